"""Single cells beside the calculations: numbers that are known, or that one repair makes known."""

from __future__ import annotations

import re
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from mathpost.teaching.workbook.meaning.calculation import SAMPLES
from mathpost.teaching.workbook.meaning.given import runs
from mathpost.teaching.workbook.sheet.edits import INVERSE, edits, repaired, said
from mathpost.teaching.workbook.sheet.evaluate import STATISTICS
from mathpost.teaching.workbook.sheet.formula import Tree
from mathpost.teaching.workbook.sheet.neighbours import as_around
from mathpost.teaching.workbook.sheet.place import beside
from mathpost.teaching.workbook.sheet.samples import CLOSE, same
from mathpost.teaching.workbook.sheet.tree import heads, parts_of, unrounded
from mathpost.teaching.workbook.verdict.known import agree

if TYPE_CHECKING:
    from mathpost.teaching.workbook.report import Fault
    from mathpost.teaching.workbook.sheet.place import Place
    from mathpost.teaching.workbook.verdict.judge import Judge
    from mathpost.teaching.workbook.verdict.known import Known

BETWEEN = r"[xyz]['’′]?[ –/,-]+[xyz]['’′]|between|zwischen|entre|夹角"


MANY = 200  # cells that are nothing known: of more no rule is tried that compares them with each other
KNOWN = "it is a number that follows from right results: a length, distance, angle, entry or sum"
CONFIRMED = "a formula of the same form makes the same of the points before they are turned, or after it"
KEPT = "it is made of right results, and at all inputs what a step towards them is: what a turn keeps"
MADE_OF_KNOWN = "it is a sum, mean, extreme, square or difference of right cells of one form"
REPAIRED = "one repair makes it what it should be"


