"""The report on a class as a page and as a table, in English or Chinese.

Everything that a student wrote is escaped: a file's name or an answer cannot become part of the page, nor a formula
of the spreadsheet program that opens the table.
"""

import csv
import html
import io
from collections import Counter, defaultdict

from mathpost.course.exercise import MARKS
from mathpost.course.verdict import OPEN, RIGHT, WRONG

ENGLISH = {
    RIGHT: "right",
    WRONG: "not yet",
    OPEN: "open",
    "": "not handed in",
    "title": "A class",
    "summary": "{students} students, {notebooks} notebooks, {workbooks} workbooks; {exercises} exercises count.",
    "same_rule": "Answers were judged anew from what the notebooks store. A right answer that was typed after a "
    "neighbour's looks like any other.",
    "attention": "What needs a look",
    "edited": "verdict differs from its answer: the file was edited, or saved with another edition of the course",
    "trouble": "not read",
    "unknown": "not judged: the exercise is not defined here",
    "reran": "different when the notebook is run",
    "unclear": "workbook not judged to the end",
    "mixups": "Mix-ups by frequency",
    "failed": "Exercises that most failed",
    "workbooks": "Workbooks: the first wrong cell",
    "causes": "Causes by frequency",
    "same": "The same hand-ins",
    "same_why": "The same beyond what the course handed out. A reason to ask, no proof.",
    "file": "the same file",
    "text": "the same answers and the same text of cells",
    "cells": "the same formulas and numbers",
    "table": "Students and exercises",
    "student": "student",
    "exercise": "exercise",
    "count": "students",
    "tried": "tried",
    "not_solved": "not solved",
    "mark": "mark, %",
    "solved": "solved",
    "points": "points",
    "cell": "cell",
    "cause": "cause",
    "why": "why",
    "verdict": "verdict",
    "checked": "checked",
    "name": "file",
    "none": "None.",
    "kind": "what",
    "notes": "What was not done, or not bounded",
    "class": "class",
    "right workbooks": "workbooks right",
}
CHINESE = {
    RIGHT: "正确",
    WRONG: "未通过",
    OPEN: "未作答",
    "": "未提交",
    "title": "班级报告",
    "summary": "{students} 名学生，{notebooks} 个笔记本，{workbooks} 个工作簿，计分练习 {exercises} 题。",
    "same_rule": "答案根据笔记本中保存的数据重新评判，抄来的正确答案与自己得出的无法区分。",
    "attention": "需要查看",
    "edited": "保存的结论与答案不符：文件被改动，或用另一版课程保存",
    "trouble": "无法读取",
    "unknown": "未评判：此处没有定义该练习",
    "reran": "重新运行后结果不同",
    "unclear": "工作簿未能完全判定",
    "mixups": "常见混淆（按人数）",
    "failed": "错误最多的练习",
    "workbooks": "工作簿：第一个错误单元格",
    "causes": "错误原因（按次数）",
    "same": "相同的作业",
    "same_why": "除课程下发的内容外仍然相同。这是询问的理由，不是证据。",
    "file": "文件完全相同",
    "text": "答案与单元格文字相同",
    "cells": "公式与数值相同",
    "table": "学生与练习",
    "student": "学生",
    "exercise": "练习",
    "count": "人数",
    "tried": "作答",
    "not_solved": "未解出",
    "mark": "成绩 %",
    "solved": "已解出",
    "points": "得分",
    "cell": "单元格",
    "cause": "原因",
    "why": "说明",
    "verdict": "结论",
    "checked": "已检查",
    "name": "文件",
    "none": "无。",
    "kind": "内容",
    "notes": "未做或未限制的事项",
    "class": "全班",
    "right workbooks": "正确工作簿",
}
LANGUAGES = {"en": ENGLISH, "zh": CHINESE}
STYLE = """
body { font: 15px/1.45 system-ui, sans-serif; margin: 2rem auto; max-width: 76rem; padding: 0 1rem; color: #1c2733;
 background: white }
h1 { font-size: 1.5rem } h2 { font-size: 1.15rem; margin-top: 2rem }
table { border-collapse: collapse } th, td { text-align: left; padding: .2rem .6rem; vertical-align: top }
th { font-weight: 600; background: #eef2f6 } td { border-top: 1px solid #dde4ea }
td.n { text-align: right; font-variant-numeric: tabular-nums }
.bar { display: inline-block; height: .7em; background: #d55e00; margin-right: .4em }
.wide { overflow-x: auto }
.wide th.s, .wide td.s { position: sticky; left: 0; background: white; white-space: nowrap }
.wide th.e { font-weight: 400; font-size: .8rem; vertical-align: bottom; padding: .2rem }
.wide th.e span { writing-mode: vertical-rl; transform: rotate(180deg) }
.wide td.m { text-align: center; padding: .2rem }
.right { color: #007a5a } .wrong { color: #b34700 } .open { color: #8a97a5 } .edited { background: #ffd9e6 }
p.key { color: #4b5a69 }
"""
CLASSES = {RIGHT: "right", WRONG: "wrong", OPEN: "open", "": ""}


