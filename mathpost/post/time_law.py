"""The time law of a joint path: when each pose is reached, under the rates and the accelerations of the axes.

Every move is *asked* to take the time that its feed or its slowest axis needs. The *override* w is the part of that
speed at which it is really run, 0 to 1; from rest to rest, and never faster than the axes can follow.
"""

from dataclasses import dataclass

import numpy as np

from mathpost.post.travel import compiled

SETTLE = 0.02  # s, assumed: how long an axis may take to follow when its speed jumps at a corner
STILL = 1e-12  # mm/s or rad/s
ROUNDING = 1e-12  # of w²: what changes less stays the same
LONG = 10_000  # moves; with more of them it pays to load Numba


@dataclass(frozen=True)
class TimeLaw:
    """When a machine reaches the poses of a path, and how.

    Attributes
    ----------
    joints, seconds, override : ndarray, shape (m, 5), (m,) and (m,)
        mm and radians, when each pose is reached, and the w at which it is passed.
    asked, ramp, highest : ndarray, shape (m - 1,)
        Of each move: the seconds that it would take at w = 1; how fast w changes, 1/s, up and down again (∞: at
        once); and its greatest w, between.
    peak_speeds, peak_accelerations, peak_jumps : ndarray, shape (5,)
        Of each axis, mm or radians per s and s²; NaN the acceleration of one that states none. The jumps are those
        of the speed at single corners.
    """

    joints: np.ndarray
    seconds: np.ndarray
    override: np.ndarray
    asked: np.ndarray
    ramp: np.ndarray
    highest: np.ndarray
    peak_speeds: np.ndarray
    peak_accelerations: np.ndarray
    peak_jumps: np.ndarray

    def at(self, seconds):
        """Return the joints, shape (..., 5), at times from 0 to ``seconds[-1]``."""
        seconds = np.clip(seconds, 0, self.seconds[-1])
        move = np.clip(np.searchsorted(self.seconds, seconds, side="right") - 1, 0, len(self.asked) - 1)
        since, left = seconds - self.seconds[move], self.seconds[move + 1] - seconds
        first, last = self.override[move], self.override[move + 1]
        ramp, highest, asked = self.ramp[move], self.highest[move], self.asked[move]
        up, down = (highest - first) / ramp, (highest - last) / ramp
        rising = first * since + np.where(since < up, ramp, 0) * since**2 / 2
        falling = asked - last * left - np.where(left < down, ramp, 0) * left**2 / 2
        even = (first + highest) / 2 * up + highest * (since - up)
        done = np.where(since < up, rising, np.where(left < down, falling, even)) / asked
        return self.joints[move] + done[..., None] * (self.joints[move + 1] - self.joints[move])


