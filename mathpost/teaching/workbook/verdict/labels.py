"""Cells beside a calculation that are something known, but not what their labels say: they are listed."""

from __future__ import annotations

import re
from collections.abc import Iterator
from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from mathpost.rotation import wrap
from mathpost.teaching.workbook.meaning.calculation import Turn
from mathpost.teaching.workbook.meaning.given import runs
from mathpost.teaching.workbook.meaning.label import IN_RADIANS
from mathpost.teaching.workbook.meaning.vocabulary import wording
from mathpost.teaching.workbook.sheet.edits import INVERSE
from mathpost.teaching.workbook.sheet.place import Place, offset
from mathpost.teaching.workbook.sheet.samples import same
from mathpost.teaching.workbook.sheet.tree import heads, parts_of, text_of, unrounded
from mathpost.teaching.workbook.verdict.known import Known, has_angles, solutions

if TYPE_CHECKING:
    from mathpost.teaching.workbook.verdict.judge import Judge

LENGTH = rf"{wording('length')}|^\|[^|]*\|\W*$"
DISTANCE = rf"{wording('distance')}|\|"
NO_LENGTH = rf"{wording('of lengths', 'determinant')}|²|\^2|%|/|Δ"
DIFFERENCE = rf"{wording('difference')}|Δ"
BETWEEN_TWO, FROM_ZERO = wording("between two"), rf"{wording('from zero')}|\b[o0]\b"
STATISTIC = {
    "AVERAGE": wording("mean"),
    "SUM": wording("sum"),
    "MAX": wording("largest"),
    "MIN": wording("smallest"),
    "SQRT": wording("root mean square"),
}


class Labels:
    """What labels say of cells, by a `Judge` and what is `Known`."""

    def __init__(self, judge: Judge, known: Known) -> None:
        self.judge, self.graph, self.found, self.known = judge, judge.graph, judge.found, known
        self.plain: list[np.ndarray] = []
        self.lengths: list[np.ndarray] = []
        for turn in (c for c in judge.live if isinstance(c, Turn) and c.point):
            for end in (judge.block(turn.point), np.array([*turn.targets.values()][:3])):
                self.plain += [*end, np.linalg.norm(end, axis=0)]
                self.lengths += [] if turn.origin or turn.shift else self.plain[-1:]

    def doubts(self, rest: set[Place]) -> Iterator[Place]:
        """Yield the cells of `rest`, which no result needs, that are unlike their labels, or their order."""
        for place in self.found.sorted(rest & self.graph.trees.keys()):
            texts = self.found.texts(place)
            label = next(iter(texts), "")
            if (
                self._is_no_length(place, label)
                or self._is_no_difference(place, label)
                or self._is_no_statistic(place, self._in_row(place) + texts)
                or self._is_in_radians(place, texts)
            ):
                yield place
        yield from self._mixed({p: q for p in rest if (q := self._copied(p)) != p})
        yield from self._of_the_other_solution(rest)

    def _in_row(self, place: Place) -> list[str]:
        """The texts before a cell in its row."""
        cells = (self.graph.cells.get((*place[:2], column)) for column in range(1, place[2]))
        return [cell.value for cell in cells if cell and isinstance(cell.value, str)]

    def _is_no_length(self, place: Place, label: str) -> bool:
        """Whether what is said to be a length is none, has no root, or takes one number twice."""
        tree, now = self.graph.trees[place], self.judge.now(place)
        terms = [text_of(term) for part in parts_of(tree) if part[0] == "+" for term in part[1:] if term[0] != "+"]
        twice = tree[0] == "SQRT" and len({*terms}) < len(terms)
        if re.search(NO_LENGTH, label, re.I) or self.known.is_length(now):
            return False
        no_root = re.search(DISTANCE, label, re.I) and self.known.is_length(np.sqrt(np.abs(now)))
        return bool(re.search(LENGTH, label, re.I) or no_root or twice)

    def _is_no_difference(self, place: Place, label: str) -> bool:
        """Whether a difference, or a distance between two, is by its value a coordinate or a length itself."""
        of_two = re.search(BETWEEN_TWO, label, re.I) and not re.search(FROM_ZERO, label, re.I)
        others = self.plain if re.search(DIFFERENCE, label, re.I) else self.lengths if of_two else ()
        return any(same(self.judge.now(place), each) for each in others)

    def _is_no_statistic(self, place: Place, texts: list[str]) -> bool:
        """Whether a mean, sum, largest or smallest is said to be another one, or one of absolute values."""
        tree = self.graph.trees[place]
        named = {name for name, pattern in STATISTIC.items() if any(re.search(pattern, t, re.I) for t in texts)}
        if tree[0] in ("MAX", "MIN") and re.search(wording("absolute"), " ".join(texts), re.I):
            return bool((self.judge.now(place) < 0).any())
        return len(named) == 1 and heads(tree).isdisjoint(named) and tree[0] in {*STATISTIC} - {"SQRT"}

    def _is_in_radians(self, place: Place, texts: list[str]) -> bool:
        """Whether an angle is in radians, the given ones in degrees, and no text says so."""
        graph, functions, known = self.graph, heads(self.graph.trees[place]), self.known
        units = {self.judge.units.get(p, 1.0) for turn in known.turns for p in turn.angles}
        if place in graph.used or not functions & INVERSE or "DEGREES" in functions or units != {np.pi / 180}:
            return False
        near, now = graph.cells.get(offset(place, 0, 1)), self.judge.now(place)
        in_words = any(re.search(IN_RADIANS, text, re.I) for text in (*texts, str(near and near.value)))
        return known.is_angle(now) and not (in_words or known.is_angle(np.deg2rad(now)))

    def _copied(self, place: Place) -> Place:
        """The cell of which a cell is a copy, perhaps rounded, or a copy of a copy."""
        graph = self.graph
        while unrounded(graph.tree(place))[0] == "area" and len(graph.uses[place]) == 1:
            if place in graph.circular:
                break
            (place,) = graph.uses[place]
        return place

    def _mixed(self, copies: dict[Place, Place]) -> Iterator[Place]:
        """Three cells in line that are copies of three in line, in another order."""
        for line in runs(copies):
            sources = [copies[p] for p in line]
            for n in range(len(line) - 2):
                own = sources[n : n + 3]
                first, second, _ = in_order = [*self.found.sorted(own)]
                down, right = second[1] - first[1], second[2] - first[2]
                in_line = in_order == [offset(first, k * down, k * right) for k in range(3)]
                yield from line[n : n + 3] if in_line and own not in (in_order, in_order[::-1]) else ()

    def _of_the_other_solution(self, rest: set[Place]) -> Iterator[Place]:
        """Angles computed back, each once, that are of another of the two solutions than most."""
        inverse = [p for p in self.found.sorted(rest) if heads(self.graph.tree(p)) & INVERSE]
        for turn in {turn.angles: turn for turn in self.known.turns if has_angles(turn)}.values():
            _, *both = solutions(turn)
            fits: dict[Place, list[bool]] = {}
            which = []
            for place, (k, angle) in product(inverse, enumerate(np.transpose(both, (2, 0, 1)))):
                for unit in (1, np.pi / 180):
                    off = np.abs(wrap(self.judge.now(place) * unit - angle, 2 * np.pi))[:, 1:].max(axis=1)
                    if (off < 1e-6).any():
                        fits[place] = [*map(bool, off < 1e-6)]
                        which.append(k)
            usual = int(np.argmax(np.sum([*fits.values()], axis=0))) if fits else 0
            if len({*which}) == len(which):
                yield from (place for place, own in fits.items() if not own[usual])
