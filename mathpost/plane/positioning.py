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
    names, present = _names(alignment), _present(present)
    first = _joint(alignment, master or names[0])
    motions = {
        f"smallest motion of {names[n]}": lambda angles, n=n: abs(angles - present)[n] for n in (first, 1 - first)
    }
    zeros = {f"{names[n]} nearest to 0": lambda angles, n=n: abs(wrap(angles))[n] for n in (first, 1 - first)}
    return _choose(alignment, present, motions | zeros)


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
    """
    if (seq and sym) or seq not in ("", "+", "-") or sym not in ("", "+", "-"):
        raise InputError("seq, sym", "'+' or '-' for one of the two, or nothing", f"seq={seq!r}, sym={sym!r}")
    if rot not in ("COORD", "TABLE"):
        raise InputError("rot", "'COORD' or 'TABLE'", repr(rot))
    present, master, side = _present(present), alignment.inner, seq or sym
    name, word = _names(alignment)[master], f"{'SYM' if sym else 'SEQ'}{side}"

    def refuse(angles):
        above = wrap(angles[master] - (symmetry if sym else 0.0)) * (-1 if side == "-" else 1)
        return f"{name} at {angles[master]:.4f} is not {word}" if side and above < -TIE else ""

    clauses = {
        "shortest path": lambda angles: np.hypot(*(angles - present)),
        f"higher {name}": lambda angles: -angles[master],
    }
    return _choose(alignment, present, clauses, refuse, turn_table=rot == "TABLE", alone=word if side else ALONE)


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
    axis, present = alignment.inner if reference is None else _joint(alignment, reference), _present(present)
    clause = f"{'higher' if direction > 0 else 'lower'} {_names(alignment)[axis]}"
    return _choose(alignment, present, {clause: lambda angles: -direction * wrap(angles[axis])})


def _choose(alignment, present, clauses, refuse=lambda angles: "", *, turn_table=False, alone=ALONE):
    """The position with the least of the first clause, a dict from its words to what it measures, that differs.

    Positions are moved by whole turns towards `present`; `alone` says why, if nothing else is left to choose from.
    """
    left, reasons = {}, []
    for index, solution in enumerate(alignment.solutions):
        angles = solution.angles.copy()
        if alignment.free:  # it stays where it stands, or turns until ρ is 0: one degree shows which way ρ goes
            angles[alignment.outer] = 1.0
            slope = np.sign(wrap(alignment.at(angles).rho - solution.rho))
            angles[alignment.outer] = -slope * solution.rho if turn_table else present[alignment.outer]
        if reason := refuse(angles) or beyond_travel(alignment.machine, angles):
            reasons.append(reason)
        else:
            left[index] = np.array(
                [nearest_turn(*p) for p in zip(alignment.machine.rotary, angles, present, strict=True)]
            )
    if not left:
        raise ReachError(f"{alignment.machine.name}: entered angle not permitted ({'; '.join(reasons)})")
    why = alone
    for clause, measure in clauses.items():
        if len(left) > 1:
            least = min(map(measure, left.values())) + TIE
            nearest = {index: angles for index, angles in left.items() if measure(angles) <= least}
            why, left = clause if len(nearest) < len(left) else "both are one position", nearest
    index = min(left)
    endless = [np.isinf(rotary.limits).all() for rotary in alignment.machine.rotary]
    angles = np.where(endless, wrap(left[index]), left[index])
    return Choice(index, angles, alignment.at(angles).rho, why)


def _names(alignment):
    return [rotary.name for rotary in alignment.machine.rotary]


def _joint(alignment, name):
    if name not in _names(alignment):
        raise InputError("rotary axis", f"one of {', '.join(_names(alignment))}", repr(name))
    return _names(alignment).index(name)


def _present(present):
    array = as_array(present, 2, "present")
    if array.ndim != 1:
        raise InputError("present", "two rotary angles", f"shape {array.shape}")
    return array
