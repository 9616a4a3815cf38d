"""From sympy expressions to NumPy functions, and from plain loops to machine code where Numba is installed."""

import logging
import math
from collections import Counter
from collections.abc import Callable, Hashable, Iterable, Iterator, Sequence
from functools import cache, lru_cache, partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import sympy as sp
from numpy.typing import ArrayLike
from sympy.printing.numpy import NumPyPrinter

from mathpost.errors import InputError

SLICE = 16384  # elements that a formula works on at a time


def from_angles(build: Callable, angles: Sequence[Any], degrees: bool) -> Any:
    """Apply the symbolic `build`, a function of the angles, to numbers, arrays or sympy expressions."""
    if any(isinstance(angle, sp.Basic) for angle in angles):
        return build(*(sp.sympify(angle) * (sp.pi / 180 if degrees else 1) for angle in angles))
    try:
        values = [np.asarray(angle, dtype=float) for angle in angles]
    except (TypeError, ValueError):
        raise InputError("angles", "numbers, arrays or sympy expressions", repr(angles)) from None
    return _built(build, len(angles))(*(map(np.deg2rad, values) if degrees else values))


@lru_cache(maxsize=256)
def _built(build: Callable, count: int) -> Callable[..., np.ndarray]:
    symbols = sp.symbols(f"angle:{count}", real=True)
    return numeric(sp.ImmutableMatrix(build(*symbols)), symbols)


@lru_cache(maxsize=512)
def numeric(
    expression: sp.Expr | sp.Matrix | tuple[sp.Expr, ...],
    arguments: tuple[sp.Symbol, ...],
    named: tuple[tuple[sp.Symbol, sp.Expr], ...] = (),
) -> Callable[..., np.ndarray]:
    """Compile a sympy expression into a function of NumPy arrays, and cache it: the one place where formulas become
    functions.

    `expression` is one expression, an ImmutableMatrix or a tuple of expressions, `arguments` a tuple of symbols,
    `named` pairs of a further symbol and its expression. The function takes numbers or arrays, broadcast against
    each other to shape ``(...)``, and returns a float array of shape ``(...)``, ``(..., rows, columns)`` or
    ``(..., len(tuple))``. Common subexpressions are computed once. Large arrays are processed in pieces of `SLICE`
    elements, so that the intermediate results stay in the processor's cache.

    Examples
    --------
    >>> x = sp.Symbol("x")
    >>> numeric((sp.cos(x), sp.S(1)), (x,))([0, np.pi])
    array([[ 1.,  1.],
           [-1.,  1.]])
    """
    shape = (len(expression),) if isinstance(expression, tuple) else getattr(expression, "shape", ())
    entries = list(expression if shape else [expression])
    # Sorting the terms and printing everything again as a docstring would take as long as all the rest.
    printer = NumPyPrinter({"fully_qualified_modules": False, "inline": True, "order": "none"})
    common = partial(shared, named=named)
    # A dict: by its name sympy would run "from numpy import *", which loads all of it, f2py too.
    compiled = sp.lambdify(arguments, entries, vars(np), printer, cse=common, use_imps=False, docstring_limit=0)

    def evaluate(*values: ArrayLike) -> np.ndarray:
        arrays: Sequence[np.ndarray] = [np.asarray(value, dtype=float) for value in values]
        if len({array.shape for array in arrays if array.ndim}) > 1:
            arrays = np.broadcast_arrays(*arrays)
        over = max((array.shape for array in arrays), key=len)  # a single number among arrays stays one
        flat = [array.reshape(-1) if array.ndim else array for array in arrays]
        result = np.empty((len(entries), math.prod(over)))
        for rows in slices(result.shape[1:]):
            for index, entry in enumerate(compiled(*(array[rows] if array.ndim else array for array in flat))):
                result[index, rows] = entry
        return result.T.reshape((*over, *shape))

    return evaluate


