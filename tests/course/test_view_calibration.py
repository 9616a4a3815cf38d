"""The sliders of lessons 05 to 14 that print or record their curves: the numbers in the page are the package's."""

import json
import shutil
import subprocess

import numpy as np
import pytest

from mathpost.detective.misreadings import COMMON, common_matrices
from mathpost.machine import Rotary
from mathpost.shop.measure import horizontal_head, rotary_axis, work_offset
from mathpost.teaching.course import view_calibration as views
from mathpost.teaching.course import view_rotation

HEAD = "data/measurements/five_face_head.csv"
ISO_C = Rotary("C", "workpiece", (0, 0, -1), (0, 0, 0))


def numbers(view, *values):
    """What the page calculates at the values of the sliders, in their units."""
    if shutil.which("node") is None:
        pytest.skip("node is not installed")
    q = [float(value * each["factor"]) for value, each in zip(values, view.state["sliders"], strict=True)]
    run = f"{view.machines[0]}\nconsole.log(JSON.stringify([...numbers({q})]));"
    return json.loads(subprocess.run(["node", "-e", run], check=True, capture_output=True, text=True).stdout)


def test_a_point_goes_where_the_offset_says():
    point, centres = (-300, -250, -600), ((0, -200, -850), (-350, 0, -900))
    got = np.reshape(numbers(views.datum_after_rotation(*centres, point), -41.5, 133.25), (3, 3))
    for order, place in zip(("AB", "BA"), got, strict=False):
        table = work_offset.ab_table(*centres, order=order)
        wanted = work_offset.moved(point, table, {"A": 0, "B": 0}, {"A": -41.5, "B": 133.25}, degrees=True)
        assert place == pytest.approx(wanted, abs=1e-9)


@pytest.mark.parametrize("noise", [0, 4])
def test_the_centre_recovered_is_that_of_a_whole_fit(noise):
    got = numbers(views.rotation_centre(ISO_C), 25, -35, 45, -55, noise)
    ball, scale = rotary_axis.ball(ISO_C), np.array([1e3, 1e3, 1e6, 1e6])
    at = {"angle": np.tile(np.arange(0, 360, 30), 2), "x": 150.0, "y": 0.0, "z": np.repeat([50.0, 350.0], 12)}
    set_to = dict(zip(map(str, ball.unknowns), [25, -35, 45, -55] / scale, strict=True))
    readings = ball.simulate(set_to, at, sigma=noise / 1000, seed=1, degrees=True)
    whole = ball.identify(readings, degrees=True, sigma=max(noise, 1) / 1000)
    assert got[::2] == pytest.approx(scale * list(whole.values.values()), abs=0.05)
    if noise:
        assert got[1::2] == pytest.approx(1.96 * scale * np.sqrt(np.diag(whole.covariance)), rel=1e-3)


def test_the_zero_recovered_is_the_zero_set():
    alpha, _, dy, dl, _ = numbers(views.rtcp_zero(), -20, 15, 40, 30, 0)
    assert (alpha, dy, dl) == pytest.approx((-20, 15, 40), abs=1e-6)


def test_bars_are_as_long_as_the_misreadings_are_wrong():
    point, names, angles = (3.0, 4.0, 5.0), tuple(COMMON), np.array([33.0, -71.0, 12.5])
    right, *wrong = common_matrices(("right", *names), angles) @ point
    got = numbers(view_rotation.misreadings_apart(point, names), *angles)
    assert got == pytest.approx([np.linalg.norm(each - right) for each in wrong], abs=1e-9)


def test_a_head_recorded_says_its_block(pytestconfig):
    view = views.five_face_head(horizontal_head.fit_head(horizontal_head.read_head(pytestconfig.rootpath / HEAD)))
    kinds = [said[-1].split(";")[0] for said in view.state["said"]]
    assert kinds.count("measured") == 5 and len(kinds) == 145  # 0, 90, 180, 270 and 360 degrees
    assert all(len(frame) == 3 for frame in view.state["frames"])  # the arm and two axes
