"""Linearization: what the tool does between two blocks, and enough blocks to keep it on the CL path.

A control without TCP moves all five joints linearly from block to block, so that the tip leaves the straight
line of the CL data (nonlinear error, 非线性误差). The cure is to divide the move in the *workpiece* (tip on the CL
segment, rotary angles in equal steps, X Y Z recomputed), never in the joints: source 002's equation (8) puts its
points on the very line that the control already follows.
"""

import math
from dataclasses import dataclass

import numpy as np

from mathpost.errors import ReachError
from mathpost.rotation import BLOCK

RESOLUTION = 1e-5  # mm; what the samples of a move may miss of the way between them


@dataclass(frozen=True)
class Linearized:
    """A sequence of joints dense enough for a tolerance.

    Attributes
    ----------
    joints : ndarray, shape (m, 5)
        mm and radians.
    place : ndarray, shape (m,)
        Where each stands in the sequence that was given: 2.25 is a quarter of the way from row 2 to row 3.
    error : ndarray, shape (n - 1,)
        The largest distance (mm) of the tip from its segment, for each move that was given; where a bound tells
        that the tolerance is kept, that bound.
    """

    joints: np.ndarray
    place: np.ndarray
    error: np.ndarray


def deviation(kin, start, end, *, tips=None, axes=None, reached=None, samples=None, least=2):
    """Return how far the tip and the tool axis stray when all joints move linearly.

    Between its samples a move is taken for a parabola; there are as many samples as it takes to miss no more than
    `RESOLUTION` by that.

    Parameters
    ----------
    kin : Kinematics
    start, end : array_like, shape (m, 5)
        Joints at both ends of m moves, mm and radians.
    tips : array_like, shape (2, m, 3), optional
        Ends of the straight segments that the tips should follow, mm; by default the tips at both ends.
    axes : array_like, shape (2, m, 3), optional
        Ends of the great circles that the tool axes should follow; by default the axes at both ends. False leaves
        the axes out, for half the work.
    reached : pair of pairs of ndarray, shape (m, 3), optional
        Tips and axes at `start`, and at `end`, if they are known already.
    samples : int, optional
        Intervals per move, for a check that is denser than the default.
    least : int
        The fewest intervals that a move has by default.

    Returns
    -------
    tip, axis : ndarray, shape (m,)
        Largest distance in mm from the segment, and largest angle in radians from the great circle; 0 if left out.

    Examples
    --------
    Half a turn of C about a tip 77 mm from its axis: the tip cuts straight across.

    >>> from mathpost import machine
    >>> from mathpost.kinematics import Kinematics
    >>> kin = Kinematics(machine.load("data/machines/dmu50v.toml"))
    >>> ends = kin.close([77.0, 0, 0], [[0, 0], [0, np.pi]])
    >>> tip, axis = deviation(kin, ends[:1], ends[1:])
    >>> f"{tip[0]:.3f} mm"
    '77.000 mm'
    """
    start, end = np.asarray(start, dtype=float), np.asarray(end, dtype=float)
    reached = (kin.forward(start), kin.forward(end)) if reached is None else reached
    ways = [(_from_segment, tips), (_from_great_circle, axes)]
    result = np.zeros((2, len(start)))
    intervals = np.full(len(start), samples) if samples else _intervals(kin.machine, start, end, least)
    for part, count in _batches(intervals):
        t = np.linspace(0, 1, count + 1)[1:-1, None, None]
        between = kin.forward(start[part] + t * (end[part] - start[part]))
        for row, (distance, wanted) in enumerate(ways):
            if wanted is False:
                continue
            ends = [at[row][part].T for at in reached]
            points = np.empty((3, count + 1, len(ends[0][0])))
            points[:, 0], points[:, 1:-1], points[:, -1] = ends[0], np.moveaxis(between[row], -1, 0), ends[1]
            segment = ends if wanted is None else [at[part].T for at in wanted]
            result[row, part] = _peak(distance(points, *segment))
    return result[0], result[1]


