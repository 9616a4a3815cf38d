"""What readings leave open, in a sentence: which unknowns they cannot separate, and what would."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from mathpost.compensate.held import held
from mathpost.compensate.model import SQUARENESS
from mathpost.compensate.problem import Problem
from mathpost.rotation import unit

if TYPE_CHECKING:
    from mathpost.compensate.readings import Readings
    from mathpost.machine import Machine

MORE = 200  # mm by which a ball or a tool is moved


def reason(problem: Problem, name: str, expanded: float) -> str:
    """Say why `name` is not determined, what would determine it, and with which U it is taken for nothing."""
    taken = f"taken for 0 ± {1e6 * expanded:.0f} µrad, which is in U"
    others = problem.reasons.get(name) or []
    if name in SQUARENESS:
        return f"the readings do not determine it: {taken}"
    from_what = " and ".join(others) or "where the ball stands"
    enough = [words for words, blocks in _candidates(problem) if _separates(problem, blocks, name)]
    advice = f" Also {', or '.join(enough[:2])}." if enough else ""
    return f"these readings cannot separate {name} from {from_what}.{advice} It is {taken}"


def _separates(problem: Problem, blocks: list[Readings], name: str) -> bool:
    more = Problem(problem.machine, [*problem.blocks, *blocks], problem.tables)
    return name not in more.reasons


def _candidates(problem: Problem) -> Iterator[tuple[str, list[Readings]]]:
    """Words, and the files of readings that would come to those that there are."""
    machine = problem.machine
    blocks = [each for each in problem.blocks if each.method not in ("dial", "tip", "ballbar")]
    yield "read all of x, y and z", [_all_three(each) for each in blocks]
    for rotary in machine.rotary:
        if rotary.carries == "workpiece":
            words = f"move the ball {MORE} mm along the axis of {rotary.name}"
            yield words, [_moved(each, machine, target=MORE * unit(rotary.axis)) for each in blocks]
    yield f"take a tool {MORE} mm longer", [_moved(each, machine, length=MORE) for each in problem.blocks]
    for n, rotary in enumerate(machine.rotary):
        turned = np.deg2rad(30) * np.eye(2)[n]
        yield f"read with {rotary.name} at other angles", [_moved(each, machine, turned=turned) for each in blocks]


def _all_three(block: Readings) -> Readings:
    """The poses of a file, read along X, Y and Z."""
    count = len(block.value)
    return replace(
        block,
        joints=np.repeat(block.joints, 3, axis=0),
        reference=None if block.reference is None else np.repeat(block.reference, 3, axis=0),
        target=np.repeat(block.target, 3, axis=0),
        direction=np.tile(np.eye(3), (count, 1)),
        length=np.repeat(block.length, 3),
        value=np.zeros(3 * count),
        setup=np.repeat(block.setup, 3),
        order=np.repeat(block.order, 3),
    )


def _moved(
    block: Readings, machine: Machine, target: np.ndarray | float = 0.0, length: float = 0.0,
    turned: np.ndarray | float = 0.0,
) -> Readings:  # fmt: skip
    """The readings of a file with the ball, the tool or an axis elsewhere."""
    place, tool = block.target + target, block.length + length
    joints = held(machine, place, block.joints[:, 3:] + turned, tool)[0]
    reference = block.reference
    if reference is not None:
        reference = held(machine, place, reference[:, 3:], tool)[0]
    return replace(block, joints=joints, reference=reference, target=place, length=tool)
