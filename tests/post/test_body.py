"""The body of a tool in a box of slides: against a dense sample of places and points."""

from itertools import product

import numpy as np
import pytest

from mathpost.shop.post.body import ABOVE, BODY, Body


def deepest(axis, length, ends, lines):
    """How far inside the cylinder, mm, a point of the lines comes from a grid of places of the tip."""
    grid = np.array(list(product(*np.linspace(ends[0], ends[1], 9).T)))
    points = np.concatenate([lines[0] + t * (lines[1] - lines[0]) for t in np.linspace(0, 1, 25)])
    off = points[:, None] - grid
    along = off @ axis
    beside = np.linalg.norm(np.cross(off, axis), axis=-1)
    return np.minimum(BODY - beside, np.minimum(along - ABOVE, length - along)).max()


@pytest.mark.parametrize("seed", range(2))
def test_what_is_clear_meets_no_line(seed):
    rng, seen = np.random.default_rng(seed), []
    for _ in range(100):
        axis = rng.normal(size=3)
        axis /= np.linalg.norm(axis)
        length = rng.choice([12.0, 60.0])
        body = Body(axis, length)
        ends = rng.uniform(-8, 8, 3) + np.array([np.zeros(3), rng.uniform(-15, 15, 3)])
        starts = rng.uniform(-45, 45, (4, 3))
        lines = np.array([starts, starts + rng.uniform(-20, 20, (4, 3))])
        near = lines[:, body.near(ends, lines.min(axis=0).T, lines.max(axis=0).T)]
        clear, sure, depth = (
            not body.meets(ends, near).any(),
            bool(body.surely_meets(ends, near).any()),
            deepest(axis, length, ends, lines),
        )
        assert not (clear and depth > 0)
        assert not (sure and depth < -1.5)  # between the places of the grid
        seen.append((clear, sure, depth > 0))
    assert {(True, False, False), (False, True, True)} <= set(seen)
    assert np.mean([clear or hit for clear, _, hit in seen]) > 0.85  # the few directions part nearly all
