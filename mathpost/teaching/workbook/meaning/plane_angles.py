"""The angles of a tilted plane, from directions of its axes or points on it: what they must be."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from mathpost import euler
from mathpost.teaching.workbook.meaning.calculation import Calculation, look, nearest
from mathpost.teaching.workbook.sheet.samples import SAMPLES

if TYPE_CHECKING:
    from mathpost.teaching.workbook.sheet.place import Line, Place
    from mathpost.teaching.workbook.sheet.samples import Values

ROUNDED = 2e-3  # what the directions of a frame are off that are written to three decimals
PLANE_WORDS = {("i", "j", "k"): "ZXZ", ("eulpr", "eulnu", "eulrot"): "ZXZ", ("spa", "spb", "spc"): "xyz"}


@dataclass(eq=False)
class Plane(Calculation):
    """The angles of a tilted plane: G68.2, PLANE EULER, PLANE SPATIAL, CYCLE800.

    `results` are all three in sequence, or the first two of a plane that is known by its normal only. `x`, `y`, `z`
    are directions of its axes, of which some are given; `corner` is the point from which `x` and `y` are measured
    where these are points.
    """

    sequence: str = "ZXZ"
    degrees: bool = True
    x: Line = ()
    y: Line = ()
    z: Line = ()
    corner: Line = ()
    frame: np.ndarray | None = None  # X, Y, Z in columns, shape (samples, 3, 3), once prepared from two directions

    @property
    def given(self) -> Line:
        """All inputs."""
        return (*self.x, *self.y, *self.z, *self.corner)

    @property
    def periods(self) -> dict[Place, float]:
        """Place of an angle → a turn."""
        return dict.fromkeys(self.results, 360.0 if self.degrees else 2 * np.pi)

    def is_possible(self) -> bool:
        """Whether the angles follow: from two directions, or from a normal but for the angle about it."""
        about_it = self.sequence[2] == "Z" or (self.sequence.islower() and self.sequence[0] != "z")
        return bool(self.x) if len(self.results) == 3 else about_it

    def draw(self, rng: np.random.Generator, units: dict[Place, float]) -> Values:
        """Place → samples: of frames at random, or of two directions or three points where these make the frame."""
        frame = np.moveaxis(_frame(*rng.normal(size=(2, SAMPLES, 3))), -1, 0)
        vectors = [
            *(frame if self.z else 30 * rng.normal(size=(3, SAMPLES, 3))),
            30 * rng.normal(size=(SAMPLES, 3)),
        ]
        columns = zip((self.x, self.y, self.z, self.corner), vectors, strict=True)
        return {p: entry for places, column in columns for p, entry in zip(places, column.T, strict=False)}

    def unround(self, inputs: Values) -> None:
        """Square the frame of the sheet if it is one but for its last digits; else draw others as it is."""
        if not inputs.keys() >= {*self.x, *self.y, *self.z}:  # a formula in place of a number
            return
        vectors = {each: np.stack([inputs[p] for p in each], axis=-1) for each in (self.x, self.y, self.z) if each}
        if not self.z:
            x, y = vectors[self.x], vectors[self.y]
            along = x * ((x * y).sum(axis=1) / (x * x).sum(axis=1))[:, None]
            if not self.corner and np.linalg.norm(along[0]) < ROUNDED * np.linalg.norm(y[0]):  # given as square
                inputs.update(zip(self.y, (y - along).T, strict=True))
            return
        lengths = {each: np.linalg.norm(vector[0]) for each, vector in vectors.items()}
        if self.x:
            own_x, own_z = vectors[self.x][0], vectors[self.z][0]
            cosine = own_x @ own_z / lengths[self.x] / lengths[self.z]
            for places, axis in zip((self.x, self.y, self.z), _frame(own_x, own_z).T, strict=True):
                if places:
                    vectors[places][0] = axis
            vectors[self.x] += (abs(cosine) > ROUNDED) * cosine * vectors[self.z]
        else:
            vectors[self.z][0] /= lengths[self.z]
        for places, vector in vectors.items():
            length = lengths[places] if abs(lengths[places] - 1) > ROUNDED and places != self.y else 1.0
            inputs.update(zip(places, (vector * length).T, strict=True))

    def prepare(self, values: Values, units: dict[Place, float]) -> None:
        """Compute the angles at the samples in `values`; of the two solutions the one that the sheet has."""
        turn = 180 / np.pi if self.degrees else 1.0
        corner = look(values, self.corner) if self.corner else 0.0
        x, y = (look(values, places) - corner if places else np.zeros((SAMPLES, 3)) for places in (self.x, self.y))
        across = look(values, self.z) if self.z else np.cross(x, y)
        now = look(values, self.results)
        is_whole = len(self.results) == 3
        if is_whole:
            frame = self.frame = _frame(x, across)
        else:
            frame = (across / np.linalg.norm(across, axis=-1, keepdims=True))[..., None]
        lost = ~np.isfinite(frame).all(axis=(1, 2))  # directions that are 0 or parallel make no frame
        frame[lost] = np.eye(3)[:, -frame.shape[-1] :]
        if is_whole:
            first = euler.angles(self.sequence, frame)
            both = np.stack([first, euler.twin(self.sequence, first)], axis=1)
        else:
            both = _from_normal(self.sequence, frame[..., 0])
        both = both * turn
        expected, votes = nearest(now, both, self.degrees)
        if 2 * max(votes) < expected.size:  # one angle that a slip turns round says nothing
            expected, _ = nearest(now, both[:, [0, 0]], self.degrees)
        turned = np.pad(np.nan_to_num(now), ((0, 0), (0, 3 - len(self.results))))
        made = euler.matrix(self.sequence, turned / turn)[..., -frame.shape[-1] :]
        fits = np.isfinite(now).all(axis=1) & (np.abs(made - frame).max(axis=(1, 2)) < 1e-9)
        expected = np.where(fits[:, None], now, expected)  # where first and last axis are parallel
        expected[lost] = np.nan
        self.radians = expected / turn
        self.should_be(self.results, expected.T)
        turns = [self.radians, np.rad2deg(self.radians), np.cos(self.radians), np.sin(self.radians)]
        vectors = [*_on_the_way(x, y, across), *np.moveaxis(frame, -1, 0)]
        numbers = [_dot(a, b) for a, b in ((x, across), (x, _unit(across)), (across, across), (y, _unit(x)))]
        lengths = [np.linalg.norm(vector, axis=-1, keepdims=True) for vector in vectors]
        beside = np.hstack([*turns, *numbers, *lengths, np.zeros((SAMPLES, 1))])
        self.known = {1: [entry[None] for entry in beside.T], 3: [vector.T for vector in vectors]}


def _on_the_way(x: np.ndarray, y: np.ndarray, across: np.ndarray) -> list[np.ndarray]:
    """What leads to a frame: of X, another direction in the plane and one across it, some may be 0."""
    vectors = [x, y, across, np.cross(across, x), np.cross(_unit(across), x)]
    vectors += [a - _dot(a, _unit(b)) * _unit(b) for a, b in ((x, across), (y, x))]
    return [vector for vector in (*vectors, _unit(x)) if np.ptp(vector) > 0 and np.isfinite(vector[1:]).all()]


def _unit(vector: np.ndarray) -> np.ndarray:
    return vector / np.linalg.norm(vector, axis=-1, keepdims=True)


def _dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return (a * b).sum(axis=-1, keepdims=True)


def _frame(x: np.ndarray, z: np.ndarray) -> np.ndarray:
    """The matrix of X, Y and Z in columns, from vectors along Z and in the plane of Z and X."""
    y = np.cross(z, x)
    columns = np.stack([np.cross(y, z), y, z], axis=-1)
    return columns / np.linalg.norm(columns, axis=-2, keepdims=True)


def _from_normal(sequence: str, normal: np.ndarray) -> np.ndarray:
    """Both solutions of the first two angles, as written, that make a Z of `normal`, shape (samples, 2, 2)."""
    letters = sequence if sequence.isupper() else sequence[1::-1].upper() + "Z"
    first = euler.from_direction(letters, normal)
    both = np.stack([first, euler.twin(letters, first)], axis=1)[..., :2]
    return both if sequence.isupper() else both[..., ::-1]
