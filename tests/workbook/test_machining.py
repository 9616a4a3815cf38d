"""Tables of NC words, tilted planes and plain numbers, laid out as strangers do."""

import re

import numpy as np
import openpyxl
import pytest

from mathpost import load_machine
from mathpost.errors import InputError
from mathpost.kinematics import Kinematics
from mathpost.teaching.workbook import Task, check_file
from mathpost.teaching.workbook.sheet.formula import parse
from tests.workbook.cells import Book, Values, address, letters, save
from tests.workbook.machining_sheets import MACHINES, TABLES, first_in_file, forward, order_of
from tests.workbook.test_strangers import ROOT

ROWS = 5
UNIT = {n: f"({{{n}}}/SQRT({{i}}^2+{{j}}^2+{{k}}^2))" for n in "ijk"}


def in_rows(n, k):
    return "S", n + 3, k + 2


def with_gaps(n, k):
    return "S", n + 3, 1 + k + (k >= 3) + (k >= 6)


def words_first(n, k):
    return "S", n + 3, 40 - k


LAYOUTS = {
    "in rows": ("dmu50v", in_rows, "xyzijk", "{}", 1),
    "blank columns": ("head_b_table_c", with_gaps, "xyzijk", "{}", 1),
    "from right to left": ("ac_head", words_first, "xyzijk", "{}", 1),
    "rounded": ("ac_table", in_rows, "xyzijk", "ROUND({},3)", 1),
    "from 0 to 360": ("bc_table", in_rows, "xyzijk", "ROUND(MOD({},360),4)", 1),
    "normals of any length": ("ac_head", in_rows, "xyzijk", "{}", 2.5),
}


def table(layout):
    """The cells of a table of NC words, and of each row the places of its words."""
    name, place, headings, form, length = LAYOUTS[layout]
    constants, angles, helpers, words = TABLES[name]
    turns = order_of(name, angles, np.linspace(20, 40, ROWS), np.linspace(-30, 60, ROWS))
    rng = np.random.default_rng(7)
    cl = forward(name, rng.uniform(-40, 40, (3, ROWS)), turns)
    cl[3:] *= length
    names = [*angles, *helpers, *words]
    rows = []
    cells = {place(-1, k): text for k, text in enumerate([*headings, *names])}
    for n in range(ROWS):
        found = {place(n, k): round(float(cl[k, n]), 5) for k in range(6)}
        refs = {letter: address(place(n, k)) for k, letter in enumerate("xyzijk")}
        units = {letter: UNIT[letter].format(**refs) for letter in "ijk"} if length != 1 else {}
        refs |= units | {key: str(value) for key, value in constants.items()}
        refs |= {word: address(place(n, 6 + k)) for k, word in enumerate(names)}
        for k, (word, formula) in enumerate((*angles.items(), *helpers.items(), *words.items())):
            turned = form if word in angles else form.replace("MOD({},360)", "{}")
            text = formula.format(**refs)[1:]
            found[place(n, 6 + k)] = f"={text}" if word in helpers else f"={turned.format(text)}"
        cells |= found
        rows.append({word: place(n, 6 + k) for k, word in enumerate(names)})
    return cells, rows, Task(machine=MACHINES / f"{name}.toml")


def checked(path, cells, task=None):
    book = Book(cells)
    save(path, book, Values(book).all())
    return check_file(path, task)


@pytest.mark.parametrize("layout", LAYOUTS)
def test_a_table_in_any_layout(layout, tmp_path):
    cells, rows, task = table(layout)
    report = checked(tmp_path / "right.xlsx", cells, task)  # by its numbers; what its formulas are is not judged
    assert (report.verdict, report.faults) == ("not judged", []) and "--reference" in str(report), str(report)
    place = rows[2][first_in_file(task.machine.stem)]
    cells[place] += "+0.75"
    report = checked(tmp_path / "wrong.xlsx", cells, task)
    assert (report.verdict, report.faults[0].cell) == ("wrong", address(place))


def numbers(cells, form):
    """The table as numbers, written by `form`."""
    values = Values(Book(cells)).all()
    return {p: v if isinstance(v, str) else form(float(np.ravel(v)[0])) for p, v in values.items()}


@pytest.mark.parametrize("form", [lambda v: round(v, 3), lambda v: float(f"{v:.6g}"), lambda v: v])
@pytest.mark.parametrize("layout", ["in rows", "rounded", "from 0 to 360"])
def test_a_table_of_numbers(layout, form, tmp_path):
    cells, rows, task = table(layout)
    cells = numbers(cells, form)
    report = checked(tmp_path / "right.xlsx", cells, task)
    assert report.verdict == "right", str(report)
    cells[rows[3]["Y"]] += 0.5
    report = checked(tmp_path / "wrong.xlsx", cells, task)
    assert [fault.cell for fault in report.faults] == [address(rows[3]["Y"])]


def test_rotary_words_beyond_travel_are_not_judged(tmp_path):
    """Which branch is meant the machine says; one of words beyond travel is none that it has."""
    for layout, verdict in (("in rows", "not judged"), ("rounded", "right")):  # B from 0 to 180, A from -120 to 120
        cells, rows, task = table(layout)
        tilts = [row["B" if "B" in row else "A"] for row in rows]
        cells |= {p: cells[p].replace("DEGREES", "-DEGREES", 1) for p in tilts}
        if layout == "rounded":
            cells |= {
                row["C"]: re.sub(r"ATAN2\(-([^,]+),([^)]+)", r"ATAN2(\1,-\2", cells[row["C"]]) for row in rows
            }
        report = checked(tmp_path / "sheet.xlsx", numbers(cells, lambda v: round(v, 4)), task)
        assert (report.verdict, report.faults) == (verdict, []), str(report)
        assert ("within its travel" in str(report)) == (verdict == "not judged")


