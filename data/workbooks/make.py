"""Make the workbooks of this folder, the template with one error planted in each, and table 2 of source 002.

Run it from the repository's root: ``python data/workbooks/make.py``. LibreOffice calculates the values.
"""

import shutil
import tempfile
from pathlib import Path

import openpyxl
from openpyxl.worksheet.formula import ArrayFormula

from mathpost.workbook.file import recalculate
from mathpost.workbook.template import template

HERE = Path(__file__).parent
TABLES = HERE.parent / "tables"
# Yu Dan et al. (source 002), tables 1 and 2: x y z i j k, and the NC words X Y Z B C.
BLADE = (
    (40, 50.31991, 58.40925, 52.13969, 0.145196, 0.0, 0.989403, -46.051, -60.375, 67.403, 11.817, 166.559),
    (50, 50.31968, 58.40925, 52.14050, 0.058170, 0.0, 0.998307, -45.116, -62.825, 57.875, 4.716, 178.52),
    (60, 50.31947, 58.40925, 52.14126, -0.028804, 0.0, 0.999585, 48.935, 59.374, 52.169, 2.335, 1.144),
    (70, 50.31931, 58.40925, 52.14198, -0.114263, 0.0, 0.993451, 45.936, 60.76, 52.552, 9.284, 3.251),
    (80, 50.31915, 58.40925, 52.14338, -0.275502, 0.0, 0.961300, 38.782, 62.119, 54.925, 22.691, 8.078),
)


def active_elements(sheet):
    """The signs of the sines belong to a turned vector, not to a turned frame, in all six matrices."""
    for corner in ("A14", "I14", "A32", "I32"):
        _exchange(sheet[corner].offset(0, 1), sheet[corner].offset(1, 0))
    for corner in ("E14", "E32"):
        _exchange(sheet[corner].offset(1, 2), sheet[corner].offset(2, 1))


def _exchange(first, second):
    first.value, second.value = second.value, first.value


def wrong_order(sheet):
    """β·γ where γ·β belongs."""
    sheet["A20"] = ArrayFormula("A20:C22", "=MMULT(E14:G16,I14:K16)")


def radians_forgotten(sheet):
    """COS and SIN of β in degrees, in the first recipe."""
    sheet["G10"], sheet["G11"] = "=COS(C6)", "=SIN(C6)"


def missing_transpose(sheet):
    """The product of the second recipe is passed on as it is."""
    sheet["I38"] = ArrayFormula("I38:K40", "=E38:G40")


def typed_sign(sheet):
    """One entry of γβα typed by hand, with the wrong sign."""
    for row in range(3):
        for column, letter in enumerate("ABC"):
            terms = [f"{left}{20 + row}*{letter}{14 + n}" for n, left in enumerate("ABC")]
            sheet["E20"].offset(row, column).value = "=" + "+".join(terms)
    sheet["F21"] = -0.707106781186548


def lucky(sheet):
    """γβ as sums, with one reference a row too low: F16 for F15, beside cos γ, which is zero at the source's angles."""
    for row in range(3):
        for column, letter in enumerate("EFG"):
            terms = [f"{left}{14 + row}*{letter}{14 + n}" for n, left in enumerate("IJK")]
            sheet["A20"].offset(row, column).value = "=" + "+".join(terms)
    sheet["B21"] = "=I15*F14+J15*F16+K15*F16"


def main():
    """Write all workbooks."""
    errors = (active_elements, wrong_order, radians_forgotten, missing_transpose, typed_sign, lucky)
    _save("right", lambda sheet: None)
    for plant in errors:
        _save(plant.__name__, plant)
    book = openpyxl.Workbook()
    book.active.title = "Blade"
    book.active.append(["N", "x", "y", "z", "i", "j", "k", "X", "Y", "Z", "B", "C"])
    for row in BLADE:
        book.active.append(row)
    TABLES.mkdir(exist_ok=True)
    book.save(TABLES / "source_002_table_2.xlsx")


def _save(name, plant):
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "planted.xlsx"
        template(path)
        book = openpyxl.load_workbook(path)
        plant(book.active)
        book.save(path)
        shutil.copyfile(recalculate(path, folder), HERE / f"{name}.xlsx")


if __name__ == "__main__":
    main()
