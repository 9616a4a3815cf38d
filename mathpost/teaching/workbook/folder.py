"""A class of files: one line for each in a table, as text, CSV or HTML; and copies with coloured cells."""

from __future__ import annotations

import io
import os
import re
import zipfile
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import IO, TYPE_CHECKING

import openpyxl
from openpyxl.comments import Comment
from openpyxl.styles import PatternFill
from openpyxl.utils.cell import coordinate_to_tuple

from mathpost.errors import InputError, OutputError, internal, one_line
from mathpost.files import csv_text, write_bytes
from mathpost.teaching.bounds import bounded
from mathpost.teaching.workbook.check import check_file
from mathpost.teaching.workbook.reference.check import Reference
from mathpost.teaching.workbook.report import STATUS_COLOUR, UNCLEAR, WRONG, html_table
from mathpost.teaching.workbook.sheet.file import Book, read
from mathpost.teaching.workbook.sheet.safety import MEGABYTE, inspect

if TYPE_CHECKING:
    from mathpost.teaching.workbook.report import FileReport
    from mathpost.teaching.workbook.task import Task

DAMAGED = "not read"
SUFFIXES = {".xlsx", ".xlsm", ".xlsb", ".xls", ".ods", ".et", ".csv", ".xlsx.part"}
MARKED_LIMIT = 4 * MEGABYTE
HEADS = {
    "en": ("file", "verdict", "checked", "first wrong cell", "cause", "why"),
    "zh": ("文件", "结论", "已检查", "第一个错误单元格", "原因", "说明"),
}
IN_CHINESE = """right=正确 wrong=错误 not_judged=未能判定 not_read=无法读取 wrong_reference=引用错误 missing_$=缺少$
typed_over_formula=公式被数字覆盖 degrees_for_radians=角度未化为弧度 radians_for_degrees=弧度误作角度
atan2_order=ATAN2参数顺序 atan_for_atan2=应为ATAN2 sign=符号 transposed=转置 order_of_product=矩阵乘积顺序
sin_and_cos_exchanged=正弦余弦互换 rounded_early=过早取整 missing_term=缺少一项 wrong_angle=角度用错 branch=另一分支
wrong_point=坐标用错 other_convention=约定不同（主动/被动） offset=恒定偏移 half_angle=半角 wrong_value=数值错误
inch_for_mm=应为毫米，却用英寸 mm_for_inch=应为英寸，却用毫米"""
CHINESE = dict(pair.replace("_", " ").split("=") for pair in IN_CHINESE.split())


Row = tuple[str, ...]  # the row of a file in a `Summary`


@dataclass(frozen=True)
class Summary:
    """The result of `check_folder`.

    `rows` have the file, relative to the folder; the verdict, or ``"not read"``; how many cells were checked, as
    ``"45 of 63"``; the first wrong cell; its cause; a sentence. `language` is ``"en"`` or ``"zh"``.
    """

    rows: tuple[Row, ...]
    language: str = "en"

    @property
    def status(self) -> int:
        """The exit status: 2 if a file was not read or not judged, 1 if one is wrong, else 0."""
        verdicts = {row[1] for row in self.rows}
        return 2 if verdicts & {DAMAGED, UNCLEAR} else int(WRONG in verdicts)

    @property
    def table(self) -> list[tuple[str, ...]]:
        """Head and rows in the language asked for."""
        say = CHINESE if self.language == "zh" else {}
        return [HEADS[self.language], *(tuple(say.get(text, text) for text in row) for row in self.rows)]

    def __str__(self) -> str:
        widths = [max(_width(row[n]) for row in self.table) for n in range(5)]
        padded = [[row[n] + " " * (widths[n] - _width(row[n])) for n in range(5)] + [row[5]] for row in self.table]
        counts = Counter(row[1] for row in self.table[1:])
        total = ", ".join(f"{count} {verdict}" for verdict, count in sorted(counts.items()))
        return "\n".join([*("  ".join(row).rstrip() for row in padded), total])

    def to_csv(self) -> str:
        """Return the table as CSV, with a mark that tells spreadsheet programs the encoding."""
        return csv_text(self.table)

    def to_html(self) -> str:
        """Return the table as a page."""
        return f"<!DOCTYPE html><meta charset='utf-8'><title>mathpost check</title>{self._repr_html_()}\n"

    def _repr_html_(self) -> str:
        head, *rows = self.table
        return html_table(head, [(row[1], *said) for row, said in zip(self.rows, rows, strict=True)])


def _width(text: str) -> int:
    """How many columns a text takes where a Chinese character takes two."""
    return sum(2 if ord(character) > 0x2E80 else 1 for character in text)