@pytest.mark.parametrize(("layout", "long", "short"), [("blank columns", "300", "250")])
def test_words_of_another_point_of_the_head(layout, long, short, tmp_path):
    """Whatever else is wrong with it: which point is meant is not in the machine file."""
    cells, rows, task = table(layout)
    words = {row[letter] for row in rows for letter in "XYZ"}
    cells |= {p: cells[p].replace(long, short) for p in words}
    said = f"{int(long) - int(short)} mm down the tool axis"
    for form in (lambda cells: cells, lambda cells: numbers(cells, lambda v: round(v, 5))):
        report = checked(tmp_path / "sheet.xlsx", form(cells), task)
        assert (report.verdict, report.faults) == ("not judged", []) and said in str(report), str(report)


def test_at_the_pole_any_angle_is_right_but_there_must_be_one(tmp_path):
    cells, rows, task = table("rounded")
    cells |= dict(zip([in_rows(2, k) for k in (3, 4, 5)], (0, 0, 1), strict=True))
    report = checked(tmp_path / "none.xlsx", cells, task)
    assert report.verdict == "not judged" and "S!B5:G5: numbers that are no row of a table" in str(report)
    for n, row in enumerate(rows):
        i, above = (address(place) for place in (in_rows(n, 3), rows[max(n - 1, 0)]["C"]))
        cells[row["C"]] = f"=IF({i}=0,{above},{cells[row['C']][1:]})" if n else cells[row["C"]]
    assert checked(tmp_path / "kept.xlsx", numbers(cells, lambda v: round(v, 4)), task).verdict == "right"


def test_a_tool_axis_that_is_no_unit_vector_is_warned_of(tmp_path):
    cells, _, task = table("rounded")
    cells["S", 5, 7] += 0.01
    report = checked(tmp_path / "sheet.xlsx", cells, task)
    assert any("no unit vector in row 5" in text for text in report.warnings)


def test_rows_that_are_no_rows_of_the_table_are_said(tmp_path):
    cells, _, task = table("rounded")
    cells = numbers(cells, lambda v: round(v, 3))
    for k in range(13):
        cells[in_rows(ROWS, k)] = min(cells[in_rows(n, k)] for n in range(ROWS))
    cells["S", ROWS + 3, 1] = "min"
    report = checked(tmp_path / "sheet.xlsx", cells, task)
    assert report.verdict == "not judged" and any("no row of a table" in text for text in report.seen)


def test_numbers_beside_a_table_are_said(tmp_path):
    cells, _, task = table("rounded")
    cells = numbers(cells, lambda v: round(v, 4)) | {("S", n + 3, 21): n + 0.123 for n in range(ROWS)}
    report = checked(tmp_path / "said.xlsx", cells, task)
    assert "not looked at: S!J3:J7, S!K3:K7, S!U3:U7" in str(report)


def test_a_function_that_is_not_known_makes_nothing_wrong(tmp_path):
    cells, rows, task = table("rounded")
    save(tmp_path / "sheet.xlsx", Book(cells), Values(Book(cells)).all())
    book = openpyxl.load_workbook(tmp_path / "sheet.xlsx")
    for row in rows:
        _, line, column = row["X"]
        cell = book.active[f"{letters(column)}{line}"]
        cell.value = f"=LET(q,1,q*{cell.value[1:]})"
    book.save(tmp_path / "sheet.xlsx")
    assert check_file(tmp_path / "sheet.xlsx", task).verdict == "not judged"


def test_a_range_may_be_written_backwards():
    assert parse("=SUM(C2:A1)", "S", {}) == parse("=SUM(A1:C2)", "S", {})


@pytest.mark.parametrize("group", [False, True])
def test_tip_and_linear_words_under_each_others_headings_are_not_right(group, tmp_path):
    kinematics = Kinematics(load_machine(ROOT / "data/machines/dmu50v.toml"))
    rng = np.random.default_rng(1)
    tips, axes = rng.uniform(-50, 50, (4, 3)).round(3), np.abs(rng.normal(size=(4, 3)))
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    words = kinematics.inverse(tips, axes, degrees=True)[:, 0].round(6)
    cl, nc = ["x", "y", "z", "i", "j", "k"], ["X", "Y", "Z", "B", "C"]
    for first, second, is_right in (("CL", "NC", True), ("NC", "CL", False)):
        book = openpyxl.Workbook()
        if group:
            book.active.append([first, *[None] * 5, second])
            book.active.append([*cl, *nc])
        else:
            heads = [f"{first} {letter}" for letter in cl[:3]] + cl[3:]
            book.active.append(heads + [f"{second} {letter}" for letter in nc[:3]] + nc[3:])
        for row in np.hstack([tips, axes, words]).tolist():
            book.active.append(row)
        book.save(tmp_path / "table.xlsx")
        report = check_file(tmp_path / "table.xlsx", Task(machine=kinematics.machine))
        assert (report.verdict == "right") == is_right, report


def test_a_machine_with_one_rotary_axis_is_refused_in_a_sentence(tmp_path):
    cells, _, _ = table("rounded")
    path = tmp_path / "sheet.xlsx"
    save(path, Book(cells), Values(Book(cells)).all())
    with pytest.raises(InputError, match="machine: expected a machine with two rotary axes.*Dividing head"):
        check_file(path, Task(machine=ROOT / "data/machines/dividing_head.toml"))
