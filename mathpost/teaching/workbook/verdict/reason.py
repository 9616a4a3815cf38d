"""Which rule gave the verdict of a cell, and the values that it used."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mathpost.teaching.workbook.sheet.tree import text_of

if TYPE_CHECKING:
    from mathpost.teaching.workbook.sheet.place import Place
    from mathpost.teaching.workbook.verdict.beside import Beside
    from mathpost.teaching.workbook.verdict.judge import Judge


def reason(judge: Judge, others: Beside, place: Place, status: str | None) -> list[str]:
    """Return lines on a cell: its contents, the rule that judged it, what that rule compared.

    Parameters
    ----------
    judge : Judge
        After `run`.
    others : Beside
    place : tuple
        Sheet, row, column.
    status : str
        As the report has it, or nothing.

    Returns
    -------
    list of str
    """
    graph, found = judge.graph, judge.found
    formula = f", ={text_of(graph.trees[place], place[0])}" if place in graph.trees else ""
    cell = graph.book.cells.get(place)
    number = graph.own.get(place)
    written = cell and cell.value if number is None else f"{number:.9g}"
    lines = [f"{graph.address(place)} is {written}{formula}: {status or 'no cell to judge'}"]
    used = [p for p in graph.uses.get(place, ()) if graph.own.get(p) is not None][:9]
    values = [f"{graph.address(p)} = {graph.own[p]:.9g}" for p in used]
    lines += [f"it uses {', '.join(values)}"] * bool(used)
    should, *_ = judge.fixed.get(place, [np.nan])
    lines += [f"it should be {should:.9g} at these inputs"] * bool(np.isfinite(should))
    for fault in (each for each in judge.faults if each.place == place):
        lines.append(f"rule: a fault, {fault.cause}: {fault.message}; {fault.rule}")
    result = next((c for c in found.calculations if place in c.results), None)
    needed = graph.upstream(p for c in found.calculations for p in c.results)
    if len(lines) > 1 and lines[-1].startswith("rule"):
        return lines
    if result is not None:
        asked = f", asked for at these inputs: {judge.targets[place][0]:.9g}" if place in judge.targets else ""
        parts = {name: getattr(result, name) for name in ("angles", "axis", "point", "origin")}
        given = [f"{name} {graph.range(cells)}" for name, cells in parts.items() if cells]
        given = given or [f"directions {' '.join(graph.ranges(result.given))}"]
        rule = f"it is a result, compared as a function of {', '.join(given)}{asked}"
    elif place in graph.aside:
        rule = "it is apart from all rotations, among too many cells to judge"
    elif place in graph.errors:
        rule = "it shows an error, or a text where others have numbers"
    elif status == "consequence":
        before = [each.cell for each in judge.faults if place in graph.downstream([each.place])]
        rule = f"it follows from {', '.join(before[:3])}" if before else "it is repaired together with a wrong cell"
    elif place in judge.inputs:
        made = place in graph.trees
        rule = (
            "a formula makes it, and it is taken as given: not judged"
            if made
            else "it is given, and was varied at random"
        )
    elif not found.calculations:
        rule = "no result was recognised, so that nothing was compared"
    elif place in others.rules:
        rule = f"no result needs it; {others.rules[place]}" if place not in needed else others.rules[place]
    elif place in needed and place in graph.trees:
        ends = [p for c in found.calculations for p in c.results if place in graph.upstream([p])]
        rule = f"it is on the way to {', '.join(map(graph.address, ends[:3]))}, right as functions"
    elif status:
        rule = "it is an array's part, or a number that no formula uses, like a right one"
    else:
        rule = "it is no number that follows from the inputs"
    return [*lines, f"rule: {rule}"]
