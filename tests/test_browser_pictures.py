"""What the browser paints, against Python's own pictures and against the numbers that they were made of.

Every call that draws is noted on its canvas: a line is where it was drawn, and a curve is read off by the labels of
its axes, as a reader does.
"""

import base64
import html
import io
import json
import re
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from mathpost.path.deviation import true_tip
from mathpost.teaching.course import view_gallery, view_machine, view_rotation
from mathpost.teaching.course.lesson_data import blade, load
from mathpost.teaching.course.view_machine import IN_THE_PART, SAMPLES
from mathpost.teaching.draw.live import HERE, MODULES, _dense
from mathpost.teaching.draw.part import Part
from mathpost.teaching.draw.picture import FINE, View, spread
from mathpost.teaching.draw.plot import COLOUR
from mathpost.teaching.draw.solid import ring
from tests.conftest import LESSONS
from tests.test_browser import CHROMIUM, PICTURE, browser, opened  # noqa: F401  the fixture of this module, too

pytestmark = pytest.mark.skipif(not CHROMIUM.exists(), reason=f"no browser: {CHROMIUM} is not there")

START = 'start(document.getElementById("live"), '
ALIGN = {"x": "center", "y": "right"}  # of the labels on an axis
CHARTS = [path for path in LESSONS if r"\"kind\":\"chart\"" in path.read_text(encoding="utf-8")]
SHARE = 0.015  # of the pixels may be of another colour: ends of lines, and the edges of letters
BACKGROUND = (243, 243, 243)
SEEN = f"async canvas => [await ({PICTURE})(canvas), canvas.strokes, canvas.texts, canvas.written]"  # of one frame
NOTE = """const kinds = [CanvasRenderingContext2D, Path2D], calls = ['beginPath', 'moveTo', 'lineTo'];
for (const kind of kinds) for (const name of calls) {
    const kept = kind.prototype[name];
    if (kept) kind.prototype[name] = function (...at) {
        if (name === 'beginPath') this.way = []; else (this.way ||= []).push(at);
        return kept.apply(this, at);
    };
}
const ink = CanvasRenderingContext2D.prototype, { stroke, fillText, clearRect } = ink;
ink.clearRect = function (...box) {
    Object.assign(this.canvas, { strokes: [], texts: [] });
    return clearRect.apply(this, box);
};
ink.stroke = function (...path) {
    this.canvas.strokes?.push([this.strokeStyle, (path[0] || this).way || []]);
    return stroke.apply(this, path);
};
ink.fillText = function (text, x, y) {
    this.canvas.texts?.push([text, this.textAlign, x, y]);
    return fillText.call(this, text, x, y);
};"""


@pytest.fixture(scope="module")
def noted(browser):  # noqa: F811
    """A page that notes what is drawn."""
    page = opened(browser)
    page.add_init_script(NOTE)
    return page


def painted(page, source, folder):
    """Open a page of a view; return for each canvas its strokes, texts, places of letters and image."""
    (folder / "view.html").write_text(source, encoding="utf-8")
    page.goto((folder / "view.html").as_uri())
    page.locator(".said div").first.wait_for()
    for canvas in page.locator("canvas").all():
        picture, *seen = canvas.evaluate(SEEN)
        image = Image.open(io.BytesIO(base64.b64decode(picture.split(",")[1])))
        yield *seen, Image.alpha_composite(Image.new("RGBA", image.size, BACKGROUND), image.convert("RGBA"))


def ways(strokes, colour):
    """Where lines of a colour were drawn, a list of arrays (n, 2)."""
    return [np.array([at[:2] for at in way], dtype=float) for drawn, way in strokes if drawn == colour and way]


SCENES = {
    "ac_table": lambda: view_machine.machine(load("ac_table")),
    "ac_head": lambda: view_machine.machine(load("ac_head")),
    "dmu50v": lambda: view_machine.machine(load("dmu50v")),
    "both": lambda: view_machine.tool_axis(load("dmu50v")),
    "walk": lambda: view_machine.walk(load("dmu50v"), blade()),
    "turns": lambda: view_rotation.turns((3, 4, 5), (135, 54.7356, -90)),
    "notations": view_rotation.notations,
    "gallery": lambda: view_gallery.gallery([load("bc_table"), load("head_b_table_c"), load("nutating_head")]),
}


