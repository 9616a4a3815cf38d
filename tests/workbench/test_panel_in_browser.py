"""A panel in JupyterLab: a file uploaded, a number changed, run, downloaded; then without its kernel, reopened."""

import pytest

from mathpost.shell import main
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


def test_a_panel_in_jupyterlab(page, by_hand):  # noqa: F811
    notebook, _ = run(page, "15_workbench")
    panel = page.locator(".mathpost-panel").first
    sentence = page.locator(f"#{notebook} .mathpost-sentence").first
    with page.expect_file_chooser() as chooser:
        panel.get_by_role("button", name="Upload").first.click()
    chooser.value.set_files(DATA / "cl/blade.cl")
    panel.get_by_role("button", name="Upload (1)").wait_for()
    panel.get_by_text("Travel, rates and accelerations").click()
    cell = panel.get_by_label("B from, °")
    cell.fill("-25")
    cell.press("Tab")
    assert not sentence.is_visible()
    start = panel.get_by_role("button", name="Run", exact=True)
    start.focus()
    page.keyboard.press("Enter")
    panel.locator(".mathpost-said.right").wait_for()
    link = panel.locator("a.mathpost-download", has_text="blade.h")
    link.focus()
    with page.expect_download() as download:
        page.keyboard.press("Enter")
    assert download.value.path().read_bytes() == by_hand
    page.screenshot(path=PICTURES / "workbench_post.png")

    page.evaluate(RESTART, notebook)
    sentence.wait_for()
    assert not panel.is_visible()
    page.evaluate(CLOSE, notebook)
    notebook = reopen(page, "15_workbench")
    sentences = page.locator(f"#{notebook} .mathpost-sentence")
    sentences.first.wait_for()
    assert {each.inner_text() for each in sentences.all()} == {SENTENCE}
    assert not page.get_by_text("Error displaying widget").and_(page.locator(":visible")).count()
    page.evaluate(CLOSE_ONLY, notebook)
