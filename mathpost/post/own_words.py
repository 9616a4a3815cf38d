"""Moves in the control's own words: runs of blocks that become one arc, as the file of the control states them.

Moves are made as if there were straight lines only. Then those that are an arc of the CL data, with rotary axes
that stand still, are replaced by it, if what the control will run from the printed numbers keeps the tolerance.
When the program is read back, `as_run` finds where on the CL path each of the points is that the control runs
through.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from mathpost.controls import curves
from mathpost.controls.blocks import Blocks, Turn, joined, printed
from mathpost.controls.phrases import PLANES
from mathpost.controls.reader import Program
from mathpost.errors import InputError, MathpostError
from mathpost.path.cl import feed_times
from mathpost.path.pieces import Arc
from mathpost.post import proof
from mathpost.post.motion import ON_PART, Motion
from mathpost.post.options import Options
from mathpost.post.steps import Moves, ToolPath

FEWEST = 2  # chords that are worth an arc
WHOLE = 2 * np.pi + 1e-6  # radians, the most of one arc
LARGEST = 99_999.0  # mm, of a centre, the most that controls take


@dataclass(frozen=True)
class Space:
    """The coordinates that X Y Z of rows are in, as a function of the tip in the workpiece."""

    path: ToolPath
    angles: np.ndarray  # of the rotary axes, radians
    tcp: bool

    def point(self, tip: ArrayLike) -> np.ndarray:
        """Return the words of a tip, shape (3,)."""
        return np.asarray(tip) if self.tcp else self.path.kin.close(tip, self.angles)[:3]


def own_words(path: ToolPath, moves: Moves, options: Options) -> Moves:
    """Return moves with the words for arcs, if the control has them and they are wanted."""
    if options.expand or options.control.arcs is None or not path.cl.pieces:
        return moves
    turns: dict[int, tuple[int, Turn]] = {}  # by the last row of each arc, its first, where it starts
    for piece in path.cl.pieces:
        if isinstance(piece, Arc):
            turns |= {last: (first, turn) for first, last, turn in _arcs(path, moves, piece, options)}
    if not turns:
        return moves
    kept = np.ones(len(moves.blocks.words), bool)
    for last, (first, _) in turns.items():
        kept[first + 1 : last] = False
    return replace(
        moves, blocks=_kept(moves.blocks, kept, {last: turn for last, (_, turn) in turns.items()}), kept=kept
    )


def _kept(blocks, kept, turns):
    """Some of the blocks, with their remarks, and the arcs among them."""
    before = np.r_[0, np.cumsum(kept)]
    columns = (column[kept] for column in blocks.columns)
    remarks = tuple((int(before[row]), remark) for row, remark in blocks.remarks)
    return Blocks(*columns, remarks, tuple((int(before[row]), turn) for row, turn in sorted(turns.items())))


def _arcs(path: ToolPath, moves: Moves, piece: Arc, options: Options) -> Iterator[tuple[int, int, Turn]]:
    """Yield the arcs that a piece may be written as: the rows that each starts from and ends at."""
    blocks, motion, arcs = moves.blocks, moves.motion, options.control.arcs
    if arcs is None:
        return
    first, last = np.searchsorted(motion.place, [piece.first, piece.last], side="right") - 1
    if first < 0 or motion.place[first] != piece.first or motion.place[last] != piece.last:
        return
    rows = slice(first, last + 1)
    plain = np.isnan(blocks.seconds[first + 1 : last + 1]) & ~blocks.rapid[first + 1 : last + 1]
    still = not np.ptp(blocks.words[rows, 3:], axis=0).any() and (blocks.tcp[rows] == blocks.tcp[first]).all()
    if not (still and plain.all() and (motion.kind[rows] == ON_PART).all()):
        return
    space = Space(path, blocks.joints[first, 3:], bool(blocks.tcp[first]))
    centre = space.point(piece.centre)
    axis = space.point(np.add(piece.centre, piece.axis)) - centre
    square = int(np.abs(axis).argmax())
    plane = PLANES[2 - square]
    if plane not in arcs.planes or np.abs(centre).max() > LARGEST:
        return
    clockwise = bool(axis[square] < 0)
    around = np.delete(blocks.words[rows, :3] - centre, square, axis=1)
    radius = np.linalg.norm(around, axis=1)
    step = 2 * np.arcsin(np.minimum(np.linalg.norm(around[1] - around[0]) / (2 * radius[0]), 1))
    step = _angle(around[0], around[-1], square, clockwise, step * (last - first)) / (last - first)
    sagitta = radius[0] * (1 - np.cos(step / 2))
    room = options.tolerance - sagitta - curves.CHORD - 10.0**-options.control.decimals
    compensated = [(row, remark) for row, remark in blocks.remarks if getattr(remark, "kind", "") == "compensation"]
    for start, end in _between_remarks(blocks, first, last, {row for row, _ in compensated}):
        most = end - start if arcs.helix else int(WHOLE / step)  # rows of one arc
        edges = np.linspace(start, end, -(-(end - start) // most) + 1)
        for begin, stop in pairwise(edges.round().astype(int).tolist()):
            if stop - begin < FEWEST:
                continue
            turn = _turn(blocks.words[begin : stop + 1, :3], centre, square, clockwise, step, room, options)
            if turn is not None and (plane == PLANES[0] or not _compensates(compensated, begin)):
                yield begin, stop, turn


def _angle(start, end, square, clockwise, about):
    """The angle from one vector in a plane to another, in the sense of the arc: the one nearest to `about`."""
    across = (start[0] * end[1] - start[1] * end[0]) * (-1 if clockwise else 1)
    across *= -1 if square == 1 else 1  # X and Z, in this order, are left-handed seen from Y
    angle = np.arctan2(across, start @ end)
    return angle + 2 * np.pi * np.round((about - angle) / (2 * np.pi))


def _between_remarks(blocks, first, last, compensated):
    """Pairs of rows between which nothing is said to the control; a compensation begins on a straight line."""
    edges = {first, last}
    for row, _ in blocks.remarks:
        if first < row <= last:
            edges |= {row - 1, row} if row in compensated else {row - 1}
    if first + 1 in compensated:
        edges.add(first + 1)
    return pairwise(sorted(edges))


def _compensates(switched, row):
    """Whether the control compensates a radius at a row, which it does in the plane XY."""
    sides = [remark.values[0] for at, remark in switched if at <= row + 1]
    return bool(sides) and sides[-1] != "OFF"


def _turn(words, centre, square, clockwise, step, room, options):
    """The arc through some words, or None if what the control would run from the printed numbers is off them."""
    control, plane = options.control, PLANES[2 - square]
    start, end = words[0], words[-1]
    centre = np.where(np.arange(3) == square, start[square], centre)
    offset = printed(centre - start, control.decimals)
    centre = start + offset if control.arcs.centre else printed(centre, control.decimals)
    in_plane = np.arange(3) != square
    radii = [np.linalg.norm((at - centre)[in_plane]) for at in (start, end)]
    if abs(radii[0] - radii[1]) > control.arcs.ends:
        return None
    swept = step * (len(words) - 1)
    try:
        points = curves.arc(start, end, centre, f"plane {plane}", clockwise, int(np.ceil(swept / WHOLE)) - 1)
    except InputError:
        return None
    parts = np.arange(len(words)) / (len(words) - 1)
    run = np.column_stack([np.interp(parts, np.linspace(0, 1, len(points) + 1), np.r_[at, column])
                           for at, column in zip(start, points.T, strict=True)])  # fmt: skip
    if np.linalg.norm(run - words, axis=1).max() > room:
        return None
    sweep = float(np.degrees(swept)) * (-1 if clockwise else 1)
    return Turn(plane, clockwise, centre, offset, sweep, bool(start[square] != end[square]))


def parts_of(program: Program, moves: list[Moves]) -> list[slice]:
    """Return which rows of a program, read back, belong to each of several tools' moves."""
    starts = np.flatnonzero(np.r_[True, np.diff(program.lines) != 0]).tolist()
    edges = np.cumsum([0, *(len(each.blocks.words) for each in moves)])
    if edges[-1] != len(starts):
        raise MathpostError(f"{edges[-1]} blocks were written and {len(starts)} read back")
    rows = [*starts, len(program.lines)]
    return [slice(rows[first], rows[stop]) for first, stop in pairwise(edges)]


