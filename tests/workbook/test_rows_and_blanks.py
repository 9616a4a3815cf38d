"""Tables with rows of statistics, blanks that say "unchanged" and rows under each other's points; what mirrors."""

import numpy as np
import pytest

from mathpost.workbook import Task
from tests.workbook.cells import address
from tests.workbook.test_headings import as_numbers, points
from tests.workbook.test_machining import ROWS, checked, table
from tests.workbook.test_strange_sheets import _check

LAST = 3 + ROWS  # the row below the table


def column_of(place):
    return address((place[0], 1, place[2])).split("!")[-1][:-1]


@pytest.mark.parametrize("gap", [0, 1])
@pytest.mark.parametrize("label", ["max", "größter Wert", None])
def test_a_row_of_statistics_is_no_row_of_the_table(label, gap, tmp_path):
    cells, rows, task = table("rounded")
    places = {word: rows[0][word] for word in ("A", "C", "X", "Y", "Z")}
    row = LAST + gap
    cells |= {("S", row, 1): label} if label else {}
    for form in ("=MAX({0})", "=MAX({0})-MIN({0})"):
        cells |= {
            ("S", row, p[2]): form.format(f"{column_of(p)}3:{column_of(p)}{LAST - 1}") for p in places.values()
        }
        report = checked(tmp_path / "right.xlsx", cells, task)
        assert report.verdict == "right", (form, str(report))
    wrong = cells | {("S", row, places["Y"][2]): cells["S", row, places["X"][2]].replace("MAX", "SUM", 1)}
    assert checked(tmp_path / "wrong.xlsx", wrong, task).verdict != "right"


def modal(form):
    """A table whose first three tool axes are the same, and its words once more, blank where they are the same."""
    cells, rows, task = table("rounded")
    for n in (1, 2):
        cells |= {("S", 3 + n, 5 + k): cells["S", 3, 5 + k] for k in range(3)}
    found = {}
    for n, row in enumerate(rows):
        for k, word in enumerate(("X", "Y", "Z", "A", "C")):
            own, place = address(row[word]), ("S", 3 + n, 30 + k)
            before = address(rows[n - 1][word])
            found[place] = form.format(own=own, before=before) if n and k > 2 else f"={own}"
    heads = {("S", 2, 30 + k): word for k, word in enumerate(("X", "Y", "Z", "A", "C"))}
    return cells | heads | found, rows, task


FORMS = ['=IF({own}={before},"",{own})', '=IF(ABS({own}-{before})>0.00001,{own},"")']


@pytest.mark.parametrize("form", FORMS)
def test_a_blank_word_is_the_one_before(form, tmp_path):
    cells, rows, task = modal(form)
    assert checked(tmp_path / "right.xlsx", cells, task).verdict == "right"
    a, c, before = (address(rows[3][word]) for word in "AC"), None, address(rows[2]["C"])
    own, c = a
    other = (
        form.format(own=c, before=before)
        .replace(f"{c}={before}", f"{own}={own}")
        .replace(f"ABS({c}", f"ABS({before}")
    )
    report = checked(tmp_path / "wrong.xlsx", cells | {("S", 6, 34): other}, task)  # never said again
    assert report.verdict == "wrong", str(report)


def test_a_blank_among_typed_words_is_the_one_before(tmp_path):
    cells, rows, task = table("rounded")
    for n in (1, 2):
        cells |= {("S", 3 + n, 5 + k): cells["S", 3, 5 + k] for k in range(3)}
    cells = as_numbers(cells)
    blank = {row[word] for row in rows[1:3] for word in "AC"}
    cells = {p: cell for p, cell in cells.items() if p not in blank}
    assert checked(tmp_path / "right.xlsx", cells, task).verdict == "right"
    del cells[rows[3]["C"]]
    report = checked(tmp_path / "wrong.xlsx", cells, task)
    assert [fault.place for fault in report.faults][:1] == [rows[3]["C"]], str(report)


def test_a_sum_that_is_typed_while_nobody_uses_its_parts_is_not_right(tmp_path):
    cells, _, task = table("from right to left")  # a head of 200 and 150 mm
    parts = {("S", 20, 1): "pivot to nose", ("S", 20, 2): 200, ("S", 21, 1): "tool", ("S", 21, 2): 150}
    length = {p: c.replace("350", "$F$20") if isinstance(c, str) else c for p, c in cells.items()}
    right = length | parts | {("S", 20, 6): "=B20+B21"}
    assert checked(tmp_path / "right.xlsx", right, task).verdict == "right"
    report = checked(tmp_path / "typed.xlsx", right | {("S", 20, 6): 350}, task)
    assert report.verdict == "unclear" and "F20 is 350, as B20 and B21 together" in str(report)


@pytest.mark.parametrize("down", [False, True])
def test_rows_that_have_each_others_points_are_wrong(down, tmp_path):
    cells = points(down)
    place = (lambda n, k: ("S", 10 + k, 2 + n)) if down else (lambda n, k: ("S", 7 + n, 4 + k))
    other = cells | {place(n, k): cells[place(3 - n, k)] for n in (1, 2) for k in range(3)}
    report = checked(tmp_path / "wrong.xlsx", other)
    assert (report.verdict, report.faults[0].place) == ("wrong", place(1, 0)), str(report)


