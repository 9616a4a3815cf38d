"""Readings of a dial, a probe, a ball, a ballbar, a laser: files, brought to one form whatever the method.

All but the laser see the same thing: the position of the tool relative to a point of the workpiece at which the
control, with the machine file's geometry, believes the tool to be. `Readings` say at which joints, for which point,
along which direction. A line ``# start = X Y Z`` says from where their positions count, if not from the machine's
zero. `template` prints a file for each method to fill in; the methods are in data/measurements/methods.toml.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from mathpost.errors import InputError
from mathpost.files import data_file, read_toml
from mathpost.rotation import unit
from mathpost.shop.compensate import instrument
from mathpost.shop.compensate.gauge import bar
from mathpost.shop.compensate.held import held, tips
from mathpost.shop.compensate.positioning import Positioning, positioning, stated_sigma
from mathpost.shop.measure import csv_table
from mathpost.shop.measure.angular_error import RUNS
from mathpost.shop.measure.fit import Value
from mathpost.shop.measure.rotary_axis import location_errors
from mathpost.shop.measure.vocabulary import measure

if TYPE_CHECKING:
    from mathpost.machine import Machine, Rotary
    from mathpost.shop.measure.csv_table import Table

LARGEST = 5  # mm: of a reading that is no position
SMALL = 1e-6  # of a direction: what it has of one square to it
REPEATED = 3  # rows that are the same to the last digit: so many, and a quarter of all, were copied

METHODS = {
    name: each for name, each in read_toml(data_file("measurements/methods.toml")).items() if "readings" in each
}
POSITIONING = ("laser", "autocollimator")
PROBED = ("probe", "centre")
BALLS = ("ball", "sensor", "ballbar")
CARRIES = {"dial": "workpiece", "tip": "tool"}  # what the axis carries that a method is about
SIGNS = {"dial": {"out": 1, "in": -1}, "tip": {"tip": 1, "block": -1}}


@dataclass(frozen=True)
class Readings:
    """The n readings of one file: the distance of the point `target` + ball from the tool along `direction`."""

    where: str
    method: str
    joints: np.ndarray  # as programmed, (n, 5); mm and radians throughout
    believed: np.ndarray  # where RTCP would have been, (n, 5): not the same where the slides were read
    reference: np.ndarray | None  # at which it was zeroed, (n, 5): what it would be there is to be subtracted
    target: np.ndarray  # in the workpiece, (n, 3)
    direction: np.ndarray  # along the machine's axes, (n, 3)
    length: np.ndarray  # of the tool from the spindle nose, (n,)
    value: np.ndarray  # the reading, (n,)
    setup: np.ndarray  # which ball, (n,): each lies a little elsewhere than its target
    zeroed: bool  # whether each has an unknown zero, too
    sigma: float  # standard deviation of a reading, NaN if the file does not say it
    order: np.ndarray  # when each was taken, from 0 to 1, (n,)
    rows: tuple  # where each is in the file: line and column
    freedom: float = np.inf  # its degrees of freedom
    notes: tuple = ()  # sentences on the file
    doubts: tuple = ()  # and on what is wrong with it

    def at(self, index: np.ndarray) -> Readings:
        """The readings at these places, shape (m,), of the n."""
        names = ("joints", "believed", "reference", "target", "direction", "length", "value", "setup", "order")
        arrays = {name: getattr(self, name) for name in names if getattr(self, name) is not None}
        rows = tuple(self.rows[n] for n in index.tolist())
        return replace(self, rows=rows, **{name: array[index] for name, array in arrays.items()})

    def same_poses(self, other: Readings) -> bool:
        """Whether other readings of the same rows were taken at the same joints, of the same points."""
        names = ("joints", "reference", "target", "direction")
        return all(np.array_equal(getattr(self, name), getattr(other, name)) for name in names)


Read = Readings | Positioning | dict[str, Value]  # what a file holds; the last is a test bar's


def template(method: str, machine: Machine) -> str:
    """Return a file to fill in, as text, with the names of the machine's own axes."""
    if method not in METHODS:
        raise InputError("method", f"one of {', '.join(METHODS)}", repr(method))
    settings = {"method": method, "unit": "arcsec" if method in POSITIONING else "mm"}
    if method in SIGNS:
        settings["positive"] = next(iter(SIGNS[method]))
    if method in (*CARRIES, *POSITIONING):
        names = {each.carries: each.name for each in machine.rotary}
        settings["axis"] = names.get(CARRIES.get(method, "workpiece"), machine.rotary[-1].name)
    if method == "ballbar":
        settings["centre"] = "0 0 50"
    comments = [f"# {line}" for line in METHODS[method]["words"].strip().splitlines()]
    comments += [f"# taken on trust: {line}" for line in METHODS[method]["trust"]]
    comments += [f"# {key} = {value}" for key, value in settings.items()]
    return "\n".join([*comments, _example(method, machine)])


