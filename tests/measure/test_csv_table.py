"""CSV tables: what is read, and that every fault is named with its file and line."""

from pathlib import Path

import numpy as np
import pytest

from mathpost.errors import InputError
from mathpost.shop.measure import csv_table

DATA = Path(__file__).parent.parent.parent / "data"


@pytest.fixture
def write(tmp_path):
    def write(text):
        path = tmp_path / "readings.csv"
        path.write_text(text, encoding="utf-8")
        return path

    return write


def test_columns_in_any_order_with_comments_blank_lines_and_words(write):
    path = write('# source: a "test, of sorts\n\n y , angle,way\n 1.5, 0, up\n\n# a remark\n-2e-3,90,down\n')
    read = csv_table.read(path, ["angle", "y"], optional=["way", "z"], text=["way"])
    np.testing.assert_array_equal(read["angle"], [0, 90])
    np.testing.assert_array_equal(read["y"], [1.5, -2e-3])
    assert read["way"] == ["up", "down"] and read.lines == (4, 7)
    assert "z" not in read and len(read["y"]) == 2


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("angle,x\n0,1\n", "line 1: expected the columns angle, y, found angle, x: no 'y'"),
        (
            "angle,y,torque\n0,1,2\n",
            "says what they are (remark, if they are no readings), found 'torque'",
        ),
        ("angle,y,y\n0,1,2\n", "line 1: expected every column once, found 'y' 2 times"),
        ("# s\nangle,y\n0,1\n1\n", "line 4: expected 2 entries, found 1"),
        ("angle,y\n0,1\n1,\n", "line 3, column 'y': expected a number with a decimal point, found ''"),
        ("angle,y\n0,one\n", "line 2, column 'y': expected a number with a decimal point, found 'one'"),
        ("angle,y\n0,inf\n", "line 2, column 'y': expected a number with a decimal point, found 'inf'"),
        ("angle,y\n", "found no readings"),
        ("", "found no readings"),
    ],
)
def test_faults_name_file_line_and_column(write, text, message):
    path = write(text)
    with pytest.raises(InputError) as error:
        csv_table.read(path, ["angle", "y"])
    assert str(path) in str(error.value) and message in str(error.value)


def test_a_unit_behind_a_name_is_obeyed(tmp_path):
    path = tmp_path / "units.csv"
    path.write_text("# unit = µm\nangle (rad),x (in),dial (0.002 mm),y,z (front)\n0.5,2,10,7,1\n")
    read = csv_table.read(path, ["angle", "x", "dial", "y", "z"])
    assert [read.unit(name, "length") for name in ("x", "dial", "y")] == [25.4, 0.002, 1e-3]
    for name in ("angle", "z"):
        with pytest.raises(InputError, match=f"'{name}': expected its unit.*found '(rad|front)'"):
            read.unit(name, "length")
    read.obey_units(["angle", "x", "z"])
    assert read["angle"] == np.degrees(0.5) and read["x"] == 50.8 and read["z"] == 1 and read["y"] == 7


def test_a_file_that_contradicts_itself(tmp_path):
    path = tmp_path / "two_units.csv"
    path.write_text("# unit = µm\n# unit = µm\n# unit = mm\nangle,x\n0,1\n")
    with pytest.raises(InputError, match="two_units.csv, line 3: expected one line # unit = …, found"):
        csv_table.read(path, ["angle", "x"])


@pytest.mark.parametrize(
    ("angles", "message"),
    [
        ([0, 90, 3600], "line 4, column 'angle': expected degrees within ±360"),
        ([0, 1.5708, 3.1416, 4.7124], "line 3, column 'angle': expected degrees (these look like radians)"),
    ],
)
def test_suspected_units(write, angles, message):
    read = csv_table.read(write("angle\n" + "\n".join(map(str, angles))), ["angle"])
    with pytest.raises(InputError) as error:
        read.check_angles("angle")
    assert message in str(error.value)


@pytest.mark.parametrize("angles", [[0], [-5, 5], [0, 0.5, 1, 2.5], [-360, 360], [0, 3.1416, 90]])
def test_degrees_pass(write, angles):
    csv_table.read(write("angle\n" + "\n".join(map(str, angles))), ["angle"]).check_angles("angle")


def test_order_and_duplicates(write):
    read = csv_table.read(write("height,angle\n50,0\n50,90\n350,0\n350,90\n"), ["height", "angle"])
    read.check_increasing("angle", within=["height"])
    with pytest.raises(
        InputError, match=r"line 4, column 'angle': expected more than 90.* line 3, found 0, out of"
    ):
        read.check_increasing("angle")
    with pytest.raises(InputError, match=r"line 3, column 'height': expected more than 50.*a duplicate"):
        read.check_increasing("height")


@pytest.mark.parametrize("path", sorted(DATA.rglob("*.csv")), ids=lambda path: path.name)
def test_every_shipped_table_names_its_source(path):
    assert path.read_text(encoding="utf-8").startswith("# ")
