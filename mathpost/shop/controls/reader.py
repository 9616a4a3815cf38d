"""The text of a program to its blocks, in the words of any control, whoever wrote it.

What is read is what the file of the control says. A word that is not in it is an error with its line: it may move
an axis. Plain lines, that move axes and change no mode but their feed, are taken many at a time; any other is taken
word by word, by `ProgramReader.take_line`. Arcs and drilling cycles become the points that the tool goes through.
"""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import dataclass

import numpy as np

from mathpost.errors import InputError, MathpostError
from mathpost.files import NUMBER
from mathpost.machine import MM_PER_INCH, Machine
from mathpost.path.nc_words import bare, tidy
from mathpost.shop.controls import arcs_and_holes, calls, stops
from mathpost.shop.controls.blocks import FEED, PLANES, Blocks, axis_word
from mathpost.shop.controls.control import Control, control_for
from mathpost.shop.controls.coordinates import Setup
from mathpost.shop.controls.lines import Drilling, Line, plain, seconds, tool_name, whole_number
from mathpost.shop.controls.meanings import ASSUMED, MODES, MOTIONS, NUMBERS, POSITIONING, STATEMENTS
from mathpost.shop.controls.plane_forms import lacking
from mathpost.shop.controls.track import Blind, Track
from mathpost.shop.controls.variables import Variables
from mathpost.shop.controls.words import Word

MOST_DIGITS = 40  # in a row


def read(text: str, machine: Machine, control: Control | str = "heidenhain", *, name: str = "program") -> Blocks:
    """Return the `Blocks` of a program's text; `InputError` with its `name` and the line if a word is not known."""
    return follow(text, machine, control, name=name).blocks


@dataclass(frozen=True)
class Program:
    """A program as its control takes it."""

    blocks: Blocks  # n moves; X Y Z count from the machine file's origin
    lines: np.ndarray  # shape (n,), the line of the text that each move is on
    machines: list[tuple[int, Machine]]  # from which move on, the machine with the tool that it then has
    skipped: dict[str, int]  # words that move no axis, by their kind: how often they occur
    began: np.ndarray  # shape (j,), words from where the first move goes, NaN if nobody knows
    # Moves from or to where nobody knows all axes; those to where nobody does are no others.
    blind: tuple[Blind, ...]
    dwell: float  # seconds that it waits, by words that say so
    assumed: tuple[str, ...]  # what was assumed, as sentences


def follow(
    text: str, machine: Machine, control: Control | str = "heidenhain", *, setup: Setup | None = None,
    name: str = "program",
) -> Program:  # fmt: skip
    """Return the motion of a program's text, as a `Program`; `setup` holds the contents of the control's tables.

    `InputError` names the line where a word is not known, the program does not run from line to line, or an offset
    or a length is needed that `setup` does not have.
    """
    lines = ProgramReader(machine, control_for(machine, control), setup or Setup(), name)
    lines.texts = [each.strip().upper() for each in text.split("\n")]
    try:
        lines.take_all(text)
    except InputError as error:
        raise stops.with_all(error, lines) from None
    if not lines.count:
        raise InputError(name, "at least one move", "none")
    words, feeds, seconds, rapid, tcp, numbers = lines.all_kept()
    machines = [pair for pair in lines.machines if pair[0] < len(numbers)]
    if lines.control.whole_numbers and (found := whole_number(text, lines.names)):
        lines.notes["no point"] = found
    assumed = (*lines.at.assumed, *lines.assumed())
    return Program(
        Blocks(words.T, feeds, seconds, rapid, tcp),
        numbers,
        machines,
        dict(lines.skipped),
        lines.began,
        tuple(lines.blind),
        lines.dwell,
        assumed,
    )


