"""The check of one workbook: every step recomputed, every cell judged, the first wrong one first.

A cell is *right* if it holds what the given angles and point demand, to the digits written; a *consequence* if it
follows rightly from cells before it that are wrong; otherwise it is *wrong*.
"""

from dataclasses import dataclass

import numpy as np

from mathpost.errors import InputError, as_array
from mathpost.workbook.diagnosis import diagnose
from mathpost.workbook.file import read
from mathpost.workbook.label import Role
from mathpost.workbook.layout import Found, describe, find, place_text
from mathpost.workbook.old_report import CONSEQUENCE, RIGHT, WRONG, Judgement, Report
from mathpost.workbook.steps import EXACT, Task

GIVEN = ("angle", "coordinate")


def check(path, *, cells=None, angles=None, point=None):
    """Check a worksheet that turns a point by ZXZ Euler angles.

    Parameters
    ----------
    path : str or path-like
        An .xlsx workbook: the template, a sheet with the labels of source 000, or any other with `cells`.
    cells : dict, optional, keyword only
        Where things stand if labels and names do not say it: ``{"angles": "B2:B4", "point": "C2:C4",
        "result": "H2:H4", "γβα": "D5:F7"}``, the sheet in front as in ``"Sheet1!B2:B4"``.
    angles, point : array_like, shape (3,), optional, keyword only
        The task, if the cells of the given numbers are to be judged as well.

    Returns
    -------
    Report

    Raises
    ------
    InputError
        If the workbook cannot be read, or the angles, the point or anything to check are not found in it.

    Examples
    --------
    >>> report = check("data/workbooks/missing_transpose.xlsx")
    >>> report.first.cell, report.kind
    ('ZXZ!J38', 'transpose')
    """
    book = read(path)
    found = find(book, cells)
    asked = [None if v is None else _three(v, name) for v, name in ((angles, "angles"), (point, "point"))]
    judged, first, notes = [], None, list(book.notes)
    for results in _calculations(book, found, *asked, notes):
        known = {each.cell for each in judged}  # both recipes share the given numbers
        judged += [each for each in results.judgements if each.cell not in known]
        first = first or results.first_error()
    if not judged:
        raise InputError(str(path), "matrices or a result beside the angles and the point", "none")
    kinds, why, question = first or ((), "", None)
    return Report(book.path, tuple(judged), kinds, why, tuple(dict.fromkeys(notes)), question)


def _three(values, where):
    array = as_array(values, 3, where)
    if array.shape != (3,):
        raise InputError(where, "shape (3,)", f"shape {array.shape}")
    return array


# From ranges to calculations.


def _calculations(book, found, angles, point, notes):
    """Judge each calculation in the book by the recipe that it follows; return a list of `_Results`."""
    by_sheet = {}
    for each in found:
        by_sheet.setdefault(each.sheet.name, []).append(each)
    given = {}
    for each in found:
        if each.role.kind in GIVEN:
            given.setdefault(each.role, each)
    results = []
    for ranges in by_sheet.values():
        for section in _sections(ranges, notes):
            for role, each in given.items():
                section.setdefault(role, each)
            if any(role.kind not in GIVEN for role in section):
                results.append(_best(book, section, angles, point))
    return results


def _sections(ranges, notes):
    """Divide the ranges of a sheet into calculations: the k-th range of a role belongs to the k-th calculation."""
    if any(each.section is not None for each in ranges):
        common = {each.role: each for each in ranges if each.section is None}
        numbers = sorted({each.section for each in ranges if each.section is not None})
        return [common | {e.role: e for e in ranges if e.section == number} for number in numbers]
    occurrences = {}
    for each in ranges:
        occurrences.setdefault(each.role, []).append(each)
    recipes = []
    for each in ranges:
        recipe = _recipe_of(each.role)
        if recipe and recipe not in recipes:
            recipes.append(recipe)
    computed = [len(o) for role, o in occurrences.items() if role.kind not in GIVEN and _recipe_of(role) is None]
    count = max([len(recipes), 1, *computed])
    sections = [{} for _ in range(count)]
    for role, several in occurrences.items():
        recipe = _recipe_of(role)
        if recipe and len(recipes) > 1:
            sections[recipes.index(recipe)][role] = several[0]
            several = several[1:]
            notes += [f"{place_text(each)} ({each.role}) is there twice and was not checked" for each in several]
            continue
        for section, each in zip(sections, several, strict=False):
            section[role] = each
    return sections


def _recipe_of(role):
    """Which recipe a product belongs to: γβ and γβα to the first, αβ, αβγ and a transpose to the second."""
    if role.kind == "transposed":
        return "left"
    if role.kind == "matrix" and len(role.word) > 1:
        return "right" if role.word[0] > role.word[-1] else "left"
    return None


