"""Workbooks for the tests: right ones in many layouts, and the same with one planted error.

A workbook is a dict of cells; `Layout` writes the calculation of source 000 into it in one of many arrangements,
and the functions in `ERRORS` spoil one thing. The values come from an evaluator of its own, which shares nothing
with the package, and are stored beside the formulas as a spreadsheet program does.
"""

import io
import math
import re
import zipfile
from functools import cache
from pathlib import Path

import numpy as np
import openpyxl
from openpyxl.utils import get_column_letter, range_boundaries
from openpyxl.worksheet.formula import ArrayFormula

GREEK = "αβγ"


def at(row, column):
    return f"{get_column_letter(column)}{row}"


def block(row, column, rows=3, columns=3):
    return [[at(row + r, column + c) for c in range(columns)] for r in range(rows)]


def area(cells):
    return f"{cells[0][0]}:{cells[-1][-1]}"


# Evaluation.

FUNCTIONS = {
    "COS": math.cos,
    "SIN": math.sin,
    "RADIANS": math.radians,
    "DEGREES": math.degrees,
    "PI": lambda: math.pi,
    "ROUND": lambda x, n: round(x, int(n)),
    "MMULT": lambda a, b: np.atleast_2d(a) @ np.atleast_2d(b),
    "TRANSPOSE": lambda a: np.atleast_2d(a).T,
    "SUMPRODUCT": lambda a, b: float((np.asarray(a) * np.asarray(b)).sum()),
}


def evaluate(cells):
    """Return the values of `cells`: numbers, texts, formulas, and arrays as (range, formula) in the first cell."""
    values, arrays = {}, {}
    for content in cells.values():
        if isinstance(content, tuple):
            for row, line in enumerate(_addresses(content[0])):
                for column, address in enumerate(line):
                    arrays[address] = (content, row, column)

    def value(address):
        if address not in values:
            values[address] = compute(address)
        return values[address]

    def compute(address):
        if address in arrays:
            content, row, column = arrays[address]
            result = np.atleast_2d(calculate(content[1]))
            return _plain(result[row % result.shape[0], column % result.shape[1]])
        content = cells.get(address, 0)
        if isinstance(content, str) and content.startswith("="):
            return _plain(np.atleast_2d(calculate(content))[0, 0])
        return content

    def calculate(formula):
        try:
            return _run(formula)
        except (TypeError, ValueError):
            return "#VALUE!"

    def _run(formula):
        grid = lambda name: np.array([[value(a) for a in line] for line in _addresses(name)], dtype=float)  # noqa: E731
        return eval(_code(formula), {"__builtins__": {}}, {**FUNCTIONS, "value": value, "grid": grid})

    return {address: value(address) for address in [*cells, *arrays]}


@cache
def _code(formula):
    text = formula[1:].replace("$", "").replace("^", "**")
    text = re.sub(r"([A-Z]+\d+):([A-Z]+\d+)", r"grid('\1:\2')", text)
    text = re.sub(r"(?<![\w':])([A-Z]{1,2}\d+)(?![\w':(])", r"value('\1')", text)
    return compile(text, formula, "eval")


def _plain(result):
    return "#VALUE!" if isinstance(result, str) else float(result)


def _addresses(name):
    left, top, right, bottom = range_boundaries(name)
    return block(top, left, bottom - top + 1, right - left + 1)


def save(path, cells, *, names=(), merged=(), values_only=False, sheet="Sheet1"):
    """Write `cells` with the values that their formulas have."""
    values = evaluate(cells)
    book = openpyxl.Workbook()
    book.active.title = sheet
    for address, number in values.items():
        book.active[address] = number
    if not values_only:
        for address, content in cells.items():
            if isinstance(content, tuple):
                book.active[address] = ArrayFormula(*content)
            elif isinstance(content, str) and content.startswith("="):
                book.active[address] = content
    for name, target in names:
        book.defined_names[name] = openpyxl.workbook.defined_name.DefinedName(name, attr_text=target)
    for span in merged:
        book.active.merge_cells(span)
    content = io.BytesIO()
    book.save(content)
    with zipfile.ZipFile(content) as source, zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as target:
        for name in source.namelist():
            data = source.read(name)
            if name == "xl/worksheets/sheet1.xml":
                data = _with_values(data.decode(), values).encode()
            target.writestr(name, data)
    return Path(path)


