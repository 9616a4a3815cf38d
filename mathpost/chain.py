"""The transform chain of a machine, link by link from the workpiece to the tool, in sympy.

The same few lines serve every arrangement: a rotary table is a turn about a line traversed backwards, a head
the same turn forwards, and the three slides are one translation between the two.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import lru_cache, reduce
from typing import TYPE_CHECKING

import numpy as np
import sympy as sp
from numpy.typing import ArrayLike

from mathpost.errors import as_array
from mathpost.formula import numeric
from mathpost.frame import Frame
from mathpost.machine import LETTERS
from mathpost.rotation import about

if TYPE_CHECKING:
    from mathpost.machine import Machine, Rotary


Vectors = Callable[[str, Sequence[float]], sp.Matrix]  # from a symbol's name and the numbers in the machine file


@dataclass(frozen=True)
class Link:
    """One factor of the chain: its name, and the 4×4 matrix in the joint symbols."""

    name: str
    matrix: sp.ImmutableMatrix


@dataclass(frozen=True)
class Geometry:
    """The geometry of a chain in sympy: exact numbers of a machine file, or symbols of the same shape.

    Directions and points of the rotary axes are dicts by joint name; the vectors are 3×1 matrices.
    """

    axis: dict[str, sp.Matrix]
    point: dict[str, sp.Matrix]
    origin: sp.Matrix
    tool_axis: sp.Matrix
    tool_length: sp.Expr
    programmed_point: sp.Matrix

    @classmethod
    def numbers(cls, machine: Machine) -> Geometry:
        """The machine's decimals as exact fractions, so that 0.707107 in two components becomes √2/2."""
        length = _exact(machine.tool_length)
        return cls._of(machine, length, lambda _, axis: exact_unit(axis), lambda _, point: exact_vector(point))

    @classmethod
    def symbols(cls, machine: Machine) -> Geometry:
        """Symbols named after the joints: V the directions, p the points, o the origin, t and L the tool."""
        return cls._of(machine, sp.Symbol("L", real=True), *[lambda name, _: _symbol_vector(name)] * 2)

    @classmethod
    def _of(cls, machine: Machine, length: sp.Expr, direction: Vectors, vector: Vectors) -> Geometry:
        tool_axis = direction("t", machine.tool_axis)
        along = tool_axis if machine.length_axis is None else exact_unit(machine.length_axis)
        named = {"tip": -length * along, "nose": sp.zeros(3, 1)}
        point = machine.programmed_point
        return cls(
            axis={each.name: direction(f"V_{each.name}", each.axis) for each in machine.rotary},
            point={each.name: vector(f"p_{each.name}", each.point) for each in machine.rotary},
            origin=vector("o", machine.origin),
            tool_axis=tool_axis,
            tool_length=length,
            programmed_point=named[point] if isinstance(point, str) else vector("r", point),
        )

    def flat(self) -> list[sp.Expr]:
        """All entries in one list, in the same order for numbers and symbols."""
        vectors = [*self.axis.values(), *self.point.values(), self.origin, self.tool_axis, self.programmed_point]
        return [entry for vector in vectors for entry in vector] + [self.tool_length]


def joint_symbols(machine: Machine) -> tuple[sp.Symbol, ...]:
    """The joint symbols, named as in the machine file."""
    return sp.symbols(machine.joint_names, real=True)


def rotary_in_chain_order(machine: Machine) -> list[tuple[Rotary, sp.Symbol, int]]:
    """The rotary joints from the workpiece to the tool: tuples of `Rotary`, its symbol, and the sign of its turn.

    A table lies between the workpiece and the bed, so the chain runs through it backwards: sign −1.
    """
    pairs = list(zip(machine.rotary, joint_symbols(machine)[3:], strict=True))
    tables = [(rotary, angle, -1) for rotary, angle in pairs if rotary.carries == "workpiece"]
    heads = [(rotary, angle, +1) for rotary, angle in pairs if rotary.carries == "tool"]
    return [*reversed(tables), *heads]


