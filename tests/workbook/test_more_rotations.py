"""Rotations other than one of a point by three typed angles: frames in a chain, centres, quaternions, lookups.

Each right sheet, and slips in it at which the first wrong cell must be named. Nothing here is computed by the
package.
"""

import re

import pytest

from mathpost.workbook import Task
from mathpost.workbook.meaning.texts import reading
from tests.workbook.test_strange_sheets import WHOLE, _check, _matrix, _places, _product, _sheet

ROWS = (6, 7, 8)


def _two_frames():
    """The sheet of one frame, and a second one by B21:B23 that takes M6:M8 less the origin D21:D23."""
    cells = _sheet() | {
        f"{c}{20 + n}": v for c, v3 in (("B", (20, -35, 71)), ("D", (5, -6, 7))) for n, v in _from_1(v3)
    }
    for corner, axis, angle in (("A26", "Z", "B21"), ("A30", "X", "B22"), ("A34", "Z", "B23")):
        cells |= _matrix(corner, axis, angle)
    cells |= _product("E26", "A30", "A26") | _product("I26", "A34", "E26")
    return cells | {f"M{n}": f"=I{n}*(M6-D21)+J{n}*(M7-D22)+K{n}*(M8-D23)" for n in (26, 27, 28)}


def _from_1(values):
    return enumerate(values, 1)


def _centre(angles=(135, 54.7356, -90)):
    """The point D1:D3 turned about the centre F1:F3."""
    cells = _sheet(angles=angles) | {f"F{n}": v for n, v in _from_1((7, -8, 9))}
    for axis, corner in (("Z", "A6"), ("X", "A10"), ("Z", "A14")):
        cells |= _matrix(
            corner, axis, {"A6": "B3", "A10": "B2", "A14": "B1"}[corner], ("COS(RADIANS({}))", "-SIN(RADIANS({}))")
        )
    rows = {f"M{n}": f"=I{n}*(D1-F1)+J{n}*(D2-F2)+K{n}*(D3-F3)+F{n - 5}" for n in ROWS}
    return cells | rows | {"A20": "active rotation about the centre", "E1": "centre"}


def _quaternion(*names):
    """A typed quaternion in B1:B4, divided by its length in C1:C4, its matrix in E1:G3, a point in I1:I3."""
    cells = dict(zip(("B1", "B2", "B3", "B4"), (0.8, 0.1, -0.5, 0.3), strict=True)) | {
        "A10": "quaternion, p' = q p q*"
    }
    cells |= {f"A{n}": name for n, name in _from_1(names)} | {"B5": "=SQRT(SUMSQ(B1:B4))"}
    cells |= {f"C{n}": f"=B{n}/$B$5" for n in (1, 2, 3, 4)} | {f"I{n}": v for n, v in _from_1((3, -4, 5))}
    place = {name: f"C{n}" for n, name in _from_1(names)}
    elements = (
        *("1-2*(y^2+z^2)", "2*(x*y-w*z)", "2*(x*z+w*y)"),
        *("2*(x*y+w*z)", "1-2*(x^2+z^2)", "2*(y*z-w*x)"),
        *("2*(x*z-w*y)", "2*(y*z+w*x)", "1-2*(x^2+y^2)"),
    )
    for address, element in zip(_places("E1"), elements, strict=True):
        cells[address] = "=" + "".join(place.get(letter, letter) for letter in element)
    return cells | {f"K{n}": f"=SUMPRODUCT(E{n}:G{n},TRANSPOSE($I$1:$I$3))" for n in (1, 2, 3)}


