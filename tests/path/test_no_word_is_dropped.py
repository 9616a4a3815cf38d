"""No word behind a known word of CL data is dropped: it is used, or refused with its line."""

import numpy as np
import pytest

from mathpost import postprocess
from mathpost.errors import InputError
from mathpost.machine_file import load
from mathpost.path import cl as cldata
from mathpost.shop.controls import control

TABLE = load("ac_table")
START = "UNITS/MM\nLOADTL/1\nSPINDL/1000,RPM,CLW\nFEDRAT/100,MMPM\nGOTO/0,0,50\n"
DRILLED = "CYCLE/DRILL,FEDTO,-2,RAPTO,3,RTRCTO,10,MMPM,250"
STATEMENTS = [
    "UNITS/MM", "RAPID/", "FEDRAT/100,MMPM", "LOADTL/2,LENGTH,50", "LOADTL/2,1,1", "LOAD/TOOL,2,ADJUST,3",
    "CUTCOM/LEFT,31", "CUTCOM/ON,LENGTH,5", "SPINDL/500,RPM,CLW", "COOLNT/FLOOD", "STOP", "OPSTOP", "DELAY/2",
    "DELAY/2,REV", "OPSKIP/OFF", "AUXFUN/8", "GOTO/1,2,3", "GODLTA/1,2,3", "FROM/1,2,3", "GOHOME/1,2,3",
    "TLAXIS/0,0,1", "MULTAX/ON", "MODE/INCR", "SET/MODE,ABSOL", "SET/OFSETL,5", "CIRCLE/0,0,50,0,0,1",
    "INDIRV/0,1,0", "CYCLE/OFF", DRILLED, f"{DRILLED}\nCYCLE/ON", "TRNTYP/WORLD,0,0,0", "ORIGIN/0,0,0",
    "ROTABL/0,AAXIS,CCLW", "GOTO/5,0,50\nINDIRV/0,1,0\nTLON,GOFWD/(CIRCLE/0,0,50,5),ON,(LINE/0,0,50,0,5,50)",
]  # fmt: skip


@pytest.mark.parametrize("statement", STATEMENTS)
@pytest.mark.parametrize("word", ["HOCUS", "7.125"])
def test_a_word_that_is_left_is_refused_with_its_line(statement, word):
    *before, last = statement.split("\n")
    line = START.count("\n") + len(before) + 1
    changed = "\n".join(
        [*before, f"{last.removesuffix('/')}{',' if last[-1] != '/' and '/' in last else '/'}{word}"]
    )
    with pytest.raises(InputError, match=f"line {line}"):
        cldata.parse(f"{START}{changed}\nGOTO/1,2,60\n", "part.cl")


@pytest.mark.parametrize("off", ["", "CYCLE/OFF\nGOTO/0,0,50\n"])
def test_cycle_on_goes_on_with_the_words_behind_it(off):
    """The form of a published CLSF: each of its holes is as deep as ON says."""
    text = (
        f"{START}{DRILLED}\nGOTO/0,0,0\n{off}CYCLE/ON,FEDTO,-74.5,RTRCTO,AUTO\nGOTO/9,0,0\nCYCLE/ON\nGOTO/18,0,0\n"
    )
    cl = cldata.parse(text + "CYCLE/OFF\n")
    assert [cl.points[cl.points[:, 0] == x, 2].min() for x in (0, 9, 18)] == [-2, -74.5, -74.5]
    assert cl.feeds[cl.points[:, 2] < 0].tolist() == [250] * 3
    last = [cl.points[cl.points[:, 0] == x, 2][-1] for x in (9, 18)]  # AUTO: to where the tool came from
    assert last == [50 if off else 10] * 2


def test_a_cycle_that_says_a_depth_twice_and_one_that_nothing_began():
    for text in ("CYCLE/DRILL,DEPTH,2,FEDTO,-3,RAPTO,3", "CYCLE/INIT\nCYCLE/ON,FEDTO,-3"):
        with pytest.raises(InputError, match="one word for the depth|a cycle before CYCLE/ON"):
            cldata.parse(f"{START}{text}\nGOTO/1,2,3\n")


def test_a_tool_that_is_called_again_stays_in_the_spindle():
    again = "LOADTL/1,1\nSPINDL/1000,RPM,CLW\nGOTO/10,0,50\n"
    text = "LOADTL/1,1\nCOOLNT/ON\n" + START.removeprefix("UNITS/MM\nLOADTL/1\n") + again
    result = postprocess(cldata.parse(f"UNITS/MM\n{text}"), TABLE, dialect="fanuc")
    assert result.program.count("M6") == 1 and result.program.count("M8") == 1
    assert "they stay: 1" in str(result.report)


@pytest.mark.parametrize("dialect", ["heidenhain", "fanuc", "linuxcnc"])
def test_cl_data_without_a_feed_have_none_in_the_program_and_the_report_says_so_first(dialect):
    text = "UNITS/MM\nGOTO/0,0,50\nGOTO/10,0,50\nGOTO/10,0,60,0,0.6,0.8\n"
    result = postprocess(cldata.parse(text), TABLE, dialect=dialect)
    moves = [line for line in result.program.splitlines() if " X" in line or " Y" in line]
    assert moves and not any(word[0] == "F" for line in moves for word in line.split()[1:])
    assert str(result.report).startswith("no feed      for 3 moves in cut")
    fed = postprocess(cldata.parse(text, feed=300), TABLE, dialect=dialect)
    assert "F300" in fed.program and not str(fed.report).startswith("no feed")


def test_the_unit_of_cl_data_that_state_none():
    text = "TOOL PATH/A,TOOL,B\nGOTO/1,2,3\n"
    assert "mm assumed" in cldata.parse(text).notes[0]
    inches = cldata.parse(text, unit="inch")
    assert np.allclose(inches.points[0], [25.4, 50.8, 76.2]) and not inches.notes
    with pytest.raises(InputError, match="line 1, UNITS"):
        cldata.parse("UNITS/MM\n" + text, unit="inch")


def test_continued_lines_are_taken_in_the_time_of_their_number():
    """What is looked at for each line does not grow with those before it."""
    text = START + "GOTO/1,$\n" + "2,$\n" * 20_000 + "3\n"
    with pytest.raises(InputError, match="3, 6 or 9 numbers"):
        cldata.parse(text)


def test_a_name_that_ends_in_inch_is_a_name():
    words = control.load("heidenhain").words
    for text, unit in (("PART_INCH MM", "mm"), ("PART_MM INCH", "inch"), ("INCH MM", "mm")):
        assert words.begins(f"BEGIN PGM {text}").meaning == unit
