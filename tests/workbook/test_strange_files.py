"""Files that the check of spreadsheets likes less: read, or refused by name; never passed, never a crash."""

import shutil
import subprocess
import zipfile

import numpy as np
import openpyxl
import pytest
from openpyxl.workbook.defined_name import DefinedName
from scipy.spatial.transform import Rotation

from mathpost.errors import InputError
from mathpost.workbook import check_file
from mathpost.workbook.sheet.file import read
from mathpost.workbook.sheet.graph import Graph
from mathpost.workbook.sheet.tree import text_of
from mathpost.workbook.task import task_file
from tests.workbook import layouts
from tests.workbook.cells import Values, formula_of, save
from tests.workbook.test_strangers import SHEETS, workbook

TURNS = ("alpha", "beta", "gamma")


@pytest.fixture(scope="module")
def books():
    """The source's sheet, and the same with a sign lost in an element."""
    book = layouts.source_sheet()
    key = next(key for key in book.formulas() if book.cells[key].startswith("=-"))
    spoiled = layouts.source_sheet()
    spoiled.cells[key] = "=" + book.cells[key][2:]
    return {"right": book, "wrong": spoiled}


def verdict(path):
    """The verdict; "refused" if the file is, and then its name must be said."""
    try:
        return check_file(path).verdict
    except InputError as error:
        assert path.name in str(error)
        return "refused"


def write_csv(path, book, separator, comma):
    values = Values(book).all()
    rows = max(key[1] for key in values)
    lines = []
    for row in range(1, rows + 1):
        cells = [values.get((book.sheets()[0], row, column)) for column in range(1, 8)]
        texts = ["" if v is None else v if isinstance(v, str) else f"{v[0]:.6f}" for v in cells]
        lines.append(separator.join(text.replace(".", ",") if comma else text for text in texts))
    path.write_text("\n".join(lines), encoding="utf-8")


@pytest.mark.parametrize(("separator", "comma"), [(",", False), (";", True), ("\t", False)])
def test_csv(books, tmp_path, separator, comma):
    for name, allowed in (("right", {"right", "unclear", "refused"}), ("wrong", {"wrong", "unclear", "refused"})):
        write_csv(tmp_path / f"{name}.csv", books[name], separator, comma)
        assert verdict(tmp_path / f"{name}.csv") in allowed


@pytest.mark.skipif(shutil.which("soffice") is None, reason="LibreOffice is not installed")
@pytest.mark.parametrize(("name", "kind", "ending"), [("right", "ods", "ods"), ("wrong", "xls", "et")])
def test_other_programs_files(books, tmp_path, name, kind, ending):
    """The .et of WPS is an .xls."""
    save(tmp_path / f"{name}.xlsx", books[name])
    profile = f"-env:UserInstallation=file://{tmp_path}/profile"
    command = ["soffice", "--headless", "--norestore", profile, "--convert-to", kind, "--outdir", str(tmp_path)]
    subprocess.run([*command, str(tmp_path / f"{name}.xlsx")], check=True, capture_output=True)
    path = (tmp_path / f"{name}.{kind}").rename(tmp_path / f"sheet.{ending}")
    assert verdict(path) == name


def test_a_workbook_with_another_ending(books, tmp_path):
    save(tmp_path / "wrong.et", books["wrong"])
    assert verdict(tmp_path / "wrong.et") in {"wrong", "unclear", "refused"}
    (tmp_path / "text.xlsx").write_text("x;y;z\n1;2;3\n")
    (tmp_path / "empty.xlsx").write_bytes(b"")
    (tmp_path / "picture.xlsx").write_bytes(b"\x89PNG\r\n\x1a\n" + bytes(200))
    for name in ("text", "empty", "picture"):
        assert verdict(tmp_path / f"{name}.xlsx") == "refused"
    assert verdict(tmp_path / "missing.xlsx") == "refused"
    (tmp_path / "folder.xlsx").mkdir()
    assert verdict(tmp_path / "folder.xlsx") == "refused"


def test_damaged_files(books, tmp_path):
    """Cut off, or with bytes changed at random: refused, or judged as what can still be read."""
    path = tmp_path / "wrong.xlsx"
    save(path, books["wrong"])
    content, rng = path.read_bytes(), np.random.default_rng(0)
    for part in (0.2, 0.6, 0.95):
        path.write_bytes(content[: int(len(content) * part)])
        assert verdict(path) == "refused"
    for _ in range(30):
        spoiled = bytearray(content)
        for place in rng.integers(0, len(content), 3):
            spoiled[place] = rng.integers(256)
        path.write_bytes(bytes(spoiled))
        assert verdict(path) in {"wrong", "unclear", "refused"}


