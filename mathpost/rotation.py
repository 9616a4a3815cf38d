"""Rotations as matrices: elementary, about any axis, and the two ZXZ recipes of source 000, step by step.

Matrices act on column vectors. An *active* matrix turns a vector, right-handed, in a fixed frame; the
*passive* one is its transpose and gives the coordinates of a fixed point in the turned frame. The elementary
matrices are sympy's own, so that no rotation matrix is typed here.
"""

import math
from collections import Counter
from dataclasses import dataclass
from functools import lru_cache, partial

import numpy as np
import sympy as sp
from sympy.matrices import rot_axis1, rot_axis2, rot_axis3, rot_ccw_axis1, rot_ccw_axis2, rot_ccw_axis3
from sympy.printing.numpy import NumPyPrinter

from mathpost.errors import InputError, as_array

ACTIVE = {"X": rot_ccw_axis1, "Y": rot_ccw_axis2, "Z": rot_ccw_axis3}
PASSIVE = {"X": rot_axis1, "Y": rot_axis2, "Z": rot_axis3}
ORTHONORMAL = 2e-6  # what six printed decimals leave of an orthonormal matrix
SHORTEST = 1e-9  # a vector no longer than this has no direction
SLICE = 16384  # elements that a formula works on at a time


def about(axis, angle):
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


def as_rotation(matrix, where="rotation"):
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


def unit(vectors, where="axis"):
    """Return `vectors`, shape (..., n), with length 1; raise `InputError` where one has none."""
    length = np.sqrt(np.einsum("...i,...i->...", vectors, vectors))
    if not (length > SHORTEST).all():
        index = tuple(map(int, np.argwhere(length <= SHORTEST)[0]))
        raise InputError(where, "a vector with a direction", f"one of length zero{_at(index)}")
    return vectors / length[..., None]


def wrap(angles, turn=360.0):
    """Return `angles` less whole turns, in (−turn/2, turn/2]; what is 1e-12 turns above the open end is the other.

    Examples
    --------
    >>> wrap([190.0, -180.0, 540.0])
    array([-170.,  180.,  180.])
    """
    angles = np.asarray(angles, dtype=float)
    return angles - turn * np.ceil(angles / turn - 0.5 - 1e-12)


def _at(index):
    return f" at index {index}" if index else ""


def zxz_right(alpha, beta, gamma, *, degrees=False):
    """Return the passive ZXZ matrix by the first recipe of source 000: E_z(γ)·E_x(β)·E_z(α).

    It takes the coordinates of a fixed point from the initial frame into the frame that was turned by α about
    Z, by β about the new X and by γ about the newest Z. E are passive elementary matrices; the product grows
    on the *left*, which the source calls right multiplication (右乘).

    Parameters
    ----------
    alpha, beta, gamma : float, array_like or sympy expression
        Broadcast against each other; radians unless `degrees`. `InputError` is raised if one is not a number.

    Returns
    -------
    numpy.ndarray, shape (..., 3, 3), or sympy.Matrix if any angle is a sympy expression

    Examples
    --------
    >>> (zxz_right(135, 54.7356, -90, degrees=True) @ [3, 4, 5]).round(6)
    array([-1.224744,  0.707107,  6.928203])
    """
    return from_angles(_result(_right), (alpha, beta, gamma), degrees)


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
    return from_angles(_result(_left), (alpha, beta, gamma), degrees)


@dataclass(frozen=True)
class Step:
    """One step of a recipe of source 000: its number and name there, and the angles, matrix or point it yields."""

    number: int
    name: str
    value: np.ndarray | sp.Matrix


