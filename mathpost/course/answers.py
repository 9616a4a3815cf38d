"""What an exercise may ask for: a number, an angle, a vector, a pose, a name.

A kind of answer turns what the learner typed into plain data (numbers, text, lists of them, as in JSON), says when
two answers are the same, and knows the mix-ups that all answers of its kind share. It executes nothing, so a stored
answer can be read again safely.
"""

import re
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise, permutations
from typing import Any, ClassVar, Generic, TypeVar

import numpy as np

from mathpost import euler
from mathpost.course.typed import UNITS, bare, brief, counted, numbers
from mathpost.detective.digits import written_decimals
from mathpost.errors import InputError
from mathpost.frame import Frame
from mathpost.kinematics import Kinematics
from mathpost.rotation import wrap

POSE_NAMES = [*map(str.split, ("I J K", "EULPR EULNU EULROT", "α β γ", "alpha beta gamma", "w x y z"))]
ROUNDING = 1e-6  # share of the last digit that float rounding may add


Data = TypeVar("Data")  # what a kind makes of an answer
Numbers = float | list | np.ndarray  # a number, or lists of them


class Kind(ABC, Generic[Data]):
    """What all kinds have in common."""

    @property
    @abstractmethod
    def asked(self) -> str:
        """What to answer with, in words."""

    @abstractmethod
    def read(self, answer: Any) -> Data:
        """Return the answer as data, or raise an error."""

    @abstractmethod
    def show(self, value: Data) -> str:
        """Write a solution as one could type it."""

    def same(self, value: Data, target: Data) -> bool:
        """Whether two data are the same answer."""
        return value == target

    def coarse(self, value: Data, target: Data) -> bool:
        """Whether they agree to the digits that the value has, but those are too few."""
        return False

    def mixups(self, target: Data) -> Iterable[tuple[str, Data]]:
        """Yield the common mix-ups: a sentence and the wrong answer that each leads to."""
        return ()

    def nearly(self, value: Data, target: Data) -> str:
        """Say which part of a wrong answer is right, if any."""
        return ""

    def remark(self, value: Data, target: Data) -> str:
        """Say under which different but usual reading the answer is right; empty if there is none."""
        return ""


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
    >>> Angle(decimals=2).same(353.44, -6.5624), Pose().same([90, 30, -90], [-90, -30, 90])
    (True, True)
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
        array = numbers(answer, self.asked, self.unit, [names] if names else ())
        if array.size != (len(names) or 1):
            raise InputError("answer", self.asked, counted(array.size))
        return array.ravel().tolist() if names else array.item()  # a row or a column matrix will do

    def near(self, value: Numbers, target: Numbers) -> np.ndarray:
        """Which of the numbers are right, one by one."""
        apart = np.ravel(np.subtract(value, target))
        return np.abs(apart if np.isinf(self.period) else wrap(apart, self.period)) <= self.bound

    def same(self, value: Numbers, target: Numbers) -> bool:
        return bool(self.near(value, target).all())

    def coarse(self, value: Numbers, target: Numbers) -> bool:
        shown = written_decimals(value)
        too_few = 0.5 * 10.0**-shown > self.bound and np.abs(value).max() * 10.0**shown >= 10
        return bool(too_few) and replace(self, decimals=shown, tolerance=None).same(value, target)

    def mixups(self, target: Numbers) -> Iterator[tuple[str, Numbers]]:
        target, names = np.asarray(target), self.names.split()
        yield "Right size, wrong sign: which body turns, and which way do you look at it?", -target
        for unit, factor in UNITS.get(self.unit, ("", {}))[1].items():
            if np.abs(factor * target).max() < self.period:  # further round, it would be the same as anything
                yield f"Right, but in {unit}: answer in {self.unit}.", factor * target
        for number, name in enumerate(names):
            yield f"Only the sign of {name} is wrong.", np.where(np.arange(len(names)) == number, -1, 1) * target
        for order in permutations(range(len(names))) if names else ():
            yield "The right numbers in a different order.", target[list(order)]
        factors = [("That is twice the right answer.", 2 * target)]
        factors.append(("That is half of the right answer.", target / 2))
        if not names and target and np.isinf(self.period):
            factors.append(("That is one over the right number.", 1 / target))
        for sentence, wrong in factors:
            if np.abs(wrong).max() >= 10 * self.bound:  # a single digit may come from anything
                yield sentence, wrong

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
    """Rotary joints in degrees, or all five, compared as poses: every branch and every whole turn is right."""

    kinematics: Callable[[], Kinematics]
    names: str = "B C"
    unit: str = "degrees"

    def same(self, value: Numbers, target: Numbers) -> bool:
        target, count = np.asarray(target), np.size(target)
        joints = np.zeros((2, 5))
        joints[:, -count:] = value, target
        poses = self.kinematics().forward(joints, degrees=True)
        moved, leaned = (np.linalg.norm(np.subtract(*pair)) for pair in poses)
        turned = np.radians(self.bound) * 2  # both rotary joints are rounded
        near = count < 5 or moved <= 2 * self.bound + turned * np.linalg.norm(target[:-2])
        return bool(leaned <= turned and near)  # the tip says nothing if only rotary joints are asked for


