"""The package's own errors, and the one check that turns a caller's numbers into an array."""

import numpy as np


class MathpostError(ValueError):
    """Every error that mathpost raises on purpose."""


class InputError(MathpostError):
    """Something given to mathpost is wrong.

    Parameters
    ----------
    where : str
        The place: file and line, file and key, cell, or argument name.
    expected, found : str
        What should stand there and what does.
    """

    def __init__(self, where, expected, found):
        self.where, self.expected, self.found = where, expected, found
        super().__init__(f"{where}: expected {expected}, found {found}")


class ReachError(MathpostError):
    """The machine cannot go there: the tool axis is out of reach or a joint out of travel."""


class OutputError(MathpostError):
    """A result could not be written; nothing was."""


def as_array(values, length, where, *, check=True):
    """Return `values` as a float array of shape ``(..., length)``, or raise `InputError`.

    Without `check` the numbers may be infinite or NaN: the caller looks at them with `finite`, block by block.

    Examples
    --------
    >>> as_array([1, 2, 3], 3, "tip")
    array([1., 2., 3.])
    >>> as_array([1, float("nan"), 3], 3, "tip")
    Traceback (most recent call last):
        ...
    mathpost.errors.InputError: tip: expected finite numbers, found nan at index (1,)
    """
    try:
        array = np.asarray(values, dtype=float)
    except (TypeError, ValueError):
        raise InputError(where, f"numbers of shape (..., {length})", repr(values)) from None
    if array.ndim == 0 or array.shape[-1] != length:
        raise InputError(where, f"shape (..., {length})", f"shape {array.shape}")
    if check and not finite(array):
        index = tuple(int(n) for n in np.argwhere(~np.isfinite(array))[0])
        raise InputError(where, "finite numbers", f"{array[index]} at index {index}")
    return array


def finite(array):
    """Whether all is finite, told from sums, which take no memory; one that overflows asks for a closer look."""
    parts = [array] if array.flags.c_contiguous else [array[..., n] for n in range(array.shape[-1])]
    with np.errstate(over="ignore", invalid="ignore"):
        return all(np.isfinite(part.sum()) for part in parts) or bool(np.isfinite(array).all())
