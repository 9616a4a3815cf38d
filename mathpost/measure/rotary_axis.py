"""Where a machine's rotary axes really are, from a dial, a probe and a ball: rotation centre, tilt, RTCP zero.

Each procedure is a `mathpost.measure.fit.Measurement`: `predict` and `simulate` say what it would read on a machine
with given errors, `identify` finds the errors from the readings, with their covariance. All formulas are exact;
the first-order ones of the literature are what remains of them for small errors.

Names of errors follow ISO 230-7 with the letter O: XOC and YOC place the C line, AOC and BOC tilt it, as turns
about X and Y, right-handed. For an axis along none of the machine's they are XO, YO and so on in the plane square
to the axis, numbered 1 and 2.

References
----------
Source 001: the text on the rotation centre of tilting tables (its equation (2) is destroyed: `dial_circle` is a
reconstruction) and 五坐标数控机床旋转轴定位精度的校正方法 (2019), on the RTCP zero.
"""

from dataclasses import replace
from functools import lru_cache

import numpy as np
import sympy as sp

from mathpost.chain import exact_unit, exact_vector, turn
from mathpost.errors import InputError
from mathpost.measure.fit import Measurement
from mathpost.rotation import ACTIVE, about

ANGLE = sp.Symbol("angle", real=True)


