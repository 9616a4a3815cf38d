"""Workbooks: a template for the lesson, the check of one, of a table, of a whole class, and marked copies.

>>> report = check("data/workbooks/missing_transpose.xlsx")
>>> print(report.why)
the final transpose is missing
"""

import html
import io
import os
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

import openpyxl
from openpyxl.comments import Comment
from openpyxl.styles import PatternFill

from mathpost.errors import InputError, OutputError, write_bytes
from mathpost.workbook.check import check
from mathpost.workbook.nc_table import check_table
from mathpost.workbook.report import RIGHT, STATUS_COLOUR, WRONG, Judgement, Report
from mathpost.workbook.safety import PART_LIMIT, inspect
from mathpost.workbook.template import template

__all__ = [
    "UNREADABLE",
    "Judgement",
    "Report",
    "Summary",
    "check",
    "check_folder",
    "check_table",
    "mark",
    "template",
]

UNREADABLE = "unreadable"
SUFFIXES = {".xlsx", ".xlsm", ".xlsb", ".xls", ".ods"}
FILL = {status: PatternFill("solid", fgColor=colour[1:].upper()) for status, colour in STATUS_COLOUR.items()}


@dataclass(frozen=True)
class Summary:
    """The result of `check_folder`: one row for each workbook.

    Attributes
    ----------
    rows : tuple of tuples
        File, relative to the folder; ``"right"``, ``"wrong"`` or ``"unreadable"``; the first wrong cell; the kind
        of error; and the sentence that says why.
    """

    rows: tuple

    HEAD = ("file", "status", "first wrong cell", "kind", "why")

    @property
    def right(self):
        """Whether every workbook is right."""
        return all(row[1] == RIGHT for row in self.rows)

    def counts(self):
        """Return how many workbooks have each status, and how many each kind of error."""
        return Counter(row[1] for row in self.rows), Counter(row[3] for row in self.rows if row[3])

    def __str__(self):
        table = [self.HEAD, *self.rows]
        widths = [max(len(row[n]) for row in table) for n in range(4)]
        lines = ["  ".join([*(row[n].ljust(widths[n]) for n in range(4)), row[4]]).rstrip() for row in table]
        statuses, _ = self.counts()
        return "\n".join([*lines, ", ".join(f"{count} {status}" for status, count in sorted(statuses.items()))])

    def _repr_html_(self):
        rows = ["".join(f"<td>{html.escape(text)}" for text in row) for row in self.rows]
        head = "".join(f"<th>{text}" for text in self.HEAD)
        return f"<table><tr>{head}<tr>{'<tr>'.join(rows)}</table>"


def check_folder(folder, *, machine=None, marked=None, progress=None, **options):
    """Check all workbooks of a folder and the folders in it.

    Parameters
    ----------
    folder : str or path-like
    machine : Machine or path, optional, keyword only
        If given, each workbook is a table for `check_table`.
    marked : str or path-like, optional, keyword only
        A folder for marked copies, made if it is not there.
    progress : callable, optional, keyword only
        ``progress(done, total, path)`` is called after each workbook.
    **options
        Passed on to `check`.

    Returns
    -------
    Summary
        A workbook that cannot be read has a row that says why.

    Raises
    ------
    InputError
        If the folder is not there or holds no workbook.
    OutputError
        If a marked copy cannot be written.
    """
    folder = Path(folder)
    if not folder.is_dir():
        raise InputError(str(folder), "a folder", "none")
    paths = [path for path in sorted(folder.rglob("*")) if path.suffix.lower() in SUFFIXES and path.is_file()]
    paths = [path for path in paths if not path.name.startswith(("~$", ".~lock", "."))]
    if marked is not None:
        paths = [path for path in paths if Path(marked).resolve() not in path.resolve().parents]
    if not paths:
        raise InputError(str(folder), "workbooks", "none")
    rows = []
    for done, path in enumerate(paths, 1):
        name = str(path.relative_to(folder))
        try:
            report = check_table(path, machine, **options) if machine is not None else check(path, **options)
        except InputError as error:
            rows.append((name, UNREADABLE, "", "", str(error)))
        else:
            cell = report.first.cell if report.first else ""
            rows.append((name, RIGHT if report.right else WRONG, cell, report.kind, report.why))
            if marked is not None:
                mark(report, Path(marked) / name)
        if progress is not None:
            progress(done, len(paths), path)
    return Summary(tuple(rows))


def mark(report, out):
    """Write a copy of the checked workbook with its cells green, red or amber, and comments on what is not right.

    Parameters
    ----------
    report : Report
    out : str or path-like
        The copy, an .xlsx file; folders are made. The original is never written.

    Raises
    ------
    InputError
        If the workbook has changed into something unsafe since, or is too large to copy.
    OutputError
        If `out` is the original or cannot be written.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     mark(check("data/workbooks/missing_transpose.xlsx"), f"{folder}/marked.xlsx")
    ...     book = openpyxl.load_workbook(f"{folder}/marked.xlsx")
    >>> print(book["ZXZ"]["J38"].comment.text)
    wrong: ... the final transpose is missing
    """
    out = Path(out)
    if out.exists() and os.path.samefile(out, report.path):
        raise OutputError(f"{out}: not written, it is the original")
    inspect(report.path)
    if report.path.stat().st_size > PART_LIMIT // 8:
        raise InputError(str(report.path), f"at most {PART_LIMIT // 8 // 2**20} MB to mark", "a larger workbook")
    book = openpyxl.load_workbook(report.path)
    for judged in report.cells:
        sheet, place = judged.place
        cell = book[sheet].cell(*place)
        cell.fill = FILL[judged.status]
        if judged.status != RIGHT:
            text = f"{judged.status}: expected {judged.expected:z.9g}"
            cell.comment = Comment(f"{text}\n{report.why}" if judged is report.first else text, "mathpost")
    content = io.BytesIO()
    book.save(content)
    try:
        out.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise OutputError(f"{out}: not written, {error.strerror or error}") from None
    write_bytes(out, content.getvalue())
