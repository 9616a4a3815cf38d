"""Readings that several tests share."""

import numpy as np
import pytest

from mathpost.shop.measure import angular_error


@pytest.fixture
def example():
    """The example of four targets whose statistics were computed by hand."""
    spread = np.array([-0.4, -0.2, 0, 0.2, 0.4])
    up = np.array([1, 10, -6, 3])[:, None] + spread
    down = np.array([0, 8.5, -7.2, 2.5])[:, None] + spread / 2
    return angular_error.from_arrays([0, 90, 180, 270], up, down)
