"""Between two blocks: poses enough to keep both tolerances, and when the machine is at each.

A control without TCP moves all five joints linearly from block to block: tip and tool axis leave the CL path. First
`follow` puts poses on the great circle of the tool axis. Then linearization (线性化) divides a move in the
*workpiece*: tip on the CL segment, rotary angles in equal steps, X Y Z recomputed.

By the *time law* every move is *asked* to take the time that its feed or its slowest axis needs. The *override* w
is the part of that speed at which it is really run, 0 to 1, from rest to rest, so that every axis can follow.
"""

import math
from dataclasses import dataclass

import numpy as np

from mathpost.errors import ReachError
from mathpost.formula import compiled
from mathpost.machine import UNITS
from mathpost.path.cl import feed_times
from mathpost.post import singular
from mathpost.post.proof import AXIS_RESOLUTION, derivative, peak, sampled, stray
from mathpost.post.selection import nearest

LOST = 1 / 8  # of the axis tolerance: a move that spans less and strays more does not go along its great circle
AIR = 0.1  # of the clearance, how far a lifted tip may stray
SETTLE = 0.02  # s, assumed: how long an axis may take to follow when its speed jumps at a corner
STILL = 1e-12  # mm/s or rad/s
ROUNDING = 1e-12  # of w²: what changes less stays the same
LONG = 10_000  # moves; with more of them it pays to load Numba


@dataclass(frozen=True)
class Motion:
    """The m poses that the machine runs through, all joints linearly from each to the next."""

    joints: np.ndarray  # shape (m, 5), mm and radians
    place: np.ndarray  # shape (m,), where on the CL path: 2.25 is a quarter of the way from record 2 to record 3
    lifted: np.ndarray  # shape (m,), whether the pose is off the part, retracted along the tool axis

    @classmethod
    def on_part(cls, joints, place):
        """Poses none of which is lifted."""
        return cls(joints, np.asarray(place, dtype=float), np.zeros(len(joints), bool))

    @classmethod
    def joined(cls, parts):
        """One motion after the other."""
        return Motion(*(np.concatenate([getattr(part, name) for part in parts]) for name in cls.__annotations__))

    def __getitem__(self, rows):
        """The same of some poses: a slice or an index array."""
        return Motion(self.joints[rows], self.place[rows], self.lifted[rows])

    @property
    def record(self):
        """The record that each pose is at or leads to, shape (m,)."""
        return np.ceil(self.place).astype(int)

    @property
    def in_cut(self):
        """Whether each move is in cut, both ends on the part, shape (m - 1,)."""
        return ~(self.lifted[:-1] | self.lifted[1:])

    def at_feed(self, cl):
        """Whether each move is in cut and not rapid, so that its tool axis counts, shape (m - 1,)."""
        return self.in_cut & ~cl.rapid[self.record[1:]]


def axis_lag(kin, cl, start, end, place, place_after):
    """How far the tool axis is at most, radians, from where `cl` has it at the same part of each move."""
    error = np.zeros(len(start))
    for moves, t, _, axis in sampled(kin, start, end):
        _, wanted = cl.at(place[moves] + t * (place_after - place)[moves])
        error[moves] = 2 * np.arcsin(np.minimum(peak(np.linalg.norm(axis - wanted, axis=-1)) / 2, 1))
    return error + AXIS_RESOLUTION


def follow(kin, cl, motion, tolerance, *, free=False):
    """Divide every move in cut that is not `free` until the tool axis keeps `tolerance` of its great circle.

    Moves are halved on the great circle. Where it meets a singular tool axis there is a pose just before and one
    just after it: the outer axis turns while the tool axis all but stands still. `ReachError` if the joints do not
    go along the great circle, as where they change the branch.
    """
    joints, place, lifted = motion.joints, motion.place, motion.lifted
    # An axis turned by Ω leaves its chord by at most Ω²/8, and so does the great circle: few need a closer look.
    turned = np.abs(np.diff(joints[:, 3:], axis=0)).sum(axis=1)
    todo = motion.at_feed(cl) & ~np.asarray(free) & (turned**2 / 4 > tolerance)
    while True:
        moves = np.flatnonzero(todo)
        error = np.zeros(len(todo))
        error[moves] = axis_lag(kin, cl, joints[moves], joints[moves + 1], place[moves], place[moves + 1])
        todo = error > tolerance
        if not todo.any():
            return Motion(joints, place, lifted)
        moves = np.flatnonzero(todo)
        start, end = (cl.at(place[at])[1] for at in (moves, moves + 1))
        lost = moves[np.linalg.norm(end - start, axis=1) < LOST * tolerance]
        if lost.size:
            strayed, most = np.degrees([error[lost[0]], tolerance])
            where = f"{cl.where(place[lost[0] + 1])}: on its way there the tool axis strays"
            far = f"{strayed:.3f}° from its great circle, more than {most:.2g}°"
            raise ReachError(f"{where} {far}, however often the move is divided")
        of, at, beside = _cuts(kin, joints[moves], joints[moves + 1], start, end, singular.STILL * tolerance)
        of, at = moves[of], place[moves[of]] + at * np.diff(place)[moves[of]]
        joints = np.insert(joints, of + 1, _pose(kin, cl, at, beside), axis=0)
        place, lifted = np.insert(place, of + 1, at), np.insert(lifted, of + 1, False)
        todo = np.insert(todo, of, True)


