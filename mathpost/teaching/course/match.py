"""Which block of a program, whoever wrote it, ends at which record of the CL data, and what lies between."""

from dataclasses import dataclass

import numpy as np

from mathpost.kinematics import Kinematics
from mathpost.path.cl import CLData
from mathpost.path.deviation import deviation
from mathpost.rotation import angle_of_chord


@dataclass(frozen=True)
class Match:
    """The blocks that end at the records, as far as these are reached in their order."""

    blocks: np.ndarray  # shape (k,), numbers of the blocks, from 0, that end at the first k records
    tip: float = np.nan  # how near the blocks after these come to the next record: mm,
    axis: float = np.nan  # and radians of the tool axis there; NaN if all records are reached


@dataclass(frozen=True)
class Between:
    """The m moves between the first and the last block of a `Match`."""

    record: np.ndarray  # shape (m,), from 0, that each move leads to
    tip: np.ndarray  # shape (m,), how far the tip strays from the segment between the records, mm
    axis: np.ndarray  # shape (m,), and the tool axis from the great circle, radians
    height: np.ndarray  # shape (m,), of the higher end of the move above the segment, along the tool axis, mm


def match(kin: Kinematics, cl: CLData, joints: np.ndarray, *, tip: float, axis: float) -> Match:
    """Find the first block that ends at each record, in the order of the records.

    `joints`, shape (n, 5), mm and radians, are those at the ends of the blocks; `tip` (mm) and `axis` (radians) say
    how far a block may be from its record.
    """
    tips, axes = kin.forward(joints)
    blocks: list[int] = []
    for point, direction in zip(cl.points, cl.axes, strict=True):
        begin = blocks[-1] if blocks else 0
        off = np.linalg.norm(tips[begin:] - point, axis=1)
        lean = angle_of_chord(np.linalg.norm(axes[begin:] - direction, axis=1))
        at = np.flatnonzero((off <= tip) & (lean <= axis))
        if not at.size:
            nearest = off.argmin()
            return Match(np.array(blocks, int), float(off[nearest]), float(lean[nearest]))
        blocks.append(begin + int(at[0]))
    return Match(np.array(blocks, int))


def between(kin: Kinematics, cl: CLData, joints: np.ndarray, found: Match) -> Between:
    """Return how far the moves between matched blocks stray from the CL path when all joints move linearly."""
    first, last = found.blocks[0], found.blocks[-1]
    moves = np.arange(first, last)
    record = np.searchsorted(found.blocks, moves, side="right")
    tips = cl.points[record - 1], cl.points[record]
    axes = cl.axes[record - 1], cl.axes[record]
    tip, axis = deviation(kin, joints[moves], joints[moves + 1], tips=tips, axes=axes)
    ends, _ = kin.forward(joints)
    count = np.diff(found.blocks)[record - 1]
    part = (moves - found.blocks[record - 1])[:, None] / count[:, None]
    height = []
    for row, t in ((moves, part), (moves + 1, part + 1 / count[:, None])):
        on_path = tips[0] + t * (tips[1] - tips[0])
        height.append(np.vecdot(ends[row] - on_path, axes[1]))
    return Between(record, tip, axis, np.maximum(*height))
