"""The functions that a learner calls: check an answer, open the solution, see the progress.

In a lesson an exercise is a question, a cell ``answer = None``, a cell ``exercise.check("07-pivot", answer)`` and a
cell ``exercise.solution("07-pivot")``, which stays closed until it is clicked. The saved notebook is the record:
each answer is stored as data beside its verdict, so a teacher can judge it again without running anybody's code.
"""

from __future__ import annotations

import html
import json
import re
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass, replace
from difflib import get_close_matches
from importlib import import_module
from pathlib import Path
from pkgutil import iter_modules
from typing import Any

import numpy as np

from mathpost.detective.digits import written_decimals
from mathpost.errors import InputError
from mathpost.files import read_text
from mathpost.rotation import wrap
from mathpost.teaching.course import exercises
from mathpost.teaching.course.answers import Number
from mathpost.teaching.course.typed import bare
from mathpost.teaching.course.verdict import EXERCISES, MIME, OPEN, RIGHT, WRONG, Exercise, Verdict
from mathpost.teaching.course.verdict import define as define
from mathpost.teaching.course.verdict import slip as slip

for _module in iter_modules(exercises.__path__):
    import_module(f"mathpost.teaching.course.exercises.{_module.name}")  # for their entries in EXERCISES

LESSONS = "[0-9][0-9]*_*.ipynb"
STYLE = "font-family: monospace; white-space: pre-wrap"
CLOSED = f'<details><summary>{{}}</summary><pre style="{STYLE}">{{}}</pre></details>'
MARKS = {RIGHT: "●", WRONG: "◐", OPEN: "○"}
SAID = re.compile(rf"^([\w-]+) · ({RIGHT}|{WRONG}|{OPEN})\.", re.MULTILINE)
_tried: set[str] = set()  # exercises with an attempt in this session
_numbers = {"of": ""}  # the student whose numbers are used in this session


def student(name: str) -> None:
    """Use the numbers drawn for this student from now on, in the exercises that draw any."""
    _numbers["of"] = str(name)
    print(f"The numbers of {name or 'the lesson'}.")


def check(name: str, answer: Any) -> None:
    """Say whether `answer` is right and, if not, which mix-up leads to it; None means not attempted.

    No answer raises an error. An unknown name does (`InputError`), and so does a missing data file.

    Examples
    --------
    >>> check("01-sign", None)
    01-sign · not attempted yet. Answer with three numbers (x, y, z), to 3 decimals.
    >>> check("01-sign", [-4, 3, 5])
    01-sign · not yet. This turns the point (an active matrix). The frame turns: look from its new axes.
    """
    from IPython.display import display  # slow to import, and a grader of notebooks displays nothing

    verdict = judge(name, answer)
    display(verdict)
    if verdict.status != OPEN and name not in _tried:
        _tried.add(name)
        solution(name, update=True)


def judge(name: str, answer: Any) -> Verdict:
    """Return the `Verdict` on an answer; it may be one stored in a notebook."""
    return _named(name).verdict(answer)


def solution(name: str, *, update: bool = False) -> None:
    """Show the hint and the solution, its code and its result, both closed until they are clicked.

    The summary says whether an attempt was checked; `update` rewrites a summary that is already shown. Outside a
    notebook the solution is printed.
    """
    from IPython import display, get_ipython

    found = _named(name)
    if get_ipython():
        summary = f"Solution of {name}{': you have not tried yet' * (name not in _tried)}"
        shown = {f"Hint for {name}": found.hint, summary: found.shown_solution}
        page = "".join(CLOSED.format(title, html.escape(text)) for title, text in shown.items() if text)
        bundle = {"text/plain": summary, "text/html": page}
        display.display(bundle, raw=True, display_id=f"solution of {name}", update=update)
    elif not update:
        print(found.shown_solution)


def given(name: str) -> Any:
    """Return the material of the question, such as a program with an error in it."""
    found = _named(name)
    if found.given is None:
        raise InputError("exercise", "one that hands something out", repr(name))
    return found.with_arguments(found.given)


def reveal(guess: Any, truth: Any, *, within: float | None = None, modulo: float | None = None) -> None:
    """Print the truth after a guess, and whether the guess is right; without a guess, do not reveal it.

    A correctly rounded number is right, or one as near as `within`, which the question states; `modulo` 360 takes
    -180 and 180 as the same. Spaces and letter case of a word do not matter.

    Examples
    --------
    >>> reveal(None, -1)
    Write a guess in the place of None, even a wild one, and run that cell. Then run this one: it shows the answer.
    >>> reveal(1, -1)
    The answer: -1. You guessed 1. Find out why before you go on.
    >>> reveal("−650.0", -650), reveal(175, 174.2, within=10), reveal("Z-200", "Z - 200")
    The answer: -650. You guessed it.
    The answer: 174.2. Your guess of 175 is within 10 of it.
    The answer: Z - 200. You guessed it.
    (None, None, None)
    """
    if not _given(guess):
        print(
            "Write a guess in the place of None, even a wild one, and run that cell. Then run this one: "
            "it shows the answer."
        )
        return
    said = f"You guessed {guess}. Find out why before you go on."
    try:  # a number to the digits of the coarser of both
        decimals = written_decimals(truth)
        number = Number(decimals=decimals, tolerance=0.5 * 10.0**-decimals if within is None else within)
        apart = np.subtract(number.read(guess), number.read(truth))
        apart = wrap(apart, modulo) if modulo else apart
        if number.same(apart, 0.0) or (within is None and number.coarse(number.read(guess), number.read(truth))):
            said = f"Your guess of {guess} is within {within:g} of it." if within and apart else "You guessed it."
    except (TypeError, ValueError, OverflowError):
        if bare(guess) == bare(truth):
            said = "You guessed it."
    print(f"The answer: {truth}. {said}")


