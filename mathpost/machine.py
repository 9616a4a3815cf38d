"""A machine as data: one or two rotary joints, offsets, limits and rates. Lengths are mm, angles radians.

`machine_file` reads one from a TOML file.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from mathpost.errors import InputError, as_array

LETTERS = ("X", "Y", "Z")
ENDLESS = (-math.inf, math.inf)
MM_PER_INCH = 25.4
TRAVEL_TOLERANCE = 1e-9  # mm and radians, by which a joint may be beyond an end of its travel
UNITS = np.array([1, 1, 1, np.degrees(1), np.degrees(1)])  # of each joint: from mm and radians to mm and degrees


@dataclass(frozen=True)
class Rotary:
    """A rotary joint: the carried body turns right-handed about `axis` by the programmed angle.

    `axis` and `point`, mm, are in machine coordinates on the workpiece side, and count from the spindle nose on the
    tool side.
    """

    name: str  # the address of its NC word, such as "B"
    carries: str  # "workpiece" or "tool"
    axis: tuple[float, ...]  # direction at rotary zero as the file gives it, not yet of unit length
    point: tuple[float, ...]  # any point on the axis
    limits: tuple[float, ...] = ENDLESS  # travel, radians
    max_rate: float | None = None  # radians per second
    max_acceleration: float | None = None  # radians per second squared
    clamp: tuple[str, ...] = ()  # words of a program that clamp the axis, and that release it

    def nearest_turn(self, angle: float, present: float = 0.0) -> float:
        """Return `angle` plus the whole turns that bring it nearest to `present` within travel, or NaN; degrees.

        Examples
        --------
        >>> from mathpost import load_machine
        >>> c = load_machine("ac_head").rotary[0]  # C, from -360 to 360
        >>> c.nearest_turn(90, 350), c.nearest_turn(10, 350), c.nearest_turn(-20, 300)
        (90.0, 10.0, 340.0)
        """
        ends = np.degrees(_widened(self.limits))
        low, high = np.ceil((ends[0] - angle) / 360), np.floor((ends[1] - angle) / 360)
        return float(angle + 360 * np.clip(np.round((present - angle) / 360), low, high)) if low <= high else np.nan


@dataclass(frozen=True)
class Linear:
    """Travel (mm), greatest rate (mm/s) and acceleration (mm/s²) of a linear axis, and what its slide carries.

    `carries` matters to drawings and errors only: NC words move the tool in the workpiece, whichever part moves.
    """

    name: str
    limits: tuple[float, ...] = ENDLESS
    max_rate: float | None = None
    max_acceleration: float | None = None
    carries: str = "tool"


@dataclass(frozen=True)
class Solid:
    """A box between two corners or, with a radius, a cylinder about a line; mm, in the workpiece, from `origin`."""

    start: tuple[float, ...]
    end: tuple[float, ...]
    radius: float | None = None


@dataclass(frozen=True)
class Machine:
    """A machine with three linear and one or two rotary axes; joints are ordered X, Y, Z, then `rotary`."""

    name: str
    source: str
    rotary: tuple[Rotary, ...]  # the workpiece side from the bed outwards, then the tool side from the bed outwards
    linear: tuple[Linear, ...]  # X, Y, Z
    # The workpiece's origin, in machine coordinates at rotary zero, mm; programmed X Y Z count from it:
    origin: tuple[float, ...]
    tool_axis: tuple[float, ...]  # from the tip towards the spindle, at rotary zero; not yet of unit length
    tool_length: float  # spindle nose to tip, mm
    # The point of the head, at rotary zero, that X Y Z name: "tip", "nose" or mm from the nose:
    programmed_point: str | tuple[float, ...]
    # Along which the control adds the tool's length where words name the tip; None: along the tool axis. It is
    # another direction if the spindle leans and the control does not know it.
    length_axis: tuple[float, ...] | None = None
    # What the limits of X Y Z refer to: "slides", in machine coordinates (the position of a slide is its programmed
    # value, its word, plus the origin, plus the tool where the words name the tip), or "words".
    limits_of: str = "slides"
    slide_order: tuple[str, ...] = ("X", "Y", "Z")  # from the bed outwards, on either side: for drawings and errors
    # Lines of a program, in the words of its control: before and after the moves, and instead of the control's own
    # tool call. {name} in them is the name of the program, {tool} the number of the tool,
    # {offset} that of its length offset.
    program_head: tuple[str, ...] = ()
    program_foot: tuple[str, ...] = ()
    tool_change: tuple[str, ...] = ()
    skip: tuple[str, ...] = ()  # words of the machine's maker that move no axis, {} for a number in them
    # Where rotary axes may turn freely, X Y Z as in `limits_of`, None for one that may be anywhere; or not known.
    safe: tuple[float | None, float | None, float] | None = None
    # Where the reference point is, by names of axes, machine coordinates in mm, and degrees; or not known.
    home: tuple[tuple[str, float], ...] = ()
    # Work offsets of the control, numbered from 1: the one that has `origin`, if stated, and others with theirs.
    offset: int | None = None
    offsets: tuple[tuple[int, tuple[float, float, float]], ...] = ()
    # What the tool must not meet: stock that is not cut yet in rapid traverse, the fixture ever; if they are named.
    stock: tuple[Solid, ...] = ()
    fixture: tuple[Solid, ...] = ()

    @property
    def complete(self) -> bool:
        """Whether its programs are more than motion: the file gives them a head or a foot."""
        return bool(self.program_head or self.program_foot)

    @property
    def every_joint(self) -> tuple[Linear | Rotary, ...]:
        """The joints, in joint order."""
        return (*self.linear, *self.rotary)

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the joints, in joint order."""
        return tuple(joint.name for joint in self.every_joint)

    def slides_that_carry(self, side: str) -> tuple[str, ...]:
        """Return the names of the slides on the side of ``"workpiece"`` or ``"tool"``, from the bed outwards."""
        sides = {joint.name: joint.carries for joint in self.linear}
        return tuple(name for name in self.slide_order if sides[name] == side)

    @property
    def slides(self) -> np.ndarray:
        """The positions of the slides X Y Z when their words are 0, mm, shape (3,); see `limits_of`."""
        return np.zeros(3) if self.limits_of == "words" else self.slide_positions(np.zeros(3))

    def slide_positions(self, words: ArrayLike, tool_length: ArrayLike | None = None) -> np.ndarray:
        """Return the machine coordinates of the slides, mm, shape (..., 3), at words X Y Z, shape (..., 3).

        They are what the encoders count, and what a control shows in machine coordinates while no tool length is
        active (G53, M91, SUPA). The same tip needs other positions with a longer tool: where the words name the
        tip, the control adds `tool_length`, mm, shape (...), by default that of the machine.
        """
        length = self.tool_length if tool_length is None else tool_length
        axis = np.array(self.length_axis or self.tool_axis)
        axis = axis / np.linalg.norm(axis)
        return np.asarray(words) + self.origin + (self.programmed_point == "tip") * np.multiply.outer(length, axis)

    @property
    def limits(self) -> np.ndarray:
        """Travel of the k joints as words, shape (k, 2): mm and radians."""
        limits = np.array([joint.limits for joint in self.every_joint])
        limits[:3] -= self.slides[:, None]
        return limits

    @property
    def ends(self) -> np.ndarray:
        """`limits`, widened by the rounding error that a joint may exceed them by."""
        return _widened(self.limits)

    @property
    def endless(self) -> np.ndarray:
        """Whether each of the k joints is a rotary axis without an end of travel, shape (k,)."""
        return ~np.isfinite(self.limits).all(axis=1) & (np.arange(len(self.joint_names)) > 2)

    def within(self, joints: ArrayLike) -> np.ndarray:
        """Return whether each of the joints, shape (..., k) in mm and radians, is inside travel; NaN is not."""
        low, high = self.ends.T
        return (low <= joints) & (joints <= high)

    def out_of_travel(self, joints: ArrayLike) -> list[str]:
        """Return a sentence for each of the joints, shape (k,) in mm and radians, that is outside travel."""
        moved = np.r_[self.slides, np.zeros(len(self.rotary))]  # where the slides are
        values, (low, high) = (joints + moved) * self.units, (self.limits.T + moved) * self.units
        units, inside = [" mm"] * 3 + ["°"] * len(self.rotary), self.within(joints)
        return [
            f"{'slide ' * bool(moved[n])}{name} {values[n]:.3f}{units[n]} is outside {low[n]:g} … {high[n]:g}"
            for n, name in enumerate(self.joint_names)
            if not inside[n]
        ]

    @property
    def max_rates(self) -> np.ndarray:
        """Greatest rates of the k joints, shape (k,): mm/s and rad/s, NaN where not stated."""
        return np.array([joint.max_rate for joint in self.every_joint], dtype=float)

    @property
    def max_accelerations(self) -> np.ndarray:
        """Greatest accelerations of the k joints, shape (k,): mm/s² and rad/s², NaN where not stated."""
        return np.array([joint.max_acceleration for joint in self.every_joint], dtype=float)

    @property
    def arrangement(self) -> str:
        """``"table-table"``, ``"head-table"`` or ``"head-head"``; of one rotary axis ``"table"`` or ``"head"``."""
        heads = sum(rotary.carries == "tool" for rotary in self.rotary)
        return "-".join(["head"] * heads + ["table"] * (len(self.rotary) - heads))

    @property
    def units(self) -> np.ndarray:
        """Factors of the joints from mm and radians to mm and degrees, shape (k,)."""
        return UNITS[: len(self.joint_names)]

    def with_setup(self, *, origin: ArrayLike | None = None, tool_length: float | None = None) -> Machine:
        """Return the machine with a different workpiece origin (mm) or tool length (mm); `InputError` if wrong."""
        changes: dict[str, Any] = {}
        if origin is not None:
            changes["origin"] = tuple(as_array(origin, 3, "origin").tolist())
        if tool_length is not None:
            if not (np.isfinite(tool_length) and tool_length >= 0):
                raise InputError("tool length", "mm, not negative", f"{tool_length}")
            changes["tool_length"] = float(tool_length)
        return replace(self, **changes)


def _widened(limits: ArrayLike) -> np.ndarray:
    return np.add(limits, (-TRAVEL_TOLERANCE, TRAVEL_TOLERANCE))
