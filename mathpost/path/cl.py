"""Cutter location data (刀位数据): APT CL files in and out.

A CL file says where the tool tip goes and where the tool points, in the workpiece, before any machine is
chosen. `mathpost.path.cl_words` explains its statements.
"""

from __future__ import annotations

import codecs
import math
from collections import Counter
from collections.abc import Collection, Iterable
from dataclasses import dataclass, replace
from itertools import pairwise
from operator import itemgetter
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from mathpost.errors import InputError, as_array
from mathpost.files import read_bytes
from mathpost.formula import slices
from mathpost.path.cl_lines import LARGEST, Records
from mathpost.path.cl_words import Statements
from mathpost.path.modal import Command, Remark
from mathpost.path.pieces import Arc, Hole, moved
from mathpost.rotation import angle_of_chord, unit

ARC_TOLERANCE = 0.001  # mm
OPPOSITE = 1e-6  # of the sum of two tool axes
NO_UNITS = "no UNITS: mm assumed, --unit states it"


@dataclass(frozen=True)
class CLData:
    """A tool path in the workpiece.

    A remark, a statement that does not move the tool, is a pair: the number of the record that follows it, and a
    comment or a `mathpost.path.modal.Command`. With `normals` `mathpost.shop.measure.cutter.compensated` makes the
    path of a different cutter. In memory each component of `points` and `axes` lies together.
    """

    points: np.ndarray  # shape (n, 3), tool tip, mm
    axes: np.ndarray  # shape (n, 3), the unit vector from it towards the spindle
    feeds: np.ndarray  # shape (n,), of the move to the record: mm/min, NaN where none is stated
    rapid: np.ndarray  # shape (n,), whether it is in rapid traverse
    lines: np.ndarray  # shape (n,), line of the file where the record begins; for error messages
    remarks: tuple[Remark, ...] = ()
    name: str = "CL data"  # the file, for error messages
    first: int = 0  # number of its records before these
    notes: tuple[str, ...] = ()  # how the file was interpreted, where its reader should know: for the report
    coordinates: str = ""  # in whose coordinates its GOTO were read, see `mathpost.path.coordinates`
    normals: np.ndarray | None = None  # shape (n, 3), unit vectors out of the part that is touched, or NaN
    pieces: tuple[Arc | Hole, ...] = ()  # arcs and holes that runs of records make, in order

    def __len__(self) -> int:
        return len(self.points)

    def where(self, record: float) -> str:
        """Say where in the file a record (counted from 0), or the next one, is; for error messages."""
        record = math.ceil(record)
        return f"{self.name}, line {self.lines[record]}, record {self.first + record + 1}"

    def part(self, start: int, stop: int) -> CLData:
        """Return records `start` to `stop` (exclusive), and the remarks before them, as `CLData` without a copy."""
        end = stop if stop < len(self) else stop + 1  # the last part has what follows it, too
        remarks = tuple((record - start, text) for record, text in self.remarks if start <= record < end)
        rows = slice(start, stop)
        pieces = tuple(moved(piece, -start) for piece in self.pieces if start <= piece.first and piece.last < stop)
        return replace(
            self,
            points=self.points[rows],
            axes=self.axes[rows],
            feeds=self.feeds[rows],
            rapid=self.rapid[rows],
            lines=self.lines[rows],
            remarks=remarks,
            first=self.first + start,
            normals=None if self.normals is None else self.normals[rows],
            pieces=pieces,
        )

    def by_setup(self) -> list[tuple[CLData, float | None, int | None]]:
        """Return the parts of the path between changes of the tool or the work offset.

        Each with the length of its tool, mm, and the number of its work offset, None where nothing says it.
        """
        changes: dict[int, dict[str, Any]] = {0: {}}
        for kind, value in (("tool", 1), ("work offset", 0)):
            for record, command in commands(self.remarks, kind):
                if record < len(self):
                    changes.setdefault(record, {})[kind] = command.values[value]
        parts: list[tuple[CLData, float | None, int | None]] = []
        held: dict[str, Any] = {"tool": None, "work offset": None}
        for first, stop in pairwise([*sorted(changes), len(self)]):
            held |= changes[first]
            parts.append((self.part(first, stop), held["tool"], held["work offset"]))
        return parts

    def at(self, place: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
        """Return tip and axis, each (..., 3), between the records: 2.25 is a quarter of the way from 2 to 3.

        The tip goes straight from record to record, the axis on the great circle.
        """
        place = np.asarray(place, dtype=float)
        if place.shape == (len(self),) and np.array_equal(place, np.arange(len(self))):
            return self.points, self.axes
        record = np.clip(np.floor(place).astype(int), 0, len(self) - 1)
        tip, axis = (
            np.moveaxis(np.array([component[record] for component in vectors.T]), 0, -1)
            for vectors in (self.points, self.axes)
        )
        between = (place != record) & (record < len(self) - 1)
        if between.any():
            first, t = record[between], (place - record)[between][:, None]
            tip[between] += t * (self.points[first + 1] - self.points[first])
            axis[between] = _slerp(self.axes[first], self.axes[first + 1], t)
        return tip, axis


def commands(remarks: Iterable[Remark], kind: str) -> list[tuple[int, Command]]:
    """Return those of `remarks`, of CL data or of blocks, that are a `Command` of this kind."""
    return [(row, remark) for row, remark in remarks if isinstance(remark, Command) and remark.kind == kind]


def feed_times(tips: np.ndarray, feeds: np.ndarray) -> np.ndarray:
    """Seconds that the feed gives the moves between tips (m, 3), shape (m - 1,); NaN where none is stated."""
    lengths = np.empty(max(len(tips) - 1, 0))
    for moves in slices(lengths.shape):
        lengths[moves] = np.linalg.norm(np.diff(tips[moves.start : moves.stop + 1], axis=0), axis=1)
    return 60 * lengths / feeds


def from_arrays(points: ArrayLike, axes: ArrayLike, *, feed: float = math.nan, name: str = "CL data") -> CLData:
    """Make `CLData` of points (n, 3) in mm and axes (n, 3) of any length, all moves at `feed` mm/min."""
    points, axes = as_array(points, 3, "points"), as_array(axes, 3, "axes")
    if points.ndim != 2 or points.shape != axes.shape:
        raise InputError("points and axes", "the same shape (n, 3)", f"{points.shape} and {axes.shape}")
    if not (count := len(points)):
        raise InputError("points and axes", "at least one record", "none")
    if (largest := np.abs(points).max()) >= LARGEST:
        raise InputError("points", f"mm below {LARGEST:g}", f"{largest:g}")
    axes = axes / np.maximum(np.abs(axes).max(axis=1, keepdims=True), 1e-300)  # whatever their size
    columns = np.array(points.T, order="C"), np.ascontiguousarray(unit(axes).T), np.full(count, float(feed))
    return _made(*columns, np.zeros(count, bool), np.arange(1, count + 1), (), name)


def read(
    path: Path | str, *, tolerance: float = ARC_TOLERANCE, ignored: Collection[str] = (), unit: str | None = None,
    feed: float | None = None,
) -> CLData:  # fmt: skip
    """Read an APT CL file as `CLData`.

    Parameters
    ----------
    path : str or path-like
        Its words are those of `mathpost.path.cl_words`; its encoding is UTF-8, GBK or Windows-1252.
    tolerance : float
        Chordal tolerance, mm: how far the chords that replace an arc may be from it.
    ignored : collection of str
        Hazardous or unknown words to be taken as comments; words that move the tool are refused.
    unit : "mm" or "inch", optional
        The unit of a file without UNITS; by default mm, and the notes say so.
    feed : float, optional
        The feed, mm/min, of the moves before the first FEDRAT.

    Raises
    ------
    InputError
        If statements are wrong, hazardous or not known: it names them all, with file and line. Or if the file
        cannot be read, has no GOTO, or its last GOTO has fewer numbers than the one before it (a truncated file),
        or if `ignored` names a word that moves the tool.

    Examples
    --------
    >>> cl = read("data/cl/blade.cl")
    >>> len(cl), cl.points[0], cl.axes[0].round(6)
    (5, array([50.31991, 58.40925, 52.13969]), array([0.145196, 0.      , 0.989403]))
    """
    content = read_bytes(path).removeprefix(codecs.BOM_UTF8)
    made = parse(content, str(path), tolerance=tolerance, ignored=ignored, unit=unit, feed=feed)
    *before, last = content[-1000:].rsplit(b"\n", 2)
    if b"/" not in last:
        return made
    wanted = before[-1].count(b",") if before and before[-1].startswith(b"GOTO/") else 0
    if last.startswith(b"GOTO/") and last.count(b",") < wanted:
        expected = f"{wanted + 1} numbers, as in the line before"
        found = f"the end of the file after {last[-60:].decode(errors='replace')!r}"
        raise InputError(f"{path}, line {made.lines[-1]}", expected, found)
    return replace(made, notes=(*made.notes, "no line break at the end: the last statement may be cut off"))


def parse(
    text: str | bytes, name: str = "CL data", *, tolerance: float = ARC_TOLERANCE, ignored: Collection[str] = (),
    unit: str | None = None, feed: float | None = None,
) -> CLData:  # fmt: skip
    """Read the text or the bytes of an APT CL file; see `read`. `name` begins every error message."""
    statements = Statements(name, tolerance, ignored)
    statements.assume(unit, feed)
    statements.take_file(text.encode("utf-8", "surrogatepass") if isinstance(text, str) else text)
    remarks = sorted(statements.remarks, key=itemgetter(0))
    records, remarks, over = _turned_over(statements.records(), remarks, statements.counts)
    notes = [NO_UNITS] * (not statements.units_stated)
    notes += [f"{what}: {count}" for what, count in statements.counts.items()]
    made = _made(*records, tuple(remarks), name, tuple(notes))
    pieces = tuple(moved(piece, int((over <= piece.first).sum())) for piece in statements.pieces)
    made = replace(made, coordinates=statements.coordinates.rule, pieces=pieces)
    if not statements.normals:
        return made
    lines, stated = zip(*statements.normals.items(), strict=True)
    normals = np.full(made.points.shape, math.nan)
    normals[np.searchsorted(made.lines, lines, side="right") - 1] = stated
    return replace(made, normals=normals)


def _turned_over(
    records: Records, remarks: list[Remark], counts: Counter[str]
) -> tuple[Records, list[Remark], np.ndarray]:
    """Insert a record half way along each rapid move that turns the tool by 180°; return these moves, too."""
    points, axes, feeds, rapid, lines = records
    changes = [record for record, _ in commands(remarks, "tool")]
    over = 1 + np.flatnonzero(rapid[1:])
    over = over[np.linalg.norm(axes[:, over] + axes[:, over - 1], axis=0) < OPPOSITE]
    over = np.setdiff1d(over, changes)  # the new tool comes from elsewhere
    if not over.size:
        return records, remarks, over
    counts["rapid moves that turn the tool by 180°, with a record half way"] += len(over)
    before = axes[:, over]
    up = np.where(np.abs(before[2]) < 0.9, [[0], [0], [1]], [[1], [0], [0]])  # or X, where the tool points up
    across = unit((up - (up * before).sum(axis=0) * before).T).T
    half = (points[:, over - 1] + points[:, over]) / 2
    remarks = [(record + int((over < record).sum()), remark) for record, remark in remarks]
    points, axes = np.insert(points, over, half, axis=1), np.insert(axes, over, across, axis=1)
    feeds, rapid, lines = (np.insert(column, over, column[over]) for column in (feeds, rapid, lines))
    return (points, axes, feeds, rapid, lines), remarks, over


def _made(
    points: np.ndarray, axes: np.ndarray, feeds: np.ndarray, rapid: np.ndarray, lines: np.ndarray,
    remarks: tuple[Remark, ...], name: str, notes: tuple[str, ...] = (),
) -> CLData:  # fmt: skip
    """Make `CLData` of points and axes, shape (3, n), with read-only arrays."""
    arrays = points.T, axes.T, feeds, rapid, lines
    for array in arrays:
        array.setflags(write=False)
    return CLData(*arrays, remarks, name, notes=notes)


def to_text(cl: CLData, *, title: str | None = None, decimals: int = 6) -> str:
    """Write `CLData` as the text of an APT CL file, which `parse` reads back; 9 decimals for the axes."""
    lines, feed = ([f"$$ {title}"] if title else []), math.nan
    remarks: dict[int, list[str]] = {}
    for record, remark in cl.remarks:
        said = remark.statement if isinstance(remark, Command) else remark
        remarks.setdefault(record, []).append(said)
    for record, (point, axis) in enumerate(zip(cl.points.tolist(), cl.axes.tolist(), strict=True)):
        lines += remarks.get(record, [])
        if cl.rapid[record]:
            lines.append("RAPID")
        elif cl.feeds[record] != feed and not math.isnan(cl.feeds[record]):
            feed = cl.feeds[record]
            lines.append(f"FEDRAT/{feed:g},MMPM")
        normal = [] if cl.normals is None or np.isnan(cl.normals[record, 0]) else cl.normals[record].tolist()
        numbers = [f"{value:z.{decimals}f}" for value in point] + [f"{value:z.9f}" for value in [*axis, *normal]]
        lines.append("GOTO/" + ",".join(numbers))
    return "\n".join([*lines, *remarks.get(len(cl), [])]) + "\n"


def _slerp(start: np.ndarray, end: np.ndarray, t: np.ndarray) -> np.ndarray:
    """Unit vectors on the great circles from `start` to `end` (..., 3) at `t` from 0 to 1, broadcasting."""
    angle = angle_of_chord(np.linalg.norm(end - start, axis=-1, keepdims=True))
    close = (sine := np.sin(angle)) < 1e-9
    first, last = (np.where(close, part, np.sin(part * angle) / np.where(close, 1, sine)) for part in (1 - t, t))
    return unit(first * start + last * end)
