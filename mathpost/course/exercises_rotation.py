"""The exercises of lessons 01 to 04: rotations, Euler angles, the tilted plane, the chain."""

from dataclasses import replace

import numpy as np
import sympy as sp

from mathpost import angles as euler
from mathpost import chain, machine
from mathpost.course.verdict import data, exercise
from mathpost.detective.euler_angles import explain
from mathpost.frame import Frame
from mathpost.kinematics import Kinematics
from mathpost.plane import positioning
from mathpost.plane.alignment import align
from mathpost.plane.tilted_plane import Plane
from mathpost.rotation import ACTIVE, wrap, zxz_right, zxz_steps

POINT = (3, 4, 5)
PRINTED = (135, 54.7356, -90)
ACTIVE_POINT = (-4.490731, 4.949747, 2.309402)  # what the colleague of 01-slip shows; lesson 01 computes it


def zxz(angles):
    """The frame of I J K, in degrees: what two answers are compared by."""
    return euler.matrix("ZXZ", angles, degrees=True)


def turned(angles, elementary):
    """The point of lesson 01 by the first recipe, with active or passive elementary matrices."""
    return zxz_steps("right", angles, POINT, elementary=elementary, degrees=True)[-1].value


def load(name):
    """A machine of the course by the name of its file."""
    return machine.load(data(f"machines/{name}.toml"))


# 01 Rotating a point


@exercise(
    "01-sign",
    wrong={
        "This turns the point (an active matrix). The frame turns: look from its new axes.": (
            lambda: turned((90, 0, 0), ACTIVE)
        ),
        "This is the point before the turn.": lambda: POINT,
    },
)
def sign():
    """The new X stands where Y was, so x' is the old y; the new Y points along -X, so y' is minus the old x."""
    return zxz_right(90, 0, 0, degrees=True) @ POINT


@exercise(
    "01-point",
    wrong={
        "These are active matrices: they turn the point. Coordinates in a turned frame take the passive ones.": (
            lambda: turned((30, 90, 0), ACTIVE)
        ),
        "The factors stand in the order of turning; the first turn must act first, at the right end.": (
            lambda: (
                zxz_steps("right", (30, 90, 0), np.eye(3), degrees=True)[0].value
                @ zxz_steps("right", (30, 90, 0), POINT, degrees=True)[1].value
                @ POINT
            )
        ),
        "The angles went in as degrees where the function expects radians; say degrees=True.": (
            lambda: zxz_right(30, 90, 0) @ POINT
        ),
    },
    detective=lambda answer: explain((30, 90, 0), POINT, np.round(np.asarray(answer, dtype=float), 6)),
)
def point():
    """X' = (cos 30°, sin 30°, 0), Y' = (0, 0, 1), Z' = (sin 30°, -cos 30°, 0): three dot products."""
    return zxz_right(30, 90, 0, degrees=True) @ POINT


@exercise(
    "01-slip",
    given=lambda: ACTIVE_POINT,
    wrong={
        "Both kinds make the recipes agree; the passive kind gives another number. Compare with the audit.": (
            lambda: "passive"
        )
    },
)
def slip():
    """So look at the first elementary matrix: the minus before the sine is in the wrong place, in all six."""
    return explain(PRINTED, POINT, ACTIVE_POINT).misreadings[0].kinds[0]


@exercise(
    "01-still",
    wrong={
        "That is so for a turn about X. The last turn is about the newest Z.": lambda: "x",
        "Which axis does the last turn leave in its place?": lambda: "y",
    },
)
def still():
    """The last turn is about the newest Z, and turning about an axis keeps the coordinate along it."""
    alpha, beta, gamma = sp.symbols("alpha beta gamma")
    coordinates = zxz_right(alpha, beta, gamma) * sp.Matrix(POINT)
    return next(name for name, value in zip("xyz", coordinates, strict=True) if sp.diff(value, gamma) == 0)


# 02 Euler angles and frames


