"""The independent reader against cases that are worked out by hand."""

import math
from pathlib import Path

import numpy as np
import pytest

from .machine_model import Model, rotation
from .reader import Setup, read
from .words import Refused

MACHINES = Path(__file__).parents[2] / "data" / "machines"
WITH_TWO_AXES = [
    path for path in sorted(MACHINES.glob("*.toml")) if path.read_text(encoding="utf-8").count("[[rotary]]") == 2
]


def model(name, **more):
    return Model(MACHINES / f"{name}.toml", **more)


def run(machine, dialect, program, **more):
    """Moves of a program that begins at a known place."""
    more.setdefault("start", (np.zeros(3), np.zeros(len(machine.letters))))
    return read("\n".join(program), dialect, Setup(machine, length_on=True, **more))


def ends(machine, moves):
    return np.array([move.joints(machine, 1.0) for move in moves])


class TestMachines:
    def test_quarter_turn_is_right_handed(self):
        assert np.allclose(rotation((0, 0, 1), 90) @ [1, 0, 0], [0, 1, 0])
        assert np.allclose(rotation((1, 0, 0), 90) @ [0, 1, 0], [0, 0, 1])

    def test_half_turn_of_the_inclined_table(self):
        """dmu50v, B180 about (0, 1, 1): y and z of the workpiece change places, x goes to 100 − x."""
        machine = model("dmu50v")
        tip, axis = machine.place([10, 20, 30], [180, 0])
        assert np.allclose(tip, [90, 30, 20])
        assert np.allclose(axis, [0, 1, 0])

    def test_b90_of_the_inclined_table(self):
        """k = (0, 1, 1)/√2: the spindle z, turned back by 90°, is k (k·z) − k × z = (−1/√2, 1/2, 1/2)."""
        axis = model("dmu50v").place([0, 0, 0], [90, 0])[1]
        assert np.allclose(axis, [-math.sqrt(0.5), 0.5, 0.5])

    def test_iso_table_turns_against_its_angle(self):
        """ac_table at A90: the table turns −90° about X, the tool comes from the workpiece's −Y."""
        axis = model("ac_table").place([0, 0, 0], [90, 0])[1]
        assert np.allclose(axis, [0, -1, 0])

    def test_fork_head_swings_its_pivot_to_tip_length(self):
        """ac_head: pivot 200 above the nose, tool 150: at A90 the tip is 350 in front of the pivot, towards +Y."""
        machine = model("ac_head")
        nose = machine.nose_of_words([0, 0, 0], 150)
        tip, axis = machine.place(nose, [0, 90])
        assert np.allclose(tip, [0, 350, 0])
        assert np.allclose(axis, [0, -1, 0])

    def test_words_name_tip_nose_or_pivot(self):
        assert np.allclose(
            model("ac_table").place(model("ac_table").nose_of_words([1, 2, 3], 120), [0, 0])[0], [1, 2, 3]
        )
        nutating = model("nutating_head_table")
        assert np.allclose(nutating.place(nutating.nose_of_words([1, 2, 3], 140), [0, 0])[0], [1, 2, 3 - 140])

    def test_the_way_back(self):
        """`nose_for` undoes `place` on every machine, at any angles and tool length."""
        random = np.random.default_rng(5)
        for file in WITH_TWO_AXES:
            machine = Model(file)
            angles = random.uniform(-100, 100, 2)
            nose = random.uniform(-100, 100, 3)
            tip, axis = machine.place(nose, angles, 77)
            assert np.allclose(machine.nose_for(tip, angles, 77), nose)
            found = machine.angles_for(axis, angles)
            assert found and np.allclose(machine.place(nose, found[0], 77)[1], axis)

    def test_one_rotary_axis(self):
        data = {
            "rotary": [{"name": "A", "carries": "workpiece", "axis": [-1, 0, 0], "point": [0, 0, 10]}],
            "workpiece": {"origin": [0, 0, 0]},
            "tool": {"axis": [0, 0, 1], "length": 50},
        }
        tip, axis = Model(data).place([0, 0, 60 + 50], [90])
        assert np.allclose(tip, [0, -50, 10])
        assert np.allclose(axis, [0, -1, 0])


