"""What a path cuts, and when: a point that was in the tool's body in an earlier cut is air by now.

Every other point of the path is the part, or still to be cut.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from mathpost.shop.post.body import ABOVE, BODY, MANY_POINTS, spread

if TYPE_CHECKING:
    from mathpost.path.cl import CLData
BORDER = 0.05  # mm beside the body; a gap to what is nearer is not always found


@dataclass(frozen=True)
class Cuts:
    """The k lines that tools cut along, in the order in which they do."""

    lines: np.ndarray  # shape (2, k, 3), from where to where, mm, in the workpiece
    axes: np.ndarray  # shape (k, 3), of the tool at the end
    when: np.ndarray  # shape (k,), place of the end on the whole path, increasing

    def moved(self, shift: ArrayLike) -> Cuts:
        """Return the same counted from another origin: `shift`, mm, is added."""
        return replace(self, lines=self.lines + np.asarray(shift))

    @cached_property
    def points(self) -> np.ndarray:
        """Points of the lines, both ends and others at most a fifth of the body's radius apart, shape (n, 3)."""
        parts = 2 + (np.linalg.norm(self.lines[1] - self.lines[0], axis=1) / (BODY / 5)).astype(int)
        line = np.repeat(np.arange(len(parts)), parts)
        share = (np.arange(len(line)) - np.repeat(np.cumsum(parts) - parts, parts)) / (parts[line] - 1)
        points = self.lines[0, line] + share[:, None] * (self.lines[1] - self.lines[0])[line]
        return points[spread(points)]

    def some(self, lines: np.ndarray) -> Cuts:
        """Return some of the lines, by number."""
        return Cuts(self.lines[:, lines], self.axes[lines], self.when[lines])

    def gone(self, points: np.ndarray, before: float) -> np.ndarray:
        """Whether points, (n, 3), were in the body of the tool while it cut, up to a place on the path."""
        gone = np.zeros(len(points), bool)
        stop, step = int(np.searchsorted(self.when, before, side="right")), max(1, MANY_POINTS * 40 // len(points))
        while stop > 0 and not gone.all():  # the last cuts first: they are the nearest
            some = slice(max(0, stop - step), stop)
            gone[~gone] = self._within(points[~gone], some)
            stop -= step
        return gone

    def _within(self, points: np.ndarray, some: slice) -> np.ndarray:
        """Whether points were in the body of the tool on some lines, along each of which its axis stays."""
        start, axis = self.lines[0, some], self.axes[some]
        way = self.lines[1, some] - start
        rise = np.vecdot(way, axis)
        across = way - rise[:, None] * axis
        square = np.vecdot(across, across)
        off = points[:, None] - start
        nearest = np.einsum("nki,ki->nk", off, across) / np.maximum(square, ABOVE**2)
        found = np.zeros(len(points), bool)
        for share in (0.0, np.clip(nearest, 0, 1), 1.0):  # beside the line, or at the lower one of its ends
            from_tip = off - np.asarray(share)[..., None] * way
            along = np.einsum("nki,ki->nk", from_tip, axis)
            beside = np.vecdot(from_tip, from_tip) - along**2
            found |= ((along > 0) & (beside < (BODY + BORDER) ** 2)).any(axis=1)
        return found


NOTHING = Cuts(np.empty((2, 0, 3)), np.empty((0, 3)), np.empty(0))


def touched(parts: Sequence[tuple[CLData, ArrayLike]]) -> Cuts:
    """Return what the tools of all parts of a path cut: CL data, each with its shift from a common origin, mm."""
    lines, axes, when, before = [], [], [], 0
    for cl, shift in parts:
        ends = np.flatnonzero(~cl.rapid)
        starts = np.maximum(ends - 1, 0)
        long = np.linalg.norm(cl.points[ends] - cl.points[starts], axis=1) > BODY / 5
        kept = np.union1d(np.flatnonzero(long), spread(cl.points[ends]))
        lines.append(np.array([cl.points[starts[kept]], cl.points[ends[kept]]]) + np.asarray(shift))
        axes.append(cl.axes[ends[kept]])
        when.append(before + ends[kept])
        before += len(cl)
    return Cuts(np.concatenate(lines, axis=1), np.concatenate(axes), np.concatenate(when))