def _with_values(xml, values):
    def fill(found):
        number = values[found[1]]
        if isinstance(number, str):
            return f'<c r="{found[1]}" t="e">{found[2]}<v>{number}</v></c>'
        return f'<c r="{found[1]}">{found[2]}<v>{number!r}</v></c>'

    return re.sub(r'<c r="([A-Z]+\d+)"[^>]*>(<f[^>]*>[^<]*</f>)<v\s*/?>(?:</v>)?</c>', fill, xml)


# Layouts.


class Layout:
    """One calculation written into cells; the attributes name the cells of each step."""

    def __init__(self, rng, angles, point, *, recipe="right", trig=True, array=True, across=False, english=False):
        self.rng, self.recipe, self.trig, self.array = rng, recipe, trig, array
        self.cells, self.steps = {}, []
        self.sign = "-" if recipe == "left" else ""
        words = ["alpha", "beta", "gamma"] if english else GREEK
        self.name = "matrix {}" if english else "矩阵{}"
        self.row = 1
        self.angles = self.given(words, angles, across)
        self.point = self.given("xyz", point, across, column=1 if across else 4)
        self.used = self.angles
        if recipe == "left":
            self.negated = [at(self.row + 1, 2 + 2 * n) for n in range(3)]
            for n, address in enumerate(self.negated):
                self.cells[at(self.row + 1, 1 + 2 * n)] = f"-{words[n]}"
                self.put([[address]], [[f"=-{self.angles[n]}"]])
            self.used, self.row = self.negated, self.row + 3
        self.elements = []
        self.functions = {}
        for n in range(3):
            self.elements.append(self.element(n, words[n]))
        order = (2, 1, 0) if recipe == "right" else (0, 1, 2)
        join = " " if english else ""
        self.first = self.product(
            join.join(words[n] for n in order[:2]), self.elements[order[0]], self.elements[order[1]]
        )
        self.whole = self.product(join.join(words[n] for n in order), self.first, self.elements[order[2]])
        self.final = self.whole
        if recipe == "left":
            self.final = self.matrix("转置" if not english else "transposed")
            self.array_formula(self.final, f"=TRANSPOSE({area(self.whole)})")
        self.result = self.outcome()

    def given(self, labels, values, across, column=1):
        addresses = []
        for n, (label, number) in enumerate(zip(labels, values, strict=True)):
            row, label_column = (self.row, column + 2 * n) if across == "pairs" else (self.row + n, column)
            if across is True:
                self.cells[at(self.row, 1 + n)] = label
                addresses.append(at(self.row + 1, 1 + n))
            else:
                self.cells[at(row, label_column)] = label
                addresses.append(at(row, label_column + 1))
            self.cells[addresses[-1]] = float(number)
        if across:
            self.row += 3
        elif column == 4:
            self.row += 4
        return addresses

    def put(self, addresses, formulas):
        for line, content in zip(addresses, formulas, strict=True):
            for address, formula in zip(line, content, strict=True):
                self.cells[address] = formula
        self.steps.append(addresses)

    def function(self, n, name):
        """The cosine or sine as it is used in the matrix: a cell, or the formula."""
        return self.functions.get((name, n)) or f"{name}(RADIANS({self.used[n]}))"

    def element(self, n, word):
        if self.trig:
            for k, name in enumerate(("COS", "SIN")):
                self.cells[at(self.row + k, 1)] = f"{name.lower()}{GREEK[n]}"
                self.put([[at(self.row + k, 2)]], [[f"={name}(RADIANS({self.used[n]}))"]])
                self.functions[name, n] = at(self.row + k, 2)
        cells = self.matrix(word, column=4)
        self.put(cells, self.entries(n, "ZXZ"[n]))
        return cells

    def entries(self, n, axis, cosine=None, sine=None, minus="-"):
        c, s = cosine or self.function(n, "COS"), sine or self.function(n, "SIN")
        plus, minus = ("", minus) if minus == "-" else ("-", "")
        turn = {(0, 0): f"={c}", (0, 1): f"={plus}{s}", (1, 0): f"={minus}{s}", (1, 1): f"={c}"}
        plane = {"Z": (0, 1), "X": (1, 2), "Y": (2, 0)}[axis]
        entries = [[float(r == c) for c in range(3)] for r in range(3)]
        for (r, c_), formula in turn.items():
            entries[plane[r]][plane[c_]] = formula
        return entries

    def matrix(self, word, column=1):
        self.cells[at(self.row, column)] = self.name.format(word)
        cells = block(self.row + 1, column)
        self.row += 5
        return cells

    def product(self, word, left, right):
        cells = self.matrix(word)
        self.multiply(cells, left, right)
        return cells

    def multiply(self, cells, left, right):
        if self.array and right[0][0][0] == right[-1][0][0]:
            self.array_formula(cells, f"=MMULT({area(left)},{area(right)})")
        else:
            columns = range(len(cells[0]))
            self.put(cells, [[self.dot(left[r], [line[c] for line in right]) for c in columns] for r in range(3)])

    @staticmethod
    def dot(row, column):
        return "=" + "+".join(f"{a}*{b}" for a, b in zip(row, column, strict=True))

    def array_formula(self, cells, formula):
        self.clear(cells)
        self.cells[cells[0][0]] = (area(cells), formula)
        self.steps.append(cells)

    def clear(self, cells):
        for line in cells:
            for address in line:
                self.cells.pop(address, None)
        if cells in self.steps:
            self.steps.remove(cells)

    def outcome(self):
        for n in range(3):
            self.cells[at(self.row + n, 1)] = f"{'xyz'[n]}'"
        cells = [[at(self.row + n, 2)] for n in range(3)]
        self.multiply(cells, self.final, [[a] for a in self.point])
        return cells

    def first_difference(self, right_values):
        """The first cell, in the order of the calculation, that differs from the right workbook's."""
        values = evaluate(self.cells)
        for step in self.steps:
            for line in step:
                for address in line:
                    number, right = values.get(address), right_values[address]
                    if not isinstance(number, float | int) or abs(number - right) > 2e-9:
                        return address
        return None


