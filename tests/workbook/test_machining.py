"""Tables of NC words, tilted planes and plain numbers, laid out as strangers do."""

import re

import numpy as np
import openpyxl
import pytest
from scipy.spatial.transform import Rotation

from mathpost import load_machine
from mathpost.errors import InputError
from mathpost.kinematics import Kinematics
from mathpost.teaching.workbook import Task, check_file
from mathpost.teaching.workbook.sheet.formula import parse
from tests.workbook.cells import Book, Values, address, letters, save
from tests.workbook.machining_sheets import MACHINES, PLANES, TABLES, first_in_file, forward, order_of
from tests.workbook.test_strangers import ROOT

ROWS = 5
UNIT = {n: f"({{{n}}}/SQRT({{i}}^2+{{j}}^2+{{k}}^2))" for n in "ijk"}


def in_rows(n, k):
    return "S", n + 3, k + 2


def in_columns(n, k):
    return "S", k + 3, n + 2


def with_gaps(n, k):
    return "S", n + 3, 1 + k + (k >= 3) + (k >= 6)


def words_first(n, k):
    return "S", n + 3, 40 - k


def on_two_sheets(n, k):
    return ("CL", n + 2, k + 1) if k < 6 else ("NC", n + 4, k - 4)


LAYOUTS = {
    "points in columns": ("bc_table", in_columns, "xyzijk", "{}", 1),
    "blank columns": ("head_b_table_c", with_gaps, "xyzijk", "{}", 1),
    "from right to left": ("ac_head", words_first, "xyzijk", "{}", 1),
    "two sheets": ("dmu50v", on_two_sheets, "xyzijk", "{}", 1),
    "rounded": ("ac_table", in_rows, "xyzijk", "ROUND({},3)", 1),
    "from 0 to 360": ("bc_table", in_rows, "xyzijk", "ROUND(MOD({},360),4)", 1),
    "normals of any length": ("ac_head", in_rows, ["Px", "Py", "Pz", "Nx", "Ny", "Nz"], "{}", 2.5),
}


def table(layout):
    """The cells of a table of NC words, and of each row the places of its words."""
    name, place, headings, form, length = LAYOUTS[layout]
    constants, angles, helpers, words = TABLES[name]
    turns = order_of(name, angles, np.linspace(20, 40, ROWS), np.linspace(-30, 60, ROWS))
    rng = np.random.default_rng(7)
    cl = forward(name, rng.uniform(-40, 40, (3, ROWS)), turns)
    cl[3:] *= length
    names = [*angles, *helpers, *words]
    rows = []
    cells = {place(-1, k): text for k, text in enumerate([*headings, *names])}
    for n in range(ROWS):
        found = {place(n, k): round(float(cl[k, n]), 5) for k in range(6)}
        refs = {letter: address(place(n, k)) for k, letter in enumerate("xyzijk")}
        units = {letter: UNIT[letter].format(**refs) for letter in "ijk"} if length != 1 else {}
        refs |= units | {key: str(value) for key, value in constants.items()}
        refs |= {word: address(place(n, 6 + k)) for k, word in enumerate(names)}
        for k, (word, formula) in enumerate((*angles.items(), *helpers.items(), *words.items())):
            turned = form if word in angles else form.replace("MOD({},360)", "{}")
            text = formula.format(**refs)[1:]
            found[place(n, 6 + k)] = f"={text}" if word in helpers else f"={turned.format(text)}"
        cells |= found
        rows.append({word: place(n, 6 + k) for k, word in enumerate(names)})
    return cells, rows, Task(machine=MACHINES / f"{name}.toml")


def checked(path, cells, task=None):
    book = Book(cells)
    save(path, book, Values(book).all())
    return check_file(path, task)


@pytest.mark.parametrize("layout", LAYOUTS)
def test_a_table_in_any_layout(layout, tmp_path):
    cells, rows, task = table(layout)
    report = checked(tmp_path / "right.xlsx", cells, task)
    assert report.verdict == "right", str(report)
    place = rows[2][first_in_file(task.machine.stem)]
    cells[place] += "+0.75"
    report = checked(tmp_path / "wrong.xlsx", cells, task)
    assert (report.verdict, report.faults[0].cell) == ("wrong", address(place))


