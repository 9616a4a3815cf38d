"""Other tools on the same CL data: contact against a sampled cutter, length errors against the chain."""

import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mathpost.errors import InputError
from mathpost.kinematics import Kinematics
from mathpost.path import cl
from mathpost.shop.measure import cutter as tool
from mathpost.shop.measure.cutter import Cutter

DATA = Path(__file__).parent.parent.parent / "data"
CUTTERS = {"ball": Cutter.ball(12), "bull": Cutter(12, 2), "flat": Cutter.flat(12)}
cutters = pytest.mark.parametrize("cutter", CUTTERS.values(), ids=CUTTERS)


def surface(cutter, axis):
    """Points all over the lower side of a cutter whose tip is the origin: rings along the bottom and up the rim."""
    axis = axis / np.linalg.norm(axis)
    across = np.linalg.svd(axis[None])[2][1:]
    turn, rise = np.linspace(0, 2 * np.pi, 721), np.linspace(0, np.pi / 2, 361)
    flat = cutter.diameter / 2 - cutter.rim
    radius = np.concatenate([np.linspace(0, flat, 3), flat + cutter.rim * np.sin(rise)])
    height = np.concatenate([np.zeros(3), cutter.rim * (1 - np.cos(rise))])
    ring = np.cos(turn)[:, None] * across[0] + np.sin(turn)[:, None] * across[1]
    return radius[:, None, None] * ring + height[:, None, None] * axis


@cutters
@pytest.mark.parametrize("seed", range(6))
def test_the_cutter_lies_on_the_tangent_plane_and_touches_at_the_contact(cutter, seed):
    rng = np.random.default_rng(seed)
    axis, normal = rng.normal(size=(2, 3))
    normal = normal * np.sign(normal @ axis)
    unit = normal / np.linalg.norm(normal)
    offset = tool.tip_from_contact(cutter, normal, axis)
    heights = (offset + surface(cutter, axis)) @ unit
    assert -1e-9 <= heights.min() <= 2e-3
    # The contact point itself is on the cutter.
    closest = np.linalg.norm(offset + surface(cutter, axis), axis=-1).min()
    assert closest < 0.08


@cutters
def test_bottom_and_side(cutter):
    np.testing.assert_allclose(tool.tip_from_contact(cutter, [0, 0, 1], [0, 0, 1]), 0, atol=1e-12)
    side = tool.tip_from_contact(cutter, [[1, 0, 0], [0, -2, 0]], [0, 0, 3])
    np.testing.assert_allclose(side, [[6, 0, -cutter.rim], [0, -6, -cutter.rim]], atol=1e-12)


unit = st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda v: np.linalg.norm(v) > 0.1)


@settings(deadline=None, max_examples=60)
@given(unit, unit, st.sampled_from(sorted(CUTTERS)), st.sampled_from(sorted(CUTTERS)))
def test_compensation_keeps_the_contact_and_leaves_no_stock(normal, axis, old, new):
    old, new = CUTTERS[old], Cutter(CUTTERS[new].diameter * 0.9, CUTTERS[new].rim * 0.9)
    normal, axis = np.array(normal), np.array(axis)
    normal = normal if normal @ axis >= 0 else -normal
    tip = tool.compensated([1, 2, 3], normal, axis, old, new)
    contact_old = np.array([1, 2, 3]) - tool.tip_from_contact(old, normal, axis)
    np.testing.assert_allclose(tip - tool.tip_from_contact(new, normal, axis), contact_old, atol=1e-9)
    stock = tool.stock_left(normal, axis, old, new)
    shift = (np.array([1, 2, 3]) - tip) @ normal / np.linalg.norm(normal)
    assert stock == pytest.approx(shift, abs=1e-9)
    np.testing.assert_allclose(tool.compensated(tip, normal, axis, new, old), [1, 2, 3], atol=1e-9)


def test_a_smaller_ball_leaves_stock_that_grows_with_the_slope():
    slope = np.deg2rad([0, 30, 60, 90])
    normal = np.column_stack([np.sin(slope), 0 * slope, np.cos(slope)])
    stock = tool.stock_left(normal, [0, 0, 1], Cutter.ball(10), Cutter.ball(9.8))
    np.testing.assert_allclose(stock, 0.1 * (1 - np.cos(slope)), atol=1e-12)
    longer = tool.stock_left(normal, [0, 0, 1], Cutter.ball(10), Cutter.ball(10), longer=0.05)
    np.testing.assert_allclose(longer, -0.05 * np.cos(slope), atol=1e-12)


