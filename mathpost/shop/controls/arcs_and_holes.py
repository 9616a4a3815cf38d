"""Lines of a program that are no straight moves by their words: arcs, drilling cycles, tool axes that are vectors.

A function that takes the reader (`mathpost.shop.controls.reader`), which keeps what holds, and the line, runs them;
the others make points of them, in the coordinates that the words are in.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from mathpost.errors import InputError
from mathpost.path import arcs
from mathpost.path.nc_words import arguments, numbers
from mathpost.shop.controls.blocks import PLANES
from mathpost.shop.controls.lines import Drilling, Line, seconds

if TYPE_CHECKING:
    from mathpost.shop.controls.reader import ProgramReader

CHORD = 0.0001  # mm, between an arc and the points that are made of it
LEAN = 0.05  # degrees, that a tool may be off the axis of a drilling cycle: printed digits of a plane
# Cycles of Siemens: whether the tool comes out at its feed, and which of their numbers is the wait.
OUT_AT_FEED = {"CYCLE81": False, "CYCLE82": False, "CYCLE83": False, "CYCLE84": True, "CYCLE85": True,
               "CYCLE86": False, "CYCLE87": False, "CYCLE88": False, "CYCLE89": True, "CYCLE840": True}  # fmt: skip
WAITS = {"CYCLE83": 8} | dict.fromkeys(
    ("CYCLE82", "CYCLE84", "CYCLE840", "CYCLE85", "CYCLE86", "CYCLE88", "CYCLE89"), 5
)


@dataclass(frozen=True)
class Heights:
    """How a drilling cycle goes: to the clearance, to the bottom and out, mm."""

    clearance: float
    bottom: float
    leave: float
    slow: bool = False  # whether the tool comes out at its feed
    dwell: float = 0.0  # seconds that it waits at the bottom; below 0 turns of the spindle


def point(reader: ProgramReader, line: Line, arc: str) -> None:
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


def turn(reader: ProgramReader, line: Line, clockwise: bool) -> None:
    """Run an arc or a helix; rotary axes that are named turn along with it."""
    start, end, values = reader.at.words.copy(), reader.target(line), line.values
    if np.isnan(start[:3]).any():
        raise reader.error("X, Y and Z before an arc", "not all")
    line.used("centre ", "turns", "full turns", "sweep")
    if "radius" in values:
        if any(name.startswith("centre ") for name in values):
            raise reader.error("a radius of the arc or its centre", "both")
        line.used("radius")
        centre = centre_of(start[:3], end[:3], values["radius"] * reader.scale, reader.plane, clockwise)
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
        end[:3], turns = swept(start[:3], end[:3], centre, reader.plane, values["sweep"])
    points = arc(start[:3], end[:3], centre, reader.plane, clockwise, turns)
    t = np.arange(1, len(points) + 1)[:, None] / len(points)
    reader.put(np.c_[points, start[3:] + t * (end[3:] - start[3:])], line, np.zeros(len(points), bool))


def holes(reader: ProgramReader, place: np.ndarray, axis: int, heights: Heights) -> None:
    """Take the moves of one hole at a place, words of shape (j,)."""
    _refuse_tilted(reader, place, axis)
    height = reader.at.words[axis]
    place = place.copy()
    place[axis] = height
    points, rapid = _hole_points(place[:3], axis, heights)
    points = np.c_[points, np.repeat(place[None, 3:], len(points), axis=0)]
    moved = (np.diff(points, axis=0, prepend=reader.at.words[None]) != 0).any(axis=1)
    motion, reader.motion = reader.motion, "linear"
    reader.put(points[moved], Line(), np.array(rapid)[moved])
    reader.motion = motion
    reader.wait(heights.dwell)


def _refuse_tilted(reader: ProgramReader, place: np.ndarray, axis: int) -> None:
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


def drill(reader: ProgramReader) -> None:
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
    holes(reader, reader.at.words, 2, Heights(surface + clearance, surface + depth, leave, slow, dwell))
    reader.feed = before


def hole(reader: ProgramReader, cycle: Drilling, line: Line) -> None:
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
    holes(reader, place, axis, Heights(cycle.clearance, cycle.bottom, leave, cycle.slow, cycle.dwell))


def centre_of(start: np.ndarray, end: np.ndarray, radius: float, plane: str, clockwise: bool) -> np.ndarray:
    """Return the centre of an arc by its radius: positive for less than half a turn, negative for more.

    Examples
    --------
    >>> centre_of(np.array([10.0, 0, 0]), np.array([0.0, 10, 0]), 10, "XY", clockwise=False).round(6) + 0.0
    array([0., 0., 0.])
    """
    first, second, _ = PLANES[plane]
    chord = end[[first, second]] - start[[first, second]]
    half = np.linalg.norm(chord) / 2
    if half == 0:
        raise InputError("arc", "ends apart, or a centre", f"equal ends and the radius {radius:g}")
    if half > abs(radius) + arcs.SAME_RADIUS:
        raise InputError("arc", f"a radius of {half:.4f} at least", f"{radius:g}")
    rise = np.sqrt(max(float(radius**2 - half**2), 0.0)) / (2 * half)
    across = np.array([-chord[1], chord[0]]) * rise
    centre = start.copy()
    centre[[first, second]] += chord / 2 + across * (-1 if clockwise == (radius > 0) else 1)
    return centre


def arc(
    start: np.ndarray, end: np.ndarray, centre: np.ndarray, plane: str, clockwise: bool, turns: int = 0
) -> np.ndarray:
    """Return the points of an arc or a helix behind its start, shape (n, 3)."""
    axis = np.zeros(3)
    axis[PLANES[plane][2]] = -1.0 if clockwise else 1.0
    return arcs.arc(start, end, centre, axis, CHORD, turns)


def swept(
    start: np.ndarray, end: np.ndarray, centre: np.ndarray, plane: str, degrees: float
) -> tuple[np.ndarray, int]:
    """Return where an arc by its angle ends, with the height of `end`, and how many full turns it makes before.

    Examples
    --------
    >>> end, turns = swept(np.array([10.0, 0, 0]), np.array([10.0, 0, -2]), np.zeros(3), "XY", -450)
    >>> end.round(6) + 0.0, turns
    (array([  0., -10.,  -2.]), 1)
    """
    first, second, _ = PLANES[plane]
    angle, (u, v) = np.deg2rad(degrees), (start - centre)[[first, second]]
    found = np.array(end)
    found[first] = centre[first] + u * np.cos(angle) - v * np.sin(angle)
    found[second] = centre[second] + u * np.sin(angle) + v * np.cos(angle)
    return found, max(int(np.ceil(abs(degrees) / 360 - 1e-9)) - 1, 0)


def _hole_points(at: np.ndarray, axis: int, heights: Heights) -> tuple[np.ndarray, list[bool]]:
    """Return the points of a drilling cycle at `at`, (n, 3), and which moves to them are rapid.

    The tool comes at its present height. Where it pecks or breaks chips it stays on this way.
    """
    levels = [at[axis], heights.clearance, heights.bottom]
    rapid = [True, True, False]
    if heights.slow:
        levels.append(heights.clearance)
        rapid.append(False)
    if levels[-1] != heights.leave:
        levels.append(heights.leave)
        rapid.append(True)
    points = np.repeat(at[None], len(levels), axis=0)
    points[:, axis] = levels
    return points, rapid


def heights(text: str) -> Heights:
    """Return the heights of a cycle of Siemens.

    CYCLE81 and the like begin with the planes to which the tool comes out and of the surface, the distance in front
    of it, the depth and, if that is left out, how far below the surface it is. How long it waits is further back.
    """
    name, given = arguments(text.removeprefix("MCALL"))
    try:
        values = numbers(given)
    except ValueError:
        raise InputError(name, "numbers", ",".join(given)) from None
    if name not in OUT_AT_FEED or len(given) < 4:
        raise InputError(name, "CYCLE81 to CYCLE89 or CYCLE840, with four numbers", f"{len(given)}")
    leave, surface, distance, bottom, below = [*values, 0.0][:5]
    if below and not given[3]:
        bottom = surface - abs(below)
    dwell = dict(enumerate(values)).get(WAITS.get(name, -1), 0.0)
    return Heights(surface + abs(distance), bottom, leave, OUT_AT_FEED[name], dwell)
