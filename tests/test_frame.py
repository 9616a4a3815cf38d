"""Frames, the frames of every machine, and source 003's transform with its lost signs."""

from itertools import product

import numpy as np
import pytest
import sympy as sp
from scipy.spatial.transform import RigidTransform, Rotation

from mathpost import euler, machine_file
from mathpost.chain import machine_frames
from mathpost.errors import InputError
from mathpost.frame import Frame
from mathpost.sources.csy_transform import CsyTransform
from tests.machines import content


@pytest.fixture
def rng():
    return np.random.default_rng(3)


def random_frame(rng, shape=(), parent="", child=""):
    rotation = Rotation.random(int(np.prod(shape)), rng).as_matrix().reshape(*shape, 3, 3)
    return Frame(rotation, rng.uniform(-100, 100, (*shape, 3)), parent, child)


def test_frames_agree_with_scipy(rng):
    first, second = random_frame(rng), random_frame(rng)
    known = [RigidTransform.from_matrix(frame.matrix) for frame in (first, second)]
    points = rng.normal(size=(4, 5, 3))
    flat = points.reshape(-1, 3)
    np.testing.assert_allclose((first @ second).matrix, (known[0] * known[1]).as_matrix(), atol=1e-13)
    np.testing.assert_allclose(first.inverse().matrix, known[0].inv().as_matrix(), atol=1e-13)
    np.testing.assert_allclose(first.point(points).reshape(-1, 3), known[0].apply(flat), atol=1e-13)
    np.testing.assert_allclose(first.direction(points).reshape(-1, 3), flat @ first.rotation.T, atol=1e-13)


def test_frames_broadcast(rng):
    many, one = random_frame(rng, (6,)), random_frame(rng)
    points = rng.normal(size=(2, 6, 3))
    composed = one @ many
    assert composed.matrix.shape == (6, 4, 4)
    np.testing.assert_allclose(composed.point(points), one.point(many.point(points)), atol=1e-12)
    np.testing.assert_allclose(many.inverse().point(many.point(points)), points, atol=1e-12)
    np.testing.assert_allclose(Frame.from_matrix(many.matrix).matrix, many.matrix)


def test_names_travel_and_refuse_a_gap(rng):
    machine_from_workpiece = random_frame(rng, parent="MCS", child="WCS")
    workpiece_from_feature = random_frame(rng, parent="WCS", child="feature")
    whole = machine_from_workpiece @ workpiece_from_feature
    assert (whole.parent, whole.child) == ("MCS", "feature")
    assert (whole.inverse().parent, whole.inverse().child) == ("feature", "MCS")
    with pytest.raises(InputError, match="expected a frame in feature on the right, found WCS from feature @ MCS"):
        workpiece_from_feature @ machine_from_workpiece


def test_reference_direction_need_not_be_perpendicular(rng):
    z, reference = rng.normal(size=(2, 1000, 3))
    reference[:100] = z[:100] + 1e-7 * reference[:100]
    frames = Frame.from_axes(z, reference)
    np.testing.assert_allclose(frames.z, z / np.linalg.norm(z, axis=1, keepdims=True), atol=1e-15)
    products = np.swapaxes(frames.rotation, -1, -2) @ frames.rotation
    np.testing.assert_allclose(products, np.broadcast_to(np.eye(3), products.shape), atol=1e-15)
    assert (np.einsum("ni,ni->n", frames.x, reference) > 0).all()
    np.testing.assert_allclose(np.einsum("ni,ni->n", frames.y, reference), 0, atol=1e-14)


def test_way_of_a_point_on_every_machine(kin, rng):
    joints = np.concatenate([rng.uniform(-100, 100, (50, 3)), rng.uniform(-np.pi, np.pi, (50, 2))], axis=1)
    workpiece, tool = machine_frames(kin.machine, joints)
    assert (workpiece.parent, workpiece.child, tool.parent, tool.child) == ("MCS", "WCS", "MCS", "TCS")
    workpiece_from_tool = workpiece.inverse() @ tool
    tip, axis = kin.forward(joints)
    np.testing.assert_allclose(workpiece_from_tool.origin, tip, atol=1e-11)
    np.testing.assert_allclose(workpiece_from_tool.z, axis, atol=1e-14)


