"""The detective against itself: every cause planted at random is named first, and of two together both."""

from collections import Counter
from itertools import combinations

import numpy as np
import pytest

from mathpost.detective.causes import Setup, causes
from mathpost.detective.explanation import misread
from mathpost.detective.positions import explain_linear, explain_tip
from mathpost.kinematics import Kinematics
from mathpost.machine_file import load


def drawn(rng, kin):
    """X Y Z and rotary words with three decimals, away from zero."""
    count = len(kin.machine.rotary)
    rotary = rng.uniform(5, 85, count) * rng.choice([-1, 1], count)
    return np.concatenate([rng.uniform(-100, 100, 3), rotary]).round(3)


def said(found):
    """Every wording of the first reading."""
    return [found.misreadings[0].sentence, *found.misreadings[0].same] if found.explained else []


@pytest.mark.parametrize("name", ["bc_table", "ac_head", "nutating_head_table", "dividing_head"])
@pytest.mark.parametrize("backward", [False, True])
def test_alone(name, backward):
    kin, rng, scored = Kinematics(load(name)), np.random.default_rng(11), Counter()
    right = Setup.right(kin.machine)
    for cause in causes(kin.machine):
        wrong, given = misread(right, cause), drawn(rng, kin)
        if backward:
            found = explain_linear(kin, given[:3], given[3:], wrong.linear(given[None])[0].round(4), decimals=4)
        else:
            found = explain_tip(kin, given, wrong.pose(given[None])[0, :3].round(4), decimals=4)
        if found.right:
            continue  # the cause makes nothing different there
        scored[any(cause.phrase in sentence for sentence in said(found))] += 1
    assert scored[True] >= 0.95 * scored.total() and scored.total() > 20, scored


def test_two_together(of):
    kin, rng, scored = Kinematics(load("bc_table")), np.random.default_rng(12), Counter()
    right, pairs = Setup.right(kin.machine), list(combinations(causes(kin.machine), 2))
    for n in rng.choice(len(pairs), of(8, 15), replace=False):
        given = drawn(rng, kin)
        found = explain_tip(kin, given, misread(right, *pairs[n]).pose(given[None])[0, :3].round(4), decimals=4)
        both = [all(cause.phrase in sentence for cause in pairs[n]) for sentence in said(found)]
        simpler = found.explained and len(found.misreadings[0].kinds) < 2  # one undoes or contains the other
        scored[any(both) or simpler] += 1
    assert scored[True] >= 0.8 * scored.total(), scored


@pytest.mark.parametrize("name", ["bc_table", "ac_head"])
def test_what_nothing_explains_is_not_explained(name, of):
    """A tip that is off by anything, to three decimals."""
    kin, rng = Kinematics(load(name)), np.random.default_rng(13)
    for _ in range(of(3, 8)):
        given = drawn(rng, kin)
        tip = kin.forward(given, degrees=True)[0] + rng.uniform(-50, 50, 3)
        assert not explain_tip(kin, given, tip.round(3), decimals=3).explained
