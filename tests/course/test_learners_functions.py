"""Lesson 06's own functions, as they stand in its cells, on a machine that no lesson programs: a nutating head."""

import json
from itertools import pairwise

import numpy as np
import pytest

from mathpost.course.lesson_data import load
from tests.conftest import ROOT

CELLS = ("pole-candidates", "measure", "division", "division-2", "stations", "followed")
HANGS = np.array([0, 0, 380.0])  # from the tip up to the point where both axes of the head meet, mm


def turned(axis, angle):
    """Rodrigues' formula, for an array of angles."""
    x, y, z = np.array(axis) / np.linalg.norm(axis)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    angle = np.asarray(angle)[..., None, None]
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * (cross @ cross)


class Head:
    """What the lesson asks of a machine, in NumPy: C about the vertical, B at 45° to it, X Y Z of the tip."""

    workpiece_side = 3

    def forward(self, joints):
        head = turned([0, 0, 1], joints[..., 3]) @ turned([0, 1, 1], joints[..., 4])
        return joints[..., :3] + HANGS - head @ HANGS, head[..., 2]

    def close(self, tip, rotary):
        head = turned([0, 0, 1], rotary[..., 0]) @ turned([0, 1, 1], rotary[..., 1])
        return np.concatenate([tip - HANGS + head @ HANGS, rotary], axis=-1)

    def inverse(self, tip, axis):
        i, j, k = axis
        below = (i**2 + j**2 + (k - 1) ** 2) / 2
        half = np.arctan2(np.sqrt(below), np.sqrt(1 - below))
        found = []
        for b in (2 * half, -2 * half):
            w = turned([0, 1, 1], b)[:, 2]
            c = np.arctan2(w[0] * j - w[1] * i, w[0] * i + w[1] * j)
            found.append(self.close(tip, np.array([c, b])))
        return np.array(found)


@pytest.fixture(scope="module")
def own():
    """The functions of the cells, by name."""
    notebook = json.loads((ROOT / "notebooks/06_singular_region.ipynb").read_text(encoding="utf-8"))
    source = {cell["id"]: "".join(cell["source"]) for cell in notebook["cells"]}
    names = {"np": np, "pairwise": pairwise, "t": np.linspace(0, 1, 2001)}
    for cell in CELLS:
        exec(source[cell], names)
    return names


def proved(own, kin, poses, tips, axes):
    """The largest errors of tip and tool axis, mm and degrees, of the blocks between all poses."""
    errors = []
    for number, pair in enumerate(pairwise(poses)):
        segment = tips[number : number + 2], axes[number : number + 2]
        blocks = [pair[0], *own["through"](kin, *pair, segment)]
        errors += [own["error"](kin, *two, segment) for two in pairwise(blocks)]
    return np.max(errors, axis=0)


def test_the_head_is_that_of_the_package():
    kin, poses = load("nutating_head"), np.random.default_rng(3).uniform(-2, 2, (50, 5))
    for ours, theirs in zip(Head().forward(poses), kin.forward(poses), strict=True):
        assert ours == pytest.approx(theirs, abs=1e-9)
    tip, axis = kin.forward(poses[0])
    assert Head().inverse(tip, axis) == pytest.approx(kin.inverse(tip, axis), abs=1e-9)


@pytest.mark.parametrize("width", [10, 40])
@pytest.mark.parametrize("lowest", [-180, -1])
def test_eleven_records_one_of_them_at_the_pole(own, width, lowest):
    """With B to both sides C does not swing, with B from -1° it does; both keep 0.01 mm and 0.1°."""
    kin, tilt = Head(), np.radians(np.linspace(-width, width, 11))
    axes = np.stack([np.sin(tilt) * np.cos(1.1), np.sin(tilt) * np.sin(1.1), np.cos(tilt)], axis=1)
    axes[5] = [0, 0, 1]
    tips = np.stack([np.linspace(30, 50, 11), np.linspace(-9, 9, 11) ** 2 / 9, np.zeros(11)], axis=1)
    poses = []
    for record in own["candidates"](kin, tips, axes):
        inside = [pose for pose in record if pose[4] > np.radians(lowest)]
        before = poses[-1] if poses else inside[-1]
        for pose in inside:
            pose[3] = before[3] + own["shorter"](pose[3] - before[3])
        poses.append(min(inside, key=lambda pose: abs(pose[3] - before[3])))
    tip, axis = proved(own, kin, poses, tips, axes)
    assert tip <= 0.01 and axis <= 0.1
    swing = np.degrees(np.abs(np.diff([pose[3] for pose in poses])).max())
    assert (swing > 90) == (lowest == -1)


@pytest.mark.parametrize("name", ["own", "dmu50v", "ac_table", "head_b_table_c"])
@pytest.mark.parametrize("beside", [-0.3, -0.05, 0.05])
@pytest.mark.parametrize("branch", [0, 1])
def test_beside_the_pole_halving_ends(own, name, beside, branch):
    """In the direction in which the branch goes, also where that is more than half a turn."""
    kin = Head() if name == "own" else load(name)
    along, off = np.radians([-15, 25]), np.radians(beside)
    axes = np.stack([np.sin(along) * np.cos(off), [np.sin(off)] * 2, np.cos(along) * np.cos(off)], axis=1)
    tips = np.array([[30, 0, 0], [31, 2, 0.0]])
    one, two = (kin.inverse(tip, axis)[branch] for tip, axis in zip(tips, axes, strict=True))
    tip, axis = proved(own, kin, [one, own["followed"](kin, one, two, axes)], tips, axes)
    assert tip <= 0.01 and axis <= 0.1