def say(language, text):
    """A word of the report; causes are the workbook check's."""
    if language == "zh" and text not in CHINESE:
        from mathpost.workbook.folder import CHINESE as CAUSES  # slow to import, and needed for workbooks only

        return CAUSES.get(text, text)
    return LANGUAGES[language].get(text, text)


def to_csv(graded, language="en"):
    """Return the table of students and exercises as CSV, with a mark that tells spreadsheet programs the encoding.

    The columns ``student_id``, ``score`` and ``max_score`` are those of nbgrader's export, ``percent_correct`` is
    otter's.
    """
    head = ["student_id", *graded.exercises, "score", "max_score", "workbooks_right", "first_wrong_cell", "cause"]
    rows = [[*head, "percent_correct", "edited", "same_as", "trouble"]]
    same = defaultdict(set)
    for _, _, who in graded.same:
        for name in who:
            same[name] |= {*who} - {name}
    for result in graded.results:
        had, possible, right = graded.points(result)
        mark = graded.mark(result)
        wrong = [each for each in result.workbooks if each.cell]
        rows.append(
            [
                result.name,
                *(say(language, result.status(name)) for name in graded.exercises),
                had,
                possible,
                right,
                "; ".join(each.cell for each in wrong),
                "; ".join(say(language, each.cause) for each in wrong),
                "" if mark is None else f"{mark:.1f}",
                " ".join(result.edited),
                "; ".join(sorted(same[result.name])),
                "; ".join(f"{file}: {why}" if file else why for file, why in result.trouble),
            ]
        )
    text = io.StringIO()
    csv.writer(text).writerows([[_harmless(cell) for cell in row] for row in rows])
    return "\ufeff" + text.getvalue()


def _harmless(cell):
    """A text that begins as a formula does is shown by spreadsheet programs instead of calculated."""
    return f"'{cell}" if isinstance(cell, str) and cell[:1] in ("=", "+", "-", "@", "\t", "\r") else cell


def to_html(graded, language="en"):
    """Return the report as a page of its own, without scripts."""
    word = lambda text: html.escape(say(language, text))  # noqa: E731
    results = graded.results
    summary = LANGUAGES[language]["summary"].format(
        students=len(results),
        notebooks=sum(each.notebooks for each in results),
        workbooks=sum(len(each.workbooks) for each in results),
        exercises=len(graded.exercises),
    )
    count = max(len(results), 1)
    mixups = [(name, why, _bar(number, count)) for name, why, number in graded.mixups()]
    failed = [(name, tried, _bar(wrong, tried)) for name, tried, wrong in graded.failed()]
    books = [
        (
            result.name,
            book.file,
            say(language, book.verdict),
            f"{book.checked}/{book.total}",
            *_first(book, language),
        )
        for result in results
        for book in result.workbooks
    ]
    causes = Counter(book.cause for result in results for book in result.workbooks if book.cause)
    same = [(say(language, kind), file, ", ".join(who)) for kind, file, who in graded.same]
    parts = [
        f'<!DOCTYPE html><html lang="{language}"><meta charset="utf-8">',
        f"<title>{word('title')}</title><style>{STYLE}</style>",
        f"<h1>{word('title')}</h1><p>{html.escape(summary)}</p><p class='key'>{word('same_rule')}</p>",
        _section(word, "attention", ("student", "name", "kind", "why"), list(_attention(graded, language))),
        _section(word, "mixups", ("exercise", "why", "count"), mixups),
        _section(word, "failed", ("exercise", "tried", "not_solved"), failed),
    ]
    if books:
        heads = ("student", "name", "verdict", "checked", "cell", "cause", "why")
        parts.append(_section(word, "workbooks", heads, books))
        rows = [(say(language, cause), _bar(number, len(books))) for cause, number in causes.most_common()]
        parts.append(_section(word, "causes", ("cause", "count"), rows))
    parts.append(_section(word, "same", ("kind", "name", "student"), same, word("same_why")))
    parts.append(f"<h2>{word('table')}</h2>{_key(word)}{_table(graded, word)}")
    if graded.notes:
        parts.append(f"<h2>{word('notes')}</h2><ul>{''.join(f'<li>{html.escape(n)}' for n in graded.notes)}</ul>")
    return "\n".join([*parts, "</html>\n"])


