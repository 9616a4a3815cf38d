"""One exercise: its solution, the mix-ups that lead to wrong answers, all computed, and the verdict on an answer.

The exercises of the lessons are in `mathpost.teaching.course.exercises.rotation` and its neighbours, their texts in
`exercises.toml`. Learners, and teachers who write exercises, use them through `mathpost.teaching.course.exercise`.
"""

from __future__ import annotations

import ast
import inspect
import json
import random
import re
import textwrap
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cache, cached_property, partial
from pathlib import Path
from typing import Any

from mathpost.detective.explanation import Explanation
from mathpost.errors import InputError, MathpostError
from mathpost.files import read_toml
from mathpost.teaching.course.answers import Kind, Name, Names, Written
from mathpost.teaching.course.typed import brief

Solution = Callable[..., Any]
EXERCISES: dict[str, Exercise] = {}
OPEN, WRONG, RIGHT = "not attempted yet", "not yet", "right"
MIME = "application/vnd.mathpost+json"  # of the answer stored beside its verdict in a saved notebook
UNREADABLE = "unreadable"
NO_MIXUP = "None of the usual mix-ups gives this."


@dataclass(frozen=True)
class Verdict:
    """The verdict on an answer."""

    name: str  # of the exercise
    status: str  # OPEN, WRONG or RIGHT
    why: str = ""
    answer: Any = None  # as in JSON; if it could not be read, a dict of what was found instead
    edited: bool = False  # whether the saved notebook gave a different verdict
    mixup: str = ""  # the sentence that names the mix-up, if one gives this answer
    student: str = ""  # whose numbers were used; "" for those of the lesson

    def __str__(self) -> str:
        return f"{self.name} · {self.status}." + (f" {self.why}" if self.why else "")

    def _repr_mimebundle_(self, include: Any = None, exclude: Any = None) -> dict[str, Any]:
        data = {"answer": self.answer, "exercise": self.name}  # as sorted in a file
        return {"text/plain": str(self), MIME: data | ({"student": self.student} if self.student else {})}


