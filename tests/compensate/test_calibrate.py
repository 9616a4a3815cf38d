"""From files of readings to a compensated machine: the loop, the signs, the uncertainty, what is asked for."""

import itertools
import re
from dataclasses import replace

import numpy as np
import pytest
import tomlkit

from mathpost import machine_file as machines
from mathpost.errors import InputError
from mathpost.interface.shell.main import main
from mathpost.kinematics import Kinematics
from mathpost.shop.compensate import handover, readings
from mathpost.shop.compensate.calibrate import calibrate
from mathpost.shop.compensate.compensation import Compensator
from mathpost.shop.compensate.estimate import estimate
from mathpost.shop.compensate.model import constant_errors, read_errors
from mathpost.shop.compensate.moved import moved
from mathpost.shop.measure import rotary_axis
from tests.compensate.measured import AGAINST, ISO, Real, believed, files, left, nominal
from tests.machines import with_slides

ARCSECOND = np.deg2rad(1 / 3600)
ARRANGEMENTS = [("table", ISO), ("mixed", AGAINST), ("head", ISO)]
LASER = {"method": "laser", "unit": "arcsec", "axis": "C"}
UP_DOWN = "position,up1,down1,up2,down2"
arrangements = pytest.mark.parametrize(("arrangement", "sign"), ARRANGEMENTS)


def text(*rows, **settings):
    return "".join(f"# {key} = {value}\n" for key, value in settings.items()) + "\n".join(rows) + "\n"


@pytest.fixture
def write(tmp_path):
    numbers = itertools.count()

    def write(content, encoding="utf-8"):
        path = tmp_path / f"readings{next(numbers)}.csv"
        path.write_bytes(content if isinstance(content, bytes) else content.encode(encoding))
        return path

    return write


# The loop


@arrangements
def test_readings_without_noise_leave_nothing(arrangement, sign, tmp_path):
    machine, rng = nominal(arrangement, sign), np.random.default_rng(5)
    real = Real.random(machine, rng, positioning=False)
    paths = files(real, tmp_path, rng, noise=0.0, only=("ball", "probe", "dial", "tip", "ballbar"))
    found = estimate(machine, [readings.read(path, machine) for path in paths])  # no cause is sought for no noise
    angles = rng.uniform(-0.8, 0.8, (20, 2))
    place, length = rng.uniform(-100, 100, (20, 3)), np.full(20, 120.0)
    before, after = (left(real, control, place, angles, length) for control in (Real(machine), believed(found)))
    assert np.abs(before).max() > 0.01 and np.abs(after).max() < 1e-5


@pytest.mark.parametrize(
    ("arrangement", "sign", "carried"), [*((*each, "") for each in ARRANGEMENTS), ("table", ISO, "XZ")]
)
def test_a_program_for_the_calibrated_machine_arrives(arrangement, sign, carried, tmp_path):
    """Files, shell, machine file, errors file, inverse, compensation: measured again by SciPy's machine.

    What the slides do between tool and workpiece does not depend on which of the two they carry.
    """
    machine, rng = nominal(arrangement, sign), np.random.default_rng(8)
    machine = with_slides(machine, carried, "".join(sorted(set("XYZ") - set(carried))))
    real = Real.random(machine, rng)
    real.positioning["X"] = lambda x: 0.01 * (x / 400) ** 2
    path = tmp_path / "nominal.toml"
    path.write_text(tomlkit.dumps(content(machine)), encoding="utf-8")
    read = files(real, tmp_path, rng)
    assert main(["calibrate", str(path), *map(str, read), "-o", str(tmp_path / "out")]) == 0
    calibrated = machines.load(tmp_path / "out/machine.toml")
    errors = read_errors(tmp_path / "out/errors.toml", calibrated)
    tilted = 0 if arrangement == "table" else 1
    poses = np.zeros((8, 5))
    poses[:, 3 + tilted], poses[1:, 4 - tilted] = (
        np.deg2rad([0, 30, -40, 20, 45, -15, 25, 35]),
        rng.uniform(0, 6, 7),
    )
    poses[:, :3] = rng.uniform(-80, 80, (8, 3))

    def missed(machine, correct):
        """The tip from where it should be, the datum at the first pose with the first of the tools."""
        found, datum = [], None
        for length in (120.0, 320.0):
            kin = Kinematics(machine.with_setup(tool_length=length))
            tips, axes = kin.forward(poses)
            joints = correct(kin.machine, nearest(kin.inverse(tips, axes), poses))
            place = tips + machine.origin
            datum = reached(joints[:1], place[:1], length) if datum is None else datum
            found.append(np.linalg.norm(reached(joints, place + datum, length), axis=1))
        return np.array(found)

    def reached(joints, place, length):
        tip = real.tip(joints[:, :3] + machine.origin, joints[:, 3:], np.full(len(joints), length))
        return tip - real.ball(place, joints[:, 3:])

    def nearest(both, poses):
        turn = np.abs((both - poses[:, None])[..., 3:] + np.pi) % (2 * np.pi) - np.pi
        return both[np.arange(len(poses)), np.abs(turn).max(axis=-1).argmin(axis=-1)]

    before = missed(machine, lambda setup, joints: joints)
    after = missed(
        calibrated, lambda setup, joints: Compensator(replace(errors, machine=setup)).compensate(joints).joints
    )
    assert before[:, 1:].max(axis=1).min() > 0.02 and after[:, 1:].max() < 0.003


