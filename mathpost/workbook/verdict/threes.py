"""Which threes of numbers a rotation takes to which, where no label says it: told by the numbers.

Three numbers are the angles whose rotation takes most other threes to threes in line with each other, to their
digits. Those that stand in line with these and are not taken there are wrong.
"""

from collections import Counter, defaultdict
from functools import reduce
from itertools import permutations, product
from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from mathpost.detective.misreadings import elementary, written_decimals

CANDIDATES, MOST, STRIPS = 200, 1000, 20  # so many threes may be angles, may be points; strips of angles in rows
FULL = 9  # decimals of a number that was not rounded
MANY = 6  # numbers, of which one may have more decimals by mistake
FEW = 8  # threes, of which one that becomes another tells the angles
LEAST = 2  # decimals of a result: fewer agree by luck
NEAR = 1e-3  # of the entries of a matrix


def common_decimals(numbers):
    """The most decimals that some numbers are written to; of many numbers, more than one of them."""
    counts = Counter(written_decimals(number) for number in numbers if number % 1)
    least = 2 if counts.total() >= MANY else 1
    return max((decimals for decimals, count in counts.items() if count >= least), default=0)


def words(found):
    """All products of neighbours among the elementary matrices, as which angles they turn by from left to right."""
    order = (2, 1, 0) if found.sequence.isupper() != found.active else (0, 1, 2)
    return [order[a : a + size] for size in (1, 2, 3) for a in range(4 - size)]


class Three(NamedTuple):
    """Three numbers in line, of a strip of such side by side: the sheet, which way it goes, where it stands."""

    places: tuple
    strip: tuple
    index: int


class Operator(NamedTuple):
    """What may become of a point: a matrix, of nine places, about an origin; without a matrix only a difference."""

    matrix: np.ndarray
    places: tuple = ()
    origin: tuple = ()
    half: float = 0.0  # of the last digit of the matrix


