"""Where is it wrong? The earliest place where putting in the right thing makes all that follows right.

`Where.earliest` returns the faults, and what to put where, so that what follows is judged without them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from functools import cache, partial
from itertools import chain, islice
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from mathpost.teaching.workbook.meaning.calculation import Turn
from mathpost.teaching.workbook.sheet.edits import ROUGHLY, TO_DEGREES, TO_RADIANS, edits
from mathpost.teaching.workbook.sheet.samples import SAMPLES, at_samples, same
from mathpost.teaching.workbook.sheet.tree import CONVERSIONS, ROUNDING, exact, heads
from mathpost.teaching.workbook.verdict.sampled import as_window
from mathpost.teaching.workbook.verdict.why import UNEXPLAINED

if TYPE_CHECKING:
    from mathpost.teaching.workbook.report import Fault
    from mathpost.teaching.workbook.sheet.place import Line, Place
    from mathpost.teaching.workbook.sheet.samples import Values
    from mathpost.teaching.workbook.verdict.judge import Judge

TURNING = {"SIN", "COS", "TAN"}
AT_ONCE = 16  # options that are tried side by side
EARLIEST = "it is the earliest cell whose repair makes all results that follow from it right"
Each = TypeVar("Each")


class Where:
    """The search for repairs of what a `Judge` finds wrong."""

    def __init__(self, judge: Judge) -> None:
        self.judge, self.graph, self.found = judge, judge.graph, judge.found

    def earliest(
        self, calculation: Turn, targets: Values, bad: list[Place], missed: Values
    ) -> tuple[Values, list[Fault]] | None:
        """The earliest repair: what it puts where, and its faults.

        One that changes what other calculations `missed`, and does not mend it, is less likely.
        """
        best: tuple[Any, ...] | None = None
        candidates = self._candidates(calculation, targets, bad)
        for order, unit, options in sorted(candidates, key=lambda candidate: candidate[0]):
            if best and best[0] == 0 and order > best[1]:
                break
            for option in options:
                cost, faults = self.judge.why.explain(calculation, unit, option)
                others = {p: missed[p] for p in self.graph.downstream(option) & missed.keys()}
                cost += 0.1 * bool(others and not self.judge.met(others, self.judge.values_with(option)))
                own = (*min(map(self.graph.calculation_order, option)), order[-1])
                best = min(best or (99,), (cost, max(order, own), option, faults), key=lambda b: b[:2])
        if best is None or (best[0] >= UNEXPLAINED and not len(bad) == 1 < len(calculation.targets)):
            return None
        mates = [q for p in best[2] for q in self.judge.graph.array(p)] if best[0] < UNEXPLAINED else ()
        put = {q: self.judge.targets[q] for q in mates if q in self.judge.targets} | best[2]
        return put, [replace(fault, rule=EARLIEST) for fault in best[3]]

    def _candidates(
        self, calculation: Turn, targets: Values, bad: list[Place]
    ) -> Iterator[tuple[tuple, Line, Iterator[Values]]]:
        """(order, cells, what may belong there): matrices, vectors, a cosine with its sine, single cells, all."""
        graph, found, scope = self.graph, self.found, self.graph.upstream(bad)
        blocks = [w for w in found.windows if not scope.isdisjoint(w)]
        pairs: dict[tuple[Place, ...], list[Place]] = {}
        formulas = scope & graph.trees.keys() - self.judge.inputs.keys()
        for place in self.found.sorted(formulas - {p for window in blocks for p in window}):
            if heads(graph.trees[place]) & {"SIN", "COS", "TAN"}:
                pairs.setdefault(tuple(graph.uses[place]), []).append(place)
        blocks += self.lines(calculation, scope)
        for block in (*blocks, *(tuple(pair) for pair in pairs.values() if len(pair) == 2)):
            order = min(map(graph.calculation_order, [p for p in block if p in graph.trees] or block))
            known = [dict(zip(block, each, strict=True)) for each in calculation.known.get(len(block), ())]
            yield (*order, len(block)), block, self._tried(known, targets, bad)
        typed = scope & (found.constants | (found.typed & targets.keys()))
        places = sorted(formulas | typed, key=graph.calculation_order)
        moving = [p for p in places if p not in targets and graph.downstream([p]).issuperset(bad)]
        moved = cache(self._moved)
        for batch in batched(moving, AT_ONCE):
            for n, place in enumerate(batch):
                options = self._cell_options(calculation, place, targets, bad, partial(moved, batch), n)
                yield (*graph.calculation_order(place), 0), (place,), options
        for place in (p for p in places if p in targets):
            options = self._tried([{place: targets[place]}], targets, bad)
            yield (*graph.calculation_order(place), 0), (place,), options
        everywhere = (("rounded early", ROUNDING), (TO_RADIANS[0], TURNING), (TO_DEGREES[0], TURNING))
        for number, (kind, functions) in enumerate(everywhere):
            places = [p for p in self.found.sorted(formulas) if heads(graph.trees[p]) & functions]
            slips = {p: next((e[3] for e in edits(graph, p) if e[0] == kind), None) for p in places}
            option = {p: self.judge.calculate(p, tree) for p, tree in slips.items() if tree}
            if len(option) > 1:  # the same slip everywhere
                yield (97, (number,), 0), tuple(option), self._tried([option], targets, bad)
        exactly = {
            p: tree
            for p in self.found.sorted(formulas)
            if (tree := exact(graph.trees[p], ROUGHLY)) != graph.trees[p]
        }
        option = {p: self.judge.calculate(p, tree) for p, tree in exactly.items()}
        yield (97, (9,), 0), tuple(option), self._tried([option], targets, bad)
        # All matrices of the other convention.
        windows = (as_window(w, other).items() for w, (_, other) in self.judge.elements(calculation).items())
        option = dict(chain.from_iterable(windows))
        yield (98, (0,), 0), tuple(option), self._tried([option], targets, bad)

    def lines(self, calculation: Turn, scope: set[Place]) -> list[Line]:
        """Triples and quadruples of vector cells, the results among them."""
        vectors = self.found.vectors & scope
        lines = {c for p in vectors for c in [self.graph.component[p]] if len(c) in (3, 4)}
        lines = {line for line in lines if len(vectors.intersection(line)) >= 2} | {calculation.results}
        return sorted(lines, key=lambda line: [self.graph.reading_order(p) for p in line])

    def _tried(self, options: Iterable[Values], targets: Values, bad: list[Place]) -> Iterator[Values]:
        """Yield the changes made by those options (place → value) that meet the targets, `bad[0]` first."""
        first, before = bad[0], self.graph.upstream(bad[:1])
        for batch in batched(options, AT_ONCE):
            changes = [{p: v for p, v in option.items() if not same(self.judge.now(p), v)} for option in batch]
            reach = {places: self.graph.downstream(places) for places in map(tuple, changes)}
            affected = [reach[tuple(changed)] for changed in changes]
            tried = [n for n, reached in enumerate(affected) if reached.issuperset(bad)]
            if not tried:
                continue
            only = set().union(*(affected[n] for n in tried)) & before
            values = self.judge.run_each([changes[n] for n in tried], only)[first]
            for n, value in zip(tried, values, strict=True):
                reached = {p: target for p, target in targets.items() if p in affected[n]}
                if self.judge.met({first: targets[first]}, {first: value}) and self.judge.met(
                    reached, self.judge.run_with(changes[n], affected[n])
                ):
                    yield changes[n]

    def _moved(self, places: Line) -> Values:
        """All that follows from some cells, where 0, 1 and 2 are added to each alone: three options for each."""
        starts = {p: np.where(np.isfinite(self.judge.now(p)[1:]).all(), self.judge.now(p), 0.0) for p in places}
        options = [{p: starts[p] + step} for p in places for step in (0.0, 1.0, 2.0)]
        return self.judge.run_each(options, self.graph.downstream(places))

    def _cell_options(
        self,
        calculation: Turn,
        place: Place,
        targets: Values,
        bad: list[Place],
        moved: Callable[[], Values],
        n: int,
    ) -> Iterator[Values]:
        """The value of one cell that makes all targets right: solved where they are linear in it, or guessed.

        `moved` gives what follows from some cells that are moved, of which it is the one with the number `n`.
        """
        affected, runs = self.graph.downstream([place]), moved()
        now = runs[place][3 * n]
        wanted, steepest, linear = np.array(now), np.full(SAMPLES, 1e-9), True
        for target, value in targets.items():
            if target not in affected:
                continue
            f0, f1, f2 = runs[target][3 * n : 3 * n + 3]
            slope = f1 - f0
            linear &= bool(np.isfinite(slope[1:]).all()) and same(f2 - f1, slope, 1e-7)
            if target in bad:
                steeper = np.abs(slope) > steepest
                wanted = np.where(steeper, now + (value - f0) / np.where(steeper, slope, 1), wanted)
                steepest = np.maximum(steepest, np.abs(slope))
        wanted[0] = np.nan if steepest[0] < 1e-8 else wanted[0]
        options = [wanted] if linear and steepest.max() > 1e-9 else self._plausible(calculation, place)
        yield from islice(self._tried(({place: value} for value in options), targets, bad), 1)

    def _plausible(self, calculation: Turn, place: Place) -> Iterator[np.ndarray]:
        """Values to try in a cell on which results depend nonlinearly: an angle, a repaired formula."""
        if place in self.found.turning:
            for a in calculation.radians.T:
                yield from (a, -a, np.rad2deg(a), -np.rad2deg(a), a / 2)
        if place in self.found.constants:
            yield from (np.full(SAMPLES, factor) for factor in CONVERSIONS)
        seen = [self.judge.now(place)]
        changed = edits(self.graph, place) if place in self.graph.trees else ()
        held = self.graph.parts_at(self.graph.tree(place), self.judge.values)
        for *_, tree in changed:
            value = at_samples(self.graph.cell(place, self.judge.values, tree, held))
            if np.isfinite(value[1:]).all() and not any(same(value, s) for s in seen):
                seen.append(value)
                yield value
            if len(seen) > 60:
                break
        yield from (sign * entry for entry in calculation.scalars() for sign in (1, -1))


def batched(options: Iterable[Each], size: int) -> Iterator[tuple[Each, ...]]:
    """Yield so many options at a time, one lot after the other."""
    left = iter(options)
    while batch := tuple(islice(left, size)):
        yield batch
