"""Right or wrong: every calculation is compared with what is asked for, and repaired for the next ones."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from itertools import chain
from typing import TYPE_CHECKING, Self

import numpy as np

from mathpost.detective.digits import written_decimals
from mathpost.teaching.workbook.meaning.calculation import Turn
from mathpost.teaching.workbook.meaning.plane_angles import Plane
from mathpost.teaching.workbook.meaning.words import Words
from mathpost.teaching.workbook.report import Fault
from mathpost.teaching.workbook.sheet.edits import repaired, said
from mathpost.teaching.workbook.sheet.graph import Graph
from mathpost.teaching.workbook.sheet.samples import Values, same
from mathpost.teaching.workbook.sheet.tree import areas
from mathpost.teaching.workbook.verdict.readings import Readings
from mathpost.teaching.workbook.verdict.sampled import Sampled
from mathpost.teaching.workbook.verdict.tables import Tables
from mathpost.teaching.workbook.verdict.where import Where
from mathpost.teaching.workbook.verdict.why import Why

if TYPE_CHECKING:
    from mathpost.teaching.workbook.meaning.calculation import Calculation
    from mathpost.teaching.workbook.meaning.recognise import Recognised
    from mathpost.teaching.workbook.sheet.formula import Tree
    from mathpost.teaching.workbook.sheet.place import Place

UNEXPLAINED = 5  # results without a repair: beside so many no further repairs are looked for
# What is found of a wrong cell.
UNLIKE_TASK = "it is an input, and the task gives another number"
UNLIKE = "it is a result, and not what the task asks for at these inputs"
EXCHANGED = "it is a result that is right under the heading of another one"
ALONE = "it is the only cell that keeps a matrix from being one of the rotation"
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
        self.unexplained: list[Calculation] = []
        self.unsure: set[Place] = set()
        self.chained: list[Calculation] = []  # calculations from what another one may give
        self.readings = Readings(self)
        self.why = Why(self)
        self.where = Where(self)

    def fault(self, place: Place, cause: str, message: str, rule: str = "", values: Values | None = None) -> Fault:
        return Fault(self.graph.address(place), cause, message, place, values or {}, rule)

    def run(self) -> Self:
        """Judge every calculation; one that is wrong is repaired, so that the next ones are seen without it."""
        planes = [c for c in self.live if isinstance(c, Plane)]
        self.faults = self._judge_planes(planes)
        self.prepare(self.live)
        tables = Tables(self)
        tables.prepare()
        for calculation in self.live[:]:
            self._drop_if_partial(calculation)
            self._choose(calculation)
        self.readings.read_the_headings()
        self.targets |= {p: t for c in self.live for p, t in c.targets.items()}
        made = self.graph.trees.keys() - self.inputs.keys()
        self.chained = [c for c in self.live if not made.isdisjoint(c.given)]
        for calculation in [c for c in self.found.calculations if c not in planes][:1]:
            self.faults += self._unlike_the_task(calculation)
        self.reading = self.readings.left_open()
        if not self.reading:
            self.faults += self._judge_others([c for c in self.live if c not in planes])
        if others := self.readings.of_another_convention(self.unexplained):
            self.faults, self.unexplained = self.faults + others, []
        self.faults = tables.judged(self.faults)
        return self

    def _judge_planes(self, planes: Sequence[Calculation]) -> list[Fault]:
        """Judge the angles of planes first: what these turn is judged with right ones."""
        self.prepare(planes)
        self.targets = {p: t for plane in planes for p, t in plane.targets.items()}
        faults = [fault for plane in planes for fault in self._repaired(plane)]
        self.readings.choose_the_way([c for c in self.live if isinstance(c, Turn) and c.active is None])
        return faults

    def _judge_others(self, calculations: list[Turn]) -> list[Fault]:
        """Judge each calculation; what turns by the angles of a plane that may be none is not repaired."""
        unsure, faults = {*self.unexplained}, list[Fault]()
        for calculation in calculations:
            of_unsure = getattr(calculation, "plane", None) in unsure or self._is_of_a_table(calculation)
            of_unsure |= len(self.unexplained) >= UNEXPLAINED
            if of_unsure and self.bad(calculation.targets):
                self.unexplained.append(calculation)
            else:
                faults += self._repaired(calculation)
        return faults

    def _is_of_a_table(self, calculation: Calculation) -> bool:
        """Whether another row of its table could not be explained."""
        place = calculation.results[0]
        rows = [c.results[0] for c in self.unexplained]
        same_table = [p for p in rows if self.graph.component[p] is self.graph.component[place]]
        return self.graph.form(place) in {self.graph.form(p) for p in same_table} - {None}

    def prepare(self, calculations: Iterable[Calculation]) -> None:
        for calculation in calculations:
            calculation.prepare({p: self.now(p) for p in calculation.read}, self.units)

    def _unlike_the_task(self, calculation: Calculation) -> Iterator[Fault]:
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

    def _repaired(self, calculation: Calculation) -> list[Fault]:
        """Put in the right things, one after the other, until the results are right; return what was wrong."""
        faults: list[Fault] = []
        after = self.graph.downstream(calculation.targets) if self.chained else set()
        later = [c for c in self.chained if c is not calculation and not after.isdisjoint(c.given)]
        while bad := self.bad(calculation.targets):
            near = self.graph.downstream(self.graph.upstream(bad))
            targets = {p: t for p, t in self.targets.items() if p in near}
            targets = {p: t for p, t in targets.items() if not any(p in c.targets for c in later)}
            missed = {p: targets.pop(p) for p in self.bad(targets) if p not in calculation.targets}
            found = self.where.earliest(calculation, targets, bad, missed) or self._exchanged(calculation)
            strange = not self.graph.upstream(bad).isdisjoint(self.graph.not_evaluated)
            if found is None and not isinstance(calculation, Words):
                self.unexplained.append(calculation)
            elif found is None and isinstance(calculation, Words):
                if strange or not calculation.is_wrong(self.now):
                    self.unsure.update(bad)  # right at these inputs; it may not be made for other tool axes
                else:
                    place = min(bad, key=self.graph.calculation_order)
                    text = "no single change makes the result what is asked for"
                    faults.append(self.fault(place, "wrong value", text, UNLIKE))
                    self.put({p: targets[p] for p in bad})
            if found is None:
                break
            self.put(found[0])
            faults += found[1]
            self.prepare(later)
            self.targets.update(chain.from_iterable(c.targets.items() for c in later))
        return _one_convention(faults)

    def _exchanged(self, calculation: Calculation) -> tuple[Values, list[Fault]] | None:
        """The right values of results that stand under each other's headings, and the fault."""
        results, wanted = calculation.results, [*calculation.targets.values()]
        of_points = isinstance(calculation, Turn) and calculation.point
        if of_points:
            results, wanted = results[:3], wanted[:3]
        headings = [self.found.coordinate(p) if of_points else self.found.label(p) for p in results]
        fits = np.array([[self.met({p: target}) for target in wanted] for p in results])
        is_named = all(headings) and len({*headings}) == len(results) < 5
        if not (is_named and (fits.any(axis=0) & fits.any(axis=1)).all()):
            return None
        k = int(np.argmin(fits.diagonal()))
        into = self.graph.short(results[int(fits[k].argmax())])
        text = f"{self.graph.short(results[k])} is what belongs into {into}: exchanged"
        return dict(zip(results, wanted, strict=True)), [self.fault(results[k], "exchanged", text, EXCHANGED)]

    def _choose(self, last: Calculation) -> None:
        """Take vectors on the way that are right, but for one cell, in place of what only follows from them."""
        steps = self.steps(last)
        self.prepare(steps)
        right = [s for s in steps if len(self.bad(s.targets)) <= 1]
        if right and len(self.bad(last.targets)) > 1:
            before = {p for s in steps for p in self.graph.upstream(s.results) - set(s.results)}
            ends = [s for s in steps if not before.issuperset(s.results)]  # two recipes, of which one is wrong
            right = [s for s in steps if s in right + ends and s not in self.live]
            self.live = [c for c in self.live if c is not last] + right
            self.found.calculations = [c for c in self.found.calculations if c is not last] + right
            self.found.beside.append(last.results)

    def _drop_if_partial(self, calculation: Calculation) -> None:
        """Set aside a vector that only some of the angles turn, if it is a step to another calculation's result."""
        turns = [c for c in self.live if isinstance(c, Turn) and c is not calculation]
        angles, now = self.found.turned_by(calculation.results), self.block(calculation.results[:3])
        partial = self.bad(calculation.targets) and any(angles < self.found.turned_by(c.results) for c in turns)
        if partial and any(same(known, now) for known in calculation.known.get(3, ())):
            self.live.remove(calculation)
            self.found.calculations.remove(calculation)
            self.found.beside.append(calculation.results)

    def steps(self, last: Calculation) -> list[Calculation]:
        """The vectors on the way to a result."""
        if not self.found.steps or not isinstance(last, Turn):
            return []
        up = self.graph.upstream(last.results, last.point) - set(last.point)
        return [s for s in self.found.steps if up.issuperset(s.results)]

    def repaired_alone(self, place: Place, value: np.ndarray) -> Fault | None:
        """The fault of a cell beside the calculations that ought to hold `value`; None if no repair makes it so."""
        wanted = {p: self.now(p) for p in self.graph.array(place)} | {place: value}
        if place in self.graph.trees and (found := repaired(self.graph, wanted, self.values)):
            cause, sentence, other = found
            cause = self.why.reference_kind(place, other) if cause == "wrong reference" else cause
            self.put({place: value})
            return self.fault(place, cause, f"{self.graph.short(place)}: {sentence}", ALONE)
        return None

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
