"""Forks: the parts of formulas that take one of several ways, and which ways no sample takes.

A condition, a MAX, an ABS, a MOD and a lookup are such parts.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from mathpost.teaching.workbook.reference.quantities import Dictionary, Sheet
from mathpost.teaching.workbook.sheet.evaluate import COMPARISONS, CONDITIONS
from mathpost.teaching.workbook.sheet.formula import Area, NotUnderstood, Tree
from mathpost.teaching.workbook.sheet.place import Place
from mathpost.teaching.workbook.sheet.samples import Values
from mathpost.teaching.workbook.sheet.tree import areas, heads, parts_of, text_of, walk, with_areas

MOST_WAYS = 12  # of one formula that are looked for
SELECTED = range(1, 10)  # by a number that selects
LOOKUPS = {
    "MATCH": 0,
    "VLOOKUP": 1,
    "HLOOKUP": 1,
    "LOOKUP": 9,
    "XLOOKUP": 9,
}  # which part after the list is the kind
EXTREMES = {"MAX": np.argmax, "MIN": np.argmin}
SIGNS, EQUALITIES = {"ABS", "SIGN"}, {"=", "<>"}
BRANCHING = {*COMPARISONS, *EXTREMES, *SIGNS, *LOOKUPS, "IF", "MOD", "CHOOSE"}


@dataclass(frozen=True)
class Fork:
    """A part of a formula that takes one of several ways, at one of the cells that it asks about."""

    sheet: Sheet
    place: Place
    tree: Tree
    guards: tuple[tuple[Tree, bool], ...] = ()  # conditions within which it stands, and what they must be
    spot: int = 0

    def ways(self, values: Values) -> np.ndarray:
        """The number of the way that is taken, shape (samples,) or (1,); NaN where there is none."""
        ways = self._ways(values)
        for condition, wanted in self.guards:
            holds = self.sheet.calculate(condition, values)[:, 0, 0]
            ways = np.where(np.isfinite(holds) & ((holds != 0) == wanted), ways, np.nan)
        return ways

    def _ways(self, values: Values) -> np.ndarray:
        head, *parts = self.tree
        try:
            if head in EXTREMES:
                cells = self._numbers(values)
                return np.where(np.isfinite(cells).all(axis=1), EXTREMES[head](cells, axis=1), np.nan)
            found = [self.sheet.calculate(part, values) for part in parts]
            if head in LOOKUPS:
                return self._row_found(*found)
            if head in COMPARISONS:
                off = np.subtract(*found[:2])
                way = np.where(np.isnan(off), np.nan, off == 0) if head in EQUALITIES else np.sign(off)
            elif head in SIGNS:
                way = np.sign(found[0])
            else:
                way = np.floor(np.divide(*found)) if head == "MOD" else found[0]
                way = np.where(np.isnan(way), np.nan, way != 0) if head == "IF" else np.floor(way)
        except (NotUnderstood, ValueError, IndexError, TypeError):
            return np.full(1, np.nan)
        return way.reshape(len(way), -1)[:, self.spot]

    def _numbers(self, values: Values) -> np.ndarray:
        """What a MAX or MIN takes one of, shape (samples, numbers)."""
        sheet, parts = self.sheet, self.tree[1:]
        found = [
            sheet.look(part[1], values, "left out") if part[0] == "area" else sheet.calculate(part, values)
            for part in parts
        ]
        samples = max(map(len, found))
        return np.hstack([np.broadcast_to(v.reshape(len(v), -1), (samples, v[0].size)) for v in found])

    def _row_found(self, key: np.ndarray, table: np.ndarray, *more: np.ndarray) -> np.ndarray:
        """The row, from 1, that a lookup finds."""
        head = self.tree[0]
        keys = table[:, :, :1] if head == "VLOOKUP" else table[:, :1] if head == "HLOOKUP" else table
        kind = [*more[LOOKUPS[head] :], np.full((1, 1, 1), float(head != "XLOOKUP"))][0]
        return self.sheet.functions["MATCH"](key, keys, kind)[:, 0, 0]

    def not_taken(self, values: Values) -> Iterator[Missing]:
        """Yield the ways that no sample takes."""
        head, *parts = self.tree
        seen = {float(way) for way in np.unique(self.ways(values)) if np.isfinite(way)}
        if not np.isfinite(self._ways(values)).any():
            return
        wanted: Iterable[float | None] = (0.0, 1.0)
        if head in EXTREMES or head in LOOKUPS:
            count = self._numbers(values).shape[1] if head in EXTREMES else max(self._list().shape)
            numbers = np.linspace(0, count - 1, min(count, MOST_WAYS)).round() + (head in LOOKUPS)
            wanted = numbers.tolist()
        elif head == "CHOOSE":
            wanted = [float(n) for n in range(1, len(parts))]
        elif head == "MOD":
            wanted = [None] * (len(seen) == 1)
        elif head in SIGNS or (head in COMPARISONS and head not in EQUALITIES):
            wanted = (-1.0, 1.0, *[0.0] * (head in COMPARISONS and all(map(self._is_whole, parts))))
        yield from (Missing(self, way, min(seen, default=np.nan)) for way in wanted if way not in seen)

    def _is_whole(self, part: Tree) -> bool:
        """Whether a part of a formula is a whole number that is typed, which may be just the limit."""
        if part[0] == "area" and part[1].shape == (1, 1):
            number = self.sheet.numbers_typed.get(part[1].places[0])
            return number is not None and number == int(number)
        return part[0] == "number" and part[1] == int(part[1])

    def _list(self) -> Area:
        """The cells in which a lookup looks for its key."""
        head, _, table, *_ = self.tree
        if table[0] != "area":
            return Area("", 1, 1, 1, 1)
        area = table[1]
        return replace(area, **({"VLOOKUP": {"right": area.left}, "HLOOKUP": {"bottom": area.top}}.get(head, {})))

    def off(self, values: Values, way: float | None) -> np.ndarray | None:
        """What is 0 where a way begins, shape (samples,), if one number says that."""
        head, *parts = self.tree
        with suppress(NotUnderstood, ValueError, IndexError):
            first = self.sheet.calculate(parts[0], values)
            if head in COMPARISONS:
                off = first - self.sheet.calculate(parts[1], values)
                return off.reshape(len(off), -1)[:, self.spot]
            if head in LOOKUPS and way is not None:
                return (first - self.sheet.look(self._list(), values).reshape(-1)[int(way) - 1])[:, 0, 0]
            if head in SIGNS or head in ("IF", "CHOOSE"):
                return first[:, 0, 0] - (way if head == "CHOOSE" and way is not None else 0.0)
        return None

    def said(self, way: float) -> str:
        """What was compared, where only one way is taken."""
        head, *parts = self.tree
        tree = text_of(self.tree, self.place[0])
        if head in COMPARISONS and np.isfinite(way):
            left, right = (text_of(part, self.place[0]) for part in parts)
            sign = ("≠", "=")[int(way)] if head in EQUALITIES else {-1: "<", 0: "=", 1: ">"}[int(way)]
            return f"only the branch {left} {sign} {right}"
        return f"not all ways through {tree}"


@dataclass(frozen=True)
class Missing:
    """A way of a fork that no sample takes, or any but the one that is `seen`, if it has no number."""

    fork: Fork
    way: float | None
    seen: float

    def goes_with(self, other: Missing) -> bool:
        """Whether it is the same of a cell to which the same formula is filled."""
        a, b = self.fork, other.fork
        same = a.sheet is b.sheet and a.tree[0] == b.tree[0] and (self.way, self.seen) == (other.way, other.seen)
        return same and (a.place == b.place or a.sheet.relative(a.place) == b.sheet.relative(b.place))

    def taken(self, values: Values) -> np.ndarray:
        """At which samples it is taken."""
        ways = self.fork.ways(values)
        return ways == self.way if self.way is not None else np.isfinite(ways) & (ways != self.seen)


def forks(sheet: Sheet, cells: Iterable[Place], known: set[str], names: Dictionary, values: Values) -> list[Fork]:
    """The forks in the formulas that some cells depend on, but for formulas that are `known`, by `names`."""
    found: list[Fork] = []
    for place in sorted(sheet.upstream(cells) & sheet.trees.keys(), key=sheet.reading_order):
        tree = sheet.trees[place]
        if sheet.part.get(place, (0, 0)) != (0, 0) or heads(tree).isdisjoint(BRANCHING):
            continue
        if named(tree, names, sheet, values) in known:
            continue
        for path, part in walk(tree):
            asks = part[0] in BRANCHING and not (part[0] == "IF" and part[1][0] in {*COMPARISONS, *CONDITIONS})
            if asks and not (part[0] in COMPARISONS and any(each[0] == "text" for each in part[1:])):
                sizes = [sheet.calculate(each, values)[0].size for each in part[1:] if part[0] in COMPARISONS]
                spots = max(sizes, default=1)
                guards = tuple(_guards(tree, path))
                found += [Fork(sheet, place, part, guards, spot) for spot in range(min(spots, MOST_WAYS))]
    return found


def _guards(tree: Tree, path: Sequence[int]) -> Iterator[tuple[Tree, bool]]:
    """Yield the conditions that decide whether a part of a formula is what it gives."""
    for step in path:
        if tree[0] == "IF" and step > 1:
            yield tree[1], step == 2
        elif tree[0] == "IFS":
            yield from ((tree[n], n == step - 1) for n in range(1, step, 2))
        tree = tree[step]


def selectors(sheet: Sheet) -> set[Place]:
    """The whole numbers that are compared with others, such as a kind 1 or 2, or of which a CHOOSE takes one."""
    found = set()
    for tree in {id(t): t for t in sheet.trees.values()}.values():
        for part in parts_of(tree):
            chosen = [*part[1:2]] if part[0] == "CHOOSE" else []
            if part[0] in EQUALITIES:
                chosen = [a for a, b in (part[1:], part[:0:-1]) if b[0] == "number" and b[1] in SELECTED]
            found |= {p for each in chosen if each[0] == "area" for p in each[1].places}
    return {p for p in found if sheet.numbers_typed.get(p) in SELECTED}


def not_compared(missing: Sequence[Missing]) -> Iterator[str]:
    """Yield what was not compared, in words, cells of one formula together."""
    groups: dict[tuple, dict[Place, Missing]] = {}
    for each in missing:
        fork = each.fork
        kind = fork.sheet.relative(fork.place) or fork.place, fork.tree[0], each.seen
        groups.setdefault(kind, {}).setdefault(fork.place, each)
    for cells in groups.values():
        (first, *_) = cells.values()
        where = ", ".join(first.fork.sheet.ranges(cells))
        yield f"{where}: {first.fork.said(first.seen)} was compared"


def named(tree: Tree, names: Dictionary, sheet: Sheet, values: Values) -> str:
    """Write a formula with the names of the quantities in place of its references."""
    new: list[Any] = ["|".join(_name(place, names, sheet, values) for place in area.places) for area in areas(tree)]
    return text_of(with_areas(tree, new))


def _name(place: Place, names: Dictionary, sheet: Sheet, values: Values) -> str:
    value = values.get(place, sheet.constants.get(place))
    if value is None or np.isnan(value).all():
        return repr(sheet.cells[place].value if place in sheet.cells else "")
    if (value == value[0]).all():
        return f"{value[0]:.10g}"
    return str([*names.find(value), place][0])
