"""Every move of a program is proved, the user's lines of head, foot and tool change among them."""

import tomllib
from dataclasses import replace

import pytest

from mathpost import load_machine, machine_file, postprocess
from mathpost.errors import MathpostError
from mathpost.files import read_toml
from mathpost.path import cl
from mathpost.shop.post.verify import verify
from tests.conftest import DATA

TABLE = load_machine("ac_table")  # Z −400 … 400, safe at 390; the nose goes lower than the part at 0
PART = cl.parse(
    "UNITS/MM\nLOADTL/1\nFEDRAT/500,MMPM\nGOTO/0,0,60\nGOTO/20,0,60\nLOADTL/2\nGOTO/20,0,60\nGOTO/0,0,60"
)
HEAD = {"fanuc": "G40", "siemens": "G40", "heidenhain": "; OURS"}


def made(dialect, part=PART, base=TABLE, **own):
    whole = {"program_head": (HEAD[dialect],)} | {key: tuple(lines) for key, lines in own.items()}
    return postprocess(part, replace(base, **whole), dialect=dialect)


@pytest.mark.parametrize("key", ["program_head", "program_foot", "tool_change"])
@pytest.mark.parametrize(
    ("dialect", "lines", "found"),
    [
        ("fanuc", ["G0 G53 Z0"], "Z 0, where|meets"),
        ("fanuc", ["G00 G53 Z189."], None),  # with the tool that is in the spindle the part reaches Z 181.7
        ("fanuc", ["G0 G53 Z410"], "Z 410.000 mm is outside"),
        ("fanuc", ["G0 Z10."], "Z 130, where|meets"),
        ("fanuc", ["G0 G53 Z390", "G53 X9000"], "X 9000.000 mm is outside"),
        ("fanuc", ["G28 Z0"], "Z 120, where|meets"),  # by Z0 of the workpiece
        ("siemens", ["SUPA G0 Z=0"], "Z 0, where|meets"),
        ("heidenhain", ["L Z-5 R0 FMAX M91"], "Z -5, where|meets"),
        ("heidenhain", ["L Z+10 R0 FMAX"], "Z 130, where|meets"),
        ("fanuc", ["G54", "G0 G53 Z390", "G53 X0 Y0 A0", "M5"], None),
        ("fanuc", ["G91 G28 Z0", "G90", "G0 G53 X0 Y0", "T1 M6", "G43 H1"], None),
        ("siemens", ["SUPA G0 Z390 D0", 'T="MILL_1"', "M6"], None),
        ("heidenhain", ["L Z+400 R0 FMAX M91", "TOOL CALL 1 Z S500"], None),
        ("fanuc", ["G65 P9810 Z10."], "runs from line to line, found 'G65"),
        ("fanuc", ["M250 P1"], "found 'M250'.*skip"),
    ],
)
def test_lines_of_the_user_are_read_and_proved(key, dialect, lines, found):
    if found is None:
        made(dialect, **{key: lines})
    else:
        name = {"program_head": "head", "program_foot": "foot", "tool_change": "tool_change"}[key]
        with pytest.raises(MathpostError, match=rf"\[program\] {name}, .*({found})"):
            made(dialect, **{key: lines})


@pytest.mark.parametrize("lines", [["G0 G53 X0 Y0", "G0 G53 Z390"], ["G0 G53 X0 Y0 Z390"], ["G0 G53 A0"]])
def test_z_goes_up_before_other_axes_move(lines):
    """At the beginning nobody knows where it stands; behind the path it is at the safe position."""
    with pytest.raises(MathpostError, match=r"\[program\] head, .*nobody knows where Z stands"):
        made("fanuc", program_head=lines)
    made("fanuc", program_foot=lines)


def test_what_moves_nothing_is_declared():
    assert "M250 P1" in made("fanuc", base=replace(TABLE, skip=("M250 P{}",)), program_foot=["M250 P1"]).program
    content = read_toml(DATA / "machines/ac_table.toml")
    content["program"] = {"skip": ["M250 P{}"]}
    content["linear"]["home"] = {"Z": 400.0}
    asked = machine_file.from_dict(content)
    assert asked.skip == ("M250 P{}",) and dict(asked.home) == {"Z": 400.0}
    with pytest.raises(MathpostError, match="'G28', home"):
        made("fanuc", base=replace(TABLE, skip=("G28",)))


