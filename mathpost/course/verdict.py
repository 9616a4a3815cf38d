"""One exercise: its solution, its typical mistakes, all of them computed, and what to say of an answer.

The exercises of the lessons stand in `mathpost.course.exercises_rotation` and its neighbours; the learner meets
them through `mathpost.course.exercise`.
"""

import ast
import inspect
import os
import textwrap
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from itertools import permutations
from pathlib import Path

import numpy as np

from mathpost.errors import InputError, MathpostError

TASKS = {}
ANYTHING = "what the question asks for"
OPEN, WRONG, RIGHT = "not attempted yet", "not yet", "right"


@dataclass(frozen=True)
class Verdict:
    """What is said of an answer: `status` is `OPEN`, `WRONG` or `RIGHT`, `why` a sentence or more."""

    name: str
    status: str
    why: str = ""

    def __str__(self):
        return f"{self.name} · {self.status}." + (f" {self.why}" if self.why else "")


@dataclass(frozen=True)
class Task:
    """An exercise.

    Attributes
    ----------
    name : str
        Two digits of the lesson and a word, such as ``"07-pivot"``.
    solve : callable
        Returns the solution: numbers, a word, a set of words, or, with a `judge`, one of the answers that it
        accepts. Its docstring says what the exercise teaches; its body is shown.
    tolerance : float
        How far each number may be from the solution's.
    wrong : dict
        The sentence that names a mistake, to a callable that returns the answer to which that mistake leads.
    seen_as : callable or None
        What is compared in place of the answer: the matrix of three angles, so that twins are equal.
    judge : callable or None
        For exercises with many solutions: returns what is wrong with an answer, or "" if nothing is.
    detective : callable or None
        Returns a `mathpost.detective.misreadings.Explanation` of an answer that is none of `wrong`.
    given : callable or None
        Returns what the question hands out, such as a program with an error in it.
    """

    name: str
    solve: Callable
    tolerance: float
    wrong: dict
    seen_as: Callable | None = None
    judge: Callable | None = None
    detective: Callable | None = None
    given: Callable | None = None

    @cached_property
    def solution(self):
        """What `solve` returns, computed once."""
        return self.solve()

    @property
    def code(self):
        """The body of `solve` without its docstring, as text."""
        source = textwrap.dedent(inspect.getsource(self.solve))
        function = ast.parse(source).body[0]
        first = next(
            node
            for node in function.body
            if not (isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant))
        )
        return textwrap.dedent("\n".join(source.splitlines()[first.lineno - 1 :]))

    def verdict(self, answer):
        """Judge an answer; whatever it is, nothing is raised."""
        if answer is None or (isinstance(answer, (list, tuple)) and any(each is None for each in answer)):
            return Verdict(self.name, OPEN)
        try:
            why = self._difference(answer)
        except MathpostError as error:
            why = f"The answer cannot be used: {error}."
        except (TypeError, ValueError, IndexError, KeyError, AttributeError):
            why = f"This is not {_described(self.solution)}."
        return Verdict(self.name, WRONG, why) if why else Verdict(self.name, RIGHT, inspect.getdoc(self.solve))

    def _difference(self, answer):
        """Return why the answer is not a solution, or "" if it is one."""
        if isinstance(self.solution, (str, set)):
            return self._difference_of_words(answer)
        if _described(self.solution) == ANYTHING:
            return self.judge(answer)
        values, target = np.asarray(answer, dtype=float), np.asarray(self.solution, dtype=float)
        if values.size != target.size or not np.isfinite(values).all():
            return f"Expected {_described(self.solution)}, found {_described(values)}."
        values = values.reshape(target.shape)  # a row or a column matrix will do
        if self.judge:
            return self.judge(values)
        if self._same(values, target):
            return ""
        for sentence, leads_to in self.wrong.items():
            if self._same(values, np.asarray(leads_to(), dtype=float)):
                return sentence
        explained = self._explained(answer)
        return (
            explained or _general_slip(values, target, self._same) or _what_is_right(values, target, self.tolerance)
        )

    def _same(self, one, other):
        if self.seen_as:
            one, other = self.seen_as(one), self.seen_as(other)
        return np.abs(one - other).max() <= self.tolerance

    def _difference_of_words(self, answer):
        given, target = _words(answer, self.solution), _words(self.solution, self.solution)
        if given == target:
            return ""
        for sentence, leads_to in self.wrong.items():
            if given == _words(leads_to(), self.solution):
                return sentence
        if isinstance(self.solution, set):
            right, extra, lacking = len(given & target), len(given - target), len(target - given)
            return f"Of yours {right} belong here and {extra} do not; {lacking} are missing."
        return "That is not it; read the question once more."

    def _explained(self, answer):
        """The detective's sentence for the answer, or "" if it has none."""
        found = self.detective(answer) if self.detective else None
        if found is None or not found.explained or found.right:
            return ""
        sentence = str(found.misreadings[0])
        return sentence[0].upper() + sentence[1:] + "."


