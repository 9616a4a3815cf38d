"""The first wrong cell: the one change of one cell that makes what is missing right, and breaks nothing."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from mathpost.teaching.workbook.reference.changes import (
    MOST_CELLS,
    Change,
    Edits,
    all_edits,
    edited,
    replaced,
    unlike_edits,
)
from mathpost.teaching.workbook.reference.quantities import Sheet, agree
from mathpost.teaching.workbook.reference.results import Comparison
from mathpost.teaching.workbook.sheet.neighbours import filled
from mathpost.teaching.workbook.sheet.place import Place
from mathpost.teaching.workbook.sheet.samples import Values, at, at_samples
from mathpost.teaching.workbook.sheet.tree import areas, text_of

TOGETHER = 64  # changes that are evaluated side by side
PATTERN = 3  # cells with one formula, of which none is wrong alone


def first_wrong(comparison: Comparison, result: Place, target: Place) -> Change | None:
    """The change that makes `target` the missing `result`; None if no single one does."""
    if comparison.is_template and (change := _unlike_the_same_cell(comparison, target)):
        return change
    wanted = {target: at_samples(comparison.ours[result])}
    for some in (unlike_edits, all_edits):  # a part that is unlike the reference is the smallest change
        options = [
            (_rank(comparison, change, wanted), n, change)
            for n, change in enumerate(_changes(comparison, wanted, some))
        ]
        if options:
            return min(options, key=lambda each: each[:2])[2]
    return None


def _unlike_the_same_cell(comparison: Comparison, target: Place) -> Change | None:
    """The first cell on the way that is not what stands there in a reference of the same layout."""
    sheet, reference, inputs = comparison.handed_in, comparison.reference, comparison.matched.back
    for place in sorted(sheet.upstream([target]) - inputs.keys(), key=sheet.calculation_order):
        if place not in reference.trees or place not in comparison.ours:
            continue
        wanted = {p: at_samples(comparison.ours[p]) for p in sheet.array(place) if p in comparison.ours}
        number = sheet.value(place)
        own = at_samples(comparison.theirs.get(place, np.full(1, np.nan if number is None else number)))
        if agree(own, wanted[place]):
            continue
        for cause, old, new, whole in all_edits(comparison, place, own, wanted) if place in sheet.trees else ():
            made = sheet.calculate(whole, comparison.theirs)
            if all(agree(at_samples(at(made, sheet.part.get(p, (0, 0)))), value) for p, value in wanted.items()):
                return Change(place, cause, "", whole, wanted, parts=(old, new))
        formula = text_of(reference.trees[place], place[0])
        if place in sheet.trees:
            return Change(
                place, "wrong value", f"{sheet.short(place)} is not {formula}, as in the reference", None, wanted
            )
        text = f"{sheet.short(place)} is a number, {number or 0.0:g}, typed where a formula belongs: {formula}"
        return Change(place, "typed over formula", text, None, wanted)
    return None


def _rank(comparison: Comparison, change: Change, wanted: Values) -> tuple[int, int]:
    """A change that explains more of what is missing comes first, then how telling it is."""
    sheet = comparison.handed_in
    after = sheet.downstream(change.values)
    explained = 0
    targets = [(r, cells[0]) for r, cells in comparison.candidates.items() if cells and cells[0] in after]
    if targets:
        only = after & sheet.upstream(c for _, c in targets[:MOST_CELLS])
        values = sheet.run({**comparison.put, **change.values}, comparison.theirs, only)
        explained = sum(
            bool(agree(at_samples(values[c]), at_samples(comparison.ours[r]))) for r, c in targets[:MOST_CELLS]
        )
    return -explained, change.kind


def _changes(comparison: Comparison, wanted: Values, some: Edits) -> Iterator[Change]:
    """Yield the changes that make the target right and leave right what is, the earliest cell first."""
    sheet, (target,) = comparison.handed_in, wanted
    inputs = comparison.matched.back
    way = [
        p for p in sheet.upstream([target]) if p not in inputs and (p in sheet.trees or p in sheet.numbers_typed)
    ]
    way.sort(key=sheet.calculation_order)
    found = {cell: result for result, cell in comparison.found.items()}
    for alike in _patterns(sheet, [p for p in way if p not in found])[-MOST_CELLS:]:
        if comparison.tries < 0:
            return
        place = alike[0]
        own = comparison.theirs.get(place)
        own = at_samples(np.full(1, sheet.value(place) or 0.0) if own is None else own)
        after = sheet.downstream(alike)
        between = after & sheet.upstream([target])
        keep = [cell for cell in found if cell in after]
        for change in _fitting(comparison, alike, own, wanted, between, some):
            if _keeps(comparison, change, after, keep, found):
                yield change


def _patterns(sheet: Sheet, places: Sequence[Place]) -> list[list[Place]]:
    """Some cells, those with one formula together, as none of several is wrong alone; in their order."""
    groups: dict[Any, list[Place]] = {}
    for place in places:
        is_filled = place in sheet.trees and place not in sheet.part
        groups.setdefault((sheet.relative(place) if is_filled else None) or place, []).append(place)
    return [part for group in groups.values()
            for part in ([group] if len(group) >= PATTERN else [[place] for place in group])]  # fmt: skip


def _keeps(comparison: Comparison, change: Change, after: set[Place], keep: Sequence[Place], found: dict) -> bool:
    """Whether what was found stays right."""
    if not keep:
        return True
    sheet = comparison.handed_in
    keep = keep[:MOST_CELLS]
    only = after & sheet.upstream(keep)
    values = sheet.run({**comparison.put, **change.values}, comparison.theirs, only)
    return all(agree(at_samples(values[c]), at_samples(comparison.ours[found[c]])) for c in keep)


def _fitting(
    comparison: Comparison,
    alike: Sequence[Place],
    own: np.ndarray,
    wanted: Values,
    between: set[Place],
    edits: Edits,
) -> Iterator[Change]:
    """Yield the changes of a cell, and of those `alike`, that give the target what it should be."""
    sheet, (target,), place = comparison.handed_in, wanted, alike[0]
    made = [*edited(comparison, alike, own, wanted, edits)]
    if place not in sheet.trees or (edits is all_edits and place != target):
        made += replaced(comparison, place)  # that a result should be what it is explains nothing
    made = [change for change in made if all(np.isfinite(value).all() for value in change.values.values())]
    for start in range(0, len(made), TOGETHER):
        some = made[start : start + TOGETHER]
        if place == target:
            values = np.array([change.values[target] for change in some])
        else:
            values = sheet.run_each([c.values for c in some], comparison.put, comparison.theirs, between)[target]
        for change, is_right in zip(some, agree(values, wanted[target]), strict=True):
            passed_on = change.tree is None and place in sheet.trees and agree(change.values[place], wanted[target])
            if is_right and not passed_on:
                yield replace(change, kind=_kind(comparison, change, own, wanted))


def _kind(comparison: Comparison, change: Change, own: np.ndarray, wanted: Values) -> int:
    """How telling a change is: first what makes a cell what its label says, or a quantity of the reference."""
    (target,), place = wanted, change.place
    value, own_label = change.values[place], comparison.expected(place)
    if change.tree is None and place in comparison.handed_in.trees:
        return 4
    if own_label is not None and agree(own, own_label):
        return 6
    if place != target and own_label is not None and agree(value, own_label):
        return 0
    if own in comparison.steps:
        return 5
    if place != target and (
        value in comparison.steps or (value in comparison.known and own not in comparison.known)
    ):
        return 1
    return 3 if own in comparison.known else 2


def repair(comparison: Comparison, change: Change) -> list[Place]:
    """Put a change into the hand-in, and into all cells to which the wrong formula was filled; return these."""
    sheet, place = comparison.handed_in, change.place
    relative = sheet.relative(place) if place in sheet.trees and place not in sheet.part else None
    alike = [p for p in sheet.trees if relative is not None and p != place and sheet.relative(p) == relative]
    if comparison.is_template:
        ours, pattern = comparison.reference, comparison.reference.relative(place)
        known = [p for p in alike if p in comparison.ours and p in ours.trees]
        alike = [
            p for p in known
            if (pattern is not None and ours.relative(p) == pattern)
            or not agree(at_samples(comparison.theirs[p]), at_samples(comparison.ours[p]))
        ]  # fmt: skip
    elif len(alike) < PATTERN - 1:
        alike = []
    if change.tree is None:
        comparison.fixed |= change.values
        for each in change.values:
            sheet.trees.pop(each, None)
        alike = [each for each in change.values if each != place]
    else:
        for each in sheet.array(place):
            sheet.trees[each] = change.tree
        for other in alike if areas(change.tree) else ():
            tree = filled(sheet, place, other)
            if tree is not None and other not in comparison.found.values():
                sheet.trees[other] = tree
    sheet.forget()
    comparison.run()
    return [place, *alike]
