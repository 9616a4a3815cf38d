"""Lookups as references: INDEX, MATCH, VLOOKUP and the like, with a key that is typed, name a cell of a table.

The check looks at what that cell becomes; that a lookup finds another cell than it should is a wrong reference.
And an IF that texts or empty cells decide, as of a row that is not filled in, is what it decides for.
"""

from __future__ import annotations

import operator as op
from collections.abc import Callable
from dataclasses import replace
from typing import Any

from mathpost.teaching.workbook.sheet.formula import Area, Tree
from mathpost.teaching.workbook.sheet.place import Place

HOLDS = {
    "ISBLANK": lambda value: value == "",
    "ISNUMBER": lambda value: isinstance(value, float),
    "ISTEXT": lambda value: isinstance(value, str) and value != "",
}
Held = Callable[[Place], Any]  # what is typed at a place
Lookup = Callable[..., Tree | None]  # of a `Held` and the arguments: a reference, or None
COMPARED = {"=": op.eq, "<>": op.ne, "<": op.lt, ">": op.gt, "<=": op.le, ">=": op.ge}


def resolved(tree: Tree, held: Held) -> Tree:
    """Return a tree with a reference for every lookup that finds a cell; `held(place)` is what is typed there.

    Examples
    --------
    >>> from mathpost.teaching.workbook.sheet.formula import parse
    >>> from mathpost.teaching.workbook.sheet.tree import text_of
    >>> held = {("S", 1, 1): "P1", ("S", 2, 1): "P2"}.get
    >>> text_of(resolved(parse('=SIN(VLOOKUP("p2",A1:B9,2,FALSE))', "S", {}), held))
    'SIN(B2)'
    """
    tree = tuple(resolved(part, held) if isinstance(part, tuple) else part for part in tree)
    try:
        return FOUND[tree[0]](held, *tree[1:]) or tree
    except (
        AttributeError,
        LookupError,
        TypeError,
        ValueError,
        OverflowError,
        StopIteration,
    ):  # no lookup, or nothing is found
        return tree


def _held(held: Held, tree: Tree) -> float | str:
    """A number or a text, in lower case, that is typed in a formula or in the cell to which it refers.

    Or how many cells hold a number, or anything, which row or column a cell is in, how long a text is.
    """
    if tree[0] in ("COUNT", "COUNTA"):
        values = [_plain(held(place)) for _, area in tree[1:] for place in area.places]
        return float(sum(isinstance(v, float) or (tree[0] == "COUNTA" and v != "") for v in values))
    if tree[0] in ("ROW", "COLUMN"):
        return float(tree[1][1].top if tree[0] == "ROW" else tree[1][1].left)
    if tree[0] == "LEN":
        return float(len(str(_held(held, tree[1]))))
    if tree[0] == "area" and tree[1].shape == (1, 1):
        return _plain(held(tree[1].places[0]))
    return _plain({"number": tree[1], "text": tree[1]}[tree[0]])


def _plain(value: Any) -> float | str:
    return value.lower() if isinstance(value, str) else float(value)


def _number(held: Held, tree: Tree) -> int:
    number = _held(held, tree)
    if isinstance(number, str):
        raise ValueError
    return int(number)


def _position(held: Held, key: Tree, area: Area, kind: int = 1) -> int:
    """The index, from 0, of a key in a row or a column: an equal one for `kind` 0, else the last not beyond it."""
    sought, cells = _held(held, key), [held(place) for place in area.places]
    values: list[Any] = [None if value in (None, "") else _plain(value) for value in cells]
    if kind == 0:
        return values.index(sought)
    alike = [n for n, value in enumerate(values) if type(value) is type(sought)]
    return next(n for n in alike[::-1] if (values[n] <= sought if kind > 0 else values[n] >= sought))


def _match(held: Held, key: Tree, table: Tree, kind: Tree = ("number", 1.0)) -> Tree:
    return "number", float(_position(held, key, table[1], _number(held, kind)) + 1)


