"""The length of a test bar and the radius of its ball, from touching a gauge in a known place."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mathpost.errors import InputError
from mathpost.machine import LETTERS, Machine
from mathpost.rotation import unit
from mathpost.shop.compensate.positioning import scatter
from mathpost.shop.measure.fit import Value

if TYPE_CHECKING:
    from mathpost.shop.measure.csv_table import Table

SQUARE = 1e-6  # sine of an angle that is none


def bar(table: Table, machine: Machine) -> dict[str, Value]:
    """By how much a bar is longer than the tool, and the radius of its ball, mm, as far as they were touched."""
    tool = unit(machine.tool_axis)
    lengths: list[float] = []
    radii: list[float] = []
    table.need(("face", "at", "shown"), "columns face, at, shown")
    size = table.unit("shown", "length")
    for row, (face, at, shown) in enumerate(zip(table["face"], table["at"], table["shown"], strict=True)):
        sign, letter = {"+": 1, "-": -1, "−": -1}.get(face[:1], 0), face[1:].upper()
        along = sign * tool["XYZ".index(letter)] if sign and letter in LETTERS else np.nan
        if not (abs(along) < SQUARE or along > 1 - SQUARE):
            expected = "the side that the bar comes from: +X, -X and so on, along the tool or square to it"
            raise InputError(table.where(row, "face"), expected, repr(face))
        (lengths if along > 0.5 else radii).append(sign * size * (shown - at))
    found = {key: each for key, each in (("length", lengths), ("radius", radii)) if each}
    sigma, freedom = scatter(table, found.values(), size, "a face touched twice")
    return {key: Value(float(np.mean(each)), sigma / len(each) ** 0.5, freedom) for key, each in found.items()}
