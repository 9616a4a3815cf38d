"""The page of a machine: its words against what points of table and head really do."""

from dataclasses import replace

import numpy as np
import pytest

from mathpost.interface.shell.main import main
from mathpost.kinematics import Kinematics
from mathpost.teaching.course.machine_page import page, reach, words
from mathpost.teaching.draw.arrangement import placing


def seen(kin, joint, offset):
    """Where a point goes that stands beside the axis of a rotary joint, at rotary zero, by the chain."""
    rotary = kin.machine.rotary[joint - 3]
    places = placing(kin.machine)
    before, after = (places(angle * np.eye(5)[joint]) for angle in (0.0, 0.02))
    point = before[rotary.name] @ [*rotary.point, 1.0] + np.append(offset, 0.0)
    return (after[rotary.name] @ np.linalg.inv(before[rotary.name]) @ point - point)[:3]


@pytest.mark.parametrize("turned", [1, -1])
def test_words_say_what_points_do(kin, turned):
    rotary = tuple(replace(each, axis=tuple(turned * x for x in each.axis)) for each in kin.machine.rotary)
    kin = Kinematics(replace(kin.machine, rotary=rotary))
    for joint, each in enumerate(kin.machine.rotary, start=3):
        said = words(kin)[each.name]
        front, right = (seen(kin, joint, offset) for offset in ([0, -1.0, 0], [1.0, 0, 0]))
        below = seen(kin, joint, [0, 0, -1.0])
        if each.carries == "workpiece":
            assert ("front rises" in said) == (front[2] > 1e-3) and ("front sinks" in said) == (front[2] < -1e-3)
            assert ("side rises" in said) == (right[2] > 1e-3) and ("side sinks" in said) == (right[2] < -1e-3)
        else:
            assert ("to the back" in said) == (below[1] > 1e-3) and ("to the front" in said) == (below[1] < -1e-3)
            assert ("to the left" in said) == (below[0] < -1e-3) and ("to the right" in said) == (below[0] > 1e-3)
        assert ("counterclockwise" in said) == (right[1] > 1e-3)
        assert (" clockwise" in said) == (right[1] < -1e-3)


def test_the_programmed_sign_and_iso_841(kin):
    """By ISO 841 a positive C turns the tool, seen from the workpiece, right-handed about +Z; A and B likewise."""
    for joint, each in enumerate(kin.machine.rotary, start=3):
        places = placing(kin.machine)(0.01 * np.eye(5)[joint])
        turn = np.linalg.inv(places["workpiece"]) @ places["tool"]
        at_zero = placing(kin.machine)(np.zeros(5))
        turn = (turn @ np.linalg.inv(np.linalg.inv(at_zero["workpiece"]) @ at_zero["tool"]))[:3, :3]
        sign = {"A": turn[2, 1], "B": turn[0, 2], "C": turn[1, 0]}[each.name]
        assert ("as ISO 841 has it" in words(kin)[each.name]) == (sign > 0)


def test_reach_within_travel(kin):
    text = " ".join(reach(kin))
    near, far = np.degrees(kin.reach)
    assert f"{near:.1f}° to {far:.1f}° from the pole" in text


def test_show_writes_a_page_that_stands_alone(tmp_path, capsys):
    out = tmp_path / "machine.html"
    assert main(["show", "data/machines/ac_table.toml", "-o", str(out)]) == 0
    written = out.read_text(encoding="utf-8")
    assert "A+ turns the table so that its front rises" in written and "-120 to 120 °" in written
    assert "http" not in written and len(written) < 60_000
    assert main(["show", "data/machines/missing.toml", "-o", str(out)]) == 2
    assert "missing.toml" in capsys.readouterr().err


def test_names_from_a_file_are_text(kin):
    assert "<b>" not in page(Kinematics(replace(kin.machine, name="<b>bold</b>")))


def test_print_writes_every_language(tmp_path, capsys):
    for language, start in (("c", "/*"), ("js", "/*"), ("latex", "%")):
        out = tmp_path / f"machine.{language}"
        assert main(["print", "data/machines/bc_table.toml", "--to", language, "-o", str(out)]) == 0
        assert main(["print", "data/machines/bc_table.toml", "--to", language]) == 0
        assert capsys.readouterr().out == out.read_text(encoding="utf-8")
        assert out.read_text(encoding="utf-8").startswith(start)
