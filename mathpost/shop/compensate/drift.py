"""Errors that drift, tracked from part to part by recursive least squares.

The last text of source 001 asks for dynamic correction: measure, compute the error, correct the next motion. Here
each part's readings, at the same poses, refine an estimate of the drifting errors. Older parts are forgotten by a
factor. A reading that contradicts what is known is set aside, unless most do: one sensor may lie, but if all say
the same, the machine has changed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import ArrayLike

from mathpost.errors import InputError, as_array
from mathpost.shop.compensate.model import ErrorModel, constant_errors
from mathpost.shop.measure.fit import check_told_apart


@dataclass(frozen=True)
class Update:
    """What one part's readings did."""

    set_aside: np.ndarray  # which contradict the past, shape (poses, 3)
    changed: bool  # whether most of them do: then the machine has changed, and the past is dropped instead


class Tracker:
    """Recursive least squares for some errors of a machine, from tip readings at fixed poses.

    `names` are the errors of `model`, an `ErrorModel`, that drift; `poses`, shape (poses, 5), the joints at which
    every part is probed, mm and radians. `sigma` is the standard deviation of one reading, mm; `expected` is how
    large the errors may be before anything is read, one number for all or one for each. `forgetting`, above 0, is
    the weight of a part's readings one part later; 1 averages over all parts. A reading is set aside beyond `gate`
    standard deviations; an infinite gate believes everything.

    The estimate is `values`, mm and radians; `covariance` is its covariance if the errors do not change and
    `forgetting` is 1. `InputError` if the poses cannot tell the errors apart: it says which, and which joint to
    move as well.

    Examples
    --------
    >>> from mathpost import load_machine
    >>> from mathpost.shop.compensate.model import ErrorModel
    >>> model = ErrorModel(load_machine("data/machines/ac_table.toml"))
    >>> tracker = Tracker(model, ["EYA", "EYC"], [[0, 0, 0, 0, 0], [0, 0, 0, 1, 0]], sigma=0.001, expected=0.1)
    >>> update = tracker.update(tracker.predict([0.010, 0.020]))
    >>> tracker.values.round(4), update.set_aside.any().item()
    (array([0.01, 0.02]), False)
    >>> Tracker(model, ["EYA", "EYC"], [[0, 0, 0, 0, 0]], sigma=0.001, expected=0.1)
    Traceback (most recent call last):
        ...
    mathpost.errors.InputError: poses: expected poses that tell EYA and EYC apart (moving A too would), found ...
    """

    def __init__(
        self, model: ErrorModel, names: Sequence[str], poses: ArrayLike, *, sigma: float, expected: ArrayLike,
        forgetting: float = 0.7, gate: float = 5.0,
    ) -> None:  # fmt: skip
        self.model, self.names = model, tuple(names)
        constant_errors(model.machine, dict.fromkeys(names, 0))  # refuses other names
        if not 0 < forgetting <= 1:
            raise InputError("forgetting", "a number above 0, at most 1", f"{forgetting}")
        if not (sigma > 0 and gate > 0 and np.all(np.asarray(expected) > 0)):
            raise InputError("sigma, expected and gate", "sizes above 0", f"{sigma}, {expected!r} and {gate}")
        self.poses = np.atleast_2d(as_array(poses, 5, "poses"))
        self.sigma, self.forgetting, self.gate = sigma, forgetting, gate
        self.expected = np.broadcast_to(np.asarray(expected, dtype=float), len(self.names))
        self.design = self._design(self.poses)
        steps = np.diag([100, 100, 100, *np.deg2rad([50, 50])])
        moved = [partial(self._design, self.poses + step) for step in steps]
        further = dict(zip(model.machine.joint_names, moved, strict=True))
        found, otherwise = f"{len(self.poses)} that do not", "no other position of one joint"
        check_told_apart(self.design, self.names, further, "poses", "poses", found, otherwise, "moving {} too")
        self.values, self.covariance = np.zeros(len(self.names)), np.diag(self.expected**2)

    def predict(self, values: ArrayLike) -> np.ndarray:
        """Return the tip readings, shape (poses, 3) in mm, that errors of these `values` cause."""
        return (self.design @ np.asarray(values, dtype=float)).reshape(-1, 3)

    def drift(self) -> np.ndarray:
        """Return the estimate among all errors of the model, shape (33,), for `Compensator.with_drift`."""
        drift = np.zeros(len(self.model.names))
        drift[[self.model.names.index(name) for name in self.names]] = self.values
        return drift

    def sure(self) -> bool:
        """Return the standard deviation that each value will have after one part, shape (names,)."""
        information = self.design.T @ self.design / self.sigma**2 + np.linalg.inv(self.covariance)
        return np.sqrt(np.diag(np.linalg.inv(information)))

    def update(self, readings: ArrayLike, *, corrected: float = 0.0) -> Update:
        """Take in the readings of one more part, and return the `Update`.

        `readings`, shape (poses, 3), are where the tip was minus where it should have been, in the workpiece, mm.
        `corrected`, shape (names,), are the values with which that part had already been corrected.
        """
        tips = as_array(readings, 3, "readings")
        if tips.shape != (len(self.poses), 3):
            raise InputError("readings", f"shape {(len(self.poses), 3)}, one for each pose", f"{tips.shape}")
        read = tips.ravel() + self.design @ np.broadcast_to(corrected, len(self.names))
        self.covariance = self.covariance / self.forgetting
        variance = np.einsum("ij,jk,ik->i", self.design, self.covariance, self.design) + self.sigma**2
        surprise = np.abs(read - self.design @ self.values) / np.sqrt(variance)
        changed = bool((surprise > self.gate).mean() > 0.5)
        if changed:
            self.covariance = np.diag(self.expected**2) + self.covariance
        # The least surprising first: a liar is judged by what the others have already said.
        set_aside = np.zeros(len(read), dtype=bool)
        for row in np.argsort(surprise):
            h = self.design[row]
            seen, missed = self.covariance @ h, read[row] - h @ self.values
            variance = h @ seen + self.sigma**2
            set_aside[row] = abs(missed) > self.gate * np.sqrt(variance)
            if not set_aside[row]:
                gain = seen / variance
                self.values = self.values + gain * missed
                # Joseph's form keeps the covariance symmetric and positive whatever the rounding.
                keep = np.eye(len(h)) - np.outer(gain, h)
                self.covariance = keep @ self.covariance @ keep.T + self.sigma**2 * np.outer(gain, gain)
        return Update(set_aside.reshape(-1, 3), changed)

    def _design(self, poses: np.ndarray) -> np.ndarray:
        columns = [self.model.names.index(name) for name in self.names]
        return self.model.sensitivities(poses)[:, :3, columns].reshape(-1, len(self.names))
