"""What would explain a program that is off its CL path: each hypothesis is tried on the whole program.

A hypothesis changes the poses that the words make: a chain computed with one of the causes of
`mathpost.detective.causes`, words of another sign or unit, the other branch of the rotary axes, another origin or
tool length; in the whole program, from the block on that is off first, or in that block alone. Or it changes the
text: a digit of a word. What brings the program back onto its path explains it.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from mathpost.detective.causes import Setup, causes
from mathpost.detective.explanation import Slip, misread
from mathpost.errors import MathpostError
from mathpost.files import NUMBER
from mathpost.kinematics import Kinematics
from mathpost.machine import MM_PER_INCH
from mathpost.path import deviation
from mathpost.path.cl import CLData
from mathpost.rotation import wrap
from mathpost.shop.controls.blocks import axis_word
from mathpost.shop.post.along import Off, along

MOST = 5  # explanations that are reported
FIRST = 2000  # blocks that a hypothesis must explain before it is tried on all
CANDIDATES = 40  # blocks of which one must be on the path, or at the first record for a shift
BEHIND, AHEAD = 3, 64  # records before and behind the place of a program where its next block may be
LEAST_GAIN = 0.01  # mm that the tip moves for a mm of the tool, below which nothing is said of its length
Poses = tuple[np.ndarray, np.ndarray]  # tips and tool axes of the blocks
SAME_ANGLE = 1e-6  # degrees, by which an axis turns that need not be named
STEP = 100.0  # mm, between the points that show in which coordinates words are
LONGEST = 20_000  # lines of a program whose words are edited and which is read anew


@dataclass(frozen=True)
class Case:
    """A program, as it was simulated, and its CL path."""

    text: str
    lines: np.ndarray  # of the blocks
    words: np.ndarray  # shape (n, 5), mm and degrees; X Y Z are tips where `tcp`
    tcp: np.ndarray
    kin: list[Kinematics]  # of each block
    tips: np.ndarray
    axes: np.ndarray
    cl: CLData
    tip: float
    axis: float
    begin: str  # word that a straight move begins with, or nothing
    read: Callable[[str], np.ndarray]  # the words of another text, as `words`
    follows: Callable[[str], bool]  # simulates another text: whether it is along the CL path

    def fits(self, tips: np.ndarray, axes: np.ndarray) -> bool:
        """Whether poses at the ends of the blocks are along the CL path."""
        if len(tips) > FIRST:
            part = along(tips[:FIRST], axes[:FIRST], self.cl, tip=self.tip, axis=self.axis)
            if part.off is not None and part.off.what != "end":
                return False
        return along(tips, axes, self.cl, tip=self.tip, axis=self.axis).off is None

    def pose(self, words: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return tips and tool axes of words for all blocks."""
        return self._by_machine(words, lambda kin, rows: np.concatenate(kin.forward(rows, degrees=True), axis=1))

    def misread(self, cause: Slip) -> tuple[np.ndarray, np.ndarray] | None:
        """Return tips and tool axes of a chain with a cause of the catalogue; None where it concerns answers."""
        setups = {kin: misread(Setup.right(kin.machine), cause) for kin in dict.fromkeys(self.kin)}
        if any((setup.order, setup.signs) != ((0, 1, 2), (1.0, 1.0, 1.0)) for setup in setups.values()):
            return None
        return self._by_machine(self.words, lambda kin, rows: setups[kin].pose(rows))

    def moved(self, name: str, factor: float) -> tuple[np.ndarray, np.ndarray]:
        """Return tips and tool axes of a chain whose pivot is so many times as far, whatever X Y Z name."""

        def pose(kin: Kinematics, rows: np.ndarray) -> np.ndarray:
            right = Setup.right(kin.machine)
            return right.moved(name, factor * right.point(name)).pose(rows)

        return self._by_machine(self.words, pose)

    def longer(self, more: float) -> np.ndarray:
        """Return the tips of all blocks with a tool that is so many mm longer."""
        setups = {kin: Setup.right(kin.machine).longer(more) for kin in dict.fromkeys(self.kin)}
        return self._by_machine(self.words, lambda kin, rows: setups[kin].pose(rows))[0]

    def _by_machine(self, words: np.ndarray, pose: Callable[[Kinematics, np.ndarray], np.ndarray]) -> Poses:
        found = np.empty((len(words), 6))
        for kin in dict.fromkeys(self.kin):
            rows = np.array([each is kin for each in self.kin])
            found[rows] = pose(kin, words[rows])
        found[self.tcp, :3] = words[self.tcp, :3]
        return found[:, :3], found[:, 3:]