# Errors: each spoils a layout and returns the kinds that name it, or None if the layout does not lend itself to it.


def _respoil(layout, n, **changes):
    axis = changes.pop("axis", "ZXZ"[n])
    entries = layout.entries(n, axis, **changes)
    for line, content in zip(layout.elements[n], entries, strict=True):
        for address, formula in zip(line, content, strict=True):
            layout.cells[address] = formula


def _refunction(layout, n, template):
    """Write both functions of an angle anew; `template` has {f} for COS or SIN and {a} for the angle's cell."""
    for name in ("COS", "SIN"):
        text = template.format(f=name, a=layout.used[n])
        if layout.trig:
            layout.cells[layout.functions[name, n]] = "=" + text
        else:
            layout.functions[name, n] = text
    if not layout.trig:
        _respoil(layout, n)


def active_all(layout):
    for n in range(3):
        _respoil(layout, n, minus="+")
    return {"active", "sign"} if layout.recipe == "left" else {"active"}


def active_one(layout):
    _respoil(layout, layout.rng.integers(3), minus="+")
    return {"active"}


def radians_all(layout):
    for n in range(3):
        _refunction(layout, n, "{f}({a})")
    return {"unit"}


def radians_one(layout):
    _refunction(layout, layout.rng.integers(3), "{f}({a})")
    return {"unit"}


