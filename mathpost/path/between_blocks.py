"""Between two blocks: moves are divided until the tip and the tool axis keep their tolerances.

A control without TCP moves all five joints linearly from block to block: tip and tool axis leave the CL path. First
`follow` puts poses on the great circle of the tool axis. Then linearization (线性化) divides a move in the
*workpiece*: tip on the CL segment, rotary angles in equal steps, X Y Z recomputed.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from mathpost.errors import ReachError
from mathpost.path import singular
from mathpost.path.deviation import AXIS_RESOLUTION, FEWEST_INTERVALS, TIP, derivative, peak, sampled, stray
from mathpost.path.dynamic_programming import nearest
from mathpost.path.motion import ON_PART, Motion
from mathpost.rotation import angle_of_chord

if TYPE_CHECKING:
    from mathpost.kinematics import ForwardKinematics, Kinematics
    from mathpost.path.cl import CLData

LOST = 1 / 8  # of the axis tolerance: a move that spans less and strays more does not go along its great circle
AIR = 0.1  # of the clearance, how far a lifted tip may stray


def axis_lag(
    kin: ForwardKinematics, cl: CLData, start: np.ndarray, end: np.ndarray, place: np.ndarray,
    place_after: np.ndarray, least: int = FEWEST_INTERVALS,
) -> np.ndarray:  # fmt: skip
    """How far the tool axis is at most, radians, from where `cl` has it at the same part of each move.

    Not less than its distance from the arc between the records, which is what a proof measures.
    """
    error = np.zeros(len(start))
    for moves, t, _, axis in sampled(kin, start, end, least):
        _, wanted = cl.at(place[moves] + t * (place_after - place)[moves])
        error[moves] = angle_of_chord(peak(np.linalg.norm(axis - wanted, axis=-1)))
    return error + AXIS_RESOLUTION


def follow(kin: Kinematics, cl: CLData, motion: Motion, tolerance: float, *, free: ArrayLike = False) -> Motion:
    """Divide every move in cut that is not `free` until the tool axis keeps `tolerance` of its great circle.

    Moves are halved on the great circle. Where it meets a singular tool axis, one pose is put just before and one
    just after it: between them the workpiece-side axis turns while the tool axis hardly moves. `ReachError` if the
    joints cannot follow the great circle, for example where they change the branch.
    """
    joints, place, kind = motion.joints, motion.place, motion.kind
    # An axis turned by Ω leaves its chord by at most Ω²/8, and so does the great circle: few need a closer look.
    turned = np.abs(np.diff(joints[:, 3:], axis=0)).sum(axis=1)
    todo = motion.at_feed(cl) & ~np.asarray(free) & (turned**2 / 4 > tolerance)
    while True:
        moves = np.flatnonzero(todo)
        error = np.zeros(len(todo))
        error[moves] = axis_lag(kin, cl, joints[moves], joints[moves + 1], place[moves], place[moves + 1])
        todo = error > tolerance
        if not todo.any():
            return Motion(joints, place, kind)
        moves = np.flatnonzero(todo)
        start, end = (cl.at(place[at])[1] for at in (moves, moves + 1))
        lost = moves[np.linalg.norm(end - start, axis=1) < LOST * tolerance]
        if lost.size:
            strayed, most = np.degrees([error[lost[0]], tolerance])
            where = f"{cl.where(place[lost[0] + 1])}: on its way there the tool axis lags"
            far = f"by {strayed:.3f}° on its great circle, more than {most:.2g}°"
            raise ReachError(f"{where} {far}, however often the move is divided")
        of, at, beside = _cuts(kin, joints[moves], joints[moves + 1], start, end, singular.STILL * tolerance)
        of, at = moves[of], place[moves[of]] + at * np.diff(place)[moves[of]]
        joints = np.insert(joints, of + 1, _pose(kin, cl, at, beside), axis=0)
        place, kind = np.insert(place, of + 1, at), np.insert(kind, of + 1, ON_PART)
        todo = np.insert(todo, of, True)


def _cuts(
    kin: Kinematics, start: np.ndarray, end: np.ndarray, start_axis: np.ndarray, end_axis: np.ndarray, still: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the move that each cut divides, the fraction of it, and joints nearby: of an end, or the mean."""
    t, distance = singular.nearest(kin, start_axis, end_axis)
    aside = 2 * still / np.maximum(np.linalg.norm(end_axis - start_axis, axis=1), 1e-300)
    meets = distance < still
    part = np.where(meets, [t - aside, t + aside], 0.5)
    beside = np.where(meets[:, None], [start, end], (start + end) / 2)
    move, side = np.nonzero(((part > 0) & (part < 1) & [np.ones_like(meets), meets]).T)
    return move, part[side, move], beside[side, move]