def exercise(name, *, tolerance=5e-4, wrong=None, **how):
    """Enter the decorated function as the solution of the exercise `name`; the rest are attributes of `Task`."""

    def enter(solve):
        if name in TASKS:
            raise InputError("exercise", "a name of its own", repr(name))
        TASKS[name] = Task(name, solve, tolerance, wrong or {}, **how)
        return solve

    return enter


def data(path):
    """Return the path of a file in the course's data folder, sought from the working folder upwards."""
    for folder in (Path.cwd(), *Path.cwd().parents, Path(__file__).parents[2]):
        if (found := folder / "data" / path).exists():
            return Path(os.path.relpath(found))
    raise InputError("data", "the folder `data` of the course above the working folder", f"no data/{path}")


def _words(answer, like):
    """The answer as a lower-case word, or as a set of them."""
    if isinstance(like, str):
        return str(answer).strip().lower()
    return {str(each).strip().lower() for each in ([answer] if isinstance(answer, str) else answer)}


def _described(value):
    """Say what kind of thing an answer is."""
    if isinstance(value, str):
        return "one word"
    if isinstance(value, set):
        return "a list of words"
    try:
        shape = np.shape(np.asarray(value, dtype=float))
    except (TypeError, ValueError):
        return ANYTHING
    if not np.isfinite(np.asarray(value, dtype=float)).all():
        return "something that is not a finite number"
    return "one number" if shape == () else f"{shape[0]} numbers" if len(shape) == 1 else f"shape {shape}"


def _general_slip(values, target, same):
    """Name a slip that any number can suffer: sign, order, unit, or too few digits."""
    if same(-values, target):
        return "Right size, wrong sign: which body turns, and which way do you look at it?"
    for factor, slip in (
        (np.rad2deg(1), "this is in radians, degrees were asked for"),
        (np.deg2rad(1), "this is in degrees, radians were asked for"),
        (1e-3, "a thousand times too much: mm or µm?"),
        (1e3, "a thousand times too little: mm or µm?"),
        (3600.0, "this is in degrees, arcseconds were asked for"),
        (1 / 3600, "this is in arcseconds, degrees were asked for"),
        (0.5, "twice too much"),
        (2.0, "half of it"),
    ):
        if np.abs(target).max() > 0 and same(values * factor, target):
            return f"Right digits, but {slip}."
    if values.ndim == 1 and 1 < len(values) <= 5:
        signs = [1 - 2 * (np.arange(len(values)) == row) for row in range(len(values))]
        for row, sign in enumerate(signs):
            if same(values * sign, target):
                return f"Only the sign of number {row + 1} is wrong."
        if any(same(values[list(order)], target) for order in permutations(range(len(values)))):
            return "The right numbers in another order."
    return ""


def _what_is_right(values, target, tolerance):
    if values.ndim == 0:
        direction = "too great" if values > target else "too small"
        if abs(values - target) <= 0.01 * max(abs(target), tolerance):
            return f"Nearly: a little {direction}; keep more digits on the way."
        return f"It is {direction}."
    right = int((np.abs(values - target) <= tolerance).sum())
    return f"{right} of {values.size} numbers are right."
