"""Stock and fixture that the machine file names: rapid moves and the user's lines keep clear of both."""

import re
from dataclasses import replace

import numpy as np
import pytest

from mathpost import load_machine, machine_file, postprocess
from mathpost.errors import InputError, MathpostError
from mathpost.files import read_toml
from mathpost.machine import Solid
from mathpost.path import cl
from mathpost.shop.post import solids
from mathpost.shop.post.body import ABOVE, BODY, in_body
from mathpost.shop.post.verify import verify
from tests.conftest import DATA
from tests.independent import judge

TABLE = load_machine("ac_table")
STOCK = Solid((-50, -50, 0), (50, 50, 60))
CLAMP = Solid((60, 0, 0), (60, 0, 80), 10)  # beside it, and higher
SLOT = "FEDRAT/500\nRAPID\nGOTO/-60,0,70,0,0,1\nGOTO/-60,0,50\nGOTO/40,0,50\nRAPID\nGOTO/40,0,70\n"


def made(text, dialect="siemens", **setup):
    setup = {"program_head": ("G40" if dialect != "heidenhain" else "; OURS",)} | setup
    return postprocess(cl.parse(text, "part.cl"), replace(TABLE, **setup), dialect=dialect)


def test_a_machine_file_names_them():
    content = read_toml(DATA / "machines/ac_table.toml")
    content["workpiece"] |= {
        "stock": [{"from": [-50, -50, 0], "to": [50, 50, 60]}],
        "fixture": [{"from": [60, 0, 0], "to": [60, 0, 80], "radius": 10}],
    }
    found = machine_file.from_dict(content)
    assert found.stock == (STOCK,) and found.fixture == (CLAMP,)
    for wrong, why in (
        ({"from": [0, 0, 0], "to": [9, 9, 0]}, "key 'to'"),
        ({"from": [0, 0, 0], "to": [0, 0, 0], "radius": 3}, "key 'to'"),
        ({"from": [0, 0, 0], "to": [0, 0, 9], "radius": -3}, "key 'radius'"),
        ({"from": [0, 0, 0]}, "key 'to'"),
        ({"from": [0, 0, 0], "to": [1, 2, 3], "height": 3}, "key 'height'"),
    ):
        content["workpiece"]["fixture"] = [{"from": [0, 0, 0], "to": [1, 2, 3]}, wrong]
        with pytest.raises(InputError, match=rf"fixture 2, {why}"):
            machine_file.from_dict(content)


@pytest.mark.parametrize(
    ("back", "meets"),
    [
        ("GOTO/40,0,50\nRAPID\nGOTO/-60,0,50\n", False),  # along the slot that is cut
        ("GOTO/40,0,70\nRAPID\nGOTO/40,20,70\nRAPID\nGOTO/40,20,59\nRAPID\nGOTO/40,20,70\n", True),
        ("GOTO/40,0,70\nRAPID\nGOTO/40,70,70\nRAPID\nGOTO/40,70,20\nRAPID\nGOTO/40,55.1,20\n", False),
        (
            "GOTO/40,0,70\nRAPID\nGOTO/40,70,70\nRAPID\nGOTO/40,70,20\nRAPID\nGOTO/40,54.7,20\nRAPID\nGOTO/40,70,20\n",
            True,
        ),
        ("GOTO/40,0,70\nRAPID\nGOTO/40,0,70,0,.6,.8\nRAPID\nGOTO/40,44,70\n", False),  # a tool that leans
        ("GOTO/40,0,70\nRAPID\nGOTO/40,0,70,0,.6,.8\nRAPID\nGOTO/40,44,57\nRAPID\nGOTO/40,94,77\n", True),
        (
            "GOTO/40,0,70\nRAPID\nGOTO/40,20,70\nRAPID\nGOTO/40,20,61.9,0,.6,.8\nRAPID\nGOTO/40,20,70\n",
            True,
        ),  # its edge comes down while it turns
    ],
)
def test_rapid_moves_keep_clear_of_stock_that_is_not_cut(back, meets):
    said = [each for each in made(SLOT + back, stock=(STOCK,)).report.warnings if "meets" in each]
    assert [("what the path cuts or the stock" in each) for each in said] == [True] * meets
    assert not any("meets" in each for each in made(SLOT + back).report.warnings)


@pytest.mark.parametrize("dialect", ["siemens", "fanuc", "heidenhain"])
def test_what_the_first_record_takes_of_the_stock_is_its_own(dialect):
    """It is a rapid one, in the stock, with a tool that leans: the way down to it is along its axis."""
    for angle in np.radians([0, 17, 40]):
        axis = f"0,{-np.sin(angle):.9f},{np.cos(angle):.9f}"
        made(f"FEDRAT/500\nRAPID\nGOTO/9.06,-30.05,41.78,{axis}\nGOTO/-9,-30,30\n", dialect, stock=(STOCK,))


def test_where_none_is_named_the_report_says_so():
    assert "stock and fixture are not known" in str(made(SLOT).report)
    assert "1 of stock, 1 of fixture" in str(made(SLOT, stock=(STOCK,), fixture=(CLAMP,)).report)


