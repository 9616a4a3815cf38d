"""The forms of G68.2 and its kin against formulas of their own: Rodrigues, cross products, SciPy's rotations."""

import json

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mathpost import load_machine
from mathpost.errors import InputError
from mathpost.interface.shell.main import main
from mathpost.kinematics import Kinematics
from mathpost.shop.controls import plane_blocks
from mathpost.shop.controls.plane_forms import FORMS
from mathpost.shop.controls.reader import follow
from tests.independent.machine_model import rotation as rodrigues

RNG = np.random.default_rng(57)
ANGLES = RNG.uniform(-170, 170, (6, 3)).round(3)
ORIGIN = np.array([11.0, -7.5, 3.25])
AT = "X11. Y-7.5 Z3.25"


def words(letters, values):
    return " ".join(f"{letter}{value:.6f}" for letter, value in zip(letters, values, strict=True))


def check(text, rotation, origin=ORIGIN, atol=1e-9, **given):
    frame = plane_blocks.read(text, **given)[0].frame
    np.testing.assert_allclose(frame.rotation, rotation, atol=atol)
    np.testing.assert_allclose(frame.origin, origin, atol=1e-9)


@pytest.mark.parametrize("angles", ANGLES)
def test_euler_and_roll_pitch_yaw(angles):
    check(f"G68.2 P0 {AT} {words('IJK', angles)}", Rotation.from_euler("ZXZ", angles, degrees=True).as_matrix())
    for order in ("123", "132", "213", "231", "312", "321"):
        about = np.eye(3)
        for digit in order:  # about axes that stay: each later turn on the left
            about = rodrigues(np.eye(3)[int(digit) - 1], angles[int(digit) - 1]) @ about
        for head in ("G68.2 P1", "G268"):
            check(f"{head} Q{order} {AT} {words('IJK', angles)}", about)
    check(f"G68.2 P1 {AT} I30", rodrigues([1, 0, 0], 30))


@pytest.mark.parametrize("seed", range(4))
def test_three_points_and_two_vectors(seed):
    rng = np.random.default_rng(seed)
    first, second, third = rng.uniform(-50, 50, (3, 3)).round(6)
    x = (second - first) / np.linalg.norm(second - first)
    z = np.cross(x, third - first)
    z /= np.linalg.norm(z)
    frame = np.column_stack([x, np.cross(z, x), z])
    blocks = [f"G68.2 P2 Q{n} {words('XYZ', p)}" for n, p in enumerate((first, second, third), 1)]
    check("\n".join(blocks), frame, first)
    check("\n".join(blocks[::-1]), frame, first)
    turned = rodrigues(z, 25) @ frame
    check("\n".join([f"G68.2 P2 Q0 {AT} R25.", *blocks]), turned, first + frame @ ORIGIN)
    over = plane_blocks.from_text("\n".join(blocks).replace("Q2", "Q9").replace("Q3", "Q2").replace("Q9", "Q3"))
    np.testing.assert_allclose(over.frame.z, -z, atol=1e-9)
    vectors = f"G68.2 P3 Q1 {AT} {words('IJK', 3 * x)}\nG68.2 P3 Q2 {words('IJK', z)}"
    check(vectors, frame, atol=2e-6)
    coarse = f"G68.2 P3 Q1 {' '.join(f'{w}{v:.3f}' for w, v in zip('IJK', x, strict=True))}"
    coarse += f"\nG68.2 P3 Q2 {' '.join(f'{w}{v:.3f}' for w, v in zip('IJK', z, strict=True))}"
    check(coarse, frame, np.zeros(3), atol=2e-3)


@pytest.mark.parametrize("angles", [(20, 30, 0), (-35, 10, 40), (0, 0, 15), (60, -50, -120)])
def test_projected_angles(angles):
    """Seen along Y the plane rises by I against X, seen along X by J against Y: two slopes of one plane."""
    alpha, beta, gamma = np.radians(angles)
    found = plane_blocks.from_text(f"G68.2 P4 {AT} {words('IJK', angles)}").frame
    z = np.array([np.tan(alpha), -np.tan(beta), 1])
    np.testing.assert_allclose(found.z, z / np.linalg.norm(z), atol=1e-9)
    x = np.array([np.cos(alpha), 0, -np.sin(alpha)])
    np.testing.assert_allclose(found.x @ x, np.cos(gamma), atol=1e-9)
    np.testing.assert_allclose(np.cross(x, found.x) @ found.z, np.sin(gamma), atol=1e-9)


