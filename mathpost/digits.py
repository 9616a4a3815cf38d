"""Many decimal numbers at once, between text and arrays: what reading and writing large files rests on.

Reading: lines that differ only in their digits and signs have the same *shape*, the line with each run of digits
and signs written as 0. A caller recognises a shape once, by an ordinary regular expression, and takes the numbers
of all its lines as columns. Eight characters are gathered as one machine word and become a number in three
multiplications. What is not plain beyond doubt is told apart and left to the caller.

Writing: a line is a row of cells of four characters each, taken from tables, NUL where nothing stands. Deleting
the NULs leaves the text.

Both are exact: what is read is what `float` reads, what is written is what ``%`` writes.
"""

from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

import numpy as np

ALL, BIT_4, NIBBLES = 2**64 - 1, 0x1010101010101010, 0x0F0F0F0F0F0F0F0F
POWERS = np.array([10**power for power in range(23)], dtype=float)  # all powers of ten that a double holds exactly
EXACT = 2.0**53  # integers below are exact, and so is one division of theirs by an exact power, correctly rounded
NUMBER = r"(?:0\.?0?|\.0)"  # in a shape
LONGEST = 64  # marks in a line that may have a shape
MIX = np.random.default_rng(0).integers(2**63, size=LONGEST, dtype=np.uint64)  # weights that tell shapes apart
LEAST_LINES = 4  # of one shape; fewer are not worth a table
LEAST_ROWS = 24  # fewer are formatted one by one
LARGEST = 1e12  # last digits in a number that the tables write; the product is then good to 0.0003 of a digit


class Lines:
    """The lines of a text in bytes, which ends with the end of a line.

    Parameters
    ----------
    text : bytes
        ASCII where it is to be recognised; any other byte is a character of no shape that a caller knows.

    Examples
    --------
    >>> lines = Lines(b"X+1.5 Y2\\nX-20.25 Y-1\\nX30 Z1\\nX.5 Y1\\n" * 4)
    >>> for table in lines.tables():
    ...     if table.shape == "X0.0 Y0":
    ...         print(table.lines.tolist()[:4], table.numbers([(1, 4), (6, 7)])[0][:, :4].tolist())
    [0, 1, 4, 5] [[1.5, -20.25, 1.5, -20.25], [2.0, -1.0, 2.0, -1.0]]
    """

    def __init__(self, text):
        padded = b"".join([b"\n", text, b"\n" * (-len(text) % 8 + 31)])  # every gather finds bytes behind the end
        self.text, self.bytes = text, np.frombuffer(padded, np.uint8)
        self.words = np.ndarray(len(padded) - 7, "<u8", padded, strides=1)  # the eight characters from each on
        characters = self.bytes[: len(text) + 1]
        number = ((characters - 48) < 10) | ((characters - 43) & 253 == 0)  # a digit, or + (43) or - (45)
        self.marks = np.flatnonzero(~number)
        kinds = characters[self.marks]
        self.newlines = np.flatnonzero(kinds == 10)
        self.ends = self.marks[self.newlines]
        # A mark, and in the highest bit whether a run of digits and signs stands behind it; 127 for all non-ASCII.
        self.signature = np.minimum(kinds, 127)
        self.signature[:-1] |= (np.diff(self.marks) > 1).view(np.uint8) << 7

    def __len__(self):
        return len(self.ends) - 1

    def __getitem__(self, line):
        return self.text[self.ends[line] : self.ends[line + 1]]

    def tables(self):
        """Yield a `Table` of each shape that at least `LEAST_LINES` lines share."""
        sizes = np.diff(self.newlines)
        for size in np.flatnonzero(np.bincount(sizes[sizes <= LONGEST]) >= LEAST_LINES):
            lines = np.flatnonzero(sizes == size)
            rows = _windows(self.signature, size)[self.newlines[lines]]
            for group in _alike(rows):
                yield self._table(rows[group[0]], lines[group])

    def _table(self, signature, lines):
        shape = "".join(chr(mark & 127) + "0" * (mark >> 7) for mark in signature.tolist())
        marks = _windows(self.marks, len(signature) + 1)[self.newlines[lines]]
        return Table(shape[1:], lines, marks.T, self.words)


