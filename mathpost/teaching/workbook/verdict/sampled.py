"""A recognised workbook at random inputs, of which the first are its own, and with right values put in."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from mathpost.errors import InputError
from mathpost.teaching.workbook.meaning.calculation import LARGEST_RADIANS, Calculation, Turn
from mathpost.teaching.workbook.meaning.label import IN_RADIANS
from mathpost.teaching.workbook.sheet.evaluate import COMPARISONS
from mathpost.teaching.workbook.sheet.file import EMPTY
from mathpost.teaching.workbook.sheet.place import offset
from mathpost.teaching.workbook.sheet.samples import SAMPLES, at_samples, same
from mathpost.teaching.workbook.sheet.tree import heads, parts_of

if TYPE_CHECKING:
    from mathpost.teaching.workbook.meaning.recognise import Recognised
    from mathpost.teaching.workbook.sheet.formula import Tree
    from mathpost.teaching.workbook.sheet.graph import Graph
    from mathpost.teaching.workbook.sheet.place import Line, Place
    from mathpost.teaching.workbook.sheet.samples import Values

MOST = 1e5  # mm: no more is a limit
TWO_TURNS = np.array([720, 4 * np.pi, 800])  # in degrees, radians, gon; half angles turn half as fast
NAMED_UNITS = {"rad": 1.0, "gon": np.pi / 200, "deg": np.pi / 180, "°": np.pi / 180, "grad": np.pi / 180}


class Sampled:
    """The values of all cells, for samples of the inputs of the calculations that are `live`.

    `units` has the radians of 1 of an angle, `fixed` what was
    put in where.
    """

    def __init__(self, graph: Graph, found: Recognised) -> None:
        self.graph, self.found = graph, found
        self.inputs: Values = {}
        self.units: dict[Place, float] = {}
        self.fixed: Values = {}
        self.live = [c for c in found.calculations if isinstance(c, Turn)]
        base = graph.run({})
        for angles in dict.fromkeys(c.angles for c in (*self.live, *found.steps)):
            self._set_units(angles, base)
        spare = (
            [] if found.task.machine else [Calculation((), found.sorted(found.angles), found.sorted(found.lengths))]
        )
        rng = np.random.default_rng(20)
        wide = self._wide()
        for calculation in (*spare, *self.live):
            drawn = calculation.draw(rng, self.units)
            drawn |= {p: wide * drawn[p] for p in found.lengths.intersection(drawn) - {*calculation.axis}}
            self.inputs.update({p: drawn[p] for p in drawn if p in found.typed or p not in graph.trees})
        for place, numbers in self.inputs.items():
            if self.graph.own.get(place) is None:
                where = f"{self.graph.book.path}, {self.graph.address(place)}"
                raise InputError(where, "a number", repr(self.graph.cells.get(place, EMPTY).value))
            numbers[0] = self.graph.own[place]
        self.values = self.run_with()

    def _wide(self) -> float:
        """How much longer lengths must be for some to be beyond the limits that formulas set, as IF(B8>100,…)."""
        limiting = [part for _, part in self.graph.parts if part[0] in {*COMPARISONS, "MIN", "MAX"}]
        limits = [abs(inner[1]) for part in limiting for inner in parts_of(part) if inner[0] == "number"]
        return max([1.0, *(limit / 20 for limit in limits if limit < MOST)])

    def _set_units(self, places: Line, base: Values) -> None:
        """Degrees, radians or gon: whole turns of which unit leave more sines and cosines as they are.

        Angles of one calculation are in one unit, but for formulas such as =RADIANS(20).
        """
        unit, agreed = self._unit(places, base)
        self.units.update(dict.fromkeys(places, unit))
        for place in () if agreed else places:
            own, agreed = self._unit((place,), base)
            said = self.graph.cells.get(offset(place, 0, 1), EMPTY).value  # "gon", "rad" beside it
            said = NAMED_UNITS.get(str(said).strip().lower())
            said = 1.0 if re.search(IN_RADIANS, self.found.label(place), re.I) else said
            is_own = agreed and (own == said or (own == 1.0 and place in self.graph.trees))
            self.units.update({place: own} if is_own else {})

    def _unit(self, places: Line, base: Values) -> tuple[float, bool]:
        """The unit in radians, and whether all sines and cosines that use the places say so."""
        own, votes, every = {p: np.array([self.graph.number(p) + 0.3]) for p in places}, np.zeros(3), 0
        still = self.graph.run(own, base, self.graph.downstream(places))
        for place in places:
            moved = self.graph.downstream([place])
            after = [p for p in moved if heads(self.graph.tree(p)) & {"SIN", "COS"}]
            every += len(after)
            turned = self.graph.run({place: own[place] + TWO_TURNS}, still, moved)
            votes += sum(np.abs(turned[p] - still[p]) < 1e-9 * (1 + np.abs(still[p])) for p in after)
        beyond = any(abs(number) > LARGEST_RADIANS for number in own.values())
        unit = np.pi / 200 if votes[2] > max(votes[:2]) else np.pi / 180 if votes[0] > votes[1] or beyond else 1.0
        return unit, max(votes) == every

    def now(self, place: Place) -> np.ndarray:
        """What is in a cell at the samples."""
        if place in self.values:
            return at_samples(self.values[place])
        value = self.graph.value(place)
        return np.full(SAMPLES, np.nan if value is None else value)

    def block(self, places: Sequence[Place], option: Mapping[Place, np.ndarray] | None = None) -> np.ndarray:
        """What is in some cells, or what `option` puts there, shape (cells, samples)."""
        put = option or {}
        return np.array([put[p] if p in put else self.now(p) for p in places])

    def bad(self, targets: Values) -> list[Place]:
        """The targets that are missed now."""
        return [place for place, target in targets.items() if not self.met({place: target})]

    def met(self, targets: Values, values: Mapping[Place, np.ndarray] | None = None) -> bool:
        """Whether all targets are met, now or with other values."""
        put = values or {}
        return all(same(put[p] if p in put else self.now(p), target) for p, target in targets.items())

    def run_with(self, more: Values | tuple[()] = (), only: Collection[Place] | None = None) -> Values:
        """The values with all that was put in, and `more`."""
        base = None if only is None else self.values
        return self.graph.run({**self.inputs, **self.fixed, **dict(more)}, base, only)

    def run_each(self, options: Sequence[Values], only: Collection[Place]) -> Values:
        """The values with all that was put in, and each of some options: place → shape (options, samples)."""
        return self.graph.run_each(options, {**self.inputs, **self.fixed}, self.values, only)

    def values_with(self, option: Values) -> Values:
        """The values with `option` put in, for once."""
        return self.run_with(option, self.graph.downstream(option))

    def put(self, option: Values) -> None:
        """Put values into some places, for good."""
        self.fixed.update(option)
        self.values = self.run_with(only=self.graph.downstream(option))

    def calculate(self, place: Place, tree: Tree) -> np.ndarray:
        """What a cell would hold with another formula."""
        return at_samples(self.graph.cell(place, self.values, tree))

    def elements(self, turn: Turn, option: Values | tuple[()] = ()) -> dict[Line, tuple[bool, np.ndarray]]:
        """The windows that are elementary matrices, with `option` → their sense, and what the other would be."""
        half = len(turn.elements) // 2
        return {
            window: (n < half, turn.elements[n - half])
            for window in self.found.windows
            for n, element in enumerate(turn.elements)
            if self.met(as_window(window, element), dict(option))
        }

    def stands(self, calculation: Calculation, places: Line) -> bool:
        """Whether some cells together hold values known for so many."""
        return any(same(each, self.block(places)) for each in calculation.known.get(len(places), ()))


def as_window(window: Line, matrix: np.ndarray) -> Values:
    """Place → its value if a window of 3×3 or 4×4 holds a matrix, or its first rows and columns."""
    size = 3 if len(window) == 9 else 4
    return dict(zip(window, matrix[:, :size, :size].reshape(len(matrix), -1).T, strict=True))
