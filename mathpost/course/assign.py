"""The lessons as an assignment: a copy for students that holds no solutions.

What is taken out are the cells that show solutions and everything that checks and solutions have printed. The
package itself stays what it is: who has it installed can read the sources of its exercises, or call
`exercise.solution`. Exercises of a teacher's own, in a file that students do not get, have no such way in. The
numbers of an exercise stand in its text and are the same for everybody.
"""

import copy
import json
import re
from pathlib import Path

from mathpost.course import exercise
from mathpost.course.verdict import EXERCISES, OPEN
from mathpost.errors import InputError, OutputError, write_text

CALLS = re.compile(r"exercise\.(check|solution|progress)\s*\(")
DEFINES = re.compile(r"@?\bexercise\.define\s*\(")
SHOWN = re.compile(r"Solution of|Hint for")


def assign(lessons, folder):
    """Write the student copy.

    Parameters
    ----------
    lessons : str or Path
        A notebook, or a folder of notebooks.
    folder : str or Path
        Made where it is missing; a notebook that is there already is not overwritten.

    Returns
    -------
    dict
        Path of each copy to the names of its exercises.

    Raises
    ------
    InputError
        If there are no notebooks, one holds an answer, or one defines an exercise and with it a solution.
    OutputError
        If a copy is there already or cannot be written.
    """
    lessons, folder = Path(lessons), Path(folder)
    paths = [lessons] if lessons.is_file() else sorted(lessons.glob("*.ipynb"))
    if not paths:
        raise InputError(str(lessons), "a notebook or a folder of notebooks", "none")
    copies = {folder / path.name: _student_copy(path) for path in paths}
    for path in copies:
        if path.exists():
            raise OutputError(f"{path}: not written, it is there already")
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise OutputError(f"{folder}: not made, {error.strerror or error}") from None
    for path, (page, _) in copies.items():
        write_text(path, json.dumps(page, indent=1, ensure_ascii=False) + "\n")
    return {path: names for path, (_, names) in copies.items()}


def _student_copy(path):
    """The notebook as JSON without solutions, and the names of its exercises."""
    page = copy.deepcopy(exercise.notebook(path))
    for each in exercise.judged(page["cells"], path):
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
    page["cells"] = cells
    _make_sure(page, names, path)
    return page, names


def _make_sure(page, names, path):
    """Refuse a copy in which the lines of a solution stand somewhere else."""
    text = "\n".join("".join(cell["source"]) + json.dumps(cell.get("outputs", "")) for cell in page["cells"])
    for name in names:
        if name in EXERCISES and EXERCISES[name].source in text:
            raise InputError(f"{path}, {name}", "a notebook that shows no solution", "its lines")
