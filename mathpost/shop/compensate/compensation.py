"""Compensate the systematic errors of a machine, after Bohez (source 001), and say what is left.

Errors that do not depend on position are put into the inverse directly (`CalibratedKinematics`); those that do are
taken out by one step of the total differential of the inverse, dq = −J⁺·Jₑ·e(q). Which error belongs to which group
the source does not say. Near the singular position of the machine the step asks for a great turn in return for a
small tilt, and its remainder, which grows with the square of the turn, makes things worse. There the turn is
limited, X Y Z still correct the tip, and a point that would nevertheless become worse stays as programmed.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
import sympy as sp
from numpy.typing import ArrayLike

from mathpost.errors import as_array
from mathpost.formula import numeric
from mathpost.kinematics import Kinematics
from mathpost.rotation import angle_of_chord, unit, wrap
from mathpost.shop.compensate.model import COMPONENTS, ErrorModel, MachineErrors, error_frame, named_point

if TYPE_CHECKING:
    from mathpost.machine import Machine

MAX_TURN = np.deg2rad(0.1)  # its second-order remainder is 0.15 µm for every 100 mm between tool and rotary axis
MAX_GAIN = 10  # turn for tilt that is never limited: that of a tool axis some 6 degrees from the singular one
ROUNDING = 1e-13  # radians
NEGLIGIBLE = 1e-4, 1e-7  # mm and radians by which "worse" is not worth refusing
Pose = tuple[np.ndarray, np.ndarray]  # tip and tool axis
_SIX, _POINT = sp.symbols(tuple(COMPONENTS), real=True), sp.symbols(("px", "py", "pz"), real=True)


class CalibratedKinematics:
    """The exact inverse kinematics of a machine whose errors are constants: Bohez's first group.

    A turn behind a constant error frame E is the turn about the line that E has moved, followed by E: E·Turn(line)
    = Turn(E·line)·E. Moved outwards joint by joint, the frames leave a `machine` with other axes and pivots, slides
    with other directions, and one small displacement of the `workpiece` or the tool: a machine with the closed-form
    inverse of `mathpost.kinematics`; it has no tool, and its words are the positions of its slides.
    `constant`, shape (33,), is in the order of `model.names`, mm and radians.
    """

    def __init__(self, model: ErrorModel, constant: ArrayLike) -> None:
        self.slides = np.empty((3, 3))  # true directions of X, Y and Z as columns
        self.nominal = model.machine
        machine = model.machine.with_setup(origin=np.zeros(3), tool_length=0.0)
        errors = dict(zip(model.names, np.asarray(constant, dtype=float), strict=True))
        moved: dict[str, tuple[np.ndarray, np.ndarray]] = {}
        self.workpiece = self._outwards("workpiece", machine, errors, moved, start=np.zeros(3))
        # Beyond the slides the chain counts from the spindle nose.
        axis = unit(machine.tool_axis)
        programmed = named_point(machine, 0.0)
        frame = self._outwards("tool", machine, errors, moved, start=programmed)
        nose, rotary = frame[:3, 3], []
        for each in machine.rotary:
            point, direction = moved[each.name]
            point = point - nose * (each.carries == "tool")
            rotary.append(replace(each, point=tuple(point.tolist()), axis=tuple(direction.tolist())))
        self.machine = replace(
            machine,
            rotary=tuple(rotary),
            tool_axis=tuple((frame[:3, :3] @ axis).tolist()),
            programmed_point=tuple((programmed - nose).tolist()),
        )
        self._kinematics = Kinematics(self.machine)

    def _outwards(
        self, side: str, machine: Machine, errors: dict[str, float],
        moved: dict[str, tuple[np.ndarray, np.ndarray]], start: np.ndarray,
    ) -> np.ndarray:  # fmt: skip
        """Move all error frames of a side outwards from the bed; return the one frame that they leave at its end.

        The slides' directions and, in `moved`, point and direction of each rotary axis are those behind them.
        """
        frame = np.eye(4)
        for name in machine.slides_that_carry(side):
            along = np.eye(3)["XYZ".index(name)]
            turned = [errors.get(f"E{about}0{name}", 0.0) for about in "ABC"]  # out of square
            self.slides[:, "XYZ".index(name)] = frame[:3, :3] @ (along + np.cross(turned, along))
            frame = frame @ _frame(name, np.zeros(3), errors)
        frame = _translation(start) @ frame @ _translation(-start)
        for rotary in machine.rotary:
            if rotary.carries == side:
                point = np.array(rotary.point)
                frame = frame @ _frame(rotary.name, point, errors)
                moved[rotary.name] = frame[:3, :3] @ point + frame[:3, 3], frame[:3, :3] @ unit(rotary.axis)
        return frame

    def inverse(self, tip: ArrayLike, axis: ArrayLike) -> np.ndarray:
        """Return the joints of both branches with which the machine, errors and all, reaches a pose.

        Parameters, result and errors are those of `mathpost.kinematics.Kinematics.inverse`; radians.
        """
        turned, shift, nominal = self.workpiece[:3, :3].T, self.workpiece[:3, 3], self.nominal
        nose = np.asarray(tip) + nominal.origin + nominal.tool_length * unit(axis)
        joints = self._kinematics.inverse(nose @ turned + shift, np.asarray(axis) @ turned)
        positions = np.linalg.solve(self.slides, joints[..., :3, None])[..., 0]
        joints[..., :3] = positions - nominal.slide_positions(np.zeros(3))
        return joints


@dataclass(frozen=True)
class PoseError:
    """What the machine misses at each point, shape (...)."""

    tip: np.ndarray  # mm
    axis: np.ndarray  # radians

    def __str__(self) -> str:
        tip, axis = 1e3 * self.tip, np.rad2deg(self.axis) * 3600
        return (
            f"tip {tip.mean():.3f} µm on average, {tip.max():.3f} µm at most; "
            f"tool axis {axis.mean():.2f} arcsec on average, {axis.max():.2f} arcsec at most"
        )


@dataclass(frozen=True)
class Compensated:
    """Joints that take the machine's errors into account."""

    joints: np.ndarray  # shape (..., 5), mm and radians
    before: PoseError  # with the joints as programmed
    after: PoseError  # and with these
    limited: np.ndarray  # where the turn was limited, so that the tool axis is corrected only in part, shape (...)
    refused: np.ndarray  # where the joints are those programmed: the correction would have made things worse

    @property
    def cautions(self) -> tuple[str, ...]:
        """Sentences that say how many points were limited or refused; none if none was."""
        worst = np.rad2deg(self.after.axis[self.limited].max(initial=0)) * 3600
        said = {
            "stand too near the singular position for the whole turn: there the tip is corrected, and up to "
            f"{worst:.2f} arcsec of the tool axis' error stay": self.limited,
            "stay as programmed: the step made them worse": self.refused,
        }
        return tuple(f"{at.sum()} of {at.size} points {what}" for what, at in said.items() if at.any())

    def __str__(self) -> str:
        said = f"volumetric error before: {self.before}", f"volumetric error after:  {self.after}", *self.cautions
        return "\n".join(said)


