"""The positions of a machine for one tool tip and tool axis, and which of them each control takes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from mathpost.errors import ReachError, as_array
from mathpost.frame import Frame
from mathpost.kinematics import Kinematics
from mathpost.machine import Rotary
from mathpost.rotation import unit
from mathpost.shop.plane import positioning

CONTROLS: dict[str, Callable] = {
    "Fanuc G53.1": positioning.fanuc,
    "Heidenhain PLANE": positioning.heidenhain,
    "Siemens _DIR -1": lambda alignment, present: positioning.siemens(alignment, present, -1),
    "Siemens _DIR +1": lambda alignment, present: positioning.siemens(alignment, present, 1),
}
SAME = 1e-9  # radians: positions nearer than this are one
MOST_TURNS = 10  # whole turns to either side of an angle that are considered


@dataclass(frozen=True, eq=False)
class Position:
    """One position of a machine, and the pose of its tool."""

    joints: np.ndarray  # X Y Z in mm and the rotary angles in degrees, in the order of the machine file
    tip: np.ndarray  # of the tool in the workpiece, mm, shape (3,)
    axis: np.ndarray  # a unit vector from the tip towards the spindle, shape (3,)
    from_pole: float  # degrees between the tool axis and the pole, where the two branches meet
    reasons: tuple[str, ...] = ()  # sentences that say which joints are outside travel; empty if all are inside


@dataclass(frozen=True)
class Taken:
    """The rotary angles that a control goes to, in degrees, and why; no angles if it refuses."""

    angles: np.ndarray | None
    why: str


def at(kinematics: Kinematics, joints: np.ndarray) -> Position:
    """Return the `Position` of joints in mm and degrees, whether or not they are inside travel.

    Examples
    --------
    >>> from mathpost import load_machine
    >>> found = at(Kinematics(load_machine("bc_table")), [0, 0, 0, 200, 90])
    >>> found.axis.round(6) + 0.0, found.reasons
    (array([ 0.      , -0.34202 , -0.939693]), ('B 200.000° is outside -35 … 110',))
    """
    joints = as_array(joints, len(kinematics.symbols), "joints")
    tip, axis = kinematics.forward(joints, degrees=True)
    pole = np.array(kinematics.inverse_symbolic.pole, dtype=float)
    between = np.degrees(np.arctan2(np.linalg.norm(np.cross(pole, axis)), pole @ axis))
    radians = np.r_[joints[:3], np.deg2rad(joints[3:])]
    return Position(joints, tip, axis, float(between), tuple(kinematics.machine.out_of_travel(radians)))


def positions(
    kinematics: Kinematics, tip: np.ndarray, axis: np.ndarray, present: ArrayLike | None = None
) -> list[Position]:
    """Return every `Position` that puts the tip at `tip` and the tool along `axis`, those inside travel first.

    Both branches, in all windings inside travel; the positions nearest to the rotary angles `present`, degrees, by
    default 0, come first. At the pole the workpiece-side axis stays where it is. A branch outside travel is given
    once, with the reason. `ReachError` if no position makes the tool axis.

    Examples
    --------
    >>> from mathpost import load_machine
    >>> for found in positions(Kinematics(load_machine("bc_table")), [0, 0, 0], [1, 1, 1]):
    ...     print(found.joints.round(3) + 0.0, found.reasons)
    [-97.98    0.    -50.718  54.736  45.   ] ()
    [  97.98     0.     -50.718  -54.736 -135.   ] ('B -54.736° is outside -35 … 110',)
    """
    rotary = kinematics.machine.rotary
    present = np.zeros(len(rotary)) if present is None else as_array(present, len(rotary), "present")
    alignment = positioning.align(_feature(tip, axis), kinematics)
    found = []
    for angles in alignment.positions:
        if alignment.free:
            angles = np.where(np.arange(len(rotary)) == alignment.workpiece_side, present, angles)
        choices = [windings(joint, angle, now) for joint, angle, now in zip(rotary, angles, present, strict=True)]
        grid = np.meshgrid(*choices, indexing="ij")
        found += [angles for angles in np.stack(grid, axis=-1).reshape(-1, len(rotary))]
    apart: list[np.ndarray] = []
    for angles in sorted(found, key=lambda angles: (np.abs(angles - present).round(6)).sum()):
        if not any(np.abs(angles - other).max() < np.degrees(SAME) for other in apart):
            apart.append(angles)
    joints = kinematics.close(tip, np.deg2rad(apart))
    listed = [at(kinematics, row) for row in np.c_[joints[:, :3], apart]]
    return sorted(listed, key=lambda position: len(position.reasons))


def windings(joint: Rotary, angle: float, present: float = 0.0) -> list[float]:
    """Return `angle` plus whole turns, every result inside travel, degrees, the nearest to `present` first.

    At most `MOST_TURNS` to either side; the angle alone if travel has no end, or if nothing is inside it.

    Examples
    --------
    >>> from mathpost import load_machine
    >>> c = load_machine("ac_head").rotary[0]  # C, from -360 to 360
    >>> windings(c, 90), windings(c, 90, -300), windings(load_machine("ac_table").rotary[1], 90)
    ([90.0, -270.0], [-270.0, 90.0], [90.0])
    """
    nearest = joint.nearest_turn(angle, present)
    if np.isnan(nearest) or np.isinf(joint.limits).all():
        return [float(angle)]
    turns = [nearest + 360 * turn for turn in range(-MOST_TURNS, MOST_TURNS + 1)]
    inside = [each for each in turns if joint.nearest_turn(each, each) == each]
    return sorted(inside, key=lambda each: abs(each - present))


def taken(kinematics: Kinematics, axis: np.ndarray, present: ArrayLike | None = None) -> dict[str, Taken]:
    """Return the angles that each control takes for a tool axis, from the rotary angles `present`, by default 0.

    Examples
    --------
    >>> from mathpost import load_machine
    >>> found = taken(Kinematics(load_machine("ac_table")), [0.6, 0, 0.8], [0, -80])
    >>> found["Heidenhain PLANE"]
    Taken(angles=array([-36.86989765, -90.        ]), why='shortest path')
    """
    present = np.zeros(len(kinematics.machine.rotary)) if present is None else present
    alignment, found = positioning.align(_feature((0, 0, 0), axis), kinematics), {}
    for name, choose in CONTROLS.items():
        try:
            solution = choose(alignment, present)
            found[name] = Taken(solution.angles, solution.why)
        except ReachError as error:
            found[name] = Taken(None, str(error))
    return found


def as_data(kinematics: Kinematics, found: dict[str, Taken]) -> dict[str, dict[str, Any]]:
    """Return the result of `taken` as plain data, for JSON."""
    names = kinematics.machine.joint_names[3:]

    def angles(each: Taken) -> dict[str, float] | None:
        return None if each.angles is None else dict(zip(names, each.angles.tolist(), strict=True))

    return {control: {"angles": angles(each), "why": each.why} for control, each in found.items()}


def _feature(tip: ArrayLike, axis: ArrayLike) -> Frame:
    """A feature with its Z along the tool axis; its X is arbitrary."""
    z = unit(as_array(axis, 3, "axis"))
    return Frame.from_axes(z, np.eye(3)[np.abs(z).argmin()], tip, "WCS", "feature")
