"""Lines of a program that are no straight moves by their words: vectors of the tool axis, arcs, drilling cycles.

A function here takes the reader (`mathpost.shop.controls.reader`), which keeps what holds, and the line.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mathpost.shop.controls import curves
from mathpost.shop.controls.curves import PLANES
from mathpost.shop.controls.lines import Drilling, Line, seconds

LEAN = 0.05  # degrees, that a tool may be off the axis of a drilling cycle: printed digits of a plane

if TYPE_CHECKING:
    from mathpost.shop.controls.reader import Lines


def point(reader: Lines, line: Line, arc: str) -> None:
    """Make words of the rotary axes of a tool axis that is stated as a vector."""
    word = "centre" if reader.vectors else "tool axis"
    given = [line.values.get(f"{word} {letter}") for letter in "XYZ"]
    if all(value is None for value in given):
        return
    if arc:
        raise reader.error("a straight move where the tool axis is a vector", "an arc")
    line.used(word)
    angles = reader.at.angles_along([value or 0.0 for value in given])
    line.axes |= {name: (angle, "absolute") for name, angle in zip(reader.names[3:], angles, strict=True)}


def turn(reader: Lines, line: Line, clockwise: bool) -> None:
    """Run an arc or a helix; rotary axes that are named turn along with it."""
    start, end, values = reader.at.words.copy(), reader.target(line), line.values
    if np.isnan(start[:3]).any():
        raise reader.error("X, Y and Z before an arc", "not all")
    line.used("centre ", "turns", "full turns", "sweep")
    if "radius" in values:
        if any(name.startswith("centre ") for name in values):
            raise reader.error("a radius of the arc or its centre", "both")
        line.used("radius")
        centre = curves.centre_of(start[:3], end[:3], values["radius"] * reader.scale, reader.plane, clockwise)
    elif any(name.startswith("centre ") for name in values):
        base = np.zeros(3) if reader.absolute_centre else start[:3]
        centre = start[:3].copy()
        for axis, letter in enumerate("XYZ"):
            for name, counted_from in ((f"centre {letter}", base[axis]), (f"centre at {letter}", 0.0)):
                if name in values:
                    centre[axis] = counted_from + values[name] * reader.scale
    elif reader.centre is not None:
        centre = reader.centre
    else:
        raise reader.error("a centre or a radius of the arc", "neither")
    turns = int(values.get("turns", 1)) - 1 + int(values.get("full turns", 0))
    if "sweep" in values:
        end[:3], turns = curves.swept(start[:3], end[:3], centre, reader.plane, values["sweep"])
    points = curves.arc(start[:3], end[:3], centre, reader.plane, clockwise, turns)
    t = np.arange(1, len(points) + 1)[:, None] / len(points)
    reader.put(np.c_[points, start[3:] + t * (end[3:] - start[3:])], line, np.zeros(len(points), bool))


def holes(reader: Lines, place: np.ndarray, axis: int, heights: curves.Heights) -> None:
    """Take the moves of one hole at a place, words of shape (j,)."""
    _refuse_tilted(reader, place, axis)
    height = reader.at.words[axis]
    place = place.copy()
    place[axis] = height
    points, rapid = curves.hole(place[:3], axis, heights)
    points = np.c_[points, np.repeat(place[None, 3:], len(points), axis=0)]
    moved = (np.diff(points, axis=0, prepend=reader.at.words[None]) != 0).any(axis=1)
    motion, reader.motion = reader.motion, "linear"
    reader.put(points[moved], Line(), np.array(rapid)[moved])
    reader.motion = motion
    reader.wait(heights.dwell)


def _refuse_tilted(reader: Lines, place: np.ndarray, axis: int) -> None:
    """Where words name the tip, a hole goes along one of their axes, and the tool has to lie along it."""
    if not reader.at.on_tip:
        return
    if not np.array_equal(place[3:], reader.at.words[3:], equal_nan=True):
        raise reader.error("rotary axes that stand still in a drilling cycle", "a position of one")
    lean = np.degrees(np.arccos(np.clip(abs(reader.at.tool_axis()[axis]), 0, 1)))
    if lean > LEAN:
        where = "with TCP" if reader.at.tcp else "on the tilted plane"
        raise reader.error(
            f"the tool along {reader.names[axis]} of the program for a drilling cycle {where}",
            f"{lean:.3f}° off it",
        )


def drill(reader: Lines) -> None:
    """Do the cycle that is defined by its surface, depth, clearance and height to leave, where the tool is."""
    surface = reader.defined.get("cycle surface", np.nan)
    depth = reader.defined.get("cycle depth", np.nan)
    clearance = reader.defined.get("cycle clearance", np.nan)
    if np.isnan([surface, depth, clearance]).any():
        raise reader.error("a cycle with surface, depth and clearance before its call", "none")
    leave = surface + max(clearance, reader.defined.get("cycle retract", 0.0))
    before, feed = reader.feed, reader.defined.get("cycle feed", reader.feed)
    if "cycle pitch" in reader.defined:
        feed = abs(reader.defined["cycle pitch"]) * reader.speed
    slow = reader.defined.get("cycle feed out") in (0.0, feed)
    reader.feed = feed
    dwell = reader.defined.get("cycle dwell", 0.0)
    holes(reader, reader.at.words, 2, curves.Heights(surface + clearance, surface + depth, leave, slow, dwell))
    reader.feed = before


def hole(reader: Lines, cycle: Drilling, line: Line) -> None:
    """Do the drilling cycle that is on, at the place of the line."""
    axis = PLANES[reader.plane][2]
    if any(name.startswith("centre ") for name in line.values):
        raise reader.error("a drilling cycle without I J K, which may repeat it", "one of them")
    for name in ("radius", "cycle clearance"):
        if name in line.values:
            cycle.clearance = line.values[name] * reader.scale
            if reader.incremental:
                cycle.clearance += cycle.initial
    if reader.names[axis] in line.axes:
        bottom = line.axes.pop(reader.names[axis])[0] * reader.scale
        cycle.bottom = cycle.clearance + bottom if reader.incremental else bottom
    for name, word in line.waiting.items():
        if name == "turns" or name.startswith("argument P"):  # counted as behind G4
            cycle.dwell = seconds(reader.control.read.get("G4 P{}", ""), word.removeprefix("P"))
    line.used("axis ", "radius", "argument", "turns")  # how it pecks
    place = reader.target(line)
    leave = max(cycle.initial, cycle.clearance) if reader.leave == "initial" else cycle.clearance
    holes(reader, place, axis, curves.Heights(cycle.clearance, cycle.bottom, leave, cycle.slow, cycle.dwell))
