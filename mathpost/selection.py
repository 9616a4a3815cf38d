"""Solution selection (转角选解): which branch and which winding of the rotary axes each record takes.

Every record has two branches, and inside travel every rotary angle may stand ±360° away. Three strategies choose:
the shortest next move, the rules of source 002 word for word, and the best choice over the whole path.
"""

from dataclasses import dataclass, replace

import numpy as np

from mathpost.errors import InputError, ReachError
from mathpost.rotation import unit

TURN = 2 * np.pi
STRATEGIES = ("optimal", "shortest", "paper")
HALF_TURN = np.pi + 1e-9  # a rotary step beyond this means that travel has cut off the short way round
SWAY = np.radians(5.0)  # how far the tool axis may stray between two records in cut, besides half of its own turn
BREAK = 1e9  # the cost of a retract and unwind: more than any path without one
POLE = 1e-20  # r − D, half the square of the angle from the pole: within 1e-10 rad of it
TRAVEL_TOLERANCE = 1e-9  # mm and radians
PER_RADIAN = np.degrees(1.0)  # in weighted travel a degree counts as much as a millimetre
TIE = 1e-9  # weight of travel (mm and degrees) among choices that take the same time
PREFERENCE = 1e-6  # cost of beginning on the other branch than the preferred one


@dataclass(frozen=True)
class Candidates:
    """Every solution of every record.

    Attributes
    ----------
    joints : ndarray, shape (n, m, 5)
        mm and radians; NaN where the tool axis is out of reach, or not at the pole in a column that stands for it.
        An endless axis has one angle only, in
        (−180°, 180°]: its windings are counted by the choice.
    branch : ndarray of int, shape (m,)
        0 or 1, as `Kinematics.inverse` orders them.
    inside : ndarray of bool, shape (n, m)
        Whether all joints are inside travel.
    kin : Kinematics
    """

    joints: np.ndarray
    branch: np.ndarray
    inside: np.ndarray
    kin: object

    @property
    def machine(self):
        """The machine whose travel is meant."""
        return self.kin.machine

    def ever_inside(self):
        """The same without the candidates that are outside travel at every record."""
        used = self.inside.any(axis=0)
        return replace(self, joints=self.joints[:, used], branch=self.branch[used], inside=self.inside[:, used])

    def listed(self, record):
        """Numbers of the candidates of a record; those that stand for the pole only are left out elsewhere."""
        known = ~np.isnan(self.joints[record]).any(axis=1)
        return np.flatnonzero(known) if known.any() else np.arange(len(known))

    def reason(self, record, candidate):
        """Say why a candidate is out, or return "" if it is not."""
        if np.isnan(self.joints[record, candidate]).any():
            return "tool axis out of reach"
        return "; ".join(out_of_travel(self.machine, self.joints[record, candidate]))

    def table(self, record, previous=None, weights=None):
        """Rows to show: branch, joints in mm and degrees, cost of the move from `previous`, and why if out."""
        listed = self.listed(record)
        joints = self.joints[record, listed]
        steps = joints if previous is None else short_way(self.machine, joints - np.asarray(previous, dtype=float))
        degrees = np.concatenate([joints[:, :3], np.rad2deg(joints[:, 3:])], axis=1)
        reasons = [self.reason(record, candidate) for candidate in listed]
        costs = move_costs(self.machine, steps, weights)
        return list(zip(self.branch[listed].tolist(), degrees, costs, reasons, strict=True))


@dataclass(frozen=True)
class Selection:
    """A choice of joints for a whole path.

    Attributes
    ----------
    joints : ndarray, shape (n, 5)
        mm and radians; windings of endless axes counted.
    branch : ndarray of int, shape (n,)
    cost : float
        Seconds if the machine states rates, otherwise weighted travel.
    breaks : tuple of int
        Records (from 0) that cannot be reached from the one before without retracting and unwinding.
    strategy : str
    """

    joints: np.ndarray
    branch: np.ndarray
    cost: float
    breaks: tuple
    strategy: str


