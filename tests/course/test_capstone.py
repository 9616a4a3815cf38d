"""Lesson 07c: every part and machine can be done by hand, and what is wrong with a program is said."""

import re
from dataclasses import replace
from functools import cache, partial
from itertools import pairwise

import numpy as np
import pytest

from mathpost.shop.post import verify
from mathpost.teaching.course import exercise
from mathpost.teaching.course.exercises.capstone import INVERSE, KINDS, POLES, least_turn, nearest_to_the_pole, task
from mathpost.teaching.course.verdict import EXERCISES, RIGHT
from tests.course import capstone_by_hand as hand

SEEDS = [0, 14, 17, 21, 1003]  # each kind of machine, each place of the pole, both travels
MORE = [8, 19, 1001, 1002, 1004]
EXERCISE = EXERCISES["07c-program"]
A_TURN, ABOVE = np.array([0, 0, 0, 0, 2 * np.pi]), np.array([0, 0, 1])


@cache
def by_hand(seed):
    return hand.program(task(seed).machine, task(seed).cl)


def judged(text, seed=0):
    return EXERCISE.complaint(text, seed)


def test_a_part_and_a_machine_are_done_in_plain_numpy(of):
    for seed in of(SEEDS, SEEDS + MORE):
        given = task(seed)
        machine = hand.Machine(given.machine)
        inverse = EXERCISES["07c-inverse"]
        assert inverse.complaint([machine.inverse(*each).tolist() for each in INVERSE.inputs], seed) == "", seed
        assert judged(by_hand(seed), seed) == "", seed


@pytest.mark.parametrize("seed", SEEDS + MORE)
def test_the_numbers_asked_for_are_those_of_plain_numpy(seed):
    _, axes, _ = hand.records(task(seed).cl)
    t = np.linspace(0, 1, 10001)
    away = np.array([hand.from_pole(hand.slerp(one, two, t)) for one, two in pairwise(axes)])
    move, at = np.unravel_index(away.argmin(), away.shape)
    assert nearest_to_the_pole(seed) == pytest.approx([1 + move + t[at], np.degrees(away.min())], abs=0.001)
    machine = hand.Machine(task(seed).machine)
    tips, axes, _ = hand.records(task(seed).cl)
    chosen = hand.choose(machine, hand.candidates(machine, tips, axes, True), axes)
    turned = np.degrees(np.abs(np.diff(chosen[:, 4 - machine.inner])).sum())
    assert turned == pytest.approx(least_turn(seed), abs=0.01)


def test_every_kind_is_drawn():
    drawn_machines = {task(seed).machine.splitlines()[0][8:-1] for seed in range(60)}
    assert drawn_machines == set(KINDS)
    degrees = np.array([nearest_to_the_pole(seed) for seed in range(60)])
    at_record = (degrees[:, 1] < 1e-3) & (degrees[:, 0] % 1 < 1e-6)
    assert len(POLES) == 3
    assert at_record.sum() > 5
    assert (degrees[:, 1] > 0.2).sum() > 5
    assert (~at_record & (degrees[:, 1] < 1e-3)).sum() > 5


def test_a_learner_has_numbers_of_their_own():
    of = [EXERCISE.of(name).arguments["seed"] for name in ("one", "two", "one")]
    assert of[0] == of[2] != of[1]
    every = {EXERCISES[name].of("one").arguments["seed"] for name in EXERCISES if name.startswith("07c-")}
    assert every == {of[0]}, "all exercises are about the same part"
    assert EXERCISE.of("one").verdict(by_hand(of[0])).status == RIGHT
    assert EXERCISE.of("two").verdict(by_hand(of[0])).status != RIGHT


def test_verify_agrees_with_the_judge():
    given = task(0)
    found = verify.verify(by_hand(0), given.kin.machine, cl=given.path)
    assert found.status == 0


def swapped(pattern, replacement, text, count=0):
    changed = re.sub(pattern, replacement, text, count=count, flags=re.MULTILINE)
    assert changed != text
    return changed


def without_line(number, text):
    lines = text.splitlines()
    return "\n".join(lines[:number] + lines[number + 1 :])


def digits_exchanged(text):
    """Two decimals of one X, as a typist exchanges them."""
    line = next(line for line in text.splitlines()[20:] if re.search(r"X[-+]\d+\.(\d)(?!\1)\d", line))
    return text.replace(line, re.sub(r"(X[-+]\d+\.)(\d)(\d)", r"\1\3\2", line))


