"""The check of spreadsheets against sheets that strangers make, and slips at places drawn at random.

`python -m tests.workbook.score` runs as many as one likes and prints a table.
"""

import shutil
from dataclasses import replace
from itertools import islice

import numpy as np
import pytest

from mathpost.errors import InputError
from mathpost.workbook import Task, check_file
from mathpost.workbook.sheet.file import read
from mathpost.workbook.sheet.graph import Graph
from tests.workbook import layouts, machining_sheets, mistakes, score
from tests.workbook.cells import SAMPLES, Array, Book, Values, address, formula_of, letters, save

NOT_JUDGED = (  # slips of the whole sample that are listed, not called wrong
    "Matrices!B10: =MMULT(L6:N8,G6:I8) → =MMULT(M5:O7,G6:I8)",
    "Eingabe!E8: =COS(D3/57.29577951308232) → -0.9762",
)


@pytest.fixture(scope="module")
def results(tmp_path_factory, of):
    """(case, counts, what was said) of a sample."""
    path, found = tmp_path_factory.mktemp("planted") / "sheet.xlsx", []
    for case in score.draw_cases(2, of(48, 400)):
        save(path, case.book, case.values)
        found.append((case, *score.judge(case, path)))
    return found


@pytest.fixture(scope="module")
def source_cases(of):
    """Moved references in the source's sheet, by recipe."""
    return {recipe: list(islice(score.source_cases(recipe, of(9, 1)), of(200, None))) for recipe in (1, 2)}


def told(results):
    return "\n".join(f"{case.book.family}, {case.kind}: {case.planted()}: {said}" for case, _, said in results)


def test_no_silent_pass_and_no_false_alarm(results):
    wrong = [result for result in results if result[1] - {"first cell", "cause", "unclear"}]
    assert not wrong, told(wrong)
    unclear = [result for result in results if "unclear" in result[1] and result[0].planted() not in NOT_JUDGED]
    assert not unclear, told(unclear)


def test_the_first_wrong_cell_and_the_cause_are_named(results):
    located = [result for result in results if result[0].slip.verdict == "wrong"]
    assert len(located) > len(results) / 2
    for what, share in (("first cell", 0.98), ("cause", 0.95)):
        missed = [result for result in located if what not in result[1]]
        assert len(missed) <= (1 - share) * len(located), told(missed)


@pytest.mark.parametrize("recipe", [1, 2])
def test_moved_references_in_the_sheet_of_the_source_are_found(source_cases, recipe, tmp_path, of):
    """A sample; `python -m tests.workbook.score --source` moves every reference to every neighbouring cell."""
    path, cases = tmp_path / "sheet.xlsx", source_cases[recipe]
    for number in np.random.default_rng(3).choice(len(cases), of(12, 100), replace=False):
        case = cases[number]
        save(path, case.book, case.values)
        counts, said = score.judge(case, path)
        assert not counts & {"silent passes", "false alarms", "refused", "crashed"}, f"{case.planted()}: {said}"
        if case.slip.verdict == "right":  # a cell that always has the same value, zero times anything
            assert "always the same" in said, f"{case.planted()}: {said}"


@pytest.mark.parametrize("author", [layouts.matrix_sheet, layouts.two_tables])
def test_a_slip_in_an_elementary_matrix_is_found_there(author, tmp_path, of):
    """Not in the product that uses it, even where the spoiled cell goes into a single coordinate."""
    rng, path, seen = np.random.default_rng(5), tmp_path / "sheet.xlsx", 0
    for _ in range(of(3, 12)):
        book = author(rng)
        values = Values(book)
        slips = [
            c for c in mistakes.candidates(book, values) if c[0] in ("degrees for radians", "typed over formula")
        ]
        slips = [c for c in slips if "COS(" in (formula_of(book.cells[next(iter(c[1]))]) or "")]
        for number in rng.permutation(len(slips))[:4]:
            slip = mistakes.judge(book, values, *slips[number])
            if slip and slip.verdict == "wrong":
                case = score.make_case("slip", book, slip, values)
                save(path, case.book, case.values)
                counts, said = score.judge(case, path)
                assert "first cell" in counts, f"{case.planted()}: {said}"
                seen += 1
    assert seen > 4


@pytest.mark.parametrize("seed", range(4))
def test_all_dollars_lost_at_once_are_named(seed, tmp_path):
    """In the last row of a table of points."""
    book = layouts.many_points(np.random.default_rng(seed))
    values, path = Values(book), tmp_path / "sheet.xlsx"
    *_, changes = (changes for cause, changes in mistakes.wide_slips(book) if cause == "missing $")
    case = score.make_case("slip", book, mistakes.judge(book, values, "missing $", changes), values)
    save(path, case.book, case.values)
    counts, said = score.judge(case, path)
    assert counts == {"first cell", "cause"}, f"{case.planted()}: {said}"


