"""A measurement as a formula of unknowns and settings: evaluate it and it simulates, invert it and it identifies.

Each procedure of `rotary_axis`, and the arm of `horizontal_head`, is one sympy expression. Its derivative gives the
least-squares estimate, its covariance, and the diagnosis when readings are too few.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property, lru_cache, partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import scipy
import sympy as sp
from numpy.typing import ArrayLike

from mathpost.errors import InputError, as_array
from mathpost.formula import numeric
from mathpost.shop.measure import csv_table

if TYPE_CHECKING:
    from mathpost.shop.measure.csv_table import Table

STEPS = 20  # of Gauss and Newton: where there is an answer, three or four do, and never more than a dozen
SINGULAR = 1e-8  # of the greatest singular value: below it a combination of unknowns leaves no trace in readings
SHARE = 1e-6  # of an unknown in such a combination, below which it is not part of it
ENDLESS = 1e4  # degrees of freedom beyond which Student's t is the normal distribution in three digits

Compiled = tuple[Callable[..., np.ndarray], Callable[..., np.ndarray]]  # of expressions: values and derivatives


@dataclass(frozen=True)
class Value:
    """A number found from readings: `value` ± `U` (95 %), k standard deviations, with the degrees of `freedom`."""

    value: float
    deviation: float
    freedom: float

    @property
    def k(self) -> float:
        return coverage_factor(self.freedom)

    @property
    def U(self) -> float:
        return self.k * self.deviation

    @property
    def free(self) -> str:
        """The degrees of freedom as they are printed."""
        return "∞" if self.freedom > ENDLESS else f"{self.freedom:.1f}"


@dataclass(frozen=True)
class Estimate:
    """The unknowns as the readings determine them; mm and radians.

    `noise` is the standard deviation of a reading as the residuals show it, NaN without spare ones, in units of the
    stated sigma if there is one: well above 1 means that something is not in the model.
    """

    values: dict[str, float]  # by unknown, as ``estimate[name]`` returns them
    covariance: np.ndarray  # in the same order; NaN if no sigma was stated and no reading is to spare
    residuals: dict[str, np.ndarray]  # of readings: measured minus explained
    spare: int  # readings minus unknowns
    noise: float
    freedom: float = np.inf  # infinite if sigma was stated, else `spare`

    def __getitem__(self, name: str) -> float:
        return self.values[name]

    def deviation(self, name: str) -> float:
        """The standard deviation of one value."""
        return float(np.sqrt(self.covariance.diagonal()[list(self.values).index(name)]))

    def expanded(self, name: str) -> Value:
        """One value as `Value`, with its expanded uncertainty."""
        return Value(self.values[name], self.deviation(name), self.freedom)


@dataclass(frozen=True)
class Measurement:
    """A measuring procedure: its readings as formulas of its settings and its unknowns; mm and radians.

    `unknowns` and `settings` are real sympy symbols; the first setting is an angle, which is stepped. `readings`
    maps a name to an expression in both. `more` maps descriptions of further steps to the settings that they would
    change, ``{setting: expression}``: where readings are too few, the diagnosis proposes some of these. Readings
    beyond `largest`, mm, are suspected to be in another unit.

    Examples
    --------
    >>> turn, slope, start = sp.symbols("turn slope start", real=True)
    >>> more = {"a further turn": {turn: turn + 1}}
    >>> screw = Measurement("screw", (slope, start), (turn,), {"z": start + slope * turn}, more)
    >>> estimate = screw.identify({"turn": [0, 100, 200], "z": [1, 3, 5]}, sigma=0.01)
    >>> f"{estimate['slope']:.4f} ± {estimate.deviation('slope'):.6f}"
    '0.0200 ± 0.000071'
    >>> screw.identify({"turn": 100, "z": [3, 3.01]})
    Traceback (most recent call last):
        ...
    mathpost.errors.InputError: screw: expected readings that tell slope and start apart (a further turn would), ...
    """

    name: str
    unknowns: tuple[sp.Symbol, ...]
    settings: tuple[sp.Symbol, ...]
    readings: dict[str, sp.Expr]
    more: dict[str, dict[sp.Symbol, sp.Expr]] = field(default_factory=dict)
    largest: float = np.inf

    @cached_property
    def depends(self) -> dict[str, set[sp.Symbol]]:
        """The symbols that each reading depends on."""
        return {name: expression.free_symbols for name, expression in self.readings.items()}

    def predict(
        self, values: Mapping[str, float], settings: Mapping[str, ArrayLike], *, degrees: bool = False
    ) -> dict[str, np.ndarray]:
        """Return the readings without noise, as a dict of arrays.

        `values` maps unknowns to numbers (0 if left out), `settings` settings to numbers or arrays, which are
        broadcast; `degrees` is for the angle among them.
        """
        predict, _ = self._compiled(self.readings, self.unknowns)
        predicted = predict(*self._all(values), *self._settings(settings, degrees))
        return dict(zip(self.readings, np.moveaxis(predicted, -1, 0), strict=True))

    def simulate(
        self,
        values: Mapping[str, float],
        settings: Mapping[str, ArrayLike],
        *,
        sigma: float,
        seed: int,
        degrees: bool = False,
    ) -> dict[str, ArrayLike]:
        """Return settings and readings with normal noise of deviation `sigma`, mm; arguments as in `predict`."""
        random = np.random.default_rng(seed)
        readings = self.predict(values, settings, degrees=degrees).items()
        return {**settings} | {name: read + sigma * random.standard_normal(read.shape) for name, read in readings}

    def read(self, path: Path) -> Table:
        """Read settings and at least one reading from a CSV file: a `csv_table.Table` for `identify`.

        Degrees, and mm unless the file names a unit. `InputError` also for suspected units, and if the angle does
        not increase while the other settings, and a column ``run``, stay the same.
        """
        angle, *others = (s.name for s in self.settings)
        also = dict.fromkeys("ABC", angle)
        columns = csv_table.read(path, [angle, *others], optional=[*self.readings, "run"], also=also)
        if not (read := [name for name in self.readings if name in columns]):
            columns.refuse(f"a column of readings: {', '.join(self.readings)}")
        columns.obey_units([angle, *others])
        columns.check_angles(angle)
        for name in read:
            columns[name] = columns.unit(name, "length", default="mm") * columns[name]
            columns.require(name, np.abs(columns[name]) <= self.largest, f"mm within ±{self.largest:g} (µm?)")
        columns.check_increasing(angle, within=[name for name in (*others, "run") if name in columns])
        return columns

    def identify(
        self,
        data: Mapping[str, ArrayLike] | Table,
        *,
        degrees: bool = False,
        sigma: float | None = None,
        known: dict[str, float] | None = None,
    ) -> Estimate:
        """Return the least-squares `Estimate` of the unknowns.

        `data`, a dict or the result of `read`, maps a setting to a number or an array, and a reading to an array,
        shape (n,). Some of the readings are enough; an unknown that none of these depends on is left out.
        `degrees` is for the angle; that of a file always is in degrees. `sigma` is the standard deviation of a
        reading, mm: without it the residuals supply it, poorly if few are to spare. `known` maps unknowns that are
        not sought to their values. `InputError` if the readings leave unknowns undetermined: it says which, and
        which readings would determine them.
        """
        known = known or {}
        if sigma is not None and not 0 < sigma < np.inf:
            raise InputError("sigma", "a standard deviation above 0", repr(sigma))
        where = data.path if isinstance(data, csv_table.Table) else self.name
        used = {name: expression for name, expression in self.readings.items() if name in data}
        length = max((np.size(data[name]) for name in used), default=0)
        if not length:
            raise InputError(where, f"readings: {', '.join(used or self.readings)}", "none")
        appearing = set().union(*(self.depends[name] for name in used))
        sought = tuple(s for s in self.unknowns if s in appearing and s.name not in known)
        names = [s.name for s in sought]
        if not names:
            raise InputError(where, f"something sought among {', '.join(s.name for s in self.unknowns)}", "nothing")
        readings = np.stack([np.broadcast_to(self._array(data, n, length), length) for n in used], axis=-1)
        settings = [
            np.broadcast_to(s, length)
            for s in self._settings(data, degrees or isinstance(data, csv_table.Table), length)
        ]
        predict, derive = self._compiled(used, sought)

        def evaluate(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            arguments = *self._all(dict(zip(names, x, strict=True)) | known), *settings
            return predict(*arguments).ravel(), derive(*arguments).reshape(-1, len(sought))

        def rows(expressions: dict[str, sp.Expr]) -> np.ndarray:
            return self._compiled(expressions, sought)[1](*self._all(known), *settings).reshape(-1, len(sought))

        def changed(changes: dict[sp.Symbol, sp.Expr]) -> np.ndarray:
            return rows({name: e.subs(changes, simultaneous=True) for name, e in used.items()})

        unread = {name: expression for name, expression in self.readings.items() if name not in used}
        further = {f"also reading {', '.join(unread)}": partial(rows, unread)} if unread else {}
        further |= {words: partial(changed, changes) for words, changes in self.more.items()}
        start, found = np.zeros(len(sought)), f"{readings.size} of {', '.join(used)}"
        otherwise = " together with ".join(further) or "more of them"
        check_told_apart(evaluate(start)[1], names, further, where, "readings", found, otherwise)
        sigmas = np.full(readings.size, sigma or 1.0)
        x, covariance, residuals, _ = least_squares(evaluate, readings.ravel(), sigmas, start, where)
        spare = readings.size - len(sought)
        noise = float(np.linalg.norm(residuals / sigmas) / np.sqrt(spare)) if spare else np.nan
        return Estimate(
            dict(zip(names, x.tolist(), strict=True)),
            covariance * (noise**2 if sigma is None else 1.0),
            dict(zip(used, residuals.reshape(readings.shape).T, strict=True)),
            spare,
            noise,
            float(spare) if sigma is None else np.inf,
        )

    def _compiled(self, readings: dict[str, sp.Expr], sought: tuple[sp.Symbol, ...]) -> Compiled:
        return _compiled(tuple(readings.values()), sought, (*self.unknowns, *self.settings))

    def _all(self, values: Mapping[str, float]) -> np.ndarray:
        names = [s.name for s in self.unknowns]
        for name in set(values) - set(names):
            raise InputError(self.name, f"unknowns among {', '.join(names)}", repr(name))
        return as_array([values.get(name, 0.0) for name in names], len(names), f"{self.name}, values")

    def _settings(
        self, data: Mapping[str, ArrayLike], degrees: bool, length: int | None = None
    ) -> list[np.ndarray]:
        names = [s.name for s in self.settings]
        if missing := [name for name in names if name not in data]:
            raise InputError(self.name, f"the settings {', '.join(names)}", f"no {missing[0]!r}")
        angle, *others = (self._array(data, name, length) for name in names)
        return [np.deg2rad(angle) if degrees else angle, *others]

    def _array(self, data: Mapping[str, ArrayLike], name: str, length: int | None) -> np.ndarray:
        where = f"{self.name}, {name}"
        try:
            array = np.asarray(data[name], dtype=float)
        except (TypeError, ValueError):
            raise InputError(where, "numbers", repr(data[name])) from None
        if not np.isfinite(array).all():
            raise InputError(where, "finite numbers", f"{array[~np.isfinite(array)][0]}")
        if length is not None and array.ndim and array.shape != (length,):
            raise InputError(where, f"{length} numbers, one for each reading", f"shape {array.shape}")
        return array


def coverage_factor(freedom: float) -> float:
    """Return Student's t for 95 % and the degrees of `freedom`, 1.96 if they are infinite."""
    return float(scipy.special.stdtrit(freedom, 0.975) if freedom < 1e6 else scipy.special.ndtri(0.975))