@pytest.mark.parametrize("name", SCENES)
def test_the_browser_paints_the_still_picture(noted, name, tmp_path):
    """Lines and letters to a third of a pixel; solids, shades and what hides what over the whole picture."""
    made = SCENES[name]()
    canvases = list(painted(noted, made.page(), tmp_path))
    assert len(canvases) >= len(made.scenes) and not noted.errors
    for scene, (strokes, _, written, image) in zip(made.scenes, canvases, strict=False):
        sent = scene.state()  # as rounded for the page
        scene = replace(scene, middle=np.array(sent["middle"]), radius=sent["radius"])
        view = View(scene, image.size)
        for line in scene.lines:
            if line.parts:
                at = np.concatenate([view.pixels(line.body, np.asarray(part))[:, :2] for part in line.parts])
                drawn = np.concatenate(ways(strokes, line.colour))
                assert np.linalg.norm(at[:, None] - drawn, axis=-1).min(axis=1).max() < 0.3, f"{scene.title} {line}"
        letters = spread([view.pixels(label.body, label.at)[:2] for label in scene.labels], 20.0)
        assert np.reshape(written, (-1, 2)) == pytest.approx(np.reshape(letters, (-1, 2)), abs=0.3)
        still = View(scene, [FINE * side for side in image.size]).draw().resize(image.size, Image.Resampling.BOX)
        apart = np.abs(np.asarray(still, dtype=int) - np.asarray(image.convert("RGB"), dtype=int)).max(axis=-1)
        assert (apart > 60).mean() < SHARE


def scale(texts, axis, ticks, limits=(0, 1), log=False):
    """What the labels of an axis make of pixels, a function: in a straight line, right or up as the limits go."""
    named = {text: at for at, text in ticks}
    found = [(at, named[text]) for text, align, *at in texts if align == ALIGN[axis] and text in named]
    row = max(at[1] for at, _ in found)
    pixels, values = np.array(
        [(at[axis == "y"], v) for at, v in found if axis == "y" or at[1] == row], dtype=float
    ).T
    values = np.log10(values) if log else values
    slope, start = np.polyfit(pixels, values, 1)
    assert slope * pixels + start == pytest.approx(values, abs=1e-6 * np.ptp(values)), "labels at even distances"
    assert (slope > 0) == ((axis == "x") == (limits[0] < limits[1])), f"{axis} goes the other way"
    return lambda pixel: 10 ** (slope * pixel + start) if log else slope * pixel + start


def read_off(strokes, colour, x, y):
    """The curves of a colour as the labels tell them."""
    return [np.column_stack([x(way[:, 0]), y(way[:, 1])]) for way in ways(strokes, colour)]


def is_among(points, curves):
    off = 1e-6 * np.abs(points).max()
    return any(curve.shape == points.shape and np.abs(curve - points).max() < off for curve in curves)


def saved_charts(path):
    """The pages of a lesson's charts as they were saved, with today's program, and what they were made of."""
    cells = json.loads(path.read_text(encoding="utf-8"))["cells"]
    outputs = "".join("".join(o.get("data", {}).get("text/html", "")) for c in cells for o in c.get("outputs", []))
    for frame in re.findall("srcdoc='([^']*)'", outputs):
        head, _, rest = html.unescape(frame).partition("<script type=module>\n")
        rest = rest[rest.index(START) :]
        state, end = json.JSONDecoder().raw_decode(rest, len(START))
        if state["kind"] == "chart":
            program = "\n".join(_dense((HERE / name).read_text(encoding="utf-8")) for name in MODULES["chart"])
            yield (
                state,
                rest[end + 1 : rest.index(");\n</script>")],
                f"{head}<script type=module>\n{program}\n{rest}",
            )


def curves_at_start(page, state, functions):
    """Where the moving artists of a chart are at its start, arrays (n, 2)."""
    sliders = state["sliders"]
    if "frames" in state:
        number = 0  # of the frame; the last slider runs fastest
        for slider in sliders:
            positions = round((slider["high"] - slider["low"]) / slider["step"]) + 1
            number = number * positions + round((slider["value"] - slider["low"]) / slider["step"])
        for x, at in zip(state["x"], state["frames"][number], strict=True):
            yield np.column_stack([x, at]) if x else np.reshape(at, (-1, 2))
    else:
        q = [slider["value"] * slider["factor"] for slider in sliders]
        flat = page.evaluate(f"() => [...({functions})[0].points({q})]")
        yield from np.split(np.reshape(flat, (-1, 2)), np.cumsum(state["counts"])[:-1])


