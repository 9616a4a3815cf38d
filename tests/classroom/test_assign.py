"""The student copy: every exercise, no solution."""

import json
import math
import random
import re

import pytest

from mathpost.errors import InputError, OutputError
from mathpost.interface.shell.main import main
from mathpost.teaching.classroom.assign import DRAWN, OWN, SAME, assign
from mathpost.teaching.classroom.grade import grade
from mathpost.teaching.course import answers, exercise
from mathpost.teaching.course.verdict import EXERCISES
from tests.classroom.test_grade import cell, notebook, shown, solved, write
from tests.conftest import LESSONS


@pytest.mark.parametrize("path", LESSONS, ids=lambda path: path.stem)
def test_every_lesson_keeps_its_exercises_and_shows_no_solution(path, tmp_path):
    ((copy, names),) = assign(path, tmp_path).items()
    before, after = exercise.notebook(path), exercise.notebook(copy)
    kept = [each for each in before["cells"] if "exercise.solution(" not in "".join(each["source"])]
    assert [each["source"] for each in after["cells"]] == [each["source"] for each in kept]
    ours = {n for n, each in EXERCISES.items() if each.solve.__module__.startswith("mathpost.teaching.course")}
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
        cell("from mathpost.teaching.course.exercise import *\nsolution('01-sign')", html),
        cell("1 + 1", {"output_type": "stream", "name": "stdout", "text": "2"}),
    )
    write(tmp_path / "in" / "a.ipynb", page)
    (copy,) = assign(tmp_path / "in", tmp_path / "out")
    first, second = exercise.notebook(copy)["cells"]
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


@pytest.fixture
def bevel():
    """An exercise that draws its numbers, with slips that follow them."""

    def draw(rng):
        return {"angle": rng.randrange(10, 80, 5)}

    @exercise.define("my-slope", answers.Number(), drawn=draw, given=lambda angle: f"{angle} degrees")
    @exercise.slip("That is the sine.", lambda angle: math.sin(math.radians(angle)))
    @exercise.slip("That is of radians.", unit=1)
    def solve(angle=30, unit=math.pi / 180):
        """The tangent."""
        return math.tan(angle * unit)

    yield EXERCISES["my-slope"]
    del EXERCISES["my-slope"]
    exercise.student("")


def drawing_lesson():
    question = {
        "cell_type": "markdown",
        "metadata": {},
        "source": "Bevel <!--drawn:my-slope:angle-->30<!--/drawn-->°.",
    }
    other = {"cell_type": "markdown", "metadata": {}, "source": "Turn."}
    return page_of(
        cell("from mathpost.teaching.course import exercise"),
        question,
        cell("answer = None\nexercise.check('my-slope', answer)"),
        other,
        cell("exercise.check('01-still', None)"),
    )


def test_each_student_has_numbers_of_their_own(tmp_path, bevel, capsys):
    write(tmp_path / "in" / "a.ipynb", drawing_lesson())
    (tmp_path / "class.txt").write_text("Ada\n王芳\n\n", encoding="utf-8")
    arguments = [str(tmp_path / "in"), "-o", str(tmp_path / "out"), "--students", str(tmp_path / "class.txt")]
    assert main(["assign", *arguments]) == 0
    assert "numbers of their own in my-slope" in capsys.readouterr().err
    angles = []
    for name in ("Ada", "王芳"):
        copy = tmp_path / "out" / name / "a.ipynb"
        sources = ["".join(each["source"]) for each in exercise.notebook(copy)["cells"]]
        assert sources[1] == f"exercise.student({json.dumps(name, ensure_ascii=False)})"
        angles.append(int(re.fullmatch(rf"Bevel (\d+)°\.\n\n{re.escape(OWN)}", sources[2])[1]))
        assert sources[4] == f"Turn.\n\n{SAME}"
        exercise.student(name)
        own = math.tan(math.radians(angles[-1]))
        assert exercise.given("my-slope") == f"{angles[-1]} degrees"
        assert exercise.judge("my-slope", own).status == "right"
        assert exercise.judge("my-slope", math.sin(math.radians(angles[-1]))).mixup == "That is the sine."
        assert exercise.judge("my-slope", math.tan(angles[-1])).mixup == "That is of radians."
    assert angles[0] != angles[1]  # so that answers cannot be passed on
    assert exercise.judge("my-slope", math.tan(math.radians(angles[0]))).status == "not yet"
    assert bevel.verdict(math.tan(math.radians(30))).status == "right"  # the lesson itself stays as it is


def test_whose_numbers_an_answer_had_is_kept_and_told(tmp_path, bevel):
    for student, whose in {"Ada": "Ada", "Ben": "Ada", "Cao": "Cao", "Dan": ""}.items():
        verdict = bevel.of(whose).verdict(math.tan(math.radians(bevel.of(whose).arguments["angle"])))
        output = {"output_type": "display_data", "metadata": {}, "data": verdict._repr_mimebundle_()}
        write(tmp_path / student / "a.ipynb", page_of(cell("exercise.check('my-slope', answer)", output)))
    graded = grade(tmp_path, lessons=tmp_path)
    said = {result.name: [why for _, why in result.trouble] for result in graded.results}
    assert all(result.verdicts["my-slope"].status == "right" for result in graded.results)
    assert said["Cao"] == [] and said["Dan"] == ["answered with the numbers of the lesson, not with their own"]
    assert said["Ada"] == said["Ben"] == ["answered with the numbers of Ada, as 1 more did"]


@pytest.mark.parametrize("names", [["Ada", "Ada"], ["a/b"], [".."], ["x:y"]])
def test_names_that_are_no_folders_are_refused(tmp_path, names):
    write(tmp_path / "in" / "a.ipynb", drawing_lesson())
    with pytest.raises(InputError, match="students"):
        assign(tmp_path / "in", tmp_path / "out", names)
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("name", [name for name, each in sorted(EXERCISES.items()) if each.drawn])
def test_what_a_question_says_is_what_its_check_has(name):
    """The numbers in the lesson are those of the exercise; drawn ones have a solution and slips that differ."""
    text = "".join("".join(each["source"]) for path in LESSONS for each in exercise.notebook(path)["cells"])
    stated = {argument: value for own, argument, value in DRAWN.findall(text) if own == name}
    here = EXERCISES[name]
    assert stated == {argument: str(here.arguments[argument]) for argument in here.drawn(random.Random(0))}
    for student in ("Ada", "王芳", "Ben"):
        own = here.of(student)
        assert own.verdict(own.solution).status == "right"
        assert len(own.mixed_up) == len(here.slips) or here.together, (
            "on some parts of lesson 07c a slip is harmless"
        )
