"""The body of a tool in a box of slides, and of all axes: against a dense sample of places and points."""

from itertools import product

import numpy as np
import pytest

from mathpost import load_machine, postprocess
from mathpost.kinematics import Kinematics
from mathpost.path import cl
from mathpost.shop.post.body import ABOVE, BODY, Body
from mathpost.shop.post.clear import CLEAR, Ways, judged
from mathpost.shop.post.cuts import Cuts
from tests.conftest import DATA
from tests.independent import judge
from tests.independent.machine_model import Model


def deepest(axis, length, ends, lines):
    """How far inside the cylinder, mm, a point of the lines comes from a grid of places of the tip."""
    grid = np.array(list(product(*np.linspace(ends[0], ends[1], 9).T)))
    points = np.concatenate([lines[0] + t * (lines[1] - lines[0]) for t in np.linspace(0, 1, 25)])
    off = points[:, None] - grid
    along = off @ axis
    beside = np.linalg.norm(np.cross(off, axis), axis=-1)
    return np.minimum(BODY - beside, np.minimum(along - ABOVE, length - along)).max()


@pytest.mark.parametrize("seed", range(2))
def test_what_is_clear_meets_no_line(seed):
    rng, seen = np.random.default_rng(seed), []
    for _ in range(100):
        axis = rng.normal(size=3)
        axis /= np.linalg.norm(axis)
        length = rng.choice([12.0, 60.0])
        body = Body(axis, length)
        ends = rng.uniform(-8, 8, 3) + np.array([np.zeros(3), rng.uniform(-15, 15, 3)])
        starts = rng.uniform(-45, 45, (4, 3))
        lines = np.array([starts, starts + rng.uniform(-20, 20, (4, 3))])
        near = lines[:, body.near(ends, lines.min(axis=0).T, lines.max(axis=0).T)]
        clear, sure, depth = (
            not body.meets(ends, near).any(),
            bool(body.surely_meets(ends, near).any()),
            deepest(axis, length, ends, lines),
        )
        assert not (clear and depth > 0)
        assert not (sure and depth < -1.5)  # between the places of the grid
        seen.append((clear, sure, depth > 0))
    assert {(True, False, False), (False, True, True)} <= set(seen)
    assert np.mean([clear or hit for clear, _, hit in seen]) > 0.85  # the few directions part nearly all


@pytest.mark.parametrize("name", ["ac_table", "head_b_table_c", "nutating_head"])
def test_a_way_is_clear_if_the_axes_may_be_anywhere_between_its_ends(name):
    """Slides and rotary axes move; each is anywhere in its part of the box, by kinematics of another kind."""
    model, setup, rng = Model(DATA / f"machines/{name}.toml"), load_machine(name), np.random.default_rng(3)
    kin, seen = Kinematics(setup), []
    for _ in range(40):
        points = rng.uniform(-60, 60, (30, 3))
        cuts = Cuts(np.array([points, points]), np.tile([0.0, 0.0, 1.0], (30, 1)), np.arange(30.0))
        turned = np.radians(rng.uniform(-25, 25, (2, 2)))
        tips = np.array([[*rng.uniform(-50, 50, 2), rng.uniform(0, 200)]] * 2)
        tips[1] += rng.uniform(-30, 30, 3)
        ends = kin.close(tips, turned)
        never = np.zeros(2, bool)
        ways = Ways(ends, np.full(2, -1.0), never, never, np.full(2, -1), ~never, never)
        (found,) = judged(kin, ways, np.array([1]), cuts)
        places = ends[0] + rng.uniform(0, 1, (400, 5)) * (ends[1] - ends[0])
        deep = 0.0
        for joints in places:
            nose = model.nose_of_words(joints[:3], model.length)
            tip, axis = model.place(nose, np.degrees(joints[3:]))
            deep = max(deep, judge.depth_in_tool(points, tip + ABOVE * axis, axis, BODY, model.length - ABOVE))
        assert not (found == CLEAR and deep > 0)
        seen.append((found == CLEAR, deep > 0))
    assert {(True, False), (False, True)} <= set(seen)
    assert sum(clear for clear, _ in seen) > 0.6 * sum(not hit for _, hit in seen)  # few are given up


@pytest.mark.parametrize("tcp", [False, True])
@pytest.mark.parametrize("way", ["retract", "cubic lifted"])
@pytest.mark.parametrize("dialect", ["fanuc", "haas", "mazak"])
def test_what_is_lifted_is_rapid_where_each_axis_runs_at_its_own_rate(dialect, way, tcp):
    """Both ways lift by 20 mm: with the tool there, no order of the axes meets the blade."""
    blade = cl.read(DATA / "cl/blade.cl")
    result = postprocess(blade, load_machine("dmu50v"), dialect=dialect, singular=way, tcp=tcp)
    rapid = np.flatnonzero(result.blocks.rapid)
    assert len(rapid) > 6 and (np.diff(rapid) == 1).all()
    assert not any("blocks at a feed" in each for each in result.report.warnings)
