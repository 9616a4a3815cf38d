"""Frames of a horizontal head on a five-face machine, from its measured vectors, as source 001 programs them.

For every index angle the head vector U is the machine position with the horizontal head at that angle minus that
with the vertical head, for the same point. `lhyset` and `lhy` are the source's two programs; `fit_head` adds a
model that predicts the positions in between. Angles are degrees throughout, as in its blocks.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from numbers import Real
from pathlib import Path

import numpy as np
import sympy as sp
from numpy.typing import ArrayLike

from mathpost.errors import InputError, as_array
from mathpost.formula import numeric
from mathpost.frame import Frame
from mathpost.rotation import ACTIVE, wrap
from mathpost.shop.measure import csv_table
from mathpost.shop.measure.fit import Estimate, Measurement, coverage_factor

VERTICAL = -1  # the source's mark for "measured with the vertical head"
TOLERANCE = 0.01  # degrees by which the read-back angle of an indexed head may miss its position
CPOS, UZZ = sp.symbols("CPOS U_ZZ", real=True)


@dataclass(frozen=True)
class Head:
    """A horizontal head: its measured vectors and its sense of rotation."""

    angles: tuple[float, ...]  # at which it is indexed
    vectors: np.ndarray  # U at each, shape (n, 3), mm
    sense: int = -1  # -1: clockwise seen from +Z as its angle grows, as in the source; otherwise +1
    zero: float = 0.0  # where Z′ points at angle 0, degrees from +X towards +Y

    def vector(self, angle: float) -> np.ndarray:
        """Return U at a listed angle (modulo 360°); any other is an `InputError`, never the nearest one."""
        if not isinstance(angle, Real):
            raise InputError("angle", "a number of degrees", repr(angle))
        away = np.abs(wrap(np.array(self.angles) - angle))
        if not away.min() <= TOLERANCE:
            measured = ", ".join(f"{listed:g}" for listed in self.angles)
            raise InputError("angle", f"one of the measured {measured}", f"{angle:g}")
        return self.vectors[np.argmin(away)]

    def rotation_z(self, angle: float) -> float:
        """The source's UZZ, degrees: by how much AROT turns about Z."""
        turned = 90 + self.zero + self.sense * angle
        return turned if -180 <= turned <= 180 else float(wrap(turned))  # the source keeps −180

    def frame(self, angle: float) -> np.ndarray:
        """Return the directions X′ Y′ Z′ of the frame as columns, shape (3, 3); Z′ points into the spindle."""
        return numeric(frame_symbolic(), (UZZ,))(np.deg2rad(self.rotation_z(angle)))


@dataclass(frozen=True, eq=False)
class HeadFrame(Frame):
    """The frame X′ Y′ Z′ that `lhy` sets on top of the active work offset, and its Siemens blocks."""

    block: str = ""


def frame_symbolic() -> sp.Matrix:
    """AROT Z=U_ZZ X=90 as a matrix: Siemens turns about Z first, then about the new X."""
    return sp.ImmutableMatrix(ACTIVE["Z"](UZZ) * ACTIVE["X"](sp.pi / 2))


def read_head(path: Path | str, *, sense: int = -1, zero: float = 0.0) -> Head:
    """Read measured head vectors from a CSV file with the columns angle (degrees), x, y, z (mm).

    `sense` and `zero` are those of `Head`. `InputError` if the file has a fault, an angle twice, or a vector that
    does not point along Z′: the table is vertical minus horizontal, or the head turns the other way.
    """
    columns = csv_table.read(path, ["angle", "x", "y", "z"])
    columns.obey_units(columns)
    columns.check_angles("angle")
    columns.check_increasing("angle")
    angles, vectors = columns["angle"], np.column_stack([columns[name] for name in "xyz"])
    columns.require("angle", angles - angles[0] < 360 - TOLERANCE, "an angle that is not the first one again")
    if sense not in (-1, 1):
        raise InputError("sense", "-1 or 1", repr(sense))
    head = Head(tuple(angles.tolist()), vectors, sense, zero)
    along = np.array([head.frame(angle)[:2, 2] @ u[:2] for angle, u in zip(angles, vectors, strict=True)])
    ratio = along / np.linalg.norm(vectors[:, :2], axis=1)
    opposite = "a vector along Z′ (this is the opposite: vertical minus horizontal?)"
    columns.require("x", ~((ratio < -0.99).all() & (ratio < 0)), opposite)
    columns.require("x", ratio > 0.99, "a vector along Z′ at this angle (does the head turn the other way?)")
    return head


def lhyset(head: Head, x: float, y: float, z: float) -> np.ndarray:
    """Return U_LHY, shape (3,): the correction that takes the measured offset back to the vertical head.

    `x`, `y`, `z` are the head's angles when these axes of the work offset were measured, or `VERTICAL`.
    """
    rows = [(head.vector(angle) if angle != VERTICAL else np.zeros(3)) for angle in (x, y, z)]
    return -np.diag(rows) + 0.0


def lhy(head: Head, correction: ArrayLike, angle: float) -> HeadFrame:
    """Return the `HeadFrame` for the head at `angle`, CPOS in degrees, or `VERTICAL`; `correction` is `lhyset`'s.

    Examples
    --------
    >>> head = read_head("data/measurements/five_face_head.csv")
    >>> frame = lhy(head, lhyset(head, 90, VERTICAL, 90), 180)
    >>> print(frame.block)
    TRANS X=-378.920 Y=0.050 Z=-0.065
    AROT Z=-90.000 X=90
    >>> (frame.point([10, 20, 30]) + [1000, 500, 300]).round(3)
    array([591.08 , 490.05 , 319.935])
    """
    vertical, origin = angle == VERTICAL, as_array(correction, 3, "correction")
    origin = origin if vertical else origin + head.vector(angle)
    block = "TRANS " + " ".join(f"{axis}={value:z.3f}" for axis, value in zip("XYZ", origin, strict=True))
    if not vertical:
        block += f"\nAROT Z={head.rotation_z(angle):z.3f} X=90"
    return HeadFrame(np.eye(3) if vertical else head.frame(angle), origin, block=block)


