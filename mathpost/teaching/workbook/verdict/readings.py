"""Which rotation a sheet means where its texts, or its headings, leave open or change what the task asks for."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from mathpost import euler
from mathpost.teaching.workbook.meaning.calculation import Turn
from mathpost.teaching.workbook.meaning.texts import PASSIVE, SAID_ACTIVE
from mathpost.teaching.workbook.meaning.vocabulary import wording
from mathpost.teaching.workbook.sheet.samples import same

if TYPE_CHECKING:
    from mathpost.teaching.workbook.report import Fault
    from mathpost.teaching.workbook.verdict.judge import Judge

RECIPE = rf"{wording('a recipe', 'transposed')}|\^ ?T\b|ᵀ"
PRODUCT = re.compile(r"= *((?:\w+(?:\([^()]*\))? *(?:ᵀ|\^T)? *[·*×∙⋅] *){2,4})\w")
FACTOR = re.compile(r"(\w+?(?:\([^()]*\))?) *(ᵀ|\^T)? *[·*×∙⋅]")
Reading = tuple[str, bool]  # a sequence, and whether it is active
OTHER_CONVENTION = "all results are right in a different sequence or convention than the task's"


class Readings:
    """Compare the rotations of a `Judge` with other sequences, and with the other convention."""

    def __init__(self, judge: Judge) -> None:
        self.judge, self.graph, self.found = judge, judge.graph, judge.found

    def read_the_headings(self) -> None:
        """Take a result the other way where its heading says so and it is that, beside one that is as asked."""
        turns = self.judge.live
        off = [turn for turn in turns if len(self.judge.bad(turn.targets)) > 1]
        for turn in off if len(off) < len(turns) else ():
            heading = self.found.heading(turn.results)
            said = PASSIVE if turn.active else f"{SAID_ACTIVE}|{wording('the point turns')}"
            if re.search(said, heading, re.I) and not re.search(RECIPE, heading, re.I):
                self._turn_round(turn)
                if not self.judge.met(turn.targets):
                    self._turn_round(turn)

    def _turn_round(self, turn: Turn) -> None:
        before, after = ("active", "passive") if turn.active else ("passive", "active")
        turn.active, turn.said = not turn.active, turn.said.replace(before, after)
        self.judge.prepare([turn])

    def left_open(self) -> tuple[str, str] | None:
        """The sequence and convention that all results are of, where no text settles it; None if as asked."""
        if self.judge.met(self.judge.targets) or self._as_the_text_may_mean():
            return None
        if not (self.found.is_open or self.found.by == "source 000"):
            return None
        known = (self.found.sequence.upper(),) if self.found.by == "the text" else euler.SEQUENCES
        every = _all_of(known[not self.found.is_open :])
        axes = {True: "turned", False: "fixed"}
        every = [each for each in every if self.found.axes in ("", axes[each[0].isupper()])]
        reading = self._other(self.judge.live, every)
        as_asked = self.found.sequence, "active" if self.found.active else "passive"
        return None if reading == as_asked else reading

    def of_another_convention(self, unexplained: Sequence[Turn]) -> list[Fault]:
        """Return the faults of results without a repair if all are of another convention than the task's."""
        every = _all_of(euler.SEQUENCES) if self.found.by == "the task" else []
        other = self._other(unexplained, every)
        if other is None:
            return []
        text = f"it is {' '.join(other)}, and {self.found.calculations[0].said} is asked for"
        return [self.judge.fault(c.results[0], "other convention", text, OTHER_CONVENTION) for c in unexplained]

    def _as_the_text_may_mean(self) -> bool:
        """Take the sheet as what it calculates if the text, which has words for both, may mean that."""
        said = self.found.sequence, "active" if self.found.active else "passive"
        also = _all_of([self.found.sequence.upper()]) if self._follows_the_text() else self.found.also
        other = self._other(self.judge.live, also) if also else None
        if other is None:
            return False
        turns = self.judge.live
        for turn in turns:
            turn.said = f"right as {' '.join(other)}; the text may mean {' '.join(said)}"
        self.judge.targets |= {p: t for turn in turns for p, t in turn.targets.items()}
        self.found.sequence, self.found.active = other[0], other[1] == "active"
        return True

    def _follows_the_text(self) -> bool:
        """Whether all results are the product of matrices that a formula in the text names, as x = Dᵀ·Cᵀ·Bᵀ·p."""
        judge, found = self.judge, self.found
        if found.task.convention or found.task.sequence:
            return False
        windows = {_name(t): w for w in found.windows if len(w) == 9 for t in found.texts(w[0])[:1]}
        turns = [c for c in judge.live if c.point and not (c.origin or c.shift)]
        for formula in PRODUCT.finditer(found.text) if turns else ():
            factors = FACTOR.findall(formula[1])
            if {_name(name) for name, _ in factors} <= windows.keys():
                turn = np.eye(3)
                for name, turned in factors:
                    matrix = np.moveaxis(judge.block(windows[_name(name)]).reshape(3, 3, -1), -1, 0)
                    turn = turn @ (np.swapaxes(matrix, 1, 2) if turned else matrix)
                made = [np.einsum("sij,js->is", turn, judge.block(each.point)) for each in turns]
                own = [judge.block(each.results[:3]) for each in turns]
                return len(turns) == len(judge.live) and all(map(same, made, own))
        return False

    def _other(self, calculations: Sequence[Turn], readings: Iterable[Reading]) -> tuple[str, str] | None:
        """The sequence and convention, of some, that all results are of, or None; rotations are left as these."""
        turns = [c for c in calculations if not c.axis]
        for sequence, active in (*readings, (self.found.sequence, self.found.active)) if turns else ():
            for turn in turns:
                turn.sequence, turn.active = sequence, active != turn.back
            if all(self._is_met(turn) for turn in turns):
                return sequence, "active" if active else "passive"
        self.judge.prepare(turns)
        return None

    def _is_met(self, calculation: Turn) -> bool:
        self.judge.prepare([calculation])
        return self.judge.met(calculation.targets)


def _all_of(sequences: Iterable[str]) -> list[Reading]:
    """The sequences about turned and about fixed axes, passive and active."""
    return [(s, active) for n in sequences for s in (n, n.lower()) for active in (False, True)]


def _name(text: str) -> str:
    """The name of a matrix without brackets and signs."""
    return re.sub(r"\W", "", text)
