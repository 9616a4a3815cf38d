"""Every exercise: the stub, right answers in every form, every slip; stored answers; exercises of one's own."""

import ast
import html
import json
import re
from dataclasses import replace

import nbformat
import numpy as np
import pytest
import sympy as sp
from nbclient import NotebookClient
from nbclient.exceptions import CellExecutionError
from scipy.spatial.transform import Rotation

from mathpost import euler, postprocess
from mathpost.detective.explanation import Explanation, Misreading
from mathpost.errors import InputError
from mathpost.files import read_text
from mathpost.frame import Frame
from mathpost.path import cl, selection
from mathpost.shop.controls import writer
from mathpost.shop.controls.blocks import Blocks, rounded
from mathpost.shop.measure.cutter import Cutter
from mathpost.teaching.course import exercise
from mathpost.teaching.course.answers import Angle, Joints, Name, Names, Number, Pose, Vector
from mathpost.teaching.course.lesson_data import load
from mathpost.teaching.course.verdict import EXERCISES, MIME, NO_MIXUP, OPEN, RIGHT, UNREADABLE, WRONG, Exercise
from tests.conftest import LESSONS, ROOT

OURS = {
    name: each for name, each in EXERCISES.items() if each.solve.__module__.startswith("mathpost.teaching.course")
}
EACH = [pytest.param(each, id=name) for name, each in OURS.items()]
SLIPS = [
    pytest.param(each, sentence, id=f"{name}-{number}")
    for name, each in OURS.items()
    for number, sentence in enumerate(each.slips, 1)
]
BY_HAND = {
    "01-sign": [4, -3, 5],
    "01-point": [5 * np.cos(np.radians(25) - np.arctan2(4, 3)), 5, 5 * np.sin(np.radians(25) - np.arctan2(4, 3))],
    "01-still": "z",
    "02-frame": [[0, -1, 0], [0, 0, 1], [-1, 0, 0]],
    "02-lock": 90,
    "03-plane": Rotation.from_euler("y", 30, degrees=True),
    "04-sign": -0.5,
    "05-meet": [1, 0, 0],
    "05-reach": 100,
    "05b-case": [2, 3, 3, 3, 2],
    "05b-turns": [150, -190, -175, -155],
    "05b-count": 5,
    "05b-best": 5,
    "07-way": "retract",
    "08-words": "A, B",
    "09-vertical": [0, 0, 0],
    "11-factor": 2.92,
    "11-psi": 90,
    "12-steps": [3, 4, 5],
    "13-sign": [0, -10, 0],
    "13-ecc": -58.18,
    "14-pi": 180_000 / 16 * (1 / 3.14 - 1 / 3.141592653589793),
    "14-post": -90,
}
# By hand, too, from the numbers in the order in which the question states them.
STATED = {
    "05-reach": lambda _, slant, __: 2 * slant,
    "06-speed": lambda tool, rate: np.degrees(np.arcsin(tool / rate)),
    "06-yardstick": lambda radius, _, __, ___, turn, *____: radius * (1 - np.cos(np.radians(turn / 2))),
    "06b-slopes": lambda a, b, c, d, _, __, first, second: [(b - a) / first, (d - c) / second],
    "06b-seconds": lambda rate, a, long, short: [long / rate + rate / a, 2 * np.sqrt(short / a)],
    "06b-corner": lambda before, after, a, settle: a * settle / (after - before),
    "11-factor": lambda psi: 1 / np.sin(np.radians(psi)),
    "11b-stock": lambda old, new, slope: 500 * (old - new) * (1 - np.cos(np.radians(slope))),
}


def flank(records, *, tcp=False):
    """A program for 07-alone: its records and nothing between them."""
    kin, path = load("bc_table"), cl.parse(exercise.given("07-alone"))
    joints = selection.choose(kin, path).joints[records]
    words = rounded(np.c_[kin.forward(joints)[0], joints[:, 3:]] if tcp else joints)
    count = len(words)
    blocks = Blocks(words, np.full(count, 800.0), np.full(count, np.nan), np.zeros(count, bool), tcp)
    return writer.write(blocks, kin.machine)


