"""Recursive least squares: against the batch solution, its stated covariance, liars, and real changes."""

import numpy as np
import pytest

from mathpost import load_machine
from mathpost.errors import InputError
from mathpost.shop.compensate.drift import Tracker
from mathpost.shop.compensate.model import ErrorModel

NAMES = ("EYA", "EZA", "EXC", "EYC", "ECC")
TRUE = np.array([0.020, -0.030, 0.012, -0.008, 40e-6])
SIZES = [0.05, 0.05, 0.05, 0.05, 2e-4]
POSES = [
    [0, 0, 0, 0, 0],
    [60, 10, 0, 0, 1.5],
    [60, 10, 20, 0.6, 3.0],
    [-40, 30, 20, -0.6, -1.0],
    [20, 50, 0, 1.2, 4.0],
]


@pytest.fixture(scope="module")
def trunnion():
    return ErrorModel(load_machine("data/machines/ac_table.toml"))


def tracker(model, **settings):
    return Tracker(model, NAMES, POSES, **{"sigma": 0.001, "expected": SIZES, "forgetting": 1.0} | settings)


def test_it_is_the_batch_solution(trunnion):
    rng, tracked = np.random.default_rng(1), tracker(trunnion)
    readings = [tracked.predict(TRUE) + rng.normal(0, 0.001, (5, 3)) for _ in range(7)]
    for part in readings:
        assert not tracked.update(part).set_aside.any()
    rows, prior = np.tile(tracked.design, (7, 1)) / 0.001, np.diag(1 / np.array(SIZES) ** 2)
    normal = rows.T @ rows + prior
    np.testing.assert_allclose(tracked.covariance, np.linalg.inv(normal), rtol=1e-7)
    batch = np.linalg.solve(normal, rows.T @ np.ravel(readings) / 0.001)
    np.testing.assert_allclose(tracked.values, batch, rtol=0, atol=1e-10)


def test_without_noise_it_is_exact(trunnion):
    tracked = tracker(trunnion, sigma=1e-9)
    for _ in range(3):
        tracked.update(tracked.predict(TRUE))
    np.testing.assert_allclose(tracked.values, TRUE, rtol=0, atol=1e-12)


def test_the_stated_covariance_is_the_observed_one(trunnion):
    rng, misses = np.random.default_rng(2), []
    for _ in range(1000):
        tracked = tracker(trunnion, gate=np.inf)
        true = rng.normal(size=5) * SIZES
        tracked.update(tracked.predict(true) + rng.normal(0, 0.001, (5, 3)))
        misses.append(tracked.values - true)
    stated = np.sqrt(np.diag(tracked.covariance))
    assert ((np.abs(misses) < 3 * stated).mean(axis=0) >= 0.99).all()
    np.testing.assert_allclose(np.std(misses, axis=0), stated, rtol=0.1)


def test_a_sensor_that_lies_once_is_not_believed(trunnion):
    rng, believed, doubting = np.random.default_rng(3), tracker(trunnion, gate=np.inf), tracker(trunnion)
    for part in range(12):
        readings = believed.predict(TRUE) + rng.normal(0, 0.001, (5, 3))
        if part == 8:
            readings[2, 1] += 0.1
        believed.update(readings)
        update = doubting.update(readings)
        assert update.set_aside.sum() == (part == 8) and update.set_aside[2, 1] == (part == 8)
        assert not update.changed
    assert np.abs(doubting.values - TRUE)[:4].max() < 0.001 < np.abs(believed.values - TRUE)[:4].max()


def test_a_sensor_that_lies_at_once_is_not_believed_either(trunnion):
    tracked = tracker(trunnion)
    readings = tracked.predict(TRUE)
    readings[1, 2] += 0.2
    assert tracked.update(readings).set_aside.sum() == 1
    assert np.abs(tracked.values - TRUE)[:4].max() < 1e-3


def test_when_all_say_the_same_the_machine_has_changed(trunnion):
    rng, tracked = np.random.default_rng(4), tracker(trunnion, forgetting=0.7)
    for part in range(10):
        true = TRUE + (part >= 6) * np.array([0.05, 0.06, -0.04, 0.05, 0])
        update = tracked.update(tracked.predict(true) + rng.normal(0, 0.001, (5, 3)))
        assert update.changed == (part == 6)
    assert np.abs(tracked.values - true)[:4].max() < 2e-3


def test_forgetting_follows_a_drift(trunnion):
    slow, fast = tracker(trunnion), tracker(trunnion, forgetting=0.5)
    for part in range(30):
        true = TRUE * (1 - np.exp(-part / 8))
        for tracked in (slow, fast):
            tracked.update(tracked.predict(true))
    assert np.abs(fast.values - true)[:4].max() < 5e-4 < 2e-3 < np.abs(slow.values - true)[:4].max()


def test_readings_of_a_corrected_part(trunnion):
    open_loop, closed_loop = tracker(trunnion), tracker(trunnion)
    for _ in range(3):
        open_loop.update(open_loop.predict(TRUE))
        closed_loop.update(closed_loop.predict(TRUE - closed_loop.values), corrected=closed_loop.values)
    np.testing.assert_allclose(closed_loop.values, open_loop.values, rtol=0, atol=1e-12)
    assert closed_loop.drift()[trunnion.names.index("EZA")] == closed_loop.values[1]
    assert np.count_nonzero(closed_loop.drift()) == 5


@pytest.mark.parametrize(
    ("names", "poses", "message"),
    [
        (("EYA", "EYC"), POSES[:1], r"tell EYA and EYC apart \(moving A too would\)"),
        (("EXX", "EXA"), POSES, r"tell EXX and EXA apart \(no other position of one joint would\)"),
        (("ECC",), [[0, 0, 0, 0, 0]], r"determine ECC \(moving X or Y or A too would\)"),
        (NAMES, POSES[:1], r"apart"),
    ],
)
def test_poses_that_cannot_tell(trunnion, names, poses, message):
    with pytest.raises(InputError, match=message):
        Tracker(trunnion, names, poses, sigma=0.001, expected=0.05)


def test_settings_that_are_refused(trunnion):
    for settings in ({"forgetting": 0}, {"forgetting": 1.1}, {"sigma": 0}, {"expected": -1}, {"gate": np.nan}):
        with pytest.raises(InputError):
            tracker(trunnion, **settings)
    with pytest.raises(InputError, match="'EXQ'"):
        Tracker(trunnion, ["EXQ"], POSES, sigma=1, expected=1)
    with pytest.raises(InputError, match=r"one for each pose"):
        tracker(trunnion).update(np.zeros((4, 3)))
