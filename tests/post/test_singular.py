"""The singularity measure, the regions, and every way through them."""

import re
from dataclasses import replace

import numpy as np
import pytest
import sympy as sp

from mathpost import load_machine, machine_file
from mathpost.errors import InputError
from mathpost.kinematics import Kinematics
from mathpost.path import cl as cldata
from mathpost.path import region, selection, singular
from mathpost.path.deviation import AXIS_TOLERANCE
from mathpost.path.motion import Motion
from mathpost.shop.post.ways import Crossing
from tests.conftest import DATA
from tests.machines import content, random_joints


def test_measure_is_the_area_that_the_tool_axis_sweeps(kin):
    """|n·(a₁ × a₂)| against √(det JᵀJ) with J from finite differences of the forward kinematics."""
    joints = random_joints(kin, 200, seed=1)[60:]
    step = 1e-6
    columns = []
    for joint in (3, 4):
        move = np.zeros(5)
        move[joint] = step
        columns.append((kin.forward(joints + move)[1] - kin.forward(joints - move)[1]) / (2 * step))
    jacobian = np.stack(columns, axis=-1)
    area = np.sqrt(np.linalg.det(np.swapaxes(jacobian, -1, -2) @ jacobian))
    np.testing.assert_allclose(singular.closeness(kin, kin.forward(joints)[1]), area, atol=1e-8)
    tool_side = kin.inverse_symbolic.tool_side
    measure = sp.lambdify(tool_side, singular.measure(kin))(joints[:, kin.symbols.index(tool_side)])
    np.testing.assert_allclose(np.abs(measure), area, atol=1e-8)


def test_closed_forms():
    tilted = Kinematics(load_machine(DATA / "machines/dmu50v.toml"))
    trunnion = Kinematics(load_machine(DATA / "machines/ac_table.toml"))
    assert sp.simplify(singular.measure(tilted) ** 2 - sp.sin(tilted.inverse_symbolic.tool_side) ** 2 / 4) == 0
    assert sp.simplify(singular.measure(trunnion) ** 2 - sp.sin(trunnion.inverse_symbolic.tool_side) ** 2) == 0
    axis = tilted.forward([0, 0, 0, 2.335, 0], degrees=True)[1]
    assert np.degrees(singular.distance(tilted, axis)) == pytest.approx(1.651, abs=0.0005)
    assert singular.amplification(tilted, axis) == pytest.approx(34.711, abs=0.001)
    assert singular.amplification(trunnion, axis) == pytest.approx(34.708, abs=0.001)
    axis = trunnion.forward([0, 0, 0, 2.335, 0], degrees=True)[1]
    assert singular.amplification(trunnion, axis) == pytest.approx(24.5, abs=0.05)


def test_amplification_is_what_the_workpiece_side_axis_does(kin):
    """The largest |∂workpiece_side/∂n| over all directions of a small turn, by the inverse kinematics."""
    axis = kin.forward(random_joints(kin, 60, seed=2)[40:])[1]
    workpiece_side = kin.symbols.index(kin.inverse_symbolic.workpiece_side)
    side = np.cross(axis, [0.36, 0.48, 0.8])
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    step, largest = 1e-6, 0
    for direction in np.linspace(0, np.pi, 181):
        turn = np.cos(direction) * side + np.sin(direction) * np.cross(axis, side)
        before, after = (
            kin.inverse([0, 0, 0], axis + sign * step * turn)[:, 0, workpiece_side] for sign in (-1, 1)
        )
        largest = np.maximum(largest, np.abs((after - before + np.pi) % (2 * np.pi) - np.pi) / (2 * step))
    np.testing.assert_allclose(singular.amplification(kin, axis), largest, rtol=2e-3)


def test_machine_whose_pole_is_out_of_reach():
    """With the tool tilted against the table, the ends of reach are singular instead of the pole."""
    kin = Kinematics(machine_file.from_dict(content((1, 0, 0), (0, 0, 1), tool=(1, 0, 3))))
    assert kin.reach[0] == pytest.approx(np.arctan2(1, 3))
    edge = np.array([np.sin(kin.reach[0]), 0, np.cos(kin.reach[0])])
    assert singular.distance(kin, edge) == pytest.approx(0, abs=1e-15)


def pass_by(kin, offset, *, count=21, feed=np.nan):
    """A straight pass of the tool axis by the pole, `offset` radians from it, tip moving 1 mm per record."""
    pole = np.array(kin.inverse_symbolic.pole, float)
    side = np.cross(pole, [0.6, 0.0, 0.8] if abs(pole[2]) < 0.9 else [0.0, 1.0, 0.0])
    side /= np.linalg.norm(side)
    along = np.linspace(-0.2, 0.2, count)[:, None]
    axes = pole + along * side + offset * np.cross(pole, side)
    points = np.array([60.0, 20.0, 30.0]) + np.arange(count)[:, None] * [1.0, 0, 0]
    return cldata.from_arrays(points, axes, feed=feed)


