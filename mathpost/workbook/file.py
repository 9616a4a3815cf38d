"""Workbooks read as plain cells, safely: what could harm or mislead is refused by name before it is opened."""

import csv
import io
import os
import re
import shutil
import signal
import subprocess
import tempfile
import zipfile
from dataclasses import dataclass, field
from pathlib import Path

import openpyxl
from openpyxl.utils import get_column_letter, range_boundaries
from openpyxl.worksheet.formula import ArrayFormula, DataTableFormula

from mathpost.errors import InputError, OutputError
from mathpost.workbook.safety import MEGABYTE, PART_LIMIT, inspect

LONG_SHEET = 4 * MEGABYTE  # a sheet beyond this is cut after the rows that are read
COLUMN_LIMIT = 200
NUMBER_AS_TEXT = re.compile(r"\s*[-+−–]?\s*\d+(?:[.,]\d+)?\s*°?\s*")


@dataclass(frozen=True)
class Cell:
    """One cell that is not empty.

    Attributes
    ----------
    value : float, str, bool or None
        None if a formula was never calculated.
    formula : str
        Empty for a constant; of an array formula, the formula that stands in its first cell.
    array : str
        The range of the array formula that the cell belongs to, or empty.
    error : bool
        Whether the value is an error such as #VALUE!.
    anchor : tuple
        The first (row, column) of that range.
    """

    value: object
    formula: str = ""
    array: str = ""
    error: bool = False
    anchor: tuple = ()

    @property
    def number(self):
        """The value as a float, or None if it is not a number."""
        is_number = isinstance(self.value, int | float) and not isinstance(self.value, bool)
        return float(self.value) if is_number else None

    @property
    def meant(self):
        """The number that a text such as ``54,7356`` or ``54.7356°`` means; `number` where one stands."""
        if not isinstance(self.value, str) or self.formula:
            return self.number
        found = NUMBER_AS_TEXT.fullmatch(self.value) and re.search(r"[.,°]", self.value)
        return float(re.sub(r"[\s°]", "", self.value).translate(str.maketrans(",−–", ".--"))) if found else None


@dataclass(frozen=True)
class Sheet:
    """The cells of a sheet by (row, column), both from 1; `spans` gives the last cell of each merged range."""

    name: str
    cells: dict
    spans: dict = field(default_factory=dict)

    def address(self, place):
        """Return a place as ``Sheet!B5``."""
        quoted = f"'{self.name}'" if re.search(r"[^\w.]", self.name) else self.name
        return f"{quoted}!{local_address(place)}"


@dataclass(frozen=True)
class Book:
    """A workbook: its sheets, and its named ranges as name → (sheet name, (row, column) corners)."""

    path: Path
    sheets: tuple
    names: dict
    notes: tuple = ()

    def sheet(self, name):
        """Return the sheet called `name`, whatever the case; raise `InputError` if there is none."""
        for sheet in self.sheets:
            if sheet.name.lower() == name.lower():
                return sheet
        known = ", ".join(sheet.name for sheet in self.sheets)
        raise InputError(str(self.path), f"one of the sheets {known}", repr(name))


def local_address(place):
    """Return (row, column) as ``B5``."""
    return f"{get_column_letter(place[1])}{place[0]}"


def read(path, *, rows=20_000):
    """Read a spreadsheet; a formula that was never calculated has no value.

    Parameters
    ----------
    path : str or path-like
        An .xlsx workbook, a .csv file, or, where LibreOffice is there to convert it, .ods, .xls or .et.
    rows : int, keyword only
        How many rows of each sheet to read; a note says so if there are more.

    Returns
    -------
    Book

    Raises
    ------
    InputError
        If the file is none of these, is encrypted, holds macros, links or embedded objects, or unpacks to more than
        is safe.
    """
    path = Path(path)
    kind = inspect(path)
    if kind == "text":
        return _read_text(path, rows)
    if kind == "xlsx":
        return _read(path, path, rows)
    with tempfile.TemporaryDirectory() as folder:
        converted = recalculate(path, folder, kind)
        inspect(converted)
        return _read(converted, path, rows)


