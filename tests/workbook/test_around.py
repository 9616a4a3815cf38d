"""Cells beside the calculation that are something known, but not what those around them or their labels say.

One table of points with everything that people put beside it; one change at a time, none of which the result needs,
or which gives the same numbers there. Every cell is judged, and the first wrong one is named.
"""

import re

import pytest

from mathpost.workbook import Task
from mathpost.workbook.meaning.texts import reading
from tests.workbook.test_strange_sheets import _check

ROWS = range(8, 13)
POINTS = ((10, 0, 5), (0, 20, 5), (-10, 3, 7), (4, -8, 12), (6, 31, -9))
C2, C3, C4, S2, S3, S4 = "C2", "C3", "C4", "D2", "D3", "D4"
MATRIX = (
    (f"{C4}*{C2}-{S4}*{C3}*{S2}", f"{C4}*{S2}+{S4}*{C3}*{C2}", f"{S4}*{S3}"),
    (f"-{S4}*{C2}-{C4}*{C3}*{S2}", f"-{S4}*{S2}+{C4}*{C3}*{C2}", f"{C4}*{S3}"),
    (f"{S3}*{S2}", f"-{S3}*{C2}", C3),
)


def _table():
    """Angles in B, cosines and sines in C and D, R in F2:H4, points in A to C, results in D to F, and the rest."""
    cells = {"A1": "Euler angles ZXZ, coordinates in the turned frame", "C1": "cos", "D1": "sin"}
    for n, (name, angle) in enumerate((("α", 35), ("β", 50), ("γ", -20)), 2):
        cells |= {f"A{n}": name, f"B{n}": angle}
        cells |= {f"{c}{n}": f"={f}(RADIANS(B{n}))" for c, f in (("C", "COS"), ("D", "SIN"))}
    cells |= {
        f"{c}{n}": f"={entry}" for n, row in enumerate(MATRIX, 2) for c, entry in zip("FGH", row, strict=True)
    }
    cells |= {
        f"{c}7": text
        for c, text in zip("ABCDEFGHI", ("x", "y", "z", "x'", "y'", "z'", "|p|", "|p'|", "off"), strict=True)
    }
    for n, point in zip(ROWS, POINTS, strict=True):
        cells |= {f"{c}{n}": v for c, v in zip("ABC", point, strict=True)}
        for c, k in (("D", 2), ("E", 3), ("F", 4)):
            cells[f"{c}{n}"] = f"=$F${k}*$A{n}+$G${k}*$B{n}+$H${k}*$C{n}"
        cells |= {f"G{n}": f"=SQRT(A{n}^2+B{n}^2+C{n}^2)", f"H{n}": f"=SQRT(D{n}^2+E{n}^2+F{n}^2)"}
        cells[f"I{n}"] = f"=H{n}-G{n}"
    cells |= {f"{c}14": f"=MAX({c}8:{c}12)" for c in "DEF"} | {"C14": "max"}
    cells |= {"K2": "α back", "K3": "β back", "K4": "γ back", "L2": "=DEGREES(ATAN2(-G4,F4))"}
    cells |= {"L3": "=DEGREES(ACOS(H4))", "L4": "=DEGREES(ATAN2(H3,H2))"}
    cells |= {"K7": "x' of the first", "L7": "=ROUND(D8,3)", "K8": "y' of the first", "L8": "=ROUND(E8,3)"}
    cells |= {f"K{n}": text for n, text in zip((10, 11, 12), ("1", "0", "0"), strict=True)}
    cells |= {"K10": 1, "L10": 0, "M10": 0, "K11": 0, "L11": "=C3", "M11": "=D3", "K12": 0, "L12": "=-D3"}
    return cells | {"M12": "=C3", "J14": "det", "K14": "=MDETERM(F2:H4)"}


