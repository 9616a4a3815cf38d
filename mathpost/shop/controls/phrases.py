"""Words for more than a straight move, as a control's file states them: arcs, drilling cycles, tilted planes.

What a file does not state, its control is not asked for: programs have straight moves then.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

from mathpost.files import TomlTable, a_number, one_of, only_if, some_text
from mathpost.shop.controls.blocks import PLANES
from mathpost.shop.controls.keys import LINES, TRUTH, WORD, WORDS, filled, key, keys_of, several, whole

# Numbers of a cycle, mm, seconds, mm/min and turns a minute: the coordinates of the surface, the bottom, of where
# the feed begins and where the tool leaves, and how far these are from the surface; how deep a peck goes.
CYCLE_FIELDS = ("surface", "bottom", "clearance", "leave", "depth", "above", "retract", "step", "dwell",
                "milliseconds", "feed", "pitch", "speed")  # fmt: skip
KINDS = ("drill", "dwell", "deep", "chips", "bore", "ream", "tap", "tap left")
PLANES_OF = only_if(lambda words: {*words} <= {*PLANES}, WORDS[0]), "a table with a word for XY, ZX or YZ"
DISTANCE = only_if(lambda value: value >= 0, a_number), "mm, not negative"
item = partial(key, "")  # of a table that is read alone
ABOVE_0 = only_if(lambda value: value > 0, whole), "a whole number from 1"


def _above(value: float | str) -> float | str:
    """A distance in mm, not negative, or the word "clearance"."""
    return value if value == "clearance" else DISTANCE[0](value)


@dataclass(frozen=True)
class Arcs:
    """How an arc or a helix is written for a control."""

    # Those that an arc may lie in, some of `PLANES`, and the word that selects each.
    planes: Mapping[str, str] = item(*PLANES_OF)
    clockwise: str = item(some_text, "a word")  # seen from the end of the axis square to the plane
    counterclockwise: str = item(some_text, "a word")
    # What such a block begins with, where moves begin with a word; the sense then comes last.
    begin: str = item(*WORD, "")
    # Words of the centre, counted from the start of the arc, of X, Y and Z;
    centre: tuple[str, ...] = item(*several(3), ())
    pole: str = item(*WORD, "")  # or the word of a line before it that has the centre's coordinates
    # What a helix begins with, and the word of its angle, if it has no end point.
    helix: tuple[str, ...] = item(*several(2), ())
    # mm, by which its distance from the centre may differ between both ends.
    ends: float = item(only_if(lambda value: value > 0, a_number), "mm above 0")


@dataclass(frozen=True)
class Cycles:
    """How drilling cycles are written for a control, by `KINDS`; lines with the fields of `CYCLE_FIELDS`."""

    kinds: dict[str, tuple[str, ...]]  # what begins a row of holes, at the position of its first one,
    again: tuple[str, ...] = item(*LINES, ())  # what follows the position of each further hole,
    off: tuple[str, ...] = item(*LINES, ())  # and of the last
    # A word that makes the last of these lines hold for each position that follows, or nothing.
    modal: str = item(*WORD, "")
    # How the control pecks: from where the first depth counts, "surface", "clearance" or nothing, if not known;
    # how far above the depth before the feed begins again, mm or "clearance"; how far chip breaking goes back, mm.
    pecks_from: str = item(*one_of("surface", "clearance"), "")
    again_above: float | str = item(_above, 'mm, not negative, or "clearance"', 0.0)
    back: float = item(*DISTANCE, 0.0)

    def pecks(self, kind: str, values: dict[str, float]) -> tuple[list[float], list[bool]]:
        """Return the heights between clearance and bottom that the tool goes to, and whether in rapid traverse.

        `values` are the numbers of the cycle, see `CYCLE_FIELDS`; `kind` is "deep" or "chips".
        """
        heights: list[float] = []
        rapid: list[bool] = []
        top, reached = values["clearance"], values[self.pecks_from]
        above = values["above"] if isinstance(self.again_above, str) else self.again_above
        while values["step"] > 0 and reached - values["step"] > values["bottom"] + 1e-9:
            reached -= values["step"]
            out = [top, min(reached + above, top)] if kind == "deep" else [min(reached + self.back, top)]
            heights += [reached, *out]
            rapid += [False, *[True] * len(out)]
        return heights, rapid


@dataclass(frozen=True)
class Tilted:
    """How a tilted plane is written for a control whose rotary axes are already in position."""

    notation: str  # of `mathpost.shop.plane.tilted_plane.NOTATIONS`
    positioning: str = item(*WORD, "")  # words behind it
    swivel_data: str = item(*WORD, "TC1")  # the name of the machine in it, where it has one
    on: tuple[str, ...] = item(*LINES, ())  # lines behind that one,
    off: tuple[str, ...] = item(*LINES)  # and those that end it


@dataclass(frozen=True)
class WorkOffsets:
    """How a work offset is written for a control, by its number, from 1."""

    words: tuple[str, ...] = item(*LINES, ())  # of the first ones,
    # and of those behind them, with {0} in it; or nothing
    further: str = item(only_if(lambda line: not line or "{0}" in line), "a line with {0} in it", "")
    counted_from: int = item(*ABOVE_0, 1)  # what {0} is in the first of these
    most: int = item(*ABOVE_0, 0)  # how many there are, by default as many as words
    # Whether it has to be selected anew behind words that switch TCP on or off.
    anew: bool = item(*TRUTH, False)

    def line(self, number: int) -> str | None:
        """Return the line that selects an offset, None if there is no such one.

        Examples
        --------
        >>> WorkOffsets(("G54", "G55"), "G54.1 P{0}", 1, 50, False).line(4)
        'G54.1 P2'
        """
        if number <= len(self.words):
            return self.words[number - 1]
        if not self.further or number > self.most:
            return None
        return self.further.format(number - len(self.words) - 1 + self.counted_from)

    def name(self, number: int) -> str:
        """Return the name of an offset in `mathpost.shop.controls.coordinates.Setup`; "" if there is none."""
        return "".join((self.line(number) or "").split())


def work_offsets_of(file: TomlTable) -> WorkOffsets:
    """Read the table [work_offsets]; without it there is none."""
    made = _of(WorkOffsets, file.table("work_offsets", optional=True))
    return replace(made, most=made.most or len(made.words))


def arcs_of(file: TomlTable) -> Arcs | None:
    """Read the table [arcs], if there is one."""
    table = file.table("arcs", optional=True)
    return _of(Arcs, table) if table.content else None


def cycles_of(file: TomlTable) -> Cycles | None:
    """Read the table [cycles], if there is one."""
    table = file.table("cycles", optional=True)
    if not table.content:
        return None
    expected = f"a list of lines, in them {', '.join(f'{{{name}}}' for name in CYCLE_FIELDS)} only"
    fields = dict.fromkeys(CYCLE_FIELDS, 1.0)
    kinds = {kind: table.take(kind, lambda lines: filled(lines, **fields), expected) for kind in KINDS
             if kind in table.content}  # fmt: skip
    return _of(Cycles, table, kinds=kinds)


def tilted_of(file: TomlTable, notations: tuple[str, ...]) -> Tilted | None:
    """Read the table [plane], if there is one."""
    table = file.table("plane", optional=True)
    if not table.content:
        return None
    notation = table.take("notation", *one_of(*notations, "none"))
    made = _of(Tilted, table, notation=notation)
    return None if notation == "none" else made


def _of(kind: type[Any], table: TomlTable, **others: Any) -> Any:
    """A dataclass whose keys are all that a table has, but for the others."""
    made = kind(**keys_of(kind, {"": table}), **others)
    table.done()
    return made
