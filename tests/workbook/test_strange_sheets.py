"""Rotation sheets as different people lay them out: what is beside the result, how it is listed, what is derived.

Nothing here is computed by the package: a sheet is right because its formulas are those of source 000.
"""

import re

import openpyxl
import pytest

from mathpost.teaching.workbook import Task, check_file
from mathpost.teaching.workbook.meaning.texts import reading

ELEMENTS = {  # of the passive elementary matrices, as formulas of cosine and sine
    "Z": ("={c}", "={s}", 0, "=-{s}", "={c}", 0, 0, 0, 1),
    "X": (1, 0, 0, 0, "={c}", "={s}", 0, "=-{s}", "={c}"),
}
ANGLES = ("COS(RADIANS({}))", "SIN(RADIANS({}))")
WHOLE = (  # of the whole passive matrix, each coordinate at once, of C1:C3 in radians and the point D1:D3
    "(COS(C3)*COS(C1)-SIN(C3)*COS(C2)*SIN(C1))*D1+(COS(C3)*SIN(C1)+SIN(C3)*COS(C2)*COS(C1))*D2+SIN(C3)*SIN(C2)*D3",
    "(-SIN(C3)*COS(C1)-COS(C3)*COS(C2)*SIN(C1))*D1+(COS(C3)*COS(C2)*COS(C1)-SIN(C3)*SIN(C1))*D2+COS(C3)*SIN(C2)*D3",
    "SIN(C2)*SIN(C1)*D1-SIN(C2)*COS(C1)*D2+COS(C2)*D3",
)


def _places(corner, rows=3, columns=3):
    left, top = ord(corner[0]), int(corner[1:])
    return [f"{chr(left + k)}{top + n}" for n in range(rows) for k in range(columns)]


def _matrix(corner, axis, angle, turn=ANGLES):
    c, s = (part.format(angle) for part in turn)
    entries = [each.format(c=c, s=s) if isinstance(each, str) else each for each in ELEMENTS[axis]]
    return dict(zip(_places(corner), entries, strict=True))


def _product(corner, left, right, columns=3):
    a, b = _places(left), _places(right, 3, columns)
    entries = [
        "=" + "+".join(f"{a[3 * row + k]}*{b[columns * k + column]}" for k in range(3))
        for row in range(3)
        for column in range(columns)
    ]
    return dict(zip(_places(corner, 3, columns), entries, strict=True))


def _sheet(turn=ANGLES, angles=(135, 54.7356, -90), point=(3, 4, 5)):
    """Angles in B1:B3, the point in D1:D3, elementary matrices from A6, products from E6, the result in M6:M8."""
    cells = dict(zip(("B1", "B2", "B3", "D1", "D2", "D3"), (*angles, *point), strict=True))
    for corner, axis, angle in (("A6", "Z", "B1"), ("A10", "X", "B2"), ("A14", "Z", "B3")):
        cells |= _matrix(corner, axis, angle, turn)
    return cells | _product("E6", "A10", "A6") | _product("I6", "A14", "E6") | _product("M6", "I6", "D1", 1)


