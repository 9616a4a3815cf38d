"""Which sign, branch or winding do someone's rotary angles have?

The machine's own inverse gives both branches for the CL data; a misreading changes its input, the tool axis (a lost
sign, exchanged components), and its output, the two angles (sign, zero position, branch, unit, exchanged).
"""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import combinations, permutations, product
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from mathpost import chain
from mathpost.detective.causes import slip
from mathpost.detective.digits import half_digit, written_decimals
from mathpost.detective.explanation import CHANCE, Explanation, Match, Misreading, Slip, grouped, told
from mathpost.detective.positions import rotary_travel
from mathpost.errors import InputError, as_array
from mathpost.machine import MM_PER_INCH
from mathpost.rotation import unit, wrap

if TYPE_CHECKING:
    from mathpost.kinematics import Kinematics

COMPONENTS = "ijk"
ZERO_POSITIONS = (0, 180, 90, -90)
UNITS = {  # factor of an angle in degrees: its text, its cause, and the sentence for it
    1.0: ("", "", ""),
    np.pi / 180: (" in radians", "radians", "{} is written in radians"),
    1 / MM_PER_INCH: ("/25.4", "inch", "{} is divided by 25.4, as if it were mm in a program in inches"),
    MM_PER_INCH: ("·25.4", "inch", "{} is multiplied by 25.4, as if it were inches"),
}
APART = 0.05  # degrees between the results of two misreadings that can be told apart
PROBES = np.array([(20, 30), (40, -60), (-30, 110), (60, 75), (-20, 35)])  # degrees
GENERIC = np.array([(31.3, 47.9), (-23.7, 104.1)])  # degrees
Branches = tuple[tuple[int, ...], ...]  # for each rotary axis, the branch of each row


@dataclass(frozen=True)
class _Change:
    """The changes to one angle of the inverse: sign, zero position in degrees, unit; and the slips."""

    name: str
    sign: int
    offset: int
    factor: float
    slips: tuple[Slip, ...]

    def text(self, branch: Sequence[int]) -> str:
        shift = f" {'+' if self.offset > 0 else '−'} {abs(self.offset)}°" if self.offset else ""
        return f"{'−' if self.sign < 0 else ''}{self.name}{_index(branch)}{shift}{UNITS[self.factor][0]}"


def explain_joints(
    kinematics: Kinematics, axis: ArrayLike, angles: ArrayLike, *, decimals: int | None = None
) -> Explanation:
    """Return the misreadings of a tool axis and a machine that give someone's rotary angles, the simplest first.

    Any pair of angles that gives the tool axis is right, on either branch. Angles that differ by whole turns are
    the same; the sentence names the turns.

    `axis`, shape (3,) or (n, 3), is the tool axis of the CL data, in the workpiece: n rows that one misreading must
    explain together. `angles`, (k,) or (n, k) for k rotary axes, are those in question, degrees in the order of the
    machine file, written to `decimals` digits after the point, by default as many as they show. The result is an
    `Explanation`; `InputError` if an argument is not finite numbers of that shape.

    Examples
    --------
    >>> from mathpost import load_machine
    >>> from mathpost.kinematics import Kinematics
    >>> kin = Kinematics(load_machine("dmu50v"))
    >>> print(explain_joints(kin, [0.145196, 0, 0.989403], [11.817, -184.185]))
    right: B₁, C₁ −1 turn
    >>> print(explain_joints(kin, [0.145196, 0, 0.989403], [11.817, -175.815]).misreadings[0])
    the sign of C is reversed: B₁, −C₁
    """
    count = len(kinematics.machine.rotary)
    directions, given = as_array(axis, 3, "axis"), as_array(angles, count, "angles")
    if directions.ndim > 2 or directions.shape[:-1] != given.shape[:-1]:
        raise InputError("angles", f"shape {(*directions.shape[:-1], count)}", f"shape {given.shape}")
    decimals = written_decimals(angles) if decimals is None else decimals
    case = JointCase(kinematics, np.atleast_2d(directions), np.atleast_2d(given), 1e-6, half_digit(axis))
    # Whole numbers are meant exactly if some misreading gives them exactly, as right angles do.
    exact = case.explain(given.shape) if decimals == 0 else None
    if exact and exact.explained:
        return exact
    return replace(case, half_digit=0.5 * 10.0**-decimals * (1 + 1e-6) + 1e-9).explain(given.shape)