def radians_twice(layout):
    _refunction(layout, layout.rng.integers(3), "{f}(RADIANS(RADIANS({a})))")
    return {"unit"}


def rounded_pi(layout):
    _refunction(layout, layout.rng.integers(3), "{f}({a}*3.14/180)")
    return {"rounded"}


def rounded_angle(layout):
    _refunction(layout, layout.rng.integers(3), "{f}(RADIANS(ROUND({a},0)))")
    return {"rounded"}


def sign_of_angle(layout):
    _refunction(layout, layout.rng.integers(3), "{f}(RADIANS(-{a}))")
    return {"sign", "active"}


def wrong_angle(layout):
    n = layout.rng.integers(3)
    _refunction(layout, n, f"{{f}}(RADIANS({layout.used[(n + 1) % 3]}))")
    return {"reference"}


def exchanged_angles(layout):
    used = layout.used
    for n, m in ((0, 2), (2, 0)):
        _refunction(layout, n, f"{{f}}(RADIANS({used[m]}))")
    return {"exchange", "reference"}


def wrong_axis(layout):
    n = layout.rng.integers(3)
    _respoil(layout, n, axis="YYX"[n] if layout.rng.integers(2) else "XYY"[n])
    return {"axis"}


def order_first(layout):
    a, b = (2, 1) if layout.recipe == "right" else (0, 1)
    layout.clear(layout.first)
    layout.multiply(layout.first, layout.elements[b], layout.elements[a])
    _reorder(layout)
    return {"order"}


def order_last(layout):
    layout.clear(layout.whole)
    layout.multiply(layout.whole, layout.elements[0 if layout.recipe == "right" else 2], layout.first)
    _reorder(layout)
    return {"order"}


def _reorder(layout):
    """Bring the steps back into the order of the rows after one was written anew."""
    layout.steps.sort(key=lambda step: range_boundaries(step[0][0])[1])


def missing_transpose(layout):
    if layout.recipe == "right":
        return None
    layout.array_formula(layout.final, f"={area(layout.whole)}")
    _reorder(layout)
    return {"transpose"}


def untransposed_result(layout):
    if layout.recipe == "right":
        return None
    layout.clear(layout.result)
    layout.multiply(layout.result, layout.whole, [[a] for a in layout.point])
    return {"transpose"}


def row_vector(layout):
    layout.clear(layout.result)
    columns = [[line[c] for line in layout.final] for c in range(3)]
    layout.put(layout.result, [[layout.dot(column, layout.point)] for column in columns])
    return {"row", "transpose"}


def transposed_product(layout):
    left, right = area(layout.elements[2 if layout.recipe == "right" else 0]), area(layout.elements[1])
    layout.array_formula(layout.first, f"=TRANSPOSE(MMULT({left},{right}))")
    _reorder(layout)
    return {"transpose", "order"}


def wrong_factor(layout):
    layout.clear(layout.whole)
    layout.multiply(layout.whole, layout.first, layout.elements[1])
    _reorder(layout)
    return {"reference"}


def factor_left_out(layout):
    layout.array_formula(layout.whole, f"={area(layout.first)}")
    _reorder(layout)
    return {"left out"}


def identity(layout):
    n = layout.rng.integers(3)
    for r, line in enumerate(layout.elements[n]):
        for c, address in enumerate(line):
            layout.cells[address] = float(r == c)
    return {"left out"}


def elementwise(layout):
    a, b = (2, 1) if layout.recipe == "right" else (0, 1)
    layout.array_formula(layout.first, f"={area(layout.elements[a])}*{area(layout.elements[b])}")
    _reorder(layout)
    return {"elementwise"}


def not_an_array(layout):
    a = layout.elements[2 if layout.recipe == "right" else 0]
    layout.clear(layout.first)
    layout.put(layout.first, [[f"=MMULT({area(a)},{area(layout.elements[1])})"] * 3] * 3)
    _reorder(layout)
    return {"not an array"}


