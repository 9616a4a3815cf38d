"""The exercises of lessons 03 and 03b: the tilted plane, and the machine that turns to it."""

from collections.abc import Sequence
from itertools import permutations

import numpy as np

from mathpost import euler
from mathpost.rotation import wrap
from mathpost.shop.plane import positioning
from mathpost.shop.plane.positioning import align
from mathpost.shop.plane.tilted_plane import Plane
from mathpost.teaching.course.answers import Angle, Name, Pose, Vector, Written
from mathpost.teaching.course.exercises.rotation import Rx, Ry, Rz, ijk, unit, zxz
from mathpost.teaching.course.lesson_data import load
from mathpost.teaching.course.verdict import define, slip

ORDERS = Name({"".join(order): [] for order in permutations("XYZ")})


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


@define("03-spatial", Written("spatial(F)", lambda rng: [zxz(*rng.uniform(-3, 3, 3))]))
@slip("moving", lambda: lambda F: euler.angles("XYZ", F, degrees=True))
@slip("transposed", lambda: lambda F: euler.angles("xyz", F.T, degrees=True))
@slip("C first", lambda: lambda F: euler.angles("xyz", F, degrees=True)[::-1])
@slip("radians", lambda: lambda F: euler.angles("xyz", F))
@slip("quotients", lambda: lambda F: np.degrees(np.arctan([F[2, 1] / F[2, 2], np.tan(beta(F)), F[1, 0] / F[0, 0]])))
@slip("minus forgotten", lambda: lambda F: euler.angles("xyz", F, degrees=True) * [1, -1, 1])
def write_spatial():
    """The last row has cos B times the sine and cosine of A, the first column cos B times those of C."""

    def spatial(F):
        a = np.arctan2(F[2, 1], F[2, 2])
        b = np.arctan2(-F[2, 0], np.hypot(F[0, 0], F[1, 0]))  # the root is cos B, which is not negative
        c = np.arctan2(F[1, 0], F[0, 0])
        return np.degrees([a, b, c])

    return spatial


def beta(F: np.ndarray) -> float:
    """SPB of a frame, radians."""
    return float(np.arcsin(-F[2, 0]))


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


def sign_of(p: np.ndarray, q: np.ndarray, r: np.ndarray) -> float:
    """Whether the cross product of the edges points up, 1, or down, -1."""
    return float(np.sign(np.cross(q - p, r - p)[2]))


@define("03-write", Written("face_frame(p, q, r)", three_points))
@slip("uphill", lambda: lambda p, q, r: write_face()(p, q, r) * [-1, -1, 1])
@slip("rows", lambda: lambda p, q, r: write_face()(p, q, r).T)
@slip("downwards", lambda: lambda p, q, r: write_face()(p, q, r) * [1, -1, -1])
@slip("not turned", lambda: lambda p, q, r: write_face()(p, q, r) * (1, sign_of(p, q, r), sign_of(p, q, r)))
@slip("not a unit", lambda: lambda p, q, r: write_face()(p, q, r) * [write_face()(p, q, r)[2, 0] * -1, 1, 1])
@slip("left-handed", lambda: lambda p, q, r: write_face()(p, q, r) * [1, -1, 1])
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
@slip("other position", lambda k: k - 90)
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
@slip("other position", lambda: third() - 180)
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
    """Return why a `present` position is no answer, "" if it is: there both controls go the same way for SPB+45."""
    rotary = load("ac_table").machine.rotary
    for joint, angle in zip(rotary, present, strict=True):
        low, high = np.degrees(joint.limits)
        if not low <= angle <= high:
            return f"{joint.name} cannot stand at {angle:g}: its travel is {low:g} to {high:g}."
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
@slip("quotient", lambda: lambda z: np.degrees([np.arccos(z[2]), np.arctan(z[0] / -z[1])]))
@slip("exchanged", lambda: lambda z: np.degrees([np.arccos(z[2]), np.arctan2(-z[1], z[0])]))
@slip("whole turn", lambda: lambda z: write_angles()(z) % 360)
@slip("C first", lambda: lambda z: write_angles()(z)[::-1])
def write_angles():
    """cos A = z₃ gives A; sin A is positive then, so z₁ and -z₂ are the sine and cosine of C times that factor."""

    def angles(z):
        a = np.arccos(z[2])
        c = np.arctan2(z[0], -z[1])
        return np.degrees([a, c])

    return angles
