"""Ways through a singular region, each with the same figures, so that they can be compared."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from mathpost.errors import MathpostError, ReachError
from mathpost.path.deviation import strays
from mathpost.path.motion import Motion
from mathpost.path.region import Region
from mathpost.path.singular import CLEARANCE, LEAN
from mathpost.shop.post.time_law import TimeLaw, block_times, time_law

NEAR = 50  # records on both sides of a region that its ways are run with


@dataclass(frozen=True)
class Way(Motion):
    """One way through a region, from its first record to its last; without poses if it is not possible."""

    name: str
    law: TimeLaw | None = None  # from rest `NEAR` records before the region to rest as many after it
    peak_speed: float = np.nan  # of the workpiece-side rotary axis meanwhile, radians per s,
    peak_acceleration: float = np.nan  # and s²; NaN without a limit
    tip_error: float = np.nan  # largest distance of the moves in cut from the CL data, mm,
    axis_error: float = np.nan  # and angle, radians: what the way needs
    reason: str = ""  # why the way is not possible

    @property
    def time(self) -> float:
        """Seconds that `law` takes."""
        return self.law.seconds[-1] if self.law else np.nan

    @property
    def blocks(self) -> int:
        """Number of moves."""
        return max(len(self.joints) - 1, 0)


class Crossing(Region):
    """A singular region of a path, and the ways through it with what each costs."""

    def compare(self, **options: Any) -> list[Way]:
        """Return all ways as a list of `Way`; one that is not possible says why."""
        return [self.way(name, **options) for name in self.WAYS]

    def possible(self, name: str, **options: Any) -> Way:
        """Return one way, or raise `ReachError` if it is not possible or leaves the great circle too far."""
        way = self.way(name, **options)
        reason = way.reason
        if way.axis_error > self.axis_tolerance:
            needed = np.degrees(way.axis_error) + 0.001
            reason = f"it needs an axis tolerance of {needed:.3f}°, more than was granted"
        if reason:
            first, last = self.cl.first + self.first + 1, self.cl.first + self.last + 1
            raise ReachError(f"{self.cl.name}: no way {name!r} from record {first} to {last}: {reason}")
        return way

    def way(self, name: str, *, lean: float = LEAN, clearance: float = CLEARANCE, points: int = 5) -> Way:
        """Return one way through as a `Way`; see `Region.motion`."""
        self.refuse(name, lean, clearance)
        try:
            motion = self.motion(name, lean=lean, clearance=clearance, points=points)
        except MathpostError as error:
            nowhere = Motion.on_part(np.empty((0, len(self.kin.symbols))), [])
            return Way(**vars(nowhere), name=name, reason=str(error))
        law = self._law(motion)
        peak_speed, peak_acceleration = law.peaks[:, self.kin.workpiece_side]
        tip, axis = strays(self.kin, self.cl, motion)
        return Way(
            **vars(motion),
            name=name,
            law=law,
            peak_speed=peak_speed,
            peak_acceleration=peak_acceleration,
            tip_error=tip[motion.in_cut].max(initial=0),
            axis_error=axis[motion.at_feed(self.cl)].max(initial=0),
        )

    def _law(self, motion: Motion) -> TimeLaw:
        """The time law of a motion with the records about it."""
        near = np.arange(max(self.first - NEAR, 0), min(self.last + 1 + NEAR, len(self.joints)))
        run, machine = Motion.on_part(self.joints[near], near), self.kin.machine
        run = Motion.joined([run[near < self.first], motion, run[near > self.last]])
        tips, feeds = self.kin.forward(run.joints)[0], self.cl.feeds[run.record[1:]]
        return time_law(machine, run.joints, block_times(machine, run.joints, tips, feeds, run.in_cut))


def comparison(region: tuple[int, int], ways: Sequence[Way]) -> Iterator[str]:
    """Yield the lines of a table that compares the ways through a singular region."""
    yield f"singular region, records {region[0] + 1} to {region[1] + 1}"
    yield f"{'way':<14}{'time s':>8}{'peak °/s':>10}{'°/s²':>7}{'tip mm':>10}{'axis °':>9}{'blocks':>8}"
    for way in ways:
        speed, acceleration, axis = np.degrees([way.peak_speed, way.peak_acceleration, way.axis_error])
        figures = f"{way.time:8.2f}{speed:10.1f}{acceleration:7.0f}{way.tip_error:10.4f}{axis:9.4f}{way.blocks:8d}"
        yield f"{way.name:<14}" + (way.reason or figures)
