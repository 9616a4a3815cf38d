"""NC programs (加工程序) out and back in: Heidenhain, Fanuc and Siemens.

A program is verified from its own text. Reading knows the words that writing uses and a few that do not move an
axis; any other is an error with its line.
"""

import re
from dataclasses import dataclass
from functools import cache
from itertools import pairwise

import numpy as np

from mathpost.errors import NUMBER, InputError
from mathpost.path import text as bulk
from mathpost.path.cl import commands, feed_times
from mathpost.path.text import Column, Item, Pattern
from mathpost.post.between_blocks import block_times
from mathpost.post.controls import DIALECTS, FANUC, HEIDENHAIN, said

DECIMALS = 4
SHORTEST_TIME = 0.001  # s, the least that FT may state
LAST_BLOCK_NUMBER = 99_999  # Fanuc counts no further; numbering begins again
MOTION_ONLY = "MOTION ONLY: THE MACHINE FILE GIVES NO HEAD AND NO FOOT"  # a program says so before its first move
RAPID, TIME, FEED = " FMAX", " FT", " F"

FEED_WORD = re.compile(rf"(FMAX|FT|F)({NUMBER})?")


@dataclass(frozen=True)
class Blocks:
    """The moves of a program."""

    words: np.ndarray  # shape (n, 5), mm and degrees, X Y Z and the rotary axes in the order of the machine file
    feeds: np.ndarray  # shape (n,), mm/min, NaN where no feed is stated
    seconds: np.ndarray  # shape (n,), of the block where inverse time is programmed, otherwise NaN
    rapid: np.ndarray  # shape (n,), whether in rapid traverse
    tcp: bool = False  # whether X Y Z are the tool tip in the workpiece (M128, G43.4, TRAORI) instead of joints
    remarks: tuple = ()  # (number of the block that follows, a comment or a `cl_words.Command`)

    @property
    def columns(self):
        """The arrays, one entry for each move."""
        return self.words, self.feeds, self.seconds, self.rapid

    def __getitem__(self, rows):
        """The moves of a slice, without remarks."""
        return Blocks(*(column[rows] for column in self.columns), self.tcp)

    @property
    def joints(self):
        """`words` with the rotary angles in radians, shape (n, 5)."""
        joints = np.array(self.words)
        np.deg2rad(joints[:, 3:], out=joints[:, 3:])
        return joints


def control_for(machine, dialect):
    """Return the words of a control; refuse an unknown one, or one that cannot name the machine's axes."""
    if dialect not in DIALECTS:
        raise InputError("dialect", " or ".join(DIALECTS), repr(dialect))
    for axis in machine.joint_names[3:]:
        if dialect == "heidenhain" and len(axis) > 1:
            raise InputError("rotary axis name", "one letter for a Heidenhain program", repr(axis))
    return DIALECTS[dialect]


def axis_word(name):
    """What stands before the number of an axis: names of more than one letter take an equals sign."""
    return f" {name}=" if len(name) > 1 else f" {name}"


def printed(words):
    """Round words, in place, to the last digit that stands in a program; a zero has no sign."""
    np.round(words, DECIMALS, out=words)
    words += 0.0
    return words


def rounded(joints):
    """Joints (n, 5) in mm and radians as words in mm and degrees, rounded as they will be printed."""
    words = np.array(joints)
    np.rad2deg(words[:, 3:], out=words[:, 3:])
    return printed(words)


def joined(parts):
    """Return `Blocks` one after the other as one."""
    if len(parts) == 1:
        return parts[0]
    remarks, first = [], 0
    for part in parts:
        remarks += [(first + row, remark) for row, remark in part.remarks]
        first += len(part.words)
    columns = (np.concatenate(column) for column in zip(*(part.columns for part in parts), strict=True))
    return Blocks(*columns, parts[0].tcp, tuple(remarks))


