"""Blocks to the text of a program, in the words of any control."""

from __future__ import annotations

import io
import re
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from typing import TypeVar

import numpy as np

from mathpost.machine import Machine
from mathpost.path import text as bulk
from mathpost.path.cl import commands
from mathpost.path.modal import Command
from mathpost.path.text import Column
from mathpost.shop.controls.blocks import FEED, Blocks, Turn, axis_word, printed
from mathpost.shop.controls.control import Control, control_for
from mathpost.shop.controls.phrases import PLANES

SHORTEST_TIME = 0.001  # s, the least that a block may state
Values = TypeVar("Values", float, np.ndarray)
MOTION_ONLY = "MOTION ONLY: THE MACHINE FILE GIVES NO HEAD AND NO FOOT"  # a program says so before its first move


def write(
    blocks: Blocks, machine: Machine, control: Control | str = "heidenhain", *, name: str = "MATHPOST"
) -> str:
    """Return the text of a program for a control, or one of that name; words that do not change are left out.

    There is at least one block, and none like the one before. Only letters, digits and underscores of the name are
    used.
    Where the head says how far the control may round off, it says 0: see `state_rounding`.
    """
    control = control_for(machine, control)
    name = re.sub(r"\W", "_", name, flags=re.ASCII).upper() or "MATHPOST"
    said = _between(control, machine, blocks)
    between = said.lines
    rows, own = len(blocks.words), list(machine.program_head)
    only_motion = not own and not machine.program_foot
    if only_motion:
        own = control.remark(MOTION_ONLY)
    stated = re.search(r"\d{1,4}", name)
    number = f"{int(stated[0]) or 1:04d}" if stated else "0001"

    def filled(lines: Iterable[str]) -> list[str]:
        named = (line.replace("{name}", name).replace("{number}", number) for line in lines)
        return [line.replace("{rounding}", f"{0:.4f}") for line in named]

    between[0][:0] = filled((*control.head, *own, *_tool_list(control, blocks)))
    foot = filled(_foot(control, machine, only_motion))
    between[rows] += foot
    numbered = np.zeros(rows + 1, int)  # how many lines before each move, besides the moves
    for row, lines in between.items():
        numbered[row] = sum(not line.startswith(control.unnumbered) for line in lines)
    before = np.cumsum(numbered) + np.arange(rows + 1)
    columns = _columns(control, machine.joint_names, blocks, before[:-1], said)
    texts = io.StringIO()  # unlike pieces that are joined it never holds the text twice
    at = 0
    for row, lines in between.items():
        moves = bulk.lines(columns, at, row)
        texts.writelines(moves if control.number is not None else _without_indent(moves))
        count, at = before[row] - numbered[row], row
        for line in lines:
            if not line.startswith(control.unnumbered):
                skip, line = "/" * line.startswith("/"), line.removeprefix("/")
                line, count = f"{skip}{control.numbered(line, count)}", count + 1
            texts.write(f"{line}\n")
    return texts.getvalue()


def _foot(control: Control, machine: Machine, only_motion: bool) -> list[str]:
    """The lines after the moves; the foot of the machine may end the program itself."""
    own = machine.program_foot
    last = [*(() if only_motion else control.end), *control.foot]
    if any(control.ends(line) for line in own):
        last = [line for line in last if not control.ends(line)]
    return [*own, *last]


def state_rounding(text: str, control: Control, rounding: float) -> str:
    """Return a program that says in its head how far the control may round off, mm, if its head says so at all."""
    for word in " ".join(control.head).split():
        if "{rounding}" in word:
            before, after = (word.replace("{rounding}", f"{value:.4f}") for value in (0, _down(rounding, 4)))
            text = text.replace(f" {before}", f" {after}", 1)
    return text


