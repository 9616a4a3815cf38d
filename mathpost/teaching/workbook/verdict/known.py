"""What follows from right results: the vectors, lengths, statistics and angles that people put beside them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from itertools import combinations, product
from typing import TYPE_CHECKING, Any

import numpy as np

from mathpost import euler
from mathpost.rotation import wrap
from mathpost.teaching.workbook.meaning.calculation import SAMPLES, Turn
from mathpost.teaching.workbook.meaning.conversion import Conversion
from mathpost.teaching.workbook.meaning.plane_angles import Plane
from mathpost.teaching.workbook.sheet.edits import INVERSE
from mathpost.teaching.workbook.sheet.place import Line, offset
from mathpost.teaching.workbook.sheet.samples import CLOSE, same
from mathpost.teaching.workbook.sheet.tree import heads, unrounded

if TYPE_CHECKING:
    from mathpost.teaching.workbook.sheet.formula import Tree
    from mathpost.teaching.workbook.sheet.place import Place
    from mathpost.teaching.workbook.verdict.judge import Judge

LENGTHS = {25.4, 10.0, 1000.0}  # mm of an inch, a centimetre, a metre
MOST = 20  # points of which each two are compared
CORNERS = 6  # points of which each two edges are


class Known:
    """What a `Judge` that has judged the calculations knows, at the samples.

    `turns` are the rotations; `vectors` has shape (vectors, 3, samples), of which `combined` are made of several.
    One cell may hold any of `numbers`, of which `norms` are lengths, or either angle of a pair in `angles`. `globe`
    has the directions of points and results.
    """

    def __init__(self, judge: Judge) -> None:
        self.judge, self.graph, self.found = judge, judge.graph, judge.found
        self.turns: list[Turn] = [c for c in judge.live if isinstance(c, Turn)]
        self.turns += [c.turn for c in judge.live if isinstance(c, Conversion)]
        self.pairs: list[tuple[np.ndarray, np.ndarray]] = []
        self.off: list[np.ndarray] = []
        self.lengths: list[np.ndarray] = []
        self.globe: list[np.ndarray] = []
        self.whole: list[np.ndarray] = []
        self.vectors, whole = self._known_vectors()
        numbers, self.angles = self._known_numbers()
        self.vectors = np.concatenate([self.vectors, whole])
        self.numbers = numbers[np.argsort(numbers[:, -1])]

    def _known_vectors(self) -> tuple[np.ndarray, np.ndarray]:
        """Points and what became of them, their sums, means, extremes, and the differences of each two."""
        graph, judge, axes, found = self.graph, self.judge, [], []
        lists: dict[tuple[int, int], dict[Line, np.ndarray]] = {}
        everywhere: dict[int, dict[Line, np.ndarray]] = {}
        found += [vector for c in judge.live if isinstance(c, Plane) for vector in c.known[3]]
        for turn in self.turns:
            found += turn.known.get(3, ())
            found += [np.array(each) for each in _in_all_units(turn.radians.T) if len(each) == 3]
            matrix = turn.whole.reshape(3, 3, -1)
            axes += [*matrix, *matrix.swapaxes(0, 1)]
            result = np.array([*turn.targets.values()])
            if not turn.point or len(result) > 4:
                continue
            point, result = judge.block(turn.point), result[:3]
            self.pairs.append((point, result))
            about = [judge.block(turn.axis)] * (len(turn.axis) == 3)
            self.pairs += [(axis, each) for axis in about for each in (point, result)]
            found += [result - point, point - result, (point + result) / 2]
            units = [each / np.linalg.norm(each, axis=0) for each in (point, result)]
            found += units
            self.globe += units
            points = [(turn.point, point), (turn.given, result)]  # a copy of a result is of the same
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
        for column in (np.array([*each.values()]) for each in every if len(each) > 1):
            found += [statistic(column, axis=0) for statistic in STATISTICS]
            self.lengths += [np.linalg.norm(each, axis=1) for each in (column, column - column.mean(axis=0))]
        for vectors in everywhere.values():
            for a, b in combinations(vectors.values(), 2) if len(vectors) <= MOST else ():
                found += [a - b, b - a, a + b, (a + b) / 2] * (not np.array_equal(a, b))
                self.pairs.append((a, b))
            edges = [b - a for a, b in combinations(vectors.values(), 2) if len(vectors) <= CORNERS]
            self.pairs += [(sign * a, b) for a, b in combinations(edges, 2) for sign in (1, -1)]
        self.combined = np.array(found[single:]).reshape(-1, 3, SAMPLES)
        angles = [np.arccos(np.clip(each, -1, 1)) for each in axes + self.globe]  # only three together say of what
        whole = [unit * each for each in angles for unit in (1, 180 / np.pi)]
        planes = [c for c in judge.live if isinstance(c, Plane)]
        whole += [judge.block(p) for c in planes for p in (c.x, c.y, c.z, c.corner) if p]  # as of its origin
        return np.array(found).reshape(-1, 3, SAMPLES), np.array(whole).reshape(-1, 3, SAMPLES)

    def _expected(self, results: Line) -> Iterator[Line]:
        """Numbers in threes with which a result may be compared: apart, or where a difference is made."""
        given = {p for turn in self.turns for p in turn.given}
        for component in self.graph.components:
            if len(component) == 3 and (self.found.typed - given).issuperset(component):
                yield component
        for users in product(*(self.graph.used.get(p, ()) for p in results)):
            typed = [[s for s in self.graph.uses[p] if s in self.found.typed] for p in users]
            if [len(each) for each in typed] == [1, 1, 1] and len(set(users)) == 3:
                a, b, c = (place for (place,) in typed)
                (_, i, j), (_, k, m), (_, p, q) = a, b, c
                middle = (a[0], (i + p) // 2, (j + q) // 2)  # one of them may be mistaken
                for line in (
                    (a, middle, c),
                    (a, b, (a[0], 2 * k - i, 2 * m - j)),
                    ((a[0], 2 * k - p, 2 * m - q), b, c),
                ):
                    in_line = not np.ptp(np.diff([place[1:] for place in line], axis=0), axis=0).any()
                    if in_line and line[0] != line[1] and self.found.typed.issuperset(line):
                        yield line
            elif len(typed[0]) == 3 and len(set(users)) == 1:
                yield tuple(typed[0])

    def _known_numbers(self) -> tuple[np.ndarray, np.ndarray]:
        """Numbers that one cell may hold, each of shape (samples,), and pairs of angles, of which either may be."""
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
        self.norms = _at_samples(norms)
        numbers += [*self.vectors.reshape(-1, SAMPLES), *norms, *(each.max(axis=0) for each in self.vectors)]
        products = [(a * b).sum(axis=0) for a, b in self.pairs]
        between = [
            np.arctan2(np.linalg.norm(np.cross(a, b, axis=0), axis=0), (a * b).sum(axis=0)) for a, b in self.pairs
        ]
        angles = [np.array([angle, angle]) for angle in between]  # each, and the one that it may be as well
        numbers += [*products, *np.cos(between)]
        for turn in self.turns:
            traces = [matrix[0] + matrix[4] + matrix[8] for matrix in turn.known[9]]
            numbers += [
                *traces,
                *np.abs(np.sin(turn.radians.T)),
                *(each for angles in _in_all_units(turn.radians.T) for each in angles),
            ]
            numbers += [entry for product in turn.quaternions() for entry in product]
            whole = np.arccos(np.clip((np.array(traces) - 1) / 2, -1, 1))
            angles += [np.array([angle, angle]) for angle in whole]
            self.whole += [*whole]
            about = turn.radians.T if turn.axis else ()
            angles += [np.array([angle - own, own - angle]) for angle, own in product(whole, about)]
            if has_angles(turn):
                for solution in solutions(turn):
                    angles += [np.array([each, -each if turn.signs else each]) for each in solution.T]
                    angles += [np.array([each, each]) for each in (solution - turn.radians).T]
        for x, y, z in self.globe:
            seen = np.arctan2(y, x), np.arccos(np.clip(z, -1, 1)), np.arcsin(np.clip(z, -1, 1))
            angles += [np.array([angle, angle]) for angle in seen]
        return _at_samples(numbers), np.array(angles).reshape(-1, 2, SAMPLES)

    def is_angle(self, radians: np.ndarray) -> bool:
        """Whether a value is an angle between two vectors, or computed back."""
        off = np.abs(wrap(radians - self.angles, 2 * np.pi)).min(axis=1)
        whole = np.array(self.whole).reshape(-1, SAMPLES)
        off = np.concatenate([off, np.abs(np.pi - np.abs(radians - np.pi) - whole)])  # or the long way
        return bool((off[:, 1:].max(axis=1) < 1e-6).any())

    def is_length(self, value: np.ndarray) -> bool:
        """Whether a value is the length of a vector."""
        return bool(agree(value, self.norms).any())

    def is_known(self, place: Place, tree: Tree | None = None) -> bool:
        """Whether a formula, or another in its place, is a determinant, a length, an angle computed back."""
        if place not in self.graph.trees:
            return False
        tree = tree or self.graph.trees[place]
        value, functions = self.judge.calculate(place, unrounded(tree)), heads(tree)
        is_angle = not functions.isdisjoint({*INVERSE, "DEGREES"})
        is_angle |= tree[0] == "-" and not self.found.turning.isdisjoint(self.graph.uses[place])
        if tree[0] == "COUNT" and tree[1][0] == "area":  # of a whole column
            column, rows = tree[1][1].places, self.graph.component
            around = offset(column[0], -1, 0), offset(column[-1], 1, 0)
            return not rows.keys().isdisjoint(column) and rows.keys().isdisjoint(around)
        units = {1.0, np.pi / 180, *self.judge.units.values()}
        if is_angle and any(self.is_angle(unit * value) for unit in units):
            return True
        if "MDETERM" in functions:
            vectors = {p for turn in self.turns for p in (*turn.point, *turn.results)}
            return same(value, np.ones(SAMPLES)) or vectors.issuperset(self.graph.uses[place])
        if tree[0] in ("*", "/") and tree[2][0] == "number" and tree[2][1] in LENGTHS:
            angles = self.found.turning | self.judge.periods.keys()  # which are no lengths
            return angles.isdisjoint(self.graph.uses[place]) and self.is_known(place, tree[1])
        last = value.flat[-1]  # most numbers differ there, and they are in its order
        around = np.searchsorted(self.numbers[:, -1], last + np.array([-2, 2]) * CLOSE * (1 + abs(last)))
        known = self.numbers[slice(*around)]
        fits = np.abs(value - known) <= CLOSE * (1 + np.abs(known))
        fits[:, 0] |= ~np.isfinite(value + known)[:, 0]
        return bool(fits.all(axis=1).any())


def agree(values: np.ndarray, known: np.ndarray) -> np.ndarray:
    """Whether values are what is known, at all samples but the sheet's own."""
    return (np.abs(values - known)[..., 1:] <= CLOSE * (1 + np.abs(known[..., 1:]))).all(axis=-1)


