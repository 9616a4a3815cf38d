"""NC programs (加工程序) out and back in: Heidenhain, Fanuc and Siemens.

A program is a list of blocks that name all five axes. Writing and reading are inverse to each other to the
printed digits, so that a program can be verified from its own text. The readers know the words that the writers
use and a few that do not move an axis; any other word is an error with its line.
"""

import math
import re
from dataclasses import dataclass
from itertools import repeat

import numpy as np

from mathpost.errors import InputError

DECIMALS = 4
SHORTEST_TIME = 0.001  # s, the least that FT may state
LEAST_PLAIN, MOST_PLAIN = 8, 20_000  # moves in a row that are read together
LAST_BLOCK_NUMBER = 99_999  # Fanuc counts no further; numbering begins again
NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)"


@dataclass(frozen=True)
class Blocks:
    """The moves of a program.

    Attributes
    ----------
    words : ndarray, shape (n, 5)
        What the axis words say: mm and degrees, X Y Z and the rotary axes in the order of the machine file.
    feeds : ndarray, shape (n,)
        mm/min; NaN where no feed is stated.
    seconds : ndarray, shape (n,)
        Time of the block where inverse time is programmed, otherwise NaN.
    rapid : ndarray of bool, shape (n,)
    tcp : bool
        Whether X Y Z are the tool tip in the workpiece (M128, G43.4, TRAORI) instead of joints.
    remarks : tuple of (int, str)
        Comments, each with the number of the block that follows it.
    """

    words: np.ndarray
    feeds: np.ndarray
    seconds: np.ndarray
    rapid: np.ndarray
    tcp: bool = False
    remarks: tuple = ()

    @property
    def joints(self):
        """`words` with the rotary angles in radians, shape (n, 5)."""
        return np.concatenate([self.words[:, :3], np.deg2rad(self.words[:, 3:])], axis=1)


@dataclass(frozen=True)
class Dialect:
    """How a control writes a program; ``{name}`` is the program's name, ``{n}`` the block number.

    `comment` is a pair of what stands before and after. `codes` are the words without an axis that the reader
    passes over, as a regular expression.
    """

    name: str
    head: tuple
    foot: tuple
    tcp_on: str
    tcp_off: str
    comment: tuple
    number_step: int
    sign: str
    codes: str
    suffix: str


HEIDENHAIN = Dialect(
    name="heidenhain",
    head=("BEGIN PGM {name} MM",),
    foot=("END PGM {name} MM",),
    tcp_on="M128",
    tcp_off="M129",
    comment=("; ", ""),
    number_step=1,
    sign="+",
    codes=r"(?:M(?:0|00|1|01|3|03|4|04|5|05|8|08|9|09|128|129|30)|R0|S\d+|TOOL CALL \d+)",
    suffix=".h",
)
FANUC = Dialect(
    name="fanuc",
    head=("%", "O0001 ({name})", "G21 G17 G40 G90 G94"),
    foot=("M30", "%"),
    tcp_on="G43.4 H1",
    tcp_off="G49",
    comment=("(", ")"),
    number_step=10,
    sign="",
    codes=r"(?:G(?:21|17|40|49|90|43\.4)|M0?(?:0|1|3|4|5|6|8|9)|M30|H\d+|S\d+|T\d+|O\d+)",
    suffix=".nc",
)
SIEMENS = Dialect(
    name="siemens",
    head=("; {name}", "G710 G17 G40 G90 G94"),
    foot=("M30",),
    tcp_on="TRAORI",
    tcp_off="TRAFOOF",
    comment=("; ", ""),
    number_step=10,
    sign="",
    codes=r"(?:G(?:710|71|17|40|90)|M0?(?:0|1|3|4|5|6|8|9)|M30|TRAORI|TRAFOOF|S\d+|T\d+|D\d+)",
    suffix=".mpf",
)
DIALECTS = {dialect.name: dialect for dialect in (HEIDENHAIN, FANUC, SIEMENS)}


def dialect_named(name):
    """Return the `Dialect` called `name`, or raise `InputError`."""
    if name not in DIALECTS:
        raise InputError("dialect", " or ".join(DIALECTS), repr(name))
    return DIALECTS[name]