def _cuts(kin, start, end, start_axis, end_axis, still):
    """Of which move each cut is, at which part of it, and the joints to go on from: those of an end, or of both."""
    t, distance = singular.nearest(kin, start_axis, end_axis)
    aside = 2 * still / np.maximum(np.linalg.norm(end_axis - start_axis, axis=1), 1e-300)
    meets = distance < still
    part = np.where(meets, [t - aside, t + aside], 0.5)
    beside = np.where(meets[:, None], [start, end], (start + end) / 2)
    move, side = np.nonzero(((part > 0) & (part < 1) & [np.ones_like(meets), meets]).T)
    return move, part[side, move], beside[side, move]


def _pose(kin, cl, place, beside):
    """Joints on the CL path, on the branch and in the windings of those beside them."""
    second = np.sin(beside[:, kin.inner] - float(sum(kin.inverse_symbolic.solutions) / 2)) < 0
    joints = kin.inverse(*cl.at(place))[np.arange(len(place)), second.astype(int)]
    if (lost := np.isnan(joints).any(axis=1)).any():
        raise ReachError(f"{cl.where(place[lost.argmax()])}: on its way there the tool axis is out of reach")
    joints[:, 3:] = beside[:, 3:] + nearest(joints[:, 3:] - beside[:, 3:])
    return joints


def subdivide(kin, start, end, pieces):
    """Divide moves evenly: tip on the segment, rotary angles in equal steps, X Y Z recomputed.

    `start` and `end`, shape (m, 5), are the joints at both ends, mm and radians; `pieces` one number or m. Returns
    the joints (k, 5) at the end of every piece, and its place (k,): 2.25 is a quarter of the third move.
    """
    pieces = np.broadcast_to(pieces, len(start))
    move = np.repeat(np.arange(len(start)), pieces)
    piece = np.arange(1, len(move) + 1) - np.repeat(np.cumsum(pieces) - pieces, pieces)
    t, joints = piece / pieces[move], end[move]
    inner = np.flatnonzero(t < 1)
    of, part = move[inner], t[inner, None]
    first, last = kin.forward(start[of])[0], kin.forward(end[of])[0]
    joints[inner] = kin.close(first + part * (last - first), start[of, 3:] + part * (end - start)[of, 3:])
    return joints, move + t


def linearize(kin, motion, tolerance, *, max_pieces=4096, name="block"):
    """Divide every move until the tip stays within `tolerance` of the straight segment between its ends.

    `motion` is a `Motion`, or its joints alone, shape (n, 5), mm and radians, at the places 0, 1, 2 …; `tolerance`,
    mm, is that of all moves or of each. Returns a `Motion`; `ReachError` if `max_pieces` of one `name` do not do.
    """
    if not isinstance(motion, Motion):
        motion = Motion.on_part(np.asarray(motion, dtype=float), np.arange(len(motion)))
    start, end = motion.joints[:-1], motion.joints[1:]
    tolerance, pieces = np.broadcast_to(tolerance, len(start)), np.ones(len(start), dtype=int)
    # A curve leaves its chord by at most an eighth of its second derivative: most moves need no closer look.
    rest = np.flatnonzero(derivative(kin.machine, start, end, 2) / 8 > tolerance)
    while rest.size:
        ends, _ = subdivide(kin, start[rest], end[rest], pieces[rest])
        firsts = np.cumsum(pieces[rest]) - pieces[rest]
        starts = np.roll(ends, 1, axis=0)
        starts[firsts] = start[rest]
        error = np.maximum.reduceat(stray(0, kin, starts, ends), firsts)
        over = error > tolerance[rest]
        rest, error = rest[over], error[over]
        # The error falls with the square of the number of pieces.
        wanted = np.ceil(pieces[rest] * np.sqrt(error / tolerance[rest])).astype(int)
        pieces[rest] = np.maximum(pieces[rest] + 1, wanted)
        if pieces.max() > max_pieces:
            move = int(pieces.argmax())
            strayed = f"the tip strays {error[rest == move][0]:.6f} mm, more than {tolerance[move]:g} mm"
            raise ReachError(
                f"from {name} {move + 1} to {move + 2}: {strayed}, and {max_pieces} pieces are not enough"
            )
    if (pieces == 1).all():
        return motion
    joints, at = subdivide(kin, start, end, pieces)
    joints, at = np.concatenate([motion.joints[:1], joints]), np.r_[0.0, at]
    place = np.interp(at, np.arange(len(motion.place)), motion.place)
    lifted = motion.lifted[np.floor(at).astype(int)] | motion.lifted[np.ceil(at).astype(int)]
    return Motion(joints, place, lifted)


