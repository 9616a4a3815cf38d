"""The student copy: every exercise, no solution."""

import json
import re

import pytest

from mathpost.__main__ import main
from mathpost.course import exercise
from mathpost.course.assign import assign
from mathpost.course.verdict import EXERCISES
from mathpost.errors import InputError, OutputError
from tests.conftest import LESSONS
from tests.course.test_grade import cell, notebook, shown, solved, write


@pytest.mark.parametrize("path", LESSONS, ids=lambda path: path.stem)
def test_every_lesson_keeps_its_exercises_and_shows_no_solution(path, tmp_path):
    ((copy, names),) = assign(path, tmp_path).items()
    before, after = exercise.notebook(path), exercise.notebook(copy)
    kept = [each for each in before["cells"] if "exercise.solution(" not in "".join(each["source"])]
    assert [each["source"] for each in after["cells"]] == [each["source"] for each in kept]
    ours = {n for n, each in EXERCISES.items() if each.solve.__module__.startswith("mathpost.course")}
    assert set(names) == {name for name in ours if name.startswith(path.name[:3].replace("_", "-"))}
    text = copy.read_text(encoding="utf-8")
    assert "exercise.solution" not in text and "Solution of" not in text
    for name in names:
        lines = [json.dumps(line.strip())[1:-1] for line in EXERCISES[name].source.splitlines()]
        telling = [line for line in lines if line.startswith("return ") and len(line) > 25]
        assert not any(line in text for line in telling), name


def page_of(*cells):
    return {"cells": list(cells), "metadata": {}, "nbformat": 4, "nbformat_minor": 5}


def test_outputs_of_solutions_are_gone_wherever_they_stand(tmp_path):
    html = {
        "output_type": "display_data",
        "metadata": {},
        "data": {"text/html": "<summary>Solution of 01-sign</summary>"},
    }
    page = page_of(
        cell("from mathpost.course.exercise import *\nsolution('01-sign')", html),
        cell("1 + 1", {"output_type": "stream", "name": "stdout", "text": "2"}),
    )
    write(tmp_path / "in" / "a.ipynb", page)
    (copy,) = assign(tmp_path / "in", tmp_path / "out")
    first, second = exercise.cells(copy)
    assert not first["outputs"] and second["outputs"]


def test_what_would_give_a_solution_away_is_refused(tmp_path):
    cases = {
        "answered": (notebook(solved(["01-sign"])), "01-sign: expected an exercise that nobody has answered"),
        "defined": (
            page_of(cell("@exercise.define('my', answers.Number())\ndef my(): return 1")),
            "cell 1: expected",
        ),
        "lines": (
            page_of(
                cell('exercise.check("01-sign", None)', shown(exercise.judge("01-sign", None))),
                cell(EXERCISES["01-sign"].source),
            ),
            "its lines",
        ),
        "other": ([], "a notebook"),
    }
    for name, (page, complaint) in cases.items():
        write(tmp_path / name / "a.ipynb", page)
        with pytest.raises(InputError, match=re.escape(complaint)):
            assign(tmp_path / name, tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_nothing_is_overwritten(tmp_path):
    write(tmp_path / "in" / "a.ipynb", page_of(cell("1")))
    assign(tmp_path / "in", tmp_path / "out")
    with pytest.raises(OutputError, match="there already"):
        assign(tmp_path / "in", tmp_path / "out")


def test_the_command(tmp_path, capsys):
    assert main(["assign", str(LESSONS[1]), "-o", str(tmp_path)]) == 0
    said = capsys.readouterr()
    assert "01-sign, 01-point" in said.out and "same for all" in said.err and "can read them" in said.err
    assert main(["assign", str(tmp_path / "none"), "-o", str(tmp_path)]) == 2
