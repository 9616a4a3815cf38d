"""From sympy expressions to NumPy functions, and from plain loops to machine code where Numba is installed."""

import math
from collections import Counter
from functools import cache, lru_cache, partial

import numpy as np
import sympy as sp
from sympy.printing.numpy import NumPyPrinter

from mathpost.errors import InputError

SLICE = 16384  # elements that a formula works on at a time


def from_angles(build, angles, degrees):
    """Apply the symbolic `build`, a function of so many angles, to numbers, arrays or sympy expressions."""
    if any(isinstance(angle, sp.Basic) for angle in angles):
        return build(*(sp.sympify(angle) * (sp.pi / 180 if degrees else 1) for angle in angles))
    try:
        values = [np.asarray(angle, dtype=float) for angle in angles]
    except (TypeError, ValueError):
        raise InputError("angles", "numbers, arrays or sympy expressions", repr(angles)) from None
    return _built(build, len(angles))(*(map(np.deg2rad, values) if degrees else values))


@lru_cache(maxsize=256)
def _built(build, count):
    symbols = sp.symbols(f"angle:{count}", real=True)
    return numeric(sp.ImmutableMatrix(build(*symbols)), symbols)


@lru_cache(maxsize=512)
def numeric(expression, arguments, named=()):
    """Compile a sympy expression into a function of NumPy arrays: the one place that does, and remembers it.

    `expression` is one expression, an ImmutableMatrix or a tuple of expressions, `arguments` a tuple of symbols,
    `named` pairs of a further symbol and what it stands for. The function takes numbers or arrays, broadcast
    against each other to shape ``(...)``, and returns a float array of shape ``(...)``, ``(..., rows, columns)`` or
    ``(..., len(tuple))``. What the entries have in common is computed once. Large arrays go through in pieces of
    `SLICE` elements, so that the intermediate results stay in the processor's cache.

    Examples
    --------
    >>> x = sp.Symbol("x")
    >>> numeric((sp.cos(x), sp.S(1)), (x,))([0, np.pi])
    array([[ 1.,  1.],
           [-1.,  1.]])
    """
    shape = (len(expression),) if isinstance(expression, tuple) else getattr(expression, "shape", ())
    entries = list(expression if shape else [expression])
    # To sort the terms, and to print the whole once more as a docstring, takes as long as all else.
    printer = NumPyPrinter({"fully_qualified_modules": False, "inline": True, "order": "none"})
    common = partial(shared, named=named)
    compiled = sp.lambdify(arguments, entries, "numpy", printer, cse=common, use_imps=False, docstring_limit=0)

    def evaluate(*values):
        values = [np.asarray(value, dtype=float) for value in values]
        if len({value.shape for value in values if value.ndim}) > 1:
            values = np.broadcast_arrays(*values)
        over = max((value.shape for value in values), key=len)  # a single number among arrays stays one
        flat = [value.reshape(-1) if value.ndim else value for value in values]
        result = np.empty((len(entries), math.prod(over)))
        for rows in slices(result.shape[1:]):
            for index, entry in enumerate(compiled(*(value[rows] if value.ndim else value for value in flat))):
                result[index, rows] = entry
        return result.T.reshape(*over, *shape)

    return evaluate


def slices(shape):
    """Yield slices of the first axis of `shape` that take about `SLICE` elements each."""
    step = max(1, SLICE // max(1, math.prod(shape[1:])))
    for start in range(0, shape[0], step):
        yield slice(start, start + step)


def shared(expressions, symbols=None, named=()):
    """Take apart what expressions have in common: pairs of a symbol and its value, and the expressions in these.

    Exact constants (√2/2, long fractions) are evaluated, exponents left alone. Unlike `sympy.cse` it looks for
    equal parts only, and lets sympy simplify nothing again, which takes most of the time there. Symbols that are
    `named`, pairs of a symbol and its meaning, give way to that.
    """
    meaning = dict(named)

    def parts(expression):
        return [meaning.get(part, part) for part in _parts(expression)]

    expressions = [meaning.get(entry, entry) for entry in map(sp.sympify, expressions)]
    symbols = symbols or sp.numbered_symbols("common")
    uses, left, built, pairs = Counter(expressions), [*dict.fromkeys(expressions)], {}, []
    while left:
        for part in parts(left.pop()):
            uses[part] += 1
            if uses[part] == 1:
                left.append(part)

    def build(part):
        if part not in built:
            built[part] = new = _put_together(part, [build(each) for each in parts(part)])
            if uses[part] > 1 and new.args and isinstance(new, sp.Expr):  # no condition, no case of a Piecewise
                built[part] = next(symbols)
                pairs.append((built[part], new))
        return built[part]

    return pairs, [build(entry) for entry in expressions]


def _parts(expression):
    """What an expression is made of: of a constant nothing, of a product the constant factor and the rest."""
    if not expression.args or expression.is_number:
        return ()
    if expression.is_Pow:
        return expression.args[:1]
    if expression.is_Mul and any(factor.is_number for factor in expression.args):
        constant = [factor for factor in expression.args if factor.is_number]
        rest = [factor for factor in expression.args if not factor.is_number]
        return sp.Mul(*constant), sp.Mul(*rest, evaluate=False)
    return expression.args


def _put_together(expression, parts):
    """An expression of these parts as they stand; a constant as a float, but for whole numbers that one holds."""
    if not parts:
        exact = not expression.is_number or (expression.is_Integer and abs(expression) < 2**53)
        return expression if exact else sp.N(expression, 30)
    if expression.is_Pow:
        return sp.Pow(*parts, expression.exp, evaluate=False)
    # A condition knows no such choice.
    as_it_stands = {"evaluate": False} if isinstance(expression, sp.Expr) else {}
    return expression.func(*parts, **as_it_stands)


@cache
def compiled(loop, *helpers):
    """A loop that calls `helpers` as machine code, kept if there is a folder for it; as it stands without Numba."""
    try:
        from numba import njit
        from numba.extending import register_jitable
    except ImportError:
        return loop
    for function in helpers:
        register_jitable(function)
    try:
        return njit(cache=True, error_model="numpy")(loop)
    except RuntimeError:  # neither here nor in the home folder
        return njit(error_model="numpy")(loop)
