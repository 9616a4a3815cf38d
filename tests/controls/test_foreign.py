"""Programs by others: arcs, cycles, planes, shifts and offsets, at points worked out by hand."""

import re

import numpy as np
import pytest

from mathpost import load_machine
from mathpost.errors import InputError
from mathpost.shop.controls import reader
from mathpost.shop.controls.coordinates import Setup
from tests.conftest import DATA

AC = load_machine(DATA / "machines/ac_table.toml")
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
        ("G20\nG81 X1 Z-1 R1 F10\nG80\nG0 Z-1\nG99 G81 X1 Y2 Z-2 R1 F10", [25.4, 50.8, 25.4]),
        ("G20 G52 X1\nG1 X0 F10", [25.4, 0, 5]),
        ("T2 M6\nG0 X1 Y2\nG43 H2 Z3\nG1 X4 F100", [4, 2, 3]),
        ("G68.2 X1 Y0 Z0 I0 J60 K0\nG53.1\nG52 Z10\nG1 X0 Y0 Z0 F100", [1, -10 * ROOT, 10 * HALF]),
        ("G68.2 X1 Y0 Z0 I0 J60 K0\nG53.1\nG1 X0 Y0 Z10 F100\nG52 Z10\nG1 X5", [6, -10 * ROOT, 10 * HALF]),
    ],
)
def test_where_a_line_leads(lines, expected):
    found, _ = ends(f"{START}{lines}\nM30\n")
    np.testing.assert_allclose(found[max(found)], expected, atol=1e-9)


PLANE = "G68.2 X0 Y0 Z0 I0 J60 K0"


@pytest.mark.parametrize(
    ("control", "line", "word"),
    [
        ("fanuc", f"{PLANE} R30", "R30"),
        ("fanuc", f"{PLANE} Q5", "Q5"),
        ("fanuc", "G69 X5", "X5"),
        ("fanuc", f"{PLANE}\nG53.1 Z50", "Z50"),
        ("fanuc", "G1 X5 R2 F100", "R2"),
        ("fanuc", "G1 X5 I3 F100", "I3"),
        ("fanuc", "G1 X5 P2 F100", "P2"),
        ("fanuc", "G2 X0 Y-10 I-10 R10 F100", "both"),
        ("fanuc", "G80 R3", "R3"),
        ("siemens", "G1 X5 CR=4 F100", "CR=4"),
        ("siemens", "TRANS X5 I=3", "I=3"),
        ("siemens", "MCALL CYCLE81(10,0,2,-8) X5", "X5"),
        ("heidenhain", "L X+5 IPA+20 F100", "IPA+20"),
        ("heidenhain", "L X+5 Q5=3 F100", "Q5=3"),
        ("heidenhain", "PLANE RESET STAY X+5", "X+5"),
        ("heidenhain", "L X+5 SEQ- F100", "SEQ-"),
        ("heidenhain", "CC X+5 R20", "R20"),
        ("heidenhain", "PLANE SPATIAL SPA+0 SPB+0 SPC+0 STAY Q7=1", "Q7=1"),
    ],
)
def test_no_word_behind_a_known_word_is_dropped(control, line, word):
    start = START if control != "heidenhain" else "L X+10 Y+0 Z+5 A+0 C+0 FMAX\n"
    last = (start + line).count("\n") + 1
    with pytest.raises(InputError, match=rf"line {last}: .*found .*{re.escape(word)}"):
        ends(f"{start}{line}\n", control)


def test_behind_a_plane_to_which_the_slides_move_their_places_are_not_known():
    text = "L X+10 Y+0 Z+5 A+0 C+0 FMAX\nPLANE SPATIAL SPA+60 SPB+0 SPC+0 MOVE DIST50 F1000\nL Z+1 F100\n"
    with pytest.raises(InputError, match="line 3: expected words of X, Y, Z before or in the first move, found"):
        ends(text, "heidenhain")


