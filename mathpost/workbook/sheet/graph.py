"""A workbook as one graph of cells: which cell uses which, and what all of them are at many inputs at once."""

import re
from contextlib import suppress
from dataclasses import replace
from functools import cached_property, partial
from graphlib import CycleError, TopologicalSorter

import numpy as np

from mathpost.bounds import TooLarge
from mathpost.errors import InputError
from mathpost.workbook.sheet.file import EMPTY, local_address
from mathpost.workbook.sheet.formula import (
    FUNCTIONS,
    Area,
    NotUnderstood,
    areas,
    evaluate,
    exact,
    form_of,
    gives_text,
    heads,
    parse,
    parts_of,
    unrounded,
    walk,
)
from mathpost.workbook.sheet.lookup import resolved

SAMPLES = 8
SIX_DIGITS = 1e-6  # relative
ZERO, NOTHING = np.zeros(1), np.full(1, np.nan)
WORK, MOST_FORMULAS = 20_000_000, 20_000  # steps from cell to cell; formulas that are looked at one by one
ASIDE = 300  # formulas apart from all rotations: so many are judged
LONG = 16  # cells of a sum from which it is read as the one before it and what is added
RUNNING = {"SUM", "MAX", "MIN", "PRODUCT"}
TURNS = {"SIN", "COS", "TAN", "ASIN", "ACOS", "ATAN", "ATAN2", "MMULT", "TRANSPOSE", "MINVERSE", "MDETERM"}
CLOSE = 5e-8  # relative: what the arithmetic of a spreadsheet and π/180 as 0.0174532925 lose


