"""Arcs, drilling cycles and tilted planes in the words of each control, read by the reader of the manuals alone."""

import re
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from mathpost import load_machine, postprocess
from mathpost.kinematics import Kinematics
from mathpost.path import cl as cldata
from mathpost.rotation import unit
from tests.conftest import DATA
from tests.independent import judge
from tests.independent.machine_model import Model
from tests.independent.reader import Setup, read

CONTROLS = ("heidenhain", "fanuc", "siemens", "linuxcnc", "haas", "mazak")
MACHINES = ("ac_table", "bc_table", "dmu50v", "head_b_table_c", "nutating_head", "ac_head")
TABLES = ("ac_table", "bc_table", "dmu50v")  # whose tool is along Z in the machine
TOLERANCE = 0.01  # mm


def on_machine(name, **rotary):
    """The machine with a tool of 80 mm, the tool axis at rotary angles, and vectors square to it."""
    setup = load_machine(name).with_setup(tool_length=80.0)
    angles = [rotary.get(axis, 0.0) for axis in setup.joint_names[3:]]
    _, axis = Kinematics(setup).forward([0, 0, 0, *angles], degrees=True)
    across = unit(np.cross(axis, [0.3, 0.8, 0.1]))
    return setup, axis, across, np.cross(axis, across)


def numbers(*vectors):
    return ",".join(f"{value:.9f}" for vector in vectors for value in np.atleast_1d(vector))


def arcs_file(rng, axis, across, along, count=12):
    """A path of lines, arcs and helices square to the tool axis: its text, and centre and radius of each arc."""
    point, circles = np.array([5.0, 3.0, 2.0]), []
    lines = ["UNITS/MM", "FEDRAT/600,MMPM", f"GOTO/{numbers(point, axis)}"]
    for number in range(count):
        turn = rng.uniform(0, 2 * np.pi)
        radius, sweep = rng.uniform(1, 25), rng.uniform(0.3, 2 * np.pi)
        sweep = 2 * np.pi if number % 5 == 4 else sweep
        sense = rng.choice([-1, 1])
        out = np.cos(turn) * across + np.sin(turn) * along
        centre = point - radius * out
        rise = rng.uniform(-1, 1) * (number % 3 == 0)
        round_ = np.cos(sweep) * out + sense * np.sin(sweep) * np.cross(axis, out)
        times = int(rng.integers(1, 4)) if rise and sweep < 6 else 1
        end = centre + radius * round_ + rise * axis
        lines += [f"CIRCLE/{numbers(centre, sense * axis, radius)}" + f",TIMES,{times}" * (times > 1)]
        lines += [f"GOTO/{numbers(end)}"]
        circles.append((centre, radius))
        point = end + rng.uniform(-4, 4) * across
        lines += [f"GOTO/{numbers(point)}"] * (number % 2)
        point = point if number % 2 else end
    return "\n".join(lines) + "\n", circles


def moves_of(result, setup, control, name):
    model = Model(DATA / "machines" / f"{name}.toml", length=setup.tool_length, origin=setup.origin)
    moves = read(result.program, control, Setup(model, length_on=True))
    return moves, judge.sample(model, moves, turn=0.5)


@pytest.mark.parametrize("number", range(6))
def test_arcs_and_helices_are_run(number, of):
    """By the joints on every second machine and with TCP on the others, or both on all."""
    for tcp in of([number % 2 == 1], [False, True]):
        arcs_and_helices_are_run(number, tcp)


def arcs_and_helices_are_run(number, tcp):
    rng = np.random.default_rng(number)
    name, control = MACHINES[number], CONTROLS[(number + 3 * tcp) % 6]
    setup, axis, across, along = on_machine(name)
    text, circles = arcs_file(rng, axis, across, along)
    path = cldata.parse(text)
    result = postprocess(path, setup, dialect=control, tcp=tcp)
    moves, samples = moves_of(result, setup, control, name)
    assert sum(move.arc for move in moves) >= len(circles)
    assert len(moves) < 60 < len(path) / 10
    assert judge.to_path(samples.tip[::7], path.points).max() < TOLERANCE
    assert max(judge.between(each, axis) for each in samples.axis) < 1e-3
    curved = np.array([moves[move].arc for move in samples.move])
    from_circle = [
        np.abs(np.linalg.norm(np.cross(samples.tip[curved] - centre, axis), axis=1) - radius)
        for centre, radius in circles
    ]
    assert np.min(from_circle, axis=0).max() < 5e-4  # of the arcs themselves, not of their chords
    length = np.linalg.norm(np.diff(path.points, axis=0), axis=1).sum()
    seconds = sum(judge.at_constant_speed(Model(DATA / "machines" / f"{name}.toml"), move) for move in moves[1:])
    assert seconds == pytest.approx(length / 10, rel=1e-2)
    assert result.report.path_tip_error < TOLERANCE


