"""The course in a browser: in JupyterLab, reopened without a kernel, and its machines; for its pages see site/."""

import contextlib
import json
import os
import re
import shutil
import socket
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from playwright.sync_api import expect, sync_playwright

from mathpost.files import write_text
from mathpost.path import cl
from mathpost.teaching.course import machine_page, view_globe, view_machine, view_path
from mathpost.teaching.course.view_machine import SAMPLES
from mathpost.teaching.draw.part import Part
from mathpost.teaching.draw.solid import ring
from tests.conftest import DATA, LESSONS, ROOT, runs_all

CHROMIUM = Path("/usr/bin/chromium")
PICTURES = ROOT / ".artefacts/browser"  # screenshots; not in git
FLAGS = (
    "--headless --no-sandbox --disable-gpu --disable-quic --no-first-run --disable-background-networking "
    "--disable-component-update --disable-sync"
).split()
SETTINGS = {  # no news, and every cell in the page whether it is in sight or not
    "apputils-extension/notification": '{"fetchNews": "false", "checkForUpdates": false}',
    "notebook-extension/tracker": '{"windowingMode": "none"}',
}
PATIENCE = 120_000  # ms, for a busy machine
# JupyterLab's own: of what opens without a kernel, and of what is closed before it has answered.
NO_SESSION = "Cannot read properties of null (reading 'kernel')"
CLOSED = re.compile("(Could not restore the debugger state: )?Canceled future for |Disposed")

# Lessons with views; all are run before any is opened without a kernel, which the same page then hears of.
LIVE = [path.stem for path in LESSONS if "mathpost-live" in path.read_text(encoding="utf-8")]
NOT_TRUSTED = "sent_by_mail"  # the first of them, not signed here
RUN = """async path => {
    const app = window.jupyterapp;
    await app.restored;
    const panel = await app.commands.execute('docmanager:open', {path, factory: 'Notebook'});
    await panel.context.ready;
    await panel.sessionContext.ready;
    await panel.sessionContext.session.kernel.info;
    app.shell.activateById(panel.id);
    await app.commands.execute('notebook:run-all-cells');
    const cells = panel.content.model.sharedModel.cells.map(cell => cell.toJSON());
    return {id: panel.id, code: cells.filter(cell => cell.cell_type == 'code')};
}"""
CLOSE = """async id => {
    const app = window.jupyterapp;
    const panel = [...app.shell.widgets('main')].find(widget => widget.id == id);
    await panel.sessionContext.shutdown();
    await panel.context.save();
    panel.dispose();
}"""
# Opened as it was saved, without a kernel.
REOPEN = """async path => {
    const app = window.jupyterapp;
    const kernelPreference = {shouldStart: false, canStart: false, autoStartDefault: false};
    const panel = await app.commands.execute('docmanager:open', {path, factory: 'Notebook', kernelPreference});
    await panel.context.ready;
    app.shell.activateById(panel.id);
    return panel.id;
}"""
CLOSE_ONLY = """async id => {
    const app = window.jupyterapp;
    [...app.shell.widgets('main')].find(widget => widget.id == id).dispose();
}"""
# How much of a lesson's first picture is seen before one scrolls, 0 to 1.
FIRST = """async picture => {
    const seen = picture.closest('.jp-WindowedPanel-outer').getBoundingClientRect();
    await picture.decode();
    const { top, bottom } = (picture.closest('.mathpost-live') ?? picture).getBoundingClientRect();
    return (Math.min(bottom, seen.bottom) - Math.max(top, seen.top)) / (bottom - top);
}"""
PICTURE = """canvas => new Promise(done =>
    requestAnimationFrame(() => requestAnimationFrame(() => done(canvas.toDataURL()))))"""

# The first column of pixels that is drawn for more than half of its length: the left edge of a panel.
LEFT = """canvas => {
    const { width, height } = canvas, { data } = canvas.getContext('2d').getImageData(0, 0, width, height);
    const drawn = x => Array.from({ length: height }, (_, y) => data[4 * (y * width + x) + 3]).filter(Boolean);
    return Array.from({ length: width }, (_, x) => x).find(x => drawn(x).length > height / 2);
}"""


