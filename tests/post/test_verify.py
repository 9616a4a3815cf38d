"""Programs verified: right ones of every control agree, planted slips are found and named."""

import re
from dataclasses import replace

import numpy as np
import pytest

from mathpost import load_machine, machine_file, postprocess
from mathpost.errors import MathpostError
from mathpost.interface.shell.main import main
from mathpost.path import cl as cldata
from mathpost.shop.controls.coordinates import Setup
from mathpost.shop.post.verify import verify
from tests.conftest import DATA
from tests.independent.machine_model import Model
from tests.machines import content
from tests.post import slips
from tests.post import test_own_words as own_words
from tests.post.rewritten import rewritten


@pytest.mark.parametrize("seed", range(3))
def test_right_programs_agree(seed):
    made = slips.job(np.random.default_rng(seed))
    judged = made.judged()
    assert judged.status == 0, str(judged)
    assert judged.along.tip <= 0.01


@pytest.mark.parametrize("seed", range(8))
def test_right_programs_in_the_words_of_another_post_agree(seed):
    """Own words of the control on every second one; none is read as it was written."""
    rng = np.random.default_rng(40 + seed)
    made = slips.own_words_job(rng) if seed % 2 else slips.job(rng)
    text = rewritten(rng, made)
    assert text != made.text
    judged = made.judged(text)
    assert judged.status == 0, str(judged)
    assert judged.along.tip <= 0.01
    unsure = [block for block in judged.unsure if judged.program.blocks.rapid[block]]
    clear = judged.together or not unsure  # together, or at a feed, they go as the CL data have them
    assert clear and not judged.unjudged, "what the package writes is clear on every way"


def test_vectors_of_the_tool_axis_agree():
    """G43.5: the rotary words of a program with TCP as the tool axis, by formulas of another kind."""
    rng = np.random.default_rng(3)
    made = slips.job(rng, tcp=True)
    while made.control not in ("fanuc", "mazak"):
        made = slips.job(rng, tcp=True)
    file = next(file for file in sorted((DATA / "machines").glob("*.toml")) if load_machine(file) == made.machine)
    model, angles, lines = Model(file), {}, []
    for line in made.text.replace("G43.4", "G43.5").splitlines():
        words = re.findall(r"(?<![A-Z])([ABC])(-?[\d.]+)", line) if " X" in line or " Y" in line else []
        angles |= {name: float(value) for name, value in words}
        if words:
            _, axis = model.place(
                np.zeros(3), [angles[name] for name in made.machine.joint_names[3:]], model.length
            )
            turned = "".join(f" {name}{value:.9f}" for name, value in zip("IJK", axis, strict=True))
            line = re.sub(r" [ABC]-?[\d.]+", "", line)
            line = re.sub(r"(?= F|$)", turned, line, count=1)
        lines.append(line)
    judged = made.judged("\n".join(lines) + "\n")
    assert judged.status == 0, str(judged)


@pytest.mark.parametrize("number", range(len(slips.KINDS)))
def test_planted_slips_are_found_and_named(number, of):
    """In the words of one control for each kind of slip, or of all."""
    kind, count = slips.KINDS[number], len(slips.CONTROLS)
    for n in of([number % count], range(count)):
        made, text, name = slips.slip(np.random.default_rng(n), kind, slips.CONTROLS[n])
        judged = made.judged(text)
        assert judged.status == 1
        assert re.search(name, slips.names(judged)[0]), str(judged)


def test_a_pivot_wrong_under_the_point_that_is_named():
    """Seed 5 has a fork head whose X Y Z name the pivot: only the chain's pivot is wrong."""
    made, text, _ = slips.slip(np.random.default_rng(5), "pivot")
    assert made.machine.programmed_point not in ("tip", "nose")
    judged = made.judged(text)
    assert judged.status == 1
    assert any("pivot of A" in sentence for sentence in judged.explained), str(judged)