@pytest.mark.parametrize(
    ("lines", "line", "said"),
    [
        ("G43.4 H1\nG0 X0 Y0 Z20 A30\nG81 X1 Y2 Z-7 R2 F100", 6, "a drilling cycle with TCP, found 30.000° off it"),
        (
            "G43.4 H1\nG0 X0 Y0 Z20\nG81 X1 Y2 Z-7 R2 A30 F100",
            6,
            "rotary axes that stand still in a drilling cycle",
        ),
        (f"{PLANE}\nG81 X1 Y2 Z-7 R2 F100", 5, "a drilling cycle on the tilted plane, found 60.000° off it"),
        (f"G43.4 H1\n{PLANE}\nG53.1", 6, "TCP off where the rotary axes turn to a plane or back, found it is on"),
    ],
)
def test_holes_and_planes_that_would_be_misread_under_tcp_are_refused(lines, line, said):
    with pytest.raises(InputError, match=f"line {line}: .*{re.escape(said)}"):
        ends(f"{START}{lines}\nM30\n")


@pytest.mark.parametrize("line", ["PLANE SPATIAL SPA+60 SPB+0 SPC+0 TURN FMAX", "PLANE RESET TURN FMAX"])
def test_a_klartext_plane_that_turns_under_tcp_is_refused(line):
    with pytest.raises(InputError, match="line 4: .*TCP off where the rotary axes turn"):
        ends(f"0 BEGIN PGM A MM\n1 L X+0 Y+0 Z+50 A+0 C+0 FMAX\n2 M128\n3 {line}\n4 END PGM A MM\n", "heidenhain")


def test_a_hole_under_tcp_goes_along_the_tool():
    """Upright, and on a plane that the tool is square to: both as without TCP."""
    hole = "G99 G81 X1 Y2 Z-7 R2 F100"
    for before, expected in (("", [1, 2, 2]), (f"{PLANE}\nG53.1\n", [1, 2 * HALF - 2 * ROOT, 2 * ROOT + 2 * HALF])):
        found, _ = ends(f"{START}{before}G43.4 H1\nG0 X0 Y0 Z20\n{hole}\nM30\n")
        np.testing.assert_allclose(found[max(found)], expected, atol=1e-9)


def test_an_arc_keeps_its_radius_and_its_sense():
    text = f"{START}G3 X-10 Y0 I-10 J0 Z7 F100\nM30\n"
    _, found = ends(text)
    arc = found.blocks.words[found.lines == 4]
    np.testing.assert_allclose(np.hypot(*arc[:, :2].T), 10, atol=1e-9)
    assert (arc[:-1, 1] > 0).all()
    np.testing.assert_allclose(np.interp(7, arc[:, 2], arc[:, 0]), -10)
    for radius, centre in (("R10", (0, 0)), ("R-10", (10, -10))):  # a quarter, or three
        arc = ends(f"{START}G2 X0 Y-10 {radius} F100\nM30\n")[1].blocks.words[3:]
        np.testing.assert_allclose(np.hypot(*(arc[:, :2] - centre).T), 10, atol=1e-9)


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
    assert program.skipped["CYCL DEF 7.0"] == 1


def test_tool_axis_vectors_and_machine_coordinates_of_siemens():
    turned = "G1 X1 Y2 Z3 A3=0 B3=-0.5 C3=0.8660254 F100"
    text = f"G90 G710 G0 A0 C0\nG0 X0 Y0 Z50\nTRAORI\n{turned}\nTRAFOOF\nSUPA G0 Z100\nM30\n"
    _, program = ends(text, "siemens")
    kin_words = program.blocks.words
    np.testing.assert_allclose(kin_words[1], [1, 2, 3, 30, 0], atol=1e-5)
    np.testing.assert_allclose(kin_words[-1, 2], 100 - AC.tool_length)  # the slide stands at 100


KLARTEXT = "0 BEGIN PGM A MM\n1 TOOL CALL 3 Z S1000\n2 L A+0 C+0 FMAX\n"
TILTED = "8 CYCL DEF 7.0 DATUM\n9 CYCL DEF 7.1 Z+10\n10 L X+0 Y+0 Z+0 F100\n"


