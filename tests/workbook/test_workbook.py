"""Workbooks with planted errors, right ones in many layouts, the template, tables, folders, and bad input."""

import os
import shutil
import subprocess
import sys
import zipfile

import numpy as np
import openpyxl
import pytest
from scipy.spatial.transform import Rotation

from mathpost.__main__ import main
from mathpost.errors import InputError, OutputError
from mathpost.workbook import folder as workbook
from mathpost.workbook.file import read, recalculate
from mathpost.workbook.layout import find
from tests.conftest import DATA, ROOT
from tests.workbook import planted

ANGLES, POINT = (135, 54.7356, -90), (3, 4, 5)
RIGHT = DATA / "workbooks/right.xlsx"
needs_office = pytest.mark.skipif(shutil.which("soffice") is None, reason="LibreOffice is not installed")


def _layout(rng, angles, point):
    return planted.Layout(
        rng,
        angles,
        point,
        recipe=str(rng.choice(["right", "left"])),
        trig=bool(rng.integers(2)),
        array=bool(rng.integers(2)),
        across=bool(rng.integers(2)),
        english=bool(rng.integers(2)),
    )


def _numbers(rng):
    return np.round(rng.uniform(-170, 170, 3), rng.integers(1, 5)), np.round(rng.uniform(-9, 9, 3), 2)


def _spoilt(rng, spoil):
    """A layout with one error that shows in the numbers, the first cell where it does, and the kinds."""
    while True:
        layout = _layout(rng, *_numbers(rng))
        right = planted.evaluate(layout.cells)
        kinds = spoil(layout)
        first = layout.first_difference(right) if kinds else None
        if first:
            return layout, first, kinds


@pytest.fixture(scope="module")
def spoilt_reports(tmp_path_factory):
    """510 workbooks with one planted error each: error, cell and kinds that were planted, and the report."""
    path, rng, found = tmp_path_factory.mktemp("planted") / "one.xlsx", np.random.default_rng(20), []
    for n in range(510):
        spoil = planted.ERRORS[n % len(planted.ERRORS)]
        layout, first, kinds = _spoilt(rng, spoil)
        planted.save(path, layout.cells, values_only=n % 4 == 3)
        found.append((spoil.__name__, first, kinds, workbook.check(path)))
    return found


def test_the_first_wrong_cell_is_always_named(spoilt_reports):
    missed = [
        (name, first, str(report.first)) for name, first, _, report in spoilt_reports
        if report.right or report.first.cell != f"Sheet1!{first}"
    ]  # fmt: skip
    assert not missed


def test_the_kind_is_named_in_95_percent(spoilt_reports):
    missed = [(name, report.why) for name, _, kinds, report in spoilt_reports if not kinds & set(report.kinds)]
    assert len(missed) <= 0.05 * len(spoilt_reports), missed


def test_what_follows_from_an_error_is_no_error(spoilt_reports):
    """One slip in a cell or a formula spoils the steps after it, but only its own step is wrong."""
    single = {"typed_number", "sign_of_entry", "sine_for_cosine", "order_first", "missing_transpose", "identity"}
    for name, _, _, report in spoilt_reports:
        if name in single:
            wrong = {cell.role.split(",")[0] for cell in report.cells if cell.status == "wrong"}
            assert len(wrong) == 1, (name, wrong)


def test_right_workbooks_raise_no_alarm(tmp_path):
    rng, path = np.random.default_rng(21), tmp_path / "right.xlsx"
    special = np.array([0, 90, -90, 180, 45, 54.7356, 1e-3, 360, 120])
    for n in range(200):
        angles, point = _numbers(rng)
        if n % 2:
            angles = rng.choice(special, 3)
        if n % 10 == 0:
            point = rng.choice([0, 0, 1, -5], 3).astype(float)
        planted.save(path, _layout(rng, angles, point).cells, values_only=n % 4 == 3)
        report = workbook.check(path)
        assert report.right and report.counts()["right"] == len(report.cells), f"{angles} {point}\n{report}"


