"""What texts of a sheet say of its rotation, and what makes its inputs doubtful: names, units, what nobody uses."""

import numpy as np
import pytest

from mathpost.euler import matrix
from mathpost.shell.main import main
from mathpost.workbook import Task, check_file
from mathpost.workbook.meaning.texts import reading
from tests.workbook.test_around import ROWS, _table
from tests.workbook.test_strange_sheets import _check
from tests.workbook.test_strangers import ROOT, SHEETS, workbook


@pytest.mark.parametrize(
    ("text", "sequence", "active", "names"),
    [
        ("C_bn = R1(φ)·R2(θ)·R3(ψ), passive", "ZYX", False, ("ψ", "θ", "φ")),
        ("R3·R2·R1, the matrices of the steps", "ZXZ", False, ()),
        ("intrinsic z-x-z, R = Rz(a) Rx(b) Rz(c); find R^T p", "ZXZ", False, ()),
        ("intrinsic z-x-z, p' = R p with R = Rz(a) Rx(b) Rz(c), back p = R^T p'", "ZXZ", True, ("a", "b", "c")),
        ("aktive Drehmatrix R = Rz(ψ)·Ry(θ)·Rx(φ)", "ZYX", True, ("ψ", "θ", "φ")),
        ("r = Rz(Ω)·Rx(i)·Rz(ω)·q with active matrices", "ZXZ", True, ("Ω", "i", "ω")),
        ("R = Rz(Ω)·Rx(i)·Rz(ω) of active matrices, then transposed", "ZXZ", False, ()),
        ("about the fixed axes, active: R = Rz(c)*Ry(b)*Rx(a)", "xyz", True, ("a", "b", "c")),
        ("A = Rz(-γ)·Rx(-β)·Rz(-α), active matrices", "ZXZ", False, ()),
        ("(row – p0) · M with M = Rx(a)·Ry(b)·Rz(c)", "XYZ", False, ("a", "b", "c")),
        (
            "M = T*Rz*Ry*Rx about machine X, then about machine Y, then about machine Z, all axes fixed",
            "xyz",
            True,
            (),
        ),
        ("w = o + Rz(I) Rx(J) Rz(K) f", "ZXZ", True, ("I", "J", "K")),
        ("yaw - pitch - roll, passive", "ZYX", False, ()),
        ("XYZ by quaternions (w x y z), passive", "XYZ", False, ()),
        ("unit quaternion w x y z", "ZXZ", False, ()),
    ],
)
def test_a_product_in_the_text(text, sequence, active, names):
    found = reading(Task(), text)
    assert (*found[:2], found[4]) == (sequence, active, names)


def test_two_angles_of_which_one_is_negated():
    sequence, active, _, doubts, names = reading(Task(), "Gimbal: R = Rz(az)·Ry(−el), active", 2)
    assert (sequence, active, doubts, names) == ("ZY", True, [], ("az", "-el"))


def _by_columns(names, entries, angles=(-18.8, 47.1, 152.0)):
    """Angles in A2:C2 under their names, R in E2:G4, a point in I2:I4 and the result in K2:K4."""
    cells = {f"{c}1": name for c, name in zip("ABC", names, strict=True)}
    cells |= {f"{c}2": angle for c, angle in zip("ABC", angles, strict=True)}
    cells |= {f"I{n}": number for n, number in zip((2, 3, 4), (4, -7, 11), strict=True)}
    for n, row in enumerate(entries, 2):
        for c, entry in zip("EFG", row, strict=True):
            for letter, column in zip("pqr", "ABC", strict=True):
                entry = entry.replace(f"c{letter}", f"COS(RADIANS(${column}$2))")
                entry = entry.replace(f"s{letter}", f"SIN(RADIANS(${column}$2))")
            cells[f"{c}{n}"] = f"={entry}"
        cells[f"K{n}"] = f"=E{n}*$I$2+F{n}*$I$3+G{n}*$I$4"
    return cells


# Rz(r)·Ry(q)·Rx(p)
YAW_LAST = (
    ("cr*cq", "cr*sq*sp-sr*cp", "cr*sq*cp+sr*sp"),
    ("sr*cq", "sr*sq*sp+cr*cp", "sr*sq*cp-cr*sp"),
    ("-sq", "cq*sp", "cq*cp"),
)


