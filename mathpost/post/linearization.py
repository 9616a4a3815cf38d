"""Linearization (线性化): enough blocks to keep the tip on the CL path.

A move is divided in the *workpiece* (tip on the CL segment, rotary angles in equal steps, X Y Z recomputed), never
in the joints: source 002's equation (8) puts its points on the very line that the control already follows.
"""

from dataclasses import dataclass

import numpy as np

from mathpost.errors import ReachError
from mathpost.post.deviation import derivative, deviation, from_segment


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


def linearize(kin, joints, tolerance, *, max_pieces=4096, name="block"):
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
    error = derivative(kin.machine, start, end, 2) / 8
    if (doubtful := np.flatnonzero(error > tolerance)).size:
        error[doubtful] = deviation(kin, start[doubtful], end[doubtful], axes=False)[0]
    while (open_moves := np.flatnonzero(error > tolerance)).size:
        # The error falls with the square of the number of pieces.
        wanted = np.ceil(pieces[open_moves] * np.sqrt(error[open_moves] / tolerance[open_moves])).astype(int)
        pieces[open_moves] = np.maximum(pieces[open_moves] + 1, wanted)
        if pieces.max(initial=0) > max_pieces:
            move = int(pieces.argmax())
            raise ReachError(
                f"from {name} {move + 1} to {move + 2}: the tip strays {error[move]:.6f} mm, "
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
        claimed = from_segment(middle.T[:, None], tip[:-1].T, tip[1:].T)
        if claimed.max() <= tolerance:
            break
        halved = np.insert(joints, np.arange(1, len(joints)), (joints[:-1] + joints[1:]) / 2, axis=0)
        rows = list(halved)
    whole = np.broadcast_to(tip[[0, -1], None], (2, len(joints) - 1, 3))
    return joints, float(claimed.max()), float(deviation(kin, joints[:-1], joints[1:], tips=whole)[0].max())
