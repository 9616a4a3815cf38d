"""Where a machine's rotary axes really are, from a dial, a probe and a ball: rotation centre, tilt, RTCP zero.

Each procedure is a `mathpost.shop.measure.fit.Measurement`, and exact; the first-order formulas of the literature
are what remains for small errors.

Location errors are named as in ISO 230-7: EX0C and EY0C place the C line, EA0C and EB0C tilt it, as turns about X
and Y, right-handed; many texts write XOC, YOC, AOC and BOC. For an axis along none of the machine's they are
counted in the plane square to it: offsets E10B and E20B, tilts E30B and E40B.

References
----------
Source 001: the text on the rotation centre of tilting tables (its equation (2) is destroyed: `dial_circle` is a
reconstruction) and 五坐标数控机床旋转轴定位精度的校正方法 (2019), on the RTCP zero.
"""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
import sympy as sp

from mathpost.chain import exact_unit, exact_vector, turn
from mathpost.errors import InputError
from mathpost.rotation import ACTIVE, unit
from mathpost.shop.measure.fit import Measurement

if TYPE_CHECKING:
    from mathpost.machine import Rotary

ANGLE = sp.Symbol("angle", real=True)
TILT = dict(zip("XYZ12", "ABC34", strict=True))  # the tilt that belongs to a direction
QUARTER = {"the same with the axis 90° further": {ANGLE: ANGLE + sp.pi / 2}}


@lru_cache(maxsize=1)
def dial_circle() -> Measurement:
    """X and Y interpolate a large circle, C turns with it, and a dial reads the distance from C's centre.

    Settings: `angle` on the circle and its radius `R`. Reading: `dial`. Unknowns: `ex`, `ey`, by which the circle's
    centre lies off that of C, and the `zero` of the dial. To first order it reads ex·cos + ey·sin + zero.

    Examples
    --------
    >>> dial = {"angle": [0, 90, 180, 270], "R": 100, "dial": [0.030002, -0.019995, -0.029998, 0.020004]}
    >>> estimate = dial_circle().identify(dial, degrees=True)
    >>> f"{estimate['ex']:.6f} {estimate['ey']:.6f}"
    '0.030000 -0.020000'
    """
    ex, ey, zero, radius = sp.symbols("ex ey zero R", real=True)
    distance = sp.sqrt((radius * sp.cos(ANGLE) + ex) ** 2 + (radius * sp.sin(ANGLE) + ey) ** 2)
    return Measurement(
        name="dial on a circle",
        unknowns=(ex, ey, zero),
        settings=(ANGLE, radius),
        readings={"dial": distance - radius + zero},
        more={"the same at 90° more": {ANGLE: ANGLE + sp.pi / 2}, "the same at 180° more": {ANGLE: ANGLE + sp.pi}},
        largest=5,
    )


@lru_cache(maxsize=32)
def probing(rotary: Rotary) -> Measurement:
    """One feature, a ball or a bore, is probed at two or more angles of a rotary axis.

    Setting: `angle`, as programmed. Readings: `x`, `y`, `z` of the feature in the machine, those that were taken.
    Unknowns: the centre of rotation, square to the axis (`xc`, `yc` for C; `c1`, `c2` for an axis along none of the
    machine's), and the feature at angle zero (`xf`, `yf`, `zf`). Only the direction of `rotary` is used.
    """
    names, plane = square_to(rotary)
    names = [f"{name.lower()}c" if name in "XYZ" else f"c{name}" for name in names]
    centre, feature = sp.symbols(names, real=True), sp.symbols("xf yf zf", real=True)
    probed = turn(exact_unit(rotary.axis), plane * sp.Matrix(centre), ANGLE) * sp.Matrix([*feature, 1])
    return Measurement(
        name=f"probing on {rotary.name}",
        unknowns=(*centre, *feature),
        settings=(ANGLE,),
        readings=dict(zip("xyz", probed, strict=False)),
        more=QUARTER,
    )


