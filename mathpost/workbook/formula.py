"""Spreadsheet formulas as trees, evaluated at many inputs at once.

A tree is a tuple: ``("number", 2.0)``, ``("text", "a")``, ``("area", area)``, ``("call", "SIN", arguments)``,
``("minus", tree)``, ``("percent", tree)``, ``("+", left, right)``, ``("rows", rows)``. Values are arrays of shape
(samples, rows, columns), so a scalar is (samples, 1, 1), and one evaluation covers all the samples.
"""

import re
from dataclasses import dataclass

import numpy as np
from openpyxl.formula import Tokenizer
from openpyxl.utils import column_index_from_string, get_column_letter

POWER = {"^": 5, "*": 4, "/": 4, "+": 3, "-": 3, "&": 2, "=": 1, "<>": 1, "<": 1, ">": 1, "<=": 1, ">=": 1}
AREA = re.compile(r"(\$?)([A-Z]{1,3})(\$?)(\d+)(?::(\$?)([A-Z]{1,3})(\$?)(\d+))?$", re.IGNORECASE)


class NotUnderstood(ValueError):
    """A formula, or a part of one, that is not evaluated here; the message names it."""


@dataclass(frozen=True)
class Area:
    """Cells that a formula refers to: the sheet's name, corners from 1, and which of them a $ holds.

    `fixed` tells of the first row and the first column whether a copied formula keeps them.
    """

    sheet: str
    top: int
    left: int
    bottom: int
    right: int
    fixed: tuple = (False, False)

    @property
    def places(self):
        """The (sheet, row, column) of the cells, row by row."""
        rows, columns = range(self.top, self.bottom + 1), range(self.left, self.right + 1)
        return [(self.sheet, row, column) for row in rows for column in columns]

    @property
    def shape(self):
        """Rows and columns."""
        return self.bottom - self.top + 1, self.right - self.left + 1

    def moved(self, rows, columns):
        """Return the area `rows` further down and `columns` further right; None if it leaves the sheet."""
        top, left = self.top + rows, self.left + columns
        if top < 1 or left < 1:
            return None
        return Area(self.sheet, top, left, self.bottom + rows, self.right + columns, self.fixed)

    def __str__(self):
        first, last = f"{get_column_letter(self.left)}{self.top}", f"{get_column_letter(self.right)}{self.bottom}"
        return first if first == last else f"{first}:{last}"


def area_of(places):
    """Return the `Area` from the first to the last of `places`."""
    (sheet, top, left), (_, bottom, right) = places[0], places[-1]
    return Area(sheet, top, left, bottom, right)


def parse(text, sheet, names):
    """Return the tree of a formula that stands in `sheet`.

    Parameters
    ----------
    text : str
        With its ``=``.
    sheet : str
    names : dict
        Name in upper case → `Area`, or a formula's text.

    Raises
    ------
    NotUnderstood
        Names the first thing that is no formula of this grammar.

    Examples
    --------
    >>> parse("=-B2^2+SIN($C3)", "S", {})[0]
    '+'
    """
    try:
        tokens = [t for t in Tokenizer(text).items if t.type != "WHITE-SPACE"]
    except Exception as error:  # the tokenizer raises what it meets
        raise NotUnderstood(str(error)) from None
    reader = _Reader(tokens, sheet, names)
    tree = reader.expression(0)
    if reader.tokens:
        raise NotUnderstood(reader.tokens[-1].value)
    return tree


