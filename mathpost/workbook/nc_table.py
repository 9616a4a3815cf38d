"""A table of tool tips and tool axes against NC words: where the columns stand, and what the words must be.

The rotary words are right if they make the tool axis, on either branch and whatever whole turns; X Y Z if they
bring the tip into place with the rotary words that are demanded.
"""

import re
from dataclasses import dataclass
from itertools import dropwhile, takewhile

import numpy as np

from mathpost import machine as machines
from mathpost.detective.misreadings import written_decimals
from mathpost.detective.rotary_axes import JointCase
from mathpost.errors import InputError
from mathpost.kinematics import Kinematics
from mathpost.workbook.calculation import Calculation, look, nearest
from mathpost.workbook.formula import heads
from mathpost.workbook.graph import SAMPLES

UNIT = r"[\s_]*[\[(（]?\s*(?:mm|deg|degrees|°|度)?\s*[\])）]?$"
TIP = re.compile(r"^(?:tip|cl|刀尖|点|p|wcs)?[\s_]*([xyz])(?:[\s_]*(?:cl|0|w|wcs|坐标))?" + UNIT, re.I)
AXIS = re.compile(r"^(?:axis|tool|刀轴)?[\s_]*(?:([ijk])|[ntv]_?([xyz])|([uvw]))" + UNIT, re.I)
WORD = re.compile(r"^(?:nc|machine|mcs|机床)?[\s_]*([a-z])(?:[\s_]*(?:nc|m|mcs|机床|轴|axis|坐标))?" + UNIT, re.I)
COLUMNS = {"tip": 3, "axis": 3, "joints": 5}
FLIP = 60.0  # degrees between two rows that are worth a look


@dataclass(eq=False)
class Words(Calculation):
    """One row of a table; `results` are the five words in the machine's joint order, `point` is the tip."""

    kinematics: Kinematics = None
    preferred: int | None = None
    complete: bool = True  # whether there is a number in each cell
    beyond: bool = False  # whether to look beyond the travel as well: ATAN of a quotient loses a quadrant

    def prepare(self, values, units):
        """Compute the words at the samples in `values`, on the branch that those that are there now are on."""
        tip, axis, now = (look(values, places) for places in (self.point, self.axis, self.results))
        axis = np.where(np.linalg.norm(axis, axis=-1, keepdims=True) > 1e-9, axis, 1.0)
        both = self.kinematics.inverse(tip, axis, degrees=True)[..., 3:]
        rotary, self.votes = nearest(now[:, 3:], both, preferred=self.preferred)
        self.radians = np.deg2rad(rotary)
        linear = self.kinematics.close(tip, self.radians)[:, :3]
        self.should_be(self.results, np.concatenate([linear, rotary], axis=-1).T)

    def draw(self, rng, units):
        """Place → samples, of tool axes at random, in travel, away from the pole, all around the other axis."""
        vectors = rng.normal(size=(40 * SAMPLES, 3))
        vectors /= np.linalg.norm(vectors, axis=1, keepdims=True)
        low, high = self.kinematics.machine.limits[3 + self.tilting]
        joints = self.kinematics.inverse(np.zeros(3), vectors)
        angle, turn = joints[:, :, 3 + self.tilting], joints[:, 0, 4 - self.tilting]
        good = ((angle >= low) & (angle <= high)).any(axis=1) | self.beyond
        good &= np.isfinite(angle).all(axis=1)
        good = np.flatnonzero(good & (np.abs(vectors[:, 2]) > 0.05) & (np.abs(vectors[:, 2]) < 0.98))
        good = good[np.argsort(turn[good])][np.linspace(0, len(good) - 1, SAMPLES).astype(int)]
        found = dict(zip(self.axis, vectors[good].T, strict=True))
        return found | {p: rng.uniform(-60, 60, SAMPLES) for p in self.point}

    @property
    def tilting(self):
        """The rotary word whose sign tells the branch: 0 or 1, the joint nearer to the tool."""
        inner = self.kinematics.inverse_symbolic.inner
        return [str(s) for s in self.kinematics.symbols[3:]].index(str(inner))