def check_folder(
    folder: str | PathLike[str],
    task: Task | Reference | None = None,
    *,
    marked: str | PathLike[str] | None = None,
    language: str = "en",
    progress: Callable[[int, int, Path], object] | None = None,
    judged: Callable[[Row, FileReport | None], object] | None = None,
) -> Summary:
    """Return the `Summary` of all spreadsheets of a folder and the folders in it.

    Parameters
    ----------
    folder : str or path-like
    task : Task or Reference, optional
        The same for all.
    marked : str or path-like, optional, keyword only
        A folder for marked copies, made if it is not there.
    language : str, keyword only
        ``"en"`` or ``"zh"``, of the table.
    progress : callable, optional, keyword only
        ``progress(done, total, path)`` is called after each file.
    judged : callable, optional, keyword only
        ``judged(row, report)`` is called with each row and its `FileReport`, None of a file that was not read.

    Raises
    ------
    InputError
        If the folder is not there or holds no spreadsheet.
    OutputError
        If a marked copy cannot be written.
    """
    folder = Path(folder)
    rows: list[tuple[str, ...]] = []
    if not folder.is_dir():
        raise InputError(str(folder), "a folder", "none")
    paths = [path for path in sorted(folder.rglob("*")) if path.suffix.lower() in SUFFIXES and path.is_file()]
    out = None if marked is None else Path(os.path.realpath(marked))
    paths = [
        p for p in paths if not p.name.startswith(("~$", ".")) and out not in Path(os.path.realpath(p)).parents
    ]
    if not paths:
        raise InputError(str(folder), "spreadsheets", "none")
    for done, path in enumerate(paths, 1):
        name, report = one_line(str(path.relative_to(folder))), None
        try:
            report = task.check(path) if isinstance(task, Reference) else check_file(path, task)
        except InputError as error:
            rows.append((name, DAMAGED, "", "", "", str(error)))
        except Exception as error:  # whatever it is: the other files are still checked
            rows.append((name, UNCLEAR, "", "", "", internal(error)))
        else:
            *row, why = row_of(report)
            if out and path.suffix.lower() == ".xlsx":
                why = f"{why} {_marked(report, out / name)}".strip()
            rows.append((name, *row, why))
        if progress is not None:
            progress(done, len(paths), path)
        if judged is not None:
            judged(rows[-1], report)
    return Summary(tuple(rows), language)


def _marked(report: FileReport, out: Path) -> str:
    """Mark one of many; what keeps it from being marked is returned, and ends nothing."""
    try:
        with bounded():
            mark(report, out)
    except OutputError:
        raise
    except Exception as error:  # whatever it is, as in the check
        return f"(not marked: {error or type(error).__name__})"
    return ""


def row_of(report: FileReport) -> tuple[str, str, str, str, str]:
    """Return the row of a file in a `Summary`, without its name."""
    first = report.faults[0] if report.faults else None
    why = first.message if first else "; ".join(report.seen[: report.verdict == UNCLEAR])
    if report.not_checked:
        why += f" (not judged: {', '.join(report.not_checked[:4])}{', …' * (len(report.not_checked) > 4)})"
    found = (first.cell, first.cause) if first else ("", "")
    return report.verdict, f"{report.checked} of {report.total}", *found, why.strip()


def mark(report: FileReport, out: str | PathLike[str]) -> None:
    """Write a copy of the workbook of a `FileReport` to `out`: its cells coloured, notes on what is wrong.

    Calculated values and the comments in the sheet are kept; folders are made; the original is never written.

    Raises
    ------
    InputError
        If the workbook has changed into something unsafe since, or is too large to copy.
    OutputError
        If `out` is the original or cannot be written.
    """
    out = Path(out)
    if out.exists() and os.path.samefile(out, report.path):
        raise OutputError(f"{out}: not written, it is the original")
    inspect(report.path)
    if report.path.stat().st_size > MARKED_LIMIT:
        raise InputError(str(report.path), f"at most {MARKED_LIMIT // MEGABYTE} MB to mark", "a larger workbook")
    try:
        book, content = openpyxl.load_workbook(report.path), io.BytesIO()
    except Exception as error:  # openpyxl raises whatever its parser meets in formats, too
        raise InputError(str(report.path), "a workbook that can be copied", f"one that cannot ({error})") from None
    messages = {fault.cell: f"{fault.cause}: {fault.message}" for fault in report.faults}
    for judged in report.cells:
        sheet, row, column = judged.place
        cell = book[sheet].cell(row, column)
        cell.fill = PatternFill("solid", fgColor=STATUS_COLOUR[judged.status][1:].upper())
        if judged.cell in messages:
            before = f"{cell.comment.text}\n— mathpost: " if cell.comment else ""
            cell.comment = Comment(before + messages[judged.cell], cell.comment.author if before else "mathpost")
    book.save(content)
    try:
        out.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise OutputError(f"{out}: not written, {error.strerror or error}") from None
    write_bytes(out, _with_values(content, read(report.path)))


def _with_values(content: IO[bytes], original: Book) -> bytes:
    """The saved workbook with the numbers that its formulas had, which openpyxl does not write."""
    result = io.BytesIO()
    with zipfile.ZipFile(content) as source, zipfile.ZipFile(result, "w", zipfile.ZIP_DEFLATED) as target:
        for name in source.namelist():
            data = source.read(name)
            if found := re.fullmatch(r"xl/worksheets/sheet(\d+)\.xml", name):
                sheet = original.sheets[int(found[1]) - 1]

                def fill(match: re.Match[str], sheet: str = sheet) -> str:
                    cell = original.cells.get((sheet, *coordinate_to_tuple(match[2])))
                    number = None if cell is None else cell.number
                    return match[0] if number is None else f"{match[1]}<v>{number!r}</v></c>"

                pattern = r'(<c r="([A-Z]+\d+)"[^>]*><f[^>]*>[^<]*</f>)<v\s*/?>(?:</v>)?</c>'
                data = re.sub(pattern, fill, data.decode()).encode()
            target.writestr(name, data)
    return result.getvalue()
