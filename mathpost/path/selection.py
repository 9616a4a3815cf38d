"""Solution selection (转角选解): which branch and which winding of the rotary axes each record takes.

Each record has several *candidates*: two branches, each in every winding (±360°) inside travel, and at the pole
also the workpiece-side angles of the neighbours. One is chosen for each record: on the best way over the whole path
by dynamic programming (动态规划, R. Bellman 1957), by the shortest next move, or by the rules of source 002.
"""

from __future__ import annotations

from collections.abc import Callable
from copy import copy
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from mathpost.errors import InputError, ReachError, as_array
from mathpost.formula import compiled, slices
from mathpost.machine import ENDLESS, Machine
from mathpost.path import singular
from mathpost.path.dynamic_programming import TIE, TURN, Axes, Records, best_way, cost, nearest
from mathpost.sources import yu_dan

if TYPE_CHECKING:
    from mathpost.kinematics import Kinematics
    from mathpost.path.cl import CLData

STRATEGIES = ("optimal", "shortest", "paper")
SWAY = np.radians(0.05)  # how far the tool axis may leave its great circle for a change of branch in cut
POLE = 1e-10  # radians from the pole, within which every workpiece-side angle is right
PREFERENCE = 1e-3  # of the way: by so much the other branch has to be cheaper than the preferred one to begin on it
EVEN = np.radians(1.0)  # by which the travel of a tilting axis may be shorter on the side that it prefers
MANY = 10  # turns of travel
LONG = 24_000  # moves to compare; with more of them it pays to load Numba


@dataclass(frozen=True)
class Selection:
    """A choice of joints for a path."""

    joints: np.ndarray  # shape (n, j), mm and radians; windings of endless axes counted
    branch: np.ndarray  # shape (n,), 0 or 1, as `Kinematics.inverse` orders them
    cost: float  # by `move_costs`; from `start` if that is given
    breaks: tuple[int, ...]  # records (from 0) that cannot be reached without retracting and unwinding
    strategy: str


@dataclass(frozen=True)
class Candidates:
    """All candidates of each record, to look at."""

    kin: Kinematics
    joints: np.ndarray  # shape (n, m, j), mm and radians; NaN out of reach, and what is for the pole only elsewhere
    branch: np.ndarray  # shape (m,), 0 or 1, as `Kinematics.inverse` orders them

    @cached_property
    def inside(self) -> np.ndarray:
        """Whether all five joints are inside travel, shape (n, m)."""
        return np.logical_and.reduce(self.kin.machine.within(self.joints), axis=-1)

    def reason(self, record: int, candidate: int) -> str:
        """Say why a candidate is out, or return "" if it is not."""
        if np.isnan(self.joints[record, candidate]).any():
            return "tool axis out of reach"
        return "; ".join(self.kin.machine.out_of_travel(self.joints[record, candidate]))

    def table(self, record: int, previous: np.ndarray | None = None) -> list[tuple[int, np.ndarray, float, str]]:
        """Return rows to show: branch, joints in mm and degrees, cost of the move from `previous`, why if out."""
        machine, known = self.kin.machine, ~np.isnan(self.joints[record]).any(axis=1)
        listed = np.flatnonzero(known | ~known.any()).tolist()  # those for the pole only at the pole
        joints = self.joints[record, listed]
        costs = move_costs(machine, joints if previous is None else short_way(machine, joints - previous))
        reasons = [self.reason(record, candidate) for candidate in listed]
        return list(zip(self.branch[listed].tolist(), joints * machine.units, costs, reasons, strict=True))


def candidates(kin: Kinematics, tip: ArrayLike, axis: ArrayLike) -> Candidates:
    """Return all candidates for a path of tips and tool axes, shape (n, 3) each, as `Candidates`.

    Examples
    --------
    >>> import mathpost
    >>> kin = mathpost.Kinematics(mathpost.load_machine("ac_head"))
    >>> for branch, joints, _, reason in candidates(kin, [[0, 0, 0]], [[0.6, 0, 0.8]]).table(0):
    ...     print(branch, joints[3:].round(2), reason or "inside travel")
    0 [90.   36.87] inside travel
    0 [-270.     36.87] inside travel
    0 [450.     36.87] C 450.000° is outside -360 … 360
    1 [-90.   -36.87] inside travel
    1 [-450.    -36.87] C -450.000° is outside -360 … 360
    1 [270.   -36.87] inside travel
    """
    return _explained(kin, _solutions(kin, tip, axis))


