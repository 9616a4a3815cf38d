"""The mix-ups of students: their catalogue and the sentences of the exercises, as tables for teachers."""

from collections.abc import Iterable
from html import escape
from itertools import groupby

from mathpost.detective.causes import CAUSES
from mathpost.interface.site.lesson import Lesson
from mathpost.teaching.course.exercise import EXERCISES

MARK = "<!-- mix-ups -->"  # the place of the tables in TEACHING.md


def mixups(lessons: Iterable[Lesson]) -> str:
    """Return HTML: mix-ups found in public, the most frequent first, and those that exercises name."""
    pages = {each.path.stem.split("_")[0]: each for each in lessons}
    found = sorted(CAUSES.values(), key=lambda cause: -len(cause["seen"]))
    rows = [(each["mixup"], each["why"], str(len(each["seen"])), _link(pages, each["lesson"])) for each in found]
    made = [_table(("mix-up", "why", "threads", "lesson"), rows)]
    named = [name for name in EXERCISES if EXERCISES[name].slips]
    for number, names in groupby(sorted(named), key=lambda name: name.partition("-")[0]):
        said = [(f"<code>{name}</code>", escape(slip)) for name in names for slip in EXERCISES[name].slips]
        title = escape(pages[number].short) if number in pages else number
        table = _table(("exercise", "what the check says of the mix-up"), said)
        made.append(f"<details><summary>{title}: {len(said)} mix-ups</summary>{table}</details>")
    return "\n".join(made)


def _link(pages: dict[str, Lesson], number: str) -> str:
    """A link to a lesson, if there is one with this number."""
    return f'<a href="lessons/{pages[number].name}.html">{number}</a>' if number in pages else number


def _table(heads: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    head = "".join(f'<th scope="col">{head}</th>' for head in heads)
    body = "".join(f"<tr>{''.join(f'<td>{cell}</td>' for cell in row)}</tr>" for row in rows)
    return f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"
