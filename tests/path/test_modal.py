"""What words leave behind: spindle, coolant, compensation, offsets, feeds, optional skip, in all forms.

A case is a piece of CL data and what the control is told in the end, without the repetitions that are harmless.
"""

import re
from dataclasses import replace

import numpy as np
import pytest

from mathpost import load_machine, postprocess
from mathpost.errors import InputError
from mathpost.path import cl as cldata
from mathpost.path.cl_words import ALIASES, COMMENTS, MOVING, REFUSED, Statements
from mathpost.path.moves import Movements
from mathpost.shop.controls.reader import read as read_program
from tests.conftest import DATA

TABLE, HEAD = (load_machine(DATA / f"machines/{name}.toml") for name in ("ac_table", "ac_head"))
MOVES = "FEDRAT/100,MMPM\nGOTO/0,0,0\nGOTO/9,0,0\n"
DIALECTS = ("heidenhain", "fanuc", "siemens")


def read(text, **options):
    return cldata.parse(f"UNITS/MM\n{text}", "part.cl", **options)


def told(text, kind):
    """The values of the commands of a kind."""
    return [remark.values for _, remark in read(text).remarks if getattr(remark, "kind", "") == kind]


def refused(text, **options):
    with pytest.raises(InputError) as caught:
        read(text, **options)
    return str(caught.value)


def lines(text, dialect, data=TABLE, **options):
    """The lines of a program without their numbers."""
    program = postprocess(read(text), data, dialect=dialect, **options).program
    return [line.lstrip("N0123456789").strip() for line in program.splitlines()]


@pytest.mark.parametrize(
    ("text", "turning"),
    [
        ("SPINDL/600,RPM,CCLW\nSPINDL/OFF\nSPINDL/ON", [(600, "CCLW"), (None, "OFF"), (None, "CCLW")]),
        ("SPINDL/600,RPM,CCLW\nSPINDL/ON", [(600, "CCLW"), (None, "CCLW")]),
        ("SPINDL/RPM,600,CCLW\nSPINDL/RPM,800", [(600, "CCLW"), (800, "CCLW")]),
        ("SPINDL/600,RPM,CCW\nSPINDL/STOP\nSPINDL/800", [(600, "CCLW"), (None, "OFF"), (800, "CCLW")]),
        ("SPINDL/600,RPM,CLW\nSPINDL/ON", [(600, "CLW"), (None, "CLW")]),
        ("SPINDL/ON", [(None, "CLW")]),
        ("SPINDL/ 600.0, RPM, CLW, RANGE, 2", [(600, "CLW")]),
        ("SPINDL/ RPM, 600, CLW, RANGE, LOW", [(600, "CLW")]),
        ("SPINDL/600,RPM,CCLW,HIGH", [(600, "CCLW")]),
    ],
)
def test_spindle(text, turning):
    assert told(f"{text}\nGOTO/0,0,0", "spindle") == turning


@pytest.mark.parametrize(
    ("text", "coolants"),
    [
        ("COOLNT/MIST\nCOOLNT/OFF\nCOOLNT/ON", ["MIST", "OFF", "MIST"]),
        ("COOLNT/FLOOD\nCOOLNT/OFF\nCOOLNT/ON", ["FLOOD", "OFF", "FLOOD"]),
        ("COOLNT/MIST\nCOOLNT/FLOOD,OFF\nCOOLNT/ON", ["MIST", "OFF", "FLOOD"]),
        ("COOLNT/FLOOD,OFF", ["OFF"]),
        ("COOLNT/ON", ["FLOOD"]),
        ("COOLNT/ON,MIST", ["MIST"]),
        ("COOLNT / FLOOD, HIGH", ["FLOOD"]),
        ("COOLNT/THRU\nCOOLNT/OFF\nCOOLNT/ON", ["THRU", "OFF", "THRU"]),
        ("COOLNT/MIST,ON\nCOOLNT/TAP\nCOOLNT/OFF", ["MIST", "TAP", "OFF"]),
    ],
)
def test_coolant(text, coolants):
    assert [kind for (kind,) in told(f"{text}\nGOTO/0,0,0", "coolant")] == coolants


