"""The error between blocks against closed forms and dense sampling, and subdivision that meets it."""

import numpy as np
import pytest

from mathpost.deviation import RESOLUTION, _intervals, deviation, levers
from mathpost.errors import ReachError
from mathpost.linearization import linearize, subdivide


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
    (tip, axis), (dense_tip, dense_axis) = deviation(kin, start, end), deviation(kin, start, end, samples=1024)
    np.testing.assert_allclose(tip, dense_tip, rtol=0, atol=RESOLUTION)
    np.testing.assert_allclose(axis, dense_axis, rtol=0, atol=RESOLUTION / 100)


def test_the_number_of_samples_follows_the_turn_and_the_levers(kin):
    start, end = np.zeros((3, 5)), np.array([[500.0, 0, 0, 0, 0], [0.1, 0, 0, 1e-3, 0], [0, 0, 0, 1, 1]])
    straight, small, large = _intervals(kin.machine, start, end, 2)
    assert straight == 2 and small <= 4 and large >= 64
    # Eight times the third derivative takes twice the intervals.
    far = np.array([7 * (levers(kin.machine) + 1), 0, 0, 0, 0])
    assert _intervals(kin.machine, start[2:] + far, end[2:] + far, 2) == 2 * large


def test_linearized_path_keeps_the_tolerance_in_dense_sampling(kin):
    rng = np.random.default_rng(2)
    joints = np.cumsum(rng.normal(size=(30, 5)) * [5, 5, 5, 0.1, 0.1], axis=0)
    found = linearize(kin, joints, 0.01)
    assert deviation(kin, found.joints[:-1], found.joints[1:], samples=160)[0].max() <= 0.01 * 1.01
    np.testing.assert_array_equal(found.joints[found.place % 1 == 0], joints)
    tip, corners = kin.forward(found.joints)[0], kin.forward(joints)[0]
    expected = np.stack([np.interp(found.place, np.arange(30), column) for column in corners.T], axis=1)
    np.testing.assert_allclose(tip, expected, atol=1e-9)
    assert len(linearize(kin, joints, 1e9).joints) == 30


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
