"""What is around the tool: what a path cuts, and when, and the stock and the fixture that the machine file names.

A point that was in the tool's body in an earlier cut is air by now. Every other point of the path, and of the
stock, is the part, or still to be cut.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from mathpost.shop.post.body import ABOVE, BODY, MANY_POINTS, spread
from mathpost.shop.post.solids import corners, moved

if TYPE_CHECKING:
    from mathpost.machine import Machine, Solid
    from mathpost.path.cl import CLData
BORDER = 0.05  # mm beside the body; a gap to what is nearer is not always found


@dataclass(frozen=True)
class Cuts:
    """The k lines that tools cut along, in the order in which they do, and the solids about them."""

    lines: np.ndarray  # shape (2, k, 3), from where to where, mm, in the workpiece
    axes: np.ndarray  # shape (k, 3), of the tool at the end
    when: np.ndarray  # shape (k,), place of the end on the whole path, increasing
    stock: tuple[Solid, ...] = ()
    fixture: tuple[Solid, ...] = ()

    def moved(self, shift: ArrayLike) -> Cuts:
        """Return the same counted from another origin: `shift`, mm, is added."""
        solids = (tuple(moved(each, shift) for each in some) for some in (self.stock, self.fixture))
        return Cuts(self.lines + np.asarray(shift), self.axes, self.when, *solids)

    @cached_property
    def ends(self) -> np.ndarray:
        """Points that all of it is between: ends of the lines, and corners around the solids, shape (n, 3)."""
        return np.concatenate([self.lines.reshape(-1, 3), *map(corners, (*self.stock, *self.fixture))])

    def __str__(self) -> str:
        named = {"what the path cuts": True, "the stock": self.stock, "a fixture": self.fixture}
        return " or ".join(name for name, some in named.items() if some)

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
        return replace(self, lines=self.lines[:, lines], axes=self.axes[lines], when=self.when[lines])

    def gone(self, points: np.ndarray, before: float) -> np.ndarray:
        """Whether points, (n, 3), were in the body of the tool while it cut, up to a place on the path."""
        gone = np.zeros(len(points), bool)
        stop = int(np.searchsorted(self.when, before, side="right"))
        step = max(1, MANY_POINTS * 40 // max(1, len(points)))
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


def touched(parts: Sequence[tuple[CLData, ArrayLike]], machine: Machine, shift: ArrayLike) -> Cuts:
    """Return what is around the tools of all parts of a path: CL data, each with its shift from one origin, mm.

    `shift`, mm, is that of the origin of the machine file, which its solids count from.
    """
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
    solids = [tuple(moved(each, shift) for each in some) for some in (machine.stock, machine.fixture)]
    return Cuts(np.concatenate(lines, axis=1), np.concatenate(axes), np.concatenate(when), *solids)
