"""Ways between the part and the safe position: approach, retract, unwinding, and on to another work offset."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mathpost.errors import InputError
from mathpost.machine import Machine
from mathpost.path.modal import Command
from mathpost.path.motion import LIFTED, ON_PART, SAFE, Motion
from mathpost.shop.controls.blocks import Blocks
from mathpost.shop.post.options import Options
from mathpost.sources.yu_dan import lifted

if TYPE_CHECKING:
    from mathpost.path.selection import Selection
    from mathpost.shop.post.steps import Plan
    from mathpost.shop.post.tool_path import ToolPath


def approaches(machine: Machine, options: Options) -> bool:
    """Whether a program comes from the safe position and goes back: it has a head or a foot, and they are known."""
    return machine.safe is not None and machine.complete and bool(options.control.commands["safe"])


def approached(path: ToolPath, motion: Motion, clearance: float) -> Motion:
    """Put the way from the safe position before a motion, and the way back behind it; at last the axes go to 0."""
    to_part, from_part = above(path, motion.joints[[0, -1]], clearance)
    machine, kinds = path.kin.machine, np.array([LIFTED, SAFE, SAFE])
    first, last = motion.place[[0, -1]]
    before = Motion(away(machine, to_part)[::-1], np.full(3, first), kinds[::-1])
    behind = Motion(away(machine, from_part), np.full(3, last), kinds)
    zeros = homeward(machine, behind.joints[-1]) if path.last else behind.joints[:0]
    home = Motion(zeros, np.full(len(zeros), last), np.full(len(zeros), SAFE))
    return Motion.joined([before, motion, behind, home])


def homeward(machine: Machine, joints: np.ndarray) -> np.ndarray:
    """Return joints, shape (k, 5), in which one rotary axis after the other goes to 0, if that is within travel.

    Or to the whole turn nearest to where it is. Of one axis alone there is one way, on every control.
    """
    found = np.array([joints] * len(machine.rotary))
    for number, joint in enumerate(machine.rotary, 3):
        angle = joint.nearest_turn(0.0, np.degrees(joints[number]))
        found[number - 3 :, number] = joints[number] if np.isnan(angle) else np.radians(angle)
    return found


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
    off, onto = (away(path.kin.machine, over) for over in above(path, np.array([before, after]), clearance))
    turned = np.r_[off[-1][:3], onto[-1][3:]]
    joints = np.array([before, *off, turned, *onto[::-1], after])
    place = record - 1 + np.repeat([0.0, 1.0], [4, 5])
    half = [ON_PART, LIFTED, SAFE, SAFE]
    return Motion(joints, place, np.array([*half, SAFE, *half[::-1]]))


def above(path: ToolPath, joints: np.ndarray, clearance: float) -> np.ndarray:
    """Lift joints, shape (n, 5), along the tool axis until all of the path, stock and fixture is `clearance` below.

    From there the tool may go on in any direction that does not lead back.
    """
    tips, axes = path.kin.forward(joints)
    points = np.concatenate([path.cl.points, path.touched.ends])  # those of all tools
    height = [max(0.0, np.max((points - tip) @ axis)) for tip, axis in zip(tips, axes, strict=True)]
    return lifted(path.kin, joints, np.array(height)[:, None] + clearance)


def away(machine: Machine, joints: np.ndarray) -> np.ndarray:
    """Return joints, shape (5,), then with Z at the safe position, then with X and Y if the file states them."""
    stated = [(axis, position) for axis, position in enumerate(machine.safe or ()) if position is not None]
    way = np.array([joints] * 3)
    for axis, position in stated:
        way[1 if axis == 2 else 2 :, axis] = position - machine.slides[axis]
    return way
