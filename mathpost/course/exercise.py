"""The exercises as the learner meets them: check an answer, see a solution, see how far one has come.

In a lesson an exercise is a question, a cell ``answer = None``, a cell ``exercise.check("07-pivot", answer)`` and a
folded cell ``exercise.solution("07-pivot")``. The saved notebook itself is the record of what has been solved, so
there is no other file, and a teacher reads the progress of a class from the notebooks that are handed in.
"""

import json
import re
from difflib import get_close_matches
from pathlib import Path

import numpy as np

from mathpost.course import (
    exercises_calibration,  # noqa: F401  imported for their entries in TASKS
    exercises_compensation,  # noqa: F401
    exercises_datum,  # noqa: F401
    exercises_path,  # noqa: F401
    exercises_rotation,  # noqa: F401
)
from mathpost.course.verdict import OPEN, RIGHT, TASKS, WRONG
from mathpost.errors import InputError, read_text

MARKS = {RIGHT: "●", WRONG: "◐", OPEN: "○"}
VERDICT = re.compile(rf"^(\d\d-\w+) · ({RIGHT}|{WRONG}|{OPEN})\.", re.MULTILINE)


def check(name, answer):
    """Print whether `answer` solves an exercise and, if not, the mistake that leads to it.

    Parameters
    ----------
    name : str
        Such as ``"07-pivot"``: the lesson and a word.
    answer : object
        What the question asks for; None if it has not been attempted.

    Raises
    ------
    InputError
        If there is no such exercise. No answer raises anything.

    Examples
    --------
    >>> check("01-sign", None)
    01-sign · not attempted yet.
    >>> check("01-sign", [-4, 3, 5])
    01-sign · not yet. This turns the point (an active matrix). The frame turns: look from its new axes.
    """
    print(_task(name).verdict(answer))


def solution(name):
    """Print one way to solve an exercise, as the lines that the package itself runs, and what they give.

    Raises
    ------
    InputError
        If there is no such exercise.

    Examples
    --------
    >>> solution("01-sign")
    # mathpost.course.exercises_rotation.sign
    return zxz_right(90, 0, 0, degrees=True) @ POINT
    # -> 4.000, -3.000, 5.000
    """
    task = _task(name)
    print(f"# {task.solve.__module__}.{task.solve.__name__}")
    print(task.code)
    print("# ->", _shown(task.solution, task.tolerance))


def given(name):
    """Return what the question of an exercise hands out, such as a program with an error in it.

    Raises
    ------
    InputError
        If there is no such exercise, or it hands out nothing.

    Examples
    --------
    >>> given("01-slip")
    (-4.490731, 4.949747, 2.309402)
    """
    task = _task(name)
    if task.given is None:
        raise InputError("exercise", "one that hands something out", repr(name))
    return task.given()


def answered(folder="."):
    """Return the state of every exercise as the notebooks saved in a folder show it.

    Parameters
    ----------
    folder : str or Path
        The learner's folder of lessons.

    Returns
    -------
    dict
        Name of an exercise to ``"right"``, ``"not yet"`` or ``"not attempted yet"``.

    Raises
    ------
    InputError
        If the folder has no lessons, or one of them is not a notebook.
    """
    found = dict.fromkeys(sorted(TASKS), OPEN)
    for path in _lessons(folder):
        for cell in _cells(path):
            if "exercise.check(" not in "".join(cell["source"]):
                continue
            for output in cell.get("outputs", []):
                verdicts = VERDICT.findall("".join(output.get("text", "")))
                found.update({name: status for name, status in verdicts if name in found})
    return found


def progress(folder="."):
    """Print how far the notebooks saved in a folder have come: one line for each lesson.

    Raises
    ------
    InputError
        As `answered`.

    Examples
    --------
    >>> progress("notebooks")
    ● solved   ◐ tried   ○ open
    01 Rotating a point                         ○ ○ ○ ○  0 of 4
    ...
    """
    state = answered(folder)
    print(
        "   ".join(
            f"{MARKS[status]} {word}" for status, word in ((RIGHT, "solved"), (WRONG, "tried"), (OPEN, "open"))
        )
    )
    for path in _lessons(folder):
        states = [status for name, status in state.items() if name[:2] == path.name[:2]]
        if states:
            marks = " ".join(MARKS[status] for status in states)
            print(f"{_title(path):42s}  {marks:9s} {states.count(RIGHT)} of {len(states)}")
    print(f"{'all lessons':53s} {list(state.values()).count(RIGHT)} of {len(state)}")


def _task(name):
    if name not in TASKS:
        near = get_close_matches(str(name), TASKS, n=1, cutoff=0)
        raise InputError("exercise", f"the name of one, such as {near[0]!r}", repr(name))
    return TASKS[name]


def _lessons(folder):
    found = sorted(Path(folder).glob("[0-9][0-9]_*.ipynb"))
    if not found:
        raise InputError(str(folder), "lessons such as 01_rotating_a_point.ipynb", "none")
    return found


def _cells(path):
    try:
        return json.loads(read_text(path))["cells"]
    except (ValueError, KeyError, TypeError):
        raise InputError(str(path), "a notebook", "something else") from None


def _title(path):
    """The first heading of a lesson up to a comma or colon, without the Chinese in brackets."""
    heading = "".join(_cells(path)[0]["source"]).splitlines()[0]
    return re.split(r"\s*\(|[,:]", heading.lstrip("# "))[0].replace(" · ", " ")


def _shown(value, tolerance):
    """A solution as text with fixed decimals, as many as the tolerance asks for."""
    if isinstance(value, str):
        return value
    if isinstance(value, set):
        return ", ".join(f"{each:g}" if isinstance(each, float) else str(each) for each in sorted(value))
    try:
        array = np.asarray(value, dtype=float)
    except (TypeError, ValueError):
        return ", ".join(map(str, value)) if isinstance(value, tuple) else str(value)
    # Half a unit of the last digit stays within the tolerance.
    decimals = int(max(np.ceil(-np.log10(2 * tolerance) - 1e-9), 0)) if np.any(array % 1) else 0
    return ", ".join(f"{each:z.{decimals}f}" for each in array.ravel())
