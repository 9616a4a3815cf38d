"""The exercises as the learner meets them: check an answer, open a solution, see how far one has come.

In a lesson an exercise is a question, a cell ``answer = None``, a cell ``exercise.check("07-pivot", answer)`` and a
cell ``exercise.solution("07-pivot")``, which stays closed until it is clicked. The saved notebook is the record:
beside each verdict stands the answer as data, so that a teacher judges every answer anew, and runs nobody's code.
"""

import html
import json
import re
from dataclasses import replace
from difflib import get_close_matches
from importlib import import_module
from pathlib import Path

from mathpost.course.answers import Number
from mathpost.course.verdict import EXERCISES, MIME, OPEN, RIGHT, WRONG, Verdict, define, slip
from mathpost.detective.misreadings import written_decimals
from mathpost.errors import InputError, read_text

__all__ = ["check", "define", "given", "judge", "progress", "reveal", "saved", "slip", "solution", "student"]
for _module in sorted(Path(__file__).parent.glob("exercises_*.py")):
    import_module(f"mathpost.course.{_module.stem}")  # for their entries in EXERCISES

LESSONS = "[0-9][0-9]*_*.ipynb"
MARKS = {RIGHT: "●", WRONG: "◐", OPEN: "○"}
SAID = re.compile(rf"^([\w-]+) · ({RIGHT}|{WRONG}|{OPEN})\.", re.MULTILINE)
_tried = set()  # exercises of which an attempt was checked in this session
_numbers = {"of": ""}  # the student whose numbers hold in this session


def student(name):
    """From here on the exercises have the numbers that were drawn for a student, where they draw any."""
    _numbers["of"] = str(name)
    print(f"The numbers of {name or 'the lesson'}.")


