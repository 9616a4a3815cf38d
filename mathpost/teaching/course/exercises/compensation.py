"""The exercises of lessons 12 to 14: angular error, systematic errors, the spreadsheet."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from mathpost import machine_file
from mathpost.detective.euler_angles import explain
from mathpost.detective.misreadings import COMMON, common_matrices
from mathpost.formula import numeric
from mathpost.shop.compensate.compensation import Compensated, Compensator, total_differential
from mathpost.shop.compensate.drift import Tracker
from mathpost.shop.compensate.model import COMPONENTS, SQUARENESS, ErrorModel, constant_errors, read_errors
from mathpost.shop.measure import angular_error, spline
from mathpost.teaching.course.answers import Angle, Name, Names, Number, Vector
from mathpost.teaching.course.lesson_data import data, load
from mathpost.teaching.course.verdict import define, slip

if TYPE_CHECKING:
    from mathpost.shop.measure.spline import Curve

SPOILT = 135  # the target of 12-table whose command is wrong
STEPS = "3 4 5 6 7 8 9 11"  # between targets, degrees


@cache
def table_error() -> Curve:
    """The spline of lesson 12: C's error in seconds of arc."""
    measured = angular_error.read_runs(data("measurements/angular_error.csv")).points(endless=True)
    return spline.adaptive(measured, 0.5)


@define("12-command", Angle(decimals=6))
def command(sign=-1, seconds=3600):
    """Command = target - error, both in degrees."""
    return 250 + sign * table_error()(250) / seconds


@cache
def spoilt_table() -> str:
    """The command table of lesson 12 every 45 degrees, one command with the error's own sign."""
    error, lines = table_error(), ["target,error,command"]
    for target in range(0, 360, 45):
        sign = 1 if target == SPOILT else -1
        lines.append(f"{target},{error(target):.3f},{target + sign * error(target) / 3600:.6f}")
    return "\n".join(lines)


class Row(Name):
    """A row of the table, named by its target; the feedback on a wrong one quotes that row."""

    def nearly(self, value: str, target: str) -> str:
        row = next(line.split(",") for line in spoilt_table().splitlines() if line.split(",")[0] == value)
        return "At {}° the error is {}″ and the command {}°: it is taken away there.".format(*row)


@define("12-table", Row, given=spoilt_table)
@slip("greatest", lambda: max(range(0, 360, 45), key=lambda target: abs(table_error()(target))))
def spoilt():
    """Where the command is above the target although the axis already goes too far."""
    rows = [list(map(float, line.split(","))) for line in spoilt_table().splitlines()[1:]]
    return next(target for target, error, command in rows if (command - target) * error > 0)


@define("12-knots", Number(decimals=0))
def knots(tolerance=0.2):
    """An open curve begins with both ends; the knots crowd where sin 3a bends it."""
    angles = np.arange(-120, 121, 15)
    errors = 8 * np.sin(np.radians(angles)) + 2 * np.sin(3 * np.radians(angles))
    return len(spline.adaptive(spline.points(angles, errors), tolerance).knots)


@cache
def ripple_left(step: str, teeth: int = 30) -> float:
    """Return the share of a ripple that the spline through targets `step` apart leaves, in its worst phase."""
    at, fine = np.arange(0, 360, float(step)), np.arange(0, 360, 0.05)
    left = []
    for wave in (np.sin, np.cos):
        fitted = spline.through_all(spline.points(at, wave(np.radians(teeth * at)), period=360))
        left.append(wave(np.radians(teeth * fine)) - fitted(fine))
    return np.hypot(*left).max()


def not_enough(step: str) -> str:
    """Say how much of the ripple a step in degrees leaves."""
    return f"A step of {step}° leaves {ripple_left(step):.0%} of the ripple."


@define("12-steps", Names(STEPS, about=not_enough))
def steps(share=0.5, teeth=30):
    """Below half of the period of 12°. Just below, at 5°, much of the ripple is still left; at 3° hardly any."""
    return {step for step in STEPS.split() if ripple_left(step, teeth) <= share}


