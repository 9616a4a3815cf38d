"""Trees of formulas evaluated at many inputs at once.

Values are arrays of shape (samples, rows, columns): a scalar is (samples, 1, 1). An error is NaN, and so is a text.

Empty cells and texts count differently by context (`TAKES`): in arithmetic an empty cell is 0 and a text an error;
a sum or a mean leaves both out; in a product of columns both are 0; in a matrix both are an error. This follows the
documentation of Excel and the values of LibreOffice; where these differ, as for TRUE in a sum, the value is NaN.
"""

from __future__ import annotations

import math
import re
import zlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial, reduce
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from mathpost.teaching.workbook.sheet.formula import POWER, NotUnderstood

if TYPE_CHECKING:
    from mathpost.teaching.workbook.sheet.formula import Tree


Function = Callable[..., np.ndarray]  # of arrays, shape (samples, rows, columns)


def _rounded(how: Callable[[np.ndarray], np.ndarray]) -> Function:
    def function(x: np.ndarray, digits: np.ndarray | int = 0) -> np.ndarray:
        scale = 10.0**digits
        return np.sign(x) * how(np.abs(x) * scale) / scale

    return function


def _total(
    reduce: Callable[..., Any],
    each: Callable[[np.ndarray], np.ndarray] = lambda value: value,
    of_none: float = np.nan,
) -> Function:
    """A function of all numbers together, `of_none` where there is none."""

    def function(*values: np.ndarray) -> np.ndarray:
        samples = max(map(len, values))
        parts = [v.reshape(len(v), math.prod(v.shape[1:])) for v in map(each, values)]
        parts = [v if len(v) == samples else np.repeat(v, samples, axis=0) for v in parts]
        together = np.concatenate(parts, axis=1)
        total = reduce(together, axis=1) if together.size else np.full(samples, of_none)
        return total[:, None, None]

    return function


def _known(function: Function) -> Function:
    """A condition, NaN where a value that it asks about is."""

    def known(*values: ArrayLike) -> np.ndarray:
        unknown = reduce(np.logical_or, map(np.isnan, values))
        return np.where(unknown, np.nan, function(*values))

    return known


def _all_known(function: Function) -> Function:
    """The same of all values together."""
    return lambda x, axis: np.where(np.isnan(x).any(axis=axis), np.nan, function(x, axis=axis))


def _finite(function: Function) -> Function:
    """A function that gives an error where it has a pole."""

    def finite(*values: np.ndarray) -> np.ndarray:
        value = function(*values)
        return np.where(np.isfinite(value), value, np.nan)

    return finite


def _index(area: np.ndarray, row: np.ndarray, column: np.ndarray | None = None) -> np.ndarray:
    down = int(row.flat[0])
    if column is None:
        down, right = (1, down) if area.shape[1] == 1 else (down, int(area.shape[2] == 1))  # 0 is all of them
    else:
        right = int(column.flat[0])
    if not (0 <= down <= area.shape[1] and 0 <= right <= area.shape[2]):
        raise IndexError
    area = area[:, down - 1 : down] if down else area
    return area[:, :, right - 1 : right] if right else area


def _sum_of_products(*values: np.ndarray) -> np.ndarray:
    if len({value.shape[1:] for value in values}) > 1:
        raise ValueError
    return np.prod(np.broadcast_arrays(*values), axis=0).sum(axis=(1, 2), keepdims=True)


def _inverse(matrix: np.ndarray) -> np.ndarray:
    """The inverse, NaN at the samples where there is none."""
    known = np.isfinite(matrix).all(axis=(1, 2), keepdims=True)
    matrix = np.where(known, matrix, 0.0)
    singular = np.linalg.det(matrix)[:, None, None] == 0
    return np.where(singular, np.nan, np.linalg.inv(np.where(singular, np.eye(matrix.shape[-1]), matrix)))


def code(text: str) -> float:
    """A number that stands for a text, in any case the same: so a choice of texts is a function, too."""
    return 1 + zlib.crc32(text.strip().casefold().encode()) / 2**32


@dataclass(frozen=True)
class OfTrees:
    """A function of what its arguments are, not only of their values: it is called with how to evaluate them."""

    function: Callable[..., np.ndarray]


def _number_of(along: int) -> OfTrees:
    """ROW or COLUMN of an area."""

    def numbers(value: Callable[..., np.ndarray], area: Tree) -> np.ndarray:
        if area[0] != "area":
            raise NotUnderstood("a row of no cell")
        first, count = (area[1].top, area[1].left)[along], area[1].shape[along]
        return np.arange(first, first + count, dtype=float).reshape((1, -1, 1) if along == 0 else (1, 1, -1))

    return OfTrees(numbers)


