"""The columns of a table of NC words as its headings name them; and whose headings are exchanged.

Headings decide before fit does: if they name every column, these are the columns, whatever numbers are there. If
most rows are right only with some headings exchanged, the exchange is the fault.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations, permutations
from typing import TYPE_CHECKING

import numpy as np

from mathpost.detective.positions import explain_linear
from mathpost.workbook.meaning.nc_headings import PLAIN, where
from mathpost.workbook.meaning.nc_roles import CLOSE

if TYPE_CHECKING:
    from mathpost.kinematics import Kinematics
    from mathpost.workbook.meaning.nc_columns import Column
    from mathpost.workbook.sheet.graph import Graph
    from mathpost.workbook.sheet.place import Place

TOLD = 2  # decimals of a mm that tell a cause
MOST = 24  # rows that are looked at
ALONE = 5  # columns of tool axis and rotary words, without tip and X Y Z
SIDES = {"tip": "cl", "axis": "axis", "linear": "nc"}
NAMES = {"tip": "{} of the tip", "axis": "{} of the tool axis", "linear": "{}", "rotary": "{}"}


@dataclass(frozen=True)
class Heading:
    """What one column is said to be: a part of a row and a letter."""

    part: str
    letter: str

    def __str__(self) -> str:
        letter = self.letter.upper() if self.part in ("linear", "rotary") else self.letter
        return NAMES[self.part].format(letter)


Order = tuple[int, ...]  # the columns, in the order of their headings


def named(columns: Sequence[Column], joints: Sequence[str], alone: bool) -> tuple[list[Heading], list[Order]]:
    """What the headings name, and the columns so named; more than one order if they do not tell tip from X Y Z.

    `joints` are the letters of the five words, or two that are `alone`, without X Y Z and a tip. None are named
    unless each is, by as many columns as there should be.
    """
    said = {letter for column in columns for letter in column.letters}
    letters = next((letters for letters in ("ijk", "uvw") if not said.isdisjoint(letters)), "xyz")
    if alone and letters == "xyz":
        return [], []
    groups = {"tip": "xyz", "axis": letters, "linear": joints[:3], "rotary": joints[3:]}
    groups = {part: groups[part] for part in ("axis", "rotary")} if alone else groups
    headings = [Heading(part, letter) for part, group in groups.items() for letter in group]
    asked = [heading.letter for heading in headings]
    found = {letter: _of_letter(columns, letter, asked.count(letter)) for letter in asked}
    if not all(len(found[letter]) == asked.count(letter) for letter in found):
        return [], []
    orders = [order for order in _orders(columns, headings, found) if len({*order}) == len(order)]
    return headings, list(dict.fromkeys(orders))


def _of_letter(columns: Sequence[Column], letter: str, count: int) -> list[int]:
    """The columns of a letter: with nothing but it over them if these are so many as there should be."""
    any_of = [n for n, column in enumerate(columns) if letter in column.letters]
    plain = [n for n in any_of if columns[n].letters[letter] == PLAIN]
    return plain if len(plain) == count else any_of


def _orders(columns: Sequence[Column], headings: Sequence[Heading], found: dict[str, list[int]]) -> Iterator[Order]:
    """The columns of headings; those of one letter by what is said of their part, or else as they follow."""
    for order in permutations(dict.fromkeys(heading.part for heading in headings)):
        taken: dict[Heading, int] = {}
        for letter, numbers in found.items():
            parts = [part for part in order if Heading(part, letter) in headings]
            said = {part: [n for n in numbers if columns[n].said == SIDES.get(part)] for part in parts}
            told = {part: of[0] for part, of in said.items() if len(of) == 1}
            left = [n for n in numbers if n not in told.values()]
            told |= dict(zip([part for part in parts if part not in told], left, strict=True))
            taken |= {Heading(part, letter): n for part, n in told.items()}
        yield tuple(taken[heading] for heading in headings)


def _parts(order: Order) -> dict[str, Sequence[int]]:
    tip, axis = (order[:3], order[3:6]) if len(order) > ALONE else ((), order[:3])
    return {"tip": tip, "axis": axis, "words": order[len(tip) + 3 :]}


def exchanges(headings: Sequence[Heading]) -> np.ndarray:
    """Orders of the headings with two exchanged, three of a part in another order, or two parts, or the words."""
    same = [*range(len(headings))]
    of = {part: [n for n in same if headings[n].part == part] for part in dict.fromkeys(h.part for h in headings)}
    ways: list[tuple[Sequence[int], Sequence[int]]] = [((a, b), (b, a)) for a, b in combinations(same, 2)]
    threes = [numbers for numbers in of.values() if len(numbers) == 3]
    ways += [(numbers, (*numbers[k:], *numbers[:k])) for numbers in threes for k in (1, 2)]
    ways += [((*a, *b), (*b, *a)) for a, b in combinations(threes, 2)]
    words = [*of.get("linear", ()), *of["rotary"]]
    ways += [(words, order) for order in permutations(words)]
    found = []
    for numbers, others in ways:
        order = [*same]
        for n, other in zip(numbers, others, strict=True):
            order[n] = other
        found.append(order)
    return np.array(found)


def _are_off(headings: Iterable[Heading]) -> str:
    words = [str(heading) for heading in headings if heading.part == "linear"]
    return f"{' '.join(words)} {'is' if len(words) == 1 else 'are'} off in every row"


class Headed:
    """The columns of a table that headings name, if they name all.

    After `settle`, `columns` are under their own headings, and `exchanged` has a cell and a sentence if these are
    not the sheet's.
    """

    def __init__(self, graph: Graph, columns: Sequence[Column], kinematics: Kinematics, alone: bool) -> None:
        self.graph, self.columns, self.kinematics = graph, [*columns], kinematics
        self.joints = [name[0].lower() for name in kinematics.machine.joint_names]
        self.headings, self.orders = named(columns, self.joints, alone)
        rows = len(columns[0].values)
        self.sample = np.unique(np.linspace(0, rows - 1, min(rows, MOST)).astype(int))
        self.exchanged: tuple[Place, str] | tuple[()] = ()

    def settle(self) -> dict[str, Sequence[int]] | None:
        """The columns by "tip", "axis", "words": as named, or exchanged if most rows are right only then."""
        order = self._order() if self.orders else None
        return _parts(order) if order else None

    @property
    def first(self) -> dict[str, Sequence[int]] | None:
        """The columns as they follow, where headings name all and do not tell the tip from X Y Z."""
        return _parts(self.orders[0]) if self.orders else None

    def _order(self) -> Order | None:
        right = self.right(np.array(self.orders))
        if right.max() >= 0.5:
            return self.orders[int(right.argmax())]
        for order in self.orders:
            others = np.array(order)[exchanges(self.headings)]
            right = self.right(others, order)
            for n in np.flatnonzero(right > 0.5):
                other = tuple(map(int, others[n]))
                if self._may_be(other):
                    self._exchange(order, other)
                    return other
        return self.orders[0] if len(self.orders) == 1 else None

    def _may_be(self, order: Order) -> bool:
        """Whether no tip or tool axis is made of what would be a word."""
        parts = _parts(order)
        first = [self.columns[n].places[0] for n in (*parts["tip"], *parts["axis"])]
        return self.graph.upstream(first).isdisjoint(self.columns[n].places[0] for n in parts["words"])

    def _exchange(self, order: Order, other: Order) -> None:
        """Give the columns `other` the headings of those in `order`, and say so."""
        columns = [*self.columns]
        for n, k in zip(other, order, strict=True):
            own = columns[k]
            self.columns[n] = replace(columns[n], letters=own.letters, unit=own.unit, said=own.said, more=own.more)
        said, meant = (dict(zip(each, self.headings, strict=True)) for each in (order, other))
        off = [n for n in order if said[n] != meant[n]]
        text = f"{meant[off[0]]} stands under the heading {said[off[0]]}: exchanged"
        if {said[n].part for n in off} == {"tip", "linear"}:
            if len(off) == 6:
                text = "the headings say that this is the tip, and that the tip is X Y Z: exchanged"
            text += f", or {self._cause(order) or _are_off(meant[n] for n in off)}"
        words = [columns[n] for n in _parts(other)["words"]]
        self.exchanged = where(self.graph, columns[off[0]], words), text

    def _cause(self, order: Order) -> str:
        """What else makes X Y Z of the tip, with the columns as they are named: no number can tell."""
        values = np.array([self.columns[n].values[self.sample] for n in order]).T
        degrees = values[:, -2:] * [self.columns[n].unit for n in order[-2:]]
        whole = np.isfinite(values).all(axis=1)
        tip, linear, rotary = values[whole, :3], values[whole, 6:9], degrees[whole]
        found = explain_linear(self.kinematics, tip, rotary, linear, decimals=TOLD, together=1)
        single = [each.sentence for each in found.misreadings if found.explained and len(each.kinds) == 1]
        return next(iter(single), "")

    def right(self, orders: np.ndarray, headed: Order | None = None) -> np.ndarray:
        """The share of rows whose words put the tool where they say, with the columns in each order.

        `orders` has shape (n, columns), the share (n,). The units of rotary words are those in the headings over
        them, or over the columns in the order `headed`.
        """
        values = np.array([column.values[self.sample] for column in self.columns])[orders].swapaxes(1, 2)
        unit_of = np.array([column.unit for column in self.columns])
        joints = np.zeros((*values.shape[:2], 5))
        joints[..., 3:] = values[..., -2:] * unit_of[orders if headed is None else [headed]][:, None, -2:]
        alone = values.shape[-1] == ALONE
        joints[..., :3] = 0.0 if alone else values[..., -5:-2]
        tip, axis = self.kinematics.forward(np.nan_to_num(joints), degrees=True)
        wanted = values[..., -ALONE:-2] if alone else values[..., 3:6]
        wanted = wanted / np.linalg.norm(wanted, axis=-1, keepdims=True)
        fits = np.isfinite(values).all(axis=-1) & (np.abs(axis - wanted).max(axis=-1) < np.deg2rad(CLOSE))
        if not alone:
            fits &= np.abs(tip - values[..., :3]).max(axis=-1) < CLOSE
        return fits.mean(axis=-1)