def choose(
    kin: Kinematics, cl: CLData, strategy: str = "optimal", *, start: ArrayLike | None = None,
    split: bool = False, prefer: int | None = None, sway: float = SWAY,
) -> Selection:  # fmt: skip
    """Choose branch and winding for every record, as `Selection`.

    Parameters
    ----------
    kin : Kinematics
    cl : CLData
    strategy : str
        ``"optimal"``: least cost over the whole path, by dynamic programming. ``"shortest"``: least cost of each
        next move. ``"paper"``: the cases and the C ± 2π rule of source 002.
    start : array_like, shape (j,), optional
        Present joints (mm, radians). Without it the first record prefers the branch `prefer`, near rotary zero.
    split : bool
        Whether the path may be split, with a retract and an unwind, where travel does not let it go on. It is split
        as seldom as possible; among such choices the optimal one costs least.
    prefer : {1, -1}, optional
        The preferred direction of the tilting axis, the paper's dominant range (优势区间): the path begins on it
        unless the other one is cheaper by a thousandth, and it decides the paper's case (2). By default the longer
        side of its travel.
    sway : float
        Radians, how far the tool axis may leave its great circle to change the branch in cut: the branch changes
        only where the circle between two records comes nearer than this to a singular tool axis.

    Raises
    ------
    ReachError
        With record and reason: if it has no candidate inside travel, or the path breaks and may not be `split`.
    InputError
        If an argument is none of those above, or the rules of source 002 do not fit the machine.

    Examples
    --------
    >>> import mathpost
    >>> kin = mathpost.Kinematics(mathpost.load_machine("dmu50v"))
    >>> np.rad2deg(choose(kin, mathpost.read_cl("data/cl/blade.cl")).joints[:, 3:]).round(3)
    array([[ 11.817, 175.815],
           [  4.717, 178.332],
           [  2.334,  -0.825],
           [  9.284,  -3.286],
           [ 22.691,  -8.075]])
    """
    if strategy not in STRATEGIES:
        raise InputError("strategy", " or ".join(STRATEGIES), repr(strategy))
    if prefer not in (None, 1, -1):
        raise InputError("prefer", "1 or -1", repr(prefer))
    machine, workpiece_side = kin.machine, kin.workpiece_side
    start = None if start is None else as_array(start, len(kin.symbols), "start")
    if prefer is None:  # the longer side of travel from the middle of the two solutions
        low, high = machine.limits[kin.tool_side or kin.workpiece_side] - float(
            sum(kin.inverse_symbolic.solutions) / 2
        )
        prefer = 1 if np.isinf(high) or high >= -low - EVEN else -1
    again = partial(choose, strategy=strategy, start=start, prefer=prefer, sway=sway)
    if strategy == "paper":
        joints, branch = yu_dan.choose(kin, cl, prefer)
        return Selection(joints, branch, path_cost(machine, joints, start), (), strategy)

    if (loose := without_far_limits(machine)) != machine:  # hundreds of windings that hardly ever matter
        without = copy(kin)
        without.machine = loose
        chosen = again(without, cl, split=split)
        if machine.within(chosen.joints).all():  # the best way without a limit, and inside it
            return chosen

    solved, turns = _solutions(kin, cl.points, cl.axes), _turns(machine)
    beyond = _beyond_the_short_way(kin, cl, solved, singular.STILL * sway)
    first = _explained(kin, solved[..., :1])
    if start is None:
        beginning = TIE * np.abs((first.joints[0] * machine.units)[:, 3:]).sum(axis=1)
        beginning += _preference(machine, solved) * (first.branch != (0 if prefer > 0 else 1))
    else:
        beginning = move_costs(machine, short_way(machine, first.joints[0] - start))
    by_solution = np.ascontiguousarray(np.swapaxes(solved, 0, 1))  # one order in memory: the loop is compiled once
    long = len(cl) * len(first.branch) ** 2 > LONG
    picks, broken, unreachable, stuck = (compiled(best_way, nearest, cost) if long else best_way)(
        Axes(machine.ends, machine.endless, workpiece_side, *prices(machine)),
        Records(by_solution, turns, beyond, np.r_[False, singular.near(kin, cl, sway)], np.array(cl.rapid)),
        beginning, strategy == "shortest",
    )  # fmt: skip
    if unreachable >= 0:
        rows = _explained(kin, solved[..., unreachable, None]).table(0)
        reasons = " / ".join(dict.fromkeys(why for *_, why in rows))
        raise ReachError(f"{cl.where(unreachable)}: no solution inside travel: {reasons}")
    if stuck >= 0 and not split:
        so_far = np.rad2deg(again(kin, cl.part(0, stuck), split=True).joints[-1, 3:])
        angles = " ".join(f"{joint.name} {at:.3f}°" for joint, at in zip(machine.rotary, so_far, strict=True))
        reason = f"no choice of branch and winding goes on in cut (so far {angles})"
        raise ReachError(
            f"{cl.where(stuck)}: the path breaks here, {reason}; split it, with a retract and an unwind"
        )
    (solution, winding), records = np.divmod(picks, turns.shape[1]), np.arange(len(cl))
    joints = np.empty((len(solved), len(cl))).T  # joint by joint is read fastest
    for column, angle, turn in zip(joints.T, solved, turns, strict=True):
        column[:] = angle[solution, records] + turn[winding]
    further = np.where(np.diff(solution, prepend=-1) == 0, beyond[solution, records], 0)
    for joint in np.flatnonzero(
        machine.endless
    ):  # goes on the short way, and the workpiece-side one `further` turns
        turned = np.diff(joints[:, joint], prepend=0.0 if start is None else start[joint])
        joints[:, joint] -= TURN * np.cumsum(np.rint(turned / TURN) - further * (joint == workpiece_side))
    breaks = tuple(np.flatnonzero(broken).tolist())
    return Selection(joints, (solution % 2).astype(np.int8), path_cost(machine, joints, start), breaks, strategy)


