"""Whether the tool's body stays clear of what a path cuts, on a known way, and where nobody knows the way.

Where a control moves each axis at its own rate, a rapid move starts all axes at once, and each stops when it is
there. The tool leaves the straight line; how far, and to which side, depends on rates and accelerations. Whatever
they are, the slides stay in the box between both ends.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from mathpost.shop.post.body import ABOVE, AROUND, BODY, LEAST_BODY, MANY_POINTS, Body, in_body, moving
from mathpost.shop.post.cuts import Cuts

if TYPE_CHECKING:
    from mathpost.kinematics import Kinematics

MEETS, CLEAR, UNJUDGED = range(3)  # what is found of a way


@dataclass(frozen=True)
class Ways:
    """The moves from each row of `joints` to the next, and what is known of how they go."""

    joints: np.ndarray  # shape (n, j), mm and radians
    place: np.ndarray  # shape (n,), how far on the path all cuts before the end of each row are
    straight: np.ndarray  # shape (n,), whether all axes arrive at each row together
    tcp: np.ndarray  # shape (n,), and then the tip goes straight, not the joints
    onto: np.ndarray  # shape (n,), the row at which the CL data go on behind the move to each row, or -1
    lifted: np.ndarray  # shape (n,), whether the move to each row is one of approach or retract


def judged(kin: Kinematics, ways: Ways, rows: np.ndarray, cuts: Cuts) -> np.ndarray:
    """Return for the moves to some rows whether the tool is `CLEAR` of all that is cut, or `MEETS` it, or neither.

    Of axes that arrive at their own times every order counts: that is judged while slides move, or while one rotary
    axis turns alone. What the tool has in its body, or above, where the CL data go on is theirs, and does not
    count; but if a rapid move comes there along its own axis no more than its end, `BODY` mm, is.
    """
    joints = ways.joints
    steps = moving(kin, joints)[rows - 1]
    alone, turns = steps.sum(axis=1) == 1, steps[:, 3:].any(axis=1)
    found = np.where(steps.any(axis=1) & (cuts.lines.size > 0), UNJUDGED, CLEAR)
    for move in np.flatnonzero(turns & (alone | ways.straight[rows]) & (found != CLEAR)):
        found[move] = _turned(kin, ways, rows[move], cuts)
    slides = np.flatnonzero((found != CLEAR) & ~turns)
    length = max(kin.machine.tool_length, LEAST_BODY)
    if not slides.size:
        return found
    positions, group = np.unique(joints[rows[slides], 3:].round(9), axis=0, return_inverse=True)
    order = np.argsort(group, kind="stable")
    for angles, moves in zip(positions, np.split(slides[order], np.cumsum(np.bincount(group))[:-1]), strict=True):
        ends = joints[[rows[moves] - 1, rows[moves]], :3]
        _, axis = kin.forward(np.r_[np.zeros(3), angles])
        body = Body((kin.close(axis, angles) - kin.close(np.zeros(3), angles))[:3], length)
        of_lines = placed(kin, cuts.lines, angles)
        lowest = (ends @ body.axis).mean(axis=0) - np.abs(ends[1] - ends[0]) @ np.abs(body.axis) / 2
        found[moves] = np.where(lowest + ABOVE > (of_lines @ body.axis).max(initial=-np.inf), CLEAR, MEETS)
        boxes = of_lines.min(axis=0).T.copy(), of_lines.max(axis=0).T.copy()
        for move in moves[found[moves] == MEETS]:
            row, lines = rows[move], body.near(joints[[rows[move] - 1, rows[move]], :3], *boxes)
            straight = bool(alone[move] or ways.straight[row])
            both = joints[[row - 1, row], :3]
            lines = lines[body.meets(both, of_lines[:, lines], straight)]
            if lines.size:
                points = cuts.some(lines).points
                points = points[body.meets(both, placed(kin, points, angles)[None], straight)]
            found[move] = MEETS if lines.size and _are_there(kin, ways, row, cuts, points) else CLEAR
    return found


def placed(kin: Kinematics, points: np.ndarray, angles: np.ndarray) -> np.ndarray:
    """Where the slides put the tip on points of the workpiece, (..., 3), at rotary angles, (..., k): (..., 3)."""
    shape = np.broadcast_shapes(points.shape[:-1], angles.shape[:-1])
    points, angles = (np.broadcast_to(each, (*shape, each.shape[-1])) for each in (points, angles))
    return kin.close(points, angles)[..., :3]


def _are_there(kin: Kinematics, ways: Ways, row: int, cuts: Cuts, points: np.ndarray) -> bool:
    """Whether any point, of (n, 3) that the body meets on the way to a row, is there then, and no cut's own."""
    if not len(points):
        return False
    there = ~cuts.gone(points, ways.place[row - 1])
    if (onto := ways.onto[row]) >= 0:
        tips, axes = kin.forward(ways.joints[[row - 1, onto]])
        plunge = (
            onto == row and not ways.lifted[row] and np.linalg.norm(np.cross(tips[1] - tips[0], axes[1])) < ABOVE
        )
        there &= ~in_body(points, tips[1:], axes[1:], BODY if plunge else np.inf)
    return bool(there.any())


def _turned(kin: Kinematics, ways: Ways, row: int, cuts: Cuts) -> int:
    """What is found of a known way on which rotary axes turn: poses a fifth of the body's radius apart."""
    start, end = ways.joints[row - 1], ways.joints[row]
    length = max(kin.machine.tool_length, LEAST_BODY)
    tips, _ = kin.forward(start + np.linspace(0, 1, AROUND + 1)[:, None] * (end - start))
    away = np.linalg.norm(np.diff(tips, axis=0), axis=1).sum() + np.abs(end - start)[3:].sum() * length
    share = np.linspace(0, 1, int(min(MANY_POINTS, 2 + away / (BODY / 5))))[:, None]
    tips, axes = kin.forward(start + share * (end - start))
    if ways.tcp[row]:
        tips = tips[0] + share * (tips[-1] - tips[0])
    met = cuts.points[in_body(cuts.points, tips, axes, length)]
    return MEETS if _are_there(kin, ways, row, cuts, met) else CLEAR
