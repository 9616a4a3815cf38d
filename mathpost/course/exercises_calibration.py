"""The exercises of lessons 10 and 11: the rotation centre, RTCP."""

from functools import cache

import numpy as np

from mathpost import machine
from mathpost.course.verdict import data, exercise
from mathpost.measure import cutter, rotary_axis

# 10 Where is the rotation centre?


def dial_readings():
    return rotary_axis.dial_circle().read(data("measurements/dial_circle.csv"))


def oval_centre(harmonic, size=0.005):
    """The centre that the dial finds when a ring's shape adds a wave to the readings."""
    table = dial_readings()
    readings = {name: table[name] for name in ("angle", "R")}
    readings["dial"] = table["dial"] + size * np.cos(harmonic * np.radians(table["angle"]))
    found = rotary_axis.dial_circle().identify(readings, degrees=True)
    return np.array([found["ex"], found["ey"]])


@exercise(
    "10-oval",
    tolerance=1e-4,
    wrong={
        "This is a wave of one period in a turn, which *is* an offset. An oval has two.": lambda: oval_centre(1),
        "Only one of four readings at 90° sees it like this; use all eight.": lambda: (
            oval_centre(2) + np.array([0.005, -0.005])
        ),
    },
)
def oval():
    """The centre does not move: opposite readings feel the oval alike. Only `noise` shows it."""
    dial = rotary_axis.dial_circle()
    table = dial.read(data("measurements/dial_circle.csv"))
    wave = 0.005 * np.cos(2 * np.radians(table["angle"]))
    readings = {"angle": table["angle"], "R": table["R"], "dial": table["dial"] + wave}
    found = dial.identify(readings, degrees=True)
    return [found["ex"], found["ey"]]


@cache
def iso_a():
    return machine.Rotary("A", "workpiece", axis=(-1, 0, 0), point=(0, 0, 0))


def angles_for(sigmas, *, goal=0.002, sigma=0.002):
    """The fewest angles, even from 0° to 90°, that bring `sigmas` deviations of yc below the goal."""
    probing = rotary_axis.probing(iso_a())
    for count in range(2, 200):
        at = {"angle": np.linspace(0, 90, count), "y": np.zeros(count), "z": np.zeros(count)}
        if sigmas * probing.identify(at, degrees=True, sigma=sigma).deviation("yc") <= goal:
            return count


@exercise(
    "10-angles",
    tolerance=0.1,
    wrong={
        "That is for one standard deviation; the question asks for three.": lambda: angles_for(1),
        "Nine times as many as for one: but the ends count most, angles between them tell less.": (
            lambda: 9 * angles_for(1)
        ),
    },
)
def angles():
    """Averaging is dear. Two angles that are 180° apart give more than many within 90°."""
    return angles_for(sigmas=3)


@cache
def unknown_sense():
    """Readings of a table whose file may have the wrong sign: three angles, 2 µm of noise."""
    other = machine.Rotary("A", "workpiece", axis=(1, 0, 0), point=(0, 0, 0))
    true = {"yc": -120.0, "zc": -340.0, "yf": -60.0, "zf": -310.0}
    at = {"angle": np.array([0.0, 40.0, 90.0])}
    return rotary_axis.probing(other).simulate(true, at, sigma=0.002, seed=10, degrees=True)


@exercise(
    "10-sense",
    given=unknown_sense,
    tolerance=2e-2,
    wrong={
        "This is the ISO table with three readings that contradict it: look at `noise` or at the residuals.": (
            lambda: probed_centre(-1, 3)
        ),
        "Two of the three readings fit any sense of turning, so they cannot tell you that it is wrong.": (
            lambda: probed_centre(-1, 2)
        ),
    },
)
def sense():
    """Only with the axis (1, 0, 0) are the residuals those of a probe: this table turns the other way."""
    best = min((probed_fit(sign) for sign in (-1, 1)), key=lambda fit: fit.noise)
    return [best["yc"], best["zc"]]


