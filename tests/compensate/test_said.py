"""What was once accepted without a word is refused or doubted, where and why; and what controls are told."""

import re
import tracemalloc

import numpy as np
import pytest

from mathpost import machine_file as machines
from mathpost.errors import InputError
from mathpost.shop.compensate import handover, probed, readings
from mathpost.shop.compensate.calibrate import calibrate
from tests.compensate import simulated
from tests.compensate.simulated import ARCSEC, Simulated
from tests.conftest import DATA


def _laser(axis, unit, rows):
    cells = "".join(f"{at},{','.join(f'{each:.6g}' for each in values)}\n" for at, values in rows)
    return f"# method = laser\n# axis = {axis}\n# unit = {unit}\nposition,up1,down1,up2,down2\n{cells}"


def _turned(last=0.0, size=1.0):
    """A table from 0 to 360 in arcsec, which has turned by `last` more when it comes round."""
    rng = np.random.default_rng(5)
    errors = ((at, 3 * np.sin(np.radians(at)) + (at == 360) * last) for at in range(0, 361 if last else 360, 30))
    return _laser("C", "arcsec", [(at, size * (error + rng.normal(0, 0.2, 4))) for at, error in errors])


def _machine():
    machine = Simulated("table", np.random.default_rng(1))
    machine.positioning["C"] = lambda q: 2 * ARCSEC * np.sin(q)
    return machine


def _ball(**how):
    return simulated.ball(_machine(), np.random.default_rng(2), **how)


def _probe(**how):
    return simulated.probe(_machine(), np.random.default_rng(2), **how)


def _further(columns):
    return columns | {"A": columns["A"] + 290}


def _runs(change):
    """Three runs forth and back of C, columns up1, down1, …, of which `change` makes other ones."""
    rng, at = np.random.default_rng(8), np.arange(0, 360, 15.0)
    error = 3 * np.sin(np.radians(at + 20)) + np.sin(np.radians(3 * at))
    columns = np.stack([error + (-0.3 if n % 2 else 0.3) + rng.normal(0, 0.1, len(at)) for n in range(6)], axis=1)
    rows = zip(at, change(columns).round(2), strict=True)
    cells = "".join(f"{at:g},{','.join(f'{each:.2f}' for each in values)}\n" for at, values in rows)
    names = "position,up1,down1,up2,down2,up3,down3"
    return f"# method = laser\n# axis = C\n# unit = arcsec\n{names}\n{cells}"


def _back_as_taken(columns):
    columns[:, 1::2] = columns[::-1, 1::2].copy()
    return columns


THREE = "# method = centre\n# unit = mm\nC,x,y\n0,80,2\n120,-41.732,68.282\n240,-38.268,{y}\n"
SAID = {
    "two balls without setup": (_probe(setup=False), "line 20, column 'x': .*two features need a column setup"),
    "one of three off by 100 mm": (THREE.format(y=29.718), r"tell EX0C to ± 1 mm or better .* found ± \d+ mm"),
    "one of five off by 100 mm": (
        _probe(
            change=lambda columns: {
                name: each[:5] + (name == "y") * np.eye(5)[3] * 100 for name, each in columns.items()
            }
        ),
        "line 7 is 100 mm off from where line 4 and 3 more have it",
    ),
    "a table that does not turn": (
        THREE.format(y=2).replace("-41.732,68.282", "80.001,2").replace("-38.268", "79.999"),
        "stays where it is while C turns by 240°",
    ),
    "runs back in the order of taking": (
        _runs(_back_as_taken),
        "columns down1, down2, down3 agree with those forth from the last row to the first",
    ),
    "a run of the other sign": (
        _runs(lambda columns: columns * [1, 1, -1, -1, 1, 1]),
        "columns up2, down2 agree with the others only if they have the other sign",
    ),
    "copied runs": (
        _runs(lambda columns: columns[:, [0, 1, 0, 1, 4, 5]]),
        "columns up2, down2 repeat others to the last digit",
    ),
    "A from 240": (_ball(change=_further), "column 'A': .*within the travel of A, -120 … 120, .*found 290"),
    "a laser on 700 mm of a slide of ±400": (
        _laser("X", "µm", [(at, [0.01 * at + 0.1 * n for n in range(4)]) for at in range(0, 701, 50)]),
        "line 14, column 'position': .*-400 … 400.*# start = .* of position 0.*found 450",
    ),
    "5 arcsec between 0 and 360": (
        _turned(5.0),
        r"C does not close: after a turn the same place reads [45]\.\d\d arcsec more .*warm it up",
    ),
    "degrees for arcsec": (
        _turned(size=1 / 3600),
        r"no deviation is greater than 0\.\d+ arcsec: is the unit right",
    ),
    "a ball's mm for µm": (_ball().replace("unit = mm", "unit = µm"), "scatter by 0.00.. µm: .*in another unit"),
    "a probe's mm for µm": (_probe().replace("unit = mm", "unit = µm"), "scatter by 0.00.. µm: .*in another unit"),
}


