"""Every lesson in a real browser: opened in JupyterLab and run, its sliders moved, its pictures seen to change."""

import os
import shutil
import socket
import subprocess
import sys
from pathlib import Path

import nbformat
import pytest

from tests.conftest import ROOT

CHROMIUM = Path("/usr/bin/chromium")
pytestmark = pytest.mark.skipif(not CHROMIUM.exists(), reason=f"no browser: {CHROMIUM} is not there")

NOTEBOOKS = sorted((ROOT / "notebooks").glob("*.ipynb"))
PICTURES = ROOT / ".artefacts/browser"  # screenshots, and the figures below; not in git
FLAGS = (
    "--headless --no-sandbox --disable-gpu --disable-quic --no-first-run --disable-background-networking "
    "--disable-component-update --disable-sync"
).split()
SETTINGS = {  # no news, and every cell in the page whether it is in sight or not
    "apputils-extension/notification": '{"fetchNews": "false", "checkForUpdates": false}',
    "notebook-extension/tracker": '{"windowingMode": "none"}',
}
PATIENCE = 120_000  # ms, for a busy machine

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
# From a key on the slider to the new picture decoded, in the page's own clock.
TIMED = """async ([handle, image]) => {
    handle.focus();
    const start = performance.now();
    const changed = new Promise(resolve => new MutationObserver((_, observer) => {
        observer.disconnect();
        image.decode().then(() => resolve(performance.now() - start));
    }).observe(image, {attributes: true, attributeFilter: ['src']}));
    const key = handle.getAttribute('aria-valuenow') == handle.getAttribute('aria-valuemax') ? 'Left' : 'Right';
    handle.dispatchEvent(new KeyboardEvent('keydown', {key: 'Arrow' + key, bubbles: true}));
    return await changed;
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
        path.write_text(content)
    places = {"JUPYTERLAB_SETTINGS_DIR": "settings", "JUPYTERLAB_WORKSPACES_DIR": "workspaces"}
    places |= {"JUPYTER_CONFIG_DIR": "config", "JUPYTER_DATA_DIR": "data", "JUPYTER_RUNTIME_DIR": "runtime"}
    environment = os.environ | {variable: str(folder / name) for variable, name in places.items()}
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    command = [sys.executable, "-m", "jupyterlab", "--no-browser", "--allow-root", "--ip=127.0.0.1"]
    command += [f"--port={port}", "--ServerApp.port_retries=0", "--IdentityProvider.token=course"]
    command += [f"--ServerApp.root_dir={folder / 'course'}", "--expose-app-in-browser"]
    log = folder / "server.log"
    server = subprocess.Popen(
        command, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True
    )
    try:
        said = []
        for line in server.stderr:
            said.append(line)
            if "is running at" in line:
                break
        else:
            pytest.fail("JupyterLab did not start:\n" + "".join(said))
        with log.open("w") as rest:  # so that the pipe never fills
            drain = subprocess.Popen(["cat"], stdin=server.stderr, stdout=rest)
            yield f"http://127.0.0.1:{port}/lab?token=course"
    finally:
        server.terminate()
        server.wait()
        server.stderr.close()
        drain.wait()


@pytest.fixture(scope="module")
def page(lab):
    """A page of the size of a projector, with JupyterLab in it; errors of its console are in `page.errors`."""
    playwright = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    with playwright.sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        page = browser.new_page(viewport={"width": 1024, "height": 768})
        page.set_default_timeout(PATIENCE)
        page.errors = []
        page.on("console", lambda message: message.type == "error" and page.errors.append(message.text))
        page.on("pageerror", lambda error: page.errors.append(str(error)))
        page.goto(lab)
        page.wait_for_function("window.jupyterapp !== undefined")
        page.evaluate("async () => { await window.jupyterapp.restored; }")
        page.evaluate("() => window.jupyterapp.shell.collapseLeft()")
        PICTURES.mkdir(parents=True, exist_ok=True)
        yield page
        browser.close()


@pytest.fixture(scope="module", params=NOTEBOOKS, ids=lambda path: path.stem)
def lesson(request, page):
    """A lesson that has been run in the page: its name, the panel's selector and the code cells."""
    page.errors.clear()
    ran = page.evaluate(RUN, f"notebooks/{request.param.name}")
    yield request.param, f"#{ran['id']}", ran["code"]
    page.evaluate(CLOSE, ran["id"])


def views(page, panel):
    """The views of a lesson: boxes that hold sliders and a picture."""
    return page.locator(f"{panel} .widget-vbox:has(.noUi-handle):has(img.widget-image)")


def test_every_cell_runs_and_the_console_is_silent(lesson, page):
    path, panel, cells = lesson
    assert all(cell["execution_count"] for cell in cells)
    failed = [output["evalue"] for cell in cells for output in cell["outputs"] if output["output_type"] == "error"]
    assert not failed
    page.locator(f"{panel} .jp-Notebook").screenshot(path=PICTURES / f"{path.stem}.png")
    assert not page.errors


def test_every_slider_changes_its_picture(lesson, page):
    path, panel, _ = lesson
    found = views(page, panel)
    expected = sum("View(" in str(cell.get("outputs")) for cell in nbformat.read(path, 4).cells)
    assert found.count() == expected
    if not expected:
        pytest.skip("does not apply: a lesson without sliders")
    for number in range(expected):
        view = found.nth(number)
        picture, handle = view.locator("img.widget-image"), view.locator(".noUi-handle").first
        handle.scroll_into_view_if_needed()
        times = [page.evaluate(TIMED, [handle.element_handle(), picture.element_handle()]) for _ in range(7)]
        with (PICTURES / "slider_to_picture.txt").open("a") as figures:
            print(f"{path.stem} view {number + 1}: {sorted(times)[3]:.0f} ms (median of 7)", file=figures)
        view.screenshot(path=PICTURES / f"{path.stem}_view_{number + 1}.png")
    assert not page.errors


def test_an_exercise_tells_wrong_from_right(page):
    """The first exercise of lesson 01, typed in by hand: the point turned for the frame, then right."""
    page.errors.clear()
    panel = page.evaluate(RUN, "notebooks/01_rotating_a_point.ipynb")["id"]
    stub = page.locator(f"#{panel} .jp-Notebook-cell:has(.jp-InputArea)", has_text="coordinates_after_alpha = None")
    number = stub.evaluate("cell => [...cell.parentElement.children].indexOf(cell)")
    answer, check, solved = (page.locator(f"#{panel} .jp-Notebook-cell").nth(number + step) for step in (0, 1, 2))
    solutions = page.locator(f"#{panel} details pre")
    solved.get_by_text("Solution of 01-sign: you have not tried yet", exact=True).wait_for()
    assert solutions.count() >= 3
    assert not any(solution.is_visible() for solution in solutions.all())
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
    assert solved.locator("pre").is_visible()
    solved.screenshot(path=PICTURES / "exercise_solution.png")
    assert not page.errors
    page.evaluate(CLOSE, panel)


def test_sliders_are_in_five_lessons_at_least():
    assert sum("View(" in path.read_text(encoding="utf-8") for path in NOTEBOOKS) >= 5
