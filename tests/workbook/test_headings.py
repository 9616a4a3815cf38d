"""Columns, or rows, under each other's headings: what is right only under other headings is wrong."""

from itertools import combinations, product

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mathpost.teaching.workbook import Task
from tests.workbook.cells import Book, Values, address
from tests.workbook.machining_sheets import MACHINES, TABLES, first_in_file, forward, order_of
from tests.workbook.test_machining import checked, table
from tests.workbook.test_strange_sheets import _check

PAIRS = [*combinations(("x", "y", "z"), 2), *combinations(("i", "j", "k"), 2), ("X", "Z"), ("A", "C")]
ANGLES = 33, 52, -71
POINTS = ((12, 0, 5), (-31, 44, 8), (7, 19, -62), (80, -5, 23), (15, -22, 31))


def as_numbers(cells):
    values = Values(Book(cells)).all()
    is_formula = {p: isinstance(cell, str) and cell.startswith("=") for p, cell in cells.items()}
    return {p: round(float(values[p][0]), 5) if is_formula[p] else cell for p, cell in cells.items()}


def exchanged(cells, names):
    places = [next(p for p, text in cells.items() if text == name) for name in names]
    return cells | dict(zip(places, names[::-1], strict=True))


@pytest.mark.parametrize("numbers", [False, True])
@pytest.mark.parametrize("layout", ["points in columns", "rounded"])
def test_columns_of_a_machines_table_under_each_others_headings_are_wrong(layout, numbers, tmp_path):
    cells, _, task = table(layout)
    names = {"points in columns": {"A": "B"}}.get(layout, {})
    cells = as_numbers(cells) if numbers else cells
    assert checked(tmp_path / "right.xlsx", cells, task).verdict == "right"
    for n, pair in enumerate(PAIRS):
        other = exchanged(cells, [names.get(name, name) for name in pair])
        report = checked(tmp_path / f"{n}.xlsx", other, task)
        assert [fault.cause for fault in report.faults] == ["exchanged"], (pair, str(report))


STYLES = {  # of tip, axis, X Y Z and rotary words: {0} is the letter as it is, {1} a capital
    "case": ("{0}", "{0}", "{1}", "{1}"),
    "suffix": ("{1}_CL", "{1}", "{1}_NC", "{1} [°]"),
    "words": ("Werkstück {1}", "刀轴{0}", "机床{1}", "{1}角"),
}


def named_numbers(name, style, down):
    """A machine's table by its pose, from SciPy: heading of each part and letter, cells, places of headings."""
    names = sorted(TABLES[name][1], key=lambda each: each != first_in_file(name))
    keys = [*product(("tip",), "xyz"), *product(("axis",), "ijk"), *product(("linear",), "xyz")]
    keys += [("rotary", each) for each in names]
    form = dict(zip(("tip", "axis", "linear", "rotary"), STYLES[style], strict=True))
    headings = {(part, letter): form[part].format(letter, letter.upper()) for part, letter in keys}
    linear = np.random.default_rng(3).uniform(-90, 90, (3, 3)).round(3)
    rotary = order_of(name, TABLES[name][1], (18, 31, 47), (-35, 12, 64))
    values = np.vstack([forward(name, linear, rotary).round(6), linear, rotary])

    def place(n, k):
        return ("S", 3 + k, 2 + n) if down else ("S", 3 + n, 2 + k)

    cells = {place(n, k): float(values[k, n]) for k in range(11) for n in range(3)}
    return headings, cells, {key: place(-1, k) for k, key in enumerate(keys)}


@pytest.mark.parametrize("down", [False, True])
@pytest.mark.parametrize(
    ("name", "style"),
    [("ac_table", "case"), ("ac_head", "suffix"), ("head_b_table_c", "words"), ("dmu50v", "suffix")],
)
def test_what_is_right_only_under_exchanged_headings_is_exchanged(name, style, down, tmp_path):
    headings, cells, at = named_numbers(name, style, down)
    task = Task(machine=MACHINES / f"{name}.toml")
    keys = [*headings]
    ways = [keys[a : a + 1] + keys[b : b + 1] for a, b in [(0, 1), (3, 5), (7, 8), (9, 10), (2, 5), (6, 9), (1, 7)]]
    ways += [keys[a : a + 3] + keys[b : b + 3] for a, b in [(0, 3), (0, 6), (3, 6)]]
    for n, way in enumerate(([], *ways)):
        half = len(way) // 2
        said = headings | {a: headings[b] for a, b in zip(way, way[half:] + way[:half], strict=True)}
        report = checked(tmp_path / f"{n}.xlsx", cells | {at[key]: said[key] for key in keys}, task)
        assert [fault.cause for fault in report.faults] == ["exchanged"] * bool(way), (way, str(report))
        along = 1 if down else 2
        assert {fault.place[along] for fault in report.faults} <= {at[key][along] for key in way}


