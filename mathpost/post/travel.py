"""Travel and moves: what is inside travel, the short way round, and what a move costs.

The elementary functions stand in `bellman`; these take a machine and whole paths.
"""

from dataclasses import replace

import numpy as np

from mathpost.machine import ENDLESS
from mathpost.post.bellman import TURN, UNITS, cost, nearest, within_travel

MANY = 10  # turns of travel


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

    An endless axis has one winding here: its turns are counted when the path is known, by `count_turns`.

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


def count_turns(machine, joints, start):
    """Return the path of joints (n, 5) with endless axes that go on from `start` (5,) and turn the short way."""
    counted, around = joints.copy(), endless(machine)
    steps = np.diff(joints[:, around], axis=0, prepend=start[None, around])
    counted[:, around] -= TURN * np.cumsum(np.rint(steps / TURN), axis=0)
    return counted


def rates_or_weights(machine, weights=None):
    """Return what a mm or radian of each joint costs, shape (5,), and whether only the slowest joint counts.

    It is what `move_costs` counts by.
    """
    rates = machine.max_rates
    if weights is None and not np.isnan(rates).all():
        return np.nan_to_num(1 / rates), True
    return UNITS * (1.0 if weights is None else np.asarray(weights, dtype=float)), False


def move_costs(machine, steps, weights=None):
    """Return what moves by the joint steps `steps`, shape (..., 5) in mm and radians, cost.

    Parameters
    ----------
    machine : Machine
    steps : array_like, shape (..., 5)
    weights : array_like, shape (5,), optional
        Cost of travel per mm and per degree, to add up. Without it the cost is the time in seconds that the slowest
        axis needs, over the axes whose rate the machine states, or if it states none the sum of mm and degrees.

    Returns
    -------
    ndarray, shape (...)

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
    total = float(np.sum(move_costs(machine, np.diff(joints, axis=0), weights)))
    if start is not None and len(joints):
        total += float(move_costs(machine, short_way(machine, joints[0] - start), weights))
    return total
