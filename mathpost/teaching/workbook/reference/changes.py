"""Changes of one cell: its formula with one part that somebody may have meant, or a quantity of the reference."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import islice

import numpy as np

from mathpost.teaching.workbook.reference.quantities import agree
from mathpost.teaching.workbook.reference.results import Comparison
from mathpost.teaching.workbook.sheet.edits import ROUGHLY, edits, said
from mathpost.teaching.workbook.sheet.formula import Area, Tree
from mathpost.teaching.workbook.sheet.neighbours import filled
from mathpost.teaching.workbook.sheet.place import Place, beside
from mathpost.teaching.workbook.sheet.samples import SAMPLES, Values, at, at_samples
from mathpost.teaching.workbook.sheet.tree import ROUNDING, areas, exact, parts_of, put, text_of, walk, with_areas

MANY, MOST_EDITS, MOST_USUAL = 30, 1000, 200
MOST_CELLS = 60  # on the way to a result, the last before it
SCALES = (2.0, np.pi, 4.0, 10.0, 60.0, 100.0, 180.0, 360.0, 1000.0, 3600.0, 25.4, np.pi / 180)
IN_UNITS = {
    **{np.pi / 180: "degrees for radians", 180 / np.pi: "radians for degrees"},
    **{25.4: "inch for mm", 1 / 25.4: "mm for inch"},
}  # fmt: skip
TURNED = {np.pi / 180: "RADIANS", 180 / np.pi: "DEGREES"}


@dataclass(frozen=True)
class Change:
    """A change of one cell: why, in words, its formula or, for a number, what it should be as a function."""

    place: Place
    cause: str
    text: str
    tree: Tree | None
    values: Values  # of the cell, and of those to which it was filled
    kind: int = 0  # how telling it is, 0 the most
    parts: tuple[Tree, Tree] | None = None  # what is there and what should be, if that is what is to be said

    @property
    def message(self) -> str:
        """The change in words."""
        return in_words(self.place, *self.parts) if self.parts else self.text


Edits = Callable[[Comparison, Place, np.ndarray, Values], Iterator[tuple[str, Tree, Tree, Tree]]]


def edited(
    comparison: Comparison, alike: Sequence[Place], own: np.ndarray, wanted: Values, some: Edits
) -> Iterator[Change]:
    """Yield the formula of a cell with one change, those that somebody may have meant; filled to those alike."""
    sheet, place = comparison.handed_in, alike[0]
    if place not in sheet.trees:
        yield from _as_beside(comparison, place)
        return
    tree, index = sheet.trees[place], sheet.part.get(place, (0, 0))
    held = sheet.parts_at(tree, comparison.theirs)
    after, seen = sheet.downstream(alike), set()
    most = MOST_EDITS if len(alike) < MANY else MOST_EDITS // 5
    for cause, old, new, whole in islice(some(comparison, place, own, wanted), most):
        comparison.tries -= len(alike)
        if comparison.tries < 0:
            return
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
            yield Change(place, cause, "", whole, values, parts=(old, new))


def in_words(place: Place, old: Tree, new: Tree) -> str:
    """A change of a part of a formula, in words."""
    if old[0] == new[0] == "area" and old[1].places == new[1].places:
        return f"{text_of(old, place[0])} should be {new[1].written()}"
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


def unlike_edits(
    comparison: Comparison, place: Place, own: np.ndarray, wanted: Values
) -> Iterator[tuple[str, Tree, Tree, Tree]]:
    """Yield (cause, part, what it should be, whole tree) as formulas of the reference have it."""
    for old, new, whole in comparison.unlike.corrected(place):
        if new[0] in TURNED.values() and new[1] == old:  # an angle may have to be turned in an earlier cell
            continue
        usual = islice(_usual_edits(comparison, place, own, wanted), MOST_USUAL)
        known = (cause for cause, *_, other in usual if other == whole)
        cells = old[0] == new[0] == "area"
        yield next(known, "wrong reference" if cells else "wrong value"), old, new, whole


def all_edits(
    comparison: Comparison, place: Place, own: np.ndarray, wanted: Values
) -> Iterator[tuple[str, Tree, Tree, Tree]]:
    """Yield the same, then those that need no reference: π, units, those of `sheet.edits`, numbers, squares."""
    yield from unlike_edits(comparison, place, own, wanted)
    yield from _usual_edits(comparison, place, own, wanted)


def _usual_edits(
    comparison: Comparison, place: Place, own: np.ndarray, wanted: Values
) -> Iterator[tuple[str, Tree, Tree, Tree]]:
    """Those that need no formula of the reference."""
    sheet = comparison.handed_in
    tree = sheet.trees[place]
    new: Tree
    for path, part in walk(tree):
        for fixed in ((True, True), (True, False), (False, True)) if part[0] == "area" else ():
            new = ("area", replace(part[1], fixed=fixed))
            yield "wrong reference", part, new, put(tree, path, new)
    for part in parts_of(tree):
        if part[0] == "number" and (new := exact(part, ROUGHLY)) != part:
            yield "rounded early", part, new, exact(tree, ROUGHLY)
    for path, part in walk(tree):
        if part[0] in ROUNDING:
            yield "rounded early", part, part[1], put(tree, path, part[1])
    if place in wanted and (own != 0).all() and (unit := _unit(wanted[place] / own)):
        factor = next(f for f, name in IN_UNITS.items() if name == unit)
        new = (TURNED[factor], tree) if factor in TURNED else ("*", tree, ("number", factor))
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


def replaced(comparison: Comparison, place: Place) -> Iterator[Change]:
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
