"""Explanations of an answer: the simplest misreadings, each a set of slips, that give this answer."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Hashable, Iterable, Sequence
from dataclasses import dataclass, field
from operator import attrgetter
from typing import Any, TypeVar

import numpy as np

COST = attrgetter("cost")
CHANCE = 0.005  # expected accidental matches above which a match explains nothing
FAR_FETCHED = 1.0  # misreadings that cost this much more than the simplest are not shown
UNROUNDED = "unrounded"  # the kind of slip that is no mistake: more digits of the input were used than are given


@dataclass(frozen=True)
class Slip:
    """One mistake: its kind in a word, how far-fetched it is, its description, the fields that it changes."""

    kind: str
    cost: float
    phrase: str
    changes: dict[str, Any] = field(default_factory=dict, compare=False)


@dataclass(frozen=True)
class Misreading:
    """One misreading that gives the answer; without slips it is the right way."""

    sentence: str  # the mistake, such as "the final transpose is missing"
    product: str  # the matrix product: E is a passive elementary matrix, R an active one, p the point
    kinds: tuple[str, ...]  # of slip, such as ("transpose",)
    value: np.ndarray  # its result, in the shape of the answer
    same: tuple[str, ...]  # other wordings of the identical product, with their products
    cost: float  # how far-fetched it is: about one for each slip

    def __str__(self) -> str:
        return f"{self.sentence}: {self.product}"


@dataclass(frozen=True)
class Explanation:
    """The result of `explain`, `explain_joints` and the like."""

    misreadings: tuple[Misreading, ...]  # those that give the answer, the simplest first
    tolerance: float  # how far a misreading may be from the answer: half of the last digit written
    tried: int  # how many misreadings were compared with it
    note: str = ""  # how to tell several misreadings apart, or the facts if none fits
    travel: tuple[str, ...] = ()  # sentences on rotary words outside travel, which no misreading excuses

    @property
    def explained(self) -> bool:
        """Whether any misreading gives the answer."""
        return bool(self.misreadings)

    @property
    def right(self) -> bool:
        """Whether the right way gives the answer, even if with more digits of the angles than are given."""
        return self.explained and set(self.misreadings[0].kinds) <= {UNROUNDED}

    def __str__(self) -> str:
        lines = list(map(str, self.misreadings)) or [f"No misreading explains it ({self.tried} were tried)."]
        return "\n".join([*lines, *self.travel, *([self.note] if self.note else [])])


class Misread(ABC):
    """Anything with `slips`: their total cost and their description."""

    @property
    @abstractmethod
    def slips(self) -> tuple[Slip, ...]:
        """The mistakes."""

    @property
    def cost(self) -> float:
        return sum(slip.cost for slip in self.slips)

    @property
    def sentence(self) -> str:
        return " and ".join(slip.phrase for slip in self.slips) or "right"


class Match(Misread):
    """A misreading that gives the answer."""

    @property
    @abstractmethod
    def product(self) -> str:
        """The computation as text."""


AnyMatch = TypeVar("AnyMatch", bound=Match)


def grouped(
    matches: Iterable[AnyMatch], key: Callable[[AnyMatch], Hashable], most: int | None = None
) -> list[list[AnyMatch]]:
    """Return the matches worth showing, the least far-fetched first, in lists of those with one `key`.

    The first `most` are examined; one that has all the slips of another and more explains nothing.
    """
    ranked = sorted(matches, key=COST)[:most]
    near = [match for match in ranked if match.cost <= ranked[0].cost + FAR_FETCHED]
    groups: dict[Hashable, list[AnyMatch]] = {}
    for match in near:
        if not any(set(match.slips) > set(other.slips) for other in near):
            groups.setdefault(key(match), []).append(match)
    return list(groups.values())


def told(group: Sequence[Match], value: np.ndarray) -> Misreading:
    """Return the first of a group of matches with one `value` as a `Misreading`; the others go to its `same`."""
    first, *others = group
    near = [match for match in sorted(others, key=COST) if match.cost <= first.cost + FAR_FETCHED]
    same = tuple(f"{match.sentence}: {match.product}" for match in near)
    kinds = tuple(slip.kind for slip in first.slips)
    return Misreading(first.sentence, first.product, kinds, value, same, first.cost)
