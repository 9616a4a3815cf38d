"""The effect of a tool other than the one that the CL data were made for, and how to compensate it.

A cutter is a disc with a rounded rim: ball (rim radius = half the diameter), flat (rim radius 0) or bull nose in
between. It touches the surface where its rim has the surface's normal: contact point, normal and tool axis give the
tip of any cutter.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import sympy as sp
from numpy.typing import ArrayLike

from mathpost.errors import InputError, as_array
from mathpost.formula import numeric
from mathpost.rotation import unit

if TYPE_CHECKING:
    from mathpost.kinematics import Kinematics

NORMAL, AXIS = sp.symbols("n_x n_y n_z", real=True), sp.symbols("i j k", real=True)
RADIUS, RIM, SINE = sp.symbols("R r s", nonnegative=True)
BOTTOM = 1e-9  # sine of the angle from normal to axis below which the cutter's flat bottom touches


@dataclass(frozen=True)
class Cutter:
    """A cutter by its diameter and the radius of its rim, mm."""

    diameter: float
    rim: float

    def __post_init__(self) -> None:
        if not 0 <= self.rim <= self.diameter / 2 or not 0 < self.diameter < np.inf:
            found = f"diameter {self.diameter}, rim {self.rim}"
            raise InputError("cutter", "a diameter above 0 and a rim radius from 0 to half of it", found)

    @classmethod
    def ball(cls, diameter: float) -> Cutter:
        return cls(diameter, diameter / 2)

    @classmethod
    def flat(cls, diameter: float) -> Cutter:
        return cls(diameter, 0.0)


def tip_symbolic() -> sp.Matrix:
    """Return tip minus contact point, 3×1, for surface normal n, tool axis (i, j, k), radius R and rim radius r.

    r·n + (R − r)·m − r·a, where m is the part of n square to the axis a, scaled to length 1 by s = ``|n × a|``.

    Examples
    --------
    >>> ball = tip_symbolic().subs(RIM, RADIUS)
    >>> sp.simplify(ball - RADIUS * (sp.Matrix(NORMAL) - sp.Matrix(AXIS))).T
    Matrix([[0, 0, 0]])
    """
    n, a = sp.Matrix(NORMAL), sp.Matrix(AXIS)
    radial = (n - n.dot(a) * a) / SINE
    return sp.ImmutableMatrix(RIM * n + (RADIUS - RIM) * radial - RIM * a)


def tip_from_contact(cutter: Cutter, normal: ArrayLike, axis: ArrayLike) -> np.ndarray:
    """Return the tool tip minus the contact point, shape (..., 3), mm.

    `normal`, out of the part, and `axis`, from the tip towards the spindle, have the shape (..., 3) and any length.
    Where they coincide the flat bottom touches everywhere, and its middle is returned. `InputError` if a normal
    points away from the cutter.

    Examples
    --------
    >>> tip_from_contact(Cutter(diameter=10, rim=1), normal=[1, 0, 1], axis=[0, 0, 1]).round(4)
    array([ 4.7071,  0.    , -0.2929])
    """
    normal, axis = unit(as_array(normal, 3, "normal"), "normal"), unit(as_array(axis, 3, "axis"))
    normal, axis = np.broadcast_arrays(normal, axis)
    away = (normal * axis).sum(axis=-1) < -1e-9
    if away.any():
        index = tuple(int(n) for n in np.argwhere(away)[0])
        raise InputError("normal", "within 90° of the tool axis", f"one that points away from it at index {index}")
    sine = np.linalg.norm(np.cross(normal, axis), axis=-1)
    # On the flat bottom there is no radial direction: its radius does not count, and any divisor will do.
    bottom = sine < BOTTOM
    arguments = (*np.moveaxis(normal, -1, 0), *np.moveaxis(axis, -1, 0))
    evaluate = numeric(tip_symbolic(), (*NORMAL, *AXIS, RADIUS, RIM, SINE))
    radius = np.where(bottom, cutter.rim, cutter.diameter / 2)
    return evaluate(*arguments, radius, cutter.rim, np.where(bottom, 1.0, sine))[..., 0]


def compensated(tip: ArrayLike, normal: ArrayLike, axis: ArrayLike, old: Cutter, new: Cutter) -> np.ndarray:
    """Return the tips for another cutter that touches the same surface points: 3-D radius compensation.

    `tip`, `normal` and `axis`, shape (..., 3), are CL points made for the cutter `old`, mm, their normals and axes.
    """
    tip = as_array(tip, 3, "tip")
    return tip - tip_from_contact(old, normal, axis) + tip_from_contact(new, normal, axis)


def stock_left(normal: ArrayLike, axis: ArrayLike, old: Cutter, new: Cutter, *, longer: float = 0.0) -> np.ndarray:
    """Return how much material is left on the surface if `new` runs the CL data of `old`; negative is a gouge.

    The result, shape (...), is mm along the normal: exact on a plane, else to first order in the difference of
    cutters. `longer`, shape (...), is by how much the new tip lies further from the spindle than believed, mm.
    """
    n, a = unit(as_array(normal, 3, "normal"), "normal"), unit(as_array(axis, 3, "axis"))
    short = tip_from_contact(old, n, a) - tip_from_contact(new, n, a) - np.asarray(longer)[..., None] * a
    return (short * n).sum(axis=-1)


def tip_shift(kin: Kinematics, joints: ArrayLike, longer: float, told: str, *, degrees: bool = False) -> np.ndarray:
    """Return the displacement, in the part, of the tip of a tool that is `longer`, mm: (..., 3), mm.

    `kin` is a `mathpost.kinematics.Kinematics`; `joints`, shape (..., 5), were made for the old tool. `told` is
    what the control knows: ``"tcp"``, the new length, with TCP; ``"length offset"``, the new length without TCP, so
    that it moves the slides back along the tool's direction at rotary zero (G43); or ``"nothing"``.
    """
    joints = np.asarray(joints, dtype=float)
    _, axis = kin.forward(joints, degrees=degrees)
    if told == "tcp":
        return np.zeros_like(axis)
    if told == "nothing":
        return -longer * axis
    if told != "length offset":
        raise InputError("told", '"tcp", "length offset" or "nothing"', repr(told))
    heads = [rotary.carries == "tool" for rotary in kin.machine.rotary]
    upright = joints * np.where([False, False, False, *heads], 0.0, 1.0)
    return longer * (kin.forward(upright, degrees=degrees)[1] - axis)
