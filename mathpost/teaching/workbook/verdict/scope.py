"""Which cells of a sheet are to be judged, and which of them no result needs."""

from __future__ import annotations

import re
from collections import Counter
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from mathpost.detective.digits import written_decimals
from mathpost.teaching.workbook.meaning.vocabulary import wording
from mathpost.teaching.workbook.sheet.evaluate import STATISTICS
from mathpost.teaching.workbook.sheet.formula import Tree
from mathpost.teaching.workbook.sheet.place import Place, beside
from mathpost.teaching.workbook.sheet.tree import areas, heads

if TYPE_CHECKING:
    from mathpost.teaching.workbook.verdict.judge import Judge

CALCULATED = 3  # decimals that nobody gives
EXPECTED = wording("expected")
LENGTH_OR_VOLUME = rf"{wording('length or volume')}|\|.*\|"


class Scope:
    """What a `Judge` that has judged the calculations has to judge: `places`, of which no result needs `rest`."""

    def __init__(self, judge: Judge) -> None:
        self.judge, self.graph, self.found = judge, judge.graph, judge.found
        self.places, self.rest = self._scope()

    def _scope(self) -> tuple[list[Place], set[Place]]:
        """The cells to judge, and those of them that no result needs."""
        judge, graph, found = self.judge, self.graph, self.found
        messages = graph.messages
        formulas = [p for p in graph.trees if p not in found.typed - found.composed] + [*graph.unread]
        # A number of many digits, or 0, that only messages use was a formula; another is their tolerance.
        typed = found.typed - graph.trees.keys()
        alone = {p for p in typed - graph.used.keys() if self._looks_calculated(p)}
        typed = {p for p in typed if messages.issuperset(graph.used.get(p, "-"))}
        typed = {p for p in typed if float(f"{graph.value(p):.2g}") != graph.value(p) or graph.value(p) == 0}
        results = np.array([target[0] for target in judge.targets.values()])
        typed = {p for p in typed if not (np.abs(results - graph.value(p)) <= _half_digit(graph.value(p))).any()}
        typed |= alone
        places = [p for p in formulas if p not in messages] + sorted(typed, key=graph.reading_order)
        explained = (p for c in found.calculations if c not in judge.unexplained for p in c.results)
        rest = set(places) - (graph.upstream(explained, judge.inputs) - judge.inputs.keys())
        given = graph.upstream(p for c in found.calculations for p in (*c.given, *c.results))
        from_given, from_any = (graph.downstream(p - graph.trees.keys()) for p in (given, graph.cells.keys()))
        # The numbers of points, 1, 2, 3, copied beside what became of them.
        copies = rest - graph.used.keys() - from_given
        copies = {p for p in copies if graph.tree(p)[0] == "area"}
        own = {p: graph.own[p] for p in copies if graph.own[p] is not None}
        other = {p for p in own for q in beside(p) if q in own and abs(graph.number(q) - graph.number(p)) == 1}
        given |= {p for c in {id(c): c for c in map(graph.component.get, given) if c}.values() for p in c}
        from_given = graph.downstream(given - graph.trees.keys())  # and the cells beside them
        other |= {p for p in rest & from_any - from_given if _is_count_or_mean(graph.tree(p))}
        return [p for p in places if p not in other], rest - other

    def _looks_calculated(self, place: Place) -> bool:
        """Whether a number that no formula uses is said to be a length, or alone has decimals that nobody gives."""
        if re.search(LENGTH_OR_VOLUME, self.found.label(place), re.I):
            return True
        is_alone = self._typed_in[id(self.graph.component[place])] < 3
        has_decimals = written_decimals(self.graph.number(place)) >= CALCULATED
        return is_alone and has_decimals and not re.search(EXPECTED, self.found.label(place), re.I)

    @cached_property
    def _typed_in(self) -> Counter[int]:
        """How many typed numbers each component has."""
        component = self.graph.component
        return Counter(id(component[p]) for p in self.found.typed if p in component)


def _is_count_or_mean(tree: Tree) -> bool:
    """Whether a formula only counts on, or sums up: no calculation of this field is made of such alone."""
    return heads(tree) <= {*STATISTICS, "area", "number", "+", "-"} and len(areas(tree)) == 1


def _half_digit(number: float | None) -> float:
    return 0.51 * 10.0 ** -written_decimals(number) if number else 1e-6
