"""Off the part: unwinding and approach go by the safe position of the machine, the body stays clear."""

import re
from dataclasses import replace

import numpy as np
import pytest

from mathpost import load_machine, postprocess
from mathpost.errors import InputError, MathpostError
from mathpost.kinematics import Kinematics
from mathpost.path import cl as cldata
from mathpost.shop.controls import control
from mathpost.shop.post.proof import joints_of

HALF = np.radians(60)  # half angle of a cone with its apex at the origin, pointing up
MACHINES = ["ac_table", "bc_table", "head_b_table_c", "ac_head", "nutating_head"]
DIALECTS = ["heidenhain", "fanuc", "siemens"]


def round_the_cone(turns=1.5, count=80):
    """A path round the cone, the tool square to it."""
    t, radius = np.linspace(0, turns * 2 * np.pi, count), np.linspace(40, 30, count)
    points = np.stack([radius * np.cos(t), radius * np.sin(t), -radius / np.tan(HALF)], axis=1)
    axes = np.stack([np.cos(t) * np.cos(HALF), np.sin(t) * np.cos(HALF), np.full(count, np.sin(HALF))], axis=1)
    return cldata.from_arrays(points, axes, feed=1000, name="cone")


def with_c_to_200(name):
    """A machine whose C must unwind."""
    data = load_machine(name)
    limits = (-np.radians(200), np.radians(200))
    rotary = tuple(replace(joint, limits=limits) if joint.name == "C" else joint for joint in data.rotary)
    return replace(data, rotary=rotary)


def depth_in_the_cone(points):
    """How far points (..., 3) are inside the cone, mm, by plain geometry."""
    radius = np.linalg.norm(points[..., :2], axis=-1)
    return -(radius * np.cos(HALF) + points[..., 2] * np.sin(HALF))


@pytest.mark.parametrize("tcp", [False, True])
@pytest.mark.parametrize(("name", "dialect"), [(name, DIALECTS[n % 3]) for n, name in enumerate(MACHINES)])
def test_the_tool_unwinds_clear_of_the_cone(name, dialect, tcp):
    data = with_c_to_200(name)
    result = postprocess(round_the_cone(), data, dialect=dialect, tcp=tcp, split=True)
    assert "before record" in result.report.settings["splits"]
    kin, blocks = Kinematics(data), result.blocks
    joints, tips = joints_of(kin, blocks), []
    for start, end, with_tcp in zip(joints, joints[1:], blocks.tcp[1:], strict=False):
        t = np.linspace(0, 1, 60)[:, None]
        tip, axis = kin.forward(start + t * (end - start))
        if with_tcp:
            tip = tip[0] + t * (tip[-1] - tip[0])
        tips.append(tip)
        body = tip[:, None] + np.linspace(0, 60, 13)[:, None] * axis[:, None]
        assert depth_in_the_cone(body).max() < 0.05, (start, end)  # chords of the CL data are 0.04 mm deep
    away = [np.linalg.norm(tip, axis=1).min() for tip in tips]
    turns = np.abs(np.diff(joints[:, 3:], axis=0)).max(axis=1)
    assert away[int(turns.argmax())] > 100  # the great turn is made far from the part


def test_without_a_safe_position_no_path_is_split():
    data = replace(with_c_to_200("ac_table"), safe=None)
    with pytest.raises(InputError, match=r"record 41: to unwind: expected safe = \{ Z = … \} in \[linear\]"):
        postprocess(round_the_cone(), data, split=True)


def test_a_safe_position_beside_the_part_is_refused():
    data = replace(with_c_to_200("ac_table"), safe=(None, None, 100.0))  # of the slide: the tool is 120 mm long
    with pytest.raises(
        MathpostError, match="to a safe position, the tool's body, 10 mm across, meets what the path cuts"
    ):
        postprocess(round_the_cone(), data, split=True)


TWO_TOOLS = """LOAD/TOOL,3,LENGTH,95
SPINDL/RPM,8000,CLW
FEDRAT/500,MMPM
GOTO/0,0,0,0,0,1
GOTO/10,0,0,0.1,0,0.994987
LOAD/TOOL,5,LENGTH,120
GOTO/0,5,0,0,0.2,0.979796
GOTO/10,5,0,0,0.2,0.979796
"""


