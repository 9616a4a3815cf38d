"""Solids that take few numbers in a page: turned profiles, joined rings, convex hulls.

A solid is in the coordinates of its body. Each kind has `state`, for the browser, and `triangles`, shape (n, 3, 3),
counterclockwise seen from outside, the same that the browser makes from the state.
"""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import scipy
from numpy.typing import ArrayLike

from mathpost.rotation import unit

SIDES = 40  # of a turned solid
CREASE = 0.8  # cosine of the angle from which two faces meet in an edge

Profile = Sequence[tuple[float, float]]  # radius and height, from bottom to top


class Solid(ABC):
    """A solid of any kind, as a picture needs it."""

    body: str
    colour: str

    @abstractmethod
    def state(self) -> dict[str, Any]:
        """Return it for the browser, ready for JSON."""

    @abstractmethod
    def triangles(self) -> np.ndarray:
        """Return its surface, shape (n, 3, 3), counterclockwise seen from outside."""

    @cached_property
    def surface(self) -> tuple[np.ndarray, np.ndarray]:
        """The triangles, and the normals at their corners, both of shape (n, 3, 3)."""
        triangles = self.triangles()
        return triangles, smooth(triangles)


@dataclass
class Turned(Solid):
    """A solid of revolution: `profile` (radius, height) from bottom to top, about `along` through `origin`."""

    body: str
    colour: str
    profile: Profile
    origin: np.ndarray
    along: np.ndarray

    def state(self) -> dict[str, Any]:
        profile = [[round(r, 2), round(h, 2)] for r, h in self.profile]
        return {"profile": profile, "from": _short(self.origin), "along": _short(self.along, 9)}

    def triangles(self) -> np.ndarray:
        radius, height = np.array(self.profile, dtype=float).T[..., None, None]
        return _between(self.origin + height * self.along + radius * ring(np.zeros(3), self.along, 1.0, SIDES))


@dataclass
class Lofted(Solid):
    """A solid through `rings`, (n, 3) each, counterclockwise seen from the last; a ring may be a single point."""

    body: str
    colour: str
    rings: list[np.ndarray]

    def state(self) -> dict[str, Any]:
        return {"rings": [_short(ring) for ring in self.rings]}

    def triangles(self) -> np.ndarray:
        count = max(map(len, self.rings))
        return _between([np.broadcast_to(ring, (count, 3)) for ring in self.rings])


@dataclass
class Hull(Solid):
    """The convex hull of `points`, shape (n, 3)."""

    body: str
    colour: str
    points: np.ndarray

    @cached_property
    def faces(self) -> tuple[np.ndarray, np.ndarray]:
        """The vertices of the hull, shape (m, 3), and its triangles as their numbers, shape (n, 3)."""
        hull = scipy.spatial.ConvexHull(self.points)
        a, b, c = np.moveaxis(self.points[hull.simplices], 1, 0)
        inwards = np.einsum("ij,ij->i", np.cross(b - a, c - a), hull.equations[:, :3]) < 0
        simplices = np.where(inwards[:, None], hull.simplices[:, ::-1], hull.simplices)
        return self.points[hull.vertices], np.searchsorted(hull.vertices, simplices)  # the vertices are sorted

    def state(self) -> dict[str, Any]:
        corners, faces = self.faces
        return {"corners": _short(corners), "faces": faces.tolist()}

    def triangles(self) -> np.ndarray:
        corners, faces = self.faces
        return corners[faces]


def smooth(triangles: np.ndarray) -> np.ndarray:
    """Return the normal at every corner, shape (n, 3, 3): the mean of faces that meet there smoothly."""
    a, b, c = np.moveaxis(triangles, 1, 0)
    flat = np.cross(b - a, c - a)
    flat /= np.maximum(np.linalg.norm(flat, axis=1, keepdims=True), 1e-300)
    rounded = triangles.reshape(-1, 3).round(2)
    _, place, count = np.unique(rounded, axis=0, return_inverse=True, return_counts=True)
    order, normals = np.argsort(place.ravel(), kind="stable"), np.empty((len(rounded), 3))
    begin = np.cumsum(count) - count
    for size in np.unique(count):  # the places where as many corners are
        corners = order[begin[count == size][:, None] + np.arange(size)]
        meeting = flat[corners // 3]
        normals[corners] = (meeting @ meeting.swapaxes(1, 2) > CREASE) @ meeting
    return (normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)).reshape(-1, 3, 3)


def put(matrix: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Transform points (..., 3) by a 4×4 matrix."""
    return points @ matrix[:3, :3].T + matrix[:3, 3]


def ring(centre: ArrayLike, normal: np.ndarray, radius: float, count: int = 12) -> np.ndarray:
    """Points of a circle, shape (count, 3)."""
    x, y = across(unit(np.asarray(normal, dtype=float)))
    turn = np.linspace(0, 2 * np.pi, count, endpoint=False)[:, None]
    return np.asarray(centre) + radius * (np.cos(turn) * x + np.sin(turn) * y)


def block(low: Sequence[float] | np.ndarray, high: Sequence[float] | np.ndarray) -> np.ndarray:
    """The corners of a box between two points."""
    return np.stack(np.meshgrid(*zip(low, high, strict=True)), axis=-1).reshape(-1, 3)


def _between(rings: Sequence[np.ndarray]) -> np.ndarray:
    """Triangles between each ring of points and the next."""
    points = np.asarray(rings)
    a, b, following = points[:-1], points[1:], np.roll(points, -1, axis=1)
    quads = [(a, following[:-1], following[1:]), (a, following[1:], b)]
    return np.concatenate([np.stack(corners, axis=-2).reshape(-1, 3, 3) for corners in quads])


def across(axis: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Two unit vectors perpendicular to a unit vector and to each other."""
    x = unit(np.cross(axis, [1.0, 0, 0] if abs(axis[0]) < 0.6 else [0, 1.0, 0]))
    return x, np.cross(axis, x)


def _short(vector: ArrayLike, digits: int = 2) -> list:
    return (np.asarray(vector).round(digits) + 0.0).tolist()
