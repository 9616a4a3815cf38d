"""The positioning error of one joint from a laser or an autocollimator: runs after ISO 230-2, and their means."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
import scipy

from mathpost.shop.measure import spline

if TYPE_CHECKING:
    from mathpost.machine import Machine
    from mathpost.shop.measure.csv_table import Table
    from mathpost.shop.measure.spline import Curve

LARGEST = 5  # mm: of a deviation
SMALLEST = 0.05  # arcsec or µm: deviations that are all smaller were given in another unit
ROUNDING = 1e-9  # mm or radians: no reading scatters less
FEWEST = 4  # targets at which runs are compared
# One run is not like the others if it differs from them by so many times what they differ at a target, and beyond
# chance. Of 3,000 right simulated files of 3 to 10 runs, 4 to 37 targets and readings rounded to 0.1 or 0.5, one in
# 2,500 is doubted; of runs with the other sign 92 % are named where the error is 5 times the noise, 99 % at 15
# times. (4 times alone: one in 125, and every third file of 3 runs and 4 targets that is rounded; 96 and 100 %.)
ODD = 3
CHANCE = 0.002
CLOSED = 4  # standard deviations by which a turn may fail to close


@dataclass(frozen=True)
class Positioning:
    """The positioning error of one joint."""

    where: str
    joint: int  # its index
    at: np.ndarray  # degrees, or mm of `Machine.slide_positions`, shape (targets,)
    value: np.ndarray  # mean error there, radians or mm
    sigma: np.ndarray  # its standard deviation
    freedom: float  # degrees of freedom of the deviations
    endless: bool
    reversal: float  # B of ISO 230-2, the largest difference of both directions
    closure: float = 0.0  # by which it had changed when the axis came round to the same place; 0: not read
    scatter: float = np.nan  # standard deviation of one reading
    notes: tuple[str, ...] = ()  # sentences on the file
    doubts: tuple[str, ...] = ()  # and on what is wrong with it

    @property
    def unit(self) -> tuple[float, str]:
        """The factor from radians or mm to the unit in which the error is shown, and the unit."""
        return unit_of(self.joint)

    def curve(self, values: np.ndarray) -> Curve:
        """The spline through `values`, shape (targets, ...), as `mathpost.shop.measure.spline.Curve`."""
        return spline.through_all(spline.Points(self.at, values, 360.0 if self.endless else None))

    @cached_property
    def weights(self) -> Curve:
        """What each entry counts for at a position: a spline, too, as a spline is linear in its entries."""
        return self.curve(np.eye(len(self.at)))


def unit_of(joint: int) -> tuple[float, str]:
    """Return the factor from radians or mm to the unit in which the error of a joint is shown, and the unit."""
    return (np.degrees(3600), "arcsec") if joint > 2 else (1e3, "µm")


def positioning(table: Table, machine: Machine) -> Positioning:
    """Bring runs of one axis to `Positioning`: the mean of both directions at each target."""
    axis = table.choice("axis", {name: n for n, name in enumerate(machine.joint_names)})
    name, rotary = machine.joint_names[axis], axis > 2
    place = next((each for each in ("position", "angle", name) if each in table), None)
    if place is None:
        table.refuse(f"a column position, angle or {name}")
    kind, most, scale = ("angle", np.deg2rad(1), np.deg2rad(1)) if rotary else ("length", LARGEST, 1.0)
    at = _targets(table, machine, axis, place)
    columns = [c for c in table if c in ("forth", "back", "reading") or c[:2] == "up" or c[:4] == "down"]
    if not columns:
        table.refuse("columns up1, down1, … or forth, back or reading")
    values = np.column_stack([table.unit(each, kind) * table[each] for each in columns])
    for each, deviations in zip(columns, values.T, strict=True):
        same = np.ptp(at) > 2 and np.ptp(deviations) > np.ptp(at) * scale / 2
        table.require(each, ~np.full(len(table.lines), same), "deviations, actual minus target, no positions")
        table.require(each, np.abs(deviations) <= most, "a deviation below 1° or 5 mm (other units?)")
    backwards = [each == "back" or each.startswith("down") for each in columns]
    sides = np.tile(np.where(backwards, -1.0, 1.0), (len(at), 1))
    if "reading" in columns and np.ptp(at):  # rows as they were taken: the direction is that in which the axis came
        sides[:] = np.sign(np.diff(at, prepend=2 * at[0] - at[1]))[:, None]
    endless = bool(rotary and np.isinf(machine.rotary[axis - 3].limits[0]) and np.ptp(at) > 270)
    runs: dict[float, dict[float, list[float]]] = {}  # by target and side
    turns: dict[float, dict[float, list[float]]] = {}  # by target and position
    for position, row, came in zip(at, values, sides, strict=True):
        target = float(np.round(position % 360 if endless else position, 6))
        for value, side in zip(row, came, strict=True):
            if side:
                runs.setdefault(target, {}).setdefault(side, []).append(value)
                turns.setdefault(target, {}).setdefault(float(position), []).append(value)
    if len(runs) < 2 + endless:
        table.refuse(f"at least {2 + endless} targets", f"{len(runs)}")
    groups = [[np.array(each) for each in runs[target].values()] for target in sorted(runs)]
    every = [each for group in groups for each in group]
    sigma, freedom = scatter(table, every, table.unit(columns[0], kind), "two runs")
    means = np.array([np.mean([each.mean() for each in group]) for group in groups])
    spread = np.array([np.sqrt(sum(1 / len(each) for each in group)) / len(group) for group in groups])
    reversal = max((abs(group[0].mean() - group[1].mean()) for group in groups if len(group) == 2), default=0.0)
    closure, doubts = _closure(turns, sigma, axis, name)
    doubts = (*doubts, *_odd_run(table.path, columns, backwards, values))
    if len(values) >= FEWEST:
        doubts = (*doubts, *(f"{table.path}: {each}" for each in _confused(columns, np.array(backwards), values)))
    size, unit = unit_of(axis)
    if 0 < (most := size * np.abs(values).max()) < SMALLEST:
        doubts = (*doubts, f"{table.path}: no deviation is greater than {most:.4f} {unit}: is the unit right?")
    return Positioning(
        table.header, axis, np.array(sorted(runs)), means, sigma * spread, freedom, endless, float(reversal),
        closure, float(sigma), table.notes, doubts,
    )  # fmt: skip


def _odd_run(path: str, columns: Sequence[str], backwards: Sequence[bool], values: np.ndarray) -> tuple[str, ...]:
    """The doubt about a run without which the others agree far better: a sign, another target, a bump.

    All of a run may be shifted, for an axis drifts from run to run. A run that is alone in its direction is not
    judged.
    """
    peers = [n for n, side in enumerate(backwards) if list(backwards).count(side) > 1]
    if len(columns) < 3 or len(values) < FEWEST or not peers:
        return ()
    shape, targets, spare = values - values.mean(axis=0), len(values) - 1, len(columns) - 2
    rounded = _step(values) / np.sqrt(12)  # what scatters less was rounded
    noise = {n: float(np.sqrt(np.delete(shape, n, axis=1).var(axis=1, ddof=1).mean())) for n in peers}
    odd = min(peers, key=lambda n: noise[n])
    least, others = max(noise[odd], rounded, ROUNDING), np.delete(shape, odd, axis=1).mean(axis=1)
    times = np.sqrt(np.mean((shape[:, odd] - others) ** 2)) / least
    chance = scipy.special.fdtrc(targets, targets * spare, times**2 / (1 + 1 / (spare + 1))) * len(peers)
    if times < ODD or chance > CHANCE:
        return ()
    turned = np.sqrt(np.mean((shape[:, odd] + others) ** 2)) < 2 * least
    said = ": with the other sign it would agree" if turned else ""
    return (f"{path}, column {columns[odd]!r}: this run alone differs from the others{said}",)


def _confused(columns: Sequence[str], backwards: np.ndarray, values: np.ndarray) -> Iterator[str]:
    """Doubts about runs that have another sign than most, that were copied, or whose rows are in another order."""
    shape = values - values.mean(axis=0)
    _, sizes, loads = np.linalg.svd(shape, full_matrices=False)
    most = np.sign(loads[0].sum())
    other = [name for name, load in zip(columns, loads[0], strict=True) if load * most < 0]
    alike = np.abs(loads[0]).min() > 0.5 / np.sqrt(len(columns)) and sizes[0] > ODD * np.linalg.norm(sizes[1:])
    if len(other) > 1 and alike:
        yield f"columns {', '.join(other)} agree with the others only if they have the other sign"

    _, first = np.unique(values, axis=1, return_index=True)
    again = [name for n, name in enumerate(columns) if n not in first]
    scatter = np.sqrt(shape[:, first].var(axis=1, ddof=1).mean()) if len(first) > 1 else 0.0
    if again and scatter > 2 * _step(values):  # what is rounded may well be the same
        yield f"columns {', '.join(again)} repeat others to the last digit: copied readings make U too small"

    if backwards.any() and not backwards.all():
        forth, back = shape[:, ~backwards].mean(axis=1), shape[:, backwards].mean(axis=1)
        square = ((back - forth) ** 2).sum() / max(((back[::-1] - forth) ** 2).sum(), ROUNDING**2)
        if square > ODD**2 and scipy.special.fdtrc(len(forth) - 1, len(forth) - 1, square) < CHANCE:
            names = ", ".join(name for name, side in zip(columns, backwards, strict=True) if side)
            yield f"columns {names} agree with those forth from the last row to the first: list them by position"


def _step(values: np.ndarray) -> float:
    """The smallest difference between readings, to which they may be rounded; 0 if there is none."""
    steps = np.diff(np.unique(np.round(values, 12)))
    return float(steps.min()) if len(steps) else 0.0


def _targets(table: Table, machine: Machine, axis: int, place: str) -> np.ndarray:
    """The targets in degrees, or in mm of `Machine.slide_positions`; those outside the travel are refused."""
    at, name = table[place], machine.joint_names[axis]
    low, high = machine.every_joint[axis].limits
    if axis > 2:
        table.check_angles(place)
        low, high = np.degrees((low, high))
        expected = f"degrees within the travel of {name}, {low:g} … {high:g}, as the control shows them"
    else:
        (start,) = table.numbers("start", 1) if "start" in table.settings else [0.0]
        at = at + start
        low, high = machine.limits[axis] + machine.slide_positions(np.zeros(3))[axis]
        expected = (
            f"machine coordinates within the travel of {name}, {low:g} … {high:g}, as shown while no tool length "
            "is active (if the laser was set to 0 elsewhere: a line # start = that coordinate of position 0)"
        )
    table.require(place, (at >= low - 1e-6) & (at <= high + 1e-6), expected)
    return at


def _closure(
    turns: dict[float, dict[float, list[float]]], sigma: float, joint: int, name: str
) -> tuple[float, tuple[str, ...]]:
    """By how much an error had changed when the axis came round, and the doubt that this raises."""
    size, unit = unit_of(joint)
    around = [[np.mean(each) for _, each in sorted(found.items())] for found in turns.values() if len(found) > 1]
    closure = max((each[-1] - each[0] for each in around), key=abs, default=0.0)
    readings = min((len(each) for found in turns.values() if len(found) > 1 for each in found.values()), default=1)
    if abs(closure) <= CLOSED * sigma * np.sqrt(2 / readings):
        return float(closure), ()
    said = f"{name} does not close: after a turn the same place reads {size * closure:.2f} {unit} more"
    return float(closure), (f"{said} (readings scatter by {size * sigma:.2f}): warm it up, and measure again",)


def scatter(
    table: Table, groups: Collection[Sequence[float] | np.ndarray], size: float, repeated: str
) -> tuple[float, float]:
    """The standard deviation of a reading and its degrees of freedom: stated in units of `size`, or of repeats."""
    stated = stated_sigma(table, size)
    if not np.isnan(stated):
        return stated, np.inf
    freedom = sum(len(each) - 1 for each in groups)
    if not freedom:
        table.refuse(f"{repeated}, or a line # sigma = standard deviation of a reading", "neither")
    return max(np.sqrt(sum(np.var(each) * len(each) for each in groups) / freedom), ROUNDING), freedom


def stated_sigma(table: Table, size: float) -> float:
    """The stated standard deviation of a reading, in units of `size`; NaN if the file does not say it."""
    (sigma,) = table.numbers("sigma", 1) if "sigma" in table.settings else [np.nan]
    if sigma <= 0:
        table.refuse("a line # sigma = a number above 0", f"{sigma:g}")
    return sigma * size
