"""The motion of a machine along a CL path: poses, where on the path they stand, and what a program says of them."""

from dataclasses import dataclass

import numpy as np

from mathpost.errors import InputError, ReachError
from mathpost.post import program, selection
from mathpost.post.deviation import levers
from mathpost.post.linearization import linearize
from mathpost.post.passage import block_times, in_cut


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

    def replaced(self, passage):
        """Put a `Passage` in the place of what lies between its ends."""
        before, after = self[self.place < passage.place[0]], self[self.place > passage.place[-1]]
        return Motion(
            *(
                np.concatenate([getattr(part, name) for part in (before, passage, after)])
                for name in ("joints", "place", "lifted")
            )
        )

    def linearized(self, kin, tolerance, cl):
        """Divide the moves until the tip keeps `tolerance`, the printed digits included."""
        tip, _ = cl.at(self.place)  # on the path, or lifted by so little that it does not count here
        left = tolerance - _rounding(kin.machine, tip, tolerance)
        divided = linearize(kin, self.joints, left, name=f"{cl.name}, block", before=cl.first)
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

    def blocks(self, machine, cl, words, tcp, *, behind=0):
        """Return the `program.Blocks` of these words, and the time that the moves take in s.

        Of the first `behind` poses nothing is written: they say where the machine stands.
        """
        record = np.ceil(self.place).astype(int)
        feeds, rapid, cut = cl.feeds[record], cl.rapid[record], in_cut(self.lifted)
        turning = np.r_[False, (words[1:, 3:] != words[:-1, 3:]).any(axis=1)]
        tip, _ = cl.at(self.place)  # in cut the tip is on the path
        seconds = np.r_[np.nan, block_times(machine, self.joints, tip, feeds[1:], cut)]
        inverse = turning & ~np.isnan(feeds) & ~rapid & (not tcp)
        # A remark stands before the first block of the move to its record.
        remarks = [
            (int(np.searchsorted(self.place, record - 1, side="right")) - behind, text)
            for record, text in cl.remarks
            if record >= behind
        ]
        written = slice(behind, None)
        timed = np.where(inverse, seconds, np.nan)
        blocks = program.Blocks(words[written], feeds[written], timed[written], rapid[written], tcp, tuple(remarks))
        return blocks, float(seconds[1:].sum())

    def refuse_out_of_travel(self, machine, cl):
        """Check every pose, those between the records included; raise `ReachError` for the first that is out."""
        limits = machine.limits + selection.TRAVEL_TOLERANCE * np.array([-1, 1])
        out = np.flatnonzero(((self.joints < limits[:, 0]) | (self.joints > limits[:, 1])).any(axis=1))
        if out.size:
            sentences = selection.out_of_travel(machine, self.joints[out[0]])
            raise ReachError(f"{cl.where(int(self.place[out[0]]))} and on: {'; '.join(sentences)}")


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
