"""Every exercise: the stub, the solution, the typical mistakes; and the lessons that pose them."""

import ast
import json
import re

import numpy as np
import pytest

from mathpost.course import exercise
from mathpost.course.verdict import OPEN, RIGHT, TASKS, WRONG, Task
from mathpost.detective.misreadings import Explanation, Misreading
from mathpost.errors import InputError
from tests.conftest import ROOT

LESSONS = sorted((ROOT / "notebooks").glob("[0-9][0-9]_*.ipynb"))[1:]
EACH = [pytest.param(task, id=name) for name, task in TASKS.items()]
MISTAKES = [
    pytest.param(task, sentence, id=f"{name}-{number}")
    for name, task in TASKS.items()
    for number, sentence in enumerate(task.wrong, 1)
]


@pytest.mark.parametrize("task", EACH)
def test_stub(task):
    assert task.verdict(None).status == OPEN
    assert task.verdict([None, None, None]).status == OPEN


@pytest.mark.parametrize("task", EACH)
def test_solution_passes_and_teaches(task):
    verdict = task.verdict(task.solution)
    assert verdict.status == RIGHT, str(verdict)
    assert len(verdict.why) > 30
    assert "return" in task.code and '"""' not in task.code


@pytest.mark.parametrize(("task", "sentence"), MISTAKES)
def test_mistake_is_named(task, sentence):
    verdict = task.verdict(task.wrong[sentence]())
    assert verdict.status == WRONG
    assert sentence in verdict.why


@pytest.mark.parametrize("task", EACH)
def test_each_has_a_typical_mistake_and_raises_at_no_answer(task):
    assert task.wrong
    for answer in (
        "",
        "nonsense",
        [],
        [[]],
        {},
        object(),
        np.nan,
        np.inf,
        -1e9,
        [1e9] * 3,
        [np.nan] * 3,
        (1, "a"),
        len,
    ):
        assert task.verdict(answer).status == WRONG, answer


@pytest.mark.parametrize("task", [each for each in EACH if each.values[0].judge is None])
def test_the_solution_as_shown_can_be_typed_in(task, capsys):
    exercise.solution(task.name)
    _, *code, shown = capsys.readouterr().out.splitlines()
    assert "\n".join(code) == task.code
    words = shown.removeprefix("# -> ").split(", ")
    if not isinstance(task.solution, (str, set)):
        words = [float(word) for word in words]
    assert (
        task.verdict(words if np.shape(task.solution) or isinstance(task.solution, set) else words[0]).status
        == RIGHT
    )


@pytest.mark.parametrize("lesson", [f"{number:02d}" for number in range(1, 15)])
def test_three_in_every_lesson(lesson):
    assert sum(name.startswith(lesson) for name in TASKS) >= 3


@pytest.mark.parametrize("path", LESSONS, ids=lambda path: path.stem)
def test_lesson_poses_its_exercises(path):
    cells = json.loads(path.read_text(encoding="utf-8"))["cells"]
    sources = ["".join(cell["source"]) for cell in cells]
    answers = {}
    for name in (name for name in TASKS if name[:2] == path.name[:2]):
        question = next(number for number, source in enumerate(sources) if f"**{name}**" in source)
        stub, check, solved = cells[question + 1 : question + 4]
        answer = ast.parse("".join(stub["source"])).body[-1].targets[0].id
        assert "".join(stub["source"]).endswith(f"{answer} = None")
        assert "".join(check["source"]) == f'exercise.check("{name}", {answer})'
        assert "".join(check["outputs"][0]["text"]) == f"{name} · {OPEN}.\n"
        assert "".join(solved["source"]) == f'exercise.solution("{name}")'
        assert solved["metadata"]["jupyter"] == {"source_hidden": True, "outputs_hidden": True}
        assert "solution" in solved["metadata"]["tags"]
        assert TASKS[name].code in "".join(solved["outputs"][0]["text"])
        answers[answer] = name
    assert len(answers) >= 3
    posed = re.findall(r'exercise\.\w+\("(.*?)"', "\n".join(sources))
    assert set(posed) == set(answers.values())


def of(solution, **how):
    return Task("00-test", lambda: solution, 1e-3, how.pop("wrong", {}), **how)


