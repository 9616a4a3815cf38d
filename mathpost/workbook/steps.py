"""A worksheet's calculation as steps: what each range should hold, and what follows from the cells before it.

The steps are those of source 000: cosines and sines, three elementary matrices, their products, in the second
recipe the transpose, and the point. `Task` computes what a step should hold from the given angles and point
(*expected*), and again from what the worksheet itself holds (*local*): so an error is told from its consequences.
"""

import re
from dataclasses import dataclass
from functools import reduce

import numpy as np

from mathpost.detective.misreadings import elementary, written_decimals
from mathpost.workbook.label import Role

AXES = "ZXZ"
EXACT = 1e-9  # what a spreadsheet's arithmetic may lose
FULL = 9  # a number with so many decimals was not rounded by hand
LEAST = {"outcome": 2}  # decimals that a number written by hand needs at least; 3 elsewhere


@dataclass(frozen=True)
class Local:
    """A step computed from the worksheet's own cells: value, what their rounding may change, and which steps."""

    value: np.ndarray
    slack: np.ndarray
    sources: tuple


class Task:
    """One calculation in a worksheet: the given numbers, the recipe, and the ranges found for it.

    Parameters
    ----------
    found : dict
        `Role` → `mathpost.workbook.layout.Found`.
    angles, point : ndarray, shape (3,)
        Degrees and mm.
    recipe : str
        ``"right"`` or ``"left"``: γ·β·α, or α·β·γ of the negated angles and transposed.
    written : int
        −1 if the cells of the angles hold the negated ones already, else 1.
    """

    def __init__(self, found, angles, point, recipe="right", written=1):
        self.found, self.angles, self.point = found, angles, point
        self.recipe, self.written = recipe, written
        self.sign = -1 if recipe == "left" else 1
        self.values = {role: self._numbers(each) for role, each in found.items()}
        self.halves = {role: self._half_digits(each) for role, each in found.items()}
        self.slack = {}

    def _numbers(self, found):
        cells = [found.sheet.cells.get(place) for place in found.places.flat]
        numbers = [np.nan if cell is None or cell.number is None else cell.number for cell in cells]
        return np.array(numbers).reshape(found.places.shape)

    # What the steps should hold.

    def expected(self, role):
        """Return what the range of `role` should hold, in its shape."""
        n = role.word[0] if role.word else 0
        signed = self.sign * self.angles[n]
        simple = {
            "angle": lambda: self.written * self.angles[n],
            "negated": lambda: -self.angles[n],
            "radians": lambda: np.deg2rad(signed),
            "cos": lambda: elementary("Z", np.deg2rad(signed))[0, 0],
            "sin": lambda: elementary("Z", np.deg2rad(signed))[0, 1],
            "coordinate": lambda: self.point[n],
            "outcome": lambda: self.final[n] @ self.point,
            "matrix": lambda: self.product(role.word) if role.word else self.final,
            "transposed": lambda: self.product(role.word).T if role.word else self.final,
        }
        return np.asarray(simple[role.kind](), dtype=float)

    def product(self, word):
        """The product of the elementary matrices of the angles in `word`, first on the left."""
        return reduce(np.matmul, [elementary(AXES[n], np.deg2rad(self.sign * self.angles[n])) for n in word])

    @property
    def final(self):
        """The matrix that takes the point into the turned frame."""
        return self.product((2, 1, 0)) if self.recipe == "right" else self.product((0, 1, 2)).T

    # What follows from the worksheet's own cells.

    def locals(self, role):
        """Return every way to compute the range from other ranges that were found, the most direct first."""
        return list(self._locals(role))

    def _locals(self, role):
        kind, word = role.kind, role.word
        if kind in ("negated", "radians", "cos", "sin") or (kind == "matrix" and len(word) == 1):
            yield from self._from_angle(kind, word)
        elif kind == "matrix" and word:
            for parts in _splittings(word):
                yield from self._multiplied([Role("matrix", part) for part in parts])
        elif kind == "transposed" and word:
            yield from (_transpose(each) for each in self._matrix(Role("matrix", word)))
        elif kind in ("matrix", "transposed"):
            yield from self.finals(role)
        elif kind == "outcome":
            yield from self._outcomes(word[0])

    def _from_angle(self, kind, word):
        n = word[0]
        turned = [("radians", 1.0), ("negated", np.pi / 180), ("angle", self.sign * self.written * np.pi / 180)]
        if kind == "matrix" and {Role("cos", word), Role("sin", word)} <= self.values.keys():
            cosine, sine = self.values[Role("cos", word)], self.values[Role("sin", word)]
            # E(t) = E(0)·(what stays) + cosine and sine parts, read off the matrix at 0°, 90° and 180°.
            stays = (elementary(AXES[n], 0.0) + elementary(AXES[n], np.pi)) / 2
            even, odd = elementary(AXES[n], 0.0) - stays, elementary(AXES[n], np.pi / 2) - stays
            slack = np.abs(even) * self.slack_of(Role("cos", word)) + np.abs(odd) * self.slack_of(Role("sin", word))
            yield Local(stays + cosine * even + sine * odd, slack, (Role("cos", word), Role("sin", word)))
        for source, factor in turned:
            role = Role(source, word)
            if role in self.values and role.kind != kind and not (kind == "negated" and source != "angle"):
                angle, slack = (
                    self.values[role] * factor,
                    self.slack_of(role) * (1 if kind == "negated" else abs(factor)),
                )
                value = {
                    "negated": -self.values[role],
                    "radians": angle,
                    "cos": elementary("Z", angle)[0, 0],
                    "sin": elementary("Z", angle)[0, 1],
                    "matrix": elementary(AXES[n], angle),
                }[kind]
                yield Local(np.asarray(value), np.full(np.shape(value), slack), (role,))

    def _matrix(self, role):
        """A matrix as it stands in the worksheet, or else as it follows from what does."""
        if role in self.values:
            yield Local(self.values[role], self.slack_of(role), (role,))
        else:
            yield from self.locals(role)

    def _multiplied(self, roles):
        lefts = [next(self._matrix(role), None) for role in roles]
        if all(lefts):
            yield reduce(_multiply, lefts)

    def finals(self, role):
        """The final matrix from the others."""
        words = [r for r in self.values if r.kind == "matrix" and len(r.word) == 3]
        if self.recipe == "left":
            yield from (Local(self.values[r], self.slack_of(r), (r,)) for r in self.values
                        if r.kind == "transposed" and r != role)  # fmt: skip
            yield from (_transpose(Local(self.values[r], self.slack_of(r), (r,))) for r in words)
            if not words:
                yield from (_transpose(each) for each in self.locals(Role("matrix", (0, 1, 2))))
        else:
            yield from (Local(self.values[r], self.slack_of(r), (r,)) for r in words if r != role)
            if not words:
                yield from self.locals(Role("matrix", (2, 1, 0)))

    def _outcomes(self, row):
        names = [r for r in self.values if r.kind in ("matrix", "transposed") and not r.word]
        matrices = [Local(self.values[r], self.slack_of(r), (r,)) for r in names]
        matrices += self.finals(Role("outcome"))
        point = Local(
            np.array([self.values.get(Role("coordinate", (n,)), self.point[n]) for n in range(3)], dtype=float),
            np.array([self.slack_of(Role("coordinate", (n,))) for n in range(3)], dtype=float),
            tuple(Role("coordinate", (n,)) for n in range(3)),
        )
        for matrix in matrices:
            product = _multiply(matrix, point)
            yield Local(product.value[row], product.slack[row], product.sources)

    # How precisely numbers were written.

    def slack_of(self, role):
        """How far the rounding of what was typed may move the cells of `role`; zero for what is calculated."""
        return self.slack.get(role, np.zeros(role.shape))

    def _half_digits(self, found):
        """Half of the last digit written in each cell, 0 where it must be exact."""
        peers = [each for each in self.found.values() if _level(each.role) == _level(found.role)]
        own, all_digits = self._digits(found), [self._digits(each) for each in peers]
        group = max((d for d in all_digits if d is not None), default=FULL)
        half = np.zeros(found.places.shape)
        for index, place in np.ndenumerate(found.places):
            cell = found.sheet.cells.get(place)
            if cell is None or cell.number is None:
                continue
            written = _cell_digits(cell)
            if written is None or written >= FULL:
                continue
            typed_alike = own == group and LEAST.get(found.role.kind, 3) <= own < FULL
            result = found.role.kind == "outcome" and written >= LEAST["outcome"]
            if typed_alike:
                half[index] = 0.5 * 10.0**-own * (1 + 1e-6)
            elif written >= 6 or result:
                half[index] = 0.5 * 10.0**-written * (1 + 1e-6)
        return half

    def _digits(self, found):
        cells = [found.sheet.cells.get(place) for place in found.places.flat]
        digits = [_cell_digits(cell) for cell in cells if cell is not None and cell.number is not None]
        return max((d for d in digits if d is not None), default=None)


def _cell_digits(cell):
    """Decimals of a constant or of a formula that rounds; many for another formula; None for whole numbers."""
    if cell.formula and not re.search("ROUND|TRUNC|INT|FIXED", cell.formula.upper()):
        return 15
    return None if float(cell.number).is_integer() else written_decimals(cell.number)


def _level(role):
    if role.kind in ("cos", "sin", "radians") or (role.kind == "matrix" and len(role.word) == 1):
        return "elements"
    return "products" if role.kind in ("matrix", "transposed") else role.kind


def _splittings(word):
    """The ways to make a product of found ranges: γβ·α, γ·βα, γ·β·α."""
    if len(word) == 3:
        yield (word[:2], word[2:])
        yield (word[:1], word[1:])
    else:
        yield tuple((n,) for n in word)


def _multiply(left, right):
    slack = np.abs(np.nan_to_num(left.value)) @ right.slack + left.slack @ np.abs(np.nan_to_num(right.value))
    return Local(left.value @ right.value, slack, left.sources + right.sources)


def _transpose(local):
    return Local(local.value.T, np.transpose(local.slack), local.sources)
