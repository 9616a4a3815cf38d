"""The rotary angles that bring the tool onto a tilted plane, and which of the two positions a control takes.

`align` finds both positions, and the rotation that is then left between feature and machine. Each control's
documented rule takes the `Alignment` and the present angles of the k rotary axes, shape (k,), and returns the
`Solution` that they go to; where no position is within travel it raises `ReachError` with the limits. Positions are
rotary angles in degrees, in the order of the machine file. A control is assumed to take the winding within travel
that is nearest to the present angle; an endless axis then shows it in (−180, 180], which is the same position.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from mathpost import euler
from mathpost.chain import machine_frames
from mathpost.errors import InputError, ReachError, as_array
from mathpost.frame import Frame
from mathpost.kinematics import Kinematics
from mathpost.machine import Machine
from mathpost.rotation import unit, wrap

TIE = 1e-6  # degrees
STANDING = 1e-3  # degrees, which printed angles and planes differ by
ALONE = "the only one within travel"
PARALLEL = 1e-9  # sine of the angle below which two directions count as parallel


@dataclass(frozen=True, eq=False)
class Solution:
    """One position of the rotary axes that puts the tool along the feature's Z.

    `spindle`, the spindle's axes, which a probe's stylus follows, and `slides`, the directions of the linear axes,
    which a G1 X moves along, are columns in the workpiece. With both rotary axes in the table they are one.
    """

    angles: np.ndarray  # the rotary angles in the order of the machine file, degrees, in (−180, 180]
    spindle: np.ndarray  # shape (3, 3)
    slides: np.ndarray  # shape (3, 3)
    rho: float  # degrees about the feature's Z from the spindle's X to the feature's X: F = spindle·Rz(ρ)
    feature: Frame  # in the workpiece
    reason: str = ""  # the limit that keeps the machine from this position; empty if it is within travel
    why: str = ""  # the clause of a control's rule that chose it

    @property
    def parallel(self) -> list[tuple[str, str]]:
        """Pairs of a linear axis and the feature's axis parallel to it; source 000 asks for one with X or Y."""
        slides, axes = self.slides.T, self.feature.rotation.T
        sines = np.linalg.norm(np.cross(slides[:, None], axes), axis=-1)
        return [("XYZ"[linear], "XYZ"[axis]) for linear, axis in np.argwhere(sines < PARALLEL)]

    def third_angle(self, along: str = "spindle", feature: str = "X") -> float:
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
            raise ReachError(f"{what}, which is {off:.3f} degrees out of the plane")
        third = euler.angles("ZXZ", self.feature.rotation, degrees=True)[2]
        return float(wrap(third - _turn(direction, self.feature) - (90 if feature == "Y" else 0)))


@dataclass(frozen=True, eq=False)
class Alignment:
    """All positions, as from `Kinematics.inverse`, that put the tool along the Z of one feature on a machine."""

    feature: Frame
    machine: Machine
    positions: np.ndarray  # rotary angles of both, equal if they coincide, degrees, shape (2, 2); one axis: (1, 1)
    workpiece_side: int  # index, among the rotary axes, of the one next to the workpiece
    tool_side: int  # and of the one next to the tool; the same if there is only one
    free: bool  # the workpiece-side axis is parallel to the feature's Z and its angle arbitrary; it is given as 0

    def at(self, angles: ArrayLike) -> Solution:
        """Return the `Solution` at these rotary angles, degrees, whether or not the tool is then along Z."""
        angles = np.asarray(angles, dtype=float)
        workpiece, tool = machine_frames(self.machine, [0, 0, 0, *angles], degrees=True)
        slides = workpiece.rotation.T
        spindle = slides @ tool.rotation
        rho, reason = _turn(spindle[:, 0], self.feature), beyond_travel(self.machine, angles)
        return Solution(angles, spindle, slides, rho, self.feature, reason)

    @cached_property
    def solutions(self) -> tuple[Solution, ...]:
        """The `Solution` of each position."""
        return tuple(map(self.at, self.positions))


