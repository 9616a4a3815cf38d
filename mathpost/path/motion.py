"""The poses that a machine runs through, where on the CL path each of them is, and what it is for."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

if TYPE_CHECKING:
    from mathpost.path.cl import CLData

ON_PART, LIFTED, SAFE = range(3)  # what a pose is: in cut, retracted along the tool axis, where all axes may turn


@dataclass(frozen=True)
class Motion:
    """The m poses that the machine runs through, all joints linearly from each to the next."""

    joints: np.ndarray  # shape (m, 5), mm and radians
    place: np.ndarray  # shape (m,), where on the CL path: 2.25 is a quarter of the way from record 2 to record 3
    kind: np.ndarray  # shape (m,), `ON_PART`, `LIFTED` or `SAFE`

    @classmethod
    def on_part(cls, joints: np.ndarray, place: ArrayLike) -> Motion:
        """Poses none of which is lifted."""
        return cls(joints, np.asarray(place, dtype=float), np.full(len(joints), ON_PART, np.int8))

    @classmethod
    def joined(cls, parts: Sequence[Motion]) -> Motion:
        """One motion after the other."""
        if len(parts) == 1:
            return parts[0]
        return Motion(
            np.concatenate([part.joints for part in parts]),
            np.concatenate([part.place for part in parts]),
            np.concatenate([part.kind for part in parts]),
        )

    def __getitem__(self, rows: slice | np.ndarray) -> Motion:
        """The same of some poses: a slice or an index array."""
        return Motion(self.joints[rows], self.place[rows], self.kind[rows])

    @property
    def lifted(self) -> np.ndarray:
        """Whether each pose is off the part, shape (m,)."""
        return self.kind != ON_PART

    @property
    def record(self) -> np.ndarray:
        """The record that each pose is at or leads to, shape (m,)."""
        return np.ceil(self.place).astype(int)

    @property
    def in_cut(self) -> np.ndarray:
        """Whether each move is in cut, both ends on the part, shape (m - 1,)."""
        return ~(self.lifted[:-1] | self.lifted[1:])

    @property
    def far(self) -> np.ndarray:
        """Whether each move has an end at a safe position, shape (m - 1,)."""
        return (self.kind[:-1] == SAFE) | (self.kind[1:] == SAFE)

    def at_feed(self, cl: CLData) -> np.ndarray:
        """Whether each move is in cut and not rapid, so that its tool axis counts, shape (m - 1,)."""
        return self.in_cut & ~cl.rapid[self.record[1:]]