def numbers(cells, form):
    """The table as numbers, written by `form`."""
    values = Values(Book(cells)).all()
    return {p: v if isinstance(v, str) else form(float(np.ravel(v)[0])) for p, v in values.items()}


@pytest.mark.parametrize(
    "form", [lambda v: round(v, 3), lambda v: float(f"{v:.6g}"), lambda v: float(np.float32(v)), lambda v: v]
)
@pytest.mark.parametrize("layout", ["points in columns", "two sheets"])
def test_a_table_of_numbers(layout, form, tmp_path):
    cells, rows, task = table(layout)
    cells = numbers(cells, form)
    report = checked(tmp_path / "right.xlsx", cells, task)
    assert report.verdict == "right", str(report)
    cells[rows[3]["Y"]] += 0.05
    report = checked(tmp_path / "wrong.xlsx", cells, task)
    assert [fault.cell for fault in report.faults] == [address(rows[3]["Y"])]


@pytest.mark.parametrize("layout", ["rounded", "points in columns"])
def test_rotary_words_alone(layout, tmp_path):
    cells, rows, task = table(layout)
    place = LAYOUTS[layout][1]
    cells = {
        p: cell for p, cell in cells.items() if p in {place(n, k) for n in range(-1, ROWS) for k in range(3, 8)}
    }
    report = checked(tmp_path / "right.xlsx", cells, task)
    assert report.verdict == "right" and rows[0]["C"] in {each.place for each in report.cells}, str(report)
    report = checked(tmp_path / "wrong.xlsx", cells | {rows[3]["C"]: f"{cells[rows[3]['C']]}+0.75"}, task)
    assert [fault.cell for fault in report.faults] == [address(rows[3]["C"])]
    cells = numbers(cells, lambda v: round(v, 4))
    assert checked(tmp_path / "numbers.xlsx", cells, task).verdict == "right"
    report = checked(tmp_path / "wrong_number.xlsx", cells | {rows[3]["C"]: cells[rows[3]["C"]] + 0.05}, task)
    assert [fault.cell for fault in report.faults] == [address(rows[3]["C"])]


def test_beyond_travel_while_the_other_branch_is_inside(tmp_path):
    for layout, verdict in (("two sheets", "wrong"), ("rounded", "right")):  # B from 0 to 180, A from -120 to 120
        cells, rows, task = table(layout)
        tilts = [row["B" if "B" in row else "A"] for row in rows]
        cells |= {p: cells[p].replace("DEGREES", "-DEGREES", 1) for p in tilts}
        if layout == "rounded":
            cells |= {
                row["C"]: re.sub(r"ATAN2\(-([^,]+),([^)]+)", r"ATAN2(\1,-\2", cells[row["C"]]) for row in rows
            }
        for form in (lambda cells: cells, lambda cells: numbers(cells, lambda v: round(v, 4))):
            report = checked(tmp_path / "sheet.xlsx", form(cells), task)
            assert report.verdict == verdict, str(report)
            expected = [(address(p), "branch") for p in tilts] * (verdict == "wrong")
            assert [(fault.cell, fault.cause) for fault in report.faults] == expected


@pytest.mark.parametrize(("layout", "long", "short"), [("blank columns", "300", "250")])
def test_words_of_another_point_of_the_head(layout, long, short, tmp_path):
    cells, rows, task = table(layout)
    words = {row[letter] for row in rows for letter in "XYZ"}
    cells |= {p: cells[p].replace(long, short) for p in words}
    said, place = f"{int(long) - int(short)} mm down the tool axis", rows[2]["Y"]
    for form in (lambda cells: cells, lambda cells: numbers(cells, lambda v: round(v, 5))):
        report = checked(tmp_path / "sheet.xlsx", form(cells), task)
        assert (report.verdict, report.faults) == ("not judged", []) and said in str(report), str(report)
        report = checked(tmp_path / "wrong.xlsx", form(cells | {place: f"{cells[place]}+0.75"}), task)
        assert [fault.cell for fault in report.faults] == [address(place)], str(report)