def as_run(path: ToolPath, moves: Moves, program: Program, rows: slice) -> tuple[Moves, Blocks]:
    """Return moves at the points that the control runs through, and these as blocks, with the records between them.

    `rows` are those of the program, read back, that belong to the moves. Within an arc its points turn by equal
    angles, as the records do.
    """
    blocks, lines, motion = program.blocks[rows], program.lines[rows], moves.motion
    if moves.kept is None:
        return moves, blocks
    starts = np.r_[np.flatnonzero(np.r_[True, np.diff(lines) != 0]), len(lines)]
    kept = np.flatnonzero(moves.kept)
    parts, places, kinds, done = [], [], [], 0
    for row in [*(row for row, _ in moves.blocks.turns), len(kept)]:
        straight = slice(done, row)
        parts.append(blocks[starts[min(done, len(kept))] : starts[row]])
        places.append(motion.place[kept[straight]])
        kinds.append(motion.kind[kept[straight]])
        if row < len(kept):
            part, place = _with_records(blocks, *starts[[row, row + 1]], *motion.place[kept[[row - 1, row]]])
            parts.append(part)
            places.append(place)
            kinds.append(np.full(len(place), motion.kind[kept[row]]))
        done = row + 1
    run = joined(parts)
    place = np.concatenate(places)
    found = Motion(proof.joints_of(path.kin, run), place, np.concatenate(kinds))
    tip, _ = path.cl.at(place)
    by_feed = np.where(found.at_feed(path.cl), feed_times(tip, path.cl.feeds[found.record[1:]]), np.nan)
    return replace(moves, motion=found, by_feed=by_feed), run


def _with_records(blocks, begin, stop, before, after):
    """The points of an arc, and the records between them, at their places on the CL path."""
    read = before + np.arange(stop - begin + 1) / (stop - begin) * (after - before)
    read[-1] = after
    inside = np.arange(np.floor(before) + 1, after)
    place = np.unique(np.r_[read[1:], inside])
    words = np.column_stack([np.interp(place, read, column) for column in blocks.words[begin - 1 : stop].T])
    others = (np.full(len(place), column[begin]) for column in blocks.columns[1:])
    return Blocks(words, *others), place