@pytest.mark.parametrize(
    ("names", "verdict"),
    [("abc", "right"), ("cba", "wrong"), (("φ", "θ", "ψ"), "right"), (("ψ", "θ", "φ"), "wrong")],
)
def test_the_names_of_a_product_tell_which_angle_turns_about_which_axis(tmp_path, names, verdict):
    a, b, c = ("φ", "θ", "ψ") if "φ" in names else "abc"
    text = {"A6": f"active rotation, R = Rz({c})·Ry({b})·Rx({a})"}
    cells = _by_columns(names, YAW_LAST)
    assert _check(tmp_path, cells, text).verdict == verdict
    turned = matrix("xyz", np.array([-18.8, 47.1, 152.0]), degrees=True) @ [4, -7, 11]
    angles = [cells[f"{p}2"] for p in "ABC"]
    assert np.allclose(turned, matrix("ZYX", angles[::-1], degrees=True) @ [4, -7, 11])


def test_row_vectors_are_turned_by_the_transposed_matrix(tmp_path):
    cells = _by_columns("abc", YAW_LAST)
    rows = {f"K{n}": f"={c}$2*$I$2+{c}$3*$I$3+{c}$4*$I$4" for n, c in zip((2, 3, 4), "EFG", strict=True)}
    text = {"A6": "row vectors: p' = p · R, R = Rz(c)·Ry(b)·Rx(a), active matrices"}
    assert _check(tmp_path, cells | rows, text).verdict == "right"
    assert _check(tmp_path, cells, text).verdict == "wrong"


@pytest.mark.parametrize(
    ("heading", "formula", "verdict"),
    [
        ("for comparison: active rotation", "={c}2*A8+{c}3*B8+{c}4*C8", "right"),
        ("the same rotation applied to the point", "={c}2*A8+{c}3*B8+{c}4*C8", "right"),
        ("second recipe, active matrices", "={c}2*A8+{c}3*B8+{c}4*C8", "wrong"),
        ("for comparison: active rotation", "={c}2*A8-{c}3*B8+{c}4*C8", "unclear"),
    ],
)
def test_the_other_convention_under_a_heading(tmp_path, heading, formula, verdict):
    cells = {"P1": heading} | {f"Q{n}": formula.format(c=c) for n, c in zip((2, 3, 4), "FGH", strict=True)}
    assert _check(tmp_path, _table() | cells).verdict == verdict


@pytest.mark.parametrize("factor", ["*PI()/180", "*3.14159/180", "/57.29578", "*0.01745329"])
def test_a_conversion_of_six_digits_is_right(tmp_path, factor):
    assert _check(tmp_path, _table() | _converted(factor)).verdict == "right"


@pytest.mark.parametrize("factor", ["*3.14/180", "*3.1416/180", "/57.3", "*0.01745"])
def test_a_rough_conversion_of_all_angles_is_rounded_early(tmp_path, factor):
    report = _check(tmp_path, _table() | _converted(factor))
    assert {fault.cause for fault in report.faults} == {"rounded early"}, report
    assert [fault.cell for fault in report.faults] == [f"Sheet!{c}{n}" for n in (2, 3, 4) for c in "CD"]


def _converted(factor):
    return {f"{c}{n}": f"={f}(B{n}{factor})" for n in (2, 3, 4) for c, f in (("C", "COS"), ("D", "SIN"))}


DOUBTFUL = {
    "an origin that no formula uses": ({"N2": "origin", "O2": 4, "P2": -2, "Q2": 9}, "no formula uses it"),
    "a label of another unit": ({"A3": "β [rad]"}, "taken in another unit"),
    "a circle": ({"D8": "=$F$2*$A8+$G$2*$B8+$H$2*$C8+0*D14"}, "depends on itself"),
}


@pytest.mark.parametrize("name", DOUBTFUL)
def test_what_makes_the_inputs_doubtful(tmp_path, name):
    change, text = DOUBTFUL[name]
    report = _check(tmp_path, _table() | change)
    assert report.verdict == "unclear" and any(text in line for line in report.seen), str(report)