def content(machine):
    """A machine as the content of its file."""
    rotary = [
        {"name": r.name, "carries": r.carries, "axis": list(r.axis), "point": list(r.point)} for r in machine.rotary
    ]
    tool = {"axis": list(machine.tool_axis), "length": machine.tool_length}
    return {
        "name": "m",
        "source": "s",
        "rotary": rotary,
        "workpiece": {"origin": list(machine.origin)},
        "tool": tool,
        "linear": {each.name: {"carries": each.carries} for each in machine.linear},
    }


@pytest.mark.parametrize("table", ["ac_table", str(machines.data_file("machines/ac_table.toml"))])
def test_what_the_shell_writes_is_what_post_takes(table, tmp_path, capsys):
    given = str(machines.data_file("measurements/ball_c_axis.csv"))
    assert main(["calibrate", table, given, "-o", str(tmp_path)]) == 0
    assert "EX0C" in capsys.readouterr().out
    cl = str(machines.data_file("cl/blade.cl"))
    made = ["post", cl, "--machine", str(tmp_path / "machine.toml"), "--errors", str(tmp_path / "errors.toml")]
    assert main([*made, "-o", str(tmp_path / "p.h")]) == 0
    found = calibrate(machines.load("ac_table"), [given])
    assert machines.load(tmp_path / "machine.toml").rotary == found.machine.rotary
    assert main(["post", cl, "--machine", table, *made[4:], "-o", str(tmp_path / "q.h")]) == 2
    assert "from which the errors count" in capsys.readouterr().err


def test_readings_that_contradict_each_other_are_written_only_when_accepted(tmp_path, capsys):
    """The ball was read on a machine whose C is perfect, the autocollimator on one with a worn tooth."""
    data = machines.data_file("measurements")
    given = ["calibrate", "ac_table", str(data / "ball_c_axis.csv"), str(data / "angular_error.csv")]
    assert main([*given, "-o", str(tmp_path / "no")]) == 1 and not (tmp_path / "no").exists()
    captured = capsys.readouterr()
    assert captured.out.startswith("THE READINGS DO NOT FIT") and "nothing was written" in captured.err
    assert main([*given, "--accept", "-o", str(tmp_path / "yes")]) == 1
    for name in ("machine.toml", "errors.toml", "errors_c.csv", "siemens_c.ini", "terms.txt"):
        assert "DO NOT FIT" in (tmp_path / "yes" / name).read_text(encoding="utf-8")
    calibrated = machines.load(tmp_path / "yes/machine.toml")
    assert read_errors(tmp_path / "yes/errors.toml", calibrated).curves


