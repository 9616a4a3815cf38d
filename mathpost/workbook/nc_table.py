"""A table of tool tips and tool axes against NC words: where the columns stand, and what the words must be.

The rotary words are right if they make the tool axis, on either branch and whatever whole turns; X Y Z if they
bring the tip into place with the rotary words that are demanded.
"""

import re
from collections import Counter
from dataclasses import dataclass, field

import numpy as np

from mathpost import machine as machines
from mathpost.detective.misreadings import written_decimals
from mathpost.detective.rotary_axes import JointCase
from mathpost.errors import InputError
from mathpost.kinematics import Kinematics
from mathpost.workbook.formula import walk
from mathpost.workbook.graph import SAMPLES, area_named

NUMBER = r"[-+−–]?\s*(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
UNIT = r"[\s_]*[\[(（]?\s*(?:mm|deg|degrees|°|度)?\s*[\])）]?$"
TIP = re.compile(r"^(?:tip|cl|刀尖|点|p|wcs)?[\s_]*([xyz])(?:[\s_]*(?:cl|0|w|wcs|坐标))?" + UNIT, re.I)
AXIS = re.compile(r"^(?:axis|tool|刀轴)?[\s_]*(?:([ijk])|[ntv]_?([xyz])|([uvw]))" + UNIT, re.I)
WORD = re.compile(r"^(?:nc|machine|mcs|机床)?[\s_]*([a-z])(?:[\s_]*(?:nc|m|mcs|机床|轴|axis|坐标))?" + UNIT, re.I)


@dataclass
class Words:
    """One row of a table; `results` are the five words in the machine's joint order."""

    results: tuple
    point: tuple
    axis: tuple
    kinematics: Kinematics
    said: str = ""
    angles: tuple = ()
    origin: tuple = ()
    words: dict = field(default_factory=dict)
    vectors: dict = field(default_factory=dict)
    target = None
    preferred = None
    beyond: bool = False  # whether to look beyond the travel as well: ATAN of a quotient loses a quadrant
    typed: bool = False  # whether a word is a number, so that only the sheet's own numbers can be judged

    def prepare(self, values, units):
        """Compute both branches at the samples in `values`, which hold what the words are now as well."""
        tip, axis, now = (
            np.stack([np.broadcast_to(values[p], (SAMPLES,)) for p in places], axis=-1)
            for places in (self.point, self.axis, self.results)
        )
        length = np.linalg.norm(axis, axis=-1, keepdims=True)
        self.branches = self.kinematics.inverse(tip, np.where(length > 1e-9, axis, 1.0), degrees=True)
        off = np.abs((now[:, None, 3:] - self.branches[..., 3:] + 180) % 360 - 180)
        fits = (off < 1e-6).sum(axis=-1)
        self.votes = fits.sum(axis=0)
        better = int(np.argmax(self.votes)) if self.preferred is None else self.preferred
        branch = np.where(fits[:, 1 - better] > fits[:, better], 1 - better, better)
        n = np.arange(SAMPLES)
        rotary = self.branches[n, branch, 3:]
        # A rotary word that is right is so with its own whole turns.
        turns = np.where(off[n, branch] < 1e-6, np.round((now[:, 3:] - rotary) / 360), 0)
        rotary = rotary + 360 * turns
        self.radians = np.deg2rad(rotary)
        linear = self.kinematics.close(tip, self.radians)[:, :3]
        self.expected = np.concatenate([linear, rotary], axis=-1)

    def draw(self, rng):
        """Place → samples, of tool axes at random that the machine reaches in its travel, away from the pole."""
        vectors = rng.normal(size=(40 * SAMPLES, 3))
        vectors /= np.linalg.norm(vectors, axis=1, keepdims=True)
        tilt = tilting(self)
        low, high = self.kinematics.machine.limits[3 + tilt]
        angle = self.kinematics.inverse(np.zeros(3), vectors)[:, :, 3 + tilt]
        good = ((angle >= low) & (angle <= high)).any(axis=1) | self.beyond
        good &= np.isfinite(angle).all(axis=1)
        good &= (np.abs(vectors[:, 2]) > 0.05) & (np.abs(vectors[:, 2]) < 0.98)
        return dict(zip(self.axis, vectors[good][:SAMPLES].T, strict=True))

    def targets(self):
        """Place → what must stand there."""
        return dict(zip(self.results, self.expected.T, strict=True))