@pytest.fixture(scope="module")
def lab(tmp_path_factory):
    """A JupyterLab of its own on a copy of the course; its address."""
    folder = tmp_path_factory.mktemp("lab")
    for name in ("notebooks", "data"):
        shutil.copytree(ROOT / name, folder / "course" / name)
    shutil.copy(ROOT / "environment.txt", folder / "course")
    for name, content in SETTINGS.items():
        path = folder / "settings/@jupyterlab" / f"{name}.jupyterlab-settings"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(content, encoding="utf-8")
    places = {"JUPYTERLAB_SETTINGS_DIR": "settings", "JUPYTERLAB_WORKSPACES_DIR": "workspaces"}
    places |= {"JUPYTER_CONFIG_DIR": "config", "JUPYTER_DATA_DIR": "data", "JUPYTER_RUNTIME_DIR": "runtime"}
    environment = os.environ | {variable: str(folder / name) for variable, name in places.items()}
    lessons = [folder / "course/notebooks" / path.name for path in LESSONS]
    subprocess.run([sys.executable, "-m", "jupyter", "trust", *lessons], env=environment, check=True)
    foreign = json.loads(lessons[0].read_text(encoding="utf-8"))
    foreign["metadata"]["title"] = "as somebody else sent it"
    lessons[0].with_stem(NOT_TRUSTED).write_text(json.dumps(foreign), encoding="utf-8")
    command = [sys.executable, "-m", "jupyterlab", "--no-browser", "--allow-root", "--ip=127.0.0.1"]
    command += ["--port=0", "--IdentityProvider.token=course"]  # a port that is free
    command += [f"--ServerApp.root_dir={folder / 'course'}", "--expose-app-in-browser"]
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.PIPE, "text": True}
    with subprocess.Popen(command, env=environment, **quiet) as server:
        said = []
        for line in server.stderr:
            said.append(line)
            if found := re.search(r"http://127\.0\.0\.1:(\d+)/lab", line):
                break
        else:
            pytest.fail("JupyterLab did not start:\n" + "".join(said))
        while server.poll() is None:  # it says its address before it listens there
            with contextlib.suppress(ConnectionRefusedError), socket.create_connection(("127.0.0.1", found[1])):
                break
            time.sleep(0.05)
        with (folder / "server.log").open("w") as log, subprocess.Popen(["cat"], stdin=server.stderr, stdout=log):
            try:  # the pipe never fills
                yield f"{found[0]}?token=course"
            finally:
                server.terminate()


@pytest.fixture(scope="module")
def browser():
    if not CHROMIUM.exists():
        pytest.skip(f"no browser: {CHROMIUM} is not there")
    expect.set_options(timeout=PATIENCE)
    with sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        PICTURES.mkdir(parents=True, exist_ok=True)
        yield browser
        browser.close()


def opened(browser):
    """A page with the errors of its console in `page.errors`."""
    page = browser.new_page(viewport={"width": 1280, "height": 720})
    page.set_default_timeout(PATIENCE)
    page.errors, page.kernelless = [], False

    def fault(error):
        if not CLOSED.match(error.removeprefix("Error: ")) and not (page.kernelless and NO_SESSION in error):
            page.errors.append(error)

    page.on("console", lambda message: message.type == "error" and fault(message.text))
    page.on("pageerror", lambda error: fault(str(error)))
    return page


@pytest.fixture(scope="module")
def page(browser, lab):
    """JupyterLab on the screen of a small laptop."""
    page = opened(browser)
    page.goto(lab)
    page.wait_for_function("window.jupyterapp !== undefined")
    page.evaluate("async () => { await window.jupyterapp.restored; }")
    page.evaluate("() => window.jupyterapp.shell.collapseLeft()")
    return page


@pytest.fixture(scope="module")
def offline(browser):
    """A page that may ask nobody; what it asked for all the same is in `page.asked`."""
    page = opened(browser)
    page.asked = []
    page.route("http*://**", lambda route: (page.asked.append(route.request.url), route.abort()))
    return page


