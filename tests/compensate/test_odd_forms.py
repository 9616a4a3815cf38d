"""A hundred files of readings as people and instruments write them: read right, refused or doubted, never wrong."""

import re
from functools import cache

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mathpost import machine_file as machines
from mathpost.errors import InputError
from mathpost.interface.shell.main import main
from mathpost.shop.compensate.calibrate import calibrate
from mathpost.shop.measure.vocabulary import Names
from tests.compensate import simulated
from tests.compensate.simulated import Simulated

BASES = ("ball", "sensor", "probe", "laser")


def _lines(content):
    head = [line for line in content.splitlines() if line.startswith("#")]
    names, *rows = [line.split(",") for line in content.splitlines() if not line.startswith("#")]
    return head, names, rows


def _join(head, names, rows, end="\n"):
    return "\n".join([*head, ",".join(names), *(",".join(row) for row in rows)]) + end


def _form(change):
    """A form that changes the lines: head, names and rows."""
    return lambda content: _join(*change(*_lines(content)))


def _readings(names):
    return [n for n, name in enumerate(names) if re.match(r"e[xyz]|up|down", name)] or [2, 3, 4]


def _times(names, rows, columns, factor):
    return [[f"{float(x) * factor:.9g}" if n in columns else x for n, x in enumerate(row)] for row in rows]


def _semicolons(content):
    return content.replace(",", ";").replace(".", ",")


def _with(name, values):
    return _form(
        lambda head, names, rows: (head, [*names, name], [[*row, values(n)] for n, row in enumerate(rows)])
    )


def _named(change):
    """The columns' names changed, the word for each being `change` of it."""
    return _form(lambda head, names, rows: (head, [change(name) for name in names], rows))


def _letters(name):
    """A name as a person may write it: a letter with a word, a deviation, a run by its direction."""
    words = {"up": "forward ", "down": "reverse "}
    if re.fullmatch(r"e[xyz]", name):
        return "Δ" + name[1].upper()
    if found := re.fullmatch(r"(up|down)(\d)", name):
        return words[found[1]] + found[2]
    return f"{name}-axis" if name in ("A", "C") else name


def _chinese(name):
    if found := re.fullmatch(r"e([xyz])", name):
        return found[1].upper() + "偏差"
    if found := re.fullmatch(r"(up|down)(\d)", name):
        return f"第{found[2]}次{dict(up='正向', down='反向')[found[1]]}"
    return f"{name}轴角度(°)" if name in ("A", "C") else f"{name}坐标" if name in ("x", "y", "z") else name


def _several_words(name):
    """Phrases, and the signs of runs."""
    if found := re.fullmatch(r"(up|down)(\d)", name):
        return f"Run {found[2]} ({dict(up='+', down='-')[found[1]]})"
    shown = {"x": "Mitte X", "y": "Mitte Y", "z": "Mitte Z", "ex": "Fehler in X", "setup": "Aufspannung"}
    return shown.get(name, "Soll" if name == "position" else name)


def _aligned(content):
    """Columns of one width, names of two words, below a sentence that names two of them."""
    head, names, rows = _lines(content)
    lines = [*head, "the ball, machine coordinates: angles A, C of the table"]
    names = [f"{name} deg" if name in ("A", "C") else name for name in names]
    return "\n".join([*lines, *("".join(f"{cell:>16s}" for cell in row) for row in (names, *rows))]) + "\n"


def _markdown(content):
    """Settings as they are, the table as Markdown writes it."""
    lines = content.splitlines()
    return "".join(f"{x}\n" if x.startswith("#") else f"| {x.replace(',', ' | ')} |\n" for x in lines)


def _marked(row):
    """A row with a degree sign behind its first cell."""
    return [row[0] + "°", *row[1:]]


def _below(unit):
    """The unit in a line below the names, not in a comment."""

    def change(head, names, rows):
        said = ["°" if n < 1 or name in ("A", "C") else "mm" for n, name in enumerate(names)]
        said = [unit if re.match(r"up|down", name) else each for name, each in zip(names, said, strict=True)]
        return [line for line in head if "unit" not in line], names, [said, *rows]

    return _form(change)


