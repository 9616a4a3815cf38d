"""What stands beside a calculation: lengths, distances, sums and means, differences, angles computed back.

No task asks for these. Each is judged as what it is: one of the numbers and vectors that follow from right results.
"""

import re
from collections import Counter
from itertools import combinations, product

import numpy as np

from mathpost import angles as euler
from mathpost.detective.misreadings import written_decimals
from mathpost.rotation import wrap
from mathpost.workbook.around import Around
from mathpost.workbook.calculation import SAMPLES, Turn
from mathpost.workbook.conversion import Conversion
from mathpost.workbook.edits import INVERSE, edits, repaired, said
from mathpost.workbook.formula import STATISTICS, areas, heads, unrounded, walk
from mathpost.workbook.given import runs
from mathpost.workbook.graph import CLOSE, at, beside, offset, same
from mathpost.workbook.neighbours import as_around
from mathpost.workbook.plane_angles import Plane
from mathpost.workbook.why import TRANSPOSED

MOST = 20  # points of which each two are compared
# What stands beside such a word is made of others.
COMPARED = r"max|diff|error|fehler|abweich|差|Δ|\||norm|betrag|\bdet"
BETWEEN = r"[xyz]['’′]?[ –/,-]+[xyz]['’′]|between|zwischen|entre|夹角"
CORNERS = 6  # points of which each two edges are