BESIDE = {
    "a length": ({"M10": "=SQRT(M6^2+M7^2+M8^2)", "M11": "=SQRT(D1^2+D2^2+D3^2)"}, "right"),
    "what is shown": ({f"O{n}": f"=ROUND(M{n},3)" for n in (6, 7, 8)}, "right"),
    "a judgement": ({"O6": -1.2247, "P6": '=IF(ABS(M6-O6)<0.001,"OK","wrong")'}, "right"),
    "the transposed times itself": (
        {f"Q{6 + n}": f"=I{6 + n}*I6+J{6 + n}*J6+K{6 + n}*K6" for n in range(3)},
        "right",
    ),
    "turned back": ({f"O{6 + n}": f"={c}6*M6+{c}7*M7+{c}8*M8" for n, c in enumerate("IJK")}, "right"),
    "angles computed back": ({"B20": "=DEGREES(ATAN2(-J8,I8))", "B21": "=DEGREES(ACOS(K8))"}, "right"),
    "something else": ({"S20": 3, "S21": 4, "S22": 5, "S23": "=AVERAGE(S20:S22)"}, "right"),
    "a vector that only follows": ({f"O{n}": f"=M{n}/3+1" for n in (6, 7, 8)}, "not judged"),
    "its distance from the point": ({"O6": "=SQRT((M6-D1)^2+(M7-D2)^2+(M8-D3)^2)"}, "right"),
    "its difference from the point": ({f"O{n + 5}": f"=M{n + 5}-D{n}" for n in (1, 2, 3)}, "right"),
    "the largest difference of two ways": ({"O6": "=MAX(ABS(M6-I6*D1-J6*D2-K6*D3),ABS(M7-M7))"}, "right"),
    "its difference from numbers in a table": (
        {
            f"{c}{n}": v
            for n, v in ((6, 3.1), (7, 4.2), (8, 5.3))
            for c, v in (("O", n), ("P", v), ("Q", f"=M{n}-P{n}"))
        },
        "not judged",
    ),
    "the largest of the differences": (
        {f"O{n}": n / 7 for n in (6, 7, 8)}
        | {f"P{n}": f"=M{n}-O{n}" for n in (6, 7, 8)}
        | {"P10": "=MAX(MAX(P6:P8),-MIN(P6:P8))"},
        "not judged",
    ),
    "the angle of the whole turn": ({"O6": "=DEGREES(ACOS((I6+J7+K8-1)/2))"}, "right"),
    "turned back, one cell wrong": (
        {f"O{6 + n}": f"={c}6*M6+{c}7*M7+{'K' if n else c}8*M8" for n, c in enumerate("IJK")},
        "not judged",
    ),
    "a text of the result": ({"O6": '="x = "&TEXT(M6,"0.000")'}, "right"),
}


def _check(tmp_path, cells, texts=None, **task):
    book = openpyxl.Workbook()
    for address, content in (cells | (texts or {})).items():
        book.active[address] = content
    book.save(tmp_path / "one.xlsx")
    return check_file(tmp_path / "one.xlsx", Task(**task) if task else None)


@pytest.mark.parametrize("name", BESIDE)
def test_what_stands_beside_a_right_result_raises_no_alarm(tmp_path, name):
    beside, verdict = BESIDE[name]
    report = _check(tmp_path, _sheet() | beside)
    assert report.verdict == verdict, report
    assert not report.faults


@pytest.mark.parametrize("name", BESIDE)
@pytest.mark.parametrize(
    ("cell", "formula", "cause"),
    [("B11", "=-COS(RADIANS(B2))", "sign"), ("M7", "=I7*D1+J7*D2+K7*D2", "wrong point")],
)
def test_it_hides_no_slip(tmp_path, name, cell, formula, cause):
    report = _check(tmp_path, _sheet() | BESIDE[name][0] | {cell: formula})
    if name == "a vector that only follows":  # it is the result then, and which step is wrong is not looked for
        assert report.verdict != "right"
        return
    assert (report.verdict, report.faults[0].cell, report.faults[0].cause) == ("wrong", f"Sheet!{cell}", cause), (
        report
    )


@pytest.mark.parametrize("form", ["=ROUND({},0)", "=ROUND({},1)", "=INT({})", "=TRUNC({},1)"])
def test_a_result_that_is_cut_to_few_digits_is_wrong(tmp_path, form):
    cells = _sheet()
    report = _check(tmp_path, cells | {"M6": form.format(cells["M6"][1:])})
    assert (report.verdict, report.faults[0].cell, report.faults[0].cause) == ("wrong", "Sheet!M6", "rounded early")


@pytest.mark.parametrize(
    ("turn", "angles"),
    [
        (("COS({}*PI()/200)", "SIN({}*PI()/200)"), (150, 60.8173, -100)),  # gon
        (("COS({}*0.0174532925)", "SIN({}*0.0174532925)"), (135, 54.7356, -90)),
        (("COS({})", "SIN({})"), (2.3562, 0.9553, -1.5708)),
    ],
)
def test_units(tmp_path, turn, angles):
    assert _check(tmp_path, _sheet(turn, angles)).verdict == "right"


