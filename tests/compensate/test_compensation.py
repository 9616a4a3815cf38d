"""Compensation: the worked example, every machine, the singular position, and the exact inverse."""

import numpy as np
import pytest

from mathpost import load_machine
from mathpost.kinematics import Kinematics
from mathpost.shop.compensate.compensation import CalibratedKinematics, Compensator, PoseError, total_differential
from mathpost.shop.compensate.model import ErrorModel, MachineErrors, constant_errors, read_errors
from tests.machines import with_slides

ARCSEC = np.rad2deg(1) * 3600


@pytest.fixture(scope="module")
def two_tables():
    errors = read_errors("data/errors/bohez.toml", load_machine("data/errors/bohez_machine.toml"))
    return Compensator(errors)


def at(a, c=70.0):
    return np.array([40, -25, 30, np.deg2rad(a), np.deg2rad(c)])


def random_errors(seed, model):
    lengths = np.array([name[1] in "XYZ" for name in model.names])
    return np.random.default_rng(seed).normal(size=33) * np.where(lengths, 0.02, 5e-5)


def away_from_the_pole(seed, kin, count=40):
    """Joints whose tool-side axis tilts the tool by at least some 20 degrees."""
    rng = np.random.default_rng(seed)
    joints = np.column_stack([rng.uniform(-150, 150, (count, 3)), rng.uniform(-3, 3, (count, 2))])
    tool_side = 3 + [symbol.name for symbol in kin.symbols[3:]].index(kin.inverse_symbolic.tool_side.name)
    joints[:, tool_side] = rng.uniform(0.5, 1.2, count)
    return joints


def test_what_is_missed_is_said_in_micrometres_and_arc_seconds():
    missed = PoseError(np.array([0.001, 0.003]), np.radians([1 / 3600, 2 / 3600]))
    tip, axis = "tip 2.000 µm on average, 3.000 µm at most", "tool axis 1.50 arcsec on average, 2.00 arcsec at most"
    assert str(missed) == f"{tip}; {axis}"


def test_the_pose_of_the_example(two_tables):
    tip, axis = two_tables.wanted(at(35))
    np.testing.assert_allclose(tip, [49.0942, 24.6983, 10.2352], rtol=0, atol=5e-5)
    np.testing.assert_allclose(axis, [0.538986, -0.196175, 0.819152], rtol=0, atol=5e-7)


def test_the_error_of_the_example_and_its_first_order(two_tables):
    (tip, axis), (wanted_tip, wanted_axis) = two_tables.forward(at(35)), two_tables.wanted(at(35))
    np.testing.assert_allclose(1e3 * (tip - wanted_tip), [13.4770, 2.06965, -18.7617], rtol=0, atol=5e-5)
    missed = two_tables.miss(at(35))
    assert 1e3 * missed.tip == pytest.approx(23.1930, abs=5e-5)
    assert missed.axis * ARCSEC == pytest.approx(9.78603, abs=5e-6)
    first = two_tables.model.sensitivities(at(35)) @ two_tables.errors.constant
    assert 1e6 * np.linalg.norm(tip - wanted_tip - first[:3]) == pytest.approx(0.439740, abs=1e-6)
    assert np.linalg.norm(axis - wanted_axis - first[3:]) * ARCSEC == pytest.approx(0.000332393, abs=1e-9)


def test_one_step_of_the_total_differential(two_tables):
    wanted, joints = two_tables.wanted(at(35)), at(35)
    step, limited = total_differential(two_tables.model, joints, two_tables.errors.constant)
    np.testing.assert_allclose(1e3 * step[:3], [-9.65437, 18.0097, 10.5231], rtol=0, atol=5e-5)
    np.testing.assert_allclose(np.rad2deg(step[3:]), [0.000286479, 0.00471298], rtol=0, atol=5e-9)
    after = two_tables.miss(joints + step, wanted)
    assert 1e6 * after.tip == pytest.approx(0.337020, abs=1e-5)
    assert after.axis * ARCSEC == pytest.approx(0.000519792, abs=1e-8)
    assert not limited


def test_a_second_step_from_what_is_left(two_tables):
    wanted, joints = two_tables.wanted(at(35)), at(35)
    joints = joints + total_differential(two_tables.model, joints, two_tables.errors.constant)[0]
    missed = np.concatenate(two_tables.forward(joints)) - np.concatenate(wanted)
    joints = joints - np.linalg.lstsq(two_tables.model.jacobian(joints), missed)[0]
    assert two_tables.miss(joints, wanted).tip < 1e-10


def test_near_the_singular_position_the_step_does_harm(two_tables):
    joints, wanted = at(0.01), two_tables.wanted(at(0.01))
    step, _ = total_differential(two_tables.model, joints, two_tables.errors.constant)
    assert np.rad2deg(step[4]) == pytest.approx(6.56905, abs=5e-6)
    assert 1e3 * two_tables.miss(joints, wanted).tip == pytest.approx(28.2913, abs=5e-5)
    assert 1e3 * two_tables.miss(joints + step, wanted).tip == pytest.approx(309.524, abs=5e-4)


