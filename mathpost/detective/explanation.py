"""What the detective answers: readings that give a number, and the precision to which a number was written."""

from dataclasses import dataclass
from decimal import Decimal, InvalidOperation

import numpy as np

from mathpost.errors import InputError

CHANCE = 0.005  # how probable an accidental match may be before it explains nothing
FAR_FETCHED = 1.0  # readings so much more complicated than the simplest one are not shown
UNROUNDED = "unrounded"  # the kind of slip that is none: more digits of the input were used than are given


@dataclass(frozen=True)
class Reading:
    """One reading that gives the answer.

    Attributes
    ----------
    sentence : str
        What was misread, as in "the final transpose is missing".
    product : str
        The matrix product: E is a passive elementary matrix, R an active one, p the point.
    kinds : tuple of str
        The kinds of slip, such as ``("transpose",)``; empty for the right reading.
    value : ndarray
        What the reading gives, in the shape of the answer.
    same : tuple of str
        Other wordings of the identical product, with their products.
    cost : float
        How much has to be misread: about one for each slip.
    """

    sentence: str
    product: str
    kinds: tuple
    value: np.ndarray
    same: tuple
    cost: float

    def __str__(self):
        return f"{self.sentence}: {self.product}"


@dataclass(frozen=True)
class Explanation:
    """What `explain` found.

    Attributes
    ----------
    readings : tuple of Reading
        Those that give the answer, the simplest first; empty if none does.
    tolerance : float
        How far a reading may be from the answer: half of the last digit written.
    tried : int
        How many readings were compared with it.
    note : str
        How to tell several readings apart, or what is known if none fits.
    """

    readings: tuple
    tolerance: float
    tried: int
    note: str = ""

    @property
    def explained(self):
        """Whether any reading gives the answer."""
        return bool(self.readings)

    @property
    def right(self):
        """Whether the right reading gives the answer, be it with more digits of the angles than are given."""
        return self.explained and set(self.readings[0].kinds) <= {UNROUNDED}

    def __str__(self):
        lines = list(map(str, self.readings)) or [f"No reading explains it ({self.tried} were tried)."]
        return "\n".join([*lines, self.note] if self.note else lines)


def written_decimals(values):
    """Return the greatest number of digits after the point that any of `values` (strings or numbers) shows.

    Of a float thirteen digits count, so that the rounding of a sum such as 35.707 + 360 does not.

    Examples
    --------
    >>> written_decimals(["1.50", 2]), written_decimals([0.1, 1e-7, 3.0])
    (2, 7)
    """
    return max(map(_decimals, np.asarray(values, dtype=object).ravel()), default=0)


def _decimals(value):
    if not isinstance(value, str) and float(value).is_integer():
        return 0
    try:
        return max(
            0,
            -Decimal(value.strip() if isinstance(value, str) else repr(float(f"{value:.13g}"))).as_tuple().exponent,
        )
    except InvalidOperation:
        raise InputError("answer", "numbers", repr(value)) from None
