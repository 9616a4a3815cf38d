"""An interpolating cubic spline through measured points: all of them, every n-th, or those chosen adaptively.

Huang et al. (source 001) name "cubic spline interpolation with adaptively chosen knots" and give no more. The units
are the caller's.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
import scipy
from numpy.typing import ArrayLike

from mathpost.errors import InputError, ReachError, as_array

ROUNDING = 1e-9  # by which a position may be beyond the ends


@dataclass(frozen=True)
class Points:
    """Measured values at increasing positions: less than once around a `period`, if there is one."""

    at: np.ndarray  # shape (points,)
    values: np.ndarray  # shape (points, ...)
    period: float | None
    closure: float = 0.0  # change of the value over one period, if that was measured


@dataclass(frozen=True)
class Curve:
    """A cubic spline, or `straight` lines, through some of the points: `knots`, indices in the order of choice."""

    points: Points
    knots: tuple[int, ...]
    straight: bool = False

    @cached_property
    def spline(self) -> scipy.interpolate.BSpline | scipy.interpolate.CubicSpline:
        """SciPy's spline: periodic, or with not-a-knot ends."""
        chosen, period = sorted(self.knots), self.points.period
        at, values = self.points.at[chosen], self.points.values[chosen]
        if period is not None:
            at, values = np.append(at, at[0] + period), np.concatenate([values, values[:1]])
        around = False if period is None else "periodic"
        if self.straight:
            return scipy.interpolate.BSpline(np.r_[at[0], at, at[-1]], values, 1, extrapolate=around)
        return scipy.interpolate.CubicSpline(at, values, bc_type=around or "not-a-knot", extrapolate=around)

    def __call__(self, positions: ArrayLike, *, margin: float = ROUNDING, where: str = "position") -> np.ndarray:
        """Return the value at `positions`; `ReachError` where they leave an open curve by more than `margin`."""
        positions = np.asarray(positions, dtype=float)
        if self.points.period is not None:
            return self.spline(positions)
        low, high = self.points.at[[0, -1]]
        inside = positions.clip(low, high)
        if (outside := np.abs(positions - inside) > margin).any():
            first = f"{where}: {positions[outside].flat[0]:.6g}"
            raise ReachError(f"{first} was not measured: {low:.6g} to {high:.6g} was")
        return self.spline(inside)

    @cached_property
    def residuals(self) -> np.ndarray:
        """Measured value minus curve at every measured point; it says nothing about the curve between them."""
        residuals = self.points.values - self.spline(self.points.at)
        residuals[list(self.knots)] = 0
        return residuals

    @property
    def residual(self) -> float:
        """The size of the largest residual."""
        return float(np.abs(self.residuals).max())


def points(at: ArrayLike, values: ArrayLike, *, period: float | None = None) -> Points:
    """Check measured values at increasing positions, shapes (points,), and return them as `Points`.

    `period` is 360 for degrees of an endless axis. A first position that was measured again one period later counts
    once, with the mean of its two values; their difference is the `closure`. `InputError` if the positions do not
    increase, span more than a period, or are fewer than two (three with a period).

    Examples
    --------
    >>> measured = points([0, 90, 180, 270, 360], [1.0, 4.0, 0.0, -2.0, 1.5], period=360)
    >>> measured.values, measured.closure
    (array([ 1.25, 4. , 0. , -2. ]), 0.5)
    """
    at, values = as_array(at, np.size(at), "positions"), as_array(values, np.size(at), "values")
    if at.ndim != 1 or values.ndim != 1:
        raise InputError("positions and values", "one dimension each", f"shapes {at.shape} and {values.shape}")
    for before, after in pairwise(at):
        if after <= before:
            what = "a duplicate" if after == before else "out of order"
            raise InputError("positions", "increasing numbers", f"{after:.10g} after {before:.10g}, {what}")
    closure, span = 0.0, np.ptp(at) if at.size else 0.0
    if period is not None and span > period * (1 + 1e-12):
        raise InputError("positions", f"at most one period of {period:g}", f"{span:.10g} from first to last")
    if period is not None and np.isclose(span, period, rtol=1e-12, atol=0):
        closure = float(values[-1] - values[0])
        at, values = at[:-1], np.append((values[0] + values[-1]) / 2, values[1:-1])
    fewest = 2 if period is None else 3
    if at.size < fewest:
        raise InputError("positions", f"at least {fewest} different ones", f"{at.size}")
    return Points(at, values, period, closure)


def through_all(measured: Points, *, straight: bool = False) -> Curve:
    """Return the `Curve` through every point of the `Points` `measured`."""
    return Curve(measured, tuple(range(len(measured.at))), straight)


def uniform(measured: Points, count: int) -> Curve:
    """Return the `Curve` through `count` of the `Points`, equally far apart among them.

    `InputError` if `count` does not divide them equally: nearly uniform knots would be comparable with nothing.
    """
    size = len(measured.at)
    gaps, intervals = (size, count) if measured.period else (size - 1, count - 1)
    fewest = 3 if measured.period else 2
    if count < fewest or count > size or gaps % intervals:
        allowed = [n for n in range(fewest, size + 1) if gaps % (n if measured.period else n - 1) == 0]
        raise InputError("count", f"one of {', '.join(map(str, allowed))}, which divide {size} points", f"{count}")
    return Curve(measured, tuple(range(0, size, gaps // intervals)))


def adaptive(measured: Points, tolerance: float) -> Curve:
    """Return the `Curve` through as few points as the greedy choice needs to meet all of them to `tolerance`.

    It begins with both ends, or with three points about a third of the period apart, and makes the point with the
    largest residual the next knot. That residual need not fall with every knot.

    Examples
    --------
    >>> angle = np.arange(0, 360, 10)
    >>> curve = adaptive(points(angle, 12 * np.sin(np.deg2rad(angle)), period=360), 0.5)
    >>> len(curve.knots), f"{curve.residual:.3f}", f"{curve(360) - curve(0):z.9f}"
    (5, '0.049', '0.000000000')
    """
    if not tolerance > 0:
        raise InputError("tolerance", "a number above 0", f"{tolerance}")
    at = measured.at
    knots: tuple[int, ...] = (0, len(at) - 1)
    if measured.period is not None:
        thirds = dict.fromkeys(int(np.argmin(np.abs(at - at[0] - measured.period * n / 3))) for n in (0, 1, 2))
        knots = tuple(thirds) if len(thirds) == 3 else (0, 1, len(at) - 1)
    curve = Curve(measured, knots)
    while curve.residual > tolerance:
        curve = Curve(measured, (*curve.knots, int(np.argmax(np.abs(curve.residuals)))))
    return curve