def test_u_is_wide_with_few_spare_readings(write):
    rows = ["angle,R,dial", "0,100,0.0310", "90,100,-0.0212", "180,100,-0.0290", "270,100,0.0201"]
    machine = machines.load("ac_table")
    found = calibrate(machine, [write(text(*rows, method="dial", unit="mm", axis="C", positive="out"))])
    assert found["EX0C"].freedom == pytest.approx(1) and found["EX0C"].k == pytest.approx(12.706, abs=1e-3)
    assert found["EX0C"].value == pytest.approx(-0.030, abs=1e-9)
    stated = calibrate(
        machine, [write(text(*rows, method="dial", unit="mm", axis="C", positive="out", sigma=0.001))]
    )
    assert stated["EX0C"].k == pytest.approx(1.96, abs=1e-3)
    expected = 1.96 * 0.001 / np.sqrt(2)
    u = stated["EX0C"].U
    assert u == pytest.approx(expected, rel=1e-3)


def test_the_formula_of_one_method_finds_what_the_chain_finds():
    """Lessons 10 and 11 fit a formula of their own; `calibrate` has one chain for all."""
    data = machines.data_file("measurements")
    table, head = machines.load("ac_table"), machines.load("head_b_table_c")
    dial, probing, tip = rotary_axis.dial_circle(), rotary_axis.probing(table.rotary[0]), rotary_axis.rtcp_zero()
    by_formula = dial.identify(dial.read(data / "dial_circle.csv"))
    by_chain = calibrate(table, [data / "dial_circle.csv"])
    for name, other in {"ex": "EX0C", "ey": "EY0C"}.items():
        assert by_formula[name] == pytest.approx(-by_chain[other].value, abs=1e-6)
        assert pytest.approx(by_chain[other].U, rel=0.01) == by_formula.expanded(name).U
    by_formula = probing.identify(probing.read(data / "probing_a_axis.csv"))
    by_chain = calibrate(table, [data / "probing_a_axis.csv"])
    assert by_chain.machine.rotary[0].point[1:] == pytest.approx([by_formula["yc"], by_formula["zc"]], abs=3e-3)
    # Squareness, A's own positioning and the scale of the slides, which the formula takes for nothing, are in U.
    assert by_chain["EZ0A"].deviation > 1.5 * by_formula.expanded("zc").deviation
    by_formula = tip.identify(tip.read(data / "rtcp_tip.csv"))
    lines = handover.terms(calibrate(head, [data / "rtcp_tip.csv"])).splitlines()[2:5]
    said = [float(line.partition("±")[0].split()[-1]) for line in lines]
    expected = [np.rad2deg(by_formula["alpha"]), by_formula["dy"], by_formula["dL"]]
    assert said == pytest.approx(expected, abs=3e-4)


# Signs


@pytest.mark.parametrize("axis", [(0, 0, 1), (0, 0, -1), (0, 1, 1), (0, -1, -1)])
def test_arcseconds_of_a_table_through_the_converter_and_raw(axis, write):
    """+10″ of actual minus target: the command must be 10″ less, whichever way the table turns."""
    turning = machines.load("ac_table").rotary[1]
    machine = replace(
        machines.load("ac_table"), rotary=(machines.load("ac_table").rotary[0], replace(turning, axis=axis))
    )
    rows = ["C,up1,down1,up2,down2", *(f"{at},10,10,10,10" for at in range(0, 360, 30))]
    found = calibrate(machine, [write(text(*rows, method="autocollimator", unit="arcsec", axis="C"))])
    joints = np.array([50.0, 20, 30, 0.4, 0.7])
    entered = Compensator(found.errors).compensate(joints)
    assert (entered.joints - joints)[4] == pytest.approx(-10 * ARCSECOND, abs=1e-9)
    raw = Compensator(constant_errors(machine, {"ECC": 10 * ARCSECOND})).compensate(joints).joints
    left_over = (raw - joints)[4] + 10 * ARCSECOND
    if axis == (0, 0, 1):
        assert left_over == pytest.approx(0, abs=1e-9)
    if axis == (0, 0, -1):  # the error is doubled
        assert left_over == pytest.approx(20 * ARCSECOND, abs=1e-9)