@pytest.mark.parametrize("seed", [3, 4, 5])
def test_two_angles_wrong_in_one_formula(seed, tmp_path):
    """Both references to γ in a product of sines and cosines are made α."""
    book, path = layouts.direct_elements(np.random.default_rng(seed)), tmp_path / "sheet.xlsx"
    values, (first, _, last) = Values(book), (f"${letters(k[2])}${k[1]}" for k in book.inputs[0][0])
    key = next(key for key in book.formulas() if formula_of(book.cells[key]).count(last) == 2)
    slip = mistakes.judge(book, values, "wrong angle", {key: formula_of(book.cells[key]).replace(last, first)})
    case = score.make_case("slip", book, slip, values)
    save(path, case.book, case.values)
    counts, said = score.judge(case, path)
    assert counts == {"first cell", "cause"}, f"{case.planted()}: {said}"


def test_the_sheet_of_the_source_has_lucky_references(source_cases):
    """At the source's own angles many wrong references leave every value as it is: numbers alone do not tell."""
    lucky, cases = 0, source_cases[1]
    right = Values(cases[0].original).all()
    for case in cases:
        if case.slip.verdict == "wrong":
            lucky += all(abs(case.values[key][0] - right[key][0]) < 1e-9 for key in case.book.truths[-1][0])
    assert lucky > 0.05 * len(cases)


def test_the_graph_has_the_values_that_the_generator_has(tmp_path, of):
    """Every formula of right and spoiled sheets at random inputs; LibreOffice, below, agrees."""
    compared = 0
    for case in score.draw_cases(6, of(40, 300)):
        path = tmp_path / "sheet.xlsx"
        save(path, case.book, case.values)
        inputs = {key: case.values[key] for key in case.book.input_cells()}
        found = Graph(read(path)).run(inputs)
        for key in case.book.formulas():
            for cell in mistakes.spilled(case.book, key):
                value = case.values[cell]
                if not isinstance(value, str) and np.isfinite(value).all() and case.slip.verdict != "not right":
                    np.testing.assert_allclose(
                        np.broadcast_to(found[cell], value.shape),
                        value,
                        rtol=1e-9,
                        atol=1e-9,
                        err_msg=case.planted(),
                    )
                    compared += 1
    assert compared > 1000


def test_zeros_left_blank_in_a_product_of_matrices_do_not_pass(tmp_path):
    """MMULT refuses an empty cell: the spreadsheet shows #VALUE!, whatever the product would be."""
    for seed in range(40):
        book = layouts.matrix_sheet(np.random.default_rng(seed))
        blank = [key for matrix in book.turned for key in matrix if book.cells.get(key) == 0]
        if any("MMULT" in (formula_of(content) or "") for content in book.cells.values()):
            break
    for key in blank:
        del book.cells[key]
    values = Values(book).all()
    assert not all(np.isfinite(values[key]).all() for key in book.truths[0][0])
    save(tmp_path / "blank.xlsx", book, values)
    assert check_file(tmp_path / "blank.xlsx", Task(**book.task)).verdict != "right"


@pytest.mark.parametrize(("seed", "sequence", "convention"), [(0, "zyx", "active"), (1, "ZYZ", "passive")])
def test_a_reading_that_nobody_named_is_named(seed, sequence, convention, tmp_path):
    path = tmp_path / "sheet.xlsx"
    save(path, layouts.unnamed_reading(np.random.default_rng(seed)))
    report = check_file(path)
    assert report.status == 2 and f"--sequence {sequence} --convention {convention}" in str(report)
    assert check_file(path, Task(sequence=sequence, convention=convention)).verdict == "right"


def test_a_layout_that_is_not_known_gets_a_line_to_say_where_things_stand(tmp_path):
    path = tmp_path / "sheet.xlsx"
    numbers = {("S", row, column): 1.5 * row + column for row in (2, 3, 4) for column in (2, 4, 6)}
    save(path, Book(numbers))
    report = check_file(path)
    assert report.status == 2 and "--cells 'angles=S!B2:B4,point=S!D2:D4,result=S!F2:F4'" in str(report)


def test_an_input_that_is_no_number_is_refused_by_its_cell(tmp_path):
    book, path = machining_sheets.nc_table(np.random.default_rng(1)), tmp_path / "sheet.xlsx"
    key = book.inputs[-1][0][0]
    save(path, replace(book, cells={**book.cells, key: "n/a"}), {**Values(book).all(), key: "n/a"})
    with pytest.raises(InputError, match=f"{address(key)}: expected a number, found 'n/a'"):
        check_file(path, Task(**book.task))


# The generator itself.


@pytest.mark.parametrize("author", score.AUTHORS, ids=lambda author: author.__name__)
def test_right_sheets_give_what_scipy_gives(author, of):
    for seed in range(of(6, 60)):
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
def test_the_values_agree_with_those_of_libreoffice(of):
    cases = [case for case in score.draw_cases(4, of(60, 300)) if not case.slip.cause]
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
