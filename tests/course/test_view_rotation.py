"""Views of lessons 01 to 04 reach both ends; cut corner and machines stand where the mathematics puts them."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mathpost import euler
from mathpost.frame import Frame
from mathpost.shop.plane.tilted_plane import Plane
from mathpost.teaching.course import view_gallery, view_rotation
from mathpost.teaching.course.lesson_data import load
from mathpost.teaching.draw import scene
from mathpost.teaching.draw.picture import camera

BETA = np.degrees(np.arccos(1 / np.sqrt(3)))


def test_turned_point():
    view = view_rotation.turned_point((3, 4, 5))
    assert "x' = -1.224744, y' = 0.707107, z' = 6.928203" in repr(view)
    assert "active elements: -4.490731, 4.949747, 2.309402" in repr(view)
    stairs, shadow = [line for line in view.scenes[0].lines if line.points]
    assert view.scenes[0].places["turned"][:3, :3] @ stairs.parts[0][-1] == pytest.approx([3, 4, 5])
    assert shadow.body == "bed" and shadow.parts[0][-1][:2] == pytest.approx([3, 4])
    assert view.state["sliders"][1]["value"] == 54.7356


def test_turns_are_about_the_axes_as_they_stand():
    """At the start two of three turns are made, so Z' is square to the face; SciPy says where the frame is."""
    view = view_rotation.turns((3, 4, 5), (135, BETA, -90))
    assert "γ 0.0000°; now it turns about the new X" in repr(view)
    turned = Rotation.from_euler("ZX", [135, BETA], degrees=True).as_matrix()
    assert view.scenes[0].places["turned"][:3, :3] == pytest.approx(turned, abs=1e-9)
    assert turned[:, 2] == pytest.approx(np.full(3, 3**-0.5))
    (axis,) = [line for line in view.scenes[0].lines if line.points]
    assert np.cross(axis.parts[0][1], turned[:, 0]) == pytest.approx([0, 0, 0], abs=1e-8)


def test_undo_turn_and_redo_turn_about_the_new_axis():
    """The three poses at the end, by SciPy: the last is a turn about the X that the first turn made."""
    view = view_rotation.conjugation(40, 60)
    first, about_x = (Rotation.from_euler(axis, angle, degrees=True) for axis, angle in (("z", 40), ("x", 60)))
    about_new_x = Rotation.from_rotvec(np.radians(60) * first.as_matrix()[:, 0])
    places = view.scenes[0].places
    for name, expected in (("undo", Rotation.identity()), ("turn", about_x), ("redo", about_new_x * first)):
        assert places[name][:3, :3] == pytest.approx(expected.as_matrix(), abs=1e-9)
    assert "undo -40.0°, turn 60.0°, redo 40.0°; from the frame turned by 60° about its own X: 0.00°" in repr(view)
    assert [scene.title for scene in view.scenes] == ["1 · undo, about Z", "2 · turn, about X", "3 · redo, about Z"]


def test_no_plate_is_seen_edge_on():
    for view in (view_rotation.turns((3, 4, 5), (135, BETA, -90)), view_rotation.turned_point((3, 4, 5))):
        seen = view.scenes[0]
        assert abs(camera(seen.azimuth, seen.elevation)[2] @ seen.places["turned"][:3, 2]) > 0.3


def test_the_arcs_of_the_angles_begin_and_end_on_what_they_measure():
    view = view_rotation.notations((40, 50, 30))
    frame = Rotation.from_euler("ZXZ", [40, 50, 30], degrees=True).as_matrix()
    node = np.array([np.cos(np.radians(40)), np.sin(np.radians(40)), 0])
    arcs = [line.parts[0] for line in view.scenes[0].lines if len(line.points) == 13]
    ends = [(arc[place] / np.linalg.norm(arc[place])).round(9) for arc in arcs for place in (0, -1)]
    expected = [(1, 0, 0), node, (0, 0, 1), frame[:, 2], node, frame[:, 0]]
    assert np.array(ends) == pytest.approx(np.array(expected), abs=1e-8)


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


NAMES = ("ac_table", "bc_table", "dmu50v", "head_b_table_c", "ac_head", "nutating_head")


