"""A control as data: the words that its programs are written with, and what words mean when they are read.

The files are in `data/controls`; `heidenhain.toml` explains every key. A file of the user's may inherit from one of
them and state only what is different.
"""

from __future__ import annotations

import re
import textwrap
import unicodedata
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cache, cached_property
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from mathpost.errors import InputError
from mathpost.files import TomlTable, data_file, one_of, only_if, read_text, read_toml, some_text
from mathpost.machine import Machine
from mathpost.path.modal import Command
from mathpost.shop.controls.coordinates import POSITIONING
from mathpost.shop.controls.geometry import Group, geometry_of
from mathpost.shop.controls.keys import LINES, TRUTH, WORD, WORDS, filled, key, keys_of, several, whole
from mathpost.shop.controls.meanings import MEANINGS
from mathpost.shop.controls.phrases import (
    Arcs,
    Cycles,
    Tilted,
    WorkOffsets,
    arcs_of,
    cycles_of,
    tilted_of,
    work_offsets_of,
)
from mathpost.shop.controls.variables import NAMES
from mathpost.shop.controls.words import Words
from mathpost.shop.plane.tilted_plane import NOTATIONS

COMMANDS = (
    "safe", "edge", "TCP on", "TCP off", "tool", "tool with speed", "tip", "offset",
    "spindle", "spindle CLW", "spindle CCLW", "spindle OFF",
    "coolant FLOOD", "coolant MIST", "coolant THRU", "coolant AIR", "coolant TAP", "coolant OFF", "next tool",
    "compensation LEFT", "compensation RIGHT", "compensation OFF",
    "dwell", "stop", "optional stop",
)  # fmt: skip
# What a control does where one block ends and the next begins, as a report says it.
BETWEEN_BLOCKS = {
    "look-ahead": "a control that looks ahead over all axes",
    "stop": "a control that stops before and behind every block that turns an axis",
    "overlap": "a control that overlaps blocks that turn an axis, at half the acceleration",
}
TEMPLATES = "a list of lines, in them {0}, {1} and {edge} only"
COMMENT = only_if(lambda text: "{text}" in text), "a line with {text} in it"
Count = TypeVar("Count", int, np.ndarray)
NUMBER_ROOM = 8  # characters of a line, for its block number
COUNT = only_if(lambda value: value >= 0, whole), "a whole number, not negative"
DIGITS = only_if(lambda value: 0 <= value <= 6, whole)


