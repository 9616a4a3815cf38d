"""The moves of a program, as they are written and read back."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from mathpost.path.modal import Remark

DECIMALS = 4  # of positions, unless the control's file says so
FEED = " F"  # precedes a feed
PLANES = {"XY": (0, 1, 2), "ZX": (2, 0, 1), "YZ": (1, 2, 0)}  # of arcs: two axes, and the one square to them


@dataclass(frozen=True)
class Turn:
    """What a block does that is an arc or a helix: how it comes to its end."""

    plane: str  # one of `PLANES`
    clockwise: bool
    centre: np.ndarray  # shape (3,), mm, in the coordinates of the words
    offset: np.ndarray  # shape (3,), mm, of the centre from the start
    sweep: float  # degrees, positive counterclockwise
    helix: bool  # whether it rises


@dataclass(frozen=True)
class Blocks:
    """The moves of a program."""

    words: np.ndarray  # shape (n, 5), mm and degrees, X Y Z and the rotary axes in the order of the machine file
    feeds: np.ndarray  # shape (n,), mm/min, NaN where no feed is stated
    seconds: np.ndarray  # shape (n,), of the block where inverse time is programmed, otherwise NaN
    rapid: np.ndarray  # shape (n,), whether in rapid traverse
    # Shape (n,) or one for all: whether X Y Z are the tool tip in the workpiece (M128, G43.4, TRAORI), not joints.
    tcp: np.ndarray = field(default_factory=lambda: np.array(False))
    remarks: tuple[Remark, ...] = ()  # each with the number of the block that follows
    turns: tuple[tuple[int, Turn], ...] = ()  # (number of a block that is an arc, and what it is)

    def __post_init__(self) -> None:
        if np.ndim(self.tcp) == 0:
            object.__setattr__(self, "tcp", np.full(len(self.words), self.tcp))

    @property
    def columns(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """The arrays, one entry for each move."""
        return self.words, self.feeds, self.seconds, self.rapid, self.tcp

    def __getitem__(self, rows: slice | np.ndarray) -> Blocks:
        """The moves of a slice, without remarks and turns."""
        words, feeds, seconds, rapid, tcp = (column[rows] for column in self.columns)
        return Blocks(words, feeds, seconds, rapid, tcp)

    @property
    def joints(self) -> np.ndarray:
        """`words` with the rotary angles in radians, shape (n, 5)."""
        joints = np.array(self.words)
        np.deg2rad(joints[:, 3:], out=joints[:, 3:])
        return joints


def axis_word(name: str) -> str:
    """The text before the number of an axis: names of more than one letter take an equals sign."""
    return f" {name}=" if len(name) > 1 else f" {name}"


def printed(words: np.ndarray, decimals: int = DECIMALS) -> np.ndarray:
    """Round words, in place, to the last digit that is printed in a program; a zero has no sign."""
    np.round(words, decimals, out=words)
    words += 0.0
    return words


def rounded(joints: np.ndarray, decimals: int = DECIMALS) -> np.ndarray:
    """Joints (n, 5) in mm and radians as words in mm and degrees, rounded as they will be printed."""
    words = np.array(joints)
    np.rad2deg(words[:, 3:], out=words[:, 3:])
    return printed(words, decimals)


def joined(parts: list[Blocks]) -> Blocks:
    """Return `Blocks` one after the other as one."""
    if len(parts) == 1:
        return parts[0]
    remarks: list[Remark] = []
    turns: list[tuple[int, Turn]] = []
    first = 0
    for part in parts:
        remarks += [(first + row, remark) for row, remark in part.remarks]
        turns += [(first + row, turn) for row, turn in part.turns]
        first += len(part.words)
    columns = zip(*(part.columns for part in parts), strict=True)
    words, feeds, seconds, rapid, tcp = (np.concatenate(column) for column in columns)
    return Blocks(words, feeds, seconds, rapid, tcp, tuple(remarks), tuple(turns))
