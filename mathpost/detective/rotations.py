"""Are two rotations the same, and if not, how was one misread? Triples, quaternions and matrices in any mixture.

Three numbers are angles in degrees about the axes of a sequence, as `mathpost.euler` has them; four a quaternion,
scalar first; nine, or three rows of three, an active matrix. They are compared as rotations, not number by number.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from numpy.typing import ArrayLike

from mathpost import euler
from mathpost.detective.causes import slip
from mathpost.detective.digits import half_digit, row
from mathpost.detective.explanation import CHANCE, Explanation, Match, Slip, Trial, explanation
from mathpost.detective.misreadings import all_factors, frame_wordings, matrices, written
from mathpost.detective.notations import Rotation, read
from mathpost.errors import InputError

GENERIC = {3: np.array([21.1234567, 47.7654321, 74.4567891]), 4: np.array([0.5, -0.1, 0.7, 0.3])}
PROBES: dict[int, list[tuple[float, ...]]] = {
    3: [(20, 0, 50), (20, 35, 50), (-15, 70, 25)], 4: [(0.8, 0.6, 0, 0), (0.5, -0.1, 0.7, 0.3)], 9: [],
}  # fmt: skip
KINDS = {3: "angles", 4: "wxyz", 9: "matrix"}
POINT = np.array([1.0, 2.0, 3.0])
SAME = "the same rotation"


def explain_rotation(
    given: ArrayLike, answer: ArrayLike, *, sequence: str = "ZXZ", answer_sequence: str | None = None
) -> Explanation:
    """Return how `given` must be misread to be the rotation `answer`, the simplest first; right if they are equal.

    Both have 3, 4 or 9 numbers as above. `sequence` names the axes of the angles, in upper case about the
    turned, in lower case about the fixed axes; `answer_sequence` those of the answer, by default the same;
    ``"xyzw"`` says of a quaternion that its scalar is last. Strings keep the zeros that tell the precision. A
    matrix that is no rotation to its digits explains nothing, and the note says why; `InputError` for other
    counts of numbers, or an unknown sequence.

    Examples
    --------
    >>> print(explain_rotation([0, 180, 0], [180, 0, 180], sequence="XYZ"))
    the same rotation
    Every rotation has two triples: the other one is 180.0000 0.0000 180.0000, and whole turns may be added.
    >>> from scipy.spatial.transform import Rotation
    >>> answer = Rotation.from_euler("xyz", [20, 35, 50], degrees=True).as_matrix()
    >>> print(explain_rotation([20, 35, 50], answer.round(6), sequence="XYZ").misreadings[0])
    turned about the fixed axes x y z, not about the turned ones: R_z(γ)·R_y(β)·R_x(α)
    """
    first, second = _Said.of(given, sequence, "given"), _Said.of(answer, answer_sequence or sequence, "result")
    read_as = {"Given": first.rotation, "Result": second.rotation}
    faults = [f"{said}: {each.fault} {each.remedy.rstrip(':')}." for said, each in read_as.items() if each.fault]
    return Explanation((), 0.0, 0, "\n".join(faults)) if faults else _compared(first, second)


@dataclass(frozen=True, eq=False)
class _Said:
    """A rotation as it was written."""

    numbers: np.ndarray
    sequence: str
    rotation: Rotation
    allowed: float  # how far its digits allow an entry of its matrix to be off

    @classmethod
    def of(cls, values: ArrayLike, sequence: str, where: str) -> _Said:
        flat = np.ravel(np.asarray(values, dtype=object))
        if len(flat) not in KINDS:
            raise InputError(where, "3 angles, 4 numbers of a quaternion or 9 of a matrix", f"{len(flat)}")
        if len(flat) == 4 and sequence == "xyzw":
            flat = np.roll(flat, 1)
        else:
            euler.matrix(sequence, (0, 0, 0))  # refuses an unknown one
        rotation = read(sequence if len(flat) == 3 else KINDS[len(flat)], flat)
        half = half_digit(flat) * {3: 3 * np.pi / 180, 4: 4, 9: 1}[len(flat)]
        return cls(flat.astype(float), sequence, rotation, half * (1 + 1e-6) + 1e-9)

    @property
    def orders(self) -> list[tuple[tuple[Slip, ...], int]]:
        """The ways to read a quaternion: the slips of each, and how far its numbers are to be rolled."""
        others = [(1, "x y z w, scalar last", 0.0), (-1, "y z w x", 0.5)]
        others = [(-1, "w x y z, scalar first", 0.0)] if self.sequence == "xyzw" else others
        said = [((slip("quaternion", f"the quaternion is written {order}", more),), n) for n, order, more in others]
        return [((), 0), *said * (len(self.numbers) == 4)]

    def matrix(self, sequence: str) -> np.ndarray:
        """Its matrix, if the angles were about the axes of another sequence."""
        return read(sequence, self.numbers).matrix if len(self.numbers) == 3 else self.rotation.matrix


def _compared(given: _Said, answer: _Said) -> Explanation:
    allowed, tried, notes = given.allowed + answer.allowed, 0, [_difference(given, answer)]
    if len(given.numbers) != 3 == len(answer.numbers):
        given, answer = answer, given  # first what can be misread in more ways
    count, matches = len(given.numbers), list[Match]()
    made, way = _of_angles(given) if count == 3 else _of_numbers(given)
    for further, wanted in _answers(answer):
        near = np.flatnonzero(np.abs(made - wanted).max(axis=(1, 2)) <= allowed)
        tried += len(made)
        matches += [way(int(n), further) for n in near]
    matches = [match for match in matches if len(match.slips) < 3]
    if right := [match for match in matches if not match.slips]:
        matches = right[:1]
    elif tried * min(1.0, allowed) ** 3 > CHANCE:
        matches = []
    asked = [" ".join(f"{x:g}" for x in probe) for probe in PROBES[count]]
    probes = [(f"turning (1 2 3) by {each}", np.array(p)) for each, p in zip(asked, PROBES[count], strict=True)]
    trial = Trial(
        given.numbers, [GENERIC.get(count, given.numbers)], probes,
        lambda matrix: f"({row(matrix @ POINT, 3)})", "rotation",
    )  # fmt: skip
    found = explanation(matches, trial, allowed, tried)
    notes = [_twins(given, answer)] if right else [*notes, found.note]
    return replace(found, note="\n".join(filter(None, notes)))


Ways = tuple[np.ndarray, Callable[[int, tuple[Slip, ...]], Match]]  # matrices, and the match of one of them


def _of_angles(given: _Said) -> Ways:
    """The ways to read three angles."""
    factors, words = all_factors(given.sequence), frame_wordings(given.sequence)
    keys, same = list(words), [of_one[0] for of_one in words.values()]

    def match(n: int, further: tuple[Slip, ...]) -> Match:
        each, wording = factors[n // len(keys)], same[n % len(keys)]
        slips = (*wording.slips, *each.slips, *further)
        product = written(wording, each) if slips else ""
        return Match(slips, product, lambda angles: matrices([each], [wording.key], angles)[0, 0], right=SAME)

    return matrices(factors, keys, given.numbers).reshape(-1, 3, 3), match


def _of_numbers(given: _Said) -> Ways:
    """The ways to read a quaternion or a matrix."""
    ways = list(product(given.orders, (False, True)))
    inverse = (slip("transposed", "it is the inverse, the transposed matrix"),)

    def matrix(numbers: np.ndarray, order: tuple[tuple[Slip, ...], int], inverted: bool) -> np.ndarray:
        quaternion = len(numbers) == 4
        made = euler.from_quaternion(np.roll(numbers, order[1])) if quaternion else given.rotation.matrix
        return made.T if inverted else made

    def match(n: int, further: tuple[Slip, ...]) -> Match:
        order, inverted = ways[n]
        slips = (*order[0], *inverse * inverted, *further)
        return Match(slips, "", lambda numbers: matrix(numbers, order, inverted), right=SAME)

    return np.array([matrix(given.numbers, *way) for way in ways]), match


def _answers(answer: _Said) -> Iterator[tuple[tuple[Slip, ...], np.ndarray]]:
    """The ways to read the answer."""
    yield (), answer.rotation.matrix
    for slips, roll in answer.orders[1:2]:
        yield slips, read("wxyz", np.roll(answer.numbers, roll)).matrix
    if len(answer.numbers) == 3:
        for each in frame_wordings(answer.sequence).values():
            if [slip.kind for slip in each[0].slips] == ["intrinsic"]:
                yield _in_the_answer(each[0].slips[0]), answer.matrix(answer.sequence.swapcase())
        for factors in all_factors(answer.sequence):
            if [slip.kind for slip in factors.slips] == ["axis"]:
                axes = factors.axes if answer.sequence.isupper() else factors.axes.lower()
                yield _in_the_answer(factors.slips[0]), answer.matrix(axes)


def _in_the_answer(each: Slip) -> tuple[Slip, ...]:
    return (Slip(each.kind, each.cost + 0.01, f"in the answer {each.phrase}"),)


def _twins(given: _Said, answer: _Said) -> str:
    """Say how two different triples of one rotation are related."""
    if not len(given.numbers) == len(answer.numbers) == 3 or given.sequence != answer.sequence:
        return ""
    if np.abs(given.numbers - answer.numbers).max() < 1e-9:
        return ""
    if given.rotation.locked(given.sequence):
        return "First and third axis are parallel here: only the sum or the difference of their angles counts."
    other = row(euler.twin(given.sequence, given.numbers, degrees=True))
    return f"Every rotation has two triples: the other one is {other}, and whole turns may be added."


def _difference(given: _Said, answer: _Said) -> str:
    """Say how far apart the two are, and which axis they have in common."""
    first, second = given.rotation.matrix, answer.rotation.matrix
    axis, angle = euler.to_axis_angle(first.T @ second, degrees=True)
    allowed = max(1e-3, 2 * (given.allowed + answer.allowed))
    said = f"They differ by {angle:.4f}° about ({row(axis)}), seen from the first."
    same = ["XYZ"[n] for n in range(3) if np.abs(first[:, n] - second[:, n]).max() < 1e-6]
    tool = ": the same tool axis, turned about itself" * (same == ["Z"])
    return said + (f" Both have the same {same[0]} axis{tool}." if same else "") + _cycle(first, second, allowed)


def _cycle(first: np.ndarray, second: np.ndarray, allowed: float) -> str:
    """Say whether the axes of two matrices are the same in a cycle: the turned ones, the fixed ones, or both."""
    for order in ("yzx", "zxy"):
        turn = np.eye(3)[:, ["xyz".index(axis) for axis in order]]  # turn.T @ v has the entries of v in this order
        ways = {"turned axes": first @ turn, "fixed axes": turn.T @ first}
        ways["axes, turned and fixed,"] = turn.T @ first @ turn
        for said, made in ways.items():
            if np.abs(made - second).max() < allowed:
                what = f"x y z of the second are {' '.join(order)} of the first"
                return f" The {said} are exchanged in a cycle: {what}."
    return ""
