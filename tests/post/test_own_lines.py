"""Lines of the user's, in head, foot and tool change: they go to the safe position, or the program is refused."""

import tomllib
from dataclasses import replace

import pytest

from mathpost import machine, postprocess
from mathpost.errors import InputError
from mathpost.path import cl
from mathpost.shop.controls.control import load
from mathpost.shop.post.own_lines import refuse_unproved
from mathpost.toml_table import read_toml
from tests.conftest import DATA

TABLE = machine.load("ac_table")  # Z −400 … 400, safe at 390; the nose goes lower than the part at 0
PART = cl.parse(
    "UNITS/MM\nLOADTL/1\nFEDRAT/500,MMPM\nGOTO/0,0,60\nGOTO/20,0,60\nLOADTL/2\nGOTO/20,0,60\nGOTO/0,0,60"
)


@pytest.mark.parametrize("key", ["program_head", "program_foot", "tool_change"])
@pytest.mark.parametrize(
    ("dialect", "lines", "found"),
    [
        ("fanuc", ["G0 G53 Z0"], "Z 390, the safe position, or further away from the part, found 0"),
        ("fanuc", ["G00 G53 Z389."], "found 389"),
        ("fanuc", ["G0 G53 Z410"], "found 410"),
        ("fanuc", ["G0 Z100."], "moves in machine coordinates"),
        ("fanuc", ["G0 G53 X0 Y0", "G0 G53 Z390"], "Z at the safe position before other axes move"),
        ("fanuc", ["G0 G53 Z390", "G0 G53 X9000"], "X within its travel"),
        ("siemens", ["SUPA G0 Z=0"], "found 0"),
        ("heidenhain", ["L Z-5 R0 FMAX M91"], "found -5"),
        ("heidenhain", ["L Z+100 R0 FMAX"], "moves in machine coordinates"),
        ("fanuc", ["G54", "G0 G53 Z390", "G53 X0 Y0 A0", "M5"], None),
        ("fanuc", ["G91 G28 Z0", "G90", "T{tool} M6", "G43 H{tool}"], None),
        ("siemens", ["SUPA G0 Z390 D0", 'T="MILL_{tool}"', "M6"], None),
        ("heidenhain", ["L Z+400 R0 FMAX M91", "TOOL CALL {tool} Z S500"], None),
    ],
)
def test_a_line_that_moves_goes_to_the_safe_position(key, dialect, lines, found):
    own = replace(TABLE, **{key: tuple(lines)})
    if found is None:
        refuse_unproved(own, load(dialect))
    else:
        with pytest.raises(InputError, match=r"\[program\]") as error:
            refuse_unproved(own, load(dialect))
        assert found in str(error.value)


def test_without_a_safe_position_no_line_moves():
    with pytest.raises(InputError, match="safe = "):
        refuse_unproved(replace(TABLE, safe=None, tool_change=("G0 G53 Z390",)), load("fanuc"))


def test_a_tool_change_through_the_part_is_refused_and_the_page_shows_one_that_is_not():
    with pytest.raises(InputError, match="Z 390"):
        postprocess(PART, replace(TABLE, tool_change=("G0 G53 Z0", "T{tool} M6")), dialect="fanuc")
    page = (DATA.parent / "mathpost/interface/site/commands.toml").read_text(encoding="utf-8")
    example = page[page.index("[program]\n") :].partition("[linear]")[0]
    own = machine.from_dict(read_toml(DATA / "machines/ac_table.toml") | tomllib.loads(example))
    assert "G0 G53 Z390." in postprocess(PART, own, dialect="fanuc").program
