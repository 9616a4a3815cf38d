"""Single repairs of a formula: what somebody may have meant, as (cause, sentence, tree), the likeliest first."""

from collections import Counter
from itertools import product

import numpy as np

from mathpost.workbook.formula import Area, areas, put, text_of, walk, with_areas
from mathpost.workbook.graph import same

TRIGONOMETRY = {"SIN": "COS", "COS": "SIN"}
INVERSE = {"ASIN", "ACOS", "ATAN", "ATAN2"}
ROUNDING = {"ROUND", "ROUNDDOWN", "ROUNDUP", "TRUNC", "INT"}
CONVERSIONS = np.array([np.pi, np.pi / 180, 180 / np.pi, 180.0, 2 * np.pi, 200 / np.pi])
OTHER = {"+": "-", "-": "+", "*": "/", "/": "*"}


def repaired(graph, wanted, values, inputs=()):
    """Return (cause, sentence, tree) of the single repair of a formula that gives, with `values`, those `wanted`.

    These are of a cell, or of several of one array formula; `inputs` may be meant wherever they stand.
    """
    place = next(iter(wanted))
    after = graph.downstream(wanted)
    for cause, sentence, tree in edits(graph, place, inputs) if place in graph.trees else ():
        fits = all(same(graph.cell(p, values, tree), value) for p, value in wanted.items())
        if fits and (cause != "wrong reference" or after.isdisjoint(graph.used_by(tree))):
            return cause, sentence, tree
    return None


def edits(graph, place, inputs=()):
    """Yield (cause, sentence, tree) for every single repair of the formula in `place`."""
    tree = graph.trees[place]
    parts = list(walk(tree))
    if sum(part[0] in TRIGONOMETRY for _, part in parts) > 1:
        text = "the angles are in degrees, not in radians"
        yield "degrees for radians", text, converted(tree, "RADIANS")
        text = "the angles are in radians already, and converted once more"
        yield "radians for degrees", text, converted(tree, "DEGREES")
    for kind in (_functions, _signs):
        for path, part in parts:
            for cause, sentence, new in kind(path, part):
                yield cause, sentence, put(tree, path, new)
    references = [(path, part[1]) for path, part in parts if part[0] == "area"]
    for path, area in references:
        if area.shape != (1, 1):
            yield "transposed", f"{area} must be transposed", put(tree, path, ("TRANSPOSE", ("area", area)))
    for path, area, new in _elsewhere(graph, place, references, inputs):
        if new and new != area and place not in new.places:
            yield "wrong reference", f"{area} should be {new}", put(tree, path, ("area", new))
    for path, part in parts:
        text = f"{text_of(part)} is rounded too early"
        if part[0] in ROUNDING:
            yield "rounded early", text, put(tree, path, part[1])
        if part[0] == "number":
            for near in CONVERSIONS[np.abs(part[1] - CONVERSIONS) < 0.01 * CONVERSIONS]:
                yield "rounded early", text, put(tree, path, ("number", float(near)))
    if tree[0] in ("+", "-") and tree[2][0] == "number":
        yield "offset", f"{tree[0]}{text_of(tree[2])} is added to it", tree[1]
    yield from _terms(tree)
    for path, part in parts:
        if part[0] in ("*", "/"):
            text = f"{part[0]} should be {OTHER[part[0]]}"
            yield "wrong value", text, put(tree, path, (OTHER[part[0]], *part[1:]))


def _elsewhere(graph, place, references, inputs):
    """Yield (path, area, other area): as the cells around have it, nearby, an input, further up."""
    around = areas(as_around(graph, place) or ("text",))
    yield from ((*reference, new) for reference, new in zip(references, around, strict=False))
    for reach in (1, 2, 3, 4):
        span = range(-reach, reach + 1)
        steps = [(down, right) for down in span for right in span if reach in (abs(down), abs(right))]
        yield from ((path, area, area.moved(*step)) for (path, area), step in product(references, steps))
    for path, area in references:
        yield from ((path, area, Area(*p, *p[1:])) for p in inputs if area.shape == (1, 1))
        yield from ((path, area, area.moved(-up, 0)) for up in range(5, 60) if not area.fixed[0])


def converted(tree, function):
    """The tree with the argument of every sine and cosine in `function`."""
    parts = tuple(converted(part, function) if isinstance(part, tuple) else part for part in tree)
    return (parts[0], (function, parts[1])) if tree[0] in TRIGONOMETRY else parts


