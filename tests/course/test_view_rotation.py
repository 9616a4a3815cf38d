"""The sliders of lessons 01 to 04: they reach both ends, and the numbers under the picture are right."""

import numpy as np
import pytest

from mathpost import machine
from mathpost.course import view_rotation
from mathpost.frame import machine_frames
from tests.conftest import DATA


def to_both_ends(view):
    """Move every slider to its ends and back; return the number of different pictures."""
    pictures = set()
    for slider in view.sliders.values():
        start = slider.value
        for value in (slider.min, slider.max, start):
            slider.value = value
            pictures.add(view.image.value)
    return len(pictures)


@pytest.fixture(scope="module")
def trunnion():
    return machine.load(DATA / "machines/ac_table.toml")


def test_turned_point():
    view = view_rotation.turned_point((3, 4, 5))
    assert "x' = -1.224744, y' = 0.707107, z' = 6.928203" in repr(view)
    assert "active elements: -4.490731, 4.949747, 2.309402" in repr(view)
    (stairs,) = [line for line in view.scenes[0].lines if line.name]
    assert view.places[0]["turned"][:3, :3] @ stairs.parts[0][-1] == pytest.approx([3, 4, 5])
    assert view.state["sliders"][1]["value"] == 54.7356


def test_notations_say_where_they_lock():
    view = view_rotation.notations()
    assert "locked" not in view.numbers.value
    view.sliders["J"].value = 0
    assert "G68.2: I 45.000, J 0.000, K 0.000 (locked)" in view.numbers.value
    view.sliders["J"].value, view.sliders["K"].value = 90, 90
    assert "PLANE SPATIAL" in view.numbers.value and view.numbers.value.count("(locked)") == 2
    assert to_both_ends(view) >= 4  # −180 and 180 look alike


@pytest.mark.parametrize(("k", "expected"), [(0, "1.000 mm clear"), (180, "-1.000 mm IN"), (-90, "-0.050 mm IN")])
def test_third_angle_clears_the_wall(trunnion, k, expected):
    view = view_rotation.third_angle(trunnion, 135, 54.7356)
    slider = view.state["sliders"][0]
    said = view.state["said"][round((k - slider["low"]) / slider["step"])]
    assert expected in said[1]
    assert f"wrong by {40 * abs(np.sin(np.radians(k / 2))):.1f} µm" in said[2]


def test_carried_shows_the_tool_axis(kin):
    view = view_rotation.carried(kin.machine)
    angles = {slider["name"]: slider["value"] for slider in view.state["sliders"]}
    joints = [0, 0, 0, *(angles[rotary.name] for rotary in kin.machine.rotary)]
    workpiece, tool = machine_frames(kin.machine, joints, degrees=True)
    x, y, z = (workpiece.inverse() @ tool).z
    assert f"sense 1: tool axis in the workpiece ({x:z.4f}, {y:z.4f}, {z:z.4f})" in repr(view)
    assert view.places[0]["workpiece"][:3, :3] == pytest.approx(workpiece.rotation)


def test_a_view_keeps_its_picture_for_readers_without_a_kernel():
    assert "image/png" in view_rotation.notations()._repr_mimebundle_()
