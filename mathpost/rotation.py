"""Rotations as matrices: elementary, and about any axis.

Matrices act on column vectors. An *active* matrix turns a vector, right-handed, in a fixed frame; the
*passive* one is its transpose and gives the coordinates of a fixed point in the turned frame. The elementary
matrices are sympy's own, so that no rotation matrix is typed here.
"""

import numpy as np
import sympy as sp
from numpy.typing import ArrayLike
from sympy.matrices import rot_axis1, rot_axis2, rot_axis3, rot_ccw_axis1, rot_ccw_axis2, rot_ccw_axis3

from mathpost.errors import InputError, as_array

ACTIVE = {"X": rot_ccw_axis1, "Y": rot_ccw_axis2, "Z": rot_ccw_axis3}
PASSIVE = {"X": rot_axis1, "Y": rot_axis2, "Z": rot_axis3}
ORTHONORMAL = 2e-6  # error of an orthonormal matrix printed with six decimals
SHORTEST = 1e-9  # a vector no longer than this has no direction


def about(axis: sp.Matrix, angle: sp.Expr) -> sp.Matrix:
    """Return the active rotation by `angle` about the unit vector `axis` (Rodrigues), symbolically.

    Written as c·I + (1 − c)·v·vᵀ + s·[v]×, the form in which source 002 expands its tilted B axis. The angle is in
    radians, right-handed; symbols are taken to be a unit vector. Returns a sympy.Matrix, shape (3, 3).

    Examples
    --------
    >>> t = sp.Symbol("t")
    >>> about((0, 0, 1), t) == ACTIVE["Z"](t)
    True
    """
    v = sp.Matrix(axis)
    cosine, sine = sp.cos(angle), sp.sin(angle)
    return cosine * sp.eye(3) + (1 - cosine) * v * v.T + sine * v.hat()


def as_rotation(matrix: ArrayLike, where: str = "rotation") -> np.ndarray:
    """Return `matrix` as a float array of shape (..., 3, 3) if it is a rotation, or raise `InputError`.

    Rounding to six decimals is accepted, and left as it is.
    """
    array = as_array(matrix, 3, where)
    if array.shape[-2:] != (3, 3):
        raise InputError(where, "shape (..., 3, 3)", f"shape {array.shape}")
    off = np.abs(np.swapaxes(array, -1, -2) @ array - np.eye(3)).max(axis=(-2, -1))
    index = tuple(map(int, np.unravel_index(off.argmax(), off.shape)))
    if off[index] > ORTHONORMAL:
        raise InputError(where, "orthonormal axes", f"MᵀM off the identity by {off[index]:.3g}{_at(index)}")
    determinant = np.linalg.det(array)
    if (determinant < 0).any():
        index = tuple(map(int, np.argwhere(determinant < 0)[0]))
        raise InputError(where, "a right-handed frame", f"a left-handed one, determinant -1{_at(index)}")
    return array


def unit(vectors: ArrayLike, where: str = "axis") -> np.ndarray:
    """Return `vectors`, shape (..., n), scaled to length 1; raise `InputError` for one of length zero."""
    vectors = np.asarray(vectors)
    length = np.sqrt(np.einsum("...i,...i->...", vectors, vectors))
    if not (length > SHORTEST).all():
        index = tuple(map(int, np.argwhere(length <= SHORTEST)[0]))
        raise InputError(where, "a vector with a direction", f"one of length zero{_at(index)}")
    return vectors / length[..., None]


def angle_of_chord(chord: ArrayLike) -> np.ndarray:
    """Return the angles (radians) between unit vectors whose ends are a `chord` apart.

    It keeps the digits that the arccosine of their product loses.
    """
    return 2 * np.arcsin(np.minimum(np.asarray(chord) / 2, 1))


def wrap(angles: ArrayLike, turn: float = 360.0) -> np.ndarray:
    """Return `angles` less whole turns, in (−turn/2, turn/2]; one within 1e-12 turns of −turn/2 is turn/2.

    Examples
    --------
    >>> wrap([190.0, -180.0, 540.0])
    array([-170.,  180.,  180.])
    """
    angles = np.asarray(angles, dtype=float)
    return angles - turn * np.ceil(angles / turn - 0.5 - 1e-12)


def _at(index: tuple[int, ...]) -> str:
    return f" at index {index}" if index else ""
