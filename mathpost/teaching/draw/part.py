"""A workpiece as a closed solid, and the depth of a tool in it."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from mathpost.rotation import unit
from mathpost.teaching.draw.solid import Lofted

BLADE_COLOUR = "#62a9d4"  # the workpiece's, lighter


@dataclass(frozen=True)
class Part:
    """A workpiece as a closed solid, and the ball-nosed tool that cuts it."""

    # Rings of points (n, 3), mm in the workpiece, from the bottom up, counterclockwise seen from above.
    rings: list[np.ndarray]
    tool_radius: float  # mm

    @cached_property
    def solid(self) -> Lofted:
        """The `Lofted` body between the middles of its first and its last ring."""
        first, last = (ring.mean(axis=0)[None] for ring in (self.rings[0], self.rings[-1]))
        return Lofted("workpiece", BLADE_COLOUR, [first, *self.rings, last])

    def depth(self, tips: np.ndarray, axes: np.ndarray) -> np.ndarray:
        """Return how deep the tool is in the part, mm, at tips and tool axes of shape (n, 3); 0 where it is clear.

        The tool is a cylinder with a ball at its end, as long as the part is high.
        """
        triangles, radius = self.solid.triangles(), self.tool_radius
        low, high = (end(np.concatenate(self.rings), axis=0) for end in (np.min, np.max))
        along = np.arange(radius, high[2] - low[2] + radius, radius / 2)[:, None]
        found = np.zeros(len(tips))
        for number, (tip, axis) in enumerate(zip(tips, axes, strict=True)):
            middle = tip + along * axis
            near = np.linalg.norm(middle - middle.clip(low, high), axis=1) < radius
            if near.any():
                found[number] = max(0.0, radius - clearance(triangles, middle[near]).min())
        return found


def clearance(triangles: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Return how far points, shape (m, 3), are from a closed surface, triangles (n, 3, 3); negative inside it.

    The distance is that to the nearest triangle. Inside, the solid angles under which the triangles are seen add up
    to 4π: the formula of van Oosterom and Strackee (1983).
    """
    normal = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    real = np.linalg.norm(normal, axis=1) > 1e-12
    normal = unit(normal[real])
    away = np.moveaxis(triangles[real] - np.asarray(points)[:, None, None], 2, 0)  # corner, point, triangle, x y z
    above = np.ones(away.shape[1:3], dtype=bool)  # the foot of the perpendicular lies in the triangle
    square = np.full(away.shape[1:3], np.inf)
    for start, end in zip(away, np.roll(away, -1, axis=0), strict=True):
        edge = end - start
        above &= _dot(np.cross(start, edge), normal) >= 0
        along = (-_dot(start, edge) / _dot(edge, edge)).clip(0, 1)[..., None]
        square = np.minimum(square, _dot(start + along * edge, start + along * edge))
    square = np.where(above, np.minimum(square, _dot(away[0], normal) ** 2), square)
    a, b, c = away
    far_a, far_b, far_c = np.linalg.norm(away, axis=-1)
    below = far_a * far_b * far_c + _dot(a, b) * far_c + _dot(b, c) * far_a + _dot(c, a) * far_b
    seen = 2 * np.arctan2(_dot(a, np.cross(b, c)), below).sum(axis=1)
    return np.sqrt(square.min(axis=1)) * np.where(seen > 2 * np.pi, -1, 1)


def _dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.einsum("...i,...i->...", a, b)
