"""The motion of a machine along a CL path: its poses, enough of them for both tolerances, and the blocks they make.

First the tool axis: `follow` puts poses on its great circle. Then the tip: linearization (线性化) divides a move in
the *workpiece*, tip on the CL segment, rotary angles in equal steps, which leaves the tool axis where it went, and
X Y Z recomputed. Equation (8) of source 002 divides it in the joints, which puts the new points on the very line
that the control follows anyway.
"""

from dataclasses import dataclass, replace

import numpy as np

from mathpost.compensate.compensation import Compensated, PoseError
from mathpost.errors import InputError, ReachError
from mathpost.machine import UNITS
from mathpost.post import program, singular
from mathpost.post.between_blocks import (
    RESOLUTION,
    axis_lag,
    derivative,
    deviation,
    from_segment,
    levers,
    tip_deviation,
)
from mathpost.post.selection import nearest
from mathpost.rotation import slices

LOST = 1 / 8  # of the axis tolerance: a move that spans less and strays more does not go along its great circle
AIR = 0.1  # of the clearance, how far a lifted tip may stray


@dataclass(frozen=True)
class Motion:
    """The poses that the machine runs through, all joints linearly from each to the next.

    Attributes
    ----------
    joints, place : ndarray, shape (m, 5) and (m,)
        mm and radians; and where on the CL path: 2.25 is a quarter of the way from record 2 to record 3.
    lifted : ndarray of bool, shape (m,)
        Whether the pose is off the part, retracted along the tool axis.
    """

    joints: np.ndarray
    place: np.ndarray
    lifted: np.ndarray

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