def _intervals(machine, start, end, least):
    """Into how many intervals the moves must be divided for parabolas through their ends and middles.

    A parabola through three points h apart misses h³/(9√3) of the third derivative.
    """
    missed = _derivative(machine, start, end, 3) / (9 * np.sqrt(3))
    # The least power of two, n, with n³ ≥ missed/RESOLUTION, which is below 2 to its binary exponent.
    _, exponent = np.frexp(missed / RESOLUTION)
    return np.left_shift(1, np.maximum(-(-exponent // 3), math.ceil(math.log2(least))))


def _derivative(machine, start, end, order):
    """What a derivative of the tip's way is at most, order 2 or 3, a move taking the time 1.

    A point at most r from the lines that it is turned about, by Ω in all, and moved by v in all, has derivatives of
    at most Ωⁿ·r + n·Ωⁿ⁻¹·v.
    """
    step = np.abs(end - start)
    turn, travel = step[:, 3] + step[:, 4], step[:, 0] + step[:, 1] + step[:, 2]
    lever = levers(machine) + np.maximum(*(np.abs(at[:, :3]).sum(axis=1) for at in (start, end)))
    return turn ** (order - 1) * (turn * lever + order * travel)


def levers(machine):
    """All offsets of a machine end to end, mm: X Y Z aside, no point is further than this from a rotary axis."""
    head = 0 if isinstance(machine.programmed_point, str) else np.abs(machine.programmed_point).sum()
    pivots = sum(np.abs(rotary.point).sum() for rotary in machine.rotary)
    return np.abs(machine.origin).sum() + 2 * (machine.tool_length + pivots) + head


def _batches(intervals):
    """Yield the moves of each number of intervals, as many at a time as a formula takes, and that number."""
    counts = np.flatnonzero(np.bincount(intervals)).tolist()
    for count in counts:
        moves = np.flatnonzero(intervals == count) if len(counts) > 1 else np.arange(len(intervals))
        size = max(1, BLOCK // count)
        for part in (moves[first : first + size] for first in range(0, len(moves), size)):
            in_a_row = part[-1] - part[0] == len(part) - 1
            yield slice(part[0], part[-1] + 1) if in_a_row else part, count


def true_tip(kin, joints, *, samples=24):
    """Return where the tip goes when all joints move linearly, and the points of the straight segments beside it.

    Parameters
    ----------
    kin : Kinematics
    joints : array_like, shape (n, 5)
        mm and radians.
    samples : int
        Intervals between two rows.

    Returns
    -------
    tip, chord : ndarray, shape ((n - 1) * (samples + 1), 3)
        mm, in the workpiece.
    """
    joints = np.asarray(joints, dtype=float)
    t = np.linspace(0, 1, samples + 1)[:, None]
    between = joints[:-1, None] + t * np.diff(joints, axis=0)[:, None]
    ends = kin.forward(joints)[0]
    chord = ends[:-1, None] + t * np.diff(ends, axis=0)[:, None]
    return kin.forward(between)[0].reshape(-1, 3), chord.reshape(-1, 3)


def subdivide(kin, start, end, pieces):
    """Divide moves evenly: tip on the segment, rotary angles in equal steps, X Y Z recomputed.

    Parameters
    ----------
    kin : Kinematics
    start, end : array_like, shape (m, 5)
        Joints at both ends of each move, mm and radians.
    pieces : int or array_like, shape (m,)
        How many pieces each move is divided into.

    Returns
    -------
    joints : ndarray, shape (sum of pieces, 5)
        The end of every piece, one move after the other.
    place : ndarray, shape (sum of pieces,)
        Number of the move plus the part of it that is done: 2.25 is a quarter of the third move.
    """
    start, end = np.asarray(start, dtype=float), np.asarray(end, dtype=float)
    pieces = np.broadcast_to(pieces, len(start))
    move = np.repeat(np.arange(len(start)), pieces)
    step = np.arange(1, len(move) + 1) - np.repeat(np.cumsum(pieces) - pieces, pieces)
    t, joints = step / pieces[move], end[move]
    inner = np.flatnonzero(t < 1)
    of, part = move[inner], t[inner, None]
    first, last = kin.forward(start[of])[0], kin.forward(end[of])[0]
    joints[inner] = kin.close(first + part * (last - first), start[of, 3:] + part * (end - start)[of, 3:])
    return joints, move + t


def linearize(kin, joints, tolerance, *, max_pieces=4096, name="block", before=0):
    """Divide every move until the tip stays within `tolerance` of the straight segment between its ends.

    Parameters
    ----------
    kin : Kinematics
    joints : array_like, shape (n, 5)
        mm and radians.
    tolerance : float or array_like, shape (n - 1,)
        mm; for all moves, or for each.
    max_pieces : int
        The most pieces that one move may be divided into.
    name : str
        What a row is called in an error message.
    before : int
        How many rows come before these, for an error message.

    Returns
    -------
    Linearized

    Raises
    ------
    ReachError
        If a move does not meet the tolerance with `max_pieces`; names it.
    """
    joints = np.asarray(joints, dtype=float)
    start, end = joints[:-1], joints[1:]
    pieces = np.ones(len(start), dtype=int)
    tolerance = np.broadcast_to(tolerance, len(start))
    # A curve leaves its chord by at most an eighth of its second derivative: most moves need no closer look.
    error = _derivative(kin.machine, start, end, 2) / 8
    doubtful = np.flatnonzero(error > tolerance)
    error[doubtful] = deviation(kin, start[doubtful], end[doubtful], axes=False)[0]
    while (open_moves := np.flatnonzero(error > tolerance)).size:
        # The error falls with the square of the number of pieces.
        wanted = np.ceil(pieces[open_moves] * np.sqrt(error[open_moves] / tolerance[open_moves])).astype(int)
        pieces[open_moves] = np.maximum(pieces[open_moves] + 1, wanted)
        if pieces.max(initial=0) > max_pieces:
            move = int(pieces.argmax())
            raise ReachError(
                f"from {name} {before + move + 1} to {before + move + 2}: the tip strays {error[move]:.6f} mm, "
                f"more than {tolerance[move]:g} mm, and {max_pieces} pieces are not enough"
            )
        ends, place = subdivide(kin, start[open_moves], end[open_moves], pieces[open_moves])
        firsts = np.flatnonzero(np.r_[True, place[:-1] % 1 == 0])
        starts = np.roll(ends, 1, axis=0)
        starts[firsts] = start[open_moves]
        error[open_moves] = np.maximum.reduceat(deviation(kin, starts, ends, axes=False)[0], firsts)
    if (pieces == 1).all():
        return Linearized(joints, np.arange(len(joints), dtype=float), error)
    divided, place = subdivide(kin, start, end, pieces)
    return Linearized(np.concatenate([joints[:1], divided]), np.r_[0.0, place], error)


def equation_8(kin, start, end, tolerance, *, max_depth=12):
    """Divide a move by equation (8) of source 002 taken literally, for the audit only.

    The new points lie on the line in joint space, and each half is measured at its middle against its own chord.

    Returns
    -------
    joints : ndarray, shape (pieces + 1, 5)
        "Converged" by its own measure.
    claimed, true : float
        The largest error by that measure, and that against the segment of the whole move, mm.
    """
    rows = [np.asarray(start, dtype=float), np.asarray(end, dtype=float)]
    for _ in range(max_depth):
        joints = np.array(rows)
        tip = kin.forward(joints)[0]
        middle = kin.forward((joints[:-1] + joints[1:]) / 2)[0]
        claimed = _from_segment(middle.T[:, None], tip[:-1].T, tip[1:].T)
        if claimed.max() <= tolerance:
            break
        halved = np.insert(joints, np.arange(1, len(joints)), (joints[:-1] + joints[1:]) / 2, axis=0)
        rows = list(halved)
    whole = np.broadcast_to(tip[[0, -1], None], (2, len(joints) - 1, 3))
    return joints, float(claimed.max()), float(deviation(kin, joints[:-1], joints[1:], tips=whole)[0].max())


def _from_segment(points, start, end):
    """Distance of points (3, k, m) from m segments between points (3, m)."""
    along, off = (end - start)[:, None], points - start[:, None]
    squared = (along * along).sum(axis=0)
    t = (off * along).sum(axis=0) / np.where(squared > 0, squared, 1)
    off -= np.minimum(np.maximum(t, 0), 1) * along
    return np.sqrt((off * off).sum(axis=0))


def _from_great_circle(axes, start, end):
    """Angle of unit vectors (3, k, m) from the m shorter arcs between unit vectors (3, m)."""
    (a, b, c), (d, e, f) = start, end
    normal = np.stack([b * f - c * e, c * d - a * f, a * e - b * d])
    length = np.sqrt((normal * normal).sum(axis=0))
    arc = length > 1e-12
    normal /= np.where(arc, length, 1)
    off_plane = np.abs((axes * normal[:, None]).sum(axis=0))
    # Between the ends are the axes whose cross products with both point along the normal, by Lagrange's identity
    # (start × axis)·(start × end) = axis·end − (start·end)(axis·start), and alike at the other end. Scalar products
    # of neighbours keep their digits as what is missing to one: half of the squared chord.
    whole, to_start, to_end = (
        _half_squared(one) for one in (end - start, axes - start[:, None], axes - end[:, None])
    )
    beyond = ~arc | (to_end > whole + to_start - whole * to_start) | (to_start > whole + to_end - whole * to_end)
    half_chord = np.sqrt(np.minimum(to_start, to_end) / 2)
    return np.where(beyond, 2, 1) * np.arcsin(np.minimum(np.where(beyond, half_chord, off_plane), 1))


def _half_squared(vectors):
    return (vectors * vectors).sum(axis=0) / 2


def _peak(values):
    """The largest of samples along the first axis, and of the parabolas through three that follow each other."""
    before, at, after = values[:-2], values[1:-1], values[2:]
    curvature, slope = before - 2 * at + after, np.abs(after - before)
    crest = slope <= -2 * curvature
    top = at - slope**2 / np.where(curvature < 0, 8 * curvature, -np.inf)
    return np.maximum(values.max(axis=0), np.where(crest, top, 0).max(axis=0))
