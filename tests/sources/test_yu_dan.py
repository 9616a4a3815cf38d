"""Source 002 (Yu Dan et al.): its tables reproduced to the printed digits, or shown to be wrong."""

import numpy as np
import pytest
import sympy as sp
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation

from mathpost.errors import MathpostError
from mathpost.formula import numeric
from mathpost.path import selection
from mathpost.path.between_blocks import axis_lag, linearize, subdivide
from mathpost.path.deviation import deviation
from mathpost.shop.post.ways import Crossing
from mathpost.sources import yu_dan
from mathpost.sources.yu_dan import equation_8, paper_clamped, paper_cubic
from mathpost.teaching.course.lesson_data import load, with_travel
from tests.conftest import DATA

ROWS = (40, 50, 60, 70, 80)
TABLE_3_TIMES = (0.175, 0.375, 0.575, 0.775, 0.95)


@pytest.fixture
def table_2(published):
    """X Y Z B C of table 2, shape (5, 5), mm and degrees."""
    return np.array([published[2][row] for row in ROWS])


@pytest.fixture
def table_2_joints(dmu50v, blade, table_2):
    """Exact X Y Z for the printed B and C of table 2."""
    return dmu50v.close(blade.points, np.radians(table_2[:, 3:]))


def test_every_b_from_k_as_printed(dmu50v, table_2):
    derived = dmu50v.inverse_symbolic
    cosine = derived.equation.lhs.coeff(sp.cos(derived.tool_side))
    tilt = numeric(sp.acos(derived.equation.rhs / cosine), derived.axis)
    printed = np.loadtxt(DATA / "tables/yu_dan_table_1.csv", delimiter=",", skiprows=2)[:, 4:]
    np.testing.assert_array_equal(np.degrees(tilt(*printed.T)).round(3), table_2[:, 3])


def test_normalising_first_moves_two_b_by_one_digit(dmu50v, blade, table_2):
    b = dmu50v.inverse(blade.points, blade.axes, degrees=True)[:, 0, 3].round(3)
    assert np.flatnonzero(b != table_2[:, 3]).tolist() == [1, 2]
    np.testing.assert_allclose(b[1:3] - table_2[1:3, 3], [0.001, -0.001], atol=1e-9)


def test_every_xyz_from_the_tables_own_angles(table_2, table_2_joints):
    assert np.abs(table_2_joints[:, :3] - table_2[:, :3]).max() < 0.001


@pytest.mark.parametrize("sign", [(1, -1), (-1, 1), (-1, -1)])
def test_other_signs_do_not_reproduce_xyz(dmu50v, blade, table_2, sign):
    """Negative control: the table turns the workpiece positively, about both axes."""
    joints = dmu50v.close(blade.points, np.radians(table_2[:, 3:]) * sign)
    assert np.abs(joints[:, :3] - table_2[:, :3]).max() > 10


def test_no_c_of_table_2_points_the_tool_along_the_cl_axis(dmu50v, blade, table_2):
    joints = np.concatenate([table_2[:, :3], np.radians(table_2[:, 3:])], axis=1)
    axis = dmu50v.forward(joints)[1]
    angle = np.degrees(np.arccos((axis * blade.axes).sum(axis=1)))
    np.testing.assert_array_equal(angle.round(3), [1.342, 0.011, 0.057, 0.747, 4.437])


def test_the_right_c(dmu50v, blade):
    c = dmu50v.inverse(blade.points, blade.axes, degrees=True)[:, :, 4]
    np.testing.assert_allclose(c[:, 0], [175.8146, 178.3319, -0.8254, -3.2859, -8.0750], atol=1e-4)
    np.testing.assert_allclose(c[:, 1], [4.1854, 1.6681, -179.1746, -176.7141, -171.9250], atol=1e-4)


def test_table_3_is_the_four_point_cubic(published):
    rows = np.array([published[2][row] for row in (40, 50, 60, 70)])
    printed = np.array([published[3][row] for row in range(51, 56)])
    assert np.abs(paper_cubic(rows, TABLE_3_TIMES) - printed).max() < 0.001
    clamped = np.abs(paper_clamped(rows, TABLE_3_TIMES) - printed).max(axis=0)
    np.testing.assert_allclose(clamped, [7.771, 9.737, 0.641, 0.928, 14.777], atol=0.001)