def zxz_steps(recipe, angles, point, *, elementary=PASSIVE, degrees=False):
    """Return all the steps of one recipe of source 000 as a list of `Step`, numbered as in the source.

    Parameters
    ----------
    recipe : str
        ``"right"``: α, β, γ, γβ, γβα, the new point. ``"left"``: the negated angles, α, β, γ, αβ, αβγ, its
        transpose, the new point. `InputError` is raised for any other.
    angles : sequence of 3
        α, β, γ as in `zxz_right`; sympy expressions keep every step exact.
    point : sequence of 3, or array_like of shape (..., 3)
        In the initial frame.
    elementary : dict, keyword only
        `PASSIVE`, which is right, or `ACTIVE`, to see what the other reading of "the rotation matrix" gives.

    Examples
    --------
    >>> [step.name for step in zxz_steps("left", (135, 54.7356, -90), (3, 4, 5), degrees=True)]
    ['−α, −β, −γ', 'α', 'β', 'γ', 'αβ', 'αβγ', '(αβγ)ᵀ', "x', y', z'"]
    """
    if recipe not in ("right", "left"):
        raise InputError("recipe", "one of 'right', 'left'", repr(recipe))
    build = _right if recipe == "right" else _left
    values = {"−α, −β, −γ": [-angle for angle in angles]} if recipe == "left" else {}
    for name in build(0, 0, 0):
        values[name] = from_angles(lambda a, b, c, name=name: build(a, b, c, elementary)[name], angles, degrees)
    matrix, exact = values[name], isinstance(values[name], sp.MatrixBase)
    new = matrix * sp.Matrix(point) if exact else (matrix @ as_array(point, 3, "point")[..., None])[..., 0]
    values["x', y', z'"] = new
    return [Step(number, *step) for number, step in enumerate(values.items(), 0 if recipe == "left" else 1)]


def _right(alpha, beta, gamma, elementary=PASSIVE):
    """The matrices of the first recipe by name."""
    a, b, c = elementary["Z"](alpha), elementary["X"](beta), elementary["Z"](gamma)
    return {"α": a, "β": b, "γ": c, "γβ": c * b, "γβα": c * b * a}


def _left(alpha, beta, gamma, elementary=PASSIVE):
    """The matrices of the second recipe by name."""
    a, b, c = elementary["Z"](-alpha), elementary["X"](-beta), elementary["Z"](-gamma)
    return {"α": a, "β": b, "γ": c, "αβ": a * b, "αβγ": a * b * c, "(αβγ)ᵀ": (a * b * c).T}


@lru_cache(maxsize=2)
def _result(recipe):
    return lambda *angles: [*recipe(*angles).values()][-1]


def from_angles(build, angles, degrees):
    """Apply the symbolic `build`, a function of so many angles, to numbers, arrays or sympy expressions."""
    if any(isinstance(angle, sp.Basic) for angle in angles):
        return build(*(sp.sympify(angle) * (sp.pi / 180 if degrees else 1) for angle in angles))
    try:
        values = [np.asarray(angle, dtype=float) for angle in angles]
    except (TypeError, ValueError):
        raise InputError("angles", "numbers, arrays or sympy expressions", repr(angles)) from None
    return _built(build, len(angles))(*(map(np.deg2rad, values) if degrees else values))


@lru_cache(maxsize=256)
def _built(build, count):
    symbols = sp.symbols(f"angle:{count}", real=True)
    return numeric(sp.ImmutableMatrix(build(*symbols)), symbols)


