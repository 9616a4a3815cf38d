"""Rapid traverse and feeds of programs of any post, against the CL data; expected by hand."""

import re

import numpy as np
import pytest

from mathpost import load_machine
from mathpost.path import cl
from mathpost.shop.post.verify import verify
from tests.post import slips

PATH = """FEDRAT/600,MMPM
GOTO/0,0,0,0,0,1
GOTO/50,0,0,0,0,1
GOTO/50,20,0,0,0,1
RAPID
GOTO/50,20,30,0,0,1
RAPID
GOTO/0,0,30,0,0,1
FEDRAT/300,MMPM
GOTO/0,0,0,0,0,1
"""
PROGRAM = """G21 G17 G90 G94
G0 X0. Y0. Z0. A0. C0.
G1 X50. F600.
Y20.
G0 Z30.
X0. Y0.
G1 Z0. F300.
M30
"""


def judged(text, path=PATH):
    return verify(text, load_machine("ac_table"), "fanuc", cl=cl.parse(path))


def of_lines(found, rows):
    return [(found.line(block), record + 1, *rest) for block, record, *rest in rows]


def test_a_right_program():
    found = judged(PROGRAM)
    assert found.status == 0 and not (found.pace.rapid or found.pace.slow or found.pace.feeds)
    assert found.pace.compared == 3
    assert "those of the CL data within 5%, on 3 moves" in str(found)


@pytest.mark.parametrize(
    ("right", "wrong", "line", "record"),
    [("G1 X50.", "X50.", 3, 2), ("G1 Z0. F300.", "Z0.", 7, 6), ("\nY20.", "\nG0 Y20.", 4, 3)],
)
def test_rapid_where_the_cl_data_cut_is_an_error(right, wrong, line, record):
    found = judged(PROGRAM.replace(right, wrong))
    assert found.status == 1
    assert (line, record) in of_lines(found, found.pace.rapid)
    assert f"line {line}, where the CL data cut to record {record}" in str(found)


def test_a_feed_where_the_cl_data_are_rapid_is_said():
    found = judged(PROGRAM.replace("G0 Z30.", "Z30.").replace("\nX0. Y0.\n", "\nG0 X0. Y0.\n"))
    assert found.status == 0
    assert of_lines(found, found.pace.slow) == [(5, 4)]
    assert "line 5, where they are in rapid traverse to record 4" in str(found)


@pytest.mark.parametrize(
    ("right", "wrong", "expected"),
    [
        ("F300.", "F3000.", [(7, 6, 3000, 300)]),
        ("F600.", "F60.", [(3, 2, 60, 600), (4, 3, 60, 600)]),
        ("F600.", "F610.", []),
        ("G1 X50. F600.\nY20.", "G93 G1 X50. F12.\nY20. F30.\nG94", []),  # 5 s and 2 s
        ("G1 X50. F600.\nY20.", "G93 G1 X50. F12.\nY20. F60.\nG94", [(4, 3, 1200, 600)]),
        ("G1 X50. F600.\nY20.", "G93 G1 X50. F12.\nY20. F15.\nG94", [(4, 3, 300, 600)]),
        ("G1 X50. F600.\nY20.", "G20\nG1 X1.968504 F23.622\nY.787402\nG21", []),  # inches a minute
    ],
)
def test_other_feeds_are_said(right, wrong, expected):
    found = judged(PROGRAM.replace(right, wrong))
    assert found.status == 0
    assert of_lines(found, found.pace.feeds) == [pytest.approx(row) for row in expected]


def test_nothing_is_compared_where_nothing_is_stated():
    bare = "".join(line for line in PATH.splitlines(keepends=True) if "GOTO" in line)
    found = judged(PROGRAM, bare)
    assert found.status == 0 and found.pace.compared == 0
    assert "feeds      not compared" in str(found)


def test_what_lies_behind_a_block_that_is_off_is_not_compared():
    found = judged(PROGRAM.replace("\nY20.", "\nY21.").replace("F300.", "F3000."))
    assert found.along.off.block == 2
    assert not found.pace.feeds


@pytest.mark.parametrize("seed", range(3))
def test_five_axes_at_half_their_feed(seed):
    """By F or by the time of each block, without TCP and with it."""
    made = slips.job(np.random.default_rng(seed), slips.CONTROLS[seed], tcp=seed == 1)
    right = made.judged()
    assert right.pace.compared and not right.pace.feeds
    halved = re.sub(
        r" F(T?)([\d.]+)", lambda word: f" F{word[1]}{float(word[2]) * (2 if word[1] else 0.5):.3f}", made.text
    )
    assert halved != made.text
    found = made.judged(halved)
    assert found.status == 0
    ratios = [programmed / stated for _, _, programmed, stated in found.pace.feeds]
    assert len(ratios) > right.pace.compared / 2
    assert np.median(ratios) == pytest.approx(0.5, rel=0.01)
