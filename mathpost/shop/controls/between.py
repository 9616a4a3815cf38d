"""What a program says between its moves: tools, spindle, cycles, planes, clamps; and its list of tools."""

from __future__ import annotations

from itertools import groupby, pairwise
from operator import itemgetter
from typing import Any

import numpy as np

from mathpost.machine import Machine
from mathpost.path.cl import commands
from mathpost.path.modal import Command
from mathpost.shop.controls.blocks import PLANES, Blocks, Turn, axis_word
from mathpost.shop.controls.control import Control

Texts = dict[int, list[str]]  # lines by the move that follows
RESTS = 8  # moves in which a rotary axis stands still, that are worth clamping it


def tool_list(control: Control, blocks: Blocks) -> list[str]:
    """Comments on the tools of a program: number, what the CL data call each, length, offsets, what it is for.

    What a cutter and an operation are called may stand before the change of the tool or behind it.
    """
    lengths: dict[int | None, list[str]] = {}
    named: dict[int | None, list[str]] = {}
    used: dict[int | None, list[str]] = {}
    now: int | None = None
    for _, group in groupby(blocks.remarks, key=itemgetter(0)):
        orders = [each for _, each in group if isinstance(each, Command)]
        for number, length, offset in (each.values for each in orders if each.kind == "tool"):
            now = number
            stated = "LENGTH OF THE MACHINE FILE" if length is None else f"LENGTH {length:g} MM"
            lengths[now] = [stated, f"OFFSET {offset or number}"]
        for order in orders:
            if order.kind == "compensation" and order.values[0] != "OFF" and now is not None:
                lengths[now].append(f"RADIUS OFFSET {order.values[1]}")
            elif order.kind == "cutter":
                named.setdefault(now, []).append(" ".join(order.values))
            elif order.kind == "operation":
                used.setdefault(now, []).append(order.values[0])
                named.setdefault(now, []).extend(order.values[1:])
    lines = []
    for tool in dict.fromkeys([*lengths, *named, *used]):
        said = ", ".join(dict.fromkeys([*named.get(tool, []), *lengths.get(tool, [])]))
        purpose = ", ".join(dict.fromkeys(used.get(tool, [])))
        number = "TOOL" if tool is None else f"TOOL {tool}"
        lines += control.remark(": ".join(filter(None, [number, said, purpose])))
    return lines


