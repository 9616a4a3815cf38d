"""Why is the tip there? A tip or words X Y Z that somebody's chain gave, and the causes that give the same.

Forward, the joints are known and the tip is in question; backward, the tip and the rotary words are known and X Y Z
are in question. Each of `causes.causes` is tried alone, then each pair.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
from numpy.typing import ArrayLike

from mathpost.detective.causes import Setup, causes, slip
from mathpost.detective.digits import half_digit, written_decimals
from mathpost.detective.explanation import CHANCE, Explanation, Match, Trial, explanation, misread
from mathpost.errors import InputError, as_array
from mathpost.files import text_of
from mathpost.kinematics import Kinematics
from mathpost.machine import Machine

GENERIC = np.array(
    [(13.7, -21.3, 34.1, 31.3, 47.9), (-44.9, 17.3, 8.6, -23.7, 104.1), (5.2, 61.4, -12.8, 67.2, -15.8)]
)
PROBES = np.array(
    [(10, 0, 0, 30, 0), (0, 20, 0, 30, 0), (10, 20, 30, 0, 40), (10, 20, 30, 30, 40), (10, 20, 30, -20, 70)]
)


def explain_tip(
    kinematics: Kinematics, joints: ArrayLike, answer: ArrayLike, *, decimals: int | None = None
) -> Explanation:
    """Return the causes that give somebody's tip for known joints, the simplest first.

    `joints`, shape (3 + k,) or (n, 3 + k), are X Y Z in mm and the k rotary words in degrees. `answer` is the tip
    in the workpiece, (3,) or (n, 3), or tip and tool axis, (6,) or (n, 6), to `decimals` digits, by default as many
    as they show. `InputError` unless they are finite numbers of that shape.

    Examples
    --------
    >>> from mathpost import load_machine
    >>> kin = Kinematics(load_machine("bc_table"))
    >>> tip, _ = kin.forward([1, 0, 2, -40, 30], degrees=True)
    >>> print(explain_tip(kin, [1, 0, 2, 40, 30], tip.round(4)))
    B turns the other way: X -67.2504 Y -38.827 Z -25.8998
    """
    return _explained(kinematics, joints, answer, "pose", decimals)


def explain_linear(
    kinematics: Kinematics,
    tip: ArrayLike,
    angles: ArrayLike,
    answer: ArrayLike,
    *,
    decimals: int | None = None,
    together: int = 2,
) -> Explanation:
    """Return the causes that give somebody's words X Y Z for a known tip and rotary words, the simplest first.

    `tip` and `answer` have shape (3,) or (n, 3), mm, `angles` (k,) or (n, k), degrees. Up to two causes are tried
    `together`, or each alone.

    Examples
    --------
    >>> from mathpost import load_machine
    >>> kin = Kinematics(load_machine("head_b_table_c"))
    >>> print(explain_linear(kin, [0, 0, 0], [0, 90], [180.0, 0, -180.0]))
    the tool length is not turned with the head: X 180 Y 0 Z -180
    """
    tips, rotary = np.asarray(tip, dtype=object), np.asarray(angles, dtype=object)
    if tips.shape[:-1] != rotary.shape[:-1]:
        expected = f"shape {(*tips.shape[:-1], len(kinematics.symbols) - 3)}"
        raise InputError("rotary words", expected, f"{rotary.shape}")
    given = np.concatenate([tips, rotary], axis=-1)
    return _explained(kinematics, given, answer, "linear", decimals, together)


def _explained(
    kinematics: Kinematics, given: ArrayLike, answer: ArrayLike, way: str, decimals: int | None, together: int = 2
) -> Explanation:
    width = len(kinematics.symbols)
    numbers, target = as_array(given, width, "joints"), np.asarray(answer, dtype=object)
    wanted = 6 if way == "pose" and target.shape[-1:] == (6,) else 3
    target = as_array(answer, wanted, "result")
    if numbers.ndim > 2 or target.shape != (*numbers.shape[:-1], wanted):
        raise InputError("result", f"shape {(*numbers.shape[:-1], wanted)}", f"shape {target.shape}")
    decimals = written_decimals(answer) if decimals is None else decimals
    halves = [half_digit(column) for column in np.atleast_2d(np.asarray(given, dtype=object)).T]
    case = _Case(
        kinematics.machine, np.atleast_2d(numbers), np.atleast_2d(target), way, decimals, np.array(halves), together
    )
    # Whole numbers are meant exactly if something gives them exactly, as right angles do.
    exact = replace(case, decimals=9).explain(target.shape) if decimals == 0 else None
    return exact if exact and exact.explained else case.explain(target.shape)


@dataclass(frozen=True)
class _Case:
    """One question."""

    machine: Machine
    given: np.ndarray  # (n, 3 + k)
    target: np.ndarray  # (n, 3) or (n, 6)
    way: str  # "pose" or "linear", a method of `Setup`
    decimals: int
    halves: np.ndarray  # half of the last digit of each given number
    together: int  # how many causes are tried at once

    @property
    def tolerance(self) -> float:
        """The deviation that the digits of the answer and of the input allow, mm."""
        lever = np.linalg.norm(self.given[:, :3], axis=1).max() + np.abs(self.target[:, :3]).max()
        lever += sum(np.linalg.norm(each.point) for each in self.machine.rotary) + self.machine.tool_length
        moved = np.deg2rad(self.halves[3:].sum()) * lever + self.halves[:3].sum()
        return 0.5 * 10.0**-self.decimals * (1 + 1e-6) + moved + 1e-9 * max(1.0, lever)

    def value(self, setup: Setup, given: np.ndarray | None = None) -> np.ndarray:
        """Return the result of a setup, (n, 3) or (n, 6)."""
        return getattr(setup, self.way)(self.given if given is None else given)[:, : self.target.shape[1]]

    def fits(self, setup: Setup) -> bool:
        return np.abs(self.value(setup) - self.target).max() <= self.tolerance

    def with_a_constant(self, setup: Setup) -> Setup | None:
        """Return the setup with what is added to X, Y or Z in every row, if that gives the answer."""
        off = (self.target - self.value(setup))[:, :3]
        if len(off) < 2 or np.ptp(off, axis=0).max() > 2 * self.tolerance:
            return None
        middle = (off.min(axis=0) + off.max(axis=0)) / 2
        added = np.where(np.abs(middle) > 2 * self.tolerance, middle.round(self.decimals), 0.0)
        named = [f"{value:+.10g} in {name}" for name, value in zip("XYZ", added, strict=True) if value]
        cause = slip("origin", f"a constant is added: {', '.join(named)}", 0.3 + 0.1 * len(named))
        made = replace(misread(setup, cause), added=tuple(added.tolist()))
        return made if named and self.fits(made) else None

    def explain(self, shape: tuple[int, ...]) -> Explanation:
        right, found = Setup.right(self.machine), causes(self.machine)
        tried, setups = 1, [right]
        matches = [right] if self.fits(right) else []
        for depth in range(1, self.together + 1):
            if matches:
                break
            matches = [also for setup in setups if (also := self.with_a_constant(setup)) is not None]
            if matches and depth > 1:
                break
            setups = [misread(right, *several) for several in combinations(found, depth)]
            tried += len(setups)
            matches += [setup for setup in setups if self.fits(setup)]
        size = np.abs(self.target[:, :3]).max() + np.linalg.norm(self.given[:, :3], axis=1).max()
        rows = len(self.given) - any(np.any(setup.added) for setup in matches)  # a row gives the constant
        share = min(1.0, 2 * self.tolerance / max(size, 1e-9)) ** (2 * rows)
        if matches != [right] and tried * share > CHANCE:
            matches = []
        return explanation(
            [self.match(setup) for setup in matches], self.trial(), self.tolerance, tried, shape=shape,
            otherwise=lambda: self.what_is_known(right), travel=rotary_travel(self.machine, self.given[:, 3:]),
        )  # fmt: skip

    def match(self, setup: Setup) -> Match:
        return Match(setup.slips, _written(self.value(setup)), lambda given: self.value(setup, given))

    def trial(self) -> Trial:
        """The question, and other inputs."""
        width = self.given.shape[1]
        names = self.machine.joint_names if self.way == "pose" else ("x", "y", "z", *self.machine.joint_names[3:])
        probes = [
            (" ".join(f"{name} {value:g}" for name, value in zip(names, probe, strict=True)), probe[None])
            for probe in PROBES[:, :width].astype(float)
        ]
        return Trial(self.given, [GENERIC[:, :width]], probes, _written, "number")

    def what_is_known(self, right: Setup) -> str:
        """Say how far somebody's answer is from the right one."""
        value = self.value(right)
        return f"Right is {_written(value)}; it is off by {_written(self.target - value)}."


def rotary_travel(machine: Machine, angles: np.ndarray) -> tuple[str, ...]:
    """Return a sentence for each rotary word, (n, k) in degrees, that is outside travel, once."""
    said = []
    for row in angles:
        for joint, angle in zip(machine.rotary, row, strict=True):
            low, high = np.degrees(joint.limits)
            if not low - 1e-7 <= angle <= high + 1e-7:
                said.append(f"{joint.name} {angle:g} is outside {low:g} … {high:g}")
    return tuple(dict.fromkeys(said))


def _written(rows: Iterable[np.ndarray]) -> str:
    """The first of some rows as words."""
    pairs = zip(("X", "Y", "Z", "i", "j", "k"), next(iter(rows)), strict=False)
    return " ".join(f"{name} {text_of(value)}" for name, value in pairs)
