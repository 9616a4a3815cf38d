"""The pattern of its neighbours: a formula that breaks it is wrong, and a number where it would go on."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from mathpost.teaching.workbook.sheet.edits import repaired, said
from mathpost.teaching.workbook.sheet.evaluate import STATISTICS
from mathpost.teaching.workbook.sheet.formula import Tree
from mathpost.teaching.workbook.sheet.neighbours import between, filled
from mathpost.teaching.workbook.sheet.place import beside
from mathpost.teaching.workbook.sheet.samples import CLOSE, SAMPLES, Values, same
from mathpost.teaching.workbook.sheet.tree import areas, form_of, text_of, with_areas

if TYPE_CHECKING:
    from mathpost.teaching.workbook.report import Fault
    from mathpost.teaching.workbook.sheet.place import Place
    from mathpost.teaching.workbook.verdict.judge import Judge

UNLIKE_AROUND = "the formulas around it go on in a different way"


class Pattern:
    """What the cells around each cell say, by a `Judge`."""

    def __init__(self, judge: Judge) -> None:
        self.judge, self.graph = judge, judge.graph
        self.still = {p for window in judge.found.windows for p in window} | judge.inputs.keys()

    @cached_property
    def shaken(self) -> Values:
        """The values of all cells where the numbers that are no inputs are drawn at random as well."""
        graph, found = self.graph, self.judge.found
        moved = [p for p in found.typed - self.still if p in graph.used and graph.own[p] is not None]
        drawn = np.random.default_rng(4).uniform(0.3, 3, (len(moved), SAMPLES))
        given = self.judge.inputs | self.judge.fixed
        return graph.run(given | dict(zip(found.sorted(moved), drawn, strict=True)))

    def faults(self, rest: set[Place], but: Collection[Place] = ()) -> Iterator[Fault]:
        """Yield the faults of formulas, `but` of some, and of numbers; no result needs those of `rest`.

        Each holds what belongs there: who takes the next one has put that in.
        """
        graph = self.graph
        for place in sorted(graph.trees.keys() - graph.part.keys() - {*but}, key=graph.calculation_order):
            for other in self._others(place, place in rest):
                made = self.judge.calculate(place, other)
                if self._differs(place, other, made, place in rest):
                    yield self._fault(place, other, made)
                    break
        for place in self.judge.found.sorted(self._typed):
            goes_on = between(graph, place, 4) if place not in self.still else None
            if goes_on and np.isfinite(made := self.judge.calculate(place, goes_on)).all():
                yield replace(self.judge.typed_number(place), values={place: made})

    @property
    def _typed(self) -> set[Place]:
        return self.judge.found.typed - self.graph.trees.keys()

    def _others(self, place: Place, is_rest: bool) -> Iterator[Tree]:
        """Yield the formulas with which those around a cell go on, where its own is another one."""
        graph, tree = self.graph, self.graph.trees[place]
        sure, near = between(graph, place, 4), between(graph, place, 3)
        line = (p for p in graph.component.get(place, ()) if p != place and (p[1] == place[1] or p[2] == place[2]))
        if sure and (tree[0] in STATISTICS or any(filled(graph, p, place) == tree for p in line)):
            sure = None  # a row of means, or a sum that starts again
        for other in (sure, near) if is_rest else (sure,):
            if other in (None, tree) or _without_numbers(other) == _without_numbers(tree):
                continue  # such as a matrix less that of zeros and ones
            alike = form_of(other) == graph.form(place)
            if other == sure or alike:
                yield other

    def _differs(self, place: Place, other: Tree, made: np.ndarray, is_rest: bool) -> bool:
        """Whether the other formula gives another value, at other constants too; a step to a result has its own."""
        graph, judge = self.graph, self.judge
        differs = not same(judge.now(place), made)
        telling = np.ptp(made[1:]) > CLOSE or any(same(judge.now(p), made) for p in beside(place))
        if not telling or not graph.component.keys() >= {*graph.used_by(other)} or (differs and not is_rest):
            return False
        return differs or not same(self.shaken[place], graph.cell(place, self.shaken, other))

    def _fault(self, place: Place, other: Tree, made: np.ndarray) -> Fault:
        """The fault of a cell that should hold another formula, said by the references or the part that differ."""
        graph, judge, tree = self.graph, self.judge, self.graph.trees[place]
        found = repaired(graph, {place: made}, judge.values)
        cause, sentence, repair = found or ("wrong value", said(place, tree, other), other)
        pairs = [each for each in zip(areas(tree), areas(other), strict=False) if each[0] != each[1]]
        alike = len(areas(tree)) == len(areas(other))
        if alike and len(pairs) == 1 and text_of(with_areas(tree, areas(other))) == text_of(other):
            cause, sentence = "wrong reference", said(place, *(("area", area) for area in pairs[0]))
        elif text_of(repair) != text_of(other):
            cause, sentence = "wrong value", said(place, tree, other)
        return judge.fault(place, cause, f"{graph.short(place)}: {sentence}", UNLIKE_AROUND, {place: made})


def _without_numbers(tree: Tree) -> Tree:
    return tuple(
        _without_numbers(part) if isinstance(part, tuple) else part for part in tree if tree[0] != "number"
    )