def rows_of(graph, machine, cells=None):
    """Return the rows of a table as `Words`; `cells` says where the columns stand if there are no headings.

    For example ``{"tip": "A2:C6", "axis": "D2:F6", "joints": "G2:K6"}``. Raise `InputError` if there is no table.
    """
    machine = machines.load(machine) if isinstance(machine, str) or hasattr(machine, "__fspath__") else machine
    kinematics, names = Kinematics(machine), machine.joint_names
    if cells:
        blocks = [_column_block(graph, name, cells) for name in COLUMNS]
        found = list(zip(*blocks, strict=False))
    else:
        found = [row for sheet in graph.numbers for row in _below_headings(graph, sheet, names)]
    if not found:
        raise InputError(str(graph.book.path), f"headings x y z i j k {' '.join(names)}", "none")
    said = "NC words, each against tool tip and tool axis"
    rows = [Words(joints, (), tip, (), axis, said, kinematics=kinematics) for tip, axis, joints in found]
    formulas = sum(p in graph.trees for row in rows for p in row.results)
    for row in rows:
        row.beyond = any("ATAN" in heads(graph.trees[p]) for p in row.results if p in graph.trees)
        row.typed = 2 * formulas < 5 * len(rows)
    return rows


def _column_block(graph, name, cells):
    if name not in cells:
        raise InputError("cells", "tip, axis and joints", ", ".join(cells))
    area = graph.named(name, cells[name])
    if area.shape[1] != COLUMNS[name]:
        raise InputError(f"cells, {name!r}", f"{COLUMNS[name]} columns", repr(cells[name]))
    return list(zip(*[iter(area.places)] * COLUMNS[name], strict=True))


def _below_headings(graph, sheet, names):
    """The rows below each row of headings, down to the first empty one."""
    texts, found = {}, []
    for place, cell in graph.cells.items():
        if place[0] == sheet and isinstance(cell.value, str) and not cell.formula:
            texts.setdefault(place[1], {})[place[2]] = cell.value.strip()
    last = max(place[1] for place in graph.cells)

    def full(places):
        return sum(p in graph.trees or graph.value(p) is not None for p in places) >= 8

    for row, headings in sorted(texts.items()):
        if columns := _columns(headings, names):
            rows = [tuple((sheet, below, column) for column in columns) for below in range(row + 1, last + 1)]
            rows = dropwhile(lambda places: not full(places), rows)
            found += [(places[:3], places[3:6], places[6:]) for places in takewhile(full, rows)]
    return found


def _columns(texts, names):
    """The columns of tip, axis and joints in a row of headings, or None."""
    axis, tips, words = {}, {}, {}
    for column, text in sorted(texts.items()):
        if match := AXIS.match(text):
            letter = next(g for g in match.groups() if g).lower()
            axis.setdefault(dict(zip("uvwxyz", "ijkijk", strict=True)).get(letter, letter), column)
        for pattern, found in ((TIP, tips), (WORD, words)):
            if match := pattern.match(text):
                found.setdefault(match[1].upper(), []).append(column)
    if len(axis) < 3 or not tips.keys() >= set("XYZ") or any(n not in words for n in names[3:]):
        return None
    # The tip stands beside the tool axis; X Y Z of the machine are the others of that name.
    tip = [min(tips[n], key=lambda c: abs(c - axis["i"])) for n in "XYZ"]
    free = {n: [c for c in words.get(n, ()) if c not in tip] for n in names}
    if not all(free.values()):
        return None
    return [*tip, *(axis[n] for n in "ijk"), *(free[n][0] for n in names[:3]), *(free[n][-1] for n in names[3:])]


# Words that are numbers.


