"""Views that move: bodies where the chain puts them, a start in which everything is seen, exact numbers."""

import io
import json
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from PIL import Image

from mathpost import load_machine
from mathpost.errors import InputError
from mathpost.kinematics import Kinematics
from mathpost.path import cl
from mathpost.rotation import unit
from mathpost.teaching.course import view_gallery, view_machine, view_rotation
from mathpost.teaching.course.view_machine import SAMPLES
from mathpost.teaching.draw import scene
from mathpost.teaching.draw.arrangement import GREYS, arrange, placing
from mathpost.teaching.draw.part import Part, clearance
from mathpost.teaching.draw.picture import View, camera, spread
from mathpost.teaching.draw.scene import Scene
from mathpost.teaching.draw.solid import Hull, Lofted, Turned, block, put, ring, smooth
from tests.conftest import DATA
from tests.machines import machines, random_joints, with_slides


@pytest.fixture(scope="module")
def twisted():
    return cl.read(DATA / "cl/twisted_blade.cl")


def test_bodies_stand_where_the_chain_has_tool_and_workpiece(kin):
    places = placing(kin.machine)
    for joints in random_joints(kin, 20, seed=1):
        placed = places(joints)
        workpiece_from_tool = np.linalg.inv(placed["workpiece"]) @ placed["tool"]
        tip, axis = kin.forward(joints)
        assert workpiece_from_tool[:3, 3] == pytest.approx(tip, abs=1e-8)
        assert workpiece_from_tool[:3, 2] == pytest.approx(axis, abs=1e-12)
        assert placed[kin.machine.linear[1].name][:2, 3] - places(0 * joints)["Y"][:2, 3] == pytest.approx(
            joints[:2]
        )


@pytest.mark.parametrize("under", ["X", "YX", "XYZ"])
def test_slides_under_the_workpiece_are_drawn_too(dmu50v, under):
    shown = with_slides(dmu50v.machine, under, "".join(name for name in "ZXY" if name not in under))
    assert len(arrange(Kinematics(shown)).solids) >= len(arrange(dmu50v).solids)


@settings(deadline=None, max_examples=2)
@given(machines())
def test_any_machine_can_be_drawn(model):
    kin = Kinematics(model)
    view = view_machine.machine(kin)
    (drawn,) = view.scenes
    assert {solid.body for solid in drawn.solids} >= {"bed", "workpiece", "tool", *model.joint_names}
    assert np.isfinite([solid.triangles().sum() for solid in drawn.solids]).all()
    assert "NaN" not in json.dumps(view.state) and len(view.page()) < 90_000
    assert Image.open(io.BytesIO(view.picture())).size == (480, 400)


def test_solids_lie_outside_of_each_other_at_home(kin):
    """The tool stands over the workpiece, and a table under it."""
    made = arrange(kin)
    placed = placing(kin.machine)(made.home)
    heights = {}
    for solid in made.solids:
        points = solid.triangles().reshape(-1, 3) @ placed[solid.body][:3, :3].T + placed[solid.body][:3, 3]
        heights.setdefault(solid.body, []).append((points[:, 2].min(), points[:, 2].max()))
    top = max(high for _, high in heights["workpiece"])
    assert min(low for low, _ in heights["tool"]) >= top - 1e-9
    for rotary in kin.machine.rotary:
        if rotary.carries == "workpiece" and np.allclose(unit(np.abs(rotary.axis)), [0, 0, 1]):
            assert max(high for _, high in heights[rotary.name]) <= heights["workpiece"][0][0] + 1e-9


@pytest.mark.parametrize("tool_side", [-90, 0, 90])
@pytest.mark.parametrize("workpiece_side", [-180, -90, 0, 90])
def test_a_head_stays_in_front_of_the_wall(kin, tool_side, workpiece_side):
    """Where it turns about the tip; the wall carries the slides."""
    made = arrange(kin)
    (joints,) = scene.turned(kin, made, [(tool_side, workpiece_side)])
    places, (wall,) = placing(kin.machine)(joints), [each for each in made.solids if each.colour == GREYS["wall"]]
    heads = {"tool", *(rotary.name for rotary in kin.machine.rotary if rotary.carries == "tool")}
    for solid in made.solids:
        if solid.body in heads:
            assert put(places[solid.body], solid.triangles().reshape(-1, 3))[:, 1].max() < wall.points[:, 1].min()


