"""The report on a class as a page, `grade_page.html`, and as a table, in English or Chinese.

The Chinese is looked up by the English text, in `chinese.toml` or, for slips, in `exercises.toml`. All text from
students is escaped: no file name or answer can become markup, or a formula in a spreadsheet.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator
from functools import cache, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from jinja2 import Environment

from mathpost.files import csv_text, read_text
from mathpost.teaching.course.exercise import MARKS
from mathpost.teaching.course.verdict import EXERCISES, OPEN, RIGHT, WRONG, Verdict, toml
from mathpost.teaching.workbook.folder import CHINESE as CAUSES
from mathpost.teaching.workbook.report import UNCLEAR

if TYPE_CHECKING:
    from mathpost.teaching.classroom.grade import Class, Result

LANGUAGES = ("en", "zh")
ENGLISH = {OPEN: "open"}  # where the report uses a different word
EDITED = "verdict differs from its answer: the file was edited, or saved with another edition of the course"
STYLES = {RIGHT: "right", WRONG: "wrong", OPEN: "open"}


def say(language: str, text: str) -> str:
    """Return a phrase of the report, or a cause that the workbook check names, in the language."""
    return ENGLISH.get(text, text) if language == "en" else sections()["report"].get(text) or CAUSES.get(text, text)


def mixup(language: str, name: str, sentence: str) -> str:
    """Return the sentence of a mix-up, in English if there is no Chinese for it."""
    return (language == "zh" and chinese(name, sentence)) or sentence


def why(language: str, verdict: Verdict) -> str:
    """Return the comment on an answer."""
    return mixup(language, verdict.name, verdict.mixup) or verdict.why


def to_csv(graded: Class, language: str = "en") -> str:
    """Return the table of students and exercises as CSV, with a byte order mark for spreadsheet programs.

    The columns ``student_id``, ``score`` and ``max_score`` are nbgrader's, ``percent_correct`` is otter's.
    """
    head = ["student_id", *graded.exercises, "score", "max_score", "workbooks_right", "first_wrong_cell", "cause"]
    rows: list[list[Any]] = [[*head, "percent_correct", "edited", "same_as", "trouble"]]
    for result in graded.results:
        statuses = [say(language, result.status(name) or "not handed in") for name in graded.exercises]
        wrong = [book for book in result.workbooks if book.cell]
        mark = graded.mark(result)
        same = {name for _, _, who in graded.same if result.name in who for name in who} - {result.name}
        row: list[Any] = [result.name, *statuses, *graded.points(result)]
        row += ["; ".join(each.cell for each in wrong), "; ".join(say(language, each.cause) for each in wrong)]
        row += ["" if mark is None else f"{mark:.1f}", " ".join(result.edited), "; ".join(sorted(same))]
        trouble = [f"{file}: {why}" if file else why for file, why in result.trouble]
        trouble += [f"{name}: {say(language, what)}" for _, name, what in result.changed]
        rows.append([*row, "; ".join(trouble)])
    return csv_text(rows)


def to_html(graded: Class, language: str = "en") -> str:
    """Return the report as an HTML page without scripts."""
    books = [(result.name, book) for result in graded.results for book in result.workbooks]
    functions = {function.__name__: partial(function, language) for function in (say, mixup, why)}
    template = read_text(Path(__file__).with_suffix(".html"))
    page = Environment(autoescape=True, trim_blocks=True).from_string(template, functions)
    return page.render(
        graded=graded,
        language=language,
        look=list(_attention(graded, language)),
        lacking=language == "zh" and not all(chinese(*each[:2]) for each in graded.mixups()),
        books=books,
        causes=Counter(say(language, each.cause) for _, each in books if each.cause),
        marks={status: (style, MARKS[status]) for status, style in STYLES.items()},
        edited=EDITED,
        mark=partial(_mark, graded),
        solved=Counter(name for result in graded.results for name in graded.solved(result)),
    )


def _mark(graded: Class, result: Result) -> str:
    """The mark in whole per cent, with a question mark if a file could not be read or judged."""
    mark = graded.mark(result)
    doubt = result.trouble or any(book.verdict == UNCLEAR for book in result.workbooks)
    return "" if mark is None else f"{mark:.0f}{' ?' if doubt else ''}"


def _attention(graded: Class, language: str) -> Iterator[tuple[str, str, str, str]]:
    """Yield the items that need the teacher's attention: student, file or exercise, kind, why."""
    for result in graded.results:
        for file, trouble in result.trouble:
            yield result.name, file, "not read", trouble
        for file, name, what in result.changed:
            yield result.name, file, what, name
        for name in result.edited:
            judged = result.verdicts[name]
            said = [say(language, judged.status), *([why(language, judged)] if judged.status != OPEN else [])]
            yield result.name, name, EDITED, ("。" if language == "zh" else ". ").join(said)
        for name, status in result.unknown.items():
            yield result.name, name, "not judged: the exercise is not defined here", say(language, status)
        for book in result.workbooks:
            if book.verdict == UNCLEAR and not book.why:
                yield result.name, book.name, "workbook not judged to the end", f"{book.checked}/{book.total}"


@cache
def chinese(name: str, sentence: str) -> str:
    """Return the Chinese of a mix-up; "" if there is none, as in a teacher's own exercise."""
    for pattern, wording in (*_patterns(name), *_patterns("any")):
        if found := pattern.fullmatch(sentence):
            return wording.format(*(chinese(name, part) or part for part in found.groups()))
    if name not in EXERCISES or not EXERCISES[name].detective:
        return ""
    parts = sentence
    for pattern, wording in _patterns("detective"):
        parts = pattern.sub(partial(_worded, wording), parts)
    return "" if parts == sentence else parts.removesuffix(".") + "。"


def _worded(wording: str, found: re.Match[str]) -> str:
    return wording.format(*found.groups())


@cache
def sections() -> dict[str, dict[str, str]]:
    """The Chinese by section: the sections of `chinese.toml`, and one per exercise."""
    found = dict(toml("chinese"))
    for name, words in toml("exercises").items():
        slips = {sentence: entry["zh"] for sentence, entry in words.get("slips", {}).items()}
        found[name] = slips | words.get("said", {})
    return found


@cache
def _patterns(section: str) -> list[tuple[re.Pattern[str], str]]:
    """The entries of a section, keys as patterns; in the detective's, a gap is one word."""
    blank, ignore = (r"(\S+?)", re.IGNORECASE) if section == "detective" else ("(.+?)", 0)
    entries = sections().get(section, {}).items()
    return [(re.compile(re.escape(key).replace(r"\{\}", blank), ignore), wording) for key, wording in entries]
