"""All positions for a tool axis, against the candidates of a path, SciPy's rotations, and the shell's numbers."""

import json

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mathpost.errors import ReachError
from mathpost.interface.shell.main import main
from mathpost.kinematics import Kinematics
from mathpost.machine_file import load
from mathpost.path import selection
from mathpost.shop.plane import pose

TIP = np.array([12.5, -30, 7.25])


def reachable(kin, count, seed):
    """Tool axes that the machine makes at random rotary angles."""
    joints = np.random.default_rng(seed).uniform(-2, 2, (count, len(kin.symbols)))
    return kin.forward(joints)[1]


def test_the_positions_inside_travel_are_the_candidates_of_a_path(kin):
    for axis in reachable(kin, 12, seed=1):
        found = pose.positions(kin, TIP, axis)
        inside = [each.joints for each in found if not each.reasons]
        candidates = selection.candidates(kin, [TIP], [axis])
        expected = candidates.joints[0][candidates.inside[0]] * [1, 1, 1, 180 / np.pi, 180 / np.pi]
        assert len(inside) == len(expected)
        for row in expected:
            assert min(np.abs(row - joints).max() for joints in inside) < 1e-8
        for each in found:
            np.testing.assert_allclose(each.tip, TIP, atol=1e-9)
            np.testing.assert_allclose(each.axis, axis, atol=1e-12)


def test_a_pose_against_scipy():
    """The B table carries the C table; both turn the other way, and X Y Z name the tip."""
    joints = [10, -20, 30, 40, 75]
    found = pose.at(Kinematics(load("bc_table")), joints)
    back = Rotation.from_euler("ZY", [75, 40], degrees=True)
    np.testing.assert_allclose(found.axis, back.apply([0, 0, 1]), atol=1e-15)
    tilting, turning, origin = np.array([20, 0, -80]), np.array([20, 0, 0]), np.array([20, 0, 40])
    turned = tilting + Rotation.from_euler("Y", 40, degrees=True).apply(origin + joints[:3] - tilting)
    turned = turning + Rotation.from_euler("Z", 75, degrees=True).apply(turned - turning)
    np.testing.assert_allclose(found.tip, turned - origin, atol=1e-12)
    assert found.from_pole == pytest.approx(40) and not found.reasons


def test_the_nearest_comes_first_and_the_controls_go_there():
    kin = Kinematics(load("ac_head"))
    found = pose.positions(kin, TIP, [0.6, 0, 0.8], [300, 0])
    assert [each.joints[3] for each in found] == pytest.approx([270, 90, -90, -270])
    taken = pose.taken(kin, [0.6, 0, 0.8], [300, 0])
    assert taken["Heidenhain PLANE"].angles == pytest.approx([270, -36.86989765])
    assert taken["Siemens _DIR +1"].angles == pytest.approx([90, 36.86989765])


def test_at_the_pole_the_workpiece_side_axis_stands_where_it_is():
    found = pose.positions(Kinematics(load("bc_table")), TIP, [0, 0, 1], [10, 33])
    assert len(found) == 1 and found[0].joints[3:] == pytest.approx([0, 33])
    np.testing.assert_allclose(found[0].tip, TIP, atol=1e-12)


@pytest.mark.parametrize("name", ["nutating_head_table", "dmu50v"])
def test_out_of_reach_is_measured_from_the_pole(name):
    with pytest.raises(ReachError, match=r"180\.0000 degrees from the pole \(0\.000 0\.000 1\.000\)"):
        pose.positions(Kinematics(load(name)), TIP, [0, 0, -1])


def test_the_shell_prints_the_numbers_of_the_functions(capsys):
    asked = ["pose", "bc_table", "--axis", "-.6", "0", ".8", "--tip", *map(str, TIP), "--from", "-20", "100"]
    assert main([*asked, "--json"]) == 0
    printed = json.loads(capsys.readouterr().out)
    kin = Kinematics(load("bc_table"))
    found = pose.positions(kin, TIP, [-0.6, 0, 0.8], [-20, 100])
    assert [list(each["joints"].values()) for each in printed["positions"]] == [
        each.joints.tolist() for each in found
    ]
    assert [each["tip"] for each in printed["positions"]] == [each.tip.tolist() for each in found]
    assert printed["controls"]["Fanuc G53.1"]["angles"]["B"] == pytest.approx(36.86989765)
    assert main(asked) == 0
    table = capsys.readouterr().out
    assert f"{found[0].joints[0]:.4f}" in table and "36.8699" in table and "outside -35 … 110" in table


def test_joints_in_the_shell(capsys):
    assert main("pose bc_table --joints 0 0 0 -45 180".split()) == 1
    said = capsys.readouterr().out
    assert "i 0.707107 j 0 k 0.707107, 45.0000° from the pole" in said and "B -45.000° is outside -35 … 110" in said


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        ("bc_table", "--axis or --joints"),
        ("bc_table --axis 0 0 1 --joints 0 0 0 0 0", "--axis or --joints"),
        ("bc_table --joints 0 0 0 0", "5 numbers, X Y Z B C"),
        ("bc_table --axis 0 0 1 --from 1", "2 numbers, B C"),
        ("bc_table --axis 0 0 0", "direction"),
        ("dmu50v --axis 0 0 -1", "from the pole"),
    ],
)
def test_the_shell_refuses(arguments, text, capsys):
    assert main(["pose", *arguments.split()]) == 2
    assert text in capsys.readouterr().err
