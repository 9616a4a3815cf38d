"""What readings say about a machine: the unknowns with their U, the machine that they make, and a report.

u is a standard uncertainty, U = k·u the expanded one for 95 %, with Student's t for k and the degrees of freedom
after Welch and Satterthwaite (GUM, annex G).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import TYPE_CHECKING

import numpy as np

from mathpost.errors import one_line
from mathpost.rotation import unit
from mathpost.shop.compensate import readings as files
from mathpost.shop.compensate.model import (
    SQUARENESS,
    MachineErrors,
    constant_errors,
    error_names,
    out_of_square,
    shown_in,
)
from mathpost.shop.compensate.moved import displayed, moved
from mathpost.shop.compensate.positioning import Positioning
from mathpost.shop.measure import rotary_axis
from mathpost.shop.measure.fit import Value, coverage_factor

if TYPE_CHECKING:
    from mathpost.machine import Machine
    from mathpost.shop.compensate.residuals import Residual

SMALL = 1e-3  # of a rotary axis' direction: a component that its positioning error need not have


@dataclass(frozen=True)
class Calibration:
    """What readings say about a machine."""

    nominal: Machine  # as the control believed it to be
    values: dict[str, float]  # unknowns of the geometry: what the machine has more than `nominal`, mm or radians
    positioning: tuple[Positioning, ...]  # for each axis measured
    # For each file: its share of the covariance of all unknowns, geometry first, and its freedom.
    parts: tuple[tuple[np.ndarray, float], ...]
    assumed: dict[str, str]  # unknowns that the readings do not determine: the reason
    noise: dict[str, tuple[float, float]]  # files: the standard deviation of a reading and its degrees of freedom
    bar: dict[str, Value]  # "length", by which the test bar is longer than the tool, and its ball's "radius"
    about: np.ndarray  # positions of the slides, mm, shape (3,), at which squareness counts as nothing
    doubts: tuple[str, ...] = ()  # sentences: why the readings do not fit
    notes: tuple[str, ...] = ()  # sentences: what else was seen
    unchecked: bool = False  # whether there are no more readings than unknowns
    residuals: tuple[Residual, ...] = ()  # what is left of each reading
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
        """Return numbers that `function` lists of the machine as its control displays it, each as `Value`."""

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
        lines = ["The readings fit."]
        if not self.fits:
            lines = ["THE READINGS DO NOT FIT:", *(f"  {doubt}" for doubt in self.doubts)]
        elif self.unchecked:
            said = "none is to spare, U rests on the stated noise. Read one more angle."
            lines = [f"NOTHING CHECKS THE READINGS: {said}"]
        if self.methods == ("centre",):
            lines += self._centres(where_measured=True)
        lines.append(f"{'':6s} {'value':>10s} {'U 95 %':>9s}        k  freedom")
        for name in self.values:
            each, (size, unit) = self[name], shown_in(name)
            found = f"{size * each.value:z10.2f} {size * each.U:9.2f} {unit:4s} {each.k:5.2f}"
            lines.append(f"{name:6s} {found} {each.free:>8s}")
        for axis in self.positioning:
            size, unit = axis.unit
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
