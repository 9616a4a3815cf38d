"""Spreadsheets checked: a line for each as it is judged, which unfolds to its sheet; marked copies to download."""

import argparse
import shutil
from collections import Counter
from collections.abc import Callable, Iterable
from contextlib import suppress
from html import escape
from pathlib import Path

from mathpost.errors import InputError
from mathpost.interface.shell import check
from mathpost.interface.workbench.panel import download
from mathpost.interface.workbench.run import Made
from mathpost.interface.workbench.sheet_page import sheet_page
from mathpost.teaching.workbook import Reference, check_folder, mark
from mathpost.teaching.workbook.folder import HEADS, MARKED_LIMIT, Row, Summary, row_of
from mathpost.teaching.workbook.report import STATUS_COLOUR, UNCLEAR, FileReport
from mathpost.teaching.workbook.sheet.file import read

MOST_LINES = 400  # of a class; the downloads have all
SMALL = 200_000  # bytes of the largest marked copy that a line offers by itself


def work(options: argparse.Namespace, say: Callable[..., None], folder: Path) -> Made:
    """Check one spreadsheet or a folder as the shell does, and show a line for each."""
    task, marked, pages = check.asked(options), folder / "marked", {}
    place, many = options.path, options.path.is_dir()
    say("checking", row=_line(HEADS[options.language], "mathpost-head"))
    count = iter(range(1, MOST_LINES + 1))

    def judged(row: Row, report: FileReport | None) -> None:
        if next(count, 0):
            copy = marked / row[0]
            say(row=_row(row, report, place / row[0] if many else place, copy, opened=not many))

    if many:
        summary = check_folder(
            place, task, marked=marked, language=options.language, judged=judged,
            progress=lambda done, total, path: say(f"{path.name}, {done} of {total}", done, total),
        )  # fmt: skip
    else:
        report = check.judge(place, task)
        row, name = (place.name, *row_of(report)), place.name
        if place.suffix.lower() == ".xlsx" and place.stat().st_size <= MARKED_LIMIT and report.cells:
            mark(report, marked / name)
        summary = Summary((row,), options.language)
        judged(row, report)
        if options.why and report.explain:
            pages["Why"] = f"<pre>{escape(chr(10).join(report.explain(options.why)))}</pre>"
    files = {"class.csv": summary.to_csv().encode(), "class.html": summary.to_html().encode()} if many else {}
    copies = sorted(path for path in marked.rglob("*") if path.is_file()) if marked.is_dir() else []
    if many and copies:
        files["marked.zip"] = Path(shutil.make_archive(str(folder / "copies"), "zip", marked)).read_bytes()
    elif copies:
        files[f"marked_{place.name}"] = copies[0].read_bytes()
    if isinstance(task, Reference):
        files["homework.toml"] = task.text().encode()
    files["report.txt"] = f"{summary if many else report}\n".encode()
    verdicts = Counter(row[1] for row in summary.rows)
    said = ", ".join(f"{number} {verdict}" for verdict, number in sorted(verdicts.items()))
    if many:
        return Made(f"{len(summary.rows)} workbooks: {said}", pages, files, None)
    return Made(str(report).splitlines()[0], pages, files, summary.status == 0)


def _line(texts: Iterable[str], kind: str = "", colour: str = "white", inside: str = "") -> str:
    cells = "".join(f"<span>{escape(text)}</span>" for text in texts)
    summary = f'<summary style="background:{colour}">{cells}</summary>'
    return f'<details class="mathpost-row {kind}">{summary}{inside}</details>'


def _row(row: Row, report: FileReport | None, path: Path, copy: Path, *, opened: bool) -> str:
    """Return the line of a workbook; folded in it, its faults with reasons, the sheet, and the marked copy."""
    colour = STATUS_COLOUR.get(row[1], STATUS_COLOUR[UNCLEAR])
    inside = f"<p>{escape(row[5])}</p>"
    if report is not None:
        inside = "<br>".join(map(escape, str(report).splitlines()[1:]))
        with suppress(InputError):
            inside += sheet_page(report, read(path))
    if copy.is_file() and copy.stat().st_size <= SMALL:
        inside += download(f"marked_{copy.name}", copy.read_bytes())
    line = _line(row, "", colour, f"<div>{inside}</div>")
    return line.replace("<details ", "<details open ", 1) if opened else line
