"""The published form: the README's command turns every lesson into a page that has all its pictures."""

import base64
import json
import re
import shlex
import subprocess
import sys

import pytest

from tests.conftest import ROOT

EMBEDDED = re.compile(r'src="data:image/png;base64,\s*([^"]+)"')
NOTEBOOKS = sorted((ROOT / "notebooks").glob("*.ipynb"))


@pytest.fixture(scope="module")
def pages(tmp_path_factory):
    """The folder of pages that the README's command makes."""
    lines = (ROOT / "README.md").read_text(encoding="utf-8").splitlines()
    (command,) = (line for line in lines if " nbconvert " in line and " html " in line)
    program, *arguments, pattern = shlex.split(command)
    assert (program, arguments[0], pattern) == (".venv/bin/jupyter", "nbconvert", "notebooks/*.ipynb")
    folder = tmp_path_factory.mktemp("html")
    where = arguments.index("--output-dir") + 1
    assert arguments[where] == "html"
    arguments[where] = str(folder)
    subprocess.run([sys.executable, "-m", *arguments, pattern], cwd=ROOT, check=True, capture_output=True)
    return folder


def pictures(notebook):
    """The PNG of every output and attachment of a notebook, that of a moving view too, as bytes."""
    for cell in notebook["cells"]:
        shown = [output.get("data", {}) for output in cell.get("outputs", [])]
        for data in shown + list(cell.get("attachments", {}).values()):
            if "image/png" in data:
                yield base64.b64decode("".join(data["image/png"]))
            yield from map(base64.b64decode, EMBEDDED.findall("".join(data.get("text/html", ""))))


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_every_picture_is_on_the_page(pages, path):
    page = (pages / f"{path.stem}.html").read_text(encoding="utf-8")
    drawn = list(pictures(json.loads(path.read_text(encoding="utf-8"))))
    assert drawn, "a lesson has pictures"
    found = {base64.b64decode(data) for data in EMBEDDED.findall(page)}
    assert all(picture in found for picture in drawn)
    assert all(picture.startswith(b"\x89PNG") for picture in drawn)
    links = re.findall(r"<img[^>]*\ssrc=\"(?!data:)([^\"]+)\"", page)
    assert not links, "a page carries its pictures itself"


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_links_between_lessons_stay_among_the_pages(pages, path):
    page = (pages / f"{path.stem}.html").read_text(encoding="utf-8")
    links = re.findall(r'href="([^":#]+\.(?:ipynb|html))["#]', page)
    assert not [link for link in links if link.endswith(".ipynb")]
    assert all((pages / link).exists() for link in links)


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_page_asks_nobody_and_has_its_formulas(pages, path):
    page = (pages / f"{path.stem}.html").read_text(encoding="utf-8")
    asked = re.findall(r"""<(?:script|link|img|iframe)[^>]*\s(?:src|href)=["'](https?:[^"']+)""", page)
    assert not asked and "cdnjs" not in page
    cells = json.loads(path.read_text(encoding="utf-8"))["cells"]
    formulas = sum("text/latex" in output.get("data", {}) for cell in cells for output in cell.get("outputs", []))
    assert page.count("<math") >= formulas
