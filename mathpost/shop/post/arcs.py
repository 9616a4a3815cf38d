"""Arcs of CL data as one block each, where a control can run them from the printed numbers within the tolerance."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from mathpost.errors import InputError
from mathpost.path.cl import commands
from mathpost.path.motion import ON_PART
from mathpost.path.pieces import Arc
from mathpost.shop.controls import arcs_and_holes
from mathpost.shop.controls.blocks import PLANES, Blocks, Turn, printed
from mathpost.shop.controls.phrases import Arcs
from mathpost.shop.post.draft import Draft

if TYPE_CHECKING:
    from mathpost.path.modal import Command
    from mathpost.shop.controls.control import Control

FEWEST = 2  # chords that are worth an arc
WHOLE = 2 * np.pi + 1e-6  # radians, the most of one arc
LARGEST = 99_999.0  # mm, of a centre, the most that controls take


def arcs(draft: Draft, piece: Arc) -> Iterator[tuple[int, int, Turn]]:
    """Yield the arcs that a piece may be written as: the rows that each starts from and ends at."""
    blocks, motion, options = draft.moves.blocks, draft.moves.motion, draft.options
    known = options.control.arcs
    if known is None:
        return
    first, last = np.searchsorted(motion.place, [piece.first, piece.last], side="right") - 1
    if first < 0 or motion.place[first] != piece.first or motion.place[last] != piece.last:
        return
    rows = slice(first, last + 1)
    plain = np.isnan(blocks.seconds[first + 1 : last + 1]) & ~blocks.rapid[first + 1 : last + 1]
    alike = draft.still(first, last) and (blocks.tcp[rows] == blocks.tcp[first]).all()
    if not (alike and plain.all() and (motion.kind[rows] == ON_PART).all()):
        return
    words = np.r_[draft.starts[first : first + 1], draft.words[first + 1 : last + 1, :3]]
    centre = draft.point(last, piece.centre)
    axis = draft.point(last, np.add(piece.centre, piece.axis)) - centre
    square = int(np.abs(axis).argmax())
    plane = _plane(square)
    if plane not in known.planes or np.abs(centre).max() > LARGEST:
        return
    clockwise = bool(axis[square] < 0)
    around = np.delete(words - centre, square, axis=1)
    radius = np.linalg.norm(around, axis=1)
    step = 2 * np.arcsin(np.minimum(np.linalg.norm(around[1] - around[0]) / (2 * radius[0]), 1))
    step = _angle(around[0], around[-1], square, clockwise, step * (last - first)) / (last - first)
    sagitta = radius[0] * (1 - np.cos(step / 2))
    room = (
        options.tolerance * options.share(draft.path.kin.machine)
        - sagitta
        - arcs_and_holes.CHORD
        - 10.0**-options.control.decimals
    )
    compensated = commands(blocks.remarks, "compensation")
    for start, end in _between_remarks(blocks, first, last, {row for row, _ in compensated}):
        most = end - start if known.helix else int(WHOLE / step)  # rows of one arc
        edges = np.linspace(start, end, -(-(end - start) // most) + 1)
        for begin, stop in pairwise(edges.round().astype(int).tolist()):
            if stop - begin < FEWEST:
                continue
            turn = _turn(
                words[begin - first : stop + 1 - first],
                centre,
                square,
                clockwise,
                step,
                room,
                known,
                options.control,
            )
            if turn is not None and (plane == "XY" or not _compensates(compensated, begin)):
                yield begin, stop, turn


def _plane(square: int) -> str:
    return next(name for name, axes in PLANES.items() if axes[2] == square)


def _angle(start: np.ndarray, end: np.ndarray, square: int, clockwise: bool, about: float) -> float:
    """The angle from one vector in a plane to another, in the sense of the arc: the one nearest to `about`."""
    across = (start[0] * end[1] - start[1] * end[0]) * (-1 if clockwise else 1)
    across *= -1 if square == 1 else 1  # X and Z, in this order, are left-handed seen from Y
    angle = np.arctan2(across, start @ end)
    return angle + 2 * np.pi * np.round((about - angle) / (2 * np.pi))


def _between_remarks(blocks: Blocks, first: int, last: int, compensated: set[int]) -> Iterator[tuple[int, int]]:
    """Pairs of rows between which nothing is said to the control; a compensation begins on a straight line."""
    edges = {first, last}
    for row, _ in blocks.remarks:
        if first < row <= last:
            edges |= {row - 1, row} if row in compensated else {row - 1}
    if first + 1 in compensated:
        edges.add(first + 1)
    return pairwise(sorted(edges))


def _compensates(switched: list[tuple[int, Command]], row: int) -> bool:
    """Whether the control compensates a radius at a row, which it does in the plane XY."""
    sides = [remark.values[0] for at, remark in switched if at <= row + 1]
    return bool(sides) and sides[-1] != "OFF"


def _turn(
    words: np.ndarray, centre: np.ndarray, square: int, clockwise: bool, step: float, room: float, known: Arcs,
    control: Control,
) -> Turn | None:  # fmt: skip
    """The arc through some words, or None if what the control would run from the printed numbers is off them."""
    plane = _plane(square)
    start, end = words[0], words[-1]
    centre = np.where(np.arange(3) == square, start[square], centre)
    offset = printed(centre - start, control.decimals)
    centre = start + offset if known.centre else printed(centre, control.decimals)
    in_plane = np.arange(3) != square
    radii = [np.linalg.norm((at - centre)[in_plane]) for at in (start, end)]
    if abs(radii[0] - radii[1]) > known.ends:
        return None
    swept = step * (len(words) - 1)
    try:
        points = arcs_and_holes.arc(start, end, centre, plane, clockwise, int(np.ceil(swept / WHOLE)) - 1)
    except InputError:
        return None
    parts = np.arange(len(words)) / (len(words) - 1)
    run = np.column_stack([np.interp(parts, np.linspace(0, 1, len(points) + 1), np.r_[at, column])
                           for at, column in zip(start, points.T, strict=True)])  # fmt: skip
    if np.linalg.norm(run - words, axis=1).max() > room:
        return None
    sweep = float(np.degrees(swept)) * (-1 if clockwise else 1)
    return Turn(plane, clockwise, centre, offset, sweep, bool(start[square] != end[square]))
