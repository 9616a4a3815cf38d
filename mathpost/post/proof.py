"""The proof of a program: its own text, read back and sent through the forward kinematics, against the CL data.

It covers the records, the path that the joints really run between the blocks, lifted moves, feeds and times.
"""

from dataclasses import dataclass

import numpy as np

from mathpost.errors import MathpostError
from mathpost.post import ways
from mathpost.post.between_blocks import bounds, largest, sampled
from mathpost.rotation import slices

LEAST_INTERVALS = 16  # of a move of a machine with measured errors, which no third derivative bounds
FEED_DIGITS = 0.001  # mm/min; what is lost where a feed is rounded down to three decimals


@dataclass(frozen=True)
class Proof:
    """How far a program, read back from its own text, is from the CL data.

    Between the blocks the moves in cut count; a rapid one does not count for the tool axis.
    """

    tip_error: float  # largest at the records, mm,
    axis_error: float  # and of the tool axis, degrees
    path_tip_error: float  # from the CL segments, mm
    path_axis_error: float  # from the great circles, degrees
    worst_record: int  # (from 1) that the largest tip error of the path comes before or at


def prove(kin, cl, blocks, motion, tolerance, axis_tolerance, *, real=None):
    """Return the `Proof` of a program; tolerances in mm and radians, the others as in `measured`.

    Raises `MathpostError` if the tip or the tool axis is off the CL path by more than its tolerance, or the tip
    below the part on a lifted move, or if a block has another feed than the CL data, or less time than its feed and
    the rates of the machine allow.
    """
    proof = measured(kin, cl, blocks, motion, real=real)
    tip, axis = max(proof.tip_error, proof.path_tip_error), max(proof.axis_error, proof.path_axis_error)
    if not tip <= tolerance:
        raise MathpostError(f"{cl.name}: the program is {tip:.6f} mm off the CL path, more than {tolerance} mm")
    if not axis <= (granted := np.degrees(axis_tolerance)):
        raise MathpostError(f"{cl.name}: the tool axis is {axis:.4f}° off its great circle, more than {granted:g}°")
    _refuse_below_the_part(kin, cl, blocks, motion, tolerance, real)
    _refuse_other_feeds(cl, blocks, motion)
    _refuse_too_fast(kin.machine, cl, blocks, motion)
    return proof


def measured(kin, cl, blocks, motion, *, real=None):
    """Return as `Proof` how far blocks that were read back are from the CL data, at the records and between them.

    `motion` says where on the CL path each block ends, and which are lifted off the part; `real`, a `Compensator`,
    is the machine that runs the program, if it is not the one that its control knows.
    """
    if len(blocks.words) != len(motion.place):
        raise MathpostError(f"{len(motion.place)} blocks were written and {len(blocks.words)} read back")
    machine, joints = real or kin, _joints(kin, blocks)
    tips, axes = cl.at(motion.place)
    moves = len(joints) - 1
    least, most, off = LEAST_INTERVALS if real else 2, np.full((2, moves), np.inf), np.zeros(moves)
    # A record whose block was left out as a repetition has the pose of the block before.
    on_part = np.flatnonzero(~motion.lifted)
    at = on_part[np.searchsorted(motion.place[on_part], np.arange(len(cl)), side="right") - 1]
    tip_error = chord = 0.0
    for rows in slices(joints.shape[:1]):
        poses = slice(rows.start, rows.stop + 1)  # that after the last move included
        reached = machine.forward(joints[poses])
        off[rows] = np.linalg.norm(reached[0] - tips[poses], axis=1)[1:]
        if not real:
            most[:, rows] = bounds(kin.machine, joints[poses], tips[poses], axes[poses], reached)
        records = slice(*np.searchsorted(at, [rows.start, rows.stop]))
        tip, axis = (np.take(each.T, at[records] - rows.start, axis=1) for each in reached)
        tip_error = max(tip_error, np.linalg.norm(tip - cl.points[records].T, axis=0).max(initial=0))
        chord = max(chord, np.linalg.norm(axis - cl.axes[records].T, axis=0).max(initial=0))
    off[~motion.in_cut], most[:, ~motion.in_cut] = 0, -1
    most[1, ~motion.at_feed(cl)] = -1
    path_axis, _ = largest(1, machine, joints, axes, most[1], least=least)
    if blocks.tcp:  # the control keeps the tip on the straight line between the blocks
        path_tip, worst = off.max(initial=0), int(off.argmax()) if moves else -1
    else:
        path_tip, worst = largest(0, machine, joints, tips, most[0], least=least)

    return Proof(
        tip_error=float(tip_error),
        axis_error=float(np.degrees(2 * np.arcsin(min(chord / 2, 1)))),
        path_tip_error=float(path_tip),
        path_axis_error=float(np.degrees(path_axis)),
        worst_record=int(motion.record[worst + 1]) + 1,
    )


def worst_of(proofs):
    """Return the `Proof` that says the worst of several."""
    farthest = max(proofs, key=lambda proof: proof.path_tip_error)
    names = ("tip_error", "axis_error", "path_tip_error", "path_axis_error")
    return Proof(*(max(getattr(proof, name) for proof in proofs) for name in names), farthest.worst_record)


def _joints(kin, blocks):
    """What the axes do: with TCP the control finds X Y Z itself."""
    return kin.close(blocks.joints[:, :3], blocks.joints[:, 3:]) if blocks.tcp else blocks.joints


