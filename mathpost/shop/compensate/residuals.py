"""Whether readings fit the machine estimated from them: noise, rows, patterns, sizes, each in a sentence."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import scipy

from mathpost.errors import InputError
from mathpost.shop.compensate.model import SQUARENESS, is_length
from mathpost.shop.compensate.readings import METHODS, Readings
from mathpost.shop.compensate.unmeasured import shown

if TYPE_CHECKING:
    from mathpost.shop.compensate.calibration import Calibration
    from mathpost.shop.compensate.problem import Problem, Solution
    from mathpost.shop.compensate.unmeasured import Shown

CHANCE = 0.002  # of readings that fit, below which a file is doubted for one of these reasons
SPARE = 0.5  # readings to spare below which nothing tells whether they fit
SMALLEST = 2e-5  # mm: no method scatters less
LARGEST = {True: (1.0, "mm"), False: (5e-3, "rad")}  # by `is_length`: U beyond which nothing is known of an axis
FAR = {True: (5.0, "mm"), False: (2e-2, "rad")}  # and how far no machine's axis is off
CHECKED = 0.05  # of a reading that the estimate leaves free: with less, no other reading checks it
BEYOND = 3  # standard uncertainties beyond which what nobody measured is no longer what was assumed
DRAWS, SEED = 1000, 1
MANY = 2000  # readings of a file beyond which patterns are not sought


def refuse_absurd(found: Calibration) -> None:
    """Raise `InputError` for a `Calibration` that leaves an axis open by more than any machine is wrong."""
    for name in found.values:
        expanded, (most, unit) = found[name].U, LARGEST[is_length(name)]
        if expanded > most:
            said = "(two balls in one file need a column setup; more angles help)"
            expected = f"readings that tell {name} to ± {most:g} {unit} or better {said}"
            worst = max(found.residuals, key=lambda each: abs(each.times), default=None)
            row = f"; {worst.file}, line {worst.line}, column {worst.column!r} fits least" if worst else ""
            raise InputError(", ".join(found.noise) or "readings", expected, f"± {expanded:.3g} {unit}{row}")


def left_out(problem: Problem, solution: Solution, found: Calibration) -> list[str]:
    """The note on how far an unknown would move, at most and in its own U, if one reading were left out.

    In a linear problem this needs no second estimate (Belsley, Kuh and Welsch, Regression Diagnostics, 1980, 2.1).
    """
    names = [name for name in found.values if name not in found.assumed]
    count = problem.rows[len(problem.blocks) - 1].stop if problem.blocks else 0
    spare, scaled = solution.spare[:count], (solution.residuals / solution.sigmas)[:count]
    checked = spare > CHECKED
    if not names or not checked.any():
        return []
    at = [solution.kept.index(problem.names.index(name)) for name in names]
    gain = solution.covariance[at] @ solution.rows[:count].T
    moved = np.where(checked, gain * scaled / np.maximum(spare, CHECKED), 0.0)
    times = np.abs(moved) / np.array([found[name].U for name in names])[:, None]
    which, row = np.unravel_index(np.argmax(times), times.shape)
    places = [(block.where, *place) for block in problem.blocks for place in block.rows]
    where, line, column = places[row]
    said = f"{times[which, row]:.2f} of its U ({names[which]}; {where}, line {line}, column {column!r})"
    alone = [f"{where}, line {line}" for (where, line, _), other in zip(places, checked, strict=True) if not other]
    notes = [f"leaving out any one reading moves no unknown by more than {said}"]
    if alone:
        notes.append(f"nothing checks {len(alone)} readings, the first in {alone[0]}")
    return notes


def far_off(found: Calibration) -> list[str]:
    """Sentences on axes that are far from where the machine file has them."""
    said = "more than any machine has; the right machine file, the right axis?"
    sizes = {name: (value, *FAR[is_length(name)]) for name, value in found.values.items()}
    return [f"{n} is {value:.3g} {unit}: {said}" for n, (value, most, unit) in sizes.items() if abs(value) > most]


def judge(problem: Problem, solution: Solution) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return doubts and notes, tuples of sentences, on a `problem` and its `solution`."""
    doubts, notes = [], []
    for file in _files(problem, solution):
        doubts += [*file.block.doubts, *file.noise(), *(file.worst() or file.pattern())]
        notes += [*file.block.notes]
    for each in problem.tables:
        doubts += each.doubts
        notes += each.notes
        most, scatter = METHODS["laser"]["noise"], each.scatter * each.unit[0]
        if scatter < 1e3 * SMALLEST and np.isfinite(each.freedom):
            doubts.append(f"{each.where}: runs scatter by {scatter:.4f}: copied, rounded or in another unit?")
        if scatter > 5 * most:
            doubts.append(f"{each.where}: runs scatter by {scatter:.1f}, a laser by {most} at most")
    for name, error in shown(problem, solution).items():
        said = _in_words(problem, name, error)
        if error.times > BEYOND:
            beyond = f"{error.times:.1f} times the standard uncertainty of a machine in good order"
            wrong = "it is no such machine (data/measurements/methods.toml), or a sign or a column is wrong"
            doubts.append(f"{said}, {beyond}: {wrong}")
        elif name not in SQUARENESS:
            steady = "taken out, and in U, as far as it is steady or bends once; a jump is not"
            cure = f"{steady}. Warm the machine up, and end with the first pose"
            notes.append(f"{said}: {cure if _drifts(problem, name) else 'it is in U; measure it'}")
    return tuple(doubts), tuple(notes)