def _solutions(kin: Kinematics, tip: ArrayLike, axis: ArrayLike) -> np.ndarray:
    """Both branches of each record, shape (j, k, n), k = 2; k = 6 if some are at the pole, NaN for all others.

    There the workpiece-side axis may also take the angles of the nearest records before and after that are not at
    the pole, of each branch. It can then be turned where that costs nothing of the tool axis.
    """
    joints, tip = kin.inverse(tip, axis), np.asarray(tip, dtype=float)
    at_pole = np.zeros(len(joints), dtype=bool)
    if kin.tool_side is not None and kin.reach[0] == 0:  # there the two solutions meet at the pole
        at_pole = np.abs(joints[:, 0, kin.tool_side] - joints[:, 1, kin.tool_side]) < 2 * POLE
    elsewhere = np.flatnonzero(~at_pole)
    if not at_pole.any() or not elsewhere.size:
        return joints.T
    solved = np.full((joints.shape[-1], 6, len(joints)), np.nan)
    solved[:, :2] = joints.T
    after = np.searchsorted(elsewhere, np.flatnonzero(at_pole))
    for first, neighbour in ((2, after - 1), (4, after)):
        rotary = joints[at_pole, :, 3:]
        rotary[..., kin.workpiece_side - 3] = joints[
            elsewhere[np.clip(neighbour, 0, len(elsewhere) - 1)], :, kin.workpiece_side
        ]
        solved[:, first : first + 2, at_pole] = kin.close(tip[at_pole, None], rotary).T
    return solved


def _preference(machine: Machine, solved: np.ndarray) -> float:
    """What it costs to begin on the other branch than the preferred one.

    A branch that is as good must not win by rounding, or by the micrometres that a calibration moves an axis.
    """
    ways = [np.nansum(_costs_along(machine, branch, short_way)) for branch in np.swapaxes(solved[:, :2], 0, 1)]
    return max(PREFERENCE * float(min(ways)), 1e-6)


def _beyond_the_short_way(kin: Kinematics, cl: CLData, solved: np.ndarray, still: float) -> np.ndarray:
    """How many whole turns the workpiece-side axis makes beyond its short way to each record in cut, (k, n)."""
    # Where the rotary axes are not at right angles, a great circle that passes beside the pole can take it a little
    # more than half a turn. One that passes as near as `still` may go either way.
    beyond, angles = np.zeros(solved.shape[1:], np.int8), solved[kin.workpiece_side, :2]
    if kin.tool_side is None:  # its only way between two tool axes is the short one
        return beyond
    steps = nearest(np.diff(angles))
    moves = np.flatnonzero((np.abs(steps) > np.pi / 2).any(axis=0) & ~cl.rapid[1:])
    t, away = singular.nearest(kin, cl.axes[moves], cl.axes[moves + 1], singular.from_pole)
    moves, t = moves[away > still], t[away > still]
    middle = kin.inverse(*cl.at(moves + t))[..., kin.workpiece_side].T
    turned = nearest(middle - angles[:, moves]) + nearest(angles[:, moves + 1] - middle)
    beyond[:2, moves + 1] = np.nan_to_num(np.rint((turned - steps[:, moves]) / TURN))
    return beyond