def _best(book, section, angles, point):
    """Judge a calculation by the recipes that its labels allow; the one with the fewest wrong cells is meant."""
    if point is None:
        point = _given(book, section, "coordinate", "the point x, y, z")
    cells = _given(book, section, "angle", "the angles α, β, γ") if angles is None else None
    choices = [("right", 1)]
    if {_recipe_of(role) for role in section} - {None} == {"left"}:
        choices = [("left", 1)]
        if not any(role.kind == "negated" for role in section):
            choices.append(("left", -1))  # source 000 enters the negative angles, so the cells may hold them
            if not any(role.kind == "transposed" for role in section):
                choices.append(("right", 1))
    meant = [
        Task(section, angles if cells is None else written * cells, point, recipe, written)
        for recipe, written in choices
    ]
    return min(map(_judge, meant), key=lambda results: sum(j.status == WRONG for j in results.judgements))


def _given(book, section, kind, what):
    values = []
    for n in range(3):
        each = section.get(Role(kind, (n,)))
        if each is None:
            raise InputError(
                str(book.path), f"{what}, labelled or named in `cells`", f"none for {Role(kind, (n,))}"
            )
        cell = each.sheet.cells.get(each.anchor)
        if cell is None or cell.number is None:
            where = f"{book.path}, {each.sheet.address(each.anchor)} ({each.role})"
            raise InputError(where, "a number", "nothing" if cell is None else repr(cell.value))
        values.append(cell.number)
    return np.array(values)


# From calculations to judgements.

_STAGE = {
    "angle": 0,
    "coordinate": 0,
    "negated": 1,
    "radians": 2,
    "cos": 2,
    "sin": 2,
    "transposed": 4,
    "outcome": 5,
}
_PART = {"radians": 0, "cos": 1, "sin": 2, "matrix": 3}


def _order(role):
    """The order of source 000: each angle's cosine, sine and matrix, the products, the transpose, the point."""
    if role.kind == "matrix":
        return (2, role.word[0], 3) if len(role.word) == 1 else (3, len(role.word) or 9, 0)
    return (_STAGE[role.kind], role.word[0] if role.word else 9, _PART.get(role.kind, 0))


@dataclass(frozen=True)
class _Results:
    """The judgements of one task, and what is needed to say why."""

    task: Task
    judgements: list
    status: dict

    def first_error(self):
        """The kinds, the sentence and the detective's question of the first wrong step; None if all is right."""
        for role in sorted(self.status, key=_order):
            if (self.status[role] == WRONG).any():
                kinds, why = diagnose(self.task, role, self.status)
                return kinds, why, self.question()
        return None

    def question(self):
        """What to ask the detective: angles, point and result, if the result is there and not right."""
        roles = [Role("outcome", (n,)) for n in range(3)]
        if any(role not in self.status or not np.isfinite(self.task.values[role]) for role in roles):
            return None
        if all((self.status[role] == RIGHT).all() for role in roles):
            return None
        return (
            self.task.angles.tolist(),
            self.task.point.tolist(),
            [float(self.task.values[role]) for role in roles],
        )


def _judge(task):
    """Judge every cell of a task, in the order of the calculation."""
    judgements, status = [], {}
    for role in sorted(task.found, key=_order):
        expected, values, locals_ = task.expected(role), task.values[role], task.locals(role)
        inherited = locals_[0].slack if locals_ else np.zeros(role.shape)
        # What is given is exact, but for the digits by which it differs from the task that was asked.
        own_slack = np.nan_to_num(np.abs(values - expected)) if role.kind in GIVEN else task.halves[role]
        task.slack[role] = np.minimum(own_slack, task.halves[role]) + inherited
        own = EXACT * np.maximum(1, np.abs(expected)) + task.halves[role]
        right = np.abs(values - expected) <= own + inherited
        follows = np.zeros(role.shape, dtype=bool)
        for local in locals_:
            spoilt = any((status[source] != RIGHT).any() for source in local.sources if source in status)
            if spoilt:
                near = np.abs(values - local.value) <= own + local.slack
                follows |= near | (np.isnan(local.value) & ~_is_text(task.found[role]))
        status[role] = np.where(right, RIGHT, np.where(follows, CONSEQUENCE, WRONG))
        judgements += _judgements(task.found[role], status[role], expected)
    return _Results(task, judgements, status)


def _is_text(found):
    cells = [found.sheet.cells.get(place) for place in found.places.flat]
    text = [cell is not None and isinstance(cell.value, str) and not cell.error for cell in cells]
    return np.array(text).reshape(found.places.shape)


def _judgements(found: Found, status, expected):
    for index, place in np.ndenumerate(found.places):
        cell = found.sheet.cells.get(place)
        written = "nothing" if cell is None else cell.number if cell.number is not None else str(cell.value)
        yield Judgement(
            cell=found.sheet.address(place),
            role=describe(found, index),
            status=str(status[index]),
            written=written,
            expected=float(expected[index]),
            formula="" if cell is None else f"{{{cell.formula}}}" if cell.array else cell.formula,
        )
