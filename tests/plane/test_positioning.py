"""The tool on a tilted plane: every machine, what is left about Z, and what each control chooses."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from mathpost import euler, machine_file
from mathpost.chain import machine_frames
from mathpost.errors import InputError, ReachError
from mathpost.frame import Frame
from mathpost.kinematics import Kinematics
from mathpost.shop.plane.positioning import align, fanuc, heidenhain, siemens
from mathpost.shop.plane.tilted_plane import Plane
from tests.machines import machines

BETA = np.degrees(np.arccos(1 / np.sqrt(3)))


def build(first, second):
    """A machine from two (name, carries, axis), everything through one point."""
    rotary = [{"name": n, "carries": c, "axis": a, "point": [0, 0, 0]} for n, c, a in (first, second)]
    tool = {"axis": [0, 0, 1], "length": 0, "programmed_point": "tip"}
    content = {"name": "test", "source": "test", "rotary": rotary, "workpiece": {"origin": [0, 0, 0]}, "tool": tool}
    return machine_file.from_dict(content)


def limited(model, **limits):
    """The same machine with other travel, degrees, by rotary axis."""
    new = [
        replace(r, limits=tuple(np.deg2rad(limits[r.name])) if r.name in limits else r.limits) for r in model.rotary
    ]
    return replace(model, rotary=tuple(new))


AC = build(("A", "workpiece", [-1, 0, 0]), ("C", "workpiece", [0, 0, -1]))
BC = build(("B", "workpiece", [0, -1, 0]), ("C", "workpiece", [0, 0, -1]))
AB = build(("B", "workpiece", [0, -1, 0]), ("A", "workpiece", [-1, 0, 0]))
HEAD = build(("B", "tool", [0, 1, 0]), ("A", "tool", [1, 0, 0]))
SKEW = build(("C", "tool", [0, 0, 1]), ("B", "tool", [0, 1, 1]))


def reachable_planes(kin, count=60):
    """Random planes that the machine reaches, made by its own forward kinematics and a random turn about Z."""
    rng = np.random.default_rng(5)
    joints = np.concatenate([rng.uniform(-50, 50, (count, 3)), rng.uniform(-np.pi, np.pi, (count, 2))], axis=1)
    tip, axis = kin.forward(joints)
    return [Frame.from_axes(z, rng.normal(size=3), origin) for origin, z in zip(tip, axis, strict=True)]


def test_tool_stands_on_the_feature_and_rho_is_the_measured_angle(kin):
    for feature in reachable_planes(kin):
        for solution in align(feature, kin).solutions:
            joints = [0, 0, 0, *solution.angles]
            workpiece, tool = machine_frames(kin.machine, joints, degrees=True)
            spindle = (workpiece.inverse() @ tool).rotation
            np.testing.assert_allclose(kin.forward(joints, degrees=True)[1], feature.z, atol=1e-12)
            # ρ measured by SciPy: the rotation left over is about the feature's Z.
            left = Rotation.from_matrix(spindle).inv() * Rotation.from_matrix(feature.rotation)
            expected = Rotation.from_euler("Z", solution.rho, degrees=True)
            assert (left * expected.inv()).magnitude() < 1e-12
            np.testing.assert_array_equal(solution.slides, workpiece.rotation.T)


def test_both_solutions_are_there_and_differ(kin):
    for feature in reachable_planes(kin, 20):
        first, second = align(feature, kin).solutions
        assert np.abs(Rotation.from_matrix(first.spindle.T @ second.spindle).magnitude()) > 1e-6


def test_third_angle_squares_the_spindle(kin):
    for feature in reachable_planes(kin, 20):
        i, j, _ = euler.angles("ZXZ", feature.rotation, degrees=True)
        for n, solution in enumerate(align(feature, kin).solutions):
            squared = Frame(euler.matrix("ZXZ", [i, j, solution.third_angle()], degrees=True), feature.origin)
            np.testing.assert_allclose(squared.z, feature.z, atol=1e-12)
            np.testing.assert_allclose(squared.rotation, solution.spindle, atol=1e-12)
            assert abs(align(squared, kin).solutions[n].rho) < 1e-9


def test_third_angle_lays_a_linear_axis_along_the_feature(kin):
    """Where the axis is in the plane; on a pair of tables all of them are, with the tool along Z."""
    found = 0
    for feature in reachable_planes(kin, 10):
        i, j, _ = euler.angles("ZXZ", feature.rotation, degrees=True)
        for solution in align(feature, kin).solutions:
            for axis, direction in zip("XYZ", solution.slides.T, strict=True):
                for feature_axis in "XY":
                    try:
                        third = solution.third_angle(axis, feature_axis)
                    except ReachError as error:
                        out = np.degrees(np.arcsin(min(abs(direction @ feature.z), 1.0)))
                        assert f"{out:.3f} degrees out of the plane" in str(error)
                        continue
                    new = Frame(euler.matrix("ZXZ", [i, j, third], degrees=True))
                    along = new.x if feature_axis == "X" else new.y
                    np.testing.assert_allclose(along, direction, atol=1e-9)
                    found += 1
    tables = kin.machine.arrangement == "table-table"
    mixed_about_y = kin.machine.name == "B head over a C table"
    assert found == {(True, False): 80, (False, True): 40}.get((tables, mixed_about_y), 0)


# The table of the (1, 1, 1) plane: rotary angles, ρ for K = −90, ρ for K = 0, K for ρ = 0.
TABLE = [
    (AC, (54.735610, 135), -90, 0, 0),
    (AC, (-54.735610, -45), 90, 180, 180),
    (BC, (54.735610, 45), 0, 90, -90),
    (BC, (-54.735610, -135), 180, -90, 90),
    (HEAD, (45, -35.264390), 30, 120, -120),
    (HEAD, (-135, -144.735610), -150, -60, 60),
    (SKEW, (13.826048, 81.100571), -31.173952, 58.826048, -58.826048),
    (SKEW, (-103.826048, -81.100571), -148.826048, -58.826048, 58.826048),
    (AB, (35.264390, -45), 60, 150, -150),
    (AB, (144.735610, 135), -120, -30, 30),
]


@pytest.mark.parametrize(("model", "angles", "with_minus_90", "with_0", "third"), TABLE)
def test_table_of_the_111_plane(model, angles, with_minus_90, with_0, third):
    for k, rho in ((-90, with_minus_90), (0, with_0)):
        solutions = align(Plane("G68.2", [135, BETA, k]).frame, model).solutions
        (found,) = [s for s in solutions if np.allclose(s.angles, angles, atol=1e-5)]
        assert abs((found.rho - rho + 180) % 360 - 180) < 1e-5
        assert abs((found.third_angle() - third + 180) % 360 - 180) < 1e-5


@pytest.mark.parametrize(("a", "b", "third"), [(10, 20, -64.494450), (30, 20, -36.052389)])
def test_a_head_needs_another_third_angle_for_every_plane(a, b, third):
    spindle = (machine_frames(HEAD, [0, 0, 0, b, a], degrees=True)[1]).rotation
    (found,) = [s for s in align(Frame(spindle), HEAD).solutions if np.allclose(s.angles, [b, a])]
    assert abs(found.third_angle() - third) < 1e-6


def test_parallel_axes_of_source_000():
    """With two angles on an A-C table X lies along X; γ = −90 belongs to a B-C table."""
    plane = Plane("G68.2", [135, BETA, -90]).frame
    assert align(plane, BC).solutions[1].parallel == [("X", "X"), ("Y", "Y"), ("Z", "Z")]
    assert align(plane, AC).solutions[1].parallel == [("X", "Y"), ("Y", "X"), ("Z", "Z")]
    assert align(Plane("G68.2", [135, BETA, -70]).frame, BC).solutions[1].parallel == [("Z", "Z")]
    assert align(plane, SKEW).solutions[0].parallel == []


def test_limits_are_named():
    model = limited(AC, A=(-30, 60))
    reasons = [solution.reason for solution in align(Plane("PLANE SPATIAL", [0, 45, 0]).frame, model).solutions]
    assert sorted(reasons) == ["", "A at -45.0000, below its limit -30"]


def test_unreachable_plane_names_the_limit(dmu50v):
    with pytest.raises(
        ReachError, match=r"is 110\.0000 degrees from the pole .* axis C, .* from 0\.0000 to 90\.0000"
    ):
        align(Plane("PLANE SPATIAL", [110, 0, 0]).frame, dmu50v)


def test_one_frame_at_a_time():
    with pytest.raises(InputError, match="feature: expected one frame"):
        align(Frame(np.stack([np.eye(3)] * 2)), AC)
    with pytest.raises(InputError, match="along, feature: expected 'spindle', 'X'"):
        align(Frame(np.eye(3)), AC).solutions[0].third_angle("C")


# Which solution a control takes


NOTHING = (-1e4, 1e4)
NINE_ROWS = [
    (NOTHING, (0, 0), "", (45, 90)),
    (NOTHING, (0, 0), "+", (45, 90)),
    (NOTHING, (0, 0), "-", (-45, -90)),
    (NOTHING, (0, -105), "", (-45, -90)),
    (NOTHING, (0, -105), "+", (45, 90)),
    (NOTHING, (0, -105), "-", (-45, -90)),
    ((-90, 10), (0, 0), "", (-45, -90)),
    ((-90, 10), (0, 0), "+", None),
    (NOTHING, (0, -135), "+", (45, 90)),
]


@pytest.mark.parametrize(("travel", "present", "seq", "expected"), NINE_ROWS)
@pytest.mark.parametrize("sign", [-1, 1])
def test_nine_rows_of_the_heidenhain_table(travel, present, seq, expected, sign):
    """SPB+45 on an A-C table; the example holds for either sign of the table axes."""
    model = build(("A", "workpiece", [sign, 0, 0]), ("C", "workpiece", [0, 0, sign]))
    plane = align(Plane("PLANE SPATIAL", [0, 45, 0]).frame, limited(model, A=travel))
    if expected is None:
        with pytest.raises(ReachError, match=r"entered angle not permitted .*A at 45\.0000, above its limit 10"):
            heidenhain(plane, present, seq=seq)
    else:
        np.testing.assert_allclose(heidenhain(plane, present, seq=seq).angles, expected, atol=1e-9)


@pytest.mark.parametrize(
    ("rot", "angles", "point", "rho"),
    [("COORD", (0, 0), (43.30127, 25, 0), 30), ("TABLE", (0, 30), (50, 0, 0), 0)],
)
def test_coord_rot_and_table_rot(rot, angles, point, rho):
    feature = Plane("PLANE SPATIAL", [0, 0, 30]).frame
    plane = align(feature, AC)
    assert plane.free
    choice = heidenhain(plane, (0, 0), rot=rot)
    np.testing.assert_allclose(choice.angles, angles, atol=1e-9)
    assert choice.rho == pytest.approx(rho, abs=1e-9)
    workpiece, _ = machine_frames(AC, [0, 0, 0, *choice.angles], degrees=True)
    np.testing.assert_allclose(workpiece.point(feature.point([50, 0, 0])), point, atol=6e-6)


def test_free_axis_stays_where_it_stands():
    plane = align(Plane("PLANE SPATIAL", [0, 0, 30]).frame, AC)
    for choose in (fanuc, heidenhain, lambda *arguments: siemens(*arguments, direction=1)):
        np.testing.assert_allclose(choose(plane, (0, 77)).angles, (0, 77), atol=1e-9)


@pytest.mark.parametrize("side", ["+", "-"])
def test_a_master_that_stands_at_0_is_on_either_side(side):
    plane = align(Plane("PLANE SPATIAL", [0, 0, 30]).frame, AC)
    np.testing.assert_allclose(heidenhain(plane, (0, 77), seq=side).angles, (0, 77), atol=1e-9)


def test_where_both_solutions_are_one_position_it_is_said():
    plane = align(Plane("PLANE SPATIAL", [0, 0, 30]).frame, AC)
    for choose in (fanuc, heidenhain, lambda *arguments: siemens(*arguments, direction=1)):
        assert choose(plane, (0, 77)).why == "both are one position"


@pytest.mark.parametrize(("tilt", "free"), [(0.9e-9, True), (1.1e-9, False)])
def test_an_axis_is_free_if_the_plane_is_square_to_it(tilt, free):
    assert align(Plane("PLANE SPATIAL", np.degrees([tilt, 0, 0])).frame, AC).free == free


def test_table_rot_turns_the_free_axis_of_every_machine(kin):
    workpiece_side = align(Frame(np.eye(3)), kin).workpiece_side
    axis = np.array(kin.machine.rotary[workpiece_side].axis)
    feature = Frame.from_axes(axis * np.sign(axis @ kin.machine.tool_axis), [0.3, 1, 0.2])
    plane = align(feature, kin)
    assert plane.free
    assert heidenhain(plane, (0, 0), rot="TABLE").rho == pytest.approx(0, abs=1e-9)


def test_fanuc_counts_the_master_first():
    plane = align(Plane("PLANE SPATIAL", [0, 45, 0]).frame, AC)
    np.testing.assert_allclose(fanuc(plane, (20, -60)).angles, (45, 90), atol=1e-9)
    np.testing.assert_allclose(fanuc(plane, (20, -60), master="C").angles, (-45, -90), atol=1e-9)
    distances = [np.hypot(*(s.angles - (20, -60))) for s in plane.solutions]
    np.testing.assert_allclose(sorted(distances), [71.589, 152.069], atol=6e-4)
    assert fanuc(plane, (20, -60)).why == "smallest motion of A"
    assert fanuc(plane, (0, -60)).why == "smallest motion of C"


def test_fanuc_masters_by_arrangement():
    """The table's axis on a mixed machine, the axis on the bed on the others."""
    mixed = build(("C", "workpiece", [0, 0, -1]), ("B", "tool", [0, 1, 0]))
    plane = align(Plane("PLANE SPATIAL", [0, 45, 0]).frame, mixed)
    assert fanuc(plane, (0, 0)).why == "smallest motion of C"
    plane = align(Plane("PLANE SPATIAL", [0, 45, 0]).frame, SKEW)
    assert fanuc(plane, (0, 0)).why == "smallest motion of C"


