"""The whole way: every machine, every strategy and way, any random path; the shell; nothing written on error."""

import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from mathpost import load_machine, postprocess
from mathpost.errors import InputError, MathpostError, ReachError
from mathpost.interface.shell.main import main
from mathpost.kinematics import Kinematics
from mathpost.path import cl as cldata
from mathpost.path.deviation import deviation
from mathpost.shop.controls import control, reader
from mathpost.shop.controls.writer import MOTION_ONLY
from mathpost.shop.post.ways import Crossing
from tests.conftest import DATA, FIVE_AXES, ROOT
from tests.machines import machines
from tests.post.sampled import sampled_errors

BLADE, DMU = str(DATA / "cl/blade.cl"), str(DATA / "machines/dmu50v.toml")


@pytest.fixture(scope="session")
def twisted():
    """The whole blade."""
    return cldata.read(DATA / "cl/twisted_blade.cl")


@pytest.mark.parametrize("dialect", control.names())
@pytest.mark.parametrize("tcp", [False, True])
def test_the_blade(dmu50v, blade, dialect, tcp):
    result = postprocess(blade, dmu50v.machine, dialect=dialect, tcp=tcp)
    assert result.joints.shape == (5, 5)
    np.testing.assert_array_equal(
        np.degrees(result.joints[:, 3:]).round(3)[[0, 4]], [[11.817, 175.815], [22.691, -8.075]]
    )
    assert result.report.tip_error < 2e-4 and result.report.axis_error < 2e-4
    assert result.report.path_tip_error <= 0.01 and result.report.path_axis_error <= 0.1
    assert len(result.blocks.words) == (7 if tcp else pytest.approx(121, abs=20))


@pytest.mark.parametrize("name", ["dmu50v", "ac_table", "head_b_table_c"])
@pytest.mark.parametrize("strategy", ["optimal", "shortest"])
def test_a_whole_blade(twisted, name, strategy):
    data = load_machine(DATA / f"machines/{name}.toml")
    assert len(twisted) >= 5000
    result = postprocess(twisted, data, strategy=strategy)
    assert result.report.path_tip_error <= 0.01 and result.report.path_axis_error <= 0.1
    joints, place = result.blocks.joints[:2000], result.place[:2000]
    tip, axis = sampled_errors(Kinematics(data), twisted, joints, place, np.ones(1999, bool), 40)
    assert tip <= 0.01 and axis <= 0.1


MACHINES = ["dmu50v", "ac_table", "bc_table", "head_b_table_c", "ac_head", "nutating_head", "nutating_head_table"]
NEEDED = {"linear": 2.65, "cubic": 1.6, "aside": 1.01}  # degrees, for the five records


@pytest.mark.parametrize("singular", Crossing.SAFE)
@pytest.mark.parametrize("name", MACHINES)
def test_every_way_on_every_machine_keeps_both_tolerances_or_is_refused(blade, name, singular):
    """By a sampling ten times denser than the one that built it, and that shares nothing with it."""
    kin = Kinematics(load_machine(DATA / f"machines/{name}.toml"))
    for granted in (0.1, NEEDED.get(singular, 0.02)):
        try:
            result = postprocess(blade, kin.machine, singular=singular, axis_tolerance=np.radians(granted))
        except ReachError as error:
            reason = "needs an axis tolerance|on its great circle|is outside|no side to move it|different branch"
            assert granted == 0.1 or singular in ("other branch", "aside"), error
            assert re.search(reason, str(error))
            continue
        joints, place = result.blocks.joints, result.place
        lifted = np.linalg.norm(kin.forward(joints)[0] - blade.at(place)[0], axis=1) > 1
        cut = ~(lifted[:-1] | lifted[1:])
        tip, axis = sampled_errors(kin, blade, joints, place, cut, 641)
        assert tip <= result.report.path_tip_error <= 0.01
        assert axis <= result.report.path_axis_error <= granted