def _refuse_below_the_part(kin, cl, blocks, motion, tolerance, real):
    """Along lifted moves the tip must stay on the side of the part that the tool axis points to."""
    lifted = np.flatnonzero(~motion.in_cut)
    if not lifted.size:
        return
    joints = _joints(kin, blocks)
    for some, t, tip, _ in sampled(real or kin, joints[lifted], joints[lifted + 1], least=LEAST_INTERVALS):
        moves = lifted[some]
        if blocks.tcp:  # the control keeps the tip on the straight line between the blocks
            tip = tip[0] + t[..., None] * (tip[-1] - tip[0])
        tips, axes = cl.at(motion.place[moves] + t * (motion.place[moves + 1] - motion.place[moves]))
        height = np.vecdot(tip - tips, axes).min(axis=0)
        if not height.min() >= -tolerance:
            record = motion.record[moves[height.argmin()] + 1]
            raise MathpostError(
                f"{cl.where(record)}: on its way there the lifted tool goes {-height.min():.3f} mm into the part"
            )


def _refuse_other_feeds(cl, blocks, motion):
    """Rapid where the CL data are, and at their feed elsewhere, if no time is stated instead."""
    for rows in slices(motion.place.shape):
        record, block = motion[rows].record, blocks[rows]
        feeds, rapid = cl.feeds[record], cl.rapid[record]
        by_feed = ~rapid & np.isnan(block.seconds) & ~np.isnan(feeds)
        as_it_is = (block.feeds <= feeds + 1e-9) & (block.feeds >= feeds - FEED_DIGITS)
        wrong = (block.rapid != rapid) | (by_feed & ~as_it_is)
        if wrong.any():
            at = int(wrong.argmax())
            found = "rapid" if block.rapid[at] else f"feed {block.feeds[at]:g}"
            expected = "rapid" if rapid[at] else f"feed {feeds[at]:g}"
            raise MathpostError(f"{cl.where(record[at])}: the CL data have {expected} and the program {found}")


def _refuse_too_fast(machine, cl, blocks, motion):
    """A block with a time takes as long as its way on the CL path at its feed, and as its slowest axis.

    An axis goes at its rate; where the machine states none, at the feed, in mm and degrees a minute.
    """
    timed = 1 + np.flatnonzero(~np.isnan(blocks.seconds[1:]))
    seconds, feeds = blocks.seconds[timed], cl.feeds[motion.record[timed]]
    start, end = (cl.at(motion.place[rows])[0] for rows in (timed - 1, timed))
    by_feed = np.where(motion.in_cut[timed - 1], np.linalg.norm(end - start, axis=1) * 60 / feeds, 0)
    rates = np.where(np.isnan(machine.max_rates), np.inf, machine.max_rates) * [1, 1, 1, *np.degrees([1, 1])]
    if np.isinf(rates).all():
        rates = feeds[:, None] / 60
    by_axis = (np.abs(blocks.words[timed] - blocks.words[timed - 1]) / rates).max(axis=1, initial=0)
    least = np.maximum(by_feed, by_axis)
    # A hundredth, a millisecond of FT, the fourth decimal of F in blocks a minute and of the axes are left open.
    fast = seconds < 0.99 * least - 0.001 - 1e-6 * seconds**2 - 0.012 / feeds
    if fast.any():
        block = int(fast.argmax())
        where = cl.where(motion.record[timed[block]])
        raise MathpostError(
            f"{where}: a block takes {seconds[block]:.3f} s, feed and axes need {least[block]:.3f} s at least"
        )


@dataclass(frozen=True)
class Report(Proof):
    """All that a person wants to know of a program before running it; ``print(report)`` shows it."""

    settings: dict  # what the program was made with, as text
    time: float  # seconds, by `mathpost.post.time_law`; 0 if neither feed nor rates are known
    peaks: dict  # of each axis: greatest speed and acceleration, mm or degrees, NaN an acceleration without limit
    slowest: tuple | None  # record (from 0) before which the tip loses most time, seconds asked, and taken
    warnings: tuple
    uncompensated: Proof | None  # what the calibrated machine would do, had the program not been compensated
    strategies: tuple  # name; cost; largest step of each rotary axis, degrees; why it is not possible
    ways: dict  # the ways through each singular region (first and last record, from 0), lists of `Way`

    def __str__(self):
        said, peaks = [*self.settings.items()], []
        for name, (speed, acceleration) in self.peaks.items():
            unit = "mm" if name in "XYZ" else "°"
            pulled = "" if np.isnan(acceleration) else f" {acceleration:.0f} {unit}/s²"
            if speed > 0:
                peaks.append(f"{name} {speed:.1f} {unit}/s{pulled}")
        if self.time > 0:
            said += [("time", f"{self.time:.2f} s"), ("peaks", ", ".join(peaks))]
        if self.slowest:
            record, asked, taken = self.slowest
            said += [("slow-down", f"before record {record + 1}: {taken:.3f} s, the feed asks {asked:.3f} s")]
        along = f"{self.path_tip_error:.4f} mm along the path (most before record {self.worst_record})"
        said += [("tip error", f"{self.tip_error:.4f} mm at the records, {along}")]
        along = f"{self.path_axis_error:.4f}° along the path"
        said += [("axis error", f"{self.axis_error:.4f}° at the records, {along}")]
        if self.uncompensated:
            before, after = (
                f"{1e3 * each.tip_error:.1f} µm and {3600 * each.axis_error:.1f} arcsec"
                for each in (self.uncompensated, self)
            )
            said += [("volumetric", f"at the records {before} before compensation, {after} after it")]
        said += [("warning", warning) for warning in self.warnings]
        lines = [f"{key:<12} {value}" for key, value in said]
        if self.strategies:
            lines += ["", f"{'selection':<14}{'cost':>10}  largest rotary steps"]
        for name, cost, steps, reason in self.strategies:
            figures = f"{cost:10.3f}  " + " ".join(f"{step:8.3f}°" for step in steps)
            lines.append(f"{name:<14}{reason or figures}")
        for region, through in self.ways.items():
            lines += ["", *ways.comparison(region, through)]
        return "\n".join(lines)