FORMS = {  # what is done to the file, and what must come of it: "right", or "said"
    "commas at the ends": (_form(lambda h, n, r: (h, [*n, ""], [[*row, ""] for row in r])), "right"),
    "commas behind the rows": (_form(lambda h, n, r: (h, n, [[*row, "", ""] for row in r])), "right"),
    "semicolons, decimal commas": (_semicolons, "right"),
    "tabs": (lambda c: c.replace(",", "\t"), "right"),
    "a footer of words": (lambda c: c + "end of file\n", "right"),
    "a footer of means": (lambda c: c + "mean,0.001,0.002\n", "right"),
    "a preamble": (lambda c: "Machine: VMC 5\nOperator: nobody\n" + c, "right"),
    "a column of times": (_with("time", lambda n: f"10:{n:02d}"), "right"),
    "a column of temperatures": (_with("Temp", lambda n: "20.1"), "right"),
    "a column of numbers": (_with("No", lambda n: str(n + 1)), "right"),
    "colons in the head": (lambda c: c.replace(" = ", ": "), "right"),
    "settings without #": (lambda c: c.replace("# ", "").replace(" = ", ": "), "right"),
    "great letters": (_form(lambda h, n, r: (h, [x.upper() for x in n], r)), "right"),
    "Windows": (lambda c: c.replace("\n", "\r\n"), "right"),
    "blank lines": (lambda c: c.replace("\n", "\n\n"), "right"),
    "words for letters": (_named(_letters), "right"),
    "Chinese words": (_named(_chinese), "right"),
    "several words": (_named(_several_words), "right"),
    "aligned below a sentence": (_aligned, "right"),
    "a column of texts": (_with("Probe SN", lambda n: "H48812"), "right"),
    "a column of any texts": (_with("Halle", lambda n: "Nord" if n % 2 else ""), "right"),
    "a column of numbers of samples": (_with("Sample no.", lambda n: str(n + 1)), "right"),
    "a column of seconds": (_with("Time s", lambda n: f"{n / 2}"), "right"),
    "a column of numbers of what": (_with("Halle", lambda n: "3.5"), "said"),
    "a column of numbers with commas": (lambda c: _semicolons(_with("Halle", lambda n: "3.5")(c)), "said"),
    "commanded minus actual": (
        _named(lambda x: f"{x} (commanded - read)" if re.match(r"ex|z|up1", x) else x),
        "said",
    ),
    "target minus actual": (_named(lambda x: f"{x} (Soll-Ist)" if re.match(r"ex|z|up1", x) else x), "said"),
    "units in a line below": (_below("arcsec"), "right"),
    "degree signs": (_form(lambda h, n, r: (h, n, [_marked(row) for row in r])), "right"),
    "blanks between": (lambda c: "\n".join(re.sub(",", "   ", line) for line in c.splitlines()) + "\n", "right"),
    "bars between": (_form(lambda h, n, r: (h, ["|" + n[0], *n[1:]], r)), "right"),
    "a markdown table": (_markdown, "right"),
    "dashes for minus": (lambda c: re.sub(r",-", ",–", c), "right"),
    "a column without a name": (
        _form(lambda h, n, r: (h, ["", *n], [[str(k), *row] for k, row in enumerate(r)])),
        "right",
    ),
    "a number more than names": (
        _form(lambda h, n, r: (h, n, [[str(k), *row] for k, row in enumerate(r)])),
        "said",
    ),
    "quotes around settings": (lambda c: re.sub(r"= (\S+)", r'= "\1"', c), "right"),
    "comments after %": (lambda c: c.replace("# ", "% "), "right"),
    "remarks behind rows": (lambda c: c.replace("\n25,", "   # dust?\n25,", 1), "right"),
    "the names again": (_form(lambda h, n, r: (h, n, [*r[:8], n, *r[8:]])), "right"),
    "the file twice": (lambda c: c + c, "said"),
    "only names": (_form(lambda h, n, r: (h, n, [])), "said"),
    "names and units": (_form(lambda h, n, r: (h, n, [["mm"] * len(n)])), "said"),
    "cut inside the last number": (lambda c: c[:-3], "said"),
    "cut inside the last row": (lambda c: c[:-1].rpartition(",")[0], "said"),
    "every row twice": (_form(lambda h, n, r: (h, n, [row for row in r for _ in range(2)])), "said"),
    "a row of zeros at the end": (_form(lambda h, n, r: (h, n, [*r, ["0"] * len(n)])), "said"),
    "no unit": (lambda c: re.sub("# unit.*\n", "", c), "said"),
    "in inches, places not said": (lambda c: re.sub("unit = .*", "unit = in", c), "said"),
    "a thousand times too small": (_form(lambda h, n, r: (h, n, _times(n, r, _readings(n), 1e-3))), "said"),
    "outside the travel": (
        _form(
            lambda h, n, r: (
                h,
                n,
                [[str(float(r[0][0]) + 270 if k == 5 else row[0]), *row[1:]] for k, row in enumerate(r)],
            )
        ),
        "said",
    ),
    "a word for a number": (_form(lambda h, n, r: (h, n, [["n/a", *r[0][1:]], *r[1:]])), "said"),
    "a misspelt column": (_form(lambda h, n, r: (h, [*n[:-1], n[-1] + "q"], r)), "said"),
    "the log of a control": (lambda c: "TCHPR451.TXT\n" + c, "said"),
}