@pytest.mark.parametrize(
    "tilt",
    [
        "3 PLANE SPATIAL SPA+60 SPB+0 SPC+0 TURN FMAX\n",
        "3 CYCL DEF 19.0 WORKING PLANE\n4 CYCL DEF 19.1 A+60\n5 L A+Q120 C+Q122 FMAX\n",
    ],
)
def test_a_shift_on_a_tilted_plane_goes_along_it(tilt):
    """Behind a tool change nobody knows X Y Z, and the rotary axes turn nevertheless."""
    program = reader.follow(KLARTEXT + tilt + "7 L X+0 Y+0 Z+50 FMAX\n" + TILTED, AC, "heidenhain")
    np.testing.assert_allclose(program.blocks.words[-1], [0, -10 * ROOT, 10 * HALF, 60, 0], atol=1e-9)
    with pytest.raises(InputError, match="the shift on the tilted plane taken back"):
        reader.follow(KLARTEXT + tilt + TILTED + "11 PLANE RESET STAY\n", AC, "heidenhain")


def test_an_absolute_shift_takes_the_place_of_the_last_an_incremental_one_adds_to_it():
    shifts = "5 CYCL DEF 7.0 DATUM\n6 CYCL DEF 7.1 {}\n7 L X+1 Y+0 Z+0 F100\n"
    program = KLARTEXT + "3 L X+0 Y+0 Z+50 FMAX\n" + "".join(map(shifts.format, ("X+10", "X+20", "IX+5", "IX-2")))
    found = reader.follow(program, AC, "heidenhain").blocks.words[-4:, 0]
    np.testing.assert_allclose(found, [11, 21, 26, 24])


RESET = (
    "20 CYCL DEF 7.0 DATUM\n21 CYCL DEF 7.1 X+0\n22 CYCL DEF 7.2 Y+0\n23 CYCL DEF 7.3 Z+0\n24 PLANE RESET STAY\n"
)


def test_a_shift_of_0_on_a_tilted_plane_takes_back_the_one_before_it():
    """Posts end an operation so: the datum first, then the plane."""
    shift = "3 CYCL DEF 7.0 DATUM\n4 CYCL DEF 7.1 X+100\n5 PLANE SPATIAL SPA+0 SPB+0 SPC+0 STAY\n"
    text = f"{KLARTEXT}{shift}{RESET}30 L X+1 Y+2 Z+3 F100\n"
    np.testing.assert_allclose(reader.follow(text, AC, "heidenhain").blocks.words[-1, :3], [1, 2, 3])
    with pytest.raises(InputError, match="a shift on a tilted plane without one before it, found 100 in X"):
        reader.follow(text.replace("X+0", "X+7"), AC, "heidenhain")


@pytest.mark.parametrize("start", ["A+0 C+0", "A+0"])
def test_rotary_axes_that_turn_to_a_plane_alone_leave_the_slides_where_they_are(start):
    """So the height that holds on the plane is that of the slides as they stand, C known before or not."""
    turn = "4 PLANE SPATIAL SPA+60 SPB+0 SPC+0 STAY\n5 L A+Q120 C+Q122 F900\n6 L X+1 Y+2 FMAX\n"
    program = reader.follow(f"2 L {start} FMAX\n3 L X+0 Y+0 Z+30 FMAX\n{turn}", AC, "heidenhain")
    at = list(program.lines).index(4)
    np.testing.assert_allclose(program.blocks.words[at], [0, 0, 30, 60, 0], atol=1e-9)
    assert not program.blocks.tcp[at] and program.blocks.feeds[at] == 900
    # 50 mm above the A axis lies the origin, the tip 30 mm above it: along the plane's normal 80 - 50 / 2.
    tip = program.blocks.words[-1, :3]
    np.testing.assert_allclose(tip @ [0, -ROOT, HALF], 80 - 50 * HALF, atol=1e-9)