def _axis():
    """Rodrigues' formula with the matrix of the cross product, E1:G3, its square, I1:K3, and the unit matrix."""
    cells = {f"B{n}": v for n, v in _from_1((3, -1, 2))} | {"B4": "=SQRT(SUMSQ(B1:B3))", "B5": 100}
    skew = ("0", "-B3/B4", "B2/B4", "B3/B4", "0", "-B1/B4", "-B2/B4", "B1/B4", "0")
    cells |= {p: f"={e}" if "/" in e else 0 for p, e in zip(_places("E1"), skew, strict=True)}
    cells |= _product("I1", "E1", "E1") | dict(zip(_places("M1"), (1, 0, 0, 0, 1, 0, 0, 0, 1), strict=True))
    for unit, first, second, place in zip(*map(_places, ("M1", "E1", "I1", "E6")), strict=True):
        cells[place] = f"={unit}+SIN(RADIANS($B$5))*{first}+(1-COS(RADIANS($B$5)))*{second}"
    return cells | {f"C{n}": v for n, v in _from_1((14, -5, 6))} | _product("I6", "E6", "C1", 1)


def _lookups():
    """Angles and points of set-ups in rows 21 to 24, chosen by name for each of three rows."""
    setups = {
        "p": (10, 20, 30, 1, 2, 3),
        "q": (-40, 50, 60, 4, 5, 7),
        "r": (15, 75, 5, 8, -2, 0.5),
        "s": (1, 2, 3, 4, 5, 6),
    }
    cells = {"F20": "setup"}
    for row, (name, numbers) in enumerate(setups.items(), 21):
        cells |= {f"F{row}": name} | {f"{c}{row}": v for c, v in zip("GHIJKL", numbers, strict=True)}
    cells |= {f"C{n}": f'=RADIANS(VLOOKUP("q",$F$21:$L$24,{n + 1},FALSE))' for n in (1, 2, 3)}
    cells |= {f"D{n}": f'=INDEX($J$21:$L$24,MATCH("q",$F$21:$F$24,0),{n})' for n in (1, 2, 3)}
    return cells | {f"M{n}": f"={formula}" for n, formula in _from_1(WHOLE)}


def _conversion():
    """Angles of Z-X-Z in C1:C3, converted into Z-Y-X in G1:G3 by the elements in E1:E5 of the passive matrix."""
    texts = {"A10": "Euler angles Z-X'-Z'' converted into", "A11": "Euler angles Z-Y'-X''"}
    cells = {f"B{n}": v for n, v in _from_1((-51, 34, 5))} | {f"C{n}": f"=RADIANS(B{n})" for n in (1, 2, 3)}
    cells |= {
        "E1": "=COS(C3)*COS(C1)-SIN(C3)*COS(C2)*SIN(C1)",
        "E2": "=COS(C3)*SIN(C1)+SIN(C3)*COS(C2)*COS(C1)",
        **{"E3": "=SIN(C3)*SIN(C2)", "E4": "=COS(C3)*SIN(C2)", "E5": "=COS(C2)"},
        **{"G1": "=DEGREES(ATAN2(E1,E2))", "G2": "=DEGREES(ASIN(-E3))", "G3": "=DEGREES(ATAN2(E5,E4))"},
    }
    return cells | texts


def _to_quaternion():
    """The quaternion, x y z w, of yaw, pitch and roll in B1:B3."""
    cells = {f"B{n}": v for n, v in _from_1((25, -10, 60))} | {"A10": "Euler angles Z-Y'-X'' to a quaternion"}
    cells |= {f"{c}{n}": f"={f}(RADIANS(B{n}/2))" for c, f in (("D", "COS"), ("E", "SIN")) for n in (1, 2, 3)}
    parts = ("E3*D2*D1-D3*E2*E1", "D3*E2*D1+E3*D2*E1", "D3*D2*E1-E3*E2*D1", "D3*D2*D1+E3*E2*E1")
    cells |= {f"H{n}": f"={part}" for n, part in _from_1(parts)} | {f"G{n}": c for n, c in _from_1("xyzw")}
    return cells | {"H6": "=SQRT(SUMSQ(H1:H4))"}


def _two_axes():
    cells = _sheet() | {"A20": "Turned about Z, then about the new X"}
    return {p: v for p, v in cells.items() if p not in ("B3", *_places("A14"), *_places("I6"))} | _product(
        "M6", "E6", "D1", 1
    )


