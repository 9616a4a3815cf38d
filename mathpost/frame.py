"""Rigid frames: rotation and origin."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from mathpost.errors import InputError, as_array
from mathpost.rotation import as_rotation, unit


@dataclass(frozen=True, eq=False)
class Frame:
    """A child frame in its parent: p_parent = rotation @ p_child + origin.

    Name a variable after what it does to coordinates, ``parent_from_child``; given the names of both frames,
    the frame itself refuses a composition that skips one. `InputError` is raised if the axes are not orthonormal
    (says by how much) or left-handed, or something is not finite.

    Examples
    --------
    >>> machine_from_workpiece = Frame([[0, -1, 0], [1, 0, 0], [0, 0, 1]], [100, 0, 0], "MCS", "WCS")
    >>> machine_from_workpiece.point([10, 0, 5])
    array([100.,  10.,   5.])
    >>> machine_from_workpiece.inverse().point([100, 10, 5])
    array([10.,  0.,  5.])
    """

    rotation: np.ndarray  # the child's axes, as columns, in the parent, shape (..., 3, 3)
    origin: np.ndarray = field(default_factory=lambda: np.zeros(3))  # the child's in the parent, mm, (..., 3)
    parent: str = ""  # a name, such as "MCS", or nothing
    child: str = ""  # the same, such as "WCS"

    def __post_init__(self) -> None:
        object.__setattr__(self, "rotation", as_rotation(self.rotation))
        object.__setattr__(self, "origin", as_array(self.origin, 3, "origin"))

    @classmethod
    def from_axes(
        cls, z: ArrayLike, x: ArrayLike, origin: ArrayLike = (0.0, 0.0, 0.0), parent: str = "", child: str = ""
    ) -> Frame:
        """Build a frame from its Z axis and a reference direction for X, as STEP's axis2_placement_3d does.

        X is the part of `x` that is perpendicular to `z`, Y = Z × X. Shapes (..., 3), of any length above zero;
        `InputError` is raised if `x` is parallel to `z`.

        Examples
        --------
        >>> Frame.from_axes(z=[0, 0, 2], x=[1, 1, 5]).rotation.round(6) + 0.0
        array([[ 0.707107, -0.707107,  0.      ],
               [ 0.707107,  0.707107,  0.      ],
               [ 0.      ,  0.      ,  1.      ]])
        """
        z = unit(as_array(z, 3, "z"), "z")
        x = unit(as_array(x, 3, "x"), "x")
        square = np.cross(z, x)
        if (np.linalg.norm(square, axis=-1) < 1e-9).any():
            raise InputError("x", "a direction that is not parallel to z", "one that is")
        x = unit(np.cross(square, z))  # square to z to the last digit, however nearly parallel the two were
        columns = np.broadcast_arrays(x, np.cross(z, x), z)
        return cls(np.stack(columns, axis=-1), as_array(origin, 3, "origin"), parent, child)

    @classmethod
    def from_matrix(cls, matrix: ArrayLike, parent: str = "", child: str = "") -> Frame:
        """Build a frame from a 4×4 homogeneous matrix, shape (..., 4, 4)."""
        matrix = as_array(matrix, 4, "matrix")
        if matrix.shape[-2:] != (4, 4) or not np.allclose(matrix[..., 3, :], [0, 0, 0, 1], atol=1e-12):
            raise InputError("matrix", "shape (..., 4, 4) with last row 0 0 0 1", f"shape {matrix.shape}")
        return cls(matrix[..., :3, :3], matrix[..., :3, 3], parent, child)

    @property
    def x(self) -> np.ndarray:
        """The child's X axis in the parent, shape (..., 3)."""
        return self.rotation[..., 0]

    @property
    def y(self) -> np.ndarray:
        """The child's Y axis in the parent, shape (..., 3)."""
        return self.rotation[..., 1]

    @property
    def z(self) -> np.ndarray:
        """The child's Z axis in the parent, shape (..., 3)."""
        return self.rotation[..., 2]

    @property
    def matrix(self) -> np.ndarray:
        """The 4×4 homogeneous matrix, shape (..., 4, 4)."""
        shape = np.broadcast_shapes(self.rotation.shape[:-2], self.origin.shape[:-1])
        matrix = np.zeros((*shape, 4, 4))
        matrix[..., :3, :3], matrix[..., :3, 3], matrix[..., 3, 3] = self.rotation, self.origin, 1.0
        return matrix

    def point(self, points: ArrayLike) -> np.ndarray:
        """Return the parent's coordinates of points given in the child, shape (..., 3)."""
        return self.direction(as_array(points, 3, "point")) + self.origin

    def direction(self, directions: ArrayLike) -> np.ndarray:
        """Return the parent's components of directions given in the child, shape (..., 3)."""
        return (self.rotation @ as_array(directions, 3, "direction")[..., None])[..., 0]

    def inverse(self) -> Frame:
        """Return the parent in the child: child_from_parent."""
        back = np.swapaxes(self.rotation, -1, -2)
        return Frame(back, -(back @ self.origin[..., None])[..., 0], self.child, self.parent)

    def __matmul__(self, inner: Frame) -> Frame:
        """Compose: parent_from_child @ child_from_grandchild = parent_from_grandchild."""
        if not isinstance(inner, Frame):
            return NotImplemented
        if self.child and inner.parent and self.child != inner.parent:
            found = f"{self.parent or '?'} from {self.child} @ {inner.parent} from {inner.child or '?'}"
            raise InputError("frames", f"a frame in {self.child} on the right", found)
        return Frame(self.rotation @ inner.rotation, self.point(inner.origin), self.parent, inner.child)
