"""The functions of lessons 06 and 06b, as their cells stand, on machines, arcs and paths that no lesson uses."""

import json
from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation

from mathpost import machine_file, postprocess
from mathpost.kinematics import Kinematics
from mathpost.path import cl, selection
from mathpost.teaching.course import exercise
from mathpost.teaching.course.lesson_data import load
from mathpost.teaching.course.verdict import RIGHT
from tests.conftest import ROOT
from tests.machines import SIDES, content

CELLS = (
    "foot", "arriving", "pole-candidates", "measure", "division", "division-2", "followed", "stations",
)  # fmt: skip
POLE = np.array([0, 0, 1.0])


def drawn(rng):
    """A machine with C about the vertical, along which its tool can stand, and a second axis in any direction."""
    lean, heading = rng.choice([np.pi / 2, rng.uniform(0.3, np.pi / 2)]), rng.uniform(0, 2 * np.pi)
    axis = np.array([np.sin(lean) * np.cos(heading), np.sin(lean) * np.sin(heading), np.cos(lean)])
    tool = Rotation.from_rotvec(rng.choice([0, rng.uniform(-1, 1)]) * axis).apply(POLE)
    sides, turning = SIDES[rng.integers(3)], (0, 0, rng.choice([-1.0, 1.0]))
    axes = (axis, turning) if sides[1] == "workpiece" else (turning, axis)
    points = rng.uniform(-200, 200, (2, 3))
    return Kinematics(machine_file.from_dict(content(*axes, sides, point=points.tolist(), tool=tool)))


NUTATING = load("nutating_head")
# What lesson 06 says that somebody's own machine must have.
OWN = SimpleNamespace(
    **{name: getattr(NUTATING, name) for name in ("forward", "inverse", "close", "workpiece_side")}
)


def functions(lesson, cells):
    """What some cells of a lesson define."""
    notebook = json.loads((ROOT / f"notebooks/{lesson}.ipynb").read_text(encoding="utf-8"))
    source = {cell["id"]: "".join(cell["source"]) for cell in notebook["cells"]}
    names = {"np": np, "pairwise": pairwise}
    for cell in cells:
        exec(source[cell], names)
    return names


@pytest.fixture(scope="module")
def own():
    """The functions of lesson 06, by name."""
    return functions("06_singular_region", CELLS)


def proved(own, kin, one, two, segment):
    """All poses from one to the other, their tolerances proved by the lesson's measure and by one of ours."""
    blocks = [one, *own["through"](kin, one, two, segment)]
    tip, lean = np.max([own["error"](kin, *pair, segment) for pair in pairwise(blocks)], axis=0)
    (P, Q), axes = segment
    poses = np.concatenate([np.linspace(*pair, 31) for pair in pairwise(blocks)])
    tips, tools = kin.forward(poses)
    along, normal = Q - P, np.cross(*axes)
    across = np.cross(tips - P, along) / np.linalg.norm(along) if along.any() else tips - P
    out = np.degrees(np.arcsin(np.abs(tools @ normal) / max(np.linalg.norm(normal), 1e-12)))
    assert max(tip, np.linalg.norm(across, axis=1).max()) <= 0.01 and max(lean, out.max()) <= 0.1
    return blocks


def over_the_pole(first, last, beside=0.0, heading=0.0):
    """Tool axes at two tilts in a plane that passes the pole at a distance, radians."""
    tilt = np.array([first, last])
    axes = [np.sin(tilt) * np.cos(beside), np.full(2, np.sin(beside)), np.cos(tilt) * np.cos(beside)]
    return Rotation.from_rotvec(heading * POLE).apply(np.stack(axes, axis=1))


