"""The proof of a program: its own text, sent through the forward kinematics, against the CL data.

At the records, and along the path that the joints really run between the blocks.
"""

from dataclasses import dataclass

import numpy as np

from mathpost.errors import MathpostError
from mathpost.post.deviation import largest
from mathpost.post.passage import in_cut

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


def verify(kin, cl, blocks, motion, *, real=None):
    """Compare a program's blocks with the CL data, at the records and along the path between the blocks.

    Parameters
    ----------
    kin : Kinematics
    cl : CLData
    blocks : mathpost.post.program.Blocks
        As read back from the text.
    motion : Motion
        Where on the CL path each block ends, and which are lifted off the part.
    real : Kinematics or Compensator, optional
        The forward kinematics of the machine that runs the program, if not those of its control.

    Returns
    -------
    Verification
    """
    least = 2 if real is None else LEAST_INTERVALS
    real, ideal = kin if real is None else real, real is None
    if len(blocks.words) != len(motion.place):
        raise MathpostError(f"{len(motion.place)} blocks were written and {len(blocks.words)} read back")
    joints = blocks.joints
    if blocks.tcp:
        joints = kin.close(joints[:, :3], joints[:, 3:])
    tip, axis = real.forward(joints)
    tips, axes = cl.at(motion.place)
    cut = in_cut(motion.lifted)
    path_tip, worst, path_axis = 0.0, -1, 0.0
    if len(cut):
        path_tip, worst, path_axis = largest(
            real,
            joints,
            False if blocks.tcp else tips,
            axes,
            reached=(tip, axis),
            counted=cut,
            least=least,
            bounded=ideal,
        )
        if blocks.tcp:  # the control keeps the tip on the straight line between the blocks
            off = np.where(cut, _distance(tip, tips)[1:], 0)
            path_tip, worst = float(off.max()), int(off.argmax())
    at = slice(None)
    if not (np.array_equal(motion.place, np.arange(len(cl))) and cut.all()):
        # A record whose block was left out as a repetition has the pose of the block before.
        on_part = np.flatnonzero(~motion.lifted)
        at = on_part[np.searchsorted(motion.place[on_part], np.arange(len(cl)), side="right") - 1]
    return Verification(
        tip_error=float(_distance(tip[at], cl.points).max()),
        axis_error=float(np.degrees(2 * np.arcsin(min(_distance(axis[at], cl.axes).max() / 2, 1)))),
        path_tip_error=path_tip,
        path_axis_error=float(np.degrees(path_axis)),
        worst_record=cl.first + int(np.ceil(motion.place[worst + 1])) + 1,
    )


def worst_of(proofs):
    """Return the `Verification` that says of several the worst."""
    farthest = max(proofs, key=lambda proof: proof.path_tip_error)
    names = ("tip_error", "axis_error", "path_tip_error", "path_axis_error")
    return Verification(*(max(getattr(proof, name) for proof in proofs) for name in names), farthest.worst_record)


def _distance(first, second):
    off = first - second
    return np.sqrt((off * off).sum(axis=1))
