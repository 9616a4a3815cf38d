"""Where the columns of a table of NC words are: by their numbers, and by headings where these leave it open.

The tool axis is three columns from which the machine's inverse makes two others, the rotary words; the tip, if
there is one, is three columns that together with these make X Y Z. So neither the order nor the sheet matters, nor
do columns of something else.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import accumulate, pairwise, permutations, product
from typing import TYPE_CHECKING, Any

import numpy as np

from mathpost.workbook.meaning.label import IN_DEGREES, IN_RADIANS
from mathpost.workbook.meaning.nc_headed import Headed
from mathpost.workbook.meaning.nc_headings import UNIT, headings_exchanged, letters_of, normal, side, stand_apart
from mathpost.workbook.meaning.nc_roles import (
    ENOUGH,
    ENOUGH_BESIDE,
    ENOUGH_OF_ONE_ROW,
    ENOUGH_OF_ROTARY,
    Roles,
)
from mathpost.workbook.sheet.place import Line, Place, beside, number_along

if TYPE_CHECKING:
    from mathpost.kinematics import Kinematics
    from mathpost.workbook.sheet.graph import Graph

LOOKED_AT = 200  # rows are enough to tell a column
SMALLEST, LARGEST = 5, 60  # numbers in a row: the words alone; more columns than these are no such table
STATISTIC = re.compile("(?:min|max|mean|average|sum|total|mittel|summe|最小值?|最大值?|平均值?|合计)[ .:=]*", re.I)


Ends = tuple[Place, Place]  # of a row or a column


@dataclass(frozen=True)
class Column:
    """The cells of a column, one of each row, and their numbers; `letters` is how well its heading says each."""

    places: Line
    values: np.ndarray
    letters: dict[str, float]
    typed: bool
    unit: float  # degrees of 1, if it is an angle
    said: str  # "nc" or "cl" if its heading, or that of its group, says one of the two
    more: float  # what it counts that the heading says degrees; less if it says radians


@dataclass(eq=False)
class Table:
    """The places of tip, tool axis and words of each row; `units` are the degrees in one unit of a rotary word."""

    rows: list[tuple[Line, Line, Line]]
    units: tuple[float, ...]
    counters: Line = ()
    left: tuple[Ends, ...] = ()  # rows in between that are not of the table
    others: tuple[Ends, ...] = ()  # columns of numbers that are none of these, and that nobody uses
    exchanged: tuple[Place, str] | tuple[()] = ()  # a cell under another one's heading, and a sentence
    source: tuple[Column, ...] = ()  # the columns of tip and axis
    words: tuple[Column, ...] = ()

    def said(self, graph: Graph) -> str:
        """Where the columns are."""
        texts = []
        parts = zip(("tip", "axis", "words"), self.rows[0], self.rows[-1], strict=True)
        for name, first, last in (part for part in parts if part[1]):
            side_by_side = all(b in beside(a) for a, b in pairwise(first))
            ends = [(first[0], last[-1])] if side_by_side else zip(first, last, strict=True)
            ranges = graph.ranges(first) if first == last else map(graph.range, ends)
            texts.append(f"{name} {' '.join(ranges)}")
        not_seen = f"; numbers not looked at: {', '.join(map(graph.range, self.others))}"
        return ", ".join(texts) + not_seen * bool(self.others)


def find_tables(
    graph: Graph, kinematics: Kinematics, tried: Iterable[tuple[int, int]] = (ENOUGH, ENOUGH_OF_ROTARY)
) -> tuple[list[Table], list[str]]:
    """Return the tables of a workbook, and the ranges that may be a table and are not understood.

    Rows of one table may be on two sheets, its words on several; points may be in columns instead of rows, or there
    may be only one point, if that is `tried`. Both solutions may be side by side: these are two tables. There may
    be rotary words alone, from the tool axis alone.
    """
    for enough, along in product(tried, (1, 2)):  # points in rows, points in columns
        single = enough == ENOUGH_OF_ONE_ROW
        blocks, left = _blocks(graph, along, single)
        several = [n for n, block in enumerate(blocks) if single or len(block[0].places) > 1]
        tried_at = {n: _table(graph, kinematics, blocks[n], enough) for n in several}
        found: dict[Any, Table] = {n: table for n, table in tried_at.items() if table}
        for a, b in () if single else permutations(several, 2):
            if b not in found and len(blocks[a][0].places) == len(blocks[b][0].places):
                table = _table(graph, kinematics, blocks[a] + blocks[b], enough)
                found |= {a: found.get(a, table), b: table} if table else {}
        for n, table in list(found.items()):  # the other solution, in what is left or beside it
            for b, block in enumerate(blocks):
                used = {column.places for column in (*table.source, *table.words)}
                rest = [column for column in block if column.places not in used]
                alike = len(rest) >= 5 and len(rest[0].places) == len(table.words[0].places)
                if alike and (b == n or b not in found):
                    twin = _table(graph, kinematics, [*table.source, *rest], ENOUGH_BESIDE)
                    twin = twin if twin and twin.source == table.source else None
                    found |= {b if b not in found else (b, "twin"): twin} if twin else {}
        if found:
            cells = {table: {p for *_, words in table.rows for p in words} for table in found.values()}
            before = {table: graph.upstream(words) - words for table, words in cells.items()}
            tables = [t for t in cells if not any(up.issuperset(cells[t]) for up in before.values())]  # no steps
            judged = graph.upstream(p for table in tables for p in cells[table])
            other = [block for n, block in enumerate(blocks) if n not in found]
            other = [block for block in other if not all(judged.issuperset(column.places) for column in block)]
            other = [block for block in other if _are_typed(graph, [p for column in block for p in column.places])]
            left += [(block[0].places[0], block[-1].places[-1]) for block in other]
            return tables, [graph.range(ends) for ends in (*left, *(ends for t in tables for ends in t.left))]
    return [], []


def _blocks(graph: Graph, along: int, single: bool) -> tuple[list[list[Column]], list[Ends]]:
    """Lists of columns: of rows of numbers without a gap; rows are counted by the place's number `along`.

    With `single` each row is alone. And the first and last cells of rows that are left out, as of a largest or a
    mean.
    """
    lines: dict[tuple[str, int], list[Place]] = {}
    blocks: list[list[Column]] = []
    left: list[Ends] = []
    for place in graph.component:
        lines.setdefault((place[0], number_along(place, along)), []).append(place)
    lines = {line: places for line, places in lines.items() if len(places) >= SMALLEST}
    for place, cell in graph.cells.items():
        if STATISTIC.fullmatch(str(cell.value).strip()) and (place[0], number_along(place, along)) in lines:
            places = lines.pop((place[0], number_along(place, along)))
            left += [(min(places), max(places))] * _are_typed(graph, places)
    while lines:
        sheet, first = min(lines, key=lambda line: (graph.numbers[line[0]], line[1]))
        run: list[list[Place]] = []
        while (sheet, first + len(run)) in lines and not (single and run):
            run.append(lines.pop((sheet, first + len(run))))
        counted = Counter(number_along(place, 3 - along) for places in run for place in places)
        own = {number_along(place, 3 - along) for place in run[0]}  # below which a blank is the word before
        numbers = sorted(number for number, count in counted.items() if 2 * count > len(run) or number in own)
        if SMALLEST <= len(numbers) <= LARGEST:
            found = [_column(graph, sheet, range(first, first + len(run)), n, along) for n in numbers]
            blocks.append(
                [c for n, c in zip(numbers, found, strict=True) if 2 * counted[n] > len(run) or c.letters]
            )
    return blocks, left


def _column(graph: Graph, sheet: str, lines: range, number: int, along: int) -> Column:
    """The column, or row, of a number, with what the three nearest texts before it say."""

    def place(line: int) -> Place:
        return (sheet, line, number) if along == 1 else (sheet, number, line)

    texts: list[str] = []
    raw: set[str] = set()
    for line in range(lines[0] - 1, 0, -1):
        cell = graph.cells.get(place(line))
        if cell and isinstance(cell.value, str) and len(texts) < 3:
            texts.append(normal(cell.value))
            raw = raw or {UNIT.sub("", cell.value).strip()} - {""}
    letters = next(filter(None, map(letters_of, texts)), {})
    places = tuple(map(place, lines))
    numbers = accumulate((graph.own.get(p) if p in graph.component else None for p in places), _or_before)
    values = np.array([*numbers], dtype=float)
    typed = 2 * sum(p in graph.trees for p in places) < len(places)
    unit = np.rad2deg(1) if any(re.search(IN_RADIANS, text) for text in texts) else 1.0
    says_degrees = unit == 1 and any(re.search(IN_DEGREES, text) for text in texts)
    said = side(graph, sheet, along, lines[0], number)
    said = said or next(({"XYZ": "nc", "xyz": "cl"}[case] for case in ("XYZ", "xyz") if set(case) & raw), "")
    return Column(places, values, letters, typed, unit, said, 0.5 * says_degrees - 0.75 * (unit > 1))


def _or_before(before: float, number: float | None) -> float:
    """A number or, where there is none, the one before, as of words that say only what changes."""
    return before if number is None else number


def _table(graph: Graph, kinematics: Kinematics, columns: list[Column], enough: tuple[int, int]) -> Table | None:
    """The `Table` in some columns, or None."""
    count = len(columns[0].places)
    sample = np.unique(np.linspace(0, count - 1, min(count, LOOKED_AT)).astype(int))
    headed = Headed(graph, columns, kinematics, alone=enough == ENOUGH_OF_ROTARY)
    roles = headed.settle() or Roles(graph, columns, kinematics, sample).find(enough) or headed.first
    if roles is None:
        return None
    columns = headed.columns  # under their own headings
    tip, axis = (_sources(graph, columns, roles[part]) for part in ("tip", "axis"))
    words = roles["words"]
    source = [columns[n] for n in (*tip, *axis)]
    given = {p for column in source for p in column.places}
    if any(not columns[n].typed and graph.upstream(columns[n].places).isdisjoint(given) for n in words):
        return None
    alike = [[c.typed != (c.places[row] in graph.trees) for c in source] for row in range(count)]
    kept = [2 * sum(row) >= len(row) for row in alike]
    for row in range(count):  # one of statistics has no tip and no axis
        kept[row] &= any(c.places[row] in graph.component for c in source)
    if 2 * sum(kept) <= count:
        return None
    cells = [[columns[n].places for n in part] for part in (tip, axis, words)]
    rows = []
    for row in (row for row in range(count) if kept[row]):
        at_tip, at_axis, at_words = (tuple(places[row] for places in part) for part in cells)
        rows.append((at_tip, at_axis, at_words))
    unlike = [
        [c.places[row] for c in columns if c.places[row] in graph.component]
        for row in range(count)
        if not kept[row]
    ]
    left = [(places[0], places[-1]) for places in unlike if _are_typed(graph, places)]
    others = [c for n, c in enumerate(columns) if n not in (*roles["tip"], *roles["axis"], *tip, *axis, *words)]
    unused = [c.places for c in others if c.typed and not _is_count(c.values)]
    ends = [(places[0], places[-1]) for places in unused if graph.used.keys().isdisjoint(places)]
    units = tuple(columns[n].unit for n in words[-2:])
    counters = tuple(p for c in columns if not c.typed and _is_count(c.values) for p in c.places)
    of_tip, of_axis, of_words = ([columns[n] for n in part] for part in (tip, axis, words))
    exchanged = headed.exchanged or headings_exchanged(
        graph, kinematics, of_tip, of_axis, of_words, stand_apart(tip, axis, words)
    )
    return Table(rows, units, counters, tuple(left), tuple(ends), exchanged, tuple(source), tuple(of_words))


def _are_typed(graph: Graph, places: Iterable[Place]) -> bool:
    """Whether there are numbers among some cells that no formula makes: formulas are judged beside a table."""
    return any(p in graph.component and p not in graph.trees for p in places)


def _is_count(values: np.ndarray) -> bool:
    """Whether these are the numbers of blocks or points."""
    steps = np.unique(np.diff(values))
    return len(steps) == 1 and steps[0] >= 1 and not (values % 1).any()


def _sources(graph: Graph, columns: list[Column], chosen: Sequence[int]) -> Sequence[int]:
    """The columns of typed numbers that a tip, or a direction, is but copied or normalised from; else its own."""
    if all(columns[n].typed for n in chosen):
        return chosen
    votes: Counter[tuple[int, ...]] = Counter()
    of = {p: n for n, column in enumerate(columns) for p in column.places}
    for cells in zip(*(columns[n].places for n in chosen), strict=True):
        used = [p for p in graph.upstream(cells) - graph.trees.keys() if p in of]
        votes[tuple(sorted({of[p] for p in used}))] += 1
    found = votes.most_common(1)[0][0]
    if len(found) != 3 or not all(columns[n].typed for n in found):
        return chosen
    now, then = (np.stack([columns[n].values for n in part], axis=-1) for part in (chosen, found))
    length = np.linalg.norm(then, axis=1, keepdims=True)
    copied, normalised = (np.abs(now - each).max(axis=1) < 1e-6 for each in (then, then / length))
    return list(found) if (copied | normalised).mean() > 0.5 else chosen
