"""Rapid traverse where each axis runs at its own rate: every order of the axes, against what the path touches."""

from dataclasses import replace
from itertools import pairwise, permutations

import numpy as np
import pytest

from mathpost import load_machine, postprocess
from mathpost.kinematics import Kinematics
from mathpost.path import cl as cldata
from tests.conftest import DATA
from tests.independent import judge
from tests.independent.drawn import NEAR, OWN_RATE, RADIUS, goto, in_column
from tests.independent.machine_model import Model
from tests.independent.reader import Setup, read

MACHINES = ("ac_table", "bc_table", "head_b_table_c", "ac_head", "nutating_head_table")
LENGTHS = {3: 80.0, 8: 116.5}


def job(rng, setup):
    """CL data of passes with rapid moves of all kinds between them, for two tools, and the lines that are cut."""
    lines, cuts = ["UNITS/MM", "SPINDL/RPM,4000,CLW"], []
    kin = Kinematics(setup)
    tilted = rng.random() < 0.4
    for tool in LENGTHS:
        lines += [f"LOAD/TOOL,{tool},LENGTH,{LENGTHS[tool]:g}"]
        base = rng.uniform([8, -60], [35, 60])
        for _ in range(rng.integers(2, 5)):
            centre = rng.uniform([-40, -40, -10], [40, 40, 10])
            turn, count = rng.uniform(0, 2 * np.pi), int(rng.integers(2, 7))
            t = np.linspace(-1, 1, count)[:, None] * rng.uniform(5, 40)
            bend = rng.uniform(-0.01, 0.01)
            points = centre + t * [np.cos(turn), np.sin(turn), rng.uniform(-0.5, 0.5)] + bend * t**2 * [0, 0, 1]
            swing = 0.0 if tilted else rng.uniform(-6, 6)
            angles = base + np.linspace(0, swing, count)[:, None] * [1, 1]
            axes = kin.forward(np.c_[np.zeros((count, 3)), angles], degrees=True)[1]
            above = points[0] + rng.uniform(2, 40) * axes[0]
            if rng.random() < 0.5:
                above += rng.uniform(-25, 25, 3)
            lines += ["RAPID", goto(above, axes[0])]
            if rng.random() < 0.5:
                lines += ["RAPID", goto(points[0] + 1.0 * axes[0], axes[0])]
                above = points[0] + 1.0 * axes[0]
            lines.append("FEDRAT/700,MMPM")
            cut = [above, *points]
            lines += [goto(point, axis) for point, axis in zip(points, axes, strict=True)]
            leave = points[-1] + rng.uniform(1, 50) * axes[-1] + rng.uniform(-15, 15, 3) * (rng.random() < 0.5)
            lines += ["RAPID", goto(leave, axes[-1])]
            cuts += list(pairwise(cut))
    return "\n".join(lines) + "\n", np.array(cuts)


def ways(rng, start, end):
    """Ways from axes to axes, (m, 5) each: one after the other in every order, and all at once at random rates."""
    moving = np.flatnonzero(np.abs(end - start) > 2e-3)
    orders = list(permutations(moving))
    for order in orders if len(orders) <= 24 else [orders[n] for n in rng.choice(len(orders), 24, replace=False)]:
        corners = [start]
        for axis in order:
            corners.append(np.where(np.arange(len(start)) == axis, end, corners[-1]))
        yield np.concatenate([np.linspace(a, b, 25) for a, b in pairwise(corners)])
    for _ in range(6):
        soon = rng.uniform(0.2, 1, len(start))  # when each arrives
        yield start + np.clip(np.linspace(0, 1, 60)[:, None] / soon, 0, 1) * (end - start)


def deepest(seed):
    """How deep what is touched is in the tool on any way of a rapid move of several axes, mm."""
    rng = np.random.default_rng(seed)
    name, control = MACHINES[seed % len(MACHINES)], OWN_RATE[seed % len(OWN_RATE)]
    setup = replace(load_machine(name), program_head=("G40",))
    text, cuts = job(rng, setup)
    result = postprocess(cldata.parse(text, "job.cl"), setup, dialect=control, tcp=bool(seed // 2 % 2))
    model = Model(DATA / "machines" / f"{name}.toml", origin=setup.origin)
    t = np.linspace(0, 1, 60)[:, None, None]
    swept = (cuts[:, 0] + t * (cuts[:, 1] - cuts[:, 0])).reshape(-1, 3)
    worst = 0.0
    for move in read(result.program, control, Setup(model, lengths=LENGTHS)):
        ends = [np.r_[move.nose(model, t), move.angles(t)] for t in (0.0, 1.0)]
        if np.isnan(ends).any():
            continue
        if move.kind == "feed":  # what the tool has had in it is air
            for part in np.linspace(0, 1, 30):
                pose = model.place(move.nose(model, part), move.angles(part), move.tool_length)
                swept = swept[~in_column(swept, *pose, RADIUS)]
        if move.kind == "rapid" and not move.cycle and (np.abs(ends[1] - ends[0]) > 2e-3).sum() > 1:
            for axes in np.concatenate(list(ways(rng, *ends))):
                tip, axis = model.place(axes[:3], axes[3:], move.tool_length)
                found = judge.depth_in_tool(swept, tip + NEAR * axis, axis, RADIUS, 50 - NEAR)
                worst = max(worst, found)
    return worst


@pytest.mark.parametrize("seed", [7, 8])
def test_rapid_moves_are_clear_in_every_order_of_the_axes(seed, of):
    for each in of([seed], range(seed - 2, 305, 2)):
        assert deepest(each) < 0.01, each