def test_there_it_is_limited_and_said(two_tables):
    result = two_tables.compensate(at(0.01))
    assert result.limited and not result.refused
    assert result.after.tip < 1e-4 < result.before.tip
    assert result.after.axis < result.before.axis
    assert np.abs(result.joints - at(0.01))[3:].max() <= np.sqrt(2) * two_tables.max_turn
    assert "1 of 1 points stand too near the singular position" in str(result)


def test_without_a_limit_it_is_refused_and_said(two_tables):
    unlimited = Compensator(constant_errors(two_tables.errors.machine, {}), max_turn=np.inf)
    unlimited = unlimited.with_drift(two_tables.errors.constant)
    result = unlimited.compensate([at(35), at(0.01)])
    assert result.refused.tolist() == [False, True]
    np.testing.assert_array_equal(result.joints[1], at(0.01))
    assert result.after.tip[1] == result.before.tip[1]
    assert "1 of 2 points stay as programmed" in str(result)


def test_constants_are_taken_out_exactly(two_tables):
    result = two_tables.compensate(at(35))
    assert result.after.tip < 1e-10 and result.after.axis < 1e-10


def test_any_machine_comes_where_it_was_meant_to(kin, model):
    constant, drift = random_errors(5, model), random_errors(6, model)
    compensator = Compensator(MachineErrors(kin.machine, constant, drift=drift))
    result = compensator.compensate(away_from_the_pole(7, kin))
    assert result.before.tip.min() > 1e-3
    assert result.after.tip.max() < 2e-4 and result.after.axis.max() < 3e-7
    assert not result.limited.any() and not result.refused.any()
    tip, axis = compensator.forward(result.joints)
    ideal_tip, ideal_axis = kin.forward(away_from_the_pole(7, kin))
    np.testing.assert_allclose(tip, ideal_tip, rtol=0, atol=2e-4)
    np.testing.assert_allclose(axis, ideal_axis, rtol=0, atol=3e-7)


@pytest.mark.parametrize("name", ["bc_table", "nutating_head_table", "ac_head"])
def test_exact_inverse_of_constant_errors(name):
    kin = Kinematics(with_slides(load_machine(f"data/machines/{name}.toml"), "YX", "Z"))
    model = ErrorModel(kin.machine)
    errors = 20 * random_errors(8, model)
    joints = away_from_the_pole(9, kin, 10)
    pose = model.forward(joints, errors)
    both = CalibratedKinematics(model, errors).inverse(*pose)
    for real, wanted in zip(model.forward(both, errors), pose, strict=True):
        np.testing.assert_allclose(real, np.broadcast_to(wanted[:, None], real.shape), rtol=0, atol=1e-11)
    apart = (both - joints[:, None] + np.pi) % (2 * np.pi) - np.pi
    np.testing.assert_allclose(np.abs(apart[..., 3:]).max(-1).min(-1), 0, rtol=0, atol=1e-11)


def test_a_path_through_the_pole_has_no_jump(two_tables):
    tilt = np.linspace(-3, 3, 2401)
    joints = np.array([at(a) for a in tilt])
    result = two_tables.compensate(joints)
    assert result.limited.any() and not result.limited.all() and not result.refused.any()
    assert result.after.tip.max() < 2e-4
    change = result.joints - joints
    steps = np.abs(np.diff(change, axis=0))
    assert np.rad2deg(steps[:, 3:].max()) < 0.001 and steps[:, :3].max() < 0.001


@pytest.mark.parametrize("group", ["constant", "drift"])
@pytest.mark.parametrize("tilt", [35, 0.01, 0])
def test_an_axis_own_error_is_taken_out_by_that_axis_whatever_its_size(two_tables, group, tilt):
    errors = constant_errors(two_tables.errors.machine, {"ECC": 5e-3, "EAA": -4e-3}).constant
    none = np.zeros(33)
    both = {"constant": none} | {group: errors}
    compensator = Compensator(MachineErrors(two_tables.errors.machine, **both))
    result = compensator.compensate(at(tilt))
    assert not result.limited
    np.testing.assert_allclose(result.joints[3:] - at(tilt)[3:], [-4e-3, 5e-3], rtol=0, atol=1e-4)
    assert result.after.tip < 1e-9 if group == "constant" and tilt else result.after.tip < 3e-3 < result.before.tip


def test_great_errors_away_from_the_singular_position_are_not_limited(two_tables):
    errors = constant_errors(two_tables.errors.machine, {"EBC": 3e-3, "EAC": 2e-3})
    result = Compensator(errors).compensate(at(35))
    assert not result.limited and result.after.tip < 1e-9


def test_costs_are_what_each_error_does_alone(two_tables):
    costs = two_tables.costs([at(35), at(0.01)])
    assert len(costs) == 14
    assert list(costs) == sorted(costs, key=lambda name: -costs[name].max())
    wanted, _ = two_tables.wanted([at(35), at(0.01)])
    for name, cost in costs.items():
        alone = np.where(np.array(two_tables.model.names) == name, two_tables.errors.constant, 0)
        tip, _ = two_tables.model.forward([at(35), at(0.01)], alone)
        np.testing.assert_allclose(np.linalg.norm(tip - wanted, axis=-1), cost, rtol=1e-3, atol=1e-6)
