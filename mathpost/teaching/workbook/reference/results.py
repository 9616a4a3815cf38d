"""The results of a reference found in a hand-in: by what they are as functions, and where they should stand."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from functools import cached_property

import numpy as np

from mathpost.teaching.workbook.reference.compared import Samples, texts_of
from mathpost.teaching.workbook.reference.moved import FROM, Telling
from mathpost.teaching.workbook.reference.quantities import likeness
from mathpost.teaching.workbook.reference.unlike import Unlike
from mathpost.teaching.workbook.sheet.place import Place, number_along
from mathpost.teaching.workbook.sheet.samples import SAMPLES, at_samples

FUZZY = 0.5  # likeness of labels of which one may name the other's quantity
MOST_TOLD = 4  # samples at which a result is told to differ
MOST = 8  # cells that are tried in place of a result that is missing


class Comparison(Samples):
    """Two workbooks at the same samples, and which cells of the hand-in are the results of the reference."""

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

    @cached_property
    def unlike(self) -> Unlike:
        """The formulas of the hand-in beside those of the reference."""
        return Unlike(self)

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
