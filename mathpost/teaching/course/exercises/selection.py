"""The exercises of lessons 05 to 06b: the inverse, the choice of a solution, the singular region."""

from collections.abc import Sequence

import numpy as np

from mathpost.detective.rotary_axes import explain_joints
from mathpost.path import cl as cldata
from mathpost.path import selection, singular
from mathpost.path.between_blocks import Motion, linearize
from mathpost.path.deviation import strays
from mathpost.rotation import wrap
from mathpost.shop.post.ways import Crossing
from mathpost.sources import yu_dan
from mathpost.sources.yu_dan import equation_8
from mathpost.teaching.course.answers import Angle, Joints, Name, Number, Vector
from mathpost.teaching.course.lesson_data import SWING, blade, largest_swing, load, with_axis, with_travel
from mathpost.teaching.course.verdict import define, slip


@define("05-turn", Angle(decimals=2))
@slip("longitude", lambda: np.degrees(np.arctan2(0.36, -0.48)))
def turned(branch=0, column=4, swapped=False):
    """The sine product i·sin A is negative, and so is the cosine product −j·sin A: C lies in the third quadrant."""
    angle = load("ac_table").inverse([0, 0, 0], [-0.48, 0.36, 0.8], degrees=True)[branch, column]
    return 90 - angle if swapped else angle


@define("05-loop", Vector(names="X Y Z"))
def loop(pivot=-50, sign=1, forward=False):
    """Each turn is undone about its own line, C first because it stands next to the workpiece."""
    kin = with_axis(load("ac_table"), point=(0, 0, pivot))
    if forward:
        return kin.forward([20, -35, 15, -50, 160], degrees=True)[0]
    return kin.close([20, -35, 15], sign * np.radians([-50, 160]))[:3]


AXIS = (0.720216, -0.330099, 0.610183)


@define(
    "05-angles",
    Joints(kinematics=lambda: load("bc_table"), unit="degrees"),
    detective=lambda angles: explain_joints(load("bc_table"), AXIS, np.round(angles, 3)),
)
@slip("arcsine", lambda: both_angles(angles=lambda b, c: (90 - b, c)))
@slip("exchanged", lambda: both_angles(angles=lambda b, c: (b, 90 - c)))
def both_angles(name="bc_table", signs=(1, 1), angles=None):
    """Either branch is right, and C may stand whole turns away: what counts is the tool axis that they make."""
    found = load(name).inverse([0, 0, 0], AXIS, degrees=True)[0, 3:] * signs
    return angles(*found) if angles else found


@define("05-reach", Number(decimals=0, unit="degrees"))
@slip("from the horizontal", lambda: reach(slant=90 - 50))
@slip("once", lambda: 90 + 5)
@slip("less", lambda: 180 - 50)
def reach(slant=50, turn=180):
    """The tool goes round the tilted axis on a cone; half a turn takes it twice the angle of the axis away."""
    slanted = with_axis(load("dmu50v"), axis=(0, np.sin(np.radians(slant)), np.cos(np.radians(slant))))
    return np.degrees(slanted.reach[1]) if turn else slant


def two_positions(axis: Sequence[float]) -> str:
    """Say why the branches of the DMU 50V are not one position at this tool axis."""
    first, second = load("dmu50v").inverse([0, 0, 0], axis, degrees=True)[:, 3]
    if np.isnan(first):
        return "This tool axis is out of reach: it points below the horizontal."
    if axis[2] > 0.999 * np.linalg.norm(axis):
        return "That is straight up. There is another place."
    if abs(wrap(first - second)) > 0.01:
        return f"There B is {first:.3f} on one branch and {second:.3f} on the other: two positions. Tilt further."
    return ""


@define("05-meet", Vector(names="i j k", decimals=None), complaint=two_positions)
def meet():
    """B = 180° and B = -180° are one place of the table. It lays the tool flat, in a direction that C sets."""
    return load("dmu50v").forward([0, 0, 0, 180, 0], degrees=True)[1]


@define("05b-case", Vector(names="row40 row50 row60 row70 row80", decimals=0))
def case(low=-10):
    """Rows 50, 60 and 70 fit on both sides of zero; rows 40 and 80 only on the long one. None is out of reach."""
    return [each.number for each in yu_dan.cases(with_travel(load("dmu50v"), low, 110), blade(), 1)]


