"""Which misreading of three Euler angles gives this number?

Someone has turned a point, or built a matrix, and got an unexpected result. Every misreading of
`mathpost.detective.misreadings` is tried; those that give the answer to the precision to which it was written are
returned, the simplest first. A match that the number of tries would produce by accident explains nothing.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import product

import numpy as np
from numpy.typing import ArrayLike

from mathpost.detective.digits import half_digit, written_decimals
from mathpost.detective.explanation import CHANCE, UNROUNDED, Explanation, Match, Slip, Trial, explanation
from mathpost.detective.misreadings import (
    Factors,
    Wording,
    all_factors,
    matrices,
    placings,
    trade_name,
    wordings,
    written,
)
from mathpost.detective.notations import read
from mathpost.errors import InputError, as_array
from mathpost.euler import SEQUENCES

ROUNDING = 1e-9  # relative error of a spreadsheet's own arithmetic
MORE_DIGITS = Slip(UNROUNDED, 0.5, "the angles were used with more digits than are given")
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
    if sequence.upper() not in SEQUENCES or sequence not in (sequence.upper(), sequence.lower()):
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
    is_matrix, turned = point is None, convention == "active"
    starts: tuple[Factors, ...] = (Factors(sequence.upper(), point="" if is_matrix else "p"),)
    if origin is not None and not is_matrix:
        starts = placings(centre, sequence.upper(), turned)
    case = _Case(
        angles=values,
        points=np.atleast_2d(points),
        # The columns of a matrix are where ex, ey and ez go, so a matrix is three points.
        target=target.T if is_matrix else np.atleast_2d(target),
        half_digits=np.array([half_digit(angle) for angle in np.asarray(angles, dtype=object)]),
        decimals=written_decimals(answer) if decimals is None else decimals,
        placings=starts,
        is_matrix=is_matrix,
        sequence=sequence,
        turned=turned,
    )
    # Whole numbers are meant exactly if some misreading gives them exactly, as right angles do.
    exact = replace(case, decimals=9).explain(target.shape) if case.decimals == 0 else None
    return exact if exact and exact.explained else case.explain(target.shape)


def value(factors: Factors, wording: Wording, angles: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Return where a misreading takes points, shape (n, 3)."""
    return (points + factors.before) @ matrices([factors], [wording.key], angles)[0, 0].T + factors.after


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
    sequence: str
    turned: bool  # whether the point is turned, which is then right

    @property
    def size(self) -> float:
        return np.linalg.norm(self.points, axis=1).max()

    @property
    def tolerance(self) -> float:
        return 0.5 * 10.0**-self.decimals * (1 + 1e-6) + ROUNDING * max(self.size, 1e-300)

    @property
    def reach(self) -> float:
        """How far the point may move if the angles had more digits."""
        return self.tolerance + self.size * np.deg2rad(self.half_digits.sum()) * 1.5

    def explain(self, shape: tuple[int, ...]) -> Explanation:
        same = wordings(self.sequence.islower(), self.turned)
        factors, products = _products(self.sequence, tuple(self.angles.tolist()), self.turned)
        costs = np.add.outer([each.cost for each in factors], [of_one[0].cost for of_one in same.values()])
        matches = [
            self.match(each.placed(place), wording, further)
            for place in self.placings
            for each, of_one, further in self.fits(place, factors, list(same.values()), products)
            if self.chance(np.sort(costs, axis=None), place.cost + each.cost + of_one[0].cost, further) < CHANCE
            for wording in of_one
        ]  # fmt: skip
        tried = costs.size * len(self.placings)
        found = explanation(
            matches, self.trial(), self.tolerance, tried, shape=shape[::-1] if self.is_matrix else shape,
            otherwise=self.what_is_known,
        )  # fmt: skip
        if found.explained and not found.note and not found.right and self.is_inverse(matches):
            other = "passive" if self.turned else "active"
            return replace(found, note=f"By the other convention it is right: {other}.")
        return found

    def fits(
        self, place: Factors, factors: list[Factors], same: list[list[Wording]], products: np.ndarray
    ) -> Iterator[tuple[Factors, list[Wording], tuple[Slip, ...]]]:
        """The factors and wordings that give the answer from a place, and a slip where more digits are needed."""
        values = np.einsum("fkij,nj->fkni", products, self.points + place.before) + place.after
        misfit = np.abs(values - self.target).max(axis=(2, 3))
        for f, k in np.argwhere(misfit <= (self.reach if self.half_digits.any() else self.tolerance)):
            if misfit[f, k] <= self.tolerance:
                yield factors[f], same[k], ()
            elif self.fits_unrounded(factors[f].placed(place), same[k][0]):
                yield factors[f], same[k], (MORE_DIGITS,)

    def match(self, factors: Factors, wording: Wording, further: tuple[Slip, ...]) -> Match:
        def result(given: tuple[np.ndarray, np.ndarray]) -> np.ndarray:
            found = value(factors, wording, *given)
            return found.T if self.is_matrix and len(found) > 1 else found

        return Match(
            (*wording.slips, *factors.slips, *further), written(wording, factors), result, 0.01 * wording.recipe,
            "right, active" if wording.active else "right", trade_name(wording, factors),
        )  # fmt: skip

    def trial(self) -> Trial:
        """The question, and other points and angles."""
        generic = [(angles, PROBE_POINTS) for angles in GENERIC_ANGLES]
        probes = [(f"the point ({_row(p)})", (self.angles, p[None])) for p in PROBE_POINTS]
        probes = [] if self.is_matrix else probes
        for angles, p in product(PROBE_ANGLES, PROBE_POINTS[:1]):
            probes.append((f"the point ({_row(p)}) and the angles {_row(angles)}", (angles, p[None])))
        given = (self.angles, self.points)
        return Trial(given, generic, probes, lambda found: f"({_row(found[0], 3)})", "number")

    def is_inverse(self, matches: Iterable[Match]) -> bool:
        """Whether the right way of the other convention is among the matches."""
        right = [each for same in wordings(self.sequence.islower(), not self.turned).values() for each in same]
        other = self.match(self.placings[0], next(each for each in right if not each.slips), ())
        given, best = (GENERIC_ANGLES[0], PROBE_POINTS), min(matches, key=lambda match: match.cost)
        return bool(np.allclose(best.value(given), other.value(given)))

    def fits_unrounded(self, factors: Factors, wording: Wording) -> bool:
        """Whether angles that round to the given ones give the answer, judged by the differential."""
        slopes = []
        for half in np.diag(self.half_digits):
            high, low = (value(factors, wording, self.angles + step, self.points) for step in (half, -half))
            slopes.append((high - low).ravel() / 2)
        jacobian = np.transpose(slopes)
        missing = (self.target - value(factors, wording, self.angles, self.points)).ravel()
        steps, *_ = np.linalg.lstsq(jacobian, missing, rcond=1e-9)
        return bool(np.abs(missing - jacobian @ np.clip(steps, -1, 1)).max() <= self.tolerance)

    def chance(self, costs: np.ndarray, cost: float, further: tuple[Slip, ...]) -> float:
        """Return the expected number of accidental matches among misreadings that cost no more."""
        beside = np.array([place.cost for place in self.placings])
        more_digits = sum(slip.cost for slip in further)
        tries = np.searchsorted(costs, cost + more_digits - beside + 1e-9, side="right").sum()
        # A point moves on a sphere, a second one on a circle around the first. The cube of the tolerance covers
        # about six of its squares on the sphere.
        ratio = (self.reach if further else self.tolerance) / self.size
        share = min(1.0, 1.5 * ratio**2 / np.pi)
        if np.linalg.matrix_rank(self.points) > 1:
            share *= min(1.0, ratio / np.pi)
        return tries * share

    def what_is_known(self) -> str:
        """Say why no misreading can fit, or which simple one gives all coordinates but one."""
        right = self.placings[0]
        words = wordings(self.sequence.islower(), self.turned).values()
        for of_one, each in product(words, all_factors(self.sequence)):
            match = self.match(each.placed(right), of_one[0], ())
            if len(match.slips) < 2 and self.decimals > 1:
                found = value(each.placed(right), of_one[0], self.angles, self.points)
                off = np.abs(found - self.target) > self.tolerance
                if off.sum() == 1:
                    row, column = np.argwhere(off)[0]
                    name = f"row {column + 1}, column {row + 1}" if self.is_matrix else "xyz"[column]
                    rest = f"fits this misreading: {match.sentence}" if match.slips else "is right"
                    return f"Only {name} is off, the rest {rest}."
        if self.is_matrix and (said := read("matrix", self.target.T)).fault:
            return f"{said.fault} {said.remedy.rstrip(':')}."
        lengths, given = np.linalg.norm(self.target, axis=1), np.linalg.norm(self.points, axis=1)
        worst = np.abs(lengths - given).argmax()
        if abs(lengths[worst] - given[worst]) > 2 * self.tolerance:
            found, kept = lengths[worst], given[worst]
            return f"No rotation gives it: the answer has the length {found:.6g}, and a rotation keeps {kept:.6g}."
        if self.decimals > 1:
            return "It keeps the length, so it is a rotation, but by other angles."
        return "It is written too coarsely: some misreading would fit by accident. Give more digits or more points."


@lru_cache(maxsize=4)
def _products(sequence: str, angles: tuple[float, ...], turned: bool) -> tuple[list[Factors], np.ndarray]:
    """The factors that matter for `angles`, and their matrices, (factors, wordings, 3, 3)."""
    factors = [each for each in all_factors(sequence) if each.matters(np.array(angles))]
    return factors, matrices(factors, list(wordings(sequence.islower(), turned)), np.array(angles))


def _row(values: Iterable[float], decimals: int | None = None) -> str:
    return ", ".join(f"{value:g}" if decimals is None else f"{value:z.{decimals}f}" for value in values)