def test_places_that_the_maker_of_a_machine_has_set_are_not_known():
    start = "0 L X+0 Y+0 Z+50 A+0 C+0 FMAX\n1 L Z+0 R0 FMAX M92\n"
    with pytest.raises(InputError, match="line 3: expected a Z word"):
        ends(f"{start}2 L X+1 F100\n", "heidenhain")
    found, program = ends(f"{start}2 L X+1 FMAX\n3 L Z+5 FMAX\n", "heidenhain")
    np.testing.assert_allclose(found[4], [1, 0, 5])
    assert any("M92 in line 2 goes to where the machine's maker has set it" in each for each in program.assumed)


def test_what_follows_m128_is_how_fast_the_slides_follow_and_cycle_9_speaks_any_language():
    text = (
        "0 L X+0 Y+0 Z+50 A+0 C+0 F200\n1 CYCL DEF9.0 VERWEILZEIT\n2 CYCL DEF9.1 V.ZEIT12\n3 L M128 F5\n4 L X+1\n"
    )
    _, program = ends(text, "heidenhain")
    assert program.blocks.feeds[-1] == 200 and program.dwell == 12
    _, program = ends(text.replace("F5", "FQ8"), "heidenhain")  # nobody needs the number
    assert program.blocks.feeds[-1] == 200


def test_rotations_of_siemens_follow_one_another_and_a_new_one_deletes_them():
    text = f"{SIEMENS_AC}TRAORI\nTRANS X100\nAROT Z90\nATRANS X10\nAROT X90\nG1 X1 Y2 Z3 F9\n"
    found, _ = ends(text, "siemens")
    # About the last X: (1, 2, 3) is (1, -3, 2); 10 along X; about Z: (3, 11, 2); and 100.
    np.testing.assert_allclose(found[8], [103, 11, 2], atol=1e-9)
    for line, expected in (("ROT Z-90", [2, -1, 3]), ("ROT", [1, 2, 3]), ("TRANS Y5", [1, 7, 3])):
        found, _ = ends(f"{text}{line}\nX1 Y2 Z3\n", "siemens")
        np.testing.assert_allclose(found[10], expected, atol=1e-9)


def test_plane_reset_with_turn_takes_the_rotary_axes_to_0_and_the_slides_nowhere():
    """On the plane the words are the tip; behind it the slides, at c + R·(p - c), c 50 mm below the origin."""
    tilted = "3 PLANE SPATIAL SPA+60 SPB+0 SPC+0 TURN FMAX\n4 L X+1 Y+2 Z+50 FMAX\n"
    words = reader.follow(KLARTEXT + tilted + "5 PLANE RESET TURN FMAX\n", AC, "heidenhain").blocks.words[-2:]
    np.testing.assert_allclose(words[0], [1, 2 * HALF - 50 * ROOT, 2 * ROOT + 50 * HALF, 60, 0], atol=1e-9)
    np.testing.assert_allclose(words[1], [1, 2 + 50 * ROOT, 50 - 50 + 50 * HALF, 0, 0], atol=1e-9)


def test_a_new_swivel_plane_deletes_what_was_programmed_before():
    """Between TRANS and CYCLE800 the words are shifted, behind it a TRANS goes along the plane."""
    swivel = 'CYCLE800(0,"TC1",0,57,0,0,0,60,0,0,0,0,0,-1,0,1)'
    text = f"G90 G710 G0 A0 C0\nX0 Y0 Z50\nTRANS X7\nG0 X0\n{swivel}\nTRANS Z10\nG1 X0 Y0 Z0 F100\nM30\n"
    found, _ = ends(text, "siemens")
    np.testing.assert_allclose(found[4][0], 7)
    np.testing.assert_allclose(found[7], [0, -10 * ROOT, 10 * HALF], atol=1e-9)
    absolute, _ = ends(f"G710\n{START}G2 X0 Y-10 I=AC(0) J=AC(0) F100\nM30\n", "siemens")
    np.testing.assert_allclose(absolute[5], [0, -10, 5], atol=1e-9)


