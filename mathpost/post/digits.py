"""Many decimal numbers at once, between text and arrays: what reading and writing large files rests on.

Reading: a `Pattern` says what the plain lines of a language look like, and takes the numbers of all of them as
columns. What is not plain beyond doubt is told apart and left to the caller, who reads it line by line.

Writing: `text` puts lines together from `Column`s.

Both are exact: what is read is what `float` reads, what is written is what formatting writes. Large texts go
through the machine code of `mathpost.post.text_loops`.
"""

import sys
from dataclasses import dataclass
from importlib import import_module
from itertools import pairwise

import numpy as np

WORTH = 2**19  # bytes; a smaller text takes less time and memory without the machine code than loading that does
LOOPS = "mathpost.post.text_loops"
WIDEST = 24  # characters of a number that the machine code writes, at most


def _loops(size):
    """The compiled loops, if a text of that many bytes is worth loading them, or they are loaded already."""
    return import_module(LOOPS) if size >= WORTH else sys.modules.get(LOOPS)


@dataclass(frozen=True)
class Item:
    """A part of a plain line.

    Attributes
    ----------
    literal : str
        ASCII.
    holds : str
        What stands behind it: ``""`` nothing, ``"number"`` a decimal number with or without a sign and a point,
        ``"count"`` digits.
    optional : bool
    """

    literal: str
    holds: str = ""
    optional: bool = False


class Pattern:
    r"""What a plain line looks like: items in their order, and the end of the line, LF or CRLF.

    Parameters
    ----------
    items : sequence of Item
    relaxed : bool
        Whether letters may be of either case, and blanks stand before and behind numbers and behind literals.

    Examples
    --------
    >>> pattern = Pattern([Item("X", "number"), Item(" Y", "number", optional=True)])
    >>> values, plain = pattern.match(b"X+1.5 Y2\nX-20.25\nZ30\n" * 30_000)
    >>> values[:, :2], plain[:3]
    (array([[  1.5 , -20.25],
           [  2.  ,    nan]]), array([ True,  True, False]))
    """

    def __init__(self, items, *, relaxed=False):
        self.items, self.relaxed = tuple(items), relaxed
        self.literals = [item.literal for item in self.items]
        cases = (str.upper, str.lower) if relaxed else (str, str)
        (self.upper, self.sizes), (self.lower, _) = (_characters(map(case, self.literals)) for case in cases)
        self.kinds = np.array([("", "number", "count").index(item.holds) for item in self.items])
        self.optional = np.array([item.optional for item in self.items])

    def match(self, block):
        """Read the numbers of the plain lines among whole lines of bytes, of which the last must end, too.

        Returns
        -------
        values : ndarray, shape (items, lines)
            What `float` makes of each number, 0 for an item without one, NaN where an optional item is missing; of
            lines that are not plain, anything.
        plain : ndarray of bool, shape (lines,)
            Whether the line is read. One with a number of more than 18 digits, or of more than about 15 that count,
            is not. Of a small text no line is, unless a large one has been read before.
        """
        text = np.frombuffer(block, np.uint8)
        lines = np.count_nonzero(text == ord("\n"))
        values, plain = np.empty((len(self.items), lines)), np.zeros(lines, bool)
        if loops := _loops(len(block)):
            pattern = self.upper, self.lower, self.sizes, self.kinds, self.optional, self.relaxed
            loops.match(text, *pattern, values, plain)
        return values, plain


@dataclass(frozen=True)
class Column:
    """What lines hold: a literal, and a number behind it.

    Attributes
    ----------
    literal : str
        ASCII.
    values : ndarray, shape (n,), optional
    decimals : int
    plus : str
        What stands for the sign of a number that is not negative.
    shown : ndarray of bool, shape (n,), optional
        Which lines hold it; by default all of them.
    """

    literal: str
    values: np.ndarray | None = None
    decimals: int = 0
    plus: str = ""
    shown: np.ndarray | None = None

    def __getitem__(self, rows):
        """The same of some lines."""
        values, shown = (array if array is None else array[rows] for array in (self.values, self.shown))
        return Column(self.literal, values, self.decimals, self.plus, shown)

    def texts(self, count):
        """What stands in each of `count` lines."""
        texts = [self.literal] * count
        if self.values is not None:
            form = f"{'+' if self.plus else ''}.{self.decimals}f"
            texts = [f"{self.literal}{value:{form}}" for value in self.values.tolist()]
        shown = [True] * count if self.shown is None else self.shown.tolist()
        return [text * there for text, there in zip(texts, shown, strict=True)]


def text(columns, count):
    r"""Return the text of `count` lines; where a line ends, a `Column` says.

    Examples
    --------
    >>> x = np.array([1.25, -1234.56789, -0.0])
    >>> text([Column("X", x, 4, "+"), Column(" L", shown=x > 0), Column("\n")], 3)
    'X+1.2500 L\nX-1234.5679\nX-0.0000\n'
    """
    widest = sum(len(column.literal) + WIDEST * (column.values is not None) for column in columns)
    if not (loops := _loops(count * widest)):
        return "".join(map("".join, zip(*(column.texts(count) for column in columns), strict=True)))
    shown, values = np.ones((len(columns), count), bool), np.zeros((len(columns), count))
    for row, column in enumerate(columns):
        if column.shown is not None:
            shown[row] = column.shown
        if column.values is not None:
            values[row] = column.values
    decimals = np.array([-1 if column.values is None else column.decimals for column in columns])
    plus = np.array([ord(column.plus or "\0") for column in columns], np.uint8)
    literals = _characters(column.literal for column in columns)
    out, parts, line = np.empty(count * widest, np.uint8), [], 0
    while line < count:
        line, end = loops.write(out, *literals, shown, values, decimals, plus, line)
        parts.append(out[:end].tobytes().decode("ascii"))
        if line < count:  # one that is better written with care
            parts += [column[line : line + 1].texts(1)[0] for column in columns]
            line += 1
    return "".join(parts)


def _characters(texts):
    """ASCII texts as rows of bytes, and their sizes."""
    texts = list(texts)
    width = max(1, *map(len, texts))
    rows = np.frombuffer("".join(text.ljust(width) for text in texts).encode("ascii"), np.uint8)
    return rows.reshape(len(texts), width), np.array([len(text) for text in texts])


def runs(values):
    """Yield where equal neighbours begin and end.

    Examples
    --------
    >>> list(runs(np.array([True, True, False])))
    [(0, 2), (2, 3)]
    """
    edges = [0, *(np.flatnonzero(values[1:] != values[:-1]) + 1).tolist(), len(values)]
    return pairwise(edges)


def held(values, before):
    """Replace NaN by the last number before it, or by `before`.

    Examples
    --------
    >>> held(np.array([np.nan, 2.0, np.nan]), 1.0)
    array([1., 2., 2.])
    """
    missing = np.isnan(values)
    if not missing.any():
        return values
    last = np.maximum.accumulate(np.where(missing, 0, np.arange(1, len(values) + 1)))
    return np.concatenate([[before], values])[last]
