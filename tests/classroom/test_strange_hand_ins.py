"""Hand-ins that nobody foresaw: one student, one line, and the report of the class always comes."""

import csv
import io
import os
import struct
import zipfile

import pytest

from mathpost.errors import INTERNAL
from mathpost.interface.shell.main import main
from mathpost.teaching.classroom import judged
from mathpost.teaching.classroom.grade import grade
from mathpost.teaching.course.verdict import RIGHT
from tests.classroom.test_grade import by_name, notebook, solved, write

GBK = "王小明".encode("gbk")


def packed(compression=zipfile.ZIP_STORED, name="a.ipynb"):
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w", compression) as archive:
        archive.writestr(name, "text " * 400)
    return bytearray(content.getvalue())


def claims_utf_8():
    """A zip that says its name is UTF-8, in both of its places, and it is not."""
    content = packed(name="abcdef.ipynb").replace(b"abcdef", GBK)
    for start, place in ((b"PK\x03\x04", 6), (b"PK\x01\x02", 8)):
        struct.pack_into("<H", content, content.index(start) + place, 0x800)
    return bytes(content)


def damaged(compression):
    content = packed(compression)
    for place in range(60, 80):
        content[place] ^= 0xFF
    return bytes(content)


ZIPS = {
    "a name that is not UTF-8": claims_utf_8,
    "damaged, deflate": lambda: damaged(zipfile.ZIP_DEFLATED),
    "damaged, LZMA": lambda: damaged(zipfile.ZIP_LZMA),
    "damaged, bzip2": lambda: damaged(zipfile.ZIP_BZIP2),
    "an unknown compression": lambda: bytes(packed()).replace(
        b"\x14\x00\x00\x00\x00\x00", b"\x14\x00\x00\x00\x63\x00"
    ),
    "cut off": lambda: bytes(packed()[:-30]),
    "nothing": lambda: b"",
}


@pytest.mark.parametrize("zipped", ZIPS)
def test_a_zip_that_cannot_be_unpacked_is_a_line_of_its_student(zipped, tmp_path, capsys):
    write(tmp_path / "in/ada/a.ipynb", notebook(solved(["01-sign"])))
    (tmp_path / "in/eve.zip").write_bytes(ZIPS[zipped]())
    assert main(["grade", str(tmp_path / "in"), "-o", str(tmp_path / "report")]) == 1
    assert "eve: eve.zip: expected a zip that can be unpacked" in capsys.readouterr().err
    rows = list(csv.DictReader((tmp_path / "report.csv").read_text(encoding="utf-8-sig").splitlines()))
    assert [row["student_id"] for row in rows] == ["ada", "eve"]


@pytest.mark.skipif(os.name != "posix", reason="names of files are bytes on Linux")
def test_names_that_are_not_utf_8_or_of_two_lines_are_escaped(tmp_path, capfd):
    """The report and the lines on the terminal, as the table of a folder of workbooks."""
    for name in (GBK, b"two\nlines"):
        folder = os.fsencode(tmp_path) + b"/in/" + name
        os.makedirs(folder)
        with open(folder + b"/" + name + b".ipynb", "wb") as file:
            file.write(b"no notebook")
        with open(folder + b"/" + name + b".xlsx", "wb") as file:
            file.write(b"no workbook")
    assert main(["grade", str(tmp_path / "in"), "-o", str(tmp_path / "report")]) == 1
    said = capfd.readouterr().err
    assert "two\\nlines: two\\nlines.ipynb: " in said and r"\udccd" in said
    assert r"two\nlines" in (tmp_path / "report.csv").read_text(encoding="utf-8")
    assert main(["check", str(tmp_path / "in"), "--csv", str(tmp_path / "table.csv")]) == 2
    table = (tmp_path / "table.csv").read_text(encoding="utf-8")
    assert r"two\nlines/two\nlines.xlsx,not read" in table and r"\udccd" in table


def test_an_error_that_nobody_foresaw_is_said_and_ends_nothing(tmp_path, monkeypatch, capsys):
    for name in ("ada", "eve"):
        write(tmp_path / f"in/{name}/a.ipynb", notebook(solved(["01-sign"])))
    (tmp_path / "in/eve/a.ipynb").write_text("{}", encoding="utf-8")
    whole = judged.notebook

    def fails(path, tried):
        if path.parent.name == "eve":
            raise AssertionError("two\nlines")
        return whole(path, tried)

    monkeypatch.setattr(judged, "notebook", fails)
    found = by_name(grade(tmp_path / "in"))
    assert found["ada"].status("01-sign") == RIGHT
    ((name, why),) = found["eve"].trouble
    assert name == "a.ipynb" and why.startswith(rf"{INTERNAL}: AssertionError: two\nlines (")
    assert main(["grade", str(tmp_path / "in"), "-o", str(tmp_path / "report")]) == 2
    assert "ada" in (tmp_path / "report.csv").read_text(encoding="utf-8")