def time_law(machine, joints, asked, *, settle=SETTLE):
    """Return the `TimeLaw` of a path.

    From one move to the next the speed of an axis jumps, at most by what its acceleration makes of it in the time
    `settle`. Poses that follow closer than that are a curve: there the jumps, spread over the moves, are
    acceleration, and take their part of it.

    Parameters
    ----------
    machine : Machine
        An axis that states no acceleration follows at once.
    joints : array_like, shape (m, 5)
        mm and radians; all joints run linearly from each row to the next.
    asked : array_like, shape (m - 1,)
        Seconds that feed and rates ask for each move, from `mathpost.post.motion.block_times`. One that takes no
        time is passed over.
    settle : float
        Seconds.

    Examples
    --------
    Half a turn of C at 36°/s, with 200°/s² to speed up and to slow down: 180/36 + 36/200 seconds.

    >>> from mathpost import machine
    >>> dmu50v = machine.load("data/machines/dmu50v.toml")
    >>> law = time_law(dmu50v, [[0, 0, 0, 0, 0], [0, 0, 0, 0, np.pi]], [5.0])
    >>> law.seconds
    array([0.  , 5.18])
    """
    joints, asked = np.asarray(joints, dtype=float), np.asarray(asked, dtype=float)
    moving = asked > 0
    kept = np.r_[True, moving]
    lengths, most = asked[moving], np.nan_to_num(machine.max_accelerations, nan=np.inf)
    pause = (lengths[1:] + lengths[:-1]) / 2  # from the middle of a move to that of the next
    corner, needed = pause >= settle, np.zeros(max(len(lengths) - 1, 0))
    speed = np.zeros((5, len(lengths)))  # of each axis at w = 1
    bend = np.zeros((5, len(lengths) + 1))  # its acceleration at a pose that is passed at w = 1
    jumps = []  # of its speed at the corners
    for axis, column in enumerate(joints.T):
        velocity = np.diff(column)[moving] / lengths
        jump = np.abs(np.diff(velocity))
        speed[axis] = np.abs(velocity)
        np.divide(jump, pause, out=bend[axis, 1:-1], where=~corner)
        needed = np.maximum(needed, jump / most[axis])  # seconds, in which all axes can take their jumps
        jumps.append(jump[corner])

    squares = np.zeros(len(lengths) + 1)
    with np.errstate(divide="ignore"):
        limits = np.minimum(np.where(corner, np.inf, pause / needed), (settle / needed) ** 2)
        squares[1:-1] = np.minimum(limits, 1)
    if np.isfinite(most).any():
        climb = compiled(climbed) if len(lengths) > LONG else climbed
        squares = climb(squares, lengths, speed, bend, most)
        squares = climb(squares[::-1], lengths[::-1], speed[:, ::-1], bend[:, ::-1], most)[::-1]

    def used(bend):
        return np.maximum(bend[:-1] * squares[:-1], bend[1:] * squares[1:])

    left = np.full(len(lengths), np.inf)
    for v, bent, limit in zip(speed, bend, most, strict=True):
        left = np.minimum(left, np.where(v > STILL, (limit - used(bent)) / np.maximum(v, STILL), np.inf))
    ramp = np.maximum(left, np.abs(np.diff(squares)) / (2 * lengths))
    override = np.sqrt(squares)
    highest = np.minimum(1, np.sqrt((squares[1:] + squares[:-1]) / 2 + ramp * lengths))
    ramp[ramp * lengths <= ROUNDING * highest**2] = np.inf  # or what rounding leaves of a ramp would take time
    seconds = np.zeros(len(asked))
    seconds[moving] = _durations(override, lengths, ramp, highest)
    changes = (highest > override[:-1]) | (highest > override[1:])
    pull = np.where(changes & np.isfinite(ramp), ramp, 0)
    peaks = [
        [(v * highest).max(initial=0) for v in speed],
        [(v * pull + used(bent)).max(initial=0) for v, bent in zip(speed, bend, strict=True)],
        [(jump * override[1:-1][corner]).max(initial=0) for jump in jumps],
    ]
    peaks[1] = np.where(np.isfinite(most), peaks[1], np.nan)
    seconds = np.r_[0.0, np.cumsum(seconds)][kept]
    return TimeLaw(joints[kept], seconds, override, lengths, ramp, highest, *map(np.array, peaks))


def climbed(squares, lengths, speed, bend, most):
    """The squares of w at the poses, so far lowered that every axis can follow where w rises from pose to pose.

    What the bend at either end of a move takes of the acceleration of an axis is not left for the rise.
    """
    squares = squares.copy()
    for move in range(len(lengths)):
        length, square, rise = lengths[move], squares[move], np.inf
        for axis in range(len(most)):
            v, here, there = speed[axis, move], bend[axis, move], bend[axis, move + 1]
            if v > STILL:
                rise = min(rise, (most[axis] - here * square) / v)
                rise = min(rise, (most[axis] - there * square) / (v + 2 * length * there))
        squares[move + 1] = min(squares[move + 1], square + 2 * length * max(rise, 0.0))
    return squares


def _durations(override, lengths, ramp, highest):
    """Seconds of each move: up to the highest w, on at it, down again."""
    up, down = highest - override[:-1], highest - override[1:]
    on_ramps = (up * (highest + override[:-1]) + down * (highest + override[1:])) / (2 * ramp)
    return (up + down) / ramp + np.maximum(lengths - on_ramps, 0) / highest


def slow_down(record, seconds, asked):
    """Return the record that costs the tip the most time above what its feed asks: record, asked, taken seconds.

    All three are arrays, shape (m,), for the moves: the record that each leads to, the seconds that it takes, and
    those that its feed asks. Where these are NaN no feed is asked for; if it is nowhere, the answer is None.
    """
    fed = np.flatnonzero(~np.isnan(asked))
    if not fed.size:
        return None
    taken, wanted = (np.bincount(np.asarray(record)[fed], np.asarray(values)[fed]) for values in (seconds, asked))
    worst = int((taken - wanted).argmax())
    return worst, float(wanted[worst]), float(taken[worst])
