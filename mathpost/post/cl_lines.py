"""The lines of a CL file as statements, its records as arrays, and all that is wrong with it in one error."""

import math
import re

import numpy as np

from mathpost.errors import NUMBER, InputError
from mathpost.post import text

UNIT_TOLERANCE = 1e-3  # how far the printed length of a tool axis may be from 1
BLOCK = 2**19  # bytes that are taken at once: what is made of them fits the processor's cache
ENCODINGS = "utf-8", "gb18030", "cp1252", "latin-1"  # tried in turn; the last takes any byte
LARGEST = 1e9  # of any number
SHOWN = 20  # causes that are listed when a file is refused
REAL = re.compile(rf"{NUMBER}(?:[eE][-+]?\d+)?")
BETWEEN_NUMBERS = re.compile(r"[\d.]\s+$")
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


class Wrong(Exception):
    """What is expected in a statement, and what is found."""


class Lines:
    """Takes the lines of a file one after the other, and keeps where the tool is and what moves it.

    `take`, of those who know the words, takes each statement. Points are kept in mm, in the coordinate system that
    holds.

    Parameters
    ----------
    name : str
        The file, for error messages.
    """

    def __init__(self, name):
        self.name, self.encoding = name, "utf-8"
        self.line, self.start, self.statement, self.in_comment = 1, 0, "", False
        self.point, self.axis = None, [0.0, 0.0, 1.0]
        self.feed, self.rapid, self.scale = math.nan, False, 1.0
        self.first_system, self.system = None, None  # each an origin and the rows of a rotation
        self.runs, self.count = [], 0
        self.problems = []

    def take(self, line, statement):
        """Take one statement."""
        raise NotImplementedError

    def takes_plain(self):
        """Whether a GOTO is now nothing but a move to where it says."""
        return not (self.statement or self.in_comment or self.rapid)

    def take_file(self, content):
        """Take all lines."""
        if not content.isascii():
            self.encoding = next(each for each in ENCODINGS if _decodes(content, each))
        start = 0
        while start < len(content):
            stop = content.find(b"\n", start + BLOCK) + 1 or len(content)
            block = content[start:stop]
            self.take_block(block if block.endswith(b"\n") else block + b"\n")
            start = stop
        if self.statement:
            self.problem(self.start, "", "the continuation of this statement", "the end of the file")

    def take_block(self, block):
        """Take whole lines: runs of plain records together, the others one by one."""
        values, plain = PLAIN.match(block)
        numbers, stated = values[1:], ~np.isnan(values[4:])
        plain &= stated.all(axis=0) | ~stated.any(axis=0)
        ends = None
        for start, stop in text.runs(plain):
            while start < stop and not (plain[start] and self.takes_plain()):
                if ends is None:
                    ends = np.flatnonzero(np.frombuffer(block, np.uint8) == ord("\n")).tolist()
                self.take_raw(block[ends[start - 1] + 1 if start else 0 : ends[start]])
                start += 1
            if start < stop:
                self.take_plain(numbers[:, start:stop])

    def take_plain(self, numbers):
        """Take plain records, shape (6, n), on as many lines; NaN stands for the tool axis that holds."""
        numbers[:3] *= self.scale
        for row, before in zip(numbers[3:], self.axis, strict=True):
            row[:] = text.held(row, before)
        self.add(self.line + np.arange(numbers.shape[1]), numbers)
        self.line += numbers.shape[1]

    def take_raw(self, raw):
        """Take one line: leave out its comment, and take the statement if it is complete."""
        line = raw.decode(self.encoding, "surrogatepass" if self.encoding == "utf-8" else "strict")
        number, self.line = self.line, self.line + 1
        if self.in_comment or line.startswith("$$->"):  # Creo goes on with a comment on the next line
            self.in_comment = line.rstrip().endswith("$")
            return
        part = line.partition("$$")[0].rstrip()
        if not self.statement:
            self.start = number
        if BETWEEN_NUMBERS.search(self.statement) and REAL.match(part.lstrip()):
            self.statement += ","  # two numbers: some systems leave out the comma where they break a line
        if part.endswith("$"):
            self.statement += part[:-1] or " "
            return
        statement, self.statement = (self.statement + part).strip(), ""
        if statement:
            self.take(self.start, statement)

    def add(self, lines, numbers, *, feed=None, rapid=None):
        """Add records, shape (6, n), in mm; `rapid` and `feed` are those that hold unless given."""
        count = numbers.shape[1]
        feed, rapid = self.feed if feed is None else feed, self.rapid if rapid is None else rapid
        self.point, self.axis = numbers[:3, -1].tolist(), numbers[3:, -1].tolist()
        if self.system is not None:
            numbers = _placed(self.system, self.first_system, numbers)
        rapid = np.broadcast_to(rapid, count)
        self.runs.append((lines, numbers, np.where(rapid, math.nan, feed), rapid))
        self.count += count
        self.rapid = False

    def placed(self, direction):
        """A direction in the coordinate system of the records."""
        if self.system is None:
            return direction
        column = np.array([[0, 0, 0, *direction]], dtype=float).T
        return _placed(self.system, self.first_system, column)[3:, 0].tolist()

    def records(self):
        """Return points and axes, shape (3, n), feeds, rapid and lines.

        Refuses the file if anything in it is wrong, and says all that is.
        """
        if not self.runs:
            self.refuse_problems()
            raise InputError(self.name, "at least one GOTO", "none")
        lines, numbers, feeds, rapid = (
            np.concatenate(columns, axis=-1) for columns in zip(*self.runs, strict=True)
        )
        points, axes = numbers[:3], numbers[3:]
        with np.errstate(over="ignore"):
            length = np.linalg.norm(axes, axis=0)
        for record in np.flatnonzero(~(np.abs(length - 1) <= UNIT_TOLERANCE)).tolist():
            shown = ", ".join(f"{value:g}" for value in axes[:, record])
            found = f"({shown}) of length {length[record]:.6g}"
            self.problem(int(lines[record]), "GOTO", f"a unit tool axis (to {UNIT_TOLERANCE})", found)
        self.refuse_problems()
        return points, axes / length, feeds, rapid, lines

    def go(self, line, point, axis, *, feed=None, rapid=None):
        self.add([line], np.array([[*point, *axis]], dtype=float).T, feed=feed, rapid=rapid)

    def problem(self, line, word, expected, found):
        self.problems.append((line, word, expected, found))

    def refuse_problems(self):
        """Raise the `InputError` that lists all problems, each cause once."""
        if not self.problems:
            return
        causes = {}
        for line, word, expected, found in sorted(self.problems, key=lambda problem: problem[0]):
            causes.setdefault((word, expected), []).append((line, found))
        (word, expected), places = next(iter(causes.items()))
        more = [
            f"line {there[0][0]}, {other}: expected {wanted}, found {there[0][1]}{_again(there)}"
            for (other, wanted), there in list(causes.items())[1:SHOWN]
        ]
        if len(causes) > SHOWN:
            more.append(f"and {len(causes) - SHOWN} more causes")
        if more:
            more.append(
                f"{len(self.problems)} statements of {len(causes)} kinds; --ignore WORD takes a word on trust"
            )
        found = "\n  ".join([places[0][1] + _again(places), *more])
        where = f"{self.name}, line {places[0][0]}" + (f", {word}" if word else "")
        raise InputError(where, expected, found)

    def numbers(self, words):
        return [self.number(word) for word in words]

    def number(self, word):
        if not REAL.fullmatch(word.strip()):
            raise Wrong("a number", repr(word.strip()))
        value = float(word)
        if not abs(value) < LARGEST:
            raise Wrong(f"a finite number below {LARGEST:g}", word.strip())
        return value


def _decodes(content, encoding):
    try:
        content.decode(encoding, "surrogatepass" if encoding == "utf-8" else "strict")
    except UnicodeDecodeError:
        return False
    return True


def _again(places):
    return f" ({len(places)} times, up to line {places[-1][0]})" if len(places) > 1 else ""


def _placed(system, first, numbers):
    """Records, shape (6, n), in the first of two coordinate systems."""
    (origin, rotation), (first_origin, first_rotation) = system, first
    points = first_rotation.T @ (rotation @ numbers[:3] + (origin - first_origin)[:, None])
    return np.concatenate([points, first_rotation.T @ (rotation @ numbers[3:])])