def run(page, name):
    """Open a lesson with a kernel and run all of it; return the panel's id and the code cells."""
    page.errors.clear()
    ran = page.evaluate(RUN, f"notebooks/{name}.ipynb")
    return ran["id"], ran["code"]


def reopen(page, name):
    """Open a lesson as it was saved, without a kernel; return the panel's id."""
    page.errors.clear()
    page.kernelless = True
    return page.evaluate(REOPEN, f"notebooks/{name}.ipynb")


class Live:
    """A view that moves: its iframe, seen by the numbers that it says and by its picture."""

    def __init__(self, frame):
        self.outside = hasattr(frame, "content_frame") and frame.element_handle()  # not looked for at every step
        self.frame = self.outside.content_frame() if self.outside else frame
        self.frame.locator(".said div").first.wait_for()

    def said(self):
        return self.frame.locator(".said").inner_text()

    def picture(self):
        """All pictures after the next frame, as text; out of sight, a browser draws no frames."""
        if self.outside:
            self.outside.evaluate("frame => frame.scrollIntoView({block: 'center'})")
        return [canvas.evaluate(PICTURE) for canvas in self.frame.locator("canvas").all()]

    def press(self, name):
        self.frame.get_by_role("button", name=name, exact=True).click()

    def set(self, name, value):
        box = self.frame.locator("label", has_text=name).locator("input[type=number]").first
        box.fill(str(value))
        box.press("Enter")

    def moves(self):
        """Whether a key on every slider in sight changes numbers or picture, and one on some slider both."""
        changed, before = [], (self.said(), self.picture())
        for slider in self.frame.locator("input[type=range]:visible").all():
            slider.press("Arrow" + slider.evaluate("one => one.valueAsNumber < Number(one.max) ? 'Right' : 'Left'"))
            now = self.said(), self.picture()
            changed.append([new != old for new, old in zip(now, before, strict=True)])
            before = now
        return all(map(any, changed)) and any(map(all, changed))


def lives(place, count):
    """The live views in a page or in a panel, which come as it is rendered."""
    frames = place.locator(".mathpost-live iframe")
    expect(frames).to_have_count(count)
    return [Live(frames.nth(number)) for number in range(count)]


def views_of(cells):
    """How many views the outputs of a notebook's cells hold."""
    return sum("mathpost-live" in str(cell.get("outputs")) for cell in cells)


def numbers(text):
    return [float(x) for x in re.findall(r"-?\d+\.\d+", text)]


def says_00(view):
    """Lesson 00: what stays when a button is pressed."""
    view.set("B", 60)
    before = view.said()
    view.press("other solution")
    assert view.said().splitlines()[0] == before.splitlines()[0], "neither tip nor tool axis"
    assert float(view.frame.locator("input[type=number]").nth(3).input_value()) == -60.0
    assert "B -60.000° is outside 0 … 180" in view.said()
    view.frame.locator("label", has_text="RTCP").locator("input").check()
    view.set("B", 20)
    assert view.said().splitlines()[0].split(",")[0] == before.split(",")[0], "the tip stays"
    view.press("pole")
    assert "0.00° from singular" in view.said()


def says_01(view):
    """Lesson 01: the numbers of the source's angles."""
    for name, angle in (("alpha", 135), ("beta", 54.7356), ("gamma", -90)):
        view.set(name, angle)
    assert "x' = -1.224744, y' = 0.707107, z' = 6.928203" in view.said()


def says_02(view):
    """Lesson 02: two notations, two locks."""
    for name, angle in (("I", 135), ("J", 0), ("K", -90)):
        view.set(name, angle)
    assert "G68.2: I 45.000, J 0.000, K 0.000 (locked)" in view.said() and view.said().count("locked") == 1
    view.set("J", 90)
    view.set("K", 90)
    assert view.said().count("SPB -90.000, SPC 0.000 (locked)") == 1 and "J 90.000, K 90.000\n" in view.said()


