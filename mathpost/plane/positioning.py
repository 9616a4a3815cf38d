"""Which of the two positions of a tilted plane a control takes, by its documented rule.

Each rule takes an `Alignment` and where the rotary axes stand, shape (2,), and returns a `Choice`; it raises
`ReachError` where no position is within travel, with the limits. Positions are rotary angles in degrees, in the
order of the machine file. Of an angle and its whole turns a control is taken to go to the one nearest to where the
axis stands, within travel; an endless axis then shows it in (−180, 180], which is the same place.
"""

from dataclasses import dataclass

import numpy as np

from mathpost.errors import InputError, ReachError, as_array
from mathpost.plane.alignment import beyond_travel
from mathpost.rotation import wrap

TIE = 1e-6  # degrees
ALONE = "the only one within travel"


@dataclass(frozen=True, eq=False)
class Choice:
    """What a control does with a tilted plane."""

    solution: int  # index into `Alignment.solutions`
    angles: np.ndarray  # where the two rotary axes go, degrees
    rho: float  # the angle then left from the spindle's X to the feature's X, degrees
    why: str  # the clause of the rule that decided


def fanuc(alignment, present, *, master=None):
    """Choose as Fanuc's G53.1 does (Series 16i/18i-MB).

    The smallest motion of the master axis; if equal, of the slave; if equal, the master nearest to 0; if equal, the
    slave nearest to 0. The master is the axis nearest to the bed, on a machine with one table and one head the
    table's; `master` names it if a parameter of the control says otherwise.

    Examples
    --------
    >>> from mathpost import machine
    >>> from mathpost.plane.alignment import align
    >>> from mathpost.plane.tilted_plane import Plane
    >>> tilted = align(Plane("PLANE SPATIAL", [0, 45, 0]).frame, machine.load("ac_table"))
    >>> fanuc(tilted, [20, -60]).angles.round(6), fanuc(tilted, [20, -60], master="C").angles.round(6)
    (array([45., 90.]), array([-45., -90.]))
    """
    first = _joint(alignment, master) if master else 0
    names = {n: alignment.machine.joint_names[3 + n] for n in (first, 1 - first)}
    clauses = {f"smallest motion of {name}": lambda _, motion, n=n: abs(motion[n]) for n, name in names.items()}
    clauses |= {f"{name} nearest to 0": lambda angles, _, n=n: abs(wrap(angles[n])) for n, name in names.items()}
    return _choose(alignment, present, clauses)


def heidenhain(alignment, present, *, seq="", sym="", symmetry=0.0, rot="COORD"):
    """Choose as Heidenhain's PLANE does: SEQ or SYM by the master axis, otherwise by travel and shortest path.

    The master is the first rotary axis from the tool. The manual does not say how a path is measured nor what
    breaks a tie: here √(Δ₁² + Δ₂²), and of two equal paths the one with the higher master angle, which is the
    manual's example.

    One of `seq` and `sym` may be ``"+"`` or ``"-"``: the master above or below 0, or above or below its `symmetry`
    point, degrees; where that is not within travel the control says "Entered angle not permitted". `rot` is
    ``"COORD"``, which leaves a free table axis where it stands and turns the coordinates, or ``"TABLE"``, which
    turns the axis until the feature's X is the spindle's.
    """
    if (seq and sym) or seq not in ("", "+", "-") or sym not in ("", "+", "-"):
        raise InputError("seq, sym", "'+' or '-' for one of the two, or nothing", f"seq={seq!r}, sym={sym!r}")
    if rot not in ("COORD", "TABLE"):
        raise InputError("rot", "'COORD' or 'TABLE'", repr(rot))
    master, side = alignment.inner, seq or sym
    name, word = alignment.machine.joint_names[3 + master], f"{'SYM' if sym else 'SEQ'}{side}"

    def refuse(angles):
        above = wrap(angles[master] - (symmetry if sym else 0.0)) * (-1 if side == "-" else 1)
        return f"{name} at {angles[master]:.4f} is not {word}" if side and above < -TIE else ""

    clauses = {
        "shortest path": lambda _, motion: np.hypot(*motion),
        f"higher {name}": lambda angles, _: -angles[master],
    }
    return _choose(alignment, present, clauses, refuse, turn_table=rot == "TABLE", alone=word if side else ALONE)


def siemens(alignment, present, direction, *, reference=None):
    """Choose as CYCLE800's _DIR does: the lower (−1) or the higher (+1) value of the reference rotary axis.

    If that is out of travel the other is taken, as the manual says. `reference` names the axis, which is set when
    the machine is commissioned; by default it is the one next to the tool.
    """
    if direction not in (-1, 1):
        raise InputError("direction", "-1 or +1", repr(direction))
    axis = alignment.inner if reference is None else _joint(alignment, reference)
    clause = f"{'higher' if direction > 0 else 'lower'} {alignment.machine.joint_names[3 + axis]}"
    return _choose(alignment, present, {clause: lambda angles, _: -direction * wrap(angles[axis])})


def _choose(alignment, present, clauses, refuse=lambda angles: "", *, turn_table=False, alone=ALONE):
    """The position with the least of the first clause that differs, moved by whole turns towards `present`.

    `clauses` are words and what they measure, of the angles and how far they are from `present`; `alone` says why,
    if nothing else is left to choose from.
    """
    present = as_array(present, 2, "present")
    if present.ndim != 1:
        raise InputError("present", "two rotary angles", f"shape {present.shape}")
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
            turned = zip(alignment.machine.rotary, angles, present, strict=True)
            left[index] = np.array([rotary.nearest_turn(angle, now) for rotary, angle, now in turned])
    if not left:
        raise ReachError(f"{alignment.machine.name}: entered angle not permitted ({'; '.join(reasons)})")
    why = alone
    for clause, measure in clauses.items():
        if len(left) > 1:
            measured = {index: measure(angles, angles - present) for index, angles in left.items()}
            nearest = {n: angles for n, angles in left.items() if measured[n] <= min(measured.values()) + TIE}
            why, left = clause if len(nearest) < len(left) else "both are one position", nearest
    index = min(left)
    endless = [np.isinf(rotary.limits).all() for rotary in alignment.machine.rotary]
    angles = np.where(endless, wrap(left[index]), left[index])
    return Choice(index, angles, alignment.at(angles).rho, why)


def _joint(alignment, name):
    names = alignment.machine.joint_names[3:]
    if name not in names:
        raise InputError("rotary axis", f"one of {', '.join(names)}", repr(name))
    return names.index(name)
