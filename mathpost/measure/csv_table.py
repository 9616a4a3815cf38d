"""Tables of readings: CSV files with named columns, whose errors name the file and the line.

A file begins with a comment that names its source, then the column names, then one reading to a line::

    # source: Huang et al. (source 001), section 4
    angle,x,y
    0,0.016,0.004

Angles in a file are degrees, lengths mm unless its reader says otherwise.
"""

import csv
import math
from dataclasses import dataclass

import numpy as np

from mathpost.errors import InputError, read_text


@dataclass(frozen=True)
class Table:
    """Columns of a CSV file by name, and the line that each row came from.

    Attributes
    ----------
    path : str
    source : str
        The comment before the column names, without "source:"; empty if the file has none.
    columns : dict
        Name to a float array, shape (rows,), or to a list of strings for a text column.
    lines : tuple of ints
    """

    path: str
    source: str
    columns: dict
    lines: tuple

    def __getitem__(self, name):
        return self.columns[name]

    def __contains__(self, name):
        return name in self.columns

    def __len__(self):
        return len(self.lines)

    def where(self, row, name):
        """Say where the entry of `row` (from 0) in column `name` stands."""
        return f"{self.path}, line {self.lines[row]}, column {name!r}"

    def require(self, name, good, expected):
        """Raise `InputError` at the first row for which the boolean array `good` is false."""
        for row in np.flatnonzero(~np.asarray(good))[:1]:
            entry = self[name][row]
            raise InputError(self.where(row, name), expected, entry if isinstance(entry, str) else f"{entry:.10g}")

    def check_angles(self, name, limit=360.0):
        """Refuse angles that cannot be degrees: beyond ±`limit`, or the round numbers of radians."""
        angles = self[name]
        self.require(name, np.abs(angles) <= limit, f"degrees within ±{limit:g} (other units, or a lost point?)")
        steps = angles / (math.pi / 6)
        radians = (np.abs(steps - np.round(steps)) < 1e-3) & (np.round(steps) != 0)
        if np.abs(angles).max() < 2 * math.pi + 1e-3:
            self.require(name, ~radians, "degrees (these look like radians)")

    def check_increasing(self, name, within=()):
        """Refuse numbers that do not increase from row to row, as long as the columns `within` stay the same."""
        values, groups = self[name], list(zip(*(self[column] for column in within), strict=True))
        for row in range(1, len(self)):
            if groups and groups[row] != groups[row - 1]:
                continue
            if values[row] <= values[row - 1]:
                what = "a duplicate" if values[row] == values[row - 1] else "out of order"
                expected = f"more than {values[row - 1]:.10g}, which stands on line {self.lines[row - 1]}"
                raise InputError(self.where(row, name), expected, f"{values[row]:.10g}, {what}")


def read(path, columns, *, optional=(), text=()):
    """Read a CSV file.

    Parameters
    ----------
    path : str or path-like
    columns : sequence of str
        Names of the columns that must be there, in any order.
    optional : sequence of str, keyword only
        Names of those that may be there.
    text : sequence of str, keyword only
        Which of all these hold words instead of numbers.

    Returns
    -------
    Table

    Raises
    ------
    InputError
        If the file cannot be read, has no row, lacks a column, has an unknown or a repeated one, or an entry
        is missing or not a finite number. The message names file, line and column.

    Examples
    --------
    >>> table = read("data/measurements/five_face_head.csv", ["angle", "x", "y", "z"])
    >>> len(table), table["y"][1].item(), table.where(1, "y")
    (4, -378.873, "data/measurements/five_face_head.csv, line 4, column 'y'")
    """
    comments, names, rows, lines = [], None, [], []
    for number, line in enumerate(read_text(path).splitlines(), 1):
        if line.lstrip().startswith("#"):
            comments.append(line.lstrip("# \t").rstrip())
            continue
        cells = [cell.strip() for entry in csv.reader([line], skipinitialspace=True) for cell in entry]
        if not any(cells):
            continue
        if names is None:
            names = _check_names(cells, columns, optional, f"{path}, line {number}")
        elif len(cells) != len(names):
            raise InputError(f"{path}, line {number}", f"{len(names)} entries", f"{len(cells)}")
        else:
            rows.append(cells)
            lines.append(number)
    if not rows:
        raise InputError(str(path), f"the columns {', '.join(columns)} and rows of readings", "no readings")
    table = Table(str(path), " ".join(comments).removeprefix("source:").strip(), {}, tuple(lines))
    for name, entries in zip(names, zip(*rows, strict=True), strict=True):
        table.columns[name] = list(entries)
        if name not in text:
            table.columns[name] = np.array([_number(table, row, name) for row in range(len(entries))])
    return table


def _check_names(names, columns, optional, where):
    missing = [name for name in columns if name not in names]
    if missing:
        raise InputError(where, f"the columns {', '.join(columns)}", f"{', '.join(names)}: no {missing[0]!r}")
    for name in names:
        if names.count(name) > 1:
            raise InputError(where, "every column once", f"{name!r} {names.count(name)} times")
        if name not in (*columns, *optional):
            raise InputError(where, f"no columns but {', '.join((*columns, *optional))}", repr(name))
    return names


def _number(table, row, name):
    entry = table[name][row]
    try:
        number = float(entry)
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise InputError(table.where(row, name), "a number with a decimal point", repr(entry))
    return number
