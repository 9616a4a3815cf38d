"""The package's own errors, and the check of a caller's arrays."""

from __future__ import annotations

import re
import traceback
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import ArrayLike

INTERNAL = "internal error, please report"


class MathpostError(ValueError):
    """Every error that mathpost raises on purpose."""

    def __init__(self, message: str) -> None:
        super().__init__("\n".join(map(one_line, message.split("\n"))))


class InputError(MathpostError):
    """Something given to mathpost is wrong: `where` (file and line or key, cell, argument), what was expected there
    and what was found, all str.
    """

    def __init__(self, where: str, expected: str, found: str | None) -> None:
        self.where, self.expected, self.found = one_line(where), expected, found
        super().__init__(f"{self.where}: expected {expected}, found {found}")


class ReachError(MathpostError):
    """The machine cannot go there: the tool axis is out of reach or a joint out of travel."""


class OutputError(MathpostError):
    """A result could not be written; nothing was."""


def one_line(text: str) -> str:
    """Return a text from outside, such as the name of a file, as one line that a terminal shows as it is.

    Control characters and bytes that are not UTF-8 are escaped.

    Examples
    --------
    >>> print(one_line("part\\n1.cl"))
    part\\n1.cl
    """
    return re.sub(r"[\x00-\x1f\x7f-\x9f\u2028\u2029\ud800-\udfff]", lambda found: repr(found[0])[1:-1], text)


def internal(error: Exception) -> str:
    """Return an error that nobody foresaw in one line, with the place where it arose."""
    place = traceback.extract_tb(error.__traceback__)[-1]
    said = one_line(f"{type(error).__name__}: {error}"[:300])
    return f"{INTERNAL}: {said} ({Path(place.filename).name}, line {place.lineno})"


def as_array(values: ArrayLike, length: int, where: str) -> np.ndarray:
    """Return `values` as a float array of shape ``(..., length)``, all finite, or raise `InputError`."""
    import numpy as np  # here, as the shell has errors before it needs arrays

    if np.any(getattr(values, "mask", False)):  # as np.ma would say, which takes long to load
        raise InputError(where, "numbers", "masked ones")
    try:
        array = np.asarray(values, dtype=float)
    except (TypeError, ValueError, OverflowError):
        raise InputError(where, f"numbers of shape (..., {length})", repr(values)) from None
    if array.ndim == 0 or array.shape[-1] != length:
        raise InputError(where, f"shape (..., {length})", f"shape {array.shape}")
    finite = np.isfinite(array)
    if not finite.all():
        index = tuple(map(int, np.argwhere(~finite)[0]))
        raise InputError(where, "finite numbers", f"{array[index]} at index {index}")
    return array
