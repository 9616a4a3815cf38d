"""One plane in every notation: round trips, locks, the manuals' numbers, blocks written and read."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mathpost import euler
from mathpost.errors import InputError
from mathpost.frame import Frame
from mathpost.shop.controls import plane_blocks
from mathpost.shop.plane.tilted_plane import NOTATIONS, Plane

BETA = np.degrees(np.arccos(1 / np.sqrt(3)))
SOURCE = Plane("G68.2", [135, BETA, -90], [10, -20, 30])


@pytest.fixture(scope="module")
def frames():
    """Random planes, then every combination of quarter turns: all that can lock in any notation."""
    rng = np.random.default_rng(6)
    quarters = np.stack(np.meshgrid(*3 * [np.arange(-180, 181, 45)]), axis=-1).reshape(-1, 3)
    locked = [euler.matrix(s, quarters, degrees=True) for s in ("ZXZ", "xyz", "ZYZ")]
    rotation = np.concatenate([Rotation.random(5000, rng).as_matrix(), *locked])
    return Frame(rotation, rng.uniform(-500, 500, (len(rotation), 3)))


@pytest.mark.parametrize("notation", NOTATIONS)
def test_to_any_notation_and_back(notation, frames):
    back = Plane.from_frame(frames, notation).frame
    np.testing.assert_allclose(back.rotation, frames.rotation, atol=1e-12)
    np.testing.assert_array_equal(back.origin, frames.origin)


@pytest.mark.parametrize("notation", NOTATIONS)
@pytest.mark.parametrize("other", ["G68.2", "PLANE VECTOR", "AROT RPY"])
def test_from_any_notation_to_another(notation, other, frames):
    some = Frame(frames.rotation[::50], frames.origin[::50])
    plane = Plane.from_frame(some, notation).to(other)
    np.testing.assert_allclose(plane.frame.rotation, some.rotation, atol=1e-12)


@pytest.mark.parametrize(
    ("notation", "values"),
    [
        ("PLANE SPATIAL", (0, BETA, 45)),
        ("PLANE EULER", (135, BETA, 270)),
        ("PLANE VECTOR", (0.408248, 0.408248, -0.816497, 0.577350, 0.577350, 0.577350)),
        ("AROT RPY", (0, BETA, 45)),
        ("CYCLE800 ZYX", (45, BETA, 0)),
        ("CYCLE800 solid", (45, BETA, 0)),
    ],
)
def test_source_plane_in_every_notation(notation, values):
    np.testing.assert_allclose(SOURCE.to(notation).values, values, atol=6e-7)


def test_source_frame():
    expected = [[0.408248, -0.707107, 0.577350], [0.408248, 0.707107, 0.577350], [-0.816497, 0, 0.577350]]
    np.testing.assert_allclose(SOURCE.frame.rotation, expected, atol=6e-7)


def test_manual_example_of_spatial_angles():
    expected = [[0, -0.707107, 0.707107], [1, 0, 0], [0, 0.707107, 0.707107]]
    np.testing.assert_allclose(Plane("PLANE SPATIAL", [45, 0, 90]).frame.rotation, expected, atol=6e-7)


def test_axis_by_axis_zyx_is_rpy_backwards():
    np.testing.assert_allclose(
        Plane("CYCLE800 ZYX", [30, 20, 10]).frame.rotation, Plane("AROT RPY", [10, 20, 30]).frame.rotation
    )


def test_solid_angle():
    a, b = np.deg2rad([25, 40])
    z = Plane("CYCLE800 solid", [25, 40, 77]).frame.z
    np.testing.assert_allclose(z, [np.cos(a) * np.sin(b), np.sin(a) * np.sin(b), np.cos(b)])


@pytest.mark.parametrize(
    ("notation", "given", "expected", "word"),
    [
        ("G68.2", (20, 0, 35), (55, 0, 0), "K 0"),
        ("G68.2", (20, 180, 35), (-15, 180, 0), "K 0"),
        ("PLANE SPATIAL", (40, 90, 25), (15, 90, 0), "SPC 0"),
        ("PLANE SPATIAL", (40, -90, 25), (65, -90, 0), "SPC 0"),
        ("AROT RPY", (10, 90, 40), (0, 90, 30), "X 0"),
        ("AROT RPY", (190, 0, -200), (-170, 0, 160), ""),
        ("CYCLE800 solid", (30, 0, 20), (50, 0, 0), "rest 0"),
        ("G68.2", (20, 10, 35), (20, 10, 35), ""),
    ],
)
def test_lock_is_flagged_and_resolved_by_the_stated_rule(notation, given, expected, word):
    plane = Plane.from_frame(Plane(notation, given).frame, notation)
    np.testing.assert_allclose(plane.values, expected, atol=1e-12)
    assert bool(plane.locked) == bool(word)
    assert word in plane.note if word else plane.note == ""


@pytest.mark.parametrize(("k", "rotation"), [(0, 0), (-1e-9, 360 - 1e-9), (-90, 270), (90, 90), (180, 180)])
def test_eulrot_counts_from_0_up_to_360(k, rotation):
    assert Plane("G68.2", [20, 30, k]).to("PLANE EULER")["EULROT"] == pytest.approx(rotation, abs=1e-11)


@pytest.mark.parametrize("off", [1e-3, 0.1, -0.5])
def test_vectors_less_perpendicular_than_seven_decimals_are_refused(off):
    """Beside a right angle by so many degrees, either way; what the seventh decimal rounds is accepted."""
    normal = [np.sin(np.radians(off)), 0, np.cos(np.radians(off))]
    with pytest.raises(InputError, match=rf"perpendicular to N, found {90 - off:.4f} degrees"):
        Plane("PLANE VECTOR", [1, 0, 0, *normal])
    rng = np.random.default_rng(6)
    for frame in Rotation.random(50, rng).as_matrix():
        Plane("PLANE VECTOR", np.round([*frame[:, 0], *frame[:, 2]], 7))


def test_manual_vectors_are_not_perpendicular():
    values = (0.8, -0.4, -0.4472, 0.2, 0.2, 0.9592)
    with pytest.raises(InputError, match=r"B perpendicular to N, found 110\.42\d+ degrees"):
        Plane("PLANE VECTOR", values)
    kept = Plane("PLANE VECTOR", values, keep="N").frame
    np.testing.assert_allclose(kept.x, [0.928131, -0.352364, -0.120051], atol=6e-7)
    np.testing.assert_allclose(kept.z, np.array(values[3:]) / np.linalg.norm(values[3:]), atol=1e-15)
    base = Plane("PLANE VECTOR", values, keep="B").frame
    np.testing.assert_allclose(base.x, np.array(values[:3]) / np.linalg.norm(values[:3]), atol=1e-15)
    assert abs(np.degrees(np.arccos(base.z @ kept.z)) - 20.42) < 0.01


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: Plane("G68.3", [1, 2, 3]), "notation: expected one of G68.2"),
        (lambda: Plane.from_frame(SOURCE.frame, "CYCLE800 XYX"), "notation: expected one of"),
        (lambda: Plane("G68.2", [1, 2]), r"G68.2: expected shape \(..., 3\)"),
        (lambda: Plane("G68.2", [1, 2, np.inf]), "expected finite"),
        (lambda: Plane("PLANE VECTOR", [1, 0, 0, 0, 0, 0]), "PLANE VECTOR, N: expected a vector with a direction"),
        (lambda: Plane("PLANE VECTOR", [1, 0, 0, 0, 0, 1], keep="X"), "keep: expected 'B', 'N'"),
        (lambda: SOURCE["SPA"], "G68.2: expected one of I, J, K"),
    ],
)
def test_bad_planes(call, message):
    with pytest.raises(InputError, match=message):
        call()


# Blocks


@pytest.mark.parametrize("notation", NOTATIONS)
def test_written_blocks_read_back(notation, frames):
    for index in range(0, len(frames.rotation), 97):
        frame = Frame(frames.rotation[index], frames.origin[index])
        plane = Plane.from_frame(frame, notation)
        read = plane_blocks.from_text(plane_blocks.to_text(plane, decimals=9))
        assert read.notation == notation
        tolerance = 1e-9 if NOTATIONS[notation].sequence else 2e-7
        np.testing.assert_allclose(read.frame.rotation, frame.rotation, atol=tolerance)
        np.testing.assert_allclose(read.origin, frame.origin, atol=1e-9)


@pytest.mark.parametrize(
    ("notation", "block"),
    [
        ("G68.2", "G68.2 X10. Y-20. Z30. I135. J54.7356 K-90."),
        ("PLANE SPATIAL", "TRANS DATUM AXIS X+10 Y-20 Z+30\nPLANE SPATIAL SPA+0 SPB+54.7356 SPC+45 STAY"),
        ("PLANE EULER", "TRANS DATUM AXIS X+10 Y-20 Z+30\nPLANE EULER EULPR+135 EULNU+54.7356 EULROT+270 STAY"),
        (
            "PLANE VECTOR",
            "TRANS DATUM AXIS X+10 Y-20 Z+30\nPLANE VECTOR BX+0.4082483 BY+0.4082483 BZ-0.8164966 "
            "NX+0.5773503 NY+0.5773503 NZ+0.5773503 STAY",
        ),
        ("AROT RPY", "TRANS X10 Y-20 Z30\nAROT X0 Y54.7356 Z45"),
        ("CYCLE800 XYZ", 'CYCLE800(0,"TC1",0,57,10,-20,30,-45,35.2644,60,0,0,0,-1,0,1)'),
        ("CYCLE800 solid", 'CYCLE800(0,"TC1",0,64,10,-20,30,45,54.7356,0,0,0,0,-1,0,1)'),
    ],
)
def test_blocks(notation, block):
    assert plane_blocks.to_text(SOURCE.to(notation)) == block


@pytest.mark.parametrize(
    ("order", "mode"), [("XYZ", 57), ("ZYX", 27), ("ZXY", 39), ("XZY", 45), ("YXZ", 54), ("YZX", 30)]
)
def test_mode_byte(order, mode):
    assert plane_blocks.to_text(Plane(f"CYCLE800 {order}", [1, 2, 3])).split(",")[3] == str(mode)


def test_rest_of_a_solid_angle_is_a_turn_of_its_own():
    text = plane_blocks.to_text(Plane("CYCLE800 solid", [45, 30, -15]))
    assert text.splitlines()[1] == "AROT Z-15"
    np.testing.assert_allclose(plane_blocks.from_text(text).values, [45, 30, -15])


def test_swivel_cycle_moves_its_origin_along_the_turned_axes():
    plane = plane_blocks.from_text('N10 CYCLE800(1,"",100000,57,10,0,0,0,0,90,5,0,0,-1,100,1)')
    np.testing.assert_allclose(plane.origin, [10, 5, 0], atol=1e-15)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "text: expected a block with G68.2"),
        ("G0 X10", "line 1: expected G68.2, PLANE"),
        ("G68.2 X0 Y0 Z0 I10. J20.", "line 1: expected one word K with a number, found 0"),
        ("G68.2 I1. J2. J3. K4.", "one word J with a number, found 2"),
        ("G68.2 P5 I1. J2. K3.", "P with one of 0, 1, 2, 3, 4, found P5"),
        ("G68.2 P1 Q122 I1. J2. K3.", "Q with one of 123, .*found Q122"),
        ("G68.2 P2 Q1 X0 Y0 Z0\nG68.2 P2 Q2 X1 Y0 Z0\nG68.2 P2 Q3 X2 Y0 Z0", "line 3: .*not on one line"),
        ("G68.2 P2 Q1 X0 Y0 Z0\nG68.2 P2 Q2 X1 Y0 Z0", "line 2: expected G68.2 P2 Q3"),
        ("G68.2 P2 Q1 X0 Y0 Z0\nG68.2 P2 Q1 X1 Y0 Z0\nG68.2 P2 Q2 X1 Y0 Z0\nG68.2 P2 Q3 X1 Y2 Z0", "a Q that"),
        ("G68.2 P2 Q1 X0 Y0 Z0\nG0 X5\nG68.2 P2 Q2 X1 Y0 Z0\nG68.2 P2 Q3 X1 Y2 Z0", "next block of G68.2 P2"),
        ("G68.2 P3 Q1 I1. J0. K0.\nG68.2 P3 Q2 I0.1 J0 K1.", "90 degrees between both vectors, found 84.2894"),
        ("G68.2 P3 Q1 I1.000 J0. K0.\nG68.2 P3 Q2 I0.004 J0. K1.000", "both vectors, found 89.7708"),
        ("G68.2 P3 Q1 I1. J0. K0.\nG68.2 P3 Q2 I0. J0 K1. R5", "found 'R5'"),
        ("G68.2 P4 I90 J90 K0", "that span a plane"),
        ("G68.3 X0 Y0 Z0", "rotary axes whose position is known"),
        ("G68.4 I1 J2 K3", "a plane before G68.4"),
        ("G68 X0 Y0 R30", "one word I"),
        ("G68 I0 J0 K0 R30", "I J K: expected a vector"),
        ("G268 I10 J20 K30", "G268 with Q"),
        ("G68.2 I1 J2 K3\nG68.2 I1 J2 K3", "line 2: expected one plane only"),
        ("G68.2 X0 Y0 Z0 I1. J2. K3. R30", "found 'R30'"),
        ("G68.2 X0 Y0 Z0 I1. J2. K3. Q5 W99", "found 'Q5 W99'"),
        ("PLANE SPATIAL SPA+1 SPB+2 SPC+3 SEQ- DX+5", "found 'DX\\+5'"),
        ("G68.2 I1.2.3 J2. K3.", "one word I with a number"),
        ("\nPLANE SPATIAL SPA+1 SPB+2", "line 2: expected one word SPC"),
        ("PLANE VECTOR BX+1 BY+0 BZ+0.1 NX+0 NY+0 NZ+1 STAY", "84.2894 degrees"),
        ("PLANE RELATIV SPB+45", "line 1: expected G68.2, PLANE SPATIAL"),
        ("CYCLE800()", "at least ten arguments"),
        ('CYCLE800(0,"TC1",0,192,0,0,0,1,2,3,0,0,0,-1)', "_MODE"),
        ('CYCLE800(0,"TC1",0,57,0,0,0,1,two,3,0,0,0,-1)', "expected numbers"),
        ('CYCLE800(0,"TC1",0,57,0,0,0,1,nan,3,0,0,0,-1)', "expected numbers"),
        ("AROT X10\nAROT Z5", "line 2: expected one plane only"),
    ],
)
def test_bad_blocks(text, message):
    with pytest.raises(InputError, match=message):
        plane_blocks.from_text(text)