class TestModalState:
    def test_fmax_holds_for_its_block(self):
        moves = run(model("dmu50v"), "heidenhain", ["L X+10 R0 F600", "L Y+5 FMAX", "L Z+1"])
        assert [move.kind for move in moves] == ["feed", "rapid", "feed"]
        assert math.isclose(moves[2].seconds, 60 / 600)

    def test_ft_is_seconds_of_its_block(self):
        moves = run(model("dmu50v"), "heidenhain", ["L X+10 F600", "L X+20 FT2.5", "L X+30"])
        assert [move.seconds for move in moves] == [1.0, 2.5, 1.0]

    def test_inverse_time_needs_f_in_each_block(self):
        moves = run(model("ac_table"), "fanuc", ["G93 G1 X10. C90. F30."])
        assert (moves[0].seconds, moves[0].law) == (2.0, "inverse time")
        with pytest.raises(Refused, match="line 2"):
            run(model("ac_table"), "fanuc", ["G93 G1 X10. F30.", "X20."])

    def test_what_f_means_beside_a_turn(self):
        """B-63174EN 4.2: X20 C40 at F300 takes 0.14907 min; LinuxCNC and Siemens count X alone."""
        block = ["G90 G94 G1 X20. C40. F300."]
        seconds = {d: run(model("ac_table"), d, block)[0].seconds for d in ("fanuc", "linuxcnc", "siemens")}
        assert math.isclose(seconds["fanuc"], 0.14907 * 60, rel_tol=1e-4)
        assert math.isclose(seconds["linuxcnc"], 4.0) and math.isclose(seconds["siemens"], 4.0)
        for dialect in ("fanuc", "linuxcnc", "siemens"):
            assert math.isclose(run(model("ac_table"), dialect, ["G1 C90. F360."])[0].seconds, 15.0)

    def test_fgroup_with_its_reference_radius(self):
        program = ["FGROUP(X,Y,Z,C)", "FGREF[C]=57.29577951", "G1 X3 C4 F60", "FGREF[C]=10", "C94"]
        moves = run(model("ac_table"), "siemens", program)
        assert math.isclose(moves[0].seconds, 5.0)
        assert math.isclose(moves[1].seconds, 5 * math.pi)

    def test_incremental_inch_and_offsets(self):
        machine = model("ac_table")
        program = ["G20 G91 G0 X1.", "G90 G21 G55 X5.", "G52 X2.", "X0"]
        moves = run(machine, "fanuc", program, start=([0, 0, 120], [0, 0]), offsets={"G55": [100, 0, 0]})
        assert np.allclose(ends(machine, moves)[:, 0], [25.4, 105, 102])

    def test_machine_coordinates(self):
        """bc_table: origin (20, 0, 40), tool 150, tip named: machine Z0 is the word −190, X100 the word 80."""
        machine = model("bc_table")
        for dialect, block in [
            ("fanuc", "G0 G53 X100. Z0"),
            ("siemens", "G0 SUPA X100 Z0"),
            ("heidenhain", "L X+100 Z+0 FMAX M91"),
        ]:
            assert np.allclose(ends(machine, run(machine, dialect, [block]))[0, [0, 2]], [80, -190])

    def test_optional_skip(self):
        machine = model("ac_table")
        assert len(run(machine, "fanuc", ["/G0 X1.", "G0 Y1."], optional_skip=True)) == 1
        assert len(run(machine, "fanuc", ["/G0 X1.", "G0 Y1."])) == 2

    def test_length_of_the_tool_in_the_words(self):
        """After G49 a Z names the nose: the tip is a tool's length deeper."""
        machine = model("ac_table")
        moves = run(machine, "fanuc", ["G0 G43 H1 Z50.", "G49", "Z50."], lengths={1: 80})
        assert np.isclose(moves[0].place(machine, 1.0)[0][2], 50)
        assert np.isclose(moves[1].place(machine, 1.0)[0][2], -30)


class TestTip:
    @pytest.mark.parametrize("name", [file.stem for file in WITH_TWO_AXES])
    def test_tip_stands_while_axes_turn(self, name):
        """M128, G43.4, TRAORI: a turn alone leaves the tip where it was, all the way, on heads and tables."""
        machine = model(name)
        a, b = machine.letters
        programs = {
            "heidenhain": ["M128", "L X+10 Y-20 Z+30 F1000", f"L {a}+20 {b}+30"],
            "fanuc": ["G43.4 H1", "G1 X10. Y-20. Z30. F1000.", f"{a}20. {b}30."],
            "mazak": ["G43.4 H1", "G1 X10. Y-20. Z30. F1000.", f"{a}20. {b}30."],
            "siemens": ["TRAORI", "G1 X10 Y-20 Z30 F1000", f"{a}20 {b}=DC(30)"],
            "haas": ["G234 H1", "G1 X10. Y-20. Z30. F1000.", f"{a}20. {b}30."],
            "linuxcnc": ["M68 E3 Q1", "M66 E0 L0", "G1 X10 Y-20 Z30 F1000", f"{a}20 {b}30"],
        }
        for dialect, program in programs.items():
            last = run(machine, dialect, program)[-1]
            for t in (0.0, 0.3, 1.0):
                assert np.allclose(last.place(machine, t)[0], [10, -20, 30], atol=1e-9)
            assert np.allclose(last.joints(machine, 1.0)[3:], [20, 30])

    def test_without_tcp_the_joints_are_straight(self):
        machine = model("ac_table")
        move = run(machine, "fanuc", ["G1 X10. A90. F100."])[0]
        assert np.allclose(move.joints(machine, 0.5), [5, 0, -120, 45, 0])

    def test_tool_vector(self):
        machine = model("ac_table")
        move = run(machine, "mazak", ["G43.5 H1", "G1 X0 Y0 Z0 I0 J-1. K1. F100."])[-1]
        assert np.allclose(move.place(machine, 1.0)[1], [0, -math.sqrt(0.5), math.sqrt(0.5)])

    def test_the_shorter_way(self):
        machine = model("ac_table")
        start = (np.zeros(3), [0, 350])
        assert run(machine, "heidenhain", ["M126", "L C+10 FMAX"], start=start)[0].end[1] == 370
        assert run(machine, "heidenhain", ["L C+10 FMAX"], start=start)[0].end[1] == 10


