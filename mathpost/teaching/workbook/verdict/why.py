"""Why is a cell wrong? The likeliest slip that explains its contents, and how much of a stretch that is."""

from __future__ import annotations

from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from mathpost.teaching.workbook.meaning.calculation import Turn
from mathpost.teaching.workbook.sheet.edits import INVERSE, repaired
from mathpost.teaching.workbook.sheet.neighbours import as_around
from mathpost.teaching.workbook.sheet.place import beside
from mathpost.teaching.workbook.sheet.samples import SAMPLES, same
from mathpost.teaching.workbook.sheet.tree import areas, heads, text_of

if TYPE_CHECKING:
    from mathpost.teaching.workbook.report import Fault
    from mathpost.teaching.workbook.sheet.formula import Tree
    from mathpost.teaching.workbook.sheet.place import Line, Place
    from mathpost.teaching.workbook.sheet.samples import Values
    from mathpost.teaching.workbook.verdict.judge import Judge

UNLIKELY, UNEXPLAINED = 2.0, 3.0  # what a repair costs that an odd change of the formula explains, or none
TRANSPOSED = "transposed", "the matrix should be transposed"  # cause and sentence
SIZES = {9: 3, 16: 4, 3: 3, 4: 4}  # rows of so many cells


class Why:
    """The causes of what a `Judge` finds wrong."""

    def __init__(self, judge: Judge) -> None:
        self.judge, self.graph, self.found = judge, judge.graph, judge.found

    def explain(self, calculation: Turn, unit: Line, option: Values) -> tuple[float, list[Fault]]:
        """The cost of a repair, and its faults, the first one first."""
        graph, faults, done, cost = self.graph, [], set(), 0.0
        in_window = unit in self.found.windows
        places = sorted(option, key=graph.reading_order if in_window else graph.calculation_order)
        if in_window and self.found.typed.issuperset(places):  # a typed matrix: what is wrong by its number first
            places.sort(key=lambda p: graph.value(p) is not None and abs(option[p][0] - graph.value(p)) < 1e-9)
        elements = self.judge.elements(calculation)
        is_block = len(unit) in SIZES and unit not in elements and (in_window or len(places) > 1)
        block = self.of_the_block(calculation, unit, option) if is_block else None
        for place in places:
            if place not in done:
                array = graph.array(place)
                done.update(array)
                wanted = {p: option.get(p, self.judge.targets.get(p, self.judge.now(p))) for p in array}
                cause, text, more = block or self._cause(calculation, wanted)
                text = f"{self._named(array)}: {text}" if block and len(array) > 1 else text
                cost = max(cost, more)
                faults.append(self.judge.fault(place, cause, text))
        if len(unit) > 16:  # all matrices at once
            return UNLIKELY - 0.5, faults
        if unit in elements and len(places) == 2:  # do the others turn the same way?
            near = graph.upstream(calculation.results)
            senses = [sense for window, (sense, _) in elements.items() if not near.isdisjoint(window)]
            cost = UNLIKELY if senses.count(elements[unit][0]) > 1 else 0.0
        elif len(unit) == 1:
            within = [w for w in (unit, *self.found.windows) if unit[0] in w and unit[0] not in self.judge.targets]
            stands = any(self.judge.stands(calculation, w) for w in within)
            if stands or self._spoils(calculation, option):
                cost += UNLIKELY  # it may be right as it is, alone or in a matrix, or what follows from it may be
        return cost, faults

    def _spoils(self, calculation: Turn, option: Values) -> bool:
        """Whether a repair changes a cell on the way to the results whose present value may be right."""
        after = self.graph.downstream(option) - option.keys() - self.judge.targets.keys()
        right = [
            p for p in after & self.graph.upstream(calculation.results) if self.judge.stands(calculation, (p,))
        ]
        values = self.judge.values_with(option) if right else {}
        return any(not same(values[p], self.judge.now(p)) for p in right)

    def _cause(self, calculation: Turn, wanted: Values) -> tuple[str, str, float]:
        """Cause, sentence and cost of one wrong cell, or of an array formula."""
        graph, (place, value) = self.graph, next(iter(wanted.items()))
        cell, short = graph.cells.get(place), self._named([*wanted])
        known = place in self.judge.targets or any(same(value, entry, 1e-7) for entry in calculation.entries)
        if cell is None:
            return "wrong value", f"{short} is empty", UNEXPLAINED
        if place not in graph.trees:
            if cell.number is None:
                return "wrong value", f"{short} holds {cell.value!r} where a number belongs", 0.0
            if np.ptp(value[1:]) < 1e-9:
                return "wrong value", f"{short} is {cell.number:g}, should be {value[1]:g}", 0.0
            cost = 0.0 if known and cell.number not in (0, 1, -1) else UNLIKELY * 1.1
            text = f"{short} is a number, {cell.number:g}, typed where a formula belongs"
            return "typed over formula", text, cost
        tree = graph.trees[place]
        lines = filter(None, (calculation.point, calculation.origin, *self.found.windows))
        if found := repaired(graph, wanted, self.judge.values, calculation.given, [*lines]):
            cause, sentence, other = found
            plain = tree[0] in ("+", "-") or (heads(tree).isdisjoint({"minus", *INVERSE}) and tree[0] != "area")
            odd = as_around(graph, place) == tree or (plain and other == ("minus", tree))
            odd |= tree[0] == "minus" and graph.form(place) in map(graph.form, beside(place))
            cause = self.reference_kind(place, other) if cause == "wrong reference" else cause
            return cause, f"{short}: {sentence}", UNLIKELY * (cause == "sign" and odd)
        text = f"{short}: ={text_of(tree, place[0])} is not what belongs there"
        return "wrong value", text, UNEXPLAINED + 9 * (not known)

    def _named(self, array: list[Place]) -> str:
        """The address of the first of some cells, and of the array formula that they are of."""
        first, last = (self.graph.short(each(array, key=self.graph.reading_order)) for each in (min, max))
        return self.graph.short(array[0]) + f", of the array {first}:{last}" * (len(array) > 1)

    def reference_kind(self, place: Place, other: Tree) -> str:
        """Name a wrong reference: a missing $, a different angle, a different point, or just a different cell."""
        pairs = zip(areas(self.graph.trees[place]), areas(other), strict=True)
        old, new = next((a, b) for a, b in pairs if a != b)
        above, is_table = (place[0], place[1] - 1, place[2]), len(self.graph.component[place]) > 9
        is_table &= self.graph.form(above) == self.graph.form(place)
        there = map(str, areas(self.graph.tree(above)))
        if is_table and old.top > new.top and not old.fixed[0] and str(new) in there:
            return "missing $"
        if new.places[0] in self.found.angles:
            return "wrong angle"
        return "wrong point" if {old.places[0], new.places[0]} <= self.found.lengths else "wrong reference"

    def of_the_block(self, calculation: Turn, unit: Line, option: Values) -> tuple[str, str, float] | None:
        """Why a matrix or vector is wrong, with the cost: it or a factor is transposed, or a product reversed."""
        size, square = SIZES[len(unit)], len(unit) > 4

        def matrix(places: Line, *more: Values) -> np.ndarray:
            return self.judge.block(places, *more).T.reshape(SAMPLES, size, -1)

        now, wanted = matrix(unit), matrix(unit, option)
        windows = {w: matrix(w) for w in self.found.windows if len(w) == size * size and w != unit}
        if square and same(now, _turned(wanted)):
            copy = all(self.graph.tree(p)[0] == "area" for p in unit)
            return *TRANSPOSED, UNLIKELY * (not copy)
        lines = dict.fromkeys(p for c in self.judge.live for p in (c.point, c.results))
        lines |= dict.fromkeys(self.graph.components)
        others = windows if square else {c: matrix(c) for c in lines if len(c) == size and c != unit}
        turned = [] if square else [(w, _turned(each)) for w, each in windows.items()]
        for (a, left), (b, right) in product((*windows.items(), *turned), others.items()):
            if same(left @ right, wanted):
                order = f"the order is {self.graph.range(a)} times {self.graph.range(b)}"
                slips = [("transposed", "a factor of the product is transposed", _turned(left) @ right)]
                if square:
                    slips.append((*slips[0][:2], left @ _turned(right)))
                    slips.append(("order of product", order, right @ left))
                    slips.append(("transposed", "the product is transposed", _turned(left @ right)))
                for cause, text, slip in slips:
                    if same(slip, now):
                        return cause, text, 0.0
        return None


def _turned(matrix: np.ndarray) -> np.ndarray:
    return np.swapaxes(matrix, 1, 2)
