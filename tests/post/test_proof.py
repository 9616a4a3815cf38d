"""What the proof refuses: a program off the path, into the part, at another feed or in too little time."""

from dataclasses import replace

import numpy as np
import pytest

from mathpost import load_machine, postprocess
from mathpost.errors import InputError, MathpostError
from mathpost.kinematics import Kinematics
from mathpost.path import cl as cldata
from mathpost.path import region, selection, singular
from mathpost.path.deviation import AXIS_TOLERANCE
from mathpost.path.motion import Motion
from mathpost.shop.controls import control
from mathpost.shop.controls.blocks import Blocks, rounded
from mathpost.shop.post import options as settings
from mathpost.shop.post import proof, report, steps, time_law, ways
from tests.conftest import DATA


@pytest.fixture(scope="module")
def by_the_pole():
    """A part of the blade that passes the pole at 1500 mm/min."""
    return cldata.read(DATA / "cl/twisted_blade.cl").part(800, 880)


@pytest.fixture(scope="module")
def program_of(by_the_pole):
    """A function that makes the program of that part on a machine."""
    made = {}

    def make(data, **options):
        key = data.name, *options.items()
        made[key] = made.get(key) or postprocess(by_the_pole, data, **options)
        return made[key]

    return make


def on_path(result):
    """The motion of a program without lifted moves."""
    return Motion.on_part(result.blocks.joints, result.place)


def refused(kin, cl, result, match, along=None, **changes):
    """Whether a program with something changed in it is refused, and the one without is not."""
    along = along or on_path(result)
    proof.prove(kin, cl, result.blocks, along, 0.01, AXIS_TOLERANCE)
    with pytest.raises(MathpostError, match=match):
        proof.prove(kin, cl, replace(result.blocks, **changes), along, 0.01, AXIS_TOLERANCE)


@pytest.mark.parametrize("tcp", [False, True])
def test_a_wrong_digit(dmu50v, by_the_pole, program_of, tcp):
    result = program_of(dmu50v.machine, tcp=tcp)
    for axis in range(5) if not tcp else range(3):
        words = result.blocks.words.copy()
        words[40, axis] += 0.05
        refused(dmu50v, by_the_pole, result, "mm off the CL path, more than 0.01 mm", words=words)


def test_an_axis_too_far(dmu50v, by_the_pole, program_of):
    """X Y Z keep the tip, so that nothing but the tool axis is wrong: beside the pole C by 30° is 0.15°."""
    result = program_of(dmu50v.machine)
    closest = int(singular.distance(dmu50v, by_the_pole.at(result.place)[1]).argmin())
    words = result.blocks.words.copy()
    words[closest, 4] += 30
    tip = by_the_pole.at(result.place[closest])[0]
    words[[closest]] = rounded(dmu50v.close(tip, np.radians(words[[closest], 3:])))
    free = replace(result.blocks, words=words)
    along = on_path(result)
    wrong = proof.measured(dmu50v, by_the_pole, free, along)
    assert wrong.tip_error < 2e-4 and wrong.path_axis_error == pytest.approx(0.15, abs=0.03)
    with pytest.raises(MathpostError, match=r"tool axis is 0\.\d+° off its great circle, more than 0.1°"):
        proof.prove(dmu50v, by_the_pole, free, along, 1.0e3, AXIS_TOLERANCE)
    proof.prove(dmu50v, by_the_pole, replace(free, seconds=np.full(len(words), 99.0)), along, 1e3, 0.01)


def test_a_machine_with_measured_errors_is_looked_at_between_the_middle_and_the_ends(dmu50v):
    """A slide that leaves its line four times on its way, and is on it in the middle: no derivative tells of it."""

    class Wavy:
        machine = dmu50v.machine

        def forward(self, joints):
            tip, axis = dmu50v.forward(joints)
            return tip + 0.02 * np.sin(np.pi * joints[..., :1] / 25) * [0, 0, 1], axis

    cl = cldata.from_arrays([[0, 0, 0], [100, 0, 0]], [[0, 0, 1]] * 2)
    result = postprocess(cl, dmu50v.machine)
    found = proof.measured(dmu50v, cl, result.blocks, on_path(result), real=Wavy())
    assert found.tip_error < 1e-9 and found.path_tip_error == pytest.approx(0.02, rel=1e-2)


def test_a_block_too_few(dmu50v, by_the_pole, program_of):
    result = program_of(dmu50v.machine)
    columns = {name: getattr(result.blocks, name)[1:] for name in ("words", "feeds", "seconds", "rapid")}
    refused(dmu50v, by_the_pole, result, "blocks were written and", **columns)


