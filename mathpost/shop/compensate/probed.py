"""Probed features where no machine can have them: one that does not move, rows far from all others."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from mathpost.shop.compensate.held import tips
from mathpost.shop.compensate.readings import PROBED, Readings

if TYPE_CHECKING:
    from mathpost.machine import Machine
    from mathpost.shop.compensate.readings import Read

STILL, TURNED = 0.2, 20  # mm, degrees: a feature that moves by less while a table turns by more is on its axis
CLOSE = 2.0  # mm between readings of one feature, brought to rotary zero by the machine file
NAMED = 3  # rows
MOST = 1000  # rows that are held against each other


def unmoved(machine: Machine, blocks: Sequence[Readings]) -> list[str]:
    """Sentences on probed features that stay where they are while a table turns."""
    found = []
    for block in blocks:
        read = [name for name in "xyz" if name in {column for _, column in block.rows}]
        shown = block.joints[:, ["xyz".index(name) for name in read]]
        for n, rotary in enumerate(machine.rotary):
            turned = np.degrees(np.ptp(block.joints[:, 3 + n]))
            stood = len(read) > 1 and np.ptp(shown, axis=0).max() < STILL
            if rotary.carries == "workpiece" and turned > TURNED and stood:
                said = f"what was probed stays where it is while {rotary.name} turns by {turned:.0f}°"
                found.append(f"{block.where}: {said}: it is on the axis, or the table did not turn")
    return found


def unexplained(machine: Machine, read: Sequence[Read]) -> list[str]:
    """Return sentences on what may be wrong with files of probed features that no machine explains."""
    blocks = [each for each in read if isinstance(each, Readings) and each.method in PROBED]
    still = unmoved(machine, blocks)
    return still or [f"{block.where}: {said}" for block in blocks for said in _far(machine, block)]


def _far(machine: Machine, block: Readings) -> Iterator[str]:
    """The rows, of the first `MOST`, that are far from where most rows of the same feature have it."""
    every = np.unique([line for line, _ in block.rows], return_index=True)
    lines, first = (each[:MOST] for each in every)
    places, setup = tips(machine, block.joints[first], block.length[first])[0], block.setup[first]
    away = np.linalg.norm(places[:, None] - places, axis=2)
    away[setup[:, None] != setup] = np.nan
    near = (away < CLOSE).sum(axis=1)
    best = int(np.argmax(near))
    others = [n for n in np.argsort(-away[best]) if away[best][n] > CLOSE]
    if others and near[best] > max(1, len(others)):
        named = ", ".join(f"line {lines[n]} is {away[best][n]:.4g} mm" for n in others[:NAMED])
        yield f"{named} off from where line {lines[best]} and {near[best] - 1} more have it: look at the digits"
    elif others:
        most = f"{np.nanmax(away):.4g} mm"
        wrong = "the sign or the letter of an axis, machine coordinates, or the machine file?"
        yield f"brought to rotary zero by the machine file, readings of one feature are up to {most} apart: {wrong}"