def test_the_command_says_what_it_found(tmp_path, capsys):
    machine, path, program = DATA / "machines/dmu50v.toml", DATA / "cl/blade.cl", tmp_path / "blade.nc"
    words = ["--machine", str(machine), "--dialect", "fanuc"]
    assert main(["post", str(path), *words, "-o", str(program)]) == 0
    asked = ["verify", str(program), *words, "--cl", str(path)]
    page = tmp_path / "blade.html"
    assert main([*asked, "--page", str(page)]) == 0
    assert "agrees with all 5 records" in capsys.readouterr().out
    assert "<pre>" in page.read_text(encoding="utf-8")
    negated = re.sub(r" C(-?)([\d.]+)", lambda c: f" C{'' if c[1] else '-'}{c[2]}", program.read_text())
    program.write_text(negated)
    assert main(asked) == 1
    assert "C turns the other way" in capsys.readouterr().out
    program.write_text(program.read_text().replace("G90", "G90 G10 L2"))
    assert main(asked) == 2
    assert "'G10'" in capsys.readouterr().err


def test_a_word_of_the_machine_is_passed_over_when_told(tmp_path, capsys):
    program = tmp_path / "a.nc"
    program.write_text("G21 G90 G0 X0. Y0. Z5. A0. C0.\nM250\nG187 P2\nG1 X1. F100.\nM30\n")
    asked = ["verify", str(program), "--machine", "ac_table", "--dialect", "fanuc"]
    assert main([*asked, "--skip", "m250"]) == 2
    assert (
        "line 3: expected a word of a fanuc program, found 'G187'. Not read, and may move"
        in capsys.readouterr().err
    )
    assert main([*asked, "--skip", "M250", "--skip", "G187 P{}"]) == 0
    assert "1 × G187 P" in capsys.readouterr().out


def test_a_program_that_ends_too_soon():
    made = slips.job(np.random.default_rng(7))
    rows = slips._rows(made.text)
    lines = made.text.splitlines()
    try:
        judged = made.judged("\n".join(lines[: rows[-2]]) + "\n")
    except MathpostError:
        pytest.fail("it can be read")
    assert judged.status == 1
    assert "ends before" in " ".join(judged.explained)


def test_a_digit_lost_in_the_last_block_of_a_straight_path(tmp_path, capsys):
    """The program ends too soon, and the word that is wrong is named as well."""
    path, program = tmp_path / "part.cl", tmp_path / "part.nc"
    path.write_text("FEDRAT/500\nGOTO/0,0,0,0,0,1\nGOTO/50,0,0,0,0,1\nGOTO/175,0,0,0,0,1\n")
    words = ["--machine", "ac_table", "--dialect", "fanuc"]
    assert main(["post", str(path), *words, "-o", str(program)]) == 0
    program.write_text(program.read_text().replace("X175.", "X75."))
    assert main(["verify", str(program), *words, "--cl", str(path)]) == 1
    said = capsys.readouterr().out
    assert "the program ends before record 3 of 3" in said
    assert "X75.0000 stands where X175.0000 would be right" in said


def test_a_machine_with_one_rotary_axis(tmp_path, capsys):
    """Its programs agree, and a reversed axis is named."""
    path, program = tmp_path / "part.cl", tmp_path / "part.h"
    axis = "0,0.342020143,0.939692621"
    path.write_text(
        f"FEDRAT/500\nGOTO/0,0,60,0,0,1\nGOTO/10,0,60,0,0,1\nGOTO/10,20,55,{axis}\nGOTO/20,20,55,{axis}\n"
    )
    words = ["--machine", "dividing_head"]
    assert main(["post", str(path), *words, "-o", str(program)]) == 0
    asked = ["verify", str(program), *words, "--cl", str(path)]
    assert main(asked) == 0
    program.write_text(program.read_text().replace(" A-", " A+"))
    assert main(asked) == 1
    assert "A turns the other way" in capsys.readouterr().out