MICRORADIANS = 1e6 * math.radians(1) / 3600  # of a second of arc
ERRORS = (*(f"E{part}{joint}" for joint in "XYZAC" for part in COMPONENTS), *SQUARENESS)


@cache
def trunnion_model() -> ErrorModel:
    """The chain with errors of the A-C trunnion."""
    return ErrorModel(load("ac_table").machine)


@define("13-sign", Vector(decimals=1, unit="µm"), drawn=lambda rng: {"size": rng.randrange(4, 25)})
@slip("table", lambda size: error_sign(-size))
@slip("table in the machine", lambda size: error_sign(-size, 0))
def error_sign(size=10, c=90):
    """The table goes to +X, so the tool goes to -X seen from it; and at C90 the machine's X is the part's Y."""
    model = trunnion_model()
    sensitivity = numeric(model.sensitivity("EXC").as_immutable(), model.joints)
    return size * sensitivity(0, 0, 0, 0, np.radians(c))[:3, 0]


@define("13-ecc", Number(decimals=2, unit="µrad"), drawn=lambda rng: {"seconds": rng.randrange(5, 20)})
@slip("times 90", unit=90 * MICRORADIANS)
def ecc(z=-1, seconds=12, unit=MICRORADIANS):
    """The error turns about the axis of the file, [0, 0, -1]: ECC is minus what the autocollimator shows."""
    return z * seconds * unit


def unlike_exx(name: str) -> str:
    """Say why an error is not like EXX."""
    if trunnion_model().sensitivity(name)[3:, 0].is_zero_matrix:
        return "It moves the tool along Y or Z: tilt and turn the table in your mind."
    return "It turns the tool axis as well, and that probing at different places would show."


@define("13-twins", Names(" ".join(ERRORS), about=unlike_exx))
def twins():
    """All five have one sensitivity up to the sign: only their sum shows, and only the sum must be compensated."""
    model = trunnion_model()
    wanted = model.sensitivity("EXX")
    same = {name for name in model.names if model.sensitivity(name) in (wanted, -wanted)}
    return same - {"EXX"}


@cache
def worse_at(tilt: float) -> float:
    """Return the tip error after one whole step at a tilt in degrees, divided by the error before it."""
    errors = read_errors(data("errors/bohez.toml"), machine_file.load(data("errors/bohez_machine.toml")))
    compensator = Compensator(errors)
    joints = np.array([40, -25, 30, np.radians(tilt), np.radians(70)])
    step, _ = total_differential(compensator.model, joints, errors.constant)
    return compensator.miss(joints + step, compensator.wanted(joints)).tip / compensator.miss(joints).tip


@define("13b-tilt", Number(decimals=3, tolerance=2e-3, unit="degrees"))
@slip("linear", falls=lambda ratio: ratio)
def tilt(falls=np.sqrt):
    """The rest falls with the square of the tilt; bisection finds the same to a few thousandths of a degree."""
    return 0.01 * falls(worse_at(0.01))


TWO_ERRORS, AT = {"EYA": 0.025, "EBC": -50e-6}, (20, 60, -10, -40, 15)


@define("13b-inverse", Vector(decimals=4, unit="mm"))
def exact_inverse(errors=TWO_ERRORS):
    """Both are constants: the machine with the moved axes has its own closed-form inverse."""
    compensator = Compensator(constant_errors(machine_file.load(data("errors/bohez_machine.toml")), errors))
    joints = np.array([*AT[:3], *np.radians(AT[3:])])
    both = compensator.calibrated.inverse(*compensator.wanted(joints))
    return min(both, key=lambda branch: abs(branch[3] - joints[3]))[:3]


@cache
def compensated_turn(tilt: float) -> tuple[np.ndarray, Compensated]:
    """Turn C once at X60 Y0 Z0 on the trunnion with its errors; return joints and their `Compensated`."""
    joints = np.array([(60, 0, 0, np.radians(tilt), np.radians(c)) for c in range(360)])
    compensator = Compensator(read_errors(data("errors/ac_table.toml"), load("ac_table").machine))
    return joints, compensator.compensate(joints)