def test_expanded_are_straight_moves():
    rng = np.random.default_rng(3)
    setup, *vectors = on_machine("ac_table")
    path = cldata.parse(arcs_file(rng, *vectors)[0])
    program = postprocess(path, setup, dialect="fanuc", expand=True).program
    assert not re.search(r"\bG[23]\b", program)
    plain = cldata.from_arrays(path.points, path.axes, feed=600)
    assert program == postprocess(plain, setup, dialect="fanuc", name="CL data").program


@pytest.mark.parametrize(
    ("name", "tilted"), [("ac_table", 0.0), ("ac_table", 30.0), ("ac_head", 0.0), ("ac_head", 30.0)]
)
def test_an_arc_that_no_plane_of_the_machine_holds_stays_straight(name, tilted):
    """A head that is tilted moves its arcs out of XY, ZX and YZ; with a table they are square to Z again."""
    setup, *vectors = on_machine(name, A=tilted, C=25.0)
    path = cldata.parse(arcs_file(np.random.default_rng(5), *vectors)[0])
    program = postprocess(path, setup, dialect="linuxcnc").program
    assert bool(re.search(r"\bG[23]\b", program)) == (name == "ac_table" or not tilted)


def test_the_planes_of_a_control_and_back():
    """An arc about X is in G19; behind it G17 holds again, in which the radius is compensated."""
    lines = [
        "UNITS/MM",
        "FEDRAT/600,MMPM",
        "GOTO/0,10,0,0,0,1",
        "CIRCLE/0,0,0,1,0,0,10",
        "GOTO/0,0,10",
        "GOTO/5,0,10",
    ]
    path = cldata.parse("\n".join(lines) + "\n")
    text = postprocess(path, load_machine("ac_table").with_setup(), dialect="fanuc").program
    assert re.search(r"G19 G3 .*\nN\d+ G17\nN\d+ G1 ", text) or "G18" in text
    klartext = postprocess(path, load_machine("ac_table"), dialect="heidenhain").program
    assert "CC" not in klartext  # its file knows arcs in XY only


@pytest.mark.parametrize("control", ["heidenhain", "fanuc", "siemens"])
def test_a_compensation_begins_on_a_line_and_goes_on_over_arcs(control):
    lines = ["UNITS/MM", "FEDRAT/600,MMPM", "GOTO/20,-10,0,0,0,1", "CUTCOM/LEFT", "GOTO/20,0,0",
             "CIRCLE/0,0,0,0,0,1,20", "GOTO/-20,0,0", "GOTO/-20,-20,0", "CUTCOM/OFF", "GOTO/-40,-20,0"]  # fmt: skip
    text = postprocess(cldata.parse("\n".join(lines) + "\n"), load_machine("ac_table"), dialect=control).program
    on, off = {"heidenhain": ("RL", "R0")}.get(control, ("G41", "G40"))
    between = text[re.search(rf"{on}\b", text).start() : text.rindex(off)]
    assert len(between.splitlines()) < 7 and re.search(r"\bG3 |\bC ", between)
    first = next(line for line in text.splitlines() if re.search(rf"\b{on}\b", line))
    assert not re.search(r"\bG[23]\b|\bC ", first)


@pytest.mark.parametrize("control", CONTROLS)
def test_arcs_holes_and_coolant_of_a_second_tool_are_in_the_same_places_as_those_of_the_first(control):
    part = ["GOTO/20,-10,5,0,0,1", "GOTO/20,0,5", "COOLNT/FLOOD", "CIRCLE/0,0,5,0,0,1,20", "GOTO/-20,0,5",
            "COOLNT/OFF", "GOTO/-20,-9,5", "CYCLE/DRILL,DEPTH,8,MMPM,100,CLEAR,2", "GOTO/1,0,0", "GOTO/3,0,0",
            "CYCLE/OFF"]  # fmt: skip
    lines = ["FEDRAT/600,MMPM"]
    for tool in (1, 2):
        lines += [f"LOADTL/{tool}", "SPINDL/1000,RPM,CLW", *part]
    text = postprocess(cldata.parse("\n".join(lines) + "\n"), load_machine("ac_table"), dialect=control).program
    bare = re.sub(r"^N?\d+ |G43 H\d ", "", text, flags=re.MULTILINE)
    first, second = re.findall(r"\n([^\n]*X\+?20\.[^$]*?X\+?3\.\S*)", bare)
    assert first == second and re.search(r"\bG3 |\bC X", first) and "M8" in first


