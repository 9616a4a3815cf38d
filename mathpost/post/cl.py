"""Cutter location data (刀位数据): APT CL files in and out.

A CL file says where the tool tip goes and where the tool points, in the workpiece, before any machine is
chosen. Only statements that are understood are taken: one that moves the tool in a way not supported here
(circles, cycles, incremental moves) is refused by name, and so is a word that nobody knows, because skipping it
could leave out a cut.
"""

import codecs
import io
import math
import os
from bisect import bisect_left
from dataclasses import dataclass
from operator import itemgetter

import numpy as np

from mathpost.errors import InputError, as_array
from mathpost.post import apt
from mathpost.rotation import unit

PIECE = 16_384  # records that are worked on at once
BLOCK = 2**19  # bytes that are read at once


@dataclass(frozen=True)
class CLData:
    """A tool path in the workpiece.

    Attributes
    ----------
    points : ndarray, shape (n, 3)
        Tool tip, mm.
    axes : ndarray, shape (n, 3)
        Unit vector from the tip towards the spindle.
    feeds : ndarray, shape (n,)
        Feed of the move to the record, mm/min; NaN where none is stated.
    rapid : ndarray of bool, shape (n,)
        Whether the move to the record is in rapid traverse.
    lines : ndarray of int, shape (n,)
        Line of the file that the record begins on; for error messages.
    remarks : tuple of (int, str)
        Statements that do not move the tool, each with the number of the record that follows it, in the order of
        the file.
    name : str
        The file, for error messages.
    first : int
        Number of records of the file before these.

    The memory of `points` and `axes` holds one component after the other.
    """

    points: np.ndarray
    axes: np.ndarray
    feeds: np.ndarray
    rapid: np.ndarray
    lines: np.ndarray
    remarks: tuple = ()
    name: str = "CL data"
    first: int = 0

    def __len__(self):
        return len(self.points)

    def where(self, record):
        """The place of a record (counted from 0) in the file, for error messages."""
        return f"{self.name}, line {self.lines[record]}, record {self.first + record + 1}"

    def __getstate__(self):
        """For a pickle, which would turn the components of a part back into rows."""
        return vars(self) | {name: np.array(getattr(self, name), order="K") for name in ("points", "axes")}

    def part(self, start, stop):
        """Return records `start` to `stop` (exclusive) as `CLData`, without a copy.

        A remark goes with the record that follows it; those after the last record go with the last part.
        """
        first, last = (bisect_left(self.remarks, record, key=itemgetter(0)) for record in (start, stop))
        remarks = self.remarks[first : last if stop < len(self) else None]
        return CLData(
            *(array[start:stop] for array in (self.points, self.axes, self.feeds, self.rapid, self.lines)),
            tuple((record - start, text) for record, text in remarks),
            self.name,
            self.first + start,
        )

    def at(self, place):
        """Return tip and axis, each (..., 3), between the records: 2.25 is a quarter of the way from 2 to 3.

        The tip goes straight from record to record, the axis on the great circle.
        """
        place = np.asarray(place, dtype=float)
        if np.array_equal(place, np.arange(len(self))):
            return self.points, self.axes
        record = np.clip(np.floor(place).astype(int), 0, len(self) - 1)
        tip, axis = (np.moveaxis(np.take(vectors.T, record, axis=1), 0, -1) for vectors in (self.points, self.axes))
        between = (place != record) & (record < len(self) - 1)
        if between.any():
            first, t = record[between], (place - record)[between][:, None]
            start, end = self.points[first], self.points[first + 1]
            tip[between] = start + t * (end - start)
            axis[between] = _slerp(self.axes[first], self.axes[first + 1], t)
        return tip, axis


def from_arrays(points, axes, *, feed=math.nan, name="CL data"):
    """Make `CLData` of points (n, 3) in mm and axes (n, 3) of any length, all moves at `feed` mm/min."""
    points, axes = as_array(points, 3, "points"), as_array(axes, 3, "axes")
    if points.ndim != 2 or points.shape != axes.shape:
        raise InputError("points and axes", "the same shape (n, 3)", f"{points.shape} and {axes.shape}")
    count = len(points)
    columns = np.array(points.T, order="C"), np.ascontiguousarray(unit(axes).T)
    return _made(*columns, np.full(count, float(feed)), np.zeros(count, bool), np.arange(1, count + 1), (), name)


def read(path):
    """Read an APT CL file.

    Parameters
    ----------
    path : str or path-like
        GOTO with 3 or 6 numbers (three keep the last tool axis, at first 0, 0, 1), FROM (a position, not a
        move), RAPID, FEDRAT, UNITS, ``$`` continuation, ``$$`` comments, LF or CRLF.

    Returns
    -------
    CLData

    Raises
    ------
    InputError
        With file and line: if the file cannot be read, holds no GOTO, or has a statement that is wrong, that
        moves the tool in a way not supported here, or that is not known. The first such place is named.

    Examples
    --------
    >>> cl = read("data/cl/blade.cl")
    >>> len(cl), cl.points[0], cl.axes[0].round(6)
    (5, array([50.31991, 58.40925, 52.13969]), array([0.145196, 0.      , 0.989403]))
    """
    return join(pieces(path))


