"""Every move of a program's text, from its first line to its last: inside travel, and clear of what is around it.

Moves that the plan of a tool made are judged as they were read back; lines of the user's (head, foot, tool change
of the machine file), and the way to the safe position, as the reader finds them. Where nobody knows all axes, they
may be anywhere in their travel.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from mathpost.errors import MathpostError
from mathpost.formula import slices
from mathpost.kinematics import Kinematics
from mathpost.machine import Machine
from mathpost.machine_file import PROGRAM
from mathpost.shop.controls.reader import Program
from mathpost.shop.controls.track import Blind
from mathpost.shop.post.along import kinematics_of
from mathpost.shop.post.body import BODY, spread
from mathpost.shop.post.clear import CLEAR, HITS, Ways, judged, placed
from mathpost.shop.post.cuts import Cuts
from mathpost.shop.post.proof import joints_of

if TYPE_CHECKING:
    from mathpost.shop.post.steps import Plan

TURN = np.radians(5.0)  # between the positions of a rotary axis that are looked at while it turns
SAME = 1e-6  # mm and degrees: words that are read back as they were written


def lines_of(text: str, machine: Machine) -> dict[int, str]:
    """Return the lines of a program that are the user's, by number: the key of the machine file, and its line."""
    found = {}
    for field, key in PROGRAM.items():
        for line in getattr(machine, field):
            same = re.escape(line.strip()).replace(r"\{name\}", r"\w+")
            same = re.sub(r"\\\{(tool|offset|number)\\\}", r"\\d+", same)
            for match in re.finditer(rf"^/?[ \t]*N?\d*[ \t]*{same}[ \t]*$", text, re.MULTILINE) if same else ():
                found[text.count("\n", 0, match.start()) + 1] = f"{machine.name}, [program] {key}, {line!r}"
    return found


def where(text: str, own: dict[int, str], name: str, line: int) -> str:
    """Return what an error says of a line of a program."""
    return own.get(line) or f"{name}, line {line}, {text.splitlines()[line - 1].strip()!r}"


def begins(program: Program, plan: Plan, first: int, own: dict[int, str]) -> int:
    """Return the row of the program, from `first` on, with the first move of a plan: before it are others."""
    rows, wanted = program.blocks.words, plan.moves.blocks.words[0].copy()
    wanted[:3] += plan.path.shift
    row = first
    while row < len(rows) and program.lines[row] in own:
        row += 1
    for at in range(row, min(row + 3, len(rows))):  # behind the approach: to the safe Z, then the rotary axes turn
        if np.abs(rows[at] - wanted).max() < SAME:
            while at + 1 < len(rows) and np.abs(rows[at + 1] - wanted).max() < SAME:
                at += 1
            return at
    return row


def refuse_unsafe(
    plans: Sequence[Plan], starts: Sequence[int], program: Program, others: Iterable[int], text: str,
    own: dict[int, str], name: str, *, interpolated: bool,
) -> list[Plan]:  # fmt: skip
    """Return the plans with cautions on rapid moves of the CL data that are not clear of what is cut.

    `MathpostError` for the first other move of a program that is not, or that is out of travel.

    `starts` are the rows of the program at which the plans begin, `others` those that no plan made, `own` the
    user's lines from `lines_of`.
    """
    first = plans[0].path
    cuts = first.cuts.moved(first.kin.machine.origin)
    safe = {start for plan, start in zip(plans, starts, strict=True) if plan.moves.motion.lifted[0]}
    ends = np.cumsum([len(plan.path.cl) for plan in plans])
    for step in _steps(program, sorted({*others, *safe})):
        done = np.searchsorted(starts, step.block)  # plans that are done by then
        place = float(ends[done - 1] - 1) if done else -1.0
        why = why_unsafe(step, cuts.moved(np.negative(step.machine.origin)), place, interpolated)
        if why:
            raise MathpostError(f"{where(text, own, name, step.line)}: {why}")
    return [replace(plan, cautions=(*plan.cautions, *_cautions(plan, interpolated))) for plan in plans]


def _steps(program: Program, rows: Sequence[int]) -> list[Blind]:
    """The moves to some rows, and those that end where nobody knows all axes, in the order of the program."""
    words, tcp, lines = program.blocks.words, program.blocks.tcp, program.lines
    nowhere = [each for each in program.blind if np.isnan(each.end).any()]
    known = {each.block: each for each in program.blind if not np.isnan(each.end).any()}
    for row in rows:
        machine = next(machine for first, machine in reversed(program.machines) if first <= row)
        step = Blind(int(lines[row]), row, machine, words[row - 1], words[row], bool(tcp[row]), aside=False)
        nowhere.append(known.get(row, step))
    return sorted(nowhere, key=lambda step: step.line)