def _minutes():
    """Degrees, minutes and seconds in columns B to D, put together in radians."""
    cells = {p: v for p, v in _sheet(("COS({})", "SIN({})")).items() if p[0] not in "BD" or int(p[1:]) > 3}
    cells |= {f"P{n}": v for n, v in _from_1((3, 4, 5))} | _product("M6", "I6", "P1", 1)
    angles = ((24, 17, 33), (66, 42, 12), (8, 55, 41))
    cells |= {f"{c}{21 + n}": v for n, three in enumerate(angles) for c, v in zip("BCD", three, strict=True)}
    return cells | {f"B{n}": f"=RADIANS(B{20 + n}+C{20 + n}/60+D{20 + n}/3600)" for n in (1, 2, 3)}


def _terms():
    """What each coordinate adds to the three of the result, and the sums of these."""
    cells = {p: v for p, v in _sheet().items() if p[0] != "M"}
    cells |= {f"{'PQR'[k]}{6 + n}": f"={'IJK'[n]}{6 + k}*$D${n + 1}" for n in range(3) for k in range(3)}
    return cells | {f"{c}9": f"=SUM({c}6:{c}8)" for c in "PQR"}


def _in_another_order():
    """The result as z, x, y, as its labels say."""
    cells = {p: v for p, v in _sheet().items() if p[0] != "M"} | {"P5": "z'", "Q5": "x'", "R5": "y'"}
    return cells | {f"{c}6": f"=I{n}*D1+J{n}*D2+K{n}*D3" for c, n in zip("PQR", (8, 6, 7), strict=True)}


SHEETS = {
    "two frames": (
        _two_frames(),
        {"A7": "=SIN(RADIANS(B1))", "B27": "=SIN(RADIANS(B21))", "M27": "=I27*(M6-D21)+J27*(M8-D22)+K27*(M8-D23)"},
    ),
    "an origin of the second frame": (_two_frames(), {"M26": "=I26*(M6+D21)+J26*(M7-D22)+K26*(M8-D23)"}),
    "a centre": (
        _centre(),
        {"M7": "=I7*(D1-F1)+J7*(D2-F2)+K7*(D3-F3)", "M8": "=I8*(D1-F1)+J8*(D2-F1)+K8*(D3-F3)+F3"},
    ),
    "a quaternion": (_quaternion(*"wxyz"), {"F1": "=2*(C2*C3+C1*C4)", "B5": "=SUMSQ(B1:B4)", "C3": "=B2/$B$5"}),
    "scalar last": (
        _quaternion(*"xyzw"),
        {"G2": "=2*(C2*C3+C4*C1)", "K3": "=SUMPRODUCT(E2:G2,TRANSPOSE($I$1:$I$3))"},
    ),
    "an axis": (_axis(), {"F1": "=B3/B4", "I7": "=F7*C1+F7*C2+G7*C3"}),
    "lookups": (
        _lookups(),
        {
            "C2": '=RADIANS(VLOOKUP("q",$F$21:$L$24,4,FALSE))',
            "D3": '=INDEX($J$21:$L$24,MATCH("r",$F$21:$F$24,0),3)',
        },
    ),
    "a conversion": (
        _conversion(),
        {"G3": "=DEGREES(ATAN2(E4,E5))", "G2": "=DEGREES(ASIN(E3))", "E4": "=COS(C3)*COS(C2)"},
    ),
    "to a quaternion": (_to_quaternion(), {"H2": "=D3*E2*D1-E3*D2*E1", "E2": "=SIN(RADIANS(B2))"}),
    "two axes": (_two_axes(), {"C11": "=-SIN(RADIANS(B2))", "M7": "=E7*D1+F7*D2+G7*D2"}),
    "degrees, minutes, seconds": (_minutes(), {"B2": "=RADIANS(B22+C22/60+D22/360)", "M7": "=I7*P1+J7*P2+K7*P2"}),
    "sums of terms": (_terms(), {"Q7": "=J7*$D$1", "R9": "=SUM(R6:R7)"}),
    "another order": (_in_another_order(), {"Q6": "=I7*D1+J6*D2+K6*D3"}),
}