def test_degrees_minutes_and_seconds(tmp_path):
    cells = _sheet()
    for n, numbers in enumerate(((35, 15, 50), (62, 40, 12), (118, 5, 27)), 1):
        cells |= dict(zip((f"F{n}", f"G{n}", f"H{n}"), numbers, strict=True)) | {
            f"B{n}": f"=F{n}+G{n}/60+H{n}/3600"
        }
    assert _check(tmp_path, cells).verdict == "right"
    report = _check(tmp_path, cells | {"B2": "=F2+G2/60+H2/60"})
    assert (report.verdict, report.faults[0].cell) == ("wrong", "Sheet!B2"), report


def test_an_angle_that_is_computed_is_no_fault_and_not_passed(tmp_path):
    report = _check(tmp_path, _sheet() | {"F2": 125.2644, "B2": "=180-F2"})
    assert (report.verdict, report.faults, report.not_checked) == ("not judged", [], ["Sheet!B2"])


def test_two_cases_side_by_side_of_which_one_takes_an_angle_of_the_other(tmp_path):
    right = _sheet()
    below = _sheet(angles=(120, 50, -80))
    cells = right | {_down(address): _down(content) for address, content in below.items()}
    assert _check(tmp_path, cells).verdict == "right"
    # The second block is a copy in which one elementary matrix still takes the angle of the first.
    spoilt = {place: cells[place].replace("B32", "B2") for place in ("B41", "C41", "B42", "C42")}
    report = _check(tmp_path, cells | spoilt)
    assert (report.faults[0].cell, report.faults[0].cause) == ("Sheet!B41", "wrong reference"), report


def test_a_copied_block_that_takes_all_angles_of_the_first_is_warned_of(tmp_path):
    labels = {f"A{row}": name for n in (0, 30) for row, name in enumerate(("α", "β", "γ"), 1 + n)}
    cells = _sheet() | {_down(a): _down(c) for a, c in _sheet(angles=(120, 50, -80)).items()}
    spoilt = {
        a: re.sub(r"B3([123])", r"B\1", c) for a, c in cells.items() if isinstance(c, str) and int(a[1:]) > 30
    }
    assert _check(tmp_path, cells, labels).warnings == []
    assert "B31 is angle α, 120, that no formula uses" in str(_check(tmp_path, cells | spoilt, labels))


def _down(text):
    """An address, or a formula, thirty rows further down."""
    if not isinstance(text, str):
        return text
    return re.sub(r"(?<![A-Z])([A-S])(\d+)", lambda found: f"{found[1]}{int(found[2]) + 30}", text)


def test_matrices_listed_element_by_element(tmp_path):
    cells = {"B1": 135, "B2": 54.7356, "B3": -90, "H12": 3, "H13": 4, "H14": 5}
    for column, (axis, angle) in zip("BCD", (("Z", "$B$1"), ("X", "$B$2"), ("Z", "$B$3")), strict=True):
        cells |= {f"{column}{12 + n}": e for n, e in enumerate(_matrix("A1", axis, angle).values())}
    for column, left, right in (("E", "C", "B"), ("F", "D", "E")):
        for row in range(9):
            i, j = divmod(row, 3)
            terms = (f"{left}{12 + 3 * i + k}*{right}{12 + 3 * k + j}" for k in range(3))
            cells[f"{column}{12 + row}"] = "=" + "+".join(terms)
    for i in range(3):
        cells[f"J{12 + i}"] = "=" + "+".join(f"F{12 + 3 * i + k}*H{12 + k}" for k in range(3))
    assert _check(tmp_path, cells).verdict == "right"
    report = _check(tmp_path, cells | {"F16": cells["F16"].replace("E13", "E14")})
    assert report.faults[0].cell == "Sheet!F16", report


