"""A class that was made up: right, wrong by every mix-up that has a name, forged, empty, broken, copied."""

import ast
import csv
import inspect
import io
import json
import re
import shutil
import zipfile
from html.parser import HTMLParser
from pathlib import Path

import openpyxl
import pytest
from jinja2 import Environment, nodes

from mathpost import machine_file
from mathpost.detective.causes import causes_of_words
from mathpost.detective.euler_angles import MORE_DIGITS
from mathpost.detective.misreadings import all_factors, wordings
from mathpost.errors import InputError
from mathpost.interface.shell.main import main
from mathpost.teaching.classroom import grade_page
from mathpost.teaching.classroom.grade import CELLS, DUPLICATED, FILE, RETYPED, TEXT, Rules, grade, read_rules
from mathpost.teaching.classroom.handed_in import collect, unzip
from mathpost.teaching.course import exercise
from mathpost.teaching.course.answers import Number
from mathpost.teaching.course.verdict import EXERCISES, OPEN, RIGHT, WRONG
from tests.conftest import ROOT

LESSON = "01_rotating_a_point"
OURS = {
    name: each for name, each in EXERCISES.items() if each.solve.__module__.startswith("mathpost.teaching.course")
}
LESSON_01 = [name for name in OURS if name.startswith("01-")]


def cell(source, *outputs):
    return {"cell_type": "code", "source": source, "metadata": {}, "execution_count": 1, "outputs": list(outputs)}


def shown(verdict):
    return {"output_type": "display_data", "metadata": {}, "data": verdict._repr_mimebundle_()}


def notebook(answers, *own):
    """A notebook as a student saves it: exercises and answers, then cells of the student's own."""
    cells = [
        cell(f'exercise.check("{name}", answer)', shown(OURS[name].verdict(answer))) for name, answer in answers
    ]
    return {"cells": [*cells, *map(cell, own)], "metadata": {}, "nbformat": 4, "nbformat_minor": 5}


def forged(answers):
    """A notebook whose verdicts were edited into "right"."""
    page = notebook(answers)
    for each in page["cells"]:
        data = each["outputs"][0]["data"]
        data["text/plain"] = data["text/plain"].replace(WRONG, RIGHT).replace(OPEN, RIGHT)
    return json.loads(json.dumps(page))


def write(path, content):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(content if isinstance(content, str) else json.dumps(content), encoding="utf-8")


def solved(names=LESSON_01):
    return [(name, OURS[name].solution) for name in names]


def by_name(graded):
    return {each.name: each for each in graded.results}


@pytest.fixture(scope="module")
def handed_in(tmp_path_factory):
    """A class of all the states."""
    folder = tmp_path_factory.mktemp("class")
    file = f"{LESSON}.ipynb"
    write(folder / "王小明" / file, notebook(solved()))
    write(folder / "Ольга" / file, notebook([("01-sign", None), ("01-still", "x")]))
    write(folder / "eve" / file, forged([("01-sign", [-4, 3, 5]), ("01-still", None)]))
    write(folder / "stripped" / file, forged(solved(["01-sign"])))
    stripped = json.loads((folder / "stripped" / file).read_text(encoding="utf-8"))
    for data in (output["data"] for each in stripped["cells"] for output in each["outputs"]):
        data["application/vnd.mathpost+json"]["answer"] = None
    write(folder / "stripped" / file, stripped)
    write(folder / "empty" / file, "")
    write(folder / "blank" / file, {"cells": [], "metadata": {}, "nbformat": 4, "nbformat_minor": 5})
    write(folder / "broken" / file, '{"cells": [')
    write(folder / "list" / file, "[1, 2]")
    write(folder / "other" / file, {"cells": [{"cell_type": "code", "source": "exercise.check(", "outputs": 7}]})
    (folder / "nothing").mkdir()
    work = notebook(solved(["01-sign"]), "# my own derivation\n" + "x = 1  # a comment of some length\n" * 4)
    write(folder / "first" / file, work)
    write(folder / "second" / file, work | {"metadata": {"touched": True}})
    write(folder / "third" / file, notebook(solved(["01-sign"]), "# somebody's else\n" + "y = 2  # a remark\n" * 8))
    shutil.copytree(ROOT / "notebooks", folder / "untouched", ignore=lambda _, names: set(names) - {file})
    return folder


