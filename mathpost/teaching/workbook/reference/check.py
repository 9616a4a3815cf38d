"""A right workbook, and a hand-in compared with it, from its bytes to its report."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import cached_property
from os import PathLike
from pathlib import Path

import numpy as np

from mathpost.errors import InputError, internal
from mathpost.teaching.bounds import TooLarge, bounded
from mathpost.teaching.workbook.reference.hand_in import HandIn
from mathpost.teaching.workbook.reference.homework import Homework, homework_text
from mathpost.teaching.workbook.reference.matched import Matched
from mathpost.teaching.workbook.reference.quantities import Dictionary, Sheet, agree
from mathpost.teaching.workbook.reference.results import Comparison
from mathpost.teaching.workbook.report import (
    TOO_LARGE,
    UNCLEAR,
    WRONG,
    FileReport,
)
from mathpost.teaching.workbook.sheet.file import read
from mathpost.teaching.workbook.sheet.place import Place
from mathpost.teaching.workbook.sheet.samples import at_samples
from mathpost.teaching.workbook.sheet.tree import heads


class Reference:
    """A right workbook with which hand-ins are compared as functions.

    Parameters
    ----------
    homework : Homework, str or path-like
        What is asked, or the right workbook alone.
    beside : callable, optional
        ``beside(path)`` returns the `FileReport` of a check that knows no reference. What it says is said beside.

    Raises
    ------
    InputError
        If the workbook cannot be read, has no formulas, or has errors in its results.

    Examples
    --------
    >>> reference = Reference("data/workbooks/right.xlsx")
    >>> report = reference.check("data/workbooks/lucky.xlsx")
    >>> report.verdict, report.faults[0].cell
    ('wrong', 'ZXZ!B21')
    """

    def __init__(
        self, homework: Homework | str | PathLike[str], beside: Callable[[Path], FileReport] | None = None
    ) -> None:
        self.homework = homework if isinstance(homework, Homework) else Homework(Path(homework))
        self.path, self.beside = self.homework.reference, beside
        self.warnings: list[str] = []
        self.not_compared: list[str] = []  # results of the reference, and why
        try:
            with bounded(), np.errstate(all="ignore"):
                self.sheet = Sheet(read(self.path))
                self._read()
        except TooLarge as error:
            raise InputError(str(self.path), "a workbook of a size that can be compared", str(error)) from None
        if beside is not None and (own := beside(self.path)).verdict == WRONG:
            self.warnings.append(f"the reference itself is wrong, as it seems: {own.faults[0]}")

    def _read(self) -> None:
        sheet, asked = self.sheet, self.homework
        values = sheet.run({})
        if not sheet.trees.keys() - sheet.messages:
            raise InputError(str(self.path), "a reference with formulas", "numbers alone")
        named = None if asked.results is None else self._places("results", asked.results)
        unknown = sheet.downstream(sheet.unknown)
        left = [] if named else [p for p in sheet.ends() if p in unknown]
        if left:
            whys = dict.fromkeys(map(sheet.why_unknown, sorted(sheet.unknown, key=sheet.reading_order)))
            cells = ", ".join(sheet.ranges(left))
            self.not_compared.append(f"{cells} of the reference is not compared: {', '.join(whys)}")
        ends = [p for p in sheet.ends() if p not in unknown] or left
        controls = set() if named else self._controls(ends)
        self.results = named or [p for p in ends if p not in controls] or ends
        for place in self.results:
            if place not in sheet.trees or place in sheet.messages:
                raise InputError(f"{self.path}, {sheet.address(place)}", "a result, a formula", "none")
            if not np.isfinite(at_samples(values[place])).all():
                found = sheet.why_unknown(place) if place in sheet.unknown else "an error"
                raise InputError(f"{self.path}, {sheet.address(place)}", "a result", found)
        before = sheet.upstream(self.results)
        used = [p for p in sheet.numbers_typed if p in before and not sheet.is_start(p)]
        self.inputs = used if asked.inputs is None else self._places("inputs", asked.inputs)

    def _places(self, name: str, addresses: Iterable[str]) -> list[Place]:
        areas = [self.sheet.named(f"{self.path.name}, {name}", text) for text in addresses]
        return list(dict.fromkeys(place for area in areas for place in area.places))

    def _controls(self, ends: Sequence[Place]) -> set[Place]:
        """The formulas that give the same whatever the inputs are, or an input again, and the numbers of rows."""
        sheet, before = self.sheet, self.sheet.upstream(ends)
        inputs = {p: [p] for p in sheet.numbers_typed if p in before}
        compared = Comparison(sheet, ends, sheet, Matched(inputs)) if inputs else None
        ours = compared.ours if compared else {}
        values = {p: at_samples(ours[p]) for p in ends if p in ours and p not in sheet.shown}
        given = Dictionary(compared.given.items() if compared else ())
        same = [
            p for p, v in values.items() if v in given or (np.isfinite(v).all() and agree(v, np.full_like(v, v[0])))
        ]
        counts = {
            p for p in ends if heads(sheet.tree(p)) & {"ROW", "COLUMN"} and inputs.keys().isdisjoint(sheet.uses[p])
        }
        return {p for p in same if not inputs.keys().isdisjoint(sheet.upstream([p]))} | counts

    @cached_property
    def digest(self) -> str:
        """A digest of all that a verdict depends on, beside the hand-in."""
        return hashlib.sha256(self.path.read_bytes() + repr(self.homework).encode()).hexdigest()

    def text(self) -> str:
        """The file of this homework, for a teacher to edit."""
        inputs, results = (
            {text: self.sheet.label(self.sheet.named("", text).places[0]) for text in self.sheet.ranges(places)}
            for places in (self.inputs, self.results)
        )
        return homework_text(self.path.name, inputs, results, self.homework.numbers)

    def check(self, path: str | PathLike[str]) -> FileReport:
        """Compare a hand-in; an error that nobody foresaw is reported, and ends nothing.

        Raises
        ------
        InputError
            If the file cannot be read, or should not be opened, or a cell that was named is not there.
        """
        path = Path(path)
        try:
            with bounded(), np.errstate(all="ignore"):
                report = HandIn(self, path).report()
        except TooLarge as error:
            return FileReport(path, seen=[f"{TOO_LARGE} ({error})"])
        except InputError:
            raise
        except Exception as error:  # whatever it is
            return FileReport(path, seen=[f"not judged: {internal(error)}"])
        report.warnings[:0] = self.warnings
        if self.beside is not None:
            report.seen += self._said_beside(path)
        return report

    def _said_beside(self, path: Path) -> Iterator[str]:
        """What a check without the reference says of a file, if it knows what it is."""
        try:
            own = self.beside(path) if self.beside else FileReport(path)
        except Exception:  # the reference has decided already
            return
        if own.verdict != UNCLEAR:
            yield f"without the reference: {own.verdict}{f', {own.faults[0].cell}' if own.faults else ''}"