def judge_numbers(rows, values):
    """Yield (place, cause, sentence) of the words that are wrong as numbers, place → number, to their digits."""
    kinematics = rows[0].kinematics
    for row in rows:
        lacking = [p for p in (*row.given, *row.results) if values.get(p) is None]
        yield from ((p, "wrong value", "a number belongs here") for p in lacking)
        row.complete = not lacking
    rows = [row for row in rows if row.complete]
    if not rows:
        return
    words, tip, axis = (
        np.array([[values[p] for p in getattr(row, part)] for row in rows]) for part in ("results", "point", "axis")
    )
    half = _half_digit(words[:, :3]) + 2 * _half_digit(tip)
    half_angle = _half_digit(words[:, 3:])
    half_axis = 0.0 if (axis % 1 == 0).all() else _half_digit(axis)
    case = JointCase(kinematics, axis, words[:, 3:], half_angle + 1e-9, half_axis)
    both, spread = case.both_branches(axis)
    slack = spread.max(axis=1) + case.half_digit
    demanded, _ = nearest(words[:, 3:], both, slack=slack[:, None])
    off = (words[:, 3:] - demanded + 180) % 360 - 180
    right = (np.abs(off) <= slack) | case.makes_the_axis()[:, None]
    demanded = words[:, 3:] - np.where(right, 0, off)
    linear, from_words = (kinematics.close(tip, np.deg2rad(angles))[:, :3] for angles in (demanded, words[:, 3:]))
    reach = np.linalg.norm(from_words, axis=1, keepdims=True) + np.linalg.norm(tip, axis=1, keepdims=True)
    allowed = half + 2 * np.deg2rad(half_angle) * reach + 1e-6
    difference = words[:, :3] - np.where(np.abs(words[:, :3] - linear) <= allowed, linear, from_words)
    wrong = np.abs(difference) > allowed
    constant = wrong.all(axis=0) & (np.ptp(difference, axis=0) <= 4 * allowed.max()) & (len(rows) > 2)
    for r, row in enumerate(rows):
        for k in (3, 4, 0, 1, 2):  # X Y Z follow from the rotary words
            name, word, cause = kinematics.machine.joint_names[k], words[r, k], "wrong value"
            if k < 3 and wrong[r, k]:
                cause = "sign" if abs(word + linear[r, k]) <= allowed[r, 0] else "offset" if constant[k] else cause
                yield row.results[k], cause, f"{name} is {word:.6g}, {difference[r, k]:.6g} off"
            if k > 2 and not right[r, k - 3]:
                least, should = slack[r, k - 3], demanded[r, k - 3]
                cause = "sign" if abs(word + should) <= 2 * least else cause
                cause = "atan for atan2" if abs(abs(off[r, k - 3]) - 180) <= least else cause
                yield row.results[k], cause, f"{name} is {word:.6g}, the tool axis demands {should:.6g}"


def _half_digit(numbers):
    digits = written_decimals(numbers)
    return 0.5 * 10.0**-digits if digits < 9 else 1e-9


def looked_at(rows, values):
    """Yield what deserves a look in the words as they stand, place → number: travel, flips between rows."""
    machine = rows[0].kinematics.machine
    own = np.array([[values.get(p) for p in row.results] for row in rows], dtype=float)
    low, high = np.where(np.arange(5) > 2, np.rad2deg(machine.limits.T), machine.limits.T)
    lines = [row.results[0][1] for row in rows]
    for k, name in enumerate(machine.joint_names):
        outside = (own[:, k] < low[k] - 1e-6) | (own[:, k] > high[k] + 1e-6)
        beyond = [row for row, out in zip(lines, outside, strict=True) if out]
        if beyond:
            text = ", ".join(map(str, beyond[:6]))
            yield f"{name} beyond its travel {low[k]:g} … {high[k]:g} in row{'s' * (len(beyond) > 1)} {text}"
    steps = np.abs(np.diff(own[:, 3:], axis=0))
    for n in np.flatnonzero((steps > FLIP).any(axis=1)):
        jumps = zip(machine.joint_names[3:], steps[n], strict=True)
        jump = " and ".join(f"{name} by {step:.4g}" for name, step in jumps if step > FLIP)
        yield f"between rows {lines[n]} and {lines[n + 1]} jumps {jump} degrees: another branch?"
    tilts = own[:, 3 + rows[0].tilting]
    if (tilts > 0).any() and (tilts < 0).any():
        yield "the tilting axis changes its sign between rows: another branch?"
