"""What a move costs, which moves can be made in cut, and what is within travel."""

import numpy as np

TURN = 2 * np.pi
HALF_TURN = np.pi + 1e-9  # a rotary step beyond this means that travel has cut off the short way round
SWAY = np.radians(5.0)  # how far the tool axis may stray between two records in cut, besides half of its own turn
TRAVEL_TOLERANCE = 1e-9  # mm and radians
PER_RADIAN = np.degrees(1.0)  # in weighted travel a degree counts as much as a millimetre
TIE = 1e-9  # weight of travel (mm and degrees) among choices that take the same time


def move_costs(machine, steps, weights=None, *, tie=0.0):
    """Return what moves by the joint steps `steps`, shape (..., 5) in mm and radians, cost.

    The time that the slowest axis needs, in seconds, over the axes whose rate the machine states; where it states
    none, or where `weights` (5 numbers, per mm and per degree) are given, the weighted sum of travel. `tie` times
    the travel in mm and degrees is added, to tell equal costs apart.
    """
    rates, costs, travel = machine.max_rates, 0.0, 0.0
    if weights is None and np.isnan(rates).all():
        weights = np.ones(5)
    for joint in range(5):  # one by one, which is fast in whatever order they lie in memory
        way = np.abs(steps[..., joint])
        if weights is None and not np.isnan(rates[joint]):
            costs = np.maximum(costs, way * (1 / rates[joint]))
        if joint > 2 and (tie or weights is not None):
            way = way * PER_RADIAN
        if weights is not None:
            costs = costs + weights[joint] * way
        if tie:
            travel = travel + way
    return costs + tie * travel if tie else costs


def short_way(machine, steps):
    """Return joint steps, shape (..., 5), with those of endless axes brought into [−180°, 180°]."""
    return shortened(machine, np.array(steps, dtype=float))


def shortened(machine, steps):
    """Do what `short_way` does to the array `steps` itself, and return it."""
    for joint in endless(machine):
        steps[..., joint] -= TURN * np.rint(steps[..., joint] / TURN)
    return steps


def endless(machine):
    """Return the numbers of the rotary joints that have no end of travel."""
    return [joint for joint in (3, 4) if not np.isfinite(machine.limits[joint]).all()]


def count_windings(machine, joints, before, turns):
    """Unwrap the endless axes of `joints` (n, 5) itself, after joints `before` that stand `turns` turns further.

    Returns the turns, shape (5,), at the last record. They are counted as whole numbers, which do not drift.
    """
    turns = turns.copy()
    for joint in endless(machine):
        counted = turns[joint] - np.cumsum(np.rint(np.diff(joints[:, joint], prepend=before[joint]) / TURN))
        joints[:, joint] += TURN * counted
        turns[joint] = counted[-1]
    return turns


def path_cost(machine, joints, weights=None, start=None):
    """Return what a sequence of joints, shape (n, 5), costs, the way from `start` to its first row included."""
    cost = float(np.sum(move_costs(machine, np.diff(joints, axis=0), weights)))
    if start is not None and len(joints):
        cost += float(move_costs(machine, short_way(machine, joints[0] - np.asarray(start, dtype=float)), weights))
    return cost


def breaks_off(kin, joints, steps, axes, rapid, sway):
    """Return which moves along a path cannot be made in cut, shape (n,).

    That is so if a rotary axis turns by more than half a turn, which no path asks for, or if the tool axis sways
    off its great circle, as it does where the branch changes away from the pole.

    Parameters
    ----------
    kin : Kinematics
    joints, steps : ndarrays, shape (n, 5)
        Where the moves start and what they move by.
    axes : ndarray, shape (n + 1, 3)
        Unit tool axes there, and where the last move goes.
    rapid : ndarray of bool, shape (n,)
        A move in rapid traverse can always be made.
    sway : float
        See `sways_off`.
    """
    over, doubtful = turns_over(steps, sway)
    over[doubtful] = sways_off(kin, joints, steps, axes, sway, doubtful)
    return over & ~rapid


def turns_over(steps, sway):
    """Return which joint steps (..., 5) turn an axis by more than half a turn, and which others may sway off."""
    first, second = np.abs(steps[..., 3]), np.abs(steps[..., 4])
    over = np.maximum(first, second) > HALF_TURN
    return over, (first + second > sway) & ~over


def sways_off(kin, start, steps, axes, sway, which):
    """Return whether the tool axis sways off its great circle on some moves. What it does half way tells.

    Parameters
    ----------
    kin : Kinematics
    start, steps : ndarrays, broadcasting to shape (..., n, 5)
        Joints at the n records that the moves start from, and what they move by.
    axes : ndarray, shape (n + 1, 3)
        Unit tool axes of these records and of the last one that a move goes to.
    sway : float
        Radians allowed besides half of the turn of the tool axis.
    which : ndarray of bool, shape (..., n)
        The moves that are asked for, k of them.

    Returns
    -------
    ndarray of bool, shape (k,)
    """
    record = np.nonzero(which)[-1]
    half_way = np.zeros((5, len(record)))  # X Y Z do not matter to the tool axis
    for joint in (3, 4):
        half_way[joint] = np.broadcast_to(start[..., joint], which.shape)[which] + steps[..., joint][which] / 2
    before, after = axes[record], axes[record + 1]
    sway_off = np.linalg.norm(kin.forward(half_way.T)[1] - (before + after) / 2, axis=1)
    return sway_off > sway + np.linalg.norm(after - before, axis=1) / 2


def within_travel(machine, joint, values):
    """Return whether values of one joint, numbered from 0, are inside its travel; NaN is not in any that ends."""
    low, high = machine.limits[joint]
    inside = values >= low - TRAVEL_TOLERANCE if np.isfinite(low) else np.ones(values.shape, dtype=bool)
    return inside & (values <= high + TRAVEL_TOLERANCE) if np.isfinite(high) else inside


def out_of_travel(machine, joints):
    """Sentences on the joints, shape (5,), that are outside travel."""
    units = ("mm", "mm", "mm", "°", "°")
    scale = np.array([1, 1, 1, PER_RADIAN, PER_RADIAN])
    sentences = []
    for name, value, (low, high), letter in zip(
        machine.joint_names, joints * scale, machine.limits * scale[:, None], units, strict=True
    ):
        if not low - TRAVEL_TOLERANCE <= value <= high + TRAVEL_TOLERANCE:
            sentences.append(f"{name} {value:.3f}{letter} is outside {low:g} … {high:g}")
    return sentences
