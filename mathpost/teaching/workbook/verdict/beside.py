"""Further cells beside a calculation: lengths, distances, sums and means, differences, angles computed back.

No task asks for these. Each is judged as what it is: one of the numbers and vectors that follow from right results.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mathpost.teaching.workbook.sheet.place import Place
from mathpost.teaching.workbook.sheet.samples import CLOSE, same
from mathpost.teaching.workbook.sheet.tree import areas
from mathpost.teaching.workbook.verdict.around import Around
from mathpost.teaching.workbook.verdict.beside_numbers import BesideNumbers
from mathpost.teaching.workbook.verdict.beside_vectors import BesideVectors
from mathpost.teaching.workbook.verdict.known import Known
from mathpost.teaching.workbook.verdict.labelled import Labelled
from mathpost.teaching.workbook.verdict.scope import Scope

if TYPE_CHECKING:
    from mathpost.teaching.workbook.verdict.judge import Judge

# Why a cell is not judged, what is said first counts.
UNLIKE_AROUND = "it is a number that follows from right results, but breaks what the cells around it do"
UNLIKE_LABEL = "it is not what its label says"
UNLIKE_TEXT = "it is a vector that follows from right results, but another one than a text or its row says"
TAKES_NOTHING = "it refers to an empty cell"
COMPOSED = "it makes an angle of other numbers, and the task does not say how"
POINT = "it makes a point or an origin of other numbers, and the task does not say how"
NOT_TAKEN = "it is of a matrix that shifts, and no result takes it, as others are taken"
UNKNOWN = "it is no number, and of no vector, that follows from right results"


class Beside:
    """Judge what is left once a `Judge` has judged the calculations.

    `places` are all cells to judge, `unjudged` those that could not be: no result needs them, and they are nothing
    that is known, or not what their place or a text says. `rules` has the sentence that told each cell, whether it
    is right or not judged. A slip that is found is added to the judge's faults.
    """

    def __init__(self, judge: Judge) -> None:
        self.judge, self.graph, self.found = judge, judge.graph, judge.found
        self.known = Known(judge)
        scope = Scope(judge)
        self.places, rest = scope.places, scope.rest
        before = len(judge.faults)
        around, labelled = Around(judge, self.known), Labelled(judge, self.known)
        vectors = BesideVectors(judge, self.known, around)
        numbers = BesideNumbers(judge, self.known, self.places)
        for each in (around, labelled) if not judge.unexplained else ():
            judge.faults += each.faults(rest)
        doubts = [
            (UNLIKE_AROUND, around.doubtful),
            (UNLIKE_LABEL, labelled.doubtful),
            (TAKES_NOTHING, set(filter(self.known.takes_nothing, rest))),
            (TAKES_NOTHING, set(filter(self._takes_an_empty_cell, self.places))),
        ]
        rest -= vectors.judged(rest)
        judge.faults += labelled.compared(rest)
        composed = numbers.composed()
        unknown = numbers.unknown(rest - composed)
        own = judge.faults[before:]
        judge.faults[before:] = sorted(own, key=lambda fault: self.graph.calculation_order(fault.place))
        doubts += [(UNLIKE_TEXT, vectors.doubtful), (COMPOSED, composed), (POINT, self._computed_points())]
        doubts += [(NOT_TAKEN, self._shifts_not_taken()), (UNKNOWN, unknown)]
        self.unjudged = set().union(*(places for _, places in doubts))
        self.rules = vectors.rules | numbers.rules
        self.rules |= {place: rule for rule, places in doubts[::-1] for place in places}

    def _takes_an_empty_cell(self, place: Place) -> bool:
        """Whether a formula takes a cell in which nothing is: a constant that is 0 may hide that it is a slip."""
        graph, tree = self.graph, self.graph.tree(place)
        single = [area.places[0] for area in areas(tree) if area.shape == (1, 1)] if tree[0] != "IF" else []
        return not graph.cells.keys() >= set(single)

    def _shifts_not_taken(self) -> set[Place]:
        """Formulas of a 4×4 that only shifts and that nothing uses, beside others that results take: left out?"""
        graph, judge, found = self.graph, self.judge, set()
        windows = [{*window} for window in self.found.windows if len(window) == 16]
        up = graph.upstream(judge.targets)
        for window in windows if any(map(up.issuperset, windows)) else ():
            turn = judge.block(self.found.sorted(window)).reshape(4, 4, -1)[:3, :3]
            users = {user for p in window for user in graph.used.get(p, ())} - window
            if not users and np.abs(turn - np.eye(3)[..., None]).max() < CLOSE:
                found |= window & graph.trees.keys()
        return found

    def _computed_points(self) -> set[Place]:
        """Formulas that make points or origins of other numbers, which the task does not say; but for means."""
        graph, judge = self.graph, self.judge
        given = {places for turn in self.known.turns for places in (turn.point, turn.origin)} - {()}
        points = [p for p in given if not any(same(judge.block(p), known) for known in self.known.combined)]
        up = graph.upstream((p for places in points for p in places), judge.targets)
        up -= judge.targets.keys() | judge.inputs.keys()
        return {p for p in up & graph.trees.keys() if graph.trees[p][0] != "area" and graph.uses[p]}
