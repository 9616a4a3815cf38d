"""Where X Y Z of a program count from, and what they name: joints, or with TCP or on a tilted plane the tool tip.

`Coordinates` keeps the words that hold, and expresses them anew whenever a work offset, a shift, a plane or TCP is
switched. What is *resolved* counts from the machine file's workpiece origin: joints, or the tip in the workpiece.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from mathpost.errors import InputError
from mathpost.frame import Frame
from mathpost.kinematics import Kinematics
from mathpost.machine import Machine
from mathpost.rotation import unit
from mathpost.shop.plane import positioning
from mathpost.shop.plane.tilted_plane import Plane

# Rules by which a control turns its rotary axes to a plane, functions of `mathpost.shop.plane.positioning`.
POSITIONING = ("fanuc", "heidenhain", "siemens", "standing")


@dataclass
class Setup:
    """The contents of the control's tables, which the program does not state."""

    # Origins by the word that calls them, mm, as in G55.
    offsets: dict[str, tuple[float, ...]] = field(default_factory=dict)
    # Lengths by the number or name of the tool, mm; None: nobody asks for them, all tools are the machine file's.
    lengths: dict[str, float] | None = None
    # Or those of the tools, whatever their names, in the order of their changes, mm.
    in_order: tuple[float, ...] = ()
    start: dict[str, float] = field(default_factory=dict)  # words of axes before the first block, mm and degrees
    unit: str | None = None  # "mm" or "inch", of a program that does not state it; None: mm are assumed


