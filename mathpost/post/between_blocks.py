"""Between two blocks: how far tip and tool axis stray from the CL path, and poses enough to keep both tolerances.

A control without TCP moves all five joints linearly from block to block: tip and tool axis leave the CL path
(nonlinear error, 非线性误差). First `follow` puts poses on the great circle of the tool axis. Then linearization
(线性化) divides a move in the *workpiece*: tip on the CL segment, rotary angles in equal steps, X Y Z recomputed.
Equation (8) of source 002 puts the new points on the very line in the joints that the control follows anyway.
"""

import math
from dataclasses import dataclass

import numpy as np

from mathpost.errors import ReachError
from mathpost.post import singular
from mathpost.post.selection import nearest
from mathpost.rotation import slices

RESOLUTION = 1e-5  # mm; what the samples of a move may miss of the way between them
LEVER = 50.0  # mm; the least lever that samples are counted for, for the sake of the tool axis
AXIS_RESOLUTION = RESOLUTION / LEVER  # radians; what they may miss of the tool axis
FIRST = 64  # one of so many moves, those with the greatest bounds, is looked at before the others
LOST = 1 / 8  # of the axis tolerance: a move that spans less and strays more does not go along its great circle
AIR = 0.1  # of the clearance, how far a lifted tip may stray


@dataclass(frozen=True)
class Motion:
    """The m poses that the machine runs through, all joints linearly from each to the next."""

    joints: np.ndarray  # shape (m, 5), mm and radians
    place: np.ndarray  # shape (m,), where on the CL path: 2.25 is a quarter of the way from record 2 to record 3
    lifted: np.ndarray  # shape (m,), whether the pose is off the part, retracted along the tool axis

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


def deviation(kin, start, end, *, tips=None, axes=None, samples=None, least=2):
    """Return how far the tip and the tool axis stray when all joints move linearly.

    Parameters
    ----------
    kin : Kinematics
    start, end : array_like, shape (m, 5)
        Joints at both ends of m moves, mm and radians.
    tips, axes : array_like, shape (2, m, 3), optional
        Ends of the segments that the tips (mm), and of the great circles that the tool axes should follow; by
        default where the joints at both ends have them.
    samples, least : int
        Intervals per move. By default at least `least`, and as many as it takes to miss no more than `RESOLUTION`
        where the move is taken for a parabola between its samples.

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
    return tuple(_stray(kind, kin, start, end, path, samples, least) for kind, path in enumerate((tips, axes)))


def strays(kin, cl, motion, moves=slice(None)):
    """Return how far tip (mm) and tool axis (radians) stray from the CL path on moves of a `Motion`."""
    starts, ends = motion[:-1][moves], motion[1:][moves]
    tips, axes = zip(*(cl.at(poses.place) for poses in (starts, ends)), strict=True)
    return deviation(kin, starts.joints, ends.joints, tips=tips, axes=axes)


def _stray(kind, kin, start, end, path=None, samples=None, least=2):
    """One half of `deviation`: that of the tip (`kind` 0) or of the tool axis (1)."""
    error = np.zeros(len(start))
    for moves, _, *tool in sampled(kin, start, end, samples, least):
        ends = tool[kind][[0, -1]] if path is None else (path[0][moves], path[1][moves])
        error[moves] = _peak((from_segment, from_arc)[kind](tool[kind], *ends))
    return error


def axis_lag(kin, cl, start, end, place, place_after):
    """Return how far the tool axis is at most, radians, from where `cl` has it at the same part of each move.

    That is no less than its angle from the great circle.
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
    """Return the way of the tip, shape (m, 3), when the joints (n, 5) move linearly: `samples` intervals a move."""
    joints, t = np.asarray(joints, dtype=float), np.linspace(0, 1, samples + 1)[:, None]
    return kin.forward(joints[:-1, None] + t * np.diff(joints, axis=0)[:, None])[0].reshape(-1, 3)


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
        ends = path[moves], path[moves + 1]
        stray = _stray(kind, kin, joints[moves], joints[moves + 1], ends, least=least)
        found[moves] = np.minimum(stray, bound[moves])

    few = len(most) // FIRST + 1
    promising = np.argpartition(most, -few)[-few:]
    look(promising[most[promising] >= 0])
    most[promising] = -1
    look(np.flatnonzero(most > found.max()))
    error = min(found.max() + (RESOLUTION, AXIS_RESOLUTION)[kind], bound.max())
    return float(error), int(found.argmax())


def bounds(machine, joints, tips, axes, reached):
    """Return how far the moves of an ideal machine may stray, shape (2, n - 1): mm and radians.

    `tips` and `axes`, shape (n, 3), are where the path has them, `reached` where the joints (n, 5) have them.
    Between its ends a move strays from its chord by at most an eighth of its second derivative, which is Ω² for a
    unit vector that is turned by Ω in all. The chord strays from that of the path by what the ends are off. The
    great circle is off its own chord by an eighth of the square of what it spans.
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


def follow(kin, cl, motion, tolerance, *, free=False):
    """Divide every move in cut that is not `free` until the tool axis keeps `tolerance` of its great circle.

    Moves are halved on the great circle. Where it meets a singular tool axis there is a pose just before and one
    just after it: the outer axis turns while the tool axis all but stands still. `ReachError` if the joints do not
    go along the great circle, as where they change the branch.
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

    `motion` is a `Motion`, or its joints alone, shape (n, 5), mm and radians, at the places 0, 1, 2 …; `tolerance`,
    mm, is that of all moves or, shape (n - 1,), of each. Returns a `Motion`. `ReachError`, with what a row is
    called, `name`, if a move does not meet the tolerance in `max_pieces`.
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
        error = np.maximum.reduceat(_stray(0, kin, starts, ends), firsts)
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
    place = np.interp(at, np.arange(len(motion.place)), motion.place)
    lifted = motion.lifted[np.floor(at).astype(int)] | motion.lifted[np.ceil(at).astype(int)]
    return Motion(joints, place, lifted)


def in_the_air(motion, tolerance, clearance):
    """The tolerance of the tip (mm) for each move, more for those that are lifted."""
    return np.where(motion.in_cut, tolerance, np.maximum(tolerance, AIR * clearance))


def equation_8(kin, start, end, tolerance, *, max_depth=12):
    """Divide a move by equation (8) of source 002 taken literally, for the audit only.

    The new points lie on the line in joint space, and each half is measured at its middle against its own chord.
    Returns the joints (pieces + 1, 5), the largest error by that measure, and the true one of the whole move, mm.
    """
    for depth in range(max_depth):
        joints = np.linspace(start, end, 2**depth + 1)
        tip, middle = kin.forward(joints)[0], kin.forward((joints[:-1] + joints[1:]) / 2)[0]
        claimed = from_segment(middle, tip[:-1], tip[1:]).max()
        if claimed <= tolerance:
            break
    whole = np.broadcast_to(tip[[0, -1], None], (2, len(joints) - 1, 3))
    return joints, float(claimed), float(deviation(kin, joints[:-1], joints[1:], tips=whole)[0].max())
