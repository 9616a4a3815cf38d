"""Texts about the project: minutes and lessons of the paths for teachers, mix-ups, the citation, the changelog."""

import re
import tomllib

import pytest

from mathpost.detective.causes import CAUSES
from mathpost.interface.site import sources
from tests.conftest import LESSONS, ROOT

TEACHING = (ROOT / "notebooks/TEACHING.md").read_text(encoding="utf-8")
VERSION = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["version"]


@pytest.fixture(scope="module")
def lessons():
    return {path.name: sources.read(path) for path in LESSONS}


def test_the_paths_of_teachers_take_the_minutes_that_they_say_and_have_what_each_lesson_needs_first(lessons):
    paths = re.findall(r"\*\*[^*]+\*\* \((\d+) minutes(.*?)(?=\n\*\*|\n## )", TEACHING, re.DOTALL)
    assert len(paths) == 2
    for minutes, text in paths:
        names = re.findall(r"\((\w+)\.ipynb\)", text)
        assert int(minutes) == sum(int(lessons[f"{name}.ipynb"].minutes) for name in names)
        for number, name in enumerate(names):
            missing = set(lessons[f"{name}.ipynb"].needs) - set(names[:number])
            assert not missing, f"{name} needs {missing} first"


def test_every_mixup_of_the_catalogue_is_told_with_its_reason_and_lesson():
    numbers = {path.stem.split("_")[0] for path in LESSONS}
    for name, cause in CAUSES.items():
        assert cause["mixup"].endswith(".") and cause["why"].endswith(".") and cause["lesson"] in numbers, name


def test_the_changelog_begins_with_the_version():
    changes = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    assert re.findall(r"^## (\S+)", changes, re.MULTILINE)[0] == VERSION


def test_the_version_stands_in_one_place():
    for name in ("CITATION.cff", "README.md", ".github/workflows/release.yml", "mathpost/__init__.py"):
        assert VERSION not in (ROOT / name).read_text(encoding="utf-8"), name


def test_every_source_of_the_paper_is_cited_and_every_citation_has_a_source():
    paper, sources = ((ROOT / f".github/paper/paper.{kind}").read_text(encoding="utf-8") for kind in ("md", "bib"))
    assert set(re.findall(r"@(\w+)(?=[\];])", paper)) == set(re.findall(r"@\w+\{(\w+),", sources))