def follow(kin, cl, motion, tolerance, *, free=False):
    """Divide every move in cut along the CL path until the tool axis keeps `tolerance` (radians) of its circle.

    Moves are halved on the great circle. Where it meets a singular tool axis there is a pose just before and one
    just after it: the outer axis turns while the tool axis all but stands still. The poses in cut are on the path;
    `free`, shape (n - 1,), are moves that need not follow, besides those that are lifted or rapid. `ReachError` if
    the joints do not go along the great circle, as where they change the branch.
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
            raise ReachError(
                f"{cl.where(int(np.ceil(place[lost[0] + 1])))}: on its way there the tool axis strays "
                f"{np.degrees(error[lost[0]]):.3f}° from its great circle, more than {np.degrees(tolerance):.2g}°, "
                "however often the move is divided"
            )
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
    derived = kin.inverse_symbolic
    inner = beside[:, kin.symbols.index(derived.inner)]
    second = np.sin(inner - float(sum(derived.solutions) / 2)) < 0
    joints = kin.inverse(*cl.at(place))[np.arange(len(place)), second.astype(int)]
    if (lost := np.isnan(joints).any(axis=1)).any():
        raise ReachError(
            f"{cl.where(int(np.ceil(place[lost.argmax()])))}: on its way there the tool axis is out of reach"
        )
    joints[:, 3:] = beside[:, 3:] + nearest(joints[:, 3:] - beside[:, 3:])
    return joints


def subdivide(kin, start, end, pieces):
    """Divide moves evenly: tip on the segment, rotary angles in equal steps, X Y Z recomputed.

    `start` and `end`, shape (m, 5), are the joints at both ends of each move, mm and radians; `pieces` is a number
    or one for each. Returns the joints (k, 5) at the end of every piece, and its place (k,): 2.25 is a quarter of
    the third move.
    """
    start, end = np.asarray(start, dtype=float), np.asarray(end, dtype=float)
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

    Parameters
    ----------
    kin : Kinematics
    motion : Motion, or array_like of shape (n, 5)
        Or its joints alone, mm and radians, at the places 0, 1, 2 …, none lifted.
    tolerance : float or array_like, shape (n - 1,)
        mm; for all moves, or for each.
    max_pieces : int
        The most pieces that one move may be divided into.
    name : str
        What a row is called in an error message.

    Returns
    -------
    Motion

    Raises
    ------
    ReachError
        If a move does not meet the tolerance with `max_pieces`; names it.
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
        error = np.maximum.reduceat(tip_deviation(kin, starts, ends), firsts)
        over = error > tolerance[rest]
        rest, error = rest[over], error[over]
        # The error falls with the square of the number of pieces.
        wanted = np.ceil(pieces[rest] * np.sqrt(error / tolerance[rest])).astype(int)
        pieces[rest] = np.maximum(pieces[rest] + 1, wanted)
        if pieces.max() > max_pieces:
            move = int(pieces.argmax())
            raise ReachError(
                f"from {name} {move + 1} to {move + 2}: the tip strays {error[rest == move][0]:.6f} mm, more than "
                f"{tolerance[move]:g} mm, and {max_pieces} pieces are not enough"
            )
    if (pieces == 1).all():
        return motion
    joints, at = subdivide(kin, start, end, pieces)
    joints, at = np.concatenate([motion.joints[:1], joints]), np.r_[0.0, at]
    before, after = np.floor(at).astype(int), np.ceil(at).astype(int)
    place = np.interp(at, np.arange(len(motion.place)), motion.place)
    return Motion(joints, place, motion.lifted[before] | motion.lifted[after])


def in_the_air(motion, tolerance, clearance):
    """The tolerance of the tip (mm) for each move, more for those that are lifted."""
    return np.where(motion.in_cut, tolerance, np.maximum(tolerance, AIR * clearance))


def divided(kin, cl, motion, tolerance, tcp, clearance):
    """The motion divided until the tip keeps the tolerance, digits and what samples miss included."""
    tip, _ = cl.at(motion.place)  # on the path, or lifted by so little that it does not count here
    lever = (levers(kin.machine) + np.linalg.norm(tip, axis=1)) * (not tcp)  # the angles do not move the tip then
    moved = 0.5 * 10.0**-program.DECIMALS * (np.sqrt(3) + 2 * np.radians(1.0) * lever) + RESOLUTION
    if (worst := moved.max()) > tolerance / 2:
        expected = f"at least {2 * worst:.4f} mm, for words of {program.DECIMALS} decimals on this machine"
        raise InputError("tolerance", expected, f"{tolerance}")
    keep = tolerance - np.maximum(moved[:-1], moved[1:])
    return linearize(kin, motion, in_the_air(motion, keep, clearance), name=f"{cl.name}, block")


def compensated(real, motion):
    """The motion compensated for the errors of the machine, and sentences on what could not be."""
    parts = [real.compensate(motion.joints[rows]) for rows in slices(motion.joints.shape[:1])]

    def whole(names, parts):
        return (np.concatenate([getattr(part, name) for part in parts]) for name in names)

    after = PoseError(*whole(("tip", "axis"), [part.after for part in parts]))
    joints, limited, refused = whole(("joints", "limited", "refused"), parts)
    return replace(motion, joints=joints), Compensated(joints, parts[0].before, after, limited, refused).cautions


def refuse_out_of_travel(machine, cl, motion):
    """Raise `ReachError` for the first pose, those between the records included, that is out of travel."""
    out = np.flatnonzero(~machine.within(motion.joints).all(axis=1))
    if out.size:
        sentences = machine.out_of_travel(motion.joints[out[0]])
        raise ReachError(f"{cl.where(int(motion.place[out[0]]))} and on: {'; '.join(sentences)}")


def blocks(kin, cl, motion, tcp):
    """What a program says of a motion: the poses, the `program.Blocks` that end at them, and seconds of the moves.

    The seconds are those that feed and rates ask for, and those of the feed alone, NaN where it does not count. A
    pose that repeats all words of the one before is left out.
    """
    joints = motion.joints
    words = np.concatenate([kin.forward(joints)[0], joints[:, 3:]], axis=1) if tcp else joints
    words = program.rounded(words)
    kept = np.r_[True, (words[1:] != words[:-1]).any(axis=1)]
    if not kept.all():
        motion, words = motion[kept], words[kept]
    record = motion.record
    feeds, rapid, (tip, _) = cl.feeds[record], cl.rapid[record], cl.at(motion.place)  # in cut it is on the path
    seconds = np.r_[np.nan, block_times(kin.machine, motion.joints, tip, feeds[1:], motion.in_cut)]
    turning = np.r_[False, (words[1:, 3:] != words[:-1, 3:]).any(axis=1)]
    by_time = turning & ~np.isnan(feeds) & ~rapid & (not tcp)
    # A remark stands before the first block of the move to its record.
    before = np.searchsorted(motion.place, [record - 1 for record, _ in cl.remarks], side="right").tolist()
    remarks = tuple((block, text) for block, (_, text) in zip(before, cl.remarks, strict=True))
    planned = program.Blocks(words, feeds, np.where(by_time, seconds, np.nan), rapid, tcp, remarks)
    fed = np.where(motion.in_cut & ~rapid[1:], feed_times(tip, feeds[1:]), np.nan)
    return motion, planned, seconds[1:], fed


def feed_times(tip, feeds):
    """Times (s) that the feed gives the moves between tips (m, 3), shape (m - 1,); NaN where none is stated."""
    return 60 * np.linalg.norm(np.diff(tip, axis=0), axis=1) / feeds


def block_times(machine, joints, tip, feeds, in_cut):
    """Times (s) that the moves between joints (m, 5) take: what the feed asks in cut, or the slowest axis needs.

    `tip`, shape (m, 3), is where the joints put the tool; `feeds` and `in_cut`, shape (m - 1,), are those of the
    moves. On a machine that states no rates, no axis goes faster than the feed, in mm and degrees per minute; zero
    where there is no feed either.
    """
    rates, by_axis = machine.max_rates, np.zeros(len(joints) - 1)
    if no_rates := np.isnan(rates).all():
        rates = 1 / UNITS
    for column, rate in zip(joints.T, rates, strict=True):
        if not np.isnan(rate):
            np.maximum(by_axis, np.abs(np.diff(column)) / rate, out=by_axis)
    if no_rates:
        by_axis = np.nan_to_num(60 * by_axis / feeds)
    return np.fmax(by_axis, np.where(in_cut, feed_times(tip, feeds), 0))


def refuse_turning_compensation(cl, machine, blocks):
    """Raise `InputError` if a rotary axis moves while the control compensates the radius of the cutter.

    The control does so in its X-Y plane: the tool has to stand across it, and the rotary axes still.
    """
    switched = [(row, remark) for row, remark in blocks.remarks if getattr(remark, "kind", "") == "compensation"]
    on, rows = None, len(blocks.words)
    for row, remark in [*switched, (rows, None)]:
        if on is not None:
            rotary = blocks.words[max(on[0] - 1, 0) : min(row + 1, rows), 3:]
            heads = [joint.carries == "tool" for joint in machine.rotary]
            if blocks.tcp or np.ptp(rotary, axis=0).any() or rotary[:1, heads].any():
                expected = "rotary axes that stand still, the tool across X and Y, and no TCP"
                raise InputError(f"{cl.name}: {on[1].statement}", expected, "others while it holds")
        on = (row, remark) if remark is not None and remark.values[0] != "OFF" else None


def equation_8(kin, start, end, tolerance, *, max_depth=12):
    """Divide a move by equation (8) of source 002 taken literally, for the audit only.

    The new points lie on the line in joint space, and each half is measured at its middle against its own chord.
    Returns the joints (pieces + 1, 5), "converged" by that measure, the largest error by that measure, and the true
    one, against the segment of the whole move, mm.
    """
    for depth in range(max_depth):
        joints = np.linspace(start, end, 2**depth + 1)
        tip, middle = kin.forward(joints)[0], kin.forward((joints[:-1] + joints[1:]) / 2)[0]
        claimed = from_segment(middle, tip[:-1], tip[1:]).max()
        if claimed <= tolerance:
            break
    whole = np.broadcast_to(tip[[0, -1], None], (2, len(joints) - 1, 3))
    return joints, float(claimed), float(deviation(kin, joints[:-1], joints[1:], tips=whole)[0].max())
