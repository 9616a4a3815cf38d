"""The lines of a CL file as statements, its records as arrays, and all its problems in one error."""

from __future__ import annotations

import math
import re
from abc import abstractmethod
from collections import Counter
from collections.abc import Sequence
from operator import itemgetter
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from mathpost.errors import InputError
from mathpost.files import NUMBER
from mathpost.formula import slices
from mathpost.path import text
from mathpost.path.coordinates import Comments, Coordinates
from mathpost.path.modal import Command, Remark

UNIT_TOLERANCE = 1e-3  # how far the printed length of a tool axis may be from 1
ENCODINGS = "utf-8", "gb18030", "cp1252", "latin-1"  # tried in turn; the last takes any byte
LARGEST = 1e9  # absolute value of a number
BELOW_LARGEST = f"a finite number below {LARGEST:g}"
SHOWN = 20  # causes that are listed when a file is refused
REAL = re.compile(rf"{NUMBER}(?:[eE][-+]?\d+)?")
BETWEEN_NUMBERS = re.compile(r"[\d.]\s+$")
TIP, AXIS = [text.Item(",", "number")], [text.Item(",", "number", optional=True)]
# One record of three or six numbers, and nothing else: most lines of most files.
PLAIN = text.Pattern([text.Item("GOTO"), text.Item("/", "number"), *TIP * 2, *AXIS * 3], blanks=True)
T = TypeVar("T")
# Points and axes, shape (3, n), feeds, rapid and lines, shape (n,).
Records = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray]


def need(holds: object, expected: str, found: str | None = None) -> None:
    """Refuse a statement unless a condition holds; `found` is by default how the statement begins."""
    if not holds:
        raise InputError("", expected, found)


def known(value: T | None, expected: str, found: str | None = None) -> T:
    """Return a value that must be known by now; refuse the statement if it is None."""
    if value is None:
        raise InputError("", expected, found)
    return value