def explain(case: Case, off: Off) -> tuple[str, ...]:
    """Return sentences that say what would explain a program that is off, the simplest first."""
    found: list[str] = []
    if off.what == "way":
        found += _whole_turns(case, off)
    elif off.what == "position":
        found += list(_poses(case, off))
        found += [] if found else list(_shifts(case, off))
    if not found and len(case.text) < LONGEST * 40:
        found += list(_edits(case, off, off.block))
        if not found and off.what == "position":
            found += list(_left_out(case, off))
        if not found and off.what != "way":  # before a way a wrong block may replace one that is missing
            for block in range(off.block - 1, max(off.block - 3, -1), -1):
                found += list(_edits(case, off, block))
    if not found and off.what == "position":
        found += list(_poses(case, off, alone=True))
    if not found and off.what == "way":
        found.append(_on_the_way(case, off))
    if not found and off.what == "position" and off.record == 0 and len(case.cl) > 1:
        rest = case.cl.part(1, len(case.cl))
        if along(case.tips, case.axes, rest, tip=case.tip, axis=case.axis).off is None:
            found.append("record 1 is left out")
    if off.what == "end":
        found.append(f"the program ends before record {int(np.floor(off.record)) + 2} of {len(case.cl)}")
    return tuple(dict.fromkeys(found))[:MOST]


def _whole_turns(case: Case, off: Off) -> Iterator[str]:
    names = case.kin[0].machine.joint_names[3:]
    for name, step in zip(names, case.words[off.block, 3:] - case.words[off.block - 1, 3:], strict=True):
        if abs(step) > 180:
            there = f"{wrap(step):.3f}° lead to the same place"
            yield f"{name} turns by {step:.3f}° where {there}: a whole turn too much"


def _on_the_way(case: Case, off: Off) -> str:
    """A block that is missing, where nothing else mends a way."""
    where = f"a block is missing before line {case.lines[off.block]}"
    if off.spans:
        return f"record {int(off.record) + 1} is left out: {where}"
    return f"between two blocks the axes stray from the path: {where}, or TCP is off where it should be on"


def _left_out(case: Case, off: Off) -> Iterator[str]:
    """A block at the record that is not reached, before the one that is off: later ones may count on its words."""
    block, record = off.block, int(off.record)
    if not block:
        return
    before, kin = case.words[block - 1], case.kin[block]
    tip, axis = case.cl.points[record], case.cl.axes[record]
    both = kin.inverse(tip, axis, degrees=True)
    turns = wrap(both[:, 3:] - before[3:])
    if np.isnan(both).any():
        return
    nearest = int(np.abs(turns).max(axis=1).argmin())
    words = both[nearest]
    words[3:] = before[3:] + turns[nearest]
    words[:3] = tip if case.tcp[block] else words[:3]
    names = kin.machine.joint_names
    turned = [(names[3 + n], words[3 + n]) for n in np.flatnonzero(np.abs(turns[nearest]) > SAME_ANGLE)]
    texts, at = case.text.splitlines(), int(case.lines[block]) - 1
    for moved in (names[:3], names[:2]):  # in a cycle that is on, a third word would be that of the depth
        line = _line_to(case, texts[:at], words[:3], moved, turned)
        if line and _reads_right(case, [*texts[:at], line, *texts[at:]]):
            yield f"record {record + 1} is left out: a block is missing before line {case.lines[block]}"
            return


def _line_to(
    case: Case, before: list[str], wanted: np.ndarray, names: tuple[str, ...], turned: list[tuple[str, float]]
) -> str:
    """A line behind others that leads to X Y Z of `words`, in the coordinates that hold there; "" if there is none.

    Which these are, those of a tilted plane or from another origin, is found by reading lines to four points.
    """

    def line(values: np.ndarray) -> str:
        numbers = [*zip(names, values.tolist(), strict=True), *turned]
        return case.begin + "".join(f"{axis_word(name)}{value:.6f}" for name, value in numbers)

    try:
        count = len(case.read("\n".join([*before, ""])))

        def reached(values: np.ndarray) -> np.ndarray:
            return case.read("\n".join([*before, line(values), ""]))[count, :3]

        start = reached(np.zeros(len(names)))
        columns = [(reached(STEP * unit) - start) / STEP for unit in np.eye(len(names))]
    except (MathpostError, IndexError):
        return ""
    return line(np.linalg.lstsq(np.transpose(columns), wanted - start)[0])


def _reads_right(case: Case, texts: list[str]) -> bool:
    """Whether lines can be read and are along the CL path."""
    try:
        return case.follows("\n".join(texts) + "\n")
    except MathpostError:
        return False