@pytest.mark.parametrize("column", [0, 1, 4])  # Z and B change too little for three decimals of t
def test_one_column_of_table_3_gives_its_times_and_these_the_others(published, column):
    rows = np.array([published[2][row] for row in (40, 50, 60, 70)])
    printed = np.array([published[3][row] for row in range(51, 56)])
    curve = CubicSpline([-1, 0, 1, 2], rows[:, column], bc_type="not-a-knot")
    times = np.concatenate([curve.solve(value, extrapolate=False) for value in printed[:, column]])
    times = times[(times > 0) & (times < 1)].round(4)
    np.testing.assert_allclose(times, TABLE_3_TIMES, atol=1e-4)
    assert np.abs(paper_cubic(rows, times.round(3)) - printed).max() < 0.001


def test_table_3_cuts_into_the_part(dmu50v, blade, published):
    words = np.array([published[3][row] for row in (50, 51, 52, 53, 54, 55, 60)])
    joints = np.concatenate([words[:, :3], np.radians(words[:, 3:])], axis=1)
    place = np.r_[1, 1 + np.array(TABLE_3_TIMES), 2]
    tips, axes = blade.at(place)
    off = np.linalg.norm(dmu50v.forward(joints)[0] - tips, axis=1)
    np.testing.assert_array_equal(off[1:-1].round(1), [40.2, 71.6, 75.4, 50.1, 12.0])
    along = deviation(dmu50v, joints[:-1], joints[1:], tips=(tips[:-1], tips[1:]), axes=(axes[:-1], axes[1:]))
    assert along[0].max() == pytest.approx(77.575, abs=0.002)
    whole = np.broadcast_to(blade.axes[[1, 2], None], (2, 6, 3))
    out_of_plane = deviation(dmu50v, joints[:-1], joints[1:], axes=whole)[1]
    assert np.degrees(out_of_plane.max()) == pytest.approx(1.96, abs=0.01)
    mended = dmu50v.close(tips, joints[:, 3:])
    assert np.linalg.norm(dmu50v.forward(mended)[0] - tips, axis=1).max() < 1e-12
    np.testing.assert_allclose(mended[1, :3], [-68.480, -32.029, 57.834], atol=0.001)


def test_equation_8_converges_to_nothing(dmu50v, table_2_joints):
    joints, claimed, true = equation_8(dmu50v, table_2_joints[1], table_2_joints[2], 0.01)
    assert len(joints) - 1 == 128 and claimed <= 0.01
    assert true == pytest.approx(76.4707, abs=0.001)
    even = np.vstack([table_2_joints[1], subdivide(dmu50v, table_2_joints[1:2], table_2_joints[2:3], 128)[0]])
    assert deviation(dmu50v, even[:-1], even[1:])[0].max() == pytest.approx(0.00574, abs=0.00002)


@pytest.mark.parametrize(("tolerance", "pieces"), [(0.05, 44), (0.01, 98), (0.005, 138)])
def test_pieces_from_row_50_to_60(dmu50v, table_2_joints, tolerance, pieces):
    assert len(linearize(dmu50v, table_2_joints[1:3], tolerance).joints) - 1 == pieces


def test_with_b_to_minus_25_there_is_no_singular_jump(dmu50v_both_ways, blade):
    chosen = selection.choose(dmu50v_both_ways, blade)
    c = np.degrees(chosen.joints[:, 4])
    np.testing.assert_array_equal(c[[0, -1]].round(3), [175.815, 188.075])
    assert np.diff(c).max() < 5
    errors = deviation(dmu50v_both_ways, chosen.joints[:-1], chosen.joints[1:])[0]
    np.testing.assert_allclose(errors, [0.178927, 0.174108, 0.166622, 0.604563], atol=5e-5)


def test_the_papers_rule_makes_the_jump(dmu50v_both_ways, blade):
    chosen = selection.choose(dmu50v_both_ways, blade, "paper")
    assert (np.degrees(chosen.joints[:, 3]) > 0).all()
    assert np.degrees(np.abs(np.diff(chosen.joints[:, 4])).max()) == pytest.approx(179.157, abs=0.001)


