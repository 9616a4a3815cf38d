"""Where the columns of a table of NC words are: its headings name them.

A table has rows of tip, tool axis and words: x y z i j k X Y Z and two rotary words by the machine's letters, in
any order, with other columns between them. Tip and tool axis are typed. Where a heading is missing, or several
columns have it and the numbers do not tell them apart, the columns are asked for.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import islice, product
from typing import TYPE_CHECKING

import numpy as np

from mathpost.teaching.workbook.meaning.label import IN_RADIANS
from mathpost.teaching.workbook.meaning.vocabulary import wording
from mathpost.teaching.workbook.sheet.place import Line, Place

if TYPE_CHECKING:
    from mathpost.kinematics import Kinematics
    from mathpost.teaching.workbook.sheet.graph import Graph

CLOSE = 0.1  # degrees, mm: close enough to tell a heading; whether a word is right is judged elsewhere
SMALLEST, SUSPECT = 9, 5  # numbers in a row of a table; and in one that may be of a table
HEADINGS = 3  # texts over a column that may be its heading
MOST_ORDERS = 200  # of columns under the same headings
PARTS = {"given": wording("workpiece"), "words": wording("machine")}
STATISTIC = re.compile(rf"{wording('statistic')}[ .:=]*", re.I)  # of a largest or a mean of all rows
UNIT = re.compile(r"[\[(（/].*|\b(?:deg|rad|mm|grad)\b\.?$|[°度]")
PREFIX = r"(?:(?:tip|axis|tool|ax|[PTptnev])_?(?=[XYZIJKxyzijk]))?"
LETTER = re.compile(rf"(?<![A-Za-z]){PREFIX}([A-Za-z])(?![A-Za-z0-9])")


@dataclass(frozen=True)
class Column:
    """The cells of a column, one of each row, and their numbers; `letters` are those in its heading."""

    places: Line
    values: np.ndarray
    letters: list[str]
    said: str  # "given" or "words", if its heading or that of its group says so
    typed: bool  # whether they are numbers
    unit: float  # degrees of 1, if it is an angle


@dataclass(eq=False)
class Table:
    """The places of tip, tool axis and words of each row; `units` are the degrees in one unit of a rotary word."""

    rows: list[tuple[Line, Line, Line]]
    units: tuple[float, ...] = (1.0, 1.0)
    others: tuple[Line, ...] = ()  # columns of numbers that are none of these, and that nobody uses

    def said(self, graph: Graph) -> str:
        """Where the columns are."""
        named = zip(("tip", "axis", "words"), self.rows[0], self.rows[-1], strict=True)
        text = ", ".join(f"{name} {graph.range((first[0], last[-1]))}" for name, first, last in named)
        return text + f"; numbers not looked at: {', '.join(map(graph.range, self.others))}" * bool(self.others)


def find_tables(graph: Graph, kinematics: Kinematics) -> tuple[list[Table], list[str]]:
    """Return the tables of a workbook, and the ranges of numbers that may be one and are not named as one."""
    rows: dict[tuple[str, int], list[Place]] = {}
    for place in graph.component:
        rows.setdefault(place[:2], []).append(place)
    of_all = {place[:2] for place, cell in graph.cells.items() if STATISTIC.fullmatch(str(cell.value).strip())}
    single = {row: places for row, places in rows.items() if row not in of_all}
    tables = [table for columns in _blocks(graph, single) if (table := _table(graph, columns, kinematics))]
    taken = {words[0][:2] for table in tables for *_, words in table.rows}
    typed = {row: sorted(p for p in places if p not in graph.trees) for row, places in rows.items()}
    left = [places for row, places in typed.items() if row not in taken and len(places) >= SUSPECT]
    return tables, [graph.range(places) for places in left]


def _blocks(graph: Graph, rows: dict[tuple[str, int], list[Place]]) -> Iterator[list[Column]]:
    """Yield the columns of each run of rows with numbers."""
    full = {row for row, places in rows.items() if len(places) >= SMALLEST}
    for sheet, first in sorted(full):
        if (sheet, first - 1) not in full:
            last = first
            while (sheet, last + 1) in full:
                last += 1
            numbers = sorted(p[2] for p in rows[sheet, first])
            yield [_column(graph, sheet, range(first, last + 1), number) for number in numbers]


def _column(graph: Graph, sheet: str, lines: range, number: int) -> Column:
    def text(line: int, column: int) -> str:
        cell = graph.cells.get((sheet, line, column))
        return cell.value if cell and isinstance(cell.value, str) else ""

    above = range(lines[0] - 1, 0, -1)
    texts = [*islice(filter(None, (text(line, number) for line in above)), HEADINGS)]
    groups = (next(filter(None, (text(line, n) for n in range(number, 0, -1))), "") for line in above[:HEADINGS])
    said = next((part for group in groups for part in PARTS if _says(group, part)), "")
    places = tuple((sheet, line, number) for line in lines)
    values = np.array([graph.own.get(p) for p in places], dtype=float)
    typed = 2 * sum(p in graph.trees for p in places) < len(places)
    unit = np.rad2deg(1) if any(re.search(IN_RADIANS, each, re.I) for each in texts) else 1.0
    letters = next(filter(None, map(_letters, texts)), [])
    return Column(places, values, letters, said, typed, float(unit))


def _says(text: str, part: str) -> bool:
    """Whether a text has a word for one of the `PARTS`, and none for the other."""
    return [name for name, words in PARTS.items() if re.search(words, text, re.I)] == [part]


def _letters(heading: str) -> list[str]:
    """The letters that a heading names, as in "a", "X [mm]", "刀轴i", "px" or "ti"; one alone stands for all."""
    return LETTER.findall(UNIT.sub("", unicodedata.normalize("NFKC", heading)).strip())


def _table(graph: Graph, columns: list[Column], kinematics: Kinematics) -> Table | None:
    """The table in some columns; None if their headings, or else their numbers, do not name one."""
    names = [name[0] for name in kinematics.machine.joint_names]
    parts = [("xyz", True), ("ijk", True), ("".join(names), False)]
    pools = [_pool(columns, letter, given) for letters, given in parts for letter in letters]
    orders = [order for order in islice(product(*pools), MOST_ORDERS) if len({*order}) == len(order)]
    right = [order for order in orders if _share_right(columns, order, kinematics) >= 0.5]
    if not (right or len(orders) == 1):
        return None
    chosen = [columns[n] for n in (right or orders)[0]]
    rows = [row for row in zip(*(c.places for c in chosen), strict=True) if is_whole(graph, row)]
    rows = [row for row in rows if graph.trees.keys().isdisjoint(row[:6])]
    units = tuple(c.unit for c in chosen[-2:])
    others = (c.places for c in columns if c.typed and c not in chosen and graph.used.keys().isdisjoint(c.places))
    return Table([(row[:3], row[3:6], row[6:]) for row in rows], units, tuple(others)) if rows else None


def _pool(columns: list[Column], letter: str, given: bool) -> list[int]:
    """The columns that a heading may name; a small x is that of the tip if there is a capital one as well."""
    but = "words" if given else "given"
    named = [n for n, c in enumerate(columns) if c.said != but and letter.lower() in map(str.lower, c.letters)]
    named = [n for n in named if len(columns[n].letters) == 1] or named
    cased = [n for n in named if letter in columns[n].letters]
    named = cased if cased and len(cased) < len(named) else named
    return [n for n in named if columns[n].typed] if given else named


def is_whole(graph: Graph, row: Iterable[Place]) -> bool:
    """Whether there is a number in each cell of a row."""
    return bool(np.isfinite(np.array([graph.own.get(place) for place in row], dtype=float)).all())


def _share_right(columns: list[Column], order: tuple[int, ...], kinematics: Kinematics) -> float:
    """The share of rows whose words put the tool where they say, with the columns in this order."""
    numbers = np.array([columns[n].values for n in order]).T
    numbers = numbers[np.isfinite(numbers).all(axis=1)]
    joints = numbers[:, 6:] * [1, 1, 1, *(columns[n].unit for n in order[-2:])]
    tip, axis = kinematics.forward(joints, degrees=True)
    length = np.linalg.norm(numbers[:, 3:6], axis=1, keepdims=True)
    fits = np.abs(axis - numbers[:, 3:6] / length).max(axis=1) < np.deg2rad(CLOSE)
    fits &= np.abs(tip - numbers[:, :3]).max(axis=1) < CLOSE
    return float(fits.mean()) if len(fits) else 0.0