@pytest.mark.parametrize(
    ("singular", "needed"), [("linear", 0.8), ("cubic", 0.5), ("aside", 1.01), ("retract", 0.1)]
)
def test_ways_through_the_whole_blade(dmu50v, twisted, singular, needed):
    part = twisted.part(700, 2000)
    result = postprocess(part, dmu50v.machine, singular=singular, axis_tolerance=np.radians(needed))
    assert result.report.path_tip_error <= 0.01
    assert result.report.path_axis_error < needed
    assert (result.report.axis_error < 2e-4) == (singular == "retract")
    if singular != "retract":
        with pytest.raises(
            ReachError, match=rf"no way '{singular}' from record \d+ to \d+: it needs an axis toler"
        ):
            postprocess(part, dmu50v.machine, singular=singular)


def test_where_the_great_circle_meets_the_pole_the_workpiece_side_axis_turns_in_place(dmu50v, blade):
    for tcp in (False, True):
        result = postprocess(blade, dmu50v.machine, tcp=tcp, axis_tolerance=np.radians(0.01))
        swinging = np.abs(np.diff(result.blocks.words[:, 4])) > (10 if tcp else 0.9)
        _, axis = dmu50v.forward(result.blocks.joints)
        still = axis[1:][swinging] - axis[:-1][swinging]
        assert np.abs(np.diff(result.blocks.words[:, 4]))[swinging].sum() > 165
        assert np.degrees(np.linalg.norm(still, axis=1).sum()) < 0.003


def test_the_branch_changes_nowhere_but_at_the_pole(dmu50v_both_ways, twisted, blade):
    """The other branch has to come back behind the region; and 0.3° beside the pole there is no way to it."""
    strays = r"lags by .*° on its great circle, more than 0.*°, however often"
    with pytest.raises(ReachError, match=f"line 5, record 4: .*{strays}"):
        postprocess(blade, dmu50v_both_ways.machine, strategy="paper", singular="other branch")
    trunnion = load_machine(DATA / "machines/ac_table.toml")
    with pytest.raises(ReachError, match=f"no way 'other branch' from record 833 to 857: .*{strays}"):
        postprocess(twisted.part(820, 870), trunnion, singular="other branch")
    with pytest.raises(ReachError, match=strays):
        postprocess(twisted.part(820, 870), trunnion, strategy="paper")


def test_rapid_moves_that_swing_the_tool_axis_are_named(dmu50v, blade):
    rapid = replace(blade, rapid=np.array([False, False, True, False, False]))
    (warning,) = (each for each in postprocess(rapid, dmu50v.machine).report.warnings if "rapid" in each)
    assert warning == "rapid moves take the tool axis up to 2.5° off its great circle"
    assert not [each for each in postprocess(blade, dmu50v.machine).report.warnings if "rapid" in each]


def test_splitting_lifts_unwinds_and_returns(twisted):
    data = load_machine(DATA / "machines/nutating_head.toml")
    with pytest.raises(ReachError, match="breaks"):
        postprocess(twisted, data)
    result = postprocess(twisted, data, split=True, clearance=30)
    assert "before record" in result.report.settings["splits"]
    assert result.report.path_tip_error <= 0.01 and result.report.tip_error < 1e-3
    assert result.report.path_axis_error < 0.1
    assert np.degrees(np.abs(result.blocks.joints[:, 3]).max()) <= 370 + 1e-6
    lifted = result.blocks.rapid  # the CL data have no rapid move
    assert lifted.any() and not lifted.all()


def test_inverse_time_without_tcp_only(dmu50v, twisted):
    part = twisted.part(0, 50)
    without = postprocess(part, dmu50v.machine, dialect="fanuc")
    assert "G93" in without.program and (~np.isnan(without.blocks.seconds)).sum() > 40
    # No axis is asked to go faster than it can, and no move faster than the feed.
    rates = np.abs(np.diff(without.blocks.joints, axis=0)) / without.blocks.seconds[1:, None]
    assert (rates <= dmu50v.machine.max_rates * 1.02).all()
    with_tcp = postprocess(part, dmu50v.machine, dialect="fanuc", tcp=True)
    assert "G43.4" in with_tcp.program and "G93" not in with_tcp.program and "F1500" in with_tcp.program


