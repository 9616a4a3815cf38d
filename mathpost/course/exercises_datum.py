"""The exercises of lessons 08 and 09: the datum after rotation, the five-face head."""

from dataclasses import replace
from functools import cache

import numpy as np

from mathpost import machine
from mathpost.course.verdict import data, exercise
from mathpost.measure import horizontal_head, work_offset
from mathpost.measure.horizontal_head import VERTICAL

CENTRES = {"centre_a": (0, -200, -850), "centre_b": (-350, 0, -900)}
G54 = (-300, -250, -600)
SET_UP, NEW = {"A": 20, "B": -40}, {"A": -30, "B": 10}
CALL = "G65P9795X0Y0Z0A0B0D-30.E10.S55"


def moved_datum(start=SET_UP, end=NEW, *, order="AB", iso=True):
    """The datum of lesson 08 after a turn of its table."""
    return work_offset.moved(G54, work_offset.ab_table(**CENTRES, order=order, iso=iso), start, end, degrees=True)


# 08 The datum after rotation


@exercise(
    "08-face",
    wrong={
        "That is a table that turns as a head does. By ISO 841 B+ turns the *tool* right-handed about Y, "
        "so the table goes the other way.": lambda: "-X",
        "The table turns by a quarter, so the face cannot still look along Z.": lambda: "+Z",
    },
)
def face():
    """The table carries +X to +Z, where the spindle is."""
    _, b = work_offset.ab_table(**CENTRES, order="AB")
    normals = {"+X": (1, 0, 0), "-X": (-1, 0, 0), "+Z": (0, 0, 1), "-Z": (0, 0, -1)}
    turned = {
        name: np.subtract(*work_offset.moved([normal, (0, 0, 0)], (b,), {"B": 0}, {"B": 90}, degrees=True))
        for name, normal in normals.items()
    }
    return next(name for name, normal in turned.items() if normal[2] > 0.5)


@exercise(
    "08-datum",
    tolerance=2e-3,
    wrong={
        "This is from A0 B0. The part was set up at A20 B-40: carry its datum back to zero first.": (
            lambda: moved_datum({"A": 0, "B": 0})
        ),
        "The differences of the angles are not enough: B is carried back at A20 and forward at A-30.": (
            lambda: moved_datum({"A": 0, "B": 0}, {"A": -50, "B": 50})
        ),
        "This is the stack order BA; here A stands on the bed and carries B.": lambda: moved_datum(order="BA"),
        "Both axes turn the other way round: right size of the angles, wrong sign. Table or head?": (
            lambda: moved_datum(iso=False)
        ),
        "The turn is run backwards: `start` is where the part was set up.": lambda: moved_datum(NEW, SET_UP),
    },
)
def after_turn():
    """Back to zero with the old angles, forward with the new, each axis about its own line."""
    table = work_offset.ab_table(**CENTRES, order="AB")
    return work_offset.moved(G54, table, {"A": 20, "B": -40}, {"A": -30, "B": 10}, degrees=True)


@exercise(
    "08-words",
    given=lambda: CALL,
    wrong={
        "These the macro has stored in G55. What has it not stored?": lambda: {"X", "Y", "Z"},
        "Not D and E: they told the macro where to go. What moves the axes?": lambda: {"D", "E"},
    },
)
def missing_words():
    """G10 L2 stores X Y Z only; without A-30. B10. the table stands where it stood, and G55 names another place."""
    old = work_offset.WorkOffset("G54", *G54, A=0, B=0)
    table = work_offset.ab_table(**CENTRES, order="AB")
    return set(work_offset.p9795(table, old, **work_offset.read_call(CALL)).angles)


def dmu_point(table):
    return work_offset.moved((10, 20, 30), table, {"B": 0, "C": 0}, {"B": 90, "C": 90}, degrees=True)


@exercise(
    "08-dmu",
    wrong={
        "C first, then B? B stands on the bed and carries C.": (
            lambda: dmu_point(machine.load(data("machines/dmu50v.toml")).rotary[::-1])
        ),
        "This table turns the other way from ISO 841; its file says so.": lambda: dmu_point(
            [
                replace(rotary, axis=tuple(-each for each in rotary.axis))
                for rotary in machine.load(data("machines/dmu50v.toml")).rotary
            ]
        ),
        "Only C has turned.": lambda: work_offset.moved(
            (10, 20, 30),
            machine.load(data("machines/dmu50v.toml")).rotary,
            {"B": 0, "C": 0},
            {"B": 0, "C": 90},
            degrees=True,
        ),
    },
)
def dmu():
    """The same function: a table is two axes with their own lines, a tilted one too."""
    b_carries_c = machine.load(data("machines/dmu50v.toml")).rotary
    return work_offset.moved((10, 20, 30), b_carries_c, {"B": 0, "C": 0}, {"B": 90, "C": 90}, degrees=True)


# 09 The five-face head


@cache
def head():
    """The measured head of source 001."""
    return horizontal_head.read_head(data("measurements/five_face_head.csv"))


@exercise(
    "09-vertical",
    wrong={
        "That is for offsets measured with the horizontal head at 0°. Here no head vector is in them.": (
            lambda: horizontal_head.lhyset(head(), 0, 0, 0)
        ),
        "That is a head vector. LHYSET takes a measured offset back to the vertical head: how far is that here?": (
            lambda: head().vector(0)
        ),
    },
)
def vertical():
    """Nothing to take back: the offset already belongs to the vertical head."""
    return horizontal_head.lhyset(head(), VERTICAL, VERTICAL, VERTICAL)


@exercise(
    "09-missed",
    tolerance=2e-3,
    wrong={
        "This is the manufacturer's rule, the signs of the 90° vector flipped. Fit the three others instead.": (
            lambda: horizontal_head.opposite_errors(head())[270]
        ),
        "Predicted minus measured; the question asks for measured minus predicted.": lambda: -missed(),
    },
)
def missed():
    """Twice the residuals of the full fit: a point that was not fitted is missed by more than one that was."""
    three = horizontal_head.Head(head().angles[:3], head().vectors[:3])
    return head().vector(270) - horizontal_head.fit_head(three).head().vector(270)


@exercise(
    "09-wrapped",
    tolerance=0.1,
    wrong={
        "270° gives exactly -180, which a control accepts; the test is `<`.": lambda: 270,
        "The head turns clockwise: UZZ is 90 - φ, not 90 + φ.": (
            lambda: next(a for a in np.arange(0, 360, 2.5) if 90 + a > 180)
        ),
    },
)
def wrapped():
    """From here on UZZ would be below -180, and comes back from the other side, just below +180."""
    positions = np.arange(0, 360, 2.5)
    return next(angle for angle in positions if 90 + head().sense * angle < -180)


def unlisted_vector(angle):
    return horizontal_head.fit_head(head()).head().vector(angle)


@exercise(
    "09-unlisted",
    tolerance=0.5,
    wrong={
        "That is at 45°, from the lesson.": (lambda: np.linalg.norm(unlisted_vector(45) - head().vector(0))),
        "These are the arms only; the head vectors differ in direction.": (
            lambda: np.linalg.norm(unlisted_vector(135)) - np.linalg.norm(head().vector(0))
        ),
    },
)
def unlisted():
    """It falls through to the first label and uses U_0, almost two arm lengths away."""
    wanted = horizontal_head.fit_head(head()).head().vector(135)
    return np.linalg.norm(wanted - head().vector(0))