SLIPS = {
    "a row looked up too far": (
        {"D10": "=$F$2*OFFSET($A$8,2,0)+$G$2*OFFSET($B$8,2,0)+$H$2*OFFSET($C$8,3,0)"},
        "D10",
        None,
    ),
    "an angle in radians of another row": (
        {"N2": "=RADIANS(B2)", "N3": "=RADIANS(B3)", "N4": "=RADIANS(B3)"},
        "N4",
        None,
    ),
    "the length of another row": ({"H10": "=SQRT(D9^2+E9^2+F9^2)"}, "H10", "wrong reference"),
    "half of a difference is lost": ({"I10": "=H10"}, "I10", None),
    "a range that is short": ({"E14": "=MAX(E8:E11)"}, "E14", "wrong reference"),
    "a number over a length": ({"H11": 15.25}, "H11", "typed over formula"),
    "a number over a cosine": ({"C2": 0.819152}, "C2", "typed over formula"),
    "a formula of numbers": ({"C2": "=COS(RADIANS(35))"}, "C2", "typed over formula"),
    "a point typed in a formula": ({"D10": "=$F$2*-10+$G$2*3+$H$2*7"}, "D10", "typed over formula"),
    "another angle computed back": ({"L4": "=DEGREES(ATAN2(-G4,F4))"}, "L4", "wrong angle"),
    "an angle in another unit": ({"L4": "=ATAN2(H3,H2)"}, "L4", "radians for degrees"),
    "a copy of another coordinate": ({"L7": "=ROUND(E8,3)"}, "L7", "wrong reference"),
    "a sign in a matrix beside it": ({"L12": "=D3"}, "L12", "sign"),
    "a mean that is a sum": ({"C15": "mean", "D15": "=SUM(D8:D12)"}, "D15", "wrong value"),
    "a coordinate twice in a length": ({"G8": "=SQRT(A8^2+B8^2+B8^2)"}, "G8", "wrong reference"),
    "a length of two": ({"K15": "|p'|", "L15": "=SQRT(D8^2+E8^2)"}, "L15", "missing term"),
    "a length without a root": ({"K15": "|p'|", "L15": "=SUMSQ(D8:F8)"}, "L15", "wrong value"),
    "a square that is missing": ({"K15": "|p'|", "L15": "=SQRT(D8^2+E8^2+F8)"}, "L15", "wrong value"),
    "a limit beyond the numbers": ({"D9": "=MIN(100,$F$2*$A9+$G$2*$B9+$H$2*$C9)"}, "D9", None),
}
RIGHT = {
    "nothing": {},
    "statistics of two groups": {"N8": "=MAX(G8:G9)", "N10": "=MAX(G10:G12)"},
    "numbers between formulas": {f"N{n}": v for n, v in enumerate((40, "=G9", 41, "=G11", 42), 8)},
    "a count that goes on": {"O8": 1} | {f"O{n}": f"=O{n - 1}+1" for n in range(9, 13)},
    "a distance to the row above": {
        f"N{n}": f"=SQRT((D{n}-D{n - 1})^2+(E{n}-E{n - 1})^2+(F{n}-F{n - 1})^2)" for n in range(9, 13)
    },
    "largest deviations": {"I14": "=MAX(I8:I12,-MIN(I8:I12))", "F15": "mean", "G15": "=AVERAGE(G8:G12)"},
    "a mean of some points, and said so": {"C15": "mean of the first three"}
    | {f"{c}15": f"=AVERAGE({c}8:{c}10)" for c in "DEF"},
    "axes of another name": {"N7": "X2 (= y')", "N8": "=E8"},
    "a root of nine squares": {"N2": "=SQRT(SUMSQ(F2:H4))"},
    "a mirrored point": {"N7": "mirrored", "N8": "=-A8", "O8": "=B8", "P8": "=C8"},
    "marks and their sum": {"N2": "=IF(ABS(D8-4)<0.1,2,0)", "N3": "=IF(H4>0.5,1,0)", "N4": "=SUM(N2:N3)/3*100"},
    "angles in other units": {f"N{n}": f"=RADIANS(B{n})" for n in (2, 3, 4)}
    | {f"O{n}": f"=B{n}/0.9" for n in (2, 3, 4)},
    "angles between the axes": {
        f"{d}{n}": f"=DEGREES(ACOS({c}{n}))" for c, d in zip("FGH", "NOP", strict=True) for n in (2, 3, 4)
    },
    "the directions of a result": {f"{d}15": f"=DEGREES(ACOS({c}8/H8))" for c, d in zip("DEF", "NOP", strict=True)},
    "a median, a variance, inches": {"N2": "=MEDIAN(D8:D12)", "N3": "=VAR(E8:E12)", "N4": "=F8/25.4"},
    "the middle between point and result": {"N8": "=(A8+D8)/2", "O8": "=(B8+E8)/2", "P8": "=(C8+F8)/2"},
    "a point that is looked up": {"D10": "=$F$2*OFFSET($A$8,2,0)+$G$2*OFFSET($B$8,2,0)+$H$2*OFFSET($C$8,2,0)"},
    "the angle to the point": {"N2": "=DEGREES(ACOS(SUMPRODUCT(A8:C8,D8:F8)/(G8*H8)))"},
}