@pytest.mark.parametrize(("radius", "arcs"), [(90_000, 1), (150_000, 0)])
def test_an_arc_whose_centre_has_more_digits_than_controls_take_stays_straight(radius, arcs):
    rise = radius - np.sqrt(radius**2 - 200**2)
    lines = [
        "FEDRAT/600,MMPM",
        "GOTO/0,0,0,0,0,1",
        f"CIRCLE/{radius},0,0,0,0,-1,{radius}",
        f"GOTO/{rise:.9f},200,0",
    ]
    text = postprocess(cldata.parse("\n".join(lines) + "\n"), load_machine("ac_table"), dialect="fanuc").program
    assert len(re.findall(r"\bG[23]\b", text)) == arcs


CYCLES = {  # as CL data have them, and whether the tool comes out at its feed
    "DRILL,FEDTO,8,CLEAR,2,RTRCTO,6,MMPM,150": False,
    "DRILL,FEDTO,5,CLEAR,1,MMPM,120,DWELL,0.5": False,
    "DEEP,FEDTO,20,CLEAR,2,RTRCTO,9,STEP,6,MMPM,100": False,
    "BRKCHP,FEDTO,17,CLEAR,2,RTRCTO,5,STEP,5,MMPM,110": False,
    "REAM,FEDTO,12,CLEAR,3,MMPM,200": True,
    "BORE,FEDTO,9,CLEAR,2,MMPM,130": True,
    "TAP,FEDTO,10,CLEAR,4,RTRCTO,7,MMPM,500": True,
}


def holes_file(rng, axis, across, along):
    """Rows of holes, an arc and a line: the text, and point, depth, clearance, feed of each hole."""
    lines = ["UNITS/MM", "SPINDL/RPM,1000,CLW", "RAPID", f"GOTO/{numbers(30 * axis, axis)}", "FEDRAT/400,MMPM"]
    drilled = []
    for cycle in rng.permutation(list(CYCLES)):
        words = cycle.split(",")
        depth, clearance = float(words[2]), float(words[4])
        feed = float(words[words.index("MMPM") + 1])
        lines.append(f"CYCLE/{cycle}")
        for _ in range(rng.integers(1, 4)):
            point = rng.uniform(-30, 30) * across + rng.uniform(-30, 30) * along
            lines.append(f"GOTO/{numbers(point)}")
            drilled.append((point, depth, clearance, feed))
        lines.append("CYCLE/OFF")
    start, centre = 40 * across, 32 * across
    lines += ["RAPID", f"GOTO/{numbers(start + 9 * axis)}", f"GOTO/{numbers(start)}"]
    lines += [f"CIRCLE/{numbers(centre, axis)},8", f"GOTO/{numbers(centre - 8 * across)}"]
    lines += [f"GOTO/{numbers(centre - 8 * across + 30 * axis)}"]
    return "\n".join(lines) + "\n", drilled


@pytest.mark.parametrize("tilted", [False, True], ids=["upright", "tilted"])
@pytest.mark.parametrize("number", range(6))
def test_holes_and_planes_are_run(number, tilted):
    rng = np.random.default_rng(50 + number)
    name, control = MACHINES[(number + 2) % 6], CONTROLS[(number + 3 * tilted) % 6]
    turned = {letter: rng.uniform(10, 30) for letter in "ABC"} if tilted else {}
    setup, axis, across, along = on_machine(name, **turned)
    text, drilled = holes_file(rng, axis, across, along)
    result = postprocess(cldata.parse(text), setup, dialect=control)
    moves, samples = moves_of(result, setup, control, name)
    knows_planes = control in ("heidenhain", "fanuc", "siemens", "mazak") and setup.programmed_point == "tip"
    assert any(move.cycle for move in moves) == (not tilted or knows_planes or name in TABLES)
    assert any(move.modal["tilted"] for move in moves) == (tilted and knows_planes)
    assert max(judge.between(each, axis) for each in samples.axis) < 2e-4
    for point, depth, clearance, feed in drilled:
        from_point = samples.tip - point
        height = from_point @ axis
        beside = np.linalg.norm(from_point - height[:, None] * axis, axis=1)
        above = beside < 1e-3
        assert height[above].min() == pytest.approx(-depth, abs=1e-3)
        cut = [moves[move] for move in np.unique(samples.move[above & (height < clearance - 0.01)])]
        # A head whose axes run at their own rates in rapid traverse states the time of the way out.
        down = [move for move in cut if move.kind == "feed" and move.modal["feed mode"] != 93]
        assert down and all(move.feed == pytest.approx(feed, abs=2e-3) for move in down)
    assert samples.tip[-1] @ axis == pytest.approx(30, abs=1e-3)
    assert min(samples.tip @ axis) > -20 - 1e-3


