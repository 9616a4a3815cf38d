"""Single repairs of a formula: what somebody may have meant, the likeliest first."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import replace
from functools import reduce
from itertools import combinations, permutations, product
from typing import TYPE_CHECKING, Any

from mathpost.rotation import wrap
from mathpost.teaching.workbook.sheet.formula import Area, area_of
from mathpost.teaching.workbook.sheet.neighbours import as_around, filled
from mathpost.teaching.workbook.sheet.place import beside
from mathpost.teaching.workbook.sheet.samples import at, same
from mathpost.teaching.workbook.sheet.tree import (
    ROUNDING,
    areas,
    exact,
    form_of,
    heads,
    parts_of,
    put,
    text_of,
    walk,
    with_areas,
)

if TYPE_CHECKING:
    from mathpost.teaching.workbook.sheet.formula import Tree
    from mathpost.teaching.workbook.sheet.graph import Graph
    from mathpost.teaching.workbook.sheet.place import Line, Place
    from mathpost.teaching.workbook.sheet.samples import Values

Steps = tuple[int, ...]  # from a tree to a part of it
Reference = tuple[Steps, Area]

TRIGONOMETRY = {"SIN": "COS", "COS": "SIN"}
INVERSE = {"ASIN", "ACOS", "ATAN", "ATAN2"}
MOST_ROWS = 9  # from which a formula was filled
ROUGHLY = 0.01  # as 3.14 and 57.3 are
UNITS = {180.0: 200.0, 200.0: 180.0, 100.0: 60.0, 60.0: 3600.0, 3600.0: 60.0}  # degrees and gon, minutes, seconds
OTHER = {"+": "-", "-": "+", "*": "/", "/": "*"}
TO_RADIANS, TO_DEGREES = ("degrees for radians", "RADIANS"), ("radians for degrees", "DEGREES")


def repaired(
    graph: Graph,
    wanted: Values,
    values: Values,
    inputs: Collection[Place] = (),
    windows: Iterable[Line] = (),
    period: float | None = None,
) -> tuple[str, str, Tree] | None:
    """Return (cause, sentence, tree) of the single repair of a formula that gives, with `values`, those `wanted`.

    The wanted values are of a cell, or of several cells of one array formula. `inputs` and matrices, `windows`, may
    be meant wherever they are. Values that differ by `period` count as equal.
    """
    place = next(iter(wanted))
    after, held = graph.downstream(wanted), graph.parts_at(graph.trees[place], values)
    for cause, old, new, tree in edits(graph, place, dict.fromkeys(inputs), windows):
        made = graph.calculate(tree, values, held=held)
        off = ((at(made, graph.part.get(p, (0, 0))) - value, value) for p, value in wanted.items())
        fits = all(same(value + (wrap(each, period) if period else each), value) for each, value in off)
        if fits and (cause != "wrong reference" or after.isdisjoint(graph.used_by(tree))):  # in no circle
            return cause, said(place, old, new), tree
    return None


def said(place: Place, old: Tree, new: Tree) -> str:
    """A repair of a part of the formula in `place`, in words."""
    return f"{text_of(old, place[0])} should be {text_of(new, place[0])}"


def edits(
    graph: Graph, place: Place, inputs: Collection[Place] = (), windows: Iterable[Line] = ()
) -> Iterator[tuple[str, Tree, Tree, Tree]]:
    """Yield (cause, part, what it may have to be, whole tree) for every single repair of the formula in `place`."""
    tree, there = graph.trees[place], graph.component.keys()
    parts = dict(walk(tree))
    if sum(part[0] in TRIGONOMETRY for part in parts.values()) > 1:
        for cause, function in (TO_RADIANS, TO_DEGREES):
            new = converted(tree, function)
            yield cause, tree, new, new
    for kind in (_functions, _reversed, _signs):
        for path, part in parts.items():
            for cause, new in kind(part, path):
                yield cause, part, new, put(tree, path, new)
    for path, part in parts.items():
        if part[0] in ("*", "/"):
            new = (OTHER[part[0]], *part[1:])
            yield "wrong value", part, new, put(tree, path, new)
    references = [(path, part[1]) for path, part in parts.items() if part[0] == "area"]
    count = Counter(area for _, area in references)
    for path, area in references:
        if area.shape != (1, 1):
            new = ("TRANSPOSE", parts[path])
            yield "transposed", parts[path], new, put(tree, path, new)
    for a, b in combinations(dict.fromkeys(area for _, area in references if area.shape == (1, 1)), 2):
        new = with_areas(tree, [b if area == a else a if area == b else area for _, area in references])
        pair = [heads(graph.tree(area.places[0])) & TRIGONOMETRY.keys() for area in (a, b)]
        yield "sin and cos exchanged" if {"SIN"} in pair and {"COS"} in pair else "wrong reference", tree, new, new
    for path, area, other in _elsewhere(graph, place, references, inputs, windows):
        if other and _is_block(graph, area) and not (_is_block(graph, other) or tuple(other.places) in windows):
            continue  # what covers a block was not misplaced
        if other and other != area and place not in other.places and not there.isdisjoint(other.places):
            yield "wrong reference", parts[path], ("area", other), put(tree, path, ("area", other))
            if count[area] > 1:  # all that refer there
                new = with_areas(tree, [other if own == area else own for _, own in references])
                yield "wrong reference", parts[path], ("area", other), new
    for n, (down, right) in product(range(1, MOST_ROWS), ((-1, 0), (0, -1))):  # all that lost their $
        ends = [{area.top, area.bottom} if down else {area.left, area.right} for _, area in references]
        moved: list[Any] = [
            area if end == {place[1] if down else place[2]} else area.moved(n * down, n * right)
            for end, (_, area) in zip(ends, references, strict=True)
        ]
        if all(moved) and sum(new != area for new, (_, area) in zip(moved, references, strict=True)) > 1:
            yield "wrong reference", tree, with_areas(tree, moved), with_areas(tree, moved)
    for longer in zip(*(_longer(area) for _, area in references if area.shape != (1, 1)), strict=True):
        if len(longer) > 1 and all(longer):
            each = iter(longer)
            new = with_areas(tree, [area if area.shape == (1, 1) else next(each) for _, area in references])
            yield "wrong reference", tree, new, new
    for path, part in parts.items():
        for new in _exact(part):
            yield "rounded early", part, new, put(tree, path, new)
        if part[0] == "number" and part[1] in UNITS:
            new = "number", UNITS[part[1]]
            yield "wrong value", part, new, put(tree, path, new)
        for cause, new in _sums(part):
            yield cause, part, new, put(tree, path, new)
    if (new := exact(tree, ROUGHLY)) != tree:
        yield "rounded early", tree, new, new
    for (down, right), n in product(((0, 1), (1, 0)), (0, 1, 2)) if tree[0] == "area" else ():
        first, last = (tree[1].moved(k * down, k * right) for k in (-n, 2 - n))
        row = first and last and replace(first, bottom=last.bottom, right=last.right)
        if row and len(row.places) == 3 and there >= {*row.places}:  # a vector not divided by its length
            new = ("/", tree, ("SQRT", ("SUMSQ", ("area", row))))
            yield "wrong value", tree, new, new
    unlike = []
    for near in beside(place):  # filled from there
        continued = filled(graph, near, place)
        more = len(areas(continued)) - len(references) if continued else -1
        if continued and references and more >= 0:
            if graph.form(near) == graph.form(place) or more:
                yield "missing term" if more else "wrong reference", tree, continued, continued
            else:
                unlike.append(continued)
    for factor in ("*", "/") if "*" not in heads(tree) or heads(tree).isdisjoint({"+", "-"}) else ():
        new = (factor, tree, ("number", 2.0))
        yield "half angle", tree, new, new
    for path, part in parts.items():
        if part[0] in TRIGONOMETRY:
            new = (part[0], ("/", part[1], ("number", 2.0)))
            yield "half angle", part, new, put(tree, path, new)
        if part[0] == "COS":
            new = ("-", ("number", 1.0), part)
            yield "missing term", part, new, put(tree, path, new)
    for new in unlike:
        yield "missing term" if new[0] in ("+", "-") and new[1] == tree else "wrong value", tree, new, new
    meant = [("area", Area(*p, *p[1:])) for p in inputs]
    own = [path for path, area in references if area.shape == (1, 1) and area.places[0] in inputs]
    for (path, second), (a, b) in product(combinations(own, 2), product(meant, repeat=2)):
        new = put(put(tree, path, a), second, b)
        yield "wrong reference", tree, new, new


def _elsewhere(
    graph: Graph, place: Place, references: Sequence[Reference], inputs: Collection[Place], windows: Iterable[Line]
) -> Iterator[tuple[Steps, Area, Area | None]]:
    """Yield (path, area, other area): as the cells around have it, nearby, an input or a matrix, further up."""
    around = areas(as_around(graph, place) or ("text",))
    yield from ((*reference, new) for reference, new in zip(references, around, strict=False))
    for reach in (1, 2, 3, 4):
        span = range(-reach, reach + 1)
        steps = [(down, right) for down in span for right in span if reach in (abs(down), abs(right))]
        steps.sort(key=lambda step: sum(map(abs, step)))
        yield from ((path, area, area.moved(*step)) for (path, area), step in product(references, steps))
    for path, area in references:
        yield from ((path, area, other) for other in _longer(area))
    for path, area in references:
        meant = [area_of(places) for places in (*((p,) for p in inputs), *windows)]
        yield from ((path, area, other) for other in meant if other.shape == area.shape)
        far = range(5, 60 if not area.fixed[0] else 5)
        yield from ((path, area, area.moved(sign * rows, 0)) for sign in (-1, 1) for rows in far)


def _is_block(graph: Graph, area: Area) -> bool:
    """Whether a range of rows and columns covers just what hangs together on the sheet."""
    whole = graph.component.get(area.places[0], ())
    return min(area.shape) > 1 and len(whole) == len(area.places) and {*whole} == {*area.places}


def _longer(area: Area) -> Iterator[Area | None]:
    """A range with a row or a column more, or less, at each side; None where there is none."""
    for side, step in product(("top", "left", "bottom", "right"), (1, -1)) if area.shape != (1, 1) else ():
        other = replace(area, **{side: getattr(area, side) + step})
        yield other if min(*other.shape, other.top, other.left) > 0 else None


def converted(tree: Tree, function: str) -> Tree:
    """The tree with the argument of every sine and cosine in `function`."""
    parts = tuple(converted(part, function) if isinstance(part, tuple) else part for part in tree)
    return (parts[0], (function, parts[1])) if tree[0] in TRIGONOMETRY else parts


def _functions(part: Tree, path: Steps) -> Iterator[tuple[str, Tree]]:
    """Units, and one function for another."""
    name, *inner = part
    for (cause, function), back in ((TO_RADIANS, "DEGREES"), (TO_DEGREES, "RADIANS")):
        if name in TRIGONOMETRY:
            yield cause, (name, (function, *inner))
        if name == back:
            yield cause, inner[0]
        if (name in INVERSE and function == "DEGREES") or (name == "area" and not path):
            yield cause, (function, part)
    if name in TRIGONOMETRY:
        yield "sin and cos exchanged", (TRIGONOMETRY[name], *inner)
    if name == "ATAN2":
        yield "atan2 order", (name, *inner[::-1])
    if name == "ATAN" and inner[0][0] == "/":
        _, y, x = inner[0]
        yield "atan for atan2", ("ATAN2", x, y)
        yield "atan for atan2", ("ATAN2", ("minus", x), ("minus", y))
    if name in ("TRANSPOSE", "MINVERSE"):
        yield "transposed", inner[0]
    if name == "MMULT":
        a, b = inner
        factors = _factors(part)
        for order in permutations(factors) if len(factors) < 5 else [factors[::-1]]:
            yield "order of product", reduce(lambda left, right: (name, left, right), order)
        yield from (("transposed", (name, *factors)) for factors in ((("TRANSPOSE", a), b), (a, ("TRANSPOSE", b))))
    if (
        name == "SUMSQ"
        or (name == "+" and _is_square(inner[1]))
        or (not path and name in ("+", "SUM", "SUMPRODUCT"))
    ):
        yield "wrong value", ("SQRT", part)
    if not path and name in ("MMULT", "TRANSPOSE"):
        yield "transposed", ("TRANSPOSE", part)


def _sums(part: Tree) -> Iterator[tuple[str, Tree]]:
    """Yield a sum with a parenthesis, a square or a last term that was forgotten."""
    if part[0] not in ("+", "-"):
        return
    head, before, last = part
    yield "offset" if last[0] == "number" else "wrong value", before  # a term too many
    yield "wrong value", last
    if before[0] in ("+", "-") and before[2][0] == "*":  # a·(b − c) for a·b − c
        yield "wrong value", (*before[:2], ("*", before[2][1], (head, before[2][2], last)))
    elif before[0] == "*":
        yield "wrong value", ("*", before[1], (head, before[2], last))
    if last[0] == "area" and (_is_square(before) or (before[0] == "+" and _is_square(before[2]))):
        yield "wrong value", (head, before, ("^", last, ("number", 2.0)))
    one = before[2] if before[0] == head else before
    if _is_square(last) and form_of(one) == form_of(last):
        steps = [a.steps_to(b) for a, b in zip(areas(one), areas(last), strict=True)]
        more = [area.moved(*step) for area, step in zip(areas(last), steps, strict=True)]
        there = [area for area in more if area]
        if len(there) == len(more):
            yield "missing term", (head, part, with_areas(last, there))


def _is_square(tree: Tree) -> bool:
    return (tree[0] == "^" and tree[2] == ("number", 2.0)) or (tree[0] == "*" and tree[1] == tree[2])


def _factors(tree: Tree) -> list[Tree]:
    """The factors of a product of matrices, from left to right."""
    return [*_factors(tree[1]), *_factors(tree[2])] if tree[0] == "MMULT" else [tree]


def _reversed(part: Tree, path: Steps) -> Iterator[tuple[str, Tree]]:
    if part[0] in ("-", "/") and part[1][0] not in ("+", "-"):
        yield "sign" if part[0] == "-" else "wrong value", (part[0], part[2], part[1])


def _signs(part: Tree, path: Steps) -> Iterator[tuple[str, Tree]]:
    if part[0] == "minus":
        yield "sign", part[1]
    if part[0] in ("+", "-"):
        yield "sign", (OTHER[part[0]], *part[1:])
    is_long = sum(each[0] in ("+", "-") for each in parts_of(part)) > 2  # of which nobody turns the whole
    if part[0] == "area" or part[0].isupper() or not (path or is_long):
        yield "sign", ("minus", part)


def _exact(part: Tree) -> Iterator[Tree]:
    """The part of a formula without its rounding."""
    if part[0] in ROUNDING:
        yield part[1]
    if part[0] == "number" and (new := exact(part, ROUGHLY)) != part:
        yield new
