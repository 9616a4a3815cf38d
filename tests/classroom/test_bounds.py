"""Hand-ins that are too large: said with the figure, while the class goes on; and cells that were retyped."""

import csv
import io
import json
import sys

import pytest

from mathpost.teaching.bounds import TooLarge, bounded
from mathpost.teaching.classroom import grade_page, handed_in, judged
from mathpost.teaching.classroom.grade import DUPLICATED, RETYPED, grade
from mathpost.teaching.course.verdict import RIGHT
from mathpost.teaching.workbook import check as checks
from mathpost.teaching.workbook import check_folder
from mathpost.teaching.workbook import folder as workbooks
from tests.classroom.test_grade import LESSON, by_name, cell, notebook, packed, solved, write
from tests.conftest import ROOT
from tests.workbook.test_strangers import SHEETS, workbook

CHECK = 'exercise.check("01-point", answer)'


def wrong(count):
    """A notebook with different wrong answers to an exercise that takes long to judge each."""
    data = {"text/plain": "01-point · not yet."}
    stored = [data | {"application/vnd.mathpost+json": {"answer": [1, 2, n + 0.5]}} for n in range(count)]
    outputs = [{"output_type": "display_data", "metadata": {}, "data": each} for each in stored]
    return {"cells": [cell(CHECK, *outputs)], "metadata": {}, "nbformat": 4, "nbformat_minor": 5}


LARGE = {
    "800 different answers to 01-point": lambda: wrong(800),
    "80000 stored answers": lambda: {"cells": [cell(CHECK, *wrong(1)["cells"][0]["outputs"] * 80_000)]},
    "100001 cells": lambda: {"cells": [cell("x = 1")] * 100_001},
    "an answer of 100002 characters": lambda: {
        "cells": [cell(CHECK, shown_as("01-point", "x" * 100_000))],
    },
    "17 MB": lambda: {"cells": [cell("x" * 17 * 2**20)]},
}


def shown_as(name, answer):
    data = {"text/plain": f"{name} · right.", "application/vnd.mathpost+json": {"answer": answer}}
    return {"output_type": "display_data", "metadata": {}, "data": data}


@pytest.mark.parametrize("figure", LARGE)
def test_a_notebook_that_is_too_large_is_unclear_with_the_figure(figure, tmp_path):
    write(tmp_path / "eve" / "a.ipynb", LARGE[figure]())
    write(tmp_path / "ada" / "a.ipynb", notebook(solved(["01-sign"])))
    found = by_name(grade(tmp_path))
    assert found["eve"].trouble == [("a.ipynb", f"not judged: too large ({figure})")] and not found["eve"].verdicts
    assert found["ada"].status("01-sign") == RIGHT and not found["ada"].trouble


def test_many_notebooks_of_a_student_are_counted_together(tmp_path, monkeypatch):
    monkeypatch.setattr(judged, "MOST_DIFFERENT", 2)
    pages = [("01-sign", [value, 0, 0]) for value in (1, 2, 3)]
    for number, answer in enumerate(pages):
        write(tmp_path / "eve" / f"{number}.ipynb", notebook([answer]))
    write(tmp_path / "eve" / "9.ipynb", notebook([("01-still", "x")]))
    (eve,) = grade(tmp_path).results
    assert eve.trouble == [("2.ipynb", "not judged: too large (3 different answers to 01-sign)")]
    assert eve.status("01-still") and eve.notebooks == 3


def test_many_files_deep_folders_and_zips_that_are_large_together(tmp_path, monkeypatch):
    monkeypatch.setattr(handed_in, "STUDENT_LIMIT", 3)
    monkeypatch.setattr(handed_in, "ZIP_LIMIT", 3_000_000)
    for number in range(5):
        write(tmp_path / "in/many" / f"{number}.ipynb", notebook(solved(["01-sign"])))
    write(tmp_path.joinpath("in/deep", *["d"] * 60) / "a.ipynb", notebook(solved(["01-sign"])))
    for number in range(3):
        packed(tmp_path / f"in/zips/{number}.zip", (f"{number}.txt", bytes(1_400_000)))
    found = {each.name: each for each in handed_in.collect(tmp_path / "in", tmp_path / "unpacked")}
    assert found["many"].refused == [("", "only the first 3 of 5 files were read")]
    assert "at most 40 folders in each other" in found["deep"].refused[0][1] and not found["deep"].notebooks
    assert [name for name, _ in found["zips"].refused] == ["zips/2.zip"]


