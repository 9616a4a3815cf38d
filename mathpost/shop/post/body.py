"""The tool's body, held against what a path touches: along a known way, and where nobody knows the way.

Where a control moves each axis at its own rate, a rapid move starts all axes at once, and each stops when it is
there. The tool leaves the straight line; how far, and to which side, depends on rates and accelerations. Whatever
they are, the slides stay in the box between both ends.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from mathpost.kinematics import Kinematics
    from mathpost.path.cl import CLData

BODY = 5.0  # mm, assumed: the radius of the tool's body,
LEAST_BODY = 50.0  # and its length where the tool is shorter or its length not known
MANY_POINTS = 5000  # that the body of the tool is held against one by one
STILL = 1e-3  # mm or degrees; an axis that moves less moves by its printed digits
TRIES = 3  # steps towards the place from which the tool is deepest in a line
TOGETHER = 4096  # lines times directions that are tried at once
ABOVE = 0.01  # mm above the tip, where the body of the tool begins: what it slides over does not count
AROUND = 32  # directions about the tool axis,
EVENLY = 200  # and in all directions, in which a gap is looked for


def spread(points: np.ndarray) -> np.ndarray:
    """Return the indices of a sample of points, one in each cube of a fifth of the body's radius; of few, all."""
    if len(points) <= MANY_POINTS:
        return np.arange(len(points))
    return np.sort(np.unique(np.round(points / (BODY / 5)), axis=0, return_index=True)[1])


def in_body(points: np.ndarray, tips: np.ndarray, axes: np.ndarray, length: float) -> np.ndarray:
    """Whether points (n, 3) are inside the body of the tool at any of m poses, tips and axes (m, 3); shape (n,).

    The body is a cylinder about the tool axis, `BODY` in radius, from the tip on, `length` mm long.
    """
    inside = np.zeros(len(points), bool)
    for tip, axis in zip(tips, axes, strict=True):
        off = points - tip
        along = off @ axis
        beside = np.vecdot(off, off) - along**2  # the square of the distance from the axis
        inside |= (along > 0) & (along < length) & (beside < BODY**2)
    return inside


def touched(parts: Sequence[tuple[CLData, np.ndarray]]) -> np.ndarray:
    """Return the lines that a tool cuts along, shape (2, k, 3), from where to where, in mm.

    `parts` are CL data and how far their origin is from that of the points that are returned.
    """
    lines = []
    for cl, shift in parts:
        ends = np.flatnonzero(~cl.rapid)
        starts = np.maximum(ends - 1, 0)
        long = np.linalg.norm(cl.points[ends] - cl.points[starts], axis=1) > BODY / 5
        kept = np.union1d(np.flatnonzero(long), spread(cl.points[ends]))
        lines.append(np.array([cl.points[starts[kept]], cl.points[ends[kept]]]) + shift)
    return np.concatenate(lines, axis=1)


def moving(kin: Kinematics, joints: np.ndarray) -> np.ndarray:
    """Return which axes move between `joints`, shape (n, j), that follow each other; shape (n - 1, j)."""
    return np.abs(np.diff(joints, axis=0)) * kin.machine.units > STILL


def may_be_rapid(kin: Kinematics, joints: np.ndarray, rows: np.ndarray, lines: np.ndarray) -> np.ndarray:
    """Whether each of the moves to some rows of `joints`, shape (n, 5), may be rapid, each axis at its own rate.

    It may if the body of the tool stays clear of all `lines` that the path touches, shape (2, k, 3): in which order
    ever the slides arrive, or while a rotary axis turns alone. Of one axis alone there is one way; what the body
    meets where the tool stands before it, it has cut, and that does not count. Nor does a line along the tool axis
    in which the way ends: the tool has come down there.
    """
    steps = moving(kin, joints)[rows - 1]
    alone, turns = steps.sum(axis=1) == 1, steps[:, 3:].any(axis=1)
    found = ~steps.any(axis=1)
    for move in np.flatnonzero(alone & turns):
        found[move] = _turns_clear(kin, joints[rows[move] - 1], joints[rows[move]], lines)
    slides = np.flatnonzero(~found & ~turns)
    length = max(kin.machine.tool_length, LEAST_BODY)
    positions, group = np.unique(joints[rows[slides], 3:].round(9), axis=0, return_inverse=True)
    for number, angles in enumerate(positions):
        moves = slides[group == number]
        ends = joints[[rows[moves] - 1, rows[moves]], :3]
        _, axis = kin.forward(np.r_[np.zeros(3), angles])
        body = _Body((kin.close(axis, angles) - kin.close(np.zeros(3), angles))[:3], length)
        # Where the slides put the tip on the lines.
        of_lines = kin.close(lines, np.broadcast_to(angles, (*lines.shape[:2], len(angles))))[..., :3]
        lowest = (ends @ body.axis).mean(axis=0) - np.abs(ends[1] - ends[0]) @ np.abs(body.axis) / 2
        found[moves] = lowest + ABOVE > (of_lines @ body.axis).max(initial=-np.inf)
        boxes = of_lines.min(axis=0).T.copy(), of_lines.max(axis=0).T.copy()
        for move in np.flatnonzero(~found[moves]):
            near = of_lines[:, body.near(ends[:, move], *boxes)]
            if alone[moves[move]]:
                near = near[:, ~body.meets(ends[[0, 0], move], near)]
                near = near[:, ~(body.along(near) & body.meets(ends[[1, 1], move], near))]
            found[moves[move]] = not body.meets(ends[:, move], near).any()
    return found


