"""Further cells beside a calculation: lengths, distances, sums and means, differences, angles computed back.

No task asks for these. What is equal to something known is right; what breaks the pattern of its neighbours, or is
the one cell that keeps a vector from being known, is wrong; all else is listed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from mathpost.teaching.workbook.meaning.given import may_turn, runs
from mathpost.teaching.workbook.report import Fault
from mathpost.teaching.workbook.sheet.edits import INVERSE, edits, said
from mathpost.teaching.workbook.sheet.place import Line, Place
from mathpost.teaching.workbook.sheet.samples import CLOSE, SAMPLES, same
from mathpost.teaching.workbook.sheet.tree import areas, heads
from mathpost.teaching.workbook.verdict.known import Known, agree
from mathpost.teaching.workbook.verdict.labels import Labels
from mathpost.teaching.workbook.verdict.pattern import Pattern
from mathpost.teaching.workbook.verdict.scope import Scope

if TYPE_CHECKING:
    from mathpost.teaching.workbook.sheet.formula import Tree
    from mathpost.teaching.workbook.verdict.judge import Judge

# Why a cell is right.
NUMBER = "it is a number that follows from right results: a length, distance, angle, entry or sum"
KEPT = "it is made of right results, and at all inputs what a step towards them is: what a turn keeps"
VECTOR = "with the cells in line it is a vector that follows from right results: a point, a sum, a mean, an axis"
# Why a cell is wrong.
EDITED = "it is nothing known, and one edit makes it that"
# Why a cell is not judged, what is said first counts.
UNLIKE_AROUND = "it is a number that follows from right results, but breaks what the cells around it do"
UNLIKE_LABEL = "it is not what its label says"
OF_ANOTHER_ROW = "it is a vector that follows from right results but for one cell, or that of another row"
TAKES_NOTHING = "it refers to an empty cell"
POINT = "it makes a point or an origin of other numbers, and the task does not say how"
COMPOSED = "it makes an angle of other numbers, and the task does not say how"
NOT_TAKEN = "it is of a matrix that no result takes, as others are taken"
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
        scope, pattern = Scope(judge), Pattern(judge, self.known)
        self.places, rest = scope.places, scope.rest
        unlike_around, unlike_label = set[Place](), set[Place]()
        if not judge.unexplained:
            for each in self._matrices(rest):
                unlike_around.update(each if isinstance(each, tuple) else ())
                self._take([each] if isinstance(each, Fault) else ())
            self._take(pattern.faults(rest, {p for w in self.found.windows if rest.issuperset(w) for p in w}))
            unlike_around |= {*pattern.doubts(rest)}
            unlike_label = self._edited(Labels(judge, self.known).doubts(rest), self._is_length)
        nothing = {p for p in self.places if self._takes_nothing(p)}
        vectors, of_another_row = self._vectors(rest)
        self.rules, rest = vectors, rest - vectors.keys()
        others = (p for p in self.found.sorted(self.found.composed) if not self._is_degrees_and_minutes(p))
        composed = self._edited(others, self._is_degrees_and_minutes)
        unknown = self._edited(self.found.sorted(self._unknown(rest - composed)), self._is_angle)
        doubts = [(UNLIKE_AROUND, unlike_around), (UNLIKE_LABEL, unlike_label), (OF_ANOTHER_ROW, of_another_row)]
        doubts += [(TAKES_NOTHING, nothing), (COMPOSED, composed), (POINT, self._computed_points())]
        doubts += [(NOT_TAKEN, self._not_taken()), (UNKNOWN, unknown)]
        self.unjudged = set().union(*(places for _, places in doubts))
        self.rules |= {place: rule for rule, places in doubts[::-1] for place in places}
        self.faults.sort(key=lambda fault: self.graph.calculation_order(fault.place))

    def _edited(self, listed: Iterable[Place], is_right: Callable[[Place, Tree], bool]) -> set[Place]:
        """Return the cells that no single repair makes right; the others are faults."""
        left, judge = set(), self.judge
        for place in listed:
            tried = edits(self.graph, place) if place in self.graph.trees and not judge.unexplained else ()
            found = next((each for each in tried if is_right(place, each[3])), None)
            left |= set() if found else {place}
            if found:
                cause, old, new, tree = found
                text = f"{self.graph.short(place)}: {said(place, old, new)}"
                self._take([judge.fault(place, cause, text, EDITED, {place: judge.calculate(place, tree)})])
        return left

    def _is_length(self, place: Place, tree: Tree) -> bool:
        """Whether a formula gives a known length, where one coordinate is taken twice, or no root."""
        own, new = areas(self.graph.tree(place)), areas(tree)
        made, other_vector = self.judge.calculate(place, tree), own != new and len({*own}) == len(own)
        return not other_vector and np.ptp(made[1:]) > CLOSE and self.known.is_length(made)

    def _is_angle(self, place: Place, tree: Tree) -> bool:
        """Whether a formula in a cell that computes an angle back gives a known one."""
        inverse = heads(self.graph.tree(place)) & INVERSE and heads(tree) & INVERSE
        return (
            bool(inverse)
            and self.known.is_known(place, tree)
            and np.ptp(self.judge.calculate(place, tree)[1:]) > CLOSE
        )

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

    def _computed_points(self) -> set[Place]:
        """Formulas that make points or origins of other numbers, which the task does not say; but for means."""
        graph, judge = self.graph, self.judge
        given = {places for turn in self.known.turns for places in (turn.point, turn.origin)} - {()}
        points = [p for p in given if not any(same(judge.block(p), known) for known in self.known.combined)]
        up = graph.upstream((p for places in points for p in places), judge.targets)
        up -= judge.targets.keys() | judge.inputs.keys()
        return {p for p in up & graph.trees.keys() if graph.trees[p][0] != "area" and graph.uses[p]}

    # Matrices and vectors.

    def _not_taken(self) -> set[Place]:
        """Formulas of a 4×4 that nothing uses, beside others that results take: it may have been left out."""
        graph, windows = self.graph, [{*window} for window in self.found.windows if len(window) == 16]
        up = graph.upstream(self.judge.targets)
        free = [w for w in windows if all(w.issuperset(graph.used.get(p, ())) for p in w) and up.isdisjoint(w)]
        return set().union(*free) & graph.trees.keys() if any(map(up.issuperset, windows)) else set()

    def _matrices(self, rest: set[Place]) -> Iterator[Fault | Line]:
        """Matrices that no result needs and are none of the rotation: the faults of one cell or two, or all."""
        judge, unit = self.judge, np.repeat(np.eye(3).reshape(9, 1), SAMPLES, axis=1)
        known = [unit, *(matrix for c in judge.live for matrix in c.known.get(9, ()))]
        for window in self.found.windows:
            formulas, now = self.graph.trees.keys() & {*window}, judge.block(window)
            if len(window) != 9 or not formulas or not rest >= formulas or not may_turn(now[:, 1]):
                continue
            off = [[n for n in range(9) if not same(now[n], matrix[n])] for matrix in known]
            best = min(range(len(known)), key=lambda n: len(off[n]))
            one = {window[n]: known[best][n] for n in off[best]}
            faults = [judge.repaired_alone(p, value) for p, value in one.items()] if len(one) < 3 else [None]
            yield from [window] if None in faults else filter(None, faults)

    def _vectors(self, rest: set[Place]) -> tuple[dict[Place, str], set[Place]]:
        """The rules of the cells of known vectors, and the cells that are another row's, or but for one."""
        judge, judged, doubtful = self.judge, dict[Place, str](), set[Place]()
        lines = [line for line in runs(rest) if len(line) in (3, 4, 5)] * (not judge.unexplained)
        others = [line[n : n + 3] for line in lines for n in range(len(line) - 2)]
        others = [line for line in others if line not in self.found.beside]
        first = sorted(self.found.beside, key=lambda line: self.graph.calculation_order(line[0]))
        for triple in (*first, *others):
            if not rest.issuperset(triple[:3]) or not judged.keys().isdisjoint(triple):
                continue
            now = judge.block(triple[:3])
            if agree(now, self.known.vectors).all(axis=-1).any():
                judged |= dict.fromkeys(triple, VECTOR)
                doubtful.update(triple if self._is_of_another_row(triple[:3]) else ())
            elif triple in first and (agree(now, self._ends[1]).sum(axis=-1) == 2).any():  # but for one of three
                doubtful.update(triple)
        return judged, doubtful

    def _is_of_another_row(self, triple: Line) -> bool:
        """Whether a vector, calculated in the row of a table, is the point or result of another row only."""
        rows, ends = self._ends
        if triple[0][:2] not in rows or all(self.graph.tree(p)[0] == "area" for p in triple):
            return False
        fits = np.asarray(agree(self.judge.block(triple), ends).all(axis=-1))
        own = np.array([row == triple[0][:2] for row in rows])
        return len(rows) > 4 and bool(fits[~own].any()) and not fits[own].any()

    @cached_property
    def _ends(self) -> tuple[list[tuple[str, int]], np.ndarray]:
        """The row, as sheet and number, and the values of every point that is turned, and of what becomes of it."""
        turns = [turn for turn in self.known.turns if turn.point and len(turn.results) == 3]
        ends = [(self.judge.block(turn.point), np.array([*turn.targets.values()])) for turn in turns]
        rows = [turn.results[0][:2] for turn in turns for _ in (0, 1)]
        return rows, np.array([end for both in ends for end in both]).reshape(-1, 3, SAMPLES)

    # Single cells.

    def _unknown(self, rest: set[Place]) -> set[Place]:
        """Return the cells of `rest` that are nothing known."""
        unknown, typed = set[Place](), self.found.typed
        for place in rest - self.found.composed - self.judge.fixed.keys():
            if place not in typed and self.known.is_known(place):
                self.rules[place] = NUMBER
            elif place not in typed and self._is_kept(place):
                self.rules[place] = KEPT
            else:
                unknown.add(place)
        return unknown

    def _is_kept(self, place: Place) -> bool:
        """Whether it is made of results, and the same number as a step that is made of none, as u·p′ = u·p."""
        now, up = self.judge.now(place), self.graph.upstream([place])
        of_results = any(up.issuperset(turn.results) for turn in self.known.turns)
        return of_results and np.ptp(now[1:]) > CLOSE and bool(agree(now, self._steps).any())

    @cached_property
    def _steps(self) -> np.ndarray:
        """The values of the formulas that results need and that need none, shape (steps, samples)."""
        graph, results = self.graph, [p for turn in self.known.turns for p in turn.results]
        steps = graph.upstream(results) & graph.trees.keys() - graph.downstream(results)
        return np.array([self.judge.now(p) for p in self.found.sorted(steps)]).reshape(-1, SAMPLES)

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