class Graph:
    """The formulas of a workbook, by place: (sheet, row, column), rows and columns from 1.

    `cells` holds what stands there, `trees` every formula that was understood, `unread` what in the others is not;
    `part` the row and column in its array, from 0, of a cell of an array formula, which has the tree of the whole.
    `circular` has one place of each circle of formulas that depend on themselves. `other` has formulas in place of
    the file's, by place, each with the first cell of its array. `work` counts the steps from cell to cell, of which
    there may be `WORK`; what is not looked at, apart from all rotations, is `aside`.
    """

    def __init__(self, book, other=None):
        self.book, self.names, self.cells = book, book.names, dict(book.cells)
        self.trees, self.part, self.unread, self.aside, self.work = {}, {}, {}, (), 0
        for place, (formula, anchor) in (other or {}).items():
            self.cells[place] = replace(self.cells.get(place, EMPTY), formula=formula, anchor=anchor)
        self.meant = {place: cell.meant for place, cell in self.cells.items()}
        self.sheets = {name.lower(): name for name in book.sheets}
        self.numbers = {name: n for n, name in enumerate(book.sheets)}
        parsed, self._forms = {}, {}
        for place, cell in self.cells.items():
            key = place[0], cell.formula
            try:
                if cell.formula:
                    if key not in parsed:
                        parsed[key] = resolved(parse(cell.formula, place[0], self.names, self.sheets), self._typed)
                    self.trees[place] = parsed[key]
            except NotUnderstood as error:
                self.unread[place] = str(error)
            if cell.anchor:
                self.part[place] = place[1] - cell.anchor[0], place[2] - cell.anchor[1]
        self._arrays = {}
        for place in self.part:
            self._arrays.setdefault((place[0], self.cells[place].anchor), []).append(place)
        self._shorten_running_totals()
        self._take_blanks_as_before()

    def count(self, steps):
        """Count some steps; raise `TooLarge` if there were too many."""
        self.work += steps
        if self.work > WORK:
            raise TooLarge(f"more than {WORK // 1_000_000} million steps for {len(self.trees)} formulas")

    def _shorten_running_totals(self):
        """Read a long sum as the one before it and what is added: n running totals refer to 2·n cells, not n²/2."""
        totals = {}
        for place, tree in self.trees.items():
            if tree[0] in RUNNING and len(tree) == 2 and tree[1][0] == "area" and place not in self.part:
                area = tree[1][1]
                totals[place] = tree[0], replace(area, fixed=(False, False))
        for place, (head, area) in totals.items():
            down, right = (1, 0) if area.shape[1] == 1 else (0, 1)
            before = offset(place, -down, -right)
            if 1 in area.shape and sum(area.shape) > LONG and totals.get(before) == (head, area.but_last()):
                last = replace(area, top=area.bottom, left=area.right)
                self.trees[place] = head, ("area", Area(*before, *before[1:])), ("area", last)

    def _take_blanks_as_before(self):
        """Read =IF(B5=B4,"",B5), which says only what changes, as the cell before where it is blank."""
        blank, self._modal = ("text", ""), set()
        for place, tree in self.trees.items():
            if tree[0] == "IF" and blank in tree[2:]:
                single = {(area.sheet, area.top, area.left) for area in areas(tree[1]) if area.shape == (1, 1)}
                ways = [way for way in ((-1, 0), (0, -1)) if any(offset(p, *way) in single for p in single)]
                before = [offset(place, *way) for way in ways if offset(place, *way) in self.cells]
                if before:
                    cell = ("area", Area(*before[0], *before[0][1:]))
                    self.trees[place] = tuple(cell if part == blank else part for part in tree)
                    self._modal.add(place)

    def set_aside(self):
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

    def _typed(self, place):
        """The number or text in a cell, empty if there is nothing; None for a formula that is no text."""
        cell = self.cells.get(place, EMPTY)
        if cell.formula:
            return self.trees[place][1] if self.tree(place)[0] == "text" else None
        return "" if cell.value is None else cell.value

    # Places.

    def address(self, place):
        """Return a place as ``Sheet!B5``."""
        quoted = f"'{place[0]}'" if re.search(r"[^\w.]", place[0]) else place[0]
        return f"{quoted}!{self.short(place)}"

    @staticmethod
    def short(place):
        """Return a place as ``B5``."""
        return local_address(place[1:])

    def ranges(self, places):
        """Write places as addresses, runs in a row or a column as ranges."""
        left = sorted(places, key=lambda p: (self.reading_order(p)[0], p[2], p[1]))
        while left:
            run = [left.pop(0)]
            while left and left[0] == (run[-1][0], run[-1][1] + 1, run[-1][2]):
                run.append(left.pop(0))
            yield self.range(run)

    def range(self, places):
        """The first and the last of some places, as ``Sheet!B2:B4``."""
        first = self.address(places[0])
        return first if len(places) == 1 else f"{first}:{self.short(places[-1])}"

    def named(self, name, text):
        """Return the `Area` of an address such as ``Sheet1!B2:B4``; raise `InputError` if it is none."""
        try:
            (area,) = areas(parse(f"={text}", self.book.sheets[0], self.names, self.sheets))
        except (NotUnderstood, ValueError):
            known = f"an address such as B2:B4 or Sheet1!B2, sheets {', '.join(self.numbers)}"
            raise InputError(f"cells, {name!r}", known, repr(text)) from None
        return area

    def reading_order(self, place):
        """A key that sorts places by sheet, row and column."""
        return (self.numbers[place[0]], *place[1:])

    def calculation_order(self, place):
        """A key that sorts places by how many formulas in a chain lead to them, then as they are read."""
        return self.level.get(place, 0), self.reading_order(place)

    def array(self, place):
        """The cells of the array formula that a cell is of, itself first; or the cell alone."""
        mates = self._arrays[place[0], self.cells[place].anchor] if place in self.part else ()
        return [place, *(p for p in mates if p != place)]

    def cut_off(self):
        """Yield the cells of array formulas that give more rows or columns than there are cells, and how many."""
        values = self.run({})
        for anchor in dict.fromkeys((p[0], *self.cells[p].anchor) for p in self.part):
            cells = sorted(self.array(anchor))
            shape = self.calculate(self.tree(anchor), values).shape[1:]
            if any(size > len({p[n] for p in cells}) for n, size in enumerate(shape, 1)):
                yield cells, shape

    def is_array(self, places):
        """Whether some cells are of one array formula."""
        arrays = {(p[0], self.cells[p].anchor, id(self.trees.get(p))) if p in self.part else p for p in places}
        return len(arrays) == 1 and places[0] in self.part

    def unround(self):
        """Take the rounding off what is only shown, by cells that none uses but for a message: it is no slip.

        Nor is a π of six digits.
        """
        own = self.own  # of the formulas as the file has them
        precise = {id(tree): exact(tree, SIX_DIGITS) for tree in self.trees.values()}
        self.trees = {place: precise[id(tree)] for place, tree in self.trees.items()}
        for place in self.trees.keys() & own.keys() - self.part.keys():
            if self.messages.issuperset(self.used.get(place, ())):
                self.trees[place] = unrounded(self.trees[place])

    # Who uses whom.

    def value(self, place):
        """The number in a cell as the file holds it, texts such as 54,7356 included, or None."""
        return self.meant.get(place)

    def tree(self, place):
        """The formula in a cell; an empty text where there is none."""
        return self.trees.get(place, ("text", ""))

    def used_by(self, tree):
        """The places that a tree refers to."""
        return list(dict.fromkeys(place for area in areas(tree) for place in area.places))

    @cached_property
    def parts(self):
        """The parts of all formulas, as `walk` yields them."""
        return [part for tree in {id(t): t for t in self.trees.values()}.values() for part in walk(tree)]

    @cached_property
    def uses(self):
        """Place of a formula → the places it refers to, in order and without repetition."""
        trees = {id(t): t for t in self.trees.values()}
        self.count(sum(area.shape[0] * area.shape[1] for tree in trees.values() for area in areas(tree)))
        found = {id(tree): self.used_by(tree) for tree in trees.values()}
        return {place: found[id(tree)] for place, tree in self.trees.items()}

    @cached_property
    def used(self):
        """Place → the formulas that refer to it."""
        found = {}
        for place, sources in self.uses.items():
            for source in sources:
                found.setdefault(source, []).append(place)
        return found

    @cached_property
    def messages(self):
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
    def texts(self):
        """The places of texts that are typed."""
        return {
            p for p, cell in self.cells.items() if isinstance(cell.value, str) and not (cell.formula or cell.error)
        }

    @cached_property
    def errors(self):
        """The places that show an error such as #DIV/0!, typed, stored or at the sheet's own inputs.

        And texts that a formula gives which gives numbers elsewhere.
        """
        shown = self.trees.keys() - self.downstream(self.not_evaluated)
        no_number = {p for p in shown if self.own.get(p) is not None and not np.isfinite(self.own[p])}
        forms = {self.form(p) for p in self.trees.keys() - self.messages}
        texts = {p for p in self.messages & self.trees.keys() if self.cells[p].value and self.form(p) in forms}
        return {p for p, cell in self.cells.items() if cell.error} | no_number - self.messages | texts

    @cached_property
    def not_evaluated(self):
        """The places of formulas of which a function is not known here."""
        known = {*FUNCTIONS, "number", "text", "area"}
        return {*self.unread, *(place for place, tree in self.trees.items() if heads(tree) - known)}

    @cached_property
    def order(self):
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
    def _position(self):
        """Place of a formula → where it stands in `order`."""
        return {place: n for n, place in enumerate(self.order)}

    @cached_property
    def level(self):
        """Place of a formula → the length of the longest chain of formulas that leads to it."""
        found = {}
        for place in self.order:
            found[place] = 1 + max((found.get(source, 0) for source in self.uses[place]), default=0)
        return found

    @cached_property
    def components(self):
        """Numbers and formulas that hang together edge to edge, as they are read."""
        found, left = [], {p for p, cell in self.cells.items() if cell.formula or self.meant[p] is not None}
        for place in sorted(left, key=self.reading_order):
            if place in left:
                near = self._reached([place], lambda p, left=left: left.intersection(beside(p)))
                left -= near
                found.append(tuple(sorted(near, key=self.reading_order)))
        return found

    @cached_property
    def component(self):
        """Place of a number or formula → the component that it is of."""
        return {place: component for component in self.components for place in component}

    def form(self, place):
        """The formula of a cell as text with all references of one size alike, or None."""
        if place not in self.trees:
            return None
        tree = self.trees[place]
        if id(tree) not in self._forms:
            self._forms[id(tree)] = form_of(tree), tree  # as long as the tree is kept no other has its id
        return self._forms[id(tree)][0]

    def upstream(self, places, given=()):
        """Everything that `places` depend on, themselves included; not what those `given` depend on."""
        links = self.uses.get
        return self._reached(places, (lambda place: None if place in given else links(place)) if given else links)

    def downstream(self, places):
        """Everything that depends on `places`, themselves included."""
        return self._reached(places, self.used.get)

    def _reached(self, places, links):
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

    # Values.

    def run(self, given, base=None, only=None, functions=FUNCTIONS, put=()):
        """Evaluate the formulas, all or `only` some: place → array of shape (samples,).

        `given` has values in place of the file's, of typed numbers and of formulas; `base` is an earlier run, of
        which the places not in `only` are kept; `put` has the places that hold something else at some samples: at
        which, and what.
        """
        values, arrays, order = {**(base or {}), **given}, {}, self.order
        if only is not None and 8 * len(only) < len(order):
            order = sorted((p for p in only if p in self.trees), key=self._position.get)
        for place in order:
            if place in given or (only is not None and place not in only):
                continue
            self.work += 1
            tree, index = self.trees[place], self.part.get(place)
            if index is None:
                values[place] = self.calculate(tree, values, functions)[:, 0, 0]
            else:
                key = id(tree), self.cells[place].anchor
                if key not in arrays:
                    arrays[key] = self.calculate(tree, values, functions)
                values[place] = at(arrays[key], index)
            if place in put:
                values[place] = np.where(*put[place], values[place])
        return values

    def run_each(self, options, given, base, only):
        """Evaluate `only` some formulas for each of some options, place → values, in one pass: side by side.

        Returns place → array of shape (options, samples), of those and of what the options hold. `given` and `base`
        are as in `run`.
        """
        size, put = len(options) * SAMPLES, {}
        for n, option in enumerate(options):
            for place, value in option.items():
                where, held = put.setdefault(place, (np.zeros(size, bool), np.zeros(size)))
                where[n * SAMPLES : (n + 1) * SAMPLES] = True
                held[n * SAMPLES : (n + 1) * SAMPLES] = value
        used = {source for place in only for source in self.uses.get(place, ())}
        wide = {
            place: np.tile(at_samples(base[place] if place not in given else given[place]), len(options))
            for place in {*used, *only, *put}
            if place in given or place in base
        }
        fixed = {place: wide[place] for place in wide if place in given}
        for place in put:
            if place in given or place not in self.trees:
                fixed[place] = np.where(*put[place], wide.get(place, self.constants.get(place, ZERO)))
        found = self.run(fixed, wide, only, put=put)
        places = (place for place in {*only, *put} if place in found)
        return {place: np.broadcast_to(found[place], size).reshape(-1, SAMPLES) for place in places}

    @cached_property
    def own(self):
        """Place → the number that stands there, or that the formula gives with the file's inputs; None for text."""
        return self.meant | {place: float(values[0]) for place, values in self.run({}).items()}

    def cell(self, place, values, tree=None, held=()):
        """What the formula of a cell gives, or `tree` in its place: shape (samples,) or (1,)."""
        return at(self.calculate(tree or self.trees[place], values, held=held), self.part.get(place, (0, 0)))

    def calculate(self, tree, values, functions=FUNCTIONS, held=()):
        """Return the value of a tree, shape (samples, rows, columns), from those of the cells; NaN if none."""
        try:
            with np.errstate(all="ignore"):
                return evaluate(tree, partial(self.look, values=values), functions, held)
        except NotUnderstood:
            return np.full((1, 1, 1), np.nan)

    def parts_at(self, tree, values):
        """The values of all parts of a tree, by their identity, for formulas that share most parts with it."""
        held = {}
        for part in [*parts_of(tree)][::-1]:
            with suppress(NotUnderstood):
                held[id(part)] = evaluate(part, partial(self.look, values=values), held=held)
        return held

    def look(self, area, values, *, numbers_only=False):
        """The values of an area, shape (samples, rows, columns): 0 for an empty cell, NaN for text.

        With `numbers_only` both are left out, texts such as 54,7356 as well, and the others are in one row; where
        none is left, as in an average of texts, it is NaN.
        """
        constants = self.constants
        numbers = [values[p] if p in values else constants.get(p, ZERO) for p in area.places]
        if numbers_only:
            held = self.texts
            there = [p not in held and (p in values or p in constants) for p in area.places]
            numbers = [number for number, is_there in zip(numbers, there, strict=True) if is_there] or [NOTHING]
        return self._stacked(numbers, (1, len(numbers)) if numbers_only else area.shape)

    @staticmethod
    def _stacked(numbers, shape):
        """Values of several cells as one array, shape (samples, rows, columns)."""
        if len(numbers) == 1:
            return numbers[0][:, None, None]
        found = np.empty((max(map(len, numbers)), len(numbers)), max(n.dtype for n in numbers))
        for k, number in enumerate(numbers):
            found[:, k] = number
        return found.reshape(len(found), *shape)

    @cached_property
    def constants(self):
        """Place of a cell that is not calculated → what it holds, shape (1,), NaN for text."""
        held = {p: None if p in self.trees else n for p, n in self.meant.items()}
        empty = {p for p, cell in self.cells.items() if cell.value is None and not cell.formula}
        return {p: np.full(1, np.nan if n is None else n) for p, n in held.items() if p not in empty}


