"""The exercises of lessons 05 to 07: inverse and selection, the singular region, the blade."""

from dataclasses import replace
from functools import cache

import numpy as np

from mathpost import machine
from mathpost.course.verdict import data, exercise
from mathpost.detective.rotary_axes import explain_joints
from mathpost.kinematics import Kinematics
from mathpost.post import cl as cldata
from mathpost.post import program, run, selection, singular
from mathpost.post.motion import equation_8, linearize
from mathpost.rotation import wrap

ROWS = (40, 50, 60, 70, 80)
SWING = 90.0  # degrees from one record to the next: more is a swing
BLOCK = 13  # the block of 07-block that is spoilt


@cache
def load(name):
    """The kinematics of a machine of the course by the name of its file."""
    return Kinematics(machine.load(data(f"machines/{name}.toml")))


@cache
def blade():
    """Table 1 of source 002."""
    return cldata.read(data("cl/blade.cl"))


def with_travel(kin, low, high):
    """The kinematics of the same machine with other limits, in degrees, of its first rotary axis."""
    first, second = kin.machine.rotary
    return Kinematics(
        replace(kin.machine, rotary=(replace(first, limits=(np.radians(low), np.radians(high))), second))
    )


def rotary_angles(kin, cl, strategy="optimal"):
    """The chosen rotary angles in degrees, shape (n, 2)."""
    return np.degrees(selection.choose(kin, cl, strategy).joints[:, 3:])


def largest_swing(kin):
    """How far C turns at most from one record of the blade to the next, degrees."""
    return np.abs(np.diff(rotary_angles(kin, blade())[:, 1])).max()


# 05 The inverse, and which solution to take


def judge_meeting(axis):
    """Whether both branches of the DMU 50V are one position for this tool axis, which must not be straight up."""
    first, second = load("dmu50v").inverse([0, 0, 0], axis, degrees=True)[:, 3]
    if np.isnan(first):
        return "This tool axis is out of reach: it points below the horizontal."
    if axis[2] > 0.999 * np.linalg.norm(axis):
        return "That is straight up. There is another place."
    if abs(wrap(first - second)) > 0.01:
        return f"There B is {first:.3f} on one branch and {second:.3f} on the other: two positions. Tilt further."
    return ""


@exercise(
    "05-meet",
    judge=judge_meeting,
    wrong={
        "That is straight up": lambda: (0, 0, 1),
        "two positions": lambda: (1, 0, 1),
        "out of reach": lambda: (0, 0, -1),
    },
)
def meet():
    """B = 180° and B = -180° are one place of the table. It lays the tool flat, in any direction that C likes."""
    return load("dmu50v").forward([0, 0, 0, 180, 0], degrees=True)[1]


@exercise(
    "05-angles",
    seen_as=lambda angles: load("dmu50v").forward([0, 0, 0, *angles], degrees=True)[1],
    tolerance=2e-5,
    wrong={
        "That stands in table 2 of the paper. Send it through the forward kinematics and compare the tool axis.": (
            lambda: np.loadtxt(data("tables/yu_dan_table_2.csv"), delimiter=",", skiprows=2)[3, 4:]
        ),
    },
    detective=lambda angles: explain_joints(load("dmu50v"), blade().axes[3].round(6), np.round(angles, 3)),
)
def record_4():
    """Either branch is right, and C may stand whole turns away: what counts is the tool axis that they make."""
    return load("dmu50v").inverse(blade().points[3], blade().axes[3], degrees=True)[0, 3:]


@exercise(
    "05-count",
    tolerance=0.1,
    wrong={
        "Two branches, yes; but C may also stand a whole turn away from either.": lambda: 2,
        "Some of these are outside the travel of C, -360° to 360°.": lambda: head_candidates().joints.shape[1],
    },
)
def count():
    """Two branches, and for each of them C and C less (or more) one whole turn."""
    found = selection.candidates(load("ac_head"), blade().points, blade().axes)
    return int(found.inside[0].sum())


def head_candidates():
    return selection.candidates(load("ac_head"), blade().points, blade().axes)