def retracted():
    """A right program for 07-alone."""
    return postprocess(cl.parse(exercise.given("07-alone")), load("bc_table").machine, singular="retract").program


JUDGED = [  # answers that no table of typed answers holds, and what is said of them
    ("07-alone", flank(np.arange(11)), "Between records 1 and 2 the tip strays by 0.019 mm"),
    ("07-alone", flank(np.arange(11), tcp=True), "Between records 5 and 6 the tool axis strays by 0.140°"),
    ("07-alone", retracted(), RIGHT),
    ("07-alone", re.sub(r"FT[\d.]+", "F800", retracted()), RIGHT),
    ("07-alone", "HELLO", "cannot be used: your program, line 1"),
    ("07-alone", 5, "found something else"),
    ("11b-gouge", (Cutter.ball(10), Cutter(8, 1)), "the dome above"),
    ("11b-gouge", (Cutter.ball(12), Cutter.ball(11.8)), "does not gouge"),
    ("11b-gouge", (Cutter.ball(10), Cutter.flat(12)), "is not smaller"),
    ("11b-gouge", ((10, 9), (8, 1)), "cannot be used: cutter: expected a diameter above 0"),
]


UNIT_WORDS = {
    "degrees": ("deg", "degrees", "°", "度"),
    "mm": ("mm", "毫米"),
    "s": ("s", "seconds", "秒"),
    "µm": ("µm", "μm", "um"),
    "µrad": ("µrad", "μrad", "urad"),
}


def forms(kind, value):
    """The same answer in all the forms that a learner may type."""
    yield value
    if isinstance(kind, Pose):
        matrix = kind._matrix(value)
        quaternion = euler.to_quaternion(matrix)
        yield from (matrix, matrix.round(4), Frame(matrix), Rotation.from_matrix(matrix), sp.Matrix(matrix))
        yield from (quaternion, -quaternion, list(quaternion.round(5)))
        angles = euler.angles("ZXZ", matrix, degrees=True)
        twin = euler.twin("ZXZ", angles, degrees=True)
        yield from (angles, twin, np.add(angles, [360, 0, -360]), tuple(twin.round(2)), np.reshape(angles, (3, 1)))
    elif isinstance(kind, Joints):
        tip, axis = kind.kinematics().forward([0, 0, 0, *value], degrees=True)
        for branch in kind.kinematics().inverse(tip, axis, degrees=True)[:, 3:]:
            yield from (branch, tuple(branch), np.add(branch, [0, 360]), branch - [360, 720])
            yield np.round(branch, kind.decimals).tolist()
            yield dict(zip(kind.names.split(), branch, strict=True))
    elif isinstance(kind, Names):
        yield from (value[::-1], tuple(value), set(value), np.array(value), ", ".join(value), "、".join(value))
        yield from (" and ".join(value), [f' "{each.upper()}" ' for each in value], dict.fromkeys(value, 1))
        yield from ("和".join(value), f"the {'′, the '.join(value)} axes", [f"{each}'" for each in value])
        yield [said for said in kind.known if kind.known[said] in value]
    elif isinstance(kind, Name):
        yield from (f" {value}\n", f'"{value}"', f"‘{value}’", f"{value}'", value.upper(), [value], np.str_(value))
        yield from (f"the {value}", *(said for said in kind.known if kind.known[said] == value))
    elif isinstance(kind, Number):
        numbers = np.asarray(value)
        yield from (numbers, sp.Matrix(numbers) if numbers.ndim else sp.Float(float(value), 15))
        if numbers.ndim:
            names, unit = kind.names.split(), {"degrees": "°", "mm": " mm", "µm": " µm"}.get(kind.unit, "")
            yield " ".join(f"{name}{each!r}{unit}" for name, each in zip(names, value, strict=True))
            yield ", ".join(f"{name} = {each!r}{unit}" for name, each in zip(names, value, strict=True))
            yield from (
                tuple(value),
                numbers.reshape(-1, 1),
                numbers.reshape(1, -1),
                str(value),
                sp.Matrix(value).T,
            )
            yield dict(zip(kind.names.split(), value, strict=True))
        else:
            yield from (str(value), [value], np.array([[value]]), f" {value} ".replace("-", "−"))
            yield from ([f"{value} {unit}" for unit in UNIT_WORDS.get(kind.unit, [kind.unit])] if kind.unit else ())
        if kind.decimals is not None:
            yield from (numbers.round(kind.decimals), numbers.round(kind.decimals + 1), kind.show(value))
            yield kind.show(value).replace(", ", "; ").replace(".", ",")
        if isinstance(kind, Angle):
            yield from (value + 360, value - 360, np.round(value + 720, kind.decimals), f"{value}°")