def candidates(kin, tip, axis):
    """Return all candidates for tips and axes of shape (n, 3) as `Candidates`.

    At the pole every outer angle is right. Besides 0 those of the nearest records before and after that are not at
    the pole are candidates there, so that the axis can be turned while that costs nothing of the tool axis.
    """
    joints = kin.inverse(tip, axis)
    at_pole = _at_pole(kin, axis)
    if at_pole.any() and not at_pole.all():
        joints = np.concatenate([joints, *_held_at_pole(kin, tip, joints, at_pole)], axis=1)
    limits = kin.machine.limits
    turns = [_windings(*limits[joint]) for joint in (3, 4)]
    offsets = np.zeros((len(turns[0]) * len(turns[1]), 5))
    offsets[:, 3:] = np.stack(np.meshgrid(*turns, indexing="ij"), axis=-1).reshape(-1, 2) * TURN
    grid = (joints[:, :, None] + offsets).reshape(len(joints), -1, 5)
    inside = ((grid >= limits[:, 0] - TRAVEL_TOLERANCE) & (grid <= limits[:, 1] + TRAVEL_TOLERANCE)).all(axis=-1)
    branch = np.repeat(np.arange(joints.shape[1]) % 2, len(offsets))
    return Candidates(grid, branch, inside, kin)


def _at_pole(kin, axis):
    """Whether tool axes (n, 3) are parallel to the outer axis, to rounding; False where that is out of reach."""
    if kin.reach[0] > 0:
        return np.zeros(len(axis), dtype=bool)
    return kin.reach_terms(unit(np.asarray(axis, dtype=float)))[0] < POLE


def _held_at_pole(kin, tip, joints, at_pole):
    """Two blocks of candidates (n, 2, 5): the outer angles of the records before and after; NaN off the pole."""
    outer = kin.symbols.index(kin.inverse_symbolic.outer)
    others = np.flatnonzero(~at_pole)
    where = np.searchsorted(others, np.flatnonzero(at_pole))
    for neighbour in (where - 1, where):
        held = np.full_like(joints, np.nan)
        source = others[np.clip(neighbour, 0, len(others) - 1)]
        rotary = joints[at_pole, :, 3:]
        rotary[..., outer - 3] = joints[source, :, outer]
        held[at_pole] = kin.close(np.asarray(tip, dtype=float)[at_pole, None], rotary)
        yield held


def _windings(low, high):
    """Whole turns that may bring an angle of (−180°, 180°] into travel, the nearest to none first."""
    if not (np.isfinite(low) and np.isfinite(high)):
        return np.zeros(1)
    turns = np.arange(np.floor((low - np.pi) / TURN), np.ceil((high + np.pi) / TURN) + 1)
    useful = turns[(turns * TURN - np.pi <= high) & (turns * TURN + np.pi >= low)]
    return useful[np.argsort(np.abs(useful), kind="stable")]


def move_costs(machine, steps, weights=None):
    """Return what moves by the joint steps `steps`, shape (..., 5) in mm and radians, cost.

    The time that the slowest axis needs, in seconds, over the axes whose rate the machine states; where it states
    none, or where `weights` (5 numbers, per mm and per degree) are given, the weighted sum of travel.
    """
    known = ~np.isnan(machine.max_rates)
    if weights is None and known.any():
        return np.abs(steps[..., known] / machine.max_rates[known]).max(axis=-1)
    weights = np.ones(5) if weights is None else np.asarray(weights, dtype=float)
    return np.abs(steps) @ (weights * np.array([1, 1, 1, PER_RADIAN, PER_RADIAN]))


def _ties(steps):
    """What tells equal costs apart: less travel."""
    return TIE * np.abs(steps) @ np.array([1, 1, 1, PER_RADIAN, PER_RADIAN])


def short_way(machine, steps):
    """Return joint steps, shape (..., 5), with those of endless axes brought into [−180°, 180°]."""
    return np.where(_endless(machine), steps - TURN * np.round(steps / TURN), steps)


