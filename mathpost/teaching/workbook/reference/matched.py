"""Which inputs of a reference a hand-in has, where, and in which unit; when two numbers are the same."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from mathpost.teaching.workbook.reference.quantities import Sheet
from mathpost.teaching.workbook.sheet.place import Line, Place, offset

NEAR = 1e-5  # relative: the same number with fewer digits
SCALES = (1e-6, 1e-5, 1e-3, 1e3, 1e5, 1e6)  # of a student's own number in a different unit
ALIKE = 0.7  # powers of ten by which own numbers may be apart
LONG = 3  # numbers in a row that are found together


@dataclass
class Matched:
    """Inputs of the reference → the cells of the hand-in that hold them, and how these were found."""

    cells: dict[Place, list[Place]] = field(default_factory=dict)
    factor: dict[Place, float] = field(default_factory=dict)  # of the hand-in's unit
    other: dict[Place, Place] = field(default_factory=dict)  # those that hold a different number
    open: list[Place] = field(default_factory=list)
    unsure: list[Place] = field(default_factory=list)  # found by what they do alone, and in a different order
    scale: dict[Place, float] = field(
        default_factory=dict
    )  # units of the student's own numbers, as their size says
    weak: set[Place] = field(default_factory=set)  # found by what they do or by where they are, and no label agrees

    @property
    def back(self) -> dict[Place, Place]:
        """Cell of the hand-in → input of the reference."""
        return {cell: place for place, cells in self.cells.items() for cell in cells}


def near(a: float, b: float) -> bool:
    return abs(a - b) <= NEAR * abs(a)


def in_unit(numbers: Mapping[Place, float], factor: float, place: Place, number: float) -> bool:
    """Whether a number is that of an input in a different unit."""
    return telling(number) and near(numbers[place] * factor, number)


def scale_of(number: float, own: float) -> float | None:
    """The factor of the unit of a student's own number, which is of another size than the reference's."""
    if number * own <= 0 or abs(np.log10(number / own)) < -np.log10(SCALES[2]) - ALIKE:
        return None
    scale = min(SCALES, key=lambda each: abs(np.log10(number / own / each)))
    return scale if abs(np.log10(number / own / scale)) < ALIKE else None


def telling(number: float) -> bool:
    """Whether a number has so many digits that it is not equal to something else by luck."""
    return len(f"{abs(number):.10g}".replace(".", "").strip("0")) > 3


def runs(places: Sequence[Place]) -> Iterator[Line]:
    """Yield the numbers that follow each other in a column, and those in a row, `LONG` or more."""
    known = {*places}
    for down, right in ((1, 0), (0, 1)):
        for place in places:
            if offset(place, -down, -right) not in known:
                line = [place]
                while (after := offset(line[-1], down, right)) in known:
                    line.append(after)
                if len(line) >= LONG:
                    yield tuple(line)


def different(found: Matched, reference: Sheet, handed_in: Sheet) -> list[tuple[Place, Place]]:
    """The inputs of which the hand-in has a different number: (of the reference, of the hand-in)."""
    own, other = reference.numbers_typed, handed_in.numbers_typed
    return [(place, cell) for place, cell in found.other.items() if not near(own[place], other[cell])]
