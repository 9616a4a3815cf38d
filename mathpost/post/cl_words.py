"""The words of APT CL files: statements in, records as arrays out.

Only statements that are understood are taken. One that moves the tool in a way not supported here (circles,
cycles, incremental moves) is refused by name, and so is a word that nobody knows, because skipping it could leave
out a cut.
"""

import math
import re

import numpy as np

from mathpost.errors import InputError
from mathpost.post import text

UNIT_TOLERANCE = 1e-3  # how far the printed length of a tool axis may be from 1
MM_PER_INCH = 25.4
BLOCK = 2**19  # bytes that are taken at once: what is made of them fits the processor's cache
NUMBER = re.compile(rf"{text.NUMBER}(?:[eE][-+]?\d+)?")
# One record of three or six numbers, and nothing else: most lines of most files.
PLAIN = text.Pattern(
    [
        text.Item("GOTO"),
        text.Item("/", "number"),
        *[text.Item(",", "number")] * 2,
        *[text.Item(",", "number", optional=True)] * 3,
    ],
    relaxed=True,
)

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


class Statements:
    """Takes the statements of a file one after the other, and keeps what holds from one to the next."""

    def __init__(self, name):
        self.name, self.line = name, 1
        self.axis, self.feed, self.rapid, self.scale = [0.0, 0.0, 1.0], math.nan, False, 1.0
        self.statement, self.start = "", 0  # what is continued, and the line that it begins on
        self.runs, self.count, self.remarks = [], 0, []

    def take_file(self, content):
        """Take all lines."""
        start = 0
        while start < len(content):
            stop = content.find(b"\n", start + BLOCK) + 1 or len(content)
            block = content[start:stop]
            self.take_block(block if block.endswith(b"\n") else block + b"\n")
            start = stop
        if self.statement:
            raise self.error(self.start, "the continuation of this statement", "the end of the file")
        if not self.count:
            raise InputError(self.name, "at least one GOTO", "none")

    def take_block(self, block):
        """Take whole lines: runs of plain records together, the others one by one."""
        values, plain = PLAIN.match(block)
        numbers, stated = values[1:], ~np.isnan(values[4:])
        plain &= stated.all(axis=0) | ~stated.any(axis=0)
        ends = None
        for start, stop in text.runs(plain):
            while start < stop and (self.statement or not plain[start]):
                if ends is None:
                    ends = np.flatnonzero(np.frombuffer(block, np.uint8) == ord("\n")).tolist()
                self.take_raw(block[ends[start - 1] + 1 if start else 0 : ends[start]])
                start += 1
            self.take_plain(numbers[:, start:stop])

    def take_plain(self, numbers):
        """Take plain records, shape (6, n), on as many lines; NaN stands for the tool axis that holds."""
        numbers[:3] *= self.scale
        for row, before in zip(numbers[3:], self.axis, strict=True):
            row[:] = text.held(row, before)
        if self.rapid and numbers.size:
            self.add(self.line, numbers[:, :1])
            self.line, numbers = self.line + 1, numbers[:, 1:]
        if numbers.size:
            self.add(self.line, numbers)
            self.line += numbers.shape[1]

    def add(self, line, numbers):
        """Add records, shape (6, n), the first of which begins on `line`: all at one feed, or one in rapid."""
        self.runs.append((line, numbers, math.nan if self.rapid else self.feed, self.rapid))
        self.axis = numbers[3:, -1].tolist()
        self.count += numbers.shape[1]
        self.rapid = False

    def records(self):
        """Return points and axes, shape (3, n), feeds, rapid and lines; refuse an axis that is not unit."""
        starts, numbers, feeds, rapid = zip(*self.runs, strict=True)
        counts = np.array([run.shape[1] for run in numbers])
        numbers = np.concatenate(numbers, axis=1)
        lines = np.arange(numbers.shape[1]) + np.repeat(starts - np.cumsum(counts) + counts, counts)
        points, axes = numbers[:3], numbers[3:]
        with np.errstate(over="ignore"):
            length = np.linalg.norm(axes, axis=0)
        wrong = np.flatnonzero(~(np.abs(length - 1) <= UNIT_TOLERANCE))
        if wrong.size:
            axis, length = axes[:, wrong[0]], length[wrong[0]]
            found = f"({', '.join(f'{value:g}' for value in axis)}) of length {length:.6g}"
            raise self.error(lines[wrong[0]], f"a unit tool axis (to {UNIT_TOLERANCE})", found)
        return points, axes / length, np.repeat(feeds, counts), np.repeat(rapid, counts), lines

    def take_raw(self, raw):
        """Take one line: leave out its comment, and take the statement if it is complete."""
        try:
            line = raw.decode("utf-8")
        except UnicodeDecodeError as error:
            raise self.error(self.line, "UTF-8 text", f"byte 0x{raw[error.start]:02x}") from None
        part = line.partition("$$")[0].rstrip()
        if not self.statement:
            self.start = self.line
        self.line += 1
        if part.endswith("$"):
            self.statement += part[:-1] or " "
            return
        statement, self.statement = (self.statement + part).strip(), ""
        if statement:
            self.take(self.start, statement)

    def take(self, line, statement):
        major, slash, minor = statement.partition("/")
        words = major.upper().split()
        if words == ["GOTO"] and slash:
            self.add(line, np.array(self.pose(line, minor))[:, None])
        elif words == ["FROM"] and slash:
            self.axis = self.pose(line, minor)[3:]
            self.remarks.append((self.count, statement))
        elif words == ["RAPID"] and not slash:
            self.rapid = True
        elif words == ["FEDRAT"]:
            self.fedrat(line, minor)
        elif words == ["UNITS"]:
            self.units(line, minor)
        else:
            self.remark(line, statement, words[0] if words else "")

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
        upper = statement.upper()
        moves = "CIRCLE" if "CIRCLE" in upper and word not in FREE_TEXT else word
        if moves in MOVES_REFUSED and upper.replace(" ", "") != "CYCLE/OFF":
            raise self.error(line, "GOTO moves only", f"{moves}, which moves the tool in a way not supported")
        if word not in REMARKS and not upper.startswith(("TOOL PATH", "CYCLE")):
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
