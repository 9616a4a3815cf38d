"""Simple solids in parallel projection: convex hulls, shaded by the light and sorted by depth into one collection.

Everything is drawn with flat polygons in ordinary axes: for a picture that follows a slider that is several times
faster than axes in three dimensions, and what is in front is decided over all bodies together.
"""

import numpy as np
from matplotlib.collections import PolyCollection
from matplotlib.colors import to_rgb
from scipy.spatial import ConvexHull

from mathpost.rotation import unit

LIGHT = unit(np.array([-0.35, -0.75, 0.9]))


class Camera:
    """A parallel projection, seen from `azimuth` and `elevation` (degrees) with Z upwards.

    Examples
    --------
    >>> Camera(azimuth=-90, elevation=0).project([[1.0, 2.0, 3.0]]).round(6) + 0.0
    array([[1., 3.]])
    """

    def __init__(self, azimuth=-60.0, elevation=24.0):
        a, e = np.radians([azimuth, elevation])
        self.towards = np.array([np.cos(a) * np.cos(e), np.sin(a) * np.cos(e), np.sin(e)])
        self.right = np.array([-np.sin(a), np.cos(a), 0.0])
        self.up = np.cross(self.towards, self.right)

    def project(self, points):
        """Return where points (..., 3) are seen, shape (..., 2)."""
        return np.asarray(points) @ np.stack([self.right, self.up], axis=-1)


class Solid:
    """A convex body of flat faces: the hull of `points`, shape (n, 3).

    Attributes
    ----------
    body : str
        The moving body that it belongs to.
    vertices : ndarray, shape (n, 3)
    faces : list of ndarray, shape (m, 3)
        Corners of each face, in order.
    normals : ndarray, shape (faces, 3)
        Outwards.
    layer : int
        Lower layers are drawn first: for a bed that everything else stands in front of.

    Examples
    --------
    >>> corners = np.stack(np.meshgrid([0, 1], [0, 1], [0, 1]), axis=-1).reshape(-1, 3)
    >>> [len(face) for face in Solid("bed", corners, "#7f7f7f").faces]
    [4, 4, 4, 4, 4, 4]
    """

    def __init__(self, body, points, colour, *, layer=1):
        points = np.asarray(points, dtype=float)
        hull = ConvexHull(points)
        # Triangles in one plane are one face, its corners in order about its middle.
        normals, group = np.unique(hull.equations.round(6), axis=0, return_inverse=True)
        self.body, self.colour, self.layer = body, np.array(to_rgb(colour)), layer
        self.vertices = points[hull.vertices]
        self.normals = normals[:, :3]
        self.faces = []
        for face, normal in enumerate(self.normals):
            corners = points[np.unique(hull.simplices[group.ravel() == face])]
            middle = corners.mean(axis=0)
            side = unit(corners[0] - middle)
            across = np.cross(normal, side)
            order = np.argsort(np.arctan2((corners - middle) @ across, (corners - middle) @ side))
            self.faces.append(corners[order])


