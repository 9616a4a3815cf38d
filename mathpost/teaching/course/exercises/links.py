"""The exercises of lesson 04: links, and the chain of a machine."""

import numpy as np
import sympy as sp

from mathpost import chain
from mathpost.teaching.course.answers import Angle, Names, Number, Written
from mathpost.teaching.course.exercises.rotation import Rx, Rz, zxz
from mathpost.teaching.course.lesson_data import load
from mathpost.teaching.course.verdict import define, slip


@define("04-links", Names)
def links(extra=20):
    """The two changes cancel at the tip. On `ac_head`, where X Y Z name the pivot, the tool link alone changes."""

    def lift(height):
        T = np.eye(4)
        T[2, 3] = height
        return T

    def chain_with(length):  # at X0 Y0 Z0 A40 C25
        turned_c = link(Rz(np.radians(25)), np.zeros(3))
        turned_a = link(Rx(np.radians(40)), np.array([0, 0, -50]))
        # X Y Z name the tip, so the nose is `length` above it, and the tool leads back down
        named = {"workpiece": lift(0), "C": turned_c, "A": turned_a, "linear": lift(length), "tool": lift(-length)}
        return named

    link = write_link()
    before = chain_with(120)
    after = chain_with(120 + extra)
    assert np.allclose(before["linear"] @ before["tool"], after["linear"] @ after["tool"])
    return [name for name in before if not np.allclose(before[name], after[name])]


@define(
    "04-same", Angle(decimals=1), drawn=lambda rng: {"a": rng.randrange(20, 65, 5), "c": rng.randrange(10, 80, 5)}
)
@slip("same C", lambda c: c)
@slip("wrong way", lambda c: c + 90)
def same_axis(a=35, c=20):
    """sin B cos C' = sin A sin C and sin B sin C' = -sin A cos C: with B = A it is C' = C - 90."""
    table = Rz(np.radians(c)) @ Rx(np.radians(a))
    n = table[:, 2]  # (sin B cos C', sin B sin C', cos B) on the other machine
    return np.degrees(np.arctan2(n[1], n[0]))


@define("04-lean", Angle(decimals=2), drawn=lambda rng: {"radius": rng.randrange(20, 80, 5)})
@slip("outwards", lambda radius: -lean(radius))
@slip("tangent", inverse=np.arctan)
@slip("to the nose", lambda radius: -np.degrees(np.arcsin(radius / load("ac_head").machine.programmed_point[2])))
@slip("from the nose", lambda radius: -np.degrees(np.arcsin(radius / load("ac_head").machine.tool_length)))
def lean(radius=40, inverse=np.arcsin):
    """The pivot stands over the middle: radius + L·sin(lean) = 0."""
    model = load("ac_head").machine
    pivot_to_tip = model.programmed_point[2] + model.tool_length  # 200 + 150
    return -np.degrees(inverse(radius / pivot_to_tip))


@define("04-sign", Number(), drawn=lambda rng: {"a": rng.choice([20, 25, 35, 40, 50, 55])})
@slip("as a head", lambda a: table_sign(-a))
def table_sign(a=30, component=1):
    """Right-handed about X the tool axis goes from Z towards -Y: the same on a table and on a head."""
    n = Rx(np.radians(a)) @ [0, 0, 1]
    return n[component]


def turn_and_point(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """A rotation matrix and a point."""
    return zxz(*rng.uniform(-3, 3, 3)), rng.uniform(-100, 100, 3)


@define("04-write", Written("link(R, p)", turn_and_point))
@slip("p", lambda: lambda R, p: np.array(chain.homogeneous(sp.Matrix(R), sp.Matrix(p)), dtype=float))
@slip("R p", lambda: lambda R, p: np.array(chain.homogeneous(sp.Matrix(R), sp.Matrix(R @ p)), dtype=float))
@slip("negated", lambda: lambda R, p: np.array(chain.homogeneous(sp.Matrix(R), sp.Matrix(R @ p - p)), dtype=float))
@slip(
    "inverse", lambda: lambda R, p: np.array(chain.homogeneous(sp.Matrix(R.T), sp.Matrix(p - R.T @ p)), dtype=float)
)
def write_link():
    """Move the line to the origin, turn, move it back: R (q - p) + p = R q + (p - R p)."""

    def link(R, p):
        T = np.eye(4)
        T[:3, :3] = R
        T[:3, 3] = p - R @ p
        return T

    return link
