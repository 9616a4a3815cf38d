"""Euler sequences, axis and angle, quaternions: SciPy agrees, also where they degenerate; worked numbers."""

import numpy as np
import pytest
import sympy as sp
from scipy.spatial.transform import Rotation

from mathpost import euler
from mathpost.errors import InputError
from mathpost.rotation import ACTIVE

ALL = [*euler.SEQUENCES, *(sequence.lower() for sequence in euler.SEQUENCES)]
BETA = np.degrees(np.arccos(1 / np.sqrt(3)))


@pytest.fixture(scope="module")
def triples():
    """20,000 angle triples, with all multiples of 45 degrees and middle angles that almost lock."""
    rng = np.random.default_rng(8)
    values = rng.uniform(-np.pi, np.pi, (20_000, 3))
    eighths = np.arange(-4, 5) * np.pi / 4
    exact = np.stack(np.meshgrid(eighths, eighths, eighths), axis=-1).reshape(-1, 3)
    values[: len(exact)] = exact
    near = rng.choice(eighths, 2000) + rng.choice([-1, 1], 2000) * 10 ** rng.uniform(-16, -4, 2000)
    values[len(exact) : len(exact) + 2000, 1] = near
    return values


@pytest.mark.parametrize("sequence", ALL)
def test_matrix_and_angles_against_scipy(sequence, triples):
    matrices = euler.matrix(sequence, triples)
    np.testing.assert_allclose(matrices, Rotation.from_euler(sequence, triples).as_matrix(), atol=2e-15)
    low, high = (0, np.pi) if sequence[0] == sequence[2] else (-np.pi / 2, np.pi / 2)
    locked = euler.is_locked(sequence, matrices)
    assert 160 < locked.sum() < 5000
    for lock, zero in (("first", 0), ("third", 2)):
        angles = euler.angles(sequence, matrices, lock=lock)
        np.testing.assert_allclose(Rotation.from_euler(sequence, angles).as_matrix(), matrices, atol=2e-13)
        assert (angles[locked][:, zero] == 0).all()
        assert ((low <= angles[:, 1]) & (angles[:, 1] <= high)).all()


def test_beside_the_lock_the_matrix_comes_back_to_rounding():
    """First and third angle are each uncertain by 1e-16/sine there, but not their sum."""
    middle = np.array([1e-12, 1e-9, 1e-6])
    matrices = euler.matrix("ZXZ", np.stack([np.full(3, 0.3), middle, np.full(3, 1.1)], axis=-1))
    angles = euler.angles("ZXZ", matrices)
    np.testing.assert_allclose(euler.matrix("ZXZ", angles), matrices, atol=4e-16)


@pytest.mark.parametrize("sequence", ALL)
def test_twin_is_the_same_rotation(sequence, triples):
    other = euler.twin(sequence, triples[:5000])
    np.testing.assert_allclose(euler.matrix(sequence, other), euler.matrix(sequence, triples[:5000]), atol=2e-15)
    assert (np.abs(other) <= np.pi + 1e-11).all()
    np.testing.assert_allclose(np.cos(other[:, 0] - triples[:5000, 0]), -1)


def test_symbolic_zxz_frame_of_the_working_plane():
    i, j, k = sp.symbols("I J K", real=True)
    frame = euler.matrix("ZXZ", (i, j, k))
    s, c = sp.sin, sp.cos
    x = [c(i) * c(k) - s(i) * c(j) * s(k), s(i) * c(k) + c(i) * c(j) * s(k), s(j) * s(k)]
    y = [-c(i) * s(k) - s(i) * c(j) * c(k), -s(i) * s(k) + c(i) * c(j) * c(k), s(j) * c(k)]
    z = [s(i) * s(j), -c(i) * s(j), c(j)]
    assert sp.simplify(frame - sp.Matrix([x, y, z]).T) == sp.zeros(3)


def test_identity_behind_the_source_angles():
    """Rz(c)·Ry(b) = Rz(c + 90)·Rx(b)·Rz(−90): γ = −90 is the constant third angle of a B-C machine."""
    b, c = sp.symbols("b c", real=True)
    left = ACTIVE["Z"](c) * ACTIVE["Y"](b)
    right = euler.matrix("ZXZ", (c + sp.pi / 2, b, -sp.pi / 2))
    assert sp.simplify(left - right) == sp.zeros(3)


@pytest.mark.parametrize(
    ("sequence", "given", "lock", "expected"),
    [
        ("ZXZ", (20, 0, 35), "third", (55, 0, 0)),
        ("ZXZ", (20, 0, 35), "first", (0, 0, 55)),
        ("ZXZ", (20, 180, 35), "third", (-15, 180, 0)),
        ("ZXZ", (20, 180, 35), "first", (0, 180, 15)),
        ("xyz", (40, 90, 25), "third", (15, 90, 0)),
        ("xyz", (40, -90, 25), "third", (65, -90, 0)),
        ("xyz", (10, 90, 40), "first", (0, 90, 30)),
        ("xyz", (190, 0, -200), "first", (-170, 0, 160)),
        ("xyz", (-180, 20, 30), "third", (180, 20, 30)),  # not −180
        ("ZXZ", (135, BETA, -90), "third", (135, BETA, -90)),
    ],
)
def test_worked_numbers(sequence, given, lock, expected):
    found = euler.angles(sequence, euler.matrix(sequence, given, degrees=True), lock=lock, degrees=True)
    np.testing.assert_allclose(found, expected, atol=1e-12)


