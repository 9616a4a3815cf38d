"""Solids of a picture in space, small enough to travel with it: turned profiles, joined rings, convex hulls.

A solid is in the coordinates of the body that it belongs to. Each kind has `triangles`, shape (n, 3, 3),
counterclockwise seen from outside, the same that the module in the browser makes, and `state`, for the browser.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy

from mathpost.rotation import unit

SIDES = 40  # of a turned solid
CREASE = 0.8  # cosine of the angle from which two faces meet in an edge


class Solid:
    """What a picture needs of every kind."""

    @cached_property
    def surface(self):
        """The triangles, and the normals at their corners, both of shape (n, 3, 3)."""
        triangles = self.triangles()
        return triangles, smooth(triangles)


@dataclass
class Turned(Solid):
    """A solid of revolution: `profile` (radius, height) from bottom to top, about `along` through `origin`."""

    body: str
    colour: str
    profile: list
    origin: np.ndarray
    along: np.ndarray

    def state(self):
        profile = [[round(r, 2), round(h, 2)] for r, h in self.profile]
        return {"profile": profile, "from": _short(self.origin), "along": _short(self.along, 9)}

    def triangles(self):
        return _between([ring(self.origin + h * self.along, self.along, r, SIDES) for r, h in self.profile])


@dataclass
class Lofted(Solid):
    """A solid through `rings`, shape (n, 3), counterclockwise seen from the last one; a ring may be one point."""

    body: str
    colour: str
    rings: list

    def state(self):
        return {"rings": [_short(ring) for ring in self.rings]}

    def triangles(self):
        count = max(map(len, self.rings))
        return _between([np.broadcast_to(ring, (count, 3)) for ring in self.rings])


@dataclass
class Hull(Solid):
    """The convex hull of `points`, shape (n, 3)."""

    body: str
    colour: str
    points: np.ndarray

    def faces(self):
        """Return the corners that count, shape (m, 3), and triangles of their numbers, shape (n, 3)."""
        hull = scipy.spatial.ConvexHull(self.points)
        a, b, c = np.moveaxis(self.points[hull.simplices], 1, 0)
        inwards = np.einsum("ij,ij->i", np.cross(b - a, c - a), hull.equations[:, :3]) < 0
        simplices = np.where(inwards[:, None], hull.simplices[:, ::-1], hull.simplices)
        return self.points[hull.vertices], np.searchsorted(hull.vertices, simplices)  # the vertices are sorted

    def state(self):
        corners, faces = self.faces()
        return {"corners": _short(corners), "faces": faces.tolist()}

    def triangles(self):
        corners, faces = self.faces()
        return corners[faces]


def smooth(triangles):
    """Return the normal of every corner, shape (n, 3, 3): the mean over faces that meet there without an edge."""
    a, b, c = np.moveaxis(triangles, 1, 0)
    flat = np.cross(b - a, c - a)
    flat /= np.maximum(np.linalg.norm(flat, axis=1, keepdims=True), 1e-300)
    _, place = np.unique(triangles.reshape(-1, 3).round(2), axis=0, return_inverse=True)
    place, owner = place.ravel(), np.repeat(np.arange(len(flat)), 3)
    normals, count = np.empty((len(place), 3)), np.bincount(place)
    order = np.argsort(place, kind="stable")
    for many in np.unique(count):  # all places where so many faces meet at once
        corners = order[np.repeat(count, count) == many].reshape(-1, many)
        meeting = flat[owner[corners]]
        near = meeting @ np.swapaxes(meeting, 1, 2) > CREASE
        normals[corners] = near @ meeting
    return (normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)).reshape(-1, 3, 3)


def put(matrix, points):
    """Return points (..., 3) of a body where the 4×4 `matrix` puts it."""
    return points @ matrix[:3, :3].T + matrix[:3, 3]


def ring(centre, normal, radius, count=12):
    """Points of a circle, shape (count, 3)."""
    x, y = across(unit(np.asarray(normal, dtype=float)))
    turn = np.linspace(0, 2 * np.pi, count, endpoint=False)[:, None]
    return np.asarray(centre) + radius * (np.cos(turn) * x + np.sin(turn) * y)


def block(low, high):
    """The corners of a box between two points."""
    return np.stack(np.meshgrid(*zip(low, high, strict=True)), axis=-1).reshape(-1, 3)


def _between(rings):
    """Triangles between each ring of points and the next."""
    rings = np.asarray(rings)
    a, b, following = rings[:-1], rings[1:], np.roll(rings, -1, axis=1)
    quads = [(a, following[:-1], following[1:]), (a, following[1:], b)]
    return np.concatenate([np.stack(corners, axis=-2).reshape(-1, 3, 3) for corners in quads])


def across(axis):
    """Two unit vectors square to a unit vector."""
    x = unit(np.cross(axis, [1.0, 0, 0] if abs(axis[0]) < 0.6 else [0, 1.0, 0]))
    return x, np.cross(axis, x)


def _short(vector, digits=2):
    return (np.round(vector, digits) + 0.0).tolist()
