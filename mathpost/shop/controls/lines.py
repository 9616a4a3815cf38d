"""What a line of a program looks like, and what its words say together."""

import re
from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import cache

import numpy as np

from mathpost.files import NUMBER
from mathpost.path.text import Item, Pattern
from mathpost.shop.controls.blocks import FEED, axis_word


@dataclass
class Line:
    """What the words of one line say."""

    axes: dict[str, tuple[float, str]] = field(default_factory=dict)  # value, "absolute", "incremental" or ""
    # Of words that need another: radius, centre X, cycle depth …
    values: dict[str, float] = field(default_factory=dict)
    feed: float = np.nan
    seconds: float = np.nan
    rapid: bool = False
    curve: str = ""  # the sense of an arc that is said for this line alone
    work_offset: str = ""  # the word that calls it
    statement: tuple[str, str] | None = None  # a meaning that takes the axes of the line, and its word
    tool: bool = False
    turned: bool = False  # whether the rotary axes turn to the plane
    slides: bool = False  # and X Y Z with them, as far as the control likes
    choice: dict[str, str] = field(default_factory=dict)  # and to which position
    defines: bool = False  # whether it defines a cycle, which has further words
    called: bool = False  # whether the cycle that is defined is done where the line goes
    in_machine: bool = False
    gone: tuple[str, tuple[str, ...]] | None = None  # the meaning of a call or a jump, and what it names
    # Text of each word that nothing has used so far, by its name.
    waiting: dict[str, str] = field(default_factory=dict)

    @property
    def text(self) -> str:
        """The statement and the words that wait for it."""
        return " ".join(["" if self.statement is None else self.statement[1], *self.waiting.values()])

    def used(self, *names: str) -> None:
        """Words have been used, those whose names begin so."""
        for name in [each for each in self.waiting if each.startswith(names)]:
            del self.waiting[name]


@dataclass
class Drilling:
    """The drilling cycle that is done at every place until it is switched off: heights, mm."""

    initial: float  # where the tool was when it was switched on
    slow: bool  # whether the tool comes out at its feed
    clearance: float = np.nan
    bottom: float = np.nan
    dwell: float = 0.0  # seconds that the tool waits there


def seconds(meaning: str, text: str) -> float:
    """How long a word waits: where it counts milliseconds, a decimal point makes seconds of them."""
    return float(text) / (1 if meaning == "dwell seconds" or "." in text else 1000)


def tool_name(text: str) -> str:
    """The number of a tool without zeros before it, or its name."""
    return str(int(float(text))) if re.fullmatch(NUMBER, text) else text


def whole_number(text: str, names: Iterable[str]) -> tuple[int, str] | None:
    """Return the line of the first position without a decimal point, and its word."""
    words = rf"^[^(;\n]*?(?<![A-Z])((?:{'|'.join(map(re.escape, names))})[-+]?\d*[1-9]\d*)(?![\d.])"
    found = re.search(words, text, re.MULTILINE | re.IGNORECASE)
    return (text.count("\n", 0, found.start(1)) + 1, found[1]) if found else None


@cache
def plain(number: str | None, begin: str, words_behind: tuple[str, str], names: tuple[str, ...]) -> Pattern:
    """The pattern of a line that moves axes and changes no mode but its feed."""
    start = [] if number is None else [Item(number, "count")]
    start += [Item(f" {begin}")] if begin else []
    rapid, block_time = words_behind
    behind = [Item(f" {rapid}", optional=True)] if rapid else []
    behind += [Item(f" {block_time}", "number", optional=True)] if block_time else []
    axes = (Item(axis_word(name), "number", optional=True) for name in names)
    return Pattern([*start, *axes, *behind, Item(FEED, "number", optional=True)])
