"""The columns of a table of NC words as its headings name them; exchanged headings are the fault."""

from __future__ import annotations

import re
import unicodedata
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import accumulate, combinations, islice, permutations, product
from typing import TYPE_CHECKING

import numpy as np

from mathpost.teaching.workbook.meaning.label import IN_RADIANS
from mathpost.teaching.workbook.meaning.vocabulary import wording
from mathpost.teaching.workbook.sheet.place import Line, Place

if TYPE_CHECKING:
    from mathpost.kinematics import Kinematics
    from mathpost.teaching.workbook.sheet.graph import Graph

CLOSE = 0.1  # degrees, mm: close enough to tell a heading; whether a word is right is judged elsewhere
MOST = 24  # rows that are looked at
MOST_ORDERS = 200  # of columns that have the same letters
PLAIN, AMONG_OTHERS = 2, 1  # whether a heading is a letter, or has one
MACHINE = re.compile(rf"{wording('machine')}|^[xyzabc]m$")
OF_CL = re.compile(wording("workpiece"))
OF_AXIS = re.compile(rf"{wording('tool axis')}|^(?:[nv]|ax|axis)_?[xyz]$")
SAID = {"linear": MACHINE, "tip": OF_CL, "axis": OF_AXIS}
UNIT = re.compile(r"[\[(（/].*|\b(?:deg|rad|mm|grad)\b\.?$|[°度]")

Order = tuple[int, ...]  # the columns, in the order of their headings
Heading = tuple[str, str]  # a part of a row and a letter


@dataclass(frozen=True)
class Column:
    """The cells of a column, one of each row, and their numbers; `letters` are those in its heading."""

    places: Line
    values: np.ndarray
    letters: dict[str, int]
    typed: bool
    unit: float  # degrees of 1, if it is an angle
    said: str  # the part that its heading, or that of its group, says


def column(graph: Graph, sheet: str, lines: range, number: int, along: int) -> Column:
    """The column, or row, of a number, with what the three nearest texts before it say."""

    def place(line: int, n: int = number) -> Place:
        return (sheet, line, n) if along == 1 else (sheet, n, line)

    def text(p: Place) -> str:
        cell = graph.cells.get(p)
        return cell.value if cell and isinstance(cell.value, str) else ""

    raw = [found for line in range(lines[0] - 1, 0, -1) if (found := text(place(line)))][:3]
    texts = [*map(_normal, raw)]
    letters = next(filter(None, map(_letters_of, texts)), {})
    places = tuple(map(place, lines))
    numbers = accumulate((graph.own.get(p) if p in graph.component else None for p in places), _or_before)
    values = np.array([*numbers], dtype=float)
    typed = 2 * sum(p in graph.trees for p in places) < len(places)
    unit = np.rad2deg(1) if any(re.search(IN_RADIANS, each) for each in texts) else 1.0
    said = ""
    for line in range(lines[0] - 1, max(lines[0] - 4, 0), -1):  # the nearest text before, as of a group
        group = next(filter(None, (_normal(text(place(line, n))) for n in range(number, 0, -1))), "")
        parts = [part for part, pattern in SAID.items() if pattern.search(group)]
        said = said or (parts[0] if len(parts) == 1 else "")
    own = {UNIT.sub("", each).strip() for each in raw[:1]}
    said = said or next((part for part, case in (("linear", "XYZ"), ("tip", "xyz")) if set(case) & own), "")
    return Column(places, values, letters, typed, unit, said)


def _or_before(before: float, number: float | None) -> float:
    """A number or, where there is none, the one before, as of words that say only what changes."""
    return before if number is None else number


def _normal(text: str) -> str:
    """A text in small letters and plain signs."""
    return unicodedata.normalize("NFKC", text).strip().lower()


def _letters_of(heading: str) -> dict[str, int]:
    """The letters that a heading names, as in "a", "x_nc", "刀轴i", "px", "ti" or "zm"."""
    said = UNIT.sub("", heading).strip()
    if re.fullmatch("[a-z]", said):
        return {said: PLAIN}
    named = re.findall(r"(?<![a-z])(?:(?:tip|axis|tool|ax|[ptnev])(?=[xyzijk]))?([a-z])(?![a-z0-9])", said)
    named += re.findall(r"(?<![a-z])([xyz])(?:cl|nc|mcs|wcs|[a-z])(?![a-z])", said)
    return dict.fromkeys(named, PLAIN if MACHINE.search(said) else AMONG_OTHERS)