@define("05b-kappa", Vector(names="A", decimals=2, unit="degrees", said="one angle"))
@slip("a turn", lambda: kappa() + 360)
def kappa(name="ac_table", prefer=-1):
    """The negative side is the dominant range: κ = 1, and A = (−1)^κ·|A|. C follows, half a turn away."""
    return np.degrees(yu_dan.cases(with_travel(load(name), -120, 5), blade(), prefer)[4].angle)


@define("05b-turns", Vector(names="C1 C2 C3 C4", decimals=0))
def corrected(to=None):
    """Record 2 goes a turn back to be near record 3, and the jump is now one record earlier. The rule moved it."""
    first, second, third, last = 150.0, 170.0, -175.0, -155.0
    if to is None:
        rule = yu_dan.turns(np.radians([first, second, third, last]))
        return [first, *(np.degrees(turn.taken) for turn in rule), last]
    return [first, second, to, to + 20]


@define("05b-count", Number(decimals=0))
def count(low=-540, high=400):
    """C at 90° and -270° on one branch, at -90°, 270° and -450° on the other."""
    found = selection.candidates(with_travel(load("ac_head"), low, high), blade().points, blade().axes)
    return int(found.inside[0].sum())


@define("05b-back", Number(decimals=3, unit="s"))
def back(strategy="shortest", backwards=True, low=-5):
    """Backwards the rule finds the best way. What it finds depends on the direction: it sees one step only."""
    order = slice(None, None, -1) if backwards else slice(None)
    path = cldata.from_arrays(blade().points[order], blade().axes[order])
    return selection.choose(with_travel(load("dmu50v"), low, 110), path, strategy, sway=np.inf).cost


def steps() -> list[list[list[int]]]:
    """Return the costs of moves from each candidate (row) of a record to each of the next (column), seconds."""
    return [[[2, 5], [4, 3]], [[6, 2], [1, 7]], [[1, 3], [5, 6]]]


@define("05b-best", Number(decimals=0, unit="s"), given=steps)
@slip("cheapest moves", lambda: np.min(steps(), (1, 2)).sum())
def best(greedy=False):
    """The way begins with a more expensive move, because it leads to the cheap ones."""
    cost = np.zeros(2)
    for step in np.array(steps(), dtype=float):
        ways = cost[:, None] + step
        cost = ways.min(axis=0)
        if greedy:
            cost[cost > cost.min()] = np.inf
    return cost.min()


def no_trap(answer: Sequence[float]) -> str:
    """Say why the shortest next move is no trap for three tool axes (sin t, 0, cos t)."""
    tilts = np.radians(answer)
    axes = np.stack([np.sin(tilts), 0 * tilts, np.cos(tilts)], axis=1)
    path = cldata.from_arrays(np.tile(blade().points[0], (3, 1)), axes)
    kin = with_travel(load("dmu50v"), -25, 180)
    best, greedy = (selection.choose(kin, path, way, sway=np.inf).cost for way in ("optimal", "shortest"))
    if greedy > best + 0.1:
        return ""
    return f"Both cost {best:.2f} s here. What if the good way in turns out to be a dead end at the third?"


@define("05b-trap", Vector(names="t1 t2 t3", decimals=None, unit="degrees"), complaint=no_trap)
def trap():
    """A tilt beyond 17.6° needs |B| beyond 25°, which only positive B can reach: the near branch has to be left."""
    return (10, -5, -40)


@define("06-price", Number(decimals=1, unit="degrees"))
@slip("sine of B", lambda: 1 / np.sin(np.radians(2.335)))
@slip("closeness", measure=lambda kin, tool: 1 / singular.closeness(kin, tool))
def price(measure=singular.amplification):
    """Near the pole the price is one over the sine of the angle of the *tool* from it, on every machine."""
    _tip, tool = load("dmu50v").forward([0, 0, 0, 2.335, 0], degrees=True)
    return measure(load("dmu50v"), tool)


@define("06-speed", Number(decimals=2, unit="degrees"))
@slip("sine", inverse=lambda x: x)
@slip("tangent", inverse=np.arctan)
@slip("cosine", inverse=np.arccos)
@slip("of d", lambda: 12 / 60)
def speed(inverse=np.arcsin):
    """C may be five times as fast as the tool, so sin d is one fifth."""
    return np.degrees(inverse(12 / 60))


@define("06-region", Number(decimals=2, unit="degrees"))
def nearest(share=None):
    """The circle stays in a plane; the pole is as far from it as it is from being square to the plane's normal."""
    first, last = np.array([-0.05, 0.03, 1]), np.array([0.07, 0.03, 1])
    if share is not None:
        point = first + share * (last - first)
        return np.degrees(np.arccos(point[2] / np.linalg.norm(point)))
    normal = np.cross(first, last)
    return np.degrees(np.arcsin(abs(normal[2]) / np.linalg.norm(normal)))