def _endless(machine):
    return ~np.isfinite(machine.limits).all(axis=1) & (np.arange(5) > 2)


def choose(kin, cl, strategy="optimal", *, weights=None, start=None, split=False, prefer=None, sway=SWAY):
    """Choose branch and winding for every record.

    Parameters
    ----------
    kin : Kinematics
    cl : CLData
    strategy : str
        ``"optimal"``: least cost over the whole path, by dynamic programming over the candidates.
        ``"shortest"``: least cost of each next move. ``"paper"``: the cases and the C ± 2π rule of source 002.
    weights : array_like, shape (5,), optional
        See `move_costs`.
    start : array_like, shape (5,), optional
        Present joints (mm, radians). Without it the first record prefers the branch `prefer`, near rotary zero.
    split : bool
        Whether the path may be split, with a retract and an unwind, where travel does not let it go on.
    prefer : {1, -1}, optional
        The preferred direction of the tilting axis, the paper's dominant range (优势区间): to begin on among
        equals, and in its case (2). By default the longer side of its travel.
    sway : float
        Radians; in cut, a move is no choice if it takes the tool axis further than this, and half of its own turn,
        off the great circle between two records, as a change of branch away from the pole does.

    Returns
    -------
    Selection

    Raises
    ------
    ReachError
        If a record has no candidate inside travel, or if the path breaks and `split` is not given; names the
        record and the reason.

    Examples
    --------
    >>> from mathpost import cldata, machine
    >>> from mathpost.kinematics import Kinematics
    >>> kin = Kinematics(machine.load("data/machines/dmu50v.toml"))
    >>> chosen = choose(kin, cldata.read("data/cl/blade.cl"))
    >>> np.rad2deg(chosen.joints[:, 3:]).round(3)
    array([[ 11.817, 175.815],
           [  4.717, 178.332],
           [  2.334,  -0.825],
           [  9.284,  -3.286],
           [ 22.691,  -8.075]])
    """
    if strategy not in STRATEGIES:
        raise InputError("strategy", " or ".join(STRATEGIES), repr(strategy))
    prefer = prefer or _longer_side(kin)
    if strategy == "paper":
        joints, branch = _paper(kin, cl, prefer)
        return Selection(joints, branch, path_cost(kin.machine, joints, weights, start), (), strategy)
    found = candidates(kin, cl.points, cl.axes)
    _refuse_unreachable(found, cl)
    found = found.ever_inside()
    first = _first_costs(found, weights, start, prefer)
    pick, broken = (_optimal if strategy == "optimal" else _shortest)(found, first, cl.rapid, weights, sway)
    joints = _count_windings(kin.machine, found.joints[np.arange(len(pick)), pick], start)
    if broken is not None and not split:
        raise ReachError(
            f"{cl.where(broken)}: the path breaks here, no choice of branch and winding goes on in cut "
            f"(so far {_angles(kin.machine, joints[broken - 1])}); split it, with a retract and an unwind"
        )
    over = _breaks_off(kin, joints[:-1], np.diff(joints, axis=0), sway) & ~cl.rapid[1:]
    breaks = tuple(int(record) for record in np.flatnonzero(over) + 1)
    return Selection(joints, found.branch[pick], path_cost(kin.machine, joints, weights, start), breaks, strategy)


def path_cost(machine, joints, weights=None, start=None):
    """Return what a sequence of joints, shape (n, 5), costs, the way from `start` to its first row included."""
    steps = np.diff(joints, axis=0)
    if start is not None:
        steps = np.concatenate([short_way(machine, joints[:1] - np.asarray(start, dtype=float)), steps])
    return float(move_costs(machine, steps, weights).sum())


def _longer_side(kin):
    """The direction, +1 or −1, in which the tilting axis has more travel from the middle of its two solutions."""
    derived = kin.inverse_symbolic
    low, high = kin.machine.limits[kin.symbols.index(derived.inner)]
    middle = float(sum(derived.solutions) / 2)
    return 1 if np.isinf(high) or high - middle >= middle - low else -1


