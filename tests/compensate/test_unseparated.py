"""What `calibrate` says of unknowns that readings cannot separate, against ranks and null spaces.

The readings' derivatives are finite differences of `simulated`, which shares nothing with the package, and the
null space is that of a singular value decomposition. Nothing here knows in which order the package seeks unknowns.
"""

import re
import tomllib
from dataclasses import dataclass, replace
from functools import cache
from itertools import combinations, product
from pathlib import Path

import numpy as np
import pytest

from mathpost import machine_file as machines
from mathpost.shop.compensate.calibrate import calibrate
from tests.compensate import simulated
from tests.compensate.simulated import LENGTH, Simulated

DATA = tomllib.loads(Path(__file__).with_name("unseparated.toml").read_text(encoding="utf-8"))
simulated.MACHINES.update(DATA["machines"])
ZERO = 1e-7  # of the greatest: a singular value, or a share of an unknown in a combination
NOISE = 5e-4  # mm
SQUARENESS = ("EC0Y", "EB0Z", "EA0Z")
AND = re.compile("(?:,| and) (?=move|take|turn)")
SENTENCE = re.compile(
    r"these readings cannot separate (\w+) from (.+?)\.(?: Also (.+)\.)? (\w+) is taken for 0 ± (.+), which is in U"
)


@dataclass(frozen=True)
class Set:
    """Readings: each row is a place, a tool and the angles of all axes; `columns` is what is read of each."""

    kind: str
    method: str
    columns: str
    place: np.ndarray
    length: np.ndarray
    angles: dict[str, np.ndarray]

    @classmethod
    def of(cls, said):
        axes = [name for name, *_ in simulated.MACHINES[said["machine"]]]
        turned = product(*(np.deg2rad(said["angles"].get(name, [0.0])) for name in axes))
        poses = product(said["places"], said.get("lengths", [LENGTH]), [*turned])
        place, length, angles = (np.array(each, dtype=float) for each in zip(*poses, strict=True))
        named = dict(zip(axes, angles.T, strict=True))
        return cls(said["machine"], said.get("method", "ball"), said.get("columns", "xyz"), place, length, named)

    def shown(self, machine, aside=0.0):
        """What the machine shows, (rows, 3)."""
        gap = machine.gap(self.place, self.angles, self.length, aside)
        if self.method != "tip":
            return gap + (machine.slides(self.place, self.angles, self.length) if self.method == "probe" else 0.0)
        upright = {name: 0 * angle for name, angle in self.angles.items()}
        return machine.gap(self.place, upright, self.length, aside) - gap

    def file(self, machine, rng):
        shown = self.shown(machine) + NOISE * rng.standard_normal(self.place.shape)
        columns = {name: np.rad2deg(angle) for name, angle in self.angles.items()}
        lengths = {"L": 180 + self.length} if self.method == "tip" else {"length": self.length}
        places = dict(zip("xyz", self.place.T, strict=True)) if self.method == "ball" else {}
        numbers = np.unique(self.place, axis=0, return_inverse=True)[1].ravel().astype(float)
        setup = {"setup": numbers} if self.method == "probe" else {}
        names = {axis: f"e{axis}" if self.method == "ball" else axis for axis in self.columns}
        read = {name: shown[:, "xyz".index(axis)] for axis, name in names.items()}
        tip = {"axis": "B", "positive": "tip"} if self.method == "tip" else {}
        return simulated.text(
            {"method": self.method, "unit": "mm"} | tip, columns | lengths | places | setup | read
        )


def _unknowns(kind):
    """Names, and what each does to a machine for one unit: two places, two tilts of each axis, the spindle."""
    found = {}
    for number, (name, _, axis, _) in enumerate(simulated.MACHINES[kind]):
        axis = np.array(axis) / np.linalg.norm(axis)
        if 1 in np.abs(axis):
            across = {"XYZ"[n]: np.eye(3)[n] for n in np.flatnonzero(axis == 0)}
        else:  # the only oblique ones here are square to X
            across = {"1": np.eye(3)[0], "2": np.cross(axis, np.eye(3)[0])}
        for letter, direction in across.items():
            found[f"E{letter}0{name}"] = ("offset", number, direction)
            found[f"E{dict(zip('XYZ12', 'ABC34', strict=True))[letter]}0{name}"] = ("tilt", number, direction)
    if any(side == "tool" for _, side, *_ in simulated.MACHINES[kind]):
        found |= {f"E{letter}0S": ("lean", 0, np.eye(3)[n]) for n, letter in enumerate("AB")}
    return found | {name: ("squareness", n, None) for n, name in enumerate(SQUARENESS)}


