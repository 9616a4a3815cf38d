"""What a check of a workbook reports: a judgement of each cell, and why the first wrong one is wrong."""

import html
from collections import Counter
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from openpyxl.utils.cell import coordinate_to_tuple

from mathpost.detective.euler_angles import explain

RIGHT, WRONG, CONSEQUENCE = "right", "wrong", "consequence"
STATUS_COLOUR = {RIGHT: "#c6efce", WRONG: "#ffc7ce", CONSEQUENCE: "#ffeb9c"}  # a spreadsheet's green, red and amber


@dataclass(frozen=True)
class Judgement:
    """What the check says about one cell.

    Attributes
    ----------
    cell : str
        Its address, such as ``ZXZ!C14``.
    role : str
        What it holds, such as ``matrix γβ, row 1, column 2``.
    status : str
        ``"right"``, ``"wrong"`` or ``"consequence"`` of an earlier error.
    written : float or str
        The number there, or the text or error in its place.
    expected : float
    formula : str
        The formula there, empty for a constant; of an array, the formula of the whole.
    """

    cell: str
    role: str
    status: str
    written: object
    expected: float
    formula: str

    @property
    def difference(self):
        """Written minus expected; NaN if no number is there."""
        return self.written - self.expected if isinstance(self.written, float) else float("nan")

    @property
    def place(self):
        """The sheet's name, and (row, column) from 1."""
        sheet, _, address = self.cell.rpartition("!")
        row, column = coordinate_to_tuple(address)
        return sheet.strip("'"), (row, column)

    def __str__(self):
        written = f"{self.written:z.6f}" if isinstance(self.written, float) else repr(self.written)
        text = f"{self.cell} ({self.role}): written {written}, expected {self.expected:z.6f}"
        if isinstance(self.written, float):
            text += f", difference {self.difference:z.3g}"
        return text + (f", formula {self.formula}" if self.formula else "")


@dataclass(frozen=True)
class Report:
    """The result of `check`.

    Attributes
    ----------
    path : pathlib.Path
    cells : tuple of Judgement
        In the order of the calculation.
    kinds : tuple of str
        The kind of the first error, such as ``("transpose",)``; several if the same numbers have several names.
    why : str
        The first error in a sentence; empty if all is right.
    notes : tuple of str
        What was not checked.
    """

    path: Path
    cells: tuple
    kinds: tuple = ()
    why: str = ""
    notes: tuple = ()
    question: tuple | None = None

    @property
    def right(self):
        """Whether nothing is wrong."""
        return self.first is None

    @cached_property
    def first(self):
        """The first wrong cell, or None."""
        return next((cell for cell in self.cells if cell.status == WRONG), None)

    @property
    def kind(self):
        """The kind of the first error in a word, empty if all is right."""
        return self.kinds[0] if self.kinds else ""

    @cached_property
    def detective(self):
        """What `explain` says of the wrong result; None if the result is right or not found."""
        return explain(*self.question) if self.question else None

    def counts(self):
        """Return how many cells have each status."""
        return Counter(cell.status for cell in self.cells)

    def __str__(self):
        counts = self.counts()
        lines = [f"{self.path.name}: {', '.join(f'{counts[s]} {s}' for s in (RIGHT, WRONG, CONSEQUENCE))}"]
        if self.first:
            lines += [f"first wrong: {self.first}", f"why: {self.why}"]
            if self.detective and self.detective.explained:
                lines.append(f"the result is what this gives: {self.detective.misreadings[0]}")
            lines += [
                f"{cell.status}: {cell}" for cell in self.cells if cell.status != RIGHT and cell is not self.first
            ]
        return "\n".join([*lines, *(f"note: {note}" for note in self.notes)])

    def _repr_html_(self):
        summary = "<br>".join(map(html.escape, str(self).splitlines()[: 3 if self.first else 1]))
        shown = sorted((c for c in self.cells if c.status != RIGHT), key=lambda c: c is not self.first)
        rows = [
            f"<tr style='background:{STATUS_COLOUR[c.status]};color:black'>"
            + "".join(f"<td>{html.escape(str(text))}" for text in (c.cell, c.role, c.status))
            + f"<td>{_short(c.written)}<td>{c.expected:z.6f}<td>{html.escape(c.formula)}"
            for c in shown
        ]
        head = "<tr><th>cell<th>what<th>status<th>written<th>expected<th>formula"
        return f"<p>{summary}</p>" + (f"<table>{head}{''.join(rows)}</table>" if rows else "")


def _short(written):
    return f"{written:z.6f}" if isinstance(written, float) else html.escape(str(written))
