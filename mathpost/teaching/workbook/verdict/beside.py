"""Further cells beside a calculation: lengths, distances, sums and means, differences, angles computed back.

No task asks for these. What is equal to something known is right; what breaks the pattern of its neighbours, or is
the one cell that keeps a vector from being known, is wrong; all else is listed.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np

from mathpost.teaching.workbook.meaning.given import runs
from mathpost.teaching.workbook.report import Fault
from mathpost.teaching.workbook.sheet.edits import edits, said
from mathpost.teaching.workbook.sheet.place import Place, beside
from mathpost.teaching.workbook.sheet.samples import CLOSE, same
from mathpost.teaching.workbook.sheet.tree import areas
from mathpost.teaching.workbook.verdict.known import Known, agree
from mathpost.teaching.workbook.verdict.pattern import Pattern
from mathpost.teaching.workbook.verdict.scope import Scope

if TYPE_CHECKING:
    from mathpost.teaching.workbook.sheet.formula import Tree
    from mathpost.teaching.workbook.verdict.judge import Judge

# Why a cell is right.
NUMBER = "it is a number that follows from right results: a length, distance, angle, entry or sum"
VECTOR = "with the cells in line it is a vector that follows from right results: a point, a sum, a mean, an axis"
# Why a cell is wrong.
EDITED = "it is nothing known, and one edit makes it that"
# Why a cell is not judged, what is said first counts.
TAKES_NOTHING = "it refers to an empty cell"
TWICE = "it says what a cell beside it says of the same cells, where each has a label of its own"
POINT = "it makes a point or an origin of other numbers, and the task does not say how"
COMPOSED = "it makes an angle of other numbers, and the task does not say how"
UNKNOWN = "it is no number, and of no vector, that follows from right results"


class Beside:
    """Judge what is left once a `Judge` has judged the calculations.

    `places` are all cells to judge, `unjudged` those that could not be: no result needs them, and they are nothing
    that is known, or not what their place or a text says. `rules` has the sentence that told each cell, whether it
    is right or not judged. `faults` are those that are found here.
    """

    def __init__(self, judge: Judge) -> None:
        self.judge, self.graph, self.found = judge, judge.graph, judge.found
        self.known = Known(judge)
        self.faults: list[Fault] = []
        self.rules: dict[Place, str] = {}
        scope, pattern = Scope(judge), Pattern(judge)
        self.places, rest = scope.places, scope.rest
        if not judge.unexplained:
            self._take(pattern.faults(rest, {p for w in self.found.windows if rest.issuperset(w) for p in w}))
        nothing = {p for p in self.places if self._takes_nothing(p)}
        twice = {p for p in rest if self._says_the_same(p, rest)}
        vectors = self._vectors(rest)
        self.rules, rest = vectors, rest - vectors.keys()
        others = (p for p in self.found.sorted(self.found.composed) if not self._is_degrees_and_minutes(p))
        composed = self._edited(others)
        unknown = self._unknown(rest - composed)
        doubts = [(TAKES_NOTHING, nothing), (TWICE, twice), (COMPOSED, composed), (POINT, self._computed_points())]
        doubts += [(UNKNOWN, unknown)]
        self.unjudged = set().union(*(places for _, places in doubts))
        self.rules |= {place: rule for rule, places in doubts[::-1] for place in places}
        self.faults.sort(key=lambda fault: self.graph.calculation_order(fault.place))

    def _edited(self, listed: Iterable[Place]) -> set[Place]:
        """Return the made angles that no single repair makes degrees and minutes; the others are faults."""
        left, judge = set(), self.judge
        for place in listed:
            tried = edits(self.graph, place) if place in self.graph.trees and not judge.unexplained else ()
            found = next((each for each in tried if self._is_degrees_and_minutes(place, each[3])), None)
            left |= set() if found else {place}
            if found:
                cause, old, new, tree = found
                text = f"{self.graph.short(place)}: {said(place, old, new)}"
                self._take([judge.fault(place, cause, text, EDITED, {place: judge.calculate(place, tree)})])
        return left

    def _take(self, faults: Iterable[Fault]) -> None:
        """Note faults, and put in what belongs there, so that what follows is seen without them."""
        for fault in faults:
            self.faults.append(fault)
            self.judge.put(fault.values)

    def _takes_nothing(self, place: Place) -> bool:
        """Whether a formula takes an empty cell, which may hide a slip."""
        tree = self.graph.tree(place)
        return tree[0] != "IF" and any(
            self.graph.component.keys().isdisjoint(a.places) and self.graph.cells.keys().isdisjoint(a.places)
            for a in areas(tree)
        )

    def _says_the_same(self, place: Place, rest: set[Place]) -> bool:
        """Whether a formula gives what the one next to it gives of the same cells, or copies one of `rest`."""
        graph, now = self.graph, self.judge.now(place)
        if not graph.uses.get(place) or graph.is_array(graph.array(place)) or np.ptp(now[1:]) < CLOSE:
            return False
        if graph.tree(place)[0] == "area":
            return not rest.isdisjoint(graph.uses[place])
        near = (p for p in beside(place) if p in rest and graph.uses.get(p) == graph.uses[place])
        return any(same(now, self.judge.now(p)) for p in near)

    def _computed_points(self) -> set[Place]:
        """Formulas that make points or origins of other numbers, which the task does not say."""
        graph, judge = self.graph, self.judge
        given = {p for turn in self.known.turns for p in (*turn.point, *turn.origin)}
        up = graph.upstream(given, judge.targets) - judge.targets.keys() - judge.inputs.keys()
        return {p for p in up & graph.trees.keys() if graph.trees[p][0] != "area" and graph.uses[p]}

    def _vectors(self, rest: set[Place]) -> dict[Place, str]:
        """The rules of the cells of known vectors."""
        judged: dict[Place, str] = {}
        lines = [line for line in runs(rest) if len(line) in (3, 4, 5)] * (not self.judge.unexplained)
        others = [line[n : n + 3] for line in lines for n in range(len(line) - 2)]
        first = sorted(self.found.beside, key=lambda line: self.graph.calculation_order(line[0]))
        for triple in (*first, *others):
            if rest.issuperset(triple[:3]) and judged.keys().isdisjoint(triple):
                is_known = agree(self.judge.block(triple[:3]), self.known.vectors).all(axis=-1).any()
                judged |= dict.fromkeys(triple if is_known else (), VECTOR)
        return judged

    # Single cells.

    def _unknown(self, rest: set[Place]) -> set[Place]:
        """Return the cells of `rest` that are nothing known."""
        unknown, typed = set[Place](), self.found.typed
        for place in rest - self.found.composed - self.judge.fixed.keys():
            if place not in typed and self.known.is_known(place):
                self.rules[place] = NUMBER
            else:
                unknown.add(place)
        return unknown

    # Angles made of other numbers.

    def _is_degrees_and_minutes(self, place: Place, tree: Tree | None = None) -> bool:
        """Whether a cell makes an angle of degrees and minutes, and seconds, of the sign of the degrees."""
        parts = [p for p in self.found.sorted(self.graph.uses[place]) if self.graph.own.get(p) is not None]
        in_line = 1 in (len({p[1] for p in parts}), len({p[2] for p in parts}))
        if not in_line or len(parts) not in (2, 3):
            return False
        sign = -1 if self.graph.number(parts[0]) < 0 else 1
        numbers, whole = np.array([[sign * 35.0], [20.0], [48.0]]), (35, 35 + 20 / 60, 35 + 20 / 60 + 48 / 3600)
        made = self.graph.cell(place, dict(zip(parts, numbers, strict=False)), tree)
        wanted = [unit * sign * whole[len(parts) - 1] for unit in (1, np.pi / 180)]
        return any(same(made, np.array([each])) for each in wanted)
