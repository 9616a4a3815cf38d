"""The exercises of lessons 08 to 11b: datum after rotation, five-face head, rotation centre, RTCP, tools."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from mathpost.errors import InputError
from mathpost.machine import Rotary
from mathpost.shop.measure import cutter, horizontal_head, rotary_axis, work_offset
from mathpost.shop.measure.horizontal_head import VERTICAL, Head
from mathpost.teaching.course.answers import Angle, Name, Names, Number, Vector
from mathpost.teaching.course.answers.kind import Numbers
from mathpost.teaching.course.lesson_data import data, load
from mathpost.teaching.course.verdict import define, slip

if TYPE_CHECKING:
    from mathpost.shop.measure.fit import Measurement


class Addresses(Names):
    """Letters of NC words: a list, run together, or with their numbers, such as A-30. B10."""

    def read(self, answer: Any) -> list[str]:
        words = answer if isinstance(answer, str) else " ".join(map(str, answer))
        letters = re.sub(r"[-+.\d\s,;\[\]]", "", words.replace("−", "-")).upper()
        return super().read(list(letters) if letters and set(letters) <= set(self.listed) else answer)


@dataclass(frozen=True, kw_only=True)
class Place(Vector):
    """Coordinates of an axis, under their own names or as the control shows them."""

    shown: str = "Y Z"

    def read(self, answer: Any) -> Numbers:
        try:
            return super().read(answer)
        except InputError:
            return Vector(names=self.shown, unit=self.unit).read(answer)


class Factor(Number):
    """How many times: 2.92, 2.92x, 2.92 times."""

    def read(self, answer: Any) -> Numbers:
        return super().read(re.sub(r"\s*(?:[x×]|times|倍)\s*$", "", answer) if isinstance(answer, str) else answer)


CENTRES = {"centre_a": (0, -200, -850), "centre_b": (-350, 0, -900)}
G54 = (-300, -250, -600)
SET_UP, NEW = {"A": 15, "B": -50}, {"A": -20, "B": 30}
QUARTERS = {"B": 90, "C": 90}
CALL = "G65P9795X0Y0Z0A0B0D-30.E10.S55"
NORMALS = {"+X": (1, 0, 0), "-X": (-1, 0, 0), "+Z": (0, 0, 1), "-Z": (0, 0, -1)}


@define("08-face", Name({"+X": ["X"], "-X": [], "+Z": ["Z"], "-Z": []}))
def face(b=90):
    """The table carries +X to +Z, where the spindle is."""
    _, rotary = work_offset.ab_table(**CENTRES, order="AB")
    turned = work_offset.moved([*NORMALS.values(), (0, 0, 0)], (rotary,), {"B": 0}, {"B": b}, degrees=True)
    height = turned[:-1, 2] - turned[-1, 2]
    return list(NORMALS)[height.argmax()]


@define("08-datum", Vector(unit="mm"))
@slip("backwards", start=NEW, end=SET_UP)
def after_turn(start=SET_UP, end=NEW, order="AB", iso=True):
    """Back to zero with the old angles, forward with the new, each axis about its own line."""
    table = work_offset.ab_table(**CENTRES, order=order, iso=iso)
    return work_offset.moved(G54, table, start, end, degrees=True)


@define("08-words", Addresses, given=lambda: CALL)
def missing_words():
    """G10 L2 stores X Y Z only; without A-30. B10. the table stands where it stood, and G55 names another place."""
    old = work_offset.WorkOffset("G54", *G54, A=0, B=0)
    table = work_offset.ab_table(**CENTRES, order="AB")
    return set(work_offset.p9795(table, old, **work_offset.read_call(CALL)).angles)


@define("08-dmu", Vector(unit="mm"))
def dmu(end=QUARTERS, order=1):
    """The same function: a table is two axes with their own lines, a tilted one too."""
    b_carries_c = load("dmu50v").machine.rotary[::order]
    return work_offset.moved((10, 20, 30), b_carries_c, {"B": 0, "C": 0}, end, degrees=True)


@cache
def head() -> Head:
    """The measured head of source 001."""
    return horizontal_head.read_head(data("measurements/five_face_head.csv"))


@define("09-vertical", Vector(unit="mm"))
@slip("head vector", lambda: head().vector(0))
def vertical(measured=VERTICAL):
    """Nothing to take back: the offset already belongs to the vertical head."""
    return horizontal_head.lhyset(head(), measured, measured, measured)


@define("09-missed", Vector(unit="mm"))
@slip("flipped", lambda: horizontal_head.opposite_errors(head())[270])
@slip("predicted less measured", lambda: -missed())
def missed(fitted=3):
    """Twice the residuals of the full fit: a point that was not fitted is missed by more than one that was."""
    chosen = horizontal_head.Head(head().angles[:fitted], head().vectors[:fitted])
    return head().vector(270) - horizontal_head.fit_head(chosen).head().vector(270)


@define("09-wrapped", Angle(decimals=1))
@slip("counterclockwise", lambda: next(a for a in np.arange(0, 360, 2.5) if 90 + a > 180))
def wrapped():
    """From here on UZZ would be below -180, and comes back from the other side, just below +180."""
    positions = np.arange(0, 360, 2.5)
    return next(angle for angle in positions if 90 + head().sense * angle < -180)


@define("09-unlisted", Number(decimals=0, unit="mm"))
@slip(
    "arms",
    lambda: np.linalg.norm(horizontal_head.fit_head(head()).head().vector(205)) - np.linalg.norm(head().vector(0)),
)
def unlisted(angle=205):
    """It falls through to the first label and uses U_0, almost two arm lengths away."""
    wanted = horizontal_head.fit_head(head()).head().vector(angle)
    return np.linalg.norm(wanted - head().vector(0))


@define("10-square", Vector(names="ex ey", decimals=4, unit="mm"))
@slip("four", rows=slice(0, 8, 2))
def square(waves=2, rows=slice(None), sense=1):
    """The centre does not move: an offset has one period in a turn, the wave two. Only `noise` shows it."""
    dial = rotary_axis.dial_circle()
    table = dial.read(data("measurements/dial_circle.csv"))
    wave = -0.5 * 80e-6 * table["R"] * np.sin(waves * np.radians(table["angle"]))
    read = {"angle": table["angle"], "R": table["R"], "dial": sense * (table["dial"] + wave)}
    found = dial.identify({name: column[rows] for name, column in read.items()}, degrees=True)
    return [found["ex"], found["ey"]]


def probed_table(sense: int) -> Measurement:
    """The probing of a table A whose axis is (sense, 0, 0)."""
    return rotary_axis.probing(Rotary("A", "workpiece", axis=(sense, 0, 0), point=(0, 0, 0)))


@define("10-angles", Number(decimals=0))
@slip("four times", lambda: 4 * angles_needed(1))
def angles_needed(k=1.96):
    """Averaging is expensive. Two angles that are 180° apart give more than many within 90°."""
    for count in range(2, 200):
        at = {"angle": np.linspace(0, 90, count), "y": np.zeros(count), "z": np.zeros(count)}
        if k * probed_table(-1).identify(at, degrees=True, sigma=0.002).deviation("yc") <= 0.002:
            return count


@cache
def unknown_sense() -> dict[str, ArrayLike]:
    """Readings of a table whose file may have the wrong sign: three angles, 2 µm of noise."""
    true = {"yc": -120.0, "zc": -340.0, "yf": -60.0, "zf": -310.0}
    at = {"angle": np.array([0.0, 40.0, 90.0])}
    return probed_table(1).simulate(true, at, sigma=0.002, seed=10, degrees=True)


@define("10-sense", Place(names="yc zc", decimals=2, tolerance=0.02, unit="mm"), given=unknown_sense)
def sense(senses=(-1, 1), rows=(0, 1, 2)):
    """Only with the axis (1, 0, 0) are the residuals those of a probe: this table turns the other way."""
    readings = {name: np.asarray(unknown_sense()[name])[list(rows)] for name in ("angle", "y", "z")}
    fits = [probed_table(sense).identify(readings, degrees=True, sigma=0.002) for sense in senses]
    best = min(fits, key=lambda fit: fit.noise)
    return [best["yc"], best["zc"]]


@define("11-factor", Factor(decimals=2))
@slip("sine", lambda: np.sin(np.radians(20)))
@slip("tangent", lambda: 1 / np.tan(np.radians(20)))
@slip("cosine", lambda: 1 / np.cos(np.radians(20)))
def factor():
    """One over the sine of the tilt, whatever the head."""
    alpha = np.arctan(0.1 / 700)
    reading = rotary_axis.rtcp_zero().predict({"alpha": alpha}, {"angle": 20, "L": 700}, degrees=True)["axial"]
    return alpha / np.arctan(reading / 700)


@define("11-psi", Number(decimals=0, unit="degrees"))
def psi():
    """Where the sine is greatest; at 45° it is only √2 worse, and far easier to reach."""

    def deviation(psi):
        at = {"angle": [psi, -psi] * 2, "L": [500, 500, 700, 700], "axial": np.zeros(4)}
        return rotary_axis.rtcp_zero().identify(at, degrees=True, sigma=0.001).deviation("alpha")

    return min(range(5, 121), key=deviation)


@define("11-signs", Names)
def signs():
    """The sine's part, u = dy + L·alpha, comes out reversed; the cosine's part, dL, does not."""
    true, measurement = {"alpha": 7e-5, "dy": 0.03, "dL": 0.05}, rotary_axis.rtcp_zero()
    tilt, length = np.array([40, -40, 40, -40]), np.array([500, 500, 700, 700])
    axial = measurement.predict(true, {"angle": -tilt, "L": length}, degrees=True)["axial"]
    found = measurement.identify({"angle": tilt, "L": length, "axial": axial}, degrees=True)
    return {name for name, value in true.items() if found[name] * value < 0}


def no_gouge(pair: Sequence[float]) -> str:
    """Say why the second cutter is not smaller than the first, or does not gouge on its tips."""
    old, new = cutter.Cutter(*pair[:2]), cutter.Cutter(*pair[2:])
    slope = np.radians(np.arange(0, 91))
    normal = np.stack([np.sin(slope), 0 * slope, np.cos(slope)], axis=1)
    stock = cutter.stock_left(normal, [0, 0, 1], old, new)
    if tuple(pair) == (10, 5, 8, 1):
        return "These are the two cutters of the dome above. Find others."
    if not new.diameter < old.diameter:
        return f"The new cutter is not smaller: {new.diameter:g} mm after {old.diameter:g} mm."
    if stock.min() > -1e-6:
        return f"It does not gouge: stock is {stock.min():z.3f} to {stock.max():.3f} mm. Compare the rims."
    return ""


@define(
    "11b-gouge", Vector(names="D₁ r₁ D₂ r₂", decimals=None, said="two cutters, old and new"), complaint=no_gouge
)
def gouge():
    """The flat of a bull nose reaches further out at the bottom than the ball did, though it is thinner."""
    return cutter.Cutter.ball(16), cutter.Cutter(diameter=12, rim=2)


@define("11b-length", Number(decimals=1, unit="µm"))
@slip("along Z", lambda: 250 * (1 - np.cos(np.radians(40))))
@slip("sideways", lambda: 250 * np.sin(np.radians(40)))
def length(told="length offset"):
    """The difference of two directions 40° apart: 2·sin 20° times the length."""
    return 1e3 * np.linalg.norm(cutter.tip_shift(load("ac_head"), [0, 0, 0, 0, 40], -0.25, told, degrees=True))


@define("11b-stock", Number(decimals=1, unit="µm"))
@slip("sideways", lambda: 150 * np.sin(np.radians(35)))
def stock(slope=35, diameters=(16, 15.7)):
    """The middles of the balls are 0.15 mm apart along the tool; along the normal 0.15·(1 − cos 35°) is missing."""
    normal = [np.sin(np.radians(slope)), 0, np.cos(np.radians(slope))]
    return 1e3 * cutter.stock_left(normal, [0, 0, 1], *map(cutter.Cutter.ball, diameters))
