"""Cells beside a calculation that are something known, but not what their labels say: they are listed."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator
from functools import cached_property
from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from mathpost.rotation import wrap
from mathpost.teaching.workbook.meaning.calculation import Turn
from mathpost.teaching.workbook.meaning.given import runs
from mathpost.teaching.workbook.meaning.label import IN_RADIANS, read_label
from mathpost.teaching.workbook.sheet.edits import INVERSE
from mathpost.teaching.workbook.sheet.place import Place, offset
from mathpost.teaching.workbook.sheet.samples import same
from mathpost.teaching.workbook.sheet.tree import heads, parts_of, text_of, unrounded
from mathpost.teaching.workbook.verdict.known import Known, has_angles, solutions

if TYPE_CHECKING:
    from mathpost.teaching.workbook.verdict.judge import Judge

LENGTH = r"^\|[^|]*\|\W*$|\bnorme?\b|\bbetrag\b|\blength\b|\blänge\b|\b3-?d\b|模长|长度"
DISTANCE = r"length|norm|\||betrag|länge|abstand|dist|radius|长|模|距"
OF_LENGTHS = r"²|\^2|squar|quadrat|平方|diff|differenz|error|fehler|%|/|unit|einheit|差|Δ"
BETWEEN_TWO, FROM_ZERO = r"abstand|distan|entfern|距离", r"origin|ursprung|null|zero|原点|\b[o0]\b|ax[ei]s|achse|轴"
ABSOLUTE = r"absol|\babs\b|绝对"
DETERMINANT = r"\bd[eé]t|行列式"
DIFFERENCE = r"diff|Δ|abweich|error|fehler|deviation|écart|偏差|误差|差|\bd[xyz]\b"
STATISTIC = {
    "AVERAGE": r"\bmean|average|mittel|durchschnitt|moyenne|平均",
    "SUM": r"\bsum|summe|somme|总和|合计",
    "MAX": r"\bmax|größte|longest|längste|最[大长]",
    "MIN": r"\bmin(?!u)|kleinste|shortest|kürzeste|最[小短]",
    "SQRT": r"\brms\b|effektiv|均方根",
}


class Labels:
    """What labels say of cells, by a `Judge` and what is `Known`."""

    def __init__(self, judge: Judge, known: Known) -> None:
        self.judge, self.graph, self.found, self.known = judge, judge.graph, judge.found, known

    def doubts(self, rest: set[Place]) -> Iterator[Place]:
        """Yield the cells of `rest`, which no result needs, that are unlike their labels, or their order."""
        for place in self.found.sorted(rest & self.graph.trees.keys()):
            label = next(iter(self.found.texts(place)), "")
            in_row, tree = self._in_row(place), self.graph.trees[place]
            if (
                self._is_no_determinant(place, label)
                or self._is_no_length(place, label)
                or self._is_no_statistic(tree, in_row + self.found.texts(place))
                or self._is_in_radians(place)
                or self._is_no_difference(place, label)
                or self._is_no_distance(place, label)
                or self._is_not_absolute(place, in_row)
            ):
                yield place
        copies = {p: q for p in rest if (q := self._copied(p)) != p}
        yield from self._mixed(copies)
        yield from self._misnamed(copies)
        yield from self._other_angles(rest)

    def _in_row(self, place: Place) -> list[str]:
        """The texts before a cell in its row."""
        cells = (self.graph.cells.get((*place[:2], column)) for column in range(1, place[2]))
        return [cell.value for cell in cells if cell and isinstance(cell.value, str)]

    def _is_not_absolute(self, place: Place, in_row: list[str]) -> bool:
        """Whether a largest absolute value, by its label, may be negative."""
        is_one = self.graph.trees[place][0] in ("MAX", "MIN") and re.search(ABSOLUTE, " ".join(in_row), re.I)
        return bool(is_one) and bool((self.judge.now(place) < 0).any())

    def _is_no_distance(self, place: Place, label: str) -> bool:
        """Whether a distance between two, by its label, is the length of one of them."""
        named = re.search(BETWEEN_TWO, label, re.I) and not re.search(FROM_ZERO, label, re.I)
        return bool(named) and any(same(self.judge.now(place), length) for length in self._lengths)

    def _is_no_difference(self, place: Place, label: str) -> bool:
        """Whether a difference, by its label, is a sum, a coordinate itself, or one of a cell less itself."""
        if any(part[0] == "-" and part[1] == part[2] for part in parts_of(self.graph.trees[place])):
            return True
        now, is_difference = self.judge.now(place), re.search(DIFFERENCE, label, re.I)
        is_sum = heads(self.graph.trees[place]) == {"+", "area"}
        if is_difference and is_sum and not re.search(STATISTIC["SUM"], label, re.I):
            return True
        return bool(is_difference) and any(same(now, each) for each in self._plain)

    def _is_in_radians(self, place: Place) -> bool:
        """Whether an angle is in radians, the given ones in degrees, and no text says so."""
        graph, functions, known = self.graph, heads(self.graph.trees[place]), self.known
        units = {self.judge.units.get(p, 1.0) for turn in known.turns for p in turn.angles}
        if place in graph.used or not functions & INVERSE or "DEGREES" in functions or units != {np.pi / 180}:
            return False
        near, now = graph.cells.get(offset(place, 0, 1)), self.judge.now(place)
        texts = [*self.found.texts(place), str(near and near.value)]
        in_words = any(re.search(IN_RADIANS, text, re.I) for text in texts)
        return known.is_angle(now) and not (in_words or known.is_angle(np.deg2rad(now)))

    def _is_no_determinant(self, place: Place, label: str) -> bool:
        """Whether a determinant, by its label, is not that of the nine cells it uses."""
        used = self.graph.uses[place]
        rows, columns = sorted({p[:2] for p in used}), sorted({p[2] for p in used})
        if not re.search(DETERMINANT, label, re.I) or (len(rows), len(columns)) != (3, 3) or len(used) < 7:
            return False
        block = self.judge.block([(*row, column) for row in rows for column in columns]).reshape(3, 3, -1)
        value = np.linalg.det(np.moveaxis(block, -1, 0))
        return not any(same(self.judge.now(place), sign * value) for sign in (1, -1))

    def _is_no_statistic(self, tree: tuple, texts: list[str]) -> bool:
        """Whether a mean, sum, largest or smallest is said, by its only name, to be another one of these."""
        named = {name for name, pattern in STATISTIC.items() if any(re.search(pattern, t, re.I) for t in texts)}
        return len(named) == 1 and heads(tree).isdisjoint(named) and tree[0] in {*STATISTIC} - {"SQRT"}

    def _is_no_length(self, place: Place, label: str) -> bool:
        """Whether what is said to be a length is none, has no root, or takes one coordinate twice."""
        tree, now = self.graph.trees[place], self.judge.now(place)
        terms = [text_of(term) for part in parts_of(tree) if part[0] == "+" for term in part[1:] if term[0] != "+"]
        twice = tree[0] == "SQRT" and len({*terms}) < len(terms)
        if re.search(f"{OF_LENGTHS}|{DETERMINANT}", label, re.I) or self.known.is_length(now):
            return False
        no_root = re.search(DISTANCE, label, re.I) and self.known.is_length(np.sqrt(np.abs(now)))
        return bool(re.search(LENGTH, label, re.I) or no_root or twice)

    @cached_property
    def _lengths(self) -> list[np.ndarray]:
        """The lengths of points and results that are turned about zero."""
        turns = [turn for turn in self._turned if not (turn.origin or turn.shift)]
        return [np.linalg.norm(each, axis=0) for turn in turns for each in self._ends(turn)]

    @cached_property
    def _plain(self) -> list[np.ndarray]:
        """The coordinates of all points and results, and their lengths."""
        both = [each for turn in self._turned for each in self._ends(turn)]
        return [row for each in both for row in (*each, np.linalg.norm(each, axis=0))]

    @property
    def _turned(self) -> list[Turn]:
        return [c for c in self.judge.live if isinstance(c, Turn) and c.point]

    def _ends(self, turn: Turn) -> tuple[np.ndarray, np.ndarray]:
        """What a point is, and what becomes of it."""
        return self.judge.block(turn.point), np.array([*turn.targets.values()][:3])

    # Copies of results, and angles computed back.

    def _copied(self, place: Place) -> Place:
        """The cell of which a cell is a copy, perhaps rounded, or a copy of a copy."""
        graph = self.graph
        while (
            unrounded(graph.tree(place))[0] == "area"
            and len(graph.uses[place]) == 1
            and place not in graph.circular
        ):
            (place,) = graph.uses[place]
        return place

    def _misnamed(self, copies: dict[Place, Place]) -> Iterator[Place]:
        """Copies of another coordinate of a result than their labels, or their order, say."""
        of: dict[Place, list[Place]] = {}
        for place in self.found.sorted(copies):
            of.setdefault(copies[place], []).append(place)
        for result in (c.results[:3] for c in self.judge.live):
            mine = self.found.sorted(p for source in result for p in of.get(source, ()))
            wanted = {p: k for p in mine if (k := self._outcome_said(p)) is not None}
            lines = (tuple(p for p in mine if (p[0], p[n]) == (q[0], q[n])) for q in mine for n in (1, 2))
            for line in dict.fromkeys(lines):
                words = [word for p in line if (word := self.found.coordinate(p))]
                order = [word[0] for word in words] if len({*words}) == 3 else [0, 1, 2]
                wanted |= dict(zip(line, order, strict=True)) if len(line) == 3 else {}
            yield from (place for place, k in wanted.items() if copies[place] != result[k])

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

    def _outcome_said(self, place: Place) -> int | None:
        """Which coordinate of a result the text next to a cell names."""
        near = (self.graph.cells.get(p) for p in (offset(place, 0, -1), offset(place, -1, 0)))
        label = next((cell.value for cell in near if cell and isinstance(cell.value, str) and not cell.formula), "")
        plain = re.sub(r"\([^()xyz]*\)$", "", label)
        role = read_label(plain) or read_label(label.split(" ")[0]) if "=" not in label else None
        return role.word[0] if role and role.kind == "outcome" else None

    def _other_angles(self, rest: set[Place]) -> Iterator[Place]:
        """Angles computed back that are another one than their label says, or of the other solution, or unit."""
        inverse = [p for p in self.found.sorted(rest) if heads(self.graph.tree(p)) & INVERSE]
        for turn in {turn.angles: turn for turn in self.known.turns if has_angles(turn)}.values():
            found, (_, *both) = [], solutions(turn)
            for place, (k, angle), unit in product(
                inverse, enumerate(np.transpose(both, (2, 0, 1))), (1, np.pi / 180)
            ):
                off = np.abs(wrap(self.judge.now(place) * unit - angle, 2 * np.pi))[:, 1:]
                fits = off.max(axis=1) < 1e-6
                found += [(place, k, fits, unit)] if fits.any() else []
            votes = np.sum([fits for _, _, fits, _ in found], axis=0)
            units, counts = Counter(unit for *_, unit in found), Counter(k for _, k, *_ in found)
            for place, k, fits, unit in found:
                named, usual = self.found.angle_said(place), max(units, key=lambda unit: units[unit])
                is_other = named not in (None, k) and all(named != other for p, other, *_ in found if p == place)
                of_the_other = not fits[int(votes.argmax())] and {*counts.values()} == {1}
                alone = unit != usual and len(found) > 2 and units[unit] == 1
                if is_other or of_the_other or alone:
                    yield place
