"""The exercises of lesson 06: the singular region."""

import numpy as np

from mathpost.course.answers import Number, Vector
from mathpost.course.lesson_data import blade, largest_swing, load, with_travel
from mathpost.course.verdict import define, slip
from mathpost.post import selection, singular
from mathpost.post.motion import equation_8, linearize

SWING = 90.0  # degrees from one record to the next: more is a swing

# 06 The singular region


@define("06-price", Number(decimals=2), hint="How far is the *tool* from the pole there?")
@slip(
    "That is 1/sin B. B is not the tool's angle from the pole: a tilted table moves the tool by less than B.",
    lambda: 1 / np.sin(np.radians(2.335)),
)
@slip(
    "That is 1/|n·(a₁×a₂)|. A turn about an axis at 45° moves the tool by less: see `amplification`.",
    measure=lambda kin, tool: 1 / singular.closeness(kin, tool),
)
def price(measure=singular.amplification):
    """Near the pole the price is one over the angle of the *tool* from it, in radians, on every machine."""
    _tip, tool = load("dmu50v").forward([0, 0, 0, 2.335, 0], degrees=True)
    return measure(load("dmu50v"), tool)


@define("06-pieces", Number(decimals=0, tolerance=2.5), hint="How does the error fall with the number of pieces?")
@slip(
    "A quarter of the error needs twice the pieces, not four times: the error falls with the square.",
    lambda: 4 * pieces(0.01),
)
@slip("That is the number for 0.01 mm.", tolerance=0.01)
def pieces(tolerance=0.0025):
    """Twice as many: the error falls with the square of the number of pieces."""
    joints = selection.choose(load("dmu50v"), blade()).joints
    return len(linearize(load("dmu50v"), joints[1:3], tolerance).joints) - 1


@define(
    "06-yardstick", Number(decimals=1, unit="mm"), hint="Compare the tip on the way with the line of the CL data."
)
@slip("That is what it claims, measured against its own chords. Where should the tip be?", measured=1)
def yardstick(measured=2):
    """All its points lie on the line that the control follows anyway. Measure against the CL data."""
    start, end = selection.choose(load("dmu50v"), blade()).joints[1:3]
    return equation_8(load("dmu50v"), start, end, 0.01)[measured]


def no_swing(limits):
    """Say why these limits of A force no swing of C for the blade on the trunnion."""
    low, high = limits
    if not -180 <= low < high <= 180:
        return "Give the lower and the upper limit in degrees, between -180 and 180."
    swing = largest_swing(with_travel(load("ac_table"), low, high))
    return "" if swing > SWING else f"With A from {low:g} to {high:g} C turns by {swing:.1f}° at most: no swing."


@define("06-limits", Vector(names="low high", decimals=None, unit="degrees"), complaint=no_swing)
def limits():
    """Neither the first two records nor the last three may fit below zero; then A has to turn back at the pole."""
    return next((low, 120) for low in (-20, -10, -5, 0) if not no_swing((low, 120)))