class BesideNumbers:
    """Judge single cells that no result needs by what is `Known`, and by the cells around them.

    `rules` has what told each.
    """

    def __init__(self, judge: Judge, known: Known, places: list[Place]) -> None:
        self.judge, self.graph, self.found = judge, judge.graph, judge.found
        self.known, self.places = known, places
        self.rules: dict[Place, str] = {}
        self.turns, self.is_known = known.turns, known.is_known

    def composed(self) -> set[Place]:
        """The angles made of other numbers that are none of degrees and minutes; those with a slip are faults."""
        left = {p for p in self.found.composed if not (self._is_degrees_and_minutes(p) or self._goes_on(p))}
        return left - {p for p in self.found.sorted(left) if self._are_wrong_minutes(p)}

    def unknown(self, rest: set[Place]) -> set[Place]:
        """Return the cells of `rest` that no rule tells, each after those that it uses."""
        graph, typed = self.graph, self.found.typed - self.found.composed
        rest = rest - self.found.composed - self.judge.fixed.keys()
        known = {p for p in rest if p not in typed and self.is_known(p)}
        self.rules |= dict.fromkeys(known, KNOWN)
        unknown = rest - known
        after, few = unknown & typed, len(unknown) <= MANY
        for place in sorted(graph.trees, key=graph.calculation_order):
            alone = after.isdisjoint(graph.uses[place])  # else it may only follow
            after |= set() if alone and place not in unknown else {place}
            if place not in unknown or place in typed:
                continue
            rule = KNOWN if self.is_known(place) else self._rule(place, unknown) if alone and few else None
            if rule:
                self.rules[place] = rule
                unknown.remove(place)
                after -= {place} if alone else set()
        return unknown

    def _rule(self, place: Place, unknown: set[Place]) -> str | None:
        """The rule that tells what a cell is that is nothing known, or None."""
        if self._is_confirmed(place, unknown):
            return CONFIRMED
        if self._is_kept(place):
            return KEPT
        if self._is_another_angle(place):
            return None
        if self._is_made_of_known(place, unknown):
            return MADE_OF_KNOWN
        slip = self._is_unlike(place, unknown) or self._is_nearly_known(place)
        return REPAIRED if slip or self._completes_a_vector(place, unknown) else None

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
        turned = {p for turn in self.turns for p in turn.results}
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
        of_results = any(up.issuperset(turn.results) for turn in self.turns)
        return of_results and np.ptp(now[1:]) > CLOSE and bool(agree(now, self._steps).any())

    @cached_property
    def _steps(self) -> np.ndarray:
        """The values of the formulas that results need and that need none, shape (steps, samples)."""
        graph, results = self.graph, [p for turn in self.turns for p in turn.results]
        steps = graph.upstream(results) & graph.trees.keys() - graph.downstream(results)
        return np.array([self.judge.now(p) for p in self.found.sorted(steps)]).reshape(-1, SAMPLES)

    def _is_unlike(self, place: Place, unknown: set[Place]) -> bool:
        """Whether a wrong reference keeps a cell from what one beside it is, as a length that is kept: a fault."""
        graph, judge = self.graph, self.judge
        if place not in graph.trees:
            return False
        form = [part[0] for part in parts_of(graph.tree(place))]
        chain = not set(beside(place)).isdisjoint(graph.uses.get(place, ()))  # as a sum that goes on
        for near in beside(place) if not (judge.unexplained or chain) else ():
            wanted, like = judge.now(near), [part[0] for part in parts_of(graph.tree(near))]
            alike = [p for p in graph.component[place] if graph.form(p) == graph.form(near)]
            once = np.ptp(wanted) <= CLOSE and sum(same(judge.now(p), wanted) for p in alike) < 2
            once |= not wanted.any()
            if near in unknown or like != form or once:
                continue
            cause, _, other = repaired(graph, {place: wanted}, judge.values) or (None, "", ("text", ""))
            meant = cause == "wrong reference" and graph.component.keys() >= set(graph.used_by(other))
            if meant and judge.why.reference_kind(place, other) == cause:
                judge.faults += filter(None, [judge.repaired_alone(place, wanted)])
                return True
        return False

    def _is_another_angle(self, place: Place) -> bool:
        """Whether most angles beside an angle without a name are not known either, as those between two axes."""
        graph = self.graph
        if place not in graph.component or not heads(graph.tree(place)) & INVERSE:
            return False
        if re.search(BETWEEN, self.found.label(place), re.I):
            return True
        near = [p for p in graph.component[place] if heads(graph.tree(p)) & INVERSE]
        named, known = self.found.angle_said(place) is not None, sum(map(self.is_known, near))
        return not named and len(near) > 1 and 2 * known < len(near)

    def _completes_a_vector(self, place: Place, unknown: set[Place]) -> bool:
        """Whether one repair makes a cell, with two known ones in line, a known vector, which is a fault then."""
        graph, judge = self.graph, self.judge
        whole = [run for run in runs(graph.component[place]) if place in run and not judge.unexplained]
        for line in (run[n : n + 3] for run in whole for n in range(len(run) - 2)):
            others = set(line) - {place}
            if len(others) == 2 and graph.trees.keys() >= others and unknown.isdisjoint(others):
                fits, k = agree(judge.block(line), self.known.vectors), line.index(place)
                for n in np.flatnonzero((fits.sum(axis=-1) == 2) & ~fits[:, k])[:1]:
                    if fault := judge.repaired_alone(place, self.known.vectors[n, k]):
                        judge.faults.append(fault)
                        return True
        return False

    def _is_nearly_known(self, place: Place) -> bool:
        """Whether one repair makes a cell an angle computed back, or a determinant of 1, which is a fault then."""
        is_angle, many = heads(self.graph.tree(place)) & INVERSE, len(self.graph.uses.get(place, ())) > 5
        tried = edits(self.graph, place) if (is_angle or many) and not self.judge.unexplained else ()
        for cause, old, new, tree in tried:
            value = self.judge.calculate(place, tree)
            known = heads(tree) & INVERSE and self.is_known(place, tree) if is_angle else None
            known = known and np.ptp(value[1:]) > CLOSE
            if known or (known is None and same(value, np.ones(SAMPLES))):
                self.judge.put({place: value})
                self.judge.faults.append(self._fault(place, cause, old, new))
                return True
        return False

    def _are_wrong_minutes(self, place: Place) -> bool:
        """Whether one repair makes a cell an angle of degrees and minutes, which is a fault then."""
        for cause, old, new, tree in edits(self.graph, place) if self._parts(place) else ():
            if self._is_degrees_and_minutes(place, tree):
                self.judge.faults.append(self._fault(place, cause, old, new))
                return True
        return False

    def _is_degrees_and_minutes(self, place: Place, tree: Tree | None = None) -> bool:
        """Whether a cell makes an angle of degrees and minutes, and seconds, of the sign of the degrees."""
        parts = self._parts(place)
        if not parts:
            return False
        sign = -1 if self.graph.number(parts[0]) < 0 else 1
        numbers, whole = np.array([[sign * 35.0], [20.0], [48.0]]), (35, 35 + 20 / 60, 35 + 20 / 60 + 48 / 3600)
        made = self.graph.cell(place, dict(zip(parts, numbers, strict=False)), tree)
        wanted = [unit * sign * whole[len(parts) - 1] for unit in (1, np.pi / 180)]
        return any(same(made, np.array([each])) for each in wanted)

    def _parts(self, place: Place) -> list[Place]:
        """The numbers that may be the degrees, minutes and seconds of an angle: two or three in line, or none."""
        parts = [p for p in self.found.sorted(self.graph.uses[place]) if self.graph.own.get(p) is not None]
        in_line = 1 in (len({p[1] for p in parts}), len({p[2] for p in parts}))
        return parts if in_line and len(parts) in (2, 3) else []

    def _goes_on(self, place: Place) -> bool:
        """Whether an angle is made of the one before as all around it are, as in a table of steps."""
        mates = {p for p in self.graph.component[place] if p in self.found.turning}
        on = len(mates) > 2 and not mates.isdisjoint(self.graph.uses[place])
        return on and as_around(self.graph, place) == self.graph.trees[place]

    def _fault(self, place: Place, cause: str, old: Tree, new: Tree) -> Fault:
        return self.judge.fault(place, cause, f"{self.graph.short(place)}: {said(place, old, new)}")
