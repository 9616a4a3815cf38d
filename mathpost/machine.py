"""A machine as data: one or two rotary joints, offsets, limits and rates, read from a TOML file.

The file is described by `data/machines/dmu50v.toml`, which uses every key. Lengths are mm there and here;
angles are degrees in the file and radians in the objects.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from mathpost.errors import InputError, as_array
from mathpost.files import data_file
from mathpost.toml_table import TomlTable, a_number, each, numbers, one_of, only_if, read_toml, some_text

PROGRAM = {"program_head": "head", "program_foot": "foot", "tool_change": "tool_change"}  # keys of [program]
LETTERS = ("X", "Y", "Z")
ENDLESS = (-math.inf, math.inf)
TRAVEL_TOLERANCE = 1e-9  # mm and radians, by which a joint may be beyond an end of its travel
UNITS = np.array([1, 1, 1, np.degrees(1), np.degrees(1)])  # mm and degrees of one mm or radian of each joint


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
        >>> c = load("ac_head").rotary[0]  # C, from -360 to 360
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


AnyJoint = TypeVar("AnyJoint", Rotary, Linear)


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
    # What the limits of X Y Z refer to: "slides", in machine coordinates (the position of a slide is its word, plus
    # the origin, plus the tool where the word names the tip), or "words".
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
        """mm and degrees of one mm or radian of each joint, shape (k,)."""
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


def load(path: Path | str) -> Machine:
    """Read a `Machine` from the TOML file `path`, or by the name of one that comes with the package.

    `InputError` is raised if there is no such machine, or the file cannot be read, is not TOML, lacks a key, has
    one too many, or holds a value that no such machine can have: no rotary axis or more than two, parallel axes, a
    tool-side axis along the tool.

    Examples
    --------
    >>> machine = load("dmu50v")
    >>> machine.joint_names, machine.arrangement
    (('X', 'Y', 'Z', 'B', 'C'), 'table-table')
    """
    path = find(path)
    return from_dict(read_toml(path), str(path))


def find(path: Path | str) -> Path | str:
    """Return `path`, or the file of the machine of that name that comes with the package."""
    shipped = {file.stem: file for file in sorted(data_file("machines").glob("*.toml"))}
    if not Path(path).suffix and not Path(path).exists() and str(path) not in shipped:
        raise InputError(str(path), f"a TOML file, or one of {', '.join(shipped)}", "neither")
    return path if Path(path).exists() else shipped.get(str(path), path)


def from_dict(content: dict[str, Any], where: str = "machine") -> Machine:
    """Build a machine from the content of a TOML file; `where` begins every error message."""
    file = TomlTable(content, where)
    rotary = file.take("rotary", each(dict), "one or two [[rotary]] tables")
    if len(rotary) not in (1, 2):
        raise InputError(f"{where}, [[rotary]]", "one or two rotary axes", f"{len(rotary)}")
    workpiece, tool = file.table("workpiece"), file.table("tool")
    linear, program = file.table("linear", optional=True), file.table("program", optional=True)
    machine = Machine(
        name=file.take("name", some_text, "a name in quotes"),
        source=file.take("source", some_text, "a source in quotes"),
        rotary=tuple(_rotary(TomlTable(entry, f"{where}, rotary {n}")) for n, entry in enumerate(rotary, 1)),
        slide_order=tuple(dict.fromkeys([*(key for key in linear.content if key in LETTERS), *LETTERS])),
        linear=tuple(_joint(linear.table(name, optional=True), Linear, name, "mm", "tool") for name in LETTERS),
        origin=workpiece.take("origin", *VECTOR),
        offset=workpiece.take("offset", *OFFSET, None),
        offsets=_offsets(workpiece.table("offsets", optional=True)),
        stock=_solids(workpiece, "stock"),
        fixture=_solids(workpiece, "fixture"),
        tool_axis=tool.take("axis", *DIRECTION),
        tool_length=tool.take("length", only_if(lambda x: x >= 0, a_number), "a length in mm, not negative", 0.0),
        length_axis=tool.take("length_axis", *DIRECTION, None),
        programmed_point=tool.take("programmed_point", _point, '"tip", "nose" or [x, y, z] in mm', "tip"),
        limits_of=linear.take("limits_of", *one_of("slides", "words"), "slides"),
        safe=_safe(linear),
        home=_home(linear, [entry.get("name") for entry in rotary]),
        skip=tuple(program.take("skip", each(str), "a list of words", ())),
        **{name: tuple(program.take(key, each(str), "a list of lines", ())) for name, key in PROGRAM.items()},
    )
    for table in (file, workpiece, tool, linear, program):
        table.done()
    if machine.offset in dict(machine.offsets):
        key = f"{where}, [workpiece], key 'offsets'"
        raise InputError(key, f"others than offset = {machine.offset}", f"{machine.offset}")
    _check_arrangement(machine, where)
    return machine


def _safe(linear: TomlTable) -> tuple[float | None, float | None, float] | None:
    """X, Y and Z of the table ``safe``, of which Z must be there; None without it."""
    if "safe" not in linear.content:
        return None
    table = linear.table("safe")
    ends = [table.take(axis, a_number, "mm", *default) for axis, *default in (("X", None), ("Y", None), ("Z",))]
    table.done()
    return tuple(ends)


def _home(linear: TomlTable, rotary: Sequence[Any]) -> tuple[tuple[str, float], ...]:
    """The table ``home``: axes, all or some, and where they are at the reference point."""
    table = linear.table("home", optional=True)
    found = [
        (axis, table.take(axis, a_number, "mm or degrees")) for axis in (*LETTERS, *rotary) if axis in table.content
    ]
    table.done()
    return tuple(found)


def _offsets(table: TomlTable) -> tuple[tuple[int, tuple[float, float, float]], ...]:
    """Numbers of work offsets, the keys, and their origins."""
    found = []
    for key in list(table.content):
        if not (key.isdecimal() and int(key) > 0):
            raise InputError(f"{table.where}, key {key!r}", OFFSET[1], repr(key))
        found.append((int(key), table.take(key, *VECTOR)))
    return tuple(found)


def _solids(workpiece: TomlTable, key: str) -> tuple[Solid, ...]:
    """A list of boxes and cylinders."""
    found = []
    for n, entry in enumerate(workpiece.take(key, each(dict), "a list of { from = …, to = … }", ()), 1):
        table = TomlTable(entry, f"{workpiece.where}, {key} {n}")
        solid = Solid(table.take("from", *VECTOR), table.take("to", *VECTOR), table.take("radius", *RADIUS, None))
        table.done()
        apart = np.not_equal(solid.start, solid.end)
        if not (apart.all() if solid.radius is None else apart.any()):
            raise InputError(f"{table.where}, key 'to'", "a point that makes a solid with 'from'", str(solid.end))
        found.append(solid)
    return tuple(found)


def _rotary(table: TomlTable) -> Rotary:
    name = table.take("name", _address, "a word address such as A, B or C, not X, Y or Z")
    table.where += f" ({name})"
    axis, point = table.take("axis", *DIRECTION), table.take("point", *VECTOR)
    clamp = tuple(table.take("clamp", only_if(lambda two: len(two) == 2, each(str)), "two words", ()))
    return _joint(table, Rotary, name, "degrees", axis=axis, point=point, clamp=clamp)


def _joint(table: TomlTable, kind: type[AnyJoint], name: str, unit: str, *carries: str, **more: Any) -> AnyJoint:
    """Read a joint of either kind, given in `unit`; `carries` is the default of that key."""
    scale = math.radians if unit == "degrees" else float

    def rate(key: str, expected: str) -> float | None:
        found = table.take(key, only_if(lambda x: x > 0, a_number), f"{expected} above 0", None)
        return found and scale(found)

    joint = kind(
        name=name,
        carries=table.take("carries", *one_of("workpiece", "tool"), *carries),
        limits=tuple(map(scale, table.take("limits", _limits, f"[low, high] in {unit}", ENDLESS))),
        max_rate=rate("max_rate", f"a rate in {unit} per second"),
        max_acceleration=rate("max_acceleration", f"{unit} per second squared"),
        **more,
    )
    table.done()
    return joint


def _check_arrangement(machine: Machine, where: str) -> None:
    """Refuse a machine that cannot exist although every key is well formed."""
    if len(machine.rotary) == 1:
        return
    first, second = machine.rotary
    if first.name == second.name:
        raise InputError(f"{where}, rotary 2, name", "a name of its own", f"{second.name!r} twice")
    if (first.carries, second.carries) == ("tool", "workpiece"):
        raise InputError(f"{where}, [[rotary]]", "the workpiece side before the tool side", "the tool side first")
    if _parallel(first.axis, second.axis):
        raise InputError(f"{where}, rotary 2 ({second.name}), axis", "not parallel to the first", f"{second.axis}")
    # Seen from the tool, the first rotary axis must tilt the tool: turning the tool about itself moves nothing.
    tool_side = first if second.carries == "workpiece" else second
    if _parallel(tool_side.axis, machine.tool_axis):
        expected = f"not parallel to the tool axis, or {tool_side.name} cannot tilt the tool"
        raise InputError(f"{where}, rotary ({tool_side.name}), axis", expected, f"{tool_side.axis}")


def _parallel(first: Sequence[float], second: Sequence[float]) -> bool:
    a, b = (np.array(v) / np.linalg.norm(v) for v in (first, second))
    return bool(np.linalg.norm(np.cross(a, b)) < 1e-6)


_address = only_if(lambda value: re.fullmatch("[ABCUVW][0-9]?", value))
_limits = only_if(lambda ends: ends[0] < ends[1], numbers(2))
VECTOR = numbers(3), "[x, y, z] in mm"
RADIUS = only_if(lambda x: x > 0, a_number), "mm, above 0"
OFFSET = only_if(lambda value: type(value) is int and value > 0), "the number of a work offset, whole and from 1"
DIRECTION = only_if(lambda vector: np.linalg.norm(vector) > 1e-9, numbers(3)), "[x, y, z], not all zero"


def _point(value: Any) -> str | tuple[float, ...]:
    return value if value in ("tip", "nose") else numbers(3)(value)
