"""The proof of a program: its own text, read back and sent through the forward kinematics, against the CL data.

It covers the records, the path that the joints really run between the blocks, lifted moves, feeds and times.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from mathpost.errors import MathpostError
from mathpost.formula import slices
from mathpost.kinematics import ForwardKinematics, Kinematics
from mathpost.path.between_blocks import axis_lag
from mathpost.path.deviation import (
    AXIS,
    FEWEST_INTERVALS,
    LEAST_INTERVALS,
    TIP,
    arcs,
    bounds,
    largest,
    sampled,
    stray,
)
from mathpost.rotation import angle_of_chord
from mathpost.shop.controls.blocks import Blocks
from mathpost.shop.post.body import moving

if TYPE_CHECKING:
    from mathpost.path.cl import CLData
    from mathpost.path.motion import Motion

FEED_DIGITS = 0.001  # mm/min; what is lost where a feed is rounded down to three decimals


@dataclass(frozen=True)
class Proof:
    """How far a program, read back from its own text, is from the CL data.

    Between the blocks, cutting moves are measured; of rapid ones the tip alone.
    """

    tip_error: float  # largest at the records, mm,
    axis_error: float  # and of the tool axis, degrees
    path_tip_error: float  # from the CL segments, mm
    path_axis_error: float  # from the great circle arcs between the records, degrees
    worst_record: int  # (from 1) that the largest tip error of the path comes before or at
    lag: float  # of the tool axis: the angle, degrees, to where it should be at the same part of each move


def prove(
    kin: Kinematics,
    cl: CLData,
    blocks: Blocks,
    motion: Motion,
    tolerance: float,
    axis_tolerance: float,
    *,
    real: ForwardKinematics | None = None,
    rapid_interpolated: bool = True,
    left_out: ArrayLike = (),
) -> Proof:
    """Return the `Proof` of a program; tolerances in mm and radians, the others as in `measured`.

    `MathpostError` if tip or tool axis are off the CL path by more than their tolerances, or a lifted tip goes into
    the part, or a block has another feed than the CL data, or less time than its feed and the rates of the machine
    allow.
    """
    proof = measured(kin, cl, blocks, motion, real=real, rapid_interpolated=rapid_interpolated, left_out=left_out)
    tip, axis = max(proof.tip_error, proof.path_tip_error), max(proof.axis_error, proof.path_axis_error)
    if not tip <= tolerance:
        raise MathpostError(f"{cl.name}: the program is {tip:.6f} mm off the CL path, more than {tolerance} mm")
    if not axis <= (granted := np.degrees(axis_tolerance)):
        raise MathpostError(f"{cl.name}: the tool axis is {axis:.4f}° off its great circle, more than {granted:g}°")
    _refuse_below_the_part(kin, cl, blocks, motion, tolerance, real)
    _refuse_other_feeds(cl, blocks, motion, slower=not rapid_interpolated)
    _refuse_too_fast(kin, cl, blocks, motion)
    return proof


def measured(
    kin: Kinematics,
    cl: CLData,
    blocks: Blocks,
    motion: Motion,
    *,
    real: ForwardKinematics | None = None,
    rapid_interpolated: bool = True,
    left_out: ArrayLike = (),
) -> Proof:
    """Return as `Proof` how far blocks that were read back are from the CL data, at the records and between them.

    `motion` says where on the CL path each block ends, and which are lifted; `real`, a `Compensator`, is the
    machine that runs the program, if it is not the one that its control knows. Where its rapid traverse is not
    interpolated, nobody knows the path of a rapid move of several axes, and only its end counts. Records that are
    `left_out` are pecks of holes, which the control makes by itself.
    """
    if len(blocks.words) != len(motion.place):
        raise MathpostError(f"{len(motion.place)} blocks were written and {len(blocks.words)} read back")
    machine, joints = real or kin, joints_of(kin, blocks)
    tips, _ = cl.at(motion.place)
    least = LEAST_INTERVALS if real else FEWEST_INTERVALS
    tip_error, chord, off, most = _at_the_ends(kin, cl, joints, motion, real, left_out)
    off[~motion.in_cut], most[:, ~motion.in_cut] = 0, -1
    most[1, ~motion.at_feed(cl)] = -1
    if not rapid_interpolated:
        unknown = blocks.rapid[1:] & (moving(kin, joints).sum(axis=1) > 1)
        off[unknown], most[:, unknown] = 0, -1

    def off_arcs(moves: np.ndarray) -> np.ndarray:
        path = arcs(cl, motion.place[moves], motion.place[moves + 1])
        return stray(AXIS, machine, joints[moves], joints[moves + 1], path, least)

    def off_segments(moves: np.ndarray) -> np.ndarray:
        return stray(TIP, machine, joints[moves], joints[moves + 1], (tips[moves], tips[moves + 1]), least)

    def lags(moves: np.ndarray) -> np.ndarray:
        start, end, (before, after) = (
            joints[moves],
            joints[moves + 1],
            (motion.place[moves], motion.place[moves + 1]),
        )
        return axis_lag(machine, cl, start, end, before, after, least)

    path_axis, _ = largest(off_arcs, most[1], AXIS.resolution)
    over_records = motion.record[1:] > np.floor(motion.place[:-1]) + 1  # a way that goes past some: no bound
    lag, _ = largest(lags, np.where(over_records & (most[1] >= 0), np.pi, most[1]))
    straight = blocks.tcp[1:]  # the control keeps the tip on the straight line between the blocks
    off[~straight], most[0, straight] = 0, -1
    path_tip, worst = largest(off_segments, most[0], TIP.resolution)
    if off.max(initial=0) > path_tip:
        path_tip, worst = off.max(), int(off.argmax())

    axis_error = np.degrees(angle_of_chord(chord))
    return Proof(
        tip_error=float(tip_error),
        axis_error=float(axis_error),
        path_tip_error=float(max(path_tip, tip_error)),  # the records are on the path
        path_axis_error=float(max(np.degrees(path_axis), axis_error)),
        worst_record=int(motion.record[worst + 1]) + 1,
        lag=float(max(np.degrees(lag), axis_error)),
    )


def _at_the_ends(
    kin: Kinematics,
    cl: CLData,
    joints: np.ndarray,
    motion: Motion,
    real: ForwardKinematics | None,
    left_out: ArrayLike,
) -> tuple[float, float, np.ndarray, np.ndarray]:
    """How far tip and tool axis are off at the records, mm and the chord of the angle.

    And, of each move, how far off the path its end is, and how far the move can stray, as `bounds`.
    """
    tips, axes = cl.at(motion.place)
    off, most = np.zeros(len(joints) - 1), np.full((2, len(joints) - 1), np.inf)
    # A record whose block was left out as a repetition has the pose of the block before.
    on_part = np.flatnonzero(~motion.lifted)
    wanted = np.delete(np.arange(len(cl)), np.asarray(left_out, int))
    at = on_part[np.searchsorted(motion.place[on_part], wanted, side="right") - 1]
    tip_error = chord = 0.0
    for rows in slices(joints.shape[:1]):
        poses = slice(rows.start, rows.stop + 1)  # that after the last move included
        reached = (real or kin).forward(joints[poses])
        off[rows] = np.linalg.norm(reached[0] - tips[poses], axis=1)[1:]
        if not real:
            most[:, rows] = bounds(kin.machine, joints[poses], tips[poses], axes[poses], reached)
        some = slice(*np.searchsorted(at, [rows.start, rows.stop]))
        records = wanted[some]
        tip, axis = (np.take(each.T, at[some] - rows.start, axis=1) for each in reached)
        tip_error = max(tip_error, np.linalg.norm(tip - cl.points[records].T, axis=0).max(initial=0))
        chord = max(chord, np.linalg.norm(axis - cl.axes[records].T, axis=0).max(initial=0))
    return tip_error, chord, off, most


def joints_of(kin: Kinematics, blocks: Blocks) -> np.ndarray:
    """Return what the axes do, shape (n, 5), mm and radians: with TCP the control finds X Y Z itself."""
    joints = blocks.joints
    joints[blocks.tcp] = kin.close(joints[blocks.tcp, :3], joints[blocks.tcp, 3:])
    return joints


def _refuse_below_the_part(
    kin: Kinematics, cl: CLData, blocks: Blocks, motion: Motion, tolerance: float, real: ForwardKinematics | None
) -> None:
    """Along lifted moves the tip must stay on the side of the part that the tool axis points to."""
    lifted = np.flatnonzero(~motion.in_cut & ~motion.far)
    if not lifted.size:
        return
    joints = joints_of(kin, blocks)
    for some, t, tip, _ in sampled(real or kin, joints[lifted], joints[lifted + 1], least=LEAST_INTERVALS):
        moves = lifted[some]
        line = tip[0] + t[..., None] * (tip[-1] - tip[0])  # on which a control with TCP keeps the tip
        tip = np.where(blocks.tcp[moves + 1, None], line, tip)
        tips, axes = cl.at(motion.place[moves] + t * (motion.place[moves + 1] - motion.place[moves]))
        height = np.vecdot(tip - tips, axes).min(axis=0)
        if not height.min() >= -tolerance:
            into = f"on its way there the lifted tool goes {-height.min():.3f} mm into the part"
            raise MathpostError(f"{cl.where(motion.place[moves[height.argmin()] + 1])}: {into}")


def _refuse_other_feeds(cl: CLData, blocks: Blocks, motion: Motion, slower: bool) -> None:
    """On the part: rapid where the CL data are, and at their feed elsewhere, if no time is stated instead.

    Where the CL data are rapid a program may be `slower`.
    """
    feeds, rapid = cl.feeds[motion.record], cl.rapid[motion.record]
    on_part = np.r_[~motion.lifted[0], motion.in_cut]
    by_feed = ~rapid & np.isnan(blocks.seconds) & ~np.isnan(feeds)
    as_it_is = (blocks.feeds <= feeds + 1e-9) & (blocks.feeds >= feeds - FEED_DIGITS)
    moved = np.zeros(blocks.words.shape, bool)
    moved[1:] = blocks.words[1:] != blocks.words[:-1]
    only_turns = blocks.tcp & ~moved[:, :3].any(axis=1) & moved[:, 3:].any(axis=1)  # F is not that of the tip
    wrong = on_part & (
        (blocks.rapid & ~rapid) | (rapid & ~blocks.rapid & (not slower)) | (by_feed & ~as_it_is & ~only_turns)
    )
    if wrong.any():
        at = int(wrong.argmax())
        found = "rapid" if blocks.rapid[at] else f"feed {blocks.feeds[at]:g}"
        expected = "rapid" if rapid[at] else f"feed {feeds[at]:g}"
        raise MathpostError(f"{cl.where(motion.record[at])}: the CL data have {expected} and the program {found}")


def _refuse_too_fast(kin: Kinematics, cl: CLData, blocks: Blocks, motion: Motion) -> None:
    """A block with a time takes as long as its way on the CL path at its feed, and as its slowest axis."""
    all_timed, records, in_cut = 1 + np.flatnonzero(~np.isnan(blocks.seconds[1:])), motion.record, motion.in_cut
    for some in slices(all_timed.shape):
        timed = all_timed[some]
        seconds, feeds = blocks.seconds[timed], cl.feeds[records[timed]]
        start, end = (cl.at(motion.place[rows])[0] for rows in (timed - 1, timed))
        by_feed = np.where(in_cut[timed - 1], np.linalg.norm(end - start, axis=1) * 60 / feeds, 0)
        rates = kin.machine.max_rates * kin.machine.units
        if np.isnan(rates).all():
            rates = feeds[:, None] / 60
        steps = (joints_of(kin, blocks[timed]) - joints_of(kin, blocks[timed - 1])) * kin.machine.units
        by_axis = np.nan_to_num(np.abs(steps) / rates).max(axis=1, initial=0)
        least = np.maximum(by_feed, by_axis)
        # A hundredth, a millisecond of FT, the fourth decimal of F in blocks a minute and of the axes are open.
        fast = seconds < 0.99 * least - 0.001 - 1e-6 * seconds**2 - np.nan_to_num(0.012 / feeds)
        if fast.any():
            block = int(fast.argmax())
            taken = f"a block takes {seconds[block]:.3f} s, feed and axes need {least[block]:.3f} s at least"
            raise MathpostError(f"{cl.where(records[timed[block]])}: {taken}")