@pytest.mark.parametrize("name", SLIPS)
def test_a_slip_beside_the_result(name, tmp_path):
    change, first, cause = SLIPS[name]
    report = _check(tmp_path, _table() | change)
    assert (report.verdict, report.faults[0].cell) == ("wrong", f"Sheet!{first}"), report
    assert cause in (None, report.faults[0].cause), report
    assert report.checked == report.total


@pytest.mark.parametrize("name", RIGHT)
def test_what_only_looks_like_a_slip(name, tmp_path):
    report = _check(tmp_path, _table() | RIGHT[name])
    assert report.verdict == "right", str(report)


UNCLEAR = {
    "no length under the name of one": ({"K15": "|p'|", "L15": "=A8"}, "Sheet!L15"),
    "a calculation of other numbers": ({f"N{n}": 7 * n for n in (2, 3, 4)} | {"N5": "=N2*N3-N4"}, "Sheet!N5"),
    "angles between axes": (
        {f"P{n}": f"=DEGREES(ACOS({c}{n}))" for n, c in zip((2, 3, 4), "FGH", strict=True)},
        "Sheet!P2:P3",
    ),
    "a difference that is none": ({"N7": "dx", "N8": "=D8"}, "Sheet!N8"),
    "a difference from itself": ({"N8": "=D8-D8"}, "Sheet!N8"),
    "another mean than its name": ({"K15": "RMS", "L15": "=AVERAGE(G8:G12)"}, "Sheet!L15"),
    "a number with the name of a length": ({"K15": "|p'|", "L15": 17.35}, "Sheet!L15"),
    "a mirrored point without a word": ({"N8": "=-A8", "N9": "=B8", "N10": "=C8"}, "Sheet!N8:N10"),
    "copies in another order": ({"N8": "=G2", "N9": "=G4", "N10": "=G3"}, "Sheet!N8:N10"),
    "a sum of empty cells": ({"N8": "=SUM(P8:P12)"}, "Sheet!N8"),
    "a length, or a text": ({"L15": '=IF(A8="","",SQRT(A8^2+B8^2+7))'}, "Sheet!L15"),
}


@pytest.mark.parametrize("name", UNCLEAR)
def test_what_is_not_judged_is_listed(name, tmp_path):
    change, listed = UNCLEAR[name]
    report = _check(tmp_path, _table() | change)
    assert (report.verdict, report.not_checked) == ("unclear", [listed]), str(report)


