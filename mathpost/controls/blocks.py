"""The moves of a program, as they are written and read back."""

from dataclasses import dataclass, field

import numpy as np

DECIMALS = 4  # of positions, unless the control's file says so
FEED = " F"  # what stands before a feed


@dataclass(frozen=True)
class Blocks:
    """The moves of a program."""

    words: np.ndarray  # shape (n, 5), mm and degrees, X Y Z and the rotary axes in the order of the machine file
    feeds: np.ndarray  # shape (n,), mm/min, NaN where no feed is stated
    seconds: np.ndarray  # shape (n,), of the block where inverse time is programmed, otherwise NaN
    rapid: np.ndarray  # shape (n,), whether in rapid traverse
    # Shape (n,) or one for all: whether X Y Z are the tool tip in the workpiece (M128, G43.4, TRAORI), not joints.
    tcp: np.ndarray = field(default_factory=lambda: np.array(False))
    remarks: tuple = ()  # (number of the block that follows, a comment or a `path.modal.Command`)

    def __post_init__(self):
        if np.ndim(self.tcp) == 0:
            object.__setattr__(self, "tcp", np.full(len(self.words), self.tcp))

    @property
    def columns(self):
        """The arrays, one entry for each move."""
        return self.words, self.feeds, self.seconds, self.rapid, self.tcp

    def __getitem__(self, rows):
        """The moves of a slice, without remarks."""
        return Blocks(*(column[rows] for column in self.columns))

    @property
    def joints(self):
        """`words` with the rotary angles in radians, shape (n, 5)."""
        joints = np.array(self.words)
        np.deg2rad(joints[:, 3:], out=joints[:, 3:])
        return joints


def axis_word(name):
    """What stands before the number of an axis: names of more than one letter take an equals sign."""
    return f" {name}=" if len(name) > 1 else f" {name}"


def printed(words, decimals=DECIMALS):
    """Round words, in place, to the last digit that stands in a program; a zero has no sign."""
    np.round(words, decimals, out=words)
    words += 0.0
    return words


def rounded(joints, decimals=DECIMALS):
    """Joints (n, 5) in mm and radians as words in mm and degrees, rounded as they will be printed."""
    words = np.array(joints)
    np.rad2deg(words[:, 3:], out=words[:, 3:])
    return printed(words, decimals)


def joined(parts):
    """Return `Blocks` one after the other as one."""
    if len(parts) == 1:
        return parts[0]
    remarks, first = [], 0
    for part in parts:
        remarks += [(first + row, remark) for row, remark in part.remarks]
        first += len(part.words)
    columns = (np.concatenate(column) for column in zip(*(part.columns for part in parts), strict=True))
    return Blocks(*columns, tuple(remarks))
