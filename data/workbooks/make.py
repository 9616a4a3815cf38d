"""Make the workbooks of this folder, one error planted in each, and table 2 of source 002.

The sheet has both recipes of source 000 with live formulas, in English and Chinese. The formulas of its elementary
matrices are the package's own sympy expressions, written as a spreadsheet writes them. Every range has a name.

Run it from the repository's root: ``python data/workbooks/make.py``. LibreOffice calculates the values.
"""

import re
import shutil
import tempfile
from pathlib import Path

import openpyxl
import sympy as sp
from openpyxl.styles import Alignment, Border, Font, PatternFill, Side
from openpyxl.utils import get_column_letter
from openpyxl.workbook.defined_name import DefinedName
from openpyxl.worksheet.formula import ArrayFormula
from openpyxl.worksheet.properties import PageSetupProperties

from mathpost.rotation import PASSIVE
from mathpost.teaching.workbook.sheet.file import local_address, recalculate

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


SHEET = "ZXZ"
NAMES = ("alpha", "beta", "gamma")
AXES = "ZXZ"
GIVEN = PatternFill("solid", fgColor="DDEBF7")
THIN = Side(style="thin", color="BFBFBF")
BOX = Border(left=THIN, right=THIN, top=THIN, bottom=THIN)


def write_sheet(path, angles=(135, 54.7356, -90), point=(3, 4, 5)):
    """Write the worksheet of the lesson."""
    book = openpyxl.Workbook()
    sheet = _Sheet(book)
    sheet.given(angles, point)
    sheet.recipe_right(top=9)
    sheet.recipe_left(top=26)
    book.save(path)


def elementary_formulas(axis, cosine, sine):
    """The passive elementary matrix about an axis as a nested list of formulas."""
    cells, matrix = {"cos(t)": cosine, "sin(t)": sine}, PASSIVE[axis](sp.Symbol("t")).tolist()
    return [
        [re.sub(r"(cos|sin)\(t\)", lambda found: cells[found[0]], f"={entry}") for entry in row] for row in matrix
    ]


