"""The site from a disk, without a network: lessons, links, search, keyboard, phone, paper, and what axe-core finds.

One file, so that one process builds the pages once.
"""

import base64
import json
import re
import sys
from importlib import metadata
from pathlib import Path
from unittest.mock import Mock
from urllib.parse import unquote

import nbformat
import pytest
from playwright.sync_api import expect

from mathpost.detective.causes import CAUSES
from mathpost.interface.shell.main import COMMANDS, main
from mathpost.interface.site import commands, sources
from mathpost.teaching.course.exercise import EXERCISES
from tests.conftest import DATA, LESSONS, ROOT
from tests.site.reader import Reader
from tests.test_browser import LIVE, lives, opened, views_of

KINDS = (  # a page of each
    "index.html", "lessons/index.html", "lessons/01_rotating_a_point.html", "machines/index.html",
    "machines/dmu50v.html", "commands/index.html", "commands/post.html", "reference/index.html",
    "reference/mathpost.kinematics.html", "search.html?q=gimbal lock", "authors.html", "teaching.html",
)  # fmt: skip
# Of elements whose tags, classes and styles are alike up to the root, axe looks at the contrast of the first alone.
FIRST = """() => {
    const seen = new Set();
    for (const each of document.querySelectorAll('*')) {
        const text = [...each.childNodes].map(one => one.nodeType == 3 ? one.data : '').join('').trim();
        let path = `${each.checkVisibility()} ${Math.min(2, text.length)}`;  // a single character is not judged
        for (let one = each; one; one = one.parentElement) {
            path += `${one.tagName} ${one.getAttribute('class')} ${one.getAttribute('style')}>`;
        }
        each.toggleAttribute('data-first', !seen.has(path));
        seen.add(path);
    }
    axe.configure({ rules: [{ id: 'color-contrast', selector: '[data-first]' }] });
}"""
EMBEDDED = re.compile(r'src="data:image/png;base64,\s*([^"]+)"')
HEAVY = re.compile(r" srcdoc='[^']*'|data:image/png;base64,[^\"]*")  # views are pages of their own


@pytest.fixture(scope="module")
def pages(site):
    """Every page by its path, without the views and pictures that it carries."""
    return {
        path: HEAVY.sub("", path.read_text(encoding="utf-8"))
        for path in sorted(site.rglob("*.html"))
        if "_static" not in path.parts
    }


def test_every_link_leads_to_a_file_and_a_place_of_the_site(pages):
    read = {path: Reader(text) for path, text in pages.items()}
    broken = []
    for path, reader in read.items():
        for link in reader.of("href", "src", "action"):
            if re.match("https?:|data:", link):
                continue
            name, _, anchor = unquote(link).partition("#")
            name = name.partition("?")[0]
            target = Path(path.parent, name).resolve() if name else path
            if not target.is_file() or (anchor and anchor not in read[target].of("id")):
                broken.append((path.name, link))
    assert not broken
    links = [(path.parent, unquote(link)) for path in read for link in read[path].of("href", "action")]
    linked = {Path(folder, link.partition("#")[0]).resolve() for folder, link in links}
    assert {path.name for path in pages if path not in linked} <= {"genindex.html", "py-modindex.html"}


def test_no_page_fetches_anything_from_elsewhere(pages):
    fetched = re.compile(
        r"""<(?:script|link|img|iframe|source|form)[^>]*\s(?:src|href|action)=["'](?:https?:|//)"""
    )
    assert [path.name for path, text in pages.items() if fetched.search(text)] == []


@pytest.mark.parametrize("query", ["五轴", "gimbal lock", "--axis-tolerance"])
def test_the_search_finds(offline, site, query):
    """五轴 stands in the lessons within longer runs of characters only."""
    offline.errors.clear()
    offline.goto((site / "lessons/index.html").as_uri())
    offline.keyboard.press("Control+k")
    offline.locator("input[type=search]:focus").fill(query)
    offline.keyboard.press("Enter")
    offline.locator("ul.search a").first.click()
    offline.wait_for_url(re.compile("(lessons|commands|reference)/"))
    expect(offline.locator("main")).to_contain_text(query, ignore_case=True)
    assert not offline.asked and not offline.errors


@pytest.mark.parametrize("query", ["xyzzy", "轴五"])
def test_the_search_says_that_there_is_nothing(offline, site, query):
    offline.goto((site / "search.html").as_uri() + f"?q={query}")
    offline.get_by_text("did not match any documents").wait_for()


