"""A measured positioning error as the table of a control, whose entries are equally spaced.

Siemens: the Function Manual of the 840D, K3 (6FC5397). Fanuc: the parameter manual of the 0i (B-63980EN), pages 99
and 100. Heidenhain: a table .COM, assigned in a file .CMA and switched on by MP730, has entries at a datum and
every 2ⁿ × 0.0001 mm or degrees (TNC 407, technical manual, page 153). No description of its file format or of the
sign was available, so no such file is written here.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mathpost.errors import InputError

if TYPE_CHECKING:
    from mathpost.shop.measure.spline import Curve

DEGREES = 1 / 3600  # of a second of arc
HEIDENHAIN = (
    "Heidenhain: no file, for its format was not to be had; enter the errors by hand in a table .COM (positioning: "
    "columns 1 to 18), at a datum and every 2ⁿ × 0.0001, and try the sign"
)
LARGEST = 7  # that a Fanuc compensation point holds


def entries(error: Curve, step: float) -> np.ndarray:
    """Return the positions of a control's table: every `step` over the turn or the measured travel."""
    low, high = error.points.at[[0, -1]] if error.points.period is None else (0.0, error.points.period)
    count = (high - low) / step if step > 0 else 0.5
    if abs(count - round(count)) > 1e-9 or round(count) < 1:
        raise InputError("step", f"a step that divides {high - low:g}", f"{step:g}")
    return low + step * np.arange(round(count) + 1)


def siemens(axis: str, step: float, error: Curve, error_down: Curve | None = None, *, unit: float = DEGREES) -> str:
    """Return a compensation table for a Siemens 840D as the text of an INI file.

    `axis` is the machine axis, such as "C" or "AX5"; `step`, degrees or mm between entries, must divide the turn or
    the measured travel. `error` is a `mathpost.shop.measure.spline.Curve`, actual minus target, in units of `unit`
    degrees or mm, by default seconds of arc; a periodic one makes a modulo table, which ends where it begins.

    One curve makes a table of encoder error compensation (EEC, in newer manuals MSEC), `$AA_ENC_COMP`: the control
    moves the axis *against* a positive entry, so the entries are the errors themselves. A second one, for the
    negative direction of travel, makes two CEC tables, `$AN_CEC`, from the axis onto itself. The sign rule of EEC
    is from the manual; that of CEC was not found, so the file asks to try the sign on the machine first.

    Examples
    --------
    >>> from mathpost.shop.measure import spline
    >>> error = spline.through_all(spline.points([0, 120, 240], [0, 36, -36], period=360))
    >>> siemens("C", 120, error).splitlines()[2:5]
    ['$AA_ENC_COMP[0,0,C]=0.000000', '$AA_ENC_COMP[0,1,C]=0.010000', '$AA_ENC_COMP[0,2,C]=-0.010000']
    """
    at = entries(error, step)
    spacing = {"STEP": float(step), "MIN": float(at[0]), "MAX": float(at[-1])}
    modulo = {"IS_MODULO": int(error.points.period is not None)}
    lines = []
    if error_down is None:
        lines += [f"$AA_ENC_COMP[0,{n},{axis}]={value:z.6f}" for n, value in enumerate(error(at) * unit)]
        lines += [f"$AA_ENC_COMP_{key}[0,{axis}]={value}" for key, value in (spacing | modulo).items()]
        return "\n".join(["%_N_AX_EEC_INI", "CHANDATA(1)", *lines, "M17"]) + "\n"
    if not np.array_equal(at, entries(error_down, step)):
        raise InputError("error_down", "a curve over the same range as error", "another range")
    columns = {"INPUT_AXIS": f"({axis})", "OUTPUT_AXIS": f"({axis})"} | spacing
    for number, (direction, each) in enumerate([(1, error), (-1, error_down)]):
        lines += [f"$AN_CEC[{number},{n}]={value:z.6f}" for n, value in enumerate(each(at) * unit)]
        ending = columns | {"DIRECTION": direction, "MULT_BY_TABLE": 0} | modulo
        lines += [f"$AN_CEC_{key}[{number}]={value}" for key, value in ending.items()]
    note = "; the entries are errors, actual minus target: try one before use"
    return "\n".join(["%_N_NC_CEC_INI", "CHANDATA(1)", note, *lines, "M17"]) + "\n"


def fanuc(
    axis: int, step: float, error: Curve, *, unit: float = DEGREES, detection: float = 0.001,
    reference: int | None = None,
) -> str:  # fmt: skip
    """Return parameters and points of a Fanuc's pitch error compensation as text.

    Each point holds what the correction grows by from the point before it: whole detection units, −7 to 7, times a
    magnification. The sums are rounded, not the increments, so that rounding does not add up. The correction at the
    reference position, machine coordinate 0, is nothing. The manual gives no sign, and the words N A P are quoted
    from memory: the text asks for a trial.

    `axis` is the number of the controlled axis, from 1, `detection` the detection unit, degrees or mm, `reference`
    the number of the reference position's point, by default the smallest with which no number is negative; the rest
    is as in `siemens`. Whole steps lie between machine coordinate 0 and the ends of the travel, which includes it.
    """
    at, endless = entries(error, step), error.points.period is not None
    sections = at / step
    first = round(-sections[0])
    if not 0 <= first < len(at) or np.abs(sections - np.round(sections)).max() > 1e-6:
        found = f"{at[0]:g} to {at[-1]:g} every {step:g}"
        raise InputError("step", "a travel with machine coordinate 0, whole steps from its ends", found)
    if not 0 < detection < np.inf:
        raise InputError("detection", "a detection unit above 0", f"{detection}")
    wanted = (error(0.0) - error(at)) * unit / detection
    magnification = 1
    while np.abs(np.diff(np.round(wanted / magnification))).max() > LARGEST:
        magnification += 1
    sums = np.round(wanted / magnification)
    reference = first if reference is None else reference
    points = dict(enumerate(np.diff(sums).astype(int).tolist(), reference - first + 1))
    if endless:
        points = {reference: points[max(points)], **points}
    left = np.abs(sums * magnification - wanted).max() * detection
    numbers = {3620: reference, 3621: min(points), 3622: max(points), 3623: magnification, 3624: step}
    numbers |= {3625: 360} if endless else {}
    lines = [
        f"(pitch error compensation of axis {axis}; rounding leaves {left:.5f})",
        "(made from actual minus target; try one point, and compare with a file that the control has put out)",
        *(f"N{number:05d}A{axis}P{value:g}" for number, value in numbers.items()),
        *(f"N{10000 + number}P{value}" for number, value in points.items()),
    ]
    return "\n".join(lines) + "\n"
