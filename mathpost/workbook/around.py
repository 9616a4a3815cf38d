"""What the cells around a cell say that it should hold: a formula that goes on, a range as long as the table.

A cell beside the calculations may be something that is known, and yet not what all around it are.
"""

from itertools import pairwise

import numpy as np

from mathpost.detective.misreadings import written_decimals
from mathpost.workbook.edits import repaired, said
from mathpost.workbook.formula import STATISTICS, Area, areas, form_of, put, text_of, walk, with_areas
from mathpost.workbook.given import offset
from mathpost.workbook.graph import CLOSE, SAMPLES, beside, same

WAYS = ((1, 0), (0, 1), (-1, 0), (0, -1))


class Around:
    """The faults of cells of a `Judge` that are unlike those around them; `is_known(place, tree)` helps to tell."""

    def __init__(self, judge, is_known):
        self.judge, self.graph, self.found, self.is_known = judge, judge.graph, judge.found, is_known
        graph, found = self.graph, self.found
        still = {p for window in found.windows for p in window} | judge.inputs.keys()
        moved = [p for p in found.typed - still if p in graph.used and graph.own[p] is not None]
        drawn = np.random.default_rng(4).uniform(0.3, 3, (len(moved), SAMPLES))
        self.shaken = graph.run(judge.inputs | judge.fixed | dict(zip(found.sorted(moved), drawn, strict=True)))

    def faults(self, rest):
        """Yield the faults of formulas and numbers; those of `rest` are what no result needs."""
        graph = self.graph
        for place in sorted(graph.trees.keys() - graph.part.keys(), key=graph.calculation_order):
            fault = self._short_range(place) if place in rest else None
            if fault := fault or self._unlike(place, place in rest):
                yield fault
        for place in self.found.sorted(self.found.typed - graph.trees.keys()):
            if self._is_typed_over(place):
                text = f"{graph.short(place)} is a number, {graph.own[place]:g}, typed where a formula belongs"
                yield self.judge.fault(place, "typed over formula", text)

    # A formula.

    def _unlike(self, place, is_rest):
        """The fault of a formula where those around it go on another way."""
        graph, judge, tree = self.graph, self.judge, self.graph.trees[place]
        between = self._between(place, 4)
        for other in (between, self._between(place, 3), *self._along(place)) if is_rest else (between,):
            if other in (None, tree) or _without_numbers(other) == _without_numbers(tree):
                continue  # such as a matrix less that of zeros and ones
            alike = form_of(other) == graph.form(place) or areas(other) == areas(tree)
            if other != between and not (alike and self.is_known(place, other)):
                continue
            made, shaken = judge.calculate(place, other), graph.cell(place, self.shaken, other)
            differs = not same(judge.now(place), made)
            sources = {p for area in areas(other) for p in area.places}
            telling = np.ptp(made[1:]) > CLOSE or any(same(judge.now(p), made) for p in beside(place))
            if not telling or not graph.component.keys() >= sources or differs > is_rest:
                continue  # what a result needs is judged elsewhere
            if differs or not same(self.shaken[place], shaken):
                return self._fault(place, other, made)
        return None

    def _fault(self, place, other, made):
        graph, judge = self.graph, self.judge
        found = repaired(graph, {place: made}, judge.values)
        cause, sentence, tree = found or ("wrong value", said(place, graph.trees[place], other), other)
        if tree != other and text_of(tree) != text_of(other):
            cause, sentence = "wrong value", said(place, graph.trees[place], other)
        judge.put({place: made})
        return judge.fault(place, cause, f"{graph.short(place)}: {sentence}")

    def _filled(self, near, place):
        """The formula of a cell filled to a place; None if it has none."""
        if near not in self.graph.trees or near in self.graph.part:
            return None
        down, right = place[1] - near[1], place[2] - near[2]
        filled = [area.filled(down, right) for area in areas(self.graph.trees[near])]
        return with_areas(self.graph.trees[near], filled) if all(filled) else None

    def _between(self, place, least):
        """The formula that those on both sides of a cell are filled from, in a line of `least` with the cell."""
        for down, right in WAYS[:2]:
            line = [offset(place, n * down, n * right) for n in (-2, -1, 1, 2)]
            goes_on = [self._goes_on(a, b) for a, b in pairwise(line)]
            if goes_on[1] and (least < 4 or goes_on[0] or goes_on[2]):
                return self._filled(line[1], place)
        return None

    def _goes_on(self, a, b):
        """Whether the formula of a cell is that of another one, filled."""
        return (filled := self._filled(a, b)) is not None and filled == self.graph.trees.get(b)

    def _along(self, place):
        """Yield the formulas of two cells before or after a cell, filled."""
        for down, right in WAYS:
            near, next_one = (offset(place, n * down, n * right) for n in (1, 2))
            if self._goes_on(near, next_one):
                yield self._filled(near, place)

    # A number.

    def _is_typed_over(self, place):
        """Whether a number stands where formulas go on: of what nobody else uses, or in a longer line."""
        graph, number = self.graph, self.graph.own[place]
        if place in graph.used:
            other = self._between(place, 3)
            sources = [p for area in areas(other or ("text",)) for p in area.places]
            lost = [p for p in sources if p in self.found.typed and p not in graph.used]
            return bool(lost) and graph.component.keys() >= set(sources)
        others = [self._between(place, 4), *self._along(place)]
        for n, other in enumerate(others):
            made = self.judge.calculate(place, other)[0] if other else np.nan
            if np.isfinite(made) and (n == 0 or abs(made - number) <= 0.51 * 10.0 ** -written_decimals(number)):
                return written_decimals(number) > 0 or n == 0
        return False

    # A range.

    def _short_range(self, place):
        """The fault of a sum, mean or extreme of all but the first or the last cell of a line."""
        tree = self.graph.trees[place]
        parts = [(path, part) for path, part in walk(tree) if part[0] in STATISTICS - {"SUMSQ"}]
        for path, part in parts:
            for inner, child in walk(part):
                if child[0] != "area" or sorted(child[1].shape)[0] > 1 or child[1].shape == (1, 1):
                    continue
                area, longer = child[1], self._whole(child[1], place)
                if longer != area and not self._is_divided(place, part[0], area):
                    other = put(tree, (*path, *inner), ("area", longer))
                    return self._fault(place, other, self.judge.calculate(place, other))
        return None

    def _whole(self, area, place):
        """A range with what goes on at its ends: formulas of one form, or the same coordinate of further points."""
        graph, places = self.graph, area.places
        step = (0, 1) if area.shape[0] == 1 else (1, 0)
        forms, roles = {*map(graph.form, places)}, self._coordinates
        role = {roles.get(p) for p in places}

        def is_like(p):
            return (
                p != place
                and p in graph.component
                and (
                    graph.form(p) in forms if None not in forms else roles.get(p) in role and graph.form(p) is None
                )
            )

        if graph.is_array(places) or len(forms) > 1 or (None in forms and (len(role) > 1 or None in role)):
            return area
        first, last = places[0], places[-1]
        while is_like(offset(first, -step[0], -step[1])):
            first = offset(first, -step[0], -step[1])
        while is_like(offset(last, *step)):
            last = offset(last, *step)
        return Area(first[0], *first[1:], *last[1:], area.fixed)

    @property
    def _coordinates(self):
        """Place of a given number → which coordinate it is, of a point."""
        return {p: n for c in self.judge.live for n, p in enumerate(c.point)}

    def _is_divided(self, place, head, area):
        """Whether another cell takes the same of what is left, as of groups in a table."""
        others = self._whole(area, place).places
        left = set(others) - set(area.places)
        for p, tree in self.graph.trees.items():
            if p != place and any(part[0] == head for _, part in walk(tree)):
                used = set(self.graph.uses[p])
                if used & left and used.isdisjoint(area.places):
                    return True
        return False


def _without_numbers(tree):
    return tuple(
        _without_numbers(part) if isinstance(part, tuple) else part for part in tree if tree[0] != "number"
    )