def _minutes(formula="=B{n}+C{n}/60+D{n}/3600"):
    """Angles of degrees, minutes and seconds in B2:D4, in E as decimals, ZXZ, and a result in N2:N4."""
    cells = {"B1": "deg", "C1": "min", "D1": "sec"}
    for n, parts in zip((2, 3, 4), ((35, 20, 15), (62, 45, 30), (18, 5, 50)), strict=True):
        cells |= {f"{c}{n}": part for c, part in zip("BCD", parts, strict=True)} | {f"E{n}": formula.format(n=n)}
        cells |= {f"F{n}": f"=COS(RADIANS(E{n}))", f"G{n}": f"=SIN(RADIANS(E{n}))"}
    cells |= {"L2": 4, "L3": -9, "L4": 6}
    rows = (
        ("F4*F2-G4*F3*G2", "F4*G2+G4*F3*F2", "G4*G3"),
        ("-G4*F2-F4*F3*G2", "-G4*G2+F4*F3*F2", "F4*G3"),
        ("G3*G2", "-G3*F2", "F3"),
    )
    for n, row in enumerate(rows, 2):
        terms = (f"({entry})*L{k}" for k, entry in enumerate(row, 2))
        cells[f"N{n}"] = f"={'+'.join(terms)}"
    return cells


def test_minutes_and_seconds(tmp_path):
    assert _check(tmp_path, _minutes()).verdict == "right"
    swapped = _check(tmp_path, _minutes() | {"E3": "=B3+D3/60+C3/3600"})
    assert [fault.cell for fault in swapped.faults] == ["Sheet!E3"], swapped
    for change in ({"E3": "=B3+C3/60"}, {"E3": "=B2+C2/60+D2/3600"}):
        report = _check(tmp_path, _minutes() | change)
        assert report.verdict != "right" and "no formula uses it" in str(report), report


def _moved(used):
    """The table with an origin in S6:U6, and p - p0 in W to Y, of which the columns `used` are turned."""
    cells = _table() | {"R6": "p0", "S6": 4, "T6": -2, "U6": 9, "W7": "p - p0"}
    for n in ROWS:
        cells |= {f"{d}{n}": f"={c}{n}-${o}$6" for c, d, o in zip("ABC", "WXY", "STU", strict=True)}
        for c, k in (("D", 2), ("E", 3), ("F", 4)):
            cells[f"{c}{n}"] = f"=$F${k}*{used[0]}{n}+$G${k}*{used[1]}{n}+$H${k}*{used[2]}{n}"
    return {
        address: content for address, content in cells.items() if address[0] not in "GI" or address[1:] in "234"
    }


def test_differences_with_the_origin_that_are_not_used(tmp_path):
    assert _check(tmp_path, _moved("WXY")).verdict == "right"
    report = _check(tmp_path, _moved("ABC"))
    assert (report.verdict, report.faults[0].cell) == ("wrong", "Sheet!D8"), report


def test_what_lost_all_its_dollars_is_one_slip(tmp_path):
    cells = _table()
    cells |= {f"D{n}": f"=$F$2*$A{n}+$G$2*$B{n}+$H$2*$C{n}" for n in ROWS}
    cells["D9"] = "=F3*$A9+G3*$B9+H3*$C9"
    report = _check(tmp_path, cells)
    assert (report.faults[0].cell, report.faults[0].cause) == ("Sheet!D9", "missing $"), report


@pytest.mark.parametrize(
    ("cell", "rule"),
    [
        ("F21", "rule: a fault, typed over formula"),
        ("J22", "asked for at these inputs: "),
        ("A14", "it is on the way to ZXZ!J20"),
        ("C5", "it is given, and was varied at random"),
        ("A1", "it is no number that follows"),
    ],
)
def test_the_rule_that_judged_a_cell(cell, rule, capsys):
    assert main(["check", str(ROOT / "data/workbooks/typed_sign.xlsx"), "--why", cell]) == 1
    said = capsys.readouterr().out.splitlines()[-3:]
    assert any(line.startswith(f"ZXZ!{cell} is ") for line in said) and rule in said[-1]


@pytest.mark.parametrize(
    ("cells", "cell", "rule"),
    [
        ({"B26": "=SQRT(SUMSQ(E3:E5))"}, "B26", "a number that follows from right results"),
        ({"B26": "=E3*E20+7"}, "B26", "it is no number, and of no vector"),
        ({"B26": "=E3*H20"}, "B26", "it refers to an empty cell"),
        (
            {"G20": "=(E3+E20)/2", "G21": "=(E4+E21)/2", "G22": "=(E5+E22)/2"},
            "G21",
            "a vector that follows from right results",
        ),
        ({"B26": "=1/0"}, "B26", "it shows an error"),
        ({"E21": "=1*E22"}, "E20", "compared as a function of angles Sheet1!B3:B5, point Sheet1!E3:E5"),
    ],
)
def test_the_rule_that_judged_what_stands_beside(cells, cell, rule, tmp_path):
    (title, right), *_ = SHEETS["u001"]["sheets"].items()
    workbook(SHEETS["u001"] | {"sheets": {title: right | cells}}).save(tmp_path / "sheet.xlsx")
    assert rule in check_file(tmp_path / "sheet.xlsx").explain(cell)[-1]


