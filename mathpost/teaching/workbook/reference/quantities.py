"""A workbook as quantities: its labels, its inputs and its results, and which of two workbooks are the same."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from functools import cached_property
from itertools import product
from typing import Any

import numpy as np

from mathpost.teaching.bounds import TooLarge
from mathpost.teaching.workbook.reference.functions import FUNCTIONS
from mathpost.teaching.workbook.sheet.file import Book
from mathpost.teaching.workbook.sheet.graph import Graph
from mathpost.teaching.workbook.sheet.links import MOST_FORMULAS
from mathpost.teaching.workbook.sheet.place import Place, number_along, offset
from mathpost.teaching.workbook.sheet.samples import SAMPLES, Values, at_samples
from mathpost.teaching.workbook.sheet.tree import TEXTS, areas, heads, parts_of, with_areas

DIRECTION = 1e-3  # by which the square of a direction of three decimals is off
AGREE = 2e-8  # relative to the largest of the samples: what arithmetic loses, and π/180 as 0.0174532925
NOTHING = 1e-12  # what is left of the difference of equal numbers
SEVERAL = 3  # cells with one formula
CHOICES, PUT_TOGETHER = {"IF", "IFS", "CHOOSE"}, TEXTS - {"text"}  # of texts
GAP = 2  # empty cells between a heading and what it heads
UNIT = re.compile(r"[\[(]([^\])]*)[\])]")
Labels = tuple[str, str]  # of a cell: the text to the left of it and the text above


class Sheet(Graph):
    """The graph of a workbook in which lookups by a number stay functions of that number."""

    functions = FUNCTIONS

    def __init__(self, book: Book) -> None:
        super().__init__(book)
        if len(self.trees) > MOST_FORMULAS:
            raise TooLarge(f"{len(self.trees)} formulas")
        self.unround()
        for along in (2, 1):
            self._keep_what_stays(along)

    def _keep_what_stays(self, along: int) -> None:
        """Give a $ to the references that stay the same down a column, `along` 2, or a row, though it has none."""
        groups: dict[tuple, list[Place]] = {}
        for place in self.trees.keys() - self.part.keys():
            groups.setdefault((place[0], number_along(place, along), self.form(place)), []).append(place)
        for places in groups.values():
            found = [areas(self.trees[p]) for p in places]
            for k in range(len(found[0]) if len(places) >= SEVERAL else 0):
                same = Counter(each[k] for each in found).most_common(1)[0]
                seen = Counter(each[k].seen_from(*p[1:]) for p, each in zip(places, found, strict=True))
                if same[1] > len(places) / 2 and same[1] > seen.most_common(1)[0][1]:
                    kept = replace(
                        same[0], fixed=(True, same[0].fixed[1]) if along == 2 else (same[0].fixed[0], True)
                    )
                    for each in found:
                        each[k] = kept if each[k] == same[0] else each[k]
            self.trees |= {p: with_areas(self.trees[p], new) for p, new in zip(places, found, strict=True)
                           if len(places) >= SEVERAL and new}  # fmt: skip

    def _typed(self, place: Place) -> Any:
        """A text, which a lookup may find; a number is an input, and stays one."""
        value = super()._typed(place)
        return value if isinstance(value, str) else None

    def forget(self) -> None:
        """Forget what followed from formulas that have been replaced."""
        for name in ("uses", "used", "order", "_position", "level", "parts"):
            self.__dict__.pop(name, None)

    @cached_property
    def unknown(self) -> set[Place]:
        """The formulas that are not evaluated: a function is not known here, or they depend on themselves."""
        known = {*FUNCTIONS, "number", "text", "area"}
        strange = {place for place, tree in self.trees.items() if heads(tree) - known}
        circular = self.circular if self.order else set()
        return {*self.unread, *strange, *circular} - self.messages

    def why_unknown(self, place: Place) -> str:
        """Say why a formula is not evaluated."""
        names = sorted(heads(self.tree(place)) - {*FUNCTIONS, "number", "area"})
        return self.unread.get(place) or f"{', '.join(names) or 'a function'} is not known here"

    @cached_property
    def shown(self) -> set[Place]:
        """The formulas that give a text."""
        return super().messages

    @cached_property
    def messages(self) -> set[Place]:
        """The formulas that give a text, but for those in which conditions choose it: these are functions."""
        given = self.shown
        chosen = {
            p
            for p in given & self.trees.keys()
            if (found := heads(self.trees[p])) & CHOICES and not found & PUT_TOGETHER
        }
        return given - chosen

    def words(self, place: Place) -> set[str]:
        """The texts among which a formula chooses, in lower case."""
        return {part[1].strip().casefold() for part in parts_of(self.tree(place)) if part[0] == "text"}

    @cached_property
    def numbers_typed(self) -> dict[Place, float]:
        """Place → number of the cells that hold one and no formula, as they are read."""
        found = {p: n for p, n in self.meant.items() if n is not None and not self.cells[p].formula}
        return {p: found[p] for p in sorted(found, key=self.reading_order)}

    def is_start(self, place: Place) -> bool:
        """Whether a 0 or 1 is an entry of a matrix, or what a column of formulas starts from, and no input."""
        if abs(self.numbers_typed[place]) not in (0, 1):
            return False
        near = [
            (head, offset(place, down, right))
            for head, right, down in ((0, 1, 0), (0, -1, 0), (1, 0, 1), (1, 0, -1))
        ]
        return any(p in self.trees and self.labels[p][head] == self.labels[place][head] != "" for head, p in near
                   if p in self.labels)  # fmt: skip

    def ends(self) -> list[Place]:
        """The formulas that give a number and that none uses but for a text, as they are read."""
        used = {mate for p in self.used if not self.shown.issuperset(self.used[p]) for mate in self.array(p)}
        return sorted(self.trees.keys() - self.messages - used, key=self.reading_order)

    # Labels.

    @cached_property
    def labels(self) -> dict[Place, Labels]:
        """Place of a number or formula → the text to its left and the text above, as they are written, or empty."""
        numbers = [
            p for p in self.cells if (p not in self.texts or p in self.numbers_typed) and p not in self.messages
        ]
        numbers.sort(key=self.reading_order)
        ways: dict[tuple[Place, int, int], str] = {}
        return {p: (self._text(p, 0, -1, ways), self._text(p, -1, 0, ways)) for p in numbers}

    def _text(self, place: Place, down: int, right: int, ways: dict[tuple[Place, int, int], str]) -> str:
        """The first text on the way from a place, over numbers, or over a few empty cells."""
        found = ""
        for gap in range(1, GAP + 2):
            near = offset(place, gap * down, gap * right)
            if near in self.texts and self.meant[near] is None:
                found = str(self.cells[near].value)
                break
            if gap == 1 and (near, down, right) in ways:
                found = ways[near, down, right]
                break
        ways[place, down, right] = found
        return found

    def label(self, place: Place) -> str:
        """The labels of a place in one text, for people."""
        return ", ".join(dict.fromkeys(text.strip() for text in self.labels.get(place, ()) if text))


def plain(label: str) -> str:
    """A label without its unit, in lower case: what two people write alike.

    Examples
    --------
    >>> plain("Feed  rate vf [mm/min] =")
    'feed rate vf'
    """
    return re.sub(r"\s+", " ", UNIT.sub(" ", label)).strip(" :=").casefold()


def words(label: str) -> frozenset[str]:
    """The words and symbols of a label."""
    return frozenset(re.findall(r"[^\W\d_]+\d*['′]*|\d+", plain(label)))


def likeness(a: Labels, b: Labels) -> float:
    """How alike the labels of two cells are, 0 to 2; a text beside one may stand above the other."""
    scores = [[_shared(x, y) for y in b] for x in a]
    return max(scores[0][0] + scores[1][1], scores[0][1] + scores[1][0])


def _shared(a: str, b: str) -> float:
    if not a or not b:
        return 0.0
    if plain(a) == plain(b):
        return 1.0
    x, y = words(a), words(b)
    return 0.8 * len(x & y) / len(x | y) if x and y else 0.0


# Values at samples.


def agree(a: np.ndarray, b: np.ndarray, own: bool = True) -> np.ndarray:
    """Whether two quantities, shape (…, samples), are the same at all samples; without the first if not `own`."""
    a, b = (np.asarray(each)[..., (0 if own else 1) :] for each in (a, b))
    size = np.maximum(np.abs(a).max(axis=-1), np.abs(b).max(axis=-1))[..., None]
    return (np.abs(a - b) <= AGREE * size + NOTHING).all(axis=-1)


class Dictionary:
    """Quantities, found by what they are at the samples."""

    def __init__(self, quantities: Iterable[tuple[Any, np.ndarray]]) -> None:
        known = [(key, at_samples(value)) for key, value in quantities if np.isfinite(value).all()]
        self.keys = [key for key, _ in known]
        values = np.array([value for _, value in known]).reshape(-1, SAMPLES)
        order = np.argsort(values[:, -1], kind="stable")
        self.keys, self.values = [self.keys[n] for n in order], values[order]

    def find(self, value: np.ndarray) -> list[Any]:
        """The keys of all quantities that agree with a value, in their order."""
        value = at_samples(np.asarray(value))
        if not np.isfinite(value).all():
            return []
        reach = 2 * AGREE * np.abs(value).max() + 2 * NOTHING
        first, last = np.searchsorted(self.values[:, -1], (value[-1] - reach, value[-1] + reach))
        near = range(first, last)
        return [self.keys[n] for n in near if agree(self.values[n], value)]

    def __contains__(self, value: np.ndarray) -> bool:
        return bool(self.find(value))


def parts_as_quantities(sheet: Sheet, values: Values, places: Iterable[Place]) -> list[tuple[Any, np.ndarray]]:
    """Every part of some formulas that is one number, with the place of its formula."""
    found: list[tuple[Any, np.ndarray]] = []
    for tree, place in {id(sheet.trees[p]): (sheet.trees[p], p) for p in places}.values():
        if place in sheet.part:
            continue
        held = sheet.parts_at(tree, values)
        found += [(place, held[id(part)][:, 0, 0]) for part in parts_of(tree)
                  if id(part) in held and held[id(part)].shape[1:] == (1, 1)]  # fmt: skip
    return found


# Samples.


def sampled(numbers: Mapping[Place, float], other: Mapping[Place, float], reach: float, seed: int = 0) -> Values:
    """Values of inputs at all samples: the first are `other`, the rest near `numbers` and near `other` in turn.

    A list that rises or falls does so at every sample, so that a lookup finds its place. Three numbers in line that
    are a direction, or four that are a unit quaternion, are one at every sample.
    """
    rng, found = np.random.default_rng(seed), {}
    steps = {place: min(reach * (abs(number) or 1.0), _step(numbers, place)) for place, number in numbers.items()}
    for place, number in numbers.items():
        centre = np.where(np.arange(SAMPLES) % 2, number, other[place])
        shift = rng.uniform(-1, 1, SAMPLES) * steps[place]
        shift[0] = 0.0
        found[place] = centre + shift
    for line in _units(numbers, other):
        length = np.sqrt(sum(found[place] ** 2 for place in line))
        length[0] = 1.0  # as it was typed
        found |= {place: found[place] / length for place in line}
    return found


def _units(*sheets: Mapping[Place, float]) -> Iterator[list[Place]]:
    """Inputs beside or below each other whose squares add up to 1, as they are rounded, in each of some sheets."""
    taken: set[Place] = set()
    for count, (down, right) in product((4, 3), ((0, 1), (1, 0))):
        for place in sorted(sheets[0]):
            line = [offset(place, n * down, n * right) for n in range(count)]
            if taken.isdisjoint(line) and all(p in sheet for sheet in sheets for p in line):
                squares = [sum(sheet[p] * sheet[p] for p in line) for sheet in sheets]  # ** may overflow
                if all(abs(each - 1) < DIRECTION for each in squares):
                    taken |= set(line)
                    yield line


def _step(numbers: Mapping[Place, float], place: Place) -> float:
    """A fifth of the smallest step of the list in which a number rises or falls; infinite where it is in none."""
    steps = [np.inf]
    for down, right in ((1, 0), (0, 1)):
        line = [p for n in (-2, -1, 0, 1, 2) if (p := offset(place, n * down, n * right)) in numbers]
        change = np.diff([numbers[p] for p in line])
        if len(line) > 2 and ((change > 0).all() or (change < 0).all()):
            steps.append(float(np.abs(change).min()) / 5)
    return min(steps)