def test_results_between_other_columns(tmp_path):
    cells = {address: content for address, content in _sheet().items() if address[0] not in "DM"}
    for row in range(20, 25):
        cells |= {f"A{row}": row - 19, f"B{row}": 1.5 * row, f"C{row}": 40 - row, f"D{row}": (row - 22) ** 2}
        for n, column in enumerate("FIL"):
            cells[f"{column}{row}"] = f"=$I${6 + n}*B{row}+$J${6 + n}*C{row}+$K${6 + n}*D{row}"
            cells[chr(ord(column) + 1) + str(row)] = 100 * row
    assert _check(tmp_path, cells).verdict == "right"
    spoilt = {f"I{row}": cells[f"I{row}"].replace("$J$7", "$J$8") for row in range(20, 25)}
    report = _check(tmp_path, cells | spoilt)
    assert (report.verdict, report.faults[0].cell) == ("wrong", "Sheet!I20"), report


def test_the_one_below_a_point_beside_its_result(tmp_path):
    """Homogeneous coordinates: (x, y, z, 1) next to the formulas of p', and the matrix with the origin in it."""
    cells = {a: c for a, c in _sheet().items() if a[0] not in "DM"} | {"B20": 10, "B21": -2, "B22": 1.5}
    for n, row in enumerate((6, 7, 8)):
        cells |= {f"L{row}": f"=-(I{row}*B20+J{row}*B21+K{row}*B22)", f"O{row}": (3, 4, 5)[n]}
        cells[f"P{row}"] = f"=I{row}*O6+J{row}*O7+K{row}*O8+L{row}*O9"
    cells |= {"I9": 0, "J9": 0, "K9": 0, "L9": 1, "O9": 1, "P9": "=I9*O6+J9*O7+K9*O8+L9*O9"}
    assert _check(tmp_path, cells).verdict == "right"
    report = _check(tmp_path, cells | {"L7": "=-(I7*B20+J7*B22+K7*B22)"})
    assert (report.verdict, report.faults[0].cell) == ("wrong", "Sheet!L7"), report


def test_what_no_single_change_explains_is_not_judged(tmp_path):
    spoilt = {"A6": "=SIN(RADIANS(B2))", "B11": "=COS(RADIANS(B3))", "J7": "=A15*F6", "I8": "=1/E6"}
    report = _check(tmp_path, _sheet() | spoilt)
    assert (report.verdict, report.faults) == ("not judged", []) and "no single change" in str(report)


def test_labels_of_matrices_make_no_silent_pass_of_formulas(tmp_path):
    """Labels say three matrices; the formulas that use them are none of the task's, and are listed."""
    cells = _matrix("A6", "Z", "B1") | {"B1": 35, "E6": "=SUM(A6:C6)*7", "E7": "=A7*A6"}
    report = _check(tmp_path, cells, {"A1": "α", "A5": "matrix alpha"})
    assert report.verdict == "not judged" and {"Sheet!E6:E7"} <= set(report.not_checked), report


@pytest.mark.parametrize(
    ("text", "verdict"),
    [
        ("Intrinsic z-x'-z'' Euler angles, passive rotation (not the active one)", "right"),
        ("3-1-3 sequence, passive", "right"),
        ("rotation sequence 3-2-1, passive", "not judged"),
        ("Euler angles ZYX", "not judged"),
    ],
)
def test_texts_that_name_a_sequence(tmp_path, text, verdict):
    assert _check(tmp_path, _sheet(), {"A20": text}).verdict == verdict


def test_another_sequence_than_the_tasks_is_named(tmp_path):
    report = _check(tmp_path, _sheet(), sequence="ZYX", convention="passive")
    assert (report.verdict, report.faults[0].cause) == ("wrong", "other convention") and "ZXZ" in str(
        report.faults[0]
    )


def _points(rows=((3, 4, 5), (-7, 2, 11), (0, 6, -10), (8, 1, 1))):
    """The matrix R in I6:K8, points in rows from S6, what becomes of them from V6."""
    cells = {place: formula for place, formula in _sheet().items() if place[0] != "M"}
    for n, point in enumerate(rows, 6):
        cells |= dict(zip((f"S{n}", f"T{n}", f"U{n}"), point, strict=True))
        cells |= {
            f"{c}{n}": f"=$I${r}*$S{n}+$J${r}*$T{n}+$K${r}*$U{n}" for r, c in zip((6, 7, 8), "VWX", strict=True)
        }
    return cells