def stored(verdict):
    """The answer as it comes out of a saved notebook."""
    return json.loads(json.dumps(verdict._repr_mimebundle_()[MIME]))["answer"]


@pytest.mark.parametrize("each", EACH)
def test_stub(each):
    for stub in (None, ..., [None, None, None]):
        verdict = each.verdict(stub)
        assert verdict.status == OPEN
        assert stored(verdict) is None
    assert each.kind.asked in verdict.why


@pytest.mark.parametrize("each", EACH)
def test_right_in_every_form_also_when_judged_anew(each):
    for answer in forms(each.kind, each.solution):
        verdict = each.verdict(answer)
        assert verdict.status == RIGHT, f"{answer!r}: {verdict}"
        assert each.verdict(stored(verdict)).status == RIGHT, answer
    assert len(verdict.why) > 30, "a right answer teaches"


@pytest.mark.parametrize("name", BY_HAND)
def test_right_by_hand(name):
    assert str(exercise.judge(name, BY_HAND[name])).startswith(f"{name} · {RIGHT}.")


@pytest.mark.parametrize("name", STATED)
def test_right_from_the_numbers_of_the_question(name):
    sources = ["".join(cell["source"]) for path in LESSONS for cell in exercise.notebook(path)["cells"]]
    question = next(source for source in sources if source.startswith(f"**{name}**")).partition("** ")[2]
    stated = re.findall(r"(?<![\w.])-?\d+(?:\.\d+)?", question.replace("−", "-"))
    assert exercise.judge(name, STATED[name](*map(float, stated))).status == RIGHT


@pytest.mark.parametrize("each", EACH)
def test_what_any_answer_can_suffer_is_named(each):
    for _, value in [] if each.complaint else each.common:
        verdict = each.verdict(value)
        assert verdict.status == WRONG
        assert verdict.mixup, f"{value}: {verdict.why}"


@pytest.mark.parametrize(("each", "sentence"), SLIPS)
def test_slip_is_named_in_every_form_also_when_judged_anew(each, sentence):
    if sentence not in dict(each.mixed_up):  # with the lesson's numbers it happens to give the right answer
        assert each.drawn
        return
    for answer in forms(each.kind, dict(each.mixed_up)[sentence]):
        verdict = each.verdict(answer)
        assert (verdict.status, verdict.why) == (WRONG, sentence), answer
        assert replace(each.verdict(stored(verdict)), answer=None) == replace(verdict, answer=None)


@pytest.mark.parametrize(("name", "answer", "said"), JUDGED)
def test_judged(name, answer, said):
    verdict = exercise.judge(name, answer)
    assert said in str(verdict)
    assert str(exercise.judge(name, stored(verdict))) == str(verdict)


@pytest.mark.parametrize("each", [each for each in EACH if isinstance(each.values[0].kind, Name)])
def test_every_wrong_choice_helps(each):
    names = each.kind.listed
    if isinstance(each.kind, Names):
        target = set(each.solution)
        wrong = [target ^ {name} for name in names] + [{name} for name in names] + [set(names), set(names) - target]
        wrong = [some for some in wrong if some != target]
    else:
        wrong = [name for name in names if name != each.solution]
    for answer in wrong:
        verdict = each.verdict(answer)
        assert verdict.status == WRONG
        assert len(verdict.why.removeprefix(NO_MIXUP)) > 30, f"{answer}: {verdict.why}"


