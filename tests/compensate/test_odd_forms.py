"""A hundred files of readings as people and instruments write them: read right, refused or doubted, never wrong."""

import re
from functools import cache

import numpy as np
import pytest

from mathpost import machine as machines
from mathpost.compensate.calibrate import calibrate
from mathpost.errors import InputError
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
    "units in a line below": (_below("arcsec"), "right"),
    "degree signs": (_form(lambda h, n, r: (h, n, [_marked(row) for row in r])), "right"),
    "blanks between": (lambda c: "\n".join(re.sub(",", "   ", line) for line in c.splitlines()) + "\n", "right"),
    "bars between": (_form(lambda h, n, r: (h, ["|" + n[0], *n[1:]], r)), "said"),
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
    "a word for a number": (_form(lambda h, n, r: (h, n, [[*r[0][:-1], "n/a"], *r[1:]])), "said"),
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
@pytest.mark.parametrize("base", BASES)
def test_read_right_refused_or_doubted(base, form, tmp_path):
    path = tmp_path / "machine.toml"
    limits = simulated.toml("table").replace('"A"\n', '"A"\nlimits = [-120, 120]\n', 1)
    path.write_text(limits, encoding="utf-8")
    machine = machines.load(path)
    right, nothing = outcome(plain(base), machine, tmp_path / "plain.csv")
    assert nothing == ""
    change, expected = FORMS[form]
    numbers, said = outcome(change(plain(base)), machine, tmp_path / "odd.csv")
    if expected == "right":
        assert said == "" and numbers == pytest.approx(right, abs=1e-9)
    else:
        assert said and len(said) < 2000


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
    x, y = 350.012 + 80 * np.cos(angle), -120.006 - 80 * np.sin(angle)  # an ISO table turns against the word
    rows = "".join(f"{a:.0f},{one:.4f},{two:.4f}\n" for a, one, two in zip(np.rad2deg(angle), x, y, strict=True))
    path = tmp_path / "centre.csv"
    path.write_text("# method = centre\n# unit = mm\n# sigma = 0.002\nC,x,y\n" + rows, encoding="utf-8")
    found = calibrate(machines.load("ac_table"), [path])
    assert found.fits and found.machine.rotary[1].point[:2] == pytest.approx((350.012, -120.006), abs=1e-3)
    assert "centre of C: X 350.0120 ±" in str(found)