@pytest.mark.parametrize("function", ["AVERAGE", "SUM", "MAX"])
def test_means_of_points_are_listed(tmp_path, function):
    """Whether a mean should take a row is no question of rotations."""
    for last in (9, 8):
        report = _check(tmp_path, _points() | {"W11": f"={function}(W6:W{last})"})
        assert (report.verdict, report.not_checked, report.beside) == ("not judged", ["Sheet!W11"], True), report


@pytest.mark.parametrize(
    ("formula", "verdict"),
    [
        ("={a}*(D1-F1)+{b}*(D2-F2)+{c}*(D3-F3)", "right"),
        ("={a}*D1+{b}*D2+{c}*D3-{o}", "not judged"),  # after the turn, not before: no single cell is wrong
        ("={a}*(D1+F1)+{b}*(D2+F2)+{c}*(D3+F3)", "not judged"),
    ],
)
def test_an_origin_at_the_wrong_place(tmp_path, formula, verdict):
    cells = _sheet() | {"F1": 11, "F2": -6, "F3": 4}
    for n, origin in zip((6, 7, 8), ("F1", "F2", "F3"), strict=True):
        cells[f"M{n}"] = formula.format(a=f"I{n}", b=f"J{n}", c=f"K{n}", o=origin)
    report = _check(tmp_path, cells, origin=(11, -6, 4))
    assert report.verdict == verdict, report


def test_the_inverse_of_a_transformation_with_an_origin(tmp_path):
    cells = _sheet() | {
        "F1": 11,
        "F2": -6,
        "F3": 4,
        "A20": "inverse transformation: from the workpiece to the machine",
    }
    for n, column in zip((6, 7, 8), "IJK", strict=True):
        cells[f"M{n}"] = f"={column}6*D1+{column}7*D2+{column}8*D3+F{n - 5}"
    report = _check(tmp_path, cells)
    assert report.verdict == "right", report
    assert [f.cell for f in _check(tmp_path, cells | {"M7": cells["M7"].replace("F2", "F3")}).faults] == [
        "Sheet!M7"
    ]


def test_one_conversion_in_gon(tmp_path):
    cells = _sheet(("COS({}/200*PI())", "SIN({}/200*PI())"), (150, 60, -100))
    assert _check(tmp_path, cells).verdict == "right"
    report = _check(tmp_path, cells | {"C11": "=SIN(B2/180*PI())"})
    assert [(f.cell, f.message) for f in report.faults] == [("Sheet!C11", "C11: 180 should be 200")], report


def test_turned_back_by_a_matrix_that_is_not_transposed(tmp_path):
    back = {f"O{6 + n}": f"=I{6 + n}*M6+J{6 + n}*M7+K{6 + n}*M8" for n in range(3)}
    report = _check(tmp_path, _sheet() | back)
    assert report.verdict == "not judged" and report.not_checked == ["Sheet!O6:O8"], report


def test_angles_here_and_there_are_in_the_order_in_which_they_turn(tmp_path):
    cells = _sheet() | {"B1": "=S9", "B2": "=S2", "B3": "=T5"}
    assert _check(tmp_path, cells | {"S9": 135, "S2": 54.7356, "T5": -90}).verdict == "right"


def test_an_angle_that_is_a_share_of_a_turn_is_computed(tmp_path):
    """It is listed, and what turns by it is judged."""
    shared = _sheet() | {"F1": 7, "G1": 2, "B1": "=360/F1*G1"}
    report = _check(tmp_path, shared)
    assert (report.verdict, report.not_checked) == ("not judged", ["Sheet!B1"]), report
    assert _check(tmp_path, shared | {"F7": "=A11*B6+B11*A7+C11*B8"}).verdict == "wrong"


def test_a_point_that_is_computed_is_listed(tmp_path):
    cells = _sheet() | {"F1": 5, "D1": "=F1*COS(RADIANS(30))", "D2": "=F1*SIN(RADIANS(30))"}
    report = _check(tmp_path, cells)
    assert (report.verdict, report.not_checked) == ("not judged", ["Sheet!D1:D2"]), report