@dataclass(frozen=True, kw_only=True)
class Pose(Number):
    """A frame: its matrix, its quaternion of either sign, or its three angles or their twin.

    It is judged to the digits that were typed, at least one of angles. A quaternion is read as (w, x, y, z). If
    only (x, y, z, w) fits, as in SciPy, that is right too, and said.

    Examples
    --------
    >>> Pose().same([63.4, 48.2, 0], [63.4349, 48.1897, 0]), Pose().same([63.5, 48.2, 0], [63.4349, 48.1897, 0])
    (True, False)
    """

    decimals: int = 2
    sequence: str = "ZXZ"  # of three angles, as in `mathpost.euler`; degrees
    origin: bool = False  # if it has one, the answer is a 4×4 matrix or a `mathpost.frame.Frame`

    @property
    def asked(self) -> str:
        if self.origin:
            return f"a frame as a 4×4 matrix, its origin to {self.decimals} decimals"
        return f"three angles ({self.sequence}) in degrees to {self.decimals} decimals, or the matrix or quaternion"

    def read(self, answer: Any) -> Numbers:
        if isinstance(answer, Frame):
            answer = answer.matrix if self.origin else answer.rotation
        plain = answer.as_matrix() if hasattr(answer, "as_matrix") else answer
        array = numbers(plain, self.asked, "degrees", POSE_NAMES)
        array = array.reshape({9: (3, 3), 16: (4, 4)}.get(array.size, -1 if array.size < 5 else array.shape))
        if array.shape not in ([(4, 4)] if self.origin else [(3,), (4,), (3, 3)]):
            raise InputError("answer", self.asked, f"numbers of shape {array.shape}")
        return array.tolist()

    def same(self, value: Numbers, target: Numbers) -> bool:
        if np.size(value) == 3 and written_decimals(value) == 1:
            return self._rounded(value, target, 1)
        one, other = self._matrix(value), self._matrix(target)
        near = np.abs(one[:3, :3] - other[:3, :3]).max() <= self._slack(value)
        return bool(near and np.abs(one[:3, 3:] - other[:3, 3:]).max(initial=0) <= self.bound)

    def coarse(self, value: Numbers, target: Numbers) -> bool:
        return np.size(value) == 3 and written_decimals(value) == 0 and self._rounded(value, target, 0)

    def remark(self, value: Numbers, target: Numbers) -> str:
        if np.size(value) != 4 or not self.same(np.roll(value, 1), target):
            return ""
        return "Read in SciPy's order, (x, y, z, w); here a quaternion is written (w, x, y, z)."

    def mixups(self, target: Numbers) -> Iterator[tuple[str, Numbers]]:
        inverse = np.array(self._matrix(target))
        inverse[:3, :3] = inverse[:3, :3].T
        yield "That is the transpose: it takes coordinates the other way.", inverse
        if self.origin:
            yield "That is the inverse: it takes coordinates the other way.", np.linalg.inv(self._matrix(target))
        if np.size(target) == 3:
            twin = euler.twin(self.sequence, target, degrees=True)
            for named in (target, twin):
                yield "Right, but in radians: answer in degrees.", np.radians(wrap(np.array(named)))
            yield from Vector(names="I J K", unit="degrees").mixups(target)

    def nearly(self, value: Numbers, target: Numbers) -> str:
        if self.coarse(value, target):
            return f"Correct as far as its digits go. Answer with {self.asked}."
        apart = np.abs(self._matrix(value) - self._matrix(target))[:3].max(axis=0)
        right = [name for name, far in zip("XYZ", apart, strict=False) if far <= self._slack(value)]
        if len(right) == 3:
            return "The axes are right, the origin is not." if self.origin else ""
        return f"{right[0]} of the frame is right, the other two axes are not." if right else ""

    def show(self, value: Numbers) -> str:
        return Vector(decimals=self.decimals if np.size(value) == 3 else 6).show(value)

    def _rounded(self, value: Numbers, target: Numbers, decimals: int) -> bool:
        """Whether three angles are those of the target or its twin, each rounded to these decimals."""
        angles = euler.angles(self.sequence, self._matrix(target), degrees=True)
        names = [angles, euler.twin(self.sequence, angles, degrees=True)]
        bound = 0.5 * 10.0**-decimals * (1 + ROUNDING)
        return any(bool((np.abs(wrap(np.subtract(value, each))) <= bound).all()) for each in names)

    def _slack(self, value: Numbers) -> float:
        """How far an entry of the matrix may be off, by the rounding of what was typed."""
        if np.size(value) == 3:
            return 3 * np.radians(self.bound)
        shown = written_decimals(np.asarray(value)[:3])
        if np.size(value) == 4:  # an entry of the matrix has products of two entries of q, twice each
            return 2 * 10.0 ** -min(max(shown, 2), 4) * (1 + ROUNDING)
        return 0.5 * 10.0 ** -min(max(shown, 2), 3) * (1 + ROUNDING)

    def _matrix(self, value: Numbers) -> np.ndarray:
        value = np.asarray(value, dtype=float)
        if value.shape == (3,):
            return euler.matrix(self.sequence, value, degrees=True)
        return euler.from_quaternion(value) if value.shape == (4,) else value


