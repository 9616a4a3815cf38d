"""Readings of a dial, a probe, a ball, a ballbar, a laser: CSV files, brought to one form whatever the method.

All but the laser see the same thing: where the tool stands against a point of the workpiece that the control, with
the machine file's geometry, believes to hold. `Readings` say at which joints, for which point, along which
direction. `template` prints a file for each method to fill in.
"""

import re
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
import sympy as sp

from mathpost import chain
from mathpost.compensate.model import named_point
from mathpost.errors import InputError
from mathpost.formula import numeric
from mathpost.kinematics import Kinematics
from mathpost.machine import ENDLESS, LETTERS, Linear, Machine
from mathpost.measure import csv_table, spline
from mathpost.measure.angular_error import RUNS
from mathpost.measure.fit import Value
from mathpost.measure.rotary_axis import location_errors
from mathpost.rotation import unit

LARGEST = 5  # mm: of a reading that is no position
SQUARE = 1e-6  # sine of an angle that is none
ROUNDING = 1e-9  # mm or radians: no reading scatters less


POSITIONING = ("laser", "autocollimator")
# For each method: what its columns are, and an example; {axis} is a rotary axis of the machine.
METHODS = {
    "ball": (
        "a ball on the table, the tool (R-test, or a probe) kept on it by RTCP: x y z is the ball at rotary\n"
        "zero in machine coordinates, ex ey ez the ball minus the tool along the machine's axes",
        "{axes},x,y,z,ex,ey,ez\n0,0,150,0,50,0.000,0.000,0.000\n0,90,150,0,50,0.004,-0.002,0.000\n",
    ),
    "probe": (
        "one ball or bore probed at several rotary angles: x y z is its centre in machine coordinates, as\n"
        "displayed; a coordinate that was not probed may be left out; the column setup numbers the features",
        "{axes},x,y,z\n0,0,150.000,0.000,50.000\n0,90,0.004,-149.998,50.001\n",
    ),
    "dial": (
        "X and Y run on a circle of radius R about the table axis, which turns along: the dial looks at one\n"
        "spot of a ring; angle is where on the circle, from +X towards +Y, z the height in machine coordinates\n"
        "positive: out if the reading grows when the tool is moved away from the centre (try it), else in",
        "angle,R,z,dial\n0,100,0,0.000\n90,100,0,0.012\n180,100,0,0.021\n270,100,0,0.008\n",
    ),
    "tip": (
        "a dial at the tip of a head that tilts under RTCP, zeroed at 0; L is pivot to tip. axial: positive\n"
        "from the tip to the pivot, as the tool stands at 0; lateral: positive where the tip swings as the\n"
        "angle grows; or x y z along the machine's axes. positive: tip if so moves the tip, block if the block",
        "angle,L,axial,lateral\n-40,500,0.000,0.000\n40,500,0.000,0.000\n-40,700,0.000,0.000\n40,700,0.000,0.000\n",
    ),
    "ballbar": (
        "a bar from a ball on the table (centre, machine coordinates at rotary zero) to one in the spindle, which\n"
        "RTCP keeps at x y z of the workpiece (counted alike); bar: how much longer than nominal",
        "{axes},x,y,z,bar\n0,0,150,0,50,0.000\n0,0,0,150,50,0.003\n",
    ),
    "bar": (
        "a test bar with a ball end touches faces of a gauge in a known place: face is the side that it comes\n"
        "from, at where it is, shown what the control shows, with the length of the machine file and no radius",
        "face,at,shown\n+X,50,53.001\n-X,-50,-53.002\n+Z,80,80.004\n+Z,80,80.005\n",
    ),
    "laser": (
        "positioning of one axis after ISO 230-2: actual minus target, for the axis as it is programmed;\n"
        "up1,down1,up2,… for runs forth and back, or one column reading, in the order in which it was taken",
        "position,up1,down1,up2,down2\n0,0.0,0.4,0.1,0.5\n30,1.2,1.5,1.1,1.6\n",
    ),
}
METHODS["autocollimator"] = METHODS["laser"]
READ = {"ball": ("ex", "ey", "ez"), "probe": ("x", "y", "z"), "dial": ("dial",), "ballbar": ("bar",)}
READ |= {"tip": ("axial", "lateral", "x", "y", "z"), "bar": ("shown",)}
READ |= dict.fromkeys(POSITIONING, ("reading", "forth", "back"))
CARRIES = {"dial": "workpiece", "tip": "tool"}  # what the axis carries that a method is about
SIGNS = {"dial": {"out": 1, "in": -1}, "tip": {"tip": 1, "block": -1}}


