"""Random machines, paths, tools, feeds and ways: what the independent reader sees against what the report says."""

import numpy as np
import pytest

from mathpost import machine_file, postprocess
from mathpost.errors import MathpostError
from mathpost.kinematics import Kinematics
from mathpost.path import cl as cldata
from mathpost.shop.post import postprocess as postprocessing
from tests.machines import SIDES, content

from . import drawn, judge
from .machine_model import Model
from .reader import Setup, read

DIALECTS = ("fanuc", "haas", "heidenhain", "linuxcnc", "mazak", "siemens")
FEEDS = {"MMPM": 900.0, "IPM": 35.0, "MMPR": 0.15, "IPR": 0.006}
ORDINARY = [([-1, 0, 0], [0, 0, -1]), ([0, 0, -1], [0, 1, 0]), ([0, 0, 1], [0, 1, 0])]  # for each of SIDES


def random_machine(rng, seed):
    """The content of a machine file, skew or ordinary, with rates and a safe position."""
    first, second = ORDINARY[seed % 3] if seed % 2 else rng.integers(-9, 10, (2, 3)).tolist()
    points = np.round(rng.uniform(-200, 200, (2, 3)), 3).tolist()
    origin = np.round(rng.uniform(-100, 100, 3), 3).tolist()
    named = ["tip", "nose", points[0]][int(rng.integers(3))]
    more = {"origin": origin, "length": int(rng.integers(0, 200)), "programmed": named}
    data = content(first, second, SIDES[seed % 3], point=points, tool=(0, 0.2 * (seed % 2), 1), **more)
    for joint in data["rotary"]:
        joint |= {"max_rate": float(rng.integers(20, 90)), "max_acceleration": float(rng.integers(200, 900))}
    rates = {"max_rate": 600.0, "max_acceleration": 2500.0}
    data["linear"] = {axis: dict(rates) for axis in "XYZ"} | {"safe": {"Z": 900.0}}
    if seed % 4 == 0:
        data["program"] = {"foot": ["M9"]}
    return data


def random_path(rng, data, unit, length):
    """CL data that the machine reaches, with a tool of this length or none."""
    with_tool = machine_file.from_dict(data).with_setup(tool_length=length)
    joints = np.cumsum(rng.normal(size=(7, 5)) * [6, 6, 6, 0.08, 0.08], axis=0)
    joints[:, 3:] += rng.uniform(-1, 1, 2)
    lines = [f"LOADTL/4,LENGTH,{length:g}"] if length is not None else []
    lines += ["UNITS/MM", "SPINDL/RPM,6000,CLW", f"FEDRAT/{FEEDS[unit]:g},{unit}"]
    for pose in zip(*Kinematics(with_tool).forward(joints), strict=True):
        lines.append("GOTO/" + ",".join(f"{value:.9f}" for value in np.concatenate(pose)))
    return cldata.parse("\n".join(lines) + "\n", "random.cl")


def met(data, dialect, path, program):
    """What the tool meets in the air of what is cut."""
    lines = np.stack([path.points[:-1], path.points[1:]], axis=1)
    t = np.linspace(0, 1, 200)[:, None, None]
    points = (lines[:, 0] + t * (lines[:, 1] - lines[:, 0])).reshape(-1, 3)
    job = drawn.Job("random", data, dialect, False, "", {"cut": points}, lines)
    return drawn.hits(job, program, np.random.default_rng(0))


@pytest.mark.parametrize("seed", range(20))
def test_the_report_says_what_the_program_does(seed, monkeypatch):
    rng = np.random.default_rng(seed)
    data = random_machine(rng, seed)
    length = float(rng.integers(20, 150)) if seed % 2 else None
    path = random_path(rng, data, list(FEEDS)[seed % 4], length)
    way, dialect = ["direct", "retract", "linear"][seed % 3], DIALECTS[seed % len(DIALECTS)]
    options = {"singular": way, "cone": np.radians(5), "axis_tolerance": np.radians(3 if way == "linear" else 0.1)}
    tcp = bool(rng.integers(2))
    options |= {"dialect": dialect, "tcp": tcp}
    try:
        result = postprocess(path, machine_file.from_dict(data), **options)
    except MathpostError as error:
        if "lifted, the tool's body" in str(error):  # then an independent body says the same of the program
            monkeypatch.setattr(postprocessing, "refuse_unsafe", lambda plans, *_, **__: plans)
            program = postprocess(path, machine_file.from_dict(data), **options).program
            assert met(data, dialect, path, program)
        else:
            assert any(why in str(error) for why in ("it needs an axis tolerance of", "out of reach"))
        return
    held = float(data["tool"]["length"]) if length is None else length
    model, report = Model(data, length=held), result.report
    moves = read(result.program, dialect, Setup(model, length_on=True, lengths={4: held}))
    samples = judge.sample(model, moves)
    assert not judge.records_missed(
        samples.tip, samples.axis, path.points, path.axes, 1e-3, report.axis_error + 2e-3
    )
    at_ends = [np.linalg.norm(samples.tip - path.points[end], axis=1) < 1e-3 for end in (0, -1)]
    first, last = int(at_ends[0].argmax()), int(np.flatnonzero(at_ends[1])[-1])
    feed = np.array([moves[move].kind == "feed" for move in samples.move[first : last + 1]])
    tip, axis = samples.tip[first : last + 1][feed], samples.axis[first : last + 1][feed]
    off, turned, _ = judge.along_records(tip, axis, path.points, path.axes, window=7)
    of_move = samples.move[first : last + 1][feed]
    lifted = np.isin(of_move, of_move[off > 1])  # a lift that is written with a feed
    assert off[~lifted].max() <= report.path_tip_error + 3e-4
    assert turned[~lifted].max() <= report.path_axis_error + 2e-3
    known = [move for move in moves if not np.isnan(move.nose(model, 0.0)).any()]
    least = sum(judge.at_constant_speed(model, move) for move in known)
    most = sum(judge.rest_to_rest(model, move) for move in known)
    assert 0.98 * least - 0.01 <= report.time <= 1.02 * most + 0.01
