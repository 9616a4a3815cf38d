"""The chain and its inverse: round trips, the pole, the edge of reach, and a chain built without the package."""

import numpy as np
import pytest
import sympy as sp
from hypothesis import HealthCheck, given, settings
from scipy.spatial.transform import Rotation

from mathpost import chain, formula, load_machine, machine_file, rotation
from mathpost.errors import InputError
from mathpost.kinematics import ABOVE, BELOW, Kinematics
from tests.conftest import FIVE_AXES
from tests.machines import SIDES, content, machines, random_joints, with_slides

TIP, AXIS = 1e-9, 1e-12  # mm, rad
ASKEW = {  # no component of any direction is zero, so that no term of a formula is
    f"askew, axes carry {' and '.join(sides)}": content(
        (2, -1, 2), (1, 3, -2), sides, point=((10, -20, 30), (-40, 50, 60)), origin=(5, -6, 7), tool=(1, -2, 2),
        length=80, programmed=[3, 4, -5])
    for sides in SIDES
}  # fmt: skip


@pytest.fixture(scope="module", params=[*FIVE_AXES, *ASKEW], ids=lambda given: getattr(given, "stem", given))
def kin(request):
    """The kinematics of each machine in data/machines with two rotary axes, and of machines askew."""
    given = request.param
    return Kinematics(machine_file.from_dict(ASKEW[given]) if given in ASKEW else load_machine(given))


def assert_round_trip(kin, joints):
    """Both branches lead back to the pose of `joints`, and one of them is `joints` itself where not singular."""
    tip, axis = kin.forward(joints)
    back = kin.inverse(tip, axis)
    assert not np.isnan(back).any()
    tips, axes = kin.forward(back)
    assert np.linalg.norm(tips - tip[..., None, :], axis=-1).max() < TIP
    assert np.linalg.norm(axes - axis[..., None, :], axis=-1).max() < AXIS


def pose_by_scipy(machine, joints):
    """Tip and tool axis in the workpiece, the chain composed of SciPy's rotations, point by point from the nose."""
    angle = dict(zip(machine.joint_names, joints.T, strict=True))

    def turn(rotary, points, sense=1):
        axis = np.array(rotary.axis) / np.linalg.norm(rotary.axis)
        rotation = Rotation.from_rotvec(sense * angle[rotary.name][:, None] * axis)
        return rotation.apply(points - rotary.point) + rotary.point

    tool = np.array(machine.tool_axis) / np.linalg.norm(machine.tool_axis)
    tip = np.tile(-machine.tool_length * tool, (len(joints), 1))
    above = tip + tool
    programmed = {"tip": tip[0], "nose": np.zeros(3)}.get(str(machine.programmed_point))
    programmed = np.array(machine.programmed_point) if programmed is None else programmed
    for rotary in reversed([r for r in machine.rotary if r.carries == "tool"]):
        tip, above = turn(rotary, tip), turn(rotary, above)
    slide = joints[:, :3] + np.array(machine.origin) - programmed
    tip, above = tip + slide, above + slide
    for rotary in [r for r in machine.rotary if r.carries == "workpiece"]:
        tip, above = turn(rotary, tip, -1), turn(rotary, above, -1)
    return tip - machine.origin, above - tip


STEPS = {  # what is zero at the joints of a pose, in what `derive` finds
    "the equation of the tool-side angle": lambda made, xyz: [made.equation.lhs - made.equation.rhs],
    "the two solutions": lambda made, xyz: [
        sp.prod(sp.sin((solution - made.tool_side) / 2) for solution in made.solutions)
    ],
    "the sense of the workpiece-side angle": lambda made, xyz: [
        sp.sin((sp.atan2(*made.turn) - made.workpiece_side) / 2)
    ],
    "X Y Z that close the loop": lambda made, xyz: [found - q for found, q in zip(made.linear, xyz, strict=True)],
}