@dataclass(frozen=True)
class Readings:
    """The n rows of one file: how far the point `target` + ball stands from the tool along `direction`."""

    where: str
    method: str
    joints: np.ndarray  # as programmed, (n, 5); mm and radians throughout
    reference: np.ndarray | None  # at which it was zeroed, (n, 5): what it would be there is to be subtracted
    target: np.ndarray  # in the workpiece, (n, 3)
    direction: np.ndarray  # along the machine's axes, (n, 3)
    length: np.ndarray  # of the tool from the spindle nose, (n,)
    value: np.ndarray  # the reading, (n,)
    setup: np.ndarray  # which ball, (n,): each lies a little elsewhere than its target
    zeroed: bool  # whether each has an unknown zero, too
    sigma: float  # standard deviation of a reading, NaN if the file does not say it
    freedom: float = np.inf  # its degrees of freedom


@dataclass(frozen=True)
class Positioning:
    """The positioning error of one joint."""

    where: str
    joint: int  # its index
    at: np.ndarray  # degrees or mm, shape (targets,)
    value: np.ndarray  # mean error there, radians or mm
    sigma: np.ndarray  # its standard deviation
    freedom: float  # degrees of freedom of the deviations
    endless: bool
    reversal: float  # B of ISO 230-2, the largest difference of both directions

    def curve(self, values):
        """The spline through `values`, shape (targets, ...), as `mathpost.measure.spline.Curve`."""
        return spline.through_all(spline.Points(self.at, values, 360.0 if self.endless else None))


def template(method, machine):
    """Return a file to fill in, as text, with the names of the machine's own axes."""
    if method not in METHODS:
        raise InputError("method", f"one of {', '.join(METHODS)}", repr(method))
    words, rows = METHODS[method]
    settings = {"method": method, "unit": "arcsec" if method in POSITIONING else "mm"}
    if method in SIGNS:
        settings["positive"] = next(iter(SIGNS[method]))
    if method in (*CARRIES, *POSITIONING):
        names = {each.carries: each.name for each in machine.rotary}
        settings["axis"] = names.get(CARRIES.get(method, "workpiece"), machine.rotary[-1].name)
    if method == "ballbar":
        settings["centre"] = "0 0 50"
    comments = [f"# {line}" for line in words.splitlines()]
    comments += [f"# {key} = {value}" for key, value in settings.items()]
    axes = ",".join(rotary.name for rotary in machine.rotary)
    return "\n".join([*comments, rows.replace("{axes}", axes)])


def read(path, machine, **settings):
    """Read a file of any method as `Readings`, `Positioning` or, of a test bar, a dict of `Value`.

    `machine` is as the control believed it to be; `settings` are ``method``, ``unit``, ``axis`` and so on, where
    the file does not say them. What it leaves unclear is asked for by an `InputError` with the line.
    """
    known = {method: _columns(method, machine) for method in METHODS}
    names = dict.fromkeys(name for columns in known.values() for name in columns)
    table = csv_table.read(path, [], optional=tuple(names), text=["face"])
    for key in set(settings) - set(csv_table.KNOWN):
        raise InputError(key, f"settings among {', '.join(csv_table.KNOWN)}", "none of them")
    table.settings = {key: str(value) for key, value in settings.items()} | table.settings
    method = table.settings.get("method", "").casefold()
    if method not in METHODS:
        table.refuse(f"a line # method = one of {', '.join(METHODS)}", method and repr(method))
    for name in table:
        if name not in known[method]:
            table.refuse(f"no columns but {', '.join(known[method][: csv_table.SHOWN])}", repr(name))
    if method == "bar":
        return _bar(table, machine)
    table.obey_units(set(table) - {*READ[method], *RUNS})
    return _positioning(table, machine) if method in POSITIONING else _readings(table, machine, method)