def test_siemens_names_the_reference_axis_by_which_it_chose():
    plane = align(Plane("PLANE SPATIAL", [0, 45, 0]).frame, AC)
    for direction, word in ((1, "higher"), (-1, "lower")):
        assert siemens(plane, (0, 0), direction).why == f"{word} A"


def test_siemens_takes_the_other_if_one_is_out_of_travel():
    feature = Plane("PLANE SPATIAL", [0, 45, 0]).frame
    assert siemens(align(feature, AC), (0, 0), -1).angles[0] == pytest.approx(-45)
    assert siemens(align(feature, AC), (0, 0), 1).angles[0] == pytest.approx(45)
    assert siemens(align(feature, limited(AC, A=(-10, 90))), (0, 0), -1).angles[0] == pytest.approx(45)


def test_whole_turns_within_travel():
    model = limited(SKEW, C=(-370, 370), B=(0, 181))
    plane = align(Plane("G68.2", [135, BETA, 0]).frame, model)
    np.testing.assert_allclose(fanuc(plane, (360, 90)).angles, (13.826048, 81.100571), atol=1e-6)
    np.testing.assert_allclose(fanuc(plane, (-340, 90)).angles, (-346.173952, 81.100571), atol=1e-6)


@given(st.floats(-180, 180), st.floats(5, 175), st.floats(-180, 180), st.floats(-180, 180), st.floats(-180, 180))
def test_every_choice_puts_the_tool_on_the_plane(i, j, k, first, second):
    for model in (AC, BC, HEAD):
        feature = Plane("G68.2", [i, j, k]).frame
        plane = align(feature, model)
        for choice in (
            fanuc(plane, (first, second)),
            heidenhain(plane, (first, second)),
            siemens(plane, (0, 0), 1),
        ):
            np.testing.assert_allclose(plane.at(choice.angles).spindle[:, 2], feature.z, atol=1e-12)
            assert choice.rho == pytest.approx(plane.at(choice.angles).rho)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda plane: fanuc(plane, (0, 0), master="X"), "rotary axis: expected one of A, C"),
        (lambda plane: fanuc(plane, (0, 0, 0)), r"present: expected shape \(..., 2\)"),
        (lambda plane: fanuc(plane, [(0, 0)]), "present: expected the rotary angles"),
        (lambda plane: heidenhain(plane, (0, 0), seq="up"), "seq: expected"),
        (lambda plane: heidenhain(plane, (0, 0), rot="ROT"), "rot: expected 'COORD' or 'TABLE'"),
        (lambda plane: siemens(plane, (0, 0), 0), "direction: expected -1 or"),
    ],
)
def test_bad_input(call, message):
    with pytest.raises(InputError, match=message):
        call(align(Plane("PLANE SPATIAL", [0, 45, 0]).frame, AC))


@settings(max_examples=5, deadline=None)
@given(machines(), st.integers(0, 2**32 - 1))
def test_any_machine_stands_on_the_plane(model, seed):
    kin = Kinematics(model)
    rng = np.random.default_rng(seed)
    (tip,), (axis,) = kin.forward(np.concatenate([rng.uniform(-300, 300, 3), rng.uniform(-3, 3, 2)])[None])
    feature = Frame.from_axes(axis, rng.normal(size=3), tip)
    for solution in align(feature, kin).solutions:
        _, reached = kin.forward([0, 0, 0, *solution.angles], degrees=True)
        np.testing.assert_allclose(reached, feature.z, atol=1e-12)
        turned = solution.spindle @ Rotation.from_euler("Z", solution.rho, degrees=True).as_matrix()
        np.testing.assert_allclose(turned, feature.rotation, atol=1e-12)