@lru_cache(maxsize=1)
def dial_circle():
    """X and Y interpolate a large circle, C turns with it, and a dial reads the distance from C's centre.

    Settings: `angle` on the circle and its radius `R`. Reading: `dial`. Unknowns: `ex`, `ey`, by which the circle's
    centre lies off the centre of C, and the `zero` of the dial. To first order the dial reads
    ex·cos + ey·sin + zero, hence ex = (r0 − r180)/2 and ey = (r90 − r270)/2.

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
        angles=("angle",),
        more={"the same at 90° more": {ANGLE: ANGLE + sp.pi / 2}, "the same at 180° more": {ANGLE: ANGLE + sp.pi}},
        largest=5,
    )


@lru_cache(maxsize=32)
def probing(rotary):
    """One feature, a ball or a bore, is probed at two or more angles of a rotary axis.

    Setting: `angle`, as programmed. Readings: `x`, `y`, `z` of the feature in the machine, those that were taken.
    Unknowns: the centre of rotation, as coordinates square to the axis (`xc`, `yc` for C), and the feature at
    angle zero (`xf`, `yf`, `zf`). For an axis along none of the machine's the centre is `c1`, `c2`: the point of
    the axis nearest to the machine's origin, in the directions of `square_to`. Only the direction of `rotary` is
    used: [-1, 0, 0] is an ISO 841 table A, whose table turns against the word.

    Examples
    --------
    >>> from mathpost.machine import Rotary
    >>> a = Rotary("A", "workpiece", axis=(-1, 0, 0), point=(0, 0, 0))
    >>> probed = {"angle": [0, 90], "y": [-150, -150.021], "z": [-300, -400.005]}
    >>> estimate = probing(a).identify(probed, degrees=True)
    >>> f"{estimate['yc']:.3f} {estimate['zc']:.3f}"
    '-200.013 -349.992'
    """
    names, plane = square_to(rotary)
    names = [f"{name[0].lower()}c" if name[0] in "XYZ" else f"c{name}" for name in names]
    centre, feature = sp.symbols(names, real=True), sp.symbols("xf yf zf", real=True)
    point = plane * sp.Matrix(centre)
    probed = point + about(exact_unit(rotary.axis), ANGLE) * (sp.Matrix(feature) - point)
    return Measurement(
        name=f"probing on {rotary.name}",
        unknowns=(*centre, *feature),
        settings=(ANGLE,),
        readings=dict(zip("xyz", probed, strict=True)),
        angles=("angle",),
        more={"the same with the axis 90° further": {ANGLE: ANGLE + sp.pi / 2}},
    )


@lru_cache(maxsize=32)
def ball(rotary, *, ball_unknown=False):
    """A ball on the carried body, followed by the control over a turn of a rotary axis it takes for perfect.

    Settings: `angle` as programmed, and `x`, `y`, `z` of the ball at angle zero, in the machine (on a head: the
    tool's tip relative to the nose). Readings: `ex`, `ey`, `ez`, the ball minus where the control believes it.
    Unknowns: two offsets of the axis from `rotary.point` and two tilts of it from `rotary.axis`, as the control
    has them, both square to it: XOC, YOC, AOC, BOC for C. With `ball_unknown` the ball need not be where `x`, `y`,
    `z` say: three more unknowns `bx`, `by`, `bz`. To first order e = (I − R)(c + h·(BOC, −AOC)) on a C axis.

    Examples
    --------
    >>> from mathpost.machine import Rotary
    >>> c = ball(Rotary("C", "workpiece", axis=(0, 0, -1), point=(0, 0, 0)))
    >>> at = {"angle": [0, 90, 180, 270], "x": 150, "y": 0, "z": 0}
    >>> read = c.predict({"XOC": 0.010, "YOC": -0.006}, at, degrees=True)
    >>> read["ex"].round(6) + 0.0
    array([0.   , 0.016, 0.02 , 0.004])
    >>> estimate = c.identify({**at, **read}, degrees=True)
    >>> f"{estimate['XOC']:.6f} {estimate['YOC']:.6f} {estimate['AOC']:z.6f}"
    '0.010000 -0.006000 0.000000'
    """
    names, plane = square_to(rotary)
    letter = rotary.name[0]
    offset = sp.symbols([f"{name}O{letter}" if name in "XYZ" else f"offset{name}" for name in names], real=True)
    tilt = sp.symbols([f"{'ABC'['XYZ'.index(n)]}O{letter}" if n in "XYZ" else f"tilt{n}" for n in names], real=True)
    place, shift = sp.symbols("x y z", real=True), sp.symbols("bx by bz", real=True)

    point = exact_vector(rotary.point)
    believed = turn(exact_unit(rotary.axis), point, ANGLE)
    true = turn(_tilted(rotary, plane * sp.Matrix(tilt)), point + plane * sp.Matrix(offset), ANGLE)
    at = sp.Matrix([*place, 1])
    moved = at + sp.Matrix([*shift, 0]) if ball_unknown else at
    error = (true * moved - believed * at)[:3, 0]
    x, y, z = place
    up = 200 * exact_unit(rotary.axis)
    return Measurement(
        name=f"ball on {rotary.name}",
        unknowns=(*offset, *tilt, *(shift if ball_unknown else ())),
        settings=(ANGLE, *place),
        readings=dict(zip(("ex", "ey", "ez"), error, strict=True)),
        angles=("angle",),
        more={
            "the same with the axis 90° further": {ANGLE: ANGLE + sp.pi / 2},
            "the same with the ball 200 mm further along the axis": {x: x + up[0], y: y + up[1], z: z + up[2]},
        },
        largest=5,
    )


@lru_cache(maxsize=1)
def rtcp_zero():
    """The tip of a head tilted by ±ψ under RTCP, with two tool lengths: the head's zero angle and its pivot.

    Settings: `angle` ψ of the head, positive when the tip swings towards positive `lateral`, and the pivot-to-tip
    length `L` that the control believes. Readings, zeroed at ψ = 0: `axial`, along the tool as it stands at ψ = 0,
    positive from the tip to the pivot, and `lateral`, square to it in the plane of tilt. Unknowns: `alpha`, where
    the head stands when it shows zero; `dy`, by which the spindle passes beside the pivot; `dL`, by which the tip
    is further from the pivot than believed. With one length `alpha` and `dy` do the same to the tip.

    Examples
    --------
    >>> at = {"angle": [40, -40, 40, -40], "L": [500, 500, 700, 700]}
    >>> read = {"axial": [0.0534204, -0.0300264, 0.0623953, -0.0390015]}
    >>> estimate = rtcp_zero().identify({**at, **read}, degrees=True)
    >>> f"{np.rad2deg(estimate['alpha']):.6f} {estimate['dy']:.4f} {estimate['dL']:.4f}"
    '0.004000 0.0300 0.0500'
    """
    alpha, dy, dl, length = sp.symbols("alpha dy dL L", real=True)
    nominal, true = sp.Matrix([0, -length, 0]), sp.Matrix([dy, -(length + dl), 0])
    return Measurement(
        name="RTCP zero",
        unknowns=(alpha, dy, dl),
        settings=(ANGLE, length),
        readings=_tilted_tip(ACTIVE["Z"](alpha) * true - nominal),
        angles=("angle",),
        more={
            "the same at the opposite angle": {ANGLE: -ANGLE},
            "the same with a tool 200 mm longer": {length: length + 200},
        },
        largest=5,
    )


@lru_cache(maxsize=1)
def rtcp_tip():
    """The same readings with one tool: what it can know, the tip's own error `u` across and `w` along the tool.

    To first order u = dy + L·alpha and w = −dL. From ±ψ: u = (v₊ − v₋)/(2 sin ψ), w = (v₊ + v₋)/(2(cos ψ − 1)).

    Examples
    --------
    >>> estimate = rtcp_tip().identify({"angle": [40, -40], "axial": [0.0534204, -0.0300264]}, degrees=True)
    >>> f"{estimate['u']:.6f} {estimate['w']:.6f}"
    '0.064910 -0.049997'
    """
    u, w = sp.symbols("u w", real=True)
    return Measurement(
        name="RTCP tip",
        unknowns=(u, w),
        settings=(ANGLE,),
        readings=_tilted_tip(sp.Matrix([u, w, 0])),
        angles=("angle",),
        more={"the same at the opposite angle": {ANGLE: -ANGLE}},
        largest=5,
    )


def source_zero_angle(error, length):
    """The zero angle as source 001 has it: arctan(y/x) of the tip's error y and the pivot-to-tip length x, radians.

    It takes the whole reading for L·α. A dial zeroed at ψ = 0 shows L·α·sin ψ: right at ψ = 90° only, and 11.5
    times too small at the 5° of that text.

    Examples
    --------
    >>> f"{np.rad2deg(source_zero_angle(0.1, 700)) * 3600:.4f} arcsec"
    '29.4664 arcsec'
    """
    return np.arctan(np.divide(error, length))


def angle_error_at_tip(kin, joints, errors, *, degrees=False):
    """Return what errors of the rotary angles do to tip and tool axis in the workpiece, shapes (..., 3).

    `joints` are (..., 5), `errors`, (..., 2), actual minus programmed angle of both rotary axes, and so are the
    results: actual minus programmed. `degrees` is for `errors` and the angles of `joints`.

    Examples
    --------
    >>> from mathpost import machine
    >>> from mathpost.kinematics import Kinematics
    >>> kin = Kinematics(machine.load("data/machines/ac_table.toml"))
    >>> tip, _ = angle_error_at_tip(kin, [200, 0, 0, 0, 0], [0, 10 / 3600], degrees=True)
    >>> f"10 arcsec of C, 200 mm from its centre: {1000 * np.linalg.norm(tip):.2f} µm"
    '10 arcsec of C, 200 mm from its centre: 9.70 µm'
    """
    try:
        joints, errors = np.asarray(joints, dtype=float), np.asarray(errors, dtype=float)
        disturbed = joints + np.concatenate([np.zeros((*errors.shape[:-1], 3)), errors], axis=-1)
    except (TypeError, ValueError):
        raise InputError("errors", "numbers of shape (..., 2) beside joints (..., 5)", repr(errors)) from None
    actual, programmed = kin.forward(disturbed, degrees=degrees), kin.forward(joints, degrees=degrees)
    return actual[0] - programmed[0], actual[1] - programmed[1]


def corrected(rotary, estimate):
    """Return `rotary` where `estimate`, of `ball` or `probing`, has found it: what to enter in the control.

    Examples
    --------
    >>> from mathpost.machine import Rotary
    >>> c = Rotary("C", "workpiece", axis=(0, 0, -1), point=(0, 0, -50))
    >>> turn = {"angle": [0, 90, 180, 270] * 2, "x": 150, "y": 0, "z": [0] * 4 + [300] * 4}
    >>> read = ball(c).predict({"XOC": 0.010, "BOC": 4e-5}, turn, degrees=True)
    >>> found = corrected(c, ball(c).identify(turn | read, degrees=True))
    >>> tuple(round(x, 6) + 0.0 for x in (*found.axis, *found.point))
    (-4e-05, 0.0, -1.0, 0.01, 0.0, -50.0)
    """
    _, plane = square_to(rotary)
    plane, point = np.array(plane, dtype=float), np.array(rotary.point)
    unknowns = [str(symbol) for symbol in (*ball(rotary).unknowns, *probing(rotary).unknowns[:2])]
    offset, tilt, centre = (
        plane @ [estimate.values.get(name, 0.0) for name in unknowns[i : i + 2]] for i in (0, 2, 4)
    )
    if not any(name in estimate.values for name in unknowns):
        raise InputError("estimate", f"some of {', '.join(unknowns)}", ", ".join(estimate.values))
    if unknowns[4] in estimate.values:
        offset = centre - plane @ plane.T @ point
    direction = np.array(rotary.axis) + np.cross(tilt, rotary.axis)
    return replace(rotary, point=tuple((point + offset).tolist()), axis=tuple(direction.tolist()))


def square_to(rotary):
    """Return the two directions square to a rotary axis in which its errors are counted: names, and 3×2 matrix.

    The machine's own two other axes if the axis lies along one of them; else, named "1" and "2", the machine axis
    nearest to square with it, made square, and the third direction of the right-handed frame.

    Examples
    --------
    >>> from mathpost.machine import Rotary
    >>> square_to(Rotary("B", "tool", axis=(0, 1, 0), point=(0, 0, 0)))[0]
    ['X', 'Z']
    """
    axis = exact_unit(rotary.axis)
    across = [row for row in range(3) if axis[row] == 0]
    if len(across) == 2:
        return ["XYZ"[row] for row in across], sp.eye(3)[:, across]
    first = sp.eye(3)[:, min(range(3), key=lambda row: abs(axis[row]))]
    first = first - axis * axis.dot(first)
    first = first / sp.sqrt(first.dot(first))
    return ["1", "2"], sp.Matrix.hstack(first, axis.cross(first))


def _tilted(rotary, tilt):
    """The direction of an axis turned by the small angles `tilt` square to it, of length 1."""
    axis = exact_unit(rotary.axis)
    return (axis + tilt.cross(axis)) / sp.sqrt(1 + tilt.dot(tilt))


def _tilted_tip(error):
    """Readings of a dial zeroed at ψ = 0 when the head tilts by ψ a tip that misses its place by `error`."""
    lateral, axial, _ = (ACTIVE["Z"](ANGLE) - sp.eye(3)) * error
    return {"axial": axial, "lateral": lateral}
