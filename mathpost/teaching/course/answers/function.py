"""A function as an answer, judged by its results."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from mathpost.errors import InputError
from mathpost.teaching.course.answers.kind import Kind, Numbers


@dataclass(frozen=True)
class Written(Kind[Numbers]):
    """A function that the learner wrote, judged and stored by its results at inputs drawn at random.

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
            ready = str(getattr(answer, "__module__", "")).split(".")[0]
            if ready in ("numpy", "scipy", "sympy", "math"):
                found = f"{getattr(answer, '__name__', 'a function')} of {ready}: write your own"
                raise InputError("answer", self.asked, found)
            try:
                results = [answer(*inputs) for inputs in self.inputs]
                if any(result is None for result in results):
                    raise InputError("answer", self.asked, "one that returns nothing: does it lack its return?")
                answer = [np.asarray(result, dtype=float).tolist() for result in results]
            except InputError:
                raise
            except Exception as error:  # a learner's function may raise anything
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