@pytest.mark.parametrize(
    ("control", "lines", "said"),
    [
        ("fanuc", "G41 D3\nG1 X1. F100", "line 4 \\(G41\\) compensates is 0"),
        ("fanuc", "T2 M6\nG0 X1. Y0. Z5.\nG1 X2. F100", "A, C stand still while a tool is changed"),
        ("fanuc", "G1 X1 F100", "X10 in line 3 counts mm, .*3401"),
        ("siemens", "G42\nG1 X1 F100", "G42"),
        ("linuxcnc", "M428\nG1 X1 F100\nM429", "M428 in line 4 switches TCP: .* how machines are configured"),
    ],
)
def test_what_is_taken_for_granted_is_said(control, lines, said):
    _, program = ends(f"{START}{lines}\nM30\n", control)
    assert any(re.search(said, sentence) for sentence in program.assumed), program.assumed


def test_a_unit_that_nobody_states_is_said():
    _, program = ends(START.replace("G21", ""), "haas")
    assert "no word says whether positions are mm or inches: mm, --unit states it" in program.assumed
    stated, program = ends(START.replace("G21", ""), "haas", unit="inch")
    assert not any("--unit" in each for each in program.assumed)
    np.testing.assert_allclose(stated[3], [254, 0, 127])
    np.testing.assert_allclose(ends(START, "haas", unit="inch")[0][3], [10, 0, 5])  # G21
    with pytest.raises(InputError, match="line 1"):
        ends("0 BEGIN PGM A IN\n", "heidenhain")
    inch, _ = ends("BEGIN PGM A INCH\nL X+1 Y+0 Z+2 A+0 C+0 F9\n", "heidenhain")
    np.testing.assert_allclose(inch[2], [25.4, 0, 50.8])


@pytest.mark.parametrize(
    "option", ["F TCP AXIS SPAT PATHCTRL AXIS", "F TCP AXIS POS PATHCTRL AXIS REFPNT CENTER-CENTER"]
)
def test_another_meaning_of_the_words_under_tcp_is_refused(option):
    with pytest.raises(InputError, match="line 4"):
        ends(f"{KLARTEXT}3 FUNCTION TCPM {option}\n", "heidenhain")


def test_machine_coordinates_are_absolute():
    with pytest.raises(InputError, match="line 4: expected machine coordinates in absolute numbers"):
        ends(f"{START}G91 G53 Z0\n")


def test_tool_axis_vectors_of_fanuc():
    text = f"{START}G43.5 H1\nG1 X1 Y2 Z3 I0 J-0.5 K0.8660254 F100\nX2\nG43.4 H1\nG3 X1 Y3 I-1 J0\n"
    _, program = ends(text)
    rows = [program.blocks.words[program.lines == line][-1] for line in (5, 6, 8)]
    np.testing.assert_allclose(rows, [[1, 2, 3, 30, 0], [2, 2, 3, 30, 0], [1, 3, 3, 30, 0]], atol=1e-5)
    with pytest.raises(InputError, match="line 8: expected a straight move where the tool axis is a vector"):
        ends(text.replace("G43.4", "G43.5"))


def test_offsets_and_lengths_are_asked_for():
    text = f"G54\n{START}G55\nG1 X0 Y0 Z0 F100\nM30\n"
    with pytest.raises(InputError, match="line 5: expected the origin of G55: --origin G55=X,Y,Z"):
        ends(text)
    found, _ = ends(text, offsets={"G55": (7, 8, 9)})
    np.testing.assert_allclose(found[6], np.subtract([7, 8, 9], AC.origin))
    placed, _ = ends("G21 G90\nG1 X4 F100\nM30\n", start={"X": 1, "Y": 2, "Z": 3, "A": 0, "C": 0})
    np.testing.assert_allclose(placed[2], [4, 2, 3])
    shifted, _ = ends(
        "G21 G90\nG54\nG1 X4 F100\nM30\n", start=dict(X=1, Y=2, Z=3, A=0, C=0), offsets={"G54": (7, 8, 9)}
    )
    np.testing.assert_allclose(
        shifted[3], np.add([4, 2, 3], [0, *np.subtract(AC.origin, [7, 8, 9])[1:]])
    )  # the slides stand
    tools = f"T1 M6\n{START}T2 M6\nG0 X0 Y0 Z0 A0 C0\nM30\n"
    with pytest.raises(InputError, match="line 5: expected the length of tool 2"):
        ends(tools, lengths={})
    _, program = ends(tools, lengths={"1": 50.0, "2": 80.0})
    assert [each.tool_length for _, each in program.machines][-2:] == [50.0, 80.0]


