"""The errors of a machine: in its chain as symbols, and measured ones as figures from a TOML file.

Between each joint's body and the one before it is an *error frame*: a small displacement, turned by the roll,
pitch and yaw of the carried body. Six errors for each of the five joints and three squareness errors make 33
symbols. A calibration gives each a constant, a table over the joint's position, or both: 30 functions, 3 squareness
constants and 2 × 4 location constants of the rotary axes are the usual count of 41.

Errors are named as in ISO 230-1: E, the component (X Y Z displacements along, A B C rotations about, the machine's
axes), the joint. EYX is the straightness of X along Y, ECC the angular positioning error of C. EC0Y, EB0Z and EA0Z
turn the path of Y and Z out of square. All are seen in the body before the joint, at a rotary joint's `point` and
at a slide's own place; all move the *carried* body, table or tool. Displacements are mm, rotations radians.

Bohez (source 001) has two groups of errors. In a file, the errors that do not depend on position are listed under
[constant], the others in tables, each over the position of one joint::

    name = "…"
    source = "…"
    machine = "…"                     # `fingerprint` of the one machine that it is for

    [constant]                        # µm and µrad
    EXA = 10
    EAA = 30

    [[table]]
    joint = "C"
    file = "c_axis.csv"               # beside this file: the column position, then ECC, EZC, …
    endless = true                    # repeats after 360°; without it the errors end where the table ends
    interpolation = "spline"          # or "linear"

Positions are degrees, or mm. That of a slide is what its encoder counts, whatever the tool: its machine coordinate
while no tool length is active (G53, M91, SUPA), `Machine.slide_positions`. Squareness counts from its 0. The own
place of a slide is there, with the slides that it carries at 0: that of the last one is the spindle nose, or the
point of the head that X Y Z name. The workpiece is taken to be where the ideal machine would have it: subtract any
error that probing it on the machine has removed.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import sympy as sp
from numpy.typing import ArrayLike

from mathpost import chain
from mathpost.errors import InputError, as_array
from mathpost.files import TomlTable, a_number, beside, only_if, read_toml, some_text
from mathpost.formula import numeric
from mathpost.machine import Machine
from mathpost.rotation import ACTIVE, unit
from mathpost.shop.measure import csv_table, spline

if TYPE_CHECKING:
    from mathpost.chain import Link
    from mathpost.shop.measure.spline import Curve

COMPONENTS = "XYZABC"
SQUARENESS = ("EC0Y", "EB0Z", "EA0Z")
GREATEST = {"um": 5000, "urad": 20000}  # more than this is another unit, or no machine
MARGIN = 0.1  # mm or degrees by which a corrected joint may leave its table


def error_names(machine: Machine) -> tuple[str, ...]:
    """Names of the 33 errors, 27 with one rotary axis: six for each joint in joint order, then squareness."""
    return (*(f"E{component}{joint}" for joint in machine.joint_names for component in COMPONENTS), *SQUARENESS)


class ErrorModel:
    """The chain of a machine with its errors as symbols, its derivatives, and both compiled.

    `joints` are 5 sympy symbols, `errors` 33 in the order of `names`, which is that of `error_names`. What is
    compiled serves every origin and tool length.

    Examples
    --------
    >>> from mathpost import load_machine
    >>> model = ErrorModel(load_machine("data/machines/ac_table.toml"))
    >>> [link.name for link in model.links()]
    ['workpiece', 'C', 'error C', 'A', 'error A', 'X', 'error X', ..., 'programmed', 'tool']
    >>> sp.Matrix(model.sensitivity("EXC"))[:3, 0].subs({model.joints[3]: 0})
    Matrix([
    [-cos(C)],
    [-sin(C)],
    [      0]])
    """

    def __init__(self, machine: Machine) -> None:
        self.machine = machine
        self.names = error_names(machine)
        self.joints = chain.joint_symbols(machine)
        self.errors = sp.symbols(self.names, real=True)
        self.symbol = dict(zip(self.names, self.errors, strict=True))
        self._compiled: dict[tuple[str, ...], Callable[..., np.ndarray]] = {}

    @cached_property
    def _bare(self) -> ErrorModel:
        """The model without a tool, whose words are the positions of the slides: one for all set-ups."""
        return _model(self.machine.with_setup(origin=np.zeros(3), tool_length=0.0))

    def links(self) -> list[Link]:
        """Return the chain from the workpiece to the tool as a list of `mathpost.chain.Link`."""
        data = chain.Geometry.numbers(self.machine)
        # Where words name the tip, the control adds the tool to the positions of the slides.
        added = -data.programmed_point * int(self.machine.programmed_point == "tip")
        zero = data.origin + added
        ideal = {link.name: link for link in chain.links(self.machine)}
        tables, heads = [], []
        for rotary, _, sign in chain.rotary_in_chain_order(self.machine):
            point = data.point[rotary.name]
            if sign < 0:
                tables += [ideal[rotary.name], self._error(rotary.name, point, inverse=True)]
            else:
                heads += [self._error(rotary.name, point), ideal[rotary.name]]
        for name in reversed(self.machine.slides_that_carry("workpiece")):
            tables += [self._error(name, inverse=True), self._slide(name, zero)]
        names = self.machine.slides_that_carry("tool")
        slides = [link for name in names for link in (self._slide(name, zero), self._error(name))]
        programmed = chain.Link("programmed", chain.homogeneous(sp.eye(3), -data.programmed_point - added))
        return [ideal["workpiece"], *tables, *slides, programmed, *heads, ideal["tool"]]

    def _slide(self, name: str, zero: sp.Matrix) -> Link:
        """Travel along a path that squareness errors turn: a workpiece slide runs the other way, backwards."""
        index = "XYZ".index(name)
        turned = sp.Matrix([self.symbol.get(f"E{axis}0{name}", 0) for axis in "ABC"])
        path = sp.eye(3)[:, index] + turned.cross(sp.eye(3)[:, index])
        return chain.Link(name, chain.homogeneous(sp.eye(3), (zero[index] + self.joints[index]) * path))

    def _error(self, name: str, point: sp.Matrix | None = None, inverse: bool = False) -> Link:
        """The error frame of a joint at `point`; of a slide, at the place that the slide itself has carried."""
        six, point = [self.symbol[f"E{c}{name}"] for c in COMPONENTS], point or sp.zeros(3, 1)
        return chain.Link(f"error {name}", error_frame(six, point, inverse))

    @cached_property
    def _partial(self) -> tuple[list[Link], list[sp.Matrix], list[sp.Matrix]]:
        """The links, and the products of those before and behind each of them without errors."""
        links = self.links()
        matrices = [link.matrix.xreplace(dict.fromkeys(self.errors, 0)) for link in links]
        before, behind = [sp.eye(4)], [matrices[-1][:, 2:]]
        for matrix in matrices[:-1]:
            before.append(chain.product((before[-1], matrix)))
        for matrix in reversed(matrices[:-1]):
            behind.append(chain.product((matrix, behind[-1])))
        return links, before, behind[::-1]

    def sensitivity(self, name: str) -> sp.Matrix:
        """Return how tip and tool axis move for one unit of the error or the joint `name`, without errors: 6×1.

        The derivative of the chain is the derivative of the one link that holds the symbol, between the products of
        the others.
        """
        symbol = self.symbol.get(name) or dict(zip(self.machine.joint_names, self.joints, strict=True))[name]
        links, before, behind = self._partial
        others, moved = [each for each in self.errors if each != symbol], sp.zeros(4, 2)
        for index, link in enumerate(links[:-1]):
            if symbol in link.matrix.free_symbols:
                alone = link.matrix.xreplace(dict.fromkeys(others, 0))  # the others are zero before it is derived
                slope = alone.diff(symbol).xreplace(dict.fromkeys(self.errors, 0))
                moved += chain.product((before[index], slope, behind[index + 1]))
        return sp.ImmutableMatrix([*moved[:3, 1], *moved[:3, 0]])

    def forward(self, joints: ArrayLike, errors: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
        """Return tip and axis, shape (..., 3), of the pose that the real machine takes.

        `joints`, shape (..., 5), and `errors`, shape (..., 33) in the order of `names`, are mm and radians.
        """
        joints, errors = self._slides_and_angles(joints), as_array(errors, len(self.names), "errors")
        pose = self._bare._forward(*joints, *np.moveaxis(errors, -1, 0))
        nose, axis = pose[..., :3], pose[..., 3:]
        return nose - self.machine.tool_length * axis - self.machine.origin, axis

    def jacobian(self, joints: ArrayLike) -> np.ndarray:
        """Return d(tip, axis)/d(joints) of the ideal machine, shape (..., 6, 5), at `joints` in radians."""
        return self._derivatives(joints, self.machine.joint_names)

    def sensitivities(self, joints: ArrayLike) -> np.ndarray:
        """Return d(tip, axis)/d(errors) of the ideal machine, shape (..., 6, 33), at `joints` in radians."""
        return self._derivatives(joints, self.names)

    @cached_property
    def _forward(self) -> Callable[..., np.ndarray]:
        matrix = chain.product(link.matrix for link in self.links())
        return numeric((*matrix[:3, 3], *matrix[:3, 2]), (*self.joints, *self.errors))

    def _derivatives(self, joints: ArrayLike, names: tuple[str, ...]) -> np.ndarray:
        compiled = self._bare._compiled
        if names not in compiled:
            compiled[names] = numeric(sp.ImmutableMatrix.hstack(*map(self._bare.sensitivity, names)), self.joints)
        found = compiled[names](*self._slides_and_angles(joints))
        found[..., :3, :] -= self.machine.tool_length * found[..., 3:, :]
        return found

    def _slides_and_angles(self, joints: ArrayLike) -> list[np.ndarray]:
        """The five arguments of what was compiled: machine coordinates of the slides, and the angles."""
        joints = as_array(joints, len(self.machine.joint_names), "joints")
        slides = self.machine.slide_positions(joints[..., :3])
        return [*np.moveaxis(slides, -1, 0), *np.moveaxis(joints[..., 3:], -1, 0)]


_model = lru_cache(maxsize=8)(ErrorModel)  # to derive and compile one takes seconds


def error_frame(errors: Sequence[sp.Symbol], point: sp.Matrix, inverse: bool = False) -> sp.Matrix:
    """The 4×4 matrix of six errors about `point`: displacement, and the exact turn Rz·Ry·Rx, not its skew form."""
    *displacement, roll, pitch, yaw = errors
    turned = ACTIVE["Z"](yaw) * ACTIVE["Y"](pitch) * ACTIVE["X"](roll)
    shift = sp.Matrix(displacement) + point - turned * point
    return chain.homogeneous(turned.T, -turned.T * shift) if inverse else chain.homogeneous(turned, shift)


@dataclass(frozen=True)
class MachineErrors:
    """Constants and tables of all errors of a machine."""

    machine: Machine
    constant: np.ndarray  # shape (33,), in the order of `error_names`, mm and radians
    # An error's index, and its table in µm or µrad over the position of its joint.
    curves: tuple[tuple[int, Curve], ...] = ()
    drift: np.ndarray | float = 0.0  # added to `constant` since the calibration, by heat for instance

    def at(self, joints: ArrayLike) -> np.ndarray:
        """Return all errors at `joints`, shape (..., 5) in mm and radians, as shape (..., 33)."""
        return self.constant + self.varying(joints)

    def varying(self, joints: ArrayLike) -> np.ndarray:
        """Return the second group alone: what tables and drift add; `ReachError` where that was not measured."""
        joints = as_array(joints, len(self.machine.joint_names), "joints")
        errors = np.zeros((*joints.shape[:-1], len(self.constant))) + self.drift
        for index, curve in self.curves:
            joint = index // len(COMPONENTS)
            position, where = table_position(self.machine, joints, joint), self.machine.joint_names[joint]
            size = _unit(error_names(self.machine)[index])[1]
            errors[..., index] += curve(position, margin=MARGIN, where=where) * size
        return errors


def table_position(
    machine: Machine, joints: np.ndarray, joint: int, tool_length: ArrayLike | None = None
) -> np.ndarray:
    """The position of a joint as its tables count it: degrees, or mm of `Machine.slide_positions`."""
    if joint > 2:
        return np.rad2deg(joints[..., joint])
    return machine.slide_positions(joints[..., :3], tool_length)[..., joint]


@lru_cache(maxsize=len(SQUARENESS))
def out_of_square(name: str) -> tuple[int, np.ndarray]:
    """The index of the slide that a squareness error turns, and where 1 rad sends it aside on 1 mm, shape (3,)."""
    slide = "XYZ".index(name[3])
    aside = np.cross(np.eye(3)["ABC".index(name[1])], np.eye(3)[slide])
    aside.flags.writeable = False
    return slide, aside


def named_point(machine: Machine, length: ArrayLike) -> np.ndarray:
    """The point of the head that X Y Z name, at rotary zero, mm from the nose, (..., 3), with tools of `length`."""
    if machine.programmed_point == "tip":
        return -np.multiply.outer(length, unit(machine.length_axis or machine.tool_axis))
    return np.zeros(3) if machine.programmed_point == "nose" else np.array(machine.programmed_point)


def constant_errors(machine: Machine, errors: Mapping[str, float]) -> MachineErrors:
    """Return `MachineErrors` with the given constants: a dict of name to mm or radians, all others 0."""
    known = error_names(machine)
    for name in errors:
        if name not in known:
            raise InputError(f"error {name!r}", f"one of {', '.join(known)}", "another name")
    return MachineErrors(machine, as_array([errors.get(name, 0) for name in known], len(known), "errors"))


def fingerprint(machine: Machine) -> str:
    """Return a word for the geometry of a machine: its axes, pivots and offsets; not its travel, rates or set-up.

    Errors count from this geometry. They are wrong on a machine file that has them in it already, or not yet.

    Examples
    --------
    >>> from mathpost.machine_file import load
    >>> fingerprint(load("ac_table")), fingerprint(load("bc_table"))
    ('727abc5ac311', 'c8293b4b6b1a')
    """
    parts = [machine.programmed_point] if isinstance(machine.programmed_point, str) else []
    numbers = [*unit(machine.tool_axis), *(machine.programmed_point if not parts else [])]
    numbers += [] if machine.length_axis is None else [*unit(machine.length_axis)]
    for each in machine.rotary:
        parts += [each.name, each.carries]
        numbers += [*unit(each.axis), *each.point]
    parts += [f"{number:z.9f}" for number in numbers]
    return hashlib.sha256(" ".join(parts).encode()).hexdigest()[:12]


def read_errors(path: Path | str, machine: Machine) -> MachineErrors:
    """Read the errors of `machine` from a TOML file, as `MachineErrors`.

    `InputError` if a file cannot be read, is for a machine with another `fingerprint`, a key or a column is missing
    or unknown, an error belongs to no joint of the machine, or a value suggests other units than µm, µrad, mm and
    degrees.
    """
    file, known = TomlTable(read_toml(path), str(path)), error_names(machine)
    for key in ("name", "source"):
        file.take(key, some_text, "text in quotes")
    own = fingerprint(machine)
    expected = f'"{own}", the geometry of {machine.name!r} from which the errors count'
    file.take("machine", only_if(lambda word: word == own), expected)
    constant, values = file.table("constant", optional=True), np.zeros(len(known))
    for index, name in enumerate(known):
        unit, size = _unit(name)
        read = only_if(lambda value, most=GREATEST[unit]: abs(value) <= most, a_number)
        expected = f"a number in {unit}, within ±{GREATEST[unit]} (other units?)"
        values[index] = constant.take(name, read, expected, 0.0) * size
    entries = file.take("table", list, "[[table]] entries", [])
    curves = []
    for number, entry in enumerate(entries, 1):
        curves += _table(TomlTable(entry, f"{path}, table {number}"), path, machine)
    constant.done()
    file.done()
    return MachineErrors(machine, values, tuple(curves))


def _table(entry: TomlTable, path: Path | str, machine: Machine) -> list[tuple[int, Curve]]:
    """Read one [[table]] and the CSV file that it names: pairs of an error's index and its curve."""
    joints = machine.joint_names
    joint = entry.take("joint", joints.index, f"one of {', '.join(joints)}")
    file = beside(
        path, entry.take("file", some_text, "a file name in quotes"), ".csv", f"{entry.where}, key 'file'"
    )
    endless = entry.take("endless", only_if(lambda value: isinstance(value, bool)), "true or false", False)
    kind = entry.take("interpolation", ("spline", "linear").index, '"spline" or "linear"', 0)
    entry.done()
    if endless and joint < 3:
        raise InputError(f"{entry.where}, key 'endless'", "a rotary joint", joints[joint])

    known = error_names(machine)
    columns = [f"E{component}{joints[joint]}" for component in COMPONENTS]
    read = csv_table.read(file, ["position"], optional=columns)
    read.obey_units(["position"])
    if joint > 2:
        read.check_angles("position")
    read.check_increasing("position")
    curves = []
    for name in (column for column in columns if column in read):
        index = known.index(name)
        unit, size = _unit(name)
        read[name] *= read.unit(name, "length" if unit == "um" else "angle", default=unit) / size
        read.require(name, np.abs(read[name]) <= GREATEST[unit], f"{unit} within ±{GREATEST[unit]} (other units?)")
        try:
            measured = spline.points(read["position"], read[name], period=360.0 if endless else None)
        except InputError as error:
            read.refuse(f"{error.where}: {error.expected}", error.found)
        curves.append((index, spline.through_all(measured, straight=bool(kind))))
    if not curves:
        read.refuse(f"at least one of the columns {', '.join(columns)}", "only 'position'")
    return curves


def is_length(name: str) -> bool:
    """Return whether an error is a displacement, not a rotation; that of E10B is along no machine axis."""
    return name[1] in "XYZ12"


def shown_in(name: str) -> tuple[float, str]:
    """Return the factor from mm or radians to the unit in which an error is shown, and the unit."""
    return (1e3, "µm") if is_length(name) else (1e6, "µrad")


def _unit(name: str) -> tuple[str, float]:
    """An error's unit in a file and its size: displacements are µm, rotations and squareness µrad."""
    return ("um", 1e-3) if is_length(name) else ("urad", 1e-6)