def _first_costs(found, weights, start, prefer):
    """Cost of beginning with each candidate of the first record."""
    joints = found.joints[0]
    if start is None:
        on_the_other = found.branch != (0 if prefer > 0 else 1)
        costs = PREFERENCE * on_the_other + _ties(np.pad(joints[:, 3:], ((0, 0), (3, 0))))
    else:
        costs = move_costs(
            found.machine, short_way(found.machine, joints - np.asarray(start, dtype=float)), weights
        )
    return np.where(found.inside[0], costs, np.inf)


def _optimal(found, first, rapid, weights, sway):
    """Dynamic programming over the candidates. Returns the choice and the first record that needs a break."""
    best = {candidate: cost for candidate, cost in enumerate(first.tolist()) if cost < np.inf}
    came_from = np.zeros(found.inside.shape, dtype=np.int16)
    columns, broken = np.arange(len(first)), None
    # Few candidates are inside travel at any one record: for these, Python's own numbers are faster than arrays.
    for record, costs in _all_moves(found, rapid, weights, sway):
        total = costs.tolist()
        steps = {
            candidate: min((cost + total[before][candidate], before) for before, cost in best.items())
            for candidate in columns[found.inside[record]].tolist()
        }
        best = {candidate: cost for candidate, (cost, _) in steps.items()}
        for candidate, (_, before) in steps.items():
            came_from[record, candidate] = before
        if broken is None and min(best.values()) >= BREAK:
            broken = record
    pick = np.empty(len(found.joints), dtype=np.intp)
    pick[-1] = min(best, key=best.get)
    for record in range(len(pick) - 1, 0, -1):
        pick[record - 1] = came_from[record, pick[record]]
    return pick, broken


def _shortest(found, first, rapid, weights, sway):
    """The candidate that costs least from the one before, never back on a choice. Returns as `_optimal`."""
    pick, broken = np.empty(len(found.joints), dtype=np.intp), None
    pick[0] = first.argmin()
    for record, costs in _all_moves(found, rapid, weights, sway):
        pick[record] = costs[pick[record - 1]].argmin()
        if broken is None and costs[pick[record - 1], pick[record]] >= BREAK:
            broken = record
    return pick, broken