@pytest.mark.parametrize("decimals", [3, 4, 6, 15])
def test_numbers_written_by_hand_are_right_to_their_digits(tmp_path, decimals):
    layout = planted.Layout(np.random.default_rng(1), ANGLES, POINT, recipe="left")
    values = planted.evaluate(layout.cells)
    keep = {*layout.angles, *layout.point, *layout.negated}
    cells = {a: v if isinstance(v, str) or a in keep else round(v, decimals) for a, v in values.items()}
    report = workbook.check(planted.save(tmp_path / "hand.xlsx", cells))
    assert report.right, report


# Layouts.


def _elements(sign=1):
    return [
        Rotation.from_euler(axis, sign * a, degrees=True).as_matrix().T
        for axis, a in zip("ZXZ", ANGLES, strict=True)
    ]


def _write(sheet, corner, matrix):
    for (r, c), number in np.ndenumerate(np.atleast_2d(matrix)):
        sheet[corner].offset(r, c).value = float(number)


def _source_000(path):
    """Both methods side by side and below each other, as source 000 tells them: numbers only, curly primes."""
    book = openpyxl.Workbook()
    sheet = book.active
    a, b, c = _elements()
    for top, sign in ((1, 1), (21, -1)):
        for n in range(3):
            sheet.cell(top, 1 + 2 * n, "αβγ"[n])
            sheet.cell(top, 2 + 2 * n, sign * ANGLES[n])
            sheet.cell(top + 3, 1 + 4 * n, f"矩阵{'αβγ'[n]}")
            _write(sheet, sheet.cell(top + 4, 1 + 4 * n).coordinate, _elements(sign)[n])
    for n in range(3):
        sheet.cell(2, 1 + 2 * n, "xyz"[n])
        sheet.cell(2, 2 + 2 * n, POINT[n])
    blocks = {"A9": ("矩阵γβ", c @ b), "E9": ("矩阵γβα", c @ b @ a)}
    d, e, f = _elements(-1)
    blocks |= {"A29": ("矩阵αβ", d @ e), "E29": ("矩阵αβγ", d @ e @ f), "I29": ("转置矩阵αβγ", (d @ e @ f).T)}
    for corner, (label, matrix) in blocks.items():
        sheet[corner] = label
        _write(sheet, sheet[corner].offset(1, 0).coordinate, matrix)
    for corner in ("I10", "M30"):
        for n, number in enumerate(c @ b @ a @ POINT):
            sheet[corner].offset(n, 0).value = f"{'xyz'[n]}‘"
            sheet[corner].offset(n, 1).value = float(number)
    book.save(path)
    return sheet, book


def test_the_layout_of_source_000(tmp_path):
    path = tmp_path / "source.xlsx"
    sheet, book = _source_000(path)
    report = workbook.check(path)
    assert report.right and len(report.cells) == 114
    sheet["F11"] = 0.3
    book.save(path)
    report = workbook.check(path)
    assert (report.first.cell, report.first.role) == ("Sheet!F11", "matrix γβα, row 2, column 2")
    assert report.first.difference == pytest.approx(0.3 - np.sqrt(0.5))


def test_cells_that_the_caller_names(tmp_path):
    book = openpyxl.Workbook()
    a, b, c = _elements()
    _write(book.active, "A1", np.array([ANGLES]).T)
    _write(book.active, "C1", [POINT])
    _write(book.active, "C3", c @ b @ a)
    _write(book.active, "H1", np.array([(c @ b @ a).T @ POINT]).T)
    book.save(tmp_path / "bare.xlsx")
    cells = {"angles": "A1:A3", "point": "C1:E1", "gamma beta alpha": "C3:E5", "result": "Sheet!H1:H3"}
    report = workbook.check(tmp_path / "bare.xlsx", cells=cells)
    assert report.first.cell == "Sheet!H1" and {"row", "transpose"} & set(report.kinds)
    assert report.detective.misreadings[0].kinds == ("transpose",)
    with pytest.raises(InputError, match="none"):
        workbook.check(tmp_path / "bare.xlsx")
    for bad in ({"angles": "A1:A4"}, {"nonsense": "A1"}, {"angles": "there"}, {"angles": "No!A1:A3"}):
        with pytest.raises(InputError):
            workbook.check(tmp_path / "bare.xlsx", cells={**cells, **bad})


