"""The exercises of lessons 06 and 07: the singular region, the blade."""

from dataclasses import replace
from functools import cache

import numpy as np

from mathpost.course.answers import Name, Number, Vector
from mathpost.course.lesson_data import blade, load, with_travel
from mathpost.course.verdict import define, slip
from mathpost.kinematics import Kinematics
from mathpost.post import program, run, selection, singular
from mathpost.post.motion import equation_8, linearize

ROWS = (40, 50, 60, 70, 80)
SWING = 90.0  # degrees from one record to the next: more is a swing
BLOCK = 13  # the block of 07-block that is spoilt


def rotary_angles(kin, strategy="optimal"):
    """The rotary angles chosen for the blade, in degrees, shape (5, 2)."""
    return np.degrees(selection.choose(kin, blade(), strategy).joints[:, 3:])


def largest_swing(kin):
    """How far C turns at most from one record of the blade to the next, degrees."""
    return np.abs(np.diff(rotary_angles(kin)[:, 1])).max()


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


# 07 The blade


@define(
    "07-pivot", Name("40 50 60 70 80"), hint="By how much does a turn by B move a point whose pivot is shifted?"
)
@slip("Nearest to the pole, where angles are uncertain. But a shifted pivot moves what B turns *far*.", "60")
@slip("Second: which row has the greatest B?", "40")
def pivot():
    """The tip moves by 2·sin(B/2) times the shift, so the row with the greatest B moves furthest."""
    kin = load("dmu50v")
    tilting, turning = kin.machine.rotary
    moved = Kinematics(replace(kin.machine, rotary=(replace(tilting, point=(50.1, 0, 0)), turning)))
    rotary = kin.inverse(blade().points, blade().axes)[:, 0, 3:]
    shift = moved.close(blade().points, rotary) - kin.close(blade().points, rotary)
    return ROWS[np.linalg.norm(shift[:, :3], axis=1).argmax()]


@cache
def spoilt_program():
    """The blade's program, B from -25°, with two decimals of one C word exchanged: enough to miss the part."""
    lines = run(blade(), with_travel(load("dmu50v"), -25, 180).machine).program.splitlines()
    line = next(number for number, text in enumerate(lines) if text.startswith(f"{BLOCK} "))
    head, word = lines[line].rsplit("C", 1)
    lines[line] = f"{head}C{word[:6]}{word[7]}{word[6]}{word[8:]}"
    return "\n".join(lines) + "\n"


@define(
    "07-block",
    Number(decimals=0),
    given=spoilt_program,
    hint="Read the program back: in which block do tip and tool axis leave the CL data?",
)
@slip("You count from 0, the control's blocks from 1.", lambda: block() - 1)
@slip(
    "That is the block after: its move starts from the wrong place, but it ends in the right one.",
    lambda: block() + 1,
)
def block():
    """In one block only the tip leaves the CL data, by a tenth of a millimetre; no glance at the words shows it."""
    kin = with_travel(load("dmu50v"), -25, 180)
    tips, _ = kin.forward(program.read(spoilt_program(), kin.machine).joints)
    middle = np.median(tips, axis=0)  # the blade's five tips are all within 0.01 mm
    return int(np.linalg.norm(tips - middle, axis=1).argmax()) + 1


def not_lowest(low):
    """Say why B from `low` does not avoid the swing, or that less travel does, too."""
    if not -180 <= low <= 180:
        return "Give a limit of B in degrees, between -180 and 180."
    swing, swing_with_less = (largest_swing(with_travel(load("dmu50v"), bound, 180)) for bound in (low, low + 0.02))
    if swing > SWING:
        return f"With B from {low:g} C still swings by {swing:.1f}°."
    if swing_with_less <= SWING:
        return "No swing, but B need not go so far: the path may also begin on the other branch."
    return ""


@define("07-lowest", Number(decimals=2, unit="degrees"), complaint=not_lowest)
def lowest():
    """One half of the swing of the tool must be made with B below zero: take the smaller half."""
    b = rotary_angles(load("dmu50v"))[:, 0]
    before, after = b[:2].max(), b[2:].max()
    return -min(before, after) - 1e-3
