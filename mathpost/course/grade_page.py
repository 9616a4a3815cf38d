"""The report on a class as a page and as a table, in English or Chinese.

Everything that a student wrote is escaped: a file's name or an answer cannot become part of the page, nor a formula
of the spreadsheet program that opens the table.
"""

import html
from collections import Counter
from pathlib import Path

from mathpost.course import chinese
from mathpost.course.exercise import MARKS
from mathpost.course.verdict import OPEN, RIGHT, WRONG
from mathpost.workbook.report import csv_table

LANGUAGES = ("en", "zh")
ENGLISH = {OPEN: "open"}  # where the report says something else than its programs
EDITED = "verdict differs from its answer: the file was edited, or saved with another edition of the course"
SAME = {
    "file": "the same file",
    "text": "the same answers and the same text of cells",
    "cells": "the same formulas and numbers",
}
CLASSES = {RIGHT: "right", WRONG: "wrong", OPEN: "open", "": ""}


def say(language, text):
    """A word of the report."""
    return chinese.word(text) if language == "zh" else ENGLISH.get(text, text)


def to_csv(graded, language="en"):
    """Return the table of students and exercises as CSV, with a mark that tells spreadsheet programs the encoding.

    The columns ``student_id``, ``score`` and ``max_score`` are those of nbgrader's export, ``percent_correct`` is
    otter's.
    """
    head = ["student_id", *graded.exercises, "score", "max_score", "workbooks_right", "first_wrong_cell", "cause"]
    rows = [[*head, "percent_correct", "edited", "same_as", "trouble"]]
    for result in graded.results:
        statuses = [say(language, result.status(name) or "not handed in") for name in graded.exercises]
        wrong = [each for each in result.workbooks if each.cell]
        cells = [[each.cell for each in wrong], [say(language, each.cause) for each in wrong]]
        mark = graded.mark(result)
        mark = "" if mark is None else f"{mark:.1f}"
        same = {name for _, _, who in graded.same if result.name in who for name in who} - {result.name}
        trouble = [f"{file}: {why}" if file else why for file, why in result.trouble]
        row = [
            result.name,
            *statuses,
            *graded.points(result),
            *map("; ".join, cells),
            mark,
            " ".join(result.edited),
        ]
        rows.append([*row, "; ".join(sorted(same)), "; ".join(trouble)])
    return csv_table(rows)


def to_html(graded, language="en"):
    """Return the report as a page of its own, without scripts."""
    word = lambda text: html.escape(say(language, text))  # noqa: E731
    results = graded.results
    summary = say(
        language, "{students} students, {notebooks} notebooks, {workbooks} workbooks; {exercises} exercises count."
    ).format(
        students=len(results),
        notebooks=sum(each.notebooks for each in results),
        workbooks=sum(len(each.workbooks) for each in results),
        exercises=len(graded.exercises),
    )
    judged_anew = (
        "Answers were judged anew from what the notebooks store. "
        "A right answer that was typed after a neighbour's looks like any other."
    )
    mixups, count = graded.mixups(), max(len(results), 1)
    lacking = language == "zh" and not all(chinese.mixup(name, why) for name, why, _ in mixups)
    own_words = "A mix-up without a Chinese wording, as of a teacher's own exercise, stands in its own words."
    mixups = [(name, _mixup(language, name, why), _bar(number, count)) for name, why, number in mixups]
    failed = [(name, tried, _bar(wrong, tried)) for name, tried, wrong in graded.failed()]
    books = [(result.name, book) for result in results for book in result.workbooks]
    same = [(say(language, SAME[kind]), file, ", ".join(who)) for kind, file, who in graded.same]
    look = list(_attention(graded, word, language))
    parts = [
        f'<!DOCTYPE html><html lang="{language}"><meta charset="utf-8">',
        f"<title>{word('A class')}</title>",
        f"<style>\n{Path(__file__).with_suffix('.css').read_text(encoding='utf-8')}</style>",
        f"<h1>{word('A class')}</h1><p>{html.escape(summary)}</p><p class='key'>{word(judged_anew)}</p>",
        _section(word, "What needs a look", ("student", "file", "what", "why"), look),
        _section(word, "Mix-ups by frequency", ("exercise", "why", "students"), mixups, own_words * lacking),
        _section(word, "Exercises that most failed", ("exercise", "tried", "not solved"), failed),
    ]
    if books:
        heads = ("student", "file", "verdict", "checked", "cell", "cause", "why")
        rows = []
        for who, book in books:
            verdict, cause = say(language, book.verdict), say(language, book.cause)
            rows.append((who, book.file, verdict, f"{book.checked}/{book.total}", book.cell, cause, book.message))
        parts.append(_section(word, "Workbooks: the first wrong cell", heads, rows))
        causes = Counter(say(language, book.cause) for _, book in books if book.cause)
        rows = [(cause, _bar(number, len(books))) for cause, number in causes.most_common()]
        parts.append(_section(word, "Causes by frequency", ("cause", "students"), rows))
    no_proof = "The same beyond what the course handed out. A reason to ask, no proof."
    parts.append(_section(word, "The same hand-ins", ("what", "file", "student"), same, no_proof))
    parts.append(f"<h2>{word('Students and exercises')}</h2>{_table(graded, word, language)}")
    if graded.notes:
        notes = "".join(f"<li>{html.escape(note)}" for note in graded.notes)
        parts.append(f"<h2>{word('What was not done, or not bounded')}</h2><ul>{notes}</ul>")
    return "\n".join([*parts, "</html>\n"])


