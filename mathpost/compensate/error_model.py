"""The chain of a machine whose joints have errors, derived in sympy from the same links as the ideal one.

Between each joint's body and the one before it stands an *error frame*: a small displacement, turned by the roll,
pitch and yaw of the carried body. Six errors for each of the five joints and three squareness errors make the 33
symbols. A calibration gives each of them a constant, a table over the joint's position, or both: 30 functions, 3
squareness constants and 2 × 4 location constants of the rotary axes are the usual count of 41.

Errors are named as in ISO 230-1: E, the component (X Y Z displacements along, A B C rotations about, the machine's
axes), the joint. EYX is the straightness of X along Y, ECC the angular positioning error of C. EC0Y, EB0Z and EA0Z
turn the path of Y and Z out of square. All are seen in the body before the joint, at a rotary joint's `point` and
at a slide's own place; all move the *carried* body, table or tool. Displacements are mm, rotations radians.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import sympy as sp

from mathpost import chain
from mathpost.errors import InputError, as_array
from mathpost.rotation import ACTIVE, numeric

COMPONENTS = "XYZABC"
SQUARENESS = ("EC0Y", "EB0Z", "EA0Z")


@dataclass(frozen=True)
class Structure:
    """Which slides carry the workpiece and which the tool, each from the bed outwards."""

    workpiece: str = ""
    tool: str = "XYZ"


DEFAULT = Structure()


def structure(text, machine, where="structure"):
    """Read a structure code such as "w C A X b Y Z t" (after ISO 10791): workpiece, bed b, tool t.

    Raises
    ------
    InputError
        If it does not name the machine's five joints once each, with the rotary ones where its file has them.

    Examples
    --------
    >>> from mathpost import machine
    >>> structure("w C A X b Y Z t", machine.load("data/machines/ac_table.toml"))
    Structure(workpiece='X', tool='YZ')
    """
    words = text.split()
    tables = [rotary.name for rotary in machine.rotary if rotary.carries == "workpiece"]
    heads = [rotary.name for rotary in machine.rotary if rotary.carries == "tool"]
    expected = f"a code such as {' '.join(['w', *reversed(tables), 'b X Y Z', *heads, 't'])}"
    if sorted(words) != sorted(["w", "b", "t", *machine.joint_names]) or (words[0], words[-1]) != ("w", "t"):
        raise InputError(where, expected, repr(text))
    bed = words.index("b")
    workpiece, tool = list(reversed(words[1:bed])), words[bed + 1 : -1]
    slides = [len(workpiece) - len(tables), len(tool) - len(heads)]
    if workpiece[slides[0] :] != tables or tool[slides[1] :] != heads:
        raise InputError(where, expected, repr(text))
    return Structure("".join(workpiece[: slides[0]]), "".join(tool[: slides[1]]))


def names(machine):
    """Names of the 33 errors: six for each joint in joint order, then squareness."""
    return (*(f"E{component}{joint}" for joint in machine.joint_names for component in COMPONENTS), *SQUARENESS)


class ErrorModel:
    """The chain of a machine with its errors as symbols, its derivatives, and both compiled.

    Parameters
    ----------
    machine : mathpost.machine.Machine
    structure : Structure
        Where the slides stand; by default the tool side carries X, then Y, then Z.

    Attributes
    ----------
    joints : tuple of 5 sympy symbols
    errors : tuple of 33 sympy symbols
        In the order of `names`.

    Examples
    --------
    >>> from mathpost import machine
    >>> model = ErrorModel(machine.load("data/machines/ac_table.toml"))
    >>> [link.name for link in model.links()]
    ['workpiece', 'C', 'error C', 'A', 'error A', 'X', 'error X', ..., 'programmed', 'tool']
    >>> sp.Matrix(model.sensitivity("EXC"))[:3, 0].subs({model.joints[3]: 0})
    Matrix([
    [-cos(C)],
    [-sin(C)],
    [      0]])
    """

    def __init__(self, machine, structure=DEFAULT):
        self.machine, self.structure = machine, structure
        self.names = names(machine)
        self.joints = chain.joint_symbols(machine)
        self.errors = sp.symbols(self.names, real=True)
        self.symbol = dict(zip(self.names, self.errors, strict=True))

    def links(self):
        """Return the chain from the workpiece to the tool as a list of `mathpost.chain.Link`."""
        data = chain.Geometry.numbers(self.machine)
        ideal = {link.name: link for link in chain.links(self.machine)}
        tables, heads = [], []
        for rotary, _, sign in chain.between(self.machine):
            point = data.point[rotary.name]
            if sign < 0:
                tables += [ideal[rotary.name], self._error(rotary.name, point, inverse=True)]
            else:
                heads += [self._error(rotary.name, point), ideal[rotary.name]]
        for name in reversed(self.structure.workpiece):
            tables += [self._error(name, inverse=True), self._slide(name, data)]
        slides = [link for name in self.structure.tool for link in (self._slide(name, data), self._error(name))]
        programmed = chain.Link("programmed", chain.homogeneous(sp.eye(3), -data.programmed_point))
        return [ideal["workpiece"], *tables, *slides, programmed, *heads, ideal["tool"]]

    def _slide(self, name, data):
        """Travel along a path that squareness errors turn: a workpiece slide runs the other way, backwards."""
        index = "XYZ".index(name)
        turned = sp.Matrix([self.symbol.get(f"E{axis}0{name}", 0) for axis in "ABC"])
        path = sp.eye(3)[:, index] + turned.cross(sp.eye(3)[:, index])
        return chain.Link(name, chain.homogeneous(sp.eye(3), (data.origin[index] + self.joints[index]) * path))

    def _error(self, name, point=None, inverse=False):
        """The error frame of a joint at `point`; of a slide, at the place that the slide itself has carried."""
        point = sp.zeros(3, 1) if point is None else point
        return chain.Link(
            f"error {name}", error_frame([self.symbol[f"E{c}{name}"] for c in COMPONENTS], point, inverse)
        )

    @cached_property
    def forward_symbolic(self):
        """The 4×4 matrix workpiece_from_tool in the symbols of joints and errors."""
        return sp.ImmutableMatrix(chain.product(link.matrix for link in self.links()))

    @cached_property
    def _ideal(self):
        return dict.fromkeys(self.errors, sp.S.Zero)

    @cached_property
    def _partial(self):
        """Each link without errors, and the products of those before and behind it."""
        links = self.links()
        matrices = [link.matrix.xreplace(self._ideal) for link in links]
        before, behind = [sp.eye(4)], [matrices[-1][:, 2:]]
        for matrix in matrices[:-1]:
            before.append(before[-1] * matrix)
        for matrix in reversed(matrices[:-1]):
            behind.append(matrix * behind[-1])
        return links, before, behind[::-1]

    def sensitivity(self, name):
        """Return how tip and tool axis move for one unit of the error or the joint `name`, without errors.

        The derivative of the chain is the derivative of the one link that holds the symbol, between the products
        of the others.

        Returns
        -------
        sympy.ImmutableMatrix, shape (6, 1)
            Tip, then axis, in the workpiece.
        """
        symbol = self.symbol.get(name) or dict(zip(self.machine.joint_names, self.joints, strict=True))[name]
        links, before, behind = self._partial
        moved = sp.zeros(4, 2)
        for index, link in enumerate(links[:-1]):
            if symbol in link.matrix.free_symbols:
                moved += before[index] * link.matrix.diff(symbol).xreplace(self._ideal) * behind[index + 1]
        return sp.ImmutableMatrix([*moved[:3, 1], *moved[:3, 0]])

    def forward(self, joints, errors):
        """Return the pose that the real machine takes.

        Parameters
        ----------
        joints : array_like, shape (..., 5)
            mm and radians.
        errors : array_like, shape (..., 33)
            In the order of `names`; mm and radians.

        Returns
        -------
        tip, axis : ndarray, shape (..., 3)
        """
        joints, errors = as_array(joints, 5, "joints"), as_array(errors, len(self.names), "errors")
        pose = self._forward(*np.moveaxis(joints, -1, 0), *np.moveaxis(errors, -1, 0))
        return pose[..., :3], pose[..., 3:]

    def jacobian(self, joints):
        """Return d(tip, axis)/d(joints) of the ideal machine, shape (..., 6, 5), at `joints` in radians."""
        return self._jacobian(*np.moveaxis(as_array(joints, 5, "joints"), -1, 0))

    def sensitivities(self, joints):
        """Return d(tip, axis)/d(errors) of the ideal machine, shape (..., 6, 33), at `joints` in radians."""
        return self._sensitivities(*np.moveaxis(as_array(joints, 5, "joints"), -1, 0))

    @cached_property
    def _forward(self):
        matrix = self.forward_symbolic
        return numeric((*matrix[:3, 3], *matrix[:3, 2]), (*self.joints, *self.errors))

    @cached_property
    def _jacobian(self):
        columns = sp.Matrix.hstack(*(self.sensitivity(name) for name in self.machine.joint_names))
        return numeric(sp.ImmutableMatrix(columns), self.joints)

    @cached_property
    def _sensitivities(self):
        columns = sp.Matrix.hstack(*(self.sensitivity(name) for name in self.names))
        return numeric(sp.ImmutableMatrix(columns), self.joints)


def error_frame(errors, point, inverse=False):
    """The 4×4 matrix of six errors about `point`: displacement, and the turn Rz·Ry·Rx.

    Written out as in section D of the derivations, so that the exact matrix, not a skew one, stands in the chain.
    """
    *displacement, roll, pitch, yaw = errors
    turned = ACTIVE["Z"](yaw) * ACTIVE["Y"](pitch) * ACTIVE["X"](roll)
    shift = sp.Matrix(displacement) + point - turned * point
    return chain.homogeneous(turned.T, -turned.T * shift) if inverse else chain.homogeneous(turned, shift)