def test_faces_look_outwards_and_normals_are_theirs():
    along = unit(np.array([1.0, 2, 3]))
    for solid in (
        Turned("a", "#000000", [(0, 0), (5, 0), (3, 8), (0, 8)], along, along),
        Hull("a", "#000000", block([0, 0, 0], [1.0, 2, 3])),
        Lofted("a", "#000000", [np.zeros((1, 3)), ring([0, 0, 0], [0, 0, 1], 5), ring([0, 0, 8], [0, 0, 1], 3)]),
    ):
        triangles = solid.triangles()
        middle = triangles.reshape(-1, 3).mean(axis=0)
        flat = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
        real = np.linalg.norm(flat, axis=1) > 1e-9
        assert (np.einsum("ni,ni->n", flat, triangles.mean(axis=1) - middle)[real] > 0).all()
        normals = smooth(triangles)[real]
        assert np.linalg.norm(normals, axis=-1) == pytest.approx(1)
        assert (
            np.einsum("ni,nki->nk", flat[real] / np.linalg.norm(flat[real], axis=1, keepdims=True), normals) > 0.8
        ).all()


def test_clearance_of_a_box_is_that_of_its_coordinates():
    """Face, edge and corner, outside and inside."""
    box, half = Hull("a", "#000000", block([-2.0, -3, -4], [2.0, 3, 4])).surface[0], np.array([2.0, 3, 4])
    points = np.random.default_rng(1).uniform(-6, 6, (2000, 3))
    beyond = np.abs(points) - half
    wanted = np.where((beyond < 0).all(axis=1), beyond.max(axis=1), np.linalg.norm(np.maximum(beyond, 0), axis=1))
    assert clearance(box, points) == pytest.approx(wanted, abs=1e-12)


def test_clearance_of_a_hollow_solid_knows_inside_from_outside():
    """A bowl: what lies in the hollow is outside, and nearest to its wall."""
    bowl = Turned("a", "#000000", [(0, 0), (9, 0), (9, 9), (8, 9), (8, 1), (0, 1)], np.zeros(3), np.eye(3)[2])
    points = np.array([[0, 0, 5.0], [0, 0, 0.4], [0, 0, 1.3], [0, 0, -2.0]])
    inner = 8 * np.cos(np.pi / 40)  # the wall is a polygon of forty sides
    assert clearance(bowl.triangles(), points) == pytest.approx([4.0, -0.4, 0.3, 2.0])
    assert clearance(bowl.triangles(), np.array([[inner - 0.5, 0, 5], [8.5, 0, 5]])) == pytest.approx(
        [0.5, -0.5], abs=0.03
    )


@pytest.fixture
def pillar():
    """A round pillar of radius 10 and height 40, and a tool of radius 3."""
    return Part([ring([0, 0, height], [0, 0, 1], 10, 360) for height in (0, 40)], 3.0)


@pytest.mark.parametrize(
    ("tip", "tilt", "wanted"),
    [
        ((13, 0, 5), 0, 0),  # beside it
        ((11.5, 0, 5), 0, 1.5),
        ((20, 0, 5), 90, 0),  # away from it
        ((8, 0, 20), 90, 2),  # the ball, from the side
        ((0, 0, 38), 0, 2),  # the ball, from above
        ((0, 0, 20), 0, 13),
        ((0, 0, -50), 0, 0),  # under it, and no longer than the pillar is high
    ],
)
def test_how_deep_a_tool_is_in_a_part(pillar, tip, tilt, wanted):
    axis = np.array([[np.sin(np.radians(tilt)), 0, np.cos(np.radians(tilt))]])
    assert pillar.depth(np.array([tip], dtype=float), axis) == pytest.approx([wanted], abs=2e-3)


@pytest.mark.parametrize("azimuth", [-170, -60, 10, 100])
@pytest.mark.parametrize("elevation", [-40, 5, 60])
def test_what_is_nearest_is_seen(azimuth, elevation):
    """Two balls: the one nearer to the viewer hides the middle of the other."""
    half = np.linspace(-np.pi / 2, np.pi / 2, 9)
    ball = list(zip(np.cos(half), np.sin(half), strict=True))
    towards = camera(azimuth, elevation)[2]
    pair = [Turned("bed", "#ff0000", ball, side * 3 * towards, np.eye(3)[2]) for side in (1, -1)]
    drawn = Scene(pair, radius=2.0, azimuth=azimuth, elevation=elevation)
    solid, light, depth = View(drawn, (40, 40)).seen()
    assert solid[20, 20] == 0 and depth[20, 20] == pytest.approx(4, abs=0.05) and 0 < light[20, 20] < 255
    assert (solid != 1).all() and solid[0, 0] == -1


