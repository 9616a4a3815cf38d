"""The exercises of lessons 08 and 09: the datum after rotation, the five-face head."""

from functools import cache

import numpy as np

from mathpost.course.answers import Angle, Name, Names, Number, Vector
from mathpost.course.lesson_data import data, load
from mathpost.course.verdict import define, slip
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


@define("08-face", Name({"+X": ["X"], "-X": [], "+Z": ["Z"], "-Z": []}))
@slip(
    "That is a table that turns as a head does. By ISO 841 B+ turns the *tool* right-handed about Y, "
    "so the table goes the other way.",
    b=-90,
)
@slip("The table turns by a quarter, so the face cannot still look along Z.", "+Z")
@slip("The table turns by a quarter, so the face at the back does not come to the front.", "-Z")
def face(b=90):
    """The table carries +X to +Z, where the spindle is."""
    _, rotary = work_offset.ab_table(**CENTRES, order="AB")
    turned = {
        name: np.subtract(*work_offset.moved([normal, (0, 0, 0)], (rotary,), {"B": 0}, {"B": b}, degrees=True))
        for name, normal in NORMALS.items()
    }
    return next(name for name, normal in turned.items() if normal[2] > 0.5)


@define("08-datum", Vector(unit="mm"), "Carry the datum back to A0 B0 first, then forward.")
@slip(
    "This is from A0 B0. The part was set up at A15 B-50: carry its datum back to zero first.",
    start={"A": 0, "B": 0},
)
@slip(
    "The differences of the angles are not enough: B is carried back at A15 and forward at A-20.",
    start={"A": 0, "B": 0},
    end={"A": -35, "B": 80},
)
@slip("This is the stack order BA; here A stands on the bed and carries B.", order="BA")
@slip("Both axes turn the other way round: right size of the angles, wrong sign. Table or head?", iso=False)
@slip("The turn is run backwards: `start` is where the part was set up.", start=NEW, end=SET_UP)
def after_turn(start=SET_UP, end=NEW, order="AB", iso=True):
    """Back to zero with the old angles, forward with the new, each axis about its own line."""
    table = work_offset.ab_table(**CENTRES, order=order, iso=iso)
    return work_offset.moved(G54, table, start, end, degrees=True)


@define("08-words", ADDRESSES, "Which axes must move before the datum in G55 is true?", given=lambda: CALL)
@slip("These the macro has stored in G55. What has it not stored?", "X Y Z")
@slip("Not D and E: they told the macro where to go. What moves the axes?", "D E")
def missing_words():
    """G10 L2 stores X Y Z only; without A-30. B10. the table stands where it stood, and G55 names another place."""
    old = work_offset.WorkOffset("G54", *G54, A=0, B=0)
    table = work_offset.ab_table(**CENTRES, order="AB")
    return set(work_offset.p9795(table, old, **work_offset.read_call(CALL)).angles)


@define("08-dmu", Vector(unit="mm"), "Which axis stands on the bed, and which way does the file let it turn?")
@slip("C first, then B? B stands on the bed and carries C.", order=-1)
@slip("This table turns the other way from ISO 841; its file says so.", end={"B": -90, "C": -90})
@slip("Only C has turned.", end={"B": 0, "C": 90})
@slip("Only B has turned.", end={"B": 90, "C": 0})
def dmu(end=QUARTERS, order=1):
    """The same function: a table is two axes with their own lines, a tilted one too."""
    b_carries_c = load("dmu50v").machine.rotary[::order]
    return work_offset.moved((10, 20, 30), b_carries_c, {"B": 0, "C": 0}, end, degrees=True)


# 09 The five-face head


@cache
def head():
    """The measured head of source 001."""
    return horizontal_head.read_head(data("measurements/five_face_head.csv"))


@define("09-vertical", Vector(unit="mm"), "Which head vector is in an offset that the vertical head measured?")
@slip("That is for offsets measured with the horizontal head at 0°. Here no head vector is in them.", measured=0)
@slip(
    "That is a head vector. LHYSET takes a measured offset back to the vertical head: how far is that here?",
    lambda: head().vector(0),
)
def vertical(measured=VERTICAL):
    """Nothing to take back: the offset already belongs to the vertical head."""
    return horizontal_head.lhyset(head(), measured, measured, measured)


@define("09-missed", Vector(unit="mm"), "Fit the other three; then measured minus predicted.")
@slip(
    "This is the manufacturer's rule, the signs of the 90° vector flipped. Fit the three others instead.",
    lambda: horizontal_head.opposite_errors(head())[270],
)
@slip("Predicted minus measured; the question asks for measured minus predicted.", lambda: -missed())
@slip("That is what is left in a fit of all four. Leave the 270° position out.", fitted=4)
def missed(fitted=3):
    """Twice the residuals of the full fit: a point that was not fitted is missed by more than one that was."""
    chosen = horizontal_head.Head(head().angles[:fitted], head().vectors[:fitted])
    return head().vector(270) - horizontal_head.fit_head(chosen).head().vector(270)


@define("09-wrapped", Angle(decimals=1), "Write UZZ as a function of the position.")
@slip("270° gives exactly -180, which a control accepts; the test is `<`.", 270)
@slip(
    "The head turns clockwise: UZZ is 90 - φ, not 90 + φ.",
    lambda: next(a for a in np.arange(0, 360, 2.5) if 90 + a > 180),
)
def wrapped():
    """From here on UZZ would be below -180, and comes back from the other side, just below +180."""
    positions = np.arange(0, 360, 2.5)
    return next(angle for angle in positions if 90 + head().sense * angle < -180)


@define(
    "09-unlisted",
    Number(decimals=0, unit="mm"),
    "Which label does the program reach, and which vector does it load there?",
)
@slip("That is at 45°, from the lesson.", angle=45)
@slip(
    "These are the arms only; the head vectors differ in direction.",
    lambda: np.linalg.norm(horizontal_head.fit_head(head()).head().vector(205)) - np.linalg.norm(head().vector(0)),
)
def unlisted(angle=205):
    """It falls through to the first label and uses U_0, almost two arm lengths away."""
    wanted = horizontal_head.fit_head(head()).head().vector(angle)
    return np.linalg.norm(wanted - head().vector(0))
