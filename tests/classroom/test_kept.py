"""A class that is graded again and again: only new files are judged, and records are nobody's but the teacher's."""

import os
import shutil
import sqlite3

import pytest

from mathpost.errors import InputError, OutputError
from mathpost.interface.shell.main import main
from mathpost.teaching.classroom import grade_page, judged, kept
from mathpost.teaching.classroom.grade import grade
from mathpost.teaching.classroom.kept import Kept
from mathpost.teaching.course.verdict import RIGHT, WRONG
from tests.classroom.test_grade import notebook, solved, write
from tests.conftest import DATA

posix = pytest.mark.skipif(os.name != "posix", reason="accounts and modes are those of Linux and macOS")


@pytest.fixture
def folder(tmp_path):
    """Six students, each with a notebook of their own and two with workbooks."""
    for number in range(6):
        answers = [*solved(["01-sign"]), ("01-still", f"guess {number}")]
        write(tmp_path / f"in/student {number}/a.ipynb", notebook(answers, f"# {number}"))
    shutil.copy(DATA / "workbooks/typed_sign.xlsx", tmp_path / "in/student 0/sheet.xlsx")
    book = (DATA / "workbooks/typed_sign.xlsx").read_bytes() + b"\0"
    (tmp_path / "in/student 1/sheet.xlsx").write_bytes(book)
    return tmp_path / "in"


@pytest.fixture
def looked_at(monkeypatch):
    """Names of the files that were judged, not taken from a record."""
    names = []
    for kind in ("notebook", "workbook"):
        real = getattr(judged, kind)
        monkeypatch.setattr(
            judged, kind, lambda path, *more, real=real: (names.append(path.parent.name), real(path, *more))[1]
        )
    return names


def report(folder, file):
    records = Kept(file)
    graded = grade(folder, kept=records)
    return grade_page.to_csv(graded) + grade_page.to_html(graded)


def test_the_second_report_is_the_first_and_only_what_is_new_is_judged(folder, tmp_path, looked_at):
    first = report(folder, tmp_path / "kept")
    assert len(looked_at) >= 7
    looked_at.clear()
    assert report(folder, tmp_path / "kept") == first and not looked_at
    write(folder / "student 3/a.ipynb", notebook([("01-sign", [9, 9, 9])]))
    second = report(folder, tmp_path / "kept")
    assert looked_at == ["student 3"] and second != first
    assert second == report(folder, None)


def test_another_edition_of_what_judges_judges_anew(folder, tmp_path, looked_at, monkeypatch):
    report(folder, tmp_path / "kept")
    looked_at.clear()
    monkeypatch.setattr(kept, "edition", lambda: "another")
    report(folder, tmp_path / "kept")
    assert len(looked_at) >= 7
    assert {row[0] for row in sqlite3.connect(tmp_path / "kept").execute("SELECT edition FROM kept")} == {"another"}


def test_the_edition_is_that_of_every_file_that_judges(monkeypatch, tmp_path):
    before = kept.edition.__wrapped__()
    shutil.copytree(DATA, tmp_path / "data")
    monkeypatch.setattr(kept, "data_file", lambda _: tmp_path / "data/machines")
    assert kept.edition.__wrapped__() == before
    with (tmp_path / "data/machines/dmu50v.toml").open("a", encoding="utf-8") as file:
        file.write("#")
    assert kept.edition.__wrapped__() != before


@pytest.mark.parametrize(
    "record", ["", "[]", '{"verdicts": 3}', '{"cells": [], "given": [], "verdicts": [{}]}', "x"]
)
def test_a_record_that_is_not_whole_counts_as_none(record, folder, tmp_path):
    first = report(folder, tmp_path / "kept")
    with sqlite3.connect(tmp_path / "kept") as database:
        database.execute("UPDATE kept SET record = ?", (record,))
    assert report(folder, tmp_path / "kept") == first


@posix
@pytest.mark.parametrize("how", ["a link", "of somebody else", "written by others", "no records", "no folder"])
def test_records_of_others_are_refused(how, folder, tmp_path):
    path = tmp_path / "kept"
    report(folder, path)
    if how == "a link":
        path.rename(tmp_path / "other")
        path.symlink_to(tmp_path / "other")
    elif how == "of somebody else":
        if os.getuid():
            pytest.skip("does not apply: only root may give a file away")
        os.chown(path, 12345, 12345)
    elif how == "written by others":
        path.chmod(0o666)
    elif how == "no records":
        path.write_text("something else that is long enough to be read as a page", encoding="utf-8")
    else:
        path = tmp_path / "none" / "kept"
    with pytest.raises((InputError, OutputError), match="kept"):
        Kept(path)


def test_what_a_student_calls_a_record_is_none(folder, tmp_path, capsys):
    """A forged file among what was handed in, even where the report is to stand."""
    report(folder, tmp_path / "kept")
    with sqlite3.connect(tmp_path / "kept") as database:
        rows = database.execute("SELECT key, record FROM kept").fetchall()
        for key, record in rows:
            database.execute("UPDATE kept SET record = ? WHERE key = ?", (record.replace(WRONG, RIGHT), key))
    shutil.copy(tmp_path / "kept", folder / "report.judged")
    assert main(["grade", str(folder), "-o", str(folder / "report")]) == 0
    assert "Nothing was kept" in capsys.readouterr().err
    assert WRONG in (folder / "report.csv").read_text(encoding="utf-8")


def test_the_bound_of_answers_holds_with_records_too(tmp_path, monkeypatch):
    monkeypatch.setattr(judged, "MOST_DIFFERENT", 1)
    for number in range(2):
        write(tmp_path / f"in/eve/{number}.ipynb", notebook([("01-sign", [number, 0, 0])]))
        write(tmp_path / f"in/{number}/{number}.ipynb", notebook([("01-sign", [number, 0, 0])]))
    said = [grade(tmp_path / "in", kept=Kept(tmp_path / "kept")).results[-1].trouble for _ in range(2)]
    assert said[0] == said[1] == [("1.ipynb", "not judged: too large (2 different answers to 01-sign)")]
