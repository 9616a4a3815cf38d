"""Arcs, cycles, work offsets and changes of the tool on LinuxCNC: its joints against a reader of the manuals."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mathpost import load_machine, postprocess
from mathpost.kinematics import Kinematics
from mathpost.path import cl as cldata
from mathpost.path.cl import commands
from mathpost.shop.controls.simulation import write_folder
from tests.conftest import DATA
from tests.independent import judge
from tests.independent.machine_model import Model
from tests.independent.reader import Setup, read
from tests.linuxcnc import control
from tests.linuxcnc.test_programs import DIGITS, MISSING
from tests.post.test_own_words import arcs_file, holes_file, on_machine

pytestmark = pytest.mark.skipif(bool(MISSING), reason=MISSING)
LENGTHS = {1: 80.0, 3: 80.0, 5: 112.0, 7: 80.0}  # the kinematics of TCP have one, of tools 3 and 7
SHIFT = {"G55": (14.0, -9.0, 6.0), "G59": (-20.0, 5.0, -12.0)}
NUMBERS = {"G55": 2, "G59": 6}


def job(seed, tcp):
    """CL data with arcs, holes of every kind, two tools and three work offsets."""
    rng = np.random.default_rng(seed)
    lines = ["UNITS/MM"]
    for number, tool, turned in (
        (1, 3, {}),
        (2, 3, {"C": 20.0}),
        (6, 7 if tcp else 5, {"A": 15.0 * (not tcp), "C": -30.0}),
    ):
        _, axis, across, along = on_machine("ac_table", **turned)
        lines += [f"MCSYS/NUM,{number}"]
        lines += [f"LOAD/TOOL,{tool},LENGTH,{LENGTHS[tool]:g}"] * (number != 2)
        made = arcs_file(rng, axis, across, along, 4)[0] if tcp else holes_file(rng, axis, across, along)[0]
        lines += made.splitlines()[1:]
    faster = re.sub(r"MMPM,(\d+)", lambda feed: f"MMPM,{4 * int(feed[1])}", "\n".join(lines))  # a third of the wait
    return cldata.parse(faster + "\n")


class Ran:
    """Programs with TCP and without it, on one start of the control."""

    def __init__(self):
        setup = load_machine("ac_table").with_setup(tool_length=LENGTHS[3])
        offsets = tuple((NUMBERS[name], tuple(np.add(setup.origin, shift))) for name, shift in SHIFT.items())
        setup = replace(setup, offset=1, offsets=offsets, program_head=("G40",))
        self.model = Model(DATA / "machines/ac_table.toml", length=LENGTHS[3], origin=setup.origin)
        self.results = {
            tcp: postprocess(job(4 + tcp, tcp), setup, dialect="linuxcnc", tcp=tcp) for tcp in (False, True)
        }
        with control.folder() as folder:
            write_folder(Kinematics(setup), folder)
            tools = "".join(f"T{tool} P{tool} Z{LENGTHS[tool] - LENGTHS[3]:g}\n" for tool in (3, 5, 7))
            (Path(folder) / "machine.tbl").write_text(tools, encoding="ascii")
            control.build(Path(folder))
            first = ["G53 G0 Z390", "G0 A0 C0"]
            texts = {f"tcp{tcp}": (result.program, first) for tcp, result in self.results.items()}
            self.samples = control.run(Path(folder), texts)

    def noses(self, tcp):
        """Where the nose goes, mm, and the rotary axes, degrees: by the reader of manuals, and on the control."""
        offsets = {name: np.array(shift) for name, shift in SHIFT.items()}
        known = Setup(self.model, offsets=offsets, lengths=LENGTHS, length_on=True)
        wanted = []
        for move in read(self.results[tcp].program, "linuxcnc", known):
            if (
                move.kind != "dwell"
                and not np.isnan([move.nose(self.model, 0.0), move.nose(self.model, 1.0)]).any()
            ):
                some = judge.sample(self.model, [move], least=400 if move.arc else 1, turn=0.5)
                wanted.append(np.c_[some.nose, some.angles])
        wanted = np.concatenate(wanted)
        joints = self.samples[f"tcp{tcp}"][0]
        noses = np.array([self.model.nose_of_slides(row) for row in joints[:, :3]])
        here = np.c_[noses, joints[:, 3:]]
        start = int(np.argmax(np.abs(here - wanted[0]).max(axis=1) < 1e-3))
        # At the safe position the reader does not know where a tool is changed.
        return wanted, np.unique(here[start:][here[start:, 2] < 389.9], axis=0)


@pytest.fixture(scope="module")
def ran():
    return Ran()


def to_polyline(points, line):
    """Distances of points (n, k) to the line through others, the nearest of each."""
    start, along = line[:-1], np.diff(line, axis=0)
    moving = (along != 0).any(axis=1)
    start, along = start[moving], along[moving]
    found = np.empty(len(points))
    for n, point in enumerate(points):
        off = point - start
        t = np.clip((off * along).sum(axis=1) / (along**2).sum(axis=1), 0, 1)
        found[n] = np.linalg.norm(off - t[:, None] * along, axis=1).min()
    return found


@pytest.mark.parametrize("tcp", [False, True], ids=["holes", "arcs under TCP"])
def test_the_joints_go_where_the_words_say(ran, tcp):
    """Nowhere else than on the moves, and to the end of each of them."""
    wanted, here = ran.noses(tcp)
    assert to_polyline(here[::60], wanted).max() < (1e-3 if tcp else DIGITS)
    below = wanted[wanted[:, 2] < 389.9]
    below = below[np.r_[True, (np.diff(below, axis=0) != 0).any(axis=1)]]
    assert max(np.abs(here - end).max(axis=1).min() for end in below[::21]) < 0.3  # of 0.5 mm in a servo period
    bottoms = below[1:-1][(below[1:-1, 2] < below[:-2, 2]) & (below[1:-1, 2] < below[2:, 2])]
    assert len(bottoms) > 20 or tcp
    assert all(np.abs(here - end).max(axis=1).min() < 2e-3 for end in bottoms)


@pytest.mark.parametrize("tcp", [False, True], ids=["holes", "arcs under TCP"])
def test_the_time_of_the_report(ran, tcp):
    """Of what moves; dwells and changes of the tool stand still."""
    joints, _ = ran.samples[f"tcp{tcp}"]
    moving = (np.abs(np.diff(joints, axis=0)).max(axis=1) > 1e-9).sum() * control.PERIOD
    dwells = sum(command.values[0] for _, command in commands(job(4 + tcp, tcp).remarks, "dwell"))
    assert ran.results[tcp].report.time - dwells == pytest.approx(moving, rel=0.02)