@pytest.mark.parametrize("tool", [(0, 0, 1), (0, 0, -1), (3, 0, 4), (0, -5, -12), (1, 2, 2)])
def test_the_tool_frame_is_turned_the_shortest_way_from_machine_z(tool):
    _, found = machine_frames(machine_file.from_dict(content((0, 1, 0), (1, 1, -1), tool=tool)), np.zeros(5))
    direction = np.array(tool) / np.linalg.norm(tool)
    np.testing.assert_allclose(found.z, direction, atol=1e-15)
    turned = Rotation.from_matrix(found.rotation)
    assert turned.magnitude() == pytest.approx(np.arccos(direction[2]))
    np.testing.assert_allclose(turned.as_rotvec()[2], 0, atol=1e-12)


# Source 003


def printed_entries(signs, theta, psi, phi):
    """Source 003's nine entries; `signs` are the nine leading signs, of which the text does not keep a minus.

    Between the two terms of an entry it keeps a plus, and a doubled blank where a minus stood.
    """
    (c1, c2, c3), (s1, s2, s3) = np.cos([theta, psi, phi]), np.sin([theta, psi, phi])
    entries = [
        (c2 * c3, -c1 * s2 * s3), (s2 * c3, c1 * c2 * s3), (s1 * s3, 0),
        (c2 * s3, -c1 * s2 * c3), (s2 * s3, c1 * c2 * c3), (s1 * c3, 0),
        (s1 * s2, 0), (s1 * c2, 0), (c1, 0),
    ]  # fmt: skip
    return np.array([sign * first + second for sign, (first, second) in zip(signs, entries, strict=True)])


def test_lost_signs_leave_two_matrices_that_start_at_the_identity():
    """Being a rotation is not enough to find them: the prose must say about which axis theta turns which way."""
    proper = []
    for signs in product((1, -1), repeat=9):
        matrices = [printed_entries(signs, *angles).reshape(3, 3) for angles in [(0.3, 1.1, 2.0), (2.2, -0.7, 0.4)]]
        if all(np.allclose(m @ m.T, np.eye(3)) and np.linalg.det(m) > 0 for m in matrices):
            proper.append(signs)
    assert len(proper) == 4
    at_zero = [signs for signs in proper if np.allclose(printed_entries(signs, 0, 0, 0).reshape(3, 3), np.eye(3))]
    assert len(at_zero) == 2
    restored = CsyTransform(theta=30, psi=40, phi=50).matrix.ravel()
    both = [printed_entries(signs, *np.deg2rad([sign * 30, 40, 50])) for signs in at_zero for sign in (1, -1)]
    matching = [np.allclose(entries, restored) for entries in both]
    assert matching.count(True) == 2 and matching[:2] != matching[2:]  # they differ by theta → −theta


def test_restored_matrix_follows_from_the_prose():
    """Turn the machine about its Z, new X, newest Z: its axes then are the part's, whose rows M holds."""
    theta, psi, phi = 35, 50, -20
    axes = np.eye(3)
    for row, angle in zip((2, 0, 2), np.deg2rad([psi, theta, phi]), strict=True):
        axes = Rotation.from_rotvec(angle * axes[row]).apply(axes)
    np.testing.assert_allclose(CsyTransform(0, 0, 0, theta, psi, phi).matrix, axes, atol=1e-15)


def test_symbolic_entries_of_source_003():
    t, p, f = sp.symbols("Theta Psi Phi", real=True)
    (c1, c2, c3), (s1, s2, s3) = ([g(a) for a in (t, p, f)] for g in (sp.cos, sp.sin))
    expected = sp.Matrix([
        [c2 * c3 - c1 * s2 * s3, s2 * c3 + c1 * c2 * s3, s1 * s3],
        [-c2 * s3 - c1 * s2 * c3, -s2 * s3 + c1 * c2 * c3, s1 * c3],
        [s1 * s2, -s1 * c2, c1],
    ])  # fmt: skip
    assert sp.simplify(euler.matrix("ZXZ", (p, t, f)).T - expected) == sp.zeros(3)


