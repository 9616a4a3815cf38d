"""The plane as the shell answers it, against SciPy's rotations."""

import json
from pathlib import Path

import nbformat
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mathpost.interface.shell.main import main
from mathpost.shop.controls import plane_blocks
from mathpost.shop.controls.plane_forms import FORMS

BETA = "54.7356103172"
SOURCE = Rotation.from_euler("ZXZ", [135, 54.7356103172, -90], degrees=True).as_matrix()


def answered(capsys, *arguments, status=0):
    assert main(["plane", *arguments, "--json"]) == status
    return json.loads(capsys.readouterr().out)


WAYS = {
    "G68.2": ["G68.2", "I135.", f"J{BETA}", "K-90."],
    "lower case": ["g68.2 x0 y0 z0", f"i135 j{BETA} k-90"],
    "SPATIAL": [f"PLANE SPATIAL SPA+0 SPB+{BETA} SPC+45 TURN FMAX SEQ-"],
    "comma": [f"PLANE SPATIAL SPA+0 SPB+{BETA.replace('.', ',')} SPC+45 STAY"],
    "EULER": [f"PLANE EULER EULPR135 EULNU{BETA} EULROT270"],
    "CYCLE800": [f'CYCLE800(0,"TC1",0,27,0,0,0,45,{BETA},0,0,0,0,-1,0,1)'],
    "AROT": [f"AROT Y{BETA} Z45"],
    "points": "--point 0 0 0 --point 1 1 -2 --point -5 5 0".split(),
    "vector": "--normal 2 2 2 --x 1 1 -2".split(),
    "crooked vector": "--normal 2 2 2 --x 1 1 0".split(),
}


@pytest.mark.parametrize("way", WAYS)
def test_every_way_to_say_a_plane(way, capsys):
    found = answered(capsys, *WAYS[way])
    np.testing.assert_allclose(np.transpose([found["x"], found["y"], found["z"]]), SOURCE, atol=1e-9)
    for notation, words in found["words"].items():  # read back from the text, to its four decimals
        back = plane_blocks.from_text(words["block"])
        assert back.notation == notation
        np.testing.assert_allclose(back.frame.rotation, SOURCE, atol=2e-6)


def test_a_direction_alone_has_a_level_x(capsys):
    found = answered(capsys, "--normal", "1", "-2", "3", "--origin", "5", "6", "7")
    assert found["x"][2] == pytest.approx(0) and found["origin"] == [5, 6, 7]
    np.testing.assert_allclose(found["z"], np.array([1, -2, 3]) / np.sqrt(14))


def test_what_a_wrong_k_does(capsys):
    found = answered(capsys, *WAYS["G68.2"])["wrong"]
    assert [row["K"] for row in found] == [0, 90]
    for row in found:
        frame = Rotation.from_euler("ZXZ", [135, float(BETA), row["K"]], degrees=True)
        np.testing.assert_allclose(row["point"], frame.apply([10, 0, 0]), atol=1e-9)


def test_a_machine_on_the_plane(capsys):
    """B carries C, both turn the other way: the plane's origin in the machine, and the known third angle."""
    arguments = [*WAYS["G68.2"], "--origin", "10", "20", "30", "--machine", "bc_table", "--from", "-20", "100"]
    found = answered(capsys, *arguments)["machine"]
    first, second = found["positions"]
    assert (first["joints"]["B"], first["joints"]["C"]) == pytest.approx((float(BETA), 45))
    assert first["K"] == pytest.approx(-90) and first["rho"] == pytest.approx(0, abs=1e-9)
    assert abs(second["rho"]) == pytest.approx(180) and "-35" in second["out_of_travel"][0]
    point, tilting, turning = np.array([30, 20, 70]), np.array([20, 0, -80]), np.array([20, 0, 0])
    point = turning + Rotation.from_euler("Z", -45, degrees=True).apply(point - turning)
    point = tilting + Rotation.from_euler("Y", -float(BETA), degrees=True).apply(point - tilting)
    np.testing.assert_allclose(first["offset"], point, atol=1e-9)
    # The tip stands there: the words count from the workpiece origin, and the tool is vertical.
    linear = [first["joints"][name] for name in "XYZ"]
    np.testing.assert_allclose(np.add(linear, (20, 0, 40)), point, atol=1e-9)
    assert found["controls"]["Fanuc G53.1"]["angles"]["B"] == pytest.approx(float(BETA))


def test_the_text(capsys):
    assert main(["plane", *WAYS["SPATIAL"], "--machine", "ac_table"]) == 0
    said = capsys.readouterr().out
    for text in ("I135. J54.7356 K-90.", "EULROT+270", "I -45 J -54.7356 K 90", "Work offset", "A 54.7356"):
        assert text in said, text
    assert "K 0 along it" in said and "Siemens _DIR -1" in said


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        ("", "found nothing"),
        ("G68.2 I1 J2 K3 --normal 0 0 1", "found words and normal"),
        ("--point 0 0 0 --point 1 0 0", "three points"),
        ("--point 0 0 0 --point 1 1 1 --point 2 2 2", "direction"),
        ("--normal 0 0 0", "direction"),
        ("G68.2 I1 J2 K3 --x 1 0 0", "--normal"),
        ("PLANE VECTOR BX1 BY0 BZ1 NX0 NY0 NZ1", "perpendicular"),
        ("G17", "line 1"),
        ("G68.2 I1 J2 K3 --machine bc_table --from 1", "2 numbers"),
        ("G68.2 I0 J120 K0 --machine dmu50v", "from the pole"),
    ],
)
def test_refused(arguments, text, capsys):
    assert main(["plane", *arguments.split()]) == 2
    assert text in capsys.readouterr().err


def test_vectors_that_are_not_square_are_kept_on_demand(capsys):
    found = answered(capsys, "PLANE VECTOR BX1 BY0 BZ1 NX0 NY0 NZ1", "--keep", "N")
    np.testing.assert_allclose(found["x"], [1, 0, 0], atol=1e-12)


def test_the_lesson_shows_the_forms_that_the_command_reads():
    notebook = nbformat.read(Path("notebooks/03_tilted_working_plane.ipynb"), as_version=4)
    [cell] = [cell.source for cell in notebook.cells if "| rests on |" in cell.source]
    rows = [line.strip("| ").split(" | ") for line in cell.splitlines() if line.startswith("| `")]
    said = [[form[column] or "–" for column in ("words", "is", "source", "beware")] for form in FORMS.values()]
    assert rows == [[f"`{words}`", *others] for words, *others in said]


def test_r_behind_g68_2_is_told_where_it_belongs(capsys):
    assert main(["plane", "G68.2", "X0", "Y0", "Z0", "I0", "J30", "K0", "R30"]) == 2
    assert "is of G68 X Y Z I J K R" in capsys.readouterr().err
