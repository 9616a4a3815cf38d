"""The exercises of lessons 10 and 11: the rotation centre, RTCP."""

from functools import cache

import numpy as np

from mathpost import machine
from mathpost.course.answers import Names, Number, Vector
from mathpost.course.lesson_data import data, load, of_lesson
from mathpost.course.verdict import slip
from mathpost.measure import cutter, rotary_axis

# 10 Where is the rotation centre?


@of_lesson("10-square", Vector(names="ex ey", decimals=4, unit="mm"))
@slip("four", rows=slice(0, 8, 2))
def square(waves=2, rows=slice(None), sense=1):
    """The centre does not move: an offset has one period in a turn, the wave two. Only `noise` shows it."""
    dial = rotary_axis.dial_circle()
    table = dial.read(data("measurements/dial_circle.csv"))
    wave = -0.5 * 80e-6 * table["R"] * np.sin(waves * np.radians(table["angle"]))
    read = {"angle": table["angle"], "R": table["R"], "dial": sense * (table["dial"] + wave)}
    found = dial.identify({name: column[rows] for name, column in read.items()}, degrees=True)
    return [found["ex"], found["ey"]]


def probed_table(sense):
    """The probing of a table A whose axis is (sense, 0, 0)."""
    return rotary_axis.probing(machine.Rotary("A", "workpiece", axis=(sense, 0, 0), point=(0, 0, 0)))


@of_lesson("10-angles", Number(decimals=0))
@slip("nine times", lambda: 9 * angles_needed(1))
def angles_needed(sigmas=3):
    """Averaging is dear. Two angles that are 180° apart give more than many within 90°."""
    for count in range(2, 200):
        at = {"angle": np.linspace(0, 90, count), "y": np.zeros(count), "z": np.zeros(count)}
        if sigmas * probed_table(-1).identify(at, degrees=True, sigma=0.002).deviation("yc") <= 0.002:
            return count


@cache
def unknown_sense():
    """Readings of a table whose file may have the wrong sign: three angles, 2 µm of noise."""
    true = {"yc": -120.0, "zc": -340.0, "yf": -60.0, "zf": -310.0}
    at = {"angle": np.array([0.0, 40.0, 90.0])}
    return probed_table(1).simulate(true, at, sigma=0.002, seed=10, degrees=True)


@of_lesson("10-sense", Vector(names="yc zc", decimals=2, tolerance=0.02, unit="mm"), given=unknown_sense)
def sense(senses=(-1, 1), rows=(0, 1, 2)):
    """Only with the axis (1, 0, 0) are the residuals those of a probe: this table turns the other way."""
    readings = {name: np.asarray(unknown_sense()[name])[list(rows)] for name in ("angle", "y", "z")}
    fits = [probed_table(sense).identify(readings, degrees=True, sigma=0.002) for sense in senses]
    best = min(fits, key=lambda fit: fit.noise)
    return [best["yc"], best["zc"]]


# 11 How accurate is RTCP?


@of_lesson("11-factor", Number(decimals=2))
@slip("sine", lambda: np.sin(np.radians(20)))
@slip("tangent", lambda: 1 / np.tan(np.radians(20)))
@slip("cosine", lambda: 1 / np.cos(np.radians(20)))
def factor():
    """One over the sine of the tilt, whatever the head."""
    alpha = rotary_axis.source_zero_angle(0.1, 700)
    reading = rotary_axis.rtcp_zero().predict({"alpha": alpha}, {"angle": 20, "L": 700}, degrees=True)["axial"]
    return alpha / rotary_axis.source_zero_angle(reading, 700)


@of_lesson("11-psi", Number(decimals=0, unit="degrees"))
def psi():
    """Where the sine is greatest; at 45° it is only √2 worse, and far easier to reach."""

    def deviation(psi):
        at = {"angle": [psi, -psi] * 2, "L": [500, 500, 700, 700], "axial": np.zeros(4)}
        return rotary_axis.rtcp_zero().identify(at, degrees=True, sigma=0.001).deviation("alpha")

    return min(range(5, 121), key=deviation)


@of_lesson(
    "11-signs",
    Names(
        {"alpha": ["α"], "dy": ["Δy"], "dL": ["ΔL"]},
        about={"dL": "The length error reads w·(cos ψ - 1): a cosine does not know the sign of ψ."}.get,
    ),
)
def signs():
    """The sine's part, u = dy + L·alpha, comes out reversed; the cosine's part, dL, does not."""
    true, measurement = {"alpha": 7e-5, "dy": 0.03, "dL": 0.05}, rotary_axis.rtcp_zero()
    tilt, length = np.array([40, -40, 40, -40]), np.array([500, 500, 700, 700])
    axial = measurement.predict(true, {"angle": -tilt, "L": length}, degrees=True)["axial"]
    found = measurement.identify({"angle": tilt, "L": length, "axial": axial}, degrees=True)
    return {name for name, value in true.items() if found[name] * value < 0}


def no_gouge(pair):
    """Say why the second cutter is not smaller than the first, or does not gouge on its tips."""
    old, new = cutter.Cutter(*pair[:2]), cutter.Cutter(*pair[2:])
    slope = np.radians(np.arange(0, 91))
    normal = np.stack([np.sin(slope), 0 * slope, np.cos(slope)], axis=1)
    stock = cutter.stock_left(normal, [0, 0, 1], old, new)
    if not new.diameter < old.diameter:
        return f"The new cutter is not smaller: {new.diameter:g} mm after {old.diameter:g} mm."
    if stock.min() > -1e-6:
        return f"It does not gouge: stock is {stock.min():z.3f} to {stock.max():.3f} mm. Compare the rims."
    return ""


@of_lesson(
    "11b-gouge", Vector(names="D₁ r₁ D₂ r₂", decimals=None, said="two cutters, old and new"), complaint=no_gouge
)
def gouge():
    """The flat of a bull nose reaches further out at the bottom than the ball did, though it is thinner."""
    return cutter.Cutter.ball(10), cutter.Cutter(diameter=8, rim=1)


@of_lesson("11b-length", Number(decimals=1, unit="µm"))
@slip("along Z", lambda: 250 * (1 - np.cos(np.radians(40))))
@slip("sideways", lambda: 250 * np.sin(np.radians(40)))
def length(told="length offset"):
    """The difference of two directions 40° apart: 2·sin 20° times the length."""
    return 1e3 * np.linalg.norm(cutter.tip_shift(load("ac_head"), [0, 0, 0, 0, 40], -0.25, told, degrees=True))


@of_lesson("11b-stock", Number(decimals=1, unit="µm"))
@slip("sideways", lambda: 150 * np.sin(np.radians(35)))
def stock(slope=35, diameters=(16, 15.7)):
    """The middles of the balls are 0.15 mm apart along the tool; along the normal 0.15·(1 − cos 35°) is missing."""
    normal = [np.sin(np.radians(slope)), 0, np.cos(np.radians(slope))]
    return 1e3 * cutter.stock_left(normal, [0, 0, 1], *map(cutter.Cutter.ball, diameters))
