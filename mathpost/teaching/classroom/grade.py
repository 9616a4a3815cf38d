"""A class at a glance: who solved what, which mix-ups are common, and what needs the teacher's attention.

Answers are judged again from what the notebooks store, so an edited verdict shows, and no student's code is run. A
right answer copied from a neighbour cannot be told from any other. `handed_in` assigns files to students,
`judged` judges one file, and `grade_page` writes the report.
"""

from __future__ import annotations

import tempfile
import time
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mathpost import files
from mathpost.errors import InputError, internal
from mathpost.teaching.bounds import TooLarge, bounded
from mathpost.teaching.classroom import judged
from mathpost.teaching.classroom.handed_in import Student, collect
from mathpost.teaching.classroom.kept import Kept
from mathpost.teaching.course import exercise
from mathpost.teaching.course.verdict import EXERCISES, OPEN, RIGHT, WRONG, Verdict
from mathpost.teaching.workbook import Reference
from mathpost.teaching.workbook.folder import DAMAGED

if TYPE_CHECKING:
    from mathpost.teaching.classroom.judged import Notebook, Tried, Workbook

COURSE = Path(__file__).parents[3]
ORDER = (OPEN, WRONG, RIGHT)  # the best of several answers to one exercise counts
TEXT_ENOUGH = 80  # characters of their own that two students must share to be reported
SHARED_BY_CLASS = 0.5  # of a class of ten or more: cells that more students have are taken as handed out
NAMED = 'an exercise such as "07-pivot" or a lesson such as "07"'
FILE, TEXT = "the same file", "the same answers and the same text of cells"
CELLS = "the same formulas and numbers"
DUPLICATED, RETYPED = "checked in more than one cell", "its check is not as it was handed out"
SECONDS = 120.0  # of the processor, for all files of one student

Work = tuple[str, str, Any]  # kind, file, content


@dataclass(frozen=True)
class Rules:
    """The exercises that count, and how much."""

    students: tuple[str, ...] = ()  # those expected to hand in
    # Such as "07-pivot", or lessons such as "07"; empty: all lessons that anybody handed in.
    exercises: tuple[str, ...] = ()
    # Per exercise, or for each exercise of a lesson; 1 if not given.
    points: dict[str, float] = field(default_factory=dict)
    notebooks: float = 1.0  # weights of the two parts, if both were handed in
    workbooks: float = 1.0
    expected_workbooks: int = 1


@dataclass
class Result:
    """One student."""

    name: str
    verdicts: dict[str, Verdict] = field(default_factory=dict)  # exercise → the best in the notebooks
    edited: list[str] = field(default_factory=list)  # exercises whose saved verdict does not fit the answer
    mixups: set[tuple[str, str]] = field(default_factory=set)  # (exercise, sentence) of each mix-up found
    workbooks: list[judged.Workbook] = field(default_factory=list)
    trouble: list[tuple[str, str]] = field(default_factory=list)  # (file, why): not read, too large, or empty
    # (file, exercise, what): whose check is not the course's one cell.
    changed: list[tuple[str, str, str]] = field(default_factory=list)
    lessons: set[str] = field(default_factory=set)  # numbers of the lessons handed in
    unknown: dict[str, str] = field(default_factory=dict)  # exercise not defined here → its status in the notebook
    numbers: set[str] = field(default_factory=set)  # whose drawn numbers were used; "" for those of the lesson
    works: list[Work] = field(default_factory=list)  # (kind, file, content) to compare with other students'
    notebooks: int = 0

    def status(self, name: str) -> str:
        """Return the status of an exercise; "" if its lesson was not handed in."""
        found = self.verdicts.get(name)
        return found.status if found else OPEN if lesson_of(name) in self.lessons else ""


