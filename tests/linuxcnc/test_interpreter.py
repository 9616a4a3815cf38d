"""Arcs and drilling cycles in the interpreter of LinuxCNC, rs274, which prints the moves of a program."""

import re
import shutil
import subprocess

import numpy as np
import pytest

from mathpost import postprocess
from mathpost.path import cl as cldata
from tests.post.test_own_words import arcs_file, holes_file, on_machine

pytestmark = pytest.mark.skipif(not shutil.which("rs274"), reason="LinuxCNC is not installed")
NUMBERS = re.compile(r"-?\d+\.\d+|-?\d+")


def interpreted(program, folder):
    """The canonical calls of a program: their names, and their numbers."""
    file = folder / "program.ngc"
    file.write_text(program, encoding="ascii")
    out = subprocess.run(["rs274", "-g", str(file)], capture_output=True, text=True, check=False)
    assert out.returncode == 0 and "PROGRAM_END" in out.stdout, out.stderr[-500:]
    calls = re.findall(r"(STRAIGHT_TRAVERSE|STRAIGHT_FEED|ARC_FEED|SET_FEED_RATE)\((.*)\)", out.stdout)
    return [(name, np.array(NUMBERS.findall(values), float)) for name, values in calls]


def test_holes(tmp_path):
    setup, *vectors = on_machine("ac_table")
    text, drilled = holes_file(np.random.default_rng(8), *vectors)
    calls = interpreted(postprocess(cldata.parse(text), setup, dialect="linuxcnc").program, tmp_path)
    fed = np.array([values[:3] for name, values in calls if name == "STRAIGHT_FEED"])
    bottoms = [cldata.from_arrays([point - depth * vectors[0]], [vectors[0]]) for point, depth, *_ in drilled]
    expected = [postprocess(bottom, setup, dialect="linuxcnc") for bottom in bottoms]
    for result in expected:
        assert np.linalg.norm(fed - result.blocks.words[0, :3], axis=1).min() < 1e-3


def test_arcs(tmp_path):
    """An ARC_FEED in XY: end, centre, and how many turns, negative clockwise; the rise is the third axis."""
    setup, *vectors = on_machine("ac_table")
    text, circles = arcs_file(np.random.default_rng(9), *vectors)
    result = postprocess(cldata.parse(text), setup, dialect="linuxcnc", tcp=True)
    calls = interpreted(result.program, tmp_path)
    arcs = [values for name, values in calls if name == "ARC_FEED"]
    assert len(arcs) >= len(circles)
    for first, second, centre_x, centre_y, turns, *_ in arcs:
        radius = np.hypot(first - centre_x, second - centre_y)
        off = [np.hypot(centre_x - c[0], centre_y - c[1]) + abs(radius - r) for c, r in circles]
        assert min(off) < 1e-3 and abs(turns) == 1
