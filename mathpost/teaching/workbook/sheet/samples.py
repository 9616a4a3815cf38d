"""Values at many inputs at once: the first sample is the sheet's own, at the others the inputs are random."""

from __future__ import annotations

import numpy as np

from mathpost.teaching.workbook.sheet.place import Place

SAMPLES = 8
CLOSE = 5e-8  # relative: what the arithmetic of a spreadsheet and π/180 as 0.0174532925 lose
Values = dict[Place, np.ndarray]  # of shape (samples,)


def at_samples(value: np.ndarray) -> np.ndarray:
    """A value at every sample, shape (samples,)."""
    return value if len(value) == SAMPLES else np.broadcast_to(value, SAMPLES)


def at(array: np.ndarray, index: tuple[int, int]) -> np.ndarray:
    """The entry of an array formula's value in one of its cells; a single row or column is repeated."""
    row, column = (i if size > 1 else 0 for i, size in zip(index, array.shape[1:], strict=True))
    inside = row < array.shape[1] and column < array.shape[2]
    return array[:, row, column] if inside else np.full(len(array), np.nan)


def same(a: np.ndarray, b: np.ndarray, tolerance: float = CLOSE) -> bool:
    """Whether two values agree at every sample; at the first, the sheet's own, either may be unknown, NaN."""
    last_a, last_b = (np.asarray(values).item(-1) for values in (a, b))
    if abs(last_a - last_b) > tolerance * (1 + abs(last_b)):  # most that differ do here, and it costs least
        return False
    fine = np.abs(a - b) <= tolerance * (1 + np.minimum(np.abs(a), np.abs(b)))  # no number is close to infinity
    if len(fine) == 1 or not fine[1:].all():
        return bool(fine.all())
    return bool((fine[0] | ~np.isfinite((a + b)[0])).all())