class _Reader:
    """Precedence climbing over the tokens of openpyxl, which are taken from the end of a reversed list."""

    def __init__(self, tokens, sheet, names):
        self.tokens, self.sheet, self.names = tokens[::-1], sheet, names

    def take(self, kind=None):
        if not self.tokens or (kind and self.tokens[-1].type != kind):
            raise NotUnderstood(self.tokens[-1].value if self.tokens else "the end of the formula")
        return self.tokens.pop()

    def expression(self, least):
        left = self.operand()
        while self.tokens and self.tokens[-1].type.startswith("OPERATOR"):
            operator = self.tokens[-1].value
            if self.tokens[-1].type == "OPERATOR-POSTFIX":
                self.take()
                left = ("percent", left)
            elif operator not in POWER:
                raise NotUnderstood(operator.strip() or "an intersection of ranges")
            elif POWER[operator] <= least:
                break
            else:
                self.take()
                left = (operator, left, self.expression(POWER[operator]))
        return left

    def operand(self):
        token = self.take()
        if token.type == "OPERATOR-PREFIX":
            inner = self.expression(5)  # a sign binds closer than a power: -2^2 is 4
            return inner if token.value == "+" else ("minus", inner)
        if token.type == "PAREN":
            inner = self.expression(0)
            self.take("PAREN")
            return inner
        if token.type == "FUNC":
            return ("call", token.value[:-1].upper().replace("_XLFN.", "").replace("_XLWS.", ""), self.arguments())
        if token.type == "ARRAY":
            rows = [[]]
            while (token := self.take()).type != "ARRAY":
                if token.type == "SEP" and token.subtype == "ROW":
                    rows.append([])
                elif token.type == "OPERAND":
                    rows[-1].append(self.constant(token))
                elif token.type == "OPERATOR-PREFIX":
                    rows[-1].append(("minus", self.constant(self.take())))
                elif token.type not in ("ARRAYROW", "SEP"):
                    raise NotUnderstood(token.value)
            return ("rows", tuple(tuple(row) for row in rows if row))
        return self.constant(token)

    def arguments(self):
        found = []
        while True:
            if self.tokens and self.tokens[-1].type == "FUNC" and self.tokens[-1].subtype == "CLOSE":
                self.take()
                return tuple(found)
            if self.tokens and self.tokens[-1].type == "SEP":
                self.take()
                continue
            found.append(self.expression(0))

    def constant(self, token):
        if token.type != "OPERAND":
            raise NotUnderstood(token.value)
        if token.subtype == "NUMBER":
            return ("number", float(token.value))
        if token.subtype == "TEXT":
            return ("text", token.value[1:-1].replace('""', '"'))
        if token.subtype == "LOGICAL":
            return ("number", float(token.value.upper() == "TRUE"))
        if token.subtype == "RANGE":
            return self.reference(token.value)
        raise NotUnderstood(token.value)

    def reference(self, text):
        sheet, _, local = text.rpartition("!")
        known = self.names.get(local.upper())
        if isinstance(known, Area):
            return ("area", known)
        if known:
            return parse(known, self.sheet, {k: v for k, v in self.names.items() if k != local.upper()})
        found = AREA.match(local)
        if not found:
            raise NotUnderstood(text)
        name = sheet.strip("'").replace("''", "'") or self.sheet
        left, top = column_index_from_string(found[2].upper()), int(found[4])
        right = column_index_from_string(found[6].upper()) if found[6] else left
        bottom = int(found[8]) if found[8] else top
        return ("area", Area(name, top, left, bottom, right, (bool(found[3]), bool(found[1]))))


def walk(tree, path=()):
    """Yield every part of a tree with its path, a tuple of positions."""
    yield path, tree
    for position, child in enumerate(tree):
        if isinstance(child, tuple):
            if tree[0] in ("call", "rows") and position == len(tree) - 1:
                for n, argument in enumerate(child):
                    if tree[0] == "call":
                        yield from walk(argument, (*path, position, n))
                    else:
                        for k, entry in enumerate(argument):
                            yield from walk(entry, (*path, position, n, k))
            else:
                yield from walk(child, (*path, position))


def put(tree, path, new):
    """Return the tree with the part at `path` replaced."""
    if not path:
        return new
    return (*tree[: path[0]], put(tree[path[0]], path[1:], new), *tree[path[0] + 1 :])


def areas(tree):
    """Return the areas in a tree, in their order."""
    return [part[1] for _, part in walk(tree) if part[0] == "area"]


def text_of(tree):
    """Write a tree as a formula without its ``=``.

    Examples
    --------
    >>> text_of(parse("=-(A1+2)*SUM(B1:B3)", "S", {}))
    '-(A1+2)*SUM(B1:B3)'
    """
    kind = tree[0]
    if kind == "number":
        return f"{tree[1]:.15g}"
    if kind == "text":
        return f'"{tree[1]}"'
    if kind == "area":
        return str(tree[1])
    if kind == "call":
        return f"{tree[1]}({','.join(map(text_of, tree[2]))})"
    if kind == "rows":
        return "{" + ";".join(",".join(map(text_of, row)) for row in tree[1]) + "}"
    if kind == "minus":
        return f"-{_within(tree[1], 4)}"
    if kind == "percent":
        return f"{_within(tree[1], 6)}%"
    own = POWER[kind]
    return f"{_within(tree[1], own - 1)}{kind}{_within(tree[2], own)}"


def _within(tree, least):
    text = text_of(tree)
    return f"({text})" if tree[0] in POWER and POWER[tree[0]] <= least else text


# Evaluation.


def evaluate(tree, look):
    """Return the value of a tree, shape (samples, rows, columns); `look(area)` returns that of an area.

    Wrong arguments, such as a root of a negative number, are NaN, as an error value is.
    """
    kind = tree[0]
    if kind == "number":
        return np.full((1, 1, 1), tree[1])
    if kind == "area":
        return look(tree[1])
    if kind == "call":
        return _call(tree[1], tree[2], look)
    if kind == "minus":
        return -evaluate(tree[1], look)
    if kind == "percent":
        return evaluate(tree[1], look) / 100
    if kind == "rows":
        return np.array([[evaluate(entry, look)[0, 0, 0] for entry in row] for row in tree[1]])[None]
    if kind in OPERATORS:
        left, right = evaluate(tree[1], look), evaluate(tree[2], look)
        if kind in "+-*/^" or "text" not in (tree[1][0], tree[2][0]):
            return OPERATORS[kind](left, right) * 1.0
    if kind == "text":
        return np.full((1, 1, 1), np.nan)
    raise NotUnderstood(f"the operator {kind}")