def rounded(joints):
    """Return joints (n, 5) in mm and radians as words in mm and degrees, rounded as they will be printed."""
    words = np.concatenate([joints[:, :3], np.rad2deg(joints[:, 3:])], axis=1)
    return np.round(words, DECIMALS) + 0.0


def write(blocks, machine, dialect="heidenhain", *, name="MATHPOST"):
    """Return the text of a program; words that do not change are left out.

    Parameters
    ----------
    blocks : Blocks
        At least one block, and none that repeats all words of the one before.
    machine : Machine
        For the names of its axes.
    dialect : str
        ``"heidenhain"``, ``"fanuc"`` or ``"siemens"``.
    name : str
        Program name; letters, digits and underscores of it are used.

    Examples
    --------
    >>> from mathpost import machine
    >>> dmu = machine.load("data/machines/dmu50v.toml")
    >>> words = np.array([[1, 2, 3, 4, 5], [1, 2, 3.5, 4, 5]])
    >>> two = Blocks(words, np.full(2, 500.0), np.full(2, np.nan), np.array([True, False]))
    >>> print(write(two, dmu, name="demo"), end="")
    0 BEGIN PGM DEMO MM
    1 L X+1.0000 Y+2.0000 Z+3.0000 B+4.0000 C+5.0000 FMAX
    2 L Z+3.5000 F500
    3 END PGM DEMO MM
    """
    style, name = dialect_named(dialect), re.sub(r"\W", "_", name, flags=re.ASCII).upper() or "MATHPOST"
    for axis in machine.joint_names[3:]:
        if style is HEIDENHAIN and len(axis) > 1:
            raise InputError("rotary axis name", "one letter for a Heidenhain program", repr(axis))
    lines = [line.format(name=name) for line in style.head]
    if blocks.tcp:
        lines.append(style.tcp_on)
    remarks = {}
    for index, remark in blocks.remarks:
        remarks.setdefault(index, []).append(_comment(style, remark))
    for index, line in enumerate(_moves(style, machine.joint_names, blocks)):
        if index in remarks:
            lines += remarks[index]
        lines.append(line)
    lines += [line for index, group in sorted(remarks.items()) if index >= len(blocks.words) for line in group]
    if blocks.tcp:
        lines.append(style.tcp_off)
    return _numbered(style, lines + [line.format(name=name) for line in style.foot])


def _comment(style, remark):
    text = " ".join(remark.split())
    if style is FANUC:
        text = text.replace("(", "[").replace(")", "]")
    return style.comment[0] + text + style.comment[1]


def _moves(style, names, blocks):
    """Yield the line of each move: what stands before its axis words, those that change, what stands after them."""
    axes = map("".join, zip(*map(_axis_words, names, blocks.words.T, repeat(style.sign)), strict=True))
    state = _State(style)
    modes = zip(blocks.rapid.tolist(), blocks.feeds.tolist(), blocks.seconds.tolist(), strict=True)
    for words, (rapid, feed, seconds) in zip(axes, modes, strict=True):
        before, after = state.around(rapid, feed, seconds)
        yield f"{before}{words}{after}".lstrip(" ")


def _axis_words(name, values, sign):
    """The words of one axis, each with a space before it; empty where the printed value stays as it was."""
    printed = (f"%{sign}.{DECIMALS}f " * len(values) % tuple(values.tolist())).split()
    word = f" {name}=" if len(name) > 1 else f" {name}"
    return ["" if now == before else word + now for now, before in zip(printed, [None, *printed], strict=False)]