@exercise(
    "02-frame",
    seen_as=zxz,
    wrong={
        "These are the angles of the transposed matrix: it takes coordinates into the frame, F takes them out.": (
            lambda: euler.angles("ZXZ", Frame.from_axes([0, 1, 0], [0, 0, -1]).rotation.T, degrees=True)
        ),
        "The plane's Z is right, its X is not: the third angle is still free.": (
            lambda: euler.from_direction("ZXZ", [0, 1, 0], degrees=True)
        ),
    },
)
def frame():
    """Z alone gives I and J; X, along the slope, gives K. The twin with -J would have been right too."""
    return euler.angles("ZXZ", Frame.from_axes([0, 1, 0], [0, 0, -1]).rotation, degrees=True)


@exercise(
    "02-twin",
    tolerance=5e-3,
    wrong={
        "That is the inverse turn. A twin is the same rotation under another name.": (
            lambda: -euler.to_axis_angle(zxz((20, 30, 40)), degrees=True)[1]
        ),
        "That is the turn the other way round; its axis would point the other way.": (
            lambda: 360 - euler.to_axis_angle(zxz((20, 30, 40)), degrees=True)[1]
        ),
        "The three angles are about different axes, so they do not add up.": lambda: 20 + 30 + 40,
    },
)
def twin():
    """The same as before: a twin is another name of the same rotation, and the axis with its angle has no names."""
    twin = euler.twin("ZXZ", (20, 30, 40), degrees=True)
    return euler.to_axis_angle(euler.matrix("ZXZ", twin, degrees=True), degrees=True)[1]


@exercise(
    "02-lock",
    wrong={
        "That is where ZXZ locks (G68.2), whose first and third axis are the same. Here they are X and Z.": (
            lambda: 0
        ),
        "Between them stands B: at which B does it lay X onto Z?": lambda: 45,
    },
)
def lock():
    """SPB = 90° lays the part's X onto the fixed Z, about which SPC turns: only SPA - SPC is left."""
    tried = range(181)
    return next(b for b in tried if euler.is_locked("xyz", euler.matrix("xyz", (20, b, 30), degrees=True)))


@exercise(
    "02-order",
    given=lambda: "F = Rz(c) @ Ry(b) @ Rx(a)",
    wrong={
        "About moving axes the later turns stand further *right*: Rx(a)·Ry(b)·Rz(c). Here they stand left.": (
            lambda: "moving"
        )
    },
)
def order():
    """About the fixed X, the fixed Y, the fixed Z. His words need Rx(a)·Ry(b)·Rz(c), in SciPy's spelling XYZ."""
    a, b, c = sp.symbols("a b c")
    program = ACTIVE["Z"](c) * ACTIVE["Y"](b) * ACTIVE["X"](a)
    spellings = {"moving": "XYZ", "fixed": "xyz"}
    return next(axes for axes, name in spellings.items() if euler.matrix(name, (a, b, c)) == program)


# 03 The tilted working plane


@exercise(
    "03-plane",
    seen_as=zxz,
    wrong={
        "I0 J30 K0 tilts about X. J is about the *new* X: I must first turn that X into the old Y.": lambda: (
            0,
            30,
            0,
        ),
        "Z is right, X is not: I has turned the plane about Z, and K must turn it back.": lambda: (90, 30, 0),
        "Z leans to the other side: the sign of I.": lambda: (-90, 30, 90),
    },
)
def plane():
    """I lays X along the old Y, J tilts about it, and K takes I's turn back again: I = 90, K = -90."""
    return Plane("PLANE SPATIAL", [0, 30, 0]).to("G68.2").values


@exercise(
    "03-third",
    tolerance=5e-3,
    wrong={
        "This is what is left (ρ). The third angle must take it away, so it has the other sign.": (
            lambda: align(Plane("G68.2", [60, 30, 0]).frame, load("dmu50v")).solutions[0].rho
        ),
        "0 is the third angle of an A-C table. This table tilts about an axis at 45°.": lambda: 0,
    },
)
def third():
    """Only one position is within the travel of B, and on a 45° table K is another for every plane."""
    solutions = align(Plane("G68.2", [60, 30, 0]).frame, load("dmu50v")).solutions
    return next(solution.third_angle() for solution in solutions if not solution.reason)


