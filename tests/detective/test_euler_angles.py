"""The detective against readings computed by SciPy, and the numbers of the sources."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from mathpost.detective.digits import written_decimals
from mathpost.detective.euler_angles import explain
from mathpost.detective.misreadings import Factors, all_factors, matrices, wordings
from mathpost.detective.rotary_axes import JointCase, explain_joints
from mathpost.errors import InputError
from mathpost.rotation import wrap

ANGLES, POINT = (135, 54.7356, -90), (3, 4, 5)
SOMEWHERE = np.array([21.3, -47.9, 74.6])


def turned_frame(angles, sequence="ZXZ"):
    """The frame turned by three intrinsic rotations: its axes are the columns."""
    return Rotation.from_euler(sequence, angles, degrees=True).as_matrix()


# What someone may do wrong, computed without the package: name of the kind → matrix.
def _single(axis, angle):
    return Rotation.from_euler(axis, angle, degrees=True).as_matrix()


WRONG = {
    "active": lambda a: _single("Z", a[2]) @ _single("X", a[1]) @ _single("Z", a[0]),
    "transpose": lambda a: turned_frame(a),
    "order": lambda a: _single("Z", a[0]).T @ _single("X", a[1]).T @ _single("Z", a[2]).T,
    "sign": lambda a: turned_frame(a * [1, -1, 1]).T,
    "exchange": lambda a: turned_frame(a[[1, 0, 2]]).T,
    "left out": lambda a: turned_frame(a * [1, 1, 0]).T,
    "axis": lambda a: turned_frame(a, "ZYZ").T,
    "unit": lambda a: turned_frame(np.rad2deg(a)).T,
}


def test_numbers_of_the_source():
    assert explain(ANGLES, POINT, (-1.224744, 0.707107, 6.928203)).right
    assert explain(ANGLES, POINT, (-4.490731, 4.949747, 2.309402)).misreadings[0].kinds == ("active",)
    assert explain(ANGLES, POINT, (1.283069, 6.939923, 0.437263)).misreadings[0].kinds == ("transpose",)
    assert explain(ANGLES, POINT, (6.939923, -1.283069, 0.437263)).misreadings[0].kinds == ("order",)
    # With the exact β = arccos(1/√3) of which 54.7356 is the rounding.
    exact = (-1.224744871, 0.707106781, 6.928203230)
    found = explain(ANGLES, POINT, exact)
    assert found.right and found.misreadings[0].kinds == ("unrounded",)


@pytest.mark.parametrize("kind", WRONG)
@pytest.mark.parametrize("decimals", [3, 6, 12])
def test_single_slips_are_named_first(kind, decimals):
    answer = (WRONG[kind](SOMEWHERE) @ POINT).round(decimals)
    found = explain(SOMEWHERE, POINT, answer, decimals=decimals)
    assert kind in found.misreadings[0].kinds and len(found.misreadings[0].kinds) == 1, str(found)
    np.testing.assert_allclose(found.misreadings[0].value, answer, atol=10.0**-decimals)


@pytest.mark.parametrize("kind", WRONG)
def test_single_slips_in_a_matrix(kind):
    answer = WRONG[kind](SOMEWHERE).round(4)
    found = explain(SOMEWHERE, None, answer)
    assert found.misreadings[0].kinds == (kind,)
    np.testing.assert_allclose(found.misreadings[0].value, answer, atol=1e-4)


@pytest.mark.parametrize("sequence", ["ZXZ", "ZYZ", "XYZ", "ZYX", "XYX"])
def test_other_sequences(sequence):
    right = turned_frame(SOMEWHERE, sequence).T @ POINT
    assert explain(SOMEWHERE, POINT, right, sequence=sequence).right
    missing = turned_frame(SOMEWHERE, sequence) @ POINT
    assert "transpose" in explain(SOMEWHERE, POINT, missing, sequence=sequence).misreadings[0].kinds


@pytest.mark.parametrize("sequence", ["xyz", "zyx", "xzx", "yxz"])
def test_lower_case_means_fixed_axes(sequence):
    angles, point = [30, 60, 10], np.array([20, -10, 30])
    fixed, turned = (
        Rotation.from_euler(s, angles, degrees=True).inv().apply(point) for s in (sequence, sequence.upper())
    )
    assert explain(angles, point, fixed.round(6), sequence=sequence).right
    found = explain(angles, point, turned.round(6), sequence=sequence)
    assert "as about turned axes" in str(found) and not found.right


def test_a_reflection_is_called_one():
    found = explain(
        [20, 30, 40], None, np.diag([1.0, -1, 1]) @ Rotation.from_euler("y", 20, degrees=True).as_matrix()
    )
    assert "a reflection, left-handed axes" in found.note and "With Y (column 2) turned round" in found.note


@pytest.mark.parametrize("sequence", ["ZXZ", "xyz", "ZYX", "yxz"])
def test_active_is_right_where_it_was_said(sequence):
    angles, point, origin = [30, 60, 10], np.array([20, -10, 30]), np.array([5, -7, 11])
    turned = Rotation.from_euler(sequence, angles, degrees=True)
    active = {"sequence": sequence, "convention": "active"}
    assert explain(angles, point, turned.apply(point).round(6), **active).right
    assert explain(angles, None, turned.as_matrix().round(6), **active).right
    passive = explain(angles, point, turned.inv().apply(point).round(6), **active)
    assert not passive.right and "right: passive" in passive.note
    assert "right: active" in explain(angles, point, turned.apply(point).round(6), sequence=sequence).note
    assert "left-handed" in str(explain(angles, point, _negated(sequence, angles).apply(point).round(6), **active))
    placed = {**active, "origin": origin}
    assert explain(angles, point, (turned.apply(point) + origin).round(6), **placed).right
    for answer, said in (
        (turned.apply(point), "is not added"),
        (turned.apply(point - origin) + origin, "the centre of rotation"),
        (turned.apply(point + origin), "added before"),
    ):
        assert said in explain(angles, point, answer.round(6), **placed).misreadings[0].sentence


def _negated(sequence, angles):
    return Rotation.from_euler(sequence, np.negative(angles), degrees=True)


@settings(max_examples=40, deadline=None)
@given(
    key=st.sampled_from(sorted(wordings())),
    axes=st.sampled_from(["ZXZ", "ZYZ", "XYZ", "ZXY"]),
    source=st.sampled_from([(0, 1, 2), (2, 1, 0), (1, 0, 2), (0, 2, 1), (1, 2, 0)]),
    kept=st.sampled_from([(True, True, True), (True, False, True), (True, True, False)]),
    unit=st.sampled_from(["degrees", "radians"]),
    without=st.sampled_from(["axes", "source", "meaning"]),
)
def test_every_pair_of_the_common_slips_is_found(key, axes, source, kept, unit, without):
    angles = np.array([23.456, -41.237, 77.891])
    axes, source = "ZXZ" if without == "axes" else axes, (0, 1, 2) if without == "source" else source
    kept, unit = ((True,) * 3, "degrees") if without == "meaning" else (kept, unit if all(kept) else "degrees")
    turns = [angles[n] * kept[k] for k, n in enumerate(source)]
    turns = np.rad2deg(turns) if unit == "radians" else turns
    order, signs = key
    matrix = np.eye(3)
    for n in order:
        matrix = matrix @ _single(axes[n], signs[n] * turns[n]).T
    answer = matrix @ POINT
    found = explain(angles, POINT, answer.round(9), decimals=9)
    assert found.explained
    np.testing.assert_allclose(found.misreadings[0].value, answer, atol=1e-8)


def test_nothing_is_made_up():
    rng = np.random.default_rng(5)
    for _ in range(10):
        direction = rng.normal(size=3)
        answer = direction / np.linalg.norm(direction) * np.linalg.norm(POINT)
        found = explain(SOMEWHERE, POINT, answer.round(5))
        assert not found.explained and "other angles" in found.note
    assert "No rotation gives it: the answer has the length" in explain(SOMEWHERE, POINT, (1, 2, 3.123)).note
    rounded_up = 4.2069, -4.1982, -3.8312  # all three of them by nearly half a digit, and so is the length by more
    assert "other angles" in explain(SOMEWHERE, POINT, rounded_up).note
    assert not explain(SOMEWHERE, POINT, (1.3, -2.6, 6.4)).explained  # so coarse that many fit by accident
    off = turned_frame(SOMEWHERE).T @ POINT + [0, 0, 0.5]
    assert "Only z is off" in explain(SOMEWHERE, POINT, off.round(4)).note


@pytest.mark.parametrize(("chance", "believed"), [(0.0049, True), (0.0051, False)])
def test_a_match_is_believed_if_an_accident_is_less_probable_than_one_in_two_hundred(chance, believed):
    """A point on a sphere of radius R, within ±t of given coordinates: 6t² of 4πR², for each misreading tried."""
    costs = np.add.outer([f.cost for f in all_factors("ZXZ")], [same[0].cost for same in wordings().values()])
    tries = (costs <= 1 + 1e-9).sum()  # no more far-fetched than active elements
    radius = np.sqrt(tries * 6 * 0.05**2 / (4 * np.pi * chance))
    point = radius * np.array([3, 4, 5]) / np.sqrt(50)
    angles = np.array([21.3123456, -47.9654321, 74.6135246])
    found = explain(angles, point, (WRONG["active"](angles) @ point).round(1), decimals=1)
    assert found.explained == believed
    assert not believed or found.misreadings[0].kinds == ("active",)


def test_several_misreadings_are_told_apart():
    found = explain((90, 0, 0), (1, 0, 0), (0, 1, 0))
    assert len(found.misreadings) > 1 and "tell them apart" in found.note
    assert len({reading.sentence for reading in found.misreadings}) == len(found.misreadings)


def test_several_points_must_fit_together():
    points = np.array([POINT, (1, 0, 0), (0, 2, 1)])
    assert explain(SOMEWHERE, points, (points @ turned_frame(SOMEWHERE)).round(3)).right
    mixed = points @ turned_frame(SOMEWHERE)
    mixed[1] = turned_frame(SOMEWHERE) @ points[1]
    assert not explain(SOMEWHERE, points, mixed.round(3)).explained


def test_written_decimals_keep_zeros_of_text():
    assert written_decimals(["4.9500", "2"]) == 4
    assert explain(ANGLES, POINT, ("-4.4907", "4.9497", "2.3094")).tolerance == pytest.approx(0.5e-4, rel=1e-3)


@pytest.mark.parametrize(("too_far", "explained"), [(0.0, True), (0.001, False), (0.03, False)])
def test_more_digits_must_explain_every_coordinate(too_far, explained):
    """Angles rounded to a tenth of a degree, and an answer that is longer, in y and z alone."""
    angles, target = np.array([20.34, -35.27, 50.41]), np.array([0.0, 30.0, 40.0])
    answer = (target * (1 + too_far / 50)).round(5)
    found = explain(angles.round(1), (turned_frame(angles) @ target).round(6), answer)
    assert found.explained == explained


@pytest.mark.parametrize("value", ["nan", "inf", float("nan"), -np.inf, "4,95"])
def test_digits_of_what_is_no_finite_number_are_refused(value):
    with pytest.raises(InputError, match="finite numbers"):
        written_decimals([1.5, value])


@pytest.mark.parametrize(
    ("arguments", "where"),
    [
        (((1, 2), POINT, POINT), "angles"),
        (((1, 2, 3), (0, 0, 0), (0, 0, 0)), "point"),
        (((1, 2, 3), POINT, (1, 2)), "answer"),
        (((1, 2, 3), POINT, (1, 2, float("nan"))), "answer"),
        (((1, 2, 3), POINT, ("1", "2,5", "3")), "answer"),
        (((1, 2, 3), None, POINT), "answer"),
    ],
)
def test_bad_input(arguments, where):
    with pytest.raises(InputError) as raised:
        explain(*arguments)
    assert raised.value.where == where


def test_a_point_at_the_origin_tells_nothing():
    with pytest.raises(InputError, match="a point that a rotation moves"):
        explain(SOMEWHERE, POINT, (0, 0, 0), origin=POINT)


def test_bad_sequence():
    with pytest.raises(InputError, match="ZZX"):
        explain(SOMEWHERE, POINT, POINT, sequence="ZZX")


def test_the_48_products_are_all_different():
    values = matrices([Factors("XYZ")], list(wordings()), SOMEWHERE)[0].reshape(48, 9).round(9)
    assert len(wordings()) == 48 and sum(map(len, wordings().values())) == 384
    assert len(np.unique(values, axis=0)) == 48


# Rotary axes.


def _reachable_axes(kin, count=4, seed=2):
    """Tool axes well inside the reach of any machine, six digits written."""
    rng = np.random.default_rng(seed)
    workpiece_side = kin.inverse_symbolic.workpiece_side
    joints = np.zeros((200, 5))
    joints[:, 3:] = rng.uniform(15, 75, (200, 2))
    assert workpiece_side in kin.symbols[3:]
    axes = kin.forward(joints, degrees=True)[1].round(6)
    return axes[:count]


def _angles(kin, axes, branch=0):
    return kin.inverse(np.zeros(3), axes, degrees=True)[:, branch, 3:]


def test_both_branches_and_any_winding_are_right(kin):
    axes = _reachable_axes(kin)
    for branch in (0, 1):
        turned = _angles(kin, axes, branch) + np.array([0, 360])
        assert explain_joints(kin, axes, turned.round(3), decimals=3).right


@pytest.mark.parametrize("decimals", [2, 4])
def test_the_last_digit_of_the_tool_axis_moves_both_branches_as_far_as_is_said(kin, decimals):
    """The angles of the axis before it was rounded lie within the spread, which is not far too wide."""
    rng, joints, half = np.random.default_rng(8), np.zeros((300, 5)), 0.5 * 10.0**-decimals
    joints[:, 3:] = rng.uniform(20, 70, (300, 2))
    exact = kin.forward(joints, degrees=True)[1]
    printed, branches = exact.round(decimals), np.stack([_angles(kin, exact, branch) for branch in (0, 1)], axis=1)
    both, spread = JointCase(kin, printed, joints[:, 3:], 1e-9, half).both_branches(printed)
    reached = np.isfinite(both + branches).all(axis=(1, 2))
    off = np.abs(wrap(both - branches))[reached]
    assert reached.sum() > 100 and (off <= 1.02 * spread[reached] + 1e-9).all()
    assert (off.max(axis=0) > 0.2 * np.median(spread[reached], axis=0)).all()
    without = JointCase(kin, printed, joints[:, 3:], 1e-9, 0.0).both_branches(printed)[1]
    assert without[reached].max() < 1e-9


@pytest.mark.parametrize("joint", [0, 1])
def test_a_reversed_sign_is_named(kin, joint):
    axes = _reachable_axes(kin)
    wrong = _angles(kin, axes).round(3)
    wrong[:, joint] *= -1
    found = explain_joints(kin, axes, wrong, decimals=3)
    name = kin.machine.rotary[joint].name
    sentences = [reading.sentence for reading in found.misreadings] + [s for r in found.misreadings for s in r.same]
    if not found.right:
        assert any(f"the sign of {name} is reversed" in sentence for sentence in sentences), str(found)


@pytest.mark.parametrize(("off", "right"), [(1.9, True), (2.1, False)])
def test_angles_are_right_if_the_halves_of_both_last_digits_explain_the_tool_axis(dmu50v, off, right):
    """C alone turns the tool axis by its own angle where B lays the tool flat: B180 on this machine."""
    axis, half = dmu50v.forward([[0, 0, 0, 180, 25]], degrees=True)[1], 0.0005
    assert JointCase(dmu50v, axis, np.array([[180, 25 + off * half]]), half, 0.0).makes_the_axis() == right


def test_mixed_branches_exchange_and_radians_are_named(kin):
    axes = _reachable_axes(kin)
    first, second = _angles(kin, axes, 0), _angles(kin, axes, 1)
    mixed = explain_joints(kin, axes, np.stack([first[:, 0], second[:, 1]], axis=1).round(3), decimals=3)
    said = " ".join([r.sentence for r in mixed.misreadings] + [s for r in mixed.misreadings for s in r.same])
    assert mixed.right or "branches" in said
    assert "exchange" in explain_joints(kin, axes, first[:, ::-1].round(3), decimals=3).misreadings[0].kinds
    assert set(explain_joints(kin, axes, np.deg2rad(first).round(5), decimals=5).misreadings[0].kinds) == {"unit"}


def test_degrees_are_not_taken_for_radians_because_the_tool_axis_is_rounded(kin):
    axis, angles = np.round([(0.6, -0.35, 0.7194)], 2), [(40.125, 60.875)]
    if np.isfinite(_angles(kin, axis)).all():
        found = explain_joints(kin, axis, angles, decimals=3).misreadings
        assert not any("unit" in reading.kinds for reading in found)


def test_table_2_of_source_002_has_no_reading(dmu50v):
    axis = [(0.145196, 0, 0.989403), (0.05817, 0, 0.998307), (-0.028804, 0, 0.999585), (-0.114263, 0, 0.993451),
            (-0.275502, 0, 0.9613)]  # fmt: skip
    table = [(11.817, 166.559), (4.716, 178.52), (2.335, 1.144), (9.284, 3.251), (22.691, 8.078)]
    found = explain_joints(dmu50v, axis, table)
    assert not found.explained
    assert found.note.startswith("B alone: right. C: no misreading gives it. Right is B 11.8172 C 175.8146")
    for row, angles in zip(axis, table, strict=True):
        assert not explain_joints(dmu50v, row, angles).explained


def test_at_the_pole_any_workpiece_side_angle_is_right(dmu50v):
    assert explain_joints(dmu50v, (0, 0, 1), (0, 77)).right


def test_every_wording_says_its_own_product():
    values = matrices([Factors("ZXZ")], list(wordings()), SOMEWHERE)[0]
    for matrix, same in zip(values, wordings().values(), strict=True):
        for wording in same:
            said = np.eye(3)
            for n in wording.order:
                active = _single("ZXZ"[n], wording.signs[n] * SOMEWHERE[n])
                said = said @ (active if wording.active else active.T)
            result = (said.T if wording.transposed else said) @ POINT
            np.testing.assert_allclose(matrix @ POINT, result, atol=1e-12)
