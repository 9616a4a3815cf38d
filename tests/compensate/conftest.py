"""Readings of simulated machines, calibrated."""

import pytest

from mathpost import machine_file as machines
from mathpost.shop.compensate.calibrate import calibrate
from tests.compensate import simulated


@pytest.fixture
def calibrated(tmp_path):
    """``calibrated(content, …, kind="table")``: what is found in files of readings, 0.csv and so on."""

    def calibrated(*contents, kind="table"):
        (tmp_path / "machine.toml").write_text(simulated.toml(kind), encoding="utf-8")
        paths = [tmp_path / f"{number}.csv" for number in range(len(contents))]
        for path, content in zip(paths, contents, strict=True):
            path.write_text(content, encoding="utf-8")
        return calibrate(machines.load(tmp_path / "machine.toml"), paths)

    return calibrated
