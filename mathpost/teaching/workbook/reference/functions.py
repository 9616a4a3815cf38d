"""Functions of a spreadsheet beyond those that a rotation needs: lookups by a computed key, statistics, steps.

Each takes arrays of shape (samples, rows, columns), as in `sheet.evaluate`, and looks up at every sample by itself.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from mathpost.teaching.workbook.sheet import evaluate

ONE = np.ones((1, 1, 1))


def _flat(area: np.ndarray, samples: int) -> np.ndarray:
    """The cells of an area in one row, shape (samples, cells)."""
    return np.broadcast_to(area.reshape(len(area), -1), (samples, area[0].size))


def match(key: np.ndarray, area: np.ndarray, kind: np.ndarray = ONE) -> np.ndarray:
    """The number, from 1, of the key in a list; NaN where it is not there. `kind` is 0, 1 or -1 as in MATCH."""
    samples, way = max(len(key), len(area)), kind.flat[0]
    cells, key = _flat(area, samples), _flat(key, samples)
    fits = cells == key if way == 0 else cells <= key if way > 0 else cells >= key
    last = cells.shape[1] - np.argmax(fits[:, ::-1], axis=1)
    number = np.argmax(fits, axis=1) + 1.0 if way == 0 else last * 1.0
    return np.where(fits.any(axis=1), number, np.nan)[:, None, None]


def index(area: np.ndarray, row: np.ndarray, column: np.ndarray | None = None) -> np.ndarray:
    """INDEX, of which row and column may differ from sample to sample; 0 takes all."""
    if column is None:
        row, column = (ONE, row) if area.shape[1] == 1 else (row, ONE * (area.shape[2] == 1))
    samples = max(map(len, (area, row, column)))
    area = np.broadcast_to(area, (samples, *area.shape[1:]))
    for axis, number in ((1, row), (2, column)):
        if (number == 0).all():
            continue
        size, place = area.shape[axis], np.broadcast_to(number, (samples, 1, 1))
        inside = (place >= 1) & (place < size + 1)
        found = np.where(inside, place, 1.0).astype(int) - 1
        shape = (samples, 1, area.shape[2]) if axis == 1 else (samples, area.shape[1], 1)
        area = np.take_along_axis(area, np.broadcast_to(found, shape), axis)
        area = np.where(inside, area, np.nan)
    return area


def _vlookup(key: np.ndarray, table: np.ndarray, column: np.ndarray, near: np.ndarray = ONE) -> np.ndarray:
    return index(table, match(key, table[:, :, :1], near), column)


def _hlookup(key: np.ndarray, table: np.ndarray, row: np.ndarray, near: np.ndarray = ONE) -> np.ndarray:
    return index(table, row, match(key, table[:, :1], near))


def _lookup(kind: float) -> Callable[..., np.ndarray]:
    def lookup(key: np.ndarray, keys: np.ndarray, table: np.ndarray | None = None) -> np.ndarray:
        table = keys if table is None else table
        return index(table.reshape(len(table), -1, 1), match(key, keys, ONE * kind), ONE)

    return lookup


def _line(ys: np.ndarray, xs: np.ndarray) -> tuple[np.ndarray, ...]:
    """The slope and the intercept of the straight line through points, and the square of the correlation."""
    samples = max(len(ys), len(xs))
    y, x = _flat(ys, samples), _flat(xs, samples)
    if y.shape != x.shape:
        raise ValueError
    u, v = (each - each.mean(axis=1, keepdims=True) for each in (x, y))
    uu, uv, vv = ((a * b).sum(axis=1)[:, None, None] for a, b in ((u, u), (u, v), (v, v)))
    slope = uv / uu
    return slope, y.mean(axis=1)[:, None, None] - slope * x.mean(axis=1)[:, None, None], uv**2 / (uu * vv), uv


def _forecast(x: np.ndarray, ys: np.ndarray, xs: np.ndarray) -> np.ndarray:
    slope, start, *_ = _line(ys, xs)
    return start + slope * x


def _linest(ys: np.ndarray, xs: np.ndarray) -> np.ndarray:
    return np.concatenate(_line(ys, xs)[:2], axis=2)


def _spread_about_line(ys: np.ndarray, xs: np.ndarray) -> np.ndarray:
    """STEYX: the standard deviation of points about their straight line."""
    slope, start, *_ = _line(ys, xs)
    samples = max(len(ys), len(xs))
    left = (_flat(ys, samples) - start[:, 0] - slope[:, 0] * _flat(xs, samples)) ** 2
    return np.sqrt(left.sum(axis=1) / (left.shape[1] - 2))[:, None, None]


def _payment(
    rate: np.ndarray, count: np.ndarray, now: np.ndarray, then: np.ndarray = 0 * ONE, early: np.ndarray = 0 * ONE
) -> np.ndarray:
    """PMT: what is paid each time, so that `now` becomes `then`."""
    growth = (1 + rate) ** count
    without = rate == 0
    share = np.where(without, 1 / count, rate / np.where(without, 1, growth - 1))
    return -(now * growth + then) * share / (1 + rate * early)


def _ranked(largest: bool) -> Callable[..., np.ndarray]:
    def ranked(area: np.ndarray, k: np.ndarray) -> np.ndarray:
        cells = np.sort(area.reshape(len(area), -1), axis=1)[:, :, None]
        return index(cells[:, ::-1] if largest else cells, k, ONE)

    return ranked


def _steps(how: Callable[[np.ndarray], np.ndarray]) -> Callable[..., np.ndarray]:
    return lambda x, step=ONE: how(x / step) * step


def _first_true(*pairs: np.ndarray) -> np.ndarray:
    value: np.ndarray = ONE * np.nan
    for test, then in reversed(list(zip(pairs[::2], pairs[1::2], strict=True))):
        value = np.where(np.isnan(test), np.nan, np.where(test != 0, then, value))
    return value


def _choose(number: np.ndarray, *values: np.ndarray) -> np.ndarray:
    return _first_true(*(part for n, value in enumerate(values, 1) for part in (np.floor(number) == n, value)))


MORE: dict[str, Callable[..., np.ndarray]] = {
    **{"MATCH": match, "INDEX": index, "VLOOKUP": _vlookup, "HLOOKUP": _hlookup, "CHOOSE": _choose},
    **{"LOOKUP": _lookup(1), "XLOOKUP": _lookup(0), "IFS": _first_true},
    **{name: lambda ys, xs, n=n: _line(ys, xs)[n] for n, name in enumerate(("SLOPE", "INTERCEPT", "RSQ"))},
    "CORREL": lambda ys, xs: np.sign(_line(ys, xs)[3]) * np.sqrt(_line(ys, xs)[2]),
    **{"FORECAST": _forecast, "FORECAST.LINEAR": _forecast, "LINEST": _linest},
    **{"STEYX": _spread_about_line, "PMT": _payment},
    "TREND": lambda ys, xs, new: _forecast(new, ys, xs),
    "DEVSQ": lambda x: ((x - x.mean(axis=(1, 2), keepdims=True)) ** 2).sum(axis=(1, 2), keepdims=True),
    **{"LARGE": _ranked(True), "SMALL": _ranked(False)},
    **{name: lambda x, n=n: np.full((1, 1, 1), float(x.shape[n])) for n, name in ((1, "ROWS"), (2, "COLUMNS"))},
    "MUNIT": lambda n: np.eye(int(n.flat[0]))[None],
    **{name: getattr(np, name.lower()) for name in ("LOG10", "SINH", "COSH", "TANH")},
    "LOG": lambda x, base=ONE * 10: np.log(x) / np.log(base),
    **{"COT": lambda x: 1 / np.tan(x), "SEC": lambda x: 1 / np.cos(x), "CSC": lambda x: 1 / np.sin(x)},
    **{name: _steps(np.ceil) for name in ("CEILING", "CEILING.MATH")},
    **{name: _steps(np.floor) for name in ("FLOOR", "FLOOR.MATH")},
    **{"MROUND": _steps(np.round), "QUOTIENT": lambda a, b: np.trunc(a / b)},
    "SUMX2PY2": lambda a, b: (a**2 + b**2).sum(axis=(1, 2), keepdims=True),
    "SUMX2MY2": lambda a, b: (a**2 - b**2).sum(axis=(1, 2), keepdims=True),
    **{"ISNUMBER": lambda x: np.isfinite(x) * 1.0, "ISERROR": lambda x: ~np.isfinite(x) * 1.0},
}


def _quantile(of_t: bool, two_sided: bool) -> Callable[..., np.ndarray]:
    """Quantiles of Student's distribution or of the normal one."""

    def quantile(share: np.ndarray, freedom: np.ndarray = ONE) -> np.ndarray:
        from scipy.special import ndtri, stdtrit  # it takes a while, and few need it

        share = 1 - share / 2 if two_sided else share
        return stdtrit(freedom, share) if of_t else ndtri(share)

    return quantile


