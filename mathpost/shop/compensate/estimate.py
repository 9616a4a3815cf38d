"""The estimate that readings make of a machine, and what is to be said of how they fit.

The variances of the methods are estimated with the unknowns, each from its own residuals: `problem`. `residuals`
says whether the readings fit.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from mathpost.errors import InputError
from mathpost.shop.compensate import further, probed, residuals
from mathpost.shop.compensate import readings as files
from mathpost.shop.compensate.agree import apart
from mathpost.shop.compensate.calibration import Calibration
from mathpost.shop.compensate.positioning import Positioning
from mathpost.shop.compensate.problem import Problem, Solution
from mathpost.shop.measure.fit import Value

if TYPE_CHECKING:
    from mathpost.machine import Machine
    from mathpost.shop.compensate.readings import Read


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
    if not seen and set(found.values) <= set(found.assumed):
        raise InputError(", ".join(found.noise), "readings at several angles of an axis", "none that tells of one")
    residuals.refuse_absurd(found)
    doubts, notes = residuals.judge(problem, solution)
    doubts = (*files.copied(blocks), *doubts, *apart(problem, solution))
    notes = (*notes, *residuals.left_out(problem, solution, found))
    far, unmoved = residuals.far_off(found), probed.unmoved(problem.machine, problem.blocks)
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
    methods = [*(each.method for each in problem.blocks), *["laser"] * bool(tables), *["bar"] * bool(bar)]
    return Calibration(
        problem.machine,
        values,
        tables,
        tuple(parts),
        assumed,
        noise,
        bar,
        problem.about,
        unchecked=bool(problem.blocks) and float(solution.spare.sum()) < residuals.SPARE,
        residuals=tuple(residuals.residuals(problem, solution)),
        methods=tuple(dict.fromkeys(methods)),
    )