class Compensator:
    """Compensates joints for the `MachineErrors` of one machine.

    `max_turn` is the greatest correction of a rotary axis for a tilt that it can hardly make, radians.

    Examples
    --------
    >>> from mathpost import load_machine
    >>> from mathpost.shop.compensate.model import constant_errors
    >>> trunnion = load_machine("data/machines/ac_table.toml")
    >>> compensator = Compensator(constant_errors(trunnion, {"EXC": 0.012, "EAC": 30e-6}))
    >>> result = compensator.compensate([40, -25, 30, 0.6, 1.2])
    >>> f"{1e3 * result.before.tip:.2f} µm, {1e3 * result.after.tip:.2f} µm"
    '12.16 µm, 0.00 µm'
    """

    def __init__(self, errors: MachineErrors, *, max_turn: float = MAX_TURN) -> None:
        self.errors, self.max_turn = errors, max_turn
        self.machine, self.model = errors.machine, ErrorModel(errors.machine)

    @cached_property
    def calibrated(self) -> CalibratedKinematics:
        """The exact inverse of the machine with the first group of its errors."""
        return CalibratedKinematics(self.model, self.errors.constant)

    def with_drift(self, drift: ArrayLike) -> Compensator:
        """Return a `Compensator` of the same machine, whose errors have drifted by `drift`, shape (33,)."""
        drift = as_array(drift, len(self.model.names), "drift")
        other = Compensator(replace(self.errors, drift=drift), max_turn=self.max_turn)
        other.calibrated = self.calibrated  # the drift belongs to the second group
        return other

    def costs(self, joints: ArrayLike) -> dict[str, np.ndarray]:
        """Return what each error costs at the tip at `joints`, shape (..., 5), to first order.

        A dict: the name of each error that is not 0 everywhere to an array of mm, shape (...), dearest first.
        """
        errors = self.errors.at(joints)
        moved = self.model.sensitivities(joints)[..., :3, :] * errors[..., None, :]
        costs = zip(self.model.names, np.moveaxis(np.linalg.norm(moved, axis=-2), -1, 0), strict=True)
        return dict(sorted((item for item in costs if item[1].any()), key=lambda item: -item[1].max()))

    def forward(self, joints: ArrayLike) -> Pose:
        """Return tip and axis that the machine takes at `joints`, errors and all; mm and radians."""
        return self.model.forward(joints, self.errors.at(joints))

    def wanted(self, joints: ArrayLike) -> Pose:
        """Return tip and axis that a machine without errors takes at `joints`."""
        return self.model.forward(joints, np.zeros(len(self.model.names)))

    def miss(self, joints: ArrayLike, wanted: Pose | None = None) -> PoseError:
        """Return the `PoseError` of `joints` against the pose `wanted`, by default that without errors."""
        tip, axis = self.forward(joints)
        wanted_tip, wanted_axis = self.wanted(joints) if wanted is None else wanted
        turned = angle_of_chord(np.linalg.norm(axis - wanted_axis, axis=-1))
        return PoseError(np.linalg.norm(tip - wanted_tip, axis=-1), turned)

    def compensate(self, joints: ArrayLike) -> Compensated:
        """Return the joints, as `Compensated`, with which the machine comes to where `joints` were meant to be.

        `joints`, shape (..., 5), mm and radians, are as computed for a machine without errors.
        """
        joints = as_array(joints, len(self.machine.joint_names), "joints")
        wanted = self.wanted(joints)
        before = self.miss(joints, wanted)
        base, exact = self._first_group(joints, wanted, np.maximum(self.max_turn, MAX_GAIN * before.axis))
        left = np.where(exact[..., None], self.errors.varying(base), self.errors.at(base))
        step, limited = total_differential(self.model, base, left, max_turn=self.max_turn)
        after = self.miss(base + step, wanted)
        refused = (after.tip > before.tip + NEGLIGIBLE[0]) | (after.axis > before.axis + NEGLIGIBLE[1])
        corrected = np.where(refused[..., None], joints, base + step)
        return Compensated(corrected, before, self.miss(corrected, wanted), limited & ~refused, refused)

    def _first_group(self, joints: np.ndarray, wanted: Pose, most: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The exact inverse nearest to `joints` where it turns by no more than `most`, else `joints` themselves."""
        change = self.calibrated.inverse(*wanted) - joints[..., None, :]
        change[..., 3:] = wrap(change[..., 3:], 2 * np.pi)
        turn = np.abs(change[..., 3:] - _own_turns(self.model, self.errors.constant)).max(axis=-1)
        nearest = np.argmin(np.where(np.isnan(turn), np.inf, turn), axis=-1)[..., None]
        exact = np.take_along_axis(turn, nearest, axis=-1)[..., 0] <= most
        change = np.take_along_axis(change, nearest[..., None], axis=-2)[..., 0, :]
        return np.where(exact[..., None], joints + change, joints), exact


def total_differential(
    model: ErrorModel, joints: np.ndarray, errors: np.ndarray, *, max_turn: float = np.inf
) -> tuple[np.ndarray, np.ndarray]:
    """Return one step of the total differential, dq = −J⁺·Jₑ·e, (..., 5), and where it was limited, (...).

    The Jacobian J of tip and axis (6×5) falls in two: only the rotary axes turn the tool, and X Y Z, which are
    never singular, then make up for what the turn does to the tip. `joints` have the shape (..., 5), `errors`, in
    the order of `model.names`, (..., 33); mm and radians. `max_turn` limits a turn that is more than `MAX_GAIN`
    times the tilt for which it is made, beside what takes out an axis' own positioning error.
    """
    missed = np.einsum("...ij,...j->...i", model.sensitivities(joints), errors)
    jacobian = model.jacobian(joints)
    left, sizes, right = np.linalg.svd(jacobian[..., 3:, 3:], full_matrices=False)
    own = _own_turns(model, errors)
    tilted = missed[..., 3:] + np.einsum("...ij,...j->...i", jacobian[..., 3:, 3:], own)
    tilt = np.einsum("...ij,...i->...j", left, tilted)
    tilt = np.where(np.abs(tilt) < ROUNDING, 0, tilt)
    wanted = -tilt / np.maximum(sizes, np.finfo(float).tiny)
    most = np.maximum(max_turn, MAX_GAIN * np.abs(tilt))
    # Beyond the limit the turn falls again as the pole comes nearer, where it would do nothing for the tilt, and so
    # goes through zero at the pole, where the wanted turn jumps from plus to minus infinity.
    beyond = np.abs(wanted) > most
    turn = np.where(beyond, most**2 / np.where(beyond, wanted, 1), wanted)
    rotary = own + np.einsum("...ji,...j->...i", right, turn)
    tip = missed[..., :3] + np.einsum("...ij,...j->...i", jacobian[..., :3, 3:], rotary)
    linear = -np.linalg.solve(jacobian[..., :3, :3], tip[..., None])[..., 0]
    return np.concatenate([linear, rotary], axis=-1), beyond.any(axis=-1)


def _own_turns(model: ErrorModel, errors: np.ndarray) -> np.ndarray:
    """The turns, shape (..., 2), that take out what the rotary axes' own positioning errors turn."""
    columns = [[model.names.index(f"E{c}{rotary.name}") for c in "ABC"] for rotary in model.machine.rotary]
    axes = unit([rotary.axis for rotary in model.machine.rotary])
    return -np.einsum("...ij,ij->...i", np.asarray(errors)[..., columns], axes)


def _frame(joint: str, point: np.ndarray, errors: dict[str, float]) -> np.ndarray:
    kernel = numeric(error_frame(_SIX, sp.Matrix(_POINT)), (*_SIX, *_POINT))
    return kernel(*(errors[f"E{component}{joint}"] for component in COMPONENTS), *point)


def _translation(vector: ArrayLike) -> np.ndarray:
    matrix = np.eye(4)
    matrix[:3, 3] = vector
    return matrix
