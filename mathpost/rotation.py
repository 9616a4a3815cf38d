"""Rotations as matrices: elementary, about any axis, and the two ZXZ recipes of source 000.

Matrices act on column vectors. An *active* matrix turns a vector, right-handed, in a fixed frame; the
*passive* one is its transpose and gives the coordinates of a fixed point in the turned frame. The elementary
matrices are sympy's own, so that no rotation matrix is typed here.
"""

from functools import lru_cache

import numpy as np
import sympy as sp
from sympy.matrices import rot_axis1, rot_axis2, rot_axis3, rot_ccw_axis1, rot_ccw_axis2, rot_ccw_axis3

from mathpost.errors import InputError

ACTIVE = {"X": rot_ccw_axis1, "Y": rot_ccw_axis2, "Z": rot_ccw_axis3}
PASSIVE = {"X": rot_axis1, "Y": rot_axis2, "Z": rot_axis3}


def about(axis, angle):
    """Return the active rotation by `angle` about the unit vector `axis` (Rodrigues), symbolically.

    Written as c·I + (1 − c)·v·vᵀ + s·[v]×, the form in which source 002 expands its tilted B axis.

    Parameters
    ----------
    axis : sequence of 3 sympy expressions
        A unit vector; symbols are taken to be one.
    angle : sympy expression
        Radians, right-handed about `axis`.

    Returns
    -------
    sympy.Matrix, shape (3, 3)

    Examples
    --------
    >>> t = sp.Symbol("t")
    >>> about((0, 0, 1), t) == ACTIVE["Z"](t)
    True
    """
    v = sp.Matrix(axis)
    cosine, sine = sp.cos(angle), sp.sin(angle)
    return cosine * sp.eye(3) + (1 - cosine) * v * v.T + sine * v.hat()


def zxz_right(alpha, beta, gamma, *, degrees=False):
    """Return the passive ZXZ matrix by the first recipe of source 000: E_z(γ)·E_x(β)·E_z(α).

    It takes the coordinates of a fixed point from the initial frame into the frame that was turned by α about
    Z, by β about the new X and by γ about the newest Z. E are passive elementary matrices; the product grows
    on the *left*, which the source calls right multiplication (右乘).

    Parameters
    ----------
    alpha, beta, gamma : float, array_like or sympy expression
        The angles, broadcast against each other. Radians unless `degrees`.
    degrees : bool, keyword only

    Returns
    -------
    numpy.ndarray, shape (..., 3, 3), or sympy.Matrix if any angle is a sympy expression

    Raises
    ------
    InputError
        If an angle is not a number.

    Examples
    --------
    >>> (zxz_right(135, 54.7356, -90, degrees=True) @ [3, 4, 5]).round(6)
    array([-1.224744,  0.707107,  6.928203])
    """
    return _from_angles(_right, (alpha, beta, gamma), degrees)


def zxz_left_transposed(alpha, beta, gamma, *, degrees=False):
    """Return the passive ZXZ matrix by the second recipe of source 000: (E_z(−α)·E_x(−β)·E_z(−γ))ᵀ.

    Parameters, result and errors are those of `zxz_right`. The two agree identically, whichever elementary
    matrices are used, because E(−t)ᵀ = E(t): their agreement proves nothing about E.

    Examples
    --------
    >>> a, b, c = sp.symbols("alpha beta gamma")
    >>> zxz_left_transposed(a, b, c) == zxz_right(a, b, c)
    True
    """
    return _from_angles(_left_transposed, (alpha, beta, gamma), degrees)


def _right(alpha, beta, gamma, elementary=PASSIVE):
    return elementary["Z"](gamma) * elementary["X"](beta) * elementary["Z"](alpha)


def _left_transposed(alpha, beta, gamma, elementary=PASSIVE):
    return (elementary["Z"](-alpha) * elementary["X"](-beta) * elementary["Z"](-gamma)).T


def _from_angles(build, angles, degrees):
    """Apply the symbolic `build` to angles that are numbers, arrays or sympy expressions."""
    if any(isinstance(angle, sp.Basic) for angle in angles):
        return build(*(sp.sympify(angle) * (sp.pi / 180 if degrees else 1) for angle in angles))
    symbols = sp.symbols(f"angle:{len(angles)}", real=True)
    try:
        values = [np.asarray(angle, dtype=float) for angle in angles]
    except (TypeError, ValueError):
        raise InputError("angles", "numbers, arrays or sympy expressions", repr(angles)) from None
    matrix = numeric(sp.ImmutableMatrix(build(*symbols)), symbols)
    return matrix(*(map(np.deg2rad, values) if degrees else values))


@lru_cache(maxsize=256)
def numeric(expression, arguments):
    """Compile a sympy expression into a vectorised NumPy function; the one place that calls `lambdify`.

    Parameters
    ----------
    expression : sympy expression, ImmutableMatrix or tuple of expressions
    arguments : tuple of sympy symbols

    Returns
    -------
    callable
        Takes one number or array for each argument, broadcast against each other to shape ``(...)``, and
        returns a float array of shape ``(...)``, ``(..., rows, columns)`` or ``(..., len(tuple))``.

    Examples
    --------
    >>> x = sp.Symbol("x")
    >>> numeric((sp.cos(x), sp.S(1)), (x,))([0, np.pi])
    array([[ 1.,  1.],
           [-1.,  1.]])
    """
    if isinstance(expression, tuple):
        shape, entries = (len(expression),), expression
    else:
        shape = getattr(expression, "shape", ())
        entries = tuple(expression) if shape else (expression,)
    kernel = sp.lambdify(arguments, [_in_floats(sp.sympify(entry)) for entry in entries], "numpy", cse=True)

    def evaluate(*values):
        values = np.broadcast_arrays(*(np.asarray(value, dtype=float) for value in values))
        result = np.empty((*values[0].shape, len(entries)))
        for index, entry in enumerate(kernel(*values)):
            result[..., index] = entry
        return result.reshape((*values[0].shape, *shape))

    return evaluate


def _in_floats(expression):
    """Return `expression` with its exact constants (√2/2, long fractions) evaluated, exponents left alone."""
    if expression.is_Integer and abs(expression) < 2**53:
        return expression
    if expression.is_number:
        return sp.N(expression, 30)
    if expression.is_Pow:
        return sp.Pow(_in_floats(expression.base), expression.exp)
    return expression.func(*map(_in_floats, expression.args)) if expression.args else expression