def _windows(array, size):
    """All runs of `size` neighbours, shape (n - size + 1, size), without a copy."""
    return np.ndarray((max(len(array) - size + 1, 0), size), array.dtype, array, strides=2 * array.strides)


def _alike(rows):
    """Yield the numbers of the rows that are equal, for each kind of which there are at least `LEAST_LINES`."""
    if (rows == rows[0]).all():
        yield np.arange(len(rows))
        return
    mixed = rows.astype(np.uint64) @ MIX[: rows.shape[1]]
    _, kind, count = np.unique(mixed, return_inverse=True, return_counts=True)
    for common in np.flatnonzero(count >= LEAST_LINES):
        group = np.flatnonzero(kind == common)
        if (rows[group] == rows[group[0]]).all():
            yield group


@dataclass(frozen=True)
class Table:
    """Lines of one shape.

    Attributes
    ----------
    shape : str
        The line, each run of digits and signs as 0, without the end of the line.
    lines : ndarray of int, shape (n,)
        Which lines of the text they are.
    marks : ndarray of int, shape (m, n)
        Where the other characters stand, the ends of the line before and of the line itself among them.
    words : ndarray of uint64
        The eight characters from each place of the text on.
    """

    shape: str
    lines: np.ndarray
    marks: np.ndarray
    words: np.ndarray

    def numbers(self, spans):
        """Read the numbers at some places of the shape.

        Parameters
        ----------
        spans : sequence of (int, int)
            Where in `shape` the numbers stand, each of the form 0, 0., .0 or 0.0.

        Returns
        -------
        values : ndarray, shape (len(spans), n)
            What `float` makes of each.
        plain : ndarray of bool, shape (n,)
            Whether all numbers of the line were read. What has more than 8 characters before the point, more than
            16 behind it or more than about 15 digits is not, nor what is no number.
        """
        left, point, right = np.array([self._around(*span) for span in spans]).T
        start, point, end = self.marks[left] + 1, self.marks[point], self.marks[right]
        size, places = point - start, np.maximum(end - point - 1, 0)
        word = self.words[start]
        first = word & 0xFF
        negative = first == ord("-")
        signed = negative | (first == ord("+"))
        word = (word & ~(signed * np.uint64(0xFF))) << _bits(8 - size)  # NUL counts as the digit 0
        good = (word & BIT_4) == (np.uint64(BIT_4) << _bits(8 - size + signed))  # which no sign has
        good &= (size <= 8) & (places <= 16) & (size - signed + places > 0)
        values = _eight(word)

        longest = np.clip(places.max(axis=1, keepdims=True, initial=0), 8, 16)
        scale = POWERS[longest]
        for behind in (0, 8) if longest.max() > 8 else (0,):
            mask = np.uint64(ALL) >> _bits(np.maximum(8 + behind - places, 0))
            word = self.words[point + behind + 1] & mask
            good &= (word & BIT_4) == (mask & BIT_4)
            if behind:
                values = values * POWERS[longest - 8] + _eight(word << _bits(16 - longest))
            else:
                values = values * POWERS[8] + _eight(word)
        good &= values < EXACT
        values /= scale
        return np.negative(values, out=values, where=negative), good.all(axis=0)

    def unsigned(self, start, stop):
        """Whether the run of digits and signs at this place of the shape is of digits only, at most 8."""
        left, _, right = self._around(start, stop)
        begin = self.marks[left] + 1
        size = self.marks[right] - begin
        shift = _bits(8 - size)
        return (size <= 8) & ((self.words[begin] << shift) & BIT_4 == np.uint64(BIT_4) << shift)

    def _around(self, start, stop):
        """Numbers of the marks before a number, at its point (or behind it, if it has none) and behind it."""
        before = start - self.shape.count("0", 0, start)
        return before, before + 1, before + 1 + self.shape.count(".", start, stop)


def _bits(count):
    """Bits of `count` bytes, as what an array of words is shifted by; by 64 and more, NumPy shifts all out."""
    return (count << 3).view(np.uint64)


