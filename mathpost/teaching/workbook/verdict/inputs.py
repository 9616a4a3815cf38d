"""What is given against what is said of it: units, and numbers that a text names; and what no formula uses."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from mathpost.teaching.workbook.meaning.given import runs
from mathpost.teaching.workbook.meaning.label import plain, read_label
from mathpost.teaching.workbook.meaning.vocabulary import wording

if TYPE_CHECKING:
    from mathpost.teaching.workbook.meaning.recognise import Recognised
    from mathpost.teaching.workbook.sheet.place import Place

GIVEN = wording("origin", "centre", "shift")
NAME = r"[α-ω]|(?<![A-Za-z])[A-Za-z]+\d?"
NAMED_NUMBER = rf"({NAME}) *(?:\([^()]*\))? *[=:] *([-+−]? ?\d+(?:[.,]\d+)?)(?! *[*·/^\d])"
UNITS = {wording(name): size for name, size in (("radians", 1.0), ("gon", np.pi / 200), ("degrees", np.pi / 180))}


def contradicted(found: Recognised, units: dict[Place, float]) -> Iterator[str]:
    """Yield sentences on angles that a label or a text contradicts; `units` are the radians of 1 of each.

    A label may say another unit than that in which formulas take the angle; a text may give all three by name, of
    which one is another number.
    """
    graph = found.graph
    said: dict[str, set[float]] = {}
    for name, number in re.findall(NAMED_NUMBER, plain(found.text)):
        said.setdefault(name, set()).add(float(number.replace(",", ".").replace("−", "-").replace(" ", "")))
    for angles in dict.fromkeys(c.angles for c in found.calculations):
        typed = [p for p in angles if p in found.typed and p not in graph.trees and graph.own.get(p) is not None]
        for place in typed:
            named = [unit for name, unit in UNITS.items() if re.search(name, found.label(place), re.I)]
            if len(named) == 1 and abs(named[0] - units.get(place, named[0])) > 1e-6:
                yield f"{graph.address(place)} is {found.label(place).strip()!r}, and is taken in another unit"
        names = [{*re.findall(NAME, plain(found.label(p)))} & said.keys() for p in typed]
        if [len(each) for each in names] != [1, 1, 1] or any(len(said[name]) > 1 for (name,) in names):
            continue
        for place, (name,) in zip(typed, names, strict=True):
            (number,), own = said[name], graph.number(place) * np.rad2deg(units.get(place, np.pi / 180))
            others = [p for p, (n,) in zip(typed, names, strict=True) if graph.own[p] in said[n]]
            if abs(own - number) > 1e-6 and len(others) == 2:
                yield f"{graph.address(place)} is {own:.6g}, and a text says {name} = {number:g}"


def unused(found: Recognised) -> Iterator[str]:
    """Yield sentences on angles and points, by their labels, that no formula uses."""
    graph = found.graph
    places = found.typed - graph.used.keys() - graph.trees.keys()
    taken = {p: graph.own[p] for c in found.calculations for p in (*c.angles, *c.point, *c.origin)}
    for place in found.sorted(places):
        role = read_label(found.label(place))
        if role and role.kind in ("angle", "coordinate") and graph.own[place] not in taken.values():
            yield f"{graph.address(place)} is {role}, {graph.own[place]:g}, that no formula uses"
    for line in (line for line in runs(places) if len(line) == 3):
        numbers = {graph.own[p] for p in line}
        if any(numbers) and not numbers <= {*taken.values()} and re.search(GIVEN, found.label(line[0]), re.I):
            yield f"{graph.range(line)} is {found.label(line[0]).strip()!r}, and no formula uses it"
