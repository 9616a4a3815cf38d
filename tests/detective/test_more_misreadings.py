"""Misreadings beside the order, the signs and the axes: other meanings of the angles, quaternions, other places.

What someone gets is computed from SciPy's rotations and written-out formulas, never by the detective.
"""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mathpost.detective.euler_angles import explain
from mathpost.interface.shell.main import main

ANGLES, POINT = np.array([21.3, -47.9, 74.6]), np.array([3, 4, 5])
POINTS = np.array([(3, 4, 5), (-20, 7, 11), (6, -15, 2.5)])


def passive(angles, sequence="ZXZ"):
    return Rotation.from_euler(sequence, angles, degrees=True).as_matrix().T


def exchanged(angles):
    """The passive matrices with sine and cosine exchanged in the second one, multiplied by hand."""
    c, s = np.sin(np.radians(angles[1])), np.cos(np.radians(angles[1]))
    about_x = np.array([(1, 0, 0), (0, c, s), (0, -s, c)])
    first, last = (passive([0, 0, angle]) for angle in (angles[0], angles[2]))
    return last @ about_x @ first


ANGLE_SLIPS = {
    "half angle": [lambda a: passive(a / 2), lambda a: passive(a * [1, 0.5, 1])],
    "double angle": [lambda a: passive(2 * a), lambda a: passive(a * [1, 1, 2])],
    "complement": [lambda a: passive([a[0], 90 - a[1], a[2]]), exchanged, lambda a: passive(90 - a)],
    "offset": [
        lambda a: passive(a + np.array([90, 0, 0])),
        lambda a: passive(a - np.array([0, 0, 90])),
        lambda a: passive(a + np.array([180, 0, 0])),
        lambda a: passive(a + np.array([0, 180, 0])),
    ],
}


@pytest.mark.parametrize(
    ("kind", "number"), [(kind, n) for kind in ANGLE_SLIPS for n in range(len(ANGLE_SLIPS[kind]))]
)
@pytest.mark.parametrize("decimals", [4, 6])
def test_other_meanings_of_the_angles(kind, number, decimals):
    matrix = ANGLE_SLIPS[kind][number](ANGLES)
    found = explain(ANGLES, POINT, (matrix @ POINT).round(decimals), decimals=decimals)
    assert found.misreadings[0].kinds == (kind,), str(found)
    np.testing.assert_allclose(found.misreadings[0].value, matrix @ POINT, atol=10.0**-decimals)
    assert explain(ANGLES, None, matrix.round(decimals), decimals=decimals).misreadings[0].kinds == (kind,)


def test_a_meaning_beside_another_convention():
    """Half the angles in a matrix that was not transposed: two slips, and both are named."""
    found = explain(ANGLES, POINTS, (POINTS @ passive(ANGLES / 2)).round(6))
    assert set(found.misreadings[0].kinds) == {"transpose", "half angle"}


ORIGIN = np.array([12.5, -3, 40])
PLACES = {
    "right": ((), lambda m, p: (p - ORIGIN) @ m.T),
    "not subtracted": (("origin",), lambda m, p: p @ m.T),
    "added, not": (("origin",), lambda m, p: (p + ORIGIN) @ m.T),
    "centre of rotation": (("centre",), lambda m, p: (p - ORIGIN) @ m.T + ORIGIN),
    "after the rotation": (("origin",), lambda m, p: p @ m.T - ORIGIN),
}


@pytest.mark.parametrize("place", PLACES)
def test_an_origin(place):
    kinds, formula = PLACES[place]
    for points in (POINTS, POINTS[0]):
        answer = formula(passive(ANGLES), points).round(6)
        found = explain(ANGLES, points, answer, origin=ORIGIN)
        assert found.misreadings[0].kinds == kinds and place in found.misreadings[0].sentence
        assert found.right == (place == "right")


def test_names_of_the_trade():
    a, b, c = ANGLES
    cases = {
        "KUKA A B C": Rotation.from_euler("ZYX", [a, b, c], degrees=True),
        "Fanuc robot W P R": Rotation.from_euler("xyz", [a, b, c], degrees=True),
    }
    for name, frame in cases.items():
        for rotation in (frame, frame.inv()):
            found = explain(ANGLES, POINT, rotation.apply(POINT).round(6))
            assert name in found.misreadings[0].sentence, str(found)
    for other in ([b, a, c], [-a, b, c]):  # nobody's: two angles exchanged, one sign reversed
        found = explain(ANGLES, POINT, Rotation.from_euler("ZYX", other, degrees=True).apply(POINT).round(6))
        assert "KUKA" not in str(found.misreadings[0])
    assert "left-handed" in explain(ANGLES, POINT, (passive(-ANGLES) @ POINT).round(6)).misreadings[0].sentence
    twice = explain(ANGLES, POINT, (passive(np.deg2rad(ANGLES)) @ POINT).round(6)).misreadings[0]
    assert "converted to radians twice" in twice.sentence
    assert "gon" in explain(ANGLES, POINT, (passive(ANGLES * 0.9) @ POINT).round(6)).misreadings[0].sentence