def test_the_rule_that_judged_a_number(tmp_path):
    (cells,) = SHEETS["u030"]["sheets"].values()
    workbook(SHEETS["u030"] | {"sheets": {"Abgabe": cells | {"F11": 9.448}}}).save(tmp_path / "sheet.xlsx")
    explain = check_file(tmp_path / "sheet.xlsx").explain
    wanted, rule = explain("F11")[-2:]
    assert float(wanted.split()[3]) == pytest.approx(-9.448, abs=1e-3)  # as the author's sheet has it
    assert "Abgabe!B11:D11 turned by the angles Abgabe!B2:B4" in rule
    assert explain("B2")[-1] == "rule: it is given" and "under no heading" in explain("B6")[-1]


def test_what_is_not_judged_is_said_in_one_of_two_sentences(tmp_path):
    (title, cells), *_ = SHEETS["u001"]["sheets"].items()
    pages = (
        (cells | {"B26": "=E3*E20+7"}, "results right; not judged: Sheet1!B26"),
        ({"A1": "Lab", "B3": 30, "C3": "=B3*2"}, "no result recognised; say where it is: --cells"),
    )
    for page, said in pages:
        workbook(SHEETS["u001"] | {"sheets": {title: page}}).save(tmp_path / "sheet.xlsx")
        report = check_file(tmp_path / "sheet.xlsx")
        assert report.status == 2 and said in str(report)
        assert report.beside == said.startswith("results right")


TEXTS = {
    "Euler ZXZ: alpha = 35°, beta = {}°, gamma = -20°, three points": 50,
    "ZXZ欧拉角:α=35°,β={}°,γ=-20°,点P(1, 2, 3)": 50,
    "Eulerwinkel ZXZ, alpha: 35, beta: {}, gamma: −20 Grad; Aufgabe 3 von 7": 50,
    "Euler ZXZ; alpha = 35, then alpha = 36, beta = {}, gamma = -20": None,  # who knows which
    "Euler ZXZ; alpha = 10, beta = {}, gamma = -21": None,  # another example
}


@pytest.mark.parametrize("text", TEXTS)
@pytest.mark.parametrize("number", [5, -50, 50])
def test_an_angle_that_a_text_gives_by_name_with_another_number(text, number, tmp_path):
    """The text is what was asked for, where two angles are as it says and one is not."""
    report = _check(tmp_path, _table() | {"A1": text.format(number)})
    is_wrong = TEXTS[text] is not None and number != 50
    assert (report.verdict == "wrong") == is_wrong, report
    assert not is_wrong or report.faults[0].cell == "Sheet!B3"


def _plane_words(given, made):
    """A plane's angles by one control's words in A2 to C2, F in E2:G4, and by another's in I2 to K2, by hand."""
    cells = {"A1": "Same plane, two controls"} | {f"{c}1": word for c, word in zip("IJK", made, strict=True)}
    cells |= {"A1": given[0], "B1": given[1], "C1": given[2], "A2": 25, "B2": -40, "C2": 110}
    ca, cb, cc, sa, sb, sc = (f"{f}(RADIANS(${c}$2))" for f in ("COS", "SIN") for c in "ABC")
    spatial = (
        (f"{cc}*{cb}", f"{cc}*{sb}*{sa}-{sc}*{ca}", f"{cc}*{sb}*{ca}+{sc}*{sa}"),
        (f"{sc}*{cb}", f"{sc}*{sb}*{sa}+{cc}*{ca}", f"{sc}*{sb}*{ca}-{cc}*{sa}"),
        (f"-{sb}", f"{cb}*{sa}", f"{cb}*{ca}"),
    )
    euler = (
        (f"{ca}*{cc}-{sa}*{cb}*{sc}", f"-{ca}*{sc}-{sa}*{cb}*{cc}", f"{sa}*{sb}"),
        (f"{sa}*{cc}+{ca}*{cb}*{sc}", f"-{sa}*{sc}+{ca}*{cb}*{cc}", f"-{ca}*{sb}"),
        (f"{sb}*{sc}", f"{sb}*{cc}", cb),
    )
    matrix = spatial if given[0] == "SPA" else euler
    cells |= {
        f"{c}{n}": f"={entry}" for n, row in enumerate(matrix, 2) for c, entry in zip("EFG", row, strict=True)
    }
    back = {
        "SPA": ("ATAN2(G4,F4)", "ATAN2(SQRT(E2^2+E3^2),-E4)", "ATAN2(E2,E3)"),
        "I": ("ATAN2(-G3,G2)", "ATAN2(G4,SQRT(G2^2+G3^2))", "ATAN2(F4,E4)"),
    }
    formulas = back["SPA" if made[0] == "SPA" else "I"]
    return cells | {f"{c}2": f"=DEGREES({formula})" for c, formula in zip("IJK", formulas, strict=True)}


