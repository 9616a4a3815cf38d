"""A rotation as an axis and an angle, and as a quaternion, to and from the active matrix."""

from functools import lru_cache

import numpy as np
import sympy as sp

from mathpost.errors import as_array
from mathpost.rotation import about, as_rotation, numeric, unit


def from_axis_angle(axis, angle, *, degrees=False):
    """Return the active matrix of a turn about `axis`: `about`, compiled.

    Parameters
    ----------
    axis : array_like, shape (..., 3)
        Of any length above zero.
    angle : array_like, shape (...)
        Right-handed about `axis`; radians unless `degrees`.

    Returns
    -------
    ndarray, shape (..., 3, 3)

    Raises
    ------
    InputError
        If an argument is not finite numbers of that shape or an axis has no length.

    Examples
    --------
    >>> (from_axis_angle([1, 1, 1], 120, degrees=True) @ [1, 0, 0]).round(12) + 0.0
    array([0., 1., 0.])
    """
    axis, angle = unit(as_array(axis, 3, "axis")), as_array(np.expand_dims(angle, -1), 1, "angle")[..., 0]
    *v, t = sp.symbols("v_x v_y v_z t", real=True)
    turn = numeric(sp.ImmutableMatrix(about(v, t)), (*v, t))
    return turn(*np.moveaxis(axis, -1, 0), np.deg2rad(angle) if degrees else angle)


def to_axis_angle(matrix, *, degrees=False):
    """Return the axis and the angle in [0, π] of an active matrix.

    No turn at all has axis Z; of the two axes of a half turn the one is given whose first entry that is not
    zero is positive.

    Parameters
    ----------
    matrix : array_like, shape (..., 3, 3)

    Returns
    -------
    axis : ndarray, shape (..., 3)
        Unit vectors.
    angle : ndarray, shape (...)
        Radians unless `degrees`.

    Raises
    ------
    InputError
        If `matrix` is not a rotation, as `as_rotation` tells.

    Examples
    --------
    >>> axis, angle = to_axis_angle([[0, 0, 1], [1, 0, 0], [0, 1, 0]], degrees=True)
    >>> axis.round(6), angle.round(6)
    (array([0.57735, 0.57735, 0.57735]), np.float64(120.0))
    """
    quaternion = to_quaternion(matrix)
    sine = np.linalg.norm(quaternion[..., 1:], axis=-1)
    turned = (sine > 0)[..., None]
    axis = np.where(turned, quaternion[..., 1:] / np.where(turned, sine[..., None], 1), [0.0, 0.0, 1.0])
    angle = 2 * np.arctan2(sine, quaternion[..., 0])
    return axis, np.rad2deg(angle) if degrees else angle


def from_quaternion(quaternion):
    """Return the active matrix of a quaternion w + xi + yj + zk, given as (w, x, y, z), *scalar first*.

    Parameters
    ----------
    quaternion : array_like, shape (..., 4)
        Of any length above zero; q and −q are the same rotation.

    Returns
    -------
    ndarray, shape (..., 3, 3)

    Raises
    ------
    InputError
        If the numbers are not finite, not four, or all zero.

    Examples
    --------
    >>> (from_quaternion([1, 0, 0, 1]) @ [1, 0, 0]).round(12) + 0.0  # 90 degrees about Z
    array([0., 1., 0.])
    """
    quaternion = unit(as_array(quaternion, 4, "quaternion"), "quaternion")
    return numeric(_QUATERNION_MATRIX, _QUATERNION)(*np.moveaxis(quaternion, -1, 0))


def to_quaternion(matrix):
    """Return the unit quaternion (w, x, y, z), scalar first, of an active matrix.

    Of q and −q the one with w > 0, or at a half turn the one whose first entry that is not zero is positive.
    Parameters and errors are those of `to_axis_angle`; the result has shape (..., 4).

    Examples
    --------
    >>> to_quaternion([[0, -1, 0], [1, 0, 0], [0, 0, 1]]).round(6) + 0.0
    array([0.707107, 0.      , 0.      , 0.707107])
    """
    entries = np.moveaxis(as_rotation(matrix).reshape(*np.shape(matrix)[:-2], 9), -1, 0)
    products = numeric(_quaternion_products(), _ENTRIES)(*entries)
    # Every row is q times one of its own entries: the row of the greatest loses no digits.
    greatest = np.diagonal(products, axis1=-2, axis2=-1).argmax(axis=-1)
    quaternion = np.take_along_axis(products, greatest[..., None, None], axis=-2)[..., 0, :]
    quaternion /= np.linalg.norm(quaternion, axis=-1, keepdims=True)
    quaternion[np.abs(quaternion) < 1e-16] = 0.0
    first = np.take_along_axis(quaternion, (quaternion != 0).argmax(axis=-1)[..., None], axis=-1)
    return quaternion * np.sign(first)


_QUATERNION = sp.symbols("w x y z", real=True)
_QUATERNION_MATRIX = sp.ImmutableMatrix(
    sp.Quaternion(*_QUATERNION).to_rotation_matrix(homogeneous=True).subs(sum(q**2 for q in _QUATERNION), 1)
)  # of length 1
_ENTRIES = sp.symbols("m:3:3", real=True)


@lru_cache(maxsize=1)
def _quaternion_products():
    """4·q·qᵀ in the nine entries of the matrix of q, found by comparing coefficients."""
    q = sp.Matrix(_QUATERNION)
    products = list(q * q.T)
    names = {product: sp.Symbol(f"q{n}") for n, product in enumerate(dict.fromkeys(products))}
    known = [q.dot(q) - 1, *(_QUATERNION_MATRIX - sp.Matrix(3, 3, _ENTRIES))]
    found = sp.solve([sp.expand(equation).subs(names) for equation in known], list(names.values()), dict=True)[0]
    return sp.ImmutableMatrix(4, 4, [4 * found[names[product]] for product in products])