def test_named_ranges(tmp_path):
    layout = planted.Layout(np.random.default_rng(1), ANGLES, POINT)
    cells = {a: v for a, v in layout.cells.items() if not (isinstance(v, str) and not v.startswith("="))}
    names = [
        (name, f"Sheet1!${a[0]}${a[1:]}") for name, a in zip(("alpha", "beta", "gamma"), layout.angles, strict=True)
    ]
    names += [(name, f"Sheet1!${a[0]}${a[1:]}") for name, a in zip("xyz", layout.point, strict=True)]
    block = layout.whole
    names.append(("gamma_beta_alpha", f"Sheet1!$A${block[0][0][1:]}:$C${block[2][2][1:]}"))
    path = planted.save(tmp_path / "named.xlsx", cells, names=names)
    assert len(workbook.check(path).cells) == 15
    cells[block[1][1]] = 0.5
    if isinstance(cells[block[0][0]], tuple):
        del cells[block[0][0]]
    assert not workbook.check(planted.save(path, cells, names=names, values_only=True)).right


def test_merged_cells(tmp_path):
    path = tmp_path / "merged.xlsx"
    sheet, book = _source_000(path)
    for span in ("A4:C4", "E9:G9", "A29:C29"):
        sheet.merge_cells(span)
    book.save(path)
    assert len(workbook.check(path).cells) == 114


# The template.


@needs_office
@pytest.mark.parametrize("angles", [ANGLES, (0, 0, 0), (-33.3, 100, 271.25)])
def test_the_template_recalculated_equals_the_package_and_survives_a_save(tmp_path, angles):
    workbook.template(tmp_path / "t.xlsx", angles=angles, point=(1.5, -2, 7))
    once = recalculate(tmp_path / "t.xlsx", tmp_path)
    twice = tmp_path / "again"
    twice.mkdir()
    for path in (once, recalculate(once, twice)):
        report = workbook.check(path)
        assert report.right and len(report.cells) == 126
        assert max(abs(cell.difference) for cell in report.cells) < 1e-12
        expected = Rotation.from_euler("ZXZ", angles, degrees=True).as_matrix().T @ (1.5, -2, 7)
        outcome = [cell.written for cell in report.cells if cell.role in ("x'", "y'", "z'")]
        np.testing.assert_allclose(outcome, [*expected, *expected], atol=1e-12)


def test_a_blank_template_is_empty_in_its_first_cell(tmp_path):
    workbook.template(tmp_path / "blank.xlsx", blank=True)
    report = workbook.check(tmp_path / "blank.xlsx")
    assert (report.kind, report.first.cell) == ("empty", "ZXZ!C10")


@needs_office
def test_uncalculated_formulas_are_calculated(tmp_path):
    workbook.template(tmp_path / "t.xlsx")
    assert workbook.check(tmp_path / "t.xlsx").right


def test_uncalculated_formulas_are_refused_without_libreoffice(tmp_path, monkeypatch):
    workbook.template(tmp_path / "t.xlsx")
    monkeypatch.setenv("PATH", "")
    with pytest.raises(InputError, match="install LibreOffice"):
        workbook.check(tmp_path / "t.xlsx")


def test_template_refuses(tmp_path):
    with pytest.raises(InputError):
        workbook.template(tmp_path / "t.xlsx", angles=(1, 2))
    with pytest.raises(InputError):
        workbook.template(tmp_path / "t.ods")
    with pytest.raises(OutputError):
        workbook.template(tmp_path / "no" / "t.xlsx")


