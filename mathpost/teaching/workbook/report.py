"""What a check of one file reports: a verdict, every cell that was judged, and why the first wrong one is wrong."""

from __future__ import annotations

import html
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from mathpost.errors import one_line
from mathpost.teaching.workbook.sheet.place import Place
from mathpost.teaching.workbook.sheet.samples import Values

RIGHT, WRONG, CONSEQUENCE, UNCLEAR = "right", "wrong", "consequence", "not judged"
TOO_LARGE = "not judged: too large"
# A spreadsheet's green, red and amber; what was not judged is grey.
STATUS_COLOUR = {RIGHT: "#c6efce", WRONG: "#ffc7ce", CONSEQUENCE: "#ffeb9c", UNCLEAR: "#d9d9d9"}


@dataclass(frozen=True)
class Judgement:
    """One cell: address, ``"right"``, ``"wrong"``, ``"consequence"`` or ``"not judged"``, and its contents."""

    cell: str
    place: Place
    status: str
    written: Any


@dataclass(frozen=True)
class Fault:
    """A wrong cell: its address, the kind of slip, such as ``"sign"``, and a sentence in terms of the formula.

    `values` has what belongs there, where that is known: place → value at the samples; `rule` says what was found.
    """

    cell: str
    cause: str
    message: str
    place: Place
    values: Values = field(default_factory=dict, compare=False, repr=False)
    rule: str = field(default="", compare=False, repr=False)

    def __str__(self) -> str:
        return f"{self.cell}: {self.cause}: {self.message}"


@dataclass
class FileReport:
    """The result of `check_file`.

    Attributes
    ----------
    verdict : str
        ``"right"`` only if everything that follows from the inputs was judged and is right; ``"wrong"``;
        ``"not judged"`` if something could not be read or judged.
    faults : list of `Fault`
        The first one first.
    cells : list of `Judgement`
        Those that follow from the inputs: `total` of them, of which `checked` were judged.
    not_checked : list of str
        Addresses of the others.
    seen, warnings : list of str
        What was recognised, with addresses; what deserves a look.
    beside : bool
        Whether all results are right, and only cells beside them are not judged.
    explain : callable or None
        ``explain("B5")`` returns lines on the rule that judged a cell, and the values that it used; None where
        the workbook is too large.
    """

    path: Path
    verdict: str = UNCLEAR
    faults: list[Fault] = field(default_factory=list)
    cells: list[Judgement] = field(default_factory=list)
    not_checked: list[str] = field(default_factory=list)
    seen: list[str] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)
    beside: bool = False
    explain: Callable[[str], list[str]] | None = field(default=None, repr=False, compare=False)
    total = property(lambda self: len(self.cells))
    checked = property(lambda self: sum(cell.status != UNCLEAR for cell in self.cells))

    @property
    def first(self) -> Judgement | None:
        """The judgement of the first wrong cell, or None."""
        return next((cell for cell in self.cells if self.faults and cell.cell == self.faults[0].cell), None)

    @property
    def status(self) -> int:
        """The exit status of the shell: 0, 1 or 2."""
        return (RIGHT, WRONG, UNCLEAR).index(self.verdict)

    def __str__(self) -> str:
        lines = [f"{one_line(self.path.name)}: {self.verdict}, checked {self.checked} of {self.total}"]
        lines += [f"{'wrong as well' if n else 'first wrong'}: {fault}" for n, fault in enumerate(self.faults[:6])]
        lines += [f"… and {len(self.faults) - 6} more"] * (len(self.faults) > 6)
        follow = sum(cell.status == CONSEQUENCE for cell in self.cells)
        lines += [f"{follow} cells follow from that"] * bool(follow and self.faults)
        some = self.not_checked[:12] + ["…"] * (len(self.not_checked) > 12)
        said = "results right; not judged" if self.beside else "not judged"
        lines += [f"{said}: {', '.join(some)}"] * bool(some)
        lines += [f"seen: {text}" for text in self.seen[:8]]
        return "\n".join([*lines, *(f"warning: {text}" for text in self.warnings[:8])])

    def _repr_html_(self) -> str:
        summary = "<br>".join(map(html.escape, str(self).splitlines()))
        rows = [(WRONG, fault.cell, fault.cause, fault.message) for fault in self.faults]
        return f"<p>{summary}</p>" + html_table(("cell", "cause", "why"), rows) * bool(rows)


def html_table(head: Iterable[str], rows: Iterable[Sequence[str]]) -> str:
    """A table, each row in the colour of the status that it begins with, which is not shown."""
    lines = [f"<tr>{''.join(f'<th>{text}' for text in head)}"]
    for status, *texts in rows:
        colour = STATUS_COLOUR.get(status, STATUS_COLOUR[UNCLEAR])
        cells = "".join(f"<td>{html.escape(text)}" for text in texts)
        lines.append(f"<tr style='background:{colour};color:black'>{cells}")
    return f"<table>{''.join(lines)}</table>"
