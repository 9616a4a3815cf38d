"""The exercises of lessons 12 to 14: angular error, systematic errors, the spreadsheet."""

from functools import cache

import numpy as np

from mathpost import machine
from mathpost.compensate import error_model, machine_errors
from mathpost.compensate.compensation import Compensator, total_differential
from mathpost.course.verdict import data, exercise
from mathpost.detective.euler_angles import explain
from mathpost.detective.misreadings import COMMON, common_matrices
from mathpost.kinematics import Kinematics
from mathpost.measure import angular_error, spline
from mathpost.rotation import numeric

# 12 The angular error of a rotary axis


@cache
def table_error():
    """The spline of lesson 12: C's error in seconds of arc."""
    measured = angular_error.load(data("measurements/angular_error.csv")).points(endless=True)
    return spline.adaptive(measured, 0.5)


@exercise(
    "12-command",
    tolerance=2e-6,
    wrong={
        "The error is added where it must be taken away: this doubles it.": lambda: 90 + table_error()(90) / 3600,
        "The error is in seconds of arc, the command in degrees.": lambda: 90 - table_error()(90),
        "That is what you want, uncorrected.": lambda: 90.0,
    },
)
def command():
    """Command = target - error, both in degrees."""
    return 90 - table_error()(90) / 3600


SPOILT = 135


def spoilt_table():
    """The command table of lesson 12 every 45 degrees, one command with the error's own sign."""
    error = table_error()
    lines = ["target,error,command"]
    for target in range(0, 360, 45):
        sign = 1 if target == SPOILT else -1
        lines.append(f"{target},{error(target):.3f},{target + sign * error(target) / 3600:.6f}")
    return "\n".join(lines)


@exercise(
    "12-table",
    given=spoilt_table,
    tolerance=0.1,
    wrong={
        "There the error is greatest, and rightly taken away.": (
            lambda: max(range(0, 360, 45), key=lambda target: abs(table_error()(target)))
        ),
        "0 less a positive error is negative: that is right.": lambda: 0,
    },
)
def spoilt():
    """Where the command is above the target although the axis already goes too far."""
    rows = [list(map(float, line.split(","))) for line in spoilt_table().splitlines()[1:]]
    return next(target for target, error, command in rows if (command - target) * error > 0)


def tilting_knots(tolerance):
    angles = np.arange(-120, 121, 15)
    errors = 8 * np.sin(np.radians(angles)) + 2 * np.sin(3 * np.radians(angles))
    return len(spline.adaptive(spline.points(angles, errors), tolerance).knots)


@exercise(
    "12-knots",
    tolerance=0.1,
    wrong={
        "That is enough for 0.5 seconds.": lambda: tilting_knots(0.5),
        "These are all the measured points.": lambda: len(np.arange(-120, 121, 15)),
    },
)
def knots():
    """An open curve begins with both ends; the knots crowd where sin 3a bends it."""
    angles = np.arange(-120, 121, 15)
    errors = 8 * np.sin(np.radians(angles)) + 2 * np.sin(3 * np.radians(angles))
    return len(spline.adaptive(spline.points(angles, errors), 0.2).knots)


def ripple_seen(step):
    """The greatest share of a ripple of 18 waves that measuring at multiples of `step` shows."""
    return np.abs(np.sin(np.radians(18 * np.arange(0, 360, step)))).max()


@exercise(
    "12-steps",
    wrong={
        "10° is the blind one: 18 teeth repeat every 20°.": lambda: {"10"},
        "Finer is not the point. Which steps meet a crest at all?": lambda: {"5"},
        "The even steps miss the crests a little: they see 95 %.": (
            lambda: {str(step) for step in range(5, 13) if ripple_seen(step) > 0.5}
        ),
    },
)
def steps():
    """The odd ones: 18 times an odd number of degrees can be an odd multiple of 90°."""
    seen = {step: np.abs(np.sin(np.radians(18 * np.arange(0, 360, step)))).max() for step in range(5, 13)}
    return {str(step) for step, share in seen.items() if share > 0.999}


# 13 Systematic errors


@cache
def trunnion_model():
    """The chain with errors of the A-C trunnion."""
    return error_model.ErrorModel(machine.load(data("machines/ac_table.toml")))


def moved_by(name, size, a, c):
    """How the tip moves, seen from the workpiece, under one error of `size` at angles a and c in degrees."""
    model = trunnion_model()
    sensitivity = numeric(model.sensitivity(name).as_immutable(), model.joints)
    return size * sensitivity(0, 0, 0, np.radians(a), np.radians(c))[:3, 0]


@exercise(
    "13-sign",
    tolerance=0.05,
    wrong={
        "That is where the table goes. The tool stays, so *seen from the workpiece* it goes the other way.": (
            lambda: -moved_by("EXC", 10, 0, 90)
        ),
        "That is in the machine's directions. At C90 the workpiece has turned: which of its axes is along X?": (
            lambda: (-10, 0, 0)
        ),
        "That is where the table goes, in the machine's directions.": lambda: (10, 0, 0),
    },
)
def error_sign():
    """The table goes to +X, so the tool goes to -X seen from it; and at C90 the machine's X is the part's Y."""
    model = trunnion_model()
    at = dict(zip(model.joints, (0, 0, 0, 0, np.pi / 2), strict=True))
    return np.array(10 * model.sensitivity("EXC").subs(at)[:3, 0], dtype=float).ravel()