@pytest.mark.parametrize(
    ("name", "cell", "kind"),
    [
        ("active_elements", "B14", "active"),
        ("wrong_order", "B20", "order"),
        ("radians_forgotten", "G10", "unit"),
        ("missing_transpose", "J38", "transpose"),
        ("typed_sign", "F21", "sign"),
    ],
)
def test_the_workbooks_of_the_lesson(name, cell, kind):
    report = workbook.check(DATA / f"workbooks/{name}.xlsx")
    assert (report.first.cell, report.kind) == (f"ZXZ!{cell}", kind)
    assert len(list((DATA / "workbooks").glob("*.xlsx"))) == 6


def test_the_task_may_be_given(tmp_path):
    # The cell says 54.7356, which is right to its digits.
    assert workbook.check(RIGHT, angles=(135, 54.735610317, -90), point=POINT).right
    layout = planted.Layout(np.random.default_rng(1), (135, 55, -90), POINT)
    report = workbook.check(planted.save(tmp_path / "rounded.xlsx", layout.cells), angles=ANGLES)
    assert (report.first.cell, report.kind) == (f"Sheet1!{layout.angles[1]}", "rounded")
    assert {cell.status for cell in report.cells if cell.role == "cos β"} == {"consequence"}
    assert workbook.check(RIGHT, angles=(135, -54.7356, -90)).kind == "sign"


# Tables of NC words.


def test_table_2_of_source_002(dmu50v):
    report = workbook.check_table(DATA / "tables/source_002_table_2.xlsx", dmu50v.machine)
    status = {letter: {c.status for c in report.cells if c.role.endswith(letter)} for letter in "XYZBC"}
    # X Y Z reproduce with the table's own C, which is wrong in every row.
    assert status == {letter: {"consequence"} for letter in "XYZ"} | {"B": {"right"}, "C": {"wrong"}}
    assert report.kind == "unexplained" and "C: no misreading" in report.why


def _table(path, kin, spoil=lambda rows: rows, headings=None):
    rng = np.random.default_rng(4)
    axis = kin.forward(np.hstack([np.zeros((8, 3)), rng.uniform(15, 70, (8, 2))]), degrees=True)[1].round(6)
    tip = rng.uniform(-40, 40, (8, 3)).round(4)
    joints = kin.inverse(tip, axis, degrees=True)[np.arange(8), rng.integers(0, 2, 8)].round(3)
    joints[:, 4] += 360 * rng.integers(-1, 2, 8)
    book = openpyxl.Workbook()
    book.active.append(headings or [*"xyzijk", *kin.machine.joint_names])
    for row in spoil(np.hstack([tip, axis, joints])):
        book.active.append([float(number) for number in row])
    book.save(path)
    return path


def test_tables_of_any_machine(kin, tmp_path):
    path = tmp_path / "table.xlsx"
    for headings in (None, [*"XYZIJK", *kin.machine.joint_names]):
        assert workbook.check_table(_table(path, kin, headings=headings), kin.machine).right

    def typo(rows):
        rows[3, 7] += 1
        return rows

    report = workbook.check_table(_table(path, kin, typo), kin.machine)
    assert (report.first.cell, report.counts()["wrong"]) == ("Sheet!H5", 1)

    def other_angle(rows):
        rows[5, 10] += 7.5
        return rows

    report = workbook.check_table(_table(path, kin, other_angle), kin.machine)
    assert report.first.role == f"row 7, {kin.machine.joint_names[4]}"