class Coordinates:
    """The words X Y Z and of the rotary axes that hold, shape (j,), mm and degrees, NaN where nobody knows them."""

    def __init__(self, machine: Machine, setup: Setup) -> None:
        self.machine, self.setup = machine, setup
        self.words = np.full(len(machine.joint_names), np.nan)
        for axis, name in enumerate(machine.joint_names):
            self.words[axis] = setup.start.get(name, np.nan)
        self.tcp = False
        self.plane: Plane | None = None
        self.turned: Frame | None = None  # of a 3D rotation: the program in the workpiece, the rotary axes stay
        self.shift = np.zeros(3)  # of the datum
        self.inner = np.zeros(3)  # of the datum in the plane or the rotation, along its axes
        self.offset = np.zeros(3)  # of the work offset that is called, from the first one
        self.first_offset: str | None = None
        self.tools: list[str] = []
        # Joints X Y Z where words name the tip, the rotary axes are not known, and the slides are.
        self.standing = np.full(3, np.nan)

    @property
    def kin(self) -> Kinematics:
        """The machine with its present tool."""
        return Kinematics(self.machine)

    @property
    def on_tip(self) -> bool:
        """Whether X Y Z name the tool tip in the workpiece."""
        return self.tcp or self.plane is not None

    @property
    def frame(self) -> Frame | None:
        """The frame that X Y Z are in: that of the plane, or of a 3D rotation."""
        return self.turned if self.plane is None else self.plane.frame

    @property
    def as_they_are(self) -> bool:
        """Whether words are what they resolve to."""
        return self.frame is None and not self.shift.any() and not self.offset.any()

    def resolved(self, points: np.ndarray) -> np.ndarray:
        """Return X Y Z of a program, (..., 3), counted from the machine file's origin, as joints or tips."""
        placed = points if self.frame is None else _point(self.frame, points + self.inner)
        return placed + self.shift + self.offset

    def expressed(self, points: np.ndarray) -> np.ndarray:
        """The inverse of `resolved`."""
        placed = points - self.shift - self.offset
        return placed if self.frame is None else _point(self.frame.inverse(), placed) - self.inner

    def exchange(self, machine: Machine) -> None:
        """Change the tool or the origin of the machine: its slides stay where they are, its words change."""
        slides = self.joints() + self.machine.slides
        self.machine = machine
        self.stand(slides - machine.slides, self.words[3:])

    def change(self, **state: Any) -> None:
        """Switch TCP, a plane, a shift or a work offset: the machine does not move, its words change."""
        point, on_tip, joints = self.resolved(self.words[:3]), self.on_tip, self.joints()
        for name, value in state.items():
            setattr(self, name, value)
        if on_tip != self.on_tip:
            point = self._converted(joints, self.words[3:], to_tip=True) if self.on_tip else joints
        self.standing = joints
        self.words[:3] = self.expressed(point)

    def go(self, words: np.ndarray) -> None:
        """Take the words, (j,), of a place that the machine has gone to."""
        self.words, self.standing = words, np.full(3, np.nan)

    def lose(self, axes: Sequence[int]) -> None:
        """Some axes, by number, are where nobody knows; without TCP the others stay."""
        joints = self.joints()
        self.words[axes] = np.nan
        self.standing = np.full(3, np.nan)
        if self.on_tip and not self.tcp and min(axes) > 2:
            self.words[:3], self.standing = np.nan, joints

    def joints(self) -> np.ndarray:
        """Return X Y Z of the joints, shape (3,), NaN where they are not known."""
        point = self.resolved(self.words[:3])
        if not self.on_tip:
            return point
        found = self._converted(point, self.words[3:], to_tip=False)
        return self.standing if np.isnan(found).any() else found

    def stand(self, joints: np.ndarray, angles: np.ndarray) -> None:
        """Set the machine's position: joints X Y Z and rotary angles, degrees."""
        self.words[3:], self.standing = angles, joints
        point = self._converted(joints, angles, to_tip=True) if self.on_tip else joints
        self.words[:3] = self.expressed(point)

    def machine_position(self, named: dict[int, float]) -> np.ndarray:
        """Return joints and angles, (j,), with the slides of `named`, by axis, at machine coordinates, mm."""
        place = np.r_[self.joints(), self.words[3:]]
        for axis, value in named.items():
            place[axis] = value - self.machine.slides[axis] if axis < 3 else value
        return place

    def tool_axis(self) -> np.ndarray:
        """Return the tool axis, (3,), in the coordinates of words that name the tip; NaN where it is not known."""
        if np.isnan(self.words[3:]).any():
            return np.full(3, np.nan)
        axis = self.kin.forward(np.r_[np.zeros(3), self.words[3:]], degrees=True)[1]
        return axis if self.frame is None else self.frame.inverse().rotation @ axis

    def angles_for(self, plane: Plane, rule: str, **choice: Any) -> np.ndarray:
        """Return the rotary angles, degrees, that a control goes to for a plane, from the present angles.

        `rule` is one of `POSITIONING`; axes whose position is not known are taken to be at 0.
        """
        alignment, present = positioning.align(plane.frame, self.kin), np.nan_to_num(self.words[3:])
        choose: Callable = getattr(positioning, rule)
        return choose(alignment, present, **choice).angles

    def angles_along(self, axis: ArrayLike) -> np.ndarray:
        """Return the rotary angles, degrees, for a tool axis in the workpiece: the branch that is nearest."""
        kin, present = self.kin, np.nan_to_num(self.words[3:])
        frame = self.frame
        axis = unit(np.asarray(axis, dtype=float))
        both = kin.inverse(np.zeros(3), axis if frame is None else frame.rotation @ axis, degrees=True)[:, 3:]
        for angles in both:
            for n, joint in enumerate(kin.machine.rotary):
                angles[n] = joint.nearest_turn(angles[n], present[n])
        far = np.abs(both - present).max(axis=1)
        return both[int(np.nanargmin(far))] if np.isfinite(far).any() else np.full(2, np.nan)

    def call_offset(self, word: str, where: str) -> None:
        """Take a work offset by its word; the first one is the machine file's, unless it was stated."""
        known = self.setup.offsets
        if self.first_offset is None:
            self.first_offset = word
            self.exchange(self.machine.with_setup(origin=known.get(word)))
        if word != self.first_offset and word not in known:
            raise InputError(where, f"the origin of {word}: --origin {word}=X,Y,Z", "none")
        self.change(offset=np.subtract(known.get(word, self.machine.origin), self.machine.origin))

    def load_tool(self, name: str, where: str) -> None:
        """Take the length of a tool."""
        lengths, in_order = self.setup.lengths, self.setup.in_order
        if in_order and self.tools[-1:] != [name]:
            self.tools.append(name)
            self.exchange(self.machine.with_setup(tool_length=in_order[min(len(self.tools), len(in_order)) - 1]))
        if lengths is None:
            return
        if name in lengths:
            self.exchange(self.machine.with_setup(tool_length=lengths[name]))
        elif lengths or self.tools not in ([], [name]):
            raise InputError(where, f"the length of tool {name}: --tools FILE", "none")
        if name not in self.tools:
            self.tools.append(name)

    @property
    def assumed(self) -> tuple[str, ...]:
        """What was taken for granted, as sentences."""
        stated = self.setup.lengths
        if stated is None or not self.tools or self.tools[0] in stated:
            return ()
        return (f"tool {self.tools[0]} is {self.machine.tool_length:g} mm long, as the machine file has it",)

    def _converted(self, point: np.ndarray, angles: np.ndarray, *, to_tip: bool) -> np.ndarray:
        """A tip of joints, or joints of a tip; NaN where anything is not known."""
        if np.isnan(point).any() or np.isnan(angles).any():
            return np.full(3, np.nan)
        if to_tip:
            return self.kin.forward(np.r_[point, angles], degrees=True)[0]
        return self.kin.close(point, np.deg2rad(angles))[:3]


def _point(frame: Frame, points: np.ndarray) -> np.ndarray:
    """Points of a frame, (..., 3); those with a coordinate that is not known become NaN."""
    found = np.full(np.shape(points), np.nan)
    known = ~np.isnan(points).any(axis=-1)
    found[known] = frame.point(points[known])
    return found
