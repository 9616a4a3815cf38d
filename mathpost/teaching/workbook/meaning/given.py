"""Which cells of a sheet are given, and which are matrices with their zeros and ones: told by who uses them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Sequence
from itertools import product, takewhile
from typing import TYPE_CHECKING

import numpy as np

from mathpost.teaching.workbook.meaning.label import read_label
from mathpost.teaching.workbook.sheet.edits import TRIGONOMETRY
from mathpost.teaching.workbook.sheet.place import offset
from mathpost.teaching.workbook.sheet.tree import CONVERSIONS, areas, heads, parts_of

if TYPE_CHECKING:
    from mathpost.teaching.workbook.sheet.graph import Graph
    from mathpost.teaching.workbook.sheet.place import Line, Place

PASSED_ON = {"RADIANS", "DEGREES", "PI", "MOD", "ROUND", "ATAN"}  # 4·ATAN(1) is π


class Given:
    """The numbers of a workbook.

    `typed` are the places of numbers, and of formulas such as =RADIANS(20) that use no cell; `turning` go into a
    sine or cosine; `composed` are angles that a formula makes of other numbers. `windows` are matrices, row by row.
    The recognised `angles` and `lengths` are inputs; the rotation is of the `sequence`.
    """

    windows: list[Line]
    angles: set[Place]
    lengths: set[Place]
    sequence: str

    def __init__(self, graph: Graph, *, with_formulas: bool = True) -> None:
        self.graph = graph
        texts = [c.value for c in graph.cells.values() if isinstance(c.value, str) and not c.formula]
        self.text = "\n".join(texts)
        self.typed = {p for p in graph.component if p not in graph.trees and graph.value(p) is not None}
        self.typed |= {p for p in graph.trees if not graph.uses[p]} - graph.messages
        self.turning, composed = self._turning()
        self.composed = composed if with_formulas else set()
        self.typed |= self.composed

    def sorted(self, places: Iterable[Place]) -> Line:
        """Places as they are read."""
        return tuple(sorted(places, key=self.graph.reading_order))

    def matrices(self) -> list[Line]:
        graph = self.graph
        found: Counter[Line] = Counter()
        for _, part in graph.parts:
            if part[0] in ("MMULT", "TRANSPOSE", "MDETERM", "MINVERSE"):
                found.update(tuple(a.places) for a in areas(part) if a.shape in ((3, 3), (4, 4)))
        for anchor in dict.fromkeys((p[0], *graph.cells[p].anchor) for p in graph.part):
            array = graph.array(anchor)
            if len(array) in (9, 16) and len({p[1] for p in array}) == len({p[2] for p in array}):
                found[tuple(self.sorted(array))] += 1
        for component in graph.components:
            sides = [len({p[n] for p in component}) for n in (1, 2)]
            size = min(sides)
            along = 0 if sides[0] > sides[1] else 1
            if size not in (3, 4) or max(sides) % size or len(component) != sides[0] * sides[1]:
                continue
            for k in range(0, max(sides) if max(sides) <= 3 * size else 0, size):
                tile = tuple(p for p in component if 0 <= p[1:][along] - component[0][1:][along] - k < size)
                uses = [graph.uses[p] for p in tile if p in graph.trees]
                # Three points in rows use numbers typed in their own row; a matrix does not.
                own = [any(s[1] == p[1] and s in self.typed for s in graph.uses.get(p, [p])) for p in tile]
                if max(sides) == size or (len(uses) >= 2 and not all(own)):
                    found[tile] = 99
        for component in graph.components:  # nine elements in one line
            for line in runs([p for p in component if p in graph.trees or graph.value(p) in (0, 1)]):
                numbers = [number for p in line if (number := graph.own.get(p)) is not None]
                if len(line) == len(numbers) == 9 and any(p in graph.trees for p in line) and may_turn(numbers):
                    found[line] = 1
        for window, votes in list(found.items()):
            others = [o for o in found if o != window and found[o] >= votes and found[o] > 1]
            numbers = [number for p in window if p not in graph.trees and (number := graph.value(p)) is not None]
            # A matrix has formulas, or else numbers such as cosines and sines make: it is no table of points.
            table = len(numbers) == len(window) and (all(n % 1 == 0 for n in numbers) or not may_turn(numbers))
            table &= numbers != [float(n % 4 == 0) for n in range(9)]  # the unit matrix
            large = {p for p in window if p in self.typed and abs(graph.own[p] or 0.0) > 1}
            table |= len(large) > (1 if len(window) == 9 else 3)
            table |= any(len({p[n] for p in large}) == 1 for n in (1, 2)) and len(large) > 2
            values = [graph.own.get(p) for p in window]
            trees = [graph.tree(p) for p in window]  # differences of two matrices are none
            table |= all(tree[0] == "-" and tree[1][0] == tree[2][0] == "area" for tree in trees)
            table |= len(window) == 16 and [0, 0, 0, 1] not in (values[12:], values[3::4])
            overlaps = any(not set(window).isdisjoint(other) for other in others)
            if table or overlaps or self.turning & set(window) or not graph.component.keys() >= set(window):
                del found[window]
        return sorted(found, key=lambda w: graph.reading_order(w[0]))

    def _turning(self) -> tuple[set[Place], set[Place]]:
        """What goes into a sine or cosine, directly or through cells that only convert or negate.

        And the `composed` of these: angles that a formula makes of other numbers, as of degrees and minutes.
        """
        graph, found, composed = self.graph, set(), set()
        stack = [p for _, part in graph.parts if part[0] in (*TRIGONOMETRY, "TAN") for p in graph.used_by(part)]
        while stack:
            place = stack.pop()
            if place in found:
                continue
            found.add(place)
            sources = graph.uses.get(place, ())
            if sources and {head for head in heads(graph.trees[place]) if head.isupper()} <= PASSED_ON:
                only = len(sources) == 1 or (len(sources) == 2 and any(map(self._converts, sources)))
                if only and (any(self._passes_on(place, p) for p in sources)):
                    stack += sources
                    continue
            above = graph.upstream(sources) & graph.trees.keys()
            if sources and not any(heads(graph.trees[p]) & TRIGONOMETRY.keys() for p in (place, *above)):
                composed.add(place)
        for place in self.sorted(found):  # an angle that is made by a formula and then negated
            if graph.tree(place)[0] == "minus" and composed.issuperset(graph.uses[place]):
                composed = composed - set(graph.uses[place]) | {place}
        if len(found & self.typed) > 2:  # half the sum of two angles, as a quaternion takes it, is none of its own
            composed = {p for p in composed if len(graph.uses[p]) == 1 or not found.issuperset(graph.uses[p])}
        return found, composed

    def _passes_on(self, place: Place, source: Place) -> bool:
        """Whether a formula gives a number that it uses, but for its sign, its unit and a factor of two."""
        steps = np.array([0.0, 1.0, 300.0])  # one within a turn in radians, one beyond what is lost by rounding
        own = {p: np.full(3, number) for p, number in self.graph.own.items() if number is not None}
        zero, *others = self.graph.cell(place, own | {source: steps}) * np.ones(3)
        factors = np.outer((0.5, 1, 2), (1.0, *CONVERSIONS, *(1 / CONVERSIONS)))
        slopes = np.abs(others / steps[1:])[:, None, None]
        return abs(zero) < 1e-9 and bool((abs(slopes - factors) < 0.02 * factors).any())

    def _converts(self, place: Place) -> bool:
        """Whether a number that is given is 1, π, 180 or one such as π/180, or minus that."""
        factors = np.array([1.0, *CONVERSIONS])
        near = np.abs(abs(self.graph.own.get(place) or 0.0) - factors) < 1e-4 * factors
        return place in self.typed and bool(near.any())

    def _scales(self, place: Place, source: Place) -> bool:
        """Whether a formula multiplies or divides by a cell."""
        parts = (part for part in parts_of(self.graph.tree(place)) if part[0] in ("*", "/"))
        return any(child[0] == "area" and source in child[1].places for _, *inner in parts for child in inner)

    def never_moved(self) -> set[Place]:
        """Typed numbers that are not given: zeros and ones of matrices, numbers over formulas, conversions."""
        graph, found = self.graph, self.typed & {p for window in self.windows for p in window}
        for place in self.sorted(self.turning & self.typed):  # 180 or π multiplies or divides several others
            users = [p for p in graph.used.get(place, ()) if self._scales(p, place)]
            partners = {s for user in users for s in graph.uses[user]} - {place}
            found |= {place} if self._converts(place) and min(len(users), len(partners)) >= 2 else set()
        given = self.typed & graph.used.keys() - self.turning - found
        for place, (down, right) in product(self.sorted(given), ((1, 0), (0, 1))):  # (x, y, z, 1), or (0, x, y, z)
            line = [offset(place, n * down, n * right) for n in range(-1, 5)]
            if [p in given for p in line] == [False, True, True, True, True, False]:
                found |= {line[4]} if graph.own[line[4]] == 1 else set()
        for area in dict.fromkeys(area for _, part in graph.parts if part[0] == "MMULT" for area in areas(part)):
            ends = {area.places[-1]} if sorted(area.shape) == [1, 4] else set()  # (x, y, z, 1) among others
            found |= {p for p in ends & given if graph.own[p] == 1}
        for whole in graph.components:
            formulas = [p for p in whole if p in graph.trees and p not in self.typed]
            homogeneous = len(whole) == 4 and formulas and graph.own[whole[-1]] == 1
            if homogeneous or any(not self.turning.isdisjoint(graph.upstream([p])) for p in formulas):
                typed = self.typed - self.composed - found
                found |= {p for p in whole if p in typed and not self._in_typed_line(p, whole)}
        return found

    def _in_typed_line(self, place: Place, whole: Line) -> bool:
        """Whether a typed number among formulas is given, not typed over one: three of its kind are in line."""
        for n in (1, 2):  # three rows or columns side by side hold numbers only, as those of points
            at = place[1:][n - 1]
            lines = {p[n] for p in whole} - {p[n] for p in whole if p not in self.typed}
            if any(lines.issuperset(range(first, first + 3)) for first in range(at - 2, at + 1)):
                return True
        for down, right in ((1, 0), (0, 1)):
            line = [place]
            for sign in (1, -1):
                near = place
                while self.graph.component.get(near := offset(near, sign * down, sign * right)) is whole:
                    line.append(near)
            typed = sum(p in self.typed for p in line)
            row = {p in self.typed for p in whole if p[1] == place[1] and p != place} if down else ()
            if typed == 1 < len(line) and len(row) == 2:
                return False
            own = {p: abs(self.graph.number(p)) for p in whole if p in self.typed}
            units = sum(number in (0, 1) for number in own.values())
            if typed >= 3 and (units < 6 or any(own.get(p, 0) not in (0, 1) for p in line)):
                # A quaternion of a turn about one axis has two zeros.
                return not (len(line) == 4 > typed and sum(own.get(p) == 0 for p in line) >= 2)
            if len(line) in (3, 4) and sum(p in self.turning and p not in self.typed for p in line) >= 2:
                return False
        return place in self.turning

    def lines(self, cells: Collection[Place], least: int) -> list[Line]:
        """Triples of evenly spaced typed cells of which at least `least` are in `cells`, the fullest first."""
        found, steps = {}, [way for step in range(1, 11) for way in ((step, 0), (0, step))]
        for place, (down, right) in product(self.sorted(self.typed.intersection(cells)), steps):
            line = [offset(place, n * down, n * right) for n in range(-2, 3)]
            for triple in (tuple(line[n : n + 3]) for n in range(3) if self.typed.issuperset(line[n : n + 3])):
                count = sum(p in cells for p in triple)
                if count < least:
                    continue
                within = [offset(triple[0], n * (down > 0), n * (right > 0)) for n in range(1, 2 * (down + right))]
                # A number within that nobody uses tells that the formula which did is lost.
                count -= any(p in self.typed and p not in self.graph.used for p in within if p not in triple)
                ends = map(self.graph.reading_order, (triple[0], triple[-1]))
                found[triple] = (-count, down + right, *ends)  # in rows first, whatever the order of sets
        return sorted(found, key=lambda triple: found[triple])

    def label(self, place: Place) -> str:
        """The text to the left of a cell or above it, the first that names something; empty if there is none."""
        texts = self.texts(place)
        return next(filter(read_label, texts), next(iter(texts), ""))

    def texts(self, place: Place) -> list[str]:
        """The texts to the left of a cell and above it, the nearest first."""
        cells = self.graph.cells
        left = [cells[p] for n in (1, 2) if (p := offset(place, 0, -n)) in cells][:1]
        above = takewhile(lambda cell: cell, (cells.get(offset(place, -n, 0)) for n in range(1, 60)))
        along = takewhile(lambda cell: cell, (cells.get(offset(place, 0, -n)) for n in range(2, 60)))
        near = (*left, *above, *along)
        return [cell.value for cell in near if cell and isinstance(cell.value, str)]


def may_turn(numbers: Sequence[float] | np.ndarray) -> bool:
    """Whether nine or sixteen numbers may be a rotation with a mistake: two of its rows are nearly unit vectors."""
    rows = np.reshape(numbers, (3 if len(numbers) == 9 else 4, -1))[:3, :3]
    return (np.abs(np.linalg.norm(rows, axis=1) - 1) < 0.05).sum() > 1


def runs(places: Iterable[Place]) -> Iterator[Line]:
    """The longest lines of cells side by side, in rows and in columns."""
    for along, order in ((1, lambda p: p), (2, lambda p: (p[0], p[2], p[1]))):
        lines: list[list[Place]] = []
        for place in sorted(places, key=order):
            if not lines or place != offset(lines[-1][-1], along == 2, along == 1):
                lines.append([])
            lines[-1].append(place)
        yield from map(tuple, lines)
