"""What the check with a reference says of small workbooks, each of which shows one thing."""

import numpy as np
import openpyxl
import pytest

from mathpost.errors import InputError
from mathpost.interface.shell.main import main
from mathpost.teaching.workbook import Homework, Reference, check_folder, mark
from mathpost.teaching.workbook.reference.functions import FUNCTIONS
from mathpost.teaching.workbook.sheet.graph import Graph

FEED = {"A1": "vc", "B1": 180, "A2": "D", "B2": 16, "A3": "fz", "B3": 0.08, "A4": "z", "B4": 4,
        "A6": "n", "B6": "=B1*1000/(PI()*B2)", "A7": "vf", "B7": "=B6*B3*B4"}  # fmt: skip
POLAR = {"A1": "x", "B1": 3.5, "A2": "y", "B2": 4.25, "A4": "radius", "B4": "=SQRT(B1^2+B2^2)",
         "A5": "angle [deg]", "B5": "=DEGREES(ATAN2(B1,B2))"}  # fmt: skip


@pytest.fixture
def saved(tmp_path):
    def save(cells, name="theirs.xlsx"):
        book = openpyxl.Workbook()
        for address, content in cells.items():
            sheet, _, cell = address.rpartition("!")
            if sheet and sheet not in book.sheetnames:
                book.create_sheet(sheet)
            (book[sheet] if sheet else book.active)[cell] = content
        book.save(tmp_path / name)
        return tmp_path / name

    return save


def compared(saved, right, theirs, **homework):
    return Reference(Homework(saved(right, "right.xlsx"), **homework)).check(saved(theirs))


def test_laid_out_elsewhere_it_is_right(saved):
    theirs = {"Data!C3": 4, "Data!D3": "teeth", "Data!C4": 180, "Data!C5": 0.08, "Data!C6": 16,
              "Sheet!F9": "=Data!C4/(PI()*Data!C6)*Data!C5*Data!C3*1000"}  # fmt: skip
    report = compared(saved, FEED, theirs)
    assert report.verdict == "right" and report.status == 0
    assert "Sheet!F9: vf" in "\n".join(report.seen)


@pytest.mark.parametrize(
    "cell, content, cause, said",
    [
        ("B6", "=B1*1000/(3.14*B2)", "rounded early", "3.14"),
        ("B6", "=ROUND(B1*1000/(PI()*B2),0)", "rounded early", "rounded in between"),
        ("B6", 3580.99, "typed over formula", "typed where a formula belongs"),
        ("B6", "=B1*1000/(PI()*B3)", "wrong reference", "B3 should be B2"),
        ("B7", "=B6*B3/B4", "wrong value", "B4"),
    ],
)
def test_a_slip_is_told_with_its_cell(saved, cell, content, cause, said):
    report = compared(saved, FEED, {**FEED, cell: content})
    assert (report.verdict, report.faults[0].cell, report.faults[0].cause) == ("wrong", f"Sheet!{cell}", cause)
    assert said in report.faults[0].message
    assert any("rule: changed so" in line for line in report.explain(cell))


@pytest.mark.parametrize(
    "content, cause", [("=ATAN2(B1,B2)", "radians for degrees"), ("=DEGREES(ATAN2(B2,B1))", "atan2 order")]
)
def test_a_unit_is_told_as_a_unit(saved, content, cause):
    report = compared(saved, POLAR, {**POLAR, "B5": content})
    assert [(fault.cell, fault.cause) for fault in report.faults] == [("Sheet!B5", cause)]


def test_a_right_copy_elsewhere_does_not_save_what_is_labelled(saved):
    report = compared(saved, FEED, {**FEED, "B7": "=B6*B3", "H20": "=B6*B3*B4"})
    assert report.verdict == "wrong" and report.faults[0].cell == "Sheet!B7"


def test_numbers_of_a_students_own_are_right_as_a_function(saved):
    report = compared(saved, FEED, {**FEED, "B1": 140, "B2": 12, "B3": 0.05, "B4": 3})
    assert report.verdict == "right" and "own" in "\n".join(report.warnings)


def test_one_number_that_differs_is_asked_about(saved):
    theirs = {**FEED, "B2": 61}
    assert compared(saved, FEED, theirs).verdict == "not judged"
    assert compared(saved, FEED, theirs, numbers="own").verdict == "right"
    assert compared(saved, FEED, theirs, numbers="given").faults[0].cell == "Sheet!B2"