class ProgramReader(Track):
    """Keeps what holds from one line of a program to the next."""

    def __init__(self, machine: Machine, control: Control, setup: Setup, name: str) -> None:
        super().__init__(machine, setup, name)
        self.control = control
        letters = "|".join(re.escape(axis) for axis in sorted(self.names, key=len, reverse=True))
        self.axis = re.compile(rf"({letters})(?:=|(?<=[A-Z]))({NUMBER})(?![\d=])")
        self.feed_word = re.compile(rf"({'|'.join(filter(None, (*self._words_behind(), 'F')))})=?({NUMBER})?")
        number = "N" if control.number is None else control.number
        self.numbered = re.compile(rf"^{number}\d+\s*")
        self.pattern = plain(control.number, control.begin, self._words_behind(), self.names)
        self.speed = np.nan
        self.plane = "XY"
        self.scale = MM_PER_INCH if setup.unit == "inch" else 1.0
        self.incremental = False
        self.per_turn = False
        self.absolute_centre = False
        self.vectors = False  # whether words that are centres of arcs elsewhere are the tool axis
        self.centre: np.ndarray | None = None
        self.cycle: Drilling | None = None
        self.leave = "initial"  # or "clearance": to where the tool comes out
        self.defined: dict[str, float] = {}  # of a cycle that is called later
        self.plane_angles: dict[str, float] = {}  # degrees, by axis, that a cycle leaves for the program
        self.unfinished: list[str] = []  # blocks of a tilted plane that needs more of them
        self.everywhere: arcs_and_holes.Heights | None = None  # of the cycle that is done behind every move
        self.pending = ""  # tool
        self.begun = ""  # of a line that goes on in the next
        self.ended = False
        self.returned = False  # from the subprogram that is called
        self.awaited = 0  # the line that a jump goes to
        self.labels: dict[str, dict[str, list[int]]] = {}  # lines by their names, see `calls.LABELS`
        self.depth = self.called = 0  # of calls, now, and lines that they have run in all
        self.texts: list[str] = []  # of the program
        self.variables = Variables(control.variables, control.words)
        self.skipped: Counter[str] = Counter()
        self.dwell = 0.0
        self.unit_stated = setup.unit is not None
        self.machines = [(0, machine)]

    def _words_behind(self) -> tuple[str, str]:
        """The words of rapid traverse and of seconds that follow the positions, or nothing."""
        return "" if self.control.modal else self.control.rapid, self.control.block_time

    def columns(self, values: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Of plain lines the words, shape (j, n), time or feed, and whether they say rapid, a time, a feed."""
        numbers = dict(zip(self.pattern.literals, values, strict=True))
        first, missing = self.pattern.literals.index(axis_word(self.names[0])), np.full(values.shape[1], np.nan)
        rapid, times = (numbers.get(f" {word}", missing) if word else missing for word in self._words_behind())
        feeds = numbers[FEED]
        said = ~np.isnan([rapid, times, feeds])
        return values[first : first + len(self.names)], np.where(said[1], times, feeds), said

    def fits(self, values: np.ndarray) -> np.ndarray:
        """Which lines move an axis, and say no more than one of rapid, a time and a feed, these above 0."""
        words, value, said = self.columns(values)
        return ~np.isnan(words).all(axis=0) & (said.sum(axis=0) < 2) & ~(value <= 0)

    def takes_plain(self) -> bool:
        """Whether plain lines are, in the present modal state, straight moves in mm to the positions they state."""
        straight = self.motion in ("linear", "rapid") and not (
            self.cycle or self.everywhere or self.incremental or self.per_turn
        )
        if np.isnan(self.at.words).any():
            return False
        running = not (self.begun or self.ended or self.returned or self.awaited or self.unfinished)
        return straight and self.scale == 1 and self.at.as_they_are and running

    def take_plain(self, values: np.ndarray) -> None:
        words, value, (rapid, timed, _) = self.columns(values)
        seconds = 60 / value if self.inverse else np.where(timed, value, np.nan)
        self.move(words, np.where(np.isnan(seconds), value, np.nan), seconds, rapid, np.arange(len(value)))
        self.line += len(value)

    def take_line(self, raw: bytes) -> None:
        """Take one line, word by word."""
        text = raw.decode("utf-8", "surrogatepass").strip()
        if self.awaited == self.line:
            self.awaited = 0
        if self.returned or self.awaited:
            pass
        elif self.control.continued and text.endswith(self.control.continued):
            self.begun += self.control.comments.sub(" ", text.removesuffix(self.control.continued)) + " "
        elif not self.ended:
            self.take_words(self.begun + text)
            self.begun = ""
        self.line += 1

    def words_of(self, text: str) -> str:
        """A line in capital letters, without its number and comments."""
        return bare(text, self.control.comments, self.numbered)

    def bare(self, text: str) -> str:
        """The same, with numbers for variables and without what gives them one."""
        return tidy(self.variables.line(self.words_of(text)))

    def take_words(self, text: str) -> None:
        skipped = text.startswith("/")
        try:
            values = dict(self.variables.values) if skipped else {}
            body = self.bare(text)
            if skipped and values != self.variables.values:
                raise InputError("", "a variable that always has its number", "one behind an oblique stroke")
        except InputError as error:
            raise self.error(error.expected, error.found) from None
        if re.search(rf"\d{{{MOST_DIGITS}}}", body):
            raise self.error(f"numbers of less than {MOST_DIGITS} digits", "a longer one")
        line = Line()
        while body:
            word = self.next_word(body)
            if word is None:
                raise self.error(f"a word of a {self.control.name} program", repr(body.split()[0]))
            self.take_word(line, *word)
            body = body[len(word.text) :].lstrip()
        if skipped and (line.axes or line.statement):
            raise self.error("a move that is never left out", "one behind an oblique stroke")
        try:
            self.obey(line)
            for unused in line.waiting.values():
                raise self.error("a word that says something in this line", repr(unused.strip()))
        except InputError as error:
            if error.where.startswith(self.name):
                raise
            raise self.error(error.expected, error.found) from None
        except MathpostError as error:
            raise self.error("a place where the machine can go", str(error)) from None
        if line.gone:
            calls.go(self, *line.gone)

    def next_word(self, body: str) -> Word | None:
        """The word that a line begins with, of an axis, of the control or of the feed; None if it is not known."""
        if match := self.axis.match(body):
            return Word(" axis", match[0], (match[1], match[2]))
        if word := self.control.words.begins(body):
            return word
        match = self.feed_word.match(body)
        return Word("feed", match[0], (match[1], match[2] or "")) if match else None

    def take_axis(self, line: Line, name: str, value: str, counted: str, word: str) -> None:
        if name not in self.names:
            raise self.error(f"one of the axes {' '.join(self.names)}", repr(name))
        if name in line.axes:
            raise self.error(f"one {name} word", "two")
        line.axes[name] = float(value), counted
        line.waiting[f"axis {name}"] = word

    def take_feed(self, line: Line, name: str, number: str, word: str) -> None:
        """Take a word that says rapid, a feed, or the time of the block."""
        value = float(number or "nan")
        rapid, block_time = self._words_behind()
        if name == rapid and not number:
            line.rapid = True
            return
        if not value > 0 or name == rapid:
            raise self.error("a feed above 0", repr(word))
        line.waiting["feed"] = word
        if name == "F" and not self.inverse:
            line.feed = value * self.scale * (self.speed if self.per_turn else 1.0)
        else:
            line.seconds = value if name == block_time else 60 / value

    def assumed(self) -> list[str]:
        """What was taken for granted, as sentences."""
        control = self.control
        if not self.unit_stated and "inch" in control.read.values():
            self.note("unit", "")
        return [
            ASSUMED[kind].format(line=line, word=word, control=control) for kind, (line, word) in self.notes.items()
        ]

    def take_word(self, line: Line, meaning: str, word: str, values: tuple[str, ...]) -> None:
        """Take what a word means: a mode holds at once, what needs the rest of the line waits for `obey`."""
        if meaning in MODES:
            MODES[meaning](self, line)
            if meaning in POSITIONING:
                line.waiting[f"argument {word}"] = word
        elif meaning.startswith("plane ") and meaning.removeprefix("plane ") in PLANES:
            self.plane = meaning.removeprefix("plane ")
        elif meaning in MOTIONS:
            self.motion, self.cycle = meaning, None
        elif meaning in calls.LABELS:
            line.gone = meaning, values
        elif meaning in ("return", "end of section"):
            calls.end(self, meaning, word)
        elif meaning == "flow":
            raise self.error("a program that runs from line to line", repr(word))
        elif meaning == "zero":
            if float(values[0]):
                raise self.error("0", repr(word))
        elif meaning == "tool":
            line.tool, self.pending = True, tool_name(values[0]) if values else self.pending
        elif meaning == "tool number":
            self.pending = tool_name(values[0])
        elif meaning == "length":
            self.load(tool_name(values[0]))
        elif meaning == "dwell turns":
            self.wait(-float(values[0]))
        elif meaning.startswith("dwell "):
            self.wait(seconds(meaning, values[0]))
        elif meaning.startswith("TCP "):
            self.vectors = meaning == "TCP on with vectors"
            self.at.change(tcp=not meaning.startswith("TCP off"))
            if meaning.endswith("as configured"):
                self.note("configured", word)
        elif meaning == "plane angle":
            if word[0] not in self.plane_angles:
                raise self.error(f"a tilted plane that {word[0]} turns to", "none")
            line.axes[word[0]] = self.plane_angles[word[0]], "absolute"
            line.waiting[f"axis {word[0]}"] = word
        elif meaning in ASSUMED:
            self.note(meaning, word)
        elif meaning == "speed":
            self.speed = float(values[0])
        elif meaning == "feed":
            self.take_feed(line, values[0], values[1], word)
        elif meaning.endswith(" axis"):
            self.take_axis(line, values[0], values[1], meaning.removesuffix(" axis"), word)
        elif meaning in STATEMENTS:
            if line.statement:
                raise self.error(f"one of {line.statement[1]} and {word} in a line", "both")
            line.statement = meaning, word
        elif meaning == "work offset":
            line.work_offset = re.sub(r"\s+", "", word)
        elif meaning == "argument":
            line.waiting[f"argument {word}"] = word
        elif meaning in NUMBERS:
            if meaning in line.values:
                raise self.error(f"one word that is the {meaning}", f"a second one, {word!r}")
            line.values[meaning] = float(values[0])
            line.waiting[meaning] = word
        else:
            for value in values:
                word = word.replace(value, "", 1)
            self.skipped[" ".join(word.split())] += 1

    def wait(self, dwell: float) -> None:
        """Wait so many seconds or, below 0, turns of the spindle."""
        if dwell < 0 and not self.speed > 0:
            raise self.error("a speed before a wait of turns of the spindle", "none")
        self.dwell += dwell if dwell >= 0 else -60 * dwell / self.speed

    def load(self, name: str) -> None:
        """Take the length of another tool."""
        before = self.at.machine
        self.at.load_tool(name, f"{self.name}, line {self.line}")
        if self.at.machine is not before:
            self.machines.append((self.count, self.at.machine))

    def obey(self, line: Line) -> None:
        """Do what the words of a line say together."""
        if line.tool:
            self.park([0, 1, 2])
            self.feed = np.nan
            self.changed = True
            self.kept = set(range(3, len(self.names)))
            if self.pending:
                self.load(self.pending)
        if line.work_offset:
            self.at.call_offset(line.work_offset, f"{self.name}, line {self.line}")
        if line.statement:
            STATEMENTS[line.statement[0]](self, line, line.text)
        else:
            self.defined |= {name: value for name, value in line.values.items() if name.startswith("cycle ")}
            line.used("cycle ", "feed", "argument" if line.defines else "cycle ")
            self.go(line)
        if line.called:
            arcs_and_holes.drill(self)

    def target(self, line: Line) -> np.ndarray:
        """The words, (j,), that a line leads to."""
        words = self.at.words.copy()
        line.used("axis ")
        for name, (value, counted) in line.axes.items():
            axis = self.names.index(name)
            self.kept.discard(axis)
            value *= self.scale if axis < 3 else 1.0
            added = counted == "incremental" or (self.incremental and not counted)
            words[axis] = words[axis] + value if added else value
        return words

    def go(self, line: Line) -> None:
        """Move to where a line leads, by a straight line, an arc or a drilling cycle."""
        arc = line.curve or (self.motion[4:] if self.motion.startswith("arc ") else "")
        centred = any(name.startswith("centre ") for name in line.values)
        if not np.isnan(line.feed):
            self.feed = line.feed
        arcs_and_holes.point(self, line, arc)
        if line.axes and self.unfinished:
            raise self.error(", ".join(lacking(self.unfinished)), "a move")
        if not line.axes and not (arc and (centred or "sweep" in line.values)):
            return
        if line.in_machine:
            if self.incremental:
                raise self.error("machine coordinates in absolute numbers", "incremental ones")
            named = {self.names.index(name): value for name, (value, _) in line.axes.items()}
            line.used("axis ")
            self.stand(self.at.machine_position(named))
        elif self.cycle is not None and not line.curve:
            arcs_and_holes.hole(self, self.cycle, line)
        elif arc == "arc":
            raise self.error("the sense of the arc", "none")
        elif arc:
            arcs_and_holes.turn(self, line, arc == "clockwise")
        else:
            self.turning = not self.at.tcp and all(self.names.index(name) > 2 for name in line.axes)
            words = self.target(line)
            self.turn(words, line) if self.turning else self.put(words[None], line)
            self.turning = False
            if self.everywhere is not None:
                arcs_and_holes.holes(self, self.at.words, 2, self.everywhere)