@lru_cache(maxsize=256)
def links(machine: Machine, parameters: bool = False) -> tuple[Link, ...]:
    """Return the chain from the workpiece to the tool as a tuple of `Link`.

    With `parameters` offsets and directions stay symbols instead of the machine's numbers.

    Examples
    --------
    >>> from mathpost import load_machine
    >>> [link.name for link in links(load_machine("dmu50v"))]
    ['workpiece', 'C', 'B', 'linear', 'tool']
    """
    data = Geometry.symbols(machine) if parameters else Geometry.numbers(machine)
    tables: list[Link] = []
    heads: list[Link] = []
    for rotary, angle, sign in rotary_in_chain_order(machine):
        turned = turn(data.axis[rotary.name], data.point[rotary.name], sign * angle)
        (tables if sign < 0 else heads).append(Link(rotary.name, turned))
    slides = data.origin + sp.Matrix(joint_symbols(machine)[:3]) - data.programmed_point
    return (
        Link("workpiece", homogeneous(sp.eye(3), -data.origin)),
        *tables,
        Link("linear", homogeneous(sp.eye(3), slides)),
        *heads,
        Link("tool", homogeneous(_from_z_to(data.tool_axis), -data.tool_length * data.tool_axis)),
    )


@lru_cache(maxsize=256)
def workpiece_from_tool(machine: Machine, parameters: bool = False) -> sp.Matrix:
    """The product of the `links`, a 4×4 matrix."""
    return product(link.matrix for link in links(machine, parameters))


@lru_cache(maxsize=256)
def bodies(machine: Machine) -> tuple[tuple[str, sp.Matrix], ...]:
    """Return the pose of each body of the machine: pairs of its name and the 4×4 matrix machine_from_body.

    First come the bodies carried by the joints between bed and workpiece, then the workpiece, then the bodies
    carried by the joints between bed and tool, and last the tool. A carried body is named after its joint. On the
    workpiece side the frame of a body is that of the machine when all joints are zero, on the tool side its origin
    is the spindle nose; the workpiece and the tool have their own frames. `Machine.slides_that_carry` says which
    slides are on which side, and which carries which.

    Examples
    --------
    >>> from mathpost import load_machine
    >>> [name for name, _ in bodies(load_machine("head_b_table_c"))]
    ['C', 'workpiece', 'X', 'Y', 'Z', 'B', 'tool']
    """
    first, *rest = links(machine)
    symbols = dict(zip(machine.joint_names, joint_symbols(machine), strict=True))
    cut = [link.name for link in rest].index("linear")
    slides, *heads = rest[cut:]
    standing = dict.fromkeys((symbols[name] for name in machine.slide_order), sp.S.Zero)
    found, place = [], sp.ImmutableMatrix(sp.eye(4))
    for name in machine.slides_that_carry("workpiece"):  # the word X+ moves the workpiece towards X-
        direction = sp.Matrix([int(name == letter) for letter in LETTERS])
        place = product((place, homogeneous(sp.eye(3), -symbols[name] * direction)))
        found.append((name, place))
    for link in reversed(rest[:cut]):  # a turn traversed backwards is a turn by minus the angle
        place = product((place, link.matrix.xreplace({symbols[link.name]: -symbols[link.name]})))
        found.append((link.name, place))
    found.append(("workpiece", product((place, first.matrix.inv()))))
    place = slides.matrix.xreplace(standing)
    for name in machine.slides_that_carry("tool"):
        del standing[symbols[name]]
        place = slides.matrix.xreplace(standing)
        found.append((name, place))
    for link in heads:
        place = product((place, link.matrix))
        found.append((link.name, place))
    return tuple(found)


def turn(axis: sp.Matrix, point: sp.Matrix, angle: sp.Expr) -> sp.Matrix:
    """The 4×4 matrix of a turn about the line through `point` along the unit vector `axis`."""
    matrix = about(axis, angle)
    return homogeneous(matrix, point - matrix * point)


