"""When a machine is at each pose of its path.

By the *time law* every move is *asked* to take the time that its feed or its slowest axis needs. The *override* w
is the part of that speed at which it is really run, 0 to 1, from rest to rest, so that every axis can follow.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike

from mathpost.formula import compiled, slices
from mathpost.kinematics import Kinematics
from mathpost.machine import Linear, Machine, Rotary
from mathpost.path.cl import feed_times
from mathpost.shop.controls.blocks import Blocks
from mathpost.shop.controls.control import Control
from mathpost.shop.post.proof import joints_of

SETTLE = 0.02  # s, assumed: how long an axis may take to follow when its speed jumps at a corner
AT_ONCE = 1e-9  # s, instead of it where the path has to be exact
SLIGHT = 1e-3  # radians, a corner that is none
STILL = 1e-12  # mm/s or rad/s
ROUNDING = 1e-12  # of w²: what changes less stays the same
TCP_PARTS = 16  # of a move with TCP, that are looked at for the fastest of each axis
LONG = 6_000  # moves; with more of them it pays to load Numba
SlowDown = tuple[int, float, float]  # a record, from 0, and the seconds before it that are asked, and taken
Joint = TypeVar("Joint", Linear, Rotary)


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

    def at(self, seconds: ArrayLike) -> np.ndarray:
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


def time_law(
    machine: Machine, joints: ArrayLike, asked: ArrayLike, *, settle: float = SETTLE,
    halts: np.ndarray | None = None, smooth: np.ndarray | None = None,
) -> TimeLaw:  # fmt: skip
    """Return the `TimeLaw` of a path whose joints (m, 5), mm and radians, run linearly from each row to the next.

    `asked`, shape (m - 1,), is the time of each move in seconds by feed and rates, as `block_times` returns it; a
    move that takes no time is skipped. An axis that states no acceleration reaches its speed at once. From one move
    to the next the speed of an axis may jump by as much as its acceleration would change it in `settle` seconds.
    Poses closer in time than that form a curve: there the jumps, spread over the moves, use up part of the
    acceleration.

    `halts`, shape (m,), says at which poses the machine stops, `smooth` which lie within an arc and are no corners.

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
    limited, count = np.isfinite(most).any(), len(moving)
    settling = np.full(count + 1, float(settle))
    if smooth is not None:
        settling[1:-1][np.asarray(smooth)[moving[1:]]] = SETTLE
    if halts is not None:
        settling[np.asarray(halts)[np.r_[0, moving + 1]]] = 0
    rise = compiled(climbed) if count > LONG else climbed
    drive = compiled(driven) if count > LONG else driven
    squares, (ramp, highest, durations), peaks = np.zeros(count + 1), np.empty((3, count)), np.zeros((2, len(most)))
    parts = list(slices(moving.shape))  # the corners of all moves would take more memory than the path
    for moves in parts:
        poses = slice(moves.start, moves.stop + 1)
        speed, bend, square = corners(joints, moving, lengths, most, settling, moves)
        square[0] = squares[moves.start]
        squares[poses] = rise(square, lengths[moves], speed, bend, most) if limited else square
    for moves in reversed(parts):
        poses = slice(moves.start, moves.stop + 1)
        speed, bend, _ = corners(joints, moving, lengths, most, settling, moves)
        if limited:
            square, length = squares[poses][::-1].copy(), lengths[moves][::-1].copy()
            squares[poses] = rise(square, length, speed[:, ::-1].copy(), bend[:, ::-1].copy(), most)[::-1]
        ramp[moves], highest[moves], durations[moves], most_of = drive(
            squares[poses], lengths[moves], speed, bend, most
        )
        peaks = np.maximum(peaks, most_of)
    peaks[1, np.isinf(most)] = np.nan
    seconds = np.zeros(count + 1)
    np.cumsum(durations, out=seconds[1:])
    if len(moving) < len(asked):
        joints = joints[np.r_[0, moving + 1]]
    return TimeLaw(joints, seconds, np.sqrt(squares, out=squares), lengths, ramp, highest, peaks)


def block_times(
    machine: Machine, joints: np.ndarray, tip: np.ndarray, feeds: np.ndarray, in_cut: np.ndarray
) -> np.ndarray:
    """Times (s) that the moves between joints (m, 5) take: what the feed asks in cut, or the slowest axis needs.

    Tips are (m, 3), `feeds` and whether a move is `in_cut` (m - 1,). On a machine that states no rates, no axis
    goes faster than the feed, in mm and degrees per minute; zero where there is no feed either.
    """
    rates, by_axis = machine.max_rates, np.zeros(len(joints) - 1)
    if no_rates := np.isnan(rates).all():
        rates = 1 / machine.units
    for column, rate in zip(joints.T, rates, strict=True):
        by_axis = np.fmax(by_axis, np.abs(np.diff(column)) / rate)
    if no_rates:
        by_axis = np.nan_to_num(60 * by_axis / feeds)
    return np.fmax(by_axis, np.where(in_cut, feed_times(tip, feeds), 0))


