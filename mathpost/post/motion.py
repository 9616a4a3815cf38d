"""The motion of a machine along a CL path: poses, where on the path they stand, and what a program says of them."""

from dataclasses import dataclass, replace

import numpy as np

from mathpost.compensate.compensation import Compensated, PoseError
from mathpost.errors import InputError, ReachError
from mathpost.post import program, travel
from mathpost.post.deviation import levers
from mathpost.post.linearization import linearize
from mathpost.post.passage import block_times, in_cut
from mathpost.rotation import blocks


@dataclass(frozen=True)
class Motion:
    """The poses that the machine runs through.

    Attributes
    ----------
    joints : ndarray, shape (m, 5)
        mm and radians.
    place : ndarray, shape (m,)
        Where each stands on the CL path: 2.25 is a quarter of the way from record 2 to record 3.
    lifted : ndarray of bool, shape (m,)
        Whether the pose is off the part.
    """

    joints: np.ndarray
    place: np.ndarray
    lifted: np.ndarray

    def __getitem__(self, rows):
        """The same of some poses: a slice or an index array."""
        return Motion(self.joints[rows], self.place[rows], self.lifted[rows])

    def linearized(self, kin, tolerance, cl):
        """Divide the moves until the tip keeps `tolerance`, the printed digits included."""
        tip, _ = cl.at(self.place)  # on the path, or lifted by so little that it does not count here
        left = tolerance - _rounding(kin.machine, tip, tolerance)
        divided = linearize(kin, self.joints, left, name=f"{cl.name}, block")
        if len(divided.place) == len(self.place):
            return self
        place = np.interp(divided.place, np.arange(len(self.place)), self.place)
        before, after = np.floor(divided.place).astype(int), np.ceil(divided.place).astype(int)
        return Motion(divided.joints, place, self.lifted[before] | self.lifted[after])

    def thinned(self, kin, tcp):
        """Leave out the poses that repeat all words of the one before.

        Returns
        -------
        Motion
        ndarray, shape (m, 5)
            The words of the poses as they will be printed.
        """
        joints = self.joints
        if tcp:
            joints = np.concatenate([kin.forward(joints)[0], joints[:, 3:]], axis=1)
        words = program.rounded(joints)
        keep = np.r_[True, (words[1:] != words[:-1]).any(axis=1)]
        return (self, words) if keep.all() else (self[keep], words[keep])

    def blocks(self, machine, cl, words, tcp):
        """Return the `program.Blocks` of these words, and the time that the moves take in s."""
        record = np.ceil(self.place).astype(int)
        feeds, rapid, cut = cl.feeds[record], cl.rapid[record], in_cut(self.lifted)
        turning = np.r_[False, (words[1:, 3:] != words[:-1, 3:]).any(axis=1)]
        tip, _ = cl.at(self.place)  # in cut the tip is on the path
        seconds = np.r_[np.nan, block_times(machine, self.joints, tip, feeds[1:], cut)]
        inverse = turning & ~np.isnan(feeds) & ~rapid & (not tcp)
        # A remark stands before the first block of the move to its record.
        before = np.searchsorted(self.place, [record - 1 for record, _ in cl.remarks], side="right").tolist()
        remarks = tuple((block, text) for block, (_, text) in zip(before, cl.remarks, strict=True))
        timed = np.where(inverse, seconds, np.nan)
        return program.Blocks(words, feeds, timed, rapid, tcp, remarks), float(seconds[1:].sum())

    def refuse_out_of_travel(self, machine, cl):
        """Check every pose, those between the records included; raise `ReachError` for the first that is out."""
        out = np.flatnonzero(~travel.all_within(machine, self.joints))
        if out.size:
            sentences = travel.out_of_travel(machine, self.joints[out[0]])
            raise ReachError(f"{cl.where(int(self.place[out[0]]))} and on: {'; '.join(sentences)}")


def along_the_records(joints, ways):
    """Return the `Motion` through the joints (n, 5) chosen for the records, with each of `ways` in its place.

    The ways follow each other; where one begins at the record at which another ends, both have its pose.
    """
    parts, record = [], 0
    for way in sorted(ways, key=lambda way: way.place[0]):
        first, last = int(way.place[0]), int(way.place[-1])
        parts.append(_of_records(joints, record, first))
        parts.append(Motion(way.joints, way.place, way.lifted)[max(record - first, 0) :])
        record = last + 1
    parts.append(_of_records(joints, record, len(joints)))
    columns = ([getattr(part, name) for part in parts] for name in ("joints", "place", "lifted"))
    return Motion(*map(np.concatenate, columns))


def _of_records(joints, first, stop):
    rows = np.arange(first, max(first, stop))
    return Motion(joints[rows], rows.astype(float), np.zeros(len(rows), bool))


def compensated(compensator, motion):
    """Return the `Motion` compensated for the errors of the machine, and sentences on what could not be."""
    parts = [compensator.compensate(motion.joints[rows]) for rows in blocks(motion.joints.shape[:1])]
    after = PoseError(*(np.concatenate([getattr(part.after, name) for part in parts]) for name in ("tip", "axis")))
    joints, limited, refused = (
        np.concatenate([getattr(part, name) for part in parts]) for name in ("joints", "limited", "refused")
    )
    whole = Compensated(joints, parts[0].before, after, limited, refused)
    return replace(motion, joints=joints), whole.cautions


def _rounding(machine, tip, tolerance):
    """Return how far the printed digits alone may move the tip, for the moves between tips (m, 3).

    Refuses a tolerance that leaves no room for it.
    """
    lever = levers(machine) + np.sqrt((tip * tip).sum(axis=1))
    moved = 0.5 * 10.0**-program.DECIMALS * (np.sqrt(3) + 2 * np.radians(1.0) * lever)
    if (worst := moved.max()) > tolerance / 2:
        expected = f"at least {2 * worst:.4f} mm, for words of {program.DECIMALS} decimals on this machine"
        raise InputError("tolerance", expected, f"{tolerance}")
    return np.maximum(moved[:-1], moved[1:])