@pytest.mark.parametrize("each", EACH)
def test_no_answer_raises_or_passes(each):
    nonsense = ["", "nonsense", [], [[]], {}, {"a": 1}, object(), np.nan, np.inf, -1e9, [1e9] * 3, [np.nan] * 3, 1j]
    nonsense += [
        (1, "a"),
        len,
        True,
        "1 2 x",
        b"1",
        Frame,
        [[1, 2], [3]],
        {UNREADABLE: "x"},
        10**400,
        np.datetime64("now"),
    ]
    for answer in nonsense:
        verdict = each.verdict(answer)
        assert verdict.status == WRONG, answer
        assert each.verdict(stored(verdict)).status == WRONG, answer


@pytest.mark.parametrize("each", EACH)
def test_each_names_a_mixup_or_judges(each):
    assert each.slips or each.complaint
    assert "return" in each.source and '"""' not in each.source and "@" not in each.source.splitlines()[0]


def test_a_slip_that_the_table_does_not_name_is_refused():
    again = lambda: [4, -3, 5]  # noqa: E731
    again.__module__ = EXERCISES["01-sign"].solve.__module__
    with pytest.raises(InputError, match=r"exercises.toml, 01-sign: expected a slip by tangent"):
        exercise.define("01-sign", Vector())(exercise.slip("tangent", [1, 2, 3])(again))
    assert len(EXERCISES["01-sign"].slips) == 2


@pytest.mark.parametrize("path", LESSONS[1:], ids=lambda path: path.stem)
def test_lesson_poses_its_exercises(path):
    cells = json.loads(path.read_text(encoding="utf-8"))["cells"]
    sources = ["".join(cell["source"]) for cell in cells]
    answers = {}
    for name in (name for name in OURS if name.split("-")[0] == path.name.split("_")[0]):
        question = next(number for number, source in enumerate(sources) if f"**{name}**" in source)
        stub, check, solved = cells[question + 1 : question + 4]
        answer = ast.parse("".join(stub["source"])).body[-1].targets[0].id
        assert "".join(stub["source"]).endswith(f"{answer} = None")
        assert "".join(check["source"]) == f'exercise.check("{name}", {answer})'
        assert "".join(check["outputs"][0]["data"]["text/plain"]).startswith(f"{name} · {OPEN}.")
        assert "".join(solved["source"]) == f'exercise.solution("{name}")'
        assert solved["metadata"] == {"jupyter": {"source_hidden": True}, "tags": ["solution"]}
        shown = solved["outputs"][0]["data"]
        assert "".join(shown["text/plain"]) == f"Solution of {name}: you have not tried yet"
        assert re.fullmatch(r"<details><summary>.*</details>", "".join(shown["text/html"]), re.DOTALL)
        assert html.escape(EXERCISES[name].shown_solution) in "".join(shown["text/html"])
        answers[answer] = name
    assert len(answers) >= 3
    posed = re.findall(r'exercise\.\w+\("(.*?)"', "\n".join(sources))
    assert set(posed) == set(answers.values())


@pytest.mark.parametrize(
    ("guess", "truth", "right"),
    [
        (-650.0, -650, True),
        ("-650 ", -650, True),
        (174.4, "174", True),
        (174.6, "174", False),
        (1.97, 2, True),
        (3.14, np.pi, True),
        (3.15, np.pi, False),
        (3, np.pi, False),
        (0, 0.01, False),
        ("10", "+10", True),
        (sp.Integer(-1), sp.Integer(-1), True),
        (-1.0, sp.Integer(-1), True),
        (1, True, False),
        ("true", True, True),
        (" Up", "up", True),
        ("down", "up", False),
        ([1, 2], 1, False),
        (object(), 1, False),
        (np.nan, 1, False),
    ],
)
def test_a_guess_is_right_if_it_is_correctly_rounded(guess, truth, right, capsys):
    exercise.reveal(guess, truth)
    assert ("You guessed it." in capsys.readouterr().out) is right