def _mixup(language, name, sentence):
    """The sentence that names a mix-up, in its own words if there are no Chinese ones."""
    return (language == "zh" and chinese.mixup(name, sentence)) or sentence


def _why(language, verdict):
    """What is said of an answer."""
    return _mixup(language, verdict.name, verdict.mixup) or verdict.why


class _Safe(str):
    """Text that is HTML already."""


def _bar(number, of):
    return _Safe(f'<span class="bar" style="width:{6 * number / of:.2f}rem"></span>{number}')


def _section(word, title, heads, rows, said=""):
    """A heading and a table, or "none"."""
    text = f"<h2>{word(title)}</h2>" + (f"<p class='key'>{word(said)}</p>" if said and rows else "")
    if not rows:
        return f"{text}<p>{word('None.')}</p>"
    cells = ("".join(f"<td>{_escaped(cell)}" for cell in row) for row in rows)
    return f"{text}<table><tr>{''.join(f'<th>{word(head)}' for head in heads)}<tr>{'<tr>'.join(cells)}</table>"


def _escaped(cell):
    return cell if isinstance(cell, _Safe) else html.escape(str(cell))


def _attention(graded, word, language):
    """What a person should look at: student, file or exercise, kind, why."""
    for result in graded.results:
        found = [(file, "not read", why) for file, why in result.trouble]
        for name in result.edited:
            judged = result.verdicts[name]
            said = [say(language, judged.status), *([_why(language, judged)] if judged.status != OPEN else [])]
            found.append((name, EDITED, ("。" if language == "zh" else ". ").join(said)))
        for name, status in result.unknown.items():
            found.append((name, "not judged: the exercise is not defined here", say(language, status)))
        for name, status in result.reran.items():
            found.append((name, "different when the notebook is run", say(language, status)))
        for book in result.workbooks:
            if book.verdict == "unclear":
                found.append((book.file, "workbook not judged to the end", f"{book.checked}/{book.total}"))
        yield from ((result.name, what, _Safe(word(kind)), why) for what, kind, why in found)


def _table(graded, word, language):
    """Students and exercises, a mark a cell; what was said of a wrong answer where the pointer rests."""
    marks = ", ".join(f'<span class="{CLASSES[s]}">{MARKS[s]}</span> {word(s)}' for s in (RIGHT, WRONG, OPEN))
    key = f"<p class='key'>{marks}, <span class='edited'>&nbsp;●&nbsp;</span> {word(EDITED)}</p>"
    books = any(result.workbooks for result in graded.results)
    heads = [f"<th class=s>{word('student')}"]
    heads += [f"<th>{word(head)}" for head in ("mark, %", "solved", *(["workbooks right"] * books))]
    heads += [f"<th class=e><span>{html.escape(name)}</span>" for name in graded.exercises]
    rows, solved = [], Counter()
    for result in graded.results:
        mark, solves = graded.mark(result), [n for n in graded.exercises if result.status(n) == RIGHT]
        # A file that was not read or judged may have held more.
        doubt = " ?" * any([*result.trouble, *(book.verdict == "unclear" for book in result.workbooks)])
        numbers = ["" if mark is None else f"{mark:.0f}{doubt}", len(solves), *[graded.points(result)[2]] * books]
        row = f"<td class=s>{html.escape(result.name)}" + "".join(f"<td class=n>{each}" for each in numbers)
        for name in graded.exercises:
            status = result.status(name)
            classes = " ".join(filter(None, ("m", CLASSES[status], "edited" * (name in result.edited))))
            why = f' title="{html.escape(_why(language, result.verdicts[name]))}"' if status == WRONG else ""
            row += f'<td class="{classes}"{why}>{MARKS.get(status, "")}'
        rows.append(row)
        solved.update(solves)
    last = f"<td class=s>{word('class')}, {word('solved')}<td><td class=n>{solved.total()}" + "<td>" * books
    rows.append(last + "".join(f'<td class="m">{solved[name]}' for name in graded.exercises))
    return f'{key}<div class="wide"><table><tr>{"".join(heads)}<tr>{"<tr>".join(rows)}</table></div>'