@pytest.mark.parametrize("carries", ["tool", "workpiece"])
def test_a_slide_that_carries_the_table_errs_the_other_way(carries, write):
    machine = machines.load("ac_table")
    first, *others = machine.linear
    machine = replace(machine, linear=(replace(first, carries=carries), *others))
    rows = ["position,up1,down1,up2,down2", *(f"{at},5,5,5,5" for at in range(-400, 401, 100))]
    found = calibrate(machine, [write(text(*rows, method="laser", unit="µm", axis="X"))])
    joints = np.array([50.0, 20, 30, 0.4, 0.7])
    moved = Compensator(found.errors).compensate(joints).joints - joints
    np.testing.assert_allclose(moved, [-0.005, 0, 0, 0, 0], atol=1e-7)


@pytest.mark.parametrize(("given", "factor"), [("tip", 1), ("block", -1)])
def test_the_head_of_the_lesson(given, factor, write):
    """alpha 0.004°, dy 0.030, dL 0.050 of the reference, in the words of each control."""
    numbers = ("40,500,.0534204", "-40,500,-.0300264", "40,700,.0623953", "-40,700,-.0390015")
    rows = [f"{a},{L},{factor * float(x)}" for a, L, x in (row.split(",") for row in numbers)]
    path = write(text("angle,L,axial", *rows, method="tip", unit="mm", axis="B", positive=given))
    found = calibrate(machines.load("head_b_table_c"), [path])
    lines = [line.split() for line in handover.terms(found).splitlines()[2:5]]
    lines = {words[0].strip(","): float(words[words.index("±") - 1]) for words in lines}
    assert lines == pytest.approx({"alpha": 0.004, "dy": 0.03, "dL": 0.05}, abs=2e-5)


# The controls' own terms

BAR = ("face,at,shown", "+X,50,53.001", "-X,-50,-53.002", "+Y,0,3.0025", "+Z,80,80.004", "+Z,80,80.005")


@pytest.mark.parametrize(
    ("words", "line", "value"),
    [
        ("检测球头检棒长度补偿值", "L, length of the test bar", 120.0045),
        ("半径补偿值", "R, radius of its ball", 3.00183),
        ("A 轴回转中心与 C 轴回转中心在 y 方向上", "A to C, in Y", -0.006),
        ("回转中心矢量位置, x", "Trans X before MachAxis C", 0.014),
        ("回转中心矢量位置, y", "Trans Y before MachAxis C", -0.006),
        ("回转中心矢量位置, A, z", "Trans Z before MachAxis A", -49.982),
    ],
)
def test_what_source_001_enters_in_the_itnc_530(words, line, value, write, tmp_path):
    """Its section 6 lists these for a tilting table; the readings are of a machine that has them, by SciPy."""
    machine = replace(machines.load("ac_table"), tool_length=120.0)
    shifts = {"A": np.array([0, 0, 0.018]), "C": np.array([0.014, -0.006, 0])}
    real = Real(machine, shifts, {name: np.zeros(3) for name in "AC"})
    balls = files(real, tmp_path, np.random.default_rng(1), noise=1e-6, only=("ball",))
    found = calibrate(machine, [*balls, write(text(*BAR, method="bar", unit="mm"))])
    said = [each for each in handover.terms(found).splitlines() if each.strip().startswith(line)]
    assert len(said) == 1 and "±" in said[0], words
    assert float(said[0].removeprefix("  " + line).split()[0]) == pytest.approx(value, abs=1e-5)


@pytest.mark.parametrize(
    ("name", "said"),
    [
        (
            "ac_table",
            "LinuxCNC, xyzac-trt-kins: .*; NOT FOR THIS MACHINE: A and C turn the other way\\n",
        ),
        ("dmu50v", "^(?s:(?!trt-kins).)*LinuxCNC, other kinematics"),  # its B lies at 45°
    ],
)
def test_linuxcnc_is_told_only_what_its_module_can_hold(name, said):
    found = calibrate(machines.load(name), [machines.data_file("measurements/ball_c_axis.csv")])
    terms = handover.terms(found)
    assert re.search(said, terms) and ".x-rot-point" not in terms


