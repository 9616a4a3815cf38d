"""The best way through the candidates of each record, by dynamic programming (动态规划, R. Bellman 1957).

Plain loops over arrays: Numba compiles them where a path is long and it is installed.
"""

from typing import Any, NamedTuple

import numpy as np

from mathpost.machine import UNITS

TURN = 2 * np.pi
HALF_TURN = np.pi + 1e-9  # a rotary step beyond this means that travel has cut off the short way round
TIE = 1e-9  # weight of travel (mm and degrees) among moves that cost the same
QUANTA = 2.0**40  # costs are rounded to multiples of 1/QUANTA: their sums are exact, and equal ways stay equal


class Axes(NamedTuple):
    """A machine's joints in numbers, mm and radians."""

    ends: np.ndarray  # (j, 2), of travel
    endless: np.ndarray  # (j,)
    workpiece_side: int  # which joint that is
    price: np.ndarray  # (j,), of a mm or a radian
    slowest: bool  # whether a move costs what its dearest joint costs, or all together


class Records(NamedTuple):
    """What each of n records may take, and the move to it."""

    solved: np.ndarray  # (s, j, n), the joints of each solution
    turns: np.ndarray  # (j, w), what the windings add: candidate k·w + t is solution k in winding t
    beyond: np.ndarray  # (s, n), whole turns of the workpiece-side joint beyond its short way, on one solution
    meeting: np.ndarray  # (n,), whether the branch may change
    rapid: np.ndarray  # (n,), whether it is out of cut, where nothing breaks the path


def nearest(step: Any) -> Any:
    """A rotary step (radians) less whole turns, in [−180°, 180°].

    Unlike in `rotation.wrap` half a turn keeps its direction: there and back again does not wind an axis up.
    """
    return step - TURN * np.rint(step / TURN)


def cost(steps: np.ndarray, price: np.ndarray, slowest: bool) -> Any:
    """Return what moves cost whose joint steps are `steps[0]`, `steps[1]` …, by `prices`."""
    total = 0.0
    for joint in range(len(steps)):
        part = np.abs(steps[joint]) * price[joint]
        total = np.maximum(total, part) if slowest else total + part
    return total


def best_way(
    machine: Axes, path: Records, beginning: np.ndarray, greedy: bool
) -> tuple[np.ndarray, np.ndarray, int, int]:
    """Find one candidate for each record so that the path has the fewest breaks, and then the least cost.

    Bellman's recursion: the best path to a candidate extends the best path to some candidate of the record before.

        best(r, j) = min over i of [best(r − 1, i) + move(i, j)],    best = (breaks, cost), compared in this order

    `beginning`, (s·w,), is the cost of beginning at each candidate. If `greedy`, only the best candidate of each
    record is kept: the shortest next move.

    Returns the number of the candidate of each record, and whether the move to it breaks the path, both (n,); the
    first record without a candidate inside travel, and the first that every way reaches with a break, or −1.
    """
    records, windings = path.solved.shape[2], path.turns.shape[1]
    count = path.solved.shape[0] * windings
    came_from = np.zeros((records, count), np.int32)  # the candidate of the record before on the best way
    came_by_break = np.zeros((records, count), np.bool_)
    # The candidates inside travel of two records, this one and the one before, take rows 0 and 1 in turn.
    numbers, breaks = np.zeros((2, count), np.int64), np.zeros((2, count), np.int64)
    axes = path.solved.shape[1]
    joints, costs = np.zeros((2, count, axes)), np.zeros((2, count))
    picks, broken, step = np.zeros(records, np.int64), np.zeros(records, np.bool_), np.zeros(axes)
    known, stuck = 0, -1
    for record in range(records):
        now, before, cut = record % 2, (record + 1) % 2, not path.rapid[record]

        found = 0
        for number in range(count):
            inside = True
            for joint in range(axes):
                value = path.solved[number // windings, joint, record] + path.turns[joint, number % windings]
                inside = inside and machine.ends[joint, 0] <= value <= machine.ends[joint, 1]
                joints[now, found, joint] = value
            if inside:
                numbers[now, found] = number
                found += 1
        if found == 0:
            return picks, broken, record, stuck

        best = 0
        for j in range(found):
            breaks[now, j], costs[now, j] = records, np.inf  # worse than any way
            if record == 0:
                breaks[now, j], costs[now, j] = 0, np.rint(beginning[numbers[now, j]] * QUANTA)
            for i in range(known):
                for joint in range(axes):
                    step[joint] = joints[now, j, joint] - joints[before, i, joint]
                    if machine.endless[joint]:
                        step[joint] = nearest(step[joint])
                solution, last = numbers[now, j] // windings, numbers[before, i] // windings
                changed = (solution - last) % 2 == 1
                further = TURN * path.beyond[solution, record] if solution == last else 0.0
                if machine.endless[machine.workpiece_side]:
                    step[machine.workpiece_side] += further
                too_far = abs(step[machine.workpiece_side] - further) > HALF_TURN
                for joint in range(3, axes):
                    too_far = too_far or (joint != machine.workpiece_side and abs(step[joint]) > HALF_TURN)
                breaking = cut and (too_far or (changed and not path.meeting[record]))
                if breaks[before, i] + breaking > breaks[now, j]:
                    continue
                move = cost(step, machine.price, machine.slowest) + TIE * cost(step, UNITS, False)
                way = costs[before, i] + np.rint(move * QUANTA)
                if (breaks[before, i] + breaking, way) < (breaks[now, j], costs[now, j]):
                    breaks[now, j], costs[now, j] = breaks[before, i] + breaking, way
                    came_from[record, numbers[now, j]] = numbers[before, i]
                    came_by_break[record, numbers[now, j]] = breaking
            if (breaks[now, j], costs[now, j]) < (breaks[now, best], costs[now, best]):
                best = j

        if stuck < 0 and breaks[now, best] > 0:
            stuck = record
        if greedy:
            numbers[now, 0], breaks[now, 0] = numbers[now, best], breaks[now, best]
            joints[now, 0], costs[now, 0] = joints[now, best], costs[now, best]
            found, best = 1, 0
        costs[now, :found] -= costs[now, :found].min()  # what all ways have in common would only make numbers long
        pick, known = numbers[now, best], found

    for record in range(records - 1, -1, -1):
        picks[record], broken[record] = pick, came_by_break[record, pick]
        pick = came_from[record, pick]
    return picks, broken, -1, stuck
