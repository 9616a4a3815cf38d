"""The modal state of CL data, and the commands to the control between two moves."""

import math
from dataclasses import dataclass, field
from typing import Any


@dataclass(frozen=True)
class Command:
    """A command to the control between two moves; `values` by kind.

    ``"work offset"`` (its number, from 1), ``"tool"`` (number, length in mm or None, number of its length offset or
    None), ``"offset"`` (that number),
    ``"spindle"`` (turns per minute or None, CLW, CCLW or OFF), ``"coolant"`` (FLOOD, MIST, THRU, AIR, TAP or OFF),
    ``"compensation"`` (LEFT, RIGHT or OFF, number of the radius offset), ``"dwell"`` (seconds), ``"stop"``,
    ``"optional stop"``, ``"verbatim"`` (the words of a block); of comments ``"operation"`` (its name, and that of
    its tool, if stated) and ``"cutter"`` (words that describe it, mm).
    """

    kind: str
    values: tuple[Any, ...]
    statement: str  # the words of the CL file
    skip: bool = False  # whether the operator may skip it (OPSKIP)


COMMENTS = ("operation", "cutter")  # kinds of commands that a control is not asked for
Remark = tuple[int, str | Command]  # the number of the record that follows, and the text or command before it


@dataclass
class Modal:
    """The state that words set; "on" alone means as before.

    A feed is in mm per minute or per turn; one per turn follows the spindle.
    """

    speed: float | None = None  # of the spindle, turns per minute
    sense: str = "CLW"  # of rotation when it is on
    turning: bool = False
    coolant: str = "FLOOD"  # the kind that ON switches on
    side: str | None = None  # of the compensation that ON switches on
    feed: float = math.nan  # mm,
    per_turn: bool = False  # per turn instead of per minute
    skip: bool = False
    tool: int = 1
    # In the spindle: number, length, offsets.
    loaded: tuple[int, float | None, int | None, int | None] | None = None
    length_offset: int | None = None  # numbers of the control's offsets; None is that of the tool
    radius_offset: int | None = None
    # Numbers for length and radius that TOOLNO states for tools still to be loaded.
    offsets: dict[int, tuple[int | None, int | None]] = field(default_factory=dict)

    @property
    def lacks_speed(self) -> bool:
        """Whether the feed per minute is not known."""
        return self.per_turn and not self.speed

    @property
    def feed_per_minute(self) -> float:
        if not self.per_turn:
            return self.feed
        return self.feed * self.speed if self.speed else math.nan

    def load(self, tool: int, length_offset: int | None, radius_offset: int | None) -> None:
        """Load a tool with the numbers of its offsets, None where they are not stated."""
        before = self.offsets.get(tool, (None, None))
        self.tool = tool
        self.length_offset = before[0] if length_offset is None else length_offset
        self.radius_offset = before[1] if radius_offset is None else radius_offset

    def radius_number(self) -> int:
        """Return the number of the radius offset: stated, or that of the length, or the tool's."""
        for number in (self.radius_offset, self.length_offset):
            if number is not None:
                return number
        return self.tool
