"""Make the site: page by page, each in the same frame, and a search index of them all."""

import re
import shutil
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from html import unescape
from importlib import metadata
from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from pygments.formatters import HtmlFormatter

from mathpost import machine
from mathpost.errors import InputError
from mathpost.files import data_file, read_text, write_text
from mathpost.interface.site import commands, course_map, lesson, reference, search, teaching
from mathpost.kinematics import Kinematics
from mathpost.teaching.course import machine_page, view_machine

TEMPLATES = Path(__file__).parent / "templates"
CONTENTS = re.compile(r'<h2 id="([^"]+)">(.*?)</h2>|<(?:section|div class="classattr") id="([^"]+)">', re.DOTALL)
HEADING = re.compile(r"<h([2-4])>(.*?)</h\1>", re.DOTALL)
TABLE = re.compile(r"<table.*?</table>", re.DOTALL)
PRE = re.compile(r"<pre(?=[ >])")
FORMULA = re.compile(r'<math(?= [^>]*display="block").*?</math>', re.DOTALL)
TAG = re.compile(r"<[^>]+>")
FRONT = "dmu50v"  # the machine on the front page
TEXTS = {  # pages of Markdown, relative to the lessons, and their titles
    "TEACHING.md": "Teach with it",
    "AUTHORS.md": "Write a lesson",
    "../.github/CONTRIBUTING.md": "Contribute, report",
    "../CHANGELOG.md": "What changed",
}
LITE = "lite"  # the folder of the lessons that run in the browser, if they were built there


@dataclass(frozen=True)
class Page:
    """A page without its frame."""

    url: str  # in the folder, with /
    title: str
    body: str  # HTML
    toc: bool = False  # whether it lists its headings

    @property
    def root(self) -> str:
        """The relative path to the top of the folder."""
        return "../" * self.url.count("/")


class Site:
    """Everything that the pages are made from, read once."""

    def __init__(self, folder: Path, output: Path) -> None:
        paths = sorted(folder.glob("*.ipynb"))
        if not paths:
            raise InputError(f"{folder}", "a folder of notebooks", "none")
        made = lesson.exporter()
        self.folder = folder
        self.lessons = [lesson.read(path, made) for path in paths]
        self.version = metadata.version("mathpost")
        self.texts = [(name, page_of(name), title) for name, title in TEXTS.items() if (folder / name).exists()]
        self.lite = (output / LITE / "index.html").exists()
        self.jinja = Environment(
            loader=FileSystemLoader(TEMPLATES), autoescape=True, undefined=StrictUndefined, trim_blocks=True,
            lstrip_blocks=True,
        )  # fmt: skip
        self.jinja.filters |= {"inline": inline, "markdown": lesson.markdown}

    @cached_property
    def machines(self) -> dict[str, Kinematics]:
        """The machines that come with the package, by the names of their files."""
        paths = sorted(data_file("machines").glob("*.toml"))
        return {path.stem: Kinematics(machine.load(path)) for path in paths}

    @cached_property
    def commands(self) -> list[commands.Command]:
        """The commands, with their examples run."""
        return commands.read(self.folder)

    def filled(self, template: str, **values: Any) -> str:
        """Return a template filled in."""
        return self.jinja.get_template(f"{template}.html.j2").render(site=self, **values)

    def pages(self) -> Iterator[Page]:
        """Yield all pages except the search."""
        front = view_machine.machine(self.machines[FRONT])._repr_html_()
        yield Page("index.html", "Five-axis kinematics and post-processing", self.filled("front", view=front))
        chart = course_map.svg([(each.name, each.needs) for each in self.lessons])
        yield Page("lessons/index.html", "The course", self.filled("course", chart=chart))
        neighbours = zip([None, *self.lessons], self.lessons, [*self.lessons[1:], None], strict=False)
        for before, each, after in neighbours:
            body = self.filled("lesson", lesson=each, before=before, after=after)
            yield Page(f"lessons/{each.name}.html", each.title, body, toc=True)
        yield Page("machines/index.html", "Machines", self.filled("machines"))
        for name, kin in self.machines.items():
            head, tail = machine_page.around(kin)
            body = f"{head}{view_machine.machine(kin)._repr_html_()}{tail}"
            yield Page(f"machines/{name}.html", kin.machine.name, body)
        yield Page("commands/index.html", "Commands", self.filled("commands"))
        for command in self.commands:
            yield Page(f"commands/{command.name}.html", command.name, self.filled("command", command=command))
        shown = reference.pages(reference.modules(cell for each in self.lessons for cell in each.code))
        yield Page("reference/index.html", "Reference", self.filled("reference", modules=shown))
        for name, (_, body) in shown.items():
            yield Page(f"reference/{name.replace('.', '/')}.html", name, body, toc=True)
        for name, url, title in self.texts:
            body = text(self.folder / name)
            if teaching.MARK in body:
                body = body.replace(teaching.MARK, teaching.mixups(self.lessons))
            yield Page(url, title, body, toc=True)