def _drifts(problem: Problem, name: str) -> bool:
    """Whether what is shown under `name` is the drift of a file."""
    return any(block.where == name for block in problem.blocks)


def _in_words(problem: Problem, name: str, each: Shown) -> str:
    """An error that nobody measured, in words."""
    if name in SQUARENESS:
        return f"{name}: the readings show slides out of square by {1e6 * each.size:.0f} µrad"
    if _drifts(problem, name):
        return f"{name}: the readings drift by up to {1e3 * each.size:.1f} µm while they are taken"
    if name in problem.machine.joint_names[3:]:
        found = f"up to {np.degrees(3600 * each.size):.1f} arcsec that nobody measured"
        return f"{name}: the readings show a positioning error of {found}"
    return f"{name}: the readings show a scale error of {1e3 * each.size:.1f} µm"


@dataclass(frozen=True)
class Residual:
    """What is left of one reading: `off`, µm, and how many times what it may scatter by itself."""

    file: str
    line: int
    column: str
    off: float
    times: float


def residuals(problem: Problem, solution: Solution) -> Iterator[Residual]:
    """Yield the `Residual` of each reading of an axis."""
    for file in _files(problem, solution):
        off, times, name = 1e3 * (file.scaled * file.sigma), file.studentized(), file.block.where
        for (line, column), *numbers in zip(file.block.rows, off.tolist(), times.tolist(), strict=True):
            yield Residual(name, line, column, *numbers)


def _files(problem: Problem, solution: Solution) -> Iterator[_File]:
    for block, own, freedom in zip(problem.blocks, problem.rows, solution.freedom, strict=False):
        yield _File(block, solution, own, freedom)


