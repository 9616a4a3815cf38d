"""How fast a program, whoever wrote it, goes along its CL path: rapid traverse where that cuts, and other feeds."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mathpost.path.cl import CLData
from mathpost.shop.controls.blocks import Blocks
from mathpost.shop.post.along import SAME_PLACE, Reached
from mathpost.shop.post.time_law import block_times

SAME_FEED = 0.05  # of the feed
SHORT = 3  # times the tolerance of the tip: what is shorter may be where a block is placed
SLACK = 0.002  # s, that the digits of a block's time leave open


@dataclass(frozen=True)
class Pace:
    """Where a program is faster or slower than its CL data; numbers of blocks and of records, from 0."""

    rapid: tuple[tuple[int, int], ...]  # the first block of each line in rapid traverse where the CL data cut
    slow: tuple[tuple[int, int], ...]  # and at a feed where they are in rapid traverse
    feeds: tuple[tuple[int, int, float, float], ...]  # and with another feed: mm/min as programmed, as stated
    compared: int  # moves whose feed was compared


def pace(
    moves: Reached, blocks: Blocks, lines: np.ndarray, tips: np.ndarray, cl: CLData, place: np.ndarray, tip: float
) -> Pace:
    """Compare the moves of a program between `place`, shape (m,), along its CL path, for its first m blocks.

    A feed agrees if one of the ways in which controls and posts count it does: along the way of the tip, of X Y Z,
    or of all axes in mm and degrees. A time of a block may be longer where the slowest axis needs more.
    """
    stated = ~cl.rapid & (~np.isnan(cl.feeds) | cl.rapid.any())
    lengths = np.linalg.norm(np.diff(cl.points, axis=0), axis=1)
    cut = _between(np.where(stated[1:], lengths, 0), place)
    rapid = _between(np.where(cl.rapid[1:], lengths, 0), place)
    at_feed = _between(np.where(cl.rapid[1:] | np.isnan(cl.feeds[1:]), 0, lengths), place)
    seconds = _between(np.where(cl.rapid[1:], 0, np.nan_to_num(60 * lengths / cl.feeds[1:])), place)
    goes_on = np.diff(place) > SAME_PLACE
    programmed = blocks[1 : len(place)]
    least = SHORT * tip
    fast = goes_on & programmed.rapid & (cut > least)
    slow = goes_on & ~programmed.rapid & (rapid > least) & (cut <= least)
    with np.errstate(invalid="ignore", divide="ignore"):
        wanted = 60 * at_feed / seconds
        fed = goes_on & ~programmed.rapid & (at_feed > least) & (at_feed == cut)
        fed &= ~(np.isnan(programmed.feeds) & np.isnan(programmed.seconds))
        found, other = _other(moves, programmed, tips[: len(place)], at_feed, wanted)
    record = np.ceil(place[1:] - SAME_PLACE)
    feeds = [
        (*pair, float(found[pair[0] - 1]), float(wanted[pair[0] - 1])) for pair in _rows(fed & other, record, lines)
    ]
    return Pace(tuple(_rows(fast, record, lines)), tuple(_rows(slow, record, lines)), tuple(feeds), int(fed.sum()))


def _between(lengths: np.ndarray, place: np.ndarray) -> np.ndarray:
    """How much of what the segments of a path have is between places that follow each other; NaN off the path."""
    return np.diff(np.interp(place, np.arange(len(lengths) + 1), np.r_[0.0, np.cumsum(lengths)]))


def _rows(wrong: np.ndarray, record: np.ndarray, lines: np.ndarray) -> tuple[tuple[int, int], ...]:
    """The blocks of moves that are wrong, the first of each line, and the records that they lead to."""
    blocks = 1 + np.flatnonzero(wrong)
    _, first = np.unique(lines[blocks], return_index=True)
    return tuple((int(block), int(record[block - 1])) for block in blocks[np.sort(first)])


def _other(
    moves: Reached, programmed: Blocks, tips: np.ndarray, length: np.ndarray, wanted: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """The feed of the tip, mm/min, on each move as programmed, and whether it is another than is wanted."""
    count = len(length)
    timed = ~np.isnan(programmed.seconds)
    joints = moves.joints[: count + 1]
    needed = block_times(moves.kin[0].machine, joints, tips, wanted, np.ones(count, bool))
    soon = programmed.seconds < (1 - SAME_FEED) * 60 * length / wanted - SLACK
    late = programmed.seconds > (1 + SAME_FEED) * needed + SLACK
    steps = np.diff(joints, axis=0) * moves.kin[0].machine.units
    ways = [length, np.linalg.norm(steps[:, :3], axis=1), np.linalg.norm(steps, axis=1)]
    same = [np.abs(programmed.feeds * length / way - wanted) <= SAME_FEED * wanted for way in ways]
    found = np.where(timed, 60 * length / programmed.seconds, programmed.feeds)
    return found, np.where(timed, soon | late, ~np.logical_or.reduce(same))