def rows_of(graph, machine, cells=None):
    """Return the rows of a table as `Words`.

    Parameters
    ----------
    graph : mathpost.workbook.graph.Graph
    machine : mathpost.machine.Machine, or path of a machine file
    cells : dict, optional
        Where the columns stand if there are no headings: ``{"tip": "A2:C6", "axis": "D2:F6", "joints": "G2:K6"}``.

    Raises
    ------
    InputError
        If the machine cannot be read or there is no table.
    """
    if isinstance(machine, str) or hasattr(machine, "__fspath__"):
        machine = machines.load(machine)
    kinematics, found = Kinematics(machine), []
    if cells:
        blocks = [_column_block(graph, name, cells) for name in ("tip", "axis", "joints")]
        found = [tuple(tuple(block[n]) for block in blocks) for n in range(min(map(len, blocks)))]
    else:
        for sheet in graph.sheets.values():
            found += _below_headings(graph, sheet, machine.joint_names)
    if not found:
        expected = f"headings x y z i j k {' '.join(machine.joint_names)}"
        raise InputError(str(graph.book.path), expected, "none")
    name = "NC words, each against tool tip and tool axis"
    rows = [Words(joints, tip, axis, kinematics, name) for tip, axis, joints in found]
    most = sum(p in graph.trees for row in rows for p in row.results)
    for row in rows:
        trees = [graph.trees[p] for p in row.results if p in graph.trees]
        row.beyond = any(part[:2] == ("call", "ATAN") for tree in trees for _, part in walk(tree))
        row.typed = 2 * most < 5 * len(rows)
    return rows


def judge_numbers(rows, graph, number):
    """Yield (place, cause, sentence) of the words that are wrong as numbers.

    Parameters
    ----------
    rows : list of `Words`
    graph : mathpost.workbook.graph.Graph
    number : callable
        ``number(place)``, of an input cell.
    """
    own = graph.run({})
    value = lambda p: float(own[p][0]) if p in own else number(p)  # noqa: E731
    kinematics = rows[0].kinematics
    names = kinematics.machine.joint_names
    words, tip, axis = (
        np.array([[value(p) for p in getattr(row, part)] for row in rows]) for part in ("results", "point", "axis")
    )
    half = {part: _half_digit(numbers) for part, numbers in (("linear", words[:, :3]), ("angle", words[:, 3:]))}
    half["tip"], half["axis"] = _half_digit(tip), _half_digit(axis) * (not (axis % 1 == 0).all())
    case = JointCase(kinematics, axis, words[:, 3:], half["angle"] + 1e-9, half["axis"])
    both, slack = case.both_branches(axis)
    off = (words[:, None, 3:] - both + 180) % 360 - 180
    fits = np.abs(off) <= slack
    branch = (fits.sum(axis=2) - np.nan_to_num(np.abs(off).max(axis=2), nan=999) / 1e4).argmax(axis=1)
    n = np.arange(len(rows))
    off, right, slack = off[n, branch], fits[n, branch], slack[n, branch]
    right |= case.makes_the_axis()[:, None]
    demanded = np.where(right, words[:, 3:], words[:, 3:] - off)
    linear = kinematics.close(tip, np.deg2rad(demanded))[:, :3]
    from_words = kinematics.close(tip, np.deg2rad(words[:, 3:]))[:, :3]
    reach = np.linalg.norm(from_words, axis=1, keepdims=True) + np.linalg.norm(tip, axis=1, keepdims=True)
    allowed = half["linear"] + 2 * half["tip"] + 2 * np.deg2rad(half["angle"]) * reach + 1e-6
    difference = words[:, :3] - np.where(np.abs(words[:, :3] - linear) <= allowed, linear, from_words)
    wrong = np.abs(difference) > allowed
    constant = wrong.all(axis=0) & (np.ptp(difference, axis=0) <= 4 * allowed.max()) & (len(rows) > 2)
    for r, row in enumerate(rows):
        for k in np.flatnonzero(~right[r]):
            cause = "wrong value"
            if abs(abs(off[r, k]) - 180) <= slack[r, k]:
                cause = "atan for atan2"
            elif abs(words[r, 3 + k] + demanded[r, k]) <= 2 * slack[r, k]:
                cause = "sign"
            yield (
                row.results[3 + k],
                cause,
                f"{names[3 + k]} is {words[r, 3 + k]:.6g}, the tool axis demands {demanded[r, k]:.6g}",
            )
        for k in np.flatnonzero(wrong[r]):
            cause = "offset" if constant[k] else "wrong value"
            if abs(words[r, k] + linear[r, k]) <= allowed[r, 0]:
                cause = "sign"
            yield row.results[k], cause, f"{names[k]} is {words[r, k]:.6g}, {difference[r, k]:.6g} off"


