"""Source 000: both recipes, every intermediate matrix, the exact result, and the audit that they need."""

import numpy as np
import pytest
import sympy as sp
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from mathpost import formula, rotation
from mathpost.errors import InputError
from mathpost.rotation import ACTIVE, PASSIVE
from mathpost.sources.recipes import zxz_left_transposed, zxz_right, zxz_steps

PRINTED = (135, 54.7356, -90)
POINT = (3, 4, 5)
ANGLE = st.floats(-400, 400)


def turned_axes(angles):
    """The axes after three turns, each about an axis as it then stands: vectors turned by SciPy."""
    axes = np.eye(3)  # rows x, y, z
    for row, angle in zip((2, 0, 2), np.deg2rad(angles), strict=True):
        axes = Rotation.from_rotvec(angle * axes[row]).apply(axes)
    return axes


def test_elementary_matrices_are_active_and_passive():
    quarter = sp.pi / 2
    turns = {"X": ([0, 1, 0], [0, 0, 1]), "Y": ([0, 0, 1], [1, 0, 0]), "Z": ([1, 0, 0], [0, 1, 0])}
    for letter, (before, after) in turns.items():
        assert list(ACTIVE[letter](quarter) * sp.Matrix(before)) == after
        assert list(PASSIVE[letter](quarter) * sp.Matrix(after)) == before


def test_printed_example_by_both_recipes():
    for recipe in (zxz_right, zxz_left_transposed):
        assert (recipe(*PRINTED, degrees=True) @ POINT).round(6).tolist() == [-1.224744, 0.707107, 6.928203]


def test_exact_result():
    angles = (3 * sp.pi / 4, sp.acos(1 / sp.sqrt(3)), -sp.pi / 2)
    exact = sp.Matrix([-sp.sqrt(sp.Rational(3, 2)), 1 / sp.sqrt(2), 12 / sp.sqrt(3)])
    for recipe in ("right", "left"):
        assert sp.simplify(zxz_steps(recipe, angles, POINT)[-1].value - exact) == sp.zeros(3, 1)


@given(ANGLE, ANGLE, ANGLE)
def test_new_coordinates_are_dot_products_with_the_turned_axes(alpha, beta, gamma):
    expected = turned_axes((alpha, beta, gamma)) @ POINT
    np.testing.assert_allclose(zxz_right(alpha, beta, gamma, degrees=True) @ POINT, expected, atol=1e-12)
    np.testing.assert_allclose(zxz_left_transposed(alpha, beta, gamma, degrees=True) @ POINT, expected, atol=1e-12)


def test_every_intermediate_matrix_of_the_first_recipe():
    steps = zxz_steps("right", PRINTED, POINT, degrees=True)
    assert [(step.number, step.name) for step in steps] == [
        (1, "α"), (2, "β"), (3, "γ"), (4, "γβ"), (5, "γβα"), (6, "x', y', z'"),
    ]  # fmt: skip
    s, c, t = 0.707107, 0.577350, 0.816496
    expected = [
        [[-s, s, 0], [-s, -s, 0], [0, 0, 1]],
        [[1, 0, 0], [0, c, t], [0, -t, c]],
        [[0, -1, 0], [1, 0, 0], [0, 0, 1]],
        [[0, -c, -t], [1, 0, 0], [0, -t, c]],
        [[0.408248, 0.408248, -t], [-s, s, 0], [c, c, c]],
    ]
    for step, matrix in zip(steps[:-1], expected, strict=True):
        np.testing.assert_allclose(step.value, matrix, atol=1.1e-6, err_msg=step.name)


def test_every_intermediate_matrix_of_the_second_recipe():
    steps = zxz_steps("left", PRINTED, POINT, degrees=True)
    assert [step.number for step in steps] == list(range(8))
    assert steps[0].value == [-135, -54.7356, 90]
    first = {step.name: step.value for step in zxz_steps("right", PRINTED, POINT, degrees=True)}
    second = {step.name: step.value for step in steps}
    for name in "αβγ":  # negated angles give the transposed elements
        np.testing.assert_allclose(second[name], first[name].T, atol=1e-15)
    np.testing.assert_allclose(second["αβ"], first["α"].T @ first["β"].T, atol=1e-15)
    feature = [[0.408248, -0.707107, 0.577350], [0.408248, 0.707107, 0.577350], [-0.816496, 0, 0.577350]]
    np.testing.assert_allclose(second["αβγ"], feature, atol=6e-7)
    np.testing.assert_allclose(second["(αβγ)ᵀ"], first["γβα"], atol=1e-15)


