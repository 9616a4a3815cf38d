"""The scan, the places of minima and the pointers, against plain loops."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mathpost.post import min_plus

seeds, sizes = st.integers(0, 2**32 - 1), st.integers(1, 40)


def random_steps(rng, choices, count, share=0.3):
    """Whole numbers, some of them infinite, none of them where a record would be out of reach."""
    steps = rng.integers(0, 50, (choices, choices, count)).astype(float)
    steps[rng.random(steps.shape) < share] = np.inf
    return steps


@given(seeds, st.sampled_from([1, 2, 3, 5, min_plus.FEW, min_plus.FEW + 1]), sizes)
def test_least_sums_are_those_of_the_recursion(seed, choices, count):
    rng = np.random.default_rng(seed)
    first, steps = rng.integers(0, 9, choices).astype(float), random_steps(rng, choices, count)
    expected, sums = [], first
    for record in range(count):
        sums = (sums[:, None] + steps[..., record]).min(axis=0)
        expected.append(sums)
    np.testing.assert_array_equal(min_plus.least_sums(first, steps), np.transpose(expected))


@given(seeds, st.integers(1, 5), st.integers(1, 5), sizes)
def test_the_first_of_equals_is_taken(seed, choices, places, count):
    values = np.random.default_rng(seed).integers(0, 3, (choices, places, count)).astype(float)
    values[..., ::3] = np.inf
    found = min_plus.first_least(values)
    expected = np.where(np.isfinite(values.min(axis=0)), values.argmin(axis=0), np.arange(places)[:, None])
    np.testing.assert_array_equal(found, expected)


@given(seeds, st.integers(1, 5), sizes, st.booleans())
def test_a_walk_follows_every_pointer(seed, choices, count, mostly_stay):
    rng = np.random.default_rng(seed)
    pointers = rng.integers(0, choices, (choices, count))
    if mostly_stay:
        pointers = np.where(rng.random(count) < 0.8, min_plus.stay(choices, count), pointers)
    path = [int(rng.integers(choices))]
    for record in range(count - 1, -1, -1):
        path.append(pointers[path[-1], record])
    np.testing.assert_array_equal(min_plus.walk(pointers, path[0]), path[::-1])


def test_joined_pointers_stay_where_a_block_had_fewer_choices():
    blocks = np.array([[0, 0]], np.int8), np.array([[1, 1], [0, 0], [2, 1]], np.int8)
    np.testing.assert_array_equal(min_plus.joined(blocks), [[0, 0, 1, 1], [1, 1, 0, 0], [2, 2, 2, 1]])


@pytest.mark.parametrize(("choices", "kind"), [(127, np.int8), (128, np.int16)])
def test_pointers_take_a_byte_where_that_is_enough(choices, kind):
    assert min_plus.stay(choices, 1).dtype == kind
    assert min_plus.first_least(np.zeros((choices, 1, 1))).dtype == kind