def at_samples(value):
    """A value at every sample, shape (samples,)."""
    return value if len(value) == SAMPLES else np.broadcast_to(value, SAMPLES)


def beside(place):
    """The four places beside a place."""
    sheet, row, column = place
    return [(sheet, row + down, column + right) for down, right in ((1, 0), (-1, 0), (0, 1), (0, -1))]


def offset(place, down, right):
    """The place so many rows further down and columns further right."""
    return place[0], place[1] + down, place[2] + right


def at(array, index):
    """The entry of an array formula's value in one of its cells; a single row or column is repeated."""
    row, column = (i if size > 1 else 0 for i, size in zip(index, array.shape[1:], strict=True))
    inside = row < array.shape[1] and column < array.shape[2]
    return array[:, row, column] if inside else np.full(len(array), np.nan)


def same(a, b, tolerance=CLOSE):
    """Whether two values agree at every sample; at the first, the sheet's own, either may be unknown, NaN."""
    last_a, last_b = (np.asarray(values).item(-1) for values in (a, b))
    if abs(last_a - last_b) > tolerance * (1 + abs(last_b)):  # most that differ do here, and it costs least
        return False
    fine = np.abs(a - b) <= tolerance * (1 + np.minimum(np.abs(a), np.abs(b)))  # no number is close to infinity
    if len(fine) == 1 or not fine[1:].all():
        return bool(fine.all())
    return bool((fine[0] | ~np.isfinite((a + b)[0])).all())
