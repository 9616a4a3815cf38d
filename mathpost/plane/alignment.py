"""The rotary angles that bring the tool onto a tilted plane, and what is then left between feature and machine."""

from dataclasses import dataclass

import numpy as np

from mathpost import angles as euler
from mathpost import chain
from mathpost.errors import InputError, ReachError
from mathpost.frame import Frame, machine_frames
from mathpost.kinematics import Kinematics
from mathpost.machine import Machine
from mathpost.rotation import unit, wrap

PARALLEL = 1e-9  # sine of the angle below which two directions count as parallel


@dataclass(frozen=True, eq=False)
class Solution:
    """One position of the rotary axes that puts the tool along the feature's Z.

    `spindle`, the spindle's axes, which a probe's stylus follows, and `slides`, the directions of the linear axes,
    which a G1 X moves along, are columns in the workpiece. With both rotary axes in the table they are one.
    """

    angles: np.ndarray  # the two rotary angles in the order of the machine file, degrees, in (−180, 180]
    spindle: np.ndarray  # shape (3, 3)
    slides: np.ndarray  # shape (3, 3)
    rho: float  # degrees about the feature's Z from the spindle's X to the feature's X: F = spindle·Rz(ρ)
    feature: Frame  # in the workpiece
    reason: str = ""  # the limit that keeps the machine from this position; empty if it is within travel

    @property
    def parallel(self):
        """Pairs of a linear axis and the feature's that it is parallel to; source 000 asks for one with X or Y."""
        return [
            (linear, axis)
            for linear, slide in zip("XYZ", self.slides.T, strict=True)
            for axis, direction in zip("XYZ", self.feature.rotation.T, strict=True)
            if np.linalg.norm(np.cross(slide, direction)) < PARALLEL
        ]

    def third_angle(self, along="spindle", feature="X"):
        """Return the third ZXZ angle K, degrees in (−180, 180], that lays the feature's X or Y along a direction.

        `along` is ``"spindle"`` for the spindle's X (ρ becomes 0 with `feature` X), or a linear axis of the
        machine; `ReachError` if that does not lie in the feature's plane. K goes with I and J of the feature's ZXZ
        angles.
        """
        directions = dict(zip("XYZ", self.slides.T, strict=True)) | {"spindle": self.spindle[:, 0]}
        if along not in directions or feature not in ("X", "Y"):
            expected = "'spindle', 'X', 'Y' or 'Z', and 'X' or 'Y'"
            raise InputError("along, feature", expected, f"{along!r}, {feature!r}")
        direction = directions[along]
        if abs(out_of_plane := direction @ self.feature.z) > PARALLEL:
            off = np.degrees(np.arcsin(min(abs(out_of_plane), 1.0)))
            what = f"no third angle lays the feature's {feature} along the machine's {along}"
            raise ReachError(f"{what}, which stands {off:.3f} degrees out of the plane")
        third = euler.angles("ZXZ", self.feature.rotation, degrees=True)[2]
        return float(wrap(third - _turn(direction, self.feature) - (90 if feature == "Y" else 0)))


@dataclass(frozen=True, eq=False)
class Alignment:
    """Both positions, as of `Kinematics.inverse`, that put the tool along the Z of one feature on a machine."""

    feature: Frame
    machine: Machine
    solutions: tuple  # where they are one position, both are it
    outer: int  # which of the two rotary angles is that of the axis next to the workpiece
    inner: int  # and next to the tool
    free: bool  # the outer axis is parallel to the feature's Z and may stand anywhere; it is given at 0

    def at(self, angles):
        """Return the `Solution` at these rotary angles, degrees, whether or not the tool then stands on Z."""
        return _solution(self.feature, self.machine, np.asarray(angles, dtype=float))


def align(feature, machine):
    """Return the `Alignment` of one feature, a `Frame` in the workpiece, on a `Machine` or its `Kinematics`.

    Two rotary axes place the tool axis and nothing else: `Solution.rho` is the angle left about it. `ReachError` if
    no rotary angle puts the tool there; a position beyond travel has the limit in `Solution.reason`.

    Examples
    --------
    >>> from mathpost import machine
    >>> from mathpost.plane.tilted_plane import Plane
    >>> found = align(Plane("G68.2", [135, 54.7356103172, 0]).frame, machine.load("bc_table"))
    >>> [solution.angles.round(4).tolist() for solution in found.solutions]
    [[54.7356, 45.0], [-54.7356, -135.0]]
    >>> round(found.solutions[0].rho, 6), round(found.solutions[0].third_angle(), 6)
    (90.0, -90.0)
    >>> found.solutions[1].reason
    'B at -54.7356, below its limit -35'
    """
    kinematics = machine if isinstance(machine, Kinematics) else Kinematics(machine)
    machine = kinematics.machine
    if np.shape(feature.rotation) != (3, 3):
        raise InputError("feature", "one frame", f"frames of shape {np.shape(feature.rotation)[:-2]}")
    (outer, *_), (inner, *_) = chain.between(machine)
    joints, axis = kinematics.inverse(feature.origin, feature.z, degrees=True), unit(np.array(outer.axis))
    if np.isnan(joints).any():
        low, high = np.degrees(kinematics.reach)
        angle = np.degrees(np.arccos(np.clip(axis @ feature.z, -1, 1)))
        raise ReachError(
            f"{machine.name}: the feature's Z stands {angle:.4f} degrees from axis {outer.name}, "
            f"which {inner.name} allows only from {low:.4f} to {high:.4f}"
        )
    solutions = tuple(_solution(feature, machine, branch[3:]) for branch in joints)
    free = bool(np.linalg.norm(np.cross(axis, feature.z)) < PARALLEL)
    return Alignment(feature, machine, solutions, *map(machine.rotary.index, (outer, inner)), free)


def _solution(feature, machine, angles):
    workpiece, tool = machine_frames(machine, [0, 0, 0, *angles], degrees=True)
    slides = workpiece.rotation.T
    spindle = slides @ tool.rotation
    rho = _turn(spindle[:, 0], feature)
    return Solution(angles, spindle, slides, rho, feature, beyond_travel(machine, angles))


def beyond_travel(machine, angles):
    """Say which rotary axis cannot stand at its angle (degrees), nor whole turns from it; empty if all can."""
    for rotary, angle in zip(machine.rotary, angles, strict=True):
        if np.isnan(rotary.nearest_turn(angle)):
            low, high = np.degrees(rotary.limits)
            side, limit = ("below", low) if angle < low else ("above", high)
            return f"{rotary.name} at {angle:.4f}, {side} its limit {limit:g}"
    return ""


def _turn(direction, feature):
    """The angle about the feature's Z from `direction` to the feature's X, degrees in (−180, 180]."""
    across = np.cross(feature.z, direction)
    return float(wrap(np.degrees(np.arctan2(across @ feature.x, direction @ feature.x))))