def test_remarks_become_comments(dmu50v):
    cl = cldata.parse("SPINDL/3000,RPM,CLW\nGOTO/1,2,3,0,0,1\nCOOLNT/ON\nGOTO/2,2,3,0.1,0,0.994987\nFINI\n")
    lines = postprocess(cl, dmu50v.machine).program.splitlines()
    kinds = [re.sub(r"^\d+ ", "", line).split()[0] for line in lines]
    assert kinds[:6] == ["BEGIN", ";", "TOOL", "M3", "L", "M8"] and kinds[-2:] == ["L", "END"]


def test_tool_length_and_origin_matter(blade):
    data = load_machine(DATA / "machines/nutating_head.toml")
    base = postprocess(blade, data).blocks.words
    for change in ({"tool_length": 131.0}, {"origin": (0, 0, 1)}):
        other = postprocess(blade, data.with_setup(**change)).blocks.words
        moved = np.abs(other[0] - base[0])
        assert moved[3:].max() == 0
        assert (moved[:3].max() > 0.01) == ("tool_length" in change)


@settings(max_examples=20, deadline=None, suppress_health_check=list(HealthCheck))
@given(
    any_machine=machines(),
    seed=st.integers(0, 10**6),
    step=st.sampled_from([0.003, 0.1, 1.0]),
    tcp=st.booleans(),
    singular=st.sampled_from(["direct", "other branch", "linear", "cubic", "aside"]),
    granted=st.sampled_from([0.02, 0.1, 3]),
    rapid=st.sampled_from([0, 0.3]),
)
def test_any_machine_any_path(any_machine, seed, step, tcp, singular, granted, rapid):
    """The verified program reproduces the CL data within its stated error, or a clear error is raised."""
    kin, rng = Kinematics(any_machine), np.random.default_rng(seed)
    joints = np.cumsum(rng.normal(size=(8, 5)) * [5, 5, 5, step, step], axis=0)
    joints[:, 3:] += rng.uniform(-3, 3, 2)
    cl = replace(cldata.from_arrays(*kin.forward(joints), feed=1000), rapid=rng.random(8) < rapid)
    dialect = control.names()[seed % 3]
    try:
        options = {"tolerance": 0.02, "axis_tolerance": np.radians(granted), "singular": singular}
        result = postprocess(cl, any_machine, dialect=dialect, tcp=tcp, **options)
    except MathpostError as error:
        assert len(str(error)) > 20
        return
    blocks = reader.read(result.program, any_machine, dialect)
    tip, axis = kin.forward(blocks.joints)
    tip = blocks.words[:, :3] if tcp else tip
    at_record = result.place % 1 == 0
    tips, axes = cl.at(result.place[at_record])
    assert np.linalg.norm(tip[at_record] - tips, axis=1).max() <= result.report.tip_error + 1e-12
    assert np.degrees(np.linalg.norm(axis[at_record] - axes, axis=1).max()) <= result.report.axis_error + 1e-9
    assert result.report.path_tip_error <= 0.02 and result.report.path_axis_error <= granted
    if not tcp:
        place = result.place.round(9)
        tips, _ = cl.at(place)
        between = cl.axes[np.floor(place[:-1]).astype(int)], cl.axes[np.ceil(place[1:]).astype(int)]
        ends = {"tips": (tips[:-1], tips[1:]), "axes": between}  # the whole arc, wherever on it the blocks are
        tip, axis = deviation(kin, blocks.joints[:-1], blocks.joints[1:], **ends, least=512)
        known = ~blocks.rapid[1:] | control.load(dialect).rapid_interpolated  # moves whose way is known
        assert tip[known].max(initial=0) <= result.report.path_tip_error + 1e-12
        at_feed = ~cl.rapid[np.ceil(result.place[1:]).astype(int)]
        assert np.degrees(axis[at_feed].max(initial=0)) <= result.report.path_axis_error + 1e-9