MORE |= {
    **dict.fromkeys(("TINV", "T.INV.2T"), _quantile(of_t=True, two_sided=True)),
    "T.INV": _quantile(of_t=True, two_sided=False),
    **dict.fromkeys(("NORMSINV", "NORM.S.INV"), _quantile(of_t=False, two_sided=False)),
    "NPV": lambda rate, *values: _present(rate, *values),
    **{"EVEN": lambda x: np.sign(x) * np.ceil(np.abs(x) / 2) * 2},
    **{"ODD": lambda x: np.where(x < 0, -1, 1) * (np.ceil((np.abs(x) + 1) / 2) * 2 - 1)},
    "AVEDEV": lambda x: np.abs(x - x.mean(axis=(1, 2), keepdims=True)).mean(axis=(1, 2), keepdims=True),
    "GEOMEAN": lambda x: np.exp(np.log(x).mean(axis=(1, 2), keepdims=True)),
}


def _present(rate: np.ndarray, *values: np.ndarray) -> np.ndarray:
    """NPV: what payments at the ends of periods are worth now."""
    samples = max(map(len, (rate, *values)))
    paid = np.hstack([_flat(value, samples) for value in values])
    growth = (1 + rate[:, :, 0]) ** np.arange(1, paid.shape[1] + 1)
    return (paid / growth).sum(axis=1)[:, None, None]


FUNCTIONS = {**evaluate.FUNCTIONS, **MORE, "text": lambda text: ONE * evaluate.code(text)}
