"""The verdict on one handed-in file: its answers judged again, its formulas checked, digests to find copies.

Both kinds of record are plain data that follow from the file's content and this package alone. A file that is too
large is reported with the figure, and the class goes on: everything is counted before it is judged, and each
hand-in has a bound of time, too, for what no count foresees.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mathpost.errors import InputError
from mathpost.teaching.bounds import TooLarge
from mathpost.teaching.course import exercise
from mathpost.teaching.course.verdict import OPEN, Verdict
from mathpost.teaching.workbook import Reference, check_file
from mathpost.teaching.workbook.folder import DAMAGED
from mathpost.teaching.workbook.report import TOO_LARGE, FileReport
from mathpost.teaching.workbook.sheet.file import read

NOTEBOOK_LIMIT = 16 * 2**20  # bytes; a lesson with its pictures has less than one million
MOST_CELLS, MOST_STORED = 2000, 1000  # cells and stored answers of a notebook
LONGEST = 20_000  # characters of an answer
MOST_DIFFERENT = 20  # answers to one exercise that are judged, in all notebooks of a student

Tried = dict[str, set[str]]  # from an exercise to digests of the different answers to it


@dataclass(frozen=True)
class Cell:
    """A cell of a notebook that is not empty."""

    source: str  # a digest of it
    length: int
    asks: tuple[str, ...]  # names of the exercises that it checks


@dataclass(frozen=True)
class Notebook:
    """The record of a notebook."""

    given: tuple[tuple[str, str], ...]  # (exercise, digest of the answer) of each different answer
    verdicts: tuple[Verdict, ...]  # without the answers
    answers: str  # a digest of them; "" if there are none
    cells: tuple[Cell, ...]


@dataclass(frozen=True)
class Workbook:
    """The record of a workbook's check."""

    name: str
    verdict: str  # "right", "wrong", "not judged" or "not read"
    checked: int = 0
    total: int = 0
    cell: str = ""  # the first wrong one
    cause: str = ""
    message: str = ""
    why: str = ""  # the reason why it was not judged, or not read
    content: str = ""  # a digest of all formulas and numbers


def digest(content: bytes | str) -> str:
    """The SHA-256 of bytes or text."""
    return hashlib.sha256(content.encode() if isinstance(content, str) else content).hexdigest()


def source(cell: dict[str, Any]) -> str:
    """The source of a cell without trailing spaces."""
    return "\n".join(map(str.rstrip, "".join(cell["source"]).split("\n"))).strip()


def notebook(path: Path, tried: Tried) -> Notebook:
    """Return the `Notebook` of a file.

    `tried` are the same student's answers in other notebooks, see `count`. Raises `InputError` if the file is not a
    notebook, `TooLarge` if it contains too much.
    """
    if (size := path.stat().st_size) > NOTEBOOK_LIMIT:
        raise TooLarge(f"{size / 2**20:.0f} MB")
    cells = exercise.notebook(path)["cells"]
    if len(cells) > MOST_CELLS:
        raise TooLarge(f"{len(cells)} cells")
    answers = exercise.stored(cells, path)
    if len(answers) > MOST_STORED:
        raise TooLarge(f"{len(answers)} stored answers")
    for each in answers:
        if len(each.answer) > LONGEST:
            raise TooLarge(f"an answer of {len(each.answer)} characters")
    given = tuple(dict.fromkeys((each.name, digest(f"{each.student} {each.answer}")) for each in answers))
    count(given, tried)
    verdicts = [exercise.judged_anew(each) for each in answers]
    said = json.dumps([(each.name, each.answer) for each in verdicts if each.status != OPEN])
    texts = [source(cell) for cell in cells]
    return Notebook(
        given,
        tuple(Verdict(v.name, v.status, v.why, None, v.edited, v.mixup, v.student) for v in verdicts),
        digest(said) if said != "[]" else "",
        tuple(Cell(digest(text), len(text), tuple(exercise.asked(text))) for text in texts if text),
    )


def count(given: Iterable[tuple[str, str]], tried: Tried) -> None:
    """Add the answers `given` in a notebook to those `tried`, a dict of each exercise to a set.

    Raises `TooLarge`, and adds nothing, if that makes more than anybody needs.
    """
    together = {name: tried.get(name, set()) | {a for n, a in given if n == name} for name in dict(given)}
    for name, different in together.items():
        if len(different) > MOST_DIFFERENT:
            raise TooLarge(f"{len(different)} different answers to {name}")
    tried.update(together)


def workbook(path: Path, reference: Reference | None = None) -> Workbook:
    """Return the `Workbook` of a file, compared with a reference if there is one."""
    try:
        report = check_file(path) if reference is None else reference.check(path)
        cells = {} if _too_large(report) else read(path).cells
    except InputError as error:
        return Workbook(path.name, DAMAGED, why=f"expected {error.expected}, found {error.found}")
    written = sorted((place, repr(cell.formula or cell.number)) for place, cell in cells.items())
    first = [(fault.cell, fault.cause, fault.message) for fault in report.faults[:1]] or [("", "", "")]
    why = report.seen[0] if _too_large(report) else ""
    content = digest(json.dumps(written)) if written else ""
    return Workbook(path.name, report.verdict, report.checked, report.total, *first[0], why, content)


def _too_large(report: FileReport) -> bool:
    return any(said.startswith(TOO_LARGE) for said in report.seen)
