"""Whether files of readings tell of one machine: each against all the others, without a second estimate."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import scipy

if TYPE_CHECKING:
    from mathpost.shop.compensate.problem import Problem, Solution

# Chance of files that agree, below which one is doubted. Of 300 right simulated sets of 2 or 3 files, half of them
# with every error that is assumed, 10 are below 0.05, 4 below 0.02, 1 below 0.01, none below 0.005. Where an axis
# moves by 2 µm before one of three files (noise 0.5 and 1 µm) 72 % are doubted, from 5 µm or 40 µrad on all.
CHANCE = 0.002
NOTHING = 1e-8  # of the greatest eigenvalue: a combination of unknowns that a file says nothing of


@dataclass(frozen=True)
class Information:
    """The information of one file about the unknowns that files share, in a linear problem; that of others adds."""

    matrix: np.ndarray  # the inverse of their covariance
    vector: np.ndarray  # the matrix times what they are
    square: float  # what the readings leave if the unknowns stay as they are, in deviations
    count: float  # readings less the unknowns of the file alone

    @classmethod
    def of_all(cls, files: Sequence[Information]) -> Information:
        """The information of several files together: their sum."""
        return cls(
            np.sum([each.matrix for each in files], axis=0),
            np.sum([each.vector for each in files], axis=0),
            sum(each.square for each in files),
            sum(each.count for each in files),
        )

    def best(self) -> tuple[float, int]:
        """By how much the square falls at the unknowns that fit best, and how many unknowns this determines."""
        size, vectors = np.linalg.eigh(self.matrix)
        told = size > NOTHING * max(size[-1], NOTHING)
        return float(((self.vector @ vectors[:, told]) ** 2 / size[told]).sum()), int(told.sum())


def apart(problem: Problem, solution: Solution) -> list[str]:
    """Return the doubt about the file that disagrees most with the others, if it does so beyond chance.

    With A the information of a file and b its vector, the squares that are left would fall by
    b' A⁻¹ b + o' O⁻¹ o - (b + o)' (A + O)⁻¹ (b + o) if the file had a machine of its own, O and o being that of all
    the others and of what was known before (Chow, Econometrica 28, 1960).
    """
    if len(problem.blocks) < 2:
        return []
    files = _informations(problem, solution)
    total = Information.of_all(files)
    fell, known = total.best()
    chances = []
    for n, each in enumerate(files[: len(problem.blocks)]):
        falls, told = zip(each.best(), Information.of_all(files[:n] + files[n + 1 :]).best(), strict=True)
        fall, more = max(sum(falls) - fell, 0.0), sum(told) - known
        left, free = total.square - fell - fall, total.count - known - more
        ratio = max(fall / more / (left / free), 0.0) if more and free >= 1 else 0.0
        chances.append(scipy.special.fdtrc(more, free, ratio) if ratio else 1.0)
    worst = int(np.argmin(chances))
    if chances[worst] * len(chances) > CHANCE:
        return []
    names = [block.where for block in problem.blocks]
    if len(names) == 2:
        return [f"{names[0]} and {names[1]} tell of two machines: was something moved or changed between them?"]
    return [f"{names[worst]} tells of a different machine than the other files: look at it, and leave it out"]


def _informations(problem: Problem, solution: Solution) -> list[Information]:
    """The `Information` of each source, and last of what was known before, linear about the `solution`."""
    kept = problem.sought(effects=True, drift=3)
    alone = {n for part in (*problem.drifts, *problem.places) for n in range(part.start, part.stop)}
    shared = [n for n in kept if n not in alone]
    derivatives, found = problem.linear[2], []
    for n, rows in enumerate(problem.rows):
        parts = (problem.drifts[n], problem.places[n]) if n < len(problem.blocks) else ()
        aside = [index for part in parts for index in range(part.start, part.stop) if index in kept]
        known = [index for index in aside if np.isfinite(problem.prior[index])]
        sigmas = solution.sigmas[rows, None]
        # The file's own unknowns, each with what was known of it, are projected out.
        own = np.vstack([derivatives[rows][:, aside] / sigmas, np.eye(problem.count)[np.ix_(known, aside)]])
        own[len(sigmas) :] /= problem.prior[known, None]
        with_known = (len(known), len(shared))
        matrix = np.vstack([derivatives[rows][:, shared] / sigmas, np.zeros(with_known)])
        left = solution.residuals[rows] / sigmas[:, 0]
        left = np.concatenate([left, -solution.x[known] / problem.prior[known]])
        basis = np.linalg.qr(own / np.linalg.norm(own, axis=0))[0]
        matrix, left = matrix - basis @ (basis.T @ matrix), left - basis @ (basis.T @ left)
        found.append(Information(matrix.T @ matrix, matrix.T @ left, float(left @ left), len(left) - len(aside)))
    weights = problem.prior[shared] ** -2.0
    x = solution.x[shared]
    found.append(Information(np.diag(weights), -x * weights, float(x @ (weights * x)), float((weights > 0).sum())))
    return found