@pytest.mark.parametrize(
    "change",
    [
        {"dialect": "mazatrol"},
        {"singular": "paper cubic"},
        {"tolerance": 0},
        {"tolerance": np.inf},
        {"tolerance": 1e-6},
        {"axis_tolerance": 0},
        {"axis_tolerance": np.nan},
        {"axis_tolerance": 1e-6},
        {"strategy": "?"},
        {"cone": 0},
        {"cone": np.nan},
    ],
)
def test_wrong_options(dmu50v, blade, change):
    with pytest.raises(InputError, match=next(iter(change))):
        postprocess(blade, dmu50v.machine, **change)


def test_an_option_that_nobody_knows(dmu50v, blade):
    with pytest.raises(InputError, match="dialect, tcp, .*found workers"):
        postprocess(blade, dmu50v.machine, workers=2)


def test_stages_and_what_is_compared(dmu50v, blade):
    stages = ["choosing", "planning", "writing", "reading back", "proving"]
    seen = []
    report = postprocess(blade, dmu50v.machine, progress=seen.append).report
    assert seen == stages and report.strategies == () and report.ways == {}
    seen.clear()
    report = postprocess(blade, dmu50v.machine, progress=seen.append, compare=True).report
    assert seen == [*stages, "comparing"] and list(report.ways) == [(1, 2)]
    assert [row[0] for row in report.strategies] == ["optimal", "shortest", "paper"]
    assert "paper clamped" in str(report)


def test_records_that_repeat_the_one_before(dmu50v):
    remark = "PPRINT/HERE IT WAITS\n"
    first, second, third = (f"GOTO/{x},2,3,0,0,1\n" for x in (1, 4, 5))
    cl = cldata.parse("FEDRAT/500\n" + first + remark + second * 30 + third + remark)
    lines = postprocess(cl, dmu50v.machine).program.splitlines()
    assert [line.split()[1] for line in lines[2:-1]] == ["L", ";", "L", "L", ";"]
    assert postprocess(cl.part(0, 1), dmu50v.machine).report.worst_record == 1
    assert postprocess(cl.part(0, 1), dmu50v.machine, tcp=True).report.path_tip_error == 0


def test_a_way_that_is_not_possible_is_named_with_its_records(dmu50v, blade):
    with pytest.raises(ReachError, match=r"no way 'cubic' from record 2 to 3: a spline needs a record"):
        postprocess(blade.part(0, 3), dmu50v.machine, singular="cubic")


def test_without_a_cone_the_feed_decides(dmu50v, twisted):
    part = twisted.part(0, 300)
    silent = replace(part, feeds=np.full(300, np.nan))
    with pytest.raises(InputError, match="cone"):
        postprocess(silent, dmu50v.machine, cone=None)
    half = replace(part, feeds=np.where(np.arange(300) < 150, np.nan, part.feeds))
    # The first move with a feed goes to record 151; what no feed asks for is no region.
    assert postprocess(half, dmu50v.machine, cone=None).report.settings["singular"].startswith("records 150–")
    quick = replace(part, feeds=1e4 * part.feeds)
    assert postprocess(quick, dmu50v.machine, cone=None).report.settings["singular"].startswith("records 1–300")


