"""What the tool does between two blocks: how far tip and tool axis stray from the CL path.

A control without TCP moves all five joints linearly from block to block, so that the tip leaves the straight line
of the CL data, and the tool axis its great circle (nonlinear error, 非线性误差).
"""

import math

import numpy as np

from mathpost.rotation import BLOCK

RESOLUTION = 1e-5  # mm; what the samples of a move may miss of the way between them
CREST = 9 / 8  # how high above all of three values from 0 on a parabola through them may rise
FIRST = 64  # one of so many moves, those with the greatest bounds, is looked at before the others


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
    ways = [(from_segment, tips), (_from_great_circle, axes)]
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


def largest(kin, joints, tips, axes, *, reached, counted, least=2, bounded=True):
    """Return the largest `deviation` along a path, for all its moves but without a look at most of them.

    A bound tells how far a move may stray at most. The moves with the greatest bounds are looked at first; what may
    not stray as far as they do needs no look.

    Parameters
    ----------
    kin : Kinematics
    joints : ndarray, shape (n, 5)
        mm and radians.
    tips, axes : ndarray, shape (n, 3)
        Where the path has the tip, mm, and the tool axis. False leaves the tips out.
    reached : pair of ndarray, shape (n, 3)
        Where the joints have them.
    counted : ndarray of bool, shape (n - 1,)
        The moves that are asked for.
    least : int
        As in `deviation`.
    bounded : bool
        Whether `kin` is an ideal machine; if not there is no bound.

    Returns
    -------
    tip : float
        mm.
    move : int
        The first move that strays as far as that.
    axis : float
        Radians.
    """
    found = np.zeros((2, len(counted)))
    bounds = _bounds(kin.machine, joints, tips, axes, reached) if bounded else np.full(found.shape, np.inf)
    bounds[:, ~counted] = -1
    bounds[0] = -1 if tips is False else bounds[0]
    few = len(counted) // FIRST + 1
    moves = np.unique(np.argpartition(bounds, -few, axis=1)[:, -few:])
    moves = moves[counted[moves]]
    for _ in range(2):
        bounds[:, moves] = -1
        found[:, moves] = deviation(
            kin,
            *_ends(joints, moves),
            tips=False if tips is False else _ends(tips, moves),
            axes=_ends(axes, moves),
            reached=list(zip(*(_ends(at, moves) for at in reached), strict=True)),
            least=least,
        )
        moves = np.flatnonzero((bounds >= found.max(axis=1)[:, None]).any(axis=0))
    return float(found[0].max()), int(found[0].argmax()), float(found[1].max())


def _ends(poses, moves):
    """What poses (n, k) are at both ends of some moves, component by component in memory."""
    return [np.take(poses.T, place, axis=1).T for place in (moves, moves + 1)]


def _bounds(machine, joints, tips, axes, reached):
    """What `deviation` says of each move at most, shape (2, m): mm and radians.

    Between its ends a move strays from a chord by an eighth of its second derivative, Ω² for a unit vector that is
    turned by Ω in all, and the chord from that of the path by what the ends are off. The great circle is off its
    own chord by an eighth of the square of what it spans.
    """
    tip_off, axis_off = (
        0 if way is False else _at_ends(at - way) for at, way in zip(reached, (tips, axes), strict=True)
    )
    turn = np.abs(np.diff(joints[:, 3:], axis=0)).sum(axis=1)
    tip = tip_off + derivative(machine, joints[:-1], joints[1:], 2) / 8
    axis = axis_off + (turn**2 + (turn + np.pi * axis_off) ** 2) / 8
    return CREST * np.stack([tip, 2 * np.arcsin(np.minimum(axis / 2, 1))])


def _at_ends(vectors):
    """The greater length at both ends of each move, of vectors (n, 3) at the poses."""
    length = np.sqrt((vectors * vectors).sum(axis=1))
    return np.maximum(length[:-1], length[1:])


def _intervals(machine, start, end, least):
    """Into how many intervals the moves must be divided for parabolas through their ends and middles.

    A parabola through three points h apart misses h³/(9√3) of the third derivative.
    """
    missed = derivative(machine, start, end, 3) / (9 * np.sqrt(3))
    # The least power of two, n, with n³ ≥ missed/RESOLUTION, which is below 2 to its binary exponent.
    _, exponent = np.frexp(missed / RESOLUTION)
    return np.left_shift(1, np.maximum(-(-exponent // 3), math.ceil(math.log2(least))))


def derivative(machine, start, end, order):
    """Return what a derivative of the tip's way is at most, order 2 or 3, a move taking the time 1.

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


def from_segment(points, start, end):
    """Distance of points (3, k, m) from m segments between points (3, m)."""
    along, off = (end - start)[:, None], points - start[:, None]
    squared = (along * along).sum(axis=0)
    t = (off * along).sum(axis=0) / np.where(squared > 0, squared, 1)
    off -= np.minimum(np.maximum(t, 0), 1) * along
    return np.sqrt((off * off).sum(axis=0))


def _from_great_circle(axes, start, end):
    """Angle of unit vectors (3, k, m) from the m shorter arcs between unit vectors (3, m)."""
    # Of neighbours only the differences keep their digits. With D = end − start, s = axis − start and w = D²/2:
    # start × end = start × D, and by Lagrange's identity an axis is between the ends, its cross products with both
    # along the normal, if w·(s²/2) ≤ s·D ≤ w·(2 − (axis − end)²/2).
    along, from_start = end - start, axes - start[:, None]
    whole, to_start, to_end = map(_half_squared, (along, from_start, axes - end[:, None]))
    (a, b, c), (d, e, f) = start, along
    normal = np.stack([b * f - c * e, c * d - a * f, a * e - b * d])
    squared = (normal * normal).sum(axis=0)
    # No arc between opposite axes, nor between axes that differ by rounding, be it only in their own length.
    arc = squared > 1e-30 + 1e-24 * whole
    normal /= np.sqrt(np.where(arc, squared, 1))
    off_plane = np.abs((from_start * normal[:, None]).sum(axis=0))
    done = (from_start * along[:, None]).sum(axis=0)
    beyond = ~arc | (done < whole * to_start) | (done > whole * (2 - to_end))
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
