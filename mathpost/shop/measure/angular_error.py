"""Angular positioning error of a rotary axis: statistics of ISO 230-2, and the commands that compensate it.

As in a measuring report and in the control's tables, angles are degrees here and errors seconds of arc: actual
minus target, so that a command is corrected by *subtracting* the error.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from mathpost.errors import InputError, as_array
from mathpost.shop.measure import csv_table, spline

if TYPE_CHECKING:
    from mathpost.shop.measure.spline import Curve, Points

ARCSECONDS = 3600  # in a degree
RUNS = tuple(f"{side}{run}" for run in range(1, 51) for side in ("up", "down"))  # columns of a report
SMALLEST = 0.05  # seconds of arc: a table whose errors are all smaller was given in another unit


@dataclass(frozen=True)
class Runs:
    """Repeated approaches of the same targets from both sides."""

    angles: np.ndarray  # degrees, increasing, shape (targets,)
    up: np.ndarray  # errors in the positive direction, seconds of arc, shape (targets, runs)
    down: np.ndarray  # and in the negative one

    def mean(self, direction: str = "both") -> np.ndarray:
        """Return the mean error at each target, shape (targets,), for "up", "down" or "both" directions."""
        up, down = self.up.mean(axis=1), self.down.mean(axis=1)
        means = {"up": up, "down": down, "both": (up + down) / 2}
        if direction not in means:
            raise InputError("direction", '"up", "down" or "both"', repr(direction))
        return means[direction]

    def points(self, direction: str = "both", *, endless: bool = False) -> Points:
        """Return the means as `spline.Points`, which repeat after 360° if the axis is endless."""
        return spline.points(self.angles, self.mean(direction), period=360.0 if endless else None)


@dataclass(frozen=True)
class Accuracy:
    """The parameters of ISO 230-2, seconds of arc: at each target, of all, and as triples for up, down and both."""

    s_up: np.ndarray  # standard deviations
    s_down: np.ndarray
    reversal: np.ndarray  # mean up minus mean down
    B: float  # the largest |reversal|
    M: float  # the range of the mean of both directions
    E: tuple[float, ...]  # the range of the means
    R: tuple[float, ...]  # the widest 4 s, of both directions 2 s up + 2 s down + |B| if that is wider
    A: tuple[float, ...]  # from the lowest mean − 2 s to the highest mean + 2 s

    def __str__(self) -> str:
        pairs = (("A", self.A[2]), ("E", self.E[2]), ("M", self.M), ("B", self.B), ("R", self.R[2]))
        return "   ".join(f"{name} {value:6.2f}" for name, value in pairs) + "   arcsec"


def read_runs(path: Path | str) -> Runs:
    """Read bidirectional runs from a CSV file with the columns angle, up1, down1, up2, down2, … as `Runs`.

    Angles in degrees, increasing; errors in seconds of arc unless the file names another unit. `InputError` with
    file, line and column for a fault, and for what suggests other units: an angle beyond a turn, an error beyond a
    degree, none beyond 0.05″.
    """
    also = dict.fromkeys(("A", "B", "C", "position"), "angle")
    read = csv_table.read(path, ["angle", *RUNS[:4]], optional=RUNS[4:], also=also)
    runs = (sum(name in read for name in RUNS) + 1) // 2
    names = RUNS[: 2 * runs]
    read.need(names, f"as many runs down as up: up1, down1, … {names[-1]}")
    for name in names:
        size = read.unit(name, "angle", default="arcsec")
        read[name] = np.rad2deg(size) * ARCSECONDS * read[name]
        read.require(name, np.abs(read[name]) <= ARCSECONDS, "seconds of arc, less than a degree (other units?)")
    most = max(np.abs(read[name]).max() for name in names)
    if 0 < most < SMALLEST and "unit" not in read.settings:
        raise InputError(read.where(0, "up1"), "a unit, in a line such as # unit = deg", f"{most:g}″ at most")
    read.obey_units(["angle"])
    read.check_angles("angle")
    read.check_increasing("angle")
    up, down = (np.column_stack([read[name] for name in names[side::2]]) for side in (0, 1))
    return Runs(read["angle"], up, down)


def from_arrays(angles: ArrayLike, up: ArrayLike, down: ArrayLike) -> Runs:
    """Check arrays of the shapes of `Runs` and return them as one; two approaches or more from each side."""
    angles = as_array(angles, np.size(angles), "angles")
    up, down = (np.asarray(runs, dtype=float) for runs in (up, down))
    for name, runs in (("up", up), ("down", down)):
        if runs.shape != up.shape or runs.ndim != 2 or len(runs) != angles.size or runs.shape[1] < 2:
            raise InputError(name, f"shape ({angles.size}, runs) with two runs or more, as up", f"{runs.shape}")
        as_array(runs, runs.shape[1], name)
    if not (np.diff(angles) > 0).all():
        raise InputError("angles", "increasing angles", "a step back or a duplicate")
    return Runs(angles, up, down)


def accuracy(runs: Runs) -> Accuracy:
    """Return the `Accuracy` of `runs` after ISO 230-2, with the coverage factor 2.

    Examples
    --------
    >>> print(accuracy(read_runs("data/measurements/angular_error.csv")))
    A  27.69   E  26.92   M  26.08   B   1.39   R   1.95   arcsec
    """
    up, down = runs.mean("up"), runs.mean("down")
    s_up, s_down = runs.up.std(axis=1, ddof=1), runs.down.std(axis=1, ddof=1)
    reversal = up - down
    triples = [(up, s_up), (down, s_down), (np.append(up, down), np.append(s_up, s_down))]
    across = (2 * s_up + 2 * s_down + np.abs(reversal)).max()
    repeatability = [float(4 * s.max()) for _, s in triples]
    return Accuracy(
        s_up,
        s_down,
        reversal,
        B=float(np.abs(reversal).max()),
        M=float(np.ptp(runs.mean())),
        E=tuple(float(np.ptp(mean)) for mean, _ in triples),
        R=(*repeatability[:2], max(*repeatability, float(across))),
        A=tuple(float((mean + 2 * s).max() - (mean - 2 * s).min()) for mean, s in triples),
    )


def commands(error: Curve, targets: ArrayLike) -> np.ndarray:
    """Return the angles to command so that the axis arrives at `targets`, degrees: target minus error.

    `error` is a `mathpost.shop.measure.spline.Curve`, seconds of arc over degrees. It is taken at the target, as in
    a control's table; at the command it would differ by some thousandths of a second of arc.
    """
    targets = np.asarray(targets, dtype=float)
    return targets - error(targets) / ARCSECONDS


def command_table(error: Curve, targets: Sequence[float]) -> str:
    """Return the compensated command table as the text of a CSV file: target, error, correction, command."""
    rows = ["# errors in seconds of arc, actual minus target; angles in degrees", "target,error,correction,command"]
    for target, command in zip(targets, commands(error, targets), strict=True):
        value = float(error(target))
        rows.append(f"{target:.6f},{value:z.3f},{-value:z.3f},{command:z.6f}")
    return "\n".join(rows) + "\n"