def from_motion(kin, cl, motion, tcp):
    """The poses of a motion, but repetitions, the `Blocks` that end at them, and seconds of the moves.

    Those that feed and rates ask for, and those of the feed alone, NaN where it does not count.
    """
    joints = motion.joints
    words = rounded(np.concatenate([kin.forward(joints)[0], joints[:, 3:]], axis=1) if tcp else joints)
    kept = np.r_[True, (words[1:] != words[:-1]).any(axis=1)]
    if not kept.all():
        motion, words = motion[kept], words[kept]
    record = motion.record
    feeds, rapid, (tip, _) = cl.feeds[record], cl.rapid[record], cl.at(motion.place)  # in cut it is on the path
    seconds = np.r_[np.nan, block_times(kin.machine, motion.joints, tip, feeds[1:], motion.in_cut)]
    turning = np.r_[False, (words[1:, 3:] != words[:-1, 3:]).any(axis=1)]
    by_time = turning & ~np.isnan(feeds) & ~rapid & (not tcp)
    # A remark stands before the first block of the move to its record.
    before = np.searchsorted(motion.place, [record - 1 for record, _ in cl.remarks], side="right").tolist()
    remarks = tuple((block, text) for block, (_, text) in zip(before, cl.remarks, strict=True))
    blocks = Blocks(words, feeds, np.where(by_time, seconds, np.nan), rapid, tcp, remarks)
    return motion, blocks, seconds[1:], np.where(motion.at_feed(cl), feed_times(tip, feeds[1:]), np.nan)


def refuse_turning_compensation(cl, machine, blocks):
    """Refuse a rotary axis that moves while the control compensates the radius of the cutter, in its X-Y plane."""
    heads = [joint.carries == "tool" for joint in machine.rotary]
    switched = [*commands(blocks.remarks, "compensation"), (len(blocks.words), None)]
    for (first, side), (last, _) in pairwise(switched):
        rotary = blocks.words[max(first - 1, 0) : last + 1, 3:]
        if side.values[0] != "OFF" and (blocks.tcp or np.ptp(rotary, axis=0).any() or rotary[:1, heads].any()):
            expected = "rotary axes that stand still, the tool across X and Y, and no TCP"
            raise InputError(f"{cl.name}: {side.statement}", expected, "others while it holds")


def write(blocks, machine, dialect="heidenhain", *, name="MATHPOST"):
    """Return the text of a program; words that do not change are left out.

    There is at least one block, and none like the one before. Of the name letters, digits and underscores are used.
    """
    control, name = control_for(machine, dialect), re.sub(r"\W", "_", name, flags=re.ASCII).upper() or "MATHPOST"
    between, changes, switches = _between(control, machine, blocks)
    rows, own = len(blocks.words), machine.program_head
    if not own and not machine.program_foot:
        own = [_comment(control, MOTION_ONLY)]
    between[0][:0] = [line.replace("{name}", name) for line in (*control["head"], *own)]
    foot = [line.replace("{name}", name) for line in (*machine.program_foot, *control["foot"])]
    between[rows] += [control["TCP off"]] * blocks.tcp + foot
    numbered = np.zeros(rows + 1, int)  # how many lines before each move, besides the moves
    for row, lines in between.items():
        numbered[row] = sum(not line.startswith(control["unnumbered"]) for line in lines)
    before = np.cumsum(numbered) + np.arange(rows + 1)
    columns = _columns(control, machine.joint_names, blocks, before[:-1], changes, switches)
    texts, at = [], 0
    for row, lines in between.items():
        texts += bulk.lines(columns, at, row)
        count, at = before[row] - numbered[row], row
        for line in lines:
            if not line.startswith(control["unnumbered"]):
                line, count = f"{control['block']}{_number(control, count)} {line}", count + 1
            texts.append(f"{line}\n")
    return "".join(texts)