def test_a_result_that_depends_on_nothing_is_a_number_and_no_more(saved):
    right = {**FEED, "A9": "limit", "B9": "=2*PI()*50"}
    report = compared(saved, right, {**FEED, "A9": "limit", "B9": "=100*PI()"})
    assert report.verdict == "right" and "B9 is compared as a number" in "\n".join(report.warnings)
    assert compared(saved, right, {**FEED, "A9": "limit", "B9": "=99*PI()"}).faults[0].cell == "Sheet!B9"


def test_what_is_not_found_is_asked_for_and_can_be_told(saved):
    right = {"B1": 5, "B2": 7, "B4": "=B1-2*B2"}
    theirs = {"C1": 11, "D1": 23, "E5": "=D1-2*C1"}  # an order of their own, or two that are exchanged?
    report = compared(saved, right, theirs)
    assert report.status == 2 and "--cells" in "\n".join(report.seen)
    assert compared(saved, right, theirs, cells={"B1": "D1", "B2": "C1"}).verdict == "right"
    assert compared(saved, right, theirs, cells={"B1": "C1", "B2": "D1", "B4": "E5"}).verdict == "wrong"


def test_own_numbers_in_a_different_language_are_found_by_what_they_do(saved):
    own = zip(("inner diameter", "wall", "conductivity", "inside", "outside"), (100, 4, 50, 180, 20), strict=True)
    other = zip(("内径", "壁厚", "导热系数", "内", "外"), (60, 20, 45, 150, 18), strict=True)
    right, theirs = (
        {f"{c}{n}": v for n, pair in enumerate(each, 1) for c, v in zip("AB", pair, strict=True)}
        for each in (own, other)
    )
    right |= {"B7": "=B1/2", "B8": "=B7+B2", "B9": "=LN(B8/B7)/B3", "A10": "flow", "B10": "=(B4-B5)/B9"}
    theirs |= {"E1": "=B1+2*B2", "E2": "=B3*(B4-B5)", "A9": "流", "E9": "=E2/LN(E1/B1)"}
    assert compared(saved, right, theirs).verdict == "right"
    report = compared(saved, right, {**theirs, "E1": "=B1+B2"})
    assert report.verdict != "right" and all(fault.cell == "Sheet!E1" for fault in report.faults)


@pytest.mark.parametrize("reactance, is_right", [("=1/(E1*E3)", True), ("=1/(E1+E3)", False)])
def test_an_own_number_in_a_different_unit_is_taken_as_that(saved, reactance, is_right):
    right = {"A1": "omega", "B1": 314, "A2": "R", "B2": 40, "A3": "C", "B3": 60, "B5": "=1/(B1*B3*10^-6)",
             "A6": "Z", "B6": "=SQRT(B2^2+B5^2)", "A7": "phi", "B7": "=ATAN(B5/B2)"}  # fmt: skip
    theirs = {"D1": "ω", "E1": 377, "D2": "R", "E2": 25, "D3": "C [F]", "E3": 7e-5, "E5": reactance,
              "E6": "=(E2^2+E5^2)^0.5", "E7": "=ATAN2(E2,E5)"}  # fmt: skip
    report = compared(saved, right, theirs)
    assert (report.verdict == "right") == is_right, report


def test_numbers_in_a_row_of_a_list_are_the_same_row_of_the_list(saved):
    right = {f"A{n}": 20 + n / 7 for n in range(1, 6)} | {"C1": 0.3, "C2": -0.1}
    right |= {"C4": "=(C1-C2)/STDEV(A1:A5)", "C5": "=AVERAGE(A1:A5)-C2"}
    theirs = {f"F{n}": 35 + n % 3 for n in range(1, 6)} | {"H1": 0.4, "H2": 0.2}
    theirs |= {"H4": "=AVERAGE(F1:F5)-H2", "H5": "=(H1-H2)/STDEV(F1:F5)"}
    assert compared(saved, right, theirs).verdict == "right"


def test_a_lookup_by_a_computed_key_is_a_function(saved):
    table = {f"A{n}": 30.0 * n for n in range(1, 6)} | {f"B{n}": 0.5 + n**1.3 for n in range(1, 6)}
    right = {**table, "D1": 77.5, "D2": "=MATCH(D1,A1:A5,1)", "D3": "=INDEX(B1:B5,D2)*D1"}
    assert compared(saved, right, {**table, "F1": 77.5, "F2": "=F1*VLOOKUP(F1,A1:B5,2)"}).verdict == "right"
    report = compared(saved, right, {**table, "F1": 77.5, "F2": "=F1*INDEX(B1:B5,MATCH(F1,A1:A5,1)+1)"})
    assert report.verdict == "wrong"