def _tool_list(control: Control, blocks: Blocks) -> list[str]:
    """Comments on the tools of a program: their numbers, lengths, and the numbers of their offsets."""
    lines: dict[int, str] = {}
    for _, remark in blocks.remarks:
        if isinstance(remark, str):
            continue
        if remark.kind == "tool":
            number, length, offset = remark.values
            stated = "LENGTH OF THE MACHINE FILE" if length is None else f"LENGTH {length:g} MM"
            lines[number] = f"TOOL {number}: {stated}, OFFSET {offset or number}"
        elif remark.kind == "compensation" and remark.values[0] != "OFF" and lines:
            radius = f", RADIUS OFFSET {remark.values[1]}"
            lines[number] += radius * (radius not in lines[number])
    return [comment for line in lines.values() for comment in control.remark(line)]


@dataclass
class Said:
    """The lines between the moves, and how they change the moves."""

    lines: dict[int, list[str]]  # by the number of the move that follows, also behind the last
    anew: list[int]  # moves that state X Y Z, feed and modes anew: behind a change of the tool, a plane or a cycle
    turned: list[int]  # and those of them that state the rotary axes, too
    switches: dict[int, str]  # words that a move itself takes, by its number
    cycles: list[int]  # moves behind drilling cycles, which have a feed in mm per minute
    planes: list[int]  # the first moves in a tilted plane and behind it, in turn
    further: list[int]  # moves to holes of the cycle that is on, which a word such as G0 would end


def _between(control: Control, machine: Machine, blocks: Blocks) -> Said:
    """Return what is `Said` between the moves."""
    rows = len(blocks.words)
    offset = edge = 1
    tcp = unnamed = False  # whether the control keeps the tip, and whether X Y Z name the tip no more
    selected = ""  # line of the work offset
    speed: float | None = None  # of the spindle, as stated for this tool
    wanted = np.r_[blocks.tcp, False]  # behind the last move it is off
    switched = np.flatnonzero(np.diff(wanted)) + 1
    changes = [0, *switched.tolist()]
    said: dict[int, list[str | Command]] = {row: [] for row in (*changes, rows)}
    between: dict[int, list[str]] = {}
    switches: dict[int, str] = {}
    cycles: list[int] = []
    drilled: list[int] = []
    planes: list[int] = []
    further: list[int] = []
    cut = np.flatnonzero(~blocks.rapid)
    tools = [(row, remark.values[0]) for row, remark in commands(blocks.remarks, "tool")]
    following = {row: after for (row, now), (_, after) in pairwise([*tools, *tools[:1]]) if after != now}
    around = _around(control, machine.joint_names, blocks)
    for row in around:
        said.setdefault(row, [])
    for row, remark in blocks.remarks:
        said.setdefault(min(row, rows), []).append(remark)
    for row in sorted(said):
        lines: list[str] = []
        if tcp and not wanted[row] and any(_in_own_coordinates(remark) for remark in said[row]):
            lines += control.lines("TCP off")
            lines += [selected] * bool(selected and control.work_offsets.anew)
            unnamed, tcp = True, False
        for remark in said[row]:
            if isinstance(remark, str):
                lines += control.remark(remark)
                continue
            kind, first = remark.kind, len(lines)
            if kind == "compensation":
                (side,) = control.lines(f"{kind} {remark.values[0]}", *remark.values)
                switches[row] = f"{switches[row]} {side}" if switches.get(row) else side
            elif kind == "tool":
                lines += control.lines("TCP off") * tcp
                tool, _, stated = remark.values
                offset, edge, tcp, speed = stated or tool, stated or 1, False, None
                change = (line.replace("{tool}", str(tool)) for line in machine.tool_change)
                lines += [line.replace("{offset}", str(offset)) for line in change]
                unnamed = not machine.tool_change
                if unnamed:
                    lines += control.lines("tool", tool, edge=edge)
                    lines += control.lines("next tool", following[row]) if row in following else []
                changes.append(row)
            elif kind == "work offset":
                lines += control.lines("TCP off") * tcp
                selected = control.work_offset_line(*remark.values)
                lines.append(selected)
                unnamed, tcp = unnamed or tcp, False
                changes.append(row)
            elif kind == "approach":
                height, angles = remark.values
                lines += [*control.lines("safe", height, edge=edge), _turn(control, angles)]
            elif kind == "cycle":
                last = cut[np.searchsorted(cut, row) - 1] if (cut < row).any() else -1
                if control.inverse_time and last >= max(cycles, default=0) and not np.isnan(blocks.seconds[last]):
                    lines.append(control.inverse_time[1])
                cycles.append(row)
                further += [row] if control.cycles and not control.cycles.before else []
                lines += [line.format(**remark.values[1]) for line in remark.values[0]]
            elif kind in ("plane", "cycle off", "plane off"):
                lines += remark.values[0]
                (drilled if kind == "cycle off" else changes).append(row)
                if further[-1:] == [row]:
                    further.pop()
                planes += [row] if kind.startswith("plane") else []
            elif kind == "offset":
                lines += control.lines("TCP off") * tcp
                unnamed = unnamed or tcp
                offset, edge, tcp = remark.values[0], remark.values[0], False
                if wanted[row] or machine.programmed_point == "tip":
                    lines += control.said(remark)
            elif kind == "spindle" and not remark.skip:
                value, sense = remark.values
                news = control.said(Command(kind, (None if value == speed else value, sense), ""))
                if tcp and any(line.startswith(control.without_tcp) for line in news):
                    lines += control.lines("TCP off")
                    tcp = False
                lines += news
                speed = value if value is not None else speed
            else:
                lines += control.said(remark)
            if remark.skip:
                lines[first:] = [f"/{line}" for line in lines[first:]]
        if wanted[row] != tcp:
            tcp = bool(wanted[row])
            unnamed = not tcp
            lines += control.lines("TCP on", offset) if tcp else control.lines("TCP off")
            lines += [selected] * bool(selected and control.work_offsets.anew)
        if unnamed and not tcp and row < rows and machine.programmed_point == "tip":
            # In the block itself: X Y Z name the tip again.
            tip = [*control.lines("tip", offset), *filter(None, [switches.get(row)])]
            switches[row], unnamed = " ".join(tip), False
        restored, pole = around.get(row, ([], []))
        between[row] = [*restored, *lines, *pole]
    anew, turned = (sorted({row for row in found if row < rows}) for found in ([*changes, *drilled], changes))
    return Said(between, anew, turned, switches, cycles, planes, further)


