"""Right programs for every control, and slips planted in them, as a post or a person at the control makes them.

A slip is made in the text, or by a post for a machine with another pivot. `python -m tests.post.slips 300 100`
plants so many, judges so many right programs, and prints what was found and explained.
"""

import re
import sys
from collections import Counter
from dataclasses import dataclass, replace

import numpy as np

from mathpost import machine as machines
from mathpost import post
from mathpost.controls import control
from mathpost.errors import MathpostError
from mathpost.kinematics import Kinematics
from mathpost.path import cl
from mathpost.post.verify import Verified, verify
from tests.conftest import DATA
from tests.post import test_own_words as own_words

KINDS = ("sign", "pivot", "branch", "winding", "digit", "lost", "inch")
MACHINES = ("ac_table", "bc_table", "dmu50v", "head_b_table_c", "ac_head", "nutating_head", "nutating_head_table")
EFFECT = 0.2  # mm or degrees, by which a slip changes a word at least
NAMED = {
    "sign": "turns the other way", "pivot": "pivot", "branch": "other branch|turns the other way|is off by",
    "winding": "whole turn", "digit": "would be right|alone", "lost": "left out|ends before|missing",
    "inch": "inch",
}  # fmt: skip


@dataclass(frozen=True)
class Job:
    """A path, a machine and a right program."""

    machine: object
    control: str
    tcp: bool
    path: cl.CLData
    text: str

    def judged(self, text: str | None = None) -> Verified:
        return verify(self.text if text is None else text, self.machine, self.control, cl=self.path)


def job(rng, *, tcp=None) -> Job:
    """A random job; a path that a machine cannot run is drawn anew."""
    while True:
        machine = machines.load(DATA / f"machines/{rng.choice(MACHINES)}.toml")
        kin, name = Kinematics(machine), str(rng.choice(control.names()))
        with_tcp = bool(rng.random() < 0.5) if tcp is None else tcp
        path = _path(rng, kin)
        try:
            made = post.run(path, machine, dialect=name, tcp=with_tcp)
        except MathpostError:
            continue
        return Job(machine, name, with_tcp, path, made.program)


def own_words_job(rng) -> Job:
    """A random job of arcs or holes, upright or tilted, sometimes with TCP, in the control's own words."""
    while True:
        name, dialect = str(rng.choice(own_words.MACHINES)), str(rng.choice(own_words.CONTROLS))
        angles = {letter: rng.uniform(10, 30) for letter in "ABC"} if rng.random() < 0.5 else {}
        setup, *vectors = own_words.on_machine(name, **angles)
        with_tcp = bool(rng.random() < 0.3)
        if rng.random() < 0.5:
            text, _ = own_words.arcs_file(rng, *vectors, int(rng.integers(3, 9)))
        else:
            text, _ = own_words.holes_file(rng, *vectors)
        path = cl.parse(text)
        try:
            made = post.run(path, setup, dialect=dialect, tcp=with_tcp)
        except MathpostError:
            continue
        return Job(setup, dialect, with_tcp, path, made.program)


def _path(rng, kin):
    """A curved path of some 20 records whose tool axis leans 5 to 35 degrees from the pole and goes about it."""
    count = int(rng.integers(12, 30))
    t = np.linspace(0, 1, count)
    wave = rng.normal(size=(3, 3)) * [[30], [30], [8]]
    points = sum(wave[:, n, None] * np.sin((n + 1.5) * t + rng.uniform(0, 6)) for n in range(3)).T
    pole = np.array(kin.inverse_symbolic.pole, dtype=float)
    if pole[2] < 0.5:
        pole = np.array([0, 0, 1.0])
    around = rng.uniform(0, 2 * np.pi) + rng.uniform(0.5, 1.5) * t
    lean = np.radians(rng.uniform(8, 15) + 8 * np.sin(3 * t))
    across = np.cross(pole, [1, 0, 0.3])
    across /= np.linalg.norm(across)
    other = np.cross(pole, across)
    side = np.cos(around)[:, None] * across + np.sin(around)[:, None] * other
    axes = np.cos(lean)[:, None] * pole + np.sin(lean)[:, None] * side
    return cl.from_arrays(points, axes, feed=1000.0)


def slip(rng, kind: str) -> tuple[Job, str]:
    """A job and its program with a slip of this kind that changes something."""
    while True:
        made = job(rng, tcp=False if kind == "pivot" else None)
        if kind == "branch" and made.tcp:
            continue  # with TCP the other branch is right, too
        changed = PLANTED[kind](rng, made)
        if changed is not None:
            return made, changed


def _word(names):
    letters = "|".join(re.escape(name) for name in names)
    return re.compile(rf"(?<![A-Z0-9.])({letters})(=?)([-+]?\d+\.?\d*)")


def _rows(text):
    return [n for n, line in enumerate(text.splitlines()) if _word("XYZABC").search(line) and "CONTROL" not in line]


def _edited(made, names, change, rows=None):
    """The text with the numbers of some axes changed, in some lines or all."""
    lines = made.text.splitlines()
    for n in _rows(made.text) if rows is None else rows:
        lines[n] = _word(names).sub(
            lambda found: f"{found[1]}{found[2]}{change(found[1], float(found[3])):{_sign(made)}.4f}", lines[n]
        )
    return "\n".join(lines) + "\n"


