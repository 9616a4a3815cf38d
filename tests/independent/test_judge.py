"""The judge against figures that are worked out by hand."""

import math

import numpy as np

from . import judge
from .test_reader import model, run


def test_distances():
    ex, ey, ez = np.eye(3)
    assert judge.to_segment(np.array([5.0, 3, 0]), 0 * ex, 10 * ex) == 3
    assert judge.to_segment(np.array([13.0, 4, 0]), 0 * ex, 10 * ex) == 5
    points = np.array([[5.0, 3, 0], [13, 4, 0], [9, -4, 0]])
    assert judge.to_path(points, np.array([0 * ex, 10 * ex, 10 * ex, [10, -9, 0]])).tolist() == [3, 5, 1]
    tilted = np.array([math.sqrt(0.5) * math.cos(0.01), math.sqrt(0.5) * math.cos(0.01), math.sin(0.01)])
    assert math.isclose(judge.to_great_circle(tilted, ex, ey), math.degrees(0.01))
    assert math.isclose(judge.to_great_circle(ez, ex, ey), 90)
    assert math.isclose(judge.to_great_circle(-ex, ex, ey), 90)


def test_sagitta_of_straight_joints():
    """ac_table, C turns 20° while its slides run straight: the tip's chord is cut 60·(1 − cos 10°) deep."""
    machine = model("ac_table")
    b = math.radians(-20)
    program = ["G0 X60. Y0 Z0", f"G1 X{60 * math.cos(b):.9f} Y{60 * math.sin(b):.9f} C20. F100."]
    moves = run(machine, "fanuc", program)
    samples = judge.sample(machine, moves[1:])
    tip, axis, _ = judge.along_records(
        samples.tip, samples.axis, np.array([[60.0, 0, 0]] * 2), np.array([[0.0, 0, 1]] * 2)
    )
    assert math.isclose(tip.max(), 60 * (1 - math.cos(math.radians(10))), rel_tol=1e-6)
    assert axis.max() < 1e-6


def test_records_in_order():
    tips = np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0]])
    axes = np.tile([0.0, 0, 1], (3, 1))
    assert judge.records_missed(tips, axes, tips, axes, 1e-6, 1e-6) == []
    assert judge.records_missed(tips, axes, tips[::-1], axes, 1e-6, 1e-6) == [1, 2]


def test_time_of_a_turn():
    """ac_table, C at most 120°/s and 800°/s²: 90° take 0.75 s, and 0.9 s from rest to rest."""
    machine = model("ac_table")
    move = run(machine, "fanuc", ["G0 C90."])[0]
    assert math.isclose(judge.at_constant_speed(machine, move), 0.75)
    assert math.isclose(judge.rest_to_rest(machine, move), 0.75 + 120 / 800)
    short = run(machine, "fanuc", ["G0 C8."])[0]
    assert math.isclose(judge.rest_to_rest(machine, short), 2 * math.sqrt(8 / 800))


def test_a_feed_beyond_the_axes():
    machine = model("ac_table")
    moves = run(machine, "fanuc", ["G93 G1 C90. F120."])  # half a second for 90 degrees
    assert judge.exceeded_rates(machine, moves) == [(1, "C", 1.5)]
    assert math.isclose(judge.at_constant_speed(machine, moves[0]), 0.75)


def test_travel_of_the_slides():
    """bc_table: Z of the slide is the word + 40 + 150; its end is 400."""
    machine = model("bc_table")
    moves = run(machine, "fanuc", ["G0 Z209.", "Z211."])
    found = judge.beyond_travel(machine, moves, judge.sample(machine, moves))
    assert {(line, letter) for line, letter, _ in found} == {(2, "Z")}


def test_the_body_of_the_tool():
    machine = model("ac_table")
    up = (machine.nose_of_words([0, 0, 0], 120), [0, 0])
    points = np.array([[3.0, 0, 10]])
    assert judge.clear(machine, [up], points, radius=2.9, length=50) == (0.0, None)
    assert judge.clear(machine, [up], points, radius=4, length=50) == (1.0, 0)
    assert judge.clear(machine, [up], points, radius=4, length=9) == (0.0, None)
