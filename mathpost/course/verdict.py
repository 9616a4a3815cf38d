"""One exercise: its solution, the mix-ups that give a wrong answer, all of them computed, and the verdict.

The exercises of the lessons stand in `mathpost.course.exercises_rotation` and its neighbours, their words in
`exercises.toml`; the learner meets them through `mathpost.course.exercise`, and so does a teacher who writes one.
"""

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

from mathpost.course.answers import brief
from mathpost.errors import InputError, MathpostError
from mathpost.machine import read_toml

EXERCISES = {}
OPEN, WRONG, RIGHT = "not attempted yet", "not yet", "right"
MIME = "application/vnd.mathpost+json"  # the answer as data, beside the verdict in a saved notebook
UNREADABLE = "unreadable"
NO_MIXUP = "None of the usual mix-ups gives this."


@dataclass(frozen=True)
class Verdict:
    """What is said of an answer."""

    name: str  # of the exercise
    status: str  # OPEN, WRONG or RIGHT
    why: str = ""
    answer: object = None  # as JSON holds it; a dict with what was found in its place if it could not be read
    edited: bool = False  # whether the saved notebook said something else of this answer
    mixup: str = ""  # the sentence that names the mix-up, where one gives the answer
    student: str = ""  # whose numbers it was judged by; "" for those that stand in the lesson

    def __str__(self):
        return f"{self.name} · {self.status}." + (f" {self.why}" if self.why else "")

    def _repr_mimebundle_(self, include=None, exclude=None):
        data = {"answer": self.answer, "exercise": self.name}  # as sorted in a file
        return {"text/plain": str(self), MIME: data | ({"student": self.student} if self.student else {})}


@dataclass(frozen=True)
class Exercise:
    """An exercise, made by `define`. What belongs to it gets the arguments of the solution that it names."""

    name: str  # not one of the lessons'
    kind: object  # what is asked for: one of `mathpost.course.answers`, such as ``Angle(decimals=2)``
    solve: Callable  # its docstring says what the exercise teaches; its source is shown
    slips: dict = field(default_factory=dict)  # sentence → function that computes the answer; see `slip`
    hint: str = ""  # what to say if no mix-up gives the answer
    complaint: Callable | None = None  # where there are many solutions: what is wrong with an answer, or ""
    detective: Callable | None = None  # an `Explanation` of an answer that no slip gives; see mathpost.detective
    given: Callable | None = None  # what the question hands out, such as a program with an error in it
    drawn: Callable | None = None  # ``drawn(rng)``: arguments of the solution, drawn for one student, as a dict
    student: str = ""  # for whom its numbers were drawn; "" where they are those of the lesson

    @cached_property
    def of(self):
        """The exercise with a student's own numbers, remembered; itself if all have the same."""
        return cache(lambda student: replace(self, student=student) if student and self.drawn else self)

    @cached_property
    def arguments(self):
        """The arguments of the solution: as it states them, or as they are drawn for the student."""
        stated = inspect.signature(self.solve).parameters.items()
        found = {name: each.default for name, each in stated if each.default is not each.empty}
        return found | (self.drawn(random.Random(f"{self.name} {self.student}")) if self.student else {})

    def with_arguments(self, function, *values):
        """Call what belongs to the exercise with the arguments of the solution that it names."""
        named = inspect.signature(function).parameters
        every = any(each.kind is each.VAR_KEYWORD for each in named.values())
        taken = list(named)[len(values) :]
        return function(*values, **{key: value for key, value in self.arguments.items() if every or key in taken})

    def read(self, answer):
        """The answer as data, or an `InputError`."""
        try:
            return self.kind.read(answer)
        except (TypeError, ValueError, LookupError, AttributeError, OverflowError) as error:
            found = error.found if isinstance(error, InputError) else brief(answer)
            raise InputError(f"exercise {self.name}", self.kind.asked, found) from None

    @cached_property
    def solution(self):
        """The solution as data, computed once, and right in its own eyes."""
        value = self.read(self.with_arguments(self.solve))
        if self.complaint and (why := self.with_arguments(self.complaint, value)):
            raise InputError(f"exercise {self.name}", "a solution that has nothing wrong", f"{value}: {why}")
        return value

    @cached_property
    def mixed_up(self):
        """What each slip gives, as data: pairs of a sentence and a value."""
        found = [(said, self.read(self.with_arguments(slip))) for said, slip in self.slips.items()]
        for said, value in found if not self.complaint else ():
            if self.kind.same(value, self.solution):
                raise InputError(f"exercise {self.name}", "a slip that gives a wrong answer", f"{value}: {said}")
        return found

    @cached_property
    def common(self):
        """What the mix-ups give that any answer of its kind can suffer."""
        found = self.kind.mixups(self.solution)
        return [(sentence, value) for sentence, value in found if not self.kind.same(value, self.solution)]

    @property
    def source(self):
        """The function that solves it, without decorator and docstring, as text."""
        lines = textwrap.dedent(inspect.getsource(self.solve)).splitlines()
        function = ast.parse("\n".join(lines)).body[0]
        described, *rest = function.body
        head = lines[function.lineno - 1 : described.lineno - 1]
        body = lines[(rest[0].lineno if self.solve.__doc__ else described.lineno) - 1 :]
        nodes = (node for part in (function.args, *rest, described) for node in ast.walk(part))
        used = dict.fromkeys(node.id for node in nodes if isinstance(node, ast.Name) and node.id.isupper())
        known = {name: repr(self.solve.__globals__.get(name)) for name in used}
        plain = [f"{name} = {value}" for name, value in known.items() if re.fullmatch(r"[\w\s'+:,.(){}-]+", value)]
        return "\n".join([*plain, *head, *body])

    @property
    def shown_solution(self):
        """The lines that solve it, and what they give."""
        own = "".join(f"\n# {name} = {self.arguments[name]}" for name in self.arguments if self.student)
        return f"{self.source}{own}\n# gives {self.kind.show(self.solution)}"

    def verdict(self, answer):
        """Judge an answer, also one that was stored.

        Whatever the answer is, nothing is raised; what the exercise itself cannot compute raises its own error.
        """
        say = partial(Verdict, self.name, student=self.student)
        parts = answer if isinstance(answer, (list, tuple)) else [answer]
        if answer is ... or any(each is None for each in parts):
            return say(OPEN, f"Answer with {self.kind.asked}.")
        _ = self.solution, self.mixed_up  # what fails here is not the answer's fault
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
            return say(RIGHT, inspect.getdoc(self.solve) or "", value)
        why = mixup or f"{self.kind.nearly(value, self.solution) or NO_MIXUP} {self.hint}".strip()
        return say(WRONG, why, value, mixup=mixup)

    @cached_property
    def anew(self):
        """The verdict on an answer as JSON text, remembered: a class gives few different answers."""
        return cache(lambda text: self.verdict(json.loads(text)))

    def _mixup(self, value):
        """None if the value is right, or the sentence of the first mix-up: named, of the detective, or common."""
        if self.complaint:
            return self.with_arguments(self.complaint, value) or None
        if self.kind.same(value, self.solution):
            return None
        if named := [said for said, mistaken in self.mixed_up if self.kind.same(value, mistaken)]:
            return named[0]
        found = self.with_arguments(self.detective, value) if self.detective else None
        if found and found.explained and not found.right:
            first, *rest = str(found.misreadings[0])
            return "".join([first.upper() if first.isascii() else first, *rest, "."])  # a letter such as α stays
        if named := [said for said, mistaken in self.common if self.kind.same(value, mistaken)]:
            return named[0]
        if self.kind.coarse(value, self.solution):
            return ""
        return next((said for said, other in self.mixed_up + self.common if self.kind.coarse(value, other)), "")