def says_04(view):
    """Lesson 04: the head at home."""
    view.press("home")
    assert "tip 0.000 0.000 48.000, tool axis 0.0000 0.0000 1.0000" in view.said()


def exercises_01(page, panel):
    """Lesson 01: its first exercise, typed in by hand, tells wrong (the point turned for the frame) from right."""
    stub = page.locator(f"#{panel} .jp-Notebook-cell:has(.jp-InputArea)", has_text="coordinates_after_alpha = None")
    number = stub.evaluate("cell => [...cell.parentElement.children].indexOf(cell)")
    answer, check, solved = (page.locator(f"#{panel} .jp-Notebook-cell").nth(number + step) for step in (0, 1, 2))
    solutions = page.locator(f"#{panel} details pre")
    solved.get_by_text("Solution of 01-sign: you have not tried yet", exact=True).wait_for()
    assert solutions.count() >= 3
    expect(solutions.and_(page.locator(":visible"))).to_have_count(0)
    for typed, said in (
        ("[-4, 3, 5]", "01-sign · not yet. This turns the point"),
        ("[4, -3, 5]", "01-sign · right."),
    ):
        answer.locator(".cm-content").click()
        page.keyboard.press("Control+A")
        page.keyboard.insert_text(f"coordinates_after_alpha = {typed}")
        page.keyboard.press("Shift+Enter")
        page.keyboard.press("Shift+Enter")
        check.locator(".jp-OutputArea-output", has_text=said).wait_for()
        check.screenshot(path=PICTURES / f"exercise_{said.split()[2].strip('.')}.png")
    solved.get_by_text("Solution of 01-sign", exact=True).click()  # what it says of an attempt has changed
    expect(solved.locator("pre").nth(1)).to_be_visible()
    expect(solved.locator("pre").first).to_be_hidden()  # the hint stays closed
    solved.screenshot(path=PICTURES / "exercise_solution.png")


SAYS = {"00": says_00, "01": says_01, "02": says_02, "04": says_04}  # of the last view of the lesson


def pytest_generate_tests(metafunc):
    """Run here, too, is the lesson whose exercise is typed in, and all by --hypothesis-profile=many.

    What the others show when they are run is compared with what they hold by their own tests (nbval).
    """
    if "run_here" in metafunc.fixturenames:
        chosen = [path for path in LESSONS if runs_all(metafunc.config) or path.stem.startswith("01")]
        metafunc.parametrize("run_here", chosen, ids=lambda path: path.stem)


def test_a_lesson_lives_with_a_kernel(page, run_here):
    """Run, saved and shut down: every cell, every view and the console."""
    panel, cells = run(page, run_here.stem)
    assert all(cell["execution_count"] for cell in cells)
    assert not [o["evalue"] for cell in cells for o in cell["outputs"] if o["output_type"] == "error"]
    if run_here.stem.startswith("01"):
        exercises_01(page, panel)
    assert all(view.moves() for view in lives(page.locator(f"#{panel}"), views_of(cells)))
    expect(page.locator(".Toastify__toast")).to_have_count(0)  # nobody asks about news
    page.locator(f"#{panel} .jp-Notebook").screenshot(path=PICTURES / f"{run_here.stem}.png")
    assert not page.errors
    page.evaluate(CLOSE, panel)


def test_a_lesson_that_is_not_trusted_shows_the_still_picture(page):
    """Opened for the first time, before it is run: JupyterLab takes the scripts away."""
    panel = reopen(page, NOT_TRUSTED)
    picture = page.locator(f"#{panel} .mathpost-live img")
    picture.scroll_into_view_if_needed()
    picture.evaluate("picture => picture.decode()")
    expect(page.locator(f"#{panel} .mathpost-live iframe[srcdoc]")).to_have_count(0)
    box = picture.bounding_box()
    assert box["width"] > 400 and box["height"] > 300
    assert "tip 0.000 0.000 24.000, tool axis" in picture.get_attribute("alt")
    page.screenshot(path=PICTURES / "not_trusted.png")
    page.evaluate(CLOSE_ONLY, panel)


