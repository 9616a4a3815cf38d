"""The work offset after the table has turned, as the macro G65 P9795 of source 001 calculates it.

A point of the part is carried back to where it was with all rotary axes at zero, and forward to the new angles. The
table is a tuple of `mathpost.machine.Rotary` from the bed outwards, such as `Machine.rotary`: stack order, sign
convention and a centre for each axis. Source 001 states none of the three, and its example depends on them.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from numbers import Real
from typing import Any

import numpy as np
import sympy as sp
from numpy.typing import ArrayLike

from mathpost.chain import exact_unit, product, turn
from mathpost.errors import InputError, as_array
from mathpost.formula import numeric
from mathpost.machine import Rotary
from mathpost.path.nc_words import Words

POINT = sp.symbols("x y z", real=True)
ADDRESSES = "XYZABDESUVW"


@dataclass(frozen=True)
class WorkOffset:
    """An entry of the control's offset table, ``"G54"`` to ``"G59"`` or ``"G54.1 P7"``: machine mm and degrees."""

    code: str
    X: float
    Y: float
    Z: float
    A: float = 0.0
    B: float = 0.0


@dataclass(frozen=True)
class NewDatum:
    """The result of `p9795`."""

    after: np.ndarray  # the point after the turn, shape (3,), machine mm
    angles: dict[str, float]  # degrees by axis, which must also be programmed
    block: str  # the NC block that stores the point


def ab_table(
    centre_a: ArrayLike, centre_b: ArrayLike, *, order: str = "AB", iso: bool = True
) -> tuple[Rotary, ...]:
    """Return the rotary axes of a horizontal machining centre's table, from the bed outwards.

    `centre_a` and `centre_b` are points on either axis with both at zero, mm in machine coordinates; A lies along X
    and B along Y. `order` is ``"AB"`` if A is mounted on the bed and carries B, ``"BA"`` if B carries A; `iso` says
    that the table turns against the programmed angle, as in ISO 841.
    """
    if sorted(order) != ["A", "B"]:
        raise InputError("order", '"AB" or "BA"', repr(order))
    sign = -1 if iso else 1
    axes = {
        "A": ((sign, 0, 0), as_array(centre_a, 3, "centre_a")),
        "B": ((0, sign, 0), as_array(centre_b, 3, "centre_b")),
    }
    return tuple(Rotary(name, "workpiece", axes[name][0], tuple(axes[name][1].tolist())) for name in order)


@lru_cache(maxsize=32)
def moved_symbolic(table: tuple[Rotary, ...]) -> tuple[tuple[sp.Expr, ...], tuple[sp.Symbol, ...]]:
    """Return the moved point of a table, (x, y, z), and the symbols in it, as two tuples.

    Those are x y z of the point, and for each axis its centre, old and new angle (``A_x A_y A_z A_0 A_1``).
    """
    symbols, point = list(POINT), sp.Matrix([*POINT, 1])
    to_new: list[sp.Matrix] = []
    for axis in table:
        *centre, old, new = own = sp.symbols([f"{axis.name}_{c}" for c in "xyz01"], real=True)
        direction, centre = exact_unit(axis.axis), sp.Matrix(centre)
        point = product((turn(direction, centre, -old), point))
        to_new.insert(0, turn(direction, centre, new))
        symbols += own
    for matrix in to_new:
        point = product((matrix, point))
    return tuple(point[:3, 0]), tuple(symbols)


def moved(
    point: ArrayLike,
    table: Sequence[Rotary],
    start: Mapping[str, ArrayLike],
    end: Mapping[str, ArrayLike],
    *,
    degrees: bool = False,
) -> np.ndarray:
    """Return where a point of the part, shape (..., 3), goes when the table turns: mm, in machine coordinates.

    `start` and `end` map the name of an axis to its machine angle before and after, numbers or arrays, broadcast.
    `InputError` if an angle is missing or not finite, or an axis carries the tool.

    Examples
    --------
    >>> table = ab_table((0, -200, -850), (-350, 0, -900), order="AB")
    >>> moved((-300, -250, -600), table, {"A": 0, "B": 0}, {"A": 0, "B": 90}, degrees=True).round(6)
    array([-650., -250., -850.])
    """
    point = as_array(point, 3, "point")
    values = list(np.moveaxis(point, -1, 0))
    for axis in table:
        if axis.carries != "workpiece":
            raise InputError(f"table, {axis.name}", "an axis that carries the workpiece", "one of the tool")
        values += axis.point
        for where, angles in (("start", start), ("end", end)):
            if axis.name not in angles:
                raise InputError(where, f"an angle for {axis.name}", f"{', '.join(angles) or 'none'}")
            angle = as_array(np.asarray(angles[axis.name])[..., None], 1, f"{where}, {axis.name}")[..., 0]
            values.append(np.deg2rad(angle) if degrees else angle)
    expressions, symbols = moved_symbolic(tuple(table))
    return numeric(expressions, symbols)(*values)


