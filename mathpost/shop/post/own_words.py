"""Moves in the control's own words: arcs, drilling cycles, tilted planes, as the file of the control states them.

Moves are made as if there were straight lines only. Then runs of them are replaced, if what the control will run
from the printed numbers keeps the tolerance. When the program is read back, `as_run` finds where on the CL path
each of the points is that the control runs through.
"""

from dataclasses import replace

import numpy as np

from mathpost.errors import MathpostError
from mathpost.path.motion import Motion
from mathpost.path.pieces import Arc
from mathpost.shop.controls.blocks import Blocks, joined, rounded
from mathpost.shop.controls.reader import Program
from mathpost.shop.post import proof
from mathpost.shop.post.arcs import arcs
from mathpost.shop.post.draft import Draft
from mathpost.shop.post.holes import holes
from mathpost.shop.post.options import Options
from mathpost.shop.post.steps import Moves
from mathpost.shop.post.tilted import standing, tilted
from mathpost.shop.post.tool_path import ToolPath, what_the_control_holds


def own_words(path: ToolPath, moves: Moves, options: Options) -> Moves:
    """Return moves in the words that the control has, if they are wanted."""
    if options.expand or not (path.cl.pieces or any(standing(path, moves))):
        return moves
    draft, moves = _with_holes(path, moves, options)
    if any(frame is not None for frame in draft.frames):
        said = what_the_control_holds(path, options)
        rest = [remark for remark in draft.said.get(0, []) if remark not in said]
        draft.said[0] = [*what_the_control_holds(path, options, planes=True), *rest]
    for piece in path.cl.pieces:
        if isinstance(piece, Arc):
            for first, last, turn in arcs(draft, piece):
                draft.turns[last] = turn
                draft.kept[first + 1 : last] = False
                draft.run[first + 1 : last] = False
    if draft.kept.all() and sum(map(len, draft.said.values())) == len(moves.blocks.remarks):
        return moves
    ends = np.flatnonzero(draft.run)
    return replace(
        moves, blocks=draft.blocks(), run=ends, turns=np.flatnonzero(np.isin(ends, list(draft.turns))),
        pecks=np.array(draft.pecks, int), strokes=tuple(draft.strokes), cycles=len(draft.drilled),
    )  # fmt: skip


def _with_holes(path: ToolPath, moves: Moves, options: Options) -> tuple[Draft, Moves]:
    """Return a draft with planes and cycles, and the moves that it is made of.

    Controls take no drilling cycles while they keep the tip: in an operation whose rotary axes stand still TCP is
    left behind its first move, if holes of it become cycles then.
    """
    tcp = moves.blocks.tcp
    left = [
        (first, stop) for first, stop, drilled in standing(path, moves) if drilled and tcp[first + 1 : stop].any()
    ]
    while True:
        without = _without_tcp(moves, left, options)
        draft = Draft(path, without, options)
        tilted(draft)
        holes(draft)
        worth = [(first, stop) for first, stop in left if any(first < row < stop for row in draft.drilled)]
        if worth == left:
            return draft, without
        left = worth


def _without_tcp(moves: Moves, runs: list[tuple[int, int]], options: Options) -> Moves:
    """Return moves whose words are the joints, and no tip is kept, behind the first row of some runs."""
    if not runs:
        return moves
    words, tcp = moves.blocks.words.copy(), moves.blocks.tcp.copy()
    for first, stop in runs:
        rows = slice(first + 1, stop)
        words[rows, :3] = rounded(moves.motion.joints[rows], options.control.decimals)[:, :3]
        tcp[rows] = False
    return replace(moves, blocks=replace(moves.blocks, words=words, tcp=tcp))


def as_run(path: ToolPath, moves: Moves, program: Program, first: int) -> tuple[Moves, int]:
    """Return moves at the points that the control runs through, as they are read back, and how far that is.

    `first` is the row of the program, read back, that belongs to the first of the moves. Within an arc its points
    turn by equal angles, as the records do, which are put between them.
    """
    blocks, lines, motion = program.blocks, program.lines, moves.motion
    if path.shift.any():
        words = blocks.words.copy()
        words[:, :3] -= path.shift  # they count from the origin of the first part
        blocks = replace(blocks, words=words)
    if moves.run is None:
        stop = first + len(moves.blocks.words)
        return replace(moves, blocks=blocks[first:stop]), stop
    parts, places, kinds, within, done, row = [], [], [], [], 0, first
    for turn in [*moves.turns.tolist(), len(moves.run)]:
        straight = moves.run[done:turn]
        parts.append(blocks[row : row + len(straight)])
        places.append(motion.place[straight])
        kinds.append(motion.kind[straight])
        within.append(np.zeros(len(straight), bool))
        row += len(straight)
        if turn < len(moves.run) and row < len(lines):
            stop = int(np.searchsorted(lines, lines[row], side="right"))
            part, place = _with_records(path, blocks, row, stop, *motion.place[moves.run[[turn - 1, turn]]])
            parts.append(part)
            places.append(place)
            kinds.append(np.full(len(place), motion.kind[moves.run[turn]]))
            within.append(np.arange(len(place)) < len(place) - 1)
            row = stop
        done = turn + 1
    run, place = joined(parts), np.concatenate(places)
    if len(run.words) != len(place):
        raise MathpostError(f"{len(place)} ends of moves were written and {len(run.words)} read back")
    found = Motion(proof.joints_of(path.kin, run), place, np.concatenate(kinds))
    return replace(moves, motion=found, blocks=run, smooth=np.concatenate(within)), row


def _with_records(
    path: ToolPath, blocks: Blocks, begin: int, stop: int, before: float, after: float
) -> tuple[Blocks, np.ndarray]:
    """The points of an arc, and the records between them, at their places on the CL path."""
    read = before + np.arange(stop - begin + 1) / (stop - begin) * (after - before)
    read[-1] = after
    inside = np.arange(np.floor(before) + 1, after)
    place = np.unique(np.r_[read[1:], inside])
    around = np.array(blocks.words[begin - 1 : stop])
    if blocks.tcp[begin] and not blocks.tcp[begin - 1]:  # it starts where the coordinates begin to be the tip's
        around[0, :3] = path.kin.forward(blocks[begin - 1 : begin].joints)[0][0]
    words = np.column_stack([np.interp(place, read, column) for column in around.T])
    feeds, seconds, rapid, tcp = (np.full(len(place), column[begin]) for column in blocks.columns[1:])
    return Blocks(words, feeds, seconds, rapid, tcp), place
