"""The horizontal head: the source's numbers, its program's faults, and the model between the measured angles."""

import tomllib

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mathpost.errors import InputError
from mathpost.interface.shell.main import main
from mathpost.shop.measure import horizontal_head
from mathpost.shop.measure.horizontal_head import VERTICAL, Head
from tests.conftest import ROOT

CSV = ROOT / "data/measurements/five_face_head.csv"
OFFSET, POINT = (1000, 500, 300), (10, 20, 30)


@pytest.fixture(scope="module")
def head():
    return horizontal_head.read_head(CSV)


@pytest.mark.parametrize(
    ("angle", "uzz", "translation", "z", "machine"),
    [
        (VERTICAL, None, (-0.06, 0, -533.468), (0, 0, 1), (1009.940, 520.000, -203.468)),
        (0, 90, (378.910, 0.040, 0), (1, 0, 0), (1408.910, 510.040, 320.000)),
        (90, 0, (0, -378.873, 0), (0, -1, 0), (1010.000, 91.127, 320.000)),
        (180, -90, (-378.920, 0.050, -0.065), (-1, 0, 0), (591.080, 490.050, 319.935)),
        (270, -180, (0.050, 378.931, -0.065), (0, 1, 0), (990.050, 908.931, 319.935)),
    ],
)
def test_the_worked_table(head, angle, uzz, translation, z, machine):
    correction = horizontal_head.lhyset(head, 90, VERTICAL, 90)
    np.testing.assert_allclose(correction, (-0.06, 0, -533.468), atol=1e-12)
    assert not np.signbit(correction[1])  # what is left at zero has no minus when it is printed
    frame = horizontal_head.lhy(head, correction, angle)
    np.testing.assert_allclose(frame.origin, translation, atol=1e-9)
    np.testing.assert_allclose(frame.rotation[:, 2], z, atol=1e-12)
    np.testing.assert_allclose(np.add(OFFSET, frame.point(POINT)), machine, atol=1e-9)
    if uzz is None:
        assert frame.block == "TRANS X=-0.060 Y=0.000 Z=-533.468"
    else:
        assert head.rotation_z(angle) == uzz
        assert frame.block.endswith(f"\nAROT Z={uzz:.3f} X=90")
        # Siemens' default is RPY, Z Y′ X″; the Euler setting Z X′ Z″ gives the same, for y and z″ are 0.
        for order in ("ZYX", "ZXZ"):
            turns = (uzz, 0, 90) if order == "ZYX" else (uzz, 90, 0)
            siemens = Rotation.from_euler(order, turns, degrees=True).as_matrix()
            np.testing.assert_allclose(frame.rotation, siemens, atol=1e-12)
        assert 378.86 <= frame.rotation[:, 2] @ head.vector(angle) <= 378.97


def test_uzz_wraps_as_in_the_source(head):
    assert head.rotation_z(275) == 175 and head.rotation_z(270) == -180 and head.rotation_z(-90) == 180


@pytest.mark.parametrize("angle", [45, 0.02, 359.9, np.nan])
def test_an_unlisted_angle_is_an_error(head, angle):
    for call in (
        lambda: head.vector(angle),
        lambda: horizontal_head.lhy(head, (0, 0, 0), angle),
        lambda: horizontal_head.lhyset(head, angle, VERTICAL, 90),
    ):
        with pytest.raises(InputError, match="one of the measured 0, 90, 180, 270"):
            call()


def test_what_falling_through_to_turn0_costs_at_45(head):
    predicted = horizontal_head.fit_head(head).head().vector(45)
    np.testing.assert_allclose(predicted, (267.988, -267.902, 533.481), atol=6e-4)
    assert np.linalg.norm(predicted - head.vector(0)) == pytest.approx(290, abs=1)


def test_the_sign_flip_rule(head):
    errors = horizontal_head.opposite_errors(head)
    np.testing.assert_allclose(errors[180], (0.11, 0.09, -0.065), atol=1e-9)
    np.testing.assert_allclose(errors[270], (0.17, 0.058, -0.065), atol=1e-9)
    assert list(errors) == [180, 270]


