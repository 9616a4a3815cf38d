"""Axis and angle, and quaternions, against SciPy and at their degenerate ends."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mathpost import axis_angle
from mathpost.errors import InputError


@pytest.fixture(scope="module")
def rotations():
    """100,000 random rotations, with none, half turns and tiny turns among them."""
    rng = np.random.default_rng(4)
    vectors = rng.normal(size=(100_000, 3))
    vectors *= rng.uniform(0, np.pi, (100_000, 1)) / np.linalg.norm(vectors, axis=1, keepdims=True)
    vectors[:10] = 0
    vectors[10:1000] *= np.pi / np.linalg.norm(vectors[10:1000], axis=1, keepdims=True)
    vectors[1000:2000] *= 1e-9
    vectors[2000:2006] = np.pi * np.vstack([np.eye(3), -np.eye(3)])
    return Rotation.from_rotvec(vectors)


def test_matrix_agrees_with_scipy(rotations):
    vectors = rotations.as_rotvec()
    angle = np.linalg.norm(vectors, axis=1)
    turned = angle > 0
    found = axis_angle.from_axis_angle(3 * vectors[turned] / angle[turned, None], angle[turned])
    np.testing.assert_allclose(found, rotations[turned].as_matrix(), atol=2e-15)
    np.testing.assert_allclose(
        axis_angle.from_quaternion(-2 * rotations.as_quat(scalar_first=True)), rotations.as_matrix(), atol=2e-15
    )


def test_axis_and_angle_give_the_matrix_back(rotations):
    axis, angle = axis_angle.to_axis_angle(rotations.as_matrix())
    assert ((angle >= 0) & (angle <= np.pi)).all()
    np.testing.assert_allclose(np.linalg.norm(axis, axis=1), 1, atol=1e-15)
    np.testing.assert_allclose(axis_angle.from_axis_angle(axis, angle), rotations.as_matrix(), atol=4e-15)


def test_quaternion_agrees_with_scipy(rotations):
    found = axis_angle.to_quaternion(rotations.as_matrix())
    known = rotations.as_quat(scalar_first=True)
    known *= np.sign((found * known).sum(axis=1, keepdims=True))  # q and −q are one rotation
    np.testing.assert_allclose(found, known, atol=4e-16)
    first = np.take_along_axis(found, (found != 0).argmax(axis=1)[:, None], axis=1)
    assert (first > 0).all()


def test_rules_where_the_axis_is_not_unique():
    axis, angle = axis_angle.to_axis_angle([np.eye(3), np.diag([-1, 1, -1]), np.diag([1, -1, -1])], degrees=True)
    np.testing.assert_array_equal(angle, [0, 180, 180])
    np.testing.assert_array_equal(axis, [[0, 0, 1], [0, 1, 0], [1, 0, 0]])


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: axis_angle.from_quaternion([0, 0, 0, 0]), "quaternion: expected a vector with a direction"),
        (lambda: axis_angle.from_quaternion([1, 0, 0]), r"quaternion: expected shape \(..., 4\)"),
        (lambda: axis_angle.from_axis_angle([0, 0, 0], 1), "axis: expected a vector with a direction"),
        (lambda: axis_angle.from_axis_angle([0, 0, 1], np.inf), "angle: expected finite numbers"),
        (lambda: axis_angle.to_axis_angle(2 * np.eye(3)), "rotation: expected orthonormal axes"),
    ],
)
def test_bad_input(call, message):
    with pytest.raises(InputError, match=message):
        call()
