"""The chain with errors against bodies stacked by hand with SciPy, finite differences, and the ideal chain."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mathpost import load_machine
from mathpost.shop.compensate.model import ErrorModel, error_names
from tests.machines import with_slides


def random_errors(rng, model):
    lengths = np.array([name[1] in "XYZ" for name in model.names])
    return rng.normal(size=len(model.names)) * np.where(lengths, 0.02, 1e-4)


def random_joints(rng, model, count=8):
    return np.column_stack([rng.uniform(-150, 150, (count, 3)), rng.uniform(-2, 2, (count, 2))])


def stacked(model, joints, errors):
    """The pose by going from the bed outwards on both sides, one rigid body after the other."""
    given = model.machine
    e = dict(zip(model.names, errors, strict=True))
    q = dict(zip(given.joint_names, joints, strict=True))

    def displaced(point, name):
        moved = Rotation.from_euler("xyz", [e[f"E{c}{name}"] for c in "ABC"])  # extrinsic: Rz·Ry·Rx
        return moved, np.array([e[f"E{c}{name}"] for c in "XYZ"]) + point - moved.apply(point)

    def outwards(slides, rotary, sign, fixed):
        turned, place = Rotation.identity(), np.zeros(3)

        def attach(rotation, shift):
            nonlocal turned, place
            place = place + turned.apply(shift)
            turned = turned * rotation

        for name in slides:
            index = "XYZ".index(name)
            path = np.eye(3)[index]
            path = path + np.cross([e.get(f"E{c}0{name}", 0) for c in "ABC"], path)
            attach(Rotation.identity(), sign * (given.origin[index] + q[name] + added[index]) * path)
            attach(*displaced(np.zeros(3), name))
        attach(Rotation.identity(), -fixed)
        for joint in rotary:
            point = np.array(joint.point)
            attach(*displaced(point, joint.name))
            turn = Rotation.from_rotvec(q[joint.name] * np.array(joint.axis) / np.linalg.norm(joint.axis))
            attach(turn, point - turn.apply(point))
        return turned, place

    axis = np.array(given.tool_axis) / np.linalg.norm(given.tool_axis)
    tip = -given.tool_length * axis
    # G43: the control adds the tool to the slides; another point of the head it does not know.
    named = given.programmed_point
    added, fixed = -tip * (named == "tip"), np.zeros(3) if isinstance(named, str) else np.array(named)
    tables = [joint for joint in given.rotary if joint.carries == "workpiece"]
    heads = [joint for joint in given.rotary if joint.carries == "tool"]
    table, table_place = outwards(given.slides_that_carry("workpiece"), tables, -1, np.zeros(3))
    head, head_place = outwards(given.slides_that_carry("tool"), heads, +1, fixed)
    in_bed = head.apply(tip) + head_place
    in_workpiece = table.inv().apply(in_bed - table_place) - given.origin
    return in_workpiece, (table.inv() * head).apply(axis)


def test_without_errors_it_is_the_ideal_chain(kin, model):
    joints = random_joints(np.random.default_rng(1), model)
    for real, ideal in zip(model.forward(joints, np.zeros(33)), kin.forward(joints), strict=True):
        np.testing.assert_allclose(real, ideal, rtol=0, atol=1e-12)


def test_with_errors_it_is_the_stack_of_bodies(model):
    rng = np.random.default_rng(2)
    errors = 50 * random_errors(rng, model)  # so great that no first-order chain would pass
    for joints in random_joints(rng, model):
        for real, expected in zip(model.forward(joints, errors), stacked(model, joints, errors), strict=True):
            np.testing.assert_allclose(real, expected, rtol=0, atol=1e-11)


@pytest.mark.parametrize("sides", [("X", "YZ"), ("XY", "Z"), ("XYZ", ""), ("", "ZXY")])
def test_wherever_the_slides_stand(sides):
    model = ErrorModel(with_slides(load_machine("data/machines/ac_table.toml"), *sides))
    rng = np.random.default_rng(3)
    errors = 50 * random_errors(rng, model)
    joints = random_joints(rng, model, 1)[0]
    for real, expected in zip(model.forward(joints, errors), stacked(model, joints, errors), strict=True):
        np.testing.assert_allclose(real, expected, rtol=0, atol=1e-11)


def test_derivatives_are_the_finite_differences(model):
    joints, step = random_joints(np.random.default_rng(4), model, 1)[0], 1e-5

    def pose(joints, errors):
        return np.concatenate(model.forward(joints, errors))

    none = np.zeros(33)
    by_error = [(pose(joints, e) - pose(joints, -e)) / (2 * step) for e in step * np.eye(33)]
    by_joint = [(pose(joints + d, none) - pose(joints - d, none)) / (2 * step) for d in step * np.eye(5)]
    np.testing.assert_allclose(model.sensitivities(joints), np.transpose(by_error), rtol=0, atol=1e-7)
    np.testing.assert_allclose(model.jacobian(joints), np.transpose(by_joint), rtol=0, atol=1e-7)


def test_the_names_are_thirty_and_three(model):
    assert len(set(error_names(model.machine))) == 33
    assert sum(name.endswith(model.machine.joint_names[4]) for name in model.names) == 6
