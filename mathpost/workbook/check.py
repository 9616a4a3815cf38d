"""The check of one file: its formulas as functions, or, where there are none, its values."""

from pathlib import Path

import numpy as np
from openpyxl.utils import get_column_letter

from mathpost.workbook.file import read_plain
from mathpost.workbook.graph import Graph
from mathpost.workbook.judge import Judge
from mathpost.workbook.nc_table import looked_at
from mathpost.workbook.recognise import Recognised, Task
from mathpost.workbook.report import CONSEQUENCE, RIGHT, UNCLEAR, WRONG, FileReport, Judgement


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
    ('wrong', 'ZXZ!I38', 'transposed')
    """
    task = task or Task()
    graph = Graph(read_plain(path))
    found = Recognised(graph, task)
    judge = Judge(graph, found).run()
    unjudged = judge.judge_the_rest()
    wrong = {fault.cell for fault in judge.faults}
    follows = graph.downstream(judge.fixed)
    report = FileReport(Path(path), faults=judge.faults, warnings=judge.warnings)
    if task.machine is not None:
        own = graph.run({})
        words = [[own.get(p, judge.constant(p))[0] for p in row.results] for row in found.calculations]
        report.warnings = [*report.warnings, *looked_at(found.calculations, np.array(words, dtype=float))]
    report.seen = [f"{found.place_text(c.results)}: {c.said}" for c in found.calculations] + found.problems
    for place in judge.all_places:
        address = graph.address(place)
        status = RIGHT
        if address in wrong:
            status = WRONG
        elif place in unjudged:
            status = UNCLEAR
        elif place in follows:
            status = CONSEQUENCE
        cell = graph.cells[place]
        written = cell.number if cell.number is not None else cell.value
        report.cells.append(Judgement(address, place, status, written, cell.formula))
    report.not_checked = list(ranges(graph, unjudged))
    judged = bool(report.cells) and not unjudged and found.calculations and not found.problems
    report.verdict = WRONG if report.faults else RIGHT if judged else UNCLEAR
    return report


def ranges(graph, places):
    """Write places as addresses, runs in a column as ranges."""
    left = sorted(places, key=lambda p: (graph.reading_order(p)[0], p[2], p[1]))
    while left:
        run = [left.pop(0)]
        while left and left[0] == (run[-1][0], run[-1][1] + 1, run[-1][2]):
            run.append(left.pop(0))
        last = f":{get_column_letter(run[-1][2])}{run[-1][1]}" if len(run) > 1 else ""
        yield graph.address(run[0]) + last