@pytest.mark.parametrize(
    ("solution", "answer", "said"),
    [
        (2.5, -2.5, "wrong sign"),
        (30.0, np.radians(30), "radians"),
        (0.5, np.degrees(0.5), "degrees, radians were asked for"),
        (0.25, 250, "mm or µm"),
        (10.0, 10 / 3600, "arcseconds were asked for"),
        (3.0, 6, "twice too much"),
        (3.0, 1.5, "half of it"),
        ([1.0, 2, 3], [1, -2, 3], "sign of number 2"),
        ([1.0, 2, 3], [2, 1, 3], "another order"),
        ([1.0, 2, 3], [-1, -2, -3], "wrong sign"),
        ([1.0, 2, 3], [1, 2, 7], "2 of 3 numbers"),
        ([1.0, 2, 3], [1, 2], "Expected 3 numbers, found 2 numbers"),
        (100.0, 100.5, "a little too great"),
        (100.0, 7, "too small"),
        ({"a", "b"}, ["A", "c"], "Of yours 1 belong here and 1 do not; 1 are missing"),
        ("active", "elements", "read the question once more"),
    ],
)
def test_general_slips(solution, answer, said):
    verdict = of(solution).verdict(answer)
    assert verdict.status == WRONG
    assert said in verdict.why


def test_a_zero_solution_names_no_factor():
    assert of(np.zeros(3)).verdict(np.ones(3)).why == "0 of 3 numbers are right."


def test_the_detective_is_asked_before_general_slips_and_after_named_mistakes():
    found = Explanation((Misreading("the sign of α is reversed", "M", ("sign",), np.array(0), (), 1.0),), 0.1, 1)
    task = of(5.0, wrong={"Named.": lambda: 7.0}, detective=lambda answer: found)
    assert task.verdict(7).why == "Named."
    assert task.verdict(-5).why == "The sign of α is reversed: M."
    assert of(5.0, detective=lambda answer: Explanation((), 0.1, 1)).verdict(-5).why.startswith("Right size")


def test_the_detective_names_a_mix_up_that_no_list_foresees():
    reversed_beta = [4.598076, -5.0, 1.964102]
    assert "β" in TASKS["01-point"].verdict(reversed_beta).why


def test_the_detective_of_joints_names_sign_and_zero():
    b, c = TASKS["05-angles"].solution
    assert "sign of C" in TASKS["05-angles"].verdict([b, -c]).why
    assert "off by +90" in TASKS["05-angles"].verdict([b, c + 90]).why
    assert TASKS["05-angles"].verdict([-b, 180 - c]).status == RIGHT
    assert TASKS["05-angles"].verdict([b, c - 360]).status == RIGHT


def test_twins_are_right_answers():
    assert TASKS["02-frame"].verdict([0, -90, 90]).status == RIGHT
    assert TASKS["03-plane"].verdict([-90, -30, 90]).status == RIGHT


def test_an_unknown_name_is_refused_with_the_nearest():
    with pytest.raises(InputError, match="such as '07-pivot', found '07-pivto'"):
        exercise.check("07-pivto", None)


def test_only_some_hand_something_out():
    with pytest.raises(InputError, match="one that hands something out"):
        exercise.given("01-sign")


def notebook(*checks):
    cells = [{"cell_type": "markdown", "source": ["# 01 · Rotating a point (点的旋转), once"]}]
    for source, text in checks:
        output = {"output_type": "stream", "text": text.splitlines(True)}
        cells.append({"cell_type": "code", "source": [source], "outputs": [output]})
    return json.dumps({"cells": cells})


def test_progress_is_read_from_the_saved_notebooks(tmp_path, capsys):
    text = notebook(
        ('exercise.check("01-sign", x)', "01-sign · right. Because.\n"),
        ('exercise.check("01-point", y)', "01-point · not yet. Nearly.\n"),
        ('print("01-slip · right.")', "01-slip · right.\n"),
    )
    (tmp_path / "01_rotating_a_point.ipynb").write_text(text, encoding="utf-8")
    state = exercise.answered(tmp_path)
    assert (state["01-sign"], state["01-point"], state["01-slip"]) == (RIGHT, WRONG, OPEN)
    exercise.progress(tmp_path)
    lines = capsys.readouterr().out.splitlines()
    assert lines[1].split() == ["01", "Rotating", "a", "point", "◐", "●", "○", "○", "1", "of", "4"]
    assert lines[-1].split() == ["all", "lessons", "1", "of", str(len(TASKS))]


def test_the_lessons_as_committed_are_unsolved():
    assert set(exercise.answered(ROOT / "notebooks").values()) == {OPEN}


def test_progress_of_no_lessons(tmp_path):
    with pytest.raises(InputError, match="lessons such as"):
        exercise.progress(tmp_path)
    (tmp_path / "01_a.ipynb").write_text("[]", encoding="utf-8")
    with pytest.raises(InputError, match="expected a notebook"):
        exercise.answered(tmp_path)
