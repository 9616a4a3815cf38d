"""What stands beside a calculation: lengths, distances, sums and means, differences, angles computed back.

No task asks for these. Each is judged as what it is: one of the numbers and vectors that follow from right results.
"""

import re
from collections import Counter
from functools import cached_property

import numpy as np

from mathpost.detective.misreadings import written_decimals
from mathpost.workbook.meaning.calculation import SAMPLES
from mathpost.workbook.meaning.given import runs
from mathpost.workbook.meaning.recognise import MIRRORED
from mathpost.workbook.sheet.edits import INVERSE, edits, repaired, said
from mathpost.workbook.sheet.evaluate import STATISTICS
from mathpost.workbook.sheet.neighbours import as_around
from mathpost.workbook.sheet.place import beside
from mathpost.workbook.sheet.samples import CLOSE, at, same
from mathpost.workbook.sheet.tree import areas, heads, parts_of, unrounded
from mathpost.workbook.verdict.around import Around
from mathpost.workbook.verdict.known import Known, agree
from mathpost.workbook.verdict.labelled import Labelled
from mathpost.workbook.verdict.values import CALCULATED
from mathpost.workbook.verdict.why import TRANSPOSED

# What stands beside such a word is made of others.
MANY = 200  # cells that are nothing known: of more no rule is tried that compares them with each other
COMPARED = r"max|diff|error|fehler|abweich|差|Δ|\||norm|betrag|\bdet|abstand|distan|距离"
LENGTH_OR_VOLUME = r"\|.*\||\bnorme?\b|betrag|模长|\bdet|行列式"
EXPECTED = r"soll|should|expect|target|limit|grenz|toler|允许|公差|理论|应为|given|gegeben"
BETWEEN = r"[xyz]['’′]?[ –/,-]+[xyz]['’′]|between|zwischen|entre|夹角"