def test_rounded_copies_and_numbers_of_points_beside_the_results(tmp_path):
    shown = {f"O{n}": f"=ROUND(M{n},1)" for n in (6, 7, 8)}
    cells = _sheet() | shown | {"E1": 1, "E2": 2, "T1": "=E1", "T2": "=E2"}
    assert _check(tmp_path, cells).verdict == "right"
    report = _check(tmp_path, cells | {"E1": 7.5, "E2": 9.5})
    assert (report.verdict, report.not_checked) == ("not judged", ["Sheet!T1:T2"]), report


def test_rows_of_a_matrix_by_index(tmp_path):
    cells = _sheet() | {f"M{5 + n}": f"=SUMPRODUCT(INDEX(I6:K8,{n},0),F20:H20)" for n in (1, 2, 3)}
    cells |= {"F20": "=D1", "G20": "=D2", "H20": "=D3"}
    assert _check(tmp_path, cells).verdict == "right"


def test_points_of_zeros_and_ones_and_vectors_along_the_axes_are_given(tmp_path):
    sheet = _sheet()
    del sheet["M6"], sheet["M7"], sheet["M8"]
    columns = {f"{c}{10 + n}": 0.3 * (n == k) for k, c in enumerate("MNO") for n in range(3)}
    cells = sheet | columns | _product("M14", "I6", "M10")
    assert _check(tmp_path, cells).verdict == "right"
    corners = {f"{c}{10 + n}": (1, -1)[n >> k & 1] for k, c in enumerate("MNO") for n in range(4)}
    turned = {
        f"{c}{10 + n}": f"=SUMPRODUCT($I${r}:$K${r},$M{10 + n}:$O{10 + n})"
        for c, r in zip("PQR", (6, 7, 8), strict=True)
        for n in range(4)
    }
    assert _check(tmp_path, sheet | corners | turned).verdict == "right"
    report = _check(tmp_path, sheet | corners | turned | {"B7": "=SIN(RADIANS(B1))"})
    assert (report.verdict, report.faults[0].cell) == ("wrong", "Sheet!B7"), report


def test_seconds_by_60_in_every_angle(tmp_path):
    cells = _sheet()
    for n, numbers in enumerate(((35, 15, 50), (62, 40, 12), (118, 5, 27)), 1):
        cells |= dict(zip((f"F{n}", f"G{n}", f"H{n}"), numbers, strict=True)) | {f"B{n}": f"=F{n}+G{n}/60+H{n}/60"}
    report = _check(tmp_path, cells)
    assert [fault.cell for fault in report.faults] == ["Sheet!B1", "Sheet!B2", "Sheet!B3"], report


@pytest.mark.parametrize(("rows", "verdict"), [((6,), "right"), ((6, 7, 8), "not judged")])
def test_copies_of_one_coordinate_in_a_line_are_no_vector(rows, verdict, tmp_path):
    shown = {f"Y{n}": f"=ROUND(W{n},2)" for n in rows}
    assert _check(tmp_path, _points() | shown).verdict == verdict


def test_a_row_that_takes_the_point_of_the_next_one(tmp_path):
    """Its own result is then right for another point, and no number differs from one that is right."""
    points = ((1, 2, 3), (2, 3, 1), (-5, 4, 2.5), (3, -6, 7), (8, 9, -8))
    cells = _points(points)
    assert _check(tmp_path, cells).verdict == "right"
    cells |= {f"{c}8": re.sub(r"(?<=[STU])8", "9", cells[f"{c}8"]) for c in "VWX"}
    report = _check(tmp_path, cells)
    assert (report.faults[0].cell, report.verdict) == ("Sheet!V8", "wrong"), report


def test_an_angle_computed_back_with_its_arguments_exchanged(tmp_path):
    cells = _sheet() | {"B20": "=DEGREES(ATAN2(I8,-J8))", "B21": "=B20-B1"}
    report = _check(tmp_path, cells)
    assert (report.verdict, report.not_checked) == ("not judged", ["Sheet!B20:B21"]), report
    assert _check(tmp_path, cells | {"B20": "=DEGREES(ATAN2(-J8,I8))"}).verdict == "right"


