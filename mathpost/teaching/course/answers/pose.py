"""A frame as an answer: its matrix, its quaternion, or three angles."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from mathpost import euler
from mathpost.detective.digits import written_decimals
from mathpost.errors import InputError
from mathpost.frame import Frame
from mathpost.rotation import wrap
from mathpost.teaching.course.answers.kind import Numbers
from mathpost.teaching.course.answers.numbers import ROUNDING, Number, Vector
from mathpost.teaching.course.typed import numbers

POSE_NAMES = [*map(str.split, ("I J K", "EULPR EULNU EULROT", "α β γ", "alpha beta gamma", "w x y z"))]


@dataclass(frozen=True, kw_only=True)
class Pose(Number):
    """A frame: its matrix, its quaternion of either sign, or its three angles or their twin.

    It is judged to the digits that were typed; angles need at least one. A quaternion is read as (w, x, y, z). If
    only (x, y, z, w) fits, as in SciPy, it is right too, with a remark.

    Examples
    --------
    >>> Pose().same([63.4, 48.2, 0], [63.4349, 48.1897, 0]), Pose().same([63.5, 48.2, 0], [63.4349, 48.1897, 0])
    (True, False)
    >>> Pose().same([90, 30, -90], [-90, -30, 90])
    True
    """

    decimals: int = 2
    sequence: str = "ZXZ"  # of three angles, as in `mathpost.euler`; degrees

    @property
    def asked(self) -> str:
        return f"three angles ({self.sequence}) in degrees to {self.decimals} decimals, or the matrix or quaternion"

    def read(self, answer: Any) -> Numbers:
        if isinstance(answer, Frame):
            answer = answer.rotation
        plain = answer.as_matrix() if hasattr(answer, "as_matrix") else answer
        array = numbers(plain, self.asked, "degrees", POSE_NAMES, (3, 4, 9))
        array = array.reshape((3, 3) if array.size == 9 else -1 if array.size < 5 else array.shape)
        if array.shape not in [(3,), (4,), (3, 3)]:
            raise InputError("answer", self.asked, f"numbers of shape {array.shape}")
        return array.tolist()

    def same(self, value: Numbers, target: Numbers) -> bool:
        if np.size(value) == 3 and written_decimals(value) == 1:
            return self._rounded(value, target, 1)
        return bool(np.abs(self._matrix(value) - self._matrix(target)).max() <= self._slack(value))

    def coarse(self, value: Numbers, target: Numbers) -> bool:
        return np.size(value) == 3 and written_decimals(value) == 0 and self._rounded(value, target, 0)

    def remark(self, value: Numbers, target: Numbers) -> str:
        if np.size(value) != 4 or not self.same(np.roll(value, 1), target):
            return ""
        return "Read in SciPy's order, (x, y, z, w); here a quaternion is written (w, x, y, z)."

    def mixups(self, target: Numbers) -> Iterator[tuple[str, Numbers]]:
        yield "That is the transpose: it takes coordinates the other way.", self._matrix(target).T
        if np.size(target) == 3:
            twin = euler.twin(self.sequence, target, degrees=True)
            for named in (target, twin):
                radians = np.radians(wrap(np.array(named)))
                if not self.same([0, 0, 0], radians):  # near it, nothing can be told apart from it
                    yield "Right, but in radians: answer in degrees.", radians
            yield from Vector(names="I J K").mixups(target)

    def nearly(self, value: Numbers, target: Numbers) -> str:
        if self.coarse(value, target):
            return f"Correct as far as its digits go. Answer with {self.asked}."
        apart = np.abs(self._matrix(value) - self._matrix(target)).max(axis=0)
        right = [name for name, far in zip("XYZ", apart, strict=True) if far <= self._slack(value)]
        return f"{right[0]} of the frame is right, the other two axes are not." if 0 < len(right) < 3 else ""

    def show(self, value: Numbers) -> str:
        return Vector(decimals=self.decimals if np.size(value) == 3 else 6).show(value)

    def _rounded(self, value: Numbers, target: Numbers, decimals: int) -> bool:
        """Return whether three angles are those of the target or its twin, each rounded to these decimals."""
        angles = euler.angles(self.sequence, self._matrix(target), degrees=True)
        names = [angles, euler.twin(self.sequence, angles, degrees=True)]
        bound = 0.5 * 10.0**-decimals * (1 + ROUNDING)
        return any(bool((np.abs(wrap(np.subtract(value, each))) <= bound).all()) for each in names)

    def _slack(self, value: Numbers) -> float:
        """Return how far an entry of the matrix may be off because of the rounding of the answer."""
        if np.size(value) == 3:
            return 3 * np.radians(self.bound)
        shown = written_decimals(value)
        if np.size(value) == 4:  # an entry of the matrix has products of two entries of q, twice each
            return 2 * 10.0 ** -min(max(shown, 2), 4) * (1 + ROUNDING)
        return 0.5 * 10.0 ** -min(max(shown, 2), 3) * (1 + ROUNDING)

    def _matrix(self, value: Numbers) -> np.ndarray:
        value = np.asarray(value, dtype=float)
        if value.shape == (3,):
            return euler.matrix(self.sequence, value, degrees=True)
        return euler.from_quaternion(value) if value.shape == (4,) else value