def test_every_state(handed_in):
    found = by_name(grade(handed_in))
    assert set(found) == {path.name for path in handed_in.iterdir()}
    statuses = {name: [each.status(exercise) for exercise in LESSON_01] for name, each in found.items()}
    assert statuses["王小明"] == [RIGHT] * len(LESSON_01)
    assert (found["Ольга"].status("01-sign"), found["Ольга"].status("01-still")) == (OPEN, WRONG)
    assert found["Ольга"].mixups == {("01-still", next(iter(OURS["01-still"].slips)))}
    assert found["eve"].edited == ["01-sign", "01-still"] and RIGHT not in statuses["eve"]
    assert found["stripped"].edited == ["01-sign"] and found["stripped"].status("01-sign") == OPEN
    assert statuses["untouched"] == [OPEN] * len(LESSON_01) and not found["untouched"].trouble
    assert not any(each.edited for name, each in found.items() if name not in ("eve", "stripped"))
    trouble = {name: each.trouble[0][1] for name, each in found.items() if each.trouble}
    assert trouble == {
        "empty": "expected a notebook, found an empty file",
        "blank": "no cell has anything in it",
        "broken": "expected a notebook, found something else",
        "list": "expected a notebook, found something else",
        "other": "expected a notebook, found something else",
        "nothing": "nothing was handed in",
    }
    assert found["王小明"].status("02-frame") == "", "a lesson that was not handed in is not open"


def test_the_same_hand_ins_and_no_others(handed_in):
    assert grade(handed_in).same == [(TEXT, f"{LESSON}.ipynb", ["first", "second"])]


@pytest.fixture(scope="module")
def mixed_up(tmp_path_factory):
    """A class that answers one exercise each: not, right, and by every mix-up that it names."""
    folder = tmp_path_factory.mktemp("mixed_up")
    for name, each in OURS.items():
        answers = {"open": None, "right": each.solution}
        answers |= {f"student {n}": value for n, value in enumerate(dict(each.mixed_up).values())}
        for student, value in answers.items():
            write(folder / f"{name} {student}" / "work.ipynb", notebook([(name, value)]))
    graded = grade(folder)
    return graded.results, graded.mixups(), graded.failed()


@pytest.mark.parametrize("name", OURS)
def test_every_named_mixup_is_counted(name, mixed_up):
    sentences, (results, mixups, failed) = dict(OURS[name].mixed_up), mixed_up
    statuses = [each.status(name) for each in results if each.name.startswith(f"{name} ")]
    assert statuses == [OPEN, RIGHT] + [WRONG] * len(sentences)
    said = [OURS[name].verdict(value).mixup for value in sentences.values()]
    assert all(said) and sum(number for of, *_, number in mixups if of == name) == len(sentences)
    assert [each for each in failed if each[0] == name] == (
        [(name, len(sentences) + 1, len(sentences))] if sentences else []
    )


def test_of_several_answers_the_best_counts_and_every_mixup(tmp_path):
    wrong = OURS["01-sign"].mixed_up[0]
    write(tmp_path / "ada" / "a.ipynb", notebook([("01-sign", wrong[1]), *solved(["01-sign"]), ("01-sign", None)]))
    write(tmp_path / "ada" / "b.ipynb", notebook([("01-sign", wrong[1])]))
    graded = grade(tmp_path)
    assert graded.results[0].status("01-sign") == RIGHT
    assert graded.mixups() == [("01-sign", wrong[0], 1)]


def test_an_exercise_that_is_not_defined_here_gives_nothing(tmp_path):
    page = notebook(solved(["01-sign"]))
    text = json.dumps(page, default=str).replace("01-sign", "99-own")
    write(tmp_path / "ada" / "a.ipynb", text)
    result = grade(tmp_path).results[0]
    assert result.unknown == {"99-own": RIGHT} and not result.verdicts


# --- whose is it --------------------------------------------------------------------------------------------------


def names(folder, tmp_path):
    return {
        each.name: sorted(path.name for path in each.notebooks)
        for each in collect(folder, tmp_path / "unpacked", [LESSON])
    }