class _Sheet:
    """The worksheet while it is written: each method fills a part and names its ranges."""

    def __init__(self, book):
        self.book, self.sheet = book, book.active
        self.sheet.title = SHEET
        self.sheet.sheet_view.showGridLines = False
        self.sheet.page_setup.orientation = "landscape"
        self.sheet.sheet_properties.pageSetUpPr = PageSetupProperties(fitToPage=True)
        for column in range(1, 16):
            self.sheet.column_dimensions[get_column_letter(column)].width = 12
        self.text(
            (1, 1), "A point in a frame turned by ZXZ Euler angles · ZXZ欧拉角旋转坐标转换", bold=True, size=14
        )
        self.text(
            (2, 1), "Turn about Z by α, about the new X by β, about the newest Z by γ: where is the point then?"
        )
        self.text((3, 1), "绕初始Z轴旋转α，再绕新X轴旋转β，最后绕最新Z轴旋转γ：该点在最后的坐标系里的坐标是多少？")

    def given(self, angles, point):
        self.text((5, 1), "Given · 已知", bold=True)
        for n, (name, value) in enumerate(zip(NAMES, angles, strict=True)):
            self.value((5 + n, 2), "αβγ"[n], value, name, fill=GIVEN)
            self.text((5 + n, 4), "°")
        for n, value in enumerate(point):
            self.value((5 + n, 6), "xyz"[n], value, None, fill=GIVEN)
        self.name("point", (5, 7), (7, 7))

    def recipe_right(self, top):
        self.text(
            (top, 1), "Recipe 1 · 方法一: multiply γ·β·α (the source says 右乘 right multiplication)", bold=True
        )
        elements = self.elements(top + 1, [f"C{5 + n}" for n in range(3)], "recipe1")
        first = self.product("γβ", top + 10, 1, elements[2], elements[1], "recipe1_gamma_beta")
        final = self.product("γβα", top + 10, 5, first, elements[0], "recipe1_gamma_beta_alpha")
        self.outcome(top + 10, 9, final, "recipe1_result")

    def recipe_left(self, top):
        self.text(
            (top, 1), "Recipe 2 · 方法二: negate the angles, multiply α·β·γ (左乘), transpose (转置)", bold=True
        )
        for n, name in enumerate(NAMES):
            self.value((top + 1, 2 + 4 * n), f"−{'αβγ'[n]}", f"=-C{5 + n}", f"recipe2_minus_{name}")
        elements = self.elements(top + 2, [f"{c}{top + 1}" for c in "CGK"], "recipe2")
        first = self.product("αβ", top + 11, 1, elements[0], elements[1], "recipe2_alpha_beta")
        last = self.product("αβγ", top + 11, 5, first, elements[2], "recipe2_alpha_beta_gamma")
        final = self.matrix("(αβγ)ᵀ", top + 11, 9, f"=TRANSPOSE({last})", "recipe2_transposed")
        self.outcome(top + 11, 13, final, "recipe2_result")

    def elements(self, top, angles, recipe):
        """The three elementary matrices side by side, each below its cosine and sine."""
        areas = []
        for n, angle in enumerate(angles):
            column, letter = 1 + 4 * n, "αβγ"[n]
            cells = []
            for row, function in ((top, "cos"), (top + 1, "sin")):
                formula = f"={function.upper()}(RADIANS({angle}))"
                self.value((row, column + 1), f"{function} {letter}", formula, f"{recipe}_{function}_{NAMES[n]}")
                cells.append(local_address((row, column + 2)))
            label = f"{letter} = E_{AXES[n].lower()}"
            entries = elementary_formulas(AXES[n], *cells)
            entries = [[int(e[1:]) if e[1:].isdigit() else e for e in row] for row in entries]
            areas.append(self.matrix(label, top + 3, column, entries, f"{recipe}_{NAMES[n]}"))
        return areas

    def product(self, label, top, column, left, right, name):
        return self.matrix(label, top, column, f"=MMULT({left},{right})", name)

    def matrix(self, label, top, column, content, name):
        """A matrix below its label, from an array formula or nine numbers and formulas; returns its range."""
        self.text((top, column), f"矩阵 matrix {label}")
        first, last = (top + 1, column), (top + 3, column + 2)
        area = f"{local_address(first)}:{local_address(last)}"
        self.cells(first, last, content)
        self.name(name, first, last)
        return area

    def outcome(self, top, column, final, name):
        for n, letter in enumerate("xyz"):
            self.text((top + 1 + n, column), f"{letter}'", align="right")
        first, last = (top + 1, column + 1), (top + 3, column + 1)
        self.cells(first, last, f"=MMULT({final},$G$5:$G$7)")
        self.name(name, first, last)

    def cells(self, first, last, content):
        for row in range(first[0], last[0] + 1):
            for column in range(first[1], last[1] + 1):
                cell = self.sheet.cell(row, column)
                cell.border, cell.number_format = BOX, "0.000000"
                if not isinstance(content, str):
                    cell.value = content[row - first[0]][column - first[1]]
        if isinstance(content, str):
            area = f"{local_address(first)}:{local_address(last)}"
            self.sheet[local_address(first)] = ArrayFormula(area, content)

    def value(self, place, label, value, name, fill=None):
        """A label and the cell to its right."""
        self.text(place, label, align="right")
        cell = self.sheet.cell(place[0], place[1] + 1)
        cell.border = BOX
        if fill:
            cell.fill = fill
        cell.value = value
        if isinstance(value, str) and not value.startswith("=-"):
            cell.number_format = "0.000000"
        if name:
            self.name(name, (place[0], place[1] + 1), (place[0], place[1] + 1))

    def text(self, place, text, *, bold=False, size=11, align=None):
        cell = self.sheet.cell(*place, text)
        cell.font = Font(bold=bold, size=size)
        cell.alignment = Alignment(horizontal=align)

    def name(self, name, first, last):
        area = ":".join(f"${get_column_letter(column)}${row}" for row, column in dict.fromkeys((first, last)))
        self.book.defined_names[name] = DefinedName(name, attr_text=f"{SHEET}!{area}")


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
    """γβ as sums, with F16 for F15 in one of them, beside cos γ, which is zero at the source's angles."""
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
        write_sheet(path)
        book = openpyxl.load_workbook(path)
        plant(book.active)
        book.save(path)
        shutil.copyfile(recalculate(path, folder), HERE / f"{name}.xlsx")


if __name__ == "__main__":
    main()