@pytest.mark.parametrize(("x", "hits"), [(44, False), (46, True)])
def test_no_move_goes_into_a_fixture(x, hits):
    text = SLOT.replace("40,", f"{x},")
    if hits:
        with pytest.raises(MathpostError, match="record 3: on its way there the tool's body.* hits a fixture"):
            made(text, fixture=(CLAMP,))
    else:
        made(text, fixture=(CLAMP,))


@pytest.mark.parametrize("dialect", ["siemens", "fanuc", "heidenhain"])
def test_a_tool_that_leans_is_held_against_it_with_its_whole_length(dialect):
    """The shank comes to the clamp at the upper end, 80 mm over the table."""
    text = "FEDRAT/500\nGOTO/-9,0,0,{0},0,{1}\nGOTO/9,0,0\n"
    far, near = ((np.sin(angle), np.cos(angle)) for angle in np.radians([20, 28]))
    made(text.format(*far), dialect, fixture=(CLAMP,))
    with pytest.raises(MathpostError, match="hits a fixture|meets"):
        made(text.format(*near), dialect, fixture=(CLAMP,))


@pytest.mark.parametrize("dialect", ["siemens", "heidenhain", "linuxcnc"])
def test_approach_and_retract_rise_above_both(dialect):
    """From the clearance of 20 mm above what is highest the tool comes down."""
    high = Solid((-50, -50, 0), (50, 50, 73))
    for setup, height in (({}, 90), ({"stock": (high,)}, 93), ({"fixture": (CLAMP,)}, 100)):
        heights = {float(each) for each in re.findall(r"Z\+?(\d+)\.0000", made(SLOT, dialect, **setup).program)}
        assert heights == {50, 70, height, 270, 390}, setup


@pytest.mark.parametrize(("line", "safe"), [("SUPA G0 Z205", True), ("SUPA G0 Z195", False)])
def test_lines_of_the_user_keep_clear_of_both(line, safe):
    """With a tool of 120 mm the clamp reaches Z 200."""
    straight = replace(TABLE.rotary[0], limits=(0.0, 1e-6))
    own = {"rotary": (straight, TABLE.rotary[1]), "program_foot": (line, "G0 X60 Y0"), "fixture": (CLAMP,)}
    if safe:
        made(SLOT, **own)
    else:
        with pytest.raises(MathpostError, match=r"\[program\] foot, .*X60.* or a fixture"):
            made(SLOT, **own)


def test_verify_says_what_meets_them():
    text = "G90 G0 X-60 Y0 Z70 A0 C0\nG1 Z50 F500\nX40\nG0 Z59\nY30\nZ70\nX52\nG1 X62 F500\n"
    bare = verify(text, TABLE, "siemens")
    assert not bare.unsure and bare.status == 0 and "stock and fixture: the machine file names none" in str(bare)
    judged = verify(text, replace(TABLE, stock=(STOCK,), fixture=(Solid((70, 30, 0), (70, 30, 80), 5),)), "siemens")
    assert [judged.line(block) for block in judged.unsure] == [5, 6]
    assert [judged.line(block) for block in judged.hits] == [8] and judged.status == 1
    assert "fixture    line 8: on its way the tool, 10 mm across, hits it" in str(judged)


@pytest.mark.parametrize("seed", range(40))
def test_solids_are_met_where_a_fine_lattice_of_them_is(seed):
    rng = np.random.default_rng(seed)
    start, end = np.sort(np.add(rng.uniform(-40, 40, (2, 3)).round(1), [[0], [3]]), axis=0)
    radius = None if seed % 2 else round(rng.uniform(2, 30), 1)
    solid = Solid(tuple(start), tuple(end), radius)
    tips, axes = rng.uniform(-60, 60, (3, 3)), rng.normal(size=(3, 3))
    axes /= np.linalg.norm(axes, axis=1)[:, None]

    def near(points, margin):
        return in_body(points, tips, axes, 50.0, margin)

    found = solids.meets(solid, near, lambda points: np.ones(len(points), bool))
    lattice = np.stack(np.meshgrid(*(np.arange(-75, 76, 1.5),) * 3), axis=-1).reshape(-1, 3)
    if radius is None:
        inside = ((lattice >= start) & (lattice <= end)).all(axis=1)
    else:
        way = (end - start) / np.linalg.norm(end - start)
        along = (lattice - start) @ way
        beside = np.linalg.norm(np.cross(lattice - start, way), axis=1)
        inside = (along >= 0) & (along <= (end - start) @ way) & (beside <= radius)
    deep = max(
        judge.depth_in_tool(lattice[inside], tip + ABOVE * axis, axis, BODY, 50 - ABOVE)
        for tip, axis in zip(tips, axes, strict=True)
    )
    grown = solids.meets(
        solid, lambda points, margin: near(points, margin + 3.0), lambda points: points[:, 0] < 1e9
    )
    assert found >= (deep > 1) and grown >= found
    if found and deep == 0:  # what a lattice of 1.5 mm misses is no more than a corner of it
        assert grown