def test_the_light_on_a_ball_changes_little_from_pixel_to_pixel():
    half = np.linspace(-np.pi / 2, np.pi / 2, 13)
    ball = Turned("bed", "#ff0000", list(zip(np.cos(half), np.sin(half), strict=True)), np.zeros(3), np.eye(3)[2])
    _, light, _ = View(Scene([ball], radius=1.2), (200, 200)).seen()
    inside = light[50:150, 50:150]
    assert all(np.abs(np.diff(inside, axis=axis)).max() < 5 for axis in (0, 1)) and np.ptp(inside) > 50


def on_screen(drawn, first, second):
    """The angle between two directions as they are seen, degrees."""
    seen = camera(drawn.azimuth, drawn.elevation)
    (a, b), (c, d) = seen[:2] @ first, seen[:2] @ second
    return np.degrees(abs(np.arctan2(a * d - b * c, a * c + b * d)))


def test_at_the_start_everything_is_seen(kin):
    view = view_machine.machine(kin)
    (drawn,) = view.scenes
    start = np.array([slider["value"] for slider in view.state["sliders"]])
    joints = np.r_[start[:3], np.radians(start[3:])]
    places = placing(kin.machine)(joints)
    assert all(drawn.places[body] == pytest.approx(place) for body, place in places.items())
    assert scene.crossed(kin, drawn) == scene.covered(drawn) == []
    tilt = on_screen(drawn, places["tool"][:3, 2], places["workpiece"][:3, 2])
    assert tilt > 8, "the tool is seen to lean"


def test_a_walk_starts_where_everything_is_seen(kin, blade):
    view = view_machine.walk(kin, blade)
    start = np.array(view.state["joints"][0])
    (drawn,) = view.scenes
    assert drawn.places["tool"] == pytest.approx(placing(kin.machine)(start)["tool"])
    assert scene.crossed(kin, drawn) == scene.covered(drawn) == []


def test_a_blade_stands_under_a_path_that_is_a_point(blade, dmu50v):
    """Its edge is at the tip, square to the fan of the tool."""
    (solid,) = [each for each in arrange(dmu50v, blade).solids if isinstance(each, Lofted)]
    assert solid.rings[-1] == pytest.approx(blade.points.mean(axis=0)[None])
    fan = np.ptp(blade.axes[:, :2], axis=0)
    edge = solid.rings[0] - solid.rings[0].mean(axis=0)
    assert np.ptp(edge[:, :2] @ unit(fan)) < 0.4 * np.ptp(edge[:, :2] @ unit(fan)[::-1])


def test_what_is_hidden_is_said(kin):
    """Seen along the tool, or from under the bed, something is wrong."""
    drawn, made = scene.machine(kin)
    tool = placing(kin.machine)(made.home)["tool"][:3, 2]
    along = drawn.frame(np.degrees(np.arctan2(tool[1], tool[0])), np.degrees(np.arcsin(tool[2])))
    assert any("points at the viewer" in said for said in scene.crossed(kin, along))
    below = scene.covered(drawn.frame(-58, -75))
    assert "the workpiece is hidden" in below or "the tool is hidden" in below


def test_frames_of_a_formula_stand_apart():
    point = view_rotation.turned_point((3, 4, 5))
    turned = point.scenes[0].places["turned"][:3, :3]
    axes = dict(zip(("X", "Y", "Z", "X'", "Y'", "Z'"), [*np.eye(3), *turned.T], strict=True))
    turns, notations = view_rotation.turns((3, 4, 5), (135, 54.7356, -90)), view_rotation.notations()
    half, named = (
        dict(zip("XYZxyz", [*np.eye(3), *view.scenes[0].places["turned"][:3, :3].T], strict=True))
        for view in (turns, notations)
    )
    for view, directions in ((point, axes), (turns, half), (notations, named)):
        seen = camera(view.scenes[0].azimuth, view.scenes[0].elevation)
        assert scene.together(directions, seen) == []


def test_spread_leaves_alone_what_is_far_enough_apart():
    places = np.array([[0.0, 0.0], [3.0, 0.0], [0.0, 3.0]])
    assert spread(places, 1.0) == pytest.approx(places)
    crowd = np.random.default_rng(7).uniform(0, 1.5, (6, 2))
    moved = spread(crowd, 0.8, rounds=200)
    apart = np.linalg.norm(moved[:, None] - moved, axis=-1)[np.triu_indices(6, 1)]
    assert apart.min() > 0.79


