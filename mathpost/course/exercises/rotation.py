"""The exercises of lessons 01 to 04: rotations, Euler angles, the tilted plane, the chain."""

from itertools import permutations

import numpy as np
import sympy as sp

from mathpost import chain, euler
from mathpost.course.answers import Angle, Name, Names, Number, Pose, Vector
from mathpost.course.lesson_data import load
from mathpost.course.verdict import define, slip
from mathpost.detective.euler_angles import explain
from mathpost.frame import Frame
from mathpost.plane import blocks, positioning
from mathpost.plane.positioning import align
from mathpost.plane.tilted_plane import Plane
from mathpost.rotation import ACTIVE, wrap
from mathpost.sources.recipes import zxz_right, zxz_steps

POINT = (3, 4, 5)
SLIP = ((20, 70, 50), (3.278276, -0.856658, 6.206371))  # angles, and the point that the colleague of 01-slip shows
ORDERS = Name({"".join(order): [] for order in permutations("XYZ")})


def drawn_point(rng):
    """Three different coordinates that are easy to turn in the head."""
    return {"point": tuple(rng.sample(range(2, 10), 3))}


@define("01-sign", Vector(), drawn=drawn_point)
def sign(angle=90, point=POINT):
    """The new X stands where Y was, so x' is the old y; the new Y points along -X, so y' is minus the old x."""
    return zxz_right(angle, 0, 0, degrees=True) @ point


@define(
    "01-point",
    Vector(),
    detective=lambda answer, point: explain((30, 90, 0), point, np.round(answer, 6)),
    drawn=drawn_point,
)
@slip("active", lambda angles, point: zxz_steps("right", angles, point, elementary=ACTIVE, degrees=True)[-1].value)
def by_hand(angles=(30, 90, 0), point=POINT, degrees=True):
    """X' = (cos 30°, sin 30°, 0), Y' = (0, 0, 1), Z' = (sin 30°, -cos 30°, 0): three dot products."""
    return zxz_right(*angles, degrees=degrees) @ point


@define("01-slip", Name, given=lambda: SLIP)
def kind_of_matrix():
    """So look at the first elementary matrix: the minus before the sine is in the wrong place, in all six."""
    angles, shown = SLIP
    return explain(angles, POINT, shown).misreadings[0].kinds[0]


@define("01-still", Name)
def still():
    """The last turn is about the newest Z, and turning about an axis keeps the coordinate along it."""
    alpha, beta, gamma = sp.symbols("alpha beta gamma")
    coordinates = zxz_right(alpha, beta, gamma) * sp.Matrix(POINT)
    return next(name for name, value in zip("xyz", coordinates, strict=True) if sp.diff(value, gamma) == 0)


@define("02-frame", Pose())
@slip("transposed", lambda: euler.angles("ZXZ", Frame.from_axes([0, 1, 0], [0, 0, -1]).rotation.T, degrees=True))
@slip("any X", lambda: euler.from_direction("ZXZ", [0, 1, 0], degrees=True))
def frame(z=(0, 1, 0), x=(0, 0, -1), sequence="ZXZ"):
    """Z alone gives I and J; X, along the slope, gives K. The twin with -J would have been right too."""
    return euler.angles(sequence, Frame.from_axes(z, x).rotation, degrees=True)


@define("02-twin", Angle(decimals=2), drawn=lambda rng: {"angles": tuple(rng.sample(range(15, 60, 5), 3))})
@slip("other way", lambda angles: -twin(angles))
@slip("sum", lambda angles: sum(angles))
def twin(angles=(20, 30, 40)):
    """The same as before: a twin is another name of the same rotation, and the axis with its angle has no names."""
    twin = euler.twin("ZXZ", angles, degrees=True)
    return euler.to_axis_angle(euler.matrix("ZXZ", twin, degrees=True), degrees=True)[1]


@define("02-lock", Angle(decimals=0))
def lock(sequence="xyz"):
    """SPB = 90° lays the part's X onto the fixed Z, about which SPC turns: only SPA - SPC is left."""
    tried = ((b, euler.matrix(sequence, (20, b, 30), degrees=True)) for b in range(181))
    return next(b for b, matrix in tried if euler.is_locked(sequence, matrix))


@define("02-order", Name, given=lambda: "F = Rz(c) @ Ry(b) @ Rx(a)")
def order():
    """About the fixed X, the fixed Y, the fixed Z. The comment needs Rx(a)·Ry(b)·Rz(c), in SciPy's spelling XYZ."""
    a, b, c = sp.symbols("a b c")
    program = ACTIVE["Z"](c) * ACTIVE["Y"](b) * ACTIVE["X"](a)
    spellings = {"moving": "XYZ", "fixed": "xyz"}
    return next(axes for axes, name in spellings.items() if euler.matrix(name, (a, b, c)) == program)


@define("03-plane", Pose())
def plane():
    """I lays X along the old Y, J tilts about it, and K takes I's turn back again: I = 90, K = -90."""
    return Plane("PLANE SPATIAL", [0, 30, 0]).to("G68.2").values