@pytest.mark.parametrize(
    ("text", "sides"),
    [
        ("CUTCOM/LEFT,31", [("LEFT", 31)]),
        ("CUTCOM / RIGHT, 31", [("RIGHT", 31)]),
        ("CUTCOM/LEFT,XYPLAN,31", [("LEFT", 31)]),
        ("CUTCOM/ LEFT, XYPLAN, OSETNO, 31", [("LEFT", 31)]),
        ("CUTCOM/LEFT,31\nCUTCOM/OFF\nCUTCOM/ON", [("LEFT", 31), ("OFF", 31), ("LEFT", 31)]),
        ("CUTCOM/RIGHT\nCUTCOM/OFF\nCUTCOM/ON", [("RIGHT", 5), ("OFF", 5), ("RIGHT", 5)]),
        ("CUTCOM/ON\nCUTCOM/LEFT", [("LEFT", 5)]),
        ("CUTCOM/ON,LENGTH,7\nCUTCOM/ON\nCUTCOM/RIGHT,XYPLAN,OSETNO,8", [("RIGHT", 8)]),
        ("LOADTL/5,ADJUST,12\nCUTCOM/LEFT", [("LEFT", 12)]),
        ("LOADTL/5,OSETNO,12,13\nCUTCOM/LEFT", [("LEFT", 13)]),
        ("CUTCOM/LEFT,31\nCUTCOM/OFF\nLOADTL/6\nCUTCOM/ON", [("LEFT", 31), ("OFF", 31), ("LEFT", 6)]),
        ("TOOLNO/6, MILL, OSETNO, 14, 15, 10.\nLOADTL/6\nCUTCOM/LEFT", [("LEFT", 15)]),
    ],
)
def test_compensation(text, sides):
    assert told(f"LOADTL/5\n{text}\nGOTO/0,0,0", "compensation") == sides


@pytest.mark.parametrize(
    ("load", "number"),
    [
        ("LOAD/TOOL,5", 5),
        ("LOAD/TOOL,5,ADJUST,12", 12),
        ("LOADTL/5,OSETNO,12", 12),
        ("LOADTL / 5, OSETNO, 12, 13", 12),
        ("LOADTL/5,LENGTH,120,OSETNO,12", 12),
        ("LOADTL/5,OFFSET,12,LENGTH,120", 12),
        ("TOOLNO/ 5, MILL, OSETNO, 12, 13, 10.\nLOAD/ TOOL, 5, 'FLAT 10', NEXTTL, 6", 12),
        ("LOADTL/5\nSET/OFSETL,12", 12),
        ("LOADTL/5\nCUTCOM/ON,LENGTH,12", 12),
    ],
)
def test_the_length_offset_of_a_tool(load, number):
    """Fanuc names it by H, with TCP and without; the D of Siemens is that of the CL data, or 1."""
    text = f"{load}\nSPINDL/1000\n{MOVES}GOTO/9,0,0,0,0.6,0.8"
    plain = [line for line in lines(text, "fanuc") if "G43" in line]
    assert f"G43 H{number} X" in plain[-1]
    tcp = [line for line in lines(text, "fanuc", tcp=True) if line.startswith("G43.4")]
    assert tcp == [f"G43.4 H{number}"]
    edges = [line.split()[-1] for line in lines(text, "siemens") if line.startswith(("T5 ", "D"))]
    assert edges[-1] == (f"D{number}" if number != 5 else "D1")
    assert not [line for line in lines(text, "heidenhain") if f"{number} Z" in line and number != 5]


def test_the_radius_offset_of_a_tool():
    text = "LOADTL/5,ADJUST,12\nFEDRAT/100\nGOTO/-9,0,0\nCUTCOM/LEFT,31\nGOTO/0,0,0\nCUTCOM/OFF\nGOTO/0,-9,0"
    assert [line for line in lines(text, "fanuc") if "G41 D31" in line]


def test_a_tool_change_of_the_machine_file_knows_the_offset():
    own = replace(TABLE, program_head=("G54",), tool_change=("T{tool} M6", "G43 H{offset}"))
    assert "G43 H12" in lines(f"LOADTL/5,OSETNO,12\n{MOVES}", "fanuc", own)