def test_the_model_of_the_printed_head(head):
    fitted = horizontal_head.fit_head(head)
    expected = {"cx": 0.070, "cy": 0.037, "a": 378.9085, "b": -0.015, "d": 533.4355, "e": 0.0325, "f": 0.0325}
    np.testing.assert_allclose([fitted.estimate[name] for name in expected], list(expected.values()), atol=6e-4)
    assert np.abs(fitted.residuals).max() <= 0.025 + 1e-9
    assert 1e6 * fitted.tilt == pytest.approx(121, abs=0.5)
    whole = fitted.head(step=5)
    assert len(whole.angles) == 72
    np.testing.assert_allclose(head.vectors - [whole.vector(a) for a in head.angles], fitted.residuals, atol=1e-9)


def test_heights_that_repeat_to_the_last_digit_say_nothing_of_the_noise(head):
    fitted = horizontal_head.fit_head(head)
    left = fitted.residuals[:, :2]  # eight readings of x and y, four unknowns
    assert fitted.repeated == ("z",) and fitted.estimate.spare == fitted.estimate.freedom == 4
    assert fitted.estimate.noise == pytest.approx(np.sqrt((left**2).sum() / 4))
    u = np.sqrt((left**2).sum() / 4) / 2  # a mean of four
    assert fitted.estimate.deviation("cx") == pytest.approx(u) == fitted.estimate.deviation("d")
    read = head.vectors.copy()
    read[[0, 3], 2] += 0.001, 0.002
    measured = horizontal_head.fit_head(Head(head.angles, read))
    assert measured.repeated == () and measured.estimate.spare == 5


def test_the_lesson_names_every_word_that_suppresses_all_frames():
    control, lesson = (
        (ROOT / path).read_text("utf-8")
        for path in ("data/controls/siemens.toml", "notebooks/09_five_face_head.ipynb")
    )
    suppress = [word for word, what in tomllib.loads(control)["read"].items() if what == "machine coordinates"]
    assert suppress and all(f"**{word}**" in lesson for word in suppress)


@pytest.mark.parametrize("sense", [-1, 1])
@pytest.mark.parametrize("zero", [0, 90, -30])
def test_any_head_is_recovered_from_four_positions(sense, zero):
    rng = np.random.default_rng(11)
    turn = np.deg2rad(zero + sense * np.arange(0, 360, 2.5))
    a, b, c, z = rng.uniform(200, 500), rng.uniform(-1, 1), rng.uniform(-1, 1, 2), rng.uniform(300, 600)
    tilt = rng.uniform(-0.1, 0.1, 2)
    vectors = np.column_stack(
        [
            c[0] + a * np.cos(turn) - b * np.sin(turn),
            c[1] + a * np.sin(turn) + b * np.cos(turn),
            z + tilt[0] * np.cos(turn) + tilt[1] * np.sin(turn),
        ]
    )
    measured = Head((0.0, 90.0, 180.0, 270.0), vectors[::36], sense, zero)
    fitted = horizontal_head.fit_head(measured)
    np.testing.assert_allclose(fitted.head().vectors, vectors, atol=1e-9)
    assert fitted.tilt == pytest.approx(np.hypot(*tilt) / np.hypot(a, b))
    for angle, vector in zip(measured.angles, measured.vectors, strict=True):
        assert measured.frame(angle)[:, 2] @ vector == pytest.approx(a, rel=0.01)


def test_three_positions_are_needed(head):
    two = Head(head.angles[:2], head.vectors[:2])
    with pytest.raises(InputError, match=r"tell d and e and f apart \(one position more or"):
        horizontal_head.fit_head(two)
    assert horizontal_head.fit_head(Head(head.angles[:3], head.vectors[:3])).estimate.spare == 2


