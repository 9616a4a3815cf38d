"""The check of spreadsheets: tables, folders, the shell, and bad input."""

import os
import shutil
import subprocess
import sys
import zipfile

import numpy as np
import openpyxl
import pytest
import sympy as sp

from mathpost.errors import InputError, OutputError
from mathpost.interface.shell.main import main
from mathpost.sources.recipes import zxz_right
from mathpost.teaching import workbook
from mathpost.teaching.workbook import Task, check_file
from mathpost.teaching.workbook.sheet.formula import parse
from mathpost.teaching.workbook.sheet.tree import text_of
from tests.conftest import DATA, ROOT

ANGLES, POINT = (135, 54.7356, -90), (3, 4, 5)
RIGHT = DATA / "workbooks/right.xlsx"
# Layouts.


def test_an_input_that_is_not_the_tasks_is_wrong():
    assert check_file(RIGHT, Task(angles=ANGLES, point=POINT)).verdict == "right"
    report = check_file(RIGHT, Task(angles=(135, -54.7356, -90)))
    assert (report.faults[0].cell, report.faults[0].cause) == ("ZXZ!C6", "sign")


@pytest.mark.parametrize(("sequence", "convention"), [("ZYX", "active"), ("zxz", "passive"), ("ZXZ", "active")])
def test_another_task(sequence, convention):
    """The right sheet is none for another reading; the cause is not blamed on one of its cells without reason."""
    assert check_file(RIGHT, Task(sequence=sequence, convention=convention)).verdict == "wrong"


@pytest.mark.parametrize(
    ("name", "cell", "cause"),
    [
        ("active_elements", "B14", "other convention"),
        ("wrong_order", "B20", "order of product"),
        ("radians_forgotten", "G10", "degrees for radians"),
        ("missing_transpose", "J38", "transposed"),
        ("typed_sign", "F21", "typed over formula"),
        ("lucky", "B21", "wrong reference"),
    ],
)
def test_the_workbooks_of_the_lesson(name, cell, cause):
    report = check_file(DATA / f"workbooks/{name}.xlsx")
    assert (report.faults[0].cell, report.faults[0].cause) == (f"ZXZ!{cell}", cause)
    assert len(list((DATA / "workbooks").glob("*.xlsx"))) == 7


def test_the_sheet_as_sympy_is_the_packages_matrix():
    angles = sp.symbols("alpha beta gamma", real=True)
    sheet = workbook.symbolic(RIGHT, "E20:G22", dict(zip(("C5", "C6", "C7"), angles, strict=True)))
    assert (sheet - zxz_right(*angles, degrees=True)).applyfunc(sp.simplify) == sp.zeros(3)


@pytest.mark.parametrize(
    "formula", ["-A1^2", "(A1+B2)*-3", "MMULT(A1:C3,TRANSPOSE(D1:F3))", "A1-(B1-C1)", "IF(A1>=2,1,0)", "50%*A1"]
)
def test_formulas_are_written_as_they_are_read(formula):
    assert text_of(parse(f"={formula}", "S", {})) == formula


# Tables of NC words.


def _table(path, kin, spoil=lambda rows: rows, headings=None):
    rng = np.random.default_rng(4)
    axis = kin.forward(np.hstack([np.zeros((8, 3)), rng.uniform(15, 70, (8, 2))]), degrees=True)[1].round(6)
    tip = rng.uniform(-40, 40, (8, 3)).round(4)
    both, limits = kin.inverse(tip, axis, degrees=True).round(3), np.rad2deg(kin.machine.limits[3:])
    inside = ((both[..., 3:] >= limits[:, 0]) & (both[..., 3:] <= limits[:, 1])).all(axis=2)
    joints = both[np.arange(8), [rng.choice(np.flatnonzero(row)) for row in inside]]  # in travel
    joints[:, 4] += 360 * rng.integers(-1, 2, 8)
    book = openpyxl.Workbook()
    book.active.append(headings or [*"xyzijk", *kin.machine.joint_names])
    for row in spoil(np.hstack([tip, axis, joints])):
        book.active.append([float(number) for number in row])
    book.save(path)
    return path


def test_table_2_of_source_002(dmu50v):
    report = check_file(DATA / "tables/source_002_table_2.xlsx", Task(machine=dmu50v.machine))
    assert [fault.cell for fault in report.faults] == [f"Blade!L{row}" for row in range(2, 7)]
    assert any("C jumps by" in text for text in report.warnings)


def test_a_row_of_a_table_with_a_text_is_not_judged(dmu50v, tmp_path):
    book = openpyxl.load_workbook(DATA / "tables/source_002_table_2.xlsx")
    book.active["K3"], book.active["E4"] = "n/a", "#"
    book.save(tmp_path / "text.xlsx")
    report = check_file(tmp_path / "text.xlsx", Task(machine=dmu50v.machine))
    assert [fault.cell for fault in report.faults] == [f"Blade!L{row}" for row in (2, 5, 6)]
    said = [text for text in report.seen if "no row of a table" in text]
    assert [text.split(":")[:2] for text in said] == [["Blade!A3", "L3"], ["Blade!A4", "L4"]]


