"""The time law: against closed forms, its inequalities, and an integration that knows nothing of moves."""

from dataclasses import replace

import numpy as np
import pytest

from mathpost import postprocess
from mathpost.kinematics import Kinematics
from mathpost.path import selection
from mathpost.shop.post import time_law as module
from mathpost.shop.post.time_law import SETTLE, block_times, slow_down, time_law
from mathpost.shop.post.ways import Crossing
from tests.conftest import DATA
from tests.linuxcnc import samples

RATE, ACCELERATION = np.radians(36), np.radians(200)  # of C on the DMU 50V
LINEAR = 2000.0  # mm/s², X and Y


def asked(kin, joints, feed):
    """Block times at a feed (mm/min) along X Y Z."""
    return block_times(kin.machine, joints, joints[:, :3], np.full(len(joints) - 1, feed), True)


def turned(angle, pieces=1):
    """A turn of C, in equal pieces."""
    joints = np.zeros((pieces + 1, 5))
    joints[:, 4] = np.linspace(0, angle, pieces + 1)
    return joints


@pytest.mark.parametrize("pieces", [1, 7, 400])
@pytest.mark.parametrize(
    ("angle", "seconds"),
    [
        (np.pi, np.pi / RATE + RATE / ACCELERATION),  # a trapezoid
        (np.radians(2), 2 * np.sqrt(np.radians(2) / ACCELERATION)),  # a triangle: the rate is never reached
    ],
)
def test_one_axis(dmu50v, angle, seconds, pieces):
    joints = turned(angle, pieces)
    law = time_law(dmu50v.machine, joints, np.full(pieces, angle / RATE / pieces))
    # The top of a triangle that falls into an uneven number of pieces lies within one of them.
    assert law.seconds[-1] == pytest.approx(seconds, rel=1e-9)
    assert law.peaks[1][4] == pytest.approx(ACCELERATION)
    assert law.peaks[0][4] == pytest.approx(min(RATE, np.sqrt(angle * ACCELERATION)))
    assert jumps(law)[:, 4].max(initial=0) == pytest.approx(0, abs=1e-12)


@pytest.mark.parametrize("halting", [False, True])
def test_long_paths_go_by_parts(dmu50v, halting, monkeypatch):
    """A law that is found a few moves at a time is that of all of them at once."""
    rng = np.random.default_rng(17)
    joints, seconds = rng.normal(0, 0.3, (100, 5)).cumsum(axis=0), rng.choice([0, 0.005, 0.05], 99)
    halts, smooth = (rng.random(100) < 0.1, rng.random(100) < 0.3) if halting else (None, None)
    whole, parts = [], []
    for found, size in ((whole, 1000), (parts, 7)):
        monkeypatch.setattr("mathpost.formula.SLICE", size)
        law = time_law(dmu50v.machine, joints, seconds, halts=halts, smooth=smooth)
        found += [law.joints, law.seconds, law.override, law.asked, law.ramp, law.highest, law.peaks]
    assert np.count_nonzero(whole[2]) > 20
    for one, other in zip(whole, parts, strict=True):
        np.testing.assert_array_equal(one, other)


def jumps(law):
    """By how much the speed of each axis jumps at each pose between the first and the last."""
    speeds = np.diff(law.joints, axis=0) / law.asked[:, None]
    return np.abs(np.diff(speeds, axis=0)) * law.override[1:-1, None]


def test_a_corner(dmu50v):
    """Along X, then along Y: at the corner one axis stops and the other starts, both by acceleration × settle."""
    joints, speed = np.zeros((3, 5)), 80.0
    joints[1:, 0] = joints[2, 1] = 100
    law = time_law(dmu50v.machine, joints, asked(dmu50v, joints, 60 * speed))
    through = LINEAR * SETTLE / speed
    assert law.override[1] == pytest.approx(through)
    lost = speed / (2 * LINEAR) * (1 + (1 - through) ** 2)  # by speeding up from rest, and by slowing down
    assert law.seconds[-1] == pytest.approx(2 * (100 / speed + lost))
    np.testing.assert_allclose(jumps(law)[0, :2], LINEAR * SETTLE)
    slow = time_law(dmu50v.machine, joints, asked(dmu50v, joints, 60 * LINEAR * SETTLE))
    assert slow.override[1] == 1  # as slowly as this the corner is taken at full speed


def circle(radius, pieces):
    angle = np.linspace(0, 2 * np.pi, pieces + 1)
    joints = np.zeros((pieces + 1, 5))
    joints[:, :2] = radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return joints


