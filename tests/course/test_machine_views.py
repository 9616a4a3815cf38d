"""A moving machine: bodies where the chain puts them, views that answer, and what one slider step costs."""

import io

import numpy as np
import pytest
from hypothesis import given, settings
from matplotlib.figure import Figure
from PIL import Image
from scipy.spatial.transform import Rotation

from mathpost import rotation
from mathpost.course import view_calibration, view_machine, view_path, view_rotation
from mathpost.draw.arrangement import arrange, placing
from mathpost.draw.scene import Scene, spread
from mathpost.draw.solid import Camera, Solid, Solids, block
from mathpost.draw.traces import Curves, Sphere, small_circle
from mathpost.draw.widget import View
from mathpost.errors import InputError, OutputError
from mathpost.kinematics import Kinematics
from mathpost.post import cl, selection, singular
from mathpost.post.between_blocks import deviation, true_tip
from mathpost.rotation import unit
from tests.conftest import DATA
from tests.machines import machines, random_joints


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


def test_a_carried_body_turns_about_its_own_axis(kin):
    places = placing(kin.machine)
    first = kin.machine.rotary[0]
    for angle in (-2.0, 0.3, 1.5):
        placed = places([0, 0, 0, angle, 0])[first.name]
        turned = Rotation.from_rotvec(angle * unit(np.array(first.axis))).as_matrix()
        assert placed[:3, :3] == pytest.approx(turned, abs=1e-12)
        on_axis = np.array([*first.point, 1.0])
        still = places(np.zeros(5))[first.name] @ on_axis
        assert placed @ on_axis == pytest.approx(still, abs=1e-9)


@settings(deadline=None, max_examples=4)
@given(machines())
def test_any_machine_can_be_drawn(model):
    kin = Kinematics(model)
    made = arrange(kin)
    assert {solid.body for solid in made.solids} >= {"bed", "workpiece", "tool", *model.joint_names}
    scene = Scene(Figure().subplots(), kin)
    scene.move(random_joints(kin, 4, seed=3)[-1])
    drawn = np.concatenate([path.vertices for path in scene._solids.artist.get_paths()])
    assert np.isfinite(drawn).all()


def test_solids_lie_outside_of_each_other_at_home(kin):
    """The tool stands over the workpiece, and a table under it."""
    made = arrange(kin)
    placed = placing(kin.machine)(made.home)
    heights = {}
    for solid in made.solids:
        points = solid.vertices @ placed[solid.body][:3, :3].T + placed[solid.body][:3, 3]
        heights.setdefault(solid.body, []).append((points[:, 2].min(), points[:, 2].max()))
    top = max(high for _, high in heights["workpiece"])
    assert min(low for low, _ in heights["tool"]) >= top - 1e-9
    for rotary in kin.machine.rotary:
        if rotary.carries == "workpiece" and np.allclose(unit(np.abs(rotary.axis)), [0, 0, 1]):
            assert max(high for _, high in heights[rotary.name]) <= heights["workpiece"][0][0] + 1e-9


@pytest.mark.parametrize("azimuth", [-170, -60, 10, 100])
@pytest.mark.parametrize("elevation", [-40, 5, 60])
def test_what_is_in_front_is_drawn_last(azimuth, elevation):
    """A small box on each face of a large flat one, where depths of middles mislead."""
    camera = Camera(azimuth, elevation)
    plate = Solid("bed", block([-100, -100, -1], [100, 100, 1]), "#000000")
    above = Solid("bed", block([60, 60, 1], [70, 70, 11]), "#ff0000")
    below = Solid("bed", block([-70, -70, -11], [-60, -60, -1]), "#0000ff")
    solids = Solids(Figure().subplots(), [above, plate, below], camera)
    solids.move({"bed": np.eye(4)})
    drawn = [colour[:3].argmax() if colour[:3].any() else 1 for colour in solids.artist.get_facecolor()]
    order = list(dict.fromkeys(drawn))  # 0 above, 1 plate, 2 below
    assert order == ([2, 1, 0] if elevation > 0 else [0, 1, 2])


def test_labels_never_overlap(kin):
    figure = Figure(figsize=(6, 4.4), dpi=100)
    scene = Scene(figure.subplots(), kin)
    figure.canvas.draw()
    for joints in [scene.home, *(scene.home + random_joints(kin, 12, seed=5) * [0.05, 0.05, 0.05, 1, 1])]:
        scene.move(joints)
        boxes = [text.get_window_extent().padded(-1) for text, _, _ in scene._labels]
        for number, box in enumerate(boxes):
            assert not any(box.overlaps(other) for other in boxes[number + 1 :])


def test_spread_leaves_alone_what_is_far_enough_apart():
    places = np.array([[0.0, 0.0], [3.0, 0.0], [0.0, 3.0]])
    assert spread(places, 1.0) == pytest.approx(places)
    crowd = np.random.default_rng(7).uniform(0, 1.5, (6, 2))
    moved = spread(crowd, 0.8, rounds=200)
    apart = np.linalg.norm(moved[:, None] - moved, axis=-1)[np.triu_indices(6, 1)]
    assert apart.min() > 0.79