def least_squares(
    evaluate: Callable, readings: np.ndarray, sigmas: np.ndarray, start: np.ndarray, where: str
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return the values of the unknowns, their covariance, the residuals, and the weighted derivatives.

    Gauss–Newton: formulas of small errors are nearly linear, so two or three steps suffice. `evaluate` maps the
    values to the predicted readings, shape (n,), and their derivatives, (n, unknowns).
    """
    x = start
    for _ in range(STEPS):
        predicted, derivatives = evaluate(x)
        jacobian = derivatives / sigmas[:, None]
        lengths = _lengths(jacobian)
        q, r = np.linalg.qr(jacobian / lengths)
        if np.abs(r.diagonal()).min() <= SINGULAR:  # the part of a column that those before it do not explain
            break
        inverse = np.linalg.inv(r) / lengths[:, None]
        step = inverse @ (q.T @ ((readings - predicted) / sigmas))
        x = x + step
        if np.abs(derivatives @ step).max() <= 1e-9 * max(1e-2, np.abs(readings).max()):
            return x, inverse @ inverse.T, readings - predicted - derivatives @ step, jacobian
    raise InputError(where, "readings that a machine can explain", "readings that fit no values")


def check_told_apart(
    matrix: np.ndarray,
    names: Sequence[str],
    further: Mapping[str, Callable],
    where: str,
    what: str,
    found: str,
    otherwise: str,
    offer: str = "{}",
) -> None:
    """Raise `InputError` if readings leave unknowns open: it says which, and which of `further` would help.

    `matrix`, shape (readings, unknowns), holds the derivatives of the readings. `further` maps words, for `offer`,
    to a function that returns more rows.
    """
    if not (missing := undetermined(matrix, names)):
        return
    tasks = [f"tell {' and '.join(group)} apart" for group in missing if len(group) > 1]
    if traceless := [group[0] for group in missing if len(group) == 1]:
        tasks.append(f"determine {' and '.join(traceless)}")
    enough = [words for words, rows in further.items() if not undetermined(np.vstack([matrix, rows()]), names)]
    advice = offer.format(" or ".join(enough)) if enough else otherwise
    raise InputError(where, f"{what} that {', '.join(tasks)} ({advice} would)", found)


def undetermined(matrix: np.ndarray, names: Sequence[str]) -> list[list[str]]:
    """Return the unknowns that readings leave open, in groups whose members can replace each other.

    A group of one is an unknown that leaves no trace at all.
    """
    _, singular, vt = np.linalg.svd(matrix / _lengths(matrix), full_matrices=True)
    rank = int((singular > SINGULAR * max(1.0, singular.max(initial=0.0))).sum())
    # The projector on the null space: 1 on the diagonal for an unknown without a trace, less for one that others
    # can replace, 0 for one that is determined. Off the diagonal: which others.
    projector = np.abs(vt[rank:].T @ vt[rank:])
    groups: dict[int, list[str]] = {}
    if rank < len(names):
        _, group = scipy.sparse.csgraph.connected_components(projector > SHARE)
        for index in np.flatnonzero(projector.diagonal() > SHARE):
            groups.setdefault(group[index], []).append(names[int(index)])
    return list(groups.values())


@lru_cache(maxsize=256)
def _compiled(
    expressions: tuple[sp.Expr, ...], sought: tuple[sp.Symbol, ...], arguments: tuple[sp.Symbol, ...]
) -> Compiled:
    """The expressions as a function, shape (n, expressions), and their derivatives, (n, expressions, sought)."""
    derivatives = sp.ImmutableMatrix(expressions).jacobian(sp.Matrix(sought))
    return numeric(expressions, arguments), numeric(sp.ImmutableMatrix(derivatives), arguments)


def _lengths(matrix: np.ndarray) -> np.ndarray:
    """The lengths of the columns, 1 for a column that is only rounding."""
    lengths = np.linalg.norm(matrix, axis=0)
    return np.where(lengths > 1e-13 * max(1.0, lengths.max()), lengths, 1.0)
