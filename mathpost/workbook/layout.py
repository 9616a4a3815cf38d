"""Where things stand in somebody's worksheet: angles, point, matrices and result, by label, name or address.

Labels in the cells beside or above (α, 矩阵γβ, x', matrix gamma beta …), named ranges and what the caller says all
go through `mathpost.workbook.label.read_label`; what is left here is geometry.
"""

import re
from dataclasses import dataclass

import numpy as np
from openpyxl.utils import range_boundaries

from mathpost.errors import InputError
from mathpost.workbook.file import Sheet, local_address
from mathpost.workbook.label import Role, read_label

SINGLE = {"angle": "angles", "coordinate": "point", "outcome": "result"}
UNIT_WORDS = {"=", ":", "°", "deg", "degree", "degrees", "度", "mm", "rad", "弧度", "->", "→", "："}


@dataclass(frozen=True)
class Found:
    """A range with its role: the places of its cells as an object array of (row, column), and of which section."""

    role: Role
    sheet: Sheet
    places: np.ndarray
    section: int | None = None

    @property
    def anchor(self):
        return self.places.flat[0]


def find(book, cells=None):
    """Return all `Found` ranges of the book in reading order; `cells` maps names to addresses and goes first."""
    found = []
    for name, address in (cells or {}).items():
        found.append(_named_by_caller(book, name, address))
    named = [each for name, area in sorted(book.names.items()) if (each := _named_range(book, name, area))]
    taken = {each.role for each in found}
    if any(each.section is not None for each in named):
        found += [each for each in named if each.role not in taken]
    else:
        labelled = [each for sheet in book.sheets for each in _labelled(sheet)]
        by_name = {each.role for each in named if each.role not in taken}
        found += [each for each in named if each.role in by_name]
        found += [each for each in labelled if each.role not in taken | by_name]
    order = {sheet.name: n for n, sheet in enumerate(book.sheets)}
    return sorted(_split_vectors(found), key=lambda each: (order[each.sheet.name], each.anchor))


def _split_vectors(found):
    """Angles, point and result as single cells, so that all layouts look the same from here."""
    single = {vector: one for one, vector in SINGLE.items()}
    for each in found:
        if each.role.kind in single:
            for n in range(3):
                place = np.empty((), dtype=object)
                place[()] = each.places[n]
                yield Found(Role(single[each.role.kind], (n,)), each.sheet, place, each.section)
        else:
            yield each


def _named_by_caller(book, name, address):
    role = read_label(name)
    where = f"cells, {name!r}"
    if role is not None and role.kind == "angle" and ":" in str(address):
        role = Role("matrix", role.word)
    if role is None:
        raise InputError(where, "angles, point, result, α, x, x', or a matrix such as γβα", repr(name))
    sheet, first, last = read_area(book, where, address)
    places = _shaped(role, first, last)
    if places is None:
        expected = {(3, 3): "3 by 3 cells", (3,): "3 cells in a row or a column", (): "one cell"}[role.shape]
        raise InputError(where, expected, repr(address))
    return Found(role, sheet, places)


def read_area(book, where, address):
    """Return the sheet and the corners of an address such as ``Sheet1!B2:B4``; `where` begins the error."""
    sheet_name, _, area = str(address).rpartition("!")
    sheet = book.sheet(sheet_name.strip("'")) if sheet_name else book.sheets[0]
    try:
        left, top, right, bottom = range_boundaries(area.replace("$", "").upper())
    except (ValueError, TypeError):
        left = None
    if left is None or None in (top, right, bottom):
        raise InputError(where, "an address such as B2:B4 or Sheet1!B2", repr(address))
    return sheet, (top, left), (bottom, right)


def _named_range(book, name, area):
    sheet_name, first, last = area
    section = re.match(r"(?:recipe|method|m)_?([12])_", name.lower())
    role = read_label(name[section.end() :] if section else name)
    if role is None or not any(sheet.name == sheet_name for sheet in book.sheets):
        return None
    if role.kind == "angle" and first != last:
        role = Role("matrix", role.word)
    places = _shaped(role, first, last)
    return None if places is None else Found(role, book.sheet(sheet_name), places, section and int(section[1]) - 1)


def _shaped(role, first, last):
    """The places from `first` to `last` in the shape of the role, or None if they do not have it."""
    rows, columns = last[0] - first[0] + 1, last[1] - first[1] + 1
    if (rows, columns) not in {(): {(1, 1)}, (3,): {(1, 3), (3, 1)}, (3, 3): {(3, 3)}}[role.shape]:
        return None
    return _array([(r, c) for r in range(first[0], last[0] + 1) for c in range(first[1], last[1] + 1)], role.shape)


def _array(places, shape):
    array = np.empty(len(places), dtype=object)
    array[:] = places
    return array.reshape(shape)