class Between:
    """What a program says between its moves, and how that changes the moves.

    It keeps what holds from one move to the next, while the lines between them are made.
    """

    def __init__(self, control: Control, machine: Machine, blocks: Blocks) -> None:
        self.control, self.machine, self.blocks = control, machine, blocks
        self.rows = len(blocks.words)
        self.offset = self.edge = 1
        self.tcp = self.unnamed = False  # whether the control keeps the tip, and whether X Y Z name it no more
        if machine.complete:  # as behind any words that switch TCP off, if the own head does not name it
            words, named = (set(" ".join(lines).split()) for lines in (control.start, machine.program_head))
            tip = {line.split()[0] for line in control.lines("tip", 1)}
            self.unnamed = not words.isdisjoint(control.lines("TCP off")) and named.isdisjoint(tip)
        self.selected = ""  # line of the work offset
        self.speed: float | None = None  # of the spindle, as stated for this tool
        self.running: dict[str, str] = {}  # the lines that stop spindle and coolant, of those that are on
        self.wanted = np.r_[blocks.tcp, False]  # behind the last move it is off
        switched = np.flatnonzero(np.diff(self.wanted)) + 1
        self.changes = [0, *switched.tolist()]
        self.switches: dict[int, str] = {}  # words that a move itself takes, by its number
        self.cycles: list[int] = []  # moves behind drilling cycles, which have a feed in mm per minute
        self.drilled: list[int] = []
        self.planes: list[int] = []  # the first moves in a tilted plane and behind it, in turn
        self.further: list[int] = []  # to holes of the cycle that is on, which a word such as G0 would end
        self.cut = np.flatnonzero(~blocks.rapid)
        tools = [(row, remark.values[0]) for row, remark in commands(blocks.remarks, "tool")]
        self.following = {row: after for (row, now), (_, after) in pairwise([*tools, *tools[:1]]) if after != now}
        self.clamps, self.released, self.clamped = _clamps(machine, blocks)

        self.lines = self._lines()  # by the number of the move that follows, also behind the last
        # Moves that state X Y Z, feed and modes anew: behind a change of the tool, a plane or a cycle;
        self.anew = sorted({row for row in [*self.changes, *self.drilled] if row < self.rows})
        # those of them that state the rotary axes, too, but for those where a line before has turned them.
        self.turned = sorted({row for row in self.changes if row < self.rows})
        self.approached = [row for row, _ in commands(blocks.remarks, "approach")]

    def _lines(self) -> Texts:
        around = _around(self.control, self.machine.joint_names, self.blocks)
        said: dict[int, list[str | Command]] = {
            row: [] for row in sorted({*self.changes, *around, *self.clamps, self.rows})
        }
        for row, remark in self.blocks.remarks:
            said.setdefault(min(row, self.rows), []).append(remark)
        lines: Texts = {}
        for row in sorted(said):
            restored, pole = around.get(row, ([], []))
            lines[row] = [*restored, *self.clamps.get(row, []), *self.row(row, said[row]), *pole]
        lines[self.rows] += self.running.values()
        return lines

    def row(self, row: int, remarks: list[str | Command]) -> list[str]:
        """Lines before a move."""
        control, lines, off = self.control, [], self.control.lines("TCP off")
        reselect = control.work_offsets.anew  # where words that switch TCP deselect the work offset
        own = any(isinstance(remark, Command) and remark.kind in ("plane", "cycle") for remark in remarks)
        if self.tcp and not self.wanted[row] and own:  # the control keeps no tip in a plane or a cycle
            lines += [*off, *filter(None, [self.selected * reselect])]
            self.unnamed, self.tcp = True, False
        for at, remark in enumerate(remarks):
            if isinstance(remark, str):
                lines += control.remark(remark)
            else:
                first = len(lines)
                lines += self.command(row, remark, remarks[at + 1 :])
                if remark.skip:
                    lines[first:] = [f"/{line}" for line in lines[first:]]
        if self.wanted[row] != self.tcp:
            self.tcp = bool(self.wanted[row])
            self.unnamed = not self.tcp
            lines += control.lines("TCP on", self.offset) if self.tcp else off
            lines += filter(None, [self.selected * reselect])
        if self.unnamed and not self.tcp and row < self.rows and self.machine.programmed_point == "tip":
            # In the block itself: X Y Z name the tip again.
            tip = [*control.lines("tip", self.offset), *filter(None, [self.switches.get(row)])]
            self.switches[row], self.unnamed = " ".join(tip), False
        return lines

    def without_tcp(self) -> list[str]:
        """Lines that end TCP, before words that it does not go with."""
        lines, self.tcp = self.control.lines("TCP off") * self.tcp, False
        return lines

    def command(self, row: int, remark: Command, following: list[str | Command]) -> list[str]:
        """Lines of a command before a move; `following` are those behind it."""
        control, kind, values = self.control, remark.kind, remark.values
        if kind == "compensation":
            (side,) = control.lines(f"{kind} {values[0]}", *values)
            self.switches[row] = f"{self.switches[row]} {side}" if self.switches.get(row) else side
            return []
        if kind == "cutter":
            return []
        if kind == "operation":
            return control.remark(values[0], control.operation)
        if kind == "tool":
            return self.tool(row, values, following)
        if kind == "work offset":
            self.unnamed = self.unnamed or self.tcp
            self.selected = control.work_offset_line(*values)
            self.changes.append(row)
            return [*self.without_tcp(), self.selected]
        if kind == "safe":
            return control.lines("safe", *values)
        if kind == "approach":
            height, angles = values
            turn = [*self.released.get(row, []), _turn(control, angles), *self.clamped.get(row, [])]
            return [*control.lines("safe", height), *control.lines("edge", edge=self.edge), *turn]
        if kind == "cycle":
            last = self.cut[np.searchsorted(self.cut, row) - 1] if (self.cut < row).any() else -1
            timed = last >= max(self.cycles, default=0) and not np.isnan(self.blocks.seconds[last])
            self.cycles.append(row)
            self.further += [row] if control.cycles and not control.cycles.modal else []
            in_time = [control.inverse_time[1]] if control.inverse_time and timed else []
            return [*in_time, *(line.format(**values[1]) for line in values[0])]
        if kind in ("plane", "cycle off", "plane off"):
            (self.drilled if kind == "cycle off" else self.changes).append(row)
            if self.further[-1:] == [row]:
                self.further.pop()
            self.planes += [row] if kind.startswith("plane") else []
            return list(values[0])
        if kind == "offset":
            self.unnamed = self.unnamed or self.tcp
            lines = self.without_tcp()
            self.offset = self.edge = values[0]
            needed = self.wanted[row] or self.machine.programmed_point == "tip"
            return [*lines, *control.said(remark)] if needed else lines
        if kind in ("spindle", "coolant") and not remark.skip:
            return self.switch(remark)
        return control.said(remark)

    def tool(self, row: int, values: tuple[Any, ...], following: list[str | Command]) -> list[str]:
        """Lines that change the tool, spindle and coolant off; where the control takes it, with the speed."""
        tool, _, stated = values
        control, lines = self.control, [*self.without_tcp(), *self.running.values()]
        self.offset, self.edge, self.speed, self.running = stated or tool, stated or 1, None, {}
        self.changes.append(row)
        self.unnamed = not self.machine.tool_change
        if self.machine.tool_change:
            change = (line.replace("{tool}", str(tool)) for line in self.machine.tool_change)
            return [*lines, *(line.replace("{offset}", str(self.offset)) for line in change)]
        turns = [each for each in following if isinstance(each, Command) and each.kind == "spindle"]
        if turns and not turns[0].skip and turns[0].values[0] is not None and control.commands["tool with speed"]:
            self.speed = turns[0].values[0]
            lines += control.lines("tool with speed", tool, self.speed, edge=self.edge)
        else:
            lines += control.lines("tool", tool, edge=self.edge)
        return [*lines, *(control.lines("next tool", self.following[row]) if row in self.following else [])]

    def switch(self, remark: Command) -> list[str]:
        """Lines for spindle or coolant, and which line stops it."""
        kind, values, lines = remark.kind, remark.values, []
        if kind == "spindle":
            value, sense = values
            remark = Command(kind, (None if value == self.speed else value, sense), "")
            self.speed = value if value is not None else self.speed
        news = self.control.said(remark)
        if any(line.startswith(self.control.without_tcp) for line in news):
            lines = self.without_tcp()
        self.running.pop(kind, None)
        if values[-1] != "OFF" and self.machine.complete:
            self.running.update((kind, line) for line in self.control.lines(f"{kind} OFF"))
        return [*lines, *news]


