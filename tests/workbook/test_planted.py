"""The check of spreadsheets against sheets that strangers make, and slips at places drawn at random.

`python -m tests.workbook.score` runs as many as one likes and prints a table.
"""

import shutil

import numpy as np
import pytest

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


@pytest.mark.parametrize("recipe", [1, 2])
def test_moved_references_in_the_sheet_of_the_source_are_found(recipe, tmp_path):
    """A sample; `python -m tests.workbook.score --source` moves every reference to every neighbouring cell."""
    path, cases = tmp_path / "sheet.xlsx", list(score.source_cases(recipe))
    for number in np.random.default_rng(3).choice(len(cases), 20, replace=False):
        case = cases[number]
        save(path, case.book, case.values)
        counts, said = score.judge(case, path)
        assert not counts & {"silent passes", "false alarms", "refused", "crashed"}, f"{case.planted()}: {said}"


def test_the_sheet_of_the_source_has_lucky_references():
    """At the source's own angles many wrong references leave every value as it is: numbers alone do not tell."""
    lucky = 0
    for case in score.source_cases(1):
        if case.slip.verdict == "wrong":
            right = Values(case.original).all()
            lucky += all(abs(case.values[key][0] - right[key][0]) < 1e-9 for key in case.book.truths[-1][0])
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
