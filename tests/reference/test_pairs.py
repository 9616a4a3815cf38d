"""A teacher's workbook and a student's, laid out differently: right, or wrong where the slip was made."""

import pytest

from mathpost.teaching.workbook import Reference
from tests.conftest import runs_all
from tests.reference.pairs import LATER, SUBJECTS, agreeing_ways, pair

FEW = [(name, 0) for name in SUBJECTS] + [
    ("bolts", 2), ("inverse", 6), ("inverse", 9), ("offset", 4), ("regression", 4), ("tilt", 4), ("units", 3),
    ("units", 9), ("frame", 1), ("plane3", 0), ("chain", 1), ("gear", 3), ("sinebar", 2),
]  # fmt: skip
SEEDS = 10  # of each subject, by the profile "many"


def pytest_generate_tests(metafunc):
    if "seed" in metafunc.fixturenames:
        every = [(name, seed) for name in SUBJECTS for seed in range(SEEDS)]
        every += [(name, seed) for name, seed in FEW if name in LATER]
        metafunc.parametrize("name, seed", every if runs_all(metafunc.config) else FEW)


@pytest.mark.parametrize("name", SUBJECTS)
@pytest.mark.parametrize("own", [False, True])
def test_the_ways_of_a_subject_give_the_same_results(name, own):
    assert agreeing_ways(SUBJECTS[name], own) < 1e-9


def test_a_pair_is_judged_as_it_was_made(name, seed, tmp_path):
    made = pair({**SUBJECTS, **LATER}[name], seed)
    made.reference.book.save(tmp_path / "right.xlsx")
    made.handed_in.book.save(tmp_path / "theirs.xlsx")
    report = Reference(tmp_path / "right.xlsx").check(tmp_path / "theirs.xlsx")
    assert report.verdict == ("wrong" if made.cause else "right"), report
    if made.cause:
        assert report.faults[0].place in made.first, report