class TestShell:
    """``python -m mathpost post …``."""

    def test_program_and_report(self, tmp_path, capsys):
        path = tmp_path / "blade.h"
        assert main(["post", BLADE, "--machine", DMU, "--compare", "-o", str(path)]) == 0
        assert path.read_text(encoding="utf-8").startswith(
            f"0 BEGIN PGM BLADE MM\n1 ; {MOTION_ONLY}\n2 L X-36.7809"
        )
        report = capsys.readouterr()
        assert report.out == "" and "tip error" in report.err and "paper cubic" in report.err
        assert [file.name for file in tmp_path.iterdir()] == ["blade.h"]

    def test_all_options(self, capsys):
        options = "--dialect siemens --tcp --tolerance 0.02 --selection shortest --singular cubic --tool-length 50"
        options += " --axis-tolerance 1.6"
        status = main(["post", BLADE, "--machine", DMU, *options.split(), "--origin", "-10,0,5"])
        assert status == 0 and "TRAORI" in capsys.readouterr().out

    @pytest.mark.parametrize(
        ("cl", "words"),
        [
            ("", "at least one GOTO"),
            ("GOTO/1,2,3,0,1", "line 1"),
            ("GOTO/1,2,3,0,0,0", "line 1"),
            ("GOTO/1,2,nan", "line 1"),
            ("GOTO/1,2,3\nGOTO/9999,0,0", "line 2, record 2"),
            ("GOTO/1,2,3,0,0,-1", "out of reach"),
        ],
    )
    def test_bad_cl_data_writes_nothing(self, tmp_path, capsys, cl, words):
        file, out = tmp_path / "part.cl", tmp_path / "out.h"
        file.write_text(cl, encoding="utf-8")
        assert main(["post", str(file), "--machine", DMU, "-o", str(out)]) == 2
        assert words in capsys.readouterr().err and not out.exists()

    def test_bad_places(self, tmp_path, capsys):
        assert main(["post", BLADE, "--machine", DMU, "-o", str(tmp_path / "none" / "out.h")]) == 2
        assert "not written" in capsys.readouterr().err
        assert main(["post", BLADE, "--machine", str(tmp_path / "m.toml")]) == 2
        assert "m.toml" in capsys.readouterr().err
        assert main(["post", BLADE, "--machine", DMU, "--tool-length", "-1"]) == 2

    def test_an_existing_program_survives_an_error(self, tmp_path):
        out, file = tmp_path / "out.h", tmp_path / "part.cl"
        out.write_text("old")
        file.write_text("GOTO/1")
        assert main(["post", str(file), "--machine", DMU, "-o", str(out)]) == 2
        assert out.read_text(encoding="utf-8") == "old"


def test_the_blade_is_what_its_script_makes():
    namespace = {"__name__": "make", "__file__": str(ROOT / "data/cl/make_twisted_blade.py")}
    exec((ROOT / "data/cl/make_twisted_blade.py").read_text(encoding="utf-8"), namespace)
    made, stored = namespace["make"](), cldata.read(DATA / "cl/twisted_blade.cl")
    np.testing.assert_allclose(stored.points, made.points, atol=1e-6)
    np.testing.assert_allclose(stored.axes, made.axes, atol=1e-8)


@pytest.mark.parametrize("name", [path.stem for path in FIVE_AXES])
def test_a_calibration_of_micrometres_keeps_the_branch(name, blade, of):
    """15 µm and 30 µrad in both rotary axes: the joints move a little, none of them to the other solution."""
    nominal = load_machine(name)
    if name == "dmu50v":  # the blade passes its pole, where the travel of B ends: a little beyond must be allowed
        tilting = replace(nominal.rotary[0], limits=(-0.01, np.pi))
        nominal = replace(nominal, rotary=(tilting, nominal.rotary[1]))
    before = postprocess(blade, nominal).joints
    for seed in range(of(1, 4)):
        rng = np.random.default_rng(seed)
        moved = [
            replace(
                joint,
                point=tuple(np.add(joint.point, rng.normal(scale=0.015, size=3))),
                axis=tuple(np.add(joint.axis, rng.normal(scale=30e-6, size=3))),
            )
            for joint in nominal.rotary
        ]
        turned = (before - postprocess(blade, replace(nominal, rotary=tuple(moved))).joints)[:, 3:]
        assert np.degrees(np.abs(turned - 2 * np.pi * np.rint(turned / (2 * np.pi)))).max() < 0.5


