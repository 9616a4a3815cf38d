"""How far tip and tool axis stray from the CL path when all five joints move linearly from block to block.

A proof measures this nonlinear error (非线性误差), and planning divides moves to keep it small.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from mathpost.formula import slices
from mathpost.rotation import angle_of_chord

if TYPE_CHECKING:
    from mathpost.kinematics import ForwardKinematics, Kinematics
    from mathpost.machine import Machine
    from mathpost.path.cl import CLData
    from mathpost.path.motion import Motion

TOLERANCE = 0.01  # mm, of the tip; travel between the blocks is never looked at more coarsely
# Of the tool axis: as much as a flank 6 mm above the tip strays by 0.01 mm; what Siemens' CYCLE832 sets for
# finishing, too: 10° for each mm of the tolerance of the contour.
AXIS_TOLERANCE = np.radians(0.1)
RESOLUTION = 1e-5  # mm; error of the tip that the samples of a move may miss
LEVER = 50.0  # mm; the least lever that the number of samples assumes, for the sake of the tool axis
AXIS_RESOLUTION = RESOLUTION / LEVER  # radians; error of the tool axis that they may miss
FIRST = 64  # the 1/64 of the moves with the greatest bounds is examined before the others
FEWEST_INTERVALS = 4  # of any move: with two, an end on the other side of the segment hides how high the peak is
LEAST_INTERVALS = 16  # of a move of a machine with measured errors, which no third derivative bounds
PLACE_DIGITS = 9  # of a place on the CL path, so that rounding does not move it past a record
Ends = tuple[np.ndarray, np.ndarray]  # the start and the end of each move


def deviation(
    kin: ForwardKinematics,
    start: np.ndarray,
    end: np.ndarray,
    *,
    tips: Ends | None = None,
    axes: Ends | None = None,
    least: int = FEWEST_INTERVALS,
) -> tuple[np.ndarray, np.ndarray]:
    """Return how far the tip (mm) and the tool axis (radians) stray when all joints move linearly, shape (m,) each.

    `start` and `end`, shape (m, 5), are the joints at both ends of m moves, mm and radians; `tips` and `axes`, (2,
    m, 3), the ends of the segments and great circles that they should follow, by default the poses of these joints.
    A move is sampled in at least `least` intervals, enough for parabolas between the samples to miss no more than
    `RESOLUTION`.

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
    return stray(TIP, kin, start, end, tips, least), stray(AXIS, kin, start, end, axes, least)


def strays(
    kin: Kinematics, cl: CLData, motion: Motion, moves: slice | np.ndarray = slice(None)
) -> tuple[np.ndarray, np.ndarray]:
    """Return how far tip (mm) and tool axis (radians) stray from the CL path on moves of a `Motion`.

    The tool axis is measured from the whole arc between two records, wherever on it the blocks are. Its angle to
    the axis of `cl` at the same place is the axis lag (of geometry, not that of the servos), see
    `mathpost.path.between_blocks.axis_lag`.
    """
    starts, ends = motion[:-1][moves], motion[1:][moves]
    tips = cl.at(starts.place)[0], cl.at(ends.place)[0]
    return deviation(kin, starts.joints, ends.joints, tips=tips, axes=arcs(cl, starts.place, ends.place))


def arcs(cl: CLData, place: np.ndarray, place_after: np.ndarray) -> Ends:
    """The tool axes of the records before and after each move, (2, m, 3): the ends of its arc."""
    before = np.floor(np.round(place, PLACE_DIGITS)).astype(int)
    after = np.ceil(np.round(place_after, PLACE_DIGITS)).astype(int)
    return cl.axes[before], cl.axes[after]