class Beside:
    """Judge what is left once a `Judge` has judged the calculations.

    `places` are all cells to judge, `unjudged` those that could not be: no result needs them, and they are nothing
    that is known. A vector with a single wrong cell is added to the judge's faults.
    """

    def __init__(self, judge):
        self.judge, self.graph, self.found = judge, judge.graph, judge.found
        self.turns = [c for c in judge.live if isinstance(c, Turn)]
        self.turns += [c.turn for c in judge.live if isinstance(c, Conversion)]
        self.pairs, self.off, self.lengths, self.tried = [], [], [], set()
        self.vectors = self._known_vectors()
        self.places, rest = self._scope()
        self.numbers, self.angles = self._known_numbers()
        before = len(judge.faults)
        around = self.around = Around(judge, self._is_known, self.norms)
        judge.faults += () if judge.unexplained else around.faults(rest)
        rest -= self._judge_vectors(rest)
        self._compare_copies(rest)
        self._compare_solutions(rest)
        composed = {p for p in self.found.composed if not (self._is_degrees_and_minutes(p) or self._goes_on(p))}
        composed -= {p for p in judge.found.sorted(composed) if self._are_wrong_minutes(p)}
        typed = self.found.typed - self.found.composed
        unknown = {
            p for p in rest - self.found.composed - judge.fixed.keys() if p in typed or not self._is_known(p)
        }
        for place in sorted(unknown - typed, key=judge.graph.calculation_order):
            follows = self.graph.upstream([place]) & unknown != {place}
            told = self._is_known(place) or (
                not follows
                and (
                    self._is_made_of_known(place, unknown)
                    or (
                        not self._is_another_angle(place)
                        and (self._is_unlike(place, unknown) or self._is_nearly_known(place))
                    )
                )
            )
            unknown -= {place} if told else set()
        own = judge.faults[before:]
        judge.faults[before:] = sorted(own, key=lambda fault: self.graph.calculation_order(fault.place))
        self.unjudged = unknown | around.doubtful | composed | self._computed_points()

    def _scope(self):
        """The cells to judge, and those of them that no result needs."""
        judge, graph, found = self.judge, self.graph, self.found
        messages = graph.messages | ({p for c in judge.live for p in c.aside} - graph.downstream(judge.inputs))
        formulas = [p for p in graph.trees if p not in found.typed - found.composed] + [*graph.unread]
        # A number of many digits, or 0, that only messages use was a formula; another is their tolerance.
        typed = found.typed - graph.trees.keys()
        unused = {p for p in typed - graph.used.keys() if re.search(COMPARED, found.label(p), re.I)}
        typed = {p for p in typed if messages.issuperset(graph.used.get(p, "-"))} | unused
        typed = {p for p in typed if float(f"{graph.value(p):.2g}") != graph.value(p) or graph.value(p) == 0}
        results = np.array([target[0] for target in judge.targets.values()])
        typed = {p for p in typed if not (np.abs(results - graph.value(p)) <= _half_digit(graph.value(p))).any()}
        places = [p for p in formulas if p not in messages] + sorted(typed, key=graph.reading_order)
        results = (p for c in found.calculations if c not in judge.unexplained for p in c.results)
        rest = set(places) - (graph.upstream(results, judge.inputs) - judge.inputs.keys()) | judge.unsure
        given = graph.upstream(p for c in found.calculations for p in (*c.given, *c.results))
        leaves = {p: graph.upstream([p]) - graph.trees.keys() for p in rest}
        # The numbers of points, 1, 2, 3, copied beside what became of them.
        copies = {p for p in rest - graph.used.keys() if graph.tree(p)[0] == "area" and given.isdisjoint(leaves[p])}
        own = {p: graph.own[p] for p in copies if graph.own[p] is not None}
        other = {p for p in own for q in beside(p) if q in own and abs(own[q] - own[p]) == 1}
        given |= {p for c in {id(c): c for c in map(graph.component.get, given) if c}.values() for p in c}
        other |= {
            p for p, used in leaves.items() if used and given.isdisjoint(used) and _is_count_or_mean(graph.tree(p))
        }
        return [p for p in places if p not in other], rest - other

    def _computed_points(self):
        """Formulas that make points or origins of other numbers, which the task does not say; but for means."""
        graph, judge = self.graph, self.judge
        points = {places for turn in self.turns for places in (turn.point, turn.origin)} - {()}
        points = [p for p in points if not any(same(judge.block(p), known) for known in self.combined)]
        up = graph.upstream((p for places in points for p in places), judge.targets)
        up -= judge.targets.keys() | judge.inputs.keys()
        return {p for p in up & graph.trees.keys() if graph.trees[p][0] != "area" and graph.uses[p]}

    def _known_vectors(self):
        """Points and what became of them, their sums, means, extremes, and the differences of each two."""
        graph, judge, lists, everywhere, found = self.graph, self.judge, {}, {}, self._in_planes()
        for turn in self.turns:
            found += [*turn.known.get(3, ()), *_axes(turn)]
            result = np.array([*turn.targets.values()])
            if not turn.point or len(result) > 4:
                continue
            point, result = judge.block(turn.point), result[:3]
            self.pairs.append((point, result))
            found += [result - point, point - result]
            found += [each / np.linalg.norm(each, axis=0) for each in (point, result)]
            points = [(turn.point, point), (turn.results, result)]
            if turn.origin:
                points.append((turn.origin, point - judge.block(turn.origin)))
            for n, (places, vector) in enumerate(points):
                lists.setdefault((id(graph.component[turn.results[0]]), n), {})[turn.results] = vector
                everywhere.setdefault(n, {})[places] = vector
            for places in self._expected(turn.results[:3]):
                off = result - judge.block(places)
                self.off.append(np.abs(off))
                found += [off, -off, self.off[-1]]
                for n, vector in ((3, off), (4, -off)):
                    lists.setdefault((id(graph.component[turn.results[0]]), n), {})[turn.results] = vector
        every, single = [*lists.values(), *everywhere.values()], len(found)
        for vectors in (np.array([*each.values()]) for each in every if len(each) > 1):
            statistics = np.sum, np.mean, np.max, np.min, np.ptp, np.std, _of_a_sample, _largest, _squares
            found += [statistic(vectors, axis=0) for statistic in statistics]
            self.lengths += [np.linalg.norm(each, axis=1) for each in (vectors, vectors - vectors.mean(axis=0))]
        for vectors in everywhere.values():
            for a, b in combinations(vectors.values(), 2) if len(vectors) <= MOST else ():
                found += [a - b, b - a, a + b, (a + b) / 2] * (not np.array_equal(a, b))
                self.pairs.append((a, b))
            edges = [b - a for a, b in combinations(vectors.values(), 2) if len(vectors) <= CORNERS]
            self.pairs += [(sign * a, b) for a, b in combinations(edges, 2) for sign in (1, -1)]
        self.combined = np.array(found[single:]).reshape(-1, 3, SAMPLES)
        return np.array(found).reshape(-1, 3, SAMPLES)

    def _in_planes(self):
        """Points in the frame of a plane, from any other point: of sheets that turn them without the angles."""
        found, judge = [], self.judge
        for plane in (c for c in judge.live if isinstance(c, Plane) and c.frame is not None):
            points = [line for line in runs(self.found.lengths.difference(plane.given)) if len(line) == 3][:MOST]
            points = [judge.block(line) for line in points]
            for point, origin in product(points, (0, *points, *(judge.block(p) for p in [plane.corner] if p))):
                found.append(np.einsum("sji,js->is", plane.frame, point - origin))
        return found

    def _expected(self, results):
        """Numbers in threes with which a result may be compared: apart, or where a difference is made."""
        given = {p for turn in self.turns for p in turn.given}
        for component in self.graph.components:
            if len(component) == 3 and (self.found.typed - given).issuperset(component):
                yield component
        for users in product(*(self.graph.used.get(p, ()) for p in results)):
            given = [[s for s in self.graph.uses[p] if s in self.found.typed] for p in users]
            if [len(each) for each in given] == [1, 1, 1] and len(set(users)) == 3:
                a, b, c = (place for (place,) in given)
                if a != b and not np.ptp(np.diff([a[1:], b[1:], c[1:]], axis=0), axis=0).any():  # in line
                    yield a, b, c
            elif len(given[0]) == 3 and len(set(users)) == 1:
                yield tuple(given[0])

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
            fits = _agree(judge.block(triple[:3]), self.vectors)
            if fits.all(axis=-1).any():
                judged.update(triple)
                self.around.doubtful.update(triple if self._is_of_another_row(triple[:3]) else ())
                continue
            for n in np.flatnonzero(fits.sum(axis=-1) == 2)[:1]:
                (k,) = np.flatnonzero(~fits[n])
                known = triple in others and self._is_known(triple[k])
                place, wanted, fault = triple[k], self.vectors[n, k], None
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

    def _is_of_another_row(self, triple):
        """Whether a vector, calculated in the row of a table, is the point or result of another row only."""
        rows = {turn.results[0][:2]: turn for turn in self.turns if turn.point and len({*turn.results[:3]}) == 3}
        own = rows.pop(triple[0][:2], None)
        if own is None or len(rows) < 2 or all(self.graph.tree(p)[0] == "area" for p in triple):
            return False
        judge, now = self.judge, self.judge.block(triple)

        def is_of(turn):
            return same(now, judge.block(turn.point)) or same(now, np.array([*turn.targets.values()][:3]))

        return not is_of(own) and any(map(is_of, rows.values()))

    def _compare_copies(self, rest):
        """Record copies of a result's three cells in another order than theirs, and than their labels say."""
        copies = {p: s for p in rest if (s := self._copied(p)) != p}
        for turn in self.turns:
            mine = [p for p in self.found.sorted(copies) if copies[p] in turn.results[:3]]
            for line in {tuple(p for p in mine if (p[0], p[n]) == (q[0], q[n])) for q in mine for n in (1, 2)}:
                said = [self.found.coordinate(p) for p in line]
                order = [word[0] for word in said] if len({*said} - {None}) == 3 else [0, 1, 2]
                for place, k in zip(line, order, strict=True) if len(line) == 3 else ():
                    if copies[place] != turn.results[k]:
                        text = f"{self.graph.short(copies[place])} should be {self.graph.short(turn.results[k])}"
                        text = f"{self.graph.short(place)}: {text}"
                        self.judge.faults.append(self.judge.fault(place, "wrong reference", text))

    def _compare_solutions(self, rest):
        """Record an angle computed back that is of the other solution, or in the other unit, than those beside it.

        Or that is another angle than its label says.
        """
        judge = self.judge
        inverse = [p for p in self.found.sorted(rest) if heads(self.graph.tree(p)) & INVERSE]
        for turn in {turn.angles: turn for turn in self.turns if _has_angles(turn)}.values():
            found, (_, *both) = [], _solutions(turn)
            for place, (k, angle) in product(inverse, enumerate(np.transpose(both, (2, 0, 1)))):
                for unit in (1.0, np.pi / 180):
                    off = np.abs(wrap(judge.now(place) * unit - angle, 2 * np.pi))[:, 1:]
                    fits = off.max(axis=1) < 1e-6
                    found += [(place, k, fits, angle, unit)] if fits.any() else []
            votes = np.sum([fits for _, _, fits, *_ in found], axis=0)
            units, counts = Counter(unit for *_, unit in found), Counter(k for _, k, *_ in found)
            for place, k, fits, angles, unit in found:
                said, solution = self._angle_said(place), int(votes.argmax())
                usual = max(units, key=units.get)
                if said not in (None, k) and all(said != other for p, other, *_ in found if p == place):
                    text = f"is {'αβγ'[k]}, and {'αβγ'[said]} belongs there"
                    self._record(place, both[solution][:, said] / unit, "wrong angle", text)
                elif not fits[solution] and {*counts.values()} == {1}:
                    text = "is of the other solution than the angles beside it"
                    self._record(place, angles[solution] / unit, "branch", text)
                elif unit != usual and len(found) > 2 and units[unit] == 1:
                    text = f"is in {'radians' if unit == 1 else 'degrees'}, the angles beside it are not"
                    cause = "radians for degrees" if unit == 1 else "degrees for radians"
                    self._record(place, angles[int(fits.argmax())] / usual, cause, text)

    def _record(self, place, value, cause, text):
        """Record the repair that makes a cell have a value, or else why it is wrong."""
        fault = self.judge.repaired_alone(place, value)
        self.judge.faults.append(fault or self.judge.fault(place, cause, f"{self.graph.short(place)} {text}"))

    def _angle_said(self, place):
        """Which angle the text before a cell names; None if it names none, or several."""
        letters = {*re.findall("[αβγ]|alpha|beta|gamma", self.found.label(place).lower())}
        return ("α", "β", "γ", "alpha", "beta", "gamma").index(*letters) % 3 if len(letters) == 1 else None

    def _copied(self, place):
        """The cell of which a cell is a copy, or a copy of a copy."""
        graph = self.graph
        while graph.tree(place)[0] == "area" and len(graph.uses[place]) == 1 and place not in graph.circular:
            (place,) = graph.uses[place]
        return place

    def _repaired_before(self, wanted, rest):
        """The fault of an earlier cell of `rest`, nothing known, if one repair of it makes all `wanted` right."""
        graph, judge = self.graph, self.judge
        earlier = graph.upstream(wanted) & rest & graph.trees.keys() - wanted.keys() - self.tried
        for first in sorted(earlier, key=graph.calculation_order):
            if first in self.tried or self._is_known(first):
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
        if self.judge.unexplained or not of_points or any(map(self._is_known, triple)):
            return False
        judge, tried = self.judge, []
        fits = (np.ptp(self.combined[..., 1:], axis=-1) > CLOSE).all(axis=-1)  # no zeros, as of two that are equal
        for k, place in enumerate(triple):
            repairs = [*edits(self.graph, place)] if place in self.graph.trees else []
            repairs = [each for each in repairs if self.graph.component.keys() >= {*self.graph.used_by(each[3])}]
            own, part = areas(self.graph.tree(place)), self.around.is_of_a_part(place)
            wholes = [] if part else [[self.around.whole(area, place) for area in own]]
            sizes = [area.shape for area in own]
            repairs = [e for e in repairs if areas(e[3]) in wholes or [a.shape for a in areas(e[3])] == sizes]
            made = np.array([judge.calculate(place, tree) for *_, tree in repairs]).reshape(-1, 1, SAMPLES)
            tried.append((repairs, _agree(made, self.combined[:, k])))
            fits &= tried[-1][1].any(axis=0)
        for n in np.flatnonzero(fits)[:1]:
            found = [repairs[int(good[:, n].argmax())] for repairs, good in tried]
            if len({cause for cause, *_ in found}) == 1:
                judge.put(dict(zip(triple, self.combined[n], strict=True)))
                for place, (cause, old, new, _) in zip(triple, found, strict=True):
                    judge.faults.append(self._fault(place, cause, old, new))
                return True
        return False

    def _known_numbers(self):
        """What may stand in one cell, each of shape (samples,), and pairs of angles of which it may be either."""
        judge = self.judge
        numbers = [1.0, 0.0, 3.0, *(entry for c in judge.live for entry in c.entries)]  # 3: the trace of R·Rᵀ
        norms = [*np.linalg.norm(self.vectors, axis=1)]
        if self.off:
            numbers.append(np.max(self.off, axis=(0, 1)))
            norms.append(np.linalg.norm(self.off, axis=1).max(axis=0))
        for each in self.lengths:
            norms += [*each, np.sqrt((each**2).mean(axis=0))]
            norms += [statistic(each, axis=0) for statistic in (np.sum, np.mean, np.max, np.min)]
        norms = [0.0, 1.0, 3**0.5, *norms]  # that of R, as of nine numbers
        self.norms = np.array([np.broadcast_to(each, SAMPLES) for each in norms])
        numbers += [*self.vectors.reshape(-1, SAMPLES), *norms, *(each.max(axis=0) for each in self.vectors)]
        products = [(a * b).sum(axis=0) for a, b in self.pairs]
        between = [
            np.arctan2(np.linalg.norm(np.cross(a, b, axis=0), axis=0), (a * b).sum(axis=0)) for a, b in self.pairs
        ]
        angles, numbers = [np.array([angle, angle]) for angle in between], numbers + products
        for turn in self.turns:
            traces = [matrix[0] + matrix[4] + matrix[8] for matrix in turn.known[9]]
            numbers += traces
            angles += [np.array([angle, -angle]) for angle in np.arccos(np.clip((np.array(traces) - 1) / 2, -1, 1))]
            if _has_angles(turn):
                for solution in _solutions(turn):
                    angles += [[each, each] for each in (*solution.T, *(solution - turn.radians).T)]
        angles = np.array(angles).reshape(-1, 2, SAMPLES)
        return np.array([np.broadcast_to(number, SAMPLES) for number in numbers]), angles

    def _is_known(self, place, tree=None):
        """Whether a formula, or another in its place, is a determinant, a length, an angle computed back."""
        if place not in self.graph.trees:
            return False
        tree = tree or self.graph.trees[place]
        value, functions = self.judge.calculate(place, unrounded(tree)), heads(tree)
        is_angle = not functions.isdisjoint({*INVERSE, "DEGREES"})
        is_angle |= tree[0] == "-" and not self.found.turning.isdisjoint(self.graph.uses[place])
        if self.graph.component.keys().isdisjoint(self.graph.uses[place]):
            return False  # something empty was taken
        if tree[0] == "COUNT" and tree[1][0] == "area":  # of a whole column
            column, rows = tree[1][1].places, self.graph.component
            around = offset(column[0], -1, 0), offset(column[-1], 1, 0)
            return rows.keys() >= set(column) and rows.keys().isdisjoint(around)
        for radians in (value, np.deg2rad(value)) if is_angle else ():
            off = np.abs(wrap(radians - self.angles, 2 * np.pi)).min(axis=1)
            if (off[:, 1:].max(axis=1) < 1e-6).any():
                return True
        known = self.numbers[:1] if "MDETERM" in functions else self.numbers
        fits = np.abs(value - known) <= CLOSE * (1 + np.abs(known))
        fits[:, 0] |= ~np.isfinite(value + known)[:, 0]
        return bool(fits.all(axis=1).any())

    def _is_made_of_known(self, place, unknown):
        """Whether a cell is a sum, mean or extreme of known cells of one form, their square or difference."""
        graph, tree = self.graph, unrounded(self.graph.tree(place))
        tree = tree[1] if tree[0] == "SQRT" else tree
        used = graph.used_by(tree)
        alike = len({*map(graph.form, used)} - {None}) == 1 and all(map(graph.form, used))
        of_one = tree[0] == "^" and tree[1][0] == "area" and tree[2] == ("number", 2.0)
        of_two = tree[0] == "-" and tree[1][0] == tree[2][0] == "area" and len(used) == 2
        of_many = tree[0] in STATISTICS - {"SUMSQ"} and len(tree) == 2 and tree[1][0] == "area" and len(used) > 1
        return alike and (of_one or of_two or of_many) and {*self.places} >= set(used) and unknown.isdisjoint(used)

    def _is_unlike(self, place, unknown):
        """Whether a wrong reference keeps a cell from what one beside it is, as a length that is kept: a fault."""
        graph, judge = self.graph, self.judge
        if place not in graph.trees:
            return False
        form = [part[0] for _, part in walk(graph.tree(place))]
        chain = not set(beside(place)).isdisjoint(graph.uses.get(place, ()))  # as a sum that goes on
        for near in beside(place) if not (judge.unexplained or chain) else ():
            wanted, like = judge.now(near), [part[0] for _, part in walk(graph.tree(near))]
            alike = [p for p in graph.component[place] if graph.form(p) == graph.form(near)]
            once = np.ptp(wanted) <= CLOSE and sum(same(judge.now(p), wanted) for p in alike) < 2
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
        named = self._angle_said(place) is not None
        known = sum(map(self._is_known, near))
        return place in near and not named and len(near) > 1 and 2 * known < len(near)

    def _is_nearly_known(self, place):
        """Whether one repair makes a cell an angle computed back, or a determinant of 1, which is a fault then."""
        is_angle, many = heads(self.graph.tree(place)) & INVERSE, len(self.graph.uses.get(place, ())) > 5
        tried = edits(self.graph, place) if (is_angle or many) and not self.judge.unexplained else ()
        for cause, old, new, tree in tried:
            value = self.judge.calculate(place, tree)
            known = heads(tree) & INVERSE and self._is_known(place, tree) if is_angle else None
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
        parts = [p for p in self.graph.uses[place] if self.graph.own.get(p) is not None]
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