class _File:
    """The residuals of one file of readings."""

    def __init__(self, block: Readings, solution: Solution, own: slice, freedom: float) -> None:
        self.block, self.freedom = block, freedom
        self.rows, self.covariance = solution.rows[own], solution.covariance
        self.scaled = solution.residuals[own] / solution.sigmas[own]
        self.sigma = float(solution.sigmas[own.start])
        self.spare = np.clip(solution.spare[own], 1e-9, None)
        self.free = float(self.spare.sum())
        # A row that pulls the unknowns away from what was known of them shows there, too.
        self.known = float(((solution.rows[len(solution.residuals) :] @ solution.x[solution.kept]) ** 2).sum())

    def noise(self) -> Iterator[str]:
        """Doubts about its size: above what was stated or what the method has, or below what anything has."""
        most, name = METHODS[self.block.method]["noise"], self.block.where
        if np.isinf(self.freedom):
            square = float((self.scaled**2).sum())
            if self.free > SPARE and scipy.special.chdtrc(self.free, square) < CHANCE:
                times = np.sqrt(square / self.free)
                yield f"{name}: readings scatter {times:.1f} times as much as the stated {1e3 * self.sigma:.2f} µm"
            return
        method = self.block.method
        least = self.sigma * np.sqrt(self.freedom / scipy.special.chdtri(self.freedom, CHANCE))
        if 1e3 * least > most:
            said = f"readings scatter by {1e3 * self.sigma:.1f} µm, those of method {method} by {most} at most"
            yield f"{name}: {said}"
        if self.sigma < SMALLEST:
            said = f"readings scatter by {1e3 * self.sigma:.4f} µm: simulated, rounded, or in another unit?"
            yield f"{name}: {said}"

    def studentized(self) -> np.ndarray:
        """Each residual by its own standard deviation; 0 for a reading that nothing else checks."""
        return np.where(self.spare > CHECKED, self.scaled / np.sqrt(self.spare), 0.0)

    def worst(self) -> list[str]:
        """The row that the others contradict, if there is one."""
        studentized = self.studentized()
        row = int(np.argmax(np.abs(studentized)))
        free = self.free
        square = float(studentized[row] ** 2)
        if free < 4 or self.sigma < SMALLEST:
            return []
        if np.isfinite(self.freedom):  # against the noise of the others
            rest = max(float((self.scaled**2).sum()) + self.known - square, 1e-6) / (free - 1)
            chance = 2 * scipy.special.stdtr(free - 1, -np.sqrt(square / rest)) * len(studentized)
            less = np.sqrt(rest)
        else:
            chance, less = 2 * scipy.special.ndtr(-np.sqrt(square)) * len(studentized), 1.0
        if chance > CHANCE:
            return []
        line, column = self.block.rows[row]
        off = 1e3 * self.scaled[row] * self.sigma / self.spare[row]
        said = f"{self.block.where}, line {line}, column {column!r}: {off:+.1f} µm from what all the others say"
        return [f"{said}; without it U is about {less:.2g} times as large: look at it, and measure it again"]

    def pattern(self) -> list[str]:
        """The doubt if residuals hang together: from row to row, or at the angles of an axis."""
        if self.free < 6 or len(self.scaled) > MANY or self.sigma < SMALLEST:
            return []
        columns = np.array([column for _, column in self.block.rows])
        follows = np.flatnonzero(columns[1:] == columns[:-1])
        groups = []
        for axis in range(3, self.block.joints.shape[1]):
            keys = [f"{c} {a:.4f}" for c, a in zip(columns, self.block.joints[:, axis], strict=True)]
            _, index, count = np.unique(keys, return_inverse=True, return_counts=True)
            if 1 < len(count) < len(keys):
                groups.append(np.eye(len(count))[index] / np.sqrt(count))

        def statistics(scaled: np.ndarray) -> np.ndarray:
            """For residuals, shape (readings, draws): how much they hang together, (statistics, draws)."""
            total = (scaled**2).sum(axis=0)
            neighbours = (scaled[follows] * scaled[follows + 1]).sum(axis=0)
            return np.stack([neighbours, *(((each.T @ scaled) ** 2).sum(axis=0) for each in groups)]) / total

        drawn = np.random.default_rng(SEED).standard_normal((len(self.scaled), DRAWS))
        left = drawn - self.rows @ (self.covariance @ (self.rows.T @ drawn))
        found, chance = statistics(self.scaled[:, None]), statistics(left)
        # The tail of the normal distribution with the moments of the draws: chances too small to be drawn.
        above = (found[:, 0] - chance.mean(axis=1)) / chance.std(axis=1)
        if scipy.special.ndtr(-above).min() * len(above) > CHANCE / 10:
            return []
        said = "what is left of the readings follows a pattern: something is not in the model"
        return [f"{self.block.where}: {said}"]
