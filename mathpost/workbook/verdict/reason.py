"""Which rule gave the verdict of a cell, and the values that it used."""

from mathpost.workbook.sheet.tree import text_of


def reason(judge, others, place, status):
    """Return lines on a cell: what stands there, the rule that judged it, what that rule compared.

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
    written = graph.own.get(place)
    written = cell and cell.value if written is None else f"{written:.9g}"
    lines = [f"{graph.address(place)} is {written}{formula}: {status or 'no cell to judge'}"]
    used = [p for p in graph.uses.get(place, ()) if graph.own.get(p) is not None][:9]
    used = [f"{graph.address(p)} = {graph.own[p]:.9g}" for p in used]
    lines += [f"it uses {', '.join(used)}"] * bool(used)
    lines += [f"rule: a fault, {each.cause}: {each.message}" for each in judge.faults if each.place == place]
    result = next((c for c in found.calculations if place in c.results), None)
    needed = graph.upstream(p for c in found.calculations for p in c.results)
    if len(lines) > 1 and lines[-1].startswith("rule"):
        return lines
    if result is not None:
        asked = f", asked for at these inputs: {judge.targets[place][0]:.9g}" if place in judge.targets else ""
        given = f"angles {graph.range(result.angles)}" if result.angles else "its inputs"
        given += f", point {graph.range(result.point)}" if result.point else ""
        rule = f"it is a result, compared as a function of {given}{asked}"
    elif place in graph.aside:
        rule = "it is apart from all rotations, among too many cells to judge"
    elif place in graph.errors:
        rule = "it shows an error, or a text where others have numbers"
    elif status == "consequence":
        before = [each.cell for each in judge.faults if place in graph.downstream([each.place])]
        rule = f"it follows from {', '.join(before[:3])}"
    elif place in judge.inputs:
        rule = "it is given, and was varied at random"
    elif place in others.unjudged:
        rule = "no result needs it, and it is nothing that follows from right ones, or not what its place says"
    elif place in needed and place in graph.trees:
        ends = [p for c in found.calculations for p in c.results if place in graph.upstream([p])]
        rule = f"it is on the way to {', '.join(map(graph.address, ends[:3]))}, right as functions"
    elif status:
        rule = "no result needs it, and it is a number or of a vector that follows from right ones"
    else:
        rule = "it is no number that follows from the inputs"
    return [*lines, f"rule: {rule}"]