@define("03-face", Pose())
@slip("leaning", lambda: face_angles() - [90, 0, 0])
def face_angles(x=(1, 2, 0), inverted=False):
    """Z × z is horizontal and lies in the face: it is (1, 2, 0). The frame on it has K = 0."""
    frame = Frame.from_axes([2, -1, 2], x)
    return Plane.from_frame(frame.inverse() if inverted else frame, "G68.2").values


@define("03-mode", ORDERS)
@slip("from the left", lambda: mode_39()[::-1])
def mode_39():
    """39 is 10 01 11 in bits. From the right: 3 is Z, 1 is X, 2 is Y."""
    return blocks.MODES[39].split()[1]


@define(
    "03b-rho",
    Angle(decimals=1),
    drawn=lambda rng: {"i": rng.randrange(10, 80, 5), "j": rng.randrange(20, 60, 5), "k": rng.randrange(5, 60, 5)},
)
@slip("wrong sense", lambda k: -90 - k)
def rho(i=20, j=35, k=10, name="bc_table"):
    """The third angle of a B-C table is -90, and each degree of K beyond it is one degree of ρ: K + 90."""
    return align(Plane("G68.2", [i, j, k]).frame, load(name).machine).solutions[0].rho


@define("03b-third", Angle(decimals=2))
@slip("left over", lambda: align(Plane("G68.2", [60, 30, 0]).frame, load("dmu50v").machine).solutions[0].rho)
def third(name="dmu50v"):
    """Only one position is within the travel of B, and on a 45° table every plane needs a K of its own."""
    solutions = align(Plane("G68.2", [60, 30, 0]).frame, load(name).machine).solutions
    return next(solution.third_angle() for solution in solutions if not solution.reason)


def same_choice(present):
    """Say which position Fanuc and Heidenhain both take from here for SPB+45 on the A-C table."""
    if np.allclose(present, (20, -60)):
        return "That is the case of the lesson. Find one of your own."
    tilted = align(Plane("PLANE SPATIAL", [0, 45, 0]).frame, load("ac_table").machine)
    one, other = positioning.fanuc(tilted, present), positioning.heidenhain(tilted, present)
    if np.abs(wrap(np.subtract(one.angles, other.angles))).max() > 1e-6:
        return ""
    a, c = one.angles
    return f"Both go to A{a:+.0f} C{c:+.0f} from there (Fanuc: {one.why}; Heidenhain: {other.why})."


@define("03b-choice", Vector(names="A C", decimals=None, unit="degrees"), complaint=same_choice)
def choice():
    """Fanuc asks only how far A has to go; Heidenhain adds the way of C."""
    tried = ((a, c) for a in (0, 20) for c in range(-90, 91, 30))
    return next(present for present in tried if not same_choice(present))


@define("04-links", Names)
def links():
    """The two changes cancel at the tip. On `ac_head`, where X Y Z name the pivot, the tool link alone changes."""
    model = load("ac_table").machine
    longer = model.with_setup(tool_length=model.tool_length + 20)
    pairs = zip(chain.links(model), chain.links(longer), strict=True)
    return {one.name for one, other in pairs if one.matrix != other.matrix}


@define(
    "04-same", Angle(decimals=1), drawn=lambda rng: {"a": rng.randrange(20, 65, 5), "c": rng.randrange(10, 80, 5)}
)
@slip("same C", lambda c: c)
@slip("wrong way", lambda c: c + 90)
def same_axis(a=35, c=20):
    """sin B cos C' = sin A sin C and sin B sin C' = -sin A cos C: with B = A it is C' = C - 90."""
    _tip, axis = load("ac_table").forward([0, 0, 0, a, c], degrees=True)
    return load("head_b_table_c").inverse([0, 0, 0], axis, degrees=True)[0, 3]


@define("04-lean", Angle(decimals=2), drawn=lambda rng: {"radius": rng.randrange(20, 80, 5)})
@slip("outwards", lambda radius: -lean(radius))
@slip("tangent", inverse=np.arctan)
@slip("to the nose", lambda radius: -np.degrees(np.arcsin(radius / load("ac_head").machine.programmed_point[2])))
@slip("from the nose", lambda radius: -np.degrees(np.arcsin(radius / load("ac_head").machine.tool_length)))
def lean(radius=40, inverse=np.arcsin):
    """The pivot stands over the middle: radius + L·sin(lean) = 0."""
    model = load("ac_head").machine
    pivot_to_tip = model.tool_length + model.programmed_point[2]
    return -np.degrees(inverse(radius / pivot_to_tip))


@define("04-sign", Number(), drawn=lambda rng: {"a": rng.choice([20, 25, 35, 40, 50, 55])})
@slip("as a head", lambda a: table_sign(-a))
def table_sign(a=30, component=1):
    """Right-handed about X the tool axis goes from Z towards -Y: the same on a table and on a head."""
    _tip, axis = load("ac_table").forward([0, 0, 0, a, 0], degrees=True)
    return axis[component]
