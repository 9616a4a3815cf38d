"""Views of lessons 05 to 07: what they say at the start, against the kinematics and the selection."""

import re

import numpy as np
import pytest

from mathpost.course import view_path
from mathpost.course.lesson_data import load, with_travel
from mathpost.post import selection
from tests.course.test_calibration_views import numbers


def said(view):
    """The numbers of a view at its start."""
    return [float(number) for number in re.findall(r"-?\d+\.\d+", repr(view))]


@pytest.mark.parametrize("angles", [(50, 125), (-50, 125), (20, -170)])
def test_inner_and_outer_print_the_tool_axis_and_find_the_outer_angle(angles):
    kin = load("ac_table")
    _, axis = kin.forward([0, 0, 0, *angles], degrees=True)
    *components, _sine, _cosine, outer = numbers(view_path.inner_and_outer(kin), *angles[::-1])
    assert components == pytest.approx(axis, abs=1e-12)
    assert outer == pytest.approx(angles[1], abs=1e-9)


def test_past_the_pole_both_branches_keep_their_outer_angles_half_a_turn_apart(kin):
    if kin.reach[0] > 0:
        pytest.skip("does not apply: the branches of this machine do not meet at the pole")
    view = view_path.past_the_pole(kin)
    inner = kin.symbols.index(kin.inverse_symbolic.inner) - 3
    for frame in view.state["frames"]:
        curves = np.array(frame, dtype=float).reshape(2, 2, -1)
        assert np.ptp(curves[1 - inner, 0] - curves[1 - inner, 1]) < 30  # neither has been unwrapped differently
        assert (curves[inner, 0] > curves[inner, 1]).all()
    assert len(view.page()) < 200_000


def test_the_travel_limit_says_what_each_strategy_costs(dmu50v, blade):
    view = view_path.travel_limit(dmu50v, blade, range(5), 110)
    limited = with_travel(dmu50v, -5, 110)
    costs = [selection.choose(limited, blade, way, sway=np.inf).cost for way in selection.STRATEGIES]
    assert said(view) == pytest.approx(
        [*costs, selection.choose(limited, blade, sway=view_path.KEPT).cost], abs=1e-3
    )