@pytest.mark.parametrize("step", STEPS)
def test_each_step_of_the_inverse_holds_at_the_joints_of_a_pose(kin, step):
    """Poses are SciPy's."""
    made, joints = kin.inverse_symbolic, random_joints(kin, 90, seed=6)[50:]
    tip, axis = pose_by_scipy(kin.machine, joints)
    names = (*made.tip, *made.axis, BELOW, ABOVE, *kin.symbols)
    evaluate = sp.lambdify(names, sp.Matrix(STEPS[step](made, kin.symbols[:3])), "numpy")
    values = np.vstack([tip.T, axis.T, kin.reach_terms(axis), joints.T])
    np.testing.assert_allclose([evaluate(*row).ravel() for row in values.T], 0, atol=1e-7)


def test_forward_of_inverse(kin):
    assert_round_trip(kin, random_joints(kin, 10_000, seed=1))


@settings(max_examples=6, deadline=None, suppress_health_check=list(HealthCheck))
@given(machines())
def test_forward_of_inverse_on_any_machine(any_machine):
    kin = Kinematics(any_machine)
    assert_round_trip(kin, random_joints(kin, 400, seed=2))


def test_both_branches_differ_and_the_first_tilts_up(kin):
    joints = random_joints(kin, 200, seed=3)[50:]
    branches = kin.inverse(*kin.forward(joints))
    tool_side = kin.symbols.index(kin.inverse_symbolic.tool_side)
    middle = float(sum(kin.inverse_symbolic.solutions) / 2)
    tilt = (branches[..., tool_side] - middle + np.pi) % (2 * np.pi) - np.pi
    assert (tilt[:, 0] > 0).all() and np.allclose(tilt[:, 0], -tilt[:, 1])


def test_forward_against_scipy_rotations(kin):
    joints = random_joints(kin, 300, seed=4)
    tip, axis = kin.forward(joints)
    np.testing.assert_allclose(tip, pose_by_scipy(kin.machine, joints)[0], atol=1e-9)
    np.testing.assert_allclose(axis, pose_by_scipy(kin.machine, joints)[1], atol=1e-12)


def test_symbolic_and_compiled_forms_agree(kin):
    joints = random_joints(kin, 100, seed=5)[25:28]
    for row, tip, axis in zip(joints, *kin.forward(joints), strict=True):
        matrix = kin.forward_symbolic().subs(dict(zip(kin.symbols, row, strict=True))).evalf(30)
        np.testing.assert_allclose(np.array(matrix[:3, 3], float).ravel(), tip, atol=1e-11)
        np.testing.assert_allclose(np.array(matrix[:3, 2], float).ravel(), axis, atol=1e-14)


def parameters(kin):
    """The symbols of the machine's offsets and directions and their values."""
    symbols, numbers = chain.Geometry.symbols(kin.machine), chain.Geometry.numbers(kin.machine)
    pairs = zip(symbols.flat(), numbers.flat(), strict=True)
    return {symbol: number for symbol, number in pairs if symbol.is_Symbol}


def test_parameters_put_numbers_in_the_place_of_symbols(kin):
    general = kin.forward_symbolic(parameters=True)
    assert general.free_symbols > set(kin.symbols)
    values = {symbol: sp.N(value, 30) for symbol, value in parameters(kin).items()}
    values |= dict(zip(kin.symbols, (3, -4, 5, sp.Rational(1, 3), sp.Rational(-7, 5)), strict=True))
    difference = general.xreplace(values) - kin.forward_symbolic().xreplace(values)
    assert max(abs(entry) for entry in difference.evalf(20)) < 1e-12


def test_below_and_above_are_r_minus_d_and_r_plus_d(kin):
    """The half-angle form is the classical one: r ∓ D, with i² + j² + k² = 1."""
    derived = kin.inverse_symbolic
    cosine, sine = (derived.equation.lhs.coeff(f(derived.tool_side)) for f in (sp.cos, sp.sin))
    r, d = sp.sqrt(cosine**2 + sine**2), derived.equation.rhs
    for axis in ((0.36, 0.48, 0.8), (-0.6, 0, -0.8), (0, 1, 0)):
        values = dict(zip(derived.axis, map(sp.Float, axis), strict=True))
        assert float((derived.below - (r - d)).subs(values)) == pytest.approx(0, abs=1e-14)
        assert float((derived.above - (r + d)).subs(values)) == pytest.approx(0, abs=1e-14)


