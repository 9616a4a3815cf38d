"""The method of source 002 (Yu Dan et al.), step by step; each step returns the numbers it decides by.

Section 1.2 chooses the rotary angles: `cases`, `turns`, and `choose` by both. Section 1.3 smooths them through a
singular region: `end_slopes`, `hermite` or `clamped`, `smooth`, and `lifted` for the retract.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING

import numpy as np
import sympy as sp
from numpy.typing import ArrayLike

from mathpost.errors import InputError, MathpostError, ReachError
from mathpost.formula import numeric
from mathpost.machine import TRAVEL_TOLERANCE
from mathpost.path.deviation import deviation, from_segment

if TYPE_CHECKING:
    from mathpost.kinematics import Kinematics
    from mathpost.path.cl import CLData


@dataclass(frozen=True)
class Case:
    """The case of section 1.2 that applies to the tilting angle of one record."""

    number: int  # 1: |θ| is outside travel, or NaN. 2: one sign is inside, equation (5). 3: both, the smaller step
    size: float  # |θ|, radians
    kappa: int | None  # the κ of (−1)^κ·|θ| that is taken, None in case (1)
    steps: tuple[float, ...] = ()  # radians from the record before for κ = 0 and 1

    @property
    def angle(self) -> float:
        """The angle ``(−1)^κ·|θ|``, radians; NaN in case (1)."""
        return np.nan if self.kappa is None else float((-1) ** self.kappa * self.size)

    def __str__(self) -> str:
        if self.kappa is None:
            return f"case (1): |θ| = {np.degrees(self.size):.3f}° is outside travel"
        steps = ", steps {:.3f}° and {:.3f}° for κ = 0 and 1".format(*np.degrees(self.steps)) if self.steps else ""
        return f"case ({self.number}): κ = {self.kappa}, {np.degrees(self.angle):.3f}°{steps}"


@dataclass(frozen=True)
class Turn:
    """The C ± 2π rule at one record: it compares Δ₁, of the angle, with Δ₂, of the angle a turn away; radians."""

    angle: float
    turned: float
    delta_1: float
    delta_2: float

    @property
    def taken(self) -> float:
        """The angle that the rule takes."""
        return self.angle if self.delta_1 <= self.delta_2 else self.turned


def cases(kin: Kinematics, cl: CLData, prefer: int) -> list[Case]:
    """Return the `Case` of each record; before the first, the tilting angle is taken to be 0.

    `prefer`, 1 or -1, is the sign of the dominant range (优势区间) of the tilting axis, for case (2) and the ties
    of case (3). `InputError` if the two solutions of the machine are not opposite angles.

    Examples
    --------
    >>> import mathpost
    >>> kin = mathpost.Kinematics(mathpost.load_machine("dmu50v"))
    >>> print(cases(kin, mathpost.read_cl("data/cl/blade.cl"), 1)[0])
    case (2): κ = 0, 11.817°
    """
    derived = kin.inverse_symbolic
    if derived.tool_side is None:
        raise InputError("strategy 'paper'", "a machine with two rotary axes", "one")
    if derived.solutions[0] != -derived.solutions[1]:
        elsewhere = f"{kin.machine.name}, where it is elsewhere"
        raise InputError("strategy 'paper'", f"a machine whose two solutions are ±{derived.tool_side}", elsewhere)
    near, far = np.sort(np.abs(kin.machine.limits[kin.tool_side])) + TRAVEL_TOLERANCE
    dominant = 0 if prefer > 0 else 1
    found: list[Case] = []
    before = 0.0
    for size in np.abs(kin.inverse(cl.points, cl.axes)[:, 0, kin.tool_side]).tolist():
        case, steps = Case(1, size, None), (abs(size - before), abs(-size - before))
        if size <= near:
            case = Case(3, size, min((dominant, 1 - dominant), key=lambda kappa: steps[kappa]), steps)
        elif size <= far:
            case = Case(2, size, dominant)
        found.append(case)
        before = before if case.kappa is None else case.angle
    return found


def turns(angles: np.ndarray) -> list[Turn]:
    """Return the `Turn` of each workpiece-side angle (radians) between the first and the last.

    As in the paper, the next angle is not yet corrected: a steady motion across ±180° stays broken.
    """
    corrected = [float(angle) for angle in angles]
    found: list[Turn] = []
    for record in range(1, len(corrected) - 1):
        before, angle, after = corrected[record - 1 : record + 2]
        turned = angle - 2 * np.pi * np.sign(angle)
        found.append(Turn(angle, turned, *(abs(each - before) + abs(each - after) for each in (angle, turned))))
        corrected[record] = found[-1].taken
    return found


def choose(kin: Kinematics, cl: CLData, prefer: int) -> tuple[np.ndarray, np.ndarray]:
    """Return joints (n, 5) and branches (n,) by `cases`, equation (6) and `turns`; `ReachError` out of travel."""
    found = cases(kin, cl, prefer)
    for record, case in enumerate(found):
        if case.kappa is None:
            raise ReachError(f"{cl.where(record)}: {kin.inverse_symbolic.tool_side}: {case}")
    branch = np.array([case.kappa for case in found])  # the first branch is the positive one
    joints = kin.inverse(cl.points, cl.axes)[np.arange(len(branch)), branch]
    joints[1:-1, kin.workpiece_side] = [turn.taken for turn in turns(joints[:, kin.workpiece_side])]
    out = np.flatnonzero(~kin.machine.within(joints).all(axis=1))
    if out.size:
        raise ReachError(f"{cl.where(int(out[0]))}: {'; '.join(kin.machine.out_of_travel(joints[out[0]]))}")
    return joints, branch


def four_records(joints: np.ndarray, region: tuple[int, int]) -> np.ndarray:
    """Return the joints, shape (4, 5), of the records s − 1, s, e, e + 1 about the region (s, e)."""
    first, last = region
    if not 0 < first < last < len(joints) - 1:
        raise MathpostError("a spline needs a record before the region and one after it")
    return np.asarray(joints, dtype=float)[[first - 1, first, last, last + 1]]


def end_slopes(rows: np.ndarray, dt: tuple[float, float] = (1.0, 1.0)) -> tuple[np.ndarray, np.ndarray]:
    """Return k₁ and k₂ of equation (7), the changes per unit of virtual time into and out of the region.

    `rows`, shape (4, ...), is M from `four_records`; `dt` the virtual time from s − 1 to s and from e to e + 1.
    """
    rows = np.asarray(rows, dtype=float)
    return (rows[1] - rows[0]) / dt[0], (rows[3] - rows[2]) / dt[1]


@cache
def hermite() -> sp.Expr:
    """Return the cubic that equation (7) clamps, t from 0 to T, as a sympy expression from its four conditions.

    Examples
    --------
    >>> hermite().subs({"t": "T/2", "k_1": 0, "k_2": 0})
    M_e/2 + M_s/2
    """
    t, span, start, end, k_1, k_2 = sp.symbols("t T M_s M_e k_1 k_2")
    unknown = sp.symbols("a:4")
    cubic = sum(a * t**power for power, a in enumerate(unknown))
    ends = [(cubic, 0, start), (cubic, span, end), (cubic.diff(t), 0, k_1), (cubic.diff(t), span, k_2)]
    return cubic.subs(sp.solve([each.subs(t, at) - value for each, at, value in ends], unknown))


def clamped(
    rows: np.ndarray, span: float = 1.0, dt: tuple[float, float] = (1.0, 1.0)
) -> Callable[[ArrayLike], np.ndarray]:
    """Return the same cubic as a function of the virtual time, 0 to `span`; `rows` and `dt` as in `end_slopes`."""
    _, start, end, _ = np.asarray(rows, dtype=float)
    k_1, k_2 = end_slopes(rows, dt)
    compiled = numeric(hermite(), sp.symbols("t T M_s M_e k_1 k_2"))
    return lambda t: compiled(np.expand_dims(t, -1) if start.ndim else t, span, start, end, k_1, k_2)


def paper_clamped(rows: np.ndarray, t: ArrayLike) -> np.ndarray:
    """The cubic of the text, in all five joints as the text has it: X Y Z leave the part. `t` runs from 0 to 1."""
    return clamped(rows)(t)


def paper_cubic(rows: np.ndarray, t: ArrayLike) -> np.ndarray:
    """The cubic of table 3, as its 25 numbers show: one through the records at t = −1, 0, 1, 2, all five joints."""
    return np.polyval(np.linalg.solve(np.vander([-1.0, 0, 1, 2]), rows), np.expand_dims(t, -1))


def paper_literal(rows: np.ndarray, t: ArrayLike) -> np.ndarray:
    """The cubic spline of the text taken literally: through the four records, with k₁ and k₂ at the outer ends."""
    from scipy.interpolate import CubicSpline  # here, as a post that smooths nothing does not wait for it

    k_1, k_2 = end_slopes(rows)
    return CubicSpline([-1, 0, 1, 2], rows, bc_type=((1, k_1), (1, k_2)))(t)


def smooth(
    kin: Kinematics,
    cl: CLData,
    joints: np.ndarray,
    region: tuple[int, int],
    n: int,
    *,
    dt: tuple[float, float] = (1.0, 1.0),
) -> tuple[np.ndarray, np.ndarray]:
    """Put `n` points, evenly spaced in virtual time, into a region: angles on the cubic, X Y Z recomputed.

    `joints`, shape (m, 5), are those of all records, mm and radians; `region` is the first and the last record,
    from 0. Returns the virtual time (n + 2,), in records, and joints (n + 2, 5).
    """
    first, last = region
    curve = clamped(four_records(joints, region)[:, 3:], last - first, dt)
    place = np.linspace(first, last, n + 2)
    return place, kin.close(cl.at(place)[0], curve(place - first))


def lifted(kin: Kinematics, joints: ArrayLike, clearance: float | np.ndarray) -> np.ndarray:
    """Return joints (..., 5), the tip moved by `clearance` (ΔA, mm) along the tool axis: (9), or (10) back."""
    tip, axis = kin.forward(joints)
    return kin.close(tip + clearance * axis, np.asarray(joints)[..., 3:])


def equation_8(
    kin: Kinematics, start: np.ndarray, end: np.ndarray, tolerance: float, *, max_depth: int = 12
) -> tuple[np.ndarray, float, float]:
    """Divide a move by equation (8) of source 002 taken literally, for the audit only.

    The new points lie on the line in joint space, and each half is measured at its middle against its own chord.
    Returns the joints (pieces + 1, 5), the largest error by that measure, and the true one of the whole move, mm.
    """
    for depth in range(max_depth):
        joints = np.linspace(start, end, 2**depth + 1)
        tip, middle = kin.forward(joints)[0], kin.forward((joints[:-1] + joints[1:]) / 2)[0]
        claimed = from_segment(middle, tip[:-1], tip[1:]).max()
        if claimed <= tolerance:
            break
    begin, end = np.broadcast_to(tip[[0, -1], None], (2, len(joints) - 1, 3))
    return joints, float(claimed), float(deviation(kin, joints[:-1], joints[1:], tips=(begin, end))[0].max())