def test_a_typed_element_that_fits_one_of_three_points_is_not_blamed_for_another(tmp_path):
    """Each number in a row of a matrix can make one point right; only the one that is wrong makes all right."""
    cells = _points(((1, 2, 3), (2, 3, 1), (-5, 4, 2.5))) | {"C11": 0.8}
    report = _check(tmp_path, cells)
    assert [fault.cell for fault in report.faults] == ["Sheet!C11"], report


def test_copies_of_a_result_in_another_order(tmp_path):
    summary = {"O6": "=M6", "O7": "=M7", "O8": "=M8"}
    assert _check(tmp_path, _sheet() | summary).verdict == "right"
    report = _check(tmp_path, _sheet() | summary | {"O6": "=M7", "O7": "=M6"})
    assert report.verdict == "not judged" and report.not_checked == ["Sheet!O6:O8"], report


@pytest.mark.parametrize("inverse", ["=DEGREES(ATAN(I8/-J8))", "=DEGREES(ATAN2(J8,-I8))"])
def test_an_angle_computed_back_in_the_wrong_half_turn(tmp_path, inverse):
    back = {"B20": "=DEGREES(ATAN2(-J8,I8))", "B21": "=DEGREES(ATAN2(K8,SQRT(I8^2+J8^2)))"}
    assert _check(tmp_path, _sheet() | back).verdict == "right"
    report = _check(tmp_path, _sheet() | back | {"B20": inverse})
    assert [*(fault.cell for fault in report.faults), *report.not_checked] == ["Sheet!B20"], report


@pytest.mark.parametrize("factor", ["=180/PI()", 57.29577951308232])
def test_a_factor_between_units_that_is_upside_down(tmp_path, factor):
    cells = _sheet(turn=("COS({}*$F$1)", "SIN({}*$F$1)"), angles=(35, 20, 50))
    assert _check(tmp_path, cells | {"F1": "=PI()/180"}).verdict == "right"
    report = _check(tmp_path, cells | {"F1": factor})
    assert [fault.cell for fault in report.faults] == ["Sheet!F1"], report


def test_an_angle_of_180_degrees_in_many_formulas_is_no_factor(tmp_path):
    cells = {"B1": 180, "B2": 25, "B3": 0, "P1": 250, "P2": 0, "P3": -412.75}
    cells |= {f"D{n}": number for n, number in enumerate((200.1, -30, -380.2), 1)}
    turned = WHOLE
    for n in (1, 2, 3):
        turned = [re.sub(rf"\bC{n}\b", f"RADIANS(B{n})", row) for row in turned]
    moved = [re.sub(r"\bD(\d)", r"(D\1-P\1)", row) for row in turned]
    cells |= {f"M{6 + n}": f"={row}" for n, row in enumerate(moved)}
    assert _check(tmp_path, cells).verdict == "right"
    report = _check(tmp_path, cells | {"M8": cells["M8"].replace("D3-P3", "D3+P3")})
    assert [(fault.cell, fault.cause) for fault in report.faults] == [("Sheet!M8", "sign")], report


def test_a_range_that_begins_at_a_heading(tmp_path):
    cells = {place: value for place, value in _sheet().items() if not place.startswith("M")}
    cells |= {f"S{n + 5}": cells[f"D{n}"] for n in (1, 2, 3)} | {"S5": "P"}
    rows = {f"M{n}": f"=SUMPRODUCT(I{n}:K{n},TRANSPOSE(S6:S8))" for n in (6, 7, 8)}
    assert _check(tmp_path, cells | rows).verdict == "right"
    report = _check(tmp_path, cells | {p: f.replace("S6:S8", "S5:S7") for p, f in rows.items()})
    assert (report.verdict, report.faults[0].cell) == ("wrong", "Sheet!M6"), report