def _labelled(sheet):
    """Everything that labels in the sheet point to."""
    labels = {}
    for place, cell in sheet.cells.items():
        role = read_label(cell.value) if isinstance(cell.value, str) and not cell.error else None
        if role:
            labels[place] = role
    grid = _Grid(sheet, labels)
    matrices, used = {}, set()
    for place, role in sorted(labels.items()):
        if role.kind in ("matrix", "transposed", "angle"):
            block = grid.block(place, used)
            if block is not None:
                as_matrix = Role("matrix", role.word) if role.kind == "angle" else role
                matrices[place] = Found(as_matrix, sheet, block)
                used.update(block.flat)
    rest = {place: role for place, role in labels.items() if place not in matrices}
    yield from matrices.values()
    yield from grid.scalars(rest, used)
    for place, role in rest.items():
        if role.shape == (3,):
            vector = grid.vector(place, used)
            if vector is not None:
                yield Found(role, sheet, vector)


@dataclass(frozen=True)
class _Grid:
    """The neighbourhood of labels: steps over merged ranges, and over units such as °."""

    sheet: Sheet
    labels: dict

    def right(self, place):
        return (place[0], self.sheet.spans.get(place, place)[1] + 1)

    def below(self, place):
        return (self.sheet.spans.get(place, place)[0] + 1, place[1])

    def is_value(self, place):
        """Whether a number stands here, or what should have been one: not a label, a unit or nothing."""
        cell = self.sheet.cells.get(place)
        if cell is None or place in self.labels:
            return False
        return not isinstance(cell.value, str) or cell.error or bool(re.search(r"\d", cell.value) or cell.formula)

    def block(self, label, used):
        """The nine places of the matrix that a label names: below it, to the right, or around its middle."""
        row, column = label
        kind = self.labels[label].kind
        if kind == "angle" and any(
            near in self.labels and self.labels[near].kind == kind
            for near in ((row - 1, column), (row + 1, column), (row, column - 1), (row, column + 1))
        ):
            return None  # a list of the angles, not the heading of a matrix
        below, right = self.below(label), self.right(label)
        starts = [below, right, (below[0], column - 1), (row - 1, right[1]), (below[0], column - 2)]
        starts += [(below[0] + 1, column), (row, right[1] + 1), (below[0], column + 1), (row - 1, right[1] + 1)]
        for start in starts:
            if start[0] < 1 or start[1] < 1 or not self.is_value(start):
                continue
            block = self.nine(start)
            if (
                used.isdisjoint(block.flat)
                and sum(map(self.is_value, block.flat)) >= 7
                and self.is_corner(start, used)
            ):
                return block
        return None

    def nine(self, start):
        places, first = [], start
        for _ in range(3):
            place = first
            for _ in range(3):
                places.append(place)
                place = self.right(place)
            first = self.below(first)
        return _array(places, (3, 3))

    def is_corner(self, start, used):
        """Whether no other value touches the corner from the left or above, so that the block starts here."""
        row, column = start
        return not any(self.is_value(p) and p not in used for p in ((row, column - 1), (row - 1, column)))

    def scalars(self, labels, used):
        """Single cells: labels of one kind are read together, all with the value on the right or all below."""
        groups = {}
        for place, role in sorted(labels.items()):
            if role.shape == ():
                run = groups.setdefault(role.kind, [])
                if not run or role in (r for _, r in run[-1]):
                    run.append([])
                run[-1].append((place, role))
        for run in (run for runs in groups.values() for run in runs):
            ways = [{p: self.next_value(p, step) for p, _ in run} for step in (self.right, self.below)]
            counts = [sum(v is not None and v not in used for v in way.values()) for way in ways]
            chosen = ways[0] if counts[0] >= counts[1] else ways[1]
            for place, role in run:
                if chosen[place] is not None:
                    yield Found(role, self.sheet, _array([chosen[place]], ()))

    def next_value(self, place, step):
        for _ in range(3):
            place = step(place)
            cell = self.sheet.cells.get(place)
            if self.is_value(place):
                return place
            is_unit = cell is not None and isinstance(cell.value, str) and cell.value.strip().lower() in UNIT_WORDS
            if cell is not None and not is_unit:
                # Text where the number should be, unless it is the next label.
                return None if place in self.labels else place
        return None

    def vector(self, label, used):
        """Three values in a row to the right or below, or in a column below or to the right of a label."""
        for first, step in (
            (self.right(label), self.right),
            (self.below(label), self.below),
            (self.below(label), self.right),
            (self.right(label), self.below),
        ):
            places = [first, step(first), step(step(first))]
            if all(self.is_value(p) and p not in used for p in places) and not self.is_value(step(places[-1])):
                return _array(places, (3,))
        return None


def describe(found, index=None):
    """Return the role and, of a matrix, the row and column: ``matrix γβ, row 1, column 2``."""
    if index is None or found.places.ndim < 2:
        return str(found.role)
    return f"{found.role}, row {index[0] + 1}, column {index[1] + 1}"


def place_text(found):
    """Return the range of a found item as ``Sheet!B5:D7``."""
    first, last = found.places.flat[0], found.places.flat[-1]
    text = found.sheet.address(first)
    return text if first == last else f"{text}:{local_address(last)}"
