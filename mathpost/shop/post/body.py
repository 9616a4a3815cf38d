"""The tool's body: what is inside it, at a pose, on a straight way, or anywhere in a box of slides."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mathpost.formula import slices

if TYPE_CHECKING:
    from mathpost.kinematics import Kinematics

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


def in_body(
    points: np.ndarray, tips: np.ndarray, axes: np.ndarray, length: float, margin: float = 0.0
) -> np.ndarray:
    """Whether points (n, 3) are inside the body of the tool at any of m poses, tips and axes (m, 3); shape (n,).

    The body is a cylinder about the tool axis, `BODY` in radius, from just above the tip on, `length` mm long; or
    `margin` mm larger all around.
    """
    inside = np.zeros(len(points), bool)
    for poses in slices((len(tips), len(points))):
        off = points[:, None] - tips[poses]
        along = np.vecdot(off, axes[poses])
        beside = np.vecdot(off, off) - along**2  # the square of the distance from the axis
        within = (along > ABOVE - margin) & (along < length + margin) & (beside < (BODY + margin) ** 2)
        inside |= within.any(axis=1)
    return inside


def moving(kin: Kinematics, joints: np.ndarray) -> np.ndarray:
    """Return which axes move between `joints`, shape (n, j), that follow each other; shape (n - 1, j)."""
    return np.abs(np.diff(joints, axis=0)) * kin.machine.units > STILL


class Body:
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

    def meets(self, ends: np.ndarray, lines: np.ndarray, straight: bool = False, margin: float = 0.0) -> np.ndarray:
        """Whether each line, (2, k, 3), may meet the body in the box of slides between two ends, (2, 3).

        Or on the straight way between them; or come so near as `margin`, mm. A line may be one point, (1, k, 3).
        """
        middle = ends.mean(axis=0)
        if straight:
            found = np.zeros(lines.shape[1], bool)
            most = np.abs(self.directions @ (ends[1] - ends[0])) / 2 + self.reach
        else:
            found = self.surely_meets(ends, lines)
            # Of box and body together, in each direction.
            most = np.abs(self.directions) @ np.abs(ends[1] - ends[0]) / 2 + self.reach
        left, tried = np.flatnonzero(~found), 0
        while left.size and tried < len(self.directions):
            some = slice(tried, tried + max(1, TOGETHER // left.size))
            apart = ((lines[:, left] - middle) @ self.directions[some].T).min(axis=0) > most[some] + margin
            left, tried = left[~apart.any(axis=1)], some.stop
        found[left] = True
        return found