def _poses(case: Case, off: Off, alone: bool = False) -> Iterator[str]:
    """Hypotheses that change poses: in the first block alone that is off, or in all, or else from it on."""
    line = case.lines[off.block]
    first = off.block if off.record else 0
    here = slice(off.block, off.block + 1)
    # What is said, of which blocks, and which of them are looked at first.
    ranges = [
        ("", slice(None), slice(first, first + CANDIDATES)),
        (f" from line {line} on", slice(off.block, None), here),
    ]
    if alone:
        ranges = [(f" in line {line} alone", here, here)]
    tried, found = [(phrase, *pose) for phrase, pose in _hypotheses(case) if pose is not None], False
    for where, rows, some in ranges:
        if found:
            return
        for phrase, tips, axes in tried:
            if not _on_path(case, tips[some], axes[some], off).any():
                continue
            some_tips, some_axes = case.tips.copy(), case.axes.copy()
            some_tips[rows], some_axes[rows] = tips[rows], axes[rows]
            if case.fits(some_tips, some_axes):
                found = True
                yield phrase + where


def _on_path(case: Case, tips: np.ndarray, axes: np.ndarray, off: Off) -> np.ndarray:
    """Which of n poses are on the path about the place where a program is off it, or about its end."""
    last = len(case.cl) - 1
    first = last if off.what == "end" else max(int(off.record) - BEHIND, 0)
    after = np.minimum(np.arange(first, first + AHEAD) + 1, last)
    points, directions = case.cl.points, case.cl.axes
    on = deviation.from_segment(tips[:, None], points[after - 1], points[after]) <= case.tip
    on &= deviation.from_arc(axes[:, None], directions[after - 1], directions[after]) <= case.axis
    return np.logical_or.reduce(on, axis=1)


def _hypotheses(case: Case) -> Iterator[tuple[str, Poses | None]]:
    """Phrases, and the tips and tool axes that the words would have had to make."""
    for cause in causes(case.kin[0].machine):
        yield cause.phrase, case.misread(cause)
    words, names = case.words, case.kin[0].machine.joint_names
    for joint in case.kin[0].machine.rotary:
        for factor, said in ((0.0, "left out"), (2.0, "taken twice")):
            phrase = f"the pivot of {joint.name} is {said}, the point that X Y Z name is not moved with it"
            yield phrase, case.moved(joint.name, factor)
    for axis, name in enumerate(names[:3]):  # of the rotary axes that is one of the causes
        changed = words.copy()
        changed[:, axis] *= -1
        yield f"the words {name} have the other sign", case.pose(changed)
    inches = ((MM_PER_INCH, "X Y Z are in inches"), (1 / MM_PER_INCH, "X Y Z are mm taken for inches"))
    for factor, phrase in inches:
        yield phrase, case.pose(np.c_[words[:, :3] * factor, words[:, 3:]])
    yield "the rotary axes are those of the other branch, X Y Z are not", case.pose(_other_branch(case))
    for first, second in ((0, 1), (0, 2), (1, 2), (3, 4)):
        if second >= len(names):
            continue  # with one rotary axis
        order = list(range(len(names)))
        order[first], order[second] = second, first
        yield f"{names[first]} and {names[second]} stand in each other's place", case.pose(words[:, order])


def _other_branch(case: Case) -> np.ndarray:
    """The words with the other rotary angles for the same tool axes."""
    words = case.words.copy()
    for kin in dict.fromkeys(case.kin):
        rows = np.flatnonzero([each is kin for each in case.kin])
        both = kin.inverse(np.zeros(3), case.axes[rows], degrees=True)[..., 3:]
        away = np.abs(wrap(both - words[rows, None, 3:])).sum(axis=2)
        other = both[np.arange(len(rows)), np.nan_to_num(away, nan=-1.0).argmax(axis=1)]
        words[rows, 3:] = np.where(np.isnan(other), words[rows, 3:], other)
    return words


