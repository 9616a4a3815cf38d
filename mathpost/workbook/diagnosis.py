"""Why the first wrong step of a worksheet is wrong: its kind in a word, and a sentence.

Each kind of step has its own list of what may have gone wrong, the simplest first: what the whole range would then
hold is computed from the cells before it and compared. If no slip gives the range, a single entry is looked at.
"""

import numpy as np

from mathpost.detective.misreadings import PI_WRITTEN, UNITS, elementary, written_decimals
from mathpost.workbook.label import Role
from mathpost.workbook.products import of_outcome, of_product, terms_of
from mathpost.workbook.slips import CLOSE, UNIT_PHRASES, first_match, holds, name_of, roundings, turns
from mathpost.workbook.steps import AXES


def diagnose(task, role, status):
    """Return the kinds of the error in the step `role`, the simplest first, and the sentence that says why.

    Parameters
    ----------
    task : mathpost.workbook.steps.Task
    role : mathpost.workbook.label.Role
    status : dict
        `Role` → array of ``"right"``, ``"wrong"`` and ``"consequence"``.

    Returns
    -------
    kinds : tuple of str
    why : str
    """
    wrong = status[role] == "wrong"
    place = tuple(np.argwhere(wrong)[0])
    found = task.found[role]
    cell = found.sheet.cells.get(found.places[place])
    if cell is None or cell.value is None:
        return ("empty",), f"nothing stands in the first wrong cell of {role}"
    if cell.error:
        return ("error",), f"{role} holds the error value {cell.value}"
    if cell.number is None:
        return ("text",), f"{role} holds the text {str(cell.value)!r} where a number belongs"
    steps = {
        "outcome": of_outcome,
        "coordinate": _given,
        "angle": _given,
        "negated": _angle,
        "radians": _angle,
        "cos": _function,
        "sin": _function,
    }
    look = steps.get(role.kind) or (_elementary if len(role.word) == 1 else of_product)
    return look(task, role, status) or _entry(task, role, place)


def _given(task, role, status):
    """An angle or a coordinate that is not the task's."""
    given = task.written * task.angles if role.kind == "angle" else task.point
    n = role.word[0]
    candidates = [(("sign",), f"the sign of {role} is reversed", -given[n])]
    for m in range(3):
        other = Role(role.kind, (m,))
        if m != n:
            both = other in task.values and holds(task, other, given[n])
            kind, verb = ("exchange", "are exchanged") if both else ("reference", "stands in its place")
            text = f"{role} and {other} {verb}" if both else f"{other} {verb}: {role} was asked"
            candidates.append(((kind,), text, given[m]))
    candidates += roundings(role, given[n])
    why = f"{role} is not the one that was asked"
    return first_match(task, role, candidates) or (("input",), why)


def _angle(task, role, status):
    """A negated angle, or an angle in radians."""
    n, signed = role.word[0], task.sign * task.angles[role.word[0]]
    to_cell = (lambda angle: angle) if role.kind == "negated" else np.deg2rad
    name = name_of(n)
    flipped = f"{name} is not negated" if task.sign < 0 else f"{name} is negated"
    candidates = [(("sign", "active"), flipped, -to_cell(signed))]
    for m in range(3):
        if m != n:
            other, text = to_cell(task.sign * task.angles[m]), f"{name_of(m)} stands where {name} belongs"
            candidates.append((("reference", "exchange"), text, other))
            candidates.append((("reference", "exchange", "sign"), f"{text}, with the wrong sign", -other))
    if role.kind == "radians":
        for unit, phrase in UNIT_PHRASES.items():
            candidates.append((("unit",), phrase.format(name), UNITS[unit](signed, np.pi)))
        candidates += [(("rounded",), f"π is taken as {pi:.6g}", UNITS["degrees"](signed, pi)) for pi in PI_WRITTEN]
    candidates.append((("left out",), f"{name} is left out", 0.0))
    return first_match(task, role, [*candidates, *roundings(role, task.expected(role))])


def _function(task, role, status):
    """A cosine or a sine."""
    n = role.word[0]
    parts = {"cos": (0, 0), "sin": (0, 1)}
    own, other = parts[role.kind], parts["sin" if role.kind == "cos" else "cos"]
    expected = elementary("Z", np.deg2rad(task.sign * task.angles[n]))
    turned = [(k, w, elementary("Z", angle)) for k, w, axis, angle in turns(task, n) if axis == AXES[n]]
    candidates = [(k, w, matrix[own]) for k, w, matrix in turned]
    swapped = f"sine and cosine of {name_of(n)} are exchanged"
    candidates[1:1] = [
        (("sine and cosine",), swapped, expected[other]),
        (("sine and cosine",), f"{swapped}, with a sign", -expected[other]),
        (("sign",), f"{role} has the opposite sign", -expected[own]),
    ]
    return first_match(task, role, [*candidates, *roundings(role, task.expected(role))])