@dataclass(frozen=True)
class _Match(Match):
    """A misreading that fits: the changes to the tool axis and to each angle, and the branch of each."""

    components: list[int]
    signs: np.ndarray
    exchanged: bool
    changes: tuple[_Change, ...]
    branches: Branches
    slips: tuple[Slip, ...] = ()

    @property
    def product(self) -> str:
        return ", ".join(map(_Change.text, self.changes, self.branches))

    def value(self, kinematics: Kinematics, axis: np.ndarray) -> np.ndarray:
        """Return its angles for tool axes of shape (n, 3): shape (n, 2), degrees."""
        joints = kinematics.inverse(np.zeros(3), axis[:, self.components] * self.signs, degrees=True)[..., 3:]
        angles = [
            (change.sign * joints[np.arange(len(axis)), branch, n] + change.offset) * change.factor
            for n, (change, branch) in enumerate(zip(self.changes, self.branches, strict=True))
        ]
        return np.stack(angles[::-1] if self.exchanged else angles, axis=1)


@dataclass(frozen=True)
class JointCase:
    """One question: CL tool axes, someone's angles, and the precision of both."""

    kinematics: Kinematics
    axis: np.ndarray
    given: np.ndarray
    half_digit: float
    axis_half_digit: float

    @property
    def names(self) -> tuple[str, ...]:
        return self.kinematics.machine.joint_names[3:]

    def explain(self, shape: tuple[int, ...]) -> Explanation:
        tried = 0
        matches: list[_Match] = []
        alone: list[list[tuple[Slip, ...]]] = [[] for _ in self.names]
        swapped = slip("names", f"{' and '.join(self.names)} stand in each other's place")
        for axis_slips, components, signs in _axis_misreadings():
            values, spread = self.both_branches(self.axis[:, components] * signs)
            if np.isnan(values).any():
                continue
            for exchanged in (False, True)[: len(self.names)]:
                given = self.given[:, ::-1] if exchanged else self.given
                slips = [*axis_slips, swapped] if exchanged else axis_slips
                fits = [self.fits(values, spread, given, joint) for joint in range(len(self.names))]
                tried += len(_changes(self.names[0])) ** len(self.names)
                for changes in product(*fits):
                    rows = [fits[joint][change] for joint, change in enumerate(changes)]
                    branches, extra = self.branches(*rows)
                    if branches:
                        all_slips = (*slips, *(each for change in changes for each in change.slips), *extra)
                        matches.append(_Match(components, signs, exchanged, changes, branches, all_slips))
                for joint in range(len(self.names)):
                    alone[joint] += [(*slips, *change.slips) for change in fits[joint]] if not exchanged else []
        if self.makes_the_axis().all() or any(match.cost == 0 for match in matches):
            return Explanation((self.right(shape),), self.half_digit, tried, self.jumps(), self.travel())
        return self.verdict(matches, alone, tried, shape)

    def makes_the_axis(self) -> np.ndarray:
        """Return whether the given angles point the tool along the CL axis, to the digits of both."""
        joints = np.concatenate([np.zeros((len(self.given), 3)), self.given], axis=1)
        made = self.kinematics.forward(joints, degrees=True)[1]
        allowed = 2 * np.deg2rad(self.half_digit) + 3 * self.axis_half_digit + 1e-9
        return np.linalg.norm(made - unit(self.axis), axis=1) <= allowed

    def both_branches(self, axis: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return all branches, (n, k, k) for k axes, degrees, and how far the input's last digits may move them."""
        near = axis[:, None, :] + np.array([(0, 0, 0), *product((-1, 1), repeat=3)]) * self.axis_half_digit
        near = np.concatenate([near, self.not_normalised(axis)[:, None, :]], axis=1)
        joints = self.kinematics.inverse(np.zeros(3), near, degrees=True)[..., : len(self.names), 3:]
        values = joints[:, 0]
        spread = np.abs(wrap(joints - values[:, None]))
        return values, np.nan_to_num(spread).max(axis=1)

    def not_normalised(self, axis: np.ndarray) -> np.ndarray:
        """Return unit vectors that keep the component of `axis` along the workpiece-side axis, not normalised."""
        (workpiece_side, *_), *_ = chain.between(self.kinematics.machine)
        u = unit(np.array(workpiece_side.axis, dtype=float))
        across = axis - (axis @ u)[:, None] * u
        length = np.linalg.norm(across, axis=1, keepdims=True)
        along = np.clip(axis @ u, -1, 1)[:, None]
        printed = along * u + np.sqrt(1 - along**2) * across / np.where(length > 0, length, 1)
        is_rounded = np.abs(np.linalg.norm(axis, axis=1, keepdims=True) - 1) < 4 * self.axis_half_digit
        return np.where(is_rounded & (length > 0), printed, axis)

    def fits(
        self, values: np.ndarray, spread: np.ndarray, given: np.ndarray, joint: int
    ) -> dict[_Change, np.ndarray]:
        """Return the changes of one angle that give the written one, with the rows and branches that do, (n, 2)."""
        found = {}
        for change in _changes(self.names[joint]):
            off = wrap(given[:, None, joint] / change.factor - change.sign * values[..., joint] - change.offset)
            fit = np.abs(off) <= spread[..., joint] + self.half_digit / change.factor
            if fit.any(axis=1).all():
                found[change] = fit
        return found

    def branches(
        self, first: np.ndarray, second: np.ndarray | None = None
    ) -> tuple[Branches | None, tuple[Slip, ...]]:
        """Return the branch of each angle in each row, and a slip if they differ; None if they are inconsistent."""
        if second is None:
            return ((0,) * len(first),), ()
        for other, apart in ((second, 0), (second[:, ::-1], 1)):
            if (both := first & other).any(axis=1).all():
                branch = both.argmax(axis=1)
                slip = Slip("branch", 1.1, f"{self.names[0]} and {self.names[1]} are of different branches")
                return (tuple(branch.tolist()), tuple((branch ^ apart).tolist())), (slip,) * apart
        return None, ()

    def right(self, shape: tuple[int, ...]) -> Misreading:
        """Return the right result: the branch and the turns of each row."""
        values, _ = self.both_branches(self.axis)
        branch = np.argmin(np.abs(wrap(self.given[:, None] - values)).max(axis=2), axis=1)
        chosen = values[np.arange(len(values)), branch]
        parts = []
        for n, name in enumerate(self.names):
            turns = set(np.round((self.given - chosen)[:, n] / 360).astype(int).tolist())
            text = name + _index(branch)
            if len(turns) == 1 and turns != {0}:
                count = turns.pop()
                text += f" {'+' if count > 0 else '−'}{abs(count)} turn{'s' * (abs(count) > 1)}"
            parts.append(text)
        return Misreading("right", ", ".join(parts), (), chosen.reshape(shape), (), 0.0)

    def jumps(self) -> str:
        """Say where right angles jump because they are between −180° and 180°, as atan2 gives them."""
        said = []
        for n, name in enumerate(self.names):
            step = np.diff(self.given[:, n])
            for row in np.flatnonzero(np.abs(step) > 180)[:1]:
                way, more = wrap(step[row]), -360 * np.sign(step[row])
                said.append(
                    f"{name} jumps by {step[row]:+.4g}° from row {row + 1} to row {row + 2}: the way is "
                    f"{way:+.4g}°, and atan2 gives angles from -180 to 180. Both name one position: "
                    f"add {more:+.0f}° from there on, if {name} may turn so far."
                )
        return " ".join(said)

    def verdict(
        self, matches: list[_Match], alone: list[list[tuple[Slip, ...]]], tried: int, shape: tuple[int, ...]
    ) -> Explanation:
        """Rank the matches and group those that are the same for every tool axis."""
        # The expected number of accidental matches among misreadings that cost no more.
        share = (self.half_digit / 180) ** (len(self.names) * len(self.axis))
        believed = [match for match in matches if 8.0 ** np.ceil(match.cost) * share < CHANCE]
        groups, note = grouped(believed, self.angles_of)[:8], ""
        values = (group[0].value(self.kinematics, self.axis).reshape(shape) for group in groups)
        misreadings = tuple(map(told, groups, values))
        if len(misreadings) > 1:
            note = self.tell_apart(groups)
        elif not misreadings:
            note = " ".join(self.one_by_one(name, alone[n]) for n, name in enumerate(self.names))
            note += f" Right is {self.both_ways()}.{self.zero()}"
        return Explanation(misreadings, self.half_digit, tried, note, self.travel())

    def travel(self) -> tuple[str, ...]:
        """Return a sentence for each of the angles in question that is outside travel."""
        return rotary_travel(self.kinematics.machine, self.given)

    def tell_apart(self, groups: list[list[_Match]]) -> str:
        """Propose the tool axis for which the misreadings differ most clearly, with the result of each."""
        count, best, most = len(groups), None, 0
        for probe in self.made(PROBES):
            values = [self.one_row(group[0]).value(self.kinematics, probe[None])[0] for group in groups]
            apart = sum(np.abs(wrap(a - b)).max() > APART for a, b in combinations(values, 2))
            if apart > most and np.isfinite(values).all():
                best, most = (probe, values), apart
        if best is None:
            return f"{count} misreadings give the same angles here: rows with another tool axis tell them apart."
        asked, values = " ".join(f"{x:g}" for x in best[0].round(6)), best[1]
        each = "; ".join(
            f"{group[0].sentence}: {' '.join(f'{name} {x:z.3f}' for name, x in zip(self.names, row, strict=True))}"
            for group, row in zip(groups, values, strict=True)
        )
        return (
            f"{count} misreadings give the same angles here. To tell them apart, try the tool axis {asked}: {each}."
        )

    def made(self, angles: np.ndarray) -> np.ndarray:
        """Return the tool axes at rotary angles, rows in degrees."""
        rotary = angles[:, : len(self.names)]
        joints = np.concatenate([np.zeros((len(rotary), 3)), rotary], axis=1)
        return self.kinematics.forward(joints, degrees=True)[1]

    @staticmethod
    def one_row(match: _Match, count: int = 1) -> _Match:
        """Return the match with the branches of its first row, for `count` rows."""
        return replace(match, branches=tuple(branch[:1] * count for branch in match.branches))

    def zero(self) -> str:
        """Say by what constant the angles are off on a branch, if an axis or a second row confirms it."""
        values, spread = self.both_branches(self.axis)
        off, slack = wrap(self.given[:, None] - values), spread + self.half_digit
        constant = (np.abs(wrap(off - off[:1])) <= 2 * slack).all(axis=(0, 2))
        right = (np.abs(off) <= slack).all(axis=0)
        for branch in np.flatnonzero(constant & (right.any(axis=1) | (len(off) > 1))):
            wrong = [n for n in range(len(self.names)) if not right[branch, n]]
            said = ", ".join(f"{self.names[n]} by {off[0, branch, n]:+.4f}°" for n in wrong)
            return f" Off by a constant, as a zero point is: {said}."
        return ""

    def both_ways(self) -> str:
        """Return the right angles of the first row, on either branch, as text."""
        values, _ = self.both_branches(self.axis[:1])
        said = (" ".join(f"{name} {x:z.4f}" for name, x in zip(self.names, row, strict=True)) for row in values[0])
        return ", or ".join(dict.fromkeys(said)) if np.isfinite(values).all() else "none: it is out of reach"

    def angles_of(self, match: _Match) -> Hashable:
        """Return a key that differs between misreadings, whatever the tool axis."""
        one_row = self.one_row(match, len(GENERIC))
        generic = np.round(wrap(one_row.value(self.kinematics, self.made(GENERIC))), 6) % 360
        return generic.tobytes() if np.isfinite(generic).all() else match.slips

    def one_by_one(self, name: str, found: Iterable[tuple[Slip, ...]]) -> str:
        """Explain one angle alone, by one slip at most, as one number fits many misreadings by accident."""
        simple = sorted((slips for slips in found if len(slips) <= 1), key=len)
        if not simple:
            return f"{name}: no misreading gives it."
        return f"{name} alone: {simple[0][0].phrase if simple[0] else 'right'}."


def _index(branch: Sequence[int]) -> str:
    """The branch that all rows are on, as a subscript to the name of a joint."""
    return "₁₂"[branch[0]] if len(set(branch)) == 1 else ""


def _axis_misreadings() -> Iterator[tuple[list[Slip], list[int], np.ndarray]]:
    """Misreadings of the tool axis: slips, the order of the components, and their signs."""
    for components, signs in product(permutations(range(3)), product((1, -1), repeat=3)):
        moved = [COMPONENTS[n] for n in range(3) if components[n] != n]
        lost = [f"the sign of {COMPONENTS[n]} is lost" for n in range(3) if signs[n] < 0]
        if len(lost) == 3:
            lost = ["the tool axis points away from the spindle"]
        slips = [Slip("axis sign", 1, phrase) for phrase in lost]
        if moved:
            slips.insert(
                0,
                Slip(
                    "exchange",
                    len(moved) - 1,
                    f"{', '.join(moved)} of the tool axis are exchanged{' in a cycle' * (len(moved) > 2)}",
                ),
            )
        yield slips, list(components), np.array(signs)


@lru_cache(maxsize=32)
def _changes(name: str) -> list[_Change]:
    """The changes that may have been made to the angle of the joint `name`."""
    changes = []
    for sign, offset, factor in product((1, -1), ZERO_POSITIONS, UNITS):
        slips = []
        if sign < 0:
            slips.append(slip("reversed", f"the sign of {name} is reversed"))
        if offset:
            slips.append(slip("zero", f"{name} is off by {offset:+d} degrees", 0.1 * (offset != 180)))
        if factor != 1:
            _, cause, phrase = UNITS[factor]
            slips.append(slip(cause, phrase.format(name)))
        changes.append(_Change(name, sign, offset, factor, tuple(slips)))
    return changes
