"""Which of the two positions of a tilted plane a control takes, by its documented rule.

Positions are rotary angles in degrees, in the order of the machine file. Of an angle and its whole turns a control
is taken to go to the one nearest to where the axis stands, within travel; an endless axis then shows it in
(−180, 180], which is the same place.
"""

from dataclasses import dataclass

import numpy as np

from mathpost.errors import InputError, ReachError, as_array
from mathpost.plane.alignment import beyond_travel, nearest_turn
from mathpost.rotation import wrap

TIE = 1e-6  # degrees
ALONE = "the only one within travel"


@dataclass(frozen=True, eq=False)
class Choice:
    """What a control does with a tilted plane.

    Attributes
    ----------
    solution : int
        0 or 1, the index into `Alignment.solutions`.
    angles : ndarray, shape (2,)
        Where the rotary axes go, degrees.
    rho : float
        The angle then left from the spindle's X to the feature's X, degrees.
    why : str
        The clause of the rule that decided.
    """

    solution: int
    angles: np.ndarray
    rho: float
    why: str


def fanuc(alignment, present, *, master=None):
    """Choose as Fanuc's G53.1 does (Series 16i/18i-MB).

    The smallest motion of the master axis; if equal, of the slave axis; if equal, the master nearest to 0; if
    equal, the slave nearest to 0. The master is the axis nearest to the machine's bed, on a machine with one
    table and one head the table's.

    Parameters
    ----------
    alignment : mathpost.plane.alignment.Alignment
    present : array_like, shape (2,)
        Where the rotary axes stand, degrees.
    master : str, keyword only
        Name of the master axis if a parameter of the control says otherwise.

    Returns
    -------
    Choice

    Raises
    ------
    ReachError
        If neither position is within travel; names both limits.

    Examples
    --------
    >>> from mathpost import machine
    >>> from mathpost.plane.alignment import align
    >>> from mathpost.plane.tilted_plane import Plane
    >>> trunnion = machine.load("data/machines/ac_table.toml")
    >>> tilted = align(Plane("PLANE SPATIAL", [0, 45, 0]).frame, trunnion)
    >>> fanuc(tilted, [20, -60]).angles.round(6), fanuc(tilted, [20, -60], master="C").angles.round(6)
    (array([45., 90.]), array([-45., -90.]))
    """
    first = _joint(alignment, master or alignment.machine.rotary[0].name)
    names = [joint.name for joint in alignment.machine.rotary]
    candidates = _within_travel(alignment, _present(present))
    order = (first, 1 - first)

    def keys(angles):
        motion, distance = np.abs(angles - _present(present)), np.abs(wrap(angles))
        return [motion[order[0]], motion[order[1]], distance[order[0]], distance[order[1]]]

    clauses = [f"smallest motion of {names[n]}" for n in order] + [f"{names[n]} nearest to 0" for n in order]
    return _smallest(alignment, candidates, keys, clauses)


def heidenhain(alignment, present, *, seq="", sym="", symmetry=0.0, rot="COORD"):
    """Choose as Heidenhain's PLANE does: SEQ or SYM by the master axis, otherwise by travel and shortest path.

    The master is the first rotary axis from the tool, the last from the table. The manual does not say how a
    path is measured nor what breaks a tie: here it is √(Δ₁² + Δ₂²), and of two equal paths the one with the
    higher master angle, which is the manual's example.

    Parameters
    ----------
    alignment, present
        As in `fanuc`.
    seq, sym : str, keyword only
        ``"+"`` or ``"-"``: the master above or below 0, or above or below the symmetry point. One at most.
    symmetry : float, keyword only
        The symmetry point of the master axis, degrees.
    rot : str, keyword only
        ``"COORD"`` leaves a free table axis where it stands and turns the coordinates; ``"TABLE"`` turns the
        axis until the feature's X is the spindle's. Without a free axis it has no effect.

    Returns
    -------
    Choice

    Raises
    ------
    ReachError
        If the position asked for is not within travel ("Entered angle not permitted" on the control).

    Examples
    --------
    >>> from mathpost import machine
    >>> from mathpost.plane.alignment import align
    >>> from mathpost.plane.tilted_plane import Plane
    >>> trunnion = machine.load("data/machines/ac_table.toml")
    >>> tilted = align(Plane("PLANE SPATIAL", [0, 45, 0]).frame, trunnion)
    >>> heidenhain(tilted, [0, -105]).angles.round(6), heidenhain(tilted, [0, -105], seq="+").angles.round(6)
    (array([-45., -90.]), array([45., 90.]))
    """
    if seq and sym:
        raise InputError("seq, sym", "one of the two", f"seq={seq!r}, sym={sym!r}")
    if rot not in ("COORD", "TABLE"):
        raise InputError("rot", "'COORD' or 'TABLE'", repr(rot))
    master, side = alignment.inner, seq or sym
    reference = symmetry if sym else 0.0
    if side not in ("", "+", "-"):
        raise InputError("seq, sym", "'+', '-' or nothing", repr(side))

    name, word = alignment.machine.rotary[master].name, f"{'SYM' if sym else 'SEQ'}{side}"

    def refuse(angles):
        above = wrap(angles[master] - reference) * (-1 if side == "-" else 1)
        return f"{name} at {angles[master]:.4f} is not {word}" if side and above < -TIE else ""

    def keys(angles):
        return [np.hypot(*(angles - _present(present))), -angles[master]]

    candidates = _within_travel(alignment, _present(present), refuse, turn_table=rot == "TABLE")
    clauses = ["shortest path", f"higher {name}"]
    return _smallest(alignment, candidates, keys, clauses, alone=word if side else ALONE)