def _columns(method, machine):
    """The columns that a file of `method` may have: its readings, what its template shows beside them, and more."""
    shown = re.sub(r"\{axes\},|angle,|\n.*", "", METHODS[method][1], flags=re.DOTALL).split(",")
    axes = (*machine.joint_names, *RUNS) if method in POSITIONING else machine.joint_names[3:]
    return list(dict.fromkeys([*READ[method], *shown, "angle", *axes, "length", "setup", "run"]))


def _bar(table, machine):
    """By how much a bar is longer than the tool, and its ball's radius: those that were touched, as `Value`, mm."""
    tool, found = unit(machine.tool_axis), {"length": [], "radius": []}
    table.need(("face", "at", "shown"), "columns face, at, shown")
    size = table.unit("shown", "length")
    for row, (face, at, shown) in enumerate(zip(table["face"], table["at"], table["shown"], strict=True)):
        sign, letter = {"+": 1, "-": -1, "−": -1}.get(face[:1]), face[1:].upper()
        along = sign * tool["XYZ".index(letter)] if sign and letter in LETTERS else np.nan
        if not (abs(along) < SQUARE or along > 1 - SQUARE):
            expected = "the side that the bar comes from: +X, -X and so on, along the tool or square to it"
            raise InputError(table.where(row, "face"), expected, repr(face))
        found["length" if along > 0.5 else "radius"].append(sign * size * (shown - at))
    found = {key: each for key, each in found.items() if each}
    sigma, freedom = _scatter(table, found.values(), size, "a face touched twice")
    return {key: Value(float(np.mean(each)), sigma / len(each) ** 0.5, freedom) for key, each in found.items()}


def _readings(table, machine, method):
    """Bring a table of `method` to `Readings`."""
    tool, count = unit(machine.tool_axis), len(table.lines)
    columns = [name for name in READ[method] if name in table]
    if not columns:
        table.refuse(f"columns of readings: {', '.join(READ[method])}")
    axis = _axis(table, machine, method)
    angles = _angles(table, machine, method, axis)
    length = table["length"] if "length" in table else np.full(count, machine.tool_length)
    if "L" in table:
        length = table["L"] - np.array(axis.point) @ tool
    values = {}
    for name in columns:
        values[name] = table.unit(name, "length") * table[name]
        if method != "probe":
            table.require(name, np.abs(values[name]) <= LARGEST, f"a reading within ±{LARGEST} mm (other units?)")

    target = np.zeros((count, 3))  # where the ball is believed to be, in the workpiece
    if method == "dial":  # where it looks at the ring with the axis at zero
        table.need("R", "a column R, the radius of the circle")
        point, outwards = np.array(axis.point), location_errors(axis)[1][:, 0]
        target = point + table["R"][:, None] * outwards - machine.origin
        if "z" in table:
            up = unit(axis.axis) * _sense(axis)
            target += (table["z"] - point @ up)[:, None] * up
    elif method in ("ball", "ballbar"):
        table.need("xyz", "columns x, y, z of the ball, machine coordinates at rotary zero")
        target = np.column_stack([table[name] for name in "xyz"]) - machine.origin
    keys = [table["setup"] if "setup" in table else np.zeros(count), length]
    keys += [*target.T] if method == "ball" else []
    _, first, setup = np.unique(np.column_stack(keys), axis=0, return_index=True, return_inverse=True)
    setup = setup.ravel()
    if method == "probe":  # the first row of each feature says where it is believed to be
        shown = np.column_stack([values.get(name, np.zeros(count)) for name in "xyz"]) - machine.origin
        target = tips(machine, np.column_stack([shown, angles]), length)[0][first][setup]
    joints, turn = held(machine, target, angles, length)

    directions = {name: np.eye(3)["xyz".index(name[-1])] for name in columns if name[-1] in "xyz"}
    rows, reference, sign = np.tile(np.arange(count), len(columns)), None, 1
    if method in SIGNS:
        sign = table.choice("positive", SIGNS[method])
    if method == "probe":
        values = {name: values[name] - (joints[:, :3] + machine.origin) @ directions[name] for name in columns}
    elif method == "dial":
        directions["dial"] = -turn @ outwards
    elif method == "ballbar":
        along = unit(target + machine.origin - table.numbers("centre", 3), f"{table.header}, x y z minus centre")
        directions["bar"] = -np.einsum("nij,nj->ni", turn, along)
    elif method == "tip":
        directions |= {"axial": tool, "lateral": np.cross(tool, unit(axis.axis))}
        directions = {name: -directions[name] for name in columns}
        upright = angles * [each.carries == "workpiece" for each in machine.rotary]
        reference = held(machine, target, upright, length)[0][rows]
    return Readings(
        table.path,
        method,
        joints=joints[rows],
        reference=reference,
        target=target[rows],
        direction=np.concatenate([np.broadcast_to(directions[name], target.shape) for name in columns]),
        length=length[rows],
        value=sign * np.concatenate([values[name] for name in columns]),
        setup=setup[rows],
        zeroed=method in ("dial", "ballbar"),
        sigma=_sigma(table, table.unit(columns[0], "length")),
    )


