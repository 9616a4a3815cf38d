"""Where a program, whoever wrote it, goes along the CL path, and the first place where it does not.

Blocks need not end at records: a post may have divided moves, or left records out that lie on a straight line.
Each block is *placed* on the path, from its beginning to its end: at the first place, not before that of the block
before it, where tip and tool axis keep their tolerances. Before the first record and behind the last one the tool
may go anywhere. In between it may leave the path if it comes back to where it left, or goes on behind rapid moves
of the CL data, and each block is above the place that it left, or where it goes on, or its tip is on their way.
Between two records it may lift along its axis, and come down at a later place: that is said.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from mathpost.formula import compiled, slices
from mathpost.kinematics import Kinematics
from mathpost.path import deviation
from mathpost.path.cl import CLData, commands
from mathpost.rotation import angle_of_chord

if TYPE_CHECKING:
    from mathpost.machine import Machine

BOX = 16  # segments of the path that are looked at together
WINDOW = 200  # records that may lie between the places of two blocks
MANY = 15_000  # blocks; with more of them it pays to load Numba
SAMPLES = 33  # of a move that spans records
SAME_PLACE = 1e-6  # of a record


@dataclass(frozen=True)
class Off:
    """The first place where a program is off its CL path."""

    block: int  # number of the move, from 0
    record: float  # the place on the CL path, from 0
    tip: float  # how far the tip is off, mm,
    axis: float  # and the tool axis, radians
    what: str  # "position", "way" between two blocks, or "end": the block is the last one and records are left
    spans: bool = False  # whether the way leaves out a record


@dataclass(frozen=True)
class Along:
    """A program along its CL path."""

    place: np.ndarray  # shape (n,), where each block ends on the path, NaN for those that are off it
    off: Off | None
    tip: float  # most that the tip is off the path, between the blocks, too, mm,
    axis: float  # and the tool axis, radians; as far as the program goes right
    lifts: tuple[tuple[int, int], ...] = ()  # (first, last block) over what is cut in the CL data, not here


@dataclass(frozen=True)
class Reached:
    """A program as it runs: how the machine comes to the ends of its n blocks."""

    joints: np.ndarray  # shape (n, 5), mm and radians, at the ends
    kin: list[Kinematics]  # of each block
    tcp: np.ndarray  # shape (n,), whether the control keeps the tip on a straight line
    free: np.ndarray  # shape (n,), whether nobody knows the way, and only the ends are judged


def along(
    tips: np.ndarray, axes: np.ndarray, cl: CLData, *, tip: float, axis: float, moves: Reached | None = None
) -> Along:
    """Return a program, given by tips and tool axes at the ends of its n blocks, (n, 3), along its CL path.

    `tip` (mm) and `axis` (radians) are the tolerances. With the `moves` the ways between blocks are judged, too.
    """
    points, directions = cl.points, cl.axes
    if len(points) == 1:
        points, directions = np.repeat(points, 2, axis=0), np.repeat(directions, 2, axis=0)
    loop = compiled(_placed) if len(tips) > MANY else _placed
    place = np.full(len(tips), np.nan)
    poses = [np.ascontiguousarray(each) for each in (tips, axes, points, directions)]
    low, high = _boxes(points, tip)
    loop(poses[0], poses[1], poses[2], poses[3], low, high, tip, axis, place)
    lifts: list[tuple[int, int]] = []
    off = _position_off(tips, axes, cl, points, directions, tip, axis, place, lifts)
    last = len(tips) if off is None or off.what == "end" else off.block
    most = np.zeros(2)
    if moves is not None:
        way, most = _way_off(moves, cl, tip, axis, place[:last])
        if way is not None:
            off = way
    return Along(place, off, float(most[0]), float(most[1]), tuple(lifts))


def _boxes(points: np.ndarray, tip: float) -> tuple[np.ndarray, np.ndarray]:
    """The corners of the boxes around every `BOX` segments of a path, outside of which no tip is on it."""
    starts = np.arange(0, len(points) - 1, BOX)
    corners = []
    for corner in (np.minimum, np.maximum):
        ends = corner(points[:-1], points[1:])
        corners.append(corner.reduceat(ends, starts))
    return corners[0] - tip, corners[1] + tip


def _placed(
    tips: np.ndarray, axes: np.ndarray, points: np.ndarray, directions: np.ndarray, low: np.ndarray,
    high: np.ndarray, tip: float, axis: float, place: np.ndarray,
) -> None:  # fmt: skip
    """Put into `place` where each block ends on the path, or leave NaN."""
    started, at = False, 0.0
    for block in range(len(tips)):
        first = int(at)
        stop = min(first + WINDOW, len(points) - 1) if started else 1
        segment = min(first, len(points) - 2) - 1
        while segment + 1 < stop:
            segment += 1
            box = segment // BOX
            outside = False
            for k in range(3):
                outside = outside or tips[block, k] < low[box, k] or tips[block, k] > high[box, k]
            if outside:
                segment = (box + 1) * BOX - 1
                continue
            up, down = 0.0, 0.0
            for k in range(3):
                step, turn = (
                    points[segment + 1, k] - points[segment, k],
                    directions[segment + 1, k] - directions[segment, k],
                )
                up += (tips[block, k] - points[segment, k]) * step / tip**2
                up += (axes[block, k] - directions[segment, k]) * turn / axis**2
                down += step * step / tip**2 + turn * turn / axis**2
            t = min(max(up / down if down > 0 else 1.0, 0.0), 1.0)
            t = max(t, at - segment)
            if not started:
                t = 0.0
            far, lean, length = 0.0, 0.0, 0.0
            for k in range(3):
                length += (directions[segment, k] + t * (directions[segment + 1, k] - directions[segment, k])) ** 2
            for k in range(3):
                far += (
                    tips[block, k] - points[segment, k] - t * (points[segment + 1, k] - points[segment, k])
                ) ** 2
                on = directions[segment, k] + t * (directions[segment + 1, k] - directions[segment, k])
                lean += (axes[block, k] - on / np.sqrt(length)) ** 2
            if far <= tip**2 and lean <= axis**2:
                started, at = True, segment + t
                place[block] = at
                break


def _position_off(
    tips: np.ndarray, axes: np.ndarray, cl: CLData, points: np.ndarray, directions: np.ndarray, tip: float,
    axis: float, place: np.ndarray, lifts: list[tuple[int, int]],
) -> Off | None:  # fmt: skip
    """The first block that is off although it may not be, or the end of a program that is too short.

    Ways through the air over a stretch that the CL data cut are put into `lifts`.
    """
    on = np.flatnonzero(~np.isnan(place))
    if not on.size:  # nowhere near the first record
        far = np.linalg.norm(tips - points[0], axis=1)
        lean = _angles(axes, directions[0])
        block = int(np.hypot(far / tip, lean / axis).argmin())
        return Off(block, 0.0, float(far[block]), float(lean[block]), "position")
    for before, after in pairwise(on.tolist()):
        if after > before + 1:
            from_place, to_place = place[before], place[after]
            same = to_place - from_place < SAME_PLACE
            rapid = cl.rapid[int(np.floor(from_place)) + 1 : int(np.ceil(to_place)) + 1]
            ends, upwards = cl.at(np.array([from_place, to_place]))
            height = np.vecdot(tips[before + 1 : after, None] - ends, upwards).max(axis=1)
            air = same or (rapid.size and rapid.all())
            some = slice(before, after + 1)
            if not air and not _left_out(cl, from_place, to_place, tip, axis):
                air = _is_lift(tips[some], axes[some], tip, axis)
                lifts += [(before + 1, after)] * air
            inner = np.arange(np.floor(from_place) + 1, np.ceil(to_place))
            way, _ = cl.at(np.r_[from_place, inner, to_place])
            off = deviation.from_segment(tips[before + 1 : after, None], way[:-1], way[1:]).min(axis=1)
            if not air or (np.minimum(-height, off) > tip).any():
                return _nearest(tips, axes, points, directions, tip, axis, before + 1, from_place)
    end = len(cl) - 1
    if end - place[on[-1]] > SAME_PLACE:
        last, there = on[-1], place[on[-1]]
        far = np.linalg.norm(tips[last] - points[end])
        lean = _angles(axes[last], directions[end])
        if far > tip or lean > axis:
            if last + 1 < len(tips):
                return _nearest(tips, axes, points, directions, tip, axis, last + 1, there)
            return Off(int(last), float(there), float(far), float(lean), "end")
    return None


def _left_out(cl: CLData, before: float, after: float, tip: float, axis: float) -> bool:
    """Whether any record between two places is at neither of them."""
    inner = slice(int(np.floor(before + SAME_PLACE)) + 1, int(np.ceil(after - SAME_PLACE)))
    points, directions = cl.at(np.array([before, after]))
    far = np.linalg.norm(cl.points[inner, None] - points, axis=2) > tip
    return bool((far | (_angles(cl.axes[inner, None], directions) > axis)).all(axis=1).any())


def _is_lift(tips: np.ndarray, axes: np.ndarray, tip: float, axis: float) -> bool:
    """Whether the tool leaves the path along its axis, and comes back onto it along its axis at another place."""
    if len(tips) < 4:
        return False
    up, over = tips[[1, -2]] - tips[[0, -1]], axes[[0, -1]]
    beside = np.linalg.norm(up - np.vecdot(up, over)[:, None] * over, axis=1)
    turned = _angles(axes[[1, -2]], over)
    return bool((np.vecdot(up, over) > tip).all() and (beside <= tip).all() and (turned <= axis).all())


def _nearest(
    tips: np.ndarray, axes: np.ndarray, points: np.ndarray, directions: np.ndarray, tip: float, axis: float,
    block: int, place: float,
) -> Off:  # fmt: skip
    """How far a block is off the records that follow its place."""
    record = min(int(np.floor(place + SAME_PLACE)) + 1, len(points) - 1)
    some = slice(record, record + WINDOW)
    far = np.linalg.norm(points[some] - tips[block], axis=1)
    lean = _angles(directions[some], axes[block])
    near = int(np.hypot(far / tip, lean / axis).argmin())
    return Off(int(block), float(record), float(far[near]), float(lean[near]), "position")


def _way_off(run: Reached, cl: CLData, tip: float, axis: float, place: np.ndarray) -> tuple[Off | None, np.ndarray]:
    """The first move between two blocks on the path that strays from it, and how far those before it stray."""
    on = ~np.isnan(place)
    skipped = _inside(place[:-1], place[1:])
    # A move that leaves out records in cut is no right one, whichever way it takes.
    cut = np.r_[0, np.cumsum(~cl.rapid)]
    first = np.nan_to_num(np.floor(place[:-1] + SAME_PLACE)).astype(int) + 1
    misses = cut[np.minimum(first + skipped, len(cl))] > cut[np.minimum(first, len(cl))]
    stated = on[:-1] & on[1:] & ~_to_another_offset(cl, place, tip)
    moves = np.flatnonzero(stated & (misses | ~run.free[1 : len(place)]))
    kin = run.kin
    same = np.array([kin[move] is kin[move + 1] for move in moves], bool)
    moves = moves[same] if moves.size else moves
    worst = np.zeros((2, len(moves)))
    found: Off | None = None
    for machine in dict.fromkeys(kin[move] for move in moves):
        rows = np.array([n for n, move in enumerate(moves) if kin[move] is machine])
        worst[:, rows] = _strays(machine, run.joints, run.tcp, cl, place, moves[rows])
    # A rapid move of the CL data does not count for the tool axis.
    counted = ~cl.rapid[np.clip(np.ceil(place[moves + 1]).astype(int), 0, len(cl) - 1)] if moves.size else on[:0]
    worst[1] *= counted
    wrong = (worst[0] > tip) | (worst[1] > axis)
    if wrong.any():
        n = int(wrong.argmax())
        move = int(moves[n])
        record = float(np.floor(place[move] + SAME_PLACE) + 1)
        found = Off(move + 1, record, float(worst[0, n]), float(worst[1, n]), "way", bool(skipped[move]))
        worst = worst[:, :n]
    return found, worst.max(axis=1, initial=0)


def _to_another_offset(cl: CLData, place: np.ndarray, tip: float) -> np.ndarray:
    """Whether moves go from the last record of one work offset to the first of the next: CL data state no way."""
    named = [(record, command.values[0]) for record, command in commands(cl.remarks, "work offset")]
    first = [record for (_, before), (record, number) in pairwise(named) if number != before]
    record = np.rint(np.nan_to_num(place)).astype(int)
    reached = np.linalg.norm(cl.at(np.nan_to_num(place))[0] - cl.points[record], axis=1) <= tip
    return reached[:-1] & reached[1:] & (record[:-1] == record[1:] - 1) & np.isin(record[1:], first)


def _strays(
    kin: Kinematics, joints: np.ndarray, tcp: np.ndarray, cl: CLData, place: np.ndarray, moves: np.ndarray
) -> np.ndarray:
    """How far moves stray from the CL path, shape (2, m), mm and radians."""
    inside = _inside(place[moves], place[moves + 1])
    spans = inside > 0
    worst = np.zeros((2, len(moves)))
    plain = moves[~spans]
    if plain.size:
        ends = [cl.at(place[rows]) for rows in (plain, plain + 1)]
        tips, axes = zip(*ends, strict=True)
        worst[:, ~spans] = deviation.deviation(kin, joints[plain], joints[plain + 1], tips=tips, axes=axes)
        kept = tcp[plain + 1]
        at = [kin.forward(joints[rows])[0] for rows in (plain, plain + 1)]
        straight = np.max([np.linalg.norm(a - b, axis=1) for a, b in zip(at, tips, strict=True)], axis=0)
        worst[0, ~spans] = np.where(kept, straight, worst[0, ~spans])
    for count in np.unique(inside[spans]).tolist():
        alike = np.flatnonzero(inside == count)
        for part in slices((len(alike), SAMPLES * (count + 1))):
            rows = alike[part]
            worst[:, rows] = _over(kin, joints, tcp, cl, place, moves[rows], count)
    return worst


def _over(
    kin: Kinematics,
    joints: np.ndarray,
    tcp: np.ndarray,
    cl: CLData,
    place: np.ndarray,
    moves: np.ndarray,
    inside: int,
) -> tuple[np.ndarray, np.ndarray]:
    """How far so many records that each of m moves spans are off it, and its samples off the path between them."""
    t = np.linspace(0, 1, SAMPLES)[:, None, None]
    tips, axes = kin.forward(joints[moves] + t * (joints[moves + 1] - joints[moves]))
    tips = np.where(tcp[moves + 1, None], tips[0] + t * (tips[-1] - tips[0]), tips)
    first = np.floor(place[moves] + SAME_PLACE) + 1
    points, directions = cl.at(np.vstack([place[moves], first + np.arange(inside)[:, None], place[moves + 1]]))
    apart, lean = deviation.from_segment, deviation.from_arc
    tip = np.maximum(_furthest(apart, points, tips), _furthest(apart, tips, points))
    return tip, np.maximum(_furthest(lean, directions, axes), _furthest(lean, axes, directions))


def _furthest(off: Callable[..., np.ndarray], vectors: np.ndarray, chains: np.ndarray) -> np.ndarray:
    """How far the furthest of n vectors is off its chain of segments or arcs: (n, m, 3) and (k, m, 3) to (m,)."""
    return off(vectors[:, None], chains[:-1], chains[1:]).min(axis=1).max(axis=0)


def _inside(before: np.ndarray, after: np.ndarray) -> np.ndarray:
    """How many records lie between two places; 0 where one of them is off the path."""
    found = np.ceil(after - SAME_PLACE) - np.floor(before + SAME_PLACE) - 1
    return np.maximum(np.nan_to_num(found), 0).astype(int)


def _angles(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Angles between unit vectors, radians."""
    return angle_of_chord(np.linalg.norm(first - second, axis=-1))


@lru_cache(maxsize=32)
def _kinematics(machine: Machine) -> Kinematics:
    return Kinematics(machine)


def stretches(machines: list, count: int) -> list[tuple[Kinematics, slice]]:
    """Return the blocks, of so many, that one machine with its tool runs, each with its `Kinematics`."""
    ends = [first for first, _ in machines[1:]] + [count]
    return [
        (_kinematics(machine), slice(first, stop))
        for (first, machine), stop in zip(machines, ends, strict=True)
        if first < stop
    ]


def kinematics_of(machines: list, count: int) -> list[Kinematics]:
    """Return the `Kinematics` of each of `count` blocks; `machines` are pairs of a first block and its machine."""
    return [kin for kin, rows in stretches(machines, count) for _ in range(rows.start, rows.stop)]
