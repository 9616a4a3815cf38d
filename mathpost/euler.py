"""A rotation as three angles in sequence, as an axis and an angle, and as a quaternion, to and from the matrix.

A `sequence` is named as in SciPy: upper case, one of `SEQUENCES`, turns about the axes as already turned
(``"ZXZ"``: Z, new X, newest Z; intrinsic), the same in lower case about the fixed ones (``"xyz"``; extrinsic).
Three angles are given in the order of the sequence, shape (..., 3), radians unless `degrees`. Matrices are active,
shape (..., 3, 3): their columns are the axes of the turned frame. `InputError` is raised for an unknown sequence,
numbers that are not finite or not of the shape stated, a matrix that is no rotation and a direction of length zero.
"""

from collections.abc import Callable, Iterable
from functools import lru_cache
from itertools import product
from typing import Any

import numpy as np
import sympy as sp
from numpy.typing import ArrayLike

from mathpost.errors import InputError, as_array
from mathpost.formula import from_angles, numeric
from mathpost.rotation import ACTIVE, about, as_rotation, unit, wrap

SEQUENCES = ("ZXZ", "ZYZ", "XYX", "XZX", "YXY", "YZY", "XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX")
LOCK = 1e-13  # first and last axis are parallel if the sine between them is below this


def matrix(sequence: str, angles: Any, *, degrees: bool = False) -> np.ndarray:
    """Return the active matrix of three angles in sequence; of sympy expressions a sympy.Matrix.

    Examples
    --------
    >>> matrix("ZXZ", [135, 54.7356, -90], degrees=True).round(6)
    array([[ 0.408248, -0.707107,  0.57735 ],
           [ 0.408248,  0.707107,  0.57735 ],
           [-0.816496,  0.      ,  0.57735 ]])
    >>> matrix("ZXZ", sp.symbols("I J K"))[:, 2].T
    Matrix([[sin(I)*sin(J), -sin(J)*cos(I), cos(J)]])
    """
    letters, step = _intrinsic(sequence)
    if not any(isinstance(angle, sp.Basic) for angle in np.ravel(np.asarray(angles, dtype=object))[:3]):
        angles = np.moveaxis(as_array(angles, 3, "angles"), -1, 0)
    return from_angles(_turns(letters), tuple(angles)[::step], degrees)


def angles(sequence: str, matrix: ArrayLike, *, lock: str = "third", degrees: bool = False) -> np.ndarray:
    """Return the three angles of an active matrix, the middle one in [0, π], or [−π/2, π/2] if no axis repeats.

    Where the first and the last axis are parallel only the sum or the difference of the first and the third
    angle is defined (gimbal lock): then the one named by `lock` is 0 and the other takes it all. The angles
    always give the matrix back to rounding, even near the lock, because the third is read after the first has
    been taken off. They are in (−π, π]. `lock` is ``"first"`` or ``"third"``, counted in the order of the sequence
    as it is written.

    Examples
    --------
    >>> angles("xyz", matrix("xyz", [40, 90, 25], degrees=True), degrees=True).round(9)
    array([15., 90., 0.])
    """
    if lock not in ("first", "third"):
        raise InputError("lock", "'first' or 'third'", repr(lock))
    found = _read(sequence, lock, as_rotation(matrix, "matrix"))[0]
    return np.rad2deg(found) if degrees else found


def is_locked(sequence: str, matrix: ArrayLike) -> np.bool | np.ndarray:
    """Return whether the first and the last axis of the sequence are parallel, shape (...)."""
    return _read(sequence, "third", as_rotation(matrix, "matrix"))[1] < LOCK


def from_direction(
    sequence: str, direction: ArrayLike, third: ArrayLike = 0.0, *, degrees: bool = False
) -> np.ndarray:
    """Return the angles of the intrinsic `sequence` that turn its last axis into `direction`.

    Two angles are enough for a `direction`, shape (..., 3), of any length above zero. The third is free and
    returned as given: it turns the frame about it. Along the first axis itself the first angle is free as well,
    and 0.

    Examples
    --------
    >>> from_direction("ZXZ", [1, 1, 1], -90, degrees=True).round(6)
    array([135.      ,  54.73561, -90.      ])
    """
    if sequence not in SEQUENCES:
        raise InputError("sequence", f"one of {', '.join(SEQUENCES)}", repr(sequence))
    direction = unit(as_array(direction, 3, "direction"), "direction")
    columns = np.zeros((*direction.shape[:-1], 3, 3))
    columns[..., "XYZ".index(sequence[2])] = direction
    two = np.moveaxis(_read(sequence, "first", columns)[0], -1, 0)[:2]
    found = np.broadcast_arrays(*(np.rad2deg(two) if degrees else two), np.asarray(third, dtype=float))
    return np.stack(found, axis=-1)


