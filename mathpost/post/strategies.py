"""The optimal choice over the whole path and the shortest next move, a block of moves at a time.

Both leave pointers: for each candidate of each record, which candidate of the record before it comes from.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from mathpost.post.min_plus import first_least, least_sums, stay, walk
from mathpost.post.travel import PER_RADIAN, TIE, move_costs, short_way, shortened, sways_off, turns_over

PREFERENCE = 1e-6  # cost of beginning on the other branch than the preferred one
QUANTA = 2.0**40  # costs are whole multiples of 1/QUANTA, so that sums are exact, in whatever order they are taken
OUTSIDE = np.float32(np.inf)


@dataclass
class Moves:
    """Moves to n records, one after the other, in arrays of shape (from candidate, to candidate, n).

    Attributes
    ----------
    over : ndarray of float32
        1 for a move that cannot be made in cut, infinite outside travel, otherwise 0.
    costs : ndarray
        In quanta.
    doubtful : ndarray of bool
        Where `over` is 1 only because nobody has looked: that takes the forward kinematics.
    look : callable
        Takes an array of bool, shape (from, to, n), and returns for each True whether that move is over.
    """

    over: np.ndarray
    costs: np.ndarray
    doubtful: np.ndarray
    look: Callable

    def settle(self, which):
        """Look at doubtful moves; return whether there are some among them that can be made."""
        self.over[which] = found = self.look(which)
        self.doubtful &= ~which
        return not found.all()


def moves(kin, inside, axes, rapid, weights, sway):
    """Return the `Moves` from each record of `inside` to the next, given tool axes (n + 1, 3) and rapid (n,)."""
    start = np.moveaxis(inside.joints[:, :, None, :-1], 0, -1)
    steps = shortened(kin.machine, np.moveaxis(inside.joints[:, None, :, 1:], 0, -1) - start)
    possible = inside.known[:, None, :-1] & inside.known[None, :, 1:]
    in_cut = possible & ~rapid
    over, doubtful = turns_over(steps, sway)
    doubtful &= in_cut
    over = np.where(possible, (over & in_cut) | doubtful, OUTSIDE)
    costs = np.rint(move_costs(kin.machine, steps, weights, tie=TIE) * QUANTA)
    return Moves(over, costs, doubtful, partial(sways_off, kin, start, steps, axes, sway))


def first_moves(machine, inside, weights, start, prefer):
    """Return, as `Moves` from anywhere, what it costs to begin with each candidate of one record."""
    joints = inside.joints[..., 0].T
    if start is None:
        on_the_other = inside.branch[:, 0] != (0 if prefer > 0 else 1)
        costs = PREFERENCE * on_the_other + TIE * PER_RADIAN * np.abs(joints[:, 3:]).sum(axis=1)
    else:
        costs = move_costs(machine, short_way(machine, joints - np.asarray(start, dtype=float)), weights)
    over, costs = np.where(inside.known, np.float32(0), OUTSIDE), np.rint(costs * QUANTA)[:, None]
    shape = len(costs), *costs.shape
    return Moves(np.broadcast_to(over, shape), np.broadcast_to(costs, shape), np.zeros(shape, dtype=bool), None)


class Optimal:
    """Dynamic programming: the way to each candidate with the fewest breaks, and of those the one of least cost.

    Breaks and costs are sums along the path, kept apart so that no cost is lost beside the price of a break.
    """

    def __init__(self):
        self.breaks, self.costs = np.zeros(1, np.float32), np.zeros(1)

    def take(self, block):
        """Go on by some `Moves`. Return where each candidate comes from, (m, n), and at which records it breaks.

        Doubtful moves are breaks at first. Where one would be better than what has been found without, it is looked
        at: if none is left that can be made, the sums are right, because no move that can be made undercuts them
        (Bellman's equation). For most paths nothing needs to be looked at.
        """
        came_from, breaks, costs, attractive = self._solved(block)
        if attractive.any() and block.settle(attractive):
            if block.doubtful.any():
                block.settle(block.doubtful.copy())
            came_from, breaks, costs, _ = self._solved(block)
        last = breaks[:, -1], costs[:, -1]
        self.breaks, self.costs = (values - values.min() for values in last)
        return came_from, breaks.min(axis=0) > 0

    def _solved(self, block):
        """Pointers, and the fewest breaks and the least cost to each candidate; which doubtful moves attract."""
        first = _fitted(self.breaks, len(block.over))
        breaks = least_sums(first, block.over)
        before = _shifted(first, breaks)[:, None]
        kept = (before + block.over == breaks) & (breaks < np.inf)
        excess = np.where(kept, block.costs, np.inf)
        common = excess.min(axis=(0, 1))  # what all ways to a record have in common would only make numbers long
        excess -= common
        first = _fitted(self.costs, len(block.over))
        costs = least_sums(first, excess)
        ways = _shifted(first, costs)[:, None]
        attractive = block.doubtful
        if attractive.any():
            as_cheap = ways + (block.costs - common) <= costs
            attractive = attractive & ((before < breaks) | ((before == breaks) & as_cheap))
        return first_least(ways + excess), breaks, costs, attractive

    def last(self):
        """The candidate of the last record."""
        return int(np.where(self.breaks == 0, self.costs, np.inf).argmin())


class Shortest:
    """The candidate that costs least from the one before, never back on a choice. Methods as in `Optimal`."""

    def __init__(self):
        self.pick = 0

    def take(self, block):
        if block.doubtful.any():
            block.settle(block.doubtful.copy())
        kept = (block.over == block.over.min(axis=1, keepdims=True)) & (block.over < np.inf)
        following = first_least(np.where(kept, block.costs, np.inf).swapaxes(0, 1))
        picks = walk(following[:, ::-1], self.pick)[::-1]
        self.pick = int(picks[-1])
        before, after, record = picks[:-1], picks[1:], np.arange(len(picks) - 1)
        came_from = stay(*following.shape)
        came_from[after, record] = before
        return came_from, block.over[before, after, record] > 0

    def last(self):
        return self.pick


def _fitted(values, count):
    """The first `count` values, infinite where there are no more."""
    return np.pad(values[:count], (0, max(0, count - len(values))), constant_values=np.inf)


def _shifted(first, values):
    """Values (m, n) of the records, at the record before each; `first` before the first one."""
    return np.concatenate([first[:, None], values[:, :-1]], axis=1)
