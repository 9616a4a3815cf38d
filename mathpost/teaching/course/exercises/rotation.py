"""The exercises of lessons 00 to 02: rotations and Euler angles.

The solutions are worked with functions that the learner has written: `Rx`, `Ry` and `Rz` in 01-write, `zxz` in
02-write, `ijk`, which reads the angles back, in section 3 of lesson 02.
"""

import random

import numpy as np
from numpy.typing import ArrayLike

from mathpost import euler
from mathpost.detective.euler_angles import explain
from mathpost.rotation import ACTIVE
from mathpost.sources.recipes import zxz_right, zxz_steps
from mathpost.teaching.course.answers import Angle, Name, Number, Pose, Vector, Written
from mathpost.teaching.course.verdict import define, slip

POINT = (3, 4, 5)
SLIP = ((20, 70, 50), (3.278276, -0.856658, 6.206371))  # angles, and the point that the colleague of 01-slip shows


def Rx(t: float) -> np.ndarray:
    """The active matrix of a turn about X, radians."""
    return np.array(ACTIVE["X"](t), dtype=float)


def Ry(t: float) -> np.ndarray:
    """The active matrix of a turn about Y, radians."""
    return np.array(ACTIVE["Y"](t), dtype=float)


def Rz(t: float) -> np.ndarray:
    """The active matrix of a turn about Z, radians."""
    return np.array(ACTIVE["Z"](t), dtype=float)


def zxz(i: float, j: float, k: float) -> np.ndarray:
    """The frame of three ZXZ angles, radians."""
    return Rz(i) @ Rx(j) @ Rz(k)


def ijk(frame: np.ndarray) -> np.ndarray:
    """The three ZXZ angles of a frame, degrees: I by its z, J and K after the first turn is undone."""
    i = np.arctan2(frame[0, 2], -frame[1, 2])
    rest = Rz(-i) @ frame
    j = np.arctan2(-rest[1, 2], rest[2, 2])
    k = np.arctan2(-rest[0, 1], rest[0, 0])
    return np.degrees([i, j, k])


def unit(vector: ArrayLike) -> np.ndarray:
    """A vector scaled to length 1."""
    return np.array(vector) / np.linalg.norm(vector)


