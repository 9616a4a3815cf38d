"""The views of lessons 06 and 06b say what is computed another way."""

import numpy as np
import pytest
from scipy.interpolate import CubicHermiteSpline

from mathpost.course import view_path
from mathpost.post import selection
from mathpost.post.ways import Crossing


def numbers(view):
    """The numbers that a view says at its start."""
    words = repr(view).replace("°", " ").replace(",", " ").replace(";", " ").replace(":", " ").split()
    return [float(word) for word in words if word.replace(".", "").replace("-", "").isdigit()]


def test_globe():
    """The longitude of a point that is turned about X and Y, and its change by differences."""

    def longitude(tilt):
        tilt, distance = np.radians([tilt, 4.0])
        east, north = np.sin(tilt), np.cos(tilt) * np.sin(distance)
        return np.degrees(np.arctan2(north, east))

    said = numbers(view_path.globe())
    change = (longitude(-12.0) - longitude(-12.001)) / 0.001
    assert said[0] == pytest.approx(longitude(-12.0), abs=0.005)
    assert said[1] == pytest.approx(abs(change), abs=0.005) and said[2] == pytest.approx(10 * abs(change), abs=0.05)
    assert said[3] == pytest.approx(abs(longitude(0.001) - longitude(-0.001)) / 0.002, abs=0.005)


def test_pass_by():
    fastest, follows = numbers(view_path.pass_by(120))
    assert fastest == pytest.approx(20 / np.sin(np.radians(4)), abs=0.5)
    assert np.sin(np.radians(follows)) == pytest.approx(20 / 120, abs=1e-4)


def test_clamped():
    rows = np.array([20.0, 24.0, 150.0, 153.0])
    curve = CubicHermiteSpline([0, 1], rows[1:3], [4, 3])
    said = numbers(view_path.clamped(rows))
    np.testing.assert_allclose(said, [4, 3, curve(0.3), curve(0.3, 1)], atol=0.005)


def test_moved_aside_and_smoothed(dmu50v, blade):
    joints = selection.choose(dmu50v, blade).joints
    crossing = Crossing(dmu50v, blade, joints, (1, 2))
    way = crossing.way("aside", lean=np.radians(1.0))
    assert f"{way.time:.2f} s" in repr(view_path.moved_aside(crossing, most=1.5))
    assert "n = 5: the tip is off by up to 5.5" in repr(view_path.smoothed(dmu50v, blade, joints, (1, 2), most=6))