@contextmanager
def after(guess: Any) -> Iterator[None]:
    """Run the lines below, but show their output only after a guess.

    So a lesson that is run as a whole, exported or handed out does not contain the answer before the guess.

    Examples
    --------
    >>> for guess in None, 3:
    ...     with after(guess):
    ...         print("It is", 2 + 1)
    It is 3
    """
    from IPython.utils.capture import capture_output  # slow to import, see `check`

    with nullcontext() if _given(guess) else capture_output():
        yield


def _given(guess: Any) -> bool:
    return guess is not None and guess is not ...


def judged(path: Path | str) -> list[Verdict]:
    """Return the verdicts on all answers in a saved notebook, each judged again."""
    return [judged_anew(each) for each in stored(notebook(path)["cells"], path)]


@dataclass(frozen=True)
class Stored:
    """An answer as stored in a notebook."""

    name: str  # of the exercise
    said: str  # its status in the notebook
    answer: str  # JSON
    student: str  # whose drawn numbers it is for; "" for those of the lesson


def stored(cells: Iterable[dict[str, Any]], where: Path | str) -> list[Stored]:
    """Return the `Stored` answers in the cells of a notebook; errors name `where`."""
    found = []
    try:
        for cell in cells:
            asks = cell["cell_type"] == "code" and "exercise.check(" in "".join(cell["source"])
            for shown in (output.get("data", {}) for output in cell["outputs"]) if asks else ():
                beside = shown.get(MIME, {})
                answer, whose = json.dumps(beside.get("answer")), str(beside.get("student") or "")
                for name, status in SAID.findall("".join(shown.get("text/plain", ""))):
                    found.append(Stored(name, status, answer, whose))
    except (KeyError, TypeError, AttributeError):
        raise InputError(str(where), "a notebook", "something else") from None
    return found


def judged_anew(found: Stored) -> Verdict:
    """Return the verdict on a `Stored` answer, `edited` if the notebook has a different one.

    For an exercise that is not defined here, it is the one in the notebook.
    """
    if found.name not in EXERCISES:
        answer = json.loads(found.answer)
        return Verdict(found.name, found.said, "This exercise is not defined here.", answer)
    verdict = EXERCISES[found.name].of(found.student).anew(found.answer)
    return replace(verdict, edited=verdict.status != found.said)


def answered(folder: Path | str = ".") -> dict[str, Verdict]:
    """Return the verdicts, judged again, on the lessons saved in a folder: a dict by exercise."""
    paths = sorted(Path(folder).glob(LESSONS))
    if not paths:
        raise InputError(str(folder), "lessons such as 01_rotating_a_point.ipynb", "none")
    found = {name: Verdict(name, OPEN) for name in sorted(EXERCISES)}
    return found | {verdict.name: verdict for path in paths for verdict in judged(path)}


def progress(folder: Path | str = ".") -> None:
    """Print the progress in the notebooks saved in a folder, one line per lesson.

    Examples
    --------
    >>> progress("notebooks")
    ● solved   ◐ tried   ○ open
    00 Start here                               ○        0 of 1
    ...
    """
    verdicts = answered(folder).values()
    print(f"{MARKS[RIGHT]} solved   {MARKS[WRONG]} tried   {MARKS[OPEN]} open")
    for path in sorted(Path(folder).glob(LESSONS)):
        lesson = [each.status for each in verdicts if each.name.split("-")[0] == path.name.split("_")[0]]
        if lesson:
            heading = "".join(notebook(path)["cells"][0]["source"]).splitlines()[0].lstrip("# ").replace(" · ", " ")
            title = re.split(r"\s*\(|[,:]", heading)[0]  # without the Chinese in brackets
            marks = " ".join(MARKS[status] for status in lesson)
            print(f"{title:42s}  {marks:9s} {lesson.count(RIGHT)} of {len(lesson)}")
    print(f"{'all lessons':53s} {sum(each.status == RIGHT for each in verdicts)} of {len(verdicts)}")
    for each in verdicts:
        if each.edited:
            print(f"{each.name}: the notebook says something else than its answer deserves ({each.status}).")


def _named(name: str) -> Exercise:
    if name not in EXERCISES:
        near = get_close_matches(str(name), EXERCISES, n=1, cutoff=0)
        raise InputError("exercise", f"the name of one, such as {near[0]!r}", repr(name))
    return EXERCISES[name].of(_numbers["of"])


def notebook(path: Path | str) -> dict[str, Any]:
    """Return a saved notebook as parsed JSON; raise `InputError` if it is not a notebook."""
    try:
        found = json.loads(read_text(path))
        for cell in found["cells"]:
            _ = "".join(cell["source"]), cell["cell_type"]
        return found
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
        raise InputError(str(path), "a notebook", "something else") from None


def asked(source: str) -> list[str]:
    """Return the names of the exercises that a cell checks."""
    return re.findall(r"exercise\.check\(\s*[\"']([\w-]+)[\"']", source)