@cache
def plain(method):
    rng = np.random.default_rng(12)
    machine = Simulated("table", rng)
    machine.positioning["A"] = lambda q: 6 * simulated.ARCSEC * np.sin(2 * q)
    if method == "laser":
        return simulated.laser(machine, "A", rng)
    return (
        simulated.probe(machine, rng)
        if method == "probe"
        else simulated.ball(machine, rng, sensor=method == "sensor")
    )


@pytest.fixture(scope="module")
def with_travel(tmp_path_factory):
    """The machine that was read, with travel of A."""
    path = tmp_path_factory.mktemp("machine") / "machine.toml"
    limits = simulated.toml("table").replace('"A"\n', '"A"\nlimits = [-120, 120]\n', 1)
    path.write_text(limits, encoding="utf-8")
    return machines.load(path)


@pytest.fixture(scope="module", params=BASES)
def base(request, with_travel, tmp_path_factory):
    """The plain file of a method, and the numbers that are found in it."""
    content = plain(request.param)
    right, nothing = outcome(content, with_travel, tmp_path_factory.mktemp("plain") / "plain.csv")
    assert nothing == ""
    return content, right


def outcome(content, machine, path):
    """The numbers that were found, and whether the file was refused, doubted or remarked upon."""
    path.write_bytes(content.encode("utf-8"))
    try:
        found = calibrate(machine, [path])
    except InputError as error:
        return None, str(error)
    numbers = [*found.values.values(), *(x for each in found.positioning for x in each.value)]
    return np.array(numbers), "; ".join([*found.doubts, *(n for n in found.notes if "cut off" in n)])


@pytest.mark.parametrize("form", FORMS)
def test_read_right_refused_or_doubted(base, form, with_travel, tmp_path):
    content, right = base
    change, expected = FORMS[form]
    numbers, said = outcome(change(content), with_travel, tmp_path / "odd.csv")
    if expected == "right":
        assert said == "" and numbers == pytest.approx(right, abs=1e-9)
    else:
        assert said and len(said) < 2000


@pytest.mark.parametrize(
    ("wanted", "cells"),
    [
        ("dial angle R z C", {"Winkel": "angle", "Radius": "R", "Höhe": "z", "Uhr": "dial", "radius at z": None}),
        ("bar A C x y z setup run", {"Deviation um": "bar", "Ball X": "x", "Run": "run", "max deviation": None}),
        (
            "axial lateral angle L length B",
            {"quer": "lateral", "Länge": None, "Werkzeuglänge": "length"},
        ),
        ("ex ey ez x y z A C setup", {"Aufspannung": "setup", "pose x": None, "Écart X": "ex", "Nest Z": "z"}),
        ("x y z A C setup", {"Écart X": None, "tool x": None, "x old": None, "Centre X": "x", "Tisch C": "C"}),
        (
            "reading position up1 down1 A",
            {"Positioning error": "reading", "Run 1 (-)": "down1", "-1": None},
        ),
    ],
)
def test_what_headings_mean(wanted, cells):
    names = Names(wanted.split())
    assert {cell: names.find(cell)[0] for cell in cells} == cells


