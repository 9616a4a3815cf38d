"""Inputs that are moved, and both workbooks along the way."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from mathpost.teaching.workbook.reference.quantities import Sheet
from mathpost.teaching.workbook.sheet.place import Place
from mathpost.teaching.workbook.sheet.samples import Values

STEPS = 20  # to where a condition changes
FROM = 1  # the sample from which inputs are moved, one whose numbers are equal to others by no luck


@dataclass(frozen=True)
class Move:
    """Inputs from where they are to multiples of that, or, one that is 0, so much further."""

    start: Mapping[Place, float]
    factors: np.ndarray
    has_steps: bool = False  # and nothing between

    def numbers(self, place: Place) -> np.ndarray:
        """An input along the move; as it is typed, of twelve digits, where it is alone."""
        start = self.start[place]
        numbers = start * self.factors if start else self.factors - 1.0
        return np.array([float(f"{number:.12g}") for number in numbers])

    def closer(self, n: int) -> Move:
        """The move to its number n, with more steps before the last."""
        if self.has_steps:
            return self
        before = self.factors[n - 1] if n else 1.0
        between = np.linspace(before, self.factors[n], STEPS + 1)[1:]
        return Move(self.start, np.concatenate([self.factors[:n], between, self.factors[n + 1 : n + 2]]))


@dataclass(frozen=True)
class Way:
    """Values of both workbooks along moved inputs."""

    given: Values
    ours: Values
    theirs: Values
    reference: Sheet
    reached: int = 0

    @property
    def count(self) -> int:
        """How many samples there are."""
        return len(next(iter(self.given.values())))

    def values(self, sheet: Sheet) -> Values:
        """Those of the reference, or of the hand-in."""
        return self.ours if sheet is self.reference else self.theirs

    def until(self, n: int) -> Way:
        """The samples to number n, which is `reached`, and one more."""
        given, ours, theirs = (
            {p: v[: n + 2] if len(v) > 1 else v for p, v in each.items()}
            for each in (self.given, self.ours, self.theirs)
        )
        return Way(given, ours, theirs, self.reference, n)


@dataclass(frozen=True)
class Telling:
    """Inputs at which a result that was found is not what it should be, as some way changes there."""

    result: Place
    given: Mapping[Place, float]
    is_error: bool  # the hand-in has an error there
    is_single: bool  # at just these numbers, and not beyond them
