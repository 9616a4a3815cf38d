"""Arcs and drilling cycles of a program as points, in the coordinates that its words are in."""

import re
from dataclasses import dataclass

import numpy as np

from mathpost.errors import InputError
from mathpost.files import NUMBER
from mathpost.path import arcs

CHORD = 0.0001  # mm, between an arc and the points that are made of it
SAME_ANGLE = 1e-3  # degrees, by which the printed digits of a plane may turn the rotary axes
OUT_AT_FEED = {"CYCLE81": False, "CYCLE82": False, "CYCLE83": False, "CYCLE84": True, "CYCLE85": True,
               "CYCLE86": False, "CYCLE87": False, "CYCLE88": False, "CYCLE89": True, "CYCLE840": True}  # fmt: skip
PLANES = {
    "plane XY": (0, 1, 2),
    "plane ZX": (2, 0, 1),
    "plane YZ": (1, 2, 0),
}  # two axes, and the one square to them


def centre_of(start: np.ndarray, end: np.ndarray, radius: float, plane: str, clockwise: bool) -> np.ndarray:
    """Return the centre of an arc by its radius: positive for less than half a turn, negative for more.

    Examples
    --------
    >>> centre_of(np.array([10.0, 0, 0]), np.array([0.0, 10, 0]), 10, "plane XY", clockwise=False).round(6) + 0.0
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
    >>> end, turns = swept(np.array([10.0, 0, 0]), np.array([10.0, 0, -2]), np.zeros(3), "plane XY", -450)
    >>> end.round(6) + 0.0, turns
    (array([  0., -10.,  -2.]), 1)
    """
    first, second, _ = PLANES[plane]
    angle, (u, v) = np.deg2rad(degrees), (start - centre)[[first, second]]
    found = np.array(end)
    found[first] = centre[first] + u * np.cos(angle) - v * np.sin(angle)
    found[second] = centre[second] + u * np.sin(angle) + v * np.cos(angle)
    return found, max(int(np.ceil(abs(degrees) / 360 - 1e-9)) - 1, 0)


@dataclass(frozen=True)
class Heights:
    """How a drilling cycle goes: to the clearance, to the bottom and out, mm."""

    clearance: float
    bottom: float
    leave: float
    slow: bool = False  # whether the tool comes out at its feed
    dwell: float = 0.0  # seconds that it waits at the bottom; below 0 turns of the spindle


WAITS = dict.fromkeys(("CYCLE82", "CYCLE84", "CYCLE840", "CYCLE85", "CYCLE86", "CYCLE88", "CYCLE89"), 5) | {
    "CYCLE83": 8
}


def hole(at: np.ndarray, axis: int, heights: Heights) -> tuple[np.ndarray, list[bool]]:
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


def arguments(text: str) -> tuple[str, list[float]]:
    """Return the name of a cycle and its numbers, 0 for what is left out.

    Examples
    --------
    >>> arguments("MCALL CYCLE81(10,0,,-8.5)")
    ('CYCLE81', [10.0, 0.0, 0.0, -8.5])
    """
    name, _, rest = text.removeprefix("MCALL").strip().partition("(")
    values = [each.strip() for each in rest.rpartition(")")[0].split(",")]
    if not all(re.fullmatch(rf"(?:{NUMBER})?", value) for value in values):
        raise InputError(name, "numbers", rest)
    return name.strip(), [float(value or 0) for value in values]


def heights(text: str) -> Heights:
    """Return the heights of a cycle of Siemens.

    CYCLE81 and the like begin with the planes to which the tool comes out and of the surface, the distance in front
    of it, the depth and, if that is left out, how far below the surface it is. How long it waits is further back.
    """
    name, values = arguments(text)
    if name not in OUT_AT_FEED or len(values) < 4:
        raise InputError(name, "CYCLE81 to CYCLE89 or CYCLE840, with four numbers", f"{len(values)}")
    leave, surface, distance, bottom, below = [*values, 0.0][:5]
    if below and text.split("(")[1].split(",")[3].strip() == "":
        bottom = surface - abs(below)
    dwell = dict(enumerate(values)).get(WAITS.get(name, -1), 0.0)
    return Heights(surface + abs(distance), bottom, leave, OUT_AT_FEED[name], dwell)
