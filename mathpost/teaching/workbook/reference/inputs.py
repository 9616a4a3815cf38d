"""The inputs of a reference found in a hand-in: by value, then by place in a list, then by label."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import partial
from itertools import product

import numpy as np

from mathpost.teaching.workbook.reference.matched import ALIKE, Matched, in_unit, near, runs, scale_of, telling
from mathpost.teaching.workbook.reference.quantities import Sheet, likeness, plain
from mathpost.teaching.workbook.reference.roles import Inputs, by_role
from mathpost.teaching.workbook.sheet.place import Line, Place

UNITS = (np.pi / 180, 180 / np.pi, 1 / 25.4, 25.4)  # of an input that a hand-in has in radians or inch
COMMON = frozenset(
    map(float, (-1, 0, 1, 2, 3, 10, 60, 90, 100, 180, 360, 1000, 3600))
)  # a formula has these as well
PLAIN = frozenset(map(float, (-1, 0, 1, 60, 180, 360, 1000, 3600)))  # no input if a hand-in has none
LIKE = 0.4  # of labels that may mean the same
CLEARLY = 0.15  # by how much the best must be better than the next


def match(
    reference: Sheet, inputs: Sequence[Place], handed_in: Sheet, told: Mapping[Place, Place] | None = None
) -> Matched:
    """Find the inputs of a reference in a hand-in; those that nothing tells stay open."""
    matcher = _Matcher(reference, inputs, handed_in, told or {})
    found, numbers = matcher.found, reference.numbers_typed
    matcher.lists_of_equal_numbers()
    equal = {*found.cells}
    matcher.lists_of_a_label()
    other = {*found.cells} - equal
    for own_numbers in (False, True):
        matcher.settle(lambda place, number: near(numbers[place], number))
        for factor in UNITS:
            before = {*found.cells}
            matcher.settle(partial(in_unit, numbers, factor))
            found.factor |= dict.fromkeys(found.cells.keys() - before, factor)
        if own_numbers or not matcher.has_own_numbers():
            break
        matcher.by_role(equal | other)
    theirs = handed_in.numbers_typed
    before = {p for p, cells in found.cells.items() if p not in other and near(numbers[p], theirs[cells[0]])}
    before |= found.factor.keys()
    matcher.take_named()
    matcher.settle(None)
    matcher.by_shape()
    found.other = {place: found.cells[place][0] for place in found.cells if place not in before}
    own = {p: c for p, c in found.other.items() if p not in matcher.told and p not in other}
    found.weak = {p for p, c in own.items() if p not in matcher.named and not matcher.likely(p, c)}
    found.scale = {p: scale for p, c in own.items() if (scale := scale_of(theirs[c], numbers[p]))}
    found.open = [place for place in matcher.left if numbers[place] not in PLAIN]
    matcher.copies()
    return found


class _Matcher:
    """Candidates of each input, of which that is taken which clearly has the most of labels and neighbours."""

    def __init__(
        self, reference: Sheet, inputs: Sequence[Place], handed_in: Sheet, told: Mapping[Place, Place]
    ) -> None:
        self.reference, self.handed_in, self.inputs = reference, handed_in, inputs
        self.numbers, self.found = handed_in.numbers_typed, Matched()
        cells = list(self.numbers)
        self.free = [p for p in cells if p in handed_in.used] + [p for p in cells if p not in handed_in.used]
        self.runs = list(runs(inputs)), list(runs(cells))
        self.votes: dict[tuple, Counter] = defaultdict(Counter)
        self.likeness: dict[tuple, float] = {}
        self.named, self.told = self._named(), told
        self.names = {cell: place for place, cell in self.named.items()}
        self.take((place, cell) for place, cell in told.items() if place in inputs and cell in self.numbers)

    def _named(self) -> dict[Place, Place]:
        """Input → the number of the hand-in with the same label, where no other has it here or there."""
        here, there = (
            _alone(sheet, places) for sheet, places in ((self.reference, self.inputs), (self.handed_in, self.free))
        )
        return {place: there[text] for text, place in here.items() if text in there}

    def may_be(self, place: Place, cell: Place) -> bool:
        """Whether no label says that an input is another cell, or that a cell is another input."""
        return self.named.get(place, cell) == cell and self.names.get(cell, place) == place

    @property
    def left(self) -> list[Place]:
        """The inputs that are not found yet."""
        return [place for place in self.inputs if place not in self.found.cells]

    def take(self, pairs: Iterable[tuple[Place, Place]]) -> None:
        """Take cells for inputs, and remember which row or column goes with which."""
        for place, cell in pairs:
            self.found.cells[place] = [cell]
            for line in _lines(place):
                for other in _lines(cell):
                    self.votes[line][other] += 1

    def score(self, place: Place, cell: Place) -> float:
        """How well a cell goes with an input: by labels, and by the lists in which those beside it were found."""
        labels = self.reference.labels[place], self.handed_in.labels[cell]
        if labels not in self.likeness:
            self.likeness[labels] = likeness(*labels)
        beside = sum(min(self.votes[a][b], 3) for a in _lines(place) for b in _lines(cell)) / 10
        return self.likeness[labels] + beside + 0.05 * (cell in self.handed_in.used)

    # Whole lists.

    def lists_of_equal_numbers(self) -> None:
        """Find lists in which the numbers are the same from the first to the last."""
        there: dict[tuple, list[Line]] = defaultdict(list)
        for line in self.runs[1]:
            there[tuple(float(f"{self.numbers[p]:.6g}") for p in line)].append(line)
        here = self.reference.numbers_typed
        self._lists(lambda line: there[tuple(float(f"{here[p]:.6g}") for p in line)])

    def lists_of_a_label(self) -> None:
        """Find a student's own lists: as long, with the same label, and the same labels all along."""
        there: dict[tuple, list[Line]] = defaultdict(list)
        for line in self.runs[1]:
            for key in self._keys(self.handed_in, line):
                there[key].append(line)
        self._lists(lambda line: [found for key in self._keys(self.reference, line) for found in there[key]])

    @staticmethod
    def _keys(sheet: Sheet, line: Line) -> Iterator[tuple]:
        """What two lists must share: their label, their length, and the labels of what is in them."""
        head, along = (1, 0) if line[0][2] == line[1][2] else (0, 1)
        if heading := plain(sheet.labels[line[0]][head]):
            texts = [plain(sheet.labels[p][along]) for p in line]
            yield heading, tuple(texts if len({*texts}) == len(texts) else [""] * len(line))

    def _lists(self, candidates: Callable[[Line], list[Line]]) -> None:
        for line in sorted(self.runs[0], key=len, reverse=True):
            if any(place in self.found.cells for place in line):
                continue
            back = self.found.back
            free = [cells for cells in candidates(line) if back.keys().isdisjoint(cells)]
            if len(free) > 1:
                scores = sorted(((self.score(line[0], cells[0]), cells) for cells in free), reverse=True)
                free = [scores[0][1]] if scores[0][0] - scores[1][0] >= CLEARLY else []
            if free:
                self.take(zip(line, free[0], strict=True))

    # Single numbers.

    def settle(self, may_be: Callable[[Place, float], bool] | None) -> None:
        """Match what is clear, again and again, as what is found tells more; then equal numbers by their order."""
        groups = self._groups(may_be)
        while self._clear(groups, may_be is not None):
            pass
        if may_be is not None:
            self._in_order(groups)

    def _groups(self, may_be: Callable[[Place, float], bool] | None) -> dict[Place, list[Place]]:
        """The cells that each input may be."""
        back = self.found.back
        free, left = [cell for cell in self.free if cell not in back], self.left
        if may_be is None:
            if len(left) * len(free) > 10_000:  # of which nobody could say
                return {}
            used = [cell for cell in free if cell in self.handed_in.used]
            return {place: used for place in left}
        alike: dict[float, list[Place]] = defaultdict(list)
        for cell in free:
            alike[self.numbers[cell]].append(cell)
        numbers = self.reference.numbers_typed
        one = {numbers[place]: place for place in left}
        may = {number: [n for n in alike if may_be(place, n)] for number, place in one.items()}
        return {
            place: [cell for n in may[numbers[place]] for cell in alike[n] if self.may_be(place, cell)]
            for place in left
        }

    def _clear(self, groups: Mapping[Place, list[Place]], by_value: bool) -> bool:
        """Match the inputs of which one cell is clearly the best, and which are clearly that cell's best."""
        taken, wishes = self.found.back, defaultdict(list)
        for place in self.left:
            cells = [cell for cell in groups.get(place, ()) if cell not in taken]
            scores = sorted(((self.score(place, cell), -n, cell) for n, cell in enumerate(cells)), reverse=True)
            if not scores:
                continue
            margin = scores[0][0] - scores[1][0] if len(scores) > 1 else np.inf
            is_common = by_value and self.reference.numbers_typed[place] in COMMON
            least = LIKE if not by_value else 0.2 if is_common else 0.0
            if margin >= CLEARLY and scores[0][0] >= least:
                wishes[scores[0][2]].append((scores[0][0], place))
        new = []
        for cell, places in wishes.items():
            places.sort(reverse=True)
            if len(places) == 1 or places[0][0] - places[1][0] >= CLEARLY:
                new.append((places[0][1], cell))
        self.take(new)
        return bool(new)

    def _in_order(self, groups: Mapping[Place, list[Place]]) -> None:
        """Equal numbers of which there are as many here as there, one after the other."""
        equal: dict[Line, list[Place]] = defaultdict(list)
        taken = self.found.back
        for place in self.left:
            equal[tuple(cell for cell in groups[place] if cell not in taken)].append(place)
        for cells, places in equal.items():
            if len(cells) == len(places) and abs(self.numbers.get(cells[0], 0.0) if cells else 0.0) not in (0, 1):
                self.take(zip(places, cells, strict=True))

    def has_own_numbers(self) -> bool:
        """Whether the numbers of some inputs are not in the hand-in."""
        return any(self.reference.numbers_typed[place] not in PLAIN for place in self.left)

    def take_named(self) -> None:
        """Match the inputs whose labels nothing else has."""
        back = self.found.back
        self.take((p, c) for p, c in self.named.items() if p not in self.found.cells and c not in back)

    def by_role(self, lists: set[Place]) -> None:
        """Match what does the same; single numbers of few digits, which may be equal by luck, are open again."""
        numbers, found = self.reference.numbers_typed, self.found
        for place in [p for p in found.cells if p not in lists and p not in self.told and not telling(numbers[p])]:
            del found.cells[place]
            found.factor.pop(place, None)
        self.take_named()
        known = {p: np.full(1, numbers[p]) for p in found.cells}
        theirs = {c: known[p] * found.factor.get(p, 1.0) for p, cells in found.cells.items() for c in cells}
        left = [p for p in self.left if abs(numbers[p]) not in (0, 1)]  # not the entries of a matrix
        free = [c for c in self.free if c in self.handed_in.used and c not in theirs]
        free = sorted((c for c in free if abs(self.numbers[c]) not in (0, 1)), key=self.handed_in.reading_order)
        pairs = by_role(Inputs(self.reference, left, known), Inputs(self.handed_in, free, theirs), self.likely)
        found.unsure = self.out_of_order([(p, c) for p, c in pairs if not self.likely(p, c)])
        self.take(pairs)

    def out_of_order(self, pairs: Sequence[tuple[Place, Place]]) -> list[Place]:
        """The inputs that nothing but their roles tells, and that stand in a different order here and there.

        A student who exchanged two inputs in a formula has them the other way round, too. Numbers of clearly
        different sizes tell which is which.
        """

        def across(place: Place) -> Place:
            return place[0], place[2], place[1]

        def apart(place: Place, cell: Place) -> float:
            ratio = self.numbers[cell] / self.reference.numbers_typed[place]
            return abs(np.log10(ratio)) if ratio > 0 else ALIKE

        ways = []
        for here, there in product((self.reference.reading_order, across), (self.handed_in.reading_order, across)):
            ordered = sorted(pairs, key=lambda pair: here(pair[0]))
            crossed = [
                (p, c, q, d) for n, (p, c) in enumerate(ordered) for q, d in ordered[:n] if there(c) < there(d)
            ]
            ways.append(
                [(p, q) for p, c, q, d in crossed if apart(p, d) + apart(q, c) < apart(p, c) + apart(q, d) + ALIKE]
            )
        return list(dict.fromkeys(place for pair in min(ways, key=len) for place in pair))

    def likely(self, place: Place, cell: Place) -> float:
        """How well a cell goes with an input that does the same: by what else is known, 0 if nothing is."""
        labels = likeness(self.reference.labels[place], self.handed_in.labels[cell])
        return labels + near(self.reference.numbers_typed[place], self.numbers[cell])

    def by_shape(self) -> None:
        """What is left of a row or column, where as many are left in the one that goes with it; or the only one."""
        for line in dict.fromkeys(line for place in self.left for line in _lines(place)):
            here = [p for p in self.left if line in _lines(p)]
            best = self.votes[line].most_common(1) if line in self.votes else []
            back = self.found.back
            cells = [c for c in self.free if best and best[0][0] in _lines(c) and c not in back]
            cells = [c for c in cells if c in self.handed_in.used]
            if here and len(here) == len(cells):
                self.take(zip(here, sorted(cells, key=self.handed_in.reading_order), strict=True))
        free = [c for c in self.free if c in self.handed_in.used and c not in self.found.back]
        if len(self.left) == 1 == len(free):
            self.take([(self.left[0], free[0])])

    def copies(self) -> None:
        """The same number with the same label again is the same input, on another worksheet as well."""
        back, labels = self.found.back, self.handed_in.labels
        again: dict[tuple, list[Place]] = defaultdict(list)
        for cell in self.free:
            if cell not in back and cell in self.handed_in.used:
                again[self.numbers[cell], labels[cell][0]].append(cell)
        for cells in self.found.cells.values():
            if labels[cells[0]][0]:
                cells += again.pop((self.numbers[cells[0]], labels[cells[0]][0]), [])


def _alone(sheet: Sheet, places: Sequence[Place]) -> dict[str, Place]:
    """Label → the one of some cells that has it."""
    found: dict[str, list[Place]] = defaultdict(list)
    for place in places:
        for text in dict.fromkeys(map(plain, sheet.labels[place])):
            found[text].append(place)
    return {text: named[0] for text, named in found.items() if text and len(named) == 1}


def _lines(place: Place) -> tuple[tuple, tuple]:
    """The row and the column in which a place is."""
    return ("row", *place[:2]), ("column", place[0], place[2])
