"""Numbers of a machine that are 0 in a sheet hide nothing: a slip before them is found, though no word shows it."""

import numpy as np
import openpyxl
import pytest

from mathpost import machine
from mathpost.workbook import Task, check_file

ROWS = range(8, 12)
ANGLES = {"ac_table": "=DEGREES(ATAN2(-E#,D#))", "bc_table": "=DEGREES(ATAN2(D#,E#))"}
CHAINS = {  # what becomes of the point before each rotary axis, I J K, and after it, L M N
    "ac_table": ("=I#", "={ca}*(J#-$C$3)+{sa}*(K#-$D$3)+$C$3", "=-{sa}*(J#-$C$3)+{ca}*(K#-$D$3)+$D$3"),
    "bc_table": ("={ca}*(I#-$B$3)-{sa}*(K#-$D$3)+$B$3", "=J#", "={sa}*(I#-$B$3)+{ca}*(K#-$D$3)+$D$3"),
}


def table(name):
    """A table of poses and words with part zero and both pivots in rows 2 to 4; many of these numbers are 0."""
    loaded, rng = machine.load(name), np.random.default_rng(3)
    cells = dict(zip(("B1", "C1", "D1"), "xyz", strict=True))
    points = (loaded.origin, *(joint.point for joint in loaded.rotary))
    for row, (text, point) in enumerate(zip(("part zero", "axis 1", "axis C"), points, strict=True), 2):
        cells |= {f"A{row}": text} | {f"{'BCD'[k]}{row}": point[k] for k in range(3)}
    headings = ("x", "y", "z", "i", "j", "k", loaded.rotary[0].name, "C", *"uvwrst", "X", "Y", "Z")
    cells |= {f"{chr(65 + n)}7": text for n, text in enumerate(headings)}
    turned = {f"{f[0].lower()}{x}": f"{f}(RADIANS({c}#))" for x, c in ("aG", "cH") for f in ("COS", "SIN")}
    x, y = "(A#+$B$2-$B$4)", "(B#+$C$2-$C$4)"
    formulas = {
        "G": "=DEGREES(ACOS(F#))",
        "H": ANGLES[name],
        "I": f"={{cc}}*{x}+{{sc}}*{y}+$B$4",
        "J": f"=-{{sc}}*{x}+{{cc}}*{y}+$C$4",
        "K": "=C#+$D$2",
        **dict(zip("LMN", CHAINS[name], strict=True)),
        **{"O": "=L#-$B$2", "P": "=M#-$C$2", "Q": "=N#-$D$2"},
    }
    for row in ROWS:
        tilt, turn = np.radians(rng.uniform(15, 60)), np.radians(rng.uniform(-170, 170))
        axis = np.sin(tilt) * np.cos(turn), np.sin(tilt) * np.sin(turn), np.cos(tilt)
        numbers = [*rng.uniform(-40, 40, 3).round(2), *np.round(axis, 6)]
        cells |= {f"{'ABCDEF'[n]}{row}": float(number) for n, number in enumerate(numbers)}
        cells |= {f"{c}{row}": text.format(**turned).replace("#", str(row)) for c, text in formulas.items()}
    return cells


def checked(cells, name, path):
    book = openpyxl.Workbook()
    for place, content in cells.items():
        book.active[place] = content
    book.save(path)
    return check_file(path, Task(machine=name))


@pytest.mark.parametrize("name", CHAINS)
def test_a_right_table_stays_right(name, tmp_path):
    assert checked(table(name), name, tmp_path / "sheet.xlsx").verdict == "right"


@pytest.mark.parametrize(
    ("name", "column", "was", "now"),
    [
        ("ac_table", "J", "+$C$4", "-$C$4"),  # the sign of a pivot
        ("ac_table", "M", "+$C$3", ""),  # not added again
        ("ac_table", "K", "+$D$2", ""),  # as if it were given from elsewhere
        ("ac_table", "N", "-$C$3)", "-$C$4)"),  # the other axis
        ("bc_table", "J", "+$C$4", "+$C$3"),
        ("bc_table", "P", "-$C$2", "+$C$2"),
    ],
)
@pytest.mark.parametrize("rows", [ROWS, [9]], ids=["all rows", "one row"])
def test_a_slip_before_a_number_that_is_0_is_named(name, column, was, now, rows, tmp_path):
    cells = table(name)
    for row in rows:
        assert was in cells[f"{column}{row}"]
        cells[f"{column}{row}"] = cells[f"{column}{row}"].replace(was, now)
    report = checked(cells, name, tmp_path / "sheet.xlsx")
    assert report.verdict == "wrong" and report.faults[0].cell == f"Sheet!{column}{rows[0]}", str(report)


def test_a_number_that_no_machine_has_there_is_named(tmp_path):
    """0 is added to one word and to another, and there is nothing of the kind."""
    cells = table("ac_table") | {"F4": 0}
    for row in ROWS:
        cells[f"O{row}"] += "+$F$4*COS(RADIANS(G#))".replace("#", str(row))
        cells[f"P{row}"] += "+2*$F$4"
    report = checked(cells, "ac_table", tmp_path / "sheet.xlsx")
    assert report.verdict == "unclear" and "Sheet!F4 is 0; if it were not" in str(report)
