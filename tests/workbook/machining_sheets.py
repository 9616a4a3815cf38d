"""Right sheets of five-axis machines: tables of NC words.

The formulas are written by hand for each machine; the truth is the machine's pose, from SciPy's rotations about the
axes of its file: the words must put the tool where the row says.
"""

import tomllib
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

MACHINES = Path(__file__).parents[2] / "data/machines"
# The formulas of each machine, {I} {J} {K} {X} {Y} {Z} from the row, and {name} of what stands to the left of it;
# constants of the machine as {:name}. Rotary words in degrees.
ROTATED = {
    "x1": "={x}*COS(RADIANS({C}))+{y}*SIN(RADIANS({C}))",
    "y1": "=-{x}*SIN(RADIANS({C}))+{y}*COS(RADIANS({C}))",
}
TABLES = {
    "ac_table": (
        {"pivot": 50},
        {"A": "=DEGREES(ACOS({k}))", "C": "=DEGREES(ATAN2(-{j},{i}))"},
        ROTATED,
        {
            "X": "={x1}",
            "Y": "={y1}*COS(RADIANS({A}))+({z}+{pivot})*SIN(RADIANS({A}))",
            "Z": "=-{y1}*SIN(RADIANS({A}))+({z}+{pivot})*COS(RADIANS({A}))-{pivot}",
        },
    ),
    "bc_table": (
        {"pivot": 120},
        {"B": "=ACOS({k})*180/PI()", "C": "=ATAN2({i},{j})*180/PI()"},
        ROTATED,
        {
            "X": "={x1}*COS(RADIANS({B}))-({z}+{pivot})*SIN(RADIANS({B}))",
            "Y": "={y1}",
            "Z": "={x1}*SIN(RADIANS({B}))+({z}+{pivot})*COS(RADIANS({B}))-{pivot}",
        },
    ),
    "head_b_table_c": (
        {"length": 300},
        {"B": "=DEGREES(ATAN2({k},SQRT({i}^2+{j}^2)))", "C": "=DEGREES(ATAN2({i},{j}))"},
        ROTATED,
        {
            "X": "={x1}+{length}*SIN(RADIANS({B}))",
            "Y": "={y1}",
            "Z": "={z}+{length}*COS(RADIANS({B}))-{length}",
        },
    ),
    "ac_head": (
        {"length": 350},
        {"A": "=DEGREES(ACOS({k}))", "C": "=DEGREES(ATAN2(-{j},{i}))"},
        {},
        {"X": "={x}+{length}*{i}", "Y": "={y}+{length}*{j}", "Z": "={z}+{length}*{k}"},
    ),
    "dmu50v": (
        {"pivot": 50},
        {
            "B": "=DEGREES(ACOS(2*{k}-1))",
            "C": "=DEGREES(ATAN2(-{i}*SIN(RADIANS({B}))/SQRT(2)+{j}*(1-COS(RADIANS({B})))/2,"
            "{i}*(1-COS(RADIANS({B})))/2+{j}*SIN(RADIANS({B}))/SQRT(2)))",
        },
        {
            "x1": "={x}*COS(RADIANS({C}))-{y}*SIN(RADIANS({C}))-{pivot}",
            "y1": "={x}*SIN(RADIANS({C}))+{y}*COS(RADIANS({C}))",
        },
        {
            "X": "=COS(RADIANS({B}))*{x1}+SIN(RADIANS({B}))/SQRT(2)*({z}-{y1})+{pivot}",
            "Y": "=SIN(RADIANS({B}))/SQRT(2)*{x1}+(1+COS(RADIANS({B})))/2*{y1}+(1-COS(RADIANS({B})))/2*{z}",
            "Z": "=-SIN(RADIANS({B}))/SQRT(2)*{x1}+(1-COS(RADIANS({B})))/2*{y1}+(1+COS(RADIANS({B})))/2*{z}",
        },
    ),
}


def forward(name, linear, rotary):
    """Tip and tool axis in the workpiece, shape (6, n), of linear (3, n) and rotary words (2, n) in degrees."""
    with open(MACHINES / f"{name}.toml", "rb") as file:
        data = tomllib.load(file)
    joints = []
    for joint, words in zip(data["rotary"], rotary, strict=True):
        axis = np.array(joint["axis"], dtype=float)
        turns = Rotation.from_rotvec(np.outer(np.radians(words), axis / np.linalg.norm(axis)))
        joints.append((joint["carries"], turns, np.array(joint["point"], dtype=float)))
    origin, length = np.array(data["workpiece"]["origin"], dtype=float), data["tool"]["length"]
    tip = np.array([0.0, 0, -length])
    programmed = data["tool"]["programmed_point"]
    programmed = tip if programmed == "tip" else np.array(programmed, dtype=float)
    nose = linear.T + origin - programmed
    tip, axis = nose + tip, np.tile([0.0, 0, 1], (linear.shape[1], 1))
    for carries, turns, point in reversed(joints):
        if carries == "tool":
            tip, axis = turns.apply(tip - nose - point) + nose + point, turns.apply(axis)
    for carries, turns, point in joints:
        if carries == "workpiece":
            tip, axis = turns.inv().apply(tip - point) + point, turns.inv().apply(axis)
    return np.vstack([(tip - origin).T, axis.T])


def first_in_file(name):
    with open(MACHINES / f"{name}.toml", "rb") as file:
        return tomllib.load(file)["rotary"][0]["name"]


def order_of(name, angles, tilts, turns):
    """The rotary words in the order of the machine's file."""
    return np.array([tilts, turns] if first_in_file(name) == next(iter(angles)) else [turns, tilts])