def _machine(kind, what, size):
    return _moved(Simulated(kind, np.random.default_rng(0), size=(0, 0)), what, size)


def _moved(machine, what, size):
    part, number, direction = what
    if part == "squareness":
        machine.square = size * np.eye(3)[number]
    elif part == "lean":
        machine.lean = size * direction
    else:
        name, side, axis, point = machine.axes[number]
        moved = (
            (axis, point + size * direction)
            if part == "offset"
            else (axis + size * np.cross(direction, axis), point)
        )
        machine.axes[number] = (name, side, *moved)
    return machine


def _design(sets):
    """Derivatives of all readings by the unknowns, and by where the balls stand; a dict, (readings,) each."""
    kind = sets[0].kind
    ideal = _machine(kind, ("offset", 0, np.zeros(3)), 0)
    slides = [simulated.encoders(ideal.slides(e.place, e.angles, e.length), e.length) for e in sets]
    slides = [np.repeat(each, len(e.columns), axis=0) for each, e in zip(slides, sets, strict=True)]
    _, y, z = np.concatenate(slides).mean(axis=0)
    # A slide out of square turns about the middle of where it was read, not about its zero.
    about = {"EC0Y": (y, 0, 0), "EB0Z": (-z, 0, 0), "EA0Z": (0, z, 0)}

    def flat(slopes):
        return np.concatenate(
            [s[:, ["xyz".index(c) for c in e.columns]].ravel() for s, e in zip(slopes, sets, strict=True)]
        )

    found, places = {}, []
    for name, what in _unknowns(kind).items():
        step = 1e-3 if what[0] == "offset" else 1e-5
        one, other = (_machine(kind, what, size) for size in (step, -step))
        slopes = [(e.shown(one) - e.shown(other)) / (2 * step) for e in sets]
        found[name] = flat(
            [s - np.multiply(about.get(name, 0.0), e.method != "tip") for s, e in zip(slopes, sets, strict=True)]
        )
    for number, each in enumerate(sets):
        balls, still = np.column_stack([each.place, each.length]), each.shown(ideal)
        for ball in np.unique(balls, axis=0):
            for direction in np.eye(3):
                aside = (balls == ball).all(axis=1)[:, None] * direction
                slopes = [np.zeros(e.place.shape) for e in sets]
                slopes[number] = each.shown(ideal, aside) - still
                places.append(flat(slopes))
    return found, np.array(places).T


def _rank(columns):
    matrix = np.column_stack(columns)
    lengths = np.linalg.norm(matrix, axis=0)
    matrix = matrix[:, lengths > ZERO] / lengths[lengths > ZERO]
    return int((np.linalg.svd(np.linalg.qr(matrix, mode="r"), compute_uv=False) > ZERO).sum()) if matrix.size else 0


def _left_open(design, places):
    """Names of the unknowns that the readings leave open, and of those of which they have no trace."""
    matrix = np.column_stack([*design.values(), places])
    lengths = np.linalg.norm(matrix, axis=0)
    matrix = np.linalg.qr(matrix / np.where(lengths > ZERO, lengths, np.inf), mode="r")
    _, sizes, rows = np.linalg.svd(matrix)
    nothing = rows[np.append(sizes, np.zeros(len(rows) - len(sizes))) < ZERO]
    traceless = {name for name, length in zip(design, lengths, strict=False) if length <= ZERO}
    part = np.linalg.norm(nothing, axis=0)
    return {name for name, share in zip(design, part, strict=False) if share > ZERO} - traceless, traceless


def _again(each, parts):
    """The readings of a set as the parts of a sentence advise to take them."""
    for part in parts:
        if found := re.fullmatch(r"move the ball 200 mm along the axis of (\w)", part):
            axis = next(np.array(axis) for name, _, axis, _ in simulated.MACHINES[each.kind] if name == found[1])
            each = replace(each, place=each.place + 200 * axis / np.linalg.norm(axis))
        elif part == "take a tool 200 mm longer":
            each = replace(each, length=each.length + 200)
        elif found := re.fullmatch(r"turn (\w) to four angles", part):
            count = len(each.length)
            several = {name: np.repeat(angle, 4) for name, angle in each.angles.items()}
            several[found[1]] = np.tile(np.deg2rad([-50.0, -10, 20, 60]), count)
            each = replace(
                each, place=np.repeat(each.place, 4, axis=0), length=np.repeat(each.length, 4), angles=several
            )
        else:
            names = re.fullmatch(r"read (.+)", part)[1].replace("e", "")
            each = replace(each, columns="".join(sorted({*each.columns, *re.split(", | and ", names)})))
    return each


