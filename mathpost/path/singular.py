"""The singular region (奇异区域): how near the tool is to it, and where a path meets it.

The tool and both rotary axes in one plane: there the rotary joints lose one direction of turning, and close to it
the workpiece-side axis must swing far for a small turn of the tool. `region` has the ways through.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
import sympy as sp
from numpy.typing import ArrayLike

from mathpost import chain
from mathpost.errors import InputError
from mathpost.path.cl import CLData, feed_times
from mathpost.rotation import about, angle_of_chord, unit

if TYPE_CHECKING:
    from mathpost.kinematics import Kinematics
    from mathpost.machine import Machine

CONE = np.radians(1.0)  # about the singular tool axes; nearer, `verify` reports blocks as near the pole, too
LEAN = np.radians(1.0)
CLEARANCE = 20.0  # mm
STILL = 0.01  # of a tolerance of the tool axis: a path that passes a singular axis as near as that meets it


def measure(kin: Kinematics) -> sp.Expr:
    """Return n·(a₁ × a₂) as a sympy expression in the tool-side angle: zero where the machine is singular.

    n is the tool axis, a₁ and a₂ the present directions of the rotary axes. Its size is √(det JᵀJ) for J = ∂n/∂q:
    the area that the tool axis sweeps on the unit sphere for small turns of both joints.

    Examples
    --------
    >>> import mathpost
    >>> measure(mathpost.Kinematics(mathpost.load_machine("dmu50v")))
    sin(B)/2
    """
    data = chain.Geometry.numbers(kin.machine)
    (workpiece_side, _, _), (tool_side, angle, sign) = chain.rotary_in_chain_order(kin.machine)
    # Seen from the body between the two axes: both axes are at rest and the tool turns about the tool-side one.
    tool = about(data.axis[tool_side.name], sign * angle) * data.tool_axis
    return sp.simplify(tool.dot(data.axis[workpiece_side.name].cross(data.axis[tool_side.name])))


def closeness(kin: Kinematics, axis: ArrayLike) -> np.ndarray:
    """Return √(det JᵀJ) = ``|n·(a₁ × a₂)|`` for tool axes (..., 3): 0 when singular, NaN when out of reach."""
    below, above = kin.reach_terms(axis)
    return np.sqrt(below * above)


def amplification(kin: Kinematics, axis: ArrayLike) -> np.ndarray:
    """Return how far the workpiece-side axis turns at most, rad per rad of the tool; tool axes (..., 3)."""
    (_, _, _), (tool_side, _, _) = chain.rotary_in_chain_order(kin.machine)
    along = unit(np.array(tool_side.axis)) @ unit(np.array(kin.machine.tool_axis))
    with np.errstate(divide="ignore"):
        return np.sqrt(1 - along**2) / closeness(kin, axis)


def distance(kin: Kinematics, axis: ArrayLike) -> np.ndarray:
    """Return the angle (radians) between tool axes (..., 3) and the nearest singular one, an end of reach.

    With one rotary axis none is singular: infinite.
    """
    if kin.tool_side is None:
        return np.full(np.shape(axis)[:-1], np.inf)
    return from_pole(kin, axis, kin.reach)


def from_pole(kin: Kinematics, axis: ArrayLike, ends: tuple[float, float] = (0, np.pi)) -> np.ndarray:
    """Return the angle (radians) between tool axes (..., 3) and the workpiece-side axis, or the nearer end."""
    pole, axis = np.array(kin.inverse_symbolic.pole, dtype=float), np.asarray(axis, dtype=float)
    angle = 2 * np.arctan2(np.linalg.norm(axis - pole, axis=-1), np.linalg.norm(axis + pole, axis=-1))
    return np.minimum(angle - ends[0], ends[1] - angle)


def regions(kin: Kinematics, cl: CLData, joints: np.ndarray, *, cone: float | None = None) -> list[tuple[int, int]]:
    """Return first and last record (from 0) of each singular region of a path, list of (int, int).

    A move is singular if the tool axis comes nearer than `cone` (radians) to a singular one. Without `cone`, if a
    rotary axis would have to turn faster than it can at the stated feed between the chosen `joints`, shape (n, 5),
    mm and radians; `InputError` then if the CL data state no feed or the machine no rate.
    """
    singular = _too_fast(kin.machine, cl, np.asarray(joints)) if cone is None else near(kin, cl, cone)
    edges = np.flatnonzero(np.diff(np.r_[False, singular, False]))
    return [(int(first), int(last)) for first, last in zip(edges[::2], edges[1::2], strict=True)]


def near(kin: Kinematics, cl: CLData, cone: float) -> np.ndarray:
    """Return whether the tool axis comes nearer than `cone` (radians) to a singular one, for each move."""
    # On its way it comes nearer than at the ends by no more than half of its turn: most moves need no closer look.
    ends, turn = distance(kin, cl.axes), np.linalg.norm(np.diff(cl.axes, axis=0), axis=1)
    inside = np.minimum(ends[:-1], ends[1:]) - np.pi / 4 * turn < cone
    moves = np.flatnonzero(inside)
    inside[moves] = nearest(kin, cl.axes[moves], cl.axes[moves + 1])[1] < cone
    return inside


def nearest(
    kin: Kinematics, start: np.ndarray, end: np.ndarray, measured: Callable[..., np.ndarray] = distance
) -> tuple[np.ndarray, np.ndarray]:
    """Where the great circle between tool axes (n, 3) comes nearest to a singular one, t from 0 to 1, and radians.

    With `from_pole` as `measured`: to the workpiece-side axis.
    """
    along = end - start  # of neighbours only the difference keeps its digits
    across = along - np.vecdot(along, start)[:, None] * start
    across /= np.maximum(np.linalg.norm(across, axis=1), 1e-300)[:, None]
    arc = angle_of_chord(np.linalg.norm(along, axis=1))
    pole = np.array(kin.inverse_symbolic.pole, dtype=float)
    # The ends of reach lie round the workpiece-side axis: what is near an end of it is near one of them.
    turn = [np.arctan2(across @ end, start @ end) for end in (pole, -pole)]
    turn = np.clip([*turn, np.zeros(len(arc)), arc], 0, arc)
    found = measured(kin, np.cos(turn)[..., None] * start + np.sin(turn)[..., None] * across)
    pick = found.argmin(axis=0), np.arange(len(start))
    return turn[pick] / np.maximum(arc, 1e-300), found[pick]


def _too_fast(machine: Machine, cl: CLData, joints: np.ndarray) -> np.ndarray:
    """Whether a rotary axis would have to turn faster than it can at the stated feed, for each move."""
    rates = machine.max_rates[3:]
    if np.isnan(rates).all() or np.isnan(cl.feeds[~cl.rapid]).all():
        raise InputError("cone", "an angle, or a feed in the CL data and the rates of the machine", "neither")
    seconds = np.nan_to_num(feed_times(cl.points, cl.feeds[1:]), nan=np.inf, posinf=np.inf)
    needed = np.abs(np.diff(joints[:, 3:], axis=0))
    over = (needed > np.where(np.isnan(rates), np.inf, rates) * seconds[:, None] + 1e-12).any(axis=1)
    return over & ~cl.rapid[1:]


def refuse_nonsense(lean: float, clearance: float) -> None:
    """Raise `InputError` for a lean or a clearance that leads nowhere."""
    if not 0 < lean < np.pi / 2:
        raise InputError("lean", "radians above 0 and below π/2", repr(lean))
    if not 0 < clearance < np.inf:
        raise InputError("clearance", "mm above 0", repr(clearance))
