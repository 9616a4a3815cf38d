"""The index of the search: every page divided at its headings, as one script that a browser loads from a disk.

The text is not split into words: the page looks for exactly what was typed, so that 五轴 and ``--axis-tolerance``
are found inside longer words.
"""

import json
import re
from dataclasses import dataclass, field
from html.parser import HTMLParser

DIVIDES = {"h1", "h2", "h3", "h4", "section", "tr", "div"}  # if they have an id
SILENT = {"script", "style", "svg", "nav", "annotation"}


@dataclass
class Section:
    """The text between one element with an id and the next."""

    anchor: str  # the id
    heading: str
    words: list[str] = field(default_factory=list)


class Sections(HTMLParser):
    """The text of a page, from one element with an id to the next."""

    def __init__(self) -> None:
        super().__init__()
        self.found = [Section("", "")]
        self.heading = ""
        self.silent: list[str] = []

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        """Begin a section, or an element that is not read."""
        given = dict(attributes)
        if self.silent or tag in SILENT or "source" in (given.get("class") or "").split():
            self.silent += [tag] if not self.silent or tag == self.silent[0] else []
            return
        if tag in DIVIDES and (anchor := given.get("id")):
            title = given.get("data-title", "" if tag.startswith("h") else anchor)
            self.found.append(Section(anchor, title or ""))
            self.heading = tag if tag.startswith("h") else ""
        if alternative := given.get("alt"):
            self.found[-1].words.append(alternative)

    def handle_endtag(self, tag: str) -> None:
        """End a heading, or an element that is not read."""
        if self.silent and tag == self.silent[0]:
            self.silent.pop()
        if tag == self.heading:
            self.heading = ""

    def handle_data(self, data: str) -> None:
        """Keep text."""
        if self.silent:
            return
        if self.heading:
            self.found[-1].heading += data
        self.found[-1].words.append(data)


def sections(url: str, title: str, page: str) -> list[list[str]]:
    """Return the sections of a page: address, title of the page, heading, text."""
    parser = Sections()
    parser.feed(page)
    made = []
    for part in parser.found:
        text = re.sub(r"\s+", " ", "".join(part.words)).strip()
        if text:
            made.append([f"{url}#{part.anchor}" if part.anchor else url, title, part.heading.strip(), text])
    return made


def script(found: list[list[str]]) -> str:
    """Return the index as JavaScript: a page opened from a disk may load scripts, but no data."""
    rows = ",\n".join(json.dumps(row, ensure_ascii=False, separators=(",", ":")) for row in found)
    return f"const SECTIONS = [\n{rows}\n];\n"