def _sign(made):
    return "+" if made.control == "heidenhain" else ""


def _sign_slip(rng, made):
    name = made.machine.rotary[rng.integers(2)].name
    changed = _edited(made, [name], lambda _, value: -value)
    sizes = [abs(float(found[3])) for found in _word([name]).finditer(made.text)]
    return changed if max(sizes, default=0) > 1 else None


def _pivot_slip(rng, made):
    which, factor = int(rng.integers(2)), float(rng.choice([0, 2]))
    rotary = list(made.machine.rotary)
    rotary[which] = replace(rotary[which], point=tuple(factor * np.array(rotary[which].point)))
    other = replace(made.machine, rotary=tuple(rotary))
    try:
        changed = post.run(made.path, other, dialect=made.control).program
    except MathpostError:
        return None
    return changed if _moved(made, changed) else None


def _moved(made, changed):
    first, second = (
        np.array([float(found[3]) for found in _word("XYZ").finditer(text)]) for text in (made.text, changed)
    )
    return len(first) != len(second) or np.abs(first - second).max() > EFFECT


def _branch_slip(rng, made):
    kin, names = Kinematics(made.machine), made.machine.joint_names[3:]
    read = made.judged()
    both = kin.inverse(read.tips, read.axes, degrees=True)[..., 3:]
    now = np.degrees(read.joints[:, 3:])
    away = np.abs((both - now[:, None] + 180) % 360 - 180).sum(axis=2).argmax(axis=1)
    other = dict(zip(read.program.lines.tolist(), both[np.arange(len(now)), away].tolist(), strict=True))
    lines = made.text.splitlines()
    for number, angles in other.items():
        values = dict(zip(names, angles, strict=True))
        line, seen = lines[number - 1], set()
        line = _word(names).sub(lambda f: seen.add(f[1]) or f"{f[1]}{f[2]}{values[f[1]]:{_sign(made)}.4f}", line)  # noqa: B023
        lines[number - 1] = line
    text = "\n".join(lines) + "\n"
    tips = np.abs(verify(text, made.machine, made.control).tips - read.tips).max()
    return text if tips > EFFECT else None


def _winding_slip(rng, made):
    rows = _rows(made.text)
    endless = [each.name for each in made.machine.rotary if not np.isfinite(each.limits).all()]
    if not endless:
        return None
    first = int(rng.integers(len(rows) // 3, len(rows)))
    text = _edited(made, [endless[0]], lambda _, value: value + 360, rows[first:])
    return text if text != made.text and "G0" not in made.text.splitlines()[rows[first]] else None


def _digit_slip(rng, made):
    lines, rows = made.text.splitlines(), _rows(made.text)
    n = int(rng.choice(rows))
    found = rng.choice(np.array(list(_word(made.machine.joint_names).finditer(lines[n])), dtype=object))
    places = [k for k, character in enumerate(found[3]) if character.isdigit()]
    place = int(rng.choice(places))
    digit = str(rng.choice([each for each in "0123456789" if each != found[3][place]]))
    number = found[3][:place] + digit + found[3][place + 1 :]
    if abs(float(number) - float(found[3])) < EFFECT:
        return None
    start, end = found.span(3)
    lines[n] = lines[n][:start] + number + lines[n][end:]
    return "\n".join(lines) + "\n"


def _lost_slip(rng, made):
    lines, rows = made.text.splitlines(), _rows(made.text)
    gone = int(rng.choice(rows))
    return "\n".join(lines[:gone] + lines[gone + 1 :]) + "\n"


def _inch_slip(rng, made):
    factor = float(rng.choice([25.4, 1 / 25.4]))
    return _edited(made, "XYZ", lambda _, value: value * factor)


PLANTED = {
    "sign": _sign_slip, "pivot": _pivot_slip, "branch": _branch_slip, "winding": _winding_slip,
    "digit": _digit_slip, "lost": _lost_slip, "inch": _inch_slip,
}  # fmt: skip


def main(planted: int, right: int) -> None:
    """Plant so many slips and judge so many right programs."""
    rng, found, explained, said, wrong = np.random.default_rng(38), Counter(), Counter(), Counter(), 0
    for n in range(planted):
        kind = KINDS[n % len(KINDS)]
        made, text = slip(rng, kind)
        try:
            judged = made.judged(text)
        except MathpostError as error:
            found[kind], explained[kind] = found[kind] + 1, explained[kind] + ("word before" in str(error))
            continue
        found[kind] += judged.status == 1
        explained[kind] += any(re.search(NAMED[kind], sentence) for sentence in judged.explained)
        said[kind] += bool(judged.explained)
        if judged.status != 1 or not any(re.search(NAMED[kind], each) for each in judged.explained):
            print(f"--- {n} {kind} {made.machine.name}, {made.control}, TCP {made.tcp}\n{judged}")
    for _ in range(right):
        made = job(rng)
        judged = made.judged()
        if judged.status:
            wrong += 1
            print(f"--- right {made.machine.name}, {made.control}, TCP {made.tcp}\n{judged}")
    for kind in KINDS:
        count = len(range(KINDS.index(kind), planted, len(KINDS)))
        print(f"{kind:8s} found {found[kind]} of {count}, named {explained[kind]}, something said {said[kind]}")
    print(f"right programs called wrong: {wrong} of {right}")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:3]))