def _chosen(value: Callable[..., np.ndarray], pairs: Sequence[Tree]) -> np.ndarray:
    """Of ranges and criteria in turn, which cells fulfil all: shape (samples, rows, columns), NaN where unknown."""
    chosen = np.ones((1, 1, 1))
    for area, criterion in zip(pairs[::2], pairs[1::2], strict=True):
        head, wanted = "=", criterion
        if criterion[0] == "criterion":
            head, wanted = criterion[1][1], criterion[2]
        elif criterion[0] == "text":
            text = criterion[1].strip()
            head = next((sign for sign in ("<>", "<=", ">=", "<", ">", "=") if text.startswith(sign)), "")
            text, head = text[len(head) :], head or "="
            number = re.fullmatch(r"-?[\d.]+", text)
            wanted = ("number", float(text)) if number else ("number", code(text))
        cells, key = value(area, take="with texts"), value(wanted, take="with texts")
        holds = np.where(np.isnan(cells), head == "<>", COMPARISONS[head](cells, key) == 1)
        chosen = chosen * holds
    return chosen


def _if(total: Callable[..., np.ndarray], first: int) -> OfTrees:
    """SUMIF and the like, `first` 0 or 2, or SUMIFS, 1: the total of the cells that fulfil criteria."""

    def of_chosen(value: Callable[..., np.ndarray], *parts: Tree) -> np.ndarray:
        pairs = parts[1:] if first == 1 else parts[:2] if first == 2 else parts
        cells = parts[0] if first < 2 or len(parts) < 3 else parts[2]
        if (
            cells[0] == "area" == pairs[0][0] and cells[1].shape != pairs[0][1].shape
        ):  # it begins there, and is as large as the other
            rows, columns = pairs[0][1].shape
            area = cells[1]
            cells = "area", replace(area, bottom=area.top + rows - 1, right=area.left + columns - 1)
        chosen, numbers = _chosen(value, pairs), value(cells, take="with texts")
        return total(chosen, np.where(chosen == 0, 0.0, numbers))

    return OfTrees(of_chosen)


def _sum_of(chosen: np.ndarray, numbers: np.ndarray) -> np.ndarray:
    return np.nansum(numbers * np.ones_like(chosen), axis=(1, 2), keepdims=True)


def _count_of(chosen: np.ndarray, numbers: np.ndarray) -> np.ndarray:
    return chosen.sum(axis=(1, 2), keepdims=True)


def _mean_of(chosen: np.ndarray, numbers: np.ndarray) -> np.ndarray:
    return _finite(np.divide)(_sum_of(chosen, numbers), _count_of(chosen, numbers))


def _extreme_of(extreme: Callable[..., np.ndarray], beyond: float) -> Callable[..., np.ndarray]:
    return lambda chosen, numbers: extreme(np.where(chosen == 0, beyond, numbers), axis=(1, 2), keepdims=True)


