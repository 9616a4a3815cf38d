"""Formulas that repeat the formula of an earlier cell: read as a reference to that cell and what is new."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

from mathpost.teaching.workbook.sheet.formula import Area
from mathpost.teaching.workbook.sheet.place import offset
from mathpost.teaching.workbook.sheet.tree import areas

if TYPE_CHECKING:
    from mathpost.teaching.workbook.sheet.formula import Tree
    from mathpost.teaching.workbook.sheet.place import Place

LONG = 16  # cells of a sum from which it is read as the one before it and what is added
RUNNING = {"SUM", "MAX", "MIN", "PRODUCT"}


def running_totals(trees: Mapping[Place, Tree], arrays: Collection[Place]) -> dict[Place, Tree]:
    """Place → the tree of a long sum, as the one before it and what is added.

    n running totals then refer to 2·n cells, not n²/2. None of `arrays` is read so.
    """
    totals, found = {}, {}
    for place, tree in trees.items():
        if tree[0] in RUNNING and len(tree) == 2 and tree[1][0] == "area" and place not in arrays:
            area = tree[1][1]
            totals[place] = tree[0], replace(area, fixed=(False, False))
    for place, (head, area) in totals.items():
        down, right = (1, 0) if area.shape[1] == 1 else (0, 1)
        before = offset(place, -down, -right)
        if 1 in area.shape and sum(area.shape) > LONG and totals.get(before) == (head, area.but_last()):
            last = replace(area, top=area.bottom, left=area.right)
            found[place] = head, ("area", Area(*before, *before[1:])), ("area", last)
    return found


def blanks_as_before(trees: Mapping[Place, Tree], cells: Collection[Place]) -> dict[Place, Tree]:
    """Place → the tree of =IF(B5=B4,"",B5), which says only what changes, with the cell before for the blank."""
    blank, found = ("text", ""), {}
    for place, tree in trees.items():
        if tree[0] == "IF" and blank in tree[2:]:
            single = {(area.sheet, area.top, area.left) for area in areas(tree[1]) if area.shape == (1, 1)}
            ways = [way for way in ((-1, 0), (0, -1)) if any(offset(p, *way) in single for p in single)]
            before = [offset(place, *way) for way in ways if offset(place, *way) in cells]
            if before:
                cell = ("area", Area(*before[0], *before[0][1:]))
                found[place] = tuple(cell if part == blank else part for part in tree)
    return found
