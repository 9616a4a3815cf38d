"""The proof of a program: its own text, read back and sent through the forward kinematics, against the CL data.

It covers the records, the path that the joints really run between the blocks, lifted moves, feeds and times. First
comes what it measures with, and planning, too: how far tip and tool axis stray from the CL path when all five
joints move linearly from block to block (nonlinear error, 非线性误差).
"""

import math
from dataclasses import dataclass

import numpy as np

from mathpost.controls.blocks import Blocks
from mathpost.errors import MathpostError
from mathpost.formula import slices
from mathpost.kinematics import Kinematics

RESOLUTION = 1e-5  # mm; what the samples of a move may miss of the way between them
LEVER = 50.0  # mm; the least lever that samples are counted for, for the sake of the tool axis
AXIS_RESOLUTION = RESOLUTION / LEVER  # radians; what they may miss of the tool axis
FIRST = 64  # one of so many moves, those with the greatest bounds, is looked at before the others
FEWEST_INTERVALS = 4  # of any move: with two, an end on the other side of the segment hides how high the peak is
LEAST_INTERVALS = 16  # of a move of a machine with measured errors, which no third derivative bounds
BODY = 5.0  # mm, assumed: the radius of the tool's body,
LEAST_BODY = 50.0  # and its length where the tool is shorter or its length not known
PLACE_DIGITS = 9  # of a place on the CL path: what rounding adds to that of a record does not count
MANY_POINTS = 5000  # that the body of the tool is held against one by one
FEED_DIGITS = 0.001  # mm/min; what is lost where a feed is rounded down to three decimals


def deviation(kin, start, end, *, tips=None, axes=None, least=FEWEST_INTERVALS):
    """Return how far the tip (mm) and the tool axis (radians) stray when all joints move linearly, shape (m,) each.

    `start` and `end`, shape (m, 5), are the joints at both ends of m moves, mm and radians; `tips` and `axes`, (2,
    m, 3), the ends of the segments and great circles that they should follow, by default where the joints at both
    ends have them. A move is sampled in intervals, at `least` so many, that miss no more than `RESOLUTION` where it
    is taken for a parabola between them.

    Examples
    --------
    Half a turn of C about a tip 77 mm from its axis: the tip cuts straight across.

    >>> import mathpost
    >>> kin = mathpost.Kinematics(mathpost.load_machine("dmu50v"))
    >>> ends = kin.close([77.0, 0, 0], [[0, 0], [0, np.pi]])
    >>> tip, axis = deviation(kin, ends[:1], ends[1:])
    >>> f"{tip[0]:.3f} mm"
    '77.000 mm'
    """
    return tuple(stray(kind, kin, start, end, path, least) for kind, path in enumerate((tips, axes)))


def strays(kin, cl, motion, moves=slice(None)):
    """Return how far tip (mm) and tool axis (radians) stray from the CL path on moves of a `Motion`.

    The tool axis is measured from the whole arc between two records, wherever on it the blocks are. How far it is
    from where `cl` has it at the same part of the way is the lag, see `mathpost.post.between_blocks.axis_lag`.
    """
    starts, ends = motion[:-1][moves], motion[1:][moves]
    tips = [cl.at(poses.place)[0] for poses in (starts, ends)]
    return deviation(kin, starts.joints, ends.joints, tips=tips, axes=arcs(cl, starts.place, ends.place))


def arcs(cl, place, place_after):
    """The tool axes of the records before and after each move, (2, m, 3): the ends of its arc."""
    before = np.floor(np.round(place, PLACE_DIGITS)).astype(int)
    after = np.ceil(np.round(place_after, PLACE_DIGITS)).astype(int)
    return cl.axes[before], cl.axes[after]


def stray(kind, kin, start, end, path=None, least=FEWEST_INTERVALS):
    """One half of `deviation`: that of the tip (`kind` 0) or of the tool axis (1)."""
    error = np.zeros(len(start))
    for moves, _, *tool in sampled(kin, start, end, least):
        ends = tool[kind][[0, -1]] if path is None else (path[0][moves], path[1][moves])
        error[moves] = peak((from_segment, from_arc)[kind](tool[kind], *ends))
    return error