def p9795(
    table: tuple[Rotary, ...],
    offset: WorkOffset,
    *,
    S: int | str | None = None,
    current: dict[str, float] | None = None,
    shift: str = "machine",
    **arguments: float,
) -> NewDatum:
    """Recalculate a work offset for new angles of A and B, with the arguments of the macro, as `NewDatum`.

    `table` is A and B, or one of them, as `mathpost.machine.Rotary`; `offset` the active `WorkOffset`. X, Y, Z, A,
    B are workpiece coordinates, mm and degrees, before the turn: those of the dict `current`, the present position,
    if left out. D, E are the new A and B, degrees (the source calls both "A axis"); U, V, W an extra shift after
    the turn, mm. `shift` says whether that lies along the ``"machine"`` axes or is turned with the ``"part"``; the
    source is silent. S is where to store the result: 54 to 59, or ``"54.1 P7"``; `offset` if left out. `InputError`
    if an argument is missing, is not a number or names an axis that the table lacks.

    Examples
    --------
    The program of source 001, on a machine of the stack order AB:

    >>> table = ab_table((0, -200, -850), (-350, 0, -900), order="AB")
    >>> old = WorkOffset("G54", X=-300, Y=-250, Z=-600)
    >>> p9795(table, old, **read_call("G65P9795X0Y0Z0A0B0D-30.E10.S55")).block
    'G90 G10 L2 P2 X-352.854 Y-370.364 Z-654.922'
    """
    for address in set(arguments) - set(ADDRESSES):
        raise InputError(address, f"arguments among {', '.join(ADDRESSES)}", "another")
    given: dict[str, Any] = dict.fromkeys("XYZABDE") | dict.fromkeys("UVW", 0.0) | (current or {}) | arguments
    for axis, address in (("A", "D"), ("B", "E")):
        if axis not in [each.name for each in table]:
            if given[axis] or given[address]:
                raise InputError(address, f"no angle: the table has no {axis} axis", f"{given[address]}")
            given |= {axis: 0.0, address: 0.0}
    for address, number in given.items():
        if not isinstance(number, Real) or not np.isfinite(float(number)):
            raise InputError(address, "a number", "nothing" if number is None else repr(number))
    if shift not in ("machine", "part"):
        raise InputError("shift", '"machine" or "part"', repr(shift))

    before = np.array([given[address] + getattr(offset, address) for address in "XYZ"])
    along, turned = np.array([given[address] for address in "UVW"]) * [[shift == "machine"], [shift == "part"]]
    start = {"A": offset.A + given["A"], "B": offset.B + given["B"]}
    end = {"A": offset.A + given["D"], "B": offset.B + given["E"]}
    after = moved(before + turned, table, start, end, degrees=True) + along

    code = offset.code if S is None else S
    store = re.fullmatch(r"G?(5[4-9])|G?54\.1 ?P([1-9]\d*)", str(code).strip().upper())
    if not store:
        raise InputError("S", "54 to 59, or 54.1 P and a number", repr(code))
    place = f"L2 P{int(store[1]) - 53}" if store[1] else f"L20 P{store[2]}"
    return NewDatum(after, {axis.name: end[axis.name] for axis in table}, f"G90 G10 {place} {words(after)}")


def words(point: np.ndarray, decimals: int = 3) -> str:
    """Return a point, shape (3,), as NC words."""
    return " ".join(f"{name}{number:z.{decimals}f}" for name, number in zip("XYZ", point, strict=True))


def read_call(block: str) -> dict[str, float]:
    """Return the arguments of a ``G65 P9795`` block as a dict for `p9795`.

    A number needs its decimal point, unless it is 0: without one the control counts in its smallest unit.
    """
    where = f"block {block!r}"
    arguments: dict[str, float] = {}
    pairs = Words(block.upper().rstrip("; "), where).all()
    if [(letter, float(number)) for letter, number in pairs[:2]] != [("G", 65), ("P", 9795)]:
        raise InputError(where, "G65 P9795", " ".join(letter + number for letter, number in pairs[:2]))
    for letter, number in pairs[2:]:
        if letter not in ADDRESSES or letter in arguments:
            found = f"{letter} twice" if letter in arguments else letter
            raise InputError(where, f"each of {' '.join(ADDRESSES)} at most once", found)
        if letter != "S" and "." not in number and float(number) != 0:
            raise InputError(f"{where}, {letter}", f"a decimal point, {letter}{number}.", letter + number)
        value = float(number)
        arguments[letter] = int(value) if letter == "S" and value.is_integer() else value
    return arguments