def judge_choice(present):
    """Whether Fanuc and Heidenhain take different positions from here for SPB+45 on the A-C table."""
    tilted = align(Plane("PLANE SPATIAL", [0, 45, 0]).frame, load("ac_table"))
    one, other = positioning.fanuc(tilted, present), positioning.heidenhain(tilted, present)
    if np.abs(wrap(np.subtract(one.angles, other.angles))).max() > 1e-6:
        return ""
    a, c = one.angles
    return f"Both go to A{a:+.0f} C{c:+.0f} from there (Fanuc: {one.why}; Heidenhain: {other.why})."


@exercise("03-choice", judge=judge_choice, wrong={"Both go to": lambda: (0, -105)})
def choice():
    """Fanuc asks only how far A has to go; Heidenhain adds the way of C."""
    tried = ((a, c) for a in (0, 20) for c in range(-90, 91, 30))
    return next(present for present in tried if not judge_choice(present))


# 04 The transform chain


@exercise(
    "04-links",
    wrong={
        "Not only the tool: X Y Z name the *tip* here, so for the same words the slides must stand higher.": (
            lambda: {"tool"}
        ),
        "The linear link too, but also the tool's own: the distance from nose to tip is in it.": lambda: {"linear"},
        "The workpiece link knows where the part sits, not how long the tool is.": lambda: {"workpiece", "tool"},
    },
)
def links():
    """The two changes cancel at the tip. On `ac_head`, where X Y Z name the pivot, the tool link alone changes."""
    model = load("ac_table")
    longer = model.with_setup(tool_length=model.tool_length + 20)
    pairs = zip(chain.links(model), chain.links(longer), strict=True)
    return {one.name for one, other in pairs if one.matrix != other.matrix}


@exercise(
    "04-lean",
    tolerance=5e-3,
    wrong={
        "Leaning outwards makes the ring of the pivot wider. It must lean inwards.": lambda: -lean(),
        "The pivot is L along the *tool*: it is the sine of the lean that carries it sideways, not the tangent.": (
            lambda: -np.degrees(np.arctan2(40, pivot_to_tip()))
        ),
        "The pivot lies not at the spindle nose but further up: add both lengths of the file.": (
            lambda: -np.degrees(np.arcsin(40 / load("ac_head").tool_length))
        ),
    },
)
def lean():
    """The pivot stands over the middle: radius + L·sin(lean) = 0."""
    model = load("ac_head")
    pivot_to_tip = model.tool_length + model.programmed_point[2]
    return -np.degrees(np.arcsin(40 / pivot_to_tip))


def pivot_to_tip():
    model = load("ac_head")
    return model.tool_length + model.programmed_point[2]


def tilted_y(model, *, mirrored=False):
    """The y of the tool axis in the workpiece at A30 C0, perhaps with the sign of A reversed."""
    if mirrored:
        first = replace(model.rotary[0], axis=tuple(-each for each in model.rotary[0].axis))
        model = replace(model, rotary=(first, model.rotary[1]))
    return Kinematics(model).forward([0, 0, 0, 30, 0], degrees=True)[1][1]


@exercise(
    "04-sign",
    wrong={
        "Right size, wrong sign: this table turns as a head does. By ISO 841 the *tool* turns right-handed "
        "about X, seen from the part.": lambda: tilted_y(load("ac_table"), mirrored=True),
        "That is the component along Z, the cosine.": lambda: np.cos(np.radians(30)),
    },
)
def table_sign():
    """Right-handed about X the tool axis goes from Z towards -Y: the same on a table and on a head."""
    return Kinematics(load("ac_table")).forward([0, 0, 0, 30, 0], degrees=True)[1][1]
