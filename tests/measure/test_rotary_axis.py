"""Rotary axes identified from readings: worked numbers, random machines, noise, and readings that do not suffice.

The readings are simulated with SciPy's rotations, which share nothing with the package.
"""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from mathpost.errors import InputError
from mathpost.machine import Rotary
from mathpost.shop.measure import rotary_axis

URAD = 1e-6
AXES = {
    "C ISO": Rotary("C", "workpiece", (0, 0, -1), (0, 0, 0)),
    "C": Rotary("C", "workpiece", (0, 0, 1), (20, -30, 100)),
    "A ISO": Rotary("A", "workpiece", (-1, 0, 0), (-350, -200, -850)),
    "B head": Rotary("B", "tool", (0, 1, 0), (0, 0, 180)),
    "B 45": Rotary("B", "workpiece", (0, 1, 1), (50, 0, 0)),
    "skew": Rotary("B", "workpiece", (0.3, -0.5, 0.8), (5, 60, -7)),
}
axes = pytest.mark.parametrize("rotary", AXES.values(), ids=AXES)


def turned(point, axis, centre, angle):
    """`point` after a turn by `angle` radians about the line through `centre` along `axis`, by SciPy."""
    axis = np.array(axis) / np.linalg.norm(axis)
    return centre + Rotation.from_rotvec(np.multiply.outer(np.atleast_1d(angle), axis)).apply(point - centre)


def disturbed(rotary, rng, size=0.02, tilt=100e-6):
    """The true axis: offset and tilt drawn at random square to the nominal one; as point, direction."""
    axis = np.array(rotary.axis) / np.linalg.norm(rotary.axis)
    offset, turn = (np.cross(axis, scale * rng.uniform(-1, 1, 3)) for scale in (size, tilt))
    return np.array(rotary.point) + offset, axis + np.cross(turn, axis)


def ball_readings(rotary, balls, angles, centre, axis):
    angles, places = np.tile(angles, len(balls)), np.repeat(balls, len(angles), axis=0)
    pairs = zip(angles, places, strict=True)
    error = [(turned(b, axis, centre, t) - turned(b, rotary.axis, rotary.point, t))[0] for t, b in pairs]
    data = dict(zip(("ex", "ey", "ez"), np.transpose(error), strict=True))
    return data | dict(zip("xyz", places.T, strict=True)) | {"angle": angles}


# Worked numbers


def test_ball_errors_at_the_quarters():
    at = {"angle": [0, 90, 180, 270], "x": 150, "y": 0, "z": 0}
    read = rotary_axis.ball(AXES["C ISO"]).predict({"EX0C": 0.010, "EY0C": -0.006}, at, degrees=True)
    np.testing.assert_allclose(read["ex"], [0, 0.016, 0.020, 0.004], atol=1e-12)
    np.testing.assert_allclose(read["ey"], [0, 0.004, -0.012, -0.016], atol=1e-12)


def test_two_heights_of_the_ball_give_centres_tilt_and_axial_runout():
    ball = rotary_axis.ball(AXES["C ISO"])
    true = {"EX0C": 0.010, "EY0C": -0.006, "EA0C": -30 * URAD, "EB0C": 40 * URAD}
    turn = {"angle": np.arange(0, 360, 45), "x": 150, "y": 0}
    low, high = (ball.predict(true, turn | {"z": h}, degrees=True) for h in (50, 350))
    # Each height for itself, the tilt not sought: its centre is where the axis passes.
    found = {}
    for height, read in ((50, low), (350, high)):
        data = turn | {"z": 0, "ex": read["ex"], "ey": read["ey"]}
        estimate = ball.identify(data, degrees=True, known={"EA0C": 0, "EB0C": 0})
        found[height] = estimate["EX0C"], estimate["EY0C"]
    np.testing.assert_allclose(found[50], [0.0120002, -0.00449987], atol=6e-8)
    np.testing.assert_allclose(found[350], [0.0240002, 0.00450014], atol=6e-8)
    (low_x, low_y), (high_x, high_y) = found[50], found[350]
    tilt = [-(high_y - low_y) / 300, (high_x - low_x) / 300]
    np.testing.assert_allclose(tilt, [-30 * URAD, 40 * URAD], rtol=1e-4)
    whole = ball.predict(true, {"angle": np.arange(0, 360, 0.5), "x": 150, "y": 0, "z": 50}, degrees=True)
    assert np.ptp(whole["ez"]) / 2 == pytest.approx(150 * 50 * URAD, rel=1e-4)
    at_90 = [high[name][2] for name in ("ex", "ey", "ez")]
    np.testing.assert_allclose(at_90, [0.0195002, 0.0285004, 0.0104984], atol=6e-8)


