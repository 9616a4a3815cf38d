"""Numbers as answers: one, an angle, several, joints."""

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from itertools import permutations
from typing import Any, ClassVar

import numpy as np

from mathpost.detective.digits import written_decimals
from mathpost.errors import InputError
from mathpost.kinematics import Kinematics
from mathpost.rotation import wrap
from mathpost.teaching.course.answers.kind import Kind, Numbers
from mathpost.teaching.course.typed import UNITS, counted, numbers

ROUNDING = 1e-6  # share of the last digit that float rounding may add


@dataclass(frozen=True, kw_only=True)
class Number(Kind[Numbers]):
    """One number. It is right if it is correctly rounded to the decimals asked for.

    Examples
    --------
    >>> Number(decimals=2, unit="mm").asked
    'one number in mm, to 2 decimals'
    >>> Number(decimals=2).same(74.46, 74.4577), Number(decimals=2).same(74.5, 74.4577)
    (True, False)
    >>> Number(unit="mm").read("−77.7 mm"), Vector(names="B C", unit="degrees").read("B52.4° C = -24.6°")
    (-77.7, [52.4, -24.6])
    >>> Angle(decimals=2).same(353.44, -6.5624)
    True
    """

    decimals: int | None = 3  # None where there are many solutions and the exercise judges them itself
    tolerance: float | None = None  # if it is not half of the last digit
    unit: str = ""  # such as "mm"
    said: str = ""  # instead of "one number"
    names: str = ""  # if there are several numbers: their names in one string
    period: ClassVar[float] = np.inf

    @property
    def asked(self) -> str:
        names = self.names.split()
        what = self.said or (f"{counted(len(names))} ({', '.join(names)})" if names else "one number")
        few = {None: "", 0: ", to the whole number", 1: ", to 1 decimal"}
        exact = few.get(self.decimals, f", to {self.decimals} decimals")
        exact = exact if self.tolerance is None else f", within ±{self.tolerance:g}"
        return f"{what}{f' in {self.unit}' if self.unit else ''}{exact}"

    @property
    def bound(self) -> float:
        """How far off a right answer may be."""
        half_digit = 0.5 * 10.0 ** -(self.decimals or 0)
        return (half_digit if self.tolerance is None else self.tolerance) * (1 + ROUNDING)

    def read(self, answer: Any) -> Numbers:
        names = self.names.split()
        digits = str(answer).strip()
        if names and self.decimals == 0 and re.fullmatch(rf"\d{{{len(names)}}}", digits, re.ASCII):  # "23332"
            answer = [float(digit) for digit in digits]
        array = numbers(answer, self.asked, self.unit, [names] if names else (), [len(names) or 1])
        if array.size != (len(names) or 1):
            raise InputError("answer", self.asked, counted(array.size))
        return array.ravel().tolist() if names else array.item()  # a row or a column matrix will do

    def near(self, value: Numbers, target: Numbers) -> np.ndarray:
        """Return which of the numbers are right."""
        apart = np.ravel(np.subtract(value, target))
        bound = np.full(apart.shape, self.bound)
        if self.decimals == 0 and self.tolerance is None:  # 90.4 is not 90, rounded
            bound[np.ravel(value) != np.round(np.ravel(value))] /= 10
        return np.abs(apart if np.isinf(self.period) else wrap(apart, self.period)) <= bound

    def same(self, value: Numbers, target: Numbers) -> bool:
        return bool(self.near(value, target).all())

    def coarse(self, value: Numbers, target: Numbers) -> bool:
        shown = written_decimals(value)
        too_few = 0.5 * 10.0**-shown > self.bound and np.abs(value).max() * 10.0**shown >= 10
        return bool(too_few) and replace(self, decimals=shown, tolerance=None).same(value, target)

    def mixups(self, target: Numbers) -> Iterator[tuple[str, Numbers]]:
        target, names = np.asarray(target), self.names.split()
        yield "Right size, wrong sign: which body turns, and which way do you look at it?", -target
        yield from self.units(target)
        for number, name in enumerate(names):
            yield f"Only the sign of {name} is wrong.", np.where(np.arange(len(names)) == number, -1, 1) * target
        for order in permutations(range(len(names))) if names else ():
            yield "The right numbers in a different order.", target[list(order)]
        factors = [("That is twice the right answer.", 2 * target)]
        factors.append(("That is half of the right answer.", target / 2))
        if not names and target and np.isinf(self.period):
            factors.append(("That is one over the right number.", 1 / target))
        for sentence, wrong in factors:
            if np.abs(wrong).max() >= 10 * self.bound:  # a single digit can have any cause
                yield sentence, wrong

    def units(self, target: Numbers) -> Iterator[tuple[str, Numbers]]:
        """Yield the answer in each unit that it is mixed up with, where no different answer is so near to it."""
        target = np.asarray(target)
        for unit, factor in UNITS.get(self.unit, ("", {}))[1].items():
            size = np.abs(factor * target).max()
            turn = 360.0 if self.unit == "degrees" else np.inf  # beyond it, it could equal any answer
            least = 20 * self.bound / (1 if self.decimals else 10)  # nearer to zero, rounding makes it any number
            if least < size < turn:
                yield f"Right, but in {unit}: answer in {self.unit}.", factor * target

    def nearly(self, value: Numbers, target: Numbers) -> str:
        if self.coarse(value, target):
            return f"Correct as far as its digits go. Answer with {self.asked}."
        names = self.names.split()
        right = [name for name, near in zip(names, self.near(value, target), strict=False) if near]
        look = ", ".join(name for name in names if name not in right)
        return f"Right: {', '.join(right)}. Look once more at {look}." if right else ""

    def show(self, value: Numbers) -> str:
        return ", ".join(f"{each:z.{self.decimals or 0}f}" for each in np.ravel(value))


@dataclass(frozen=True, kw_only=True)
class Angle(Number):
    """One angle in degrees, modulo 360."""

    unit: str = "degrees"
    said: str = "one angle"
    period: ClassVar[float] = 360.0

    def mixups(self, target: Numbers) -> Iterator[tuple[str, Numbers]]:
        yield from super().mixups(target)
        target = np.asarray(target)
        yield "That is what is missing to 90°: it is measured from the other axis.", 90 - target
        yield "That is half a turn away.", 180 + target
        yield "That is what is missing to 180°.", 180 - target


@dataclass(frozen=True, kw_only=True)
class Vector(Number):
    """Several numbers: a list, tuple, array, row or column matrix, text, or a dict by name."""

    names: str = "x y z"


@dataclass(frozen=True, kw_only=True)
class Joints(Vector):
    """Two rotary joints in degrees, compared as poses: every branch and every whole turn is right."""

    kinematics: Callable[[], Kinematics]
    names: str = "B C"
    unit: str = "degrees"

    def same(self, value: Numbers, target: Numbers) -> bool:
        joints = np.zeros((2, 5))
        joints[:, 3:] = value, target
        _, axes = self.kinematics().forward(joints, degrees=True)
        return bool(np.linalg.norm(np.subtract(*axes)) <= 2 * np.radians(self.bound))  # both joints are rounded
