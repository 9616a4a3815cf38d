"""Spreadsheet formulas as trees, evaluated at many inputs at once.

A tree is a tuple of a head and its parts: ``("number", 2.0)``, ``("text", "a")``, ``("area", area)``, and of trees
``("SIN", tree)``, ``("minus", tree)``, ``("+", left, right)``. Values are arrays of shape (samples, rows, columns):
a scalar is (samples, 1, 1), and one evaluation covers all the samples.
"""

import re
from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np
from openpyxl.formula import Tokenizer
from openpyxl.utils import get_column_letter, range_boundaries

POWER = {"^": 5, "*": 4, "/": 4, "+": 3, "-": 3, "&": 2, "=": 1, "<>": 1, "<": 1, ">": 1, "<=": 1, ">=": 1}
LOGICAL = {"TRUE": 1.0, "FALSE": 0.0}
LARGEST = 20_000  # cells of a range
LEVELS, PARTS, LETTERS = 100, 20_000, 8192  # of a formula, the names in it included; a spreadsheet takes 64 levels
CONVERSIONS = np.array([np.pi, np.pi / 180, 180 / np.pi, 180.0, 2 * np.pi, np.pi / 200, 200 / np.pi])
ROUNDING = {"ROUND", "ROUNDDOWN", "ROUNDUP", "TRUNC", "INT"}


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
    fixed: tuple = (False, False)

    @cached_property
    def places(self):
        """The (sheet, row, column) of the cells, row by row."""
        columns = range(self.left, self.right + 1)
        return [(self.sheet, row, column) for row in range(self.top, self.bottom + 1) for column in columns]

    @property
    def shape(self):
        """Rows and columns."""
        return self.bottom - self.top + 1, self.right - self.left + 1

    def but_last(self):
        """Return the area without its last row, or column if it has but one row."""
        rows, columns = self.shape
        return Area(self.sheet, self.top, self.left, self.bottom - (rows > 1), self.right - (rows == 1 < columns))

    def moved(self, rows, columns):
        """Return the area `rows` further down and `columns` further right; None if it leaves the sheet."""
        corners = self.top + rows, self.left + columns, self.bottom + rows, self.right + columns
        return Area(self.sheet, *corners, self.fixed) if min(corners) > 0 else None

    def filled(self, rows, columns):
        """Return the area in a formula filled so far down and to the right; None if it leaves the sheet."""
        return self.moved(rows * (not self.fixed[0]), columns * (not self.fixed[1]))

    def steps_to(self, other):
        """How far it is to another area, down and to the right."""
        return other.top - self.top, other.left - self.left

    def __str__(self):
        first, last = f"{get_column_letter(self.left)}{self.top}", f"{get_column_letter(self.right)}{self.bottom}"
        return first if first == last else f"{first}:{last}"


def area_of(places):
    """Return the `Area` from the first to the last of `places`."""
    return Area(*places[0], *places[-1][1:])