@pytest.mark.parametrize("dialect", control.names())
@pytest.mark.parametrize("tcp", [False, True])
def test_the_report_times_what_is_written(dmu50v, blade, dialect, tcp):
    """Lifts of 20 mm are rapid on every control, as the tool is clear in every order of the axes."""
    blade = replace(blade, feeds=np.full(len(blade), 900.0))
    result = postprocess(blade, dmu50v.machine, dialect=dialect, tcp=tcp, singular="retract")
    rapid = np.flatnonzero(result.blocks.rapid)
    assert len(rapid) > 3 and (np.diff(rapid) == 1).all()
    words, seconds = result.blocks.words, 0.0
    for start, end, stated in zip(words, words[1:], result.blocks.seconds[1:], strict=False):
        rates = np.degrees(dmu50v.machine.max_rates[3:])
        seconds += max(np.max(np.abs(end - start)[3:] / rates), np.nan_to_num(stated))
    assert seconds <= result.report.time + 1e-6


@pytest.mark.parametrize("head", [["G20"], ["G91"], ["G54", "G91 G28 Z0"], ["g20"]])
def test_a_head_that_makes_positions_mean_something_else_is_refused(dmu50v, blade, head):
    data = replace(dmu50v.machine, program_head=tuple(head))
    with pytest.raises(MathpostError, match="off the CL path|word before or in the first move|incremental"):
        postprocess(blade, data, dialect="fanuc")


def test_a_tool_change_that_ends_in_rapid_traverse_is_not_gone_on_with(dmu50v):
    cl = cldata.parse("FEDRAT/500\nGOTO/0,0,0\nGOTO/9,0,0\nLOADTL/4\nGOTO/9,0,0\nGOTO/0,5,0\n")
    data = replace(dmu50v.machine, tool_change=("G0 G53 Z190.", "T{tool} M6"))
    text = postprocess(cl, data, dialect="fanuc").program
    after = text[text.index("T4 M6") :].splitlines()[1]
    assert " G1 " in after and " X9" in after


def test_a_rate_that_is_not_known_is_said(dmu50v):
    slides = tuple(replace(axis, max_rate=None) if axis.name == "Z" else axis for axis in dmu50v.machine.linear)
    cl = cldata.parse("RAPID\nGOTO/0,0,100\nFEDRAT/500\nGOTO/0,0,0\nRAPID\nGOTO/0,0,100\n")
    said = str(postprocess(cl, replace(dmu50v.machine, linear=slides)).report)
    assert "Z not known" in said and "at least" in said


def test_the_path_holds_the_records(dmu50v, blade):
    for tcp in (False, True):
        found = postprocess(blade, dmu50v.machine, tcp=tcp).report
        assert found.path_tip_error >= found.tip_error and found.path_axis_error >= found.axis_error


@pytest.mark.parametrize("name", ["ac_head", "head_b_table_c", "ac_table"])
def test_a_program_says_what_the_control_has_to_hold(name, blade):
    """Pivots, work offset and tool length with TCP; without it the length that a head's words rest on."""
    data = load_machine(name).with_setup(tool_length=101.5, origin=(1, 2, 3))
    text = postprocess(blade, data, dialect="fanuc", tcp=True).program
    for joint in data.rotary:
        assert f"CONTROL HOLDS: {joint.name} THROUGH " in text
    assert "CONTROL HOLDS: WORK OFFSET X1 Y2 Z3" in text and "101.5 MM FROM NOSE TO TIP, IN THE TOOL TABLE" in text
    free = postprocess(blade, data, dialect="linuxcnc", tcp=True).program
    assert "101.5 MM FROM NOSE TO TIP, IN G54 AND THE KINEMATICS, 0 IN THE TOOL TABLE" in free
    result = postprocess(blade, data, dialect="fanuc")
    heads = any(joint.carries == "tool" for joint in data.rotary)
    assert ("101.5 MM FROM NOSE TO TIP" in result.program) == heads
    assert result.report.settings["tool length"] == "101.5 mm (machine file)"
    assert "…" in result.report.settings["rotary"]
