"""What follows from right results: the vectors, lengths and angles that people put beside them."""

from __future__ import annotations

from itertools import combinations, product
from typing import TYPE_CHECKING

import numpy as np

from mathpost import euler
from mathpost.rotation import wrap
from mathpost.teaching.workbook.meaning.calculation import SAMPLES, Turn
from mathpost.teaching.workbook.sheet.edits import INVERSE
from mathpost.teaching.workbook.sheet.evaluate import STATISTICS
from mathpost.teaching.workbook.sheet.place import beside
from mathpost.teaching.workbook.sheet.samples import CLOSE, same
from mathpost.teaching.workbook.sheet.tree import heads, unrounded

if TYPE_CHECKING:
    from mathpost.teaching.workbook.sheet.place import Place
    from mathpost.teaching.workbook.verdict.judge import Judge

MOST = 20  # points of which each two are compared
SUMS = {"SUM", "SUMSQ", "PRODUCT"}


class Known:
    """What a `Judge` that has judged the calculations knows, at the samples.

    Three cells in line may hold any of `vectors`, shape (vectors, 3, samples), one cell any of `numbers` or of
    `angles`, in radians.
    """

    def __init__(self, judge: Judge) -> None:
        self.judge, self.graph, self.found = judge, judge.graph, judge.found
        self.turns = judge.live
        points, results = self._ends()
        pairs = [*zip(points, results, strict=True)]
        for turn in (turn for turn in self.turns if turn.axis and turn.point):
            axis = judge.block(turn.axis)
            units = axis, axis / np.linalg.norm(axis, axis=0)
            pairs += product(units, (judge.block(turn.point), judge.block(turn.results[:3])))
        self.vectors = self._known_vectors(points, results, pairs)
        numbers = self._known_numbers(pairs)
        self.numbers = numbers[np.argsort(numbers[:, -1])]
        self.angles = self._known_angles(points, results, pairs)

    def _ends(self) -> tuple[list[np.ndarray], list[np.ndarray]]:
        """The points that are turned, and what becomes of them."""
        turns = [turn for turn in self.turns if turn.point and len(turn.results) < 9]
        results = [np.array([*turn.targets.values()][:3]) for turn in turns]
        return [self.judge.block(turn.point) for turn in turns], results

    def _known_vectors(
        self, points: list[np.ndarray], results: list[np.ndarray], pairs: list[tuple[np.ndarray, np.ndarray]]
    ) -> np.ndarray:
        """The vectors on the way to the results, their directions, and the differences of each two.

        The pairs of points, and of results, of which there are differences, are added to `pairs`.
        """
        found = [vector for turn in self.turns for vector in turn.known.get(3, ())]
        found += [unit * turn.radians.T for turn in self.turns if turn.radians.shape[1] == 3 for unit in UNITS]
        found += [end / np.linalg.norm(end, axis=0) for end in (*points, *results)]
        for ends in (points, results) if len(points) <= MOST else ():
            pairs += combinations(ends, 2)
        found += [sign * (a - b) for a, b in pairs for sign in (1, -1) if not np.array_equal(a, b)]
        return np.array(found).reshape(-1, 3, SAMPLES)

    def _known_numbers(self, pairs: list[tuple[np.ndarray, np.ndarray]]) -> np.ndarray:
        """The numbers that one cell may hold: entries of matrices, cosines, sines, lengths, products, traces."""
        numbers = [np.full(SAMPLES, each) for each in (0.0, 1.0)]
        numbers += [
            entry for c in self.judge.live for n in (1, 2, 9) for known in c.known.get(n, ()) for entry in known
        ]
        numbers += [*np.linalg.norm(self.vectors, axis=1)]
        for a, b in pairs:
            dot = (a * b).sum(axis=0)
            numbers += [dot, dot / np.linalg.norm(a, axis=0) / np.linalg.norm(b, axis=0)]
        for turn in self.turns:
            numbers += [matrix[0] + matrix[4] + matrix[8] for matrix in turn.known[9]]
            numbers += [unit * angle for angle in turn.radians.T for unit in UNITS]
        return np.array(numbers)

    def _known_angles(
        self, points: list[np.ndarray], results: list[np.ndarray], pairs: list[tuple[np.ndarray, np.ndarray]]
    ) -> np.ndarray:
        """The angles between two vectors, of directions, of the whole turn, and those that are computed back."""
        angles = []
        for a, b in pairs:
            angles.append(np.arctan2(np.linalg.norm(np.cross(a, b, axis=0), axis=0), (a * b).sum(axis=0)))
        for x, y, z in (*points, *results):
            angles += [np.arctan2(y, x), np.arctan2(np.hypot(x, y), z), np.arctan2(z, np.hypot(x, y))]
        for turn in self.turns:
            for matrix in turn.known[9]:
                angles.append(np.arccos(np.clip((matrix[0] + matrix[4] + matrix[8] - 1) / 2, -1, 1)))
            if not turn.axis:
                back = _computed_back(turn)
                angles += [sign * each for each in (*back.T, *(back - turn.radians).T) for sign in (1, -1)]
        return np.array(angles).reshape(-1, SAMPLES)

    def is_known(self, place: Place) -> bool:
        """Whether what a formula gives may stand beside right results; a mean is not told by its value."""
        if place not in self.graph.trees:  # a formula that could not be read
            return False
        tree = unrounded(self.graph.trees[place])
        if tree[0] == "area":  # of a step, or beside others, only together with those in line
            return self._is_copied(place) and not any(map(self._is_copied, beside(place)))
        if tree[0] in STATISTICS - SUMS and any(part[0] == "area" for part in tree[1:]):
            return False
        value, functions = self.judge.calculate(place, tree), heads(tree)
        if "MDETERM" in functions:
            return same(value, np.ones(SAMPLES))
        of_angles = tree[0] == "-" and not self.found.turning.isdisjoint(self.graph.uses[place])
        if of_angles or not functions.isdisjoint(INVERSE):
            units = {self.judge.units.get(p, 1.0) for turn in self.turns for p in turn.angles}
            units |= {1.0} if place in self.graph.used else set()  # it may be converted further on
            return any(self._is_angle(unit * value) for unit in units)
        last = value.flat[-1]  # most numbers differ there, and they are in its order
        near = np.searchsorted(self.numbers[:, -1], last + np.array([-2, 2]) * CLOSE * (1 + abs(last)))
        return bool(agree(value, self.numbers[slice(*near)]).any())

    def _is_copied(self, place: Place) -> bool:
        """Whether a cell is a copy of one of a result, perhaps rounded."""
        is_copy = unrounded(self.graph.tree(place))[0] == "area"
        return is_copy and not self.judge.targets.keys().isdisjoint(self.graph.uses[place])

    def _is_angle(self, radians: np.ndarray) -> bool:
        off = np.abs(wrap(radians - self.angles, 2 * np.pi))
        return bool((off[:, 1:].max(axis=1) < 1e-6).any())


UNITS = 1.0, 180 / np.pi, 200 / np.pi  # of a radian


def agree(values: np.ndarray, known: np.ndarray) -> np.ndarray:
    """Whether values are what is known, at all samples but the sheet's own."""
    return (np.abs(values - known)[..., 1:] <= CLOSE * (1 + np.abs(known[..., 1:]))).all(axis=-1)


def _computed_back(turn: Turn) -> np.ndarray:
    """The angles of a turn with the middle one where its inverse function gives it, shape (samples, angles)."""
    own, twin = turn.radians, euler.twin(turn.sequence.upper(), turn.radians)
    middle = (np.sin if turn.sequence[0] == turn.sequence[2] else np.cos)(own[:, 1:2]) > 0
    return np.where(middle, own, twin)