def _call(name, arguments, look):
    if name == "IF":
        test, *branches = (evaluate(argument, look) for argument in arguments)
        return np.where(test != 0, branches[0], branches[1] if len(branches) > 1 else 0.0)
    if name == "IFERROR":
        value = evaluate(arguments[0], look)
        return np.where(np.isfinite(value), value, evaluate(arguments[1], look))
    if name == "INDEX":
        area, *at = (evaluate(argument, look) for argument in arguments)
        at = [int(position[0, 0, 0]) for position in at]
        if len(at) == 1:
            at = [1, at[0]] if area.shape[1] == 1 else [at[0], 1]
        if not (1 <= at[0] <= area.shape[1] and 1 <= at[1] <= area.shape[2]):
            raise NotUnderstood("INDEX beyond its range")
        return area[:, at[0] - 1 : at[0], at[1] - 1 : at[1]]
    if name in PLAIN:
        values = [evaluate(argument, look) for argument in arguments]
        try:
            return PLAIN[name](*values)
        except (TypeError, ValueError, IndexError, np.linalg.LinAlgError):
            sizes = ", ".join("×".join(map(str, value.shape[1:])) for value in values)
            raise NotUnderstood(f"{name} of {sizes or 'nothing'}") from None
    raise NotUnderstood(name)


def _rounded(how):
    def function(x, digits=None):
        scale = 10.0 ** (0 if digits is None else digits)
        return np.sign(x) * how(np.abs(x) * scale) / scale

    return function


def _total(reduce):
    def function(*values):
        parts = [value.reshape(len(value), -1) for value in values]
        samples = max(map(len, parts))
        whole = np.concatenate([np.broadcast_to(p, (samples, p.shape[1])) for p in parts], axis=1)
        return reduce(whole, axis=1)[:, None, None]

    return function


def _sum_of_products(*values):
    if len({value.shape[1:] for value in values}) > 1:
        raise ValueError("shapes")
    return np.prod(np.broadcast_arrays(*values), axis=0).sum(axis=(1, 2), keepdims=True)


def _either(*values):
    return (_total(np.max)(*[(value != 0) * 1.0 for value in values])) * 1.0


def _finite_inverse(matrix):
    return np.linalg.inv(np.where(np.isfinite(matrix), matrix, 0.0))


PLAIN = {
    **{name: getattr(np, name.lower()) for name in ("SIN", "COS", "TAN", "SQRT", "EXP", "SIGN")},
    **{f"A{name}": getattr(np, f"arc{name.lower()}") for name in ("SIN", "COS", "TAN")},
    "ATAN2": lambda x, y: np.where(
        (x == 0) & (y == 0), np.nan, np.arctan2(y, x)
    ),  # the spreadsheet's order is x, y
    "RADIANS": np.deg2rad,
    "DEGREES": np.rad2deg,
    "PI": lambda: np.full((1, 1, 1), np.pi),
    "ABS": np.abs,
    "INT": np.floor,
    "LN": np.log,
    "POWER": np.power,
    "MOD": lambda x, n: x - n * np.floor(x / n),
    "ROUND": _rounded(lambda x: np.floor(x + 0.5)),
    "ROUNDDOWN": _rounded(np.floor),
    "ROUNDUP": _rounded(np.ceil),
    "TRUNC": _rounded(np.floor),
    "SUM": _total(np.sum),
    "PRODUCT": _total(np.prod),
    "AVERAGE": _total(np.mean),
    "MAX": _total(np.max),
    "MIN": _total(np.min),
    "AND": lambda *v: _total(np.min)(*[(x != 0) * 1.0 for x in v]),
    "OR": _either,
    "NOT": lambda x: (x == 0) * 1.0,
    "SUMSQ": lambda *v: _total(np.sum)(*[x * x for x in v]),
    "SUMPRODUCT": _sum_of_products,
    "SUMXMY2": lambda a, b: ((a - b) ** 2).sum(axis=(1, 2), keepdims=True),
    "MMULT": np.matmul,
    "TRANSPOSE": lambda a: np.swapaxes(a, 1, 2),
    "MINVERSE": _finite_inverse,
    "MDETERM": lambda a: np.linalg.det(a)[:, None, None],
    "SINGLE": lambda a: a[:, :1, :1],
    "N": lambda a: a,
}
COMPARISONS = {
    "=": np.equal,
    "<>": np.not_equal,
    "<": np.less,
    ">": np.greater,
    "<=": np.less_equal,
    ">=": np.greater_equal,
}
OPERATORS = {"+": np.add, "-": np.subtract, "*": np.multiply, "/": np.divide, "^": np.power, **COMPARISONS}
