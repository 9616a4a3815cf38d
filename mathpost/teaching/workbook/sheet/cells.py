"""The contents of the cells of a workbook, its formulas as trees, and how a place is written and read."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from mathpost.errors import InputError
from mathpost.teaching.bounds import TooLarge
from mathpost.teaching.workbook.sheet.file import EMPTY, local_address
from mathpost.teaching.workbook.sheet.formula import NotUnderstood, area_of, parse
from mathpost.teaching.workbook.sheet.lookup import resolved
from mathpost.teaching.workbook.sheet.shorthand import blanks_as_before, running_totals
from mathpost.teaching.workbook.sheet.tree import areas, form_of, parts_of, with_areas

if TYPE_CHECKING:
    from mathpost.teaching.workbook.sheet.file import Book
    from mathpost.teaching.workbook.sheet.formula import Area, Tree
    from mathpost.teaching.workbook.sheet.place import Place

WORK = 20_000_000  # steps from cell to cell


class Cells:
    """The formulas of a workbook, by place: (sheet, row, column), rows and columns from 1.

    `cells` holds the contents, `trees` every formula that was understood, `unread` what was not understood in the
    others; `part` has the row and column in its array, from 0, of a cell of an array formula, whose tree is that of
    the whole array. `other` has formulas that replace the file's, by place, each with the first cell of its array.
    `work` counts the steps from cell to cell, of which at most `WORK` are allowed.
    """

    def __init__(self, book: Book, other: Mapping[Place, tuple[str, tuple]] | None = None) -> None:
        self.book, self.names, self.cells = book, book.names, dict(book.cells)
        self.trees, self.part, self.unread, self.work = {}, {}, {}, 0
        for place, (formula, anchor) in (other or {}).items():
            self.cells[place] = replace(self.cells.get(place, EMPTY), formula=formula, anchor=anchor)
        self.meant = {place: cell.meant for place, cell in self.cells.items()}
        self.sheets = {name.lower(): name for name in book.sheets}
        self.numbers = {name: n for n, name in enumerate(book.sheets)}
        parsed: dict[tuple[str, str], Tree] = {}
        self._forms: dict[int, tuple[str, Tree]] = {}
        self._relative: dict[Place, tuple[Tree, Tree | None]] = {}
        for place, cell in self.cells.items():
            key = place[0], cell.formula
            try:
                if cell.formula:
                    if key not in parsed:
                        parsed[key] = resolved(parse(cell.formula, place[0], self.names, self.sheets), self._typed)
                    self.trees[place] = _with_own_place(parsed[key], place)
            except NotUnderstood as error:
                self.unread[place] = str(error)
            if cell.anchor:
                self.part[place] = place[1] - cell.anchor[0], place[2] - cell.anchor[1]
        self._arrays: dict[tuple, list[Place]] = {}
        for place in self.part:
            self._arrays.setdefault((place[0], self.cells[place].anchor), []).append(place)
        self.trees |= running_totals(self.trees, self.part)
        unchanged = blanks_as_before(self.trees, self.cells)
        self.trees |= unchanged
        self._modal = unchanged.keys()

    def count(self, steps: int) -> None:
        """Count some steps; raise `TooLarge` if there were too many."""
        self.work += steps
        if self.work > WORK:
            raise TooLarge(f"more than {WORK // 1_000_000} million steps for {len(self.trees)} formulas")

    def _typed(self, place: Place) -> Any:
        """The number or text in a cell, empty if there is nothing; None for a formula that is no text."""
        cell = self.cells.get(place, EMPTY)
        if cell.formula:
            return self.trees[place][1] if self.tree(place)[0] == "text" else None
        return "" if cell.value is None else cell.value

    # Places.

    def address(self, place: Place) -> str:
        """Return a place as ``Sheet!B5``."""
        quoted = f"'{place[0]}'" if re.search(r"[^\w.]", place[0]) else place[0]
        return f"{quoted}!{self.short(place)}"

    @staticmethod
    def short(place: Place) -> str:
        """Return a place as ``B5``."""
        return local_address(place[1:])

    def ranges(self, places: Iterable[Place]) -> Iterator[str]:
        """Write places as addresses, runs in a row or a column as ranges."""
        left = sorted(places, key=lambda p: (self.reading_order(p)[0], p[2], p[1]))
        while left:
            run = [left.pop(0)]
            while left and left[0] == (run[-1][0], run[-1][1] + 1, run[-1][2]):
                run.append(left.pop(0))
            yield self.range(run)

    def range(self, places: Sequence[Place]) -> str:
        """The first and the last of some places, as ``Sheet!B2:B4``."""
        first = self.address(places[0])
        return first if len(places) == 1 else f"{first}:{self.short(places[-1])}"

    def named(self, name: str, text: str) -> Area:
        """Return the `Area` of an address such as ``Sheet1!B2:B4``; raise `InputError` if it is none."""
        try:
            (area,) = areas(parse(f"={text}", self.book.sheets[0], self.names, self.sheets))
        except (NotUnderstood, ValueError):
            known = f"an address such as B2:B4 or Sheet1!B2, sheets {', '.join(self.numbers)}"
            raise InputError(f"cells, {name!r}", known, repr(text)) from None
        return area

    def reading_order(self, place: Place) -> tuple[int, int, int]:
        """A key that sorts places by sheet, row and column."""
        return (self.numbers[place[0]], *place[1:])

    def array(self, place: Place) -> list[Place]:
        """The cells of the array formula that a cell is of, itself first; or the cell alone."""
        mates = self._arrays[place[0], self.cells[place].anchor] if place in self.part else ()
        return [place, *(p for p in mates if p != place)]

    def is_array(self, places: Sequence[Place]) -> bool:
        """Whether some cells are of one array formula."""
        arrays = {(p[0], self.cells[p].anchor, id(self.trees.get(p))) if p in self.part else p for p in places}
        return len(arrays) == 1 and places[0] in self.part

    # The contents of a place.

    def value(self, place: Place) -> float | None:
        """The number in a cell as the file holds it, texts such as 54,7356 included, or None."""
        return self.meant.get(place)

    def tree(self, place: Place) -> Tree:
        """The formula in a cell; an empty text where there is none."""
        return self.trees.get(place, ("text", ""))

    def form(self, place: Place) -> str | None:
        """The formula of a cell as text with all references of one size alike, or None."""
        if place not in self.trees:
            return None
        tree = self.trees[place]
        if id(tree) not in self._forms:
            self._forms[id(tree)] = form_of(tree), tree  # as long as the tree is kept no other has its id
        return self._forms[id(tree)][0]

    def relative(self, place: Place) -> Tree | None:
        """The formula with its references counted from its cell, as R[-1]C2, or None if it has none.

        All cells to which a formula is filled have the same.
        """
        tree = self.trees.get(place)
        if tree and self._relative.get(place, (None,))[0] is not tree:
            seen: list[Any] = [area.seen_from(*place[1:]) for area in areas(tree)]
            self._relative[place] = tree, with_areas(tree, seen) if seen else None
        return self._relative[place][1] if tree else None


def _with_own_place(tree: Tree, place: Place) -> Tree:
    """A formula with its own cell in ROW() and COLUMN()."""
    if not any(len(part) == 1 and part[0] in ("ROW", "COLUMN") for part in parts_of(tree)):
        return tree
    if len(tree) == 1 and tree[0] in ("ROW", "COLUMN"):
        return tree[0], ("area", area_of([place]))
    return tuple(_with_own_place(part, place) if isinstance(part, tuple) else part for part in tree)