def _clamps(machine: Machine, blocks: Blocks) -> tuple[Texts, Texts, Texts]:
    """Words that clamp or release rotary axes, by the move that follows; those around an approach's turn apart.

    An axis is clamped where it stands still for more than a few moves, or for a hole.
    """
    lines: Texts = {}
    released: Texts = {}
    clamped: Texts = {}
    approached = [row for row, _ in commands(blocks.remarks, "approach")]
    drilled = np.array([row for row, _ in commands(blocks.remarks, "cycle")])
    for joint, words in zip(machine.rotary, blocks.words.T[3:], strict=True):
        if not joint.clamp:
            continue
        hold, free = joint.clamp
        turns = np.r_[True, words[1:] != words[:-1]]
        turns[approached] = True
        at, fixed = np.flatnonzero(turns).tolist(), True
        for row, after in pairwise([*at, len(words)]):
            there = row in approached
            if fixed:
                (released if there else lines).setdefault(row, []).append(free)
            fixed = after - row > RESTS or bool(((drilled > row) & (drilled <= after)).any())
            if fixed:
                (clamped if there else lines).setdefault(row if there else row + 1, []).append(hold)
    return lines, released, clamped


def _around(control: Control, axes: tuple[str, ...], blocks: Blocks) -> dict[int, tuple[list[str], list[str]]]:
    """Lines before the moves from arcs: that select the plane XY again, and that state a centre; by row, a pair."""
    lines: dict[int, tuple[list[str], list[str]]] = {}
    arcs = control.arcs
    if arcs is None:
        return lines
    turns = dict(blocks.turns)
    for row, turn in blocks.turns:
        if arcs.pole:
            in_plane = sorted(PLANES[turn.plane][:2])
            words = [_position(control, axes[axis], turn.centre[axis]) for axis in in_plane]
            lines[row] = [], [f"{arcs.pole}{''.join(words)}"]
        elif turn.plane != "XY" and row + 1 not in turns:
            lines[row + 1] = [arcs.planes["XY"]], []
    return lines


def lies_in(axis: int, turn: Turn) -> bool:
    """Whether an axis is one of the plane of an arc."""
    return axis in PLANES[turn.plane][:2]


def _position(control: Control, name: str, value: float) -> str:
    return f"{axis_word(name)}{value:{control.plus}z.{control.decimals}f}"


def _turn(control: Control, angles: dict[str, float]) -> str:
    """The line of a rapid move of the rotary axes alone; `angles` by name, degrees."""
    words = [_position(control, name, value) for name, value in angles.items()]
    turned = f"{control.begin}{''.join(words)}"
    return f"{control.rapid}{turned}" if control.modal else f"{turned} {control.rapid}"
