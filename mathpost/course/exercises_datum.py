"""The exercises of lessons 08 and 09: the datum after rotation, the five-face head."""

from functools import cache

import numpy as np

from mathpost.course.answers import Angle, Name, Names, Number, Vector
from mathpost.course.lesson_data import data, load, of_lesson
from mathpost.course.verdict import slip
from mathpost.measure import horizontal_head, work_offset
from mathpost.measure.horizontal_head import VERTICAL

CENTRES = {"centre_a": (0, -200, -850), "centre_b": (-350, 0, -900)}
G54 = (-300, -250, -600)
SET_UP, NEW = {"A": 15, "B": -50}, {"A": -20, "B": 30}
QUARTERS = {"B": 90, "C": 90}
CALL = "G65P9795X0Y0Z0A0B0D-30.E10.S55"
NORMALS = {"+X": (1, 0, 0), "-X": (-1, 0, 0), "+Z": (0, 0, 1), "-Z": (0, 0, -1)}
ADDRESSES = Names(
    {"A": ["A-30", "A-30."], "B": ["B10", "B10."], "X": [], "Y": [], "Z": [], "D": [], "E": [], "S": []},
    about={
        **dict.fromkeys("XYZ", "The macro has stored it in G55."),
        **dict.fromkeys("DES", "It told the macro where to go. What moves the axes?"),
    }.get,
)

# 08 The datum after rotation


@of_lesson("08-face", Name({"+X": ["X"], "-X": [], "+Z": ["Z"], "-Z": []}))
def face(b=90):
    """The table carries +X to +Z, where the spindle is."""
    _, rotary = work_offset.ab_table(**CENTRES, order="AB")
    turned = {
        name: np.subtract(*work_offset.moved([normal, (0, 0, 0)], (rotary,), {"B": 0}, {"B": b}, degrees=True))
        for name, normal in NORMALS.items()
    }
    return next(name for name, normal in turned.items() if normal[2] > 0.5)


@of_lesson("08-datum", Vector(unit="mm"))
@slip("backwards", start=NEW, end=SET_UP)
def after_turn(start=SET_UP, end=NEW, order="AB", iso=True):
    """Back to zero with the old angles, forward with the new, each axis about its own line."""
    table = work_offset.ab_table(**CENTRES, order=order, iso=iso)
    return work_offset.moved(G54, table, start, end, degrees=True)


@of_lesson("08-words", ADDRESSES, given=lambda: CALL)
def missing_words():
    """G10 L2 stores X Y Z only; without A-30. B10. the table stands where it stood, and G55 names another place."""
    old = work_offset.WorkOffset("G54", *G54, A=0, B=0)
    table = work_offset.ab_table(**CENTRES, order="AB")
    return set(work_offset.p9795(table, old, **work_offset.read_call(CALL)).angles)


@of_lesson("08-dmu", Vector(unit="mm"))
def dmu(end=QUARTERS, order=1):
    """The same function: a table is two axes with their own lines, a tilted one too."""
    b_carries_c = load("dmu50v").machine.rotary[::order]
    return work_offset.moved((10, 20, 30), b_carries_c, {"B": 0, "C": 0}, end, degrees=True)


# 09 The five-face head


@cache
def head():
    """The measured head of source 001."""
    return horizontal_head.read_head(data("measurements/five_face_head.csv"))


@of_lesson("09-vertical", Vector(unit="mm"))
@slip("head vector", lambda: head().vector(0))
def vertical(measured=VERTICAL):
    """Nothing to take back: the offset already belongs to the vertical head."""
    return horizontal_head.lhyset(head(), measured, measured, measured)


@of_lesson("09-missed", Vector(unit="mm"))
@slip("flipped", lambda: horizontal_head.opposite_errors(head())[270])
@slip("predicted less measured", lambda: -missed())
def missed(fitted=3):
    """Twice the residuals of the full fit: a point that was not fitted is missed by more than one that was."""
    chosen = horizontal_head.Head(head().angles[:fitted], head().vectors[:fitted])
    return head().vector(270) - horizontal_head.fit_head(chosen).head().vector(270)


@of_lesson("09-wrapped", Angle(decimals=1))
@slip("counterclockwise", lambda: next(a for a in np.arange(0, 360, 2.5) if 90 + a > 180))
def wrapped():
    """From here on UZZ would be below -180, and comes back from the other side, just below +180."""
    positions = np.arange(0, 360, 2.5)
    return next(angle for angle in positions if 90 + head().sense * angle < -180)


@of_lesson("09-unlisted", Number(decimals=0, unit="mm"))
@slip(
    "arms",
    lambda: np.linalg.norm(horizontal_head.fit_head(head()).head().vector(205)) - np.linalg.norm(head().vector(0)),
)
def unlisted(angle=205):
    """It falls through to the first label and uses U_0, almost two arm lengths away."""
    wanted = horizontal_head.fit_head(head()).head().vector(angle)
    return np.linalg.norm(wanted - head().vector(0))
