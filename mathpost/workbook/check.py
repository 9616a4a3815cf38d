"""The check of one file: its formulas as functions, or, where there are none, its values."""

import re
from itertools import product

import numpy as np

from mathpost.workbook.beside import Beside
from mathpost.workbook.calculation import LARGEST_RADIANS
from mathpost.workbook.edits import INVERSE
from mathpost.workbook.file import EMPTY, read
from mathpost.workbook.formula import areas, heads
from mathpost.workbook.given import runs
from mathpost.workbook.graph import Graph, beside, same
from mathpost.workbook.judge import Judge
from mathpost.workbook.label import read_label
from mathpost.workbook.nc_table import looked_at
from mathpost.workbook.neighbours import as_around, typed_over
from mathpost.workbook.recognise import Recognised
from mathpost.workbook.report import CONSEQUENCE, RIGHT, UNCLEAR, WRONG, FileReport, Judgement
from mathpost.workbook.task import Task
from mathpost.workbook.values import check_values

GIVEN = r"origin|ursprung|nullpunkt|原点|offset|shift|verschieb|平移|\bpoint\b|\bpunkt\b|^\W*[pxyz]_?0?\W*$"
LUCKY = "numbers without formulas: that they are right by luck cannot be excluded"


@np.errstate(all="ignore")  # a cell may hold what is no number
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
    if lost := typed_over(graph):
        before, graph = graph, Graph(graph.book)
        graph.trees |= lost  # as if they were not
    graph.unround()
    found = Recognised(graph, task)
    judge = Judge(graph, found).run()
    judge.faults[:0] = [judge.typed_number(place, before.tree(place)) for place in found.sorted(lost)]
    if not found.calculations and (report := _by_values(graph, found)).cells:
        return report
    others = Beside(judge)
    typed = {p: c for c in found.calculations if c.typed for p in c.results}
    typed = {p: UNCLEAR if p in graph.trees or not c.complete else RIGHT for p, c in typed.items()}
    after = graph.downstream([*judge.fixed, *lost])
    statuses = {p: CONSEQUENCE if p in after else RIGHT for p in others.places}
    statuses |= dict.fromkeys(others.unjudged, UNCLEAR)
    # An input that is not the task's is wrong, though it is none of the cells that follow from the inputs.
    statuses |= typed | {fault.place: WRONG for fault in judge.faults}
    warnings = [f"{graph.address(p)} depends on itself" for p in sorted(graph.circular, key=graph.reading_order)]
    after_lost = graph.downstream(lost)
    stored = {p: graph.cells[p].number for p in graph.order if p not in after_lost}
    stored = {p: number for p, number in stored.items() if number is not None}
    stale = [p for p, number in stored.items() if abs(graph.own[p] - number) > 1e-6 * (1 + abs(number))]
    angles = {graph.own[p] for c in found.calculations for p in c.angles}
    for place in found.sorted(found.typed - graph.used.keys()) if angles else ():
        role = read_label(found.label(place))
        if role and role.kind == "angle" and graph.own[place] not in angles:
            warnings.append(f"{graph.address(place)} is an angle, {graph.own[place]:g}, that no formula uses")
    if stale:
        warnings.append(f"stored values are not what the formulas give: {', '.join(graph.ranges(stale[:6]))}")
    warnings += [LUCKY] * bool(typed)
    if task.machine is not None:
        warnings += looked_at(found.calculations, graph.own)
    elif not judge.faults:
        warnings += _lucky_references(graph, judge)
    seen = [c.said if task.machine else f"{graph.range(c.results)}: {c.said}" for c in found.calculations if c.said]
    if judge.reading:
        sequence, convention = judge.reading
        axes = "turned" if sequence.isupper() else "fixed"
        seen = [
            f"it is {sequence} about {axes} axes, {convention}; no text says so, and source 000 has ZXZ, passive",
            f"if that was asked, add --sequence {sequence} --convention {convention}",
            *(graph.range(c.results) for c in found.calculations),
        ]
    for calculation in judge.unexplained:
        text = "is not what the task asks for, and no single change makes it so"
        found.problems.append(f"{graph.range(calculation.results)} {text}")
    unlike = [*_unlike_the_text(graph, found), *_typed_twice(graph, found), *_not_converted(graph, found)]
    unlike += [*_not_used(graph, found)]
    found.problems += [text for triple, text in found.doubts.items() if not others.unjudged.isdisjoint(triple)]
    unclear = not found.calculations or found.problems or judge.reading
    if unclear and not (judge.faults or judge.reading or task.machine):
        if not found.planes and any(heads(tree) & INVERSE for tree in graph.trees.values()):
            found.problems.append("tool axes and the words of a machine are judged with --machine FILE")
        found.problems.append(_ready_cells(graph, found.turning))
    seen += [*found.problems, *unlike]
    return _report(graph, statuses, judge.faults, seen, warnings, unclear or unlike)


def _unlike_the_text(graph, found):
    """Yield what is given where a text of the sheet has the same three numbers but for one: a typing error?"""
    number, aside = r"[-+]?\d+(?:\.\d+)?", r"\(([^()]*)\)"
    texts = [
        part for text in found.text.splitlines() for part in (re.sub(aside, "", text), *re.findall(aside, text))
    ]
    said = {tuple(map(float, numbers)) for text in texts if len(numbers := re.findall(number, text)) == 3}
    given = {places for c in found.calculations for places in (c.angles, c.point, c.origin) if len(places) == 3}
    given = {places: tuple(graph.own[p] for p in places) for places in given if found.typed.issuperset(places)}
    for text, (places, numbers) in product(said - {*given.values()}, given.items()):
        alike = [abs(a - b) < 1e-6 for a, b in zip(text, numbers, strict=True)]
        if sum(alike) == 2 and any(same for same, number in zip(alike, numbers, strict=True) if number):
            yield f"{graph.range(places)} is {_three(numbers)}, and a text says {_three(text)}"


