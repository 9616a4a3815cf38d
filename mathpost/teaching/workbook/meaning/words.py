"""A table of tool tips and tool axes against NC words: where the columns are, and what the words must be.

The rotary words are right if they make the tool axis, on either branch and in any winding, unless only the other
branch is inside travel. X Y Z, if there are any, are right if they bring the tip into place with the rotary words
that are demanded.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from mathpost import machine_file as machines
from mathpost.errors import InputError
from mathpost.kinematics import Kinematics
from mathpost.rotation import unit, wrap
from mathpost.teaching.workbook.meaning.calculation import Calculation, look, nearest
from mathpost.teaching.workbook.meaning.machine_table import CLOSE, Table, find_tables, is_whole
from mathpost.teaching.workbook.sheet.place import Line
from mathpost.teaching.workbook.sheet.samples import SAMPLES
from mathpost.teaching.workbook.sheet.tree import heads

if TYPE_CHECKING:
    from mathpost.machine import Machine
    from mathpost.teaching.workbook.meaning.recognise import Recognised
    from mathpost.teaching.workbook.sheet.graph import Graph
    from mathpost.teaching.workbook.sheet.place import Place
    from mathpost.teaching.workbook.sheet.samples import Values

COLUMNS = {"tip": 3, "axis": 3, "joints": 5}
UNIT_LENGTH = 2e-3  # as near to 1 as the length of a unit vector of three decimals
NEAR_THE_POLE = 0.02  # the sine of a tilt
ROUNDED = 0.01  # mm, degrees: less may come from the rounding of what a word is calculated from
TOLD = 0.05  # of a unit vector: so much tells a length


@dataclass(eq=False)
class Words(Calculation):
    """One row of a table; `results` are the five words in the machine's joint order, `point` is the tip."""

    kinematics: Kinematics = field(kw_only=True)
    units: tuple[float, ...] = (1.0, 1.0)  # degrees of 1 of a rotary word
    table: int = 0  # of a workbook with several
    preferred: int | None = None
    beyond: bool = False  # whether to look beyond the travel as well: ATAN of a quotient loses a quadrant

    def unround(self, inputs: Values) -> None:
        """Normalise the tool axis of the sheet, if it is one but for its last digits."""
        length = np.linalg.norm([inputs[p][0] for p in self.axis])
        is_unit = abs(length - 1) < UNIT_LENGTH
        for place in self.axis:
            inputs[place][0] /= length if is_unit else 1.0
            inputs[place][1:] *= 1.0 if is_unit else length

    def prepare(self, values: Values, units: dict[Place, float]) -> None:
        """Compute the words at the samples in `values`, on the branch that those that are there now are on."""
        tip, axis, now = (look(values, places) for places in (self.point, self.axis, self.results))
        axis = _not_zero(axis)
        both = self.kinematics.inverse(tip, axis, degrees=True)[..., 3:]
        own = now[:, -2:] * self.units
        rotary, self.votes = nearest(own, both, preferred=self.preferred)
        made = self.kinematics.forward(np.nan_to_num(np.hstack([0 * tip, own])), degrees=True)[1]
        off = np.abs(made - axis / np.linalg.norm(axis, axis=-1, keepdims=True)).max(axis=-1)
        rotary = np.where((np.isfinite(own).all(axis=-1) & (off < 1e-10))[:, None], own, rotary)  # any, at the pole
        self.radians = np.deg2rad(rotary)
        linear = self.kinematics.close(tip, self.radians)[:, :3]
        self.should_be(self.results, np.hstack([linear, rotary / self.units]).T)
        turns = [self.radians, rotary, np.cos(self.radians), np.sin(self.radians)]
        length = np.linalg.norm(axis, axis=-1, keepdims=True)
        beside = np.hstack([*turns, linear, tip, axis / length, length, np.zeros((SAMPLES, 1))])
        self.known = {1: [entry[None] for entry in beside.T]}

    @property
    def periods(self) -> dict[Place, float]:
        """Place of a rotary word → a turn."""
        return {p: 360 / degrees for p, degrees in zip(self.results[-2:], self.units, strict=True)}

    def is_wrong(self, now: Callable[[Place], np.ndarray]) -> bool:
        """Whether the words are wrong by more than rounding; `now(place)` gives the contents of a cell."""
        for place, target in self.targets.items():
            off = now(place)[0] - target[0]
            off = wrap(off, self.periods[place]) if place in self.periods else off
            if np.isfinite(target[0]) and not abs(off) <= ROUNDED:
                return True
        return False

    def draw(self, rng: np.random.Generator, units: dict[Place, float]) -> Values:
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
        drawn = vectors[good]
        drawn[1, :2] *= NEAR_THE_POLE / np.linalg.norm(drawn[1, :2])  # where a formula may make an exception
        drawn[1, 2] = np.sqrt(1 - NEAR_THE_POLE**2)
        found = dict(zip(self.axis, drawn.T, strict=True))
        return found | {p: rng.uniform(-60, 60, SAMPLES) for p in self.point}

    @property
    def tilting(self) -> int:
        """The rotary word whose sign tells the branch: 0 or 1, the joint nearer to the tool."""
        tool_side = self.kinematics.inverse_symbolic.tool_side
        return [str(s) for s in self.kinematics.symbols[3:]].index(str(tool_side))


