"""Paths divided until they keep a tolerance, against dense sampling."""

import numpy as np
import pytest

from mathpost.errors import ReachError
from mathpost.post.between_blocks import deviation
from mathpost.post.motion import linearize, subdivide
from tests.post.test_between_blocks import moves


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
