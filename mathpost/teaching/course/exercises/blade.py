"""The exercises of lessons 07 and 07b, the blade and on the control, and the programs of 06b and 07."""

from functools import cache

import numpy as np

from mathpost import postprocess
from mathpost.path import cl as cldata
from mathpost.path.between_blocks import linearize
from mathpost.path.deviation import from_segment
from mathpost.shop.controls.reader import read
from mathpost.shop.post.proof import joints_of
from mathpost.sources import yu_dan
from mathpost.teaching.course.answers import Name, Number, Vector
from mathpost.teaching.course.exercises.selection import WAYS
from mathpost.teaching.course.judged_program import AXIS, LIFTED, TIP, Program, unproved
from mathpost.teaching.course.lesson_data import SWING, blade, data, largest_swing, load, with_axis, with_travel
from mathpost.teaching.course.match import match
from mathpost.teaching.course.verdict import define, slip

ROWS = (40, 50, 60, 70, 80)
ROUNDED = 0.005 * (1 + 1e-6)  # degrees by which rounding may change 07-lowest
SPOILT = 12  # the move of 07-block that is spoilt, counted from 0
FEED = 800  # mm/min of the path of 07-alone


@define("07-pivot", Name("40 50 60 70 80"))
def pivot():
    """The tip moves by 2·sin(B/2) times the shift, so the row with the greatest B moves furthest."""
    kin = load("dmu50v")
    moved = with_axis(kin, point=(50.1, 0, 0))
    rotary = kin.inverse(blade().points, blade().axes)[:, 0, 3:]
    shift = moved.close(blade().points, rotary) - kin.close(blade().points, rotary)
    return ROWS[np.linalg.norm(shift[:, :3], axis=1).argmax()]


def table(number: int) -> np.ndarray:
    """Return the printed joints of a table of source 002, mm and degrees."""
    return np.loadtxt(data(f"tables/yu_dan_table_{number}.csv"), delimiter=",", skiprows=2)[:, 1:]


@define("07-next", Vector(names="B C", unit="degrees"))
@slip("clamped", curve=yu_dan.paper_clamped)
@slip("straight", curve=lambda rows, t: rows[1] + t * (rows[2] - rows[1]))
def next_point(curve=yu_dan.paper_cubic, t=0.975):
    """A step of 0.2 from t = 0.775; no row of table 3 is needed, only the four rows that the cubic passes."""
    return curve(table(2)[:4], t)[3:]


@define("07-time", Number(decimals=3))
@slip("straight", lambda: (178.52 - 90) / (178.52 - 1.144))
@slip("clamped", curve=yu_dan.paper_clamped)
def time_of(curve=yu_dan.paper_cubic, c=90.0):
    """The root of C(t) = 90°, found by halving; the same equation gave all five times."""
    from scipy.optimize import brentq  # slow to load, and no other lesson needs it

    rows = table(2)[:4]
    return brentq(lambda t: curve(rows, t)[4] - c, 0, 1)


@define("07-pieces", Number(decimals=0, tolerance=1.5))
@slip("whole way", rows=slice(1, 8, 6))
def pieces(rows=slice(4, 6), tolerance=0.01):
    """A swing of C by 37° about a tip 77 mm away; the error falls with the square of the number of pieces."""
    kin, printed = load("dmu50v"), table(3)[rows]
    ends = kin.close(np.broadcast_to(blade().points[1], (len(printed), 3)), np.radians(printed[:, 3:]))
    return len(linearize(kin, ends, tolerance).joints) - 1


@cache
def spoilt_program() -> str:
    """The blade's program, B from -25°, with two decimals of one C word exchanged: enough to miss the part."""
    text = postprocess(blade(), with_travel(load("dmu50v"), -25, 180).machine).program
    move = [line for line in text.splitlines() if " L " in line][SPOILT]
    head, word = move.rsplit("C", 1)
    return text.replace(move, f"{head}C{word[:6]}{word[7]}{word[6]}{word[8:]}")


@define("07-block", Number(decimals=0), given=spoilt_program)
@slip("moves from 0", lambda: SPOILT)
@slip("moves from 1", lambda: SPOILT + 1)
@slip("after", lambda: block() + 1)
def block():
    """In one block only the tip leaves the CL data, by a tenth of a millimetre; no glance at the words shows it."""
    kin = with_travel(load("dmu50v"), -25, 180)
    tips, _ = kin.forward(read(spoilt_program(), kin.machine).joints)
    middle = np.median(tips, axis=0)  # the blade's five tips are all within 0.01 mm
    moves = [line for line in spoilt_program().splitlines() if " L " in line]
    return int(moves[np.linalg.norm(tips - middle, axis=1).argmax()].split()[0])


def not_lowest(low: float) -> str:
    """Say why B from `low` does not avoid the swing, or that less travel does, too."""
    if not -180 <= low <= 180:
        return "Give a limit of B in degrees, between -180 and 180."
    if low > 0:
        return "That is how far B has to go below zero. The limit itself is a negative angle."
    rounded = low - ROUNDED, low + ROUNDED
    swing, swing_with_less = (largest_swing(with_travel(load("dmu50v"), bound, 180)) for bound in rounded)
    if swing > SWING:
        return f"With B from {low:g} C still swings by {swing:.1f}°."
    if swing_with_less <= SWING:
        before, after = np.degrees(load("dmu50v").inverse(blade().points, blade().axes)[[0, 4], 0, 3])
        why = f"But the first record, which is the deepest below zero then, needs {-before:.2f}° only."
        if low <= -after:
            why = f"But the last record needs {-after:.2f}° only, and the path may also begin on the other branch."
        return f"With B from {low:g} there is no swing. {why}"
    return ""


