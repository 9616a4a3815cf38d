"""The lessons as an assignment: one copy for all without solutions, or one for each student with own numbers.

Cells that show solutions are removed, and so is the output of checks and solutions. Students who have the package
can still read its exercises, or call `exercise.solution`; a teacher's own exercises, in a file that students do not
get, are safe from that. An exercise that draws numbers uses the student's own in its question and its check, and
every question says whether it does.
"""

from __future__ import annotations

import copy
import json
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from mathpost.errors import InputError, OutputError
from mathpost.files import write_set
from mathpost.teaching.course import exercise
from mathpost.teaching.course.verdict import EXERCISES, OPEN

CALLS = re.compile(r"exercise\.(check|solution|progress|given)\s*\(")
DEFINES = re.compile(r"@?\bexercise\.define\s*\(")
SHOWN = re.compile(r"Solution of|Hint for")
DRAWN = re.compile(r"<!--drawn:([\w-]+):(\w+)-->(.*?)<!--/drawn-->", re.DOTALL)
Notebook = dict[str, Any]  # as parsed JSON
OWN, SAME = "*These numbers are yours alone.*", "*The same for everybody.*"


def assign(lessons: Path | str, folder: Path | str, students: Sequence[str] = ()) -> dict[Path, list[str]]:
    """Write the student copy, or one for each student; return a dict from each path to its exercises' names.

    `lessons` is a notebook or a folder of them; each name in `students` becomes a folder in `folder`. Raises
    `InputError` if there are no notebooks, or one contains an answer, shows a solution, or defines an exercise;
    `OutputError` if a copy exists already or cannot be written.
    """
    lessons, folder = Path(lessons), Path(folder)
    paths = [lessons] if lessons.is_file() else sorted(lessons.glob("*.ipynb"))
    if not paths:
        raise InputError(str(lessons), "a notebook or a folder of notebooks", "none")
    for number, name in enumerate(students):
        if not name.strip() or name in students[:number] or re.search(r'[\\/:*?"<>|\x00-\x1f]|^\.+$', name):
            raise InputError("students", "different names, each that of a folder", repr(name))
    blank = {path.name: _student_copy(path) for path in paths}
    copies = {
        folder / who / file: (_personal(page, who) if who else page, names)
        for who in students or [""]
        for file, (page, names) in blank.items()
    }
    for path in copies:
        if path.exists():
            raise OutputError(f"{path}: not written, it is there already")
    pages = {path: json.dumps(page, indent=1, ensure_ascii=False) + "\n" for path, (page, _) in copies.items()}
    write_set(pages, folders=True)
    return {path: names for path, (_, names) in copies.items()}


def _student_copy(path: Path) -> tuple[Notebook, list[str]]:
    """The notebook without solutions, as parsed JSON, and the names of its exercises."""
    page = exercise.notebook(path)
    for each in exercise.judged(path):
        if each.status != OPEN:
            raise InputError(f"{path}, {each.name}", "an exercise that nobody has answered", "a stored answer")
    cells, names = [], []
    for number, cell in enumerate(page["cells"], 1):
        source = "".join(cell["source"])
        if cell["cell_type"] == "code" and DEFINES.search(source):
            expected = "exercises defined in a file of the teacher's, which the copy does not hold"
            raise InputError(f"{path}, cell {number}", expected, "an exercise with its solution")
        if "solution" in cell["metadata"].get("tags", []) or "exercise.solution(" in source:
            continue
        if cell["cell_type"] == "code":
            names += exercise.asked(source)
            shown = json.dumps(cell["outputs"], ensure_ascii=False)
            if CALLS.search(source) or SHOWN.search(shown):
                cell["outputs"], cell["execution_count"] = [], None
        cells.append(cell)
    text = "\n".join("".join(cell["source"]) + json.dumps(cell.get("outputs", "")) for cell in cells)
    for name in EXERCISES.keys() & names:
        if EXERCISES[name].source in text:
            raise InputError(f"{path}, {name}", "a notebook that shows no solution", "its lines")
    return page | {"cells": cells}, names


def _personal(page: Notebook, student: str) -> Notebook:
    """A student copy with the student's own numbers, and a cell that tells the checks the student's name."""
    question, cells = None, []
    for cell in copy.deepcopy(page["cells"]):
        source = "".join(cell["source"])
        if cell["cell_type"] == "markdown":
            cell["source"] = DRAWN.sub(lambda mark: _number(mark[1], mark[2], mark[3], student), source)
            question = cell
        elif question is not None and (names := [name for name in exercise.asked(source) if name in EXERCISES]):
            own = EXERCISES[names[0]].of(student).student
            question["source"] += f"\n\n{OWN if own else SAME}"
            question = None
        cells.append(cell)
        if cell["cell_type"] == "code" and re.search(r"import.*\bexercise\b", source):
            told: Notebook = {
                "cell_type": "code",
                "execution_count": None,
                "id": "student",
                "metadata": {},
                "outputs": [],
            }
            cells.append(told | {"source": f"exercise.student({json.dumps(student, ensure_ascii=False)})"})
    return page | {"cells": cells}


def _number(name: str, argument: str, stated: str, student: str) -> str:
    """The drawn number for a place in a question, or the lesson's own if the exercise draws none."""
    if name not in EXERCISES or argument not in (arguments := EXERCISES[name].of(student).arguments):
        raise InputError(f"<!--drawn:{name}:{argument}-->", "an exercise, and an argument that it draws", stated)
    return str(arguments[argument])
