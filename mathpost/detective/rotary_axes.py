"""Which sign, zero, unit or branch do someone's rotary angles have?

Angles are right if they point the tool along its axis in the CL data, on either branch and after any number of
turns. If they do not, each of `causes.causes_of_words`, and each pair, is tried in the same way.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import combinations, product
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from mathpost import chain
from mathpost.detective.causes import Setup, causes_of_words
from mathpost.detective.digits import half_digit, written_decimals
from mathpost.detective.explanation import (
    CHANCE,
    Explanation,
    Match,
    Misreading,
    Slip,
    Trial,
    explanation,
    misread,
)
from mathpost.detective.positions import rotary_travel
from mathpost.errors import InputError, as_array
from mathpost.rotation import unit, wrap

if TYPE_CHECKING:
    from mathpost.kinematics import Kinematics

PROBES = np.array([(20, 30), (40, -60), (-30, 110), (60, 75), (-20, 35)])  # degrees
GENERIC = np.array([(31.3, 47.9), (-23.7, 104.1)])  # degrees
EXACT = 1e-14  # from 1, of the length of a direction that its digits state exactly


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
    the sign of C is reversed: B, −C
    """
    count = len(kinematics.machine.rotary)
    directions, given = as_array(axis, 3, "axis"), as_array(angles, count, "angles")
    if directions.ndim > 2 or directions.shape[:-1] != given.shape[:-1]:
        raise InputError("angles", f"shape {(*directions.shape[:-1], count)}", f"shape {given.shape}")
    decimals = written_decimals(angles) if decimals is None else decimals
    exactly = np.abs(np.linalg.norm(directions, axis=-1) - 1).max() < EXACT
    half = 0.0 if exactly else half_digit(axis)  # 0 0.6 0.8 is not rounded
    case = JointCase(kinematics, np.atleast_2d(directions), np.atleast_2d(given), 1e-6, half)
    # Whole numbers are meant exactly if some misreading gives them exactly, as right angles do.
    exact = case.explain(given.shape) if decimals == 0 else None
    if exact and exact.explained:
        return exact
    return replace(case, half_digit=0.5 * 10.0**-decimals * (1 + 1e-6) + 1e-9).explain(given.shape)


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

    def makes_the_axis(self) -> np.ndarray:
        """Return whether the given angles point the tool along the CL axis, to the digits of both."""
        return self.off(Setup.right(self.kinematics.machine)) <= self.allowed(1.0)

    def off(self, setup: Setup) -> np.ndarray:
        """Return how far the axes that a setup makes of the angles are from those of the CL data, (n,)."""
        return np.linalg.norm(setup.axis(self.given) - unit(self.axis), axis=1)

    def allowed(self, factor: float) -> float:
        """How far the digits of the angles, multiplied by a factor, and of the tool axis allow it to be off."""
        return 2 * np.deg2rad(self.half_digit * factor) + 3 * self.axis_half_digit + 1e-9

    def reach(self, setup: Setup) -> np.ndarray:
        """Return how far the digits of each angle alone, and of the tool axis, move it with a setup, (n,)."""
        steps = np.eye(len(self.names)) * self.half_digit
        moved = [np.linalg.norm(setup.axis(self.given + s) - setup.axis(self.given), axis=1) for s in steps]
        return np.sum(moved, axis=0) + 2 * self.axis_half_digit + 1e-9

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
        (workpiece_side, *_), *_ = chain.rotary_in_chain_order(self.kinematics.machine)
        u = unit(np.array(workpiece_side.axis, dtype=float))
        across = axis - (axis @ u)[:, None] * u
        length = np.linalg.norm(across, axis=1, keepdims=True)
        along = np.clip(axis @ u, -1, 1)[:, None]
        printed = along * u + np.sqrt(1 - along**2) * across / np.where(length > 0, length, 1)
        is_rounded = np.abs(np.linalg.norm(axis, axis=1, keepdims=True) - 1) < 4 * self.axis_half_digit
        return np.where(is_rounded & (length > 0), printed, axis)

    def explain(self, shape: tuple[int, ...]) -> Explanation:
        machine, travel = self.kinematics.machine, rotary_travel(self.kinematics.machine, self.given)
        if self.makes_the_axis().all():
            return Explanation((self.right(shape),), self.half_digit, 1, self.jumps(), travel)
        causes = causes_of_words(machine)
        ways = [several for count in (1, 2) for several in combinations(causes, count)]
        matches = []
        for several in ways:
            setup = misread(Setup.right(machine), *several)
            off, allowed = self.off(setup), self.allowed(max(map(abs, setup.factor)))
            # A direction hits a disc on the sphere by accident.
            chance = len(ways) * min(1.0, allowed**2 / 4) ** len(self.axis)
            if off.max() <= allowed and chance < CHANCE and (off <= self.reach(setup)).all():
                matches.append(self.match(setup))
        return explanation(
            [*matches, *self.mixed()], self.trial(), self.half_digit, len(ways), shape=shape,
            otherwise=self.what_is_known, travel=travel,
        )  # fmt: skip

    def match(self, setup: Setup) -> Match:
        def words(axis: np.ndarray) -> np.ndarray:
            asked = np.zeros_like(axis)
            asked[:, list(setup.order)] = axis * setup.signs
            angles = self.kinematics.inverse(np.zeros(3), asked, degrees=True)[:, 0, 3:]
            return wrap((angles - setup.zero) / setup.factor)[:, np.argsort(setup.source)]

        return Match(setup.slips, ", ".join(self.words(setup)), words)

    def words(self, setup: Setup) -> Iterator[str]:
        """The words of a setup by the right ones, such as "−C + 180°"."""
        for n in np.argsort(setup.source):
            size = abs(setup.factor[n])
            unit_of = {1.0: "", float(np.degrees(1)): " in radians"}.get(size, f"{'/' if size > 1 else '·'}25.4")
            shift = -setup.zero[n] * np.sign(setup.factor[n])
            added = f" {'+' if shift > 0 else '−'} {abs(shift):g}°" if shift else ""
            yield f"{'−' * (setup.factor[n] < 0)}{self.names[n]}{added}{unit_of}"

    def mixed(self) -> Iterator[Match]:
        """The angles of different branches."""
        values, spread = self.both_branches(self.axis)
        near = np.abs(wrap(self.given[:, None] - values)) <= spread + self.half_digit
        if len(self.names) > 1 and (near[:, 0, 0] & near[:, 1, 1] | near[:, 1, 0] & near[:, 0, 1]).all():
            kind = Slip("branch", 1.1, f"{self.names[0]} and {self.names[1]} are of different branches")

            def words(axis: np.ndarray) -> np.ndarray:
                both = self.kinematics.inverse(np.zeros(3), axis, degrees=True)[..., 3:]
                return np.stack([both[:, 0, 0], both[:, 1, 1]], axis=1)

            yield Match((kind,), f"{self.names[0]}₁, {self.names[1]}₂", words)

    def right(self, shape: tuple[int, ...]) -> Misreading:
        """Return the right result: the branch and the turns of each row."""
        values, _ = self.both_branches(self.axis)
        branch = np.argmin(np.abs(wrap(self.given[:, None] - values)).max(axis=2), axis=1)
        chosen, parts = values[np.arange(len(values)), branch], []
        for n, name in enumerate(self.names):
            turns = set(np.round((self.given - chosen)[:, n] / 360).astype(int).tolist())
            text = name + ("₁₂"[branch[0]] if len(set(branch.tolist())) == 1 else "")
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

    def trial(self) -> Trial:
        """The question, and other tool axes."""

        def made(angles: np.ndarray) -> np.ndarray:
            return Setup.right(self.kinematics.machine).axis(angles[:, : len(self.names)].astype(float))

        def written(rows: np.ndarray) -> str:
            return " ".join(f"{name} {x:z.3f}" for name, x in zip(self.names, rows[0], strict=True))

        probes = [
            (f"the tool axis {' '.join(f'{x:g}' for x in axis.round(6))}", axis[None]) for axis in made(PROBES)
        ]
        return Trial(self.axis, [made(GENERIC)], probes, written, "angles")

    def what_is_known(self) -> str:
        """Say what is known of each angle alone, what is right, and by what constant the angles are off."""
        values, spread = self.both_branches(self.axis)
        said = [self.one_by_one(n, values, spread) for n in range(len(self.names))]
        rows = (" ".join(f"{n} {x:z.4f}" for n, x in zip(self.names, each, strict=True)) for each in values[0])
        right = ", or ".join(dict.fromkeys(rows)) if np.isfinite(values[0]).all() else "none: it is out of reach"
        return " ".join([*said, f"Right is {right}.{self.zero(values, spread)}"])

    def one_by_one(self, n: int, values: np.ndarray, spread: np.ndarray) -> str:
        """Explain one angle alone, by one slip at most, as one number fits many misreadings by accident."""
        right = Setup.right(self.kinematics.machine)
        for slips in ((), *((each,) for each in causes_of_words(self.kinematics.machine))):
            setup = misread(right, *slips)
            words = (values[..., n] - setup.zero[n]) / setup.factor[n]
            off = np.abs(wrap(self.given[:, None, n] - words)) <= spread[..., n] + self.half_digit
            alone = setup.source == right.source and setup.order == right.order and setup.signs == right.signs
            if alone and off.any(axis=1).all():
                return f"{self.names[n]} alone: {slips[0].phrase if slips else 'right'}."
        return f"{self.names[n]}: no misreading gives it."

    def zero(self, values: np.ndarray, spread: np.ndarray) -> str:
        """Say by what constant the angles are off on a branch, if an axis or a second row confirms it."""
        off, slack = wrap(self.given[:, None] - values), spread + self.half_digit
        constant = (np.abs(wrap(off - off[:1])) <= 2 * slack).all(axis=(0, 2))
        right = (np.abs(off) <= slack).all(axis=0)
        for branch in np.flatnonzero(constant & (right.any(axis=1) | (len(off) > 1))):
            wrong = [n for n in range(len(self.names)) if not right[branch, n]]
            said = ", ".join(f"{self.names[n]} by {off[0, branch, n]:+.4f}°" for n in wrong)
            return f" Off by a constant, as a zero point is: {said}."
        return ""
