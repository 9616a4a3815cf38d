"""Tables that people open in a spreadsheet program: nothing that a stranger wrote becomes a formula there."""

import csv
import io
import shutil
import subprocess
import unicodedata
from itertools import product

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mathpost.files import csv_text

SEPARATORS = ",;\t|"
SIGNS = "=+-@＝＋－＠﹦﹢﹣﹫"
LEADS = [
    "",
    "eve;",
    "eve,",
    "eve\t",
    "eve|",
    "\r",
    "\n",
    " ",
    "\t\r\n ",
    ' "',
    ';"',
    '";',
    '"',
    "\u3000",
    "\u200b;",
]
FORMULAS = [lead + sign + "1+cmd|'/C calc'!A1" for lead, sign in product(LEADS, SIGNS)]


def is_formula(cell):
    """As programs see it: what they pass over goes, wide signs are signs, a number is none."""
    shown = "".join(
        c for c in cell if c not in '"' and unicodedata.category(c) not in ("Cc", "Cf", "Zs", "Zl", "Zp")
    )
    if unicodedata.normalize("NFKC", shown[:1]) not in ("=", "+", "-", "@"):
        return False
    try:
        float(shown.rstrip(")]}°"))
    except ValueError:
        return True
    return False


def cells(text, separator):
    """The cells of a table where `separator` divides, with and without regard to quotes."""
    yield from (cell for row in csv.reader(io.StringIO(text, newline=""), delimiter=separator) for cell in row)
    yield from (cell for line in text.splitlines() for cell in line.split(separator))


@pytest.mark.parametrize("separator", SEPARATORS)
def test_no_text_becomes_a_formula_whatever_divides(separator):
    table = csv_text([[text, "right", text] for text in FORMULAS]).removeprefix("\ufeff")
    assert not list(filter(is_formula, cells(table, separator)))


@given(st.lists(st.text(alphabet=SIGNS + SEPARATORS + "\"' \r\n\u200baA1é.", max_size=12), min_size=1, max_size=4))
def test_no_strange_text_does(texts):
    table = csv_text([texts]).removeprefix("\ufeff")
    assert not [cell for separator in SEPARATORS for cell in cells(table, separator) if is_formula(cell)]


def test_numbers_and_words_stay_as_they_are():
    row = [-2.5, 3, "-2.5", "+1e-3", "o'neil", "a-b", "F16 should be -F15", "found (1.5, -2.5, -3)", "王小明"]
    read = next(csv.reader(io.StringIO(csv_text([row]).removeprefix("\ufeff"))))
    assert read == [str(value) for value in row]


@pytest.mark.skipif(not shutil.which("soffice"), reason="no LibreOffice here")
def test_libreoffice_calculates_nothing_of_it(tmp_path):
    (tmp_path / "class.csv").write_text(csv_text([[text, "right"] for text in FORMULAS]), encoding="utf-8")
    filters = f"CSV:{ord(';')},{ord(chr(34))},76,1,,0,false,true,false,false,false,-1,true"
    command = ["soffice", "--headless", "--norestore", f"-env:UserInstallation={(tmp_path / 'profile').as_uri()}"]
    command += [
        f"--infilter={filters}",
        "--convert-to",
        "fods",
        "--outdir",
        str(tmp_path),
        str(tmp_path / "class.csv"),
    ]
    subprocess.run(command, check=True, capture_output=True)
    opened = (tmp_path / "class.fods").read_text(encoding="utf-8")
    assert "calc" in opened and "table:formula" not in opened