def test_at_the_pole_any_angle_is_right_but_there_must_be_one(tmp_path):
    cells, rows, task = table("rounded")
    cells |= dict(zip([in_rows(2, k) for k in (3, 4, 5)], (0, 0, 1), strict=True))
    angle = cells[rows[2]["C"]][1:]
    report = checked(tmp_path / "none.xlsx", cells, task)
    assert [fault.cell for fault in report.faults] == [address(rows[2]["C"])]
    for n, row in enumerate(rows):
        i, above = (address(place) for place in (in_rows(n, 3), rows[max(n - 1, 0)]["C"]))
        text = cells[row["C"]][1:]
        cells[row["C"]] = f"=IF({i}=0,{above},{text})" if n else f"={text}"
    assert angle in cells[rows[2]["C"]]
    assert checked(tmp_path / "kept.xlsx", cells, task).verdict == "right"


def test_a_tool_axis_that_is_no_unit_vector_is_warned_of(tmp_path):
    cells, _, task = table("rounded")
    cells["S", 5, 7] += 0.01
    report = checked(tmp_path / "sheet.xlsx", cells, task)
    assert any("no unit vector in row 5" in text for text in report.warnings)


def test_rows_that_are_no_rows_of_the_table_are_said(tmp_path):
    cells, _, task = table("rounded")
    cells = numbers(cells, lambda v: round(v, 3))
    for k in range(13):
        cells[in_rows(ROWS, k)] = min(cells[in_rows(n, k)] for n in range(ROWS))
    cells["S", ROWS + 3, 1] = "min"
    report = checked(tmp_path / "sheet.xlsx", cells, task)
    assert report.verdict == "not judged" and any("not understood" in text for text in report.seen)


def test_numbers_beside_a_table_are_said(tmp_path):
    cells, _, task = table("rounded")
    cells = numbers(cells, lambda v: round(v, 4)) | {("S", n + 3, 21): n + 0.123 for n in range(ROWS)}
    report = checked(tmp_path / "said.xlsx", cells, task)
    assert "not looked at: S!J3:J7, S!K3:K7, S!U3:U7" in str(report)


def test_a_function_that_is_not_known_makes_nothing_wrong(tmp_path):
    cells, rows, task = table("rounded")
    save(tmp_path / "sheet.xlsx", Book(cells), Values(Book(cells)).all())
    book = openpyxl.load_workbook(tmp_path / "sheet.xlsx")
    for row in rows:
        _, line, column = row["X"]
        cell = book.active[f"{letters(column)}{line}"]
        cell.value = f"=LET(q,1,q*{cell.value[1:]})"
    book.save(tmp_path / "sheet.xlsx")
    assert check_file(tmp_path / "sheet.xlsx", task).verdict == "not judged"


def test_a_range_may_be_written_backwards():
    assert parse("=SUM(C2:A1)", "S", {}) == parse("=SUM(A1:C2)", "S", {})


# Tilted planes.


def planes(title, *, across, raw, form):
    """Four planes, one per row or column, the normal first, angles in radians on the way; where the angles are."""
    _, sequence, formulas = PLANES[title]
    cells, angles = {("S", 1, 1): title}, []
    for n, three in enumerate(([25, 40, -35], [-70, 30, 60], [140, 75, -100], [10, 50, 20])):
        matrix = Rotation.from_euler(sequence, three, degrees=True).as_matrix()
        x, z = matrix[:, 0], matrix[:, 2]
        x, z = (30 * x, 4 * z) if raw else (x, z)

        def place(k, n=n):
            return ("S", k + 4, n + 2) if across else ("S", n + 4, k + 2)

        vectors = np.round([*z, *x], 5)
        cells |= {place(k): float(number) for k, number in enumerate(vectors)}
        fragments = {f"{letter}{k}": address(place(k + 3 * (letter == "x"))) for letter in "zx" for k in range(3)}
        if raw:
            unit = "({}/SQRT({}^2+{}^2+{}^2))"
            for letter in "zx":
                three = [fragments[f"{letter}{k}"] for k in range(3)]
                fragments |= {f"{letter}{k}": unit.format(three[k], *three) for k in range(3)}
        for k, formula in enumerate(formulas):
            cells[place(7 + k)] = f"={formula.format(**fragments)}"
            cells[place(11 + k)] = f"={form.format(address(place(7 + k)))}"
        angles.append([place(11 + k) for k in range(3)])
    return cells, angles


