"""Formulas as answers: read without being run, and compared by their values.

See `mathpost.course.answers` for what a kind of answer is.
"""

import ast
import unicodedata
from dataclasses import dataclass

import numpy as np
import sympy as sp

from mathpost.course.answers import Kind, brief
from mathpost.errors import InputError

FUNCTIONS = {name: getattr(sp, name) for name in "sin cos tan asin acos atan atan2 sqrt exp log Abs".split()}
FUNCTIONS |= {"arc" + name[1:]: function for name, function in FUNCTIONS.items() if name[0] == "a"}
OPERATIONS = {ast.Add: "__add__", ast.Sub: "__sub__", ast.Mult: "__mul__", ast.Div: "__truediv__"}
LONGEST, GREATEST_POWER, GREATEST_BASE = 2000, 12, 1e6  # of a formula that is read: it must not take for ever


@dataclass(frozen=True)
class Formula(Kind):
    """A formula, or a list or matrix of them: as sympy, or as text in Python's or a textbook's spelling.

    Two are the same if they have the same value wherever one looks, however they are written.

    Examples
    --------
    >>> a, x = sp.symbols("alpha x")
    >>> Formula().same(Formula().read("2·x·sin(α)·cos(α)"), Formula().read(x * sp.sin(2 * a)))
    True
    """

    asked: str = "a formula"

    def read(self, answer):
        rows = np.asarray(answer, dtype=object).tolist()
        written = _each(lambda formula: formula if isinstance(formula, str) else sp.sstr(formula), rows)
        try:
            _each(parse, written)
        except (SyntaxError, KeyError, TypeError, ValueError, AttributeError, RecursionError):
            raise InputError("answer", self.asked, brief(answer)) from None
        return written

    def same(self, value, target):
        one, other = (np.ravel(np.array(_each(parse, rows), dtype=object)) for rows in (value, target))
        return len(one) == len(other) and all(map(_equal, one, other))

    def mixups(self, target):
        yield "Right but for the sign.", _each(lambda text: f"-({text})", target)
        yield "Sine and cosine are exchanged.", _each(_exchanged, target)
        if isinstance(target, list) and isinstance(target[0], list):
            yield "That is the transpose.", [list(column) for column in zip(*target, strict=True)]

    def show(self, value):
        return str(value).replace("'", "")


def parse(text):
    """Return a formula as sympy without running it: numbers, names, + - * / ** and `FUNCTIONS`.

    Examples
    --------
    >>> parse("cos(β)^2 − 1/2")
    cos(beta)**2 - 1/2
    """
    if len(text) > LONGEST:
        raise SyntaxError
    text = unicodedata.normalize("NFC", text).replace("·", "*").replace("×", "*").replace("−", "-")
    return _node(ast.parse(text.replace("^", "**").strip(), mode="eval").body)


def _node(node):
    if isinstance(node, ast.Constant) and type(node.value) in (int, float):
        return sp.Integer(node.value) if type(node.value) is int else sp.Float(node.value)
    if isinstance(node, ast.Name):
        greek = unicodedata.name(node.id[0]).startswith("GREEK") and len(node.id) == 1
        name = unicodedata.name(node.id).split()[-1].lower() if greek else node.id
        return sp.pi if name == "pi" else sp.Symbol(name)
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, (ast.USub, ast.UAdd)):
        return -_node(node.operand) if isinstance(node.op, ast.USub) else _node(node.operand)
    if isinstance(node, ast.Call) and not node.keywords:
        return FUNCTIONS[node.func.id](*map(_node, node.args))
    left, right = _node(node.left), _node(node.right)
    if not isinstance(node.op, ast.Pow):
        return getattr(left, OPERATIONS[type(node.op)])(right)
    if (right.is_number and abs(right) > GREATEST_POWER) or (left.is_number and abs(left) > GREATEST_BASE):
        raise SyntaxError
    return left**right


def _each(function, rows):
    return [_each(function, row) for row in rows] if isinstance(rows, list) else function(rows)


def _exchanged(text):
    swapped = sp.Function("swapped")
    return sp.sstr(parse(text).replace(sp.sin, swapped).replace(sp.cos, sp.sin).replace(swapped, sp.cos))


def _equal(one, other):
    """Whether two formulas agree at some places that nobody chose."""
    random = np.random.default_rng(1)
    names = sorted(map(str, one.free_symbols | other.free_symbols))
    for _ in range(6):
        at = {
            sp.Symbol(name): value for name, value in zip(names, random.uniform(0.1, 0.9, len(names)), strict=True)
        }
        value, target = (complex(formula.evalf(subs=at)) for formula in (one, other))
        if not abs(value - target) <= 1e-9 * (1 + abs(target)):
            return False
    return True
