"""A control as data: the words that its programs are written with, and what words mean when they are read.

The files are in `data/controls`; `heidenhain.toml` explains every key. A file of the user's may inherit from one of
them and state only what is different.
"""

from __future__ import annotations

import re
import textwrap
import unicodedata
from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cache, cached_property
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from mathpost.errors import InputError
from mathpost.files import (
    TomlTable,
    a_number,
    data_file,
    each,
    one_of,
    only_if,
    read_text,
    read_toml,
    some_text,
)
from mathpost.machine import Machine
from mathpost.path.modal import Command
from mathpost.shop.controls.coordinates import POSITIONING
from mathpost.shop.controls.geometry import Group, geometry_of
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
LINES = each(str), "a list of lines"
TEMPLATES = "a list of lines, in them {0}, {1} and {edge} only"
WORD = only_if(lambda value: isinstance(value, str)), "a word"
COMMENT = only_if(lambda text: "{text}" in text), "a line with {text} in it"
Count = TypeVar("Count", int, np.ndarray)
NUMBER_ROOM = 8  # characters of a line, for its block number
TRUTH = only_if(lambda value: isinstance(value, bool))
DIGITS = only_if(lambda value: value == int(value) and 0 <= value <= 6, a_number)
COUNT = only_if(lambda value: value == int(value) and value >= 0, a_number), "a whole number, not negative"


@dataclass(frozen=True)
class Control:
    """The words of one control."""

    name: str
    source: str  # what its words rest on: a manual, or a run on the control
    head: tuple[str, ...]  # lines before the moves,
    # Behind them in a program that is more than motion: what may still be on is switched off.
    start: tuple[str, ...]
    end: tuple[str, ...]  # after them in a program that is more than motion,
    foot: tuple[str, ...]  # and at the end of any
    comment: str  # with {text} in it
    operation: str  # the same, for the name of an operation
    tool_length: str  # where it holds the length of the tool, as a comment at the head says it
    replaced: dict[str, str]  # characters that a comment may not hold, and what replaces them
    ascii: bool  # whether a comment holds no other letters
    longest: int | None  # characters of a line
    number: str | None  # the text before the number of a block; None: blocks have no numbers
    first: int  # number of the first block
    step: int  # from each to the next
    last: int | None  # after which numbering begins again
    unnumbered: tuple[str, ...]  # how lines without a number begin
    begin: str  # what every move begins with
    plus: str  # before a number that is not negative
    decimals: int  # of positions, mm and degrees
    feed_decimals: int  # of feeds, mm per minute
    axis_letters: int | None  # that the name of an axis may have
    linear: str  # modal word of a move at feed, or nothing
    rapid: str  # of a move in rapid traverse: modal if `linear` is, otherwise of its block
    rapid_interpolated: bool  # whether the axes arrive together then, on a line, and not each at its own rate
    # What F is in a block with TCP that only turns: "degrees" a minute, "rates" of the axes. Or "time": every block
    # that turns states its time, with TCP too, in which no axis exceeds its rate.
    turning_feed: str
    rotary_feed: str  # what F is without TCP in one: "degrees" a minute, or "tip", mm a minute on the part
    mixed_feed: str  # and in one that moves slides too: "tip", "slides" alone, or "all", mm and degrees together
    without_tcp: tuple[str, ...]  # how lines begin before which TCP is switched off, and on again behind them
    between_blocks: str  # what it does there: one of `BETWEEN_BLOCKS`
    inverse_time: tuple[str, ...]  # words that switch it on and off, or nothing
    block_time: str  # word for the seconds of a block, or nothing
    compensation: str  # the place of its words, "before" or "behind" the positions
    commands: dict[str, tuple[str, ...]]  # lines by command, see `COMMANDS`
    read: dict[str, str]  # word to meaning, see `mathpost.shop.controls.meanings`
    whole_numbers: str  # what makes a number without a decimal point count as with one, or nothing if all do
    variables: str  # how it names them, one of `mathpost.shop.controls.variables.NAMES`, or nothing
    continued: str  # at the end of a line that goes on in the next, or nothing
    positioning: str  # which position the rotary axes take for a plane, one of `POSITIONING`, or nothing
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
    for key, value in content.items():
        both_tables = isinstance(value, dict) and isinstance(inherited.get(key), dict)
        inherited[key] = inherited[key] | value if both_tables else value
    return inherited


