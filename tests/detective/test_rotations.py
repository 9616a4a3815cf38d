"""Rotations compared, against SciPy: triples, quaternions of both orders, matrices."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mathpost.detective.rotations import explain_rotation
from mathpost.errors import InputError
from mathpost.interface.shell.main import main

ANGLES = np.array([20.0, 35.0, -50.0])


def made(sequence="XYZ", angles=ANGLES):
    return Rotation.from_euler(sequence, angles, degrees=True)


SAME = {
    "twin": (ANGLES, ANGLES * [1, -1, 1] + 180),
    "turns": (ANGLES, np.add(ANGLES, (360, 0, -720))),
    "matrix": (ANGLES, made().as_matrix().round(5)),
    "quaternion": (ANGLES, made().as_quat()[[3, 0, 1, 2]].round(5)),
    "minus the quaternion": (ANGLES, -made().as_quat()[[3, 0, 1, 2]].round(5)),
    "from a quaternion": (made().as_quat()[[3, 0, 1, 2]], made().as_matrix()),
    "published": ((0, 180, 0), (180, 0, 180)),
}


@pytest.mark.parametrize("way", SAME)
def test_the_same_rotation(way):
    found = explain_rotation(*SAME[way], sequence="XYZ")
    assert found.right and str(found).startswith("the same rotation"), str(found)


OTHER = {
    "turned about the fixed axes x y z, not about the turned ones": made("xyz").as_matrix(),
    "it is the inverse, the transposed matrix": made().as_matrix().T,
    "the axes are Z Y X, not X Y Z": made("ZYX").as_matrix(),
    "the quaternion is written x y z w, scalar last": made().as_quat(),
    "the sign of β is reversed": made(angles=ANGLES * [1, -1, 1]).as_matrix(),
    "α and γ are exchanged": made(angles=ANGLES[::-1]).as_matrix(),
    "the degrees of all angles are taken for radians": made(angles=np.degrees(ANGLES)).as_matrix(),
    "in the answer the axes are Z Y X, not X Y Z": made().as_euler("ZYX", degrees=True),
}


@pytest.mark.parametrize("sentence", OTHER)
def test_one_misreading(sentence):
    found = explain_rotation(ANGLES, OTHER[sentence].round(6), sequence="XYZ")
    assert found.misreadings[0].sentence == sentence, str(found)
    assert not found.right


def test_a_quaternion_and_angles_from_somewhere():
    """The given side may be a quaternion or a matrix, the answer angles."""
    matrix = made("ZYX").as_matrix().round(6)
    assert explain_rotation(matrix, ANGLES, sequence="ZYX").right
    found = explain_rotation(matrix, ANGLES, sequence="zyx")
    assert found.misreadings[0].sentence == "turned about the turned axes Z Y X, not about the fixed ones"
    found = explain_rotation(made().as_quat().round(6), made().as_matrix().round(6))
    assert found.misreadings[0].kinds == ("quaternion",)


def test_what_two_rotations_have_in_common():
    """A0 B180 and A180 B0 point the tool the same way and are not the same rotation."""
    found = explain_rotation((0, 180, 0), (180, 0, 0), sequence="XYZ")
    assert not found.right and "They differ by 180.0000° about (0.0000 0.0000 1.0000)" in found.note
    assert "the same tool axis" in found.note
    found = explain_rotation((10, 20, 30), (10, 20, 31.5), sequence="ZXZ")
    assert "differ by 1.5000°" in found.note


def test_the_lock_is_said():
    found = explain_rotation((10, 0, 40), (50, 0, 0))
    assert found.right and "only the sum or the difference" in found.note


def test_random_rotations_are_not_explained():
    rng = np.random.default_rng(5)
    for _ in range(30):
        found = explain_rotation(ANGLES, Rotation.random(None, rng).as_matrix().round(4))
        assert not found.explained, str(found)


@pytest.mark.parametrize("answer", [(1, 2), (0, 0, 0, 0), (1, 2, np.nan)])
def test_what_cannot_be_read_is_refused(answer):
    with pytest.raises(InputError):
        explain_rotation(ANGLES, answer)


@pytest.mark.parametrize(
    ("matrix", "why"),
    [(np.diag((1, 1, -1)), "Given: Determinant −1"), (np.full(9, 0.5), "Given: The three axes lie in")],
)
def test_a_matrix_that_is_none_explains_nothing(matrix, why):
    found = explain_rotation(matrix, ANGLES)
    assert not found.explained and found.note.startswith(why)


@pytest.mark.parametrize("column", [0, 1, 2])
def test_a_matrix_of_which_one_column_is_too_long_is_no_rotation(column):
    matrix = made().as_matrix()
    matrix[:, column] *= 1.002
    found = explain_rotation(ANGLES, matrix.round(6))
    assert not found.explained and "Not orthonormal to its digits" in found.note and "1.00200" in found.note


@pytest.mark.parametrize(
    ("arguments", "status", "text"),
    [
        ("--angles 0 180 0 --sequence XYZ --result 180 0 180", 0, "the same rotation"),
        ("--angles 20 35 50 --sequence xyz --result 20 35 50 --result-sequence YXZ", 1, "differ by"),
        ("--quaternion 0.5 0.5 0.5 0.5 --result 0 0 1 1 0 0 0 1 0", 0, "the same rotation"),
        ("--quaternion 0.5 0.5 0.5 0.5 --convention passive --result 0 1 0 0 0 1 1 0 0", 0, "the same rotation"),
        ("--quaternion 0.5 0.5 0.5 0.5 --result 0 0 1 1 0 0 0 -1 0", 1, "(column 3) turned round"),
        ("--quaternion 0.5 0.5 0.5 0.5 --sequence ZXZ", 2, "--angles"),
    ],
)
def test_the_shell(arguments, status, text, capsys):
    assert main(["explain", *arguments.split()]) == status
    said = capsys.readouterr()
    assert text in said.out + said.err


@pytest.mark.parametrize("order", ["yzx", "zxy"])
@pytest.mark.parametrize("which", ["turned axes are", "fixed axes are", "turned and fixed, are"])
def test_axes_exchanged_in_a_cycle_are_named(order, which):
    first = Rotation.from_euler("ZYX", [20, 35, 50], degrees=True).as_matrix()
    places = ["xyz".index(axis) for axis in order]
    second = first[:, places] if which.startswith("turned axes") else first[places]
    second = second[:, places] if which.startswith("turned and") else second
    said = str(explain_rotation(first.round(6), second.round(6)))
    assert which in said and f"x y z of the second are {' '.join(order)} of the first" in said
    assert "cycle" not in str(explain_rotation(first.round(6), np.round(first @ first, 6)))


def test_a_result_whose_scalar_is_known_to_be_last():
    stored = Rotation.from_euler("ZYX", [30, 20, 10], degrees=True).as_quat().round(6)
    assert explain_rotation([30, 20, 10], stored, sequence="ZYX", answer_sequence="xyzw").right
    found = explain_rotation([30, 20, 10], np.roll(stored, 1), sequence="ZYX", answer_sequence="xyzw")
    assert found.misreadings[0].sentence == "the quaternion is written w x y z, scalar first" and not found.right
