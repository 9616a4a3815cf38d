"""The line of a table that names its columns: which it is, what its cells mean, what comes before and below it."""

from __future__ import annotations

import csv
import re
from collections.abc import Sequence
from difflib import get_close_matches
from typing import TYPE_CHECKING

from mathpost.files import MINUS
from mathpost.shop.measure.vocabulary import LONGEST, Names, bracket, instead, is_aside, is_count, reverse

if TYPE_CHECKING:
    from mathpost.shop.measure.csv_table import Table

PREAMBLE, WIDEST = 200, 300  # lines before the column names, and columns, at most
WIDE = 60  # columns at most, if there are no rows below
BELOW = 3  # lines below the column names, the first row of numbers among them
MARKS = ",;\t|"  # between cells; otherwise blanks
BLANKS = ("  ", " ")  # between names of several words, and of one
LIKELY = 3  # columns that a message proposes
QUANTITY = re.compile(r"[-+]?\d*[.,]?\d+[.,]?(?:[eE][-+]?\d+)?\s*\D{0,8}")  # a number, and perhaps its unit

Row = tuple[int, list[str]]  # the number of a line, and its cells


def cells_of(line: str, mark: str) -> list[str]:
    """The cells of a line between marks; a blank, or two and more, count as a mark unless a bracket follows."""
    if mark.isspace() and mark != "\t":
        return re.split(rf"\s{{{len(mark)},}}(?![(\[（])", line.strip())
    if mark == "|":
        line = line.strip().removeprefix("|").removesuffix("|")
    entries = csv.reader([line], delimiter=mark, skipinitialspace=True)
    return [cell.strip() for cell in next(entries, [])]


def row_of(line: str, mark: str, count: int) -> list[str]:
    """The cells of a row below `count` names; numbers may be closer together than these."""
    cells = cells_of(line, mark)
    return cells_of(line, " ") if mark == BLANKS[0] and len(cells) != count else cells


def find_header(lines: Sequence[tuple[int, str]], known: Names) -> tuple[int, str]:
    """Return the index of the line that names the columns, and its mark.

    It is the first that names a wanted column and has rows of its own shape below it; otherwise the first that
    names two, or that has such rows.
    """
    named: list[tuple[int, str]] = []
    shaped: list[tuple[int, str]] = []
    for index, (_, line) in enumerate(lines[:PREAMBLE]):
        marks = sorted((each for each in MARKS if each in line), key=line.count, reverse=True)
        for mark in marks or BLANKS:
            names = cells_of(line, mark)[:WIDEST]
            below = len(names) > 1 and _has_rows(lines[index + 1 : index + 1 + BELOW], names, mark)
            if not below and (mark in BLANKS or named or len(names) > WIDE):
                continue
            found = {known.find(cell)[0] for cell in names} - {None}
            if found and below:
                return index, mark
            if len(found) >= min(2, len(known.wanted)):
                named.append((index, mark))
            elif below and not all(map(reads, names)):
                shaped.append((index, mark))
    line = lines[0][1] if lines else ""
    return [*named, *shaped, (0, max(MARKS, key=lambda mark: (line.count(mark), mark == ",")))][0]


def _has_rows(lines: Sequence[tuple[int, str]], names: Sequence[str], mark: str) -> bool:
    """Whether one of `lines` has a cell for each of `names`, with numbers; between blanks nothing but numbers."""
    count = len(names) - sum(not name for name in names[-1:])
    for _, line in lines:
        cells = row_of(line, mark, count)
        while len(cells) > count and not cells[-1]:
            cells.pop()
        numbers = sum(bool(reads(cell)) for cell in cells)
        if len(cells) == count and numbers >= (count if mark in BLANKS else min(2, count)):
            return True
    return False


def reads(cell: str) -> re.Match[str] | None:
    """Return a match if a cell looks like a number, with either decimal mark."""
    return re.fullmatch(r"[-+]?[\d.,]+(e[-+]?\d+)?", cell.translate(MINUS), re.IGNORECASE)


def check_names(table: Table, cells: list[str], columns: Sequence[str], known: Names) -> list[str]:
    """Return the names of the columns; a unit after a name goes to the settings."""
    while cells and not cells[-1]:  # commas at the ends of lines
        cells.pop()
    names, wanted = [], known.wanted
    for cell in cells:
        if reverse(cell[:LONGEST]):
            table.refuse("readings that are actual minus target, or ball minus tool", f"{cell!r}, the reverse")
        plain = bracket(cell[:LONGEST])[0]
        name, unit = (plain, None) if plain not in wanted and is_aside(plain) else known.find(cell)
        name = name or plain
        if unit:
            table.settings[f"unit {name}"] = unit
        names.append(name)
    for name in columns:
        if name not in names:
            table.refuse(f"the columns {', '.join(columns)}", f"{', '.join(names)}: no {name!r}")
    for name in wanted:
        if names.count(name) > 1:
            said = " and ".join(repr(cell) for cell, each in zip(cells, names, strict=True) if each == name)
            asked = f"; is one of them e{name}?" if f"e{name}" in wanted else ""
            table.refuse("every column once", f"{name!r} {names.count(name)} times: {said}{asked}")
    if not any(name in wanted for name in names):
        table.refuse(f"a line that names the columns{_likely(known, names)}", ", ".join(names)[:LONGEST])
    return names


def check_aside(
    table: Table, cells: Sequence[str], names: Sequence[str], rows: Sequence[Row], known: Names
) -> None:
    """Refuse numbers under one of `cells` whose name is not known; texts are passed over."""
    for column, (cell, name) in enumerate(zip(cells, names, strict=True)):
        if not name or name in known.wanted or is_aside(name) or is_count(name):
            continue
        if any(QUANTITY.fullmatch(each[column].translate(MINUS)[:LONGEST]) for _, each in rows):
            expected = instead(name) or f"numbers under a name that says what they are{_likely(known, names, name)}"
            table.refuse(f"{expected} (remark, if they are no readings)", repr(cell[:LONGEST]))


def _likely(known: Names, names: Sequence[str], name: str = "") -> str:
    """Words for a few columns that a name may be: those that are written alike, then those missing."""
    like = [known.words[word] for word in get_close_matches(name.casefold(), known.words, LIKELY)]
    like = known.unclear.get(name.casefold()) or [*like, *known.wanted]
    missing = [each for each in dict.fromkeys(like) if each not in names]
    return f", such as {', '.join(missing[:LIKELY])}" if missing else ""