@pytest.mark.parametrize(
    "cells", [{"A1": 1, "A2": 2}, {"A1": 1, "A2": "=A1/0"}, {"A1": 1, "A2": "=WEBSERVICE(A1)"}]
)
def test_a_reference_without_results_is_refused(saved, cells):
    with pytest.raises(InputError):
        Reference(saved(cells))


def test_a_hand_in_of_any_kind_ends_in_a_report(saved):
    strange = [
        {"A1": "nothing"}, {"A1": 1.0}, {**FEED, "B6": "=B7"}, {**FEED, "B6": "=B1/0"}, {**FEED, "B6": "=FOO(B1)"},
        {**FEED, "B1": "many"}, {"A1": "n", "B1": 3580.986}, {**FEED, "B7": "=B6&B3"}, {**FEED, "B2": True},
        {**FEED, "B7": "=B6*SIN()"}, {**FEED, "B7": "=MMULT(B6)"}, {**FEED, "B7": "=SUM(OFFSET(B1,0,0,0,1))"},
        {**FEED, "B7": "=INDEX(B1:B4,B3*1E308)"}, {**FEED, "B7": "=B6*1E400"}, {**FEED, "B1": "180,5", "B7": "=B6"},
    ]  # fmt: skip
    reference = Reference(saved(FEED, "right.xlsx"))
    for cells in strange:
        report = reference.check(saved(cells))
        assert report.verdict != "right" and "internal" not in str(report), cells


def test_a_number_that_is_none_is_refused_with_its_cell(saved):
    with pytest.raises(InputError, match="Sheet!B2: expected a finite number"):
        Reference(saved(FEED, "right.xlsx")).check(saved({**FEED, "B2": float("1.7976931348623157e308")}))


def test_the_shell_writes_the_task_and_reads_it_again(saved, tmp_path, capsys):
    right, theirs, task = saved(FEED, "right.xlsx"), saved({**FEED, "B7": "=B6*B3"}), tmp_path / "homework.toml"
    assert main(["check", str(theirs), "--reference", str(right), "--task", str(task)]) == 1
    assert "Sheet!B7" in task.read_text(encoding="utf-8")
    task.write_text(task.read_text(encoding="utf-8").replace("Sheet!B7", "Sheet!B6"), encoding="utf-8")
    assert main(["check", str(theirs), "--task", str(task)]) == 0
    task.write_text('reference = "right.xlsx"\nresult = ["B6"]\n', encoding="utf-8")
    assert main(["check", str(theirs), "--task", str(task)]) == 2
    assert "one of reference, numbers" in capsys.readouterr().err


def test_a_class_has_a_table_and_marked_copies(saved, tmp_path):
    reference = Reference(saved(FEED, "right.xlsx"))
    saved({**FEED, "B7": "=B6*B3"}, "a.xlsx")
    summary = check_folder(tmp_path, reference, marked=tmp_path / "marked")
    assert {row[0]: (row[1], row[3]) for row in summary.rows} == {
        "a.xlsx": ("wrong", "Sheet!B7"), "right.xlsx": ("right", ""),
    }  # fmt: skip
    comment = openpyxl.load_workbook(tmp_path / "marked/a.xlsx").active["B7"].comment
    assert "B6*B3" in comment.text
    mark(reference.check(tmp_path / "a.xlsx"), tmp_path / "copy.xlsx")


def test_the_reference_decides_and_the_check_of_its_kind_is_said_beside(saved, tmp_path):
    from mathpost.teaching.workbook import check_file

    folder = "data/workbooks"
    reference = Reference(f"{folder}/right.xlsx", check_file)
    report = reference.check(f"{folder}/lucky.xlsx")
    assert (report.verdict, report.faults[0].cell) == ("wrong", "ZXZ!B21")
    assert "without the reference: wrong" in "\n".join(report.seen)
    assert "reference itself is wrong" in Reference(f"{folder}/lucky.xlsx", check_file).warnings[0]