def _elementary(task, role, status):
    """An elementary matrix: another angle, sign, unit or axis; an active one tells itself by its fellows."""
    n = role.word[0]
    others = [other for m in range(3) if m != n and (other := Role("matrix", (m,))) in task.values]
    all_active = len(others) == 2 and all(holds(task, other, task.expected(other).T) for other in others)
    own_angle = task.sign * np.deg2rad(task.angles[n])
    exchanged = any(holds(task, other, elementary(AXES[other.word[0]], own_angle)) for other in others)
    candidates = []
    for kinds, why, axis, angle in turns(task, n):
        if kinds[0] == "active" and all_active and task.sign < 0:
            kinds, why = ("sign", "active"), "the angles are not negated, or the elementary matrices are active"
        elif kinds[0] == "active" and all_active:
            kinds, why = ("active", "sign"), "the elementary matrices are active where passive ones belong"
        elif kinds[0] == "active":
            kinds, why = ("active", "sign", "transpose"), f"{role} is the active one, transposed, or {why}"
        elif kinds[0] == "reference" and exchanged:
            kinds, why = ("exchange", "reference"), f"two angles are exchanged: {why}"
        candidates.append((kinds, why, elementary(axis, angle)))
    candidates += roundings(role, task.expected(role))
    swapped = f"sine and cosine of {name_of(n)} are exchanged"
    candidates += [(("sine and cosine",), swapped, m) for m in (_exchanged(task, n), _exchanged(task, n).T)]
    return first_match(task, role, candidates)


def _exchanged(task, n):
    """The elementary matrix with sine and cosine of its angle exchanged, which is that of 90° minus the angle."""
    return elementary(AXES[n], np.pi / 2 - np.deg2rad(task.sign * task.angles[n]))


def _entry(task, role, place):
    """A single entry: a sign, sine for cosine, a term of the sum, another entry, digits, or just a number."""
    value, expected = float(task.values[role][place]), task.expected(role)
    slack = 2 * float(task.slack[role][place])
    where = f"row {place[0] + 1}, column {place[1] + 1} of {role}" if place else str(role)

    def near(other):
        return abs(value - other) <= CLOSE * max(1, abs(other)) + slack

    candidates = [(("sign",), f"the sign of {where} is reversed", -expected[place])]
    if role.kind == "matrix" and len(role.word) == 1:
        candidates += _entries_of_elements(task, role.word[0], place, where)
    terms = terms_of(task, role, place)
    for n, term in enumerate(terms, 1):
        if abs(term) > CLOSE:
            candidates.append(
                (("term", "left out"), f"in the sum of {where}, term {n} is missing", terms.sum() - term)
            )
            sign = f"in the sum of {where}, term {n} has the wrong sign"
            candidates.append((("term", "sign"), sign, terms.sum() - 2 * term))
    for index in np.ndindex(expected.shape) if place else ():
        if index != place and abs(expected[index]) > CLOSE:
            text = f"{where} holds what belongs into row {index[0] + 1}, column {index[1] + 1}"
            candidates.append((("entry", "reference"), text, expected[index]))
    for n in range(3) if role.kind == "outcome" else ():
        other = Role("outcome", (n,))
        candidates.append((("entry", "reference"), f"{role} holds what {other} should be", task.expected(other)))
    for kinds, why, other in candidates:
        if near(float(other)):
            return kinds, why
    decimals = written_decimals(value)
    if decimals < 9 and abs(value - expected[place]) <= 10.0**-decimals:
        return ("rounded",), f"{where} is rounded to {decimals} decimal{'s' * (decimals != 1)}"
    found = task.found[role]
    if found.sheet.cells[found.places[place]].formula:
        return ("formula",), f"the formula in {where} calculates something else"
    return ("number",), f"{where} is a number typed by hand, and not the right one"


def _entries_of_elements(task, n, place, where):
    """What may stand in one entry of an elementary matrix in place of a cosine or a sine."""
    if abs(task.expected(Role("matrix", (n,)))[place]) < 1:
        for kinds, why, axis, angle in turns(task, n):
            if kinds[0] in ("unit", "reference", "rounded"):
                yield kinds, f"in {where}, {why}", elementary(axis, angle)[place]
    for number in elementary("Z", np.deg2rad(task.sign * task.angles[n]))[0, :2]:
        if abs(number) > CLOSE:
            text = f"{where} holds the wrong one of sine, cosine, 0 and 1, or a wrong sign"
            yield ("sine and cosine", "entry"), text, number
            yield ("sine and cosine", "entry"), text, -number