def _index(held: Held, table: Tree, row: Tree, column: Tree | None = None) -> Tree | None:
    area, down = table[1], _number(held, row)
    if column is None:
        down, right = (1, down) if area.shape[0] == 1 else (down, int(area.shape[1] == 1))  # 0 is all of them
    else:
        right = _number(held, column)
    if not (0 <= down <= area.shape[0] and 0 <= right <= area.shape[1]):
        return None
    rows = (area.top + down - 1,) * 2 if down else (area.top, area.bottom)
    columns = (area.left + right - 1,) * 2 if right else (area.left, area.right)
    return "area", Area(area.sheet, rows[0], columns[0], rows[1], columns[1])


def _offset(held: Held, table: Tree, *steps: Tree) -> Tree:
    """The range so many rows and columns further, and of so many."""
    numbers = [_number(held, step) for step in steps]
    area = table[1].moved(*numbers[:2])
    rows, columns = (numbers[n] if n < len(numbers) else area.shape[n - 2] for n in (2, 3))
    if min(rows, columns) < 1:
        raise ValueError
    return "area", replace(area, bottom=area.top + rows - 1, right=area.left + columns - 1)


def _along(across: bool) -> Lookup:
    """VLOOKUP, or HLOOKUP, `across` the table."""

    def find(held: Held, key: Tree, table: Tree, number: Tree, near: Tree = ("number", 1.0)) -> Tree | None:
        area, wanted = table[1], _number(held, number)
        line = replace(area, **({"bottom": area.top} if across else {"right": area.left}))
        kind = _held(held, near)
        where = _position(held, key, line, int(isinstance(kind, float) and kind != 0)) + 1
        place = (wanted, where) if across else (where, wanted)
        return _index(held, table, *(("number", float(n)) for n in place))

    return find


def _beside(kind: int) -> Lookup:
    """XLOOKUP, or LOOKUP, which takes the last entry not beyond the key: the entry of another area beside it."""

    def find(held: Held, key: Tree, keys: Tree, table: Tree, *_: Tree) -> Tree | None:
        where, whole = ("number", _position(held, key, keys[1], kind) + 1.0), ("number", 0.0)
        return _index(held, table, *((where, whole) if keys[1].shape[1] == 1 else (whole, where)))

    return find


def _if(held: Held, test: Tree, yes: Tree, no: Tree = ("number", 0.0)) -> Tree | None:
    """The part of an IF that texts or empty cells decide."""
    decided = _decided(held, test)
    return None if decided is None else yes if decided else no


def _decided(held: Held, test: Tree) -> bool | None:
    """Whether a condition holds; None if numbers decide that, which are inputs."""
    head, *parts = test
    if head == "number":
        return parts[0] != 0
    if head == "NOT":
        decided = _decided(held, *parts)
        return None if decided is None else not decided
    if head in ("AND", "OR"):
        truths, enough = [_decided(held, part) for part in parts], head == "OR"
        return enough if enough in truths else None if None in truths else not enough
    values: list[Any] = [_held(held, part) for part in parts]
    if head in HOLDS:
        return HOLDS[head](*values)
    texts = [isinstance(value, str) for value in values]
    counts = any(part[0] in ("COUNT", "COUNTA", "LEN") for part in parts)
    if sum(texts) == 1:  # an empty cell is 0 beside a number, and every text is beyond every number
        is_empty = any(value == "" and part[0] == "area" for part, value in zip(parts, values, strict=True))
        return None if is_empty else COMPARED[head](*texts)
    return COMPARED[head](*values) if counts or all(texts) else None


def _comparison(head: str) -> Lookup:
    """A comparison that texts or empty cells decide, as the number that it is in arithmetic."""

    def truth(held: Held, *parts: Tree) -> Tree | None:
        decided = _decided(held, (head, *parts))
        return None if decided is None else ("number", float(decided))

    return truth


FOUND: dict[str, Lookup] = {
    **{head: _comparison(head) for head in COMPARED},
    "IF": _if,
    "MATCH": _match,
    "INDEX": _index,
    "OFFSET": _offset,
    "VLOOKUP": _along(across=False),
    "HLOOKUP": _along(across=True),
    "XLOOKUP": _beside(0),
    "LOOKUP": _beside(1),
    "CHOOSE": lambda held, number, *values: dict(enumerate(values, 1))[_number(held, number)],
}