@dataclass(frozen=True)
class Written(Kind[Numbers]):
    """A function that the learner wrote. It is judged, and stored, by what it returns at inputs drawn at random.

    Examples
    --------
    >>> double = Written("double(x)", lambda rng: [rng.uniform(-1, 1)])
    >>> double.same(double.read(lambda x: x + x), double.read(lambda x: 2 * x))
    True
    """

    signature: str  # such as "Rz(t)"
    draw: Callable[[np.random.Generator], Iterable]  # returns the arguments of one call
    count: ClassVar[int] = 6

    @property
    def asked(self) -> str:
        return f"a function {self.signature}"

    @property
    def inputs(self) -> list[tuple]:
        rng = np.random.default_rng(7)
        return [tuple(self.draw(rng)) for _ in range(self.count)]

    def read(self, answer: Any) -> Numbers:
        if callable(answer):
            try:
                answer = [np.asarray(answer(*inputs), dtype=float).tolist() for inputs in self.inputs]
            except Exception as error:  # somebody's own function may raise anything
                found = f"one that raises {type(error).__name__}: {error}"
                raise InputError("answer", self.asked, found[:120]) from None
        array = np.array(answer, dtype=float)
        if len(array) != self.count or not np.isfinite(array).all():
            raise InputError("answer", self.asked, "something else")
        return array.tolist()

    def same(self, value: Numbers, target: Numbers) -> bool:
        return np.shape(value) == np.shape(target) and bool(np.allclose(value, target, atol=1e-6))

    def mixups(self, target: Numbers) -> Iterator[tuple[str, Numbers]]:
        target = np.array(target)
        yield "Right size, wrong sign.", -target
        if target.ndim == 3 and target.shape[1] == target.shape[2]:
            yield "That is the transpose: rows and columns are exchanged.", np.moveaxis(target, 1, 2)

    def nearly(self, value: Numbers, target: Numbers) -> str:
        wanted, found = np.shape(target)[1:], np.shape(value)[1:]
        return "" if wanted == found else f"It returns an array of shape {found}, not {wanted}."

    def show(self, value: Numbers) -> str:
        return f"the right result at {self.count} inputs drawn at random"