KLARTEXT_AC = "0 BEGIN PGM A MM\n1 L X+0 Y+0 Z+5 A+0 C+0 FMAX\n"
SIEMENS_AC = "G90 G710 G0 A0 C0\nG0 X0 Y0 Z5\n"


@pytest.mark.parametrize(
    ("control", "lines", "expected", "feed"),
    [
        ("siemens", "DEF REAL _x, _y\n_x=5 _y=-2\nG1 X=_x Y=-_y Z=_x*2-1 F=100*_x", [5, 2, 9], 500),
        ("siemens", "DEF REAL _Z_HOME=30\nR1=_Z_HOME/4\nG1 X=R1 Y=-R1 Z=AC(R1) F=R1", [7.5, -7.5, 7.5], 7.5),
        ("siemens", "DEF REAL _t\n_t=1\nCYCLE832(_t,0,1)\n_t=2\nCYCLE832(_t,1,1)\nG1 X2 F2", [2, 0, 5], 2),
        ("siemens", "GOTOF ENDE\nG1 X9 F1\nENDE: G1 Y3 F2", [0, 3, 5], 2),
        ("heidenhain", "FN 0: Q50 =+550 ; Cutting\nL X+3 FQ50", [3, 0, 5], 550),
        ("heidenhain", "FN 0: Q50 =+550\nL X+3 FQ50\nFN 0: Q50 =+90\nL X+4 FQ50", [4, 0, 5], 90),
        ("siemens", "R1=5\nG1 X=R1 F9\nR1=R1+1\nX=R1", [6, 0, 5], 9),
        ("fanuc", "#1=1.\nM98 P10 L3\nG1 X#1 F5\nM30\nO10\n#1=#1+1\nM99", [4, 0, 5], 5),
        ("heidenhain", "Q1 = (+8 - 2) / +4\nFN 3: Q2 = +Q1 * -2\nL X+Q1 Y-Q1 Z+Q2 F9", [1.5, -1.5, -3], 9),
        ("heidenhain", "CALL LBL 7\nCALL LBL 7\nL Y+1\nM30\nLBL 7\nL IX+2 F50\nLBL 0", [4, 1, 5], 50),
        ("fanuc", "#1=5.\n#2=#1*-2\nG1 X#1 Y-#2 Z[#1+[1-#1]/2] F#1", [5, 10, 3], 5),
        ("fanuc", "G91\nM98 P1000 L3\nG1 Z1.\nM30\nO1000\nG1 X2. F8\nM99", [6, 0, 6], 8),
        ("fanuc", "GOTO 40\nG1 X9. F1\nN40 G1 Y3. F2", [0, 3, 5], 2),
        ("haas", "G91\nM97 P10\nM30\nN10 G1 X2. F8\nM99", [2, 0, 5], 8),
        ("linuxcnc", "#<f>=70\nM428\nG1 X3. F#<f>\nM429", [3, 0, 5], 70),
    ],
)
def test_constants_subprograms_and_jumps_ahead(control, lines, expected, feed):
    start = {"heidenhain": KLARTEXT_AC, "siemens": SIEMENS_AC}.get(control, "G21 G90 G0 X0. Y0. Z5. A0. C0.\n")
    _, program = ends(f"{start}{lines}\n", control)
    np.testing.assert_allclose(program.blocks.words[-1][:3], expected, atol=1e-9)
    assert program.blocks.feeds[-1] == feed


