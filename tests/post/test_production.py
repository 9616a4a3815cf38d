"""Programs made in stretches: the same however the path is cut and whoever works on it, and nothing half done."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from mathpost import machine
from mathpost.errors import InputError, MathpostError, OutputError, ReachError
from mathpost.kinematics import Kinematics
from mathpost.post import cl as cldata
from mathpost.post import postprocess, selection
from mathpost.post.passage import Crossing
from mathpost.post.production import produce
from mathpost.post.program import DIALECTS
from mathpost.post.setting import Setting
from mathpost.post.spool import Spool
from mathpost.post.workers import AHEAD, Workers
from tests.conftest import DATA
from tests.machines import machines

TWISTED = DATA / "cl/twisted_blade.cl"


@pytest.fixture(scope="module")
def twisted():
    """A quarter of the blade: it passes the pole, and changes its feed."""
    return cldata.read(TWISTED).part(600, 2000)


def cut(cl, size):
    """The path in pieces."""
    return [cl.part(first, min(first + size, len(cl))) for first in range(0, len(cl), size)]


def made(cl, size, data, **options):
    """Everything that a program made of pieces consists of."""
    setting = Setting(data, "cut", **options)
    return list(produce(setting, cut(cl, size), Workers(1, setting)))


def text(parts):
    return "".join(part.proved.text for part in parts)


@pytest.mark.parametrize("dialect", ["heidenhain", "fanuc", "siemens"])
@pytest.mark.parametrize("tcp", [False, True])
def test_the_program_is_the_same_however_the_path_is_cut(twisted, dmu50v, dialect, tcp):
    options = {"dialect": dialect, "tcp": tcp, "compare": False}
    whole = text(made(twisted, len(twisted), dmu50v.machine, **options))
    for size in (1, 7, 500, 1399):
        assert text(made(twisted.part(0, 60) if size == 1 else twisted, size, dmu50v.machine, **options)) == (
            text(made(twisted.part(0, 60), 60, dmu50v.machine, **options)) if size == 1 else whole
        )


@settings(max_examples=12, deadline=None, suppress_health_check=list(HealthCheck))
@given(any_machine=machines(), seed=st.integers(0, 10**6), size=st.integers(1, 12), data=st.data())
def test_any_machine_any_path_any_cut(any_machine, seed, size, data):
    """The same program, or no program at all."""
    kin, rng = Kinematics(any_machine), np.random.default_rng(seed)
    step = data.draw(st.sampled_from([0.003, 0.1, 0.5]))
    joints = np.cumsum(rng.normal(size=(16, 5)) * [5, 5, 5, step, step], axis=0)
    joints[4:9, 3:] *= data.draw(st.sampled_from([0, 1]))
    cl = replace(
        cldata.from_arrays(*kin.forward(joints), feed=1000),
        rapid=rng.random(16) < data.draw(st.sampled_from([0, 0.3])),
        remarks=tuple((record, "PPRINT/HERE") for record in sorted(rng.integers(0, 17, 4).tolist())),
    )
    options = {
        "dialect": data.draw(st.sampled_from(list(DIALECTS))),
        "tcp": data.draw(st.booleans()),
        "singular": data.draw(st.sampled_from(Crossing.SAFE)),
        "split": data.draw(st.booleans()),
        "tolerance": 0.02,
        "compare": False,
    }
    programs = []
    for pieces in (16, size):
        try:
            programs.append(text(made(cl, pieces, any_machine, **options)))
        except MathpostError:
            programs.append(None)
    assert programs[0] == programs[1]


@pytest.mark.parametrize("singular", ["linear", "cubic", "aside", "retract"])
def test_a_region_on_a_border_is_passed_as_a_whole(twisted, dmu50v, singular):
    options = {"singular": singular, "compare": False, "name": "cut"}
    [*_, (first, last)] = made(twisted, len(twisted), dmu50v.machine, compare=False)[0].stretch.regions
    part = twisted.part(first - 40, last + 40)
    whole = postprocess.run(part, dmu50v.machine, **options)
    for size in (41, 42, 40 + last - first, len(part) - 3):
        parts = made(part, size, dmu50v.machine, singular=singular, compare=False)
        assert text(parts) == whole.program
        assert [region for p in parts for region in p.stretch.regions if p.stretch.lead == 0 or region[0] > 0]


def test_a_break_on_a_border(dmu50v):
    data = machine.load(DATA / "machines/nutating_head.toml")
    cl = cldata.read(TWISTED)
    expected = made(cl, len(cl), data, split=True, compare=False)
    record = expected[0].stretch.breaks[0]
    for size in (record - 1, record, record + 1):
        assert text(made(cl, size, data, split=True, compare=False)) == text(expected)


def test_file_in_file_out_is_the_same_for_any_number_of_workers(tmp_path, dmu50v):
    cl = tmp_path / "long.cl"
    cl.write_text(cldata.to_text(cldata.read(TWISTED)) * 7)
    programs, reports = [], []
    options = {"compare": False, "name": "LONG"}
    for workers in (1, 2):
        output = tmp_path / f"{workers}.h"
        reports.append(postprocess.run_file(cl, output, dmu50v.machine, workers=workers, **options))
        programs.append(output.read_bytes())
    result = postprocess.run(cldata.read(cl), dmu50v.machine, **options)
    assert programs[0] == programs[1] == result.program.encode()
    assert str(reports[0]) == str(reports[1]) == str(result.report)
    assert len(result.place) == len(result.blocks.words) and (np.diff(result.place) > 0).all()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["1.h", "2.h", "long.cl"]


def test_progress_ends_with_everything(tmp_path, dmu50v):
    seen = {}

    def note(doing, done, total):
        seen[doing] = doing, done, total

    postprocess.run_file(TWISTED, tmp_path / "a.h", dmu50v.machine, progress=note)
    parts = ["reading, bytes", "selecting, records", "writing and proving, records"]
    assert list(seen) == [*parts, *(f"selecting by {name!r}, records" for name in selection.STRATEGIES)]
    assert all(done == total for _, done, total in seen.values())


@pytest.mark.parametrize("workers", [1, 2])
def test_nothing_is_written_if_the_end_is_wrong(tmp_path, dmu50v, workers):
    cl, output = tmp_path / "bad.cl", tmp_path / "bad.h"
    lines = cldata.to_text(cldata.read(TWISTED)).splitlines()
    cl.write_text("\n".join([*lines * 4, "GOTO/99999,0,0,0,0,1"]))
    output.write_text("the program of yesterday")
    with pytest.raises(ReachError, match=r"bad\.cl, line \d+, record \d+"):
        postprocess.run_file(cl, output, dmu50v.machine, workers=workers)
    cl.write_text("\n".join([*lines * 4, "GOTO/1,2"]))
    with pytest.raises(InputError, match=rf"line {4 * len(lines) + 1}"):
        postprocess.run_file(cl, output, dmu50v.machine, workers=workers)
    with pytest.raises(OutputError, match="not written"):
        postprocess.run_file(TWISTED, tmp_path / "no" / "a.h", dmu50v.machine, workers=workers)
    assert output.read_text() == "the program of yesterday" and len(list(tmp_path.iterdir())) == 2


def test_an_error_comes_out_of_another_process_as_it_is():
    with (
        Workers(2, "shared") as workers,
        pytest.raises(InputError, match="there: expected this, found shared that"),
    ):
        list(workers.map(_refuse, [(None, "that")]))


def _refuse(shared, sent):
    raise InputError("there", "this", f"{shared} {sent}")


def test_no_workers_at_all_are_refused(tmp_path, dmu50v):
    with pytest.raises(InputError, match="workers: expected a number from 1 on, found 0"):
        postprocess.run_file(TWISTED, tmp_path / "a.h", dmu50v.machine, workers=0)
    assert not list(tmp_path.iterdir())


def test_workers_keep_the_order_and_are_not_run_ahead_of():
    taken = []

    def items():
        for number in range(200):
            taken.append(number)
            yield number, number

    with Workers(2, 1000) as workers:
        for kept, result in workers.map(_added, items()):
            assert result == 1000 + kept and len(taken) - kept <= 2 * AHEAD + 2
    assert kept == 199


def _added(shared, sent):
    return shared + sent


def test_a_state_that_does_not_fit_is_noticed(twisted, dmu50v, monkeypatch):
    from mathpost.post import production

    def forgetful(setting, planned, **options):
        proved = prove(setting, planned, **options)
        return replace(proved, state=replace(proved.state, feed=1.0))

    prove = production.prove
    monkeypatch.setattr(production, "prove", forgetful)
    with pytest.raises(MathpostError, match="does not go on"):
        made(twisted, 700, dmu50v.machine, compare=False)


def test_pieces_that_only_repeat_the_pose_before(dmu50v):
    remark = "PPRINT/HERE IT WAITS\n"
    first, second, third = (f"GOTO/{x},2,3,0,0,1\n" for x in (1, 4, 5))
    cl = cldata.parse("FEDRAT/500\n" + first + remark + second * 30 + third + remark)
    whole = text(made(cl, len(cl), dmu50v.machine))
    assert whole.count(" L ") == 3 and whole.count("WAITS") == 2
    for size in (1, 2, 7):
        assert text(made(cl, size, dmu50v.machine)) == whole


def test_a_way_that_is_not_possible_is_named_with_its_records(dmu50v, blade):
    with pytest.raises(ReachError, match=r"no way 'cubic' from record 2 to 3: a spline needs a record"):
        made(blade.part(0, 3), 3, dmu50v.machine, singular="cubic")


def test_without_cone_a_stretch_without_feed_asks_for_no_speed(dmu50v):
    cl = cldata.read(TWISTED)
    silent = replace(cl.part(0, 300), feeds=np.full(300, np.nan))
    path = cldata.join([silent, cl.part(300, 600)])
    assert text(made(path, 100, dmu50v.machine, cone=None)) == text(made(path, 600, dmu50v.machine, cone=None))
    with pytest.raises(InputError, match="cone"):
        made(silent, 100, dmu50v.machine, cone=None)


def test_spool_keeps_what_it_is_given():
    rng = np.random.default_rng(1)
    arrays = [rng.random((n, 3)) for n in (5, 0, 1000)]
    with Spool() as spool:
        for array in arrays:
            spool.append(array)
        assert len(spool) == 3
        for index in (2, 0, -1, 1):
            np.testing.assert_array_equal(spool[index], arrays[index])
        spool.append("after reading")
        assert spool[3] == "after reading" and len(list(spool)) == 4
