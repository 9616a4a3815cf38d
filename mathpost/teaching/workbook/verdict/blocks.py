"""Matrices and vectors that no result needs: known ones, and those that one cell keeps from being known."""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from mathpost.teaching.workbook.meaning.given import may_turn, runs
from mathpost.teaching.workbook.meaning.recognise import MIRRORED
from mathpost.teaching.workbook.report import Fault
from mathpost.teaching.workbook.sheet.place import Line, Place
from mathpost.teaching.workbook.sheet.samples import CLOSE, SAMPLES, same
from mathpost.teaching.workbook.verdict.known import Known, agree

if TYPE_CHECKING:
    from mathpost.teaching.workbook.verdict.judge import Judge

VECTOR = "with the cells in line it is a vector that follows from right results: a point, a sum, a mean, an axis"
COPIES = "with the cells in line it is such a vector, but for signs"


class Blocks:
    """Judge matrices and vectors by a `Judge` and what is `Known`; `faults` are those found in vectors."""

    def __init__(self, judge: Judge, known: Known) -> None:
        self.judge, self.graph, self.found, self.known = judge, judge.graph, judge.found, known
        self.faults: list[Fault] = []

    def matrices(self, rest: set[Place]) -> Iterator[Fault | Line]:
        """Matrices that no result needs and are none of the rotation: the faults of one cell or two, or all."""
        judge, unit = self.judge, np.repeat(np.eye(3).reshape(9, 1), SAMPLES, axis=1)
        known = [unit, *(matrix for c in judge.live for matrix in c.known.get(9, ()))]
        for window in self.found.windows:
            formulas, now = self.graph.trees.keys() & {*window}, judge.block(window)
            if len(window) != 9 or not formulas or not rest >= formulas or not may_turn(now[:, 1]):
                continue
            off = [[n for n in range(9) if not same(now[n], matrix[n])] for matrix in known]
            best = min(range(len(known)), key=lambda n: len(off[n]))
            one = {window[n]: known[best][n] for n in off[best]}
            faults = [judge.repaired_alone(p, value) for p, value in one.items()] if len(one) < 3 else [None]
            yield from [window] if None in faults else filter(None, faults)

    def judged(self, rest: set[Place]) -> tuple[dict[Place, str], set[Place]]:
        """The rules of the cells of known vectors, and the cells of which a text or a row says another one."""
        judge, judged, doubtful = self.judge, dict[Place, str](), set[Place]()
        lines = [line for line in runs(rest) if len(line) in (3, 4, 5)] * (not judge.unexplained)
        others = [line[n : n + 3] for line in lines for n in range(len(line) - 2)]
        others = [line for line in others if line not in self.found.beside]
        first = sorted(self.found.beside, key=lambda line: self.graph.calculation_order(line[0]))
        for triple in (*first, *others):
            if not rest.issuperset(triple[:3]) or not judged.keys().isdisjoint(triple):
                continue
            fits = agree(judge.block(triple[:3]), self.known.vectors)
            copies = self._is_of_signed_copies(triple[:3])
            if fits.all(axis=-1).any() or copies:
                judged |= dict.fromkeys(triple, COPIES if copies else VECTOR)
                doubtful.update(triple if self._is_said_otherwise(triple, copies) else ())
            elif fault := self._not_turned_back(triple[:3]) or self._only_one_unlike(
                triple, fits, alone=triple in others
            ):
                self.faults.append(fault)
                judged |= dict.fromkeys(triple, VECTOR)
        return judged, doubtful

    def _not_turned_back(self, triple: Line) -> Fault | None:
        """The fault of the cell of a result turned back that is not the point's, where the two others are."""
        judge, up = self.judge, self.graph.upstream(triple)
        for turn in (turn for turn in self.known.turns if turn.point and up.issuperset(turn.results)):
            wanted = dict(zip(triple, judge.block(turn.point[:3]), strict=True))
            wrong = [p for p, value in wanted.items() if not same(judge.now(p), value)]
            if len(wrong) == 1:
                place, value = wrong[0], wanted[wrong[0]]
                text = f"{self.graph.short(place)} does not lead back to the point, as the two others do"
                return judge.repaired_alone(place, value) or judge.fault(place, "wrong value", text)
        return None

    def _only_one_unlike(self, triple: Line, fits: np.ndarray, alone: bool) -> Fault | None:
        """The fault of the cell that keeps a vector from being a known one, if one repair makes it that."""
        nonzero = (np.abs(self.known.vectors[..., 1:]) > CLOSE).any(axis=-1)
        for n in np.flatnonzero((fits.sum(axis=-1) == 2) & (fits & nonzero).any(axis=-1))[:1]:
            (k,) = np.flatnonzero(~fits[n])
            if not (alone and self.known.is_known(triple[k])):
                return self.judge.repaired_alone(triple[k], self.known.vectors[n, k])
        return None

    def _is_of_signed_copies(self, triple: Line) -> bool:
        """Whether a vector is a known one, some of its coordinates with a minus, as in a mirror."""
        trees = [self.graph.tree(p) for p in triple]
        plain = [tree[1] if tree[0] == "minus" else tree for tree in trees]
        if trees == plain or any(part[0] != "area" for part in plain):
            return False
        return bool(agree(np.abs(self.judge.block(triple)), np.abs(self.known.vectors)).all(axis=-1).any())

    def _is_said_otherwise(self, triple: Line, copies: bool) -> bool:
        """Whether a known vector is said to be mirrored and is not, or the reverse, or is another row's."""
        is_said = re.search(MIRRORED, self.found.heading(triple), re.I)
        plain = is_said and all(self.graph.tree(p)[0] == "area" for p in triple[:3])
        return bool(plain or (copies and not is_said) or self._is_of_another_row(triple[:3]))

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
        turns = [turn for turn in self.known.turns if turn.point and len(turn.results) == 3]
        ends = [(self.judge.block(turn.point), np.array([*turn.targets.values()])) for turn in turns]
        rows = [turn.results[0][:2] for turn in turns for _ in (0, 1)]
        return rows, np.array([end for both in ends for end in both])