def _typed_twice(graph, found):
    """Yield inputs that stand in two places, the same but for one number: a typing error?"""
    own = graph.own
    given = {(*c.angles, *c.point, *c.origin): c for c in found.calculations}
    given = [places for places in given if places and found.typed.issuperset(places)]
    unused = found.lines(found.typed - graph.used.keys(), 3)
    tables = {id(graph.component[p]) for p in graph.used if p in graph.component}
    unused = [line for line in unused if id(graph.component[line[0]]) not in tables]
    threes = {c for each in found.calculations for c in (each.angles, each.point, each.origin) if len(c) == 3}
    pairs = [*product((c for c in threes if found.typed.issuperset(c)), unused)]
    if len(given) == 2 and len({graph.component[places[0]] for places in given}) == 2:
        pairs.append(given)
    for a, b in pairs:
        if len(a) == len(b) and set(a).isdisjoint(b):
            other = [(p, q) for p, q in zip(a, b, strict=True) if own[p] != own[q]]
            same = {own[p] for p in a} & {own[q] for q in b} - {0}
            if len(other) == 1 and len(same) > 1:
                p, q = other[0]
                yield f"{graph.address(p)} is {own[p]:g} and {graph.address(q)} {own[q]:g}, all else twice the same"


def _not_converted(graph, found):
    """Yield angles in degrees that no formula uses, beside what is not made of them but turns in their place."""
    for place in found.sorted(found.typed - graph.used.keys() - graph.trees.keys()):
        for near in found.angles.intersection(beside(place)):
            degrees, own = graph.own[place], graph.own[near]
            other = near in graph.trees or abs(np.rad2deg(own) - degrees) > 0.01 * abs(degrees)
            if abs(own) < LARGEST_RADIANS < abs(degrees) <= 360 and other:
                text = f"{graph.short(near)}, {own:g}, turns instead"
                yield f"{graph.address(place)}, {degrees:g}, is not used; {text}"


def _not_used(graph, found):
    """Yield a point or origin, by its label, that stands alone and that no formula uses."""
    places = [each for c in found.calculations for each in (c.point, c.origin, c.results[:3])]
    known = np.array([[graph.own[p] for p in each] for each in places if len(each) == 3], dtype=float)
    known = known.reshape(-1, 3)
    for line in runs(found.typed - graph.used.keys() - graph.trees.keys()):
        alone = len(line) == 3 and len({q for p in line for q in beside(p)} & graph.component.keys()) == 3
        if alone and re.search(GIVEN, found.label(line[0]), re.I):
            numbers = np.array([graph.own[p] for p in line])
            if numbers.any() and not (np.abs(known - numbers).max(axis=-1, initial=0) < 0.02).any():
                yield f"{graph.range(line)} is {found.label(line[0]).strip()!r}, and no formula uses it"


def _three(numbers):
    return ", ".join(f"{number:g}" for number in numbers)


def _by_values(graph, found):
    statuses, faults, seen = check_values(graph, found)
    if statuses:  # a formula is not looked at there
        statuses = dict.fromkeys(graph.trees.keys() - graph.messages, UNCLEAR) | statuses
    return _report(graph, statuses, faults, seen, [LUCKY])


def _report(graph, statuses, faults, seen, warnings, unclear=False):
    cells = []
    for place, status in statuses.items():
        cell = graph.cells.get(place, EMPTY)
        cells.append(
            Judgement(graph.address(place), place, status, cell.value if cell.number is None else cell.number)
        )
    unjudged = list(graph.ranges(place for place, status in statuses.items() if status == UNCLEAR))
    verdict = WRONG if faults else UNCLEAR if unclear or unjudged or not statuses else RIGHT
    return FileReport(graph.book.path, verdict, faults, cells, unjudged, seen, [*warnings, *graph.book.notes])


def _ready_cells(graph, turning=()):
    """The option that says where angles, point and result stand, filled with what looks like them."""
    lines = {}
    for n, place in product((1, 2), graph.component):
        lines.setdefault((graph.component[place][0], n, place[n]), []).append(place)
    lines = (line for line in lines.values() if len(line) == 3)
    lines = sorted(lines, key=lambda line: graph.reading_order(line[0]))
    given = [line for line in lines if graph.trees.keys().isdisjoint(line)] or [None]
    angles = next((line for line in given if set(line or ()) & set(turning)), given[0])
    point = next((line for line in given if line != angles), None)
    result = next((line for line in lines[::-1] if line not in (angles, point)), None)
    named = {"angles": angles, "point": point, "result": result}
    text = ",".join(f"{name}={graph.range(line) if line else 'A1:A3'}" for name, line in named.items())
    return f"where it stands can be said: --cells {text!r}"


def _lucky_references(graph, judge):
    """References that are not those to which the formulas around point, though the value is always the same."""
    for place in graph.order:
        around = None if place in graph.part else as_around(graph, place)
        if around and same(judge.now(place), graph.cell(place, judge.values, around)):
            for a, b in zip(areas(graph.trees[place]), areas(around), strict=True):
                if a != b:
                    text = f"{graph.address(place)} refers to {a} where the formulas around it ask for {b}"
                    yield f"{text}; it is always the same here"