class _State:
    """What the control remembers from block to block, so that it need not be written again."""

    def __init__(self, style):
        self.style, self.codes, self.feed = style, {}, None

    def around(self, rapid, feed, seconds):
        """What stands before and after the axis words of a move."""
        if self.style is HEIDENHAIN:
            return "L", self.heidenhain_feed(rapid, feed, seconds)
        return self.iso_codes(rapid, seconds), self.iso_feed(rapid, feed, seconds)

    def heidenhain_feed(self, rapid, feed, seconds):
        if rapid:
            return " FMAX"
        if not math.isnan(seconds):
            return f" FT{max(seconds, SHORTEST_TIME):.3f}"
        return self.changed_feed(feed)

    def iso_codes(self, rapid, seconds):
        wanted = {"move": "G0" if rapid else "G1"}
        if not rapid:
            wanted["feed"] = "G94" if math.isnan(seconds) else "G93"
        codes = [code for group, code in wanted.items() if self.codes.get(group, "G94") != code]
        if "feed" in wanted and self.codes.get("feed", "G94") != wanted["feed"]:
            self.feed = None
        self.codes |= wanted
        return " ".join(codes)

    def iso_feed(self, rapid, feed, seconds):
        if rapid:
            return ""
        return self.changed_feed(feed) if math.isnan(seconds) else f" F{60 / max(seconds, SHORTEST_TIME):.4f}"

    def changed_feed(self, feed):
        if math.isnan(feed) or feed == self.feed:
            return ""
        self.feed = feed
        return f" F{feed:.0f}" if feed == round(feed) else f" F{feed:.3f}"


