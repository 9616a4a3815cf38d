"""A workbook as one graph of cells: which cell uses which, and what all of them are at many inputs at once."""

from dataclasses import replace
from functools import cached_property

import numpy as np

from mathpost.errors import InputError
from mathpost.workbook.file import local_address
from mathpost.workbook.formula import Area, NotUnderstood, areas, evaluate, parse, put, walk

SAMPLES = 8
CLOSE = 1e-9  # relative: what the arithmetic of a spreadsheet loses


class Graph:
    """The formulas of a workbook.

    Attributes
    ----------
    cells : dict
        (sheet, row, column) → `mathpost.workbook.file.Cell`; rows and columns from 1.
    trees : dict
        Place → tree, of every formula that was understood; a cell of an array formula has the tree of the whole.
    part : dict
        Place of a cell of an array formula → its row and column in the array, from 0.
    unread : dict
        Place → what in its formula is not understood.
    """

    def __init__(self, book):
        self.book = book
        self.cells = {(sheet.name, *place): cell for sheet in book.sheets for place, cell in sheet.cells.items()}
        self.sheets = {sheet.name.lower(): sheet.name for sheet in book.sheets}
        self.trees, self.part, self.unread = {}, {}, {}
        names = {
            name.upper(): Area(self.sheets.get(sheet.lower(), sheet), *first, *last, (True, True))
            for name, (sheet, first, last) in book.names.items()
        }
        parsed = {}
        for place, cell in self.cells.items():
            if not cell.formula:
                continue
            key = (place[0], cell.formula)
            try:
                if key not in parsed:
                    parsed[key] = self._known_sheets(parse(cell.formula, place[0], names))
                self.trees[place] = parsed[key]
            except NotUnderstood as error:
                self.unread[place] = str(error)
            if cell.array:
                row, column = cell.anchor
                self.part[place] = (place[1] - row, place[2] - column)

    def _known_sheets(self, tree):
        """Return the tree with the names of sheets as they are written in the workbook."""
        for path, part in list(walk(tree)):
            if part[0] != "area":
                continue
            area = part[1]
            if area.sheet.lower() not in self.sheets:
                raise NotUnderstood(f"the sheet {area.sheet}, which is not there")
            if area.sheet != self.sheets[area.sheet.lower()]:
                tree = put(tree, path, ("area", replace(area, sheet=self.sheets[area.sheet.lower()])))
            if (area.bottom - area.top + 1) * (area.right - area.left + 1) > 20_000:
                raise NotUnderstood(f"the large range {area}")
        return tree

    def address(self, place):
        """Return a place as ``Sheet!B5``."""
        return self.book.sheet(place[0]).address(place[1:])

    def short(self, place):
        """Return a place as ``B5``."""
        return local_address(place[1:])

    def value(self, place):
        """The number in a cell as the file holds it, texts such as 54,7356 included, or None."""
        cell = self.cells.get(place)
        return None if cell is None else cell.meant

    @cached_property
    def uses(self):
        """Place of a formula → the places it refers to, in order and without repetition."""
        seen, found = {}, {}
        for place, tree in self.trees.items():
            if id(tree) not in seen:
                seen[id(tree)] = self.used_by(tree)
            found[place] = seen[id(tree)]
        return found

    def used_by(self, tree):
        """The places that a tree refers to."""
        return list(dict.fromkeys(place for area in areas(tree) for place in area.places))

    @cached_property
    def used(self):
        """Place → the formulas that refer to it."""
        found = {}
        for place, sources in self.uses.items():
            for source in sources:
                found.setdefault(source, []).append(place)
        return found

    @cached_property
    def order(self):
        """The places of the formulas, each after what it uses; `circular` are those for which there is no order."""
        state, order, circular = {}, [], set()
        for start in sorted(self.trees, key=self.reading_order):
            stack = [(start, iter(self.uses[start]))]
            if start in state:
                continue
            state[start] = 1
            while stack:
                place, rest = stack[-1]
                for source in rest:
                    if source in self.trees and state.get(source) != 2:
                        if state.get(source) == 1:
                            circular.add(place)
                        else:
                            state[source] = 1
                            stack.append((source, iter(self.uses[source])))
                            break
                else:
                    state[place] = 2
                    order.append(place)
                    stack.pop()
        self.circular = circular
        return order

    def reading_order(self, place):
        """A key that sorts places by sheet, row and column."""
        return (list(self.sheets.values()).index(place[0]), *place[1:])

    @cached_property
    def leaves(self):
        """The typed numbers that some formula uses."""
        return [
            p
            for p in sorted(self.used, key=self.reading_order)
            if p not in self.trees and self.value(p) is not None
        ]

    def upstream(self, places):
        """Everything that `places` depend on, themselves included."""
        found, stack = set(), list(places)
        while stack:
            place = stack.pop()
            if place not in found:
                found.add(place)
                stack += self.uses.get(place, ())
        return found

    def downstream(self, places):
        """Everything that depends on `places`, themselves included."""
        found, stack = set(), list(places)
        while stack:
            place = stack.pop()
            if place not in found:
                found.add(place)
                stack += self.used.get(place, ())
        return found

    # Values.

    def run(self, inputs, fixed=None, base=None, only=None):
        """Evaluate the formulas.

        Parameters
        ----------
        inputs : dict
            Place → array of shape (samples,), for typed numbers; the others have the value of the file.
        fixed : dict, optional
            Place → array, for formulas that are not to be evaluated.
        base : dict, optional
            The result of an earlier run, of which the places not in `only` are kept.
        only : set, optional
            The formulas to evaluate; all without it.

        Returns
        -------
        dict
            Place → array of shape (samples,).
        """
        fixed = fixed or {}
        values = dict(base or {})
        values.update(inputs)
        values.update(fixed)
        arrays = {}
        with np.errstate(all="ignore"):
            for place in self.order:
                if place in fixed or (only is not None and place not in only):
                    continue
                values[place] = self._cell(place, self.trees[place], values, arrays)
        return values

    def _cell(self, place, tree, values, arrays):
        if place not in self.part:
            return self.calculate(tree, values)[:, 0, 0]
        key = (id(tree), self.cells[place].anchor)
        if key not in arrays:
            arrays[key] = self.calculate(tree, values)
        return at(arrays[key], self.part[place])

    def calculate(self, tree, values):
        """Return the value of a tree, shape (samples, rows, columns), from those of the cells; NaN if none."""
        try:
            with np.errstate(all="ignore"):
                return evaluate(tree, lambda area: self.look(area, values))
        except NotUnderstood:
            return np.full((1, 1, 1), np.nan)

    def look(self, area, values):
        """The values of an area, shape (samples, rows, columns)."""
        if area.top == area.bottom and area.left == area.right:
            return self.number((area.sheet, area.top, area.left), values)[:, None, None]
        numbers = [self.number(place, values) for place in area.places]
        samples = max(map(len, numbers))
        stacked = np.stack([np.broadcast_to(n, (samples,)) for n in numbers], axis=-1)
        return stacked.reshape(samples, *area.shape)

    def number(self, place, values):
        """The value of one cell, shape (samples,) or (1,): 0 for an empty one, NaN for text."""
        if place in values:
            return values[place]
        cell = self.cells.get(place)
        if cell is None or (cell.value is None and not cell.formula):
            return np.zeros(1)
        if place in self.trees or cell.meant is None:
            return np.full(1, np.nan)
        return np.array([cell.meant])


