"""Drawings of set-ups: from where one looks, which body turns, where a plunger is, which way a dial reads more."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mathpost.shop.compensate.readings import SIGNS
from mathpost.shop.measure import work_offset
from mathpost.teaching.course import setups
from mathpost.teaching.course.lesson_data import load
from mathpost.teaching.course.verdict import toml
from mathpost.teaching.draw import plot

DRAWN = toml("setups")
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