@exercise(
    "13-twins",
    wrong={
        "A moves too when X has an error, but it is not the only one that carries the tool or the part along X.": (
            lambda: {"EXA"}
        ),
        "These are the slides. The tables can stand wrong along X as well.": lambda: {"EXY", "EXZ"},
        "C's too: A turns about X, so what C carries along X stays along X.": lambda: {"EXY", "EXZ", "EXA"},
    },
)
def twins():
    """All five have one sensitivity up to the sign: only their sum shows, and only the sum must be compensated."""
    model = trunnion_model()
    wanted = model.sensitivity("EXX")
    same = {name for name in model.names if model.sensitivity(name) in (wanted, -wanted)}
    return same - {"EXX"}


@cache
def bohez():
    """The machine of lesson 13 with its fourteen errors, and the errors."""
    errors = machine_errors.load(data("errors/bohez.toml"), machine.load(data("errors/bohez_machine.toml")))
    return Compensator(errors), errors


def worse_at(tilt):
    """The tip error after one whole step at a tilt in degrees, divided by that before."""
    compensator, errors = bohez()
    joints = np.array([40, -25, 30, np.radians(tilt), np.radians(70)])
    step, _ = total_differential(compensator.model, joints, errors.constant)
    return compensator.miss(joints + step, compensator.wanted(joints)).tip / compensator.miss(joints).tip


@exercise(
    "13-tilt",
    tolerance=2e-3,
    wrong={
        "The rest falls with the *square* of the tilt, not with the tilt.": lambda: 0.01 * worse_at(0.01),
        "There it is still more than ten times too much.": lambda: 0.01,
    },
)
def tilt():
    """The rest falls with the square of the tilt; bisection finds the same to a few thousandths of a degree."""
    return 0.01 * np.sqrt(worse_at(0.01))


# 14 Check a spreadsheet


SLIP = ((20, 35, 50), (1, 2, 3), (0.690, -1.540, 3.339))


@exercise(
    "14-slip",
    given=lambda: SLIP,
    wrong={
        "The elements are passive, as they should be; ask `explain`.": lambda: "active",
        "That is the name of an angle; the *kind* of slip is the word in `kinds`.": lambda: "beta",
    },
)
def worksheet_slip():
    """Three decimals and angles that are not special were enough."""
    angles, point, answer = SLIP
    return explain(angles, point, answer).misreadings[0].kinds[0]


@cache
def trunnion():
    return Kinematics(machine.load(data("machines/ac_table.toml")))


def wrong_post():
    """A tool axis, and the A and C of a post whose C is counted from another place."""
    axis = np.round(np.array([0.3, -0.2, 0.9]) / np.linalg.norm([0.3, -0.2, 0.9]), 6)
    a, c = trunnion().inverse([0, 0, 0], axis, degrees=True)[0, 3:] + [0, 90]
    return tuple(axis.tolist()), (round(float(a), 3), round(float(c), 3))


@exercise(
    "14-post",
    given=wrong_post,
    tolerance=0.01,
    wrong={
        "That is how far off C is. What must be *added* to it?": lambda: 90,
        "Half a turn is the other branch; then A would have the other sign too.": lambda: 180,
        "C is off, not right: compare with both branches, or ask `explain_joints`.": lambda: 0,
    },
)
def post():
    """A zero position off by a quarter turn: the post thinks of a table whose C0 is where Y should be."""
    axis, angles = wrong_post()
    branches = trunnion().inverse([0, 0, 0], axis, degrees=True)[:, 3:]
    return next(c for a, c in branches if abs(a - angles[0]) < 1e-3) - angles[1]


def judge_angles(angles):
    """Whether these Euler angles show every common misreading by 2 mm, with no multiple of 15 degrees."""
    if (angles % 15 == 0).any() or (angles % 1 != 0).any():
        return "Take whole angles that are no multiples of 15."
    right, *others = common_matrices(("right", *COMMON), angles) @ np.array([3.0, 4.0, 5.0])
    apart = {name: np.linalg.norm(other - right) for name, other in zip(COMMON, others, strict=True)}
    name = min(apart, key=apart.get)
    return "" if apart[name] > 2 else f"The bar of '{name}' is only {apart[name]:.2f} long."


@exercise(
    "14-angles",
    judge=judge_angles,
    wrong={
        "The bar of": lambda: (4, 35, 50),
        "no multiples of 15": lambda: (20, 45, 50),
        "Expected 3 numbers": lambda: (20, 35),
    },
)
def telling_angles():
    """None near 0 or 90, and no two alike: then every mistake leaves a trace of its own."""
    tried = (np.array([a, 35, c]) for a in (20, 37, 67) for c in (-59, 50))
    return next(angles for angles in tried if not judge_angles(angles))
