"""Typical mistakes, each of which a check must catch: a check that passes them all would be worth nothing.

Every entry is a mistake that learners and manuals make, under its name. The checks share no formula with the
package: they turn vectors with SciPy and take dot products.
"""

import json
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mathpost import load_machine, rotation
from mathpost.frame import Frame
from mathpost.kinematics import Kinematics
from mathpost.rotation import ACTIVE, PASSIVE
from mathpost.shop.plane.positioning import align
from mathpost.shop.plane.tilted_plane import Plane
from mathpost.sources.csy_transform import CsyTransform
from mathpost.sources.recipes import zxz_left_transposed, zxz_right
from tests.conftest import ROOT

POINT = np.array([3.0, 4.0, 5.0])
PRINTED = np.deg2rad([135, 54.7356, -90])


def element(kind, letter, angle):
    return np.array(kind[letter](angle), dtype=float)


def turned_axes(turns, axes=None):
    """Axes, as rows, after turns (row of the axis, angle) about the axes as they then stand."""
    axes = np.eye(3) if axes is None else axes
    for row, angle in turns:
        axes = Rotation.from_rotvec(angle * axes[row]).apply(axes)
    return axes


def check_zxz(matrix, angles):
    """Source 000: the new coordinates are the dot products with the turned axes."""
    np.testing.assert_allclose(matrix, turned_axes(zip((2, 0, 2), angles, strict=True)), atol=1e-6)


def passive(a, b, c, order="ZXZ"):
    """E(c)·E(b)·E(a), the right one."""
    return element(PASSIVE, order[2], c) @ element(PASSIVE, order[1], b) @ element(PASSIVE, order[0], a)


@pytest.mark.parametrize("derivation", ["v.cross(point)", "point.cross(v)"])
def test_lesson_01_fails_if_about_turns_as_the_left_hand_does(monkeypatch, derivation):
    """Also if the derivation in the lesson is turned with it: the quarter turns of the learner's hand remain."""
    about = rotation.about
    monkeypatch.setattr(rotation, "about", lambda axis, angle: about(axis, -angle))
    path, space = ROOT / "notebooks/01_rotating_a_point.ipynb", {"display": lambda shown: None}
    cells = [cell for cell in json.loads(path.read_text(encoding="utf-8"))["cells"] if cell["cell_type"] == "code"]
    for source in ("".join(cell["source"]) for cell in cells):
        if "about(unit[axis]" in source:
            with pytest.raises(AssertionError):
                exec(source.replace("v.cross(point)", derivation), space)
            return
        exec(source, space)


# name: (the mistake, what it makes of the point (3, 4, 5))
ZXZ_MISTAKES = {
    "active elements, first recipe": (
        lambda a, b, c: element(ACTIVE, "Z", c) @ element(ACTIVE, "X", b) @ element(ACTIVE, "Z", a),
        (-4.490731, 4.949747, 2.309402),
    ),
    "active elements, second recipe": (
        lambda a, b, c: (element(ACTIVE, "Z", -a) @ element(ACTIVE, "X", -b) @ element(ACTIVE, "Z", -c)).T,
        (-4.490731, 4.949747, 2.309402),
    ),
    "factors in the order of turning": (
        lambda a, b, c: element(PASSIVE, "Z", a) @ element(PASSIVE, "X", b) @ element(PASSIVE, "Z", c),
        (6.939923, -1.283069, 0.437263),
    ),
    "final transpose forgotten": (lambda a, b, c: passive(a, b, c).T, (1.283069, 6.939923, 0.437263)),
    "negated angles, first order": (lambda a, b, c: passive(-a, -b, -c), (-4.490731, 4.949747, 2.309402)),
    "sign of alpha missed": (lambda a, b, c: passive(-a, b, c), None),
    "sign of beta missed": (lambda a, b, c: passive(a, -b, c), None),
    "sign of gamma missed": (lambda a, b, c: passive(a, b, -c), None),
    "alpha and gamma swapped": (lambda a, b, c: passive(c, b, a), None),
    "ZYZ instead of ZXZ": (lambda a, b, c: passive(a, b, c, "ZYZ"), None),
    "degrees taken for radians": (lambda a, b, c: passive(*np.rad2deg([a, b, c])), None),
}


@pytest.mark.parametrize("right", [zxz_right, zxz_left_transposed, passive])
def test_the_right_matrix_passes(right):
    check_zxz(right(*PRINTED), PRINTED)


@pytest.mark.parametrize("function", [zxz_right, zxz_left_transposed])
@pytest.mark.parametrize("signs", [(-1, 1, 1), (1, -1, 1), (1, 1, -1), (-1, -1, -1)])
def test_dot_products_catch_the_functions_called_with_a_wrong_sign_or_transposed(function, signs):
    with pytest.raises(AssertionError):
        check_zxz(function(*(PRINTED * signs)), PRINTED)
    with pytest.raises(AssertionError):
        check_zxz(function(*PRINTED).T, PRINTED)