@pytest.mark.parametrize(("base", "matters"), [("sensor", False), ("ball", True)])
def test_where_a_sensor_is_set_to_zero(base, matters, tmp_path):
    """A constant turns with a nest on the table, as its place does; in the spindle it moves the axes."""
    path = tmp_path / "machine.toml"
    path.write_text(simulated.toml("table"), encoding="utf-8")
    head, names, rows = _lines(plain(base))
    column = names.index("ex")
    moved = [[*row[:column], f"{float(row[column]) + 0.05:.9g}", *row[column + 1 :]] for row in rows]
    machine = machines.load(path)
    before, after = (outcome(_join(head, names, each), machine, tmp_path / "x.csv")[0] for each in (rows, moved))
    assert np.abs(after - before).max() == pytest.approx(0.05 if matters else 0, abs=1e-4)


LASER = """HEADER::
File Type: LINEAR
Owner: RENISHAW PLC
Version no: 1

TARGET DATA::
Filetype: ISO
Target-count: 7
Targets :
   -300.0000  -200.0000  -100.0000  0.0000  100.0000
    200.0000  300.0000
Flags: 0 0 2 0

USER-TEXT::
Machine: mill
Axis: X

RUNS::
Run-count: 2

DEVIATIONS::
Run Target Data:
{}
EOF::
"""


def test_the_target_data_of_a_laser(tmp_path):
    there = [f"  1   {n}   {n * 0.5:.3f}" for n in range(1, 8)]
    back = [f"  2   {n}   {n * 0.5 + 0.4:.3f}" for n in range(7, 0, -1)]
    again = [line.replace("  1 ", "  3 ", 1).replace("0 ", "0 ") for line in there]
    home = [line.replace("  2 ", "  4 ", 1) for line in back]
    path = tmp_path / "x.rtl"
    path.write_text(LASER.format("\n".join([*there, *back, *again, *home])), encoding="utf-8")
    found = calibrate(machines.load("ac_table"), [path], sigma=0.2)
    (axis,) = found.positioning
    assert axis.joint == 0 and axis.at.tolist() == [-300, -200, -100, 0, 100, 200, 300]
    assert 1e3 * axis.value == pytest.approx(0.5 * np.arange(1, 8) + 0.2)
    assert 1e3 * axis.reversal == pytest.approx(0.4)
    path.write_text(LASER.format("\n".join(there[:-1])), encoding="utf-8")
    with pytest.raises(
        InputError, match="a deviation of each of 7 targets in each run, found 6 in 1 runs: cut off"
    ):
        calibrate(machines.load("ac_table"), [path])


def test_a_laser_that_was_set_to_zero_elsewhere(tmp_path):
    machine = machines.from_dict(
        {
            "name": "m", "source": "s", "workpiece": {"origin": [0, 0, 0]}, "tool": {"axis": [0, 0, 1]},
            "linear": {"X": {"limits": [-400, 400]}},
            "rotary": [
                {"name": "A", "carries": "workpiece", "axis": [-1, 0, 0], "point": [0, 0, 0]},
                {"name": "C", "carries": "workpiece", "axis": [0, 0, -1], "point": [0, 0, 0]},
            ],
        }
    )  # fmt: skip
    path = tmp_path / "x.csv"
    rows = "".join(f"{at},{at / 100},{at / 100}\n" for at in range(0, 701, 100))
    path.write_text(
        f"# method = laser\n# axis = X\n# unit = µm\n# sigma = 0.3\nposition,up1,down1\n{rows}", encoding="utf-8"
    )
    with pytest.raises(
        InputError, match=r"line 11.*machine coordinates within the travel of X, -400 … 400.*# start"
    ):
        calibrate(machine, [path])
    assert calibrate(machine, [path], start=-350).positioning[0].at[0] == -350


def test_the_centre_of_a_table_from_bare_positions(tmp_path):
    angle = np.deg2rad([0, 120, 240])
    x, y = 300.012 + 80 * np.cos(angle), -120.006 - 80 * np.sin(angle)  # an ISO table turns against the word
    rows = "".join(f"{a:.0f},{one:.4f},{two:.4f}\n" for a, one, two in zip(np.rad2deg(angle), x, y, strict=True))
    path = tmp_path / "centre.csv"
    path.write_text("# method = centre\n# unit = mm\n# sigma = 0.002\nC,x,y\n" + rows, encoding="utf-8")
    found = calibrate(machines.load("ac_table"), [path])
    assert found.fits and found.machine.rotary[1].point[:2] == pytest.approx((300.012, -120.006), abs=1e-3)
    assert "centre of C: X 300.0120 ±" in str(found)


