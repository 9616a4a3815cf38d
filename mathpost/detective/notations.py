"""One rotation in every notation: whatever is known of it goes in, all the others come out.

Matrices are active: the columns are the axes of the turned frame, given in the fixed one. Who writes which is in
`notations.toml`, beside this file.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from mathpost import euler
from mathpost.detective.digits import half_digit, row
from mathpost.errors import InputError, as_array
from mathpost.files import read_toml
from mathpost.rotation import ORTHONORMAL, unit

WRITERS = read_toml(Path(__file__).with_name("notations.toml"))  # who writes it how
COUNTS = {
    "matrix": 9, "rows": 9, "wxyz": 4, "xyzw": 4, "vector": 3, "axis-angle": 4,
    "from-to": 6, "x-y": 6, "x-z": 6, "z-x": 6,
}  # fmt: skip
EXPECTED = f"{', '.join(COUNTS)}, three axes such as ZYX (turned) or zyx (fixed), or {', '.join(WRITERS)}"
SAME = 1e-9


@dataclass(frozen=True, eq=False)
class Rotation:
    """A rotation, and what was found where it was read; ``print(rotation)`` says all of it."""

    matrix: np.ndarray  # shape (3, 3), orthonormal: the nearest one to what was given
    found: tuple[str, ...] = ()  # sentences on the numbers that were given
    fault: str = ""  # why they are no rotation, or empty;
    remedy: str = ""  # then how `matrix` came from them
    half: float = 0.0  # half of the last digit of its entries, 0 if they are exact

    @cached_property
    def quaternion(self) -> np.ndarray:
        """(w, x, y, z), *scalar first*, shape (4,)."""
        return euler.to_quaternion(self.matrix)

    @cached_property
    def axis_angle(self) -> tuple[np.ndarray, float]:
        """The unit axis, shape (3,), and the angle in degrees, 0 to 180."""
        axis, angle = euler.to_axis_angle(self.matrix, degrees=True)
        return axis, float(angle)

    @property
    def vector(self) -> np.ndarray:
        """The rotation vector, shape (3,): the axis times the angle in radians."""
        axis, angle = self.axis_angle
        return axis * np.deg2rad(angle)

    def angles(self, sequence: str) -> np.ndarray:
        """Return both solutions of a sequence, (2, 3), degrees; at the lock the third of the first is 0."""
        first = euler.angles(sequence, self.matrix, degrees=True)
        return np.array([first, euler.twin(sequence, first, degrees=True)])

    def written(self, kind: str, *, radians: bool = False) -> np.ndarray:
        """Return its numbers in a notation of `read`, angles in degrees unless `radians`."""
        angle = np.pi / 180 if radians else 1.0
        axis, turned = self.axis_angle
        x, y, z = self.matrix.T
        known = {
            "matrix": self.matrix.ravel(), "rows": self.matrix.T.ravel(), "wxyz": self.quaternion,
            "xyzw": np.roll(self.quaternion, -1), "vector": axis * turned * angle,
            "axis-angle": [*axis, turned * angle],
            "x-y": [*x, *y], "x-z": [*x, *z], "z-x": [*z, *x],
        }  # fmt: skip
        return np.array(known[kind]) if kind in known else self.angles(kind)[0] * angle

    def __str__(self) -> str:
        axis, angle = self.axis_angle
        lines = [*self.found, *filter(None, (self.fault, self.remedy))]
        lines += [f"a turn by {angle:.4f}° about ({row(axis, 6)})"]
        lines += [f"   {row(each, 6, 10)}" for each in self.matrix]
        lines += [f"quaternion w x y z   {row(self.quaternion, 6)}"]
        lines += [f"rotation vector      {row(self.vector, 6)} rad, {row(self.written('vector'))}°"]
        lines += ["", "angles about turned axes; about fixed axes in the opposite order (ZYX a b c is xyz c b a)"]
        for sequence in euler.SEQUENCES:
            first, second = self.angles(sequence)
            beside = f"or {row(second, width=9)}"
            if self.locked(sequence):
                sign = self._together(sequence)
                beside = f"locked: only first {'+-'[sign < 0]} third is known, {first[0] + sign * first[2]:z.4f}"
            lines.append(f"   {sequence}  {row(first, width=9)}   {beside}")
        lines.append("")
        width = max(len(each["name"]) for each in WRITERS.values())
        for each in WRITERS.values():
            radians = each.get("unit") == "rad"
            decimals = 6 if radians or "unit" not in each else 4
            numbers = row(self.written(each["as"], radians=radians), decimals)
            lines.append(f"{each['name']:{width}}  {numbers}{' rad' * radians}{'°' * (each.get('unit') == 'deg')}")
        back = replace(self, matrix=self.matrix.T)
        lines += ["", "the inverse (transposed: a passive matrix, or one written by columns)"]
        lines += [f"   wxyz {row(back.quaternion, 6)}   ZYX {row(back.angles('ZYX')[0])}"]
        return "\n".join(lines)

    def locked(self, sequence: str) -> bool:
        """Whether first and third axis of a sequence are parallel, as far as the digits tell."""
        middle = euler.angles(sequence, self.matrix)[1]
        sine = np.sin(middle) if sequence[0] == sequence[2] else np.cos(middle)
        return bool(abs(sine) < max(euler.LOCK, 4 * self.half))

    def _together(self, sequence: str) -> int:
        """At the lock +1 if first and third axis point the same way, −1 if against each other."""
        turned = euler.matrix(sequence, [0, euler.angles(sequence, self.matrix)[1], 0])
        return int(np.sign(turned["XYZ".index(sequence[0]), "XYZ".index(sequence[2])]))


def read(notation: str, values: ArrayLike, *, radians: bool | None = None) -> Rotation:
    """Return the `Rotation` that numbers mean in a notation.

    `notation` is ``"matrix"`` (row by row, 9 numbers; ``"rows"`` if its rows are the axes),
    ``"wxyz"`` or ``"xyzw"`` of a quaternion, ``"vector"`` (axis times angle), ``"axis-angle"``, ``"from-to"`` (the
    shortest turn of one direction into another), ``"x-y"``, ``"x-z"`` or ``"z-x"`` (two axes of the turned frame,
    the first kept), a sequence of `mathpost.euler` such as ``"ZYX"`` or ``"xyz"``, or a key of `WRITERS` such as
    ``"kuka"``. Angles are degrees, those of a vector radians, or as the writer has them; `radians` overrides that.
    Strings keep the zeros that tell the precision.

    Numbers that are no rotation to their digits are not refused: `Rotation.fault` says why. `InputError` for an
    unknown notation, another count of numbers, or a direction of length zero.

    Examples
    --------
    >>> read("kuka", [30, 20, 10]).written("wxyz").round(6)
    array([0.951549, 0.038135, 0.189308, 0.239298])
    >>> read("matrix", "1 0 0 0 1 0 0 0 -1".split()).fault
    'Determinant −1: a reflection, left-handed axes. No angles give it.'
    """
    writer = WRITERS.get(notation.lower(), {})
    kind = writer.get("as", notation)
    if kind not in COUNTS:
        try:
            euler.matrix(kind, (0, 0, 0))
        except InputError:
            raise InputError("notation", EXPECTED, repr(notation)) from None
    flat, count = np.ravel(np.asarray(values, dtype=object)), COUNTS.get(kind, 3)
    numbers = as_array(flat, len(flat), notation)
    if len(flat) != count:
        raise InputError(notation, f"{count} numbers", f"{len(flat)}")
    if radians is None:
        radians = writer.get("unit", "rad" if kind == "vector" else "deg") == "rad"
    if count == 9:
        matrix = numbers.reshape(3, 3)
        return _of_matrix(matrix if kind == "matrix" else matrix.T, half_digit(flat))
    if kind in ("wxyz", "xyzw"):
        length, found = np.linalg.norm(numbers), ""
        if abs(length - 1) > max(2 * half_digit(flat), ORTHONORMAL):
            found = f"the quaternion has the length {length:.6g}: divided by it"
        return _found(euler.from_quaternion(numbers if kind == "wxyz" else np.roll(numbers, 1)), found)
    if kind == "axis-angle":
        return _found(euler.from_axis_angle(numbers[:3], numbers[3], degrees=not radians))
    if kind == "vector":
        angle = np.linalg.norm(numbers)
        return _found(euler.from_axis_angle(numbers if angle else [0, 0, 1], angle, degrees=not radians))
    if count == 6:
        return _of_directions(kind, numbers[:3], numbers[3:])
    return _found(euler.matrix(kind, numbers, degrees=not radians))


def numbers(words: Iterable[str]) -> list[str]:
    """Return the numbers of words as they were written: brackets and separators go, a decimal comma is a point.

    Examples
    --------
    >>> numbers(["[[0.5,", "-1e-3],", "[0,5", "1;2]"])
    ['0.5', '-1e-3', '0.5', '1', '2']
    """
    text = " ".join(words).replace("−", "-").replace("°", " ")
    parts = re.sub(r"[\[\](){};|]", " ", text).split()
    found = []
    for part in parts:
        part = part.strip(",")
        decimal = part.count(",") == 1 and "." not in part
        found += [part.replace(",", ".")] if decimal else [each for each in part.split(",") if each]
    for each in found:
        try:
            float(each)
        except ValueError:
            raise InputError("rotation", "numbers", repr(each)) from None
    return found


def _found(matrix: np.ndarray, *sentences: str) -> Rotation:
    return Rotation(matrix, tuple(filter(None, sentences)))


def _of_directions(kind: str, first: np.ndarray, second: np.ndarray) -> Rotation:
    """Two axes of the turned frame, or a direction and what it is turned into."""
    one, two = unit(first, f"{kind}, the first direction"), unit(second, f"{kind}, the second direction")
    cosine, across = float(np.clip(one @ two, -1, 1)), np.cross(one, two)
    angle = float(np.degrees(np.arctan2(np.linalg.norm(across), cosine)))
    if kind == "from-to":
        if np.linalg.norm(across) > SAME:
            return _found(euler.from_axis_angle(across, angle, degrees=True))
        if cosine > 0:
            return _found(np.eye(3), "both directions are the same")
        said = "the directions are opposite: any axis square to them will do, this is one of them"
        square = np.cross(one, np.eye(3)[np.abs(one).argmin()])
        return _found(euler.from_axis_angle(square, 180, degrees=True), said)
    kept, other = kind.upper().split("-")
    if np.linalg.norm(across) < SAME:
        raise InputError(kind, "two directions that are not parallel", f"{angle:.4f}° between them")
    said = ""
    if abs(cosine) >= 1e-6:
        said = f"{angle:.4f}° between both directions: the first is kept, the second made square"
    sense = 1 if kept + other in ("XY", "YZ", "ZX") else -1
    third = sense * unit(across)
    axes = {kept: one, other: sense * unit(np.cross(third, one)), (set("XYZ") - {kept, other}).pop(): third}
    return _found(np.stack([axes[name] for name in "XYZ"], axis=1), said)


def _of_matrix(matrix: np.ndarray, half: float) -> Rotation:
    """A matrix, and how orthonormal it is.

    Of a rotation whose entries are off by `half` a digit at most, the nearest orthonormal matrix is no further,
    in the Frobenius norm, than the rounding itself: three times as much.
    """
    left, sizes, right = np.linalg.svd(matrix)
    nearest, determinant = left @ right, float(np.linalg.det(matrix))
    lengths, axes = (np.linalg.norm(matrix, axis=n) for n in (1, 0))
    said = f"determinant {determinant:.6g}, its rows have the lengths {row(lengths, 6)}"
    if sizes[-1] < SAME * max(sizes[0], SAME):
        return Rotation(np.eye(3), (said,), "The three axes lie in one plane: it turns nothing.", "No turn:")
    off = float(np.linalg.norm(matrix - nearest))
    digits, allowed = int(-np.log10(max(off / 1.5, 1e-15))), max(3 * half * (1 + 1e-6), ORTHONORMAL)
    exactly = f" to {digits} digit{'s' * (digits != 1)} after the point" * (digits < 14)
    found, fault = (said, f"orthonormal{exactly}" * (off <= allowed)), ""
    if off > allowed:
        between = {pair: _between(matrix, pair) for pair in ((0, 1), (0, 2), (1, 2))}
        worst = max(between, key=lambda pair: abs(between[pair] - 90))
        fault = f"Not orthonormal{' to its digits' * (half > 0)}, off by {off:.2g}: "
        if abs(between[worst] - 90) > np.degrees(allowed):
            fault += f"{'XYZ'[worst[0]]} and {'XYZ'[worst[1]]} axis are {between[worst]:.4f}° apart."
        elif np.ptp(axes) < 2 * allowed:
            fault += f"all axes have the length {axes.mean():.6g}, not 1."
        else:
            fault += f"the axes, its columns, have the lengths {row(axes, 6)}."
    if determinant > 0:
        return Rotation(nearest, tuple(filter(None, found)), fault, "The nearest rotation:" * bool(fault), half)
    turned = {n: nearest * np.where(np.arange(3) == n, -1, 1) for n in range(3)}
    angles = {n: float(euler.to_axis_angle(turned[n], degrees=True)[1]) for n in turned}
    least = min(angles, key=lambda n: (round(angles[n], 6), -n))
    others = " or ".join(f"{'XYZ'[n]} ({angles[n]:z.4f}°)" for n in angles if n != least)
    fault += " " * bool(fault) + "Determinant −1: a reflection, left-handed axes. No angles give it."
    remedy = f"With {'XYZ'[least]} (column {least + 1}) turned round it is a rotation, of the three ways the "
    remedy += f"smallest; with {others} it is another:"
    return Rotation(turned[least], tuple(filter(None, found)), fault, remedy, half)


def _between(matrix: np.ndarray, pair: tuple[int, int]) -> float:
    """Degrees between two columns."""
    one, two = (unit(matrix[:, n]) for n in pair)
    return float(np.degrees(np.arctan2(np.linalg.norm(np.cross(one, two)), one @ two)))
