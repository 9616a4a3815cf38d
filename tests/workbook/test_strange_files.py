"""Files that the check of spreadsheets likes less: read, or refused by name; never passed, never a crash."""

import shutil
import subprocess
import zipfile

import numpy as np
import openpyxl
import pytest
from openpyxl.workbook.defined_name import DefinedName

from mathpost.errors import InputError
from mathpost.teaching.workbook import check_file
from mathpost.teaching.workbook.sheet.file import read
from mathpost.teaching.workbook.sheet.graph import Graph
from mathpost.teaching.workbook.sheet.tree import text_of
from mathpost.teaching.workbook.task import task_file
from tests.conftest import DATA
from tests.workbook.test_strangers import SHEETS, workbook

BOOKS = {"right": DATA / "workbooks/right.xlsx", "wrong": DATA / "workbooks/typed_sign.xlsx"}


def verdict(path):
    """The verdict; "refused" if the file is, and then its name must be said."""
    try:
        return check_file(path).verdict
    except InputError as error:
        assert path.name in str(error)
        return "refused"


@pytest.mark.skipif(shutil.which("soffice") is None, reason="LibreOffice is not installed")
@pytest.mark.parametrize(("name", "kind", "ending"), [("right", "ods", "ods"), ("wrong", "xls", "et")])
def test_other_programs_files(tmp_path, name, kind, ending):
    """The .et of WPS is an .xls."""
    shutil.copy(BOOKS[name], tmp_path / f"{name}.xlsx")
    profile = f"-env:UserInstallation=file://{tmp_path}/profile"
    command = ["soffice", "--headless", "--norestore", profile, "--convert-to", kind, "--outdir", str(tmp_path)]
    subprocess.run([*command, str(tmp_path / f"{name}.xlsx")], check=True, capture_output=True)
    path = (tmp_path / f"{name}.{kind}").rename(tmp_path / f"sheet.{ending}")
    assert verdict(path) == name


def test_a_workbook_with_another_ending(tmp_path):
    shutil.copy(BOOKS["wrong"], tmp_path / "wrong.et")
    assert verdict(tmp_path / "wrong.et") in {"wrong", "not judged", "refused"}
    (tmp_path / "text.xlsx").write_text("x;y;z\n1;2;3\n")
    (tmp_path / "empty.xlsx").write_bytes(b"")
    (tmp_path / "picture.xlsx").write_bytes(b"\x89PNG\r\n\x1a\n" + bytes(200))
    for name in ("text", "empty", "picture"):
        assert verdict(tmp_path / f"{name}.xlsx") == "refused"
    assert verdict(tmp_path / "missing.xlsx") == "refused"
    (tmp_path / "folder.xlsx").mkdir()
    assert verdict(tmp_path / "folder.xlsx") == "refused"


def test_damaged_files(tmp_path):
    """Cut off, or with bytes changed at random: refused, or judged as what can still be read."""
    path = tmp_path / "wrong.xlsx"
    shutil.copy(BOOKS["wrong"], path)
    content, rng = path.read_bytes(), np.random.default_rng(0)
    for part in (0.2, 0.6, 0.95):
        path.write_bytes(content[: int(len(content) * part)])
        assert verdict(path) == "refused"
    for _ in range(30):
        spoiled = bytearray(content)
        for place in rng.integers(0, len(content), 3):
            spoiled[place] = rng.integers(256)
        path.write_bytes(bytes(spoiled))
        assert verdict(path) in {"wrong", "not judged", "refused"}


def test_an_encrypted_file(tmp_path):
    path = tmp_path / "secret.xlsx"
    stream = "EncryptedPackage".encode("utf-16-le")
    path.write_bytes(bytes.fromhex("d0cf11e0a1b11ae1") + bytes(504) + stream + bytes(2000))
    with pytest.raises(InputError, match="encrypted"):
        check_file(path)


def parts_of(path):
    with zipfile.ZipFile(path) as archive:
        return {name: archive.read(name).decode() for name in archive.namelist()}


def pack(path, parts):
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in parts.items():
            archive.writestr(name, content)


def test_bombs(tmp_path):
    path = tmp_path / "bomb.xlsx"
    parts = parts_of(BOOKS["right"])
    pack(path, {**parts, "xl/sharedStrings.xml": "<sst>" + "<si><t>a</t></si>" * 4_000_000 + "</sst>"})
    assert verdict(path) == "refused"
    pack(path, {**parts, **{f"xl/media/{n}.xml": "" for n in range(5000)}})
    assert verdict(path) == "refused"
    sheet = "xl/worksheets/sheet1.xml"
    entities = '<!DOCTYPE a [<!ENTITY b "bb"><!ENTITY c "&b;&b;&b;&b;">]>'
    pack(path, {**parts, sheet: parts[sheet].replace("<worksheet", entities + "<worksheet", 1)})
    assert verdict(path) == "refused"