@pytest.mark.parametrize(
    ("text", "feeds"),
    [
        ("SPINDL/1000,RPM,CLW\nFEDRAT/0.3,MMPR\nGOTO/0,0,0\nSPINDL/166.6666667\nGOTO/1,0,0", [300, 50]),
        ("FEDRAT/0.3,MMPR\nSPINDL/1000,RPM,CLW\nGOTO/0,0,0\nGOTO/1,0,0", [300, 300]),
        ("SPINDL/100\nFEDRAT/0.01,IPR\nGOTO/0,0,0\nSPINDL/200,CCLW\nGOTO/1,0,0", [25.4, 50.8]),
        ("SPINDL/100\nFEDRAT/0.001,FPR\nGOTO/0,0,0\nSPINDL/OFF\nGOTO/1,0,0", [30.48, 30.48]),
        ("SPINDL/100\nFEDRAT/2,PERREV\nGOTO/0,0,0\nFEDRAT/50\nSPINDL/200\nGOTO/1,0,0", [200, 50]),
        ("SPINDL/100\nFEDRAT/1,FPM\nGOTO/0,0,0\nSPINDL/200\nGOTO/1,0,0", [304.8, 304.8]),
        ("FEDRAT/100,MMPM\nGOTO/0,0,0\nFEDRAT/INVERS,AUTO\nGOTO/1,0,0", [100, 100]),
    ],
)
def test_a_feed_per_turn_follows_the_spindle(text, feeds):
    np.testing.assert_allclose(read(text).feeds, feeds, rtol=1e-6)


@pytest.mark.parametrize("dialect", DIALECTS)
def test_the_program_has_the_feed_of_the_new_speed(dialect):
    text = "SPINDL/1000,RPM,CLW\nFEDRAT/0.3,MMPR\nGOTO/0,0,0\nGOTO/5,0,0\nSPINDL/100\nGOTO/9,0,0"
    found = [line.rpartition(" F")[2] for line in lines(text, dialect) if re.search(r" F\d", line)]
    assert found == ["300", "30"]


@pytest.mark.parametrize(
    ("cycle", "feeds"),
    [
        ("SPINDL/100\nCYCLE/DRILL,DEPTH,8,MMPR,0.2,CLEAR,3", (20, 40)),
        ("SPINDL/100\nFEDRAT/0.2,MMPR\nCYCLE/DRILL,DEPTH,8,CLEAR,3", (20, 40)),
        ("SPINDL/100\nCYCLE/TAP,DEPTH,8,TPI,20,CLEAR,3", (127, 254)),
        ("SPINDL/100\nCYCLE/DRILL,DEPTH,8,MMPM,60,CLEAR,3", (60, 60)),
    ],
)
def test_the_feed_of_a_cycle_follows_the_spindle(cycle, feeds):
    cl = read(f"{cycle}\nGOTO/0,0,0\nSPINDL/200\nGOTO/5,0,0\nCYCLE/OFF\nRAPID\nGOTO/9,0,9")
    down = [cl.feeds[cl.points[:, 0] == x] for x in (0, 5)]
    np.testing.assert_allclose([values[~np.isnan(values)][0] for values in down], feeds)


@pytest.mark.parametrize("dwell", ["REV,5", "DWELL,REV,5", "DWELL,5,REV", "DWELL,3"])
def test_a_dwell_of_a_cycle_in_turns(dwell):
    assert told(f"SPINDL/100\nCYCLE/FACE,DEPTH,8,MMPM,60,CLEAR,3,{dwell}\nGOTO/0,0,0", "dwell") == [(3.0,)]


@pytest.mark.parametrize("delay", ["DELAY/5,REV", "DELAY/REV,5", "DWELL/3", "DELAY/3"])
def test_a_delay_in_turns(delay):
    assert told(f"SPINDL/100\n{delay}\nGOTO/0,0,0", "dwell") == [(3.0,)]


@pytest.mark.parametrize("dialect", DIALECTS)
@pytest.mark.parametrize("text", ["INSERT M88", "INSERT/M88", "insert  m88", "AUXFUN/88", "PPWORD/INSERT,M88"])
def test_verbatim_words_are_obeyed(text, dialect):
    found = lines(f"GOTO/1,1,1\n{text}\n{MOVES}", dialect)
    assert "M88" in found and found.index("M88") < len(found) - 3


@pytest.mark.parametrize("text", ["INSERT/17.5mm JOBBER DRILL", "INSERT/STOP  change fixture", "INSERT (a remark)"])
def test_remarks_that_are_inserted_stay_comments(text):
    assert read(f"{text}\nGOTO/0,0,0").remarks == ((0, text),)


@pytest.mark.parametrize(
    "text",
    [
        "INSERT G91", "INSERT/G0 Z100", "INSERT G53 G0 Z0", "INSERT M128", "INSERT M91", "INSERT M30", "INSERT M2",
        "INSERT M98 P1000", "INSERT TRAORI", "INSERT CYCL CALL", "INSERT L Z+100 FMAX", "AUXFUN/98", "AUXFUN/6",
    ],
)  # fmt: skip
def test_verbatim_words_that_could_move_the_tool_are_refused(text):
    assert refused(f"GOTO/0,0,0\n{text}").startswith("part.cl, line 3,")


