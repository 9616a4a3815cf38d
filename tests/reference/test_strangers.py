"""Pairs of workbooks by authors who had not seen the check: right, or with one slip, tried in LibreOffice.

A line of strangers.jsonl is a pair: both workbooks, the verdict, the first wrong cells, and if the check agrees.
"""

import json

from mathpost.teaching.workbook import Reference
from tests.conftest import ROOT, runs_all
from tests.workbook.test_strangers import workbook

LINES = (ROOT / "tests/reference/strangers.jsonl").read_text(encoding="utf-8").splitlines()
PAIRS = {pair["name"]: pair for pair in map(json.loads, LINES)}
FEW = ["p05", "p16", "p26", "p27", "p38", "p39", "q01", "q09", "q31", "q38", "r02", "r03", "r18", "r23", "r28"]


def pytest_generate_tests(metafunc):
    metafunc.parametrize("name", PAIRS if runs_all(metafunc.config) else FEW)


def test_no_pair_is_judged_against_its_author(name, tmp_path):
    pair = PAIRS[name]
    for side in ("right", "handed_in"):
        workbook(pair[side]).save(tmp_path / f"{side}.xlsx")
    report = Reference(tmp_path / "right.xlsx").check(tmp_path / "handed_in.xlsx")
    assert report.verdict in (pair["verdict"], "not judged")
    if pair["agrees"]:
        assert report.verdict == pair["verdict"]
        assert not pair["first"] or report.faults[0].cell.replace("'", "") in pair["first"]