@exercise(
    "05-jump",
    tolerance=5e-3,
    wrong={
        "That is the paper's choice, the smaller step of B; C pays for it with half a turn.": (
            lambda: rotary_angles(with_travel(load("dmu50v"), -25, 180), blade(), "paper")[2, 0]
        ),
        "That is record 2.": lambda: rotary_angles(load("dmu50v"), blade())[1, 0],
    },
)
def jump():
    """Through zero and on: the other branch continues where this one would turn back."""
    kin = with_travel(load("dmu50v"), -25, 180)
    return rotary_angles(kin, blade())[2, 0]


def judge_trap(tilts):
    """Whether the shortest next move costs more than the optimum for three tool axes (sin t, 0, cos t)."""
    tilts = np.radians(tilts)
    axes = np.stack([np.sin(tilts), 0 * tilts, np.cos(tilts)], axis=1)
    path = cldata.from_arrays(np.tile(blade().points[0], (3, 1)), axes)
    kin = with_travel(load("dmu50v"), -25, 180)
    # With any sway allowed, a swing costs time and breaks nothing.
    best, greedy = (selection.choose(kin, path, way, sway=np.inf).cost for way in ("optimal", "shortest"))
    if greedy > best + 0.1:
        return ""
    return f"Both cost {best:.2f} s here. What if the good way in turns out to be a dead end at the third?"


@exercise("05-trap", judge=judge_trap, wrong={"Both cost": lambda: (10, 5, 3)})
def trap():
    """Beyond 25° on that side B cannot go below zero, so the branch that was nearest at first has to be left."""
    return (10, -5, -40)


# 06 The singular region


@exercise(
    "06-price",
    tolerance=0.01,
    wrong={
        "That is 1/sin B. B is not the tool's angle from the pole: a tilted table moves the tool by less than B.": (
            lambda: 1 / np.sin(np.radians(2.335))
        ),
        "That is 1/|n·(a₁×a₂)|. A turn about an axis at 45° moves the tool by less: see `amplification`.": (
            lambda: 1 / singular.closeness(load("dmu50v"), tool_at(2.335))
        ),
    },
)
def price():
    """Near the pole the price is one over the angle of the *tool* from it, in radians, on every machine."""
    kin = load("dmu50v")
    tool = kin.forward([0, 0, 0, 2.335, 0], degrees=True)[1]
    return singular.amplification(kin, tool)


def tool_at(b):
    return load("dmu50v").forward([0, 0, 0, b, 0], degrees=True)[1]


@exercise(
    "06-pieces",
    tolerance=2.5,
    wrong={
        "A quarter of the error needs twice the pieces, not four times: the error falls with the square.": (
            lambda: 4 * swing_pieces(0.01)
        ),
        "That is the number for 0.01 mm.": lambda: swing_pieces(0.01),
    },
)
def pieces():
    """Twice as many: the error falls with the square of the number of pieces."""
    kin = load("dmu50v")
    joints = selection.choose(kin, blade()).joints
    return len(linearize(kin, joints[1:3], 0.0025).joints) - 1


def swing_pieces(tolerance):
    kin = load("dmu50v")
    return len(linearize(kin, selection.choose(kin, blade()).joints[1:3], tolerance).joints) - 1


@exercise(
    "06-yardstick",
    tolerance=0.05,
    wrong={
        "That is what it claims, measured against its own chords. Where should the tip be?": (
            lambda: equation_8(load("dmu50v"), *swing_ends(), 0.01)[1]
        ),
    },
)
def yardstick():
    """All its points lie on the line that the control follows anyway. Measure against the CL data."""
    kin = load("dmu50v")
    start, end = selection.choose(kin, blade()).joints[1:3]
    return equation_8(kin, start, end, 0.01)[2]


def swing_ends():
    return selection.choose(load("dmu50v"), blade()).joints[1:3]