@pytest.mark.parametrize("path", LESSONS, ids=lambda path: path.stem)
def test_a_lesson_lives_without_a_kernel(page, path, of):
    """Opened as it was saved: every view and the console, and what the text says.

    That each view moves is seen on the pages of the site; here the last one does, or all of them.
    """
    panel = reopen(page, path.stem)
    first = page.locator(f"#{panel} .jp-OutputArea-output img").first.evaluate(FIRST)
    assert first > 0.5, "the first screen shows the lesson's question"
    again = lives(page.locator(f"#{panel}"), views_of(json.loads(path.read_text(encoding="utf-8"))["cells"]))
    assert all(view.moves() for view in of(again[-1:], again))
    assert "model not found" not in page.locator(f"#{panel}").inner_text()
    lesson = path.stem.split("_")[0]
    if lesson in SAYS:
        SAYS[lesson](again[-1])
    for number, view in enumerate(of([], again), 1):
        view.outside.screenshot(path=PICTURES / f"{path.stem}_view_{number}.png")
    assert not page.errors
    page.evaluate(CLOSE_ONLY, panel)


def test_every_machine_says_in_the_browser_what_python_says(offline, kin, tmp_path):
    """The page's own printed functions against NumPy, at its start and at a pose that is typed in."""
    path = tmp_path / "machine.html"
    write_text(path, machine_page.page(kin))
    offline.goto(path.as_uri())
    view = Live(offline)
    assert view.said().strip() in repr(view_machine.machine(kin))
    joints = np.array([12.5, -30.25, 41.125, 17.75, 63.5])
    for name, value in zip(kin.machine.joint_names, joints, strict=True):
        view.set(name, value)
    tip, axis = kin.forward(joints, degrees=True)
    shown = numbers(view.said())
    assert shown[:3] == pytest.approx(tip, abs=6e-4) and shown[3:6] == pytest.approx(axis, abs=6e-5)
    before = view.said().splitlines()[0]
    view.press("other solution")
    assert view.said().splitlines()[0] == before
    offline.locator("label", has_text="RTCP").locator("input").check()
    for rotary, angle in zip(kin.machine.rotary, (-25.5, 140.25), strict=True):
        view.set(rotary.name, angle)
        assert numbers(view.said())[:3] == pytest.approx(tip, abs=6e-4), "the tip is kept"
    assert not offline.asked and not offline.errors


def test_views_of_paths_move_too(offline, dmu50v, blade, tmp_path):
    """Both solutions, and a walk: play, step, and what is said at the largest swing."""
    both, walk = view_machine.tool_axis(dmu50v), view_machine.walk(dmu50v, blade)
    for name, made in (("both", both), ("walk", walk)):
        (tmp_path / f"{name}.html").write_text(made.page(still=True), encoding="utf-8")
        offline.goto((tmp_path / f"{name}.html").as_uri())
        view = Live(offline)
        assert view.moves()
        if name == "both":
            view.set("tilt", 120)
            assert view.said().count("out of reach") == 2
            continue
        view.set("record", 3)
        assert view.said().count("tip 0.0000 mm and axis 0.000° off the CL data") == len(made.scenes)
        view.press("largest swing")
        assert float(view.said().split("tip ")[1].split()[0]) > 70  # source 002: C swings by 180° about 77 mm
        view.press("+ step")
        assert float(offline.locator("input[type=number]").input_value()) == pytest.approx(2.55)
        view.set("record", -7)
        assert float(offline.locator("input[type=number]").input_value()) == 1, "a walk stays on its path"
        view.press("largest swing")
        view.press("play")
        offline.wait_for_function("document.querySelector('input[type=number]').value > 2.7")
        view.press("pause")
    assert not offline.asked and not offline.errors