class Beside:
    """Judge what is left once a `Judge` has judged the calculations.

    `places` are all cells to judge, `unjudged` those that could not be: no result needs them, and they are nothing
    that is known. A vector with a single wrong cell is added to the judge's faults.
    """

    def __init__(self, judge):
        self.judge, self.graph, self.found = judge, judge.graph, judge.found
        self.known, self.tried = Known(judge), set()
        self.turns, self.is_known = self.known.turns, self.known.is_known
        self.places, rest = self._scope()
        before = len(judge.faults)
        self.around, labelled = Around(judge, self.known), Labelled(judge, self.known)
        for each in (self.around, labelled) if not judge.unexplained else ():
            judge.faults += each.faults(rest)
        self.doubtful = self.around.doubtful | labelled.doubtful | set(filter(self.known.takes_nothing, rest))
        self.doubtful |= set(filter(self._takes_an_empty_cell, self.places))
        rest -= self._judge_vectors(rest)
        judge.faults += labelled.compared(rest)
        composed = {p for p in self.found.composed if not (self._is_degrees_and_minutes(p) or self._goes_on(p))}
        composed -= {p for p in judge.found.sorted(composed) if self._are_wrong_minutes(p)}
        typed = self.found.typed - self.found.composed
        unknown = {p for p in rest - self.found.composed - judge.fixed.keys() if p in typed or not self.is_known(p)}
        after, many = unknown & typed, len(unknown) > MANY
        for place in sorted(judge.graph.trees, key=judge.graph.calculation_order):
            alone = after.isdisjoint(judge.graph.uses[place])  # else it may only follow
            after |= set() if alone and place not in unknown else {place}
            if place not in unknown or place in typed:
                continue
            told = self.is_known(place) or (alone and not many and self._is_confirmed(place, unknown))
            told = told or (
                alone
                and not many
                and not self._is_another_angle(place)
                and (
                    self._is_made_of_known(place, unknown)
                    or self._is_unlike(place, unknown)
                    or self._is_nearly_known(place)
                    or self._completes_a_vector(place, unknown)
                )
            )
            unknown -= {place} if told else set()
            after -= {place} if told and alone else set()
        own = judge.faults[before:]
        judge.faults[before:] = sorted(own, key=lambda fault: self.graph.calculation_order(fault.place))
        self.unjudged = unknown | self.doubtful | composed | self._computed_points()

    def _takes_an_empty_cell(self, place):
        """Whether a formula takes a cell in which nothing is: a constant that is 0 may hide that it is a slip."""
        graph, tree = self.graph, self.graph.tree(place)
        single = [area.places[0] for area in areas(tree) if area.shape == (1, 1)] if tree[0] != "IF" else []
        return not graph.cells.keys() >= set(single)

    def _scope(self):
        """The cells to judge, and those of them that no result needs."""
        judge, graph, found = self.judge, self.graph, self.found
        messages = (
            graph.messages
            | self._marks()
            | ({p for c in judge.live for p in c.aside} - graph.downstream(judge.inputs))
        )
        formulas = [p for p in graph.trees if p not in found.typed - found.composed] + [*graph.unread]
        # A number of many digits, or 0, that only messages use was a formula; another is their tolerance.
        typed = found.typed - graph.trees.keys()
        unused = {p for p in typed - graph.used.keys() if self._looks_calculated(p)}
        unused |= {p for p in typed - graph.used.keys() if found.planes and judge.vectors_of(p)}
        typed = {p for p in typed if messages.issuperset(graph.used.get(p, "-"))}
        typed = {p for p in typed if float(f"{graph.value(p):.2g}") != graph.value(p) or graph.value(p) == 0}
        results = np.array([target[0] for target in judge.targets.values()])
        typed = {p for p in typed if not (np.abs(results - graph.value(p)) <= _half_digit(graph.value(p))).any()}
        typed |= unused
        places = [p for p in formulas if p not in messages] + sorted(typed, key=graph.reading_order)
        results = (p for c in found.calculations if c not in judge.unexplained for p in c.results)
        rest = set(places) - (graph.upstream(results, judge.inputs) - judge.inputs.keys()) | judge.unsure
        given = graph.upstream(p for c in found.calculations for p in (*c.given, *c.results))
        from_given, from_any = (graph.downstream(p - graph.trees.keys()) for p in (given, graph.cells.keys()))
        # The numbers of points, 1, 2, 3, copied beside what became of them.
        copies = rest - graph.used.keys() - from_given
        copies = {p for p in copies if graph.tree(p)[0] == "area"}
        own = {p: graph.own[p] for p in copies if graph.own[p] is not None}
        other = {p for p in own for q in beside(p) if q in own and abs(own[q] - own[p]) == 1}
        given |= {p for c in {id(c): c for c in map(graph.component.get, given) if c}.values() for p in c}
        from_given = graph.downstream(given - graph.trees.keys())  # and what stands beside it
        other |= {p for p in rest & from_any - from_given if _is_count_or_mean(graph.tree(p))}
        return [p for p in places if p not in other], rest - other

    def _looks_calculated(self, place):
        """Whether a number that no formula uses has a label, or decimals, of what nobody gives."""
        label, number = self.found.label(place), self.graph.own[place]
        if re.search(EXPECTED, label, re.I):
            return False
        many = float(f"{number:.2g}") != number or number == 0
        named = re.search(LENGTH_OR_VOLUME, label, re.I) or (many and re.search(COMPARED, label, re.I))
        alone = self._typed_in[id(self.graph.component[place])] < 3
        return bool(named) or (alone and written_decimals(number) >= CALCULATED)

    @cached_property
    def _typed_in(self):
        """How many typed numbers each component has."""
        component = self.graph.component
        return Counter(id(component[p]) for p in self.found.typed if p in component)

    def _marks(self):
        """Formulas that give one of some numbers, as points for a right answer, or sum such up: messages."""
        graph, typed, found, marks = self.graph, self.found.typed - self.graph.trees.keys(), set(), set()
        for place in graph.order:
            uses = set(graph.uses[place])
            if _is_a_choice(graph.trees[place]) or (uses & found and found | typed >= uses):
                found.add(place)
        for place in graph.order[::-1]:  # no number of a calculation
            if place in found and marks | graph.messages >= set(graph.used.get(place, ())):
                marks.add(place)
        return marks

    def _computed_points(self):
        """Formulas that make points or origins of other numbers, which the task does not say; but for means."""
        graph, judge = self.graph, self.judge
        points = {places for turn in self.turns for places in (turn.point, turn.origin)} - {()}
        points = [p for p in points if not any(same(judge.block(p), known) for known in self.known.combined)]
        up = graph.upstream((p for places in points for p in places), judge.targets)
        up -= judge.targets.keys() | judge.inputs.keys()
        return {p for p in up & graph.trees.keys() if graph.trees[p][0] != "area" and graph.uses[p]}

    def _judge_vectors(self, rest):
        """Return the cells of known vectors; a vector with a single wrong cell becomes a fault."""
        judged, judge = set(), self.judge
        lines = [line for line in runs(rest) if len(line) in (3, 4, 5)] * (not judge.unexplained)
        others = [line[n : n + 3] for line in lines for n in range(len(line) - 2)]
        others = [line for line in others if line not in self.found.beside]
        first = sorted(self.found.beside, key=lambda line: self.graph.calculation_order(line[0]))
        for triple in (*first, *others):
            if not rest.issuperset(triple[:3]) or judged.intersection(triple):
                continue
            fits = agree(judge.block(triple[:3]), self.known.vectors)
            copies = self._is_of_signed_copies(triple[:3])
            if fits.all(axis=-1).any() or copies:
                judged.update(triple)
                is_said = re.search(MIRRORED, self.found.heading(triple), re.I)
                plain = is_said and all(self.graph.tree(p)[0] == "area" for p in triple[:3])
                self.doubtful.update(triple if plain or (copies and not is_said) else ())
                self.doubtful.update(triple if self._is_of_another_row(triple[:3]) else ())
                continue
            nonzero = (np.abs(self.known.vectors[..., 1:]) > CLOSE).any(axis=-1)
            for n in np.flatnonzero((fits.sum(axis=-1) == 2) & (fits & nonzero).any(axis=-1))[:1]:
                (k,) = np.flatnonzero(~fits[n])
                known = triple in others and self.is_known(triple[k])
                place, wanted, fault = triple[k], self.known.vectors[n, k], None
                if not known:
                    before = None if judge.unexplained else self._repaired_before({place: wanted}, rest)
                    fault = before or judge.repaired_alone(place, wanted)
                if fault:
                    judge.faults.append(fault)
                    judged.update(triple)
            if (
                judged.isdisjoint(triple)
                and not judge.unexplained
                and (self._is_turned_back(triple[:3], rest) or self._has_one_slip(triple[:3]))
            ):
                judged.update(triple)
        return judged

    def _is_of_signed_copies(self, triple):
        """Whether a vector is a known one, some of its coordinates with a minus, as in a mirror."""
        trees = [self.graph.tree(p) for p in triple]
        plain = [tree[1] if tree[0] == "minus" else tree for tree in trees]
        fits = agree(np.abs(self.judge.block(triple)), np.abs(self.known.vectors))
        return trees != plain and all(part[0] == "area" for part in plain) and bool(fits.all(axis=-1).any())

    def _is_of_another_row(self, triple):
        """Whether a vector, calculated in the row of a table, is the point or result of another row only."""
        rows, ends = self._ends
        if triple[0][:2] not in rows or all(self.graph.tree(p)[0] == "area" for p in triple):
            return False
        fits = agree(self.judge.block(triple), ends).all(axis=-1)
        own = np.array([row == triple[0][:2] for row in rows])
        return len(rows) > 4 and bool(fits[~own].any()) and not fits[own].any()

    @cached_property
    def _ends(self):
        """The row, as sheet and number, and the values of every point that is turned, and of what becomes of it."""
        turns = [turn for turn in self.turns if turn.point and len(turn.results) == 3]
        rows = [turn.results[0][:2] for turn in turns]
        ends = [(self.judge.block(turn.point), np.array([*turn.targets.values()])) for turn in turns]
        return [row for row in rows for _ in (0, 1)], np.array([end for both in ends for end in both])

    def _repaired_before(self, wanted, rest):
        """The fault of an earlier cell of `rest`, nothing known, if one repair of it makes all `wanted` right."""
        graph, judge = self.graph, self.judge
        earlier = graph.upstream(wanted) & rest & graph.trees.keys() - wanted.keys() - self.tried
        for first in sorted(earlier, key=graph.calculation_order):
            if first in self.tried or self.is_known(first):
                continue
            array = graph.array(first)
            self.tried.update(array)  # what does not make these right is not the cause of others either
            for cause, old, new, tree in edits(graph, first):
                made = graph.calculate(tree, judge.values)
                option = {p: np.broadcast_to(at(made, graph.part.get(p, (0, 0))), SAMPLES) for p in array}
                values = judge.values_with(option)
                if all(same(values.get(p, np.nan), value) for p, value in wanted.items()):
                    judge.put(option)
                    return self._fault(min(array, key=graph.reading_order), cause, old, new)
        return None

    def _fault(self, place, cause, old, new):
        return self.judge.fault(place, cause, f"{self.graph.short(place)}: {said(place, old, new)}")

    def _is_turned_back(self, triple, rest):
        """Whether a result is turned back, to the point, by a matrix with a slip, or that should be transposed."""
        up, judge = self.graph.upstream(triple), self.judge
        for turn in self.turns:
            if not turn.point or not up.issuperset(turn.results):
                continue
            option = dict(zip(triple, judge.block(turn.point), strict=True))
            if fault := self._repaired_before(option, rest):
                judge.faults.append(fault)
                return True
            wrong = [p for p, value in option.items() if not same(judge.now(p), value)]
            if len(wrong) == 1:
                judge.put(option)
                text = f"{self.graph.short(wrong[0])} does not lead back to the point, as the two others do"
                judge.faults.append(judge.fault(wrong[0], "wrong value", text))
                return True
            for window in (w for w in self.found.windows if len(w) == 9 and (up & rest).issuperset(w)):
                other = judge.block(window).reshape(3, 3, -1).swapaxes(0, 1).reshape(9, -1)
                other = {p: new for p, new in zip(window, other, strict=True) if not same(judge.now(p), new)}
                values = judge.values_with(other)
                if all(same(values[p], value) for p, value in option.items()):
                    judge.put(other)
                    judge.faults += [judge.fault(p, *TRANSPOSED) for p in other]
                    return True
            if block := judge.why.of_the_block(turn, triple, option):
                judge.put(option)
                judge.faults += [judge.fault(p, *block[:2]) for p in triple]
                return True
        return False

    def _has_one_slip(self, triple):
        """Whether one slip in all three cells keeps them from a sum, mean or difference of points: three faults."""
        points = {p for turn in self.turns for p in (*turn.point, *turn.results)}
        of_points = not points.isdisjoint(self.graph.upstream(triple))
        if self.judge.unexplained or not of_points or any(map(self.is_known, triple)):
            return False
        judge, tried, combined = self.judge, [], self.known.combined
        fits = (np.ptp(combined[..., 1:], axis=-1) > CLOSE).all(axis=-1)  # no zeros, as of two that are equal
        for k, place in enumerate(triple):
            repairs = [*edits(self.graph, place)] if place in self.graph.trees else []
            repairs = [each for each in repairs if self.graph.component.keys() >= {*self.graph.used_by(each[3])}]
            own, part = areas(self.graph.tree(place)), self.around.is_of_a_part(place)
            wholes = [] if part else [[self.around.whole(area, place) for area in own]]
            sizes = [area.shape for area in own]
            repairs = [e for e in repairs if areas(e[3]) in wholes or [a.shape for a in areas(e[3])] == sizes]
            made = np.array([judge.calculate(place, tree) for *_, tree in repairs]).reshape(-1, 1, SAMPLES)
            tried.append((repairs, agree(made, combined[:, k])))
            fits &= tried[-1][1].any(axis=0)
        for n in np.flatnonzero(fits)[:1]:
            found = [repairs[int(good[:, n].argmax())] for repairs, good in tried]
            if len({cause for cause, *_ in found}) == 1:
                judge.put(dict(zip(triple, combined[n], strict=True)))
                for place, (cause, old, new, _) in zip(triple, found, strict=True):
                    judge.faults.append(self._fault(place, cause, old, new))
                return True
        return False

    def _is_made_of_known(self, place, unknown):
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

    def _is_confirmed(self, place, unknown):
        """Whether it is what a formula of the same form makes of the points before they are turned, or after it."""
        graph, now = self.graph, self.judge.now(place)
        turned = {p for turn in self.turns for p in turn.results}
        own = turned.isdisjoint(graph.upstream([place]))
        for other in self.found.sorted(unknown - {place}) if np.ptp(now[1:]) > CLOSE else ():
            alike = graph.form(other) == graph.form(place) and same(self.judge.now(other), now)
            if alike and own != turned.isdisjoint(up := graph.upstream([other])) and up & unknown == {other}:
                unknown.remove(other)
                return True
        return False

    def _is_unlike(self, place, unknown):
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

    def _is_another_angle(self, place):
        """Whether most angles beside an angle without a name are not known either, as those between two axes."""
        near = [p for p in self.graph.component.get(place, ()) if heads(self.graph.tree(p)) & INVERSE]
        if place in near and re.search(BETWEEN, self.found.label(place), re.I):
            return True
        named = self.found.angle_said(place) is not None
        known = sum(map(self.is_known, near))
        return place in near and not named and len(near) > 1 and 2 * known < len(near)

    def _completes_a_vector(self, place, unknown):
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

    def _is_nearly_known(self, place):
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

    def _are_wrong_minutes(self, place):
        """Whether one repair makes a cell an angle of degrees and minutes, which is a fault then."""
        for cause, old, new, tree in edits(self.graph, place):
            if self._is_degrees_and_minutes(place, tree):
                self.judge.faults.append(self._fault(place, cause, old, new))
                return True
        return False

    def _is_degrees_and_minutes(self, place, tree=None):
        """Whether a cell makes an angle of degrees and minutes, and seconds, of the sign of the degrees."""
        parts = [p for p in self.found.sorted(self.graph.uses[place]) if self.graph.own.get(p) is not None]
        if len(parts) not in (2, 3):
            return False
        sign = -1 if self.graph.own[parts[0]] < 0 else 1
        numbers, whole = np.array([[sign * 35.0], [20.0], [48.0]]), (35, 35 + 20 / 60, 35 + 20 / 60 + 48 / 3600)
        made = self.graph.cell(place, dict(zip(parts, numbers, strict=False)), tree)
        in_line = 1 in (len({p[1] for p in parts}), len({p[2] for p in parts}))
        wanted = [unit * sign * whole[len(parts) - 1] for unit in (1, np.pi / 180)]
        return in_line and any(same(made, np.array([each])) for each in wanted)

    def _goes_on(self, place):
        """Whether an angle is made of the one before as all around it are, as in a table of steps."""
        mates = {p for p in self.graph.component[place] if p in self.found.turning}
        on = len(mates) > 2 and not mates.isdisjoint(self.graph.uses[place])
        return on and as_around(self.graph, place) == self.graph.trees[place]


def _is_a_choice(tree):
    """Whether a formula is an IF of which all results are numbers or texts, not all the same."""
    if tree[0] != "IF":
        return False
    return all(part[0] in ("number", "text") or _is_a_choice(part) for part in tree[2:])


def _is_count_or_mean(tree):
    """Whether a formula only counts on, or sums up: no calculation of this field is made of such alone."""
    return heads(tree) <= {*STATISTICS, "area", "number", "+", "-"} and len(areas(tree)) == 1


def _half_digit(number):
    return 0.51 * 10.0 ** -written_decimals(number) if number else 1e-6