def test_dial_circle():
    at = {"angle": [0, 90, 180, 270], "R": 100}
    read = rotary_axis.dial_circle().predict({"ex": 0.030, "ey": -0.020}, at, degrees=True)["dial"]
    np.testing.assert_allclose(read, [0.030002, -0.019995, -0.029998, 0.020004], atol=6e-7)
    assert (read[0] - read[2]) / 2 == pytest.approx(0.030, abs=1e-9)
    assert (read[1] - read[3]) / 2 == pytest.approx(-0.020, abs=1e-9)


@pytest.mark.parametrize(("angle", "point"), [(90, (-150.021, -400.005)), (60, (-131.712, -368.309))])
@pytest.mark.parametrize("sign", [-1, 1])
def test_probing_at_two_angles_and_the_wrong_sign(angle, point, sign):
    probed = {"angle": [0, angle], "y": [-150, point[0]], "z": [-300, point[1]]}
    axis = Rotary("A", "workpiece", (sign, 0, 0), (0, 0, 0))
    estimate = rotary_axis.probing(axis).identify(probed, degrees=True)
    wrong = {90: (-100.008, -350.013), 60: (-81.6992, -318.317)}
    expected = (-200.013, -349.992) if sign < 0 else wrong[angle]
    np.testing.assert_allclose([estimate["yc"], estimate["zc"]], expected, atol=6e-4)


def test_probing_uncertainty_is_that_of_the_chord():
    for angle in (30, 60, 90, 180):
        data = {"angle": [0, angle], "y": [1, 2], "z": [3, 4]}
        estimate = rotary_axis.probing(AXES["A ISO"]).identify(data, degrees=True, sigma=0.004)
        expected = np.sqrt(2) * 0.004 / (2 * np.sin(np.deg2rad(angle) / 2))
        assert estimate.deviation("yc") == pytest.approx(expected) == pytest.approx(estimate.deviation("zc"))


def test_rtcp_numbers():
    true = {"alpha": np.deg2rad(0.004), "dy": 0.03, "dL": 0.05}
    at = {"angle": [40, -40, 40, -40], "L": [500, 500, 700, 700]}
    read = rotary_axis.rtcp_zero().predict(true, at, degrees=True)
    np.testing.assert_allclose(read["axial"], [0.0534204, -0.0300264, 0.0623953, -0.0390015], atol=6e-8)
    # One tool tells the tip's own error only, u across and w along it.
    plus, minus = read["axial"].reshape(2, 2).T
    u, w = (plus - minus) / (2 * np.sin(np.deg2rad(40))), (plus + minus) / (2 * (np.cos(np.deg2rad(40)) - 1))
    np.testing.assert_allclose([u, w], [(0.0649101, 0.0788727), (-0.0499967, -0.0499962)], atol=6e-8)
    assert np.rad2deg(u[1] - u[0]) / 200 == pytest.approx(0.004, rel=1e-6)
    for names in (("axial",), ("lateral",), ("axial", "lateral")):
        estimate = rotary_axis.rtcp_zero().identify(at | {n: read[n] for n in names}, degrees=True)
        np.testing.assert_allclose([estimate[n] for n in true], list(true.values()), rtol=1e-9)


def test_the_source_takes_the_reading_for_the_error():
    arcsec = np.rad2deg(np.arctan(0.1 / 700)) * 3600
    assert arcsec == pytest.approx(29.4664, abs=5e-5)
    read = rotary_axis.rtcp_zero().predict(
        {"alpha": np.deg2rad(arcsec / 3600)}, {"angle": 5, "L": 700}, degrees=True
    )
    low = np.rad2deg(np.arctan(read["axial"] / 700)) * 3600
    assert low == pytest.approx(2.57, abs=0.005) and arcsec / low == pytest.approx(11.47, abs=0.005)
    estimate = rotary_axis.rtcp_zero().identify(
        {"angle": [5, -5], "L": 700, "axial": np.multiply(read["axial"], [1, -1])}, degrees=True, known={"dy": 0}
    )
    assert np.rad2deg(estimate["alpha"]) * 3600 == pytest.approx(arcsec, abs=2e-3)


# Any axis, any error