def test_a_number_outside_of_its_slider_is_taken_at_the_end(offline, dmu50v, blade, tmp_path):
    """In every kind of view the box shows what is used, and no formula is asked where it does not hold."""
    views = [view_globe.globe(), view_path.clamped([20, 24, 150, 153]), view_path.past_the_pole(dmu50v)]
    views += [view_machine.machine(dmu50v), view_machine.tool_axis(dmu50v), view_machine.walk(dmu50v, blade)]
    for made in views:
        (tmp_path / "view.html").write_text(made.page(), encoding="utf-8")
        offline.goto((tmp_path / "view.html").as_uri())
        view = Live(offline)
        for slider, box in zip(made.state["sliders"], offline.locator("input[type=number]").all(), strict=True):
            for end, typed in (("high", "1e6"), ("low", "-1e6")):
                box.fill(typed)
                box.press("Enter")
                assert float(box.input_value()) == pytest.approx(slider[end], abs=6e-4)
                assert "NaN" not in view.said() and "Infinity" not in view.said()
    assert not offline.errors


def test_panels_above_each_other_have_the_same_left_edge(offline, dmu50v, tmp_path):
    (tmp_path / "view.html").write_text(view_path.past_the_pole(dmu50v).page(), encoding="utf-8")
    offline.goto((tmp_path / "view.html").as_uri())
    Live(offline).picture()
    first, second = (canvas.evaluate(LEFT) for canvas in offline.locator("canvas").all())
    assert first == second > 0


def test_a_long_walk_is_exact_at_every_record(offline, dmu50v, tmp_path):
    path = cl.read(DATA / "cl/twisted_blade.cl")
    walk = view_machine.walk(dmu50v, cl.from_arrays(path.points[:1000], path.axes[:1000]))
    (tmp_path / "walk.html").write_text(walk.page(still=True), encoding="utf-8")
    offline.goto((tmp_path / "walk.html").as_uri())
    view = Live(offline)
    view.set("record", 789)
    assert "tip 0.0000 mm and axis 0.000° off" in view.said() and not offline.errors


def test_a_walk_says_where_the_tool_is_in_a_part(offline, dmu50v, blade, tmp_path):
    """Nothing of the path is drawn before it is walked; the depth is that of the tool as it is sampled."""
    pillar = Part([ring([20, 55, height], [0, 0, 1], 10, 72) for height in (0, 100)], 3.0)
    walk = view_machine.walk(dmu50v, blade, start=2.0, part=pillar)
    (tmp_path / "walk.html").write_text(walk.page(still=True), encoding="utf-8")
    offline.goto((tmp_path / "walk.html").as_uri())
    view = Live(offline)
    assert "in the part" not in view.said()
    depth = walk.state["depth"]
    into = next(number for number, deep in enumerate(depth) if deep > 0.01)
    view.set("record", 1 + into / SAMPLES)
    assert f"the tool is {depth[into]:.2f} mm in the part" in view.said()
    view.press("in the part")
    assert f"the tool is {max(depth):.2f} mm in the part" in view.said()
    assert not offline.asked and not offline.errors


def test_a_small_screen_shows_picture_and_sliders_together(offline, dmu50v, tmp_path):
    (tmp_path / "machine.html").write_text(view_machine.machine(dmu50v).page(still=True), encoding="utf-8")
    for width, height in ((980, 440), (520, 440), (390, 650)):
        offline.set_viewport_size({"width": width, "height": height})
        offline.goto((tmp_path / "machine.html").as_uri())
        Live(offline)
        for part in ("canvas", ".slider:last-of-type", ".said div"):
            box = offline.locator(part).first.bounding_box()
            assert box["x"] >= 0 and box["y"] >= 0 and box["x"] + box["width"] <= width + 1
            assert box["y"] + box["height"] <= height + 1, f"{part} is cut off at {width} × {height}"
    offline.set_viewport_size({"width": 1280, "height": 720})


def test_names_of_axes_do_not_cover_each_other(offline, kin, tmp_path):
    (tmp_path / "machine.html").write_text(view_machine.machine(kin).page(still=True), encoding="utf-8")
    offline.goto((tmp_path / "machine.html").as_uri())
    view = Live(offline)
    view.picture()
    places = np.array(offline.evaluate("document.querySelector('canvas').written"))
    apart = np.linalg.norm(places[:, None] - places, axis=-1)[np.triu_indices(len(places), 1)]
    assert apart.min() > 13, "letters of 14 pixels"