def test_a_circle(dmu50v):
    """v²/r is what it takes of X and of Y, where the circle turns the axis back."""
    radius, pieces = 10.0, 800
    joints, fastest = circle(radius, pieces), np.sqrt(LINEAR * radius)
    slow = time_law(dmu50v.machine, joints, asked(dmu50v, joints, 60 * 0.5 * fastest))
    assert (slow.override[pieces // 4 : -pieces // 4] == 1).all()
    quick = time_law(dmu50v.machine, joints, asked(dmu50v, joints, 60 * 2 * fastest))
    quarters = pieces * np.arange(1, 4) // 4
    np.testing.assert_allclose(2 * fastest * quick.override[quarters], fastest, rtol=1e-4)
    assert (quick.peaks[1] <= np.array([1, 1, 1, 0, 0]) * LINEAR * (1 + 1e-9)).all()


def wander(seed, records, spacing, uneven=0.5):
    """A smooth path of all joints, and the times that are asked for."""
    random, place = np.random.default_rng(seed), np.linspace(0, 1, records)[:, None]
    joints = sum(
        size * np.sin(2 * np.pi * (k + 1) * place + random.uniform(0, 7, 5))
        for k, size in enumerate(random.uniform(0, 1, (4, 5)) * [8, 8, 8, 0.3, 0.3])
    )
    return joints, spacing * random.uniform(1 - uneven, 1 + uneven, records - 1)


@pytest.mark.parametrize("spacing", [0.004, 0.015, 0.1])
@pytest.mark.parametrize("seed", range(3))
def test_no_pose_can_be_passed_faster(dmu50v, seed, spacing):
    """Written as inequalities over the squares of w, all hold, and one breaks if any square is raised."""
    joints, lengths = wander(seed, 80, spacing)
    lengths = np.maximum(lengths, block_times(dmu50v.machine, joints, joints, np.full(79, np.nan), True))
    most, speed = dmu50v.machine.max_accelerations, np.abs(np.diff(joints, axis=0)) / lengths[:, None]
    jump = np.abs(np.diff(np.diff(joints, axis=0) / lengths[:, None], axis=0))
    pause = (lengths[1:] + lengths[:-1]) / 2
    rows = [np.eye(80)[pose] for pose in range(80)]  # w is 1 at most
    for pose in range(1, 79):
        rows += [np.eye(80)[pose] * (part / (most[axis] * SETTLE)) ** 2 for axis, part in enumerate(jump[pose - 1])]
    for move in range(79):
        for end in (move, move + 1):
            bent = 0 < end < 79 and pause[end - 1] < SETTLE
            for axis in range(5):
                for sign in (1, -1):
                    row = np.zeros(80)
                    row[[move + 1, move]] = np.array([sign, -sign]) * speed[move, axis] / (2 * lengths[move])
                    row[end] += jump[end - 1, axis] / pause[end - 1] if bent else 0
                    rows.append(row / most[axis])
    rows, squares = np.array(rows), time_law(dmu50v.machine, joints, lengths).override ** 2
    assert (rows @ squares).max() <= 1 + 1e-9 and squares[0] == squares[-1] == 0
    assert squares[1:-1].min() < 0.9  # more than w = 1 did bind
    for pose in range(1, 79):
        assert (rows @ (squares + 1e-6 * np.eye(80)[pose])).max() > 1 + 1e-9


@pytest.mark.parametrize("seed", range(3))
def test_integrated(dmu50v, seed):
    """Sampled evenly in time, speeds and accelerations are sums of differences: none is above its limit."""
    joints, lengths = wander(seed, 6000, 0.0004, uneven=0)
    slowest = block_times(dmu50v.machine, joints, joints, np.full(5999, np.nan), True)
    lengths = np.full(5999, max(lengths[0], slowest.max()))
    law = time_law(dmu50v.machine, joints, lengths)
    period = 0.004
    samples = law.at(np.arange(0, law.seconds[-1], period))
    speeds = np.diff(samples, axis=0) / period
    pulled = np.abs(np.diff(speeds, axis=0)).max(axis=0) / period
    assert (np.abs(speeds).max(axis=0) <= law.peaks[0] * (1 + 1e-9)).all()
    assert (law.peaks[0] <= dmu50v.machine.max_rates * (1 + 1e-9)).all()
    assert (law.peaks[1] <= dmu50v.machine.max_accelerations * (1 + 1e-9)).all()
    assert (pulled <= 1.15 * dmu50v.machine.max_accelerations).all()
    assert (law.peaks[1] > 0.95 * dmu50v.machine.max_accelerations).any()


def test_it_is_where_it_says_when_it_says(dmu50v):
    joints, lengths = wander(5, 60, 0.05)
    law = time_law(dmu50v.machine, joints, lengths)
    np.testing.assert_allclose(law.at(law.seconds), joints, atol=1e-9)
    fine = np.linspace(0, law.seconds[-1], 20001)
    speeds = np.diff(law.at(fine), axis=0) / np.diff(fine)[:, None]
    assert (np.abs(speeds).max(axis=0) <= law.peaks[0] * (1 + 1e-6)).all()


def test_no_move_lasts_longer_than_at_its_slower_end(dmu50v, blade):
    """What rounding leaves of a ramp, where w stays as it is, takes no time."""
    crossing = Crossing(dmu50v, blade, selection.choose(dmu50v, blade).joints, (1, 2))
    for lean in np.radians([2, 7.5, 8]):
        law = crossing.way("aside", lean=lean).law
        slower = np.minimum(law.override[1:], law.override[:-1])
        with np.errstate(divide="ignore"):
            assert (np.diff(law.seconds) <= law.asked / slower * (1 + 1e-9))[law.asked > 0].all()


def test_the_way_back_takes_as_long(dmu50v):
    joints, lengths = wander(6, 60, 0.02)
    there, back = (time_law(dmu50v.machine, joints[::way], lengths[::way]) for way in (1, -1))
    assert there.seconds[-1] == pytest.approx(back.seconds[-1])
    np.testing.assert_allclose(there.override, back.override[::-1], atol=1e-9)


def test_without_accelerations_every_move_takes_what_it_is_asked(dmu50v):
    joints, lengths = wander(7, 20, 0.02)
    joints, lengths = np.insert(joints, 5, joints[5], axis=0), np.insert(lengths, 5, 0.0)
    parts = (tuple(replace(joint, max_acceleration=None) for joint in part)
             for part in (dmu50v.machine.linear, dmu50v.machine.rotary))  # fmt: skip
    machine = replace(dmu50v.machine, **dict(zip(("linear", "rotary"), parts, strict=True)))
    law = time_law(machine, joints, lengths)
    np.testing.assert_allclose(law.seconds, np.r_[0, np.cumsum(lengths[lengths > 0])])
    assert len(law.joints) == len(joints) - 1


def test_compiled_or_not(dmu50v, monkeypatch):
    pytest.importorskip("numba")
    joints, lengths = wander(8, 200, 0.01)
    plain = time_law(dmu50v.machine, joints, lengths)
    monkeypatch.setattr(module, "LONG", 0)
    np.testing.assert_array_equal(time_law(dmu50v.machine, joints, lengths).seconds, plain.seconds)


def test_slow_down():
    nan = np.nan
    assert slow_down([1, 2, 2, 3], [1, 3, 3, 9], [1, 1, 1, nan]) == (2, 2, 6)
    assert slow_down([1, 2], [1, 2], [nan, nan]) is None


def test_ways_through_the_blade_in_real_seconds(dmu50v, blade):
    """With slow axes the straight way beats the spline, whose C turns back first; with quick ones they tie."""
    times = {}
    for degrees in (20, 200, 2000):
        rotary = tuple(replace(joint, max_acceleration=np.radians(degrees)) for joint in dmu50v.machine.rotary)
        kin = Kinematics(replace(dmu50v.machine, rotary=rotary))
        crossing = Crossing(kin, blade, selection.choose(kin, blade).joints, (1, 2))
        ways = {name: crossing.way(name) for name in ("linear", "cubic", "aside", "retract")}
        assert all(way.peak_acceleration <= np.radians(degrees) * (1 + 1e-9) for way in ways.values())
        times[degrees] = {name: way.time for name, way in ways.items()}
    assert sorted(times[20], key=times[20].get) == ["linear", "aside", "cubic", "retract"]
    for name in ("linear", "cubic", "aside", "retract"):
        assert times[20][name] > times[200][name] > times[2000][name]
    for degrees in (200, 2000):
        others = [times[degrees][name] for name in ("linear", "cubic", "aside")]
        assert max(others) < 1.01 * min(others) < 0.97 * times[degrees]["retract"]


def test_the_report_has_real_seconds(dmu50v, blade):
    fed = replace(blade, feeds=np.full(5, 300.0))
    report = postprocess(fed, dmu50v.machine, singular="retract").report
    record, wanted, taken = report.slowest
    assert record == 4 and taken > 100 * wanted  # B turns by 13° while the tip all but stands
    assert report.peaks["C"] == pytest.approx([36, 200]) and report.time > 6
    assert "peaks " in str(report) and f"before record {record + 1}: {taken:.3f} s" in str(report)


# What LinuxCNC took for programs of ours: the last time of each way in the stored samples.
SAMPLED = [(name, way) for name, (_, _, _, ways, _) in samples.PATHS.items() for way in ways]


@pytest.mark.parametrize(("name", "way"), SAMPLED)
def test_the_seconds_that_a_real_control_took(name, way):
    rows = (DATA / f"measurements/linuxcnc_{name}.csv").read_text(encoding="utf-8").splitlines()[3:]
    took = max(float(row.split(",")[1]) for row in rows if row.startswith(f"{way},"))
    report = samples.posted(name)[way].report
    assert report.time == pytest.approx(took, rel=0.01 if way == "G61" else 0.02)


def test_a_control_that_looks_ahead_over_all_axes_is_faster_than_this_one():
    """Where no axis turns LinuxCNC looks ahead as well; beside the pole the laws differ."""
    seconds = {}
    for name in ("upright", "pole"):
        for dialect in ("fanuc", "linuxcnc_g64", "linuxcnc"):
            seconds[name, dialect] = postprocess(samples.PATHS[name][1], samples.SETUP, dialect=dialect).report.time
    assert seconds["upright", "fanuc"] == pytest.approx(seconds["upright", "linuxcnc"], rel=1e-9)
    half = seconds["upright", "fanuc"] + 25 / LINEAR  # 1500 mm/min, reached and left with half the acceleration
    assert seconds["upright", "linuxcnc_g64"] == pytest.approx(half, rel=1e-6)
    assert seconds["pole", "fanuc"] < 0.9 * min(seconds["pole", "linuxcnc"], seconds["pole", "linuxcnc_g64"])
