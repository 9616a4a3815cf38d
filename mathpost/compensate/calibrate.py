"""One calibration: all readings of a machine, one least-squares estimate, and what it says with its uncertainty.

What is sought: where the rotary axes are and how they lean, named as in ISO 230-7 (EX0C, EA0C, …), how the spindle
leans on a head (EA0S, EB0S), the squareness of the slides (EC0Y, EB0Z, EA0Z), and the positioning error of each
axis that a laser has seen. The chain of `mathpost.chain`, its numbers unknown, predicts all readings, so that a
calibrated machine is a machine file with other points. The workpiece is where probing finds it at rotary zero.

The variances of the methods are estimated with the unknowns, each from its own residuals. U is t·u, with Student's
t for the degrees of freedom after Welch and Satterthwaite (GUM, annex G).
"""

from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np

from mathpost.compensate import readings as files
from mathpost.compensate.model import SQUARENESS, constant_errors, error_names, named_point, table_position
from mathpost.errors import InputError
from mathpost.measure import rotary_axis
from mathpost.measure.fit import Value, coverage_factor, least_squares
from mathpost.rotation import unit

DEPENDENT = 1e-5  # of a column that others leave: below it the readings do not tell the unknown from theirs
NOTHING = 1e-9  # length of a column without a trace of its unknown
SMALL = 1e-3  # of a rotary axis' direction: a component that its positioning error need not have


@dataclass(frozen=True)
class Calibration:
    """What readings say about a machine."""

    nominal: object  # the `Machine` as the control believed it to be
    values: dict  # unknowns of the geometry: what the machine has more than `nominal`, mm or radians
    positioning: tuple  # a `Positioning` for each axis measured
    parts: tuple  # for each file: its share of the covariance of all unknowns, geometry first, and its freedom
    assumed: dict  # unknowns that stay at zero: the reason
    noise: dict  # files: the standard deviation of a reading and its degrees of freedom
    bar: dict  # `Value` of "length", by which the test bar is longer than the tool, and of its ball's "radius"

    def __getitem__(self, name):
        """Return the `Value` of one unknown."""
        index = list(self.values).index(name)
        return self.value(self.values[name], np.eye(len(self.values))[index])

    def of(self, function):
        """Return numbers of the calibrated machine, each as `Value`: `function` takes a machine to a list."""

        def at(name, step):
            return np.array(function(corrected(self.nominal, self.values | {name: self.values[name] + step})))

        numbers = np.asarray(function(self.machine), dtype=float)
        slopes = np.zeros((len(self.values), len(numbers)))
        for row, name in enumerate(self.values):
            slopes[row] = (at(name, 1e-6) - at(name, -1e-6)) / 2e-6
        return [self.value(number, slope) for number, slope in zip(numbers.tolist(), slopes.T, strict=True)]

    @cached_property
    def machine(self):
        """The calibrated `Machine`: axes, points and tool where the readings have found them."""
        return corrected(self.nominal, self.values)

    @cached_property
    def errors(self):
        """What a machine file cannot say, as `MachineErrors` of `machine`: squareness and positioning."""
        names, square = error_names(self.machine), {n: x for n, x in self.values.items() if n in SQUARENESS}
        curves = []
        for each in self.positioning:
            found = columns(self.machine, each).items()
            curves += [(names.index(name), each.curve(column)) for name, column in found]
        return replace(constant_errors(self.machine, square), curves=tuple(curves))

    def value(self, value, gradient):
        """Return a number with its U as `Value`, given its derivatives by `values`, then by all table entries."""
        gradient = np.pad(gradient, (0, len(self.parts[0][0]) - len(gradient)))
        shares = np.array([gradient @ part @ gradient for part, _ in self.parts])
        variance, freedoms = shares.sum(), np.array([freedom for _, freedom in self.parts])
        spread = (shares**2 / freedoms).sum()
        return Value(value, float(np.sqrt(variance)), float(variance**2 / spread) if spread > 0 else np.inf)

    def __str__(self):
        lines = [f"{'':6s} {'value':>10s} {'U 95 %':>9s}        k  freedom"]
        for name in self.values:
            each, (size, unit) = self[name], ((1e3, "µm  ") if name[1] in "XYZ12" else (1e6, "µrad"))
            found = f"{size * each.value:10.2f} {size * each.U:9.2f} {unit} {each.k:5.2f}"
            lines.append(f"{name:6s} {found} {each.free:>8s}")
        for each in self.positioning:
            size, unit = (np.degrees(3600), "arcsec") if each.joint > 2 else (1e3, "µm")
            most = size * coverage_factor(each.freedom) * each.sigma.max()
            found = f"range {size * np.ptp(each.value):.2f} {unit}, U {most:.2f} at a target"
            name = self.machine.joint_names[each.joint]
            lines.append(f"{name} positioning: {found}; reversal {size * each.reversal:.2f} {unit}")
        for name, each in self.bar.items():
            longer = "longer than believed by" if name == "length" else "radius"
            lines.append(f"test bar: {longer} {each.value:.4f} mm, U {each.U:.4f}")
        for reason in dict.fromkeys(self.assumed.values()):
            names = [name for name, each in self.assumed.items() if each == reason]
            lines.append(f"{', '.join(names)}: {reason}")
        for name, (sigma, freedom) in self.noise.items():
            stated = "as stated" if np.isinf(freedom) else f"from {freedom:.0f} spare ones"
            lines.append(f"noise of a reading in {name}: {1e3 * sigma:.2f} µm, {stated}")
        return "\n".join(lines)


