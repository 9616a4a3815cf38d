"""Rigid frames: rotation and origin, the frames of a machine by name, and the frame of I++ DME (source 003)."""

from dataclasses import dataclass

import numpy as np

from mathpost import angles as euler
from mathpost import chain
from mathpost.errors import InputError, as_array
from mathpost.rotation import as_rotation, numeric, unit, zxz_right


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
    origin: np.ndarray = (0.0, 0.0, 0.0)  # the child's in the parent, mm, shape (..., 3)
    parent: str = ""  # a name, such as "MCS", or nothing
    child: str = ""  # the same, such as "WCS"

    def __post_init__(self):
        object.__setattr__(self, "rotation", as_rotation(self.rotation))
        object.__setattr__(self, "origin", as_array(self.origin, 3, "origin"))

    @classmethod
    def from_axes(cls, z, x, origin=(0.0, 0.0, 0.0), parent="", child=""):
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
        return cls(np.stack(columns, axis=-1), origin, parent, child)

    @classmethod
    def from_matrix(cls, matrix, parent="", child=""):
        """Build a frame from a 4×4 homogeneous matrix, shape (..., 4, 4)."""
        matrix = as_array(matrix, 4, "matrix")
        if matrix.shape[-2:] != (4, 4) or not np.allclose(matrix[..., 3, :], [0, 0, 0, 1], atol=1e-12):
            raise InputError("matrix", "shape (..., 4, 4) with last row 0 0 0 1", f"shape {matrix.shape}")
        return cls(matrix[..., :3, :3], matrix[..., :3, 3], parent, child)

    @property
    def x(self):
        """The child's X axis in the parent, shape (..., 3)."""
        return self.rotation[..., 0]

    @property
    def y(self):
        """The child's Y axis in the parent, shape (..., 3)."""
        return self.rotation[..., 1]

    @property
    def z(self):
        """The child's Z axis in the parent, shape (..., 3)."""
        return self.rotation[..., 2]

    @property
    def matrix(self):
        """The 4×4 homogeneous matrix, shape (..., 4, 4)."""
        shape = np.broadcast_shapes(self.rotation.shape[:-2], self.origin.shape[:-1])
        matrix = np.zeros((*shape, 4, 4))
        matrix[..., :3, :3], matrix[..., :3, 3], matrix[..., 3, 3] = self.rotation, self.origin, 1.0
        return matrix

    def point(self, points):
        """Return the parent's coordinates of points given in the child, shape (..., 3)."""
        return self.direction(as_array(points, 3, "point")) + self.origin

    def direction(self, directions):
        """Return the parent's components of directions given in the child, shape (..., 3)."""
        return (self.rotation @ as_array(directions, 3, "direction")[..., None])[..., 0]

    def inverse(self):
        """Return the parent in the child: child_from_parent."""
        back = np.swapaxes(self.rotation, -1, -2)
        return Frame(back, -(back @ self.origin[..., None])[..., 0], self.child, self.parent)

    def __matmul__(self, inner):
        """Compose: parent_from_child @ child_from_grandchild = parent_from_grandchild."""
        if not isinstance(inner, Frame):
            return NotImplemented
        if self.child and inner.parent and self.child != inner.parent:
            found = f"{self.parent or '?'} from {self.child} @ {inner.parent} from {inner.child or '?'}"
            raise InputError("frames", f"a frame in {self.child} on the right", found)
        return Frame(self.rotation @ inner.rotation, self.point(inner.origin), self.parent, inner.child)


def machine_frames(machine, joints, *, degrees=False):
    """Return where the workpiece and the tool of a machine stand, WCS in MCS and TCS in MCS, as two `Frame`.

    `joints`, shape (..., 5), are those of `Kinematics.forward`. The tool's origin is the tip, its Z the tool axis.
    The way of a point from tool to workpiece is ``machine_from_workpiece.inverse() @ machine_from_tool``.

    Examples
    --------
    >>> from mathpost import machine
    >>> workpiece, tool = machine_frames(machine.load("ac_table"), [10, 0, 30, 0, 90], degrees=True)
    >>> (workpiece.inverse() @ tool).origin.round(6) + 0.0
    array([ 0., 10., 30.])
    """
    x, y, z, first, second = np.moveaxis(as_array(joints, 5, "joints"), -1, 0)
    if degrees:
        first, second = np.deg2rad(first), np.deg2rad(second)
    bodies, symbols = dict(chain.bodies(machine)), chain.joint_symbols(machine)
    matrices = (numeric(bodies[name], symbols)(x, y, z, first, second) for name in ("workpiece", "tool"))
    return tuple(Frame.from_matrix(m, "MCS", child) for m, child in zip(matrices, ("WCS", "TCS"), strict=True))