def test_another_feed_or_rapid(dmu50v, by_the_pole, program_of):
    result = program_of(dmu50v.machine, tcp=True)
    feeds, rapid = result.blocks.feeds.copy(), result.blocks.rapid.copy()
    feeds[7] += 0.002
    refused(
        dmu50v, by_the_pole, result, r"record \d+: the CL data have feed 1500 and the program feed", feeds=feeds
    )
    feeds[7] = np.nan
    refused(dmu50v, by_the_pole, result, "the program feed nan", feeds=feeds)
    rapid[9] = True
    refused(dmu50v, by_the_pole, result, "have feed 1500 and the program rapid", rapid=rapid)


@pytest.mark.parametrize("name", ["dmu50v", "ac_head"])
def test_a_block_with_a_tenth_of_its_time(by_the_pole, program_of, name):
    """Whether the feed or an axis is the slowest: no block may be any faster."""
    data = load_machine(DATA / f"machines/{name}.toml")
    result = program_of(data)
    timed = np.flatnonzero(result.blocks.seconds > 0.01)
    assert timed.size
    for block in timed[:: max(timed.size // 10, 1)]:
        seconds = result.blocks.seconds.copy()
        seconds[block] /= 10
        refused(Kinematics(data), by_the_pole, result, "a block takes .* need .* at least", seconds=seconds)
        seconds[block] *= 9
        refused(Kinematics(data), by_the_pole, result, "a block takes", seconds=seconds)


@pytest.mark.parametrize("rates", [True, False])
@pytest.mark.parametrize("dialect", control.names())
def test_times_computed_ten_times_too_short_are_refused(dmu50v, by_the_pole, monkeypatch, dialect, rates):
    data = dmu50v.machine if rates else without_rates(dmu50v.machine)
    postprocess(by_the_pole, data, dialect=dialect)
    right = time_law.block_times
    monkeypatch.setattr(steps, "block_times", lambda *given: right(*given) / 10)
    with pytest.raises(MathpostError, match="a block takes"):
        postprocess(by_the_pole, data, dialect=dialect)


def without_rates(data):
    """The machine, stating no rates."""
    return replace(
        data,
        linear=tuple(replace(axis, max_rate=None) for axis in data.linear),
        rotary=tuple(replace(axis, max_rate=None) for axis in data.rotary),
    )


def test_times_in_numbers(dmu50v):
    """30 mm at 600 mm/min and rotary moves by hand."""
    assert cldata.feed_times(np.array([[0.0, 0, 0], [0, 30, 0]]), np.array([600.0])) == pytest.approx([3.0])
    joints = np.array([[0.0, 0, 0, 0, 0], [0, 30, 0, 0, np.radians(90)], [0, 30, 0, 0, np.radians(100)]])
    tip, feeds, data = np.zeros((3, 3)), np.array([600.0, np.nan]), without_rates(dmu50v.machine)
    assert time_law.block_times(data, joints, tip, feeds, np.ones(2, bool)) == pytest.approx([9.0, 0])
    rate = np.degrees(dmu50v.machine.max_rates[4])
    times = time_law.block_times(dmu50v.machine, joints, tip, feeds, np.ones(2, bool))
    assert times == pytest.approx([90 / rate, 10 / rate])
    far = np.array([[0.0, 0, 0], [0, 0, 600], [0, 0, 600]])
    times = time_law.block_times(dmu50v.machine, joints, far, feeds, np.array([True, True]))
    assert times == pytest.approx([60, 10 / rate])
    times = time_law.block_times(dmu50v.machine, joints, far, feeds, np.array([False, True]))
    assert times == pytest.approx([90 / rate, 10 / rate])


@pytest.mark.parametrize("tcp", [False, True])
@pytest.mark.parametrize("name", ["dmu50v", "ac_table", "nutating_head", "head_b_table_c"])
def test_a_retract_into_the_part_is_refused(by_the_pole, monkeypatch, name, tcp):
    data = load_machine(DATA / f"machines/{name}.toml")
    options = {"singular": "retract", "cone": np.radians(1), "tcp": tcp}
    result = postprocess(by_the_pole, data, **options, clearance=5.0)
    assert result.report.settings["singular"].endswith(": retract")
    for module in (settings, region):
        monkeypatch.setattr(module, "refuse_nonsense", lambda *_: None)
    with pytest.raises(MathpostError, match=r"record \d+: on its way .* 5.00\d mm into the part"):
        postprocess(by_the_pole, data, **options, clearance=-5.0)


def test_a_split_into_the_part_is_refused(monkeypatch):
    data, cl = load_machine(DATA / "machines/nutating_head.toml"), cldata.read(DATA / "cl/twisted_blade.cl")
    monkeypatch.setattr(region, "refuse_nonsense", lambda *_: None)
    monkeypatch.setattr(settings, "refuse_nonsense", lambda *_: None)
    with pytest.raises(MathpostError, match=r"\d mm into the part"):
        postprocess(cl, data, split=True, clearance=-20.0)


def test_the_whole_way_of_a_lifted_move_is_looked_at(dmu50v):
    """Half a turn of C, lifted at both ends by words that are right: half way the tip is deep in the part."""
    cl = cldata.from_arrays([[77.0, 0, 0], [77.0, 0, 0]], [[0, 0, 1], [0, 0, 1]])
    tilt = np.radians(30)
    axes = np.array([[np.sin(tilt), 0, np.cos(tilt)]] * 2)
    cl = replace(cl, axes=axes)
    lifted = cl.points + 5 * axes
    solved = dmu50v.inverse(lifted, axes)[0]
    joints = np.stack([solved[0], solved[0]])
    joints[1, 4] += 2 * np.pi
    ends = dmu50v.close(cl.points, joints[:, 3:])
    joints = np.stack(
        [ends[0], dmu50v.close(lifted, joints[:, 3:])[0], dmu50v.close(lifted, joints[:, 3:])[1], ends[1]]
    )
    blocks = Blocks(rounded(joints), np.full(4, np.nan), np.full(4, np.nan), np.zeros(4, bool))
    along = Motion(joints, np.array([0.0, 0, 1, 1]), np.array([False, True, True, False]))
    with pytest.raises(MathpostError, match="into the part"):
        proof.prove(dmu50v, cl, blocks, along, 0.01, AXIS_TOLERANCE)
    with_tcp = replace(blocks, words=tcp_words(dmu50v, blocks), tcp=True)
    proof.prove(dmu50v, cl, with_tcp, along, 0.01, AXIS_TOLERANCE)


def tcp_words(kin, blocks):
    """The words for a control that keeps the tip."""
    joints = blocks.joints
    return rounded(np.concatenate([kin.forward(joints)[0], joints[:, 3:]], axis=1))


@pytest.mark.parametrize(
    ("option", "value"),
    [
        *((name, value) for name in ("clearance", "lean") for value in (0.0, -1.0, float("nan"), float("inf"))),
        ("lean", np.pi / 2),
    ],
)
def test_ways_of_no_use_are_refused(dmu50v, blade, option, value):
    with pytest.raises(InputError, match=rf"{option}: expected .* above 0"):
        postprocess(blade, dmu50v.machine, **{option: value})
    crossing = ways.Crossing(dmu50v, blade, selection.choose(dmu50v, blade).joints, (1, 2))
    with pytest.raises(InputError, match=option):
        crossing.way("retract", **{option: value})
    with pytest.raises(InputError, match=option):
        crossing.compare(**{option: value})


def test_ways_that_meet_at_a_record():
    """Two splits in a row: each lifts, swings and returns, and the record between them is cut once."""
    joints = np.arange(30.0).reshape(6, 5)

    def over(record):
        place = np.array([record - 1, record - 1, record - 0.5, record, record])
        rows = joints[[record - 1, record - 1, record, record, record]] + [[0], [0.1], [0.2], [0.3], [0]]
        return Motion(rows, place, np.array([False, True, True, True, False]))

    whole = region.through_the_records(joints, [over(3), over(2)])
    np.testing.assert_array_equal(whole.place, [0, 1, 1, 1.5, 2, 2, 2, 2.5, 3, 3, 4, 5])
    np.testing.assert_array_equal(np.flatnonzero(whole.lifted), [2, 3, 4, 6, 7, 8])
    np.testing.assert_array_equal(whole.joints[~whole.lifted], joints)
    plain = region.through_the_records(joints, [])
    np.testing.assert_array_equal(plain.joints, joints)
    assert not plain.lifted.any()


def test_a_region_is_passed_between_the_breaks():
    assert list(region.unbroken([(1, 4), (6, 9), (20, 21)], [5, 7, 9, 21])) == [(1, 4), (7, 8)]
    assert list(region.unbroken([(1, 4)], [])) == [(1, 4)]
    assert list(region.unbroken([(1, 9)], [5])) == [(1, 4), (5, 9)]


def test_the_record_between_two_blocks_and_what_is_reported(dmu50v, by_the_pole, program_of):
    """The figures against distances by hand, at the records and at the worst place."""
    result = program_of(dmu50v.machine)
    tip, axis = dmu50v.forward(result.blocks.joints)
    at = np.searchsorted(result.place, np.arange(len(by_the_pole)))
    assert result.report.tip_error == pytest.approx(np.linalg.norm(tip[at] - by_the_pole.points, axis=1).max())
    angle = np.degrees(np.arcsin(np.linalg.norm(np.cross(axis[at], by_the_pole.axes), axis=1).max()))
    assert result.report.axis_error == pytest.approx(angle)
    words = result.blocks.words.copy()
    words[60, 0] += 0.5
    wrong = proof.measured(dmu50v, by_the_pole, replace(result.blocks, words=words), on_path(result))
    assert wrong.path_tip_error == pytest.approx(0.5, abs=0.01)
    assert wrong.worst_record in (int(np.ceil(result.place[60])) + 1, int(np.ceil(result.place[61])) + 1)


@pytest.mark.parametrize(
    ("rates", "feed", "to", "turn", "seconds"),
    [
        (True, 600.0, [0, 30, 0], 0.1, 3.0),  # the feed: 30 mm at 600 mm/min
        (True, 1e5, [0, 30, 0], 90, 90 / 50),  # C at 50°/s
        (True, 1e6, [0, 600, 0], 0.1, 600 / 250),  # Y at 250 mm/s
        (False, 600.0, [0, 30, 0], 0.1, 3.0),
        (False, 600.0, [0, 30, 0], 90, 9.0),  # without rates no axis is faster than the feed, in degrees a minute
    ],
)
def test_the_least_time_of_a_block_by_hand(dmu50v, rates, feed, to, turn, seconds):
    data = dmu50v.machine if rates else without_rates(dmu50v.machine)
    if rates:
        data = replace(
            data,
            linear=tuple(replace(each, max_rate=250.0) for each in data.linear),
            rotary=tuple(replace(each, max_rate=np.radians(50)) for each in data.rotary),
        )
    cl = cldata.from_arrays([[0, 0, 0], to], [[0, 0, 1]] * 2, feed=feed)
    words = np.array([[0.0] * 5, [*map(float, to), 0, turn]])
    along = Motion.on_part(words, np.arange(2.0))

    def look(time):
        given = Blocks(words, np.full(2, np.nan), np.array([np.nan, time]), np.zeros(2, bool))
        proof._refuse_too_fast(Kinematics(data), cl, given, along)

    look(seconds)
    with pytest.raises(MathpostError, match=rf"takes .* need {seconds:.3f} s at least"):
        look(0.97 * seconds)


@pytest.mark.parametrize("to", [50.0, -50.0])
@pytest.mark.parametrize("tcp", [True, False])
def test_a_lifted_move_beside_a_path_that_climbs_or_falls(dmu50v, to, tcp):
    """The tool stays 5 mm above the part all the way."""
    cl = cldata.from_arrays([[10, 0, 0], [10, 0, to]], [[0, 0, 1]] * 2)
    joints = dmu50v.close(cl.points[[0, 0, 1, 1]] + np.outer([0, 5, 5, 0], [0, 0, 1]), np.zeros((4, 2)))
    along = Motion(joints, np.array([0.0, 0, 1, 1]), np.array([False, True, True, False]))
    blocks = Blocks(rounded(joints), np.full(4, np.nan), np.full(4, np.nan), np.zeros(4, bool))
    if tcp:
        blocks = replace(blocks, words=tcp_words(dmu50v, blocks), tcp=True)
    proof.prove(dmu50v, cl, blocks, along, 0.01, AXIS_TOLERANCE)


def test_the_worst_of_several_tools():
    first, second = proof.Proof(0.1, 4.0, 0.3, 0.2, 7, 0.3), proof.Proof(0.2, 1.0, 0.9, 0.1, 3, 0.5)
    for both in ([first, second], [second, first]):
        assert report.worst_of(both) == proof.Proof(0.2, 4.0, 0.9, 0.2, 3, 0.5)


def test_the_report_in_words():
    made = report.Report(
        0.001, 0.002, 0.003, 0.004, 5, 0.005,
        settings={"machine": "M"}, time=61.25, time_law="as assumed",
        peaks={"X": (0.0, 1.0), "Y": (12.5, 300.0), "C": (36.0, np.nan)},
        slowest=(4, 1.0, 2.5), warnings=("look",), uncompensated=proof.Proof(0.0125, 0.01, 0, 0, 1, 0),
        strategies=(("optimal", 1.5, (10.0, 20.0), ""), ("paper", np.nan, (), "no way")), ways={},
    )  # fmt: skip
    assert str(made).split("\n") == [
        "machine      M",
        "time         61.25 s, as assumed",
        "peaks        Y 12.5 mm/s 300 mm/s², C 36.0 °/s",
        "slow-down    before record 5: 2.500 s, the feed asks 1.000 s",
        "tip error    0.0010 mm at the records, 0.0030 mm along the path (most before record 5)",
        "axis error   0.0020° at the records, 0.0040° from the arc along the path, lag 0.0050°",
        "volumetric   at the records 12.5 µm and 36.0 arcsec before compensation, 1.0 µm and 7.2 arcsec after it",
        "warning      look",
        "",
        "selection           cost  largest rotary steps",
        "optimal            1.500    10.000°   20.000°",
        "paper         no way",
    ]