def parse(text, sheet, names, sheets=None, left=None):
    """Return the tree of a formula, with its ``=``, that stands in `sheet`; raise `NotUnderstood` if it has none.

    `names` has the `Area` or formula of each name in upper case, `sheets`, if given, the sheets that are there, by
    lower case; `left` how many levels and parts a formula may still have that it is a name in.

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


@dataclass
class _Reader:
    """Precedence climbing over the tokens of openpyxl, which are taken from the end of a reversed list."""

    tokens: list
    sheet: str
    names: dict
    sheets: dict
    left: list  # levels and parts

    def expression(self, least=0):
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

    def operand(self):
        self.left[:] = self.left[0] - 1, self.left[1] - 1
        if min(self.left) < 0:
            raise NotUnderstood(f"a formula of more than {LEVELS} levels or {PARTS} parts")
        try:
            return self.operand_within()
        finally:
            self.left[0] += 1

    def operand_within(self):
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
            return (name, *rows[0]) if name else rows[0][0]
        if token.subtype in ("NUMBER", "LOGICAL"):
            return ("number", float(LOGICAL.get(token.value.upper(), token.value)))
        if token.subtype == "TEXT":
            return ("text", token.value[1:-1].replace('""', '"'))
        if isinstance(text := self.names.get(token.value.upper()), str):
            others = {n: a for n, a in self.names.items() if a != text}
            return parse(text, self.sheet, others, self.sheets, self.left)
        if token.subtype == "RANGE":
            return ("area", self.area(token.value))
        raise NotUnderstood(token.value)

    def until_close(self):
        """The rows of expressions up to a closing parenthesis or brace; 0 where one is left out."""
        rows, left_out = [[]], True
        while self.tokens[-1].subtype != "CLOSE":
            if is_separator := self.tokens[-1].type == "SEP":
                rows[-1] += [("number", 0.0)] * left_out
                rows += [[] for _ in range(self.tokens.pop().subtype == "ROW")]
            else:
                rows[-1].append(self.expression())
            left_out = is_separator
        self.tokens.pop()
        return rows

    def area(self, text):
        sheet, _, local = text.rpartition("!")
        if local.upper() in self.names:
            return self.names[local.upper()]
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


def walk(tree, path=()):
    """Yield every part of a tree with its path, a tuple of positions."""
    stack = [(path, tree)]
    while stack:
        path, tree = stack.pop()
        yield path, tree
        stack += [((*path, n), tree[n]) for n in range(len(tree) - 1, 0, -1) if type(tree[n]) is tuple]


def parts_of(tree):
    """Yield every part of a tree, itself first, in the order of `walk`."""
    stack = [tree]
    while stack:
        tree = stack.pop()
        yield tree
        stack += [part for part in tree[:0:-1] if type(part) is tuple]


def put(tree, path, new):
    """Return the tree with the part at `path` replaced."""
    return (*tree[: path[0]], put(tree[path[0]], path[1:], new), *tree[path[0] + 1 :]) if path else new


def areas(tree):
    """Return the areas in a tree, in their order."""
    return [part[1] for part in parts_of(tree) if part[0] == "area"]


def with_areas(tree, new):
    """Return the tree with the areas `new` in place of its own, in their order."""
    new = iter(new)

    def rebuilt(tree):
        if tree[0] == "area":
            return "area", next(new)
        return tuple([rebuilt(part) if type(part) is tuple else part for part in tree])

    return rebuilt(tree)


def gives_text(tree):
    """Whether a formula always gives a text, and no number."""
    if tree[0] in ("IF", "IFERROR"):
        return all(map(gives_text, tree[-2:] if len(tree) > 3 or tree[0] == "IFERROR" else tree[2:]))
    return tree[0] in TEXTS


def heads(tree):
    """Return the functions, operators and kinds of leaves in a tree."""
    return {part[0] for part in parts_of(tree)}


def text_of(tree, sheet=None):
    """Write a tree as a formula without its ``=``; as it is written in `sheet`, if given, with the other sheets."""
    head, *parts = tree
    if head == "area":
        return str(parts[0]) if sheet is None or parts[0].sheet == sheet else f"{parts[0].sheet}!{parts[0]}"
    if head in ("number", "text"):
        return {"number": "{:.15g}", "text": '"{}"'}[head].format(parts[0])
    if head in ("minus", "percent"):
        return f"-{_within(parts[0], 4, sheet)}" if head == "minus" else f"{_within(parts[0], 6, sheet)}%"
    if head in POWER:
        return f"{_within(parts[0], POWER[head] - 1, sheet)}{head}{_within(parts[1], POWER[head], sheet)}"
    inner = (";" if head == "rows" else ",").join(text_of(part, sheet) for part in parts)
    return {"rows": f"{{{inner}}}", "row": inner}.get(head, f"{head}({inner})")


def unrounded(tree):
    """The tree without the last rounding of what it gives, to two decimals or more, or of a copy of a cell."""
    if tree[0] in ROUNDING and (tree[1][0] == "area" or (tree[2:] and tree[2][0] == "number" and tree[2][1] >= 2)):
        return tree[1]
    if tree[0] == "IF":
        return (*tree[:2], *map(unrounded, tree[2:]))
    return (tree[0], unrounded(tree[1]), *tree[2:]) if tree[0] == "MOD" else tree


def exact(tree, within):
    """The tree with π, π/180 and the like for all numbers that are nearly these, relatively `within`.

    Examples
    --------
    >>> text_of(exact(parse("=A1*3.1416/180", "S", {}), 1e-5))
    'A1*3.14159265358979/180'
    """
    if tree[0] == "number":
        near = CONVERSIONS[np.abs(tree[1] - CONVERSIONS) < within * CONVERSIONS]
        return ("number", float(near[0])) if len(near) else tree
    return tuple(exact(part, within) if isinstance(part, tuple) else part for part in tree)


def form_of(tree):
    """Write a tree as a formula in which all references of one size are alike."""
    return text_of(with_areas(tree, [area.shape for area in areas(tree)]))


def _within(tree, least, sheet):
    text = text_of(tree, sheet)
    return f"({text})" if POWER.get(tree[0], 9) <= least else text


# Evaluation.


def _rounded(how):
    def function(x, digits=0):
        scale = 10.0**digits
        return np.sign(x) * how(np.abs(x) * scale) / scale

    return function


def _total(reduce, each=lambda value: value):
    def function(*values):
        samples = max(map(len, values))
        parts = [v.reshape(len(v), -1) for v in map(each, values)]
        parts = [v if len(v) == samples else np.repeat(v, samples, axis=0) for v in parts]
        return reduce(np.concatenate(parts, axis=1), axis=1)[:, None, None]

    return function


def _index(area, row, column=None):
    row = int(row.flat[0])
    if column is None:
        row, column = (1, row) if area.shape[1] == 1 else (row, int(area.shape[2] == 1))  # 0 is all of them
    else:
        column = int(column.flat[0])
    if not (0 <= row <= area.shape[1] and 0 <= column <= area.shape[2]):
        raise IndexError
    area = area[:, row - 1 : row] if row else area  # 0 is all of them
    return area[:, :, column - 1 : column] if column else area


def _sum_of_products(*values):
    if len({value.shape[1:] for value in values}) > 1:
        raise ValueError
    return np.prod(np.broadcast_arrays(*values), axis=0).sum(axis=(1, 2), keepdims=True)


def _inverse(matrix):
    """The inverse, NaN at the samples where there is none."""
    matrix = np.where(np.isfinite(matrix), matrix, 0.0)
    singular = np.linalg.det(matrix)[:, None, None] == 0
    return np.where(singular, np.nan, np.linalg.inv(np.where(singular, np.eye(matrix.shape[-1]), matrix)))


TEXTS = {"text", "&", "TEXT", "CONCAT", "CONCATENATE", "TEXTJOIN", "FIXED", "LEFT", "RIGHT", "MID", "REPT"}
COMPARISONS = {
    **{"=": np.equal, "<>": np.not_equal, "<": np.less},
    **{">": np.greater, "<=": np.less_equal, ">=": np.greater_equal},
}
SPREADS = {  # of a sample, or of all
    f"{name}{end}": partial(spread, ddof=end in ("", ".S"))
    for name, spread in (("STDEV", np.std), ("VAR", np.var))
    for end in ("", ".S", "P", ".P")
}
STATISTICS = {"COUNT", "SUM", "PRODUCT", "AVERAGE", "MEDIAN", "MAX", "MIN", "SUMSQ", *SPREADS}
FUNCTIONS = {
    **COMPARISONS,
    **{"+": np.add, "-": np.subtract, "*": np.multiply, "/": np.divide, "^": np.power, "POWER": np.power},
    **{"minus": np.negative, "percent": lambda x: x / 100},
    **{name: getattr(np, name.lower()) for name in ("SIN", "COS", "TAN", "SQRT", "EXP", "SIGN", "ABS")},
    **{f"A{name}": getattr(np, f"arc{name.lower()}") for name in ("SIN", "COS", "TAN")},
    # The spreadsheet's order is x, y.
    "ATAN2": lambda x, y: np.where((x == 0) & (y == 0), np.nan, np.arctan2(y, x)),
    **{"RADIANS": np.deg2rad, "DEGREES": np.rad2deg, "PI": lambda: np.full((1, 1, 1), np.pi)},
    **{"INT": np.floor, "LN": np.log, "MOD": lambda x, n: x - n * np.floor(x / n)},
    **{"ROUND": _rounded(lambda x: np.floor(x + 0.5)), "ROUNDUP": _rounded(np.ceil)},
    **{name: _rounded(np.floor) for name in ("ROUNDDOWN", "TRUNC")},
    **{
        "COUNT": _total(lambda x, axis: np.isfinite(x).sum(axis=axis)),
        "SUM": _total(np.sum),
        "PRODUCT": _total(np.prod),
        **{"AVERAGE": _total(np.mean), "MEDIAN": _total(np.median)},
    },
    **{"MAX": _total(np.max), "MIN": _total(np.min), "SUMSQ": _total(np.sum, np.square)},
    **{name: _total(spread) for name, spread in SPREADS.items()},
    **{"AND": _total(np.all), "OR": _total(np.any), "NOT": lambda x: x == 0},
    "IF": lambda test, yes, no=0.0: np.where(test != 0, yes, no),
    "IFERROR": lambda value, other: np.where(np.isfinite(value), value, other),
    **{"INDEX": _index, "SUMPRODUCT": _sum_of_products},
    "SUMXMY2": lambda a, b: ((a - b) ** 2).sum(axis=(1, 2), keepdims=True),
    **{"MMULT": np.matmul, "TRANSPOSE": lambda a: np.swapaxes(a, 1, 2)},
    "MINVERSE": _inverse,
    "MDETERM": lambda a: np.linalg.det(a)[:, None, None],
    **{"SINGLE": lambda a: a[:, :1, :1], "N": lambda a: a},
    "rows": lambda *rows: np.concatenate(rows, axis=1),
    "row": lambda *entries: np.concatenate(entries, axis=2),
}


def evaluate(tree, look, functions=FUNCTIONS, held=()):
    """Return the value of a tree, shape (samples, rows, columns); `look(area)` returns that of an area.

    ``look(area, numbers_only=True)`` leaves out empty cells and texts, so that what is left is one row; `held` has
    the values of parts by their identity.

    Wrong arguments, such as a root of a negative number, are NaN, as an error value is.
    """
    if id(tree) in held:
        return held[id(tree)]
    head, *parts = tree
    if head == "area":
        return look(parts[0])
    if head in ("number", "text"):
        return np.array([[[parts[0] if head == "number" else np.nan]]])
    if head in ("=", "<>") and [part[0] for part in parts].count("text") == 1:  # a number is no text
        (number,) = (evaluate(part, look, functions, held) for part in parts if part[0] != "text")
        return np.where(np.isfinite(number), float(head == "<>"), np.nan)
    if head not in functions or (head in COMPARISONS and any(part[0] == "text" for part in parts)):
        raise NotUnderstood(f"the operator {head}" if head in POWER else head)
    values = [
        # Of cells these functions take what is a number: no empty one counts as 0, no text as what it means.
        look(part[1], numbers_only=True)
        if head in STATISTICS and part[0] == "area"
        else evaluate(part, look, functions, held)
        for part in parts
    ]
    try:
        value = functions[head](*values)
        return value if value.dtype == float else value * 1.0
    except (TypeError, ValueError, IndexError, np.linalg.LinAlgError):
        sizes = ", ".join("×".join(map(str, np.shape(value)[1:])) for value in values)
        raise NotUnderstood(f"{head} of {sizes or 'nothing'}") from None