def _templates(lines: list[str]) -> list[str]:
    """Lines whose fields are those of a command: its values by number, and the edge of the tool."""
    for line in LINES[0](lines):
        try:
            line.format(1.0, 1, 1, edge=1)
        except (KeyError, IndexError):
            raise ValueError from None
    return lines


def from_dict(content: dict, where: str = "control") -> Control:
    """Build a control from the content of its file; `where` begins every error message."""
    file = TomlTable(content, where)
    program, blocks, motion = file.table("program"), file.table("blocks"), file.table("motion")
    commands, read = file.table("commands"), file.table("read")
    replaced = program.table("replaced", optional=True)
    control = Control(
        name=file.take("name", some_text, "a name in quotes"),
        source=file.take("source", some_text, "what its words rest on, in quotes"),
        head=tuple(program.take("head", *LINES, ())),
        start=tuple(program.take("start", *LINES, ())),
        end=tuple(program.take("end", *LINES, ())),
        foot=tuple(program.take("foot", *LINES, ())),
        comment=program.take("comment", *COMMENT),
        operation=program.take("operation", *COMMENT, program.content.get("comment", "")),
        tool_length=program.take("tool_length", some_text, "a text in quotes", "IN THE TOOL TABLE"),
        replaced={sign: replaced.take(sign, *WORD) for sign in list(replaced.content)},
        ascii=program.take("ascii", TRUTH, "true or false", False),
        longest=blocks.take("longest", lambda value: int(COUNT[0](value)), COUNT[1], None),
        number=blocks.take("number", lambda word: None if word == "none" else WORD[0](word), WORD[1], ""),
        first=int(blocks.take("first", *COUNT, 1)),
        step=int(blocks.take("step", only_if(lambda x: x == int(x) > 0, a_number), "a whole number above 0", 1)),
        last=blocks.take("last", lambda value: int(COUNT[0](value)), COUNT[1], None),
        unnumbered=tuple(blocks.take("unnumbered", *LINES, ())),
        begin=blocks.take("begin", *WORD, ""),
        plus=blocks.take("plus", *one_of("+", ""), ""),
        decimals=int(blocks.take("decimals", DIGITS, "a whole number from 2 to 6", 4)),
        feed_decimals=int(blocks.take("feed_decimals", DIGITS, "a whole number from 0 to 6", 3)),
        axis_letters=blocks.take("axis_letters", lambda value: int(COUNT[0](value)), COUNT[1], None),
        linear=motion.take("linear", *WORD, ""),
        rapid=motion.take("rapid", some_text, "the word of rapid traverse"),
        rapid_interpolated=motion.take("rapid_interpolated", TRUTH, "true or false"),
        turning_feed=motion.take("turning_feed", *one_of("degrees", "rates", "time"), "degrees"),
        rotary_feed=motion.take("rotary_feed", *one_of("degrees", "tip"), "degrees"),
        mixed_feed=motion.take("mixed_feed", *one_of("tip", "slides", "all"), "tip"),
        between_blocks=motion.take("between_blocks", *one_of(*BETWEEN_BLOCKS), "look-ahead"),
        without_tcp=tuple(motion.take("without_tcp", *LINES, ())),
        inverse_time=tuple(
            motion.take("inverse_time", only_if(lambda two: len(two) == 2, LINES[0]), "two words", ())
        ),
        block_time=motion.take("block_time", *WORD, ""),
        compensation=motion.take("compensation", *one_of("before", "behind"), "before"),
        commands={name: tuple(commands.take(name, _templates, TEMPLATES, ())) for name in COMMANDS},
        read={word: read.take(word, *one_of(*MEANINGS)) for word in list(read.content)},
        whole_numbers=blocks.take("whole_numbers", *WORD, ""),
        variables=blocks.take("variables", *one_of("", *NAMES), ""),
        continued=blocks.take("continued", *WORD, ""),
        positioning=motion.take("positioning", *one_of(*POSITIONING), ""),
        work_offsets=work_offsets_of(file),
        arcs=arcs_of(file),
        cycles=cycles_of(file),
        tilted=tilted_of(file, tuple(NOTATIONS)),
        geometry=geometry_of(file),
    )
    for table in (file, program, blocks, motion, commands, read, replaced):
        table.done()
    return control