def _example(method: str, machine: Machine) -> str:
    """The first lines of a file of `method`, with the names of the machine's axes."""
    tables = [each.name for each in machine.rotary if each.carries == "workpiece"]
    axes = ",".join(rotary.name for rotary in machine.rotary)
    return METHODS[method]["example"].replace("{axes}", axes).replace("{table}", (tables or [axes[-1]])[-1])


def read(path: Path | str, machine: Machine, **settings: Any) -> Read:
    """Read a file of any method as `Readings`, `Positioning` or, of a test bar, a dict of `Value`.

    `machine` is as the control believed it to be; `settings` are ``method``, ``unit``, ``axis`` and so on, where
    the file does not say them. What it leaves unclear is asked for by an `InputError` with the line.
    """
    return taken(read_table(path, machine, **settings), machine)


def read_table(path: Path | str, machine: Machine, **settings: Any) -> Table:
    """Read a file of any method as the table that it is, with its settings."""
    for key in set(settings) - set(csv_table.KNOWN):
        raise InputError(key, f"settings among {', '.join(csv_table.KNOWN)}", "none of them")
    lines = csv_table.scan(path)
    said = {key: str(value) for key, value in settings.items()} | lines.settings
    table = instrument.read(lines, machine)
    if table is not None:
        said |= table.settings
    method = said.get("method", "").casefold()
    if method not in METHODS:
        where = f"{path}, line {lines.lines[0][0]}" if lines.lines else str(path)
        found = repr(method) if method else "none"
        raise InputError(where, f"a line # method = one of {', '.join(METHODS)}", found)
    if table is None:
        table = csv_table.parse(lines, [], optional=_columns(method, machine), text=["face", "setup"])
        if "setup" in table:  # numbers or words, which ball it is
            table["setup"] = np.unique(table["setup"], return_inverse=True)[1].astype(float)
    table.settings = said | table.settings | {"method": method}
    return table


def taken(table: Table, machine: Machine) -> Read:
    """Return what a table of any method says, as `read` does. Units in the table are obeyed, in place."""
    method = table.settings["method"]
    if method == "bar":
        _obey_places(table, ("at",))
        return bar(table, machine)
    _obey_places(table, set(table) - {*METHODS[method]["readings"], *RUNS})
    _refuse_zeros(table, method)
    if method not in POSITIONING:
        return _readings(table, machine, method)
    runs = positioning(table, machine)
    # With one reading in a row, forth and back may well read the same.
    return replace(runs, doubts=(*runs.doubts, *_repeated(table))) if len(table) > 2 else runs


def _columns(method: str, machine: Machine) -> list[str]:
    """The columns that a file of `method` may have: its readings, what its template shows beside them, and more."""
    shown = _example(method, machine).split("\n")[0].split(",")
    axes = (*machine.joint_names, *RUNS) if method in POSITIONING else machine.joint_names[3:]
    more = ["angle", "length", "setup"] if method != "bar" else []
    return list(dict.fromkeys([*METHODS[method]["readings"], *shown, *more, *axes, "run"]))