class Headed:
    """The columns of a table as headings name them; false if they do not name all.

    `parts` are the columns of tip, tool axis and words; `exchanged` has a cell and a sentence if most rows are
    right only with some headings exchanged.
    """

    def __init__(self, graph: Graph, columns: Sequence[Column], alone: bool, kinematics: Kinematics) -> None:
        self.graph, self.columns, self.kinematics, self.alone = graph, [*columns], kinematics, alone
        joints = [name[0].lower() for name in kinematics.machine.joint_names]
        said = {letter for column in columns for letter in column.letters}
        letters = next((letters for letters in ("ijk", "uvw") if not said.isdisjoint(letters)), "xyz")
        groups = {"tip": "xyz", "axis": letters, "linear": joints[:3], "rotary": joints[3:]}
        groups = {part: groups[part] for part in ("axis", "rotary")} if alone else groups
        self.headings = [(part, letter) for part, group in groups.items() for letter in group]
        self.sample = np.unique(np.linspace(0, len(columns[0].values) - 1, MOST).astype(int))
        self.exchanged: tuple[Place, str] | tuple[()] = ()
        orders = [] if alone and letters == "xyz" else self._orders()
        order = self._order(orders) if orders else ()
        self.parts = [order[n:m] for n, m in ((0, 0), (0, 3), (3, 5)) if order] if alone else []
        self.parts = [order[:3], order[3:6], order[6:]] if order and not alone else self.parts

    def __bool__(self) -> bool:
        return bool(self.parts)

    def _orders(self) -> list[Order]:
        """The columns of the headings; several if the tip and X Y Z are only told by which comes first."""
        if any(not column.typed for column in self.columns):
            pools = [self._pool(*heading) for heading in self.headings]
            return [order for order in islice(product(*pools), MOST_ORDERS) if len({*order}) == len(order)]
        asked, found = Counter(letter for _, letter in self.headings), {}
        for letter, count in asked.items():
            any_of = [n for n, column in enumerate(self.columns) if letter in column.letters]
            plain = [n for n in any_of if self.columns[n].letters[letter] == PLAIN]
            found[letter] = plain if len(plain) == count else any_of
            if len(found[letter]) != count:
                return []
        orders: dict[Order, None] = {}
        for parts in permutations(dict.fromkeys(part for part, _ in self.headings)):
            taken: dict[Heading, int] = {}
            for letter, numbers in found.items():
                mine = [part for part in parts if (part, letter) in self.headings]
                said = {part: [n for n in numbers if self.columns[n].said == part] for part in mine}
                told = {part: of[0] for part, of in said.items() if len(of) == 1}
                left = [n for n in numbers if n not in told.values()]
                told |= dict(zip([part for part in mine if part not in told], left, strict=True))
                taken |= {(part, letter): n for part, n in told.items()}
            if len({*taken.values()}) == len(taken):
                orders[tuple(taken[heading] for heading in self.headings)] = None
        return [*orders]

    def _pool(self, part: str, letter: str) -> list[int]:
        """The columns that a heading may name in a table with formulas: a letter alone, the last first."""
        columns, of_words = self.columns, part in ("linear", "rotary")
        found = [n for n, c in enumerate(columns) if letter in c.letters and not (of_words and c.typed)]
        found = found if of_words else [n for n in found if columns[n].typed] or found
        found = [n for n in found if columns[n].letters[letter] == PLAIN] or found
        first = {n: columns[n].places[0] for n in found}
        used = {p for n in found if of_words for p in self.graph.upstream([first[n]]) - {first[n]}}
        return sorted(found, key=lambda n: (first[n] in used, columns[n].said != part, columns[n].said in SAID))

    def _order(self, orders: list[Order]) -> Order:
        right = self._right(np.array(orders))
        if right.max() >= 0.5:
            return orders[int(np.argmax(right >= 0.5))]
        for order in orders[:2]:
            others = np.array(order)[self._exchanges()]
            right = self._right(others, order)
            for other in (tuple(map(int, others[n])) for n in np.flatnonzero(right > 0.5)):
                first = [self.columns[n].places[0] for n in (other[:3] if self.alone else other[:6])]
                words = [self.columns[n].places[0] for n in (other[3:] if self.alone else other[6:])]
                if self.graph.upstream(first).isdisjoint(words):
                    self._exchange(order, other)
                    return other
        has_formulas = any(not column.typed for column in self.columns)
        return orders[0] if len(orders) == 1 or not has_formulas else ()  # no number tells which columns are meant

    def _exchanges(self) -> np.ndarray:
        """Orders of the headings: two exchanged, three of a part in another order, two parts, or the words."""
        same = [*range(len(self.headings))]
        of = {part: [n for n in same if self.headings[n][0] == part] for part, _ in self.headings}
        ways: list[tuple[Sequence[int], Sequence[int]]] = [((a, b), (b, a)) for a, b in combinations(same, 2)]
        threes = [numbers for numbers in of.values() if len(numbers) == 3]
        ways += [(numbers, (*numbers[k:], *numbers[:k])) for numbers in threes for k in (1, 2)]
        ways += [((*a, *b), (*b, *a)) for a, b in combinations(threes, 2)]
        words = [*of.get("linear", ()), *of["rotary"]]
        ways += [(words, order) for order in permutations(words)]
        found = np.tile(same, (len(ways), 1))
        for row, (numbers, others) in zip(found, ways, strict=True):
            row[[*numbers]] = others
        return found

    def _exchange(self, order: Order, other: Order) -> None:
        """Say that columns stand under the headings of others, whose units they then have."""
        columns = [*self.columns]
        for n, k in zip(other, order, strict=True):
            self.columns[n] = replace(columns[n], unit=columns[k].unit)
        said, meant = (dict(zip(each, self.headings, strict=True)) for each in (order, other))
        off = [n for n in order if said[n] != meant[n]]
        text = f"{_name(meant[off[0]])} stands under the heading {_name(said[off[0]])}: exchanged"
        if {said[n][0] for n in off} == {"tip", "linear"}:
            if len(off) == 6:
                text = "the headings say that this is the tip, and that the tip is X Y Z: exchanged"
            names = [_name(meant[n]) for n in off if meant[n][0] == "linear"]
            are_off = f"{' '.join(names)} {'is' if len(names) == 1 else 'are'} off in every row"
            text += f", or {are_off}"
        first = columns[off[0]]
        words = [columns[n].places[0] for n in other[-2 if self.alone else -5 :]]
        made = [p for p in words if first.places[0] in self.graph.upstream([p])] if first.typed else []
        self.exchanged = (made or [first.places[0]])[0], text

    def _right(self, orders: np.ndarray, headed: Order | None = None) -> np.ndarray:
        """The share of rows whose words put the tool where they say, with the columns in each order, shape (n,).

        The units of rotary words are those in the headings over them, or over the columns in the order `headed`.
        """
        values = np.array([column.values[self.sample] for column in self.columns])[orders].swapaxes(1, 2)
        unit_of = np.array([column.unit for column in self.columns])
        joints = np.zeros((*values.shape[:2], 5))
        joints[..., 3:] = values[..., -2:] * unit_of[orders if headed is None else [headed]][:, None, -2:]
        joints[..., :3] = 0.0 if self.alone else values[..., -5:-2]
        tip, axis = self.kinematics.forward(np.nan_to_num(joints), degrees=True)
        wanted = values[..., :3] if self.alone else values[..., 3:6]
        wanted = wanted / np.linalg.norm(wanted, axis=-1, keepdims=True)
        fits = np.isfinite(values).all(axis=-1) & (np.abs(axis - wanted).max(axis=-1) < np.deg2rad(CLOSE))
        if not self.alone:
            fits &= np.abs(tip - values[..., :3]).max(axis=-1) < CLOSE
        return fits.mean(axis=-1)


def _name(heading: Heading) -> str:
    part, letter = heading
    return {"tip": f"{letter} of the tip", "axis": f"{letter} of the tool axis"}.get(part, letter.upper())