def test_the_way_under_tcp_may_leave_travel():
    """Half a turn of C about a tip 240 mm from its axis: half way there Y stands at 240 mm, of 225 mm of travel."""
    text = "M128\n" + "".join(
        f"L X+240 Y{y:+} Z+100 B+0 C{c:+} F1000\n" for y, c in ((0, 0), (1, 0), (0, 0), (0, 180), (1, 180))
    )
    judged = verify(text, load_machine("dmu50v"))
    assert judged.outside == ((3, "on the way: Y 240.000 mm is outside -225 … 225"),)


@pytest.mark.parametrize("control", ["heidenhain", "fanuc", "siemens"])
def test_a_block_that_is_lost_on_a_tilted_plane_is_named(control):
    """Words of a line that is put back are those of the plane, whatever its coordinates."""
    setup, axis, across, along = own_words.on_machine("ac_table", A=20.0, C=35.0)
    lines = ["UNITS/MM", "FEDRAT/400,MMPM", "RAPID", f"GOTO/{own_words.numbers(30 * axis, axis)}"]
    lines += ["RAPID", f"GOTO/{own_words.numbers(20 * across + 9 * axis)}"]
    lines += [f"GOTO/{own_words.numbers((20 + step % 2) * across + 4 * step * along)}" for step in range(9)]
    path = cldata.parse("\n".join(lines) + "\n")
    text = postprocess(path, setup, dialect=control).program
    rows = text.splitlines()
    after = next(n for n, row in enumerate(rows) if re.search("PLANE|G53.1|CYCLE800", row))
    for gone in (after + 1, after + 4):
        lost = "\n".join([*rows[:gone], *rows[gone + 1 :]]) + "\n"
        judged = verify(lost, setup, control, cl=path)
        assert judged.status == 1 and "is left out: a block is missing" in judged.explained[0], judged


SLOT = "G21 G90 G0 X0. Y0. Z5. A0. C0.\nG1 Z-2. F300.\nX50.\n"  # 10 mm wide and 2 mm deep, along X


@pytest.mark.parametrize(
    ("after", "line"),
    [
        ("G0 Z5.\nG0 X0. Y20.\n", None),  # one axis, then above everything
        ("G0 X0. Z-2.\n", None),  # Z stands: X alone, back through the slot itself
        ("G0 X0. Z5.\n", None),  # X may arrive before Z has moved: through the slot, which is air
        ("G0 X50. Y20. Z5.\n", None),  # beside the end of the slot, whichever comes first
        ("G0 Z5.\nG0 X20. Y4.9 Z0.\n", None),  # above the bottom of the slot
        ("G0 Z5.\nG0 X20. Y4.9 Z-3.\n", 5),  # ends with its body in the line that was cut
        ("G0 Z5.\nG0 X20. Y20.\nG0 X30. Y6. Z-3.\n", None),  # 1 mm beside it at the end, and all the way
        ("G0 Z5.\nG0 X70. Y0.\nG0 X55.1 Y1. Z-9.\n", None),  # stays beyond its end
        ("G0 Z-1.\nG0 X20.\nG0 Z-9.\n", 6),  # Z alone, down through the bottom of the slot
        ("G0 Z5.\nG0 Y20.\nG0 Z-9.\nG0 Y-20.\n", 7),  # Y alone, through what is below it
        ("G0 Z5.\nG53 G0 Z-300.\n", 5),  # a home position that is below the part
        ("G0 Z5.\nG0 X70. Y0.\nG0 X40. Y-20. Z-9.\n", 6),  # X and Z may arrive before Y has left the slot's line
    ],
)
def test_a_strangers_rapid_move_is_held_against_every_way(after, line):
    """The tool, 10 mm across, anywhere in the box of its slides."""
    text = SLOT + after + "M30\n"
    judged = verify(text, load_machine("ac_table"), "fanuc")
    assert [judged.line(block) for block in judged.unsure] == ([] if line is None else [line]), judged
    assert ("clear of all cuts" in str(judged)) == (line is None)
    assert judged.unjudged == ()