@pytest.mark.parametrize("angles", ANGLES[:3])
def test_a_plane_on_a_plane_and_turns_about_lines(angles):
    first = Rotation.from_euler("ZXZ", angles, degrees=True).as_matrix()
    second = Rotation.from_euler("ZXZ", angles[::-1], degrees=True).as_matrix()
    both = f"G68.2 {AT} {words('IJK', angles)}\nG68.4 X1. Y2. Z3. {words('IJK', angles[::-1])}"
    check(both, first @ second, ORIGIN + first @ [1, 2, 3])
    check(f"G68 {AT} {words('IJK', angles)} R40.", rodrigues(angles, 40))
    twice = f"G68.5 {AT} I0 J1. K0 R40.\nG68.5 X1. Y2. Z3. I1. J0 K0 R-25."
    lean = rodrigues([0, 1, 0], 40)
    check(twice, lean @ rodrigues([1, 0, 0], -25), ORIGIN + lean @ [1, 2, 3])


@pytest.mark.parametrize("angles", [(30, 20), (-15, 200), (80, -70)])
def test_from_the_tool_axis(angles):
    """On a table that tilts about Y and turns about Z the tool leans against both."""
    tool = rodrigues([0, 0, 1], angles[1]) @ rodrigues([0, 1, 0], angles[0]) @ [0, 0, 1]
    level = np.cross([0, 0, 1], tool) / np.linalg.norm(np.cross([0, 0, 1], tool))
    frame = np.column_stack([level, np.cross(tool, level), tool])
    check(f"G68.3 {AT} R35.", rodrigues(tool, 35) @ frame, tool=tool)


def test_a_fixture_turns_with_the_table(capsys):
    """What lies along X of the table after C30 pointed by 30° off X before, backwards."""
    model = load_machine("ac_table")
    senses = [joint.axis for joint in model.rotary]
    turned = np.eye(3)
    for axis, angle in zip(senses, (-90, 30), strict=True):
        turned = turned @ rodrigues(axis, angle)
    assert (
        main(["plane", *"CALL OO88 PX=0 PY=0 PZ=0 PA=-90 PC=30 PH=1 PP=2 --machine ac_table --json".split()]) == 0
    )
    found = json.loads(capsys.readouterr().out)
    np.testing.assert_allclose(np.column_stack([found[axis] for axis in "xyz"]), turned.T, atol=1e-9)
    assert main(["plane", "CALL OO88 PX=5 PA=-90", "--machine", "ac_table"]) == 2


def test_three_points_say_which_way_they_run(capsys):
    points = "--point 0 0 0 --point 10 0 0 --point 0 10 0".split()
    assert main(["plane", *points]) == 0
    assert "anticlockwise seen from above: Z points up" in capsys.readouterr().out
    assert main(["plane", *points[:4], *points[8:], *points[4:8]]) == 0
    said = capsys.readouterr().out
    assert "clockwise seen from above: Z points down" in said and "turns the plane over" in said


# In programs

HEAD = "G21 G90 G94 G17\nG54\nG0 X0 Y0 Z100 A0 C0\n"


def tips(text, control="fanuc", model="ac_table"):
    """The tips that a program goes to, from the joints of its moves."""
    program = follow(text, load_machine(model), control)
    blocks = program.blocks
    kin = Kinematics(load_machine(model))
    joints = np.where(
        blocks.tcp[:, None], [kin.close(w[:3], np.deg2rad(w[3:])) for w in blocks.words], blocks.words
    )
    joints[:, 3:] = blocks.words[:, 3:]
    return program, kin.forward(joints, degrees=True)[0]


EULER = "G68.2 X5. Y-3. Z2. I30. J20. K-10."
FRAME = Rotation.from_euler("ZXZ", [30, 20, -10], degrees=True).as_matrix()


def as_points(frame, origin):
    places = {1: origin, 2: origin + frame[:, 0] * 40, 3: origin + frame @ [3, 25, 0]}
    return "\n".join(f"G68.2 P2 Q{q} {words('XYZ', place)}" for q, place in places.items())


OF_ONE_PLANE = {
    "P0": EULER,
    "P2": as_points(FRAME, np.array([5.0, -3, 2])),
    "P3": "G68.2 P3 Q1 X5. Y-3. Z2. " + " ".join(f"{w}{v:.7f}" for w, v in zip("IJK", FRAME[:, 0], strict=True))
    + "\nG68.2 P3 Q2 " + " ".join(f"{w}{v:.7f}" for w, v in zip("IJK", FRAME[:, 2], strict=True)),
    "G68.4": "G68.2 X5. Y-3. Z2. I30. J0. K0.\nG68.4 I0. J20. K-10.",
}  # fmt: skip


