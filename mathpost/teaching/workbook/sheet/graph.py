"""A workbook as one graph of functions: what all cells are at many inputs at once."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from functools import cached_property, partial
from typing import TYPE_CHECKING

import numpy as np

from mathpost.teaching.workbook.sheet.evaluate import COMPARISONS, CONDITIONS, FUNCTIONS, code, evaluate
from mathpost.teaching.workbook.sheet.file import EMPTY
from mathpost.teaching.workbook.sheet.formula import NotUnderstood
from mathpost.teaching.workbook.sheet.links import Links
from mathpost.teaching.workbook.sheet.samples import SAMPLES, at, at_samples
from mathpost.teaching.workbook.sheet.tree import copied, exact, parts_of, unrounded

if TYPE_CHECKING:
    from mathpost.teaching.workbook.sheet.formula import Area, Tree
    from mathpost.teaching.workbook.sheet.place import Place
    from mathpost.teaching.workbook.sheet.samples import Values

SIX_DIGITS = 1e-6  # relative
ZERO = np.zeros(1)
NOTHING = np.full(1, np.nan)


class Graph(Links):
    """The formulas of a workbook as functions: `run` evaluates them at many inputs at once.

    A value has the shape (samples,), or (1,) where it is the same at all of them.
    `functions` are those that are known.
    """

    functions: Mapping[str, Callable] = FUNCTIONS

    def run(
        self,
        given: Values,
        base: Values | None = None,
        only: Collection[Place] | None = None,
        put: Mapping[Place, tuple[np.ndarray, np.ndarray]] | None = None,
    ) -> Values:
        """Evaluate the formulas, all or `only` some: place → array of shape (samples,).

        `given` has values in place of the file's, of typed numbers and of formulas; `base` is an earlier run, of
        which the places not in `only` are kept; `put` has the places that hold something else at some samples: at
        which, and what.
        """
        values, arrays, order = {**(base or {}), **given}, {}, self.order
        if only is not None and 8 * len(only) < len(order):
            order = sorted((p for p in only if p in self.trees), key=lambda place: self._position[place])
        for place in order:
            if place in given or (only is not None and place not in only):
                continue
            self.work += 1
            tree, index = self.trees[place], self.part.get(place)
            if index is None:
                values[place] = self.calculate(tree, values)[:, 0, 0]
            else:
                key = id(tree), self.cells[place].anchor
                if key not in arrays:
                    arrays[key] = self.calculate(tree, values)
                values[place] = at(arrays[key], index)
            if put and place in put:
                where, other = put[place]
                values[place] = np.where(where, other, values[place])
        return values

    def run_each(self, options: Sequence[Values], given: Values, base: Values, only: Collection[Place]) -> Values:
        """Evaluate `only` some formulas for each of some options, place → values, in one pass: side by side.

        Returns place → array of shape (options, samples), of those and of what the options hold. `given` and `base`
        are as in `run`.
        """
        size = len(options) * SAMPLES
        put: dict[Place, tuple[np.ndarray, np.ndarray]] = {}
        for n, option in enumerate(options):
            for place, value in option.items():
                where, held = put.setdefault(place, (np.zeros(size, bool), np.zeros(size)))
                where[n * SAMPLES : (n + 1) * SAMPLES] = True
                held[n * SAMPLES : (n + 1) * SAMPLES] = value
        used = {source for place in only for source in self.uses.get(place, ())}
        wide = {
            place: np.tile(at_samples(base[place] if place not in given else given[place]), len(options))
            for place in {*used, *only, *put}
            if place in given or place in base
        }
        fixed = {place: wide[place] for place in wide if place in given}
        for place in put:
            if place in given or place not in self.trees:
                where, held = put[place]
                fixed[place] = np.where(where, held, wide.get(place, self.constants.get(place, ZERO)))
        found = self.run(fixed, wide, only, put=put)
        places = (place for place in {*only, *put} if place in found)
        return {place: np.broadcast_to(found[place], size).reshape(-1, SAMPLES) for place in places}

    @cached_property
    def own(self) -> dict[Place, float | None]:
        """Place → its number, or the one that its formula gives with the file's inputs; None for text."""
        return self.meant | {place: float(values[0]) for place, values in self.run({}).items()}

    def number(self, place: Place) -> float:
        """Return the number that `own` has of a place, NaN for a text."""
        found = self.own[place]
        return np.nan if found is None else found

    @cached_property
    def errors(self) -> set[Place]:
        """The places that show an error such as #DIV/0!, typed, stored or at the sheet's own inputs.

        And texts that a formula gives which gives numbers elsewhere.
        """
        shown = self.trees.keys() - self.downstream(self.not_evaluated)
        no_number = {p for p in shown if (own := self.own.get(p)) is not None and not np.isfinite(own)}
        forms = {self.form(p) for p in self.trees.keys() - self.messages}
        texts = {p for p in self.messages & self.trees.keys() if self.cells[p].value and self.form(p) in forms}
        return {p for p, cell in self.cells.items() if cell.error} | no_number - self.messages | texts

    def cell(
        self,
        place: Place,
        values: Values,
        tree: Tree | None = None,
        held: Mapping[int, np.ndarray] | tuple[()] = (),
    ) -> np.ndarray:
        """What the formula of a cell gives, or `tree` in its place: shape (samples,) or (1,)."""
        return at(self.calculate(tree or self.trees[place], values, held=held), self.part.get(place, (0, 0)))

    def calculate(
        self,
        tree: Tree,
        values: Values,
        held: Mapping[int, np.ndarray] | tuple[()] = (),
    ) -> np.ndarray:
        """Return the value of a tree, shape (samples, rows, columns), from those of the cells; NaN if none."""
        try:
            with np.errstate(all="ignore"):
                return evaluate(tree, partial(self.look, values=values), self.functions, held)
        except NotUnderstood:
            return np.full((1, 1, 1), np.nan)

    def parts_at(self, tree: Tree, values: Values) -> dict[int, np.ndarray]:
        """The values of all parts of a tree, by their identity, for formulas that share most parts with it."""
        held: dict[int, np.ndarray] = {}
        for part in [*parts_of(tree)][::-1]:
            with suppress(NotUnderstood):
                held[id(part)] = evaluate(part, partial(self.look, values=values), self.functions, held)
        return held

    def look(self, area: Area, values: Values, take: str = "") -> np.ndarray:
        """The values of an area, shape (samples, rows, columns): 0 for an empty cell, NaN for text.

        `take` says where empty cells and texts are otherwise (see `evaluate.TAKES`); where they are left out, the
        others are in one row.
        """
        places, constants = area.places, self.constants
        if take == "with texts":
            coded = [np.full(1, code(self.cells[p].value)) if p in self.texts else
                     values[p] if p in values else constants.get(p, NOTHING) for p in places]  # fmt: skip
            return self._stacked(coded, area.shape)
        if len(places) == 1 and not take:
            (place,) = places
            return (values[place] if place in values else constants.get(place, ZERO))[:, None, None]
        numbers = [values[p] if p in values else constants.get(p, ZERO) for p in places]
        if not take:
            return self._stacked(numbers, area.shape)
        leaves_out, other = take.startswith("left out"), ZERO if take == "as 0" else NOTHING
        found = []
        for place, number in zip(places, numbers, strict=True):
            if self._is_none(place, values):
                found += [other] * (not leaves_out)
            elif take != "left out, TRUE is 1" and self._is_truth(place):
                found.append(NOTHING)
            else:
                found.append(number)
        return self._stacked(found, (1, len(found)) if leaves_out else area.shape)

    def _is_none(self, place: Place, values: Values) -> bool:
        """Whether a cell is empty or holds a text."""
        if place in values:
            return place in self.messages and bool(np.isnan(values[place]).all())
        return place in self.texts or place not in self.constants

    def _is_truth(self, place: Place) -> bool:
        """Whether a cell holds TRUE or FALSE, which one program counts as a number and the other does not."""
        is_typed = isinstance(self.cells.get(place, EMPTY).value, bool)
        return is_typed or self.tree(place)[0] in {*COMPARISONS, *CONDITIONS}

    @staticmethod
    def _stacked(numbers: list[np.ndarray], shape: tuple[int, int]) -> np.ndarray:
        """Values of several cells as one array, shape (samples, rows, columns)."""
        if not numbers:
            return np.zeros((1, *shape))
        found = np.empty((max(map(len, numbers)), len(numbers)), max(n.dtype for n in numbers))
        for k, number in enumerate(numbers):
            found[:, k] = number
        return found.reshape(len(found), *shape)

    @cached_property
    def constants(self) -> Values:
        """Place of a cell that is not calculated → what it counts for in arithmetic, shape (1,), NaN for text."""
        held = {p: None if p in self.trees else self.cells[p].counts for p in self.meant}
        empty = {p for p, cell in self.cells.items() if cell.value is None and not cell.formula}
        return {p: np.full(1, np.nan if n is None else n) for p, n in held.items() if p not in empty}

    # What is written differently from what is meant.

    def unround(self) -> None:
        """Take the rounding off what is only shown, by cells that none uses but for a message: it is no slip.

        Nor is a π of six digits.
        """
        own = self.own  # of the formulas as the file has them
        precise = {id(tree): exact(tree, SIX_DIGITS) for tree in self.trees.values()}
        self.trees = {place: precise[id(tree)] for place, tree in self.trees.items()}
        for place in self.trees.keys() & own.keys() - self.part.keys():
            if self.messages.issuperset(self.used.get(place, ())):
                self.trees[place] = unrounded(self.trees[place])

    def take_unrounded(self, places: Collection[Place], before: Iterable[Place] = ()) -> None:
        """Take results as they are before they are rounded, if most are; and what they are copies of."""
        own = self.own  # of the formulas as they are
        rounded = {p: tree for p in places if p in own and (tree := unrounded(self.tree(p))) != self.tree(p)}
        self.trees |= rounded if 2 * len(rounded) > len(places) else {}
        before = {*before, *places}
        if sources := [p for place in places for p in copied(self.tree(place)) if p not in before]:
            self.take_unrounded(dict.fromkeys(sources), before)

    def cut_off(self) -> Iterator[tuple[list[Place], tuple[int, int]]]:
        """Yield the cells of array formulas that give more rows or columns than there are cells, and how many."""
        values = self.run({}) if self.part else {}
        for anchor in dict.fromkeys((p[0], *self.cells[p].anchor) for p in self.part):
            cells = sorted(self.array(anchor))
            shape = self.calculate(self.tree(anchor), values).shape[1:]
            if any(size > len({p[n] for p in cells}) for n, size in enumerate(shape, 1)):
                yield cells, shape
