"""Runs of records of CL data that a control may have words for: an arc, a hole."""

from dataclasses import dataclass, replace

from mathpost.path.arcs import Cycle
from mathpost.path.modal import Command


@dataclass(frozen=True)
class Arc:
    """An arc or a helix from record `first` to record `last`, whose chords turn by equal angles."""

    first: int
    last: int
    centre: tuple[float, float, float]  # a point of its axis, mm
    axis: tuple[float, float, float]  # a unit vector, about which the tool turns right-handed


@dataclass(frozen=True)
class Hole:
    """A hole of a drilling cycle: record `first` is above it, `last` where the tool leaves it."""

    first: int
    last: int
    cycle: Cycle
    said: tuple[Command, ...] = ()  # commands to the control on the way, as part of the cycle


def moved(piece: Arc | Hole, by: int) -> Arc | Hole:
    """Return a piece with `by` more records before it."""
    return replace(piece, first=piece.first + by, last=piece.last + by)
