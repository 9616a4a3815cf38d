"""The cubic of lesson 06b as a panel: its line against errors that are sampled here on SciPy's own cubic."""

import re

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from mathpost.interface import workbench
from mathpost.path import cl, selection
from mathpost.teaching.course.lesson_data import data, load

REGION = (1, 2)


@pytest.fixture(scope="module")
def blade():
    """Machine, CL data and the joints that were chosen."""
    kin, path = load("dmu50v"), cl.read(data("cl/blade.cl"))
    return kin, path, selection.choose(kin, path).joints


def sampled(kin, path, joints, n, k_1, k_2):
    """Tip error, mm, and angle from the plane of the arc, degrees, at 400 points of each block."""
    rotary = CubicSpline([0, 1], joints[1:3, 3:], bc_type=((1, k_1), (1, k_2)))(np.linspace(0, 1, n + 2))
    wanted = path.points[1] + np.linspace(0, 1, n + 2)[:, None] * (path.points[2] - path.points[1])
    rows = kin.close(wanted, rotary)
    t = np.linspace(0, 1, 400)[:, None]
    off, apart = 0.0, 0.0
    normal = np.cross(path.axes[1], path.axes[2])
    normal /= np.linalg.norm(normal)
    for start, end, tip, tip_after in zip(rows, rows[1:], wanted, wanted[1:], strict=False):
        tips, axes = kin.forward(start + t * (end - start))
        off = max(off, np.linalg.norm(tips - tip - t * (tip_after - tip), axis=1).max())
        apart = max(apart, np.abs(np.arcsin(axes @ normal)).max())
    return off, np.degrees(apart)


@pytest.mark.parametrize(
    ("n", "dt", "times"),
    [(5, (1, 1), (1, 1)), (40, (2, 0.5), (1, 1)), (80, (1, 1), (0.5, 1.5)), (20, (0.4, 1.7), (0, 2))],
)
def test_the_line_says_what_is_sampled(blade, n, dt, times):
    kin, path, joints = blade
    panel = workbench.spline(*blade, REGION)
    panel.n.value = n
    for controls, values in ((panel.dt, dt), (panel.slopes, times)):
        for control, value in zip(controls, values, strict=True):
            control.value = value
    k_1 = times[0] * (joints[1] - joints[0])[3:] / dt[0]
    k_2 = times[1] * (joints[3] - joints[2])[3:] / dt[1]
    said = re.search(r"tip ([\d.]+) mm, tool axis ([\d.]+)° at most from the CL data, ([\d.]+) s", panel.said.value)
    tip, axis, seconds = map(float, said.groups())
    wanted = sampled(kin, path, joints, n, k_1, k_2)
    assert tip <= wanted[0] + 1e-4 and axis == pytest.approx(wanted[1], abs=2e-3)
    assert tip == pytest.approx(wanted[0], rel=0.1)
    assert 5 < seconds < 8, "half a turn at 36°/s, and what is about it"
