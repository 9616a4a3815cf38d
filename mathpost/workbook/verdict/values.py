"""A sheet of numbers without formulas: results under their headings, against what the task makes of its inputs.

Cells between them are listed, not judged. A slip that makes no difference at these numbers cannot be seen.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import count, permutations, product
from typing import TYPE_CHECKING

import numpy as np

from mathpost import euler
from mathpost.detective.digits import written_decimals
from mathpost.workbook.meaning.label import IN_RADIANS, Role
from mathpost.workbook.report import RIGHT, UNCLEAR, WRONG, Fault
from mathpost.workbook.sheet.file import EMPTY
from mathpost.workbook.sheet.place import Place, offset
from mathpost.workbook.verdict.labels import labelled

if TYPE_CHECKING:
    from mathpost.workbook.meaning.recognise import Recognised
    from mathpost.workbook.sheet.graph import Graph

CALCULATED = 3  # decimals that nobody gives
KINDS = ("angle", "coordinate", "outcome")


@dataclass
class Judged:
    """What a check of numbers says: place → status, empty if there is no result; the faults; what was seen.

    `asked` has what a result should be, and the places of angles and point; `given` are places of inputs.
    """

    statuses: dict[Place, str] = field(default_factory=dict)
    faults: list[Fault] = field(default_factory=list)
    seen: list[str] = field(default_factory=list)
    asked: dict[Place, tuple[float, list[Place], list[Place]]] = field(default_factory=dict)
    given: set[Place] = field(default_factory=set)


def check_values(graph: Graph, found: Recognised) -> Judged:
    """Return the `Judged` of a sheet of numbers, of which `found` is the `Recognised` workbook."""
    blocks = _inputs_and_results(graph, found.task.cells)
    values = Judged(given={place for role, place in blocks if role.kind != "outcome"})
    for angles, point, result in _calculations(graph, blocks):
        values.given.update(angles, point)
        _judge(graph, found, values, angles, point, result)
    if values.statuses:
        for place in graph.component.keys() - values.given - values.statuses.keys():
            value = graph.value(place)
            if value is None or written_decimals(value) >= CALCULATED:
                values.statuses[place] = UNCLEAR
        values.seen = [f"{graph.address(place)}: {role}" for role, place in blocks]
    return values


def _calculations(graph: Graph, blocks: list[tuple[Role, Place]]) -> Iterator[list[list[Place]]]:
    """Yield (angles, point, result), each of three places: each x' with the inputs that are nearest before it."""
    for n, (role, place) in enumerate(blocks):
        if role == Role("outcome", (0,)):
            near = dict([*blocks[n + 1 :][::-1], *blocks[:n]])  # the last before it, or else the first after it
            near |= {role: place for role, place in blocks[n:][::-1] if role.kind == "outcome"}
            for cells in (near, *(near | more for more in _more_points(graph, blocks, place))):
                threes = [[Role(kind, (k,)) for k in range(3)] for kind in KINDS]
                if all(role in cells for three in threes for role in three):
                    yield [[cells[role] for role in three] for three in threes]