@pytest.mark.parametrize(("height", "clear"), [(20, True), (12, True), (7, False), (5, False)])
def test_a_rapid_move_of_rotary_axes_with_slides_is_held_against_every_order(height, clear):
    """With A at 30° and C on its way, what is less than 5 mm from Y0 in the slot comes up to Z 8.3.

    A turns about Y0 Z-50: the point of the slot at radius r comes to Y r cos 30° - 48 sin 30°, and so high as
    r sin 30° + 48 cos 30° - 50; Y is 5 at r = 33.5.
    """
    text = SLOT + f"G0 Z90.\nG0 A30.\nG0 Z{height}.\nG0 X0. C90.\nM30\n"
    judged = verify(text, load_machine("ac_table"), "fanuc")
    assert [judged.line(block) for block in judged.unsure] == ([] if clear else [7]) and not judged.unjudged


def test_the_first_rapid_move_of_another_tool_is_said_not_to_be_judged():
    """Where the slides stand before it depends on both lengths."""
    text = SLOT + "G0 Z90.\nT2 M6\nG0 G43 H2 X0. Y0. Z50.\nG0 X5.\n"
    judged = verify(text, load_machine("ac_table"), "fanuc", setup=Setup(lengths={"1": 100.0, "2": 120.0}))
    assert "the first after a change of tool" in str(judged)
    assert "not judged" not in str(verify(SLOT, load_machine("ac_table"), "fanuc"))


def test_ways_are_known_where_the_axes_arrive_together():
    text = "".join(
        f"L {words} {feed}\n"
        for words, feed in (("X+0 Y+0 Z-2 B+0 C+0", "F300"), ("X+50", ""), ("X+0 Z+5", "FMAX"))
    )
    judged = verify(text, load_machine("dmu50v"), "heidenhain")
    assert judged.unsure == () and "clear of all cuts, the axes arrive together" in str(judged)


AT_ONCE = machine_file.from_dict(content((-1, 0, 0), (0, 0, -1)))  # no rates: it goes as fast as it is told
TURNS = {  # control, program, seconds: F is degrees a minute where only rotary axes move, and waiting counts
    "fanuc": ("G21 G90 G94 G49 G0 X0 Y0 Z0 A0 C0\nG4 X2.5\nG4 P500\nG1 A30 C40 F300\n", 3 + 50 * 60 / 300),
    "mazak": ("G94 G1 A90 F360\n", 15),
    "haas": ("G21 G90 G94 G49 G0 X0 Y0 Z0 A0 C0\nG4 P2.\nG4 P250\n", 2.25),
    "linuxcnc": ("G21 G90 G94 G0 X0 Y0 Z0 A0 C0\nG4 P1.5\nG1 A-30 F360\n", 1.5 + 5),
    "heidenhain": ("L X+0 Y+0 Z+0 A+0 C+0 FMAX\nCYCL DEF 9.0 DWELL TIME\nCYCL DEF 9.1 DWELL 3\nL C+60 F360\n", 13),
}


@pytest.mark.parametrize("control", TURNS)
def test_degrees_a_minute_and_waiting_count_in_the_time(control):
    text, seconds = TURNS[control]
    setup = Setup(start=dict.fromkeys("XYZAC", 0.0))
    assert verify(text, AT_ONCE, control=control, setup=setup).seconds == pytest.approx(seconds, abs=1e-6)


@pytest.mark.parametrize("control", ["fanuc", "haas", "heidenhain", "linuxcnc", "siemens"])
@pytest.mark.parametrize("kind", ["DRILL", "BORE"])
def test_a_cycle_that_waits_at_the_bottom(control, kind):
    def seconds(dwell):
        lines = ["SPINDL/RPM,1000,CLW", "RAPID", "GOTO/0,0,30,0,0,1", "FEDRAT/400,MMPM"]
        lines += [f"CYCLE/{kind},FEDTO,5,CLEAR,1,MMPM,120,DWELL,{dwell}", "GOTO/0,0,0", "GOTO/9,0,0", "CYCLE/OFF"]
        made = postprocess(cldata.parse("\n".join(lines) + "\n"), load_machine("ac_table"), dialect=control)
        return verify(made.program, load_machine("ac_table"), control).seconds

    assert seconds(2.5) - seconds(0.5) == pytest.approx(2 * 2.0, abs=1e-6)