@pytest.mark.parametrize("form", OF_ONE_PLANE)
@pytest.mark.parametrize("turn", ["G53.1", "G53.6"])
def test_a_program_on_the_plane(form, turn):
    _, found = tips(f"{HEAD}{OF_ONE_PLANE[form]}\n{turn}\nG1 X10. Y5. Z1. F500\nX20.\nG69\nM30\n")
    for point, tip in zip([(10, 5, 1), (20, 5, 1)], found[-2:], strict=True):
        np.testing.assert_allclose(tip, FRAME @ point + [5, -3, 2], atol=1e-4)


def test_g53_6_holds_the_tip():
    program, found = tips(f"{HEAD}{EULER}\nG0 X1. Y2. Z30.\nG53.6\nG1 X2. F100\nM30\n")
    assert program.blocks.tcp[-2] and program.blocks.rapid[-2]
    np.testing.assert_allclose(found[-2], found[-3], atol=1e-9)


def test_a_3d_rotation_moves_slides_only():
    """G68 turns X Y Z about a direction; the rotary axes and the tool's length take no part."""
    first, second = (
        "G68 X10. Y0. Z0. I0. J1. K0. R30.\nG1 X10. Y2. Z0. F100\n",
        "G68 X1. I0. J0. K1. R90.\nX5. Y0.\n",
    )
    text = f"{HEAD}{first}{second}G69\nX0. Y0. Z0.\nM30\n"
    blocks = follow(text, load_machine("ac_table"), "fanuc").blocks
    lean = rodrigues([0, 1, 0], 30)
    np.testing.assert_allclose(blocks.words[-3, :3], lean @ [10, 2, 0] + [10, 0, 0], atol=1e-9)
    inner = rodrigues([0, 0, 1], 90)
    second = blocks.words[-2, :3]
    there = inner.T @ (lean.T @ (second - [10, 0, 0]) - [1, 0, 0])
    np.testing.assert_allclose(there[:2], [5, 0], atol=1e-9)
    np.testing.assert_allclose(blocks.words[-1, :3], [0, 0, 0], atol=1e-9)
    assert not blocks.tcp.any()


@pytest.mark.parametrize(
    ("control", "text", "message"),
    [
        ("siemens", "G68.2 X0 Y0 Z0 I10 J20 K30", "line 4: expected CYCLE800 with at least ten arguments"),
        ("fanuc", "G68.2 P2 Q1 X0 Y0 Z0\nG1 X5. F100", "line 5: expected G68.2 P2 Q2, G68.2 P2 Q3, found a move"),
        ("fanuc", f"{EULER}\nG53.1 P1\nG1 X1. F9", "found 'P1'"),
        ("fanuc", "G68.4 I1. J2. K3.\nG1 X1. F9", "a plane before G68.4"),
        ("haas", "G268 X0 Y0 Z0 I0. J20. K0. Q123\nG253\nG1 X1. F9", "which one is taken is not known"),
        ("haas", "G268 X0 Y0 Z0 I0. J20. K0.\nG1 X1. F9", "G268 with Q"),
    ],
)
def test_what_is_refused_in_a_program(control, text, message):
    with (
        pytest.raises(InputError, match=message)
        if "which" not in message
        else pytest.raises(ValueError, match=message)
    ):
        follow(HEAD + text + "\nM30\n", load_machine("ac_table"), control)


def test_haas_where_the_axes_stand_there_already():
    kin = Kinematics(load_machine("ac_table"))
    normal = rodrigues([0, 1, 0], 20) @ [0, 0, 1]
    a, c = kin.inverse([0, 0, 0], normal, degrees=True)[0, 3:]
    _, found = tips(
        f"{HEAD}G0 A{a:.6f} C{c:.6f}\nG268 X0 Y0 Z0 I0. J20. K0. Q123\nG253\nG1 X10. Y5. Z1. F9\nM30\n", "haas"
    )
    np.testing.assert_allclose(found[-1], rodrigues([0, 1, 0], 20) @ [10, 5, 1], atol=1e-5)


def test_projected_angles_and_g68_3_are_assumed_in_the_report():
    program, _ = tips(f"{HEAD}G68.2 P4 X0 Y0 Z0 I10. J5. K0.\nG53.1\nG1 X1. Y0. Z0. F9\nM30\n")
    assert any("right-handed" in said for said in program.assumed)
    program, _ = tips(f"{HEAD}G0 A20. C30.\nG68.3 X0 Y0 Z0\nG1 X1. Y0. Z0. F9\nM30\n")
    assert any("vertical" in said for said in program.assumed)


def test_every_form_says_what_it_rests_on():
    for form in FORMS.values():
        assert form["source"] and form["is"] and "beware" in form