@pytest.mark.parametrize(("at", "safe"), [(390.0, True), (50.0, False)])
def test_a_reference_point_is_where_the_machine_file_has_it(at, safe):
    base = replace(TABLE, home=(("Z", at),))
    if safe:
        made("fanuc", base=base, program_foot=["G91 G28 Z0", "G90", "G53 X0 Y0"])
    else:
        with pytest.raises(MathpostError, match="Z 50.* is not above what the path cuts|meets what the path cuts"):
            made("fanuc", base=base, program_foot=["G91 G28 Z0", "G90", "G53 X0 Y0"])


def test_a_safe_position_below_the_part_is_refused():
    """What is cut at Y-160 is at Z110 with A at 90°; nobody knows where A stands when the program begins."""
    for safe, length, right in ((300.0, 95, True), (300.0, 200, False), (390.0, 200, True)):
        base = replace(TABLE, safe=(None, None, safe))
        longer = cl.parse(f"FEDRAT/500\nLOAD/TOOL,3,LENGTH,{length}\nGOTO/0,-160,0,0,0,1\nGOTO/9,-160,0\n")
        if right:
            made("heidenhain", longer, base)
        else:
            with pytest.raises(MathpostError, match="Z 300"):
                made("heidenhain", longer, base)


def test_the_pages_own_tool_change_is_safe():
    page = (DATA.parent / "mathpost/interface/site/commands.toml").read_text(encoding="utf-8")
    example = page[page.index("[program]\n") :].partition("[linear]")[0]
    own = machine_file.from_dict(read_toml(DATA / "machines/ac_table.toml") | tomllib.loads(example))
    assert "G0 G53 Z390." in postprocess(PART, own, dialect="fanuc").program


DEEP = "G21 G90 G0 X0. Y0. Z5. A0. C0.\nG1 Z-2. F300.\nX50.\nG0 Z5.\n"


@pytest.mark.parametrize(
    ("control", "text", "line"),
    [
        ("fanuc", "G0 X20.\nG0 Z-2.\n", None),  # down into the slot again
        ("fanuc", "G0 X20.\nG1 Z-9. F100\nG0 Z5.\nG0 Z-9.\nG0 Z5.\n", None),  # and into the hole in it
        ("fanuc", "G0 X20.\nG0 Z-9.\nG1 Z5. F100\n", 6),  # a hole that is not there
        ("fanuc", "G0 X80.\nG0 Z-5.\nG1 X60. F100\nG0 X80.\n", None),
        ("siemens", "G0 X80.\nG0 Z-5.\nG0 X20 Z-9\n", 7),  # both axes together, but through the end of the slot
        ("siemens", "G0 X0 Z12\nG0 X50 Z5\n", None),
    ],
)
def test_what_was_cut_before_is_air(control, text, line):
    judged = verify(DEEP + text, TABLE, control)
    assert [judged.line(block) for block in judged.unsure] == ([] if line is None else [line]), judged


@pytest.mark.parametrize("tcp", [False, True])
@pytest.mark.parametrize(("dialect", "change"), [("fanuc", "G0 G53 Z390."), ("heidenhain", "L Z+390 R0 FMAX M91")])
def test_a_tool_change_loads_the_tool(dialect, change, tcp):
    """Without a word for that the control goes on with the length of the tool before."""
    part = cl.parse(
        "LOAD/TOOL,1,LENGTH,120\nFEDRAT/500\nGOTO/0,0,60\nLOAD/TOOL,2,LENGTH,80\nFEDRAT/500\nGOTO/9,0,60"
    )
    own = replace(TABLE, program_head=(HEAD[dialect],), tool_change=(change,))
    with pytest.raises(
        MathpostError, match=r"\[program\] tool_change: expected a word that loads the tool of 80 mm"
    ):
        postprocess(part, own, dialect=dialect, tcp=tcp)
