"""Every way to misread a rotation by three Euler angles, enumerated, evaluated and put into words.

A misreading is a set of slips; the right way has none. It has two parts. The *wording* is the form of the product:
which of the two recipes of source 000, in what order, with active or passive elements, with which signs, transposed
or not; 384 wordings give 48 different products. Of a rotation that is not applied to a point the wording says
instead whether the axes are turned or fixed ones, and whether it is the inverse. The *factors* are the angles and
axes in the product, and the place of the point: a slip changes the right ones. What a number may mean is in
`misreadings.toml`.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import chain, combinations, permutations, product
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from mathpost import euler
from mathpost.detective.causes import slip
from mathpost.detective.explanation import COST, Slip, cost_of, misread, setting
from mathpost.detective.notations import WRITERS
from mathpost.files import read_toml
from mathpost.formula import from_angles
from mathpost.rotation import PASSIVE

ANGLES = "αβγ"
NOWHERE = (0.0, 0.0, 0.0)
MEANINGS, PLACINGS = (read_toml(Path(__file__).with_name(f"{name}.toml")) for name in ("misreadings", "placings"))
# The keys of a few misreadings of the recipes of source 000.
COMMON = {
    "active elements": ((2, 1, 0), (-1, -1, -1)),
    "transpose missing": ((0, 1, 2), (-1, -1, -1)),
    "order α·β·γ": ((0, 1, 2), (1, 1, 1)),
    "sign of α": ((2, 1, 0), (-1, 1, 1)),
    "sign of β": ((2, 1, 0), (1, -1, 1)),
    "sign of γ": ((2, 1, 0), (1, 1, -1)),
}
Key = tuple[tuple[int, ...], tuple[int, ...]]  # of a product: the order of its rotations, and their signs


def inverse(key: Key) -> Key:
    """Return the key of the transposed product."""
    order, signs = key
    return order[::-1], tuple(-sign for sign in signs)


@dataclass(frozen=True)
class Wording:
    """One form of the product; `order` and `signs` are as stated, before any transpose."""

    recipe: int
    active: bool
    order: tuple[int, ...]
    signs: tuple[int, ...]
    transposed: bool
    slips: tuple[Slip, ...] = ()

    @property
    def cost(self) -> float:
        return 0.01 * self.recipe + cost_of(self.slips)

    @property
    def key(self) -> Key:
        """The product that it gives: rotations from left to right and the signs of their passive elements."""
        stated = self.order, tuple(-s if self.active else s for s in self.signs)
        return inverse(stated) if self.transposed else stated


@dataclass(frozen=True)
class Factors:
    """The angles and axes of the first, second and third rotation, and the place of the point."""

    axes: str
    source: tuple[int, ...] = (0, 1, 2)  # index of the angle used for each
    meaning: tuple[str, ...] = ("degrees",) * 3
    before: tuple[float, ...] = NOWHERE  # added to the point before the rotation, and after it
    after: tuple[float, ...] = NOWHERE
    point: str = "p"  # the text for each
    added: str = ""
    slips: tuple[Slip, ...] = ()

    @property
    def cost(self) -> float:
        return cost_of(self.slips)

    def degrees(self, angles: np.ndarray) -> np.ndarray:
        """The angle of each rotation, shape (3,), from the numbers that are given."""
        meant = [MEANINGS[meaning] for meaning in self.meaning]
        factors, offsets = [each.get("factor", 1.0) for each in meant], [each.get("offset", 0.0) for each in meant]
        return angles[list(self.source)] * factors + offsets

    def placed(self, place: Factors) -> Factors:
        """Return them with the point, and the slips, of others."""
        where = {name: getattr(place, name) for name in ("before", "after", "point", "added")}
        return replace(self, **where, slips=(*self.slips, *place.slips))

    def matters(self, angles: np.ndarray) -> bool:
        """Whether the meaning changes any angle: half of 0 is no slip."""
        plain = replace(self, meaning=("degrees",) * 3)
        return self.meaning == plain.meaning or not np.array_equal(self.degrees(angles), plain.degrees(angles))


def placings(origin: np.ndarray, sequence: str, turned: bool) -> tuple[Factors, ...]:
    """The factors to start from if `origin` is that of the turned frame; the first are right.

    The point is to be taken relative to it, or if the point itself is `turned`, it is to be added in the end.
    """

    def placed(way: dict[str, Any]) -> Factors:
        before, after = (way.get(when, 0) for when in ("before", "after"))
        return Factors(
            sequence,
            before=tuple((before * origin).tolist()),
            after=tuple((after * origin).tolist()),
            point={0: "p", -1: "(p − o)", 1: "(p + o)"}[before],
            added={0: "", -1: " − o", 1: " + o"}[after],
        )

    said = PLACINGS["active" if turned else "passive"]
    wrong = [replace(placed(way), slips=(Slip(way["kind"], way["cost"], way["phrase"]),)) for way in said["wrong"]]
    return placed(said["right"]), *wrong


@lru_cache(maxsize=4)
def wordings(fixed: bool = False, turned: bool = False) -> dict[Key, list[Wording]]:
    """Return the 48 products: a dict from `Wording.key` to its wordings, the simplest first.

    About `fixed` axes the right order of the factors is the opposite one; so it is if the point itself is `turned`
    (active), by active elementary matrices.
    """
    everything = product((0, 1), (False, True), permutations(range(3)), product((1, -1), repeat=3), (False, True))
    return _by_key(_worded(*each, fixed=fixed, turned=turned) for each in everything)


def _worded(
    recipe: int, active: bool, order: tuple[int, ...], flips: tuple[int, ...], transpose_wrong: bool,
    *, fixed: bool, turned: bool,
) -> Wording:  # fmt: skip
    slips = []
    if active != turned:
        found_and_right = ("active", "passive") if active else ("passive", "active")
        phrase = "the elementary matrices are {} where {} ones belong".format(*found_and_right)
        slips.append(Slip("active", 1, phrase))
    right_order = (2, 1, 0) if (fixed != turned) == bool(recipe) else (0, 1, 2)
    if order != right_order:
        phrase = f"the product is taken in the order {_dots(order)}, not {_dots(right_order)}"
        phrase += ", as about turned axes" * (fixed and order == right_order[::-1])
        slips.append(Slip("order", 1 if order == right_order[::-1] else 1.25, phrase))
    slips += _signs(flips, "the angles are not negated" if recipe else "all three angles are negated")
    if transpose_wrong:
        missing, needless = "the final transpose is missing", "the product is transposed where it should not be"
        slips.append(Slip("transpose", 1, missing) if recipe else Slip("transpose", 1.2, needless))
    signs = tuple(-flip if recipe else flip for flip in flips)
    return Wording(recipe, active, order, signs, bool(recipe) != transpose_wrong, tuple(slips))


@lru_cache(maxsize=16)
def frame_wordings(sequence: str) -> dict[Key, list[Wording]]:
    """Return the products of a rotation that is compared as such: about turned or fixed axes, or its inverse."""
    fixed, other = sequence.islower(), " ".join(sequence.swapcase())
    which, not_which = ("turned", "fixed") if fixed else ("fixed", "turned")
    about = f"turned about the {which} axes {other}, not about the {not_which} ones"
    found = []
    for backwards, flips, inverted in product((False, True), product((1, -1), repeat=3), (False, True)):
        slips = [slip("intrinsic", about)] * backwards + _signs(flips, "all three angles are negated")
        slips += [slip("transposed", "it is the inverse, the transposed matrix")] * inverted
        order = (2, 1, 0) if fixed != backwards else (0, 1, 2)
        found.append(Wording(0, True, order, flips, inverted, tuple(slips)))
    return _by_key(each for each in found if len(each.slips) < 3)


def _signs(flips: tuple[int, ...], all_said: str) -> list[Slip]:
    """The slips of reversed signs."""
    if flips == (-1, -1, -1):
        return [Slip("sign", 1.05, all_said)]
    return [Slip("sign", 1, f"the sign of {ANGLES[n]} is reversed") for n in range(3) if flips[n] < 0]


def _by_key(found: Iterable[Wording]) -> dict[Key, list[Wording]]:
    """Wordings by their product, the simplest first."""
    same: dict[Key, list[Wording]] = {}
    for wording in sorted(found, key=COST):
        same.setdefault(wording.key, []).append(wording)
    return same


def _dots(order: Iterable[int]) -> str:
    return "·".join(ANGLES[n] for n in order)


@lru_cache(maxsize=8)
def all_factors(sequence: str) -> tuple[Factors, ...]:
    """Return the `Factors` to try on three angles about the axes of a sequence, the cheapest first.

    Each slip alone, and each pair of other axes, angles exchanged, a unit or an angle left out.
    """
    meanings = list(_meanings())
    common = [each for each in meanings if each.kind in ("unit", "left out")]
    groups = [list(_axes(sequence)), list(_sources()), common]
    chosen: list[tuple[Slip, ...]] = [(), *((each,) for each in chain(*groups[:2], meanings))]
    chosen += [pair for a, b in combinations(groups, 2) for pair in product(a, b)]
    start = Factors(sequence.upper(), point="")
    return tuple(sorted((misread(start, *slips) for slips in chosen), key=COST))


def _axes(sequence: str) -> Iterator[Slip]:
    for axes in euler.SEQUENCES:
        if axes != sequence.upper():
            said = axes.lower() if sequence.islower() else axes
            phrase = f"the axes are {' '.join(said)}, not {' '.join(sequence)}"
            yield Slip("axis", 1, phrase, setting(axes=axes))


def _sources() -> Iterator[Slip]:
    for source in permutations(range(3)):
        moved = [ANGLES[n] for n in range(3) if source[n] != n]
        if moved:
            phrase = f"the angles are taken in the order {', '.join(ANGLES[n] for n in source)}"
            phrase = f"{' and '.join(moved)} are exchanged" if len(moved) == 2 else phrase
            yield Slip("exchange", 1, phrase, setting(source=source))


def _meanings() -> Iterator[Slip]:
    for name, meaning in MEANINGS.items():
        for which in chain.from_iterable(combinations(range(3), count) for count in (1, 2, 3)):
            cost = meaning.get(("one", "two", "all")[len(which) - 1])
            if cost is not None:
                said = "all angles" if len(which) > 2 else " and ".join(ANGLES[n] for n in which)
                phrase = meaning["phrase"].format(said, verb="are" if len(which) > 1 else "is")
                change = setting(meaning=tuple(name if n in which else "degrees" for n in range(3)))
                yield Slip(meaning["kind"], cost, phrase, change)


def elementary(axis: str, angle: ArrayLike) -> np.ndarray:
    """Return the passive elementary matrix about ``"X"``, ``"Y"`` or ``"Z"``, shape (..., 3, 3); radians."""
    return from_angles(PASSIVE[axis], (angle,), False)


def matrices(factors: Sequence[Factors], keys: Sequence[Key], angles: np.ndarray) -> np.ndarray:
    """Return the products `keys` of `factors` for `angles` (3,), degrees, shape (factors, keys, 3, 3)."""
    radians = np.deg2rad([each.degrees(angles) for each in factors])
    elements = np.empty((len(factors), 3, 2, 3, 3))
    axes = np.array([list(each.axes) for each in factors])
    for axis in "XYZ":
        at = axes == axis
        elements[at] = np.stack([elementary(axis, radians[at]), elementary(axis, -radians[at])], axis=1)
    order = np.array([key[0] for key in keys])
    negative = np.array([[int(key[1][n] < 0) for n in key[0]] for key in keys])
    left, middle, right = (elements[:, order[:, n], negative[:, n]] for n in range(3))
    return left @ middle @ right


def common_matrices(names: Iterable[str], angles: np.ndarray) -> np.ndarray:
    """Return the matrices of ``"right"`` or of names that `COMMON` has, shape (n, 3, 3); angles in degrees."""
    keys = [COMMON.get(name, ((2, 1, 0), (1, 1, 1))) for name in names]
    return matrices([Factors("ZXZ")], keys, angles)[0]


def trade_name(wording: Wording, factors: Factors) -> str:
    """Return who writes such angles, such as "KUKA A B C", or an empty text.

    The frame that they write, or its inverse, turns the point. In a left-handed system all angles count the other
    way.
    """
    kinds = {each.kind for each in factors.slips} - {"origin", "centre"}
    if [each.kind for each in wording.slips] == ["active"] and not wording.recipe and not kinds:
        return "in a left-handed system"
    if "axis" not in kinds or kinds - {"axis"}:
        return ""
    turned = ((0, 1, 2), (-1, -1, -1)), ((2, 1, 0), (1, 1, 1))
    said = factors.axes if wording.key in turned else factors.axes.lower()
    fits = wording.key in (*turned, ((2, 1, 0), (-1, -1, -1)), ((0, 1, 2), (1, 1, 1)))
    names: list[Any] = [each["name"] for each in WRITERS.values() if each["as"] == said and each["unit"] == "deg"]
    return " or ".join(names) if fits else ""


def written(wording: Wording, factors: Factors) -> str:
    """Return the product of a misreading as text: E passive, R active elementary matrices, times the point."""
    letter, parts = "R" if wording.active else "E", []
    for n in wording.order:
        angle = MEANINGS[factors.meaning[n]]["written"].format(ANGLES[factors.source[n]])
        if wording.signs[n] < 0:
            angle = f"−({angle})" if "°" in angle else f"−{angle}"
        if factors.meaning[n] != "out":
            parts.append(f"{letter}_{factors.axes[n].lower()}({angle})")
    text = f"({'·'.join(parts) or '1'})ᵀ" if wording.transposed else "·".join(parts) or "1"
    return f"{text}·{factors.point}{factors.added}" if factors.point else text
