"""What the headings of a table of NC words say: which letter a column is of, and whose data it holds."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from mathpost.kinematics import Kinematics
    from mathpost.workbook.meaning.nc_columns import Column
    from mathpost.workbook.sheet.graph import Graph
    from mathpost.workbook.sheet.place import Place

PLAIN, AMONG_OTHERS = 1.1, 0.4  # what a heading counts that is a letter or word, or has a letter; 1 if numbers fit
MACHINE = re.compile(r"(?<![a-z])(?:nc|machine|mcs|posted)(?![a-z])|机床|maschine|^[xyzabc]m$")
OF_CL = re.compile(r"(?<![a-z])(?:cl|apt|tip|part|workpiece|wcs|werkstück)(?![a-z])|刀位|刀尖")
OF_AXIS = re.compile(
    r"tool.?axis|werkzeugachse|刀轴|normal|ve[ck]tor|矢量|direction|richtung|orient|^[nv]_?[xyz]$|^(?:ax|axis)_?[xyz]$"
)
SIDES = {"nc": MACHINE, "cl": OF_CL, "axis": OF_AXIS}
UNIT = re.compile(r"[\[(（/].*|\b(?:deg|rad|mm|grad)\b\.?$|[°度]")


def side(graph: Graph, sheet: str, along: int, first: int, number: int) -> str:
    """Whose data a column holds by its headings, or by the nearest before each: "nc", "cl", "axis", or nothing.

    Rows are counted by the place's number `along`, from `first`; `number` is that of the column.
    """
    for line in range(first - 1, max(first - 4, 0), -1):
        places = ((sheet, line, n) if along == 1 else (sheet, n, line) for n in range(number, 0, -1))
        cells = map(graph.cells.get, places)
        text = next((normal(cell.value) for cell in cells if cell and isinstance(cell.value, str)), "")
        names = [name for name, pattern in SIDES.items() if pattern.search(text)]
        if len(names) == 1:
            return names[0]
    return ""


def normal(text: str) -> str:
    """A text in small letters and plain signs."""
    return unicodedata.normalize("NFKC", text).strip().lower()


def letters_of(heading: str) -> dict[str, float]:
    """The letters that a heading names, as in "a", "x_nc", "刀轴i", "px", "ti" or "zm"."""
    said = UNIT.sub("", heading).strip()
    if re.fullmatch("[a-z]", said):
        return {said: PLAIN}
    named = re.findall(r"(?<![a-z])(?:(?:tip|axis|tool|ax|[ptnev])(?=[xyzijk]))?([a-z])(?![a-z0-9])", said)
    named += re.findall(r"(?<![a-z])([xyz])(?:cl|nc|mcs|wcs|[a-z])(?![a-z])", said)
    return dict.fromkeys(named, PLAIN if MACHINE.search(said) else AMONG_OTHERS)


def stand_apart(tip: Sequence[int], axis: Sequence[int], words: Sequence[int]) -> bool:
    """Whether the tip is next to the rotary words and X Y Z next to the tool axis, as if exchanged."""

    def near(part: Sequence[int], other: Sequence[int]) -> bool:
        return min((abs(a - b) for a in part for b in other), default=0) == 1

    linear, rotary = words[-5:-2], words[-2:]
    return near(tip, rotary) and near(linear, axis) and not (near(tip, axis) or near(linear, rotary))


def headings_exchanged(
    graph: Graph,
    kinematics: Kinematics,
    tip: Sequence[Column],
    axis: Sequence[Column],
    words: Sequence[Column],
    apart: bool = False,
) -> tuple:
    """The first cell under the heading of another column, or that is made of such, and what is said there."""
    names = "".join(name[0].lower() for name in kinematics.machine.joint_names)
    sides = [{c.said for c in part} for part in (tip, words[-5:-2])]
    if sides == [{"nc"}, {"cl"}] or (apart and sides == [{""}, {""}]):
        return words[0].places[0], "the headings say that this is the tip, and that the tip is X Y Z: exchanged"
    parts = (
        (tip, "xyz"),
        (axis, "ijk"),
        (axis, "uvw"),
        (axis, "xyz"),
        (words[-5:-2], names[:3]),
        (words[-2:], names[3:]),
    )
    for part, letters in parts:
        said = ["".join(column.letters) for column in part]
        if sorted(said) == sorted(letters) and said != [*letters]:
            k = next(k for k in range(len(said)) if said[k] != letters[k])
            return where(graph, part[k], words), f"{letters[k]} stands under the heading {said[k]}: exchanged"
    return ()


def where(graph: Graph, column: Column, words: Sequence[Column]) -> Place:
    """The first cell of a column, or of a word that is made of it."""
    place = column.places[0]
    made = [p for word in words for p in word.places[:1] if place in graph.upstream([p])]
    return next(iter(made), place) if column.typed else place