@lru_cache(maxsize=512)
def numeric(expression, arguments, named=()):
    """Compile a sympy expression into a function of NumPy arrays: the one place that does, and remembers it.

    `expression` is one expression, an ImmutableMatrix or a tuple of expressions, `arguments` a tuple of symbols,
    `named` pairs of a further symbol and what it stands for. The function takes numbers or arrays, broadcast
    against each other to shape ``(...)``, and returns a float array of shape ``(...)``, ``(..., rows, columns)`` or
    ``(..., len(tuple))``. What the entries have in common is computed once. Large arrays go through in pieces of
    `SLICE` elements, so that the intermediate results stay in the processor's cache.

    Examples
    --------
    >>> x = sp.Symbol("x")
    >>> numeric((sp.cos(x), sp.S(1)), (x,))([0, np.pi])
    array([[ 1.,  1.],
           [-1.,  1.]])
    """
    shape = (len(expression),) if isinstance(expression, tuple) else getattr(expression, "shape", ())
    entries = list(expression if shape else [expression])
    # To sort the terms, and to print the whole once more as a docstring, takes as long as all else.
    printer = NumPyPrinter({"fully_qualified_modules": False, "inline": True, "order": "none"})
    common = partial(shared, named=named)
    compiled = sp.lambdify(arguments, entries, "numpy", printer, cse=common, use_imps=False, docstring_limit=0)

    def evaluate(*values):
        values = [np.asarray(value, dtype=float) for value in values]
        if len({value.shape for value in values if value.ndim}) > 1:
            values = np.broadcast_arrays(*values)
        over = max((value.shape for value in values), key=len)  # a single number among arrays stays one
        flat = [value.reshape(-1) if value.ndim else value for value in values]
        result = np.empty((len(entries), math.prod(over)))
        for rows in slices(result.shape[1:]):
            for index, entry in enumerate(compiled(*(value[rows] if value.ndim else value for value in flat))):
                result[index, rows] = entry
        return result.T.reshape(*over, *shape)

    return evaluate


def slices(shape):
    """Yield slices of the first axis of `shape` that take about `SLICE` elements each."""
    step = max(1, SLICE // max(1, math.prod(shape[1:])))
    for start in range(0, shape[0], step):
        yield slice(start, start + step)


def shared(expressions, symbols=None, named=()):
    """Take apart what expressions have in common: pairs of a symbol and its value, and the expressions in these.

    Exact constants (√2/2, long fractions) are evaluated, exponents left alone. Unlike `sympy.cse` it looks for
    equal parts only, and lets sympy simplify nothing again, which takes most of the time there. Symbols that are
    `named`, pairs of a symbol and its meaning, give way to that.
    """
    meaning = dict(named)

    def parts(expression):
        return [meaning.get(part, part) for part in _parts(expression)]

    expressions = [meaning.get(entry, entry) for entry in map(sp.sympify, expressions)]
    symbols = symbols or sp.numbered_symbols("common")
    uses, left, built, pairs = Counter(expressions), [*dict.fromkeys(expressions)], {}, []
    while left:
        for part in parts(left.pop()):
            uses[part] += 1
            if uses[part] == 1:
                left.append(part)

    def build(part):
        if part not in built:
            built[part] = new = _put_together(part, [build(each) for each in parts(part)])
            if uses[part] > 1 and new.args and isinstance(new, sp.Expr):  # no condition, no case of a Piecewise
                built[part] = next(symbols)
                pairs.append((built[part], new))
        return built[part]

    return pairs, [build(entry) for entry in expressions]


def _parts(expression):
    """What an expression is made of: of a constant nothing, of a product the constant factor and the rest."""
    if not expression.args or expression.is_number:
        return ()
    if expression.is_Pow:
        return expression.args[:1]
    if expression.is_Mul and any(factor.is_number for factor in expression.args):
        constant = [factor for factor in expression.args if factor.is_number]
        rest = [factor for factor in expression.args if not factor.is_number]
        return sp.Mul(*constant), sp.Mul(*rest, evaluate=False)
    return expression.args


def _put_together(expression, parts):
    """An expression of these parts as they stand; a constant as a float, but for whole numbers that one holds."""
    if not parts:
        exact = not expression.is_number or (expression.is_Integer and abs(expression) < 2**53)
        return expression if exact else sp.N(expression, 30)
    if expression.is_Pow:
        return sp.Pow(*parts, expression.exp, evaluate=False)
    # A condition knows no such choice.
    as_it_stands = {"evaluate": False} if isinstance(expression, sp.Expr) else {}
    return expression.func(*parts, **as_it_stands)
