"""The parts of a path: what each tool runs, at its work offset, and the machine with it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from mathpost.errors import InputError
from mathpost.kinematics import Kinematics
from mathpost.machine import Machine
from mathpost.path.cl import OPPOSITE, CLData, commands
from mathpost.path.motion import Motion
from mathpost.path.nc_words import written
from mathpost.rotation import unit
from mathpost.shop.post.clear import Ways
from mathpost.shop.post.cuts import NOTHING, Cuts, touched
from mathpost.shop.post.options import Options


@dataclass(frozen=True)
class ToolPath:
    """The part of the CL data that one tool runs, and the machine with it; records count from 0 within it."""

    kin: Kinematics
    cl: CLData
    first: int  # how many records of the whole path come before
    last: bool = False  # whether it is the last part of the path
    offset: int | None = None  # number of the work offset that its points count from, if one is stated
    # Shape (3,), mm, from the origin of the first part of the path to that of this one.
    shift: np.ndarray = field(default_factory=lambda: np.zeros(3))
    cuts: Cuts = NOTHING  # what is around the tools of all parts, counted from the origin of the first part

    @cached_property
    def touched(self) -> Cuts:
        """The same, counted from the origin of this part."""
        return self.cuts.moved(-self.shift) if self.shift.any() else self.cuts

    def ways(self, joints: np.ndarray, motion: Motion, straight: np.ndarray, tcp: np.ndarray) -> Ways:
        """Return how the moves of a motion go; `joints` as rounded in words, the others as in `Ways`."""
        rows = np.arange(len(joints))
        on_part = np.append(np.flatnonzero(~motion.lifted), -1)
        onto = on_part[np.searchsorted(on_part[:-1], rows)]  # behind a lifted way
        cuts = np.append(motion.at_feed(self.cl), False)
        onto = np.where(np.append(False, motion.in_cut) & ~cuts, -1, onto)
        lifted, cutting = np.append(True, ~motion.in_cut), np.append(False, motion.at_feed(self.cl))
        return Ways(joints, self.first + motion.place, straight, tcp, onto, lifted, cutting)


def tool_paths(cl: CLData, machine: Machine) -> list[ToolPath]:
    """Return the parts of the path between changes of the tool or work offset, with the machine that each has.

    `InputError` is raised where the tool axis turns over in cut, as no great circle is shorter than another there,
    and for a work offset whose origin the machine file does not have.
    """
    paths: list[ToolPath] = []
    for part, length, stated in cl.by_setup():
        turned = np.flatnonzero(np.linalg.norm(part.axes[1:] + part.axes[:-1], axis=1) < OPPOSITE)
        if turned.size:
            expected = "a tool axis not opposite to the one before, or RAPID"
            raise InputError(part.where(turned[0] + 1), expected, "a turn by 180°")
        offset = machine.offset if stated is None else stated
        known = dict(machine.offsets)
        named = paths[0].offset if paths and machine.offset is None else machine.offset or offset
        if offset not in known and offset != named:
            expected = f"its origin, offsets = {{ {offset} = [X, Y, Z] }} in [workpiece] of the machine file"
            raise InputError(f"{part.where(0)}: work offset {offset}", expected, "none")
        origin = machine.origin if offset is None else known.get(offset, machine.origin)
        with_setup = machine.with_setup(origin=origin, tool_length=length)
        shift = np.subtract(origin, paths[0].kin.machine.origin) if paths else np.zeros(3)
        first = part.first - cl.first
        last = first + len(part) == len(cl)
        paths.append(ToolPath(Kinematics(with_setup), part, first, last, offset, shift))
    solids = np.subtract(machine.origin, paths[0].kin.machine.origin)
    cuts = touched([(path.cl, path.shift) for path in paths], machine, solids)
    return [replace(path, cuts=cuts) for path in paths]


def what_the_control_holds(path: ToolPath, options: Options, planes: bool = False) -> list[str]:
    """Return comments for the head of a program: what it rests on that its moves do not say.

    With TCP, or in tilted `planes`, the control moves X Y Z by its own numbers of the rotary axes and of the tool.
    Without them a head that tilts puts the length of the tool into the words.
    """
    machine, lines = path.kin.machine, []
    if options.tcp or planes:
        for joint in machine.rotary:
            frame = "SPINDLE NOSE" if joint.carries == "tool" else "MACHINE ZERO"
            along = " ".join(f"{value:.6g}" for value in unit(np.array(joint.axis)))
            lines.append(f"CONTROL HOLDS: {joint.name} THROUGH {xyz(joint.point)} FROM {frame}, ALONG {along}")
        if path.offset is None:
            lines.append(f"CONTROL HOLDS: WORK OFFSET {xyz(machine.origin)}")
    if path.offset is not None:
        lines.append(f"CONTROL HOLDS: WORK OFFSET {path.offset}, {xyz(machine.origin)}")
    if options.tcp or planes or any(joint.carries == "tool" for joint in machine.rotary):
        tools = [tool.values[0] for record, tool in commands(path.cl.remarks, "tool") if record == 0]
        name = f"TOOL {tools[0]}" if tools else "TOOL"
        in_table = options.tcp or machine.programmed_point == "tip"
        held = options.control.tool_length if in_table else "IN THE WORDS, 0 IN THE TOOL TABLE"
        lines.append(f"{name}: {machine.tool_length:g} MM FROM NOSE TO TIP, {held}")
    return lines


def xyz(point: Sequence[float]) -> str:
    """Return a point as words, such as X0 Y-5.5 Z20."""
    return written(dict(zip("XYZ", point, strict=True)))
