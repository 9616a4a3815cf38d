"""The check of one file: its formulas as functions, or, where there are none, its values.

A sheet in which no result is recognised is not judged, whatever is wrong in it.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from os import PathLike
from pathlib import Path

import numpy as np

from mathpost.teaching.bounds import TooLarge, bounded
from mathpost.teaching.workbook.meaning.recognise import Recognised
from mathpost.teaching.workbook.meaning.typed_words import looked_at
from mathpost.teaching.workbook.meaning.words import Words
from mathpost.teaching.workbook.report import (
    CONSEQUENCE,
    RIGHT,
    TOO_LARGE,
    UNCLEAR,
    WRONG,
    Fault,
    FileReport,
    Judgement,
)
from mathpost.teaching.workbook.sheet.file import EMPTY, Book, read
from mathpost.teaching.workbook.sheet.formula import Tree
from mathpost.teaching.workbook.sheet.graph import Graph
from mathpost.teaching.workbook.sheet.neighbours import typed_over
from mathpost.teaching.workbook.sheet.place import Place
from mathpost.teaching.workbook.task import Task
from mathpost.teaching.workbook.verdict.beside import Beside
from mathpost.teaching.workbook.verdict.inputs import contradicted, unused
from mathpost.teaching.workbook.verdict.judge import Judge
from mathpost.teaching.workbook.verdict.reason import reason

ASKED = "no result recognised; say where it is, --cells angles=…,point=…,result=…"
BY_REFERENCE = "give a right workbook to compare it with: --reference"
LUCKY = "numbers without formulas: that they are right by luck cannot be excluded"


@np.errstate(all="ignore")  # a cell may hold what is no number
def check_file(path: str | PathLike[str], task: Task | None = None) -> FileReport:
    """Check a spreadsheet by its formulas.

    Every formula of all sheets is evaluated at random inputs, so that a sheet is right only as a function, not at
    its own numbers by luck.

    Parameters
    ----------
    path : str or path-like
        .xlsx or .csv; .ods, .xls and .et where LibreOffice is there to convert them.
    task : Task, optional
        What the sheet was asked to do; without it the sheet's texts say it, or else it is the task of source 000.

    Returns
    -------
    FileReport

    Raises
    ------
    InputError
        If the file cannot be read, or should not be opened.

    Examples
    --------
    >>> report = check_file("data/workbooks/missing_transpose.xlsx")
    >>> report.verdict, report.faults[0].cell, report.faults[0].cause
    ('wrong', 'ZXZ!J38', 'transposed')
    """
    try:
        with bounded():
            return _checked(path, task or Task())
    except TooLarge as error:
        return FileReport(Path(path), seen=[f"{TOO_LARGE} ({error})"])


def _checked(path: str | PathLike[str], task: Task) -> FileReport:
    graph = _graph(read(path))
    if lost := typed_over(graph):
        before, graph = graph, _graph(graph.book)
        graph.trees |= lost  # as if they were not
    graph.unround()
    found = Recognised(graph, task)
    judge = Judge(graph, found).run()
    judge.faults[:0] = [judge.typed_number(place, before.tree(place)) for place in found.sorted(lost)]
    others = Beside(judge)
    judge.faults += others.faults
    problems = [*_problems(judge, others), *contradicted(found, judge.units)]
    seen = [*_recognised(judge), *problems]
    unclear = bool(problems or judge.reading or not found.calculations)
    report = _report(graph, _statuses(judge, others, lost), judge.faults, seen, _warnings(judge, lost), unclear)
    results = {graph.address(p) for c in found.calculations for p in c.results}
    right = {cell.cell for cell in report.cells if cell.status == RIGHT}
    status = {cell.place: cell.status for cell in report.cells}

    def explain(text: str) -> list[str]:
        (place, *_) = graph.named("why", text).places
        return reason(judge, others, place, status.get(place))

    report.explain = explain
    if report.verdict == UNCLEAR:
        report.seen.append(BY_REFERENCE)
    report.beside = not (report.faults or unclear) and report.verdict == UNCLEAR and results <= right
    return report


def _graph(book: Book) -> Graph:
    """The graph of a workbook, without what is apart from all rotations if that is much."""
    graph = Graph(book)
    graph.set_aside()
    return graph


def _statuses(judge: Judge, others: Beside, lost: dict[Place, Tree]) -> dict[Place, str]:
    """Place → status of all cells to judge."""
    graph, found = judge.graph, judge.found
    after = graph.downstream([*judge.fixed, *lost])
    statuses = {p: CONSEQUENCE if p in after else RIGHT for p in others.places}
    statuses |= dict.fromkeys([*others.unjudged, *graph.aside], UNCLEAR)
    typed = {p: c for c in found.calculations if c.typed for p in c.results}
    statuses |= {p: UNCLEAR if p in graph.trees or not c.complete else RIGHT for p, c in typed.items()}
    statuses |= {p: UNCLEAR for p in graph.errors if statuses.get(p, RIGHT) == RIGHT}
    # An input that is not the task's is wrong, though it is none of the cells that follow from the inputs.
    return statuses | {fault.place: WRONG for fault in judge.faults}


def _recognised(judge: Judge) -> Iterator[str]:
    """What the sheet calculates, and where."""
    graph, found = judge.graph, judge.found
    if judge.reading:
        sequence, convention = judge.reading
        axes = "turned" if sequence.isupper() else "fixed"
        unsaid = "so, and source 000 has ZXZ, passive"
        if found.by == "the text":
            unsaid = "whether the point or the frame turns"
        yield f"it is {sequence} about {axes} axes, {convention}; no text says {unsaid}"
        yield f"if that was asked, add --sequence {sequence} --convention {convention}"
        yield from (graph.range(c.results) for c in found.calculations)
        return
    for calculation in found.calculations:
        if calculation.said:
            yield (
                calculation.said
                if found.task.machine
                else f"{graph.range(calculation.results)}: {calculation.said}"
            )


def _problems(judge: Judge, others: Beside) -> list[str]:
    """What keeps the sheet from being judged."""
    graph, found = judge.graph, judge.found
    problems = [*found.problems, *(f"{graph.address(p)} depends on itself" for p in found.sorted(graph.circular))]
    for cells, (rows, columns) in graph.cut_off():
        problems.append(
            f"{graph.range(cells)} has only a part of the {rows} × {columns} numbers that its formula gives"
        )
    for calculation in judge.unexplained:
        text = "is not what the task asks for, and no single change makes it so"
        problems.append(f"{graph.range(calculation.results)} {text}")
    problems += [text for triple, text in found.doubts.items() if not others.unjudged.isdisjoint(triple)]
    unclear = problems or not found.calculations
    if unclear and not (judge.faults or judge.reading or found.task.machine):
        problems.append(ASKED)
    return problems


def _warnings(judge: Judge, lost: dict[Place, Tree]) -> Iterator[str]:
    """Yield what deserves a look."""
    graph, found = judge.graph, judge.found
    yield from unused(found) if any(c.angles for c in found.calculations) else ()
    after_lost = graph.downstream(lost)
    numbers = {p: graph.cells[p].number for p in graph.order if p not in after_lost}
    stored = {p: number for p, number in numbers.items() if number is not None}
    stale = [p for p, number in stored.items() if abs(graph.number(p) - number) > 1e-6 * (1 + abs(number))]
    if stale:
        yield f"stored values are not what the formulas give: {', '.join(graph.ranges(stale[:6]))}"
    if any(c.typed for c in found.calculations):
        yield LUCKY
    if words := [c for c in found.calculations if isinstance(c, Words)]:
        yield from looked_at(words, graph.own)


def _report(
    graph: Graph,
    statuses: dict[Place, str],
    faults: list[Fault],
    seen: list[str],
    warnings: Iterable[str],
    unclear: bool = False,
) -> FileReport:
    cells = []
    statuses = {place: statuses[place] for place in sorted(statuses, key=graph.reading_order)}
    for place, status in statuses.items():
        cell = graph.book.cells.get(place, EMPTY)
        cells.append(
            Judgement(graph.address(place), place, status, cell.value if cell.number is None else cell.number)
        )
    unjudged = list(graph.ranges(place for place, status in statuses.items() if status == UNCLEAR))
    verdict = WRONG if faults else UNCLEAR if unclear or unjudged or not statuses else RIGHT
    return FileReport(graph.book.path, verdict, faults, cells, unjudged, seen, [*warnings, *graph.book.notes])
