"""Bellman's recursion over the candidates of a path, and what it calls: within travel, the short way, the cost.

The loop runs as it stands, or as machine code if Numba compiles it. The functions that it calls stand beside it
because Numba keeps its machine code by file: were they in another one, a change there would go unnoticed. They take
numbers as well as arrays.
"""

from functools import cache

import numpy as np

TURN = 2 * np.pi
HALF_TURN = np.pi + 1e-9  # a rotary step beyond this means that travel has cut off the short way round
TRAVEL_TOLERANCE = 1e-9  # mm and radians
UNITS = np.array([1, 1, 1, np.degrees(1), np.degrees(1)])  # mm and degrees of one mm or radian of each joint
TIE = 1e-9  # weight of travel (mm and degrees) among moves that cost the same
QUANTA = 2.0**40  # costs are rounded to multiples of 1/QUANTA: their sums are exact, and equal ways stay equal
LONG = 100_000  # moves to compare; with more of them it pays to load Numba


def best_way(solved, turns, limits, endless, beginning, price, slowest, meeting, rapid, greedy):
    """Find the candidate of each record: with the fewest breaks on the way, and among those of the least cost.

    Bellman's recursion: the best way to a candidate goes by the best way to one of the record before it.

        best(r, j) = min over i of [best(r − 1, i) + move(i, j)],    best = (breaks, cost), compared in this order

    Parameters
    ----------
    solved, turns : ndarrays, shape (5, s, n) and (5, w)
        Joints of each record's solutions, and what the windings add: candidate ``k·w + t`` is solution ``k`` in
        winding ``t``.
    limits, endless : ndarrays, shape (5, 2) and (5,)
        Travel, and which joints have no end.
    beginning : ndarray, shape (s·w,)
        What it costs to begin with each candidate.
    price, slowest
        What a move costs, see `cost`.
    meeting, rapid : ndarrays of bool, shape (n,)
        Moves to each record on which the branches meet, so that it may change, and those in rapid traverse, which
        never break the path.
    greedy : bool
        Whether only the best candidate of each record is kept: the shortest next move.

    Returns
    -------
    picks, broken : ndarrays, shape (n,)
        Number of the candidate of each record, and whether the move to it breaks the path.
    unreachable, stuck : int
        First record without a candidate inside travel, and first that every way reaches with a break; or −1.
    """
    records, windings = solved.shape[2], turns.shape[1]
    count = solved.shape[1] * windings
    came_from = np.zeros((records, count), np.int32)  # the candidate of the record before on the best way
    came_by_break = np.zeros((records, count), np.bool_)
    # The candidates inside travel of two records, this one and the one before, take rows 0 and 1 in turn.
    numbers, breaks = np.zeros((2, count), np.int64), np.zeros((2, count), np.int64)
    joints, costs = np.zeros((2, count, 5)), np.zeros((2, count))
    picks, broken, step = np.zeros(records, np.int64), np.zeros(records, np.bool_), np.zeros(5)
    known, stuck = 0, -1
    for record in range(records):
        now, before, cut = record % 2, (record + 1) % 2, not rapid[record]

        found = 0
        for number in range(count):
            inside = True
            for joint in range(5):
                value = solved[joint, number // windings, record] + turns[joint, number % windings]
                inside = inside and within_travel(value, limits[joint, 0], limits[joint, 1])
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
                for joint in range(5):
                    step[joint] = joints[now, j, joint] - joints[before, i, joint]
                    if endless[joint]:
                        step[joint] = nearest(step[joint])
                changed = (numbers[now, j] // windings - numbers[before, i] // windings) % 2 == 1
                too_far = max(abs(step[3]), abs(step[4])) > HALF_TURN
                breaking = cut and (too_far or (changed and not meeting[record]))
                if breaks[before, i] + breaking > breaks[now, j]:
                    continue
                move = cost(step, price, slowest) + TIE * cost(step, UNITS, False)
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


def within_travel(value, low, high):
    """Return whether joint values are inside their travel, ends included; NaN is not.

    Examples
    --------
    >>> within_travel(np.array([-1.0, 0.0, np.nan]), 0.0, np.inf)
    array([False,  True, False])
    """
    return (low - TRAVEL_TOLERANCE <= value) & (value <= high + TRAVEL_TOLERANCE)


def nearest(step):
    """Return a rotary step (radians) less whole turns, in [−180°, 180°].

    Half a turn keeps its direction, so that there and back again does not wind an axis up; this is where it differs
    from `rotation.wrap`.

    Examples
    --------
    >>> np.degrees(nearest(np.radians([190, 180, -180, 720])))
    array([-170.,  180., -180.,    0.])
    """
    return step - TURN * np.rint(step / TURN)


def cost(steps, price, slowest):
    """Return what moves cost whose joint steps are `steps[0]` … `steps[4]`, by `travel.rates_or_weights`."""
    total = 0.0
    for joint in range(5):
        part = np.abs(steps[joint]) * price[joint]
        total = np.maximum(total, part) if slowest else total + part
    return total


@cache
def compiled(loop, *helpers):
    """A loop as machine code, kept for all sessions if there is a folder for it; as it stands without Numba."""
    try:
        from numba import njit
        from numba.extending import register_jitable
    except ImportError:
        return loop
    for function in helpers:
        register_jitable(function)
    try:
        return njit(cache=True)(loop)
    except RuntimeError:  # neither here nor in the home folder
        return njit()(loop)


def loop(moves):
    """`best_way` as it suits so many moves."""
    return compiled(best_way, within_travel, nearest, cost) if moves > LONG else best_way