def _first(book, language):
    """The first wrong cell, its cause, and why."""
    return book.cell, say(language, book.cause) if book.cause else "", book.message


class _Safe(str):
    """Text that is HTML already."""


def _bar(number, of):
    return _Safe(f'<span class="bar" style="width:{6 * number / of:.2f}rem"></span>{number}')


def _section(word, title, heads, rows, said=""):
    """A heading and a table, or "none"."""
    text = f"<h2>{word(title)}</h2>" + (f"<p class='key'>{said}</p>" if said and rows else "")
    if not rows:
        return f"{text}<p>{word('none')}</p>"
    cells = ("".join(f"<td>{_escaped(cell)}" for cell in row) for row in rows)
    return f"{text}<table><tr>{''.join(f'<th>{word(head)}' for head in heads)}<tr>{'<tr>'.join(cells)}</table>"


def _escaped(cell):
    return cell if isinstance(cell, _Safe) else html.escape(str(cell))


def _attention(graded, language):
    """What a person should look at: student, file or exercise, kind, why."""
    for result in graded.results:
        for file, why in result.trouble:
            yield result.name, file, say(language, "trouble"), why
        for name in result.edited:
            judged = result.verdicts[name]
            yield result.name, name, say(language, "edited"), f"{say(language, judged.status)}. {judged.why}"
        for name, status in result.unknown.items():
            yield result.name, name, say(language, "unknown"), say(language, status)
        for name, status in result.reran.items():
            yield result.name, name, say(language, "reran"), say(language, status)
        for book in result.workbooks:
            if book.verdict == "unclear":
                yield result.name, book.file, say(language, "unclear"), f"{book.checked}/{book.total}"


def _mark(mark, result):
    """Per cent; with a question mark where a file was not read or judged, which may have held more."""
    doubt = result.trouble or any(book.verdict == "unclear" for book in result.workbooks)
    return "" if mark is None else f"{mark:.0f}{' ?' * bool(doubt)}"


def _key(word):
    marks = ", ".join(f'<span class="{CLASSES[s]}">{MARKS[s]}</span> {word(s)}' for s in (RIGHT, WRONG, OPEN))
    return f"<p class='key'>{marks}, <span class='edited'>&nbsp;●&nbsp;</span> {word('edited')}</p>"


def _table(graded, word):
    """Students and exercises, a mark a cell; what was said of a wrong answer where the pointer rests."""
    books = any(result.workbooks for result in graded.results)
    heads = [f"<th class=s>{word('student')}"]
    heads += [f"<th>{word(head)}" for head in ("mark", "solved", *(["right workbooks"] * books))]
    heads += [f"<th class=e><span>{html.escape(name)}</span>" for name in graded.exercises]
    rows = []
    for result in graded.results:
        statuses = [result.status(name) for name in graded.exercises]
        mark = graded.mark(result)
        row = [f"<td class=s>{html.escape(result.name)}", f"<td class=n>{_mark(mark, result)}"]
        row.append(f"<td class=n>{statuses.count(RIGHT)}")
        row += [f"<td class=n>{graded.points(result)[2]}"] * books
        for name, status in zip(graded.exercises, statuses, strict=True):
            classes = " ".join(filter(None, ("m", CLASSES[status], "edited" * (name in result.edited))))
            why = f' title="{html.escape(result.verdicts[name].why)}"' if status == WRONG else ""
            row.append(f'<td class="{classes}"{why}>{MARKS.get(status, "")}')
        rows.append("".join(row))
    solved = [sum(result.status(name) == RIGHT for result in graded.results) for name in graded.exercises]
    last = f"<td class=s>{word('class')}, {word('solved')}<td><td class=n>{sum(solved)}" + "<td>" * books
    rows.append(last + "".join(f'<td class="m">{number}' for number in solved))
    return f'<div class="wide"><table><tr>{"".join(heads)}<tr>{"<tr>".join(rows)}</table></div>'
