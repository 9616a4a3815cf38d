"""Workbooks read as plain cells, safely: what could harm or mislead is refused by name before it is opened."""

from __future__ import annotations

import csv
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing, suppress
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from subprocess import DEVNULL
from typing import IO, Any
from xml.etree.ElementTree import Element

import openpyxl
from openpyxl.utils import get_column_letter, range_boundaries
from openpyxl.workbook.defined_name import DefinedNameDict
from openpyxl.worksheet._read_only import ReadOnlyWorksheet
from openpyxl.worksheet._reader import FORMULA_TAG, WorkSheetParser
from openpyxl.worksheet.formula import ArrayFormula, DataTableFormula

from mathpost.errors import InputError, OutputError
from mathpost.files import NUMBER
from mathpost.teaching.bounds import TooLarge
from mathpost.teaching.workbook.sheet.formula import Area
from mathpost.teaching.workbook.sheet.place import Place
from mathpost.teaching.workbook.sheet.safety import inspect

COLUMN_LIMIT = 200
MOST_CELLS = 300_000
NUMBER_AS_TEXT = re.compile(r"[-+−–]?\d+(?:[.,]\d+)?°?")


@dataclass(frozen=True)
class Cell:
    """One cell that is not empty; `value` is None if a formula was never calculated.

    A constant has no `formula`. A cell of an array formula has that of its first cell, whose place is `anchor`.
    """

    value: Any  # a number, a text, a truth value or a date
    formula: str = ""
    error: bool = False
    anchor: tuple[int, int] | tuple[()] = ()

    @property
    def number(self) -> float | None:
        """The value as a float, or None if it is not a number."""
        if isinstance(self.value, int | float) and not isinstance(self.value, bool):
            return float(self.value)
        return None

    @property
    def meant(self) -> float | None:
        """The number that a text such as ``54,7356`` or ``54.7356°`` means; `number` where the cell has one."""
        text = "" if self.formula else re.sub(r"\s", "", str(self.value))
        if not isinstance(self.value, str) or not NUMBER_AS_TEXT.fullmatch(text) or not re.search("[.,°]", text):
            return self.number
        return float(text.translate(str.maketrans(",−–", ".--", "°")))

    @property
    def counts(self) -> float | None:
        """The number that a constant is in arithmetic: 1 for TRUE, 5 for the text ``5``; or None."""
        if isinstance(self.value, bool):
            return float(self.value)
        if isinstance(self.value, str) and re.fullmatch(rf"\s*{NUMBER}\s*", self.value):
            return float(self.value)
        return self.meant


EMPTY = Cell(None)


@dataclass(frozen=True)
class Book:
    """A workbook: its sheets' names; `Cell`s by (sheet, row, column) from 1; an `Area` or formula by NAME."""

    path: Path
    sheets: tuple[str, ...]
    cells: dict[Place, Cell]
    names: dict[str, Area | str]
    notes: tuple[str, ...] = ()


def local_address(place: tuple[int, int]) -> str:
    """Return (row, column) as ``B5``."""
    return f"{get_column_letter(place[1])}{place[0]}"


def read(path: str | PathLike[str], *, rows: int = 20_000) -> Book:
    """Read the first `rows` rows of each sheet of an .xlsx or .csv file, or of what LibreOffice converts."""
    path = Path(path)
    kind = inspect(path)
    if kind in ("text", "xlsx"):
        return _read_text(path, rows) if kind == "text" else _read(path, path, rows)
    with tempfile.TemporaryDirectory() as folder:
        inspect(file := recalculate(path, folder, kind))
        return _read(file, path, rows)


def _read_text(path: Path, rows: int) -> Book:
    """Cells of a text file between commas, semicolons or tabs; a decimal comma where semicolons or tabs divide."""
    content = path.read_bytes()
    cells: dict[Place, Cell] = {}
    try:
        lines = content.decode("utf-8-sig").splitlines()
    except UnicodeDecodeError:
        lines = content.decode("gb18030", "replace").splitlines()
    divider = max(";\t,", key=lambda sign: sum(sign in line for line in lines[:50]) - 0.5 * (sign == ","))
    for row, line in enumerate(csv.reader(lines[:rows], delimiter=divider), 1):
        for column, text in enumerate(map(str.strip, line), 1):
            number = text if divider == "," else text.replace(",", ".")
            if text.startswith("="):
                cells[path.stem, row, column] = Cell(None, text)
            elif text:
                is_number = re.fullmatch(rf"{NUMBER}(?:[eE][-+]?\d+)?", number)
                cells[path.stem, row, column] = Cell(float(number) if is_number else text)
    if not cells:
        raise InputError(str(path), "a sheet with cells", "an empty file")
    _numbers_are_finite(path, cells)
    return Book(path, (path.stem,), cells, {})