def define(name, kind, **how):
    """Enter the decorated function as the solution of an `Exercise`; `how` are more of its attributes.

    Those of the lessons have their words in `exercises.toml`; where these have choices, `kind` is a class.

    Running the cell anew replaces it; a name that a different file or notebook has taken is an `InputError`. A
    number that is drawn stands in the question as ``<!--drawn:01-sign:angle-->90<!--/drawn-->``.

    Examples
    --------
    A teacher's own, in a notebook or in a file that it imports; the question is a markdown cell above it:

    >>> import math
    >>> from mathpost.course import answers, exercise
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

    def enter(solve):
        if name in EXERCISES and (there := EXERCISES[name].solve.__module__) != solve.__module__:
            raise InputError("exercise", "a name of its own", f"{name!r}, which {there} has")
        named, slips, words = dict(getattr(solve, "slips", {})), {}, toml("exercises").get(name, {})
        for sentence, entry in words.get("slips", {}).items():
            changed = {key: value for key, value in entry.items() if key not in ("zh", "by")}
            slips[sentence] = named.pop(entry["by"]) if "by" in entry else _leads_to(solve, **changed)
        if words and named:
            raise InputError(f"exercises.toml, {name}", f"a slip by {' and '.join(named)}", "none")
        about = [words["about"].get] if "about" in words else []
        asked = kind(words["choices"], *about) if "choices" in words else kind
        EXERCISES[name] = Exercise(name, asked, solve, slips | named, **{"hint": words.get("hint", "")} | how)
        return solve

    return enter


@cache
def toml(name):
    """A file of this folder as it stands."""
    return read_toml(Path(__file__).with_name(f"{name}.toml"))


def slip(sentence, answer=None, **changed):
    """Name a mix-up of the exercise that is defined above: what is said of an answer that it leads to.

    `answer` is that answer, or a function that computes it from the arguments of the solution that it names. Else
    the keywords are the arguments with which the *solution* gives the answer.
    """

    def enter(solve):
        solve.slips = {sentence: _leads_to(solve, answer, **changed)} | getattr(solve, "slips", {})
        return solve

    return enter


def _leads_to(solve, answer=None, **changed):
    if answer is None:
        return lambda **arguments: solve(**arguments | changed)
    return answer if callable(answer) else lambda: answer