ABOUT = {
    "A1": "axis",
    "B1": 0.6,
    "C1": 0,
    "D1": 0.8,
    "A2": "angle",
    "B2": 50,
    "A3": "v",
    "B3": 3,
    "C3": -1,
    "D3": 2,
}
BY_QUATERNION = ABOUT | {
    "A5": "q0", "B5": "=COS(RADIANS(B2)/2)", "A6": "q1", "B6": "=B1*SIN(RADIANS(B2)/2)", "A7": "q2",
    "B7": "=C1*SIN(RADIANS(B2)/2)", "A8": "q3", "B8": "=D1*SIN(RADIANS(B2)/2)",
    "A9": "x", "B9": "=(1-2*(B7^2+B8^2))*B3+2*(B6*B7-B5*B8)*C3+2*(B6*B8+B5*B7)*D3",
}  # fmt: skip
BY_RODRIGUES = ABOUT | {
    "A5": "c", "B5": "=COS(B2*PI()/180)", "A6": "s", "B6": "=SIN(B2*PI()/180)", "A7": "along",
    "B7": "=B1*B3+C1*C3+D1*D3", "A9": "x", "B9": "=B3*B5+(C1*D3-D1*C3)*B6+B1*B7*(1-B5)",
}  # fmt: skip


def test_a_direction_is_one_at_every_sample(saved):
    """The two formulas are the same for a unit axis alone, which both sheets have."""
    assert compared(saved, BY_QUATERNION, BY_RODRIGUES).verdict == "right"
    wrong = BY_RODRIGUES | {"B9": "=B3*B5+(C1*D3+D1*C3)*B6+B1*B7*(1-B5)"}
    report = compared(saved, BY_QUATERNION, wrong)
    assert (report.verdict, report.faults[0].cell) == ("wrong", "Sheet!B9"), report


def test_the_work_grows_as_the_rows_do(saved, monkeypatch):
    """Many results, some of them controls that give the same whatever the inputs are."""
    made, begin = [], Graph.__init__
    monkeypatch.setattr(Graph, "__init__", lambda self, *given: (made.append(self), begin(self, *given))[1])
    work = {}
    for count in (50, 200):
        cells = {
            "A1": "angle",
            "B1": 25,
            "C1": "=COS(RADIANS(B1))",
            "D1": "=SIN(RADIANS(B1))",
            "A2": "x",
            "B2": "y",
        }
        for row in range(3, 3 + count):
            cells |= {f"A{row}": 1.5 * row, f"B{row}": 2.5 + row % 7, f"C{row}": f"=$C$1*A{row}-$D$1*B{row}"}
            cells |= {f"D{row}": f"=$D$1*A{row}+$C$1*B{row}"}
            cells |= {f"E{row}": f"=SUMSQ(C{row}:D{row})/SUMSQ(A{row}:B{row})"}
        made.clear()
        assert compared(saved, cells, cells).verdict == "right"
        work[count] = sum(graph.work for graph in made)
    assert work[200] < 6 * work[50]


LOAD = {"A1": "load", "B1": 5, "A2": "limit", "B2": 7, "A3": "ratio", "B3": "=B1/B2",
        "A4": "state", "B4": '=IF(B3<=1,"ok","overloaded")'}  # fmt: skip


@pytest.mark.parametrize(
    "content, verdict",
    [
        ('=IF(B1>B2,"Overloaded","OK")', "right"),
        ('=IF(B1<B2,"overloaded","ok")', "wrong"),
        ('=IF(B3>=1,"ok","overloaded")', "wrong"),
        ('=IF(B1>B2,"zu viel","gut")', "not judged"),  # other words: nobody knows which is which
        ("ok", "not judged"),
    ],
)
def test_a_text_that_a_condition_chooses_is_a_result(saved, content, verdict):
    report = compared(saved, LOAD, {**LOAD, "B4": content})
    assert report.verdict == verdict
    assert [fault.cell for fault in report.faults] == ["Sheet!B4"] * (verdict == "wrong")


PIPE = {"A1": "v", "B1": 1.7, "A2": "D", "B2": 0.05, "A3": "nu", "B3": 1e-6, "A4": "Re", "B4": "=B1*B2/B3",
        "A5": "friction", "B5": "=IF(B4<2300,64/B4,0.3164/B4^0.25)"}  # fmt: skip