@pytest.mark.parametrize(("across", "raw"), [(False, False), (True, False), (False, True)])
@pytest.mark.parametrize("title", PLANES)
def test_planes_in_rows_or_columns(title, across, raw, tmp_path):
    cells, angles = planes(title, across=across, raw=raw, form="ROUND(DEGREES({}),3)")
    report = checked(tmp_path / "right.xlsx", cells)
    assert report.verdict == "right", str(report)
    place = angles[2][1]
    cells[place] = cells[place].replace("DEGREES", "")
    report = checked(tmp_path / "wrong.xlsx", cells)
    assert (report.verdict, report.faults[0].cell) == ("wrong", address(place))


# Numbers that no label names.


def rotation_in_numbers(points):
    """α β γ, three matrices and their product in numbers of five decimals, and points with what they become."""
    angles = (48, -30, 21)
    single = [Rotation.from_euler(a, -g, degrees=True).as_matrix() for a, g in zip("zxz", angles, strict=True)]
    cells = {("S", 1, 2 * n + 1): "αβγ"[n] for n in range(3)} | {("S", 1, 2 * n + 2): angles[n] for n in range(3)}
    matrices = dict(zip(("Ez(α)", "Ex(β)", "Ez(γ)", "R = Ez(γ)·Ex(β)·Ez(α)"), single, strict=False))
    matrices["R = Ez(γ)·Ex(β)·Ez(α)"] = single[2] @ single[1] @ single[0]
    for n, (label, matrix) in enumerate(matrices.items()):
        cells["S", 3 + 5 * n, 1] = label
        cells |= {("S", 4 + 5 * n + r, 1 + c): round(float(matrix[r, c]), 5) for r in range(3) for c in range(3)}
    for n, point in enumerate(points):
        after = np.round(matrix @ point, 5)
        cells |= {("S", 4 + n, 6 + c): point[c] for c in range(3)}
        cells |= {("S", 4 + n, 10 + c): float(after[c]) for c in range(3)}
    return cells


# Points turned by the angles of a tilted plane.

SEQUENCES = {  # title, the angles from the plane's axes: {x0} is the X of its X, {z2} the Z of its Z
    "ZXZ": ("Z-X'-Z''", ("ATAN2(-{z1},{z0})", "ACOS({z2})", "ATAN2({y2},{x2})")),
    "ZYZ": ("Z-Y'-Z''", ("ATAN2({z0},{z1})", "ACOS({z2})", "ATAN2(-{x2},{y2})")),
    "XYZ": ("CYCLE800 X-Y'-Z''", ("ATAN2({z2},-{z1})", "ASIN({z0})", "ATAN2({x0},-{y0})")),
    "xyz": ("PLANE SPATIAL SPA SPB SPC", ("ATAN2({z2},{y2})", "ASIN(-{x2})", "ATAN2({x0},{x1})")),
}
GIVEN = {  # numbers, and the plane's X and normal from them
    "two directions": ([[0.8, 0.3, -0.2], [-0.1, 0.9, 0.35]], "{a}", "{b}"),
    "three points": ([[10, 5, 20], [70, 35, 14], [-5, 60, 38]], "{b}-{a}", "{c}-{a}"),
}


