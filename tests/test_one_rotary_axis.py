"""A machine with one rotary axis: the chain against SciPy's rotations, what is out of reach, and what uses it."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import mathpost
from mathpost import load_machine, machine_file
from mathpost.detective.rotary_axes import explain_joints
from mathpost.errors import InputError, ReachError
from mathpost.interface.shell.main import main
from mathpost.kinematics import Kinematics
from mathpost.path import cl, selection
from mathpost.shop.compensate.compensation import Compensator
from mathpost.shop.compensate.model import fingerprint, read_errors
from mathpost.shop.plane import pose
from mathpost.teaching.course import machine_page
from tests.machines import content

HEAD = Kinematics(load_machine("dividing_head"))
PART = """UNITS/MM
SPINDL/1000,RPM,CLW
FEDRAT/300,MMPM
RAPID
GOTO/0,0,60,0,0,1
GOTO/0,0,25,0,0,1
GOTO/5,-4.34120,24.62019,0,-0.173648,0.984808
GOTO/10,-8.55050,23.49232,0,-0.342020,0.939693
GOTO/40,-25,0,0,-1,0
"""


def one(axis, side="workpiece", tool=(0, 0, 1), **more):
    """A machine with one rotary axis."""
    data = content(axis, axis, (side, side), tool=tool, **more)
    data["rotary"] = data["rotary"][:1]
    return Kinematics(machine_file.from_dict(data))


@settings(max_examples=15, deadline=None)
@given(
    axis=st.tuples(*[st.integers(-5, 5)] * 3).filter(any),
    side=st.sampled_from(["workpiece", "tool"]),
    tool=st.sampled_from([(0, 0, 1), (1, 0, 0), (1, -2, 2)]),
    seed=st.integers(0, 9),
)
def test_there_and_back(axis, side, tool, seed):
    """Forward against SciPy, and the inverse of what it makes; beside the cone of tool axes there is nothing."""
    point, origin = np.array([11.0, -7, 3]), np.array([5.0, 6, 7])
    kin = one(axis, side, tool, point=(point.tolist(), (0, 0, 0)), origin=origin.tolist(), length=50)
    rng = np.random.default_rng(seed)
    joints = np.c_[rng.uniform(-200, 200, (30, 3)), rng.uniform(-np.pi, np.pi, 30)]
    tip, direction = kin.forward(joints)
    unit_axis, unit_tool = (np.array(v) / np.linalg.norm(v) for v in (axis, tool))
    turn = Rotation.from_rotvec(joints[:, 3:] * unit_axis)
    if side == "workpiece":
        turned = point + turn.inv().apply(joints[:, :3] + origin - point)
        np.testing.assert_allclose(tip, turned - origin, atol=1e-9)
        np.testing.assert_allclose(direction, turn.inv().apply(unit_tool), atol=1e-12)
    else:
        nose = joints[:, :3] + 50 * unit_tool  # machine coordinates less the origin
        swung = point + turn.apply(-50 * unit_tool - point)
        np.testing.assert_allclose(tip, nose + swung, atol=1e-9)
        np.testing.assert_allclose(direction, turn.apply(unit_tool), atol=1e-12)
    back = kin.inverse(tip, direction)
    assert back.shape == (30, 2, 4) and np.isnan(back[:, 1]).all()
    if np.linalg.norm(np.cross(unit_axis, unit_tool)) > 1e-9:
        apart = np.abs(np.angle(np.exp(1j * (back[:, 0] - joints)[:, 3])))
        np.testing.assert_allclose(apart, 0, atol=1e-9)
        np.testing.assert_allclose(back[:, 0, :3], joints[:, :3], atol=1e-6)
    else:  # any angle points the tool there: it stands at 0
        assert (back[:, 0, 3] == 0).all()
    tips, _ = kin.forward(back[:, 0])
    np.testing.assert_allclose(tips, tip, atol=1e-9)
    aside = direction + 0.01 * unit_axis
    if np.linalg.norm(np.cross(unit_axis, unit_tool)) > 1e-9:
        assert np.isnan(kin.inverse(tip, aside)).all()


def test_printed_tool_axes_are_reached_and_others_are_not():
    assert not np.isnan(HEAD.inverse([1, 2, 3], [0, 0.342020, 0.939693])[0]).any()
    assert not np.isnan(HEAD.inverse([1, 2, 3], [1e-6, 0.342020, 0.939693])[0]).any()
    assert np.isnan(HEAD.inverse([1, 2, 3], [1e-5, 0.342020, 0.939693])).all()


def test_the_machine_says_what_it_is():
    assert HEAD.machine.arrangement == "table" and HEAD.machine.joint_names == ("X", "Y", "Z", "A")
    assert one((1, 0, 0), "tool").machine.arrangement == "head"
    assert HEAD.machine.limits.shape == (4, 2) and HEAD.machine.endless.tolist() == [False] * 3 + [True]
    assert HEAD.reach == pytest.approx((np.pi / 2, np.pi / 2))


def test_positions_and_controls(capsys):
    found = pose.positions(HEAD, np.array([10, 0, 25]), np.array([0, -0.6, 0.8]), [300])
    assert len(found) == 1 and found[0].joints == pytest.approx([10, 15, 20, 36.86989765])
    assert {each.angles[0].round(6) for each in pose.taken(HEAD, [0, -0.6, 0.8], [300]).values()} == {36.869898}
    with pytest.raises(ReachError, match=r"95\.7106 degrees from the pole .*, which A allows only at 90\.0000"):
        pose.positions(HEAD, np.zeros(3), np.array([0.1, 0, 1]))
    assert main("plane PLANE SPATIAL SPA+30 SPB+0 SPC+0 --machine dividing_head".split()) == 0
    assert "A 30" in capsys.readouterr().out


def test_a_program_and_what_is_refused():
    result = mathpost.postprocess(cl.parse(PART), HEAD.machine)
    words = [line for line in result.program.splitlines() if "A+10.0000" in line]
    assert words and "A+90.0000" in result.program
    np.testing.assert_allclose(result.joints[:, 3], np.radians([0, 0, 10, 20, 90]), atol=2e-6)
    with pytest.raises(ReachError, match="tool axis out of reach"):
        mathpost.postprocess(
            cl.parse(PART.replace("0,-0.342020,0.939693", "0.01,-0.342020,0.939693")), HEAD.machine
        )
    with pytest.raises(InputError, match="two rotary axes"):
        selection.choose(HEAD, cl.parse(PART), "paper")


def test_a_limit_of_the_one_axis_winds_it():
    """From 0 to 360 a head at −10 goes to 350."""
    data = content((-1, 0, 0), (0, 0, 1))
    data["rotary"] = [data["rotary"][0] | {"limits": [0, 360]}]
    kin = Kinematics(machine_file.from_dict(data))
    chosen = selection.choose(
        kin, cl.parse(PART.replace("0,-0.173648", "0,0.173648").split("GOTO/10")[0]), split=True
    )
    assert np.degrees(chosen.joints[-1, 3]) == pytest.approx(350, abs=1e-4)


def test_a_spreadsheet_of_its_words_is_refused(capsys):
    assert main("check data/workbooks/right.xlsx --machine dividing_head".split()) == 2
    assert "two rotary axes" in capsys.readouterr().err


def test_the_page_and_the_detective():
    html = machine_page.page(HEAD)
    assert "is always at 90.0° to the axis of A" in html and "X+ moves the table to the left" in html
    assert explain_joints(HEAD, [0, -0.6, 0.8], [36.8699]).right
    found = explain_joints(HEAD, [0, -0.6, 0.8], [-36.8699])
    assert found.misreadings[0].sentence == "the sign of A is reversed" and len(found.misreadings) == 1
    found = explain_joints(HEAD, [0, -0.6, 0.8], [1.451571])
    assert found.misreadings[0].kinds == ("inch",)


def test_errors_are_compensated(tmp_path, capsys):
    """The tip by SciPy's rotations; what one axis cannot turn the tool by is left, and said."""
    path, rng = tmp_path / "errors.toml", np.random.default_rng(4)
    said = f'name = "e"\nsource = "test"\nmachine = "{fingerprint(HEAD.machine)}"\n[constant]\n'
    path.write_text(said + "EYA = 12\nEZA = -20\nEAA = 100\nEBA = 30\nEC0Y = 40\n", encoding="utf-8")
    errors = read_errors(path, HEAD.machine)
    (a,), origin = HEAD.machine.rotary, np.array(HEAD.machine.origin)
    turned = Rotation.from_euler("xy", [100e-6, 30e-6])

    def reached(joints):
        slides = joints[:, :3] + origin + [0, 0, HEAD.machine.tool_length]
        tip = slides - slides[:, [1]] * [40e-6, 0, 0] - [0, 0, HEAD.machine.tool_length]
        turn = Rotation.from_rotvec(joints[:, 3:] * a.axis)
        back = turned.inv().apply(tip - a.point - [0, 12e-3, -20e-3])
        return a.point + turn.inv().apply(back) - origin, turn.inv().apply(turned.inv().apply([0, 0, 1.0]))

    joints = np.c_[rng.uniform(-80, 80, (30, 3)), rng.uniform(-np.pi, np.pi, 30)]
    found = Compensator(errors).compensate(joints)
    tip, axis = HEAD.forward(joints)
    before, _ = reached(joints)
    after, along = reached(found.joints)
    assert np.linalg.norm(before - tip, axis=1).min() > 0.01 and np.abs(after - tip).max() < 1e-4
    beside = np.linalg.norm(along - axis, axis=1)
    assert beside == pytest.approx(found.after.axis, abs=1e-9)
    assert beside == pytest.approx(30e-6, rel=1e-3)

    (tmp_path / "part.cl").write_text(PART, encoding="utf-8")
    given = ["post", str(tmp_path / "part.cl"), "--machine", "dividing_head", "--errors", str(path)]
    assert main([*given, "-o", str(tmp_path / "part.nc")]) == 0
    assert "6.2 arcsec after it" in capsys.readouterr().err