def align(feature: Frame, machine: Machine | Kinematics) -> Alignment:
    """Return the `Alignment` of one feature, a `Frame` in the workpiece, on a `Machine` or its `Kinematics`.

    Two rotary axes place the tool axis and nothing else: `Solution.rho` is the angle left about it. `ReachError` if
    no rotary angle puts the tool there; a position beyond travel has the limit in `Solution.reason`.

    Examples
    --------
    >>> import mathpost
    >>> plane = mathpost.Plane("G68.2", [135, 54.7356103172, 0])
    >>> found = align(plane.frame, mathpost.load_machine("bc_table"))
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
    places = kinematics.workpiece_side - 3, (kinematics.tool_side or kinematics.workpiece_side) - 3
    workpiece_side, tool_side = (machine.rotary[place] for place in places)
    joints, axis = kinematics.inverse(feature.origin, feature.z, degrees=True), unit(np.array(workpiece_side.axis))
    joints = joints[: len(machine.rotary)]
    if np.isnan(joints).any():
        low, high = np.degrees(kinematics.reach)
        pole = np.array(kinematics.inverse_symbolic.pole, dtype=float)
        angle = np.degrees(np.arccos(np.clip(pole @ feature.z, -1, 1)))
        end = " ".join(f"{x:z.3f}" for x in pole)
        where = f"the pole ({end}), the end of axis {workpiece_side.name}"
        lean = f"the feature's Z is {angle:.4f} degrees from {where}"
        allows = f"only from {low:.4f} to {high:.4f}" if high > low else f"only at {low:.4f}"
        raise ReachError(f"{machine.name}: {lean}, which {tool_side.name} allows {allows}")
    free = bool(np.linalg.norm(np.cross(axis, feature.z)) < PARALLEL)
    return Alignment(feature, machine, joints[:, 3:], *places, free)


def beyond_travel(machine: Machine, angles: Iterable[float]) -> str:
    """Say which rotary axis cannot reach its angle (degrees) in any winding; empty if all can."""
    for rotary, angle in zip(machine.rotary, angles, strict=True):
        if np.isnan(rotary.nearest_turn(angle)):
            low, high = np.degrees(rotary.limits)
            side, limit = ("below", low) if angle < low else ("above", high)
            return f"{rotary.name} at {angle:.4f}, {side} its limit {limit:g}"
    return ""


def _turn(direction: np.ndarray, feature: Frame) -> float:
    """The angle about the feature's Z from `direction` to the feature's X, degrees in (−180, 180]."""
    across = np.cross(feature.z, direction)
    return float(wrap(np.degrees(np.arctan2(across @ feature.x, direction @ feature.x))))


def fanuc(alignment: Alignment, present: ArrayLike, *, master: str | None = None) -> Solution:
    """Choose as Fanuc's G53.1 does (Series 16i/18i-MB, operator's manual B-63534EN, tool axis direction control).

    The smallest motion of the master axis; if equal, of the slave; if equal, the master nearest to 0; if equal, the
    slave nearest to 0. The master is the axis nearest to the bed, on a machine with one table and one head the
    table's; `master` names it if a parameter of the control says otherwise.

    Examples
    --------
    >>> import mathpost
    >>> tilted = align(mathpost.Plane("PLANE SPATIAL", [0, 45, 0]).frame, mathpost.load_machine("ac_table"))
    >>> fanuc(tilted, [20, -60]).angles.round(6), fanuc(tilted, [20, -60], master="C").angles.round(6)
    (array([45., 90.]), array([-45., -90.]))
    """
    own = alignment.machine.joint_names[3:]
    if master not in (None, *own):
        raise InputError("rotary axis", f"one of {', '.join(own)}", repr(master))
    first = own.index(master) if master else 0
    order = (first, 1 - first)[: len(alignment.machine.rotary)]
    names = {n: own[n] for n in order}
    clauses: dict[str, Callable] = {
        f"smallest motion of {name}": lambda _, motion, n=n: abs(motion[n]) for n, name in names.items()
    }
    clauses |= {f"{name} nearest to 0": lambda angles, _, n=n: abs(wrap(angles[n])) for n, name in names.items()}
    return _choose(alignment, present, clauses)


def heidenhain(alignment: Alignment, present: ArrayLike, *, seq: str = "", rot: str = "COORD") -> Solution:
    """Choose as Heidenhain's PLANE does: SEQ by the master axis, otherwise by travel and shortest path.

    The master is the first rotary axis from the tool. The manual says neither how a path is measured nor what
    breaks a tie: here its length is √(Δ₁² + Δ₂²), and of two equal paths the one with the higher master angle is
    taken, as in the manual's example.

    `seq` may be ``"+"`` or ``"-"``, the master above or below 0; where that is not within travel the control says
    "Entered angle not permitted". `rot` is ``"COORD"``, which leaves a free table axis where it is and turns the
    coordinates, or ``"TABLE"``, which turns the axis until the feature's X is the spindle's.
    """
    if seq not in ("", "+", "-"):
        raise InputError("seq", "'+', '-' or nothing", repr(seq))
    if rot not in ("COORD", "TABLE"):
        raise InputError("rot", "'COORD' or 'TABLE'", repr(rot))
    master = alignment.tool_side
    name, word = alignment.machine.joint_names[3 + master], f"SEQ{seq}"

    def refuse(angles: np.ndarray) -> str:
        above = wrap(angles[master]) * (-1 if seq == "-" else 1)
        return f"{name} at {angles[master]:.4f} is not {word}" if seq and above < -TIE else ""

    clauses = {
        "shortest path": lambda _, motion: np.linalg.norm(motion),
        f"higher {name}": lambda angles, _: -angles[master],
    }
    return _choose(alignment, present, clauses, refuse, turn_table=rot == "TABLE", alone=word if seq else ALONE)


def siemens(alignment: Alignment, present: ArrayLike, direction: int) -> Solution:
    """Choose as CYCLE800's _DIR does: the lower (−1) or the higher (+1) value of the reference rotary axis.

    If that is out of travel the other is taken, as the manual says. Which axis is the reference is set when the
    machine is commissioned; taken here is the one next to the tool.
    """
    if direction not in (-1, 1):
        raise InputError("direction", "-1 or +1", repr(direction))
    axis = alignment.tool_side
    clause = f"{'higher' if direction > 0 else 'lower'} {alignment.machine.joint_names[3 + axis]}"
    return _choose(alignment, present, {clause: lambda angles, _: -direction * wrap(angles[axis])})


def standing(alignment: Alignment, present: ArrayLike) -> Solution:
    """Choose where no rule is known: the position where the axes stand, or the only one within travel.

    Otherwise `ReachError`: which one a control takes is then not known.
    """
    found = _choose(alignment, present, {"where the axes stand": lambda _, motion: np.abs(motion).max()})
    if found.why != ALONE and np.abs(wrap(found.angles - np.asarray(present))).max() > STANDING:
        raise ReachError(
            f"{alignment.machine.name}: two positions are within travel, and which one is taken is not known"
        )
    return found


def _choose(
    alignment: Alignment,
    present: ArrayLike,
    clauses: dict[str, Callable],
    refuse: Callable[[np.ndarray], str] = lambda angles: "",
    *,
    turn_table: bool = False,
    alone: str = ALONE,
) -> Solution:
    """Return the position with the least measure by the first clause that differs, turned towards `present`.

    `clauses` maps words to a measure of the angles and of the motion from `present`; `alone` is the reason given
    if only one position is left.
    """
    rotary = alignment.machine.rotary
    present = as_array(present, len(rotary), "present")
    if present.ndim != 1:
        raise InputError("present", "the rotary angles", f"shape {present.shape}")
    left, reasons = [], []
    for solution in alignment.solutions:
        angles = solution.angles.copy()
        if alignment.free:  # it stays where it is, or turns until ρ is 0: one degree shows which way ρ goes
            angles[alignment.workpiece_side] = 1.0
            slope = np.sign(wrap(alignment.at(angles).rho - solution.rho))
            angles[alignment.workpiece_side] = (
                -slope * solution.rho if turn_table else present[alignment.workpiece_side]
            )
        if reason := refuse(angles) or beyond_travel(alignment.machine, angles):
            reasons.append(reason)
        else:
            turned = zip(rotary, angles, present, strict=True)
            left.append(np.array([joint.nearest_turn(angle, now) for joint, angle, now in turned]))
    if not left:
        raise ReachError(f"{alignment.machine.name}: entered angle not permitted ({'; '.join(reasons)})")
    why = alone
    for clause, measure in clauses.items():
        if len(left) > 1:
            measured = [measure(angles, angles - present) for angles in left]
            least = [angles for angles, size in zip(left, measured, strict=True) if size <= min(measured) + TIE]
            why, left = clause if len(least) < len(left) else "both are one position", least
    endless = [np.isinf(joint.limits).all() for joint in rotary]
    return replace(alignment.at(np.where(endless, wrap(left[0]), left[0])), why=why)
