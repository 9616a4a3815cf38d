"""Typical mistakes, each of which a check of the course must catch: one that passes them would be worth nothing."""

import json
from dataclasses import replace

import numpy as np
import pytest

from mathpost import load_machine, rotation
from mathpost.kinematics import Kinematics
from mathpost.shop.plane.positioning import align
from mathpost.shop.plane.tilted_plane import Plane
from tests.conftest import ROOT


@pytest.mark.parametrize("derivation", ["v.cross(point)", "point.cross(v)"])
def test_lesson_01_fails_if_about_turns_as_the_left_hand_does(monkeypatch, derivation):
    """Also if the derivation in the lesson is turned with it: the quarter turns of the learner's hand remain."""
    about = rotation.about
    monkeypatch.setattr(rotation, "about", lambda axis, angle: about(axis, -angle))
    path, space = ROOT / "notebooks/01_rotating_a_point.ipynb", {"display": lambda shown: None}
    cells = [cell for cell in json.loads(path.read_text(encoding="utf-8"))["cells"] if cell["cell_type"] == "code"]
    for source in ("".join(cell["source"]) for cell in cells):
        if "about(unit[axis]" in source:
            with pytest.raises(AssertionError):
                exec(source.replace("v.cross(point)", derivation), space)
            return
        exec(source, space)


def flipped(model, *names):
    """The machine with the sense of some rotary axes reversed: a table taken for a head."""
    rotary = [replace(r, axis=tuple(-x for x in r.axis)) if r.name in names else r for r in model.rotary]
    return replace(model, rotary=tuple(rotary))


def check_alignment(kin, feature, answers):
    for angles in answers:
        _, axis = kin.forward([0, 0, 0, *angles], degrees=True)
        np.testing.assert_allclose(axis, feature.z, atol=1e-9)


@pytest.mark.parametrize("names", [("A",), ("C",)], ids=["A taken for a head", "C taken for a head"])
def test_forward_kinematics_catches(names):
    model = load_machine("data/machines/ac_table.toml")
    feature = Plane("G68.2", [100, 40, 0]).frame
    check_alignment(Kinematics(model), feature, [s.angles for s in align(feature, model).solutions])
    with pytest.raises(AssertionError):
        wrong = align(feature, flipped(model, *names))
        check_alignment(Kinematics(model), feature, [s.angles for s in wrong.solutions])


def test_the_manual_example_does_not_tell_the_table_signs_apart():
    """SPB+45 on an A-C table: with both signs reversed the same two positions, so it proves neither."""
    model = load_machine("data/machines/ac_table.toml")
    feature = Plane("PLANE SPATIAL", [0, 45, 0]).frame
    pairs = [align(feature, m).solutions for m in (model, flipped(model, "A", "C"))]
    first, second = ({tuple(np.round(s.angles, 9)) for s in solutions} for solutions in pairs)
    assert first == second
