"""The exercises of lesson 07c: a part and a machine drawn for each learner, from the inverse to a program."""

from __future__ import annotations

import random
import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from mathpost import machine_file, postprocess
from mathpost.kinematics import Kinematics
from mathpost.path import cl as cldata
from mathpost.path import selection, singular
from mathpost.teaching.course.answers import Number, Vector, Written
from mathpost.teaching.course.judged_program import AXIS, Program, unproved
from mathpost.teaching.course.verdict import define, slip

if TYPE_CHECKING:
    from mathpost.path.cl import CLData

RECORDS, MIDDLE = 11, 5
FEEDS = (600, 800, 1000, 1200)  # mm/min
GRANTED = np.radians(AXIS)
SAME_POSE = 1e-5  # mm, and of the tool axis

ROTARY = """
[[rotary]]
name = "{name}"
carries = "{carries}"
axis = {axis}
point = {point}{limits}
max_rate = {rate}
max_acceleration = {acceleration}
"""
REST = """
[workpiece]
origin = [0, 0, 0]

[tool]
axis = [0, 0, 1]
length = {length}
programmed_point = "tip"

[linear]
X = { limits = [-600, 600], max_rate = 500, max_acceleration = 2000 }
Y = { limits = [-600, 600], max_rate = 500, max_acceleration = 2000 }
Z = { limits = [-600, 600], max_rate = 500, max_acceleration = 2000 }
safe = { Z = 590 }
"""
# Name, axis of the tilting joint, what it carries, axis of C, travel of the tilting joint if it is one-sided.
KINDS = {
    "trunnion A, C": ("A", [-1, 0, 0], "workpiece", [0, 0, -1], (-5, 110)),
    "trunnion B, C": ("B", [0, -1, 0], "workpiece", [0, 0, -1], (-5, 110)),
    "table B at 45°, C": ("B", [0, 1, 1], "workpiece", [0, 0, 1], (0, 180)),
    "head B, table C": ("B", [0, 1, 0], "tool", [0, 0, -1], (-5, 110)),
}
POLES = ("at a record", "between records", "beside")


@dataclass(frozen=True)
class Task:
    """The part and the machine of one learner; ``print(task)`` shows them."""

    machine: str  # the text of a machine file
    cl: str  # and of the CL data

    @property
    def kin(self) -> Kinematics:
        """The kinematics that the package makes of the machine file."""
        return Kinematics(machine_file.from_dict(tomllib.loads(self.machine), "the machine"))

    @property
    def path(self) -> CLData:
        """The CL data that the package reads."""
        return cldata.parse(self.cl, "part")

    def __str__(self) -> str:
        return f"{self.machine}\n{self.cl}"


@cache
def task(seed: int) -> Task:
    """Return the `Task` of a number. The lesson's own, 0, is a trunnion whose path meets the pole at record 6."""
    rng = random.Random(f"capstone {seed}")
    kind, pole, one_sided = rng.choice(list(KINDS)), rng.choice(POLES), rng.random() < 0.6
    if seed == 0:
        kind, pole, one_sided = "trunnion A, C", "at a record", True
    return Task(_machine(rng, kind, one_sided), _path(rng, pole))


def _machine(rng: random.Random, kind: str, one_sided: bool) -> str:
    name, axis, carries, c_axis, travel = KINDS[kind]
    low, high = travel if one_sided else (-110, 110)
    head, rates = carries == "tool", (rng.randrange(36, 61, 4), rng.randrange(60, 121, 10))
    point = [0, 0, rng.randrange(150, 200)] if head else [rng.randrange(-30, 31), 0, -rng.randrange(20, 90)]
    tilting = ROTARY.format(
        name=name, carries=carries, axis=axis, point=point, rate=rates[0], acceleration=5 * rates[0],
        limits=f"\nlimits = [{low}, {high}]",
    )  # fmt: skip
    turning = ROTARY.format(
        name="C", carries="workpiece", axis=c_axis, point=[0, 0, 0], limits="", rate=rates[1],
        acceleration=5 * rates[1],
    )  # fmt: skip
    title = f'name = "{kind}"\nsource = "drawn for this lesson"\n'
    rest = REST.replace("{length}", str(rng.randrange(80, 161, 10)))
    return title + (turning + tilting if head else tilting + turning) + rest


def _path(rng: random.Random, pole: str) -> str:
    """Draw a path along a shallow arc, on which the tool tilts in a plane past the pole."""
    t = np.arange(RECORDS) - MIDDLE
    heading, radius, height = rng.uniform(0, 2 * np.pi), rng.uniform(25, 60), rng.uniform(5, 40)
    points = np.stack([4.0 * t, radius + t**2 / 4, height - t / 3], axis=1)
    step, shift = rng.uniform(2.0, 3.2), 0.0 if pole == "at a record" else rng.uniform(0.25, 0.75)
    aside = np.sin(np.radians(rng.uniform(0.3, 0.6))) if pole == "beside" else 0.0
    tilt = np.radians(step * (t - shift))
    axes = np.stack([np.sin(tilt), np.full(RECORDS, aside), np.cos(tilt)], axis=1)
    turn = np.array([[np.cos(heading), -np.sin(heading), 0], [np.sin(heading), np.cos(heading), 0], [0, 0, 1]])
    feeds = rng.sample(FEEDS, 2)
    halves = [
        cldata.from_arrays(points[part] @ turn.T, axes[part] @ turn.T, feed=feed)
        for part, feed in zip((slice(0, MIDDLE), slice(MIDDLE, None)), feeds, strict=True)
    ]
    return cldata.to_text(halves[0], title="part") + cldata.to_text(halves[1])


