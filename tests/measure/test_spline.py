"""Splines through chosen knots: the published-like curve, periodicity, and points that cannot be a curve."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import CubicSpline

from mathpost.errors import InputError, ReachError
from mathpost.shop.measure import spline

FINE = np.arange(0, 360, 0.1)


def published_like(degrees):
    t = np.deg2rad(degrees)
    bump = np.exp(20 * (np.cos(t - np.deg2rad(203)) - 1))
    return 12 * np.sin(t) + 4 * np.cos(2 * t) + 8 * bump + np.sin(5 * t)


@pytest.fixture(scope="module")
def measured():
    angles = np.arange(0, 360, 10.0)
    return spline.points(angles, published_like(angles), period=360)


def off_data(fitted):
    return np.abs(fitted(FINE) - published_like(FINE)).max()


@pytest.mark.parametrize(
    ("tolerance", "knots", "at_data", "between"),
    [
        (2, 6, 1.85615, 1.91660),
        (1, 12, 0.914458, 0.936043),
        (0.5, 14, 0.395295, 0.405845),
        (0.1, 21, 0.0712970, 0.0727154),
    ],
)
def test_adaptive_knots_of_the_published_like_curve(measured, tolerance, knots, at_data, between):
    fitted = spline.adaptive(measured, tolerance)
    assert len(fitted.knots) == knots
    assert fitted.residual == pytest.approx(at_data, rel=5e-6)
    assert off_data(fitted) == pytest.approx(between, rel=5e-6)


def test_adaptive_knots_come_in_the_order_of_the_largest_residual(measured):
    order = measured.at[list(spline.adaptive(measured, 0.5).knots)]
    assert order.tolist() == [0, 120, 240, 200, 180, 150, 220, 270, 300, 90, 60, 20, 340, 170]


@pytest.mark.parametrize(("count", "between"), [(6, 5.64602), (12, 1.88674), (18, 0.470873)])
def test_uniform_knots_of_the_published_like_curve(measured, count, between):
    assert off_data(spline.uniform(measured, count)) == pytest.approx(between, rel=3e-6)


@pytest.mark.parametrize("tolerance", [2, 1, 0.5, 0.1])
def test_uniform_knots_need_more(measured, tolerance):
    uniform = next(n for n in (3, 4, 6, 9, 12, 18, 36) if spline.uniform(measured, n).residual <= tolerance)
    assert len(spline.adaptive(measured, tolerance).knots) < uniform


def test_more_knots_may_be_worse(measured):
    order = spline.adaptive(measured, 1).knots
    six, ten = (spline.Curve(measured, order[:count]).residual for count in (6, 10))
    assert (six, ten) == pytest.approx((1.856, 2.367), abs=5e-4)


def test_what_happens_between_the_measured_points_is_invisible(measured):
    angles = measured.at
    with_ripple = spline.points(angles, published_like(angles) + 0.4 * np.sin(18 * np.deg2rad(angles)), period=360)
    fitted = spline.through_all(with_ripple)
    assert fitted.residual < 1e-12
    truth = published_like(FINE) + 0.4 * np.sin(18 * np.deg2rad(FINE))
    assert np.abs(fitted(FINE) - truth).max() == pytest.approx(0.4426, abs=5e-5)


@given(st.integers(4, 60), st.integers(0, 10_000), st.floats(0.01, 5))
def test_periodic_in_value_slope_and_curvature(count, seed, tolerance):
    rng = np.random.default_rng(seed)
    at = np.sort(rng.choice(720, count, replace=False)) / 2.0
    fitted = spline.adaptive(spline.points(at, rng.normal(size=count), period=360), tolerance)
    assert fitted.residual <= tolerance
    place = rng.uniform(-720, 720, 5)
    assert fitted(place + 360) == pytest.approx(fitted(place), abs=1e-9)
    joint = fitted.points.at[min(fitted.knots)]
    for derivative in (1, 2):
        before, after = fitted.spline(np.array([joint + 359.9999999, joint]), derivative)
        assert before == pytest.approx(after, rel=1e-5, abs=1e-4)


def test_an_open_curve_is_scipys_and_ends_where_the_measurement_ends():
    at = np.arange(-110.0, 111, 10)
    values = np.cos(at / 40)
    fitted = spline.through_all(spline.points(at, values))
    place = np.linspace(-110, 110, 57)
    assert fitted(place) == pytest.approx(CubicSpline(at, values)(place), abs=1e-14)
    assert spline.adaptive(spline.points(at, values), 0.01).residual <= 0.01
    with pytest.raises(ReachError, match=r"110.5 was not measured: -110 to 110 was"):
        fitted([0, 110.5])


def test_a_turn_that_does_not_close_is_averaged_and_said():
    measured = spline.points([0, 120, 240, 360], [1, 2, 3, 1.5], period=360)
    assert measured.closure == 0.5
    assert measured.values.tolist() == [1.25, 2, 3]


@pytest.mark.parametrize(
    ("at", "period", "message"),
    [
        ([0, 20, 10], None, "10 after 20, out of order"),
        ([0, 10, 10], None, "10 after 10, a duplicate"),
        ([0, 200, 400], 360, "at most one period of 360"),
        ([0, 360], 360, "at least 3 different"),
        ([0], None, "at least 2 different"),
    ],
)
def test_points_that_make_no_curve(at, period, message):
    with pytest.raises(InputError, match=message):
        spline.points(at, np.zeros(len(at)), period=period)


def test_knots_that_cannot_be_chosen(measured):
    with pytest.raises(InputError, match=r"one of 3, 4, 6, 9, 12, 18, 36, which divide 36 points, found 10"):
        spline.uniform(measured, 10)
    with pytest.raises(InputError, match="above 0"):
        spline.adaptive(measured, 0)
