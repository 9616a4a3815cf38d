"""What a machine has although nobody measured it: how large it is assumed to be, and where readings show it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from mathpost.files import data_file, read_toml
from mathpost.shop.compensate.model import SQUARENESS, table_position
from mathpost.shop.compensate.positioning import ROUNDING

if TYPE_CHECKING:
    from mathpost.shop.compensate.problem import Problem, Solution


@lru_cache(maxsize=1)
def unmeasured() -> dict[str, np.ndarray]:
    """The standard uncertainties of what nobody measured: mm and radians, by name."""
    content = read_toml(data_file("measurements/methods.toml"))["unmeasured"]
    size = {"squareness": 1e-6, "tilt": 1e-6, "offset": 1e-3, "slide": 1e-6, "drift": 1e-3}
    size["rotary"] = np.deg2rad(1 / 3600)
    return {name: size[name] * np.array(value, dtype=float) for name, value in content.items()}


@dataclass(frozen=True)
class Unmeasured:
    """The positioning error of a joint without a table: `shape` takes positions, (n,), to shares, (n, terms)."""

    joint: int
    shape: Callable[[np.ndarray], np.ndarray]
    sigma: np.ndarray  # standard uncertainty of each term, radians or mm

    @classmethod
    def of(cls, joint: int, about: np.ndarray) -> Unmeasured:
        """Harmonics of a rotary joint, nothing at zero; the scale of a slide, nothing at `about`, shape (3,)."""
        if joint < 3:
            return cls(joint, lambda at: (at - about[joint])[:, None], np.atleast_1d(unmeasured()["slide"]))
        size = unmeasured()["rotary"]
        orders = np.arange(1, len(size) + 1)

        def shape(at: np.ndarray) -> np.ndarray:
            angle = np.deg2rad(at)[:, None] * orders
            return np.hstack([np.sin(angle), np.cos(angle) - 1])

        return cls(joint, shape, np.tile(size, 2))


def drift_shapes(order: np.ndarray) -> np.ndarray:
    """How a file drifts, from the `order` of its readings, 0 to 1, shape (n,): steadily, and bent; (n, 2)."""
    return np.column_stack([order, 4 * order * (1 - order)])


@dataclass(frozen=True)
class Shown:
    """An error that nobody measured, and that readings show."""

    size: float  # the greatest, mm or radians
    times: float  # root mean square, in that of the standard uncertainties from before anything was read


def shown(problem: Problem, solution: Solution) -> dict[str, Shown]:
    """Unmeasured errors that exceed three standard uncertainties, by squareness, joint or drifting file."""
    full = np.zeros((problem.count, problem.count))
    full[np.ix_(solution.kept, solution.kept)] = solution.covariance
    sums: list[tuple[str, slice, np.ndarray]] = []  # names, and sums of the unknowns of a slice, (n, unknowns)
    for name in SQUARENESS:
        index = problem.names.index(name)
        sums.append((name, slice(index, index + 1), np.eye(1)))
    for each, own in zip(problem.effects, problem.terms, strict=True):
        positions = [table_position(problem.machine, b.joints, each.joint, b.length) for b in problem.blocks]
        at = np.concatenate(positions)
        sums.append((problem.machine.joint_names[each.joint], own, each.shape(at)))
    for block, own in zip(problem.blocks, problem.drifts, strict=True):
        shares = np.einsum("ns,de->dnse", drift_shapes(block.order), np.eye(3)).reshape(3, -1, 6)
        sums += [(block.where, own, share) for share in shares]
    found: dict[str, Shown] = {}
    for name, own, shares in sums:
        error, before = np.abs(shares @ solution.x[own]), found.get(name, Shown(0.0, 0.0))
        deviation = np.sqrt(np.einsum("ni,ij,nj->n", shares, full[own, own], shares))
        if (error > 3 * np.maximum(deviation, ROUNDING)).any():
            assumed = shares**2 @ problem.prior[own] ** 2
            times = float(np.sqrt((error**2).sum() / assumed.sum()))
            found[name] = max(before, Shown(float(error.max()), times), key=lambda each: each.times)
    return found