def test_the_true_way_of_the_tip(kin):
    tips = [[60.0, 20, 10], [75, 20, 10], [60, 40, 15]]
    joints = kin.close(tips, np.radians([[10, 0], [15, 40], [15, -30]]))
    tip, chord = true_tip(kin, joints, samples=400)
    assert chord[[0, 400, -1]] == pytest.approx(np.array(tips))
    strayed = deviation(kin, joints[:-1], joints[1:])[0]
    for true, straight, most in zip(np.split(tip, 2), np.split(chord, 2), strayed, strict=True):
        distance = np.linalg.norm(true[:, None] - straight, axis=-1).min(axis=1).max()
        assert distance == pytest.approx(most, rel=0.02, abs=0.05)


def test_curves_show_both_branches_limits_and_regions(dmu50v, blade):
    panels = Figure().subplots(2, 1)
    chosen = selection.choose(dmu50v, blade).joints
    curves = Curves(panels, dmu50v, blade, chosen)
    assert curves.singular == singular.regions(dmu50v, blade, chosen, cone=np.radians(1.0))
    shown = np.array([[line.get_ydata() for line in panel.lines[1:3]] for panel in panels])  # axis, branch, record
    for branch in range(2):
        axes = dmu50v.forward(np.column_stack([np.zeros((5, 3)), *np.radians(shown[:, branch])]))[1]
        assert axes == pytest.approx(blade.axes, abs=1e-9)
    curves.move(2.5)
    assert all(cursor.get_xdata()[0] == 2.5 for cursor in curves.cursors)


def test_the_sphere_shows_the_tool_axis_and_its_side(kin):
    sphere = Sphere(Figure().subplots(), kin)
    for axis in (sphere.camera.towards, -sphere.camera.towards):
        sphere.move(axis)
        assert np.hypot(*sphere.dot.get_data()) == pytest.approx(0, abs=1e-12)
    assert sphere.dot.get_markerfacecolor() == "white"
    circle = small_circle([1, 2, 2], 0.4)
    assert circle @ np.array([1, 2, 2]) / 3 == pytest.approx(np.cos(0.4))


VIEWS = {
    "machine": lambda kin, blade, twisted: view_machine.machine(kin),
    "tool axis": lambda kin, blade, twisted: view_machine.tool_axis(kin),
    "walk": lambda kin, blade, twisted: view_machine.walk(kin, blade),
    "long walk": lambda kin, blade, twisted: view_machine.walk(kin, twisted, selection.choose(kin, twisted).joints),
}


@pytest.fixture(scope="module", params=VIEWS)
def view(request, dmu50v, blade, twisted):
    return VIEWS[request.param](dmu50v, blade, twisted)


def test_one_step_of_a_slider_is_little_work(view, monkeypatch):
    """What costs time is bounded, not the time: one picture, nothing compiled, laid out or made anew."""

    def forbidden(*_, **__):
        raise AssertionError("too much work for a slider")

    start = view.values
    for values in ({name: slider.max for name, slider in view.sliders.items()}, start):
        view.go(values)  # by now the view knows what moves
    monkeypatch.setattr(rotation.sp, "lambdify", forbidden)
    monkeypatch.setattr(Figure, "draw", forbidden)
    monkeypatch.setattr(Figure, "savefig", forbidden)
    artists = len(view.figure.findobj())
    for slider in view.sliders.values():
        view.go(start)
        draws, picture = view.draws, view.image.value
        slider.value = slider.min if slider.value != slider.min else slider.max
        assert view.draws == draws + 1
        assert view.image.value != picture
    draws = view.draws
    view.go({name: slider.max for name, slider in view.sliders.items()})
    assert view.draws == draws + 1
    assert len(view.figure.findobj()) == artists
    assert len(view.image.value) < 150_000
    polygons = [len(a.get_paths()) for a in view.figure.findobj(lambda artist: hasattr(artist, "set_verts"))]
    assert sum(polygons) < 500
    points = [len(line.get_xdata()) for line in view._moving if hasattr(line, "get_xdata")]
    assert sum(points) < 12_000


OTHERS = {
    "past the pole": view_path.past_the_pole,
    "notations": lambda kin: view_rotation.notations(),
    "third angle": lambda kin: view_rotation.third_angle(kin.machine, 135, 54.7356),
    "carried": lambda kin: view_rotation.carried(kin.machine),
    "rtcp zero": lambda kin: view_calibration.rtcp_zero(),
    "machine": view_machine.machine,
    "tool axis": view_machine.tool_axis,
}


def differing(first, second):
    """The share of pixels that look different in two PNGs."""
    one, other = (np.asarray(Image.open(io.BytesIO(png)).convert("RGB"), dtype=float) for png in (first, second))
    return (np.abs(one - other).max(axis=-1) > 40).mean()