def _eight(word):
    """The number of eight digits in each word, the first in its lowest byte; two, four, eight digits at a time."""
    word = (word & NIBBLES) * (10 * 2**8 + 1) >> 8
    word = (word & 0x00FF00FF00FF00FF) * (100 * 2**16 + 1) >> 16
    word = (word & 0x0000FFFF0000FFFF) * (10000 * 2**32 + 1) >> 32
    return word.view(np.int64).astype(float)


def runs(values):
    """Yield where equal neighbours begin and end.

    Examples
    --------
    >>> list(runs(np.array([True, True, False])))
    [(0, 2), (2, 3)]
    """
    edges = [0, *(np.flatnonzero(values[1:] != values[:-1]) + 1).tolist(), len(values)]
    return pairwise(edges)


def fixed(values, decimals, *, before="", plus=""):
    """Write numbers with `decimals` decimals, at most 4, as the cells of their texts.

    Parameters
    ----------
    values : ndarray, shape (n,)
    decimals : int
        From 1 to 4.
    before : str
        Stands before every number.
    plus : str
        What stands for the sign of a number that is not negative.

    Returns
    -------
    list of ndarray of uint32, shape (n,)
        Four characters each; see `text`.

    Examples
    --------
    >>> text(fixed(np.array([1.25, -1234.56789, -0.0]), 4, before="X", plus="+")).split("X")
    ['', '+1.2500', '-1234.5679', '-0.0000']
    """
    size = np.abs(values)
    if len(values) < LEAST_ROWS or not size.max() < LARGEST / POWERS[decimals]:
        sign = "+" if plus else ""
        return cells([before + f"{value:{sign}.{decimals}f}" for value in values.tolist()])
    last = size * POWERS[decimals]  # the number in units of its last digit
    whole = np.rint(last)
    # Where the product is close to a tie its rounding may decide: these are left to the exact way.
    for unsure in np.flatnonzero(np.abs(last - whole) > 0.499):
        whole[unsure] = int(f"{size[unsure]:.{decimals}f}".replace(".", ""))
    above = np.floor(whole / POWERS[decimals])
    fraction = _table(decimals)[(whole - above * POWERS[decimals]).astype(np.intp)]
    *start, minus = repeated(before + "-", len(values))
    *_, plus = repeated(before + (plus or "\0"), len(values))
    *more, units = integers(above.astype(np.int64))
    units += np.uint32(ord(".") << 24)
    return [*start, np.where(np.signbit(values), minus, plus), *more, units, fraction]


def integers(values):
    """Write integers from 0 on, shape (n,), as the cells of their texts, the last cell of three characters."""
    if values.max(initial=0) < 2**31:
        values = values.astype(np.uint32)  # divides several times as fast
    rest = values // 1000
    columns = [_table(3, True)[(values - rest * 1000 + 1000 * (rest > 0)).astype(np.intp)]]
    while rest.any():
        values, rest = rest, rest // 10_000
        columns.append(_table(4, True)[(values - rest * 10_000 + 10_000 * (rest > 0)).astype(np.intp)])
    return columns[::-1]


def repeated(characters, count):
    """Cells of one ASCII text in all of `count` rows."""
    padded = characters.ljust(-(-len(characters) // 4) * 4, "\0").encode("ascii")
    return [np.full(count, cell) for cell in np.frombuffer(padded, "<u4")]


def cells(texts):
    """Cells of ASCII texts, all padded to one length."""
    length = max(map(len, texts), default=0)
    array = np.array(texts, dtype=f"S{max(-(-length // 4), 1) * 4}")
    return list(array.view("<u4").reshape(len(texts), -1).T)


def text(columns):
    """Return the text of cells, a list of as many arrays of shape (n,), row by row."""
    rows = np.empty((len(columns[0]), len(columns)), "<u4")
    for n, column in enumerate(columns):
        rows[:, n] = column
    return rows.tobytes().translate(None, b"\0").decode("ascii")


@lru_cache
def _table(width, leading=False):
    """Cells of all numbers of `width` digits; with `leading`, first those without leading zeros.

    Zero is then nothing at all among four digits, which stand before others, and "0" among three, which are last.
    """
    padded = [f"{number:0{width}d}" for number in range(10**width)]
    bare = [f"{number}" for number in range(10**width)]
    bare[0] = "" if width == 4 else "0"
    return np.array((bare if leading else []) + padded, dtype="S4").view("<u4")
