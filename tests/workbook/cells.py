"""A workbook as a dictionary of cells, its values, and the .xlsx file, made without the package.

A cell is `(sheet, row, column)`; its content a number, a text, or a formula that begins with "=". The values are
those of many samples of the inputs at once: sample 0 is what stands in the sheet, the others are random, so that
two formulas with the same values are the same function.
"""

import re
import zipfile
from dataclasses import dataclass, field
from typing import NamedTuple
from xml.sax.saxutils import escape, quoteattr

import numpy as np

SAMPLES = 24
REFERENCE = re.compile(
    r"(?<![\w.'!$])((?:'[^']+'|[^\W\d]\w*)!)?(\$?)([A-Z]{1,2})(\$?)(\d+)(?::(\$?)([A-Z]{1,2})(\$?)(\d+))?(?![\w(!'])"
)


def letters(column):
    return letters((column - 1) // 26) + chr(65 + (column - 1) % 26) if column > 0 else ""


def number(text):
    return sum((ord(letter) - 64) * 26**n for n, letter in enumerate(reversed(text)))


def address(key):
    return f"{key[0]}!{letters(key[2])}{key[1]}"


class Area(NamedTuple):
    sheet: str
    row: int
    column: int
    rows: int = 1
    columns: int = 1

    def key(self, row=0, column=0):
        return (self.sheet, self.row + row, self.column + column)

    def each(self):
        return [self.key(r, c) for r in range(self.rows) for c in range(self.columns)]

    def part(self, row, column, rows=1, columns=1):
        return Area(self.sheet, self.row + row, self.column + column, rows, columns)

    def text(self, sheet=None, *, row_fixed=False, column_fixed=False):
        """The reference as it stands in a formula of `sheet`."""

        def corner(row, column):
            return f"{'$' * column_fixed}{letters(column)}{'$' * row_fixed}{row}"

        quoted = self.sheet if re.fullmatch(r"[^\W\d]\w*", self.sheet) else f"'{self.sheet}'"
        text = "" if sheet in (None, self.sheet) else f"{quoted}!"
        text += corner(self.row, self.column)
        if self.rows * self.columns > 1:
            text += ":" + corner(self.row + self.rows - 1, self.column + self.columns - 1)
        return text


@dataclass(frozen=True)
class Array:
    """An array formula, in its first cell."""

    rows: int
    columns: int
    formula: str
    dynamic: bool = False


@dataclass
class Book:
    """Cells, what the inputs are, and what the results ought to be."""

    cells: dict = field(default_factory=dict)
    names: dict = field(default_factory=dict)  # name → cell
    inputs: list = field(default_factory=list)  # (cells, function of (rng, samples) → array (cells, samples))
    truths: list = field(default_factory=list)  # (cells, function of {cell: values} → array (cells, samples))
    columns: list = field(default_factory=list)  # cells of one formula copied down
    products: list = field(default_factory=list)  # (area, formulas of the wrong products by cause)
    turned: list = field(
        default_factory=list
    )  # cells of elementary matrices with their active or passive opposites
    whole: list = field(default_factory=list)  # cells of a matrix that is written down at once, not multiplied
    extras: set = field(default_factory=set)  # determinants, norms, differences: not of the chain
    rows: list = field(default_factory=list)  # NC table: {name: cell} of each row
    task: dict = field(default_factory=dict)
    family: str = ""
    as_values: bool = False  # the file holds values only
    shared: bool = False  # formulas copied down are stored once, as Excel does

    def input_cells(self):
        return {key for keys, _ in self.inputs for key in keys}

    def arrays(self):
        return {key: content for key, content in self.cells.items() if isinstance(content, Array)}

    def formulas(self):
        """Cells with a formula that is not an input."""
        given = self.input_cells()
        return [key for key, content in self.cells.items() if key not in given and formula_of(content)]

    def sheets(self):
        return list(dict.fromkeys(key[0] for key in self.cells))


def formula_of(content):
    if isinstance(content, Array):
        return content.formula
    return content if isinstance(content, str) and content.startswith("=") else None


class CircularError(Exception):
    """A cell depends on itself."""


FAULT = np.full(SAMPLES, np.nan)


class Values:
    """The values of a book: numbers of shape (SAMPLES,), NaN for an error, or texts."""

    def __init__(self, book, seed=1, given=None):
        self.book, self.found, self.active = book, {}, set()
        self.spilled = {
            (key[0], key[1] + r, key[2] + c): (key, r, c)
            for key, content in book.arrays().items()
            for r in range(content.rows)
            for c in range(content.columns)
        }
        if given is None:
            rng, given = np.random.default_rng(seed), {}
            for keys, sampler in book.inputs:
                for key, values in zip(keys, sampler(rng, SAMPLES), strict=True):
                    values = np.array(values, dtype=float)
                    values[0] = self.formula(key, book.cells[key])[0]
                    given[key] = values
        self.found = dict(given)
        self.given = given

    def all(self):
        return {key: self[key] for key in {**self.book.cells, **self.spilled}}

    def __getitem__(self, key):
        if key not in self.found:
            if key in self.active:
                raise CircularError(address(key))
            self.active.add(key)
            self.found[key] = self.compute(key)
            self.active.discard(key)
        return self.found[key]

    def compute(self, key):
        if key in self.spilled:
            anchor, row, column = self.spilled[key]
            result = self.array(anchor)
            if result.ndim == 1:
                return result
            if (row >= result.shape[0] and result.shape[0] > 1) or (
                column >= result.shape[1] and result.shape[1] > 1
            ):
                return FAULT
            return result[min(row, result.shape[0] - 1), min(column, result.shape[1] - 1)]
        return self.formula(key, self.book.cells.get(key))

    def array(self, anchor):
        if ("array", anchor) not in self.found:
            self.found["array", anchor] = self.run(anchor, self.book.cells[anchor].formula)
        return self.found["array", anchor]

    def formula(self, key, content):
        """The value that `content` has in the cell `key`."""
        if content is None:
            return None
        if isinstance(content, str):
            if not content.startswith("="):
                return content
            result = self.run(key, content)
            if isinstance(result, np.ndarray) and result.ndim > 1:
                result = result[0, 0] if result.shape[:2] == (1, 1) else FAULT
            if isinstance(result, np.ndarray) and result.dtype.kind == "U":
                return str(result[0])
            return np.zeros(SAMPLES) if result is None else result
        return np.full(SAMPLES, float(content))

    def run(self, key, formula):
        with np.errstate(all="ignore"):
            try:
                result = eval(_compiled(formula), {"__builtins__": {}}, _Scope(self, key[0]))
            except (TypeError, ValueError, ZeroDivisionError, KeyError, NameError, np.linalg.LinAlgError):
                return FAULT
        if isinstance(result, _Grid):
            result = result.plain()
        if isinstance(result, (int, float, np.bool_)):
            result = np.full(SAMPLES, float(result))
        return result.astype(float) if isinstance(result, np.ndarray) and result.dtype == bool else result


class _Scope(dict):
    def __init__(self, values, sheet):
        super().__init__(FUNCTIONS)
        self.values, self.sheet = values, sheet
        self["cell"], self["grid"], self["name"] = self.cell, self.grid, self.name

    def cell(self, sheet, row, column):
        value = self.values[(sheet or self.sheet, row, column)]
        return np.zeros(SAMPLES) if value is None else value

    def grid(self, sheet, top, left, bottom, right):
        return _Grid(
            [
                [self.values[(sheet or self.sheet, row, column)] for column in range(left, right + 1)]
                for row in range(top, bottom + 1)
            ]
        )

    def name(self, name):
        value = self.values[self.values.book.names[name]]
        return np.zeros(SAMPLES) if value is None else value


class _Grid:
    """A range: `strict` for matrix functions, `loose` for sums, which pass over texts and empty cells."""

    def __init__(self, cells):
        self.cells = cells

    def convert(self, other):
        return np.array([[other(v) if v is None or isinstance(v, str) else v for v in row] for row in self.cells])

    def strict(self):
        return self.convert(lambda _: FAULT)

    def loose(self):
        return self.convert(lambda _: np.zeros(SAMPLES))

    def plain(self):
        return self.convert(lambda v: np.zeros(SAMPLES) if v is None else FAULT)

    def __mul__(self, other):
        return self.plain() * (other.plain() if isinstance(other, _Grid) else other)

    def __rmul__(self, other):
        return other * self.plain()

    def __sub__(self, other):
        return self.plain() - (other.plain() if isinstance(other, _Grid) else other)

    def __rsub__(self, other):
        return other - self.plain()

    def __add__(self, other):
        return self.plain() + (other.plain() if isinstance(other, _Grid) else other)

    def __neg__(self):
        return -self.plain()

    def __pow__(self, power):
        return self.plain() ** power


def _strict(value):
    value = value.strict() if isinstance(value, _Grid) else np.asarray(value)
    return value if value.ndim == 3 else value.reshape(1, 1, -1)


def _numbers(arguments):
    """All numbers of ranges and values, shape (n, SAMPLES)."""
    parts = []
    for value in arguments:
        value = value.loose() if isinstance(value, _Grid) else np.asarray(value, dtype=float)
        value = value if value.ndim else np.full(SAMPLES, float(value))
        parts.append(value.reshape(-1, SAMPLES))
    return np.vstack(parts)


def _mmult(a, b):
    a, b = _strict(a), _strict(b)
    if a.shape[1] != b.shape[0]:
        return FAULT
    # One cell without a number spoils the whole product.
    return np.einsum("ijs,jks->iks", a, b) + 0 * (a.sum(axis=(0, 1)) + b.sum(axis=(0, 1)))


def _transpose(value):
    if isinstance(value, _Grid):  # what is empty stays so: a product of matrices refuses it, a sum passes over it
        return _Grid([list(column) for column in zip(*value.cells, strict=True)])
    return np.swapaxes(_strict(value), 0, 1)


def _sumproduct(*arguments):
    parts = [value.loose() if isinstance(value, _Grid) else np.asarray(value) for value in arguments]
    if len({part.shape for part in parts}) > 1:
        return FAULT
    return np.prod(parts, axis=0).reshape(-1, SAMPLES).sum(axis=0)


def _square(value, function):
    value = np.moveaxis(_strict(value), 2, 0)
    return np.moveaxis(function(value), 0, -1) if value.shape[1] == value.shape[2] else FAULT


def _round(value, digits):
    value = value.plain() if isinstance(value, _Grid) else value
    scale = 10.0 ** np.asarray(digits)
    return np.sign(value) * np.floor(np.abs(value) * scale + 0.5) / scale


def _single(function):
    return lambda value: function(value.plain() if isinstance(value, _Grid) else np.asarray(value, dtype=float))


FUNCTIONS = {
    **{
        name: _single(getattr(np, name.lower()))
        for name in ("SIN", "COS", "TAN", "SQRT", "ABS", "RADIANS", "DEGREES")
    },
    "ASIN": _single(np.arcsin),
    "ACOS": _single(np.arccos),
    "ATAN": _single(np.arctan),
    "ATAN2": lambda x, y: np.where((x == 0) & (y == 0), np.nan, np.arctan2(y, x)),
    "SIGN": _single(np.sign),
    "PI": lambda: np.full(SAMPLES, np.pi),
    "ROUND": _round,
    "MOD": lambda a, b: a - b * np.floor(a / b),
    "POWER": lambda a, b: a**b,
    "IF": lambda test, a, b=0: np.where(test, a, b),
    "AND": lambda *tests: np.logical_and.reduce(tests),
    "SUM": lambda *arguments: _numbers(arguments).sum(axis=0),
    "SUMSQ": lambda *arguments: (_numbers(arguments) ** 2).sum(axis=0),
    "MAX": lambda *arguments: _numbers(arguments).max(axis=0),
    "MIN": lambda *arguments: _numbers(arguments).min(axis=0),
    "SUMPRODUCT": _sumproduct,
    "MMULT": _mmult,
    "TRANSPOSE": _transpose,
    "MDETERM": lambda value: _square(value, np.linalg.det),
    "MINVERSE": lambda value: _square(value, np.linalg.inv),
}
TOKEN = re.compile(
    r'(?P<text>"[^"]*")|(?P<function>[A-Z][A-Z0-9]*\()|(?P<reference>'
    + REFERENCE.pattern
    + r")|(?P<number>\d+\.?\d*(?:E[+-]?\d+)?)|(?P<name>[^\W\d]\w*)|(?P<other><>|<=|>=|.)"
)
OPERATORS = {"=": "==", "<>": "!=", "^": "**"}
_CODE = {}


def _compiled(formula):
    """The formula as Python's own code."""
    if formula not in _CODE:
        parts = []
        for match in TOKEN.finditer(formula, 1):
            text = match.group()
            if match["reference"]:
                sheet, _, column, _, row, _, last_column, _, last_row = REFERENCE.match(
                    formula, match.start()
                ).groups()
                sheet = repr(sheet[:-1].strip("'") if sheet else None)
                last = f",{last_row},{number(last_column)}" if last_row else ""
                text = f"{'grid' if last else 'cell'}({sheet},{row},{number(column)}{last})"
            elif match["name"]:
                text = f"name({text!r})"
            parts.append(OPERATORS.get(text, text))
        _CODE[formula] = compile("".join(parts), formula, "eval")
    return _CODE[formula]


# The file.

TYPES = "http://schemas.openxmlformats.org/officeDocument/2006/relationships"
MAIN = 'xmlns="http://schemas.openxmlformats.org/spreadsheetml/2006/main"'
PACKAGE = 'xmlns="http://schemas.openxmlformats.org/package/2006/'
METADATA = (
    f'<metadata {MAIN} xmlns:xda="http://schemas.microsoft.com/office/spreadsheetml/2017/dynamicarray">'
    '<metadataTypes count="1"><metadataType name="XLDAPR" minSupportedVersion="120000" copy="1" pasteAll="1" '
    'pasteValues="1" merge="1" splitFirst="1" rowColShift="1" clearFormats="1" clearComments="1" assign="1" '
    'coerce="1" cellMeta="1"/></metadataTypes><futureMetadata name="XLDAPR" count="1">'
    "<bk><extLst>"
    '<ext uri="{bdbb8cdc-fa1e-496e-a857-3c3f30c029c3}"><xda:dynamicArrayProperties fDynamic="1" fCollapsed="0"/>'
    "</ext></extLst></bk></futureMetadata>"
    '<cellMetadata count="1"><bk><rc t="1" v="0"/></bk></cellMetadata></metadata>'
)


def save(path, book, values=None, *, cached=True, extra=()):
    """Write `book` as a spreadsheet program does: formulas with the values they had when it was saved.

    `extra` are further parts, as (name, content); without `cached`, whoever opens it must calculate.
    """
    if values is None:
        values = Values(book).all()
    sheets = book.sheets()
    parts = {
        "[Content_Types].xml": f'<Types {PACKAGE}content-types">'
        '<Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/>'
        '<Default Extension="xml" ContentType="application/xml"/>'
        + _override("workbook", "sheet.main")
        + "".join(_override(f"worksheets/sheet{n + 1}", "worksheet") for n in range(len(sheets)))
        + _override("metadata", "sheetMetadata")
        + "</Types>",
        "_rels/.rels": _relations([("officeDocument", "xl/workbook.xml")]),
        "xl/workbook.xml": f'<workbook {MAIN} xmlns:r="{TYPES}"><sheets>'
        + "".join(
            f'<sheet name={quoteattr(name)} sheetId="{n + 1}" r:id="rId{n + 1}"/>' for n, name in enumerate(sheets)
        )
        + "</sheets>"
        + _names(book)
        + "</workbook>",
        "xl/_rels/workbook.xml.rels": _relations(
            [
                *(("worksheet", f"worksheets/sheet{n + 1}.xml") for n in range(len(sheets))),
                ("sheetMetadata", "metadata.xml"),
            ]
        ),
        "xl/metadata.xml": METADATA,
    }
    for n, sheet in enumerate(sheets):
        parts[f"xl/worksheets/sheet{n + 1}.xml"] = _sheet(book, sheet, values, cached)
    head = '<?xml version="1.0" encoding="UTF-8" standalone="yes"?>\n'
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in parts.items():
            archive.writestr(name, head + content)
        for name, content in extra:
            archive.writestr(name, content)


def _override(name, kind):
    content = f"application/vnd.openxmlformats-officedocument.spreadsheetml.{kind}+xml"
    return f'<Override PartName="/xl/{name}.xml" ContentType="{content}"/>'


def _relations(targets):
    return (
        f'<Relationships {PACKAGE}relationships">'
        + "".join(
            f'<Relationship Id="rId{n + 1}" Type="{TYPES}/{kind}" Target="{target}"/>'
            for n, (kind, target) in enumerate(targets)
        )
        + "</Relationships>"
    )


def _names(book):
    if not book.names:
        return ""
    return (
        "<definedNames>"
        + "".join(
            f"<definedName name={quoteattr(name)}>{escape(Area(*key).text('', row_fixed=True, column_fixed=True))}"
            "</definedName>"
            for name, key in book.names.items()
        )
        + "</definedNames>"
    )


def translated(formula, rows):
    """The formula copied so many rows down."""

    def moved(match):
        sheet, *parts = match.groups()
        text = sheet or ""
        for n, (column_fixed, column, row_fixed, row) in enumerate((parts[:4], parts[4:])):
            if row:
                text += ":" * n + column_fixed + column + row_fixed + (row if row_fixed else str(int(row) + rows))
        return text

    return REFERENCE.sub(moved, formula)


def _shared(book, sheet):
    """The formulas that are stored once for a column: {cell: its <f> element}."""
    elements = {}
    for number, column in enumerate(book.columns if book.shared else ()):
        first, content = column[0], book.cells.get(column[0])
        if first[0] != sheet or not isinstance(content, str):
            continue
        last = f"{letters(column[-1][2])}{column[-1][1]}"
        elements[first] = (
            f'<f t="shared" ref="{letters(first[2])}{first[1]}:{last}" si="{number}">{escape(content[1:])}</f>'
        )
        for key in column[1:]:
            if book.cells.get(key) == translated(content, key[1] - first[1]):
                elements[key] = f'<f t="shared" si="{number}"/>'
    return elements


def _sheet(book, sheet, values, cached):
    rows, shared = {}, _shared(book, sheet)
    for key in {**book.cells, **values}:
        if key[0] == sheet and values.get(key) is not None:
            rows.setdefault(key[1], []).append(key)
    lines = []
    for row in sorted(rows):
        cells = "".join(
            _cell(book, key, values[key], cached, shared.get(key))
            for key in sorted(rows[row], key=lambda key: key[2])
        )
        lines.append(f'<row r="{row}">{cells}</row>')
    return f"<worksheet {MAIN}><sheetData>{''.join(lines)}</sheetData></worksheet>"


def _cell(book, key, value, cached, shared):
    content, place = book.cells.get(key), f'r="{letters(key[2])}{key[1]}"'
    formula = formula_of(content)
    if isinstance(value, str):
        if formula is None:
            return f'<c {place} t="inlineStr"><is><t xml:space="preserve">{escape(value)}</t></is></c>'
        return f'<c {place} t="str"><f>{escape(formula[1:])}</f><v>{escape(value)}</v></c>'
    inner = shared or ("" if formula is None else f"<f>{escape(formula[1:])}</f>")
    if not cached and formula is None and key not in book.cells:
        return ""  # the rest of an array
    if isinstance(content, Array):
        last = f"{letters(key[2] + content.columns - 1)}{key[1] + content.rows - 1}"
        span = f"{letters(key[2])}{key[1]}" + (f":{last}" if content.rows * content.columns > 1 else "")
        inner = f'<f t="array" ref="{span}">{escape(formula[1:])}</f>'
        place += ' cm="1"' * content.dynamic
    if not cached and formula is not None:
        return f"<c {place}>{inner}</c>"
    if np.isfinite(value[0]):
        return f"<c {place}>{inner}<v>{float(value[0])!r}</v></c>"
    return f'<c {place} t="e">{inner}<v>#VALUE!</v></c>'
