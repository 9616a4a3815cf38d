"""What the words of a program may mean: the values in the [read] table of a control's file, and what they do.

A function here takes the reader (`mathpost.shop.controls.reader`), which keeps the modal state, and the line that
the word is on. `MODES` apply at once, in the order of the line. `STATEMENTS` apply to the axes that the line names,
when all of it is read. `NUMBERS` wait for a word that needs them.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from mathpost.frame import Frame
from mathpost.machine import MM_PER_INCH
from mathpost.shop.controls import plane_blocks, plane_forms
from mathpost.shop.controls.arcs_and_holes import heights, holes
from mathpost.shop.controls.blocks import PLANES
from mathpost.shop.controls.calls import LABELS
from mathpost.shop.controls.lines import Drilling, Line
from mathpost.shop.plane.tilted_plane import Plane

if TYPE_CHECKING:
    from mathpost.shop.controls.reader import ProgramReader


def _time(reader: ProgramReader, *, inverse: bool = False, per_turn: bool = False) -> None:
    reader.inverse = inverse
    reader.per_turn = per_turn
    reader.feed = np.nan


def _counted(name: str, value: Any) -> Callable[[ProgramReader, Line], None]:
    return lambda reader, line: setattr(reader, name, value)


def _defined(**said: float) -> Callable[[ProgramReader, Line], None]:
    """A cycle that is called later: of one that was defined before nothing holds."""

    def define(reader: ProgramReader, line: Line) -> None:
        reader.defined, line.defines = dict(said), True

    return define


def _unit(reader: ProgramReader, scale: float) -> None:
    reader.scale = scale
    reader.unit_stated = True


def _said(name: str, value: Any) -> Callable[[ProgramReader, Line], None]:
    return lambda reader, line: setattr(line, name, value)


def _cycle(slow: bool) -> Callable[[ProgramReader, Line], None]:
    """A drilling cycle that is done at every place from now on."""

    def begin(reader: ProgramReader, line: Line) -> None:
        height = reader.at.words[PLANES[reader.plane][2]]
        reader.motion = "linear"
        reader.cycle = Drilling(height, slow)

    return begin


def _move(reader: ProgramReader, line: Line) -> None:
    """The rotary axes turn to a plane, and X Y Z go along."""
    line.turned = line.slides = True


MODES = {
    "inverse time": lambda reader, line: _time(reader, inverse=True),
    "feed per minute": lambda reader, line: _time(reader),
    "feed per turn": lambda reader, line: _time(reader, per_turn=True),
    "inch": lambda reader, line: _unit(reader, MM_PER_INCH),
    "mm": lambda reader, line: _unit(reader, 1.0),
    "incremental": _counted("incremental", True),
    "absolute": _counted("incremental", False),
    "absolute centre": _counted("absolute_centre", True),
    "incremental centre": _counted("absolute_centre", False),
    "cycle": _cycle(False),
    "cycle out at feed": _cycle(True),
    "cycle definition": _defined(),
    "cycle definition out at feed": _defined(**{"cycle feed out": 0.0}),
    "cycle off": _counted("cycle", None),
    "return to initial": _counted("leave", "initial"),
    "return to clearance": _counted("leave", "clearance"),
    "end": _counted("ended", True),
    "rapid block": _said("rapid", True),
    "machine coordinates": _said("in_machine", True),
    "cycle call": _said("called", True),
    "turn": _said("turned", True),
    "move": _move,
    "stay": _said("turned", False),
    "higher position": _said("choice", {"seq": "+"}),
    "lower position": _said("choice", {"seq": "-"}),
    "arc": lambda reader, line: setattr(line, "curve", line.curve or "arc"),
    "clockwise": _said("curve", "clockwise"),
    "counterclockwise": _said("curve", "counterclockwise"),
}


def _shift(added: bool = False, anew: bool = False) -> Callable[[ProgramReader, Line, str], None]:
    """A shift of the datum by the axes that the line names.

    On a tilted plane it goes along the plane's axes. A shift from before the plane is taken back by one of 0 there,
    as posts write it at the end of an operation; what another one does to it no manual says.
    """

    def shift(reader: ProgramReader, line: Line, text: str) -> None:
        line.used("axis ")
        if anew and reader.at.turned is not None:
            reader.at.change(turned=None, inner=np.zeros(3))
        on_plane = reader.at.frame is not None
        before, inner = reader.at.shift.copy(), np.zeros(3) if anew else reader.at.inner.copy()
        shift = inner if on_plane else np.zeros(3) if anew else before
        for name, (value, counted) in line.axes.items():
            axis = reader.names.index(name)
            if axis > 2:
                if value:
                    raise reader.error("a shift of X Y Z", f"of {name}")
                continue
            value *= reader.scale
            if on_plane and not added and counted != "incremental":
                if value and before[axis]:
                    raise reader.error(
                        "a shift on a tilted plane without one before it", f"{before[axis]:g} in {name}"
                    )
                before[axis] = 0.0
            shift[axis] = shift[axis] + value if added or counted == "incremental" else value
        if on_plane and anew and not line.axes:
            before = np.zeros(3)
        reader.at.change(shift=before if on_plane else shift, inner=inner)

    return shift


def _home(first: bool) -> Callable[[ProgramReader, Line, str], None]:
    """The axes that the line names, or all, go to a reference point, by the place that it states.

    Of the `first` one the machine file may say where it is.
    """

    def go(reader: ProgramReader, line: Line, text: str) -> None:
        named = [reader.names.index(name) for name in line.axes] or list(range(len(reader.names)))
        by = reader.target(line)
        if line.axes and not np.array_equal(by, reader.at.words, equal_nan=True):
            reader.put(by[None], replace(line, rapid=True))
        known = dict(reader.at.machine.home) if first else {}
        if all(reader.names[axis] in known for axis in named):
            reader.stand(reader.at.machine_position({axis: known[reader.names[axis]] for axis in named}))
            return
        if reader.at.on_tip and min(named) < 3:
            named = [0, 1, 2, *(axis for axis in named if axis > 2)]
        reader.park(named)
        reader.note("reference point", text.split()[0])

    return go


def _plane(reader: ProgramReader, line: Line, text: str) -> None:
    """A tilted plane; where its line says so, or the control does it by itself, the rotary axes turn to it."""
    if reader.control.positioning == "siemens":
        plane = plane_blocks.from_text(text)
        kept, direction = plane_blocks.swivel(text)
        _no_frames(reader, line, text)  # a new plane deletes what was programmed before
        reader.at.change(plane=_in_mm(reader, plane))
        if direction:
            _turn_to(reader, direction=direction)
        if not kept:
            reader.park([0, 1, 2])
        return
    line.used("axis ", "centre ", "radius", "argument", "feed")
    reader.unfinished.append(text)
    if plane_forms.lacking(reader.unfinished):
        return
    text, held = "\n".join(reader.unfinished), reader.at.plane
    reader.unfinished = []
    _leave(reader)
    plane, form = plane_blocks.read(
        text, before=held if text.startswith("G68.4") else None, tool=reader.at.tool_axis()
    )
    if form in ASSUMED:
        reader.note(form, text.splitlines()[0])
    plane = _in_mm(reader, plane)
    reader.at.change(plane=plane)
    if reader.control.positioning == "heidenhain":  # what the program may turn the axes by itself with, as A+Q120
        angles = reader.at.angles_for(plane, reader.control.positioning, **line.choice)
        reader.plane_angles = dict(zip(reader.names[3:], angles.tolist(), strict=True))
    if line.turned:
        _turn_to(reader, **line.choice)
    if line.slides:
        reader.at.lose([0, 1, 2])


def _rotation(reader: ProgramReader, line: Line, text: str) -> None:
    """A 3D rotation: X Y Z are in another frame, the rotary axes and the tool's length take no part in it."""
    line.used("axis ", "centre ", "radius")
    if reader.at.plane is not None:
        raise reader.error("a 3D rotation without a tilted plane", "one")
    frame = _in_mm(reader, plane_blocks.from_text(text)).frame
    held, inner = reader.at.turned, reader.at.inner
    if held is not None:
        frame = Frame(held.rotation, held.point(inner)) @ Frame(frame.rotation, frame.origin)
    reader.at.change(turned=frame, inner=np.zeros(3))


