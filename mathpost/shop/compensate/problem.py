"""All readings of a machine as one least-squares problem: what they say, and what nobody measured.

The chain of `mathpost.chain`, with unknown numbers, predicts all readings. Unknowns that no method reads directly
(squareness of the slides, positioning errors of axes without a laser, tilts that can stand in for an offset) are
estimated like the rest, each with an assumed reading of 0 ± a standard uncertainty: [unmeasured] in
data/measurements/methods.toml. Where the readings determine such an unknown, they outweigh that assumption; where
they do not, it adds to the uncertainty of all the rest.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from copy import copy
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import pairwise, product
from typing import TYPE_CHECKING

import numpy as np
import scipy
from numpy.typing import ArrayLike

from mathpost.errors import InputError
from mathpost.shop.compensate import held
from mathpost.shop.compensate.model import SQUARENESS, out_of_square, table_position
from mathpost.shop.compensate.moved import moved, unknowns
from mathpost.shop.compensate.positioning import Positioning
from mathpost.shop.compensate.unmeasured import Unmeasured, drift_shapes, unmeasured
from mathpost.shop.measure.fit import least_squares

if TYPE_CHECKING:
    from mathpost.machine import Machine
    from mathpost.shop.compensate.readings import Readings

DEPENDENT = 1e-5  # of a column that others leave: below it the readings do not tell the unknown from theirs
NOTHING = 1e-9  # length of a column without a trace of its unknown
SHOWN = 0.01  # chance below which readings are taken to show an error that nobody measured
LEAST = 1e-6  # mm: no reading scatters less
FEWEST = 3  # spare readings below which they are not asked for it
DETERMINED = 0.5  # of the uncertainty from before anything was read: readings that leave more determine nothing


@dataclass(frozen=True)
class Solution:
    """One least-squares estimate; `kept` are the indices of the unknowns that were sought."""

    x: np.ndarray  # all unknowns
    kept: list[int]
    covariance: np.ndarray  # of those kept
    rows: np.ndarray  # weighted derivatives by these: of the readings, then of what was known before
    residuals: np.ndarray  # of the readings
    sigmas: np.ndarray
    freedom: list[float]  # of the noise of each source
    bias: np.ndarray | float = 0.0  # what the estimate moves by one standard uncertainty of each error left out

    @property
    def whole(self) -> np.ndarray:
        """The covariance of the unknowns kept, with that of the errors that were left out."""
        return self.covariance + np.dot(self.bias, np.transpose(self.bias))

    @property
    def spare(self) -> np.ndarray:
        """How much of each reading the estimate leaves free, 0 to 1."""
        rows = self.rows[: len(self.residuals)]
        return 1 - ((rows @ self.covariance) * rows).sum(axis=1)


@lru_cache(maxsize=8)
def _moves(machine: Machine) -> np.ndarray:
    """How the machine's axes, points and tool change with each of its `unknowns`, shape (18, unknowns)."""
    columns = []
    for name in unknowns(machine):
        high, low = (held.geometry(moved(machine, {name: step})) for step in (1e-5, -1e-5))
        columns.append((high - low) / 2e-5)
    moves = np.array(columns).T
    moves.flags.writeable = False
    return moves