@pytest.mark.parametrize("path", CHARTS, ids=lambda path: path.stem)
def test_a_curve_is_read_off_as_what_it_was_made_of(noted, path, tmp_path):
    """Each chart of the lesson: by the labels of its axes every curve has its own points and colour."""
    for state, functions, source in saved_charts(path):
        canvases = list(painted(noted, source, tmp_path))
        moving = curves_at_start(noted, state, functions)
        for panel, (strokes, texts, *_) in zip(state["panels"], canvases, strict=True):
            if panel["drawn"]:
                x, y = (
                    scale(texts, axis, *(panel[axis][key] for key in ("ticks", "limits", "log"))) for axis in "xy"
                )
                turned = {text for text, _, *at in texts if at == [0, 0]}  # along the y axis
                assert turned == {panel["y"]["label"]} and panel["x"]["label"] in {text for text, *_ in texts}
            for artist in panel["artists"]:
                fixed = artist["points"] is not None
                points = np.array(np.reshape(artist["points"], (-1, 2)) if fixed else next(moving), dtype=float)
                points = points[np.isfinite(points).all(axis=1)]
                if artist.get("width") and len(points) > 1 and panel["drawn"]:
                    assert is_among(points, read_off(strokes, artist["colour"], x, y)), artist
        assert not noted.errors


def test_a_walk_draws_both_branches_and_the_true_tip(noted, tmp_path):
    """Against the kinematics: the curves as they are read off, and the way of the tip as it is projected."""
    kin, path = load("dmu50v"), blade()
    made = view_machine.walk(kin, path)
    canvases = list(painted(noted, made.page(), tmp_path))
    both = np.degrees(kin.inverse(path.points, path.axes)[..., 3:])
    for joint, (strokes, texts, *_) in enumerate(canvases[1:]):
        ticks = [(float(text), text) for text in (str(text) for text, *_ in texts)]
        x, y = (scale([(str(text), *rest) for text, *rest in texts], axis, ticks) for axis in "xy")
        for branch, role in enumerate(("first branch", "second branch")):
            (curve,) = read_off(strokes, COLOUR[role], x, y)
            assert curve[:, 0] == pytest.approx(np.arange(1, len(path) + 1))
            turns = (curve[:, 1] - both[:, branch, joint]) / 360
            assert turns == pytest.approx(np.round(turns), abs=1e-6)
    (line,) = [line for line in made.scenes[0].lines if line.name == "true tip"]
    tip = true_tip(kin, np.array(made.state["joints"]), samples=24)
    sent, strokes = made.scenes[0].state(), canvases[0][0]
    scene = replace(made.scenes[0], middle=np.array(sent["middle"]), radius=sent["radius"])
    at = View(scene, canvases[0][3].size).pixels(line.body, tip)[:, :2]
    drawn = np.concatenate(ways(strokes, line.colour))
    assert np.linalg.norm(at[:, None] - drawn, axis=-1).min(axis=1).max() < 0.3


def test_a_walk_in_a_part_draws_what_was_walked_and_what_was_cut(noted, tmp_path):
    """Against the kinematics: the path of the tip up to record 2.6, red where the tool is in a pillar."""
    kin, path = load("dmu50v"), blade()
    pillar = Part([ring([20, 55, height], [0, 0, 1], 10, 72) for height in (0, 100)], 3.0)
    made = view_machine.walk(kin, path, start=2.6, part=pillar)
    strokes, *_, image = next(painted(noted, made.page(), tmp_path))
    run, samples = made.state, np.arange(0, 1.6, 1 / SAMPLES)
    columns = np.transpose(run["joints"])
    joints = np.stack([np.interp([*samples, 1.6], np.arange(5), column) for column in columns], axis=1)
    sent = made.scenes[0].state()
    scene = replace(made.scenes[0], middle=np.array(sent["middle"]), radius=sent["radius"])
    at = View(scene, image.size).pixels("workpiece", kin.forward(joints)[0])[:, :2]
    inside = np.array(run["depth"][: len(samples)]) > 0.01
    assert 2 < inside.sum() < len(samples)
    tool = [np.concatenate(ways(strokes, colour)) for colour in (COLOUR["tool"], IN_THE_PART)]
    for drawn, wanted in zip(tool, (at, at[:-1][inside]), strict=True):
        apart = np.linalg.norm(wanted[:, None] - drawn, axis=-1)
        assert apart.min(axis=1).max() < 0.3
        half = np.linalg.norm(np.diff(wanted, axis=0), axis=1).max() / 2
        assert apart.min(axis=0).max() < half + 0.3, "and no more than that"
