"""A machine with other axes, points and spindle: what `calibrate` seeks, by name, put into a machine file."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from mathpost.errors import InputError
from mathpost.rotation import unit
from mathpost.shop.compensate.model import SQUARENESS, named_point
from mathpost.shop.measure import rotary_axis

if TYPE_CHECKING:
    from mathpost.machine import Machine


def unknowns(machine: Machine) -> list[str]:
    """Return the names of the geometry's unknowns; of two that readings cannot tell apart the later is given up."""
    errors = [rotary_axis.location_errors(each)[0] for each in machine.rotary]
    spindle = ["EA0S", "EB0S"] if any(each.carries == "tool" for each in machine.rotary) else []
    offsets, tilts = ([name for each in errors for name in each[part]] for part in (slice(2), slice(2, 4)))
    return [*offsets, *tilts, *spindle, *SQUARENESS]


def displayed(machine: Machine, values: dict[str, float]) -> Machine:
    """Return `machine` moved by `values` as a control that does not know of its leaning spindle displays it.

    The tip of the machine's tool is at rotary zero beside where it is displayed, and so a table is displayed beside
    where it is. With a tool of another length it is so by another amount.
    """
    found = moved(machine, values)
    aside = machine.tool_length * (np.array(found.tool_axis) - unit(machine.length_axis or machine.tool_axis))
    tables = [
        replace(each, point=tuple((each.point + aside).tolist())) if each.carries == "workpiece" else each
        for each in found.rotary
    ]
    named = machine.programmed_point
    if named != "tip" and aside.any():
        named = tuple(named_point(machine, 0.0) - aside)
    return replace(found, rotary=tuple(tables), programmed_point=named)


def moved(machine: Machine, values: dict[str, float]) -> Machine:
    """Return `machine` as it is: its axes, points and tool moved by `values`, in the coordinates of its slides.

    Squareness is not in a machine file. If the spindle leans, the control goes on adding the length of a tool along
    the axis that it believes in.
    """
    names = unknowns(machine)
    for name in set(values) - set(names):
        raise InputError("values", f"unknowns among {', '.join(names)}", repr(name))
    values = dict.fromkeys(names, 0.0) | values
    tool = unit(machine.tool_axis)
    lean = np.cross([values.get("EA0S", 0.0), values.get("EB0S", 0.0), 0.0], tool)
    rotary = tuple(rotary_axis.corrected(each, values) for each in machine.rotary)
    along = (machine.length_axis or machine.tool_axis) if lean.any() else machine.length_axis
    return replace(machine, rotary=rotary, tool_axis=tuple(unit(tool + lean).tolist()), length_axis=along)