def test_the_cases_of_the_five_rows(dmu50v_both_ways, blade):
    found = yu_dan.cases(dmu50v_both_ways, blade, 1)
    assert [case.number for case in found] == [3, 3, 3, 3, 3]
    assert [case.kappa for case in found] == [0] * 5
    small, large = np.degrees(found[2].steps)
    assert small == pytest.approx(4.7167 - 2.3344, abs=1e-3) and large == pytest.approx(4.7167 + 2.3344, abs=1e-3)
    assert str(found[2]) == "case (3): κ = 0, 2.334°, steps 2.382° and 7.051° for κ = 0 and 1"


def test_c_rule_says_what_it_compares():
    angles = np.radians([150, 170, -175, -155])
    first, second = yu_dan.turns(angles)
    np.testing.assert_allclose(np.degrees([first.turned, first.delta_1, first.delta_2]), [-190, 365, 355])
    np.testing.assert_allclose(np.degrees([second.delta_1, second.delta_2]), [35, 715])
    assert (first.taken, second.taken) == (first.turned, angles[2])


@pytest.mark.parametrize(("span", "dt"), [(1.0, (1.0, 1.0)), (3.0, (0.5, 2.0))])
def test_the_cubic_by_hand_is_scipys(span, dt):
    """The derivation, the blend of four polynomials that a book on curves prints, and `CubicSpline`."""
    rows = np.random.default_rng(3).normal(size=(4, 5))
    k_1, k_2 = (rows[1] - rows[0]) / dt[0], (rows[3] - rows[2]) / dt[1]
    np.testing.assert_allclose(yu_dan.end_slopes(rows, dt), [k_1, k_2])
    t = np.linspace(0, span, 9)
    u = (t / span)[:, None]
    ends = rows[1] * (1 - 3 * u**2 + 2 * u**3) + rows[2] * (3 * u**2 - 2 * u**3)
    by_hand = ends + span * (k_1 * (u - 2 * u**2 + u**3) + k_2 * (u**3 - u**2))
    np.testing.assert_allclose(yu_dan.clamped(rows, span, dt)(t), by_hand, atol=1e-12)
    scipys = CubicSpline([0, span], rows[1:3], bc_type=((1, k_1), (1, k_2)))
    np.testing.assert_allclose(scipys(t), by_hand, atol=1e-12)
    np.testing.assert_allclose(yu_dan.clamped(rows[:, 3], span, dt)(t), by_hand[:, 3], atol=1e-12)
    np.testing.assert_allclose(yu_dan.clamped(rows, span, dt)(t[2]), by_hand[2], atol=1e-12)


def test_the_cubic_through_four_records_is_scipys():
    rows, t = np.random.default_rng(4).normal(size=(4, 5)), np.linspace(-1, 2, 9)
    scipys = CubicSpline([-1, 0, 1, 2], rows, bc_type="not-a-knot")(t)
    np.testing.assert_allclose(paper_cubic(rows, t), scipys, atol=1e-12)
    np.testing.assert_allclose(paper_cubic(rows, t[4]), scipys[4], atol=1e-12)


def test_smooth_keeps_the_tip_at_its_points(dmu50v, blade):
    joints = selection.choose(dmu50v, blade).joints
    place, smoothed = yu_dan.smooth(dmu50v, blade, joints, (1, 2), 5)
    tip, _ = dmu50v.forward(smoothed)
    np.testing.assert_allclose(tip, blade.at(place)[0], atol=1e-9)
    np.testing.assert_allclose(smoothed[[0, -1]], joints[1:3], atol=1e-9)
    for region in ((0, 2), (2, 4), (2, 2)):
        with pytest.raises(MathpostError, match="a record before the region"):
            yu_dan.smooth(dmu50v, blade, joints, region, 5)