@cache
def _calibrated(number, folder):
    """A set, what `calibrate` finds on a machine as wrong as is assumed, and how wrong that is."""
    each, rng = Set.of(DATA["set"][number]), np.random.default_rng(number)
    machine = Simulated(each.kind, rng, size=(0, 0))
    true = {name: rng.normal(0, _assumed(name)) for name in _unknowns(each.kind) if name not in SQUARENESS}
    for name, size in true.items():
        _moved(machine, _unknowns(each.kind)[name], size)
    (folder / "machine.toml").write_text(simulated.toml(each.kind), encoding="utf-8")
    (folder / "readings.csv").write_text(each.file(machine, rng), encoding="utf-8")
    return each, calibrate(machines.load(folder / "machine.toml"), [folder / "readings.csv"]), true


@pytest.fixture(
    params=range(len(DATA["set"])), ids=lambda n: f"{DATA['set'][n]['machine']}, {DATA['set'][n]['words']}"
)
def measured(request, tmp_path_factory):
    return _calibrated(request.param, tmp_path_factory.getbasetemp())


@pytest.fixture
def readings(measured):
    """A set, what `calibrate` says of the unknowns that it leaves open, and these sentences taken apart."""
    each, found, _ = measured
    taken_apart = {name: SENTENCE.fullmatch(why) for name, why in found.assumed.items()}
    return each, found.assumed, {name: parts for name, parts in taken_apart.items() if parts}


def test_what_is_named_is_what_the_readings_leave_open(readings):
    each, assumed, sentences = readings
    design, places = _design([each])
    left, traceless = _left_open(design, places)
    assert {name for name, why in assumed.items() if why.startswith("not measured")} == traceless
    named = set()
    for name, found in sentences.items():
        others = [] if found[2] == "where the ball stands" else re.split(", | and ", found[2])
        named |= {name, *others}
        # Together they are one unknown too many, and without any of them they are not.
        columns = [design[other] for other in (name, *others)]
        alone = _rank([places])
        assert found[1] == found[4] == name
        assert _rank([*columns, places]) - alone == len(others)
        for n in range(len(columns)):
            assert _rank([*columns[:n], *columns[n + 1 :], places]) - alone == len(others)
    assert named == left


def _assumed(name):
    """[unmeasured] of data/measurements/methods.toml, typed here: mm and radians."""
    return 20e-3 if name[1] in "XYZ12" else 40e-6 if name in SQUARENESS else 50e-6


def _deviation(design, places, name):
    """The standard uncertainty of an unknown, its noise and what is assumed of the others known."""
    left, traceless = _left_open(design, places)
    names = [each for each in design if each not in traceless]
    # What the readings leave open is as small as a machine in good order has it.
    known = [each for each in names if each in left or each in SQUARENESS]
    rows = np.zeros((len(known), len(names) + places.shape[1]))
    for row, each in enumerate(known):
        rows[row, names.index(each)] = NOISE / _assumed(each)
    matrix = np.vstack([np.column_stack([*(design[each] for each in names), places]), rows])
    lengths = np.linalg.norm(matrix, axis=0)
    inverse = np.linalg.pinv(matrix / np.where(lengths > ZERO, lengths, np.inf))
    row = names.index(name)
    return NOISE * np.linalg.norm(inverse[row]) / lengths[row]


def test_what_is_advised_separates_them(readings):
    each, _, sentences = readings
    for name, found in sentences.items():
        assert found[3], found[0]
        for words in found[3].split(", or "):
            both, crossed = re.fullmatch("(.+?)(, in all combinations)?", words).groups()
            parts = AND.split(both)
            taken = [some for n in range(1, len(parts)) for some in combinations(parts, n)] if crossed else []
            design, places = _design([each, *(_again(each, some) for some in (*taken, parts))])
            assert name not in _left_open(design, places)[0], words
            assert _deviation(design, places, name) <= _assumed(name) / 2, words


def test_what_is_left_open_is_in_the_uncertainty(measured):
    """In U is 95 %, and 23 machines are no statistics; three times U is what nothing may exceed without a word."""
    _, found, true = measured
    over = {name: abs(found[name].value - true[name]) / found[name].U for name in true if name in found.values}
    assert max(over.values()) < 3 or not found.fits, over
