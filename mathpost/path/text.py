r"""Many decimal numbers at once, between text and arrays, for reading and writing large files.

A `Pattern` describes the plain lines of a language, and reads the numbers of all of them as columns; any other line
is left to the caller, who reads it with care. Numbers are read as by `float`. `lines` puts lines together from
`Column`s. The loops over the characters are plain Python; for a large text they are compiled, where Numba is
installed.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import pairwise
from typing import AnyStr

import numpy as np

from mathpost.errors import InputError
from mathpost.formula import compiled

BLOCK = 2**19  # bytes that are read at once: their numbers fit the processor's cache
WORTH = 6_000  # lines; for a smaller text, loading the machine code takes longer than doing without it
ROWS = 4096  # lines that are written at once: their text fits the processor's cache
WIDEST = 24  # characters of a number that the loop writes, at most
NEWLINE, RETURN, BLANK, POINT, MINUS, PLUS, ZERO, NINE = b"\n\r .-+09"
MOST_DIGITS = 18  # of a number that is read: its digits without the point are below 2**63
POWERS = np.array([10.0**power for power in range(MOST_DIGITS + 1)])  # exact, as all up to 10**22 are
EXACT = 2**53  # integers below are exact as floats; dividing one by an exact power rounds once
LARGEST = 1e15  # of numbers that are written, in units of their last digits
TEN, NAUGHT = np.uint64(10), np.uint64(ZERO)  # unsigned: the division takes half the time of a signed one


@dataclass(frozen=True)
class Item:
    """A part of a plain line: an ASCII literal, and the kind of number after it."""

    literal: str
    holds: str = ""  # "number", decimal, with or without a sign and a point; "count", digits; or nothing
    optional: bool = False


class Pattern:
    r"""The form of a plain line: items in their order, and the end of the line, LF or CRLF.

    With `blanks`, blanks are allowed before and after numbers and after literals.

    Examples
    --------
    >>> pattern = Pattern([Item("X", "number"), Item(" Y", "number", optional=True)])
    >>> values, plain = pattern.match(b"X+1.5 Y2\nX-20.25\nZ30\n")
    >>> values[:, :2], plain
    (array([[  1.5 , -20.25],
           [  2.  ,    nan]]), array([ True,  True, False]))
    """

    def __init__(self, items: Sequence[Item], *, blanks: bool = False) -> None:
        self.literals = [item.literal for item in items]
        kinds = np.array([("", "count", "number").index(item.holds) for item in items])
        optional = np.array([item.optional for item in items])
        self.arrays = *_characters(self.literals), kinds, optional, blanks

    def match(self, block: bytes, parts: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
        """Read the numbers of the plain lines among complete lines of bytes.

        `parts` is how many such blocks the whole text has: that decides whether machine code is worth it. Returns
        the numbers, shape (items, lines), 0 for an item without one, NaN where an optional item is missing; and
        whether each line was read, shape (lines,): none with more than 18 digits is.
        """
        lines = np.count_nonzero(np.frombuffer(block, np.uint8) == NEWLINE)
        values, plain = np.empty((len(self.literals), lines)), np.zeros(lines, bool)
        _loops(lines * parts)[0](block, *self.arrays, values, plain)
        return values, plain


class Reader(ABC):
    """Takes the lines of a text in order: runs of plain ones together, the others one by one.

    Subclasses, which know the language, define `pattern`; `fits(values)`, which lines are plain to the end;
    `takes_plain()`, whether plain lines have their plain meaning now; `take_plain(values)` for a run of them, and
    `take_line(raw)` for the bytes of one line. They `keep` what they make of the lines.
    """

    pattern: Pattern
    _columns: Sequence[np.ndarray] = ()  # with room for all that is kept
    room = 1  # lines of the text
    count = 0  # that are kept

    @abstractmethod
    def fits(self, values: np.ndarray) -> np.ndarray: ...

    @abstractmethod
    def take_plain(self, values: np.ndarray) -> None: ...

    @abstractmethod
    def take_line(self, raw: bytes) -> None: ...

    def takes_plain(self) -> bool:
        return True

    def keep(self, *parts: np.ndarray) -> None:
        """Keep arrays, shape (…, k) each, behind those that were kept before."""
        stop = self.count + parts[0].shape[-1]
        if not self._columns or stop > self._columns[0].shape[-1]:
            # Room for all lines at once: what is never written to takes no memory, what is copied takes it twice.
            before, room = self.all_kept(), max(self.room, 2 * stop)
            self._columns = [np.empty((*part.shape[:-1], room), part.dtype) for part in parts]
            for column, part in zip(self._columns, before, strict=False):
                column[..., : self.count] = part
        for column, part in zip(self._columns, parts, strict=True):
            column[..., self.count : stop] = part
        self.count = stop

    def all_kept(self) -> list[np.ndarray]:
        """The arrays that were kept, shape (…, count) each."""
        return [column[..., : self.count] for column in self._columns]

    def take_all(self, content: AnyStr) -> None:
        """Take all lines of bytes, or of a text."""
        start = 0
        end = "\n" if isinstance(content, str) else b"\n"
        self.room = content.count(end) + 1
        while start < len(content):
            stop = content.find(end, start + BLOCK) + 1 or len(content)
            self._take_block(content[start:stop], len(content) / (stop - start))
            start = stop

    def _take_block(self, block: bytes | str, parts: float) -> None:
        if isinstance(block, str):
            block = block.encode("utf-8", "surrogatepass")
        block += b"" if block.endswith(b"\n") else b"\n"
        values, plain = self.pattern.match(block, parts)
        plain &= self.fits(values)
        ends = np.flatnonzero(np.frombuffer(block, np.uint8) == NEWLINE)
        changes = np.flatnonzero(plain[1:] != plain[:-1]) + 1
        for start, stop in pairwise([0, *changes.tolist(), len(plain)]):
            while start < stop:
                if plain[start] and self.takes_plain():
                    self.take_plain(values[:, start:stop])
                    break
                self.take_line(block[ends[start - 1] + 1 if start else 0 : ends[start]])
                start += 1


@dataclass(frozen=True)
class Column:
    """A part of n lines: an ASCII literal, and a number after it."""

    literal: str
    values: np.ndarray | None = None
    decimals: int = 0  # that it is rounded to; a zero has the sign `plus`
    plus: str = ""  # the sign of a number that is not negative
    shown: np.ndarray | None = None  # which lines have it; by default all


def lines(columns: Sequence[Column], first: int, stop: int) -> Iterator[str]:
    """Yield the text of the lines from `first` to `stop`, many at a time; a `Column` ends them."""
    widest = sum(len(column.literal) + WIDEST * (column.values is not None) for column in columns)
    write = _loops(stop - first)[1]
    decimals = np.array([-1 if column.values is None else column.decimals for column in columns])
    plus = np.array([ord(column.plus or "\0") for column in columns])
    literals = _characters(column.literal for column in columns)
    out = np.empty(min(stop - first, ROWS) * widest, np.uint8)
    for start in range(first, stop, ROWS):
        rows = slice(start, min(start + ROWS, stop))
        shown, values = np.ones((2, len(columns), rows.stop - start))
        for n, column in enumerate(columns):
            if column.shown is not None:
                shown[n] = column.shown[rows]
            if column.values is not None:
                values[n] = column.values[rows]
        if not (end := write(out, *literals, shown, values, decimals, plus)):
            raise InputError("lines", f"numbers of less than {LARGEST:g} last digits", "a larger one")
        yield out[:end].tobytes().decode("ascii")


def held(values: np.ndarray, before: float) -> np.ndarray:
    """Replace NaN by the last number before it, or by `before`."""
    last = np.maximum.accumulate(np.where(np.isnan(values), 0, np.arange(1, len(values) + 1)))
    return np.concatenate([[before], values])[last]


def _characters(texts: Iterable[str]) -> tuple[np.ndarray, np.ndarray]:
    """ASCII texts as rows of bytes, and their sizes."""
    texts = list(texts)
    width = max(1, *map(len, texts))
    rows = np.frombuffer("".join(text.ljust(width) for text in texts).encode("ascii"), np.uint8)
    return rows.reshape(len(texts), width), np.array([len(text) for text in texts])


def _loops(lines: float) -> tuple[Callable, Callable]:
    """The loops `_match` and `_write`: machine code if that many lines are worth it, or if it is loaded."""
    return _compiled() if lines >= WORTH or _compiled.cache_info().currsize else (_match, _write)


@cache
def _compiled() -> tuple[Callable, Callable]:
    """The loops as machine code, or as they are if Numba is not installed."""
    return compiled(_match, _skipped, _number), compiled(_write, _written)


def _match(
    text: bytes, literals: np.ndarray, sizes: np.ndarray, kinds: np.ndarray, optional: np.ndarray, blanks: bool,
    values: np.ndarray, plain: np.ndarray,
) -> None:  # fmt: skip
    """Put the numbers of the lines of `text` that fit a pattern into `values`, and which lines fit into `plain`."""
    at = 0
    for line in range(len(plain)):
        fits = True
        for item in range(len(sizes)):
            here, size, value = _skipped(text, at, blanks and item > 0), 0, 0.0
            while size < sizes[item] and text[here] == literals[item, size]:
                here, size = here + 1, size + 1
            found = size == sizes[item]
            if found and kinds[item] > 0:
                here, value = _number(text, _skipped(text, here, blanks), kinds[item] == 2)
                found = here > 0
            values[item, line] = value if found else math.nan
            if found:
                at = here
            elif not optional[item]:
                fits = False
                break
        at = _skipped(text, at, blanks)
        if text[at] == RETURN:
            at += 1
        plain[line] = fits and text[at] == NEWLINE
        while text[at] != NEWLINE:
            at += 1
        at += 1


def _skipped(text: bytes, at: int, blanks: bool) -> int:
    while blanks and text[at] == BLANK:
        at += 1
    return at


def _number(text: bytes, at: int, with_sign_and_point: bool) -> tuple[int, float]:
    """Return where the number at this place ends, and its value as by `float`; 0 and 0 if it is not plain."""
    negative = text[at] == MINUS
    if with_sign_and_point and (negative or text[at] == PLUS):
        at += 1
    first, value = at, 0
    while ZERO <= text[at] <= NINE:
        value = 10 * value + (text[at] - ZERO)
        at += 1
    digits, places = at - first, 0
    if with_sign_and_point and text[at] == POINT:
        at += 1
        while ZERO <= text[at] <= NINE:
            value = 10 * value + (text[at] - ZERO)
            at, places = at + 1, places + 1
    if not 0 < digits + places <= MOST_DIGITS or value >= EXACT:
        return 0, 0.0
    size = value / POWERS[places]
    return at, -size if negative else size


def _write(
    out: np.ndarray, literals: np.ndarray, sizes: np.ndarray, shown: np.ndarray, values: np.ndarray,
    decimals: np.ndarray, plus: np.ndarray,
) -> int:  # fmt: skip
    """Write lines into `out`, and return where they end, or 0 if a number is too large.

    `plus` is the sign of a number that is not negative, or 0.
    """
    at = 0
    for line in range(shown.shape[1]):
        for item in range(len(sizes)):
            if not shown[item, line]:
                continue
            for character in literals[item, : sizes[item]]:
                out[at] = character
                at += 1
            if decimals[item] < 0:
                continue
            value = values[item, line]
            last = abs(value) * POWERS[decimals[item]]  # in units of the last digit
            if not last < LARGEST:
                return 0
            whole = np.uint64(round(last))
            sign = MINUS if value < 0 and whole else plus[item]
            if sign:
                out[at] = sign
                at += 1
            at = _written(out, at, whole, decimals[item])
    return at


def _written(out: np.ndarray, at: int, whole: np.uint64, decimals: int) -> int:
    """Write `whole`, a point before its last `decimals` digits if there are any, and return where that ends."""
    count, rest = 1, whole // TEN
    while rest:
        count, rest = count + 1, rest // TEN
    count = max(count, decimals + 1)
    end = at + count + (decimals > 0)
    at = end
    for behind in range(count):
        if 0 < behind == decimals:
            at -= 1
            out[at] = POINT
        at -= 1
        rest = whole // TEN
        out[at] = NAUGHT + (whole - TEN * rest)
        whole = rest
    return end