def points_of_a_plane(sequence, given, *, into):
    """Directions or points, their frame, its angles, and points turned step by step; the places of the angles."""
    title, angles = SEQUENCES[sequence]
    numbers, *directions = GIVEN[given]
    cells = {("S", 1, 1): title} | {
        ("S", 3 + n, 2 + k): v for n, row in enumerate(numbers) for k, v in enumerate(row)
    }
    row = {letter: [address(("S", 3 + n, 2 + k)) for k in range(3)] for n, letter in enumerate("abc")}

    def put(name, line, formulas):
        row[name] = [address(("S", line, 2 + k)) for k in range(3)]
        cells.update({("S", line, 2 + k): f"={formula}" for k, formula in enumerate(formulas)})

    def cross(a, b):
        return [f"{a[(k + 1) % 3]}*{b[(k + 2) % 3]}-{a[(k + 2) % 3]}*{b[(k + 1) % 3]}" for k in range(3)]

    for name, line, form in zip("uv", (8, 9), directions, strict=True):
        put(name, line, [form.format(**{letter: places[k] for letter, places in row.items()}) for k in range(3)])
    put("n", 10, cross(row["u"], row["v"]))
    for name, line, of in (("x", 11, "u"), ("z", 12, "n")):
        put(name, line, [f"{cell}/SQRT({row[of][0]}^2+{row[of][1]}^2+{row[of][2]}^2)" for cell in row[of]])
    put("y", 13, cross(row["z"], row["x"]))
    axes = {f"{name}{k}": row[name][k] for name in "xyz" for k in range(3)}
    places = [("S", 15 + k, 2) for k in range(3)]
    cells |= {place: f"=DEGREES({form.format(**axes)})" for place, form in zip(places, angles, strict=True)}
    cells |= {("S", 18, 2 + k): number for k, number in enumerate((12.5, -7, 31))}
    steps = list(zip(sequence.upper(), places, strict=True))
    steps = steps if sequence.isupper() == into else steps[::-1]
    for n, point in enumerate(([3.5, 40, -8], [-25, 6.25, 17])):
        cells |= {("S", 21 + n, 2 + k): number for k, number in enumerate(point)}
        now = [f"{address(('S', 21 + n, 2 + k))}" for k in range(3)]
        now = [f"({cell}-{'BCD'[k]}$18)" for k, cell in enumerate(now)] if into else now
        for step, (axis, angle) in enumerate(steps):
            turn, sign = f"(RADIANS({address(angle)}))", "+-" if into else "-+"
            k, m = ("XYZ".index(axis) + 1) % 3, ("XYZ".index(axis) + 2) % 3
            first, second = (
                f"{now[k]}*COS{turn}{sign[0]}{now[m]}*SIN{turn}",
                f"{now[m]}*COS{turn}{sign[1]}{now[k]}*SIN{turn}",
            )
            after = {k: first, m: second}
            last = [f"+{letter}$18" for letter in "BCD"] if step == 2 and not into else [""] * 3
            for c in range(3):
                cells["S", 21 + n, 6 + 4 * step + c] = f"={after.get(c, now[c])}{last[c]}"
            now = [address(("S", 21 + n, 6 + 4 * step + c)) for c in range(3)]
    return cells, places


PLANE_SHEETS = [("ZXZ", "two directions", True), ("xyz", "two directions", False), ("XYZ", "three points", True)]


