"""The sliders of lessons 01 and 02: they reach both ends, and the numbers under the picture are right."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mathpost import angles as euler
from mathpost.course import view_rotation
from mathpost.frame import Frame
from mathpost.plane.tilted_plane import Plane


def test_turned_point():
    view = view_rotation.turned_point((3, 4, 5))
    assert "x' = -1.224744, y' = 0.707107, z' = 6.928203" in repr(view)
    assert "active elements: -4.490731, 4.949747, 2.309402" in repr(view)
    (stairs,) = [line for line in view.scenes[0].lines if line.points]
    assert view.places[0]["turned"][:3, :3] @ stairs.parts[0][-1] == pytest.approx([3, 4, 5])
    assert view.state["sliders"][1]["value"] == 54.7356


def test_turns_are_about_the_axes_as_they_stand():
    """Half way, the second of three turns is half made; SciPy says where the frame is."""
    view = view_rotation.turns((3, 4, 5), (135, 54.7356, -90))
    assert "β 27.3678°, γ 0.0000°; now it turns about the new X" in repr(view)
    turned = Rotation.from_euler("ZX", [135, 27.3678], degrees=True).as_matrix()
    assert view.places[0]["turned"][:3, :3] == pytest.approx(turned, abs=1e-12)
    (axis,) = [line for line in view.scenes[0].lines if line.points]
    assert np.cross(axis.parts[0][1], turned[:, 0]) == pytest.approx([0, 0, 0], abs=1e-9)


@pytest.mark.parametrize(
    "angles",
    [
        (0, 0, 0),
        (20, 0, 35),
        (20, 180, 35),
        (30, 90, 90),
        (30, 90, -90),
        *np.random.default_rng(5).uniform(0, 180, (3, 3)),
    ],
)
def test_notations_say_what_python_says(angles):
    """The printed expressions, locks included, against the package's readings of the matrix."""
    frame = Frame(euler.matrix("ZXZ", angles, degrees=True))
    said = repr(view_rotation.notations(angles))
    axis, angle = euler.to_axis_angle(frame.rotation, degrees=True)
    assert f"axis ({', '.join(f'{x:z.4f}' for x in axis)}), angle {angle:.3f}°" in said
    assert f"quaternion ({', '.join(f'{x:z.4f}' for x in euler.to_quaternion(frame.rotation))})" in said
    for notation in ("G68.2", "PLANE SPATIAL", "AROT RPY"):
        plane = Plane.from_frame(frame, notation)
        words = ", ".join(f"{word} {value:z.3f}" for word, value in zip(plane.words, plane.values, strict=True))
        assert f"{notation}: {words}{' (locked)' * bool(plane.locked)}" in said