def test_a_second_table_below_the_first_is_judged(dmu50v, tmp_path):
    book = openpyxl.load_workbook(DATA / "tables/source_002_table_2.xlsx")
    rows = [[cell.value for cell in row] for row in book.active.iter_rows()]
    for row in ([], *rows):
        book.active.append(row)
    book.save(tmp_path / "two.xlsx")
    report = check_file(tmp_path / "two.xlsx", Task(machine=dmu50v.machine))
    assert [fault.cell for fault in report.faults] == [f"Blade!L{row}" for row in (*range(2, 7), *range(9, 14))]


def test_tables_of_any_machine(kin, tmp_path):
    path, task = tmp_path / "table.xlsx", Task(machine=kin.machine)
    for headings in (None, [*"XYZIJK", *kin.machine.joint_names]):
        assert check_file(_table(path, kin, headings=headings), task).verdict == "right"

    def typo(rows):
        rows[3, 7] += 1
        return rows

    assert [f.cell for f in check_file(_table(path, kin, typo), task).faults] == ["Sheet!H5"]

    def moved(rows):
        rows[:, 6] += 12.5
        return rows

    assert {f.cause for f in check_file(_table(path, kin, moved), task).faults} == {"offset"}
    report = check_file(RIGHT, task)
    assert report.verdict == "not judged" and "no table with the headings" in str(report)


# Folders, marked copies, the shell.


def _folder(tmp_path):
    folder = tmp_path / "class"
    (folder / "group").mkdir(parents=True)
    shutil.copy(RIGHT, folder / "anna.xlsx")
    shutil.copy(DATA / "workbooks/wrong_order.xlsx", folder / "group/bo.xlsx")
    (folder / "chris.xlsx").write_text("no workbook")
    (folder / "~$anna.xlsx").write_text("a lock file")
    return folder


def test_a_class(tmp_path):
    folder, seen = _folder(tmp_path), []
    summary = workbook.check_folder(folder, marked=folder / "marked", progress=lambda *args: seen.append(args[:2]))
    assert [row[:5] for row in summary.rows] == [
        ("anna.xlsx", "right", "90 of 90", "", ""),
        ("chris.xlsx", "not read", "", "", ""),
        (str(os.path.join("group", "bo.xlsx")), "wrong", "90 of 90", "ZXZ!B20", "order of product"),
    ]
    assert seen == [(1, 3), (2, 3), (3, 3)] and summary.status == 2
    assert sorted(p.name for p in (folder / "marked").rglob("*.xlsx")) == ["anna.xlsx", "bo.xlsx"]
    assert "1 not read, 1 right, 1 wrong" in str(summary) and "<table>" in summary._repr_html_()
    chinese = workbook.check_folder(folder, marked=folder / "marked", language="zh")
    assert "矩阵乘积顺序" in chinese.to_csv() and "正确" in chinese.to_html()
    shutil.copy(RIGHT, folder / "=1+1.xlsx")
    assert "\r\n'=1+1.xlsx,right" in workbook.check_folder(folder, marked=folder / "marked").to_csv()
    with pytest.raises(InputError):
        workbook.check_folder(tmp_path / "nowhere")


def test_marked_copies(tmp_path):
    original = (DATA / "workbooks/wrong_order.xlsx").read_bytes()
    (tmp_path / "w.xlsx").write_bytes(original)
    report = check_file(tmp_path / "w.xlsx")
    workbook.mark(report, tmp_path / "out" / "marked.xlsx")
    sheet = openpyxl.load_workbook(tmp_path / "out" / "marked.xlsx")["ZXZ"]
    assert sheet["B20"].fill.fgColor.rgb.endswith("FFC7CE") and "order" in sheet["B20"].comment.text
    assert sheet["A14"].fill.fgColor.rgb.endswith("C6EFCE") and sheet["A14"].comment is None
    assert sheet["E20"].fill.fgColor.rgb.endswith("FFEB9C") and "MMULT" in sheet["A20"].value.text
    values = openpyxl.load_workbook(tmp_path / "out" / "marked.xlsx", data_only=True)["ZXZ"]
    assert values["J22"].value == pytest.approx(
        openpyxl.load_workbook(tmp_path / "w.xlsx", data_only=True)["ZXZ"]["J22"].value
    )
    assert (tmp_path / "w.xlsx").read_bytes() == original
    with pytest.raises(OutputError, match="original"):
        workbook.mark(report, tmp_path / "w.xlsx")


