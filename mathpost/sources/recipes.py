"""The two ZXZ recipes of source 000, step by step."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
import sympy as sp

from mathpost.errors import InputError, as_array
from mathpost.formula import from_angles
from mathpost.rotation import PASSIVE


def zxz_right(alpha: Any, beta: Any, gamma: Any, *, degrees: bool = False) -> Any:
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


def zxz_left_transposed(alpha: Any, beta: Any, gamma: Any, *, degrees: bool = False) -> Any:
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


def zxz_steps(
    recipe: str,
    angles: Sequence[Any],
    point: Sequence[Any],
    *,
    elementary: dict[str, Callable] = PASSIVE,
    degrees: bool = False,
) -> list[Step]:
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


def _right(alpha: Any, beta: Any, gamma: Any, elementary: dict[str, Callable] = PASSIVE) -> dict[str, sp.Matrix]:
    """The matrices of the first recipe by name."""
    a, b, c = elementary["Z"](alpha), elementary["X"](beta), elementary["Z"](gamma)
    return {"α": a, "β": b, "γ": c, "γβ": c * b, "γβα": c * b * a}


def _left(alpha: Any, beta: Any, gamma: Any, elementary: dict[str, Callable] = PASSIVE) -> dict[str, sp.Matrix]:
    """The matrices of the second recipe by name."""
    a, b, c = elementary["Z"](-alpha), elementary["X"](-beta), elementary["Z"](-gamma)
    return {"α": a, "β": b, "γ": c, "αβ": a * b, "αβγ": a * b * c, "(αβγ)ᵀ": (a * b * c).T}


@lru_cache(maxsize=2)
def _result(recipe: Callable[..., dict[str, sp.Matrix]]) -> Callable[..., sp.Matrix]:
    return lambda *angles: [*recipe(*angles).values()][-1]