@define("13b-path", Number(decimals=1, unit="µm"))
@slip("before", lambda: 1e3 * compensated_turn(20)[1].before.tip.max())
def path_change(column=1, tilt=20):
    """Y takes back what the errors do along it, and follows the small turns of A and C besides."""
    joints, result = compensated_turn(tilt)
    return 1e3 * np.abs(result.joints - joints)[:, column].max()


@define("13b-drift", Number(decimals=0))
def drift_parts(forgetting=0.8):
    """Each part leaves the share 0.8 of what was left: 0.8 to the tenth is still more than a tenth."""
    poses = np.zeros((5, 5))
    poses[:, :3], poses[:, 3:] = [40, 20, 0], np.radians([[0, 0], [0, 120], [60, 0], [60, 180], [-60, 90]])
    how = {"sigma": 0.001, "expected": 0.03, "forgetting": forgetting, "gate": np.inf}
    tracker = Tracker(trunnion_model(), ("EYA", "EZA"), poses, **how)
    for part in range(-40, 200):
        tracker.update(tracker.predict([0.010 * (part >= 0), 0]))
        if part >= 0 and 0.010 - tracker.values[0] < 0.001:
            return part + 1


SLIP = ((20, 35, 50), (1, 2, 3), (0.690, -1.540, 3.339))
SLIPS = "sign,active,order,transpose,row,axis,reference,exchange,left out,unit,rounded".split(",")


@define("14-slip", Name(dict.fromkeys(SLIPS, ())), given=lambda: SLIP)
def worksheet_slip():
    """Three decimals and angles that are not special were enough."""
    angles, point, answer = SLIP
    return explain(angles, point, answer).misreadings[0].kinds[0]


@define("14-pi", Number(decimals=1, unit="1/min"))
@slip("sign", lambda: -typed_pi())
def typed_pi():
    """The speed is inversely proportional to π: half a per mille of 3581 turns a minute."""
    turns = 1000 * 180 / 16
    return turns * (1 / 3.14 - 1 / np.pi)


@cache
def wrong_post() -> tuple[tuple[float, float, float], tuple[float, float]]:
    """Return a tool axis, and the A and C of a post whose C is counted from a different zero."""
    axis = np.round(np.array([0.3, -0.2, 0.9]) / np.linalg.norm([0.3, -0.2, 0.9]), 6)
    a, c = load("ac_table").inverse([0, 0, 0], axis, degrees=True)[0, 3:] + [0, 90]
    return tuple(axis.tolist()), (round(float(a), 3), round(float(c), 3))


@define("14-post", Angle(decimals=1, tolerance=0.01), given=wrong_post)
@slip("off", lambda: -post())
def post():
    """A zero position off by a quarter turn: the post thinks of a table whose C0 is where Y should be."""
    axis, angles = wrong_post()
    branches = load("ac_table").inverse([0, 0, 0], axis, degrees=True)[:, 3:]
    return next(c for a, c in branches if abs(a - angles[0]) < 1e-3) - angles[1]


def hides_a_mistake(answer: Sequence[float]) -> str:
    """Say which common misreading these Euler angles show by less than 2 mm, or that they are not as asked."""
    angles = np.asarray(answer)
    if (angles % 15 == 0).any() or (angles % 1 != 0).any():
        return "Take whole angles that are no multiples of 15."
    right, *others = common_matrices(("right", *COMMON), angles) @ np.array([3.0, 4.0, 5.0])
    apart = {name: float(np.linalg.norm(other - right)) for name, other in zip(COMMON, others, strict=True)}
    name = min(apart, key=lambda each: apart[each])
    return "" if apart[name] > 2 else f"The bar of '{name}' is only {math.floor(100 * apart[name]) / 100:.2f} long."


@define("14-angles", Vector(names="α β γ", decimals=None, unit="degrees"), complaint=hides_a_mistake)
def telling_angles():
    """None near 0 or 90, and no two alike: then every mistake leaves a trace of its own."""
    tried = ((a, 35, c) for a in (20, 37, 67) for c in (-59, 50))
    return next(angles for angles in tried if not hides_a_mistake(angles))