def test_regions_by_cone_and_by_rate(dmu50v):
    cl = pass_by(dmu50v, 0.01, feed=600)
    joints = selection.choose(dmu50v, cl).joints
    by_cone = singular.regions(dmu50v, cl, joints, cone=0.03)
    assert by_cone == [(8, 12)]
    (first, last), *more = singular.regions(dmu50v, cl, joints)
    assert not more and first <= 9 and last >= 11
    slow = pass_by(dmu50v, 0.01, feed=1)
    assert singular.regions(dmu50v, slow, joints) == []
    assert singular.regions(dmu50v, cl, joints, cone=0.001) == []
    with pytest.raises(InputError, match="cone"):
        singular.regions(dmu50v, pass_by(dmu50v, 0.01), joints)


def test_regions_by_rate_whatever_way_the_axis_turns(dmu50v):
    cl = pass_by(dmu50v, 0.01, feed=600)
    back = cldata.from_arrays(cl.points[::-1], cl.axes[::-1], feed=600)
    ((first, last),) = singular.regions(dmu50v, cl, selection.choose(dmu50v, cl).joints)
    found = singular.regions(dmu50v, back, selection.choose(dmu50v, back).joints)
    assert found == [(len(cl) - 1 - last, len(cl) - 1 - first)]


@pytest.mark.parametrize("axis", [3, 4])
def test_a_move_at_the_very_rate_of_an_axis_is_no_region(dmu50v, axis):
    rotary = [replace(each, max_rate=rate) for each, rate in zip(dmu50v.machine.rotary, (0.5, 0.7), strict=True)]
    kin = Kinematics(replace(dmu50v.machine, rotary=tuple(rotary)))
    cl = cldata.from_arrays([[0, 0, 0], [1, 0, 0]], [[0, 0, 1]] * 2, feed=600)  # 0.1 s
    for more, found in ((0, []), (1e-9, [(0, 1)])):
        joints = np.zeros((2, 5))
        joints[1, axis] = 0.1 * kin.machine.max_rates[axis] + more
        assert singular.regions(kin, cl, joints) == found


def test_nearest_is_what_dense_sampling_finds(kin):
    """Great circles of any length, by either end of reach; and nearest to the workpiece-side axis."""
    start, end = kin.forward(random_joints(kin, 240, seed=3)[:200])[1].reshape(2, 100, 3)
    t = np.linspace(0, 1, 4001)[:, None, None]
    arc = np.arccos(np.vecdot(start, end))[:, None]
    axes = (np.sin((1 - t) * arc) * start + np.sin(t * arc) * end) / np.sin(arc)
    pole = np.array(kin.inverse_symbolic.pole, float)
    angle = np.arccos(np.clip(axes @ pole, -1, 1))
    for measured, dense in (
        (singular.distance, np.minimum(angle - kin.reach[0], kin.reach[1] - angle)),
        (singular.from_pole, np.minimum(angle, np.pi - angle)),
    ):
        at, away = singular.nearest(kin, start, end, measured)
        np.testing.assert_allclose(away, dense.min(axis=0), atol=1e-3)
        row = np.rint(at * 4000).astype(int), np.arange(100)
        np.testing.assert_allclose(dense[row], away, atol=2e-3)


def test_pole_between_two_records_is_found(dmu50v, blade):
    joints = selection.choose(dmu50v, blade).joints
    assert singular.regions(dmu50v, blade, joints, cone=np.radians(0.1)) == [(1, 2)]


@pytest.fixture(params=["dmu50v", "ac_table", "head_b_table_c", "nutating_head"])
def crossing(request):
    """A pass by the pole on a machine that could take either branch."""
    kin = Kinematics(load_machine(DATA / f"machines/{request.param}.toml"))
    cl = pass_by(kin, 0.004)
    joints = selection.choose(kin, cl, "shortest").joints
    (region,) = singular.regions(kin, cl, joints, cone=0.05)
    return Crossing(kin, cl, joints, region, tolerance=0.01)


