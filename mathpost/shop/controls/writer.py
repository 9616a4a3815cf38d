"""Blocks to the text of a program, in the words of any control."""

from __future__ import annotations

import io
import re
from collections.abc import Callable, Iterable, Iterator
from functools import partial
from typing import TypeVar

import numpy as np

from mathpost.machine import Machine
from mathpost.path import text as bulk
from mathpost.path.text import Column
from mathpost.shop.controls.between import Between, lies_in, tool_list
from mathpost.shop.controls.blocks import FEED, Blocks, Turn, axis_word, printed
from mathpost.shop.controls.control import Control, control_for

SHORTEST_TIME = 0.001  # s, the least that a block may state
Values = TypeVar("Values", float, np.ndarray)
MOTION_ONLY = "MOTION ONLY: THE MACHINE FILE GIVES NO HEAD AND NO FOOT"  # a program says so before its first move


def write(
    blocks: Blocks, machine: Machine, control: Control | str = "heidenhain", *, name: str = "MATHPOST"
) -> str:
    """Return the text of a program for a control, or one of that name; words that do not change are left out.

    There is at least one block, and none like the one before. Only letters, digits and underscores of the name are
    used.
    Where the file of the control says how far it may round off, the program says 0: see `state_rounding`.
    """
    control = control_for(machine, control)
    name = re.sub(r"\W", "_", name, flags=re.ASCII).upper() or "MATHPOST"
    said = Between(control, machine, blocks)
    lines_before, rows = said.lines, len(blocks.words)
    own = [*control.start, *machine.program_head] if machine.complete else control.remark(MOTION_ONLY)
    stated = re.search(r"\d{1,4}", name)
    number = f"{int(stated[0]) or 1:04d}" if stated else "0001"

    def filled(lines: Iterable[str]) -> list[str]:
        named = (line.replace("{name}", name).replace("{number}", number) for line in lines)
        return [_with_rounding(line, 0, 0) for line in named]

    lines_before[0][:0] = filled((*control.head, *own, *tool_list(control, blocks)))
    lines_before[rows] += filled(_foot(control, machine))
    numbered = np.zeros(rows + 1, int)  # how many lines before each move, besides the moves
    for row, lines in lines_before.items():
        numbered[row] = sum(not line.startswith(control.unnumbered) for line in lines)
    before = np.cumsum(numbered) + np.arange(rows + 1)
    columns = _columns(control, machine.joint_names, blocks, before[:-1], said)
    texts = io.StringIO()  # unlike pieces that are joined it never holds the text twice
    at = 0
    for row, lines in lines_before.items():
        moves = bulk.lines(columns, at, row)
        texts.writelines(moves if control.number is not None else _without_indent(moves))
        count, at = before[row] - numbered[row], row
        for line in lines:
            if not line.startswith(control.unnumbered):
                skip, line = "/" * line.startswith("/"), line.removeprefix("/")
                line, count = f"{skip}{control.numbered(line, count)}", count + 1
            texts.write(f"{line}\n")
    return texts.getvalue()


def _foot(control: Control, machine: Machine) -> list[str]:
    """The lines after the moves; the foot of the machine may end the program itself."""
    own, end = machine.program_foot, control.end if machine.complete else ()
    before = [line for line in end if not control.ends(line)]
    last = [*(line for line in end if control.ends(line)), *control.foot]
    if any(control.ends(line) for line in own):
        last = [line for line in last if not control.ends(line)]
    return [*before, *own, *last]


def state_rounding(text: str, control: Control, rounding: float, turned: float) -> str:
    """Return a program that says how far the control may round off, mm, and turn the tool, degrees.

    If its file has words for that.
    """
    for line in (*control.head, *control.start):
        before, after = _with_rounding(line, 0, 0), _with_rounding(line, rounding, turned)
        if before != after:
            text = text.replace(before, after, 1)
    return text


def _with_rounding(line: str, rounding: float, turned: float) -> str:
    return line.replace("{rounding}", f"{_down(rounding, 4):.4f}").replace("{turned}", f"{_down(turned, 4):.4f}")


def _without_indent(texts: Iterable[str]) -> Iterator[str]:
    """Lines that begin with a word and not with the blank before it."""
    return (text.replace("\n ", "\n").removeprefix(" ") for text in texts)


def _columns(
    control: Control, axes: tuple[str, ...], blocks: Blocks, numbers: np.ndarray, said: Between
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
            shown[said.approached] = False
            for first, stop in zip(said.planes[::2], said.planes[1::2], strict=True):
                shown[first:stop] = False  # in a tilted plane
        for row, turn in blocks.turns:
            if lies_in(number, turn):
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
    plane = "XY"
    switched: dict[str, list[int]] = {name: [] for name in arcs.planes}
    for last, (row, turn) in zip([-1, *rows], blocks.turns, strict=False):
        plane = plane if last == row - 1 else "XY"  # where `_around` has selected it again
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
        shown = where(partial(lies_in, axis))
        centres.append(number(word, [turn.offset[axis] for turn in turns], shown))
    return ([*before], centres, senses) if arcs.begin else ([*before, *senses], centres, [])


def _modes(
    control: Control, rapid: np.ndarray, timed: np.ndarray, said: Between, straight: np.ndarray
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