@pytest.mark.parametrize("dialect", DIALECTS)
def test_optional_skip(dialect):
    text = f"GOTO/1,1,1\nOPSKIP/ON\nCOOLNT/MIST\nDELAY/1\nSTOP\nOPSKIP/OFF\nCOOLNT/FLOOD\n{MOVES}"
    program = postprocess(read(text), TABLE, dialect=dialect).program
    skipped = [line for line in program.splitlines() if line.startswith("/")]
    assert sum("M7" in line for line in skipped) == sum("M0" in line for line in skipped) == 1
    assert len(skipped) == (4 if dialect == "heidenhain" else 3) and "M8" not in "".join(skipped)
    for line in program.splitlines():
        if " X" in line and line not in skipped:
            with pytest.raises(InputError, match="never left out"):
                read_program(program.replace(line, f"/{line}"), TABLE, dialect)


@pytest.mark.parametrize("text", ["GOTO/1,1,1", "RAPID\nGOTO/1,1,1", "LOADTL/2", "CUTCOM/LEFT", "GODLTA/1"])
def test_what_moves_is_never_skipped(text):
    assert "OPSKIP/OFF" in refused(f"GOTO/0,0,0\nOPSKIP/ON\n{text}\nOPSKIP/OFF")


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        ("SPINDL/100\nCYCLE/DRILL,DEEP,DEPTH,60,MMPM,100,CLEAR,2\nGOTO/0,0,0", 3, "STEP"),
        ("SPINDL/100\nCYCLE/DEEP,FEDTO,-60,RAPTO,2,MMPM,100\nGOTO/0,0,0", 3, "STEP"),
        ("SPINDL/100\nCYCLE/BRKCHP,FEDTO,-60,RAPTO,2,MMPM,100\nGOTO/0,0,0", 3, "STEP"),
        ("CUTCOM/LEFT,ZXPLAN\nGOTO/0,0,0", 2, "XYPLAN"),
        ("CUTCOM/RIGHT,YZPLAN,3\nGOTO/0,0,0", 2, "XYPLAN"),
        ("CUTCOM/LEFT,NORMAL\nGOTO/0,0,0", 2, "CUTCOM"),
        ("CUTCOM/LEFT,3.5\nGOTO/0,0,0", 2, "CUTCOM"),
        ("LOADTL/5,OSETNO,1200\nGOTO/0,0,0", 2, "999"),
        ("LOADTL/5,ADJUST\nGOTO/0,0,0", 2, "an offset"),
        ("SET/OFSETL,ON\nGOTO/0,0,0", 2, "an offset"),
        ("FEDRAT/0.1,MMPR\nGOTO/0,0,0", 3, "SPINDL"),
        ("SPINDL/0\nFEDRAT/0.1,MMPR\nGOTO/0,0,0", 4, "SPINDL"),
        ("SPINDL/RANGE\nGOTO/0,0,0", 2, "RANGE"),
        ("SPINDL/LOCK,ON\nGOTO/0,0,0", 2, "LOCK"),
        ("COOLNT/HIGH\nGOTO/0,0,0", 2, "COOLNT"),
        ("COOLNT/FLOOD,MIST\nGOTO/0,0,0", 2, "COOLNT"),
        ("OPSKIP\nGOTO/0,0,0", 2, "OPSKIP/ON or OFF"),
        ("PPWORD/G91\nGOTO/0,0,0", 2, "nobody knows"),
        ("PPWORD/PPWORD,COOLNT,ON\nGOTO/0,0,0", 2, "nobody knows"),
        ("CYCLE/TAP,DEPTH,8,TPI,0,CLEAR,3\nGOTO/0,0,0", 2, "threads per inch"),
        ("CYCLE/DRILL,DEPTH,8,MMPM,9,CLEAR,3,RAPTO,3\nGOTO/0,0,0", 2, "a clearance"),
        ("CYCLE/FACE,DEPTH,8,MMPM,9,CLEAR,3,REV,3\nGOTO/0,0,0", 2, "a delay in turns"),
    ],
)
def test_what_cannot_be_obeyed_is_refused_with_its_line(text, line, words):
    message = refused(text)
    assert message.startswith(f"part.cl, line {line},") and words in message


def test_words_of_another_post_processor_within_a_statement():
    text = "PPWORD/COOLNT,MIST\nPPWORD/ SPINDL/600,RPM,CCLW\nPPWORD/PPRINT,hello\nGOTO/0,0,0"
    assert told(text, "coolant") == [("MIST",)] and told(text, "spindle") == [(600, "CCLW")]
    assert not read("PPWORD/TLAXIS,0,1,0\nGOTO/0,0,0").axes[0][2]


