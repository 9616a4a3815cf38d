"""Stock and fixture: boxes and cylinders, divided into cubes where the body of the tool may be near.

A solid need not be whole: of stock, what the tool has been in is air. So it is not looked at as a shape, but cube
by cube, down to `LEAST` mm; each stands for the point of the solid that is nearest to its middle.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import product

import numpy as np
from numpy.typing import ArrayLike

from mathpost.machine import Solid

LEAST = 1.0  # mm, the edge of the smallest cubes
SAME = 1e-6  # mm, by which a point of a solid may be beside it
MOST = 200_000  # cubes of one size; where more are near, the body counts as meeting them
EIGHTHS = np.array(list(product((-0.25, 0.25), repeat=3)))  # middles of a cube's eight parts
Near = Callable[[np.ndarray, float], np.ndarray]  # which of n points may be in the body, or so many mm beside it


def corners(solid: Solid) -> np.ndarray:
    """The corners of the box around a solid, along the axes of the workpiece, mm, shape (8, 3)."""
    ends = np.array([solid.start, solid.end])
    low, high = ends.min(axis=0), ends.max(axis=0)
    if solid.radius is not None:
        along = (ends[1] - ends[0]) / np.linalg.norm(ends[1] - ends[0])
        beside = solid.radius * np.sqrt(np.maximum(1 - along**2, 0))
        low, high = low - beside, high + beside
    return np.array(list(product(*zip(low, high, strict=True))))


def moved(solid: Solid, shift: ArrayLike) -> Solid:
    """Return a solid counted from another origin: `shift`, mm, is added."""
    start, end = (tuple(np.add(each, shift).tolist()) for each in (solid.start, solid.end))
    return replace(solid, start=start, end=end)


def nearest(solid: Solid, points: np.ndarray) -> np.ndarray:
    """The point of a solid that is nearest to each of some points, (n, 3)."""
    start, end = np.array(solid.start), np.array(solid.end)
    if solid.radius is None:
        return np.clip(points, np.minimum(start, end), np.maximum(start, end))
    way = end - start
    off = points - start
    along = (off @ way / (way @ way))[:, None] * way
    beside = off - along
    far = np.linalg.norm(beside, axis=1, keepdims=True)
    inside = np.clip(off @ way / (way @ way), 0, 1)[:, None] * way
    return start + inside + beside * np.minimum(1, solid.radius / np.maximum(far, 1e-12))


def meets(
    solid: Solid, near: Near, there: Callable[[np.ndarray], np.ndarray], least: float = LEAST
) -> bool:  # fmt: skip
    """Whether any point of a solid that is still `there` may be in the body.

    Of what is left of it a layer thinner than `LEAST` mm may be lost. Where the smallest cubes are larger, `least`,
    what is not known by then counts as met.
    """
    box = corners(solid)
    size = LEAST * 2.0 ** np.ceil(np.log2(np.ptp(box, axis=0).max() / LEAST + 2))
    middles = box.mean(axis=0, keepdims=True)
    while True:
        points = nearest(solid, middles)
        kept = (np.linalg.norm(points - middles, axis=1) <= size) & near(middles, size)
        middles, points = middles[kept], points[kept]
        points = points[near(points, 0.0)]
        if len(points) and there(points).any():
            return True
        if not len(middles) or size <= least:
            return len(middles) > 0 and least > LEAST
        if len(middles) > MOST / len(EIGHTHS):
            return True
        middles = (middles[:, None] + size * EIGHTHS).reshape(-1, 3)
        size /= 2


def within(solids: Sequence[Solid], points: np.ndarray) -> np.ndarray:
    """Whether points, (n, 3), are in any solid."""
    off = [np.linalg.norm(nearest(solid, points) - points, axis=1) for solid in solids]
    return np.min(off, axis=0) < SAME


def in_reach(solids: Sequence[Solid], low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Whether boxes, from `low` to `high`, (n, 3) each, reach the box around any solid."""
    found = np.zeros(len(low), bool)
    for box in map(corners, solids):
        found |= ((low <= box.max(axis=0)) & (high >= box.min(axis=0))).all(axis=1)
    return found