def _between(control, machine, blocks):
    """What stands between the moves: lines, by the number of the move that follows, also behind the last.

    And the moves before which a tool is changed, and words that a move itself takes, by its number.
    """
    rows, tool, tcp = len(blocks.words), 1, False
    between, changes, switches = {0: [], rows: []}, [0], {}
    for row, remark in blocks.remarks:
        between.setdefault(min(row, rows), []).append(remark)
    for row in sorted(between):
        remarks, lines = between.pop(row), []
        for remark in remarks:
            kind = getattr(remark, "kind", "comment")
            if kind == "comment":
                lines.append(_comment(control, remark))
            elif kind == "compensation":
                switches[row] = control[f"{kind} {remark.values[0]}"].format(tool=tool)
            elif kind == "tool":
                lines += [control["TCP off"]] * tcp
                tool, tcp = remark.values[0], False
                lines += [line.replace("{tool}", str(tool)) for line in machine.tool_change]
                if not machine.tool_change:
                    lines += said(control, remark)
                    if machine.programmed_point == "tip" and not blocks.tcp:
                        lines += [line.format(tool) for line in control["tip"]]
                changes.append(row)
            else:
                lines += said(control, remark)
        if blocks.tcp and not tcp and row < rows:
            lines.append(control["TCP on"].format(tool=tool))
            tcp = True
        between[row] = lines
    return between, [row for row in changes if row < rows], switches