@pytest.mark.parametrize("word", sorted(MOVING))
def test_words_that_move_the_tool_are_not_ignored(word):
    message = refused("GOTO/0,0,0", ignored=[word.lower()])
    assert word in message and "ignored" in message and "part.cl" in message


def test_every_word_that_moves_is_among_those():
    """Whatever a method of the moves takes, under each of its names."""
    names = {name[3:].upper() for name in vars(Movements) if name.startswith("on_")}
    assert names | {alias for alias, word in ALIASES.items() if word in names} <= MOVING
    modelled = {name[3:].upper() for name in dir(Statements) if name.startswith("on_")}
    assert not MOVING & COMMENTS.keys() and not (COMMENTS | REFUSED).keys() & modelled


def test_lines_that_lead_from_an_arc_to_its_circle():
    """Three quarters of the way round, the last as a line; Creo goes on with another arc about the same centre."""
    arc = "CIRCLE/0,0,0,0,0,1,5"
    cl = read(f"FEDRAT/100\nGOTO/5,0,0\n{arc}\nGOTO/0,5,0\nGOTO/-5,0,0\n{arc}\nGOTO/0,-5,0")
    quarter = (len(cl) - 2) // 2
    np.testing.assert_allclose(
        cl.points[[quarter, quarter + 1, -1]], [(0, 5, 0), (-5, 0, 0), (0, -5, 0)], atol=1e-9
    )
    radii = np.hypot(*cl.points.T[:2])
    np.testing.assert_allclose(radii, 5)
    assert cl.lines[quarter] == 5 and cl.lines[quarter + 1] == 6  # one record for the line
    assert any("from the end of an arc" in note for note in cl.notes)


@pytest.mark.parametrize(
    ("words", "angle"),
    [
        ("CENTER, 0, 0, 2, AXIS, 0, 0, 1, RADIUS, 5", 90),
        ("CENTER, 0, 0, 2, AXIS, 0, 0, 1, RADIUS, 5, ANGLE, 90", 90),
        ("CENTER, 0, 0, 2, AXIS, 0, 0, 1, RADIUS, 5, TIMES, 1", 90),
        *[(f"0,0,2,0,0,{axis},5,ANGLE,{abs(angle)}", angle) for axis in (1, -1) for angle in (90, -270, 450)],
    ],
)
def test_arcs_of_iso_4343(words, angle):
    """Of the two ways to the end the one that is as long as it says, whatever way the axis points."""
    cl = read(f"FEDRAT/100\nGOTO/5,0,2\nMOVARC/{words}\nGOTO/0,5,2")
    turned = np.unwrap(np.arctan2(cl.points[:, 1], cl.points[:, 0]))
    assert np.degrees(turned[-1] - turned[0]) == pytest.approx(angle) and (np.diff(turned) * angle > 0).all()
    np.testing.assert_allclose(np.hypot(*cl.points.T[:2]), 5, atol=1e-12)


@pytest.mark.parametrize("words", ["MOVARC/0,0,2,0,0,1,5", "MOVARC/CENTER,0,0,2,AXIS,0,0,1,RADIUS", "MOVARC/1,2"])
def test_arcs_that_say_too_little(words):
    assert "MOVARC/ 7 numbers" in refused(f"GOTO/5,0,2\n{words}\nGOTO/0,5,2")


def test_commands_read_back_from_text():
    """What `to_text` writes says the same again."""
    text = (
        "LOADTL/5,LENGTH,80,OSETNO,12,13\nSPINDL/600,RPM,CCLW\nFEDRAT/0.5,MMPR\nGOTO/0,0,0\nCUTCOM/LEFT\nGOTO/9,0,0\n"
        "CUTCOM/OFF\nSPINDL/OFF\nOPSKIP/ON\nCOOLNT/MIST\nOPSKIP/OFF\nINSERT M88\nMULTAX/OFF\nGOTO/9,9,0\n"
    )
    one = read(text)
    again = cldata.parse(cldata.to_text(one))
    kinds = [
        [(r, c.kind, c.values, c.skip) for r, c in cl.remarks if not isinstance(c, str)] for cl in (one, again)
    ]
    assert kinds[0] == kinds[1]
    np.testing.assert_allclose(again.feeds, one.feeds)
    np.testing.assert_allclose(again.axes, one.axes)