def test_a_bar_has_the_uncertainty_of_its_touches(write):
    ball = machines.data_file("measurements/ball_c_axis.csv")
    found = calibrate(machines.load("ac_table"), [ball, write(text(*BAR, method="bar", unit="mm"))]).bar
    lengths, radii = np.array([0.004, 0.005]), np.array([3.001, 3.002, 3.0025])
    pooled = np.sqrt((np.ptp(lengths) ** 2 / 2 + ((radii - radii.mean()) ** 2).sum()) / 3)
    assert found["length"].freedom == 3 and found["length"].k == pytest.approx(3.1824, abs=1e-4)
    assert pytest.approx(3.1824 * pooled / np.sqrt(2), rel=1e-4) == found["length"].U
    assert pytest.approx(3.1824 * pooled / np.sqrt(3), rel=1e-4) == found["radius"].U


@pytest.mark.parametrize(
    ("rows", "message"),
    [
        (("face,at,shown", "+X,0,1"), "a face touched twice"),
        (("face,at,shown", "+X,0,1", "X,0,1"), "line 5, column 'face': expected the side"),
        (("face,at,shown", "-Z,0,1"), "line 4, column 'face': expected the side"),
        (("face,at", "+X,0"), "columns face, at, shown, found no 'shown'"),
        (BAR, "readings of an axis, and at most one test bar beside them"),
    ],
)
def test_bars_that_are_refused(rows, message, write):
    with pytest.raises(InputError, match=message):
        calibrate(machines.load("ac_table"), [write(text(*rows, method="bar", unit="mm"))])


@pytest.mark.parametrize("axis", [(0, 0, 1), (0, 0, -1)])
def test_the_tables_of_the_controls_take_the_error_out(axis, write):
    """Entries are the error of the axis as it is programmed, whichever way the table turns."""
    machine = machines.load("ac_table")
    machine = replace(machine, rotary=(machine.rotary[0], replace(machine.rotary[1], axis=axis)))
    rows = [UP_DOWN, *(f"{at},{at / 30},{at / 30},{at / 30},{at / 30}" for at in range(0, 360, 30))]
    slide = [UP_DOWN, *(f"{at},{at},{at},{at},{at}" for at in range(-4, 5))]
    tilt = [UP_DOWN, *(f"{at},1,1,1,1" for at in (-31, -11, 8, 30))]
    found = calibrate(
        machine,
        [
            write(text(*rows, **LASER)),
            write(text(*slide, **LASER | {"axis": "X", "unit": "µm"})),
            write(text(*tilt, **LASER | {"axis": "A"})),
        ],
    )
    tables, notes = handover.control_tables(found)
    assert sorted(tables) == ["fanuc_c.txt", "fanuc_x.txt", "siemens_a.ini", "siemens_c.ini", "siemens_x.ini"]
    assert "$AA_ENC_COMP[0,1,C]=0.000278" in tables["siemens_c.ini"]  # 1 second of arc at 30
    assert "$AA_ENC_COMP[0,8,X]=0.004000" in tables["siemens_x.ini"]
    assert "N10001P-1\n" in tables["fanuc_x.txt"]  # 1 µm too far at 1 mm: 1 µm less
    assert "no table for Fanuc, A: step: expected a travel with machine coordinate 0" in notes[0]
    assert any(note.startswith("Heidenhain: no file") for note in notes)


# What cannot be known is said


def test_what_the_readings_do_not_tell_is_listed():
    found = calibrate(machines.load("ac_table"), [machines.data_file("measurements/dial_circle.csv")])
    assert list(found.values) == ["EX0C", "EY0C", "EC0Y"]
    assert "not measured" in found.assumed["EY0A"] and "not measured" in found.assumed["EA0Z"]