def test_the_frame_starts_on_the_face_of_the_cut():
    face = Frame.from_axes([1, 1, 1], [1, 1, -2], [15, 15, -15])
    view = view_rotation.cut_corner(face, (135, BETA, -90))
    assert "off the face by 0.00°" in repr(view) and "off the slope by 0.00°" in repr(view)
    assert view.scenes[0].places["feature"] == pytest.approx(face.matrix)
    cube, drill = view.scenes[0].solids
    assert drill.body == "feature" and drill.along == pytest.approx([0, 0, 1])
    height = (cube.faces[0] - face.origin) @ face.z
    assert height.max() == pytest.approx(0) and (abs(height) < 1e-9).sum() == 3
    seen = camera(view.scenes[0].azimuth, view.scenes[0].elevation)
    assert scene.together(dict(zip("xyz", face.rotation.T, strict=True)), seen) == []
    assert scene.together(dict(zip("XYZ", np.eye(3), strict=True)), seen) == []


def test_the_gallery_turns_every_machine_by_its_own_chain():
    solvers = [load(name) for name in NAMES]
    view = view_gallery.gallery(solvers, workpiece=40, tool=30)
    assert len(view.page()) < 90_000 and len(view.scenes) == len(NAMES)
    for number, kin in enumerate(solvers):
        angle = {str(kin.inverse_symbolic.workpiece_side): 40, str(kin.inverse_symbolic.tool_side): 30}
        rotary = [angle[joint.name] for joint in kin.machine.rotary]
        _, axis = kin.forward([0, 0, 0, *rotary], degrees=True)
        places = view.scenes[number].places
        seen = np.linalg.inv(places[f"{number} workpiece"]) @ places[f"{number} tool"]
        assert seen[:3, 2] == pytest.approx(axis, abs=1e-12)
        assert f"{number + 1} {kin.machine.name}: n = ({', '.join(f'{x:z.4f}' for x in axis)})" in repr(view)
        own = {body.removeprefix(f"{number} "): place for body, place in places.items()}
        home = scene.machine(kin)[1].home
        assert seen[:3, 3] == pytest.approx(kin.forward(home)[0], abs=1e-9), "the tip stays where it is"
        drawn = view.scenes[number]
        assert {part.body for part in drawn.solids} <= {"bed", *places}
        seen = camera(drawn.azimuth, drawn.elevation)
        assert scene.together(dict(zip("xyz", own["workpiece"][:3, :3].T, strict=True)), seen) == []


def test_the_sense_turns_both_axes_round():
    solvers = [load("ac_table"), load("ac_head")]
    view = view_gallery.gallery(solvers, workpiece=40, tool=30, senses=True)
    buttons = dict(view.state["places"])
    assert buttons["sense −1"] == [None, None, -1] and "sense 1" in repr(view)
    assert "senses" not in repr(view) and "sense −1" not in dict(view_gallery.gallery(solvers).state["places"])


@pytest.mark.parametrize(("k", "expected"), [(0, "1.000 mm clear"), (180, "-1.000 mm IN"), (-90, "-0.050 mm IN")])
def test_third_angle_clears_the_wall(k, expected):
    """The tip at the angle ρ = K, retracted by 1 mm in a bore of 10; a stylus that runs out by 20 µm."""
    view = view_rotation.third_angle(load("ac_table").machine, 135, BETA, k)
    rho = np.radians(k)
    clearance = 10 - abs(10 * np.exp(-1j * rho) - 1)
    assert expected in repr(view) and f"{clearance:.3f} mm" in repr(view)
    assert f"wrong by {40 * abs(np.sin(rho / 2)):.1f} µm" in repr(view)
    assert "A 54.736, C 135.000" in repr(view)


@pytest.mark.parametrize("k", [0, 180])
def test_the_other_position_takes_the_other_third_angle(k):
    """With A below 0 the bar is clear of the wall at K = 180 and goes into it at 0."""
    view = view_rotation.third_angle(load("ac_table").machine, 135, BETA, k, seq="-")
    assert "A -54.736, C -45.000" in repr(view)
    assert ("1.000 mm clear" if k else "-1.000 mm IN") in repr(view)
    assert dict(view.state["places"]) == {"A > 0": [None, 1], "A < 0": [None, -1]}


def test_the_ring_is_run_by_each_machines_own_chain():
    """At every place of the slider each machine's forward chain puts tip and tool axis on the ring."""
    solvers = [load(name) for name in ("ac_table", "head_b_table_c", "ac_head")]
    view = view_gallery.ring(solvers, radius=40, height=25, lean=30)
    for number in range(len(solvers)):
        places = view.scenes[number].places
        seen = np.linalg.inv(places[f"{number} workpiece"]) @ places[f"{number} tool"]
        assert seen[:3, 3] == pytest.approx([40, 0, 25], abs=1e-9)
        assert seen[:3, 2] == pytest.approx([0.5, 0, np.cos(np.radians(30))], abs=1e-9)