def test_a_longer_tool_against_the_chain(kin):
    """The chain with a longer tool and unchanged joints: what X Y Z name decides what the control was told."""
    rng = np.random.default_rng(2)
    joints = rng.uniform(-1, 1, (10, 5)) * [100, 100, 100, 1.5, 3]
    longer = Kinematics(kin.machine.with_setup(tool_length=kin.machine.tool_length + 0.7))
    moved = longer.forward(joints)[0] - kin.forward(joints)[0]
    told = "length offset" if kin.machine.programmed_point == "tip" else "nothing"
    np.testing.assert_allclose(tool.tip_shift(kin, joints, 0.7, told), moved, atol=1e-9)
    degrees = np.hstack([joints[:, :3], np.rad2deg(joints[:, 3:])])
    np.testing.assert_allclose(tool.tip_shift(kin, degrees, 0.7, told, degrees=True), moved, atol=1e-9)
    np.testing.assert_array_equal(tool.tip_shift(kin, joints, 0.7, "tcp"), np.zeros((10, 3)))
    if kin.machine.arrangement == "table-table":
        np.testing.assert_allclose(tool.tip_shift(kin, joints, 0.7, "length offset"), 0, atol=1e-12)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: Cutter(10, 6), "rim radius from 0 to half"),
        (lambda: Cutter(0, 0), "diameter above 0"),
        (lambda: tool.tip_from_contact(Cutter.ball(10), [[0, 0, 1], [0, 0, -1]], [0, 0, 1]), r"at index (1,)"),
        (lambda: tool.tip_from_contact(Cutter.ball(10), [0, 0, 0], [0, 0, 1]), "normal: expected a vector with"),
        (
            lambda: tool.compensated([0, 0], [0, 0, 1], [0, 0, 1], Cutter.ball(1), Cutter.ball(2)),
            "tip: expected shape",
        ),
    ],
)
def test_bad_input(call, message):
    with pytest.raises(InputError) as error:
        call()
    assert message in str(error.value)


def test_what_the_control_was_told_is_one_of_three(dmu50v):
    with pytest.raises(InputError, match='told: expected "tcp", "length offset" or "nothing"'):
        tool.tip_shift(dmu50v, [0, 0, 0, 0, 0], 1, "RTCP")


@pytest.mark.parametrize(
    ("statement", "message"),
    [
        ("GOTO/0,0,0,0,0,1,0,0,2", "line 2, GOTO: expected a unit contact normal out of the part"),
        ("GOTO/0,0,0,0,0,1,0,0,-1", "line 2, GOTO: expected a unit contact normal out of the part"),
        ("GOTO/0,0,0,0,0,1,0,0", "line 2, GOTO: expected 3, 6 or 9 numbers, found 8"),
    ],
)
def test_faulty_contact_normals(statement, message):
    with pytest.raises(InputError, match=re.escape(message)):
        cl.parse(f"GOTO/0,0,0,0,0,1,0,0,1\n{statement}\n")


def test_normals_stay_with_their_records():
    text = "GOTO/0,0,0,0,0,1\nGOTO/1,0,0,0,0,1,0.6,0,0.8\nGOTO/2,0,0\nGOTO/3,0,0,0,0,1,0,0,1\n"
    path = cl.parse(text)
    np.testing.assert_array_equal(np.isnan(path.normals[:, 0]), [True, False, True, False])
    np.testing.assert_array_equal(path.part(1, 3).normals[0], [0.6, 0, 0.8])
    again = cl.parse(cl.to_text(path))
    np.testing.assert_array_equal(again.normals, path.normals)
    assert cl.parse("GOTO/0,0,0").normals is None


def test_the_shipped_contacts_lie_on_their_dome():
    path = cl.read(DATA / "cl/dome.cl")
    contact = path.points - tool.tip_from_contact(Cutter.ball(10), path.normals, path.axes)
    np.testing.assert_allclose(contact[:, 2], -(contact[:, 0] ** 2) / 40, atol=2e-6)
