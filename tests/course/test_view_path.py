"""Views of lessons 05 to 07: what they say at the start, against the kinematics, the selection, and other ways."""

import re

import numpy as np
import pytest
from scipy.interpolate import CubicHermiteSpline

from mathpost.path import selection
from mathpost.shop.post.ways import Crossing
from mathpost.teaching.course import view_globe, view_path
from mathpost.teaching.course.lesson_data import load, with_travel
from tests.course.test_view_calibration import numbers


def said(view):
    """The numbers of a view at its start."""
    return [float(number) for number in re.findall(r"-?\d+\.\d+", repr(view))]


@pytest.mark.parametrize("angles", [(50, 125), (-50, 125), (20, -170)])
def test_both_angles_print_the_tool_axis_and_find_the_workpiece_side_angle(angles):
    kin = load("ac_table")
    _, axis = kin.forward([0, 0, 0, *angles], degrees=True)
    *components, _sine, _cosine, workpiece_side = numbers(view_path.both_angles(kin), *angles[::-1])
    assert components == pytest.approx(axis, abs=1e-12)
    assert workpiece_side == pytest.approx(angles[1], abs=1e-9)


def test_past_the_pole_both_branches_keep_their_workpiece_side_angles_half_a_turn_apart(kin):
    if kin.reach[0] > 0:
        pytest.skip("does not apply: the branches of this machine do not meet at the pole")
    view = view_path.past_the_pole(kin)
    tool_side = kin.symbols.index(kin.inverse_symbolic.tool_side) - 3
    for frame in view.state["frames"]:
        curves = np.array(frame, dtype=float).reshape(2, 2, -1)
        assert (
            np.ptp(curves[1 - tool_side, 0] - curves[1 - tool_side, 1]) < 30
        )  # neither has been unwrapped differently
        assert (curves[tool_side, 0] > curves[tool_side, 1]).all()
    assert len(view.page()) < 200_000


def test_the_travel_limit_says_what_each_strategy_costs(dmu50v, blade):
    view = view_path.travel_limit(dmu50v, blade, range(5), 110)
    limited = with_travel(dmu50v, -5, 110)
    costs = [selection.choose(limited, blade, way, sway=np.inf).cost for way in selection.STRATEGIES]
    assert said(view) == pytest.approx(
        [*costs, selection.choose(limited, blade, sway=view_path.KEPT).cost], abs=1e-3
    )


def spoken(view):
    """The numbers that a view says at its start."""
    words = repr(view).replace("°", " ").replace(",", " ").replace(";", " ").replace(":", " ").split()
    return [float(word) for word in words if word.replace(".", "").replace("-", "").isdigit()]


def test_globe():
    """The longitude of a point that is turned about X and Y, and its change by differences."""

    def longitude(tilt):
        tilt, distance = np.radians([tilt, 4.0])
        east, north = np.sin(tilt), np.cos(tilt) * np.sin(distance)
        return np.degrees(np.arctan2(north, east))

    said = spoken(view_globe.globe())
    change = (longitude(-12.0) - longitude(-12.001)) / 0.001
    assert said[0] == pytest.approx(longitude(-12.0), abs=0.005)
    assert said[1] == pytest.approx(abs(change), abs=0.005) and said[2] == pytest.approx(10 * abs(change), abs=0.05)
    assert said[3] == pytest.approx(abs(longitude(0.001) - longitude(-0.001)) / 0.002, abs=0.005)


def test_pass_by():
    fastest, follows = spoken(view_path.pass_by(120))
    assert fastest == pytest.approx(20 / np.sin(np.radians(4)), abs=0.5)
    assert np.sin(np.radians(follows)) == pytest.approx(20 / 120, abs=1e-4)


def test_clamped():
    rows = np.array([20.0, 24.0, 150.0, 153.0])
    curve = CubicHermiteSpline([0, 1], rows[1:3], [4, 3])
    said = spoken(view_path.clamped(rows))
    np.testing.assert_allclose(said, [4, 3, curve(0.3), curve(0.3, 1)], atol=0.005)


def test_moved_aside_and_smoothed(dmu50v, blade, monkeypatch):
    monkeypatch.setattr(view_path, "MOST_POINTS", 6)
    monkeypatch.setattr(view_path, "MOVED_MOST", 1.5)
    joints = selection.choose(dmu50v, blade).joints
    crossing = Crossing(dmu50v, blade, joints, (1, 2))
    way = crossing.way("aside", lean=np.radians(1.0))
    assert f"{way.time:.2f} s" in repr(view_path.moved_aside(crossing))
    assert "n = 5: the tip is off by up to 5.5" in repr(view_path.smoothed(dmu50v, blade, joints, (1, 2)))


def test_virtual_time(dmu50v, blade):
    """At Δt = 1 what the way says; at 0.5 and 2 what dense sampling found, and B below zero at 0.5."""
    joints = selection.choose(dmu50v, blade).joints
    view = view_path.virtual_time(dmu50v, blade, joints, (1, 2))
    way = Crossing(dmu50v, blade, joints, (1, 2)).way("cubic")
    _, off, seconds = said(view)
    assert off == pytest.approx(np.degrees(way.axis_error), abs=0.006)
    assert seconds == pytest.approx(way.time, abs=0.06)  # more blocks, other corners
    spoken = [line for (line,) in view.state["said"]]
    assert len(spoken) == 400
    assert "least B -0.20°, tool axis off by 0.57°" in spoken[20 * 4 + 4] and "off by 1.95°" in spoken[-1]
    assert "off by 0.35°" in spoken[20 * 2 + 16], "Δt₁ = 0.3, Δt₂ = 1.7: the last slider runs fastest"