def _number(control, count):
    """The block number after `count` others."""
    return count if control is HEIDENHAIN else 10 * (count % (LAST_BLOCK_NUMBER // 10) + 1)


def _columns(control, axes, blocks, numbers, changes, switches):
    """The moves as `Column`s; `changes` and `switches` as in `_between`."""
    rows, timed = np.arange(len(blocks.words)), ~(blocks.rapid | np.isnan(blocks.seconds))
    heidenhain = control is HEIDENHAIN
    # A time is rounded up and a feed down: no block is faster than it may be.
    if heidenhain:
        seconds = np.where(timed, np.maximum(-_down(-blocks.seconds, 3), SHORTEST_TIME), 1.0)
        start, rapid = [Column("", numbers), Column(" L")], [Column(RAPID, shown=blocks.rapid)]
        times = Column(TIME, seconds, 3, shown=timed)
    else:
        per_minute = _down(60 / np.maximum(blocks.seconds, SHORTEST_TIME), 4)
        per_minute = np.where(timed, np.maximum(per_minute, 1e-4), 1.0)
        start, rapid = [Column("N", _number(control, numbers)), *_codes(blocks.rapid, timed)], []
        times = Column(FEED, per_minute, 4, shown=timed)
    positions = []
    for axis, column in zip(axes, blocks.words.T, strict=True):
        shown = _changes(values := printed(np.array(column)))
        shown[changes] = True  # nobody knows where the machine went for its tool
        positions.append(Column(axis_word(axis), values, DECIMALS, control["plus"], shown))
    switched = [Column(word, shown=rows == row) for row, word in switches.items()]
    moved = [*positions, *switched] if heidenhain else [*switched, *positions]
    # An ISO control that has been told times has forgotten the feed.
    times_before = np.cumsum(timed) * (not heidenhain)
    tools_before = np.searchsorted(changes, rows, side="right")
    fed = np.flatnonzero(~(blocks.rapid | timed | np.isnan(blocks.feeds)))
    stated = np.zeros(len(rows), bool)
    stated[fed] = _changes(blocks.feeds[fed]) | _changes(times_before[fed]) | _changes(tools_before[fed])
    whole = blocks.feeds == np.round(blocks.feeds)
    feeds = Column(FEED, blocks.feeds, 0, shown=stated & whole)
    parts = Column(FEED, _down(blocks.feeds, 3), 3, shown=stated & ~whole)
    return [*start, *moved, *rapid, times, feeds, parts, Column("\n")]


def _down(values, decimals):
    """Round down to so many decimals; what is a multiple but for the last bits stays."""
    return np.floor(values * 10.0**decimals * (1 + 1e-15) + 1e-9) / 10.0**decimals


def _codes(rapid, timed):
    """The G codes as `Column`s, each where it begins to hold; G94 holds from the head on."""
    changed, begins, cutting = _changes(rapid), np.zeros(len(rapid), bool), np.flatnonzero(~rapid)
    begins[cutting] = _changes(np.r_[False, timed[cutting]])[1:]
    words = {"G1": changed & ~rapid, "G0": changed & rapid, "G94": begins & ~timed, "G93": begins & timed}
    return [Column(f" {word}", shown=shown) for word, shown in words.items()]


def _changes(values):
    """Where a value is not the one before; the first always is not."""
    return np.concatenate([[True], values[1:] != values[:-1]]) if len(values) else np.empty(0, bool)


def _comment(control, remark):
    comment = " ".join(remark.split())
    if control is FANUC:
        comment = comment.replace("(", "[").replace(")", "]")
    return control["comment"].format(comment)


def read(text, machine, dialect="heidenhain", *, name="program"):
    """Return the `Blocks` of a program's text; `InputError` with its `name` and the line if a word is not known."""
    lines = _Lines(machine, dialect, name)
    lines.take_all(text)
    if not lines.runs:
        raise InputError(name, "at least one move", "none")
    words, *columns = (np.concatenate(runs, axis=-1) for runs in zip(*lines.runs, strict=True))
    return Blocks(words.T, *columns, tcp=bool(lines.moves_tcp))


class _Lines(bulk.Reader):
    """Keeps what holds from one line of a program to the next."""

    def __init__(self, machine, dialect, name):
        self.control, self.names, self.name = control_for(machine, dialect), machine.joint_names, name
        letters = "|".join(re.escape(axis) for axis in sorted(self.names, key=len, reverse=True))
        self.axis = re.compile(rf"({letters})(?:=|(?<=[A-Z]))({NUMBER})")
        self.codes = re.compile(self.control["codes"] + r"(?![\d.])")
        self.pattern = _plain(self.control is HEIDENHAIN, self.names)
        self.passed_over = _templates((*machine.program_head, *machine.program_foot))
        self.tool_change = _templates(machine.tool_change)
        self.line = 1
        self.forget()
        self.rapid, self.inverse, self.tcp = False, False, False
        self.moves_tcp = None  # whether the moves so far were with TCP
        self.runs = []  # of moves: words, shape (5, n), feeds, seconds and rapid

    def columns(self, values):
        """Of plain lines the words, shape (5, n), time or feed, and whether they say rapid, a time, a feed."""
        numbers = dict(zip(self.pattern.literals, values, strict=True))
        first, missing = self.pattern.literals.index(axis_word(self.names[0])), np.full(values.shape[1], np.nan)
        times, feeds = numbers.get(TIME, missing), numbers[FEED]
        said = ~np.isnan([numbers.get(RAPID, missing), times, feeds])
        return values[first : first + 5], np.where(said[1], times, feeds), said

    def fits(self, values):
        """Which lines move an axis, and say no more than one of rapid, a time and a feed, these above 0."""
        words, value, said = self.columns(values)
        return ~np.isnan(words).all(axis=0) & (said.sum(axis=0) < 2) & ~(value <= 0)

    def take_plain(self, values):
        words, value, (rapid, timed, _) = self.columns(values)
        seconds = 60 / value if self.inverse else np.where(timed, value, np.nan)
        self.move(words, np.where(np.isnan(seconds), value, np.nan), seconds, rapid)
        self.line += len(value)

    def take_line(self, raw):
        """Take one line, word by word."""
        line = raw.decode("utf-8", "surrogatepass").strip()
        body = re.sub(r"\([^()]*\)" if self.control is FANUC else ";.*", " ", line).strip()
        body = re.sub(rf"^{self.control['block']}\d+\s*", "", body)
        if self.control is HEIDENHAIN:
            body = "" if re.fullmatch(r"(BEGIN|END) PGM \w+ MM", body) else re.sub(r"^L(\s+|$)", "", body)
        template = re.sub(r"^N?\d+\s*", "", line)
        if self.tool_change.fullmatch(template):
            self.forget()
            body = ""
        elif self.passed_over.fullmatch(template) or (body == "%" and self.control is not HEIDENHAIN):
            body = ""
        words, feed, seconds, rapid = {}, np.nan, np.nan, False
        while body:
            if match := self.axis.match(body):
                if match[1] in words:
                    raise self.error(f"one {match[1]} word", "two")
                words[match[1]] = float(match[2])
            elif match := FEED_WORD.match(body):
                rapid, feed, seconds = self.take_feed(match)
            elif self.control is not HEIDENHAIN and (match := re.match(r"G0?([01]|9[34])(?![\d.])", body)):
                if match[1] in "01":
                    self.rapid = match[1] == "0"
                else:
                    self.inverse, self.feed = match[1] == "93", np.nan
            elif match := self.codes.match(body):
                self.take_code(match[0])
            else:
                raise self.error(f"a word of a {self.control['control']} program", repr(body.split()[0]))
            body = body[match.end() :].lstrip()
        if words:
            column = np.array([[words.get(name, np.nan)] for name in self.names])
            self.move(column, *np.array([[feed], [seconds]]), np.array([rapid]))
        elif not np.isnan(feed):
            self.feed = feed
        self.line += 1

    def take_feed(self, match):
        """Return whether a feed word says rapid, the feed, and the time of the block."""
        kind, value, heidenhain = match[1], float(match[2] or "nan"), self.control is HEIDENHAIN
        if match[0] == "FMAX" and heidenhain:
            return True, np.nan, np.nan
        if not value > 0 or (kind == "FT" and not heidenhain) or kind == "FMAX":
            raise self.error("a feed above 0", repr(match[0]))
        if kind == "F" and not self.inverse:
            return False, value, np.nan
        return False, np.nan, value if kind == "FT" else 60 / value

    def forget(self):
        """The machine goes where its tools are."""
        self.position, self.feed = np.full(5, np.nan), np.nan

    def take_code(self, code):
        if re.fullmatch(r"TOOL CALL \d+(?: Z)?|M0?6", code):
            self.forget()
        if code in (self.control["TCP on"].split()[0], self.control["TCP off"]):
            self.tcp = code != self.control["TCP off"]

    def move(self, words, feeds, seconds, rapid):
        """Take n moves: words, shape (5, n), feeds and seconds, NaN where a line does not say."""
        rapid = rapid | self.rapid
        for row, name, before in zip(words, self.names, self.position, strict=True):
            if np.isnan(row[0]) and np.isnan(before):
                raise self.error(f"a {name} word before or in the first move", "none")
            row[:] = bulk.held(row, before)
        untimed = np.isnan(seconds)
        if self.inverse and (untimed & ~rapid).any():
            self.line += int((untimed & ~rapid).argmax())
            raise self.error("an F word, inverse time being active", "none")
        if self.moves_tcp not in (None, self.tcp):
            raise self.error("moves all with or all without TCP", "both")
        feeds = bulk.held(feeds, self.feed)
        self.runs.append((words, np.where(rapid | ~untimed, np.nan, feeds), seconds, rapid))
        self.position, self.feed, self.moves_tcp = words[:, -1], feeds[-1], self.tcp

    def error(self, expected, found):
        return InputError(f"{self.name}, line {self.line}", expected, found)


def _templates(lines):
    """An expression that the lines of the machine file fit, whatever name and tool stand in them."""
    escaped = (re.escape(line.strip()) for line in lines)
    fields = (line.replace(r"\{name\}", r"\w+").replace(r"\{tool\}", r"\d+") for line in escaped)
    return re.compile("|".join(fields) or r"(?!)")


@cache
def _plain(heidenhain, names):
    """The pattern of a line that moves axes and changes no mode but its feed."""
    start, ends = [Item("N", "count")], [Item(FEED, "number", optional=True)]
    if heidenhain:
        start = [Item("", "count"), Item(" L")]
        ends = [Item(RAPID, optional=True), Item(TIME, "number", optional=True), *ends]
    return Pattern([*start, *(Item(axis_word(name), "number", optional=True) for name in names), *ends])