def _read_text(path, rows):
    """Cells of a text file between commas, semicolons or tabs; a decimal comma where semicolons or tabs divide."""
    content = path.read_bytes()
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = content.decode("gb18030", "replace")
    divider = max(
        ";\t,", key=lambda sign: sum(sign in line for line in text.splitlines()[:50]) - 0.5 * (sign == ",")
    )
    cells = {}
    for row, line in enumerate(csv.reader(io.StringIO(text), delimiter=divider), 1):
        for column, field_text in enumerate(line if row <= rows else (), 1):
            plain = field_text.strip()
            if plain.startswith("="):
                cells[row, column] = Cell(None, plain)
            elif plain:
                number = plain if divider == "," else plain.replace(",", ".")
                is_number = re.fullmatch(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?", number)
                cells[row, column] = Cell(float(number) if is_number else plain)
    if not cells:
        raise InputError(str(path), "a sheet with cells", "an empty file")
    return Book(path, (Sheet(path.stem, cells),), {})


def _read(file, path, rows):
    """Read the cells of `file`, which is `path` itself or a recalculated copy of it."""
    file = _shortened(file, rows)
    try:
        values = openpyxl.load_workbook(file, read_only=True, data_only=True, keep_links=False)
        formulas = openpyxl.load_workbook(file, read_only=True, keep_links=False)
    except Exception as error:  # openpyxl raises whatever its parser meets
        raise InputError(str(path), "an .xlsx workbook", f"one that cannot be read ({error})") from None
    try:
        notes, sheets = [], []
        for value_sheet, formula_sheet in zip(values.worksheets, formulas.worksheets, strict=True):
            sheet, more = _read_sheet(path, value_sheet, formula_sheet, rows)
            sheets.append(Sheet(sheet.name, sheet.cells, _merged(file, formula_sheet)))
            if more:
                notes.append(f"only the first {rows} rows of sheet {sheet.name} were read")
        names = dict(_names(formulas.defined_names, ""))
        for sheet in formulas.worksheets:
            names.update(_names(getattr(sheet, "defined_names", {}), sheet.title))
    except InputError:
        raise
    except Exception as error:
        raise InputError(str(path), "an .xlsx workbook", f"one that cannot be read ({error})") from None
    finally:
        values.close()
        formulas.close()
    if not any(sheet.cells for sheet in sheets):
        raise InputError(str(path), "a sheet with cells", "only empty ones")
    return Book(path, tuple(sheets), names, tuple(notes))


def _shortened(file, rows):
    """Return `file`, or a copy whose long sheets end after `rows` rows: openpyxl would read to the end."""
    with zipfile.ZipFile(file) as archive:
        members = archive.infolist()
        if not any(_is_long(member) for member in members):
            return file
        copy = io.BytesIO()
        with zipfile.ZipFile(copy, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as short:
            for member in members:
                content = _first_rows(archive, member, rows) if _is_long(member) else archive.read(member)
                short.writestr(member.filename, content)
    return copy


def _is_long(member):
    return member.filename.startswith("xl/worksheets/") and member.file_size > LONG_SHEET


def _first_rows(archive, member, rows):
    """The part of a sheet up to one row more than `rows`, closed properly; all of it if it has no more."""
    content, count, end = bytearray(), 0, re.compile(rb"</((?:\w+:)?)row>")
    with archive.open(member) as part:
        while chunk := part.read(MEGABYTE):
            start = max(0, len(content) - 16)
            content += chunk
            # A tag may lie across two chunks; one that ended in the last chunk is not counted again.
            ends = [found for found in end.finditer(content, start) if found.end() > len(content) - len(chunk)]
            if count + len(ends) > rows:
                last = ends[rows - count]
                prefix = last[1]
                return bytes(content[: last.end()]) + b"</%ssheetData></%sworksheet>" % (prefix, prefix)
            count += len(ends)
            if len(content) > 2 * PART_LIMIT:
                found = f"{count} rows in {len(content) // MEGABYTE} MB"
                raise InputError(
                    f"{archive.filename or 'workbook'}, {member.filename}", "rows of a sensible length", found
                )
    return bytes(content)


def _read_sheet(path, value_sheet, formula_sheet, rows):
    value_sheet.reset_dimensions()
    formula_sheet.reset_dimensions()
    limits = {"max_row": rows + 1}
    cells, arrays, more = {}, [], False
    for value_row, formula_row in zip(
        value_sheet.iter_rows(**limits), formula_sheet.iter_rows(**limits), strict=False
    ):
        for value, formula in zip(value_row[:COLUMN_LIMIT], formula_row, strict=False):
            if value.value is None and formula.value is None:
                continue
            place = (formula.row, formula.column)
            if place[0] > rows:
                more = True
                continue
            text, array = _formula(formula.value)
            if array:
                arrays.append((array, text))
            cells[place] = Cell(value.value, text, array, value.data_type == "e", place if array else ())
    for array, text in arrays:
        left, top, right, bottom = range_boundaries(array)
        for place in [
            (r, c) for r in range(top, min(bottom, rows) + 1) for c in range(left, min(right, COLUMN_LIMIT) + 1)
        ]:
            inner = cells.get(place, Cell(None))
            if not inner.formula:
                cells[place] = Cell(inner.value, text, array, inner.error, (top, left))
    return Sheet(formula_sheet.title, cells), more


def _formula(value):
    """The text of a formula and the range of its array; two empty strings for a constant."""
    if isinstance(value, ArrayFormula):
        return f"={(value.text or '').lstrip('=')}", value.ref
    if isinstance(value, DataTableFormula):
        return "=TABLE()", ""
    return (value, "") if isinstance(value, str) and value.startswith("=") else ("", "")


def _merged(file, sheet):
    """The last place of each merged range by its first, which openpyxl does not tell when it only reads."""
    with zipfile.ZipFile(file) as archive:
        part = sheet._worksheet_path.lstrip("/")
        if archive.getinfo(part).file_size > PART_LIMIT:
            return {}
        text = archive.read(part)
    spans = {}
    for found in re.findall(rb'<(?:\w+:)?mergeCell\s[^>]*ref="([A-Z]+\d+:[A-Z]+\d+)"', text):
        left, top, right, bottom = range_boundaries(found.decode())
        spans[top, left] = (bottom, right)
    return spans


def _names(defined, own_sheet):
    for name, definition in defined.items():
        try:
            destinations = list(definition.destinations)
        except (ValueError, TypeError, AttributeError):
            continue
        if len(destinations) == 1:
            sheet, area = destinations[0]
            try:
                left, top, right, bottom = range_boundaries(area)
            except (ValueError, TypeError):
                continue
            if None not in (left, top, right, bottom):
                yield name, (sheet or own_sheet, (top, left), (bottom, right))


def recalculate(path, folder, kind="xlsx"):
    """Have LibreOffice calculate the spreadsheet `path`; return a copy as .xlsx, which it puts into `folder`.

    Raises
    ------
    InputError
        If LibreOffice is not on the PATH or cannot do it.
    """
    office, expected = shutil.which("soffice"), "an .xlsx workbook or a .csv file"
    if office is None:
        raise InputError(str(path), expected, f"another format, .{kind}: save it as .xlsx, or install LibreOffice")
    folder = Path(folder)
    source, result = folder / f"source.{kind}", folder / "calculated" / "source.xlsx"
    try:
        shutil.copyfile(path, source)
    except OSError as error:
        raise OutputError(f"{folder}: not written, {error.strerror or error}") from None
    profile = (folder / "profile").resolve().as_uri()
    command = [office, "--headless", "--norestore", f"-env:UserInstallation={profile}", "--convert-to", "xlsx"]
    command += ["--outdir", str(result.parent), str(source)]
    quiet = {"stdin": subprocess.DEVNULL, "stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    # In a session of its own, because LibreOffice is a script that starts a program.
    with subprocess.Popen(command, start_new_session=True, **quiet) as process:
        try:
            process.wait(timeout=120)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL) if hasattr(os, "killpg") else process.kill()
    if not result.exists():
        raise InputError(str(path), expected, "what LibreOffice could not convert")
    return result
