"""Answers as learners type them, right and wrong; the third angle where the control goes."""

import math
import tomllib
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mathpost import euler, rotation
from mathpost.shop.plane import positioning
from mathpost.shop.plane.positioning import align
from mathpost.shop.plane.tilted_plane import Plane
from mathpost.teaching.course import exercise
from mathpost.teaching.course.answers import Written
from mathpost.teaching.course.lesson_data import load
from mathpost.teaching.course.verdict import EXERCISES, RIGHT, WRONG

TYPED = tomllib.loads(Path(__file__).with_name("typed_answers.toml").read_text(encoding="utf-8"))
PAIRS = [(name, pair) for name, typed in TYPED.items() for pair in typed.get("wrong", ())]


def with_column(R, column):
    """A 4×4 matrix of a rotation and a last column."""
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = R, column
    return matrix


def face_right(p, q, r):
    """The frame of three points with x straight down the slope, by projections only."""
    normal = np.linalg.svd(np.array([q - p, r - p]))[2][2]
    z = normal * np.sign(normal[2])
    x = np.array([z[0] * z[2], z[1] * z[2], -(z[0] ** 2 + z[1] ** 2)])
    x = x / np.linalg.norm(x)
    return np.stack([x, np.cross(z, x), z], axis=1)


KNOWN = {
    "np": np,
    "math": math,
    "c": math.cos,
    "s": math.sin,
    "rotation": rotation,
    "euler": euler,
    "Rotation": Rotation,
    "Rx": lambda t: Rotation.from_euler("x", t).as_matrix(),
    "Ry": lambda t: Rotation.from_euler("y", t).as_matrix(),
    "Rz": lambda t: Rotation.from_euler("z", t).as_matrix(),
    "with_column": with_column,
    "face_right": face_right,
    "link_right": lambda R, p: with_column(R, p - R @ p),
}


def typed(name, answer):
    """An answer of the table: of functions the text is evaluated."""
    return eval(answer, KNOWN) if isinstance(EXERCISES[name].kind, Written) else answer


LESSONS = ("00", "01", "02", "02b", "03", "03b", "04", "05", "05b", "06", "06b", "07", "07c")
ELSEWHERE = {"06b-whole", "07-alone", "07c-inverse", "07c-program"}  # programs and a function: their own tests


def test_every_exercise_of_these_lessons_is_typed():
    ours = {name for name in EXERCISES if name.split("-")[0] in LESSONS}
    assert set(TYPED) >= ours - ELSEWHERE
    assert min(len(TYPED[name]["wrong"]) for name in ours - ELSEWHERE) >= 7


@pytest.mark.parametrize("name", TYPED)
def test_right_in_every_usual_form(name):
    said = {str(answer): str(exercise.judge(name, typed(name, answer))) for answer in TYPED[name].get("right", ())}
    assert {answer: why for answer, why in said.items() if f"{name} · {RIGHT}." not in why} == {}


@pytest.mark.parametrize(("name", "pair"), PAIRS, ids=lambda each: each if isinstance(each, str) else str(each[0]))
def test_wrong_and_what_is_said(name, pair):
    answer, said = pair
    verdict = exercise.judge(name, typed(name, answer))
    assert verdict.status == WRONG
    assert said in verdict.why


def test_a_quaternion_in_scipys_order_is_right_and_said():
    quaternion = Rotation.from_euler("ZXZ", EXERCISES["03-face"].solution, degrees=True).as_quat()
    assert "SciPy's order" in exercise.judge("03-face", quaternion).why
    assert "SciPy" not in exercise.judge("03-face", np.roll(quaternion, 1)).why


# --- position first, K second -----------------------------------------------------------------------------------

THIRD = {("A", 1): 0, ("A", -1): 180, ("B", 1): -90, ("B", -1): 90}  # lesson 03b: by the tilting axis and its sign


def clearance(name, angles, i, j, k):
    """How far the tip of a bar in a bore of 10 mm is from the wall when it has moved by 1 mm along minus the
    feature's X, by vectors in the workpiece alone: the spindle from its machine's turns, the feature from SciPy.
    """
    feature = Rotation.from_euler("ZXZ", [i, j, k], degrees=True).as_matrix()
    by_name = dict(zip([rotary.name for rotary in load(name).machine.rotary], angles, strict=True))
    tilt = "A" if "A" in by_name else "B"
    spindle = Rotation.from_euler(
        "Z" + "XY"["AB".index(tilt)], [by_name["C"], by_name[tilt]], degrees=True
    ).as_matrix()
    assert spindle[:, 2] == pytest.approx(feature[:, 2])
    tip = 10 * spindle[:, 0] - 1 * feature[:, 0]
    return 10 - np.linalg.norm(tip)


@pytest.mark.parametrize("name", ["ac_table", "bc_table", "head_b_table_c", "ac_head"])
def test_forty_faces_by_the_rules_of_the_controls(name):
    """On 40 faces at random, from positions at random, where Fanuc, Heidenhain and Siemens go."""
    rng = np.random.default_rng([7, *name.encode()])
    seen = set()
    for _ in range(40):
        i, j = rng.uniform(-180, 180), rng.uniform(5, 85)
        level = align(Plane("G68.2", [i, j, 0]).frame, load(name))
        now = rng.uniform(-30, 30), rng.uniform(-180, 180)
        present = now if level.tool_side == 0 else now[::-1]
        letter = load(name).machine.rotary[level.tool_side].name
        for choice in (
            positioning.fanuc(level, present),
            positioning.heidenhain(level, present),
            positioning.siemens(level, present, 1),
            positioning.siemens(level, present, -1),
        ):
            side = int(np.sign(choice.angles[level.tool_side]))
            seen.add(side)
            k = THIRD[letter, side]
            assert clearance(name, choice.angles, i, j, k) == pytest.approx(1)
            assert clearance(name, choice.angles, i, j, THIRD[letter, -side]) == pytest.approx(-1)
            assert np.cos(np.radians(choice.third_angle() - k)) == pytest.approx(1)
    assert seen == {1, -1}


def test_a_bar_that_is_too_short_is_not_shown_as_long_enough():
    """Found among whole angles: the shortest bar rounds to 2.00 and is not longer than 2."""
    shown = {
        str(exercise.judge("14-angles", (a, b, c))) for a in (20, 37) for b in range(16, 75) for c in (-59, 50)
    }
    assert not any("only 2.0" in each for each in shown) and any("only 1." in each for each in shown)
