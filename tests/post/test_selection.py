"""Selection: against brute force, the paper's rules by hand, limits, and paths that break."""

import itertools
from dataclasses import replace

import numpy as np
import pytest

from mathpost import machine
from mathpost.errors import InputError, ReachError
from mathpost.kinematics import Kinematics
from mathpost.post import cl as cldata
from mathpost.post import selection
from tests.conftest import DATA

RATED = ["dmu50v", "ac_table", "nutating_head", "nutating_head_table"]


def limited(name, *, outer=None, inner=None, rates=True):
    """A machine file with other travel (degrees), or without rates."""
    data = machine.load(DATA / f"machines/{name}.toml")
    kin = Kinematics(data)
    at_outer = kin.symbols.index(kin.inverse_symbolic.outer) - 3
    rotary = list(data.rotary)
    for index, limits in ((at_outer, outer), (1 - at_outer, inner)):
        if limits is not None:
            rotary[index] = replace(rotary[index], limits=tuple(np.radians(limits)))
    linear = tuple(replace(axis, limits=machine.ENDLESS) for axis in data.linear)
    if not rates:
        rotary = [replace(joint, max_rate=None) for joint in rotary]
        linear = tuple(replace(axis, max_rate=None) for axis in linear)
    return Kinematics(replace(data, rotary=tuple(rotary), linear=linear))


def wandering(kin, count, rng, step=0.5):
    """A path of poses that the machine can reach: a random walk of its own joints."""
    joints = np.cumsum(rng.normal(size=(count, 5)) * [5, 5, 5, step, step], axis=0)
    return cldata.from_arrays(*kin.forward(joints))


@pytest.mark.parametrize("rates", [True, False])
@pytest.mark.parametrize("name", RATED)
def test_optimal_equals_brute_force(name, rates):
    kin = limited(name, outer=(-200, 250), inner=(-170, 190), rates=rates)
    rng = np.random.default_rng(7)
    for _ in range(125):
        cl = wandering(kin, 4, rng)
        found = selection.candidates(kin, cl.points, cl.axes)
        choices = [np.flatnonzero(row) for row in found.inside]
        best = np.inf
        for picks in itertools.product(*choices):
            joints = found.joints[range(4), picks]
            if (np.abs(np.diff(joints[:, 3:], axis=0)) <= selection.HALF_TURN).all():
                best = min(best, selection.move_costs(kin.machine, np.diff(joints, axis=0)).sum())
        if np.isfinite(best):
            costs = {
                name: selection.choose(kin, cl, name, sway=np.inf, split=True) for name in ("optimal", "shortest")
            }
            assert costs["optimal"].breaks == ()
            assert costs["optimal"].cost == pytest.approx(best, rel=1e-6, abs=1e-6)
            assert costs["shortest"].breaks or costs["shortest"].cost >= best - 1e-6
        else:
            with pytest.raises(ReachError, match="breaks"):
                selection.choose(kin, cl, sway=np.inf)


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


def test_a_limited_axis_breaks_with_the_record_and_is_split():
    kin = limited("ac_table", outer=(-360, 360))
    assert np.degrees(np.ptp(selection.choose(kin, turning(1.7)).joints[:, 4])) == pytest.approx(612)
    cl = turning(3, count=61)
    # It says how far the machine comes without a break: as on the path that ends there.
    so_far = np.degrees(selection.choose(kin, cl.part(0, 36)).joints[-1, 3:])
    for size in (10, 36, 61):
        pieces = [cl.part(first, min(first + size, 61)) for first in range(0, 61, size)]
        with pytest.raises(ReachError, match="record 37: the path breaks here") as refused:
            list(selection.choose_pieces(kin, pieces))
        assert f"(so far A {so_far[0]:.3f}° C {so_far[1]:.3f}°)" in str(refused.value)
    split = selection.choose(kin, cl, split=True)
    assert len(split.breaks) == 1 and split.breaks[0] <= 36
    assert np.degrees(np.abs(split.joints[:, 4]).max()) <= 360 + 1e-9


def test_rapid_moves_may_swing():
    kin = limited("ac_table", outer=(-200, 200))
    cl = turning(2, count=61)
    rapid = np.zeros(61, bool)
    rapid[[20, 40]] = True
    assert selection.choose(kin, replace(cl, rapid=rapid)).breaks == ()


def test_a_change_of_branch_away_from_the_pole_is_no_cut():
    kin = limited("ac_table", inner=(-50, 50), outer=(-100, 100))
    cl = turning(1, count=37)
    with pytest.raises(ReachError, match="breaks"):
        selection.choose(kin, cl)
    assert selection.choose(kin, cl, sway=np.inf).breaks == ()


def test_out_of_travel_names_record_and_axis(dmu50v):
    cl = cldata.from_arrays([[0, 0, 0], [900, 0, 0]], [[0, 0, 1], [0.1, 0, 1]])
    with pytest.raises(ReachError, match=r"record 2: no solution inside travel: .*X .*mm is outside -250 … 250"):
        selection.choose(dmu50v, cl)
    with pytest.raises(ReachError, match="record 1: .*out of reach"):
        selection.choose(dmu50v, cldata.from_arrays([[0, 0, 0]], [[0, 0.6, -0.8]]))


def test_the_outer_axis_turns_while_the_tool_is_at_the_pole(kin):
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
    outer = kin.symbols.index(kin.inverse_symbolic.outer)
    leaning = chosen.joints[2:8, outer]
    assert np.degrees(np.ptp(leaning)) < 10
    tip, axis = kin.forward(chosen.joints)
    np.testing.assert_allclose(tip, cl.points, atol=1e-9)
    np.testing.assert_allclose(axis, cl.axes, atol=1e-12)


def test_candidates_say_why_they_are_out(dmu50v_both_ways, blade):
    found = selection.candidates(dmu50v_both_ways, blade.points, blade.axes)
    rows = found.table(4, previous=found.joints[3, 0])
    reasons = {(branch, round(joints[3])): reason for branch, joints, cost, reason in rows}
    assert reasons[0, 23] == reasons[1, -23] == ""
    assert reasons[1, 337] == "B 337.309° is outside -25 … 180"
    assert [reason == "" for *_, reason in rows] == found.inside[4].tolist()


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
        kin = limited("dmu50v", inner=travel)
        chosen = selection.choose(kin, self.tilts(tilts), "paper")
        np.testing.assert_allclose(np.degrees(chosen.joints[:, 3]), expected, atol=1e-9)

    def test_case_1(self):
        with pytest.raises(ReachError, match=r"record 2: \|B\| 41.000° is outside travel, case \(1\)"):
            selection.choose(limited("dmu50v", inner=(-5, 40)), self.tilts([11, 41]), "paper")

    def test_case_2_with_the_wrong_preference_leaves_travel(self):
        with pytest.raises(ReachError, match="record 1: B -11.000"):
            selection.choose(limited("dmu50v", inner=(-5, 40)), self.tilts([11]), "paper", prefer=-1)

    @pytest.mark.parametrize(
        ("angles", "expected"),
        [
            ([150, 170, -170, -150], [150, 170, -170, -150]),  # equal steps: nothing happens
            ([150, 170, -175, -155], [150, -190, -175, -155]),  # the jump moves by one row
            ([150, 165, -175, -155], [150, 165, -175, -155]),
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


def test_wrong_strategy(dmu50v, blade):
    with pytest.raises(InputError, match="'best'"):
        selection.choose(dmu50v, blade, "best")
