"""Which columns of a table of NC words are the tip, the tool axis and the words: told by what the numbers are."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import permutations, product
from typing import TYPE_CHECKING, Any

import numpy as np

from mathpost.rotation import wrap
from mathpost.workbook.meaning.nc_headings import AMONG_OTHERS, PLAIN

if TYPE_CHECKING:
    from mathpost.kinematics import Kinematics
    from mathpost.workbook.meaning.nc_columns import Column
    from mathpost.workbook.sheet.graph import Graph

CLOSE = 0.1  # degrees, mm: close enough to recognise a word; whether it is right is judged elsewhere
# How many words must fit, so that it is no coincidence: without all their headings, and with them.
ENOUGH, ENOUGH_OF_ONE_ROW, ENOUGH_BESIDE = (3, 0), (6, 3), (4, 4)
ENOUGH_OF_ROTARY = (2, 1)  # of a table of rotary words alone


class Roles:
    """The search for the numbers of the columns of tip, axis and words."""

    def __init__(self, graph: Graph, columns: Sequence[Column], kinematics: Kinematics, sample: np.ndarray) -> None:
        self.graph, self.columns, self.kinematics = graph, columns, kinematics
        self.values = np.array([column.values[sample] for column in columns])
        self.degrees = self.values * np.array([[column.unit] for column in columns])  # if they are angles
        self.names = [name[0].lower() for name in kinematics.machine.joint_names]

    def find(self, enough: tuple[int, int]) -> dict[str, Sequence[int]] | None:
        """The columns by "tip", "axis", "words"; None if there are not all, or fewer words fit than `enough`."""
        triples = self.triples("ijk", "uvw", "xyz")
        if not triples:
            return None
        demanded = self.inverse(np.array([self.vectors(triple) for triple in triples]))
        alike = [self.axis_score(*each) for each in zip(triples, demanded, strict=True)]
        first = int(np.argmax(alike))
        if alike[first] < 0.5:
            return None
        axis, self.demanded = triples[first], demanded[first]
        words: dict[int, Any] = {}
        for k in (3, 4):
            words[k] = self.choose(k, self.turning(self.demanded[..., k - 3]), {*axis, *words.values()})
        if list(words.values()).count(None) > 1:
            return None
        words = self.as_they_fit(words, {k: self.turning(self.demanded[..., k - 3]) for k in words})
        if enough == ENOUGH_OF_ROTARY:
            return self.rotary_alone(axis, words)
        tips = [t for t in self.triples("xyz") if not {*axis, *words.values()}.intersection(t)]
        after = {self.columns[n].places[0] for n in (*axis, *words.values()) if n is not None}
        tips = [t for t in tips if after.isdisjoint(self.graph.upstream(self.columns[n].places[0] for n in t))]
        choices = [n for n in range(len(self.columns)) if n not in (*axis, *words.values())]
        lost = next((k for k in words if words[k] is None), None)
        best: tuple[float, Any, Any] = 0.3 if lost is None else 2.9, None, None  # a lost one is found by X Y Z
        for n in choices if lost else (None,):
            self.turn_by(words | {lost: n} if lost else words, alone=lost is None)
            scores = [(self.tip_score(t, axis), t, n) for t in tips if n not in t]
            best = max([best, *scores], key=lambda score: score[0])
        _, tip, n = best
        if tip is None:
            return None
        words |= {lost: n} if lost else {}
        self.turn_by(words)
        fits = [*self.linear(tip)]
        plain = {k: self.plainly(k, {*tip, *axis, *words.values()}) for k in range(3)}
        for k in range(3):
            words[k] = (
                max((fits[k][n], n) for n in plain[k])[1]  # these are it, whatever fits: a step may
                if all(plain.values())
                else self.choose(k, fits[k], {*tip, *axis, *words.values()}, 2 * AMONG_OTHERS)
            )
        for k, n in product(range(3), repeat=2):  # one that is all wrong is between the others, or next to them
            free = set(range(len(self.columns))) - {*tip, *axis, *words.values()}
            if words[k] is None and words[n] is not None and words[n] + k - n in free:
                words[k] = words[n] + k - n
        for k in range(3):
            if words[k] is None:
                words[k] = self.choose(k, fits[k], {*tip, *axis, *words.values()})
        if None in words.values() or len(set(words.values())) < 5:
            return None
        words |= self.as_they_fit({k: words[k] for k in range(3)}, fits)
        fits = [*fits, *(self.turning(self.demanded[..., k]) for k in (0, 1))]
        fitting = sum(fits[k][n] >= 0.5 for k, n in words.items())
        headed = all(self.names[k] in self.columns[n].letters for k, n in words.items())
        if fitting < enough[headed]:
            return None  # a coincidence
        return {"tip": tip, "axis": axis, "words": [words[k] for k in range(5)]}

    @staticmethod
    def as_they_fit(words: dict[int, Any], fits: Mapping[int, np.ndarray] | Sequence[np.ndarray]) -> dict[int, Any]:
        """Columns, by joint, reassigned by their numbers if they are right only under each other's headings."""
        for columns in permutations(words.values()) if None not in words.values() else ():
            if all(fits[k][n] > 0.5 for k, n in zip(words, columns, strict=True)):
                return dict(zip(words, columns, strict=True))
        return words

    def rotary_alone(self, axis: Sequence[int], words: dict[int, Any]) -> dict[str, Sequence[int]] | None:
        """Rotary words without others, unless the table has as many further numbers as a tip and X Y Z."""
        others = [c for n, c in enumerate(self.columns) if n not in (*axis, *words.values()) and c.typed]
        if None in words.values() or len(others) >= 6:
            return None
        fitting = sum(self.turning(self.demanded[..., k - 3])[n] >= 0.5 for k, n in words.items())
        headed = all(self.names[k] in self.columns[n].letters for k, n in words.items())
        found = {"tip": (), "axis": axis, "words": [*words.values()]}
        return found if fitting >= ENOUGH_OF_ROTARY[headed] else None

    def triples(self, *groups: str) -> list[tuple[int, int, int]]:
        """Three columns side by side, or as far apart, of headings that name such letters."""
        found = [(n, n + 1, n + 2) for n in range(len(self.columns) - 2)]
        for group in groups:
            headed = [[n for n, c in enumerate(self.columns) if letter in c.letters] for letter in group]
            found += [(a, b, c) for a, b, c in product(*headed) if a != b and b - a == c - b][:200]
        return list(dict.fromkeys(found))

    def vectors(self, triple: Sequence[int]) -> np.ndarray:
        return np.stack([self.values[n] for n in triple], axis=-1)

    def inverse(self, axes: np.ndarray) -> np.ndarray:
        """The rotary words of both branches in degrees, shape (..., rows, 2, 2); NaN where there are none."""
        good = np.isfinite(axes).all(axis=-1) & (np.abs(axes).max(axis=-1) > 1e-6)
        found = np.full((*good.shape, 2, 2), np.nan)
        found[good] = self.kinematics.inverse(np.zeros(3), axes[good], degrees=True)[..., 3:]
        return found

    def turn_by(self, words: dict[int, Any], alone: bool = False) -> None:
        """Take the rotary words as they are and, unless these `alone` are to tell, as they are demanded."""
        own = np.stack([self.degrees[words[k]] for k in (3, 4)], axis=-1)
        self.rotary = np.stack([own] if alone else [own, self.demanded[:, 0], self.demanded[:, 1]])

    def turning(self, wanted: np.ndarray) -> np.ndarray:
        """How much of each column is one of the angles wanted, shape (rows, branches)."""
        off = np.abs(wrap(self.degrees[..., None] - wanted))
        return (off < CLOSE).any(axis=-1).mean(axis=-1)

    def axis_score(self, triple: Sequence[int], both: np.ndarray) -> float:
        """How much three columns are a tool axis, of which `both` are the rotary words."""
        vectors = self.vectors(triple)
        others = [n for n in range(len(self.columns)) if n not in triple]
        fit = sum(self.turning(both[..., k])[others].max(initial=0) for k in (0, 1))
        units = np.mean(np.abs(np.linalg.norm(vectors, axis=1) - 1) < 2e-3)
        return fit + 0.2 * units + self.headed(triple, "ijk", "uvw", "xyz") + self.typed(triple)

    def linear(self, tip: Sequence[int]) -> np.ndarray:
        """How much of each column is X, Y, Z with that tip, shape (3, columns); half if it is but shifted."""
        wanted = self.kinematics.close(self.vectors(tip), np.deg2rad(self.rotary))[..., :3]
        off = self.values - np.swapaxes(wanted, 1, 2)[:, :, None]  # ways to turn, X Y Z, columns, rows
        shifted = off - np.median(np.nan_to_num(off, nan=1e9), axis=-1, keepdims=True)
        fits = [(np.abs(each) < CLOSE).mean(axis=-1) * weight for each, weight in ((off, 1.0), (shifted, 0.5))]
        return np.max(fits, axis=(0, 1))

    def tip_score(self, tip: Sequence[int], axis: Sequence[int]) -> float:
        others = [n for n in range(len(self.columns)) if n not in (*tip, *axis)]
        fit = self.linear(tip)[:, others].max(axis=1, initial=0).sum()
        return fit + self.headed(tip, "xyz") + self.typed(tip)

    def headed(self, triple: Sequence[int], *groups: str) -> float:
        return 0.3 * any(
            all(letter in self.columns[n].letters for n, letter in zip(triple, group, strict=True))
            for group in groups
        )

    def typed(self, triple: Sequence[int]) -> float:
        return 0.2 * all(self.columns[n].typed for n in triple)

    def plainly(self, joint: int, taken: set[int]) -> list[int]:
        """The columns with nothing but the letter of a word over them."""
        letter = self.names[joint]
        return [n for n, c in enumerate(self.columns) if n not in taken and c.letters.get(letter) == PLAIN]

    def choose(self, joint: int, fits: np.ndarray, taken: set[int], least: float = AMONG_OTHERS) -> int | None:
        """The column of a word: the one with its letter over it, if there is one, that fits best."""
        letter = self.names[joint]
        left = {n: c for n, c in enumerate(self.columns) if n not in taken}
        value = {n: fits[n] + c.letters.get(letter, -c.more) + c.more for n, c in left.items()}
        best = max(value, key=lambda n: (value[n], n), default=None)
        headed = any(c.letters.get(letter) == PLAIN for c in left.values())
        if best is None or value[best] < least or (headed and letter not in left[best].letters):
            return None  # what has the heading is not it, and another that has none is: who knows
        return best