def _turns_clear(kin: Kinematics, start: np.ndarray, end: np.ndarray, lines: np.ndarray) -> bool:
    """Whether the body stays clear of lines while a rotary axis turns alone: poses a fifth of its radius apart."""
    if not lines.size:
        return True
    share = np.linspace(0, 1, AROUND + 1)
    tips, _ = kin.forward(start + share[:, None] * (end - start))
    away = np.linalg.norm(np.diff(tips, axis=0), axis=1).sum() + np.abs(end - start).sum() * kin.machine.tool_length
    poses = np.linspace(0, 1, int(min(MANY_POINTS, 2 + away / (BODY / 5))))
    tips, axes = kin.forward(start + poses[:, None] * (end - start))
    length = max(kin.machine.tool_length, LEAST_BODY)
    parts = int(min(MANY_POINTS, 2 + np.linalg.norm(lines[1] - lines[0], axis=1).max() / (BODY / 5)))
    points = (lines[0] + np.linspace(0, 1, parts)[:, None, None] * (lines[1] - lines[0])).reshape(-1, 3)
    points = points[spread(points)]
    return not in_body(points[~in_body(points, tips[:1], axes[:1], length)], tips, axes, length).any()


class _Body:
    """The body of a tool that does not turn: a cylinder from just above the tip on, and directions to part it in.

    Two convex bodies are apart if some direction parts them; one that the few here do not find counts as none.
    """

    def __init__(self, axis: np.ndarray, length: float) -> None:
        self.axis = axis
        across = np.cross(axis, np.eye(3)[np.abs(axis).argmin()])
        across /= np.linalg.norm(across)
        turn = np.arange(AROUND)[:, None] * 2 * np.pi / AROUND
        around = np.cos(turn) * across + np.sin(turn) * np.cross(axis, across)
        height = 1 - (2 * np.arange(EVENLY) + 1) / EVENLY
        turn = np.pi * (1 + np.sqrt(5)) * np.arange(EVENLY)  # a Fibonacci lattice on the sphere
        evenly = np.stack([np.cos(turn), np.sin(turn), height], axis=1)
        evenly[:, :2] *= np.sqrt(1 - height**2)[:, None]
        self.directions = np.concatenate([[-axis, axis], around, evenly])
        self.length = length
        self.reach = self._reach(self.directions)

    def _reach(self, directions: np.ndarray) -> np.ndarray:
        """How far the body reaches from the tip in some directions, (n, 3); shape (n,)."""
        along = directions @ self.axis
        across = BODY * np.sqrt(np.maximum(1 - along**2, 0))
        return np.maximum(ABOVE * along, self.length * along) + across

    def near(self, ends: np.ndarray, least: np.ndarray, greatest: np.ndarray) -> np.ndarray:
        """Which lines may meet the body in the box between two ends, (2, 3), by their own boxes, (3, k) each."""
        low = ends.min(axis=0) - self._reach(-np.eye(3))
        high = ends.max(axis=0) + self._reach(np.eye(3))
        found = np.arange(least.shape[1])
        for axis in range(3):
            found = found[(least[axis, found] <= high[axis]) & (greatest[axis, found] >= low[axis])]
        return found

    def along(self, lines: np.ndarray) -> np.ndarray:
        """Whether each line, (2, k, 3), is along the axis of the body."""
        return np.linalg.norm(np.cross(lines[1] - lines[0], self.axis), axis=-1) < ABOVE

    def surely_meets(self, ends: np.ndarray, lines: np.ndarray) -> np.ndarray:
        """Whether the body somewhere in the box has an end or the middle of each line inside; not all are found."""
        points = np.concatenate([lines, lines.mean(axis=0)[None]])
        tips = ends.mean(axis=0)
        for _ in range(TRIES):  # from the point down the axis, and into the box
            along = np.clip((points - tips) @ self.axis, ABOVE, self.length)
            tips = np.clip(points - along[..., None] * self.axis, ends.min(axis=0), ends.max(axis=0))
        off = points - tips
        along = off @ self.axis
        beside = np.vecdot(off, off) - along**2
        inside = (along > 2 * ABOVE) & (along < self.length - ABOVE) & (beside < (BODY - ABOVE) ** 2)
        return inside.any(axis=0)

    def meets(self, ends: np.ndarray, lines: np.ndarray) -> np.ndarray:
        """Whether each line, (2, k, 3), may meet the body in the box of slides between two ends, (2, 3)."""
        found = self.surely_meets(ends, lines)
        middle, half = ends.mean(axis=0), np.abs(ends[1] - ends[0]) / 2
        most = np.abs(self.directions) @ half + self.reach  # of box and body together, in each direction
        left, tried = np.flatnonzero(~found), 0
        while left.size and tried < len(self.directions):
            some = slice(tried, tried + max(1, TOGETHER // left.size))
            apart = ((lines[:, left] - middle) @ self.directions[some].T).min(axis=0) > most[some]
            left, tried = left[~apart.any(axis=1)], some.stop
        found[left] = True
        return found