def siemens(alignment, present, direction, *, reference=None):
    """Choose as CYCLE800's _DIR does: the lower (−1) or the higher (+1) value of the reference rotary axis.

    If that one is out of travel the other is taken, as the manual says.

    Parameters
    ----------
    alignment, present
        As in `fanuc`.
    direction : int
        −1 or +1.
    reference : str, keyword only
        Name of the reference axis, set when the machine is commissioned; by default the axis next to the tool.

    Returns
    -------
    Choice

    Raises
    ------
    ReachError
        If neither position is within travel.
    """
    if direction not in (-1, 1):
        raise InputError("direction", "-1 or +1", repr(direction))
    axis = alignment.inner if reference is None else _joint(alignment, reference)
    candidates = _within_travel(alignment, _present(present))
    name = alignment.machine.rotary[axis].name
    clauses = [f"{'higher' if direction > 0 else 'lower'} {name}", "smallest motion"]
    return _smallest(
        alignment,
        candidates,
        lambda angles: [-direction * wrap(angles[axis]), np.hypot(*(angles - _present(present)))],
        clauses,
    )


def _within_travel(alignment, present, refuse=lambda angles: "", turn_table=False):
    """The solutions that nothing refuses, within travel, by index; each moved by whole turns towards `present`."""
    candidates, reasons = {}, []
    for index, solution in enumerate(alignment.solutions):
        angles = solution.angles.copy()
        if alignment.free:
            angles[alignment.outer] = _free_angle(alignment, solution, present, turn_table)
        reason = refuse(angles) or beyond_travel(alignment.machine, angles)
        if reason:
            reasons.append(reason)
        else:
            pairs = zip(alignment.machine.rotary, angles, present, strict=True)
            candidates[index] = np.array([nearest_turn(*pair) for pair in pairs])
    if not candidates:
        raise ReachError(f"{alignment.machine.name}: entered angle not permitted ({'; '.join(reasons)})")
    return candidates


def _free_angle(alignment, solution, present, turn_table):
    """A free outer axis stays where it stands, or turns until ρ is 0."""
    if not turn_table:
        return present[alignment.outer]
    angles = solution.angles.copy()
    angles[alignment.outer] = 1.0  # one degree shows which way ρ goes
    slope = wrap(alignment.at(angles).rho - solution.rho)
    return -np.sign(slope) * solution.rho


def _smallest(alignment, candidates, keys, clauses, alone=ALONE):
    """The candidate with the smallest keys, the first that differs deciding; `alone` says why there was but one."""
    left, why = dict(candidates), alone
    table = {index: keys(angles) for index, angles in candidates.items()}
    for column, clause in enumerate(clauses):
        if len(left) == 1:
            break
        least = min(table[index][column] for index in left)
        nearest = {index: left[index] for index in left if table[index][column] <= least + TIE}
        why = clause if len(nearest) < len(left) else "both are one position"
        left = nearest
    index = min(left)
    endless = [np.isinf(rotary.limits).all() for rotary in alignment.machine.rotary]
    angles = np.where(endless, wrap(left[index]), left[index])
    return Choice(index, angles, alignment.at(angles).rho, why)


def _joint(alignment, name):
    names = [joint.name for joint in alignment.machine.rotary]
    if name not in names:
        raise InputError("rotary axis", f"one of {', '.join(names)}", repr(name))
    return names.index(name)


def _present(present):
    array = as_array(present, 2, "present")
    if array.ndim != 1:
        raise InputError("present", "two rotary angles", f"shape {array.shape}")
    return array
