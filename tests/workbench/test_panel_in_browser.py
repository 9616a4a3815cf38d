"""A panel in JupyterLab: files uploaded, a number changed, run, downloaded; then without its kernel, reopened."""

import zipfile
from pathlib import Path

import pytest
from playwright.sync_api import expect

from mathpost.interface.shell import main
from mathpost.interface.workbench.panel import SENTENCE
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
    """A folder of a class as a zip: two workbooks, one of them in a folder."""
    with zipfile.ZipFile(tmp_path / "class.zip", "w") as packed:
        for name in ("lucky.xlsx", "late/right.xlsx"):
            packed.write(DATA / "workbooks" / Path(name).name, name)
    return tmp_path / "class.zip"


def test_a_panel_in_jupyterlab(page, by_hand, hand_ins):  # noqa: F811
    notebook, _ = run(page, "15_workbench")
    panel = page.locator(".mathpost-panel").first
    sentence = page.locator(f"#{notebook} .mathpost-sentence").first
    page.locator(".mathpost-panel .widget-upload").last.wait_for(state="attached")  # no cell takes keys any more
    with page.expect_file_chooser() as chooser:
        panel.get_by_role("button", name="Upload cl").press("Enter")
    chooser.value.set_files(DATA / "cl/blade.cl")
    expect(panel.get_by_label("cl", exact=True)).to_have_value("blade.cl")
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
    with page.expect_file_chooser() as chooser:
        check.get_by_role("button", name="Upload path").press("Enter")
    chooser.value.set_files([hand_ins, DATA / "workbooks/right.xlsx"])
    expect(check.get_by_label("path", exact=True)).to_have_value("2 files")
    axe = pytest.importorskip("axe_playwright_python", reason="axe-core is not installed")
    page.evaluate((Path(axe.__file__).parent / "axe.min.js").read_text(encoding="utf-8"))
    assert page.evaluate("axe.run('.mathpost-panel .widget-upload')")["violations"] == []
    check.get_by_role("button", name="Run", exact=True).click()
    check.get_by_text("3 workbooks: 2 right, 1 wrong").wait_for()
    expect(check.locator("summary span:first-child")).to_have_text(
        ["file", "class/late/right.xlsx", "class/lucky.xlsx", "right.xlsx"]
    )
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