SPATIAL, FANUC, EULER = ("SPA", "SPB", "SPC"), ("I", "J", "K"), ("EULPR", "EULNU", "EULROT")


@pytest.mark.parametrize(
    ("given", "made"), [(SPATIAL, FANUC), (FANUC, SPATIAL), (EULER, SPATIAL), (SPATIAL, EULER)]
)
def test_angles_under_the_words_of_a_plane_are_converted(given, made, tmp_path):
    cells = _plane_words(given, made)
    assert _check(tmp_path, cells).verdict == "right"
    for cell, old, new in (("J2", "ATAN2(", "-ATAN2("), ("F4", "SIN", "COS"), ("K2", "ATAN2(", "-ATAN2(")):
        report = _check(tmp_path, cells | {cell: cells[cell].replace(old, new, 1)})
        assert (report.verdict, report.faults[0].cell) == ("wrong", f"Sheet!{cell}"), (cell, report)


def test_a_point_that_turns_about_a_centre_is_turned(tmp_path):
    cells = _table() | {"A1": "Euler ZXZ, p' = c + R·(p − c)", "R6": "c", "S6": 4, "T6": -2, "U6": 9}
    cells = {
        address: cell for address, cell in cells.items() if address[0] not in "GHIKLMN" or address[1:] in "234"
    }
    for n in ROWS:
        for c, column, k in (("D", "F", "S"), ("E", "G", "T"), ("F", "H", "U")):  # Rᵀ of the table's passive R
            terms = (f"${column}${j}*({a}{n}-${o}$6)" for j, a, o in zip((2, 3, 4), "ABC", "STU", strict=True))
            cells[f"{c}{n}"] = f"=${k}$6+" + "+".join(terms)
    assert _check(tmp_path, cells).verdict == "right"
    other = cells | {f"D{n}": cells[f"D{n}"].replace("$S$6+", "") for n in ROWS}
    assert _check(tmp_path, other).verdict == "wrong"


def test_a_difference_of_lengths_that_is_none_is_not_right(tmp_path):
    cells = _moved("WXY") | {"AA7": "distance of p from p0", "AB7": "length of p'", "AC7": "difference"}
    for n in ROWS:
        cells |= {
            f"AA{n}": f"=SQRT(SUMSQ(W{n}:Y{n}))",
            f"AB{n}": f"=SQRT(SUMSQ(D{n}:F{n}))",
            f"AC{n}": f"=AA{n}-AB{n}",
        }
    assert _check(tmp_path, cells).verdict == "right"
    other = cells | {f"AA{n}": f"=SQRT(SUMSQ(A{n}:C{n}))" for n in ROWS}
    assert _check(tmp_path, other).verdict != "right"


def test_a_formula_that_takes_an_empty_cell_is_not_right(tmp_path):
    """An origin of 0 hides it: the numbers are the same."""
    cells = _moved("WXY") | {"U6": 0}
    assert _check(tmp_path, cells).verdict == "right"
    last = ROWS[-1]
    report = _check(tmp_path, cells | {f"Y{last}": f"=C{last}-$U$5"})
    assert report.verdict != "right" and f"Y{last}" in str(report)


def test_a_difference_that_is_a_sum_is_not_right(tmp_path):
    cells = _table() | {"Q20": "difference of the lengths", "R20": "=G8-H8"}
    assert _check(tmp_path, cells).verdict == "right"
    assert _check(tmp_path, cells | {"R20": "=G8+H8"}).verdict != "right"


def test_a_result_that_its_heading_calls_active_is_said_to_be(tmp_path):
    """Sheet t012 has a passive rotation and, for comparison, an active one, both right."""
    workbook(SHEETS["t012"]).save(tmp_path / "both.xlsx")
    seen = check_file(tmp_path / "both.xlsx").seen
    assert "Sheet!B31:B33: active rotation, ZXZ, as the text says" in seen
    assert "Sheet!J17:J19: passive rotation, ZXZ, as the text says" in seen