@pytest.mark.parametrize("name", ["ac_table", "head_b_table_c"])
@pytest.mark.parametrize("control", CONTROLS)
def test_with_tcp_the_tip_is_not_kept_in_holes_of_one_orientation(control, name):
    """Moves in five axes, holes with the tool leaned, and moves in five axes again."""
    setup, axis, across, along = on_machine(name, **{"A": 20.0, "B": 20.0, "C": 35.0})
    lines, points, axes = ["UNITS/MM", "SPINDL/RPM,1000,CLW", "FEDRAT/400,MMPM"], [], []

    def go(point, tool):
        points.append(point)
        axes.append(tool)
        lines.append(f"GOTO/{numbers(point, tool)}")

    for part in (-4, -3, -2):
        go(10.0 * part * across, unit(axis + 0.05 * part * along))
    lines.append("RAPID")
    go(30.0 * axis, axis)
    lines.append("CYCLE/DRILL,FEDTO,8,CLEAR,3,MMPM,120")
    holes = [5.0 * along, 9.0 * across, -12.0 * along]
    lines += [f"GOTO/{numbers(hole, axis)}" for hole in holes]
    lines += ["CYCLE/OFF", "RAPID"]
    points += [hole - 8.0 * axis for hole in holes]
    axes += [axis] * 3
    go(30.0 * axis + 5.0 * across, axis)
    for part in (2, 3, 4):
        go(10.0 * part * across, unit(axis + 0.05 * part * along))
    result = postprocess(cldata.parse("\n".join(lines) + "\n"), setup, dialect=control, tcp=True)
    moves, samples = moves_of(result, setup, control, name)
    taken = name != "head_b_table_c" or control in ("heidenhain", "fanuc", "siemens", "mazak")  # have leaned planes
    assert any(move.cycle for move in moves) == taken
    assert not any(move.cycle and move.tcp for move in moves) and moves[1].tcp and moves[-1].tcp
    assert any("holes that are straight moves, 3 of 3" in each for each in result.report.warnings) != taken
    assert not judge.records_missed(samples.tip, samples.axis, np.array(points), np.array(axes), 1e-3, 2e-3)


KLARTEXT = {"200": 3, "201": 2, "203": 1, "207": 1}  # how many of `CYCLES` each cycle of Heidenhain drills


@pytest.mark.parametrize("sense", ["CLW", "CCLW"])
def test_klartext_has_a_cycle_for_each_kind(sense):
    setup, *vectors = on_machine("ac_table")
    text, _ = holes_file(np.random.default_rng(9), *vectors)
    program = postprocess(cldata.parse(text.replace("CLW", sense)), setup, dialect="heidenhain").program
    assert {number: program.count(f"CYCL DEF {number} ") for number in KLARTEXT} == KLARTEXT
    assert ("Q239=+0.5000" if sense == "CLW" else "Q239=-0.5000") in program


PECKED = {  # a hole 20 mm deep from 2 mm above, by 6 mm: heights behind each stroke, by the manuals and parameters
    ("fanuc", "DEEP"): [-4, 2, -3, -10, 2, -9, -16, 2, -15],
    ("fanuc", "BRKCHP"): [-4, -3.5, -10, -9.5, -16, -15.5],
    ("heidenhain", "DEEP"): [-6, 2, -4, -12, 2, -10, -18, 2, -16],
    ("heidenhain", "BRKCHP"): [-6, -5.8, -12, -11.8, -18, -17.8],
    ("siemens", "DEEP"): [-6, 2, -5.4, -12, 2, -11.4, -18, 2, -17.4],
    ("siemens", "BRKCHP"): [-6, -5, -12, -11, -18, -17],
    ("linuxcnc", "DEEP"): [-4, 2, -3.746, -10, 2, -9.746, -16, 2, -15.746],
    ("linuxcnc", "BRKCHP"): [-4, -3.746, -10, -9.746, -16, -15.746],
}