def test_zips_flat_files_and_moodle(tmp_path):
    folder = tmp_path / "in"
    page = json.dumps(notebook(solved()))
    write(folder / f"李雷_{LESSON}.ipynb", page)
    write(folder / f"{LESSON} (Zoë).ipynb", page)
    write(folder / "韩梅梅_4711_assignsubmission_file_" / "work.ipynb", page)
    write(folder / ".ipynb_checkpoints" / "x.ipynb", page)
    shutil.copy(ROOT / "data/workbooks/missing_transpose.xlsx", folder / "李雷 作业.xlsx")
    shutil.copy(ROOT / "data/workbooks/missing_transpose.xlsx", folder / "Jörg.xlsx")
    with zipfile.ZipFile(folder / "張三.zip", "w") as packed:
        packed.writestr("张三/作业.ipynb", page)
        packed.writestr("__MACOSX/张三/._作业.ipynb", "")
    found = {each.name: each for each in collect(folder, tmp_path / "unpacked", [LESSON])}
    assert sorted(found) == sorted(["李雷", "Zoë", "韩梅梅", "Jörg", "張三"])
    assert [path.name for path in found["張三"].notebooks] == ["作业.ipynb"]
    assert [path.name for path in found["李雷"].workbooks] == ["李雷 作业.xlsx"]
    assert not any(each.refused for each in found.values())


def test_a_zip_packed_with_a_chinese_code_page(tmp_path):
    path = tmp_path / "in" / "王.zip"
    path.parent.mkdir()
    with zipfile.ZipFile(path, "w") as packed:
        packed.writestr("xx.ipynb", json.dumps(notebook(solved())))
    path.write_bytes(path.read_bytes().replace(b"xx.ipynb", "王".encode("gb18030") + b".ipynb"))
    assert names(tmp_path / "in", tmp_path) == {"王": ["王.ipynb"]}


def test_nbgraders_folders(tmp_path):
    page = notebook(solved())
    for top in ("submitted", "autograded", "source"):
        write(tmp_path / "course" / top / "王小明" / "ps1" / "a.ipynb", page)
    write(tmp_path / "course/submitted/bob/ps1/b.ipynb", page)
    for folder in ("course", "course/submitted"):
        assert names(tmp_path / folder, tmp_path / folder) == {"王小明": ["a.ipynb"], "bob": ["b.ipynb"]}
    inbound = tmp_path / "exchange/inbound"
    write(inbound / "ada+ps1+2026-03-01 10:00:00 UTC+x" / "old.ipynb", page)
    write(inbound / "ada+ps1+2026-03-02 10:00:00 UTC+y" / "new.ipynb", page)
    write(inbound / "ada+ps2+2026-03-01 10:00:00 UTC" / "two.ipynb", page)
    assert names(tmp_path / "exchange", tmp_path) == {"ada": ["new.ipynb", "two.ipynb"]}


def packed(path, *members):
    path.parent.mkdir(parents=True, exist_ok=True)
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as target:
        for name, content in members:
            target.writestr(name, content)
    return path


@pytest.mark.parametrize(
    "name", ["../out.ipynb", "/out.ipynb", "a/../../out.ipynb", "..\\out.ipynb", "C:\\x.ipynb"]
)
def test_a_zip_that_leads_out_is_refused_by_name(tmp_path, name):
    packed(tmp_path / "in" / "eve.zip", ("good.ipynb", "{}"), (name, "{}"))
    (eve,) = collect(tmp_path / "in", tmp_path / "unpacked")
    assert (
        not eve.notebooks and "inside the zip's own folder" in eve.refused[0][1] and eve.refused[0][0] == "eve.zip"
    )
    assert not list(tmp_path.glob("out*")) and not list((tmp_path / "unpacked").glob("out*"))


def test_bombs_links_and_zips_in_zips_are_refused(tmp_path):
    folder = tmp_path / "in"
    packed(folder / "bomb.zip", *((f"{n}.ipynb", bytes(2**25)) for n in range(9)))
    packed(folder / "many.zip", *((f"{n}.txt", "") for n in range(2001)))
    packed(folder / "nested.zip", ("inner.zip", packed(tmp_path / "x.zip", ("a.ipynb", "{}")).read_bytes()))
    link = zipfile.ZipInfo("a.ipynb")
    link.external_attr = 0o120777 << 16
    packed(folder / "link.zip", (link, "/etc/passwd"))
    (folder / "notzip.zip").write_bytes(b"PK\x03\x04 rubbish")
    (folder / "linked").mkdir()
    (folder / "linked" / "a.ipynb").symlink_to("/etc/passwd")
    found = {each.name: each.refused[0][1] for each in collect(folder, tmp_path / "unpacked")}
    assert "288 MB" in found["bomb"] and "2001 files" in found["many"]
    assert "a zip in a zip" in found["nested"] and "a link" in found["link"] and "a link" in found["linked"]
    assert "a zip that can be unpacked" in found["notzip"]


