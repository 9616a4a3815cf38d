"""A calculation: its inputs by their roles, the required results, and the values that may occur in between."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from mathpost.detective.misreadings import elementary
from mathpost.euler import from_axis_angle
from mathpost.rotation import unit
from mathpost.teaching.workbook.sheet.samples import SAMPLES

if TYPE_CHECKING:
    from mathpost.teaching.workbook.sheet.place import Line, Place
    from mathpost.teaching.workbook.sheet.samples import Values

LARGEST_RADIANS = 6.3  # an angle beyond a turn in radians is in degrees


@dataclass(eq=False)
class Calculation:
    """Inputs and results are places.

    `known` takes a number of cells to the values that so many cells may hold together on the way to the results,
    each of shape (cells, samples): matrices in 9 or 16 cells, vectors in 3 or 4, cosine and sine in 2.
    """

    results: Line
    angles: Line = ()
    point: Line = ()
    origin: Line = ()
    axis: Line = ()
    said: str = ""
    complete: bool = True  # whether there is a number in each cell
    typed: bool = False  # whether results are numbers, so that only the sheet's own can be judged
    known: dict[int, list[np.ndarray]] = field(default_factory=dict)
    targets: Values = field(default_factory=dict)
    radians: np.ndarray = field(init=False, repr=False)  # of the angles, shape (samples, …), once prepared

    @property
    def given(self) -> Line:
        """All inputs."""
        return (*self.angles, *self.point, *self.origin, *self.axis)

    @property
    def read(self) -> Line:
        """All places of which `prepare` needs the values."""
        return (*self.given, *self.results)

    @property
    def entries(self) -> list[np.ndarray]:
        """The values that one cell may hold."""
        return [entry for known in self.known.values() for k in known for entry in k]

    def draw(self, rng: np.random.Generator, units: dict[Place, float]) -> Values:
        """Place of an input → samples at random."""
        limits = {p: 3.0 if units.get(p, 1.0) == 1.0 else 170.0 for p in self.angles}
        return {p: rng.uniform(-limits.get(p, 60), limits.get(p, 60), SAMPLES) for p in self.given}

    def prepare(self, values: Values, units: dict[Place, float]) -> None:
        """Compute, at the samples in `values`, the required results and the values that may occur on the way."""
        raise NotImplementedError

    def should_be(self, places: Iterable[Place], expected: np.ndarray) -> None:
        """Set the targets: the required values of `places`, shape (len(places), samples)."""
        self.targets = dict(zip(places, expected, strict=False))


@dataclass(eq=False)
class Turn(Calculation):
    """A rotation of a point, about an origin where there is one, by three angles in sequence or about an axis."""

    sequence: str = "ZXZ"
    active: bool = False
    shift: Line = ()  # what is added after the rotation
    back: bool = False  # whether the point is turned back, from the turned frame
    of_length_one: bool = False  # whether the axis is taken as it is, not divided by its length

    @property
    def given(self) -> Line:
        """All inputs."""
        return (*super().given, *self.shift)

    def draw(self, rng: np.random.Generator, units: dict[Place, float]) -> Values:
        drawn = super().draw(rng, units)
        if self.of_length_one:
            length = np.linalg.norm([drawn[p] for p in self.axis], axis=0)
            drawn |= {p: drawn[p] / length for p in self.axis}
        return drawn

    def prepare(self, values: Values, units: dict[Place, float]) -> None:
        """Compute, at the samples in `values`, what the sheet may hold: as 4×4, of which the 3×3 are a part."""
        self.radians = look(values, self.angles) * [units[p] for p in self.angles]
        self.elements, words, ends = self._elements(values), [], []
        for first in range(len(self.elements)):
            product = np.eye(4)
            for element in self.elements[first:]:
                product = product @ element
                words.append(product)
            ends.append(product)
        shift = np.tile(np.eye(4), (SAMPLES, 1, 1))
        shift[:, :3, 3] -= look(values, self.origin) if self.origin else 0.0
        moved = [shift, *(end @ shift for end in ends)]
        if self.shift:
            after = np.tile(np.eye(4), (SAMPLES, 1, 1))
            after[:, :3, 3] += look(values, self.shift)
            moved.insert(1, after @ moved[1])
        matrices = [each for word in words for each in (word, np.swapaxes(word, 1, 2))]
        places = (
            [each for word in moved for each in (word, np.linalg.inv(word))] if self.origin or self.shift else []
        )
        self.elements += [np.swapaxes(each, 1, 2) for each in self.elements]
        pairs = [(np.cos(a), np.sin(a)) for a in self.radians.T]
        self.known = {
            9: [_cells(m, 3) for m in matrices],
            16: [_cells(m, 4) for m in (*matrices, *places)],
            2: [np.array(each) for c, s in pairs for each in ((c, s), (s, c), (c, -s), (-s, c))],
        }
        target, self.whole = moved[1], _cells(ends[0], 3)
        if self.point:
            point = np.concatenate([look(values, self.point), np.ones((SAMPLES, 1))], axis=1)[..., None]
            vectors = [*(matrix @ point for matrix in moved), point]
            vectors += [matrix[:, :, 3:] for matrix in places]
            self.known |= {n: [_cells(v, n) for v in vectors] for n in (3, 4)}
            terms = _cells(ends[0][:, :3, :3] * np.swapaxes(vectors[0][:, :3], 1, 2), 3)
            self.known[1] = [term[None] for term in terms if np.ptp(term[1:])]
            self.known[3] += [unit(look(values, self.axis)).T] if self.axis else []
            target = vectors[1] if len(self.results) < 9 else target
        self.should_be(self.results, _cells(target, 3 if len(self.results) in (3, 9) else 4))

    def _elements(self, values: Values) -> list[np.ndarray]:
        """The elementary matrices from left to right, each of shape (samples, 4, 4)."""
        sign = 1 if self.active else -1
        if self.axis:
            order = [from_axis_angle(look(values, self.axis), sign * self.radians[:, 0])]
        else:
            order = [elementary(*each) for each in zip(self.sequence.upper(), -sign * self.radians.T, strict=True)]
            order = order[::-1] if self.sequence.isupper() != self.active else order
        return [np.pad(each, ((0, 0), (0, 1), (0, 1))) + np.diag([0, 0, 0, 1.0]) for each in order]

    def scalars(self) -> Iterator[np.ndarray]:
        """The values that one cell may hold: cosine and sine of an angle and its half."""
        pairs = [np.array([np.cos(a), np.sin(a)]) for a in (*self.radians.T, *self.radians.T / 2)]
        yield from (entry for pair in pairs for entry in pair)


def look(values: Values, places: Sequence[Place]) -> np.ndarray:
    """The values of some places, shape (samples, len(places))."""
    found = np.empty((SAMPLES, len(places)))
    for n, place in enumerate(places):
        found[:, n] = values[place]
    return found


def nearest(now: np.ndarray, both: np.ndarray, slack: float | np.ndarray = 1e-6) -> np.ndarray:
    """Return the one of two solutions, (rows, 2, angles), that has more of the present angles.

    A right angle is right in any winding, which is then kept; of equally good solutions that of most rows counts.
    """
    right = np.abs((now[:, None] - both + 180) % 360 - 180) <= slack
    fits = right.sum(axis=-1)
    better = int(np.argmax(fits.sum(axis=0)))
    branch = np.where(fits[:, 1 - better] > fits[:, better], 1 - better, better)
    n = np.arange(len(now))
    found = both[n, branch]
    return found + 360 * np.where(right[n, branch], np.round((now - found) / 360), 0)


def _cells(matrix: np.ndarray, size: int) -> np.ndarray:
    """The first rows and columns of matrices or vectors, shape (cells, samples)."""
    return matrix[:, :size, :size].reshape(SAMPLES, -1).T