def test_links_hold_numbers_unless_asked_for_symbols(kin):
    for links, free in (
        (kin.links(), set(kin.symbols)),
        (kin.links(parameters=True), {*kin.symbols, *parameters(kin)}),
    ):
        found = set().union(*(link.matrix.free_symbols for link in links))
        assert found <= free and (found - set(kin.symbols) != set()) == (free != set(kin.symbols))


@pytest.mark.parametrize("under", ["", "Y", "ZX"])
def test_a_joint_moves_the_bodies_that_it_carries_and_no_other(kin, under):
    """Slides by a mm, against their word under the workpiece; rotary axes about their lines, turned by SciPy."""
    made = with_slides(kin.machine, under, "".join(name for name in "XYZ" if name not in under))
    names, matrices = zip(*chain.bodies(made), strict=True)
    placed = formula.numeric(sp.ImmutableMatrix.vstack(*matrices), kin.symbols)
    zero = placed(*np.zeros(5)).reshape(-1, 4, 4)
    half = names.index("workpiece") + 1
    nose = zero[-1, :3, 3] + made.tool_length * rotation.unit(np.array(made.tool_axis))
    for joint, (name, step) in enumerate(zip(made.joint_names, (1, 1, 1, 0.3, 0.3), strict=True)):
        moved, expected = placed(*step * np.eye(5)[joint]).reshape(-1, 4, 4), np.tile(np.eye(4), (len(names), 1, 1))
        own = names.index(name)
        carried = slice(own, half if own < half else None)
        if joint < 3:
            expected[carried, joint, 3] = -1 if own < half else 1
        else:
            rotary = made.rotary[joint - 3]
            turned = Rotation.from_rotvec(step * rotation.unit(np.array(rotary.axis))).as_matrix()
            point = np.array(rotary.point) + (0 if own < half else nose)
            expected[carried, :3, :3], expected[carried, :3, 3] = turned, point - turned @ point
        np.testing.assert_allclose(moved @ np.linalg.inv(zero), expected, atol=1e-9)
    np.testing.assert_allclose(
        np.linalg.inv(zero[half - 1]) @ zero[-1] @ [0, 0, 0, 1], [*kin.forward(np.zeros(5))[0], 1]
    )
    np.testing.assert_allclose(zero[half - 1, :3, 3], made.origin, atol=1e-12)


def test_pole_gives_the_workpiece_side_angle_zero(kin):
    pole = np.array(kin.inverse_symbolic.pole, float)
    if kin.reach[0] > 0:
        pytest.skip("does not apply: the pole is out of reach")
    joints = kin.inverse([1, 2, 3], pole)
    assert (joints[:, kin.symbols.index(kin.inverse_symbolic.workpiece_side)] == 0).all()
    np.testing.assert_allclose(kin.forward(joints)[1], [pole, pole], atol=1e-15)


def test_out_of_reach_is_nan(dmu50v):
    reached = dmu50v.inverse(np.zeros((3, 3)), [[1, 0, 0], [1, 0, -1e-9], [0, 0, -1]])
    assert not np.isnan(reached[0]).any() and np.isnan(reached[1:]).all()
    assert dmu50v.reach == pytest.approx((0, np.pi / 2))
    # At the edge what rounding leaves is reached, and a thousandth of a billionth of a radian more is not.
    assert not np.isnan(dmu50v.inverse([0, 0, 0], [1, 0, -1e-16])).any()
    assert np.isnan(dmu50v.inverse([0, 0, 0], [1, 0, -1e-13])).all()