@pytest.mark.parametrize("name", SHEETS)
def test_a_right_sheet_is_judged_and_right(tmp_path, name):
    report = _check(tmp_path, SHEETS[name][0])
    assert report.verdict == "right" and report.checked == report.total > 3, report


@pytest.mark.parametrize(("name", "cell"), [(name, cell) for name in SHEETS for cell in SHEETS[name][1]])
def test_a_slip_is_named(tmp_path, name, cell):
    cells, slips = SHEETS[name]
    assert slips[cell] != cells[cell]
    report = _check(tmp_path, cells | {cell: slips[cell]})
    assert report.verdict == "wrong" and report.faults[0].cell == f"Sheet!{cell}", report


def test_a_difference_from_the_expected_number_of_another_coordinate_is_named(tmp_path):
    cells = _sheet() | {f"P{n}": v for n, v in zip(ROWS, (-1.224744, 0.707107, 6.928203), strict=True)}
    cells |= {f"R{n}": f"=M{n}-P{n}" for n in ROWS}
    assert _check(tmp_path, cells).verdict == "right"
    report = _check(tmp_path, cells | {"R8": "=M8-P7"})
    assert [fault.cell for fault in report.faults] == ["Sheet!R8"], report


def test_contradicting_texts_are_said(tmp_path):
    texts = {"A20": "Euler angles Z-X'-Z'', passive", "A21": "turn the point about z, then y, then x"}
    report = _check(tmp_path, _sheet(), texts)
    assert report.verdict == "unclear" and any("ZXZ and ZYX" in line for line in report.seen), report


def test_a_lookup_without_a_key_that_is_typed_is_not_judged(tmp_path):
    report = _check(tmp_path, _lookups() | {"C2": "=RADIANS(VLOOKUP(A99,$F$21:$L$24,3,FALSE))"})
    assert report.verdict == "unclear" and report.checked < report.total, report


@pytest.mark.parametrize(
    ("text", "sequence"),
    [("R = Rz(A)·Ry(B)·Rx(C), active", "ZYX"), ("Roll (x) first, pitch (y) second, yaw (z) third: axes", "XYZ")],
)
def test_products_and_ordinals_name_a_sequence(text, sequence):
    assert reading(Task(), text)[0] == sequence


def _forty_rows_down(cell):
    return re.sub(r"([A-Z])(\d+)", lambda found: f"{found[1]}{int(found[2]) + 40}", str(cell))


def test_a_second_table_that_gives_no_number_is_listed(tmp_path):
    first = _sheet()
    second = {_forty_rows_down(p): _forty_rows_down(v) if isinstance(v, str) else v for p, v in first.items()}
    formulas = _check(tmp_path, first).total
    assert _check(tmp_path, first | second).checked == 2 * formulas
    lost = {f"M{n}": f"=I{n}*C41+J{n}*C42+K{n}*C43" for n in (46, 47, 48)} | {"C41": "x", "C42": "y", "C43": "z"}
    report = _check(tmp_path, first | second | lost)
    assert report.verdict != "right" and report.total >= 2 * formulas - 1, report  # one is 0, whatever is given


@pytest.mark.parametrize("number", [0, 3])
def test_a_choice_that_is_not_there_is_listed(tmp_path, number):
    cells = _sheet() | {f"M{n}": f"=CHOOSE(B20,M{n + 20},1)" for n in ROWS}
    cells |= {f"M{n + 20}": f"=I{n}*D1+J{n}*D2+K{n}*D3" for n in ROWS}
    assert _check(tmp_path, cells | {"B20": 1}).verdict == "right"
    assert _check(tmp_path, cells | {"B20": number}).verdict == "unclear"


def test_a_conversion_in_radians_whose_row_is_180(tmp_path):
    cells = {p: v for p, v in _conversion().items() if p[0] != "G"}
    cells |= {f"{column}180": f"=E{n}" for n, column in _from_1("KLMNO")}
    cells |= {"Q180": "=ATAN2(K180,L180)", "R180": "=ASIN(-M180)", "S180": "=ATAN2(O180,N180)"}
    assert _check(tmp_path, cells).verdict == "right"
