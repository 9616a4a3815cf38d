"""What empty cells, texts, TRUE and errors count for in a formula, as LibreOffice and Excel's documentation say.

`values_of_libreoffice.json` has what LibreOffice 7.4 made of each formula; what it makes otherwise than Excel
documents, as of TRUE in a sum, is in `differ` and must not be taken for known.
"""

import json
from pathlib import Path

import numpy as np
import openpyxl
import pytest
from openpyxl.worksheet.formula import ArrayFormula

from mathpost.teaching.workbook.sheet.file import read
from mathpost.teaching.workbook.sheet.graph import Graph

SAID = json.loads(Path(__file__).with_name("values_of_libreoffice.json").read_text(encoding="utf-8"))
FIRST = 10  # row of the formulas
ROWS = {formula: FIRST + n for n, formula in enumerate((*SAID["values"], *SAID["differ"]))}


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    book, path = openpyxl.Workbook(), tmp_path_factory.mktemp("blanks") / "blanks.xlsx"
    sheet = book.active
    for place, content in SAID["cells"].items():
        sheet[place] = content
        if content == "5":
            sheet[place].data_type = "s"  # a text
    for formula, row in ROWS.items():
        inner = formula.strip("{}")
        sheet.cell(row, 1).value = ArrayFormula(f"A{row}", f"={inner}") if formula != inner else f"={inner}"
    book.save(path)
    return path


@pytest.fixture(scope="module")
def values(path):
    """Formula → what it is here."""
    graph = Graph(read(path))
    found = graph.run({})
    return {formula: float(found[graph.book.sheets[0], row, 1][0]) for formula, row in ROWS.items()}


def test_formulas_have_the_values_that_libreoffice_gives_them(values):
    assert len(SAID["values"]) > 500
    for formula, value in SAID["values"].items():
        wanted = np.nan if value == "error" else float(value)
        np.testing.assert_allclose(values[formula], wanted, rtol=1e-12, atol=1e-12, err_msg=formula)


def test_what_programs_make_different_things_of_is_not_known(values):
    assert [formula for formula in SAID["differ"] if np.isfinite(values[formula])] == []
