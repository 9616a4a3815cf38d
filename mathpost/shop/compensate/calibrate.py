"""One calibration: all readings of a machine, one least-squares estimate, its uncertainty, and whether it fits.

What is sought: where the rotary axes are and how they lean, named as in ISO 230-7 (EX0C, EA0C, …), how the spindle
leans on a head (EA0S, EB0S), the squareness of the slides (EC0Y, EB0Z, EA0Z), and the positioning error of each
axis that a laser has seen. A calibrated machine is a machine file with other points and axes: those that are
displayed with the slides in the middle of the readings, where squareness counts as nothing. The workpiece is
where probing finds it at rotary zero. `problem` has the estimate, `verdict` says whether the readings fit it.

The variances of the methods are estimated with the unknowns, each from its own residuals. u is a standard
uncertainty, U = k·u the expanded one for 95 %, with Student's t for k and the degrees of freedom after Welch and
Satterthwaite (GUM, annex G).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from mathpost.errors import InputError, one_line
from mathpost.rotation import unit
from mathpost.shop.compensate import further, probed, suspect, verdict
from mathpost.shop.compensate import readings as files
from mathpost.shop.compensate.agree import apart
from mathpost.shop.compensate.model import SQUARENESS, MachineErrors, constant_errors, error_names, out_of_square
from mathpost.shop.compensate.moved import displayed, moved
from mathpost.shop.compensate.positioning import Positioning
from mathpost.shop.compensate.problem import Problem, Solution
from mathpost.shop.measure import rotary_axis
from mathpost.shop.measure.fit import Value, coverage_factor

if TYPE_CHECKING:
    from mathpost.machine import Machine
    from mathpost.shop.compensate.readings import Read

SMALL = 1e-3  # of a rotary axis' direction: a component that its positioning error need not have


@dataclass(frozen=True)
class Calibration:
    """What readings say about a machine."""

    nominal: Machine  # as the control believed it to be
    values: dict[str, float]  # unknowns of the geometry: what the machine has more than `nominal`, mm or radians
    positioning: tuple[Positioning, ...]  # for each axis measured
    parts: tuple[
        tuple[np.ndarray, float], ...
    ]  # for each file: its share of the covariance of all unknowns, geometry first, and its freedom
    assumed: dict[str, str]  # unknowns that the readings do not determine: the reason
    noise: dict[str, tuple[float, float]]  # files: the standard deviation of a reading and its degrees of freedom
    bar: dict[
        str, Value
    ]  # `Value` of "length", by which the test bar is longer than the tool, and of its ball's "radius"
    about: np.ndarray  # positions of the slides, mm, shape (3,), at which squareness counts as nothing
    doubts: tuple[str, ...] = ()  # sentences: why the readings do not fit
    notes: tuple[str, ...] = ()  # sentences: what else was seen
    unchecked: bool = False  # whether there are no more readings than unknowns
    residuals: tuple[verdict.Residual, ...] = ()  # what is left of each reading
    methods: tuple[str, ...] = ()  # of the files, each once

    @property
    def fits(self) -> bool:
        """Whether nothing speaks against the estimate."""
        return not self.doubts

    def __getitem__(self, name: str) -> Value:
        """Return the `Value` of one unknown."""
        index = list(self.values).index(name)
        return self.value(self.values[name], np.eye(len(self.values))[index])

    def of(self, function: Callable[[Machine], list[float]]) -> list[Value]:
        """Return numbers of the machine as its control displays it, each as `Value`, by a function to a list."""

        def at(name: str, step: float) -> np.ndarray:
            return np.array(function(displayed(self.nominal, self.values | {name: self.values[name] + step})))

        numbers = np.asarray(function(displayed(self.nominal, self.values)), dtype=float)
        slopes = np.zeros((len(self.values), len(numbers)))
        for row, name in enumerate(self.values):
            slopes[row] = (at(name, 1e-6) - at(name, -1e-6)) / 2e-6
        return [self.value(number, slope) for number, slope in zip(numbers.tolist(), slopes.T, strict=True)]

    @cached_property
    def machine(self) -> Machine:
        """The calibrated `Machine`: axes, points and tool where the readings have found them."""
        return moved(self.nominal, self.values)

    @cached_property
    def errors(self) -> MachineErrors:
        """What a machine file cannot say, as `MachineErrors` of `machine`: squareness and positioning."""
        names, curves, constant = error_names(self.machine), [], {}
        for name in (n for n in SQUARENESS if n in self.values and n not in self.assumed):
            constant[name] = self.values[name]  # which counts from 0: a displacement moves that to `about`
            slide, aside = out_of_square(name)
            back = -self.values[name] * self.about[slide] * _sense(self.machine, slide) * aside
            constant |= {f"E{'XYZ'[n]}{name[3]}": float(back[n]) for n in np.flatnonzero(aside)}
        for each in self.positioning:
            found = columns(self.machine, each).items()
            curves += [(names.index(name), each.curve(column)) for name, column in found]
        return replace(constant_errors(self.machine, constant), curves=tuple(curves))

    def value(self, value: float, gradient: np.ndarray) -> Value:
        """Return a number with its U as `Value`, given its derivatives by `values`, then by all table entries."""
        gradient = np.pad(gradient, (0, len(self.parts[0][0]) - len(gradient)))
        shares = np.array([gradient @ part @ gradient for part, _ in self.parts])
        variance, freedoms = shares.sum(), np.array([freedom for _, freedom in self.parts])
        spread = (shares**2 / freedoms).sum()
        return Value(value, float(np.sqrt(variance)), float(variance**2 / spread) if spread > 0 else np.inf)

    def __str__(self) -> str:
        lines = (
            ["The readings fit."] if self.fits else ["THE READINGS DO NOT FIT:", *(f"  {d}" for d in self.doubts)]
        )
        if self.fits and self.unchecked:
            lines = [
                "NOTHING CHECKS THE READINGS: none is to spare, U rests on the stated noise. Read one more angle."
            ]
        if self.methods == ("centre",):
            lines += self._centres(where_measured=True)
        lines.append(f"{'':6s} {'value':>10s} {'U 95 %':>9s}        k  freedom")
        for name in self.values:
            each, (size, unit) = self[name], ((1e3, "µm  ") if name[1] in "XYZ12" else (1e6, "µrad"))
            found = f"{size * each.value:z10.2f} {size * each.U:9.2f} {unit} {each.k:5.2f}"
            lines.append(f"{name:6s} {found} {each.free:>8s}")
        for axis in self.positioning:
            size, unit = (np.degrees(3600), "arcsec") if axis.joint > 2 else (1e3, "µm")
            most = size * coverage_factor(axis.freedom) * axis.sigma.max()
            found = f"range {size * np.ptp(axis.value):.2f} {unit}, U {most:.2f} at a target"
            closed = f"; closes to {size * axis.closure:.2f} {unit}" if axis.closure else ""
            name = self.machine.joint_names[axis.joint]
            lines.append(f"{name} positioning: {found}; reversal {size * axis.reversal:.2f} {unit}{closed}")
        lines += self._centres()
        for name, each in self.bar.items():
            longer = "longer than believed by" if name == "length" else "radius"
            lines.append(f"test bar: {longer} {each.value:.4f} mm, U {each.U:.4f}")
        for reason in dict.fromkeys(self.assumed.values()):
            names = [name for name, each in self.assumed.items() if each == reason]
            lines.append(f"{', '.join(names)}: {reason}")
        for name, (sigma, freedom) in self.noise.items():
            stated = "as stated" if np.isinf(freedom) else f"from {freedom:.0f} spare ones"
            lines.append(f"noise of a reading in {one_line(name)}: {1e3 * sigma:.2f} µm, {stated}")
        return "\n".join([*lines, *self.notes])

    @property
    def on_trust(self) -> str:
        """A paragraph: what no residual can show, and how to try it; from where places count."""
        lines = ["Taken on trust, for no residual shows it, and how to try it:"]
        lines += [f"  {line}" for method in self.methods for line in files.METHODS[method]["trust"]]
        if self.values:
            at = " ".join(f"{axis}{place:z.3f}" for axis, place in zip("XYZ", self.about.tolist(), strict=True))
            lines.append(
                f"  that places count from the mean of the readings, slides at {at} (no tool length active):"
            )
            lines.append("  elsewhere slides that are out of square show them in other places; probe one there")
            lines.append("  a drift too small to show: repeat the first pose at the end")
        return "\n".join(lines)

    def _centres(self, *, where_measured: bool = False) -> list[str]:
        """Lines that say where each measured table axis is in machine coordinates.

        In the middle of the readings, or where the machine file has the axis' point: there the tilt of the axis
        counts, too, and what is assumed of it.
        """
        lines = []
        middle = self.about - self.nominal.tool_length * unit(self.nominal.length_axis or self.nominal.tool_axis)
        for index, each in enumerate(self.nominal.rotary):
            names, plane = rotary_axis.location_errors(each)
            letters = ["XYZ"[row] for row in np.flatnonzero(np.abs(plane).max(axis=1) > SMALL)]
            if each.carries == "tool" or not set(names[:2]) <= set(self.values) or len(letters) > 2:
                continue
            at = middle if where_measured else np.array(each.point)
            places = self.of(partial(_point_of, index, at))
            found = [f"{x} {places['XYZ'.index(x)].value:.4f} ± {places['XYZ'.index(x)].U:.4f}" for x in letters]
            tool = f" of the tip of a tool of {self.nominal.tool_length:g} mm" if "EA0S" in self.values else ""
            row = int(np.abs(each.axis).argmax())
            height, read = f"{'XYZ'[row]} {at[row]:z.3f}", {left.column for left in self.residuals}
            place = f" at {height}, the machine file's point, with what is said of its tilt;"
            if where_measured:
                place = " where it was measured" + f", at {height}" * ("xyz"[row] in read) + ";"
            place *= self.methods == ("centre",)
            lines.append(f"centre of {each.name}: {', '.join(found)} mm,{place} machine coordinates{tool}")
        return lines


def _point_of(index: int, at: np.ndarray, machine: Machine) -> list[float]:
    """The point of an axis in the height of `at`, along the greatest component of its direction."""
    point, axis = np.array(machine.rotary[index].point), np.array(machine.rotary[index].axis)
    row = np.abs(axis).argmax()
    return (point + axis * (at - point)[row] / axis[row]).tolist()


def calibrate(machine: Machine, paths: Sequence[Path | str], **settings: Any) -> Calibration:
    """Return the `Calibration` of `machine`, as the control believed it to be, from files of readings.

    `paths` are files, see `mathpost.shop.compensate.readings.template`; `settings` (``unit``, ``method``, ``axis``,
    ``positive``, …) are for files that do not state them. `InputError` if a file leaves something unclear, there is
    nothing to estimate the noise from, or what comes out is no machine. Whether the readings fit is in `doubts`.

    Examples
    --------
    >>> from mathpost import load_machine
    >>> found = calibrate(load_machine("data/machines/ac_table.toml"), ["data/measurements/ball_c_axis.csv"])
    >>> f"{1e3 * found['EX0C'].value:.1f} ± {1e3 * found['EX0C'].U:.1f} µm", found.fits
    ('10.3 ± 0.5 µm', True)
    """
    read = [files.read(each, machine, **settings) for each in paths]
    try:
        found = estimate(machine, read)
    except InputError as error:
        causes = suspect.causes(machine, paths, read, settings, None, estimate)
        said = [str(error.found), *probed.unexplained(machine, read), *causes]
        raise InputError(error.where, error.expected, "; ".join(said)) from None
    causes = suspect.causes(machine, paths, read, settings, found, estimate)
    return replace(found, doubts=(*found.doubts, *causes))


def estimate(machine: Machine, read: Sequence[Read]) -> Calibration:
    """Return the `Calibration` from what `mathpost.shop.compensate.readings.read` returned."""
    seen = [each for each in read if isinstance(each, Positioning)]
    if len({each.joint for each in seen}) < len(seen):
        raise InputError(seen[-1].where, "one file of positioning for each axis", "a second one")
    blocks = [each for each in read if isinstance(each, files.Readings)]
    bars = [each for each in read if isinstance(each, dict)]
    if len(bars) > 1 or not (blocks or seen):
        others = f"{len(bars)} of a bar, {len(blocks) + len(seen)} others"
        raise InputError("readings", "readings of an axis, and at most one test bar beside them", others)
    problem = Problem(machine, blocks, seen)
    solution = problem.solve()
    found = _calibration(problem, solution, bars[0] if bars else {})
    methods = [*(each.method for each in blocks), *["laser"] * bool(seen), *["bar"] * bool(bars)]
    left = tuple(verdict.residuals(problem, solution))
    found = replace(found, residuals=left, methods=tuple(dict.fromkeys(methods)))
    found = replace(found, unchecked=bool(blocks) and float(solution.spare.sum()) < verdict.SPARE)
    if not seen and set(found.values) <= set(found.assumed):
        raise InputError(", ".join(found.noise), "readings at several angles of an axis", "none that tells of one")
    verdict.refuse_absurd(found)
    doubts, notes = verdict.judge(problem, solution)
    doubts = (*files.copied(blocks), *doubts, *apart(problem, solution))
    notes = (*notes, *verdict.left_out(problem, solution, found))
    far, unmoved = verdict.far_off(found), probed.unmoved(problem.machine, problem.blocks)
    if any(each.method not in files.PROBED for each in blocks) or (far and unmoved):
        return replace(found, doubts=(*far, *unmoved, *doubts), notes=notes)
    return replace(found, doubts=doubts, notes=(*far, *unmoved, *notes))  # a probe may be meant to find an axis


def _calibration(problem: Problem, solution: Solution, bar: dict[str, Value]) -> Calibration:
    """Bring a `Solution` to a `Calibration`."""
    gain, rows = solution.covariance @ solution.rows.T, [*problem.rows]
    rows.append(slice(rows[-1].stop, len(solution.rows)))  # what was known before
    freedom = [*solution.freedom, np.inf]
    parts = [(gain[:, own] @ gain[:, own].T, free) for own, free in zip(rows, freedom, strict=True)]
    parts.append((solution.whole - solution.covariance, np.inf))  # of what nobody measured
    deviations = np.zeros(problem.count)
    deviations[solution.kept] = np.sqrt(np.diag(solution.whole))
    names = {name: n for n, name in enumerate(problem.names)}
    values = {name: float(solution.x[n]) for name, n in names.items() if n in solution.kept}
    tables = tuple(
        replace(each, value=solution.x[own], sigma=deviations[own])
        for each, own in zip(problem.tables, problem.entries, strict=True)
    )
    noise = {
        each.where: (float(solution.sigmas[own.start]), free)
        for each, own, free in zip(problem.blocks, problem.rows, freedom, strict=False)
    }
    assumed = {name: "not measured: as in the machine file" for name in names if name not in values}
    left = [name for name in values if not problem.determined(solution, name)]
    assumed |= further.reasons(problem, left, float(np.median(solution.sigmas)))
    return Calibration(problem.machine, values, tables, tuple(parts), assumed, noise, bar, problem.about)


def _sense(machine: Machine, slide: int) -> int:
    """-1 for a slide that carries the workpiece: it runs against the programmed direction."""
    return -1 if "XYZ"[slide] in machine.slides_that_carry("workpiece") else 1


def columns(machine: Machine, positioning: Positioning) -> dict[str, np.ndarray]:
    """The columns of an error table, µm or µrad, that a positioning error makes: the sign is that of the axis."""
    name, joint = machine.joint_names[positioning.joint], positioning.joint
    if joint < 3:
        return {f"E{name}{name}": 1e3 * positioning.value * _sense(machine, joint)}
    axis = unit(machine.rotary[joint - 3].axis)
    shares = [(letter, share) for letter, share in zip("ABC", axis, strict=True) if abs(share) > SMALL]
    return {f"E{letter}{name}": 1e6 * positioning.value * share for letter, share in shares}