def test_worked_numbers_of_source_003():
    transform = CsyTransform(100, 200, 300, 35, 50, -20)
    expected = [
        [0.818643, 0.539759, -0.196175],
        [-0.369817, 0.756789, 0.538986],
        [0.439385, -0.368688, 0.819152],
    ]
    np.testing.assert_allclose(transform.matrix, expected, atol=6e-7)
    np.testing.assert_allclose(transform.forward_point([1, 2, 3]), [101.309636, 202.760718, 302.159466], atol=6e-7)
    np.testing.assert_allclose(transform.to_axes()[0], [-0.196175, 0.538986, 0.819152], atol=6e-7)
    back = CsyTransform.from_matrix(transform.matrix, transform.origin)
    np.testing.assert_allclose(back.parameters, transform.parameters, atol=1e-12)
    np.testing.assert_allclose(CsyTransform.from_matrix(expected).parameters[3:], (35, 50, -20), atol=1e-4)


@pytest.mark.parametrize(("theta", "psi"), [(0, 30), (180, 70)])
def test_theta_at_the_lock(theta, psi):
    locked = CsyTransform(theta=theta, psi=50, phi=-20)
    back = CsyTransform.from_matrix(locked.matrix)
    np.testing.assert_allclose(back.parameters[3:], (theta, psi, 0), atol=1e-12)
    np.testing.assert_allclose(back.matrix, locked.matrix, atol=1e-15)


def test_transform_round_trips(rng):
    for _ in range(200):
        transform = CsyTransform(*rng.uniform(-500, 500, 3), *rng.uniform(-400, 400, 3))
        points = rng.normal(size=(3, 4, 3))
        for other in (
            transform.twin(),
            CsyTransform.from_matrix(transform.matrix, transform.origin),
            CsyTransform.from_axes(*transform.to_axes()),
            CsyTransform().update(*transform.parameters),
        ):
            np.testing.assert_allclose(other.matrix, transform.matrix, atol=1e-14)
            np.testing.assert_array_equal(other.origin, transform.origin)
        np.testing.assert_allclose(transform.inverse_point(transform.forward_point(points)), points, atol=1e-12)
        shift = transform.forward_point(points) - transform.forward_point([0, 0, 0])
        np.testing.assert_allclose(transform.forward_direction(points), shift, atol=1e-12)
        np.testing.assert_allclose(transform.inverse_direction(shift), points, atol=1e-12)
        assert 0 <= CsyTransform.from_matrix(transform.matrix).theta <= 180


def test_update_works_in_place():
    transform = CsyTransform()
    np.testing.assert_array_equal(transform.forward_point([1, 2, 3]), [1, 2, 3])
    transform.update(1, 0, 0, 0, 90, 0)
    np.testing.assert_allclose(transform.forward_point([1, 0, 0]), [1, -1, 0], atol=1e-15)


def test_twin_of_source_003():
    assert CsyTransform(1, 2, 3, 35, 50, -20).twin().parameters == (1, 2, 3, -35, -130, 160)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: Frame(np.eye(3) * 1.001), r"off the identity by 0.002"),
        (lambda: Frame(np.diag([1, 1, -1])), "left-handed"),
        (lambda: Frame(np.eye(3), [0, 0]), r"origin: expected shape \(..., 3\)"),
        (lambda: Frame.from_axes([0, 0, 0], [1, 0, 0]), "z: expected a vector with a direction"),
        (lambda: Frame.from_axes([0, 0, 1], [0, 0, 0]), "x: expected a vector with a direction"),
        (lambda: Frame.from_axes([0, 0, 1], [0, 0, -2]), "x: expected a direction that is not parallel to z"),
        (lambda: Frame.from_matrix(np.eye(4) * 2), "last row 0 0 0 1"),
        (lambda: CsyTransform(theta=np.nan), "x0, y0, z0, theta, psi, phi: expected finite"),
        (lambda: CsyTransform(theta="steep"), "theta"),
        (lambda: CsyTransform.from_matrix(np.eye(4)), r"matrix: expected shape \(3, 3\)"),
        (lambda: CsyTransform.from_matrix(np.diag([1, 1, 0.9])), "off the identity by 0.19"),
        (lambda: CsyTransform().forward_point([1, 2]), r"point: expected shape"),
    ],
)
def test_bad_input(call, message):
    with pytest.raises(InputError, match=message):
        call()
