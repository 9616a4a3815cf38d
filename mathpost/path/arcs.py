"""Arcs and drilling cycles of CL data as the points that the tool goes through."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from mathpost.errors import InputError

SAME_RADIUS = 0.02  # mm, by which the radii at the two ends of an arc may differ
SAME_POINT = 1e-4  # mm, between the two ends of an arc that is a full turn
COARSEST = np.radians(45)  # between the points of an arc, however small it is
PECK_GAP = 0.5  # mm above the bottom, where the tool slows down again after a peck


def arc(
    start: ArrayLike, end: ArrayLike, centre: ArrayLike, axis: ArrayLike, tolerance: float, turns: int = 0
) -> np.ndarray:
    """Return the points of an arc or a helix, shape (n, 3), the last one `end`; chords keep the `tolerance`.

    The tool turns right-handed about `axis`; equal ends make a full turn. The distance of the ends along the axis
    is the rise of a helix, which adds `turns` full turns. `InputError` if there is no such arc.
    """
    start = np.asarray(start, dtype=float)
    end = np.asarray(end, dtype=float)
    centre = np.asarray(centre, dtype=float)
    about = np.asarray(axis, dtype=float)
    length = np.linalg.norm(about)
    if not 0.5 < length < 2:
        raise InputError("arc", "an axis of unit length", f"length {length:g}")
    about = about / length
    first, last = (point - centre - (point - centre) @ about * about for point in (start, end))
    radii = float(np.linalg.norm(first)), float(np.linalg.norm(last))
    if min(radii) < SAME_POINT or abs(radii[0] - radii[1]) > SAME_RADIUS:
        raise InputError("arc", "ends equally far from its centre", f"{radii[0]:.4f} and {radii[1]:.4f}")
    across = np.cross(about, first)  # as long as `first`
    angle = np.arctan2(last @ across, last @ first) % (2 * np.pi)
    if np.linalg.norm(last - first) < SAME_POINT:
        angle = 2 * np.pi
    angle += turns * 2 * np.pi
    step = min(2 * np.arccos(max(1 - tolerance / max(radii), 0)), COARSEST)
    t = np.arange(1, int(np.ceil(angle / step)) + 1)[:, None] / np.ceil(angle / step)
    around = np.cos(t * angle) * first + np.sin(t * angle) * across
    radius = (1 - t) + t * radii[1] / radii[0]
    rise = ((start - centre) @ about * (1 - t) + (end - centre) @ about * t) * about
    points = centre + around * radius + rise
    points[-1] = end
    return points


@dataclass(frozen=True)
class Cycle:
    """A drilling cycle, done at every point until it is switched off; heights along the tool axis."""

    kind: str  # DRILL and the like retract rapidly, BORE and REAM at their feed, TAP turning back
    depth: float  # below the point
    clearance: float  # above it, where the feed begins
    feed: float
    retract: float | None = None  # above it, where the tool goes afterwards; None: where it came from
    first: float | None = None  # depth of the first peck,
    following: float | None = None  # and of those that follow
    out: float | None = None  # how far a peck comes out; None: to the clearance
    dwell: float = 0.0  # seconds at the bottom

    def heights(self, before: float) -> tuple[list[float], list[bool], int]:
        """Return heights above the point, whether the move to each is rapid, and the index of the bottom.

        `before` is the height where the tool comes from.

        Examples
        --------
        >>> Cycle("DEEP", depth=8, clearance=2, feed=100, retract=10, first=5, following=5).heights(10)
        ([10, 2, -5, 2, -4.5, -8, 10], [True, True, False, True, True, False, True], 5)
        """
        retract = max(self.clearance, before if self.retract is None else self.retract)
        moves = [(retract, True), (self.clearance, True)]
        reached: float = 0
        step = self.first or self.following
        while step and reached + step < self.depth - 1e-9:
            reached, step = reached + step, self.following or step
            moves.append((-reached, False))
            if self.out is None:
                moves += [(self.clearance, True), (PECK_GAP - reached, True)]
            else:  # breaks the chip, and goes on from where it is
                moves.append((self.out - reached, True))
        bottom = len(moves)
        moves.append((-self.depth, False))
        if self.kind in ("BORE", "REAM", "TAP"):
            moves.append((self.clearance, False))
        if moves[-1][0] != retract:
            moves.append((retract, True))
        return [height for height, _ in moves], [rapid for _, rapid in moves], bottom
