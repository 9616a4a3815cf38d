"""Whose coordinates a GOTO is in, and where the tool points when it does not say."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mathpost import load_machine, postprocess
from mathpost.errors import InputError
from mathpost.path import cl as cldata
from tests.conftest import DATA

TABLE = load_machine(DATA / "machines/ac_table.toml")
UP = (0, 0, 1)
UPRIGHT = "CSYS/1.,0,0,0,0,1.,0,0,0,0,1.,0"
LEANING = "CSYS/0,-0.984808,-0.173648,0,1.,0,0,0,0,-0.173648,.984808,0"  # as in a published file
LEAN = (-0.173648, 0, 0.984808)
WORLD = "TRNTYP/WORLD,0,0,0"
QUARTER = "0,1,0,0,-1,0,0,0,0,0,1,0"


def read(text):
    return cldata.parse(text, "part.cl")


def refused(text):
    with pytest.raises(InputError) as caught:
        read(text)
    return str(caught.value)


def creo(*rows):
    """The comment that says the coordinate system of a step, on three lines."""
    return "$$-> CSYS / " + ",  $\n            ".join(rows)


SQUARE = creo("1.0, 0.0, 0.0, 0.0", "0.0, 1.0, 0.0, 0.0", "0.0, 0.0, 1.0, 0.0")
TURNED = creo("1.0, 0.0, 0.0, 0.0", "0.0, 0.0, -1.0, 0.0", "0.0, 1.0, 0.0, 0.0")
MOVED = creo("1.0, 0.0, 0.0, 50.0", "0.0, 1.0, 0.0, 0.0", "0.0, 0.0, 1.0, 0.0")


def catia(*rows):
    return "\n".join(["$$*CATIA0", "$$ Manufacturing Program.1", *(f"$$     {row}" for row in rows)])


AXIS = catia(
    "1.00000 0.00000 0.00000 0.00000", "0.00000 1.00000 0.00000 0.00000", "0.00000 0.00000 1.00000 0.00000"
)


@pytest.mark.parametrize(
    ("text", "points", "axes", "rule"),
    [
        ("GOTO/1,2,3", [(1, 2, 3)], [UP], "as written"),
        (f"{WORLD}\n{UPRIGHT}\nGOTO/1,2,3", [(1, 2, 3)], [UP], "world coordinates (SolidWorks, TRNTYP/WORLD)"),
        (f"{WORLD}\n{LEANING}\nGOTO/1,2,3", [(1, 2, 3)], [LEAN], "(SolidWorks, TRNTYP/WORLD)"),
        (f"{LEANING}\n{WORLD}\nGOTO/1,2,3", [(1, 2, 3)], [LEAN], "(SolidWorks, TRNTYP/WORLD)"),
        (
            f"{WORLD}\n{UPRIGHT}\nGOTO/1,2,3\n{WORLD}\n{LEANING}\nGOTO/4,5,6,-0.173648,0,0.984808\nGOTO/7,8,9\n"
            f"{WORLD}\n{UPRIGHT}\nGOTO/7,8,9",
            [(1, 2, 3), (4, 5, 6), (7, 8, 9), (7, 8, 9)],
            [UP, LEAN, LEAN, UP],
            "(SolidWorks, TRNTYP/WORLD)",
        ),
        (
            f"{WORLD}\n{UPRIGHT}\nGOTO/1,2,3,0,0.6,0.8\n{WORLD}\n{UPRIGHT}\nGOTO/4,5,6",
            [(1, 2, 3), (4, 5, 6)],
            [(0, 0.6, 0.8), UP],  # as in a published file: every CSYS points the tool anew
            "TRNTYP/WORLD",
        ),
        (
            f"{WORLD}\n{UPRIGHT}\nMULTAX/ON\nGOTO/1,2,3,0,0.6,0.8\n{LEANING}\nMULTAX/ON\nGOTO/4,5,6",
            [(1, 2, 3), (4, 5, 6)],
            [(0, 0.6, 0.8), LEAN],
            "TRNTYP/WORLD",
        ),
        (f"{WORLD}\n{LEANING}\nMULTAX/OFF\nGOTO/1,2,3", [(1, 2, 3)], [LEAN], "TRNTYP/WORLD"),
        (f"{WORLD}\n{LEANING}\nTLAXIS/0,0.6,0.8\nGOTO/1,2,3", [(1, 2, 3)], [(0, 0.6, 0.8)], "TRNTYP/WORLD"),
        ("CSYS/1,0,0,5,0,1,0,6,0,0,1,7\nGOTO/1,2,3", [(1, 2, 3)], [UP], "one CSYS"),
        ("MSYS/0,0,10,0,1,0,-1,0,0\nGOTO/1,2,3", [(1, 2, 3)], [UP], "MSYS (NX)"),
        (
            "MSYS/0,0,0,1,0,0,0,1,0\nGOTO/1,0,0\nMSYS/0,0,10,0,1,0,0,0,1\nGOTO/1,2,3,0,0.6,0.8",
            [(1, 0, 0), (3, 1, 12)],
            [UP, (0.8, 0, 0.6)],
            "MSYS (NX)",
        ),
        (
            "GOTO/0,10,20,0,0.5,0.8660254\nMULTAX/OFF\nGOTO/50,0,50",
            [(0, 10, 20), (50, 0, 50)],
            [(0, 0.5, 0.8660254), UP],
            "as written",
        ),
        (
            "MULTAX\nGOTO/0,0,0,0,0.6,0.8\nGOTO/1,0,0\nMULTAX/OFF\nGOTO/2,0,0\nMULTAX/ON\nGOTO/3,0,0,0,0.6,0.8",
            [(0, 0, 0), (1, 0, 0), (2, 0, 0), (3, 0, 0)],
            [(0, 0.6, 0.8), (0, 0.6, 0.8), UP, (0, 0.6, 0.8)],
            "as written",
        ),
        ("TRNTYP/WORLD,0,0,0\nGOTO/1,2,3", [(1, 2, 3)], [UP], "TRNTYP/WORLD"),
        (f"{SQUARE}\nGOTO/1,2,3", [(1, 2, 3)], [UP], "machine coordinates (Creo, three-axis"),
        (
            f"MULTAX / ON\n{TURNED}\nGOTO/4,5,6,0,-1,0\nMULTAX / OFF\n{SQUARE}\nGOTO/1,2,3",
            [(4, 5, 6), (1, 2, 3)],
            [(0, -1, 0), UP],
            "Creo, MULTAX/ON",
        ),
        (
            f"MULTAX / ON\n{SQUARE}\nGOTO/1,2,3,0,0,1\n{TURNED}\nGOTO/4,5,6,0,-1,0",
            [(1, 2, 3), (4, 5, 6)],
            [UP, (0, -1, 0)],
            "machine coordinates (Creo, MULTAX/ON)",
        ),
        (f"{AXIS}\nGOTO/1,2,3,0,0,1\n{AXIS}\nGOTO/4,5,6", [(1, 2, 3), (4, 5, 6)], [UP, UP], "axis system (CATIA)"),
    ],
)  # fmt: skip
def test_where_the_tool_is_and_points(text, points, axes, rule):
    cl = read(text)
    np.testing.assert_allclose(cl.points, points, atol=1e-9)
    np.testing.assert_allclose(cl.axes, axes, atol=1e-6)
    assert rule in cl.coordinates


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        (f"CSYS/{QUARTER}\nGOTO/1,2,3\n{UPRIGHT}\nGOTO/4,5,6", 4, "TRNTYP/WORLD before CSYS, or one CSYS"),
        (f"{LEANING}\nGOTO/1,2,3", 2, "TRNTYP/WORLD before a CSYS that leans"),
        ("GOTO/1,2,3\n" + UPRIGHT, 2, "before the first move"),
        ("CSYS/1,0,0,0,0,2,0,0,0,0,1,0\nGOTO/1,2,3", 1, "right-handed"),
        ("TRNTYP/WORLD,1,0,0\nGOTO/1,2,3", 1, "change nothing"),
        ("TRNTYP/LOCAL\nGOTO/1,2,3", 1, "TRNTYP/WORLD"),
        (f"{SQUARE}\nGOTO/1,2,3\n{TURNED}\nGOTO/4,5,6", 8, "MULTAX/ON"),
        (f"MULTAX/ON\n{TURNED}\nGOTO/1,2,3,0,-1,0\nMULTAX/OFF\nGOTO/4,5,6", 7, "MULTAX/ON"),
        ("MULTAX/3\nGOTO/1,2,3", 1, "MULTAX/ON or MULTAX/OFF"),
    ],
)
def test_what_cannot_be_told_is_refused_with_its_line(text, line, words):
    message = refused(text)
    assert message.startswith(f"part.cl, line {line},") and words in message


@pytest.mark.parametrize("row", [0, 1, 2])
def test_axis_systems_of_catia_that_differ_in_any_row_are_told_apart(row):
    other = [[f"{float(n == column):.5f}" for column in range(3)] + ["0.00000"] for n in range(3)]
    other[row][3] = "9.00000"
    text = f"{AXIS}\nGOTO/1,2,3\n{catia(*map(' '.join, other))}\nGOTO/4,5,6"
    message = refused(text)
    assert message.startswith("part.cl, line 12,") and "one machining axis system" in message


def test_three_axis_steps_in_systems_that_move_are_read_with_a_warning():
    cl = read(f"{SQUARE}\nGOTO/1,2,3\n{MOVED}\nGOTO/4,5,6")
    np.testing.assert_allclose(cl.points, [(1, 2, 3), (4, 5, 6)])
    assert any("$$-> CSYS moves between three-axis steps" in note for note in cl.notes)


def test_the_report_says_which_rule_was_used():
    report = str(postprocess(read(f"{WORLD}\n{LEANING}\nFEDRAT/100\nGOTO/1,2,3\nGOTO/4,5,6"), TABLE).report)
    assert "GOTO in world coordinates (SolidWorks, TRNTYP/WORLD)" in report


@pytest.mark.parametrize("seed", range(20))
def test_a_part_that_is_machined_from_several_sides(seed):
    """One random part, written in SolidWorks' way and in NX's, is the same path.

    SciPy turns its points into each setup; arcs lie in the plane of their setup.
    """
    rng = np.random.default_rng(seed)
    world, nx, tips, axes = ["UNITS/MM", "FEDRAT/100"], ["UNITS/MM", "FEDRAT/100", "MSYS/0,0,0,1,0,0,0,1,0"], [], []
    nx.append("GOTO/0,0,0,0,0,1")
    world += [WORLD, UPRIGHT, "GOTO/0,0,0,0,0,1"]
    for _ in range(4):
        turn, origin = Rotation.random(random_state=rng), rng.uniform(-50, 50, 3)
        matrix = turn.as_matrix()
        local = rng.uniform(-40, 40, (5, 3))
        centre, radius = rng.uniform(-20, 20, 3), rng.uniform(1, 9)
        angles = np.sort(rng.uniform(0, 6, 2))
        ends = centre + radius * np.column_stack([np.cos(angles), np.sin(angles), [0, 0]])
        words = [f"GOTO/{{{n}}}" for n in range(6)] + ["CIRCLE/{6},{7}", "GOTO/{8}"]
        part, lying = turn.apply([*local, *ends, centre]) + origin, np.array([*local, *ends, centre])
        for lines, points, z in ((world, part, matrix[:, 2]), (nx, lying, np.array(UP))):
            values = [*points[:6], points[7], z, points[6]]
            printed = [",".join(f"{value:.9f}" for value in each) for each in values]
            lines += [] if lines is nx else [WORLD, "CSYS/" + printed_matrix(matrix, origin)]
            lines += [f"MSYS/{printed_axes(matrix, origin)}"] * (lines is nx)
            lines += [word.format(*printed) for word in words]
        tips.append(part[:6])
        axes.append(matrix[:, 2])
    one, other = read("\n".join(world)), read("\n".join(nx))
    np.testing.assert_allclose(one.points, other.points, atol=1e-6)
    np.testing.assert_allclose(one.axes, other.axes, atol=1e-6)
    for points, axis in zip(tips, axes, strict=True):
        for point in points:
            record = np.linalg.norm(one.points - point, axis=1).argmin()
            np.testing.assert_allclose(one.points[record], point, atol=1e-6)
            np.testing.assert_allclose(one.axes[record], axis, atol=1e-6)


def printed_matrix(matrix, origin):
    return ",".join(f"{value:.9f}" for value in np.column_stack([matrix, origin]).ravel())


def printed_axes(matrix, origin):
    return ",".join(f"{value:.9f}" for value in [*origin, *matrix[:, 0], *matrix[:, 1]])