def _obey_places(table: Table, names: Collection[str]) -> None:
    """Bring all columns but the readings to mm and degrees; in a file in inches each must say its own unit."""
    inches = measure(table.settings.get("unit", "")) == measure("in")
    for name in sorted(set(names) & set("xyzRL") | set(names) & {"length", "at"}):
        if inches and f"unit {name}" not in table.settings:
            table.refuse(
                f"the unit of {name!r}, too, behind its name: {name} (in) or {name} (mm)", "# unit = in alone"
            )
    table.obey_units(names)


def _refuse_zeros(table: Table, method: str) -> None:
    """Refuse a last row of nothing but zeros, and a feature found at zero far from where it was before."""
    names = [name for name in METHODS[method]["readings"] if name in table] if method in PROBED else list(table)
    cells = np.column_stack([np.asarray(table[name], dtype=float) for name in names])
    far = np.abs(cells).max() > LARGEST
    if len(cells) > 1 and not cells[-1].any() and (far if method in PROBED else len(names) > 2):
        where = f"{table.path}, line {table.lines[-1]}"
        raise InputError(where, "a reading (delete the row if it was not measured)", "a row of zeros")


def _readings(table: Table, machine: Machine, method: str) -> Readings:
    """Bring a table of `method` to `Readings`."""
    tool, count = unit(machine.tool_axis), len(table.lines)
    columns = [name for name in METHODS[method]["readings"] if name in table]
    if not columns:
        table.refuse(f"columns of readings: {', '.join(METHODS[method]['readings'])}")
    axis = _axis(table, machine, method)
    angles = _angles(table, machine, method, axis)
    length = table["length"] if "length" in table else np.full(count, machine.tool_length)
    if "L" in table:
        length = table["L"] - np.array(_needed(axis, table, machine).point) @ tool
    start = dict(zip("xyz", table.numbers("start", 3) if "start" in table.settings else np.zeros(3), strict=True))
    values = {}
    for name in columns:
        values[name] = table.unit(name, "length") * table[name] + (start[name] if method in PROBED else 0.0)
        if method not in PROBED:
            table.require(name, np.abs(values[name]) <= LARGEST, f"a reading within ±{LARGEST} mm (other units?)")

    target = np.zeros((count, 3))  # where the ball is believed to be, in the workpiece
    if method == "dial":  # where it looks at the ring with the axis at zero
        table.need("R", "a column R, the radius of the circle")
        round_axis = _needed(axis, table, machine)
        point, outwards = np.array(round_axis.point), location_errors(round_axis)[1][:, 0]
        target = point + table["R"][:, None] * outwards - machine.origin
        if "z" in table:
            up = unit(round_axis.axis) * _sense(round_axis)
            target += (table["z"] - point @ up)[:, None] * up
    elif method in BALLS:
        table.need("xyz", "columns x, y, z of the ball, machine coordinates at rotary zero")
        target = np.column_stack([table[name] + start[name] for name in "xyz"]) - machine.origin
    keys = [table["setup"] if "setup" in table else np.zeros(count), length]
    keys += [*target.T] if method in ("ball", "sensor") else []
    _, first, setup = np.unique(np.column_stack(keys), axis=0, return_index=True, return_inverse=True)
    setup = setup.ravel()
    if method in PROBED:
        _refuse_several(table, columns, np.column_stack([setup, np.round(angles, 6)]))
        # The first row of each feature says where it is believed to be
        shown = np.column_stack([values.get(name, np.zeros(count)) for name in "xyz"]) - machine.origin
        target = tips(machine, np.column_stack([shown, angles]), length)[0][first][setup]
    believed, turn = held(machine, target, angles, length)
    joints = believed.copy()

    rows, reference, sign = np.tile(np.arange(count), len(columns)), None, 1
    if method in SIGNS:
        sign = table.choice("positive", SIGNS[method])
    if method in PROBED:  # the slides are where they were read: there nothing is left between ball and tool
        for name in columns:
            joints[:, "xyz".index(name)] = values[name] - machine.origin["xyz".index(name)]
            values[name] = np.zeros(count)
    _check_travel(table, machine, joints, length, columns[0])
    if method == "tip":
        upright = angles * [each.carries == "workpiece" for each in machine.rotary]
        reference = held(machine, target, upright, length)[0][rows]
    directions = _directions(table, machine, method, columns, axis, target, turn)
    return Readings(
        table.path,
        method,
        joints=joints[rows],
        believed=believed[rows],
        reference=reference,
        target=target[rows],
        direction=np.concatenate([np.broadcast_to(directions[name], target.shape) for name in columns]),
        length=length[rows],
        value=sign * np.concatenate([values[name] for name in columns]),
        setup=setup[rows],
        zeroed=method in ("dial", "ballbar"),
        sigma=stated_sigma(table, table.unit(columns[0], "length")),
        order=np.tile(np.linspace(0, 1, count), len(columns)),
        rows=tuple((line, name) for name in columns for line in table.lines),
        notes=(*table.notes, *_unread(table, method, columns)),
        doubts=_repeated(table),
    )