@pytest.mark.parametrize(
    ("axis", "nearest"), [((1, 8, 9), [1, 0, 0]), ((8, -1, 9), [0, 1, 0]), ((8, 9, 1), [0, 0, 1])]
)
def test_errors_of_an_oblique_axis_count_from_the_machine_axis_nearest_to_square(axis, nearest):
    names, plane = rotary_axis.square_to(Rotary("B", "workpiece", axis, (0, 0, 0)))
    first, second = np.array(plane, dtype=float).T
    axis = np.array(axis) / np.linalg.norm(axis)
    expected = nearest - axis * (axis @ nearest)
    np.testing.assert_allclose(first, expected / np.linalg.norm(expected), atol=1e-12)
    np.testing.assert_allclose(np.cross(axis, first), second, atol=1e-12)
    assert names == ["1", "2"]


@axes
@settings(deadline=None, max_examples=40)
@given(seed=st.integers(0, 2**32 - 1))
def test_ball_readings_give_back_the_axis(rotary, seed):
    rng = np.random.default_rng(seed)
    centre, axis = disturbed(rotary, rng)
    balls = np.array(rotary.point) + rng.uniform(-200, 200, (2, 3)) + [[0, 0, 0], [150, 150, 150]]
    data = ball_readings(rotary, balls, np.linspace(0, 5.5, 7), centre, axis)
    found = rotary_axis.corrected(rotary, rotary_axis.ball(rotary).identify(data).values)
    for angle in (1.0, 3.0):
        np.testing.assert_allclose(
            turned(balls, found.axis, found.point, angle), turned(balls, axis, centre, angle), atol=1e-9
        )


@axes
@settings(deadline=None, max_examples=40)
@given(seed=st.integers(0, 2**32 - 1))
def test_probing_gives_back_the_centre(rotary, seed):
    rng = np.random.default_rng(seed)
    centre, _ = disturbed(rotary, rng, size=300)
    angles = rng.uniform(-1, 1) + np.array([0, 1.2, 2.6])
    probed = turned(centre + rng.uniform(-300, 300, 3), rotary.axis, centre, angles)
    estimate = rotary_axis.probing(rotary).identify({"angle": angles, **dict(zip("xyz", probed.T, strict=True))})
    _, plane = rotary_axis.square_to(rotary)
    found = np.array(plane, dtype=float) @ list(estimate.values.values())[:2]
    along = np.cross(found - centre, rotary.axis)
    np.testing.assert_allclose(along, 0, atol=1e-8)


def test_a_ball_that_is_not_where_it_should_be_misleads():
    rotary = AXES["C ISO"]
    placed = np.array([[150, 0, 50], [150, 0, 350]])
    data = ball_readings(rotary, placed, np.arange(0, 6, 0.7), np.array([0.01, -0.006, 0]), (0, 0, -1))
    shift = turned([0.02, 0, 0], rotary.axis, np.zeros(3), data["angle"])
    data = data | {name: data[name] + part for name, part in zip(("ex", "ey", "ez"), shift.T, strict=True)}
    wrong = rotary_axis.ball(rotary).identify(data)
    assert abs(wrong["EX0C"] - 0.010) > 0.008 and wrong.noise > 0.005


# Noise: the stated uncertainty is the observed one

DESIGNS = {
    "dial": (
        rotary_axis.dial_circle(),
        {"angle": np.arange(0, 360, 45), "R": 100},
        {"ex": 0.03, "ey": -0.02, "zero": 0.1},
        ("dial",),
    ),
    "probing A": (
        rotary_axis.probing(AXES["A ISO"]),
        {"angle": [0, 60]},
        {"yc": -200.013, "zc": -349.992, "yf": -150, "zf": -300},
        ("y", "z"),
    ),
    "ball C": (
        rotary_axis.ball(AXES["C"]),
        {"angle": np.tile(np.arange(0, 360, 45), 2), "x": 150, "y": 10, "z": np.repeat([50, 350], 8)},
        {"EX0C": 0.01, "EY0C": -0.006, "EA0C": -30 * URAD, "EB0C": 40 * URAD},
        ("ex", "ey", "ez"),
    ),
    "ball B": (
        rotary_axis.ball(AXES["B head"]),
        {"angle": np.tile(np.arange(0, 360, 30), 2), "x": np.repeat([90, 200], 12), "y": 10, "z": 50},
        {
            "EX0B": 0.01,
            "EZ0B": 0.02,
            "EA0B": 50 * URAD,
            "EC0B": -60 * URAD,
        },
        ("ex", "ey", "ez"),
    ),
    "rtcp": (
        rotary_axis.rtcp_zero(),
        {"angle": [40, -40, 40, -40], "L": [500, 500, 700, 700]},
        {"alpha": np.deg2rad(0.004), "dy": 0.03, "dL": 0.05},
        ("axial",),
    ),
}