def test_recipes_are_equal_identically_with_either_elements():
    angles = sp.symbols("alpha beta gamma", real=True)
    for elementary in (PASSIVE, ACTIVE):
        right, left = (
            zxz_steps(recipe, angles, POINT, elementary=elementary)[-2].value for recipe in ("right", "left")
        )
        assert right == left


def test_active_elements_agree_with_each_other_and_are_wrong():
    results = [zxz_steps(r, PRINTED, POINT, elementary=ACTIVE, degrees=True)[-1].value for r in ("right", "left")]
    for result in results:
        assert result.round(6).tolist() == [-4.490731, 4.949747, 2.309402]
    assert np.abs(results[0] - turned_axes(PRINTED) @ POINT).max() > 3


def test_row_vector_manual():
    """A passive-looking matrix behind a row vector is an active one in front of a column."""
    row = np.array(POINT) @ np.array(PASSIVE["Z"](sp.rad(30)), dtype=float)
    column = np.array(ACTIVE["Z"](sp.rad(30)), dtype=float) @ POINT
    np.testing.assert_allclose(row, [0.598076, 4.964102, 5], atol=6e-7)
    np.testing.assert_allclose(row, column, atol=1e-15)


def test_unit_divides_by_the_length():
    np.testing.assert_allclose(rotation.unit(np.array([[3.0, 0, 4], [0, 0.5, 0]])), [[0.6, 0, 0.8], [0, 1, 0]])
    np.testing.assert_allclose(rotation.unit(np.array([2e-9, 0])), [1, 0])  # short, but with a direction
    with pytest.raises(InputError, match="with a direction"):
        rotation.unit(np.array([1e-9, 0, 0]))


def test_wrap_keeps_the_upper_end_and_moves_the_lower():
    found = rotation.wrap([180, -180, 180 + 1e-6, -180 + 1e-6, 540, 721, -0.0, 360])
    np.testing.assert_allclose(found, [180, 180, -180 + 1e-6, -180 + 1e-6, 180, 1, 0, 0], atol=1e-12)
    assert not np.signbit(found[-2:]).any()  # atan2 and a printed word would show the sign of −0
    assert rotation.wrap(-180 - 1e-11) == pytest.approx(180) and rotation.wrap(-180 + 1e-11) == pytest.approx(180)
    assert rotation.wrap(-180 + 1e-9) == pytest.approx(-180), "further than 1e-12 turns above the end"
    np.testing.assert_allclose(rotation.wrap([3.5, -3.5], 2 * np.pi), [3.5 - 2 * np.pi, 2 * np.pi - 3.5])


def test_rotations_rounded_to_six_decimals_are_accepted_and_to_five_refused():
    rng = np.random.default_rng(2)
    matrices = Rotation.random(500, rng).as_matrix()
    assert rotation.as_rotation(matrices.round(6)).shape == (500, 3, 3)
    refused = [m for m in matrices.round(5) if np.abs(m.T @ m - np.eye(3)).max() > 2e-6]
    assert len(refused) > 400
    for matrix in refused[:20]:
        with pytest.raises(InputError, match="orthonormal"):
            rotation.as_rotation(matrix)


def test_about_turns_right_handed_about_any_axis():
    rng = np.random.default_rng(3)
    t, *v = sp.symbols("t v_x v_y v_z")
    matrix = formula.numeric(sp.ImmutableMatrix(rotation.about(v, t)), (t, *v))
    axes, turns = rotation.unit(rng.normal(size=(50, 3))), rng.uniform(-4, 4, 50)
    expected = Rotation.from_rotvec(axes * turns[:, None]).as_matrix()
    np.testing.assert_allclose(matrix(turns, *axes.T), expected, atol=1e-14)


def test_slices_cover_the_first_axis_once_and_are_of_the_size_stated():
    for shape in ((0,), (1,), (40_000,), (70, 1000), (3, 10**6)):
        parts = list(formula.slices(shape))
        assert np.array_equal(
            np.concatenate([np.arange(shape[0])[part] for part in parts] or [[]]), range(shape[0])
        )
        size = int(np.prod(shape[1:]))
        assert all(len(range(shape[0])[part]) * size <= max(formula.SLICE, size) for part in parts)