def test_an_encrypted_file(tmp_path):
    path = tmp_path / "secret.xlsx"
    stream = "EncryptedPackage".encode("utf-16-le")
    path.write_bytes(bytes.fromhex("d0cf11e0a1b11ae1") + bytes(504) + stream + bytes(2000))
    with pytest.raises(InputError, match="encrypted"):
        check_file(path)


def parts_of(path, book):
    save(path, book)
    with zipfile.ZipFile(path) as archive:
        return {name: archive.read(name).decode() for name in archive.namelist()}


def pack(path, parts):
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in parts.items():
            archive.writestr(name, content)


def test_bombs(books, tmp_path):
    path = tmp_path / "bomb.xlsx"
    parts = parts_of(path, books["right"])
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
def test_formulas_that_reach_out_are_refused(books, tmp_path, kind, place):
    path = tmp_path / "hostile.xlsx"
    parts = parts_of(path, books["right"])
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


def test_macros_links_and_queries_are_refused(books, tmp_path):
    path = tmp_path / "hostile.xlsx"
    parts = parts_of(path, books["right"])
    for name in (
        "vbaProject.bin",
        "externalLinks/externalLink1.xml",
        "connections.xml",
        "embeddings/oleObject1.bin",
    ):
        pack(path, {**parts, f"xl/{name}": "x"})
        assert verdict(path) == "refused"


# Values without formulas.


def without_formulas(book, spoil=None):
    """The book as values; angles as texts such as "54,7356" and "54.7356°"."""
    values = Values(book).all()
    if spoil:
        values[spoil] = values[spoil] + 0.01
    cells = {key: value if isinstance(value, str) else round(float(value[0]), 6) for key, value in values.items()}
    return layouts.Book(cells)


@pytest.mark.parametrize("text", ["{}", "{}°", "comma"])
def test_sheets_of_values(books, tmp_path, text):
    """Lucky values cannot be excluded there: it is said."""
    path = tmp_path / "values.xlsx"
    for spoil in (None, *books["right"].truths[-1][0]):
        book = without_formulas(books["right"], spoil)
        for key in books["right"].inputs[0][0]:
            number = str(book.cells[key])
            if text != "{}":
                book.cells[key] = number.replace(".", ",") if text == "comma" else text.format(number)
        save(path, book)
        assert not any(formula_of(content) for content in book.cells.values())
        report = check_file(path)
        if spoil is None:
            assert report.beside and report.warnings  # matrices are not judged
        else:
            assert report.verdict == "wrong" and report.faults[0].cell.split("!")[1] == f"C{spoil[1]}"


@pytest.mark.parametrize("wrong", [None, "y_new"])
def test_numbers_that_only_names_of_the_workbook_tell(tmp_path, wrong):
    """Without formulas and labels."""
    angles, point = (20, 70, 50), (3, 4, 5)

    def turn(axis, angle):
        return Rotation.from_euler(axis, -angle, degrees=True).as_matrix()

    single = {name: turn(axis, a) for name, axis, a in zip(TURNS, "ZXZ", angles, strict=True)}
    whole = single["gamma"] @ single["beta"] @ single["alpha"]
    named = {f"angle_{name}": angle for name, angle in zip(TURNS, angles, strict=True)}
    named |= dict(zip("xyz", point, strict=True)) | single | {"matrix_gamma_beta_alpha": whole}
    named |= dict(zip(("x_new", "y_new", "z_new"), whole @ point, strict=True))
    book = openpyxl.Workbook()
    for number, (name, value) in enumerate(named.items()):
        numbers, top = np.array(value, dtype=float, ndmin=2), 5 * number + 1
        numbers[-1, -1] += 0.01 * (name == wrong)
        size = len(numbers)
        for row, column in np.ndindex(size, size):
            book.active.cell(top + row, 2 + column, numbers[row, column])
        area = f"Sheet!$B${top}" + f":$D${top + 2}" * (size > 1)
        book.defined_names[name] = DefinedName(name, attr_text=area)
        if name == wrong:
            cell = f"Sheet!{'BD'[size > 1]}{top + size - 1}"
    book.save(tmp_path / "named.xlsx")
    report = check_file(tmp_path / "named.xlsx")
    assert report.beside if wrong is None else report.faults[0].cell == cell


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
    assert report.verdict != "right" and judged[f"Sheet1!{place}"] in ("unclear", "wrong")


@pytest.mark.parametrize("name", ["/etc/passwd", "../machine.toml", "sub/machine.toml", "machine.txt", "none.toml"])
def test_a_task_opens_no_machine_but_one_beside_it(name, tmp_path):
    for place in (tmp_path / "machine.txt", tmp_path.parent / "machine.toml"):
        place.write_text("secret", encoding="utf-8")
    (tmp_path / "task.toml").write_text(f'kind = "nc"\nmachine = "{name}"\n', encoding="utf-8")
    with pytest.raises(InputError, match=r"task\.toml, machine: expected ") as error:
        task_file(tmp_path / "task.toml")
    assert "secret" not in str(error.value)