class Problem:
    """All readings as one function of all unknowns.

    The unknowns are the geometry in the order of `unknowns`, the entries of the tables, the terms of what was not
    measured, three drifts for each file and how they bend, and each ball's place and zero.
    """

    def __init__(self, machine: Machine, blocks: list[Readings], tables: list[Positioning]) -> None:
        self.machine, self.blocks, self.tables = machine, blocks, tables
        self.names = unknowns(machine)
        self.sources: list[Readings | Positioning] = [*blocks, *tables]
        seen = {each.joint for each in tables}
        joints = range(len(machine.joint_names))
        moving = [n for n in joints if any(np.ptp(each.joints[:, n]) > 0 for each in blocks)]
        # Squareness and scale of a slide count from where it was read: there the axes are where they are displayed.
        standing = [self.slides(each, each.joints) for each in blocks] or [np.zeros((1, 3))]
        self.about = np.concatenate(standing).mean(axis=0)
        self.effects = [Unmeasured.of(n, self.about) for n in moving if n not in seen]
        sizes = [len(self.names), *(len(each.at) for each in tables), *(len(each.sigma) for each in self.effects)]
        places = [4 * (int(each.setup.max()) + 1) for each in blocks]
        self.geometry, *parts = _slices([*sizes, *(6 for _ in blocks), *places])
        self.entries, parts = parts[: len(tables)], parts[len(tables) :]
        self.terms, parts = parts[: len(self.effects)], parts[len(self.effects) :]
        self.drifts, self.places = parts[: len(blocks)], parts[len(blocks) :]
        self.count = [self.geometry, *self.entries, *self.terms, *self.drifts, *self.places][-1].stop
        self.rows = _slices(len(each.value) for each in self.sources)
        self.observed = np.concatenate([each.value for each in self.sources])
        self.moves = _moves(machine)
        self.linear = np.zeros(self.count), *self.predict(self.all, np.zeros(self.count))
        self.reasons, self.told = self._told_apart()
        self.prior = self._prior()

    def _prior(self) -> np.ndarray:
        """The standard uncertainty of each unknown that has one before anything is read; infinite for others."""
        given, prior = unmeasured(), np.full(self.count, np.inf)
        for index, name in enumerate(self.names):
            if name in SQUARENESS:
                prior[index] = given["squareness"]
            elif name in self.reasons:
                prior[index] = given["tilt" if name[1] in "ABC34" else "offset"]
        for each, own in zip(self.effects, self.terms, strict=True):
            prior[own] = each.sigma
        for own in self.drifts:
            prior[own] = given["drift"] * np.repeat([1, 0.5], 3)
        return prior

    def solve(self) -> Solution:
        """Return the `Solution`.

        First everything is taken for measured. If the readings speak against that, the errors that nobody measured
        are sought and have their part in the noise. If not, they widen the uncertainty, by what the readings leave
        of them.
        """
        given = self._of_readings([np.nan_to_num(each.sigma, nan=1e-3) for each in self.sources])
        start = self._exact(self.sought(), given, np.zeros(self.count))
        self.linear = start, *self.predict(self.all, start)
        plain = self._noise(self.sought(), given)
        if plain is None:
            raise self._too_few(self.sought(), given)
        noise = plain
        for drift, effects in list(product((0, 3, 6), (False, True)))[1:]:
            found = self._noise(self.sought(effects, drift), given)
            if found is not None and self._speaks_for(found, noise):
                noise = found
        sought, others = noise.kept, [n for n in self.sought(effects=True) if n not in noise.kept]
        if others:
            self._shrink(sorted([*sought, *others]), noise.sigmas)
        found = self._with_bias(noise, others)
        x = self._exact(sought, noise.sigmas, found.x)
        self.linear = x, *self.predict(self.all, x)
        return self._with_bias(self._estimate(sought, noise.sigmas, noise.freedom), others)

    def misfit(self, noise: Sequence[float]) -> float:
        """How badly the readings fit: squares of what is left of them and of what was assumed, in deviations.

        `noise` is that of each file in mm. All unknowns are sought, in one linear step from nothing.
        """
        each_file = iter(noise)
        stated = [each.sigma if isinstance(each, Positioning) else next(each_file) for each in self.sources]
        sigmas = self._of_readings(stated)
        found = self._estimate(self.sought(effects=True, drift=3), sigmas, [])
        return float(((found.residuals / sigmas) ** 2).sum() + ((found.x / self.prior) ** 2).sum())

    def _of_readings(self, of_sources: Sequence[ArrayLike]) -> np.ndarray:
        """A number of each source, or one of each of its readings, as one array of all readings."""
        pairs = zip(of_sources, self.sources, strict=True)
        return np.concatenate([np.broadcast_to(number, len(each.value)) for number, each in pairs])

    def read_again(self, blocks: list[Readings]) -> Problem:
        """The same with other readings of the same poses; with other poses it is derived anew."""
        if not all(one.same_poses(other) for one, other in zip(self.blocks, blocks, strict=True)):
            return Problem(self.machine, blocks, self.tables)
        again = copy(self)
        again.sources = [*blocks, *self.tables]
        again.blocks, again.observed = blocks, np.concatenate([each.value for each in again.sources])
        return again

    def _with_bias(self, found: Solution, others: list[int]) -> Solution:
        """The estimate with what the unknowns `others`, taken for nothing, may have moved it by."""
        rows = found.rows[: len(found.sigmas)]
        moved = self.linear[2][:, others] * self.prior[others] / found.sigmas[:, None]
        return replace(found, bias=found.covariance @ (rows.T @ moved))

    def determined(self, found: Solution, name: str) -> bool:
        """Whether the readings, not what was assumed, say what an unknown of the geometry is."""
        index = self.names.index(name)
        if index not in found.kept:
            return False
        deviation = np.sqrt(found.whole[(found.kept.index(index),) * 2])
        return bool(deviation <= DETERMINED * self.prior[index])

    def would_tell(self, name: str, noise: float) -> bool:
        """Whether readings that scatter by `noise`, not what is assumed, would say what an unknown is."""
        found = self._estimate(self.sought(), np.full(len(self.observed), noise), [])
        index = found.kept.index(self.names.index(name))
        return bool(np.sqrt(found.covariance[index, index]) <= DETERMINED * self.prior[found.kept[index]])

    def sought(self, effects: bool = False, drift: int = 0) -> list[int]:
        """Indices of the unknowns that are sought; `drift` of each file, 3 if it is steady, 6 if it bends."""
        left_out = set() if effects else {n for own in self.terms for n in range(own.start, own.stop)}
        left_out |= {n for own in self.drifts for n in range(own.start + drift, own.stop)}
        return [n for n in range(self.count) if n in self.told and n not in left_out]

    def _exact(self, kept: list[int], sigmas: np.ndarray, start: np.ndarray) -> np.ndarray:
        """All unknowns by Gauss and Newton, the noise known."""
        known = [n for n, index in enumerate(kept) if np.isfinite(self.prior[index])]
        observed = np.concatenate([self.observed, np.zeros(len(known))])
        weights = np.concatenate([sigmas, self.prior[kept][known]])

        def evaluate(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            full = np.zeros(self.count)
            full[kept] = x
            predicted, derivatives = self.predict(kept, full)
            return np.concatenate([predicted, x[known]]), np.vstack([derivatives, np.eye(len(kept))[known]])

        full = np.zeros(self.count)
        full[kept] = least_squares(evaluate, observed, weights, start[kept], self.sources[0].where)[0]
        return full

    def _estimate(self, kept: list[int], sigmas: np.ndarray, freedom: list[float]) -> Solution:
        """The `Solution` from the readings' derivatives at `linear`."""
        start, predicted, derivatives = self.linear
        known = np.isfinite(self.prior[kept])
        rows = np.vstack([derivatives[:, kept] / sigmas[:, None], np.diag(1 / self.prior[kept])[known]])
        left = np.concatenate([(self.observed - predicted) / sigmas, (-start[kept] / self.prior[kept])[known]])
        missing = start.copy()
        missing[kept] = 0
        if missing.any():  # they are nothing in this estimate
            left[: len(sigmas)] += derivatives @ missing / sigmas
        lengths = np.linalg.norm(rows, axis=0)
        q, r = np.linalg.qr(rows / lengths)
        inverse = np.linalg.inv(r) / lengths[:, None]
        step = inverse @ (q.T @ left)
        x = np.zeros(self.count)
        x[kept] = start[kept] + step
        residuals = (left - rows @ step)[: len(sigmas)] * sigmas
        return Solution(x, kept, inverse @ inverse.T, rows, residuals, sigmas, freedom)

    def _noise(self, kept: list[int], sigmas: np.ndarray) -> Solution | None:
        """The `Solution` whose noise was estimated with its unknowns, in turn; None if no reading is to spare."""
        freedom = [each.freedom for each in self.sources]
        for _ in range(100):
            found = self._estimate(kept, sigmas, freedom)
            before, sigmas, freedom, spare = sigmas, sigmas.copy(), list(freedom), found.spare
            for number, (block, own) in enumerate(zip(self.blocks, self.rows, strict=False)):
                if np.isnan(block.sigma):
                    freedom[number] = spare[own].sum()
                    if freedom[number] < 0.5:
                        return None
                    sigmas[own] = max(np.sqrt((found.residuals[own] ** 2).sum() / freedom[number]), LEAST)
            if np.allclose(before, sigmas, rtol=1e-3):
                break
        return self._estimate(kept, sigmas, freedom)

    def _too_few(self, kept: list[int], sigmas: np.ndarray) -> InputError:
        spare = self._estimate(kept, sigmas, []).spare
        fewest = min(zip(self.blocks, self.rows, strict=False), key=lambda each: spare[each[1]].sum())[0]
        expected = "more readings than unknowns, or a line # sigma = deviation of a reading"
        return InputError(fewest.where, expected, f"{len(fewest.value)} readings, none to spare")

    def _shrink(self, kept: list[int], sigmas: np.ndarray) -> None:
        """Take the unmeasured errors for as small as the readings show them, and no greater than was assumed.

        Each joint's terms have one factor, of greatest likelihood (EM algorithm): where the readings cannot see
        them it stays 1, where they see none it goes to nothing.
        """
        whole = self.prior.copy()
        terms = [[n for n in range(own.start, own.stop) if n in kept] for own in self.terms]
        for _ in range(200):
            found, before = self._estimate(kept, sigmas, []), self.prior.copy()
            variance = np.zeros(self.count)
            variance[kept] = np.diag(found.covariance)
            for at in filter(None, terms):
                factor = np.sqrt(((found.x[at] ** 2 + variance[at]) / whole[at] ** 2).mean())
                self.prior[at] = whole[at] * min(max(factor, 1e-3), 1.0)
            if np.allclose(before, self.prior, rtol=0.01):
                break

    def _speaks_for(self, more: Solution, less: Solution) -> bool:
        """Whether the unknowns that `more` has beyond `less` explain more than chance would (F test)."""
        read = slice(0, self.rows[len(self.blocks) - 1].stop if self.blocks else 0)
        free = [float(each.spare[read].sum()) for each in (more, less)]
        if free[0] < FEWEST or free[1] - free[0] < 1e-3:
            return False
        square = [float(((each.residuals / more.sigmas) ** 2)[read].sum()) for each in (more, less)]
        ratio = (square[1] - square[0]) / (free[1] - free[0]) / (square[0] / free[0])
        return scipy.special.fdtrc(free[1] - free[0], free[0], max(ratio, 0.0)) < SHOWN

    def _told_apart(self) -> tuple[dict[str, list[str] | None], set[int]]:
        """Which unknowns the readings determine, given those before them, and which they do not.

        Returns a dict from the name of each one left open to those that explain it, None if it leaves no trace, and
        the indices of the unknowns to estimate. The positions of balls and the unknowns of the laser come first,
        then the geometry in the order of `unknowns`. An unknown with a reading of its own is always estimated.
        """
        matrix = self.linear[2]
        if any((each.joints != each.believed).any() for each in self.blocks):
            matrix = self.predict(self.all, np.zeros(self.count), believed=True)[1]
        geometry = len(self.names)
        free = [n for own in (*self.entries, *self.places) for n in range(own.start, own.stop)]
        kept: list[int] = []
        room = np.empty((len(matrix), len(free) + geometry), order="F")
        reasons: dict[str, list[str] | None] = {}
        told: set[int] = set()
        for index in (*free, *range(geometry)):
            column, basis = matrix[:, index], room[:, : len(kept)]
            length, left = np.linalg.norm(column), column - basis @ (basis.T @ column)
            left -= basis @ (basis.T @ left)
            if length > NOTHING and np.linalg.norm(left) > DEPENDENT * length:
                room[:, len(kept)] = left / np.linalg.norm(left)
                kept.append(index)
                told.add(index)
            elif index < geometry and length > NOTHING:
                share = np.linalg.lstsq(matrix[:, kept], column, rcond=None)[0]
                share = np.abs(share) * np.linalg.norm(matrix[:, kept], axis=0) > 1e-3 * length
                reasons[self.names[index]] = [
                    self.names[n] for n, each in zip(kept, share, strict=True) if each and n < geometry
                ]
                told.add(index)  # with its standard uncertainty
            elif index < geometry:
                reasons[self.names[index]] = None
        traces = np.linalg.norm(matrix, axis=0) > NOTHING
        told |= {n for own in (*self.terms, *self.drifts) for n in range(own.start, own.stop) if traces[n]}
        return reasons, told

    def slides(self, block: Readings, joints: np.ndarray) -> np.ndarray:
        """The positions of the slides, (n, 3), at the joints of a file's readings."""
        return self.machine.slide_positions(joints[:, :3], block.length)

    @property
    def all(self) -> list[int]:
        """Indices of all unknowns."""
        return list(range(self.count))

    def predict(self, kept: list[int], x: np.ndarray, believed: bool = False) -> tuple[np.ndarray, np.ndarray]:
        """The predicted readings, all unknowns being `x`, and their derivatives by those `kept`.

        `believed`: where RTCP would be, not where the slides were found, whose noise would tell unknowns apart.
        """
        eye, real = np.eye(self.count), moved(self.machine, dict(zip(self.names, x[self.geometry], strict=True)))
        parts = [self._gaps(n, x, real, believed) for n in range(len(self.blocks))]
        parts += [(x[own], eye[own]) for own in self.entries]
        predicted, derivatives = map(np.concatenate, zip(*parts, strict=True))
        return predicted, derivatives[:, kept]

    def _gaps(self, number: int, x: np.ndarray, real: Machine, believed: bool) -> tuple[np.ndarray, np.ndarray]:
        """What is read in a file of the machine `real`; its derivatives by all unknowns."""
        block, place, drift = self.blocks[number], self.places[number].start, self.drifts[number]
        gaps, derivatives = self._along(block, block.believed if believed else block.joints, place, x, real)
        if block.reference is not None:
            there, slopes = self._along(block, block.reference, place, x, real)
            gaps, derivatives = gaps - there, derivatives - slopes
        if block.zeroed:
            zero = place + 4 * block.setup + 3
            gaps = gaps + x[zero]
            derivatives[np.arange(len(zero)), zero] = 1
        derivatives[:, drift] = np.einsum("ns,nd->nsd", drift_shapes(block.order), block.direction).reshape(-1, 6)
        return gaps + derivatives[:, drift] @ x[drift], derivatives

    def _along(
        self, block: Readings, joints: np.ndarray, place: int, x: np.ndarray, real: Machine
    ) -> tuple[np.ndarray, np.ndarray]:
        """The distance of the ball from the tip along each reading's direction; its derivatives by all unknowns."""
        values = dict(zip(self.names, x[self.geometry], strict=True))
        away, actual, paths, shares = self.slides(block, joints) - self.about, joints.copy(), {}, []
        for name in SQUARENESS:
            slide, aside = out_of_square(name)
            paths[name] = np.outer(away[:, slide], aside)
            actual[:, :3] += values[name] * paths[name]
        for each, own in zip(self.tables, self.entries, strict=True):
            position = table_position(self.machine, joints, each.joint, block.length)
            shares.append((each.joint, own, each.weights(position, where=each.where)))
        for effect, own in zip(self.effects, self.terms, strict=True):
            position = table_position(self.machine, joints, effect.joint, block.length)
            shares.append((effect.joint, own, effect.shape(position)))
        for joint, own, share in shares:
            actual[:, joint] += share @ x[own]
        tip, by = held.tips(self.machine, actual, block.length, real)
        along = np.einsum("ni,nji->nj", block.direction, by[..., :3])  # the direction, in the workpiece
        slopes = -np.einsum("ni,nij->nj", along, by)
        derivatives = np.zeros((len(actual), self.count))
        derivatives[:, self.geometry] = slopes[:, joints.shape[1] :][:, : len(self.moves)] @ self.moves
        for name, path in paths.items():
            derivatives[:, self.names.index(name)] += (slopes[:, :3] * path).sum(axis=1)
        for joint, own, share in shares:
            derivatives[:, own] = slopes[:, [joint]] * share
        ball = place + 4 * block.setup[:, None] + np.arange(3)
        np.put_along_axis(derivatives, ball, along, axis=1)
        return np.einsum("ni,ni->n", along, block.target + x[ball] - tip), derivatives


def _slices(sizes: Iterable[int]) -> list[slice]:
    """Slices of these sizes, one behind the other."""
    return [slice(*each) for each in pairwise(np.cumsum([0, *sizes]).tolist())]
