"""The check of spreadsheets against sheets that strangers make, and slips at places drawn at random.

`python -m tests.workbook.score` runs as many as one likes and prints a table.
"""

import shutil

import numpy as np
import pytest

from mathpost.workbook import check_file
from tests.workbook import layouts, machining_sheets, mistakes, score
from tests.workbook.cells import SAMPLES, Array, Book, Values, formula_of, save

COUNT = 80


@pytest.fixture(scope="module")
def cases():
    return list(score.draw_cases(2, COUNT))


@pytest.mark.parametrize("number", range(COUNT))
def test_a_planted_slip_is_found_and_a_right_sheet_passes(cases, number, tmp_path):
    case = cases[number]
    path = tmp_path / "sheet.xlsx"
    save(path, case.book, case.values)
    counts, said = score.judge(case, path)
    assert not score.bad(case, counts), (
        f"{case.book.family}, {case.kind}: {case.planted()}\n{said}\n{case.slip.causes}"
    )


def moves(recipe):
    """Every single reference of the source's sheet moved to every neighbouring cell, with the truth."""
    book = layouts.source_sheet(recipe)
    values = Values(book)
    for key in book.formulas():
        for cause, formula in mistakes.moved_references(book, key, formula_of(book.cells[key])):
            yield book, values, mistakes.judge(book, values, cause, {key: formula})


@pytest.mark.parametrize("recipe", [1, 2])
@pytest.mark.parametrize("part", range(4))
def test_every_moved_reference_in_the_sheet_of_the_source_is_found(recipe, part, tmp_path):
    path, missed, alarms = tmp_path / "sheet.xlsx", [], []
    for book, values, slip in list(moves(recipe))[part::32]:
        spoiled = slip.applied(book)
        save(path, spoiled, score.spoiled_values(spoiled, values.given))
        found = check_file(path)
        if slip.verdict != "right" and found.verdict == "right":
            missed.append(slip.changes)
        if slip.verdict == "right" and found.verdict == "wrong":
            alarms.append(slip.changes)
    assert not missed and not alarms


def test_the_sheet_of_the_source_has_lucky_references():
    """At the source's own angles many wrong references leave every value as it is: numbers alone do not tell."""
    lucky = 0
    for book, values, slip in moves(1):
        if slip.verdict == "wrong":
            spoiled = score.spoiled_values(slip.applied(book), values.given)
            (result, _) = book.truths[-1]
            lucky += all(abs(spoiled[key][0] - values[key][0]) < 1e-9 for key in result)
    assert lucky > 100


# The generator itself.


@pytest.mark.parametrize("author", score.AUTHORS, ids=lambda author: author.__name__)
def test_right_sheets_give_what_scipy_gives(author):
    for seed in range(12):
        layouts.verify(author(np.random.default_rng(seed)))


@pytest.mark.parametrize("author", score.AUTHORS, ids=lambda author: author.__name__)
def test_the_truth_of_a_sheet_can_fail(author):
    """A minus in front of an input that matters is noticed by the comparison with SciPy."""
    book = author(np.random.default_rng(5))
    result = book.truths[-1][0][-1]
    key = next(key for key in reversed(book.formulas()) if key not in book.extras)
    if author not in (machining_sheets.nc_table, machining_sheets.nc_values):
        key = result if result in book.cells else key
    content = book.cells[key]
    text = "=-(" + formula_of(content)[1:] + ")"
    spoiled = Array(content.rows, content.columns, text) if isinstance(content, Array) else text
    slip = mistakes.Slip("sign", {key: spoiled})
    with pytest.raises(AssertionError):
        layouts.verify(slip.applied(book))


@pytest.mark.skipif(shutil.which("soffice") is None, reason="LibreOffice is not installed")
def test_the_values_agree_with_those_of_libreoffice():
    cases = [case for case in score.draw_cases(4, 150) if not case.slip.cause]
    wrong, compared = score.disagreements(cases)
    assert compared > 1000 and not wrong, wrong[:5]


@pytest.mark.parametrize(
    ("formula", "value"),
    [
        ("=ATAN2(0,1)*180/PI()", 90),  # Excel's order: x first
        ("=MOD(-30,360)", 330),
        ("=ROUND(-2.5,0)", -3),
        ("=SUMPRODUCT(A1:C1,A2:C2)", 32),
        ("=SUM(A1:C1)^2", 36),
        ("=MAX(A1:C2)-A1", 5),
        ("=IF(A1<B1,7,8)", 7),
        ("=MDETERM(A1:B2)", -3),
        ("=$A$1+'Sheet1'!C2", 7),
        ("=A1+D9", 1),
    ],
)
def test_the_evaluator(formula, value):
    cells = {("Sheet1", r, c): r * 3 + c - 3 for r in (1, 2) for c in (1, 2, 3)}
    book = Book({**cells, ("Sheet1", 5, 1): formula})
    np.testing.assert_allclose(Values(book)["Sheet1", 5, 1], np.full(SAMPLES, value), atol=1e-12)