def test_axe_finds_nothing_serious(browser, site):
    """In light colours by all rules; in dark ones nothing but the contrasts is different."""
    axe = pytest.importorskip("axe_playwright_python", reason="axe-core is not installed")
    rules = (Path(axe.__file__).parent / "axe.min.js").read_text(encoding="utf-8")
    page, found = opened(browser), {}
    for kind in KINDS:
        page.goto(f"{site.as_uri()}/{kind}")
        for frame in page.frames:  # the views, too
            frame.evaluate(rules)
            frame.evaluate(FIRST)
        for scheme, only in (("light", ""), ("dark", ", runOnly: ['color-contrast']")):
            page.emulate_media(color_scheme=scheme, reduced_motion="reduce")
            said = page.evaluate(f"axe.run(document, {{ preload: false, resultTypes: ['violations']{only} }})")[
                "violations"
            ]
            for each in said:
                if each["impact"] in ("serious", "critical"):
                    found[kind, scheme, each["id"]] = [node["html"][:120] for node in each["nodes"]]
    page.close()
    assert found == {}


def test_the_keyboard_reaches_text_search_and_sliders(offline, site):
    offline.goto((site / "index.html").as_uri())
    offline.keyboard.press("Tab")
    expect(offline.locator(":focus")).to_have_text("Skip to main content")
    offline.keyboard.press("Enter")
    expect(offline).to_have_url(re.compile("#main-content$"))
    (view,) = lives(offline, 1)
    before = view.said()
    slider = view.frame.locator("input[type=range]:focus")
    for _ in range(15):  # a key pressed while the page is still busy may be lost
        offline.keyboard.press("Tab")
        if slider.count():
            break
    expect(slider).to_be_visible()
    offline.keyboard.press("ArrowRight")
    offline.keyboard.press("ArrowRight")
    # It is drawn, and said, with the next frame.
    expect(view.frame.locator(".said")).not_to_have_text(before, use_inner_text=True)


@pytest.mark.parametrize("kind", KINDS)
def test_a_phone_need_not_scroll_sideways(offline, site, kind):
    offline.set_viewport_size({"width": 360, "height": 740})
    offline.goto(f"{site.as_uri()}/{kind}")
    assert offline.evaluate("document.documentElement.scrollWidth") <= 360
    offline.set_viewport_size({"width": 1280, "height": 720})


def test_paper_has_the_still_picture_of_a_view(offline, site):
    offline.goto((site / "lessons/05_inverse_and_selection.html").as_uri())
    offline.emulate_media(media="print")
    expect(offline.locator(".mathpost-live iframe").first).to_be_hidden()
    expect(offline.locator(".mathpost-live img").first).to_be_visible()
    expect(offline.locator("header.bd-header")).to_be_hidden()
    offline.emulate_media(media="screen")


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


def test_a_lesson_opens_elsewhere_only_where_the_project_is(tmp_path, monkeypatch):
    monkeypatch.setattr(commands, "read", lambda folder: [])
    nbformat.write(
        nbformat.v4.new_notebook(cells=[nbformat.v4.new_markdown_cell("# 01\n\ntext")]), tmp_path / "01.ipynb"
    )

    def head(*addresses):
        monkeypatch.setattr(metadata, "metadata", lambda name: Mock(get_all=lambda *_: addresses))
        made = next(text for name, text in sources.pages(tmp_path, tmp_path) if name == "lessons/01.ipynb")
        return nbformat.reads(made, 4).cells[0].source

    with_links = head("Homepage, https://example.org", "Repository, https://github.com/somebody/course/")
    assert with_links.startswith("# 01\n\n<p") and with_links.endswith("text")
    assert "https://colab.research.google.com/github/somebody/course/blob/main/notebooks/01.ipynb" in with_links
    assert "https://mybinder.org/v2/gh/somebody/course/main?labpath=notebooks/01.ipynb" in with_links
    assert "Colab" not in head() + head("Repository, https://example.org/course")


def test_a_panel_of_the_workbench_leaves_its_sentence(site):
    assert (site / "lessons/15_workbench.html").read_text(encoding="utf-8").count("it needs Python") == 7


