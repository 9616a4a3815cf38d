"""The words of CL files, each in the forms that systems write; hazards are refused or right."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mathpost import load_machine
from mathpost import postprocess as run_with_own_words
from mathpost.errors import InputError, ReachError
from mathpost.path import cl as cldata
from mathpost.path.arcs import arc
from tests.conftest import DATA
from tests.independent import judge, reader
from tests.independent.machine_model import Model

TABLE, HEAD = (load_machine(DATA / f"machines/{name}.toml") for name in ("ac_table", "ac_head"))
UP = (0, 0, 1)
START = "UNITS/MM\nSPINDL/1000,RPM,CLW\nFEDRAT/100,MMPM\n"


def read(text, **options):
    return cldata.parse(START + text, "part.cl", **options)


def refused(text):
    with pytest.raises(InputError) as caught:
        read(text)
    return str(caught.value)


@pytest.mark.parametrize(
    ("text", "points", "axes"),
    [
        ("GOTO/1,2,3", [(1, 2, 3)], [UP]),
        ("goto  /  1. , -2,3e0,0,0.6,.8", [(1, -2, 3)], [(0, 0.6, 0.8)]),
        ("GOTO/1,2,3,0,0.6,0.8\nGOTO/4,5,6", [(1, 2, 3), (4, 5, 6)], [(0, 0.6, 0.8)] * 2),
        ("TLAXIS/0.5,0,0.8660254\nGOTO/1,2,3", [(1, 2, 3)], [(0.5, 0, 0.8660254)]),
        ("GOTO / 1.0 , 2.0 , 3.0 $\n.0 , .6 , .8", [(1, 2, 3)], [(0, 0.6, 0.8)]),
        ("GOTO / 1.0 , $\n-2.0 $\n , 3.0", [(1, -2, 3)], [UP]),
        (
            "TLAXIS / 0.5, 0, $\n 0.8660254\nGOTO/1,2,3\nTLAXIS/0,0,1\nGOTO/1,2,3",
            [(1, 2, 3)] * 2,
            [(0.5, 0, 0.8660254), UP],
        ),
        (
            "GOTO/1,2,3\nMODE/INCR\nGOTO/10,0,0\nGOTO/20,0,0\nMODE/ABSOL\nGOTO/5,0,0",
            [(1, 2, 3), (10, 0, 0), (20, 0, 0), (5, 0, 0)],
            None,
        ),
        ("SET/MODE,INCR\nFROM/5,5,5\nGOTO/1,1,1\nSET/MODE,ABSOL\nGOTO/1,1,1", [(1, 1, 1)] * 2, None),
        ("FROM/1,1,1\nGODLTA/1,2,3\nGODLTA/-1,0,0", [(2, 3, 4), (1, 3, 4)], None),
        ("GOTO/0,0,0,0,0.6,0.8\nGODLTA/10", [(0, 0, 0), (0, 6, 8)], None),
        ("FROM/7,8,9\nGOTO/1,2,3\nGOHOME", [(1, 2, 3), (7, 8, 9)], None),
        ("GOTO/1,2,3\nGOHOME/7,8,9,0,0,1", [(1, 2, 3), (7, 8, 9)], None),
        ("UNIT/INCH\nGOTO/1,2,3", [(25.4, 50.8, 76.2)], None),
        ("UNITS / INCHES\nGOTO/1,0,0\nUNITS/MM\nGOTO/1,0,0", [(25.4, 0, 0), (1, 0, 0)], None),
        ("MSYS/5,0,0,1,0,0,0,1,0\nGOTO/1,2,3", [(1, 2, 3)], [UP]),
        (
            "MSYS/0,0,0,1,0,0,0,1,0\nGOTO/1,0,0\nMSYS/0,0,10,0,1,0,-1,0,0\nGOTO/1,0,0",
            [(1, 0, 0), (0, 1, 10)],
            [UP] * 2,
        ),
        (
            "MSYS/0,0,10,0,1,0,-1,0,0\nGOTO/0,0,0\nMSYS/0,0,0,1,0,0,0,1,0\nGOTO/1,0,0",
            [(0, 0, 0), (0, -1, -10)],
            None,
        ),
        (
            "TRNTYP/WORLD,0,0,0\nCSYS/1,0,0,0,0,1,0,0,0,0,1,0\nGOTO/1,0,0\nCSYS/1,0,0,0,0,0,-1,7,0,1,0,0\nGOTO/1,0,2",
            [(1, 0, 0), (1, 0, 2)],
            [UP, (0, -1, 0)],
        ),
        ("TRNTYP/WORLD,0,0,0\nGOTO/1,2,3", [(1, 2, 3)], None),
    ],
)
def test_where_the_tool_goes(text, points, axes):
    cl = read(text)
    np.testing.assert_allclose(cl.points, points, atol=1e-9)
    np.testing.assert_allclose(
        cl.axes, [UP] * len(points) if axes is None and "0.6" not in text else axes or cl.axes, atol=1e-6
    )


@pytest.mark.parametrize(
    ("text", "feeds"),
    [
        ("FEDRAT/250", [250]),
        ("FEDRAT/250,MMPM", [250]),
        ("FEDRAT / MMPM, 250", [250]),
        ("FEDRAT/10.,IPM", [254]),
        ("FEDRAT/IPM,10", [254]),
        ("FEDRAT/0.1,MMPR", [100]),
        ("FEDRAT/0.01,IPR", [254]),
        ("FEDRAT/0.1,PERREV", [100]),
        ("UNITS/INCH\nFEDRAT/10,PERMIN", [254]),
        ("UNITS/INCH\nFEDRAT/10", [254]),
        ("RAPID", [np.nan]),
        ("RAPID/", [np.nan]),
        ("FEDRAT/RAPID", [np.nan]),
    ],
)
def test_feeds(text, feeds):
    cl = read(f"{text}\nGOTO/1,2,3")
    np.testing.assert_allclose(cl.feeds, feeds)
    assert cl.rapid.tolist() == np.isnan(feeds).tolist()
    assert not read(f"{text}\nGOTO/1,2,3\nGOTO/4,5,6").rapid[1]  # RAPID is for one move


@pytest.mark.parametrize(
    ("text", "kind", "values"),
    [
        ("LOADTL/2", "tool", (2, None, None)),
        ("LOADTL / 2, ADJUST, 5", "tool", (2, None, 5)),
        ("LOADTL/1,1,1", "tool", (1, None, None)),
        ("LOADTL/2,LENGTH,50", "tool", (2, 50.0, None)),
        ("UNITS/INCH\nLOADTL/2,LENGTH,2", "tool", (2, 50.8, None)),
        ("LOAD/TOOL,20", "tool", (20, None, None)),
        ("LOAD/TOOL,4,ADJUST,1", "tool", (4, None, 1)),
        ("LOADTL/10,ADJUST,1,SPINDL,15915.494300,MILL", "tool", None),
        ("CUTCOM/LEFT,XYPLAN", "compensation", ("LEFT", 1)),
        ("CUTCOM/RIGHT,1", "compensation", ("RIGHT", 1)),
        ("CUTCOM/OFF", "compensation", ("OFF", 1)),
        ("CUTCOM/ON, LEFT, 3", "compensation", ("LEFT", 3)),
        ("STOP", "stop", ()),
        ("OPSTOP", "optional stop", ()),
        ("DELAY/2.5", "dwell", (2.5,)),
    ],
)
def test_commands(text, kind, values):
    if values is None:
        assert "the word LENGTH" in refused(f"{text}\nGOTO/1,2,3")
        return
    record, command = read(f"GOTO/0,0,0\n{text}\nGOTO/1,2,3").remarks[-1]
    assert (record, command.kind, command.values) == (1, kind, values)


@pytest.mark.parametrize(
    "text",
    [
        "PAINT/PATH", "PAINT/SPEED,10", "TPRINT/T1 End Mill", "PPRINT FEED / 5", "PARTNO A, B/C",
        "CSI_SET_FLUTE_LENGTH/143.", "TLDATA/MILL,10.,0.,75.,0.,0.", "CUTTER/ 10.000000,  0.000000,$\n 30.000000",
        "INTOL /    0.01000", "MULTAX/ON", "MULTAX", "SELECT/TOOL,19", "TOOLNO/1,MILL,10.", "END-OF-PATH",
        "TOOL PATH/CAVITY_MILL,TOOL,D10", "MACHIN / UNCX01, 1", "SETUP/START,1", "INSERT/17.5mm JOBBER DRILL",
        "REMARK anything / CIRCLE/ here", "AUTOPS", "FINI",
    ],
)  # fmt: skip
def test_inert_words_move_nothing(text):
    cl = read(f"GOTO/0,0,0\n{text}\nGOTO/1,2,3")
    kinds = [(record, getattr(remark, "kind", "")) for record, remark in cl.remarks]
    assert len(cl) == 2 and kinds[-1][0] == 1 and kinds[-1][1] in ("", "operation", "cutter")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("ROTHED/ATANGL,90,CLW", "tool axes"),
        ("ROTABL/ATANGL,90,CLW", "AAXIS, BAXIS or CAXIS"),
        ("ROTABL/ATANGL,90,AAXIS", "TLAXIS/0.0000,-1.0000,0.0000 of the part"),
        ("TLAXIS/0,1,0\nROTABL/90,AAXIS,CCLW", "found TLAXIS/0.0000,1.0000,0.0000"),
        ("TLAXIS/0,-1,0\nROTABL/90,AAXIS,TABLE,CCLW", "TLAXIS/"),  # degrees where radians stand
        ("ROTABL/90,CAXIS,CLW", "nothing says the sense"),
        ("TLAXIS/0,-1,0\nROTABL/ATANGL,90,AAXIS\nROTABL/ATANGL,90,CAXIS", "which carries which"),
        ("TRNTYP/WORLD,1,0,0", "change nothing"),
        ("RAPID/MODAL", "RAPID"),
        ("MODE/TURN", "INCR, ABSOL or MILL"),
        ("ORIGIN/0,0,5", "change nothing"),
        ("GOTO/5,0,0\nMOVARC/0,0,0,0,0,1,5,ANGLE,80\nGOTO/0,5,0", "an arc of 80 degrees"),
        ("CALSUB/1", "moves that are elsewhere"),
        ("PPWORD/G91", "words into the program"),
        ("GOTO/1,2,3\nCIRCLE/0,0,0,0,0,1,5\nGOTO/1,2,3", "a start 5 mm from the centre"),
        ("GOTO/5,0,0\nCIRCLE/0,0,0,0,0,1,5\nGOTO/0,6,0", "ends equally far"),
        ("GOTO/5,0,0\nCIRCLE/0,0,0,0,0,1,5\nGOTO/0,5,0,0,0.6,0.8", "stands still"),
        ("GOTO/5,0,0\nCIRCLE/0,0,0,0,0,-1,5,.06,.5,9,0,TIMES,0\nGOTO/0,5,0", "from 1 to 1000"),
        ("GOTO/5,0,0\nCIRCLE/0,0,0,0,0,-1,5,.06,.5,9,0,TIMES,1.5\nGOTO/0,5,0", "a whole number"),
        ("GOTO/5,0,0\nCIRCLE/0,0,0,0,0,-1,5,.06,.5,9,0,TIMES\nGOTO/0,5,0", "a number"),
        ("GOTO/5,0,0\nRAPID\nCIRCLE/0,0,0,0,0,1\nGOTO/0,5,0", "an arc at a feed"),
        ("CYCLE/DRILL,126.0,85.0,1.0,MMPR", "after its word"),
        ("CYCLE/DRILL,DEPTH,5,RANGE,3", "in a cycle"),
        ("CYCLE/DRILL,DEPTH,5,MMPM,100", "a clearance"),
        ("CYCLE/MILL,DEPTH,5,MMPM,100,CLEAR,2", "CYCLE/DRILL"),
        ("CYCLE/DRILL,DEPTH,5,CLEAR,2\nLOADTL/2", "CYCLE/OFF"),
        ("GOHOME", "FROM"),
        ("TLAXIS/1,1,1", "unit tool axis"),
        ("INDIRV/0,1,0,0", "3 numbers, found 4"),
        ("MSYS/0,0,0,1,0,0,0,1,0\nGOTO/5,0,0\nCIRCLE/0,0,0,0,0,1\nMSYS/1,0,0,1,0,0,0,1,0", "system of its start"),
        ("GOTO/5,0,0\nINDIRV/0,1,0,0\nTLON,GOFWD/(CIRCLE/0,0,0,5),ON,(LINE/0,0,0,0,5,0)", "INDIRV before TLON"),
        ("GOTO/5,0,0\nINDIRV/0,1,0\nTLON,GOFWD/(CIRCLE/0,0,0,5),ON,2,INTOF,(LINE/0,0,0,0,5,0)", "INTOF"),
        ("GOTO/5,0,0\nINDIRV/0,-1,0\nTLON,GOFWD/(CIRCLE/0,0,0,5),ON,(LINE/0,0,0,0,5,0)", "INTOF"),
        ("SPINDL/5,RPM\nCYCLE/TAP,DEPTH,8,MMPM,5,CLEAR,2\nSPINDL/OFF\nGOTO/0,0,0", "before a hole is tapped"),
        ("LOADTL/2,150.5", "LENGTH"),
        ("SPINDL/500,SFM,CLW", "SFM"),
        ("COOLNT/TAPKUL", "COOLNT"),
        ("MSYS/0,0,0,1,0,0,0,2,0", "right-handed"),
        ("GOTO/1,2,3\nMSYS/0,0,0,1,0,0,0,1,0", "before the first move"),
    ],
)  # fmt: skip
def test_hazards_are_refused(text, words):
    assert words in refused(f"{text}\nGOTO/1,2,3")


def test_a_feed_in_inches_needs_units():
    with pytest.raises(InputError, match="line 1, FEDRAT.*UNITS"):
        cldata.parse("FEDRAT/10,IPM\nGOTO/1,2,3\n", "part.cl")


def test_a_table_that_turns():
    """The words of a published SolidWorks file: holes in the face −Y of a block, and back to its face +Z."""
    back = "ROTABL/ 0.0,AAXIS,TABLE,CCLW\n"
    there = "ROTABL/ 1.570796,AAXIS,TABLE,CCLW\nROTABL/ -0.0,BAXIS,TABLE,CCLW\nROTABL/ 0.0,CAXIS,TABLE,CCLW\n"
    holes = f"TLAXIS/0,-1,0\n{there}GOTO/67.5,120.5,25\n{there}GOTO/67.5,120.5,5\n"
    cl = read(f"GOTO/1,2,3\n{holes}{back}TLAXIS/0,0,1\nGOTO/4,5,6\n")
    np.testing.assert_allclose(cl.points, [[1, 2, 3], [67.5, -25, 120.5], [67.5, -5, 120.5], [4, 5, 6]], atol=1e-4)
    np.testing.assert_allclose(cl.axes, [[0, 0, 1], [0, -1, 0], [0, -1, 0], [0, 0, 1]], atol=1e-6)
    assert cl.notes == ("changes of the coordinate system, brought into the first: 2",)


@pytest.mark.parametrize("axis", "AB")
@pytest.mark.parametrize("sense", ["CCLW", "CLW"])
@pytest.mark.parametrize("form", ["ATANGL,{},{}AXIS,{}", "INCR,{},{}AXIS,{}", "{},{}AXIS,{}"])
def test_turns_of_a_table_in_degrees(axis, sense, form):
    """Against SciPy, in coordinates of MSYS that lean; two turns add up, two ATANGL do not."""
    lean, about = Rotation.from_euler("x", 30, degrees=True), {"A": "x", "B": "y"}[axis]
    angle = (40 if "ATANGL" in form else 65) * (1 if sense == "CCLW" else -1)
    whole = Rotation.from_euler(about, angle, degrees=True)
    i, j, k = whole.apply([0, 0, 1])
    words = "\n".join("ROTABL/" + form.format(angle, axis, sense) for angle in (25, 40))
    x, y = lean.apply([[1, 0, 0], [0, 1, 0]]).tolist()
    msys = "MSYS/" + ",".join(map(str, [5, 6, 7, *x, *y]))
    cl = read(f"MSYS/0,0,0,1,0,0,0,1,0\nGOTO/0,0,0\n{msys}\nTLAXIS/{i},{j},{k}\n{words}\nGOTO/1,2,3\nGOTO/3,2,1")
    points = lean.apply(whole.apply([[1, 2, 3], [3, 2, 1]]))
    np.testing.assert_allclose(cl.points[1:] - [5, 6, 7], points, atol=1e-9)
    np.testing.assert_allclose(cl.axes[1:], lean.apply([[i, j, k]] * 2), atol=1e-9)


def test_coolant_without_a_common_word_is_a_comment_and_said():
    cl = read("COOLNT/THRU\nGOTO/1,2,3\nCOOLNT/OFF\nGOTO/1,2,4")
    result = run(cl, TABLE)
    assert "; COOLNT/THRU" in result.program and "M9" in result.program and "M8" not in result.program
    assert "stays off: a comment tells which THRU" in str(result.report)


def test_all_problems_are_listed_with_their_counts():
    message = refused("GOTO/1,2\nROTHED/1\nGOTO/1,2,3\nROTHED/2\nHOCUS/1\nGOTO/1,2,3,0,0,2")
    assert message.startswith("part.cl, line 4, GOTO: expected 3, 6 or 9 numbers, found 2")
    for words in (
        "line 5, ROTHED",
        "(2 times, up to line 7)",
        "'HOCUS/1'",
        "line 9, GOTO: expected a unit",
        "--ignore",
    ):
        assert words in message


def test_a_word_may_be_ignored_and_that_is_said():
    cl = read("GOTO/1,2,3\nPREFUN/1\nPREFUN/2\n", ignored=["prefun"])
    assert cl.notes == ("ignored as asked PREFUN: 2",)
    assert "ignored as asked PREFUN: 2" in str(run(cl, TABLE).report)


@pytest.mark.parametrize(
    ("encoding", "name"),
    [("utf-8", "零件 Ø10"), ("gb18030", "铣刀 第一工序"), ("cp1252", "Fräser Ø10"), ("utf-8-sig", "Ø")],
)
@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_encodings(tmp_path, encoding, name, end):
    (tmp_path / "part.cl").write_bytes(f"PPRINT {name}{end}GOTO/1,2,3{end}".encode(encoding))
    assert cldata.read(tmp_path / "part.cl").remarks == ((0, f"PPRINT {name}"),)


def test_comments_of_creo_go_on():
    cl = read(
        "$$-> CSYS / 1.0, 0.0,  $\n 0.0, 1.0, $\n 0.0, 0.0\nGOTO / 1, 2, $ $$ first orbit\n 3\n$$ no $\nGOTO/4,5,6"
    )
    assert cl.points.tolist() == [[1, 2, 3], [4, 5, 6]]


# Arcs


QUARTER = {
    "SolidWorks": "CIRCLE/0,0,0,0,0,1",
    "Creo": "CIRCLE / 0.0, 0.0, 0.0,  $\n 0.0, 0.0, 1.0, 5.0",
    "CAMWorks": "CIRCLE/ 0,0,0,0,0,1,5,COUNTERCLOCKWISE",
    "CAMWorks, about the other end": "CIRCLE/ 0,0,0,0,0,-1,5,CLOCKWISE",
    "NX": "CIRCLE/0.,0.,0.,0.,0.,-1.,5.,0.06,0.5,10.,0.",
}


@pytest.mark.parametrize("system", QUARTER)
@pytest.mark.parametrize("tolerance", [0.1, 0.001])
def test_arcs(system, tolerance):
    """From (5, 0) to (0, 5) counterclockwise: all points on the circle, in order, chords within the tolerance."""
    cl = read(f"GOTO/5,0,0\n{QUARTER[system]}\nGOTO/0,5,0\nRAPID\nGOTO/0,5,9", tolerance=tolerance)
    points = cl.points[:-1, :2]
    angles = np.arctan2(points[:, 1], points[:, 0])
    np.testing.assert_allclose(np.hypot(*points.T), 5, atol=1e-12)
    assert angles[0] == 0 and angles[-1] == pytest.approx(np.pi / 2) and (np.diff(angles) > 0).all()
    middles = (points[1:] + points[:-1]) / 2
    assert 5 - np.hypot(*middles.T).min() <= tolerance
    assert (cl.feeds[1:-1] == 100).all() and not cl.rapid[:-1].any() and "arcs as chords" in cl.notes[0]


@pytest.mark.parametrize(
    ("tangent", "end", "angle"),
    [((0, 1, 0), (0, 5), 90), ((0, -1, 0), (0, 5), -270), ((0, 1, 0), (3, -4), 306.8698976)],
)
def test_arcs_of_catia(tangent, end, angle):
    line = ",".join(f"{value:.6f}" for value in (0, 0, 2, *end, 2))
    which = "2,INTOF," if abs(angle) > 180 else ""  # of the points where the line, both ways, meets the circle
    words = f"TLON,GOFWD/ (CIRCLE/ 0.0, 0.0, 2.0,$\n 5.0),ON,{which}(LINE/{line})"
    cl = read(f"AUTOPS\nGOTO/5,0,2\nINDIRV/{','.join(map(str, tangent))}\n{words}")
    turned = np.unwrap(np.arctan2(cl.points[:, 1], cl.points[:, 0]))
    assert np.degrees(turned[-1]) == pytest.approx(angle) and (cl.points[:, 2] == 2).all()


def test_arc_of_catia_on_a_cylinder():
    plane = "(PLANE/PERPTO,$\n(PLANE/(POINT/0,0,0),PERPTO,(VECTOR/0,1,0)),$\n(POINT/0,0,0),(POINT/0,3,5))"
    words = f"TLON,GOFWD/(CYLNDR/0,0,0,0,1,0,5),ON,$\n{plane}"
    cl = read(f"GOTO/5,3,0,0,1,0\nPSIS/(PLANE/(POINT/5,3,0),PERPTO,(VECTOR/0,1,0))\nINDIRV/0,0,1\n{words}")
    np.testing.assert_allclose(cl.points[-1], [0, 3, 5], atol=1e-12)
    np.testing.assert_allclose(np.hypot(cl.points[:, 0], cl.points[:, 2]), 5)
    assert (cl.points[:, 2] >= 0).all()  # the short way, as the tangent says


@pytest.mark.parametrize(("times", "end", "turned"), [(1, (0, 5), 90), (2, (0, 5), 450), (3, (5, 0), 1080)])
def test_helix_of_nx(times, end, turned):
    """The height falls evenly with the angle that the tool has turned by, to the last of the turns begun."""
    circle = f"CIRCLE/0,0,-3,0,0,-1,5,.06,.5,9,0,TIMES,{times}"
    cl = read(f"GOTO/5,0,0\n{circle}\nGOTO/{end[0]},{end[1]},-3")
    angles = np.degrees(np.unwrap(np.arctan2(cl.points[:, 1], cl.points[:, 0])))
    assert angles[-1] == pytest.approx(turned)
    np.testing.assert_allclose(np.hypot(*cl.points[:, :2].T), 5)
    np.testing.assert_allclose(cl.points[:, 2], -3 * angles / turned, atol=1e-12)


def test_full_turns_and_helices():
    rng = np.random.default_rng(3)
    for _ in range(50):
        centre, axis = rng.normal(size=3) * 50, rng.normal(size=3)
        axis /= np.linalg.norm(axis)
        across = np.cross(axis, rng.normal(size=3))
        across *= rng.uniform(0.5, 80) / np.linalg.norm(across)
        angle, rise = rng.uniform(0.1, 2 * np.pi), rng.normal() * 5
        end = centre + np.cos(angle) * across + np.sin(angle) * np.cross(axis, across) + rise * axis
        points = arc(centre + across, end, centre, axis, 0.002)
        t = np.arange(1, len(points) + 1) / len(points)
        exact = [centre + np.cos(a) * across + np.sin(a) * np.cross(axis, across) for a in t * angle]
        np.testing.assert_allclose(points, np.array(exact) + np.outer(t * rise, axis), atol=1e-9)
    whole = arc([3, 0, 0], [3, 0, 0], [0, 0, 0], [0, 0, -1], 0.01)
    assert whole[len(whole) // 4, 1] < 0 and len(whole) > 30  # clockwise, all the way round


# Holes


def heights(cl):
    return cl.points[:, 2].round(6).tolist()


@pytest.mark.parametrize(
    ("cycle", "expected"),
    [
        ("CYCLE/DRILL,RAPTO,3.0,FEDTO,-8.0,RTRCTO,AUTO,MMPM,250.0", [25, 25, 3, -8, 25]),
        ("CYCLE/DRILL,FEDTO,8.,MMPM,250,RAPTO,3.,RTRCTO,10.,DWELL,0", [25, 10, 3, -8, 10]),
        ("CYCLE / DRILL, DEPTH, 8.0, MMPM, 250.0, CLEAR, 3.0", [25, 25, 3, -8, 25]),
        ("CYCLE/BORE,DEPTH,8,MMPM,250,CLEAR,3", [25, 25, 3, -8, 3, 25]),
        (
            "CYCLE/DEEP2,FEDTO,8.,1STPECK,5.,SUBPECK,2.,MMPM,250,RAPTO,3.,RTRCTO,25.",
            [25, 25, 3, -5, 3, -4.5, -7, 3, -6.5, -8, 25],
        ),
        ("CYCLE/DRILL,DEEP,STEP,5,RAPTO,3,FEDTO,-8,MMPM,250", [25, 25, 3, -5, 3, -4.5, -8, 25]),
        ("CYCLE/BRKCHP,STEP,5,RAPTO,3,FEDTO,-8,MMPM,250", [25, 25, 3, -5, -4.5, -8, 25]),
        ("CYCLE/DRILL,DEPTH,8,MMPM,250,CLEAR,3,RETURN,10", [25, 10, 3, -8, 10]),
        ("CYCLE / DRILL, DEPTH, 8, MMPM, 250, CLEAR, 5, RAPTO, 3, RETURN, 0", [25, 25, 2, -8, 25]),
        ("CYCLE/DRILL,DEPTH,8,MMPM,250,CLEAR,3,RETURN", [25, 25, 3, -8, 25]),
        ("CYCLE/ DRILL, DEPTH, 8, PERMIN, 250, CLEAR, 10, RETURN, 10, RAPTO, 7", [25, 10, 3, -8, 10]),
        ("CYCLE/DEEP,DEPTH,8,STEP,5,MMPM,250,CLEAR,3,RETURN,10", [25, 10, 3, -5, 3, -4.5, -8, 10]),
    ],
)  # fmt: skip
def test_drilling_cycles(cycle, expected):
    cl = read(f"GOTO/0,0,25\n{cycle}\nGOTO/1,0,0\nGOTO/2,0,0\nCYCLE/OFF\nGOTO/2,0,30")
    holes = expected[1:]
    assert heights(cl) == [25, *holes, *holes, 30]
    down = np.flatnonzero(~cl.rapid)[1:-1]
    assert (cl.feeds[down] == 250).all() and cl.feeds[-1] == 100
    # Rapid is only what ends above the part, goes up, or goes where the drill has been.
    deepest = np.minimum.accumulate(np.r_[0, heights(cl)])[:-1]
    ends, starts = np.array(heights(cl)[1:]), np.array(heights(cl)[:-1])
    assert ((ends > 0) | (ends > starts) | (ends > deepest[1:]))[cl.rapid[1:]].all()


def test_a_hole_goes_along_the_tool_axis():
    cl = read("TLAXIS/0,0.6,0.8\nGOTO/0,60,80\nCYCLE/DRILL,DEPTH,10,MMPM,50,CLEAR,5\nGOTO/0,0,0\nCYCLE/OFF")
    np.testing.assert_allclose(cl.points, np.outer([100, 100, 5, -10, 100], [0, 0.6, 0.8]), atol=1e-9)


def test_tapping_turns_back_at_the_bottom():
    cl = read("GOTO/0,0,25\nCYCLE/TAP,DEPTH,8,MMPR,1.5,CLEAR,3\nGOTO/1,0,0\nCYCLE/OFF")
    assert heights(cl) == [25, 25, 3, -8, 3, 25] and cl.feeds[3] == cl.feeds[4] == 1500
    turns = [
        (record, remark.values[1]) for record, remark in cl.remarks if getattr(remark, "kind", "") == "spindle"
    ]
    assert turns == [(0, "CLW"), (4, "CCLW"), (5, "CLW")]


# Programs, read by a reader that shares nothing with the package


def run(cl, setup, **options):
    """The program as straight moves: `tests.post.test_own_words` is on the others."""
    return run_with_own_words(cl, setup, expand=True, **options)


def moved(result, machine, dialect="heidenhain", lengths=None):
    """The moves of a program, and what they make of tip and tool axis on a machine set up alike."""
    file = DATA / f"machines/{'ac_head' if machine.name == HEAD.name else 'ac_table'}.toml"
    model = Model(file, length=machine.tool_length, origin=machine.origin)
    moves = reader.read(result.program, dialect, reader.Setup(model, length_on=True, lengths=lengths or {}))
    return moves, judge.sample(model, moves)


@pytest.mark.parametrize(
    ("dialect", "tcp", "lines"),
    [
        ("heidenhain", False, ["TOOL CALL 2 Z S1500", "M3", "M8"]),
        ("fanuc", False, ["T2 M6", "S1500 M3", "M8"]),
        ("siemens", False, ["T2", "M6", "D1", "S1500 M3", "M8"]),
        ("heidenhain", True, ["TOOL CALL 2 Z S1500", "M3", "M8", "M128"]),
        ("fanuc", True, ["T2 M6", "S1500 M3", "M8", "G43.4 H2"]),
        ("siemens", True, ["T2", "M6", "D1", "S1500 M3", "M8", "TRAORI"]),
    ],
)
def test_the_words_of_the_control(dialect, tcp, lines):
    cl = cldata.parse(
        "LOADTL/2\nSPINDL/1500,RPM,CLW\nCOOLNT/ON\nFEDRAT/100\nGOTO/0,0,0\nGOTO/5,0,0,0,0.6,0.8\n"
        "STOP\nDELAY/2\nGOTO/9,0,0\n"
    )
    text = run(cl, TABLE, dialect=dialect, tcp=tcp).program
    said = [line.split(" ", 1)[1] for line in text.splitlines() if line[0] in "N0123456789"]
    said = [line for line in said if line[0] != ";"]
    first = next(n for n, line in enumerate(said) if " X" in line)
    assert said[:first][-len(lines) :] == lines
    assert ("G43 H2 X" in said[first]) == (dialect == "fanuc" and not tcp)
    assert "M0" in said and any("2.000" in line for line in said)


@pytest.mark.parametrize("dialect", ["heidenhain", "fanuc", "siemens"])
def test_cutter_compensation_while_the_rotary_axes_stand(dialect):
    square = "GOTO/-20,-20,5\nCUTCOM/LEFT\nGOTO/0,0,5\nGOTO/0,30,5\nCUTCOM/OFF\nGOTO/-20,50,5\n"
    result = run(read(square), TABLE, dialect=dialect)
    assert [move.modal["compensation"] for move in moved(result, TABLE, dialect)[0]] == [40, 41, 41, 40]
    assert any("cutter compensation" in warning for warning in result.report.warnings)
    turning = square.replace("GOTO/0,30,5", "GOTO/0,30,5,0,0.6,0.8")
    with pytest.raises(InputError, match="CUTCOM/LEFT.*stand still"):
        run(read(turning), TABLE, dialect=dialect)
    with pytest.raises(InputError, match="CUTCOM/LEFT"):
        run(read("TLAXIS/0,0.6,0.8\n" + square), HEAD, dialect=dialect)


def test_an_axis_turned_by_180_degrees_is_refused_with_its_line():
    with pytest.raises(InputError, match="part.cl, line 5, record 2.*180"):
        run(read("GOTO/0,0,0,0,0.6,0.8\nGOTO/0,0,0,0,-0.6,-0.8"), replace(TABLE))


@pytest.mark.parametrize("axis", [(0, 0.6, 0.8), (1, 0, 0), (0, 0, 1), (-0.48, 0.64, -0.6)])
def test_a_rapid_move_may_turn_the_tool_by_180_degrees(axis):
    """The program ends where and as the file says; half way the tool stands across; remarks keep their places."""
    wide = replace(TABLE, rotary=tuple(replace(joint, limits=(-7, 7)) for joint in TABLE.rotary))
    there, back = (",".join(f"{sign * value}" for value in axis) for sign in (1, -1))
    text = f"GOTO/0,0,9,{there}\nSTOP\nRAPID\nGOTO/20,0,5,{back}\nPPRINT here\nGOTO/20,10,5"
    cl = read(text)
    np.testing.assert_allclose(cl.points, [(0, 0, 9), (10, 0, 7), (20, 0, 5), (20, 10, 5)])
    assert abs(cl.axes[1] @ axis) < 1e-12 and cl.rapid.tolist() == [False, True, True, False]
    places = {getattr(remark, "statement", remark): record for record, remark in cl.remarks}
    assert (places["STOP"], places["PPRINT here"]) == (1, 3)
    assert any("180°" in note for note in cl.notes)
    moves, samples = moved(run(cl, wide), wide)
    np.testing.assert_allclose(samples.tip[-1], (20, 10, 5), atol=1e-3)
    np.testing.assert_allclose(samples.axis[-1], np.negative(axis), atol=1e-5)
    assert [move.kind for move in moves[-2:]] == ["rapid", "feed"]


def test_a_new_tool_does_not_come_from_where_the_one_before_it_ended():
    assert len(read("GOTO/0,0,9,0,0,1\nLOADTL/2\nRAPID\nGOTO/20,0,5,0,0,-1")) == 2


def random_file(rng):
    """A file in inches or mm, with tools, arcs about Z, holes, and tool axes; all within 60 mm of the origin."""
    scale = rng.choice([1.0, 25.4])
    lines = ["UNITS/MM" if scale == 1 else "UNITS/INCH", "SPINDL/1000,RPM,CLW"]
    for tool in range(1, rng.integers(2, 5)):
        lines += [
            f"LOADTL/{tool},LENGTH,{rng.uniform(80, 120) / scale:.4f}",
            f"FEDRAT/{rng.uniform(100, 3000):.1f},MMPM",
        ]
        for _ in range(rng.integers(1, 4)):
            x, y, z = rng.uniform(-40, 40, 3) / scale
            axis = rng.normal(size=3) * [0.4, 0.4, 0] + [0, 0, 1]
            axis = ",".join(f"{value:.9f}" for value in axis / np.linalg.norm(axis))
            start = f"RAPID\nGOTO/{x:.6f},{y:.6f},{z:.6f},{axis}"
            kind = rng.integers(3)
            if kind == 0:
                lines += [start, f"GOTO/{y:.6f},{x:.6f},{z:.6f}", f"GOTO/{y:.6f},{x:.6f},{z:.6f},0,0,1"]
            elif kind == 1:
                r, a = rng.uniform(2, 15) / scale, rng.uniform(0.3, 6)
                end = f"{x - r + r * np.cos(a):.6f},{y + r * np.sin(a):.6f},{z:.6f}"
                lines += [start, f"CIRCLE/{x - r:.6f},{y:.6f},{z:.6f},0,0,1", f"GOTO/{end}"]
            else:
                cycle = f"CYCLE/DEEP,DEPTH,{9 / scale:.4f},STEP,{4 / scale:.4f},MMPM,120,CLEAR,{2 / scale:.4f}"
                lines += [start, cycle, f"GOTO/{x:.6f},{y:.6f},{z - 20 / scale:.6f}", "CYCLE/OFF"]
    return "\n".join(lines)


@pytest.mark.parametrize("seed", range(12))
def test_random_files(seed):
    """Tip, tool axis and feed as the report says, on a machine set up at random."""
    rng = np.random.default_rng(seed)
    cl = cldata.parse(random_file(rng), "random.cl")
    machine, dialect = (TABLE, HEAD)[seed % 2], ["heidenhain", "fanuc", "siemens"][seed % 3]
    machine = machine.with_setup(origin=tuple(rng.uniform(-30, 30, 3) if machine is TABLE else np.zeros(3)))
    result = run(cl, machine, dialect=dialect, tolerance=0.02)
    lengths = {r.values[0]: r.values[1] for _, r in cl.remarks if getattr(r, "kind", "") == "tool"}
    moves, samples = moved(result, machine, dialect, lengths)
    assert judge.records_missed(samples.tip, samples.axis, cl.points, cl.axes, 2e-3, 6e-4) == []
    assert result.report.tip_error < 2e-3 and result.report.path_tip_error <= 0.02
    assert len(moves) == len(result.place)
    rapid = cl.rapid[np.ceil(result.place).astype(int)]
    for n, move in enumerate(moves):
        if move.kind == "feed" and not rapid[n] and (tips := samples.tip[samples.move == n]).size:
            assert 60 * np.linalg.norm(tips[-1] - tips[0]) / move.seconds <= np.nanmax(cl.feeds) * (1 + 1e-3)


@pytest.mark.parametrize("dialect", ["heidenhain", "fanuc", "siemens"])
@pytest.mark.parametrize("tcp", [False, True])
def test_travel_is_that_of_the_slides(dialect, tcp):
    """A slide stands at its word, plus the origin, plus the tool where the word names the tip."""
    cl = read("GOTO/0,0,0\nGOTO/50,0,0\nGOTO/50,0,10,0,0.6,0.8")
    run(cl, TABLE.with_setup(origin=(350, 0, 0)), dialect=dialect, tcp=tcp)
    for origin in ((360, 0, 0), (600, 0, 0), (0, 0, 300)):  # the tool is 120 mm long
        with pytest.raises(ReachError, match="slide [XZ] .* is outside -400 … 400"):
            run(cl, TABLE.with_setup(origin=origin), dialect=dialect, tcp=tcp)
    run(cl, replace(TABLE, limits_of="words").with_setup(origin=(600, 0, 0)), dialect=dialect, tcp=tcp)


@pytest.mark.parametrize("tcp", [False, True])
def test_travel_is_looked_at_between_the_blocks_whatever_the_tolerance(tcp):
    cl = read("GOTO/0,0,100,0,0.8,0.6\nGOTO/0,0,100,0,-0.3,0.953939")
    free = run(cl, TABLE, tolerance=0.01).blocks.words
    top = free[:, 2].max()
    assert top > free[[0, -1], 2].max() + 5  # reached between the records
    limits = (-1000, TABLE.slides[2] + top - 0.1)
    low = replace(TABLE, linear=(*TABLE.linear[:2], replace(TABLE.linear[2], limits=limits)))
    with pytest.raises(ReachError, match="slide Z"):
        run(cl, low, tolerance=20.0, tcp=tcp)


def test_no_word_commands_more_than_the_feed():
    rng = np.random.default_rng(7)
    axes = np.cumsum(rng.normal(size=(200, 3)) * 0.01, axis=0) + UP
    points = np.cumsum(rng.normal(size=(200, 3)) * 0.05, axis=0)
    rates = {
        name: tuple(replace(joint, max_rate=1e6) for joint in getattr(TABLE, name)) for name in ("linear", "rotary")
    }
    quick = replace(TABLE, **rates)
    for dialect in ("heidenhain", "fanuc"):
        cl = cldata.from_arrays(points, axes, feed=10_000 / 3)
        moves, samples = moved(run(cl, quick, dialect=dialect), quick, dialect)
        assert len(moves) > 190
        for n, move in enumerate(moves[2:], 2):
            tips = samples.tip[samples.move == n]
            length = np.linalg.norm(tips[-1] - tips[0])
            assert 60 * length / move.seconds <= 10_000 / 3 * (1 + 1e-3) + 60 * 2e-4 / move.seconds


@pytest.mark.parametrize("feed", [444.49999, 158.8196, 1 / 3, 0.001])
def test_a_broken_feed_is_rounded_down(feed):
    cl = read(f"FEDRAT/{feed:.6f},MMPM\nGOTO/0,0,0\nGOTO/10,0,0")
    printed = run(cl, TABLE).blocks.feeds[1]
    assert feed - 0.001 <= printed <= feed


PROGRAM = {
    "heidenhain": (
        ["L Z+390 R0 FMAX M91"], ["L Z+390 R0 FMAX M91", "M30"], ["L M91 Z+395", "TOOL CALL {tool} Z S500"],
    ),
    "fanuc": (["G54", "(HEAD OF {name})"], ["M5", "G91 G28 Z0", "G90"], ["G91 G28 Z0", "G90 T{tool} M6"]),
    "siemens": (["G54 ; {name}"], ["SUPA Z390"], ['T="MILL_{tool}" D1', "M6"]),
}  # fmt: skip


@pytest.mark.parametrize("dialect", PROGRAM)
def test_head_foot_and_tool_change_of_the_machine_file(dialect):
    head, foot, change = PROGRAM[dialect]
    data = replace(TABLE, program_head=tuple(head), program_foot=tuple(foot), tool_change=tuple(change))
    text = run(
        read("LOADTL/3\nGOTO/0,0,0\nGOTO/9,0,0\nLOADTL/4\nGOTO/9,0,0"), data, dialect=dialect, name="part"
    ).program
    lines = [line.split(" ", 1)[-1] if line[0] in "N0123456789" else line for line in text.splitlines()]
    expected = [(line, "") for line in head] + [(line, tool) for tool in "34" for line in change]
    at = 0  # all of them, in this order
    for line, tool in expected + [(line, "") for line in foot]:
        at = 1 + lines.index(line.replace("{name}", "PART").replace("{tool}", tool), at)
