"""Selection: against a plain recursion, the paper's rules by hand, limits, and paths that break."""

import itertools
from dataclasses import replace

import numpy as np
import pytest

from mathpost import load_machine, machine_file
from mathpost.errors import InputError, ReachError
from mathpost.formula import compiled
from mathpost.kinematics import Kinematics
from mathpost.machine import ENDLESS
from mathpost.path import cl as cldata
from mathpost.path import selection
from tests.conftest import DATA
from tests.machines import content


@pytest.fixture(scope="module", autouse=True)
def machine_code():
    """Short paths, too, go through the compiled loop: it is faster. A test below compares it with the plain one."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(selection, "LONG", 0)
        yield


def limited(name, *, workpiece_side=None, tool_side=None, rates=True):
    """A machine file with other travel (degrees), or without rates."""
    return restricted(Kinematics(load_machine(DATA / f"machines/{name}.toml")), workpiece_side, tool_side, rates)


def restricted(kin, workpiece_side=None, tool_side=None, rates=True):
    """A machine with other travel (degrees), or without rates; its slides do not end."""
    data = kin.machine
    at_workpiece_side = kin.symbols.index(kin.inverse_symbolic.workpiece_side) - 3
    rotary = list(data.rotary)
    for index, limits in ((at_workpiece_side, workpiece_side), (1 - at_workpiece_side, tool_side)):
        if limits is not None:
            rotary[index] = replace(rotary[index], limits=tuple(np.radians(limits)))
    linear = tuple(replace(axis, limits=ENDLESS) for axis in data.linear)
    if not rates:
        rotary = [replace(joint, max_rate=None) for joint in rotary]
        linear = tuple(replace(axis, max_rate=None) for axis in linear)
    return Kinematics(replace(data, rotary=tuple(rotary), linear=linear))


def test_the_branch_is_changed_in_cut_within_a_twentieth_of_a_degree_of_the_pole(dmu50v_both_ways):
    t = np.linspace(-0.3, 0.3, 20)  # the pole is passed between two records
    for degrees, branches in ((0.04, {0, 1}), (0.06, {0})):
        axes = np.stack([t, np.full(20, np.tan(np.radians(degrees))), np.ones(20)], axis=-1)
        cl = cldata.from_arrays(np.outer(t, [100, 0, 0]), axes)
        assert set(selection.choose(dmu50v_both_ways, cl).branch.tolist()) == branches


def test_chosen_joints_reach_the_poses_inside_travel(kin):
    rng = np.random.default_rng(8)
    joints = np.cumsum(rng.normal(size=(60, 5)) * [1, 1, 1, 0.03, 0.03], axis=0)
    joints[:, 3:] += kin.machine.limits[3:].clip(-1, 1).mean(axis=1)
    cl = cldata.from_arrays(*kin.forward(joints))
    for strategy in ("optimal", "shortest"):
        chosen = selection.choose(kin, cl, strategy, start=joints[0])
        tip, axis = kin.forward(chosen.joints)
        np.testing.assert_allclose(tip, cl.points, atol=1e-9)
        np.testing.assert_allclose(axis, cl.axes, atol=1e-12)
        low, high = kin.machine.limits.T
        assert (chosen.joints >= low - 1e-9).all() and (chosen.joints <= high + 1e-9).all()
        np.testing.assert_allclose(chosen.joints, joints, atol=1e-6)


def turning(turns, count=40):
    """A tool leaning by 30 degrees that goes round Z `turns` times at a fixed tip."""
    angle = np.linspace(0, 2 * np.pi * turns, count)
    axes = np.stack([np.cos(angle) / 2, np.sin(angle) / 2, np.full(count, np.sqrt(0.75))], axis=1)
    return cldata.from_arrays(np.tile([10.0, 0, 0], (count, 1)), axes)


def test_an_endless_axis_winds_up():
    chosen = selection.choose(limited("ac_table"), turning(3))
    assert np.degrees(np.ptp(chosen.joints[:, 4])) == pytest.approx(1080)
    assert np.degrees(np.abs(np.diff(chosen.joints[:, 4])).max()) < 30


def test_there_and_back_does_not_wind_up():
    """Half a turn keeps its direction: a tool that goes over the pole and back comes out where it began."""
    kin = limited("ac_table", tool_side=(0, 90))
    lean = np.radians([30, 10, -10, -30, -10, 10, 30, 10, -10])
    axes = np.stack([np.zeros(9), np.sin(lean), np.cos(lean)], axis=1)
    chosen = selection.choose(kin, replace(cldata.from_arrays(np.zeros((9, 3)), axes), rapid=np.ones(9, bool)))
    assert np.degrees(np.ptp(chosen.joints[:, 4])) == pytest.approx(180)


def test_a_limited_axis_breaks_with_the_record_and_is_split():
    kin = limited("ac_table", workpiece_side=(-360, 360))
    assert np.degrees(np.ptp(selection.choose(kin, turning(1.7)).joints[:, 4])) == pytest.approx(612)
    cl = turning(3, count=61)
    # It says how far the machine comes without a break: as on the path that ends there.
    so_far = np.degrees(selection.choose(kin, cl.part(0, 36)).joints[-1, 3:])
    with pytest.raises(ReachError, match="line 37, record 37: the path breaks here") as refused:
        selection.choose(kin, cl)
    assert f"(so far A {so_far[0]:.3f}° C {so_far[1]:.3f}°)" in str(refused.value)
    split = selection.choose(kin, cl, split=True)
    assert len(split.breaks) == 1 and split.breaks[0] <= 36
    assert np.degrees(np.abs(split.joints[:, 4]).max()) <= 360 + 1e-9
    # The break is the one move in cut by more than half a turn.
    over = np.degrees(np.abs(np.diff(split.joints[:, 4]))) > 180
    assert np.flatnonzero(over).tolist() == [split.breaks[0] - 1]


def test_how_far_the_machine_comes_counts_from_the_first_record():
    """From 170° it can only go on to 240°; from the record behind it −120° would be nearer to zero."""
    kin = limited("ac_table", workpiece_side=(-180, 250), tool_side=(0, 90))
    joints = np.radians([[0, 0, 0, 30, angle] for angle in (170, 200, 240, 280)])
    with pytest.raises(ReachError, match=r"record 4: the path breaks here, .*so far A 30.000° C 240.000°"):
        selection.choose(kin, cldata.from_arrays(*kin.forward(joints)))


def test_an_unreachable_record_counts_before_a_break():
    kin = limited("ac_table", workpiece_side=(-360, 360), tool_side=(-50, 50))
    cl = turning(3, count=61)
    axes = cl.axes.copy()
    axes[60] = [1, 0, 0]
    with pytest.raises(ReachError, match="line 61, record 61: no solution inside travel"):
        selection.choose(kin, replace(cl, axes=axes))


def test_out_of_travel_names_record_and_axis(dmu50v):
    cl = cldata.from_arrays([[0, 0, 0], [900, 0, 0]], [[0, 0, 1], [0.1, 0, 1]])
    with pytest.raises(ReachError, match=r"record 2: no solution inside travel: .*X .* mm is outside -250 … 250"):
        selection.choose(dmu50v, cl)
    with pytest.raises(ReachError, match="record 1: .*out of reach"):
        selection.choose(dmu50v, cldata.from_arrays([[0, 0, 0]], [[0, 0.6, -0.8]]))


def test_the_workpiece_side_axis_turns_while_the_tool_is_at_the_pole(kin):
    """Vertical records, then leaning ones: C is turned before the lean, not during it."""
    if kin.reach[0] > 0:
        pytest.skip("does not apply: the pole is out of reach")
    pole = np.array(kin.inverse_symbolic.pole, float)
    side = np.cross(pole, [0.6, 0.8, 0])
    lean = np.array([0, 0, 0, 0.1, 0.2, 0.3, 0.1, 0, 0])[:, None]
    cl = cldata.from_arrays(
        np.arange(9)[:, None] * [1.0, 0, 0] + [20, 30, 40], np.cos(lean) * pole + np.sin(lean) * side
    )
    chosen = selection.choose(kin, cl)
    workpiece_side = kin.symbols.index(kin.inverse_symbolic.workpiece_side)
    leaning = chosen.joints[2:8, workpiece_side]
    assert np.degrees(np.ptp(leaning)) < 10
    assert set(chosen.branch.tolist()) <= {0, 1}
    tip, axis = kin.forward(chosen.joints)
    np.testing.assert_allclose(tip, cl.points, atol=1e-9)
    np.testing.assert_allclose(axis, cl.axes, atol=1e-12)


def test_at_the_pole_the_workpiece_side_axis_may_take_the_angles_of_both_neighbours():
    """Those of the branches before and those of the branches after, besides 0; at the ends of a path of the one."""
    kin = limited("ac_table")
    lean, round_z = np.radians([0, 20, 0, 0, 30, 0]), np.radians([0, 40, 0, 0, -70, 0])
    axes = np.stack([np.sin(lean) * np.sin(round_z), np.sin(lean) * np.cos(round_z), np.cos(lean)], axis=1)
    found = selection.candidates(kin, np.arange(18.0).reshape(6, 3), axes)
    workpiece_side = np.degrees(found.joints[:, :, 4]).round(6)
    before, after = sorted(workpiece_side[1, :2]), sorted(workpiece_side[4, :2])
    assert abs(np.subtract(before, after)).min() > 1
    for record, neighbours in (
        (0, (before, before)),
        (2, (before, after)),
        (3, (before, after)),
        (5, (after, after)),
    ):
        assert workpiece_side[record, :2].tolist() == [0, 0]
        assert [sorted(workpiece_side[record, first : first + 2]) for first in (2, 4)] == list(neighbours)
        np.testing.assert_allclose(
            kin.forward(found.joints[record])[0], [np.arange(18.0).reshape(6, 3)[record]] * 6
        )
        np.testing.assert_allclose(kin.forward(found.joints[record])[1], [[0, 0, 1]] * 6, atol=1e-12)
    assert np.isnan(workpiece_side[[1, 4], 2:]).all()
    assert [branch for branch, *_ in found.table(1)] == [0, 1]
    assert [branch for branch, *_ in found.table(2)] == [0, 1, 0, 1, 0, 1]


@pytest.mark.parametrize("limits", [(-np.inf, 1.0), (-1.0, np.inf), (-np.inf, np.inf)])
def test_an_axis_without_one_of_its_ends_has_one_winding(limits):
    assert selection.windings(*limits).tolist() == [0]


def test_near_the_pole_is_not_at_it():
    kin, axes = limited("ac_table"), np.array([[0.1, 0, 1], [1.3e-10, 0, 1], [0.7e-10, 0, 1]])
    found = selection.candidates(kin, np.zeros((3, 3)), axes)
    assert (~np.isnan(found.joints[..., 4])).sum(axis=1).tolist() == [2, 2, 6]


def test_a_tool_that_never_leaves_the_pole():
    kin = limited("ac_table", workpiece_side=(-360, 360))
    points = np.random.default_rng(5).normal(size=(30, 3)) * 40
    chosen = selection.choose(kin, cldata.from_arrays(points, np.tile([0.0, 0, 1], (30, 1))))
    np.testing.assert_array_equal(chosen.joints[:, 3:], 0)


@pytest.mark.parametrize(("prefer", "branch"), [(1, 0), (-1, 1)])
@pytest.mark.parametrize("strategy", ["optimal", "shortest"])
@pytest.mark.parametrize("azimuth", [40, 140, -40, -140])
def test_the_first_record_begins_on_the_preferred_branch(strategy, prefer, branch, azimuth):
    """Wherever the workpiece-side axis stands: the preference counts more than the travel from zero."""
    kin = limited("ac_table", tool_side=(-90, 90))
    cl = cldata.from_arrays(*kin.forward(np.radians([[0, 0, 0, 30, azimuth], [0, 0, 0, 30.1, azimuth]])))
    chosen = selection.choose(kin, cl, strategy, prefer=prefer)
    assert chosen.branch.tolist() == [branch, branch]
    assert (np.sign(chosen.joints[:, 3]) == prefer).all()


@pytest.mark.parametrize(("travel_of_a", "sign"), [((-30, 90), 1), ((-90, 30), -1), ((-90, 90), 1)])
def test_by_default_the_longer_side_of_the_tilting_axis_is_preferred(travel_of_a, sign):
    kin = limited("ac_table", tool_side=travel_of_a)
    (tilt,) = selection.choose(kin, cldata.from_arrays([[0, 0, 0]], [[0.1, 0.2, 1]])).joints[:, 3]
    assert np.sign(tilt) == sign


@pytest.mark.parametrize(("below", "above", "side"), [(40, 50, 1), (50, 40, -1)])
def test_the_longer_side_is_counted_from_the_middle_of_the_two_solutions(below, above, side):
    """With a tool that leans at 0 the middle, where the tool stands on the pole, is not at 0."""
    kin = Kinematics(machine_file.from_dict(content((1, 0, 0), (0, 0, 1), tool=(0, -1, 2))))
    derived = kin.inverse_symbolic
    middle = np.degrees(float(sum(derived.solutions) / 2))
    assert abs(middle) > 20
    kin = restricted(kin, tool_side=(middle - below, middle + above))
    tilted = kin.forward(np.radians([[0, 0, 0, middle + 10, 0], [0, 0, 0, middle - 10, 0]]))
    chosen = selection.choose(kin, cldata.from_arrays(tilted[0][:1], tilted[1][:1]))
    assert np.sign(np.degrees(chosen.joints[0, 3]) - middle) == side


@pytest.mark.parametrize("name", ["ac_table", "ac_head"])
def test_without_a_start_it_is_the_first_record_that_is_near_zero_not_the_last(name):
    """From 170° to 190°, not from −190° to −170°; of one C is the second rotary axis, of the other the first."""
    kin = limited(name, workpiece_side=(-700, 700), tool_side=(0, 90))
    joints = np.zeros((2, 5))
    joints[:, kin.tool_side], joints[:, kin.workpiece_side] = np.radians(30), np.radians([170, 190])
    found = selection.choose(kin, cldata.from_arrays(*kin.forward(joints)))
    np.testing.assert_allclose(np.degrees(found.joints[:, kin.workpiece_side]), [170, 190])


@pytest.mark.parametrize(("start", "expected"), [(430, 460), (-250, -260), (90, 100)])
def test_a_start_leads_to_the_nearest_winding(start, expected):
    kin = limited("dmu50v", workpiece_side=(-700, 700), tool_side=(0, 100))
    cl = cldata.from_arrays(*kin.forward(np.radians([[0, 0, 0, 30, 100]])))
    chosen = selection.choose(kin, cl, start=np.radians([0, 0, 0, 30, start]))
    assert np.degrees(chosen.joints[0, 4]) == pytest.approx(expected)
    slides = np.abs(chosen.joints[0, :3]) / kin.machine.max_rates[:3]
    turn = np.radians(abs(expected - start)) / kin.machine.max_rates[4]
    assert chosen.cost == pytest.approx(max(*slides, turn))


def test_of_moves_that_take_the_same_time_the_shorter_one_is_taken():
    """In rapid traverse X takes 10 s; a whole turn of C beside it would cost no time."""
    kin = limited("ac_table", workpiece_side=(-180, 540), tool_side=(-90, 90))
    joints = np.radians([[0, 0, 0, 30, 10], [0, 0, 0, 30, 20]])
    joints[1, 0] = 10 * kin.machine.max_rates[0]
    cl = replace(cldata.from_arrays(*kin.forward(joints)), rapid=np.ones(2, bool))
    for turns in (0, 1):
        joints[:, 4] += turns * selection.TURN
        for strategy in ("optimal", "shortest"):
            chosen = selection.choose(kin, cl, strategy, start=joints[0])
            np.testing.assert_allclose(chosen.joints, joints, atol=1e-9)


@pytest.mark.parametrize(("turn", "breaks"), [(180, ()), (-180, ()), (180.001, (1,)), (-180.001, (1,))])
def test_half_a_turn_is_the_longest_move_in_cut(turn, breaks):
    kin = limited("ac_table", workpiece_side=(-181, 181), tool_side=(0, 90))
    joints = np.radians([[0, 0, 0, 30, -turn / 2], [0, 0, 0, 30, turn / 2]])
    cl = cldata.from_arrays(*kin.forward(joints))
    for strategy in ("optimal", "shortest"):
        chosen = selection.choose(kin, cl, strategy, sway=np.inf, split=True, start=joints[0])
        assert chosen.breaks == breaks
        assert selection.choose(kin, replace(cl, rapid=np.ones(2, bool)), strategy).breaks == ()


@pytest.mark.parametrize("beyond", [-0.9, 0.9, 1.1])
@pytest.mark.parametrize("end", [0, 1])
@pytest.mark.parametrize("joint", range(5))
def test_travel_has_a_tolerance(joint, end, beyond):
    """A joint beyond an end of its travel by less than the tolerance is inside, by more is not."""
    kin = limited("ac_table", workpiece_side=(-300, 300), tool_side=(-100, 100))
    data, joints = kin.machine, np.array([10.0, 20, 30, 0.4, 0.5])
    limits = [(-1000.0, 1000.0)] * 3 + [(-3.0, 3.0)] * 2
    limits[joint] = (joints[joint], 1000.0) if end == 0 else (-1000.0, joints[joint])
    axes = [replace(axis, limits=pair) for axis, pair in zip((*data.linear, *data.rotary), limits, strict=True)]
    joints[joint] += (1 if end else -1) * beyond * 1e-9
    small = replace(data, linear=tuple(axes[:3]), rotary=tuple(axes[3:]), limits_of="words")
    assert small.within(joints).all() == (beyond < 1)
    assert small.within(joints).tolist() == [beyond < 1 or at != joint for at in range(5)]
    assert len(small.out_of_travel(joints)) == (beyond > 1)


def nearest_to_singular(kin, start, end, reach=None):
    """How near the great circle of two tool axes comes to an end of reach, by the foot of the pole on it."""
    reach = reach or kin.reach
    pole, normal = np.array(kin.inverse_symbolic.pole, float), np.cross(start, end)
    feet = [start, end]
    if np.linalg.norm(normal) > 1e-12:
        normal /= np.linalg.norm(normal)
        foot = pole - (pole @ normal) * normal
        feet += [
            side * foot / np.linalg.norm(foot)
            for side in (1, -1)
            if np.cross(start, side * foot) @ normal > 0 < np.cross(side * foot, end) @ normal
        ]
    angles = [2 * np.arctan2(np.linalg.norm(axis - pole), np.linalg.norm(axis + pole)) for axis in feet]
    return min(min(angles) - reach[0], reach[1] - max(angles))


def test_the_branch_may_change_as_near_to_a_singular_axis_as_the_sway(kin):
    """Travel leaves one candidate for each record, on branches that differ: a break if the sway is less."""
    derived, rng, compared = kin.inverse_symbolic, np.random.default_rng(4), 0
    tool_side, workpiece_side = kin.symbols.index(derived.tool_side), kin.symbols.index(derived.workpiece_side)
    kin = restricted(kin, workpiece_side=np.degrees([-1.5, 1.5]), tool_side=(-180, 180))
    for _ in range(30):
        ends = np.zeros((2, 5))
        ends[:, tool_side] = float(sum(derived.solutions) / 2) + np.array([1, -1]) * rng.uniform(0.1, 1.2, 2)
        ends[:, workpiece_side] = np.array([-1, 1]) * rng.uniform(0.2, 1.4, 2)
        cl = cldata.from_arrays(*kin.forward(ends))
        if (near := nearest_to_singular(kin, *cl.axes)) < 0.01:
            continue
        for sway, breaks in ((near + 1e-6, ()), (near - 1e-6, (1,))):
            chosen = selection.choose(kin, cl, sway=sway, split=True)
            np.testing.assert_allclose(chosen.joints, ends, atol=1e-9)
            assert chosen.breaks == breaks
        compared += 1
    assert compared > 3


def test_candidates_say_why_they_are_out(dmu50v_both_ways, blade):
    found = selection.candidates(dmu50v_both_ways, blade.points, blade.axes)
    rows = found.table(4, previous=found.joints[3, 0])
    reasons = {(branch, round(joints[3])): reason for branch, joints, cost, reason in rows}
    assert reasons[0, 23] == reasons[1, -23] == ""
    assert reasons[1, 337] == "B 337.309° is outside -25 … 180"
    assert [reason == "" for *_, reason in rows] == found.inside[4].tolist()


def test_candidates_cost_the_seconds_of_the_slowest_axis_from_the_pose_before(dmu50v_both_ways, blade):
    found = selection.candidates(dmu50v_both_ways, blade.points, blade.axes)
    before = found.joints[3, 0] * [1, 1, 1, 57.29577951308232, 57.29577951308232]
    for _, joints, cost, _ in found.table(4, previous=found.joints[3, 0]):
        change = np.abs(joints - before)
        turn = min(change[4] % 360, -change[4] % 360)  # C has no limits and takes the short way
        rates = [500, 500, 500, 36, 36]  # of the machine file
        assert cost == pytest.approx(max([*change[:4], turn] / np.array(rates)), rel=1e-9)


class TestPaper:
    """Cases (1) to (3) and the C ± 2π rule of section 1.2, by hand."""

    @staticmethod
    def tilts(degrees):
        """Tool axes that ask the DMU 50V for these B, all with C = 0 on the first branch."""
        kin = limited("dmu50v")
        joints = np.array([[0, 0, 0, np.radians(b), 0] for b in degrees])
        return cldata.from_arrays(*kin.forward(joints))

    @pytest.mark.parametrize(
        ("travel", "tilts", "expected"),
        [
            ((-5, 110), [11, 4, 2, 9], [11, 4, 2, 9]),  # cases 2 3 3 2: positive stays nearest
            ((-110, 5), [11, 4, 2, 9], [-11, -4, -2, -9]),  # the negative side is the longer one
            ((-30, 30), [40 - 20, 10, 5], [20, 10, 5]),  # case 3 throughout
        ],
    )
    def test_cases(self, travel, tilts, expected):
        kin = limited("dmu50v", tool_side=travel)
        chosen = selection.choose(kin, self.tilts(tilts), "paper")
        np.testing.assert_allclose(np.degrees(chosen.joints[:, 3]), expected, atol=1e-9)

    def test_case_1(self):
        with pytest.raises(ReachError, match=r"record 2: B: case \(1\): \|θ\| = 41.000° is outside travel"):
            selection.choose(limited("dmu50v", tool_side=(-5, 40)), self.tilts([11, 41]), "paper")

    def test_case_2_with_the_wrong_preference_leaves_travel(self):
        with pytest.raises(ReachError, match="record 1: B -11.000"):
            selection.choose(limited("dmu50v", tool_side=(-5, 40)), self.tilts([11]), "paper", prefer=-1)

    @pytest.mark.parametrize(
        ("angles", "expected"),
        [
            ([150, 170, -170, -150], [150, 170, -170, -150]),  # equal steps: nothing happens
            ([150, 170, -175, -155], [150, -190, -175, -155]),  # the jump moves by one row
            ([150, 165, -175, -155], [150, 165, -175, -155]),
            ([-170, -170, 170, -175], [-170, -170, -190, -175]),  # the last row but one is corrected, too
        ],
    )
    def test_c_rule_taken_literally(self, angles, expected):
        kin = limited("ac_table")
        joints = np.array([[0, 0, 0, 0.5, np.radians(c)] for c in angles])
        chosen = selection.choose(kin, cldata.from_arrays(*kin.forward(joints)), "paper")
        np.testing.assert_allclose(np.degrees(chosen.joints[:, 4]), expected, atol=1e-6)
        assert (
            np.degrees(
                np.abs(np.diff(selection.choose(kin, cldata.from_arrays(*kin.forward(joints))).joints[:, 4]))
            ).max()
            < 25
        )


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"strategy": "best"}, "'best'"),
        ({"prefer": 0}, "prefer: expected 1 or -1, found 0"),
        ({"start": [1, 2]}, "start: expected shape"),
        ({"start": [0, 0, 0, 0, np.nan]}, "start: expected finite numbers"),
    ],
)
def test_wrong_arguments(dmu50v, blade, wrong, message):
    with pytest.raises(InputError, match=message):
        selection.choose(dmu50v, blade, **wrong)


# Random paths on machines of every kind: against a recursion of pairs, and the compiled loop against the plain one.

KINDS = {
    "endless table": lambda: limited("ac_table"),
    "table that ends": lambda: limited("ac_table", workpiece_side=(-200, 200)),
    "table with windings": lambda: limited("dmu50v", workpiece_side=(-400, 380), tool_side=(-170, 190)),
    "head with windings": lambda: limited("ac_head", workpiece_side=(-360, 360)),
    "head without rates": lambda: limited("nutating_head", rates=False),
    "narrow head and table": lambda: limited(
        "nutating_head_table", workpiece_side=(-100, 190), tool_side=(-120, 181)
    ),
}
MACHINES = {name: make() for name, make in KINDS.items()}


def random_path(kin, rng):
    """A path with steps of any size, often close to the pole, with rapid moves, and runs of records at the pole."""
    count, derived = int(rng.integers(1, 13)), kin.inverse_symbolic
    joints = np.cumsum(rng.normal(size=(count, 5)) * [5, 5, 5, *[rng.choice([0.02, 0.1, 0.5, 1.5])] * 2], axis=0)
    if rng.random() < 0.3:
        tool_side = float(sum(derived.solutions) / 2) + rng.normal(size=count) * 0.05
        joints[:, kin.symbols.index(derived.tool_side)] = tool_side
    cl = cldata.from_arrays(*kin.forward(joints))
    axes, rapid = cl.axes.copy(), rng.random(count) < rng.choice([0, 0.3])
    if kin.reach[0] == 0 and rng.random() < 0.6:
        for first, last in np.sort(rng.integers(0, count + 1, (2, 2))):
            axes[first:last] = np.array(derived.pole, float)
    return replace(cl, axes=axes, rapid=rapid)


def options(rng):
    return {
        "start": rng.choice([None, "some"]) and rng.uniform(-1, 1, 5),
        "prefer": rng.choice([None, 1, -1]),
        "sway": rng.choice([0.01, selection.SWAY, np.inf]),
    }


def beyond_the_short_way(kin, branch, start, end):
    """How many whole turns the workpiece-side axis makes on a branch beyond its short way, by walking."""
    arc = np.arccos(np.clip(start @ end, -1, 1))
    t = np.linspace(0, 1, 201)

    def walked(t):
        axes = (np.sin((1 - t) * arc)[:, None] * start + np.sin(t * arc)[:, None] * end) / np.sin(arc)
        return axes, kin.inverse(np.zeros(3), axes)[
            :, branch, kin.symbols.index(kin.inverse_symbolic.workpiece_side)
        ]

    nearest = t[np.argmax(np.abs(walked(t)[0] @ np.array(kin.inverse_symbolic.pole, float)))]
    t = np.unique(np.clip(np.r_[t, nearest + np.outer([-1, 1], np.geomspace(1e-9, 0.01, 400)).ravel()], 0, 1))
    angles = np.unwrap(walked(t)[1])
    turned = angles[-1] - angles[0]
    return round((turned - (np.remainder(turned + np.pi, 2 * np.pi) - np.pi)) / (2 * np.pi))


def matrices(kin, cl, found, sway):
    """Breaks and costs of all moves of a path, shape (n − 1, m, m)."""
    joints = np.nan_to_num(found.joints)
    steps = joints[1:, None] - joints[:-1, :, None]
    endless = ~np.isfinite(kin.machine.limits).all(axis=1) & (np.arange(5) > 2)
    steps[..., endless] = np.remainder(steps[..., endless] + np.pi, 2 * np.pi) - np.pi
    away = np.array([nearest_to_singular(kin, *ends) for ends in itertools.pairwise(cl.axes)])
    solution = np.arange(steps.shape[1]) // np.prod(
        [len(selection.windings(*ends)) for ends in kin.machine.limits[3:]]
    )
    further, workpiece_side = np.zeros(steps.shape), kin.symbols.index(kin.inverse_symbolic.workpiece_side)
    beside = [nearest_to_singular(kin, *ends, (0, np.pi)) > 0.01 * sway for ends in itertools.pairwise(cl.axes)]
    for move in np.flatnonzero(np.array(beside, bool) & ~cl.rapid[1:]):
        for branch in (0, 1):
            more = 2 * np.pi * beyond_the_short_way(kin, branch, *cl.axes[move : move + 2])
            further[move, ..., workpiece_side] += more * ((solution[:, None] == branch) & (solution == branch))
    steps += further * endless
    over = (found.branch[:, None] != found.branch) & ~np.reshape(away < sway, (-1, 1, 1))
    over = over | (np.abs(steps - further)[..., 3:] > np.pi + 1e-9).any(axis=-1)
    way = np.abs(steps) @ np.diag([1, 1, 1, np.degrees(1), np.degrees(1)])
    rates = np.where(np.isnan(kin.machine.max_rates), np.inf, kin.machine.max_rates)
    costs = (np.abs(steps) / rates).max(axis=-1) if np.isfinite(rates).any() else way.sum(axis=-1)
    return over & ~cl.rapid[1:, None, None], costs + 1e-9 * way.sum(axis=-1)


def plain(over, costs, first, inside):
    """Least (breaks, cost) from the first record to each candidate, one by one, and from each to the last."""
    far = (np.inf, np.inf)
    to = [[(0, cost) if here else far for cost, here in zip(first, inside[0], strict=True)]]
    for record in range(1, len(inside)):
        ways = [
            [
                (to[-1][i][0] + over[record - 1, i, j], to[-1][i][1] + costs[record - 1, i, j])
                for i in range(len(first))
            ]
            for j in range(len(first))
        ]
        to.append([min(way) if inside[record, j] else far for j, way in enumerate(ways)])
    rest = [[(0, 0.0) if here else far for here in inside[-1]]]
    for record in range(len(inside) - 1, 0, -1):
        ways = [
            [
                (rest[0][j][0] + over[record - 1, i, j], rest[0][j][1] + costs[record - 1, i, j])
                for j in range(len(first))
            ]
            for i in range(len(first))
        ]
        rest.insert(0, [min(way) if inside[record - 1, i] else far for i, way in enumerate(ways)])
    return np.array(to), np.array(rest)


@pytest.mark.parametrize("name", MACHINES)
def test_optimal_is_what_a_plain_recursion_finds(name, of):
    """The fewest breaks, then the least cost; and the very candidates, where no others are as good."""
    kin, rng, compared = MACHINES[name], np.random.default_rng(3), 0
    for _ in range(of(30, 100)):
        cl, chosen_by = random_path(kin, rng), options(rng)
        chosen_by["start"] = rng.uniform(-1, 1, 5)
        found = selection.candidates(kin, cl.points, cl.axes)
        if not found.inside.any(axis=1).all():
            continue
        over, costs = matrices(kin, cl, found, chosen_by["sway"])
        steps = selection.short_way(kin.machine, found.joints[0] - chosen_by["start"])
        to, rest = plain(over, costs, selection.move_costs(kin.machine, steps), found.inside)
        through = to + rest
        breaks, cost = min(map(tuple, through[-1]))
        chosen = selection.choose(kin, cl, **chosen_by, split=True)
        assert len(chosen.breaks) == breaks
        assert chosen.cost == pytest.approx(cost, rel=1e-6, abs=1e-5)
        best = (through[..., 0] == breaks) & (through[..., 1] < cost + 1e-8)
        for record in np.flatnonzero(best.sum(axis=1) == 1):
            turns = (chosen.joints[record] - found.joints[record, best[record].argmax()]) / selection.TURN
            endless = ~np.isfinite(kin.machine.limits).all(axis=1) & (np.arange(5) > 2)
            np.testing.assert_allclose(np.where(endless, turns - np.round(turns), turns), 0, atol=1e-9)
            compared += 1
    assert compared > 100


@pytest.mark.parametrize("name", MACHINES)
def test_shortest_takes_the_cheapest_of_the_moves_that_break_least(name, of):
    kin, rng, compared = MACHINES[name], np.random.default_rng(5), 0
    for _ in range(of(15, 40)):
        cl, chosen_by = random_path(kin, rng), options(rng)
        found = selection.candidates(kin, cl.points, cl.axes)
        if not found.inside.any(axis=1).all():
            continue
        over, costs = matrices(kin, cl, found, chosen_by["sway"])
        chosen = selection.choose(kin, cl, "shortest", **chosen_by, split=True)
        off = found.joints - chosen.joints[:, None]
        endless = ~np.isfinite(kin.machine.limits).all(axis=1) & (np.arange(5) > 2)
        off[..., endless] = np.remainder(off[..., endless] + np.pi, 2 * np.pi) - np.pi
        picks = np.nanargmin(np.where(found.inside, np.abs(off).max(axis=2), np.nan), axis=1)
        for record in range(1, len(cl)):
            moves = list(
                zip(over[record - 1, picks[record - 1]], costs[record - 1, picks[record - 1]], strict=True)
            )
            least = min(move for move, inside in zip(moves, found.inside[record], strict=True) if inside)
            assert moves[picks[record]] == pytest.approx(least, abs=1e-8)
            assert (record in chosen.breaks) == least[0]
            compared += 1
    assert compared > 50


def test_costs_are_not_lost_beside_breaks():
    """After many breaks a tiny difference of cost still decides."""
    kin = limited("ac_table", workpiece_side=(-100, 260), tool_side=(-50, 50))
    cl = turning(40, count=600)
    chosen = selection.choose(kin, cl, split=True)
    found = selection.candidates(kin, cl.points, cl.axes)
    over, costs = matrices(kin, cl, found, selection.SWAY)

    def beginning(branch, joints):
        return 1e-6 * (branch != 0) + 1e-9 * np.degrees(np.abs(joints[..., 3:])).sum(axis=-1)

    to, _ = plain(over, costs, beginning(found.branch, found.joints[0]), found.inside)
    breaks, cost = min(map(tuple, to[-1]))
    assert len(chosen.breaks) == breaks > 20
    way = np.abs(np.diff(chosen.joints, axis=0)).sum(axis=0) @ [1, 1, 1, np.degrees(1), np.degrees(1)]
    first = beginning(chosen.branch[0], chosen.joints[0])
    assert first + chosen.cost + 1e-9 * way == pytest.approx(cost, abs=1e-8)


def outcome(choose):
    """What a choice gives, or what its error says."""
    try:
        return choose()
    except (ReachError, InputError) as error:
        return str(error)


def assert_same(found, expected):
    if isinstance(expected, str):
        assert found == expected
    else:
        np.testing.assert_allclose(found.joints, expected.joints, atol=1e-12)
        np.testing.assert_array_equal(found.branch, expected.branch)
        assert found.breaks == expected.breaks
        assert found.cost == pytest.approx(expected.cost, rel=1e-12, abs=1e-12)


@pytest.mark.parametrize("strategy", ["optimal", "shortest"])
@pytest.mark.parametrize("name", MACHINES)
def test_the_compiled_loop_chooses_as_the_loop_as_it_stands(name, strategy, of, monkeypatch):
    numba = pytest.importorskip("numba")
    assert isinstance(compiled(selection.best_way), numba.core.dispatcher.Dispatcher)
    kin, rng = MACHINES[name], np.random.default_rng(11)
    for _ in range(of(15, 40)):
        cl, chosen_by = random_path(kin, rng), options(rng) | {"split": bool(rng.random() < 0.8)}
        monkeypatch.setattr(selection, "LONG", np.inf)
        expected = outcome(lambda: selection.choose(kin, cl, strategy, **chosen_by))  # noqa: B023
        monkeypatch.setattr(selection, "LONG", 0)
        assert_same(outcome(lambda: selection.choose(kin, cl, strategy, **chosen_by)), expected)  # noqa: B023
    assert len(compiled(selection.best_way, selection.nearest, selection.cost).signatures) == 1, "compiled once"


@pytest.mark.parametrize("workpiece_side", [None, (-370, 370)])
def test_beside_the_pole_of_a_45_degree_machine_the_workpiece_side_axis_turns_more_than_half_a_turn(workpiece_side):
    """Two records on both sides of the pole: it turns as it does through many records between them."""
    kin, rng, over = limited("nutating_head_table", workpiece_side=workpiece_side), np.random.default_rng(2), 0
    for _ in range(40):
        side, towards = 10 ** rng.uniform(-3.5, -1.5) * rng.choice([-1, 1]), rng.uniform(0, 2 * np.pi)
        t = np.linspace(-rng.uniform(0.02, 0.5), rng.uniform(0.02, 0.5), 2001)[:, None]
        axes = (
            [0, 0, 1]
            + t * [np.cos(towards), np.sin(towards), 0]
            + [-side * np.sin(towards), side * np.cos(towards), 0]
        )
        dense = selection.choose(kin, cldata.from_arrays(10 * t * [1, 1, 0], axes)).joints
        sparse = selection.choose(kin, cldata.from_arrays(10 * t[[0, -1]] * [1, 1, 0], axes[[0, -1]])).joints
        turned = dense[-1] - dense[0]
        np.testing.assert_allclose(sparse[1] - sparse[0], turned, atol=1e-9)
        over += np.abs(turned[3:]).max() > np.pi
    assert over > 5


@pytest.mark.parametrize("strategy", ["optimal", "shortest"])
def test_a_limit_of_many_turns_that_is_met_is_kept(strategy, monkeypatch):
    """More turns than travel has, one way: the path is split, as often as all windings together say."""
    cl = turning(12, count=200)
    wide = limited("ac_table", workpiece_side=(-1900, 1900))
    chosen = selection.choose(wide, cl, strategy, split=True)
    assert wide.machine.within(chosen.joints).all()
    monkeypatch.setattr(selection, "MANY", np.inf)
    every = selection.choose(wide, cl, strategy, split=True)
    np.testing.assert_allclose(chosen.joints, every.joints, atol=1e-9)
    assert chosen.breaks == every.breaks != ()