ROWS = {f"A{n}": 0.5 + 0.13 * n for n in range(2, 12)} | {
        "A1": "v", "B1": "Re", "C1": "friction", "E1": "nu", "F1": 1e-6,
        **{f"B{n}": f"=A{n}*0.05/$F$1" for n in range(2, 12)},
        **{f"C{n}": f"=IF(B{n}<2300,64/B{n},0.3164/B{n}^0.25)" for n in range(2, 12)},
        "E2": "largest", "F2": "=MAX(C2:C11)"}  # fmt: skip
TABLE = {f"A{n}": 3.5 + 3 * n for n in range(2, 9)} | {f"B{n}": 0.5 + n**1.3 for n in range(2, 9)}
TABLE |= {"A1": "d", "B1": "pitch", "D1": "size", "E1": 13.2, "D2": "found", "E2": "=VLOOKUP(E1,A2:B8,2)"}
GUARD = {"A1": "way", "B1": 12.5, "A2": "time", "B2": 3.25, "A3": "speed", "B3": "=IF(B2=0,0,B1/B2)"}
CLAMP = {"A1": "r", "B1": 12.5, "A2": "h", "B2": 3.25, "A3": "rest", "B3": "=MAX(0,B1-2*B2)"}
MODE = {"A1": "kind", "B1": 1, "A2": "x", "B2": 3.5, "A3": "y", "B3": "=IF(B1=1,B2*2,IF(B1=2,B2*3,B2*4))"}
MARK = {"A1": "points", "B1": 61, "A2": "mark", "B2": '=IF(B1>=50,"pass","fail")'}


@pytest.mark.parametrize(
    "right, cell, content, verdict",
    [
        (PIPE, "B5", "=IF(B4<2300,60/B4,0.3164/B4^0.25)", "wrong"),
        (PIPE, "B5", "=IF(B4<3200,64/B4,0.3164/B4^0.25)", "wrong"),
        (PIPE, "B5", "=0.3164/B4^0.25", "wrong"),
        (PIPE, "B5", "=IF(B1*B2/B3>=2300,0.3164/B4^0.25,64/B4)", "right"),
        (ROWS, "C5", "=IF(B5<2300,60/B5,0.3164/B5^0.25)", "wrong"),
        (ROWS, "F2", "=MAX(C2:C10)", "wrong"),
        (TABLE, "E2", "=VLOOKUP(E1,A2:B6,2)", "wrong"),
        (TABLE, "E2", "=INDEX(B2:B8,MATCH(E1,A2:A8,1))", "right"),
        (CLAMP, "B3", "=B1-2*B2", "wrong"),
        (CLAMP, "B3", "=IF(B1>2*B2,B1-B2-B2,0)", "right"),
        (MODE, "B3", "=IF(B1=1,B2*2,IF(B1=2,B2*3.5,B2*4))", "wrong"),
        (MODE, "B3", "=B2*CHOOSE(B1,2,3,4)", "right"),
        (MARK, "B2", '=IF(B1>50,"pass","fail")', "wrong"),  # whole numbers may be just the limit
        (MARK, "B2", '=IF(B1<50,"fail","pass")', "right"),
    ],
)
def test_every_branch_is_compared(saved, right, cell, content, verdict):
    report = compared(saved, right, {**right, cell: content})
    assert report.verdict == verdict, report
    assert [fault.cell for fault in report.faults] == [f"Sheet!{cell}"] * (verdict == "wrong")


def test_what_no_input_reaches_is_told(saved):
    right = {**PIPE, "B5": "=IF(SIN(B4)<2,64/B4,0)"}
    report = compared(saved, right, {**PIPE, "B5": "=64/B4"})
    assert report.verdict == "right"
    assert "only the branch SIN(B4) < 2 was compared" in "\n".join(report.warnings)
    assert not compared(saved, right, right).warnings


def test_a_guard_that_a_hand_in_does_without_is_told(saved):
    report = compared(saved, GUARD, {**GUARD, "B3": "=B1/B2"})
    assert report.verdict == "right" and "B2 of the reference is 0" in "\n".join(report.warnings)
    assert compared(saved, GUARD, {**GUARD, "B3": "=IF(B2=0,1,B1/B2)"}).verdict == "wrong"


TAX = {"A1": "tax", "B1": 0.19, "A3": "item", "B3": "price", "C3": "with tax", "A13": "total",
       "B13": "=SUM(C4:C11)", **{f"A{n}": f"item {n}" for n in range(4, 12)},
       **{f"B{n}": 3.5 + 1.7 * n for n in range(4, 12)},
       **{f"C{n}": f"=B{n}*(1+$B$1)" for n in range(4, 12)}}  # fmt: skip


