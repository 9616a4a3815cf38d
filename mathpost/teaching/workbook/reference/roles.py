"""Inputs found by what they do: a student's own numbers, in any language and any order.

All inputs that are not known yet are set to the same number, here and there. A step that is the same function then
has the same value in both workbooks, whichever input is which. Let one of them vary, and the step shows which role
this input has in it. An input here is the one there that has its roles; of several that have the same, as those in
the rows of a table, the first is the first. What was found so is tried: at random numbers a step that depends on it
must be the same in both.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from mathpost.teaching.workbook.reference.quantities import Dictionary, Sheet, parts_as_quantities
from mathpost.teaching.workbook.sheet.place import Place
from mathpost.teaching.workbook.sheet.samples import SAMPLES, Values, at_samples
from mathpost.teaching.workbook.sheet.tree import areas

LEVELS = (0.43, 1.7, 23.0, 0.37, 29.0)  # what all inputs are set to, one after the other: one suits an arcsine
SPREAD = np.array([0, 0, 0, 0.1, 0.1])[
    :, None
]  # relative, within a list, whose deviation would be 0 if all are equal
VARIED = 1.37  # times that is the input whose role is asked for
MOST_INPUTS = 150
LONG = 3  # numbers that are a list
CLEARLY = 1.2  # times as much as what tells for any other
ORDER = 1e-6  # of the score: which of equal inputs is which, if nothing else tells

Role = tuple[int, str, str]  # the level; a quantity with all inputs equal, and with this one varied


@dataclass
class Inputs:
    """The inputs of one workbook that are not known yet, and its quantities as functions of them."""

    sheet: Sheet
    places: Sequence[Place]
    known: Values

    def less(self, known: Values) -> Inputs:
        """Those that are left when some more are known."""
        return Inputs(self.sheet, [p for p in self.places if p not in known], {**self.known, **known})

    def quantities(self, given: Values) -> list[np.ndarray]:
        """All formulas and their parts, at samples of the inputs."""
        values = self.sheet.run({**self.known, **given})
        formulas = [p for p in self.sheet.order if p not in self.sheet.messages]
        parts = parts_as_quantities(self.sheet, values, formulas)
        return [*(values[p] for p in formulas), *(value for _, value in parts)]

    @cached_property
    def _varied(self) -> list[np.ndarray]:
        """Each quantity with all inputs equal, then with one after the other varied, shape (levels, 1 + inputs)."""
        at = np.repeat(np.array(LEVELS)[:, None], len(self.places) + 1, axis=1)
        given, spread = {}, self._spread()
        for n, place in enumerate(self.places, 1):
            varied = at * (1 + SPREAD * spread.get(place, 0.0))
            varied[:, n] *= VARIED
            given[place] = varied.ravel()
        return [np.broadcast_to(value, at.size).reshape(at.shape) for value in self.quantities(given)]

    def _spread(self) -> dict[Place, float]:
        """Between 0 and 1, by its place in the longest list that a formula takes as one."""
        lists = {tuple(area.places) for tree in self.sheet.trees.values() for area in areas(tree)}
        ordered = sorted((each for each in lists if len(each) >= LONG), key=lambda each: (len(each), each))
        return {p: 0.618 * n % 1 for places in ordered for n, p in enumerate(places, 1)}

    @cached_property
    def depends(self) -> list[set[Place]]:
        """The inputs on which each quantity depends."""
        return [{self.places[n] for n in _moved(value)} for value in self._varied]

    @cached_property
    def roles(self) -> list[set[Role]]:
        """The roles of each input."""
        found: list[set[Role]] = [set() for _ in self.places]
        for value in self._varied:
            for n in _moved(value):
                found[n] |= {(k, f"{row[0]:.6e}", f"{row[n + 1]:.6e}") for k, row in enumerate(value)}
        return found


def _moved(value: np.ndarray) -> list[int]:
    """The numbers of the inputs on which a quantity depends."""
    off = np.abs(value - value[:, :1]) > 1e-9 * np.abs(value).max(axis=1)[:, None]  # false where there is no number
    return (np.flatnonzero(off.any(axis=0)) - 1).tolist()


def by_role(
    reference: Inputs, handed_in: Inputs, likeness: Callable[[Place, Place], float]
) -> list[tuple[Place, Place]]:
    """Return the inputs of a reference that do what some of a hand-in do: (of the reference, of the hand-in)."""
    ours, theirs, found = reference, handed_in, []
    while ours.places and theirs.places and max(len(ours.places), len(theirs.places)) <= MOST_INPUTS:
        score = _scores(ours, theirs, likeness)
        pairs = [*_clear(score)]
        if is_last := not pairs:
            from scipy.optimize import linear_sum_assignment  # slow to import

            pairs = [
                (int(i), int(j)) for i, j in zip(*linear_sum_assignment(-score), strict=True) if score[i, j] > 0
            ]
        new = [(ours.places[i], theirs.places[j]) for i, j in pairs]
        found += new
        if is_last:
            break
        numbers = {place: np.full(1, reference.sheet.numbers_typed[place]) for place, _ in new}
        ours = ours.less(numbers)
        theirs = theirs.less({cell: numbers[place] for place, cell in new})
    sure = _tried(reference, handed_in, found)
    return [pair for pair in found if pair in sure]


def _scores(ours: Inputs, theirs: Inputs, likeness: Callable[[Place, Place], float]) -> np.ndarray:
    """How much tells that an input of the one, a row, is one of the other, a column."""
    here, there = (Counter(role for each in roles for role in each) for roles in (ours.roles, theirs.roles))
    score = np.zeros((len(ours.places), len(theirs.places)))
    for i, own in enumerate(ours.roles):
        for j, other in enumerate(theirs.roles):
            if shared := sum(1 / (here[role] * there[role]) for role in sorted(own & other)) / len(LEVELS):
                apart = (i / len(ours.places) - j / len(theirs.places)) ** 2
                score[i, j] = shared + 0.1 * likeness(ours.places[i], theirs.places[j]) - ORDER * apart
    return score


def _clear(score: np.ndarray) -> Iterator[tuple[int, int]]:
    """The pairs that are clearly better than any other of the row and of the column."""
    for i, row in enumerate(score):
        j = int(row.argmax())
        others = [*np.delete(row, j), *np.delete(score[:, j], i)]
        if score[i, j] > CLEARLY * max(others, default=0.0):
            yield i, j


def _tried(reference: Inputs, handed_in: Inputs, pairs: Sequence[tuple[Place, Place]]) -> set[tuple[Place, Place]]:
    """The pairs on which a step depends that is the same in both workbooks at random numbers."""
    rng, numbers = np.random.default_rng(0), reference.sheet.numbers_typed
    ours = {place: numbers[place] * rng.uniform(0.9, 1.1, SAMPLES) for place, _ in pairs}
    known = Dictionary(enumerate(reference.quantities(ours)))
    partner, sure = dict(pairs), set()
    steps = handed_in.quantities({cell: ours[place] for place, cell in pairs})
    for value, depends in zip(steps, handed_in.depends, strict=True):
        for n in known.find(at_samples(value)) if depends else ():
            sure |= {(p, partner[p]) for p in reference.depends[n] if partner.get(p) in depends}
    return sure