def _new_rotation(reader: ProgramReader, line: Line, text: str) -> None:
    """A 3D rotation in place of all that was programmed before; without an axis nothing holds any more."""
    _no_frames(reader, Line(), text)
    if line.axes:
        _rotation(reader, line, f"A{text}")


def _in_mm(reader: ProgramReader, plane: Plane) -> Plane:
    return replace(plane, origin=plane.origin * reader.scale)


def _leave(reader: ProgramReader) -> None:
    """No tilted plane any more. A shift on it would go on along axes that differ from control to control."""
    if reader.at.inner.any():
        raise reader.error("the shift on the tilted plane taken back before the plane ends", "it holds")
    reader.at.change(plane=None, turned=None)


def _no_frames(reader: ProgramReader, line: Line, text: str) -> None:
    """Delete a tilted plane, a rotation and all shifts of the datum."""
    if line.axes:
        raise reader.error("no axes behind it", ", ".join(line.axes))
    reader.at.change(plane=None, turned=None, inner=np.zeros(3), shift=np.zeros(3))


def _working_plane(reader: ProgramReader, line: Line, text: str) -> None:
    """Cycle 19 of Heidenhain: the program itself turns the rotary axes, by the angles that the cycle leaves."""
    if not re.search(r"19\.1\s+[ABC]", text):
        _leave(reader)
        return
    reader.note("spatial angles", "cycle 19")
    _plane(reader, line, text)


def _turn_to(reader: ProgramReader, **choice: Any) -> None:
    """The rotary axes go to the position that this control takes, the slides do not move."""
    reader.turn_to(reader.at.joints(), _angles(reader, **choice))


def _angles(reader: ProgramReader, **choice: Any) -> np.ndarray:
    """The rotary angles, degrees, that this control takes for the plane."""
    control = reader.control
    _no_tcp(reader)
    if reader.at.plane is None:
        raise reader.error("a tilted plane before it", "none")
    if not control.positioning:
        raise reader.error(f"a rule of {control.name} for the rotary axes", "none in its file")
    return reader.at.angles_for(reader.at.plane, control.positioning, **choice)