def _axis(table, machine, method):
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


def _angles(table, machine, method, axis):
    """The rotary angles of each row, shape (n, 2) in radians; an axis that is not mentioned stood at 0."""
    columns = [(n, each.name) for n, each in enumerate(machine.rotary) if each.name in table]
    columns += [(machine.rotary.index(axis), "angle")] if "angle" in table else []
    if len(dict(columns)) < max(1, len(columns)):
        table.refuse("the rotary angles under their axes' names, or under angle", ", ".join(table))
    angles = np.zeros((len(table.lines), 2))
    for n, name in sorted(columns):
        table.check_angles(name)
        # On a dial's circle `angle` counts from +X towards +Y, whichever way the table turns.
        angles[:, n] = np.deg2rad(table[name]) * (_sense(axis) if (method, name) == ("dial", "angle") else 1)
    return angles


def _sense(axis):
    """−1 if a rotary axis points mostly against one of the machine's, else 1."""
    return np.sign(max(axis.axis, key=abs))


def _positioning(table, machine):
    """Bring runs of one axis to `Positioning`: the mean of both directions at each target."""
    axis = table.choice("axis", {name: n for n, name in enumerate(machine.joint_names)})
    name, rotary = machine.joint_names[axis], axis > 2
    place = next((each for each in ("position", "angle", name) if each in table), None)
    if place is None:
        table.refuse(f"a column position, angle or {name}")
    at = table[place]
    kind, most, scale = ("angle", np.deg2rad(1), np.deg2rad(1)) if rotary else ("length", LARGEST, 1.0)
    if rotary:
        table.check_angles(place)
    columns = [c for c in table if c in ("forth", "back", "reading") or c[:2] == "up" or c[:4] == "down"]
    if not columns:
        table.refuse("columns up1, down1, … or forth, back or reading")
    values = np.column_stack([table.unit(each, kind) * table[each] for each in columns])
    for each, deviations in zip(columns, values.T, strict=True):
        same = np.ptp(at) > 2 and np.ptp(deviations) > np.ptp(at) * scale / 2
        table.require(each, ~np.full(len(table.lines), same), "deviations, actual minus target, no positions")
        table.require(each, np.abs(deviations) <= most, "a deviation below 1° or 5 mm (other units?)")
    backwards = [each == "back" or each.startswith("down") for each in columns]
    sides = np.tile(np.where(backwards, -1.0, 1.0), (len(at), 1))
    if "reading" in columns and np.ptp(at):  # rows as they were taken: the direction is that in which the axis came
        sides[:] = np.sign(np.diff(at, prepend=2 * at[0] - at[1]))[:, None]
    endless = bool(rotary and np.isinf(machine.rotary[axis - 3].limits[0]) and np.ptp(at) > 270)
    runs = {}
    for target, row, came in zip((at % 360 if endless else at).round(6), values, sides, strict=True):
        for value, side in zip(row, came, strict=True):
            if side:
                runs.setdefault(target, {}).setdefault(side, []).append(value)
    if len(runs) < 2 + endless:
        table.refuse(f"at least {2 + endless} targets", f"{len(runs)}")
    groups = [[np.array(each) for each in runs[target].values()] for target in sorted(runs)]
    every = [each for group in groups for each in group]
    sigma, freedom = _scatter(table, every, table.unit(columns[0], kind), "two runs")
    means = np.array([np.mean([each.mean() for each in group]) for group in groups])
    spread = np.array([np.sqrt(sum(1 / len(each) for each in group)) / len(group) for group in groups])
    reversal = max((abs(group[0].mean() - group[1].mean()) for group in groups if len(group) == 2), default=0.0)
    targets = np.array(sorted(runs))
    return Positioning(table.header, axis, targets, means, sigma * spread, freedom, endless, float(reversal))


