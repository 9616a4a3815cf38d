"""What no residual shows: it stands in report and template; drift that bends; a budget's slopes by the chain."""

import re
from dataclasses import replace

import nbformat
import numpy as np
import pytest

from mathpost import machine_file as machines
from mathpost.interface.shell.main import main
from mathpost.kinematics import Kinematics
from mathpost.shop.compensate import readings
from mathpost.shop.compensate.calibrate import calibrate
from mathpost.shop.compensate.compensation import Compensator
from mathpost.shop.compensate.model import out_of_square
from tests.compensate import simulated
from tests.compensate.simulated import Simulated
from tests.conftest import ROOT

TABLE, MEASURED = ROOT / "data/machines/ac_table.toml", ROOT / "data/measurements"


@pytest.mark.parametrize("method", readings.METHODS)
def test_the_template_says_what_is_taken_on_trust_and_is_still_read(method):
    lines = readings.template(method, machines.load(TABLE if method != "tip" else "head_b_table_c")).splitlines()
    said = [line for line in lines if line.startswith("# taken on trust: ")]
    assert len(said) == len(readings.METHODS[method]["trust"]) >= 1
    if method in readings.PROBED:
        assert "(TCP) off" in "\n".join(lines) and any("radii of ball and stylus" in line for line in said)
    elif method not in ("bar", "laser", "autocollimator"):
        assert any("0.1 mm" in line for line in said), "a sign without a trial move"


def test_the_report_says_how_to_try_the_sign_and_from_where_places_count(capsys):
    main(["calibrate", str(TABLE), str(MEASURED / "ball_c_axis.csv")])
    said = capsys.readouterr().out
    trusted = said[said.index("Taken on trust") :]
    assert "ex must fall by 0.1" in trusted and "half a turn" in trusted
    at = {axis: float(value) for axis, value in re.findall(r"([XYZ])(-?\d+\.\d+)", trusted)}
    assert at["Z"] == pytest.approx((50 + 350) / 2 + 120)  # both heights of the file, and the tool's length


def reversed_signs(columns):
    return columns | {name: -columns[name] for name in ("ex", "ey", "ez")}


def wrong_radius(columns):
    return columns | {"z": columns["z"] + 0.1}


def within(found, machine):
    """How many U each value is off."""
    return [
        abs(found[name].value - machine.true[name]) / found[name].U for name in found.values if name in machine.true
    ]


@pytest.mark.parametrize(("kind", "change"), [(simulated.ball, reversed_signs), (simulated.probe, wrong_radius)])
def test_signs_and_a_radius_spoil_the_answer_and_do_not_show(kind, change, calibrated):
    """This is why they are taken on trust."""
    machine = Simulated("table", np.random.default_rng(3))
    found = calibrated(kind(machine, np.random.default_rng(4), change=change))
    assert found.fits and max(within(found, machine)) > 10


def test_a_drift_that_bends_is_taken_out(calibrated):
    """A warm-up of 12 µm with a third of the run as its time, along Z: within U as often as U says."""
    inside = []

    def warm(columns):
        return columns | {"ez": columns["ez"] + 0.012 * (1 - np.exp(-np.linspace(0, 3, len(columns["ez"]))))}

    for seed in range(6):
        machine = Simulated("table", np.random.default_rng(seed))
        found = calibrated(simulated.ball(machine, np.random.default_rng(seed), noise=1e-3, change=warm))
        assert any("as far as it is steady or bends once" in note for note in found.notes)
        inside += [times < 1 for times in within(found, machine)]
    assert np.mean(inside) > 0.9


def test_the_slopes_of_the_lessons_budget_are_those_of_the_chain_with_errors():
    """Touched off at C0, bored at C180: the chain with each error in turn, commands of the nominal inverse."""
    lesson = nbformat.read(ROOT / "notebooks/13_systematic_errors.ipynb", 4)
    (cell,) = (each.source for each in lesson.cells if "slopes = {" in each.source)
    trunnion = machines.load(TABLE)
    known = {
        "np": np,
        "replace": replace,
        "trunnion": trunnion,
        "calibrate": calibrate,
        "DATA": ROOT / "data",
        "out_of_square": out_of_square,
    }
    exec(cell, known)
    found, nominal, middle = known["found"], Kinematics(trunnion), np.array([0, 0, 300, 0, 0.0])
    bore = np.array([-200, -200, 300, 0, np.pi])
    wanted = nominal.forward(bore)[0] - nominal.forward(middle)[0]
    for name in found.values:
        values = {each: 1e-6 * (each == name) for each in found.values}
        real = Compensator(replace(found, values=values, assumed={}).errors)
        off = (real.forward(bore)[0] - real.forward(middle)[0] - wanted) @ [
            -1,
            0,
            0,
        ]  # the part's X is the machine's −X
        assert off / 1e-6 == pytest.approx(known["slopes"].get(name, 0), abs=1e-2)