@pytest.mark.skipif(sys.platform != "linux", reason="the bound of memory is Linux's")
@pytest.mark.parametrize("bound", ["time", "memory"])
def test_what_no_count_foresees_is_bounded_too(bound, tmp_path, monkeypatch):
    def endless(path, task):
        if path.name != "eve.xlsx":
            return judged_before
        held = []
        while True:
            held += [bytes(2**24)] if bound == "memory" else []

    for name, sheet in (("ada", "u001"), ("eve", "u002")):
        workbook(SHEETS[sheet]).save(tmp_path / f"{name}.xlsx")
    judged_before = checks.check_file(tmp_path / "ada.xlsx")  # however long a slow machine takes
    monkeypatch.setattr(checks, "_checked", endless)
    monkeypatch.setattr(checks, "bounded", lambda: bounded(0.3 if bound == "time" else 60, 2**28))
    ada, eve = check_folder(tmp_path).rows
    figure = {"time": "more than 0.3 s", "memory": "more than 0.25 GB of memory"}[bound]
    assert (ada[1], eve[1], eve[5]) == ("right", "not judged", f"not judged: too large ({figure})")
    (result,) = [each for each in grade(tmp_path).results if each.name == "eve"]
    assert result.trouble == [("eve.xlsx", f"not judged: too large ({figure})")]
    bytes(2**29)  # the bounds end with the work


@pytest.mark.skipif(sys.platform != "linux", reason="the bound of time is that of Linux and macOS")
def test_of_two_bounds_the_earlier_one_holds():
    with pytest.raises(TooLarge, match=r"more than 0\.2 s"), bounded(0.2), bounded(60):
        while True:
            pass
    with pytest.raises(TooLarge, match=r"more than 0\.4 s"), bounded(0.4):
        with pytest.raises(TooLarge, match=r"more than 0\.1 s"), bounded(0.1):
            while True:
                pass
        while True:
            pass


def test_a_copy_that_cannot_be_marked_ends_nothing(tmp_path, monkeypatch):
    monkeypatch.setattr(workbooks, "MARKED_LIMIT", 10)
    for name in ("ada", "bob"):
        workbook(SHEETS["u001"]).save(tmp_path / f"{name}.xlsx")
    rows = check_folder(tmp_path, marked=tmp_path / "marked").rows
    assert [row[1] for row in rows] == ["right", "right"] and all("not marked" in row[5] for row in rows)


@pytest.mark.parametrize("language", grade_page.LANGUAGES)
def test_a_check_that_was_retyped_or_duplicated_is_said(language, tmp_path):
    lesson = json.loads((ROOT / f"notebooks/{LESSON}.ipynb").read_text(encoding="utf-8"))
    name = "01-sign"
    (number,) = [n for n, each in enumerate(lesson["cells"]) if f'check("{name}"' in "".join(each["source"])]
    answered = dict(solved([name]))[name]
    ours = lesson["cells"][number] | {"outputs": notebook([(name, answered)])["cells"][0]["outputs"]}
    for student, cells in {
        "ada": [ours],
        "dan": [ours, ours],
        "eve": [ours | {"source": f'exercise.check("{name}", [4, -3, 5])'}],
    }.items():
        changed = [*lesson["cells"][:number], *cells, *lesson["cells"][number + 1 :]]
        write(tmp_path / student / "a.ipynb", lesson | {"cells": json.loads(json.dumps(changed))})
    graded = grade(tmp_path)
    changed = {each.name: each.changed for each in graded.results}
    assert changed == {"ada": [], "dan": [("a.ipynb", name, DUPLICATED)], "eve": [("a.ipynb", name, RETYPED)]}
    assert all(each.status(name) == RIGHT for each in graded.results), "it counts all the same"
    rows = list(csv.DictReader(io.StringIO(grade_page.to_csv(graded, language).lstrip("\ufeff"))))
    said = {row["student_id"]: row["trouble"] for row in rows}
    twice, retyped = (f"{name}: {grade_page.say(language, what)}" for what in (DUPLICATED, RETYPED))
    assert said == {"ada": "", "dan": twice, "eve": retyped}
    assert grade_page.to_html(graded, language).count(retyped.partition(": ")[2]) == 1
