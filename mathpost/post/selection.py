"""Solution selection (转角选解): which branch and which winding of the rotary axes each record takes.

Every record has two branches, and inside travel every rotary angle may stand ±360° away. Three strategies choose:
the shortest next move, the rules of source 002 word for word, and the best choice over the whole path.
"""

from dataclasses import dataclass, replace

import numpy as np

from mathpost.errors import InputError, ReachError
from mathpost.post import min_plus, yu_dan
from mathpost.post.candidates import Candidates, Inside, along, candidates
from mathpost.post.strategies import Optimal, Shortest, first_moves, moves
from mathpost.post.travel import (
    HALF_TURN,
    SWAY,
    TRAVEL_TOLERANCE,
    TURN,
    breaks_off,
    count_windings,
    move_costs,
    out_of_travel,
    path_cost,
    short_way,
)

__all__ = [
    "HALF_TURN",
    "STRATEGIES",
    "SWAY",
    "TRAVEL_TOLERANCE",
    "TURN",
    "Candidates",
    "Selection",
    "candidates",
    "choose",
    "choose_pieces",
    "move_costs",
    "out_of_travel",
    "path_cost",
    "short_way",
]

STRATEGIES = ("optimal", "shortest", "paper")
MOVES = 65536  # whose costs are held at once: as many as the processor's cache takes
LEAST_RECORDS = 16  # taken at once, however many moves that makes


@dataclass(frozen=True)
class Selection:
    """A choice of joints for a whole path, or for a piece of one.

    Attributes
    ----------
    joints : ndarray, shape (n, 5)
        mm and radians; windings of endless axes counted.
    branch : ndarray of int, shape (n,)
    cost : float
        Seconds if the machine states rates, otherwise weighted travel; of the moves to these records.
    breaks : tuple of int
        Records (from 0) that cannot be reached from the one before without retracting and unwinding.
    strategy : str
    """

    joints: np.ndarray
    branch: np.ndarray
    cost: float
    breaks: tuple
    strategy: str


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
        Whether the path may be split, with a retract and an unwind, where travel does not let it go on. The path
        is split as seldom as possible; among such choices the optimal one costs least.
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
    >>> from mathpost import machine
    >>> from mathpost.post import cl as cldata
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
    (chosen,) = choose_pieces(
        kin, [cl], strategy, weights=weights, start=start, split=split, prefer=prefer, sway=sway
    )
    return chosen


def choose_pieces(
    kin,
    pieces,
    strategy="optimal",
    *,
    weights=None,
    start=None,
    split=False,
    prefer=None,
    sway=SWAY,
    store=None,
    progress=None,
):
    """Choose branch and winding for a path that comes in pieces, as `choose` does for the whole of it.

    However the path is cut, the choice is the same. It needs a pass over all pieces before the first one is
    decided, and a second one to tell; between the pieces, and from pass to pass, little is kept.

    Parameters
    ----------
    kin, strategy, weights, start, split, prefer, sway
        As in `choose`.
    pieces : sequence of CLData
        The parts of the path, of one record at least, one after the other; anything with ``len()`` and ``[k]``.
    store : optional
        Keeps one array of small integers for each piece, a byte for each candidate inside travel: anything with
        ``append``, ``len()`` and ``[k]``, empty; by default a list.
    progress : callable, optional
        Called in the first pass, after each piece, with the number of records done.

    Returns
    -------
    iterator of Selection
        One for each piece; breaks count from its first record. The first one takes the pass over all pieces.

    Raises
    ------
    ReachError
        As `choose` does, by the iterator, before it gives anything.

    Examples
    --------
    >>> from mathpost import machine
    >>> from mathpost.post import cl as cldata
    >>> from mathpost.kinematics import Kinematics
    >>> kin = Kinematics(machine.load("data/machines/dmu50v.toml"))
    >>> blade = cldata.read("data/cl/blade.cl")
    >>> for chosen in choose_pieces(kin, [blade.part(0, 2), blade.part(2, 5)]):
    ...     print(np.rad2deg(chosen.joints[:, 4]).round(3))
    [175.815 178.332]
    [-0.825 -3.286 -8.075]
    """
    if strategy not in STRATEGIES:
        raise InputError("strategy", " or ".join(STRATEGIES), repr(strategy))
    prefer, progress = prefer or _longer_side(kin), progress or (lambda done: None)
    if strategy == "paper":
        chosen = yu_dan.apply(kin, pieces, prefer, progress)
    else:
        rule = (Optimal if strategy == "optimal" else Shortest)()
        task = _Task(kin, pieces, weights, start, prefer, sway, [] if store is None else store)
        chosen = task.chosen(rule, split, progress)
    return _told(kin, chosen, strategy, weights, start, sway)


def _told(kin, chosen, strategy, weights, start, sway):
    """Yield the `Selection` of each piece, given it with its joints and branches."""
    last = None
    for piece, joints, branch in chosen:
        path, axes, first = joints, piece.axes, 1
        if last is not None:
            path, axes, first = np.concatenate([last[0], joints]), np.concatenate([last[1], axes]), 0
        steps = np.diff(path, axis=0)
        over = np.zeros(0)
        if strategy != "paper":
            over = breaks_off(kin, path[:-1], steps, axes, piece.rapid[first:], sway)
        breaks = tuple((np.flatnonzero(over) + first).tolist())
        cost = path_cost(kin.machine, path, weights, start if first else None)
        yield Selection(joints, branch, cost, breaks, strategy)
        last = joints[-1:], piece.axes[-1:]