def test_lifted_along_the_tool_axis_and_back(kin):
    joints = np.array([10.0, 20.0, 30.0, 0.3, 0.5])
    (tip, axis), (moved, _) = kin.forward(joints), kin.forward(yu_dan.lifted(kin, joints, 5.0))
    np.testing.assert_allclose(moved - tip, 5 * axis, atol=1e-9)
    np.testing.assert_allclose(yu_dan.lifted(kin, yu_dan.lifted(kin, joints, 5.0), -5.0), joints, atol=1e-9)


@pytest.mark.parametrize(("name", "arc", "lag"), [("linear", 2.548, 2.641), ("cubic", 1.384, 1.555)])
def test_the_arc_and_the_lag_are_two_numbers(dmu50v, blade, name, arc, lag):
    """By dense sampling and dot products: the distance from the arc, and the angle at equal virtual time."""
    way = Crossing(dmu50v, blade, selection.choose(dmu50v, blade).joints, (1, 2)).way(name)
    start, end = blade.axes[1:3]
    turn = np.arccos(start @ end)
    fine = np.linspace(0, 1, 20001)[:, None]
    circle = (np.sin((1 - fine) * turn) * start + np.sin(fine * turn) * end) / np.sin(turn)
    place = np.linspace(1, 2, 2001)
    joints = np.array([np.interp(place, way.place, column) for column in way.joints.T]).T
    axes = dmu50v.forward(joints)[1]
    np.testing.assert_allclose(np.degrees(np.arccos((axes @ circle.T).max(axis=1))).max(), arc, atol=0.001)
    np.testing.assert_allclose(np.degrees(np.arccos((axes * circle[::10]).sum(axis=1))).max(), lag, atol=0.001)
    assert np.degrees(way.axis_error) == pytest.approx(arc, abs=0.001)
    moves = way.joints[:-1], way.joints[1:], way.place[:-1], way.place[1:]
    assert np.degrees(axis_lag(dmu50v, blade, *moves).max()) == pytest.approx(lag, abs=0.001)


def off_the_arc(dmu50v, blade, joints, samples=401):
    """The largest distances of tip and tool axis, mm and degrees, from row 50 and the arc to row 60."""
    start, end = blade.axes[1:3]
    turn = np.arccos(start @ end)
    fine = np.linspace(0, 1, 20001)[:, None]
    circle = (np.sin((1 - fine) * turn) * start + np.sin(fine * turn) * end) / np.sin(turn)
    number = np.linspace(0, len(joints) - 1, samples * (len(joints) - 1) + 1)
    between = np.stack([np.interp(number, np.arange(len(joints)), column) for column in joints.T], axis=1)
    tips, axes = dmu50v.forward(between)
    off = np.linalg.norm(tips - blade.points[1], axis=1).max()
    return off, np.degrees(np.arccos((axes @ circle.T).max(axis=1))).max()


def test_three_readings_of_the_cubic_against_table_3(published):
    """The slopes alone, the points alone, and both: what each makes of X Y Z B if C gives the times."""
    rows = np.array([published[2][row] for row in (40, 50, 60, 70)])
    printed = np.array([published[3][row] for row in range(51, 56)])
    slopes = (1, rows[1] - rows[0]), (1, rows[3] - rows[2])
    readings = {
        "slopes": CubicSpline([0, 1], rows[1:3], bc_type=slopes),
        "points": CubicSpline([-1, 0, 1, 2], rows, bc_type="not-a-knot"),
        "both": CubicSpline([-1, 0, 1, 2], rows, bc_type=slopes),
    }
    missed = {}
    fine = np.linspace(0, 1, 200001)
    for name, curve in readings.items():
        c = curve(fine)[:, 4]
        times = np.interp(-printed[:, 4], -c[c.argmax() :], fine[c.argmax() :])  # C falls from its crest on
        missed[name] = np.abs(curve(times) - printed).max(axis=0)[:4]
    assert missed["points"].max() < 0.001
    np.testing.assert_allclose(missed["both"], [0.220, 0.149, 0.284, 0.293], atol=0.001)
    assert missed["slopes"][:3].max() == pytest.approx(0.98, abs=0.005)


