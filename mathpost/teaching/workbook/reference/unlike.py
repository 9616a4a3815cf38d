"""The one part in which a formula of a hand-in is unlike a formula of the reference.

Two parts are alike if they have the same values at all samples, whatever cells they use. Sums and products are
compared term by term, in any order. What is unlike is written with the cells of the hand-in.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from mathpost.teaching.workbook.reference.quantities import NOTHING, Sheet, agree
from mathpost.teaching.workbook.sheet.formula import Area, Tree, area_of
from mathpost.teaching.workbook.sheet.place import Place
from mathpost.teaching.workbook.sheet.samples import SAMPLES, Values
from mathpost.teaching.workbook.sheet.tree import areas, parts_of, put

if TYPE_CHECKING:
    from mathpost.teaching.workbook.reference.results import Comparison

ROUGHLY = 1e-6
CHAINS = {"+": ("+", "-"), "-": ("+", "-"), "*": ("*", "/"), "/": ("*", "/")}
Path = tuple[int, ...]
Pair = tuple[Path, Tree, Tree]  # where, what is there, what the reference has


class Unlike:
    """Formulas of a hand-in beside those of a reference."""

    def __init__(self, comparison: Comparison) -> None:
        self.comparison = comparison
        self.values: dict[int, np.ndarray] = {}  # of parts of formulas, by identity
        self.last: dict[int, float] = {}  # of these the last number
        self.kept: list[Tree] = []  # as long as these are kept, no other has their identity

    def corrected(self, place: Place) -> Iterator[tuple[Tree, Tree, Tree]]:
        """Yield (part, what it should be, whole) for the formula of a cell, by each formula of the reference."""
        comparison = self.comparison
        reference, tree = comparison.reference, comparison.handed_in.trees[place]
        self._evaluate(comparison.handed_in, tree, comparison.theirs)
        seen = set()
        for ours in dict.fromkeys(reference.trees[p] for p in reference.order if p in comparison.ours):
            if ours[0] == "area":
                continue
            self._evaluate(reference, ours, comparison.ours)
            for path, old, new in self._unlike(tree, ours, ()):
                if (there := self._here(old, new, place)) is not None and there != old:
                    whole = put(tree, path, there)
                    if whole not in seen:
                        seen.add(whole)
                        yield old, there, whole

    def _evaluate(self, sheet: Sheet, tree: Tree, values: Values) -> None:
        """Keep what all parts of a formula are at the samples, shape (cells, samples)."""
        if id(tree) not in self.values:
            self.kept.append(tree)
            for key, value in sheet.parts_at(tree, values).items():
                self.values[key] = np.broadcast_to(value.reshape(len(value), -1), (SAMPLES, value[0].size)).T
                self.last[key] = float(self.values[key][-1, -1]) if value[0].size else 0.0

    def _alike(self, a: Tree, b: Tree) -> bool:
        x, y = self.last.get(id(a)), self.last.get(id(b))
        if x is None or y is None:
            return a == b
        if not abs(x - y) <= ROUGHLY * (abs(x) + abs(y)) + NOTHING:  # most that differ do here, and it costs least
            return False
        first, second = self.values[id(a)], self.values[id(b)]
        return first.shape == second.shape and bool(agree(first, second).all())

    def _unlike(self, a: Tree, b: Tree, path: Path) -> list[Pair]:
        """The part of `a` that is unlike `b`; nothing if they are alike, or if more than one is."""
        if self._alike(a, b):
            return []
        if a[0] in CHAINS and CHAINS[a[0]] == CHAINS.get(b[0]):
            return self._unlike_terms(a, b, path)
        if {a[0], b[0]} <= {"area", "number"}:
            return [(path, a, b)] if path else []
        if a[0] == b[0] and len(a) == len(b):
            parts = [(n, x, y) for n, (x, y) in enumerate(zip(a, b, strict=True)) if n and not self._alike(x, y)]
            if len(parts) == 1:
                (n, x, y), *_ = parts
                return self._unlike(x, y, (*path, n))
            if len(parts) == 2 and self._alike(parts[0][1], parts[1][2]) and self._alike(parts[1][1], parts[0][2]):
                n, m = parts[0][0], parts[1][0]
                return [(path, a, ("here", put(put(a, (n,), a[m]), (m,), a[n])))]
        if len(a) == len(b) and a[1:] and all(map(self._alike, a[1:], b[1:])):
            return [(path, a, ("here", (b[0], *a[1:])))]
        if inner := [part for part in parts_of(a) if self._alike(part, b)]:
            return [(path, a, ("here", inner[0]))]
        held = any(self._alike(a, part) for part in parts_of(b))
        return [(path, a, b)] if held else []

    def _unlike_terms(self, a: Tree, b: Tree, path: Path) -> list[Pair]:
        """The same of sums, or of products: a term that differs, is missing, or is one too many."""
        add, take = CHAINS[a[0]]
        ours, theirs = [*_terms(b, ())], [*_terms(a, ())]
        for term in [*theirs]:
            same = [t for t in ours if t[0] == term[0] and self._alike(t[2], term[2])]
            if same:
                ours.remove(same[0])
                theirs.remove(term)
        if (len(theirs), len(ours)) == (1, 1):
            (sign, where, x), (other, _, y) = theirs[0], ours[0]
            if sign == other:
                return self._unlike(x, y, (*path, *where))
            if self._alike(x, y) and where and where[-1] == 2:
                node = _at(a, where[:-1])
                return [((*path, *where[:-1]), node, ("here", ({add: take, take: add}[node[0]], *node[1:])))]
        if (len(theirs), len(ours)) == (0, 1):
            sign, _, y = ours[0]
            return [(path, a, (take if sign else add, ("here", a), y))]
        if (len(theirs), len(ours)) == (1, 0) and (where := theirs[0][1]):
            node = _at(a, where[:-1])
            if where[-1] == 2 or node[0] == add:
                return [((*path, *where[:-1]), node, ("here", node[3 - where[-1]]))]
        return []

    # The same in the cells of the hand-in.

    def _here(self, old: Tree, new: Tree, place: Place) -> Tree | None:
        """A part of a formula of the reference, in the cells of the hand-in; None if a cell is missing there."""
        if new[0] == "here":
            return new[1]
        if new[0] in ("number", "text"):
            return new
        if new != old and old[0] != "number" and self._alike(old, new):
            return old
        if new[0] == "area":
            return self._area_here(new[1], place)
        parts = [self._here(old, part, place) for part in new[1:]]
        return None if None in parts else (new[0], *parts)

    def _area_here(self, area: Area, place: Place) -> Tree | None:
        comparison = self.comparison
        sheet, own = comparison.handed_in, areas(comparison.handed_in.trees[place])
        used = {p for each in own for p in each.places}
        cells = []
        for there in area.places:
            known = comparison.matched.cells.get(there) or comparison.index.find(
                comparison.ours.get(there, np.full(1, np.nan))
            )
            known = sorted(known, key=lambda p: (p not in used, sheet.calculation_order(p)))
            if not known:
                return self._typed(area)
            cells.append(known[0])
        found = area_of([cells[0], cells[-1]])
        if found.places != cells:
            return None
        same = [each for each in own if each.places == cells]
        fixed = cells[0][1] != place[1], cells[0][2] != place[2]
        return "area", same[0] if same else replace(found, fixed=fixed)

    def _typed(self, area: Area) -> Tree | None:
        """A number of the reference that the hand-in has in no cell."""
        number = self.comparison.reference.numbers_typed.get(area.places[0])
        return ("number", number) if area.shape == (1, 1) and number is not None else None


def _terms(tree: Tree, path: Path, sign: bool = False) -> Iterator[tuple[bool, Path, Tree]]:
    """Yield the terms of a sum or the factors of a product: whether it is taken off, where, and what it is."""
    kind = CHAINS[tree[0]]
    for n, part in enumerate(tree[1:], 1):
        other = sign ^ (n == 2 and tree[0] == kind[1])
        if CHAINS.get(part[0]) == kind:
            yield from _terms(part, (*path, n), other)
        else:
            yield other, (*path, n), part


def _at(tree: Tree, path: Path) -> Tree:
    for n in path:
        tree = tree[n]
    return tree
