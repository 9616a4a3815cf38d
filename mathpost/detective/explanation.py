"""Explanations of an answer: the simplest misreadings, each a set of slips, that give this answer."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Hashable, Iterable, Sequence
from dataclasses import dataclass, field
from operator import attrgetter
from typing import Any, TypeVar

import numpy as np

COST = attrgetter("cost")
CHANCE = 0.005  # how probable an accidental match may be before it explains nothing
FAR_FETCHED = 1.0  # misreadings so much more complicated than the simplest one are not shown
UNROUNDED = "unrounded"  # the kind of slip that is none: more digits of the input were used than are given


@dataclass(frozen=True)
class Slip:
    """One thing misread: its kind in a word, how far-fetched it is, the words for it, what it changes."""

    kind: str
    cost: float
    phrase: str
    changes: dict[str, Any] = field(default_factory=dict, compare=False)


@dataclass(frozen=True)
class Misreading:
    """One misreading that gives the answer; without slips it is the right way."""

    sentence: str  # what was misread, as in "the final transpose is missing"
    product: str  # the matrix product: E is a passive elementary matrix, R an active one, p the point
    kinds: tuple[str, ...]  # of slip, such as ("transpose",)
    value: np.ndarray  # what it gives, in the shape of the answer
    same: tuple[str, ...]  # other wordings of the identical product, with their products
    cost: float  # how much has to be misread: about one for each slip

    def __str__(self) -> str:
        return f"{self.sentence}: {self.product}"


@dataclass(frozen=True)
class Explanation:
    """What `explain` or `explain_joints` found."""

    misreadings: tuple[Misreading, ...]  # those that give the answer, the simplest first
    tolerance: float  # how far a misreading may be from the answer: half of the last digit written
    tried: int  # how many were compared with it
    note: str = ""  # how to tell several misreadings apart, or what is known if none fits
    travel: tuple[str, ...] = ()  # sentences on rotary words outside travel, which no misreading excuses

    @property
    def explained(self) -> bool:
        """Whether any misreading gives the answer."""
        return bool(self.misreadings)

    @property
    def right(self) -> bool:
        """Whether the right way gives the answer, be it with more digits of the angles than are given."""
        return self.explained and set(self.misreadings[0].kinds) <= {UNROUNDED}

    def __str__(self) -> str:
        lines = list(map(str, self.misreadings)) or [f"No misreading explains it ({self.tried} were tried)."]
        return "\n".join([*lines, *self.travel, *([self.note] if self.note else [])])


class Misread(ABC):
    """Anything with `slips`: what they cost together, and the words for them."""

    @property
    @abstractmethod
    def slips(self) -> tuple[Slip, ...]:
        """What was misread."""

    @property
    def cost(self) -> float:
        return sum(slip.cost for slip in self.slips)

    @property
    def sentence(self) -> str:
        return " and ".join(slip.phrase for slip in self.slips) or "right"


class Match(Misread):
    """One that gives the answer."""

    @property
    @abstractmethod
    def product(self) -> str:
        """What was computed, as text."""


AnyMatch = TypeVar("AnyMatch", bound=Match)


def grouped(
    matches: Iterable[AnyMatch], key: Callable[[AnyMatch], Hashable], most: int | None = None
) -> list[list[AnyMatch]]:
    """Return the matches worth telling, the least far-fetched first, in lists of those with one `key`.

    The first `most` are looked at; one that has all the slips of another and more explains nothing.
    """
    ranked = sorted(matches, key=COST)[:most]
    near = [match for match in ranked if match.cost <= ranked[0].cost + FAR_FETCHED]
    groups: dict[Hashable, list[AnyMatch]] = {}
    for match in near:
        if not any(set(match.slips) > set(other.slips) for other in near):
            groups.setdefault(key(match), []).append(match)
    return list(groups.values())


def told(group: Sequence[Match], value: np.ndarray) -> Misreading:
    """Return the first of a group of matches, all of one `value`, as a `Misreading`; the others are the same."""
    first, *others = group
    near = [match for match in sorted(others, key=COST) if match.cost <= first.cost + FAR_FETCHED]
    same = tuple(f"{match.sentence}: {match.product}" for match in near)
    kinds = tuple(slip.kind for slip in first.slips)
    return Misreading(first.sentence, first.product, kinds, value, same, first.cost)
