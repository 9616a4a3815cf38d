"""Sheets written from the task's text alone, by authors who had not seen the check, each with what it must say.

A line of strangers.jsonl is a workbook: its cells by sheet, array formulas in braces, and its author's verdict and
first wrong cell, or several of which any may be named.
"""

import contextlib
import json
import random
import shlex
from pathlib import Path

import openpyxl
import pytest
from openpyxl.workbook.defined_name import DefinedName
from openpyxl.worksheet.formula import ArrayFormula

from mathpost.errors import InputError
from mathpost.teaching.workbook import Task, check_file

ROOT = Path(__file__).parents[2]


def _sheets(name):
    lines = (ROOT / "tests/workbook" / name).read_text(encoding="utf-8").splitlines()
    return {sheet["name"]: sheet for sheet in map(json.loads, lines)}


SHEETS = _sheets("strangers.jsonl")  # on which rules were made
FRESH = _sheets("fresh.jsonl")  # and these on which none was: by them it was measured which rules are needed


def given_by(options):
    """What the options of the shell say, by the names of a task's fields."""
    words = iter(shlex.split(options))
    given = {word.removeprefix("--"): next(words) for word in words}
    if "machine" in given:
        given["machine"] = str(ROOT / given["machine"])
    return given


def task_of(options):
    return Task(**given_by(options))


def workbook(sheet):
    book = openpyxl.Workbook()
    book.remove(book.active)
    for title, cells in sheet["sheets"].items():
        page = book.create_sheet(title)
        for address, content in cells.items():
            is_array = isinstance(content, str) and content.startswith("{=")
            page[address.split(":")[0]] = ArrayFormula(address, content[1:-1]) if is_array else content
    for name, text in sheet.get("names", {}).items():
        book.defined_names[name] = DefinedName(name, attr_text=text)
    return book


def agrees(sheet, report):
    """Whether a report says what the author says: the cell, or the array in which it stands."""
    if sheet["verdict"] == "not right":
        return report.verdict != "right" or bool(report.warnings)
    if report.verdict != sheet["verdict"] or not report.faults:
        return report.verdict == sheet["verdict"]
    fault = report.faults[0]
    return fault.cell.split("!")[-1] in sheet["first"] or any(
        f"of the array {cell}:" in fault.message for cell in sheet["first"]
    )


# Always looked at: what was judged wrongly when it was fresh, and false alarms of words.
KEPT = "p010 I005 Y016 Y022 Z007 Z018 Z038 MZ014 MY057 MY052 MY095 MZ035 P10 R41".split()


@pytest.mark.parametrize(("sheets", "step", "share"), [(SHEETS, 12, 0.5), (FRESH, 3, 0.75)])
def test_strangers_sheets(sheets, step, share, of, tmp_path):
    """No right sheet is wrong, no wrong one right; most are judged, and the first wrong cell is the author's."""
    names = [name for n, name in enumerate(sheets) if n % of(step, 1) == 0 or name in KEPT]
    agreed, path = 0, tmp_path / "sheet.xlsx"
    for name in names:
        sheet = sheets[name]
        workbook(sheet).save(path)
        try:
            report = check_file(path, task_of(sheet["options"]))
        except InputError:
            agreed += sheet["verdict"] == "refused"
            continue
        false = {"right": "wrong", "wrong": "right"}.get(sheet["verdict"])
        assert report.verdict != false, f"{name}, {sheet['first']}: {report}"
        agreed += agrees(sheet, report)
    assert agreed >= share * len(names), f"{agreed} of {len(names)}"


SPOILT = ("text", "#REF!", "=1/0", "=A1:B3", "=SUM(", "=XYZ99999", "=FOO(1)", 0, 1e6)


@pytest.mark.parametrize("seed", range(3))
def test_a_spoilt_sheet_raises_nothing_but_errors_of_input(seed, tmp_path, of):
    rng = random.Random(seed)
    for name in rng.sample(sorted(SHEETS), of(5, 80)):
        sheet = SHEETS[name]
        page = rng.choice([title for title, cells in sheet["sheets"].items() if cells])
        cells = sheet["sheets"][page]
        place = rng.choice([address for address in cells if ":" not in address])
        pages = sheet["sheets"] | {page: cells | {place: rng.choice(SPOILT)}}
        workbook(sheet | {"sheets": pages}).save(tmp_path / "spoilt.xlsx")
        with contextlib.suppress(InputError):
            check_file(tmp_path / "spoilt.xlsx", task_of(sheet["options"]))
