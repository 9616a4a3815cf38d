"""The precision of a written number, from its digits; and numbers in a row."""

from collections.abc import Iterable
from decimal import Decimal, InvalidOperation

import numpy as np
from numpy.typing import ArrayLike

from mathpost.errors import InputError


def written_decimals(values: ArrayLike) -> int:
    """Return the greatest number of digits after the point that any of `values` (strings or numbers) shows.

    Thirteen digits of a float count, so that rounding in a sum such as 35.707 + 360 does not.
    """
    most = 0
    for value in np.asarray(values, dtype=object).ravel():
        text = value.strip() if isinstance(value, str) else repr(float(f"{float(value):.13g}")).removesuffix(".0")
        try:
            exponent = Decimal(text).as_tuple().exponent
        except InvalidOperation:
            exponent = "n"
        if not isinstance(exponent, int):  # a letter, if the value is infinite or not a number
            raise InputError("answer", "finite numbers", repr(value))
        most = max(most, -exponent)
    return most


def half_digit(values: ArrayLike) -> float:
    """Return half of the last digit of decimal fractions; 0 for whole numbers and full floats: those are exact."""
    decimals = written_decimals(values)
    return 0.5 * 10.0**-decimals if 0 < decimals < 9 else 0.0


def row(values: Iterable[float], decimals: int = 4, width: int = 0) -> str:
    """Return numbers as text, one behind the other."""
    return " ".join(f"{f'{value:z.{decimals}f}':>{width}}" for value in values)