HOSTILE = {
    "web service": 'WEBSERVICE("http://localhost/x")',
    "in a function": 'IF(C2>0,_xlfn.WEBSERVICE("http://localhost/x"),1)',
    "small letters": 'webservice("http://localhost/x")',
    "dynamic data exchange": "cmd|'/c calc'!A1",
    "dde function": 'DDE("soffice","file","A1")',
    "external link": "'[other.xlsx]Sheet1'!A1",
}


@pytest.mark.parametrize("kind", HOSTILE)
@pytest.mark.parametrize("place", ["cell", "far column", "name"])
def test_formulas_that_reach_out_are_refused(tmp_path, kind, place):
    path = tmp_path / "hostile.xlsx"
    parts = parts_of(BOOKS["right"])
    formula = HOSTILE[kind].replace("&", "&amp;").replace(">", "&gt;")
    if place == "name":
        name = f'<definedNames><definedName name="helper">{formula}</definedName></definedNames>'
        parts["xl/workbook.xml"] = parts["xl/workbook.xml"].replace("</workbook>", name + "</workbook>")
    else:
        column = "XFA" if place == "far column" else "Q"
        row = f'<row r="1000"><c r="{column}1000"><f>{formula}</f><v>1</v></c></row>'
        sheet = "xl/worksheets/sheet1.xml"
        parts[sheet] = parts[sheet].replace("</sheetData>", row + "</sheetData>")
    pack(path, parts)
    assert verdict(path) == "refused"


def test_macros_links_and_queries_are_refused(tmp_path):
    path = tmp_path / "hostile.xlsx"
    parts = parts_of(BOOKS["right"])
    for name in (
        "vbaProject.bin",
        "externalLinks/externalLink1.xml",
        "connections.xml",
        "embeddings/oleObject1.bin",
    ):
        pack(path, {**parts, f"xl/{name}": "x"})
        assert verdict(path) == "refused"


# Values without formulas.


@pytest.mark.parametrize("written", ["half", "Sheet!half", "'Sheet'!half"])
def test_a_named_constant_may_be_written_with_its_sheet(tmp_path, written):
    book = openpyxl.Workbook()
    book.defined_names["half"] = DefinedName("half", attr_text="0.5")
    book.active["A1"], book.active["B1"] = 30, f"={written}*A1"
    book.save(tmp_path / "constant.xlsx")
    graph = Graph(read(tmp_path / "constant.xlsx"))
    assert text_of(graph.tree(("Sheet", 1, 2))) == "0.5*A1"
    assert check_file(tmp_path / "constant.xlsx").status == 2  # there is nothing to judge


# Errors, and texts where numbers are asked for.


@pytest.mark.parametrize(
    ("cells", "place"),
    [
        ({"B26": "=AVERAGE(A3:A5)"}, "B26"),
        ({"G20": "12.5", "G21": "3.25", "G22": "1.75", "B26": "=AVERAGE(G20:G22)"}, "B26"),
        ({"B26": "=STDEV(A3)"}, "B26"),
        ({"B26": "=E3/0"}, "B26"),
        ({"B26": "=SQRT(SUMSQ(E20:E22))/(E3-10)"}, "B26"),  # only at the sheet's own point
        ({"B26": "#REF!"}, "B26"),
        ({"B26": "=#REF!+E20"}, "B26"),
        ({"B26": "#VALUE!"}, "B26"),
        ({"B26": "=A3*2"}, "B26"),
        ({"B26": '=IF(B24<2,1/0,"fine")'}, "B26"),
        ({"E3": 0, "E4": 0, "E5": 0, "B26": "=SQRT(SUMSQ(E20:E22))", "C26": "=E20/B26"}, "C26"),
    ],
)
def test_an_error_is_never_right(cells, place, tmp_path):
    sheet = SHEETS["u001"]
    page = sheet["sheets"]["Sheet1"] | {"A26": "mean"} | cells
    workbook(sheet | {"sheets": {"Sheet1": page}}).save(tmp_path / "error.xlsx")
    report = check_file(tmp_path / "error.xlsx")
    judged = {cell.cell: cell.status for cell in report.cells}
    assert report.verdict != "right" and judged[f"Sheet1!{place}"] in ("not judged", "wrong")


@pytest.mark.parametrize("name", ["/etc/passwd", "../machine.toml", "sub/machine.toml", "machine.txt", "none.toml"])
def test_a_task_opens_no_machine_but_one_beside_it(name, tmp_path):
    for place in (tmp_path / "machine.txt", tmp_path.parent / "machine.toml"):
        place.write_text("secret", encoding="utf-8")
    (tmp_path / "task.toml").write_text(f'kind = "nc"\nmachine = "{name}"\n', encoding="utf-8")
    with pytest.raises(InputError, match=r"task\.toml, machine: expected ") as error:
        task_file(tmp_path / "task.toml")
    assert "secret" not in str(error.value)
