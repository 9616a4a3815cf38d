"""Between two blocks: how far the tip strays from the CL segment, and the tool axis from its great circle.

A control without TCP moves all five joints linearly from block to block, so that tip and tool axis leave the path
of the CL data (nonlinear error, 非线性误差).
"""

import math

import numpy as np

from mathpost.rotation import slices

RESOLUTION = 1e-5  # mm; what the samples of a move may miss of the way between them
LEVER = 50.0  # mm; the least lever that samples are counted for, for the sake of the tool axis
AXIS_RESOLUTION = RESOLUTION / LEVER  # radians; what they may miss of the tool axis
FIRST = 64  # one of so many moves, those with the greatest bounds, is looked at before the others


def deviation(kin, start, end, *, tips=None, axes=None, samples=None, least=2):
    """Return how far the tip and the tool axis stray when all joints move linearly.

    Parameters
    ----------
    kin : Kinematics
        Anything with its `forward` and `machine`.
    start, end : array_like, shape (m, 5)
        Joints at both ends of m moves, mm and radians.
    tips, axes : array_like, shape (2, m, 3), optional
        Ends of the segments that the tips (mm), and of the great circles that the tool axes should follow; by
        default where the joints at both ends have them.
    samples : int, optional
        Intervals per move. By default there are at least `least`, and as many as it takes to miss no more than
        `RESOLUTION` where the move is taken for a parabola between its samples.

    Returns
    -------
    tip, axis : ndarray, shape (m,)
        Largest distance in mm from the segment, and largest angle in radians from the great circle.

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
    tip_error, axis_error = np.zeros((2, len(start)))
    for moves, _, tip, axis in sampled(kin, start, end, samples, least):
        segment = tip[[0, -1]] if tips is None else (tips[0][moves], tips[1][moves])
        arc = axis[[0, -1]] if axes is None else (axes[0][moves], axes[1][moves])
        tip_error[moves] = _peak(from_segment(tip, *segment))
        axis_error[moves] = _peak(from_arc(axis, *arc))
    return tip_error, axis_error


def tip_deviation(kin, start, end):
    """Return the first half of `deviation`, for half the work."""
    error = np.zeros(len(start))
    for moves, _, tip, _ in sampled(kin, start, end):
        error[moves] = _peak(from_segment(tip, tip[0], tip[-1]))
    return error


def axis_lag(kin, cl, start, end, place, place_after):
    """Return how far the tool axis is at most, radians, from where `cl` has it at the same part of each move.

    It is no less than the angle from the great circle, `deviation`: along it, too, the tool axis keeps up.
    """
    error = np.zeros(len(start))
    for moves, t, _, axis in sampled(kin, start, end):
        _, wanted = cl.at(place[moves] + t * (place_after - place)[moves])
        error[moves] = 2 * np.arcsin(np.minimum(_peak(np.linalg.norm(axis - wanted, axis=-1)) / 2, 1))
    return error + AXIS_RESOLUTION


def sampled(kin, start, end, samples=None, least=2):
    """Yield k moves at a time: their numbers (k,), t from 0 to 1 (intervals + 1, 1), tips and axes (…, k, 3)."""
    start, end = np.asarray(start, dtype=float), np.asarray(end, dtype=float)
    intervals = np.full(len(start), samples) if samples else _intervals(kin.machine, start, end, least)
    for count in np.unique(intervals).tolist():
        t = np.linspace(0, 1, count + 1)[:, None]
        alike = np.flatnonzero(intervals == count)
        for rows in slices((len(alike), count + 1)):
            moves = alike[rows]
            yield moves, t, *kin.forward(start[moves] + t[..., None] * (end[moves] - start[moves]))


def true_tip(kin, joints, *, samples=24):
    """Return where the tip goes when the joints (n, 5) move linearly, and the points of the segments beside it.

    Both have the shape ((n - 1) * (samples + 1), 3), mm.
    """
    t = np.linspace(0, 1, samples + 1)[:, None]
    between, ends = (
        each[:-1, None] + t * np.diff(each, axis=0)[:, None]
        for each in (np.asarray(joints, dtype=float), kin.forward(joints)[0])
    )
    return kin.forward(between)[0].reshape(-1, 3), ends.reshape(-1, 3)


def largest(kind, kin, joints, path, most, *, least=2):
    """How far the tip (`kind` 0) or the tool axis (1) strays at most from `path` (n, 3), and the first such move.

    `most`, shape (n - 1,), is how far each move may stray, from `bounds`; infinite where that is not known,
    negative for moves that do not count. Looks first at the moves that may stray most, then only at those that may
    stray further than these have. What the samples may miss is added; without moves the number is -1.
    """
    if not len(most):
        return 0.0, -1
    found, bound = np.zeros(len(most)), np.maximum(most, 0)

    def look(moves):
        for some, _, *tool in sampled(kin, joints[moves], joints[moves + 1], least=least):
            at = moves[some]
            peak = _peak((from_segment, from_arc)[kind](tool[kind], path[at], path[at + 1]))
            found[at] = np.minimum(peak, bound[at])

    few = len(most) // FIRST + 1
    promising = np.argpartition(most, -few)[-few:]
    look(promising[most[promising] >= 0])
    most[promising] = -1
    look(np.flatnonzero(most > found.max()))
    error = min(found.max() + (RESOLUTION, AXIS_RESOLUTION)[kind], bound.max())
    return float(error), int(found.argmax())


def bounds(machine, joints, tips, axes, reached):
    """Return how far the moves of an ideal machine may stray, shape (2, n - 1): mm and radians.

    Between its ends a move strays from its chord by at most an eighth of its second derivative, which is Ω² for a
    unit vector that is turned by Ω in all. The chord strays from that of the path by what the ends are off. The
    great circle is off its own chord by an eighth of the square of what it spans.

    `tips` and `axes`, shape (n, 3), are where the path has them, `reached` where the joints (n, 5) have them.
    """
    ends = (np.linalg.norm(at - path, axis=1) for at, path in zip(reached, (tips, axes), strict=True))
    tip_off, axis_off = (np.maximum(off[:-1], off[1:]) for off in ends)
    turn = np.abs(np.diff(joints[:, 3:], axis=0)).sum(axis=1)
    axis = axis_off + (turn**2 + (turn + np.pi * axis_off) ** 2) / 8
    bend = derivative(machine, joints[:-1], joints[1:], 2) / 8
    return np.array([tip_off + bend, 2 * np.arcsin(np.minimum(axis / 2, 1))])


def derivative(machine, start, end, order):
    """What a derivative of the tip's way is at most, order 2 or 3, a move taking the time 1.

    A point at most r from the lines that it is turned about, by Ω in all, and moved by v in all, has derivatives of
    at most Ωⁿ·r + n·Ωⁿ⁻¹·v.
    """
    result, offsets = np.empty(len(start)), levers(machine)
    for rows in slices(result.shape):
        step = np.abs(end[rows] - start[rows])
        turn, travel = step[:, 3:].sum(axis=1), step[:, :3].sum(axis=1)
        lever = offsets + np.maximum(*(np.abs(at[rows, :3]).sum(axis=1) for at in (start, end)))
        result[rows] = turn ** (order - 1) * (turn * np.maximum(lever, LEVER) + order * travel)
    return result


def levers(machine):
    """Return all offsets of a machine end to end, mm: besides X Y Z, no point is further from a rotary axis."""
    head = 0 if isinstance(machine.programmed_point, str) else np.abs(machine.programmed_point).sum()
    pivots = sum(np.abs(rotary.point).sum() for rotary in machine.rotary)
    return np.abs(machine.origin).sum() + 2 * (machine.tool_length + pivots) + head


def _intervals(machine, start, end, least):
    """Into how many intervals the moves must be divided for parabolas through three samples; powers of two.

    A parabola through three points h apart misses h³/(9√3) of the third derivative.
    """
    missed = derivative(machine, start, end, 3) / (9 * np.sqrt(3))
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


def _peak(values):
    """The largest of samples along the first axis, and of the parabolas through three that follow each other."""
    before, at, after = values[:-2], values[1:-1], values[2:]
    curvature, slope = before - 2 * at + after, np.abs(after - before)
    crest = slope <= -2 * curvature
    top = at - slope**2 / np.where(curvature < 0, 8 * curvature, -np.inf)
    return np.maximum(values.max(axis=0), np.where(crest, top, 0).max(axis=0))
