"""Whether the truth lies within U, or a verdict says that the model does not hold: the small `coverage`."""

import numpy as np
import pytest

from mathpost import machine_file as machines
from mathpost.errors import InputError
from mathpost.shop.compensate import readings, suspect
from mathpost.shop.compensate.calibrate import calibrate
from tests.compensate import simulated
from tests.compensate.coverage import CASES, shares
from tests.compensate.simulated import Simulated

ALWAYS = (
    "the sign of A or B",
    "C reversed",
    "ex and ey exchanged",
    "A and C exchanged",
    "a chip of 0.15 mm",
    "every row twice",
)


@pytest.mark.parametrize("case", CASES)
def test_within_u_or_said(case, of):
    inside, doubted = shares(case, of(1, 2))
    assert inside > 0.85
    assert doubted < 0.2 or not CASES[case][0]
    assert doubted == 1 or case not in ALWAYS


def _change(**changes):
    return lambda columns: (
        columns | {name: columns[other.strip("-")] * (-1) ** ("-" in other) for name, other in changes.items()}
    )


@pytest.mark.parametrize(
    ("changes", "cause"),
    [
        ({"A": "-A"}, "the sign of A"),
        ({"C": "-C"}, "the sign of C"),
        ({"ex": "ey", "ey": "ex"}, "the columns ex and ey exchanged"),
        ({"A": "C", "C": "A"}, "the columns A and C exchanged"),
        ({"ez": "-ez"}, "the sign of ez"),
    ],
)
def test_the_likely_cause_is_named(changes, cause, calibrated):
    machine = Simulated("table", np.random.default_rng(3))
    found = calibrated(simulated.ball(machine, np.random.default_rng(4), change=_change(**changes)))
    assert not found.fits and f"likely cause: {cause}" in found.doubts[-1]


def test_the_cause_in_a_long_file_is_sought_in_readings_from_its_first_to_its_last(tmp_path):
    def negated(columns):
        return _change(A="-A")({name: np.repeat(column, 12) for name, column in columns.items()})

    (tmp_path / "machine.toml").write_text(simulated.toml("table"), encoding="utf-8")
    machine, path = machines.load(tmp_path / "machine.toml"), tmp_path / "long.csv"
    path.write_text(
        simulated.ball(Simulated("table", np.random.default_rng(3)), np.random.default_rng(4), change=negated),
        encoding="utf-8",
    )
    whole = readings.read(path, machine)
    some = suspect._some(whole)
    assert len(whole.value) > len(some.value) == suspect.MOST == len(set(some.rows))
    assert (some.order[0], some.order[-1]) == (0, 1) and {name for _, name in some.rows} == {"ex", "ey", "ez"}
    assert all(some.value[n] == whole.value[whole.rows.index(row)] for n, row in enumerate(some.rows))
    assert "likely cause: the sign of A" in calibrate(machine, [path]).doubts[-1]


@pytest.mark.parametrize("seed", range(4))
def test_a_sign_that_drift_and_squareness_take_up_is_named(seed, calibrated):
    machine = Simulated("mixed", np.random.default_rng(seed))
    found = calibrated(simulated.ball(machine, np.random.default_rng(9), change=_change(B="-B")), kind="mixed")
    assert "likely cause: the sign of B" in found.doubts[-1]


def test_a_sign_that_is_wrong_in_all_files_is_named(calibrated):
    machine = Simulated("mixed", np.random.default_rng(3))
    ball, probe = (
        method(machine, np.random.default_rng(4), change=_change(B="-B"))
        for method in (simulated.ball, simulated.probe)
    )
    with pytest.raises(InputError, match=r"fit no values; .*0.csv, .*1.csv: likely cause: the sign of B"):
        calibrated(ball, probe, kind="mixed")


def test_readings_along_the_tables_axes_are_no_ball(calibrated):
    machine = Simulated("table", np.random.default_rng(3))
    content = simulated.ball(machine, np.random.default_rng(4), sensor=True)
    assert calibrated(content).fits
    found = calibrated(content.replace("method = sensor", "method = ball"))
    assert "likely cause: another method: sensor" in found.doubts[-1]


def test_the_row_with_the_chip_is_named(calibrated):
    def chip(columns):
        columns["ey"][11] += 0.15
        return columns

    machine = Simulated("table", np.random.default_rng(3))
    doubts = calibrated(simulated.ball(machine, np.random.default_rng(4), change=chip)).doubts
    assert "line 15, column 'ey': +15" in doubts[1]


@pytest.mark.parametrize(
    ("square", "drift", "doubt"),
    [
        ((0, 200e-6, 0), 0.0, "EB0Z: the readings show slides out of square by 2"),
        ((0, 0, 0), 0.05, "the readings drift by up to 5"),
    ],
)
def test_what_no_machine_in_good_order_has_is_doubted(square, drift, doubt, calibrated):
    machine = Simulated("table", np.random.default_rng(3), square)
    found = calibrated(simulated.ball(machine, np.random.default_rng(4), drift=drift))
    assert any(doubt in each and "a sign or a column is wrong" in each for each in found.doubts)


@pytest.mark.parametrize(
    ("positioning", "drift", "note"),
    [
        (("C", 4), 0.0, "C: the readings show a positioning error of up to"),
        (("A", 0), 0.006, "the readings drift by"),
    ],
)
def test_what_nobody_measured_is_said(positioning, drift, note, calibrated):
    machine, (name, size) = Simulated("table", np.random.default_rng(3)), positioning
    machine.positioning[name] = lambda q: size * simulated.ARCSEC * np.sin(q)
    found = calibrated(simulated.ball(machine, np.random.default_rng(4), drift=drift))
    assert found.fits and any(note in each for each in found.notes)