@dataclass(frozen=True, kw_only=True)
class Control:
    """The words of one control; a `key` of its file each, with how it is read."""

    name: str = key("", some_text, "a name in quotes")
    # What its words rest on: a manual, or a run on the control.
    source: str = key("", some_text, "what its words rest on, in quotes")
    head: tuple[str, ...] = key("program", *LINES, ())  # lines before the moves,
    # behind them in a program that is more than motion, where what may still be on is switched off,
    start: tuple[str, ...] = key("program", *LINES, ())
    end: tuple[str, ...] = key("program", *LINES, ())  # after them in a program that is more than motion,
    foot: tuple[str, ...] = key("program", *LINES, ())  # and at the end of any
    comment: str = key("program", *COMMENT)
    operation: str = key("program", *COMMENT, "")  # a comment that names an operation, if not like any other
    # Where it holds the length of the tool, as a comment at the head says it.
    tool_length: str = key("program", some_text, "a text in quotes", "IN THE TOOL TABLE")
    # Characters that a comment may not hold, and what replaces them; whether it holds no other letters.
    replaced: Mapping[str, str] = key("program", *WORDS, {})
    ascii: bool = key("program", *TRUTH, False)
    longest: int | None = key("blocks", *COUNT, None)  # characters of a line
    # The text before the number of a block; None, "none" in the file: blocks have no numbers.
    number: str | None = key("blocks", lambda word: None if word == "none" else WORD[0](word), WORD[1], "")
    first: int = key("blocks", *COUNT, 1)  # number of the first block
    step: int = key("blocks", only_if(lambda value: value > 0, COUNT[0]), "a whole number above 0", 1)
    last: int | None = key("blocks", *COUNT, None)  # after which numbering begins again
    unnumbered: tuple[str, ...] = key("blocks", *LINES, ())  # how lines without a number begin
    begin: str = key("blocks", *WORD, "")  # what every move begins with
    plus: str = key("blocks", *one_of("+", ""), "")  # before a number that is not negative
    decimals: int = key("blocks", DIGITS, "a whole number from 2 to 6", 4)  # of positions, mm and degrees
    feed_decimals: int = key("blocks", DIGITS, "a whole number from 0 to 6", 3)  # of feeds, mm per minute
    axis_letters: int | None = key("blocks", *COUNT, None)  # that the name of an axis may have
    linear: str = key("motion", *WORD, "")  # modal word of a move at feed, or nothing
    # Of a move in rapid traverse: modal if `linear` is, otherwise of its block.
    rapid: str = key("motion", some_text, "the word of rapid traverse")
    # Whether the axes arrive together then, on a line, and not each at its own rate.
    rapid_interpolated: bool = key("motion", *TRUTH)
    # What F is in a block with TCP that only turns: "degrees" a minute, "rates" of the axes. Or "time": every block
    # that turns states its time, with TCP too, in which no axis exceeds its rate.
    turning_feed: str = key("motion", *one_of("degrees", "rates", "time"), "degrees")
    # What F is without TCP in one: "degrees" a minute, or "tip", mm a minute on the part;
    rotary_feed: str = key("motion", *one_of("degrees", "tip"), "degrees")
    # and in one that moves slides too: "tip", "slides" alone, or "all", mm and degrees together.
    mixed_feed: str = key("motion", *one_of("tip", "slides", "all"), "tip")
    # How lines begin before which TCP is switched off, and on again behind them.
    without_tcp: tuple[str, ...] = key("motion", *LINES, ())
    # What it does where one block ends and the next begins.
    between_blocks: str = key("motion", *one_of(*BETWEEN_BLOCKS), "look-ahead")
    inverse_time: tuple[str, ...] = key("motion", *several(2), ())  # words that switch it on and off, or nothing
    block_time: str = key("motion", *WORD, "")  # word for the seconds of a block, or nothing
    # The place of the words of compensation, beside the positions.
    compensation: str = key("motion", *one_of("before", "behind"), "before")
    # What makes a number without a decimal point count as with one, or nothing if all do.
    whole_numbers: str = key("blocks", *WORD, "")
    variables: str = key("blocks", *one_of("", *NAMES), "")  # how it names them, or nothing
    continued: str = key("blocks", *WORD, "")  # at the end of a line that goes on in the next, or nothing
    # Which position the rotary axes take for a plane, or nothing.
    positioning: str = key("motion", *one_of(*POSITIONING), "")
    commands: dict[str, tuple[str, ...]]  # lines by command, see `COMMANDS`
    read: dict[str, str]  # word to meaning, see `mathpost.shop.controls.meanings`
    work_offsets: WorkOffsets  # words for them,
    arcs: Arcs | None  # for arcs,
    cycles: Cycles | None  # for drilling cycles
    tilted: Tilted | None  # and for tilted planes
    geometry: tuple[Group, ...]  # where the geometry of a machine is entered

    @property
    def modal(self) -> bool:
        """Whether rapid traverse holds until it is switched off (G0), and not for one block (FMAX)."""
        return bool(self.linear)

    def lines(self, command: str, *values: object, **numbers: int) -> list[str]:
        """Return the lines of a command, its values and the numbers of the tool and its offset put in."""
        return [line.format(*values, **numbers) for line in self.commands.get(command, ())]

    def said(self, command: Command) -> list[str]:
        """Return the lines of a `mathpost.path.modal.Command` that needs no move."""
        value = command.values[0] if command.values else None
        if command.kind == "verbatim":
            return [str(value)]
        lines = [] if command.values and value is None else self.lines(command.kind, *command.values)
        if command.kind in ("spindle", "coolant"):
            lines += self.lines(f"{command.kind} {command.values[-1]}")
            if len(lines) > 1 and self.modal:
                lines = [" ".join(lines)]
        if command.kind == "coolant" and not lines:  # it stays off: a comment tells which
            return self.remark(command.statement)
        return lines

    def work_offset_line(self, number: int) -> str:
        """Return the line that selects a work offset; `InputError` if there is none of that number."""
        line = self.work_offsets.line(number)
        if line is None:
            most = self.work_offsets.most
            expected = f"1 to {most}" if most else "none, its file has no words for them"
            raise InputError(f"work offset of {self.name}", expected, f"{number}")
        return line

    def remark(self, text: str, form: str = "") -> list[str]:
        """Return a text as a comment, or in a `form` of its own, on as many lines as it needs."""
        form = form or self.comment
        shown = "".join(self.replaced.get(character, character) for character in " ".join(text.split()))
        if self.ascii:
            shown = unicodedata.normalize("NFKD", shown).encode("ascii", "replace").decode()
        room = (self.longest or len(shown) + NUMBER_ROOM) - len(form) - NUMBER_ROOM
        return [form.format(text=line) for line in textwrap.wrap(shown, max(room, 20)) or [""]]

    def numbered(self, line: str, before: int) -> str:
        """Return a line with the number of a block that comes after so many others."""
        return line if self.number is None else f"{self.number}{self.numbers(before)} {line}"

    def numbers(self, before: Count) -> Count:
        """The number of a block that comes after so many others, an int or an array of them."""
        if self.last is None:
            return self.first + self.step * before
        return self.first + self.step * (before % ((self.last - self.first) // self.step + 1))

    def skipping(self, words: Iterable[str], where: str) -> Control:
        """Return a control that passes over some words, too; `InputError` for one that does something."""
        for word in words:
            if not word.strip():
                raise InputError(where, "words of the machine, such as M250", repr(word))
            known = self.words.begins(word.upper())
            if known and known.meaning != "skip":
                found = f"{known.text!r}, {known.meaning}"
                raise InputError(where, f"a word that {self.name} does not know", found)
        more = {word.upper(): "skip" for word in words}
        return replace(self, read=self.read | more) if more else self

    def ends(self, line: str) -> bool:
        """Whether a line has a word that ends the program."""
        found = [self.words.begins(word) for word in self.comments.sub(" ", line).split()]
        return any(word is not None and word.meaning == "end" for word in found)

    @cached_property
    def comments(self) -> re.Pattern:
        """What is a comment of a line."""
        begin, end = (re.escape(part.strip()) for part in self.comment.split("{text}"))
        return re.compile(rf"{begin}[^{begin}{end}]*{end}" if end else f"{begin}.*")

    @cached_property
    def words(self) -> Words:
        """All words that are understood when they are read."""
        known = dict(self.read)
        for command in ("TCP on", "TCP off"):
            known |= {line.split()[0] if "{" in line else line: command for line in self.commands[command]}
        for command, lines in self.commands.items():
            if re.match("spindle .|coolant|compensation|stop|optional", command):
                meaning = "compensation" if command in ("compensation LEFT", "compensation RIGHT") else "skip"
                known = {line.split()[0]: meaning for line in lines} | known
        modes = zip(self.inverse_time, ("inverse time", "feed per minute"), strict=False)
        known |= {word: meaning for word, meaning in [*modes, (self.linear, "linear")] if word} | self.read
        if self.modal:
            known[self.rapid] = "rapid"
        return Words(known)


def load(name: str | Path) -> Control:
    """Return a control by its name, or from a file of the user's; those of the package are read once.

    `InputError` is raised if there is none, or the file has a wrong key or value.

    Examples
    --------
    >>> load("fanuc").lines("compensation LEFT", "LEFT", 31)
    ['G41 D31']
    """
    path = _find(str(name))
    return _read_once(path) if path.parent == data_file("controls") else _read(path)


def _read(path: Path) -> Control:
    content = _with_inherited(path, ())
    try:
        return from_dict(content, str(path))
    except InputError as error:
        raise InputError(_with_line(path, error.where), error.expected, error.found) from None


_read_once = cache(_read)


def control_for(machine: Machine, control: Control | str | Path) -> Control:
    """Return a control, given or to be loaded; `InputError` if it cannot name the rotary axes of the machine."""
    found = control if isinstance(control, Control) else load(control)
    for axis in machine.joint_names[3:]:
        if found.axis_letters and len(axis) > found.axis_letters:
            letters = "one letter" if found.axis_letters == 1 else f"at most {found.axis_letters} letters"
            raise InputError("rotary axis name", f"{letters} for a {found.name} program", repr(axis))
    return found.skipping(machine.skip, "[program] skip")


def names() -> list[str]:
    """The names of the controls that come with the package."""
    return [path.stem for path in sorted(data_file("controls").glob("*.toml"))]


def _with_line(path: Path, where: str) -> str:
    """`where` with the line of the key that it names, if the key is in this file."""
    key = re.search(r"key '([^']+)'", where)
    for number, line in enumerate(read_text(path).splitlines(), 1):
        if key and re.match(rf'\s*"?{re.escape(key[1])}"?\s*=', line):
            return where.replace(str(path), f"{path}, line {number}", 1)
    return where


def _find(name: str) -> Path:
    if Path(name).suffix == ".toml" or Path(name).exists():
        return Path(name)
    if name not in names():
        raise InputError("dialect", f"{' or '.join(names())}, or a TOML file", repr(name))
    return data_file(f"controls/{name}.toml")


def _with_inherited(path: Path, heirs: tuple[str, ...]) -> dict[str, Any]:
    """The content of a file, table by table over that of the file that it inherits from."""
    content = read_toml(path)
    parent = content.pop("inherits", None)
    if parent is None:
        return content
    if not isinstance(parent, str) or parent in heirs:
        raise InputError(f"{path}, key 'inherits'", "a control that does not inherit from this one", repr(parent))
    inherited = _with_inherited(_find(parent), (*heirs, parent))
    for name, value in content.items():
        both_tables = isinstance(value, dict) and isinstance(inherited.get(name), dict)
        inherited[name] = inherited[name] | value if both_tables else value
    return inherited


def _templates(lines: list[str]) -> tuple[str, ...]:
    """Lines whose fields are those of a command: its values by number, and the edge of the tool."""
    return filled(lines, 1.0, 1, 1, edge=1)


def from_dict(content: dict, where: str = "control") -> Control:
    """Build a control from the content of its file; `where` begins every error message."""
    file = TomlTable(content, where)
    tables = {"": file} | {name: file.table(name) for name in ("program", "blocks", "motion")}
    commands, read = file.table("commands"), file.table("read")
    made = Control(
        **keys_of(Control, tables),
        commands={name: commands.take(name, _templates, TEMPLATES, ()) for name in COMMANDS},
        read={word: read.take(word, *one_of(*MEANINGS)) for word in list(read.content)},
        work_offsets=work_offsets_of(file),
        arcs=arcs_of(file),
        cycles=cycles_of(file),
        tilted=tilted_of(file, tuple(NOTATIONS)),
        geometry=geometry_of(file),
    )
    for table in (*tables.values(), commands, read):
        table.done()
    return made
