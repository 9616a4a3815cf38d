"""Subprograms of the same text, and jumps to lines that come later.

A function here takes the reader (`mathpost.shop.controls.reader`), which runs the lines. Nothing is run in a
circle: calls are bounded in depth and in the lines that they run in all.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from mathpost.shop.controls.lines import tool_name

if TYPE_CHECKING:
    from mathpost.shop.controls.reader import ProgramReader

DEEPEST = 8  # calls within calls
MOST_LINES = 200_000  # that calls run in all
LONGEST = 40  # characters of a name that may be a number
# Where a word goes, by its meaning: how a line begins that has a name.
LABELS = {
    "call O": r"[O:]0*(\d+)",
    "call N": r"N0*(\d+)",
    "call LBL": r"\d*\s*LBL\s+\"?([^\"]*?)\"?\s*(?:;|$)",
    "jump N": r"N0*(\d+)",
    "jump label": r"(?:N\d+\s*)?(\w+):",
}


def _labels(texts: list[str], meaning: str) -> dict[str, list[int]]:
    """The numbers of the lines that have each name."""
    found: dict[str, list[int]] = {}
    for number, text in enumerate(texts, 1):
        if match := re.match(LABELS[meaning], text):
            name = match[1] if meaning == "jump label" or len(match[1]) > LONGEST else tool_name(match[1])
            found.setdefault(name, []).append(number)
    return found


def go(reader: ProgramReader, meaning: str, values: tuple[str, ...]) -> None:
    """Run a subprogram of the same text, or jump to a line that comes later."""
    name = values[0] if meaning == "jump label" else tool_name(values[0])
    if meaning not in reader.labels:
        reader.labels[meaning] = _labels(reader.texts, meaning)
    places = reader.labels[meaning].get(name, [])
    if len(places) != 1:
        raise reader.error(f"one line in the program that begins as {name}", f"{len(places)}")
    if meaning.startswith("jump"):
        if reader.depth or places[0] <= reader.line:
            raise reader.error("a jump to a later line, and from no subprogram", f"one to line {places[0]}")
        reader.awaited = places[0]
        return
    count = float(values[1]) if len(values) > 1 else 1.0
    body = _section(reader, places[0])
    reader.called += int(count * len(body))
    if reader.depth == DEEPEST or reader.called > MOST_LINES or count != int(count) or count < 1:
        limits = f"calls within calls, at most {DEEPEST}, that run {MOST_LINES} lines in all"
        raise reader.error(limits, f"{count:g} times {len(body)} lines")
    here, reader.depth = reader.line, reader.depth + 1
    for _ in range(int(count)):
        reader.line = places[0]
        reader.take_all("\n".join(body))
        reader.returned = False
    reader.line, reader.depth = here, reader.depth - 1


def end(reader: ProgramReader, meaning: str, word: str) -> None:
    """Take the word that ends a subprogram; at the end of a section nothing happens that nobody has called."""
    if not reader.depth and meaning == "return":
        raise reader.error("a program that runs from line to line", f"{word!r} in no subprogram: it begins again")
    reader.returned = reader.depth > 0


def _section(reader: ProgramReader, first: int) -> list[str]:
    """The lines of a subprogram, from that with its name to that with the word that ends it."""
    for number in range(first, len(reader.texts)):
        word = reader.control.words.begins(reader.words_of(reader.texts[number]))
        if word and word.meaning in ("return", "end of section"):
            return reader.texts[first - 1 : number + 1]
    raise reader.error("the end of the subprogram", f"none behind line {first}")
