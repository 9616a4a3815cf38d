"""The coordinate transform of I++ DME, SetCsyTransformation, after source 003."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from mathpost import euler
from mathpost.errors import InputError, as_array
from mathpost.frame import Frame
from mathpost.sources.recipes import zxz_right


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

    def __post_init__(self) -> None:
        self.update(*self.parameters)

    def update(self, x0: float, y0: float, z0: float, theta: float, psi: float, phi: float) -> CsyTransform:
        """Set all six parameters anew, in place, and return the transform."""
        values = as_array([x0, y0, z0, theta, psi, phi], 6, "x0, y0, z0, theta, psi, phi")
        if values.ndim != 1:
            raise InputError("x0, y0, z0, theta, psi, phi", "six single numbers", f"shape {values.shape}")
        self.x0, self.y0, self.z0, self.theta, self.psi, self.phi = map(float, values)
        return self

    @classmethod
    def from_matrix(cls, matrix: ArrayLike, origin: ArrayLike = (0.0, 0.0, 0.0)) -> CsyTransform:
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
        x0, y0, z0 = as_array(origin, 3, "origin")
        return cls(x0, y0, z0, theta, psi, phi)

    @classmethod
    def from_axes(cls, z: ArrayLike, x: ArrayLike, origin: ArrayLike = (0.0, 0.0, 0.0)) -> CsyTransform:
        """Build the transform from nine parameters, as STEP does: the machine's Z and X axes in part coordinates.

        `x` need not be perpendicular to `z`, see `Frame.from_axes`; `origin` is (x0, y0, z0).
        """
        return cls.from_matrix(Frame.from_axes(z, x).rotation, origin)

    def to_axes(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the nine parameters: the machine's Z axis, its X axis and its origin, in part coordinates."""
        frame = self.frame
        return frame.z, frame.x, frame.origin

    @property
    def matrix(self) -> np.ndarray:
        """The source's M, shape (3, 3): p_part = M @ p_machine + (x0, y0, z0)."""
        return zxz_right(self.psi, self.theta, self.phi, degrees=True)

    @property
    def parameters(self) -> tuple[float, ...]:
        """The six parameters, x0 y0 z0 theta psi phi, in mm and degrees."""
        return self.x0, self.y0, self.z0, self.theta, self.psi, self.phi

    @property
    def origin(self) -> np.ndarray:
        """The machine's origin in part coordinates, shape (3,), mm."""
        return np.array([self.x0, self.y0, self.z0])

    @property
    def frame(self) -> Frame:
        """The machine in the part as a `Frame`: part_from_machine."""
        return Frame(self.matrix, self.origin, "part", "machine")

    def twin(self) -> CsyTransform:
        """Return the same transform by its other three angles: (−theta, psi + 180, phi + 180)."""
        psi, theta, phi = euler.twin("ZXZ", [self.psi, self.theta, self.phi], degrees=True)
        return CsyTransform(self.x0, self.y0, self.z0, theta, psi, phi)

    def forward_point(self, points: ArrayLike) -> np.ndarray:
        """Return the part coordinates of points given in the machine, shape (..., 3)."""
        return self.frame.point(points)

    def inverse_point(self, points: ArrayLike) -> np.ndarray:
        """Return the machine coordinates of points given in the part, shape (..., 3)."""
        return self.frame.inverse().point(points)

    def forward_direction(self, directions: ArrayLike) -> np.ndarray:
        """Return the part components of directions given in the machine, shape (..., 3), without the origin."""
        return self.frame.direction(directions)

    def inverse_direction(self, directions: ArrayLike) -> np.ndarray:
        """Return the machine components of directions given in the part, shape (..., 3)."""
        return self.frame.inverse().direction(directions)