# --- kinds of answers -------------------------------------------------------------------------------------------


def of(kind, solution, **how):
    return Exercise("00-test", kind, lambda: solution, **how)


@pytest.mark.parametrize(
    ("kind", "solution", "answer", "said"),
    [
        (Number(), 2.5, -2.5, "wrong sign"),
        (Angle(), 30, np.radians(30), "in radians: answer in degrees"),
        (Angle(), 35, 55, "missing to 90°"),
        (Angle(), 30, 210, "half a turn away"),
        (Angle(decimals=1), 100, 0, NO_MIXUP),  # 100° are 360,000 arcseconds, which is no reason
        (Angle(decimals=2), 66.45, 360, NO_MIXUP),
        (Number(unit="radians"), 0.5, np.degrees(0.5), "in degrees: answer in radians"),
        (Number(unit="mm"), 0.25, 250, "in µm"),
        (Number(unit="mm"), 25.4, 1, "in inches"),
        (Number(decimals=5, unit="degrees"), 0.01, 36, "in arcseconds"),
        (Number(), 3, 6, "twice"),
        (Number(), 3, 1.5, "half"),
        (Number(), 4, 0.25, "one over"),
        (Number(), 100, 100.5, NO_MIXUP),
        (Number(), 66.4519, 66.45, "Correct as far as its digits go. Answer with one number, to 3 decimals."),
        (Number(), 66.4519, 66.4, NO_MIXUP),
        (Number(), 2.9238, 3, NO_MIXUP),
        (Vector(), [1, 2, 3], [1, -2, 3], "sign of y"),
        (Vector(), [1, 2, 3], [2, 1, 3], "different order"),
        (Vector(), [1, 2, 3], [-1, -2, -3], "wrong sign"),
        (Vector(), [1, 2, 3], [1, 2, 7], "Right: x, y. Look once more at z."),
        (Vector(), [1, 2, 3], [1, 2], "Expected three numbers (x, y, z), to 3 decimals; found two numbers."),
        (Vector(), [0, 0, 0], [1, 1, 1], NO_MIXUP),
        (Pose(), [20, 30, 40], [40, 30, 20], "different order"),
        (Pose(), [20, 30, 40], np.radians([20, 30, 40]), "in radians"),
        (Pose(), [20, 30, 40], [-40, -30, -20], "transpose"),
        (Pose(), [20, 30, 40], [20, 30, 70], "Z of the frame is right"),
        (Pose(), [20, 30, 40], [20.02, 30, 40], "Z of the frame is right"),
        (Names("a b"), ["a"], ["b"], "exactly those that do not belong"),
        (Names("a b c"), ["a"], ["a", "c"], "c does not belong"),
        (Names("a b c"), ["a", "b"], ["A"], "there are more"),
        (Name("active passive"), "active", "elements", "Expected one of active, passive; found 'elements'."),
        (Name("x y"), "x", "not x", "Expected one of x, y"),
    ],
)
def test_common_mixups(kind, solution, answer, said):
    verdict = of(kind, solution).verdict(answer)
    assert verdict.status == WRONG
    assert said in verdict.why


def test_the_detective_is_asked_after_named_slips_and_before_common_ones():
    found = Explanation((Misreading("the sign of α is reversed", "M", ("sign",), np.array(0), (), 1.0),), 0.1, 1)
    each = of(Number(), 5.0, slips={"Named.": {"answer": 7}}, detective=lambda answer: found)
    assert each.verdict(7).why == "Named."
    assert each.verdict(-5).why == "The sign of α is reversed: M."
    silent = of(Number(), 5.0, detective=lambda answer: Explanation((), 0.1, 1))
    assert silent.verdict(-5).why.startswith("Right size")