class Lines(text.Reader):
    """Collects records and remarks; keeps the tool's position, in mm and in the active coordinates.

    Subclasses, which know the words, define `take` for each `statement`, which begins on line `start`.
    """

    pattern = PLAIN

    def __init__(self, name: str) -> None:
        self.name = name
        self.encoding = "utf-8", "surrogatepass"
        self.line = 1
        self.start = 0
        self.statement = ""
        self.unfinished: list[str] = []  # parts of a statement that goes on,
        self.comment: list[str] = []  # and of a comment
        self.point: list[float] | None = None
        self.axis = [0.0, 0.0, 1.0]
        self.feed = math.nan
        self.rapid = False
        self.scale = 1.0
        self.coordinates = Coordinates()
        self.comments = Comments()
        self.remarks: list[Remark] = []
        self.counts: Counter[str] = Counter()
        self.problems: list[tuple[int, str, str, str]] = []

    def take_file(self, content: bytes) -> None:
        """Take all lines."""
        for name in () if content.isascii() else ENCODINGS:
            self.encoding = name, "surrogatepass" if name == "utf-8" else "strict"
            try:
                content.decode(*self.encoding)
            except UnicodeDecodeError:
                continue
            break
        self.take_all(content)
        if self.unfinished:
            self.problem(self.start, "", "the continuation of this statement", "the end of the file")

    def fits(self, values: np.ndarray) -> np.ndarray:
        """Return which lines have a complete tool axis or none."""
        stated = ~np.isnan(values[4:])
        return stated.all(axis=0) | ~stated.any(axis=0)

    def take_plain(self, values: np.ndarray) -> None:
        """Take plain records; a tool axis of NaN is the active one."""
        numbers, count = values[1:], values.shape[1]
        numbers[:3] *= self.scale
        for row, before in zip(numbers[3:], self.axis, strict=True):
            row[:] = text.held(row, before)
        self.add(self.line + np.arange(count), numbers)
        self.line += count

    def take_line(self, raw: bytes) -> None:
        """Take one line: drop its comment, and take the statement if it is complete."""
        line = raw.decode(*self.encoding)
        number, self.line = self.line, self.line + 1
        if self.comment or line.startswith("$$"):
            self.take_comment(line.rstrip())
            return
        part = line.partition("$$")[0].rstrip()
        if not self.unfinished:
            self.start = number
        before = self.unfinished[-1] if self.unfinished else ""
        if BETWEEN_NUMBERS.search(before) and REAL.match(part.lstrip()):
            part = f",{part}"  # two numbers: some systems leave out the comma where they break a line
        if part.endswith("$"):
            self.unfinished.append(part[:-1] or " ")
            return
        self.statement, self.unfinished = "".join([*self.unfinished, part]).strip(), []
        if self.statement:
            self.take()

    @abstractmethod
    def take(self) -> None:
        """Take one statement."""

    def take_comment(self, line: str) -> None:
        """Take a line of a comment: Creo continues one on the next line; two systems state coordinates in it."""
        if line.endswith("$") and (self.comment or line.startswith("$$->")):
            self.comment.append(line[:-1])
            return
        said, self.comment = self.comments.take(" ".join([*self.comment, line])), []
        if said:
            self.coordinates.say(**said)

    def add(
        self, lines: np.ndarray, numbers: np.ndarray, *, feed: float | None = None, rapid: bool | None = None
    ) -> None:
        """Add records, shape (6, n), in mm; `rapid` and `feed` are by default the active ones."""
        self.point, self.axis = numbers[:3, -1].tolist(), numbers[3:, -1].tolist()
        fast = np.full(len(lines), self.rapid if rapid is None else rapid)
        feeds = np.where(fast, math.nan, self.feed if feed is None else feed)
        self.keep(lines, self.coordinates.placed(numbers), feeds, fast)
        self.rapid = False

    def go(self, points: ArrayLike, axis: ArrayLike, **options: Any) -> None:
        """Add records at points, shape (n, 3), with one tool axis."""
        points = np.reshape(points, (-1, 3))
        numbers = np.empty((6, len(points)))
        numbers[:3], numbers[3:] = points.T, np.reshape(axis, (3, 1))
        self.add(np.full(len(points), self.start), numbers, **options)

    def records(self) -> Records:
        """Return points and axes, shape (3, n), feeds, rapid and lines, or refuse a file with problems."""
        if not self.count:
            self.refuse_problems()
            raise InputError(self.name, "at least one GOTO", "none")
        lines, numbers, feeds, rapid = self.all_kept()
        points, axes = numbers[:3], numbers[3:]
        length = np.empty(self.count)
        for rows in slices(length.shape):
            with np.errstate(over="ignore"):
                length[rows] = np.linalg.norm(axes[:, rows], axis=0)
        for record in np.flatnonzero(~(np.abs(length - 1) <= UNIT_TOLERANCE)).tolist():
            shown = ", ".join(f"{value:g}" for value in axes[:, record])
            found = f"({shown}) of length {length[record]:.6g}"
            self.problem(int(lines[record]), "GOTO", f"a unit tool axis (to {UNIT_TOLERANCE})", found)
        self.refuse_problems()
        axes /= length
        return points, axes, feeds, rapid, lines

    def remark(self, remark: str | Command | None = None, record: int | None = None) -> None:
        """Keep a remark, by default the statement, before a record, by default the next."""
        self.remarks.append((self.count if record is None else record, remark or self.statement))

    def problem(self, line: int, word: str, expected: str, found: str | None = None) -> None:
        self.problems.append((line, word, expected, repr(self.statement[:60]) if found is None else found))

    def refuse_problems(self) -> None:
        """Raise the `InputError` that lists all problems, each cause once."""
        causes: dict[tuple[str, str], list[tuple[int, str]]] = {}
        for line, word, expected, found in sorted(self.problems, key=itemgetter(0)):
            causes.setdefault((word, expected), []).append((line, found))
        if not causes:
            return
        said = []
        for (word, expected), ((line, found), *others) in causes.items():
            again = f" ({len(others) + 1} times, up to line {others[-1][0]})" if others else ""
            said.append((f"line {line}" + f", {word}" * bool(word), expected, found + again))
        (where, expected, found), *more = said
        lines = [found, *("{}: expected {}, found {}".format(*each) for each in more[: SHOWN - 1])]
        if len(said) > SHOWN:
            lines.append(f"and {len(said) - SHOWN} more causes")
        if more:
            kinds = f"{len(self.problems)} statements of {len(said)} kinds"
            lines.append(f"{kinds}; --ignore WORD takes a word on trust")
        raise InputError(f"{self.name}, {where}", expected, "\n  ".join(lines))

    def numbers(self, words: Sequence[str], *counts: int) -> list[float]:
        """Return words as numbers; how many there are must be one of `counts`."""
        values = [self.number(word) for word in words]
        if counts and len(values) not in counts:
            expected = " or ".join(", ".join(map(str, counts)).rsplit(", ", 1))
            raise InputError("", f"{expected} numbers", f"{len(values)}")
        return values

    def number(self, word: str) -> float:
        if not REAL.fullmatch(word.strip()):
            raise InputError("", "a number", repr(word.strip()))
        need(abs(value := float(word)) < LARGEST, BELOW_LARGEST, word.strip())
        return value