@define("07-lowest", Number(decimals=2, unit="degrees"), complaint=not_lowest)
def lowest():
    """One half of the swing of the tool must be made with B below zero: take the smaller half."""
    b = np.degrees(load("dmu50v").inverse(blade().points, blade().axes)[:, 0, 3])
    before, after = b[:2].max(), b[2:].max()
    return -min(before, after) - 1e-3


@define("07-way", Name(WAYS))
def way():
    """It keeps both tolerances, and while C turns the tool is in the air."""
    return "retract"


@cache
def new_path() -> str:
    """The text of a CL file: a hollow flank, the tool tilting past the pole at 0.6° from it."""
    across, tilt = np.linspace(-20, 20, 11), np.radians(np.linspace(-14, 11, 11))
    points = np.stack([across, 30 + across**2 / 50, 10 - across / 10], axis=1)
    axes = np.stack([np.sin(tilt), np.full(11, np.sin(np.radians(0.6))), np.cos(tilt)], axis=1)
    return cldata.to_text(cldata.from_arrays(points, axes, feed=FEED), title="flank")


def not_alone(text: str) -> str:
    """Say what is wrong with a program for the new path."""
    return unproved(text, load("bc_table"), cldata.parse(new_path(), "the CL data"))


@define("07-alone", Program(), given=new_path, complaint=not_alone)
def alone():
    """Read back, it reaches every record in order at its feed, and keeps both tolerances between them."""
    return postprocess(cldata.parse(new_path()), load("bc_table").machine, name="flank").program


ON_THE_CUBIC, SWUNG = 0.05, 10.0  # degrees


@cache
def ridge() -> str:
    """The text of a CL file: six records along a ridge, the pole between the third and the fourth."""
    tilt, heading, along = np.radians([-11, -6.5, -2.2, 1.6, 6, 11]), np.radians(40), np.arange(6.0)
    points = np.stack([20 + 3 * along, 45 - along, 12 + along**2 / 10], axis=1)
    axes = np.stack([np.sin(tilt) * np.cos(heading), np.sin(tilt) * np.sin(heading), np.cos(tilt)], axis=1)
    return cldata.to_text(cldata.from_arrays(points, axes, feed=FEED), title="ridge")


def not_whole(text: str) -> str:
    """Say what is wrong with a program that is to swing C in the air, on the cubic of equation (7)."""
    kin, path = load("dmu50v"), cldata.parse(ridge(), "the CL data")
    if why := unproved(text, kin, path):
        return why
    joints = joints_of(kin, read(text, kin.machine))
    record = match(kin, path, joints, tip=TIP, axis=np.radians(AXIS)).blocks
    swing = int(np.abs(np.diff(joints[record, 4])).argmax())
    poses, ends = joints[record[swing] : record[swing + 1] + 1], path.points[swing : swing + 2]
    high = from_segment(kin.forward(poses)[0], *ends) > LIFTED
    in_cut = ~(high[:-1] & high[1:])
    if np.abs(np.diff(poses[:, 4]))[in_cut].sum() > np.radians(SWUNG):
        return "The tool stays on the part while C swings. Lift it before, and return it behind."
    curve = np.degrees(yu_dan.clamped(joints[record][swing - 1 : swing + 3, 3:])(np.linspace(0, 1, 20_001)))
    for b, c in np.degrees(poses[high, 3:]):
        off = np.abs(curve - [b, c]).max(axis=1)
        if off.min() > ON_THE_CUBIC:
            there = curve[np.abs(curve[:, 1] - c).argmin(), 0]
            return f"In the air B {b:.3f} C {c:.3f} is not on the cubic: at this C it has B {there:.3f}."
    return ""


@define("06b-whole", Program(), given=ridge, complaint=not_whole)
def on_the_cubic():
    """Read back, it keeps tip, arc and feed in cut, and in the air each block ends on the cubic of equation (7)."""
    return postprocess(cldata.parse(ridge()), load("dmu50v").machine, singular="cubic lifted", name="ridge").program


@define("07b-stop", Number(decimals=3, unit="s"))
def stop(c=800.0, x=2000.0):
    """Parts of the block per s and s²: the axis that accelerates least rules; the full speed is 10 parts per s."""
    pull, speed = min(c / 6, x / 2), 1 / 0.1
    return 1 / speed + speed / pull if speed**2 < pull else 2 / np.sqrt(pull)


@define("07b-overlap", Number(decimals=3, unit="s"))
def overlap(half=0.5, overlaps=9):
    """Of ten blocks each begins when the one before begins to slow down, nine times in all."""
    pull, speed = half * min(800 / 6, 2000 / 2), 1 / 0.1
    speed = min(speed, np.sqrt(pull))
    return 10 * (1 / speed + speed / pull) - overlaps * speed / pull


@define("07b-feed", Vector(names="degrees inverse", decimals=3))
def still(per=60, inverse=True):
    """180° at 36°/s take 5 s: F in degrees per minute, and one over the minutes."""
    return 36 * per, (60 / 5 if inverse else 5)
