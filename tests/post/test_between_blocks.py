"""The error between blocks and paths divided to keep a tolerance, against closed forms and dense sampling."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation, Slerp

from mathpost import machine
from mathpost.errors import ReachError
from mathpost.kinematics import Kinematics
from mathpost.path import cl
from mathpost.path import deviation as module
from mathpost.path.deviation import (
    AXIS,
    AXIS_RESOLUTION,
    RESOLUTION,
    TIP,
    _intervals,
    bounds,
    derivative,
    deviation,
    from_arc,
    largest,
    levers,
    sampled,
    true_tip,
)
from mathpost.post import singular
from mathpost.post.between_blocks import axis_lag, follow, linearize, subdivide
from mathpost.post.motion import Motion
from tests.machines import SIDES, content


def moves(kin, count, seed):
    """Random moves from tiny to large: joints at both ends."""
    rng = np.random.default_rng(seed)
    start = np.concatenate([rng.uniform(-200, 200, (count, 3)), rng.uniform(-1.5, 1.5, (count, 2))], axis=1)
    step = rng.normal(size=(count, 5)) * [3, 3, 3, 1, 1]
    step[:, 3:] *= 10.0 ** rng.uniform(-4, 0, (count, 1))
    return start, start + step


@pytest.mark.parametrize("turn", [1, 30, 90, 177.376])
def test_pure_turn_has_the_sagitta(dmu50v, turn):
    ends = dmu50v.close([77.0955, 0, 10], np.radians([[0, 0], [0, turn]]))
    tip, axis = deviation(dmu50v, ends[:1], ends[1:])
    assert tip[0] == pytest.approx(77.0955 * (1 - np.cos(np.radians(turn) / 2)), rel=1e-4)
    assert axis[0] == pytest.approx(0, abs=1e-12)


def test_default_sampling_misses_no_more_than_its_resolution(kin):
    start, end = moves(kin, 400, seed=1)
    (tip, axis), (dense_tip, dense_axis) = deviation(kin, start, end), deviation(kin, start, end, least=1024)
    np.testing.assert_allclose(tip, dense_tip, rtol=0, atol=RESOLUTION)
    np.testing.assert_allclose(axis, dense_axis, rtol=0, atol=RESOLUTION / 100)


@pytest.mark.parametrize("off", [0, 0.0008, 0.002, 0.003])  # mm, of the ends, on one side and on the other
def test_ends_on_either_side_of_the_segment_hide_no_peak(dmu50v, off):
    """Against distances from a line at 20,001 points: a magnitude has a kink where its vector turns round."""
    tips, rotary = np.array([[77.0, -5, 0], [77.0, 5, 0]]), np.array([[0.3, 0], [0.3, 0.003]])
    ends = dmu50v.close(tips + np.outer([off, -off], [1, 0, 0]), rotary)
    at, _ = dmu50v.forward(np.linspace(*ends, 20_001))
    from_line = np.hypot(at[:, 0] - 77, at[:, 2])
    tip, _ = deviation(dmu50v, ends[:1], ends[1:], tips=tips[:, None])
    assert tip[0] == pytest.approx(from_line.max(), abs=RESOLUTION / 10)


def test_the_true_tip_is_where_the_joints_take_it(kin):
    start, end = moves(kin, 1, seed=4)
    joints = np.array([start[0], end[0], start[0] + 5])
    tip = true_tip(kin, joints, samples=4).reshape(2, 5, 3)
    for move in range(2):
        quarter = joints[move] + (joints[move + 1] - joints[move]) / 4
        np.testing.assert_allclose(tip[move, [0, 1, -1]], kin.forward([joints[move], quarter, joints[move + 1]])[0])


@pytest.mark.parametrize("turn", [0.01, 0.1, 0.5])
def test_the_axis_lags_behind_the_great_circle_of_the_records(kin, turn):
    rng = np.random.default_rng(6)
    joints = np.cumsum(rng.normal(size=(6, 5)) * [1, 1, 1, turn, turn], axis=0)
    points, axes = kin.forward(joints)
    place = np.array([0, 0.25, 1, 2.5, 3, 5])  # the joints keep neither to the records nor to their parts
    found = axis_lag(kin, cl.from_arrays(points, axes), joints[:-1], joints[1:], place[:-1], place[1:])
    t = np.linspace(0, 1, 2001)[:, None]
    for move, (here, there) in enumerate(pairwise(place)):
        first = int(here)
        if there > first + 1:  # past a record the great circle ends
            continue
        turned = Rotation.align_vectors(axes[first + 1], axes[first])[0]
        between = Slerp([0, 1], Rotation.concatenate([Rotation.identity(), turned]))
        wanted = between(here + t[:, 0] * (there - here) - first).apply(axes[first])
        _, axis = kin.forward(joints[move] + t * (joints[move + 1] - joints[move]))
        lag = 2 * np.arcsin(np.linalg.norm(axis - wanted, axis=1).max() / 2)
        assert lag - 1e-9 <= found[move] <= lag + 2 * AXIS_RESOLUTION


@pytest.mark.parametrize("order", [2, 3])
@pytest.mark.parametrize("sides", SIDES)
def test_no_derivative_of_the_tip_is_beyond_its_bound(sides, order):
    """By differences, which are no greater than the derivative; on machines all of whose offsets count."""
    file = content(
        (1, 0, 0),
        (0, 3, 4),
        sides,
        point=((30, -120, 50), (-200, 10, 75)),
        origin=(40, -300, 20),
        length=150,
        programmed=[20, -30, 90],
    )
    kin = Kinematics(machine.from_dict(file))
    start, end = moves(kin, 300, seed=7)
    most = derivative(kin.machine, start, end, order)
    intervals = 64
    t = np.linspace(0, 1, intervals + 1)[:, None, None]
    tip, _ = kin.forward(start + t * (end - start))
    found = np.linalg.norm(np.diff(tip, order, axis=0), axis=-1).max(axis=0) * intervals**order
    large = most > 1e-9 * intervals**order  # where differences keep digits
    assert large.sum() > 100 and (found <= most)[large].all()
    assert (found / most)[large].max() > 0.1, "a bound, and no more than needed"


def test_the_number_of_samples_follows_the_turn_and_the_levers(kin):
    start, end = np.zeros((3, 5)), np.array([[500.0, 0, 0, 0, 0], [0.1, 0, 0, 1e-3, 0], [0, 0, 0, 1, 1]])
    straight, small, large = _intervals(kin.machine, start, end, 2)
    assert straight == 2 and small <= 4 and large >= 64
    # Eight times the third derivative takes twice the intervals.
    far = np.array([7 * (levers(kin.machine) + 1), 0, 0, 0, 0])
    assert _intervals(kin.machine, start[2:] + far, end[2:] + far, 2) == 2 * large


def paths(kin, seed, turn, off):
    """A random path with turns of about `turn` radians, and one beside it: tips off by mm, axes by radians."""
    rng = np.random.default_rng(seed)
    step = rng.normal(size=(400, 5)) * [1, 1, 1, turn, turn] * 10.0 ** rng.uniform(-2, 0, (400, 1))
    joints = np.cumsum(step, axis=0)
    reached = kin.forward(joints)
    tips = reached[0] + off * rng.uniform(-1, 1, (400, 3))
    axes = reached[1] + off / 100 * rng.uniform(-1, 1, (400, 3))
    return joints, tips, axes / np.linalg.norm(axes, axis=1, keepdims=True), reached


def of_all(kin, joints, tips, axes):
    """The deviation of every move."""
    return deviation(kin, joints[:-1], joints[1:], tips=(tips[:-1], tips[1:]), axes=(axes[:-1], axes[1:]))


SIZES = [(1e-4, 1e-4), (0.01, 0), (0.01, 1e-3), (0.3, 1e-6), (2, 1)]


@pytest.mark.parametrize(("turn", "off"), SIZES)
def test_no_move_strays_beyond_its_bound(kin, turn, off):
    joints, tips, axes, reached = paths(kin, 5, turn, off)
    found, most = np.array(of_all(kin, joints, tips, axes)), bounds(kin.machine, joints, tips, axes, reached)
    assert (found <= most * (1 + 1e-9) + 1e-12).all()
    # Without the second derivative, or without what the ends are off, some would.
    assert off == 0 or (found[0] > derivative(kin.machine, joints[:-1], joints[1:], 2) / 8).any() or turn > 0.1
    assert turn < 0.01 or (found[0] > 3 * off).any()


def ends_of(vectors):
    """Of moves between vectors that follow each other."""
    return lambda moves: (vectors[moves], vectors[moves + 1])


@pytest.mark.parametrize(("turn", "off"), SIZES)
def test_the_largest_is_that_of_all_moves(kin, turn, off):
    for seed in range(5):
        joints, tips, axes, reached = paths(kin, seed, turn, off)
        expected = of_all(kin, joints, tips, axes)
        most = bounds(kin.machine, joints, tips, axes, reached)
        most[np.random.default_rng(seed).random(most.shape) < 0.1] = -1
        for what, path in ((TIP, tips), (AXIS, axes)):
            wanted = np.where(most[what.index] < 0, 0, expected[what.index])
            for known in (most[what.index], np.where(most[what.index] < 0, -1, np.inf)):
                error, move = largest(what, kin, joints, ends_of(path), known.copy())
                assert wanted.max() * (1 - 1e-9) <= error <= wanted.max() + what.resolution
                assert move == wanted.argmax()


def test_few_moves_are_looked_at(dmu50v, monkeypatch):
    joints, tips, axes, reached = paths(dmu50v, 1, 0.01, 1e-3)
    most, looked = bounds(dmu50v.machine, joints, tips, axes, reached), []
    monkeypatch.setattr(
        module,
        "sampled",
        lambda kin, start, *rest, **more: looked.append(len(start)) or sampled(kin, start, *rest, **more),
    )
    largest(TIP, dmu50v, joints, ends_of(tips), most[0])
    assert len(joints) == 400 and len(looked) == 2 and sum(looked) < 100


def test_no_moves_counted(dmu50v):
    joints, tips, *_ = paths(dmu50v, 1, 0.01, 1e-3)
    assert largest(TIP, dmu50v, joints, ends_of(tips), np.full(len(joints) - 1, -1.0)) == (0, 0)
    assert largest(TIP, dmu50v, joints[:1], ends_of(tips[:1]), np.empty(0)) == (0, -1)


unit_vectors = st.tuples(*[st.floats(-1, 1)] * 3).map(np.array).filter(lambda v: np.linalg.norm(v) > 0.1)


# Normalised twice, the start comes out one unit in the last place longer: no arc, though the two are not equal.
ALONG_ITSELF = np.array([0.5, -2.966841083808683e-11, 0.5])


@settings(max_examples=500, deadline=None)
@example(np.array([0.0, -1, 0]), ALONG_ITSELF, ALONG_ITSELF, 1e-8)
@given(unit_vectors, unit_vectors, unit_vectors, st.sampled_from([1.0, 1e-3, 1e-6, 1e-8, 1e-11]))
def test_angle_from_a_great_circle_is_the_least_to_any_axis_on_it(axis, start, other, size):
    axis, start, other = (vector / np.linalg.norm(vector) for vector in (axis, start, other))
    end, axis = start + size * (other - start), start + size * (axis - start)
    end, axis = end / np.linalg.norm(end), axis / np.linalg.norm(axis)
    found = from_arc(axis, start, end)
    along = start + np.linspace(0, 1, 20001)[:, None] * (end - start)
    length = np.linalg.norm(along, axis=1, keepdims=True)
    if length.min() > 1e-3:
        dense = 2 * np.arcsin(np.linalg.norm(axis - along / length, axis=1) / 2).min()
        step = np.linalg.norm(end - start) / 20000 / length.min()  # where the chord passes near the centre
        assert found == pytest.approx(dense, rel=1e-3, abs=step + 2e-15)


def test_linearized_path_keeps_the_tolerance_in_dense_sampling(kin):
    rng = np.random.default_rng(2)
    joints = np.cumsum(rng.normal(size=(30, 5)) * [5, 5, 5, 0.1, 0.1], axis=0)
    found = linearize(kin, joints, 0.01)
    assert deviation(kin, found.joints[:-1], found.joints[1:], least=256)[0].max() <= 0.01 * 1.01
    np.testing.assert_array_equal(found.joints[found.place % 1 == 0], joints)
    tip, corners = kin.forward(found.joints)[0], kin.forward(joints)[0]
    expected = np.stack([np.interp(found.place, np.arange(30), column) for column in corners.T], axis=1)
    np.testing.assert_allclose(tip, expected, atol=1e-9)
    assert len(linearize(kin, joints, 1e9).joints) == 30


LEANING = content((1, 0, 0), (0, 0, 1), tool=(0, -1, 2))  # whose two solutions do not meet at tool_side zero


@pytest.mark.parametrize("turns", [-2, 0, 3])
@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize("file", [content((1, 0, 0), (0, 0, 1)), LEANING], ids=["upright", "leaning"])
def test_a_divided_move_stays_on_its_branch_and_in_its_winding(file, side, turns):
    kin = Kinematics(machine.from_dict(file))
    joints = np.zeros((2, 5))
    joints[:, kin.tool_side] = float(sum(kin.inverse_symbolic.solutions) / 2) + side * np.array([0.3, 0.4])
    joints[:, kin.workpiece_side] = 2 * np.pi * turns + np.array([0.5, 1.7])
    path = cl.from_arrays(*kin.forward(joints))
    found = follow(kin, path, Motion.on_part(joints, [0, 1]), 1e-3)
    assert len(found.joints) > 8
    np.testing.assert_array_equal(found.joints[[0, -1]], joints)
    np.testing.assert_allclose(kin.forward(found.joints), path.at(found.place), atol=1e-9)
    assert np.abs(np.diff(found.joints[:, 3:], axis=0)).max() < 0.3


def test_past_a_singular_axis_two_poses_stand_close_beside_it(kin):
    """The tool-side axis stands on both sides of it alike, and the workpiece-side one by half a turn apart."""
    if kin.reach[0] > 0:
        pytest.skip("does not apply: the pole is out of reach")
    joints, tolerance = np.zeros((2, 5)), 1e-3
    joints[:, kin.tool_side] = float(sum(kin.inverse_symbolic.solutions) / 2) + 0.2
    joints[1, kin.workpiece_side] = np.pi
    path = cl.from_arrays(*kin.forward(joints))
    found = follow(kin, path, Motion.on_part(joints, [0, 1]), tolerance)
    poses = kin.forward(found.joints)[1]
    before = np.abs(np.diff(found.joints[:, kin.workpiece_side])).argmax()
    away = singular.distance(kin, poses[before : before + 2])
    np.testing.assert_allclose(away, 2 * singular.STILL * tolerance, rtol=1e-2)
    lag = axis_lag(kin, path, found.joints[:-1], found.joints[1:], found.place[:-1], found.place[1:])
    assert lag.max() <= tolerance


def test_subdivide(kin):
    start, end = moves(kin, 3, seed=3)
    joints, place = subdivide(kin, start, end, [1, 2, 4])
    np.testing.assert_array_equal(place, [1, 1.5, 2, 2.25, 2.5, 2.75, 3])
    np.testing.assert_array_equal(joints[[0, 2, 6]], end)
    np.testing.assert_allclose(joints[1, 3:], (start + end)[1, 3:] / 2)


def test_too_fine_a_tolerance_names_the_block(dmu50v):
    joints = dmu50v.close([77.0, 0, 0], [[0, 0], [0, 0.1], [0, 3]])
    with pytest.raises(ReachError, match=r"from row 2 to 3.*16 pieces"):
        linearize(dmu50v, joints, 0.01, max_pieces=16, name="row")