def test_a_zip_that_lies_about_its_size(tmp_path):
    path = packed(tmp_path / "liar.zip", ("a.ipynb", bytes(10_000)))
    content = bytearray(path.read_bytes())
    for mark, offset in ((b"PK\x03\x04", 22), (b"PK\x01\x02", 24)):
        place = content.find(mark) + offset
        content[place : place + 4] = (100).to_bytes(4, "little")
    path.write_bytes(content)
    with pytest.raises(InputError):
        unzip(path, tmp_path / "out")
    assert not any(each.stat().st_size > 100 for each in (tmp_path / "out").rglob("*.ipynb"))


# --- workbooks ----------------------------------------------------------------------------------------------------


def test_workbooks_beside_notebooks(tmp_path):
    folder, said = tmp_path / "in", []
    for student, name in (("李雷", "missing_transpose"), ("韩梅梅", "missing_transpose"), ("ada", "right")):
        (folder / student).mkdir(parents=True)
        book = openpyxl.load_workbook(ROOT / f"data/workbooks/{name}.xlsx")
        book.properties.creator = student
        book.save(folder / student / "作业.xlsx")
    (folder / "course").mkdir()
    shutil.copy(ROOT / "data/workbooks/right.xlsx", folder / "course")
    write(folder / "坏" / "a.xlsx", "rubbish")
    write(folder / "ada" / "a.ipynb", notebook(solved(["01-sign"])))
    graded = grade(folder, Rules(exercises=("01-sign",), workbooks=3.0), progress=lambda *step: said.append(step))
    found = by_name(graded)
    (wrong,) = found["李雷"].workbooks
    assert (wrong.verdict, wrong.cause) == ("wrong", "transposed") and "!" in wrong.cell
    assert graded.same == [(CELLS, "作业.xlsx", ["李雷", "韩梅梅"])]
    assert not found["course"].workbooks, "the course's own workbook is nobody's work"
    assert found["坏"].workbooks[0].verdict == "not read" and found["坏"].trouble
    assert [graded.mark(found[name]) for name in ("ada", "李雷")] == [100, 0]
    assert len(said) == 5 and said[-1][:2] == (5, 5)
    assert "转置" in grade_page.to_html(graded, "zh") and "转置" in grade_page.to_csv(graded, "zh")


# --- marks and the report -----------------------------------------------------------------------------------------


def test_points_and_weights(handed_in, tmp_path):
    write(
        tmp_path / "rules.toml",
        'students = ["王小明", "absent"]\nexercises = ["01"]\n[points]\n"01-sign" = 5\n"01" = 2\n',
    )
    graded = grade(handed_in, read_rules(tmp_path / "rules.toml"))
    found = by_name(graded)
    assert graded.points(found["王小明"])[:2] == (13, 13) and graded.mark(found["王小明"]) == 100
    assert graded.points(found["first"])[:2] == (5, 13)
    assert graded.mark(found["absent"]) == 0
    assert "13.0" not in grade_page.to_csv(graded), "points are shown as they were stated"


@pytest.mark.parametrize(
    "text, complaint",
    [
        ("weight = 1", "key 'weight'"),
        ("[points]\n'01-sing' = 1", r"\[points\]: expected an exercise"),
        ("[points]\n'01' = true", "key '01': expected a number"),
        ("[points]\n'01' = -1", "expected a number, 0 or more"),
        ("notebooks = nan", "expected a number"),
        ("students = 'all'", "a list of names"),
        ("expected_workbooks = 0", "above 0"),
        ("=", "TOML"),
    ],
)
def test_bad_rules_are_refused_by_key(tmp_path, text, complaint):
    write(tmp_path / "rules.toml", text)
    with pytest.raises(InputError, match=complaint):
        read_rules(tmp_path / "rules.toml")


class Tags(HTMLParser):
    def __init__(self, page):
        super().__init__()
        self.tags, self.text = set(), []
        self.feed(page)

    def handle_starttag(self, tag, attributes):
        self.tags.add(tag)
        assert not any(name.startswith("on") for name, _ in attributes)

    def handle_data(self, data):
        self.text.append(data)


