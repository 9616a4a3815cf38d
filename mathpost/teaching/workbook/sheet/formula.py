"""Spreadsheet formulas, read as trees.

A tree is a tuple of a head and its parts: ``("number", 2.0)``, ``("text", "a")``, ``("area", area)``, and of trees
``("SIN", tree)``, ``("minus", tree)``, ``("+", left, right)``.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

from openpyxl.formula import Tokenizer
from openpyxl.utils import get_column_letter, range_boundaries

if TYPE_CHECKING:
    from mathpost.teaching.workbook.sheet.place import Place

POWER = {"^": 5, "*": 4, "/": 4, "+": 3, "-": 3, "&": 2, "=": 1, "<>": 1, "<": 1, ">": 1, "<=": 1, ">=": 1}
LOGICAL = {"TRUE": 1.0, "FALSE": 0.0}
CRITERIA = {*("SUMIF COUNTIF AVERAGEIF SUMIFS COUNTIFS AVERAGEIFS MAXIFS MINIFS".split())}
PARAMETERS = {
    **dict.fromkeys("SIN COS TAN ASIN ACOS ATAN RADIANS DEGREES SQRT ABS TRANSPOSE MINVERSE MDETERM".split(), 1),
    **dict.fromkeys(("ATAN2", "MMULT"), 2),
}  # how many there are, where formulas are changed
SIGNS = {"=", "<>", "<", ">", "<=", ">="}
LARGEST = 20_000  # cells of a range
LEVELS, PARTS, LETTERS = 100, 20_000, 8192  # of a formula, the names in it included; a spreadsheet takes 64 levels
Tree = tuple[Any, ...]


class NotUnderstood(ValueError):
    """A formula, or a part of one, that is not evaluated here; the message names it."""


@dataclass(frozen=True)
class Area:
    """Cells that a formula refers to, from 1; `fixed` says whether a $ keeps the first row and the first column."""

    sheet: str
    top: int
    left: int
    bottom: int
    right: int
    fixed: tuple[bool, bool] = (False, False)

    @cached_property
    def places(self) -> list[Place]:
        """The (sheet, row, column) of the cells, row by row."""
        columns = range(self.left, self.right + 1)
        return [(self.sheet, row, column) for row in range(self.top, self.bottom + 1) for column in columns]

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns."""
        return self.bottom - self.top + 1, self.right - self.left + 1

    def but_last(self) -> Area:
        """Return the area without its last row, or column if it has but one row."""
        rows, columns = self.shape
        return Area(self.sheet, self.top, self.left, self.bottom - (rows > 1), self.right - (rows == 1 < columns))

    def moved(self, rows: int, columns: int) -> Area | None:
        """Return the area `rows` further down and `columns` further right; None if it leaves the sheet."""
        corners = self.top + rows, self.left + columns, self.bottom + rows, self.right + columns
        return Area(self.sheet, *corners, self.fixed) if min(corners) > 0 else None

    def filled(self, rows: int, columns: int) -> Area | None:
        """Return the area in a formula filled so far down and to the right; None if it leaves the sheet."""
        return self.moved(rows * (not self.fixed[0]), columns * (not self.fixed[1]))

    def seen_from(self, row: int, column: int) -> tuple[Any, ...]:
        """Rows and columns as counted from a cell where no $ keeps them: what filling a formula leaves as it is."""
        down, right = row * (not self.fixed[0]), column * (not self.fixed[1])
        return self.sheet, self.top - down, self.left - right, self.shape, self.fixed

    def steps_to(self, other: Area) -> tuple[int, int]:
        """How far it is to another area, down and to the right."""
        return other.top - self.top, other.left - self.left

    def __str__(self) -> str:
        return self.written().replace("$", "")

    def written(self) -> str:
        """The area as a formula has it, with each $."""
        row, column = ("$" if fixed else "" for fixed in self.fixed)
        first = f"{column}{get_column_letter(self.left)}{row}{self.top}"
        last = f"{column}{get_column_letter(self.right)}{row}{self.bottom}"
        return first if first == last else f"{first}:{last}"


def area_of(places: Sequence[Place]) -> Area:
    """Return the `Area` from the first to the last of `places`."""
    return Area(*places[0], *places[-1][1:])


def parse(
    text: str,
    sheet: str,
    names: Mapping[str, Area | str],
    sheets: Mapping[str, str] | None = None,
    left: list[int] | None = None,
) -> Tree:
    """Return the tree of a formula in `sheet`, text that begins with ``=``; raise `NotUnderstood` if it has none.

    `names` has the `Area` or formula of each name in upper case, `sheets`, if given, the existing sheets, by lower
    case; `left` is how many levels and parts are still allowed, if this is the formula of a name in another one.

    Examples
    --------
    >>> parse("=-B2^2+SIN(3)", "S", {})[2]
    ('SIN', ('number', 3.0))
    """
    if len(text) > LETTERS:
        raise NotUnderstood(f"a formula of {len(text)} letters")
    try:
        tokens = [t for t in Tokenizer(text).items if t.type != "WHITE-SPACE"]
    except Exception as error:  # the tokenizer raises what it meets
        raise NotUnderstood(str(error)) from None
    reader = _Reader(tokens[::-1], sheet, names, sheets or {}, left or [LEVELS, PARTS])
    try:
        tree = reader.expression()
    except IndexError:
        raise NotUnderstood("the end of the formula") from None
    if reader.tokens:
        raise NotUnderstood(reader.tokens[-1].value)
    stack, level = [tree], 0
    while stack:
        stack, level = [part for each in stack for part in each if isinstance(part, tuple)], level + 1
    if level > 2 * LEVELS:
        raise NotUnderstood(f"a formula of {level} levels")
    return tree