def homogeneous(matrix: sp.Matrix, translation: sp.Matrix) -> sp.Matrix:
    """The 4×4 matrix of a rotation and a translation."""
    return sp.ImmutableMatrix(sp.Matrix.vstack(sp.Matrix.hstack(matrix, translation), sp.Matrix([[0, 0, 0, 1]])))


def product(matrices: Iterable[sp.Matrix]) -> sp.Matrix:
    """The product of sympy matrices, the first on the left, as in a textbook.

    sympy's own product checks whether an entry is infinite before multiplying it by zero, which takes ten times as
    long.
    """
    return reduce(_times, matrices)


def _times(left: sp.Matrix, right: sp.Matrix) -> sp.Matrix:
    def entry(row: Sequence[sp.Expr], column: Sequence[sp.Expr]) -> sp.Expr:
        return sp.Add(*(a * b for a, b in zip(row, column, strict=True) if a != 0 and b != 0))

    columns = right.T.tolist()
    return sp.ImmutableMatrix([[entry(row, column) for column in columns] for row in left.tolist()])


def _from_z_to(axis: sp.Matrix) -> sp.Matrix:
    """The rotation by the shortest way from ez to the unit vector `axis`: the tool frame's axes."""
    z = sp.Matrix([0, 0, 1])
    if axis == -z:
        return sp.diag(1, -1, -1)
    cross = z.cross(axis).hat()
    return sp.eye(3) + cross + cross * cross / (1 + axis[2])


def _exact(number: float) -> sp.Expr:
    return sp.Rational(repr(float(number)))


def exact_vector(vector: Sequence[float]) -> sp.Matrix:
    """The decimals of `vector` as exact fractions, a 3×1 sympy matrix."""
    return sp.Matrix([_exact(entry) for entry in vector])


def exact_unit(vector: Sequence[float]) -> sp.Matrix:
    """`vector` in exact numbers, scaled to length 1."""
    exact = exact_vector(vector)
    return exact / sp.sqrt(exact.dot(exact))


def vector_symbols(name: str) -> list[sp.Symbol]:
    """The three symbols of a vector of `Geometry.symbols`, such as V_B, p_B or o."""
    return sp.symbols([f"{name}{axis}" for axis in "xyz"], real=True)


def _symbol_vector(name: str) -> sp.Matrix:
    return sp.Matrix(vector_symbols(name))


def joint_values(machine: Machine, joints: ArrayLike, degrees: bool) -> list[np.ndarray]:
    """The joints (..., k) one by one, mm and radians, as the compiled functions of the chain take them."""
    values = list(np.moveaxis(as_array(joints, len(machine.joint_names), "joints"), -1, 0))
    return values[:3] + [np.deg2rad(angle) if degrees else angle for angle in values[3:]]


def machine_frames(machine: Machine, joints: ArrayLike, *, degrees: bool = False) -> tuple[Frame, ...]:
    """Return the poses of a machine's workpiece and tool, WCS in MCS and TCS in MCS, as two `Frame`.

    `joints`, shape (..., k), are those of `Kinematics.forward`. The tool's origin is the tip, its Z the tool axis.
    ``machine_from_workpiece.inverse() @ machine_from_tool`` takes a point from the tool's frame to the workpiece's.

    Examples
    --------
    >>> from mathpost import load_machine
    >>> workpiece, tool = machine_frames(load_machine("ac_table"), [10, 0, 30, 0, 90], degrees=True)
    >>> (workpiece.inverse() @ tool).origin.round(6) + 0.0
    array([ 0., 10., 30.])
    """
    placed, symbols = dict(bodies(machine)), joint_symbols(machine)
    values = joint_values(machine, joints, degrees)
    matrices = (numeric(placed[name], symbols)(*values) for name in ("workpiece", "tool"))
    return tuple(Frame.from_matrix(m, "MCS", child) for m, child in zip(matrices, ("WCS", "TCS"), strict=True))