@define("06-pieces", Number(decimals=0, tolerance=2.5))
@slip("four times", lambda: 4 * pieces(0.01))
def pieces(tolerance=0.0025):
    """Twice as many: the error falls with the square of the number of pieces."""
    joints = selection.choose(load("dmu50v"), blade()).joints
    return len(linearize(load("dmu50v"), joints[1:3], tolerance).joints) - 1


@define("06-yardstick", Number(decimals=1, unit="mm"))
@slip("chord", lambda: 2 * 40 * np.sin(np.radians(60)))
def yardstick(measured=2, angle=120):
    """All its points lie on the line that the control follows anyway: r·(1 − cos 60°), however many there are."""
    kin = load("dmu50v")
    start, end = kin.close([40, 0, 0], np.radians([[0, 0], [0, angle]]))
    return equation_8(kin, start, end, 0.05)[measured]


def no_swing(limits: Sequence[float]) -> str:
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


ROWS = np.array([20.0, 24.0, 150.0, 153.0])  # C at four records, degrees
STEPS = (0.5, 0.4)  # Δt₁ and Δt₂


@define("06b-slopes", Vector(names="k1 k2", decimals=2))
def slopes(dt=STEPS, records=((0, 1), (2, 3))):
    """k₁ comes from the records before the region, k₂ from those after it."""
    return [(ROWS[end] - ROWS[start]) / step for (start, end), step in zip(records, dt, strict=True)]


@define("06b-cubic", Number(decimals=3, unit="degrees"))
@slip("straight", lambda: ROWS[1] + 0.25 * (ROWS[2] - ROWS[1]))
@slip("four points", lambda: yu_dan.paper_cubic(ROWS, 0.25))
def cubic(t=0.25, dt=STEPS):
    """A quarter of the time, and less than a quarter of the way: C is still gathering speed."""
    return yu_dan.clamped(ROWS, 1.0, dt)(t)


@define("06b-points", Number(decimals=0, tolerance=2))
@slip("proportional", lambda: 5 * off(5) / 0.03)
def points(tolerance=0.03):
    """Two points and an estimate by the square bring you near; then count."""
    return next(n for n in range(1, 300) if off(n) <= tolerance)


def off(n: int) -> float:
    """Return how far the tip strays at most with n points of the cubic between records 2 and 3 of the blade, mm."""
    kin, joints = load("dmu50v"), selection.choose(load("dmu50v"), blade()).joints
    place, rows = yu_dan.smooth(kin, blade(), joints, (1, 2), n)
    return strays(kin, blade(), Motion.on_part(rows, place))[0].max()


@define("06b-lift", Vector(decimals=3, unit="mm"))
@slip("along Z", lambda: [0, 0, 5])
def lift(clearance=5):
    """ΔA times the tool axis: along the tool, away from the part."""
    kin = load("dmu50v")
    pose = np.r_[10, 20, 30, np.radians([30, 60])]
    return kin.forward(yu_dan.lifted(kin, pose, clearance))[0] - kin.forward(pose)[0]


@define("06b-seconds", Vector(names="s60 s8", decimals=3, unit="s"))
def seconds(acceleration=100, triangle=True, ramps=1):
    """From rest to rest: a trapezoid takes angle/rate + rate/acceleration, a triangle has no top."""
    times = []
    for angle in (60, 8):
        reached = angle * acceleration >= 36**2
        trapezoid = angle / 36 + ramps * 36 / acceleration
        times.append(trapezoid if reached or not triangle else 2 * np.sqrt(angle / acceleration))
    return times


@define("06b-corner", Number(decimals=3))
def corner(before=-4):
    """The jump is the difference of two speeds with their signs; the override takes it down to what is allowed."""
    return 100 * 0.02 / (32 - before)


WAYS = dict.fromkeys(("direct", "linear", "cubic", "cubic lifted", "aside", "retract"), ())


@define("06b-way", Name(WAYS))
def best_way():
    """The tool axis stands still at the pole while C turns: the tolerances are kept, at a small cost of time."""
    kin = load("dmu50v")
    crossing = Crossing(kin, blade(), selection.choose(kin, blade()).joints, (1, 2))
    ways = [crossing.way(name) for name in WAYS]
    kept = [way for way in ways if way.axis_error <= np.radians(0.2) and way.tip_error <= 0.01]
    return min(kept, key=lambda way: way.time).name