def tcp_times(kin: Kinematics, joints: np.ndarray) -> np.ndarray:
    """Times (s) in which no axis exceeds its rate between joints (m, 5), mm and radians, where the tip is kept.

    The tip is on the line and the angles turn evenly; X Y Z follow, and are faster in some parts than in others.
    """
    tip, times, before = kin.forward(joints)[0], np.zeros(len(joints) - 1), joints[:-1]
    for part in np.arange(1, TCP_PARTS + 1) / TCP_PARTS:
        angles = joints[:-1, 3:] + part * np.diff(joints[:, 3:], axis=0)
        now = kin.close(tip[:-1] + part * np.diff(tip, axis=0), angles)
        rates = np.abs(now - before) * TCP_PARTS / kin.machine.max_rates
        times, before = np.fmax(times, np.fmax.reduce(rates, axis=1)), now
    return times


def asked_by(kin: Kinematics, blocks: Blocks, control: Control) -> tuple[np.ndarray, np.ndarray]:
    """Return the motion that a program asks for: joints at the block ends, (n, 5), and seconds per move, (n - 1,).

    A rapid move takes as long as its slowest axis needs, a move at feed at least as long as the feed of the tip
    asks, and a block that states its time at least that time. Where only rotary axes turn, F may be degrees per
    minute: with TCP by `Control.turning_feed`, without by `Control.rotary_feed`. Where slides move too it may count
    these alone, or all axes together, mm and degrees alike: `Control.mixed_feed`.
    """
    joints, seconds = joints_of(kin, blocks), np.empty(max(len(blocks.words) - 1, 0))
    for moves in slices(seconds.shape):
        poses = slice(moves.start, moves.stop + 1)
        seconds[moves] = _asked_by(kin, blocks[poses], joints[poses], control)
    return joints, seconds


def _asked_by(kin: Kinematics, blocks: Blocks, joints: np.ndarray, control: Control) -> np.ndarray:
    """The seconds of `asked_by`."""
    at_feed = ~blocks.rapid[1:]
    steps, tcp = np.abs(np.diff(blocks.words, axis=0)), blocks.tcp[1:] & blocks.tcp[:-1]
    only_turns = at_feed & ~steps[:, :3].any(axis=1)
    by_axes = at_feed & ~blocks.tcp[1:] & ~blocks.tcp[:-1]  # F counts axes, and not the way of the tip
    in_degrees = only_turns & by_axes & (control.rotary_feed == "degrees")
    mixed = ~only_turns & by_axes & steps[:, 3:].any(axis=1) & (control.mixed_feed != "tip")
    of_tip = at_feed & ~in_degrees & ~mixed
    feeds = np.where(mixed, np.nan, blocks.feeds[1:])  # which may be more than F in degrees
    seconds = block_times(kin.machine, joints, kin.forward(joints)[0], feeds, of_tip)
    degrees = np.where(in_degrees, np.linalg.norm(steps[:, 3:], axis=1), 0)
    counted = steps[:, :3] if control.mixed_feed == "slides" else steps
    degrees = np.where(mixed, np.linalg.norm(counted, axis=1), degrees)
    if control.turning_feed != "rates":
        degrees = np.where(only_turns & tcp, steps[:, 3:].max(axis=1), degrees)
    seconds = np.fmax(seconds, 60 * degrees / blocks.feeds[1:])
    return np.fmax(seconds, blocks.seconds[1:])


def law_of(
    kin: Kinematics, blocks: Blocks, control: Control, rounding: float, smooth: np.ndarray | None = None
) -> tuple[np.ndarray, TimeLaw]:
    """Return the seconds that the blocks of a program ask, shape (n - 1,), and the time law of a control.

    A control that does not look ahead over rotary axes plans X Y Z as programmed, with TCP those of the tip. Where
    it overlaps blocks it rounds off at most `rounding`, mm; `TimeLaw.at` does not hold then.
    """
    joints, asked = asked_by(kin, blocks, control)
    if control.between_blocks == "look-ahead":
        return asked, time_law(kin.machine, joints, asked)
    overlap = control.between_blocks == "overlap"
    turning = (np.diff(blocks.words[:, 3:], axis=0) != 0).any(axis=1)
    halts = np.r_[True, turning[1:] | turning[:-1], True]
    law = time_law(
        _weaker(kin.machine, 1 + overlap),
        blocks.joints,
        asked,
        settle=SETTLE if overlap else AT_ONCE,
        halts=halts,
        smooth=smooth,
    )
    moving = np.flatnonzero(asked > 0)
    kept = np.r_[0, moving + 1]
    if overlap:
        shared = overlaps(blocks.words[kept, :3], law, rounding) * halts[kept][1:-1] / 2
        durations = np.diff(law.seconds) - np.r_[0.0, shared] - np.r_[shared, 0.0]
        law = replace(law, seconds=np.r_[0.0, np.cumsum(durations)])
    speeds = np.abs(np.diff(joints, axis=0))[moving] / asked[moving, None]
    pulls = np.where(np.isfinite(law.ramp), law.ramp, 0)
    peaks = np.array([(speeds.T * by).max(axis=1, initial=0) for by in (law.highest, pulls)])
    peaks[1, np.isnan(kin.machine.max_accelerations)] = np.nan
    return asked, replace(law, joints=joints[kept], peaks=peaks)


