"""Every way to misread a rotation by three Euler angles, enumerated, evaluated and put into words.

A misreading is a set of slips; the right way has none. It has two parts. The *wording* is the form of the product:
which of the two recipes of source 000, in what order, with active or passive elements, with which signs,
transposed or not, the point as a column or as a row. The 768 wordings give 48 different products. The *factors* are
the angles and axes in the product, and the changes to the point and to the answer: a slip changes the right ones.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import combinations, permutations, product
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from mathpost.detective.explanation import COST, Misread, Slip
from mathpost.euler import from_quaternion, to_quaternion
from mathpost.formula import from_angles
from mathpost.rotation import PASSIVE

ANGLES = "αβγ"
NOWHERE = (0.0, 0.0, 0.0)
OUTSIDE = {
    "before",
    "after",
    "point",
    "added",
    "quaternion",
    "order",
    "signs",
}  # fields that do not concern the product
PI_WRITTEN = (3.14, 3.142, 3.1416, 3.14159, 22 / 7)
DEGREES_CALLED = "{} {verb} converted with DEGREES, not with RADIANS"
EXCHANGED = "90° − {} is used, or sine and cosine are exchanged"
FOR_MINUTES = "the decimals of {} are taken for minutes, 35.30 for 35°30′"
AS_DECIMALS = "the minutes of {} are written as decimals, 35.30 for 35.5°"
# Axes of the first, second and third angle for which a trade has a name, and the order of the frame's factors.
TRADE = {"ZYX": ("KUKA A B C", (0, 1, 2)), "XYZ": ("Fanuc W P R or Heidenhain SPA SPB SPC", (2, 1, 0))}
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


def _fraction_times(degrees: float, factor: float) -> float:
    """The degrees with their fraction times `factor`; a float such as 35.29999… counts as 35.3."""
    whole = np.trunc(np.round(degrees, 9))
    return whole + (degrees - whole) * factor


@dataclass(frozen=True)
class Meaning:
    """A meaning of the number of an angle, and the slip of taking it so."""

    degrees: Callable[[float, float], float]  # from the number and some value of π
    written: str  # the angle in a product
    kind: str = ""
    for_all: float | None = None  # cost of the slip for all angles; None if it is not tried
    for_one: float = 0.0  # and for one
    phrase: str = ""


MEANINGS = {
    "degrees": Meaning(lambda a, pi: a, "{}"),
    "radians": Meaning(
        lambda a, pi: a * 180 / pi, "{} rad", "unit", 1, 1.25, "the degrees of {} are taken for radians"
    ),
    "twice": Meaning(
        lambda a, pi: a * pi / 180, "{}·π/180", "unit", 1.25, 1.5, "{} {verb} converted to radians twice"
    ),
    "reversed": Meaning(lambda a, pi: a * (180 / pi) ** 2, "{}·180/π rad", "unit", 1.5, 1.75, DEGREES_CALLED),
    "gon": Meaning(lambda a, pi: 0.9 * a, "{} gon", "unit", 1.5, 1.75, "the degrees of {} are taken for gon"),
    "half": Meaning(
        lambda a, pi: a / 2, "{}/2", "half angle", 1.25, 1.25, "half of {} is used, as in a quaternion"
    ),
    "double": Meaning(lambda a, pi: 2 * a, "2{}", "double angle", 1.25, 1.25, "twice {} is used"),
    "complement": Meaning(lambda a, pi: 90 - a, "90° − {}", "complement", 1.25, 1.25, EXCHANGED),
    "quarter more": Meaning(lambda a, pi: a + 90, "{} + 90°", "offset", None, 1.25, "90° are added to {}"),
    "quarter less": Meaning(lambda a, pi: a - 90, "{} − 90°", "offset", None, 1.25, "90° are taken from {}"),
    "half turn more": Meaning(lambda a, pi: a + 180, "{} + 180°", "offset", None, 1.25, "180° are added to {}"),
    "minutes": Meaning(lambda a, pi: _fraction_times(a, 100 / 60), "{} in ° ′", "minutes", 1.25, 1.25, FOR_MINUTES),
    "no minutes": Meaning(
        lambda a, pi: _fraction_times(a, 60 / 100), "{} from ° ′", "minutes", 1.25, 1.25, AS_DECIMALS
    ),
}


QUATERNION = tuple(
    Slip("quaternion", 1.25, f"the quaternion is stored as {stored} and read as {read}", {"quaternion": shift})
    for stored, read, shift in (("x y z w", "w x y z", -1), ("w x y z", "x y z w", 1))
)


@dataclass(frozen=True)
class Wording(Misread):
    """One form of the product; `order` and `signs` are as stated, before any transpose."""

    recipe: int
    active: bool
    order: tuple[int, ...]
    signs: tuple[int, ...]
    transposed: bool
    row: bool
    slips: tuple[Slip, ...] = ()

    @property
    def cost(self) -> float:
        return 0.01 * self.recipe + super().cost

    @property
    def key(self) -> Key:
        """The product that it gives: rotations from left to right and the signs of their passive elements."""
        order, signs = self.order, tuple(-s if self.active else s for s in self.signs)
        if self.transposed != self.row:
            order, signs = order[::-1], tuple(-s for s in signs)
        return order, signs


@dataclass(frozen=True)
class Factors(Misread):
    """The angles and axes of the first, second and third rotation, and the changes to point and answer."""

    axes: str
    source: tuple[int, ...] = (0, 1, 2)  # index of the angle used for each
    kept: tuple[bool, ...] = (True, True, True)
    meaning: tuple[str, ...] = ("degrees",) * 3
    angle_decimals: int | None = None  # None if not rounded
    pi: float = np.pi
    entry_decimals: int | None = None
    before: tuple[float, ...] = NOWHERE  # added to the point before the rotation, and after it
    after: tuple[float, ...] = NOWHERE
    point: str = "p"  # the text for each
    added: str = ""
    quaternion: int = 0  # places by which its entries are shifted
    order: tuple[int, ...] = (0, 1, 2)  # where the answer's entries come from, and their signs
    signs: tuple[int, ...] = (1, 1, 1)
    slips: tuple[Slip, ...] = ()

    def misread(self, *slips: Slip) -> Factors:
        """Return them with more slips."""
        changes = {name: value for slip in slips for name, value in slip.changes.items()}
        return replace(self, slips=(*self.slips, *slips), **changes)

    def rounded(self, angles: np.ndarray) -> np.ndarray:
        """The given angles, degrees, as they are used."""
        return angles if self.angle_decimals is None else np.round(angles, self.angle_decimals)

    def radians(self, angles: np.ndarray) -> np.ndarray:
        """The angle of each rotation, shape (3,), from the given degrees."""
        angles, rows = self.rounded(angles), zip(self.source, self.meaning, self.kept, strict=True)
        meant = [MEANINGS[meaning].degrees(angles[n], self.pi) * kept for n, meaning, kept in rows]
        return np.array(meant) * self.pi / 180

    def matters(self, angles: np.ndarray) -> bool:
        """Whether rounding and meaning change any angle: rounding 135 to two decimals is no slip."""
        if self.angle_decimals is not None and np.array_equal(self.rounded(angles), angles):
            return False
        meant = [
            MEANINGS[meaning].degrees(angle, np.pi) for meaning, angle in zip(self.meaning, angles, strict=True)
        ]
        return set(self.meaning) == {"degrees"} or not np.array_equal(meant, angles)


def about_origin(origin: np.ndarray, sequence: str) -> tuple[Factors, ...]:
    """The factors to start from if the point is to be taken relative to `origin`; the first are right."""
    o, minus = tuple(origin.tolist()), tuple((-origin).tolist())
    right = Factors(sequence, before=minus, point="(p − o)")
    centre = "the origin is added again after the rotation: it is taken for the centre of rotation"
    slips = (
        Slip("origin", 1, "the origin is not subtracted", {"before": NOWHERE, "point": "p"}),
        Slip("origin", 1, "the origin is added, not subtracted", {"before": o, "point": "(p + o)"}),
        Slip("centre", 1, centre, {"after": o, "added": " + o"}),
        Slip("origin", 1.1, "the origin is subtracted after the rotation", _later(minus, " − o")),
        Slip("origin", 1.25, "the origin is added after the rotation", _later(o, " + o")),
    )
    return (right, *(right.misread(slip) for slip in slips))


def onto_origin(origin: np.ndarray, sequence: str) -> tuple[Factors, ...]:
    """The same where the point is turned, and the origin of the turned frame added."""
    o, minus = tuple(origin.tolist()), tuple((-origin).tolist())
    right = Factors(sequence, after=o, added=" + o")
    centre = "the origin is subtracted first: it is taken for the centre of rotation"
    slips = (
        Slip("origin", 1, "the origin is not added", {"after": NOWHERE, "added": ""}),
        Slip("origin", 1, "the origin is subtracted, not added", _later(minus, " − o")),
        Slip("centre", 1, centre, {"before": minus, "point": "(p − o)"}),
        Slip("origin", 1.1, "the origin is added before the rotation", _before(o, "(p + o)")),
        Slip("origin", 1.25, "the origin is subtracted before the rotation", _before(minus, "(p − o)")),
    )
    return (right, *(right.misread(slip) for slip in slips))


def _before(before: tuple[float, ...], point: str) -> dict[str, Any]:
    return {"before": before, "after": NOWHERE, "point": point, "added": ""}


def _later(after: tuple[float, ...], added: str) -> dict[str, Any]:
    return {"before": NOWHERE, "after": after, "point": "p", "added": added}


@lru_cache(maxsize=4)
def wordings(fixed: bool = False, turned: bool = False) -> dict[Key, list[Wording]]:
    """Return the 48 products: a dict from `Wording.key` to its wordings, the simplest first.

    About `fixed` axes the right order of the factors is the opposite one; so it is if the point itself is `turned`
    (active), by active elementary matrices.
    """
    found: dict[Key, list[Wording]] = {}
    everything = product(
        (0, 1), (False, True), permutations(range(3)), product((1, -1), repeat=3), (False, True), (False, True)
    )
    for recipe, active, order, flips, transpose_wrong, row in everything:
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
        flipped = [ANGLES[n] for n in range(3) if flips[n] < 0]
        if len(flipped) == 3:
            phrase = "the angles are not negated" if recipe else "all three angles are negated"
            slips.append(Slip("sign", 1.05, phrase))
        else:
            slips += [Slip("sign", 1, f"the sign of {name} is reversed") for name in flipped]
        if transpose_wrong and recipe:
            slips.append(Slip("transpose", 1, "the final transpose is missing"))
        elif transpose_wrong:
            slips.append(Slip("transpose", 1.2, "the product is transposed where it should not be"))
        if row:
            slips.append(Slip("row", 1.05, "the point is multiplied as a row from the left"))
        signs = tuple(-flip if recipe else flip for flip in flips)
        wording = Wording(recipe, active, order, signs, bool(recipe) != transpose_wrong, row, tuple(slips))
        found.setdefault(wording.key, []).append(wording)
    return {key: sorted(same, key=COST) for key, same in found.items()}


def _dots(order: Iterable[int]) -> str:
    return "·".join(ANGLES[n] for n in order)


@lru_cache(maxsize=8)
def all_factors(sequence: str, depth: int) -> tuple[Factors, ...]:
    """Return the `Factors` to try on the Euler angles `sequence`, the cheapest first.

    At `depth` 2: each slip alone and each pair, but quaternions and meanings other than units only alone. At depth
    3: the common slips (other axes, angles exchanged or left out, degrees taken for radians, angles rounded) in all
    combinations.
    """
    meanings = list(_meanings())
    units = [slip for slip in meanings if slip.kind == "unit"]
    groups = [list(_axes(sequence)), list(_sources()), list(_left_out()), units, list(_roundings())]
    if depth == 2:
        others = [slip for slip in (*meanings, *QUATERNION) if slip.kind != "unit"]
        chosen = [(), *((slip,) for group in (*groups, others) for slip in group)]
        chosen += [pair for a, b in combinations(groups, 2) for pair in product(a, b)]
    else:
        common = [[None, *(slip for slip in group if slip.cost <= 1)] for group in groups]
        chosen = [tuple(filter(None, row)) for row in product(*common)]
        chosen = [slips for slips in chosen if len(slips) > 2]
    return tuple(sorted((Factors(sequence).misread(*slips) for slips in chosen), key=COST))


def _axes(sequence: str) -> Iterator[Slip]:
    said = " ".join(sequence)
    for letters in product("XYZ", repeat=3):
        axes = "".join(letters)
        differing = sum(a != b for a, b in zip(axes, sequence, strict=True))
        proper = axes[0] != axes[1] != axes[2]
        if axes != sequence and (proper or differing == 1):
            phrase = f"the axes are {' '.join(axes)}, not {said}"
            yield Slip("axis", 1 if proper else 1.25, phrase, {"axes": axes})


def _sources() -> Iterator[Slip]:
    for source in product(range(3), repeat=3):
        moved = [n for n in range(3) if source[n] != n]
        if len(moved) == 1:
            phrase = f"{ANGLES[source[moved[0]]]} stands where {ANGLES[moved[0]]} belongs"
            yield Slip("reference", 1.25, phrase, {"source": source})
        elif moved and sorted(source) == [0, 1, 2]:
            phrase = f"the angles are taken in the order {', '.join(ANGLES[n] for n in source)}"
            if len(moved) == 2:
                phrase = f"{' and '.join(ANGLES[n] for n in moved)} are exchanged"
            yield Slip("exchange", 1, phrase, {"source": source})


def _left_out() -> Iterator[Slip]:
    for kept in product((True, False), repeat=3):
        gone = [ANGLES[n] for n in range(3) if not kept[n]]
        if len(gone) in (1, 2):
            verb = "is" if len(gone) == 1 else "are"
            yield Slip("left out", len(gone), f"{' and '.join(gone)} {verb} left out", {"kept": kept})


def _meanings() -> Iterator[Slip]:
    for meaning, each in list(MEANINGS.items())[1:]:
        for n, name in enumerate(ANGLES):
            changed = tuple(meaning if n == other else "degrees" for other in range(3))
            yield Slip(each.kind, each.for_one, each.phrase.format(name, verb="is"), {"meaning": changed})
        if each.for_all:
            yield Slip(
                each.kind, each.for_all, each.phrase.format("all angles", verb="are"), {"meaning": (meaning,) * 3}
            )


def _roundings() -> Iterator[Slip]:
    for decimals in range(6):
        phrase = f"the angles are rounded to {decimals} decimal{'s' * (decimals != 1)}"
        yield Slip("rounded", 0.9, phrase, {"angle_decimals": decimals})
    for pi in PI_WRITTEN:
        yield Slip("rounded", 1.1, f"π is taken as {'22/7' if pi == 22 / 7 else pi}", {"pi": pi})
    for decimals in range(1, 7):
        phrase = f"the elementary matrices are rounded to {decimals} decimal{'s' * (decimals != 1)}"
        yield Slip("rounded", 1.1, phrase, {"entry_decimals": decimals})


def elementary(axis: str, angle: ArrayLike) -> np.ndarray:
    """Return the passive elementary matrix about ``"X"``, ``"Y"`` or ``"Z"``, shape (..., 3, 3); radians."""
    return from_angles(PASSIVE[axis], (angle,), False)


def matrices(factors: Sequence[Factors], keys: Sequence[Key], angles: np.ndarray) -> np.ndarray:
    """Return the products `keys` of `factors` for `angles` (3,), degrees, shape (factors, keys, 3, 3)."""
    radians = np.array([each.radians(angles) for each in factors])
    elements = np.empty((len(factors), 3, 2, 3, 3))
    axes = np.array([list(each.axes) for each in factors])
    for axis in "XYZ":
        at = axes == axis
        elements[at] = np.stack([elementary(axis, radians[at]), elementary(axis, -radians[at])], axis=1)
    for index, each in enumerate(factors):
        if each.entry_decimals is not None:
            elements[index] = np.round(elements[index], each.entry_decimals)
    order = np.array([key[0] for key in keys])
    negative = np.array([[int(key[1][n] < 0) for n in key[0]] for key in keys])
    left, middle, right = (elements[:, order[:, n], negative[:, n]] for n in range(3))
    made = left @ middle @ right
    for index, each in enumerate(factors):
        if each.quaternion:
            made[index] = from_quaternion(np.roll(to_quaternion(made[index]), each.quaternion, axis=-1))
    return made


def common_matrices(names: Iterable[str], angles: np.ndarray) -> np.ndarray:
    """Return the matrices of ``"right"`` or of names that `COMMON` has, shape (n, 3, 3); angles in degrees."""
    right = ((2, 1, 0), (1, 1, 1))
    keys = [COMMON.get(name, right) for name in names]
    return matrices([Factors("ZXZ")], keys, angles)[0]


def trade_name(wording: Wording, factors: Factors) -> str:
    """Return the name that a trade has for these angles, such as "KUKA A B C", or an empty text.

    Both trades mean the frame Rz·Ry·Rx: KUKA gives the angle about Z first, Fanuc the one about X. The frame, or
    its inverse, turns the point. In a left-handed system all angles count the other way.
    """
    left_handed = [slip.kind for slip in wording.slips] == ["active"] and not wording.recipe
    if left_handed and all(slip.changes.keys() <= OUTSIDE for slip in factors.slips):
        return "in a left-handed system"
    name, order = TRADE.get(factors.axes, ("", ()))
    frame, inverse = (order, (-1, -1, -1)), (order[::-1], (1, 1, 1))
    as_given = factors.source == (0, 1, 2) and all(factors.kept)
    return name if as_given and wording.key in (frame, inverse) else ""


def written(wording: Wording, factors: Factors) -> str:
    """Return the product of a misreading as text: E passive, R active elementary matrices, times the point."""
    letter, parts = "R" if wording.active else "E", []
    for n in wording.order:
        angle = MEANINGS[factors.meaning[n]].written.format(ANGLES[factors.source[n]])
        if wording.signs[n] < 0:
            angle = f"−({angle})" if "°" in angle else f"−{angle}"
        if factors.kept[n]:
            parts.append(f"{letter}_{factors.axes[n].lower()}({angle})")
    text = "·".join(parts) or "1"
    if wording.transposed:
        text = f"({text})ᵀ"
    if not factors.point:
        return text
    return (f"{factors.point}ᵀ·{text}" if wording.row else f"{text}·{factors.point}") + factors.added