def test_the_detective_names_a_mix_up_that_no_list_foresees():
    assert "β" in exercise.judge("01-point", [4.409396, -5.0, 2.357376]).why
    assert exercise.judge("01-point", [3, 4, 5]).why.startswith("α and β are left out")
    b, c = EXERCISES["05-angles"].solution
    assert "sign of C" in exercise.judge("05-angles", [b, -c]).why
    assert "off by -90" in exercise.judge("05-angles", [b, c - 90]).why
    assert "as far as its digits go" in exercise.judge("05-angles", [round(b, 2), round(c, 2)]).why


# --- by name, in files, in notebooks ----------------------------------------------------------------------------


def test_an_unknown_name_is_refused_with_the_nearest():
    with pytest.raises(InputError, match="such as '07-pivot', found '07-pivto'"):
        exercise.check("07-pivto", None)


def test_only_some_hand_something_out():
    with pytest.raises(InputError, match="one that hands something out"):
        exercise.given("01-sign")


def test_a_name_of_the_lessons_is_not_taken():
    with pytest.raises(InputError, match="expected a name of its own, found '01-sign', which mathpost"):
        exercise.define("01-sign", Number())(lambda: 1)
    assert exercise.judge("01-sign", [4, -3, 5]).status == RIGHT


@pytest.fixture
def own():
    """Exercises that a test defines are forgotten after it."""

    def define(name, kind, solve, slips=(), **how):
        for sentence, answer in slips:
            solve = exercise.slip(sentence, answer)(solve)
        exercise.define(name, kind, **how)(solve)

    yield define
    for name in [name for name, each in EXERCISES.items() if each.solve.__module__ == __name__]:
        del EXERCISES[name]


def test_what_the_exercise_lacks_is_not_the_learners_mistake(own):
    own("t-file", Number(), lambda: read_text("no/such/file"))
    assert exercise.judge("t-file", None).status == OPEN
    for answer in (1, "nonsense"):
        with pytest.raises(InputError, match="no/such/file: expected a readable file"):
            exercise.judge("t-file", answer)
    own("t-slip", Number(), lambda: 1, slips=[("No.", lambda: read_text("no/such/slip"))])
    with pytest.raises(InputError, match="no/such/slip"):
        exercise.judge("t-slip", 2)


def test_an_exercise_that_contradicts_itself_says_so(own):
    own("t-slip", Angle(), lambda: 30, slips=[("Wrong way round.", 390)])
    with pytest.raises(InputError, match="exercise t-slip: expected a slip that gives a wrong answer"):
        exercise.judge("t-slip", 2)
    own("t-case", Number(), lambda: 1, complaint=lambda value: "Too small.")
    with pytest.raises(InputError, match="exercise t-case: expected a solution that has nothing wrong"):
        exercise.judge("t-case", 2)


OWN = '''
from mathpost.teaching.course import answers, exercise

@exercise.define("20-bevel", answers.Angle(decimals=1))
@exercise.slip("That is twice the angle.", times=2)
def bevel(times=1):
    """The tangent."""
    return times * SLOPE
'''


def run(path, *sources):
    cells = [nbformat.v4.new_markdown_cell("# 20 · A bevel"), *map(nbformat.v4.new_code_cell, sources)]
    notebook = nbformat.v4.new_notebook(cells=cells)
    NotebookClient(notebook, resources={"metadata": {"path": str(path.parent)}}).execute()
    nbformat.write(notebook, path)
    assert all(len(cell.outputs) <= 1 for cell in notebook.cells[1:])
    return [cell.outputs[0].data if cell.outputs else None for cell in notebook.cells[1:]]


