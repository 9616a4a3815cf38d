"""A sheet that was checked, as HTML: its cells in the colours of their verdicts, the first wrong one framed."""

from html import escape

from openpyxl.utils import get_column_letter

from mathpost.teaching.workbook.report import STATUS_COLOUR, FileReport
from mathpost.teaching.workbook.sheet.file import Book, Cell

MOST_ROWS, MOST_COLUMNS = 60, 26  # shown of a sheet, around the judged cells
MOST_LETTERS = 12  # of a cell; the style sheet cuts what is longer


def sheet_page(report: FileReport, book: Book) -> str:
    """Return the sheet of the first wrong cell, or of the first judged one.

    The tooltip of a cell is its formula, or its text if that is cut.
    """
    judged = {cell.place: cell for cell in report.cells}
    if not judged:
        return ""
    first = report.first or report.cells[0]
    name, wrong_row, wrong_column = first.place
    places = [place for place in book.cells if place[0] == name]
    rows = _near(wrong_row, {place[1] for place in places}, MOST_ROWS)
    columns = _near(wrong_column, {place[2] for place in places}, MOST_COLUMNS)
    lines = ["<tr><th>" + "".join(f"<th>{get_column_letter(column)}" for column in columns)]
    for row in rows:
        cells = []
        for column in columns:
            place = (name, row, column)
            cell, verdict = book.cells.get(place), judged.get(place)
            colour = f' style="background:{STATUS_COLOUR[verdict.status]}"' if verdict else ""
            mark = ' class="first"' if report.first and place == first.place else ""
            text = _text(cell)
            over = (cell and cell.formula) or text * (len(text) > MOST_LETTERS)
            title = f' title="{escape(over)}"' if over else ""
            cells.append(f"<td{mark}{colour}{title}>{escape(text)}")
        lines.append(f"<tr><th>{row}{''.join(cells)}")
    return f'<div class="mathpost-sheet-frame"><table class="mathpost-sheet">{"".join(lines)}</table></div>'


def _near(place: int, used: set[int], most: int) -> range:
    """Return the rows or columns from the first used one to the last, at most `most` around a place."""
    low, high = min(used | {place}), max(used | {place})
    low = max(low, min(place - most // 2, high - most + 1))
    return range(low, min(high, low + most - 1) + 1)


def _text(cell: Cell | None) -> str:
    if cell is None:
        return ""
    if cell.number is not None:
        return f"{round(cell.number, 9) + 0.0:.6g}"
    return "?" if cell.value is None else str(cell.value)[:200]