def test_a_reference_that_drifts_into_a_heading_is_told_where_it_begins(saved):
    report = compared(saved, TAX, {**TAX, **{f"C{n}": f"=B{n}*(1+B{n - 3})" for n in range(4, 12)}})
    assert [(fault.cell, fault.cause) for fault in report.faults] == [("Sheet!C5", "wrong reference")]
    assert "B1 should be $B$1" in report.faults[0].message


@pytest.mark.parametrize(
    "content, said", [("=1.5*B1-2*B2^2/3", "3 should be 4"), ("=1.5*B1+2*B2^2/4", "+"), ("=1.5*B1-2*B2/4", "B2^2")]
)
def test_what_differs_in_the_formula_is_the_cause(saved, content, said):
    right = {
        "A1": "x",
        "B1": 2.5,
        "A2": "y",
        "B2": 1.25,
        "A3": "step",
        "B3": "=1.5*B1-2*B2^2/4",
        "A4": "end",
        "B4": "=B3*7",
    }
    report = compared(saved, right, {**right, "B3": content})
    assert report.faults[0].cell == "Sheet!B3" and said in report.faults[0].message


STOPS = {f"A{n}": "xyxzyx"[n - 2] for n in range(2, 8)} | {f"B{n}": 20.5 + 13 * n for n in range(2, 8)}
STOPS |= {"D1": "x", "E1": "=SUMIF(A2:A7,D1,B2:B7)", "D2": "y", "E2": '=AVERAGEIF(A2:A7,"y",B2:B7)'}


@pytest.mark.parametrize(
    "cell, content, verdict",
    [("E1", '=SUMIFS(B2:B7,A2:A7,"X")', "right"), ("E1", "=SUMIF(A2:A6,D1,B2:B6)", "wrong"),
     ("E2", '=SUMIF(A2:A7,D2,B2:B7)/COUNTIF(A2:A7,"y")', "right"), ("E2", "=SUMIF(A2:A7,D2,B2:B7)/3", "wrong")],
)  # fmt: skip
def test_totals_by_criteria(saved, cell, content, verdict):
    assert compared(saved, STOPS, {**STOPS, cell: content}).verdict == verdict


def test_one_text_of_a_column_is_missed(saved):
    column = {"A1": "x", "B1": "sign"} | {f"A{n}": float(n) - 5.5 for n in range(2, 12)}
    right = column | {f"B{n}": f'=IF(A{n}>0,"plus","minus")' for n in range(2, 12)}
    report = compared(saved, right, {**right, "B4": '=IF(A4<0,"plus","minus")'})
    assert (report.verdict, report.faults[0].cell) == ("wrong", "Sheet!B4")


def test_a_function_that_is_not_known_leaves_its_result_open(saved):
    right = {**FEED, "A9": "many", "B9": "=PERCENTRANK(B1:B4,B2)"}
    report = compared(saved, right, right)
    assert report.verdict == "not judged" and "PERCENTRANK is not known here" in "\n".join(report.seen)
    assert compared(saved, right, {**right, "B7": "=B6*B3/B4"}).faults[0].cell == "Sheet!B7"
    assert compared(saved, right, right, results=["B7"]).verdict == "right"  # the teacher asks for no more


@pytest.mark.parametrize("rate, early", [(0.004, 0), (0.004, 1), (0.0, 0)])
def test_payments_leave_what_they_should(rate, early):
    given = (np.full((1, 1, 1), each) for each in (rate, 24.0, 9000.0, -500.0, early))
    paid, left = -FUNCTIONS["PMT"](*given)[0, 0, 0], 9000.0
    for _ in range(24):
        left = (left - paid * early) * (1 + rate) - paid * (1 - early)
    assert left == pytest.approx(500, abs=1e-6)


def test_the_spread_about_a_line():
    x, y = np.array([1.0, 2, 3, 5, 8]), np.array([2.0, 3.5, 3, 6, 8.5])
    left = y - np.polyval(np.polyfit(x, y, 1), x)
    spread = FUNCTIONS["STEYX"](y.reshape(1, -1, 1), x.reshape(1, -1, 1))[0, 0, 0]
    assert spread == pytest.approx(np.sqrt((left**2).sum() / 3))
