"""Tables of NC words: the branch that a whole table has, the point that it names, what is wrong in typed words."""

from __future__ import annotations

from itertools import groupby
from typing import TYPE_CHECKING, Any

import numpy as np

from mathpost.teaching.workbook.meaning.typed_words import judge_numbers
from mathpost.teaching.workbook.meaning.words import Words, names_another_point, on_the_wrong_branch

if TYPE_CHECKING:
    from mathpost.teaching.workbook.report import Fault
    from mathpost.teaching.workbook.sheet.place import Place
    from mathpost.teaching.workbook.verdict.judge import Judge

TYPED = "the word is off by more than the rounding of the numbers in its row"
BRANCH = "the word is beyond the axis's travel, and the other branch is not"
NO_NUMBER = "no row of a table may be without a number"


class Tables:
    """The tables of NC words that a `Judge` judges; each row is a calculation of its own."""

    def __init__(self, judge: Judge) -> None:
        self.judge, self.graph, self.found = judge, judge.graph, judge.found
        words = [row for row in judge.found.calculations if isinstance(row, Words)]
        self.tables = [list(table) for _, table in groupby(words, lambda row: row.table)]

    def prepare(self) -> None:
        """Prepare the rows once more, on the branch that their table is on; set aside one of another point."""
        for table in self.tables:
            self.judge.prepare(table)
            if text := names_another_point(table, self.judge.now):
                self.found.problems.append(text)
                self.judge.live = [row for row in self.judge.live if row not in table]
                for row in table:
                    row.complete = False
            votes = sum(row.votes for row in table)
            for row in table:
                row.preferred = int(np.argmax(votes))
            self.judge.prepare(table)

    def faults(self, faults: list[Fault]) -> list[Fault]:
        """Return the faults of typed words and branches, and of no numbers that follow from none of some faults."""
        judge, short = self.judge, self.graph.short
        own: dict[Place, Any] = self.graph.own
        for table in self.tables:
            wrong = judge_numbers(table, own) if table[0].typed and table[0].complete else ()
            for rule, found in ((TYPED, wrong), (BRANCH, on_the_wrong_branch(table, own))):
                faults = faults + [judge.fault(p, cause, f"{short(p)}: {text}", rule) for p, cause, text in found]
        rows = [row for table in self.tables for row in table]
        errors = {p for row in rows for p in row.results if p in self.graph.trees and np.isnan(own[p])}
        errors -= self.graph.downstream([*self.graph.not_evaluated, *(fault.place for fault in faults)])
        for place in (p for p in self.found.sorted(errors) if self.graph.upstream([p]) & errors == {p}):
            text = f"{short(place)} gives no number at this tool axis"
            faults = [*faults, judge.fault(place, "wrong value", text, NO_NUMBER)]
        return faults