def in_the_air(motion, tolerance, clearance):
    """The tolerance of the tip (mm) for each move, more for those that are lifted."""
    return np.where(motion.in_cut, tolerance, np.maximum(tolerance, AIR * clearance))


@dataclass(frozen=True)
class TimeLaw:
    """When a machine reaches the m poses of a path, and how."""

    joints: np.ndarray  # shape (m, 5), mm and radians
    seconds: np.ndarray  # shape (m,), when each pose is reached,
    override: np.ndarray  # and the w at which it is passed
    asked: np.ndarray  # shape (m - 1,), seconds that each move would take at w = 1
    ramp: np.ndarray  # how fast w changes in it, 1/s, up and down again (∞: at once)
    highest: np.ndarray  # and its greatest w, between
    peaks: np.ndarray  # shape (2, 5), of each axis: speed, mm or radians per s, and acceleration, NaN without limit

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
    """Return the `TimeLaw` of a path whose joints (m, 5), mm and radians, run linearly from each row to the next.

    `asked`, shape (m - 1,), are the seconds that feed and rates ask for each move, as `block_times` has them; one
    that takes no time is passed over. An axis that states no acceleration follows at once. From one move to the
    next the speed of an axis jumps, at most by what its acceleration makes of it in the time `settle`, seconds.
    Poses that follow closer than that are a curve: there the jumps, spread over the moves, take their part of the
    acceleration.

    Examples
    --------
    Half a turn of C at 36°/s, with 200°/s² to speed up and to slow down: 180/36 + 36/200 seconds.

    >>> import mathpost
    >>> half_a_turn = [[0, 0, 0, 0, 0], [0, 0, 0, 0, np.pi]]
    >>> time_law(mathpost.load_machine("dmu50v"), half_a_turn, [5.0]).seconds
    array([0.  , 5.18])
    """
    joints, asked = np.asarray(joints, dtype=float), np.asarray(asked, dtype=float)
    moving = np.flatnonzero(asked > 0)
    lengths, most = asked[moving], np.nan_to_num(machine.max_accelerations, nan=np.inf)
    speed, bend, squares = corners(joints, moving, lengths, most, settle)
    rise, drive = (compiled(loop) if len(lengths) > LONG else loop for loop in (climbed, driven))
    if np.isfinite(most).any():
        squares = rise(squares, lengths, speed, bend, most)
        squares = rise(squares[::-1], lengths[::-1], speed[:, ::-1], bend[:, ::-1], most)[::-1]
    ramp, highest, durations, peaks = drive(squares, lengths, speed, bend, most)
    peaks[1, np.isinf(most)] = np.nan
    seconds = np.r_[0.0, np.cumsum(durations)]
    if len(moving) < len(asked):
        joints = joints[np.r_[0, moving + 1]]
    return TimeLaw(joints, seconds, np.sqrt(squares), lengths, ramp, highest, peaks)


def block_times(machine, joints, tip, feeds, in_cut):
    """Times (s) that the moves between joints (m, 5) take: what the feed asks in cut, or the slowest axis needs.

    Tips are (m, 3), `feeds` and whether a move is `in_cut` (m - 1,). On a machine that states no rates, no axis
    goes faster than the feed, in mm and degrees per minute; zero where there is no feed either.
    """
    rates, by_axis = machine.max_rates, np.zeros(len(joints) - 1)
    if no_rates := np.isnan(rates).all():
        rates = 1 / UNITS
    for column, rate in zip(joints.T, rates, strict=True):
        by_axis = np.fmax(by_axis, np.abs(np.diff(column)) / rate)
    if no_rates:
        by_axis = np.nan_to_num(60 * by_axis / feeds)
    return np.fmax(by_axis, np.where(in_cut, feed_times(tip, feeds), 0))