def test_a_teachers_exercise_in_a_notebook_defined_twice(tmp_path, capsys):
    path = tmp_path / "20_bevel.ipynb"
    first, second = OWN.replace("SLOPE", "30"), OWN.replace("SLOPE", "26.6")
    check, show = "exercise.check('20-bevel', {})".format, "exercise.solution('20-bevel')"
    *_, open_, closed, slip = run(path, first, second, check(None), show, check(53.2))
    assert open_["text/plain"] == "20-bevel · not attempted yet. Answer with one angle in degrees, to 1 decimal."
    assert slip["text/plain"] == "20-bevel · not yet. That is twice the angle."
    assert slip[MIME] == {"answer": 53.2, "exercise": "20-bevel"}
    # The attempt that followed has changed what the solution, which was shown before, says of itself.
    assert "<summary>Solution of 20-bevel</summary>" in closed["text/html"]
    assert "def bevel(times=1):" in closed["text/html"]
    assert "26.6" in closed["text/html"] and "26.6" not in closed["text/plain"]
    (verdict,) = [each for each in exercise.answered(tmp_path).values() if each.name == "20-bevel"]
    assert (verdict.status, verdict.why) == (WRONG, "This exercise is not defined here.")
    exercise.progress(tmp_path)
    assert "20 A bevel                                  ◐" in capsys.readouterr().out


def test_a_missing_file_stops_the_cell(tmp_path):
    source = OWN.replace("SLOPE", "float(open('slope.txt').read())") + "\nexercise.check('20-bevel', 53.2)"
    with pytest.raises(CellExecutionError, match=r"slope\.txt"):
        run(tmp_path / "20_bevel.ipynb", source)


def notebook(*checks):
    cells = [{"cell_type": "markdown", "source": ["# 01 · Rotating a point (点的旋转), once"]}]
    for source, text, answer in checks:
        name = text.split(" · ")[0]
        data = {"text/plain": text.splitlines(True), MIME: {"answer": answer, "exercise": name}}
        output = {"output_type": "display_data", "data": data}
        cells.append({"cell_type": "code", "source": [source], "outputs": [output]})
    return json.dumps({"cells": cells})


def test_progress_is_read_from_saved_notebooks_and_judged_anew(tmp_path, capsys):
    text = notebook(
        ('exercise.check("01-sign", x)', "01-sign · right. Because.", [4, -3, 5]),
        ('exercise.check("01-point", y)', "01-point · right. Because.", [1, 2, 3]),
        ('exercise.check("01-still", y)', "01-still · not yet. So.", "Z'"),
        ('print("01-slip · right.")', "01-slip · right.", "active"),
    )
    (tmp_path / "01_rotating_a_point.ipynb").write_text(text, encoding="utf-8")
    found = exercise.answered(tmp_path)
    assert [
        (found[f"01-{word}"].status, found[f"01-{word}"].edited) for word in ("sign", "point", "still", "slip")
    ] == [
        (RIGHT, False),
        (WRONG, True),
        (RIGHT, True),
        (OPEN, False),
    ]
    exercise.progress(tmp_path)
    lines = capsys.readouterr().out.splitlines()
    assert lines[1].split() == ["01", "Rotating", "a", "point", "◐", "●", "○", "●", "○", "2", "of", "5"]
    assert lines[2].split() == ["all", "lessons", "2", "of", str(len(EXERCISES))]
    assert lines[3] == "01-point: the notebook says something else than its answer deserves (not yet)."


def test_a_verdict_without_its_answer_counts_for_nothing(tmp_path):
    path = tmp_path / "01_a.ipynb"
    text = notebook(('exercise.check("01-sign", x)', "01-sign · right. Because.", [4, -3, 5]))
    path.write_text(text.replace(MIME, "application/json"), encoding="utf-8")
    (verdict,) = exercise.judged(path)
    assert (verdict.status, verdict.edited) == (OPEN, True)


def test_the_lessons_as_committed_are_unsolved():
    found = exercise.answered(ROOT / "notebooks").values()
    assert {(each.status, each.edited) for each in found} == {(OPEN, False)}


@pytest.mark.parametrize(
    "text", ["[]", "{", '{"cells": [1]}', '{"cells": [{"cell_type": "code", "source": 1}]}', "[" * 9999]
)
def test_progress_of_no_lessons(tmp_path, text):
    with pytest.raises(InputError, match="lessons such as"):
        exercise.progress(tmp_path)
    (tmp_path / "01_a.ipynb").write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match="expected a notebook"):
        exercise.answered(tmp_path)
