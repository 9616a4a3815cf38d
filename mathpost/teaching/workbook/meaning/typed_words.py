"""Words of a machine judged as numbers to their digits, and what deserves a look.

The rotary words are right if they make the tool axis, on either branch and in any winding; X Y Z if they bring the
tip into place with the rotary words that are demanded, or with those that are there.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

import numpy as np

from mathpost.detective.digits import written_decimals
from mathpost.detective.rotary_axes import JointCase
from mathpost.rotation import unit
from mathpost.teaching.workbook.meaning.calculation import nearest
from mathpost.teaching.workbook.meaning.machine_table import CLOSE
from mathpost.teaching.workbook.meaning.words import numbers_of

if TYPE_CHECKING:
    from mathpost.teaching.workbook.meaning.words import Words
    from mathpost.teaching.workbook.sheet.place import Place

UNIT_LENGTH = 2e-3  # as near to 1 as the length of a unit vector of three decimals
ROUNDED = 0.01  # mm, degrees: less may come from the rounding of what formulas calculate a word from
TOLD = 0.05  # of a unit vector: so much tells a length
FLIP = 60.0  # degrees between two rows that are worth a look


def judge_numbers(rows: list[Words], values: Mapping[Place, float | None]) -> Iterator[tuple[Place, str, str]]:
    """Yield (place, cause, sentence) of the words that are wrong as numbers, place → number, to their digits."""
    kinematics = rows[0].kinematics
    tip, axis, words = numbers_of(rows, values)
    least = ROUNDED if any(row.by_formulas for row in rows) else 1e-9
    half = np.maximum(_half_digits(words[:, :3]), least) + 2 * _half_digits(tip).max(axis=1, keepdims=True)
    half_angle = max((_half_digits(words[:, 3:] / rows[0].units) * rows[0].units).max(), least)
    half_axis = 0.0 if (axis % 1 == 0).all() else _half_digits(axis).max()
    case = JointCase(kinematics, axis, words[:, 3:], half_angle + 1e-9, half_axis)
    both, spread = case.both_branches(axis)
    slack = spread.max(axis=1) + case.half_digit
    demanded = nearest(words[:, 3:], both, slack=slack[:, None])
    off = (words[:, 3:] - demanded + 180) % 360 - 180
    any_is = case.makes_the_axis()[:, None]  # as at the pole
    right = (np.abs(off) <= slack) | any_is
    demanded = words[:, 3:] - np.where((np.abs(off) <= slack) | ~any_is, off, 0)
    linear, from_words = (kinematics.close(tip, np.deg2rad(angles))[:, :3] for angles in (demanded, words[:, 3:]))
    reach = np.linalg.norm(from_words, axis=1, keepdims=True) + np.linalg.norm(tip, axis=1, keepdims=True)
    half = half + 1e-6
    # Made of the angles that are demanded, as closely as the tool axis tells them, or of the words as they are; how
    # a wrong word was before it was rounded nobody knows.
    allowed = half + 2 * np.deg2rad(np.minimum(spread.max(axis=(1, 2))[:, None], half_angle)) * reach
    rounded = half + 2 * np.deg2rad(np.where(right.all(axis=1, keepdims=True), 0.0, half_angle)) * reach
    difference = words[:, :3] - linear
    wrong = (np.abs(difference) > allowed) & (np.abs(words[:, :3] - from_words) > rounded)
    constant = wrong.all(axis=0) & (np.ptp(difference, axis=0) <= 4 * allowed.max()) & (len(rows) > 2)
    for r, row in enumerate(rows):
        for k in (3, 4, 0, 1, 2):  # X Y Z follow from the rotary words
            name, word, cause = kinematics.machine.joint_names[k], words[r, k], "wrong value"
            if k < 3 and wrong[r, k]:
                cause = "sign" if abs(word + linear[r, k]) <= allowed[r, k] else "offset" if constant[k] else cause
                yield row.results[k], cause, f"{name} is {word:.6g}, {difference[r, k]:.6g} off"
            if k > 2 and not right[r, k - 3]:
                least, should = slack[r, k - 3], demanded[r, k - 3]
                cause = "sign" if abs(word + should) <= 2 * least else cause
                cause = "atan for atan2" if abs(abs(off[r, k - 3]) - 180) <= least else cause
                yield row.results[k - 5], cause, f"{name} is {word:.6g}, the tool axis demands {should:.6g}"


def _half_digits(numbers: np.ndarray) -> np.ndarray:
    """Half of the last digit of numbers, all taken to have the decimals, or the digits, of the longest."""
    decimals, size = written_decimals(numbers), np.floor(np.log10(np.maximum(np.abs(numbers), 1e-9)))
    longest = max(written_decimals(n) + s for n, s in zip(numbers.ravel(), size.ravel(), strict=True))
    half = 0.5 * np.maximum(10.0**-decimals, 10.0 ** (size - longest))
    return np.maximum(half if decimals < 9 else 0 * half, 1e-9)


def names_another_point(rows: list[Words], values: Mapping[Place, float | None]) -> str:
    """Return a sentence if X Y Z of a table name another point than the machine file means, or nothing.

    Most words in two columns are then off by one length along the turned tool axis, less the same at rotary zero if
    the machine file means a point that does not turn.
    """
    kinematics = rows[0].kinematics
    tip, axis, words = numbers_of(rows, values)
    rotary = nearest(words[:, 3:], kinematics.inverse(tip, axis, degrees=True)[..., 3:])
    at_zero = unit(np.array(kinematics.machine.tool_axis, float))
    at_tip, up = (kinematics.close(tip + step, np.deg2rad(rotary))[:, :3] for step in (0, unit(axis)))
    off, up = words[:, :3] - at_tip, up - at_tip
    told = (np.abs(up - at_zero) > TOLD) & np.isfinite(off)
    for back in (0 * at_zero, at_zero) if told.any() else ():
        length = np.nanmedian(off[told] / (up - back)[told])
        fits = told & (np.abs(off - length * (up - back)) < CLOSE)
        if np.sum(2 * fits.sum(axis=0) > told.sum(axis=0)) > 1 and abs(length) > CLOSE:
            where = f"{abs(length):.6g} mm {'up' if length > 0 else 'down'} the tool axis"
            return f"X Y Z name a point {where} from the one that the machine file means"
    return ""


def beyond_travel(rows: list[Words], values: Mapping[Place, float | None]) -> Iterator[str]:
    """Yield sentences on rotary words of which no turn is within travel, as of the other branch."""
    own = numbers_of(rows, values)[2]
    for joint, angles in zip(rows[0].kinematics.machine.rotary, own[:, 3:].T, strict=True):
        turns = [[joint.nearest_turn(angle + slack) for slack in (-ROUNDED, ROUNDED)] for angle in angles]
        outside = np.isnan(np.array(turns, dtype=float)).all(axis=1)
        if lines := [str(row.results[0][1]) for row, out in zip(rows, outside, strict=True) if out]:
            where = f"row{'s' * (len(lines) > 1)} {', '.join(lines[:6])}"
            yield f"no turn of {joint.name} is within its travel in {where}"


def looked_at(rows: list[Words], values: Mapping[Place, float | None]) -> Iterator[str]:
    """Yield what deserves a look in the present words, place → number: travel, flips between rows."""
    machine, (_, axis, own) = rows[0].kinematics.machine, numbers_of(rows, values)
    low, high = np.where(np.arange(5) > 2, np.rad2deg(machine.limits.T), machine.limits.T)
    lines = [row.results[-1][1] for row in rows]
    for k, name in enumerate(machine.joint_names):
        outside = (own[:, k] < low[k] - 1e-6) | (own[:, k] > high[k] + 1e-6)
        if beyond := [str(row) for row, out in zip(lines, outside, strict=True) if out]:
            text = f"beyond its travel {low[k]:g} … {high[k]:g} in row{'s' * (len(beyond) > 1)}"
            yield f"{name} {text} {', '.join(beyond[:6])}"
    lengths = np.linalg.norm(axis, axis=1)
    odd = [f"{lines[n]} ({lengths[n]:.4g})" for n in np.flatnonzero(np.abs(lengths - 1) > UNIT_LENGTH)]
    if 0 < 2 * len(odd) < len(rows):
        yield f"the tool axis is no unit vector in row {', '.join(odd[:6])}"
    steps = np.abs(np.diff(own[:, 3:], axis=0)) * (np.diff([row.table for row in rows]) == 0)[:, None]
    for n in np.flatnonzero((steps > FLIP).any(axis=1)):
        jumps = zip(machine.joint_names[3:], steps[n], strict=True)
        jump = " and ".join(f"{name} jumps by {step:.4g}°" for name, step in jumps if step > FLIP)
        yield f"between rows {lines[n]} and {lines[n + 1]} {jump}: a different branch?"