def test_every_command_has_an_example_that_runs_and_all_its_options(site):
    assert [name for name in COMMANDS if "example" not in commands.TOLD[name]] == ["site"], "these pages"
    for name in COMMANDS:
        page = (site / f"commands/{name}.html").read_text(encoding="utf-8")
        assert set(re.findall(r"Exit status (\d)", page)) <= {"0", "1"}, name
        assert "Traceback" not in page and "expected" not in page.split("All it takes")[0]
    post = (site / "commands/post.html").read_text(encoding="utf-8")
    assert (
        'id="cmdoption-mathpost-post-axis-tolerance"' in post
        and "of the tool axis; default 0.1<" in post
        and "BEGIN PGM BLADE MM" in post
    )


def test_the_page_for_teachers_has_every_mixup_by_frequency(site):
    shown = (site / "teaching.html").read_text(encoding="utf-8").split('id="what-students-get-wrong-and-why"')[1]
    rows = shown.count("<tr") - shown.count("<thead")
    assert rows == len(CAUSES) + sum(len(each.slips) for each in EXERCISES.values())
    assert shown.index(CAUSES["reversed"]["mixup"]) < shown.index(CAUSES["origin"]["mixup"])


def test_every_machine_has_a_page(site):
    names = {path.stem for path in (DATA / "machines").glob("*.toml")} | {"index"}
    assert {path.stem for path in (site / "machines").glob("*.html")} == names


def test_the_reference_has_what_the_package_offers(site):
    import mathpost

    page = (site / "reference/index.html").read_text(encoding="utf-8")
    for name in mathpost.__all__:
        made = getattr(mathpost, name)
        assert f'href="{made.__module__}.html#{made.__module__}.{made.__name__}"' in page
    assert "Returns" in (site / "reference/mathpost.kinematics.html").read_text(encoding="utf-8")


def test_a_folder_without_notebooks_is_refused(tmp_path, capsys):
    assert main(["site", str(tmp_path), "-o", str(tmp_path / "html")]) == 2
    assert "expected a folder of notebooks" in capsys.readouterr().err
    assert not (tmp_path / "html").exists()


def test_the_map_has_a_curve_for_each_need(site):
    page = (site / "lessons/index.html").read_text(encoding="utf-8")
    drawn = page.partition("<svg aria-hidden")[2].partition("</svg>")[0]
    lessons = [sources.read(path) for path in sorted((ROOT / "notebooks").glob("*.ipynb"))]
    assert drawn.count("h0") == len(lessons) and drawn.count("C") == sum(len(each.needs) for each in lessons)
    rows = [each.name for each in lessons]
    for need, lesson in (("01_rotating_a_point", "02_euler_angles_and_frames"), ("04_transform_chain", "07_blade")):
        start, end = (10 * rows.index(name) + 5 for name in (need, lesson))
        assert re.search(rf'd="M30 {start}C[\d.]+ {start} [\d.]+ {end} 30 {end}"', drawn), "from row to row"


def test_the_site_and_the_readme_have_the_same_lessons(site):
    course = (site / "lessons/index.html").read_text(encoding="utf-8")
    listed = [name for name in re.findall(r'<li><a href="([\w]+)\.html"', course)]
    assert listed == [path.stem for path in sorted((ROOT / "notebooks").glob("*.ipynb"))]


def test_a_folder_of_somebody_else_needs_no_form_and_links_to_what_was_built(tmp_path, monkeypatch):
    """A notebook that says nothing of itself is listed; the lessons in the browser only where they are."""
    monkeypatch.setattr(commands, "read", lambda folder: [])
    nbformat.write(nbformat.v4.new_notebook(), tmp_path / "empty.ipynb")
    cells = [nbformat.v4.new_markdown_cell("# Mine\n\n$x^2$"), nbformat.v4.new_code_cell("not python (")]
    nbformat.write(nbformat.v4.new_notebook(cells=cells), tmp_path / "mine.ipynb")
    made = dict(sources.pages(tmp_path, tmp_path / "html"))
    assert "[Mine](mine.ipynb)" in made["lessons/index.md"] and "# empty" in made["lessons/empty.ipynb"]
    assert "lite/index.html" not in made["index.md"]
    (tmp_path / "html/lite").mkdir(parents=True)
    (tmp_path / "html/lite/index.html").touch()
    assert "lite/index.html" in dict(sources.pages(tmp_path, tmp_path / "html"))["index.md"]


def test_without_sphinx_it_says_what_to_install(monkeypatch, tmp_path, capsys):
    monkeypatch.setitem(sys.modules, "sphinx.cmd.build", None)
    assert main(["site", str(ROOT / "notebooks"), "-o", str(tmp_path / "html")]) == 2
    assert 'pip install -e ".[site]"' in capsys.readouterr().err
