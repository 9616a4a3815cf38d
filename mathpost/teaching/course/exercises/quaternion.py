"""The exercises of lesson 02b: axis, rotation vector, quaternions."""

import numpy as np

from mathpost import euler
from mathpost.teaching.course.answers import Pose, Vector, Written
from mathpost.teaching.course.verdict import define, slip


@define("02b-vector", Vector(unit="radians"))
@slip("axis alone", lambda: np.divide(rotation_vector(), 2 * np.pi / 3))
@slip("of the quaternion", lambda: np.divide(rotation_vector(), 2 * np.pi / 3) * np.sin(np.pi / 3))
def rotation_vector(transposed=False):
    """The trace is 0, so the cosine is -1/2 and the angle 120°; R - Rᵀ gives the axis with its sign."""
    R = np.column_stack([(0, -1, 0), (0, 0, -1), (1, 0, 0)])
    R = R.T if transposed else R
    t = np.arccos((np.trace(R) - 1) / 2)
    skew = R - R.T  # 2 v sin t
    axis = np.array([skew[2, 1], skew[0, 2], skew[1, 0]]) / (2 * np.sin(t))
    return t * axis


@define("02b-product", Pose())
@slip("exchanged", lambda: both_turns(first=(0, 0, 1), second=(1, 0, 0)))
@slip("whole angle", lambda: both_turns(half=90))
def both_turns(first=(1, 0, 0), second=(0, 0, 1), half=45):
    """The later turn multiplies from the left: (c + s k)(c + s i) = c² + cs i + s² ki + cs k, and ki = j."""
    c, s = np.cos(np.radians(half)), np.sin(np.radians(half))
    a, b = np.multiply(s, second), np.multiply(s, first)
    w = c * c - np.dot(a, b)
    x, y, z = c * a + c * b + np.cross(a, b)
    return w, x, y, z


def quaternion_and_point(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """A unit quaternion (w, x, y, z) and a point."""
    q = rng.normal(size=4)
    return q / np.linalg.norm(q), rng.uniform(-10, 10, 3)


@define("02b-write", Written("turned(q, p)", quaternion_and_point))
@slip("inverse", lambda: lambda q, p: euler.from_quaternion(q).T @ p)
@slip("last", lambda: lambda q, p: euler.from_quaternion(np.roll(q, 1)) @ p)
@slip("once", lambda: lambda q, p: q[0] * p + np.cross(q[1:], p))
@slip("same on both sides", lambda: lambda q, p: turned_twice(q, p))
def write_turned():
    """With the vector part v of q: the product w p + v × p, and then -v·p, times q* from the right."""

    def turned(q, p):
        w, v = q[0], np.array(q[1:])
        scalar, vector = -np.dot(v, p), w * np.array(p) + np.cross(v, p)  # q p
        return w * vector - scalar * v - np.cross(vector, v)  # times (w, -v)

    return turned


def turned_twice(q: np.ndarray, p: np.ndarray) -> np.ndarray:
    """The vector part of q p q, where the second factor should be q*."""
    w, v = q[0], q[1:]
    scalar, vector = -np.dot(v, p), w * p + np.cross(v, p)
    return w * vector + scalar * v + np.cross(vector, v)
