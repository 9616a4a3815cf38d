"""Tables of NC words: each table is judged by its numbers, or set aside if it is of another point or branch."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import groupby
from typing import TYPE_CHECKING

from mathpost.teaching.workbook.meaning.typed_words import beyond_travel, judge_numbers, names_another_point
from mathpost.teaching.workbook.meaning.words import Words

if TYPE_CHECKING:
    from mathpost.teaching.workbook.report import Fault
    from mathpost.teaching.workbook.verdict.judge import Judge

TYPED = "the word is off by more than the rounding of the numbers in its row"


def of_nc_words(judge: Judge) -> Iterator[Fault]:
    """Yield the faults of NC words; the sheet's problems get what keeps a table from being judged."""
    graph, found = judge.graph, judge.found
    words = [row for row in found.calculations if isinstance(row, Words)]
    for _, rows in groupby(words, lambda row: row.table):
        table = [*rows]
        found.problems += beyond_travel(table, graph.own)
        if text := names_another_point(table, graph.own):
            found.problems.append(text)
            for row in table:
                row.complete = False
            continue
        for place, cause, text in judge_numbers(table, graph.own):
            yield judge.fault(place, cause, f"{graph.short(place)}: {text}", TYPED)
