"""The work offset after a turn: worked numbers, every stack and sign against SciPy, and the macro's arguments."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from mathpost.errors import InputError
from mathpost.machine import Rotary
from mathpost.shop.measure import work_offset

CENTRE_A, CENTRE_B = (0, -200, -850), (-350, 0, -900)
OLD = work_offset.WorkOffset("G54", X=-300, Y=-250, Z=-600)


def table(order="AB", iso=True):
    return work_offset.ab_table(CENTRE_A, CENTRE_B, order=order, iso=iso)


@pytest.mark.parametrize(
    ("order", "iso", "start", "end", "expected"),
    [
        ("AB", True, (0, 0), (-30, 10), (-352.854066, -370.363638, -654.921524)),
        ("BA", True, (0, 0), (-30, 10), (-342.696750, -368.301270, -653.480264)),
        ("AB", False, (0, 0), (-30, 10), (-248.665159, -124.921312, -619.959897)),
        ("BA", False, (0, 0), (-30, 10), (-250.140066, -118.301270, -621.604694)),
        ("AB", True, (20, -40), (-30, 10), (-523.024, -394.967, -777.287)),
        ("AB", True, (0, 0), (0, 90), (-650, -250, -850)),
        ("BA", True, (0, 0), (0, 90), (-650, -250, -850)),
    ],
)
def test_worked_numbers(order, iso, start, end, expected):
    start, end = (dict(zip("AB", angles, strict=True)) for angles in (start, end))
    after = work_offset.moved((-300, -250, -600), table(order, iso), start, end, degrees=True)
    np.testing.assert_allclose(after, expected, atol=6e-7 if start["A"] == 0 else 6e-4)


@pytest.mark.parametrize("order", ["AB", "BA"])
@pytest.mark.parametrize(("height", "slip"), [(-900, 25.8819), (-850, 8.71557)])
def test_the_cost_of_one_common_centre(order, height, slip):
    common = (-350, -200, height)
    right, wrong = table(order), work_offset.ab_table(common, common, order=order)
    start, end = {"A": 0, "B": 0}, {"A": -30, "B": 10}
    pair = [work_offset.moved((-300, -250, -600), t, start, end, degrees=True) for t in (right, wrong)]
    assert np.linalg.norm(pair[0] - pair[1]) == pytest.approx(slip, abs=6e-5)


angles = st.floats(-360, 360)
points = st.tuples(*[st.floats(-1000, 1000)] * 3)
directions = points.filter(lambda v: np.linalg.norm(v) > 1e-3)


@settings(deadline=None, max_examples=30)
@given(st.tuples(directions, directions), st.tuples(points, points), points, st.tuples(*[angles] * 4))
def test_any_two_axes_against_scipy(axes, centres, point, angles):
    axes = [tuple(np.round(np.array(a) / np.linalg.norm(a), 3).tolist()) for a in axes]
    stack = tuple(Rotary(n, "workpiece", a, c) for n, a, c in zip("UV", axes, centres, strict=True))
    start, end = dict(zip("UV", angles[:2], strict=True)), dict(zip("UV", angles[2:], strict=True))

    def turned(p, axis, angle):
        axis, unit = np.array(axis.point), np.array(axis.axis) / np.linalg.norm(axis.axis)
        return axis + Rotation.from_rotvec(np.deg2rad(angle) * unit).apply(p - axis)

    expected = turned(turned(np.array(point), stack[0], -start["U"]), stack[1], -start["V"])
    expected = turned(turned(expected, stack[1], end["V"]), stack[0], end["U"])
    np.testing.assert_allclose(work_offset.moved(point, stack, start, end, degrees=True), expected, atol=1e-8)
    back = work_offset.moved(expected, stack, end, start, degrees=True)
    np.testing.assert_allclose(back, point, atol=1e-8)


def test_the_tip_follows_the_moved_point(kin):
    """On a table-table machine X Y Z of the inverse are the moved point, seen from the work offset."""
    if kin.machine.arrangement != "table-table":
        pytest.skip("does not apply: the workpiece does not carry both axes")
    rng = np.random.default_rng(5)
    tip, axis = rng.uniform(-50, 50, (20, 3)), rng.normal(size=(20, 3)) * 0.2 + [0, 0, 1]
    joints = kin.inverse(tip, axis)[:, 0]
    names = [rotary.name for rotary in kin.machine.rotary]
    end = dict(zip(names, joints[:, 3:].T, strict=True))
    after = work_offset.moved(tip + kin.machine.origin, kin.machine.rotary, dict.fromkeys(names, 0), end)
    np.testing.assert_allclose(after - kin.machine.origin, joints[:, :3], atol=1e-9)


def test_the_face_that_looks_at_the_spindle_at_b90_is_plus_x():
    face = np.array([[0, 0, 0], [1, 0, 0]])
    turned = work_offset.moved(face, table(), {"A": 0, "B": 0}, {"A": 0, "B": 90}, degrees=True)
    np.testing.assert_allclose(turned[1] - turned[0], [0, 0, 1], atol=1e-12)


def test_the_program_of_the_source():
    new = work_offset.p9795(table(), OLD, **work_offset.read_call("G65P9795X0Y0Z0A0B0D-30.E10.S55"))
    np.testing.assert_allclose(new.after, (-352.854066, -370.363638, -654.921524), atol=6e-7)
    assert new.block == "G90 G10 L2 P2 X-352.854 Y-370.364 Z-654.922"
    assert new.angles == {"A": -30, "B": 10}


def test_offsets_of_the_rotary_axes_and_the_point_count():
    old = work_offset.WorkOffset("G56", X=-310, Y=-260, Z=-590, A=5, B=-15)
    new = work_offset.p9795(table("BA"), old, X=10, Y=10, Z=-10, A=1, B=2, D=-30, E=10)
    expected = work_offset.moved(
        (-300, -250, -600), table("BA"), {"A": 6, "B": -13}, {"A": -25, "B": -5}, degrees=True
    )
    np.testing.assert_allclose(new.after, expected, atol=1e-12)
    assert new.angles == {"B": -5, "A": -25} and new.block.startswith("G90 G10 L2 P3 X-")
    current = {"X": 10, "Y": 10, "Z": -10, "A": 1, "B": 2}
    assert work_offset.p9795(table("BA"), old, D=-30, E=10, current=current).block == new.block


def test_extra_shift_along_the_machine_or_with_the_part():
    arguments = {"X": 0, "Y": 0, "Z": 0, "A": 0, "B": 0, "D": 0, "E": 90, "S": "54.1 P7"}
    plain, machine, part = (
        work_offset.p9795(table(), OLD, **arguments, **extra)
        for extra in ({}, {"U": 1, "V": 2, "W": 3}, {"U": 1, "V": 2, "W": 3, "shift": "part"})
    )
    np.testing.assert_allclose(machine.after - plain.after, [1, 2, 3], atol=1e-12)
    np.testing.assert_allclose(part.after - plain.after, [-3, 2, 1], atol=1e-12)
    assert plain.block == "G90 G10 L20 P7 X-650.000 Y-250.000 Z-850.000"


def test_a_table_with_b_alone():
    alone = (table()[1],)
    new = work_offset.p9795(alone, OLD, X=0, Y=0, Z=0, B=0, E=90)
    np.testing.assert_allclose(new.after, [-650, -250, -850], atol=1e-9)
    with pytest.raises(InputError, match="D: expected no angle: the table has no A axis, found 5"):
        work_offset.p9795(alone, OLD, X=0, Y=0, Z=0, B=0, D=5, E=90)


def test_the_symbolic_point_is_what_runs():
    for order, iso in itertools.product(("AB", "BA"), (True, False)):
        expressions, symbols = work_offset.moved_symbolic(table(order, iso))
        centres = {"A": CENTRE_A, "B": CENTRE_B}
        values = [-300, -250, -600] + [v for name in order for v in (*centres[name], 0.1, 0.2)]
        by_hand = [float(e.subs(dict(zip(symbols, values, strict=True)))) for e in expressions]
        start, end = dict.fromkeys("AB", 0.1), dict.fromkeys("AB", 0.2)
        np.testing.assert_allclose(work_offset.moved((-300, -250, -600), table(order, iso), start, end), by_hand)


def test_arrays_broadcast():
    after = work_offset.moved(np.zeros((4, 1, 3)), table(), {"A": 0, "B": 0}, {"A": [0, 1, 2], "B": 0.5})
    assert after.shape == (4, 3, 3)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"Y": 0, "Z": 0, "A": 0, "B": 0, "D": 1, "E": 2}, "X: expected a number, found nothing"),
        ({"X": 0, "Y": 0, "Z": 0, "A": 0, "B": 0, "D": 1}, "E: expected a number, found nothing"),
        ({"X": "0", "Y": 0, "Z": 0, "A": 0, "B": 0, "D": 1, "E": 2}, "X: expected a number, found '0'"),
        ({"X": 0, "Y": 0, "Z": 0, "A": 0, "B": 0, "D": 1, "E": np.nan}, "E: expected a number, found nan"),
        ({"X": 0, "Y": 0, "Z": 0, "A": 0, "B": 0, "D": 1, "E": 2, "S": 53}, "S: expected 54 to 59"),
        ({"X": 0, "Y": 0, "Z": 0, "A": 0, "B": 0, "D": 1, "E": 2, "S": "54.1 P0"}, "S: expected 54 to 59"),
        (work_offset.read_call("G65P9795X0Y0Z0A0B0D1.E2.S54.1"), "S: expected 54 to 59, or 54.1 P and a number"),
        ({"X": 0, "Y": 0, "Z": 0, "A": 0, "B": 0, "D": 1, "E": 2, "shift": "tool"}, "shift: expected"),
    ],
)
def test_bad_arguments(arguments, message):
    with pytest.raises(InputError) as error:
        work_offset.p9795(table(), OLD, **arguments)
    assert message in str(error.value)


@pytest.mark.parametrize(
    ("block", "message"),
    [
        ("G65P9795D-30", "expected a decimal point, D-30., found D-30"),
        ("G65P9795D-30.D5.", "found D twice"),
        ("G65P9795R1.", "found R"),
        ("G65P9796D1.", "expected G65 P9795, found G65 P9796"),
        ("G65P9795D#1", "expected words of a letter and a number"),
    ],
)
def test_bad_calls(block, message):
    with pytest.raises(InputError) as error:
        work_offset.read_call(block)
    assert message in str(error.value)


def test_bad_tables_and_angles():
    with pytest.raises(InputError, match='order: expected "AB" or "BA"'):
        work_offset.ab_table(CENTRE_A, CENTRE_B, order="AC")
    with pytest.raises(InputError, match="end: expected an angle for B, found A"):
        work_offset.moved((0, 0, 0), table(), {"A": 0, "B": 0}, {"A": 0})
    with pytest.raises(InputError, match="carries the workpiece"):
        work_offset.moved((0, 0, 0), (Rotary("B", "tool", (0, 1, 0), (0, 0, 0)),), {"B": 0}, {"B": 0})