@pytest.mark.parametrize("lost", [(), (2,), range(5)])
def test_what_is_said_to_be_mirrored_and_is_not_is_not_right(lost, tmp_path):
    cells = points(False) | {("S", 6, 7 + k): text for k, text in enumerate(("mirrored: x", "y", "z"))}
    for n in range(5):
        signs = ["" if n in lost else "-", "", ""]
        cells |= {("S", 7 + n, 7 + k): f"={signs[k]}{address(('S', 7 + n, 4 + k))}" for k in range(3)}
    assert checked(tmp_path / "mirror.xlsx", cells).verdict == ("unclear" if lost else "right")


def about_an_axis(check):
    axis = np.array([0.48, 0.6, 0.64])
    cells = {"A1": "Rotation of p about the unit axis k through the origin (Rodrigues), active"}
    cells |= {f"A{3 + n}": f"k{c}" for n, c in enumerate("xyz")} | {f"B{3 + n}": float(axis[n]) for n in range(3)}
    cells |= {"A6": "phi", "B6": -130} | {f"G{3 + n}": f"p{c}" for n, c in enumerate("xyz")}
    cells |= {"H3": 60, "H4": 5, "H5": -31, "C9": "k x p", "E9": "k.p", "F9": "=SUMPRODUCT(B3:B5,H3:H5)"}
    cells |= {"D9": "=B4*H5-B5*H4", "D10": "=B5*H3-B3*H5", "D11": "=B3*H4-B4*H3", "G9": "p'"}
    for n in range(3):
        turned = f"H{3 + n}*COS(RADIANS($B$6))+D{9 + n}*SIN(RADIANS($B$6))"
        cells[f"H{9 + n}"] = f"={turned}+B{3 + n}*$F$9*(1-COS(RADIANS($B$6)))"
    return cells | {"G13": "k.p'", "H13": check}


@pytest.mark.parametrize(
    ("check", "verdict"),
    [
        ("=SUMPRODUCT(B3:B5,H9:H11)", "right"),
        ("=B3*H9+B4*H10+B5*H11", "right"),
        ("=B3*H9+B4*H10+B5*H10", "unclear"),
    ],
)
def test_what_is_kept_along_the_axis_is_known(check, verdict, tmp_path):
    assert _check(tmp_path, about_an_axis(check)).verdict == verdict


def test_a_tip_that_is_only_right_as_the_words_is_wrong(tmp_path):
    """With all pivots in one point a rotation that is transposed makes the tip of the words."""
    rng, tilt, turn = (
        np.random.default_rng(3),
        np.radians(np.linspace(15, 50, 6)),
        np.radians(np.linspace(-60, 70, 6)),
    )
    axes = np.stack([np.sin(tilt) * np.sin(turn), -np.sin(tilt) * np.cos(turn), np.cos(tilt)], axis=1)
    cells = {("S", 1, 1 + k): name for k, name in enumerate([*"xyzijk", "A", "C", *"XYZ"])}
    path = tmp_path / "zero.toml"
    source = Task(machine=table("rounded")[2].machine).machine.read_text()
    path.write_text(source.replace("point = [0, 0, -50]", "point = [0, 0, 0]"))
    for transposed, verdict in ((False, "right"), (True, "wrong")):
        for n in range(6):
            about_x = np.array(
                [[1, 0, 0], [0, np.cos(tilt[n]), np.sin(tilt[n])], [0, -np.sin(tilt[n]), np.cos(tilt[n])]]
            )
            c, s = np.cos(turn[n]), np.sin(turn[n])
            whole = about_x @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])
            tip = rng.uniform(-50, 50, 3).round(3)
            words = (whole.T if transposed else whole) @ tip
            row = [*tip, *axes[n].round(6), *np.degrees([tilt[n], turn[n]]).round(4), *words.round(4)]
            cells |= {("S", 2 + n, 1 + k): float(v) for k, v in enumerate(row)}
        assert checked(tmp_path / "table.xlsx", cells, Task(machine=path)).verdict == verdict


TURNS = {
    "Rotación activa: el punto gira con los ángulos de Euler ZXZ": "right",
    "Rotazione attiva: il punto ruota con gli angoli di Eulero ZXZ": "right",
    "Ángulos de Euler ZXZ; coordenadas en el sistema girado": "unclear",
    "Euler angles ZXZ, coordinates in the turned frame": "wrong",
}


@pytest.mark.parametrize("text", TURNS)
def test_a_result_that_is_another_reading_under_a_text_that_is_not_understood_is_no_fault(text, tmp_path):
    cells = points(False)
    for n in range(5):
        for k in range(3):
            terms = (f"{address(('S', 2 + j, 10 + k))}*{address(('S', 7 + n, 1 + j))}" for j in range(3))
            cells["S", 7 + n, 4 + k] = "=" + "+".join(terms)
    assert checked(tmp_path / "turned.xlsx", cells | {("S", 1, 1): text}).verdict == TURNS[text]


@pytest.mark.parametrize(("word", "verdict"), [(None, "right"), ("A", "unclear"), ("C", "unclear")])
def test_a_rotary_word_is_not_converted_to_inches(word, verdict, tmp_path):
    cells, rows, task = table("rounded")
    for n, row in enumerate(rows):
        for k, name in enumerate(("X", "Y", "Z", "A", "C")):
            cells["S", 3 + n, 30 + k] = f"={address(row[name])}" + "/25.4" * (name in "XYZ" or name == word)
    assert checked(tmp_path / "inches.xlsx", cells, task).verdict == verdict