@pytest.mark.parametrize("case", SAID)
def test_what_is_wrong_is_said(case, tmp_path):
    content, words = SAID[case]
    toml = simulated.toml("table").replace('"A"\n', '"A"\nlimits = [-120, 120]\n', 1)
    (tmp_path / "machine.toml").write_text(
        toml
        + "[linear]\nX = { limits = [-400, 400] }\nY = { limits = [-400, 400] }\nZ = { limits = [-800, 400] }\n",
        encoding="utf-8",
    )
    path = tmp_path / "readings.csv"
    path.write_text(content, encoding="utf-8")
    machine = machines.load(tmp_path / "machine.toml")
    try:
        said = calibrate(machine, [path]).doubts
    except InputError as error:
        said = [str(error)]
    assert any(re.search(words, each) for each in said), said


ENTERED = {  # titles of what each control is told, by arrangement
    "table": ["Fanuc", "Haas", "Heidenhain", "LinuxCNC, xyzac-trt-kins", "Siemens, TRAORI", "Siemens, CYCLE800"],
    "mixed": ["Fanuc", "Haas", "Heidenhain", "Siemens, TRAORI", "Siemens, CYCLE800"],
    "head": ["Fanuc", "Heidenhain", "Siemens, TRAORI", "Siemens, CYCLE800"],
}


@pytest.fixture(scope="module")
def told(tmp_path_factory):
    """What controls are told of three machines: the machine, lines, and numbers by what is before them."""
    folder, told = tmp_path_factory.mktemp("told"), {}
    positive = [(n, side, tuple(-x for x in axis), at) for n, side, axis, at in simulated.MACHINES["table"]]
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(simulated.MACHINES, "table", positive)  # as LinuxCNC's module has them
        for kind in ENTERED:
            machine, rng = Simulated(kind, np.random.default_rng(3)), np.random.default_rng(4)
            (folder / "machine.toml").write_text(simulated.toml(kind), encoding="utf-8")
            (folder / "ball.csv").write_text(simulated.ball(machine, rng), encoding="utf-8")
            (folder / "laser.csv").write_text(simulated.laser(machine, "C", rng), encoding="utf-8")
            of = calibrate(machines.load(folder / "machine.toml"), [folder / "ball.csv", folder / "laser.csv"])
            lines = handover.terms(of).splitlines()
            entries = [re.match(r"  (\S.*?)  +(-?\d[\d.]*)", each) for each in lines]
            told[kind] = (machine, lines, {each[1]: each[2] for each in entries if each})
    return told


