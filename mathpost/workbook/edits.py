"""Single repairs of a formula: what somebody may have meant, as (cause, sentence, tree), the likeliest first."""

from mathpost.workbook.formula import POWER, Area, areas, put, text_of, walk
from mathpost.workbook.graph import at, same

TRIGONOMETRY = {"SIN": "COS", "COS": "SIN"}
INVERSE = {"ASIN", "ACOS", "ATAN", "ATAN2"}


def repaired(graph, place, wanted, values, kinds=None, inputs=()):
    """Find the single repair of the formula in `place` that gives the value `wanted` at every sample.

    Parameters
    ----------
    graph : mathpost.workbook.graph.Graph
    place : tuple
        Of a formula; for an array formula, `wanted` and the comparison are of this one cell.
    wanted : ndarray, shape (samples,), or dict of place → ndarray
        The latter for several cells of one array formula.
    values : dict
        Place → value, of what the formula uses.
    inputs : sequence of places, optional
        Inputs that the formula may have meant, wherever they stand.
    kinds : callable, optional
        ``kinds(place)`` is ``"angle"``, ``"point"`` or None, to name a wrong reference.

    Returns
    -------
    (cause, sentence) or None
    """
    tree = graph.trees.get(place)
    if tree is None:
        return None
    wanted = wanted if isinstance(wanted, dict) else {place: wanted}
    after = graph.downstream(wanted)
    for cause, sentence, other in edits(graph, place, tree, inputs):
        if cause == "wrong reference" and not after.isdisjoint(graph.used_by(other)):
            continue
        if _gives(graph, other, wanted, values):
            if cause == "wrong reference" and kinds:
                cause = kinds(place, tree, other) or cause
            return cause, sentence or f"={text_of(tree)} should be ={text_of(other)}"
    return None


def _gives(graph, tree, wanted, values):
    result = graph.calculate(tree, values)
    return all(same(at(result, graph.part.get(place, (0, 0))), value, 1e-8) for place, value in wanted.items())


def edits(graph, place, tree, inputs=()):
    """Yield (cause, sentence, tree) for every single repair."""
    parts = list(walk(tree))
    yield from _all_units(tree)
    for path, part in parts:
        yield from _units(tree, path, part)
        yield from _functions(tree, path, part)
    yield from _signs(tree, parts)
    yield from _references(graph, place, tree, parts)
    for path, part in parts:
        for sheet, row, column in inputs if part[0] == "area" and part[1].shape == (1, 1) else ():
            area = Area(sheet, row, column, row, column)
            yield "wrong reference", f"{part[1]} should be {area}", put(tree, path, ("area", area))
    for path, part in parts:
        if part[0] == "call" and part[1] in ("ROUND", "ROUNDDOWN", "ROUNDUP", "TRUNC", "INT"):
            yield "rounded early", f"{text_of(part)} is rounded too early", put(tree, path, part[2][0])
        if part[0] == "number":
            for near in (3.141592653589793, 57.29577951308232, 0.017453292519943295):
                if part[1] != near and abs(part[1] - near) < 0.01 * near:
                    yield "rounded early", f"{part[1]:g} is rounded too early", put(tree, path, ("number", near))
    if tree[0] in ("+", "-") and tree[2][0] == "number":
        yield "offset", f"{tree[0]}{text_of(tree[2])} is added to it", tree[1]
    yield from _terms(tree)
    for path, part in parts:
        if part[0] in "*/":
            other = {"*": "/", "/": "*"}[part[0]]
            yield "wrong value", f"{part[0]} should be {other}", put(tree, path, (other, *part[1:]))


def _all_units(tree):
    """Every sine and cosine of the formula at once."""
    calls = [(path, part) for path, part in walk(tree) if part[0] == "call" and part[1] in TRIGONOMETRY]
    if len(calls) > 1:
        for cause, function, text in (
            ("degrees for radians", "RADIANS", "the angles are in degrees, not in radians"),
            ("radians for degrees", "DEGREES", "the angles are in radians already, and converted once more"),
        ):
            other = tree
            for path, part in calls:
                other = put(other, path, ("call", part[1], (("call", function, part[2]),)))
            yield cause, text, other


def _units(tree, path, part):
    if part[0] == "call" and part[1] in (*TRIGONOMETRY, "TAN"):
        inner = part[2][0]
        wrapped = ("call", "RADIANS", (inner,))
        text = f"{part[1]} takes radians: {text_of(inner)} is in degrees"
        yield "degrees for radians", text, put(tree, path, ("call", part[1], (wrapped,)))
        wrapped = ("call", "DEGREES", (inner,))
        text = f"{text_of(inner)} is in radians already, and converted once more"
        yield "radians for degrees", text, put(tree, path, ("call", part[1], (wrapped,)))
    if part[0] == "call" and part[1] == "RADIANS":
        yield "radians for degrees", f"{text_of(part)} is converted once more", put(tree, path, part[2][0])
    if part[0] == "call" and part[1] in INVERSE:
        text = f"{text_of(part)} is in radians where degrees belong"
        yield "radians for degrees", text, put(tree, path, ("call", "DEGREES", (part,)))
    if part[0] == "call" and part[1] == "DEGREES":
        yield "degrees for radians", f"{text_of(part)} is converted once more", put(tree, path, part[2][0])
    if part[0] == "area" and not path:
        yield "degrees for radians", f"{text_of(part)} is in degrees", ("call", "RADIANS", (part,))
        yield "radians for degrees", f"{text_of(part)} is in radians", ("call", "DEGREES", (part,))