def opposite_errors(head: Head) -> dict[float, np.ndarray]:
    """Return the errors that the OEM's rule leaves: measure one side, flip the signs of x and y for the other.

    A dict: angle to an array (3,), mm, for every listed angle whose opposite is listed before it.
    """
    return {
        angle: head.vector(angle) - head.vector(angle - 180) * [-1, -1, 1]
        for angle in head.angles
        if any(abs(angle - 180 - listed) <= TOLERANCE for listed in head.angles)
    }


def turning_arm(sense: int = -1, zero: float = 0.0) -> Measurement:
    """The head as a `Measurement`: an arm (a along Z′, b square to it) turning about a line through (cx, cy).

    Readings x, y, z of U at `CPOS`; a tilt of the line makes z vary as e·cos + f·sin about d.
    """
    cx, cy, a, b, d, e, f = sp.symbols("cx cy a b d e f", real=True)
    arm = ACTIVE["Z"](sp.rad(zero) + sense * CPOS) * sp.Matrix([a, b, 0])
    return Measurement(
        name="horizontal head",
        unknowns=(cx, cy, a, b, d, e, f),
        settings=(CPOS,),
        readings={"x": cx + arm[0], "y": cy + arm[1], "z": d + e * sp.cos(CPOS) + f * sp.sin(CPOS)},
        more={
            "one position more": {CPOS: CPOS + sp.pi / 4},
            "the same 90° further": {CPOS: CPOS + sp.pi / 2},
            "the same 180° further": {CPOS: CPOS + sp.pi},
        },
    )


@dataclass(frozen=True)
class FittedHead:
    """The model fitted to a `Head`, with its `mathpost.shop.measure.fit.Estimate`."""

    measured: Head
    estimate: Estimate
    repeated: tuple[str, ...] = ()  # coordinates that repeat to the last digit: they say nothing of the noise

    @property
    def residuals(self) -> np.ndarray:
        """Measured minus modelled U, shape (n, 3), mm."""
        return np.column_stack([self.estimate.residuals[name] for name in "xyz"])

    @property
    def tilt(self) -> float:
        """The angle between the head's axis of rotation and Z, radians."""
        e, f, a, b = (self.estimate[name] for name in "efab")
        return float(np.hypot(e, f) / np.hypot(a, b))

    def at(self, angles: ArrayLike) -> Head:
        """Return a `Head` with the predicted vectors of these positions, degrees."""
        turning = turning_arm(self.measured.sense, self.measured.zero)
        predicted = turning.predict(self.estimate.values, {"CPOS": angles}, degrees=True)
        vectors = np.column_stack([predicted[name] for name in "xyz"])
        return Head(
            tuple(np.asarray(angles, dtype=float).tolist()), vectors, self.measured.sense, self.measured.zero
        )

    def expanded(self, angle: float) -> np.ndarray:
        """Return the expanded uncertainty of the predicted vector, shape (3,), mm, 95 %, without index errors."""
        turning = turning_arm(self.measured.sense, self.measured.zero)
        each = [turning.predict({name: 1.0}, {"CPOS": angle}, degrees=True) for name in self.estimate.values]
        slopes = np.array([[one[axis] for one in each] for axis in "xyz"])  # the model is linear in its unknowns
        variances = np.diag(slopes @ self.estimate.covariance @ slopes.T)
        return coverage_factor(self.estimate.freedom) * np.sqrt(variances)

    def head(self, step: float = 2.5) -> Head:
        """Return a `Head` with the predicted vectors of every index position, `step` degrees apart."""
        count = 360 / step if step > 0 else 0.5
        if round(count) < 1 or abs(count - round(count)) > 1e-9:
            raise InputError("step", "a whole fraction of 360°", f"{step:g}")
        return self.at(np.arange(round(count)) * step)


def fit_head(head: Head, *, sigma: float | None = None) -> FittedHead:
    """Fit the model to a measured head, as `FittedHead`; three positions or more, else `InputError`.

    `sigma` is the standard deviation of a coordinate, mm; without it the residuals supply it, but for those of a
    coordinate of which each reading repeats another to the last digit: that was not measured. Index errors of
    positions that were not measured stay unseen; the residuals show how large they may be.

    Examples
    --------
    >>> fitted = fit_head(read_head("data/measurements/five_face_head.csv"))
    >>> fitted.head(step=2.5).vector(45).round(3)
    array([ 267.988, -267.902,  533.481])
    """
    arm, coordinates = turning_arm(head.sense, head.zero), dict(zip("xyz", head.vectors.T, strict=True))
    read = {"CPOS": head.angles} | coordinates
    repeated = tuple(name for name, values in coordinates.items() if _all_repeat(values))
    if sigma is not None or not repeated or len(repeated) == 3:
        return FittedHead(head, arm.identify(read, degrees=True, sigma=sigma), repeated)
    heard = arm.identify({name: read[name] for name in read if name not in repeated}, degrees=True)
    found = arm.identify(read, degrees=True, sigma=heard.noise) if heard.spare else arm.identify(read, degrees=True)
    return FittedHead(head, replace(found, spare=heard.spare, noise=heard.noise, freedom=heard.freedom), repeated)


def _all_repeat(values: np.ndarray) -> bool:
    """Whether each of these readings repeats another to the last digit: a measurement seldom does."""
    _, counts = np.unique(values, return_counts=True)
    return bool((counts > 1).all())
