"""The check of one file: its formulas as functions, or, where there are none, its values."""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from mathpost.workbook.file import read_plain
from mathpost.workbook.graph import SAMPLES, Graph, same
from mathpost.workbook.judge import Judge
from mathpost.workbook.recognise import Recognised, Task

RIGHT, WRONG, UNCLEAR = "right", "wrong", "unclear"


@dataclass
class FileReport:
    """What the check says about one file.

    Attributes
    ----------
    path : pathlib.Path
    verdict : str
        ``"right"``, ``"wrong"`` or ``"unclear"``: not all of it could be judged.
    checked, total : int
        How many cells downstream of the inputs were judged, and how many there are.
    not_checked : list of str
        Addresses.
    faults : list
        Wrong cells, the first one first, each with `cell`, `cause` and `message`.
    seen : list of str
        What was recognised, with addresses.
    warnings : list of str
    """

    path: Path
    verdict: str = UNCLEAR
    checked: int = 0
    total: int = 0
    not_checked: list = field(default_factory=list)
    faults: list = field(default_factory=list)
    seen: list = field(default_factory=list)
    warnings: list = field(default_factory=list)


def check_file(path, task=None):
    """Check a spreadsheet by its formulas."""
    task = task or Task()
    book = read_plain(path)
    graph = Graph(book)
    report = FileReport(Path(path))
    found = Recognised(graph, task)
    judge = Judge(graph, found).run()
    report.faults = judge.faults
    report.seen = [c.said + ": " + found.place_text(c.results) for c in found.calculations] + found.problems
    unjudged = judge.judge_the_rest()
    places = judge.all_places
    report.total, report.checked = len(places), len(places) - len(unjudged)
    report.not_checked = [graph.address(p) for p in unjudged]
    report.warnings = judge.warnings
    report.verdict = WRONG if report.faults else UNCLEAR if unjudged or not found.calculations else RIGHT
    return report