def _pose(kin: Kinematics, cl: CLData, place: np.ndarray, beside: np.ndarray) -> np.ndarray:
    """Joints on the CL path, on the branch and in the windings of those beside them."""
    second = np.zeros(len(beside), dtype=bool)
    if kin.tool_side is not None:
        second = np.sin(beside[:, kin.tool_side] - float(sum(kin.inverse_symbolic.solutions) / 2)) < 0
    joints = kin.inverse(*cl.at(place))[np.arange(len(place)), second.astype(int)]
    if (lost := np.isnan(joints).any(axis=1)).any():
        raise ReachError(f"{cl.where(place[lost.argmax()])}: on its way there the tool axis is out of reach")
    joints[:, 3:] = beside[:, 3:] + nearest(joints[:, 3:] - beside[:, 3:])
    return joints


def subdivide(
    kin: Kinematics, start: np.ndarray, end: np.ndarray, pieces: ArrayLike
) -> tuple[np.ndarray, np.ndarray]:
    """Divide moves evenly: tip on the segment, rotary angles in equal steps, X Y Z recomputed.

    `start` and `end`, shape (m, 5), are the joints at both ends, mm and radians; `pieces` one number or m. Returns
    the joints (k, 5) at the end of every piece, and its place (k,): 2.25 is a quarter of the third move.
    """
    pieces = np.broadcast_to(pieces, len(start))
    move = np.repeat(np.arange(len(start)), pieces)
    piece = np.arange(1, len(move) + 1) - np.repeat(np.cumsum(pieces) - pieces, pieces)
    t, joints = piece / pieces[move], end[move]
    inner = np.flatnonzero(t < 1)
    of, part = move[inner], t[inner, None]
    first, last = kin.forward(start[of])[0], kin.forward(end[of])[0]
    joints[inner] = kin.close(first + part * (last - first), start[of, 3:] + part * (end - start)[of, 3:])
    return joints, move + t


def linearize(
    kin: Kinematics, motion: Motion | ArrayLike, tolerance: ArrayLike, *, max_pieces: int = 4096,
    name: str = "block",
) -> Motion:  # fmt: skip
    """Divide every move until the tip stays within `tolerance` of the straight segment between its ends.

    `motion` is a `Motion`, or its joints alone, shape (n, 5), mm and radians, at the places 0, 1, 2 …; `tolerance`,
    mm, is that of all moves or of each. Returns a `Motion`; `ReachError` if `max_pieces` of one `name` do not do.
    """
    if not isinstance(motion, Motion):
        joints = np.asarray(motion, dtype=float)
        motion = Motion.on_part(joints, np.arange(len(joints)))
    start, end = motion.joints[:-1], motion.joints[1:]
    allowed = np.broadcast_to(tolerance, len(start))
    pieces = np.ones(len(start), dtype=int)
    # A curve leaves its chord by at most an eighth of its second derivative: most moves need no closer look.
    rest = np.flatnonzero(derivative(kin.machine, start, end, 2) / 8 > allowed)
    while rest.size:
        ends, _ = subdivide(kin, start[rest], end[rest], pieces[rest])
        firsts = np.cumsum(pieces[rest]) - pieces[rest]
        starts = np.roll(ends, 1, axis=0)
        starts[firsts] = start[rest]
        error = np.maximum.reduceat(stray(TIP, kin, starts, ends), firsts)
        over = error > allowed[rest]
        rest, error = rest[over], error[over]
        # The error falls with the square of the number of pieces.
        wanted = np.ceil(pieces[rest] * np.sqrt(error / allowed[rest])).astype(int)
        pieces[rest] = np.maximum(pieces[rest] + 1, wanted)
        if pieces.max() > max_pieces:
            move = int(pieces.argmax())
            strayed = f"the tip strays {error[rest == move][0]:.6f} mm, more than {allowed[move]:g} mm"
            raise ReachError(
                f"from {name} {move + 1} to {move + 2}: {strayed}, and {max_pieces} pieces are not enough"
            )
    if (pieces == 1).all():
        return motion
    joints, at = subdivide(kin, start, end, pieces)
    joints, at = np.concatenate([motion.joints[:1], joints]), np.r_[0.0, at]
    place = np.interp(at, np.arange(len(motion.place)), motion.place)
    kind = np.maximum(motion.kind[np.floor(at).astype(int)], motion.kind[np.ceil(at).astype(int)])
    return Motion(joints, place, kind)


def in_the_air(motion: Motion, tolerance: ArrayLike, clearance: float) -> np.ndarray:
    """The tolerance of the tip (mm) for each move: more for those that are lifted, and any for those far away."""
    near = np.where(motion.in_cut, tolerance, np.maximum(tolerance, AIR * clearance))
    return np.where(motion.far, np.inf, near)
