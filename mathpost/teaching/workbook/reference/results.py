"""The results of a reference found in a hand-in: by what they are as functions, and where they should stand."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import product

import numpy as np

from mathpost.teaching.workbook.reference.branches import FROM, Telling
from mathpost.teaching.workbook.reference.forks import selectors
from mathpost.teaching.workbook.reference.inputs import Matched
from mathpost.teaching.workbook.reference.quantities import (
    Dictionary,
    Sheet,
    agree,
    likeness,
    parts_as_quantities,
    plain,
    sampled,
)
from mathpost.teaching.workbook.reference.unlike import Unlike
from mathpost.teaching.workbook.sheet.place import Place, number_along
from mathpost.teaching.workbook.sheet.samples import SAMPLES, Values, at_samples

REACHES = (0.25, 0.05, 0.01)  # relative: how far the samples are from the numbers of the sheets
FUZZY = 0.5  # likeness of labels of which one may name the other's quantity
MOST_TRIES = 16_000  # changes of a cell that are looked at in one hand-in
MOST_TOLD = 4  # samples at which a result is told to differ
MOST = 8  # cells that are tried in place of a result that is missing


@dataclass
class Comparison:
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

    def look_at(self, telling: Sequence[Telling]) -> None:
        """Put inputs at which results differ among the samples, and say which cells the results are."""
        samples = [dict(each) for each in dict.fromkeys(tuple(t.given.items()) for t in telling)][:MOST_TOLD]
        self.given = {p: at_samples(v).copy() for p, v in self.given.items()}
        for n, sample in enumerate(samples, SAMPLES - len(samples)):
            for place, values in self.given.items():
                values[n] = sample.get(place, values[FROM])
        self.told = {**self.told, **{t.result: self.found[t.result] for t in telling if dict(t.given) in samples}}
        self.ours = self.reference.run(self.given)
        for name in ("known", "steps", "known_cells", "unlike"):
            self.__dict__.pop(name, None)
        self.run()

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
    def unlike(self) -> Unlike:
        """The formulas of the hand-in beside those of the reference."""
        return Unlike(self)

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

    # Where a result should stand.

    @cached_property
    def _named(self) -> dict[str, list[Place]]:
        """Label → the cells of the hand-in that it names: formulas, and numbers that are no inputs."""
        found: dict[str, list[Place]] = defaultdict(list)
        back = self.matched.back
        for place, labels in self.handed_in.labels.items():
            is_number = place in self.handed_in.trees or self.handed_in.value(place) is not None
            if place not in back and is_number:
                for text in texts_of(labels):
                    found[text].append(place)
        return found

    @cached_property
    def _labels(self) -> dict[Place, list[str]]:
        """Result → the labels that name it, or the row or column of a pattern that it is in, and nothing else."""
        named: dict[str, list[Place]] = defaultdict(list)
        for place, labels in self.reference.labels.items():
            for text in texts_of(labels):
                named[text].append(place)
        asked = {*self.asked}
        alone = {
            text
            for text, places in named.items()
            if text and asked.issuperset(places) and len({self.reference.form(p) for p in places}) == 1
        }
        return {p: [t for t in texts_of(self.reference.labels.get(p, ())) if t in alone] for p in self.asked}

    def labelled(self, result: Place) -> list[Place]:
        """The cells of the hand-in that have the label of a result, with its unit if any has that."""
        return next((cells for text in self._labels[result] if (cells := self._named.get(text))), [])

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

    def place_results(self) -> None:
        """Fill `found`, result → cell, and `candidates`, missing result → cells that should be it, best first.

        `sure` are the missing ones of which the label or the place says which cell should be it.
        """
        self.found: dict[Place, Place] = {}
        self.candidates: dict[Place, list[Place]] = {}
        self.sure: set[Place] = set()
        ends = {*self.ends}
        missing: list[Place] = []
        for result in self.asked:
            alike = [r for r in self.asked if self._labels[r] == self._labels[result]]
            cells = [self.told[result]] if result in self.told else self.labelled(result)
            taken: set[Place] = set()
            single = len(alike) == 1
            if result in self.reference.shown:  # a text of two, say, is the same in many cells: each is one result
                taken = {*self.found.values()}
                if len(cells) == len(alike):
                    cells = [sorted(cells, key=self.handed_in.reading_order)[alike.index(result)]]
                single = single or len(cells) == 1
            right = [cell for cell in cells if self.same(result, cell) and cell not in taken]
            off = [cell for cell in cells if cell in ends and cell not in right and single]
            if self.index.find(self.ours[result]):  # a short label may be that of something else, which it is
                off = [cell for cell in off if not self._is_another(cell)]
                cells = [cell for cell in cells if cell in right or cell in off or cell not in ends]
            if right and not off:
                self.found[result] = next((cell for cell in right if cell in ends), right[0])
                continue
            if not cells and self.varies(result):
                places = [cell for cell in self.index.find(self.ours[result]) if cell not in taken]
                places.sort(key=lambda p: (p not in ends, self.handed_in.reading_order(p)))
                if places:
                    self.found[result] = places[0]
                    continue
            missing.append(result)
            if off:
                self.candidates[result] = off
                self.sure.add(result)
        taken = {*self.found.values()}
        self._leftover(missing, taken)
        self._in_line(missing, taken)
        self._copies()
        for result in missing:
            if result not in self.candidates:
                self.candidates[result] = self._likely(result, taken)[:MOST]

    def _is_another(self, cell: Place) -> bool:
        """Whether a cell is the only one that is some quantity of the reference."""
        value = self.theirs.get(cell)
        return value is not None and value in self.steps and self.index.find(value) == [cell]

    def _leftover(self, missing: Sequence[Place], taken: set[Place]) -> None:
        """Of the cells of one label those that are no result yet, in their order."""
        groups: dict[tuple[str, ...], list[Place]] = defaultdict(list)
        for result in missing:
            if result in self.told:
                self.candidates[result] = [self.told[result]]
                self.sure.add(result)
            elif result not in self.candidates and self._labels[result]:
                groups[tuple(self._labels[result])].append(result)
        for results in groups.values():
            cells = sorted(
                (c for c in self.labelled(results[0]) if c not in taken), key=self.handed_in.reading_order
            )
            if len(cells) == len(results) or len(results) == 1:
                for n, result in enumerate(results):
                    if own := cells[n : n + 1] if len(results) > 1 else cells[::-1]:
                        self.candidates[result] = own
                        self.sure.add(result)

    def _in_line(self, missing: Sequence[Place], taken: set[Place]) -> None:
        """Of a row or column in which most of a pattern were found, the cells that are left."""
        by_form: dict[str | None, list[Place]] = defaultdict(list)
        for result in self.asked:
            by_form[self.reference.form(result)].append(result)
        for results in by_form.values():
            here = [self.found[r] for r in results if r in self.found]
            gone = [r for r in results if r in missing and r not in self.candidates]
            for along in (2, 1):
                if len(here) > 1 and gone and len({(p[0], number_along(p, along)) for p in here}) == 1:
                    sheet, number = here[0][0], number_along(here[0], along)
                    line = [p for p in self.handed_in.labels if p[0] == sheet and number_along(p, along) == number]
                    first, last = min(here), max(here)
                    free = [p for p in sorted(line) if p not in taken and p not in self.matched.back]
                    inside = [p for p in free if first <= p <= last]
                    free = inside if len(inside) == len(gone) else free
                    if len(free) == len(gone):
                        for result, cell in zip(gone, free, strict=True):
                            self.candidates[result] = [cell]
                            self.sure.add(result)

    def _copies(self) -> None:
        """A list that repeats the results must have each of them, though the right one stands elsewhere."""
        copies = [p for p in self.ends if self.handed_in.tree(p)[0] == "area" and p not in self.handed_in.part]
        spare = [p for p in copies if p not in self.found.values()]
        apart = [r for r, cell in self.found.items() if cell not in self.ends and r not in self.told]
        if len(copies) < 2 or not spare or 2 * len(spare) > len(copies):
            return
        for result in apart:
            downstream = self.handed_in.downstream([self.found[result]])
            if downstream.isdisjoint(self.ends) or len(apart) == len(spare) == 1:
                self.candidates[result] = spare
                self.sure.add(result)
                del self.found[result]

    def nearest(self, cell: Place, results: Sequence[Place]) -> list[Place]:
        """Some quantities of the reference, first those that are nearest to a cell of the hand-in."""
        value = at_samples(self.theirs[cell])[0]
        return sorted(results, key=lambda p: abs(np.log(np.abs(at_samples(self.ours[p])[0] / value) + 1e-12)))

    def _likely(self, result: Place, taken: set[Place]) -> list[Place]:
        """The cells that may be a result: by a similar label, by the nearest value, as the last of a chain."""
        labels = self.reference.labels.get(result, ("", ""))
        wanted = at_samples(self.ours[result])[0]
        ends = {*self.ends}
        scores = []
        for cell in self.handed_in.order:
            if cell in taken or cell in self.handed_in.messages or cell in self.known_cells:
                continue
            value = at_samples(self.theirs[cell])[0]
            off = abs(abs(value) - abs(wanted)) / (abs(wanted) + 1e-9) if np.isfinite(value) else 9.0
            score = likeness(labels, self.handed_in.labels.get(cell, ("", "")))
            score = (score if score >= FUZZY else 0.0) + max(0.0, 0.6 - off) + 1.0 * (cell in ends)
            if score > 0.3:
                scores.append((-score, self.handed_in.reading_order(cell), cell))
        return [cell for *_, cell in sorted(scores)]

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