@pytest.mark.parametrize("language", grade_page.LANGUAGES)
def test_what_students_write_stays_text(tmp_path, language):
    evil = "<img src=x onerror=alert(1)>"
    write(tmp_path / evil / f"{evil}.ipynb", "rubbish")
    write(tmp_path / '=cmd|"calc"!A1' / "a.ipynb", notebook([("01-still", f'"{evil}')], evil))
    graded = grade(tmp_path)
    parsed = Tags(grade_page.to_html(graded, language))
    assert parsed.tags <= set("html meta title style h1 h2 p table tr th td span div ul li".split())
    assert evil in parsed.text
    rows = list(csv.reader(io.StringIO(grade_page.to_csv(graded, language).lstrip("\ufeff"))))
    assert not any(value.startswith(("=", "+", "@")) for row in rows for value in row)


def texts(tree):
    """Every text that a piece of Python holds, {} in place of what is computed."""
    inside = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.JoinedStr):
            inside |= set(node.values)
            yield "".join(part.value if isinstance(part, ast.Constant) else "{}" for part in node.values)
        elif isinstance(node, ast.Constant) and isinstance(node.value, str) and node not in inside:
            yield node.value


def test_every_word_of_the_report_has_its_chinese_and_no_other():
    template = Path(grade_page.__file__).with_suffix(".html").read_text(encoding="utf-8")
    page, program = Environment().parse(template), ast.parse(inspect.getsource(grade_page))
    said = (
        {text.value for text in page.find_all(nodes.Const)}
        | set(texts(program))
        | {RIGHT, WRONG, OPEN, "", FILE, TEXT, CELLS, DUPLICATED, RETYPED}
    )
    words = grade_page.sections()["report"]
    assert words.keys() <= said, "Chinese for what is never said"
    calls = [call for call in page.find_all(nodes.Call) if getattr(call.node, "name", "") in ("say", "section")]
    asked = {text.value for call in calls for text in call.find_all(nodes.Const) if text.value is not None}
    calls = [node for node in ast.walk(program) if getattr(getattr(node, "func", None), "id", "") == "say"]
    asked |= {text for call in calls for argument in call.args for text in texts(argument)}
    asked |= {FILE, TEXT, CELLS, DUPLICATED, RETYPED}
    assert len(asked) > 30 and asked - words.keys() == {"not handed in"} - words.keys()


def with_helpers(complaint):
    """The parsed sources of a complaint and of the functions that it calls to judge."""
    found, todo = {}, [complaint]
    while todo:
        each = todo.pop()
        found[each] = ast.parse(inspect.getsource(each)).body[0]
        names = [part.id for part in ast.walk(found[each]) if isinstance(part, ast.Name)]
        called = [vars(inspect.getmodule(each)).get(name) for name in names]
        course = ("mathpost.teaching.course.exercises", "mathpost.teaching.course.judged_program")
        called = [one for one in called if inspect.isfunction(one) and one.__module__.startswith(course)]
        todo += [one for one in called if one not in found]
    return list(found.values())


def test_every_mixup_of_every_exercise_has_its_chinese_and_no_other():
    for name, each in OURS.items():
        for sentence in [*each.slips, *(said for said, _ in ([] if each.complaint else each.common))]:
            assert grade_page.chinese(name, sentence), f"{name}: {sentence}"
        wanted = set(each.slips)
        if each.complaint:
            body = ast.Module([line for one in with_helpers(each.complaint) for line in one.body[1:]], [])
            wanted |= {text for text in texts(body) if text.endswith((".", "?", ". {}"))}
        own = {key for key in grade_page.sections().get(name, {}) if key.endswith((".", "?", ". {}"))}
        assert own == wanted, f"{name}: {own ^ wanted}"
    assert grade_page.sections().keys() - OURS.keys() == {"report", "any", "detective"}


ENGLISH = re.compile(r"[a-z]{3,}")


