"""What may go wrong with an angle or a number in a worksheet, as candidates to compare with what stands there.

A candidate is a triple: the kinds that name the slip, a sentence, and what it makes of the range.
"""

from itertools import product

import numpy as np

from mathpost.detective.misreadings import PI_WRITTEN, UNITS
from mathpost.workbook.steps import AXES

CLOSE = 2e-7  # relative: six decimals written
UNIT_PHRASES = {
    "radians": "{} in degrees is taken for radians",
    "twice": "{} is converted to radians twice",
    "reversed": "{} is converted with DEGREES, not with RADIANS",
    "gon": "{} in degrees is taken for gon",
}


def holds(task, role, value):
    """Whether the range of `role` holds `value`, to the digits that are written there and before it."""
    slack = 2 * task.slack.get(role, 0) + CLOSE * np.maximum(1, np.abs(value))
    return bool((np.abs(task.values[role] - value) <= slack).all())


def first_match(task, roles, candidates):
    """The kinds and sentence of the first candidate (kinds, sentence, value) that the ranges hold, or None."""
    roles = roles if isinstance(roles, list) else [roles]
    for kinds, why, value in candidates:
        parts = [np.asarray(value)] if len(roles) == 1 else value
        if all(holds(task, role, part) for role, part in zip(roles, parts, strict=True)):
            return kinds, why
    return None


def roundings(role, expected):
    """Candidates that are the expected value rounded or cut off."""
    for decimals in range(8):
        phrase = f"{role} is rounded to {decimals} decimal{'s' * (decimals != 1)}"
        yield ("rounded",), phrase, np.round(expected, decimals)
        cut = np.trunc(np.asarray(expected) * 10.0**decimals) / 10.0**decimals
        yield ("rounded",), f"{role} is cut off after {decimals} decimal{'s' * (decimals != 1)}", cut


def turns(task, n):
    """What an angle may have been taken for: kinds, sentence, axis and radians."""
    signed = task.sign * task.angles[n]
    name, degrees = name_of(n), np.pi / 180
    flipped = f"{name} is not negated" if task.sign < 0 else f"the sign of {name} is reversed"
    yield ("active", "sign"), flipped, AXES[n], -signed * degrees
    for unit, phrase in UNIT_PHRASES.items():
        yield ("unit",), phrase.format(name), AXES[n], UNITS[unit](signed, np.pi)
    for m in range(3):
        if m != n:
            text = f"{name_of(m)} stands where {name} belongs"
            yield ("reference", "exchange"), text, AXES[n], task.sign * task.angles[m] * degrees
    for axis in "XYZ":
        if axis != AXES[n]:
            yield ("axis",), f"the matrix of {name} is about {axis}, not about {AXES[n]}", axis, signed * degrees
    yield ("left out",), f"{name} is left out", AXES[n], 0.0
    for decimals in range(6):
        text = f"{name} is rounded to {decimals} decimal{'s' * (decimals != 1)}"
        yield ("rounded",), text, AXES[n], np.round(signed, decimals) * degrees
    for pi in PI_WRITTEN:
        yield ("rounded",), f"π is taken as {pi:.6g}", AXES[n], UNITS["degrees"](signed, pi)
    for unit, phrase in UNIT_PHRASES.items():
        yield (
            ("unit", "active", "sign"),
            f"{phrase.format(name)}, and its sign is reversed",
            AXES[n],
            -UNITS[unit](signed, np.pi),
        )
    for m in range(3):
        if m != n:
            text = f"{name_of(m)} stands where {name} belongs, with the wrong sign"
            yield ("reference", "exchange", "sign", "active"), text, AXES[n], -task.sign * task.angles[m] * degrees
    for axis in "XYZ":
        if axis != AXES[n]:
            text = f"the matrix of {name} is about {axis}, not about {AXES[n]}, with the wrong sign"
            yield ("axis", "sign", "active"), text, axis, -signed * degrees
    for unit, (m, axis) in product(UNIT_PHRASES, product(range(3), "XYZ")):
        if m != n or axis != AXES[n]:
            what = UNIT_PHRASES[unit].format(name_of(m))
            text = f"{what}, in a matrix about {axis} where {name} about {AXES[n]} belongs"
            yield ("unit", "axis", "reference"), text, axis, UNITS[unit](task.sign * task.angles[m], np.pi)


def name_of(n):
    return "αβγ"[n]