@pytest.mark.parametrize("tcp", [False, True])
@pytest.mark.parametrize("dialect", DIALECTS)
@pytest.mark.parametrize("name", MACHINES)
def test_an_approach_goes_down_last_and_onto_the_part_at_its_feed(name, dialect, tcp):
    """Z of the machine, the rotary axes, X Y, then down to the lifted pose, and at the feed of the cut onto it."""
    data = replace(load_machine(name), program_foot=("M9",))
    result = postprocess(cldata.parse(TWO_TOOLS), data, dialect=dialect, tcp=tcp)
    lines, (safe,) = result.program.splitlines(), control.load(dialect).lines("safe", data.safe[2])
    starts = [row for row, line in enumerate(lines) if line.endswith(safe)]
    assert len(starts) == 3  # before the first tool, and behind the change of each
    changes = [
        row for row, line in enumerate(lines) if re.search(r" (T[357]\b(?!\.)|TOOL CALL)", line) and ";" not in line
    ]
    assert starts[0] < changes[0] < starts[1] < changes[-1] < starts[2]
    for row in starts[1:]:
        words = [re.findall(r" ([XYZABC])[-+=\d]", line) for line in lines[row + 1 : row + 9]]
        turn, over = [each for each in words if each][:2]
        assert set(turn) == {joint.name for joint in data.rotary} and set(over) == {*"XYZ"}
    blocks = result.blocks
    for row, length in ((0, 95), (-1, 120)):  # the ends of the program, without TCP
        slides = data.with_setup(tool_length=length).slides
        assert not blocks.tcp[row] and blocks.words[row, 2] + slides[2] == pytest.approx(data.safe[2], abs=1e-4)
    first_on_part = int(np.flatnonzero(result.place == 0)[2])
    assert not blocks.rapid[first_on_part] and blocks.rapid[first_on_part - 2]
    assert result.report.tip_error < 1e-3


@pytest.mark.parametrize("tcp", [False, True])
@pytest.mark.parametrize("dialect", control.names())
def test_the_rotary_axes_stand_where_they_are_while_a_tool_is_changed(dialect, tcp):
    """Nothing asks for more; behind the change they turn at the safe height, straight to the next position."""
    setup = replace(load_machine("ac_table"), program_head=("; OURS" if dialect == "heidenhain" else "G40",))
    lines = ["UNITS/MM", "FEDRAT/500,MMPM", "LOAD/TOOL,3", "SPINDL/900", "GOTO/0,0,9,0,0.5,0.8660254038",
             "GOTO/9,0,0", "LOAD/TOOL,7", "GOTO/0,5,9,0.5,0,0.8660254038", "GOTO/20,5,0"]  # fmt: skip
    result = postprocess(cldata.parse("\n".join(lines) + "\n"), setup, dialect=dialect, tcp=tcp)
    angles = [re.findall(r"(?:^| )[AC]\+?(-?[\d.]+)", line) for line in result.program.splitlines()]
    turned = [tuple(map(float, both)) for both in angles if len(both) == 2]
    assert list(dict.fromkeys(turned)) == [(30.0, 180.0), (30.0, 90.0)]
    assert result.blocks.words[-1, 3:].tolist() == [0.0, 0.0]  # at the end, one after the other
    assert "tool 7 cuts, and nothing switches the spindle on" in str(result.report)
    assert "tool 3 cuts" not in str(result.report)


@pytest.mark.parametrize("dialect", DIALECTS)
def test_x_and_y_of_the_safe_position_are_left_and_reached_at_its_z(dialect):
    data = replace(load_machine("ac_table"), program_foot=("M9",), safe=(100.0, 150.0, 390.0))
    blocks = postprocess(cldata.parse(TWO_TOOLS), data, dialect=dialect).blocks
    steps = np.abs(np.diff(blocks.words[:, :3], axis=0)) > 1e-3
    over = blocks.words[:, :2] == [100.0, 150.0]
    assert over.all(axis=1).sum() >= 5  # at the beginning and the end of each tool, and where the axes go to 0
    leaving = np.flatnonzero(over[1:].all(axis=1) != over[:-1].all(axis=1))
    assert len(leaving) == 4 and not steps[leaving, 2].any()
    assert blocks.rapid[1:][leaving].all()


def test_motion_only_stays_motion_only():
    text = postprocess(cldata.parse(TWO_TOOLS), load_machine("ac_table")).program
    assert "MOTION ONLY" in text and "M91" not in text
