"""Why a cell was judged as it was, by `--why`; what is said of what was not judged; readings that a text allows."""

import pytest

from mathpost.interface.shell.main import main
from mathpost.teaching.workbook import Task, check_file
from tests.workbook.test_strangers import FRESH, ROOT, SHEETS, workbook


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
            {"G20": "=E20-E3", "G21": "=E21-E4", "G22": "=E22-E5"},
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


def test_what_is_not_judged_is_said_in_one_of_two_sentences(tmp_path):
    (title, cells), *_ = SHEETS["u001"]["sheets"].items()
    pages = (
        (cells | {"B26": "=E3*E20+7"}, "results right; not judged: Sheet1!B26"),
        ({"A1": "Lab", "B3": 30, "C3": "=B3*2"}, "give a right workbook to compare it with: --reference"),
    )
    for page, said in pages:
        workbook(SHEETS["u001"] | {"sheets": {title: page}}).save(tmp_path / "sheet.xlsx")
        report = check_file(tmp_path / "sheet.xlsx")
        assert report.status == 2 and said in str(report)
        assert report.beside == said.startswith("results right")


TURNED = {
    "F15:F17": "{=MMULT(MMULT(I10:K12,MMULT(E10:G12,A10:C12)),B5:B7)}",
    "A15:C17": "{=MMULT(I10:K12,E10:G12)}",
}


@pytest.mark.parametrize(
    ("text", "more", "verdict"),
    [
        ("ACTIVE rotation of the point, the axes stay fixed", {}, "right"),  # and intrinsic: may be either
        ("ACTIVE rotation of the point, the axes stay fixed", TURNED, "right"),
        ("ACTIVE rotation of the point, axes turn", {}, "right"),
        ("ACTIVE rotation of the point, axes turn", TURNED, "wrong"),
    ],
)
def test_words_of_both_kinds_leave_open_which_of_two_readings_is_meant(text, more, verdict, tmp_path):
    (cells,) = FRESH["P10"]["sheets"].values()
    cells = {place: content for place, content in cells.items() if place not in more}
    workbook(FRESH["P10"] | {"sheets": {"Sheet1": cells | {"A1": text} | more}}).save(tmp_path / "sheet.xlsx")
    report = check_file(tmp_path / "sheet.xlsx")
    assert report.verdict == verdict, report
    if "ZXZ active" not in str(report):
        assert ("may mean" in str(report)) == (verdict == "right" and "fixed" in text and not more)
    passive = check_file(tmp_path / "sheet.xlsx", Task(sequence="ZXZ", convention="passive"))
    assert passive.verdict == "wrong"  # the task decides


@pytest.mark.parametrize(("formula", "verdict"), [("Dᵀ·Cᵀ·Bᵀ·x_body", "right"), ("D·C·B·x_body", "wrong")])
def test_a_product_in_the_text_that_the_sheet_calculates_does_not_make_it_wrong(formula, verdict, tmp_path):
    elements = {"D": ("A", "B4", "Z"), "C": ("E", "B5", "X"), "B": ("I", "B6", "Z")}
    cells = {"A1": "D, C, B are the passive (axis-turning) matrices of phi, theta, psi"}
    cells |= {"A2": f"z-x-z turned axes; x_space = {formula}", "A4": "phi", "A5": "theta", "A6": "psi"}
    cells |= {"B4": 30, "B5": 50, "B6": 20, "D4": "x", "D5": "y", "D6": "z", "E4": 1, "E5": 2, "E6": 3}
    for name, (column, angle, axis) in elements.items():
        c, s = f"=COS(RADIANS({angle}))", f"SIN(RADIANS({angle}))"
        entries = (
            [c, f"={s}", 0, f"=-{s}", c, 0, 0, 0, 1] if axis == "Z" else [1, 0, 0, 0, c, f"={s}", 0, f"=-{s}", c]
        )
        first = ord(column)
        cells |= {f"{chr(first + n % 3)}{9 + n // 3}": entry for n, entry in enumerate(entries)} | {
            f"{column}8": name
        }
    product = "MMULT(TRANSPOSE(A9:C11),MMULT(TRANSPOSE(E9:G11),TRANSPOSE(I9:K11)))"
    cells |= {"A14:C16": f"{{={product}}}", "D14": "x_space", "E14:E16": "{=MMULT(A14:C16,E4:E6)}"}
    workbook({"sheets": {"Sheet1": cells}}).save(tmp_path / "sheet.xlsx")
    report = check_file(tmp_path / "sheet.xlsx")
    assert report.verdict == verdict, report