def sampled(kin, start, end, least=FEWEST_INTERVALS):
    """Yield k moves at a time: their numbers (k,), t from 0 to 1 (intervals + 1, 1), tips and axes (…, k, 3)."""
    start, end = np.asarray(start, dtype=float), np.asarray(end, dtype=float)
    intervals = _intervals(kin.machine, start, end, least)
    for count in np.unique(intervals).tolist():
        t = np.linspace(0, 1, count + 1)[:, None]
        alike = np.flatnonzero(intervals == count)
        for rows in slices((len(alike), count + 1)):
            moves = alike[rows]
            yield moves, t, *kin.forward(start[moves] + t[..., None] * (end[moves] - start[moves]))


def true_tip(kin, joints, *, samples=24):
    """Return the way of the tip, shape (m, 3), when the joints (n, 5) move linearly: `samples` intervals a move."""
    joints, t = np.asarray(joints, dtype=float), np.linspace(0, 1, samples + 1)[:, None]
    return kin.forward(joints[:-1, None] + t * np.diff(joints, axis=0)[:, None])[0].reshape(-1, 3)


def largest(kind, kin, joints, path, most, *, least=FEWEST_INTERVALS):
    """How far the tip (`kind` 0) or the tool axis (1) strays at most from its path, and the first such move.

    `path`, (2, n - 1, 3), has the ends of the segment or arc that each move of the joints (n, 5) should follow;
    `most`, shape (n - 1,), is how far each may stray, from `bounds`; infinite where that is not known, negative for
    moves that do not count. What the samples may miss is added.
    """
    if not len(most):
        return 0.0, -1
    found, bound, few = np.zeros(len(most)), np.maximum(most, 0), len(most) // FIRST + 1
    promising = most >= np.partition(most, -few)[-few]
    for some in (promising, ~promising):
        moves = np.flatnonzero(some & (most > found.max()))
        ends = path[0][moves], path[1][moves]
        strayed = stray(kind, kin, joints[moves], joints[moves + 1], ends, least)
        found[moves] = np.minimum(strayed, bound[moves])
    error = min(found.max() + (RESOLUTION, AXIS_RESOLUTION)[kind], bound.max())
    return float(error), int(found.argmax())


def bounds(machine, joints, tips, axes, reached):
    """How far the moves of an ideal machine may stray, shape (2, n - 1), mm and radians.

    `tips` and `axes`, shape (n, 3), are where the path has them, `reached` where the joints (n, 5) have them.
    Between its ends a move strays from its chord by at most an eighth of its second derivative, which is Ω² for a
    unit vector that is turned by Ω in all. The great circle is off its own chord by an eighth of the square of what
    it spans.
    """
    ends = (np.linalg.norm(at - path, axis=1) for at, path in zip(reached, (tips, axes), strict=True))
    tip_off, axis_off = (np.maximum(off[:-1], off[1:]) for off in ends)
    turn = np.abs(np.diff(joints[:, 3:], axis=0)).sum(axis=1)
    axis = axis_off + (turn**2 + (turn + np.pi * axis_off) ** 2) / 8
    bend = derivative(machine, joints[:-1], joints[1:], 2) / 8
    return np.array([tip_off + bend, 2 * np.arcsin(np.minimum(axis / 2, 1))])


def derivative(machine, start, end, order):
    """What a derivative of the tip's way is at most, order 2 or 3, a move taking the time 1.

    A point at most r from the lines that it is turned about, by Ω, and moved by v has at most Ωⁿ·r + n·Ωⁿ⁻¹·v.
    """
    step = np.abs(end - start)
    turn, travel = step[:, 3:].sum(axis=1), step[:, :3].sum(axis=1)
    lever = levers(machine) + np.maximum(*(np.abs(at[:, :3]).sum(axis=1) for at in (start, end)))
    return turn ** (order - 1) * (turn * np.maximum(lever, LEVER) + order * travel)


def levers(machine):
    """All offsets of a machine end to end, mm: besides X Y Z, no point is further from a rotary axis."""
    head = 0 if isinstance(machine.programmed_point, str) else np.abs(machine.programmed_point).sum()
    pivots = sum(np.abs(rotary.point).sum() for rotary in machine.rotary)
    return np.abs(machine.origin).sum() + 2 * (machine.tool_length + pivots) + head


