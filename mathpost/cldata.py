"""Cutter location data (刀位数据): APT CL files in and out.

A CL file says where the tool tip goes and where the tool points, in the workpiece, before any machine is
chosen. Only statements that are understood are taken: one that moves the tool in a way not supported here
(circles, cycles, incremental moves) is refused by name, and so is a word that nobody knows, because skipping it
could leave out a cut.
"""

import math
import re
from dataclasses import dataclass

import numpy as np

from mathpost.errors import InputError, as_array
from mathpost.files import read_text
from mathpost.rotation import unit

UNIT_TOLERANCE = 1e-3  # how far the printed length of a tool axis may be from 1
MM_PER_INCH = 25.4
NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")
# One record of six numbers, and nothing else, on a line: most lines of most files. A run of them is read at once.
PLAIN = re.compile(rf"GOTO */ *({NUMBER.pattern}(?: *, *{NUMBER.pattern}){{5}}) *\r?\n", re.ASCII)
LEAST_PLAIN, MOST_PLAIN = 8, 20_000

# Statements that say something but do not move the tool: they go into the program as comments.
REMARKS = frozenset(
    "PARTNO PPRINT MACHIN MACHINE TLDATA TLAXIS TOOLNO LOADTL LOAD SELECT SELCTL CUTTER CUTCOM SPINDL COOLNT "
    "MULTAX MODE MSYS CSYS INTOL OUTTOL TOLER LINTOL CLEARP CLRSRF OPSTOP STOP OPSKIP PREFUN AUXFUN DELAY INSERT "
    "DISPLY LEADER SEQNO REWIND PAINT CHECK SAFETY TMARK PLABEL REMARK PROGRAM OP_NAME CALSUB FINI END "
    "END-OF-PATH CATPROCESS CATPRODUCT TPRINT".split()
)
FREE_TEXT = frozenset(["PARTNO", "PPRINT", "REMARK", "INSERT", "TPRINT", "CATPROCESS", "CATPRODUCT"])
MOVES_REFUSED = frozenset(
    "CIRCLE CYCLE GODLTA GOHOME GOFWD GOBACK GOLFT GORGT GOUP GODOWN GOBAK INDIRV INDIRP MOVARC ARC SPLINE NURBS "
    "POCKET RETRCT RETRACT ROTABL ROTHED ROTATE TRANS TRACUT COPY MATRIX ORIGIN HEAD THREAD".split()
)


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
        Statements that do not move the tool, each with the number of the record that follows it.
    name : str
        The file, for error messages.
    """

    points: np.ndarray
    axes: np.ndarray
    feeds: np.ndarray
    rapid: np.ndarray
    lines: np.ndarray
    remarks: tuple = ()
    name: str = "CL data"

    def __len__(self):
        return len(self.points)

    def where(self, record):
        """The place of a record (counted from 0) in the file, for error messages."""
        return f"{self.name}, line {self.lines[record]}, record {record + 1}"

    def at(self, place):
        """Return tip and axis, each (..., 3), between the records: 2.25 is a quarter of the way from 2 to 3.

        The tip goes straight from record to record, the axis on the great circle.
        """
        place = np.asarray(place, dtype=float)
        record = np.clip(np.floor(place).astype(int), 0, max(len(self) - 2, 0))
        following, t = np.minimum(record + 1, len(self) - 1), (place - record)[..., None]
        tip = self.points[record] + t * (self.points[following] - self.points[record])
        return tip, _slerp(self.axes[record], self.axes[following], t)


def from_arrays(points, axes, *, feed=math.nan, name="CL data"):
    """Make `CLData` of points (n, 3) in mm and axes (n, 3) of any length, all moves at `feed` mm/min."""
    points, axes = as_array(points, 3, "points").copy(), as_array(axes, 3, "axes")
    if points.ndim != 2 or points.shape != axes.shape:
        raise InputError("points and axes", "the same shape (n, 3)", f"{points.shape} and {axes.shape}")
    axes, count = unit(axes), len(points)
    return _checked(
        points, axes, np.full(count, float(feed)), np.zeros(count, bool), np.arange(1, count + 1), (), name
    )


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
        moves the tool in a way not supported here, or that is not known.

    Examples
    --------
    >>> cl = read("data/cl/blade.cl")
    >>> len(cl), cl.points[0], cl.axes[0].round(6)
    (5, array([50.31991, 58.40925, 52.13969]), array([0.145196, 0.      , 0.989403]))
    """
    return parse(read_text(path), str(path))


