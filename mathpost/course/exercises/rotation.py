"""The exercises of lessons 00 to 04: rotations, Euler angles, the tilted plane, the chain.

The solutions are worked with functions that the learner has written: `Rx`, `Ry` and `Rz` in 01-write, `zxz` in
02-write, `ijk`, which reads the angles back, in section 3 of lesson 02.
"""

import random
from collections.abc import Sequence
from itertools import permutations

import numpy as np
import sympy as sp
from numpy.typing import ArrayLike

from mathpost import chain, euler
from mathpost.course.answers import Angle, Name, Names, Number, Pose, Vector, Written
from mathpost.course.lesson_data import load
from mathpost.course.verdict import define, slip
from mathpost.detective.euler_angles import explain
from mathpost.plane import positioning
from mathpost.plane.positioning import align
from mathpost.plane.tilted_plane import Plane
from mathpost.rotation import ACTIVE, wrap
from mathpost.sources.recipes import zxz_right, zxz_steps

POINT = (3, 4, 5)
SLIP = ((20, 70, 50), (3.278276, -0.856658, 6.206371))  # angles, and the point that the colleague of 01-slip shows
ORDERS = Name({"".join(order): [] for order in permutations("XYZ")})


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
    detective=lambda answer, point: explain((30, 90, 0), point, np.round(answer, 6)),
    drawn=drawn_point,
)
@slip("active", lambda angles, point: zxz_steps("right", angles, point, elementary=ACTIVE, degrees=True)[-1].value)
@slip("radians", lambda angles, point: zxz_right(*angles) @ point)
def by_hand(angles=(30, 90, 0), point=POINT):
    """X' = (cos 30°, sin 30°, 0), Y' = (0, 0, 1), Z' = (sin 30°, -cos 30°, 0): three dot products."""
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


@define("01-write", Written("Rz(t)", lambda rng: [rng.uniform(-3, 3)]))
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


@define("02-lock", Angle(decimals=0))
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
def write_zxz():
    """About moving axes a later turn stands further right: Rz(I) Rx(J) Rz(K)."""

    def zxz(i, j, k):
        return Rz(i) @ Rx(j) @ Rz(k)

    return zxz


@define("03-plane", Pose())
def plane():
    """I lays X along the old Y, J tilts about it, and K takes I's turn back again: I = 90, K = -90."""
    tilted = Ry(np.radians(30))
    return ijk(tilted)


@define("03-face", Pose())
@slip("leaning", lambda: face_angles() - [90, 0, 0])
@slip("minus forgotten", lambda: face_angles() * [-1, 1, 1] + [180, 0, 0])
def face_angles(x=(1, 2, 0), inverted=False):
    """Z × z is horizontal and lies in the face: it is (1, 2, 0). The frame on it has K = 0."""
    z = unit((2, -1, 2))
    x = unit(x)
    F = np.column_stack([x, np.cross(z, x), z])
    return ijk(F.T if inverted else F)


@define("03-mode", ORDERS)
@slip("from the left", lambda: mode_39()[::-1])
def mode_39(mode=39):
    """39 is 10 01 11 in bits. From the right: 3 is Z, 1 is X, 2 is Y."""
    axes = ""
    for _turn in range(3):
        axes += "XYZ"[mode % 4 - 1]  # the two lowest bits
        mode = mode // 4
    return axes


def three_points(rng: np.random.Generator) -> np.ndarray:
    """Three points of a face that is neither horizontal nor vertical."""
    return rng.uniform(-50, 50, (3, 3))


@define("03-write", Written("face_frame(p, q, r)", three_points))
@slip("uphill", lambda: lambda p, q, r: write_face()(p, q, r) * [-1, -1, 1])
@slip("rows", lambda: lambda p, q, r: write_face()(p, q, r).T)
@slip("downwards", lambda: lambda p, q, r: write_face()(p, q, r) * [1, -1, -1])
def write_face():
    """The normal is a cross product of two edges; x is what of "down" lies in the face; y completes the frame."""

    def face_frame(p, q, r):
        z = unit(np.cross(q - p, r - p))
        z = z if z[2] > 0 else -z  # out of the part, upwards
        down = np.array([0, 0, -1])
        x = unit(down - np.dot(down, z) * z)
        return np.column_stack([x, np.cross(z, x), z])

    return face_frame