@pytest.mark.parametrize(
    ("name", "answer"),
    [
        *(("14-angles", angles) for angles in ((4, 35, 50), (20, 35, 2), (20, 2, 50), (20, 45, 50), (88, 2, 31))),
        *(("03b-choice", present) for present in ((0, -105), (20, -60), (0, 0), (50, 90), (-40, 200))),
        *(("07-lowest", low) for low in (-5, -25, -12, 300)),
        *(("05-meet", axis) for axis in ((0, 0, 1), (1, 0, 1), (0, 0, -1))),
        ("06-limits", (-10, 120)),
        ("07c-pole", (5, 0)),
        ("07c-turn", 0),
        ("06-limits", (5, 0)),
        ("05b-trap", (10, 5, 3)),
        ("11b-gouge", ((10, 5), (12, 0))),
        ("11b-gouge", ((12, 6), (11.8, 5.9))),
        ("05-angles", (-52.397, -24.624)),
        ("05-angles", (52.397, 65.376)),
        ("05-angles", (0.9145, -0.4298)),
        ("05-angles", (-24.624, 52.397)),
        ("01-point", (4.409, 5, 2.357)),
        ("01-point", (-2.357, 5, 4.409)),
    ],
)
def test_what_is_computed_for_an_answer_has_its_chinese(name, answer):
    said = OURS[name].verdict(answer).mixup
    wording = grade_page.chinese(name, said)
    assert wording and not ENGLISH.search(wording.replace("Fanuc", "").replace("Heidenhain", "")), (
        f"{said}: {wording}"
    )


def test_every_phrase_of_the_detectives_has_its_chinese():
    slips = [slip for same in wordings().values() for wording in same for slip in wording.slips]
    slips += [slip for factors in all_factors("ZXZ") for slip in factors.slips]
    slips += [MORE_DIGITS, *causes_of_words(machine_file.load("bc_table"))]
    phrases = {slip.phrase for slip in slips} | {"B and C are of different branches"}
    assert len(phrases) > 90
    pairs = [
        *((phrase, "the final transpose is missing") for phrase in phrases),
        *((p, "γ is left out") for p in phrases),
    ]
    for first, second in pairs:
        for one, other in ((first, second), (second, first)):
            said = f"{one[0].upper()}{one[1:]} and {other} (as KUKA A B C): E_z(−α)·p."
            wording = grade_page.chinese("01-point", said)
            named = re.sub("DEGREES|RADIANS|gon", "", wording)
            assert not ENGLISH.search(named) and named.count("，且") == 1, f"{said}: {wording}"


def test_the_chinese_report_names_mixups_in_chinese_and_says_where_it_cannot(tmp_path):
    (sentence, value), *_ = OURS["01-sign"].mixed_up
    write(tmp_path / "ada" / "a.ipynb", notebook([("01-sign", value)]))
    page = grade_page.to_html(grade(tmp_path), "zh")
    assert sentence not in page and page.count(grade_page.chinese("01-sign", sentence)) == 2, "table and tooltip"
    assert "按原文显示" not in page

    @exercise.define("99-own", Number())
    @exercise.slip("That is the sine: wrong.", 0.5)
    def own():
        """The tangent."""
        return 0.577

    try:
        data = shown(EXERCISES["99-own"].verdict(0.5))
        cells = [cell('exercise.check("99-own", answer)', data)]
        write(tmp_path / "bob" / "a.ipynb", notebook([]) | {"cells": cells})
        page = grade_page.to_html(grade(tmp_path), "zh")
        assert page.count("That is the sine: wrong.") == 2 and "按原文显示" in page
        assert "按原文显示" not in grade_page.to_html(grade(tmp_path), "en")
    finally:
        del EXERCISES["99-own"]


def test_the_command(handed_in, tmp_path, capsys):
    assert main(["grade", str(handed_in), "-o", str(tmp_path / "report.html"), "--language", "zh"]) == 1
    rows = list(csv.DictReader(io.StringIO((tmp_path / "report.csv").read_text("utf-8-sig"))))
    row = next(row for row in rows if row["student_id"] == "王小明")
    assert (row["score"], row["max_score"], row["percent_correct"], row["01-sign"]) == ("5", "5", "100.0", "正确")
    assert "王小明" in (tmp_path / "report.html").read_text("utf-8")
    assert "broken" in capsys.readouterr().err
    assert main(["grade", str(tmp_path / "none"), "-o", str(tmp_path / "r")]) == 2
    (tmp_path / "bare").mkdir()
    assert main(["grade", str(tmp_path / "bare"), "-o", str(tmp_path / "r")]) == 2
