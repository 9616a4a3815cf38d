"""Right or wrong, and where: the earliest place where putting in the right thing makes all that follows right."""

from itertools import combinations, islice
from math import comb

import numpy as np

from mathpost import angles as euler
from mathpost.detective.misreadings import written_decimals
from mathpost.workbook.calculation import LARGEST_RADIANS, Calculation, Turn
from mathpost.workbook.edits import CONVERSIONS, TRIGONOMETRY, as_around, edits, flat, repaired
from mathpost.workbook.formula import Area, areas, heads, put, text_of, walk, with_areas
from mathpost.workbook.graph import SAMPLES, same
from mathpost.workbook.nc_table import Words, judge_numbers
from mathpost.workbook.report import Fault
from mathpost.workbook.values import read_labels, with_formulas

SEED = 20
OTHER_CONVENTION = "the elementary matrices are those of the other convention, active or passive"
UNEXPLAINED, UNLIKELY = (
    3.0,
    2.0,
)  # what a repair costs that no single change of the formula, or an odd one, explains
ORDERS = ("the matrix should be transposed", "a factor of the product is transposed", "the product is transposed")


class Judge:
    """Evaluate a recognised workbook at random inputs, compare, repair.

    After `run`, `faults` are the wrong cells in order, and `fixed` says what was put in where.
    """

    def __init__(self, graph, found):
        self.graph, self.found, self.inputs = graph, found, {}
        self.faults, self.fixed, self.warnings, self.reading, self.whole = [], {}, [], None, None
        self.live = [c for c in found.calculations if not c.typed]
        self.units, rng = self._units(), np.random.default_rng(SEED)
        spare = [] if found.task.machine else [Calculation((), tuple(found.angles), tuple(found.lengths))]
        for calculation in (*spare, *self.live):
            self.inputs.update(calculation.draw(rng, self.units))
        for place, numbers in self.inputs.items():
            numbers[0] = found.number(place)
        self.values = graph.run(self.inputs, self.inputs)

    def _units(self):
        """Degrees or radians: whole turns of which unit leave more sines and cosines as they are."""
        graph, units = self.graph, {}
        for calculation in self.live:
            places = calculation.angles
            after = [p for p in graph.downstream(places) if heads(graph.trees.get(p, ("text",))) & {"SIN", "COS"}]
            own = {p: np.array([self.found.number(p) + 0.3]) for p in places}
            base, degrees, radians = (
                graph.run(inputs, inputs)
                for turn in (0, 720, 4 * np.pi)  # half angles turn half as fast
                for inputs in [{p: number + turn for p, number in own.items()}]
            )
            votes = [sum(same(run[p], base[p], 1e-9) for p in after) for run in (degrees, radians)]
            in_degrees = votes[0] > votes[1] or max([abs(n[0]) for n in own.values()], default=0) > LARGEST_RADIANS
            units.update({p: np.pi / 180 if in_degrees else 1.0 for p in places})
        return units

    def now(self, place):
        """What is in a cell at the samples: shape (samples,), or (1,) of a constant."""
        if place in self.values:
            return self.values[place]
        value = self.graph.value(place)
        return np.full(1, np.nan if value is None else value)

    # The verdict.

    def run(self):
        """Judge every calculation; one that is wrong is repaired, so that the next ones are seen without it."""
        self._prepare(self.live)
        rows = [c for c in self.found.calculations if isinstance(c, Words)]
        live = [row for row in rows if not row.typed]
        for row in live:  # once more, on the branch that the table is on
            row.preferred = int(np.argmax(sum(r.votes for r in live)))
        self._prepare(live)
        self.targets = {p: t for c in self.live for p, t in c.targets.items()}
        for calculation in self.found.calculations[:1]:
            self._compare_the_inputs(calculation)
        bad = self.bad(self.targets)
        self.said = self._as_the_labels_say() if bad else {}
        if bad and not self.said and self.found.by == "source 000":
            self.reading = self._other_reading()
        for calculation in () if self.reading else self.live:
            self._repair(calculation)
        if typed := [row for row in rows if row.typed]:
            own = self.graph.run({})
            own |= {
                p: np.array([self.found.number(p)]) for r in typed for p in (*r.given, *r.results) if p not in own
            }
            for place, cause, message in judge_numbers(typed, {p: float(v[0]) for p, v in own.items()}):
                self._fault(place, cause, f"{self.graph.short(place)}: {message}")
        return self

    def _prepare(self, calculations):
        for calculation in calculations:
            places = (*calculation.given, *calculation.results)
            calculation.prepare({p: self.now(p) for p in places}, self.units)

    def _compare_the_inputs(self, calculation):
        """The numbers that the task gives, looked for in the input cells."""
        for name in ("angles", "point", "origin"):
            asked = getattr(self.found.task, name)
            for place, wanted in zip(getattr(calculation, name), asked or (), strict=False):
                number = self.found.number(place)
                unit = np.rad2deg(self.units[place]) if name == "angles" else 1.0
                half = 0.6 * 10.0 ** -min(written_decimals(number), 6) * unit + 1e-9
                if abs(number * unit - wanted) > half:
                    cause = "wrong value"
                    if any(abs(number * unit - other) <= half for other in asked):
                        cause = "wrong angle" if name == "angles" else "wrong point"
                    cause = "sign" if abs(number * unit + wanted) <= half else cause
                    text = f"{self.graph.short(place)} is {number * unit:.6g}, the task says {wanted:.6g}"
                    self._fault(place, cause, text)

    def _other_reading(self):
        """The sequence of other axes, nowhere named, that all results are of; None if there is none."""
        turns = [c for c in self.live if isinstance(c, Turn) and not c.axis]
        own = turns and (turns[0].sequence, turns[0].active)
        for sequence in (s for letters in euler.SEQUENCES if letters != "ZXZ" for s in (letters, letters.lower())):
            for active in (False, True):
                for turn in turns:
                    turn.sequence, turn.active = sequence, active
                self._prepare(turns)
                if turns and not any(self.bad(turn.targets) for turn in turns):
                    return sequence, "active" if active else "passive"
        for turn in turns:
            turn.sequence, turn.active = own
        self._prepare(turns)
        return None

    def bad(self, targets, values=None):
        """The targets that are missed."""
        look = self.now if values is None else lambda p: values.get(p, self.now(p))
        return [p for p, target in targets.items() if not same(look(p), target)]

    def _run(self, more=(), only=None):
        """The values with all that was put in, and `more`."""
        return self.graph.run(self.inputs, {**self.inputs, **self.fixed, **dict(more)}, only and self.values, only)

    def _repair(self, calculation):
        own = calculation.targets
        for _ in range(12):
            bad = self.bad(own)
            if not bad:
                return
            missed = set(self.bad(self.targets)) - set(own)
            targets = {p: t for p, t in self.targets.items() if p not in missed}
            found = self._as_in_the_row_above(own, bad) or self._against_the_labels(calculation, bad)
            found = found or self._earliest(calculation, targets, bad)
            if found is None:
                found = {p: targets[p] for p in bad}
                place = self._typed_over(bad)
                if place is not None:
                    self._fault(place, "typed over formula", self._typed_text(place))
                else:
                    text = "the result is not what the task asks for, and no single change makes it so"
                    self._fault(min(bad, key=self.graph.calculation_order), "wrong value", text)
            self.fixed.update(found)
            self.values = self._run()

    def _fault(self, place, cause, message):
        self.faults.append(Fault(self.graph.address(place), cause, message, place))

    def _typed_text(self, place):
        return f"{self.graph.short(place)} is a number, {self.graph.value(place):g}, typed where a formula belongs"

    def _as_the_labels_say(self):
        """Place → its values, of the labelled cells, if the labels say a calculation that meets the targets."""
        _, implied = read_labels(self.graph, by_numbers=False)
        if self.targets.keys().isdisjoint(implied):
            return {}
        whole = with_formulas(self.graph, implied)
        values = whole.run({p: v for p, v in self.inputs.items() if p not in implied})
        met = [p for p in self.targets if p in implied and not self.bad({p: self.targets[p]}, values)]
        reached = whole.upstream(met) & implied.keys()
        return {p: np.broadcast_to(values[p], SAMPLES) for p in whole.order if p in reached}

    def _against_the_labels(self, calculation, bad):
        """Put in what the labels say, step by step, until the results are right; None if they do not become so."""
        before, faults, put_in = self.values, [], {}
        scope = self.graph.upstream(bad) & self.said.keys()
        units = [*self.found.windows, *self._lines(calculation, scope)]
        while wrong := {p for p in scope if self.bad({p: self.said[p]})}:
            first = [p for p in wrong if len(self.graph.upstream([p]) & wrong) == 1]
            unit = (min(first, key=self.graph.calculation_order),)
            unit = next((w for w in units if unit[0] in w), unit)
            option = {p: self.said[p] for p in unit if p in wrong}
            faults += self._explain(calculation, unit, option)[1]
            put_in |= option
            self.values = self._run(put_in)
            if not self.bad({p: self.targets[p] for p in bad}):
                for place, cause, text in self._one_convention(faults) if len(faults) >= 6 else faults:
                    self._fault(place, cause, text)
                return put_in
        self.values = before
        return None

    @staticmethod
    def _one_convention(faults):
        """Faults that are all signs are those of the other convention."""
        signs = {cause for _, cause, _ in faults} == {"sign"}
        return [(p, "other convention", OTHER_CONVENTION) for p, *_ in faults] if signs else faults

    def _as_in_the_row_above(self, own, bad):
        """The same slip once more, one row further down: what was said there holds here."""
        for place in sorted(bad, key=self.graph.calculation_order):
            above = (place[0], place[1] - 1, place[2])
            for fault in [f for f in self.faults if f.place == above and self._in_table(place)]:
                if self.graph.form(above) == self.graph.form(place) is not None:
                    self._fault(place, fault.cause, f"{self.graph.short(place)}: as in the row above")
                    return {place: own[place]}
        return None

    def _in_table(self, place):
        return len(self.graph.component.get(place, ())) > 9

    def _typed_over(self, bad):
        """The first number on the way to a wrong result that is no input, nor a constant such as 0, 1 or π."""
        odd = self.graph.upstream(bad) & self.found.typed - self.graph.trees.keys()
        odd -= {p for c in self.found.calculations for p in c.given}
        odd -= self.graph.upstream(p for p in self.targets if p not in set(self.bad(self.targets)))
        constants = np.array([0, 1, -1, *CONVERSIONS])
        odd = [p for p in odd if not (np.abs(self.graph.value(p) - constants) <= 1e-3 * np.abs(constants)).any()]
        return min(odd, key=self.graph.calculation_order, default=None)

    # What else there is.

    def judge_the_rest(self):
        """Return all places to be judged, and those that could not be: they feed no result, and are nothing known."""
        graph = self.graph
        places = [p for p in graph.trees if p not in self.found.typed]
        places += sorted(graph.unread, key=graph.reading_order)
        places = [p for p in places if not self._is_text(p)]
        judged = graph.upstream(p for c in self.found.calculations for p in c.results)
        rest = sorted(set(places) - judged, key=graph.calculation_order)
        return places, [p for p in rest if p in graph.unread or not self._is_check(p)]

    def _is_text(self, place):
        """Whether a formula only makes a message."""
        cell = self.graph.cells[place]
        if cell.value is None:
            return "text" in heads(self.graph.trees.get(place, ("number", 0)))
        return isinstance(cell.value, str) and not cell.error

    def _is_check(self, place):
        """Judge a cell beside the calculation: a determinant, a length, a difference, a largest one of them."""
        value, functions = np.broadcast_to(self.now(place), SAMPLES), heads(self.graph.trees[place])
        if "MDETERM" in functions:
            return same(value, np.ones(SAMPLES))
        if not np.abs(value[1:]).max() > 1e-9 and "-" not in functions:
            return False  # zero without a difference: something empty was taken
        known = [np.ones(SAMPLES)]
        for calculation in self.live:
            known += [np.linalg.norm(vector, axis=0) for vector in calculation.known.get(3, ())]
            known += self._differences(calculation)
        return any(same(value, k) for k in known) or any(self._is_known(c, value) for c in self.live)

    def _differences(self, calculation):
        """The differences of a result to the numbers that stand below or beside it, and the largest of them."""
        for component in set(self.graph.component.values()) if calculation.known.get(3) else ():
            if len(component) == 3 and self.found.typed.issuperset(component):
                target = np.array([calculation.targets[p] for p in calculation.results[:3]])
                off = target - np.array([np.broadcast_to(self.now(p), SAMPLES) for p in component])
                yield from (*off, *-off, np.linalg.norm(off, axis=0))
                yield from (each.max(axis=0) for each in (off, -off, np.abs(off)))

    # Where.

    def _earliest(self, calculation, targets, bad):
        """The earliest repair, recorded; returns what it puts where."""
        best, scope = None, self.graph.upstream(bad)
        for order, unit, options in sorted(self._candidates(calculation, targets, bad, scope), key=lambda c: c[0]):
            if best and best[0] == 0 and order > best[1]:
                break
            for option in options:
                cost, faults = self._explain(calculation, unit, option)
                if best is None or (cost, order) < best[:2]:
                    best = (cost, order, option, faults)
        if best is None or (best[0] >= UNEXPLAINED and self._typed_over(bad)):
            return None
        for fault in best[3]:
            self._fault(*fault)
        return best[2]

    def _candidates(self, calculation, targets, bad, scope):
        """(order, cells, what may belong there): matrices, vectors, a cosine with its sine, single cells, everything."""
        graph, found = self.graph, self.found
        blocks = [w for w in found.windows if not scope.isdisjoint(w)]
        inside, pairs = {p for window in blocks for p in window}, {}
        for place in scope & graph.trees.keys() - inside - self.inputs.keys():
            if heads(graph.trees[place]) & {"SIN", "COS", "TAN"}:
                pairs.setdefault(tuple(graph.uses[place]), []).append(place)
        blocks += [*self._lines(calculation, scope), *(tuple(pair) for pair in pairs.values() if len(pair) == 2)]
        for block in blocks:
            order = min(map(graph.calculation_order, [p for p in block if p in graph.trees] or block))
            options = [dict(zip(block, known, strict=True)) for known in calculation.known.get(len(block), ())]
            yield (*order, len(block)), block, self._tried(options, targets)
        for place in scope & (graph.trees.keys() | found.constants) - self.inputs.keys():
            options = self._cell_options(calculation, place, targets, bad)
            yield (*graph.calculation_order(place), 0), (place,), options
        self.whole = tuple(sorted(scope & graph.trees.keys(), key=graph.calculation_order))
        if isinstance(calculation, Turn):
            yield (98, (0,), 0), self.whole, self._tried(self._everywhere(calculation), targets)

    def _lines(self, calculation, scope):
        """Triples and quadruples of vector cells."""
        lines = [calculation.results]
        for component in {self.graph.component[p] for p in scope & self.found.vectors if p in self.graph.component}:
            if len(component) in (3, 4) and len(self.found.vectors.intersection(component) & scope) >= 2:
                lines.append(component)
        return dict.fromkeys(lines[::-1])

    def _tried(self, options, targets):
        """Of the options (place → value) what they change, of those that meet the targets."""
        return (changed for option in options if (changed := self._try(option, targets)))

    def _try(self, option, targets):
        changed = {p: value for p, value in option.items() if not same(self.now(p), value)}
        affected = self.graph.downstream(changed)
        if not changed or not affected.issuperset(self.bad(targets)):
            return None
        return None if self.bad(targets, self._run(changed, affected)) else changed

    def _cell_options(self, calculation, place, targets, bad):
        wanted, linear = self._solve(place, targets, bad)
        if wanted is not None:
            yield {place: wanted}
        elif not linear:
            options = ({place: value} for value in self._plausible(calculation, place))
            yield from islice(self._tried(options, targets), 1)

    def _solve(self, place, targets, bad):
        """The value of one cell that makes all targets right, or None; and whether they are linear in it."""
        if place in targets:
            return (targets[place] if self._try({place: targets[place]}, targets) else None), True
        now = np.broadcast_to(self.now(place), SAMPLES)
        now = now if np.isfinite(now[1:]).all() else np.zeros(SAMPLES)
        affected = self.graph.downstream([place])
        if not affected.issuperset(bad):
            return None, True
        runs = [self._run({place: now + step}, affected) for step in (0.0, 1.0, 2.0)]
        wanted, steepest = np.array(now), np.full(SAMPLES, 1e-9)
        for target, value in targets.items():
            f0, f1, f2 = (np.broadcast_to(run.get(target, self.now(target)), SAMPLES) for run in runs)
            slope = f1 - f0
            if not np.isfinite(slope[1:]).all() or not same(f2 - f1, slope, 1e-7):
                return None, False
            steeper = np.abs(slope) > steepest
            if target in bad:
                wanted = np.where(steeper, now + (value - f0) / np.where(steeper, slope, 1), wanted)
                steepest = np.maximum(steepest, np.abs(slope))
        wanted[0] = np.nan if steepest[0] < 1e-8 else wanted[0]
        return (wanted if self._try({place: wanted}, targets) else None), True

    def _plausible(self, calculation, place):
        """What a cell may have to hold on which results depend in a curved way: an angle, a repaired formula."""
        if place in self.found.turning:
            for angle in calculation.radians.T:
                yield from (s * a for a in (angle, np.rad2deg(angle)) for s in (1, -1))
        seen = [self.now(place)]
        for _, _, tree in edits(self.graph, place) if place in self.graph.trees else ():
            value = np.broadcast_to(self.graph.cell(place, self.values, tree), SAMPLES)
            if np.isfinite(value[1:]).all() and not any(same(value, s) for s in seen):
                seen.append(value)
                yield value
            if len(seen) > 60:
                break
        if isinstance(calculation, Turn):
            yield from (sign * entry for entry in calculation.scalars() for sign in (1, -1))

    def _everywhere(self, turn):
        """The same slip in many places: all sines in degrees, all elementary matrices of the other convention."""
        option = {}
        for place in self.whole:
            tree = self.graph.trees[place]
            for path, part in reversed(list(walk(tree))):
                if part[0] in TRIGONOMETRY:
                    tree = put(tree, path, (part[0], ("RADIANS", part[1])))
            option[place] = np.broadcast_to(self.graph.cell(place, self.values, tree), SAMPLES)
        yield {p: v for p, v in option.items() if heads(self.graph.trees[p]) & TRIGONOMETRY.keys()}
        elements = self._elements(turn)
        yield {p: v for window, (_, other) in elements.items() for p, v in _as_window(window, other).items()}
        for first, second in combinations(elements, 2):
            for a in turn.elements:
                for b in turn.elements:
                    option = _as_window(first, a) | _as_window(second, b)
                    if self.bad({p: option[p] for p in first}) and self.bad({p: option[p] for p in second}):
                        yield option

    def _elements(self, turn):
        """The windows that are elementary matrices now → their sense of rotation, and what the other would be."""
        found, half = {}, len(turn.elements) // 2
        for window in self.found.windows:
            for n, element in enumerate(turn.elements):
                if not self.bad(_as_window(window, element)):
                    found[window] = n < half, turn.elements[n - half]
        return found

    # Why.

    def _explain(self, calculation, unit, option):
        """The cost of a repair, and its faults as (place, cause, sentence), the first one first."""
        graph, faults, done, cost = self.graph, [], set(), 0.0
        in_window = unit in self.found.windows
        places = sorted(option, key=graph.reading_order if in_window else graph.calculation_order)
        if in_window and self.found.typed.issuperset(places):  # a typed matrix: what is wrong by its number first
            places.sort(key=lambda p: abs(option[p][0] - graph.value(p)) < 1e-9)
        elements = self._elements(calculation) if isinstance(calculation, Turn) else {}
        whole = len(places) > 2 or (in_window and unit not in elements)
        block = self._of_the_block(calculation, unit, option) if whole else None
        for place in places:
            if place not in done:
                array = self._array(place)
                done.update(array)
                wanted = {p: option.get(p, self.now(p)) for p in array}
                *fault, more = block or self._cause(calculation, place, wanted)
                cost = max(cost, more)
                faults.append((place, *fault))
        if unit is self.whole:
            return 0.0, self._one_convention(faults)
        if unit in elements and len(places) == 2:  # do the others turn the same way?
            senses = [sense for sense, _ in elements.values()]
            cost = UNLIKELY if senses.count(elements[unit][0]) > 1 else 0.0
        elif len(unit) == 1 and any(unit[0] in window for window in elements):
            cost += UNLIKELY  # an elementary matrix as it stands
        elif not block:
            cost += 0.25 * (len(faults) - 1)
        return cost, faults

    def _array(self, place):
        """The cells of the array formula that a cell is of, itself first; or the cell alone."""
        if place not in self.graph.part:
            return [place]
        anchor, tree = self.graph.cells[place].anchor, self.graph.trees.get(place)
        mates = [p for p in self.graph.part if self.graph.cells[p].anchor == anchor and p[0] == place[0]]
        return [place, *(p for p in mates if p != place and self.graph.trees.get(p) is tree)]

    def _cause(self, calculation, place, wanted):
        """Cause, sentence and cost of one wrong cell, or of an array formula."""
        graph, value = self.graph, wanted[place]
        cell, short = graph.cells.get(place), graph.short(place)
        known = place in self.targets or self._is_known(calculation, value)
        if cell is None:
            return "wrong value", f"{short} is empty", UNEXPLAINED
        if place not in graph.trees:
            if cell.number is None:
                return "wrong value", f"{short} holds {cell.value!r} where a number belongs", 0.0
            if np.ptp(value[1:]) < 1e-9:
                cost = 0.0 if np.abs(value[1] - [0, 1]).min() < 1e-9 else UNLIKELY
                return "wrong value", f"{short} is {cell.number:g}, should be {value[1]:g}", cost
            known |= not abs(value[0] - cell.number) > 5e-3
            cost = 0.0 if known and cell.number not in (0, 1, -1) else UNLIKELY * 1.1
            return "typed over formula", self._typed_text(place), cost
        found = repaired(graph, wanted, self.values, calculation.given)
        if found is None:
            found, cost = self._missing(calculation, place, value), 0.2
            if found is None:
                text, cost = (
                    f"={text_of(graph.trees[place])} is not what belongs there",
                    UNEXPLAINED + 9 * (not known),
                )
                found = "wrong value", text
            return found[0], f"{short}: {found[1]}", cost
        cause, sentence, tree = found
        odd = cause == "sign" and self._looks_right(place, tree)
        if cause == "wrong reference":
            cause = self._reference_kind(place, tree)
        return cause, f"{short}: {sentence}", UNLIKELY * odd

    def _looks_right(self, place, other):
        """Whether the sign of a formula is as one expects: those around it agree, or a minus before all would be odd."""
        tree, around = self.graph.trees[place], as_around(self.graph, place)
        if around is not None and "minus" not in heads(other):
            return around == tree
        plain = tree[0] in ("+", "-") or ("minus" not in heads(tree) and (tree[0] != "area"))
        return around == tree or (other == ("minus", tree) and plain)

    def _reference_kind(self, place, other):
        """Name a wrong reference: a missing $, a different angle, a different point, or just a different cell."""
        old, new = next(
            (a, b) for a, b in zip(*map(areas, (self.graph.trees[place], other)), strict=True) if a != b
        )
        above = self.graph.trees.get((place[0], place[1] - 1, place[2]), ("text", ""))
        if old.top > new.top and not old.fixed[0] and self._in_table(place) and str(new) in map(str, areas(above)):
            return "missing $"
        a, b = ((area.sheet, area.top, area.left) for area in (old, new))
        if b in self.found.angles:
            return "wrong angle"
        return "wrong point" if {a, b} <= self.found.lengths else "wrong reference"

    def _is_known(self, calculation, value):
        """Whether a value is an entry of one of the matrices or vectors that may stand in the sheet."""
        return any(same(value, entry, 1e-7) for known in calculation.known.values() for k in known for entry in k)

    def _missing(self, calculation, place, value):
        """A term that is missing from a sum: one like those of the cells around, or a product of cells."""
        graph, lacking, (sheet, row, column) = self.graph, value - self.now(place), place
        if not np.isfinite(lacking[1:]).all():
            return None
        around = graph.component[place]
        around = around if len(around) <= 16 else [p for p in around if p[1] == row]
        trees, copies = [graph.trees[p] for p in around if p in graph.trees], []
        for step in (-1, 1):
            near = graph.trees.get((sheet, row + step, column), ("text",))
            moved = [area if area.fixed[0] else area.moved(-step, 0) for area in areas(near)]
            copies += [with_areas(near, moved)] * bool(moved and all(moved))
        pool = dict.fromkeys([*(s for p in around for s in graph.uses.get(p, ())), *calculation.given])
        factors = [("area", Area(*p, *p[1:])) for p in pool if p in graph.cells]
        factors += [part for tree in trees for _, part in walk(tree) if part[0] in TRIGONOMETRY]
        terms = [("number", float(lacking[1]))] + [term for tree in copies for _, term in flat(tree)]
        single = {text_of(part): graph.calculate(part, self.values)[:, 0, 0] for part in factors}
        named = {text_of(term): graph.calculate(term, self.values)[:, 0, 0] for term in terms}
        for depth in (1, 2, 3, 4):
            for chosen in combinations(single, depth) if comb(len(single), depth) < 20_000 else ():
                named["*".join(chosen)] = np.prod(np.broadcast_arrays(*map(single.get, chosen)), axis=0)
        for text, number in named.items():
            if same(lacking, number, 1e-7) or same(lacking, -number, 1e-7):
                return "missing term", f"the term {text} is missing"
        return None

    def _of_the_block(self, calculation, unit, option):
        """Why a whole matrix or vector is wrong, with the cost: it or a factor is transposed, the order of a product."""
        size = {9: 3, 16: 4, 3: 3, 4: 4}.get(len(unit))
        if size is None:
            return None
        now, wanted = self._block(unit, size), self._block(unit, size, option)
        windows = {w: self._block(w, size) for w in self.found.windows if len(w) == size * size and w != unit}
        if now.shape[2] == size and same(now, _turned(wanted)):
            copy = all(self.graph.trees.get(p, ("",))[0] == "area" for p in unit)
            copy &= any(same(w, now) for w in windows.values())
            known = [k for k in calculation.known.get(len(unit), ()) if same(k, self._cells(now))]
            known += [
                w for w in windows.values() if same(w, wanted) or any(same(w @ v, now) for v in windows.values())
            ]
            return "transposed", ORDERS[0], UNLIKELY * bool(known and not copy)
        others = windows
        if now.shape[2] == 1:
            lines = {c for c in self.graph.component.values() if len(c) == size and c != unit}
            others = {c: self._block(c, size) for c in lines}
        for a, left in windows.items():
            for b, right in others.items():
                square = right.shape[2] == size
                if not same(left @ right, wanted):
                    continue
                if same(_turned(left) @ right, now) or (square and same(left @ _turned(right), now)):
                    return "transposed", ORDERS[1], 0.0
                if square and same(right @ left, now):
                    return (
                        "order of product",
                        f"the order is {self.graph.range(a)} times {self.graph.range(b)}",
                        0.0,
                    )
                if square and same(_turned(right) @ _turned(left), now):
                    return "transposed", ORDERS[2], 0.0
        return None

    def _block(self, places, size, option=()):
        """Places as matrices, shape (samples, size, columns): their values, or what `option` puts there."""
        parts = [np.broadcast_to(dict(option).get(p, self.now(p)), SAMPLES) for p in places]
        return np.stack(parts, axis=-1).reshape(SAMPLES, size, -1)

    @staticmethod
    def _cells(matrix):
        return matrix.reshape(SAMPLES, -1).T


def _turned(matrix):
    return np.swapaxes(matrix, 1, 2)


def _as_window(window, matrix):
    """Place → what stands there if a window is a matrix of 3×3, in 4×4 where it is larger."""
    if len(window) == 16:
        matrix = np.pad(matrix, ((0, 0), (0, 1), (0, 1))) + np.diag([0, 0, 0, 1.0])
    return dict(zip(window, matrix.reshape(len(matrix), -1).T, strict=True))