def calibrate(machine, paths, *, squareness=None, **settings):
    """Return the `Calibration` of `machine`, as the control believed it to be, from files of readings.

    `paths` are CSV files, see `mathpost.compensate.readings.template`; `settings` (``unit``, ``method``, ``axis``,
    ``positive``, …) are for files that do not state them. `squareness`: whether to estimate that of the slides, by
    default only if a ballbar has seen them. `InputError` if a file leaves something unclear, or there is nothing to
    estimate the noise from.

    Examples
    --------
    >>> from mathpost import machine
    >>> found = calibrate(machine.load("data/machines/ac_table.toml"), ["data/measurements/ball_c_axis.csv"])
    >>> f"{1e3 * found['EX0C'].value:.1f} ± {1e3 * found['EX0C'].U:.1f} µm"
    '10.1 ± 0.4 µm'
    """
    read = [files.read(each, machine, **settings) for each in paths]
    seen = [each for each in read if isinstance(each, files.Positioning)]
    if len({each.joint for each in seen}) < len(seen):
        raise InputError(seen[-1].where, "one file of positioning for each axis", "a second one")
    blocks = [each for each in read if isinstance(each, files.Readings)]
    bars = [each for each in read if isinstance(each, dict)]
    if len(bars) > 1 or not blocks + seen:
        found = f"{len(bars)} of a bar, {len(blocks + seen)} others"
        raise InputError("readings", "readings of an axis, and at most one test bar beside them", found)
    if squareness is None:
        squareness = any(each.method == "ballbar" for each in blocks)
    return replace(_Problem(machine, blocks, seen, squareness).solve(), bar=bars[0] if bars else {})


def unknowns(machine):
    """Return the names of the geometry's unknowns, those first that are given up last."""
    first, second = (rotary_axis.location_errors(each)[0] for each in machine.rotary)
    spindle = ["EA0S", "EB0S"] if any(each.carries == "tool" for each in machine.rotary) else []
    return [*first[:2], *second[:2], *first[2:], *second[2:], *spindle, *SQUARENESS]


def corrected(machine, values):
    """Return `machine` with its axes, points and tool moved by `values`; squareness is not in a machine file.

    Machine coordinates are those at which the tip of the machine's tool is displayed at rotary zero: if the spindle
    leans, so does the tool, and a table is displayed beside where it is.
    """
    moved = _moved(machine, values)
    aside = machine.tool_length * (np.array(moved.tool_axis) - unit(machine.tool_axis))
    tables = [
        replace(each, point=tuple((each.point + aside).tolist())) if each.carries == "workpiece" else each
        for each in moved.rotary
    ]
    named = machine.programmed_point
    if named != "tip" and aside.any():
        named = tuple(named_point(machine, 0.0) - aside)
    return replace(moved, rotary=tuple(tables), programmed_point=named)


def _moved(machine, values):
    """The axes, points and tool of `machine` moved by `values`, in the coordinates of its slides."""
    names = unknowns(machine)
    for name in set(values) - set(names):
        raise InputError("values", f"unknowns among {', '.join(names)}", repr(name))
    values = dict.fromkeys(names, 0.0) | values
    tool = unit(machine.tool_axis)
    tool = unit(tool + np.cross([values.get("EA0S", 0.0), values.get("EB0S", 0.0), 0.0], tool))
    rotary = tuple(rotary_axis.corrected(each, values) for each in machine.rotary)
    return replace(machine, rotary=rotary, tool_axis=tuple(tool.tolist()))