def _no_tcp(reader: ProgramReader) -> None:
    """With TCP the slides would follow, on one control, and on another the block is an alarm."""
    if reader.at.tcp:
        raise reader.error("TCP off where the rotary axes turn to a plane or back", "it is on")


def _turn_about_tip(reader: ProgramReader, line: Line, text: str) -> None:
    """As the turn to a plane, but the slides follow, so that the tip stays where it is."""
    reader.put(np.r_[reader.at.words[:3], _angles(reader)][None], line, np.array([True]))


def _plane_off(reader: ProgramReader, line: Line, text: str) -> None:
    _leave(reader)
    line.used("argument", "feed")
    if line.turned:
        _no_tcp(reader)
        reader.turn_to(reader.at.joints(), np.zeros(len(reader.names) - 3))
    if line.slides:
        reader.at.lose([0, 1, 2])


def _makers_place(reader: ProgramReader, line: Line, text: str) -> None:
    """Axes go to places that count from a position of the machine's maker, which nobody knows here."""
    line.used("axis ", "feed")
    if not np.isnan(line.feed):
        reader.feed = line.feed
    if line.axes:
        reader.park([reader.names.index(name) for name in line.axes])
    reader.note("maker", text.split()[0])


def _everywhere(reader: ProgramReader, line: Line, text: str) -> None:
    """A cycle behind every move from now on, or none any more."""
    reader.everywhere = heights(text) if "(" in text else None


STATEMENTS = {
    "modal call": _everywhere,
    "cycle here": lambda reader, line, text: holes(reader, reader.at.words, 2, heights(text)),
    "retract": lambda reader, line, text: reader.park([0, 1, 2]),  # as far as the control likes
    "maker's place": _makers_place,
    "centre": lambda reader, line, text: setattr(reader, "centre", reader.target(line)[:3]),
    "shift": _shift(),
    "new shift": _shift(anew=True),
    "added shift": _shift(added=True),
    "home": _home(True),
    "other home": _home(False),
    "tilted plane": _plane,
    "working plane": _working_plane,
    "no frames": _no_frames,
    "3D rotation": _rotation,
    "new rotation": _new_rotation,
    "turn to plane": lambda reader, line, text: _turn_to(reader),
    "turn to plane about the tip": _turn_about_tip,
    "plane off": _plane_off,
}
NUMBERS = {
    *(f"{word} {letter}" for word in ("centre", "centre at", "tool axis") for letter in "XYZ"),
    *(
        f"cycle {word}"
        for word in ("surface", "depth", "clearance", "retract", "feed", "feed out", "pitch", "dwell")
    ),
    "radius",
    "turns",  # of an arc, the one that is begun included
    "full turns",  # before it
    "sweep",  # degrees
}
# What is assumed where such a word occurs, in the words of the report.
ASSUMED = {
    "compensation": "the radius that line {line} ({word}) compensates is 0: X Y Z are taken for the tool's centre",
    "on arcs": "the rotary axes turn evenly in a block; by line {line} ({word}) the control takes the tool axis "
    "on the shortest way",
    "spatial angles": "the angles of line {line} ({word}) are those of PLANE SPATIAL, not of the rotary axes",
    "p4": "the signs of the projected angles of line {line} ({word}): both right-handed",
    "g68_3": "Z is the vertical of line {line} ({word}), which a parameter says",
    "configured": "{word} in line {line} switches TCP: that is not the control's, but how machines are configured",
    "tool change": "{word} stand still while a tool is changed, first before line {line}",
    "reference point": "{word} goes to a reference point clear of the part, first in line {line}: "
    "home in [linear] of the machine file does not say where it is",
    "maker": "{word} in line {line} goes to where the machine's maker has set it, taken to be clear of the part",
    "unplaced": "a move is judged from where all axes are known; in line {line} first one moves without "
    "that: {word}",
    "unit": "no word says whether positions are mm or inches: mm, --unit states it",
    "no point": "{word} in line {line} counts mm, inches or degrees, as if it had a point: {control.whole_numbers}",
}
MOTIONS = ("linear", "rapid", "arc clockwise", "arc counterclockwise")
# Taken by the reader itself: "skip" moves no axis, "flow" is refused, so is "zero" with another number.
OTHERS = ("skip", *LABELS, "end of section", "return", "argument", "flow", "zero", "tool", "tool number", "length",
          "speed", "work offset", "dwell seconds", "dwell milliseconds", "dwell turns",
          "TCP on", "TCP off", "TCP on with vectors", "TCP on as configured", "TCP off as configured",
          "plane angle", "absolute axis", "incremental axis", *(f"plane {name}" for name in PLANES))  # fmt: skip
# How a plane is gone to: words that a line without a plane has no use for.
POSITIONING = ("turn", "move", "stay", "higher position", "lower position")
MEANINGS = (*MODES, *STATEMENTS, *sorted(NUMBERS), *MOTIONS, *ASSUMED, *OTHERS)