@define(
    "03b-rho",
    Angle(decimals=1),
    drawn=lambda rng: {"i": rng.randrange(10, 80, 5), "j": rng.randrange(20, 60, 5), "k": rng.randrange(5, 60, 5)},
)
@slip("wrong sense", lambda k: -90 - k)
@slip("A and C", lambda k: k)
def rho(i=20, j=35, k=10):
    """With B above 0 the third angle of a B-C table is -90, and each degree of K beyond it is one of ρ: K + 90."""
    F = zxz(*np.radians([i, j, k]))
    b = np.arccos(F[2, 2])
    c = np.arctan2(F[1, 2], F[0, 2])
    S = Rz(c) @ Ry(b)  # the spindle on a B-C table
    left = S.T @ F
    return np.degrees(np.arctan2(left[1, 0], left[0, 0]))


@define("03b-third", Angle(decimals=2))
@slip("left over", lambda: -third())
@slip("A and C", tilt=Rx, angle=np.arccos)
@slip("B and C", tilt=Ry, angle=np.arccos)
def third(
    tilt=lambda b: Rx(np.radians(45)) @ Ry(-b) @ Rx(np.radians(-45)),  # the tool about -B, as the part sees it
    angle=lambda z: np.arccos(2 * z - 1),  # the third row of tilt(b): z = (1 + cos b) / 2
):
    """B tilts by what z says; then C turns the tool to the side to which z leans. What is left is rho."""
    F = zxz(*np.radians([60, 30, 0]))
    tilted = tilt(angle(F[2, 2]))  # B from 0 to 180: the position that is within travel
    c = np.arctan2(F[1, 2], F[0, 2]) - np.arctan2(tilted[1, 2], tilted[0, 2])
    left = (Rz(c) @ tilted).T @ F
    rho = np.degrees(np.arctan2(left[1, 0], left[0, 0]))
    return 0 - rho  # K was 0


def same_choice(present: Sequence[float]) -> str:
    """Say which position Fanuc and Heidenhain both take from here for SPB+45 on the A-C table."""
    if np.abs(wrap(np.subtract(present, (20, -60)))).max() < 1e-6:
        return "That is the case of the lesson. Find one of your own."
    tilted = align(Plane("PLANE SPATIAL", np.array([0, 45, 0])).frame, load("ac_table").machine)
    one, other = positioning.fanuc(tilted, present), positioning.heidenhain(tilted, present)
    if np.abs(wrap(np.subtract(one.angles, other.angles))).max() > 1e-6:
        return ""
    a, c = one.angles
    return f"Both go to A{a:+.0f} C{c:+.0f} from there (Fanuc: {one.why}; Heidenhain: {other.why})."


@define("03b-choice", Vector(names="A C", decimals=None, unit="degrees"), complaint=same_choice)
def choice():
    """Fanuc asks only how far A has to go; Heidenhain adds the way of C. So start nearer to A45, but at C-90."""
    to_first = np.hypot(45 - 20, 90 - -90)  # from A20 C-90 to A45 C90
    to_second = np.hypot(-45 - 20, -90 - -90)  # and to A-45 C-90
    assert abs(45 - 20) < abs(-45 - 20)  # Fanuc: the first
    assert to_second < to_first  # Heidenhain: the second
    return 20, -90


def random_direction(rng: np.random.Generator) -> list[np.ndarray]:
    """A unit vector that leans to any side of Z, by 10° to 80°."""
    lean, side = np.radians([rng.uniform(10, 80), rng.uniform(-180, 180)])
    return [np.array([np.sin(lean) * np.cos(side), np.sin(lean) * np.sin(side), np.cos(lean)])]


@define("03b-write", Written("angles(z)", random_direction))
@slip("second", lambda: lambda z: [-np.degrees(np.arccos(z[2])), np.degrees(np.arctan2(-z[0], z[1]))])
@slip("minus forgotten", lambda: lambda z: [np.degrees(np.arccos(z[2])), np.degrees(np.arctan2(z[0], z[1]))])
@slip("B and C", lambda: lambda z: [np.degrees(np.arccos(z[2])), np.degrees(np.arctan2(z[1], z[0]))])
@slip("radians", lambda: lambda z: [np.arccos(z[2]), np.arctan2(z[0], -z[1])])
def write_angles():
    """cos A = z₃ gives A; sin A is positive then, so z₁ and -z₂ are the sine and cosine of C times that factor."""

    def angles(z):
        a = np.arccos(z[2])
        c = np.arctan2(z[0], -z[1])
        return np.degrees([a, c])

    return angles


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