def build(folder: Path, output: Path) -> None:
    """Write the site of a folder of lessons into the folder `output`."""
    site, found = Site(folder, output), []
    for page in site.pages():
        body = scrolling(anchored(page.body))
        found += search.sections(page.url, page.title, body)
        write(site, output, page, body)
    write(site, output, Page("search.html", "Search", ""), site.filled("search"))
    write_text(output / "search-index.js", search.script(found))
    for name in ("site.css", "search.js"):
        write_text(output / name, read_text(TEMPLATES / name).replace("/* code */", colours()))
    for each in site.lessons:
        shutil.copyfile(each.path, output / f"lessons/{each.name}.ipynb")


def write(site: Site, output: Path, page: Page, body: str) -> None:
    """Write a page in the common frame."""
    places = CONTENTS.findall(body) if page.toc else []
    contents = [(anchor or member, unescape(TAG.sub("", heading)) or member) for anchor, heading, member in places]
    path = output / page.url
    path.parent.mkdir(parents=True, exist_ok=True)
    write_text(path, site.filled("page", page=page, body=body, contents=contents))


def anchored(body: str) -> str:
    """Return HTML whose headings have an id, made of their words."""
    taken: set[str] = set()

    def named(match: re.Match[str]) -> str:
        level, heading = match.groups()
        words = re.sub(r"\W+", "-", unescape(TAG.sub("", heading)).lower()).strip("-") or "part"
        anchor = next(a for n in range(len(taken) + 1) if (a := f"{words}-{n}" if n else words) not in taken)
        taken.add(anchor)
        return f'<h{level} id="{anchor}">{heading}</h{level}>'

    return HEADING.sub(named, body)


def scrolling(body: str) -> str:
    """Return HTML whose wide tables, lines and formulas scroll in a box of their own, by the keyboard too."""
    body = PRE.sub('<pre tabindex="0"', body)
    body = FORMULA.sub(lambda formula: f'<span class="formula" tabindex="0">{formula[0]}</span>', body)
    return TABLE.sub(lambda table: f'<div class="wide" tabindex="0">{table[0]}</div>', body)


def text(path: Path) -> str:
    """Return a page of Markdown as HTML."""
    linked = re.sub(r"\]\(([^):/]+)\.ipynb\)", r"](lessons/\1.html)", read_text(path))
    return lesson.markdown(re.sub(r"\]\(([\w./]+\.md)\)", lambda match: f"]({page_of(match[1])})", linked))


def page_of(name: str) -> str:
    """Return the page's name for a Markdown file."""
    return f"{Path(name).stem.lower()}.html"


def inline(text: str) -> str:
    """Return a line of Markdown as HTML without its paragraph."""
    return lesson.markdown(text).strip().removeprefix("<p>").removesuffix("</p>")


def colours() -> str:
    """Return the colours of code, for light and dark."""
    light, dark = (HtmlFormatter(style=style).get_style_defs(".highlight") for style in ("default", "github-dark"))
    return f"{light}\n@media screen and (prefers-color-scheme: dark) {{\n{dark}\n}}"