def test_one_tool_length_does_not_tell_the_spindle_from_the_pivot(write):
    rows = ["40,500,0.0534", "-40,500,-0.03", "60,500,0.02", "-60,500,0.01"]
    path = write(text("angle,L,axial", *rows, method="tip", unit="mm", axis="B", positive="tip"))
    found = calibrate(machines.load("head_b_table_c"), [path])
    assert found.assumed["EB0S"].startswith(
        "these readings cannot separate EB0S from EX0B. Also take a tool 200 mm"
    )
    assert found["EX0B"].U > 0.01  # what the spindle may lean


# Files as people have them

DIAL = ["0,100,0.0423,x", "90,100,-0.0077,y", "180,100,-0.0182,z", "270,100,0.0318,w"]
SAID = {"method": "dial", "unit": "mm", "axis": "C", "positive": "out"}


def comma(rows, head):
    return "\n".join([head.replace(",", ";"), *(row.replace(",", ";").replace(".", ",") for row in rows)]) + "\n"


WITH_REMARKS = text("angle,R,dial,remark", *DIAL, **SAID)
MICROMETRES = ("0,100,42.3,", "90,100,-7.7,", "180,100,-18.2,", "270,100,31.8,")
DIVISIONS = ("0,100,21.15,", "90,100,-3.85,", "180,100,-9.1,", "270,100,15.9,")
ABROAD = ("0,10,0.0423", "1.5707963268,10,-0.0077", "3.1415926536,10,-0.0182", "4.7123889804,10,0.0318")
WORDS = ("0,100,0.0423", "-90,100,-0.0077", "-180,100,-0.0182", "-270,100,0.0318")


@pytest.mark.parametrize(
    ("content", "encoding"),
    [
        (WITH_REMARKS, "utf-8"),
        (WITH_REMARKS, "utf-8-sig"),
        (WITH_REMARKS, "utf-16"),
        (WITH_REMARKS.replace("\n", "\r\n"), "utf-8"),
        (text("角度,R,读数,备注", *DIAL, **SAID), "gbk"),
        (text("角度（度）,R,读数（mm）,备注", *DIAL, **SAID | {"unit": "µm"}), "gb18030"),
        (text(**SAID).strip() + "\n" + comma(DIAL, "Winkel,R,dial,Bemerkung"), "cp1252"),
        (text(**SAID).strip() + "\n" + comma(DIAL, "angle,R,dial,note").replace(";", "\t"), "utf-8"),
        (text("angle,R,dial (µm),remark", *MICROMETRES, **SAID), "cp1252"),
        (text("angle,R,dial,remark", *DIVISIONS, **SAID | {"unit": "0.002 mm"}), "utf-8"),
        (text("angle,R,dial,remark", *DIAL[::-1], DIAL[0].replace("0,", "360,", 1), **SAID), "utf-8"),
        (text("angle [rad],R (10 mm),dial", *ABROAD, **SAID), "utf-8"),
        (text("C,R,dial", *WORDS, **SAID), "utf-8"),
    ],
)
def test_the_same_readings_in_other_clothes(content, encoding, write):
    found = calibrate(machines.load("ac_table"), [write(content, encoding)])
    assert [found[name].value for name in ("EX0C", "EY0C")] == pytest.approx([-0.03025, 0.01975], abs=1e-9)


def test_a_stated_sigma_is_in_the_unit_of_the_readings(write):
    path = write(text("angle,R,dial (µm),remark", *MICROMETRES, **SAID, sigma=0.5))
    assert calibrate(machines.load("ac_table"), [path]).noise[str(path)] == (pytest.approx(0.5e-3), np.inf)


