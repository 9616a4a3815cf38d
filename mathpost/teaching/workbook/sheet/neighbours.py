"""What the formulas around a cell say that it should hold: those that go on by filling, or in equal steps."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from mathpost.detective.digits import written_decimals
from mathpost.teaching.workbook.sheet.place import offset
from mathpost.teaching.workbook.sheet.samples import Values
from mathpost.teaching.workbook.sheet.tree import areas, parts_of, with_areas

if TYPE_CHECKING:
    from mathpost.teaching.workbook.sheet.formula import Tree
    from mathpost.teaching.workbook.sheet.graph import Graph
    from mathpost.teaching.workbook.sheet.place import Place

TELLING = 3  # decimals, that a formula does not make by luck
WAYS = ((1, 0), (0, 1), (-1, 0), (0, -1))


def filled(graph: Graph, near: Place, place: Place) -> Tree | None:
    """The formula of a cell filled to a place; None if it has none, or is of an array of several cells."""
    if near not in graph.trees or len(graph.array(near)) > 1:
        return None
    own = areas(graph.trees[near])
    moved = [area for each in own if (area := each.filled(place[1] - near[1], place[2] - near[2]))]
    return with_areas(graph.trees[near], moved) if own and len(moved) == len(own) else None


def between(graph: Graph, place: Place, least: int) -> Tree | None:
    """The formula that those on both sides of a cell are filled from, in a line of `least` with the cell."""
    for down, right in WAYS[:2]:
        line = [offset(place, n * down, n * right) for n in (-2, -1, 1, 2)]
        outer, inner, other = pairwise(line)
        if _goes_on(graph, *inner) and (least < 4 or _goes_on(graph, *outer) or _goes_on(graph, *other)):
            return filled(graph, line[1], place)
    return None


def along(graph: Graph, place: Place) -> Iterator[Tree]:
    """Yield the formulas of two cells before or after a cell, filled."""
    for down, right in WAYS:
        near, next_one = (offset(place, n * down, n * right) for n in (1, 2))
        if _goes_on(graph, near, next_one) and (other := filled(graph, near, place)):
            yield other


def _goes_on(graph: Graph, a: Place, b: Place) -> bool:
    """Whether the formula of a cell is that of another one, filled."""
    form = graph.relative(a) if len(graph.array(a)) == 1 else None
    return form is not None and form == graph.relative(b)


def as_around(graph: Graph, place: Place) -> Tree | None:
    """The formula of a cell if it went on as those around it do, of the same form; None if they do not say."""
    (sheet, row, column), form, found = place, graph.form(place), []
    near = [(sheet, row + r, column + c) for r in range(-3, 4) for c in range(-3, 4) if r or c]
    near = [p for p in near if graph.component.get(p) is graph.component[place] and graph.form(p) == form]
    around = {p: areas(graph.trees[p]) for p in near}
    for k in range(len(areas(graph.trees[place]))):
        votes: Counter = Counter()
        for down, right in ((1, 0), (0, 1)):
            pairs = [(p, (p[0], p[1] + down, p[2] + right)) for p in around]
            steps = Counter(around[p][k].steps_to(around[q][k]) for p, q in pairs if q in around)
            for step, _ in steps.most_common(1):
                for sign in (1, -1):
                    there = around.get((sheet, row - sign * down, column - sign * right))
                    votes[there and there[k].moved(sign * step[0], sign * step[1])] += there is not None
        best = votes.most_common(1)
        if not best or best[0][0] is None:
            return None
        found.append(best[0][0])
    return with_areas(graph.trees[place], found) if found else None


def typed_over(graph: Graph) -> dict[Place, Tree]:
    """Return place → formula of a number where those around go on that make it, or take what nobody else does.

    A formula such as =RADIANS(20), or with some numbers for references, is such a number.
    """
    found, numbers = {}, graph.component.keys() - graph.trees.keys()
    unused = numbers - graph.used.keys()
    values = {p: np.array([number]) for p, number in graph.own.items() if number is not None}
    for place in sorted(graph.component.keys() - graph.part.keys(), key=graph.reading_order):
        own, count = set(graph.uses.get(place, ())), _numbers(graph.tree(place))
        if own and not count:
            continue
        other, is_used = between(graph, place, 3), place in graph.used
        sources = set(graph.used_by(other or ("text",)))
        if other and not own and is_used and sources & unused and graph.component.keys() >= sources:
            found[place] = other
        for tree in (other, *along(graph, place)):
            if tree is None or not own < set(graph.used_by(tree)):
                continue
            fewer = place in numbers or count > _numbers(tree)
            if fewer and _is_made(graph, place, tree, values):
                found[place] = tree
    return found


def _is_made(graph: Graph, place: Place, tree: Tree, values: Values) -> bool:
    """Whether a formula gives the number in a cell, to more digits than by luck."""
    number = graph.own[place]
    if number is None or not np.isfinite(number) or not graph.component.keys() >= set(graph.used_by(tree)):
        return False
    decimals = written_decimals(number)
    few = decimals == 0 and float(f"{number:.2g}") == number
    telling = decimals >= TELLING or (place not in graph.used and not few)
    if tree[0] != "area" and abs(number) not in (0, 1):  # the last of a series
        lines = ([offset(place, -n * down, -n * right) for n in (3, 2, 1)] for down, right in WAYS[:2])
        telling |= any(
            _goes_on(graph, a, b) and _goes_on(graph, b, c) and filled(graph, c, place) == tree for a, b, c in lines
        )
    return telling and abs(graph.cell(place, values, tree)[0] - number) <= max(0.51 * 10.0**-decimals, 1e-9)


def _numbers(tree: Tree) -> int:
    """How many numbers are typed in a formula."""
    return sum(part[0] == "number" for part in parts_of(tree))
