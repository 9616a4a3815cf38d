"""The blocks of one tool while they are put into the control's own words."""

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from mathpost.frame import Frame
from mathpost.path.modal import Command
from mathpost.shop.controls.blocks import Blocks, Turn
from mathpost.shop.post.options import Options
from mathpost.shop.post.steps import Moves, Strokes
from mathpost.shop.post.tool_path import ToolPath


class Draft:
    """The n blocks as they will be written: X Y Z in other coordinates, some merged into one, with text between.

    Attributes
    ----------
    words : ndarray, shape (n, 5)
        Words of the blocks; in a tilted plane they are in its coordinates.
    starts : ndarray, shape (n, 3)
        X Y Z of each block in the coordinates of the one after it.
    frames : list of Frame or None
        The tilted plane that each block is in.
    kept, run : ndarray, shape (n,)
        Whether each is written as a block, and whether the control ends a move there.
    turns : dict
        The arcs, by the last row of each.
    said : dict
        The text and commands between blocks, by the row that follows.
    drilled : list of int
        The last row of each hole that is a cycle of the control.
    pecks : list of int
        Records that the control replaces by pecks of its own.
    strokes : list of Strokes
        These pecks.
    """

    def __init__(self, path: ToolPath, moves: Moves, options: Options) -> None:
        self.path, self.moves, self.options = path, moves, options
        count = len(moves.blocks.words)
        self.words, self.starts = moves.blocks.words.copy(), moves.blocks.words[:, :3].copy()
        self.frames: list[Frame | None] = [None] * count
        self.kept, self.run = np.ones(count, bool), np.ones(count, bool)
        self.turns: dict[int, Turn] = {}
        self.drilled: list[int] = []
        self.pecks: list[int] = []
        self.strokes: list[Strokes] = []
        self.said: dict[int, list[str | Command]] = {}
        for row, remark in moves.blocks.remarks:
            self.said.setdefault(row, []).append(remark)

    def still(self, first: int, last: int) -> bool:
        """Whether the rotary axes do not move from one row to another, and all moves between are in one plane."""
        same = all(frame is self.frames[last] for frame in self.frames[first + 1 : last])
        return same and not np.ptp(self.moves.blocks.words[first : last + 1, 3:], axis=0).any()

    def point(self, row: int, tip: ArrayLike) -> np.ndarray:
        """Return X Y Z, shape (3,), that a row has for a tip in the workpiece."""
        frame = self.frames[row]
        if frame is not None:
            return frame.inverse().point(np.asarray(tip))
        if self.moves.blocks.tcp[row]:
            return np.asarray(tip)
        return self.path.kin.close(tip, np.deg2rad(self.moves.blocks.words[row, 3:]))[:3]

    def say(self, row: int, command: Command, *, first: bool = False) -> None:
        """Give the control a command before a row, ahead of or after the commands already there."""
        there = self.said.setdefault(row, [])
        there.insert(0 if first else len(there), command)

    def blocks(self) -> Blocks:
        """Return the blocks as they are to be written."""
        before, blocks = np.r_[0, np.cumsum(self.kept)], self.moves.blocks
        remarks = tuple((int(before[row]), remark) for row in sorted(self.said) for remark in self.said[row])
        turns = tuple((int(before[row]), self.turns[row]) for row in sorted(self.turns))
        return replace(blocks[self.kept], words=self.words[self.kept], remarks=remarks, turns=turns)
