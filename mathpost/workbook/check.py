"""The check of one file: its formulas as functions, or, where there are none, its values."""

import numpy as np
from openpyxl.utils import get_column_letter

from mathpost.workbook.file import read
from mathpost.workbook.graph import Graph
from mathpost.workbook.judge import Judge
from mathpost.workbook.nc_table import looked_at
from mathpost.workbook.recognise import Recognised, Task
from mathpost.workbook.report import CONSEQUENCE, RIGHT, UNCLEAR, WRONG, FileReport, Judgement
from mathpost.workbook.values import check_values

LUCKY = "numbers without formulas: that they are right by luck cannot be excluded"


def check_file(path, task=None):
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
    task = task or Task()
    graph = Graph(read(path))
    if task.machine is None and not any(graph.uses.values()):
        return _by_values(graph, task)
    found = Recognised(graph, task)
    judge = Judge(graph, found).run()
    if not found.calculations and (report := _by_values(graph, task)).cells:
        return report
    unjudged = judge.judge_the_rest()
    statuses = dict.fromkeys(judge.all_places, RIGHT)
    statuses |= dict.fromkeys((p for p in graph.downstream(judge.fixed) if p in statuses), CONSEQUENCE)
    # An input that is not the task's is wrong, though it is none of the cells that follow from the inputs.
    statuses |= dict.fromkeys(unjudged, UNCLEAR) | {fault.place: WRONG for fault in judge.faults}
    seen = [f"{found.place_text(c.results)}: {c.said}" for c in found.calculations]
    judge.warnings += [
        f"{graph.address(p)} depends on itself" for p in sorted(graph.circular, key=graph.reading_order)
    ]
    typed = [c for c in found.calculations if getattr(c, "typed", False)]
    places = {p: RIGHT for c in typed for p in c.results}
    statuses = places | {p: s for p, s in statuses.items() if p not in places}
    statuses |= {fault.place: WRONG for fault in judge.faults}
    now = graph.run({})
    stale = [p for p in graph.order if graph.cells[p].number is not None and not _as_stored(graph, p, now)]
    if stale:
        judge.warnings.append(
            f"stored values are not what the formulas give: {', '.join(ranges(graph, stale[:6]))}"
        )
    if typed:
        judge.warnings.append(LUCKY)
    report = _report(graph, statuses, judge.faults, [*seen, *found.problems], judge.warnings)
    if task.machine is not None:
        own = graph.run({})
        words = [[own.get(p, judge.constant(p))[0] for p in row.results] for row in found.calculations]
        report.warnings += looked_at(found.calculations, np.array(words, dtype=float))
    if not report.faults and (not found.calculations or found.problems):
        report.verdict = UNCLEAR
    return report


def _by_values(graph, task):
    statuses, faults, seen = check_values(graph, task.cells)
    return _report(graph, statuses, faults, seen or ["no angles, point or matrices by their labels"], [LUCKY])


def _report(graph, statuses, faults, seen, warnings):
    report = FileReport(graph.book.path, faults=faults, seen=seen, warnings=[*warnings, *graph.book.notes])
    for place, status in statuses.items():
        cell = graph.cells.get(place)
        written = None if cell is None else cell.number if cell.number is not None else cell.value
        report.cells.append(Judgement(graph.address(place), place, status, written, cell.formula if cell else ""))
    unjudged = [place for place, status in statuses.items() if status == UNCLEAR]
    report.not_checked = list(ranges(graph, unjudged))
    report.verdict = WRONG if faults else UNCLEAR if unjudged or not statuses else RIGHT
    return report


def _as_stored(graph, place, values):
    """Whether the file holds the value that the formula has; what is not a number is not compared."""
    value, stored = values[place][0], graph.cells[place].number
    return not np.isfinite(value) or abs(value - stored) <= 1e-6 * (1 + abs(stored))


def ranges(graph, places):
    """Write places as addresses, runs in a column as ranges."""
    left = sorted(places, key=lambda p: (graph.reading_order(p)[0], p[2], p[1]))
    while left:
        run = [left.pop(0)]
        while left and left[0] == (run[-1][0], run[-1][1] + 1, run[-1][2]):
            run.append(left.pop(0))
        last = f":{get_column_letter(run[-1][2])}{run[-1][1]}" if len(run) > 1 else ""
        yield graph.address(run[0]) + last
