"""What the words of a program may mean: the values in the [read] table of a control's file, and what they do.

A function here takes the reader (`mathpost.controls.reader`), which keeps what holds, and the line that the word
stands on. `MODES` hold at once, in the order of the line. `STATEMENTS` take the axes that the line names, when all
of it is read. `NUMBERS` wait for a word that needs them.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from mathpost.controls import curves, plane_blocks
from mathpost.controls.curves import PLANES
from mathpost.controls.lines import Drilling, Line

if TYPE_CHECKING:
    from mathpost.controls.reader import Lines


def _time(reader: Lines, *, inverse: bool = False, per_turn: bool = False) -> None:
    reader.inverse = inverse
    reader.per_turn = per_turn
    reader.feed = np.nan


def _counted(name: str, value: Any) -> Callable[[Lines, Line], None]:
    return lambda reader, line: setattr(reader, name, value)


def _said(name: str, value: Any) -> Callable[[Lines, Line], None]:
    return lambda reader, line: setattr(line, name, value)


def _cycle(slow: bool) -> Callable[[Lines, Line], None]:
    """A drilling cycle that is done at every place from now on."""

    def begin(reader: Lines, line: Line) -> None:
        height = reader.at.words[PLANES[reader.plane][2]]
        reader.motion = "linear"
        reader.cycle = Drilling(height, slow)

    return begin


MODES = {
    "inverse time": lambda reader, line: _time(reader, inverse=True),
    "feed per minute": lambda reader, line: _time(reader),
    "feed per turn": lambda reader, line: _time(reader, per_turn=True),
    "inch": _counted("scale", 25.4),
    "mm": _counted("scale", 1.0),
    "incremental": _counted("incremental", True),
    "absolute": _counted("incremental", False),
    "absolute centre": _counted("absolute_centre", True),
    "incremental centre": _counted("absolute_centre", False),
    "cycle": _cycle(False),
    "cycle out at feed": _cycle(True),
    "cycle off": _counted("cycle", None),
    "return to initial": _counted("leave", "initial"),
    "return to clearance": _counted("leave", "clearance"),
    "end": _counted("ended", True),
    "rapid block": _said("rapid", True),
    "machine coordinates": _said("in_machine", True),
    "cycle call": _said("called", True),
    "turn": _said("turned", True),
    "stay": _said("turned", False),
    "higher position": _said("choice", {"seq": "+"}),
    "lower position": _said("choice", {"seq": "-"}),
    "arc": lambda reader, line: setattr(line, "curve", line.curve or "arc"),
    "clockwise": _said("curve", "clockwise"),
    "counterclockwise": _said("curve", "counterclockwise"),
    "argument": lambda reader, line: None,
}


def _centre(reader: Lines, line: Line, text: str) -> None:
    """The centre of the arcs that follow."""
    reader.centre = reader.target(line)[:3]


def _shift(added: bool = False, anew: bool = False) -> Callable[[Lines, Line, str], None]:
    """A shift of the datum by the axes that the line names."""

    def shift(reader: Lines, line: Line, text: str) -> None:
        shift = np.zeros(3) if anew else reader.at.shift.copy()
        for name, (value, counted) in line.axes.items():
            axis = reader.names.index(name)
            if axis > 2:
                if value:
                    raise reader.error("a shift of X Y Z", f"of {name}")
                continue
            shift[axis] = shift[axis] + value if added or counted == "incremental" else value
        reader.at.change(shift=shift)

    return shift


def _home(reader: Lines, line: Line, text: str) -> None:
    """The axes that the line names, or all, go to where the control has its reference point: nobody knows here."""
    named = [reader.names.index(name) for name in line.axes] or list(range(len(reader.names)))
    if reader.at.on_tip and min(named) < 3:
        named = [0, 1, 2, *(axis for axis in named if axis > 2)]
    reader.at.words[named] = np.nan


def _plane(reader: Lines, line: Line, text: str) -> None:
    """A tilted plane; where its line says so, or the control does it by itself, the rotary axes turn to it."""
    if reader.control.positioning == "siemens":
        kept, direction = plane_blocks.swivel(text)
        reader.at.change(plane=None, shift=reader.at.shift)
        reader.at.change(plane=plane_blocks.from_text(text))
        if direction:
            _turn_to(reader, line, direction=direction)
        if not kept:
            reader.at.words[:3] = np.nan
        return
    reader.at.change(plane=None)
    plane = plane_blocks.from_text(re.sub(r"\s(SEQ|SYM|MB|DIST|ABST|F\s*MAX|FMAX|F\d).*", "", text))
    reader.at.change(plane=plane)
    if line.turned:
        _turn_to(reader, line, **line.choice)


def _turn_to(reader: Lines, line: Line, **choice: Any) -> None:
    """The rotary axes go to the position that this control takes, the slides stand still."""
    joints, control = reader.at.joints(), reader.control
    if reader.at.plane is None:
        raise reader.error("a tilted plane before it", "none")
    if not control.positioning:
        raise reader.error(f"a rule of {control.name} for the rotary axes", "none in its file")
    angles = reader.at.angles_for(reader.at.plane, control.positioning, **choice)
    reader.turn_to(joints, angles)


def _turn(reader: Lines, line: Line, text: str) -> None:
    _turn_to(reader, line)


def _plane_off(reader: Lines, line: Line, text: str) -> None:
    reader.at.change(plane=None)
    if line.turned:
        reader.turn_to(reader.at.joints(), np.zeros(len(reader.names) - 3))


def _retract(reader: Lines, line: Line, text: str) -> None:
    """The tool goes off the part, as far as the control likes."""
    reader.at.words[:3] = np.nan


def _everywhere(reader: Lines, line: Line, text: str) -> None:
    """A cycle behind every move from now on, or none any more."""
    reader.everywhere = curves.heights(text) if "(" in text else None


def _once(reader: Lines, line: Line, text: str) -> None:
    """A cycle where the tool is."""
    reader.holes(reader.at.words, 2, curves.heights(text))


def drill(reader: Lines) -> None:
    """Do the cycle that is defined by its surface, depth, clearance and height to leave, where the tool is."""
    surface = reader.defined.get("cycle surface", np.nan)
    depth = reader.defined.get("cycle depth", np.nan)
    clearance = reader.defined.get("cycle clearance", np.nan)
    if np.isnan([surface, depth, clearance]).any():
        raise reader.error("a cycle with surface, depth and clearance before its call", "none")
    leave = surface + max(clearance, reader.defined.get("cycle retract", 0.0))
    feed, reader.feed = reader.feed, reader.defined.get("cycle feed", reader.feed)
    reader.holes(reader.at.words, 2, curves.Heights(surface + clearance, surface + depth, leave))
    reader.feed = feed


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
        bottom, _ = line.axes.pop(reader.names[axis])
        cycle.bottom = cycle.clearance + bottom if reader.incremental else bottom
    place = reader.target(line)
    leave = max(cycle.initial, cycle.clearance) if reader.leave == "initial" else cycle.clearance
    reader.holes(place, axis, curves.Heights(cycle.clearance, cycle.bottom, leave, cycle.slow))


STATEMENTS = {
    "modal call": _everywhere,
    "cycle here": _once,
    "retract": _retract,
    "centre": _centre,
    "shift": _shift(),
    "new shift": _shift(anew=True),
    "added shift": _shift(added=True),
    "home": _home,
    "tilted plane": _plane,
    "turn to plane": _turn,
    "plane off": _plane_off,
}
NUMBERS = {
    *(f"{word} {letter}" for word in ("centre", "tool axis") for letter in "XYZ"),
    *(f"cycle {word}" for word in ("surface", "depth", "clearance", "retract", "feed")),
    "radius",
    "turns",  # of an arc, the one that is begun included
    "full turns",  # before it
    "sweep",  # degrees
}
MOTIONS = ("linear", "rapid", "arc clockwise", "arc counterclockwise", *PLANES)
# Taken by the reader itself: "skip" moves no axis, "flow" is refused, so is "zero" with another number.
OTHERS = ("skip", "flow", "zero", "tool", "tool number", "length", "speed", "work offset", "TCP on", "TCP off",
          "absolute axis", "incremental axis")  # fmt: skip
MEANINGS = (*MODES, *STATEMENTS, *sorted(NUMBERS), *MOTIONS, *OTHERS)