@pytest.mark.parametrize(
    ("control", "text", "seconds"),
    [  # the first is the example of Fanuc's manual: 0.14907 min
        ("fanuc", "G21 G90 G94 G49 G0 X0 Y0 Z0 A0 C0\nG1 X20 C40 F300\n", 60 * np.hypot(20, 40) / 300),
        ("linuxcnc", "G21 G90 G94 G0 X0 Y0 Z0 A0 C0\nG1 X20 C40 F300\n", 60 * 20 / 300),
        ("siemens", "G90 G94 G0 X0 Y0 Z0 A0 C0\nS600 M3\nG4 S10\nG4 F2\n", 1 + 2),
    ],
)
def test_both_kinds_of_axes_in_one_feed_and_turns_that_are_waited(control, text, seconds):
    found = verify(text, AT_ONCE, control=control, setup=Setup(start=dict.fromkeys("XYZAC", 0.0)))
    assert found.seconds == pytest.approx(seconds, abs=1e-6)


def test_feed_at_the_tip_is_slower_far_from_the_axis(tmp_path):
    """By "tip" F is mm a minute on the part: 100 mm from C, 180° are 100·π mm."""
    path = tmp_path / "of_mine.toml"
    path.write_text('name = "mine"\ninherits = "linuxcnc"\n[motion]\nrotary_feed = "tip"\n', encoding="utf-8")
    text = "G21 G90 G94 G0 X100 Y0 Z0 A0 C0\nG1 C1 F360\nG1 C0\n"
    by_tip = verify(text, AT_ONCE, control=str(path)).seconds
    assert by_tip == pytest.approx(2 * 200 * np.sin(np.deg2rad(0.5)) / 6, rel=1e-3)
    assert verify(text, AT_ONCE, control="linuxcnc").seconds == pytest.approx(2 / 6)


@pytest.mark.parametrize("tcp", [False, True])
@pytest.mark.parametrize("way", ["cubic lifted", "retract"])
def test_a_lift_over_a_stretch_is_told_and_is_no_fault(way, tcp):
    """On the blade both leave at record 2 and come down at record 3; a block of another height is a fault."""
    setup, path = load_machine("dmu50v"), cldata.read(DATA / "cl/blade.cl")
    text = postprocess(path, setup, dialect="siemens", singular=way, tcp=tcp).program
    judged = verify(text, setup, "siemens", cl=path)
    assert judged.status == 0, judged
    ((first, last),) = judged.along.lifts
    assert judged.along.place[[first - 1, last]] == pytest.approx([1, 2], abs=1e-4)
    assert f"lifted     lines {judged.line(first)} … {judged.line(last)}, over what the CL data cut" in str(judged)
    lines = text.splitlines()
    lifted = judged.line(first) - 1
    bare = "\n".join(line for n, line in enumerate(lines) if n != lifted)  # it goes aside before it is lifted
    assert verify(bare, setup, "siemens", cl=path).status == 1


def test_between_two_tools_the_air_is_free():
    """The way to the second tool's first record goes below the plane of the first one's last record."""
    text = """UNITS/MM
LOADTL/1
FEDRAT/500
GOTO/0,0,0,0.6,0,0.8
GOTO/0,20,0
LOADTL/2
FEDRAT/500
RAPID
GOTO/-60,0,-10,0,0,1
GOTO/-60,20,-10
"""
    setup, path = replace(load_machine("ac_table"), program_head=("G40",)), cldata.parse(text, "two.cl")
    program = postprocess(path, setup, dialect="siemens").program
    judged = verify(program, setup, "siemens", cl=path, setup=Setup(lengths={"1": 120.0, "2": 120.0}))
    assert judged.along.off is None, judged
