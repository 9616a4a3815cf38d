"""Trees of formulas: walked, changed, written as text."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from mathpost.teaching.workbook.sheet.formula import POWER

if TYPE_CHECKING:
    from mathpost.teaching.workbook.sheet.formula import Area, Tree
    from mathpost.teaching.workbook.sheet.place import Place

CONVERSIONS = np.array([np.pi, np.pi / 180, 180 / np.pi, 180.0, 2 * np.pi, np.pi / 200, 200 / np.pi])
ROUNDING = {"ROUND", "ROUNDDOWN", "ROUNDUP", "TRUNC", "INT"}
TEXTS = {"text", "&", "TEXT", "CONCAT", "CONCATENATE", "TEXTJOIN", "FIXED", "LEFT", "RIGHT", "MID", "REPT"}


def walk(tree: Tree, path: tuple[int, ...] = ()) -> Iterator[tuple[tuple[int, ...], Tree]]:
    """Yield every part of a tree with its path, a tuple of positions."""
    stack = [(path, tree)]
    while stack:
        path, tree = stack.pop()
        yield path, tree
        stack += [((*path, n), tree[n]) for n in range(len(tree) - 1, 0, -1) if type(tree[n]) is tuple]


def parts_of(tree: Tree) -> Iterator[Tree]:
    """Yield every part of a tree, itself first, in the order of `walk`."""
    stack = [tree]
    while stack:
        tree = stack.pop()
        yield tree
        stack += [part for part in tree[:0:-1] if type(part) is tuple]


def put(tree: Tree, path: tuple[int, ...], new: Tree) -> Tree:
    """Return the tree with the part at `path` replaced."""
    return (*tree[: path[0]], put(tree[path[0]], path[1:], new), *tree[path[0] + 1 :]) if path else new


def areas(tree: Tree) -> list[Area]:
    """Return the areas in a tree, in their order."""
    return [part[1] for part in parts_of(tree) if part[0] == "area"]


def used_areas(tree: Tree) -> Iterator[Area]:
    """Yield the areas of which a formula uses what they hold, and not only where they are."""
    stack = [tree]
    while stack:
        tree = stack.pop()
        if tree[0] == "area":
            yield tree[1]
        elif tree[0] not in ("ROW", "COLUMN"):
            stack += [part for part in tree[:0:-1] if type(part) is tuple]


def with_areas(tree: Tree, new: Iterable[Area]) -> Tree:
    """Return the tree with the areas `new` in place of its own, in their order."""
    new = iter(new)

    def rebuilt(tree: Tree) -> Tree:
        if tree[0] == "area":
            return "area", next(new)
        return tuple([rebuilt(part) if type(part) is tuple else part for part in tree])

    return rebuilt(tree)


def gives_text(tree: Tree) -> bool:
    """Whether a formula always gives a text, and no number."""
    if tree[0] in ("IF", "IFERROR"):
        return all(map(gives_text, tree[-2:] if len(tree) > 3 or tree[0] == "IFERROR" else tree[2:]))
    return tree[0] in TEXTS


def heads(tree: Tree) -> set[str]:
    """Return the functions, operators and kinds of leaves in a tree."""
    return {part[0] for part in parts_of(tree)}


def text_of(tree: Tree, sheet: str | None = None) -> str:
    """Write a tree as a formula without its ``=``; as it is written in `sheet`, if given, with the other sheets."""
    head, *parts = tree
    if head == "area":
        return str(parts[0]) if sheet is None or parts[0].sheet == sheet else f"{parts[0].sheet}!{parts[0]}"
    if head in ("number", "text"):
        return {"number": "{:.15g}", "text": '"{}"'}[head].format(parts[0])
    if head in ("minus", "percent"):
        return f"-{_within(parts[0], 4, sheet)}" if head == "minus" else f"{_within(parts[0], 6, sheet)}%"
    if head == "criterion":
        return f"{text_of(parts[0], sheet)}&{text_of(parts[1], sheet)}"
    if head in POWER:
        return f"{_within(parts[0], POWER[head] - 1, sheet)}{head}{_within(parts[1], POWER[head], sheet)}"
    inner = (";" if head == "rows" else ",").join(text_of(part, sheet) for part in parts)
    return {"rows": f"{{{inner}}}", "row": inner}.get(head, f"{head}({inner})")


def unrounded(tree: Tree) -> Tree:
    """The tree without the last rounding of what it gives, to two decimals or more, or of a copy of a cell."""
    if tree[0] in ROUNDING and (tree[1][0] == "area" or (tree[2:] and tree[2][0] == "number" and tree[2][1] >= 2)):
        return tree[1]
    if tree[0] == "IF":
        return (*tree[:2], *map(unrounded, tree[2:]))
    return (tree[0], unrounded(tree[1]), *tree[2:]) if tree[0] == "MOD" else tree


def copied(tree: Tree) -> Iterator[Place]:
    """Yield the cells of which a formula is but a copy, either one or the other."""
    if tree[0] == "area" and tree[1].shape == (1, 1):
        yield tree[1].places[0]
    for part in tree[2:] if tree[0] == "IF" else ():
        yield from copied(part)


def exact(tree: Tree, within: float) -> Tree:
    """The tree with π, π/180 and the like for all numbers that are nearly these, relatively `within`.

    Examples
    --------
    >>> from mathpost.teaching.workbook.sheet.formula import parse
    >>> text_of(exact(parse("=A1*3.1416/180", "S", {}), 1e-5))
    'A1*3.14159265358979/180'
    """
    if tree[0] == "number":
        near = CONVERSIONS[np.abs(tree[1] - CONVERSIONS) < within * CONVERSIONS]
        return ("number", float(near[0])) if len(near) else tree
    return tuple(exact(part, within) if isinstance(part, tuple) else part for part in tree)


def form_of(tree: Tree) -> str:
    """Write a tree as a formula in which all references of one size are alike."""
    shapes: list[Any] = [area.shape for area in areas(tree)]
    return text_of(with_areas(tree, shapes))


def _within(tree: Tree, least: int, sheet: str | None) -> str:
    text = text_of(tree, sheet)
    return f"({text})" if POWER.get(tree[0], 9) <= least else text