def _turns(machine: Machine) -> np.ndarray:
    """What each winding of the rotary axes adds to the j joints, shape (j, w), radians."""
    several = np.meshgrid(*(windings(*limits) for limits in machine.limits[3:]), indexing="ij")
    return np.concatenate([np.zeros((3, several[0].size)), np.reshape(several, (len(several), -1))])


def _explained(kin: Kinematics, solved: np.ndarray) -> Candidates:
    """`Candidates` of `_solutions`."""
    turns = _turns(kin.machine)
    joints = (solved[:, :, None] + turns[:, None, :, None]).reshape(len(solved), -1, solved.shape[2])
    return Candidates(kin, joints.T, np.repeat(np.arange(solved.shape[1]) % 2, turns.shape[1]))


# Moves: the short way round, and what they cost.


def without_far_limits(machine: Machine) -> Machine:
    """The machine with its rotary axes endless that have room for more than `MANY` turns."""
    far = [joint.limits[1] - joint.limits[0] > MANY * TURN for joint in machine.rotary]
    rotary = (replace(each, limits=ENDLESS) if so else each for each, so in zip(machine.rotary, far, strict=True))
    return replace(machine, rotary=tuple(rotary))


def windings(low: float, high: float) -> np.ndarray:
    """The whole turns, radians, that may bring an angle in [−180°, 180°] into travel; 0 for an endless axis."""
    if not (np.isfinite(low) and np.isfinite(high)):
        return np.zeros(1)
    turns = np.arange(np.floor((low - np.pi) / TURN), np.ceil((high + np.pi) / TURN) + 1)
    turns = turns[(turns * TURN - np.pi <= high) & (turns * TURN + np.pi >= low)]
    return TURN * turns[np.argsort(np.abs(turns), kind="stable")]


def short_way(machine: Machine, steps: ArrayLike) -> np.ndarray:
    """Return joint steps, shape (..., j), with those of endless axes brought into [−180°, 180°]."""
    steps = np.array(steps, dtype=float)
    around = machine.endless
    steps[..., around] = nearest(steps[..., around])
    return steps


def prices(machine: Machine) -> tuple[np.ndarray, bool]:
    """What a mm or radian of each joint costs, shape (j,), and whether only the slowest joint counts."""
    known = ~np.isnan(machine.max_rates)
    return (np.nan_to_num(1 / machine.max_rates) if known.any() else machine.units), bool(known.any())


def move_costs(machine: Machine, steps: ArrayLike) -> np.ndarray:
    """Return what moves by joint steps (..., j), mm and radians, cost, shape (...).

    That is the seconds that the slowest axis needs, over the axes whose rate the machine states; if it states none,
    the sum of mm and degrees.

    Examples
    --------
    >>> import mathpost
    >>> move_costs(mathpost.load_machine("dmu50v"), [[0, 0, 100, 0, np.pi]])
    array([5.])
    """
    return cost(np.moveaxis(np.asarray(steps, dtype=float), -1, 0), *prices(machine))


def path_cost(machine: Machine, joints: np.ndarray, start: np.ndarray | None) -> float:
    """What a sequence of joints, shape (n, j), costs, with the way from `start`, if given, to its first row."""
    total = float(np.sum(_costs_along(machine, joints.T)))
    return total if start is None else total + float(move_costs(machine, short_way(machine, joints[0] - start)))


def _costs_along(machine: Machine, joints: np.ndarray, way: Callable | None = None) -> np.ndarray:
    """What each move between joints (j, n) that follow each other costs, shape (n - 1,), as it is or by a `way`."""
    costs = np.empty(joints.shape[1] - 1)
    for moves in slices(costs.shape):
        steps = np.diff(joints[:, moves.start : moves.stop + 1]).T
        costs[moves] = move_costs(machine, steps if way is None else way(machine, steps))
    return costs