def _judge(
    graph: Graph, found: Recognised, values: Judged, angles: list[Place], point: list[Place], result: list[Place]
) -> None:
    """Judge three results.

    Those that are all off are wrong where a slip explains them; else who knows what they are.
    """
    given = [graph.value(place) for place in (*angles, *point)]
    if None in given:
        values.statuses |= dict.fromkeys(result, UNCLEAR)
        return
    units = [1.0 if re.search(IN_RADIANS, found.label(p), re.I) else np.pi / 180 for p in angles]
    radians = np.array(given[:3]) * units
    matrix = _matrix(found, radians)
    vector = np.array(given[3:]) - (found.task.origin or (0, 0, 0))
    right, cells = matrix @ vector, [graph.cells.get(place, EMPTY) for place in result]
    values.asked |= {place: (value, angles, point) for place, value in zip(result, right, strict=True)}
    written, size = [cell.number for cell in cells], float(np.linalg.norm(right))

    def status(number: float | None, n: int, wanted: np.ndarray = right) -> str:
        if number is None:  # a text is wrong, an empty cell or a formula that was not read is not judged
            return UNCLEAR if cells[n].value is None or cells[n].formula else WRONG
        return _status(number, wanted[n], size)

    statuses = {place: status(number, n) for n, (place, number) in enumerate(zip(result, written, strict=True))}
    wrong = [n for n, place in enumerate(result) if statuses[place] == WRONG]
    fits = (
        slip
        for slip in _slips(found, radians, vector)
        if all(status(each, n, slip[2]) == RIGHT for n, each in enumerate(written))
    )
    cause, text, _ = next(fits, ("", "", None)) if len(wrong) > 1 else ("", "", None)
    said = found.by != "source 000" or cause != "other convention"
    if len(wrong) == 3 and not (cause and said) and None not in written:
        values.statuses |= dict.fromkeys(result, UNCLEAR)
        return
    values.statuses |= statuses
    for n in wrong:
        short, number = graph.short(result[n]), written[n]
        if number is None:
            cause, message = "wrong value", f"{short} holds {cells[n].value!r} where a number belongs"
        elif text:
            message = f"{short} is {text}"
        else:
            cause = "sign" if _status(-number, right[n], size) == RIGHT else "wrong value"
            message = f"{short} is {number:.6g}, should be {right[n]:.6g}"
        values.faults.append(Fault(graph.address(result[n]), cause, message, result[n]))


def _matrix(found: Recognised, radians: np.ndarray) -> np.ndarray:
    active = euler.matrix(found.sequence, radians)
    return active if found.active else active.T


def _slips(found: Recognised, radians: np.ndarray, point: np.ndarray) -> Iterator[tuple[str, str, np.ndarray]]:
    """Yield cause, sentence and the three results of slips that change all of them."""
    matrix = _matrix(found, radians)
    yield "other convention", "turned the other way, active for passive", matrix.T @ point
    for order in [*permutations(range(3))][1:]:
        under = "under the heading of another coordinate"
        yield "exchanged", f"made of what stands {under}", matrix @ point[[*order]]
        yield "exchanged", f"what belongs {under}", (matrix @ point)[[*order]]
    for order in product(range(3), repeat=3):
        yield "wrong angle", "turned by one angle in place of another", _matrix(found, radians[[*order]]) @ point


def _status(written: float, right: float, size: float) -> str:
    """Right to its digits; not judged if off by no more than what matrices of as many decimals, or three, lose."""
    off, decimals = abs(written - right), written_decimals(written)
    if off <= max(0.51 * 10.0**-decimals, 1e-9 * (1 + size)):
        return RIGHT
    return UNCLEAR if off <= size * 10.0 ** -max(decimals, CALCULATED) else WRONG


def _inputs_and_results(graph: Graph, cells: dict[str, str] | None) -> list[tuple[Role, Place]]:
    """(Role, place) of angles and coordinates, as they are read, but for angles that are others with a minus."""
    first: dict[Role, float | None] = {}
    found = []
    for block in labelled(graph, cells):
        place, value = block.places[0], graph.value(block.places[0])
        before = first.setdefault(block.role, value)
        if block.role.kind in KINDS and not (block.role.kind == "angle" and value and before == -value):
            found.append((block.role, place))
    return found


def _more_points(graph: Graph, blocks: list[tuple[Role, Place]], first: Place) -> Iterator[dict[Role, Place]]:
    """Yield role → place of what goes on below a row, or beside a column, of x y z and x' y' z', angles or not."""
    taken = {place for _, place in blocks}
    for along in (1, 2):
        line = {role: p for role, p in blocks if (p[0], p[along]) == (first[0], first[along])}
        points = {role: p for role, p in line.items() if role.kind != "angle"}
        line = line if len(line) == 9 else points
        for n in count(1) if len(points) == 6 else ():
            more = {role: offset(p, n * (along == 1), n * (along == 2)) for role, p in line.items()}
            numbers = sum(graph.value(place) is not None for place in more.values())
            if numbers < len(more) - 2 or not taken.isdisjoint(more.values()):
                break
            yield more