def test_many_machines_arcs_and_poles(own, of):
    """The pole at a record, within an arc, 1e-13 to 0.1 rad beside it; both branches, and changed at the pole."""
    for seed in range(of(12, 500)):
        rng = np.random.default_rng(seed)
        kin, place = drawn(rng), rng.choice(["first", "last", "within", "beside"])
        share = {"first": 0, "last": 1}.get(place, rng.uniform(0.02, 0.98))
        reach = 0.9 * kin.reach[1]
        size = min(np.radians(np.exp(rng.uniform(np.log(0.5), np.log(60)))), reach)
        beside = 10 ** rng.uniform(-13, -1) if place == "beside" else 0.0
        axes = over_the_pole(-share * size, (1 - share) * size, beside, rng.uniform(0, 2 * np.pi))
        tips = rng.uniform(-80, 80, 3) + np.array([np.zeros(3), rng.uniform(-5, 5, 3) * rng.choice([0, 1])])
        branch, other = rng.integers(2), beside < 1e-7 and rng.random() < 0.5
        one, two = kin.inverse(tips[0], axes[0])[branch], kin.inverse(tips[1], axes[1])[branch ^ other]
        if place == "first":
            one = own["at_the_pole"](kin, tips[0], rng.uniform(-3, 3))
        if place == "last":
            two = own["at_the_pole"](kin, tips[1], rng.uniform(-3, 3))
        blocks = proved(own, kin, one, two, (tips, axes))
        assert np.concatenate(kin.forward(blocks[-1])) == pytest.approx(np.r_[tips[1], axes[1]], abs=1e-6), seed
        assert len(blocks) < 1000, seed


@pytest.mark.parametrize("name", ["own", "dmu50v", "ac_table", "head_b_table_c"])
@pytest.mark.parametrize("tilts", [(-15, 25), (-29.013, 31.02)])
@pytest.mark.parametrize("beside", [-0.3, 0, 0.05])
def test_machines_of_the_package_through_the_pole_and_beside_it(own, name, tilts, beside):
    """Through it C turns as far as from station to station; beside it halving ends on every branch."""
    kin = OWN if name == "own" else load(name)
    tips, axes = np.array([[30, 0, 0], [31, 2, 0.0]]), over_the_pole(*np.radians(tilts), np.radians(beside))
    one, two = (kin.inverse(tip, axis)[1] for tip, axis in zip(tips, axes, strict=True))
    blocks = proved(own, kin, one, two, (tips, axes))
    stations = [pose for _, pose in own["stations"](kin, one, two, (tips, axes))]
    turned, least = (np.abs(np.diff(np.array(each)[:, kin.workpiece_side])).sum() for each in (blocks, stations))
    assert beside or turned == pytest.approx(least, abs=1e-4)


def test_the_limit_at_the_pole_is_that_of_smaller_and_smaller_arcs(own):
    """On every machine: C of the inverse at 1e-3, 1e-4 … radians before the pole, extrapolated to 0."""
    for seed in range(10):
        rng = np.random.default_rng(seed)
        kin, heading = drawn(rng), rng.uniform(0, 2 * np.pi)
        axes = over_the_pole(-0.2, 0.3, heading=heading)
        one = kin.inverse(np.zeros(3), axes[0])[0]
        near = [kin.inverse(np.zeros(3), over_the_pole(-s, 0.3, heading=heading)[0])[0] for s in (2e-3, 1e-3)]
        c = [each[kin.workpiece_side] for each in near]
        limit = own["arriving"](kin, one, axes, 0.4)
        assert own["shorter"](limit - (2 * c[1] - c[0])) == pytest.approx(0, abs=2e-5)