@pytest.mark.parametrize(("sequence", "given", "into"), [*PLANE_SHEETS, ("ZYZ", "three points", False)])
def test_points_turned_by_the_angles_of_a_plane(sequence, given, into, tmp_path):
    cells, places = points_of_a_plane(sequence, given, into=into)
    values = {p: float(np.ravel(v)[0]) for p, v in Values(Book(cells)).all().items() if not isinstance(v, str)}
    frame = np.array([[values["S", line, 2 + k] for line in (11, 13, 12)] for k in range(3)])
    matrix = Rotation.from_euler(sequence, [values[p] for p in places], degrees=True).as_matrix()
    np.testing.assert_allclose(matrix, frame, atol=1e-12)
    origin, point = (np.array([values["S", line, 2 + k] for k in range(3)]) for line in (18, 22))
    result = [values["S", 22, 14 + k] for k in range(3)]
    np.testing.assert_allclose(result, frame.T @ (point - origin) if into else frame @ point + origin, atol=1e-9)
    report = checked(tmp_path / "right.xlsx", cells)
    assert report.verdict == "right", str(report)
    turned = next(p for p in (("S", 22, 10 + k) for k in range(3)) if "COS" in cells[p])
    slips = {places[2]: ("ATAN2(", "-ATAN2("), ("S", 10, 3): ("-", "+"), turned: ("COS", "SIN")}
    for place, (old, new) in slips.items():
        assert old in cells[place]
        report = checked(tmp_path / "wrong.xlsx", cells | {place: cells[place].replace(old, new, 1)})
        assert (report.verdict, report.faults[0].cell) == ("wrong", address(place)), str(report)


def test_a_plane_by_its_normal_has_two_angles_and_one_that_is_given(tmp_path):
    cells = {("S", 1, 1): "Z-Y'-Z''"} | {("S", 3, 2 + k): n for k, n in enumerate((-0.3, 0.55, 0.9))}
    cells |= {("S", 5, 2 + k): f"={'BCD'[k]}3/SQRT(B3^2+C3^2+D3^2)" for k in range(3)}
    cells |= {("S", 7, 2): "=DEGREES(ATAN2(B5,C5))", ("S", 7, 3): "=DEGREES(ACOS(D5))", ("S", 7, 4): 33.0}
    assert checked(tmp_path / "right.xlsx", cells).verdict == "right"
    cells["S", 7, 2] = "=DEGREES(ATAN2(-C5,B5))"
    assert checked(tmp_path / "wrong.xlsx", cells).verdict != "right"


def plane_with_lengths():
    """Three points of round numbers, their frame with lengths in cells, ZXZ angles, and the first point again."""
    rows = {
        1: ["G68.2 I J K"],
        **{3: [0, 0, 10], 4: [100, 0, 30], 5: [0, 80, 25]},
        7: [f"={c}4-{c}3" for c in "BCD"],
        8: [f"={c}5-{c}3" for c in "BCD"],
        9: ["=C7*D8-D7*C8", "=D7*B8-B7*D8", "=B7*C8-C7*B8"],
        **{10: ["=SQRT(SUMSQ(B7:D7))"], 11: ["=SQRT(SUMSQ(B9:D9))"]},
        **{12: [f"={c}7/$B$10" for c in "BCD"], 13: [f"={c}9/$B$11" for c in "BCD"]},
        14: ["=C13*D12-D13*C12", "=D13*B12-B13*D12", "=B13*C12-C13*B12"],
        **{16: ["=DEGREES(ATAN2(-C13,B13))"], 17: ["=DEGREES(ACOS(D13))"], 18: ["=DEGREES(ATAN2(D14,D12))"]},
        20: ["=B3", "=C3", "=D3"],
    }
    return {("S", line, 2 + k): content for line, row in rows.items() for k, content in enumerate(row)}


def test_copies_of_a_given_point_beside_a_plane_are_judged(tmp_path):
    report = checked(tmp_path / "right.xlsx", plane_with_lengths())
    assert (report.verdict, report.checked) == ("right", report.total), str(report)
    assert checked(tmp_path / "wrong.xlsx", plane_with_lengths() | {("S", 20, 3): "=C4"}).verdict != "right"


WAY_TO_A_PLANE = {
    "an empty cell for a length": {(13, 4): "=D9/$C$11"},
    "the normal turned round": {(11, 2): "=-SQRT(SUMSQ(B9:D9))"},
    "a difference from itself": {(7, 4): "=D3-D3"},
    "times for divided": {(13, 3): "=C9*$B$11"},
    "divided for times": {(9, 4): "=B7/C8-C7*B8"},
    "a number for a formula": {(9, 3): -1600},
    "no length": {(13, 2 + k): f"={c}9" for k, c in enumerate("BCD")},
}