def corners(joints, moving, lengths, most, settle):
    """The speed of each axis at w = 1, what a bend takes of its acceleration at each pose, and the squares of w."""
    moves = len(lengths)
    speed, bend, squares = np.empty((len(most), moves)), np.zeros((len(most), moves + 1)), np.zeros(moves + 1)
    between = (lengths[1:] + lengths[:-1]) / 2
    pause, needed = np.where(between < settle, between, np.inf), np.zeros(len(between))
    for axis, column in enumerate(joints.T):
        velocity = (column[moving + 1] - column[moving]) / lengths
        jumps = np.abs(np.diff(velocity))
        speed[axis], bend[axis, 1:-1] = np.abs(velocity), jumps / pause
        np.maximum(needed, jumps / most[axis], out=needed)  # seconds, in which all axes can take their jumps
    with np.errstate(divide="ignore"):
        squares[1:-1] = np.minimum(1.0, np.minimum(pause / needed, (settle / needed) ** 2))
    return speed, bend, squares


# The loops run as they stand, or as machine code if Numba compiles them.


def climbed(squares, lengths, speed, bend, most):
    """The squares of w at the poses, so far lowered that every axis can follow where w rises from pose to pose."""
    squares = squares.copy()
    for move in range(len(lengths)):
        length, square, rise = lengths[move], squares[move], np.inf
        for axis in range(len(most)):
            v, there = speed[axis, move], bend[axis, move + 1]
            if v > STILL:
                rise = min(rise, (most[axis] - bend[axis, move] * square) / v)
                rise = min(rise, (most[axis] - there * square) / (v + 2 * length * there))
        squares[move + 1] = min(squares[move + 1], square + 2 * length * max(rise, 0.0))
    return squares


def driven(squares, lengths, speed, bend, most):
    """Ramp, highest w and seconds of each move: up to the highest w, on at it, down again; peaks, shape (2, 5)."""
    moves, axes = len(lengths), len(most)
    ramp, highest, seconds, peaks = np.zeros(moves), np.zeros(moves), np.zeros(moves), np.zeros((2, axes))
    used = np.zeros(axes)  # what the bends use of the acceleration
    for move in range(moves):
        length, before, after, pull = lengths[move], squares[move], squares[move + 1], np.inf
        for axis in range(axes):
            used[axis] = max(bend[axis, move] * before, bend[axis, move + 1] * after)
            if speed[axis, move] > STILL:
                pull = min(pull, (most[axis] - used[axis]) / speed[axis, move])
        pull = max(pull, abs(after - before) / (2 * length))
        first, last, top = math.sqrt(before), math.sqrt(after), (before + after) / 2 + pull * length
        top = math.sqrt(min(top, 1.0))
        if pull * length <= ROUNDING * top**2:  # or what rounding leaves of a ramp would take time
            pull = np.inf
        up, down = top - first, top - last
        on_ramps = (up * (top + first) + down * (top + last)) / (2 * pull)
        seconds[move] = (up + down) / pull + max(length - on_ramps, 0.0) / top
        ramp[move], highest[move] = pull, top
        for axis in range(axes):
            v, pulled = speed[axis, move], used[axis]
            if max(up, down) > 0 and pull < np.inf:
                pulled += v * pull
            peaks[0, axis], peaks[1, axis] = max(peaks[0, axis], v * top), max(peaks[1, axis], pulled)
    return ramp, highest, seconds, peaks


def slow_down(record, seconds, asked):
    """Return the record that costs the tip most time above what its feed asks, with seconds asked and taken.

    Of each move `record` is the one that it leads to, `seconds` what it takes, `asked` what its feed asks, or NaN.
    """
    record, seconds, asked = np.asarray(record), np.asarray(seconds), np.asarray(asked)
    fed = ~np.isnan(asked)
    if not fed.any():
        return None
    taken, wanted = (np.bincount(record[fed], values[fed]) for values in (seconds, asked))
    worst = int((taken - wanted).argmax())
    return worst, float(wanted[worst]), float(taken[worst])
