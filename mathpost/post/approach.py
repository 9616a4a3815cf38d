"""Ways between the part and the safe position: approach, retract, unwinding, and on to another work offset."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mathpost.controls.blocks import Blocks
from mathpost.errors import InputError
from mathpost.machine import Machine
from mathpost.path.modal import Command
from mathpost.post.motion import LIFTED, ON_PART, SAFE, Motion
from mathpost.post.options import Options
from mathpost.sources.yu_dan import lifted

if TYPE_CHECKING:
    from mathpost.post.selection import Selection
    from mathpost.post.steps import Plan, ToolPath


def approaches(machine: Machine, options: Options) -> bool:
    """Whether a program comes from the safe position and goes back: it has a head or a foot, and they are known."""
    has_frame = bool(machine.program_head or machine.program_foot)
    return machine.safe is not None and has_frame and bool(options.control.commands["safe"])


def approached(path: ToolPath, motion: Motion, clearance: float) -> Motion:
    """Put the way from the safe position before a motion, and the way back behind it."""
    over = above(path, motion.joints[[0, -1]], clearance)
    far = [safe_pose(path.kin.machine, pose) for pose in over]
    first, last = motion.place[[0, -1]]
    before = Motion(np.array([far[0], over[0]]), np.array([first, first]), np.array([SAFE, LIFTED]))
    behind = Motion(np.array([over[1], far[1]]), np.array([last, last]), np.array([LIFTED, SAFE]))
    return Motion.joined([before, motion, behind])


def from_safe(path: ToolPath, motion: Motion, free: np.ndarray, before: Plan) -> tuple[Motion, np.ndarray]:
    """Put the way from the safe position of the plan before in front: there the rotary axes turn first."""
    standing = counted_from(path, before, before.moves.motion.joints[-1])
    turned = np.r_[standing[:3], motion.joints[0, 3:]]
    first = Motion(np.array([standing, turned]), motion.place[[0, 0]], np.array([SAFE, SAFE]))
    return Motion.joined([first, motion]), np.r_[free[[0, 0]], free]


def counted_from(path: ToolPath, before: Plan, joints: np.ndarray) -> np.ndarray:
    """Return joints, shape (5,), of a plan counted from the origin of another path."""
    moved = np.array(joints)
    moved[:3] += before.path.shift - path.shift
    return moved


def approach_command(path: ToolPath, blocks: Blocks, safe: tuple[float | None, float | None, float]) -> Command:
    """The command to go to the safe Z, and to turn the rotary axes there, before the first move."""
    names, angles = path.kin.machine.joint_names[3:], blocks.words[0, 3:].tolist()
    return Command("approach", (safe[2], dict(zip(names, angles, strict=True))), "")


def unwound(path: ToolPath, chosen: Selection, record: int, clearance: float) -> Motion:
    """Lead the joints from one record to the next by the safe position, where the rotary axes unwind.

    The tool leaves along its axis, then Z and, where the machine file states them, X and Y go to the safe position;
    the rotary axes turn, and it comes back in the opposite order. `InputError` is raised if the machine file has no
    safe position: beside the part a whole turn would take the tool through it.
    """
    safe = path.kin.machine.safe
    if safe is None:
        expected = "safe = { Z = … } in [linear] of the machine file: where the rotary axes may turn freely"
        raise InputError(f"{path.cl.where(record)}: to unwind", expected, "none")
    before, after = chosen.joints[record - 1 : record + 1]
    over = above(path, np.array([before, after]), clearance)
    far = [safe_pose(path.kin.machine, pose) for pose in over]
    turned = np.r_[far[0][:3], far[1][3:]]
    joints = np.array([before, over[0], far[0], turned, far[1], over[1], after])
    place = record - 1 + np.array([0.0, 0, 0, 1, 1, 1, 1])
    return Motion(joints, place, np.array([ON_PART, LIFTED, SAFE, SAFE, SAFE, LIFTED, ON_PART]))


def above(path: ToolPath, joints: np.ndarray, clearance: float) -> np.ndarray:
    """Lift joints, shape (n, 5), along the tool axis until every point of the path lies `clearance` below the tip.

    From there the tool may go on in any direction that does not lead back.
    """
    tips, axes = path.kin.forward(joints)
    height = [max(0.0, np.max((path.cl.points - tip) @ axis)) for tip, axis in zip(tips, axes, strict=True)]
    return lifted(path.kin, joints, np.array(height)[:, None] + clearance)


def safe_pose(machine: Machine, joints: np.ndarray) -> np.ndarray:
    """Return joints, shape (5,), with Z, and X and Y where the machine file states them, at the safe position."""
    there = np.array(joints)
    for axis, position in enumerate(machine.safe or ()):
        if position is not None:
            there[axis] = position - machine.slides[axis]
    return there
