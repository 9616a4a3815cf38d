"""A machine with other axes, points and spindle: what `calibrate` seeks, by name, put into a machine file."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from mathpost.compensate.model import SQUARENESS, named_point
from mathpost.errors import InputError
from mathpost.measure import rotary_axis
from mathpost.rotation import unit

if TYPE_CHECKING:
    from mathpost.machine import Machine


def unknowns(machine: Machine) -> list[str]:
    """Return the names of the geometry's unknowns, those first that are given up last."""
    errors = [rotary_axis.location_errors(each)[0] for each in machine.rotary]
    spindle = ["EA0S", "EB0S"] if any(each.carries == "tool" for each in machine.rotary) else []
    offsets, tilts = ([name for each in errors for name in each[part]] for part in (slice(2), slice(2, 4)))
    return [*offsets, *tilts, *spindle, *SQUARENESS]


def corrected(machine: Machine, values: dict[str, float]) -> Machine:
    """Return `machine` with its axes, points and tool moved by `values`; squareness is not in a machine file.

    Machine coordinates are those at which the tip of the machine's tool is displayed at rotary zero: if the spindle
    leans, so does the tool, and a table is displayed beside where it is.
    """
    found = moved(machine, values)
    aside = machine.tool_length * (np.array(found.tool_axis) - unit(machine.tool_axis))
    tables = [
        replace(each, point=tuple((each.point + aside).tolist())) if each.carries == "workpiece" else each
        for each in found.rotary
    ]
    named = machine.programmed_point
    if named != "tip" and aside.any():
        named = tuple(named_point(machine, 0.0) - aside)
    return replace(found, rotary=tuple(tables), programmed_point=named)


def moved(machine: Machine, values: dict[str, float]) -> Machine:
    """The axes, points and tool of `machine` moved by `values`, in the coordinates of its slides."""
    names = unknowns(machine)
    for name in set(values) - set(names):
        raise InputError("values", f"unknowns among {', '.join(names)}", repr(name))
    values = dict.fromkeys(names, 0.0) | values
    tool = unit(machine.tool_axis)
    tool = unit(tool + np.cross([values.get("EA0S", 0.0), values.get("EB0S", 0.0), 0.0], tool))
    rotary = tuple(rotary_axis.corrected(each, values) for each in machine.rotary)
    return replace(machine, rotary=rotary, tool_axis=tuple(tool.tolist()))