def twin(sequence: str, angles: ArrayLike, *, degrees: bool = False) -> np.ndarray:
    """Return the other three angles of the same rotation, each brought into (−180°, 180°].

    The first and the third turn by 180°; the middle one changes its sign if the sequence repeats an axis, and
    goes to 180° minus itself if it does not.

    Examples
    --------
    >>> twin("ZXZ", [135, 54.7356, -90], degrees=True)
    array([-45.    , -54.7356,  90.    ])
    """
    letters, _ = _intrinsic(sequence)
    turn = 360.0 if degrees else 2 * np.pi
    first, middle, third = np.moveaxis(as_array(angles, 3, "angles"), -1, 0)
    middle = -middle if letters[0] == letters[2] else turn / 2 - middle
    return wrap(np.stack([first + turn / 2, middle, third + turn / 2], axis=-1), turn)


def _intrinsic(sequence: str) -> tuple[str, int]:
    """The intrinsic sequence that means the same, and the step through its angles: −1 if it was extrinsic."""
    if sequence in SEQUENCES:
        return sequence, 1
    if isinstance(sequence, str) and sequence.islower() and sequence[::-1].upper() in SEQUENCES:
        return sequence[::-1].upper(), -1
    expected = f"one of {', '.join(SEQUENCES)}, or the same in lower case for fixed axes"
    raise InputError("sequence", expected, repr(sequence))


@lru_cache(maxsize=12)
def _turns(letters: str) -> Callable[..., sp.Matrix]:
    i, j, k = (ACTIVE[letter] for letter in letters)
    return lambda a, b, c: i(a) * j(b) * k(c)


def _entries(matrices: np.ndarray) -> np.ndarray:
    """The nine entries, row by row, of matrices of shape (..., 3, 3): shape (9, ...)."""
    return np.moveaxis(matrices.reshape(*matrices.shape[:-2], 9), -1, 0)


def atan2_arguments(sequence: str, matrix: sp.Matrix, first: int | sp.Expr) -> list[tuple[sp.Expr, sp.Expr]]:
    """Return the arguments of the three atan2 that read the angles of an intrinsic sequence off a matrix.

    With M = R_i(a)·R_j(b)·R_k(c): column k of M is R_i(a)·R_j(b)·e_k, in which sin a and cos a have one common
    factor, sin b or cos b, which is not negative. N = R_i(−a)·M = R_j(b)·R_k(c) then shows b in its column k and c
    in its row j.

    `matrix` is a sympy.Matrix, `first` the first angle, which the other two need. Returns three pairs: sine and
    cosine of each angle, both times one factor that is not negative; that of the first pair is zero at the lock.

    Examples
    --------
    >>> atan2_arguments("ZXZ", sp.Matrix(3, 3, sp.symbols("m:3:3")), sp.Symbol("I"))[0]
    (m02, -m12)
    """
    a, b, c = sp.symbols("a b c", real=True)
    i, j, k = (ACTIVE[letter] for letter in sequence)
    row, column = "XYZ".index(sequence[1]), "XYZ".index(sequence[2])
    rest = i(-first) * matrix
    return [
        _sine_and_cosine(a, (i(a) * j(b))[:, column], matrix[:, column]),
        _sine_and_cosine(b, j(b)[:, column], rest[:, column]),
        _sine_and_cosine(c, k(c)[row, :], rest[row, :]),
    ]


def angle_expressions(sequence: str, matrix: sp.Matrix, *, lock: str = "third") -> tuple[sp.Expr, ...]:
    """Return `angles` of a symbolic matrix, the rule at the lock included, as sympy expressions.

    Four of them: the angles in the order of the sequence, radians, and the sine that is zero at the lock.
    """
    letters, step = _intrinsic(sequence)
    i, k = ("XYZ".index(letter) for letter in (letters[0], letters[2]))
    first, middle, together = atan2_arguments(letters, matrix, 0)
    sine, together = sp.sqrt(first[0] ** 2 + first[1] ** 2), sp.atan2(*together)
    # At the lock the middle angle is 0° or 180°, or ±90°, and the matrix holds third ± first, with the sign of the
    # first axis against the last.
    middle = sp.pi / 2 * (1 - sp.sign(middle[1]) if i == k else sp.sign(middle[0]))
    at_lock = (0, middle, together)
    if (lock == "third") == (step > 0):  # the third angle of the intrinsic sequence is to be 0
        at_lock = (together * sp.sign(matrix[i, k]), middle, 0)
    found = [sp.Piecewise((at_lock[0], sine < LOCK), (sp.atan2(*first), True))]
    rest = atan2_arguments(letters, matrix, found[0])[1:]
    found += [sp.Piecewise((e, sine < LOCK), (sp.atan2(*a), True)) for e, a in zip(at_lock[1:], rest, strict=True)]
    return (*found[::step], sine)


@lru_cache(maxsize=48)
def _compiled(sequence: str, lock: str) -> Callable[..., np.ndarray]:
    m = sp.Matrix(3, 3, sp.symbols("m:3:3", real=True))
    return numeric(angle_expressions(sequence, m, lock=lock), tuple(m))