class TestPlanes:
    def test_the_same_plane_in_three_controls(self):
        """SPC+90 SPB+30 = Euler ZXZ (90 + 90, 30, −90) = axis by axis about Z then Y: one place, one axis."""
        machine = model("ac_table", origin=(5, 6, 7))
        turn = rotation((0, 0, 1), 90) @ rotation((0, 1, 0), 30)
        programs = {
            "heidenhain": ["PLANE SPATIAL SPA+0 SPB+30 SPC+90 TURN FMAX", "L X+10 Y+20 Z+30 FMAX"],
            "fanuc": ["G68.2 X0 Y0 Z0 I180. J30. K-90.", "G53.1", "G0 X10. Y20. Z30."],
            "siemens": ['CYCLE800(1,"",0,27,0,0,0,90,30,0,0,0,0,1,,)', "G0 X10 Y20 Z30"],
        }
        for dialect, program in programs.items():
            move = run(machine, dialect, program)[-1]
            tip, axis = move.place(machine, 1.0)
            assert np.allclose(tip, turn @ [10, 20, 30], atol=1e-6), dialect
            assert np.allclose(axis, turn[:, 2], atol=1e-6), dialect

    def test_dynamic_work_offset_follows_the_table(self):
        machine = model("ac_table", origin=(50, 0, 0))
        move = run(machine, "haas", ["G0 C90.", "G254", "X10. Y0 Z0"])[-1]
        # C90 turns the workpiece clockwise: its origin stands at (0, −50); 10 along machine X is its own +Y.
        assert np.allclose(move.place(machine, 1.0)[0], [0, 10, 0])

    def test_helix_on_a_plane(self):
        machine = model("ac_table")
        program = ["G68.2 X0 Y0 Z0 I0 J90. K0", "G53.1", "G0 X10. Y0 Z0", "G3 X-10. Y0 Z4. I-10. J0 F60."]
        move = run(machine, "fanuc", program)[-1]
        # J90: plane X stays, plane Y is the workpiece's Z, plane Z is its −Y.
        assert np.allclose(move.place(machine, 0.5)[0], [0, -2, 10], atol=1e-6)
        assert math.isclose(move.seconds, math.hypot(10 * math.pi, 4), rel_tol=1e-3)