@pytest.mark.parametrize("design", DESIGNS.values(), ids=DESIGNS)
def test_draws_scatter_as_the_covariance_says(design, of):
    measurement, at, true, names = design
    rng, sigma, count = np.random.default_rng(7), 0.002, of(200, 1000)
    clean = measurement.predict(true, at, degrees=True)
    exact = measurement.identify(at | {n: clean[n] for n in names}, degrees=True)
    expected = np.array([true[name] for name in exact.values])
    np.testing.assert_allclose(list(exact.values.values()), expected, rtol=1e-8, atol=1e-11)

    # Draws whose own covariance is exactly that of the noise, so that the estimates' scatter has no luck in it.
    size = exact.spare + len(expected)
    noise = rng.standard_normal((count, size))
    noise -= noise.mean(axis=0)
    noise = sigma * noise @ np.linalg.inv(np.linalg.cholesky(np.cov(noise.T))).T
    errors = np.empty((count, len(expected)))
    for draw, parts in zip(errors, noise.reshape(count, len(names), -1), strict=True):
        drawn = {name: value * rng.uniform(-2, 2) for name, value in true.items()}
        clean = measurement.predict(drawn, at, degrees=True)
        data = at | {name: clean[name] + part for name, part in zip(names, parts, strict=True)}
        estimate = measurement.identify(data, degrees=True, sigma=sigma)
        draw[:] = [estimate[name] - drawn[name] for name in exact.values]
    deviations = np.sqrt(np.diag(estimate.covariance))
    assert ((np.abs(errors) <= 3 * deviations).mean(axis=0) >= 0.99).all()
    observed = np.cov(errors.T) / np.outer(deviations, deviations)
    np.testing.assert_allclose(observed, estimate.covariance / np.outer(deviations, deviations), atol=0.01)


def test_repeated_turns_are_told_apart_by_a_run_column(tmp_path):
    path = tmp_path / "runs.csv"
    path.write_text(
        "run,angle,R,dial\n1,0,100,0.03\n1,90,100,-0.02\n1,180,100,-0.03\n2,0,100,0.03\n2,90,100,-0.02\n"
    )
    dial = rotary_axis.dial_circle()
    assert dial.identify(dial.read(path)).spare == 2


def test_noise_from_the_residuals_is_unbiased_and_tells_a_misfit():
    measurement, at, true, _ = DESIGNS["dial"]
    rng = np.random.default_rng(3)
    clean = measurement.predict(true, at, degrees=True)["dial"]
    draws = [at | {"dial": clean + 0.002 * rng.standard_normal(8)} for _ in range(300)]
    variances = [measurement.identify(data, degrees=True).noise ** 2 for data in draws]
    assert np.sqrt(np.mean(variances)) == pytest.approx(0.002, rel=0.1)
    oval = at | {"dial": clean + 0.02 * np.cos(2 * np.deg2rad(at["angle"]))}
    assert measurement.identify(oval, degrees=True, sigma=0.002).noise > 5


# Readings that do not suffice, and files that are wrong


