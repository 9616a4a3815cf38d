"""Tables of readings: CSV files with named columns, whose errors name the file and the line.

A file begins with comments that name its source and state settings, then the column names, then one reading to a
line::

    # source: Huang et al. (source 001), section 4
    # unit = µm
    angle,x,y,remark
    0,16,4,table warm

Files are read as programs write them: with a byte order mark, in UTF-8, GBK or Windows-1252, with commas,
or with semicolons, tabs, bars or spaces and decimal commas; with lines before the column names and after the
readings, commas at the ends of lines, columns of times, temperatures, numbers and remarks. `Table.notes` say what
was not read. Columns may have the names of data/measurements/words.toml. A unit may follow a column's name,
``x (µm)``, or be given in a line of units below the names, or in every cell of a column.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NoReturn

import numpy as np

from mathpost.errors import InputError, as_array, one_line
from mathpost.files import MINUS, NUMBER, read_bytes
from mathpost.shop.measure.headings import (
    Row,
    cells_of,
    check_aside,
    check_names,
    find_header,
    reads,
    row_of,
)
from mathpost.shop.measure.vocabulary import LONGEST, Names, measure, unit_names

COMMENT = ("#", "%", "//")
KNOWN = ("unit", "method", "axis", "positive", "sigma", "centre", "start")  # settings that a comment may make
# Pattern of a setting; after a colon at most two words, or it is a sentence.
SETTING = re.compile(r"(unit \S+|\w+)\s*(?:=\s*(.*)|[:,;\t]\s*(\S+(?: \S+)?))")


class Table(dict[str, Any]):
    """Columns of a CSV file by name: float arrays, shape (rows,), or lists of strings, and what else the file says.

    `lines` are the line numbers of the rows, `header` is that of the column names. `settings` holds the values of
    comments such as ``# unit = µm``, and under ``"unit x"`` the unit in a column's name, ``x (µm)``. `notes` are
    sentences on what was not read.
    """

    def __init__(self, path: Path | str) -> None:
        self.path = one_line(str(path))
        self.header = ""
        self.lines: tuple[int, ...] = ()
        self.settings: dict[str, str] = {}
        self.notes: tuple[str, ...] = ()

    def where(self, row: int, name: str) -> str:
        """Say where in the file the entry of `row` (from 0) in column `name` is."""
        return f"{self.path}, line {self.lines[row]}, column {name!r}"

    def refuse(self, expected: str, found: str | None = "") -> NoReturn:
        """Raise `InputError` for the file as a whole, at its header."""
        raise InputError(self.header, expected, found or "none") from None

    def need(self, names: Iterable[str], expected: str) -> None:
        """Refuse a table that lacks one of the columns `names`."""
        for name in names:
            if name not in self:
                self.refuse(expected, f"no {name!r}")

    def choice(self, key: str, choices: dict[str, Any]) -> Any:
        """Return the value in `choices`, a dict, that a setting names."""
        said = self.settings.get(key)
        if said not in choices:
            self.refuse(f"a line # {key} = {' or '.join(choices)}", said and repr(said))
        return choices[said]

    def numbers(self, key: str, count: int) -> np.ndarray:
        """Return the `count` numbers of a setting."""
        said = self.settings.get(key, "")
        try:
            return as_array([float(word) for word in re.split(r"[\s,;]+", said.strip())], count, key)
        except ValueError:
            self.refuse(f"a line # {key} = {' '.join(['number'] * count)}", said and repr(said))

    def require(self, name: str, good: np.ndarray, expected: str) -> None:
        """Raise `InputError` at the first row for which the boolean array `good` is false."""
        for row in np.flatnonzero(~np.asarray(good))[:1]:
            raise InputError(self.where(row, name), expected, f"{self[name][row]:.10g}")

    def check_angles(self, name: str) -> None:
        """Refuse angles that cannot be degrees: beyond ±360, or the round numbers of radians."""
        angles = self[name]
        self.require(name, np.abs(angles) <= 360, "degrees within ±360 (other units, or a lost point?)")
        steps = angles / (math.pi / 6)
        radians = (np.abs(steps - np.round(steps)) < 1e-3) & (np.round(steps) != 0)
        if np.abs(angles).max() < 2 * math.pi + 1e-3:
            self.require(name, ~radians, "degrees (these look like radians)")

    def check_increasing(self, name: str, within: Iterable[str] = ()) -> None:
        """Refuse numbers that do not increase from row to row, as long as the columns `within` stay the same."""
        values, groups = self[name], list(zip(*(self[column] for column in within), strict=True))
        for row in range(1, len(self.lines)):
            if groups and groups[row] != groups[row - 1]:
                continue
            if values[row] <= values[row - 1]:
                what = "a duplicate" if values[row] == values[row - 1] else "out of order"
                expected = f"more than {values[row - 1]:.10g}, which is on line {self.lines[row - 1]}"
                raise InputError(self.where(row, name), expected, f"{values[row]:.10g}, {what}")

    def unit(self, name: str, kind: str, default: str | None = None) -> float:
        """Return the size of the unit of column `name`, in mm or radians; of a dial division if that is stated.

        `kind` is ``"length"`` or ``"angle"``; `default` the unit if the file states none. Without one `InputError`
        asks for it.
        """
        stated = self.settings.get(f"unit {name}") or self.settings.get("unit") or default
        units = unit_names(kind)
        expected = f"its unit, in a line such as # unit = {units[1]}: one of {', '.join(units)}"
        if kind == "length":
            expected += ", or the size of a dial's division, # unit = 0.002 mm"
        measures, size = measure(stated or "")
        if measures != kind:
            raise InputError(self.where(0, name), expected, "none" if stated is None else repr(stated))
        return size

    def obey_units(self, names: Iterable[str]) -> None:
        """Convert columns to mm or degrees from the unit that follows their names."""
        for name in names:
            measures, size = measure(self.settings.get(f"unit {name}", ""))
            if measures:
                self[name] *= size if measures == "length" else math.degrees(size)


def read(path: Path | str, columns: Sequence[str], **how: Any) -> Table:
    """Read a CSV file as a `Table`; parameters as in `parse`. `InputError` also if it cannot be read."""
    return parse(scan(path), columns, **how)


@dataclass(frozen=True)
class Lines:
    """The lines of a file that are not comments, with their numbers, and the settings of all lines."""

    path: str
    lines: tuple[tuple[int, str], ...]  # number, text
    settings: dict[str, str]
    whole: bool  # whether the last line ends in a line break


def scan(path: Path | str) -> Lines:
    """Read a text file as `Lines`; `InputError` if it cannot be read, or makes a setting twice."""
    content = _text(path)
    lines: list[tuple[int, str]] = []
    settings: dict[str, str] = {}
    for number, line in enumerate(content.splitlines(), 1):
        comment = line.lstrip(' "').startswith(COMMENT)
        said = SETTING.fullmatch(line.strip(' "#%/\t;,'))
        key = said[1] if said and said[1].startswith("unit ") else said[1].casefold() if said else ""
        value = (said[2] or said[3] or "").strip(" \"'") if said else ""
        if value and (key in KNOWN or key.startswith("unit ")):
            if comment and settings.get(key, value) != value:
                raise InputError(f"{path}, line {number}", f"one line # {key} = …", f"a different one, {value!r}")
            settings.setdefault(key, value)
        if not comment and line.strip(" \t,;|-:"):
            lines.append((number, line))
    return Lines(str(path), tuple(lines), settings, not content or content[-1] in "\r\n")


def parse(
    found: Lines,
    columns: Sequence[str],
    *,
    optional: Sequence[str] = (),
    text: Sequence[str] = (),
    also: dict[str, str] | None = None,
) -> Table:
    """Parse `Lines` into a `Table`.

    `columns` are required, in any order, `optional` ones are allowed, those in `text` contain words; `also` maps
    other headers, such as ``"C"``, to columns. `InputError` with file, line and column if there is no row, a column
    is missing, unknown or repeated, or an entry is missing or not a finite number.
    """
    table, wanted = Table(found.path), (*columns, *optional)
    table.settings = dict(found.settings)
    known = Names(wanted, also)
    first, mark = find_header(found.lines, known)
    if len(found.lines) < first + 2:
        raise InputError(table.path, "a line that names the columns, and rows of readings below", "no readings")
    number, line = found.lines[first]
    table.header = f"{table.path}, line {number}"
    header = cells_of(line, mark)
    names = check_names(table, header, columns, known)
    rows = [
        (number, row_of(re.sub(r"\s#.*", "", line), mark, len(names))) for number, line in found.lines[first + 1 :]
    ]
    rows = _obey_units_below(table, names, rows)
    again = [number for number, cells in rows if cells == header]
    rows = [(number, cells) for number, cells in rows if cells != header]
    if not rows:
        raise InputError(table.path, "rows of readings below the columns' names", "no readings")
    rows, after = _without_footer(
        rows, next(n for n, name in enumerate(names) if name in wanted and name not in text)
    )
    for number, cells in rows:
        while len(cells) > len(names) and not cells[-1]:
            cells.pop()
        if len(cells) != len(names):
            cut = ", which is the last one and has no line break: the file is cut off"
            said = cut if number == found.lines[-1][0] and not found.whole else ""
            raise InputError(f"{table.path}, line {number}", f"{len(names)} entries", f"{len(cells)}{said}")
    table.lines = tuple(number for number, _ in rows)
    check_aside(table, header, names, rows, known)
    content = zip(names, *(cells for _, cells in rows), strict=True)
    table |= {name: list(column) for name, *column in content if name in wanted}
    numbers = [name for name in table if name not in text]
    for name in numbers:
        _obey_unit_in_cells(table, name)
    commas = mark != "," and not any("." in entry for name in numbers for entry in table[name])
    for name in numbers:
        table[name] = np.array([_number(table, row, name, commas) for row in range(len(rows))])
    aside = [name or "a column without a name" for name in names if name not in wanted]
    table.notes = tuple(
        f"{table.path}: {note}"
        for holds, note in (
            (first, f"{first} lines before the column names were not read"),
            (again, f"the column names are repeated in line {', '.join(map(str, again))}"),
            (after, f"{after} lines after the readings were not read"),
            (aside, f"not read: {', '.join(aside)}"),
            (not found.whole, "no line break at the end: the last reading may be cut off"),
        )
        if holds
    )
    return table


def _without_footer(rows: list[Row], column: int) -> tuple[list[Row], int]:
    """Return the rows up to the last with a number in `column`, and how many follow it."""
    reading = [n for n, (_, cells) in enumerate(rows) if len(cells) > column and reads(cells[column])]
    last = max(reading, default=len(rows) - 1)
    return rows[: last + 1], len(rows) - last - 1


def _obey_units_below(table: Table, names: Sequence[str], rows: list[Row]) -> list[Row]:
    """Record the units of a line below the names, if there is one, and return the other rows."""
    stated = [cell.strip("()[]（） ") for cell in rows[0][1]]
    if len(stated) != len(names) or not any(stated) or not all(measure(cell)[0] or cell in "-" for cell in stated):
        return rows
    for name, cell in zip(names, stated, strict=True):
        if measure(cell)[0]:
            _state(table, f"line {rows[0][0]}", name, cell)
    return rows[1:]


def _obey_unit_in_cells(table: Table, name: str) -> None:
    """Record a unit that every cell of a column repeats, and drop it from the cells."""
    cells = [cell.translate(MINUS)[:LONGEST] for cell in table[name]]
    found = [re.fullmatch(rf"({NUMBER}(?:[eE][-+]?\d+)?)\s*(\D.*)", cell) for cell in cells]
    read = [each for each in found if each]
    units = {each[2] for each in read}
    if len(read) == len(cells) and len(units) == 1 and measure(unit := units.pop())[0]:
        _state(table, f"line {table.lines[0]}", name, unit)
        table[name] = [each[1] for each in read]


def _state(table: Table, where: str, name: str, unit: str) -> None:
    """Record the unit of a column; a different second one is refused."""
    before = table.settings.setdefault(f"unit {name}", unit)
    if measure(before) != measure(unit):
        raise InputError(f"{table.path}, {where}, column {name!r}", f"the unit {before}, as its name has it", unit)


def _text(path: Path | str) -> str:
    """The text of a file in UTF-8 or UTF-16 with its mark, in UTF-8, in GBK, or in Windows-1252."""
    content = read_bytes(path)
    if content.startswith(b"PK\x03\x04"):
        raise InputError(str(path), "text (a workbook? save its sheet as CSV)", "a packed file")
    marked = content.startswith((b"\xff\xfe", b"\xfe\xff"))
    # A Chinese letter is two bytes, the second high too in all but rare ones; µ and ° are single bytes.
    eastern = re.search(rb"[\x81-\xfe]{2}", content)
    encodings = ("utf-16",) if marked else ("utf-8-sig", "gb18030" if eastern else "cp1252")
    for encoding in encodings:
        try:
            return content.decode(encoding)
        except UnicodeDecodeError as error:
            line = content[: error.start].count(b"\n") + 1
    raise InputError(f"{path}, line {line}", "text in UTF-8 or GBK", "other bytes")


def _number(table: Table, row: int, name: str, commas: bool) -> float:
    entry = table[name][row]
    try:
        number = float((entry.replace(",", ".") if commas else entry).translate(MINUS))
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise InputError(table.where(row, name), "a number with a decimal point", repr(entry))
    return number
