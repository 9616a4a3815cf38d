"""One tilted working plane in every control's notation.

A plane is a `Frame`: the feature in the workpiece. `Plane` has it as the numbers of one notation, in degrees as
in an NC program.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import permutations

import numpy as np

from mathpost import euler
from mathpost.errors import InputError, as_array
from mathpost.frame import Frame
from mathpost.rotation import unit

PERPENDICULAR = 1e-6  # cosine that seven printed decimals leave between two perpendicular vectors


@dataclass(frozen=True)
class Notation:
    """The words of one notation and what they mean."""

    words: tuple[str, ...]
    sequence: str = ""  # the Euler sequence that they fill in their order; without one they are two vectors
    lock: str = "third"  # the angle that is 0 at the lock
    rule: str = "chosen here: no manual was found that fixes it"  # where that comes from


NOTATIONS = {
    "G68.2": Notation(("I", "J", "K"), "ZXZ"),
    "G68.2 P1": Notation(("I", "J", "K"), "xyz"),
    "G68.2 P3": Notation(("I1", "J1", "K1", "I2", "J2", "K2")),
    "G268": Notation(("I", "J", "K"), "xyz"),
    "PLANE EULER": Notation(("EULPR", "EULNU", "EULROT"), "ZXZ"),
    "PLANE SPATIAL": Notation(("SPA", "SPB", "SPC"), "xyz"),
    "PLANE VECTOR": Notation(("BX", "BY", "BZ", "NX", "NY", "NZ")),
    "AROT RPY": Notation(("X", "Y", "Z"), "xyz", "first", "the manual's read-back: X becomes 0"),
    **{f"CYCLE800 {''.join(order)}": Notation(("A", "B", "C"), "".join(order)) for order in permutations("XYZ")},
    "CYCLE800 solid": Notation(("A", "B", "rest"), "ZYZ"),
}


@dataclass(frozen=True, eq=False)
class Plane:
    """A tilted plane as the numbers of one notation.

    In ``"CYCLE800 solid"`` the angles A and B give the direction only; ``rest`` is what remains about the new Z.
    The two vectors of PLANE VECTOR, and of G68.2 P3, have any length above zero. If they are not perpendicular,
    ``keep="N"`` keeps the normal and takes from B what lies in the plane, ``keep="B"`` keeps the base vector;
    without it they are refused with an `InputError` that says by how much.

    Examples
    --------
    >>> plane = Plane("G68.2", [135, 54.7356103172, -90])
    >>> plane.to("PLANE SPATIAL").values.round(6) + 0.0
    array([ 0.     , 54.73561, 45.     ])
    >>> plane.to("PLANE VECTOR")["NZ"].round(6)
    np.float64(0.57735)
    """

    notation: str  # one of `NOTATIONS`
    values: np.ndarray  # in the order of the words, degrees, shape (..., 3); of two vectors no unit, (..., 6)
    origin: np.ndarray = field(default_factory=lambda: np.zeros(3))  # in the workpiece, mm, (..., 3)
    keep: str = ""

    def __post_init__(self) -> None:
        if self.notation not in NOTATIONS:
            raise InputError("notation", f"one of {', '.join(NOTATIONS)}", repr(self.notation))
        if self.keep not in ("", "B", "N"):
            raise InputError("keep", "'B', 'N' or nothing", repr(self.keep))
        object.__setattr__(self, "values", as_array(self.values, len(self.words), self.notation))
        object.__setattr__(self, "origin", as_array(self.origin, 3, "origin"))
        if not NOTATIONS[self.notation].sequence:
            self._vectors()

    @classmethod
    def from_frame(cls, frame: Frame, notation: str) -> Plane:
        """Write `frame` in `notation`; where that locks, by the rule that `note` states. EULROT is in [0, 360)."""
        about = NOTATIONS.get(notation)  # the plane itself refuses an unknown one
        if about and about.sequence:
            values = euler.angles(about.sequence, frame.rotation, lock=about.lock, degrees=True)
        else:
            values = np.concatenate([frame.x, frame.z], axis=-1)
        if notation == "PLANE EULER":
            values[..., 2] %= 360
        return cls(notation, values, frame.origin)

    def to(self, notation: str) -> Plane:
        """Return the same plane in another notation."""
        return Plane.from_frame(self.frame, notation)

    @property
    def words(self) -> tuple[str, ...]:
        """The names of the values, in their order."""
        return NOTATIONS[self.notation].words

    def __getitem__(self, word: str) -> np.ndarray:
        """The value of one word, shape (...)."""
        if word not in self.words:
            raise InputError(self.notation, f"one of {', '.join(self.words)}", repr(word))
        return self.values[..., self.words.index(word)]

    @property
    def frame(self) -> Frame:
        """The feature in the workpiece, a `Frame`."""
        sequence = NOTATIONS[self.notation].sequence
        if sequence:
            return Frame(euler.matrix(sequence, self.values, degrees=True), self.origin, "WCS", "feature")
        base, normal = self._vectors()
        if self.keep == "B":
            normal = normal - (normal * base).sum(axis=-1, keepdims=True) * base
        return Frame.from_axes(normal, base, self.origin, "WCS", "feature")

    @property
    def locked(self) -> np.bool | np.ndarray:
        """Whether two of the angles turn about one line, so that only their sum or difference counts."""
        sequence, rotation = NOTATIONS[self.notation].sequence, self.frame.rotation
        return euler.is_locked(sequence, rotation) if sequence else np.zeros(rotation.shape[:-2], dtype=bool)

    @property
    def note(self) -> str:
        """A sentence on what was chosen at the lock; empty away from it."""
        if not np.any(self.locked):
            return ""
        about = NOTATIONS[self.notation]
        first, _, third = about.words
        zero, other = (first, third) if about.lock == "first" else (third, first)
        return f"{first} and {third} turn about one line: written with {zero} 0, all in {other} ({about.rule})"

    def _vectors(self) -> tuple[np.ndarray, np.ndarray]:
        first, second = ("B", "N") if self.notation == "PLANE VECTOR" else ("Q1", "Q2")
        base = unit(self.values[..., :3], f"{self.notation}, {first}")
        normal = unit(self.values[..., 3:], f"{self.notation}, {second}")
        worst = max(np.ravel((base * normal).sum(axis=-1)), key=abs)
        if not self.keep and abs(worst) > PERPENDICULAR:
            found = f"{np.degrees(np.arccos(worst)):.4f} degrees between them; keep='N' or keep='B' keeps one"
            raise InputError(self.notation, f"{first} perpendicular to {second}", found)
        return base, normal