def stray(
    what: Measured,
    kin: ForwardKinematics,
    start: np.ndarray,
    end: np.ndarray,
    path: Ends | None = None,
    least: int = FEWEST_INTERVALS,
) -> np.ndarray:
    """Return one half of `deviation`; `what` is `TIP` or `AXIS`."""
    error = np.zeros(len(start))
    for moves, _, *pose in sampled(kin, start, end, least):
        reached = pose[what.index]
        ends = (reached[0], reached[-1]) if path is None else (path[0][moves], path[1][moves])
        error[moves] = peak(what.off(reached, *ends))
    return error


def sampled(
    kin: ForwardKinematics, start: ArrayLike, end: ArrayLike, least: int = FEWEST_INTERVALS
) -> Iterator[tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]]:
    """Yield k moves at a time: their numbers (k,), t from 0 to 1 (intervals + 1, 1), tips and axes (…, k, 3)."""
    start, end = np.asarray(start, dtype=float), np.asarray(end, dtype=float)
    intervals = _intervals(kin.machine, start, end, least)
    for count in np.unique(intervals).tolist():
        t = np.linspace(0, 1, count + 1)[:, None]
        alike = np.flatnonzero(intervals == count)
        for rows in slices((len(alike), count + 1)):
            moves = alike[rows]
            yield moves, t, *kin.forward(start[moves] + t[..., None] * (end[moves] - start[moves]))


def true_tip(kin: ForwardKinematics, joints: ArrayLike, *, samples: int = 24) -> np.ndarray:
    """Return the tip's path, shape (m, 3), when the joints (n, 5) move linearly: `samples` intervals a move."""
    joints, t = np.asarray(joints, dtype=float), np.linspace(0, 1, samples + 1)[:, None]
    return kin.forward(joints[:-1, None] + t * np.diff(joints, axis=0)[:, None])[0].reshape(-1, 3)


def largest(
    strayed: Callable[[np.ndarray], np.ndarray], most: np.ndarray, resolution: float = 0.0
) -> tuple[float, int]:
    """Return how far moves stray at most, and the first such move.

    ``strayed(moves)`` returns how far some of them stray; `most`, shape (n,), is an upper bound for each, from
    `bounds`: infinite where none is known, negative for moves to be ignored. `resolution`, the error that samples
    may miss, is added.
    """
    if not len(most):
        return 0.0, -1
    found, bound, few = np.zeros(len(most)), np.maximum(most, 0), len(most) // FIRST + 1
    promising = most >= np.partition(most, -few)[-few]
    others = np.flatnonzero(~promising)
    for some in (np.flatnonzero(promising), *(others[rows] for rows in slices(others.shape))):
        moves = some[most[some] > found.max()]
        found[moves] = np.minimum(strayed(moves), bound[moves])
    error = min(found.max() + resolution, bound.max())
    return float(error), int(found.argmax())


def bounds(machine: Machine, joints: np.ndarray, tips: np.ndarray, axes: np.ndarray, reached: Ends) -> np.ndarray:
    """Return how far the moves of an ideal machine can stray, shape (2, n - 1), mm and radians.

    `tips` and `axes`, shape (n, 3), are where the path has them, `reached` where the joints (n, 5) have them.
    Between its ends a move strays from its chord by at most an eighth of its second derivative, which is Ω² for a
    unit vector that is turned by Ω in all. The great circle is off its own chord by an eighth of the square of the
    angle it spans.
    """
    ends = (np.linalg.norm(at - path, axis=1) for at, path in zip(reached, (tips, axes), strict=True))
    tip_off, axis_off = (np.maximum(off[:-1], off[1:]) for off in ends)
    turn = np.abs(np.diff(joints[:, 3:], axis=0)).sum(axis=1)
    axis = axis_off + (turn**2 + (turn + np.pi * axis_off) ** 2) / 8
    bend = derivative(machine, joints[:-1], joints[1:], 2) / 8
    return np.array([tip_off + bend, angle_of_chord(axis)])