@pytest.mark.parametrize("decimals", [3, 5])
def test_points_that_are_no_rotation_are_not_explained(decimals):
    """Accidental matches stay out, with a known origin and with an unknown shift, too."""
    rng = np.random.default_rng(8)
    for _ in range(8):
        other = Rotation.random(None, rng)
        answer = other.apply(POINT - ORIGIN).round(decimals)
        assert not explain(ANGLES, POINT, answer, decimals=decimals, origin=ORIGIN).explained
        answer = (other.apply(POINTS) + rng.normal(size=3)).round(decimals)
        assert not explain(ANGLES, POINTS, answer, decimals=decimals).explained


def test_the_threshold_of_chance():
    """So coarse an answer fits some half or double angle by accident: nothing is made of it."""
    answer = passive(ANGLES / 2) @ POINT
    assert explain(ANGLES, POINT, answer.round(5), decimals=5).explained
    assert not explain(ANGLES, POINT, answer.round(0), decimals=0).explained


SOURCE = ["--angles", "135", "54,7356", "-90", "--point", "3", "4", "5"]


@pytest.mark.parametrize(
    ("arguments", "status", "text"),
    [
        ([*SOURCE, "--result", "-1.224744", "0.707107", "6.928203"], 0, "right"),
        ([*SOURCE, "--result", "1.283069", "6.939923", "0.437263"], 1, "the final transpose is missing"),
        ([*SOURCE, "--result", "1", "2", "3"], 1, "No misreading"),
        (
            "--angles 135 54.7356 -90 --matrix "
            "0.408248 -0.707107 0.577350 0.408248 0.707107 0.577350 -0.816496 0 0.577350".split(),
            1,
            "transpose",
        ),
        (
            "--machine data/machines/dmu50v.toml --axis 0.145196 0 0.989403 --result 11.817 -175.815".split(),
            1,
            "the sign of C is reversed",
        ),
        ([*SOURCE, "--origin", "-1", "0", "2", "--result", "-1e-16", "-2,5", "6"], 1, "No misreading"),
    ],
)
def test_the_shell(arguments, status, text, capsys):
    assert main(["explain", *arguments]) == status
    assert text in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        ([], "--angles"),
        (SOURCE, "--result"),
        ([*SOURCE, "--result", "1", "2"], "shape (2,)"),
        ([*SOURCE, *SOURCE[4:], "--result", "1", "2", "3"], "--result"),
        ([*SOURCE, "--result", "1", "2", "3", "--sequence", "ZZX"], "sequence"),
        ("--machine data/machines/none.toml --axis 0 0 1 --result 1 2".split(), "none.toml"),
    ],
)
def test_the_shell_refuses(arguments, text, capsys):
    assert main(["explain", *arguments]) == 2
    assert text in capsys.readouterr().err


def test_several_points_in_the_shell(capsys):
    arguments = ["explain", "--angles", *map(str, ANGLES)]
    for point, result in zip(POINTS, (POINTS @ passive(ANGLES)).round(6), strict=True):
        arguments += ["--point", *map(str, point), "--result", *map(str, result)]
    assert main(arguments) == 1
    assert capsys.readouterr().out.startswith("the final transpose is missing")


@pytest.mark.parametrize(
    ("matrix", "written"),
    [
        (passive([ANGLES[0], 90 - ANGLES[1], ANGLES[2]]), "E_z(γ)·E_x(90° − β)·E_z(α)·p"),
        (passive([ANGLES[0] + 90, *ANGLES[1:]]).T, "E_z(−(α + 90°))·E_x(−β)·E_z(−γ)·p"),
        (passive(ANGLES / 2), "E_z(γ/2)·E_x(β/2)·E_z(α/2)·p"),
    ],
)
def test_the_product_is_written_out(matrix, written):
    assert explain(ANGLES, POINT, (matrix @ POINT).round(7)).misreadings[0].product == written
