"""One hand-in beside a reference: its results found by function, and its faults."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from mathpost.teaching.workbook.reference import statements
from mathpost.teaching.workbook.reference.branches import Search
from mathpost.teaching.workbook.reference.forks import not_compared
from mathpost.teaching.workbook.reference.inputs import match
from mathpost.teaching.workbook.reference.matched import different
from mathpost.teaching.workbook.reference.moved import Telling
from mathpost.teaching.workbook.reference.quantities import Dictionary, Sheet, agree
from mathpost.teaching.workbook.reference.results import Comparison
from mathpost.teaching.workbook.reference.where import Change, all_edits, edited, first_wrong, repair
from mathpost.teaching.workbook.report import (
    RIGHT,
    UNCLEAR,
    WRONG,
    Fault,
    FileReport,
)
from mathpost.teaching.workbook.sheet.file import read
from mathpost.teaching.workbook.sheet.place import Place
from mathpost.teaching.workbook.sheet.samples import at_samples
from mathpost.teaching.workbook.sheet.tree import text_of

if TYPE_CHECKING:
    from mathpost.teaching.workbook.reference.check import Reference

UNITS_APART = {-9, -6, -5, -3, 3, 5, 6, 9}  # powers of ten
MOST_FAULTS, MOST_ENDS = 6, 4
TELLING = 3  # digits of a number that is not the same as a different one by luck
SEVERAL = 3  # inputs that are as given, of which one that is not may be a mistake


class HandIn:
    """The comparison of one hand-in, its faults, and what is said of it."""

    def __init__(self, reference: Reference, path: Path) -> None:
        self.reference, self.ours = reference, reference.sheet
        self.sheet = sheet = Sheet(read(path))
        self.first_trees = dict(sheet.trees)
        told = {
            self.ours.named("cells", here).places[0]: sheet.named(f"cells, {here}", there).places[0]
            for here, there in reference.homework.cells.items()
        }
        steps_too = reference.homework.results is None
        self.matched = match(self.ours, reference.inputs, sheet, told)
        self.comparison = Comparison(self.ours, reference.results, sheet, self.matched, told, steps_too)
        if self.matched.scale:
            matched = replace(self.matched, factor=self.matched.factor | self.matched.scale)
            scaled = Comparison(self.ours, reference.results, sheet, matched, told, steps_too)
            if len(scaled.known_cells) > len(self.comparison.known_cells):
                self.matched, self.comparison = matched, scaled
        self.faults: list[Fault] = []
        self.wrong: list[Place] = []
        self.after: set[Place] = set()
        self.open: list[str] = [*reference.not_compared]
        self.not_compared: list[str] = []  # branches, in words
        self.errors: list[Telling] = []  # of the hand-in, where the reference has a number

    def report(self) -> FileReport:
        """Judge, and say what was found."""
        comparison = self.comparison
        comparison.place_results()
        while len(self.faults) < MOST_FAULTS and (self._find_fault() or self._differs_elsewhere()):
            comparison.place_results()
        if comparison.steps_too and not self.faults and not self.matched.weak:
            self._ends_that_are_nothing()
        self._numbers()
        self.open += [statements.error_elsewhere(self, each) for each in self.errors if not each.is_single]
        missing = list(comparison.candidates)
        self.open += statements.open_questions(self, missing)
        nothing = not comparison.found and not self.faults
        verdict = WRONG if self.faults else UNCLEAR if missing or self.open or nothing else RIGHT
        cells = [*statements.judgements(self)]
        unjudged = self.sheet.ranges(cell.place for cell in cells if cell.status == UNCLEAR)
        seen = [*self.open, *statements.seen(self)]
        report = FileReport(
            self.sheet.book.path, verdict, self.faults, cells, [*unjudged], seen, [*statements.warnings(self)]
        )
        report.beside = False
        report.explain = partial(statements.explain, self)
        return report

    # Faults.

    def _differs_elsewhere(self) -> bool:
        """Look where no sample was; whether a result that was found differs there."""
        comparison = self.comparison
        if comparison.fixed:
            return False
        search = Search(comparison, comparison.found)
        if telling := search.telling():
            comparison.look_at(telling)
        self.not_compared = [*not_compared(search.not_reached)]
        self.errors = search.errors
        return bool(telling)

    def _find_fault(self) -> bool:
        """Find the first wrong cell of what is missing, and repair it."""
        comparison, order = self.comparison, self.sheet.calculation_order
        ready = [
            (result, cells) for result, cells in comparison.candidates.items() if cells and self._judged(result)
        ]
        ready.sort(key=lambda each: (each[0] not in comparison.sure, order(each[1][0])))
        for result, cells in ready:
            others = cells[:1] if result in comparison.sure else [*cells, *comparison.ends]
            if said := next(filter(None, (self._in_another_unit(result, cell) for cell in others)), ""):
                self.open += [said] * (said not in self.open)
                continue
            for cell in cells[: 1 if result in comparison.sure else None]:
                if not self.sheet.unknown.isdisjoint(self.sheet.upstream([cell])):
                    continue
                change = first_wrong(comparison, result, cell)
                if change and (change.tree is not None or not self._is_weak(result)):
                    self._add(change)
                    return True
            if result in comparison.sure and not self._is_weak(result):
                self._add(self._unexplained(result, cells[0]))
                return True
        return False

    def _is_weak(self, result: Place) -> bool:
        """Whether some of its inputs may be others: then only a formula with one part wrong is a fault."""
        return not self.ours.upstream([result]).isdisjoint(self.matched.weak)

    def _in_another_unit(self, result: Place, cell: Place) -> str:
        """What to ask of a cell that is a result times 10, 100, 1000 …, if it has a label of its own."""
        theirs = at_samples(self.comparison.theirs.get(cell, np.full(1, np.nan)))
        ours = at_samples(self.comparison.ours[result])
        ratio = theirs / ours
        if (
            self.sheet.labels.get(cell) == self.ours.labels.get(result)
            or not np.isfinite(ratio).all()
            or not ratio[0]
        ):
            return ""
        power = round(float(np.log10(abs(ratio[0]))))
        if power not in UNITS_APART or not agree(ratio, np.full_like(ratio, 10.0**power)):
            return ""
        there = f"{self.ours.address(result)} of the reference"
        return f"{self.sheet.address(cell)} is {10.0**power:g} times {there}: in another unit?"

    def _judged(self, result: Place) -> bool:
        """Whether the inputs of a result are known, nothing on the way is unknown, and texts have its words."""
        before = self.ours.upstream([result])
        cells = self.comparison.candidates.get(result, [])
        unknown = self.sheet.unknown & self.sheet.upstream(cells[:1])
        other_words = bool(cells) and self.ours.words(result) != self.sheet.words(cells[0])
        doubtful = not before.isdisjoint([*self.matched.open, *self.matched.unsure])
        return not (doubtful or unknown or (result in self.ours.shown and other_words))

    def _unexplained(self, result: Place, cell: Place) -> Change:
        """A cell that should be a result, is not, and no single change makes it so."""
        ours, name = self.ours, self.ours.label(result)
        cell = self._source(cell)
        before = sorted(self.sheet.upstream([cell]) & self.sheet.trees.keys(), key=self.sheet.calculation_order)
        unlike = [p for p in before if self._is_not_what_its_label_says(p)]
        if unlike:
            cell, result = unlike[0], self.comparison.meant[unlike[0]]
            name = ours.label(result)
        filled = [p for p in unlike[1:] if self.sheet.relative(p) == self.sheet.relative(cell) is not None]
        text = (
            f"{self.sheet.short(cell)} is not {ours.address(result)} of the reference{f' ({name})' if name else ''}"
        )
        more = "no single change of one cell makes it so"
        values = {cell: at_samples(self.comparison.ours[result])}
        values |= {p: at_samples(self.comparison.ours[self.comparison.meant[p]]) for p in filled}
        typed = [p for p in self.sheet.upstream([cell]) & self.sheet.numbers_typed.keys() - self.matched.back.keys()
                 if np.full(1, self.sheet.numbers_typed[p]) not in self.comparison.known]  # fmt: skip
        typed = [p for p in typed if p != cell and len(f"{self.sheet.numbers_typed[p]:.10g}") > TELLING]
        if len(typed) == 1:
            said = f"{self.sheet.short(typed[0])} is a number, {self.sheet.numbers_typed[typed[0]]:g}, typed"
            return Change(
                typed[0],
                "typed over formula",
                f"{said} where a formula belongs: {text}",
                None,
                {**values, typed[0]: np.full(1, np.nan)},
            )
        return Change(cell, "wrong value", f"{text}, and {more}", None, values)

    def _is_not_what_its_label_says(self, cell: Place) -> bool:
        meant = self.comparison.meant.get(cell)
        return meant in self.comparison.ours and not self.comparison.same(meant, cell)

    def _source(self, cell: Place) -> Place:
        """The formula of which a cell is but a copy."""
        sheet = self.sheet
        while sheet.tree(cell)[0] == "area" and (before := sheet.uses[cell])[0] in sheet.trees and len(before) == 1:
            cell = before[0]
        return cell

    def _add(self, change: Change) -> None:
        sheet, place = self.sheet, change.place
        array = len(sheet.array(place)) > 1
        after, known = sheet.downstream([place]), {*self.wrong}
        before = {p: text_of(tree) for p, tree in sheet.trees.items()}
        alike = repair(self.comparison, change)[1:]
        self.after |= after | sheet.downstream(alike)
        self.wrong += [place, *alike]
        text = change.message
        if array:
            text = f"{sheet.short(place)}, of the array {sheet.range(sorted(sheet.array(place)))}: {text}"
        changed = [p for p in [place, *alike] if p not in known and before.get(p) != text_of(sheet.tree(p))]
        first = min(changed, key=sheet.reading_order, default=place)
        if first != place:
            text = f"as in {sheet.short(place)}: {text}"
        if others := [each for each in alike if each != first and each not in sheet.array(place)]:
            text += f"; the same in {', '.join(sheet.ranges(others))}"
        self.faults.append(Fault(sheet.address(first), change.cause, text, first))

    def _ends_that_are_nothing(self) -> None:
        """Judge what the hand-in ends in beside the results: one change away from a step that is nowhere else."""
        comparison, sheet = self.comparison, self.sheet
        for end in comparison.ends:  # a copy of a result that was typed
            source = self.sheet.uses[end][0] if sheet.tree(end)[0] == "area" else end
            number = sheet.numbers_typed.get(source) if source not in self.matched.back else None
            near = [r for r in comparison.found if number is not None and self._is_typed(number, r)]
            if near:
                text = f"{sheet.short(source)} is a number, {number:g}, typed where a formula belongs"
                self._add(Change(source, "typed over formula", text, None, {source: comparison.ours[near[0]]}))
                return
        gone = [p for p in self.ours.order if p not in self.ours.messages and p not in comparison.asked]
        gone = [p for p in gone if comparison.varies(p) and not comparison.index.find(comparison.ours[p])]
        steps = Dictionary((p, comparison.ours[p]) for p in gone)
        ends = [self._source(p) for p in comparison.ends]
        ends = [p for p in ends if p not in sheet.part and comparison.theirs[p] not in comparison.known]
        for end in ends[:MOST_FAULTS] if gone else ():
            for change in edited(comparison, [end], at_samples(comparison.theirs[end]), {}, all_edits):
                if steps.find(change.values[end]):
                    self._add(change)
                    return
        for end in ends[:MOST_ENDS] if comparison.found else ():
            near = comparison.nearest(end, gone)
            changes = (first_wrong(comparison, step, end) for step in near[:MOST_ENDS])
            if explained := next((each for each in changes if each and each.tree), None):
                self._add(explained)
                return

    def _is_typed(self, number: float, result: Place) -> bool:
        """Whether a number is what a result is at the hand-in's own inputs, with fewer digits."""
        value = at_samples(self.comparison.ours[result])[0]
        return self.comparison.varies(result) and abs(number - value) <= 1e-3 * abs(value) > 0

    def _numbers(self) -> None:
        """Judge inputs that hold a different number than the reference has."""
        wanted, others = self.reference.homework.numbers, different(self.matched, self.ours, self.sheet)
        for place, cell in others:
            own, other = self.ours.numbers_typed[place], self.sheet.numbers_typed[cell]
            there = f"{self.ours.address(place)} of the reference"
            text = f"{self.sheet.short(cell)} is {other:g}, where {there} is {own:g}"
            if wanted == "given":
                self.faults.append(Fault(self.sheet.address(cell), "wrong value", text, cell))
                self.wrong.append(cell)
                self.after |= self.sheet.downstream([cell])
            elif wanted == "any" and len(others) == 1 and len(self.matched.cells) > SEVERAL:
                self.open.append(
                    f"{text}: a mistake, or a number of the student's own? numbers = in the task file says"
                )