@dataclass(frozen=True)
class _Task:
    """A path in pieces, and what to choose by."""

    kin: object
    pieces: object
    weights: object
    start: object
    prefer: int
    sway: float
    store: object

    def chosen(self, rule, split, progress):
        """Yield each piece with its joints and branches, chosen by `rule`."""
        broken = self._forward(rule, progress)
        if broken is not None and not split:
            self._refuse_break(type(rule)(), *broken)
        yield from self._backward(rule.last())

    def _forward(self, rule, progress):
        """Take `rule` over the path and store the way back. Return piece and record of the first break, or None."""
        broken, done = None, 0
        for number, (_, blocks) in enumerate(self._all_moves()):
            pointers, record = [], 0
            for block in blocks:
                came_from, breaks = rule.take(block)
                if broken is None and breaks.any():
                    broken = number, record + int(breaks.argmax())
                pointers.append(came_from)
                record += len(breaks)
            self.store.append(min_plus.joined(pointers))
            done += record
            progress(done)
        return broken

    def _backward(self, last):
        """Follow what is stored from the last candidate of all; yield each piece with its joints and branches."""
        ends = [last]
        for number in range(len(self.store) - 1, 0, -1):
            ends.append(int(min_plus.walk(self.store[number], ends[-1])[0]))
        before, turns = np.zeros(5) if self.start is None else np.asarray(self.start, dtype=float), np.zeros(5)
        for number, (piece, slices) in enumerate(along(self.kin, self.pieces)):
            picks = min_plus.walk(self.store[number], ends.pop())[1:]
            picked = [Inside.of(found).picked(picks[rows]) for rows, found in slices]
            joints, branch = (np.concatenate(parts) for parts in zip(*picked, strict=True))
            after = joints[-1].copy()
            turns = count_windings(self.kin.machine, joints, before, turns)
            before = after
            yield piece, joints, branch

    def _refuse_break(self, rule, number, record):
        """Raise for the first break; say where the machine has come to before it."""
        before = replace(self, pieces=_Before(self.pieces, number, record), store=[])
        for _, joints, _ in before.chosen(rule, True, lambda done: None):
            so_far = joints[-1]
        raise ReachError(
            f"{self.pieces[number].where(record)}: the path breaks here, no choice of branch and winding goes on "
            f"in cut (so far {_angles(self.kin.machine, so_far)}); split it, with a retract and an unwind"
        )

    def _all_moves(self):
        """Yield each piece, and an iterator over the `Moves` to its records, in blocks."""
        last, axes = None, None

        def blocks(piece, slices):
            nonlocal last, axes
            for rows, found in slices:
                _refuse_unreachable(found, piece, rows.start)
                here, there, rapid = Inside.of(found), piece.axes[rows], piece.rapid[rows]
                if last is None:
                    first = here.part(0, 1)
                    yield first_moves(self.kin.machine, first, self.weights, self.start, self.prefer)
                    rapid = rapid[1:]
                else:
                    here, there = last.followed_by(here), np.concatenate([axes, there])
                count = max(LEAST_RECORDS, MOVES // len(here.known) ** 2)
                for start in range(0, len(rapid), count):
                    stop = start + count
                    part = here.part(start, stop + 1), there[start : stop + 1], rapid[start:stop]
                    yield moves(self.kin, *part, self.weights, self.sway)
                last, axes = here.last(), there[-1:]

        for piece, slices in along(self.kin, self.pieces):
            yield piece, blocks(piece, slices)


@dataclass(frozen=True)
class _Before:
    """The pieces of a path up to a record, exclusive, of one of them."""

    pieces: object
    number: int
    record: int

    def __len__(self):
        return self.number + (self.record > 0)

    def __getitem__(self, number):
        piece = self.pieces[number]
        return piece if number < self.number else piece.part(0, self.record)


def _longer_side(kin):
    """The direction, +1 or −1, in which the tilting axis has more travel from the middle of its two solutions."""
    derived = kin.inverse_symbolic
    low, high = kin.machine.limits[kin.symbols.index(derived.inner)]
    middle = float(sum(derived.solutions) / 2)
    return 1 if np.isinf(high) or high - middle >= middle - low else -1


def _refuse_unreachable(found, piece, first):
    """Raise for the first record without a candidate inside travel; `first` is the number of the first one."""
    out = np.flatnonzero(~found.inside.any(axis=1))
    if out.size:
        record = int(out[0])
        reasons = dict.fromkeys(found.reason(record, candidate) for candidate in found.listed(record))
        raise ReachError(f"{piece.where(first + record)}: no solution inside travel: {' / '.join(reasons)}")


def _angles(machine, joints):
    pairs = zip(machine.joint_names[3:], np.rad2deg(joints[3:]), strict=True)
    return " ".join(f"{name} {angle:.3f}°" for name, angle in pairs)