class TestArcsAndHoles:
    def test_quarter_in_each_way_of_writing(self):
        machine = model("dmu50v")
        programs = {
            "fanuc": ["G0 X10. Y0 Z0", "G17 G3 X0 Y10. I-10. J0 F100."],
            "mazak": ["G0 X10. Y0 Z0", "G17 G3 X0 Y10. R10. F100."],
            "siemens": ["G0 X10 Y0 Z0", "G17 G3 X0 Y10 CR=10 F100"],
            "linuxcnc": ["G0 X10 Y0 Z0", "g17 g3 x0 y10 i-10 j0 f100"],
            "heidenhain": ["L X+10 Y+0 Z+0 FMAX", "CC X+0 Y+0", "C X+0 Y+10 DR+ F100"],
        }
        for dialect, program in programs.items():
            move = run(machine, dialect, program)[-1]
            assert np.allclose(move.joints(machine, 0.5)[:3], [10 * math.sqrt(0.5), 10 * math.sqrt(0.5), 0])
            assert math.isclose(move.seconds, 5 * math.pi / 100 * 60, rel_tol=1e-4)

    def test_three_quarters_and_a_full_circle(self):
        machine = model("dmu50v")
        moves = run(machine, "fanuc", ["G0 X10. Y0 Z0", "G2 X0 Y10. R-10. F100.", "G2 J-10."])
        assert np.allclose(moves[1].joints(machine, 0.5)[:3], [-10 * math.sqrt(0.5), -10 * math.sqrt(0.5), 0])
        assert np.allclose(moves[2].joints(machine, 0.5)[:3], [0, -10, 0])

    def test_the_plane_of_g18_turns_from_z_to_x(self):
        machine = model("dmu50v")
        move = run(machine, "fanuc", ["G0 X0 Y0 Z10.", "G18 G3 X10. Z0 K-10. F100."])[-1]
        assert np.allclose(move.joints(machine, 0.5)[:3], [10 * math.sqrt(0.5), 0, 10 * math.sqrt(0.5)])

    def test_a_helix_by_cp(self):
        machine = model("dmu50v")
        move = run(machine, "heidenhain", ["L X+10 Y+0 Z+0 FMAX", "CC X+0 Y+0", "CP IPA+720 Z-8 DR+ F100"])[-1]
        assert np.allclose(move.joints(machine, 0.25)[:3], [-10, 0, -2], atol=1e-9)

    def test_radii_that_differ_are_refused(self):
        with pytest.raises(Refused, match="radius"):
            run(model("dmu50v"), "fanuc", ["G0 X10. Y0 Z0", "G3 X0 Y12. I-10. J0 F100."])

    def test_pecks(self):
        machine = model("dmu50v")
        moves = run(machine, "fanuc", ["G0 Z50.", "G98 G83 X5. Y6. Z-7. R2. Q4. F100.", "X9.", "G80"])
        heights = [move.joints(machine, 1.0)[2] for move in moves[1:8]]
        assert np.allclose(heights, [50, 2, -2, 2, -2, -6, 2]) and all(move.cycle for move in moves[1:])
        assert np.allclose(moves[-1].joints(machine, 1.0)[:3], [9, 6, 50])

    def test_the_same_hole_by_three_controls(self):
        machine = model("dmu50v")
        programs = {
            "fanuc": ["G0 X1. Y2. Z20.", "G99 G82 Z-10. R3. P500 F120."],
            "siemens": ["G0 X1 Y2 Z20", "F120", "CYCLE82(3,0,3,-10,,0.5)"],
            "heidenhain": [
                "L X+1 Y+2 Z+20 FMAX",
                "CYCL DEF 200 DRILLING ~",
                "Q200=+3 ~",
                "Q201=-10 ~",
                "Q206=+120 ~",
                "Q202=+10 ~",
                "Q210=+0 ~",
                "Q203=+0 ~",
                "Q204=+3 ~",
                "Q211=+0.5",
                "CYCL CALL",
            ],
        }
        for dialect, program in programs.items():
            moves = [move for move in run(machine, dialect, program) if move.cycle]
            cut = [move for move in moves if move.kind == "feed"]
            assert len(cut) == 1 and math.isclose(cut[0].seconds, 6.5), dialect
            assert sum(move.seconds for move in moves if move.kind == "dwell") == 0.5
            assert np.allclose(moves[-1].joints(machine, 1.0)[:3], [1, 2, 3])

    def test_withdrawal_along_the_tool(self):
        machine = model("ac_head")
        moves = run(machine, "heidenhain", ["L X+0 Y+0 Z+0 A+90 FMAX", "M140 MB50"])
        assert np.allclose(moves[-1].joints(machine, 1.0)[:3], [0, -50, 0])


REFUSED = [
    ("fanuc", "G43.4", "without H"),
    ("fanuc", "G1 X1.", "without a feed"),
    ("fanuc", "G0 X10", "decimal point"),
    ("fanuc", "G0 X1. X2.", "twice"),
    ("fanuc", "G0 G1 X1. F10.", "one block"),
    ("fanuc", "G0 B1.", "no B"),
    ("fanuc", "G0 X1. (open", "not closed"),
    ("fanuc", "TRAORI", "not know"),
    ("fanuc", "G53.1", "without G68.2"),
    ("fanuc", "X1.", "without a motion"),
    ("fanuc", "M123", "M123"),
    ("fanuc", "G0 G55 X1.", "not set up"),
    ("linuxcnc", "G43.4 H1", "no code"),
    ("siemens", "G43 H1", "no code"),
    ("siemens", "TRAORY", "no word"),
    ("siemens", "TRAORI\nG0 SUPA Z0", "TRAORI"),
    ("heidenhain", "G0 X10", "begins no block"),
    ("heidenhain", "L X+1", "without a feed"),
    ("heidenhain", "L X+1 FMAX M500", "M500"),
    ("heidenhain", "M128\nL Z+0 FMAX M91", "M128"),
    ("heidenhain", "M128\nTOOL CALL 5 Z S1000", "M128"),
]


@pytest.mark.parametrize(("dialect", "program", "why"), REFUSED)
def test_refused(dialect, program, why):
    lines = program.split("\n")
    with pytest.raises(Refused, match=why) as error:
        run(model("ac_table"), dialect, lines)
    assert error.value.line == len(lines)
