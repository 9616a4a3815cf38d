"""A machine as one standalone page: it moves, and says in words what each axis does.

A wrong sign of an axis is the first error that every shop makes. The words are computed from the chain; somebody in
front of the machine compares them with its motion.
"""

from __future__ import annotations

import html
from typing import TYPE_CHECKING

import numpy as np

from mathpost.path.singular import from_pole
from mathpost.rotation import unit
from mathpost.teaching.course import view_machine
from mathpost.teaching.draw.arrangement import placing

if TYPE_CHECKING:
    from mathpost.kinematics import Kinematics
    from mathpost.machine import Rotary

DIRECTIONS = (("to the left", "to the right"), ("to the front", "to the back"), ("down", "up"))
LEAST = 0.2  # the smallest component of a direction that is mentioned
ARRANGEMENTS = {
    "table-table": "Both rotary axes carry the workpiece.",
    "head-table": "One rotary axis carries the workpiece, the other the tool.",
    "head-head": "Both rotary axes carry the tool.",
    "table": "The one rotary axis carries the workpiece.",
    "head": "The one rotary axis carries the tool.",
}
FRAME = """<style>body { max-width: 1060px; margin: 0 auto; padding: 0 12px; font: 15px/1.45 system-ui, sans-serif }
#live { height: 500px; height: max(500px, min(660px, 1100px - 100vw)) }
table { border-collapse: collapse } td, th { text-align: left; padding: 3px 14px 3px 0 }
p, table { font-size: 14px }</style>"""


def words(kin: Kinematics) -> dict[str, str]:
    """Return the effect of each joint's positive direction, a dict of sentences such as "X+ moves the tool up.".

    Seen from in front of the machine, at rotary zero: the front is towards −Y, the right side towards +X.
    """
    places, said = placing(kin.machine), {}
    count = len(kin.symbols)
    at_zero = places(np.zeros(count))
    for slide, step in zip(kin.machine.linear, np.eye(count), strict=False):
        way = _ways(places(step)[slide.carries][:3, 3] - at_zero[slide.carries][:3, 3])
        said[slide.name] = f"{slide.name}+ moves the {'tool' if slide.carries == 'tool' else 'table'} {way}."
    for rotary in kin.machine.rotary:
        turn = unit(np.array(rotary.axis))
        does = _seen(rotary, turn, unit(np.array(kin.machine.tool_axis)))
        said[rotary.name] = f"{rotary.name}+ turns the {does}; {_iso(rotary, turn)}."
    return said


def reach(kin: Kinematics) -> list[str]:
    """Return sentences that say which tool axes the machine reaches."""
    derived, (near, far) = kin.inverse_symbolic, np.degrees(kin.reach)
    direction = " ".join(f"{float(x):z.3f}" for x in derived.pole)
    if kin.tool_side is None:
        return [
            f"The tool axis is always at {near:.1f}° to the axis of {derived.workpiece_side}, ({direction}) in "
            "the workpiece. Any other tool axis is out of reach."
        ]
    joint = kin.symbols.index(derived.tool_side)
    joints = np.zeros((721, 5))
    low, high = np.clip(kin.machine.limits[joint], -np.pi, np.pi)
    joints[:, joint] = np.linspace(low, high, 721)
    angles = np.degrees(from_pole(kin, kin.forward(joints)[1], (0, np.inf)))
    name, tool_side = str(derived.workpiece_side), derived.tool_side
    carried = next(axis.carries for axis in kin.machine.rotary if axis.name == name)
    turns = "the workpiece about the tool" if carried == "workpiece" else "the tool about its own axis"
    said = [
        f"The pole is ({direction}) in the workpiece. Close to it {name} turns far for a small lean of the tool.",
        f"The tool axis can be {near:.1f}° to {far:.1f}° from the pole; within the travel of {tool_side}, "
        f"{angles.min():.1f}° to {angles.max():.1f}°.",
    ]
    if near < 0.05:
        said.insert(1, f"At the pole {name} turns {turns}, and any {name} is right.")
    return said


def axes(kin: Kinematics) -> list[tuple[str, str, str]]:
    """Return for each joint its name, the effect of its positive direction in words, and its travel."""
    units = ["mm"] * 3 + ["°"] * len(kin.machine.rotary)
    limits = zip(kin.machine.limits * kin.machine.units[:, None], units, strict=True)
    return [
        (name, said, f"{low:g} to {high:g} {unit}" if np.isfinite([low, high]).all() else "endless")
        for (name, said), ((low, high), unit) in zip(words(kin).items(), limits, strict=True)
    ]


def around(kin: Kinematics) -> tuple[str, str]:
    """Return the contents of the page above and below the machine, both HTML."""
    machine = kin.machine
    rows = [f"<tr><th>{name}<td>{html.escape(said)}<td>{travel}" for name, said, travel in axes(kin)]
    name, source = html.escape(machine.name), html.escape(machine.source)
    before = f"<h1>{name}</h1><p>{ARRANGEMENTS[machine.arrangement]} Source: {source}.</p>"
    after = (
        "<h2>What each axis does</h2><p>Seen from the front, at rotary zero. Compare it with the machine, axis by "
        f"axis.</p><table><tr><th>axis<th>positive direction<th>travel{''.join(rows)}</table>"
        f"<h2>What it reaches</h2>{''.join(f'<p>{line}</p>' for line in reach(kin))}"
    )
    return before, after


def page(kin: Kinematics) -> str:
    """Return the page as HTML."""
    before, after = around(kin)
    return view_machine.machine(kin).page(kin.machine.name, before=FRAME + before, after=after, still=True)


def _ways(direction: np.ndarray) -> str:
    """A direction in words, the largest component first."""
    direction = unit(direction)
    order = [axis for axis in np.argsort(-np.abs(direction)) if abs(direction[axis]) > LEAST]
    return " and ".join(DIRECTIONS[axis][int(direction[axis] > 0)] for axis in order)


def _seen(rotary: Rotary, turn: np.ndarray, tool_axis: np.ndarray) -> str:
    """Describe the motion of a table or a head that turns right-handed about `turn`."""
    if rotary.carries == "workpiece":
        sides = zip(("front", "right side"), turn, strict=False)
        seen = [f"its {side} {'sinks' if along > 0 else 'rises'}" for side, along in sides if abs(along) > LEAST]
    else:
        swing = np.cross(turn, -tool_axis)
        seen = [f"the tip swings {_ways(swing)}"] if np.linalg.norm(swing) > LEAST else []
    if abs(turn[2]) > LEAST:
        seen.append(f"it goes {'counterclockwise' if turn[2] > 0 else 'clockwise'} seen from above")
    return f"{'table' if rotary.carries == 'workpiece' else 'head'} so that {' and '.join(seen)}"


def _iso(rotary: Rotary, turn: np.ndarray) -> str:
    """Say whether the sign is ISO 841's: A, B, C turn the tool right-handed about +X, +Y, +Z of the workpiece."""
    if rotary.name[0] not in "ABC":
        return "ISO 841 gives it no sign"
    along = turn["ABC".index(rotary.name[0])] * (-1 if rotary.carries == "workpiece" else 1)
    if abs(along) < 1e-6:
        return "square to its ISO 841 direction"
    return "as ISO 841 has it" if along > 0 else "against ISO 841"