@lru_cache(maxsize=32)
def ball(rotary: Rotary) -> Measurement:
    """A ball on the carried body, followed by the control over a turn of a rotary axis that it takes as perfect.

    Settings: `angle` as programmed, and `x`, `y`, `z` of the ball at angle zero, in the machine (on a head: the
    tool's tip relative to the nose). Readings: `ex`, `ey`, `ez`, the ball minus where the control has it.
    Unknowns: the axis' location errors against `rotary`, which is what the control has: EX0C, EY0C, EA0C, EB0C for
    C. The ball must be exactly at `x`, `y`, `z`; `mathpost.shop.compensate.calibrate` estimates its position, too.
    """
    _, plane = square_to(rotary)
    errors, place = sp.symbols(location_errors(rotary)[0], real=True), sp.symbols("x y z", real=True)
    axis, point = exact_unit(rotary.axis), exact_vector(rotary.point)
    offset, tilt = plane * sp.Matrix(errors[:2]), plane * sp.Matrix(errors[2:])
    tilted = (axis + tilt.cross(axis)) / sp.sqrt(1 + tilt.dot(tilt))
    at = sp.Matrix([*place, 1])
    error = turn(tilted, point + offset, ANGLE) * at - turn(axis, point, ANGLE) * at
    higher = dict(zip(place, sp.Matrix(place) + 200 * axis, strict=True))
    return Measurement(
        name=f"ball on {rotary.name}",
        unknowns=tuple(errors),
        settings=(ANGLE, *place),
        readings=dict(zip(("ex", "ey", "ez"), error[:3, 0], strict=True)),
        more=QUARTER | {"the same with the ball 200 mm further along the axis": higher},
        largest=5,
    )


@lru_cache(maxsize=1)
def rtcp_zero() -> Measurement:
    """The tip of a head tilted by ±ψ under RTCP, with two tool lengths: the head's zero angle and its pivot.

    Settings: `angle` ψ of the head, positive when the tip swings towards positive `lateral`, and the pivot-to-tip
    length `L` that the control believes. Readings, zeroed at ψ = 0: `axial`, along the direction from tip to pivot
    at ψ = 0, and `lateral`, square to it in the plane of tilt. Unknowns: `alpha`, the true angle of the head when
    it shows zero; `dy`, by which the spindle axis misses the pivot; `dL`, by which the tip is further from the
    pivot than believed. With one length, `alpha` and `dy` have the same effect on the tip.
    """
    alpha, dy, dl, length = sp.symbols("alpha dy dL L", real=True)
    nominal, true = sp.Matrix([0, -length, 0]), sp.Matrix([dy, -(length + dl), 0])
    lateral, axial, _ = (ACTIVE["Z"](ANGLE) - sp.eye(3)) * (ACTIVE["Z"](alpha) * true - nominal)
    return Measurement(
        name="RTCP zero",
        unknowns=(alpha, dy, dl),
        settings=(ANGLE, length),
        readings={"axial": axial, "lateral": lateral},
        more={
            "the same at the opposite angle": {ANGLE: -ANGLE},
            "the same with a tool 200 mm longer": {length: length + 200},
        },
        largest=5,
    )


def square_to(rotary: Rotary) -> tuple[list[str], sp.Matrix]:
    """Return the two directions square to a rotary axis in which its errors are counted: names, and 3×2 matrix.

    The machine's two other axes if it lies along one. Otherwise, named "1" and "2": the machine axis that is most
    nearly square to it, made square, and the third direction of the right-handed frame.
    """
    axis = exact_unit(rotary.axis)
    across = [row for row in range(3) if axis[row] == 0]
    if len(across) == 2:
        return ["XYZ"[row] for row in across], sp.eye(3)[:, across]
    first = sp.eye(3)[:, min(range(3), key=lambda row: abs(axis[row]))]
    first = first - axis * axis.dot(first)
    first = first / sp.sqrt(first.dot(first))
    return ["1", "2"], sp.Matrix.hstack(first, axis.cross(first))


@lru_cache(maxsize=64)
def location_errors(rotary: Rotary) -> tuple[list[str], np.ndarray]:
    """Names of an axis' location errors, both offsets, then both tilts; their directions as floats, 3×2."""
    names, plane = square_to(rotary)
    return [f"E{name}0{rotary.name}" for name in (*names, *map(TILT.get, names))], np.array(plane, dtype=float)


def corrected(rotary: Rotary, errors: dict[str, float]) -> Rotary:
    """Return `rotary` with its location errors, taken from `errors`: a dict, mm and radians."""
    names, plane = location_errors(rotary)
    if not set(names) & set(errors):
        raise InputError("errors", f"some of {', '.join(names)}", ", ".join(errors))
    own = [errors.get(name, 0.0) for name in names]
    axis = unit(rotary.axis)
    axis = unit(axis + np.cross(plane @ own[2:], axis))
    return replace(rotary, point=tuple((rotary.point + plane @ own[:2]).tolist()), axis=tuple(axis.tolist()))
