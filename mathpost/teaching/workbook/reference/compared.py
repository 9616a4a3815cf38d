"""A reference and a hand-in at the same samples of their inputs."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import product

import numpy as np

from mathpost.teaching.workbook.reference.forks import selectors
from mathpost.teaching.workbook.reference.matched import Matched
from mathpost.teaching.workbook.reference.quantities import (
    Dictionary,
    Sheet,
    agree,
    parts_as_quantities,
    plain,
    sampled,
)
from mathpost.teaching.workbook.sheet.place import Place
from mathpost.teaching.workbook.sheet.samples import Values, at_samples

REACHES = (0.25, 0.05, 0.01)  # relative: how far the samples are from the numbers of the sheets
MOST_TRIES = 16_000  # changes of a cell that are looked at in one hand-in


@dataclass
class Samples:
    """Two workbooks at the same samples: `ours` are the values of the reference, `theirs` those of the hand-in.

    `asked` are the results of the reference; `told` says where the hand-in has some of them; `steps_too`
    whether steps of the reference are asked for, too, which the hand-in has as results.
    """

    reference: Sheet
    asked: Sequence[Place]
    handed_in: Sheet
    matched: Matched
    told: Mapping[Place, Place] = field(default_factory=dict)
    steps_too: bool = False

    def __post_init__(self) -> None:
        own, other, factor = self.reference.numbers_typed, self.handed_in.numbers_typed, self.matched.factor
        numbers = {place: own[place] for place in self.matched.cells}
        theirs = {p: other[cells[0]] / factor.get(p, 1.0) for p, cells in self.matched.cells.items()}
        self.tries = MOST_TRIES
        self.fixed: Values = {}  # cells of the hand-in that hold a number where something else belongs
        whole = {place for place, number in numbers.items() if number == int(number)}
        back, chosen = self.matched.back, selectors(self.handed_in)
        self.selectors = selectors(self.reference) | {back[cell] for cell in chosen if cell in back}
        for hold, reach in product((self.selectors, whole | self.selectors), REACHES):
            samples = sampled(numbers, theirs, reach)
            self.given = {p: np.full_like(v, numbers[p]) if p in hold else v for p, v in samples.items()}
            self.ours = self.reference.run(self.given)
            if all(np.isfinite(self.ours[place]).all() for place in self.asked):
                break
        self.run()
        self.asked = [*self.asked, *(self._also_named() if self.steps_too else ())]

    def _also_named(self) -> list[Place]:
        """The steps of the reference that the hand-in has as results, by their whole labels."""
        ends, asked = {*self.handed_in.ends()}, {*self.asked}
        here: dict[str, list[Place]] = {}
        there: dict[str, list[Place]] = {}
        for sheet, found in ((self.reference, here), (self.handed_in, there)):
            for place, labels in sheet.labels.items():
                texts = texts_of(labels) if sheet is self.reference else [t.casefold() for t in labels if t]
                for text in dict.fromkeys(texts):
                    found.setdefault(text, []).append(place)
        named: dict[Place, None] = {}
        for text, places in here.items():
            cells = there.get(text, [])
            is_one = asked.isdisjoint(places) and len({self.reference.form(p) for p in places}) == 1
            if (
                is_one
                and self.reference.trees.keys() >= {*places}
                and len(cells) == len(places)
                and ends >= {*cells}
                and not any(map(self._is_another, cells))
            ):
                named |= dict.fromkeys(places)
        return [p for p in named if p not in self.reference.messages and np.isfinite(self.ours[p]).all()]

    def run(self) -> None:
        """Evaluate the hand-in, as its formulas are now."""
        factor = self.matched.factor
        self.put = {
            cell: self.given[place] * factor.get(place, 1.0)
            for place, cells in self.matched.cells.items()
            for cell in cells
        } | self.fixed
        self.theirs = self.handed_in.run(self.put)
        formulas = [p for p in self.handed_in.order if p not in self.handed_in.messages]
        self.index = Dictionary((p, self.theirs[p]) for p in formulas)
        self.ends = self.handed_in.ends()

    @cached_property
    def known(self) -> Dictionary:
        """The quantities of the reference: its cells, the parts of its formulas, and its numbers."""
        formulas = [p for p in self.reference.order if p not in self.reference.messages]
        cells = [(p, self.ours[p]) for p in [*self.given, *formulas] if p in self.ours]
        return Dictionary([*cells, *parts_as_quantities(self.reference, self.ours, formulas)])

    @cached_property
    def steps(self) -> Dictionary:
        """The formulas of the reference."""
        reference = self.reference
        return Dictionary((p, self.ours[p]) for p in reference.order if p not in reference.messages)

    @cached_property
    def is_template(self) -> bool:
        """Whether the hand-in is laid out as the reference: the labels are the same, and some of the formulas."""
        both = [p for p in self.handed_in.order if p in self.reference.trees and p in self.ours]
        both = [p for p in both if self.handed_in.labels.get(p) == self.reference.labels.get(p)]
        alike = sum(bool(agree(at_samples(self.theirs[p]), at_samples(self.ours[p]))) for p in both)
        return 2 * len(both) > len(self.reference.trees) and 4 * alike >= len(both) and alike > 1

    def varies(self, place: Place) -> bool:
        """Whether a result of the reference depends on an input that is varied."""
        return not self.reference.upstream([place]).isdisjoint(self.given)

    @cached_property
    def meant(self) -> dict[Place, Place]:
        """Cell of the hand-in → the cell of the reference with its label, or that place among those with it."""
        here, there = (_by_label(sheet) for sheet in (self.reference, self.handed_in))
        found: dict[Place, Place] = {}
        for text, places in there.items():
            if len(here.get(text, ())) == len(places):
                found = {**dict(zip(places, here[text], strict=True)), **found}
        return found

    def expected(self, cell: Place) -> np.ndarray | None:
        """What the label of a cell of the hand-in says that it is."""
        meant = self.meant.get(cell)
        return at_samples(self.ours[meant]) if meant in self.ours else None

    def same(self, result: Place, cell: Place) -> bool:
        """Whether a cell of the hand-in is a result of the reference."""
        value = self.theirs.get(cell)
        if value is None:
            number = self.handed_in.value(cell)
            value = np.full(1, np.nan if number is None else number)
        value, wanted = at_samples(value), at_samples(self.ours[result])
        return bool(np.isfinite(value).all()) and bool(agree(value, wanted))

    def _is_another(self, cell: Place) -> bool:
        """Whether a cell is the only one that is some quantity of the reference."""
        value = self.theirs.get(cell)
        return value is not None and value in self.steps and self.index.find(value) == [cell]

    def nearest(self, cell: Place, results: Sequence[Place]) -> list[Place]:
        """Some quantities of the reference, first those that are nearest to a cell of the hand-in."""
        value = at_samples(self.theirs[cell])[0]
        return sorted(results, key=lambda p: abs(np.log(np.abs(at_samples(self.ours[p])[0] / value) + 1e-12)))

    @cached_property
    def known_cells(self) -> set[Place]:
        """The formulas of the hand-in, as it was handed in, that are quantities of the reference."""
        return {p for p in self.handed_in.order if p in self.theirs and self.theirs[p] in self.known}


def _by_label(sheet: Sheet) -> dict[str, list[Place]]:
    """Label, with its unit first, then without → the cells that have it, in order, if these are of one formula."""
    found: dict[str, list[Place]] = defaultdict(list)
    for place, labels in sheet.labels.items():
        for text in texts_of(labels):
            found[text].append(place)
    return {text: places for text, places in found.items() if len({sheet.form(p) for p in places}) == 1}


def texts_of(labels: Sequence[str]) -> list[str]:
    """The labels of a cell, first as they are, then without their units."""
    return [t for t in dict.fromkeys([*(label.casefold() for label in labels), *map(plain, labels)]) if t]
