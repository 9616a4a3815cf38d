"""Words for more than a straight move, as a control's file states them: arcs, drilling cycles, tilted planes.

What a file does not state, its control is not asked for: programs have straight moves then.
"""

from dataclasses import dataclass

from mathpost.files import TomlTable, a_number, each, one_of, only_if, some_text
from mathpost.shop.controls.blocks import PLANES

# Numbers of a cycle, mm, seconds, mm/min and turns a minute: the coordinates of the surface, the bottom, of where
# the feed begins and where the tool leaves, and how far these are from the surface; how deep a peck goes.
CYCLE_FIELDS = ("surface", "bottom", "clearance", "leave", "depth", "above", "retract", "step", "dwell",
                "milliseconds", "feed", "pitch", "speed")  # fmt: skip
KINDS = ("drill", "dwell", "deep", "chips", "bore", "ream", "tap", "tap left")
WORD = only_if(lambda value: isinstance(value, str)), "a word"
LINES = each(str), "a list of lines"


@dataclass(frozen=True)
class Arcs:
    """How an arc or a helix is written for a control."""

    planes: dict[str, str]  # those that an arc may lie in, some of `PLANES`, and the word that selects each
    clockwise: str  # seen from the end of the axis square to the plane
    counterclockwise: str
    begin: str  # what such a block begins with, where moves begin with a word; the sense then comes last
    centre: tuple[str, ...]  # words of the centre, counted from the start of the arc, of X, Y and Z
    pole: str  # or the word of a line before it that has the centre's coordinates
    helix: tuple[str, ...]  # what a helix begins with, and the word of its angle, if it has no end point
    ends: float  # mm, by which its distance from the centre may differ between both ends


@dataclass(frozen=True)
class Cycles:
    """How drilling cycles are written for a control, by `KINDS`; lines with the fields of `CYCLE_FIELDS`."""

    kinds: dict[str, tuple[str, ...]]  # what begins a row of holes, at the position of its first one,
    again: tuple[str, ...]  # what follows the position of each further hole,
    off: tuple[str, ...]  # and of the last
    modal: str  # a word that makes the last of these lines hold for each position that follows, or nothing
    # How the control pecks: from where the first depth counts, "surface", "clearance" or nothing, if not known;
    # how far above the depth before the feed begins again, mm or "clearance"; how far chip breaking goes back, mm.
    pecks_from: str
    again_above: float | str
    back: float

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
    positioning: str  # words behind it
    swivel_data: str  # the name of the machine in it, where it has one
    on: tuple[str, ...]  # lines behind that one,
    off: tuple[str, ...]  # and those that end it


@dataclass(frozen=True)
class WorkOffsets:
    """How a work offset is written for a control, by its number, from 1."""

    words: tuple[str, ...]  # of the first ones,
    further: str  # and of those behind them, with {0} in it; or nothing
    counted_from: int  # what {0} is in the first of these
    most: int  # how many there are
    anew: bool  # whether it has to be selected anew behind words that switch TCP on or off

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
    table = file.table("work_offsets", optional=True)
    words = tuple(table.take("words", *LINES, ()))
    count = only_if(lambda value: type(value) is int and value > 0), "a whole number from 1"
    made = WorkOffsets(
        words=words,
        further=table.take("further", only_if(lambda line: not line or "{0}" in line), "a line with {0} in it", ""),
        counted_from=table.take("counted_from", *count, 1),
        most=table.take("most", *count, len(words)),
        anew=table.take("anew", only_if(lambda value: isinstance(value, bool)), "true or false", False),
    )
    table.done()
    return made


def arcs_of(file: TomlTable) -> Arcs | None:
    """Read the table [arcs], if there is one."""
    table = file.table("arcs", optional=True)
    if not table.content:
        return None
    planes = table.table("planes")
    made = Arcs(
        planes={name: planes.take(name, *WORD) for name in PLANES if name in planes.content},
        clockwise=table.take("clockwise", some_text, "a word"),
        counterclockwise=table.take("counterclockwise", some_text, "a word"),
        begin=table.take("begin", *WORD, ""),
        centre=tuple(table.take("centre", only_if(lambda three: len(three) == 3, LINES[0]), "three words", ())),
        pole=table.take("pole", *WORD, ""),
        helix=tuple(table.take("helix", only_if(lambda two: len(two) == 2, LINES[0]), "two words", ())),
        ends=table.take("ends", only_if(lambda value: value > 0, a_number), "mm above 0"),
    )
    planes.done()
    table.done()
    return made


def cycles_of(file: TomlTable) -> Cycles | None:
    """Read the table [cycles], if there is one."""
    table = file.table("cycles", optional=True)
    if not table.content:
        return None
    fields = ", ".join(f"{{{name}}}" for name in CYCLE_FIELDS)
    expected = f"a list of lines, in them {fields} only"
    made = Cycles(
        kinds={kind: tuple(table.take(kind, _filled, expected)) for kind in KINDS if kind in table.content},
        again=tuple(table.take("again", *LINES, ())),
        off=tuple(table.take("off", *LINES, ())),
        modal=table.take("modal", *WORD, ""),
        pecks_from=table.take("pecks_from", *one_of("surface", "clearance"), ""),
        again_above=table.take("again_above", _above, 'mm, not negative, or "clearance"', 0.0),
        back=table.take("back", only_if(lambda value: value >= 0, a_number), "mm, not negative", 0.0),
    )
    table.done()
    return made


def _above(value: float | str) -> float | str:
    """A distance in mm, not negative, or the word "clearance"."""
    return value if value == "clearance" else only_if(lambda distance: distance >= 0, a_number)(value)


def _filled(lines: list[str]) -> list[str]:
    """Lines whose fields are those of a cycle."""
    for line in LINES[0](lines):
        try:
            line.format(**dict.fromkeys(CYCLE_FIELDS, 1.0))
        except (KeyError, IndexError):
            raise ValueError from None
    return lines


def tilted_of(file: TomlTable, notations: tuple[str, ...]) -> Tilted | None:
    """Read the table [plane], if there is one."""
    table = file.table("plane", optional=True)
    if not table.content:
        return None
    notation = table.take("notation", *one_of(*notations, "none"))
    made = Tilted(
        notation=notation,
        positioning=table.take("positioning", *WORD, ""),
        swivel_data=table.take("swivel_data", *WORD, "TC1"),
        on=tuple(table.take("on", *LINES, ())),
        off=tuple(table.take("off", *LINES)),
    )
    table.done()
    return None if notation == "none" else made