BY_CRITERIA = {
    **{"SUMIF": _if(_sum_of, 2), "COUNTIF": _if(_count_of, 0), "AVERAGEIF": _if(_mean_of, 2)},
    **{"SUMIFS": _if(_sum_of, 1), "COUNTIFS": _if(_count_of, 0), "AVERAGEIFS": _if(_mean_of, 1)},
    **{"MAXIFS": _if(_extreme_of(np.max, -np.inf), 1), "MINIFS": _if(_extreme_of(np.min, np.inf), 1)},
}
CONDITIONS = {"AND", "OR", "NOT"}
COMPARISONS = {
    **{"=": _known(np.equal), "<>": _known(np.not_equal), "<": _known(np.less)},
    **{">": _known(np.greater), "<=": _known(np.less_equal), ">=": _known(np.greater_equal)},
}
SPREADS = {  # of a sample, or of all
    f"{name}{end}": partial(spread, ddof=end in ("", ".S"))
    for name, spread in (("STDEV", np.std), ("VAR", np.var))
    for end in ("", ".S", "P", ".P")
}
STATISTICS = {"COUNT", "SUM", "PRODUCT", "AVERAGE", "MEDIAN", "MAX", "MIN", "SUMSQ", *SPREADS}
TAKES = {  # function → how it takes the cells of a range that hold no number
    **dict.fromkeys(STATISTICS, "left out"),
    **dict.fromkeys(("AND", "OR"), "left out, TRUE is 1"),
    **dict.fromkeys(("SUMPRODUCT", "N"), "as 0"),
    **dict.fromkeys(("MMULT", "MINVERSE", "MDETERM", "SUMXMY2"), "as an error"),
}
FUNCTIONS = {
    **COMPARISONS,
    **{"+": np.add, "-": np.subtract, "*": np.multiply, "/": _finite(np.divide)},
    **dict.fromkeys(("^", "POWER"), _finite(np.power)),
    **{"minus": np.negative, "percent": lambda x: x / 100},
    **{name: getattr(np, name.lower()) for name in ("SIN", "COS", "TAN", "SQRT", "EXP", "SIGN", "ABS")},
    **{f"A{name}": getattr(np, f"arc{name.lower()}") for name in ("SIN", "COS", "TAN")},
    # The spreadsheet's order is x, y.
    "ATAN2": lambda x, y: np.where((x == 0) & (y == 0), np.nan, np.arctan2(y, x)),
    **{"RADIANS": np.deg2rad, "DEGREES": np.rad2deg, "PI": lambda: np.full((1, 1, 1), np.pi)},
    **{"INT": np.floor, "LN": _finite(np.log), "MOD": lambda x, n: x - n * np.floor(x / n)},
    **{"ROUND": _rounded(lambda x: np.floor(x + 0.5)), "ROUNDUP": _rounded(np.ceil)},
    **{name: _rounded(np.floor) for name in ("ROUNDDOWN", "TRUNC")},
    **{
        "COUNT": _total(lambda x, axis: np.isfinite(x).sum(axis=axis), of_none=0.0),
        "SUM": _total(np.sum, of_none=0.0),
        "SUMSQ": _total(np.sum, np.square, of_none=0.0),
        **{name: _total(getattr(np, name.lower()[:4]), of_none=0.0) for name in ("PRODUCT", "MAX", "MIN")},
        **{"AVERAGE": _total(np.mean), "MEDIAN": _total(np.median)},
    },
    **{name: _total(spread) for name, spread in SPREADS.items()},
    **{"AND": _total(_all_known(np.all)), "OR": _total(_all_known(np.any)), "NOT": _known(lambda x: x == 0)},
    "IF": lambda test, yes, no=0.0: np.where(np.isnan(test), np.nan, np.where(test != 0, yes, no)),
    "IFERROR": lambda value, other: np.where(np.isfinite(value), value, other),
    **{"INDEX": _index, "SUMPRODUCT": _sum_of_products},
    "SUMXMY2": lambda a, b: ((a - b) ** 2).sum(axis=(1, 2), keepdims=True),
    **{"MMULT": np.matmul, "TRANSPOSE": lambda a: np.swapaxes(a, 1, 2)},
    "MINVERSE": _inverse,
    "MDETERM": lambda a: np.linalg.det(a)[:, None, None],
    **BY_CRITERIA,
    **{"ROW": _number_of(0), "COLUMN": _number_of(1)},
    "criterion": lambda sign, number: number,
    **{"SINGLE": lambda a: a[:, :1, :1], "N": lambda a: a},
    "rows": lambda *rows: np.concatenate(rows, axis=1),
    "row": lambda *entries: np.concatenate(entries, axis=2),
}


def evaluate(
    tree: Tree,
    look: Callable[..., np.ndarray],
    functions: Mapping[str, Callable] = FUNCTIONS,
    held: Mapping[int, np.ndarray] | tuple[()] = (),
    take: str = "",
) -> np.ndarray:
    """Return the value of a tree, shape (samples, rows, columns); `look(area, take=…)` returns that of an area.

    `held` has the values of parts by their identity; `take` is what `TAKES` has for the function that asks, empty
    in arithmetic.

    Wrong arguments, such as a root of a negative number, are NaN, as an error value is.
    """
    if id(tree) in held and not take:
        return held[id(tree)]
    head, *parts = tree
    if head == "area":
        return look(parts[0], take=take)
    if head == "number":
        return np.array(parts[0], ndmin=3)
    if head == "text":
        return functions[head](parts[0]) if head in functions else np.full((1, 1, 1), np.nan)
    texts = [float(part[0] == "text") for part in parts] if head in COMPARISONS else []
    if sum(texts) == 1:  # every text is beyond every number
        (number,) = (evaluate(part, look, functions, held) for part in parts if part[0] != "text")
        return np.where(np.isfinite(number), COMPARISONS[head](*texts), np.nan)
    if head not in functions or any(texts):
        raise NotUnderstood(f"the operator {head}" if head in POWER else head)
    take = take if head == "TRANSPOSE" else TAKES.get(head, "")  # what is empty stays so
    function, values = functions[head], []
    try:
        if isinstance(function, OfTrees):
            value = function.function(partial(evaluate, look=look, functions=functions, held=held), *parts)
        else:
            values = [evaluate(part, look, functions, held, take) for part in parts]
            value = function(*values)
        return value if value.dtype == float else value * 1.0
    except (TypeError, ValueError, IndexError, OverflowError, AttributeError, np.linalg.LinAlgError):
        sizes = ", ".join("×".join(map(str, np.shape(value)[1:])) for value in values)
        raise NotUnderstood(f"{head} of {sizes or 'nothing'}") from None
