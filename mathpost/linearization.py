"""Linearization: what the tool does between two blocks, and enough blocks to keep it on the CL path.

A control without TCP moves all five joints linearly from block to block, so that the tip leaves the straight
line of the CL data (nonlinear error, 非线性误差). The cure is to divide the move in the *workpiece* (tip on the CL
segment, rotary angles in equal steps, X Y Z recomputed), never in the joints: source 002's equation (8) puts its
points on the very line that the control already follows.
"""

from dataclasses import dataclass

import numpy as np

from mathpost.errors import ReachError

SAMPLES = 16  # intervals of a move of up to 10 degrees; the peak between samples is interpolated by a parabola
DEGREES_PER_SAMPLE = 0.625


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
        The largest distance (mm) of the tip from its segment, for each move that was given.
    """

    joints: np.ndarray
    place: np.ndarray
    error: np.ndarray


def deviation(kin, start, end, *, tips=None, axes=None, samples=None):
    """Return how far the tip and the tool axis stray when all joints move linearly.

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
    samples : int, optional
        Intervals per move, for a check that is denser than the default.

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
    if tips is None:
        tips = kin.forward(start)[0], kin.forward(end)[0]
    if axes is None:
        axes = kin.forward(start)[1], kin.forward(end)[1]
    result = np.zeros((2, len(start)))
    swing = np.rad2deg(np.abs(end - start)[:, 3:].max(axis=1, initial=0))
    wanted = np.maximum(SAMPLES, swing / DEGREES_PER_SAMPLE)
    intervals = np.full(len(start), samples) if samples else 2 ** np.ceil(np.log2(wanted)).astype(int)
    for count in np.unique(intervals):
        moves = np.flatnonzero(intervals == count)
        for part in np.array_split(moves, max(1, len(moves) * count // 200_000)):
            t = np.linspace(0, 1, count + 1)[:, None, None]
            tip, axis = kin.forward(start[part] + t * (end[part] - start[part]))
            result[0, part] = _peak(_from_segment(tip, tips[0][part], tips[1][part]))
            if axes is not False:
                result[1, part] = _peak(_from_great_circle(axis, axes[0][part], axes[1][part]))
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
    t = (step / pieces[move])[:, None]
    first, last = kin.forward(start)[0][move], kin.forward(end)[0][move]
    joints = kin.close(first + t * (last - first), start[move, 3:] + t * (end - start)[move, 3:])
    return np.where(t == 1, end[move], joints), move + t[:, 0]


def linearize(kin, joints, tolerance, *, max_pieces=4096, name="block"):
    """Divide every move until the tip stays within `tolerance` of the straight segment between its ends.

    Parameters
    ----------
    kin : Kinematics
    joints : array_like, shape (n, 5)
        mm and radians.
    tolerance : float
        mm.
    max_pieces : int
        The most pieces that one move may be divided into.
    name : str
        What a row is called in an error message.

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
    error = deviation(kin, start, end, axes=False)[0]
    while (open_moves := np.flatnonzero(error > tolerance)).size:
        # The error falls with the square of the number of pieces.
        wanted = np.ceil(pieces[open_moves] * np.sqrt(error[open_moves] / tolerance)).astype(int)
        pieces[open_moves] = np.maximum(pieces[open_moves] + 1, wanted)
        if pieces.max(initial=0) > max_pieces:
            move = int(pieces.argmax())
            raise ReachError(
                f"from {name} {move + 1} to {move + 2}: the tip strays {error[move]:.6f} mm, more than "
                f"{tolerance} mm, and {max_pieces} pieces are not enough"
            )
        ends, place = subdivide(kin, start[open_moves], end[open_moves], pieces[open_moves])
        firsts = np.flatnonzero(np.r_[True, place[:-1] % 1 == 0])
        starts = np.roll(ends, 1, axis=0)
        starts[firsts] = start[open_moves]
        error[open_moves] = np.maximum.reduceat(deviation(kin, starts, ends, axes=False)[0], firsts)
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
        claimed = _from_segment(middle, tip[:-1], tip[1:])
        if claimed.max() <= tolerance:
            break
        halved = np.insert(joints, np.arange(1, len(joints)), (joints[:-1] + joints[1:]) / 2, axis=0)
        rows = list(halved)
    whole = np.broadcast_to(tip[[0, -1], None], (2, len(joints) - 1, 3))
    return joints, float(claimed.max()), float(deviation(kin, joints[:-1], joints[1:], tips=whole)[0].max())


def _from_segment(points, start, end):
    """Distance of points from segments, broadcasting."""
    along = end - start
    squared = (along * along).sum(axis=-1)
    t = ((points - start) * along).sum(axis=-1) / np.where(squared > 0, squared, 1)
    return np.linalg.norm(points - start - np.clip(t, 0, 1)[..., None] * along, axis=-1)


def _from_great_circle(axis, start, end):
    """Angle of unit vectors from the shorter arc between two unit vectors, broadcasting."""
    normal = np.cross(start, end)
    length = np.linalg.norm(normal, axis=-1)
    arc = length > 1e-12
    normal = normal / np.where(arc, length, 1)[..., None]
    off_plane = np.arcsin(np.clip(np.abs((axis * normal).sum(axis=-1)), 0, 1))
    after_start = (np.cross(start, axis) * normal).sum(axis=-1) >= 0
    before_end = (np.cross(axis, end) * normal).sum(axis=-1) >= 0
    to_ends = np.minimum(np.linalg.norm(axis - start, axis=-1), np.linalg.norm(axis - end, axis=-1))
    return np.where(arc & after_start & before_end, off_plane, 2 * np.arcsin(np.clip(to_ends / 2, 0, 1)))


def _peak(values):
    """The largest of samples along the first axis, with a parabola through the three about it."""
    index = np.clip(values.argmax(axis=0), 1, len(values) - 2)
    columns = np.arange(values.shape[1])
    before, at, after = (values[index + step, columns] for step in (-1, 0, 1))
    curvature = before - 2 * at + after
    top = at - (after - before) ** 2 / np.where(curvature < 0, 8 * curvature, -np.inf)
    return np.maximum(values.max(axis=0), np.where(np.abs(after - before) <= -2 * curvature, top, 0))