def derivative(machine: Machine, start: np.ndarray, end: np.ndarray, order: int) -> np.ndarray:
    """Return a bound on a derivative of the tip's path, order 2 or 3, for moves that take the time 1.

    For a point at most r from the lines that it is turned about, by Ω, and moved by v, it is Ωⁿ·r + n·Ωⁿ⁻¹·v.
    """
    step = np.abs(end - start)
    turn, travel = step[:, 3:].sum(axis=1), step[:, :3].sum(axis=1)
    lever = levers(machine) + np.maximum(*(np.abs(at[:, :3]).sum(axis=1) for at in (start, end)))
    return turn ** (order - 1) * (turn * np.maximum(lever, LEVER) + order * travel)


def levers(machine: Machine) -> float:
    """Return all offsets of a machine end to end, mm: apart from X Y Z, no point is further from a rotary axis."""
    head = 0 if isinstance(machine.programmed_point, str) else np.abs(machine.programmed_point).sum()
    pivots = sum(np.abs(rotary.point).sum() for rotary in machine.rotary)
    return np.abs(machine.origin).sum() + 2 * (machine.tool_length + pivots) + head


def _intervals(machine: Machine, start: np.ndarray, end: np.ndarray, least: int) -> np.ndarray:
    """Return the intervals that each move needs for parabolas through three samples; powers of two."""
    missed = derivative(machine, start, end, 3) / (9 * np.sqrt(3))  # times h³, by a parabola through points h apart
    # The least power of two, n, with n³ ≥ missed/RESOLUTION, which is below 2 to its binary exponent.
    _, exponent = np.frexp(missed / RESOLUTION)
    return np.left_shift(1, np.maximum(-(-exponent // 3), math.ceil(math.log2(least))))


def from_segment(points: np.ndarray, start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Distance of points (..., 3) from the segments between two others."""
    along, off = end - start, points - start
    squared = np.vecdot(along, along)
    t = np.clip(np.vecdot(off, along) / np.where(squared > 0, squared, 1), 0, 1)
    return np.linalg.norm(off - t[..., None] * along, axis=-1)


def from_arc(axes: np.ndarray, start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Angle of unit vectors (..., 3) from the shorter great circle arcs between two others."""
    along = end - start  # of neighbours only the differences keep their digits
    normal = np.cross(start, along)
    length = np.linalg.norm(normal, axis=-1)
    # No arc between opposite axes, nor between axes that differ by rounding, even if only in length.
    arc = length > 1e-15 + 1e-12 * np.linalg.norm(along, axis=-1)
    normal = normal / np.where(arc, length, 1)[..., None]
    from_start, from_end = axes - start, axes - end
    before = np.vecdot(from_start, np.cross(normal, start)) < 0
    behind = np.vecdot(from_end, np.cross(normal, end)) > 0
    chord = np.minimum(np.linalg.norm(from_start, axis=-1), np.linalg.norm(from_end, axis=-1))
    off_plane = np.abs(np.vecdot(from_start, normal))
    beside = arc & ~before & ~behind
    return np.where(beside, np.arcsin(np.minimum(off_plane, 1)), angle_of_chord(chord))


def peak(values: np.ndarray) -> np.ndarray:
    """Return the largest of samples along the first axis, and of the parabolas through three consecutive ones."""
    before, at, after = values[:-2], values[1:-1], values[2:]
    curvature, slope = before - 2 * at + after, np.abs(after - before)
    crest = slope <= -2 * curvature
    top = at - slope**2 / np.where(curvature < 0, 8 * curvature, -np.inf)
    return np.maximum(values.max(axis=0), np.where(crest, top, 0).max(axis=0))


@dataclass(frozen=True)
class Measured:
    """A quantity that strays from its path: the tip from segments, mm, or the tool axis from arcs, radians."""

    index: int  # in a pose: tip, tool axis
    off: Callable[..., np.ndarray]  # its distance from its path
    resolution: float  # the error that samples may miss


TIP = Measured(0, from_segment, RESOLUTION)
AXIS = Measured(1, from_arc, AXIS_RESOLUTION)