def _check_travel(table: Table, machine: Machine, joints: np.ndarray, length: np.ndarray, column: str) -> None:
    """Refuse poses at which a slide would be outside its travel; `column` is named for a file without x y z.

    Where only tables turn, the tool's length matters to nothing else: if the file does not state it, travel along
    the tool is not judged.
    """
    tool, stated = unit(machine.tool_axis), "length" in table or "L" in table
    tables_alone = all(each.carries == "workpiece" for each in machine.rotary)
    longer = (length - machine.tool_length)[:, None] * tool * (machine.limits_of == "slides")
    for index, name in enumerate("XYZ"):
        low, high = machine.limits[index]
        if tables_alone and not stated and abs(tool[index]) > SMALL:
            continue
        stands = joints[:, index] + longer[:, index] * (machine.programmed_point == "tip")
        for row in np.flatnonzero((stands < low - 1e-6) | (stands > high + 1e-6))[:1]:
            low, high, stands = (number + machine.origin[index] for number in (low, high, stands[row]))
            expected = (
                f"a place that the tip reaches: {name} within {low:g} … {high:g}, machine coordinates "
                "(counted from elsewhere? a line # start = X Y Z, the machine coordinates of 0 0 0)"
            )
            where = table.where(row, name.lower() if name.lower() in table else column)
            raise InputError(where, expected, f"{name} {stands:.10g}")


def _directions(
    table: Table, machine: Machine, method: str, columns: list[str], axis: Rotary | None, target: np.ndarray,
    turn: np.ndarray,
) -> dict[str, np.ndarray]:  # fmt: skip
    """The direction, (3,) or (rows, 3), along which each column reads the distance of the ball from the tool."""
    directions = {name: np.eye(3)["xyz".index(name[-1])] for name in columns if name[-1] in "xyz"}
    if method == "dial":
        directions["dial"] = -turn @ location_errors(_needed(axis, table, machine))[1][:, 0]
    elif method == "ballbar":
        along = unit(target + machine.origin - table.numbers("centre", 3), f"{table.header}, x y z minus centre")
        directions["bar"] = -np.einsum("nij,nj->ni", turn, along)
    elif method == "sensor":  # the tool minus the nest, and along the table's axes
        directions = {name: -turn @ each for name, each in directions.items()}
    elif method == "tip":
        tool, across = unit(machine.tool_axis), unit(_needed(axis, table, machine).axis)
        directions |= {"axial": tool, "lateral": np.cross(tool, across)}
        directions = {name: -directions[name] for name in columns}
    return directions


def _repeated(table: Table) -> tuple[str, ...]:
    """The doubt that rows which are the same to the last digit raise."""
    rows = np.column_stack([table[name] for name in table])
    _, first = np.unique(rows, axis=0, return_index=True)
    again = sorted(set(range(len(rows))) - set(first.tolist()))
    if len(again) < REPEATED or 4 * len(again) < len(rows):
        return ()
    said = f"{len(again)} of {len(rows)} rows repeat others to the last digit"
    copied = f"line {table.lines[again[0]]} first: readings that were copied are no repeats, and make U too small"
    return (f"{table.path}: {said}, {copied}",)