def parse(text, name="CL data"):
    """Read `CLData` from the text of an APT CL file; `name` begins every error message."""
    reader = _Reader(name)
    at, line = 0, 1
    while at < len(text):
        rows, end = _plain(text, at)
        if reader.take_plain(line, rows):
            line += len(rows)
        else:
            end = end if rows else text.find("\n", at) + 1 or len(text)
            for part in text[at:end].splitlines():
                reader.take_line(line, part)
                line += 1
        at = end
    return reader.result()


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


def _plain(text, at):
    """The numbers of the plain records from `at` on, as text, and where they end."""
    rows = []
    while len(rows) < MOST_PLAIN and (found := PLAIN.match(text, at)):
        rows.append(found[1])
        at = found.end()
    return rows, at


class _Reader:
    """Collects the records of one file, and what holds for the next one."""

    def __init__(self, name):
        self.name = name
        self.numbers, self.feeds, self.rapid, self.lines, self.remarks = [], [], [], [], []
        self.axis, self.feed, self.rapid_next, self.scale = [0.0, 0.0, 1.0], math.nan, False, 1.0
        self.pending, self.start = "", 0
        self.count, self.closed = 0, []

    def take_line(self, line, text):
        """Take one line: leave out its comment, and take the statement if it is complete."""
        part = text.partition("$$")[0].rstrip()
        self.start = self.start if self.pending else line
        if part.endswith("$"):
            self.pending += part[:-1]
            return
        statement, self.pending = (self.pending + part).strip(), ""
        if statement:
            self.take(self.start, statement)

    def take_plain(self, line, rows):
        """Take plain records, the first of them on `line`; return whether that was possible."""
        if len(rows) < LEAST_PLAIN or self.pending or self.rapid_next:
            return False
        numbers = np.array(",".join(rows).split(","), dtype=float).reshape(-1, 6)
        if not np.isfinite(numbers).all():
            return False
        numbers[:, :3] *= self.scale
        self.close()
        count = len(rows)
        self.closed.append(
            (numbers, np.full(count, self.feed), np.zeros(count, bool), np.arange(line, line + count))
        )
        self.axis = numbers[-1, 3:].tolist()
        self.count += count
        return True

    def close(self):
        """Turn the records that were read one by one into arrays."""
        if self.numbers:
            self.closed.append(tuple(map(np.array, (self.numbers, self.feeds, self.rapid, self.lines))))
            self.numbers, self.feeds, self.rapid, self.lines = [], [], [], []

    def take(self, line, statement):
        major, slash, minor = statement.partition("/")
        words = major.upper().split()
        if words == ["GOTO"] and slash:
            self.goto(line, minor)
        elif words == ["FROM"] and slash:
            self.axis = self.pose(line, minor)[3:]
            self.remarks.append((self.count, statement))
        elif words == ["RAPID"] and not slash:
            self.rapid_next = True
        elif words == ["FEDRAT"]:
            self.fedrat(line, minor)
        elif words == ["UNITS"]:
            self.units(line, minor)
        else:
            self.remark(line, statement, words[0] if words else "")

    def goto(self, line, minor):
        self.numbers.append(self.pose(line, minor))
        self.axis = self.numbers[-1][3:]
        self.count += 1
        self.feeds.append(math.nan if self.rapid_next else self.feed)
        self.rapid.append(self.rapid_next)
        self.lines.append(line)
        self.rapid_next = False

    def pose(self, line, minor):
        values = [self.number(line, word) for word in minor.split(",")]
        if len(values) not in (3, 6):
            raise self.error(line, "3 or 6 numbers", f"{len(values)}")
        return [value * self.scale for value in values[:3]] + (values[3:] or self.axis)

    def fedrat(self, line, minor):
        words = [word.strip().upper() for word in minor.split(",")]
        unit = [word for word in words if word in ("MMPM", "IPM")]
        values = [word for word in words if word not in ("MMPM", "IPM")]
        if len(values) != 1 or len(unit) > 1:
            raise self.error(line, "FEDRAT/ a number and MMPM or IPM", minor.strip() or "nothing")
        value = self.number(line, values[0])
        if value <= 0:
            raise self.error(line, "a feed above 0", f"{value:g}")
        self.feed = value * (MM_PER_INCH if unit == ["IPM"] else self.scale if not unit else 1.0)

    def units(self, line, minor):
        unit = minor.strip().upper()
        scales = {"MM": 1.0, "INCH": MM_PER_INCH, "INCHES": MM_PER_INCH}
        if unit not in scales:
            raise self.error(line, "UNITS/MM or UNITS/INCH", unit or "nothing")
        self.scale = scales[unit]

    def remark(self, line, statement, word):
        text = statement.upper()
        moves = "CIRCLE" if "CIRCLE" in text and word not in FREE_TEXT else word
        if moves in MOVES_REFUSED and text.replace(" ", "") != "CYCLE/OFF":
            raise self.error(line, "GOTO moves only", f"{moves}, which moves the tool in a way not supported")
        if word not in REMARKS and not text.startswith(("TOOL PATH", "CYCLE")):
            raise self.error(line, "a CL statement", repr(statement[:40]))
        self.remarks.append((self.count, statement))

    def number(self, line, word):
        if not NUMBER.fullmatch(word.strip()):
            raise self.error(line, "a number", repr(word.strip()))
        value = float(word)
        if not math.isfinite(value):
            raise self.error(line, "a finite number", word.strip())
        return value

    def error(self, line, expected, found):
        return InputError(f"{self.name}, line {line}", expected, found)

    def result(self):
        if self.pending:
            raise self.error(self.start, "the continuation of this statement", "the end of the file")
        if not self.count:
            raise InputError(self.name, "at least one GOTO", "none")
        self.close()
        numbers, feeds, rapid, lines = map(np.concatenate, zip(*self.closed, strict=True))
        return _checked(numbers[:, :3], numbers[:, 3:], feeds, rapid, lines, tuple(self.remarks), self.name)


