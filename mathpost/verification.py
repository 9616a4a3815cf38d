"""The proof of a program: its own text, sent through the forward kinematics, against the CL data.

At the records, and along the path that the joints really run between the blocks.
"""

from dataclasses import dataclass

import numpy as np

from mathpost.errors import MathpostError
from mathpost.linearization import deviation
from mathpost.passage import in_cut

LEAST_INTERVALS = 16  # of a move of a machine with measured errors, which no third derivative bounds


@dataclass(frozen=True)
class Verification:
    """How far a program, read back from its own text, is from the CL data.

    Attributes
    ----------
    tip_error, axis_error : float
        Largest distance of the tip (mm) and angle of the tool axis (degrees) at the records.
    path_tip_error, path_axis_error : float
        The same along the path that the joints run between the blocks, for the moves in cut: distance from the CL
        segment, angle from the great circle.
    worst_record : int
        The record (from 1) that the largest tip error of the path comes before or at.
    """

    tip_error: float
    axis_error: float
    path_tip_error: float
    path_axis_error: float
    worst_record: int

    def worse(self, other):
        """Return what is worst in the two."""
        worst = max(self, other, key=lambda proof: proof.path_tip_error)
        return Verification(
            tip_error=max(self.tip_error, other.tip_error),
            axis_error=max(self.axis_error, other.axis_error),
            path_tip_error=worst.path_tip_error,
            path_axis_error=max(self.path_axis_error, other.path_axis_error),
            worst_record=worst.worst_record,
        )


def verify(kin, cl, blocks, motion, *, samples=None, real=None):
    """Compare a program's blocks with the CL data, at the records and along the path between the blocks.

    Parameters
    ----------
    kin : Kinematics
    cl : CLData
    blocks : mathpost.program.Blocks
        As read back from the text.
    motion : Motion
        Where on the CL path each block ends, and which are lifted off the part.
    samples : int, optional
        Intervals between two blocks; see `mathpost.linearization.deviation`.
    real : Kinematics or Compensator, optional
        The forward kinematics of the machine that runs the program, if not those of its control.

    Returns
    -------
    Verification
    """
    least = 2 if real is None else LEAST_INTERVALS
    real = kin if real is None else real
    if len(blocks.words) != len(motion.place):
        raise MathpostError(f"{len(motion.place)} blocks were written and {len(blocks.words)} read back")
    joints = blocks.joints
    if blocks.tcp:
        joints = kin.close(joints[:, :3], joints[:, 3:])
    tip, axis = real.forward(joints)
    # A record whose block was left out as a repetition has the pose of the block before.
    on_part = np.flatnonzero(~motion.lifted)
    at = on_part[np.searchsorted(motion.place[on_part], np.arange(len(cl)), side="right") - 1]
    tips, axes = cl.at(motion.place)
    steps = slice(None, -1), slice(1, None)
    path_tip, path_axis = deviation(
        real,
        *(joints[part] for part in steps),
        tips=[tips[part] for part in steps],
        axes=[axes[part] for part in steps],
        reached=[(tip[part], axis[part]) for part in steps],
        samples=samples,
        least=least,
    )
    if blocks.tcp:  # the control keeps the tip on the straight line between the blocks
        path_tip = np.linalg.norm(tip - tips, axis=1)[1:]
    cut = in_cut(motion.lifted)
    worst = int(np.argmax(np.where(cut, path_tip, 0))) if len(cut) else -1
    return Verification(
        tip_error=float(np.linalg.norm(tip[at] - cl.points, axis=1).max()),
        axis_error=float(np.degrees(_angle(axis[at], cl.axes).max())),
        path_tip_error=float(path_tip[cut].max(initial=0)),
        path_axis_error=float(np.degrees(path_axis[cut].max(initial=0))),
        worst_record=cl.first + int(np.ceil(motion.place[worst + 1])) + 1,
    )


def _angle(first, second):
    return 2 * np.arcsin(np.clip(np.linalg.norm(first - second, axis=-1) / 2, 0, 1))
