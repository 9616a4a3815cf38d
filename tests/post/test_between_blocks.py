"""Paths divided to keep a tolerance, and the lag of the tool axis, against dense sampling."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.spatial.transform import Rotation, Slerp

from mathpost import machine_file
from mathpost.errors import ReachError
from mathpost.kinematics import Kinematics
from mathpost.path import cl, singular
from mathpost.path.between_blocks import axis_lag, follow, linearize, subdivide
from mathpost.path.deviation import AXIS_RESOLUTION, deviation
from mathpost.path.motion import Motion
from tests.machines import content


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
    kin = Kinematics(machine_file.from_dict(file))
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
    start, end = np.random.default_rng(3).uniform(-1, 1, (2, 3, 5)) * [100, 100, 100, 1, 1]
    joints, place = subdivide(kin, start, end, [1, 2, 4])
    np.testing.assert_array_equal(place, [1, 1.5, 2, 2.25, 2.5, 2.75, 3])
    np.testing.assert_array_equal(joints[[0, 2, 6]], end)
    np.testing.assert_allclose(joints[1, 3:], (start + end)[1, 3:] / 2)


def test_too_fine_a_tolerance_names_the_block(dmu50v):
    joints = dmu50v.close([77.0, 0, 0], [[0, 0], [0, 0.1], [0, 3]])
    with pytest.raises(ReachError, match=r"from row 2 to 3.*16 pieces"):
        linearize(dmu50v, joints, 0.01, max_pieces=16, name="row")
