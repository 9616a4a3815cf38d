"""Right or wrong, and where: the earliest place where putting in the right thing makes all that follows right."""

import re
from dataclasses import replace
from itertools import chain, groupby, islice

import numpy as np

from mathpost import angles as euler
from mathpost.detective.misreadings import written_decimals
from mathpost.errors import InputError
from mathpost.rotation import wrap
from mathpost.workbook.calculation import LARGEST_RADIANS, Calculation, Turn
from mathpost.workbook.edits import CONVERSIONS, TO_DEGREES, TO_RADIANS, edits, repaired, said
from mathpost.workbook.file import EMPTY
from mathpost.workbook.formula import COMPARISONS, ROUNDING, areas, heads, walk
from mathpost.workbook.graph import SAMPLES, Graph, offset, same
from mathpost.workbook.nc_table import Words, judge_numbers
from mathpost.workbook.plane_angles import Plane
from mathpost.workbook.report import Fault
from mathpost.workbook.values import read_labels
from mathpost.workbook.why import UNEXPLAINED, Why

MOST = 1e5  # mm: no more is a limit
TURNING = {"SIN", "COS", "TAN"}
IN_RADIANS = r"(?<![a-z])rad(?:ian[st]?)?(?![a-z])|弧度|bogenma"
NAMED_UNITS = {"rad": 1.0, "gon": np.pi / 200, "deg": np.pi / 180, "°": np.pi / 180, "grad": np.pi / 180}


