"""Where the columns of a table of NC words are: its headings name them.

A table has rows of tip, tool axis and words, x y z i j k X Y Z and two rotary words by the machine's letters, or of
tool axis and rotary words alone. Points may be in columns instead of rows. Where a heading is missing, or there are
two of a kind that nothing tells apart, the columns are asked for.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from mathpost.teaching.workbook.meaning.headings import Column, Headed, column
from mathpost.teaching.workbook.meaning.vocabulary import wording
from mathpost.teaching.workbook.sheet.place import Line, Place, beside, number_along

if TYPE_CHECKING:
    from mathpost.kinematics import Kinematics
    from mathpost.teaching.workbook.sheet.graph import Graph

SMALLEST, LARGEST = 5, 60  # numbers in a row: the words alone; more columns than these are no such table
STATISTIC = re.compile(rf"{wording('statistic')}[ .:=]*", re.I)
Ends = tuple[Place, Place]  # of a row or a column


@dataclass(eq=False)
class Table:
    """The places of tip, tool axis and words of each row; `units` are the degrees in one unit of a rotary word."""

    rows: list[tuple[Line, Line, Line]]
    units: tuple[float, ...]
    counters: Line = ()
    left: tuple[Ends, ...] = ()  # rows in between that are not of the table
    others: tuple[Ends, ...] = ()  # columns of numbers that are none of these, and that nobody uses
    exchanged: tuple[Place, str] | tuple[()] = ()  # a cell under another one's heading, and a sentence

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


def find_tables(graph: Graph, kinematics: Kinematics) -> tuple[list[Table], list[str]]:
    """Return the tables of a workbook, and the ranges of numbers that may be one and are not named as one."""
    for along in (1, 2):  # points in rows, points in columns
        blocks, left = _blocks(graph, along)
        tables: list[Table] = []
        other: list[list[Column]] = []
        named = [_named(graph, kinematics, block) for block in blocks]
        apart = [block for block, headed in zip(blocks, named, strict=True) if not headed]
        for block, own in zip(blocks, named, strict=True):
            mates = [b for b in apart if b is not block and len(b[0].places) == len(block[0].places)]
            tried = (_named(graph, kinematics, mate + block) for mate in mates) if not own else ()  # on two sheets
            headed = own or next(filter(None, tried), None) or Headed(graph, block, True, kinematics)
            table = _table(graph, headed) if headed else None
            tables += [table] if table and all(table.rows != each.rows for each in tables) else []
            other += [] if table else [block]
        if tables:
            judged = graph.upstream(p for table in tables for *_, words in table.rows for p in words)
            other = [block for block in other if not all(judged.issuperset(each.places) for each in block)]
            left += [(b[0].places[0], b[-1].places[-1]) for b in other if _has_numbers(graph, b)]
            return tables, [graph.range(ends) for ends in (*left, *(ends for t in tables for ends in t.left))]
    return [], []


def _named(graph: Graph, kinematics: Kinematics, columns: list[Column]) -> Headed:
    return Headed(graph, columns, False, kinematics)


def _has_numbers(graph: Graph, block: Sequence[Column]) -> bool:
    return _are_typed(graph, [p for each in block for p in each.places])


def _are_typed(graph: Graph, places: Iterable[Place]) -> bool:
    """Whether there are numbers among some cells that no formula makes: formulas are judged beside a table."""
    return any(p in graph.component and p not in graph.trees for p in places)


def _blocks(graph: Graph, along: int) -> tuple[list[list[Column]], list[Ends]]:
    """Lists of columns: of rows of numbers without a gap; rows are counted by the place's number `along`.

    And the first and last cells of rows that are left out, as of a largest or a mean.
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
        while (sheet, first + len(run)) in lines:
            run.append(lines.pop((sheet, first + len(run))))
        counted = Counter(number_along(place, 3 - along) for places in run for place in places)
        own = {number_along(place, 3 - along) for place in run[0]}  # below which a blank is the word before
        numbers = sorted(number for number, count in counted.items() if 2 * count > len(run) or number in own)
        if SMALLEST <= len(numbers) <= LARGEST:
            found = [column(graph, sheet, range(first, first + len(run)), n, along) for n in numbers]
            whole = zip(numbers, found, strict=True)
            blocks.append([each for n, each in whole if 2 * counted[n] > len(run) or each.letters])
    return blocks, left


def _table(graph: Graph, headed: Headed) -> Table | None:
    """The `Table` in columns that are named, or None if most of its rows are not alike."""
    columns, words = headed.columns, headed.parts[2]
    tip, axis = (_sources(graph, columns, part) for part in headed.parts[:2])
    source, count = [columns[n] for n in (*tip, *axis)], len(columns[0].places)
    given = {p for each in source for p in each.places}
    if any(not columns[n].typed and graph.upstream(columns[n].places).isdisjoint(given) for n in words):
        return None
    alike = [[c.typed != (c.places[row] in graph.trees) for c in source] for row in range(count)]
    kept = [2 * sum(row) >= len(row) for row in alike]
    for row in range(count):  # one of statistics has no tip and no axis
        kept[row] &= any(c.places[row] in graph.component for c in source)
    if 2 * sum(kept) <= count:
        return None
    cells = [[columns[n].places for n in part] for part in (tip, axis, words)]
    rows: list[tuple[Line, Line, Line]] = []
    for row in (row for row in range(count) if kept[row]):
        at_tip, at_axis, at_words = (tuple(places[row] for places in part) for part in cells)
        rows.append((at_tip, at_axis, at_words))
    there = [[c.places[row] for c in columns if c.places[row] in graph.component] for row in range(count)]
    left = [(each[0], each[-1]) for row, each in enumerate(there) if not kept[row] and _are_typed(graph, each)]
    counts = [c for c in columns if _is_count(c.values)]
    own = {n for part in (*headed.parts, tip, axis) for n in part}
    others = [c for n, c in enumerate(columns) if n not in own and c.typed and c not in counts]
    ends = [(c.places[0], c.places[-1]) for c in others if graph.used.keys().isdisjoint(c.places)]
    counters = tuple(p for c in counts if not c.typed for p in c.places)
    units = tuple(columns[n].unit for n in words[-2:])
    return Table(rows, units, counters, tuple(left), tuple(ends), headed.exchanged)


def _is_count(values: np.ndarray) -> bool:
    """Whether these are the numbers of blocks or points."""
    steps = np.unique(np.diff(values))
    return len(steps) == 1 and steps[0] >= 1 and not (values % 1).any()


def _sources(graph: Graph, columns: list[Column], chosen: Sequence[int]) -> Sequence[int]:
    """The columns of typed numbers that a tip, or a direction, is but copied or normalised from; else its own."""
    if all(columns[n].typed for n in chosen):
        return chosen
    of = {p: n for n, each in enumerate(columns) for p in each.places}
    votes: Counter[tuple[int, ...]] = Counter()
    for cells in zip(*(columns[n].places for n in chosen), strict=True):
        votes[tuple(sorted({of[p] for p in graph.upstream(cells) - graph.trees.keys() if p in of}))] += 1
    found = votes.most_common(1)[0][0]
    if len(found) != 3 or not all(columns[n].typed for n in found):
        return chosen
    now, then = (np.stack([columns[n].values for n in part], axis=-1) for part in (chosen, found))
    length = np.linalg.norm(then, axis=1, keepdims=True)
    copied, normalised = (np.abs(now - each).max(axis=1) < 1e-6 for each in (then, then / length))
    return list(found) if (copied | normalised).mean() > 0.5 else chosen
