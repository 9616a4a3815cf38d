"""The worksheet for a lesson: both recipes of source 000 with live formulas, in English and Chinese.

The formulas of the elementary matrices are the package's own sympy expressions, written as a spreadsheet writes
them. Every range has a name, by which `mathpost.workbook.check` finds it after rows were inserted or cells moved.
"""

import io

import openpyxl
import sympy as sp
from openpyxl.styles import Alignment, Border, Font, PatternFill, Side
from openpyxl.utils import get_column_letter
from openpyxl.workbook.defined_name import DefinedName
from openpyxl.worksheet.formula import ArrayFormula
from openpyxl.worksheet.properties import PageSetupProperties

from mathpost.errors import InputError, as_array, write_bytes
from mathpost.rotation import PASSIVE
from mathpost.workbook.file import local_address

SHEET = "ZXZ"
NAMES = ("alpha", "beta", "gamma")
AXES = "ZXZ"
GIVEN = PatternFill("solid", fgColor="DDEBF7")
THIN = Side(style="thin", color="BFBFBF")
BOX = Border(left=THIN, right=THIN, top=THIN, bottom=THIN)


def template(path, *, angles=(135, 54.7356, -90), point=(3, 4, 5), blank=False):
    """Write the worksheet for a lesson.

    Parameters
    ----------
    path : str or path-like
        The .xlsx file; replaced if it is there.
    angles : array_like, shape (3,), keyword only
        α, β, γ in degrees.
    point : array_like, shape (3,), keyword only
        The point in the initial frame.
    blank : bool, keyword only
        Whether the cells after the given ones stay empty, for the student to fill in.

    Raises
    ------
    InputError
        If the angles or the point are not three finite numbers, or `path` does not end in .xlsx.
    OutputError
        If the file cannot be written.
    """
    if not str(path).lower().endswith(".xlsx"):
        raise InputError(str(path), "a name that ends in .xlsx", "another ending")
    angles, point = (_three(values, name) for values, name in ((angles, "angles"), (point, "point")))
    book = openpyxl.Workbook()
    sheet = _Sheet(book, blank)
    sheet.given(angles, point)
    sheet.recipe_right(top=9)
    sheet.recipe_left(top=26)
    content = io.BytesIO()
    book.save(content)
    write_bytes(path, content.getvalue())


def _three(values, where):
    array = as_array(values, 3, where)
    if array.shape != (3,):
        raise InputError(where, "shape (3,)", f"shape {array.shape}")
    return [int(value) if value.is_integer() else value for value in array.tolist()]


def elementary_formulas(axis, cosine, sine):
    """Return the passive elementary matrix about `axis` as a nested list of numbers and formulas.

    Examples
    --------
    >>> elementary_formulas("Z", "B9", "C9")
    [['=B9', '=C9', 0], ['=-C9', '=B9', 0], [0, 0, 1]]
    """
    t, c, s = sp.symbols("t c s")
    matrix = PASSIVE[axis](t).subs({sp.cos(t): c, sp.sin(t): s})
    cells = {c: f"={cosine}", s: f"={sine}", -s: f"=-{sine}", -c: f"=-{cosine}"}
    return [
        [cells.get(entry, entry) if entry.free_symbols else int(entry) for entry in row] for row in matrix.tolist()
    ]


class _Sheet:
    """The worksheet while it is written: each method fills a part and names its ranges."""

    def __init__(self, book, blank):
        self.book, self.blank, self.sheet = book, blank, book.active
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
                if not self.blank and not isinstance(content, str):
                    cell.value = content[row - first[0]][column - first[1]]
        if isinstance(content, str) and not self.blank:
            area = f"{local_address(first)}:{local_address(last)}"
            self.sheet[local_address(first)] = ArrayFormula(area, content)

    def value(self, place, label, value, name, fill=None):
        """A label and the cell to its right."""
        self.text(place, label, align="right")
        cell = self.sheet.cell(place[0], place[1] + 1)
        cell.border = BOX
        if fill:
            cell.fill = fill
        if fill or not self.blank:
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