@pytest.mark.parametrize(("control", "kind"), PECKED)
def test_the_time_has_the_pecks(control, kind):
    """What pecks cost, against sums of ramps and even speed of every stroke, from rest to rest."""
    setup, axis, *_ = on_machine("ac_table")
    feed, rapid, acceleration = 90 / 60, setup.linear[2].max_rate, setup.linear[2].max_acceleration
    times = {}
    for words in (kind, "DRILL"):
        step = ",STEP,6" * (words == kind)
        cycle = f"CYCLE/{words},FEDTO,20,CLEAR,2{step},MMPM,90"
        lines = [
            "UNITS/MM",
            "RAPID",
            f"GOTO/-9,0,30,{numbers(axis)}",
            cycle,
            "GOTO/0,0,0",
            "GOTO/9,0,0",
            "CYCLE/OFF",
        ]
        result = postprocess(cldata.parse("\n".join(lines) + "\n"), setup, dialect=control)
        times[words] = result.report.time
        assert "the time has none" not in str(result.report)

    def stroke(distance, speed):
        """Seconds from rest to rest."""
        reached = min(speed, np.sqrt(distance * acceleration))
        return distance / reached + reached / acceleration

    levels = [2.0, *PECKED[control, kind], -20.0]
    seconds = 0.0
    for n, (start, end) in enumerate(pairwise(levels)):
        cuts = end < min(levels[: n + 1])
        seconds += stroke(abs(end - start), feed if cuts else rapid)
    extra = seconds - stroke(22.0, feed)
    # The time law passes a turning point at the speed that an axis changes within its time to settle.
    measured = (times[kind] - times["DRILL"]) / 2
    assert extra - 0.028 * len(PECKED[control, kind]) <= measured <= extra + 1e-3


def test_no_plane_where_the_control_does_not_know_the_tool():
    """X Y Z of a plane name the tip: not where they are those of the nose, and the tool table holds no length."""
    for name in ("ac_head", "nutating_head_table"):
        setup, *vectors = on_machine(name, A=20.0, B=20.0, C=15.0)
        program = postprocess(cldata.parse(holes_file(np.random.default_rng(1), *vectors)[0]), setup).program
        assert "PLANE" not in program and "CYCL DEF 200" not in program


def test_what_the_control_holds_is_said_for_a_plane():
    setup, *vectors = on_machine("dmu50v", B=20.0, C=15.0)
    program = postprocess(
        cldata.parse(holes_file(np.random.default_rng(1), *vectors)[0]), setup, dialect="fanuc"
    ).program
    head = program[: program.index("G0")]
    assert "CONTROL HOLDS: B THROUGH X50 Y0 Z0" in head and head.count("80 MM FROM NOSE TO TIP") == 1
    assert program.index("G68.2") < program.index("G53.1") < program.index("G69")


TOOLS = """UNITS/MM
LOAD/TOOL,3,LENGTH,95.5
SPINDL/RPM,8000,CLW
COOLNT/THRU
FEDRAT/500,MMPM
GOTO/0,0,10,0,0,1
GOTO/0,0,0
LOAD/TOOL,7,LENGTH,130,OSETNO,17
COOLNT/FLOOD
GOTO/0,5,10
GOTO/20,5,0
"""


def test_tools_offsets_and_coolant(tmp_path):
    """A list in the head, the next tool, the offset in the block of the approach, M words of a file."""
    file = tmp_path / "own.toml"
    words = ['name = "own"', 'inherits = "fanuc"', "[commands]", '"coolant THRU" = ["M51"]']
    file.write_text("\n".join(words) + "\n", encoding="utf-8")
    setup = replace(load_machine("ac_table"), program_head=("G54",))
    result = postprocess(cldata.parse(TOOLS), setup, dialect=file)
    lines = [re.sub(r"^N\d+ ", "", line) for line in result.program.splitlines()]
    assert "(TOOL 3: LENGTH 95.5 MM, OFFSET 3)" in lines and "(TOOL 7: LENGTH 130 MM, OFFSET 17)" in lines
    assert lines.index("T3 M6") == lines.index("T7") - 1 and lines.index("T7 M6") == lines.index("T3") - 1
    assert "M51" in lines and "stays off" not in str(result.report)
    approach = [line for line in lines if "G43" in line]
    assert [re.search(r"G43 H(\d+) X", line)[1] for line in approach] == ["3", "17"]
    plain = postprocess(cldata.parse(TOOLS), setup, dialect="fanuc")
    lengths = {3: 95.5, 7: 130.0, 17: 130.0}
    moves = read(plain.program, "fanuc", Setup(Model(DATA / "machines" / "ac_table.toml"), lengths=lengths))
    assert moves[-1].tool_length == 130.0
