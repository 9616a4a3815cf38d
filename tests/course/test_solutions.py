"""Every exercise: its solution runs where it is shown, its mistakes differ, and nothing given is "right, but"."""

import ast
import builtins
import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mathpost.teaching.course import exercise
from mathpost.teaching.course.answers import Angle, Number, Pose, Written
from mathpost.teaching.course.verdict import EXERCISES
from tests.conftest import LESSONS

OURS = {
    name: each for name, each in EXERCISES.items() if each.solve.__module__.startswith("mathpost.teaching.course")
}
SOURCES = {
    path.name.split("_")[0]: [
        "".join(cell["source"]) for cell in exercise.notebook(path)["cells"] if cell["cell_type"] == "code"
    ]
    for path in LESSONS
}
QUESTIONS = {
    name: "".join(cell["source"]).removeprefix(f"**{name}**")
    for path in LESSONS
    for cell in exercise.notebook(path)["cells"]
    for name in re.findall(r"^\*\*([\w-]+)\*\*", "".join(cell["source"]))
}


def pasted(each):
    """What the shown solution gives in a cell in which the lesson has made `np`, and nothing else, for it."""
    names = {"np": np}
    exec(each.source, names)
    made = names[ast.parse(each.source).body[-1].name]
    return made if isinstance(each.kind, Written) else made(**each.arguments)


@pytest.mark.parametrize("name", OURS)
def test_a_solution_runs_where_it_is_shown(name):
    each = OURS[name]
    value = each.read(pasted(each))
    assert each.kind.same(value, each.solution) or (
        each.complaint and not each.with_arguments(each.complaint, value)
    )


@pytest.mark.parametrize("lesson", sorted({name.split("-")[0] for name in OURS}))
def test_a_lesson_leaves_what_its_solutions_take_for_granted(lesson):
    """So that they give the same after Run All: `np` is NumPy, and no name of Python's own is taken."""
    cells = [ast.parse(re.sub(r"^\s*[%!].*", "", source, flags=re.M)) for source in SOURCES[lesson]]
    bound = {
        node.id
        for cell in cells
        for node in ast.walk(cell)
        if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)
    }
    imported = {
        (alias.name, alias.asname)
        for cell in cells
        for node in ast.walk(cell)
        if isinstance(node, ast.Import)
        for alias in node.names
    }
    used = "\n".join(each.source for name, each in OURS.items() if name.split("-")[0] == lesson)
    assert ("numpy", "np") in imported or not re.search(r"\bnp\.", used)
    named = {name for name in dir(builtins) if name != "_" and re.search(rf"\b{name}\b", used)}  # `_` is doctest's
    assert not bound & ({"np"} | named)


def nothing_done(each):
    """Zero, the identity, and the numbers that the question gives: what stands there before anything is done."""
    given = [
        float(number) for number in re.findall(r"(?<![\w.])-?\d+(?:\.\d+)?", QUESTIONS[each.name].replace("−", "-"))
    ]
    given += [value for value in each.arguments.values() if isinstance(value, int | float)]
    if isinstance(each.kind, Pose):
        return [np.zeros(3), np.eye(3), *(np.array(given[k : k + 3]) for k in range(len(given) - 2))]
    size = len(each.kind.names.split())
    if not size:
        return [0.0, *given]
    return [np.zeros(size), np.ones(size), *(np.array(given[k : k + size]) for k in range(len(given) - size + 1))]


NUMBERS = {  # without the detective, which looks for what is left when no usual mix-up is found
    name: replace(each, detective=None) for name, each in OURS.items() if isinstance(each.kind, Number)
}


@pytest.mark.parametrize("name", NUMBERS)
def test_what_is_given_is_not_right_in_a_different_unit(name):
    for answer in nothing_done(NUMBERS[name]):
        assert "Right, but" not in NUMBERS[name].verdict(answer).why, answer


@settings(max_examples=400)
@given(st.sampled_from(sorted(NUMBERS)), st.data())
def test_what_comes_to_nothing_is_not_right_in_a_different_unit(name, data):
    """The same, within its rounding, with signs changed, with whole turns where turns do not count."""
    each = NUMBERS[name]
    start = np.asarray(data.draw(st.sampled_from(nothing_done(each))), dtype=float)
    signs, within, turns = (
        np.reshape(data.draw(st.lists(values, min_size=start.size, max_size=start.size)), start.shape)
        for values in (st.sampled_from([1, -1]), st.floats(-1, 1), st.integers(-2, 2))
    )
    period = 360 if isinstance(each.kind, Angle) or (isinstance(each.kind, Pose) and start.size == 3) else 0
    answer = signs * start + period * turns + each.kind.bound * within * (start.size != 9)
    assert "Right, but" not in each.verdict(answer.tolist()).why


@pytest.mark.parametrize("name", OURS)
def test_the_mistakes_that_are_named_differ(name):
    """With the lesson's numbers, and with those of some students."""
    for student in ("", "a", "b", "c") if OURS[name].drawn else ("",):
        each = OURS[name].of(student)
        found = [] if each.complaint else each.mixed_up
        same = [
            (one, other)
            for number, (one, value) in enumerate(found)
            for other, target in found[:number]
            if each.kind.same(value, target)
        ]
        assert not same, student