def _at_samples(numbers: Sequence[float | np.ndarray]) -> np.ndarray:
    """Numbers, of which each is of all samples or of each, shape (numbers, samples)."""
    found = np.empty((len(numbers), SAMPLES))
    for n, number in enumerate(numbers):
        found[n] = number
    return found


def has_angles(turn: Turn) -> bool:
    """Whether a rotation is by three angles that are numbers."""
    return not turn.axis and np.isfinite(turn.radians).all()


def solutions(turn: Turn) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Its angles as they are, and computed back: with the middle one in one half turn, or always in the other."""
    own, twin = turn.radians, euler.twin(turn.sequence.upper(), turn.radians)
    if len(turn.angles) == 2:  # the second one, as of an arc sine, within a quarter turn
        folded = np.where(np.cos(own[:, 1:2]) > 0, own, np.array([np.pi, np.pi, 0]) + [1, -1, 0] * own)
        return own, folded, folded
    middle = (np.sin if turn.sequence[0] == turn.sequence[2] else np.cos)(own[:, 1:2]) > 0
    return own, np.where(middle, own, twin), np.where(middle, twin, own)


def _in_all_units(radians: np.ndarray) -> list[np.ndarray]:
    """Angles in radians, degrees and gon."""
    return [unit * radians for unit in (1, 180 / np.pi, 200 / np.pi)]


STATISTICS: tuple[Callable[..., Any], ...] = (
    *(np.sum, np.mean, np.median, np.max, np.min, np.ptp, np.std, np.var),
    *(partial(spread, ddof=1) for spread in (np.std, np.var)),  # of a sample
    lambda vectors, axis: np.abs(vectors).max(axis=axis),
    lambda vectors, axis: (vectors**2).sum(axis=axis),
)