@pytest.mark.parametrize("width", [10, 40])
@pytest.mark.parametrize("lowest", [-180, -1])
@pytest.mark.parametrize("kin", [NUTATING, load("dmu50v")], ids=["head", "table"])
def test_eleven_records_one_of_them_at_the_pole(own, kin, width, lowest):
    """With B to both sides C turns by no more than from the first record to the last; with B from -1° it swings."""
    tilt, c = np.radians(np.linspace(-width, width, 11)), kin.workpiece_side
    axes = np.stack([np.sin(tilt) * np.cos(1.1), np.sin(tilt) * np.sin(1.1), np.cos(tilt)], axis=1)
    axes[5] = [0, 0, 1]
    tips = np.stack([np.linspace(30, 50, 11), np.linspace(-9, 9, 11) ** 2 / 9, np.zeros(11)], axis=1)
    poses = []
    for record in own["candidates"](kin, tips, axes):
        inside = [pose for pose in record if pose[7 - c] > np.radians(lowest)]
        before = poses[-1] if poses else inside[-1]
        for pose in inside:
            pose[c] = before[c] + own["shorter"](pose[c] - before[c])
        poses.append(min(inside, key=lambda pose: abs(pose[c] - before[c])))
    for number, pair in enumerate(pairwise(poses)):
        proved(own, kin, *pair, (tips[number : number + 2], axes[number : number + 2]))
    turns = np.degrees(np.diff([pose[c] for pose in poses]))
    assert (np.abs(turns).max() > 90) == (lowest == -1)
    if lowest == -180:
        assert np.abs(turns).sum() == pytest.approx(abs(turns.sum())), "no turn is taken back"


def test_the_distance_to_the_arc_is_that_to_the_nearest_of_many_points_on_it(of):
    """06b's measure of the tool axis, on blocks beside the pole, against a fan of axes turned by SciPy."""
    measure = functions("06b_spline", ["axis-error"])["axis_error"]
    for seed in range(of(5, 100)):
        rng = np.random.default_rng(seed)
        kin, axes = drawn(rng), over_the_pole(*rng.uniform(-0.2, 0.2, 2), rng.uniform(0, 0.1), seed)
        one, two = (kin.inverse(np.zeros(3), axis)[seed % 2] for axis in axes)
        turn = np.arccos(axes[0] @ axes[1]) * np.cross(*axes) / np.linalg.norm(np.cross(*axes))
        fan = Rotation.from_rotvec(np.linspace(0, 1, 2001)[:, None] * turn).apply(axes[0])
        tools = kin.forward(np.linspace(one, two, 101))[1]
        away = np.linalg.norm(tools[:, None] - fan, axis=2).min(axis=1).max()
        assert measure(kin, one, two, axes) == pytest.approx(np.degrees(2 * np.arcsin(away / 2)), abs=0.01)


@pytest.fixture(scope="module")
def ridge():
    """The path of 06b-whole, its solutions, and the program that lesson 06b's cells make with a curve."""
    kin, path = load("dmu50v"), cl.parse(exercise.given("06b-whole"))
    joints = selection.choose(kin, path).joints
    made = functions("06b_spline", ("again", "whole", "asked", "written"))

    def program(curve):
        poses = made["whole"](kin, joints, path.points, 2, curve)
        return made["written"](kin, kin.machine.max_rates, *poses, 800)

    return kin, path, joints[1:5], program


def test_the_spline_to_its_end_on_a_different_path(ridge):
    """By the cells as they stand: right at once with the cubic of (7), and refused with any other curve."""
    _, _, rows, program = ridge
    slopes = [(1, rows[1] - rows[0]), (1, rows[3] - rows[2])]
    clamped, line = CubicSpline([0, 1], rows[1:3], bc_type=slopes), CubicSpline([0, 1], rows[1:3])
    assert exercise.judge("06b-whole", program(clamped)).status == RIGHT
    for curve in (line, CubicSpline([-1, 0, 1, 2], rows)):
        assert "is not on the cubic: at this C it has B" in str(exercise.judge("06b-whole", program(curve)))


@pytest.mark.parametrize(
    ("way", "said"), [("direct", "stays on the part"), ("retract", "not on the cubic"), ("cubic lifted", RIGHT)]
)
def test_the_ways_of_the_package_on_that_path(ridge, way, said):
    kin, path, *_ = ridge
    assert said in str(exercise.judge("06b-whole", postprocess(path, kin.machine, singular=way).program))