@dataclass(frozen=True)
class _Listed(Kind[Data]):
    """Of several names."""

    choices: str | Mapping[str, Sequence[str]]  # in one string, or each with its synonyms, such as the Chinese

    @property
    def known(self) -> dict[str, str]:
        """A dict of each spelling to its name."""
        if isinstance(self.choices, str):
            return {bare(name): name for name in self.choices.split()}
        return {bare(said): name for name, others in self.choices.items() for said in (name, *others)}

    @property
    def listed(self) -> list[str]:
        """Every name once."""
        return list(dict.fromkeys(self.known.values()))

    @property
    def shown(self) -> str:
        """The names in words, of many the first three."""
        names = self.listed
        return f"of {', '.join(names)}" if len(names) <= 12 else f"such as {', '.join(names[:3])}"

    def one(self, answer: Any) -> str:
        """Return the one name that an answer holds."""
        if isinstance(answer, (list, tuple)) and len(answer) == 1:
            (answer,) = answer
        letters = re.sub(r"\bthen\b|[\W\d_]", " ", str(answer)).split()
        if bare(answer) not in self.known and len(letters) > 1 and max(map(len, letters)) == 1:
            answer = "".join(letters)  # Z-X'-Y'', Z → X → Y, ["Z", "X", "Y"]
        words = {bare(answer)} if bare(answer) in self.known else {bare(word) for word in str(answer).split()}
        for first, second in pairwise(str(answer).split()):  # "the cubic lifted"
            if bare(first + second) in self.known:
                words = words - {bare(first), bare(second)} | {bare(first + second)}
        found = {self.known[word] for word in words if word in self.known}  # "the z axis"
        plain = all(word.isalpha() for word in words - set(self.known)) and not {"not", "no", "nor"} & words
        if len(found) == 1 and plain:
            return found.pop()
        raise InputError("answer", self.asked, brief(answer))


@dataclass(frozen=True)
class Name(_Listed[str]):
    """One of several names; case, spaces, quotes, primes, brackets and what joins letters do not matter.

    Examples
    --------
    >>> Name("x y z").read(" 'Z′' "), Name({"active": ["主动"], "passive": ["被动"]}).read("主动")
    ('z', 'active')
    >>> Name("ZXY ZYX").read("z-x'-y''"), Name("Z -Z").read("-Z")
    ('ZXY', '-Z')
    >>> Name({"cubic": [], "cubic lifted": []}).read("the cubic lifted")
    'cubic lifted'
    """

    @property
    def asked(self) -> str:
        return f"{'one' if self.shown.startswith('of') else 'a name'} {self.shown}"

    def read(self, answer: Any) -> str:
        return self.one(answer)

    def show(self, value: str) -> str:
        return value


@dataclass(frozen=True)
class Names(_Listed[list[str]]):
    """Some of several names, in any order: a list, a set, or one string."""

    about: Callable[[str], str | None] | None = None  # says why a name does not belong

    @property
    def asked(self) -> str:
        return f"a list of names: some {self.shown}"

    def read(self, answer: Any) -> list[str]:
        if isinstance(answer, str):
            parts = re.split(r"[,;，、；/]+|\band\b|和|与", answer.strip("[](){} "))
            listed = [part.split() if {*map(bare, part.split())} <= set(self.known) else [part] for part in parts]
            answer = [name for names in listed for name in names if bare(name)]
        found = {self.one(each) for each in np.asarray(list(answer), dtype=object).ravel()}
        return [name for name in self.listed if name in found]

    def mixups(self, target: list[str]) -> Iterator[tuple[str, list[str]]]:
        others = [name for name in self.listed if name not in target]
        yield "These are the others: exactly those that do not belong.", others

    def nearly(self, value: list[str], target: list[str]) -> str:
        for name in value:
            if name not in target:
                return f"{name} does not belong here. {self.about(name) if self.about else ''}".strip()
        return "All of these belong, but there are more." if value else "There are some."

    def show(self, value: list[str]) -> str:
        return ", ".join(value)