def judge_limits(limits):
    """Whether these limits of A on the trunnion force C to swing for the blade."""
    low, high = limits
    if not -180 <= low < high <= 180:
        return "Give the lower and the upper limit in degrees, between -180 and 180."
    swing = largest_swing(with_travel(load("ac_table"), low, high))
    return "" if swing > SWING else f"With A from {low:g} to {high:g} C turns by {swing:.1f}° at most: no swing."


@exercise(
    "06-limits",
    judge=judge_limits,
    wrong={"no swing": lambda: (-10, 120), "is outside": lambda: (0, 5)},
)
def limits():
    """Neither the first two records nor the last three may fit below zero; then A has to turn back at the pole."""
    return next((low, 120) for low in (-20, -10, -5, 0) if not judge_limits((low, 120)))


# 07 The blade


@exercise(
    "07-pivot",
    tolerance=0.1,
    wrong={
        "It lies nearest to the pole, where angles are uncertain. But a shifted pivot moves what B turns *far*.": (
            lambda: 60
        ),
        "Second: which row has the greatest B?": lambda: 40,
    },
)
def pivot():
    """The tip moves by 2·sin(B/2) times the shift, so the row with the greatest B moves furthest."""
    kin = load("dmu50v")
    tilting, turning = kin.machine.rotary
    moved = Kinematics(replace(kin.machine, rotary=(replace(tilting, point=(50.1, 0, 0)), turning)))
    rotary = kin.inverse(blade().points, blade().axes)[:, 0, 3:]
    shift = moved.close(blade().points, rotary) - kin.close(blade().points, rotary)
    return ROWS[np.linalg.norm(shift[:, :3], axis=1).argmax()]


@cache
def blade_program():
    """The blade's program with B from -25°, verified."""
    return run(blade(), with_travel(load("dmu50v"), -25, 180).machine)


def spoilt_program():
    """The same with two decimals of one C word exchanged: too little to see, enough to miss the part."""
    lines = blade_program().program.splitlines()
    line = next(number for number, text in enumerate(lines) if text.startswith(f"{BLOCK} "))
    head, word = lines[line].rsplit("C", 1)
    lines[line] = f"{head}C{word[:6]}{word[7]}{word[6]}{word[8:]}"
    return "\n".join(lines) + "\n"


@exercise(
    "07-block",
    tolerance=0.1,
    given=spoilt_program,
    wrong={
        "You count from 0, the control's blocks from 1.": lambda: BLOCK - 1,
        "That is the block after: its move starts from the wrong place, but it ends in the right one.": (
            lambda: BLOCK + 1
        ),
    },
)
def block():
    """In one block only the tip leaves the CL data, by a tenth of a millimetre; no glance at the words shows it."""
    kin = with_travel(load("dmu50v"), -25, 180)
    tips, _ = kin.forward(program.read(spoilt_program(), kin.machine).joints)
    middle = np.median(tips, axis=0)  # the blade's five tips are all within 0.01 mm
    return int(np.linalg.norm(tips - middle, axis=1).argmax()) + 1


def judge_lowest(low):
    """Whether B from `low` avoids the swing, and no less travel does."""
    if not -180 <= low <= 180:
        return "Give a limit of B in degrees, between -180 and 180."
    swings = [largest_swing(with_travel(load("dmu50v"), bound, 180)) > SWING for bound in (low, low + 0.02)]
    if swings[0]:
        return f"With B from {low:g} C still swings by {largest_swing(with_travel(load('dmu50v'), low, 180)):.1f}°."
    if not swings[1]:
        return "No swing, but B need not go so far: the path may also begin on the other branch."
    return ""


@exercise(
    "07-lowest",
    judge=judge_lowest,
    tolerance=5e-3,
    wrong={
        "C still swings": lambda: -5,
        "begin on the other branch": lambda: rotary_angles(with_travel(load("dmu50v"), -25, 180), blade())[-1, 0],
    },
)
def lowest():
    """One half of the swing of the tool must be made with B below zero: take the smaller half."""
    b = rotary_angles(load("dmu50v"), blade())[:, 0]
    before, after = b[:2].max(), b[2:].max()
    return -min(before, after) - 1e-3
