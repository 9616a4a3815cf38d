"""A program beside what shops' posts write: its beginning, its tool changes, clamps and its end, line by line."""

import re
from dataclasses import replace

import pytest

from mathpost import load_machine, postprocess
from mathpost.path import cl as cldata
from mathpost.shop.controls import control

JOB = """UNITS/MM
TOOL PATH/FACE,TOOL,EM12
TLDATA/MILL,12.0000,0.5000,75.0000
PAINT/PATH
LOADTL/1,LENGTH,120
SPINDL/RPM,6000,CLW
COOLNT/ON
RAPID
GOTO/-30,0,70,0,0,1
FEDRAT/MMPM,800
GOTO/-30,0,50,0,0,1
GOTO/30,20,50,0.2,0,0.979796
TOOL PATH/HOLES,TOOL,DR8
TLDATA/DRILL,8.0000,118
LOADTL/2,LENGTH,140
SPINDL/RPM,2500,CLW
COOLNT/ON
RAPID
GOTO/-20,0,80,0.5,0,0.866025
CYCLE/DRILL,DEPTH,12,CLEAR,3,MMPM,300
GOTO/-20,0,50
GOTO/0,0,50
CYCLE/OFF
FINI
"""
CLAMPS = {"A": ("M10", "M11"), "C": ("M12", "M13")}


def lines_of(dialect, tcp=False):
    """The lines of a program, without numbers and comments, and its report."""
    data = load_machine("ac_table")
    rotary = tuple(replace(joint, clamp=CLAMPS[joint.name]) for joint in data.rotary)
    data = replace(data, rotary=rotary, program_foot=("M9",))
    result = postprocess(cldata.parse(JOB, "job.cl"), data, dialect=dialect, tcp=tcp)
    lines = [re.sub(r"^N?\d+ ", "", line) for line in result.program.splitlines()]
    return [line for line in lines if line[0] not in "(;*"], result


@pytest.mark.parametrize("tcp", [False, True])
@pytest.mark.parametrize("dialect", control.names())
def test_order_of_retract_change_spindle_and_coolant(dialect, tcp):
    lines, result = lines_of(dialect, tcp)
    words = control.load(dialect)
    (safe,) = words.lines("safe", 390.0)
    first_move = next(n for n, line in enumerate(lines) if re.search(r"(?:^| )[ACXYZ][-+=\d]", line))
    assert lines[first_move] == safe
    assert all(line.split("{")[0] in "\n".join(lines[:first_move]) for line in words.start)
    for tool, speed in ((1, 6000), (2, 2500)):
        (change,) = [n for n, line in enumerate(lines) if re.search(rf"TOOL CALL {tool} |^T{tool}( M6)?$", line)
                     and (dialect != "siemens" or lines[n + 1] == "M6") and "DEF" not in line
                     and (dialect in ("siemens", "heidenhain") or "M6" in line)]  # fmt: skip
        behind = lines[change:]
        spindle = next(n for n, line in enumerate(behind) if line.endswith("M3"))
        assert f"S{speed}" in " ".join(behind[: spindle + 1])
        over = next(n for n, line in enumerate(behind) if re.search(r"(?:^| )X", line))
        assert behind.index(safe) < spindle < behind.index("M8") < over
        stopped = lines[:change][-4:]
        assert tool == 1 or {"M5", "M9"} < {*stopped}
    end = max(n for n, line in enumerate(lines) if "M3" in line.split() or line.endswith("M3"))
    assert "M5" in lines[end:] and result.blocks.words[-1, 3:].tolist() == [0.0, 0.0]
    text = "\n".join(lines)
    assert text.count("TOOL CALL") == 2 * (dialect == "heidenhain")
    assert "PAINT" not in result.program and "FINI\n" not in result.program
    assert "TOOL 1: EM12, MILL D12 R0.5, LENGTH 120 MM, OFFSET 1: FACE" in result.program
    assert "TOOL 2: DR8, DRILL D8, LENGTH 140 MM, OFFSET 2: HOLES" in result.program


@pytest.mark.parametrize("dialect", control.names())
def test_no_axis_turns_while_it_is_clamped_and_holes_are_drilled_clamped(dialect):
    lines, _ = lines_of(dialect)
    at, held = {}, {"A", "C"}  # nobody knows at first
    drilled = turned = 0
    for line in lines:
        for name, (clamp, release) in CLAMPS.items():
            held = held | {name} if line == clamp else held - {name} if line == release else held
            found = re.search(rf"(?:^| ){name}\+?(-?[\d.]+)", line)
            if found and at.get(name) != float(found[1]):
                assert name not in held, line
                at[name], turned = float(found[1]), turned + 1
        if re.search(r"^CYCL CALL|G81 |CYCLE81", line):
            assert held == {"A", "C"}, line
            drilled += 1
    assert drilled and turned > 4


def test_the_last_digits_of_a_tilted_plane_begin_no_new_cycle():
    """Two holes at one height: their Z differ by 0.0001 mm, which the rounded angles of the plane leave."""
    holes = "CYCLE/DRILL,DEPTH,12,CLEAR,3,MMPM,300\nGOTO/40,-10,40,0.5,0,0.866025\nGOTO/40,10,40\nCYCLE/OFF\n"
    text = f"UNITS/MM\nLOADTL/2,LENGTH,140\nRAPID\nGOTO/40,0,90,0.5,0,0.866025\n{holes}RAPID\nGOTO/60,10,90\n"
    data = replace(load_machine("ac_table"), program_foot=("M9",))
    program = postprocess(cldata.parse(text), data, dialect="heidenhain").program
    assert program.count("CYCL DEF 200") == 1 and program.count("CYCL CALL") == 2


WORDS = {"heidenhain": r"32\.1 T([\d.]+)", "siemens": r"CYCLE832\(([\d.]+)", "haas": r"G187 P3 E([\d.]+)"}


@pytest.mark.parametrize("dialect", WORDS)
def test_the_tolerance_of_the_control_is_what_the_path_leaves(dialect):
    _, result = lines_of(dialect)
    left = float(re.search(WORDS[dialect], result.program)[1])
    assert 0.005 <= left <= 0.01 - result.report.path_tip_error + 1e-9
