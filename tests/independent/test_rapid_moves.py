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
from tests.independent.machine_model import Model
from tests.independent.reader import Setup, read

MACHINES = ("ac_table", "bc_table", "head_b_table_c", "ac_head", "nutating_head_table")
CONTROLS = ("heidenhain", "fanuc", "siemens", "linuxcnc", "haas", "mazak")
OWN_RATE = ("fanuc", "haas", "mazak")  # G0 is no straight line: parameter 1401, setting 335
LENGTHS = {3: 80.0, 8: 116.5}
RADIUS, NEAR = 4.9, 0.05  # mm: of the tool, and above its tip, where what it slides over does not count


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
            lines += ["RAPID", _goto(above, axes[0])]
            if rng.random() < 0.5:
                lines += ["RAPID", _goto(points[0] + 1.0 * axes[0], axes[0])]
                above = points[0] + 1.0 * axes[0]
            lines.append("FEDRAT/700,MMPM")
            cut = [above, *points]
            lines += [_goto(point, axis) for point, axis in zip(points, axes, strict=True)]
            leave = points[-1] + rng.uniform(1, 50) * axes[-1] + rng.uniform(-15, 15, 3) * (rng.random() < 0.5)
            lines += ["RAPID", _goto(leave, axes[-1])]
            cuts += list(pairwise(cut))
    return "\n".join(lines) + "\n", np.array(cuts)


def _goto(point, axis):
    return "GOTO/" + ",".join(f"{value:.9f}" for value in [*point, *axis])


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


def deepest(seed, machines=MACHINES, controls=CONTROLS):
    """How deep what is touched is in the tool on any way of a rapid move of several axes, mm; and their number."""
    rng = np.random.default_rng(seed)
    name, control, tcp = machines[seed % len(machines)], controls[(seed // 5) % len(controls)], bool(seed // 2 % 2)
    head = ("; OURS",) if control == "heidenhain" else ("G40",)
    setup = replace(load_machine(name), program_head=head)
    text, cuts = job(rng, setup)
    result = postprocess(cldata.parse(text, "job.cl"), setup, dialect=control, tcp=tcp)
    model = Model(DATA / "machines" / f"{name}.toml", origin=setup.origin)
    moves = read(result.program, control, Setup(model, lengths=LENGTHS))
    t = np.linspace(0, 1, 60)[:, None, None]
    swept = (cuts[:, 0] + t * (cuts[:, 1] - cuts[:, 0])).reshape(-1, 3)
    worst, several = 0.0, 0
    for move in moves:
        ends = [np.r_[move.nose(model, t), move.angles(t)] for t in (0.0, 1.0)]
        if move.kind == "feed" and not np.isnan(ends).any():  # what the tool has had in it is air
            for part in np.linspace(0, 1, 30):
                tip, axis = model.place(move.nose(model, part), move.angles(part), move.tool_length)
                off = swept - tip
                along = off @ axis
                swept = swept[(along <= 0) | (np.linalg.norm(off - along[:, None] * axis, axis=1) > RADIUS)]
        if move.kind != "rapid" or move.cycle or np.isnan(ends).any():
            continue
        moving = (np.abs(ends[1] - ends[0]) > 2e-3).sum()
        if moving < 2 or control not in OWN_RATE:
            continue
        several += 1
        for way in ways(rng, *ends):
            for axes in way:
                tip, axis = model.place(axes[:3], axes[3:], move.tool_length)
                found = judge.depth_in_tool(swept, tip + NEAR * axis, axis, RADIUS, 50 - NEAR)
                if found > worst:
                    worst = found
    return worst, several, result


@pytest.mark.parametrize("seed", range(4))
def test_rapid_moves_are_clear_in_every_order_of_the_axes(seed, of):
    for each in of([5 + seed], range(5 + seed, 305, 4)):
        worst, _, _ = deepest(each)
        assert worst < 0.01, each
