"""The moves of an NC program from its text, whole or in parts."""

import re
from dataclasses import astuple, dataclass
from functools import lru_cache

import numpy as np

from mathpost.errors import InputError
from mathpost.post import digits
from mathpost.post.dialect import HEIDENHAIN, Blocks, axis_word, dialect_named
from mathpost.post.digits import Item, Pattern

NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)"
NONE = np.empty((5, 0)), np.empty(0), np.empty(0), np.empty(0, bool)
RAPID, TIME, FEED = " FMAX", " FT", " F"
BLOCK = 2**19  # characters that are read at once


@dataclass(frozen=True)
class State:
    """What holds from line to line.

    Attributes
    ----------
    line : int
        Number of the next line.
    position : tuple of float or None
        The axis words, None before the first.
    feed : float, optional
    rapid, inverse, tcp : bool
        Whether these modes are active.
    moves_tcp : bool, optional
        Whether the moves so far were with TCP.
    """

    line: int = 1
    position: tuple = (None,) * 5
    feed: float | None = None
    rapid: bool = False
    inverse: bool = False
    tcp: bool = False
    moves_tcp: bool | None = None


class Reader:
    """Reads a program, in parts if need be: their blocks are those of the whole, at whatever line ends it is cut.

    Parameters
    ----------
    machine : Machine
        For the names of its axes.
    dialect : str
    name : str
        Begins every error message.
    """

    def __init__(self, machine, dialect="heidenhain", *, name="program"):
        self.style, self.names, self.name = dialect_named(dialect), machine.joint_names, name
        letters = "|".join(re.escape(axis) for axis in sorted(self.names, key=len, reverse=True))
        self.axis = re.compile(rf"({letters})(?:=|(?<=[A-Z]))({NUMBER})")
        self.feed_word = re.compile(rf"(FMAX|FT|F)({NUMBER})?")
        self.codes = re.compile(self.style.codes + r"(?![\d.])")
        self.plain = _plain(self.style, self.names)
        self.state, self.runs = State(), []

    @property
    def state(self):
        """The `State`; given to another reader of the same program, that one goes on from here."""
        return State(self.line, tuple(self.position), self.feed, self.rapid, self.inverse, self.tcp, self.moves_tcp)

    @state.setter
    def state(self, state):
        self.line, self.position, self.feed, self.rapid, self.inverse, self.tcp, self.moves_tcp = astuple(state)

    def read(self, text):
        """Return the `Blocks` of the next lines, of which there may be none.

        Raises
        ------
        InputError
            As `mathpost.post.program.read`.
        """
        self.runs, at, content = [], 0, text.encode("utf-8", "surrogatepass")
        while at < len(content):
            end = content.find(b"\n", at + BLOCK) + 1 or len(content)
            self.take_block(content[at:end])
            at = end
        words, feeds, seconds, rapid = zip(*self.runs or [NONE], strict=True)
        rows = map(np.concatenate, (feeds, seconds, rapid))
        return Blocks(np.concatenate(words, axis=1).T, *rows, tcp=bool(self.moves_tcp))

    def take_block(self, block):
        """Take whole lines: runs of plain moves together, the others one by one."""
        values, plain = self.plain.match(block if block.endswith(b"\n") else block + b"\n")
        first = self.plain.literals.index(axis_word(self.names[0]))
        words, missing = values[first : first + 5], np.full(len(plain), np.nan)
        numbers = dict(zip(self.plain.literals, values, strict=True))
        seconds = numbers.get(TIME, missing)
        rapid, timed, fed = ~np.isnan([numbers.get(RAPID, missing), seconds, numbers[FEED]])
        plain &= ~np.isnan(words).all(axis=0) & (rapid.astype(int) + timed + fed < 2)
        value = np.where(timed, seconds, numbers[FEED])
        lines = None
        for start, stop in digits.runs(plain):
            while start < stop:
                if plain[start]:
                    rows = slice(start, stop)
                    start += self.take_plain(words[:, rows], value[rows], rapid[rows], timed[rows])
                if start < stop:
                    lines = lines or block.split(b"\n")
                    self.take_raw(lines[start] + b"\n")
                    start += 1

    def take_plain(self, words, value, rapid, timed):
        """Take plain moves, and return how many of them could be taken.

        What `take` refuses is left to it: it says what is wrong.
        """
        if None in self.position or self.moves_tcp not in (None, self.tcp):
            return 0
        rapid = rapid | self.rapid
        wrong = value <= 0
        if self.inverse:
            wrong |= np.isnan(value) & ~rapid
        if wrong.any():
            count = int(np.argmax(wrong))
            return self.take_plain(words[:, :count], value[:count], rapid[:count], timed[:count]) if count else 0
        seconds = 60 / value if self.inverse else np.where(timed, value, np.nan)
        feeds = digits.held(np.where(np.isnan(seconds), value, np.nan), np.nan if self.feed is None else self.feed)
        for row, before in zip(words, self.position, strict=True):
            row[:] = digits.held(row, before)
        self.add(words, np.where(rapid | ~np.isnan(seconds), np.nan, feeds), seconds, rapid)
        self.position, self.feed = words[:, -1].tolist(), None if np.isnan(feeds[-1]) else float(feeds[-1])
        self.line += len(value)
        return len(value)

    def add(self, *run):
        """Add moves: words, shape (5, n), feeds, seconds and rapid."""
        self.runs.append(run)
        self.moves_tcp = self.tcp

    def take_raw(self, raw):
        """Take what stands up to one line feed; some characters other than that end a line, too."""
        for line in raw.decode("utf-8", "surrogatepass").splitlines():
            self.take(line)
            self.line += 1

    def take(self, line):
        body = self.without_comment(line).strip()
        if self.style is HEIDENHAIN:
            body = re.sub(r"^\d+\s*", "", body)
            body = "" if re.fullmatch(r"(BEGIN|END) PGM \w+ MM", body) else re.sub(r"^L(\s+|$)", "", body)
        else:
            body = "" if body == "%" else re.sub(r"^N\d+\s*", "", body)
        feed, seconds, position = None, np.nan, [None] * 5
        rapid_here = False
        while body:
            if match := self.axis.match(body):
                axis = self.names.index(match[1])
                if position[axis] is not None:
                    raise self.error(f"one {match[1]} word", "two")
                position[axis] = float(match[2])
            elif body.startswith("F") and (match := self.feed_word.match(body)):
                rapid_here, feed, seconds = self.take_feed(match)
            elif self.style is not HEIDENHAIN and (match := re.match(r"G0?([01]|9[34])(?![\d.])", body)):
                self.take_mode(match[1])
            elif match := self.codes.match(body):
                self.take_code(match[0])
            else:
                raise self.error(f"a word of a {self.style.name} program", repr(body.split()[0]))
            body = body[match.end() :].lstrip()
        if feed is not None:
            self.feed = feed
        if any(value is not None for value in position):
            self.move(position, rapid_here, seconds)

    def without_comment(self, line):
        if self.style.name == "fanuc":
            return re.sub(r"\([^()]*\)", " ", line)
        return line.partition(";")[0]

    def take_feed(self, match):
        kind, value = match[1], match[2]
        if kind == "FMAX" and value is None and self.style is HEIDENHAIN:
            return True, None, np.nan
        if value is None or float(value) <= 0 or (kind == "FT") > (self.style is HEIDENHAIN) or kind == "FMAX":
            raise self.error("a feed above 0", repr(match[0]))
        if kind == "FT":
            return False, None, float(value)
        if self.inverse:
            return False, None, 60 / float(value)
        return False, float(value), np.nan

    def take_mode(self, mode):
        if mode in "01":
            self.rapid = mode == "0"
        else:
            self.inverse, self.feed = mode == "93", None

    def take_code(self, code):
        if code in (self.style.tcp_on.split()[0], self.style.tcp_off):
            self.tcp = code != self.style.tcp_off

    def move(self, position, rapid, seconds):
        rapid = rapid or self.rapid
        self.position = [old if new is None else new for new, old in zip(position, self.position, strict=True)]
        if None in self.position:
            missing = self.names[self.position.index(None)]
            raise self.error(f"a {missing} word before or in the first move", "none")
        if self.inverse and not rapid and np.isnan(seconds):
            raise self.error("an F word, inverse time being active", "none")
        if self.moves_tcp not in (None, self.tcp):
            raise self.error("moves all with or all without TCP", "both")
        feed = np.nan if rapid or not np.isnan(seconds) or self.feed is None else self.feed
        self.add(np.array(self.position)[:, None], [feed], [seconds], [rapid])

    def error(self, expected, found):
        return InputError(f"{self.name}, line {self.line}", expected, found)


@lru_cache
def _plain(style, names):
    """The pattern of a line that moves axes and changes no mode but its feed."""
    start, ends = [Item("N", "count")], [Item(FEED, "number", optional=True)]
    if style is HEIDENHAIN:
        start = [Item("", "count"), Item(" L")]
        ends = [Item(RAPID, optional=True), Item(TIME, "number", optional=True), *ends]
    return Pattern([*start, *(Item(axis_word(name), "number", optional=True) for name in names), *ends])
