"""Find the words of single positions, in any layout, by how cells depend on typed numbers.

Random tool axes are put into three numbers: if formulas then give the rotary words, these three are the axis.
Random tips in three others find X Y Z in the same way. A wrong word is found by its label, or by the places of the
others.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from itertools import chain
from typing import TYPE_CHECKING, Any

import numpy as np

from mathpost.rotation import wrap
from mathpost.workbook.meaning.label import IN_RADIANS
from mathpost.workbook.meaning.nc_columns import Column, Table
from mathpost.workbook.meaning.nc_headings import PLAIN, headings_exchanged, letters_of, normal
from mathpost.workbook.meaning.nc_roles import CLOSE
from mathpost.workbook.sheet.edits import INVERSE
from mathpost.workbook.sheet.place import offset
from mathpost.workbook.sheet.samples import same
from mathpost.workbook.sheet.tree import heads

if TYPE_CHECKING:
    from mathpost.kinematics import Kinematics
    from mathpost.workbook.meaning.recognise import Recognised
    from mathpost.workbook.sheet.place import Line, Place
    from mathpost.workbook.sheet.samples import Values

DRAWN, MOST = 24, 200  # positions at random; triples of numbers that are tried
ENOUGH = 0.4  # of the positions: an arc sine is right on half of the sphere
ENOUGH_OF_TWIN = 4.5  # all five words
RADIANS, LAST, TYPED = 0.9, 1.2, -0.3  # what counts: a word in radians, one that no formula uses, a typed number


class Positions:
    """The search in one sheet; `found` knows its typed numbers and its texts."""

    def __init__(self, found: Recognised, kinematics: Kinematics) -> None:
        self.found, self.graph, self.kinematics = found, found.graph, kinematics
        self.names = [name[0].lower() for name in kinematics.machine.joint_names]
        self.base, rng = self.graph.run({}), np.random.default_rng(30)
        self.taken: set[Place] = set()
        self.letters = {p: self.named(p) for p in self.graph.component if p not in self.graph.messages}
        axes = rng.normal(size=(4 * DRAWN, 3))
        both = kinematics.inverse(np.zeros(3), axes, degrees=True)[..., 3:]
        within = np.flatnonzero(np.isfinite(both).all(axis=(1, 2)))[:DRAWN]
        self.axes, self.both = axes[within] / np.linalg.norm(axes[within], axis=1, keepdims=True), both[within]
        self.tips = rng.uniform(-60, 60, self.axes.shape)

    def find(self) -> list[Table]:
        """The positions, each as a `Table` of one row."""
        graph, tables = self.graph, []
        turning = graph.upstream(p for p in graph.trees if heads(graph.trees[p]) & INVERSE)
        given = self.found.typed & graph.used.keys()
        axes = self.found.lines(given & turning, 2)[:MOST]
        fits = {axis: self.rotary(axis)[0] for axis in axes}
        for axis in sorted(fits, key=lambda axis: -fits[axis]):
            near = given & graph.upstream(graph.downstream(axis)) - self.taken - {*axis}
            least, tips = ENOUGH, self.found.lines(near, 2)[:MOST]
            while self.taken.isdisjoint(axis) and (found := self.position(axis, tips))[0] >= least:
                tables.append(found[1])  # and once more, for the other solution beside it
                ((tip, _, words),), least = tables[-1].rows, ENOUGH_OF_TWIN
                tips = [tip] if tip else []
                self.taken.update(words)
            self.taken.update((*axis, *chain(*tips)) if least > ENOUGH else ())
        return tables

    def position(self, axis: Line, tips: list[Line]) -> tuple[float, Table]:
        """How well the words fit that are found with an axis there and one of the tips, and the `Table`."""
        fit, rotary = self.rotary(axis)
        found = [(*self.linear(tip, axis, rotary), tip) for tip in (tips if fit >= ENOUGH else ())]
        more, linear, tip = max(found, key=lambda each: each[0], default=(0.0, (), ()))
        words = *linear, *rotary
        parts = ([self.column(p) for p in part] for part in (tip if linear else (), axis, words))
        tip_, axis_, words_ = parts
        exchanged = headings_exchanged(self.graph, self.kinematics, tip_, axis_, words_)
        return fit + more, Table(
            [(tip if linear else (), axis, words)], tuple(rotary.values()), exchanged=exchanged
        )

    def column(self, place: Place) -> Column:
        """A cell as the column of a table."""
        return Column((place,), np.empty(0), self.letters[place], place not in self.graph.trees, 1.0, "", 0.0)

    def values(self, given: Values) -> Values:
        """Place → what is there, of the formulas that depend on the numbers `given`, place → samples."""
        after = self.graph.downstream(given) & self.graph.trees.keys()
        found = self.graph.run(given, self.base, after)
        return {p: found[p] * np.ones(len(self.axes)) for p in after - self.graph.messages}

    def rotary(self, axis: Line) -> tuple[float, dict[Place, float]]:
        """How well the rotary words fit that are found with an axis there, and the words: place → unit."""
        values, total = self.values(dict(zip(axis, self.axes.T, strict=True))), 0.0
        words: dict[Place, float] = {}
        for k in (3, 4):
            degrees, radians = (
                {p: _fit(value * unit, self.both[..., k - 3]) for p, value in values.items()}
                for unit in (1.0, np.rad2deg(1))
            )
            fits = {p: RADIANS * fit for p, fit in radians.items() if fit > max(degrees[p], ENOUGH)}
            fits = {p: fit for p, fit in fits.items() if self.is_in_radians(p)}
            place = self.choose(k, degrees | fits, {*axis, *words})
            if place is None:
                return 0.0, {}
            total += (degrees | fits).get(place, 0.0)
            words[place] = np.rad2deg(1) if place in fits else 1.0
        said = self.are_named(axis, "ijk") and self.are_named(words, self.names[3:])
        return max(total, ENOUGH * said), words

    def linear(self, tip: Line, axis: Line, rotary: dict[Place, float]) -> tuple[float, Line]:
        """How well X Y Z fit that are found with a tip there, and their places; none if not all are found."""
        values = self.values(dict(zip((*axis, *tip), (*self.axes.T, *self.tips.T), strict=True)))
        own: dict[Place, Any] = self.graph.own | values
        turned = [own[p] * unit * np.ones(len(self.axes)) for p, unit in rotary.items()]
        turns = np.stack([np.stack(turned, axis=-1), self.both[:, 0], self.both[:, 1]])
        wanted, total = self.kinematics.close(self.tips, np.deg2rad(turns))[..., :3], 0.0
        words: dict[int, Any] = {}
        for k in range(3):
            fits = {p: _fit(value, wanted[..., k].T) for p, value in values.items()}
            words[k] = self.choose(k, fits, {*axis, *tip, *rotary, *words.values()})
            total += fits.get(words[k], 0.0)
        for k, (a, b) in ((0, (1, 2)), (1, (0, 2)), (2, (0, 1))):  # it is in line with the others
            if words[k] is None and None not in (words[a], words[b]):
                steps = [(q - p) * (k - a) // (b - a) for p, q in zip(words[a][1:], words[b][1:], strict=True)]
                words[k] = offset(words[a], *steps)
        if not (self.letters.keys() - {*axis, *tip, *rotary}).issuperset(words.values()):
            return 0.0, ()
        total = max(total, ENOUGH * (self.are_named(tip, "xyz") and self.are_named(words.values(), "xyz")))
        return total, tuple(words.values()) if total >= ENOUGH else ()

    def choose(self, k: int, fits: Mapping[Place, float], taken: set[Place]) -> Place | None:
        """The cell of a word: that fits best and has its label, or else one or the other."""
        graph, counts = self.graph, {}
        may = self.letters.keys() - taken - self.taken
        for place in may - (graph.used.keys() - graph.trees.keys() if k < 3 else set()):
            label, fit = self.letters[place].get(self.names[k], 0.0), fits.get(place, 0.0)
            if fit >= ENOUGH or label == PLAIN:
                last = LAST * (place in fits and place not in graph.used) + TYPED * (place not in graph.trees)
                counts[place] = -fit - label - last, graph.calculation_order(place)
        return min(counts, key=lambda place: counts[place], default=None)

    def are_named(self, places: Iterable[Place], letters: Iterable[str]) -> bool:
        return all(letter in self.letters[place] for place, letter in zip(places, letters, strict=True))

    def named(self, place: Place) -> dict[str, float]:
        """The letters in the nearest text that has any, before a cell or else after it."""
        texts = (*self.found.texts(place), self.text(place, 1))
        return next(filter(None, map(letters_of, map(normal, texts))), {})

    def text(self, place: Place, right: int) -> str:
        """The text in a cell so many columns further right, or nothing."""
        cell = self.graph.cells.get(offset(place, 0, right))
        return cell.value if cell and isinstance(cell.value, str) else ""

    def is_in_radians(self, place: Place) -> bool:
        """Whether a text beside a cell says so, or a turn in radians leaves a sine that uses it as it is."""
        beside = self.text(place, 1) or self.text(place, -1)
        after, turned = self.graph.used.get(place, ()), {place: self.base[place] + 2 * np.pi}
        turned = self.graph.run(turned, self.base, {*after})
        return bool(re.search(IN_RADIANS, normal(beside))) or any(same(turned[p], self.base[p]) for p in after)


def _fit(values: np.ndarray, wanted: np.ndarray) -> float:
    """How many of some samples are one of those wanted, shape (samples, n)."""
    return (np.abs(wrap(values[:, None] - wanted)) < CLOSE).any(axis=1).mean()