def test_twin_of_the_source():
    np.testing.assert_allclose(euler.twin("ZXZ", [135, BETA, -90], degrees=True), [-45, -BETA, 90], atol=1e-12)


@pytest.mark.parametrize("sequence", euler.SEQUENCES)
def test_angles_from_a_direction(sequence):
    rng = np.random.default_rng(2)
    directions = np.vstack([rng.normal(size=(500, 3)), np.eye(3), -np.eye(3)])
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    third = rng.uniform(-180, 180, len(directions))
    angles = euler.from_direction(sequence, 7 * directions, third, degrees=True)
    last = np.eye(3)["XYZ".index(sequence[2])]
    np.testing.assert_allclose(euler.matrix(sequence, angles, degrees=True) @ last, directions, atol=4e-16)
    np.testing.assert_array_equal(angles[:, 2], third)


def test_direction_along_the_first_axis():
    found = euler.from_direction("ZXZ", [[0, 0, 1], [0, 0, -1]], 30, degrees=True)
    np.testing.assert_allclose(found, [[0, 0, 30], [0, 180, 30]], atol=1e-14)


def test_frame_from_the_tool_axis():
    """Fanuc's G68.3 with the vertical along Z: X is Z crossed with the tool axis, which is ZXZ with K = 0."""
    frame = euler.matrix("ZXZ", euler.from_direction("ZXZ", [1, 1, 1]))
    np.testing.assert_allclose(frame[:, 0], [-np.sqrt(0.5), np.sqrt(0.5), 0], atol=1e-15)
    np.testing.assert_allclose(frame[:, 2], np.full(3, 1 / np.sqrt(3)), atol=1e-15)


# Axis and angle, and quaternions


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
    found = euler.from_axis_angle(3 * vectors[turned] / angle[turned, None], angle[turned])
    np.testing.assert_allclose(found, rotations[turned].as_matrix(), atol=2e-15)
    np.testing.assert_allclose(
        euler.from_quaternion(-2 * rotations.as_quat(scalar_first=True)), rotations.as_matrix(), atol=2e-15
    )


def test_axis_and_angle_give_the_matrix_back(rotations):
    axis, angle = euler.to_axis_angle(rotations.as_matrix())
    assert ((angle >= 0) & (angle <= np.pi)).all()
    np.testing.assert_allclose(np.linalg.norm(axis, axis=1), 1, atol=1e-15)
    np.testing.assert_allclose(euler.from_axis_angle(axis, angle), rotations.as_matrix(), atol=4e-15)


def test_quaternion_agrees_with_scipy(rotations):
    found = euler.to_quaternion(rotations.as_matrix())
    known = rotations.as_quat(scalar_first=True)
    known *= np.sign((found * known).sum(axis=1, keepdims=True))  # q and −q are one rotation
    np.testing.assert_allclose(found, known, atol=4e-16)
    first = np.take_along_axis(found, (found != 0).argmax(axis=1)[:, None], axis=1)
    assert (first > 0).all()


def test_rules_where_the_axis_is_not_unique():
    axis, angle = euler.to_axis_angle([np.eye(3), np.diag([-1, 1, -1]), np.diag([1, -1, -1])], degrees=True)
    np.testing.assert_array_equal(angle, [0, 180, 180])
    np.testing.assert_array_equal(axis, [[0, 0, 1], [0, 1, 0], [1, 0, 0]])


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: euler.matrix("ZZX", [1, 2, 3]), "sequence: expected one of ZXZ"),
        (lambda: euler.matrix("Zxz", [1, 2, 3]), "sequence"),
        (lambda: euler.matrix(None, [1, 2, 3]), "sequence"),
        (lambda: euler.matrix("ZXZ", [1, 2]), r"angles: expected shape \(..., 3\)"),
        (lambda: euler.matrix("ZXZ", [1, 2, np.nan]), "angles: expected finite"),
        (lambda: euler.angles("ZXZ", np.eye(3), lock="second"), "lock: expected 'first' or 'third'"),
        (lambda: euler.angles("ZXZ", np.diag([1, 1, 2])), "matrix: expected orthonormal"),
        (lambda: euler.angles("ZXZ", -np.eye(3)), "left-handed"),
        (lambda: euler.from_direction("zxz", [0, 0, 1]), "sequence"),
        (lambda: euler.from_direction("ZXZ", [0, 0, 0]), "direction: expected a vector with a direction"),
        (lambda: euler.from_quaternion([0, 0, 0, 0]), "quaternion: expected a vector with a direction"),
        (lambda: euler.from_quaternion([1, 0, 0]), r"quaternion: expected shape \(..., 4\)"),
        (lambda: euler.from_axis_angle([0, 0, 0], 1), "axis: expected a vector with a direction"),
        (lambda: euler.from_axis_angle([0, 0, 1], np.inf), "angle: expected finite numbers"),
        (lambda: euler.to_axis_angle(2 * np.eye(3)), "rotation: expected orthonormal axes"),
    ],
)
def test_bad_input(call, message):
    with pytest.raises(InputError, match=message):
        call()
