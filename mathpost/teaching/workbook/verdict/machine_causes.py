"""What somebody did to the words of a machine that are wrong: the causes that `mathpost explain` knows, by name."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from mathpost.detective.positions import explain_linear
from mathpost.detective.rotary_axes import explain_joints
from mathpost.rotation import unit

if TYPE_CHECKING:
    from mathpost.detective.explanation import Misreading
    from mathpost.teaching.workbook.meaning.words import Words
    from mathpost.teaching.workbook.report import Fault
    from mathpost.teaching.workbook.sheet.place import Place

TOLD = 2  # decimals of a mm that tell a cause: the words may be made of rounded tool axes
WORDS = 11  # tip, axis and five words
ROWS = 40  # as many say what all do
VAGUE = r"no single change|is not what belongs there| off$|demands"  # what says nothing of the cause
NAMES: dict[str, str] = {
    "transpose": "transposed",
    "exchange": "exchanged",
}  # of kinds that are called otherwise here


def is_of_the_machine(row: Words) -> bool:
    """Whether the point that X Y Z name is the tip, the nose or a pivot of the machine, so that it may be meant.

    Or the one that the machine file means, for a control that adds the length of the tool.
    """
    machine = row.kinematics.machine
    if _near(row.further, [-machine.tool_length]):
        return True
    up = unit(np.array(machine.tool_axis, dtype=float))
    own = {"tip": -machine.tool_length, "nose": 0.0}
    pivots = [float(up @ joint.point) for joint in machine.rotary if joint.carries == "tool"]
    named = machine.programmed_point
    here = own[named] if isinstance(named, str) else float(up @ named)
    points = [*own.values(), *pivots]
    if not np.any(row.back):
        return _near(here + row.further, points)
    # The same at rotary zero: the point itself, turned, or as if the tip were elsewhere.
    return _near(here - row.further, pivots) or _near(own["tip"] - row.further, points)


def _near(length: float, lengths: Sequence[float]) -> bool:
    return bool((np.abs(length - np.array(lengths)) < 10.0**-TOLD).any())


def by_cause(faults: list[Fault], table: list[Words], values: Mapping[Place, float | None]) -> list[Fault]:
    """The faults of a sheet; faults in most rows of a table are replaced by one common cause, if there is one.

    `values` are the contents of the cells.
    """
    for first, last in ((-2, None), (-5, -2)):  # rotary words, X Y Z
        places = [p for row in table for p in row.results[first:last]]
        vague = [fault for fault in faults if fault.place in places and re.search(VAGUE, fault.message)]
        if table[0].further or 2 * len(vague) <= len(table):
            continue
        if found := explained(table, values, first):
            for fault in vague:
                cause = NAMES.get(found.kinds[0], found.kinds[0])
                text = f"{fault.cell.rpartition('!')[2]}: {found.sentence}"
                faults[faults.index(fault)] = replace(fault, cause=cause, message=text)
    return faults


def explained(table: Sequence[Words], values: Mapping[Place, float | None], first: int) -> Misreading | None:
    """The single misreading that gives the rotary words (`first` -2) or X Y Z of a table, or None."""
    rows = table[:: -(-len(table) // ROWS)]
    written = [[values.get(p) for p in (*row.point, *row.axis, *row.results)] for row in rows]
    numbers = np.array(written, dtype=float)
    if numbers.shape[1] != WORDS or not np.isfinite(numbers).all():
        return None
    kinematics = rows[0].kinematics
    tip, axis, linear, own = np.split(numbers, (3, 6, 9), axis=1)
    own = own * rows[0].units
    if first == -2:
        found = [explain_joints(kinematics, axis, own)]
    else:  # they may follow from the rotary words, or from those that are demanded
        demanded = np.array([np.rad2deg(row.radians[0]) for row in rows])
        found = [explain_linear(kinematics, tip, a, linear, decimals=TOLD, together=1) for a in (demanded, own)]
    single = [each.misreadings[0] for each in found if each.explained and len(each.misreadings[0].kinds) == 1]
    return None if any(each.right for each in found) else next(iter(single), None)