def test_a_point_turned_back_in_each_row(tmp_path):
    back = {
        f"{c}{n}": f"=$F${2}*D{n}+$F${3}*E{n}+$F${4}*F{n}".replace("F$", f"{m}$")
        for n in ROWS
        for c, m in zip("NOP", "FGH", strict=True)
    }
    assert _check(tmp_path, _table() | back).verdict == "right"
    first = {address: re.sub(r"(?<=[DEF])\d+$|(?<=\*[DEF])\d+", "8", formula) for address, formula in back.items()}
    report = _check(tmp_path, _table() | first)
    assert (report.verdict, report.not_checked[0]) == ("unclear", "Sheet!N9:N12"), str(report)


EMPTY_ROWS = ('A{n}=""', "ISBLANK(A{n})", "COUNT(A{n}:C{n})<3", "NOT(ISNUMBER(A{n}))", 'OR(A{n}="",C{n}="")')


@pytest.mark.parametrize("test", EMPTY_ROWS)
@pytest.mark.parametrize("slip", [False, True])
def test_rows_that_wait_for_points(tmp_path, test, slip):
    cells = {a: v for a, v in _table().items() if not re.fullmatch(r"[GHI]([7-9]|1\d)|[DEF]14", a)}
    for n in range(8, 17):
        for c, k in (("D", 2), ("E", 3), ("F", 4)):
            term = f"$F${k}*$A{n}+$G${k}*$B{n}{'-' if slip and (c, n) == ('E', 11) else '+'}$H${k}*$C{n}"
            cells[f"{c}{n}"] = f'=IF({test.format(n=n)},"",{term})'
    report = _check(tmp_path, cells)
    assert report.verdict == ("wrong" if slip else "right"), str(report)
    assert [fault.cell for fault in report.faults] == ["Sheet!E11"] * slip


@pytest.mark.parametrize(
    ("text", "active"),
    [
        ("aktive Drehung", True),
        ("Rz(α) Rx(β) Rz(γ), active", True),
        ("Active user: Jones", False),
        ("Makros aktivieren, dann drehen", False),
        ("this is not an active rotation", False),
        ("for comparison: the active rotation is the transposed matrix", False),
        ("本题不是主动旋转", False),
        ("主动轴转速", False),
    ],
)
def test_words_that_do_not_say_active(text, active):
    assert reading(Task(), text)[1] == active


def test_an_angle_that_is_not_used_beside_a_number_that_is(tmp_path):
    cells = {"A1": "Rotation of a point about an axis (Rodrigues), active", "A5": "angle", "B5": 50, "C5": 1.2}
    cells |= {"A2": "axis", "B2": 0.6, "C2": 0, "D2": 0.8, "A9": "p", "B9": 4, "C9": -3, "D9": 8}
    cells |= {"A6": "cos", "B6": "=COS(C5)", "A7": "sin", "B7": "=SIN(C5)", "A8": "k·p"}
    cells |= {"B8": "=B2*B9+C2*C9+D2*D9", "A11": "p'"}
    for c, d, e in ("BCD", "CDB", "DBC"):
        cells[f"{c}11"] = f"={c}9*B6+({d}2*{e}9-{e}2*{d}9)*B7+{c}2*B8*(1-B6)"
    report = _check(tmp_path, cells)
    assert report.verdict == "unclear" and "B5, 50, is not used; C5, 1.2, turns" in str(report), str(report)


@pytest.mark.parametrize(
    ("texts", "expected"),
    [
        (["绕固定轴x转A，再绕固定轴y转B，最后绕固定轴z转C", "主动旋转 R = Rz(C)·Ry(B)·Rx(A)"], ("xyz", True)),
        (["axes fixes X, Y, Z, rotation active", "R = Rz(lacet) · Ry(tangage) · Rx(roulis)"], ("xyz", True)),
        (["Euler X-Y'-Z'', active rotation", "R = Rz(c) · Ry(b) · Rx(a)"], ("XYZ", True)),
    ],
)
def test_products_about_fixed_axes(texts, expected):
    assert reading(Task(), "\n".join(texts))[:2] == expected