def _in_own_coordinates(remark: str | Command) -> bool:
    """Whether something said begins a plane or a cycle: the control keeps no tip there."""
    return isinstance(remark, Command) and remark.kind in ("plane", "cycle")


def _around(control: Control, axes: tuple[str, ...], blocks: Blocks) -> dict[int, tuple[list[str], list[str]]]:
    """Lines before the moves from arcs: that select the plane XY again, and that state a centre; by row, a pair."""
    lines: dict[int, tuple[list[str], list[str]]] = {}
    arcs = control.arcs
    if arcs is None:
        return lines
    turns = dict(blocks.turns)
    for row, turn in blocks.turns:
        if arcs.pole:
            first, second, _ = _of_plane(turn.plane)
            words = [_position(control, axes[axis], turn.centre[axis]) for axis in sorted((first, second))]
            lines[row] = [], [f"{arcs.pole}{''.join(words)}"]
        elif turn.plane != PLANES[0] and row + 1 not in turns:
            lines[row + 1] = [arcs.planes[PLANES[0]]], []
    return lines


def _of_plane(name: str) -> tuple[int, int, int]:
    """The two axes of a plane, and the one square to it."""
    return [(0, 1, 2), (2, 0, 1), (1, 2, 0)][PLANES.index(name)]


def _lies_in(axis: int, turn: Turn) -> bool:
    """Whether an axis is one of the plane of an arc."""
    return axis in _of_plane(turn.plane)[:2]