class Threes:
    """The threes of a sheet of numbers, but for cells `taken`; `found` says sequence, convention and labels.

    x, y and z are where the headings say; with `exchanged`, two or three of a point or of a result may stand under
    each other's. `links` are (point, result, operator) of all that stand in line with those that fit.
    """

    def __init__(self, graph, found, taken, exchanged=False):
        self.graph, self.found, self.links = graph, found, []
        self.orders = [([0, 1, 2], [0, 1, 2])]
        if exchanged:
            others = [list(order) for order in permutations(range(3))][1:]
            self.orders = [each for order in others for each in ((order, [0, 1, 2]), ([0, 1, 2], order))]
        left = {p for p in graph.component if p not in taken and graph.value(p) is not None}
        self.threes = []
        for place, along in product(sorted(left, key=graph.reading_order), (1, 2)):
            places = tuple((place[0], place[1] + n * (along == 2), place[2] + n * (along == 1)) for n in range(3))
            if left.issuperset(places) and len(self.threes) < MOST:
                places = found.as_named(places, ("coordinate", "outcome"))
                self.threes.append(Three(places, (place[0], along, place[3 - along]), place[along]))
        self.values = np.array([self.look(three.places) for three in self.threes]).reshape(-1, 3)
        self.telling = np.count_nonzero(self.values, axis=1) > 1  # a vector along an axis agrees by luck
        self.decimals, self.half = np.zeros(len(self.threes)), np.ones(len(self.threes))
        self.strips, alike = defaultdict(dict), defaultdict(list)
        for n, three in enumerate(self.threes):
            self.strips[three.strip][three.index] = n
            alike[three.strip, graph.component[three.places[0]]].append(n)
        for members in alike.values():
            self.decimals[members] = min(common_decimals(self.values[members].ravel()), FULL)
            least = 1e-9 * (1 + np.abs(self.values[members]).max())
            self.half[members] = np.maximum(0.51 * 10.0 ** -self.decimals[members], least)

    def look(self, places):
        """The numbers in some cells."""
        return np.array([self.graph.value(p) for p in places], dtype=float)

    def products(self, radians):
        """Word → matrix, of three angles."""
        active, sequence = self.found.active, self.found.sequence
        single = [elementary(a, -t if active else t) for a, t in zip(sequence.upper(), radians, strict=True)]
        return {word: reduce(np.matmul, [single[n] for n in word]) for word in words(self.found)}

    def _turned(self, matrix):
        """A matrix, shape (…, 3, 3); or such as it is for what stands under each other's headings."""
        return [matrix[..., rows, :][..., columns] for rows, columns in self.orders]

    def angles(self, named=None):
        """The cells of the angles that take most threes to others, and the radians of 1; None if none does."""
        tree, best = cKDTree(self.values), (0, None)
        for cells in [named] if named else [three.places for three in self.threes[:CANDIDATES]]:
            numbers = self.look(cells)
            for radians in (np.pi / 180, 1.0) if numbers.any() and np.abs(numbers).max() <= 360 else ():
                matrix = [*self.products(numbers * radians).values()][-1]
                shown = bool((tree.query(matrix, p=np.inf)[0] < NEAR).all())
                for turned in self._turned(matrix):
                    made = self.values @ turned.T
                    off, nearest = tree.query(made, p=np.inf)
                    fits = (off <= self.half[nearest]) & self._may_follow(slice(None), nearest)
                    fits &= (np.abs(made - self.values).max(axis=1) > 0.1) & self.telling
                    best = max(best, (int(fits.sum()) + 3 * shown, (cells, radians)), key=lambda each: each[0])
        return best[1] if named or best[0] > 1 or len(self.threes) <= FEW else None

    def matrices(self, known):
        """(Word, places) of nine numbers, row by row, that but for two are a product of elementary matrices."""
        taken, found = set(), []
        for three in self.threes:
            places = tuple((p[0], p[1] + n, p[2]) for n in range(3) for p in three.places)
            if three.strip[1] == 1 and taken.isdisjoint(places) and None not in map(self.graph.value, places):
                fits = {w: (np.abs(self.look(places) - m.ravel()) < NEAR).sum() for w, m in known.items()}
                if fits[best := max(fits, key=fits.get)] >= 7:
                    taken.update(places)
                    found.append((best, places))
        return found

    # What becomes of what.

    def _may_follow(self, point, result):
        """Whether some threes may be calculated from others: of more decimals than these, or as many and later."""
        more, as_many = self.decimals[result] > self.decimals[point], self.decimals[result] == self.decimals[point]
        later = np.arange(len(self.threes))[result] > np.arange(len(self.threes))[point]
        return (self.decimals[result] >= LEAST) & (more | (as_many & later))

    def link(self, operators, done):
        """Find which strips become which by the operators; `done` are cells that are told already."""
        found = []
        variants = [(n, op._replace(matrix=m)) for n, op in enumerate(operators) for m in self._turned(op.matrix)]
        for n, operator in variants:
            for (start, end, step), rows in self._fits(operator).items():
                apart = abs(start[2] - end[2]) + abs(step) + 99 * (start[0] != end[0])
                found.append((-len(rows), apart, n, start, end, step, rows))
        for _, _, n, start, end, step, rows in sorted(found, key=lambda each: each[:3]):
            pairs = [
                (self.strips[start][k], self.strips[end].get(k + step)) for k in _run(self.strips[start], rows)
            ]
            pairs = [(i, j) for i, j in pairs if j is not None]
            results = {p for _, j in pairs for p in self.threes[j].places}
            single = len(pairs) == 1 and self.decimals[pairs[0][1]] > LEAST
            most = 2 * len(rows) > sum(self.values[i].any() for i, _ in pairs)
            if not (most and (len(rows) > 1 or single)) or done.issuperset(results):
                continue
            for i, j in pairs:
                if done.isdisjoint(self.threes[j].places):
                    self.links.append((self.threes[i].places, self.threes[j].places, operators[n]))
            done = done | results

    def _fits(self, operator):
        """(Strip of points, strip of results, step) → the numbers in the first that become those in the other."""
        moved = self.values - (self.look(operator.origin) if operator.origin else 0.0)
        made = moved @ operator.matrix.T
        # Points that are results themselves.
        late = (self.decimals > LEAST)[:, None] & (self.decimals[:, None] >= self.decimals)
        slack = self.half + late * 1.8 * self.half[:, None] + operator.half * np.abs(moved).sum(axis=1)[:, None]
        off = np.abs(self.values - made[:, None]).max(axis=2)
        changed = np.abs(made - self.values).max(axis=1) > 0.01
        each = np.arange(len(made))
        fits = (off <= slack) & changed[:, None] & self._may_follow(each[:, None], each)
        found = defaultdict(list)
        for i, j in zip(*np.nonzero(fits), strict=True):
            a, b = self.threes[i], self.threes[j]
            if set(a.places).isdisjoint(b.places):
                found[a.strip, b.strip, b.index - a.index].append(a.index)
        return {key: rows for key, rows in found.items() if any(self.telling[self.strips[key[0]][k]] for k in rows)}

    def link_rows(self):
        """(Angles, their radians of 1, point, result) of each row, where every row has angles of its own."""
        strips, best = [strip for strip, members in self.strips.items() if len(members) > 2][:STRIPS], (0, [])
        for start, radians in product(strips, (np.pi / 180, 1.0)):
            own = {k: self.values[n] * radians for k, n in self.strips[start].items()}
            matrices = {k: [*self.products(angles).values()][-1] for k, angles in own.items()}
            for point, result in product(strips, repeat=2):
                a, b, c = sorted(s[2] for s in (start, point, result))
                if min(b - a, c - b) < 3 or len({s[:2] for s in (start, point, result)}) > 1:
                    continue
                members = [self.strips[s] for s in (start, point, result)]
                rows = sorted(members[0].keys() & members[1].keys() & members[2].keys())
                if len(rows) < 3:
                    continue
                i, j = ([each[k] for k in rows] for each in members[1:])
                for turned in self._turned(np.array([matrices[k] for k in rows])):
                    made = np.einsum("nij,nj->ni", turned, self.values[i])
                    fits = (np.abs(made - self.values[j]).max(axis=1) <= self.half[j]) & self._may_follow(i, j)
                    if fits.sum() > max(best[0], 2, len(rows) / 2):
                        places = [tuple(self.threes[each[k]].places for each in members) for k in rows]
                        best = fits.sum(), [(angles, radians, *others) for angles, *others in places]
        return best[1]


def _run(members, rows):
    """The numbers in a strip from the first of `rows` to the last, and those that follow without a gap."""
    first, last = min(rows), max(rows)
    while first - 1 in members:
        first -= 1
    while last + 1 in members:
        last += 1
    return [k for k in sorted(members) if first <= k <= last]