def _criterion(tree: Tree) -> Tree:
    """A criterion such as ">"&A1; anything else as it is."""
    is_one = tree[0] == "&" and tree[1][0] == "text" and tree[1][1].strip() in SIGNS
    return ("criterion", ("text", tree[1][1].strip()), tree[2]) if is_one else tree


@dataclass
class _Reader:
    """Precedence climbing over the tokens of openpyxl, which are taken from the end of a reversed list."""

    tokens: list
    sheet: str
    names: Mapping[str, Area | str]
    sheets: Mapping[str, str]
    left: list[int]  # levels and parts

    def expression(self, least: int = 0) -> Tree:
        left = self.operand()
        while self.tokens and self.tokens[-1].type.startswith("OPERATOR"):
            operator = self.tokens[-1].value
            if POWER.get(operator, 9) <= least:
                break
            if self.tokens.pop().type == "OPERATOR-POSTFIX":
                left = ("percent", left)
            elif operator in POWER:
                left = (operator, left, self.expression(POWER[operator]))
            else:
                raise NotUnderstood(operator.strip() or "an intersection of ranges")
        return left

    def operand(self) -> Tree:
        self.left[:] = self.left[0] - 1, self.left[1] - 1
        if min(self.left) < 0:
            raise NotUnderstood(f"a formula of more than {LEVELS} levels or {PARTS} parts")
        try:
            return self.operand_within()
        finally:
            self.left[0] += 1

    def operand_within(self) -> Tree:
        token = self.tokens.pop()
        if token.type == "OPERATOR-PREFIX":
            inner = self.expression(5)  # a sign binds closer than a power: -2^2 is 4
            return inner if token.value == "+" else ("minus", inner)
        if token.subtype == "OPEN":
            rows = self.until_close()
            if token.type == "ARRAY":
                return ("rows", *(("row", *row) for row in rows))
            name = token.value[:-1].upper().replace("_XLFN.", "").replace("_XLWS.", "")
            if name in LOGICAL and not rows[0]:
                return ("number", LOGICAL[name])
            if name in CRITERIA:
                return (name, *map(_criterion, rows[0]))
            if len(rows[0]) != PARAMETERS.get(name, len(rows[0])):
                raise NotUnderstood(f"{name} of {len(rows[0])} arguments")
            return (name, *rows[0]) if name else rows[0][0]
        if token.subtype in ("NUMBER", "LOGICAL"):
            number = float(LOGICAL.get(token.value.upper(), token.value))
            if not math.isfinite(number):
                raise NotUnderstood(token.value)
            return ("number", number)
        if token.subtype == "TEXT":
            return ("text", token.value[1:-1].replace('""', '"'))
        if isinstance(text := self.names.get(token.value.rpartition("!")[2].upper()), str):
            others = {n: a for n, a in self.names.items() if a != text}
            return parse(text, self.sheet, others, self.sheets, self.left)
        if token.subtype == "RANGE":
            return ("area", self.area(token.value))
        raise NotUnderstood(token.value)

    def until_close(self) -> list[list[Tree]]:
        """The rows of expressions up to a closing parenthesis or brace; 0 where one is left out."""
        left_out = True
        rows: list[list[Tree]] = [[]]
        while self.tokens[-1].subtype != "CLOSE":
            if is_separator := self.tokens[-1].type == "SEP":
                rows[-1] += [("number", 0.0)] * left_out
                rows += [[] for _ in range(self.tokens.pop().subtype == "ROW")]
            else:
                rows[-1].append(self.expression())
            left_out = is_separator
        rows[-1] += [("number", 0.0)] * (left_out and bool(rows[-1]))
        self.tokens.pop()
        return rows

    def area(self, text: str) -> Area:
        sheet, _, local = text.rpartition("!")
        if isinstance(found := self.names.get(local.upper()), Area):
            return found
        name = sheet.strip("'").replace("''", "'")
        if name and name.lower() not in self.sheets:
            raise NotUnderstood(f"the sheet {name}, which is not there")
        try:
            left, top, right, bottom = range_boundaries(local)
        except ValueError:
            raise NotUnderstood(text) from None
        if None in (left, top) or (abs(bottom - top) + 1) * (abs(right - left) + 1) > LARGEST:
            raise NotUnderstood(f"the large range {local}")
        (top, bottom), (left, right) = sorted((top, bottom)), sorted((left, right))
        fixed = bool(re.match(r"\$?[A-Za-z]+\$", local)), local.startswith("$")
        return Area(self.sheets.get(name.lower(), self.sheet), top, left, bottom, right, fixed)