def test_the_shell(tmp_path, capsys):
    assert main(["check", str(RIGHT)]) == 0
    assert main(["check", str(DATA / "workbooks/typed_sign.xlsx"), "--marked", str(tmp_path / "m.xlsx")]) == 1
    assert "ZXZ!F21" in capsys.readouterr().out and (tmp_path / "m.xlsx").exists()
    assert main(["check", str(tmp_path / "none.xlsx")]) == 2
    assert "none.xlsx" in capsys.readouterr().err
    assert main(["check", str(_folder(tmp_path)), "--csv", str(tmp_path / "c.csv"), "--language", "zh"]) == 2
    assert "错误" in (tmp_path / "c.csv").read_text(encoding="utf-8-sig")
    table, machine = str(DATA / "tables/source_002_table_2.xlsx"), str(DATA / "machines/dmu50v.toml")
    assert main(["check", table, "--machine", machine]) == 1
    assert main(["check", table, "--machine", machine, "--cells", "tip=B2:D6,axis=E2:G6,joints=H2:L6"]) == 1
    (tmp_path / "task.toml").write_text('sequence = "ZXZ"\nconvention = "passive"\nangles = [135, 54.7356, -90]\n')
    assert main(["check", str(RIGHT), "--task", str(tmp_path / "task.toml"), "--point", "3,4,5"]) == 0
    (tmp_path / "task.toml").write_text('order = "ZXZ"\n')
    assert main(["check", str(RIGHT), "--task", str(tmp_path / "task.toml")]) == 2
    with pytest.raises(SystemExit):
        main(["check", str(RIGHT), "--cells", "angles"])


def test_reading_only_the_first_lines_ends_quietly():
    command = f"{sys.executable} -m mathpost check {DATA / 'workbooks'} | head -1"
    done = subprocess.run(["sh", "-c", command], cwd=ROOT, capture_output=True, text=True)
    assert "Traceback" not in done.stderr and "BrokenPipe" not in done.stderr


# Bad input.


def _with_member(path, name, content):
    shutil.copy(RIGHT, path)
    with zipfile.ZipFile(path, "a", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr(name, content)
    return path


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("xl/vbaProject.bin", b"x", "vbaProject"),
        ("xl/externalLinks/externalLink1.xml", b"<x/>", "externalLink"),
        ("xl/connections.xml", b"<x/>", "connections"),
        ("xl/embeddings/object.bin", b"x", "embeddings"),
        ("xl/worksheets/sheet9.xml", bytes(80_000_000), "zip bomb"),
        ("xl/media/image.png", bytes(80_000_000), "zip bomb"),
        ("xl/evil.xml", b"<?xml version='1.0'?><!DOCTYPE a [<!ENTITY b 'c'>]><a/>", "DOCTYPE"),
    ],
)
def test_dangerous_files_are_refused_by_name(tmp_path, name, content, said):
    with pytest.raises(InputError, match=said):
        check_file(_with_member(tmp_path / "bad.xlsx", name, content))


def test_error_values_and_an_empty_sheet(tmp_path):
    book = openpyxl.load_workbook(RIGHT)
    book["ZXZ"]["J20"] = "#VALUE!"
    book.save(tmp_path / "e.xlsx")
    assert check_file(tmp_path / "e.xlsx").verdict != "right"
    openpyxl.Workbook().save(tmp_path / "empty.xlsx")
    with pytest.raises(InputError, match="only empty ones"):
        check_file(tmp_path / "empty.xlsx")


READ_HUGE = r"""
import re, sys
from pathlib import Path
from mathpost.teaching.workbook import check_file

report = check_file(sys.argv[1])
assert report.verdict == "right" and any("first 20000 rows" in text for text in report.warnings), report
status = Path("/proc/self/status")  # Linux; elsewhere only the time is limited
peak = re.search(r"VmHWM:\s*(\d+) kB", status.read_text(encoding="utf-8")) if status.exists() else None
assert peak is None or int(peak[1]) < 400_000, peak
"""


def test_a_huge_sheet_is_read_to_the_limit_in_bounded_memory(tmp_path, of):
    """Many rows below a right calculation: written as bare XML, read in a process whose memory is limited."""
    path, rows = tmp_path / "huge.xlsx", of(100_000, 1_000_000)
    with (
        zipfile.ZipFile(RIGHT) as source,
        zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as target,
    ):
        for name in source.namelist():
            data = source.read(name)
            if name.endswith("sheet1.xml"):
                head, tail = data.split(b"</sheetData>")
                with target.open(name, "w", force_zip64=True) as part:
                    part.write(head)
                    for row in range(100, rows + 100):
                        part.write(f'<row r="{row}"><c r="A{row}"><v>{row}.5</v></c></row>'.encode())
                    part.write(b"</sheetData>" + tail)
            else:
                target.writestr(name, data)
    subprocess.run([sys.executable, "-c", READ_HUGE, str(path)], check=True, cwd=ROOT)


def test_numbers_without_formulas_are_not_judged(tmp_path):
    book = openpyxl.load_workbook(RIGHT, data_only=True)
    book.save(tmp_path / "numbers.xlsx")
    report = check_file(tmp_path / "numbers.xlsx")
    assert report.status == 2 and "no formulas" in str(report)