def _is_count_or_mean(tree):
    """Whether a formula only counts on, or sums up: no calculation of this field is made of such alone."""
    return heads(tree) <= {*STATISTICS, "area", "number", "+", "-"} and len(areas(tree)) == 1


def _agree(values, known):
    """Whether values are what is known, at all samples but the sheet's own."""
    return (np.abs(values - known)[..., 1:] <= CLOSE * (1 + np.abs(known[..., 1:]))).all(axis=-1)


def _axes(turn):
    """Of the whole rotation, either way: the unit vector along its axis, and what R less its transpose makes."""
    m = turn.whole
    vector = np.array([m[7] - m[5], m[2] - m[6], m[3] - m[1]])
    vectors = [vector, *(q[1:] for q in turn.quaternions()[2:])]
    with np.errstate(invalid="ignore"):  # nothing is turned
        vectors += [each / np.linalg.norm(each, axis=0) for each in vectors]
    return [sign * each for each in vectors for sign in (1, -1)]


def _has_angles(turn):
    """Whether a rotation is by three angles that are numbers."""
    return not turn.axis and np.isfinite(turn.radians).all()


def _solutions(turn):
    """Its angles as they are, and computed back: with the middle one in one half turn, or always in the other."""
    own, twin = turn.radians, euler.twin(turn.sequence.upper(), turn.radians)
    middle = (np.sin if turn.sequence[0] == turn.sequence[2] else np.cos)(own[:, 1:2]) > 0
    return own, np.where(middle, own, twin), np.where(middle, twin, own)


def _of_a_sample(vectors, axis):
    return np.std(vectors, axis=axis, ddof=1)


def _largest(vectors, axis):
    return np.abs(vectors).max(axis=axis)


def _squares(vectors, axis):
    return (vectors**2).sum(axis=axis)


def _half_digit(number):
    return 0.51 * 10.0 ** -written_decimals(number) if number else 1e-6