def _position(control: Control, name: str, value: float) -> str:
    return f"{axis_word(name)}{value:{control.plus}z.{control.decimals}f}"


def _without_indent(texts: Iterable[str]) -> Iterator[str]:
    """Lines that begin with a word and not with the blank before it."""
    return (text.replace("\n ", "\n").removeprefix(" ") for text in texts)


def _turn(control: Control, angles: dict[str, float]) -> str:
    """The line of a rapid move of the rotary axes alone; `angles` by name, degrees."""
    words = [_position(control, name, value) for name, value in angles.items()]
    turned = f"{control.begin}{''.join(words)}"
    return f"{control.rapid}{turned}" if control.modal else f"{turned} {control.rapid}"


def _columns(
    control: Control, axes: tuple[str, ...], blocks: Blocks, numbers: np.ndarray, said: Said
) -> list[Column]:
    """The moves as `Column`s."""
    rows, timed = np.arange(len(blocks.words)), ~(blocks.rapid | np.isnan(blocks.seconds))
    start = [] if control.number is None else [Column(control.number, control.numbers(numbers))]
    straight = np.ones(len(rows), bool)
    straight[[row for row, _ in blocks.turns]] = False
    if control.begin:
        start.append(Column(f" {control.begin}", shown=straight))
    before, centres, behind_arcs = _turned(control, blocks)
    positions = []
    for number, (axis, column) in enumerate(zip(axes, blocks.words.T, strict=True)):
        shown = _changes(printed(np.array(column), control.decimals))
        shown[said.anew if number < 3 else said.turned] = True
        if number > 2:
            for first, stop in zip(said.planes[::2], said.planes[1::2], strict=True):
                shown[first:stop] = False  # in a tilted plane
        for row, turn in blocks.turns:
            if _lies_in(number, turn):
                shown[row] = not (turn.helix and control.arcs is not None and control.arcs.helix)
        positions.append(Column(axis_word(axis), column, control.decimals, control.plus, shown))
    positions = [*positions, *centres]
    switched = [Column(f" {word}", shown=rows == row) for row, word in said.switches.items() if word]
    moved = [*switched, *positions] if control.compensation == "before" else [*positions, *switched]
    # A control that switches between times and feeds has forgotten the feed.
    times_before = np.cumsum(timed) * bool(control.inverse_time)
    tools_before = np.searchsorted(said.anew, rows, side="right")
    fed = np.flatnonzero(~(blocks.rapid | timed | np.isnan(blocks.feeds)))
    stated = np.zeros(len(rows), bool)
    stated[fed] = _changes(blocks.feeds[fed]) | _changes(times_before[fed]) | _changes(tools_before[fed])
    whole = blocks.feeds == np.round(blocks.feeds)
    feeds = Column(FEED, blocks.feeds, 0, shown=stated & whole)
    decimals = control.feed_decimals
    parts = Column(FEED, _down(blocks.feeds, decimals), decimals, shown=stated & ~whole)
    modes = _modes(control, blocks.rapid, timed, said, straight)
    behind = _rapid_and_times(control, blocks, timed)
    return [*start, *modes, *before, *moved, *behind_arcs, *behind, feeds, parts, Column("\n")]


