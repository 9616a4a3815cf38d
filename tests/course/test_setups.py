"""Drawings of set-ups: from where one looks, which body turns, where a plunger is, which way a dial reads more."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mathpost.frame import Frame
from mathpost.shop.compensate.readings import SIGNS
from mathpost.shop.measure import work_offset
from mathpost.teaching.course import drawings, setups
from mathpost.teaching.course.lesson_data import load
from mathpost.teaching.course.verdict import toml
from mathpost.teaching.draw import plot

SETUPS = toml("setups")
DRAWN = {name: drawn for name, drawn in SETUPS.items() if "parts" in drawn}
TURNS = [(name, part) for name, drawn in DRAWN.items() for part in drawn["parts"] if part[0] == "turn"]
DIALS = [(name, part) for name, drawn in DRAWN.items() for part in drawn["parts"] if part[0] == "dial"]
ISO = dict(zip("AC", load("ac_table").machine.rotary, strict=True))  # tables after ISO 841
ISO["B"] = work_offset.ab_table((0, 0, 0), (0, 0, 0), order="AB")[1]


def texts(drawn):
    return [drawn["title"], *(part[3] for part in drawn["parts"])]


@pytest.mark.parametrize("name", DRAWN)
def test_a_drawing_says_from_where_one_looks(name, monkeypatch):
    drawn, shown = DRAWN[name], []
    assert drawn["seen"] and len(drawn["axes"]) in (2, 3)
    monkeypatch.setattr(plot, "show", lambda: shown.extend(plot.plt.gcf().axes))
    setups.draw(name)
    plot.plt.close("all")
    said = " ".join([shown[0].get_title(), *(text.get_text() for text in shown[0].texts)])
    assert all(f"{word}" in said.split() for word in drawn["axes"]) and f"seen from {drawn['seen']}" in said
    ways = {axis: np.array(way) for axis, way in drawn["axes"].items()}
    if len(ways) == 2 and set(ways) < set("XYZ"):  # the third one, X Y Z being right-handed
        (third,) = set("XYZ") - set(ways)
        first, second = ("YZX"["XYZ".index(third)], "ZXY"["XYZ".index(third)])
        towards = np.linalg.det([ways[first], ways[second]]) > 0
        assert f", {'+' if towards else '−'}{third}" in said
        words = {"+Z": ("above", "the spindle"), "+Y": ("above",), "−Y": ("the front",), "+X": ("the right",)}
        assert drawn["seen"] in words.get(f"{'+' if towards else '−'}{third}", ("the left",))


@pytest.mark.parametrize(("name", "part"), TURNS, ids=lambda each: each if isinstance(each, str) else each[3])
def test_a_turn_says_which_body_turns_and_is_drawn_that_way(name, part):
    drawn, (_, turn, _, text, *_) = DRAWN[name], part
    assert any(turn["body"] in words for words in texts(drawn)), "the body that turns is not in the drawing"
    first, second = (np.array(drawn["axes"][axis]) for axis in turn["turns"].split(" to "))
    _, _, start, end = turn["circle"]
    assert np.sign(end - start) == np.sign(np.linalg.det([first, second])), "drawn the other way round"
    if (
        turn["body"] == "table" and text and text[-1] in "+−" and text[-2] in "ABC"
    ):  # a word: how the table obeys it
        along = np.array(turn.get("axis", ISO[text[-2]].axis), dtype=float)
        moved = Rotation.from_rotvec(0.1 * (1 if text[-1] == "+" else -1) * along).as_matrix()
        assert moved["XYZ".index(turn["turns"][-1]), "XYZ".index(turn["turns"][0])] > 0


@pytest.mark.parametrize(("name", "part"), DIALS, ids=lambda each: each if isinstance(each, str) else each[3])
def test_a_dial_reads_more_as_its_plunger_is_pressed_in(name, part):
    drawn, (_, dial, _, text, *_) = DRAWN[name], part
    body, contact = np.array(dial["points"])
    presses = (contact - body) * (1 if dial["moves"] == "dial" else -1)  # the move that presses the plunger in
    if "C" in texts(drawn):  # a dial on a circle: out if it reads more as the spindle goes away from C
        (centre,) = (part[1] for part in drawn["parts"] if part[3] == "C")
        assert SIGNS["dial"][drawn["positive"]] == np.sign(presses @ (body - centre))
    else:  # a dial at the tip: along an axis of the drawing, or against it, which it says
        (axis,) = (axis for axis in drawn["axes"] if axis in text)
        towards = SIGNS["tip"][drawn["positive"]] * presses @ np.array(drawn["axes"][axis])
        assert ("minus" in text) == (towards < 0)


def test_a_dial_in_a_drawing_has_the_sign_of_its_file():
    assert {name for name, _ in DIALS} == {name for name, drawn in DRAWN.items() if "positive" in drawn}


def test_the_package_sees_a_point_turned_as_the_picture_does():
    _, axes = plot.figure()
    plot.turned_point(axes, [(3, 0), (0, 3)], (0, 0), names=("X", "-Z"))
    right, up = axes.transData.transform([(1, 0), (0, 1)]) - axes.transData.transform([(0, 0), (0, 0)])
    plot.plt.close("all")
    seen = np.cross([right[0], 0, right[1]], [up[0], 0, up[1]])  # X and Z of the picture as they are drawn
    assert up[1] < 0 and axes.get_title() == "seen from +Y" and seen[1] > 0


PANELS = {"active_and_passive": (1, 2), "quarter_turns": (1, 3), "ruined_bore": (1, 2), "coins": (1, 3)}
STILL = {  # of lessons 00 to 04: how to draw each
    "turn_in_plane": lambda axes: drawings.turn_in_plane(axes, 35),
    "active_and_passive": lambda axes: drawings.active_and_passive(*axes, (0.75, 0.6), 25),
    "quarter_turns": drawings.quarter_turns,
    "ruined_bore": drawings.ruined_bore,
    "parts": lambda axes: drawings.parts(axes, (0.2, -0.9, 0.9), (0.2, 0.1, 1), 60),
    "two_mirrors": lambda axes: drawings.two_mirrors(axes, 20, 25),
    "euler_discs": lambda axes: drawings.euler_discs(axes, 40, 50, 30),
    "frames_and_point": lambda axes: drawings.frames_and_point(
        axes, dict.fromkeys("MWT", Frame.from_axes((0, 0, 1), (1, 0, 0))), (1, 2, 3), 1
    ),
    "coins": lambda axes: drawings.coins(axes, "Zx", "coin"),
}


def test_every_still_drawing_is_data_too():
    public = {name for name, each in vars(drawings).items() if getattr(each, "__module__", "") == drawings.__name__}
    diagrams = {"chains"}  # of no place and no turn
    assert (
        {name for name in public if name[0] != "_"} - {"captions", "write"} - diagrams
        == set(STILL)
        == set(SETUPS) - set(DRAWN)
    )


@pytest.mark.parametrize("name", STILL)
def test_a_still_drawing_says_from_where_one_looks_and_what_turns(name):
    stated, in_space = SETUPS[name], name in ("parts", "euler_discs", "frames_and_point", "coins", "quarter_turns")
    figure, axes = plot.figure(*PANELS.get(name, (1, 1)), three_d=in_space)
    STILL[name](axes)
    shown = figure.get_supxlabel()
    written = {text.get_text() for panel in figure.axes for text in panel.texts}
    arrows = [each for panel in figure.axes for each in panel.texts if getattr(each, "arrow_patch", None)]
    plot.plt.close("all")
    assert (
        f"seen from {stated['seen']}" in shown
        and stated.get("turns", "") in shown
        and set(stated["axes"]) <= written
    )
    assert name == "frames_and_point" or "turns" in stated or "moves" in stated
    if in_space:  # matplotlib's angles of the eye
        for panel in figure.axes:
            eye = Rotation.from_euler("ZY", [panel.azim, -panel.elev], degrees=True).apply([1, 0, 0])
            sides = [("the right", "the left"), ("the back", "the front"), ("above", "below")]
            words = {pair[0] if x > 0 else pair[1] for pair, x in zip(sides, eye, strict=True)}
            assert words == set(stated["seen"].replace(" and", ",").split(", "))
    elif name in ("turn_in_plane", "active_and_passive"):  # the arcs: each arrow a little piece of a turn X to Y
        arcs = [each for each in arrows if 0 < np.hypot(*np.subtract(each.xy, each.xyann)) < 0.1]
        assert arcs and all(np.linalg.det([each.xyann, each.xy]) > 0 for each in arcs) and ", +Z" in shown


def test_the_bar_in_the_bore_moves_against_x_of_the_face():
    _, panels = plot.figure(1, 2)
    drawings.ruined_bore(panels)
    for panel in panels:
        arrows = [np.subtract(each.xy, each.xyann) for each in panel.texts if getattr(each, "arrow_patch", None)]
        retract, of_spindle, of_face = arrows
        assert retract @ of_face < 0 < of_spindle[0]
        assert (panel.lines[-1].get_xydata()[-1] - [10, 0]) @ of_face < 0
    plot.plt.close("all")
