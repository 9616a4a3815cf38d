"""Lessons as pages: pictures, formulas and views of a notebook arrive, and nobody is asked."""

import base64
import json
import re

import pytest

from mathpost.interface.site import lesson
from tests.conftest import LESSONS, ROOT
from tests.site.reader import Reader
from tests.test_browser import LIVE, lives, views_of

EMBEDDED = re.compile(r'src="data:image/png;base64,\s*([^"]+)"')


def pictures(notebook):
    """The PNG of every output and attachment of a notebook, that of a moving view too, as bytes."""
    for cell in notebook["cells"]:
        shown = [output.get("data", {}) for output in cell.get("outputs", [])]
        for data in shown + list(cell.get("attachments", {}).values()):
            if "image/png" in data:
                yield base64.b64decode("".join(data["image/png"]))
            yield from map(base64.b64decode, EMBEDDED.findall("".join(data.get("text/html", ""))))


@pytest.mark.parametrize("path", LESSONS, ids=lambda path: path.stem)
def test_every_picture_is_on_the_page_and_says_what_it_shows(site, path):
    page = (site / f"lessons/{path.stem}.html").read_text(encoding="utf-8")
    drawn = list(pictures(json.loads(path.read_text(encoding="utf-8"))))
    assert drawn, "a lesson has pictures"
    found = {base64.b64decode(data) for data in EMBEDDED.findall(page)}
    assert all(picture in found for picture in drawn)
    assert all(picture.startswith(b"\x89PNG") for picture in drawn)
    assert not re.findall(r"<img[^>]*\ssrc=\"(?!data:)([^\"]+)\"", page), "a page carries its pictures itself"
    assert all(len(text) > 5 for text in Reader(page).of("alt"))


@pytest.mark.parametrize("path", LESSONS, ids=lambda path: path.stem)
def test_a_page_has_its_formulas_and_no_solutions(site, path):
    page = (site / f"lessons/{path.stem}.html").read_text(encoding="utf-8")
    cells = json.loads(path.read_text(encoding="utf-8"))["cells"]
    formulas = sum("text/latex" in output.get("data", {}) for cell in cells for output in cell.get("outputs", []))
    assert page.count("<math") >= formulas
    assert "exercise.solution" not in re.sub("<[^>]+>", "", page)
    assert (site / f"lessons/{path.name}").read_bytes() == path.read_bytes()


def test_published_pages_move_without_a_network(offline, site):
    for name in LIVE:
        offline.goto((site / f"lessons/{name}.html").as_uri())
        assert offline.locator("details[open]").count() == 0, "what answers a guess is folded"
        assert "Write a guess in the place of None" not in offline.locator("body").inner_text()
        offline.evaluate("document.querySelectorAll('details').forEach(each => { each.open = true; })")
        cells = json.loads((ROOT / f"notebooks/{name}.ipynb").read_text(encoding="utf-8"))["cells"]
        assert all(view.moves() for view in lives(offline, views_of(cells)))
        formulas = offline.locator("math")
        written = "text/latex" in str(cells) or any(
            "$" in str(c["source"]) for c in cells if c["cell_type"] != "code"
        )
        assert (formulas.count() > 0) == written
        assert all(formulas.nth(n).bounding_box()["height"] > 5 for n in range(min(3, formulas.count())))
        assert "\\frac" not in offline.locator("body").inner_text()
    assert not offline.asked and not offline.errors


def test_what_a_lesson_says_of_itself():
    read = lesson.read(ROOT / "notebooks/13b_compensation_and_drift.ipynb", lesson.exporter())
    assert read.short == "13b · Compensation and drift: how a program makes up for errors"
    assert read.needs == ("05_inverse_and_selection", "06_singular_region", "13_systematic_errors")
    assert (read.minutes, len(read.goals)) == ("60", 3)


def test_a_picture_is_described_by_its_axes_and_names():
    numbers = (
        'picture with "X, mm", x "t"\n  Line2D "X" #7f7f7f: 200 points, at (-1, 2)\n  1 × Line2D #000000: 5 points'
    )
    shown = lesson.described({"metadata": {"image/png": {"alt": numbers}}})
    assert shown == 'picture with "X, mm", x "t"; it shows X'


def test_a_panel_of_the_workbench_leaves_its_sentence_and_no_style():
    body = lesson.read(ROOT / "notebooks/15_workbench.ipynb", lesson.exporter()).body
    assert body.count("it needs Python") == 7 and "<style>" not in body
