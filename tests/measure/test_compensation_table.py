"""Positioning errors as the tables of controls."""

import re
from pathlib import Path

import numpy as np
import pytest

from mathpost.errors import InputError
from mathpost.shop.controls import compensation_table
from mathpost.shop.measure import angular_error, spline

DATA = Path(__file__).parent.parent.parent / "data"


def test_eec_table_closes_and_moves_against_the_error(example):
    error = spline.through_all(example.points(endless=True))
    text = compensation_table.siemens("AX5", 22.5, error)
    entries = [float(value) for value in re.findall(r"COMP\[0,\d+,AX5\]=(\S+)", text)]
    assert len(entries) == 17 and entries[0] == entries[-1]
    assert entries[4] == pytest.approx(9.25 / 3600, abs=5e-7)
    assert text.startswith("%_N_AX_EEC_INI\nCHANDATA(1)\n") and text.endswith("IS_MODULO[0,AX5]=1\nM17\n")
    assert "$AA_ENC_COMP_STEP[0,AX5]=22.5\n" in text


def test_an_axis_of_limited_travel_has_no_modulo():
    error = spline.through_all(spline.points([-30, 0, 45, 90], [1, 2, 0, 3]))
    text = compensation_table.siemens("A", 15, error)
    assert "_MIN[0,A]=-30.0\n$AA_ENC_COMP_MAX[0,A]=90.0\n$AA_ENC_COMP_IS_MODULO[0,A]=0\n" in text
    with pytest.raises(InputError, match="a step that divides 120, found 25"):
        compensation_table.siemens("A", 25, error)


def test_two_directions_make_two_cec_tables(example):
    up, down = (spline.through_all(example.points(side, endless=True)) for side in ("up", "down"))
    text = compensation_table.siemens("C", 90, up, down)
    assert "$AN_CEC[0,1]=0.002778\n" in text and "$AN_CEC[1,1]=0.002361\n" in text
    assert "$AN_CEC_DIRECTION[0]=1\n" in text and "$AN_CEC_DIRECTION[1]=-1\n" in text
    open_one = spline.through_all(example.points("down"))
    with pytest.raises(InputError, match="the same range"):
        compensation_table.siemens("C", 90, up, open_one)


# Fanuc: what the control makes of the points


def points(text):
    return {int(n) - 10000: int(p) for n, p in re.findall(r"^N(1\d{4})P(-?\d+)$", text, re.M)}


def numbers(text):
    return {int(n): float(p) for n, p in re.findall(r"^N0(\d{4})A\d+P(\S+)$", text, re.M)}


def position(text, at, detection):
    """Where a point-by-point control adds its increments: from the reference position, one after the other."""
    said, data = numbers(text), points(text)
    reference, interval = int(said[3620]), said[3624]
    section = round(at / interval)
    passed = range(reference + 1, reference + section + 1), range(reference + section + 1, reference + 1)
    total = sum(data[n] for n in passed[0]) - sum(data[n] for n in passed[1])
    return at + total * said[3623] * detection


@pytest.mark.parametrize("detection", [0.001, 0.0001])
def test_fanuc_arrives_after_a_turn_and_within_rounding(detection):
    error = spline.through_all(
        angular_error.read_runs(DATA / "measurements/angular_error.csv").points(endless=True)
    )
    text = compensation_table.fanuc(5, 10, error, reference=60, detection=detection)
    said, data = numbers(text), points(text)
    assert (said[3621], said[3622], said[3625]) == (60, 96, 360)
    assert data[60] == data[96] and sum(data[n] for n in range(61, 97)) == 0
    assert max(map(abs, data.values())) <= 7
    at = np.arange(0, 361, 10)
    sent = np.array([position(text, each, detection) for each in at])
    missed = sent + (error(at) - error(0.0)) / 3600 - at
    assert np.abs(missed).max() <= said[3623] * detection / 2 + 1e-12
    assert f"rounding leaves {np.abs(missed).max():.5f}" in text


def test_fanuc_numbers_the_points_of_a_slide_as_the_manual_does():
    """Travel -400 to 800, 50 apart, reference 40: 33 to 56 (B-63980EN, example 1)."""
    at = np.arange(-400, 801, 50.0)
    error = spline.through_all(spline.points(at, 0.01 * at / 400))
    text = compensation_table.fanuc(1, 50, error, unit=1.0, reference=40)
    said = numbers(text)
    assert (said[3620], said[3621], said[3622], said[3624]) == (40, 33, 56, 50) and 3625 not in said
    assert position(text, -400, 0.001) == pytest.approx(-400 + 0.01) and position(
        text, 800, 0.001
    ) == pytest.approx(800 - 0.02)


def test_fanuc_numbers_no_point_below_0():
    error = spline.through_all(spline.points([-60.0, -30, 0, 30], [3.0, 1, 0, -2]))
    text = compensation_table.fanuc(4, 30, error)
    said = numbers(text)
    assert (said[3620], said[3621], said[3622]) == (2, 1, 3) and list(points(text)) == [1, 2, 3]
    assert position(text, -60, 0.001) == pytest.approx(-60 - 0.001) and position(text, 30, 0.001) == 30 + 0.001


@pytest.mark.parametrize("detection", [0, -0.001, np.nan])
def test_a_detection_unit_is_above_0(detection):
    error = spline.through_all(spline.points([0.0, 30, 60], [0.0, 1, 3]))
    with pytest.raises(InputError, match="detection"):
        compensation_table.fanuc(4, 30, error, detection=detection)


def test_fanuc_wants_the_reference_among_the_points():
    for at in ([10.0, 20, 30], [-25.0, 0, 25, 50, 75]):
        error = spline.through_all(spline.points(at, np.arange(len(at))))
        with pytest.raises(InputError, match="machine coordinate 0, whole steps"):
            compensation_table.fanuc(4, 20 if at[0] < 0 else 10, error)
