"""Lines of the user's in a program: head, foot and tool change of the machine file. None of them moves unproved.

Such a line is taken as it stands, where the slides may be anywhere above the part. So it may move the slides to the
safe position of the machine file and further away, in machine coordinates, or to the control's reference point;
anything else that moves is refused.
"""

import re

import numpy as np

from mathpost.errors import NUMBER, InputError
from mathpost.machine import ENDLESS, LETTERS, PROGRAM, Machine
from mathpost.shop.controls.control import Control

EXACT = 1e-6  # mm
SAFE = "safe = { Z = … } in [linear] of the machine file"


def refuse_unproved(machine: Machine, control: Control) -> None:
    """Raise `InputError` for a line of the machine file that moves the tool to where nothing proves it safe."""
    for field, key in PROGRAM.items():
        above = False  # whether Z is at the safe position, so that the others may move
        for line in getattr(machine, field):
            above = _checked(line, machine, control, f"{machine.name}, [program] {key}, {line!r}", above)


def _checked(line: str, machine: Machine, control: Control, where: str, above: bool) -> bool:
    """Check one line; return whether Z is at the safe position behind it."""
    meanings, rest = _meanings(control.comments.sub(" ", line).upper(), control)
    named = dict(re.findall(rf"(?<![A-Z_{{\"])([XYZABC])=?({NUMBER})(?![\w.=])", rest))
    if not named or "home" in meanings:
        return above or ("home" in meanings and ("Z" in named or not named))
    if "machine coordinates" not in meanings:
        raise InputError(
            where, f"moves in machine coordinates, to the {SAFE}", " ".join(map("".join, named.items()))
        )
    for letter, text in sorted(named.items(), key=lambda item: item[0] != "Z"):  # Z first
        value = float(text)
        if letter == "Z":
            _check_safe(value, machine, where)
            above = True
        elif not above:
            raise InputError(where, "Z at the safe position before other axes move", f"{letter}{text}")
        low, high = machine.linear[LETTERS.index(letter)].limits if letter in LETTERS else ENDLESS
        if not low - EXACT <= value <= high + EXACT:
            raise InputError(where, f"{letter} within its travel, {low:g} to {high:g}", text)
    return above


def _check_safe(value: float, machine: Machine, where: str) -> None:
    if machine.safe is None:
        raise InputError(where, SAFE, "none")
    safe = machine.safe[2]
    low, high = machine.linear[2].limits
    end = low if np.isfinite(low) and safe - low < high - safe else high  # the way away from the part
    if not min(safe, end) - EXACT <= value <= max(safe, end) + EXACT:
        raise InputError(where, f"Z {safe:g}, the safe position, or further away from the part", f"{value:g}")


def _meanings(line: str, control: Control) -> tuple[set[str], str]:
    """What the words of a line mean, and its text without those that are no axis words."""
    found: set[str] = set()
    rest, at = [], 0
    while at < len(line):
        match = control.words.match(line, at)
        if match and match[0]:
            found.add(control.words.meaning(match)[0])
            at = match.end()
        else:
            rest.append(line[at])
            at += 1
    return found, "".join(rest)
