"""What stands beside a calculation: lengths, distances, sums and means, differences, angles computed back.

No task asks for these. Each is judged as what it is: one of the numbers and vectors that follow from right results.
"""

from itertools import combinations, product

import numpy as np

from mathpost import angles as euler
from mathpost.detective.misreadings import written_decimals
from mathpost.rotation import wrap
from mathpost.workbook.calculation import SAMPLES, Turn
from mathpost.workbook.edits import as_around
from mathpost.workbook.formula import heads, unrounded
from mathpost.workbook.graph import CLOSE, same

MOST = 20  # points of which each two are compared


class Beside:
    """Judge what is left once a `Judge` has judged the calculations.

    `places` are all cells to judge, `unjudged` those that could not be: no result needs them, and they are nothing
    that is known. A vector with a single wrong cell is added to the judge's faults.
    """

    def __init__(self, judge):
        self.judge, self.graph, self.found = judge, judge.graph, judge.found
        self.turns = [c for c in judge.live if isinstance(c, Turn)]
        self.pairs, self.off, self.lengths = [], [], []
        self.vectors = self._known_vectors()
        self.places, rest = self._scope()
        rest -= self._judge_vectors(rest)
        self.numbers, self.angles = self._known_numbers()
        composed = {p for p in self.found.composed if not (self._is_degrees_and_minutes(p) or self._goes_on(p))}
        typed = self.found.typed - self.found.composed
        self.unjudged = {p for p in rest - self.found.composed if p in typed or not self._is_known(p)} | composed

    def _scope(self):
        """The cells to judge, and those of them that no result needs."""
        judge, graph, found = self.judge, self.graph, self.found
        messages = graph.messages | ({p for c in judge.live for p in c.aside} - graph.downstream(judge.inputs))
        formulas = [p for p in graph.trees if p not in found.typed - found.composed] + [*graph.unread]
        # A number of many digits, or 0, that only messages use was a formula; another is their tolerance.
        typed = {p for p in found.typed - graph.trees.keys() if messages.issuperset(graph.used.get(p, "-"))}
        typed = {p for p in typed if float(f"{graph.value(p):.2g}") != graph.value(p) or graph.value(p) == 0}
        results = np.array([target[0] for target in judge.targets.values()])
        typed = {p for p in typed if not (np.abs(results - graph.value(p)) <= _half_digit(graph.value(p))).any()}
        places = [p for p in formulas if p not in messages] + sorted(typed, key=graph.reading_order)
        results = (p for c in found.calculations if c not in judge.unexplained for p in c.results)
        rest = set(places) - (graph.upstream(results, judge.inputs) - judge.inputs.keys()) | judge.unsure
        given = graph.upstream(p for c in found.calculations for p in (*c.given, *c.results))
        given |= {p for c in {id(c): c for c in map(graph.component.get, given) if c}.values() for p in c}
        leaves = {p: graph.upstream([p]) - graph.trees.keys() for p in rest}
        other = {p for p, used in leaves.items() if given and used & found.typed and given.isdisjoint(used)}
        return [p for p in places if p not in other], rest - other

    def _known_vectors(self):
        """Points and what became of them, their sums, means, extremes, and the differences of each two."""
        graph, judge, lists, everywhere, found = self.graph, self.judge, {}, {}, []
        for turn in self.turns:
            found += [*turn.known.get(3, ())]
            result = np.array([*turn.targets.values()])
            if not turn.point or len(result) > 4:
                continue
            point, result = judge.block(turn.point), result[:3]
            found += [result - point, point - result]
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
        every = [*lists.values(), *everywhere.values()]
        for vectors in (np.array([*each.values()]) for each in every if len(each) > 1):
            statistics = np.sum, np.mean, np.max, np.min, np.ptp, np.std, _of_a_sample
            found += [statistic(vectors, axis=0) for statistic in statistics]
            self.lengths.append(np.linalg.norm(vectors, axis=1))
        for vectors in everywhere.values():
            for a, b in combinations(vectors.values(), 2) if len(vectors) <= MOST else ():
                found += [a - b, b - a, a + b, (a + b) / 2]
                self.pairs.append((a, b))
        return np.array(found).reshape(-1, 3, SAMPLES)

    def _expected(self, results):
        """Numbers in threes with which a result may be compared: apart, or where a difference is made."""
        given = {p for turn in self.turns for p in turn.given}
        for component in self.graph.components:
            if len(component) == 3 and (self.found.typed - given).issuperset(component):
                yield component
        for users in product(*(self.graph.used.get(p, ()) for p in results)):
            given = [[s for s in self.graph.uses[p] if s in self.found.typed] for p in users]
            if [len(each) for each in given] == [1, 1, 1] and len(set(users)) == 3:
                yield tuple(place for (place,) in given)
            elif len(given[0]) == 3 and len(set(users)) == 1:
                yield tuple(given[0])

    def _judge_vectors(self, rest):
        """Return the cells of known vectors; a vector with a single wrong cell becomes a fault."""
        judged, judge = set(), self.judge
        for triple in self.found.beside:
            if not rest.issuperset(triple[:3]) or judged.intersection(triple):
                continue
            off = self.vectors - judge.block(triple[:3])
            fits = (np.abs(off)[..., 1:] <= CLOSE * (1 + np.abs(self.vectors[..., 1:]))).all(axis=-1)
            if fits.all(axis=-1).any():
                judged.update(triple)
                continue
            for n in np.flatnonzero(fits.sum(axis=-1) == 2)[:1]:
                (k,) = np.flatnonzero(~fits[n])
                if fault := judge.repaired_alone(triple[k], self.vectors[n, k]):
                    judge.faults.append(fault)
                    judged.update(triple)
        return judged

    def _known_numbers(self):
        """What may stand in one cell, each of shape (samples,), and pairs of angles of which it may be either."""
        judge = self.judge
        numbers = [1.0, 0.0, 3.0, *(entry for c in judge.live for entry in c.entries)]  # 3: the trace of R·Rᵀ
        numbers += [*self.vectors.reshape(-1, SAMPLES), *np.linalg.norm(self.vectors, axis=1)]
        numbers += [each.max(axis=0) for each in self.vectors]
        if self.off:
            numbers += [np.max(self.off, axis=(0, 1)), np.linalg.norm(self.off, axis=1).max(axis=0)]
        numbers += [reduce(each, axis=0) for each in self.lengths for reduce in (np.sum, np.mean, np.max, np.min)]
        products = [(a * b).sum(axis=0) for a, b in self.pairs]
        between = [
            np.arctan2(np.linalg.norm(np.cross(a, b, axis=0), axis=0), (a * b).sum(axis=0)) for a, b in self.pairs
        ]
        angles, numbers = [np.array([angle, angle]) for angle in between], numbers + products
        for turn in self.turns:
            traces = [matrix[0] + matrix[4] + matrix[8] for matrix in turn.known[9]]
            numbers += traces
            angles += [np.array([angle, angle]) for angle in np.arccos(np.clip((np.array(traces) - 1) / 2, -1, 1))]
            if not turn.axis:
                both = np.stack([turn.radians, euler.twin(turn.sequence.upper(), turn.radians)], axis=1)
                angles += [*both.T]
        return np.array([np.broadcast_to(number, SAMPLES) for number in numbers]), angles

    def _is_known(self, place):
        """Whether a formula is a determinant, a length, a difference, an angle computed back."""
        if place not in self.graph.trees:
            return False
        tree = self.graph.trees[place]
        value, functions = self.judge.calculate(place, unrounded(tree)), heads(tree)
        if not any(np.abs(self.judge.now(source)).max() > 0 for source in self.graph.uses[place]):
            return False  # something empty was taken
        for radians in (value, np.deg2rad(value)) if functions & {"ATAN2", "ACOS", "ASIN", "DEGREES"} else ():
            off = [np.abs(wrap(radians - pair, 2 * np.pi)).min(axis=0)[1:].max() for pair in self.angles]
            if any(each < 1e-6 for each in off):
                return True
        known = self.numbers[:1] if "MDETERM" in functions else self.numbers
        fits = np.abs(value - known) <= CLOSE * (1 + np.abs(known))
        fits[:, 0] |= ~np.isfinite(value + known)[:, 0]
        return bool(fits.all(axis=1).any())

    def _is_degrees_and_minutes(self, place):
        """Whether a cell makes an angle of degrees and minutes, and seconds, of the sign of the degrees."""
        parts = self.graph.uses[place]
        sign = -1 if self.graph.own[parts[0]] < 0 else 1
        numbers, whole = np.array([[sign * 35.0], [20.0], [48.0]]), (35, 35 + 20 / 60, 35 + 20 / 60 + 48 / 3600)
        made = self.graph.cell(place, dict(zip(parts, numbers, strict=False)))
        in_line = 1 in (len({p[1] for p in parts}), len({p[2] for p in parts}))
        return in_line and len(parts) in (2, 3) and same(made, np.array([sign * whole[len(parts) - 1]]))

    def _goes_on(self, place):
        """Whether an angle is made of the one before as all around it are, as in a table of steps."""
        mates = [p for p in self.graph.component[place] if p in self.found.composed]
        return len(mates) > 2 and as_around(self.graph, place) == self.graph.trees[place]


def _of_a_sample(vectors, axis):
    return np.std(vectors, axis=axis, ddof=1)


def _half_digit(number):
    return 0.51 * 10.0 ** -written_decimals(number)