def columns(machine, positioning):
    """The columns of an error table, µm or µrad, that a positioning error makes: the sign is that of the axis."""
    name, joint = machine.joint_names[positioning.joint], positioning.joint
    if joint < 3:
        against = name in machine.slides_that_carry("workpiece")  # it runs against the programmed direction
        return {f"E{name}{name}": 1e3 * positioning.value * (-1 if against else 1)}
    axis = unit(machine.rotary[joint - 3].axis)
    shares = [(letter, share) for letter, share in zip("ABC", axis, strict=True) if abs(share) > SMALL]
    return {f"E{letter}{name}": 1e6 * positioning.value * share for letter, share in shares}


class _Problem:
    """All readings as one function of all unknowns: geometry, tables' entries, each ball's place and zero."""

    def __init__(self, machine, blocks, tables, squareness):
        self.machine, self.blocks, self.tables, self.squareness = machine, blocks, tables, squareness
        self.names, self.sources = unknowns(machine), [*blocks, *tables]
        self.rows = _slices(len(each.value) for each in self.sources)
        places = [4 * (int(each.setup.max()) + 1) for each in blocks]
        self.geometry, *columns = _slices([len(self.names), *(len(each.at) for each in tables), *places])
        self.entries, self.places = columns[: len(tables)], columns[len(tables) :]
        self.count = [self.geometry, *columns][-1].stop
        self.kept = list(range(self.count))
        self.observed = np.concatenate([each.value for each in self.sources])
        # A spline is linear in its entries: what each of them counts for at a position is a spline, too.
        self.weights = [each.curve(np.eye(len(each.at))) for each in tables]
        self.moves = np.zeros((18, len(self.names)))  # of the machine's axes, points and tool
        for column, name in enumerate(self.names):
            high, low = (files.geometry(_moved(machine, {name: step})) for step in (1e-5, -1e-5))
            self.moves[:, column] = (high - low) / 2e-5

    def solve(self):
        """Estimate unknowns and noise in turn until neither changes."""
        reasons = self._keep_apart()
        x, where, freedom = np.zeros(len(self.kept)), self.sources[0].where, [each.freedom for each in self.sources]
        sigmas = [np.broadcast_to(np.nan_to_num(each.sigma, nan=1e-3), len(each.value)) for each in self.sources]
        sigmas = np.concatenate(sigmas)
        for _ in range(100):
            x, covariance, residuals, rows = least_squares(self._evaluate, self.observed, sigmas, x, where)
            spare = 1 - np.einsum("ij,jk,ik->i", rows, covariance, rows)
            before = sigmas.copy()
            for number, (block, own) in enumerate(zip(self.blocks, self.rows, strict=False)):
                if np.isnan(block.sigma):
                    freedom[number] = spare[own].sum()
                    if freedom[number] < 0.5:
                        expected = "more readings than unknowns, or a line # sigma = deviation of a reading"
                        raise InputError(block.where, expected, f"{len(block.value)} readings, none to spare")
                    sigmas[own] = max(np.sqrt((residuals[own] ** 2).sum() / freedom[number]), files.ROUNDING)
            if np.allclose(before, sigmas, rtol=1e-3):
                break
        gain = covariance @ rows.T
        parts = [(gain[:, own] @ gain[:, own].T, free) for own, free in zip(self.rows, freedom, strict=True)]
        full, deviations = np.zeros(self.count), np.zeros(self.count)
        full[self.kept], deviations[self.kept] = x, np.sqrt(np.diag(covariance))
        values = {name: float(full[n]) for n, name in enumerate(self.names) if name not in reasons}
        tables = tuple(
            replace(each, value=full[own], sigma=deviations[own])
            for each, own in zip(self.tables, self.entries, strict=True)
        )
        noise = {
            each.where: (float(sigmas[own.start]), free)
            for each, own, free in zip(self.blocks, self.rows, freedom, strict=False)
        }
        return Calibration(self.machine, values, tables, tuple(parts), reasons, noise, {})

    def _keep_apart(self):
        """Keep the unknowns that the readings tell from those before them; return the reasons of the others.

        Where a ball stands and what the laser has seen come first, then the geometry in the order of `unknowns`.
        """
        matrix, geometry = self._evaluate(np.zeros(self.count))[1], len(self.names)
        kept, basis, reasons = [], np.empty((len(matrix), 0)), {}
        for index in (*range(geometry, self.count), *range(geometry)):
            column = matrix[:, index]
            length, left = np.linalg.norm(column), column - basis @ (basis.T @ column)
            left -= basis @ (basis.T @ left)
            if index < geometry and self.names[index] in SQUARENESS and not self.squareness:
                reasons[self.names[index]] = "not sought, since no ballbar saw the slides: taken for square"
            elif length > NOTHING and np.linalg.norm(left) > DEPENDENT * length:
                kept.append(index)
                basis = np.column_stack([basis, left / np.linalg.norm(left)])
            elif index < geometry:
                reasons[self.names[index]] = "not measured: as in the machine file"
                if length > NOTHING:
                    share = np.linalg.lstsq(matrix[:, kept], column, rcond=None)[0]
                    share = np.abs(share) * np.linalg.norm(matrix[:, kept], axis=0) > SMALL * length
                    among = [self.names[n] for n, each in zip(kept, share, strict=True) if each and n < geometry]
                    others = " and ".join(among) or "where the ball stands"
                    reasons[self.names[index]] = f"not told from {others} by these readings: as in the machine file"
        self.kept = sorted(kept)
        return reasons

    def _evaluate(self, x):
        """The predicted readings and their derivatives by the unknowns that are kept."""
        full, eye = np.zeros(self.count), np.eye(self.count)
        full[self.kept] = x
        parts = [self._gaps(each, place.start, full) for each, place in zip(self.blocks, self.places, strict=True)]
        parts += [(full[own], eye[own]) for own in self.entries]
        predicted, derivatives = map(np.concatenate, zip(*parts, strict=True))
        return predicted, derivatives[:, self.kept]

    def _gaps(self, block, place, x):
        """What is read in a file whose balls' places begin at x[place]; its derivatives by all unknowns."""
        gaps, derivatives = self._along(block, block.joints, place, x)
        if block.reference is not None:
            there, slopes = self._along(block, block.reference, place, x)
            gaps, derivatives = gaps - there, derivatives - slopes
        if block.zeroed:
            zero = place + 4 * block.setup + 3
            gaps = gaps + x[zero]
            derivatives[np.arange(len(zero)), zero] = 1
        return gaps, derivatives

    def _along(self, block, joints, place, x):
        """How far the ball stands from the tip along each reading's direction; its derivatives by all unknowns."""
        values = dict(zip(self.names, x[self.geometry], strict=True))
        slides, actual, paths = joints[:, :3] + self.machine.origin, joints.copy(), {}
        for name in SQUARENESS:
            turned, slide = np.eye(3)["ABC".index(name[1])], "XYZ".index(name[3])
            paths[name] = np.outer(slides[:, slide], np.cross(turned, np.eye(3)[slide]))
            actual[:, :3] += values[name] * paths[name]
        shares = []
        for each, weights, own in zip(self.tables, self.weights, self.entries, strict=True):
            share = weights(table_position(self.machine, joints, each.joint), where=each.where)
            actual[:, each.joint] += share @ x[own]
            shares.append(share)
        tip, by = files.tips(self.machine, actual, block.length, _moved(self.machine, values))
        along = np.einsum("ni,nji->nj", block.direction, by[..., :3])  # the direction, in the workpiece
        slopes = -np.einsum("ni,nij->nj", along, by)
        derivatives = np.zeros((len(actual), self.count))
        derivatives[:, self.geometry] = slopes[:, 5:23] @ self.moves
        for name, path in paths.items():
            derivatives[:, self.names.index(name)] += (slopes[:, :3] * path).sum(axis=1)
        for each, share, own in zip(self.tables, shares, self.entries, strict=True):
            derivatives[:, own] = slopes[:, [each.joint]] * share
        ball = place + 4 * block.setup[:, None] + np.arange(3)
        np.put_along_axis(derivatives, ball, along, axis=1)
        return np.einsum("ni,ni->n", along, block.target + x[ball] - tip), derivatives


def _slices(sizes):
    """Slices of these sizes, one behind the other."""
    return [slice(*each) for each in pairwise(np.cumsum([0, *sizes]).tolist())]
