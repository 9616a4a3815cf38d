"""A program for a calibrated machine: read back and run through the chain with errors, it meets the CL data."""

import numpy as np
import pytest

from mathpost import load_machine, postprocess
from mathpost.errors import InputError, ReachError
from mathpost.interface.shell.main import main
from mathpost.kinematics import Kinematics
from mathpost.path import cl as cldata
from mathpost.shop.compensate.model import ErrorModel, MachineErrors, error_names, fingerprint, read_errors
from mathpost.shop.controls import control, reader
from tests.conftest import DATA
from tests.machines import with_slides

BLADE, TRUNNION, ERRORS = (
    str(DATA / name) for name in ("cl/blade.cl", "machines/ac_table.toml", "errors/ac_table.toml")
)


@pytest.fixture(scope="module")
def calibrated():
    return read_errors(ERRORS, load_machine(TRUNNION))


def missed(result, cl, errors, dialect, tcp):
    """Where the records' blocks really take the tip, minus where the CL data want it, from the text alone."""
    joints = reader.read(result.program, errors.machine, dialect).joints
    if tcp:
        joints = Kinematics(errors.machine).close(joints[:, :3], joints[:, 3:])
    at = np.searchsorted(result.place, np.arange(len(cl)))
    tip, axis = ErrorModel(errors.machine).forward(joints[at], errors.at(joints[at]))
    return np.linalg.norm(tip - cl.points, axis=1).max(), np.linalg.norm(axis - cl.axes, axis=1).max()


@pytest.mark.parametrize("tcp", [False, True])
@pytest.mark.parametrize("dialect", control.names())
def test_the_blade_on_a_calibrated_trunnion(blade, calibrated, dialect, tcp):
    plain = postprocess(blade, calibrated.machine, dialect=dialect, tcp=tcp)
    result = postprocess(blade, calibrated.machine, dialect=dialect, tcp=tcp, errors=calibrated)
    before, before_axis = missed(plain, blade, calibrated, dialect, tcp)
    after, after_axis = missed(result, blade, calibrated, dialect, tcp)
    assert before > 0.03 and after < 3e-4 and after_axis < 3e-6
    report = result.report
    assert report.uncompensated.tip_error == pytest.approx(before, abs=1e-12)
    assert np.deg2rad(report.uncompensated.axis_error) == pytest.approx(before_axis, abs=1e-12)
    assert report.tip_error == pytest.approx(after, abs=1e-12)
    assert f"{1e3 * before:.1f} µm" in str(report) and f"{1e3 * after:.1f} µm" in str(report)
    assert plain.report.uncompensated is None and "volumetric" not in str(plain.report)


@pytest.mark.parametrize("name", ["dmu50v", "head_b_table_c", "nutating_head"])
def test_any_machine(name):
    kin = Kinematics(with_slides(load_machine(DATA / f"machines/{name}.toml"), "Y", "XZ"))
    rng = np.random.default_rng(21)
    lengths = np.array([name[1] in "XYZ" for name in error_names(kin.machine)])
    drawn = rng.normal(size=33) * np.where(lengths, 0.02, 5e-5)
    errors = MachineErrors(kin.machine, drawn / 2, drift=drawn / 2)
    along = np.linspace(0, 1, 6)[:, None]
    joints = along * [30, 20, -15, 0.3, 0.25] + [10, -20, 5, 0.4, 0.45]
    cl = cldata.from_arrays(*kin.forward(joints))
    result = postprocess(cl, kin.machine, errors=errors, tolerance=0.05)
    assert (
        missed(result, cl, errors, "heidenhain", tcp=False)[0] < 1e-3 < 0.01 < result.report.uncompensated.tip_error
    )


def test_a_limited_turn_is_said(calibrated):
    tilt = np.deg2rad(np.linspace(-1, 1, 21))
    joints = np.column_stack([20 + 0 * tilt, 30 * tilt, 0 * tilt, tilt, 0.3 + 0 * tilt])
    cl = cldata.from_arrays(*Kinematics(calibrated.machine).forward(joints))
    report = postprocess(cl, calibrated.machine, errors=calibrated).report
    assert any("too near the singular position for the whole turn" in warning for warning in report.warnings)
    assert report.tip_error < 1e-3 < report.uncompensated.tip_error


def test_errors_of_another_machine_or_set_up(blade, calibrated, dmu50v):
    with pytest.raises(InputError, match="those of 'DMU"):
        postprocess(blade, dmu50v.machine, errors=calibrated)
    with pytest.raises(InputError, match="set up alike"):
        postprocess(blade, calibrated.machine.with_setup(tool_length=80), errors=calibrated)


def test_a_path_beyond_the_measured_travel(blade, calibrated, tmp_path):
    (tmp_path / "x.csv").write_text("position,EXX\n0,0\n55,3\n", encoding="utf-8")
    head = f'name = "n"\nsource = "s"\nmachine = "{fingerprint(calibrated.machine)}"\n'
    toml = head + '[[table]]\njoint = "X"\nfile = "x.csv"\n'
    (tmp_path / "errors.toml").write_text(toml, encoding="utf-8")
    errors = read_errors(tmp_path / "errors.toml", calibrated.machine)
    with pytest.raises(ReachError, match="X: .* was not measured: 0 to 55 was"):
        postprocess(blade, calibrated.machine, errors=errors)


def test_the_shell(tmp_path, capsys):
    output = tmp_path / "blade.h"
    command = ["post", BLADE, "--machine", TRUNNION, "-o", str(output), "--errors"]
    assert main([*command, ERRORS]) == 0
    said = capsys.readouterr().err
    assert "volumetric   at the records " in said and " before compensation, 0.1 µm" in said
    output.unlink()
    assert main([*command, str(DATA / "errors/none.toml")]) == 2
    assert "none.toml: expected a readable file" in capsys.readouterr().err
    assert not output.exists()