def _read(file: Path, path: Path, rows: int) -> Book:
    """Read the cells of `file`, which is `path` itself or a recalculated copy of it."""
    cells: dict[Place, Cell] = {}
    notes: list[str] = []
    try:
        with closing(openpyxl.load_workbook(file, read_only=True, data_only=True, keep_links=False)) as book:
            names = dict(_names(book.defined_names, "", book.sheetnames))
            for sheet in book.worksheets:
                own, more = _cells(sheet, rows)
                cells |= own
                _numbers_are_finite(path, own)
                if len(cells) > MOST_CELLS:
                    raise TooLarge(f"more than {MOST_CELLS} cells")
                notes += [f"only the first {rows} rows of sheet {sheet.title} were read"] * more
                names.update(_names(getattr(sheet, "defined_names", {}), sheet.title, book.sheetnames))
    except (TooLarge, MemoryError, InputError):
        raise
    except Exception as error:  # openpyxl raises whatever its parser meets
        raise InputError(str(path), "an .xlsx workbook", f"one that cannot be read ({error})") from None
    if not cells:
        raise InputError(str(path), "a sheet with cells", "only empty ones")
    return Book(path, tuple(book.sheetnames), cells, names, tuple(notes))


def _numbers_are_finite(path: Path, cells: Mapping[Place, Cell]) -> None:
    for place, cell in cells.items():
        if isinstance(cell.value, int | float) and not abs(cell.value) <= sys.float_info.max:
            raise InputError(f"{path}, {place[0]}!{local_address(place[1:])}", "a finite number", "one that is not")


class _Parser(WorkSheetParser):
    """openpyxl's parser of a sheet: values and formulas in one pass, where it has the ones or the others."""

    def __init__(self, source: IO[bytes], sheet: ReadOnlyWorksheet) -> None:
        book = sheet.parent
        formats = {"date_formats": book._date_formats, "timedelta_formats": book._timedelta_formats}
        super().__init__(source, sheet._shared_strings, data_only=True, epoch=book.epoch, **formats)

    def parse_cell(self, element: Element) -> dict[str, Any]:
        cell = super().parse_cell(element)
        is_constant = element.find(FORMULA_TAG) is None
        return cell | {"formula": cell["value"] if is_constant else self.parse_formula(element)}


def _cells(sheet: ReadOnlyWorksheet, rows: int) -> tuple[dict[Place, Cell], bool]:
    """Place → `Cell`, and whether there are more rows."""
    cells: dict[Place, Cell] = {}
    arrays, more = [], False
    with sheet._get_source() as source:
        for row, found in _Parser(source, sheet).parse():
            found = [each for each in found if each["column"] <= COLUMN_LIMIT and each["formula"] is not None]
            more = row > rows and bool(found)
            if len(cells) > MOST_CELLS:
                raise TooLarge(f"more than {MOST_CELLS} cells")
            if more:
                break
            for each in found:
                place, text = (sheet.title, row, each["column"]), each["formula"]
                if isinstance(text, ArrayFormula):
                    arrays.append((place, text.ref, f"={(text.text or '').lstrip('=')}"))
                text = "=TABLE()" if isinstance(text, DataTableFormula) else text
                text = text if isinstance(text, str) and text.startswith("=") else ""
                cells[place] = Cell(each["value"], text, each["data_type"] == "e")
    for (title, *anchor), reference, text in arrays:
        left, top, right, bottom = range_boundaries(reference)
        area = Area(title, top, left, min(bottom, rows), min(right, COLUMN_LIMIT))
        for place in area.places:
            inner = cells.get(place, EMPTY)
            if not inner.formula:
                cells[place] = Cell(inner.value, text, inner.error, tuple(anchor))
    return cells, more


def _names(defined: DefinedNameDict, own_sheet: str, sheets: Sequence[str]) -> Iterator[tuple[str, Area | str]]:
    for name, definition in defined.items():
        try:
            ((sheet, area),) = definition.destinations
            left, top, right, bottom = range_boundaries(area)
        except (ValueError, TypeError, AttributeError):  # a constant, or a formula
            yield name.upper(), f"={definition.attr_text or ''}"
            continue
        if None not in (left, top, right, bottom) and (sheet or own_sheet) in sheets:
            (top, bottom), (left, right) = sorted((top, bottom)), sorted((left, right))
            yield name.upper(), Area(sheet or own_sheet, top, left, bottom, right, (True, True))


def recalculate(path: str | PathLike[str], folder: str | PathLike[str], kind: str = "xlsx") -> Path:
    """Have LibreOffice calculate the spreadsheet `path`; return a copy as .xlsx, which it puts into `folder`."""
    office, expected = shutil.which("soffice"), "an .xlsx workbook or a .csv file"
    if office is None:
        raise InputError(str(path), expected, f"another format, .{kind}: save it as .xlsx, or install LibreOffice")
    folder = Path(folder)
    source, result = folder / f"source.{kind}", folder / "calculated" / "source.xlsx"
    try:
        shutil.copyfile(path, source)
    except OSError as error:
        raise OutputError(f"{folder}: not written, {error.strerror or error}") from None
    profile = f"-env:UserInstallation={(folder / 'profile').resolve().as_uri()}"
    command = [office, "--headless", "--norestore", profile, "--convert-to", "xlsx"]
    command += ["--outdir", str(result.parent), str(source)]
    # In a session of its own, because LibreOffice is a script that starts a program.
    process = subprocess.Popen(command, start_new_session=True, stdin=DEVNULL, stdout=DEVNULL, stderr=DEVNULL)
    try:
        with suppress(subprocess.TimeoutExpired):
            process.wait(timeout=120)
    finally:  # out of time, or interrupted
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGKILL) if hasattr(os, "killpg") else process.kill()
        process.wait()
    if not result.exists():
        raise InputError(str(path), expected, "what LibreOffice could not convert")
    return result