def _functions(tree, path, part):
    if part[0] != "call":
        return
    name, arguments = part[1], part[2]
    if name in TRIGONOMETRY:
        other = ("call", TRIGONOMETRY[name], arguments)
        yield "sin and cos exchanged", f"{name} should be {TRIGONOMETRY[name]}", put(tree, path, other)
    if name == "ATAN2":
        text = "ATAN2 takes x first, then y"
        yield "atan2 order", text, put(tree, path, ("call", name, arguments[::-1]))
    if name == "ATAN" and arguments[0][0] == "/":
        text = "ATAN loses the quadrant that ATAN2 keeps"
        y, x = arguments[0][1:]
        yield "atan for atan2", text, put(tree, path, ("call", "ATAN2", (x, y)))
        minus = ("call", "ATAN2", (("minus", x), ("minus", y)))
        yield "atan for atan2", text, put(tree, path, minus)
    if name == "TRANSPOSE":
        yield "transposed", f"{text_of(arguments[0])} must not be transposed", put(tree, path, arguments[0])
    if name == "MMULT":
        a, b = arguments
        text = f"the order is {text_of(b)} times {text_of(a)}"
        yield "order of product", text, put(tree, path, ("call", name, (b, a)))
        for n, argument in enumerate(arguments):
            if argument[:2] == ("call", "TRANSPOSE"):
                continue
            turned = list(arguments)
            turned[n] = ("call", "TRANSPOSE", (argument,))
            text = f"{text_of(argument)} must be transposed"
            yield "transposed", text, put(tree, path, ("call", name, tuple(turned)))
    if not path and name in ("MMULT", "TRANSPOSE"):
        yield "transposed", "the whole must be transposed", ("call", "TRANSPOSE", (tree,))


def _signs(tree, parts):
    for path, part in parts:
        if part[0] == "minus":
            yield "sign", f"the minus of {text_of(part)} is one too many", put(tree, path, part[1])
        if part[0] in "+-" and len(part) == 3:
            other = {"+": "-", "-": "+"}[part[0]]
            yield (
                "sign",
                f"{part[0]}{text_of(part[2])} should be {other}{text_of(part[2])}",
                put(tree, path, (other, *part[1:])),
            )
    for path, part in parts:
        if part[0] in ("area", "call") or not path:
            yield "sign", f"a minus is lost: {text_of(part)} should be negative", put(tree, path, ("minus", part))


def _references(graph, place, tree, parts):
    """Neighbours first, then a little further, then the formulas of the cells around, copied here."""
    for reach in (1, 2, 3, 4):
        for path, part in parts:
            if part[0] != "area":
                continue
            for rows in range(-reach, reach + 1):
                for columns in range(-reach, reach + 1):
                    if max(abs(rows), abs(columns)) == reach:
                        area = part[1].moved(rows, columns)
                        if area and place not in area.places:
                            text = f"{part[1]} should be {area}"
                            yield "wrong reference", text, put(tree, path, ("area", area))
    for path, part in parts:
        if part[0] == "area" and not part[1].fixed[0]:
            for up in range(5, min(place[1], 60)):
                area = part[1].moved(-up, 0)
                if area:
                    yield "wrong reference", f"{part[1]} should be {area}", put(tree, path, ("area", area))
    for path, part in parts:
        if part[0] == "area" and part[1].shape != (1, 1):
            yield "transposed", f"{part[1]} must be transposed", put(tree, path, ("call", "TRANSPOSE", (part,)))


def _terms(tree):
    """A term more: those that continue the pattern of the terms that are there."""
    terms = list(flat(tree))
    for n, first in enumerate(terms):
        for second in terms[n + 1 :]:
            a, b = areas(first[1]), areas(second[1])
            if not a or len(a) != len(b):
                continue
            for factor in (2, -1, 0.5):
                moved = [_between(x, y, factor) for x, y in zip(a, b, strict=True)]
                if all(moved):
                    term = _with_areas(first[1], moved)
                    yield "missing term", f"the term {text_of(term)} is missing", ("+", tree, term)
                    yield "missing term", f"the term -{text_of(term)} is missing", ("-", tree, term)


def _between(a, b, factor):
    rows, columns = (b.top - a.top) * factor, (b.left - a.left) * factor
    if rows != int(rows) or columns != int(columns):
        return None
    return a.moved(int(rows), int(columns))


def _with_areas(tree, new):
    new = iter(new)
    for path, part in list(walk(tree)):
        if part[0] == "area":
            tree = put(tree, path, ("area", next(new)))
    return tree


def replaced(tree, old, new):
    """Return the tree with a cell, given as area, replaced everywhere by the one at the place `new`."""
    for path, part in list(walk(tree)):
        if part == ("area", old):
            tree = put(tree, path, ("area", Area(new[0], new[1], new[2], new[1], new[2])))
    return tree


def flat(tree, sign=1):
    """The terms of a sum as (sign, tree)."""
    if tree[0] in ("+", "-") and tree[0] in POWER:
        yield from flat(tree[1], sign)
        yield from flat(tree[2], sign if tree[0] == "+" else -sign)
    elif tree[0] == "minus":
        yield from flat(tree[1], -sign)
    else:
        yield sign, tree
