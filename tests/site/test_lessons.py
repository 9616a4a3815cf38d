"""Lessons as pages: pictures, formulas and views of a notebook arrive, and nobody is asked."""

import base64
import json
import re

import nbformat
import pytest

from mathpost.interface.site import sources
from tests.conftest import LESSONS, ROOT
from tests.site.reader import Reader
from tests.test_browser import LIVE, lives, views_of

EMBEDDED = re.compile(r'src="data:image/png;base64,\s*([^"]+)"')


def pictures(notebook):
    """The PNG of every output of a notebook, that of a moving view too, as bytes."""
    for cell in notebook["cells"]:
        for data in (output.get("data", {}) for output in cell.get("outputs", [])):
            if "image/png" in data:
                yield base64.b64decode("".join(data["image/png"]))
            yield from map(base64.b64decode, EMBEDDED.findall("".join(data.get("text/html", ""))))


@pytest.mark.parametrize("path", LESSONS, ids=lambda path: path.stem)
def test_a_page_has_the_pictures_and_formulas_of_its_lesson_and_no_solutions(site, path):
    page = (site / f"lessons/{path.stem}.html").read_text(encoding="utf-8")
    notebook = json.loads(path.read_text(encoding="utf-8"))
    drawn, read = set(pictures(notebook)), Reader(page)
    files = [site / "lessons" / source for source in read.of("src") if "_images" in source]
    assert drawn and drawn == {base64.b64decode(data) for data in EMBEDDED.findall(page)} | {
        each.read_bytes() for each in files
    }
    assert all(len(text) > 5 for text in read.of("alt"))
    outputs = [output.get("data", {}) for cell in notebook["cells"] for output in cell.get("outputs", [])]
    assert page.count("<math") >= sum("text/latex" in data for data in outputs)
    assert "exercise.solution" not in re.sub("<[^>]+>", "", page)
    assert (site / f"lessons/{path.name}").read_bytes() == path.read_bytes()


def test_published_pages_move_without_a_network(offline, site):
    for name in LIVE:
        offline.goto((site / f"lessons/{name}.html").as_uri())
        assert "Write a guess in the place of None" not in offline.locator("body").inner_text()
        offline.evaluate("document.querySelectorAll('details').forEach(each => { each.open = true; })")
        cells = json.loads((ROOT / f"notebooks/{name}.ipynb").read_text(encoding="utf-8"))["cells"]
        assert all(view.moves() for view in lives(offline, views_of(cells)))
        formulas = offline.locator("math")
        assert all(formulas.nth(n).bounding_box()["height"] > 5 for n in range(min(3, formulas.count())))
        assert "\\frac" not in offline.locator("body").inner_text()
    assert not offline.asked and not offline.errors


def test_what_a_lesson_says_of_itself():
    read = sources.read(ROOT / "notebooks/13b_compensation_and_drift.ipynb")
    assert read.title.startswith("13b · Compensation and drift: how a program makes up for errors (")
    assert read.needs == ["05_inverse_and_selection", "06_singular_region", "13_systematic_errors"]
    assert (read.minutes, len(re.findall("^- ", read.goals, re.MULTILINE))) == ("60", 3)


def test_a_picture_is_described_by_its_axes_and_names():
    numbers = (
        'picture with "X, mm", x "t"\n  Line2D "X" #7f7f7f: 200 points, at (-1, 2)\n  1 × Line2D #000000: 5 points'
    )
    shown = sources.described({"metadata": {"image/png": {"alt": numbers}}})
    assert shown == 'picture with "X, mm", x "t"; it shows X'


def test_a_lesson_opens_elsewhere_only_where_the_project_is():
    lesson = sources.Lesson("01", nbformat.v4.new_notebook(cells=[nbformat.v4.new_markdown_cell("# 01\n\ntext")]))
    assert sources.page(lesson, "head").cells[0].source == "# 01\n\nhead\n\ntext"
    (_, colab), (_, binder) = sources.elsewhere("https://github.com/somebody/course/", "01")
    assert colab == "https://colab.research.google.com/github/somebody/course/blob/main/notebooks/01.ipynb"
    assert binder == "https://mybinder.org/v2/gh/somebody/course/main?labpath=notebooks/01.ipynb"
    assert sources.elsewhere("", "01") == sources.elsewhere("https://example.org/course", "01") == []


def test_a_panel_of_the_workbench_leaves_its_sentence(site):
    assert (site / "lessons/15_workbench.html").read_text(encoding="utf-8").count("it needs Python") == 7
