"""The first wrong cell: the one change of one cell that makes what is missing right, and breaks nothing."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import islice
from typing import Any

import numpy as np

from mathpost.teaching.workbook.reference.quantities import Sheet, agree
from mathpost.teaching.workbook.reference.results import Comparison
from mathpost.teaching.workbook.sheet.edits import ROUGHLY, edits, said
from mathpost.teaching.workbook.sheet.formula import Area, Tree
from mathpost.teaching.workbook.sheet.neighbours import filled
from mathpost.teaching.workbook.sheet.place import Place, beside
from mathpost.teaching.workbook.sheet.samples import SAMPLES, Values, at, at_samples
from mathpost.teaching.workbook.sheet.tree import ROUNDING, areas, exact, parts_of, put, text_of, walk, with_areas

TOGETHER = 64  # changes that are evaluated side by side
PATTERN = 3  # cells with one formula, of which none is wrong alone
MANY, MOST_EDITS = 30, 1000
MOST_CELLS = 60  # on the way to a result, the last before it
SCALES = (2.0, np.pi, 4.0, 10.0, 60.0, 100.0, 180.0, 360.0, 1000.0, 3600.0, 25.4, np.pi / 180)
IN_UNITS = {
    **{np.pi / 180: "degrees for radians", 180 / np.pi: "radians for degrees"},
    **{25.4: "inch for mm", 1 / 25.4: "mm for inch"},
}  # fmt: skip


@dataclass(frozen=True)
class Change:
    """A change of one cell: why, in words, its formula or, for a number, what it should be as a function."""

    place: Place
    cause: str
    message: str
    tree: Tree | None
    values: Values  # of the cell, and of those to which it was filled
    kind: int = 0  # how telling it is, 0 the most


def first_wrong(comparison: Comparison, result: Place, target: Place) -> Change | None:
    """The change that makes `target` the missing `result`; None if no single one does."""
    if comparison.is_template and (change := _unlike_the_same_cell(comparison, target)):
        return change
    wanted = {target: at_samples(comparison.ours[result])}
    options = [
        (_rank(comparison, change, wanted), n, change) for n, change in enumerate(_changes(comparison, wanted))
    ]
    return min(options, key=lambda each: each[:2])[2] if options else None


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
        for cause, old, new, whole in _all_edits(comparison, place, own, wanted) if place in sheet.trees else ():
            made = sheet.calculate(whole, comparison.theirs)
            if all(agree(at_samples(at(made, sheet.part.get(p, (0, 0)))), value) for p, value in wanted.items()):
                return Change(place, cause, _in_words(place, old, new), whole, wanted)
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


def _changes(comparison: Comparison, wanted: Values) -> Iterator[Change]:
    """Yield the changes that make the target right and leave right what is, the earliest cell first."""
    sheet, (target,) = comparison.handed_in, wanted
    inputs = comparison.matched.back
    way = [
        p for p in sheet.upstream([target]) if p not in inputs and (p in sheet.trees or p in sheet.numbers_typed)
    ]
    way.sort(key=sheet.calculation_order)
    found = {cell: result for result, cell in comparison.found.items()}
    for alike in _patterns(sheet, [p for p in way if p not in found])[-MOST_CELLS:]:
        place = alike[0]
        own = comparison.theirs.get(place)
        own = at_samples(np.full(1, sheet.value(place) or 0.0) if own is None else own)
        after = sheet.downstream(alike)
        between = after & sheet.upstream([target])
        keep = [cell for cell in found if cell in after]
        for change in _fitting(comparison, alike, own, wanted, between):
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
    comparison: Comparison, alike: Sequence[Place], own: np.ndarray, wanted: Values, between: set[Place]
) -> Iterator[Change]:
    """Yield the changes of a cell, and of those `alike`, that give the target what it should be."""
    sheet, (target,), place = comparison.handed_in, wanted, alike[0]
    made = [*edited(comparison, alike, own, wanted)]
    if place != target or place not in sheet.trees:  # that a result should be what it is explains nothing
        made += _replaced(comparison, place)
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
    if own_label is not None and agree(value, own_label):
        return 0
    if own in comparison.steps:
        return 5
    if place != target and (
        value in comparison.steps or (value in comparison.known and own not in comparison.known)
    ):
        return 1
    return 3 if own in comparison.known else 2


def edited(comparison: Comparison, alike: Sequence[Place], own: np.ndarray, wanted: Values) -> Iterator[Change]:
    """Yield the formula of a cell with one change, those that somebody may have meant; filled to those alike."""
    sheet, place = comparison.handed_in, alike[0]
    if place not in sheet.trees:
        yield from _as_beside(comparison, place)
        return
    tree, index = sheet.trees[place], sheet.part.get(place, (0, 0))
    held = sheet.parts_at(tree, comparison.theirs)
    after, seen = sheet.downstream(alike), set()
    most = MOST_EDITS if len(alike) < MANY else MOST_EDITS // 5
    for cause, old, new, whole in islice(_all_edits(comparison, place, own, wanted), most):
        if whole in seen or not after.isdisjoint(sheet.used_by(whole)):
            continue
        seen.add(whole)
        values = {place: at_samples(at(sheet.calculate(whole, comparison.theirs, held=held), index))}
        for other in alike[1:]:
            old_areas = areas(whole)
            moved = [m for a in old_areas if (m := a.filled(other[1] - place[1], other[2] - place[2]))]
            if len(moved) < len(old_areas):
                break
            values[other] = at_samples(sheet.cell(other, comparison.theirs, with_areas(whole, moved)))
        else:
            yield Change(place, cause, _in_words(place, old, new), whole, values)


def _in_words(place: Place, old: Tree, new: Tree) -> str:
    """A change of a part of a formula, in words."""
    if old[0] == "number" and new == ("number", np.pi):
        return f"{old[1]:g} is typed for π"
    return said(place, old, new) + ": rounded in between" * (old[0] in ROUNDING)


def _as_beside(comparison: Comparison, place: Place) -> Iterator[Change]:
    """Yield the formulas of the cells beside a number, filled to it."""
    sheet = comparison.handed_in
    for near in beside(place):
        tree = filled(sheet, near, place)
        if tree is not None and place not in sheet.used_by(tree):
            said = f"{sheet.short(place)} is a number, {sheet.value(place):g}, typed where a formula belongs"
            text = f"{said}, ={text_of(tree, place[0])}"
            yield Change(
                place,
                "typed over formula",
                text,
                tree,
                {place: at_samples(sheet.cell(place, comparison.theirs, tree))},
            )


def _all_edits(
    comparison: Comparison, place: Place, own: np.ndarray, wanted: Values
) -> Iterator[tuple[str, Tree, Tree, Tree]]:
    """Yield (cause, part, what it should be, whole tree): π, units, those of `sheet.edits`, numbers, squares."""
    sheet = comparison.handed_in
    tree = sheet.trees[place]
    for part in parts_of(tree):
        if part[0] == "number" and (new := exact(part, ROUGHLY)) != part:
            yield "rounded early", part, new, exact(tree, ROUGHLY)
    for path, part in walk(tree):
        if part[0] in ROUNDING:
            yield "rounded early", part, part[1], put(tree, path, part[1])
    if place in wanted and (own != 0).all() and (unit := _unit(wanted[place] / own)):
        factor = next(f for f, name in IN_UNITS.items() if name == unit)
        new = ("*", tree, ("number", factor))
        yield unit, tree, new, new
    for path, part in walk(tree):
        if part[0] in ("*", "/"):
            for new in part[1:]:
                yield "wrong value", part, new, put(tree, path, new)
        is_cell = part[0] == "area" and part[1].shape == (1, 1)
        if is_cell or part[0] in ("+", "-", "minus", "*"):
            new = ("^", part, ("number", 2.0))
            yield "wrong value", part, new, put(tree, path, new)
        if is_cell:
            for function in ("RADIANS", "DEGREES", "ABS", "SQRT"):
                cause = {"RADIANS": "degrees for radians", "DEGREES": "radians for degrees"}.get(
                    function, "wrong value"
                )
                yield cause, part, (function, part), put(tree, path, (function, part))
    for cause, old, new, whole in edits(sheet, place, list(comparison.matched.back)[:MOST_CELLS]):
        yield ("wrong value" if cause in ("half angle", "offset") else cause), old, new, whole
    formulas = comparison.reference.trees.values()
    typed = {part[1] for each in formulas for part in parts_of(each) if part[0] == "number"}
    numbers = sorted({*typed, *SCALES})[:MOST_CELLS]
    for path, part in walk(tree):
        if part[0] == "number":
            for number in numbers:
                new = ("number", number)
                yield "wrong value", part, new, put(tree, path, new)
    for number in numbers:
        for head in ("*", "/"):
            new = (head, tree, ("number", number))
            yield "wrong value", tree, new, new
    others = [p for p in sheet.order if p not in sheet.messages][:MOST_CELLS]
    for path, part in walk(tree):
        if part[0] == "area" and part[1].shape == (1, 1):
            for other in others:
                new = ("area", Area(*other, *other[1:]))
                yield "wrong reference", part, new, put(tree, path, new)
    for other in [*comparison.matched.back, *others][:MOST_CELLS]:
        for head in "*/+-":
            new = (head, tree, ("area", Area(*other, *other[1:])))
            yield "missing term", tree, new, new


def _unit(ratio: np.ndarray) -> str:
    """The name of the unit if a ratio is the same at all samples and that of two units."""
    return next((name for factor, name in IN_UNITS.items() if agree(ratio, np.full(SAMPLES, factor))), "")


def _replaced(comparison: Comparison, place: Place) -> Iterator[Change]:
    """Yield a quantity of the reference in place of what a cell is."""
    sheet, reference = comparison.handed_in, comparison.reference
    is_typed = place not in sheet.trees
    seen: set[Place] = set()
    for key, value in zip(comparison.known.keys, comparison.known.values, strict=True):
        is_cell = key not in seen and key in comparison.ours and agree(value, at_samples(comparison.ours[key]))
        if not (is_cell or is_typed):
            continue
        seen.add(key)
        name = reference.label(key)
        there = f"{reference.short(key)} of the reference" + f" ({name})" * bool(name)
        if is_typed:
            number = sheet.value(place)
            near = number is not None and abs(value[0] - number) <= 0.01 * abs(value[0])
            if near and np.ptp(value) == 0 and abs(value[0] - np.pi) < 1e-9:
                yield Change(place, "rounded early", f"{number:g} is typed for π", None, {place: value})
            elif near:
                text = f"{sheet.short(place)} is a number, {number:g}, typed where a formula belongs: {there}"
                yield Change(place, "typed over formula", text, None, {place: value})
        else:
            yield Change(place, "wrong value", f"{sheet.short(place)} should be {there}", None, {place: value})


def repair(comparison: Comparison, change: Change) -> list[Place]:
    """Put a change into the hand-in, and into all cells to which the wrong formula was filled; return these."""
    sheet, place = comparison.handed_in, change.place
    relative = sheet.relative(place) if place in sheet.trees and place not in sheet.part else None
    alike = [p for p in sheet.trees if relative is not None and p != place and sheet.relative(p) == relative]
    if comparison.is_template:
        known = [p for p in alike if p in comparison.ours and p in comparison.reference.trees]
        alike = [p for p in known if not agree(at_samples(comparison.theirs[p]), at_samples(comparison.ours[p]))]
    elif len(alike) < PATTERN - 1:
        alike = []
    if change.tree is None:
        comparison.fixed |= change.values
        for each in change.values:
            sheet.trees.pop(each, None)
        alike = []
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
