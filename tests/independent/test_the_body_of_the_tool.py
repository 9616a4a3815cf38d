"""The tool's body while it unwinds or retracts: a cylinder held against all points that the path sweeps."""

import numpy as np
import pytest

from mathpost import load_machine, postprocess
from mathpost.errors import MathpostError
from mathpost.path import cl as cldata
from tests.conftest import DATA
from tests.independent import judge
from tests.independent.machine_model import Model
from tests.independent.reader import Setup, read
from tests.post.test_unwinding import with_c_to_200

MACHINES = ("ac_table", "bc_table", "head_b_table_c")
CONTROLS = ("heidenhain", "fanuc", "siemens", "linuxcnc", "haas", "mazak")
LENGTH, RADIUS = 80.0, 4.9  # mm, of the tool
NEAR = 0.5  # mm above the tip, below which the tool touches the part


def unwinding(rng):
    """A path round a random surface of revolution, wider than the tool, which is square to it."""
    t = np.linspace(0, rng.uniform(1.2, 2.5) * 2 * np.pi, 60)
    slope, radius = rng.uniform(0.4, 1.3), rng.uniform(15, 60) + rng.uniform(-3, 3) * t
    radius += max(0, 2 * RADIUS - radius.min())
    points = np.stack([radius * np.cos(t), radius * np.sin(t), -radius / np.tan(slope)], axis=1)
    axes = np.stack([np.cos(t) * np.cos(slope), np.sin(t) * np.cos(slope), np.full(60, np.sin(slope))], axis=1)
    return points, axes


def over_a_saddle(rng):
    """A path over a random saddle or dome whose tool axis passes close by the pole."""
    t = np.linspace(-1, 1, 41)
    bend, lean, beside = rng.uniform(-0.006, 0.006), rng.uniform(8, 20), rng.uniform(0.02, 0.6)
    points = np.stack([30 * t, rng.uniform(-5, 5) * t, bend * (30 * t) ** 2], axis=1)
    angle, off = np.radians(lean) * t, np.radians(beside)
    axes = np.stack([np.sin(angle) * np.cos(off), np.full(41, np.sin(off)), np.cos(angle) * np.cos(off)], axis=1)
    return points, axes


def to_polyline(tips, points):
    """Distances of tips, (n, 3), to the line through points."""
    start, along = points[:-1], np.diff(points, axis=0)
    off = tips[:, None] - start
    t = np.clip((off * along).sum(axis=2) / (along**2).sum(axis=1), 0, 1)
    return np.linalg.norm(off - t[..., None] * along, axis=2).min(axis=1)


def verdict(seed):
    """ "refused", "nothing lifted", or how deep a swept point is in the tool in the air, mm."""
    rng = np.random.default_rng(seed)
    name, control, tcp = MACHINES[seed % 3], CONTROLS[(seed // 3) % 6], bool((seed // 2) % 2)
    splits = seed % 2 == 0
    points, axes = unwinding(rng) if splits else over_a_saddle(rng)
    setup = (with_c_to_200(name) if splits else load_machine(name)).with_setup(tool_length=LENGTH)
    how = {"split": True} if splits else {"singular": "retract"}
    try:
        result = postprocess(cldata.from_arrays(points, axes, feed=900), setup, dialect=control, tcp=tcp, **how)
    except MathpostError as error:
        assert "meets the point" in str(error) or "outside" in str(error), error
        return "refused"
    model = Model(DATA / "machines" / f"{name}.toml", length=LENGTH, origin=setup.origin)
    moves = read(result.program, control, Setup(model, length_on=True))
    samples = judge.sample(model, moves, least=30, turn=0.7)
    fine = np.linspace(0, 1, 8, endpoint=False)[:, None, None]
    swept = np.concatenate([(points[:-1] + fine * np.diff(points, axis=0)).reshape(-1, 3), points[-1:]])
    from_path = to_polyline(samples.tip, points)
    air = from_path > 1.0
    if not air.any():
        return "nothing lifted"
    # The part is touched by the end of the tool: what is less than `NEAR` above it does not count.
    deep = [
        judge.depth_in_tool(swept, tip + NEAR * axis, axis, RADIUS, LENGTH - NEAR)
        for tip, axis in zip(samples.tip[air], samples.axis[air], strict=True)
    ]
    return max(deep)


@pytest.mark.parametrize("seed", range(6))
def test_unwound_and_retracted_tools_stay_clear_of_what_the_path_sweeps(seed, of):
    for each in of([seed], range(seed, 300, 6)):
        found = verdict(7000 + each)
        assert found in ("refused", "nothing lifted") or found < 1e-3