FOUR = ("angle,R,dial", "0,100,4.23")
THREE = ("angle,R,dial", "0,100,0.1", "90,100,0.1")


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (
            text(*FOUR, method="dial", axis="C", positive="out"),
            "line 5, column 'dial': expected its unit, in a line such as # unit = µm: one of",
        ),
        (text(*FOUR, **SAID | {"unit": "divisions"}), "of a dial's division, # unit = 0.002 mm, found 'divisions'"),
        (text("angle,R,dial", "0,100,0.01", **SAID | {"unit": "arcsec"}), "found 'arcsec'"),
        (
            text("angle,R,dial", "0,100,42", **SAID),
            "column 'dial': expected a reading within ±5 mm (other units?), found 42",
        ),
        (
            text(*FOUR, method="dial", unit="mm", axis="C"),
            "line 4: expected a line # positive = out or in, found none",
        ),
        (text("angle,R,dial", "0,100,0.1", **SAID | {"method": "dail"}), "a line # method = one of ball"),
        (text(*FOUR, method="dial", unit="mm", positive="out"), "expected a line # axis = A or C"),
        (text("angle,dial", "0,0.1", **SAID), "a column R"),
        (
            text("angle,R,dial,ex", "0,100,0.1,0", **SAID),
            "such as z, length, setup (remark, if",
        ),
        (text("angle;R;dial", "0;100;0,1", "90;100;0.1", **SAID), "line 6, column 'dial': expected a number"),
        (text("angle,R,dial", "0,100,1", "1.5708,100,1", **SAID), "look like radians"),
        (text(*THREE, "180,100,0.2", **SAID), "readings than unknowns, or a line # sigma"),
        (text("angle,R,dial,torque", "0,100,0.1,20", **SAID), "found 'torque'"),
        (
            text(f"{UP_DOWN},dial", "0,0,0,0,0,0", **LASER),
            "such as reading, forth, back (remark, if",
        ),
        (
            text("face,at,shown,dial", "+X,0,1,0", method="bar", unit="mm"),
            "no readings), found 'dial'",
        ),
        (text("x,y,z,ex", "0,0,0,0.1", method="ball", unit="mm"), "the rotary angles under their axes' names"),
        (text("C,ex", "0,0.1", method="ball", unit="mm"), "columns x, y, z of the ball"),
        (
            text("C,x,y,z,bar", "0,9,0,0,0", "0,1,2,3,0", method="ballbar", unit="mm", centre="1 2 3"),
            "line 4, x y z minus centre: expected a vector with a direction",
        ),
        (text("C,x,y,z", "0,0,0,0", method="ball", unit="mm"), "columns of readings: ex, ey, ez"),
        (text(UP_DOWN, "0,0,0,0,0", "90,0.001,0,0,0", **LASER | {"unit": "mm"}), "found 'mm'"),
        (text(UP_DOWN, "0,0,0,0,0", "90,0.001,0,0,0", method="laser", axis="C"), "expected its unit"),
        (
            text(UP_DOWN, "0,0,0,0,0", "90,90.001,90,90,90", **LASER | {"unit": "deg"}),
            "actual minus target, no positions",
        ),
        (text("position,up1,down1", "0,0,0", "90,1,1", **LASER), "expected two runs, or a line # sigma"),
        (text("position,up1,down1", "0,0,0", "90,1,1", **LASER, sigma=-1), "a line # sigma = a number above 0"),
        (text("position,reading", "0,0", "0,1", **LASER, sigma=1), "at least 2 targets, found 1"),
        (text(UP_DOWN, "0,0,0,0,0", **LASER), "at least 2 targets, found 1"),
        (text("position,up1,down1", "0,0,0", "280,1,1", **LASER, sigma=1), "at least 3 targets, found 2"),
        (text("position,up1", "0,0", **LASER | {"axis": "B"}), "a line # axis = X or Y or Z or A or C, found 'B'"),
        (text("position,up1,up2", "0,0,0", "90,9000,9000", **LASER), "a deviation below 1° or 5 mm"),
        (b"\xff\xfe\x00", "text in UTF-8 or GBK"),
    ],
)
def test_what_is_unclear_is_asked_for_with_the_line(content, message, write):
    path = write(content)
    with pytest.raises(InputError) as error:
        calibrate(machines.load("ac_table"), [path])
    assert str(path) in str(error.value) and message in str(error.value)