def random_vectors(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Two unit vectors that are perpendicular to each other."""
    x = unit(rng.normal(size=3))
    return x, unit(np.cross(rng.normal(size=3), x))


@define("00-write", Written("third_axis(x, y)", random_vectors))
@slip("left-handed", lambda: lambda x, y: np.cross(y, x))
@slip("by component", lambda: lambda x, y: x * y)
@slip("middle", lambda: lambda x, y: np.cross(x, y) * [1, -1, 1])
def third_axis():
    """The cross product of X and Y, in this order, is the Z of a right-handed frame."""

    def third_axis(x, y):
        return [x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]]

    return third_axis


def drawn_point(rng: random.Random) -> dict[str, tuple[int, ...]]:
    """Three different coordinates that are easy to turn in the head."""
    return {"point": tuple(rng.sample(range(2, 10), 3))}


@define("01-sign", Vector(), drawn=drawn_point)
def sign(angle=90, point=POINT):
    """The new X stands where Y was, so x' is the old y; the new Y points along -X, so y' is minus the old x."""
    t = np.radians(angle)
    new_x = [np.cos(t), np.sin(t), 0]
    new_y = [-np.sin(t), np.cos(t), 0]
    new_z = [0, 0, 1]
    return [np.dot(new_x, point), np.dot(new_y, point), np.dot(new_z, point)]


@define(
    "01-point",
    Vector(),
    detective=lambda answer, point: explain((25, 90, 0), point, np.round(answer, 6)),
    drawn=drawn_point,
)
@slip("active", lambda angles, point: zxz_steps("right", angles, point, elementary=ACTIVE, degrees=True)[-1].value)
@slip("radians", lambda angles, point: zxz_right(*angles) @ point)
def by_hand(angles=(25, 90, 0), point=POINT):
    """X' = (cos 25°, sin 25°, 0), Y' = (0, 0, 1), Z' = (sin 25°, -cos 25°, 0): three dot products."""
    alpha, beta, gamma = np.radians(angles)
    frame = Rz(alpha) @ Rx(beta) @ Rz(gamma)  # its columns are X', Y', Z'
    return [np.dot(axis, point) for axis in frame.T]


@define("01-slip", Name, given=lambda: SLIP)
def kind_of_matrix():
    """With active matrices the sheet's product gives its point. Look at the minus before the sine, in all six."""
    alpha, beta, gamma = np.radians(SLIP[0])
    with_active = Rz(gamma) @ Rx(beta) @ Rz(alpha) @ POINT  # as the sheet multiplies, γ β α
    return "active" if np.allclose(with_active, SLIP[1], atol=1e-6) else "passive"


@define("01-still", Name)
def still():
    """The last turn is about the newest Z, and turning about an axis keeps the coordinate along it."""
    before = zxz(0.3, 1.1, 0.0).T @ POINT
    after = zxz(0.3, 1.1, 0.8).T @ POINT
    same = np.isclose(before, after)
    return "xyz"[int(np.argmax(same))]


@define("01-write", Written("my_Rz(t)", lambda rng: [rng.uniform(-3, 3)]))
@slip("transposed", lambda: lambda t: Rz(-t))
@slip("degrees", lambda: lambda t: Rz(np.radians(t)))
def write_rz():
    """The columns are where X, Y and Z go: (cos t, sin t, 0), (-sin t, cos t, 0) and (0, 0, 1)."""

    def Rz(t):
        x_turned = [np.cos(t), np.sin(t), 0]
        y_turned = [-np.sin(t), np.cos(t), 0]
        z_stays = [0, 0, 1]
        return np.column_stack([x_turned, y_turned, z_stays])

    return Rz


@define("02-frame", Pose())
@slip("transposed", lambda: ijk(np.column_stack([(0, 0, -1), (-1, 0, 0), (0, 1, 0)]).T))
@slip("minus forgotten", lambda: frame() * [-1, 1, 1] + [180, 0, 0])
@slip("any X", lambda: euler.from_direction("ZXZ", [0, 1, 0], degrees=True))
@slip("ZYZ", lambda: euler.angles("ZYZ", np.column_stack([(0, 0, -1), (-1, 0, 0), (0, 1, 0)]), degrees=True))
def frame(z=(0, 1, 0), x=(0, 0, -1)):
    """Z alone gives I and J; X, along the slope, gives K. The twin with -J would have been right too."""
    F = np.column_stack([x, np.cross(z, x), z])
    i = np.arctan2(F[0, 2], -F[1, 2])
    rest = Rz(-i) @ F  # the first turn undone: Rx(J) Rz(K) is left
    j = np.arctan2(-rest[1, 2], rest[2, 2])
    k = np.arctan2(-rest[0, 1], rest[0, 0])
    return np.degrees([i, j, k])


@define("02-twin", Angle(decimals=2), drawn=lambda rng: {"angles": tuple(rng.sample(range(15, 60, 5), 3))})
@slip("other way", lambda angles: -twin(angles))
@slip("sum", lambda angles: sum(angles))
def twin(angles=(20, 30, 40)):
    """The same as before: a twin is another name of the same rotation, and the axis with its angle has no names."""
    i, j, k = np.radians(angles)
    F = zxz(i + np.pi, -j, k + np.pi)
    return np.degrees(np.arccos((np.trace(F) - 1) / 2))  # the trace is 1 + 2 cos t


@define("02-lock", Number(decimals=0, unit="degrees", said="one angle"))
def lock():
    """SPB = 90° lays the part's X onto the fixed Z, about which SPC turns: only SPA - SPC is left."""
    # SPB takes X to (cos SPB, 0, -sin SPB). That lies on Z where the cosine is 0.
    return np.degrees(np.arccos(0.0))


@define("02-order", Name, given=lambda: "F = Rz(c) @ Ry(b) @ Rx(a)")
def order():
    """About the fixed X, the fixed Y, the fixed Z. The comment needs Rx(a)·Ry(b)·Rz(c), in SciPy's spelling XYZ."""
    a, b, c = 0.1, 0.2, 0.3
    program = Rz(c) @ Ry(b) @ Rx(a)
    fixed = Rx(a)
    fixed = Ry(b) @ fixed  # about a fixed axis: on the left
    fixed = Rz(c) @ fixed
    return "fixed" if np.allclose(program, fixed) else "moving"


@define("02-write", Written("zxz(i, j, k)", lambda rng: rng.uniform(-3, 3, 3)))
@slip("reversed", lambda: lambda i, j, k: zxz(k, j, i))
@slip("transposed", lambda: lambda i, j, k: zxz(i, j, k).T)
@slip("star", lambda: lambda i, j, k: Rz(i) * Rx(j) * Rz(k))
@slip("degrees", lambda: lambda i, j, k: zxz(*np.radians([i, j, k])))
@slip("ZYZ", lambda: lambda i, j, k: Rz(i) @ Ry(j) @ Rz(k))
@slip("passive", lambda: lambda i, j, k: Rz(-i) @ Rx(-j) @ Rz(-k))
def write_zxz():
    """About moving axes a later turn stands further right: Rz(I) Rx(J) Rz(K)."""

    def zxz(i, j, k):
        return Rz(i) @ Rx(j) @ Rz(k)

    return zxz