class Solids:
    """All solids of a picture as one collection of `axes`, which `move` places and sorts anew."""

    def __init__(self, axes, solids, camera):
        self.camera = camera
        self.bodies = list(dict.fromkeys(solid.body for solid in solids))
        faces = [(number, face) for number, solid in enumerate(solids) for face in solid.faces]
        most = max(len(face) for _, face in faces)
        # Faces of fewer corners repeat their last one, so that all are one array.
        self.corners = np.stack([np.pad(face, ((0, most - len(face)), (0, 0)), "edge") for _, face in faces])
        self.solid = np.array([number for number, _ in faces])
        self.body = np.array([self.bodies.index(solid.body) for solid in solids])
        self.vertices = np.concatenate([solid.vertices for solid in solids])
        self.owner = np.repeat(np.arange(len(solids)), [len(solid.vertices) for solid in solids])
        self.normals = np.concatenate([solid.normals for solid in solids])
        self.colours = np.stack([solid.colour for solid in solids])[self.solid]
        self.layers = np.array([solid.layer for solid in solids])
        self.artist = PolyCollection([], linewidths=0.4, zorder=1)
        axes.add_collection(self.artist, autolim=False)

    def move(self, places):
        """Redraw with each body at its 4×4 matrix in `places`, a dict by name."""
        matrices = np.stack([places[body] for body in self.bodies])[self.body]
        turns, shifts = matrices[:, :3, :3], matrices[:, :3, 3]
        normals = np.einsum("nij,nj->ni", turns[self.solid], self.normals)
        corners = np.einsum("nij,nkj->nki", turns[self.solid], self.corners) + shifts[self.solid, None]
        vertices = np.einsum("nij,nj->ni", turns[self.owner], self.vertices) + shifts[self.owner]
        rank = np.argsort(self._back_to_front(normals, corners[:, 0], vertices))[self.solid]
        seen = np.flatnonzero(normals @ self.camera.towards > 1e-9)
        order = seen[np.argsort(rank[seen], kind="stable")]
        colours = self.colours[order] * (0.62 + 0.38 * np.clip(normals[order] @ LIGHT, 0, 1))[:, None]
        self.artist.set_verts(self.camera.project(corners[order]))
        self.artist.set_facecolor(colours)
        self.artist.set_edgecolor(0.8 * colours)

    def _back_to_front(self, normals, on_faces, vertices):
        """Numbers of the solids in the order of drawing.

        Of two convex bodies that a face of one of them keeps apart, the one on the viewer's side of it is in front.
        """
        faces, points = (np.searchsorted(each, np.arange(len(self.layers))) for each in (self.solid, self.owner))
        beyond = normals @ vertices.T - np.einsum("nj,nj->n", normals, on_faces)[:, None]
        apart = np.minimum.reduceat(beyond, points, axis=1) > -1e-6 * np.ptp(vertices, axis=0).max()
        facing = (normals @ self.camera.towards > 0)[:, None]
        above = np.logical_or.reduceat(apart & facing, faces, axis=0)  # [a, b]: b is in front of a
        below = np.logical_or.reduceat(apart & ~facing, faces, axis=0)  # [a, b]: b is behind a
        in_front = (above | below.T) & ~(below | above.T)
        flat = self.camera.project(vertices)
        low, high = np.minimum.reduceat(flat, points), np.maximum.reduceat(flat, points)
        in_front &= ((low[:, None] <= high) & (low <= high[:, None])).all(axis=-1)
        in_front &= self.layers[:, None] <= self.layers
        depth = np.add.reduceat(vertices @ self.camera.towards, points) / np.bincount(self.owner)
        far = np.lexsort([depth, self.layers])
        order, left = [], np.ones(len(depth), bool)
        for _ in depth:  # the farthest of those that nothing left must be behind; bodies that interlock go by depth
            free = left & ~(in_front & left[:, None]).any(axis=0)
            order.append(far[(free if free.any() else left)[far]][0])
            left[order[-1]] = False
        return order


def ring(centre, normal, radius, count=16):
    """Points of a circle, shape (count, 3)."""
    normal = unit(np.asarray(normal, dtype=float))
    side = unit(np.cross(normal, np.eye(3)[np.abs(normal).argmin()]))
    turn = np.linspace(0, 2 * np.pi, count, endpoint=False)[:, None]
    return np.asarray(centre) + radius * (np.cos(turn) * side + np.sin(turn) * np.cross(normal, side))


def cylinder(start, end, radius, end_radius=None, count=16):
    """Points of a cylinder or cone between two points."""
    along = np.asarray(end, dtype=float) - start
    return np.concatenate(
        [ring(start, along, radius, count), ring(end, along, radius if end_radius is None else end_radius, count)]
    )


def block(low, high):
    """The corners of a box between two points."""
    return np.stack(np.meshgrid(*zip(low, high, strict=True)), axis=-1).reshape(-1, 3)
