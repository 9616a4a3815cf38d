"""The rows of a table share one origin, and have their points and angles at the same offsets."""

from __future__ import annotations

from collections import Counter
from itertools import permutations
from typing import TYPE_CHECKING

from mathpost.teaching.workbook.meaning.calculation import Turn
from mathpost.teaching.workbook.meaning.texts import CENTRE, ORIGIN
from mathpost.teaching.workbook.sheet.place import Place, offset

if TYPE_CHECKING:
    from mathpost.teaching.workbook.meaning.recognise import Recognised
    from mathpost.teaching.workbook.sheet.place import Line


def rows_alike(found: Recognised) -> None:
    """Give the rows of each table of a `Recognised` workbook what the others say that they have.

    A table next to another one that has angles of its own has a point of its own, where there is one.
    """
    tables: dict[Line, list] = {}
    for calculation in found.calculations:
        tables.setdefault(found.graph.component[calculation.results[0]], []).append(calculation)
    for rows in tables.values():  # one origin, even if a $ is missing
        ((origin, between), _), *_ = Counter((row.origin, _between(row)) for row in rows).most_common(1)
        (shift, _), *_ = Counter(row.shift for row in rows).most_common(1)
        for row in rows:
            own = row.origin and (_between(row) == between or found.is_named(row.origin, f"{ORIGIN}|{CENTRE}"))
            row.origin = row.origin if own else origin
            row.shift = shift
        _give(found, rows, "point")
        if len({row.angles for row in rows}) > 1:
            _give(found, rows, "angles")
    firsts = {id(found.graph.component[c.results[0]]): c for c in found.calculations if c.angles}
    for one, other in permutations(firsts.values(), 2):
        if one.point == other.point and one.angles != other.angles:
            down, right = _step(one.angles[0], other.angles[0])
            own = tuple((other.angles[0][0], *offset(p, down, right)[1:]) for p in one.point)
            if _is_unused(found, own):
                other.point = own


def _give(found: Recognised, rows: list[Turn], part: str) -> None:
    """Give a row of a table the point, or angles, that are as far from its result as in other rows.

    They are cells that no formula uses, or a point that is there in all other rows.
    """
    given = {row: own for row in rows if (own := getattr(row, part))}
    apart = Counter((own[0][0], *_step(row.results[0], own[0])) for row, own in given.items())
    for row, now in given.items():
        for (sheet, down, right), votes in sorted(apart.items(), key=lambda way: (-way[1], abs(way[0][1]))):
            _, top, left = offset(row.results[0], down, right)
            own = tuple((sheet, top + n, left + k) for n, k in (_step(now[0], p) for p in now))
            most = votes > 2 and votes == len(rows) - 1
            most |= votes > 1 and own in given.values()  # two rows that have each other's
            most &= part == "point"
            if own == now or _is_unused(found, own) or (most and found.graph.component.keys() >= set(own)):
                setattr(row, part, own)
                break


def _is_unused(found: Recognised, line: Line) -> bool:
    """Whether some cells are numbers that no formula uses."""
    return bool(line) and found.typed.issuperset(line) and found.graph.used.keys().isdisjoint(line)


def _step(a: Place, b: Place) -> tuple[int, int]:
    """How far it is from a place to another, down and to the right."""
    return b[1] - a[1], b[2] - a[2]


def _between(row: Turn) -> Line:
    """How far the origin of a row of a table is from its angles: the same where both are looked up."""
    steps = zip(row.origin[:1], row.angles[:1], strict=False)
    return tuple((p[0], p[1] - q[1], p[2] - q[2]) for p, q in steps)