@pytest.mark.parametrize(
    ("rows", "options", "message"),
    [
        (
            "0,-378.97,-0.04,533\n90,-0.06,378.873,533\n",
            {},
            "line 3, column 'x': expected a vector along Z′ (this is",
        ),
        ("0,378.97,0.04,533\n90,0.06,378.873,533\n", {}, "line 4, column 'x': expected a vector along Z′ at this"),
        ("0,378.97,0.04,533\n90,0.06,-378.873,533\n", {"sense": 1}, "does the head turn the other way?"),
        ("0,378.97,0.04,533\n", {"sense": 2}, "sense: expected -1 or 1"),
        (
            "0,378.97,0.04,533\n360,378.97,0.04,533\n",
            {},
            "line 4, column 'angle': expected an angle that is not the",
        ),
        ("90,0.06,-378.873,533\n0,378.97,0.04,533\n", {}, "line 4, column 'angle': expected more than 90"),
        ("0,378.97,0.04,533\n3600,378.97,0.04,533\n", {}, "line 4, column 'angle': expected degrees within ±360"),
    ],
)
def test_faulty_tables(tmp_path, rows, options, message):
    path = tmp_path / "head.csv"
    path.write_text("# source: a test\nangle,x,y,z\n" + rows, encoding="utf-8")
    with pytest.raises(InputError) as error:
        horizontal_head.read_head(path, **options)
    assert message in str(error.value)


def test_the_same_table_counted_anticlockwise_loads_with_its_sense(tmp_path):
    path = tmp_path / "head.csv"
    path.write_text("angle,x,y,z\n0,378.97,0.04,533\n90,0.06,378.873,533\n", encoding="utf-8")
    assert horizontal_head.read_head(path, sense=1).frame(90)[:, 2] == pytest.approx([0, 1, 0])


def test_step_must_divide_the_turn(head):
    for step in (7, 0, -2.5, 721, np.nan):
        with pytest.raises(InputError, match=f"step: expected a whole fraction of 360°, found {step}"):
            horizontal_head.fit_head(head).head(step)


def test_the_uncertainty_between_the_positions_is_what_each_reading_does_to_the_vector(head):
    """Each of the twelve readings moved by itself, and the head fitted anew."""
    sigma, at = 0.01, 73.0
    fitted = horizontal_head.fit_head(head, sigma=sigma)
    variances = np.zeros(3)
    for place in np.ndindex(head.vectors.shape):
        vectors = head.vectors.copy()
        vectors[place] += sigma
        moved = horizontal_head.fit_head(Head(head.angles, vectors))
        variances += (moved.at([at]).vectors[0] - fitted.at([at]).vectors[0]) ** 2
    np.testing.assert_allclose(fitted.expanded(at), 1.959964 * np.sqrt(variances), rtol=1e-5)


def test_the_command_says_what_is_left_and_the_block_of_any_position(capsys, tmp_path):
    """A head drawn here: it turns the other way about a line beside the spindle; one vector is then moved."""
    file = tmp_path / "mine.csv"
    phi = np.radians([0, 60, 120, 180, 240, 300])
    turned = Rotation.from_rotvec(np.outer(phi, [0, 0, 1])).apply([250.0, 0.02, 400.0])
    arm = turned + np.array([0.3, -0.2, 0.0])
    for off, status in ((0.0, 0), (0.03, 1)):
        arm[2, 0] += off
        rows = np.column_stack([np.degrees(phi), arm]).tolist()
        lines = ["angle,x,y,z", *(",".join(f"{value:.4f}" for value in row) for row in rows)]
        file.write_text("\n".join(lines), encoding="utf-8")
        words = ["head", f"{file}", "--turns", "counterclockwise", "--sigma", "0.005", "--measured", "0,-1,60"]
        assert main([*words, "--at", "90"]) == status
        said = capsys.readouterr().out
        assert ("the vectors fit" in said) is (status == 0)
        assert "AROT Z=180.000 X=90" in said, "Z′ points to +Y there"
        if not status:
            assert "TRANS X=-250.020 Y=249.800 Z=0.000" in said, "0.3 − 0.02 − 250.3, −0.2 + 250, 400 − 400"
    assert main([*words[:2], "--at", "90"]) == 2 and "does the head turn the other way?" in capsys.readouterr().err
