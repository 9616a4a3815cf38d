"""What somebody did to the words of a machine is named: in tables and single positions, formulas and numbers."""

import pytest

from tests.workbook.test_headings import as_numbers
from tests.workbook.test_machining import ROWS, checked, table


def pivot(cells, rows, factor):
    """The trunnion's pivot, 50 mm below, times a factor."""
    changed = {
        p: str(cells[p]).replace("+50)", f"+{50 * factor})").replace("-50,", f"-{50 * factor},") for p in cells
    }
    return cells | {row[word]: changed[row[word]] for row in rows for word in "YZ"}


def not_turned(cells, rows):
    """Of the 350 mm of the head 150 are tool, and stay upright."""
    found = {}
    for row in rows:
        found |= {row[word]: cells[row[word]].replace("350*", "200*") for word in "XYZ"}
        found[row["Z"]] += "+150"
    return cells | found


SLIPS = {
    "the pivot of A is taken twice": ("rounded", lambda cells, rows: pivot(cells, rows, 2), "Y", "pivot"),
    "the pivot of A is of the opposite sign": ("rounded", lambda cells, rows: pivot(cells, rows, -1), "Y", "pivot"),
}


@pytest.mark.parametrize("numbers", [False, True])
@pytest.mark.parametrize("count", [1, ROWS])
@pytest.mark.parametrize("phrase", SLIPS)
def test_what_was_done_to_the_words_is_named(phrase, count, numbers, tmp_path):
    layout, slip, first, cause = SLIPS[phrase]
    cells, rows, task = table(layout)
    cells = slip(cells, rows)
    cells = as_numbers(cells) if numbers else cells
    cells = {place: cell for place, cell in cells.items() if place[1] < 3 + count}
    report = checked(tmp_path / "slip.xlsx", cells, task)
    fault = report.faults[0]
    assert (fault.place, fault.cause) == (rows[0][first], cause) and phrase in fault.message, str(report)


@pytest.mark.parametrize(("factor", "cause"), [(1 / 25.4, "inch"), (-1, "sign")])
@pytest.mark.parametrize("count", [1, ROWS])
def test_what_was_done_to_a_rotary_word_is_named(factor, cause, count, tmp_path):
    cells, rows, task = table("rounded")
    cells = {place: cell for place, cell in as_numbers(cells).items() if place[1] < 3 + count}
    cells |= {row["C"]: round(cells[row["C"]] * factor, 3) for row in rows[:count]}
    report = checked(tmp_path / "slip.xlsx", cells, task)
    fault = report.faults[0]
    assert (fault.place, fault.cause) == (rows[0]["C"], cause) and "C" in fault.message, str(report)


def test_a_tool_that_is_not_turned_seems_to_be_another_point(tmp_path):
    cells, rows, task = table("from right to left")
    report = checked(tmp_path / "slip.xlsx", not_turned(cells, rows), task)
    assert report.verdict == "unclear" and "the tool length is not turned with the head" in str(report)


def longer(cells, rows, length):
    """The words of the head for so much from its pivot to its tip in place of 350 mm."""
    return cells | {row[word]: cells[row[word]].replace("350*", f"{length}*") for row in rows for word in "XYZ"}


@pytest.mark.parametrize("length", [550, 500])
def test_words_that_name_no_point_of_the_machine_are_wrong_by_what_was_done(length, tmp_path):
    cells, rows, task = table("from right to left")
    report = checked(tmp_path / "slip.xlsx", longer(cells, rows, length), task)
    phrase = {550: "the pivot of A is taken twice", 500: "the tool length is taken twice"}[length]
    assert report.verdict == "wrong" and phrase in report.faults[0].message, str(report)


@pytest.mark.parametrize("length", [150, 333])
def test_words_that_name_another_point_of_the_head_or_who_knows_which_are_not_judged(length, tmp_path):
    cells, rows, task = table("from right to left")
    report = checked(tmp_path / "other.xlsx", longer(cells, rows, length), task)
    assert report.verdict == "unclear" and "X Y Z name a point" in str(report), str(report)


@pytest.mark.parametrize("total", [340, 350])
def test_a_number_typed_in_place_of_a_sum_is_wrong_if_it_is_not_the_sum(total, tmp_path):
    """340 for 200 and 150; 350 may be meant, and is named."""
    cells, rows, task = table("from right to left")
    sheet = next(iter(cells))[0]
    cells |= {(sheet, 60, 40): 200, (sheet, 61, 40): 150, (sheet, 64, 40): total}
    cells |= {row[word]: cells[row[word]].replace("350*", "$AN$64*") for row in rows for word in "XYZ"}
    report = checked(tmp_path / "sum.xlsx", cells, task)
    if total == 350:
        assert report.verdict == "unclear" and "AN60 and AN61 together" in str(report), str(report)
    else:
        assert (report.faults[0].cell.split("!")[1], report.faults[0].cause) == ("AN64", "typed over formula")