def area_named(graph, name, text):
    """Return the `Area` that a caller means by an address such as ``Sheet1!B2:B4``; of the first sheet without one.

    Raises
    ------
    InputError
        If it is no address, or of a sheet that is not there.
    """
    try:
        (area,) = areas(parse(f"={text}", graph.book.sheets[0].name, {}))
    except (NotUnderstood, ValueError):
        raise InputError(f"cells, {name!r}", "an address such as B2:B4 or Sheet1!B2", repr(text)) from None
    return replace(area, sheet=graph.book.sheet(area.sheet).name)


def at(array, index):
    """The entry of an array formula's value in one of its cells; a single row or column is repeated."""
    row = index[0] if array.shape[1] > 1 else 0
    column = index[1] if array.shape[2] > 1 else 0
    if row >= array.shape[1] or column >= array.shape[2]:
        return np.full(len(array), np.nan)
    return array[:, row, column]


def same(a, b, tolerance=CLOSE):
    """Whether two values agree at every sample; at the first, the sheet's own numbers, either may be unknown, NaN.

    Examples
    --------
    >>> same(np.array([1.0, 2.0]), np.array([1.0, 2.0 + 1e-12]))
    True
    """
    fine = np.abs(a - b) <= tolerance * (1 + np.abs(b))
    if len(fine) > 1 and not fine[0].all():
        unknown = ~np.isfinite(a + b)[0]
        return bool((fine[0] | unknown).all() and fine[1:].all())
    return bool(fine.all())