def test_readings_of_the_start_are_exact(kin):
    view = view_machine.machine(kin)
    joints = np.array([slider["value"] for slider in view.state["sliders"]])
    tip, axis = kin.forward(joints, degrees=True)
    said = f"tip {' '.join(f'{x:z.3f}' for x in tip)}, tool axis {' '.join(f'{x:z.4f}' for x in axis)}, "
    assert said in repr(view)
    assert tip == pytest.approx(kin.forward(arrange(kin).home)[0], abs=1e-9), (
        "over the workpiece, to the last digit"
    )


def test_both_solutions_are_the_same_tool_axis(kin):
    view = view_machine.tool_axis(kin)
    assert repr(view).count("branch: X") == 2
    tilt, _ = (slider["value"] for slider in view.state["sliders"])
    for places in (drawn.places for drawn in view.scenes[1:]):
        axis = (np.linalg.inv(places["workpiece"]) @ places["tool"])[:3, 2]
        pole = np.array(kin.inverse_symbolic.pole, dtype=float)
        assert np.degrees(np.arccos(axis @ pole)) == pytest.approx(tilt, abs=1e-6)


def test_every_button_of_both_solutions_goes_to_a_place_of_its_own(kin):
    names, places = zip(*view_machine.tool_axis(kin).state["places"], strict=True)
    assert len(set(names)) == len(names)
    limits = [tilt for name, (tilt, _) in zip(names, places, strict=True) if "limit" in name]
    assert np.unique(np.round(limits, 6)).size == len(limits)


def test_a_walk_knows_blocks_records_and_sights(dmu50v, blade):
    view = view_machine.walk(dmu50v, blade)
    run = view.state
    assert np.array(view.state["cl"]) == pytest.approx(np.hstack([blade.points, blade.axes]), abs=1e-9)
    tip, axis = dmu50v.forward(run["joints"])
    assert tip == pytest.approx(blade.points, abs=1e-9) and axis == pytest.approx(blade.axes, abs=1e-12)
    assert dict(view.state["places"])["largest swing"] == 2.5 and dict(view.state["places"])["pole"] == 3.0
    assert run["singular"] == [[2, 3]]


def test_a_walk_tells_how_deep_the_tool_is_in_a_part(dmu50v, blade, pillar):
    """At the samples of a straight move of the five joints, by the distance from the pillar's axis alone."""
    beside = replace(pillar, rings=[ring([50, 47, height], [0, 0, 1], 10, 360) for height in (0, 100)])
    joints = dmu50v.inverse(blade.points, blade.axes)[:, 0]
    view = view_machine.walk(dmu50v, blade, joints, part=beside)
    run = view.state
    assert len(run["depth"]) == 4 * SAMPLES + 1
    number = SAMPLES * 11 // 6  # five sixths of the swing
    tip, axis = dmu50v.forward(joints[1] + (joints[2] - joints[1]) * 5 / 6)
    along = tip + np.linspace(3, 60, 2000)[:, None] * axis
    from_axis = np.linalg.norm(along[:, :2] - [50, 47], axis=1).min()
    assert run["depth"][number] == pytest.approx(max(0, 13 - from_axis), abs=5e-3)
    deepest = dict(view.state["places"])["in the part"]
    assert deepest == pytest.approx(1 + np.argmax(run["depth"]) / SAMPLES)
    away = replace(pillar, rings=[np.add(each, [500, 0, 0]) for each in pillar.rings])
    assert "in the part" not in dict(view_machine.walk(dmu50v, blade, joints, part=away).state["places"])
    (drawn,) = [each for each in view.scenes[0].solids if isinstance(each, Lofted)]
    assert drawn.rings[1] == pytest.approx(beside.rings[0]), "the part stands in place of the sketch"


def test_a_long_walk_holds_every_block(dmu50v, twisted):
    run = view_machine.walk(dmu50v, twisted).state
    tip, axis = dmu50v.forward(run["joints"])
    assert tip == pytest.approx(twisted.points, abs=1e-6) and axis == pytest.approx(twisted.axes, abs=1e-9)
    assert np.array(run["place"]) == pytest.approx(np.arange(len(twisted)))


def test_a_page_stands_alone(dmu50v):
    view = view_machine.machine(dmu50v)
    page = view.page(still=True)
    assert "http" not in page.replace("http-equiv", "") and "</script></html>" in page
    output = view._repr_html_()
    assert output.count('sandbox="allow-scripts"') == 1 and 'src="data:image/png;base64,' in output
    assert len(view.picture()) < 20_000


def test_a_gallery_refuses_a_machine_with_one_rotary_axis():
    two, one = (Kinematics(load_machine(name)) for name in ("ac_table", "dividing_head"))
    with pytest.raises(InputError, match="two rotary axes"):
        view_gallery.gallery([two, one])
