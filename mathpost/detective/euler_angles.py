"""Which misreading of three Euler angles gives this number?

Someone has turned a point, or built a matrix, and got an unexpected result. Every misreading of
`mathpost.detective.misreadings` is tried; those that give the answer to the precision to which it was written are
returned, the simplest first. A match that the number of tries would produce by accident explains nothing.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import combinations, product, starmap

import numpy as np
from numpy.typing import ArrayLike

from mathpost.detective.digits import half_digit, written_decimals
from mathpost.detective.explanation import CHANCE, UNROUNDED, Explanation, Match, Slip, grouped, told
from mathpost.detective.misreadings import (
    Factors,
    Wording,
    about_origin,
    all_factors,
    matrices,
    onto_origin,
    trade_name,
    wordings,
    written,
)
from mathpost.detective.notations import read
from mathpost.errors import InputError, as_array
from mathpost.euler import SEQUENCES


def _copied(phrase: str, cost: float = 1, **changes: tuple[int, ...]) -> tuple[Slip, ...]:
    return (Slip("copied", cost, phrase, changes),)


_Found = tuple[Factors, list[Wording], tuple[Slip, ...]]  # a fit; slips besides those of the factors
ROUNDING = 1e-9  # relative error of a spreadsheet's own arithmetic
MOST, SHOWN = 100, 6  # misreadings examined and shown: right angles and points on an axis have many
MORE_DIGITS = Slip(UNROUNDED, 0.5, "the angles were used with more digits than are given")
COPIED = (
    (),
    _copied("the answer's x and y are exchanged", order=(1, 0, 2)),
    _copied("the answer's x and z are exchanged", order=(2, 1, 0)),
    _copied("the answer's y and z are exchanged", order=(0, 2, 1)),
    _copied("the sign of the answer's x is lost", signs=(-1, 1, 1)),
    _copied("the sign of the answer's y is lost", signs=(1, -1, 1)),
    _copied("the sign of the answer's z is lost", signs=(1, 1, -1)),
    _copied("the whole answer has the opposite sign", 1.1, signs=(-1, -1, -1)),
)
PROBE_ANGLES = np.array([(20, 35, 50), (-15, 70, 25), (110, 40, -65)], dtype=float)
PROBE_POINTS = np.array([(1, 2, 3), (2, -1, 5), (7, 3, -2)], dtype=float)
GENERIC_ANGLES = np.array([(21.1234567, 47.7654321, 74.4567891), (-36.2468135, 12.1357924, 113.9753186)])


def explain(
    angles: ArrayLike,
    point: ArrayLike | None,
    answer: ArrayLike,
    *,
    decimals: int | None = None,
    sequence: str = "ZXZ",
    origin: ArrayLike | None = None,
    convention: str = "passive",
) -> Explanation:
    """Return the misreadings of three Euler angles that give `answer`, the simplest first.

    The right way is that of source 000: the coordinates of a fixed point in a frame turned by the first angle about
    the first axis, by the second about the new second and by the third about the newest third axis; of a `sequence`
    in lower case, such as ``"xyz"``, about the fixed ones.

    `angles`, shape (3,), are degrees, as they were given, about the axes of `sequence`. `point` has the shape (3,),
    or (n, 3) for points that one misreading must explain together, and `answer` its shape; or `point` is None and
    `answer` a matrix, (3, 3). Strings such as ``"4.9500"`` keep the zeros that tell the precision, unless
    `decimals` says how many digits after the point count. `origin`, shape (3,), is that of the turned frame: the
    right answer then belongs to the point minus the origin.

    By the `convention` ``"active"`` the right answer is the other one: the point turned by the three angles, plus
    the origin, or the matrix that does it.

    The result is an `Explanation`. `InputError` if an argument is not finite numbers of that shape or names no
    axes, or if the point is the origin, which no misreading moves.

    Examples
    --------
    >>> found = explain([135, 54.7356, -90], [3, 4, 5], [1.283069, 6.939923, 0.437263])
    >>> print(found.misreadings[0])
    the final transpose is missing: E_z(−α)·E_x(−β)·E_z(−γ)·p
    """
    if convention not in ("passive", "active"):
        raise InputError("convention", "'passive' or 'active'", repr(convention))
    fixed, turned = sequence.islower(), convention == "active"
    sequence = sequence.upper() if fixed else sequence
    if sequence not in SEQUENCES:
        raise InputError("sequence", "three axes such as 'ZXZ', no two neighbours alike", repr(sequence))
    values = as_array(angles, 3, "angles")
    if values.shape != (3,):
        raise InputError("angles", "shape (3,)", f"shape {values.shape}")
    points = np.eye(3) if point is None else as_array(point, 3, "point")
    centre = as_array((0, 0, 0) if origin is None else origin, 3, "origin")
    if not (points - centre).any():
        raise InputError("point", "a point that a rotation moves", "the origin")
    target = as_array(answer, 3, "answer")
    if target.shape != points.shape or points.ndim > 2:
        raise InputError("answer", f"shape {points.shape}", f"shape {target.shape}")
    is_matrix = point is None
    placings: tuple[Factors, ...] = (Factors(sequence, point="" if is_matrix else "p"),)
    if origin is not None and not is_matrix:
        placings = onto_origin(centre, sequence) if turned else about_origin(centre, sequence)
    case = _Case(
        angles=values,
        points=np.atleast_2d(points),
        # The columns of a matrix are where ex, ey and ez go, so a matrix is three points.
        target=target.T if is_matrix else np.atleast_2d(target),
        half_digits=np.array([half_digit(angle) for angle in np.asarray(angles, dtype=object)]),
        decimals=written_decimals(answer) if decimals is None else decimals,
        placings=placings,
        is_matrix=is_matrix,
        convention=(fixed, turned),
    )
    # Whole numbers are meant exactly if some misreading gives them exactly, as right angles do.
    exact = replace(case, decimals=9).explain(target.shape) if case.decimals == 0 else None
    return exact if exact and exact.explained else case.explain(target.shape)


@dataclass(frozen=True)
class _Match(Match):
    """A product that fits: its factors, and its wordings, the simplest first."""

    factors: Factors
    wordings: list[Wording]

    @property
    def slips(self) -> tuple[Slip, ...]:
        return (*self.wordings[0].slips, *self.factors.slips)

    @property
    def cost(self) -> float:
        return 0.01 * self.wordings[0].recipe + super().cost

    @property
    def product(self) -> str:
        return written(self.wordings[0], self.factors)

    @property
    def sentence(self) -> str:
        """The mistake in words, and whose convention it is."""
        if not self.slips:
            return "right, active" if self.wordings[0].active else "right"
        known_as = trade_name(self.wordings[0], self.factors)
        return super().sentence + (f" (as {known_as})" if known_as else "")

    def value(self, angles: np.ndarray, points: np.ndarray) -> np.ndarray:
        """Return its result, shape (n, 3)."""
        each = self.factors
        matrix = matrices([each], [self.wordings[0].key], angles)[0, 0]
        turned = (points + each.before) @ matrix.T
        return turned[:, each.order] * each.signs + each.after


@dataclass(frozen=True)
class _Case:
    """One question: the search and its result."""

    angles: np.ndarray
    points: np.ndarray
    target: np.ndarray
    half_digits: np.ndarray
    decimals: int
    placings: tuple[Factors, ...]  # the factors to start from, those of the right place first
    is_matrix: bool
    convention: tuple[bool, bool] = (False, False)  # whether about fixed axes, and whether the point is turned
    slack: float = 1.0

    @property
    def size(self) -> float:
        return np.linalg.norm(self.points, axis=1).max()

    @property
    def tolerance(self) -> float:
        return 0.5 * 10.0**-self.decimals * (1 + 1e-6) * self.slack + ROUNDING * max(self.size, 1e-300)

    @property
    def reach(self) -> float:
        """How far the point may move if the angles had more digits."""
        return self.tolerance + self.size * np.deg2rad(self.half_digits.sum()) * 1.5

    def explain(self, shape: tuple[int, ...]) -> Explanation:
        tried = 0
        matches: list[_Match] = []
        for depth in (2, 3):
            for placing in self.placings if depth == 2 else self.placings[:1]:
                found, count = self.likely(depth, placing)
                tried, matches = tried + count, matches + found
            if matches:
                break
        else:
            found, count = self.moved()
            tried, matches = tried + count, matches + found
        groups = grouped(matches, _product, MOST)[:SHOWN]
        misreadings = []
        for first, *others in groups:
            others = [replace(first, wordings=[wording]) for wording in first.wordings[1:]] + others
            value = first.value(self.angles, self.points)
            value = value.T if self.is_matrix else value.reshape(shape)
            misreadings.append(told([first, *others], value))
        note = self.tell_apart(groups) if len(groups) > 1 else "" if groups else self.what_is_known()
        if groups and not note and (said := self.inverse(groups[0][0])):
            note = said
        return Explanation(tuple(misreadings), self.tolerance, tried, note)

    def inverse(self, match: _Match) -> str:
        """Say that the other convention has this answer, if it does."""
        fixed, turned = self.convention
        right = next(same[0] for same in wordings(fixed, not turned).values() if not same[0].slips)
        if match.factors.slips or match.wordings[0].key != right.key:
            return ""
        return f"By the other convention it is right: {'passive' if turned else 'active'}."

    def likely(self, depth: int, placing: Factors) -> tuple[list[_Match], int]:
        """Return the matches at `depth` that are not accidental, and how many were tried."""
        turned = replace(self, points=self.points + placing.before, target=self.target - placing.after)
        found, count, costs = turned.search(placing.axes, depth)
        right = self.placings[0]
        matches = []
        for factors, same, slips in found:
            placed = replace(factors, before=right.before, point=right.point, after=right.after, added=right.added)
            matches.append(_Match(placed.misread(*placing.slips, *slips), same))
        return [match for match in matches if turned.chance(costs, match) < CHANCE], count

    def moved(self) -> tuple[list[_Match], int]:
        """Return matches of points that were shifted as well as turned: their differences are only turned."""
        start, end = self.points.mean(axis=0), self.target.mean(axis=0)
        differences = replace(self, points=self.points - start, target=self.target - end, slack=2.0)
        if self.is_matrix or differences.size < 1e-9:  # as for a single point
            return [], 0
        found, count = differences.likely(2, Factors(self.placings[0].axes))
        placed = []
        for match in found:
            if match.factors.order == (0, 1, 2) and match.factors.signs == (1, 1, 1):
                shift = end - match.value(self.angles, start[None])[0]
                slip = _translated(match.value(self.angles, np.eye(3)).T, shift, self.tolerance)
                placed.append(replace(match, factors=match.factors.misread(slip)))
        return placed, count

    def search(self, axes: str, depth: int) -> tuple[list[_Found], int, np.ndarray]:
        """Compare the answer with the factors of a `depth` in all products, also miscopied or with more digits.

        Returns factors, wordings and further slips of the fits, how many were tried, and their costs in order.
        """
        factors, products = _products(axes, depth, tuple(self.angles.tolist()), self.convention)
        same = list(wordings(*self.convention).values())
        if self.is_matrix:
            same = [[wording for wording in of_one if not wording.row] for of_one in same]
        values = np.einsum("fkij,nj->fkni", products, self.points)
        costs = np.add.outer([each.cost for each in factors], [of_one[0].cost for of_one in same])
        found: list[_Found] = []
        # A wrong copy comes with one other slip at most: more is guessing.
        simple = [n for n, each in enumerate(factors) if len(each.slips) < 2]
        for copied in COPIED[:1] if self.is_matrix else COPIED:
            as_copied = Factors("").misread(*copied)
            rows, given = (simple, values[simple]) if copied else (range(len(factors)), values)
            misfit = np.abs(given[..., as_copied.order] * as_copied.signs - self.target).max(axis=(2, 3))
            found += [(factors[rows[f]], same[k], copied) for f, k in np.argwhere(misfit <= self.tolerance)]
            if not copied and self.half_digits.any():
                for f, k in np.argwhere((misfit > self.tolerance) & (misfit <= self.reach)):
                    if self.fits_unrounded(_Match(factors[f], same[k])):
                        found.append((factors[f], same[k], (MORE_DIGITS,)))
        return found, len(COPIED) * costs.size, np.sort(costs, axis=None)

    def fits_unrounded(self, match: _Match) -> bool:
        """Whether angles that round to the given ones give the answer, judged by the differential."""
        value = match.value(self.angles, self.points)
        slopes = []
        for half in np.diag(self.half_digits):
            high, low = (match.value(self.angles + step, self.points) for step in (half, -half))
            slopes.append((high - low).ravel() / 2)
        jacobian = np.transpose(slopes)
        missing = (self.target - value).ravel()
        steps, *_ = np.linalg.lstsq(jacobian, missing, rcond=1e-9)
        left = missing - jacobian @ np.clip(steps, -1, 1)
        return np.abs(left).max() <= self.tolerance

    def chance(self, costs: np.ndarray, match: _Match) -> float:
        """Return the expected number of accidental matches among misreadings that cost no more."""
        copies = [sum(slip.cost for slip in copied) for copied in COPIED]
        beside = np.add.outer([placing.cost for placing in self.placings], copies)
        tries = np.searchsorted(costs, match.cost - beside + 1e-9, side="right").sum()
        # A point moves on a sphere, a second one on a circle around the first. The cube of the tolerance covers
        # about six of its squares on the sphere.
        ratio = (self.reach if MORE_DIGITS in match.slips else self.tolerance) / self.size
        share = min(1.0, 1.5 * ratio**2 / np.pi)
        if np.linalg.matrix_rank(self.points) > 1:
            share *= min(1.0, ratio / np.pi)
        return tries * share

    def tell_apart(self, groups: list[list[_Match]]) -> str:
        """Propose the point, or if need be the angles, for which the misreadings differ most clearly."""
        options = [(self.angles, point) for point in PROBE_POINTS] if not self.is_matrix else []
        options += [(angles, point) for angles in PROBE_ANGLES for point in PROBE_POINTS[:1]]
        for angles, point in options:
            values = [group[0].value(angles, point[None])[0] for group in groups]
            if min(np.abs(a - b).max() for a, b in combinations(values, 2)) > 0.05:
                break
        else:
            return f"{len(groups)} misreadings give the same number here, and nearly the same everywhere."
        asked = f"the point ({_numbers(point)})"
        if angles is not self.angles:
            asked += f" and the angles {_numbers(angles)}"
        pairs = zip(groups, values, strict=True)
        results = "; ".join(f"{group[0].sentence}: ({_numbers(v, 3)})" for group, v in pairs)
        return f"{len(groups)} misreadings give the same number here. To tell them apart, try {asked}: {results}."

    def what_is_known(self) -> str:
        """Say why no misreading can fit, or which simple one gives all coordinates but one."""
        simple = [each for each in all_factors(self.placings[0].axes, 2) if len(each.slips) < 2]
        for match in starmap(_Match, product(simple, wordings(*self.convention).values())):
            if len(match.slips) < 2:
                off = np.abs(match.value(self.angles, self.points) - self.target) > self.tolerance
                if off.sum() == 1 and self.decimals > 1:
                    row, column = np.argwhere(off)[0]
                    name = f"row {column + 1}, column {row + 1}" if self.is_matrix else "xyz"[column]
                    rest = f"fits this misreading: {match.sentence}" if match.slips else "is right"
                    return f"Only {name} is off, the rest {rest}."
        if self.is_matrix and np.linalg.det(self.target) < 0:
            reflection = read("matrix", self.target.T)
            return f"{reflection.fault} {reflection.remedy.rstrip(':')}."
        lengths, given = np.linalg.norm(self.target, axis=1), np.linalg.norm(self.points, axis=1)
        worst = np.abs(lengths - given).argmax()
        if abs(lengths[worst] - given[worst]) > 2 * self.tolerance:
            return (
                f"No rotation gives it: the answer has the length {lengths[worst]:.6g}, "
                f"and a rotation keeps {given[worst]:.6g}."
            )
        if self.decimals > 1:
            return "It keeps the length, so it is a rotation, but by other angles."
        return "It is written too coarsely: some misreading would fit by accident. Give more digits or more points."


@lru_cache(maxsize=4)
def _products(
    axes: str, depth: int, angles: tuple[float, ...], convention: tuple[bool, bool]
) -> tuple[list[Factors], np.ndarray]:
    """The factors of a depth that matter for `angles`, and their matrices, (factors, wordings, 3, 3)."""
    factors = [each for each in all_factors(axes, depth) if each.matters(np.array(angles))]
    return factors, matrices(factors, list(wordings(*convention)), np.array(angles))


def _product(match: _Match) -> bytes:
    """A key that differs between products, whatever the angles and the point."""
    return (np.round([match.value(angles, PROBE_POINTS) for angles in GENERIC_ANGLES], 9) + 0.0).tobytes()


def _translated(matrix: np.ndarray, shift: np.ndarray, tolerance: float) -> Slip:
    """The slip of points that were turned by `matrix` and then moved by `shift`.

    A shift across the axis of rotation is that of a rotation about a different centre: the one nearest to the
    origin is named.
    """
    moved = np.eye(3) - matrix
    centre = np.linalg.lstsq(moved, shift, rcond=1e-6)[0]
    decimals = max(0, int(np.ceil(-np.log10(2 * tolerance))) - 1)
    kind, phrase = "translation", f"({_numbers(shift, decimals)}) is added to every point"
    if np.abs(moved @ centre - shift).max() <= 4 * tolerance:
        kind, phrase = "centre", f"it is turned about another centre, such as ({_numbers(centre, decimals)})"
    return Slip(kind, 1.25, phrase, {"after": tuple(shift.tolist()), "added": " + t"})


def _numbers(values: Iterable[float], decimals: int | None = None) -> str:
    return ", ".join(f"{value:g}" if decimals is None else f"{value:z.{decimals}f}" for value in values)