def _intervals(machine, start, end, least):
    """Into how many intervals the moves must be divided for parabolas through three samples; powers of two."""
    missed = derivative(machine, start, end, 3) / (9 * np.sqrt(3))  # h³ of it, by a parabola through points h apart
    # The least power of two, n, with n³ ≥ missed/RESOLUTION, which is below 2 to its binary exponent.
    _, exponent = np.frexp(missed / RESOLUTION)
    return np.left_shift(1, np.maximum(-(-exponent // 3), math.ceil(math.log2(least))))


def from_segment(points, start, end):
    """Distance of points (..., 3) from the segments between two others."""
    along, off = end - start, points - start
    squared = np.vecdot(along, along)
    t = np.clip(np.vecdot(off, along) / np.where(squared > 0, squared, 1), 0, 1)
    return np.linalg.norm(off - t[..., None] * along, axis=-1)


def from_arc(axes, start, end):
    """Angle of unit vectors (..., 3) from the shorter great circle arcs between two others."""
    along = end - start  # of neighbours only the differences keep their digits
    normal = np.cross(start, along)
    length = np.linalg.norm(normal, axis=-1)
    # No arc between opposite axes, nor between axes that differ by rounding, be it only in their own length.
    arc = length > 1e-15 + 1e-12 * np.linalg.norm(along, axis=-1)
    normal = normal / np.where(arc, length, 1)[..., None]
    from_start, from_end = axes - start, axes - end
    before = np.vecdot(from_start, np.cross(normal, start)) < 0
    behind = np.vecdot(from_end, np.cross(normal, end)) > 0
    half_chord = np.minimum(np.linalg.norm(from_start, axis=-1), np.linalg.norm(from_end, axis=-1)) / 2
    off_plane = np.abs(np.vecdot(from_start, normal))
    beside = arc & ~before & ~behind
    return np.where(beside, np.arcsin(np.minimum(off_plane, 1)), 2 * np.arcsin(np.minimum(half_chord, 1)))


def peak(values):
    """The largest of samples along the first axis, and of the parabolas through three that follow each other."""
    before, at, after = values[:-2], values[1:-1], values[2:]
    curvature, slope = before - 2 * at + after, np.abs(after - before)
    crest = slope <= -2 * curvature
    top = at - slope**2 / np.where(curvature < 0, 8 * curvature, -np.inf)
    return np.maximum(values.max(axis=0), np.where(crest, top, 0).max(axis=0))


@dataclass(frozen=True)
class Proof:
    """How far a program, read back from its own text, is from the CL data.

    Between the blocks the moves in cut count; a rapid one does not count for the tool axis.
    """

    tip_error: float  # largest at the records, mm,
    axis_error: float  # and of the tool axis, degrees
    path_tip_error: float  # from the CL segments, mm
    path_axis_error: float  # from the great circle arcs between the records, degrees
    worst_record: int  # (from 1) that the largest tip error of the path comes before or at


def prove(kin, cl, blocks, motion, tolerance, axis_tolerance, *, real=None, rapid_interpolated=True, left_out=()):
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
    if not rapid_interpolated:
        _refuse_unknown_way(cl, blocks, motion)
    _refuse_below_the_part(kin, cl, blocks, motion, tolerance, real)
    _refuse_collision(kin, cl, blocks, motion, real)
    _refuse_other_feeds(cl, blocks, motion)
    _refuse_too_fast(kin, cl, blocks, motion)
    return proof


def measured(kin, cl, blocks, motion, *, real=None, rapid_interpolated=True, left_out=()):
    """Return as `Proof` how far blocks that were read back are from the CL data, at the records and between them.

    `motion` says where on the CL path each block ends, and which are lifted; `real`, a `Compensator`, is the
    machine that runs the program, if it is not the one that its control knows. Where its rapid traverse is not
    interpolated, nobody knows the path of a rapid move, and only its end counts. Records that are `left_out` are
    pecks of holes, which the control makes by itself.
    """
    if len(blocks.words) != len(motion.place):
        raise MathpostError(f"{len(motion.place)} blocks were written and {len(blocks.words)} read back")
    machine, joints = real or kin, joints_of(kin, blocks)
    tips, axes = cl.at(motion.place)
    moves = len(joints) - 1
    least, most, off = LEAST_INTERVALS if real else FEWEST_INTERVALS, np.full((2, moves), np.inf), np.zeros(moves)
    # A record whose block was left out as a repetition has the pose of the block before.
    on_part = np.flatnonzero(~motion.lifted)
    wanted = np.delete(np.arange(len(cl)), np.asarray(left_out, int))
    at = on_part[np.searchsorted(motion.place[on_part], wanted, side="right") - 1]
    tip_error = chord = 0.0
    for rows in slices(joints.shape[:1]):
        poses = slice(rows.start, rows.stop + 1)  # that after the last move included
        reached = machine.forward(joints[poses])
        off[rows] = np.linalg.norm(reached[0] - tips[poses], axis=1)[1:]
        if not real:
            most[:, rows] = bounds(kin.machine, joints[poses], tips[poses], axes[poses], reached)
        some = slice(*np.searchsorted(at, [rows.start, rows.stop]))
        records = wanted[some]
        tip, axis = (np.take(each.T, at[some] - rows.start, axis=1) for each in reached)
        tip_error = max(tip_error, np.linalg.norm(tip - cl.points[records].T, axis=0).max(initial=0))
        chord = max(chord, np.linalg.norm(axis - cl.axes[records].T, axis=0).max(initial=0))
    off[~motion.in_cut], most[:, ~motion.in_cut] = 0, -1
    most[1, ~motion.at_feed(cl)] = -1
    if not rapid_interpolated:
        off[blocks.rapid[1:]], most[:, blocks.rapid[1:]] = 0, -1
    between = arcs(cl, motion.place[:-1], motion.place[1:])
    path_axis, _ = largest(1, machine, joints, between, most[1], least=least)
    straight = blocks.tcp[1:]  # the control keeps the tip on the straight line between the blocks
    off[~straight], most[0, straight] = 0, -1
    path_tip, worst = largest(0, machine, joints, (tips[:-1], tips[1:]), most[0], least=least)
    if off.max(initial=0) > path_tip:
        path_tip, worst = off.max(), int(off.argmax())

    axis_error = np.degrees(2 * np.arcsin(min(chord / 2, 1)))
    return Proof(
        tip_error=float(tip_error),
        axis_error=float(axis_error),
        path_tip_error=float(max(path_tip, tip_error)),  # the records are on the path
        path_axis_error=float(max(np.degrees(path_axis), axis_error)),
        worst_record=int(motion.record[worst + 1]) + 1,
    )


def joints_of(kin: Kinematics, blocks: Blocks) -> np.ndarray:
    """Return what the axes do, shape (n, 5), mm and radians: with TCP the control finds X Y Z itself."""
    joints = blocks.joints
    joints[blocks.tcp] = kin.close(joints[blocks.tcp, :3], joints[blocks.tcp, 3:])
    return joints


def _refuse_unknown_way(cl, blocks, motion):
    """A lifted move that is rapid would go where nobody knows."""
    rapid = np.flatnonzero(~motion.in_cut & blocks.rapid[1:])
    if rapid.size:
        record = cl.where(motion.place[rapid[0] + 1])
        raise MathpostError(f"{record}: a lifted move is rapid, and each axis would run at its own rate")


def _refuse_below_the_part(kin, cl, blocks, motion, tolerance, real):
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


def _spread(points):
    """The numbers of points that stand for all, one in each cube of a fifth of the body's radius; all of a few."""
    if len(points) <= MANY_POINTS:
        return np.arange(len(points))
    return np.sort(np.unique(np.round(points / (BODY / 5)), axis=0, return_index=True)[1])


def in_body(points: np.ndarray, tips: np.ndarray, axes: np.ndarray, length: float) -> np.ndarray:
    """Whether points (n, 3) are inside the body of the tool at any of m poses, tips and axes (m, 3); shape (n,).

    The body is a cylinder about the tool axis, `BODY` in radius, from the tip on, `length` mm long.
    """
    inside = np.zeros(len(points), bool)
    for tip, axis in zip(tips, axes, strict=True):
        off = points - tip
        along = off @ axis
        beside = np.vecdot(off, off) - along**2  # the square of the distance from the axis
        inside |= (along > 0) & (along < length) & (beside < BODY**2)
    return inside


def _refuse_collision(kin, cl, blocks, motion, real):
    """While the tool is off the part, its body must stay clear of the points that the path touches.

    What else there is of the part nobody knows here. Points that the body takes in cut where it leaves the part or
    comes back to it do not count, nor does the lift along the tool axis itself.
    """
    moves = np.flatnonzero(motion.lifted[:-1] & motion.lifted[1:])
    if not moves.size:
        return
    machine, joints = real or kin, joints_of(kin, blocks)
    length, records = max(kin.machine.tool_length, LEAST_BODY), _spread(cl.points)
    points = cl.points[records]
    on_part = np.flatnonzero(~motion.lifted)
    tips, axes = machine.forward(joints[on_part])
    for some, t, tip, axis in sampled(machine, joints[moves], joints[moves + 1], least=LEAST_INTERVALS):
        rows = moves[some]
        line = tip[0] + t[..., None] * (tip[-1] - tip[0])
        tip = np.where(blocks.tcp[rows + 1, None], line, tip)
        for n, move in enumerate(rows):
            hit = in_body(points, tip[:, n], axis[:, n], length)
            if not hit.any():
                continue
            after = np.searchsorted(on_part, move)
            ends = np.clip([after - 1, after], 0, len(on_part) - 1)
            hit &= ~in_body(points, tips[ends], axes[ends], np.inf)
            if hit.any():
                record = int(records[hit.argmax()])
                way = "to a safe position" if motion.far[move] else "lifted"
                touched = f"its body, {2 * BODY:g} mm across, meets the point of record {cl.first + record + 1}"
                raise MathpostError(f"{cl.where(motion.place[move + 1])}: on its way there, {way}, {touched}")


def _refuse_other_feeds(cl, blocks, motion):
    """On the part: rapid where the CL data are, and at their feed elsewhere, if no time is stated instead."""
    feeds, rapid = cl.feeds[motion.record], cl.rapid[motion.record]
    on_part = np.r_[~motion.lifted[0], motion.in_cut]
    by_feed = ~rapid & np.isnan(blocks.seconds) & ~np.isnan(feeds)
    as_it_is = (blocks.feeds <= feeds + 1e-9) & (blocks.feeds >= feeds - FEED_DIGITS)
    steps = np.diff(blocks.words, axis=0, prepend=blocks.words[:1])
    only_turns = blocks.tcp & ~steps[:, :3].any(axis=1) & steps[:, 3:].any(axis=1)  # F is not that of the tip
    wrong = on_part & ((blocks.rapid != rapid) | (by_feed & ~as_it_is & ~only_turns))
    if wrong.any():
        at = int(wrong.argmax())
        found = "rapid" if blocks.rapid[at] else f"feed {blocks.feeds[at]:g}"
        expected = "rapid" if rapid[at] else f"feed {feeds[at]:g}"
        raise MathpostError(f"{cl.where(motion.record[at])}: the CL data have {expected} and the program {found}")


def _refuse_too_fast(kin, cl, blocks, motion):
    """A block with a time takes as long as its way on the CL path at its feed, and as its slowest axis."""
    timed = 1 + np.flatnonzero(~np.isnan(blocks.seconds[1:]))
    seconds, feeds = blocks.seconds[timed], cl.feeds[motion.record[timed]]
    start, end = (cl.at(motion.place[rows])[0] for rows in (timed - 1, timed))
    by_feed = np.where(motion.in_cut[timed - 1], np.linalg.norm(end - start, axis=1) * 60 / feeds, 0)
    rates = kin.machine.max_rates * kin.machine.units
    if np.isnan(rates).all():
        rates = feeds[:, None] / 60
    steps = np.diff(joints_of(kin, blocks) * kin.machine.units, axis=0)[timed - 1]
    by_axis = np.nan_to_num(np.abs(steps) / rates).max(axis=1, initial=0)
    least = np.maximum(by_feed, by_axis)
    # A hundredth, a millisecond of FT, the fourth decimal of F in blocks a minute and of the axes are left open.
    fast = seconds < 0.99 * least - 0.001 - 1e-6 * seconds**2 - np.nan_to_num(0.012 / feeds)
    if fast.any():
        block = int(fast.argmax())
        taken = f"a block takes {seconds[block]:.3f} s, feed and axes need {least[block]:.3f} s at least"
        raise MathpostError(f"{cl.where(motion.record[timed[block]])}: {taken}")
