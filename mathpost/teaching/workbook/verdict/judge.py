"""Right or wrong: every calculation is compared with what is asked for, and repaired for the next ones."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from itertools import chain
from typing import TYPE_CHECKING, Self

import numpy as np

from mathpost.detective.digits import written_decimals
from mathpost.teaching.workbook.meaning.calculation import Turn
from mathpost.teaching.workbook.report import Fault
from mathpost.teaching.workbook.sheet.edits import said
from mathpost.teaching.workbook.sheet.graph import Graph
from mathpost.teaching.workbook.sheet.samples import Values
from mathpost.teaching.workbook.sheet.tree import areas
from mathpost.teaching.workbook.verdict.readings import Readings
from mathpost.teaching.workbook.verdict.sampled import Sampled
from mathpost.teaching.workbook.verdict.tables import of_nc_words
from mathpost.teaching.workbook.verdict.where import Where
from mathpost.teaching.workbook.verdict.why import Why

if TYPE_CHECKING:
    from mathpost.teaching.workbook.meaning.recognise import Recognised
    from mathpost.teaching.workbook.sheet.formula import Tree
    from mathpost.teaching.workbook.sheet.place import Place

UNEXPLAINED = 5  # results without a repair: beside so many no further repairs are looked for
# What is found of a wrong cell.
UNLIKE_TASK = "it is an input, and the task gives another number"
TYPED = "the formulas around it go on over this number"


class Judge(Sampled):
    """Compare a recognised workbook, at random inputs, with what is asked for; repair it where it is wrong.

    After `run`, `faults` are the wrong cells in order, and `reading` names the sequence and convention of a sheet
    that is of other axes than those that were asked for without a word.
    """

    def __init__(self, graph: Graph, found: Recognised) -> None:
        super().__init__(graph, found)
        self.faults: list[Fault] = []
        self.reading: tuple[str, str] | None = None
        self.unexplained: list[Turn] = []
        self.targets: Values = {}
        self.readings = Readings(self)
        self.why = Why(self)
        self.where = Where(self)

    def fault(self, place: Place, cause: str, message: str, rule: str = "", values: Values | None = None) -> Fault:
        return Fault(self.graph.address(place), cause, message, place, values or {}, rule)

    def run(self) -> Self:
        """Judge every calculation; one that is wrong is repaired, so that the next ones are seen without it."""
        self.prepare(self.live)
        self.prepare(self.found.steps)
        for last in [c for c in self.live if len(self.bad(c.targets)) > 1]:
            if right := [step for step in self._steps_to(last) if not self.bad(step.targets)]:
                self._choose_steps(last, right)
        self.readings.read_the_headings()
        self.targets = {p: t for c in self.live for p, t in c.targets.items()}
        for calculation in self.live[:1]:
            self.faults += self._unlike_the_task(calculation)
        self.reading = self.readings.left_open()
        if not self.reading:
            self.faults += chain.from_iterable(map(self._repaired, self.live))
            self.faults += self._judged_by_steps()
        if others := self.readings.of_another_convention(self.unexplained):
            self.faults, self.unexplained = self.faults + others, []
        self.faults += of_nc_words(self)
        return self

    def _steps_to(self, last: Turn) -> list[Turn]:
        """The vectors on the way to a result."""
        if not self.found.steps:
            return []
        up = self.graph.upstream(last.results, last.point)
        return [step for step in self.found.steps if up.issuperset(step.results)]

    def _choose_steps(self, last: Turn, steps: list[Turn]) -> None:
        """Take vectors on the way as results in place of what only follows from them, as a mean does."""
        new: list[Turn] = [step for step in steps if step not in self.live]
        self.live = [c for c in self.live if c is not last] + new
        self.found.calculations = [*(c for c in self.found.calculations if c is not last), *new]
        self.found.beside.append(last.results)
        self.targets = {p: t for c in self.live for p, t in c.targets.items()}

    def _judged_by_steps(self) -> Iterator[Fault]:
        """Judge the vectors on the way to results that could not be explained, as they may be the results."""
        for last in self.unexplained[:]:
            if steps := [step for step in self._steps_to(last) if step not in self.live]:
                self.unexplained.remove(last)
                self._choose_steps(last, steps)
                yield from chain.from_iterable(map(self._repaired, steps))

    def prepare(self, calculations: Iterable[Turn]) -> None:
        for calculation in calculations:
            calculation.prepare({p: self.now(p) for p in calculation.read}, self.units)

    def _unlike_the_task(self, calculation: Turn) -> Iterator[Fault]:
        """Yield the faults of inputs that are not the numbers that the task gives."""
        for name, other in (("angles", "wrong angle"), ("point", "wrong point"), ("origin", "wrong point")):
            asked = getattr(self.found.task, name) or ()
            for place, wanted in zip(getattr(calculation, name), asked, strict=False):
                unit, number = np.rad2deg(self.units.get(place, np.pi / 180)), self.graph.number(place)
                half, number = 0.6 * 10.0 ** -min(written_decimals(number), 6) * unit + 1e-9, number * unit
                if abs(number - wanted) > half:
                    cause = other if any(abs(number - each) <= half for each in asked) else "wrong value"
                    cause = "sign" if abs(number + wanted) <= half else cause
                    text = f"{self.graph.short(place)} is {number:.6g}, the task says {wanted:.6g}"
                    yield self.fault(place, cause, text, UNLIKE_TASK)

    def _repaired(self, calculation: Turn) -> list[Fault]:
        """Put in the right things, one after the other, until the results are right; return what was wrong."""
        faults: list[Fault] = []
        while bad := self.bad(calculation.targets):
            near = self.graph.downstream(self.graph.upstream(bad))
            targets = {p: t for p, t in self.targets.items() if p in near}
            missed = {p: targets.pop(p) for p in self.bad(targets) if p not in calculation.targets}
            hopeless = len(self.unexplained) >= UNEXPLAINED
            found = None if hopeless else self.where.earliest(calculation, targets, bad, missed)
            if found is None:
                self.unexplained.append(calculation)
                break
            self.put(found[0])
            faults += found[1]
            self.prepare(self.live)  # some may turn what others give
            self.targets = {p: t for c in self.live for p, t in c.targets.items()}
        return _one_convention(faults)

    def typed_number(self, place: Place, tree: Tree | None = None) -> Fault:
        """The fault of a number where a formula belongs, or of a `tree` that has numbers for references."""
        number, short = self.graph.book.cells[place].meant, self.graph.short(place)
        number = self.graph.own[place] if number is None else number
        text = f"{short} is a number, {number:g}, typed where a formula belongs"
        if tree and areas(tree):
            text = f"{short}: {said(place, tree, self.graph.trees[place])}"
        return self.fault(place, "typed over formula", text, TYPED)


def _one_convention(faults: list[Fault]) -> list[Fault]:
    """Faults that are all signs are those of the other convention."""
    text = "the elementary matrices are those of the other convention, active or passive"
    signs = len(faults) >= 6 and {fault.cause for fault in faults} == {"sign"}
    return [replace(f, cause="other convention", message=text) for f in faults] if signs else faults