def _functions(path, part):
    """Units, and one function for another."""
    name, *inner = part
    text = text_of(part)
    if name in TRIGONOMETRY or name == "TAN":
        said = f"{name} takes radians: {text_of(inner[0])} is in degrees"
        yield "degrees for radians", said, (name, ("RADIANS", inner[0]))
        said = f"{text_of(inner[0])} is in radians already, and converted once more"
        yield "radians for degrees", said, (name, ("DEGREES", inner[0]))
    if name in ("RADIANS", "DEGREES"):
        cause = "radians for degrees" if name == "RADIANS" else "degrees for radians"
        yield cause, f"{text} is converted once more", inner[0]
    if name in INVERSE:
        yield "radians for degrees", f"{text} is in radians where degrees belong", ("DEGREES", part)
    if name == "area" and not path:
        yield "degrees for radians", f"{text} is in degrees", ("RADIANS", part)
        yield "radians for degrees", f"{text} is in radians", ("DEGREES", part)
    if name in TRIGONOMETRY:
        said = f"{name} should be {TRIGONOMETRY[name]}"
        yield "sin and cos exchanged", said, (TRIGONOMETRY[name], *inner)
    if name == "ATAN2":
        yield "atan2 order", "ATAN2 takes x first, then y", (name, *inner[::-1])
    if name == "ATAN" and inner[0][0] == "/":
        _, y, x = inner[0]
        for x_y in ((x, y), (("minus", x), ("minus", y))):
            yield "atan for atan2", "ATAN loses the quadrant that ATAN2 keeps", ("ATAN2", *x_y)
    if name in ("TRANSPOSE", "MINVERSE"):
        yield "transposed", f"{text_of(inner[0])} must not be transposed", inner[0]
    if name == "MMULT":
        a, b = inner
        yield "order of product", f"the order is {text_of(b)} times {text_of(a)}", (name, b, a)
        for n, factor in enumerate(inner):
            if factor[0] != "TRANSPOSE":
                said = f"{text_of(factor)} must be transposed"
                yield "transposed", said, put(part, (n + 1,), ("TRANSPOSE", factor))
    if not path and name in ("MMULT", "TRANSPOSE"):
        yield "transposed", "the whole must be transposed", ("TRANSPOSE", part)


def _signs(path, part):
    if part[0] == "minus":
        yield "sign", f"the minus of {text_of(part)} is one too many", part[1]
    if part[0] in ("+", "-"):
        term, other = text_of(part[2]), OTHER[part[0]]
        yield "sign", f"{part[0]}{term} should be {other}{term}", (other, *part[1:])
    if part[0] == "area" or part[0].isupper() or not path:
        yield "sign", f"a minus is lost: {text_of(part)} should be negative", ("minus", part)


def as_around(graph, place):
    """The formula of a cell if it went on as those around it do, of the same form; None if they do not say."""
    (sheet, row, column), form, found = place, graph.form(place), []
    near = [(sheet, row + r, column + c) for r in range(-3, 4) for c in range(-3, 4) if r or c]
    near = [p for p in near if graph.component.get(p) is graph.component[place] and graph.form(p) == form]
    around = {p: areas(graph.trees[p]) for p in near}
    for k in range(len(areas(graph.trees[place]))):
        votes = Counter()
        for down, right in ((1, 0), (0, 1)):
            pairs = [(p, (p[0], p[1] + down, p[2] + right)) for p in around]
            steps = Counter(_step(around[p][k], around[q][k]) for p, q in pairs if q in around)
            for step, _ in steps.most_common(1):
                for sign in (1, -1):
                    beside = around.get((sheet, row - sign * down, column - sign * right))
                    votes[beside and beside[k].moved(sign * step[0], sign * step[1])] += beside is not None
        best = votes.most_common(1)
        if not best or best[0][0] is None:
            return None
        found.append(best[0][0])
    return with_areas(graph.trees[place], found) if found else None


def _step(a, b):
    return b.top - a.top, b.left - a.left


def _terms(tree):
    """A term more: those that continue the pattern of the terms that are there."""
    terms = list(flat(tree))
    for n, (_, first) in enumerate(terms):
        for _, second in terms[n + 1 :]:
            a, b = areas(first), areas(second)
            for factor in (2, -1, 0.5) if a and len(a) == len(b) else ():
                steps = [np.multiply(_step(x, y), factor) for x, y in zip(a, b, strict=True)]
                if any((step % 1).any() for step in steps):
                    continue
                moved = [x.moved(*map(int, step)) for x, step in zip(a, steps, strict=True)]
                for sign in "+-" if all(moved) else "":
                    term = with_areas(first, moved)
                    yield "missing term", f"the term {sign}{text_of(term)} is missing", (sign, tree, term)


def flat(tree, sign=1):
    """The terms of a sum as (sign, tree)."""
    if tree[0] in ("+", "-"):
        yield from flat(tree[1], sign)
        yield from flat(tree[2], sign if tree[0] == "+" else -sign)
    elif tree[0] == "minus":
        yield from flat(tree[1], -sign)
    else:
        yield sign, tree