def test_roll_pitch_and_yaw_are_about_x_y_and_z_in_whatever_order_they_stand(tmp_path):
    names = ("roll", "pitch", "yaw")
    matrix = (  # of the new axes, from yaw, pitch and roll about turned axes
        *("=cq*cw", "=cq*sw", "=-sq"),
        *("=sp*sq*cw-cp*sw", "=sp*sq*sw+cp*cw", "=sp*cq"),
        *("=cp*sq*cw+sp*sw", "=cp*sq*sw-sp*cw", "=cp*cq"),
    )
    for n, order in enumerate(([0, 1, 2], [2, 1, 0])):
        rows = {k: 1 + order.index(k) for k in range(3)}
        cells = {f"B{rows[k]}": angle for k, angle in enumerate((12, -7, 140))} | {"D1": 3, "D2": 4, "D3": 5}
        texts = {f"A{rows[k]}": name for k, name in enumerate(names)} | {
            "F1": "yaw about z, pitch about y, roll about x"
        }
        for place, entry in zip(_places("A6"), matrix, strict=True):
            for k, letter in enumerate("pqw"):
                entry = entry.replace(f"c{letter}", f"COS(RADIANS(B{rows[k]}))")
                entry = entry.replace(f"s{letter}", f"SIN(RADIANS(B{rows[k]}))")
            cells[place] = entry
        cells |= _product("M6", "A6", "D1", 1)
        report = _check(tmp_path, cells, texts)
        assert report.verdict == "right", (n, report)


def test_first_and_then_name_a_sequence_about_fixed_axes():
    text = "Rotate a point about the FIXED axes: first X, then Y, then Z"
    assert reading(Task(), text)[:3] == ("xyz", False, "the text")
    assert reading(Task(), "Drehung: erst Z um a, dann X um b, dann Z um c")[0] == "ZXZ"


def test_one_angle_in_degrees_among_gon_where_every_element_has_all_three(tmp_path):
    cells = {"B1": 142.5, "B2": 60.25, "B3": -33} | {f"C{n}": f"=B{n}*PI()/200" for n in (1, 2, 3)}
    cells |= {"D1": 3, "D2": 4, "D3": 5}
    cells |= {f"M{6 + n}": f"={row}" for n, row in enumerate(WHOLE)}
    assert _check(tmp_path, cells).verdict == "right"
    report = _check(tmp_path, cells | {"C2": "=B2*PI()/180"})
    assert [fault.cell for fault in report.faults] == ["Sheet!C2"], report


def test_coordinates_in_the_turned_frame_are_turned_back(tmp_path):
    texts = {"F1": "Inverse problem: from the turned frame back to the first", "C1": "x'", "C2": "y'", "C3": "z'"}
    cells = _sheet()
    back = {f"M{6 + k}": f"={c}6*D1+{c}7*D2+{c}8*D3" for k, c in enumerate("IJK")}
    report = _check(tmp_path, cells | back, texts)
    assert report.verdict == "right", report
    report = _check(tmp_path, cells, texts)
    assert (report.faults[0].cell, report.faults[0].cause) == ("Sheet!M6", "transposed"), report
    assert _check(tmp_path, cells, {"F1": texts["F1"], "C1": "x", "C2": "y", "C3": "z"}).verdict == "right"


def test_a_product_that_gives_no_number_has_its_point_and_origin(tmp_path):
    cells = _sheet() | {"P1": 10, "P2": -20, "P3": 30} | {f"R{n}": f"=D{n}-P{n}" for n in (1, 2, 3)}
    assert _check(tmp_path, cells | _product("M6", "I6", "R1", 1)).verdict == "right"
    rows = {f"M{n}": f"=INDEX(MMULT(R1:R3,I6:K8),{n - 5},1)" for n in (6, 7, 8)}
    report = _check(tmp_path, cells | rows)
    assert report.verdict != "right" and report.faults, report
    assert {fault.cause for fault in report.faults} == {"order of product"}, report


def test_the_fourth_number_of_a_homogeneous_result_is_judged(tmp_path):
    cells = {place: value for place, value in _sheet().items() if not place.startswith("M")} | {"D4": 1}
    cells |= {f"L{n}": 0 for n in (6, 7, 8)} | dict(zip(("I9", "J9", "K9", "L9"), (0, 0, 0, 1), strict=True))
    cells |= {f"N{n}": f"=I{n}*D$1+J{n}*D$2+K{n}*D$3+L{n}*D$4" for n in (6, 7, 8, 9)}
    assert _check(tmp_path, cells).verdict == "right"
    report = _check(tmp_path, cells | {"L9": 0})
    assert (report.verdict, report.faults[0].cell) == ("wrong", "Sheet!L9"), report
