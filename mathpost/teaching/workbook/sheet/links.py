"""Which cell of a workbook uses which, in which order they follow, and which hang together on the sheet."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable
from functools import cached_property, partial
from graphlib import CycleError, TopologicalSorter
from typing import TYPE_CHECKING

from mathpost.teaching.bounds import TooLarge
from mathpost.teaching.workbook.sheet.cells import Cells
from mathpost.teaching.workbook.sheet.evaluate import FUNCTIONS
from mathpost.teaching.workbook.sheet.place import beside
from mathpost.teaching.workbook.sheet.tree import areas, gives_text, heads, used_areas, walk

if TYPE_CHECKING:
    from mathpost.teaching.workbook.sheet.formula import Tree
    from mathpost.teaching.workbook.sheet.place import Line, Place

MOST_FORMULAS = 20_000  # that are looked at one by one
ASIDE = 300  # formulas apart from all rotations: so many are judged
TURNS = {"SIN", "COS", "TAN", "ASIN", "ACOS", "ATAN", "ATAN2", "MMULT", "TRANSPOSE", "MINVERSE", "MDETERM"}


class Links(Cells):
    """The formulas of a workbook, and who uses whom.

    `circular` has one place of each circle of formulas that depend on themselves; what is not looked at, apart from
    all rotations, is `aside`.
    """

    aside: Line = ()

    def used_by(self, tree: Tree) -> list[Place]:
        """The places that a tree refers to."""
        return list(dict.fromkeys(place for area in used_areas(tree) for place in area.places))

    @cached_property
    def parts(self) -> list[tuple[tuple, Tree]]:
        """The parts of all formulas, as `walk` yields them."""
        return [part for tree in {id(t): t for t in self.trees.values()}.values() for part in walk(tree)]

    @cached_property
    def uses(self) -> dict[Place, list[Place]]:
        """Place of a formula → the places it refers to, in order and without repetition."""
        trees = {id(t): t for t in self.trees.values()}
        self.count(sum(area.shape[0] * area.shape[1] for tree in trees.values() for area in areas(tree)))
        found = {id(tree): self.used_by(tree) for tree in trees.values()}
        return {place: found[id(tree)] for place, tree in self.trees.items()}

    @cached_property
    def used(self) -> dict[Place, list[Place]]:
        """Place → the formulas that refer to it."""
        found: dict[Place, list[Place]] = {}
        for place, sources in self.uses.items():
            for source in sources:
                found.setdefault(source, []).append(place)
        return found

    def upstream(self, places: Iterable[Place], given: Collection[Place] = ()) -> set[Place]:
        """Everything that `places` depend on, themselves included; not what those `given` depend on."""
        if not given:
            return self._reached(places, self.uses.get)
        return self._reached(places, lambda place: None if place in given else self.uses.get(place))

    def downstream(self, places: Iterable[Place]) -> set[Place]:
        """Everything that depends on `places`, themselves included."""
        return self._reached(places, self.used.get)

    def _reached(self, places: Iterable[Place], links: Callable[[Place], Iterable[Place] | None]) -> set[Place]:
        """The places that one comes to from some, themselves included; `links(place)` are the next ones or None."""
        found = set(places)
        stack = [*found]
        while stack:
            for place in links(stack.pop()) or ():
                if place not in found:
                    found.add(place)
                    stack.append(place)
        self.count(len(found))
        return found

    @cached_property
    def order(self) -> list[Place]:
        """The formulas, each after those that it uses."""
        links = {place: [s for s in sources if s in self.trees] for place, sources in self.uses.items()}
        self.circular = set()
        while True:
            try:
                return list(TopologicalSorter(links).static_order())
            except CycleError as error:
                self.count(10 * len(links))
                source, user = error.args[1][:2]
                links[user] = [each for each in links[user] if each != source]
                self.circular.add(user)

    @cached_property
    def _position(self) -> dict[Place, int]:
        """Place of a formula → its index in `order`."""
        return {place: n for n, place in enumerate(self.order)}

    @cached_property
    def level(self) -> dict[Place, int]:
        """Place of a formula → the length of the longest chain of formulas that leads to it."""
        found: dict[Place, int] = {}
        for place in self.order:
            found[place] = 1 + max((found.get(source, 0) for source in self.uses[place]), default=0)
        return found

    def calculation_order(self, place: Place) -> tuple[int, tuple[int, int, int]]:
        """A key that sorts places by how many formulas in a chain lead to them, then as they are read."""
        return self.level.get(place, 0), self.reading_order(place)

    @cached_property
    def components(self) -> list[Line]:
        """Numbers and formulas that hang together edge to edge, as they are read."""
        found, left = [], {p for p, cell in self.cells.items() if cell.formula or self.meant[p] is not None}
        for place in sorted(left, key=self.reading_order):
            if place in left:
                near = self._reached([place], partial(_beside_in, left))
                left -= near
                found.append(tuple(sorted(near, key=self.reading_order)))
        return found

    @cached_property
    def component(self) -> dict[Place, Line]:
        """Place of a number or formula → the component that it is of."""
        return {place: component for component in self.components for place in component}

    # What is no number of a calculation.

    @cached_property
    def texts(self) -> set[Place]:
        """The places of texts that are typed."""
        return {
            p for p, cell in self.cells.items() if isinstance(cell.value, str) and not (cell.formula or cell.error)
        }

    @cached_property
    def messages(self) -> set[Place]:
        """The formulas that give a text."""
        found = set()
        for place in (*self.order, *self.unread):
            cell = self.cells[place]
            tree = self.trees.get(place, ("number", 0))
            source = tree[1].places[0] if tree[0] == "area" else None
            copied = source in found or (source in self.texts and self.meant[source] is None)
            unsaved = cell.value is None and (copied or gives_text(tree))
            is_text = isinstance(cell.value, str) and not cell.error and place not in self._modal
            found |= {place} if unsaved or is_text else set()
        return found

    @cached_property
    def not_evaluated(self) -> set[Place]:
        """The places of formulas of which a function is not known here."""
        known = {*FUNCTIONS, "number", "text", "area"}
        return {*self.unread, *(place for place, tree in self.trees.items() if heads(tree) - known)}

    def set_aside(self) -> None:
        """Leave out the formulas that are apart from all rotations, if these are many."""
        turning = [place for place, tree in self.trees.items() if heads(tree) & TURNS]
        near = self.upstream(self.downstream(turning))
        apart = [place for place in self.trees if place not in near]
        if len(apart) > ASIDE:
            self.aside = tuple(apart)
            needed = {s for place in self.trees.keys() & near for s in self.uses[place]}
            alone = {
                s for place in apart for s in self.uses[place]
            } & self.cells.keys() - needed  # and their inputs
            for place in alone.union(apart):
                del self.cells[place], self.meant[place]
                self.part.pop(place, None)
            self.trees = {place: tree for place, tree in self.trees.items() if place in near}
        for name in ("uses", "used"):  # of all formulas, as the file has them
            self.__dict__.pop(name, None)
        if len(self.trees) > MOST_FORMULAS:
            raise TooLarge(f"{len(self.trees)} formulas")


def _beside_in(places: set[Place], place: Place) -> set[Place]:
    return places.intersection(beside(place))