def _read(sequence: str, lock: str, matrices: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The angles, shape (..., 3), of matrices of shape (..., 3, 3), and the sine that is zero at the lock."""
    _intrinsic(sequence)
    found = _compiled(sequence, lock)(*_entries(matrices))
    angles = found[..., :3]
    return np.where(angles == -np.pi, np.pi, angles) + 0.0, found[..., 3]  # atan2 gives −180° for −0


def _sine_and_cosine(
    angle: sp.Symbol, pattern: Iterable[sp.Expr], entries: Iterable[sp.Expr]
) -> tuple[sp.Expr, sp.Expr]:
    """The two of `entries` where `pattern` has the sine and the cosine of `angle`, with the pattern's signs."""
    pairs = list(zip(pattern, entries, strict=True))
    eighth = {symbol: sp.pi / 4 for symbol in sp.Matrix(pattern).free_symbols}
    return tuple(
        next(sp.sign(shown.subs(eighth)) * entry for shown, entry in pairs if shown.has(function(angle)))
        for function in (sp.sin, sp.cos)
    )


def from_axis_angle(axis: ArrayLike, angle: ArrayLike, *, degrees: bool = False) -> np.ndarray:
    """Return the active matrix of a right-handed turn about `axis`: `about`, compiled.

    Axes (..., 3), of any length above zero, and angles (...) give matrices (..., 3, 3).
    """
    axis, angle = unit(as_array(axis, 3, "axis")), as_array(np.expand_dims(angle, -1), 1, "angle")[..., 0]
    *v, t = sp.symbols("v_x v_y v_z t", real=True)
    turn = numeric(sp.ImmutableMatrix(about(v, t)), (*v, t))
    return turn(*np.moveaxis(axis, -1, 0), np.deg2rad(angle) if degrees else angle)


def to_axis_angle(matrix: ArrayLike, *, degrees: bool = False) -> tuple[np.ndarray, np.ndarray]:
    """Return the unit axis (..., 3) and the angle (...), in [0, π], of an active matrix (..., 3, 3).

    The identity has axis Z; of the two axes of a half turn, the one whose first non-zero entry is positive is
    returned.

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


def from_quaternion(quaternion: ArrayLike) -> np.ndarray:
    """Return the active matrix of a quaternion w + xi + yj + zk, given as (w, x, y, z), *scalar first*.

    Quaternions (..., 4), of any length above zero, give matrices (..., 3, 3); q and −q are the same rotation.

    Examples
    --------
    >>> (from_quaternion([1, 0, 0, 1]) @ [1, 0, 0]).round(12) + 0.0  # 90 degrees about Z
    array([0., 1., 0.])
    """
    quaternion = unit(as_array(quaternion, 4, "quaternion"), "quaternion")
    return numeric(QUATERNION_MATRIX, QUATERNION)(*np.moveaxis(quaternion, -1, 0))


def to_quaternion(matrix: ArrayLike) -> np.ndarray:
    """Return the unit quaternion (w, x, y, z), scalar first, shape (..., 4), of an active matrix (..., 3, 3).

    q and −q are the same rotation: the one with w > 0 is returned, or at a half turn the one whose first non-zero
    entry is positive.

    Examples
    --------
    >>> to_quaternion([[0, -1, 0], [1, 0, 0], [0, 0, 1]]).round(6) + 0.0
    array([0.707107, 0.      , 0.      , 0.707107])
    """
    products = numeric(_quaternion_products(), _ENTRIES)(*_entries(as_rotation(matrix)))
    # Every row is q times one of its own entries: the row of the greatest loses no digits.
    greatest = np.diagonal(products, axis1=-2, axis2=-1).argmax(axis=-1)
    quaternion = np.take_along_axis(products, greatest[..., None, None], axis=-2)[..., 0, :]
    quaternion /= np.linalg.norm(quaternion, axis=-1, keepdims=True)
    quaternion[np.abs(quaternion) < 1e-16] = 0.0
    first = np.take_along_axis(quaternion, (quaternion != 0).argmax(axis=-1)[..., None], axis=-1)
    return quaternion * np.sign(first)


QUATERNION = sp.symbols("w x y z", real=True)
_Q = sp.Quaternion(*QUATERNION)
# q·v·q* as a matrix, for q of length 1; its first row and column belong to the scalar part.
QUATERNION_MATRIX = sp.ImmutableMatrix((_Q.product_matrix_left * _Q.product_matrix_right.T)[1:, 1:])
_ENTRIES = sp.symbols("m:3:3", real=True)


@lru_cache(maxsize=1)
def _quaternion_products() -> sp.Matrix:
    """4·q·qᵀ in the entries of a matrix M: the identity and K of ΣM·R(q) = qᵀ·K·q (Horn 1987).

    a·(q·b·q*) = (a·q)·(q·b) for the units a and b, both products of a matrix and q.
    """
    units = [sp.Quaternion(0, *row) for row in sp.eye(3).tolist()]
    forms = (a.product_matrix_left.T * b.product_matrix_right for a, b in product(units, units))
    return sp.ImmutableMatrix(sum((m * form for m, form in zip(_ENTRIES, forms, strict=True)), sp.eye(4)))
