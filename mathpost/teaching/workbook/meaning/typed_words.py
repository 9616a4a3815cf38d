"""Words of a machine that are numbers without formulas: judged to their digits, and what deserves a look."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

import numpy as np

from mathpost.detective.digits import written_decimals
from mathpost.detective.rotary_axes import JointCase
from mathpost.teaching.workbook.meaning.calculation import nearest
from mathpost.teaching.workbook.meaning.words import UNIT_LENGTH

if TYPE_CHECKING:
    from mathpost.teaching.workbook.meaning.words import Words
    from mathpost.teaching.workbook.sheet.place import Place

FLIP = 60.0  # degrees between two rows that are worth a look


def judge_numbers(rows: list[Words], values: Mapping[Place, float | None]) -> Iterator[tuple[Place, str, str]]:
    """Yield (place, cause, sentence) of the words that are wrong as numbers, place → number, to their digits."""
    kinematics = rows[0].kinematics
    words, tip, axis = (
        np.array([[values[p] for p in getattr(row, part)] for row in rows]) for part in ("results", "point", "axis")
    )
    units = rows[0].units
    half = _half_digits(words[:, :3]) + 2 * _half_digits(tip).max(axis=1, keepdims=True)
    half_angle = (_half_digits(words[:, 3:]) * units).max()
    half_axis = 0.0 if (axis % 1 == 0).all() else _half_digits(axis).max()
    words[:, 3:] *= units
    case = JointCase(kinematics, axis, words[:, 3:], half_angle + 1e-9, half_axis)
    both, spread = case.both_branches(axis)
    slack = spread.max(axis=1) + case.half_digit
    demanded, _ = nearest(words[:, 3:], both, slack=slack[:, None])
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
    single, least = numbers.astype(np.float32), np.full(numbers.shape, 1e-9)
    if written_decimals(numbers) > 8 and np.allclose(numbers, single, rtol=1e-12, atol=0):  # numbers of four bytes
        least = np.maximum(least, np.spacing(np.abs(single)))
        numbers = np.array([float(str(n)) for n in single.ravel()]).reshape(numbers.shape)
    decimals, size = written_decimals(numbers), np.floor(np.log10(np.maximum(np.abs(numbers), 1e-9)))
    longest = max(written_decimals(n) + s for n, s in zip(numbers.ravel(), size.ravel(), strict=True))
    half = 0.5 * np.maximum(10.0**-decimals, 10.0 ** (size - longest))
    return np.maximum(half if decimals < 9 else 0.0, least)


def looked_at(rows: list[Words], values: Mapping[Place, float | None]) -> Iterator[str]:
    """Yield what deserves a look in the present words, place → number: travel, flips between rows."""
    machine = rows[0].kinematics.machine
    own = np.array([[*map(values.get, row.results)] for row in rows], dtype=float)
    own[:, 3:] *= [row.units for row in rows]
    low, high = np.where(np.arange(5) > 2, np.rad2deg(machine.limits.T), machine.limits.T)
    lines = [row.results[-1][1] for row in rows]
    for k, name in enumerate(machine.joint_names):
        outside = (own[:, k] < low[k] - 1e-6) | (own[:, k] > high[k] + 1e-6)
        beyond = [row for row, out in zip(lines, outside, strict=True) if out]
        if beyond:
            text = ", ".join(map(str, beyond[:6]))
            yield f"{name} beyond its travel {low[k]:g} … {high[k]:g} in row{'s' * (len(beyond) > 1)} {text}"
    lengths = np.linalg.norm(np.array([[values.get(p) for p in row.axis] for row in rows], dtype=float), axis=1)
    odd = [f"{lines[n]} ({lengths[n]:.4g})" for n in np.flatnonzero(np.abs(lengths - 1) > UNIT_LENGTH)]
    if 0 < 2 * len(odd) < len(rows):
        yield f"the tool axis is no unit vector in row {', '.join(odd[:6])}"
    steps = np.abs(np.diff(own[:, 3:], axis=0)) * (np.diff([row.table for row in rows]) == 0)[:, None]
    for n in np.flatnonzero((steps > FLIP).any(axis=1)):
        jumps = zip(machine.joint_names[3:], steps[n], strict=True)
        jump = " and ".join(f"{name} jumps by {step:.4g}°" for name, step in jumps if step > FLIP)
        yield f"between rows {lines[n]} and {lines[n + 1]} {jump}: a different branch?"