def test_words_that_nobody_knows_are_refused():
    machine, path = machines.load("ac_table"), machines.data_file("measurements/ball_c_axis.csv")
    with pytest.raises(InputError, match="sigam: expected settings among unit, method"):
        calibrate(machine, [path], sigam=0.001)
    with pytest.raises(InputError, match="unknowns among .*, found 'XOC'"):
        moved(machine, {"XOC": 0.01})


@pytest.mark.parametrize(("head", "axis"), [("C,R,dial", {}), ("angle,R,dial", {"axis": "C"})])
def test_a_dial_on_a_ring_needs_a_table(head, axis, write):
    path = write(text(head, "0,100,0", "90,100,0.1", method="dial", unit="mm", positive="out", **axis))
    with pytest.raises(InputError, match="an axis that carries the workpiece, found C"):
        calibrate(machines.load("ac_head"), [path])


def test_a_laser_in_degrees_is_not_nothing(write):
    rows = [UP_DOWN, *(f"{at},{e},{e},{e},{e}" for at, e in ((0, 0), (90, 0.0012), (180, 0.0025), (270, -0.0008)))]
    found = calibrate(machines.load("ac_table"), [write(text(*rows, **LASER | {"unit": "deg"}))])
    assert np.ptp(found.positioning[0].value) / ARCSECOND == pytest.approx(0.0033 * 3600)


def test_an_axis_is_positioned_by_one_file(write):
    path = write(text("position,up1,up2", "0,0,0", "90,1,1", "180,2,2", **LASER))
    with pytest.raises(InputError, match="one file of positioning for each axis"):
        calibrate(machines.load("ac_table"), [path, path])


def test_runs_one_after_the_other_forth_and_back(write):
    """Rows as they were taken: up to 360 and back, twice; 360 is 0; each direction for itself."""
    there = [0, 90, 180, 270, 360]
    error = {0: 1.0, 90: 2.0, 180: -1.0, 270: 0.5, 360: 1.0}
    rows = ["position,reading", f"-10,{0}"]
    for run in range(2):
        rows += [f"{at},{error[at] + 0.4 + 0.02 * run}" for at in there]
        rows += [f"{at},{error[at] - 0.4 + 0.02 * run}" for at in there[::-1][1:]]
        rows += ["-10,0"]
    with pytest.raises(InputError, match="degrees within"):
        calibrate(machines.load("ac_table"), [write(text("position,reading", "0,1", "3600,1", **LASER))])
    found = calibrate(machines.load("ac_table"), [write(text(*rows, **LASER))]).positioning[0]
    assert found.endless and found.at[:4].tolist() == [0, 90, 180, 270]
    assert found.reversal / ARCSECOND == pytest.approx(0.8, abs=0.05)
    assert found.value[1] / ARCSECOND == pytest.approx(2.01, abs=1e-6)


@pytest.mark.parametrize(
    "head", ["position,forth,back", "角度,去程,回程", "C,forward,Backward", "target,up1,down1"]
)
def test_forth_and_back(head, write):
    rows = [head, "0,1.4,0.6", "90,2.4,1.6", "180,-0.6,-1.4", "270,0.9,0.1"]
    found = calibrate(machines.load("ac_table"), [write(text(*rows, **LASER, sigma=0.1))]).positioning[0]
    assert found.value / ARCSECOND == pytest.approx([1, 2, -1, 0.5])
    assert found.reversal / ARCSECOND == pytest.approx(0.8) and found.sigma / ARCSECOND == pytest.approx(
        0.1 / 2**0.5
    )


@pytest.mark.parametrize("method", readings.METHODS)
@pytest.mark.parametrize("arrangement", ["table", "mixed", "head"])
def test_every_template_is_read(method, arrangement, write):
    machine = nominal(arrangement)
    if (method, arrangement) in {("dial", "head"), ("tip", "table")}:
        with pytest.raises(InputError, match="an axis that carries"):
            readings.read(write(readings.template(method, machine)), machine)
        return
    assert readings.read(write(readings.template(method, machine)), machine)
