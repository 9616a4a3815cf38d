"""Machines and tables that the tests run over."""

import gc
import os
import sys
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import settings
from xdist.scheduler import LoadFileScheduling

os.environ["SYMPY_CACHE_SIZE"] = "20000"  # twenty times sympy's own, for dozens of machines in one process

from mathpost import load_machine
from mathpost.kinematics import Kinematics
from mathpost.path import cl, text
from mathpost.shop.compensate.model import ErrorModel

ROOT = Path(__file__).parent.parent
DATA = ROOT / "data"
README = (ROOT / "README.md").read_text(encoding="utf-8")
# The lessons of the course, which the README lists; a lesson of somebody's own is run, but need not keep our style.
LESSONS = [path for path in sorted((ROOT / "notebooks").glob("*.ipynb")) if f"(notebooks/{path.name})" in README]
MACHINE_FILES = sorted((DATA / "machines").glob("*.toml"))
FIVE_AXES = [path for path in MACHINE_FILES if path.read_text(encoding="utf-8").count("[[rotary]]") == 2]

# Processes that start again and again find compiled modules, even where the shell forbids Python to keep them.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
sys.dont_write_bytecode = False

# Everybody's tests draw the same examples each time. By hand, and as often as one likes: --hypothesis-profile=many
FEW, MANY = 60, 50  # examples at most, and how many times as many as the test says
settings.register_profile("same", derandomize=True, deadline=None)
settings.register_profile("many", derandomize=False, deadline=None, print_blob=True)
settings.load_profile("same")


def runs_all(config):
    """Whether samples are to be whole, by the profile "many"."""
    return config.getoption("--hypothesis-profile") == "many"


@pytest.fixture(scope="session")
def of(pytestconfig):
    """``of(few, all)``: how many cases of a sample to run, a few, or all by the profile "many"."""
    return lambda few, every: every if runs_all(pytestconfig) else few


class ByPlace(LoadFileScheduling):
    """The tests of a file on one process, and all of the site, which is built for them, on one."""

    def _split_scope(self, nodeid):
        return "tests/site" if nodeid.startswith("tests/site/") else super()._split_scope(nodeid)


def pytest_xdist_make_scheduler(config, log):
    return ByPlace(config, log)


def pytest_xdist_auto_num_workers(config):
    """One process more than cores: browser and LibreOffice let theirs wait."""
    return os.cpu_count() + 1


def pytest_collection_modifyitems(config, items):
    """What takes longest begins first. Random examples are at most `FEW`; many more with the profile "many"."""
    long = ("test_browser.py", "test_class", "tests/site/", "test_planted", "test_workbook", "13b_")
    items.sort(key=lambda item: next((n for n, name in enumerate(long) if name in item.nodeid), len(long)))
    for test in {item.obj for item in items if hasattr(getattr(item, "obj", None), "hypothesis")}:
        said = test._hypothesis_internal_use_settings
        count = MANY * said.max_examples if runs_all(config) else min(FEW, said.max_examples)
        test._hypothesis_internal_use_settings = settings(said, max_examples=count)


def pytest_collection_finish(session):
    """What is loaded by now stays: the search for garbage need not go through it again and again."""
    gc.freeze()


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item, call):
    """On a machine for tests nothing is skipped that a fresh machine could have had, a browser for example."""
    report = yield
    if report.skipped and os.environ.get("CI") and sys.platform == "linux" and not hasattr(report, "wasxfail"):
        reason = str(call.excinfo.value)
        if "does not apply" not in reason:
            report.outcome, report.longrepr = "failed", f"skipped where CI is set: {reason}"
    return report


@contextmanager
def machine_code(used):
    """Texts of any size go through the machine code, or none does."""
    loops = text._compiled() if used else (text._match, text._write)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(text, "_loops", lambda size: loops)
        yield patch


@pytest.fixture(scope="session", params=FIVE_AXES, ids=lambda path: path.stem)
def kin(request):
    """The kinematics of each machine in data/machines with two rotary axes, in turn."""
    return Kinematics(load_machine(request.param))


@pytest.fixture(scope="session")
def dmu50v():
    """The kinematics of source 002's machine."""
    return Kinematics(load_machine(DATA / "machines/dmu50v.toml"))


@pytest.fixture(scope="session")
def dmu50v_both_ways(dmu50v):
    """The same with B allowed to −25 degrees."""
    tilting, turning = dmu50v.machine.rotary
    return Kinematics(replace(dmu50v.machine, rotary=(replace(tilting, limits=(np.radians(-25), np.pi)), turning)))


@pytest.fixture(scope="session")
def blade():
    """Table 1 of source 002."""
    return cl.read(DATA / "cl/blade.cl")


@pytest.fixture(scope="session")
def published():
    """Tables 2 and 3 of source 002 as printed: dicts of row number to X Y Z B C, mm and degrees."""
    tables = {}
    for number in (2, 3):
        rows = np.loadtxt(DATA / f"tables/yu_dan_table_{number}.csv", delimiter=",", skiprows=2)
        tables[number] = {int(row[0]): row[1:] for row in rows}
    return tables


@pytest.fixture(scope="session")
def model(kin):
    """The chain with errors of each machine in data/machines, in turn."""
    return ErrorModel(kin.machine)
