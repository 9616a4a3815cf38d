"""Error files: what they mean in mm and radians, and what is refused with file, line and key."""

import numpy as np
import pytest

from mathpost import load_machine
from mathpost.errors import InputError, ReachError
from mathpost.shop.compensate.model import constant_errors, error_names, read_errors

HEAD = 'name = "n"\nsource = "s"\nmachine = "c8293b4b6b1a"\n'


@pytest.fixture(scope="module")
def trunnion():
    return load_machine("data/machines/bc_table.toml")


@pytest.fixture
def load(tmp_path, trunnion):
    def load(toml, csv=""):
        (tmp_path / "errors.toml").write_text(HEAD + toml, encoding="utf-8")
        (tmp_path / "axis.csv").write_text(csv, encoding="utf-8")
        return read_errors(tmp_path / "errors.toml", trunnion)

    return load


C_ENDLESS = '[[table]]\njoint = "C"\nfile = "axis.csv"\nendless = true\n'


def value(errors, name, joints):
    return errors.at(joints)[..., error_names(errors.machine).index(name)]


def test_units_constants_and_tables_add_up(load):
    errors = load(
        '[constant]\nEXB = 5\nECC = 100\nEA0Z = -7\n[[table]]\njoint = "C"\nfile = "axis.csv"\nendless = true\n',
        "position,ECC,EZC\n0,10,1\n90,20,2\n180,-10,-1\n270,0,0\n",
    )
    joints = np.array([1, 2, 3, 0.4, np.pi / 2])
    assert value(errors, "EXB", joints) == pytest.approx(0.005)
    assert value(errors, "EA0Z", joints) == pytest.approx(-7e-6)
    assert value(errors, "ECC", joints) == pytest.approx(120e-6)
    assert value(errors, "EZC", joints) == pytest.approx(0.002)
    turned = np.add(joints, [0, 0, 0, 0, 4 * np.pi])
    np.testing.assert_allclose(errors.at(turned), errors.at(joints), rtol=0, atol=1e-15)
    assert np.count_nonzero(errors.varying(joints)) == 2


def test_a_slide_counts_from_the_machine_not_from_the_work_offset(load):
    # The work offset of this machine is X 20.
    errors = load(
        '[[table]]\njoint = "X"\nfile = "axis.csv"\ninterpolation = "linear"\n', "position,EYX\n0,0\n100,10\n"
    )
    assert value(errors, "EYX", [30, 0, 0, 0, 0]) == pytest.approx(0.005)
    assert value(errors, "EYX", [80.05, 0, 0, 0, 0]) == pytest.approx(0.010)  # as far as a correction may go
    with pytest.raises(ReachError, match="X: 120 was not measured: 0 to 100 was"):
        errors.at([100, 0, 0, 0, 0])


def test_every_file_in_the_repository_belongs_to_a_machine():
    trunnion = load_machine("data/machines/ac_table.toml")
    errors = read_errors("data/errors/ac_table.toml", trunnion)
    assert np.count_nonzero(errors.constant) == 11 and {index // 6 for index, _ in errors.curves} == {0, 3, 4}


def test_a_unit_behind_a_name_is_obeyed(load):
    errors = load(C_ENDLESS, "position (rad),ECC (arcsec),EZC (mm)\n0,10,0.1\n1,20,0.2\n2,30,0\n")
    joints = [0, 0, 0, 0, 1]
    assert value(errors, "ECC", joints) == pytest.approx(np.radians(20 / 3600))
    assert value(errors, "EZC", joints) == pytest.approx(0.2)


@pytest.mark.parametrize(
    ("toml", "csv", "message"),
    [
        ("[constant]\nEXQ = 3\n", "", r"\[constant\], key 'EXQ'"),
        ("[constant]\nEXX = 8000\n", "", r"key 'EXX'.*um, within ±5000 \(other units\?\), found 8000"),
        ('[constant]\nEXX = "8"\n', "", r"key 'EXX'"),
        ('structure = "w C B b X Y Z t"\n', "", r"key 'structure': expected no such key"),
        ('[[table]]\njoint = "A"\nfile = "axis.csv"\n', "", r"table 1, key 'joint': expected one of X, Y, Z, B, C"),
        ('[[table]]\njoint = "B"\n', "", r"table 1, key 'file'"),
        ('[[table]]\njoint = "B"\nfile = "none.csv"\n', "", r"no file .none.csv"),
        ('[[table]]\njoint = "X"\nfile = "axis.csv"\nendless = true\n', "", r"'endless': expected a rotary joint"),
        ('[[table]]\njoint = "B"\nfile = "axis.csv"\nkind = 1\n', "", r"key 'kind'"),
        ('[[table]]\njoint = "B"\nfile = "axis.csv"\n', "position,ECC\n0,1\n", r"axis.csv, line 1.*'ECC'"),
        ('[[table]]\njoint = "B"\nfile = "axis.csv"\n', "position\n0\n1\n", r"at least one of the columns EXB"),
        ('[[table]]\njoint = "B"\nfile = "axis.csv"\n', "position,EBB\n0,1\n3600,2\n", r"line 3.*found 3600"),
        ('[[table]]\njoint = "B"\nfile = "axis.csv"\n', "position,EBB\n0,1\n0,2\n", r"line 3.*a duplicate"),
        ('[[table]]\njoint = "B"\nfile = "axis.csv"\n', "position,EBB\n9,1\n0,2\n", r"line 3.*out of order"),
        ('[[table]]\njoint = "B"\nfile = "axis.csv"\n', "position,EBB\n0,1\n9,99999\n", r"line 3.*urad within"),
        (C_ENDLESS, "position,ECC\n0,1\n360,2\n", r"axis.csv, line 1: .* at least 3 different ones, found 1"),
        (C_ENDLESS, "# unit = mm\nposition,ECC\n0,1\n90,2\n180,3\n", r"line 3, column 'ECC': .*found 'mm'"),
        ("constant = 3\n", "", r"\[constant\]"),
    ],
)
def test_files_that_are_refused(load, toml, csv, message):
    with pytest.raises(InputError, match=message):
        load(toml, csv)


@pytest.mark.parametrize(
    "name",
    [
        "/etc/passwd",
        "../axis.csv",
        "a/axis.csv",
        "C:axis.csv",
        "axis.csv.csv/..",
        ".axis.csv",
        "axis.txt",
        "link.csv",
    ],
)
def test_a_file_opens_no_file_but_those_beside_it(load, name, tmp_path):
    """Nor is anything of theirs quoted: the files are there, and hold no table."""
    for place in (tmp_path / "axis.txt", tmp_path / ".axis.csv", tmp_path.parent / "axis.csv"):
        place.write_text("root:secret", encoding="utf-8")
    (tmp_path / "link.csv").symlink_to(tmp_path.parent / "axis.csv")
    with pytest.raises(InputError, match=r"key 'file': expected the name of a \.csv file beside this one") as error:
        load(f'[[table]]\njoint = "B"\nfile = "{name}"\n', "")
    assert "secret" not in str(error.value)


def test_constants_by_name(trunnion):
    with pytest.raises(InputError, match="'EXA'"):
        constant_errors(trunnion, {"EXA": 0.01})
    with pytest.raises(InputError, match="finite numbers"):
        constant_errors(trunnion, {"EXC": np.nan})
