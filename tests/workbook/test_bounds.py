"""Large and odd workbooks: the work grows as the cells do, and what is too large is said to be, with the figure."""

import openpyxl
import pytest

from mathpost.teaching import workbook as room
from mathpost.teaching.workbook import check_file, check_folder
from mathpost.teaching.workbook.sheet import cells, links
from mathpost.teaching.workbook.sheet.formula import NotUnderstood, parse
from mathpost.teaching.workbook.sheet.graph import Graph
from tests.workbook.test_strangers import SHEETS, workbook


def rows_of(kind, count):
    """Cells of a page of `count` formulas, by address."""
    if kind == "running totals":
        return {f"A{r}": 1.5 * r for r in range(1, count + 1)} | {
            f"B{r}": f"=SUM(A$1:A{r})" for r in range(1, count + 1)
        }
    if kind == "a chain":
        return {"A1": 1.5} | {f"A{r}": f"=A{r - 1}+1" for r in range(2, count + 2)}
    if kind == "plain formulas":
        return {f"A{r}": 1.5 * r for r in range(1, count + 1)} | {f"B{r}": f"=A{r}*2" for r in range(1, count + 1)}
    return {f"A{r}": f"=Sheet1!E$20*{r}" for r in range(1, count + 1)}  # made of the result


def checked(path, more, monkeypatch, page="More"):
    """The report of a right sheet with more cells, and the steps from cell to cell that the check took."""
    book, made = workbook(SHEETS["u001"]), []
    sheet = book[page] if page in book.sheetnames else book.create_sheet(page)
    for address, content in more.items():
        sheet[address] = content
    book.save(path)
    begin = Graph.__init__
    monkeypatch.setattr(Graph, "__init__", lambda self, *given: (made.append(self), begin(self, *given))[1])
    report = check_file(path)
    return report, sum(graph.work for graph in made)


@pytest.mark.parametrize("kind", ["running totals", "a chain", "plain formulas", "of a result"])
def test_the_work_grows_as_the_cells_do(kind, tmp_path, monkeypatch):
    work = {}
    for count in (400, 1600):
        report, work[count] = checked(tmp_path / "large.xlsx", rows_of(kind, count), monkeypatch)
        result = [cell.status for cell in report.cells if cell.cell in ("Sheet1!E20", "Sheet1!E21", "Sheet1!E22")]
        assert result == ["right"] * 3 and report.verdict == "not judged" and not report.faults
    assert work[1600] < 6 * work[400]


def test_six_thousand_running_totals_refer_to_few_cells(tmp_path, monkeypatch):
    report, work = checked(tmp_path / "large.xlsx", rows_of("running totals", 6000), monkeypatch)
    assert work < 500_000 and report.verdict == "not judged"


def test_what_is_too_large_is_said_with_the_figure(tmp_path, monkeypatch):
    monkeypatch.setattr(links, "MOST_FORMULAS", 1000)
    report, _ = checked(tmp_path / "large.xlsx", rows_of("of a result", 1200), monkeypatch)
    assert report.status == 2 and report.seen == ["not judged: too large (1228 formulas)"]
    monkeypatch.setattr(cells, "WORK", 1000)
    report, _ = checked(tmp_path / "small.xlsx", {}, monkeypatch)
    assert report.seen[0].startswith("not judged: too large (more than")


@pytest.mark.parametrize(
    "formula",
    [
        "=" + "(" * 500 + "E20" + ")" * 500,
        "=" + "-" * 500 + "E20",
        "=" + "+".join(["E20"] * 1500),
        "=" + "SIN(" * 300 + "E20" + ")" * 300,
        "=E20" + "^2" * 1000,
        "=" + "E20*" * 4000 + "1",
    ],
)
def test_a_deep_or_long_formula_is_listed_and_the_others_are_judged(formula, tmp_path, monkeypatch):
    report, _ = checked(tmp_path / "deep.xlsx", {"K1": formula}, monkeypatch, "Sheet1")
    assert report.not_checked == ["Sheet1!K1"] and report.checked == 28


def test_names_in_names_do_not_multiply():
    names = {f"NAME{k}": f"=NAME{k + 1}+NAME{k + 1}" for k in range(60)} | {"NAME60": "=1"}
    with pytest.raises(NotUnderstood, match="levels or"):
        parse("=NAME0", "S", names)


def test_one_bad_file_never_ends_the_check_of_a_folder(tmp_path, monkeypatch):
    for name in ("a", "b", "c"):
        workbook(SHEETS["u001"]).save(tmp_path / f"{name}.xlsx")
    (tmp_path / "d.xlsx").write_bytes(b"PK\x03\x04 no archive")

    def fails(path, task):
        if path.name == "b.xlsx":
            raise RecursionError("too deep")
        return check_file(path, task)

    monkeypatch.setattr(room.folder, "check_file", fails)
    summary = check_folder(tmp_path)
    assert [row[1] for row in summary.rows] == ["right", "not judged", "right", "not read"] and summary.status == 2
    assert "internal error, please report: RecursionError" in summary.rows[1][-1]


def test_many_cells_that_depend_on_themselves(tmp_path, monkeypatch):
    circles = {f"K{r}": f"=K{r}+1" for r in range(1, 400)}
    report, _ = checked(tmp_path / "circles.xlsx", circles, monkeypatch, "Sheet1")
    assert report.verdict == "not judged"


def test_a_cell_read_twice_is_one_number(tmp_path):
    """Of running totals that are read as sums of the one before, one that starts again is still its own."""
    book = openpyxl.Workbook()
    for row in range(1, 41):
        book.active[f"A{row}"] = row
        book.active[f"B{row}"] = f"=SUM(A${1 if row < 30 else 2}:A{row})"
    book.save(tmp_path / "sums.xlsx")
    own = Graph(room.folder.read(tmp_path / "sums.xlsx")).own
    assert [own["Sheet", r, 2] for r in (20, 29, 30, 40)] == [210, 435, 464, 819]