def test_the_centre_is_first_told_where_it_was_measured(tmp_path):
    """An axis that leans by 200 µrad about Y, and a ball 150 mm above the point that the file has."""
    rng, foot, axis = np.random.default_rng(5), np.array([0.02, -0.03, 0]), np.array([2e-4, 0, 1])
    rows = []
    for degrees in range(0, 360, 45):
        turn = Rotation.from_rotvec(-np.deg2rad(degrees) * axis / np.linalg.norm(axis))
        place = foot + turn.apply(np.array([100.0, 0, 150]) - foot) + rng.normal(0, 1e-3, 3)
        rows.append(f"{degrees},{','.join(f'{x:.4f}' for x in place)}\n")
    path = tmp_path / "centre.csv"
    path.write_text("# method = centre\n# unit = mm\nC,x,y,z\n" + "".join(rows), encoding="utf-8")
    measured, in_file = re.findall(
        r"centre of C: X (\S+) .* mm,(.*);", str(calibrate(machines.load("ac_table"), [path]))
    )
    assert (
        float(measured[0]) == pytest.approx(0.05, abs=2e-3) and "where it was measured, at Z 150.0" in measured[1]
    )
    assert float(in_file[0]) == pytest.approx(0.02, abs=8e-3) and "the machine file's point" in in_file[1]


# What instruments and controls write


@pytest.mark.parametrize(
    ("content", "instead"),
    [
        ("<?xml version='1.0'?>\n<html>", "save it as CSV"),
        ("<TEST_SPEC NAME='XY'><PLANE TEST_PLANE='XY'/>\n", "the layout of .b5r is not public: a table of the bar"),
        ("Log of CYCLE996\n_OVR[1] = 2\n", "write the ball's centres, method probe"),
        ("TCHPRAUTO.HTML\n", "probe the ball, method probe"),
        ("PK\x03\x04", "save its sheet as CSV"),
    ],
)
def test_a_file_without_readings_is_told_what_to_write_instead(content, instead, tmp_path):
    path = tmp_path / "log.txt"
    path.write_text(content, encoding="utf-8")
    with pytest.raises(InputError, match=re.escape(instead)):
        calibrate(machines.load("ac_table"), [path])


# Travel, copies, one reading among many


def test_places_that_no_slide_reaches_are_asked_about(tmp_path):
    path = tmp_path / "machine.toml"
    path.write_text(simulated.toml("table") + "[linear]\nX = { limits = [-400, 400] }\n", encoding="utf-8")
    machine, (head, names, rows) = machines.load(path), _lines(plain("probe"))
    for method, table in (("probe", (head, names, rows)), ("ball", _lines(plain("ball")))):
        column = table[1].index("x")
        shifted = [[*row[:column], f"{float(row[column]) - 333.5:.9g}", *row[column + 1 :]] for row in table[2]]
        path.write_text(_join(table[0], table[1], shifted), encoding="utf-8")
        with pytest.raises(
            InputError, match=r"column 'x': expected a place that the tip reaches: X within -400 … 400"
        ):
            calibrate(machine, [path])
        numbers, said = outcome(_join([*table[0], "# start = 333.5 0 0"], table[1], shifted), machine, path)
        assert said == "" and numbers == pytest.approx(outcome(plain(method), machine, path)[0], abs=1e-7)


def test_the_slide_of_a_longer_tool_stands_higher(tmp_path):
    path, stands = tmp_path / "machine.toml", []
    path.write_text(simulated.toml("table") + "[linear]\nZ = { limits = [-2000, -1000] }\n", encoding="utf-8")
    machine, (head, names, rows) = machines.load(path), _lines(plain("probe"))
    column = names.index("length")
    for length in ("120", "150"):
        table = [[*row[:column], length, *row[column + 1 :]] for row in rows]
        path.write_text(_join(head, names, table), encoding="utf-8")
        with pytest.raises(InputError, match="Z within") as refused:
            calibrate(machine, [path])
        stands.append(float(re.search(r"found Z (\S+)", str(refused.value))[1]))
    assert stands[1] - stands[0] == pytest.approx(30)


def test_the_same_readings_in_two_files(tmp_path):
    machine = machines.load("ac_table")
    one = machines.data_file("measurements/ball_c_axis.csv")
    other = tmp_path / "again.csv"
    other.write_text(one.read_text(encoding="utf-8"), encoding="utf-8")
    assert any("its readings all stand in" in doubt for doubt in calibrate(machine, [one, other]).doubts)