def rows_of(
    found: Recognised, machine: Machine | str | Path, cells: dict[str, str] | None = None
) -> tuple[list[Words], list[str]]:
    """Return the rows of the tables as `Words`, and the ranges that look like a table and are not understood.

    `cells` says where the columns are, for example ``{"tip": "A2:C6", "axis": "D2:F6", "joints": "G2:K6"}``.
    Raise `InputError` if the machine has one rotary axis.
    """
    graph = found.graph
    kinematics = Kinematics(machines.load(machine) if isinstance(machine, str | Path) else machine)
    if len(kinematics.machine.rotary) < 2:
        expected = "a machine with two rotary axes: tables are recognised by both angles of a tool axis"
        raise InputError("machine", expected, f"{kinematics.machine.name}, with one")
    left: list[str] = []
    if cells:
        blocks = [_column_block(graph, name, cells) for name in COLUMNS]
        named = [*zip(*blocks, strict=False)]
        tables = [Table([row for row in named if is_whole(graph, chain(*row))])]
        left = [graph.range(tuple(chain(*row))) for row in named if row not in tables[0].rows]
    else:
        tables, left = find_tables(graph, kinematics)
    rows = []
    for n, table in enumerate(tables):
        said = f"NC words, each against tool tip and tool axis: {table.said(graph)}"
        typed = [p not in graph.trees for *_, words in table.rows for p in words]
        is_typed = 2 * sum(typed) > len(typed)
        for tip, axis, words in table.rows:
            row = Words(words, (), tip, (), axis, said, kinematics=kinematics, units=table.units, table=n)
            row.beyond = any("ATAN" in heads(graph.trees[p]) for p in words if p in graph.trees)
            row.typed, said = is_typed, ""
            rows.append(row)
        for column in zip(*(words for *_, words in table.rows), strict=True):
            graph.take_unrounded(column)
    names = " ".join(kinematics.machine.joint_names)
    none = f"no table with the headings x y z i j k {names}: say where it is, --cells tip=…,axis=…,joints=…"
    return rows, [*(f"{area}: numbers that are no row of a table" for area in left), *([] if rows else [none])]


def _column_block(graph: Graph, name: str, cells: Mapping[str, str]) -> list[Line]:
    if name not in cells:
        raise InputError("cells", "tip, axis and joints", ", ".join(cells))
    area = graph.named(name, cells[name])
    if area.shape[1] != COLUMNS[name]:
        raise InputError(f"cells, {name!r}", f"{COLUMNS[name]} columns", repr(cells[name]))
    return list(zip(*[iter(area.places)] * COLUMNS[name], strict=True))


def names_another_point(rows: list[Words], now: Callable[[Place], np.ndarray]) -> str:
    """Return a sentence if X Y Z of a table name another point than the machine file means, or nothing.

    Most words in two columns are then off by one length along the turned tool axis, less the same at rotary zero if
    the machine file means a point that does not turn. `now(place)` is what is in a cell.
    """
    kinematics = rows[0].kinematics
    tip, axis, words = (
        np.hstack([[now(p) for p in getattr(row, part)] for row in rows]).T for part in ("point", "axis", "results")
    )
    radians, at_zero = np.vstack([row.radians for row in rows]), unit(np.array(kinematics.machine.tool_axis, float))
    at_tip, up = (kinematics.close(tip + step, radians)[:, :3] for step in (0, unit(_not_zero(axis))))
    off, up = words[:, :3] - at_tip, up - at_tip
    told = (np.abs(up - at_zero) > TOLD) & np.isfinite(off)
    for back in (0 * at_zero, at_zero) if told.any() else ():
        length = np.nanmedian(off[told] / (up - back)[told])
        fits = told & (np.abs(off - length * (up - back)) < CLOSE)
        if np.sum(2 * fits.sum(axis=0) > told.sum(axis=0)) > 1 and abs(length) > CLOSE:
            where = f"{abs(length):.6g} mm {'up' if length > 0 else 'down'} the tool axis"
            return f"X Y Z name a point {where} from the one that the machine file means"
    return ""


def on_the_wrong_branch(
    rows: list[Words], values: Mapping[Place, float | None]
) -> Iterator[tuple[Place, str, str]]:
    """Yield (place, cause, sentence) of the rotary words beyond travel while the other branch is inside."""
    for row in rows:
        joints = row.kinematics.machine.rotary
        numbers = np.array([values.get(p) for p in (*row.axis, *row.results[-2:])], dtype=float)
        if not (np.isfinite(numbers).all() and numbers[:3].any()):
            continue
        own, both = numbers[3:] * row.units, row.kinematics.inverse(np.zeros(3), numbers[:3], degrees=True)[:, 3:]
        off = np.abs(wrap(own - both)).max(axis=1)
        other = both[np.argmax(off)]
        out, other_out = (
            [all(np.isnan(j.nearest_turn(a + s)) for s in slack) for j, a in zip(joints, angles, strict=True)]
            for angles, slack in ((own, (-ROUNDED, ROUNDED)), (other, (0,)))
        )
        if off.min() < 1 and any(out) and not any(other_out):
            k = out.index(True)
            text = f"{joints[k].name} is {own[k]:.6g}, beyond its travel; {other[k]:.6g}, the other branch, is not"
            yield row.results[k - 2], "branch", text


def _not_zero(axis: np.ndarray) -> np.ndarray:
    """Tool axes, with any in place of none."""
    return np.where(np.linalg.norm(axis, axis=-1, keepdims=True) > 1e-9, axis, 1.0)