@pytest.mark.parametrize(
    ("control", "lines", "line", "said"),
    [
        ("siemens", "/R1=5", 3, "always has its number, found one behind an oblique stroke"),
        ("siemens", "R1=R1+1", 3, "an expression of numbers"),
        ("siemens", "_x=5", 3, "'_X=5'"),  # not declared
        ("siemens", "AA: G0 X1\nGOTO AA", 4, "a jump to a later line, and from no subprogram, found one to line 3"),
        ("siemens", "R1=2\nIF R1>1 GOTOF AA", 4, "from line to line"),
        ("heidenhain", "L X+Q9 FMAX", 3, "'X\\+Q9'"),
        ("heidenhain", "LBL 1\nL IX+1 F9\nCALL LBL 1 REP 2", 5, "from line to line"),
        ("heidenhain", "CALL LBL 4", 3, "one line in the program that begins as 4, found 0"),
        ("fanuc", "#5221=1.", 2, "a variable of the program"),
        ("fanuc", "G1 X#500 F1", 2, "'X#500'"),
        ("fanuc", "#1=1/0", 2, "an expression of numbers"),
        ("fanuc", "#1=2**9", 2, "an expression of numbers"),
        ("fanuc", "T" + 400 * "9", 2, "numbers of less than 40 digits"),
        ("siemens", "CYCLE800(", 3, "CYCLE800 with at least ten arguments"),
        ("siemens", 'CYCLE800(-,"",0,57,0,0,0,0,45,0,0,0,0,-1)', 3, "a whole number as argument 1"),
        ("fanuc", "M99", 2, "it begins again"),
        ("fanuc", "M98 P1\nM30\nO1\nM98 P1\nM99", 5, "calls within calls"),
        ("fanuc", "M98 P1 L9999999\nM30\nO1\nG0 X1.\nM99", 2, "calls within calls"),
        ("fanuc", "M98 P1\nM30\nO1\nG0 X1.", 2, "the end of the subprogram"),
    ],
)
def test_what_depends_on_how_a_program_runs_is_refused_with_its_line(control, lines, line, said):
    start = {"heidenhain": KLARTEXT_AC, "siemens": SIEMENS_AC}.get(control, "G21 G90 G0 X0. Y0. Z5. A0. C0.\n")
    with pytest.raises(InputError, match=rf"line {line}: .*{said}"):
        ends(f"{start}{lines}\n", control)


def test_all_stops_are_told_at_once_and_what_may_move_the_machine_is_not_offered():
    text = f"{START}M200 P5\nG1 X1 F100\nM317\nG102 X3\nM428\nM317\nIF [#1 EQ 0] GOTO 5\nM30\nM999\n"
    with pytest.raises(InputError) as caught:
        ends(text)
    offered, others = str(caught.value).split(". Not read, and may move an axis or decide what runs: ")
    assert offered.startswith("program, line 4: expected a word of a fanuc program, found 'M200'. Not known")
    assert "M200 P{} (line 4), M317 (line 6, 9). Those that move no axis: in [program]" in offered
    assert """skip = ["M200 P{}", "M317"], or for verify --skip 'M200 P{}' --skip M317""" in offered
    assert "G102 (line 7), M428 (line 8), IF" in others and "M999" not in str(caught.value)


def test_moves_from_nobody_knows_where_are_said():
    """Rotary axes may go to their first position at a feed, one by one; nothing else may."""
    _, program = ends("L Z+5 FMAX\nL A+0 F5000\nL C+0 F5000\nL X+1 Y+2 FMAX\nL Z+1 F100\n", "heidenhain")
    assert list(program.lines) == [4, 5]
    assert any("in line 1 first one moves without that: X, Y, A, C" in each for each in program.assumed)
    with pytest.raises(InputError, match="line 2: expected words of X, C before .* or --start X0,Z7,C0"):
        ends("L A+0 F5000\nL Y+0 F5000\n", "heidenhain", start={"Z": 7})