@pytest.mark.parametrize("name", ZXZ_MISTAKES)
def test_dot_products_catch(name):
    build, printed = ZXZ_MISTAKES[name]
    with pytest.raises(AssertionError):
        check_zxz(build(*PRINTED), PRINTED)
    if printed:
        np.testing.assert_allclose(build(*PRINTED) @ POINT, printed, atol=1.1e-6)


def check_transform(transform, theta=35, psi=50, phi=-20):
    """Source 003's prose: the machine, turned about its Z, new X, newest Z, is parallel to the part."""
    part = turned_axes(zip((2, 0, 2), np.deg2rad([psi, theta, phi]), strict=True))
    np.testing.assert_allclose(transform.forward_point(POINT), part @ POINT + [100, 200, 300], atol=1e-9)


TRANSFORM_MISTAKES = {
    "arguments in the order of turning": lambda: CsyTransform(100, 200, 300, 50, 35, -20),
    "the other two lost signs": lambda: CsyTransform(100, 200, 300, -35, 50, -20),
    "psi and phi swapped": lambda: CsyTransform(100, 200, 300, 35, -20, 50),
    "matrix transposed": lambda: CsyTransform.from_matrix(
        CsyTransform(0, 0, 0, 35, 50, -20).matrix.T, [100, 200, 300]
    ),
    "rows taken for columns in the STEP form": lambda: CsyTransform.from_axes(
        CsyTransform(theta=35, psi=50, phi=-20).matrix[2],
        CsyTransform(theta=35, psi=50, phi=-20).matrix[0],
        [100, 200, 300],
    ),
    "origin in machine coordinates": lambda: CsyTransform.from_matrix(
        CsyTransform(0, 0, 0, 35, 50, -20).matrix, CsyTransform(0, 0, 0, 35, 50, -20).forward_point([100, 200, 300])
    ),
}


def test_the_right_transform_passes():
    check_transform(CsyTransform(100, 200, 300, 35, 50, -20))


@pytest.mark.parametrize("name", TRANSFORM_MISTAKES)
def test_prose_catches(name):
    with pytest.raises(AssertionError):
        check_transform(TRANSFORM_MISTAKES[name]())


def check_plane(frame, turns):
    """The feature's axes are the workpiece's after the turns of the manual."""
    np.testing.assert_allclose(frame.rotation.T, turned_axes(turns), atol=1e-9)


SPATIAL = [(2, np.deg2rad(30)), (1, np.deg2rad(20)), (0, np.deg2rad(10))]  # C, then new B, then newest A
PLANE_MISTAKES = {
    "spatial angles in the order A, new B, newest C": lambda: Plane("CYCLE800 XYZ", [10, 20, 30]),
    "spatial angles as Euler angles": lambda: Plane("PLANE EULER", [30, 20, 10]),
    "a missed sign": lambda: Plane("PLANE SPATIAL", [10, -20, 30]),
    "A and C swapped": lambda: Plane("PLANE SPATIAL", [30, 20, 10]),
    "the transposed frame": lambda: Plane.from_frame(
        Frame(Plane("PLANE SPATIAL", [10, 20, 30]).frame.rotation.T), "PLANE SPATIAL"
    ),
}


def test_the_right_plane_passes():
    check_plane(Plane("PLANE SPATIAL", [10, 20, 30]).frame, SPATIAL)


@pytest.mark.parametrize("name", PLANE_MISTAKES)
def test_turned_axes_catch(name):
    with pytest.raises(AssertionError):
        check_plane(PLANE_MISTAKES[name]().frame, SPATIAL)


def flipped(model, *names):
    """The machine with the sense of some rotary axes reversed: a table taken for a head."""
    rotary = [replace(r, axis=tuple(-x for x in r.axis)) if r.name in names else r for r in model.rotary]
    return replace(model, rotary=tuple(rotary))


def check_alignment(kin, feature, answers):
    for angles in answers:
        _, axis = kin.forward([0, 0, 0, *angles], degrees=True)
        np.testing.assert_allclose(axis, feature.z, atol=1e-9)


@pytest.mark.parametrize("names", [("A",), ("C",)], ids=["A taken for a head", "C taken for a head"])
def test_forward_kinematics_catches(names):
    model = load_machine("data/machines/ac_table.toml")
    feature = Plane("G68.2", [100, 40, 0]).frame
    check_alignment(Kinematics(model), feature, [s.angles for s in align(feature, model).solutions])
    with pytest.raises(AssertionError):
        wrong = align(feature, flipped(model, *names))
        check_alignment(Kinematics(model), feature, [s.angles for s in wrong.solutions])


def test_the_manual_example_does_not_tell_the_table_signs_apart():
    """SPB+45 on an A-C table: with both signs reversed the same two positions, so it proves neither."""
    model = load_machine("data/machines/ac_table.toml")
    feature = Plane("PLANE SPATIAL", [0, 45, 0]).frame
    pairs = [align(feature, m).solutions for m in (model, flipped(model, "A", "C"))]
    first, second = ({tuple(np.round(s.angles, 9)) for s in solutions} for solutions in pairs)
    assert first == second