def test_a_table_of_records_and_blocks_as_text(tmp_path, dmu50v):
    book = openpyxl.Workbook()
    book.active.append(["CATIA", "iTNC"])
    text = "GOTO/50.31991, 58.40925, 52.13969, 0.145196, 0.000000, 0.989403"
    book.active.append([text, "40 L X–36.781 Y-68.575 Z66.134 B11.817 C175.815"])
    book.save(tmp_path / "text.xlsx")
    assert workbook.check_table(tmp_path / "text.xlsx", dmu50v.machine).right


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
    assert [row[:4] for row in summary.rows] == [
        ("anna.xlsx", "right", "", ""),
        ("chris.xlsx", "unreadable", "", ""),
        (str(os.path.join("group", "bo.xlsx")), "wrong", "ZXZ!B20", "order"),
    ]
    assert seen == [(1, 3), (2, 3), (3, 3)]
    assert sorted(p.name for p in (folder / "marked").rglob("*.xlsx")) == ["anna.xlsx", "bo.xlsx"]
    assert (
        not summary.right
        and "1 right, 1 unreadable, 1 wrong" in str(summary)
        and "<table>" in summary._repr_html_()
    )
    assert len(workbook.check_folder(folder, marked=folder / "marked").rows) == 3
    with pytest.raises(InputError):
        workbook.check_folder(tmp_path / "nowhere")


def test_marked_copies(tmp_path):
    original = (DATA / "workbooks/wrong_order.xlsx").read_bytes()
    shutil.copy(DATA / "workbooks/wrong_order.xlsx", tmp_path / "w.xlsx")
    report = workbook.check(tmp_path / "w.xlsx")
    workbook.mark(report, tmp_path / "out" / "marked.xlsx")
    sheet = openpyxl.load_workbook(tmp_path / "out" / "marked.xlsx")["ZXZ"]
    assert sheet["B20"].fill.fgColor.rgb.endswith("FFC7CE") and "order" in sheet["B20"].comment.text
    assert sheet["A14"].fill.fgColor.rgb.endswith("C6EFCE") and sheet["A14"].comment is None
    assert sheet["E20"].fill.fgColor.rgb.endswith("FFEB9C")
    assert "MMULT" in sheet["A20"].value.text
    assert (tmp_path / "w.xlsx").read_bytes() == original
    with pytest.raises(OutputError, match="original"):
        workbook.mark(report, tmp_path / "w.xlsx")


def test_the_shell(tmp_path, capsys):
    assert main(["check", str(RIGHT)]) == 0
    assert main(["check", str(DATA / "workbooks/typed_sign.xlsx"), "--marked", str(tmp_path / "m.xlsx")]) == 1
    assert "ZXZ!F21" in capsys.readouterr().out and (tmp_path / "m.xlsx").exists()
    assert main(["check", str(tmp_path / "none.xlsx")]) == 2
    assert "none.xlsx" in capsys.readouterr().err
    assert main(["check", str(_folder(tmp_path))]) == 2
    assert "1 right, 1 unreadable, 1 wrong" in capsys.readouterr().out
    table, machine = str(DATA / "tables/source_002_table_2.xlsx"), str(DATA / "machines/dmu50v.toml")
    assert main(["check", table, "--machine", machine]) == 1
    cells = "tip=B2:D6,axis=E2:G6,joints=H2:L6"
    assert main(["check", table, "--machine", machine, "--cells", cells]) == 1
    with pytest.raises(SystemExit):
        main(["check", str(RIGHT), "--cells", "angles"])


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
        workbook.check(_with_member(tmp_path / "bad.xlsx", name, content))


def test_external_links_are_named(tmp_path):
    path = _with_member(tmp_path / "l.xlsx", "xl/externalLinks/externalLink1.xml", b"<x/>")
    with zipfile.ZipFile(path, "a") as archive:
        archive.writestr("xl/externalLinks/_rels/externalLink1.xml.rels", '<R Target="prices.xlsx"/>')
    with pytest.raises(InputError, match="a link to prices.xlsx"):
        workbook.check(path)


@pytest.mark.parametrize("formula", ['=WEBSERVICE("http://example.org")', "='[other.xlsx]S'!A1"])
def test_formulas_that_reach_outside_are_refused(tmp_path, formula):
    book = openpyxl.Workbook()
    book.active["A1"] = formula
    book.save(tmp_path / "outside.xlsx")
    with pytest.raises(InputError, match="Sheet!A1"):
        workbook.check(tmp_path / "outside.xlsx")


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"hello", "another kind of file"),
        (b"", "another kind of file"),
        (bytes.fromhex("d0cf11e0a1b11ae1") + "EncryptedPackage".encode("utf-16-le"), "encrypted"),
        (bytes.fromhex("d0cf11e0a1b11ae1") + bytes(100), "old binary workbook"),
    ],
)
def test_what_is_no_workbook(tmp_path, content, said):
    (tmp_path / "no.xlsx").write_bytes(content)
    with pytest.raises(InputError, match=said):
        workbook.check(tmp_path / "no.xlsx")