def test_an_absurd_reading_is_named(tmp_path):
    head, names, rows = _lines(plain("probe"))
    rows[4][names.index("y")] = f"{float(rows[4][names.index('y')]) + 100:.6f}"
    path = tmp_path / "probe.csv"
    path.write_text(simulated.toml("table"), encoding="utf-8")
    machine = machines.load(path)
    path.write_text(_join(head, names, rows), encoding="utf-8")
    with pytest.raises(InputError, match="found ± .* mm; .*probe.csv, line 8, column 'y' fits least"):
        calibrate(machine, [path])


def test_without_one_reading(tmp_path):
    """The note on leave-one-out says what a second estimate without the row says."""
    head, names, rows = _lines(plain("ball"))
    path = tmp_path / "ball.csv"
    path.write_text(simulated.toml("table"), encoding="utf-8")
    machine = machines.load(path)

    def found(rows):
        path.write_text(_join([*head, "# sigma = 0.0005"], names, rows), encoding="utf-8")
        return calibrate(machine, [path])

    whole = found(rows)
    said = re.search(r"more than ([\d.]+) of its U \((\w+); .*, line (\d+), column 'e[xyz]'", "".join(whole.notes))
    name, row = said[2], int(said[3]) - len(head) - 3
    less = found(rows[:row] + rows[row + 1 :])
    moved = abs(less[name].value - whole[name].value) / whole[name].U
    assert 0.3 * float(said[1]) < moved < 2 * float(said[1])  # the row has three readings, the note is of one


def test_one_place_three_times_tells_nothing(tmp_path):
    path = tmp_path / "centre.csv"
    path.write_text("# method = centre\n# unit = mm\nC,x,y\n0,80.001,2\n0,80,2.001\n0,80.002,2\n", encoding="utf-8")
    with pytest.raises(InputError, match="expected readings at several angles of an axis, found none that tells"):
        calibrate(machines.load("ac_table"), [path])


@pytest.mark.parametrize(
    ("at", "fits"), [("0.001,0.002 0,0.001 0.002,0", True), ("80.001,2 80,2.001 80.002,2", False)]
)
def test_a_feature_that_does_not_move(at, fits, tmp_path):
    """It is on the axis, or the table did not turn: a doubt where the axis would be far from where it was."""
    path = tmp_path / "centre.csv"
    rows = [f"{angle},{place}\n" for angle, place in zip((0, 120, 240), at.split(), strict=True)]
    path.write_text("# method = centre\n# unit = mm\nC,x,y\n" + "".join(rows), encoding="utf-8")
    found = calibrate(machines.load("ac_table"), [path])
    assert found.fits == fits
    assert any("it is on the axis, or the table did not turn" in each for each in (*found.doubts, *found.notes))
    assert any("z was not read" in each for each in found.notes)


@pytest.mark.parametrize(("label", "factor"), [("x (cm)", 0.1), ("x (m)", 1e-3), ("A (gon)", 1 / 0.9)])
def test_units_behind_a_name_are_obeyed(label, factor, tmp_path):
    head, names, rows = _lines(plain("ball"))
    path = tmp_path / "ball.csv"
    path.write_text(simulated.toml("table"), encoding="utf-8")
    machine, column = machines.load(path), names.index(label[0])
    changed = _times(names, rows, [column], factor)
    content = _join(head, [label if n == column else name for n, name in enumerate(names)], changed)
    numbers, said = outcome(content, machine, path)
    assert said == "" and numbers == pytest.approx(outcome(plain("ball"), machine, path)[0], abs=1e-7)


def test_a_centre_from_two_readings_half_a_turn_apart(tmp_path, capsys):
    """The middle of both, and no word that they fit: nothing is to spare."""
    path = tmp_path / "two.csv"
    path.write_text("angle,x,y\n0,110,20.004\n180,-69.99,-20.002\n", encoding="utf-8")
    main(["calibrate", "bc_table", str(path), *"--method centre --axis C --unit mm --sigma 0.002".split()])
    said = capsys.readouterr().out
    assert f"centre of C: X {(110 - 69.99) / 2:.4f} ± " in said and f"Y {(20.004 - 20.002) / 2:.4f} ± " in said
    assert said.startswith("NOTHING CHECKS THE READINGS") and "where it was measured" in said