@pytest.mark.parametrize("name", ["ac_head", "bc_table"])
def test_a_wrong_number_under_right_headings_is_that_number(name, tmp_path):
    headings, cells, at = named_numbers(name, "suffix", False)  # in whole degrees
    task = Task(machine=MACHINES / f"{name}.toml")
    cells |= {at[key]: heading for key, heading in headings.items()}
    for letter in "xyz":
        sheet, row, column = at["linear", letter]
        place = sheet, row + 2, column
        report = checked(tmp_path / f"{letter}.xlsx", cells | {place: cells[place] + 0.7}, task)
        assert [fault.place for fault in report.faults] == [place], str(report)


def points(down, order="xyz"):
    """Five points and what becomes of them, in rows or in columns, and its places; formulas written by hand."""
    (a, b, c), cells = np.radians(ANGLES), {("S", 1, 1): "ZXZ Euler angles, coordinates in the turned frame"}
    cells |= {("S", 2, 1 + 2 * n): name for n, name in enumerate(("alpha", "beta", "gamma"))}
    cells |= {("S", 2, 2 + 2 * n): angle for n, angle in enumerate(ANGLES)}
    matrix = Rotation.from_euler("ZXZ", (a, b, c)).as_matrix().T
    entries = [
        ["{ca}*{cg}-{sa}*{cb}*{sg}", "{sa}*{cg}+{ca}*{cb}*{sg}", "{sb}*{sg}"],
        ["-{ca}*{sg}-{sa}*{cb}*{cg}", "-{sa}*{sg}+{ca}*{cb}*{cg}", "{sb}*{cg}"],
        ["{sa}*{sb}", "-{ca}*{sb}", "{cb}"],
    ]
    named = {
        f"{f[0].lower()}{n}": f"{f}(RADIANS({p}2))"
        for n, p in zip("abg", "BDF", strict=True)
        for f in ("COS", "SIN")
    }
    cells |= {("S", 2 + n, 10 + k): "=" + entries[n][k].format(**named) for n in range(3) for k in range(3)}
    values = Values(Book(cells)).all()
    assert np.allclose([[values["S", 2 + n, 10 + k][0] for k in range(3)] for n in range(3)], matrix)

    def place(n, k):
        return ("S", 7 + k, 2 + n) if down else ("S", 7 + n, 1 + k)

    cells |= {
        ("S", 7 + k, 1) if down else ("S", 6, 1 + k): h for k, h in enumerate(["x", "y", "z", "x'", "y'", "z'"])
    }
    for n, point in enumerate(POINTS):
        cells |= {place(n, k): point[k] for k in range(3)}
        for k, letter in enumerate(order):
            row = "xyz".index(letter)
            terms = (f"{address(('S', 2 + row, 10 + j))}*{address(place(n, j))}" for j in range(3))
            cells[place(n, 3 + k)] = "=" + "+".join(terms)
    return cells


@pytest.mark.parametrize("down", [False, True])
def test_coordinates_under_each_others_headings_are_wrong(down, tmp_path):
    report = checked(tmp_path / "right.xlsx", points(down))
    assert report.verdict == "right"
    for order, first in (("yxz", 0), ("zyx", 0), ("xzy", 1), ("yzx", 0)):
        cells = points(down, order)
        report = checked(tmp_path / f"{order}.xlsx", cells)
        cell = address(("S", 10 + first, 2) if down else ("S", 7, 4 + first))
        assert report.verdict == "wrong" and report.faults[0].cell == cell, (order, str(report))
    for pair in PAIRS[:3]:
        report = checked(tmp_path / "points.xlsx", exchanged(points(down), pair))
        assert report.verdict == "wrong", (pair, str(report))


POSITION = {
    **{"x": 35.5, "y": -22, "z": 18, "i": 0.321394, "j": -0.55667, "k": 0.766044},
    "A": "=DEGREES(ACOS(B8))",
    "C": "=DEGREES(ATAN2(-B7,B6))",
    "X": "=B3*COS(RADIANS(B10))+B4*SIN(RADIANS(B10))",
    "Y": "=(B4*COS(RADIANS(B10))-B3*SIN(RADIANS(B10)))*COS(RADIANS(B9))+(B5+50)*SIN(RADIANS(B9))",
    "Z": "=(B5+50)*COS(RADIANS(B9))-50-(B4*COS(RADIANS(B10))-B3*SIN(RADIANS(B10)))*SIN(RADIANS(B9))",
}


def test_labels_of_a_single_position(tmp_path):
    cells = {f"B{n}": content for n, content in enumerate(POSITION.values(), 3)}
    names, machine = [*POSITION], table("rounded")[2].machine
    for pair in (("x", "x"), *PAIRS):
        said = [dict([pair, pair[::-1]]).get(name, name) for name in names]
        report = _check(tmp_path, cells, {f"A{n}": name for n, name in enumerate(said, 3)}, machine=machine)
        assert report.verdict == ("wrong" if said != names else "right"), (pair, report)
