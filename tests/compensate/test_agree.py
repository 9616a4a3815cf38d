"""Files, and runs of one file, that tell of different machines."""

import numpy as np
import pytest

from tests.compensate import simulated
from tests.compensate.simulated import Simulated


def _moved(kind, seed, axis, off):
    """A machine, and the same after its axis number `axis` has moved by `off`, mm."""
    one, other = (Simulated(kind, np.random.default_rng(seed)) for _ in range(2))
    name, side, direction, point = other.axes[axis]
    other.axes[axis] = (name, side, direction, point + np.array(off))
    return one, other


@pytest.mark.parametrize("kind", ["table", "mixed", "head"])
def test_files_of_one_machine_agree(kind, calibrated):
    machine, _ = _moved(kind, 1, 0, (0, 0, 0))
    rng = np.random.default_rng(2)
    assert calibrated(simulated.ball(machine, rng), simulated.probe(machine, rng), kind=kind).fits


@pytest.mark.parametrize("kind", ["table", "mixed", "head"])
def test_two_files_of_a_machine_that_was_moved_between_them(kind, calibrated):
    machine, later = _moved(kind, 1, 0, (0, 0.02, 0))
    rng = np.random.default_rng(2)
    found = calibrated(simulated.ball(machine, rng), simulated.ball(later, rng), kind=kind)
    assert any("tell of two machines" in each for each in found.doubts)


def test_the_file_that_alone_disagrees_is_named(calibrated):
    machine, later = _moved("table", 1, 1, (0, 0.02, 0))
    rng = np.random.default_rng(2)
    files = [simulated.ball(machine, rng), simulated.ball(later, rng), simulated.probe(machine, rng)]
    found = calibrated(*files)
    assert any("1.csv tells of a different machine than the other files" in each for each in found.doubts)


@pytest.mark.parametrize("run", range(6))
def test_a_run_of_the_other_sign_is_named(run, calibrated):
    machine = Simulated("table", np.random.default_rng(3))
    machine.positioning["C"] = lambda q: 5 * simulated.ARCSEC * np.sin(q)
    content = simulated.laser(machine, "C", np.random.default_rng(4))
    assert calibrated(content).fits
    head, names, *rows = content.split("\nposition")[0], *("position" + content.split("\nposition")[1]).split()
    cells = [row.split(",") for row in rows]
    for row in cells:
        row[1 + run] = f"{-float(row[1 + run])}"
    found = calibrated("\n".join([head, names, *(",".join(row) for row in cells), ""]))
    name = names.split(",")[1 + run]
    assert any(f"column {name!r}: this run alone differs from the others: with" in each for each in found.doubts)


def test_a_run_that_differs_by_its_rounding_is_like_the_others(calibrated):
    """Readings in steps of 0.5: two runs that happen to be the same do not make the third an odd one."""
    rows = ["0,0.5,0.5,0.5", "90,1.0,1.0,1.5", "180,-0.5,-0.5,-0.5", "270,0.0,0.0,-0.5"]
    content = "\n".join(["# method = laser", "# axis = C", "# unit = arcsec", "position,up1,up2,up3", *rows, ""])
    assert calibrated(content).fits