def slices(shape: tuple[int, ...]) -> Iterator[slice]:
    """Yield slices of the first axis of `shape` that take about `SLICE` elements each."""
    step = max(1, SLICE // max(1, math.prod(shape[1:])))
    for start in range(0, shape[0], step):
        yield slice(start, start + step)


def shared(
    expressions: Iterable[sp.Expr],
    symbols: Iterator[sp.Symbol] | None = None,
    named: Iterable[tuple[sp.Symbol, sp.Expr]] = (),
) -> tuple[list[tuple[sp.Symbol, sp.Expr]], list[sp.Expr]]:
    """Return common subexpressions, as pairs of a symbol and its value, and the expressions written in these.

    Exact constants (√2/2, long fractions) are evaluated, exponents left alone. Two parts are the same if
    their operands are, or if they differ in sign only: the second branch of an inverse reuses the root and the
    division of the first. Unlike `sympy.cse` it does not let sympy simplify again, which takes most of the time
    there. `named`, pairs of a symbol and its meaning, are replaced by their meaning.
    """
    values = _Values(dict(named))
    results = [values.signed(sp.sympify(entry)) for entry in expressions]
    return values.written(results, symbols or sp.numbered_symbols("common"))


Operand = tuple[int, int]  # a sign, and the number of a value


class Operation(NamedTuple):
    """A function of earlier values, in order; `exponent` is that of a power."""

    function: type[sp.Basic]
    operands: list[Operand]
    exponent: sp.Expr | None


class _Values:
    """Values numbered as they are met, each a leaf or an operation on earlier values (value numbering)."""

    ODD = (sp.sin, sp.tan, sp.asin, sp.atan)

    def __init__(self, meaning: dict[sp.Symbol, sp.Expr]) -> None:
        self.meaning = meaning
        self.met: dict[sp.Expr, Operand] = {}
        self.numbers: dict[Hashable, int] = {}  # of a leaf, or an operation on sorted operands
        self.values: list[sp.Expr | Operation] = []  # by number

    def signed(self, expression: sp.Expr) -> Operand:
        """Return an expression as an operand."""
        expression = self.meaning.get(expression, expression)
        if expression not in self.met:
            self.met[expression] = self._take(expression)
        return self.met[expression]

    def _take(self, expression: sp.Expr) -> Operand:
        if not expression.args or expression.is_number:
            leaf = _leaf(expression)
            negative = leaf.is_Number and leaf.is_negative
            return (-1, self._number(-leaf)) if negative else (1, self._number(leaf))
        if expression.is_Mul:
            return self._product(expression)
        if expression.is_Pow and expression.exp.is_number:
            sign, base = self.signed(expression.base)
            if expression.exp.is_Integer:
                return int(sign**expression.exp), self._operation(sp.Pow, [(1, base)], expression.exp)
            return 1, self._operation(sp.Pow, [(sign, base)], expression.exp)
        operands = [self.signed(part) for part in expression.args]
        if expression.is_Add:
            sign, _ = min(operands, key=lambda operand: operand[1])
            return sign, self._operation(sp.Add, [(sign * each, number) for each, number in operands])
        if isinstance(expression, self.ODD):
            ((sign, number),) = operands
            return sign, self._operation(expression.func, [(1, number)])
        if isinstance(expression, sp.cos):
            operands = [(1, number) for _, number in operands]
        return 1, self._operation(expression.func, operands)

    def _product(self, expression: sp.Expr) -> Operand:
        """Return a product as its constant factor times the rest, which is a value of its own."""
        factor = _leaf(sp.Mul(*(part for part in expression.args if part.is_number)))
        operands = [self.signed(part) for part in expression.args if not part.is_number]
        sign = math.prod(each for each, _ in operands) * (-1 if factor.is_negative else 1)
        rest = [(1, number) for _, number in operands]
        product = self._operation(sp.Mul, rest) if len(rest) > 1 else rest[0][1]
        if abs(factor) != 1:
            product = self._operation(sp.Mul, [(1, self._number(abs(factor))), (1, product)])
        return sign, product

    def _operation(self, function: type[sp.Basic], operands: list[Operand], exponent: sp.Expr | None = None) -> int:
        key = sorted(operands) if function in (sp.Add, sp.Mul) else operands
        return self._number((function, tuple(key), exponent), Operation(function, operands, exponent))

    def _number(self, key: Hashable, value: sp.Expr | Operation | None = None) -> int:
        if key not in self.numbers:
            self.numbers[key] = len(self.values)
            self.values.append(key if value is None else value)
        return self.numbers[key]

    def written(
        self, results: list[Operand], symbols: Iterator[sp.Symbol]
    ) -> tuple[list[tuple[sp.Symbol, sp.Expr]], list[sp.Expr]]:
        """The values that are used more than once as pairs of a symbol and an expression, and the results."""
        uses = Counter(number for _, number in results)
        for number, value in reversed(list(enumerate(self.values))):  # operands have smaller numbers
            if uses[number] and isinstance(value, Operation):
                uses.update(operand for _, operand in value.operands)
        pairs: list[tuple[sp.Symbol, sp.Expr]] = []
        expressions: dict[int, sp.Expr] = {}
        for number, value in enumerate(self.values):
            if not uses[number]:
                continue
            if not isinstance(value, Operation):
                expressions[number] = value
                continue
            function, operands, exponent = value
            parts = [_with_sign(sign, expressions[operand]) for sign, operand in operands]
            parts += [exponent] * (exponent is not None)
            is_value = issubclass(function, sp.Expr)  # not a condition or a case of a Piecewise
            expression = function(*parts, **({"evaluate": False} if is_value else {}))
            if uses[number] > 1 and is_value:
                symbol = next(symbols)
                pairs.append((symbol, expression))
                expression = symbol
            expressions[number] = expression
        return pairs, [_with_sign(sign, expressions[number]) for sign, number in results]


def _leaf(expression: sp.Expr) -> sp.Expr:
    """A symbol unchanged; a constant as a float, or as an integer where it is one that a float holds exactly."""
    exact = not expression.is_number or (expression.is_Integer and abs(expression) < 2**53)
    return expression if exact else sp.N(expression, 30)


def _with_sign(sign: int, expression: sp.Expr) -> sp.Expr:
    if sign > 0:
        return expression
    factors = expression.args if expression.is_Mul else (expression,)
    if factors[0].is_Number:
        return sp.Mul(-factors[0], *factors[1:], evaluate=False) if len(factors) > 1 else -expression
    return sp.Mul(-1, *factors, evaluate=False)


@cache
def _say_how_to_compile() -> None:
    logging.getLogger(__name__).info("long loops run as Python; Numba compiles them: pip install mathpost[fast]")


@cache
def compiled(loop: Callable, *helpers: Callable) -> Callable:
    """Compile a loop that calls `helpers`, cached if there is a folder for it; without Numba it stays as it is."""
    try:
        from numba import njit
        from numba.extending import register_jitable
    except ImportError:
        _say_how_to_compile()
        return loop
    for function in helpers:
        register_jitable(function)
    try:
        made = njit(cache=True, error_model="numpy")(loop)
    except RuntimeError:  # no cache folder, neither here nor at home
        made = njit(error_model="numpy")(loop)
    if made is loop:  # Numba is told to compile nothing
        return loop
    kept = made.stats.cache_path
    if kept is None or not any(Path(kept).glob(f"*.{loop.__qualname__}-*.nbi")):
        logging.getLogger(__name__).info("compiling %s%s", loop.__name__, ", once" if kept else "")
    return made