def _turned(control: Control, blocks: Blocks) -> tuple[list[Column], list[Column], list[Column]]:
    """What blocks hold that are arcs, as `Column`s: before the positions, the centre, and behind them."""
    arcs = control.arcs
    if arcs is None or not blocks.turns:
        return [], [], []
    count, rows = len(blocks.words), [row for row, _ in blocks.turns]
    turns = [turn for _, turn in blocks.turns]

    def where(holds: Callable[[Turn], bool]) -> np.ndarray:
        shown = np.zeros(count, bool)
        shown[[row for row, turn in blocks.turns if holds(turn)]] = True
        return shown

    def number(word: str, values: list[float], shown: np.ndarray) -> Column:
        column = np.zeros(count)
        column[rows] = values
        return Column(f" {word}", printed(column, control.decimals), control.decimals, control.plus, shown)

    polar = where(lambda turn: turn.helix and bool(arcs.helix))
    before: list[Column] = []
    centres: list[Column] = []
    plane = PLANES[0]
    switched: dict[str, list[int]] = {name: [] for name in arcs.planes}
    for last, (row, turn) in zip([-1, *rows], blocks.turns, strict=False):
        plane = plane if last == row - 1 else PLANES[0]  # where `_around` has selected it again
        if turn.plane != plane:
            plane = turn.plane
            switched[plane].append(row)
    for name, at in switched.items():
        if at and arcs.planes[name]:
            before.append(Column(f" {arcs.planes[name]}", shown=np.isin(np.arange(count), at)))
    if arcs.begin:
        before.append(Column(f" {arcs.begin}", shown=where(lambda turn: True) & ~polar))
    if polar.any():
        sweep = number(arcs.helix[1], [turn.sweep for turn in turns], polar)
        before += [Column(f" {arcs.helix[0]}", shown=polar), sweep]
    senses = [
        Column(f" {arcs.clockwise}", shown=where(lambda turn: turn.clockwise)),
        Column(f" {arcs.counterclockwise}", shown=where(lambda turn: not turn.clockwise)),
    ]
    for axis, word in enumerate(arcs.centre):
        shown = where(partial(_lies_in, axis))
        centres.append(number(word, [turn.offset[axis] for turn in turns], shown))
    return ([*before], centres, senses) if arcs.begin else ([*before, *senses], centres, [])


def _modes(
    control: Control, rapid: np.ndarray, timed: np.ndarray, said: Said, straight: np.ndarray
) -> list[Column]:
    """The modal words as `Column`s, each where it begins to hold and behind a change of the tool.

    F in mm/min holds from the head on.
    """
    words = []
    if control.modal:
        changed = _changes(rapid + 2 * ~straight)
        changed[said.anew] = True
        changed[[row for row in said.further if row < len(changed)]] = False
        words += [(control.linear, changed & ~rapid & straight), (control.rapid, changed & rapid)]
    if control.inverse_time:
        begins, cutting = np.zeros(len(rapid), bool), np.flatnonzero(~rapid)
        before = np.r_[False, timed[cutting]][: len(cutting)]
        behind = np.searchsorted(cutting, said.cycles)
        before[behind[behind < len(cutting)]] = False
        begins[cutting] = timed[cutting] != before
        by_time, by_feed = control.inverse_time
        words += [(by_feed, begins & ~timed), (by_time, begins & timed)]
    return [Column(f" {word}", shown=shown) for word, shown in words]


def _rapid_and_times(control: Control, blocks: Blocks, timed: np.ndarray) -> list[Column]:
    """The words after the positions, except the feed. A time is rounded so that no block is too fast."""
    words = [] if control.modal else [Column(f" {control.rapid}", shown=blocks.rapid)]
    if control.block_time:
        seconds = np.where(timed, np.maximum(-_down(-blocks.seconds, 3), SHORTEST_TIME), 1.0)
        words.append(Column(f" {control.block_time}", seconds, 3, shown=timed))
    else:
        per_minute = _down(60 / np.maximum(blocks.seconds, SHORTEST_TIME), 4)
        words.append(Column(FEED, np.where(timed, np.maximum(per_minute, 1e-4), 1.0), 4, shown=timed))
    return words


def _down(values: Values, decimals: int) -> Values:
    """Round down to so many decimals; what is a multiple but for the last bits stays."""
    return np.floor(values * 10.0**decimals * (1 + 1e-15) + 1e-9) / 10.0**decimals


def _changes(values: np.ndarray) -> np.ndarray:
    """Where a value is not the one before; the first always is not."""
    return np.concatenate([[True], values[1:] != values[:-1]]) if len(values) else np.empty(0, bool)
