"""Vectors beside the calculations: known ones, and those that one slip keeps from being known."""

from __future__ import annotations

import re
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from mathpost.teaching.workbook.meaning.calculation import SAMPLES
from mathpost.teaching.workbook.meaning.given import runs
from mathpost.teaching.workbook.meaning.recognise import MIRRORED
from mathpost.teaching.workbook.sheet.edits import edits, said
from mathpost.teaching.workbook.sheet.formula import Tree
from mathpost.teaching.workbook.sheet.place import Line
from mathpost.teaching.workbook.sheet.samples import CLOSE, Values, at, same
from mathpost.teaching.workbook.sheet.tree import areas
from mathpost.teaching.workbook.verdict.known import agree
from mathpost.teaching.workbook.verdict.why import TRANSPOSED

if TYPE_CHECKING:
    from mathpost.teaching.workbook.report import Fault
    from mathpost.teaching.workbook.sheet.place import Place
    from mathpost.teaching.workbook.verdict.around import Around
    from mathpost.teaching.workbook.verdict.judge import Judge
    from mathpost.teaching.workbook.verdict.known import Known

KNOWN = "with the cells in line it is a vector that follows from right results: a point, a sum, a mean, an axis"
COPIES = "with the cells in line it is such a vector, but for signs"


class BesideVectors:
    """Judge vectors that no result needs by what is `Known`.

    `doubtful` are those that are not what a text says, `rules` has what told the others. A vector with a single
    wrong cell is added to the judge's faults.
    """

    def __init__(self, judge: Judge, known: Known, around: Around) -> None:
        self.judge, self.graph, self.found = judge, judge.graph, judge.found
        self.known, self.around = known, around
        self.tried: set[Place] = set()
        self.doubtful: set[Place] = set()
        self.rules: dict[Place, str] = {}
        self.turns, self.is_known = known.turns, known.is_known

    def judged(self, rest: set[Place]) -> set[Place]:
        """Return the cells of known vectors; a vector with a single wrong cell becomes a fault."""
        judge = self.judge
        judged: set[Place] = set()
        lines = [line for line in runs(rest) if len(line) in (3, 4, 5)] * (not judge.unexplained)
        others = [line[n : n + 3] for line in lines for n in range(len(line) - 2)]
        others = [line for line in others if line not in self.found.beside]
        first = sorted(self.found.beside, key=lambda line: self.graph.calculation_order(line[0]))
        for triple in (*first, *others):
            if not rest.issuperset(triple[:3]) or judged.intersection(triple):
                continue
            fits = agree(judge.block(triple[:3]), self.known.vectors)
            copies = self._is_of_signed_copies(triple[:3])
            if fits.all(axis=-1).any() or copies:
                judged.update(triple)
                self.rules |= dict.fromkeys(triple, COPIES if copies else KNOWN)
                self._doubt(triple, copies)
            elif self._has_a_slip(triple, fits, rest, alone=triple in others):
                judged.update(triple)
        return judged

    def _doubt(self, triple: Line, copies: bool) -> None:
        """Doubt a known vector that is said to be mirrored and is not, or the reverse, or is another row's."""
        is_said = re.search(MIRRORED, self.found.heading(triple), re.I)
        plain = is_said and all(self.graph.tree(p)[0] == "area" for p in triple[:3])
        if plain or (copies and not is_said) or self._is_of_another_row(triple[:3]):
            self.doubtful.update(triple)

    def _has_a_slip(self, triple: Line, fits: np.ndarray, rest: set[Place], alone: bool) -> bool:
        """Whether a repair makes a vector a known one: a fault."""
        if self._has_one_wrong(triple, fits, rest, alone):
            return True
        if self.judge.unexplained:
            return False
        return self._is_turned_back(triple[:3], rest) or self._has_one_slip(triple[:3])

    def _has_one_wrong(self, triple: Line, fits: np.ndarray, rest: set[Place], alone: bool) -> bool:
        """Whether one repair makes a vector of which two cells are known a known one: a fault."""
        judge = self.judge
        nonzero = (np.abs(self.known.vectors[..., 1:]) > CLOSE).any(axis=-1)
        for n in np.flatnonzero((fits.sum(axis=-1) == 2) & (fits & nonzero).any(axis=-1))[:1]:
            (k,) = np.flatnonzero(~fits[n])
            place, wanted = triple[k], self.known.vectors[n, k]
            if alone and self.is_known(place):
                return False
            before = None if judge.unexplained else self._repaired_before({place: wanted}, rest)
            fault = before or judge.repaired_alone(place, wanted)
            judge.faults += filter(None, [fault])
            return fault is not None
        return False

    def _is_of_signed_copies(self, triple: Line) -> bool:
        """Whether a vector is a known one, some of its coordinates with a minus, as in a mirror."""
        trees = [self.graph.tree(p) for p in triple]
        plain = [tree[1] if tree[0] == "minus" else tree for tree in trees]
        fits = agree(np.abs(self.judge.block(triple)), np.abs(self.known.vectors))
        return trees != plain and all(part[0] == "area" for part in plain) and bool(fits.all(axis=-1).any())

    def _is_of_another_row(self, triple: Line) -> bool:
        """Whether a vector, calculated in the row of a table, is the point or result of another row only."""
        rows, ends = self._ends
        if triple[0][:2] not in rows or all(self.graph.tree(p)[0] == "area" for p in triple):
            return False
        fits = np.asarray(agree(self.judge.block(triple), ends).all(axis=-1))
        own = np.array([row == triple[0][:2] for row in rows])
        return len(rows) > 4 and bool(fits[~own].any()) and not fits[own].any()

    @cached_property
    def _ends(self) -> tuple[list[tuple[str, int]], np.ndarray]:
        """The row, as sheet and number, and the values of every point that is turned, and of what becomes of it."""
        turns = [turn for turn in self.turns if turn.point and len(turn.results) == 3]
        rows = [turn.results[0][:2] for turn in turns]
        ends = [(self.judge.block(turn.point), np.array([*turn.targets.values()])) for turn in turns]
        return [row for row in rows for _ in (0, 1)], np.array([end for both in ends for end in both])

    def _repaired_before(self, wanted: Values, rest: set[Place]) -> Fault | None:
        """The fault of an earlier cell of `rest`, nothing known, if one repair of it makes all `wanted` right."""
        graph, judge = self.graph, self.judge
        earlier = graph.upstream(wanted) & rest & graph.trees.keys() - wanted.keys() - self.tried
        for first in sorted(earlier, key=graph.calculation_order):
            if first in self.tried or self.is_known(first):
                continue
            array = graph.array(first)
            self.tried.update(array)  # what does not make these right is not the cause of others either
            for cause, old, new, tree in edits(graph, first):
                made = graph.calculate(tree, judge.values)
                option = {p: np.broadcast_to(at(made, graph.part.get(p, (0, 0))), SAMPLES) for p in array}
                values = judge.values_with(option)
                if all(p in values and same(values[p], value) for p, value in wanted.items()):
                    judge.put(option)
                    return self._fault(min(array, key=graph.reading_order), cause, old, new)
        return None

    def _is_turned_back(self, triple: Line, rest: set[Place]) -> bool:
        """Whether a result is turned back, to the point, by a matrix with a slip, or that should be transposed."""
        up, judge = self.graph.upstream(triple), self.judge
        for turn in self.turns:
            if not turn.point or not up.issuperset(turn.results):
                continue
            option = dict(zip(triple, judge.block(turn.point), strict=True))
            if fault := self._repaired_before(option, rest):
                judge.faults.append(fault)
                return True
            wrong = [p for p, value in option.items() if not same(judge.now(p), value)]
            if len(wrong) == 1:
                judge.put(option)
                text = f"{self.graph.short(wrong[0])} does not lead back to the point, as the two others do"
                judge.faults.append(judge.fault(wrong[0], "wrong value", text))
                return True
            for window in (w for w in self.found.windows if len(w) == 9 and (up & rest).issuperset(w)):
                turned = judge.block(window).reshape(3, 3, -1).swapaxes(0, 1).reshape(9, -1)
                other = {p: new for p, new in zip(window, turned, strict=True) if not same(judge.now(p), new)}
                values = judge.values_with(other)
                if all(same(values[p], value) for p, value in option.items()):
                    judge.put(other)
                    judge.faults += [judge.fault(p, *TRANSPOSED) for p in other]
                    return True
            if block := judge.why.of_the_block(turn, triple, option):
                judge.put(option)
                judge.faults += [judge.fault(p, *block[:2]) for p in triple]
                return True
        return False

    def _has_one_slip(self, triple: Line) -> bool:
        """Whether one slip in all three cells keeps them from a sum, mean or difference of points: three faults."""
        points = {p for turn in self.turns for p in (*turn.point, *turn.results)}
        of_points = not points.isdisjoint(self.graph.upstream(triple))
        if self.judge.unexplained or not of_points or any(map(self.is_known, triple)):
            return False
        judge, tried, combined = self.judge, [], self.known.combined
        fits = (np.ptp(combined[..., 1:], axis=-1) > CLOSE).all(axis=-1)  # no zeros, as of two that are equal
        for k, place in enumerate(triple):
            if not fits.any():
                return False
            repairs = [*edits(self.graph, place)] if place in self.graph.trees else []
            repairs = [each for each in repairs if self.graph.component.keys() >= {*self.graph.used_by(each[3])}]
            own, part = areas(self.graph.tree(place)), self.around.is_of_a_part(place)
            wholes = [] if part else [[self.around.whole(area, place) for area in own]]
            sizes = [area.shape for area in own]
            repairs = [e for e in repairs if areas(e[3]) in wholes or [a.shape for a in areas(e[3])] == sizes]
            made = np.array([judge.calculate(place, tree) for *_, tree in repairs]).reshape(-1, 1, SAMPLES)
            tried.append((repairs, agree(made, combined[:, k])))
            fits &= tried[-1][1].any(axis=0)
        for n in np.flatnonzero(fits)[:1]:
            found = [repairs[int(good[:, n].argmax())] for repairs, good in tried]
            if len({cause for cause, *_ in found}) == 1:
                judge.put(dict(zip(triple, combined[n], strict=True)))
                for place, (cause, old, new, _) in zip(triple, found, strict=True):
                    judge.faults.append(self._fault(place, cause, old, new))
                return True
        return False

    def _fault(self, place: Place, cause: str, old: Tree, new: Tree) -> Fault:
        return self.judge.fault(place, cause, f"{self.graph.short(place)}: {said(place, old, new)}")
