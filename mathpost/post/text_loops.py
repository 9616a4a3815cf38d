"""Loops over the characters of large texts, as machine code: importing this module loads Numba.

`mathpost.post.digits` says what they are for; a small text it takes without them.
"""

import math

import numpy as np
from numba import njit

NEWLINE, RETURN, BLANK, POINT, MINUS, PLUS, ZERO, NINE = b"\n\r .-+09"
MOST_DIGITS = 18  # of a number that is read: its digits without the point are below 2**63
POWERS = np.array([10.0**power for power in range(MOST_DIGITS + 1)])  # exact, as all up to 10**22 are
EXACT = 2**53  # integers below are exact as floats, and so is one division of theirs by an exact power
LARGEST = 1e15  # last digits in a number that is written
TEN, NAUGHT = np.uint64(10), np.uint64(ZERO)  # without a sign: half of the time of a division with one

NOTHING, NUMBER, COUNT = range(3)  # what an item of a line holds behind its literal


def compiled(function):
    """Return the machine code of a function, made once for all sessions if there is a folder to keep it in."""
    try:
        return njit(cache=True, error_model="numpy")(function)
    except RuntimeError:  # neither here nor in the home folder
        return njit(error_model="numpy")(function)


@compiled
def match(text, upper, lower, sizes, kinds, optional, blanks, values, plain):
    """Put the numbers of the lines of `text` that fit a pattern into `values`, and which lines fit into `plain`.

    Literals are given in `upper` and, for either case, in `lower`. The text ends with the end of a line, which is
    in no literal and no number: nothing looks behind it.
    """
    at = 0
    for line in range(len(plain)):
        fits = True
        for item in range(len(sizes)):
            here, size, value = _skipped(text, at, blanks and item > 0), 0, 0.0
            while size < sizes[item] and (text[here] == upper[item, size] or text[here] == lower[item, size]):
                here, size = here + 1, size + 1
            found = size == sizes[item]
            if found and kinds[item] != NOTHING:
                here, value = _number(text, _skipped(text, here, blanks), kinds[item] == NUMBER)
                found = here > 0
            values[item, line] = value if found else math.nan
            if found:
                at = here
            elif not optional[item]:
                fits = False
                break
        at = _skipped(text, at, blanks)
        if text[at] == RETURN:
            at += 1
        plain[line] = fits and text[at] == NEWLINE
        while text[at] != NEWLINE:
            at += 1
        at += 1


@compiled
def _skipped(text, at, blanks):
    while blanks and text[at] == BLANK:
        at += 1
    return at


@compiled
def _number(text, at, with_sign_and_point):
    """Return where the number at this place ends, and what `float` makes of it; 0 and 0 if it is not plain."""
    negative = text[at] == MINUS
    if with_sign_and_point and (negative or text[at] == PLUS):
        at += 1
    first, value = at, 0
    while ZERO <= text[at] <= NINE:
        value = 10 * value + (text[at] - ZERO)
        at += 1
    digits, places = at - first, 0
    if with_sign_and_point and text[at] == POINT:
        at += 1
        first = at
        while ZERO <= text[at] <= NINE:
            value = 10 * value + (text[at] - ZERO)
            at += 1
        places = at - first
    if not 0 < digits + places <= MOST_DIGITS or value >= EXACT:
        return 0, 0.0
    size = value / POWERS[places]
    return at, -size if negative else size


@compiled
def write(out, literals, sizes, shown, values, decimals, plus, first):
    """Write lines into `out`, from number `first` on; return the number of the next line, and where `out` ends.

    A number has so many decimals, and none stands where they are negative; `plus` is the sign of one that is not
    negative, or 0. Stops before a line with a number that is not finite, too large, or in doubt as to its rounding.
    """
    at = 0
    for line in range(first, shown.shape[1]):
        start = at
        for item in range(len(sizes)):
            if not shown[item, line]:
                continue
            for character in literals[item, : sizes[item]]:
                out[at] = character
                at += 1
            if decimals[item] < 0:
                continue
            value = values[item, line]
            last = abs(value) * POWERS[decimals[item]]  # in units of the last digit
            if not last < LARGEST:
                return line, start
            whole = round(last)
            if abs(last - whole) == 0.5:  # the product is rounded, but never past a tie: only onto one
                return line, start
            sign = MINUS if math.copysign(1.0, value) < 0 else plus[item]
            if sign:
                out[at] = sign
                at += 1
            at = _written(out, at, np.uint64(whole), decimals[item])
    return shown.shape[1], at


@compiled
def _written(out, at, whole, decimals):
    """Write `whole`, a point before its last `decimals` digits if there are any, and return where that ends."""
    count, rest = 1, whole // TEN
    while rest:
        count, rest = count + 1, rest // TEN
    count = max(count, decimals + 1)
    end = at + count + (decimals > 0)
    at = end
    for behind in range(count):
        if 0 < behind == decimals:
            at -= 1
            out[at] = POINT
        at -= 1
        rest = whole // TEN
        out[at] = NAUGHT + (whole - TEN * rest)
        whole = rest
    return end
