"""Travel and moves: what is inside travel, the short way round, what a move costs, and the cheapest way of a path.

`best_way` runs as it stands, or as machine code if Numba compiles it. What it calls stands beside it because Numba
keeps its machine code by file: a change in another one would go unnoticed. Those functions take numbers as well as
arrays.
"""

from dataclasses import replace
from functools import cache

import numpy as np

from mathpost.machine import ENDLESS

TURN = 2 * np.pi
HALF_TURN = np.pi + 1e-9  # a rotary step beyond this means that travel has cut off the short way round
TRAVEL_TOLERANCE = 1e-9  # mm and radians
MANY = 10  # turns of travel
UNITS = np.array([1, 1, 1, np.degrees(1), np.degrees(1)])  # mm and degrees of one mm or radian of each joint
TIE = 1e-9  # weight of travel (mm and degrees) among moves that cost the same
QUANTA = 2.0**40  # costs are rounded to multiples of 1/QUANTA: their sums are exact, and equal ways stay equal
LONG = 100_000  # moves to compare; with more of them it pays to load Numba


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


def all_within(machine, joints):
    """Return whether all five of the joints, shape (..., 5) in mm and radians, are inside travel."""
    return within_travel(joints, *machine.limits.T).all(axis=-1)


def out_of_travel(machine, joints):
    """Return a sentence for each of the joints, shape (5,) in mm and radians, that is outside travel.

    Examples
    --------
    >>> from mathpost import machine
    >>> out_of_travel(machine.load("data/machines/dmu50v.toml"), np.array([0, 0, 900, 0, 7]))
    ['Z 900.000mm is outside -200 … 200']
    """
    moved = np.r_[machine.slides, 0, 0]  # where the slides are
    return [
        f"{'slide ' * bool(by)}{name} {(value + by) * unit:.3f}{letter} is outside "
        f"{(low + by) * unit:g} … {(high + by) * unit:g}"
        for name, value, (low, high), by, unit, letter in zip(
            machine.joint_names, joints, machine.limits, moved, UNITS, ("mm", "mm", "mm", "°", "°"), strict=True
        )
        if not within_travel(value, low, high)
    ]


def endless(machine):
    """Return which of the five joints are rotary axes without an end of travel, shape (5,)."""
    return ~np.isfinite(machine.limits).all(axis=1) & (np.arange(5) > 2)


def without_far_limits(machine):
    """Return the machine with its rotary axes endless that have room for more than `MANY` turns.

    Examples
    --------
    >>> from mathpost import machine
    >>> dmu50v = machine.load("data/machines/dmu50v.toml")
    >>> without_far_limits(dmu50v) == dmu50v
    True
    """
    rotary = (
        replace(joint, limits=ENDLESS) if joint.limits[1] - joint.limits[0] > MANY * TURN else joint
        for joint in machine.rotary
    )
    return replace(machine, rotary=tuple(rotary))


def windings(low, high):
    """Return the whole turns that may bring an angle in [−180°, 180°] into travel, radians, least turns first.

    An endless axis has one winding here: its turns are counted when the path is known.

    Examples
    --------
    >>> np.degrees(windings(np.radians(-200), np.radians(360)))
    array([   0., -360.,  360.])
    """
    if not (np.isfinite(low) and np.isfinite(high)):
        return np.zeros(1)
    turns = np.arange(np.floor((low - np.pi) / TURN), np.ceil((high + np.pi) / TURN) + 1)
    turns = turns[(turns * TURN - np.pi <= high) & (turns * TURN + np.pi >= low)]
    return TURN * turns[np.argsort(np.abs(turns), kind="stable")]


def short_way(machine, steps):
    """Return joint steps, shape (..., 5), with those of endless axes brought into [−180°, 180°]."""
    steps = np.array(steps, dtype=float)
    around = endless(machine)
    steps[..., around] = nearest(steps[..., around])
    return steps


def rates_or_weights(machine, weights=None):
    """Return what a mm or radian of each joint costs, shape (5,), and whether only the slowest joint counts."""
    rates = machine.max_rates
    if weights is None and not np.isnan(rates).all():
        return np.nan_to_num(1 / rates), True
    return UNITS * (1.0 if weights is None else np.asarray(weights, dtype=float)), False


def move_costs(machine, steps, weights=None):
    """Return what moves by the joint steps `steps`, shape (..., 5) in mm and radians, cost, shape (...).

    `weights`, shape (5,), are the cost of travel per mm and per degree, to add up. Without them the cost is the
    seconds that the slowest axis needs, over the axes whose rate the machine states; if it states none, the sum of
    mm and degrees.

    Examples
    --------
    >>> from mathpost import machine
    >>> dmu50v = machine.load("data/machines/dmu50v.toml")
    >>> steps = [[0, 0, 100, 0, np.pi]]
    >>> move_costs(dmu50v, steps), move_costs(dmu50v, steps, weights=[1, 1, 1, 1, 1])
    (array([5.]), array([280.]))
    """
    return cost(np.moveaxis(np.asarray(steps, dtype=float), -1, 0), *rates_or_weights(machine, weights))


def path_cost(machine, joints, weights=None, start=None):
    """Return what a sequence of joints, shape (n, 5), costs, the way from `start` to its first row included."""
    total = float(np.sum(cost([np.diff(joint) for joint in joints.T], *rates_or_weights(machine, weights))))
    if start is not None and len(joints):
        total += float(move_costs(machine, short_way(machine, joints[0] - start), weights))
    return total


def best_way(solved, turns, outer, beyond, limits, endless, beginning, price, slowest, meeting, rapid, greedy):
    """Find the candidate of each record: with the fewest breaks on the way, and among those of the least cost.

    Bellman's recursion: the best way to a candidate goes by the best way to one of the record before it.

        best(r, j) = min over i of [best(r − 1, i) + move(i, j)],    best = (breaks, cost), compared in this order

    Parameters
    ----------
    solved, turns : ndarrays, shape (5, s, n) and (5, w)
        Joints of each record's solutions, and what the windings add: candidate ``k·w + t`` is solution ``k`` in
        winding ``t``.
    outer, beyond : int, ndarray of int, shape (s, n)
        The outer axis, and how many whole turns it makes beyond its short way to each record, on the same solution.
    limits, endless : ndarrays, shape (5, 2) and (5,)
        Travel, and which joints have no end.
    beginning : ndarray, shape (s·w,)
        What it costs to begin with each candidate.
    price, slowest
        By `rates_or_weights`.
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
                solution, last = numbers[now, j] // windings, numbers[before, i] // windings
                changed = (solution - last) % 2 == 1
                further = TURN * beyond[solution, record] if solution == last else 0.0
                if endless[outer]:
                    step[outer] += further
                too_far = max(abs(step[outer] - further), abs(step[7 - outer])) > HALF_TURN
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


def loop(moves):
    """`best_way` as it suits so many moves."""
    return compiled(best_way, within_travel, nearest, cost) if moves > LONG else best_way


@cache
def compiled(loop, *helpers):
    """A loop that calls `helpers` as machine code, kept if there is a folder for it; as it stands without Numba."""
    try:
        from numba import njit
        from numba.extending import register_jitable
    except ImportError:
        return loop
    for function in helpers:
        register_jitable(function)
    try:
        return njit(cache=True, error_model="numpy")(loop)
    except RuntimeError:  # neither here nor in the home folder
        return njit(error_model="numpy")(loop)