@dataclass
class Class:
    """The result of `grade`."""

    results: list[Result]  # by name
    exercises: list[str]  # those that count
    rules: Rules
    same: list[tuple[str, str, list[str]]] = field(default_factory=list)  # (kind, file, students)
    notes: list[str] = field(default_factory=list)  # what was not done

    def solved(self, result: Result) -> list[str]:
        """Return the exercises that a student has solved."""
        return [name for name in self.exercises if result.status(name) == RIGHT]

    def points(self, result: Result) -> tuple[float, float, int]:
        """Return a student's points, the points possible, and the number of right workbooks."""
        said, right = self.rules.points, sum(each.verdict == "right" for each in result.workbooks)
        worth = {name: said.get(name, said.get(lesson_of(name), 1)) for name in self.exercises}
        had = sum(worth[name] for name in self.solved(result))
        return had, sum(worth.values()), min(right, self.rules.expected_workbooks)

    def mark(self, result: Result) -> float | None:
        """Return the mark in per cent, weighted by the rules; None if nothing counts."""
        had, possible, right = self.points(result)
        parts = [(self.rules.notebooks, had / possible)] if possible else []
        if any(each.workbooks for each in self.results):
            parts.append((self.rules.workbooks, right / self.rules.expected_workbooks))
        total = sum(weight for weight, _ in parts)
        return 100 * sum(weight * part for weight, part in parts) / total if total else None

    def mixups(self) -> list[tuple[str, str, int]]:
        """Return (exercise, sentence, number of students) of each mix-up, the most frequent first."""
        counts = Counter(each for result in self.results for each in result.mixups)
        return [(*each, count) for each, count in sorted(counts.items(), key=lambda item: (-item[1], item[0]))]

    def failed(self) -> list[tuple[str, int, int]]:
        """Return (exercise, how many tried it, how many did not solve it), the worst first."""
        rows = []
        for name in self.exercises:
            statuses = Counter(result.status(name) for result in self.results)
            if wrong := statuses[WRONG]:
                rows.append((name, statuses[RIGHT] + wrong, wrong))
        return sorted(rows, key=lambda row: (-row[2] / row[1], -row[2], row[0]))


def grade(
    folder: Path | str,
    rules: Rules | None = None,
    *,
    lessons: Path | str | None = None,
    kept: Kept | None = None,
    reference: Reference | None = None,
    progress: Callable[[int, int, str], object] | None = None,
) -> Class:
    """Judge the work of a class, in a folder laid out as `handed_in` describes; return a `Class`.

    `lessons` is the folder of the notebooks as handed out, by default the course's; their content is no student's
    work. `kept`, a `kept.Kept`, has the records of earlier verdicts; workbooks are compared with the
    `reference`, if there is one. After each workbook ``progress(done, total, name)`` is called. An empty folder is
    an `InputError`; a bad file goes into its student's `trouble`.
    """
    kept = kept or Kept()
    rules = rules or Rules()
    if lessons is not None and not Path(lessons).is_dir():
        raise InputError(str(lessons), "the folder of the notebooks as they were handed out", "none")
    handed_out = sorted(Path(lessons).rglob("*.ipynb") if lessons else (COURSE / "notebooks").glob("*.ipynb"))
    with tempfile.TemporaryDirectory() as unpacked:
        students = collect(folder, unpacked, [path.stem for path in handed_out])
        course = _handed_out(handed_out)
        slow, done = sum(len(each.workbooks) for each in students), count(1)
        step = (lambda name: progress(next(done), slow, name)) if progress else str
        results = [_student(each, course, kept, step, reference) for each in students]
    _say_whose_numbers(results)
    same = _same(results)
    missing = set(rules.students) - {each.name for each in results}
    results = sorted([*results, *map(Result, missing)], key=lambda each: each.name)
    asked = set(rules.exercises) or {lesson for each in results for lesson in each.lessons}
    exercises = [name for name in sorted(EXERCISES) if {name, lesson_of(name)} & asked]
    return Class(results, exercises, rules, same)


