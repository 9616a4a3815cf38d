"""Machines that the tests run over: every file in data/machines, by name."""

from pathlib import Path

import pytest

from mathpost import machine
from mathpost.kinematics import Kinematics

ROOT = Path(__file__).parent.parent
DATA = ROOT / "data"
MACHINE_FILES = sorted((DATA / "machines").glob("*.toml"))


@pytest.fixture(scope="session", params=MACHINE_FILES, ids=lambda path: path.stem)
def kin(request):
    """The kinematics of each machine in data/machines, in turn."""
    return Kinematics(machine.load(request.param))


@pytest.fixture(scope="session")
def dmu50v():
    """The kinematics of source 002's machine."""
    return Kinematics(machine.load(DATA / "machines/dmu50v.toml"))
