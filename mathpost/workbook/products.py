"""Why a product, a transpose or the result in a worksheet is wrong: factors, their order, a row for a column."""

from itertools import permutations, product

import numpy as np

from mathpost.detective.euler_angles import explain
from mathpost.detective.misreadings import UNROUNDED
from mathpost.workbook.label import Role
from mathpost.workbook.slips import CLOSE, first_match, name_of, roundings

NOT_AN_ARRAY = "MMULT was not entered as an array formula"


def matrices_of(task):
    """The matrices of the worksheet by name, as they stand there or as they should."""
    found = {
        role: values for role, values in task.values.items() if values.shape == (3, 3) and np.isfinite(values).all()
    }
    for word in ((0,), (1,), (2,)):
        found.setdefault(Role("matrix", word), task.product(word))
    return found


def of_product(task, role, status):
    """A product or a transpose."""
    matrices, word = matrices_of(task), role.word
    before = list(status)[: list(status).index(role)]
    earlier = {r: m for r, m in matrices.items() if r in before}
    sound = next((local.value for local in task.locals(role)), task.expected(role))
    candidates = []
    if role.kind == "transposed" or (not word and task.recipe == "left"):
        candidates.append((("transpose",), "the final transpose is missing", sound.T))
    for parts in _two_factors(word):
        candidates += _of_factors(*(matrices.get(Role("matrix", part)) for part in parts), *map(_name, parts))
    for order in permutations(word):
        if order != word and len(word) == 3:
            text = f"the product is taken in the order {_dots(order)}, not {_dots(word)}"
            candidates.append((("order",), text, _own_product(matrices, order)))
    if role.kind == "matrix":
        candidates.append((("transpose", "order"), f"{role} is transposed", sound.T))
    candidates.append((("sign",), f"{role} has the opposite sign", -sound))
    candidates.append((("not an array",), f"{role}: {NOT_AN_ARRAY}", np.full((3, 3), sound[0, 0])))
    kinds = ("transpose", "reference") if role.kind == "transposed" else ("reference", "left out")
    for other, matrix in earlier.items():
        candidates.append((kinds, f"{other} stands in the place of {role}", matrix))
        candidates.append((kinds, f"{other}, transposed, stands in the place of {role}", matrix.T))
    for (a, left), (b, right) in product(earlier.items(), repeat=2):
        text = f"the product is {_short(a)}·{_short(b)}, not {_dots(word) or role}"
        candidates.append((("reference", "order"), text, left @ right))
    return first_match(task, role, [*candidates, *roundings(role, sound)])


def _of_factors(left, right, a, b):
    """What may become of the product of two matrices called `a` and `b`; nothing if either is not known."""
    if left is None or right is None:
        return
    yield ("order",), f"the product is taken in the order {b}·{a}, not {a}·{b}", right @ left
    yield ("elementwise",), f"{a} and {b} are multiplied cell by cell, not row by column", left * right
    yield ("left out",), f"{b} is left out of the product", left
    yield ("left out",), f"{a} is left out of the product", right
    yield ("transpose", "order"), f"{a}·{b} is transposed", (left @ right).T
    yield (
        ("transpose", "row by row"),
        f"{a} and {b} are multiplied row by row, as if {b} were transposed",
        left @ right.T,
    )
    yield ("transpose",), f"{a} is transposed in the product {a}·{b}", left.T @ right
    for reversed_product in (right.T @ left, right @ left.T):
        text = f"the product is taken in the order {b}·{a}, not {a}·{b}, and one of them is transposed"
        yield ("transpose", "order"), text, reversed_product
    yield ("operation",), f"{a} and {b} are added, not multiplied", left + right


def _two_factors(word):
    return [(word[:cut], word[cut:]) for cut in range(len(word) - 1, 0, -1)]


def _dots(word):
    return "·".join(map(name_of, word))


def _short(role):
    return str(role).removeprefix("matrix ")


def _name(word):
    return "".join(map(name_of, word))


def _own_product(matrices, word):
    """The product of the worksheet's own elementary matrices in the order `word`."""
    return np.linalg.multi_dot([matrices[Role("matrix", (n,))] for n in word])


def of_outcome(task, role, status):
    """The result: another matrix, a row in place of a column, coordinates or signs mixed up."""
    roles = [Role("outcome", (n,)) for n in range(3)]
    if not task.values.keys() >= set(roles):
        return None
    values = np.array([task.values[r] for r in roles])
    sound = np.array([next((x.value for x in task.locals(r)), task.expected(r)) for r in roles], dtype=float)
    known = first_match(task, roles, [*_of_result(task, sound), *roundings(Role("result"), sound)])
    only_one_is_off = (np.abs(values - sound) <= CLOSE * np.maximum(1, np.abs(sound))).sum() == 2
    if known or only_one_is_off or not np.isfinite(values).all() or not task.point.any():
        return known
    found = explain(task.angles.tolist(), task.point.tolist(), values.tolist()).misreadings
    found = [each for each in found if set(each.kinds) - {UNROUNDED}]
    return (found[0].kinds, found[0].sentence) if found else None


def _of_result(task, sound):
    """What may become of the result `sound`."""
    point = np.array([task.values.get(Role("coordinate", (n,)), task.point[n]) for n in range(3)], dtype=float)
    final, matrices = _final(task), matrices_of(task)
    if task.recipe == "left":
        text = "the final transpose is missing, or the point is multiplied as a row"
        yield ("transpose", "row"), text, final.T @ point
    else:
        yield ("row", "transpose"), "the point is multiplied as a row from the left", final.T @ point
    for order, text in (([1, 0, 2], "x and y"), ([2, 1, 0], "x and z"), ([0, 2, 1], "y and z")):
        yield ("copied", "exchange"), f"{text} of the result are exchanged", sound[order]
        yield ("exchange", "point"), f"{text} of the point are exchanged", final @ point[order]
    for name, signs in zip("xyz", 1 - 2 * np.eye(3), strict=True):
        yield ("sign", "copied"), f"the sign of {name}' is reversed", sound * signs
        yield ("sign", "point"), f"the sign of {name} is reversed", final @ (point * signs)
    yield ("sign", "copied"), "the whole result has the opposite sign", -sound
    yield ("left out",), "the result is the point itself, not turned", point
    for role, matrix in matrices.items():
        yield ("reference",), f"the point is multiplied by {role}, not by the final matrix", matrix @ point
        text = f"the point is multiplied as a row by {role}, not by the final matrix"
        yield ("reference", "row"), text, matrix.T @ point
    yield ("not an array",), NOT_AN_ARRAY, np.full(3, sound[0])
    for word in permutations(range(3)):
        text, matrix = f"the product is taken in the order {_dots(word)}", _own_product(matrices, word)
        yield ("order",), text, matrix @ point
        yield ("order", "transpose"), f"{text} and transposed", matrix.T @ point


def _final(task):
    """The final matrix as the worksheet's own cells give it."""
    return next((local.value for local in task.finals(Role("outcome"))), task.final)


def terms_of(task, role, place):
    """The three terms whose sum an entry of a product or of the result is, from the worksheet's own cells."""
    matrices = matrices_of(task)
    if role.kind == "outcome":
        return _final(task)[role.word[0]] * task.point
    if role.kind == "matrix" and len(role.word) > 1:
        for left, right in _two_factors(role.word):
            a, b = matrices.get(Role("matrix", left)), matrices.get(Role("matrix", right))
            if a is not None and b is not None:
                return a[place[0]] * b[:, place[1]]
    return np.array([])
