"""What the cells around a cell say that it should hold: a formula that goes on, a range as long as the table.

A cell beside the calculations may be something that is known, and yet not what all around it are.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from mathpost.teaching.workbook.meaning.given import may_turn
from mathpost.teaching.workbook.sheet.edits import repaired, said
from mathpost.teaching.workbook.sheet.evaluate import STATISTICS
from mathpost.teaching.workbook.sheet.formula import Area, Tree
from mathpost.teaching.workbook.sheet.neighbours import along, between, filled
from mathpost.teaching.workbook.sheet.place import Line, beside, offset
from mathpost.teaching.workbook.sheet.samples import CLOSE, SAMPLES, Values, same
from mathpost.teaching.workbook.sheet.tree import areas, form_of, parts_of, put, text_of, walk, with_areas

if TYPE_CHECKING:
    from mathpost.teaching.workbook.report import Fault
    from mathpost.teaching.workbook.sheet.place import Place
    from mathpost.teaching.workbook.verdict.judge import Judge
    from mathpost.teaching.workbook.verdict.known import Known

OF_A_PART = (
    r"first|last|ersten|letzten|without|ohne|only|nur|group|gruppe|P\d|\b(?:mid|mitte)\b|前|后|组|\d *[-–] *\d"
)


class Around:
    """The faults of cells that are unlike those around them, by a `Judge` and what is `Known`.

    After `faults`, `doubtful` are cells that are something known, but not together.
    """

    def __init__(self, judge: Judge, known: Known) -> None:
        self.judge, self.graph, self.found, self.known = judge, judge.graph, judge.found, known
        self.doubtful: set[Place] = set()
        self.given = judge.inputs | judge.fixed
        self.still = {p for window in self.found.windows for p in window} | judge.inputs.keys()

    @cached_property
    def shaken(self) -> Values:
        """The values of all cells where the numbers that are no inputs are drawn at random as well."""
        graph, typed = self.graph, self.found.typed
        moved = [p for p in typed - self.still if p in graph.used and graph.own[p] is not None]
        drawn = np.random.default_rng(4).uniform(0.3, 3, (len(moved), SAMPLES))
        return graph.run(self.given | dict(zip(self.found.sorted(moved), drawn, strict=True)))

    def faults(self, rest: set[Place]) -> Iterator[Fault]:
        """Yield the faults of formulas and numbers; those of `rest` are what no result needs."""
        graph, in_matrices = self.graph, set()
        for window in self.found.windows:
            formulas = graph.trees.keys() & set(window)
            is_matrix = len(window) == 9 and may_turn(self.judge.block(window)[:, 1])
            if is_matrix and formulas and rest.issuperset(formulas):
                in_matrices |= formulas
                yield from self._in_matrix(window)
        for place in sorted(graph.trees.keys() - graph.part.keys() - in_matrices, key=graph.calculation_order):
            fault = self._short_range(place) if place in rest else None
            if fault := fault or self._unlike(place, place in rest):
                yield fault
            elif place in rest and self._repeats(place):
                self.doubtful.add(place)
        for place in self.found.sorted(self.found.typed - graph.trees.keys()):
            other = between(graph, place, 4) if place not in self.still else None
            if other and np.isfinite(made := self.judge.calculate(place, other)).all():
                number = graph.own[place]
                if float(f"{number:.2g}") == number:  # it may be meant
                    self.doubtful.add(place)
                    continue
                self.judge.put({place: made})
                yield self.judge.typed_number(place)
            elif other is None and place not in graph.used and self._goes_on(place):
                self.doubtful.add(place)

    # A formula.

    def _unlike(self, place: Place, is_rest: bool) -> Fault | None:
        """The fault of a formula where those around it go on another way."""
        graph, judge, tree = self.graph, self.judge, self.graph.trees[place]
        sure = between(graph, place, 4)
        line = (p for p in graph.component.get(place, ()) if p != place and (p[1] == place[1] or p[2] == place[2]))
        if sure and (tree[0] in STATISTICS or any(filled(graph, p, place) == tree for p in line)):
            sure = None  # a row of means, or a sum that starts again
        for other in (sure, between(graph, place, 3), *along(graph, place)) if is_rest else (sure,):
            if other in (None, tree) or _without_numbers(other) == _without_numbers(tree):
                continue  # such as a matrix less that of zeros and ones
            if other != between(graph, place, 3) and self._closes(place, other):
                continue
            alike = form_of(other) == graph.form(place)
            if other != sure and not (alike and self.known.is_known(place, other)):
                continue
            made, shaken = judge.calculate(place, other), graph.cell(place, self.shaken, other)
            differs = not same(judge.now(place), made)
            sources = set(graph.used_by(other))
            telling = np.ptp(made[1:]) > CLOSE or any(same(judge.now(p), made) for p in beside(place))
            if not telling or not graph.component.keys() >= sources or (differs and not is_rest):
                continue  # what a result needs is judged elsewhere
            if differs or not same(self.shaken[place], shaken):
                return self._fault(place, other, made)
        return None

    def _closes(self, place: Place, other: Tree) -> bool:
        """Whether a formula leads from the end of one back to the first, as the last side of a triangle does."""
        graph, own = self.graph, set(areas(self.graph.trees[place]))
        mates = [p for p in graph.component.get(place, ()) if p != place and graph.form(p) == graph.form(place)]
        alike, back = [set(areas(graph.trees[p])) for p in mates], own.difference(areas(other))
        on = own - back
        return bool(on and back and own not in alike and any(on <= each for each in alike)) and any(
            back <= each and not on <= each for each in alike
        )

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
        judge.put({place: made})
        return judge.fault(place, cause, f"{graph.short(place)}: {sentence}")

    def _goes_on(self, place: Place) -> bool:
        """Whether a number is where the formulas of a line would continue, such as those of means."""
        likely = [between(self.graph, place, 3), *along(self.graph, place)]
        trees = [tree for tree in likely if tree and tree[0] != "area"]
        return any(self.graph.component.keys() >= set(self.graph.used_by(tree)) for tree in trees)

    # A matrix.

    def _in_matrix(self, window: Line) -> Iterator[Fault]:
        """The faults of a matrix beside the calculations, of which one or two cells keep it from a known one."""
        judge, graph = self.judge, self.graph
        now, unit = judge.block(window), np.repeat(np.eye(3).reshape(9, 1), SAMPLES, axis=1)
        known = [unit, *(matrix for c in judge.live for matrix in c.known.get(9, ()))]
        off = [[not same(a, b) for a, b in zip(now, matrix, strict=True)] for matrix in known]
        best = min(range(len(known)), key=lambda n: sum(off[n]))
        wrong = [(place, known[best][n]) for n, place in enumerate(window) if off[best][n]]
        if len(wrong) > 2:
            self.doubtful.update(window)
        for place, value in wrong if len(wrong) < 3 else ():
            text = f"{graph.short(place)} keeps {graph.range(window)} from being a matrix of the rotation"
            yield judge.repaired_alone(place, value) or judge.fault(place, "wrong value", text)

    def _short_range(self, place: Place) -> Fault | None:
        """The fault of a sum, mean or extreme of all but the first or the last cell of a line."""
        tree = self.graph.trees[place]
        parts = [(path, part) for path, part in walk(tree) if part[0] in STATISTICS - {"SUMSQ"}]
        parts = [] if parts and self.is_of_a_part(place) else parts
        for path, part in parts:
            for inner, child in walk(part):
                if child[0] != "area" or sorted(child[1].shape)[0] > 1 or child[1].shape == (1, 1):
                    continue
                area, longer = child[1], self.whole(child[1], place)
                by_one = sum(longer.shape) == sum(area.shape) + 1
                if longer != area and not self._is_alone(place, part[0], area, longer):
                    self.doubtful.update([place] * by_one)
                elif longer != area:
                    other = put(tree, (*path, *inner), ("area", longer))
                    self.judge.put({place: self.judge.calculate(place, other)})
                    text = f"{self.graph.short(place)}: {said(place, child, ('area', longer))}"
                    return self.judge.fault(place, "wrong reference", text)
        return None

    def _repeats(self, place: Place) -> bool:
        """Whether a statistic is the same as the one beside it, where others step on."""
        graph, tree = self.graph, self.graph.trees[place]
        near = [p for p in beside(place) if graph.form(p) == graph.form(place)]
        moving = [area for area in areas(tree) if not any(area.fixed)]
        return tree[0] in STATISTICS and bool(moving) and any(graph.trees[p] == tree for p in near)

    def whole(self, area: Area, place: Place) -> Area:
        """A range with what goes on at its ends: formulas of one form, or the same coordinate of further points."""
        graph, places = self.graph, area.places
        step = (0, 1) if area.shape[0] == 1 else (1, 0)
        forms, roles = {*map(graph.form, places)}, self._coordinates
        role = {roles.get(p) for p in places}

        def is_like(p: Place) -> bool:
            goes_on = graph.form(p) in forms and (None not in forms or roles.get(p) in role)
            return goes_on and p != place and p in graph.component

        if graph.is_array(places) or len(forms) > 1 or (None in forms and (len(role) > 1 or None in role)):
            return area
        first, last = places[0], places[-1]
        while is_like(offset(first, -step[0], -step[1])):
            first = offset(first, -step[0], -step[1])
        while is_like(offset(last, *step)):
            last = offset(last, *step)
        return Area(first[0], *first[1:], *last[1:], area.fixed)

    def is_of_a_part(self, place: Place) -> bool:
        """Whether a text in its row says that a cell is of some of the points only."""
        texts = (cell.value for p, cell in self.graph.cells.items() if p[:2] == place[:2] and not cell.formula)
        return any(re.search(OF_A_PART, text, re.I) for text in texts if isinstance(text, str))

    @property
    def _coordinates(self) -> dict[Place, int]:
        """Place of a given number → which coordinate it is, of a point."""
        return {p: n for c in self.judge.live for n, p in enumerate(c.point)}

    def _is_alone(self, place: Place, head: str, area: Area, longer: Area) -> bool:
        """Whether all statistics of the same line, or beside it of such lines, go as far as the longer one."""
        along, found = (1 if area.shape[1] == 1 else 2), []
        first, last = longer.places[0], longer.places[-1]
        for p, tree in self.graph.trees.items():
            parts = [part for part in parts_of(tree) if part[0] in STATISTICS] if p != place else ()
            for other, *inner in parts:
                lines = [part[1].places for part in inner[:1] if part[0] == "area"]
                lines = [line for line in lines if len({q[3 - along] for q in line}) == 1 < len(line)]
                beside = other == head and (p[0], p[along]) == (place[0], place[along])
                found += [line for line in lines if beside or not {*line}.isdisjoint(longer.places)]
        return bool(found) and all((q[0][along], q[-1][along]) == (first[along], last[along]) for q in found)


def _without_numbers(tree: Tree) -> Tree:
    return tuple(
        _without_numbers(part) if isinstance(part, tuple) else part for part in tree if tree[0] != "number"
    )
