"""A machine read from a TOML file, key by key; `data/machines/dmu50v.toml` uses every key and says what it means.

Lengths are mm there and in a `Machine`; angles are degrees in the file and radians in the object.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from mathpost.errors import InputError
from mathpost.files import TomlTable, a_number, data_file, each, numbers, one_of, only_if, read_toml, some_text
from mathpost.machine import ENDLESS, LETTERS, Linear, Machine, Rotary, Solid

# Fields of `Machine`, and their keys of [program].
PROGRAM = {"program_head": "head", "program_foot": "foot", "tool_change": "tool_change"}
AnyJoint = TypeVar("AnyJoint", Rotary, Linear)


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


def _joint(table: TomlTable, kind: type[AnyJoint], name: str, unit: str, *default: str, **more: Any) -> AnyJoint:
    """Read a joint of either kind, given in `unit`; `default` is that of its key `carries`."""
    scale = math.radians if unit == "degrees" else float

    def rate(key: str, expected: str) -> float | None:
        found = table.take(key, only_if(lambda x: x > 0, a_number), f"{expected} above 0", None)
        return found and scale(found)

    joint = kind(
        name=name,
        carries=table.take("carries", *one_of("workpiece", "tool"), *default),
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