def copied(blocks: Sequence[Readings]) -> Iterator[str]:
    """Yield a doubt about each file whose readings are all found in an earlier file."""
    seen: dict[str, set[tuple[float, ...]]] = {}
    for block in blocks:
        rows = np.column_stack([block.joints, block.target, block.direction, block.value]).tolist()
        for where, others in seen.items():
            if others.issuperset(map(tuple, rows)):
                yield f"{block.where}: its readings all stand in {where}, too: read twice, they make U too small"
        seen[block.where] = set(map(tuple, rows))


def _refuse_several(table: Table, columns: Sequence[str], poses: np.ndarray) -> None:
    """Refuse a feature that is in two places far apart at the same angles: it is two of them."""
    _, first, pose = np.unique(poses, axis=0, return_index=True, return_inverse=True)
    for name in columns:
        same = np.abs(table[name] - table[name][first][pose.ravel()]) * table.unit(name, "length") <= LARGEST
        table.require(name, same, "the place read before at these angles (two features need a column setup)")


def _unread(table: Table, method: str, columns: Collection[str]) -> Iterator[str]:
    """Yield a note on each coordinate of a probed feature that is not in the file: an axis may lean along it."""
    for name in "xyz" if method in PROBED else "":
        if name not in columns:
            yield f"{table.path}: {name} was not read: an axis is found as it is at the feature's {name}"


def _axis(table: Table, machine: Machine, method: str) -> Rotary | None:
    """The rotary axis that the file is about, or None if it does not say; a column angle needs it."""
    rotary = {each.name: each for each in machine.rotary}
    columns = [name for name in rotary if name in table]
    if "axis" not in table.settings and len(columns) == 1:
        axis = rotary[columns[0]]
    elif "axis" in table.settings or "angle" in table or method in CARRIES:
        axis = table.choice("axis", rotary)
    else:
        return None
    if axis.carries != (side := CARRIES.get(method, axis.carries)):
        table.refuse(f"an axis that carries the {side}", axis.name)
    return axis


def _needed(axis: Rotary | None, table: Table, machine: Machine) -> Rotary:
    """The rotary axis that the file is about, which it has to say."""
    return table.choice("axis", {each.name: each for each in machine.rotary}) if axis is None else axis


def _angles(table: Table, machine: Machine, method: str, axis: Rotary | None) -> np.ndarray:
    """The rotary angles of each row, shape (n, 2) in radians; an axis that is not mentioned was at 0."""
    columns = [(n, each.name) for n, each in enumerate(machine.rotary) if each.name in table]
    columns += [(machine.rotary.index(_needed(axis, table, machine)), "angle")] if "angle" in table else []
    if len(dict(columns)) < max(1, len(columns)):
        table.refuse("the rotary angles under their axes' names, or under angle", ", ".join(table))
    angles = np.zeros((len(table.lines), len(machine.rotary)))
    for n, name in sorted(columns):
        table.check_angles(name)
        turned = np.deg2rad(table[name])
        if (method, name) == ("dial", "angle"):
            # On a dial's circle `angle` counts from +X towards +Y, whichever way the table turns.
            turned *= _sense(_needed(axis, table, machine))
        else:
            (low, high), letter = np.degrees(machine.rotary[n].limits), machine.rotary[n].name
            expected = f"degrees within the travel of {letter}, {low:g} … {high:g}, as the control shows them"
            table.require(name, (table[name] >= low - 1e-6) & (table[name] <= high + 1e-6), expected)
        angles[:, n] = turned
    return angles


def _sense(axis: Rotary) -> float:
    """−1 if a rotary axis points mostly against one of the machine's, else 1."""
    return np.sign(max(axis.axis, key=abs))