@dataclass(frozen=True)
class Exercise:
    """An exercise, made by `define`. Its functions may name arguments of the solution, and are called with them."""

    name: str  # unique
    kind: Kind  # of answer, from `mathpost.teaching.course.answers`, such as ``Angle(decimals=2)``
    solve: Solution  # its docstring says why the answer is right; its source is shown
    slips: dict[str, dict[str, Any]] = field(default_factory=dict)  # sentence → the other arguments of `slip`
    hint: str = ""  # shown if no mix-up gives the answer
    complaint: Callable[..., str] | None = None  # if there are many solutions: what is wrong with an answer, or ""
    detective: Callable[..., Explanation] | None = None  # explains an answer that no slip gives
    given: Callable | None = None  # the material of the question, such as a program with an error in it
    drawn: Callable[[random.Random], dict[str, Any]] | None = None  # arguments drawn for one student
    together: str = ""  # exercises with the same word here draw the same
    student: str = ""  # whose numbers were drawn; "" for those of the lesson

    @cached_property
    def of(self) -> Callable[[str], Exercise]:
        """The exercise with a student's own numbers, cached; the exercise itself if it draws none."""
        return cache(lambda student: replace(self, student=student) if student and self.drawn else self)

    @cached_property
    def arguments(self) -> dict[str, Any]:
        """The arguments of the solution: its defaults, or those drawn for the student."""
        stated = inspect.signature(self.solve).parameters.items()
        found = {name: each.default for name, each in stated if each.default is not each.empty}
        if self.student and self.drawn:
            found |= self.drawn(random.Random(f"{self.together or self.name} {self.student}"))
        return found

    def with_arguments(self, function: Callable, *values: Any) -> Any:
        """Call a function with `values` and those arguments of the solution that it names."""
        named = list(inspect.signature(function).parameters)[len(values) :]
        return function(*values, **{key: value for key, value in self.arguments.items() if key in named})

    def read(self, answer: Any) -> Any:
        """Return the answer as data, or raise `InputError`."""
        try:
            return self.kind.read(answer)
        except (TypeError, ValueError, LookupError, AttributeError, OverflowError) as error:
            found = error.found if isinstance(error, InputError) else brief(answer)
            raise InputError(f"exercise {self.name}", self.kind.asked, found) from None

    @cached_property
    def solution(self) -> Any:
        """The solution as data, computed once and checked by its own `complaint`."""
        value = self.read(self.with_arguments(self.solve))
        if self.complaint and (why := self.with_arguments(self.complaint, value)):
            raise InputError(f"exercise {self.name}", "a solution that has nothing wrong", f"{value}: {why}")
        return value

    @cached_property
    def mixed_up(self) -> list[tuple[str, Any]]:
        """Pairs of the sentence of each slip and the answer that it gives, as data.

        A slip may be harmless with numbers that are drawn; of an exercise that draws none it is an error.
        """
        found = [(said, self.read(self._slipped(**slip))) for said, slip in self.slips.items()]
        right = [each for each in found if not self.complaint and self.kind.same(each[1], self.solution)]
        for said, value in right if not self.drawn else ():
            raise InputError(f"exercise {self.name}", "a slip that gives a wrong answer", f"{value}: {said}")
        return [each for each in found if each not in right]

    def _slipped(self, answer: Any = None, **changed: Any) -> Any:
        if answer is None:
            return self.solve(**self.arguments | changed)
        return self.with_arguments(answer) if callable(answer) else answer

    @cached_property
    def common(self) -> list[tuple[str, Any]]:
        """Pairs as in `mixed_up` for the mix-ups that are common to its kind of answer."""
        found = self.kind.mixups(self.solution)
        return [(sentence, value) for sentence, value in found if not self.kind.same(value, self.solution)]

    @property
    def source(self) -> str:
        """The source of the solution, without decorators and docstring, after what it needs from elsewhere."""
        lines = textwrap.dedent(inspect.getsource(self.solve)).splitlines()
        function = next(each for each in ast.parse("\n".join(lines)).body if isinstance(each, ast.FunctionDef))
        described, *rest = function.body
        if isinstance(self.kind, Written):  # only the function that the learner is to write
            shown = textwrap.dedent("\n".join(lines[rest[0].lineno - 1 : rest[0].end_lineno]))
        else:
            head = lines[function.lineno - 1 : described.lineno - 1]
            body = lines[(rest[0].lineno if self.solve.__doc__ else described.lineno) - 1 :]
            shown = "\n".join([*head, *body])
        return "\n".join([*self._needed(shown), shown])

    def _needed(self, shown: str) -> list[str]:
        """Return the lines that define the names a solution uses: plain constants, and imports by module."""
        function = ast.parse(shown).body[0]
        assert isinstance(function, ast.FunctionDef)
        nodes = list(ast.walk(function))
        names = sorted({node.id for node in nodes if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load)})
        own = {node.arg for node in nodes if isinstance(node, ast.arg)} | {function.name}
        own |= {node.id for node in nodes if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)}
        there = self.solve.__globals__
        outer = sorted({*names} & {*self.arguments} - own)  # of the solution in which a learner's function stands
        constants = [f"{name} = {self.arguments[name]!r}" for name in outer]
        imports: dict[str, list[str]] = {}
        for name in (each for each in names if each in there and each not in own):
            value = there[name]
            if inspect.ismodule(value):
                home, _, last = value.__name__.rpartition(".")
                known = f"from {home} import {last}" if home else f"import {last}"
                imports[f"{known} as {name}" if name != last else known] = []
            elif name.isupper() and re.fullmatch(r"[\w\s'+:,.(){}-]+", repr(value)):
                constants.append(f"{name} = {value!r}")
            else:
                origin = str(getattr(value, "__module__", "")) if callable(value) else there["__name__"]
                if origin != "__main__":  # a teacher's own function is there
                    imports.setdefault(f"from {origin} import ", []).append(name)
        imports.pop("import numpy as np", None)  # as in every lesson
        return [*(first + ", ".join(names) for first, names in sorted(imports.items())), *constants]

    @property
    def shown_solution(self) -> str:
        """The reason, the source of the solution, and its result."""
        reason = textwrap.fill(inspect.getdoc(self.solve) or "", 100)
        own = "".join(f"\n# {name} = {self.arguments[name]}" for name in self.arguments if self.student)
        worked = f"{self.source}{own}\n# gives {self.kind.show(self.solution)}"
        return f"{reason}\n\n{worked}" if reason else worked

    def verdict(self, answer: Any) -> Verdict:
        """Judge an answer, which may be a stored one.

        No answer raises an error; only an exercise that cannot compute its own solution does.
        """
        say = partial(Verdict, self.name, student=self.student)
        parts = answer if isinstance(answer, (list, tuple)) else [answer]
        if answer is ... or any(each is None for each in parts):
            return say(OPEN, f"Answer with {self.kind.asked}.")
        _ = self.solution, self.mixed_up  # an error here is not the learner's
        try:
            if isinstance(answer, dict) and UNREADABLE in answer:
                raise InputError("answer", self.kind.asked, answer[UNREADABLE])
            value = self.read(answer)
        except InputError as error:
            return say(WRONG, f"Expected {self.kind.asked}; found {error.found}.", {UNREADABLE: error.found})
        try:
            mixup = self._mixup(value)
        except MathpostError as error:
            return say(WRONG, f"The answer cannot be used: {error}.", value)
        if mixup is None:
            remark = "" if self.complaint else self.kind.remark(value, self.solution)
            return say(RIGHT, f"{remark} {inspect.getdoc(self.solve) or ''}".strip(), value)
        why = mixup or f"{self.kind.nearly(value, self.solution) or NO_MIXUP} {self.hint}".strip()
        return say(WRONG, why, value, mixup=mixup)

    @cached_property
    def anew(self) -> Callable[[str], Verdict]:
        """The verdict on an answer given as JSON text, cached: a class gives few different answers."""
        return cache(lambda text: self.verdict(json.loads(text)))

    def _mixup(self, value: Any) -> str | None:
        """Return None if the value is right, or its mix-up: a slip, the detective's, a common one, or ""."""
        if self.complaint:
            return self.with_arguments(self.complaint, value) or None
        if self.kind.same(value, self.solution):
            return None
        if named := [said for said, mistaken in self.mixed_up if self.kind.same(value, mistaken)]:
            return named[0]
        if self.kind.remark(value, self.solution):
            return None
        if named := [said for said, right in self.kind.units(self.solution) if self.kind.same(value, right)]:
            return named[0]
        found = self.with_arguments(self.detective, value) if self.detective else None
        if found and found.explained and not found.right:
            said = str(found.misreadings[0])
            return f"{said[0].upper() if said[0].isascii() else said[0]}{said[1:]}."  # a letter such as α stays
        if named := [said for said, mistaken in self.common if self.kind.same(value, mistaken)]:
            return named[0]
        if self.kind.coarse(value, self.solution):
            return ""
        return next((said for said, other in self.mixed_up + self.common if self.kind.coarse(value, other)), "")