@pytest.mark.parametrize(
    ("dt", "arc", "lowest"),
    [((1, 1), 1.383, 1.38), ((0.5, 0.5), 0.569, -0.20), ((2, 2), 1.951, 2.02), ((0.3, 1.7), 0.345, 0.03)],
)
def test_the_virtual_time_shapes_the_axis_error(dmu50v, blade, dt, arc, lowest):
    """B and C on Hermite's cubic, written out here; the tip is not asked."""
    m = dmu50v.inverse(blade.points, blade.axes)[:4, 0, 3:]
    k_1, k_2 = (m[1] - m[0]) / dt[0], (m[3] - m[2]) / dt[1]
    t = np.linspace(0, 1, 2001)[:, None]
    rotary = m[1] * (1 - 3 * t**2 + 2 * t**3) + m[2] * (3 * t**2 - 2 * t**3)
    rotary = rotary + k_1 * (t - 2 * t**2 + t**3) + k_2 * (t**3 - t**2)
    joints = np.hstack([np.zeros((len(t), 3)), rotary])
    assert off_the_arc(dmu50v, blade, joints, samples=1)[1] == pytest.approx(arc, abs=0.001)
    assert np.degrees(rotary[:, 0].min()) == pytest.approx(lowest, abs=0.01)


def test_table_3_mended_against_table_2_mended(dmu50v, blade, published):
    """X Y Z computed from the printed B and C: what is left between the rows."""
    words = np.array([published[3][row] for row in (50, 51, 52, 53, 54, 55, 60)])
    place = np.r_[1, 1 + np.array(TABLE_3_TIMES), 2]
    mended = dmu50v.close(blade.at(place)[0], np.radians(words[:, 3:]))
    assert off_the_arc(dmu50v, blade, mended) == pytest.approx((4.4, 1.963), abs=0.05)
    assert off_the_arc(dmu50v, blade, mended)[1] == pytest.approx(1.963, abs=0.001)
    assert off_the_arc(dmu50v, blade, mended[[0, -1]])[0] == pytest.approx(76.5, abs=0.05)


def test_b_at_110_degrees_leans_the_tool_by_70_8(dmu50v):
    """A turn about the axis at 45°, by SciPy."""
    turned = Rotation.from_rotvec(np.radians(110) * np.array([0, 1, 1]) / np.sqrt(2)).apply([0, 0, 1])
    assert np.degrees(np.arccos(turned[2])) == pytest.approx(70.8, abs=0.05)
    axis = dmu50v.forward([0, 0, 0, np.radians(110), 0])[1]
    assert axis[2] == pytest.approx(turned[2])


@pytest.mark.parametrize(("rule", "arc"), [("optimal", 4.183), ("shortest", 3.322), ("paper", 2.548)])
def test_each_choice_with_b_from_minus_5_strays_from_its_arcs(blade, rule, arc):
    """Over all four moves, by dense sampling; no choice is nearer than its distance from the pole allows."""
    kin = with_travel(load("dmu50v"), -5, 110)
    joints = selection.choose(kin, blade, rule, sway=np.inf).joints
    worst = 0.0
    for move in range(4):
        step = joints[move + 1] - joints[move]
        step[4] -= 2 * np.pi * np.round(step[4] / (2 * np.pi))
        axes = kin.forward(joints[move] + np.linspace(0, 1, 1001)[:, None] * step)[1]
        one, two = blade.axes[move : move + 2]
        turn = np.arccos(one @ two)
        fine = np.linspace(0, 1, 4001)[:, None]
        circle = (np.sin((1 - fine) * turn) * one + np.sin(fine * turn) * two) / np.sin(turn)
        worst = max(worst, np.degrees(np.arccos((axes @ circle.T).max(axis=1).clip(-1, 1))).max())
    assert worst == pytest.approx(arc, abs=0.001)


@pytest.mark.parametrize(("n", "tip"), [(5, 5.516), (80, 0.0329), (160, 0.0083)])
def test_what_the_number_of_points_buys(dmu50v, blade, n, tip):
    """The accuracy asks for a least n: the tip between n points, by dense sampling."""
    joints = selection.choose(dmu50v, blade).joints
    _, points = yu_dan.smooth(dmu50v, blade, joints, (1, 2), n)
    assert off_the_arc(dmu50v, blade, points, samples=41)[0] == pytest.approx(tip, rel=0.15)
