"""All solutions of a record: two branches, the windings inside travel, and at the pole what the neighbours hold."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from mathpost.post.travel import TURN, move_costs, out_of_travel, short_way, within_travel
from mathpost.rotation import unit

POLE = 1e-20  # r − D, half the square of the angle from the pole: within 1e-10 rad of it
NEAR_POLE = 1e-4  # radians between the two inner angles: only within this is r − D looked at
BLOCK = 16384  # records whose candidates are found at once: as many as the processor's cache takes


@dataclass(frozen=True)
class Candidates:
    """Every solution of every record: each one solved, in each winding.

    Attributes
    ----------
    solved : ndarray, shape (5, k, n)
        mm and radians, rotary angles in (−180°, 180°]: both branches, and again as the neighbours hold the outer
        axis at the pole. NaN where the tool axis is out of reach, or not at the pole in a row that stands for it.
    turns : tuple of 2 ndarrays
        The windings of the two rotary axes. An endless axis has one only: its windings are counted by the choice.
    kin : Kinematics
    """

    solved: np.ndarray
    turns: tuple
    kin: object

    @property
    def machine(self):
        """The machine whose travel is meant."""
        return self.kin.machine

    @cached_property
    def offsets(self):
        """What the windings add to the rotary angles, shape (2, w), radians."""
        return TURN * np.stack(np.meshgrid(*self.turns, indexing="ij")).reshape(2, -1)

    @cached_property
    def joints(self):
        """All joints, shape (n, m, 5), mm and radians, m = k·w."""
        joints = np.repeat(self.solved, self.offsets.shape[1], axis=1)
        joints[3:] += np.tile(self.offsets, len(self.solved[0]))[..., None]
        return joints.T

    @cached_property
    def branch(self):
        """0 or 1, as `Kinematics.inverse` orders them, shape (m,)."""
        return np.repeat(np.arange(len(self.solved[0])) % 2, self.offsets.shape[1])

    @cached_property
    def inside(self):
        """Whether all joints are inside travel, shape (n, m)."""
        machine, known = self.machine, ~np.isnan(self.solved[0])
        for joint in range(3):
            known &= within_travel(machine, joint, self.solved[joint])
        first, second = (
            [within_travel(machine, joint, self.solved[joint] + turn * TURN) for turn in turns]
            for joint, turns in zip((3, 4), self.turns, strict=True)
        )
        inside = np.stack([known & one & other for one in first for other in second], axis=1)
        return inside.reshape(-1, inside.shape[-1]).T

    def listed(self, record):
        """Numbers of the candidates of a record; those that stand for the pole only are left out elsewhere."""
        known = ~np.isnan(self.joints[record]).any(axis=1)
        return np.flatnonzero(known) if known.any() else np.arange(len(known))

    def reason(self, record, candidate):
        """Say why a candidate is out, or return "" if it is not."""
        if np.isnan(self.joints[record, candidate]).any():
            return "tool axis out of reach"
        return "; ".join(out_of_travel(self.machine, self.joints[record, candidate]))

    def table(self, record, previous=None, weights=None):
        """Rows to show: branch, joints in mm and degrees, cost of the move from `previous`, and why if out."""
        listed = self.listed(record)
        joints = self.joints[record, listed]
        steps = joints if previous is None else short_way(self.machine, joints - np.asarray(previous, dtype=float))
        degrees = np.concatenate([joints[:, :3], np.rad2deg(joints[:, 3:])], axis=1)
        reasons = [self.reason(record, candidate) for candidate in listed]
        costs = move_costs(self.machine, steps, weights)
        return list(zip(self.branch[listed].tolist(), degrees, costs, reasons, strict=True))


def candidates(kin, tip, axis):
    """Return all candidates for tips and axes of shape (n, 3) as `Candidates`.

    At the pole every outer angle is right. Besides 0 those of the nearest records before and after that are not at
    the pole are candidates there, so that the axis can be turned while that costs nothing of the tool axis.
    """
    joints = kin.inverse(tip, axis)
    return _with_windings(kin, tip, joints, _at_pole(kin, axis, joints))


def _with_windings(kin, tip, joints, at_pole, before=None, after=None):
    """`Candidates` from both branches; `before` and `after` as in `_held_at_pole`."""
    # In memory the five joints come first and the records last, so that what is done joint by joint is fast.
    solved = np.ascontiguousarray(joints.T)
    if at_pole.any():
        solved = np.concatenate([solved, *_held_at_pole(kin, tip, joints, at_pole, before, after)], axis=1)
    return Candidates(solved, tuple(_windings(*kin.machine.limits[joint]) for joint in (3, 4)), kin)


def _outer(kin):
    """The number of the outer joint."""
    return kin.symbols.index(kin.inverse_symbolic.outer)


def _at_pole(kin, axis, joints):
    """Whether tool axes (n, 3), whose inverse is `joints`, are parallel to the outer axis, to rounding."""
    if kin.reach[0] > 0:
        return np.zeros(len(joints), dtype=bool)
    inner = joints[..., kin.symbols.index(kin.inverse_symbolic.inner)]
    at_pole = np.abs(inner[:, 0] - inner[:, 1]) < NEAR_POLE  # there the two solutions meet
    if at_pole.any():
        at_pole[at_pole] = kin.reach_terms(unit(np.asarray(axis, dtype=float)[at_pole]))[0] < POLE
    return at_pole


def _held_at_pole(kin, tip, joints, at_pole, before, after):
    """Two blocks of candidates (5, 2, n): the outer angles of the records before and after; NaN off the pole.

    Where the records are part of a path, `before` and `after` are the outer angles, shape (2,), at the nearest
    record off the pole that precedes and that follows the part, or None.
    """
    outer, others = _outer(kin), np.flatnonzero(~at_pole)
    angles = [[before]] * (before is not None) + [joints[others, :, outer]] + [[after]] * (after is not None)
    angles = np.concatenate(angles)
    if not len(angles):
        return
    following = np.searchsorted(others, np.flatnonzero(at_pole)) + (before is not None)
    for neighbour in (following - 1, following):
        rotary = joints[at_pole, :, 3:]
        rotary[..., outer - 3] = angles[np.clip(neighbour, 0, len(angles) - 1)]
        held = np.full_like(joints, np.nan)
        held[at_pole] = kin.close(np.asarray(tip, dtype=float)[at_pole, None], rotary)
        yield held.T


def _windings(low, high):
    """Whole turns that may bring an angle of (−180°, 180°] into travel, the nearest to none first."""
    if not (np.isfinite(low) and np.isfinite(high)):
        return np.zeros(1)
    turns = np.arange(np.floor((low - np.pi) / TURN), np.ceil((high + np.pi) / TURN) + 1)
    useful = turns[(turns * TURN - np.pi <= high) & (turns * TURN + np.pi >= low)]
    return useful[np.argsort(np.abs(useful), kind="stable")]


def along(kin, pieces):
    """Yield each piece of a path, and an iterator over slices of its records and their `Candidates`.

    They are the candidates of the whole path: at the pole, neighbours count across the ends of pieces. Nothing
    else is kept from one slice to the next.
    """
    passed, ahead = None, _Ahead(kin, pieces)

    def slices(number, piece):
        nonlocal passed
        for start in range(0, len(piece), BLOCK):
            rows = slice(start, min(start + BLOCK, len(piece)))
            joints = kin.inverse(piece.points[rows], piece.axes[rows])
            at_pole = _at_pole(kin, piece.axes[rows], joints)
            after = ahead.angles(number, rows.stop) if at_pole[-1] else None
            yield rows, _with_windings(kin, piece.points[rows], joints, at_pole, passed, after)
            if (others := np.flatnonzero(~at_pole)).size:
                passed = joints[others[-1], :, _outer(kin)]

    for number in range(len(pieces)):
        piece = pieces[number]
        yield piece, slices(number, piece)


class _Ahead:
    """Looks for the next record off the pole, in whatever piece it is; at no record twice."""

    def __init__(self, kin, pieces):
        self.kin, self.pieces = kin, pieces
        self.place, self.found = (0, -1), None

    def angles(self, number, row):
        """The outer angles, shape (2,), of the first record off the pole from this one on, or None."""
        if self.place < (number, row):
            self.place, self.found = self._search(number, row)
        return self.found

    def _search(self, first, row):
        for number in range(first, len(self.pieces)):
            piece = self.pieces[number]
            for start in range(row if number == first else 0, len(piece), BLOCK):
                rows = slice(start, start + BLOCK)
                joints = self.kin.inverse(piece.points[rows], piece.axes[rows])
                others = np.flatnonzero(~_at_pole(self.kin, piece.axes[rows], joints))
                if others.size:
                    return (number, start + int(others[0])), joints[others[0], :, _outer(self.kin)]
        return (len(self.pieces), 0), None


@dataclass(frozen=True)
class Inside:
    """The candidates inside travel of some records, those of each record in front: a few rows instead of many.

    Attributes
    ----------
    joints : ndarray, shape (5, m, n)
    branch : ndarray of int, shape (m, n)
    known : ndarray of bool, shape (m, n)
        Whether a record has that many; the rest is filled with any numbers.
    """

    joints: np.ndarray
    branch: np.ndarray
    known: np.ndarray

    @classmethod
    def of(cls, found):
        """Those of `Candidates`, in their order."""
        known, branch, windings = found.inside.T, found.branch.astype(np.int8), found.offsets.shape[1]
        used = known.any(axis=1)
        if known[used].all():
            order, known = np.flatnonzero(used)[:, None], known[used]
            joints, branch = found.solved[:, order[:, 0] // windings], branch[order]
            offsets = found.offsets[:, order % windings]
        else:
            # Which are inside changes seldom along a path, and only where it does their order is to be found.
            count = known.shape[1]
            changes = np.flatnonzero((known[:, 1:] != known[:, :-1]).any(axis=0)) + 1
            lengths = np.diff(changes, prepend=0, append=count)
            known = known[:, np.r_[0, changes]]
            order = np.argsort(~known, axis=0, kind="stable")[: known.sum(axis=0).max()]
            first = np.repeat(order // windings * count, lengths, axis=1)
            joints = found.solved.reshape(5, -1).take(first + np.arange(count), axis=1)
            offsets = np.repeat(found.offsets[:, order % windings], lengths, axis=2)
            branch = np.repeat(branch[order], lengths, axis=1)
            known = np.repeat(np.take_along_axis(known, order, axis=0), lengths, axis=1)
        if windings > 1:
            joints[3:] += offsets
        return cls(joints, np.broadcast_to(branch, known.shape), known)

    def part(self, start, stop):
        """The same of some of the records."""
        return Inside(*(array[..., start:stop] for array in (self.joints, self.branch, self.known)))

    def last(self):
        """The same of the last record, without the places that it leaves empty."""
        count = np.count_nonzero(self.known[:, -1])
        return Inside(*(array[..., :count, -1:] for array in (self.joints, self.branch, self.known)))

    def followed_by(self, other):
        """These records and then those of `other`."""
        width = max(len(self.known), len(other.known))
        pairs = zip((self.joints, self.branch, self.known), (other.joints, other.branch, other.known), strict=True)
        return Inside(*(np.concatenate([_widened(array, width) for array in pair], axis=-1) for pair in pairs))

    def picked(self, picks):
        """Joints, shape (n, 5), and branches of the candidates with the numbers `picks`, shape (n,)."""
        joints, branch = self.joints[:, 0].copy(), self.branch[0].copy()
        for number in range(1, len(self.known)):
            here = picks == number
            np.copyto(joints, self.joints[:, number], where=here)
            np.copyto(branch, self.branch[number], where=here)
        return joints.T, branch


def _widened(array, width):
    """An array (..., m, n) filled with zeros to `width` in the place of m."""
    missing = width - array.shape[-2]
    return np.pad(array, [(0, 0)] * (array.ndim - 2) + [(0, missing), (0, 0)]) if missing else array
