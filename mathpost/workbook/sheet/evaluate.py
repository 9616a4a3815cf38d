"""Trees of formulas evaluated at many inputs at once.

Values are arrays of shape (samples, rows, columns): a scalar is (samples, 1, 1).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from mathpost.workbook.sheet.formula import POWER, NotUnderstood

if TYPE_CHECKING:
    from mathpost.workbook.sheet.formula import Tree


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


def evaluate(
    tree: Tree,
    look: Callable[..., np.ndarray],
    functions: Mapping[str, Callable] = FUNCTIONS,
    held: Mapping[int, np.ndarray] | tuple[()] = (),
) -> np.ndarray:
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
