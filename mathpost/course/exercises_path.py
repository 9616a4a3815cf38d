"""The exercises of lessons 06 and 06b: the singular region, and the ways through it in real seconds."""

import numpy as np

from mathpost.course.answers import Name, Number, Vector
from mathpost.course.lesson_data import SWING, blade, largest_swing, load, of_lesson, with_travel
from mathpost.course.verdict import slip
from mathpost.post import selection, singular, yu_dan
from mathpost.post.between_blocks import deviation
from mathpost.post.motion import equation_8, linearize
from mathpost.post.ways import Crossing

# 06 The singular region


@of_lesson("06-price", Number(decimals=2))
@slip("sine of B", lambda: 1 / np.sin(np.radians(2.335)))
@slip("closeness", measure=lambda kin, tool: 1 / singular.closeness(kin, tool))
def price(measure=singular.amplification):
    """Near the pole the price is one over the angle of the *tool* from it, in radians, on every machine."""
    _tip, tool = load("dmu50v").forward([0, 0, 0, 2.335, 0], degrees=True)
    return measure(load("dmu50v"), tool)


@of_lesson("06-speed", Number(decimals=2, unit="degrees"))
@slip("sine", inverse=lambda x: x)
@slip("tangent", inverse=np.arctan)
@slip("cosine", inverse=np.arccos)
def speed(inverse=np.arcsin):
    """C may be five times as fast as the tool, so sin d is one fifth."""
    return np.degrees(inverse(12 / 60))


@of_lesson("06-region", Number(decimals=2, unit="degrees"))
def nearest(share=None):
    """The circle stays in a plane; the pole is as far from it as it is from being square to the plane's normal."""
    first, last = np.array([-0.05, 0.03, 1]), np.array([0.07, 0.03, 1])
    if share is not None:
        point = first + share * (last - first)
        return np.degrees(np.arccos(point[2] / np.linalg.norm(point)))
    normal = np.cross(first, last)
    return np.degrees(np.arcsin(abs(normal[2]) / np.linalg.norm(normal)))


@of_lesson("06-pieces", Number(decimals=0, tolerance=2.5))
@slip("four times", lambda: 4 * pieces(0.01))
def pieces(tolerance=0.0025):
    """Twice as many: the error falls with the square of the number of pieces."""
    joints = selection.choose(load("dmu50v"), blade()).joints
    return len(linearize(load("dmu50v"), joints[1:3], tolerance).joints) - 1


@of_lesson("06-yardstick", Number(decimals=1, unit="mm"))
@slip("chord", lambda: 2 * 40 * np.sin(np.radians(60)))
def yardstick(measured=2, angle=120):
    """All its points lie on the line that the control follows anyway: r·(1 − cos 60°), however many there are."""
    kin = load("dmu50v")
    start, end = kin.close([40, 0, 0], np.radians([[0, 0], [0, angle]]))
    return equation_8(kin, start, end, 0.05)[measured]


def no_swing(limits):
    """Say why these limits of A force no swing of C for the blade on the trunnion."""
    low, high = limits
    if not -180 <= low < high <= 180:
        return "Give the lower and the upper limit in degrees, between -180 and 180."
    swing = largest_swing(with_travel(load("ac_table"), low, high))
    return "" if swing > SWING else f"With A from {low:g} to {high:g} C turns by {swing:.1f}° at most: no swing."


@of_lesson("06-limits", Vector(names="low high", decimals=None, unit="degrees"), complaint=no_swing)
def limits():
    """Neither the first two records nor the last three may fit below zero; then A has to turn back at the pole."""
    return next((low, 120) for low in (-20, -10, -5, 0) if not no_swing((low, 120)))


# 06b Through it

ROWS = np.array([20.0, 24.0, 150.0, 153.0])  # C at four records, degrees
STEPS = (0.5, 0.4)  # Δt₁ and Δt₂


@of_lesson("06b-slopes", Vector(names="k1 k2", decimals=2))
def slopes(dt=STEPS, records=((0, 1), (2, 3))):
    """k₁ comes from the records before the region, k₂ from those after it."""
    return [(ROWS[end] - ROWS[start]) / step for (start, end), step in zip(records, dt, strict=True)]


@of_lesson("06b-cubic", Number(decimals=3, unit="degrees"))
@slip("straight", lambda: ROWS[1] + 0.25 * (ROWS[2] - ROWS[1]))
def cubic(t=0.25, dt=STEPS):
    """A quarter of the time, and less than a quarter of the way: C is still gathering speed."""
    return yu_dan.clamped(ROWS, 1.0, dt)(t)


@of_lesson("06b-points", Number(decimals=0, tolerance=2))
@slip("proportional", lambda: 5 * off(5) / 0.03)
def points(tolerance=0.03):
    """Two points and an estimate by the square bring you near; then count."""
    return next(n for n in range(1, 300) if off(n) <= tolerance)


def off(n):
    """How far the tip strays at most with n points of the cubic between records 2 and 3 of the blade, mm."""
    kin, joints = load("dmu50v"), selection.choose(load("dmu50v"), blade()).joints
    place, rows = yu_dan.smooth(kin, blade(), joints, (1, 2), n)
    tips, _ = blade().at(place)
    return deviation(kin, rows[:-1], rows[1:], tips=(tips[:-1], tips[1:]))[0].max()


@of_lesson("06b-lift", Vector(decimals=3, unit="mm"))
@slip("along Z", lambda: [0, 0, 5])
def lift(clearance=5):
    """ΔA times the tool axis: along the tool, away from the part."""
    kin = load("dmu50v")
    pose = np.r_[10, 20, 30, np.radians([30, 60])]
    return kin.forward(yu_dan.lifted(kin, pose, clearance))[0] - kin.forward(pose)[0]


@of_lesson("06b-seconds", Vector(names="s60 s8", decimals=3, unit="s"))
def seconds(acceleration=100, triangle=True):
    """From rest to rest: a trapezoid takes angle/rate + rate/acceleration, a triangle has no top."""
    times = []
    for angle in (60, 8):
        reached = angle * acceleration >= 36**2
        trapezoid = angle / 36 + 36 / acceleration
        times.append(trapezoid if reached or not triangle else 2 * np.sqrt(angle / acceleration))
    return times


@of_lesson("06b-corner", Number(decimals=3))
def corner(before=-4):
    """The jump is the difference of two speeds with their signs; the override takes it down to what is allowed."""
    return 100 * 0.02 / (32 - before)


@of_lesson("06b-way", Name("direct linear cubic aside retract"))
def best_way():
    """The tool axis stands still at the pole while C turns: the tolerances are kept, at a small cost of time."""
    kin = load("dmu50v")
    crossing = Crossing(kin, blade(), selection.choose(kin, blade()).joints, (1, 2))
    ways = [crossing.way(name) for name in ("direct", "linear", "cubic", "aside", "retract")]
    kept = [way for way in ways if way.axis_error <= np.radians(0.2) and way.tip_error <= 0.01]
    return min(kept, key=lambda way: way.time).name