def _half_digit(numbers):
    digits = written_decimals(numbers)
    return 0.5 * 10.0**-digits if digits < 9 else 1e-9


def _column_block(graph, name, cells):
    if name not in cells:
        raise InputError("cells", "tip, axis and joints", ", ".join(cells))
    area = area_named(graph, name, cells[name])
    columns = {"tip": 3, "axis": 3, "joints": 5}[name]
    if area.shape[1] != columns:
        raise InputError(f"cells, {name!r}", f"{columns} columns", repr(cells[name]))
    return [area.places[n : n + columns] for n in range(0, len(area.places), columns)]


def _below_headings(graph, sheet, names):
    """The rows below a row of headings, down to the first empty one."""
    rows = {}
    for place, cell in graph.cells.items():
        if place[0] == sheet and isinstance(cell.value, str) and not cell.formula:
            rows.setdefault(place[1], {})[place[2]] = cell.value.strip()
    for row, texts in sorted(rows.items()):
        columns = _columns(texts, names)
        if columns is None:
            continue
        below, found = row + 1, []
        last = max(place[1] for place in graph.cells)
        while below <= last:
            places = [(sheet, below, column) for column in columns]
            filled = [p for p in places if p in graph.trees or graph.value(p) is not None]
            if len(filled) >= 8:
                found.append((tuple(places[:3]), tuple(places[3:6]), tuple(places[6:])))
            elif found:
                break
            below += 1
        if found:
            return found
    return []


def _columns(texts, names):
    """The columns of tip, axis and joints in a row of headings, or None."""
    axis, tips, words = {}, {}, {}
    for column, text in sorted(texts.items()):
        if match := AXIS.match(text):
            letter = next(g for g in match.groups() if g).lower()
            axis.setdefault(
                {"u": "i", "v": "j", "w": "k", "x": "i", "y": "j", "z": "k"}.get(letter, letter), column
            )
        if match := TIP.match(text):
            tips.setdefault(match[1].lower(), []).append(column)
        if match := WORD.match(text):
            words.setdefault(match[1].upper(), []).append(column)
    if len(axis) < 3 or any(len(tips.get(n, ())) < 1 for n in "xyz") or any(n not in words for n in names[3:]):
        return None
    # The tip stands beside the tool axis; X Y Z of the machine are the others of that name.
    tip = [min(tips[n], key=lambda c: abs(c - axis["i"])) for n in "xyz"]
    linear = [[c for c in words.get(n, ()) if c not in tip] for n in names[:3]]
    if not all(linear):
        return None
    rotary = [[c for c in words[n] if c not in tip][-1:] for n in names[3:]]
    return [*tip, *(axis[n] for n in "ijk"), *(c[0] for c in linear), *(c[0] for c in rotary)]


def looked_at(rows, own):
    """What deserves a look in the words as they stand: travel, flips between rows, an offset of all rows.

    Parameters
    ----------
    rows : list of `Words`
    own : ndarray, shape (n, 5)
        The words of the rows at the sheet's own numbers.

    Yields
    ------
    str
    """
    machine = rows[0].kinematics.machine
    low, high = np.where(np.arange(5) > 2, np.rad2deg(machine.limits.T), machine.limits.T)
    for name, column, least, most in zip(machine.joint_names, own.T, low, high, strict=True):
        beyond = [
            r.results[0][1]
            for r, value in zip(rows, column, strict=True)
            if value < least - 1e-6 or value > most + 1e-6
        ]
        if beyond:
            text = f"rows {', '.join(map(str, beyond[:6]))}" if len(beyond) > 1 else f"row {beyond[0]}"
            yield f"{name} beyond its travel {least:g} … {most:g} in {text}"
    steps = np.abs(np.diff(own[:, 3:], axis=0))
    for n in np.flatnonzero((steps > 60).any(axis=1)):
        jump = " and ".join(
            f"{name} by {step:.4g}"
            for name, step in zip(machine.joint_names[3:], steps[n], strict=True)
            if step > 60
        )
        first, second = (row.results[0][1] for row in rows[n : n + 2])
        yield f"between rows {first} and {second} jumps {jump} degrees: another branch?"
    negative = Counter(np.sign(own[:, 3:][:, [tilting(rows[0])]].ravel()))
    if len([sign for sign in negative if sign]) > 1:
        yield "the tilting axis changes its sign between rows: another branch?"


def tilting(row):
    """The rotary word whose sign tells the branch: the joint nearer to the tool."""
    inner = row.kinematics.inverse_symbolic.inner
    return [str(s) for s in row.kinematics.symbols[3:]].index(str(inner))