@pytest.mark.parametrize(
    ("measurement", "data", "message"),
    [
        (
            rotary_axis.dial_circle(),
            {"angle": [0, 180], "R": 100, "dial": [0, 0]},
            "determine ey (the same at 90° more",
        ),
        (
            rotary_axis.dial_circle(),
            {"angle": [0], "R": 100, "dial": [0]},
            "tell ex and zero apart, determine ey",
        ),
        (
            rotary_axis.ball(AXES["C ISO"]),
            {"angle": [0, 90, 180], "x": 150, "y": 0, "z": 80, "ex": [0, 1, 2], "ey": [0, 1, 2]},
            "tell EX0C and EB0C apart, tell EY0C and EA0C apart (also reading ez or the same with the ball 200 mm",
        ),
        (
            rotary_axis.ball(AXES["C ISO"]),
            {"angle": [0, 0], "x": 150, "y": 0, "z": [0, 99], "ex": [0, 0], "ey": [0, 0], "ez": [0, 0]},
            "(the same with the axis 90° further would)",
        ),
        (
            rotary_axis.probing(AXES["A ISO"]),
            {"angle": [0], "y": [1], "z": [2]},
            "determine yc and zc (the same with the axis 90° further would)",
        ),
        (
            rotary_axis.rtcp_zero(),
            {"angle": [40, -40], "L": 500, "axial": [0.05, -0.03]},
            "tell alpha and dy apart (the same with a tool 200 mm longer would)",
        ),
        (
            rotary_axis.rtcp_zero(),
            {"angle": [40], "L": 500, "axial": [0.05]},
            "tell alpha and dy and dL apart (also reading lateral together with the same at the opposite angle",
        ),
        (
            rotary_axis.rtcp_zero(),
            {"angle": [0], "L": 500, "axial": [0.0]},
            "determine alpha and dy and dL",
        ),
    ],
)
def test_too_few_readings_name_the_unknowns_and_the_remedy(measurement, data, message):
    with pytest.raises(InputError) as error:
        measurement.identify(data, degrees=True)
    assert message in str(error.value)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("angle,R,dial\n0,100,0\n90,100,0.1\n3600,100,0\n", "line 4, column 'angle': expected degrees within ±360"),
        ("angle,R,dial\n0,100,0\n180,100,0\n90,100,0\n", "line 4, column 'angle': expected more than 180"),
        (
            "angle,R,dial\n0,100,0\n90,100,0\n90,100,0\n",
            "line 4, column 'angle': expected more than 90, which is on line 3",
        ),
        ("angle,R,dial\n0,100,0\n90,100,20\n", "line 3, column 'dial': expected mm within ±5 (µm?), found 20"),
        ("angle,R\n0,100\n", "expected a column of readings: dial, found none"),
        ("angle,dial\n0,100\n", "no 'R'"),
        ("angle,R,dial\n0,100,0\n180,100,0\n", "readings.csv: expected readings that determine ey"),
    ],
)
def test_files_of_readings_are_checked(tmp_path, text, message):
    path = tmp_path / "readings.csv"
    path.write_text(text, encoding="utf-8")
    dial = rotary_axis.dial_circle()
    with pytest.raises(InputError) as error:
        dial.identify(dial.read(path))
    assert str(path) in str(error.value) and message in str(error.value)


@pytest.mark.parametrize(
    ("measurement", "head"),
    [
        (rotary_axis.dial_circle(), "angle,R,dial\n0,100,"),
        (rotary_axis.ball(AXES["C ISO"]), "angle,x,y,z,ex\n0,100,0,0,"),
        (rotary_axis.rtcp_zero(), "angle,L,axial\n0,100,"),
    ],
    ids=["dial", "ball", "rtcp"],
)
def test_readings_beyond_five_millimetres_are_in_another_unit(tmp_path, measurement, head):
    (tmp_path / "small.csv").write_text(f"{head}5\n", encoding="utf-8")
    assert measurement.read(tmp_path / "small.csv")
    (tmp_path / "large.csv").write_text(f"{head}5.1\n", encoding="utf-8")
    with pytest.raises(InputError, match="within ±5"):
        measurement.read(tmp_path / "large.csv")


@pytest.mark.parametrize(
    ("data", "options", "message"),
    [
        ({"angle": [0, 1, 2], "R": 100, "dial": [0, 1]}, {}, "angle: expected 2 numbers"),
        ({"angle": [0, 1, 2], "R": 100, "dial": [0, 1, np.nan]}, {}, "dial: expected finite numbers"),
        ({"angle": [0, 1, 2], "R": 100}, {}, "expected readings: dial"),
        ({"angle": [], "R": 100, "dial": []}, {}, "expected readings: dial"),
        ({"angle": [0, 1, 2], "dial": [0, 1, 2]}, {}, "no 'R'"),
        ({"angle": [0, 1, 2], "R": 100, "dial": ["a", 1, 2]}, {}, "expected numbers"),
        ({"angle": [0, 1, 2], "R": 100, "dial": [0, 1, 2]}, {"sigma": 0}, "above 0"),
        ({"angle": [0, 1, 2], "R": 100, "dial": [0, 1, 2]}, {"known": {"ez": 0}}, "unknowns among ex, ey, zero"),
        ({"angle": [0, 1, 2], "R": 100, "dial": [0, 1, 2]}, {"known": {"ex": np.nan}}, "values: expected finite"),
        ({"angle": [0], "R": 1, "dial": [0]}, {"known": {"ex": 0, "ey": 0, "zero": 0}}, "something sought"),
    ],
)
def test_bad_arguments(data, options, message):
    with pytest.raises(InputError) as error:
        rotary_axis.dial_circle().identify(data, **options)
    assert message in str(error.value)


def test_a_machine_is_corrected_from_readings_of_its_own_axis_only():
    estimate = rotary_axis.ball(AXES["A ISO"]).identify(
        ball_readings(AXES["A ISO"], np.array([[0, 50, 60], [100, 0, 9]]), [0, 1, 2], np.zeros(3), (-1, 0, 0))
    )
    with pytest.raises(InputError, match="errors: expected some of EX0C"):
        rotary_axis.corrected(AXES["C ISO"], estimate.values)