def _cautions(plan: Plan, interpolated: bool) -> Iterator[str]:
    """Refuse a lifted way that is not clear, and any into a fixture; say which other rapid moves are not clear."""
    path, motion, blocks = plan.path, plan.moves.motion, plan.moves.blocks
    ways = path.ways(joints_of(path.kin, blocks), motion, interpolated | ~blocks.rapid, blocks.tcp)
    rows = np.arange(1, len(ways.joints))
    found = judged(path.kin, ways, rows, path.touched)
    bad, body = rows[found != CLEAR], f"the tool's body, {2 * BODY:g} mm across"
    if (hit := rows[found == HITS]).size:
        raise MathpostError(f"{path.cl.where(motion.place[hit[0]])}: on its way there {body}, hits a fixture")
    if (lifted := bad[~motion.in_cut[bad - 1]]).size:
        row = int(lifted[0])
        way = "to a safe position" if motion.far[row - 1] else "lifted"
        meets = f"{body}, meets {path.touched}, or nobody knows its way"
        raise MathpostError(f"{path.cl.where(motion.place[row])}: on its way there, {way}, {meets}")
    if bad.size:
        record = path.first + int(motion.record[bad[0]]) + 1
        meets = f"in which {body}, meets {path.touched}, {bad.size}"
        yield f"rapid moves of the CL data {meets}: the first to record {record}"


def why_unsafe(step: Blind, cuts: Cuts, place: float, interpolated: bool) -> str:
    """Return what is wrong with a move from or to where not all axes need be known, or nothing.

    `cuts` count from the origin of its machine; those up to a `place` on the path are made.
    """
    machine, kin = step.machine, kinematics_of([(0, step.machine)], 1)[0]
    start, end = (each / machine.units for each in (step.start, step.end))
    low, high = machine.limits.T
    missing, names = np.isnan(start) | np.isnan(end), machine.joint_names
    if not step.tcp:
        outside = machine.out_of_travel(np.where(np.isnan(end), np.clip(0, low, high), end))
        if outside:
            return "; ".join(outside)
    elif missing.any():
        lacking = ", ".join(name for name, lacks in zip(names, missing, strict=True) if lacks)
        return f"the tip moves, and nobody knows where {lacking} stand"
    if not missing.any():
        one = np.ones(2, bool)
        both, nothing = np.array([start, end]), np.full(2, -1)
        ways = Ways(both, np.full(2, place), one * interpolated, one * step.tcp, nothing, ~one, ~one)
        if judged(kin, ways, np.array([1]), cuts)[0] == CLEAR:
            return ""
    else:
        unknown = np.isnan([start[2], end[2]])
        moves = ~np.isnan(end) & (start != end)
        if unknown.any() and not step.aside and (unknown[1] or moves[[0, 1, *range(3, len(names))]].any()):
            return "other axes move, and nobody knows where Z stands: first it goes to a safe position"
        if unknown[1] or not cuts.ends.size:
            return ""  # where the machine itself has put it
    height = np.nanmin([start[2], end[2]])
    travel = np.where(machine.endless[3:, None], [-np.pi, np.pi], machine.limits[3:])
    turns = np.where(missing[3:, None], travel, np.stack([start[3:], end[3:]], axis=1))
    ends = cuts.ends
    corners = np.array(list(product(*np.stack([ends.min(axis=0), ends.max(axis=0)], axis=1))))
    if height >= highest(kin, corners, turns) or height >= (top := highest(kin, ends[spread(ends)], turns)):
        return ""
    if not missing.any():
        return f"on its way there its body, {2 * BODY:g} mm across, meets {cuts}"
    at = f"Z {height + machine.slides[2]:g}, where nobody knows all axes,"
    return f"{at} is not above {cuts}: with this tool that reaches Z {top + machine.slides[2]:.3f}"


def highest(kin: Kinematics, points: np.ndarray, turns: np.ndarray) -> float:
    """Return the greatest Z, as a word, at which the tool may touch some points, (n, 3), wherever X and Y are.

    And wherever the k rotary axes are between two angles each, `turns` of shape (k, 2), radians.
    """
    angles = np.array(list(product(*(np.linspace(a, b, 2 + int(abs(b - a) / TURN)) for a, b in turns))))
    _, axes = kin.forward(np.c_[np.zeros((len(angles), 3)), angles])
    along = kin.close(points[0] + axes, angles)[:, 2] - placed(kin, points[0], angles)[:, 2]  # Z of the tool axis
    top = -np.inf
    for rows in slices((len(angles), len(points))):
        of_points = placed(kin, points, angles[rows, None])[..., 2].max(axis=1)
        top = max(top, (of_points + BODY * np.sqrt(np.maximum(1 - along[rows] ** 2, 0))).max())
    return float(top)
