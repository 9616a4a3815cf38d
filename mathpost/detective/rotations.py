"""Are two rotations the same, and if not, how was one misread? Triples, quaternions and matrices in any mixture.

Three numbers are angles in degrees about the axes of a sequence, as `mathpost.euler` has them; four a quaternion,
scalar first; nine, or three rows of three, an active matrix. They are compared as rotations, not number by number.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import combinations, permutations

import numpy as np
from numpy.typing import ArrayLike

from mathpost import euler
from mathpost.detective.causes import slip
from mathpost.detective.digits import half_digit
from mathpost.detective.explanation import (
    CHANCE,
    COST,
    Explanation,
    Match,
    Misread,
    Misreading,
    Slip,
    grouped,
    told,
)
from mathpost.detective.notations import read
from mathpost.errors import InputError, as_array
from mathpost.rotation import as_rotation

GENERIC = np.array([21.1234567, 47.7654321, 74.4567891])
GENERIC_QUATERNION = np.array([0.5, -0.1, 0.7, 0.3])
PROBES = np.array([(20, 0, 50), (20, 35, 50), (-15, 70, 25)], dtype=float)
QUATERNION_PROBES = np.array([(0.8, 0.6, 0, 0), (0.5, -0.1, 0.7, 0.3)])
POINT = np.array([1.0, 2.0, 3.0])
APART = 0.05
MOST = 6
ANGLES = "first second third".split()


def explain_rotation(
    given: ArrayLike,
    answer: ArrayLike,
    *,
    sequence: str = "ZXZ",
    answer_sequence: str | None = None,
) -> Explanation:
    """Return how `given` must be misread to be the rotation `answer`, the simplest first; right if they are equal.

    Both have 3, 4 or 9 numbers as above. `sequence` names the axes of the angles, in upper case about the turned,
    in lower case about the fixed axes; `answer_sequence` those of the answer, by default the same. Strings keep the
    zeros that tell the precision. `InputError` if one is not a rotation.

    Examples
    --------
    >>> print(explain_rotation([0, 180, 0], [180, 0, 180], sequence="XYZ"))
    the same rotation
    Every rotation has two triples: the other one is 180.0000 0.0000 180.0000, and whole turns may be added.
    >>> from scipy.spatial.transform import Rotation
    >>> answer = Rotation.from_euler("xyz", [20, 35, 50], degrees=True).as_matrix()
    >>> print(explain_rotation([20, 35, 50], answer.round(6), sequence="XYZ").misreadings[0])
    turned about the fixed axes x y z, not about the turned ones: xyz
    """
    first, second = _Said.of(given, sequence, "given"), _Said.of(answer, answer_sequence or sequence, "result")
    return _compared(first, second)


@dataclass(frozen=True)
class _Said:
    """A rotation as it was written."""

    kind: str  # "angles", "quaternion" or "matrix"
    values: np.ndarray
    sequence: str
    half_digit: float  # of its last decimal; for angles in radians

    @classmethod
    def of(cls, values: ArrayLike, sequence: str, where: str) -> _Said:
        flat = np.ravel(np.asarray(values, dtype=object))
        kinds = {3: "angles", 4: "quaternion", 9: "matrix"}
        if len(flat) not in kinds:
            raise InputError(where, "3 angles, 4 numbers of a quaternion or 9 of a matrix", f"{len(flat)}")
        numbers, half = as_array(flat, len(flat), where), half_digit(flat)
        kind = kinds[len(flat)]
        if kind == "matrix":
            _near_rotation(numbers.reshape(3, 3), half, where)
        if kind == "quaternion":
            euler.from_quaternion(numbers)
        euler.matrix(sequence, (0, 0, 0))  # refuses an unknown one
        return cls(kind, numbers, sequence, np.deg2rad(half) if kind == "angles" else half)

    @property
    def allowed(self) -> float:
        """How far its digits allow an entry of its matrix to be off."""
        return {"angles": 3, "quaternion": 4, "matrix": 1}[self.kind] * self.half_digit * (1 + 1e-6) + 1e-9


def _near_rotation(matrix: np.ndarray, half: float, where: str) -> None:
    """Refuse a matrix that is not a rotation to its digits: a coarsely written one means the nearest rotation."""
    left, _, right = np.linalg.svd(matrix)
    nearest = left @ right
    if np.linalg.det(nearest) < 0:
        reflection = read("matrix", matrix)
        raise InputError(where, "a rotation", f"{reflection.fault} {reflection.remedy.rstrip(':')}")
    if np.abs(nearest - matrix).max() > 2 * half + 2e-6:
        as_rotation(matrix, where)  # says what is wrong
        raise InputError(where, "a rotation", "none to its digits")


@dataclass(frozen=True)
class _Reading(Misread):
    """A way to read a rotation: axes, order, signs and unit of angles, the order of a quaternion, the inverse."""

    slips: tuple[Slip, ...] = ()
    sequence: str = ""
    source: tuple[int, ...] = (0, 1, 2)
    factor: tuple[float, ...] = (1.0, 1.0, 1.0)
    shift: int = 0
    inverse: bool = False

    def matrix(self, kind: str, values: np.ndarray) -> np.ndarray:
        """Return the matrix that the numbers are read as."""
        if kind == "angles":
            made = euler.matrix(self.sequence, values[list(self.source)] * self.factor, degrees=True)
        elif kind == "quaternion":
            made = euler.from_quaternion(np.roll(values, self.shift))
        else:
            made = values.reshape(3, 3)
        return made.T if self.inverse else made


@dataclass(frozen=True)
class _Match(Match):
    """A reading of the given rotation and one of the answer that agree."""

    given: _Reading
    answer: _Reading

    @property
    def slips(self) -> tuple[Slip, ...]:
        return (*self.given.slips, *self.answer.slips)

    @property
    def product(self) -> str:
        words = ["".join(self.given.sequence)] if self.given.sequence else []
        return ", ".join([*words, "transposed"] if self.given.inverse else words)


def _sequences(sequence: str) -> Iterator[tuple[str, tuple[Slip, ...]]]:
    """Every sequence, with its slip."""
    yield sequence, ()
    other = sequence.lower() if sequence.isupper() else sequence.upper()
    about = (
        "about the fixed axes {}, not about the turned ones"
        if sequence.isupper()
        else ("about the turned axes {}, not about the fixed ones")
    )
    yield other, (slip("intrinsic", "turned " + about.format(" ".join(other))),)
    for axes in euler.SEQUENCES:
        axes = axes if sequence.isupper() else axes.lower()
        if axes not in (sequence, other):
            backwards = 0.0 if axes == sequence[::-1] else 0.2
            phrase = f"the axes are {' '.join(axes)}, not {' '.join(sequence)}"
            yield axes, (slip("order", phrase, backwards),)


@lru_cache(maxsize=64)
def _of_angles(sequence: str) -> tuple[_Reading, ...]:
    """Readings of three angles with at most two slips."""
    changes: list[tuple[dict, Slip]] = []
    for source in permutations(range(3)):
        if source != (0, 1, 2):
            phrase = f"the angles are taken in the order {', '.join(ANGLES[n] for n in source)}"
            changes.append(({"source": source}, slip("order", phrase, 0.05)))
    for n, name in enumerate(ANGLES):
        factor = tuple(-1.0 if n == other else 1.0 for other in range(3))
        changes.append(({"factor": factor}, Slip("sign", 1.0, f"the sign of the {name} angle is reversed")))
    changes.append(({"factor": (-1.0,) * 3}, Slip("sign", 1.05, "all angles are negated")))
    degree = float(np.degrees(1))
    for times, phrase in ((2.0, "twice the angles are used"), (0.5, "half of the angles is used")):
        changes.append(({"factor": (times,) * 3}, Slip("double angle", 1.25, phrase)))
    changes.append(({"factor": (degree,) * 3}, slip("radians", "the degrees are taken for radians")))
    changes.append(
        ({"factor": (1 / degree,) * 3}, slip("radians", "the angles are converted to radians twice", 0.2))
    )
    found = []
    for axes, slips in _sequences(sequence):
        found.append(_Reading(slips, axes))
        found += [_Reading((*slips, also), axes, **change) for change, also in changes]
        if not slips:
            pairs = [(a, b) for a, b in combinations(changes, 2) if a[0].keys() != b[0].keys()]
            found += [_Reading((a[1], b[1]), axes, **a[0], **b[0]) for a, b in pairs]
    return tuple(found)


def _readings(said: _Said, *, simple: bool) -> list[_Reading]:
    """The ways to read a rotation; if `simple`, only those that concern its notation."""
    if said.kind == "matrix":
        return [_Reading()]
    if said.kind == "quaternion":
        stored = slip("quaternion", "the quaternion is written x y z w, scalar last")
        last = slip("quaternion", "the quaternion is written y z w x", 0.5)
        return [_Reading(), _Reading((stored,), shift=1), *([] if simple else [_Reading((last,), shift=-1)])]
    return [_Reading((), said.sequence)] if simple else list(_of_angles(said.sequence))


def _compared(given: _Said, answer: _Said) -> Explanation:
    transposed = slip("transposed", "it is the inverse, the transposed matrix")
    allowed = given.allowed + answer.allowed
    ways = _readings(given, simple=False)
    both = [*ways, *(_inverted(way, transposed) for way in ways if len(way.slips) < 2)]
    matrices = np.array([way.matrix(given.kind, given.values) for way in both])
    matches, tried = [], 0
    answers = _readings(answer, simple=answer.kind != "angles" or given.kind == "angles")
    if answer.kind == given.kind == "angles":
        answers = [_Reading(_in_the_answer(slips), axes) for axes, slips in _sequences(answer.sequence)]
    for way in answers:
        wanted = way.matrix(answer.kind, answer.values)
        off = np.abs(matrices - wanted).max(axis=(1, 2))
        tried += len(both)
        matches += [_Match(both[n], way) for n in np.flatnonzero(off <= allowed)]
    matches = [match for match in matches if len(match.slips) < 3]
    right = [match for match in matches if not match.slips]
    if right:
        value = right[0].given.matrix(given.kind, given.values)
        same = _Plain("the same rotation", "", (), value, (), 0.0)
        return Explanation((same,), allowed, tried, _twins(given, answer))
    if matches and tried * min(1.0, allowed) ** 3 > CHANCE:
        matches = []
    matches.sort(key=COST)
    groups = grouped(matches, lambda match: _behaviour(match, given), 100)[:MOST] if matches else []
    misreadings = tuple(told(group, group[0].given.matrix(given.kind, given.values)) for group in groups)
    notes = [_difference(given, answer), *([_tell_apart(groups, given)] if len(groups) > 1 else [])]
    return Explanation(misreadings, allowed, tried, "\n".join(notes))


class _Plain(Misreading):
    """The right reading, shown without a product."""

    def __str__(self) -> str:
        return self.sentence


def _in_the_answer(slips: Iterable[Slip]) -> tuple[Slip, ...]:
    return tuple(Slip(each.kind, each.cost + 0.01, f"in the answer {each.phrase}") for each in slips)


def _inverted(way: _Reading, also: Slip) -> _Reading:
    return replace(way, slips=(*way.slips, also), inverse=True)


def _behaviour(match: _Match, given: _Said) -> tuple[bytes, tuple[Slip, ...]]:
    """A key that differs between readings, whatever the numbers."""
    generic = {"angles": GENERIC, "quaternion": GENERIC_QUATERNION}.get(given.kind, given.values)
    made = match.given.matrix(given.kind, generic)
    of_answer = match.answer.slips
    return (made.round(9) + 0.0).tobytes(), of_answer


def _twins(given: _Said, answer: _Said) -> str:
    """Say how two different triples of one rotation are related."""
    if given.kind != "angles" or answer.kind != "angles" or given.sequence != answer.sequence:
        return ""
    if np.abs(given.values - answer.values).max() < 1e-9:
        return ""
    matrix = euler.matrix(given.sequence, given.values, degrees=True)
    if euler.is_locked(given.sequence, matrix):
        return "First and third axis are parallel here: only the sum or the difference of their angles counts."
    other = " ".join(f"{angle:z.4f}" for angle in euler.twin(given.sequence, given.values, degrees=True))
    return f"Every rotation has two triples: the other one is {other}, and whole turns may be added."


def _difference(given: _Said, answer: _Said) -> str:
    """Say how far apart the two are, and which axis they have in common."""
    first = _readings(given, simple=True)[0].matrix(given.kind, given.values)
    second = _readings(answer, simple=True)[0].matrix(answer.kind, answer.values)
    left, _, right = np.linalg.svd(first.T @ second)
    axis, angle = euler.to_axis_angle(left @ right, degrees=True)
    about, allowed = " ".join(f"{x:z.4f}" for x in axis), max(1e-3, 2 * (given.allowed + answer.allowed))
    said = f"They differ by {angle:.4f}° about ({about}), seen from the first."
    same = ["XYZ"[n] for n in range(3) if np.abs(first[:, n] - second[:, n]).max() < 1e-6]
    tool = ": the same tool axis, turned about itself" * (same == ["Z"])
    return said + (f" Both have the same {same[0]} axis{tool}." if same else "") + _cycle(first, second, allowed)


def _cycle(first: np.ndarray, second: np.ndarray, allowed: float) -> str:
    """Say whether the axes of two matrices are the same in a cycle: the turned ones, the fixed ones, or both."""
    for order in ("yzx", "zxy"):
        turn = np.eye(3)[:, ["xyz".index(axis) for axis in order]]  # turn.T @ v has the entries of v in this order
        for said, made in (
            ("turned axes", first @ turn),
            ("fixed axes", turn.T @ first),
            ("axes, turned and fixed,", turn.T @ first @ turn),
        ):
            if np.abs(made - second).max() < allowed:
                return (
                    f" The {said} are exchanged in a cycle: x y z of the second are {' '.join(order)} of the first."
                )
    return ""


def _tell_apart(groups: list[list[_Match]], given: _Said) -> str:
    """Propose numbers for which the readings differ, and say where each takes a point."""
    probes = {"angles": PROBES, "quaternion": QUATERNION_PROBES}.get(given.kind, ())
    for probe in probes:
        values = [group[0].given.matrix(given.kind, probe) @ POINT for group in groups]
        if min(np.abs(a - b).max() for a, b in combinations(values, 2)) > APART:
            asked = " ".join(f"{x:g}" for x in probe)
            where = "; ".join(
                f"{group[0].sentence}: ({' '.join(f'{x:z.3f}' for x in value)})"
                for group, value in zip(groups, values, strict=True)
            )
            said = f"{len(groups)} readings give the same rotation here."
            return f"{said} To tell them apart, turn (1 2 3) by {asked}: {where}."
    return f"{len(groups)} readings give the same rotation here: give another one."