def _all_moves(found, rapid, weights, sway):
    """Yield each record but the first with the costs of all moves to it, shape (from candidate, to candidate).

    Outside travel is infinite; a move that may not be made in cut costs `BREAK`.
    """
    chunk = max(1, 400_000 // found.inside.shape[1] ** 2)
    for first in range(1, len(found.joints), chunk):
        rows = slice(first, min(first + chunk, len(found.joints)))
        before = found.joints[rows.start - 1 : rows.stop - 1, :, None]
        steps = short_way(found.machine, found.joints[rows, None] - before)
        over = _breaks_off(found.kin, before, steps, sway) & ~rapid[rows, None, None]
        costs = move_costs(found.machine, steps, weights) + _ties(steps) + np.where(over, BREAK, 0.0)
        possible = found.inside[rows.start - 1 : rows.stop - 1, :, None] & found.inside[rows, None]
        yield from enumerate(np.where(possible, costs, np.inf), first)


def _breaks_off(kin, start, steps, sway):
    """Whether moves from joints `start` by `steps`, broadcasting over (..., 5), cannot be made in cut.

    That is so if a rotary axis turns by more than half a turn, which no path asks for, or if the tool axis sways
    off its great circle, as it does where the branch changes away from the pole. What it does half way tells.
    """
    turned = np.abs(steps[..., 3:])
    over = (turned > HALF_TURN).any(axis=-1)
    suspect = ~over & (turned.sum(axis=-1) > sway)
    if suspect.any():
        first = np.broadcast_to(start, steps.shape)[suspect]
        before, half_way, after = (kin.forward(first + part * steps[suspect])[1] for part in (0, 0.5, 1))
        middle = (before + after) / 2
        turn = np.linalg.norm(after - before, axis=-1)
        over[suspect] = np.linalg.norm(half_way - middle, axis=-1) > sway + turn / 2
    return over


def _count_windings(machine, joints, start):
    """Unwrap the endless axes from record to record, beginning nearest to `start` or to rotary zero."""
    before = np.zeros(5) if start is None else np.asarray(start, dtype=float)
    steps = short_way(machine, np.diff(joints, axis=0, prepend=before[None]))
    turns = np.round((before + np.cumsum(steps, axis=0) - joints) / TURN)
    return np.where(_endless(machine), joints + TURN * turns, joints)


def _refuse_unreachable(found, cl):
    out = np.flatnonzero(~found.inside.any(axis=1))
    if out.size:
        record = int(out[0])
        reasons = dict.fromkeys(found.reason(record, candidate) for candidate in found.listed(record))
        raise ReachError(f"{cl.where(record)}: no solution inside travel: {' / '.join(reasons)}")


def out_of_travel(machine, joints):
    """Sentences on the joints, shape (5,), that are outside travel."""
    units = ("mm", "mm", "mm", "°", "°")
    scale = np.array([1, 1, 1, PER_RADIAN, PER_RADIAN])
    sentences = []
    for name, value, (low, high), letter in zip(
        machine.joint_names, joints * scale, machine.limits * scale[:, None], units, strict=True
    ):
        if not low - TRAVEL_TOLERANCE <= value <= high + TRAVEL_TOLERANCE:
            sentences.append(f"{name} {value:.3f}{letter} is outside {low:g} … {high:g}")
    return sentences


def _angles(machine, joints):
    pairs = zip(machine.joint_names[3:], np.rad2deg(joints[3:]), strict=True)
    return " ".join(f"{name} {angle:.3f}°" for name, angle in pairs)


def _paper(kin, cl, prefer):
    """Cases (1) to (3), equation (6) and the C ± 2π rule of source 002, section 1.2, word for word.

    The C ± 2π rule compares with the next angle before that one is corrected, as the paper has it; it does not
    repair an ordinary crossing of ±180°. The result may swing the long way round, and is for comparison.
    """
    derived = kin.inverse_symbolic
    inner, outer = (kin.symbols.index(joint) for joint in (derived.inner, derived.outer))
    if derived.solutions[0] != -derived.solutions[1]:
        found = f"{kin.machine.name}, where it is elsewhere"
        raise InputError("strategy 'paper'", f"a machine whose two solutions are ±{derived.inner}", found)
    low, high = kin.machine.limits[inner]
    near, far = sorted((abs(low), abs(high)))
    preferred = prefer or (1 if abs(high) >= abs(low) else -1)
    joints = kin.inverse(cl.points, cl.axes)
    theta = np.abs(joints[:, 0, inner])
    branch, before = np.empty(len(theta), dtype=int), 0.0
    for record, angle in enumerate(theta):
        if not angle <= far + TRAVEL_TOLERANCE:  # case (1), and out of reach
            raise ReachError(
                f"{cl.where(record)}: |{derived.inner}| {np.rad2deg(angle):.3f}° is outside travel, case (1)"
            )
        if angle > near:  # case (2), equation (5)
            sign = preferred
        else:  # case (3)
            sign = min((preferred, -preferred), key=lambda sign: abs(sign * angle - before))
        branch[record], before = (0 if sign > 0 else 1), sign * angle
    chosen = joints[np.arange(len(branch)), branch]
    turned = chosen[:, outer]
    for record in range(1, len(turned) - 1):
        other = turned[record] - TURN * np.sign(turned[record])
        change = [
            abs(angle - turned[record - 1]) + abs(angle - turned[record + 1]) for angle in (turned[record], other)
        ]
        if change[0] > change[1]:
            turned[record] = other
    for record, row in enumerate(chosen):
        if sentences := out_of_travel(kin.machine, row):
            raise ReachError(f"{cl.where(record)}: {'; '.join(sentences)}")
    return chosen, branch