def probed_fit(sign, rows=3):
    rotary = machine.Rotary("A", "workpiece", axis=(sign, 0, 0), point=(0, 0, 0))
    readings = unknown_sense()
    chosen = [0, 1, 2] if rows == 3 else [0, 2]
    return rotary_axis.probing(rotary).identify(
        {name: np.asarray(readings[name])[chosen] for name in ("angle", "y", "z")}, degrees=True, sigma=0.002
    )


def probed_centre(sign, rows):
    fit = probed_fit(sign, rows)
    return [fit["yc"], fit["zc"]]


# 11 How accurate is RTCP?


@exercise(
    "11-factor",
    tolerance=0.02,
    wrong={
        "That is the sine itself: the dial shows this *part* of L·α. How many times too small is it?": (
            lambda: np.sin(np.radians(20))
        ),
        "The dial reads L·α·sin ψ, the axial part; the tangent does not come into it.": (
            lambda: 1 / np.tan(np.radians(20))
        ),
    },
)
def factor():
    """One over the sine of the tilt, whatever the head."""
    alpha = rotary_axis.source_zero_angle(0.1, 700)
    reading = rotary_axis.rtcp_zero().predict({"alpha": alpha}, {"angle": 20, "L": 700}, degrees=True)["axial"]
    return alpha / rotary_axis.source_zero_angle(reading, 700)


def alpha_deviation(psi):
    """The standard deviation of alpha from axial readings of 1 µm at ±psi with two bars."""
    at = {"angle": [psi, -psi] * 2, "L": [500, 500, 700, 700], "axial": np.zeros(4)}
    return rotary_axis.rtcp_zero().identify(at, degrees=True, sigma=0.001).deviation("alpha")


@exercise(
    "11-psi",
    tolerance=0.6,
    wrong={
        "There the cosine grows fastest, but alpha comes from the sine.": lambda: 45,
        "That is the source's own example, where the dial shows a tenth of the error.": lambda: 5,
    },
)
def psi():
    """Where the sine is greatest; at 45° it is only √2 worse, and far easier to reach."""
    return min(range(5, 121), key=alpha_deviation)


@exercise(
    "11-signs",
    wrong={
        "dy adds up with L·alpha in u, and u is what changes its sign.": lambda: {"alpha"},
        "The length error reads w·(cos ψ - 1): a cosine does not know the sign of ψ.": lambda: {
            "alpha",
            "dy",
            "dL",
        },
        "The other way round: the sine changes its sign with ψ, the cosine does not.": lambda: {"dL"},
    },
)
def signs():
    """The sine's part, u = dy + L·alpha, comes out reversed; the cosine's part, dL, does not."""
    true, measurement = {"alpha": 7e-5, "dy": 0.03, "dL": 0.05}, rotary_axis.rtcp_zero()
    tilt, length = np.array([40, -40, 40, -40]), np.array([500, 500, 700, 700])
    axial = measurement.predict(true, {"angle": -tilt, "L": length}, degrees=True)["axial"]
    found = measurement.identify({"angle": tilt, "L": length, "axial": axial}, degrees=True)
    return {name for name, value in true.items() if found[name] * value < 0}


def judge_cutters(pair):
    """Whether the second cutter is smaller than the first and yet gouges on its tips."""
    old, new = pair
    slope = np.radians(np.arange(0, 91))
    normal = np.stack([np.sin(slope), 0 * slope, np.cos(slope)], axis=1)
    stock = cutter.stock_left(normal, [0, 0, 1], old, new)
    if not new.diameter < old.diameter:
        return f"The new cutter is not smaller: {new.diameter:g} mm after {old.diameter:g} mm."
    if stock.min() > -1e-6:
        return f"It does not gouge: stock is {stock.min():z.3f} to {stock.max():.3f} mm. Compare the rims."
    return ""


@exercise(
    "11-gouge",
    judge=judge_cutters,
    wrong={
        "It does not gouge": lambda: (cutter.Cutter.ball(12), cutter.Cutter.ball(11.8)),
        "is not smaller": lambda: (cutter.Cutter.ball(10), cutter.Cutter.flat(12)),
    },
)
def gouge():
    """The flat of a bull nose reaches further out at the bottom than the ball did, though it is thinner."""
    return (cutter.Cutter.ball(10), cutter.Cutter(diameter=8, rim=1))