def test_cut_and_spoilt_files(tmp_path):
    whole = RIGHT.read_bytes()
    (tmp_path / "cut.xlsx").write_bytes(whole[: len(whole) // 2])
    with pytest.raises(InputError):
        workbook.check(tmp_path / "cut.xlsx")
    with zipfile.ZipFile(RIGHT) as source, zipfile.ZipFile(tmp_path / "xml.xlsx", "w") as target:
        for name in source.namelist():
            data = source.read(name)
            target.writestr(name, data[:-40] if "sheet1.xml" in name else data)
    with pytest.raises(InputError, match="cannot be read"):
        workbook.check(tmp_path / "xml.xlsx")


def _edited(tmp_path, cell, content):
    sheet, book = _source_000(tmp_path / "edited.xlsx")
    sheet[cell] = content
    book.save(tmp_path / "edited.xlsx")
    return tmp_path / "edited.xlsx"


def test_text_where_a_number_belongs(tmp_path):
    with pytest.raises(InputError, match=r"Sheet!B1 \(α\)"):
        workbook.check(_edited(tmp_path, "B1", "135°"))
    report = workbook.check(_edited(tmp_path, "B6", "-0,7071"))
    assert (report.first.cell, report.kind, report.counts()["wrong"]) == ("Sheet!B6", "text", 1)
    report = workbook.check(_edited(tmp_path, "B6", None))
    assert (report.first.cell, report.kind) == ("Sheet!B6", "empty")


def test_error_values(tmp_path):
    sheet, book = _source_000(tmp_path / "e.xlsx")
    for cell in ("B6", "F11", "J11"):
        sheet[cell] = "#VALUE!"
    book.save(tmp_path / "e.xlsx")
    report = workbook.check(tmp_path / "e.xlsx")
    assert (report.first.cell, report.kind, report.first.written) == ("Sheet!B6", "error", "#VALUE!")
    assert report.counts()["wrong"] == 1


def test_an_empty_sheet(tmp_path):
    openpyxl.Workbook().save(tmp_path / "empty.xlsx")
    with pytest.raises(InputError, match="only empty ones"):
        workbook.check(tmp_path / "empty.xlsx")


READ_HUGE = r"""
import re, sys
from pathlib import Path
from mathpost import workbook

report = workbook.check(sys.argv[1])
assert report.right and len(report.cells) == 126 and "first 2000 rows" in report.notes[0], report
status = Path("/proc/self/status")  # Linux; elsewhere only the time is limited
peak = re.search(r"VmHWM:\s*(\d+) kB", status.read_text()) if status.exists() else None
assert peak is None or int(peak[1]) < 400_000, peak
"""


def test_a_huge_sheet_is_read_to_the_limit_in_bounded_memory(tmp_path):
    """A million rows below a right calculation: written as bare XML, read in a process whose memory is limited."""
    path = tmp_path / "huge.xlsx"
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
                    for start in range(100, 1_000_100, 10_000):
                        rows = (
                            f'<row r="{r}"><c r="A{r}"><v>{r}.5</v></c></row>' for r in range(start, start + 10_000)
                        )
                        part.write("".join(rows).encode())
                    part.write(b"</sheetData>" + tail)
            else:
                target.writestr(name, data)
    subprocess.run([sys.executable, "-c", READ_HUGE, str(path)], check=True, cwd=ROOT, timeout=60)


def test_the_template_is_found_by_its_names_after_rows_were_moved():
    found = find(read(RIGHT))
    assert {each.section for each in found} == {None, 0, 1}
