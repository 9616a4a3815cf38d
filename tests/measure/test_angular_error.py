"""ISO 230-2 statistics and compensation tables of a rotary axis."""

from pathlib import Path

import numpy as np
import pytest

from mathpost.errors import InputError
from mathpost.shop.measure import angular_error, spline

DATA = Path(__file__).parent.parent.parent / "data"


def test_statistics_of_iso_230_2(example):
    result = angular_error.accuracy(example)
    assert result.s_up == pytest.approx(np.full(4, 0.316228), abs=5e-7)
    assert result.s_down == pytest.approx(np.full(4, 0.158114), abs=5e-7)
    assert result.reversal == pytest.approx([1, 1.5, 1.2, 0.5])
    assert (result.B, result.M, result.E[2]) == pytest.approx((1.5, 15.85, 17.2))
    assert result.R[2] == pytest.approx(2.44868, abs=5e-6)
    assert result.A[2] == pytest.approx(18.1487, abs=5e-5)
    assert result.E[:2] == pytest.approx((16, 15.7))
    assert result.R[:2] == pytest.approx((4 * 0.3162278, 4 * 0.1581139))


def test_repeatability_in_one_direction_can_be_the_widest():
    runs = angular_error.from_arrays([0, 90], [[-3, 3], [0, 0.0]], [[0, 0.1], [0, 0.1]])
    result = angular_error.accuracy(runs)
    assert result.R[2] == result.R[0] > result.R[1]


def test_an_offset_of_the_encoder_changes_no_range(example):
    moved = angular_error.from_arrays(example.angles, example.up + 7, example.down + 7)
    before, after = angular_error.accuracy(example), angular_error.accuracy(moved)
    for name in ("B", "M", "E", "R", "A"):
        assert getattr(after, name) == pytest.approx(getattr(before, name)), name


def test_a_compensated_axis_arrives(example):
    error = spline.through_all(
        angular_error.read_runs(DATA / "measurements/angular_error.csv").points(endless=True)
    )
    targets = np.arange(0, 360, 2.5)
    commands = angular_error.commands(error, targets)
    arrival = commands + error(commands) / 3600
    assert np.abs(arrival - targets).max() * 3600 < 0.005
    assert np.abs(error(targets)).max() > 10


def test_the_command_table_is_a_table_that_can_be_read_back(example):
    error = spline.through_all(example.points(endless=True))
    rows = [line.split(",") for line in angular_error.command_table(error, [0, 90, 360]).splitlines()[1:]]
    assert rows[0] == ["target", "error", "correction", "command"]
    assert rows[2] == ["90.000000", "9.250", "-9.250", "89.997431"]
    assert rows[1][1:3] == rows[3][1:3] and float(rows[3][3]) == pytest.approx(360 + float(rows[1][3]), abs=1e-6)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("angle,up1,down1,up2\n0,1,1,1\n", "line 1.*no 'down2'"),
        ("angle,up1,down1,up2,down2,up3\n0,1,1,1,1,1\n", "no 'down3'"),
        ("angle,up1,down1,up2,down2\n0,1,1,1,1\n3600,1,1,1,1\n", "line 3, column 'angle'.*found 3600"),
        ("angle,up1,down1,up2,down2\n0,1,1,1,1\n10,1,1,7200,1\n", "line 3, column 'up2'.*other units.*found 7200"),
        ("angle,up1,down1,up2,down2\n10,1,1,1,1\n0,1,1,1,1\n", "line 3, column 'angle'.*out of order"),
        ("angle,up1,down1,up2,down2\n10,1,1,1,1\n10,1,1,1,1\n", "line 3, column 'angle'.*a duplicate"),
        ("angle,up1,down1,up2,down2\n10,1,1,,1\n", "line 2, column 'up2'.*found ''"),
    ],
)
def test_files_that_are_refused(tmp_path, text, message):
    path = tmp_path / "runs.csv"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match=message):
        angular_error.read_runs(path)


@pytest.mark.parametrize(
    ("head", "factor"),
    [
        ("angle,up1,down1,up2,down2", 1),
        ("# unit = deg\nC,up1,down1,up2,down2", 3600),
        ("角度,up1,down1,up2,down2", 1),
    ],
)
def test_units_and_headers(tmp_path, head, factor):
    path = tmp_path / "runs.csv"
    path.write_text(f"{head}\n0,0,0,0,0\n90,{9 / factor},{8 / factor},0,0\n", encoding="gbk")
    assert angular_error.read_runs(path).up[1, 0] == pytest.approx(9)


def test_degrees_are_not_taken_for_seconds_of_arc(tmp_path):
    path = tmp_path / "runs.csv"
    path.write_text("angle,up1,down1,up2,down2\n0,0,0,0,0\n90,0.0025,0.0022,0.0024,0.002\n", encoding="utf-8")
    with pytest.raises(InputError, match="line 2, column 'up1'.*# unit = deg"):
        angular_error.read_runs(path)


def test_arrays_that_are_refused():
    with pytest.raises(InputError, match="two runs or more"):
        angular_error.from_arrays([0, 90], [[1], [1]], [[1], [1]])
    with pytest.raises(InputError, match="down"):
        angular_error.from_arrays([0, 90], np.zeros((2, 3)), np.zeros((2, 2)))
    with pytest.raises(InputError, match="increasing"):
        angular_error.from_arrays([0, 0], np.zeros((2, 3)), np.zeros((2, 3)))
