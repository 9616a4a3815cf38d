"""Which changes explain an answer: the one shape of every search.

A `Slip` is one change: its kind, how far-fetched it is, its sentence, and what it does to a way of computing. A
search applies slips to the right way (`misread`) and keeps each way that gives the answer as a `Match`;
`explanation` ranks them, puts those together that are the same everywhere, and proposes an experiment that tells
the others apart.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from itertools import combinations
from operator import attrgetter
from typing import Any, TypeVar

import numpy as np

COST = attrgetter("cost")
CHANCE = 0.005  # expected accidental matches above which a match explains nothing
FAR_FETCHED = 1.0  # misreadings that cost this much more than the simplest are not shown
MOST, SHOWN = 400, 6  # matches examined, misreadings shown: right angles and points on an axis have many
UNROUNDED = "unrounded"  # the kind of slip that is no mistake: more digits of the input were used than are given
Way = TypeVar("Way", bound=Any)  # of computing: a dataclass with `slips`


@dataclass(frozen=True)
class Slip:
    """One mistake: its kind in a word, how far-fetched it is, its sentence, the change to a way of computing."""

    kind: str
    cost: float
    phrase: str
    change: Callable[[Any], Any] = field(default=lambda way: way, compare=False)


def setting(**changes: Any) -> Callable[[Any], Any]:
    """Return the change that sets fields of a way of computing."""
    return lambda way: replace(way, **changes)


def misread(way: Way, *slips: Slip) -> Way:
    """Return a way of computing with slips applied in order."""
    for slip in slips:
        way = slip.change(way)
    return replace(way, slips=(*way.slips, *slips))


def cost_of(slips: Iterable[Slip]) -> float:
    """Return how far-fetched slips are together."""
    return sum(slip.cost for slip in slips)


@dataclass(frozen=True, eq=False)
class Match:
    """A way of computing that gives the answer; without slips it is the right one."""

    slips: tuple[Slip, ...]
    product: str  # the computation as text
    value: Callable[[Any], np.ndarray]  # its result for the question, or for any other input
    tie: float = 0.0  # decides between ways whose slips cost the same
    right: str = "right"
    known_as: str = ""  # whose convention it is

    @property
    def cost(self) -> float:
        return self.tie + cost_of(self.slips)

    @property
    def sentence(self) -> str:
        said = " and ".join(slip.phrase for slip in self.slips) or self.right
        return said + (f" (as {self.known_as})" if self.known_as else "")


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
        return f"{self.sentence}: {self.product}" if self.product else self.sentence


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


@dataclass(frozen=True)
class Trial:
    """A question, and other inputs at which ways of computing can be compared."""

    given: Any
    generic: Sequence[Any]  # ways that agree at these agree everywhere
    probes: Iterable[tuple[str, Any]]  # experiments in words, and their inputs
    written: Callable[[np.ndarray], str]
    what: str  # that is the same for several ways: "number", "angles", "rotation"
    apart: float = 0.05  # between results that can be told apart


def explanation(
    matches: Iterable[Match],
    trial: Trial,
    tolerance: float,
    tried: int,
    *,
    shape: tuple[int, ...] | None = None,
    otherwise: Callable[[], str] = str,
    travel: tuple[str, ...] = (),
) -> Explanation:
    """Return the explanation by matches, the simplest first; by `otherwise` what is known if there is none."""
    groups = _grouped(matches, trial)[:SHOWN]
    misreadings = []
    for first, *others in groups:
        value = first.value(trial.given)
        same = [match for match in sorted(others, key=COST) if match.cost <= first.cost + FAR_FETCHED]
        wordings = tuple(f"{match.sentence}: {match.product}" for match in same)
        kinds = tuple(slip.kind for slip in first.slips)
        value = value if shape is None else value.reshape(shape)
        misreadings.append(Misreading(first.sentence, first.product, kinds, value, wordings, first.cost))
    note = _tell_apart([group[0] for group in groups], trial) if len(groups) > 1 else ""
    return Explanation(tuple(misreadings), tolerance, tried, note if groups else otherwise(), travel)


def _grouped(matches: Iterable[Match], trial: Trial) -> list[list[Match]]:
    """The matches worth showing, the least far-fetched first, in lists of those that agree everywhere.

    One that has all the slips of another and more explains nothing.
    """
    ranked = sorted(matches, key=COST)[:MOST]
    near = [match for match in ranked if match.cost <= ranked[0].cost + FAR_FETCHED]
    sets = [set(match.slips) for match in near]
    groups: dict[Any, list[Match]] = {}
    for match, own in zip(near, sets, strict=True):
        if not any(own > other for other in sets):
            values = np.array([match.value(each) for each in trial.generic])
            key = (np.round(values, 6) + 0.0).tobytes() if np.isfinite(values).all() else match.slips
            groups.setdefault(key, []).append(match)
    return list(groups.values())


def _tell_apart(ways: Sequence[Match], trial: Trial) -> str:
    """Propose the experiment for which the most ways differ, with the result of each."""
    said, pairs, best, most = f"{len(ways)} misreadings give the same {trial.what} here", len(ways), None, 0
    for asked, probe in trial.probes:
        values = [way.value(probe) for way in ways]
        apart = sum(bool(np.abs(a - b).max() > trial.apart) for a, b in combinations(values, 2))
        if apart > most and np.isfinite(values).all():
            best, most = (asked, values), apart
        if most == pairs * (pairs - 1) // 2:
            break
    if best is None:
        return f"{said}, and nearly the same everywhere."
    results = "; ".join(f"{way.sentence}: {trial.written(value)}" for way, value in zip(ways, best[1], strict=True))
    return f"{said}. To tell them apart, try {best[0]}: {results}."