@pytest.mark.parametrize("slip", WAY_TO_A_PLANE)
def test_a_slip_on_the_way_to_a_plane_is_named_where_it_is(slip, tmp_path):
    wrong = {("S", *place): content for place, content in WAY_TO_A_PLANE[slip].items()}
    report = checked(tmp_path / "wrong.xlsx", plane_with_lengths() | wrong)
    assert (report.verdict, report.faults[0].cell) == ("wrong", address(min(wrong))), str(report)


def test_a_slip_in_a_table_of_normals_is_named_in_its_row(tmp_path):
    normals = ((0.6, 0, 0.8), (0, -0.6, 0.8), (0.48, 0.36, 0.8), (-0.36, 0.48, 0.8))
    cells = {("S", 1, 1): "Z-X'-Z''"} | {("S", 3 + n, 1): n + 1 for n in range(4)}
    cells |= {("S", 3 + n, 2 + k): number for n, normal in enumerate(normals) for k, number in enumerate(normal)}
    cells |= {("S", n, 5): f"=DEGREES(ATAN2(-C{n},B{n}))" for n in range(3, 7)}
    cells |= {("S", n, 6): f"=DEGREES(ACOS(D{n}))" for n in range(3, 7)}
    assert checked(tmp_path / "right.xlsx", cells).verdict == "right"
    for place, formula in ((("S", 4, 5), "=DEGREES(ATAN2(-D4,B4))"), (("S", 3, 6), "=DEGREES(ACOS(C3))")):
        report = checked(tmp_path / "wrong.xlsx", cells | {place: formula})
        assert (report.verdict, report.faults[0].cell) == ("wrong", address(place)), str(report)


def test_an_angle_of_itself_ends_the_check(tmp_path):
    book = openpyxl.Workbook()
    for (_, *place), content in plane_with_lengths().items():
        book.active.cell(*place, content)
    for row in (16, 17, 18):
        book.active.cell(row, 3, f"=ROUND(B{row},3)")
    book.active["C17"] = "=ROUND(C17,3)"
    book.save(tmp_path / "circle.xlsx")
    assert check_file(tmp_path / "circle.xlsx").verdict != "right"


# Numbers of which no label says what they are.


@pytest.mark.parametrize("group", [False, True])
def test_tip_and_linear_words_under_each_others_headings_are_wrong(group, tmp_path):
    kinematics = Kinematics(load_machine(ROOT / "data/machines/dmu50v.toml"))
    rng = np.random.default_rng(1)
    tips, axes = rng.uniform(-50, 50, (4, 3)).round(3), np.abs(rng.normal(size=(4, 3)))
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    words = kinematics.inverse(tips, axes, degrees=True)[:, 0].round(6)
    cl, nc = ["x", "y", "z", "i", "j", "k"], ["X", "Y", "Z", "B", "C"]
    for first, second, verdict in (("CL", "NC", "right"), ("NC", "CL", "wrong")):
        book = openpyxl.Workbook()
        if group:
            book.active.append([first, *[None] * 5, second])
            book.active.append([*cl, *nc])
        else:
            heads = [f"{first} {letter}" for letter in cl[:3]] + cl[3:]
            book.active.append(heads + [f"{second} {letter}" for letter in nc[:3]] + nc[3:])
        for row in np.hstack([tips, axes, words]).tolist():
            book.active.append(row)
        book.save(tmp_path / "table.xlsx")
        report = check_file(tmp_path / "table.xlsx", Task(machine=kinematics.machine))
        assert report.verdict == verdict, report


def test_a_machine_with_one_rotary_axis_is_refused_in_a_sentence(tmp_path):
    cells, _, _ = table("rounded")
    path = tmp_path / "sheet.xlsx"
    save(path, Book(cells), Values(Book(cells)).all())
    with pytest.raises(InputError, match="machine: expected a machine with two rotary axes.*Dividing head"):
        check_file(path, Task(machine=ROOT / "data/machines/dividing_head.toml"))
