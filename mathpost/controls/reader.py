"""The text of a program to its blocks, in the words of any control.

A program is verified from its own text. A word that is not in the control's file is an error with its line.
"""

import re
from functools import cache

import numpy as np

from mathpost.controls.blocks import FEED, Blocks, axis_word
from mathpost.controls.control import Control, control_for
from mathpost.errors import NUMBER, InputError
from mathpost.machine import Machine
from mathpost.path import text as bulk
from mathpost.path.text import Item, Pattern


def read(text: str, machine: Machine, control: Control | str = "heidenhain", *, name: str = "program") -> Blocks:
    """Return the `Blocks` of a program's text; `InputError` with its `name` and the line if a word is not known."""
    lines = _Lines(machine, control_for(machine, control), name)
    lines.take_all(text)
    if not lines.runs:
        raise InputError(name, "at least one move", "none")
    words, feeds, seconds, rapid, tcp = (np.concatenate(runs, axis=-1) for runs in zip(*lines.runs, strict=True))
    return Blocks(words.T, feeds, seconds, rapid, tcp)


class _Lines(bulk.Reader):
    """Keeps what holds from one line of a program to the next."""

    def __init__(self, machine, control, name):
        self.control, self.names, self.name = control, machine.joint_names, name
        letters = "|".join(re.escape(axis) for axis in sorted(self.names, key=len, reverse=True))
        self.axis = re.compile(rf"({letters})(?:=|(?<=[A-Z]))({NUMBER})")
        self.feed_word = re.compile(rf"({'|'.join(filter(None, (*self._words_behind(), 'F')))})({NUMBER})?")
        self.numbered = re.compile(r"(?!)" if control.number is None else rf"^{control.number}\d+\s*")
        self.pattern = _plain(control.number, control.begin, (*self._words_behind(),), self.names)
        self.own_lines = _templates((*machine.program_head, *machine.program_foot, *machine.tool_change))
        self.line = 1
        self.forget()
        self.rapid, self.inverse, self.tcp = False, False, False
        self.in_machine = False  # whether the line counts from the machine's own zero
        self.other_positions = {}  # words that now make positions mean something else, inch or incremental
        self.runs = []  # of moves: words, shape (j, n), feeds, seconds, whether rapid, and with TCP

    def _words_behind(self):
        """The words of rapid traverse and of seconds that stand behind the positions, or nothing."""
        return "" if self.control.modal else self.control.rapid, self.control.block_time

    def columns(self, values):
        """Of plain lines the words, shape (j, n), time or feed, and whether they say rapid, a time, a feed."""
        numbers = dict(zip(self.pattern.literals, values, strict=True))
        first, missing = self.pattern.literals.index(axis_word(self.names[0])), np.full(values.shape[1], np.nan)
        rapid, times = (numbers.get(f" {word}", missing) if word else missing for word in self._words_behind())
        feeds = numbers[FEED]
        said = ~np.isnan([rapid, times, feeds])
        return values[first : first + len(self.names)], np.where(said[1], times, feeds), said

    def fits(self, values):
        """Which lines move an axis, and say no more than one of rapid, a time and a feed, these above 0."""
        words, value, said = self.columns(values)
        return ~np.isnan(words).all(axis=0) & (said.sum(axis=0) < 2) & ~(value <= 0)

    def take_plain(self, values):
        words, value, (rapid, timed, _) = self.columns(values)
        seconds = 60 / value if self.inverse else np.where(timed, value, np.nan)
        self.move(words, np.where(np.isnan(seconds), value, np.nan), seconds, rapid)
        self.line += len(value)

    def take_line(self, raw):
        """Take one line, word by word."""
        line = raw.decode("utf-8", "surrogatepass").strip()
        skipped, line = line.startswith("/"), line.removeprefix("/").lstrip()
        body = self.numbered.sub("", self.control.comments.sub(" ", line).strip())
        template = re.sub(r"^N?\d+\s*", "", line)
        known, meanings = self.control.words
        if self.own_lines.fullmatch(template):
            self.take_own(body)
            body = ""
        words, feed, seconds, rapid = {}, np.nan, np.nan, False
        while body:
            if match := self.axis.match(body):
                if match[1] in words:
                    raise self.error(f"one {match[1]} word", "two")
                words[match[1]] = float(match[2])
            elif match := self.feed_word.match(body):
                rapid, feed, seconds = self.take_feed(match)
            elif match := known.match(body):
                self.take_word(meanings[match.lastindex - 1], match[0])
            else:
                raise self.error(f"a word of a {self.control.name} program", repr(body.split()[0]))
            body = body[match.end() :].lstrip()
        if self.in_machine:  # an axis stands where the workpiece does not know
            for name in words:
                self.position[self.names.index(name)] = np.nan
            words, self.in_machine = {}, False
        if words:
            if skipped:
                raise self.error("a move that is never left out", "one behind an oblique stroke")
            column = np.array([[words.get(name, np.nan)] for name in self.names])
            self.move(column, *np.array([[feed], [seconds]]), np.array([rapid]))
        elif not np.isnan(feed):
            self.feed = feed
        self.line += 1

    def take_own(self, body):
        """Take a line of the machine file: its words hold, but where its moves go is not known.

        A word that the control's file does not know is passed over: the machine may have more than we know.
        """
        known, meanings = self.control.words
        while body:
            match = known.match(body)
            if match:
                self.take_word(meanings[match.lastindex - 1], match[0])
            body = body[match.end() :].lstrip() if match else re.sub(r"^\S[^A-Z\s]*\s*", "", body)
        self.in_machine = False
        self.forget()

    def take_feed(self, match):
        """Return whether a feed word says rapid, the feed, and the time of the block."""
        word, value = match[1], float(match[2] or "nan")
        rapid, block_time = self._words_behind()
        if word == rapid and not match[2]:
            return True, np.nan, np.nan
        if not value > 0 or word == rapid:
            raise self.error("a feed above 0", repr(match[0]))
        if word == "F" and not self.inverse:
            return False, value, np.nan
        return False, np.nan, value if word == block_time else 60 / value

    def forget(self):
        """The machine goes where its tools are."""
        self.position, self.feed = np.full(len(self.names), np.nan), np.nan

    def take_word(self, meaning, word):
        """Take what a word that states no position means."""
        if meaning in ("inch", "incremental"):
            self.other_positions[meaning] = word
        elif meaning in ("mm", "absolute"):
            self.other_positions.pop("inch" if meaning == "mm" else "incremental", None)
        elif meaning == "machine coordinates":
            self.in_machine = True
        elif meaning == "tool":
            self.forget()
        elif meaning in ("TCP on", "TCP off"):
            self.tcp = meaning == "TCP on"
            self.position[:3] = np.nan  # X Y Z now name another point
        elif meaning in ("inverse time", "feed per minute"):
            self.inverse, self.feed = meaning == "inverse time", np.nan
        elif meaning in ("linear", "rapid"):
            self.rapid = meaning == "rapid"

    def move(self, words, feeds, seconds, rapid):
        """Take n moves: words, shape (j, n), feeds and seconds, NaN where a line does not say."""
        for word in self.other_positions.values():
            raise self.error("positions in mm, absolute", repr(word))
        rapid = rapid | self.rapid
        for row, before in zip(words, self.position, strict=True):
            row[:] = bulk.held(row, before)
        unknown = np.isnan(words).any(axis=0)
        if (unknown & ~rapid).any():
            name = self.names[int(np.isnan(words[:, 0]).argmax())]
            raise self.error(f"a {name} word before or in the first move", "none")
        if unknown.any():  # on its way to the first position, from where nobody knows
            self.position = words[:, -1].copy()
            if unknown.all():
                return
            known = ~unknown
            words, feeds, seconds, rapid = words[:, known], feeds[known], seconds[known], rapid[known]
        untimed = np.isnan(seconds)
        if self.inverse and (untimed & ~rapid).any():
            self.line += int((untimed & ~rapid).argmax())
            raise self.error("an F word, inverse time being active", "none")
        feeds = bulk.held(feeds, self.feed)
        tcp = np.full(len(feeds), self.tcp)
        self.runs.append((words, np.where(rapid | ~untimed, np.nan, feeds), seconds, rapid, tcp))
        self.position, self.feed = words[:, -1].copy(), feeds[-1]

    def error(self, expected, found):
        return InputError(f"{self.name}, line {self.line}", expected, found)


def _templates(lines):
    """An expression that the lines of the machine file fit, whatever name and tool stand in them."""
    escaped = (re.escape(line.strip()) for line in lines)
    named = (line.replace(r"\{name\}", r"\w+") for line in escaped)
    fields = (re.sub(r"\\\{(tool|offset)\\\}", r"\\d+", line) for line in named)
    return re.compile("|".join(fields) or r"(?!)")


@cache
def _plain(number, begin, words_behind, names):
    """The pattern of a line that moves axes and changes no mode but its feed."""
    start = [] if number is None else [Item(number, "count")]
    start += [Item(f" {begin}")] if begin else []
    rapid, block_time = words_behind
    behind = [Item(f" {rapid}", optional=True)] if rapid else []
    behind += [Item(f" {block_time}", "number", optional=True)] if block_time else []
    axes = (Item(axis_word(name), "number", optional=True) for name in names)
    return Pattern([*start, *axes, *behind, Item(FEED, "number", optional=True)])