@pytest.mark.parametrize("make", OTHERS.values(), ids=OTHERS)
def test_a_picture_drawn_in_part_is_the_whole_picture(make, dmu50v):
    view = make(dmu50v)
    rng = np.random.default_rng(11)
    for _ in range(3):
        for slider in view.sliders.values():
            slider.value = rng.uniform(slider.min, slider.max)
        assert differing(view.image.value, view._png(100)) < 2e-3
        view.redraw()


def test_every_button_draws_once(view):
    for button in view.buttons.values():
        draws = view.draws
        button.click()
        assert view.draws == draws + 1


def test_number_boxes_and_sliders_say_the_same(view):
    for name, slider in view.sliders.items():
        view.boxes[name].value = slider.min
        assert slider.value == slider.min
        slider.value = slider.max
        assert view.boxes[name].value == slider.max


def test_buttons_of_the_machine_keep_the_tip(kin):
    view = view_machine.machine(kin)

    def pose():
        joints = np.array([*view.values.values()])
        return joints, *kin.forward(joints, degrees=True)

    joints, tip, axis = pose()
    view.buttons["other solution"].click()
    others, other_tip, other_axis = pose()
    assert other_tip == pytest.approx(tip, abs=1e-9) and other_axis == pytest.approx(axis, abs=1e-12)
    assert np.abs(others[3:] - joints[3:]).max() > 1
    view.buttons["pole"].click()
    assert pose()[1] == pytest.approx(tip, abs=1e-9)
    assert singular.closeness(kin, pose()[2]) == pytest.approx(0, abs=1e-7)
    limits = [label for label in view.buttons if "limit" in label]
    for label in limits:
        view.buttons[label].click()
        name, *_, angle = label.rstrip("°").split()
        assert view.values[name] == pytest.approx(float(angle), abs=0.5)


def test_both_solutions_are_the_same_tool_axis(kin):
    view = view_machine.tool_axis(kin)
    first, second = view.numbers.value.split("<br>")[1:]
    assert first.startswith("first branch: X") and second.startswith("second branch: X")
    view.sliders["tilt"].value = view.sliders["tilt"].max
    assert ("out of reach" in view.numbers.value) == (view.sliders["tilt"].max > np.degrees(kin.reach[1]) + 1e-6)


def test_a_walk_meets_the_records_and_strays_between_them(dmu50v, blade):
    view = view_machine.walk(dmu50v, blade)
    for record in (1, 2, 3, 4, 5):
        view.go({"record": record})
        assert "tip 0.0000 mm and axis 0.000° off" in view.numbers.value
    view.buttons["largest swing"].click()
    assert view.values["record"] == 2.5
    assert float(view.numbers.value.split("tip ")[1].split()[0]) > 70  # source 002: C swings by 180° about 77 mm
    view.buttons["pole"].click()
    assert view.values["record"] == 3.0


def test_play_and_step(dmu50v, blade):
    view = view_machine.walk(dmu50v, blade)
    back, forth = view.steps
    forth.click()
    assert view.values["record"] == pytest.approx(1.05)
    back.click()
    assert view.values["record"] == 1.0
    view.play.value = view.play.max
    assert view.values["record"] == 5.0
    view.sliders["record"].value = 1.03  # between two steps: play follows, the slider stays
    assert view.values["record"] == 1.03 and view.play.value in (0, 1)


def test_pictures_and_animations_as_files(dmu50v, blade, tmp_path):
    view = view_machine.walk(dmu50v, blade)
    shown = view.image.value
    view.save(tmp_path / "walk.png")
    assert Image.open(tmp_path / "walk.png").size == (1720, 880)
    view.animate(tmp_path / "walk.gif", "record", start=2, end=3, frames=5)
    gif = Image.open(tmp_path / "walk.gif")
    frames = set()
    for number in range(gif.n_frames):
        gif.seek(number)
        frames.add(gif.convert("RGB").tobytes())
    assert gif.n_frames == len(frames) == 5
    view.redraw()
    assert differing(shown, view.image.value) < 2e-3
    for action in (lambda: view.save(tmp_path / "a.gif"), lambda: view.animate(tmp_path / "a.png", "record")):
        with pytest.raises(InputError, match="ends in"):
            action()
    with pytest.raises(InputError, match="name: expected record, found 'height'"):
        view.animate(tmp_path / "b.gif", "height")
    with pytest.raises(OutputError, match="not written"):
        view.save(tmp_path / "nowhere" / "a.png")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["walk.gif", "walk.png"]


def test_a_view_without_animated_artists_is_drawn_whole():
    def build(figure):
        (line,) = figure.subplots().plot([0, 1], [0, 0])
        return lambda height: line.set_ydata([0, height])

    view = View(build, {"height": (0, 1, 0.5)}, places={"top": {"height": 1}})
    before = view.image.value
    view.buttons["top"].click()
    assert view.values == {"height": 1.0} and view.image.value != before