@pytest.mark.parametrize("kind", ENTERED)
def test_each_control_is_told_in_a_safe_order(kind, told):
    _, lines, _ = told[kind]
    for title in ENTERED[kind]:
        assert any(each.startswith(title) for each in lines), title
    agree = "the place of a table also stands in the parameters of .*, and must be the same there"
    assert kind == "head" or any(re.search(agree, each) for each in lines)
    order = (
        "Back up",
        "Enter the numbers: in one place only",
        "Dry run in the air",
        "Measure again with a different",
        "Only then cut",
    )
    numbered = [each for each in lines if re.match(r"  \d\. ", each)]
    assert [f"  {n}. {words}" for n, words in enumerate(order, 1)] == [
        each[: 5 + len(words)] for each, words in zip(numbered, order, strict=True)
    ]
    text = "\n".join(lines)
    for words in ("name of the *machine* axis", "MD38000", "MD32700", "KinematicsOpt (cycle 451) and CYCLE996"):
        assert words in text


def test_what_controls_are_told_is_one_machine(told):
    """Each control counts from somewhere else: the vectors lead to the same lines of A and C."""
    machine, _, numbers = told["table"]
    (_, _, _, a), (_, _, _, c) = machine.axes

    def vector(*names):
        return np.array([float(numbers[name]) for name in names])

    def row(words, first, count=3):
        return vector(*(words.replace("#", str(n)) for n in range(first, first + count)))

    to_c = row("19700 + #, rotary table position", 0) + row("19703 + #, first to second axis of the table", 0)
    haas = vector(*(f"rotary zero point of C, {letter}" for letter in "XYZ"))
    base, joint, part = row("$TC_CARR#[n]", 4), row("$TC_CARR#[n]", 15), row("$TC_CARR#[n]", 18)
    heidenhain = sum(vector(*(f"Trans {letter} before MachAxis {name}" for letter in "XYZ")) for name in "AC")
    kins = vector(*(f"xyzac-trt-kins.{name}" for name in ("x-rot-point", "y-rot-point", "y-offset", "z-offset")))
    for place in (to_c[:2], haas[:2], (base + joint)[:2], -part[:2], heidenhain[:2], kins[:2]):
        np.testing.assert_allclose(place, c[:2], atol=2e-3)
    np.testing.assert_allclose(base + joint + part, 0, atol=2e-5)
    np.testing.assert_allclose(kins[2:], (a - c)[1:], atol=3e-3)
    np.testing.assert_allclose(base[1:], a[1:], atol=3e-3)


@pytest.mark.parametrize("kind", ENTERED)
def test_axis_vectors_have_the_digits_of_their_uncertainty(kind, told):
    """A tilt of 24 µrad must not be lost in rounding: U has two digits, and the number as many places."""
    machine, lines, _ = told[kind]
    for n in range(7, 13):
        line = next(each for each in lines if each.startswith(f"  $TC_CARR{n}[n] "))
        if found := re.search(r"(-?\d+\.(\d+))  ± (0\.(\d+))", line):
            assert len(found[2]) == len(found[4]) and (int(found[4]) >= 10 or len(found[4]) == 9)
            # Which of the axes is the first is the control's choice, as is the direction.
            true = [axis[(n - 7) % 3] / np.linalg.norm(axis) for _, _, axis, _ in machine.axes]
            off = min(abs(abs(float(found[1])) - abs(each)) for each in true)
            assert off < 2 * float(found[3]) + 1e-9


def test_of_many_rows_that_no_machine_explains_some_are_held_against_each_other(tmp_path):
    """As many distances as pairs of rows would not fit into memory."""
    rng = np.random.default_rng(3)
    rows = rng.uniform([-90, 0, *[-200] * 3], [90, 360, *[200] * 3], (4000, 5))
    lines = (",".join(f"{number:.4f}" for number in row) for row in rows)
    (tmp_path / "many.csv").write_text("\n".join(["# method = probe", "# unit = mm", "A,C,x,y,z", *lines, ""]))
    machine = machines.load(DATA / "machines/ac_table.toml")
    read = readings.read(tmp_path / "many.csv", machine)
    tracemalloc.start()
    (said,) = probed.unexplained(machine, [read])
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert "readings of one feature are up to" in said and most < 100e6  # bytes; 1e9 for all of them
