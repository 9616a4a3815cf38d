"""Which cell is x, y or z, which angle is α, β or γ, what is an origin: by the texts beside them."""

from __future__ import annotations

import re
from collections.abc import Collection, Sequence
from typing import TYPE_CHECKING

from mathpost.teaching.workbook.meaning.label import plain, read_label
from mathpost.teaching.workbook.meaning.vectors import Vectors
from mathpost.teaching.workbook.meaning.vocabulary import wording
from mathpost.teaching.workbook.sheet.place import offset

if TYPE_CHECKING:
    from mathpost.teaching.workbook.sheet.place import Line, Place

AXIS_NAMES = {
    axis: rf"{wording(name)}|\br_?{axis}\b" for axis, name in (("X", "roll"), ("Y", "pitch"), ("Z", "yaw"))
}


class Names(Vectors):
    """What the texts of a workbook call its vectors and angles."""

    names: Sequence[str]  # of the angles, as a product in the text has them
    _ends: dict[Place, Place]

    def heading(self, triple: Line) -> str:
        """The texts before a vector, with no number in between, or above it as far; or over its column."""
        (sheet, row, column), cells = triple[0], self.graph.cells
        first = max((n for n in range(1, column) if (sheet, row, n) in self.graph.component), default=0) + 1
        near = (cells.get((sheet, row - up, n)) for up in (0, 1) for n in range(first, column + 1))
        texts = [cell.value for cell in near if cell and isinstance(cell.value, str)]
        return "\n".join([*texts, *self.texts(triple[0])[:2]])

    def is_named(self, line: Line, pattern: str) -> bool:
        """Whether the text before the first of some cells, or above it, is such a name."""
        cells = self.graph.cells
        for steps in (((0, -n) for n in (1, 2, 3)), ((-n, 0) for n in (1, 2, 3))) if line else ():
            near = (cells.get(offset(line[0], *step)) for step in steps)
            text = next((cell.value for cell in near if cell and isinstance(cell.value, str)), "")
            if re.search(pattern, text, re.I):
                return True
        return False

    def coordinate(self, place: Place, kinds: Collection[str] = ("coordinate", "outcome")) -> int | None:
        """Which coordinate the text before a number, in its row or column, says it is."""
        cells = self.graph.cells
        for down, right in ((0, -1), (-1, 0)):
            before = (cells.get(offset(place, n * down, n * right)) for n in range(1, 60))
            texts = (c.value for c in before if c and isinstance(c.value, str))
            text = next(texts, "")
            said = *text.split("=")[::-1], text.split(" ")[0]  # "z2 = z'", "z' (mm)"
            role = next(filter(None, map(read_label, said)), None)
            if role and role.kind in kinds:
                return role.which
        return None

    def as_named(self, cells: Line, kinds: Collection[str] = ("outcome",)) -> Line:
        """The three cells of a result, or of a point, in the order x, y, z that their labels say."""
        said = [self.coordinate(p, kinds) for p in cells]
        named = {*said} == {0, 1, 2} and len(said) == 3
        return tuple(cells[said.index(n)] for n in range(3)) if named else cells

    def angle_said(self, place: Place) -> int | None:
        """Which angle the text before a cell names; None if it names none, or several."""
        letters = {*re.findall("[αβγ]|alpha|beta|gamma", self.label(place).lower())}
        return ("α", "β", "γ", "alpha", "beta", "gamma").index(*letters) % 3 if len(letters) == 1 else None

    def three(self, cells: Line) -> Line | None:
        """The three inputs that belong together among `cells`, which may hold one too many or one too few."""
        lines = self.lines(set(cells), min(len(cells), 2))
        lines = [line for line in lines if self.lengths.isdisjoint(line)]
        lines.sort(key=lambda line: -len(self.angles.intersection(line)))
        if len(cells) == 3:  # which may be one of two others and a wrong one
            may = self.angles | (self.typed - self.graph.used.keys()) if self.composed.isdisjoint(cells) else set()
            near = (line for line in lines if sum(b - a for a, b in zip(line[0][1:], line[1][1:], strict=True)) < 3)
            return next((line for line in near if may.issuperset(line)), tuple(cells))
        return lines[0] if lines else None

    def by_name(self, triple: Line, sequence: str | None = None) -> Line:
        """The angles α, β, γ: as labels say, or in the order in which they, or what they turn by, are read."""
        axes = [
            "".join(axis for axis, name in AXIS_NAMES.items() if re.search(name, self.label(p), re.I))
            for p in triple
        ]
        letters = (sequence or self.sequence).upper()
        if sorted(axes) == sorted(letters) == [*AXIS_NAMES]:
            return tuple(triple[axes.index(axis)] for axis in letters)
        if named := self._named_in_the_text(triple):
            return named
        graph, in_line = self.graph, any(len({(p[0], p[n]) for p in triple}) == 1 for n in (1, 2))
        ends = [self._end(p) for p in triple]
        for places in (triple, ends):
            # Which of φ, θ, ψ comes first is not the same everywhere.
            labels = [
                label for label in map(self.label, places) if not re.search("phi|psi|theta|[φψθ]", label, re.I)
            ]
            roles = [role for role in map(read_label, labels) if role and role.kind in ("angle", "radians")]
            words = [role.which for role in roles]
            if len(set(words)) == 3:
                return tuple(p for _, p in sorted(zip(words, triple, strict=True)))
        read = map(graph.reading_order, triple if in_line else ends)
        return tuple(p for _, p in sorted(zip(read, triple, strict=True)))

    def _end(self, place: Place) -> Place:
        """The last cell that an angle becomes before it goes into a sine."""
        if place not in self._ends:
            after = self.turning & self.graph.downstream([place])
            self._ends[place] = max(after, key=self.graph.calculation_order, default=place)
        return self._ends[place]

    def _named_in_the_text(self, triple: Line) -> Line:
        """The angles in the order in which a product in the text has their names; empty if the labels do not."""
        found: dict[str, Place] = {}
        for place in triple:
            said = ({*self.names}.intersection(re.findall(r"\w+", plain(text))) for text in self.texts(place))
            found |= {name: place for name in next((words for words in said if len(words) == 1), ())}
        return tuple(found[name] for name in self.names) if len(found) == len(triple) == len(self.names) else ()
