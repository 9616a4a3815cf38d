"""Further cells beside a calculation: lengths, distances, sums and means, differences, angles computed back.

No task asks for these. What is equal to something known is right; what breaks the pattern of its neighbours, or is
the one cell that keeps a vector from being known, is wrong; all else is listed.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from mathpost.teaching.workbook.meaning.given import runs
from mathpost.teaching.workbook.report import Fault
from mathpost.teaching.workbook.sheet.edits import INVERSE, edits, said
from mathpost.teaching.workbook.sheet.evaluate import STATISTICS
from mathpost.teaching.workbook.sheet.neighbours import as_around
from mathpost.teaching.workbook.sheet.place import Place
from mathpost.teaching.workbook.sheet.samples import CLOSE, SAMPLES, same
from mathpost.teaching.workbook.sheet.tree import areas, heads, unrounded
from mathpost.teaching.workbook.verdict.blocks import Blocks
from mathpost.teaching.workbook.verdict.known import Known, agree
from mathpost.teaching.workbook.verdict.labels import Labels
from mathpost.teaching.workbook.verdict.pattern import Pattern
from mathpost.teaching.workbook.verdict.scope import Scope

if TYPE_CHECKING:
    from mathpost.teaching.workbook.sheet.formula import Tree
    from mathpost.teaching.workbook.verdict.judge import Judge

MANY = 200  # cells that are nothing known: of more no rule is tried that compares them with each other
BETWEEN = r"[xyz]['’′]?[ –/,-]+[xyz]['’′]|between|zwischen|entre|夹角"
# Why a cell is right.
NUMBER = "it is a number that follows from right results: a length, distance, angle, entry or sum"
CONFIRMED = "a formula of the same form makes the same of the points before they are turned, or after it"
KEPT = "it is made of right results, and at all inputs what a step towards them is: what a turn keeps"
MADE_OF_KNOWN = "it is a sum, mean, extreme, square or difference of right cells of one form"
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
    is right or not judged. `faults` are those that are found here.
    """

    def __init__(self, judge: Judge) -> None:
        self.judge, self.graph, self.found = judge, judge.graph, judge.found
        self.known = Known(judge)
        self.faults: list[Fault] = []
        self.rules: dict[Place, str] = {}
        scope, pattern, labels = Scope(judge), Pattern(judge, self.known), Labels(judge, self.known)
        blocks = Blocks(judge, self.known)
        self.places, rest = scope.places, scope.rest
        unlike_around, unlike_label = set[Place](), set[Place]()
        if not judge.unexplained:
            for each in blocks.matrices(rest):
                unlike_around.update(each if isinstance(each, tuple) else ())
                self._take([each] if isinstance(each, Fault) else ())
            self._take(pattern.faults(rest, {p for w in self.found.windows if rest.issuperset(w) for p in w}))
            unlike_around |= {*pattern.doubts(rest)}
            unlike_label = self._edited(labels.doubts(rest), self._is_length)
        nothing = {p for p in self.places if self._takes_nothing(p, p in rest)}
        vectors, unlike_text = blocks.judged(rest)
        self.rules, rest = vectors, rest - vectors.keys()
        self.faults += blocks.faults
        composed = {p for p in self.found.composed if not (self._is_degrees_and_minutes(p) or self._goes_on(p))}
        composed = self._edited(self.found.sorted(composed), self._is_degrees_and_minutes)
        unknown = self._edited(self.found.sorted(self._unknown(rest - composed)), self._is_angle)
        doubts = [(UNLIKE_AROUND, unlike_around), (UNLIKE_LABEL, unlike_label), (TAKES_NOTHING, nothing)]
        doubts += [(UNLIKE_TEXT, unlike_text), (COMPOSED, composed), (POINT, self._computed_points())]
        doubts += [(NOT_TAKEN, self._shifts_not_taken()), (UNKNOWN, unknown)]
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
                self._take([judge.fault(place, cause, text, {place: judge.calculate(place, tree)})])
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

    def _takes_nothing(self, place: Place, is_rest: bool) -> bool:
        """Whether a formula takes an empty cell, which may hide a slip; or a range, a row of a matrix."""
        tree, there = self.graph.tree(place), self.graph.component.keys()
        ranges = [area.places for area in areas(tree)] if tree[0] != "IF" else []
        if not is_rest:
            return any(len(line) == 1 and line[0] not in self.graph.cells for line in ranges)
        if tree[0] in ("MMULT", "TRANSPOSE"):
            lines = {(n, p[n]) for line in ranges for p in line for n in (1, 2)}
            ranges += [[p for p in line if p[n] == k] for line in ranges for n, k in lines]
        return any(line and there.isdisjoint(line) for line in ranges)

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

    # Single cells.

    def _unknown(self, rest: set[Place]) -> set[Place]:
        """Return the cells of `rest` that no rule tells, each after those that it uses."""
        graph, typed = self.graph, self.found.typed - self.found.composed
        rest = rest - self.found.composed - self.judge.fixed.keys()
        known = {p for p in rest if p not in typed and self.known.is_known(p)}
        self.rules |= dict.fromkeys(known, NUMBER)
        unknown = rest - known
        after, few = unknown & typed, len(unknown) <= MANY
        for place in sorted(graph.trees, key=graph.calculation_order):
            alone = after.isdisjoint(graph.uses[place])  # else it may only follow
            after |= set() if alone and place not in unknown else {place}
            if place in unknown and place not in typed and alone and few and (rule := self._rule(place, unknown)):
                self.rules[place] = rule
                unknown.remove(place)
                after.remove(place)
        return unknown

    def _rule(self, place: Place, unknown: set[Place]) -> str | None:
        """The rule that tells what a cell is that is nothing known, or None."""
        if self._is_confirmed(place, unknown):
            return CONFIRMED
        if self._is_kept(place):
            return KEPT
        return (
            None if self._is_another_angle(place) or not self._is_made_of_known(place, unknown) else MADE_OF_KNOWN
        )

    def _is_made_of_known(self, place: Place, unknown: set[Place]) -> bool:
        """Whether a cell is a sum, mean or extreme of known cells of one form, their square or difference."""
        graph, tree = self.graph, unrounded(self.graph.tree(place))
        tree = tree[1] if tree[0] == "SQRT" else tree
        used = graph.used_by(tree)
        alike = len({*map(graph.form, used)} - {None}) == 1 and all(map(graph.form, used))
        of_one = tree[0] == "^" and tree[1][0] == "area" and tree[2] == ("number", 2.0)
        of_two = tree[0] == "-" and tree[1][0] == tree[2][0] == "area" and len(used) == 2
        if of_two and all(self.known.is_length(self.judge.now(p)) for p in used):
            return same(self.judge.now(place), np.zeros(SAMPLES))  # as of a length that is kept
        of_many = tree[0] in STATISTICS - {"SUMSQ"} and len(tree) == 2 and tree[1][0] == "area" and len(used) > 1
        if heads(tree) in ({"+", "area"}, {"*", "area"}) and alike:
            mates = [p for p in graph.component[used[0]] if graph.form(p) == graph.form(used[0])]
            of_many = tuple(self.found.sorted(used)) in runs(mates)  # of all in a line
        return alike and (of_one or of_two or of_many) and {*self.places} >= set(used) and unknown.isdisjoint(used)

    def _is_confirmed(self, place: Place, unknown: set[Place]) -> bool:
        """Whether it is what a formula of the same form makes of the points before they are turned, or after it."""
        graph, now = self.graph, self.judge.now(place)
        turned = {p for turn in self.known.turns for p in turn.results}
        own = turned.isdisjoint(graph.upstream([place]))
        for other in self.found.sorted(unknown - {place}) if np.ptp(now[1:]) > CLOSE else ():
            alike = graph.form(other) == graph.form(place) and same(self.judge.now(other), now)
            if alike and own != turned.isdisjoint(up := graph.upstream([other])) and up & unknown == {other}:
                unknown.remove(other)
                self.rules[other] = CONFIRMED
                return True
        return False

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

    def _is_another_angle(self, place: Place) -> bool:
        """Whether most angles beside an angle without a name are not known either, as those between two axes."""
        graph = self.graph
        if place not in graph.component or not heads(graph.tree(place)) & INVERSE:
            return False
        if re.search(BETWEEN, self.found.label(place), re.I):
            return True
        near = [p for p in graph.component[place] if heads(graph.tree(p)) & INVERSE]
        named, known = self.found.angle_said(place) is not None, sum(map(self.known.is_known, near))
        return not named and len(near) > 1 and 2 * known < len(near)

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

    def _goes_on(self, place: Place) -> bool:
        """Whether an angle is made of the one before as all around it are, as in a table of steps."""
        mates = {p for p in self.graph.component[place] if p in self.found.turning}
        on = len(mates) > 2 and not mates.isdisjoint(self.graph.uses[place])
        return on and as_around(self.graph, place) == self.graph.trees[place]
