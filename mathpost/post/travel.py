"""Travel and moves: what is inside travel, the short way round, and what a move costs.

`within_travel`, `nearest` and `cost` take numbers as well as arrays, so that the loop of `selection` and everything
that works on whole paths share them.
"""

import numpy as np

TURN = 2 * np.pi
TRAVEL_TOLERANCE = 1e-9  # mm and radians
UNITS = np.array([1, 1, 1, np.degrees(1), np.degrees(1)])  # mm and degrees of one mm or radian of each joint


def within_travel(value, low, high):
    """Return whether joint values are inside their travel, ends included; NaN is not.

    Examples
    --------
    >>> within_travel(np.array([-1.0, 0.0, np.nan]), 0.0, np.inf)
    array([False,  True, False])
    """
    return (low - TRAVEL_TOLERANCE <= value) & (value <= high + TRAVEL_TOLERANCE)


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


def cost(steps, price, slowest):
    """Return what moves cost whose joint steps are `steps[0]` … `steps[4]`, by `rates_or_weights`."""
    total = 0.0
    for joint in range(5):
        part = np.abs(steps[joint]) * price[joint]
        total = np.maximum(total, part) if slowest else total + part
    return total


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
