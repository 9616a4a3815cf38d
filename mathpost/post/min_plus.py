"""Least sums along a chain of choices: the min-plus product, in operations on whole arrays.

To come by the cheapest way to each of m choices at each of n records is to multiply a vector by n matrices, with
the minimum in the place of the sum and the sum in that of the product. That product is associative, so that
Bellman's recursion can be taken in pairs of pairs instead of record by record: the scan of G. E. Blelloch, "Prefix
sums and their applications" (1990).
"""

import numpy as np

FEW = 16  # choices up to which a product of matrices, m³ sums, takes less time than a call for each record


def least_sums(first, steps):
    """Return the least sums over all ways to each choice.

    Parameters
    ----------
    first : ndarray, shape (m,)
        What each choice costs so far.
    steps : ndarray, shape (m, m, n)
        What each step costs, from choice, to choice; infinite where it cannot be made.

    Returns
    -------
    ndarray, shape (m, n)

    Examples
    --------
    >>> stay_or_change = np.array([[0.0, 5.0], [5.0, 1.0]])
    >>> least_sums(np.array([0.0, 0.0]), np.stack([stay_or_change] * 7, axis=-1))
    array([[0., 0., 0., 0., 0., 0., 0.],
           [1., 2., 3., 4., 5., 5., 5.]])
    """
    choices, _, count = steps.shape
    if choices > FEW:
        return _record_by_record(first, steps)
    if count <= 1:
        return (first[:, None, None] + steps).min(axis=0)
    odd = least_sums(first, _product(steps[..., : count - 1 : 2], steps[..., 1::2]))
    sums = np.empty(steps.shape[1:], steps.dtype)
    sums[:, 1::2] = odd
    before = np.concatenate([first[:, None], odd], axis=1)[:, : (count + 1) // 2]
    sums[:, 0::2] = _least(before[:, None] + steps[..., 0::2])
    return sums


def _record_by_record(sums, steps):
    found = np.empty(steps.shape[1:], steps.dtype)
    for record in range(steps.shape[-1]):
        found[:, record] = sums = (sums[:, None] + steps[..., record]).min(axis=0)
    return found


def _product(before, after):
    """Min-plus products of matrices, shape (m, m, n) each."""
    least = before[:, 0, None] + after[0]
    for middle in range(1, len(after)):
        np.minimum(least, before[:, middle, None] + after[middle], out=least)
    return least


def _least(values):
    """The minimum along the first axis, which is short, over a last one that is long."""
    least = values[0]
    for value in values[1:]:
        least = np.minimum(least, value)
    return least


def first_least(values):
    """Return the place of the first minimum along the first axis, as small integers.

    Where nothing is finite the place is that of the result itself along its own first axis.

    Examples
    --------
    >>> first_least(np.array([[[3.0, 1.0], [np.inf, 1.0]], [[2.0, 1.0], [np.inf, 0.0]]]))
    array([[1, 0],
           [1, 1]], dtype=int8)
    """
    kind = _kind(len(values))
    place, least = np.zeros(values.shape[1:], kind), values[0]
    for index, value in enumerate(values[1:], 1):
        place = np.where(value < least, kind(index), place)
        least = np.minimum(least, value)
    return np.where(least < np.inf, place, stay(len(place), 1))


def stay(choices, count):
    """Return pointers, shape (choices, count), that keep the choice."""
    return np.repeat(np.arange(choices, dtype=_kind(choices))[:, None], count, axis=1)


def _kind(choices):
    return np.int8 if choices <= np.iinfo(np.int8).max else np.int16


def joined(pointers):
    """Return pointers of records in blocks, each (m, n) with its own m, as one array."""
    whole = stay(max(map(len, pointers)), sum(block.shape[1] for block in pointers))
    start = 0
    for block in pointers:
        whole[: len(block), start : start + block.shape[1]] = block
        start += block.shape[1]
    return whole


def walk(pointers, last):
    """Follow pointers, shape (m, n), from choice `last` of the last record back to the record before the first.

    Returns the choices of that record and the n others, shape (n + 1,), in their order. Takes time only where a
    choice points to one of another number, which is rare if numbers mean something.

    Examples
    --------
    >>> walk(np.array([[0, 1, 0, 0], [1, 1, 1, 0]]), 1)
    array([1, 1, 0, 0, 1])
    """
    choices, count = pointers.shape
    jumps = np.flatnonzero((pointers != stay(choices, 1)).any(axis=0))
    found = [int(last)]
    for row in pointers[:, jumps[::-1]].T.tolist():
        found.append(row[found[-1]])
    return np.repeat(found[::-1], np.diff(jumps, prepend=-1, append=count))