def drawn(rng: random.Random) -> dict[str, int]:
    """Draw the number of a learner's part and machine."""
    return {"seed": rng.randrange(1, 10**6)}


OWN = {"drawn": drawn, "together": "07c"}


def pose(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Draw a tip and a tool axis within 60° of the pole."""
    lean, heading = np.radians(rng.uniform(5, 60)), rng.uniform(-np.pi, np.pi)
    axis = [np.sin(lean) * np.cos(heading), np.sin(lean) * np.sin(heading), np.cos(lean)]
    return rng.uniform(-80, 80, 3), np.array(axis)


INVERSE = Written("inverse(tip, axis), which returns two rows of five joints, mm and radians", pose)


def not_inverse(answer: Sequence, seed: int) -> str:
    """Say which of the solutions gives a different pose, or that both are one."""
    kin = task(seed).kin
    found = np.array(answer)
    if found.shape[1:] != (2, 5):
        return f"It returns an array of shape {found.shape[1:]}, not (2, 5)."
    for (tip, axis), rows in zip(INVERSE.inputs, found, strict=True):
        tips, axes = kin.forward(rows)
        for number, (its_tip, its_axis) in enumerate(zip(tips, axes, strict=True), 1):
            if np.linalg.norm(its_axis - axis) > SAME_POSE:
                lean = np.degrees(2 * np.arcsin(np.linalg.norm(its_axis - axis) / 2))
                return f"Solution {number} makes a tool axis that is {lean:.3f}° off."
            if np.linalg.norm(its_tip - tip) > SAME_POSE:
                off = np.linalg.norm(its_tip - tip)
                return f"Both angles of solution {number} are right; X Y Z take the tip {off:.3f} mm away."
        if np.abs(np.sin(np.diff(rows[:, 3:], axis=0) / 2)).max() < SAME_POSE:
            return "Both solutions are the same branch."
    return ""


@define("07c-inverse", INVERSE, complaint=not_inverse, **OWN)
def both_branches(seed=0):
    """Both branches make the same pose, at inputs drawn at random: what is right there is right anywhere."""

    def inverse(tip, axis):
        return task(seed).kin.inverse(tip, axis)

    return inverse


@define("07c-pole", Vector(names="place degrees", decimals=2), **OWN)
def nearest_to_the_pole(seed=0, at_records=False, first=1):
    """The foot of the perpendicular from the pole to the arc between two records, or a record itself."""
    kin, path = task(seed).kin, task(seed).path
    part, away = singular.nearest(kin, path.axes[:-1], path.axes[1:])
    if at_records:
        part, away = np.zeros(len(path)), singular.distance(kin, path.axes)
    move = int(away.argmin())
    return [first + move + part[move], np.degrees(away[move])]


@define("07c-turn", Number(decimals=1, unit="degrees"), **OWN)
def least_turn(seed=0, by_formula=False, granted=GRANTED, travel=True):
    """Bellman's recursion with the turn of C as the cost; a record at the pole has the C of its neighbours."""
    kin, path = task(seed).kin, task(seed).path
    found = selection.candidates(kin, path.points, path.axes).joints
    found = kin.inverse(path.points, path.axes) if by_formula else found
    there = ~np.isnan(found).any(axis=-1)
    inside = kin.machine.within(found).all(axis=-1) if travel else there
    nodes = [rows[fits] for rows, fits in zip(found, there & inside, strict=True)]
    _, away = singular.nearest(kin, path.axes[:-1], path.axes[1:])
    least = np.zeros(len(nodes[0]))
    for (before, after), from_pole in zip(pairwise(nodes), away, strict=True):
        turns = np.abs(after[:, None, kin.workpiece_side] - before[:, kin.workpiece_side])
        turns = np.minimum(turns % (2 * np.pi), -turns % (2 * np.pi))
        same_branch = after[:, None, kin.tool_side] * before[:, kin.tool_side] >= 0
        least = np.where(same_branch | (from_pole <= granted), least + turns, np.inf).min(axis=1)
    return np.degrees(least.min())


def not_proved(text: str, seed: int) -> str:
    """Say what is wrong with a program for the learner's part and machine."""
    return unproved(text, task(seed).kin, task(seed).path)


@define("07c-program", Program(), given=lambda seed: task(seed), complaint=not_proved, **OWN)
def program(seed=0):
    """Read back, it reaches every record at its feed, and keeps tip, arc and travel between them."""
    return postprocess(task(seed).path, task(seed).kin.machine, name="part").program


def seconds_at_the_feeds(seed: int) -> float:
    """Return the seconds of the path if only its feeds counted."""
    path = task(seed).path
    return float(np.nansum(cldata.feed_times(path.points, path.feeds[1:])))


@define("07c-package", Number(decimals=2, unit="s"), **OWN)
@slip("feeds alone", seconds_at_the_feeds)
def seconds_of_the_package(seed=0):
    """The package's default, `direct`, timed as its text is read back."""
    return postprocess(task(seed).path, task(seed).kin.machine, name="part").report.time
