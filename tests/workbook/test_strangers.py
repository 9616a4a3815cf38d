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
from mathpost.workbook import Task, check_file
from tests.conftest import runs_all

ROOT = Path(__file__).parents[2]


def _sheets(name):
    lines = (ROOT / "tests/workbook" / name).read_text(encoding="utf-8").splitlines()
    return {sheet["name"]: sheet for sheet in map(json.loads, lines)}


SHEETS = _sheets("strangers.jsonl")  # on which rules were made
FRESH = _sheets("fresh.jsonl")  # and these on which none was: by them it was measured which rules are needed
# Not judged, or the fault is named elsewhere; never right for wrong, nor wrong for right.
OPEN = set(
    """
    u012 u013 u028 u035 u036 u037 u038 u040 v024 v027 v037 v040 w003 w009 w010
    w014 w029 w035 w037 y015 z014 z027 p009 p013 p020 p022 p029 p030 p033 p037
    k008 k018 k028 k031 b014 b017 b032 b034 c001 c029 c036 d027 d037 e032 h027
    h028 h029 i016 i021 i028 i031 i032 i033 i037 i040 t005 t007 t013 t016 G017
    H009 H034 H035 I002 I020 I025 I027 I033 I034 J010 J030 N004 N008 N015 N017
    N028 N029 N030 N040 O012 O015 O019 O020 O024 O035 O042
    P014 P016 P022 P025 P028 P032 P035 P039 P042 P043 P047 Q002 Q004 Q006 Q022
    Q028 Q039 Q040 Q042 Q047 Q049 Q050 R002 R012 R022 R028 R030 R032 R036 R038 R050
    S014 S019 S030 S031 S033 S043 S044 S045 S046 S047 S049 S050
    Z007 Z018 MZ014 MZ028 MZ042 MZ053 MY057 MY052 MY083 MZ035
    """.split()
)


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


# Always looked at: what no other of the few tells, and what was judged wrongly when it was fresh.
KEPT = "p010 I005 Y016 Y022 Z007 Z018 Z038 MZ014 MY057 MY052 MY095 MZ035".split()


def pytest_generate_tests(metafunc):
    """Every fifth sheet and those that are kept; all of them by --hypothesis-profile=many."""
    if "name" in metafunc.fixturenames:
        few = dict.fromkeys([*[*SHEETS][::5], *KEPT])
        metafunc.parametrize("name", [*SHEETS] if runs_all(metafunc.config) else [*few])


def test_a_strangers_sheet(name, tmp_path):
    sheet = SHEETS[name]
    path = tmp_path / f"{name}.xlsx"
    workbook(sheet).save(path)
    if sheet["verdict"] == "refused":
        with pytest.raises(InputError):
            check_file(path, task_of(sheet["options"]))
        return
    report = check_file(path, task_of(sheet["options"]))
    false = {"right": "wrong", "wrong": "right"}.get(sheet["verdict"])
    assert report.verdict != false, f"{sheet['first']}: {report}"
    assert agrees(sheet, report) == (name not in OPEN), f"{sheet['verdict']} {sheet['first']}: {report}"


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
