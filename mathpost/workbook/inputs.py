"""Is what is given what was meant? Inputs that a text, their twins or their unused neighbours contradict."""

import re
from itertools import chain, product

import numpy as np

from mathpost.workbook.calculation import LARGEST_RADIANS
from mathpost.workbook.given import runs
from mathpost.workbook.graph import beside

GIVEN = r"origin|ursprung|nullpunkt|原点|offset|shift|verschieb|平移|\bpoint\b|\bpunkt\b|^\W*[pxyz]_?0?\W*$"


def doubts_of_inputs(graph, found):
    """Yield what makes it doubtful that the inputs of a recognised workbook are the right ones, as sentences."""
    questions = _unlike_the_text, _typed_twice, _not_converted, _not_used
    return chain.from_iterable(question(graph, found) for question in questions)


def _unlike_the_text(graph, found):
    """Yield what is given where a text of the sheet has the same three numbers but for one: a typing error?"""
    number, aside = r"[-+]?\d+(?:\.\d+)?", r"\(([^()]*)\)"
    texts = [
        part for text in found.text.splitlines() for part in (re.sub(aside, "", text), *re.findall(aside, text))
    ]
    said = {tuple(map(float, numbers)) for text in texts if len(numbers := re.findall(number, text)) == 3}
    given = {places for c in found.calculations for places in (c.angles, c.point, c.origin) if len(places) == 3}
    given = {places: tuple(graph.own[p] for p in places) for places in given if found.typed.issuperset(places)}
    for text, (places, numbers) in product(said - {*given.values()}, given.items()):
        alike = [abs(a - b) < 1e-6 for a, b in zip(text, numbers, strict=True)]
        if sum(alike) == 2 and any(same for same, number in zip(alike, numbers, strict=True) if number):
            yield f"{graph.range(places)} is {_three(numbers)}, and a text says {_three(text)}"


def _typed_twice(graph, found):
    """Yield inputs that stand in two places, the same but for one number: a typing error?"""
    own = graph.own
    given = {(*c.angles, *c.point, *c.origin): c for c in found.calculations}
    given = [places for places in given if places and found.typed.issuperset(places)]
    unused = found.lines(found.typed - graph.used.keys(), 3)
    tables = {id(graph.component[p]) for p in graph.used if p in graph.component}
    unused = [line for line in unused if id(graph.component[line[0]]) not in tables]
    threes = {c for each in found.calculations for c in (each.angles, each.point, each.origin) if len(c) == 3}
    pairs = [*product((c for c in threes if found.typed.issuperset(c)), unused)]
    if len(given) == 2 and len({graph.component[places[0]] for places in given}) == 2:
        pairs.append(given)
    for a, b in pairs:
        if len(a) == len(b) and set(a).isdisjoint(b):
            other = [(p, q) for p, q in zip(a, b, strict=True) if own[p] != own[q]]
            same = {own[p] for p in a} & {own[q] for q in b} - {0}
            if len(other) == 1 and len(same) > 1:
                p, q = other[0]
                yield f"{graph.address(p)} is {own[p]:g} and {graph.address(q)} {own[q]:g}, all else twice the same"


def _not_converted(graph, found):
    """Yield angles in degrees that no formula uses, beside what is not made of them but turns in their place."""
    for place in found.sorted(found.typed - graph.used.keys() - graph.trees.keys()):
        for near in found.angles.intersection(beside(place)):
            degrees, own = graph.own[place], graph.own[near]
            other = near in graph.trees or abs(np.rad2deg(own) - degrees) > 0.01 * abs(degrees)
            if abs(own) < LARGEST_RADIANS < abs(degrees) <= 360 and other:
                text = f"{graph.short(near)}, {own:g}, turns instead"
                yield f"{graph.address(place)}, {degrees:g}, is not used; {text}"


def _not_used(graph, found):
    """Yield a point or origin, by its label, that stands alone and that no formula uses."""
    known = [each for c in found.calculations for each in (c.point, c.origin, c.results[:3]) if len(each) == 3]
    known = np.array([[graph.own[p] for p in each] for each in known], dtype=float).reshape(-1, 3)
    for line in runs(found.typed - graph.used.keys() - graph.trees.keys()):
        alone = len(line) == 3 and len({q for p in line for q in beside(p)} & graph.component.keys()) == 3
        if alone and re.search(GIVEN, found.label(line[0]), re.I):
            numbers = np.array([graph.own[p] for p in line])
            if numbers.any() and not (np.abs(known - numbers).max(axis=-1, initial=0) < 0.02).any():
                yield f"{graph.range(line)} is {found.label(line[0]).strip()!r}, and no formula uses it"


def _three(numbers):
    return ", ".join(f"{number:g}" for number in numbers)