def _scatter(table, groups, size, repeated):
    """The standard deviation of a reading and its degrees of freedom: stated in units of `size`, or of repeats."""
    stated = _sigma(table, size)
    if not np.isnan(stated):
        return stated, np.inf
    freedom = sum(len(each) - 1 for each in groups)
    if not freedom:
        table.refuse(f"{repeated}, or a line # sigma = standard deviation of a reading", "neither")
    return max(np.sqrt(sum(np.var(each) * len(each) for each in groups) / freedom), ROUNDING), freedom


def _sigma(table, size):
    """The stated standard deviation of a reading, in units of `size`; NaN if the file does not say it."""
    (sigma,) = table.numbers("sigma", 1) if "sigma" in table.settings else [np.nan]
    if sigma <= 0:
        table.refuse("a line # sigma = a number above 0", f"{sigma:g}")
    return sigma * size


def held(machine, target, angles, length):
    """Return the joints, (n, 5), with which RTCP holds the tip on `target`, and the turns machine_from_workpiece.

    `target` is (n, 3) in the workpiece, `angles` (n, 2) radians, `length` (n,).
    """
    zero, by = tips(machine, np.column_stack([np.zeros((len(angles), 3)), angles]), length)
    turn = np.swapaxes(by[..., :3], 1, 2)
    return np.column_stack([np.einsum("nij,nj->ni", turn, target - zero), angles]), turn


def tips(machine, joints, length, real=None):
    """Return the tip in the workpiece, (n, 3), with tools of any `length`, (n,), and its derivatives, (n, 3, 26).

    They are by the `joints`, by the 18 numbers of `geometry` and by the point that X Y Z name. `real` is the
    machine as it is if that is not `machine`, with which the control reckons.
    """
    numbers = [*geometry(real or machine), *np.moveaxis(named_point(machine, length), -1, 0)]
    # The formulas are those of any machine of the arrangement: the numbers are arguments.
    rotary = tuple(replace(each, axis=(1, 0, 0), point=(0, 0, 0), limits=ENDLESS) for each in machine.rotary)
    linear = tuple(Linear(name) for name in "XYZ")
    formulas = _compiled(Machine("", "", rotary, linear, (0, 0, 0), (0, 0, 1), 0.0, (0.0, 0.0, 0.0)))
    tip, derivatives = (formula(*np.transpose(joints), *numbers, length) for formula in formulas)
    return tip[..., 0], derivatives


def geometry(machine):
    """The axes and points, origin and tool axis of a machine: 18 numbers."""
    axes, points = [unit(each.axis) for each in machine.rotary], [each.point for each in machine.rotary]
    return np.concatenate([*axes, *points, machine.origin, unit(machine.tool_axis)])


@lru_cache(maxsize=32)
def _compiled(machine):
    kin = Kinematics(machine)
    *numbers, length = (each for each in chain.Geometry.symbols(machine).flat() if each.is_Symbol)
    arguments = (*kin.symbols, *numbers, length)
    # The product rule link by link, from the tool on: to differentiate the product takes sympy three times as long.
    tip, slopes = sp.Matrix([0, 0, 0, 1]), sp.zeros(4, len(arguments) - 1)
    for link in reversed(kin.links(parameters=True)):
        own = [chain.product((link.matrix.diff(each), tip)) for each in arguments[:-1]]
        slopes = chain.product((link.matrix, slopes)) + sp.Matrix.hstack(*own)
        tip = chain.product((link.matrix, tip))
    return tuple(numeric(sp.ImmutableMatrix(each[:3, :]), arguments) for each in (tip, slopes))