@dataclass
class CsyTransform:
    """The coordinate transform of I++ DME's SetCsyTransformation, after source 003, with its lost signs restored.

    The machine frame, turned by psi about its Z, by theta about the new X and by phi about the newest Z, is
    parallel to the part frame; (x0, y0, z0) is the machine's origin in part coordinates, mm. Mind the order:
    the arguments are theta, psi, phi, the turns are psi, theta, phi. Forward is from machine to part.

    Lengths are mm; angles are degrees, kept as given.

    Examples
    --------
    >>> CsyTransform(100, 200, 300, 35, 50, -20).forward_point([1, 2, 3]).round(6)
    array([101.309636, 202.760718, 302.159466])
    """

    x0: float = 0.0
    y0: float = 0.0
    z0: float = 0.0
    theta: float = 0.0
    psi: float = 0.0
    phi: float = 0.0

    def __post_init__(self):
        self.update(*self.parameters)

    def update(self, x0, y0, z0, theta, psi, phi):
        """Set all six parameters anew, in place, and return the transform."""
        values = as_array([x0, y0, z0, theta, psi, phi], 6, "x0, y0, z0, theta, psi, phi")
        if values.ndim != 1:
            raise InputError("x0, y0, z0, theta, psi, phi", "six single numbers", f"shape {values.shape}")
        self.x0, self.y0, self.z0, self.theta, self.psi, self.phi = map(float, values)
        return self

    @classmethod
    def from_matrix(cls, matrix, origin=(0.0, 0.0, 0.0)):
        """Read the parameters back from the passive 3×3 matrix.

        theta comes out in [0, 180], which makes the angles unique; at 0 and at 180, where only psi + phi or
        psi − phi is defined, phi is 0.

        Examples
        --------
        >>> CsyTransform.from_matrix(CsyTransform(theta=180, psi=50, phi=-20).matrix).parameters
        (0.0, 0.0, 0.0, 180.0, 70.0, 0.0)
        """
        if np.shape(matrix) != (3, 3):
            raise InputError("matrix", "shape (3, 3)", f"shape {np.shape(matrix)}")
        psi, theta, phi = euler.angles("ZXZ", np.transpose(matrix), lock="third", degrees=True)
        return cls(*as_array(origin, 3, "origin"), theta, psi, phi)

    @classmethod
    def from_axes(cls, z, x, origin=(0.0, 0.0, 0.0)):
        """Build the transform from nine parameters, as STEP does: the machine's Z and X axes in part coordinates.

        `x` need not be perpendicular to `z`, see `Frame.from_axes`; `origin` is (x0, y0, z0).
        """
        return cls.from_matrix(Frame.from_axes(z, x).rotation, origin)

    def to_axes(self):
        """Return the nine parameters: the machine's Z axis, its X axis and its origin, in part coordinates."""
        frame = self.frame
        return frame.z, frame.x, frame.origin

    @property
    def matrix(self):
        """The source's M, shape (3, 3): p_part = M @ p_machine + (x0, y0, z0)."""
        return zxz_right(self.psi, self.theta, self.phi, degrees=True)

    @property
    def parameters(self):
        """The six parameters, x0 y0 z0 theta psi phi, in mm and degrees."""
        return self.x0, self.y0, self.z0, self.theta, self.psi, self.phi

    @property
    def origin(self):
        """The machine's origin in part coordinates, shape (3,), mm."""
        return np.array([self.x0, self.y0, self.z0])

    @property
    def frame(self):
        """The machine in the part as a `Frame`: part_from_machine."""
        return Frame(self.matrix, self.origin, "part", "machine")

    def twin(self):
        """Return the same transform by its other three angles: (−theta, psi + 180, phi + 180)."""
        psi, theta, phi = euler.twin("ZXZ", [self.psi, self.theta, self.phi], degrees=True)
        return CsyTransform(*self.origin, theta, psi, phi)

    def forward_point(self, points):
        """Return the part coordinates of points given in the machine, shape (..., 3)."""
        return self.frame.point(points)

    def inverse_point(self, points):
        """Return the machine coordinates of points given in the part, shape (..., 3)."""
        return self.frame.inverse().point(points)

    def forward_direction(self, directions):
        """Return the part components of directions given in the machine, shape (..., 3): no origin in it."""
        return self.frame.direction(directions)

    def inverse_direction(self, directions):
        """Return the machine components of directions given in the part, shape (..., 3)."""
        return self.frame.inverse().direction(directions)
