"""Variables of a program that runs from line to line: each is the number that the last line before gave it.

`Variables.line` takes a line with its assignments, and returns what is left of it with numbers in the places of the
variables. Nothing is run in a circle, so it is known what a feed such as Q50 is for one operation and for the next.
What depends on more is refused: a condition, a function, a variable without a number, one of the control's own.
"""

from __future__ import annotations

import ast
import operator
import re
from collections.abc import Callable
from typing import TYPE_CHECKING

from mathpost.errors import InputError
from mathpost.files import NUMBER

if TYPE_CHECKING:
    from mathpost.shop.controls.words import Words

# How a control names its variables: in capital letters, as a line is read.
NAMES = {
    "#": r"#(?:\d+|<\w+>)",
    "Q": r"Q[LR]?\d+(?![\d.])",
    "R": r"R\d+(?![\d.])|[A-Z_]\w*",  # R parameters, and names, which have to be declared
}
LONGEST, MOST_BRACKETS = 200, 50  # characters of an expression, and its like in a line
DIGITS = 12  # decimals of a number that takes a variable's place
OPERATIONS: dict[type, Callable] = {
    ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul, ast.Div: operator.truediv,
    ast.UAdd: operator.pos, ast.USub: operator.neg,
}  # fmt: skip
SYSTEM = r"#\d{4,}"  # of the control: tool lengths, work offsets, alarms
MARK = {"#": "", "Q": r"(?:FN\s*[0-4]:\s*)?", "R": ""}  # before an assignment
DECLARED = re.compile(r"DEF\s+(?:REAL|INT|BOOL)\s+")
# An innermost bracket, no argument of a function, with a sign before it if that is not one of the expression.
BRACKET = re.compile(r"(?:(?<=[A-Z=\[(])\s*([-+])\s*)?(?<![A-Z]{2})\[([^\[\]]*)\]")


class Variables:
    """What the variables of a program are."""

    def __init__(self, kind: str, words: Words) -> None:
        """`kind` is one of `NAMES`, or nothing; `words` are all that the control has."""
        self.kind, self.words = kind, words
        self.values: dict[str, float] = {}
        self.declared: set[str] = set()
        if kind:
            name = NAMES[kind]
            self.assignment = re.compile(rf"{MARK[kind]}({name})\s*=\s*([^;=]*?)(?=\s+(?:{name})\s*=|$)")
            # A sign behind a letter is one of the number, behind a number one of the expression.
            before = r"(?<![\w.])" if kind == "R" else ""
            self.used = re.compile(rf"((?<=[A-Z=\[(,])[-+]|){before}({name})(?!\s*=)")

    def line(self, body: str) -> str:
        """Return a line without its assignments, and with numbers for variables; `InputError` if that cannot be."""
        if not self.kind:
            return body
        if self.kind == "R" and (match := DECLARED.match(body)):
            body = self.declare(body[match.end() :])
        while (match := self.assignment.match(body)) and self.assigns(match[1], match[0]):
            self.assign(match[1], match[2])
            body = body[match.end() :].lstrip()
        if self.moves_nothing(body):
            return body
        body = self.used.sub(self.number_of, body)
        if body.count("[") > MOST_BRACKETS:
            raise InputError("", f"at most {MOST_BRACKETS} brackets in a line", f"{body.count('[')}")
        while self.kind == "#" and (found := BRACKET.search(body)):
            body = body[: found.start()] + _text(value_of(f"{found[1] or ''}({found[2]})")) + body[found.end() :]
        if self.kind == "R" and '"' not in body:
            body = re.sub(r"(?<=[A-Z0-9]=)[-+\d.*/()]+(?=\s|$)", _evaluated, body)
        return body

    def declare(self, names: str) -> str:
        """Keep the names that DEF declares; those that it gives a number are left, as assignments."""
        parts = [part.strip() for part in names.split(",")]
        for part in parts:
            name = re.match(r"[A-Z_]\w*(?=\s*(?:=|$))", part)
            if not name:
                raise InputError("", "names of variables behind DEF", repr(part))
            self.declared.add(name[0])
        return " ".join(part for part in parts if "=" in part)

    def assigns(self, name: str, text: str) -> bool:
        """Whether an equals sign gives a variable a number, and does not belong to a word of the control."""
        if self.kind == "R" and not re.fullmatch(r"R\d+", name):
            return name in self.declared
        word = self.words.begins(text)
        return word is None or not word.meaning.startswith("cycle ")

    def moves_nothing(self, body: str) -> bool:
        """Whether a line is one word that moves no axis: its variables, as in CYCLE832, do not matter."""
        word = self.words.begins(body)
        return word is not None and word.text == body and word.meaning == "skip"

    def assign(self, name: str, text: str) -> None:
        """Give a variable its number."""
        if re.fullmatch(SYSTEM, name):
            raise InputError("", "a variable of the program: the control's own may move its coordinates", name)
        self.values[name] = value_of(self.used.sub(self.number_of, text.replace(" DIV ", "/")))

    def number_of(self, found: re.Match[str]) -> str:
        """The number in the place of a variable; its name as it is, if it has none."""
        if found[2] not in self.values:
            return found[0]
        value = self.values[found[2]]
        return _text(-value if found[1] == "-" else value)


def value_of(text: str) -> float:
    """Return the number that an expression of numbers is; `InputError` if it is more than that.

    Examples
    --------
    >>> value_of("[+8 - 2] * -1.5")
    -9.0
    """
    plain = re.sub(r"(?<![\d.])0+(?=\d)", "", text.strip()).replace("[", "(").replace("]", ")")
    if len(plain) <= LONGEST and re.fullmatch(r"[-+*/() .\d]+", plain):
        try:
            return _value(ast.parse(plain, mode="eval").body)
        except (SyntaxError, KeyError, ZeroDivisionError, OverflowError, RecursionError, MemoryError):
            pass
    raise InputError("", "an expression of numbers, + - * / and brackets", repr(text.strip()[:LONGEST]))


def _value(node: ast.AST) -> float:
    if isinstance(node, ast.Constant) and isinstance(node.value, int | float):
        return float(node.value)
    if isinstance(node, ast.UnaryOp):
        return OPERATIONS[type(node.op)](_value(node.operand))
    if isinstance(node, ast.BinOp):
        return OPERATIONS[type(node.op)](_value(node.left), _value(node.right))
    raise KeyError(node)


def _evaluated(found: re.Match[str]) -> str:
    return found[0] if re.fullmatch(NUMBER, found[0]) else _text(value_of(found[0]))


def _text(value: float) -> str:
    """A number with its point, so that it counts in mm and degrees."""
    return f"{value:z.{DIGITS}f}".rstrip("0")