def _weaker(machine: Machine, times: int) -> Machine:
    """A machine with so many times less acceleration."""

    def less(joint: Joint) -> Joint:
        most = joint.max_acceleration
        return joint if most is None else replace(joint, max_acceleration=most / times)

    return replace(machine, linear=tuple(map(less, machine.linear)), rotary=tuple(map(less, machine.rotary)))


def overlaps(points: np.ndarray, law: TimeLaw, rounding: float) -> np.ndarray:
    """Seconds (m - 2,) in which LinuxCNC runs two moves at once: one slows down, the next speeds up.

    `points`, shape (m, 3), are X Y Z as programmed. Both moves last half of their way at most, and the corner is
    rounded off by at most `rounding`, mm, unless it is hardly one (`tpComputeBlendVelocity` of LinuxCNC 2.9).
    """
    steps = np.diff(points, axis=0)
    lengths = np.linalg.norm(steps, axis=1)
    along = steps / np.where(lengths > 0, lengths, 1)[:, None]
    slowing, longest = law.highest / law.ramp, law.asked / law.highest
    shared = np.minimum(np.minimum(slowing[:-1], slowing[1:]), np.minimum(longest[:-1], longest[1:]))
    half = np.arccos(np.clip(-(along[:-1] * along[1:]).sum(axis=1), -1, 1)) / 2
    corner = (np.cos(half) > SLIGHT) & (rounding > 0)
    pull = law.ramp / law.asked * np.where(lengths > 0, lengths, np.inf)  # mm/s²
    allowed = 2 * np.sqrt(rounding / (pull[:-1] * np.maximum(np.cos(half), SLIGHT)))
    return np.where(corner, np.minimum(shared, allowed), shared)


def corners(
    joints: np.ndarray, moving: np.ndarray, lengths: np.ndarray, most: np.ndarray, settle: np.ndarray, some: slice
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The speed of each axis at w = 1, shape (j, k), on some moves.

    And, at the k + 1 poses at their ends, what a bend takes of the acceleration of each axis, and the squares of w.
    """
    first, stop = max(some.start - 1, 0), min(some.stop + 1, len(lengths))  # with a move more at each end
    moving, lengths, settle = moving[first:stop], lengths[first:stop], settle[first + 1 : stop]
    moves = len(lengths)
    speed, bend, squares = np.empty((len(most), moves)), np.zeros((len(most), moves + 1)), np.zeros(moves + 1)
    between = (lengths[1:] + lengths[:-1]) / 2
    pause, needed = np.where(between < settle, between, np.inf), np.zeros(len(between))
    for axis, column in enumerate(joints.T):
        velocity = (column[moving + 1] - column[moving]) / lengths
        jumps = np.abs(np.diff(velocity))
        speed[axis], bend[axis, 1:-1] = np.abs(velocity), jumps / pause
        np.maximum(needed, jumps / most[axis], out=needed)  # seconds, in which all axes can take their jumps
    with np.errstate(divide="ignore", invalid="ignore"):
        squares[1:-1] = np.minimum(1.0, np.minimum(pause / needed, (settle / needed) ** 2))
    squares[1:-1][settle == 0] = 0  # a halt, also where no speed jumps
    own = slice(some.start - first, some.stop - first)
    ends = slice(own.start, own.stop + 1)
    return np.ascontiguousarray(speed[:, own]), np.ascontiguousarray(bend[:, ends]), squares[ends]


# The loops run as plain Python, or as machine code if Numba compiles them.


def climbed(
    squares: np.ndarray, lengths: np.ndarray, speed: np.ndarray, bend: np.ndarray, most: np.ndarray
) -> np.ndarray:
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


def driven(
    squares: np.ndarray, lengths: np.ndarray, speed: np.ndarray, bend: np.ndarray, most: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
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


def slow_down(record: ArrayLike, seconds: ArrayLike, asked: ArrayLike) -> SlowDown | None:
    """Return the record at which the tip loses most time against its feed, with the seconds asked and taken.

    For each move, `record` is the record it leads to, `seconds` the time it takes, `asked` the time by its feed, or
    NaN.
    """
    record, seconds, asked = np.asarray(record), np.asarray(seconds), np.asarray(asked)
    fed = ~np.isnan(asked)
    if not fed.any():
        return None
    taken, wanted = (np.bincount(record[fed], values[fed]) for values in (seconds, asked))
    worst = int((taken - wanted).argmax())
    return worst, float(wanted[worst]), float(taken[worst])
