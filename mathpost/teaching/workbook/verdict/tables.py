"""Tables of NC words: the branch and the point that a whole table has, and what is wrong in typed words."""

from __future__ import annotations

from collections import Counter
from itertools import groupby
from typing import TYPE_CHECKING, Any

import numpy as np

from mathpost.teaching.workbook.meaning.typed_words import judge_numbers
from mathpost.teaching.workbook.meaning.words import Words, on_the_wrong_branch, point_named
from mathpost.teaching.workbook.verdict.machine_causes import by_cause, explained, is_of_the_machine

if TYPE_CHECKING:
    from mathpost.teaching.workbook.report import Fault
    from mathpost.teaching.workbook.sheet.place import Place
    from mathpost.teaching.workbook.verdict.judge import Judge

EXCHANGED = "most rows are right only with some headings exchanged"
TYPED = "the word is off by more than the rounding of the numbers in its row"
BRANCH = "the word is beyond the axis's travel, and the other branch is not"
NO_NUMBER = "no row of a table may be without a number"


class Tables:
    """The tables of NC words that a `Judge` judges; each row is a calculation of its own."""

    def __init__(self, judge: Judge) -> None:
        self.judge, self.graph, self.found = judge, judge.graph, judge.found
        self.rows = [row for row in judge.live if isinstance(row, Words)]
        self.words = [row for row in judge.found.calculations if isinstance(row, Words)]
        self.tables = [list(table) for _, table in groupby(self.words, lambda row: row.table)]

    def prepare(self) -> None:
        """Prepare the rows once more, on the branch that their table is on, with the point that it names."""
        for row in self.rows:
            row.preferred = int(np.argmax(sum(r.votes for r in self.rows if r.table == row.table)))
        for table in (t for t in self.tables if t[0].point):
            for text in point_named(table, self.judge.now):
                self._judge_the_point(table, text)
        self.judge.prepare(self.rows)

    def _judge_the_point(self, table: list[Words], text: str) -> None:
        """Doubt another point that X Y Z name if the machine has it; else what is known to give it is a fault."""
        other = explained(table, self.graph.own, -5)
        if is_of_the_machine(table[0]):
            self.found.problems.append(f"{text}, or {other.sentence}" if other else text)
        elif other:
            for row in table:
                row.further = 0.0
        else:
            self.found.problems.append(text)

    def judged(self, faults: list[Fault]) -> list[Fault]:
        """Return some faults with those of headings, branches and typed words; what a whole table has is named."""
        judge, short = self.judge, self.graph.short
        own: dict[Place, Any] = self.graph.own
        for place, text in (t[0].exchanged for t in self.tables if t[0].exchanged):
            faults = [*faults, judge.fault(place, "exchanged", f"{short(place)}: {text}", EXCHANGED)]
        axes = Counter(row.axis for row in self.words)
        for table in self.tables:  # beside its twin a table is on the branch that it shows
            alone = [row for row in table if axes[row.axis] == 1]
            wrong = judge_numbers(table, own) if table[0].typed else ()
            branch = on_the_wrong_branch(alone, own)
            for rule, found in ((TYPED, wrong), (BRANCH, branch)):
                faults += [judge.fault(p, cause, f"{short(p)}: {text}", rule) for p, cause, text in found]
        for table in self.tables:
            faults = by_cause(faults, table, own)
        errors = {p for row in self.rows for p in row.results if p in self.graph.trees and np.isnan(own[p])}
        errors -= self.graph.downstream([*self.graph.not_evaluated, *(fault.place for fault in faults)])
        for place in (p for p in self.found.sorted(errors) if self.graph.upstream([p]) & errors == {p}):
            text = f"{short(place)} gives no number at this tool axis"
            faults.append(judge.fault(place, "wrong value", text, NO_NUMBER))
        return faults
