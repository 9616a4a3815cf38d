"""Is what is given what was meant? Inputs that a text, their twins or their unused neighbours contradict."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from itertools import chain, combinations, product
from typing import TYPE_CHECKING

import numpy as np

from mathpost.workbook.meaning.calculation import LARGEST_RADIANS
from mathpost.workbook.meaning.given import runs
from mathpost.workbook.meaning.label import IN_DEGREES, IN_RADIANS, plain
from mathpost.workbook.meaning.texts import ORIGIN
from mathpost.workbook.sheet.place import Line, beside

if TYPE_CHECKING:
    from mathpost.workbook.meaning.recognise import Recognised
    from mathpost.workbook.sheet.graph import Graph
    from mathpost.workbook.sheet.place import Place

NAMED = rf"{ORIGIN}|cent(?:re|er)|mittelpunkt|中心"
GIVEN = rf"{NAMED}|offset|shift|verschieb|平移|\bpoint\b|\bpunkt\b|^\W*[pxyz]_?0?\W*$"
FEW = 6  # numbers that no formula uses
LOOKED_UP = "LOOKUP|INDEX|OFFSET|CHOOSE"
SEXAGESIMAL = r"\bmin|\bsec|\bsek|分|秒|[′″]|^ *['\"] *$"
NAME = r"[α-ω]|(?<![A-Za-z])[A-Za-z]+\d?"
NAMED_NUMBER = rf"({NAME}) *(?:\([^()]*\))? *[=:] *([-+−]? ?\d+(?:[.,]\d+)?)(?! *[*·/^\d])"
UNIT_NAMES = {
    IN_RADIANS: 1.0,
    r"\bgon\b|neugrad": np.pi / 200,
    IN_DEGREES: np.pi / 180,
}


def doubts_of_inputs(graph: Graph, found: Recognised, units: dict[Place, float]) -> list[str]:
    """Return what makes it doubtful that the inputs of a recognised workbook are the right ones, as sentences.

    `units` has the radians of 1 of each angle, as the formulas take it.
    """
    questions = _unlike_the_text, _typed_twice, _not_converted, _not_used, _parts_not_used, _added_by_hand
    doubts = chain.from_iterable(question(graph, found) for question in questions)
    return [*doubts, *_in_another_unit(graph, found, units)]


def angle_in_the_text(found: Recognised, units: dict[Place, float]) -> tuple[float, ...]:
    """The three angles of a sheet in degrees, if a text gives each by name and one of them only is another."""
    (angles, *others) = dict.fromkeys(c.angles for c in found.calculations) or [()]
    said: dict[str, set[float]] = {}
    for name, number in re.findall(NAMED_NUMBER, plain(found.text)):
        said.setdefault(name, set()).add(float(number.replace(",", ".").replace("−", "-").replace(" ", "")))
    names = [{*re.findall(NAME, plain(found.label(p)))} & said.keys() for p in angles]
    is_number = all(found.graph.own.get(p) is not None for p in angles)
    if others or not is_number or [len(each) for each in names] != [1, 1, 1]:
        return ()
    numbers = [said[name] for (name,) in names]
    own = [found.graph.own[p] * np.rad2deg(units.get(p, np.pi / 180)) for p in angles]
    alike = [any(abs(a - number) < 1e-6 for number in each) for a, each in zip(own, numbers, strict=True)]
    is_one = sum(alike) == 2 and all(len(each) == 1 for each in numbers)
    return tuple(number for (number,) in numbers) if is_one else ()


def _unlike_the_text(graph: Graph, found: Recognised) -> Iterator[str]:
    """Yield what is given where a text of the sheet has the same three numbers but for one: a typing error?"""
    number, aside = r"[-+]?\d+(?:\.\d+)?", r"\(([^()]*)\)"
    texts = [
        part for text in found.text.splitlines() for part in (re.sub(aside, "", text), *re.findall(aside, text))
    ]
    said = [tuple(map(float, numbers)) for text in texts if len(numbers := re.findall(number, text)) == 3]
    threes = (places for c in found.calculations for places in (c.angles, c.point, c.origin) if len(places) == 3)
    given = {places: tuple(map(graph.number, places)) for places in threes if found.typed.issuperset(places)}
    others = [three for three in dict.fromkeys(said) if three not in given.values()]
    for three, (places, own) in product(others, given.items()):
        alike = [abs(a - b) < 1e-6 for a, b in zip(three, own, strict=True)]
        if sum(alike) == 2 and any(same for same, number in zip(alike, own, strict=True) if number):
            yield f"{graph.range(places)} is {_three(own)}, and a text says {_three(three)}"


def _typed_twice(graph: Graph, found: Recognised) -> Iterator[str]:
    """Yield inputs that are in two places, the same but for one number: a typing error?"""
    own = graph.own
    inputs = dict.fromkeys((*c.angles, *c.point, *c.origin) for c in found.calculations)
    given = [places for places in inputs if places and found.typed.issuperset(places)]
    parts = (c for each in found.calculations for c in (each.angles, each.point, each.origin) if len(c) == 3)
    threes = [c for c in dict.fromkeys(parts) if found.typed.issuperset(c)]
    unused, numbers = found.typed - graph.used.keys(), {own[p] for three in threes for p in three}
    tables = {id(graph.component[p]) for p in graph.used if p in graph.component}
    lines = [line for line in found.lines({p for p in unused if own[p] in numbers}, 2) if unused.issuperset(line)]
    apart = [line for line in lines if id(graph.component[line[0]]) not in tables]
    pairs: list[tuple[Line, Line]] = [*product(threes, apart)]
    if len(given) == 2 and len({graph.component[places[0]] for places in given}) == 2:
        pairs.append((given[0], given[1]))
    for a, b in pairs:
        if len(a) == len(b) and set(a).isdisjoint(b):
            other = [(p, q) for p, q in zip(a, b, strict=True) if own[p] != own[q]]
            same = {own[p] for p in a} & {own[q] for q in b} - {0}
            if len(other) == 1 and len(same) > 1:
                p, q = other[0]
                yield f"{graph.address(p)} is {own[p]:g} and {graph.address(q)} {own[q]:g}, all else twice the same"


def _not_converted(graph: Graph, found: Recognised) -> Iterator[str]:
    """Yield angles in degrees that no formula uses, beside what is not made of them but turns in their place."""
    for place in found.sorted(found.typed - graph.used.keys() - graph.trees.keys()):
        for near in (p for p in beside(place) if p in found.angles):
            degrees, own = graph.number(place), graph.number(near)
            other = near in graph.trees or abs(np.rad2deg(own) - degrees) > 0.01 * abs(degrees)
            if abs(own) < LARGEST_RADIANS < abs(degrees) <= 360 and other:
                text = f"{graph.short(near)}, {own:g}, turns instead"
                yield f"{graph.address(place)}, {degrees:g}, is not used; {text}"


def _not_used(graph: Graph, found: Recognised) -> Iterator[str]:
    """Yield three numbers that no formula uses and that their names call given: a point, an origin.

    Numbers called a point are alone, or are the origin; coordinates may be anywhere.
    """
    threes = [each for c in found.calculations for each in (c.point, c.origin, c.results[:3]) if len(each) == 3]
    known = np.array([[graph.own.get(p) for p in each] for each in threes], dtype=float).reshape(-1, 3)
    for line in runs(found.typed - graph.used.keys() - graph.trees.keys()):
        if len(line) != 3:
            continue
        alone = len({q for p in line for q in beside(p)} & graph.component.keys()) == 3
        label, named = found.label(line[0]), [found.coordinate(p) for p in line] == [(0,), (1,), (2,)]
        users = (user for p in graph.component[line[0]] for user in graph.used.get(p, ()))
        if not alone and any(re.search(LOOKED_UP, graph.cells[user].formula or "") for user in users):
            continue  # of a table
        if named or re.search(GIVEN if alone else NAMED, label, re.I):
            numbers = np.array([graph.own[p] for p in line])
            if numbers.any() and not (np.abs(known - numbers).max(axis=-1, initial=0) < 0.02).any():
                yield f"{graph.range(line)} is {label.strip()!r}, and no formula uses it"


def _parts_not_used(graph: Graph, found: Recognised) -> Iterator[str]:
    """Yield minutes and seconds next to degrees, or the other way round, that no formula uses."""
    parts = found.angles.union(*(graph.uses[place] for place in found.composed))
    for place in found.sorted(found.typed - graph.used.keys() - graph.trees.keys()):
        near = [p for p in parts if graph.component.get(p) is graph.component[place]]
        if any(place[1] == p[1] or place[2] == p[2] for p in near) and re.search(
            SEXAGESIMAL, "\n".join(found.texts(place)), re.I
        ):
            yield f"{graph.address(place)}, {graph.own[place]:g}, is a part of an angle, and no formula uses it"


def _added_by_hand(graph: Graph, found: Recognised) -> Iterator[str]:
    """Yield a number that is used in place of two or three that no formula uses and whose sum it is."""
    for place, each in _used_and_not(graph, found):
        if abs(sum(map(graph.number, each)) - graph.number(place)) < 1e-9 * abs(graph.number(place)):
            names = " and ".join(map(graph.short, each))
            yield f"{graph.address(place)} is {graph.own[place]:g}, as {names} together, which no formula uses"


def sums_typed_over(graph: Graph, found: Recognised, off: float) -> Iterator[tuple[Place, str]]:
    """Yield a number that is used and is `off` from the sum of some that no formula uses, and a sentence."""
    for place, each in _used_and_not(graph, found):
        total, number = sum(map(graph.number, each)), graph.number(place)
        if abs(abs(total - number) - abs(off)) < 1e-6 * abs(total):
            names = " and ".join(map(graph.short, each))
            yield place, f"{graph.short(place)} is a number, {number:g}, and {names} together are {total:g}"


def _used_and_not(graph: Graph, found: Recognised) -> Iterator[tuple[Place, tuple[Place, ...]]]:
    """Yield typed numbers that formulas use, each with two or three that none uses."""
    alone = [p for p in found.sorted(found.typed - graph.used.keys() - graph.trees.keys()) if graph.own[p]]
    alone = [p for p in alone if len(graph.component[p]) <= FEW]
    parts = [each for size in (2, 3) for each in combinations(alone, size)] if len(alone) <= FEW else []
    used = [
        p for p in found.sorted(found.typed & graph.used.keys() - graph.trees.keys()) if abs(graph.number(p)) >= 10
    ]  # of fewer digits many numbers are sums by luck
    yield from product(used if parts else (), parts)


def _in_another_unit(graph: Graph, found: Recognised, units: dict[Place, float]) -> Iterator[str]:
    """Yield angles of which the text before them says another unit than that in which the formulas take them."""
    for places in dict.fromkeys(c.angles for c in found.calculations):
        for place in places:
            said = [unit for name, unit in UNIT_NAMES.items() if re.search(name, found.label(place), re.I)]
            typed = place in found.typed and place not in graph.trees
            if len(said) == 1 and typed and abs(said[0] - units.get(place, said[0])) > 1e-6:
                yield f"{graph.address(place)} is {found.label(place).strip()!r}, and is taken in another unit"


def _three(numbers: Iterable[float]) -> str:
    return ", ".join(f"{number:g}" for number in numbers)