def check(name, answer):
    """Say whether `answer` solves an exercise and, if not, the mix-up that leads to it; None is not attempted.

    No answer raises anything; there is an `InputError` if no exercise has the name, or what it needs is missing.

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


def judge(name, answer):
    """Return the `Verdict` on an answer, also on one that a notebook has stored."""
    return _named(name).verdict(answer)


def solution(name, *, update=False):
    """Show a hint and a solution, closed until they are clicked: the lines that run, and what they give.

    Its summary says whether an attempt was checked; `update` changes that where it is shown. Outside a notebook it
    is printed.
    """
    from IPython import display, get_ipython

    found = _named(name)
    if get_ipython():
        summary = f"Solution of {name}{': you have not tried yet' * (name not in _tried)}"
        shown = {f"Hint for {name}": found.hint, summary: found.shown_solution}
        closed = '<details><summary>{}</summary><pre style="font-family: monospace">{}</pre></details>'.format
        page = "".join(closed(title, html.escape(text)) for title, text in shown.items() if text)
        bundle = {"text/plain": summary, "text/html": page}
        display.display(bundle, raw=True, display_id=f"solution of {name}", update=update)
    elif not update:
        print(found.shown_solution)


def given(name):
    """Return what the question of an exercise hands out, such as a program with an error in it."""
    found = _named(name)
    if found.given is None:
        raise InputError("exercise", "one that hands something out", repr(name))
    return found.with_arguments(found.given)


def reveal(guess, truth):
    """Answer what the learner predicted in the lesson: say what is true, and whether it was guessed.

    A number is guessed if it is the true one, correctly rounded.

    Examples
    --------
    >>> reveal(1, -1)
    The answer: -1. You guessed 1. Find out why before you go on.
    >>> reveal("−650.0", -650)
    The answer: -650. You guessed it.
    """
    try:  # a number to the digits of the coarser of both, a word in any case
        number = Number(decimals=written_decimals(truth))
        pair = number.read(guess), number.read(truth)
        right = number.same(*pair) or number.coarse(*pair)
    except (TypeError, ValueError, OverflowError):
        right = str(guess).strip().casefold() == str(truth).casefold()
    said = "You guessed it." if right else f"You guessed {guess}. Find out why before you go on."
    if guess is None:
        said = "You have not guessed: write a guess down before you go on, even a wild one."
    print(f"The answer: {truth}. {said}")


def saved(path):
    """Return the verdicts on all answers that a saved notebook holds, each judged anew, as `judged` does."""
    return judged(notebook(path)["cells"], path)


def judged(cells, where):
    """Return the verdicts on the answers in the cells of a notebook, judged anew; `where` names it in an error.

    One is `edited` where the notebook says something else than its answer deserves. An exercise that is not defined
    here keeps what the notebook says.
    """
    found = []
    try:
        for cell in cells:
            asks = cell["cell_type"] == "code" and "exercise.check(" in "".join(cell["source"])
            for shown in (output.get("data", {}) for output in cell["outputs"]) if asks else ():
                stored, whose = (shown.get(MIME, {}).get(key) for key in ("answer", "student"))
                said = SAID.findall("".join(shown.get("text/plain", "")))
                found += [(*each, stored, str(whose or "")) for each in said]
    except (KeyError, TypeError, AttributeError):
        raise InputError(str(where), "a notebook", "something else") from None
    verdicts = []
    for name, said, stored, whose in found:
        if name in EXERCISES:
            verdict = EXERCISES[name].of(whose).anew(json.dumps(stored))
            verdicts.append(replace(verdict, edited=verdict.status != said))
        else:
            verdicts.append(Verdict(name, said, "This exercise is not defined here.", stored))
    return verdicts


def answered(folder="."):
    """Return the verdicts, judged anew, that the lessons saved in a folder hold: a dict by name of the exercise."""
    paths = sorted(Path(folder).glob(LESSONS))
    if not paths:
        raise InputError(str(folder), "lessons such as 01_rotating_a_point.ipynb", "none")
    found = {name: Verdict(name, OPEN) for name in sorted(EXERCISES)}
    return found | {verdict.name: verdict for path in paths for verdict in saved(path)}


def progress(folder="."):
    """Print how far the notebooks saved in a folder have come: one line for each lesson.

    Examples
    --------
    >>> progress("notebooks")
    ● solved   ◐ tried   ○ open
    01 Rotating a point                         ○ ○ ○ ○  0 of 4
    ...
    """
    verdicts = answered(folder).values()
    print(f"{MARKS[RIGHT]} solved   {MARKS[WRONG]} tried   {MARKS[OPEN]} open")
    for path in sorted(Path(folder).glob(LESSONS)):
        lesson = [each.status for each in verdicts if each.name.split("-")[0] == path.name.split("_")[0]]
        if lesson:
            heading = "".join(notebook(path)["cells"][0]["source"]).splitlines()[0].lstrip("# ").replace(" · ", " ")
            title = re.split(r"\s*\(|[,:]", heading)[0]  # without the Chinese in brackets
            marks = " ".join(map(MARKS.get, lesson))
            print(f"{title:42s}  {marks:9s} {lesson.count(RIGHT)} of {len(lesson)}")
    print(f"{'all lessons':53s} {sum(each.status == RIGHT for each in verdicts)} of {len(verdicts)}")
    for each in verdicts:
        if each.edited:
            print(f"{each.name}: the notebook says something else than its answer deserves ({each.status}).")


def _named(name):
    if name not in EXERCISES:
        near = get_close_matches(str(name), EXERCISES, n=1, cutoff=0)
        raise InputError("exercise", f"the name of one, such as {near[0]!r}", repr(name))
    return EXERCISES[name].of(_numbers["of"])


def notebook(path):
    """Return a saved notebook as JSON holds it; raise `InputError` if it is none."""
    try:
        found = json.loads(read_text(path))
        for cell in found["cells"]:
            _ = "".join(cell["source"]), cell["cell_type"]
        return found
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
        raise InputError(str(path), "a notebook", "something else") from None


def asked(source):
    """Return the names of the exercises that the source of a cell checks."""
    return re.findall(r"exercise\.check\(\s*[\"']([\w-]+)[\"']", source)