def parse(text, name="CL data"):
    """Read `CLData` from the text of an APT CL file; `name` begins every error message."""
    content = text.encode("utf-8", "surrogatepass")
    return join(_pieces(_blocks(io.BytesIO(content), len(content)), name, PIECE))


def pieces(path, records=PIECE, *, progress=None):
    """Read an APT CL file in pieces, in memory that does not grow with the file.

    Parameters
    ----------
    path : str or path-like
        As for `read`.
    records : int
        Length of every piece but the last, which may be shorter.
    progress : callable, optional
        Is called with the bytes read so far and the bytes of the file.

    Yields
    ------
    CLData
        Consecutive parts of the file; see `CLData.part`.

    Raises
    ------
    InputError
        As `read`, when the place in the file is reached.

    Examples
    --------
    >>> [(piece.first, len(piece)) for piece in pieces("data/cl/blade.cl", 2)]
    [(0, 2), (2, 2), (4, 1)]
    """
    if records < 1:
        raise InputError("records", "at least 1", f"{records}")
    return _pieces(_file(path), str(path), records, progress)


def join(parts):
    """Return consecutive parts as one `CLData`."""
    parts = list(parts)
    if not parts:
        raise InputError("parts", "at least one", "none")
    if len(parts) == 1:
        return parts[0]
    points, axes = (
        np.concatenate([getattr(part, name).T for part in parts], axis=1) for name in ("points", "axes")
    )
    rows = (np.concatenate([getattr(part, name) for part in parts]) for name in ("feeds", "rapid", "lines"))
    remarks = tuple((part.first - parts[0].first + record, text) for part in parts for record, text in part.remarks)
    return _made(points, axes, *rows, remarks, parts[0].name, parts[0].first)


def _file(path):
    """Yield what `_blocks` does of a file, without a byte order mark."""
    try:
        with open(path, "rb") as file:
            if file.peek(len(codecs.BOM_UTF8)).startswith(codecs.BOM_UTF8):
                file.read(len(codecs.BOM_UTF8))
            yield from _blocks(file, os.fstat(file.fileno()).st_size)
    except OSError as error:
        raise InputError(str(path), "a readable file", error.strerror or str(error)) from None


def _blocks(file, total):
    """Yield blocks of whole lines, each with the bytes up to its end and the bytes of the file."""
    done = 0
    while block := file.read(BLOCK) + file.readline():
        done += len(block)
        yield block, done, total


def _pieces(blocks, name, records, progress=None):
    """Yield `CLData` of so many records each, and the rest, of the blocks of a file."""
    reader, waiting = apt.Reader(name), []
    for block, done, total in blocks:
        first = reader.count
        *arrays, remarks = reader.read(block)
        waiting.append(_made(*arrays, tuple(remarks), name, first))
        # The last piece takes the remarks behind it: none goes out before a record of the next is there.
        if reader.count - waiting[0].first > records:
            read = join(waiting)
            ends = range(records, len(read), records)
            yield from (read.part(end - records, end) for end in ends)
            waiting = [read.part(ends[-1], len(read))]
        if progress:
            progress(done, total)
    reader.finish()
    yield join(waiting)


def _made(points, axes, feeds, rapid, lines, remarks, name, first=0):
    """Make `CLData` of points and axes, shape (3, n), whose arrays nobody may change."""
    arrays = points.T, axes.T, feeds, rapid, lines
    for array in arrays:
        array.setflags(write=False)
    return CLData(*arrays, remarks, name, first)


def to_text(cl, *, title=None, decimals=6):
    """Write `CLData` as the text of an APT CL file, which `parse` reads back; 9 decimals for the axes."""
    lines, feed = ([f"$$ {title}"] if title else []), math.nan
    remarks = {}
    for record, remark in cl.remarks:
        remarks.setdefault(record, []).append(remark)
    for record, (point, axis) in enumerate(zip(cl.points.tolist(), cl.axes.tolist(), strict=True)):
        lines += remarks.get(record, [])
        if cl.rapid[record]:
            lines.append("RAPID")
        elif cl.feeds[record] != feed and not math.isnan(cl.feeds[record]):
            feed = cl.feeds[record]
            lines.append(f"FEDRAT/{feed:g},MMPM")
        numbers = [f"{value:z.{decimals}f}" for value in point] + [f"{value:z.9f}" for value in axis]
        lines.append("GOTO/" + ",".join(numbers))
    return "\n".join([*lines, *remarks.get(len(cl), [])]) + "\n"


def _slerp(start, end, t):
    """Unit vectors on the great circles from `start` to `end` (..., 3) at `t` from 0 to 1, broadcasting."""
    half = np.linalg.norm(end - start, axis=-1, keepdims=True) / 2
    angle = 2 * np.arcsin(np.clip(half, 0, 1))
    sine = np.sin(angle)
    close = sine < 1e-9
    weights = np.where(close, 1 - t, np.sin((1 - t) * angle) / np.where(close, 1, sine))
    return unit(weights * start + np.where(close, t, np.sin(t * angle) / np.where(close, 1, sine)) * end)