def test_what_formulas_have_in_common_is_computed_once():
    x, y = sp.symbols("x y")
    pairs, entries = formula.shared([sp.sin(x * y) + 1, y * sp.sin(x * y), sp.cos(y)])
    ((common, value),) = pairs
    assert value == sp.sin(x * y)
    assert [entry.doit() for entry in entries] == [common + 1, y * common, sp.cos(y)]
    ((common, value),), entries = formula.shared([sp.sin(sp.cos(x * y)), sp.exp(x * y)])
    assert value == x * y and entries == [sp.sin(sp.cos(common)), sp.exp(common)]


@pytest.mark.parametrize("name", ["sin", "cos", "tan", "asin", "acos", "atan", "exp", "sign", "cube", "square"])
def test_a_function_of_a_term_that_is_shared_up_to_its_sign_keeps_its_own(name):
    """Whether x - y or y - x is met first."""
    x, y = sp.symbols("x y", real=True)
    powers = {"cube": lambda term: term**3, "square": lambda term: term**2}
    ours = powers.get(name) or getattr(sp, name)
    theirs = powers.get(name) or getattr(np, name)
    for first in (x - y, y - x):
        found = formula.numeric((first / 7, ours(x - y), ours(y - x)), (x, y))([0.9, 0.2], [0.3, 0.7])
        wanted = [[theirs(term), theirs(-term)] for term in (0.6, -0.5)]
        np.testing.assert_allclose(found[:, 1:], wanted)


def test_whole_numbers_stay_whole_until_a_double_cannot_hold_them():
    x = sp.Symbol("x")
    assert formula.shared([1000 * x]) == ([], [1000 * x])
    for large in (sp.Integer(2) ** 60, -(sp.Integer(2) ** 60)):
        _, (found,) = formula.shared([large])
        assert found.is_Float and int(found) == large


def test_arrays_broadcast():
    alpha = np.arange(6.0).reshape(2, 3)
    matrices = zxz_right(alpha, 30, [0, 45, 90], degrees=True)
    assert matrices.shape == (2, 3, 3, 3)
    np.testing.assert_array_equal(matrices[1, 2], zxz_right(5, 30, 90, degrees=True))


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: zxz_right("a", 2, 3), "angles: expected numbers"),
        (lambda: zxz_steps("up", PRINTED, POINT), "recipe: expected one of 'right', 'left', found 'up'"),
        (lambda: zxz_steps("right", PRINTED, (1, 2)), r"point: expected shape \(..., 3\)"),
        (lambda: rotation.as_rotation(np.eye(4)), r"expected shape \(..., 3\)"),
        (lambda: rotation.as_rotation(np.eye(3)[0]), r"expected shape \(..., 3, 3\)"),
        (lambda: rotation.as_rotation(np.diag([1, 1, 1.01])), "off the identity by 0.0201"),
        (lambda: rotation.as_rotation(np.diag([1, 0.99, 1])), "off the identity by 0.0199"),
        (lambda: rotation.as_rotation([np.eye(3), np.diag([1, 1.01, 1]), np.eye(3)]), r"by 0.0201 at index \(1,\)"),
        (lambda: rotation.as_rotation([np.eye(3), np.diag([1, -1, 1])]), r"left-handed.* at index \(1,\)"),
        (lambda: rotation.as_rotation(np.full((3, 3), np.nan)), "expected finite numbers"),
        (lambda: rotation.unit(np.zeros((2, 3))), r"axis: expected a vector with a direction.*index \(0,\)"),
    ],
)
def test_bad_input(call, message):
    with pytest.raises(InputError, match=message):
        call()


def test_names_give_way_to_what_they_stand_for():
    """A name in a name, alone, in a power and in a product."""
    x, square, more = sp.symbols("x square more", positive=True)
    named = ((square, x**2 + 1), (more, 3 * square))
    found = formula.numeric((more, x / sp.sqrt(square), 2 * more * x), (x,), named)(np.array([1.0, 2.0]))
    np.testing.assert_allclose(found, [[6, 1 / np.sqrt(2), 12], [15, 2 / np.sqrt(5), 60]])


def test_numbers_among_arrays_of_any_shape():
    x, y, z = sp.symbols("x y z")
    compiled = formula.numeric((x + y, x * z), (x, y, z))
    assert compiled(1, 2, 3).tolist() == [3, 3]
    assert compiled([1, 2], 2, [3, 4]).tolist() == [[3, 3], [4, 8]]
    assert compiled(5, np.empty(0), 1).shape == (0, 2)
    assert compiled([[1], [2]], [1, 2, 3], 7)[1, 2].tolist() == [5, 14]
    many = np.arange(2.5 * formula.SLICE)
    np.testing.assert_array_equal(compiled(2, many, 3), np.stack([many + 2, np.full(len(many), 6.0)], axis=-1))
