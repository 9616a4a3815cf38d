"""The exercises of lesson 07: the blade."""

from dataclasses import replace
from functools import cache

import numpy as np

from mathpost.course.answers import Name, Number
from mathpost.course.lesson_data import blade, load, with_travel
from mathpost.course.verdict import define, slip
from mathpost.kinematics import Kinematics
from mathpost.post import program, run, selection

ROWS = (40, 50, 60, 70, 80)
SWING = 90.0  # degrees from one record to the next: more is a swing
BLOCK = 13  # the block of 07-block that is spoilt


def rotary_angles(kin, strategy="optimal"):
    """The rotary angles chosen for the blade, in degrees, shape (5, 2)."""
    return np.degrees(selection.choose(kin, blade(), strategy).joints[:, 3:])


def largest_swing(kin):
    """How far C turns at most from one record of the blade to the next, degrees."""
    return np.abs(np.diff(rotary_angles(kin)[:, 1])).max()


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
