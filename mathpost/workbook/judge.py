"""Right or wrong, and where: the earliest place where putting in the right thing makes all that follows right."""

from itertools import combinations

import numpy as np

from mathpost.detective.misreadings import written_decimals
from mathpost.workbook.edits import edits, flat, repaired, replaced
from mathpost.workbook.formula import areas, put, text_of, walk
from mathpost.workbook.graph import SAMPLES, at, same
from mathpost.workbook.nc_table import Words, judge_numbers
from mathpost.workbook.recognise import CONVERSIONS, TRIGONOMETRY, Calculation, elementary
from mathpost.workbook.report import Fault
from mathpost.workbook.values import read_labels, with_formulas

SEED = 20
OTHER_CONVENTION = "the elementary matrices are those of the other convention, active or passive"
UNEXPLAINED, UNLIKELY = (
    3.0,
    2.0,
)  # what a repair costs that no single change of the formula, or an odd one, explains


class Judge:
    """Evaluate a recognised workbook at random inputs, compare, repair.

    After `run`, `right` and `wrong` are the places that were judged, `faults` the wrong ones in order.
    """

    def __init__(self, graph, recognised):
        self.graph, self.found = graph, recognised
        self.faults, self.fixed, self.warnings, self.whole = [], {}, [], None
        self.levels = {}
        for place in graph.order:
            self.levels[place] = 1 + max((self.levels.get(s, 0) for s in graph.uses[place]), default=0)
        self.units = self._units()
        rng = np.random.default_rng(SEED)
        self.inputs = {}
        angles = [*recognised.angle_cells, *(p for c in recognised.calculations for p in c.angles)]
        lengths = [
            *recognised.length_cells,
            *(p for c in recognised.calculations for p in (*c.point, *c.origin, *c.axis)),
        ]
        for place in dict.fromkeys(angles):
            limit = 170 if self.units.get(place, 1) != 1 else 3.0
            self.inputs[place] = self._sampled(place, rng.uniform(-limit, limit, SAMPLES))
        for place in dict.fromkeys(lengths):
            self.inputs[place] = self._sampled(place, rng.uniform(-60, 60, SAMPLES))
        for calculation in recognised.calculations:
            if not isinstance(calculation, Calculation) and not getattr(calculation, "typed", False):
                for place, numbers in calculation.draw(rng).items():
                    self.inputs[place] = self._sampled(place, numbers.copy())
        self.values = graph.run(self.inputs, self.inputs)

    def _sampled(self, place, numbers):
        numbers[0] = self.own(place)
        return numbers

    def own(self, place):
        """The number that stands in an input cell."""
        value = self.graph.value(place)
        if value is None or place in self.graph.trees:
            value = float(self.graph.calculate(self.graph.trees[place], {})[0, 0, 0])
        return value

    def _units(self):
        """Degrees or radians: what most of the formulas on the way from an angle to its sine take it for."""
        graph, votes = self.graph, {}
        for calculation in self.found.calculations:
            for place in calculation.angles:
                for user in self._on_the_way(place):
                    tree = graph.trees[user]
                    converts = any(
                        (part[0] == "call" and part[1] in ("RADIANS", "PI"))
                        or (part[0] == "number" and any(abs(part[1] - c) < 0.01 * c for c in CONVERSIONS))
                        or (part[0] == "area" and any(p in self.found.constants for p in part[1].places))
                        for _, part in walk(tree)
                    )
                    trigonometric = any(part[0] == "call" and part[1] in TRIGONOMETRY for _, part in walk(tree))
                    if converts or trigonometric:
                        votes.setdefault(calculation.angles, []).append(converts)
        units = {}
        for calculation in self.found.calculations:
            if not calculation.angles:
                continue
            own = [self.own(p) for p in calculation.angles]
            cast = votes.get(calculation.angles, [])
            degrees = sum(cast) * 2 > len(cast) or max(map(abs, own)) > 6.3
            if calculation.angles[0] in graph.trees:
                degrees = max(map(abs, own)) > 6.3
            units.update({p: np.pi / 180 if degrees else 1.0 for p in calculation.angles})
        return units

    def _on_the_way(self, place):
        found, stack = [], [place]
        while stack:
            for user in self.graph.used.get(stack.pop(), ()):
                if user not in found:
                    found.append(user)
                    if user in self.found.tainted:
                        stack.append(user)
        return found

    # The verdict.

    def run(self):
        """Judge every calculation; one that is wrong is repaired, so that the next ones are seen without it."""
        self.targets = {}
        given = {p: self.values.get(p, self.constant(p)) for p in self.graph.cells}
        for calculation in self.found.calculations:
            calculation.prepare(given, self.units)
        rows = [c for c in self.found.calculations if isinstance(c, Words)]
        for row in rows:  # once more, on the branch that the table is on
            row.preferred = int(np.argmax(sum(r.votes for r in rows)))
            row.prepare(given, self.units)
        for calculation in self.found.calculations:
            if not getattr(calculation, "typed", False):
                self.targets.update(calculation.targets())
        self._compare_the_inputs()
        self.said = self._as_the_labels_say() if self.bad(self.targets) else {}
        for calculation in self.found.calculations:
            if not getattr(calculation, "typed", False):
                self._repair(calculation)
        typed = [c for c in rows if c.typed]
        for place, cause, message in judge_numbers(typed, self.graph, self.own) if typed else ():
            self._fault(place, cause, f"{self.graph.short(place)}: {message}")
        return self

    def _compare_the_inputs(self):
        """The numbers that the task gives, looked for in the input cells of the first calculation."""
        task = self.found.task
        for calculation in self.found.calculations[:1]:
            for name in ("angles", "point", "origin"):
                places, asked = getattr(calculation, name), getattr(task, name)
                for n, place in enumerate(places if asked is not None else ()):
                    own = self.own(place) * (np.rad2deg(self.units[place]) if name == "angles" else 1)
                    half = (
                        0.6 * 10.0 ** -min(written_decimals(self.own(place)), 6) * abs(own / (self.own(place) or 1))
                    )
                    if abs(own - asked[n]) > half + 1e-9:
                        cause = "wrong value"
                        if abs(own + asked[n]) <= half:
                            cause = "sign"
                        elif any(abs(own - other) <= half for other in asked):
                            cause = "wrong angle" if name == "angles" else "wrong point"
                        text = f"{self.graph.short(place)} is {own:.6g}, the task says {asked[n]:.6g}"
                        self._fault(place, cause, text)

    def bad(self, targets, values=None):
        """The targets that are missed."""
        values = self.values if values is None else values
        return [
            p
            for p, t in targets.items()
            if not same(np.broadcast_to(values.get(p, self.constant(p)), t.shape), t, 1e-8)
        ]

    def constant(self, place):
        value = self.graph.value(place)
        return np.full(SAMPLES, np.nan if value is None else value)

    def _repair(self, calculation):
        own = {p: self.targets[p] for p in calculation.results}
        for _ in range(12):
            bad = self.bad(own)
            if not bad:
                return
            missed = set(self.bad(self.targets)) - set(own)
            targets = {p: t for p, t in self.targets.items() if p not in missed}
            found = self._as_in_the_row_above(own, bad) or self._against_the_labels(calculation, bad)
            found = found or self._earliest(calculation, targets, bad)
            if found is None:
                place = self._typed_over(calculation, bad)
                if place is not None:
                    text = (
                        f"{self.graph.short(place)} is a number, {self.own(place):g}, typed where a formula belongs"
                    )
                    self._fault(place, "typed over formula", text)
                    self.fixed.update({p: targets[p] for p in bad})
                    self.values = self.graph.run(self.inputs, {**self.inputs, **self.fixed})
                    return
                place = min(bad, key=self._order)
                self._fault(
                    place,
                    "wrong value",
                    "the result is not what the task asks for, and no single change makes it so",
                )
                found = {p: targets[p] for p in bad}
            self.fixed.update(found)
            self.values = self.graph.run(self.inputs, {**self.inputs, **self.fixed})

    def _as_the_labels_say(self):
        """Place → its values, of the labelled cells, if the labels say a calculation that meets the targets."""
        _, implied = read_labels(self.graph, by_numbers=False)
        if not implied or not self.targets.keys() & implied.keys():
            return {}
        whole = with_formulas(self.graph, implied)
        values = whole.run({p: v for p, v in self.inputs.items() if p not in implied})
        met = [p for p in self.targets if p in implied and not self.bad({p: self.targets[p]}, values)]
        reached = whole.upstream(met) & implied.keys()
        return {p: np.broadcast_to(values[p], (SAMPLES,)) for p in whole.order if p in reached}

    def _against_the_labels(self, calculation, bad):
        """Put in what the labels say, step by step, until the results are right; None if they do not become so."""
        before, faults, put_in = self.values, [], {}
        for _ in range(30):
            scope = (self.graph.upstream(bad) | set(bad)) & self.said.keys()
            wrong = {p for p in scope if self.bad({p: self.said[p]})}
            first = min(
                (p for p in wrong if len(self.graph.upstream([p]) & wrong) == 1), key=self._order, default=None
            )
            if first is None:
                break
            units = [*self.found.windows, *self._lines(calculation, scope)]
            unit = next((w for w in units if first in w), (first,))
            option = {p: self.said[p] for p in unit if p in wrong}
            faults += self._explain(calculation, unit, option)[1]
            put_in |= option
            self.values = self.graph.run(self.inputs, {**self.inputs, **self.fixed, **put_in})
            if not self.bad({p: self.targets[p] for p in bad}):
                if len(faults) >= 6 and {cause for _, cause, _ in faults} == {"sign"}:
                    faults = [(p, "other convention", OTHER_CONVENTION) for p, *_ in faults]
                for fault in faults:
                    self._fault(*fault)
                return put_in
        self.values = before
        return None

    def _as_in_the_row_above(self, own, bad):
        """The same slip once more, one row further down: what was said there holds here."""
        above = {fault.place: fault for fault in self.faults if fault.place in self.graph.trees}
        for place in sorted(bad, key=self._order):
            fault = above.get((place[0], place[1] - 1, place[2]))
            if (
                fault
                and shape_of(self.graph.trees[fault.place]) == shape_of(self.graph.trees.get(place, ("number", 0)))
                and len(self.found.component.get(place, ())) > 9
            ):
                self._fault(place, fault.cause, f"{self.graph.short(place)}: as in the row above")
                return {place: own[place]}
        return None

    def _typed_over(self, calculation, bad):
        """The first number on the way to a wrong result that is no input, nor a constant such as 0, 1 or π."""
        given = {*calculation.angles, *calculation.point, *calculation.origin, *calculation.axis}
        scope = (self.graph.upstream(bad) & self.found.typed) - given
        odd = [p for p in scope if p not in self.graph.trees and self.own(p) not in (0, 1, -1)]
        odd = [p for p in odd if not any(abs(self.own(p) - c) < 1e-3 * c for c in CONVERSIONS)]
        others = {p for c in self.found.calculations for p in (*c.angles, *c.point, *c.origin, *c.axis)}
        others |= self.graph.upstream(p for p in self.targets if p not in set(self.bad(self.targets)))
        return min((p for p in odd if p not in others), key=self._order, default=None)

    def _order(self, place):
        return self.levels.get(place, 0), self.graph.reading_order(place)

    def _fault(self, place, cause, message):
        self.faults.append(Fault(self.graph.address(place), cause, message, place))

    def _earliest(self, calculation, targets, bad):
        """The earliest repair, recorded; returns what it puts where."""
        scope = self.graph.upstream(bad)
        best = None
        for order, unit, options in sorted(self._candidates(calculation, targets, scope), key=lambda c: c[0]):
            if best and best[0] == 0 and order > best[1]:
                break
            for option in options(unit, targets, bad):
                cost, faults = self._explain(calculation, unit, option)
                if best is None or (cost, order) < best[:2]:
                    best = (cost, order, option, faults)
        if best is None or (best[0] >= UNEXPLAINED and self._typed_over(calculation, bad)):
            return None
        for place, cause, message in best[3]:
            self._fault(place, cause, message)
        return best[2]

    def judge_the_rest(self):
        """Return the places that could not be judged: what feeds no result, and is none of the known quantities."""
        graph, found = self.graph, self.found
        self.all_places = [p for p in graph.trees if p not in found.typed] + sorted(
            graph.unread, key=graph.reading_order
        )
        self.all_places = [p for p in self.all_places if not self._is_text(p)]
        judged = graph.upstream(p for c in found.calculations for p in c.results)
        rest = [p for p in self.all_places if p not in judged]
        return [p for p in sorted(rest, key=self._order) if p in graph.unread or not self._is_check(p)]

    def _is_text(self, place):
        """Whether a formula only makes a message."""
        cell = self.graph.cells[place]
        if cell.value is None:
            return any(part[0] == "text" for _, part in walk(self.graph.trees.get(place, ("number", 0))))
        return isinstance(cell.value, str) and not cell.error

    def _is_check(self, place):
        """Judge a cell beside the calculation: a determinant, a length, a difference, a largest one of them."""
        value = np.broadcast_to(self.values.get(place, np.full(1, np.nan)), (SAMPLES,))
        parts = [part for _, part in walk(self.graph.trees[place])]
        known = [np.ones(SAMPLES)]
        if any(part[:2] == ("call", "MDETERM") for part in parts):
            return same(value, known[0], 1e-8)
        if not np.abs(value[1:]).max() > 1e-9 and not any(part[0] == "-" for part in parts):
            return False  # zero without a difference: something empty was taken
        for calculation in self.found.calculations:
            if self._is_known(calculation, value):
                return True
            for vector in getattr(calculation, "vectors", {}).values():
                known.append(np.linalg.norm(vector[:, :3], axis=1))
            known += self._differences(calculation)
        return any(same(value, k, 1e-8) for k in known)

    def _differences(self, calculation):
        """The differences of a result to the numbers that stand below or beside it, and the largest of them."""
        if calculation.target is None:
            return
        for component in self.found.components:
            if len(component) == 3 and self.found.typed.issuperset(component):
                off = calculation.target[:, :3] - self._block(component, 3)[:, :, 0]
                yield from off.T
                yield from -off.T
                for each in (off, -off, np.abs(off)):
                    yield each.max(axis=1)
                yield np.linalg.norm(off, axis=1)

    # Where.

    def _candidates(self, calculation, targets, scope):
        graph, found = self.graph, self.found
        in_units = set()
        for window in found.windows:
            if scope & set(window):
                in_units |= set(window)
                yield self._unit_order(window), window, self._window_options(calculation)
        for line in self._lines(calculation, scope):
            yield self._unit_order(line), line, self._vector_options(calculation)
        pairs = {}
        for place in scope & set(graph.trees):
            if place in self.inputs:
                continue
            tree = graph.trees[place]
            if (
                any(part[0] == "call" and part[1] in TRIGONOMETRY for _, part in walk(tree))
                and place not in in_units
            ):
                pairs.setdefault(tuple(graph.uses[place]), []).append(place)
            yield (*self._order(place), 0), (place,), self._cell_options(calculation)
        for place in scope & found.constants:
            yield (*self._order(place), 0), (place,), self._cell_options(calculation)
        for pair in pairs.values():
            if len(pair) == 2:
                yield self._unit_order(pair), tuple(pair), self._pair_options(calculation)
        self.whole = tuple(sorted(scope & set(graph.trees), key=self._order))
        yield (98, (0,), 0), self.whole, self._everywhere(calculation)

    def _unit_order(self, unit):
        # Zeros and ones do not make a matrix early.
        return (*min(self._order(p) for p in [q for q in unit if q in self.graph.trees] or unit), len(unit))

    def _lines(self, calculation, scope):
        """Triples and quadruples of vector cells."""
        for component in self.found.components:
            cells = [p for p in component if p in self.found.vector_cells and p in scope]
            if len(component) in (3, 4) and len(cells) >= 2:
                yield tuple(component)
        if calculation.results not in self.found.components:
            yield calculation.results

    def _try(self, option, targets):
        """Whether the targets are met when `option` (place → value) is put in."""
        changed = {
            p: v
            for p, v in option.items()
            if not same(np.broadcast_to(self.values.get(p, self.constant(p)), v.shape), v, 1e-8)
        }
        if not changed:
            return None
        affected = self.graph.downstream(changed)
        if not affected.issuperset(self.bad(targets)):
            return None
        values = self.graph.run(self.inputs, {**self.inputs, **self.fixed, **changed}, self.values, affected)
        return None if self.bad(targets, values) else changed

    def _window_options(self, calculation):
        def options(unit, targets, bad):
            size = 3 if len(unit) == 9 else 4
            for word in calculation.words.values():
                option = dict(zip(unit, word[:, :size, :size].reshape(SAMPLES, -1).T, strict=True))
                if changed := self._try(option, targets):
                    yield changed

        return options

    def _vector_options(self, calculation):
        def options(unit, targets, bad):
            for vector in calculation.vectors.values():
                if changed := self._try(dict(zip(unit, vector.T[: len(unit)], strict=True)), targets):
                    yield changed

        return options

    def _pair_options(self, calculation):
        def options(unit, targets, bad):
            for angle in calculation.radians.T:
                c, s = np.cos(angle), np.sin(angle)
                for pair in ((c, s), (s, c), (c, -s), (-s, c)):
                    if changed := self._try(dict(zip(unit, pair, strict=True)), targets):
                        yield changed

        return options

    def _cell_options(self, calculation):
        def options(unit, targets, bad):
            (place,) = unit
            wanted = self._solve(place, targets, bad)
            if wanted is not None:
                yield {place: wanted}
                return
            if wanted is None and self.linear:
                return
            for value in self._plausible(calculation, place):
                if changed := self._try({place: value}, targets):
                    yield changed
                    return

        return options

    def _solve(self, place, targets, bad):
        """The value of one cell that makes all targets right, if they are linear in it; None if there is none."""
        now = self.values.get(place, self.constant(place))
        now = now if now.shape == (SAMPLES,) else np.broadcast_to(now, (SAMPLES,))
        self.linear = True
        if place in targets:
            return targets[place] if self._try({place: targets[place]}, targets) else None
        if not np.isfinite(now[1:]).all():
            now = np.zeros(SAMPLES)
        affected = self.graph.downstream([place])
        if not affected.issuperset(bad):
            return None
        shifts = (1.0, 2.0) if self.values.get(place) is now else (0.0, 1.0, 2.0)
        runs = [
            self.graph.run(self.inputs, {**self.inputs, **self.fixed, place: now + step}, self.values, affected)
            for step in shifts
        ]
        runs = runs if len(runs) == 3 else [self.values, *runs]
        wanted, steepest = np.array(now), np.full(SAMPLES, 1e-9)
        for target, value in targets.items():
            f0, f1, f2 = (np.broadcast_to(run.get(target, self.constant(target)), (SAMPLES,)) for run in runs)
            slope = f1 - f0
            if not np.isfinite(slope[1:]).all() or not same(f2 - f1, slope, 1e-7):
                self.linear = False
                return None
            steeper = np.abs(slope) > steepest
            if target in bad and not (np.abs(slope) > 1e-9).any():
                if not same(f0, value, 1e-8):
                    return None
            elif target in bad:
                wanted = np.where(steeper, now + (value - f0) / np.where(steeper, slope, 1), wanted)
                steepest = np.maximum(steepest, np.abs(slope))
        wanted[0] = np.nan if steepest[0] < 1e-8 else wanted[0]
        return wanted if self._try({place: wanted}, targets) else None

    def _plausible(self, calculation, place):
        """What a cell may have to hold on which results depend in a curved way: an angle, a repaired formula."""
        if place in self.found.tainted:
            for angle in calculation.radians.T:
                for value in (angle, np.rad2deg(angle)):
                    yield from (value, -value)
        tree = self.graph.trees.get(place)
        if tree is None:
            return
        seen = [self.values.get(place)]
        for _, _, other in edits(self.graph, place, tree):
            value = at(self.graph.calculate(other, self.values), self.graph.part.get(place, (0, 0)))
            value = np.broadcast_to(value, (SAMPLES,))
            if np.isfinite(value[1:]).all() and not any(same(value, s) for s in seen):
                seen.append(value)
                yield value
            if len(seen) > 60:
                return

    def _everywhere(self, calculation):
        """The same slip in many places: all sines in degrees, all elementary matrices of the other convention."""

        def options(unit, targets, bad):
            trees = {}
            for place in unit:
                tree = self.graph.trees[place]
                for path, part in reversed(list(walk(tree))):
                    if part[0] == "call" and part[1] in TRIGONOMETRY:
                        tree = put(tree, path, ("call", part[1], (("call", "RADIANS", (part[2][0],)),)))
                if tree is not self.graph.trees[place]:
                    trees[place] = tree
            option = {
                p: np.broadcast_to(
                    at(self.graph.calculate(t, self.values), self.graph.part.get(p, (0, 0))), (SAMPLES,)
                )
                for p, t in trees.items()
            }
            if changed := self._try(option, targets):
                yield changed
            singles = {window: matrix for window, (_, matrix) in self._elements(calculation).items()}
            option = {}
            for window, matrix in singles.items():
                option.update(self._as_window(window, matrix))
            if changed := self._try(option, targets):
                yield changed
            elements = {name: m for name, m in calculation.words.items() if len(name.rstrip("ᵀ")) == 1}
            for first, second in combinations(singles, 2):
                for a in elements.values():
                    for b in elements.values():
                        option = {**self._as_window(first, a[:, :3, :3]), **self._as_window(second, b[:, :3, :3])}
                        changed = self._try(option, targets)
                        if (
                            changed
                            and not changed.keys().isdisjoint(first)
                            and not changed.keys().isdisjoint(second)
                        ):
                            yield changed
                            return

        return options

    def _elements(self, calculation):
        """The windows that are elementary matrices now → their sense of rotation, and what the other would be."""
        found = {}
        for window in self.found.windows:
            now = self._block(window, 3 if len(window) == 9 else 4)
            if now.shape[1] == 4 and not same(now[:, :, 3], np.array([0, 0, 0, 1.0])):
                continue
            now = now[:, :3, :3]
            for letter in "XYZ":
                for angle in calculation.radians.T:
                    for sense in (1, -1):
                        if window not in found and same(now, elementary(letter, sense * angle), 1e-8):
                            found[window] = (sense, elementary(letter, -sense * angle))
        return found

    def _as_window(self, window, matrix):
        if len(window) == 16:
            matrix = np.pad(matrix, ((0, 0), (0, 1), (0, 1))) + np.diag([0, 0, 0, 1.0])
        return dict(zip(window, matrix.reshape(SAMPLES, -1).T, strict=True))

    # Why.

    def _explain(self, calculation, unit, changed):
        """The cost of a repair, and its faults as (place, cause, sentence), the first one first."""
        graph, faults, cost = self.graph, [], 0.0
        in_window = unit in self.found.windows
        places = sorted(changed, key=graph.reading_order if in_window else self._order)
        if in_window and all(
            p in self.found.typed for p in places
        ):  # a typed matrix: what is wrong by its number first
            places.sort(key=lambda p: abs(changed[p][0] - self.own(p)) < 1e-9)
        arrays = {}
        for place in places:
            if place in graph.part:
                arrays.setdefault((id(graph.trees[place]), graph.cells[place].anchor), []).append(place)
        done = set()
        block = self._block_cause(calculation, unit, changed) if len(places) > 2 else None
        for place in places:
            if place in done:
                continue
            group = arrays.get(
                (id(graph.trees.get(place)), graph.cells[place].anchor if place in graph.cells else None), [place]
            )
            done.update(group)
            if block:
                found = block
            else:
                whole = group if place not in graph.part else self._array(place)
                wanted = {p: changed.get(p, self.values.get(p)) for p in [place, *whole]}
                found = self._cause(calculation, place, wanted)
            cost = max(cost, found[2])
            faults.append((place, *found[:2]))
        elements = self._elements(calculation) if unit in self.found.windows and len(places) == 2 else {}
        if unit in elements:
            senses = [sense for sense, _ in elements.values()]
            cost = UNLIKELY if senses.count(elements[unit][0]) > 1 else 0.0  # do the others turn the same way?
        elif unit is self.whole:
            cost = 0.0
        elif len(unit) == 1 and any(unit[0] in w for w in self._elements(calculation)):
            cost += UNLIKELY  # an elementary matrix as it stands
        elif not block:
            cost += 0.25 * (len(faults) - 1)
        if unit is self.whole and {cause for _, cause, _ in faults} == {"sign"}:
            faults = [(p, "other convention", OTHER_CONVENTION) for p, *_ in faults]
        return cost, faults

    def _cause(self, calculation, place, wanted):
        """Cause, sentence and cost of one wrong cell, or of an array formula."""
        graph, value = self.graph, wanted[place]
        cell, short = graph.cells.get(place), graph.short(place)
        if cell is None:
            return "wrong value", f"{short} is empty", UNEXPLAINED
        if place not in graph.trees:
            if cell.number is None:
                return "wrong value", f"{short} holds {cell.value!r} where a number belongs", 0.0
            if np.ptp(value[1:]) < 1e-9:
                cost = 0.0 if abs(value[1]) < 1e-9 or abs(value[1] - 1) < 1e-9 else UNLIKELY
                return "wrong value", f"{short} is {cell.number:g}, should be {value[1]:g}", cost
            known = (
                not abs(value[0] - cell.number) > 5e-3
                or place in self.targets
                or self._is_known(calculation, value)
            )
            cost = UNLIKELY if not known else UNLIKELY / 2 if cell.number in (0, 1, -1) else 0.0
            text = f"{short} is a number, {cell.number:g}, typed where a formula belongs"
            return "typed over formula", text, cost
        found = repaired(graph, place, wanted, self.values, self._reference_kind, self._given(calculation))
        found = found or self._missing(calculation, place, value)
        if found is None:
            known = self._is_known(calculation, value) or place in self.targets
            return (
                "wrong value",
                f"{short}: ={text_of(graph.trees[place])} is not what belongs there",
                UNEXPLAINED + (not known) * 9,
            )
        cause, sentence = found
        if cause == "missing term":
            return cause, f"{short}: {sentence}", 0.2
        odd = "a minus is lost" in sentence and self._canonical(place)
        odd = (odd or (cause == "sign" and self._like_its_peers(place))) and not self._as_above(place, value)
        cost = UNLIKELY if odd else 0.0
        return cause, f"{short}: {sentence}", cost

    def _as_above(self, place, value):
        """Whether the formula of the row above or below, copied here, gives `value`."""
        for step in (-1, 1):
            tree = self.graph.trees.get((place[0], place[1] + step, place[2]))
            moved = copied(tree, -step) if tree and len(self.found.component[place]) > 9 else None
            if moved and same(self.graph.calculate(moved, self.values)[:, 0, 0], value, 1e-7):
                return True
        return False

    def _array(self, place):
        """The cells of an array formula."""
        anchor, tree = self.graph.cells[place].anchor, self.graph.trees[place]
        return [p for p in self.graph.part if self.graph.cells[p].anchor == anchor and self.graph.trees[p] is tree]

    def _like_its_peers(self, place):
        """Whether the formulas in line with a cell differ from its own in nothing but their references."""
        graph = self.graph
        line = [p for p in self.found.component.get(place, []) if p in graph.trees]
        if place in graph.part or not 2 <= len(line) <= 16:
            return False
        return len({shape_of(graph.trees[p]) for p in line}) == 1

    def _canonical(self, place):
        """Whether a formula is the sine, the cosine or the radians of a cell, without a sign of its own."""
        tree = self.graph.trees[place]
        if tree[0] in ("+", "-"):
            return True
        return not any(part[0] == "minus" for _, part in walk(tree)) and (tree[0] == "call" or len(areas(tree)) > 1)

    def _given(self, calculation):
        return [*calculation.angles, *calculation.point, *calculation.origin, *calculation.axis]

    def _is_known(self, calculation, value):
        """Whether a value is an entry of one of the matrices or vectors that may stand in the sheet."""
        entries = [w.reshape(SAMPLES, -1).T for w in calculation.words.values()]
        entries += [v.T for v in getattr(calculation, "vectors", {}).values()]
        angles = calculation.radians.T
        entries += [np.cos(angles), np.sin(angles), -np.sin(angles), -np.cos(angles)]
        return any(same(value, entry, 1e-7) for group in entries for entry in group)

    def _missing(self, calculation, place, value):
        """A term that is missing from a sum: one like those of the cells around, or a product of cells."""
        graph = self.graph
        lacking = value - np.broadcast_to(self.values[place], (SAMPLES,))
        if not np.isfinite(lacking[1:]).all():
            return None
        around = self.found.component.get(place, [place])
        if len(around) > 16:
            around = [p for p in around if p[1] == place[1]]
        trees = [graph.trees[p] for p in around if p in graph.trees]
        given = self._given(calculation)
        pool = [
            p
            for p in dict.fromkeys([*(s for p in around for s in graph.uses.get(p, ())), *given])
            if p in graph.cells
        ]
        terms = [term for tree in trees for _, term in flat(tree)]
        for term in terms:
            for old in dict.fromkeys(areas(term)):
                for new in pool:
                    other = replaced(term, old, new) if old.shape == (1, 1) else term
                    number = np.broadcast_to(graph.calculate(other, self.values)[:, 0, 0], (SAMPLES,))
                    if same(lacking, number, 1e-7) or same(lacking, -number, 1e-7):
                        return "missing term", f"the term {text_of(other)} is missing"
        named = {graph.short(p): np.broadcast_to(graph.number(p, self.values), (SAMPLES,)) for p in pool}
        for tree in trees:
            for _, part in walk(tree):
                if part[0] == "call" and part[1] in TRIGONOMETRY:
                    named[text_of(part)] = np.broadcast_to(graph.calculate(part, self.values)[:, 0, 0], (SAMPLES,))
        for depth in (1, 2, 3, 4):
            if len(named) ** depth > 20_000:
                break
            for factors in combinations(named, depth):
                product = np.prod([named[n] for n in factors], axis=0)
                if same(lacking, product, 1e-7) or same(lacking, -product, 1e-7):
                    return "missing term", f"the term {'*'.join(factors)} is missing"
        return None

    def _reference_kind(self, place, tree, other):
        """Name a wrong reference: a missing $, another angle, another point, or just another cell."""
        graph = self.graph
        for old, new in zip(areas(tree), areas(other), strict=True):
            if old == new:
                continue
            above = (place[0], place[1] - 1, place[2])
            if (
                old.top > new.top
                and above in graph.trees
                and len(self.found.component[place]) > 9
                and shape_of(graph.trees[above]) == shape_of(tree)
            ):
                refs = areas(graph.trees[above])
                moved = [a.moved(1, 0) for a in refs]
                if str(old) in map(str, moved) and not old.fixed[0] and len(refs) == len(areas(tree)):
                    first = (place[0], place[1] - (old.top - new.top), place[2])
                    if first in graph.trees and str(new) in map(str, areas(graph.trees[first])):
                        return "missing $"
            a, b = ((p.sheet, p.top, p.left) for p in (old, new))
            if b in self.found.angle_cells:
                return "wrong angle"
            if b in self.found.length_cells and a in self.found.length_cells:
                return "wrong point"
        return None

    def _block_cause(self, calculation, unit, changed):
        """Why a whole matrix or vector is wrong: the order of the product, a transposed factor, another factor."""
        if len(unit) not in (3, 4, 9, 16):
            return None
        wanted = {p: changed.get(p, self.values.get(p, self.constant(p))) for p in unit}
        size = {9: 3, 16: 4, 3: 3, 4: 4}[len(unit)]
        shape = (SAMPLES, size, -1)
        now = self._block(unit, size)
        expected = np.stack([np.broadcast_to(wanted[p], (SAMPLES,)) for p in unit], -1).reshape(shape)
        if now.shape[2] == size and same(now, np.swapaxes(expected, 1, 2), 1e-8):
            turned = any(same(now, word[:, :size, :size], 1e-8) for word in calculation.words.values()) or any(
                same(self._block(w, size), expected, 1e-8) for w in self.found.windows if len(w) == len(unit)
            )
            others = [w for w in self.found.windows if len(w) == len(unit) and w != unit]
            copy = all(self.graph.trees.get(p, ("",))[0] == "area" for p in unit)
            copy &= any(same(self._block(w, size), now, 1e-8) for w in others)
            regular = not copy and (turned or self._is_product(unit, now))
            return "transposed", "the matrix should be transposed", UNLIKELY if regular else 0.0
        blocks = {}
        for window in [w for w in self.found.windows if w != unit and len(w) == size * size]:
            blocks[window] = self._block(window, size)
        turn = lambda m: np.swapaxes(m, 1, 2)  # noqa: E731
        if now.shape[2] == 1:
            vectors = [c for c in map(tuple, self.found.components) if len(c) == size and c != unit]
            right = {c: self._block(c, size) for c in vectors}
        else:
            right = blocks
        with np.errstate(all="ignore"):
            for a, left in blocks.items():
                for b, other in right.items():
                    if not same(left @ other, expected, 1e-8):
                        continue
                    if same(turn(left) @ other, now, 1e-8) or (
                        other.shape[2] == size and same(left @ turn(other), now, 1e-8)
                    ):
                        return "transposed", "a factor of the product is transposed", 0.0
                    if other.shape[2] == size and same(other @ left, now, 1e-8):
                        return (
                            "order of product",
                            f"the order is {self.found.place_text(a)} times {self.found.place_text(b)}",
                            0.0,
                        )
                    if other.shape[2] == size and same(turn(other) @ turn(left), now, 1e-8):
                        return "transposed", "the product is transposed", 0.0
        return None

    def _block(self, places, size):
        """The present values of some places as matrices, shape (samples, size, columns)."""
        parts = [np.broadcast_to(self.values.get(p, self.constant(p)), (SAMPLES,)) for p in places]
        return np.stack(parts, axis=-1).reshape(SAMPLES, size, -1)

    def _is_product(self, unit, now):
        """Whether a matrix is the product of two others, as it stands."""
        size = now.shape[1]
        others = [self._block(w, size) for w in self.found.windows if w != unit and len(w) == len(unit)]
        return any(same(a @ b, now, 1e-8) for a in others for b in others)


def copied(tree, rows):
    """A formula copied `rows` down: references without $ move along; None if one leaves the sheet."""
    for path, part in list(walk(tree)):
        if part[0] == "area" and not part[1].fixed[0]:
            area = part[1].moved(rows, 0)
            if area is None:
                return None
            tree = put(tree, path, ("area", area))
    return tree


def shape_of(tree):
    """A formula as text with all references alike."""
    for path, part in list(walk(tree)):
        if part[0] == "area":
            tree = put(tree, path, ("text", str(part[1].shape)))
    return text_of(tree)