def test_reach_is_what_forward_attains():
    """A tool at 16.26° from an axis at 36.87° from the workpiece-side one, whose other end is the pole."""
    kin = Kinematics(machine_file.from_dict(content((0, 0, 1), (3, 0, 4), SIDES[2], tool=(4, 0, 3))))
    joints = np.zeros((721, 5))
    joints[:, 4] = np.linspace(-np.pi, np.pi, 721)
    angles = np.arccos(kin.forward(joints)[1] @ np.array(kin.inverse_symbolic.pole, float))
    assert kin.reach == pytest.approx((angles.min(), angles.max()), abs=1e-12)
    assert np.degrees(kin.reach) == pytest.approx((180 - 36.8699 - 16.2602, 180 - 36.8699 + 16.2602), abs=1e-3)


def test_work_in_slices_changes_nothing(kin, monkeypatch):
    """Any shape, cut anywhere, with poles and unreachable axes among the rest."""
    joints = random_joints(kin, 60, seed=7).reshape(3, 20, 5)
    tip, axis = kin.forward(joints)
    axis[1, 3] = -np.array(kin.inverse_symbolic.pole, float)
    whole = kin.inverse(tip, axis)
    monkeypatch.setattr(formula, "SLICE", 7)
    for cut, uncut in ((kin.inverse(tip, axis), whole), (kin.forward(joints)[0], tip)):
        np.testing.assert_allclose(cut, uncut, rtol=1e-14, atol=1e-12)
    with pytest.raises(InputError, match=r"length zero at index \(2, 5\)"):
        kin.inverse(tip, np.where(np.arange(60).reshape(3, 20, 1) == 45, 0, axis))


def test_no_angle_is_minus_half_a_turn(kin):
    """The ends of the range: straight up, straight down and a quarter round, on both branches."""
    axes = np.concatenate([np.eye(3), -np.eye(3)])
    rotary = kin.inverse(np.zeros(3), axes)[..., 3:]
    assert not (rotary <= -np.pi).any() and not (rotary > np.pi).any()


def test_axis_that_is_unit_only_to_the_printed_digits(dmu50v):
    axis = np.array([0.145196, 0, 0.989403])
    np.testing.assert_allclose(dmu50v.inverse([1, 2, 3], axis), dmu50v.inverse([1, 2, 3], axis * 7), atol=1e-13)


def test_degrees(kin):
    joints = random_joints(kin, 100, seed=6)[25:]
    tip, axis = kin.forward(joints)
    degrees = kin.inverse(tip, axis, degrees=True)
    np.testing.assert_allclose(np.deg2rad(degrees[..., 3:]), kin.inverse(tip, axis)[..., 3:], atol=1e-15)
    np.testing.assert_allclose(kin.forward(degrees, degrees=True)[0], np.stack([tip, tip], axis=1), atol=1e-9)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda kin: kin.forward([1, 2, 3]), "joints"),
        (lambda kin: kin.forward([1, 2, 3, 4, float("inf")]), "finite"),
        (lambda kin: kin.forward("north"), "north"),
        (lambda kin: kin.inverse([1, 2, 3], [0, 0, 0]), "length zero"),
        (lambda kin: kin.inverse([1, 2], [0, 0, 1]), "tip"),
        (lambda kin: kin.inverse([1, 2, 3], [0, float("nan"), 1]), "finite"),
    ],
)
def test_wrong_arguments_are_refused(dmu50v, call, words):
    with pytest.raises(InputError, match=words):
        call(dmu50v)


def test_a_pose_is_solved_to_the_same_bits_whatever_stands_beside_it(kin):
    """A path may be cut anywhere: what decides between equals must not depend on where a pose stands."""
    rng = np.random.default_rng(11)
    joints = np.concatenate([rng.uniform(-200, 200, (40, 3)), rng.uniform(-1.5, 1.5, (40, 2))], axis=1)
    tip, axis = kin.forward(joints)
    whole = kin.inverse(tip, axis)
    for size in (1, 2, 3, 5, 8, 15, 17):
        for first in range(40 - size):
            part = slice(first, first + size)
            np.testing.assert_array_equal(kin.inverse(tip[part], axis[part]), whole[part])
            np.testing.assert_array_equal(kin.forward(joints[part])[0], tip[part])