def _handed_out(notebooks: Iterable[Path]) -> set[str]:
    """Digests of the course's notebooks, workbooks and cells; "check of 01-sign" for each exercise in them."""
    files = (*notebooks, *(COURSE / "data").glob("**/*.xlsx"))
    sources = [judged.source(cell) for path in notebooks for cell in exercise.notebook(path)["cells"]]
    checks = {f"check of {name}" for text in sources for name in exercise.asked(text)}
    return {judged.digest(path.read_bytes()) for path in files} | set(map(judged.digest, sources)) | checks


def _say_whose_numbers(results: Iterable[Result]) -> None:
    """In a class with drawn numbers, note who used those of the lesson or of another student."""
    owners = Counter(name for result in results for name in result.numbers)
    for result in results if any(owners) else ():
        for name in sorted(result.numbers):
            if not name:
                result.trouble.append(("", "answered with the numbers of the lesson, not with their own"))
            elif owners[name] > 1:
                result.trouble.append(("", f"answered with the numbers of {name}, as {owners[name] - 1} more did"))


def read_rules(path: Path | str) -> Rules:
    """Return the `Rules` of a TOML file; raise `InputError` for an unknown key or a wrong value."""
    file, known = files.TomlTable(files.read_toml(path), str(path)), {*EXERCISES, *map(lesson_of, EXERCISES)}
    points = file.table("points", optional=True)
    for name in points.content.keys() - known:
        raise InputError(points.where, NAMED, repr(name))
    number = files.only_if(lambda value: files.a_number(value) >= 0), "a number, 0 or more"
    whole = files.only_if(lambda value: type(value) is int and value > 0), "a whole number above 0"
    some = files.only_if(lambda names: set(names) <= known, files.each(str))
    rules = Rules(
        students=tuple(file.take("students", files.each(str), "a list of names in quotes", ())),
        exercises=tuple(file.take("exercises", some, f"a list of names in quotes, each {NAMED}", ())),
        points={name: points.take(name, *number) for name in list(points.content)},
        notebooks=file.take("notebooks", *number, 1.0),
        workbooks=file.take("workbooks", *number, 1.0),
        expected_workbooks=file.take("expected_workbooks", *whole, 1),
    )
    file.done()
    return rules


def lesson_of(name: str) -> str:
    """The number of the lesson of an exercise, as text."""
    return name.split("-")[0]


def _student(
    student: Student, handed_out: set[str], kept: Kept, step: Callable[[str], object], reference: Reference | None
) -> Result:
    """Judge one student's files; `handed_out` are the digests of the course's files and of its cells."""
    result, begun = Result(student.name, trouble=list(student.refused)), time.process_time()
    tried: Tried = {}
    for path in (*student.notebooks, *student.workbooks):
        kind = "a notebook" if path in student.notebooks else "a workbook"
        try:
            if not path.stat().st_size:
                raise InputError(path.name, kind, "an empty file")
            if (left := SECONDS - (time.process_time() - begun)) <= 0:
                raise TooLarge(f"more than {SECONDS:g} s for the files before it")
            with bounded(left):
                content = judged.digest(path.read_bytes())
                if kind == "a notebook":
                    found = _notebook(path, content, tried, kept)
                    _add_notebook(result, path, content, found, handed_out)
                elif content not in handed_out:
                    _add_workbook(result, path, content, _workbook(path, content, kept, reference))
        except InputError as error:
            result.trouble.append((path.name, f"expected {error.expected}, found {error.found}"))
        except TooLarge as error:
            result.trouble.append((path.name, f"not judged: too large ({error})"))
        except OSError as error:
            result.trouble.append((path.name, error.strerror or str(error)))
        except Exception as error:  # whatever it is: the others are still judged
            result.trouble.append((path.name, internal(error)))
        if kind == "a workbook":
            step(f"{student.name}: {path.name}")
    kept.commit()
    if not (result.notebooks or result.workbooks or result.trouble):
        result.trouble.append(("", "nothing was handed in"))
    return result