class Judge:
    """Evaluate a recognised workbook at random inputs, compare, repair.

    After `run`, `faults` are the wrong cells in order, `fixed` says what was put in where, and `reading` names the
    sequence and convention of a sheet that is of other axes than those that were asked for without a word.
    """

    def __init__(self, graph, found):
        self.graph, self.found, self.inputs, self.units = graph, found, {}, {}
        self.faults, self.fixed, self.reading, self.unexplained, self.unsure = [], {}, None, [], set()
        self.chained = []  # calculations from what another one may give
        self.live = [c for c in found.calculations if not c.typed]
        self.periods = {p: period for c in self.live for p, period in c.periods.items()}
        base = graph.run({})
        for angles in dict.fromkeys(c.angles for c in (*self.live, *found.steps)):
            self._set_units(angles, base)
        spare = [] if found.task.machine else [Calculation((), tuple(found.angles), tuple(found.lengths))]
        rng = np.random.default_rng(20)
        wide = self._wide()
        for calculation in (*spare, *self.live):
            drawn = calculation.draw(rng, self.units)
            drawn |= {p: wide * drawn[p] for p in found.lengths.intersection(drawn) - {*calculation.axis}}
            self.inputs.update({p: drawn[p] for p in drawn if p in found.typed or p not in graph.trees})
        for place, numbers in self.inputs.items():
            if self.graph.own.get(place) is None:
                where = f"{self.graph.book.path}, {self.graph.address(place)}"
                raise InputError(where, "a number", repr(self.graph.cells.get(place, EMPTY).value))
            numbers[0] = self.graph.own[place]
        for calculation in self.live:
            calculation.unround(self.inputs)
        self.values = self._run()
        self.why = Why(self)

    def _wide(self):
        """How much longer lengths must be for some to be beyond the limits that formulas set, as IF(B8>100,…)."""
        limiting = [part for _, part in self.graph.parts if part[0] in {*COMPARISONS, "MIN", "MAX"}]
        limits = [abs(inner[1]) for part in limiting for _, inner in walk(part) if inner[0] == "number"]
        return max([1.0, *(limit / 20 for limit in limits if limit < MOST)])

    def _set_units(self, places, base):
        """Degrees, radians or gon: whole turns of which unit leave more sines and cosines as they are.

        Angles of one calculation are in one unit, but for formulas such as =RADIANS(20).
        """
        unit, agreed = self._unit(places, base)
        self.units.update(dict.fromkeys(places, unit))
        for place in () if agreed else places:
            own, agreed = self._unit((place,), base)
            said = self.graph.cells.get(offset(place, 0, 1), EMPTY).value  # "gon", "rad" beside it
            said = NAMED_UNITS.get(str(said).strip().lower())
            said = 1.0 if re.search(IN_RADIANS, self.found.label(place), re.I) else said
            is_own = agreed and (own == said or (own == 1.0 and place in self.graph.trees))
            self.units.update({place: own} if is_own else {})

    def _unit(self, places, base):
        """The unit in radians, and whether all sines and cosines that use the places say so."""
        own, votes, every = {p: np.array([self.graph.own[p] + 0.3]) for p in places}, np.zeros(3), 0
        still = self.graph.run(own, base, self.graph.downstream(places))
        for place in places:
            moved = self.graph.downstream([place])
            after = [p for p in moved if heads(self.graph.tree(p)) & {"SIN", "COS"}]
            every += len(after)
            for k, turn in enumerate((720, 4 * np.pi, 800)):  # half angles turn half as fast
                run = self.graph.run({place: own[place] + turn}, still, moved)
                votes[k] += sum(same(run[p], still[p], 1e-9) for p in after)
        beyond = any(abs(number) > LARGEST_RADIANS for number in own.values())
        unit = np.pi / 200 if votes[2] > max(votes[:2]) else np.pi / 180 if votes[0] > votes[1] or beyond else 1.0
        return unit, max(votes) == every

    def now(self, place):
        """What is in a cell at the samples."""
        value = self.graph.value(place)
        return np.broadcast_to(self.values.get(place, np.nan if value is None else value), SAMPLES)

    def block(self, places, option=()):
        """What is in some cells, or what `option` puts there, shape (cells, samples)."""
        return np.array([option[p] if p in option else self.now(p) for p in places])

    def bad(self, targets):
        """The targets that are missed now."""
        return [place for place, target in targets.items() if not self.met({place: target})]

    def met(self, targets, values=()):
        """Whether all targets are met, now or with other values; those of `periods` but for whole turns."""
        for place, target in targets.items():
            now, period = values[place] if place in values else self.now(place), self.periods.get(place)
            if not same(target + wrap(now - target, period) if period else now, target):
                return False
        return True

    def _run(self, more=(), only=None):
        """The values with all that was put in, and `more`."""
        return self.graph.run({**self.inputs, **self.fixed, **dict(more)}, only and self.values, only)

    def values_with(self, option):
        """The values with `option` put in, for once."""
        return self._run(option, self.graph.downstream(option))

    def put(self, option):
        """Put values into some places, for good."""
        self.fixed.update(option)
        self.values = self._run(only=self.graph.downstream(option))

    def calculate(self, place, tree):
        """What a cell would hold with another formula."""
        return np.broadcast_to(self.graph.cell(place, self.values, tree), SAMPLES)

    def fault(self, place, cause, message):
        return Fault(self.graph.address(place), cause, message, place)

    # The verdict.

    def run(self):
        """Judge every calculation; one that is wrong is repaired, so that the next ones are seen without it."""
        planes = [c for c in self.live if isinstance(c, Plane)]
        self._prepare(planes)
        self.targets = {p: t for plane in planes for p, t in plane.targets.items()}
        for plane in planes:  # what their angles turn is judged with right ones
            self._repair(plane, {})
        self._choose_the_way([c for c in self.live if isinstance(c, Turn) and c.active is None])
        self._prepare(self.live)
        rows = [row for row in self.live if isinstance(row, Words)]
        for row in rows:  # once more, on the branch that the table is on
            row.preferred = int(np.argmax(sum(r.votes for r in rows if r.table == row.table)))
        self._prepare(rows)
        for calculation in self.live[:]:
            self._drop_if_partial(calculation)
            self._choose(calculation)
        self.targets |= {p: t for c in self.live for p, t in c.targets.items()}
        made = self.graph.trees.keys() - self.inputs.keys()
        self.chained = [c for c in self.live if not made.isdisjoint(c.given)]
        for calculation in [c for c in self.found.calculations if c not in planes][:1]:
            self._compare_the_inputs(calculation)
        said = self._as_the_labels_say() if not self.met(self.targets) else {}
        if not (said or self.met(self.targets)) and self.found.by == "source 000":
            self.reading = self._other_reading(self.live, euler.SEQUENCES[1:])
            as_asked = self.found.sequence, "active" if self.found.active else "passive"
            self.reading = None if self.reading == as_asked else self.reading
        unsure = {*self.unexplained}  # what turns by the angles of a plane that may be none is not repaired
        for calculation in () if self.reading else [c for c in self.live if c not in planes]:
            of_unsure = getattr(calculation, "plane", None) in unsure or self._is_of_a_table(calculation)
            if of_unsure and self.bad(calculation.targets):
                self.unexplained.append(calculation)
                continue
            self._repair(calculation, said)
        for calculation in self.unexplained[:]:
            self._as_a_mistake(calculation)
        for calculation in self.unexplained[:]:
            self._by_a_step(calculation)
        if self.found.by == "the task" and (other := self._other_reading(self.unexplained, euler.SEQUENCES)):
            text = f"it is {' '.join(other)}, and {self.found.calculations[0].said} is asked for"
            for calculation in self.unexplained:
                self.faults.append(self.fault(calculation.results[0], "other convention", text))
            self.unexplained = []
        for _, table in groupby((row for row in self.found.calculations if row.typed), lambda row: row.table):
            for place, cause, message in judge_numbers(list(table), self.graph.own):
                self.faults.append(self.fault(place, cause, f"{self.graph.short(place)}: {message}"))
        errors = {p for row in rows for p in row.results if p in self.graph.trees and np.isnan(self.graph.own[p])}
        errors -= self.graph.downstream([*self.graph.not_evaluated, *(fault.place for fault in self.faults)])
        for place in (p for p in errors if self.graph.upstream([p]) & errors == {p}):
            text = f"{self.graph.short(place)} gives no number at this tool axis"
            self.faults.append(self.fault(place, "wrong value", text))
        return self

    def _is_of_a_table(self, calculation):
        """Whether another row of its table could not be explained."""
        place = calculation.results[0]
        rows = [c.results[0] for c in self.unexplained]
        same_table = [p for p in rows if self.graph.component[p] is self.graph.component[place]]
        return self.graph.form(place) in {self.graph.form(p) for p in same_table} - {None}

    def _choose_the_way(self, turns):
        """Take points into their plane or out of it, whichever more of them are."""
        right = {}
        for active in (True, False):
            for turn in turns:
                turn.active = active
            self._prepare(turns)
            right[active] = sum(len(turn.targets) - len(self.bad(turn.targets)) for turn in turns)
        for turn in turns:
            turn.active = right[True] > right[False]

    def _prepare(self, calculations):
        for calculation in calculations:
            calculation.prepare({p: self.now(p) for p in calculation.read}, self.units)

    def _compare_the_inputs(self, calculation):
        """The numbers that the task gives, looked for in the input cells."""
        for name, other in (("angles", "wrong angle"), ("point", "wrong point"), ("origin", "wrong point")):
            asked = getattr(self.found.task, name) or ()
            for place, wanted in zip(getattr(calculation, name), asked, strict=False):
                unit, number = np.rad2deg(self.units.get(place, np.pi / 180)), self.graph.own[place]
                half, number = 0.6 * 10.0 ** -min(written_decimals(number), 6) * unit + 1e-9, number * unit
                if abs(number - wanted) > half:
                    cause = other if any(abs(number - each) <= half for each in asked) else "wrong value"
                    cause = "sign" if abs(number + wanted) <= half else cause
                    text = f"{self.graph.short(place)} is {number:.6g}, the task says {wanted:.6g}"
                    self.faults.append(self.fault(place, cause, text))

    def _other_reading(self, calculations, sequences):
        """The sequence and convention, other than those asked for, that all results are of, or None."""
        turns = [c for c in calculations if isinstance(c, Turn) and not (c.axis or c.plane)]
        readings = [(s, active) for n in sequences for s in (n, n.lower()) for active in (False, True)]
        for sequence, active in (*readings, (self.found.sequence, self.found.active)) if turns else ():
            for turn in turns:
                turn.sequence, turn.active = sequence, active != turn.back
            self._prepare(turns)
            if all(self.met(turn.targets) for turn in turns):
                return sequence, "active" if active else "passive"
        return None

    def _repair(self, calculation, said):
        """Put in the right things, one after the other, until the results are right."""
        first, said = len(self.faults), said if said.keys() >= calculation.targets.keys() else {}
        after = self.graph.downstream(calculation.targets) if self.chained else set()
        later = [c for c in self.chained if c is not calculation and not after.isdisjoint(c.given)]
        while bad := self.bad(calculation.targets):
            near = self.graph.downstream(self.graph.upstream(bad))
            targets = {p: t for p, t in self.targets.items() if p in near}
            targets = {p: t for p, t in targets.items() if not any(p in c.targets for c in later)}
            missed = {p: targets.pop(p) for p in self.bad(targets) if p not in calculation.targets}
            found = self._by_labels(calculation, said, bad) or self._earliest(calculation, targets, bad, missed)
            strange = not self.graph.upstream(bad).isdisjoint(self.graph.not_evaluated)
            if found is None and not isinstance(calculation, Words):
                self.unexplained.append(calculation)
            elif found is None and (strange or not calculation.is_wrong(self.now)):
                self.unsure.update(bad)  # right as it stands; other tool axes may not be what it is made for
            elif found is None:
                place = min(bad, key=self.graph.calculation_order)
                fault = self.fault(place, "wrong value", "no single change makes the result what is asked for")
                over = self._typed_over(bad)
                self.faults.append(self.typed_number(over) if over else fault)
                self.put({p: targets[p] for p in bad})
            if found is None:
                break
            self.put(found)
            self._prepare(later)
            self.targets.update(chain.from_iterable(c.targets.items() for c in later))
        self.faults[first:] = _one_convention(self.faults[first:])

    def _choose(self, last):
        """Take vectors on the way that are right, but for one cell, in place of what only follows from them."""
        steps = self._steps(last)
        self._prepare(steps)
        right = [s for s in steps if len(self.bad(s.targets)) <= 1]
        if right and len(self.bad(last.targets)) > 1:
            before = {p for s in steps for p in self.graph.upstream(s.results) - set(s.results)}
            ends = [s for s in steps if not before.issuperset(s.results)]  # two recipes, of which one is wrong
            right = [s for s in steps if s in right + ends and s not in self.live]
            self.live = [c for c in self.live if c is not last] + right
            self.found.calculations = [c for c in self.found.calculations if c is not last] + right
            self.found.beside.append(last.results)

    def _drop_if_partial(self, calculation):
        """Set aside a vector that only some of the angles turn, if it is a step to another calculation's result."""
        turns = [c for c in self.live if isinstance(c, Turn) and c is not calculation]
        angles, now = self.found.turned_by(calculation.results), self.block(calculation.results[:3])
        partial = any(angles < self.found.turned_by(c.results) for c in turns) and self.bad(calculation.targets)
        if partial and any(same(known, now) for known in calculation.known.get(3, ())):
            self.live.remove(calculation)
            self.found.calculations.remove(calculation)
            self.found.beside.append(calculation.results)

    def _steps(self, last):
        """The vectors on the way to a result."""
        if not self.found.steps or not isinstance(last, Turn):
            return []
        up = self.graph.upstream(last.results, last.point) - set(last.point)
        return [s for s in self.found.steps if up.issuperset(s.results)]

    def _as_a_mistake(self, last):
        """Name the mistake that explains all three cells of a result, or of the step that it is copied from."""
        for text, wrong in last.mistakes.items():
            made = [c for c in (*self._steps(last), last) if same(self.block(c.results[:3]), wrong)]
            if made:
                targets = dict(zip(made[0].results, last.targets.values(), strict=False))
                self.faults += [self.fault(p, "offset", f"{self.graph.short(p)}: {text}") for p in targets]
                self.put(targets)
                self.unexplained.remove(last)
                return

    def _by_a_step(self, last):
        """Repair a vector on the way to a result that no repair explains: the result may only follow from it."""
        targets = {p: t for p, t in self.targets.items() if p not in last.targets}
        for step in self._steps(last)[::-1]:
            before = self.faults[:], self.unexplained[:]
            self._prepare([step])
            self.targets = targets | step.targets
            self._repair(step, {})
            if step not in self.unexplained:
                self.unexplained.remove(last)
                self._choose(last)
                return
            self.faults, self.unexplained = before
        self.targets = targets | last.targets

    def repaired_alone(self, place, value):
        """The fault of a cell beside the calculations that ought to hold `value`; None if no repair makes it so."""
        wanted = {p: self.now(p) for p in self.graph.array(place)} | {place: value}
        if place in self.graph.trees and (found := repaired(self.graph, wanted, self.values)):
            cause, sentence, other = found
            cause = self.why.reference_kind(place, other) if cause == "wrong reference" else cause
            self.put({place: value})
            return self.fault(place, cause, f"{self.graph.short(place)}: {sentence}")
        return None

    def typed_number(self, place, tree=None):
        """The fault of a number where a formula belongs, or of a `tree` that has numbers for references."""
        number, short = self.graph.book.cells[place].meant, self.graph.short(place)
        number = self.graph.own[place] if number is None else number
        text = f"{short} is a number, {number:g}, typed where a formula belongs"
        if tree and areas(tree):
            text = f"{short}: {said(place, tree, self.graph.trees[place])}"
        return self.fault(place, "typed over formula", text)

    def _typed_over(self, bad):
        """The first number on the way to a wrong result that is no input, nor a constant such as 0, 1 or π."""
        odd = self.graph.upstream(bad) & self.found.typed - self.graph.trees.keys()
        odd -= {p for c in self.found.calculations for p in c.given}
        odd -= self.graph.upstream(self.targets.keys() - set(self.bad(self.targets)))
        if self.found.task.machine:  # a constant of the machine stands in no row of the table
            odd &= {p for p in odd if any(p[:2] == place[:2] for place in bad)}
        constants = np.array([0, 1, -1, *CONVERSIONS])
        odd = [p for p in odd if (np.abs(self.graph.value(p) - constants) > 1e-3 * np.abs(constants)).all()]
        return min(odd, key=self.graph.calculation_order, default=None)

    def _as_the_labels_say(self):
        """Place → its values, of the labelled cells of the calculations that are right as the labels say them."""
        _, implied = read_labels(self.graph, by_numbers=False)
        whole = Graph(self.graph.book, implied)
        values = whole.run({p: v for p, v in self.inputs.items() if p not in implied})
        met = [c.targets for c in self.live if implied.keys() >= c.targets.keys() and self.met(c.targets, values)]
        reached = whole.upstream(p for targets in met for p in targets) & implied.keys()
        return {p: np.broadcast_to(values[p], SAMPLES) for p in whole.order if p in reached}

    def _by_labels(self, calculation, said, bad):
        """The first cell, or matrix, or vector, that is not what its label says, recorded; what the label says."""
        scope = self.graph.upstream(bad) & said.keys()
        wrong = {p for p in scope if not same(self.now(p), said[p])}
        first = [p for p in wrong if len(self.graph.upstream([p]) & wrong) == 1]
        for place in sorted(first, key=self.graph.calculation_order)[:1]:
            before = self.graph.upstream([place]) - {place, *said, *self.found.turning, *self.found.typed}
            if not all(any(same(self.now(p), entry) for entry in calculation.entries) for p in before):
                return None  # the cause may be a cell without a label
            units = [*self.found.windows, *self._lines(calculation, scope), (place,)]
            unit = next(unit for unit in units if place in unit)
            option = {p: said[p] for p in unit if p in wrong}
            self.faults += self.why.explain(calculation, unit, option)[1]
            return option
        return None

    # Where.

    def _earliest(self, calculation, targets, bad, missed):
        """The earliest repair, recorded; returns what it puts where.

        One that changes what other calculations `missed`, and does not mend it, is less likely.
        """
        best, candidates = None, self._candidates(calculation, targets, bad)
        for order, unit, options in sorted(candidates, key=lambda candidate: candidate[0]):
            if best and best[0] == 0 and order > best[1]:
                break
            for option in options:
                cost, faults = self.why.explain(calculation, unit, option)
                others = {p: missed[p] for p in self.graph.downstream(option) & missed.keys()}
                cost += 0.1 * bool(others and not self.met(others, self.values_with(option)))
                own = (*min(map(self.graph.calculation_order, option)), order[-1])
                best = min(best or (99,), (cost, max(order, own), option, faults), key=lambda b: b[:2])
        if best is None or (best[0] >= UNEXPLAINED and not len(bad) == 1 < len(calculation.targets)):
            return None
        if best[0] >= UNEXPLAINED and (place := self._typed_over(bad)):
            self.faults.append(self.typed_number(place))
            return {p: targets[p] for p in bad}
        if best[0] >= UNEXPLAINED and isinstance(calculation, Words) and not calculation.is_wrong(self.now):
            return None  # an arc sine of half the sphere
        self.faults += best[3]
        return best[2]

    def _candidates(self, calculation, targets, bad):
        """(order, cells, what may belong there): matrices, vectors, a cosine with its sine, single cells, all."""
        graph, found, scope = self.graph, self.found, self.graph.upstream(bad)
        blocks, pairs = [w for w in found.windows if not scope.isdisjoint(w)], {}
        formulas = scope & graph.trees.keys() - self.inputs.keys()
        for place in formulas - {p for window in blocks for p in window}:
            if heads(graph.trees[place]) & {"SIN", "COS", "TAN"}:
                pairs.setdefault(tuple(graph.uses[place]), []).append(place)
        blocks += self._lines(calculation, scope)
        for block in (*blocks, *(tuple(pair) for pair in pairs.values() if len(pair) == 2)):
            order = min(map(graph.calculation_order, [p for p in block if p in graph.trees] or block))
            options = [dict(zip(block, known, strict=True)) for known in calculation.known.get(len(block), ())]
            yield (*order, len(block)), block, self._tried(options, targets, bad)
        for place in formulas | (scope & (found.constants | (found.typed & targets.keys()))):
            options = self._cell_options(calculation, place, targets, bad)
            yield (*graph.calculation_order(place), 0), (place,), options
        everywhere = (("rounded early", ROUNDING), (TO_RADIANS[0], TURNING), (TO_DEGREES[0], TURNING))
        for number, (kind, functions) in enumerate(everywhere):
            places = [p for p in formulas if heads(graph.trees[p]) & functions]
            slips = {p: next((e[3] for e in edits(graph, p) if e[0] == kind), None) for p in places}
            option = {p: self.calculate(p, tree) for p, tree in slips.items() if tree}
            if len(option) > 1:  # the same slip everywhere
                yield (97, (number,), 0), tuple(option), self._tried([option], targets, bad)
        if isinstance(calculation, Turn):  # all matrices of the other convention
            windows = (_as_window(w, other).items() for w, (_, other) in self.elements(calculation).items())
            option = dict(chain.from_iterable(windows))
            yield (98, (0,), 0), tuple(option), self._tried([option], targets, bad)

    def _lines(self, calculation, scope):
        """Triples and quadruples of vector cells, the results among them."""
        vectors = self.found.vectors & scope
        lines = {c for p in vectors for c in [self.graph.component[p]] if len(c) in (3, 4)}
        steps = {step.results for step in self._steps(calculation) if scope.issuperset(step.results)}
        return {line for line in lines if len(vectors.intersection(line)) >= 2} | {calculation.results} | steps

    def _tried(self, options, targets, bad):
        """Of the options (place → value) what they change, of those that meet the targets, one of `bad` first."""
        first, before = bad[0], self.graph.upstream(bad[:1])
        for option in options:
            changed = {p: value for p, value in option.items() if not same(self.now(p), value)}
            affected = self.graph.downstream(changed)
            reached = {p: target for p, target in targets.items() if p in affected}
            if (
                affected.issuperset(bad)
                and self.met({first: targets[first]}, self._run(changed, affected & before))
                and self.met(reached, self._run(changed, affected))
            ):
                yield changed

    def _cell_options(self, calculation, place, targets, bad):
        """The value of one cell that makes all targets right: solved where they are linear in it, or guessed."""
        if place in targets:
            yield from self._tried([{place: targets[place]}], targets, bad)
            return
        affected, now = self.graph.downstream([place]), self.now(place)
        if not affected.issuperset(bad):
            return
        now = now if np.isfinite(now[1:]).all() else np.zeros(SAMPLES)
        runs = [self._run({place: now + step}, affected) for step in (0.0, 1.0, 2.0)]
        wanted, steepest, linear = np.array(now), np.full(SAMPLES, 1e-9), True
        for target, value in targets.items():
            if target not in affected:
                continue
            f0, f1, f2 = (run.get(target, self.now(target)) for run in runs)
            slope = np.broadcast_to(f1 - f0, SAMPLES)
            linear &= bool(np.isfinite(slope[1:]).all()) and same(f2 - f1, slope, 1e-7)
            if target in bad:
                steeper = np.abs(slope) > steepest
                wanted = np.where(steeper, now + (value - f0) / np.where(steeper, slope, 1), wanted)
                steepest = np.maximum(steepest, np.abs(slope))
        wanted[0] = np.nan if steepest[0] < 1e-8 else wanted[0]
        options = [wanted] if linear else self._plausible(calculation, place)
        yield from islice(self._tried(({place: value} for value in options), targets, bad), 1)

    def _plausible(self, calculation, place):
        """What a cell may have to hold on which results depend in a curved way: an angle, a repaired formula."""
        if place in self.found.turning:
            for a in calculation.radians.T:
                yield from (a, -a, np.rad2deg(a), -np.rad2deg(a), a / 2)
        if place in self.found.constants:
            yield from (np.full(SAMPLES, factor) for factor in CONVERSIONS)
        seen = [self.now(place)]
        for *_, tree in edits(self.graph, place) if place in self.graph.trees else ():
            value = self.calculate(place, tree)
            if np.isfinite(value[1:]).all() and not any(same(value, s) for s in seen):
                seen.append(value)
                yield value
            if len(seen) > 60:
                break
        if isinstance(calculation, Turn):
            yield from (sign * entry for entry in calculation.scalars() for sign in (1, -1))

    def elements(self, turn, option=()):
        """The windows that are elementary matrices, with `option` → their sense, and what the other would be."""
        half = len(turn.elements) // 2
        return {
            window: (n < half, turn.elements[n - half])
            for window in self.found.windows
            for n, element in enumerate(turn.elements)
            if self.met(_as_window(window, element), dict(option))
        }

    def stands(self, calculation, places):
        """Whether some cells hold together what may stand in so many."""
        return any(same(known, self.block(places)) for known in calculation.known.get(len(places), ()))


def _one_convention(faults):
    """Faults that are all signs are those of the other convention."""
    text = "the elementary matrices are those of the other convention, active or passive"
    signs = len(faults) >= 6 and {fault.cause for fault in faults} == {"sign"}
    return [replace(f, cause="other convention", message=text) for f in faults] if signs else faults


def _as_window(window, matrix):
    """Place → what stands there if a window of 3×3 or 4×4 is a matrix, or its first rows and columns."""
    size = 3 if len(window) == 9 else 4
    return dict(zip(window, matrix[:, :size, :size].reshape(len(matrix), -1).T, strict=True))
