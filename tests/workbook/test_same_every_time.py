"""The same report of the same sheets, whatever Python's hash seed and whichever sheet was checked before."""

import json
import os
import subprocess
import sys

import pytest

from tests.workbook.test_strangers import ROOT, SHEETS, given_by, workbook

# Of these many cells are not judged, or are found wrong only after many tries.
AWKWARD = ("N030", "G017", "k008")
CHECK = """
import json, sys
from mathpost.teaching.workbook import Task, check_file

reports = {}
for name, path, task in json.loads(sys.argv[1]):
    report = check_file(path, Task(**task))
    cells = [(cell.cell, cell.status) for cell in report.cells]
    reports[name] = [str(report), *map(str, report.faults), report.not_checked, report.seen, report.warnings, cells]
print(json.dumps(reports, sort_keys=True))
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("awkward")
    for name in AWKWARD:
        workbook(SHEETS[name]).save(folder / f"{name}.xlsx")
    return folder


def test_eight_hash_seeds_and_orders_of_sheets(folder, of):
    """Three of them, and all by the profile "many"."""
    said = {}
    for seed in range(of(3, 8)):
        first = seed % len(AWKWARD)
        names = AWKWARD[first:] + AWKWARD[:first]
        asked = [(name, str(folder / f"{name}.xlsx"), given_by(SHEETS[name]["options"])) for name in names]
        command = [sys.executable, "-c", CHECK, json.dumps(asked)]
        environment = os.environ | {"PYTHONHASHSEED": str(seed)}
        done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True, check=True)
        for name, report in json.loads(done.stdout).items():
            said.setdefault(name, {}).setdefault(json.dumps(report), []).append(seed)
    assert said.keys() == {*AWKWARD}
    different = {name: list(reports.values()) for name, reports in said.items() if len(reports) > 1}
    assert not different, f"hash seeds that agree: {different}"
