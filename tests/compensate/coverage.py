"""How often the truth lies within U, and how often a verdict says that the model fails, on simulated machines."""

import itertools
import tempfile
from pathlib import Path

import numpy as np

from mathpost import machine_file as machines
from mathpost.errors import InputError
from mathpost.shop.compensate.calibrate import calibrate
from tests.compensate import simulated
from tests.compensate.simulated import ARCSEC, SQUARE, Simulated


def _negated(*names):
    def change(columns):
        return columns | {name: -columns[name] for name in names if name in columns}

    return change


def _exchanged(*names):
    def change(columns):
        one, other = [name for name in names if name in columns][:2]
        return columns | {one: columns[other], other: columns[one]}

    return change


def _off(name, row, size):
    def change(columns):
        columns[name][row] += size
        return columns

    return change


def _twice(columns):
    return {name: np.repeat(column, 2) for name, column in columns.items()}


def _wave(amplitude, order=1):
    """A positioning error that is nothing at zero: what is constant belongs to the places of the axes."""
    return lambda q: amplitude * (np.sin(order * q + 0.7) - np.sin(0.7))


def _as_assumed(rng, machine, files):
    """What a machine in good order has although nobody measured it: data/measurements/methods.toml, typed here."""
    machine.square, machine.scale = rng.normal(0, 40e-6, 3), rng.normal(0, 10e-6, 3)
    for name, *_ in simulated.MACHINES[machine.kind]:
        sines, cosines = rng.normal(0, [[4, 4, 2, 2]] * 2) * ARCSEC
        machine.positioning[name] = lambda q, s=sines, c=cosines: sum(
            s[n] * np.sin((n + 1) * q) + c[n] * (np.cos((n + 1) * q) - 1) for n in range(4)
        )
    return {method: how | {"drift": rng.normal(0, 0.005)} for method, how in files.items()}


# Words, whether the model holds, squareness, positioning errors of C and of the tilting axis, and the files;
# without squareness all that nobody measured is drawn.
BALL = {"ball": {}}
CASES = {
    "a ball, square slides": (True, (0, 0, 0), 0, 0, BALL),
    "a ball, slides out of square": (True, SQUARE, 0, 0, BALL),
    "a probe, slides out of square": (True, SQUARE, 0, 0, {"probe": {}}),
    "ball, probe and lasers, all wrong": (True, SQUARE, 4, 8, {"ball": {}, "probe": {}, "laser": {}}),
    "a nest on the table": (True, SQUARE, 0, 0, {"ball": {"sensor": True}}),
    "all as large as assumed": (True, None, 0, 0, BALL),
    "C's positioning of 4 arcsec": (False, (0, 0, 0), 4, 0, BALL),
    "tilt's positioning of 8 arcsec": (False, (0, 0, 0), 0, 8, BALL),
    "both, and out of square": (False, SQUARE, 4, 8, BALL),
    "Z drifts by 6 µm": (False, (0, 0, 0), 0, 0, {"ball": {"drift": 0.006}}),
    "the sign of A or B": (False, (0, 0, 0), 0, 0, {"ball": {"change": _negated("A", "B")}}),
    "C reversed": (False, (0, 0, 0), 0, 0, {"ball": {"change": _negated("C")}}),
    "ex and ey exchanged": (False, (0, 0, 0), 0, 0, {"ball": {"change": _exchanged("ex", "ey")}}),
    "A and C exchanged": (False, (0, 0, 0), 0, 0, {"ball": {"change": _exchanged("A", "B", "C")}}),
    "a chip of 0.15 mm": (False, (0, 0, 0), 0, 0, {"ball": {"change": _off("ex", 7, 0.15)}}),
    "one reading off by 100 mm": (False, (0, 0, 0), 0, 0, {"probe": {"change": _off("x", 7, 100.0)}}),
    "two balls without setup": (False, (0, 0, 0), 0, 0, {"probe": {"setup": False}}),
    "every row twice": (False, (0, 0, 0), 0, 0, {"ball": {"change": _twice}}),
}


def once(case, kind, rng, folder):
    """One machine: what is missed over U, and U, by unknown, and why it was doubted or refused, or nothing."""
    _, square, turn, tilt, files = CASES[case]
    machine = Simulated(kind, rng, square or (0, 0, 0))
    for name, size in (("C", turn), ("A", tilt), ("B", tilt)):
        machine.positioning[name] = _wave(size * ARCSEC, 1 if name == "C" else 2)
    if square is None:
        files = _as_assumed(rng, machine, files)
    (folder / "machine.toml").write_text(simulated.toml(kind), encoding="utf-8")
    nominal, paths = machines.load(folder / "machine.toml"), []
    for method, how in files.items():
        names = [name for name, *_ in simulated.MACHINES[kind]] if method == "laser" else [""]
        for name in names:
            content = (
                simulated.laser(machine, name, rng) if name else getattr(simulated, method)(machine, rng, **how)
            )
            paths.append(folder / f"{method}{name}.csv")
            paths[-1].write_text(content, encoding="utf-8")
    try:
        found = calibrate(nominal, paths)
    except InputError as error:
        return {}, {}, str(error)
    truth = machine.true | dict(zip(("EC0Y", "EB0Z", "EA0Z"), machine.square, strict=True))
    here = machine.off([found.about])[0]  # a table is displayed by so much beside where it is
    for (name, side, *_), (n, letter) in itertools.product(simulated.MACHINES[kind], enumerate("XYZ")):
        if side == simulated.TABLE and f"E{letter}0{name}" in truth:
            truth[f"E{letter}0{name}"] -= here[n]
    ratios = {name: (found[name].value - truth[name]) / found[name].U for name in found.values}
    return ratios, {name: found[name].U for name in found.values}, "; ".join(found.doubts)


def shares(case, count, seed=4, kinds=("table", "mixed", "head")):
    """The share of unknowns within U or with a verdict, and the share of machines that were doubted or refused."""
    rng, inside, doubted = np.random.default_rng(seed), [], []
    with tempfile.TemporaryDirectory() as folder:
        for kind in kinds:
            for _ in range(count):
                ratios, _, doubt = once(case, kind, rng, Path(folder))
                doubted.append(bool(doubt))
                inside += [bool(doubt) or abs(each) <= 1 for each in ratios.values()] or [True]
    return float(np.mean(inside)), float(np.mean(doubted))
