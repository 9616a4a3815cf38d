"""The site from a disk, without a network: links, search, keyboard, phone, paper, and what axe-core finds."""

import re
import sys
from pathlib import Path
from urllib.parse import unquote

import nbformat
import pytest
from playwright.sync_api import expect

from mathpost.detective.causes import CAUSES
from mathpost.interface.shell.main import COMMANDS, main
from mathpost.interface.site import commands, course_map, sources
from mathpost.teaching.course.exercise import EXERCISES
from tests.conftest import DATA, ROOT
from tests.site.reader import Reader
from tests.test_browser import lives, opened

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


@pytest.mark.parametrize(
    "line", ["from mathpost.nowhere import x", "from mathpost.no.where import x", "from . import x"]
)
def test_a_lesson_that_names_a_module_which_is_not_there_has_no_reference_of_it(line):
    def read(*lines):
        cells = [nbformat.v4.new_code_cell(each) for each in lines]
        return sources.modules([sources.Lesson("a", nbformat.v4.new_notebook(cells=cells))])

    assert read(line, "from mathpost.shop.plane import pose") == read("from mathpost.shop.plane import pose")


def test_a_folder_without_notebooks_is_refused(tmp_path, capsys):
    assert main(["site", str(tmp_path), "-o", str(tmp_path / "html")]) == 2
    assert "expected a folder of notebooks" in capsys.readouterr().err
    assert not (tmp_path / "html").exists()


def test_the_map_has_a_curve_for_each_need_and_none_for_others():
    drawn = course_map.svg([("a", ()), ("b", ("a",)), ("c", ("a", "b", "elsewhere"))])
    assert drawn.count("C") == 3 and drawn.count("h0") == 3
    assert 'd="M30 5C' in drawn and "30 25" in drawn, "from the middle of the first row to that of the last"


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