@pytest.mark.parametrize("name", ["direct", "linear", "cubic", "aside", "retract", "other branch"])
def test_ways_through(crossing, name):
    way = crossing.way(name, lean=0.02, clearance=10)
    if name == "other branch" and way.reason:
        assert re.search("outside|lags", way.reason) and way.blocks == 0
        return
    assert way.reason == "" and way.blocks == len(way.joints) - 1 > 0
    kin, cl = crossing.kin, crossing.cl
    tip, _ = kin.forward(way.joints)
    tips, _ = cl.at(way.place)
    on_part = ~way.lifted
    np.testing.assert_allclose(tip[on_part], tips[on_part], atol=1e-9)
    assert way.place[0] == crossing.first and way.place[-1] == crossing.last
    np.testing.assert_allclose(way.joints[0], crossing.joints[crossing.first], atol=1e-9)
    if name != "other branch":
        np.testing.assert_allclose(way.joints[-1], crossing.joints[crossing.last], atol=1e-9)
    assert way.tip_error <= 0.01
    assert (way.axis_error <= AXIS_TOLERANCE) == (name in Crossing.FOLLOWING)
    if name == "aside":
        # The tool axis strays by the stated angle, plus what joint-linear moves add between the nodes.
        assert way.axis_error < 0.02 * 1.05
    if name == "retract":
        assert way.lifted.any() and np.linalg.norm(tip - tips, axis=1)[way.lifted].min() > 9.9
    if name == "cubic":  # smooth into and out of the region
        workpiece_side = crossing.kin.workpiece_side
        slope = np.diff(way.joints[:, workpiece_side]) / np.diff(way.place)
        before = np.diff(crossing.joints[:, workpiece_side])[crossing.first - 1]
        assert abs(slope[0] - before) < 0.2 * np.abs(slope).max()


def test_moving_aside_slows_the_workpiece_side_axis():
    kin = Kinematics(load_machine(DATA / "machines/ac_table.toml"))
    cl = pass_by(kin, 0.002, count=41)
    joints = selection.choose(kin, cl, prefer=1).joints
    crossing = Crossing(kin, cl, joints, singular.regions(kin, cl, joints, cone=0.15)[0])
    direct, aside = crossing.way("direct"), crossing.way("aside", lean=0.06)
    assert aside.reason == "" and aside.time < direct.time


def test_paper_ways_leave_the_part(dmu50v, blade):
    joints = selection.choose(dmu50v, blade).joints
    through = {way.name: way for way in Crossing(dmu50v, blade, joints, (1, 2)).compare()}
    assert through["paper cubic"].tip_error > 77 and through["paper clamped"].tip_error > 77
    assert "B -2.334° is outside 0 … 180" in through["other branch"].reason
    assert max(way.tip_error for name, way in through.items() if name in Crossing.SAFE and not way.reason) <= 0.01
    needed = {name: np.degrees(way.axis_error) for name, way in through.items() if not way.reason}
    assert needed["retract"] < 1e-4 and needed["direct"] < 0.1 and needed["aside"] == pytest.approx(1, abs=0.001)
    assert needed["linear"] == pytest.approx(2.548, abs=0.001) and needed["cubic"] == pytest.approx(
        1.384, abs=0.001
    )


def test_a_record_at_which_two_ways_meet_is_passed_once():
    joints = np.arange(30.0).reshape(6, 5)
    ways = [Motion.on_part(joints[at], np.array(at)) for at in ([3, 4], [1, 2, 3])]
    assert region.through_the_records(joints, ways).place.tolist() == [0, 1, 2, 3, 4, 5]


def test_a_region_at_the_end_has_no_slope(dmu50v, blade):
    joints = selection.choose(dmu50v, blade).joints
    assert "record before" in Crossing(dmu50v, blade, joints, (0, 2)).way("cubic").reason


def test_wrong_names_are_refused(dmu50v, blade):
    joints = selection.choose(dmu50v, blade).joints
    with pytest.raises(InputError, match="region"):
        Crossing(dmu50v, blade, joints, (2, 5))
    with pytest.raises(InputError, match="'over'"):
        Crossing(dmu50v, blade, joints, (1, 2)).way("over")


def test_the_cubic_lifted_turns_in_the_air_only(dmu50v, blade):
    """Equations (9) and (10): before anything turns 20 mm along the tool axis, back when all has turned."""
    joints = selection.choose(dmu50v, blade).joints
    way = Crossing(dmu50v, blade, joints, (1, 2)).way("cubic lifted", clearance=20)
    np.testing.assert_allclose(way.joints[[0, -1]], joints[1:3], atol=1e-9)
    np.testing.assert_allclose(way.joints[[1, -2], 3:], joints[1:3, 3:], atol=1e-9)
    tips, axes = dmu50v.forward(way.joints)
    np.testing.assert_allclose(tips[1] - blade.points[1], 20 * blade.axes[1], atol=1e-9)
    assert not way.in_cut.any() and way.axis_error == 0
    assert np.vecdot(tips[1:-1] - blade.points[1], axes[1:-1]).min() > 19.9
    inside = Crossing(dmu50v, blade, joints, (0, 2)).way("cubic lifted")
    assert inside.reason
    assert "left uncut" in Crossing(dmu50v, blade, joints, (1, 3)).way("cubic lifted").reason