def define(name: str, kind: Kind | type[Name | Names], **how: Any) -> Callable[[Solution], Solution]:
    """Make the decorated function the solution of a new `Exercise`; `how` are more of its attributes.

    The exercises of the lessons have their texts in `exercises.toml`; if these list choices, `kind` is a class.

    Running the cell again replaces the exercise; a name used by a different file or notebook is an `InputError`.
    In the question a drawn number is written ``<!--drawn:01-sign:angle-->90<!--/drawn-->``.

    Examples
    --------
    A teacher's own, in a notebook or in a file that it imports; the question is a markdown cell above it:

    >>> import math
    >>> from mathpost.teaching.course import answers, exercise
    >>> @exercise.define("my-bevel", answers.Angle(decimals=1))
    ... @exercise.slip("That is the sine.", inverse=math.asin)
    ... @exercise.slip("That is the angle on the other side.", lambda: 90 - bevel())
    ... def bevel(inverse=math.atan):
    ...     '''The rise over the run is the tangent.'''
    ...     return math.degrees(inverse(0.5))
    >>> exercise.check("my-bevel", 30)
    my-bevel · not yet. That is the sine.
    >>> exercise.check("my-bevel", 386.6)
    my-bevel · right. The rise over the run is the tangent.
    """

    def enter(solve: Solution) -> Solution:
        if name in EXERCISES and (there := EXERCISES[name].solve.__module__) != solve.__module__:
            raise InputError("exercise", "a name of its own", f"{name!r}, which {there} has")
        named, slips, words = dict(getattr(solve, "slips", {})), {}, toml("exercises").get(name, {})
        for sentence, entry in words.get("slips", {}).items():
            changed = {key: value for key, value in entry.items() if key != "zh"}
            slips[sentence] = named.pop(entry["by"]) if "by" in entry else changed
        if words and named:
            raise InputError(f"exercises.toml, {name}", f"a slip by {' and '.join(named)}", "none")
        about = [words["about"].get] if "about" in words else []
        asked = kind(words["choices"], *about) if isinstance(kind, type) else kind
        EXERCISES[name] = Exercise(name, asked, solve, slips | named, **{"hint": words.get("hint", "")} | how)
        return solve

    return enter


@cache
def toml(name: str) -> dict[str, Any]:
    """Return a TOML file of this folder, parsed."""
    return read_toml(Path(__file__).with_name(f"{name}.toml"))


def slip(sentence: str, answer: Any = None, **changed: Any) -> Callable[[Solution], Solution]:
    """Add a mix-up to the exercise: the sentence to show if it leads to the learner's answer.

    `answer` is the wrong answer, or a function that computes it from arguments of the solution. Without it, the
    solution is called with the keywords `changed` and gives the wrong answer.
    """

    def enter(solve: Solution) -> Solution:
        solve.__dict__["slips"] = {sentence: {"answer": answer, **changed}} | getattr(solve, "slips", {})
        return solve

    return enter