def turned_by(degrees, text):
    """C in another winding from the middle of the program on."""
    lines = text.splitlines()
    for n in range(len(lines) // 2, len(lines)):
        lines[n] = re.sub(r"C([-+][\d.]+)", lambda found: f"C{float(found[1]) + degrees:+.4f}", lines[n])
    return "\n".join(lines)


def lifted_between(text):
    """No record missed, and nothing cut between the first two."""
    lines = text.splitlines()
    up = [re.sub(r"Z([-+][\d.]+)", lambda found: f"Z{float(found[1]) + 30:+.4f}", line) for line in lines[1:3]]
    return "\n".join([*lines[:2], *up, *lines[2:]])


def slip(**how):
    return lambda _: hand.program(task(0).machine, task(0).cl, **how)


WRONG = [
    (
        "feeds deleted",
        partial(swapped, r" FT?[\d.]+$", ""),
        "On the way to record 1 a block states no feed and no time",
    ),
    (
        "feeds deleted but the first",
        lambda text: text.partition("F1000")[0] + "F1000" + swapped(r" FT?[\d.]+$", "", text.partition("F1000")[2]),
        "On the way to record 6 the feed is 1000",
    ),
    ("a tenth of the feed", partial(swapped, "F1000", "F100"), "the feed is 100 mm/min; the CL data have 1000"),
    (
        "the first feed throughout",
        partial(swapped, "F800", "F1000"),
        "record 6 the feed is 1000 mm/min; the CL data have 800",
    ),
    ("rapid in cut", partial(swapped, "F800", "FMAX"), "a block is rapid, and the tool is in cut"),
    ("times too short", partial(swapped, r"FT0\.", "FT0.0"), "feed and rates of the machine ask for"),
    ("times too long", partial(swapped, r"FT0\.", "FT9."), "feed and rates of the machine ask for"),
    ("digits exchanged", digits_exchanged, "the tip strays by"),
    ("a record left out", slip(skip=[3]), "No block ends at record 4, in its turn"),
    ("the last record missing", lambda text: without_line(-2, text), "No block ends at record 11"),
    (
        "backwards",
        lambda text: "\n".join([text.splitlines()[0], *reversed(text.splitlines()[1:-1]), text.splitlines()[-1]]),
        "No block ends at record 2",
    ),
    ("one block per record", slip(divide=False), "the tip strays by"),
    ("equation (8)", slip(evenly=True), "the tip strays by"),
    ("C the wrong way round", slip(mirrored=-1), "with the tool axis"),
    ("the pivot forgotten", slip(shift=(0, 0, 42)), "No block ends at record 1"),
    ("a turn too much", partial(turned_by, 360), "the tip strays by"),
    ("a machine with the other signs", partial(swapped, r"A\+", "A-"), "Out of travel: A"),
    ("lifted over the part", lifted_between, "Between records 1 and 2 the tool is lifted"),
    ("no program", lambda _: "HELLO", "cannot be used"),
]


@pytest.mark.parametrize(("wrong", "said"), [pytest.param(*each[1:], id=each[0]) for each in WRONG])
def test_a_wrong_program_is_refused_with_the_reason(wrong, said):
    assert said in str(exercise.judge("07c-program", wrong(by_hand(0))))
    assert exercise.judge("07c-program", wrong(by_hand(0))).status != RIGHT


def test_each_mixup_of_the_turn_is_wrong_on_some_part():
    """C = 0 at the pole, a branch out of travel, a branch that changes beside the pole."""
    assert [least_turn(21), least_turn(21, by_formula=True)] == pytest.approx([0, 36.8], abs=0.1)
    assert [least_turn(8), least_turn(8, travel=False)] == pytest.approx([180, 0], abs=0.1)
    assert [least_turn(1), least_turn(1, granted=9.0)] == pytest.approx([176.9, 59.5], abs=0.1)


@pytest.mark.parametrize(
    ("name", "answer", "said"),
    [
        ("07c-turn", np.pi, "in radians"),
        ("07c-inverse", lambda tip, axis: task(0).kin.inverse(tip, axis)[::-1], RIGHT),
        ("07c-inverse", lambda tip, axis: task(0).kin.inverse(tip, axis) + A_TURN, RIGHT),
        ("07c-inverse", lambda tip, axis: task(0).kin.inverse(tip, axis)[[0, 0]], "the same branch"),
        ("07c-inverse", lambda tip, axis: task(0).kin.inverse(tip, axis)[0], "an array of shape (5,)"),
        ("07c-inverse", lambda tip, axis: task(0).kin.inverse(tip, axis) * [1, 1, 1, 1, -1], "tool axis that is"),
        (
            "07c-inverse",
            lambda tip, axis: task(0).kin.inverse(tip + ABOVE, axis),
            "X Y Z take the tip 1.000 mm",
        ),
    ],
)
def test_judged(name, answer, said):
    assert said in str(exercise.judge(name, answer))


@pytest.mark.parametrize("seed", [8, 17, 19])
def test_between_records_the_nearest_record_is_not_the_nearest_place(seed):
    exercise = replace(EXERCISES["07c-pole"], drawn=lambda _: {"seed": seed}, student="one")
    assert "nearest record" in exercise.verdict(nearest_to_the_pole(seed, at_records=True)).mixup
    assert exercise.verdict(nearest_to_the_pole(seed)).status == RIGHT