def _checked(points, axes, feeds, rapid, lines, remarks, name):
    """Normalise the axes, refuse those that are not unit to `UNIT_TOLERANCE`, and make the arrays read-only."""
    with np.errstate(over="ignore"):
        length = np.linalg.norm(axes, axis=1)
    wrong = np.flatnonzero(~(np.abs(length - 1) <= UNIT_TOLERANCE))
    if wrong.size:
        found = f"({', '.join(f'{value:g}' for value in axes[wrong[0]])}) of length {length[wrong[0]]:.6g}"
        raise InputError(f"{name}, line {lines[wrong[0]]}", f"a unit tool axis (to {UNIT_TOLERANCE})", found)
    arrays = points, axes / length[:, None], feeds, rapid, lines
    for array in arrays:
        array.setflags(write=False)
    return CLData(*arrays, remarks, name)


def _slerp(start, end, t):
    """Unit vectors on the great circles from `start` to `end` (..., 3) at `t` from 0 to 1, broadcasting."""
    half = np.linalg.norm(end - start, axis=-1, keepdims=True) / 2
    angle = 2 * np.arcsin(np.clip(half, 0, 1))
    sine = np.sin(angle)
    close = sine < 1e-9
    weights = np.where(close, 1 - t, np.sin((1 - t) * angle) / np.where(close, 1, sine))
    return unit(weights * start + np.where(close, t, np.sin(t * angle) / np.where(close, 1, sine)) * end)
