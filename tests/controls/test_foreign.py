"""Programs by others: arcs, cycles, planes, shifts and offsets, at points worked out by hand."""

import numpy as np
import pytest

from mathpost import machine
from mathpost.controls import reader
from mathpost.controls.coordinates import Setup
from mathpost.errors import InputError
from tests.conftest import DATA

AC = machine.load(DATA / "machines/ac_table.toml")
START = "G21 G90 G17\nG0 A0 C0\nG0 X10 Y0 Z5\n"
HALF, ROOT = np.cos(np.radians(60)), np.sin(np.radians(60))


def ends(text, control="fanuc", **setup):
    """X Y Z at the end of the last move on each line of a program."""
    found = reader.follow(text, AC, control, setup=Setup(**setup))
    return {int(line): words[:3] for line, words in zip(found.lines, found.blocks.words, strict=True)}, found


@pytest.mark.parametrize("line", ["G81 X1 Z-2 R1 K3 F100", "G81 X1 Z-2 R1 L3 F100", "G76 X1 Z-2 R1 Q1 F100"])
def test_what_may_move_an_axis_otherwise_is_refused(line):
    with pytest.raises(InputError, match="line 4"):
        ends(f"{START}{line}\nM30\n")


@pytest.mark.parametrize(
    ("lines", "expected"),
    [
        ("G91 G1 X2 Y-1 F100", [12, -1, 5]),
        ("G20 G1 X1 F10", [25.4, 0, 5]),
        ("G52 X1 Y2 Z3\nG1 X0 Y0 Z0 F100", [1, 2, 3]),
        ("G2 X0 Y-10 R10 F100", [0, -10, 5]),
        ("G18 G3 X0 Z15 I-10 K0 F100", [0, 0, 15]),
        ("G81 X1 Y2 Z-7 R2 F100", [1, 2, 5]),
        ("G99 G81 X1 Y2 Z-7 R2 F100", [1, 2, 2]),
        ("G68.2 X1 Y0 Z0 I0 J60 K0\nG53.1\nG1 X0 Y0 Z10 F100", [1, -10 * ROOT, 10 * HALF]),
        ("G68.2 X1 Y0 Z0 I0 J60 K0\nG69\nG1 X3 F100", [3, 0, 5]),
    ],
)
def test_where_a_line_leads(lines, expected):
    found, _ = ends(f"{START}{lines}\nM30\n")
    np.testing.assert_allclose(found[max(found)], expected, atol=1e-9)


def test_an_arc_keeps_its_radius_and_its_sense():
    text = f"{START}G3 X-10 Y0 I-10 J0 Z7 F100\nM30\n"
    _, found = ends(text)
    arc = found.blocks.words[found.lines == 4]
    np.testing.assert_allclose(np.hypot(*arc[:, :2].T), 10, atol=1e-9)
    assert (arc[:-1, 1] > 0).all()
    np.testing.assert_allclose(np.interp(7, arc[:, 2], arc[:, 0]), -10)


def test_klartext_plane_cycle_and_shift():
    text = """0 BEGIN PGM A MM
1 TOOL CALL 3 Z S1000
2 L A+0 C+0 R0 FMAX
3 L X+0 Y+0 Z+50 R0 F MAX M3
4 CYCL DEF 7.0 DATUM SHIFT
5 CYCL DEF 7.1 X+5
6 CYCL DEF 200 DRILLING ~
  Q200=2 ;SET-UP CLEARANCE ~
  Q201=-20 ;DEPTH ~
  Q206=150 ;FEED ~
  Q203=+1 ;SURFACE ~
  Q204=8 ;2ND CLEARANCE
7 L X+1 Y+2 FMAX M99
8 CC X+11 Y+2
9 C X+11 Y+12 DR- F200
10 END PGM A MM
"""
    found, program = ends(text, "heidenhain")
    line = text.splitlines().index("7 L X+1 Y+2 FMAX M99") + 1
    heights = program.blocks.words[program.lines == line, 2]
    np.testing.assert_allclose(heights, [50, 3, -19, 9])
    np.testing.assert_allclose(found[line][:2], [6, 2])
    np.testing.assert_allclose(found[line + 2], [16, 12, 9], atol=1e-9)
    assert program.skipped["BEGIN PGM"] == 1


def test_tool_axis_vectors_and_machine_coordinates_of_siemens():
    turned = "G1 X1 Y2 Z3 A3=0 B3=-0.5 C3=0.8660254 F100"
    text = f"G90 G710 G0 A0 C0\nG0 X0 Y0 Z50\nTRAORI\n{turned}\nTRAFOOF\nSUPA G0 Z100\nM30\n"
    _, program = ends(text, "siemens")
    kin_words = program.blocks.words
    np.testing.assert_allclose(kin_words[1], [1, 2, 3, 30, 0], atol=1e-5)
    np.testing.assert_allclose(kin_words[-1, 2], 100 - AC.tool_length)  # the slide stands at 100


def test_offsets_and_lengths_are_asked_for():
    text = f"G54\n{START}G55\nG1 X0 Y0 Z0 F100\nM30\n"
    with pytest.raises(InputError, match="line 5: expected the origin of G55: --origin G55=X,Y,Z"):
        ends(text)
    found, _ = ends(text, offsets={"G55": (7, 8, 9)})
    np.testing.assert_allclose(found[6], np.subtract([7, 8, 9], AC.origin))
    placed, _ = ends("G21 G90\nG1 X4 F100\nM30\n", start={"X": 1, "Y": 2, "Z": 3, "A": 0, "C": 0})
    np.testing.assert_allclose(placed[2], [4, 2, 3])
    tools = f"T1 M6\n{START}T2 M6\nG0 X0 Y0 Z0 A0 C0\nM30\n"
    with pytest.raises(InputError, match="line 5: expected the length of tool 2"):
        ends(tools, lengths={})
    _, program = ends(tools, lengths={"1": 50.0, "2": 80.0})
    assert [each.tool_length for _, each in program.machines][-2:] == [50.0, 80.0]
