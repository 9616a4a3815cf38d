"""One rotation in every notation, against SciPy; what is none, with its reason."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from mathpost import read_rotation
from mathpost.detective.notations import WRITERS
from mathpost.errors import InputError
from mathpost.euler import SEQUENCES
from mathpost.interface.shell.main import main

WAYS = [*SEQUENCES, *map(str.lower, SEQUENCES)]
ANGLES = st.tuples(*[st.sampled_from([0, 90, -90, 180, 1e-7]) | st.floats(-180, 180)] * 3)
# As SciPy writes what each of the writers has; those with axes, as their columns.
SAID = {
    "kuka": lambda r: r.as_euler("ZYX", degrees=True),
    "fanuc": lambda r: r.as_euler("xyz", degrees=True),
    "abb": lambda r: r.as_quat()[[3, 0, 1, 2]] * np.sign(r.as_quat()[3]),
    "ur": lambda r: r.as_rotvec(),
    "staubli": lambda r: r.as_euler("XYZ", degrees=True),
    "kawasaki": lambda r: r.as_euler("ZYZ", degrees=True),
    "step": lambda r: r.as_matrix().T[[2, 0]].ravel(),
    "ros": lambda r: r.as_quat() * np.sign(r.as_quat()[3]),
    "urdf": lambda r: r.as_euler("xyz"),
    "heidenhain": lambda r: r.as_euler("xyz", degrees=True),
    "siemens": lambda r: r.as_euler("xyz", degrees=True),
    "g68": lambda r: r.as_euler("ZXZ", degrees=True),
    "nx": lambda r: r.as_matrix().T[:2].ravel(),
    "mom": lambda r: r.as_matrix().T.ravel(),
}
MIRROR = "0.8903889 0.0212530 0.4547048 0.0601415 -0.9956453 -0.0712306 -0.4512115 -0.0907696 0.8877891"


@given(ANGLES, st.sampled_from(WAYS))
def test_angles_of_any_sequence_and_both_solutions(angles, way):
    right, found = Rotation.from_euler(way, angles, degrees=True), read_rotation(way, angles)
    assert np.abs(found.matrix - right.as_matrix()).max() < 1e-9
    for each in found.angles(way):
        assert np.abs(Rotation.from_euler(way, each, degrees=True).as_matrix() - found.matrix).max() < 1e-9


@pytest.mark.parametrize("writer", WRITERS)
def test_what_each_writer_has_goes_in_and_out(writer):
    for right in Rotation.random(20, rng=4):
        numbers = SAID[writer](right)
        found, said = read_rotation(writer, numbers), WRITERS[writer]
        assert not found.fault and np.abs(found.matrix - right.as_matrix()).max() < 1e-9
        assert np.abs(found.written(said["as"], radians=said.get("unit") == "rad") - numbers).max() < 1e-6


def test_axis_and_angle_and_one_direction_into_another():
    for right in Rotation.random(20, rng=5):
        vector = right.as_rotvec()
        angle = np.linalg.norm(vector)
        found = read_rotation("axis-angle", [*vector, angle], radians=True)
        assert np.abs(found.matrix - right.as_matrix()).max() < 1e-9
        first, second = right.as_matrix()[:2]
        shortest = read_rotation("from-to", [*first, *second])
        assert np.abs(shortest.matrix @ first - second).max() < 1e-9 and abs(shortest.axis_angle[0] @ first) < 1e-9
    assert np.abs(read_rotation("from-to", [0, 0, 2, 0, 0, -1]).matrix @ [0, 0, 1] + [0, 0, 1]).max() < 1e-12
    assert read_rotation("vector", [0, 0, 0]).axis_angle[1] == 0
    assert "13.0000°" in str(read_rotation("vector", [0, 0, 13], radians=False))


def test_of_two_axes_the_first_is_kept():
    for kind in ("x-y", "x-z", "z-x"):
        found = read_rotation(kind, [1, 2, 3, 3, 2, -1])
        kept, other = ("XYZ".index(letter) for letter in kind.upper().split("-"))
        assert np.abs(found.matrix[:, kept] - np.array([1, 2, 3]) / 14**0.5).max() < 1e-12
        assert found.matrix[:, other] @ [3, 2, -1] > 0 and np.linalg.det(found.matrix) > 0
        assert "made square" in str(found)
    with pytest.raises(InputError, match="not parallel"):
        read_rotation("z-x", [0, 0, 1, 0, 0, -2])


FAULTS = {  # numbers, how they are wrong, and what is said
    MIRROR: "Determinant −1: a reflection, left-handed axes. No angles give it.",
    "2 0 0 0 2 0 0 0 2": "all axes have the length 2, not 1",
    "1 0.1000 0 0 1 0 0 0 1": "X and Y axis are 84.2894° apart",
    "1 0 0 0 2 0 0 0 1": "its columns, have the lengths 1.000000 2.000000 1.000000",
    "1 0 0 0 1 0 1 1 0": "lie in one plane",
}


@pytest.mark.parametrize("numbers", FAULTS)
def test_a_matrix_that_is_none_has_its_reason(numbers, capsys):
    assert main(["rotation", "matrix", *numbers.split()]) == 1
    assert FAULTS[numbers] in capsys.readouterr().out


def test_which_axis_turned_round_makes_a_reflection_a_rotation(capsys):
    main(["rotation", "matrix", *MIRROR.split()])
    assert "With Y (column 2) turned round" in capsys.readouterr().out
    for right in Rotation.random(10, rng=6):
        columns = right.as_matrix() * [1, 1, -1]
        found = read_rotation("matrix", columns)
        assert np.linalg.det(found.matrix) > 0.99
        assert sorted(np.abs(found.matrix - columns).max(axis=0) > 1e-9) == [False, False, True]


@pytest.mark.parametrize("decimals", [2, 3, 4, 6, 9])
def test_rounding_is_no_fault_and_more_than_that_is(decimals):
    for right in Rotation.random(20, rng=decimals):
        written = [f"{entry:.{decimals}f}" for entry in right.as_matrix().ravel()]
        assert not read_rotation("matrix", written).fault
        if decimals > 2:
            off = right.as_matrix() + np.diag([4e-2 if decimals == 3 else 2e-3, 0, 0]) * right.as_matrix()[0, 0]
            assert read_rotation("matrix", [f"{x:.{decimals}f}" for x in off.ravel()]).fault or abs(off[0, 0]) < 0.5


def test_the_lock_is_said_as_far_as_the_digits_tell(capsys):
    main("rotation ZYX 10 90 30".split())
    assert "locked: only first - third is known, -20.0000" in capsys.readouterr().out
    rounded = Rotation.from_euler("ZYX", [10, 89.99, 30], degrees=True).as_matrix().round(3)
    found = read_rotation("matrix", rounded)
    assert found.locked("ZYX") and not found.locked("ZXZ")


def test_the_answer_ends_with_the_inverse(capsys):
    right = Rotation.from_euler("ZYX", [10, 20, 30], degrees=True).as_matrix()
    assert main(["rotation", "matrix", *map(str, right.T.ravel())]) == 0
    assert "ZYX 10.0000 20.0000 30.0000" in capsys.readouterr().out.split("the inverse")[1]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("rotation foo 1 2 3", "expected matrix, rows, wxyz"),
        ("rotation kuka 1 2", "kuka: expected 3 numbers, found 2"),
        ("rotation wxyz 0 0 0 0", "one of length zero"),
        ("rotation ZYX 1 2 x", "expected numbers, found 'x'"),
        ("rotation matrix " + "1 " * 16, "9 numbers"),
    ],
)
def test_what_cannot_be_read_is_refused(words, said, capsys):
    assert main(words.split()) == 2
    assert said in capsys.readouterr().err


def test_brackets_and_decimal_commas_are_read(capsys):
    assert main(["rotation", "wxyz", "[0,5,", "-0,5,", "0.5,", "0.5]"]) == 0
    assert "120.0000°" in capsys.readouterr().out
