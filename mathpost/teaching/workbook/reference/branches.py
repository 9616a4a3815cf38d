"""Ways through formulas that no sample takes: which there are, and inputs moved until they are taken.

A condition, a MAX, an ABS or a lookup takes one of several ways. Where all samples take the same one, a slip in
another is not seen. So an input, or a list of them, is moved until the way changes: to a hundredth or a hundred
times of what it is, and to where the two sides of a condition are equal; its sign stays unless its list has both.
Both workbooks are compared along the way. Only a difference that begins where some way changes counts: two formulas
that part elsewhere do so because an input has left the range for which it is meant, as an angle beyond 90° has.

A formula that is in both workbooks, with the same quantities in it, needs no sample. A way that cannot be reached
is told, and the result is judged by what was compared.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from mathpost.teaching.workbook.reference.forks import (
    BRANCHING,
    EQUALITIES,
    EXTREMES,
    LOOKUPS,
    SELECTED,
    Fork,
    Missing,
    forks,
    named,
)
from mathpost.teaching.workbook.reference.matched import runs
from mathpost.teaching.workbook.reference.moved import FROM, STEPS, Move, Telling, Way
from mathpost.teaching.workbook.reference.quantities import AGREE, NOTHING, Dictionary, Sheet
from mathpost.teaching.workbook.sheet.place import Line, Place, offset
from mathpost.teaching.workbook.sheet.samples import Values, at_samples
from mathpost.teaching.workbook.sheet.tree import heads

if TYPE_CHECKING:
    from mathpost.teaching.workbook.reference.results import Comparison

FACTORS = 1.1 ** np.arange(1, 49)  # to about a hundred
BESIDE = 0.02  # relative: beyond the number with which an input is compared
MOST_INPUTS, MOST_SEARCHES, MOST_STEPS = 12, 40, 5
MOST_ROWS = 2  # of a table of one formula that are tried


class Search:
    """Two workbooks of which the results that were `found`, result → cell, are compared along moved inputs."""

    def __init__(self, comparison: Comparison, found: Mapping[Place, Place]) -> None:
        self.comparison, self.found = comparison, found
        self.ours, self.theirs = comparison.reference, comparison.handed_in
        names = Dictionary(
            (p, v) for p, v in comparison.ours.items() if p in comparison.given or p in self.ours.trees
        )
        both = (self.ours, found.keys(), comparison.ours), (self.theirs, found.values(), comparison.theirs)
        formulas = [
            {
                named(sheet.trees[p], names, sheet, values)
                for p in sheet.upstream(cells) & sheet.trees.keys()
                if heads(sheet.trees[p]) & BRANCHING
            }
            for sheet, cells, values in both
        ]
        known = formulas[0] & formulas[1]
        self.forks = [fork for sheet, cells, values in both for fork in forks(sheet, cells, known, names, values)]
        self.missing = [each for fork in self.forks for each in fork.not_taken(self._values(fork))]
        self._given_numbers = {p: float(at_samples(v)[FROM]) for p, v in comparison.given.items()}
        self._in_lists = {p for line in self._lists for p in line}
        self.not_reached: list[Missing] = []
        self.errors: list[Telling] = []

    def _values(self, fork: Fork) -> Values:
        return self.comparison.ours if fork.sheet is self.ours else self.comparison.theirs

    def telling(self) -> list[Telling]:
        """Where the first result differs that does; empty if none does anywhere."""
        tries: Counter[tuple] = Counter()
        left, searches = [*self.missing], 0
        while left:
            missing = left.pop(0)
            if (rows := self._rows(missing)) is not None:
                tries[rows] += 1
                if tries[rows] > MOST_ROWS:
                    continue
            searches += 1
            some = self._groups(missing) if searches <= MOST_SEARCHES else ()
            way = next(self._ways_to(missing, some), None)
            if way is None:
                self.not_reached += [missing] * (missing.way != 0 or missing.fork.tree[0] in EQUALITIES)
                continue
            told = self._told(missing, way)
            self.errors += [each for each in told if each.is_error]
            if told := [each for each in told if not each.is_error]:
                return told
            left = [each for each in left if not (each.goes_with(missing) and self._takes(each, way).any())]
        return []

    def _rows(self, missing: Missing) -> tuple | None:
        """What the rows of a table share in which both workbooks have one formula each: few of these are tried."""
        fork = missing.fork
        here, there = (self.ours, self.theirs) if fork.sheet is self.ours else (self.theirs, self.ours)
        partner = self._partners[here].get(fork.place)
        patterns = here.relative(fork.place), there.relative(partner) if partner else None
        if None in patterns:
            return None
        return here is self.ours, *patterns, self._numbers[id(fork)], missing.way

    @cached_property
    def _partners(self) -> dict[Sheet, dict[Place, Place]]:
        """Cell of one workbook → the cell of the other that is the same quantity."""
        pairs = [*self._steps.items(), *self.found.items()]
        return {self.ours: dict(pairs), self.theirs: {cell: place for place, cell in pairs}}

    @cached_property
    def _numbers(self) -> dict[int, int]:
        """Fork, by its identity → which it is of its cell."""
        counts: Counter[tuple[bool, Place]] = Counter()
        found = {}
        for fork in self.forks:
            key = fork.sheet is self.ours, fork.place
            found[id(fork)] = counts[key]
            counts[key] += 1
        return found

    def _takes(self, missing: Missing, way: Way) -> np.ndarray:
        """At which samples of a way a fork takes what is missing, and the reference has a result."""
        return np.broadcast_to(missing.taken(way.values(missing.fork.sheet)), way.count) & self._fine(missing, way)

    def _ways_to(self, missing: Missing, some: Iterable[Sequence[Line]]) -> Iterator[Way]:
        """Yield inputs moved until a way is taken, the shortest way of each of some groups that may be moved."""
        for groups in some:
            moves = [move for group in groups for move in self._moves(group, missing)]
            if not moves:
                continue
            ends = np.cumsum([len(move.factors) for move in moves])
            parts = np.split(self._takes(missing, self._moved(moves)), ends[:-1])
            reached = [(move, int(np.argmax(part))) for move, part in zip(moves, parts, strict=True) if part.any()]
            if reached:
                move, n = min(reached, key=lambda each: abs(each[0].factors[each[1]] - 1))
                way = self._moved([move.closer(n)])
                yield way.until(int(np.argmax(self._takes(missing, way))))

    def _groups(self, missing: Missing) -> list[list[Line]]:
        """Inputs of the reference that may be moved: lists together, then one by one."""
        fork, given = missing.fork, self.comparison.given
        sheet, back = fork.sheet, self.comparison.matched.back
        upstream = sheet.upstream(sheet.used_by(fork.tree))
        first: set[Place] = set()
        cells = [place for part in fork.tree[1:] if part[0] == "area" for place in part[1].places]
        if fork.tree[0] in EXTREMES and missing.way is not None and max(missing.way, missing.seen) < len(cells):
            first = sheet.upstream([cells[int(missing.way)]]) - sheet.upstream([cells[int(missing.seen)]])

        if fork.tree[0] in LOOKUPS:
            first = sheet.upstream(sheet.used_by(fork.tree[1]))

        def own(places: Iterable[Place]) -> list[Place]:
            return [p for p in given if p in places] if sheet is self.ours else [p for c in back if c in places
                    for p in [back[c]] if p in given]  # fmt: skip

        inputs, exclusive = own(upstream), {*own(first)}
        lists = [line for line in self._lists if not {*inputs}.isdisjoint(line)]
        singles = sorted(inputs, key=lambda p: p not in exclusive)
        return [lists[:MOST_INPUTS], [(p,) for p in singles[:MOST_INPUTS]]]

    def _moves(self, group: Line, missing: Missing) -> Iterator[Move]:
        """Ways for some inputs to go: up, down to nothing, and to where a condition changes."""
        start = {p: self._given_numbers[p] for p in group}
        if not self.comparison.selectors.isdisjoint(group):
            number = start[group[0]]
            others = sorted({*SELECTED} - {number}, key=lambda other: abs(other - number))
            yield Move(start, np.array(others) / number, has_steps=True)
            return
        yield Move(start, FACTORS)
        yield Move(start, np.append(1 / FACTORS, 0.0))
        trial = self._moved([Move(start, np.array([1.0, FACTORS[0]]))])
        off = missing.fork.off(trial.values(missing.fork.sheet), missing.way)
        if off is None or len(off) < 2 or not np.isfinite(off).all() or off[0] == off[1]:
            return
        goal = 1 - off[0] * (FACTORS[0] - 1) / (off[1] - off[0])
        beyond = goal + np.copysign(BESIDE * max(abs(goal), abs(goal - 1)), goal - 1)
        mixed = any(number <= 0 for p in group for number in self._list_of(p))
        if mixed or beyond >= 0:
            yield Move(start, np.append(np.linspace(1, goal, STEPS + 1)[1:], beyond))
        elif goal >= 0:
            yield Move(start, np.linspace(1, goal, STEPS + 1)[1:])

    def _list_of(self, place: Place) -> list[float]:
        """The numbers of the list in which an input is."""
        numbers = self.ours.numbers_typed
        lines = [line for line in self._runs if place in line]
        return [numbers[p] for line in lines for p in line] or [numbers[place]]

    @cached_property
    def _runs(self) -> list[Line]:
        return [*runs([*self.comparison.given])]

    @cached_property
    def _lists(self) -> list[Line]:
        """The inputs in a row or a column that formulas of one pattern use."""
        ours = self.ours
        uses = {p: {ours.relative(user) for user in ours.used.get(p, ())} for line in self._runs for p in line}
        return [line for line in self._runs if set.intersection(*(uses[p] for p in line)) - {None}]

    def _moved(self, moves: Sequence[Move]) -> Way:
        """Both workbooks along some moves, one after the other."""
        comparison, start = self.comparison, 0
        count = sum(len(move.factors) for move in moves)
        moved = {place: np.full(count, number) for move in moves for place, number in move.start.items()}
        for move in moves:
            for place in move.start:
                moved[place][start : start + len(move.factors)] = move.numbers(place)
            start += len(move.factors)
        factor, cells = comparison.matched.factor, comparison.matched.cells
        put = {cell: v * factor.get(p, 1.0) for p, v in moved.items() for cell in cells[p]}
        values: list[Values] = []
        for sheet, base, given, results in (
            (self.ours, comparison.ours, moved, self.found.keys()),
            (self.theirs, comparison.theirs, put, self.found.values()),
        ):
            others = {p: v[FROM : FROM + 1] if len(v) > 1 else v for p, v in base.items()}
            only = sheet.downstream(given) & sheet.upstream(results)
            values.append(sheet.run(given, others, only))
        return Way(moved, values[0], values[1], self.ours)

    def _fine(self, missing: Missing, way: Way) -> np.ndarray:
        """Where a result that depends on a way is a number in the reference."""
        sheet = missing.fork.sheet
        after = sheet.downstream([missing.fork.place])
        fine = np.zeros(way.count, bool)
        for result, cell in self.found.items():
            if (result if sheet is self.ours else cell) in after:
                fine |= np.isfinite(way.ours[result])
        for place, values in way.given.items():
            fine &= self._keeps_order(place, values)
        return fine

    def _keeps_order(self, place: Place, values: np.ndarray) -> np.ndarray:
        """Where an input in a table is still more or less than those in its row or column, as it was given.

        An upper deviation is above the lower one, and the keys of a table rise.
        """
        numbers, fine = self._given_numbers, np.ones(len(values), bool)
        for line in self._lists:
            if place in line:
                along = (0, 1) if line[0][2] == line[1][2] else (1, 0)
                for sign in (1, -1):
                    near = offset(place, sign * along[0], sign * along[1])
                    if near in numbers and near in self._in_lists:
                        fine &= np.sign(values - numbers[near]) == np.sign(numbers[place] - numbers[near])
        return fine

    def _told(self, missing: Missing, way: Way) -> list[Telling]:
        """Where results begin to differ along a way; or steps, which others may hide, with one input alone."""
        if told := [*self._differing(way, self.found)]:
            return told
        for step in [*self._differing(way, self._steps)][:MOST_STEPS]:
            cells = step.result, self._steps[step.result]
            for fork in (each for each in self.forks if each.place in cells):
                alone = Missing(fork, missing.way, missing.seen)
                for apart in self._ways_to(alone, self._groups(alone)[1:]):
                    if told := [*self._differing(apart, self.found)]:
                        return told
        return []

    @cached_property
    def _steps(self) -> dict[Place, Place]:
        """Formula of the reference → the cell of the hand-in, before the results, that is what it is."""
        comparison = self.comparison
        found = {}
        for cell in self.theirs.upstream(self.found.values()) & self.theirs.trees.keys() - {*self.found.values()}:
            for place in comparison.steps.find(comparison.theirs[cell])[:1]:
                found[place] = cell
        return found

    def _differing(self, way: Way, cells: Mapping[Place, Place]) -> Iterator[Telling]:
        """Where cells begin to differ along a way, as another way through a formula is taken there."""
        for result, cell in cells.items():
            if cell not in way.theirs or result not in way.ours:
                continue
            ours, theirs = (np.broadcast_to(v, way.count) for v in (way.ours[result], way.theirs[cell]))
            size = np.maximum(np.abs(ours), np.abs(self.comparison.ours[result]).max())
            off = np.isfinite(ours) & ~(np.abs(ours - theirs) <= AGREE * size + NOTHING)
            n = int(np.argmax(off))
            if off[n] and n <= way.reached and self._turns(way, n, result, cell):
                given = {p: float(v[n]) for p, v in way.given.items()}
                yield Telling(result, given, not np.isfinite(theirs[n]), not off[n + 1 :].any())

    def _turns(self, way: Way, n: int, result: Place, cell: Place) -> bool:
        """Whether some fork that a result depends on takes another way at one sample than at the one before."""
        before = {self.ours: self.ours.upstream([result]), self.theirs: self.theirs.upstream([cell])}
        for fork in self.forks:
            if fork.place in before[fork.sheet]:
                first = at_samples(fork.ways(self._values(fork)))[FROM]
                ways = np.append(first, np.broadcast_to(fork.ways(way.values(fork.sheet)), way.count))
                if ways[n] != ways[n + 1]:
                    return True
        return False