def _numbered(style, lines):
    """Put block numbers before the lines that take one, and end each line."""
    numbered, count = [], 0
    for line in lines:
        if style is HEIDENHAIN:
            numbered.append(f"{count} {line}")
            count += 1
        elif line == "%" or line.startswith(("O", "(", ";")):
            numbered.append(line)
        else:
            count = count % (LAST_BLOCK_NUMBER // style.number_step) + 1
            numbered.append(f"N{count * style.number_step} {line}")
    return "\n".join(numbered) + "\n"


def read(text, machine, dialect="heidenhain", *, name="program"):
    """Return the `Blocks` of a program's text.

    Parameters
    ----------
    text : str
    machine : Machine
        For the names of its axes.
    dialect : str
    name : str
        Begins every error message.

    Raises
    ------
    InputError
        With the line: for a word that is not known or stands twice, a block before which an axis was never set,
        or a program without a move.
    """
    reader = _Reader(dialect_named(dialect), machine.joint_names, name)
    at, number = 0, 1
    while at < len(text):
        rows, end = reader.plain(text, at)
        if reader.take_plain(rows):
            number += len(rows)
        else:
            end = end if rows else text.find("\n", at) + 1 or len(text)
            for line in text[at:end].splitlines():
                reader.take(number, line)
                number += 1
        at = end
    return reader.result()


class _Reader:
    """Takes a program line by line and keeps what is modal."""

    def __init__(self, style, names, name):
        self.style, self.names, self.name = style, names, name
        letters = "|".join(re.escape(axis) for axis in sorted(names, key=len, reverse=True))
        self.axis = re.compile(rf"({letters})(?:=|(?<=[A-Z]))({NUMBER})")
        self.feed_word = re.compile(rf"(FMAX|FT|F)({NUMBER})?")
        self.codes = re.compile(style.codes + r"(?![\d.])")
        axes = "".join(rf"(?: {re.escape(axis)}{'=?' if axis[-1].isalpha() else '='}({NUMBER}))?" for axis in names)
        start, feeds = (
            (r"\d+ L", "(?: F(MAX|T?[0-9.]+))?") if style is HEIDENHAIN else (r"N\d+", "(?: F([0-9.]+))?")
        )
        self.plain_line = re.compile(rf"{start}(?= (?:{letters})){axes}{feeds}\n", re.ASCII)
        self.position, self.feed, self.rapid, self.inverse = [None] * 5, np.nan, False, False
        self.tcp, self.moves_tcp = False, None
        self.words, self.feeds, self.seconds, self.rapids = [], [], [], []

    def take(self, number, line):
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
                    raise self.error(number, f"one {match[1]} word", "two")
                position[axis] = float(match[2])
            elif body.startswith("F") and (match := self.feed_word.match(body)):
                rapid_here, feed, seconds = self.take_feed(number, match)
            elif self.style is not HEIDENHAIN and (match := re.match(r"G0?([01]|9[34])(?![\d.])", body)):
                self.take_mode(match[1])
            elif match := self.codes.match(body):
                self.take_code(match[0])
            else:
                raise self.error(number, f"a word of a {self.style.name} program", repr(body.split()[0]))
            body = body[match.end() :].lstrip()
        if feed is not None:
            self.feed = feed
        if any(value is not None for value in position):
            self.move(number, position, rapid_here, seconds)

    def plain(self, text, at):
        """Words of the plain moves from `at` on, as printed, and where they end; none before all axes are set."""
        rows, match = [], self.plain_line.match
        while len(rows) < MOST_PLAIN and None not in self.position and (found := match(text, at)):
            rows.append(found.groups())
            at = found.end()
        return rows, at

    def take_plain(self, rows):
        """Take plain moves all at once; return whether that was possible.

        What `take` would refuse or what changes a mode is left to it: it finds the line and says what is wrong.
        """
        if len(rows) < LEAST_PLAIN or self.moves_tcp not in (None, self.tcp):
            return False
        *axes, feeds = zip(*rows, strict=True)
        try:
            words = np.array([[math.nan if word is None else float(word) for word in axis] for axis in axes]).T
            rapid = np.array([word == "MAX" for word in feeds]) | self.rapid
            timed = np.array([word is not None and word[0] == "T" for word in feeds])
            value = np.array([math.nan if word in (None, "MAX") else float(word.lstrip("T")) for word in feeds])
        except ValueError:
            return False
        seconds = np.where(timed, value, 60 / value if self.inverse else np.nan)
        if (value <= 0).any() or (self.inverse and np.isnan(seconds[~rapid]).any()):
            return False
        feed = _held(np.where(np.isnan(seconds), value, np.nan), self.feed)
        words = np.stack([_held(*column) for column in zip(words.T, self.position, strict=True)], axis=1)
        self.moves_tcp, self.position, self.feed = self.tcp, words[-1].tolist(), float(feed[-1])
        self.words += words.tolist()
        self.feeds += np.where(rapid | ~np.isnan(seconds), np.nan, feed).tolist()
        self.seconds += seconds.tolist()
        self.rapids += rapid.tolist()
        return True

    def without_comment(self, line):
        if self.style is FANUC:
            return re.sub(r"\([^()]*\)", " ", line)
        return line.partition(";")[0]

    def take_feed(self, number, match):
        kind, value = match[1], match[2]
        if kind == "FMAX" and value is None and self.style is HEIDENHAIN:
            return True, None, np.nan
        if value is None or float(value) <= 0 or (kind == "FT") > (self.style is HEIDENHAIN) or kind == "FMAX":
            raise self.error(number, "a feed above 0", repr(match[0]))
        if kind == "FT":
            return False, None, float(value)
        if self.inverse:
            return False, None, 60 / float(value)
        return False, float(value), np.nan

    def take_mode(self, mode):
        if mode in "01":
            self.rapid = mode == "0"
        else:
            self.inverse, self.feed = mode == "93", np.nan

    def take_code(self, code):
        if code in (self.style.tcp_on.split()[0], self.style.tcp_off):
            self.tcp = code != self.style.tcp_off

    def move(self, number, position, rapid, seconds):
        rapid = rapid or self.rapid
        self.position = [old if new is None else new for new, old in zip(position, self.position, strict=True)]
        if None in self.position:
            missing = self.names[self.position.index(None)]
            raise self.error(number, f"a {missing} word before or in the first move", "none")
        if self.inverse and not rapid and np.isnan(seconds):
            raise self.error(number, "an F word, inverse time being active", "none")
        if self.moves_tcp not in (None, self.tcp):
            raise self.error(number, "moves all with or all without TCP", "both")
        self.moves_tcp = self.tcp
        self.words.append(self.position)
        self.feeds.append(np.nan if rapid or not np.isnan(seconds) else self.feed)
        self.seconds.append(seconds)
        self.rapids.append(rapid)

    def error(self, number, expected, found):
        return InputError(f"{self.name}, line {number}", expected, found)

    def result(self):
        if not self.words:
            raise InputError(self.name, "at least one move", "none")
        columns = map(np.array, (self.words, self.feeds, self.seconds, self.rapids))
        return Blocks(*columns, tcp=self.moves_tcp)


def _held(values, before):
    """Replace NaN by the last number before it, or by `before`."""
    values = np.concatenate([[before], values])
    return values[np.maximum.accumulate(np.where(np.isnan(values), 0, np.arange(len(values))))][1:]
