"""A panel in JupyterLab: files dropped, a number changed, run, downloaded; then without its kernel, reopened."""

import shutil
from pathlib import Path

import pytest
from playwright.sync_api import expect

from mathpost.shell import main
from mathpost.workbench.drop import LARGEST
from mathpost.workbench.panel import SENTENCE
from tests.conftest import DATA
from tests.test_browser import CLOSE, CLOSE_ONLY, PICTURES, browser, lab, page, reopen, run  # noqa: F401, fixtures

RESTART = """async id => {
    const panel = [...window.jupyterapp.shell.widgets('main')].find(widget => widget.id == id);
    await panel.sessionContext.session.kernel.restart();
}"""


@pytest.fixture
def by_hand(tmp_path):
    """What the shell writes on a machine file that was changed by hand, as bytes."""
    text = (DATA / "machines/dmu50v.toml").read_text(encoding="utf-8")
    (tmp_path / "mine.toml").write_text(text.replace("limits = [0, 180]", "limits = [-25, 180]"), encoding="utf-8")
    words = [f"{DATA / 'cl/blade.cl'}", "--machine", f"{tmp_path / 'mine.toml'}", "-o", f"{tmp_path / 'blade.h'}"]
    assert main.main(["post", *words]) == 0
    return (tmp_path / "blade.h").read_bytes()


@pytest.fixture
def hand_ins(tmp_path):
    """A folder of a class: two workbooks at the top, one in a folder, one file of more than a message may hold."""
    (tmp_path / "class/late").mkdir(parents=True)
    for name in ("right.xlsx", "lucky.xlsx", "late/right.xlsx"):
        shutil.copy(DATA / "workbooks" / Path(name).name, tmp_path / "class" / name)
    (tmp_path / "class/photo.png").write_bytes(bytes(12 * 2**20))
    return tmp_path / "class"


def drop(zone, *paths):
    """Drop files and folders as a file manager does."""
    zone.scroll_into_view_if_needed()
    box = zone.bounding_box()
    place = {"x": box["x"] + 20, "y": box["y"] + 20}
    mouse = zone.page.context.new_cdp_session(zone.page)
    data = {"items": [], "files": list(map(str, paths)), "dragOperationsMask": 1}
    for kind in ("dragEnter", "dragOver", "drop"):
        mouse.send("Input.dispatchDragEvent", {"type": kind, "data": data, **place})
    mouse.detach()


def test_a_panel_in_jupyterlab(page, by_hand, hand_ins):  # noqa: F811
    notebook, _ = run(page, "15_workbench")
    panel = page.locator(".mathpost-panel").first
    sentence = page.locator(f"#{notebook} .mathpost-sentence").first
    choose = panel.get_by_role("button", name="Drop a file, or choose one: cl")
    page.locator(".mathpost-drop").last.wait_for(state="attached")  # no cell takes the keys any more
    with page.expect_file_chooser() as chooser:
        choose.press("Enter")
    chooser.value.set_files(DATA / "cl/blade.cl")
    panel.get_by_role("button", name="remove blade.cl").wait_for()
    panel.get_by_text("Travel, rates and accelerations").click()
    cell = panel.get_by_label("B from, °")
    cell.fill("-25")
    cell.press("Tab")
    expect(sentence).to_be_hidden()
    panel.get_by_role("button", name="Run", exact=True).press("Enter")
    panel.locator(".mathpost-said.right").wait_for()
    link = panel.locator("a.mathpost-download", has_text="blade.h")
    with page.expect_download() as download:
        link.press("Enter")
    assert download.value.path().read_bytes() == by_hand
    page.screenshot(path=PICTURES / "workbench_post.png")

    check = page.locator(".mathpost-panel").nth(1)
    zone = check.locator(".mathpost-drop.several")
    drop(zone, hand_ins, DATA / "workbooks/lucky.xlsx")
    zone.get_by_text("5 files came").wait_for()
    axe = pytest.importorskip("axe_playwright_python", reason="axe-core is not installed")
    page.evaluate((Path(axe.__file__).parent / "axe.min.js").read_text(encoding="utf-8"))
    assert page.evaluate("axe.run('.mathpost-drop')")["violations"] == []
    zone.get_by_role("button", name="remove class/lucky.xlsx").press("Enter")
    zone.get_by_role("button", name="remove class/lucky.xlsx").wait_for(state="detached")
    expect(zone.get_by_title("remove").and_(page.locator(":focus"))).to_have_count(1)  # the next one has the keys
    check.get_by_role("button", name="Run", exact=True).click()
    check.get_by_text("3 workbooks: 2 right, 1 wrong").wait_for()
    expect(check.locator("summary span:first-child")).to_have_text(
        ["file", "class/late/right.xlsx", "class/right.xlsx", "lucky.xlsx"]
    )
    zone.get_by_role("button", name="Remove all: path").click()
    expect(zone.locator("li")).to_have_count(0)
    expect(check.get_by_label("path", exact=True)).to_have_value("")
    large = hand_ins / "large.xlsx"
    with large.open("wb") as file:
        file.truncate(LARGEST + 1)
    drop(zone, large)
    zone.get_by_text("large.xlsx: expected at most 100 MB a file").wait_for()
    page.screenshot(path=PICTURES / "workbench_check.png")

    page.evaluate(RESTART, notebook)
    sentence.wait_for()
    expect(panel).to_be_hidden()
    page.evaluate(CLOSE, notebook)
    notebook = reopen(page, "15_workbench")
    sentences = page.locator(f"#{notebook} .mathpost-sentence")
    expect(sentences).to_have_text([SENTENCE] * 7)
    expect(page.get_by_text("Error displaying widget").and_(page.locator(":visible"))).to_have_count(0)
    page.evaluate(CLOSE_ONLY, notebook)
