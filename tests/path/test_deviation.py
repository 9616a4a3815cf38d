"""How far moves stray from a path, against closed forms, dense sampling and differences."""

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from mathpost import machine_file
from mathpost.kinematics import Kinematics
from mathpost.path import deviation as module
from mathpost.path.deviation import (
    AXIS,
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
    stray,
    true_tip,
)
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
    kin = Kinematics(machine_file.from_dict(file))
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


def strays(what, kin, joints, vectors):
    """How far moves stray from the segments or arcs between vectors that follow each other."""
    return lambda moves: stray(what, kin, joints[moves], joints[moves + 1], (vectors[moves], vectors[moves + 1]))


@pytest.mark.parametrize(("turn", "off"), SIZES)
def test_the_largest_is_that_of_all_moves(kin, turn, off, of):
    for seed in range(of(2, 5)):
        joints, tips, axes, reached = paths(kin, seed, turn, off)
        expected = of_all(kin, joints, tips, axes)
        most = bounds(kin.machine, joints, tips, axes, reached)
        most[np.random.default_rng(seed).random(most.shape) < 0.1] = -1
        for what, path in ((TIP, tips), (AXIS, axes)):
            wanted = np.where(most[what.index] < 0, 0, expected[what.index])
            for known in (most[what.index], np.where(most[what.index] < 0, -1, np.inf)):
                error, move = largest(strays(what, kin, joints, path), known.copy(), what.resolution)
                certain = min(wanted.max() + what.resolution, max(known.max(), 0))
                assert error == pytest.approx(certain, rel=1e-9)
                assert move == wanted.argmax()


def test_few_moves_are_looked_at(dmu50v, monkeypatch):
    joints, tips, axes, reached = paths(dmu50v, 1, 0.01, 1e-3)
    most, looked = bounds(dmu50v.machine, joints, tips, axes, reached), []
    monkeypatch.setattr(
        module,
        "sampled",
        lambda kin, start, *rest, **more: looked.append(len(start)) or sampled(kin, start, *rest, **more),
    )
    largest(strays(TIP, dmu50v, joints, tips), most[0], TIP.resolution)
    assert len(joints) == 400 and len(looked) == 2 and sum(looked) < 100


def test_no_moves_counted(dmu50v):
    joints, tips, *_ = paths(dmu50v, 1, 0.01, 1e-3)
    assert largest(strays(TIP, dmu50v, joints, tips), np.full(len(joints) - 1, -1.0)) == (0, 0)
    assert largest(strays(TIP, dmu50v, joints[:1], tips[:1]), np.empty(0)) == (0, -1)


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