def _shifts(case: Case, off: Off) -> Iterator[str]:
    """Another tool length, origin of the CL data or work offset, from a block that may be at the first record.

    Where the first blocks are right it is the first record that is not reached, and a block from there on.
    """
    record = int(off.record)
    point, axis = case.cl.points[record], case.cl.axes[record]
    per_mm = case.longer(1.0) - case.tips
    begin = off.block if record else 0
    for block in range(begin, min(begin + CANDIDATES, len(case.words))):
        if np.linalg.norm(case.axes[block] - axis) > case.axis:
            continue
        missing = point - case.tips[block]
        gain = np.linalg.norm(per_mm[block])
        longer = missing @ per_mm[block] / gain**2 if gain > LEAST_GAIN else np.inf
        along_tool = gain > LEAST_GAIN and np.linalg.norm(missing - longer * per_mm[block]) < case.tip
        if along_tool and case.fits(case.tips + longer * per_mm, case.axes):
            sense = "longer" if longer > 0 else "shorter"
            yield f"the program is made for a tool that is {abs(longer):.2f} mm {sense}"
        if case.fits(case.tips + missing, case.axes):
            yield f"the origin of the CL data is moved by {_vector(-missing)} in the workpiece"
        kin, angles = case.kin[block], np.deg2rad(case.words[block, 3:])
        moved = (kin.close(point, angles) - kin.close(case.tips[block], angles))[:3]
        shifted = case.words.copy()
        shifted[~case.tcp, :3] += moved
        if not case.tcp.any() and case.fits(*case.pose(shifted)):
            yield f"the work offset is off by {_vector(moved)}: origin, or tool length"
            return


def _vector(values: np.ndarray) -> str:
    return " ".join(f"{name}{value:+z.3f}" for name, value in zip("XYZ", values, strict=True))


def _edits(case: Case, off: Off, block: int) -> Iterator[str]:
    """One digit, sign or point of a word in the line of a block."""
    texts = case.text.splitlines()
    names = case.kin[0].machine.joint_names
    word = re.compile("|".join(rf"(?<![A-Z0-9]){re.escape(axis_word(name).strip())}({NUMBER})" for name in names))
    line = int(case.lines[block])
    for match in word.finditer(texts[line - 1]):
        group = match.lastindex or 1
        start, end = match.span(group)

        def changed(other: str, start: int = start, end: int = end) -> list[str]:
            text = texts[line - 1]
            return [*texts[: line - 1], text[:start] + other + text[end:], *texts[line:]]

        others = _alike(match[group])
        value = float(match[group])
        moved = _moved(case, block, group - 1, changed(f"{value + 1:.6f}"))
        steps = np.array([float(other) for other in others]) - value
        for index in np.flatnonzero(_near(case, block, steps[:, None] * moved, off)):
            if _reads_right(case, changed(others[index])):
                name = names[group - 1]
                yield f"line {line}: {match[0]} stands where {name}{others[index]} would be right"


def _moved(case: Case, block: int, axis: int, texts: list[str]) -> np.ndarray:
    """How far the words of a block go for a step of 1 in a line: on a tilted plane or in inches not as it says."""
    try:
        found = case.read("\n".join(texts) + "\n")
    except MathpostError:
        found = case.words[:0]
    if len(found) == len(case.words):
        return found[block] - case.words[block]
    return np.eye(case.words.shape[1])[axis]


def _near(case: Case, block: int, steps: np.ndarray, off: Off) -> np.ndarray:
    """Which steps of the words, (n, 5), would move a block onto the CL path about the place where it should be.

    A step that leaves tip and tool axis within their tolerances mends nothing. Where the program ends too soon the
    place is that of the last record.
    """
    words = case.words[block] + steps
    tips, tools = case.kin[block].forward(words, degrees=True)
    tips = words[:, :3] if case.tcp[block] else tips
    moved = np.linalg.norm(tips - case.tips[block], axis=1) > case.tip
    moved |= np.linalg.norm(tools - case.axes[block], axis=1) > case.axis
    return moved & _on_path(case, tips, tools, off)


def _alike(number: str) -> list[str]:
    """Numbers that differ in one digit, the sign, the position of the point, or by two digits exchanged."""
    sign, digits = ("-", number[1:]) if number[0] == "-" else ("", number.lstrip("+"))
    plus = "+" if number[0] == "+" else ""
    found = ["-" + digits if not sign else plus + digits]
    for place, character in enumerate(digits):
        if character.isdigit():
            found += [
                sign + digits[:place] + other + digits[place + 1 :] for other in "0123456789" if other != character
            ]
        if place and digits[place - 1] != character and "." not in digits[place - 1 : place + 1]:
            found.append(sign + digits[: place - 1] + character + digits[place - 1] + digits[place + 1 :])
    if "." in digits:
        bare, point = digits.replace(".", ""), digits.index(".")
        found += [
            sign + bare[:place] + "." + bare[place:] for place in (point - 1, point + 1) if 0 <= place <= len(bare)
        ]
    found += [
        sign + digits[:place] + digits[place + 1 :] for place in range(len(digits)) if digits[place].isdigit()
    ]
    found += [
        sign + digits[:place] + other + digits[place:] for place in range(len(digits) + 1) for other in "0123456789"
    ]
    unique: dict[float, str] = {}
    for each in found:
        if re.fullmatch(NUMBER, each) and float(each) != float(number):
            unique.setdefault(float(each), each)
    return list(unique.values())