def _entries(layout):
    return [a for m in (*layout.elements, layout.first, layout.whole) for line in m for a in line]


def _single(layout, of):
    """An entry of one of the matrices whose value is not a plain 0 or 1."""
    values = evaluate(layout.cells)
    choice = [a for m in of for line in m for a in line if 0.02 < abs(values[a]) < 0.98]
    address = str(layout.rng.choice(choice))
    for cells in of:
        content = layout.cells.get(cells[0][0])
        if any(address in line for line in cells) and isinstance(content, tuple):
            for line in cells:
                for each in line:
                    layout.cells[each] = values[each]
    return address, values[address]


def typed_number(layout):
    address, value = _single(layout, [*layout.elements, layout.first, layout.whole])
    layout.cells[address] = float(np.round(value + layout.rng.choice([-1, 1]) * layout.rng.uniform(0.1, 0.5), 4))
    return {"number"}


def sign_of_entry(layout):
    address, value = _single(layout, [*layout.elements, layout.first, layout.whole])
    layout.cells[address] = -value
    return {"sign"}


def rounded_entry(layout):
    address, value = _single(layout, [*layout.elements, layout.first, layout.whole])
    layout.cells[address] = float(np.round(value, 3))
    return {"rounded"} if round(value, 3) != value else None


def sine_for_cosine(layout):
    n = layout.rng.integers(3)
    address = layout.elements[n][1][1]
    layout.cells[address] = f"={layout.function(n, 'SIN')}"
    return {"sine and cosine"}


def term_with_wrong_sign(layout):
    if layout.array:
        return None
    address = str(layout.rng.choice([a for line in layout.first for a in line]))
    terms = layout.cells[address][1:].split("+")
    values = [evaluate({**layout.cells, "ZZ1": "=" + term})["ZZ1"] for term in terms]
    if max(map(abs, values)) < 0.01:
        return None
    n = int(np.argmax(np.abs(values)))
    layout.cells[address] = "=" + "+".join(terms[:n] + terms[n + 1 :]) + "-" + terms[n]
    return {"term", "sign"}


def wrong_row_in_result(layout):
    layout.clear(layout.result)
    layout.put(layout.result, [[layout.dot(layout.final[n], layout.point)] for n in (0, 2, 2)])
    return {"entry", "reference"}


def exchanged_coordinates(layout):
    layout.clear(layout.result)
    point = [layout.point[n] for n in (1, 0, 2)]
    layout.put(layout.result, [[layout.dot(layout.final[n], point)] for n in range(3)])
    return {"exchange", "point"}


def exchanged_result(layout):
    layout.clear(layout.result)
    layout.put(layout.result, [[layout.dot(layout.final[n], layout.point)] for n in (1, 0, 2)])
    return {"exchange", "copied"}


def not_negated(layout):
    if layout.recipe == "right":
        return None
    n = layout.rng.integers(3)
    layout.cells[layout.negated[n]] = f"={layout.angles[n]}"
    return {"sign"}


def text_in_a_cell(layout):
    address, value = _single(layout, layout.elements)
    layout.cells[address] = f"{value:.4f}°"
    return {"text"}


ERRORS = (
    active_all,
    active_one,
    radians_all,
    radians_one,
    radians_twice,
    rounded_pi,
    rounded_angle,
    sign_of_angle,
    wrong_angle,
    exchanged_angles,
    wrong_axis,
    order_first,
    order_last,
    missing_transpose,
    untransposed_result,
    row_vector,
    transposed_product,
    wrong_factor,
    factor_left_out,
    identity,
    elementwise,
    not_an_array,
    typed_number,
    sign_of_entry,
    rounded_entry,
    sine_for_cosine,
    term_with_wrong_sign,
    wrong_row_in_result,
    exchanged_coordinates,
    exchanged_result,
    not_negated,
    text_in_a_cell,
)