def _notebook(path: Path, content: str, tried: Tried, kept: Kept) -> Notebook:
    """The record of a notebook, kept or new."""
    if any(not each.solve.__module__.startswith("mathpost.teaching.course.") for each in EXERCISES.values()):
        return judged.notebook(path, tried)  # judged by a teacher's own exercises, which may change
    if found := kept.get("notebook", content):
        judged.count(found.given, tried)
        return found
    found = judged.notebook(path, tried)
    kept.put("notebook", content, found)
    return found


def _workbook(path: Path, content: str, kept: Kept, reference: Reference | None) -> Workbook:
    """The record of a workbook, kept or new; with another reference it is another one."""
    key = content if reference is None else f"{content} {reference.digest}"
    if found := kept.get("workbook", key):
        return replace(found, name=path.name)
    found = judged.workbook(path, reference)
    if found.verdict != DAMAGED:  # which may differ where LibreOffice is installed
        kept.put("workbook", key, found)
    return found


def _add_notebook(result: Result, path: Path, content: str, found: Notebook, handed_out: set[str]) -> None:
    """Add the answers in one notebook."""
    result.notebooks += 1
    if not found.cells:
        result.trouble.append((path.name, "no cell has anything in it"))
    names = {name for each in found.cells for name in each.asks} | {each.name for each in found.verdicts}
    result.lessons |= {lesson_of(name) for name in names & EXERCISES.keys()}
    for each in found.verdicts:
        if each.edited and each.name not in result.edited:
            result.edited.append(each.name)
        if each.mixup:
            result.mixups.add((each.name, each.mixup))
        if each.name not in EXERCISES:
            result.unknown[each.name] = each.status
            continue
        if EXERCISES[each.name].drawn:
            result.numbers.add(each.student)
        best = max(result.verdicts.get(each.name, each), each, key=lambda verdict: ORDER.index(verdict.status))
        result.verdicts[each.name] = best
    result.changed += [(path.name, *each) for each in _changed(found, handed_out)]
    own = [(each.source, each.length) for each in found.cells if each.source not in handed_out]
    if (own or found.answers) and content not in handed_out:
        result.works += [(FILE, path.name, content), (TEXT, path.name, (found.answers, own))]


def _changed(found: Notebook, handed_out: set[str]) -> Iterator[tuple[str, str]]:
    """Yield the exercises whose check is not the course's one cell, and how it differs."""
    checks = Counter(name for each in found.cells for name in dict.fromkeys(each.asks))
    kept = {name for each in found.cells if each.source in handed_out for name in each.asks}
    for name, cells in checks.items():
        if cells > 1:
            yield name, DUPLICATED
        elif name not in kept and f"check of {name}" in handed_out:
            yield name, RETYPED


def _add_workbook(result: Result, path: Path, content: str, found: Workbook) -> None:
    """Add the check of one workbook."""
    result.workbooks.append(found)
    if found.why:
        result.trouble.append((path.name, found.why))
    if found.content:
        result.works += [(FILE, path.name, content), (CELLS, path.name, found.content)]


def _same(results: Sequence[Result]) -> list[tuple[str, str, list[str]]]:
    """Find work that students share beyond what was handed out: its kind, the files, the students."""
    works = [(result.name, *work) for result in results for work in result.works]
    has = Counter(text for _, kind, _, content in works if kind == TEXT for text in set(content[1]))
    having: dict[str, dict[Any, list[tuple[str, str]]]] = {kind: defaultdict(list) for kind in (FILE, TEXT, CELLS)}
    for student, kind, file, content in works:
        if kind == TEXT:
            answers, texts = content
            beyond = tuple(t for t in texts if len(results) < 10 or has[t] <= SHARED_BY_CLASS * len(results))
            content = (answers, beyond) if sum(length for _, length in beyond) >= TEXT_ENOUGH else ""
        having[kind][content].append((student, file))
    found: dict[tuple[str, ...], str] = {}
    for kind, groups in having.items():
        for content, having_it in groups.items():
            who, names = (sorted(set(column)) for column in zip(*having_it, strict=True))
            if len(who) > 1 and content:
                found.setdefault((", ".join(names), *who), kind)
    return [(kind, names, who) for (names, *who), kind in found.items()]
