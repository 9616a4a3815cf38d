"""Which cells are vectors: linear in some lengths, in line, and which inputs each cell depends on."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable, Mapping, Sequence, Set
from itertools import combinations, count, product
from typing import TYPE_CHECKING

import numpy as np

from mathpost.teaching.workbook.meaning.given import Given
from mathpost.teaching.workbook.sheet.place import Line, offset

if TYPE_CHECKING:
    from mathpost.teaching.workbook.sheet.place import Place

MOVES = 300  # inputs of one formula: what is made of more is no coordinate
PAIRS = 400  # slopes that are compared


class Vectors(Given):
    """What becomes of the inputs of a workbook, `angles` and `lengths`, told by moving each alone.

    `depends` has the inputs on which a cell depends, `reaches` those to which its formulas lead; `vectors` are
    linear in lengths. For each vector, `unturned` has the slopes where all angles are 0, `turned` the slopes at the
    angles of the sheet, `unmoved` the lengths that are added after the turn, `curved` those it is not linear in.
    """

    vectors: set[Place]
    depends: dict[Place, Set[Place]]
    reaches: dict[Place, frozenset[Place]]
    unturned: dict[Place, dict[Place, float]]
    turned: dict[Place, dict[Place, float]]
    unmoved: dict[Place, set[Place]]
    curved: dict[Place, set[Place]]

    def _respond(self) -> None:
        """Find the inputs that each cell depends on, the cells that are linear in lengths, their slopes at angle 0.

        Each input is moved alone; inputs that no formula has in common move at once, so that a long
        table needs no more runs than a short one.
        """
        graph, inputs = self.graph, (*self.sorted(self.angles), *self.sorted(self.lengths))
        self.depends, self.reaches, self.unturned, self.turned, self.unmoved, self.curved = {}, {}, {}, {}, {}, {}
        together = {p: {p} for p in inputs}
        vast: set[Place] = set()
        for place in graph.order:
            sources = graph.uses[place]
            direct = frozenset(together.keys() & sources)
            reach = direct.union(*(self.reaches.get(s, ()) for s in sources if s not in together))
            vast |= {place} if len(reach) > MOVES or not vast.isdisjoint(sources) else set()
            self.reaches[place] = frozenset() if place in vast else reach
        for reach in dict.fromkeys(self.reaches.values()):
            graph.count(len(reach) ** 2)
            for place in reach:
                together[place] |= reach
        turn: dict[Place, int] = {}
        for place in inputs:
            taken = {turn.get(other) for other in together[place]}
            turn[place] = next(k for k in count(1) if k not in taken)
        size = 1 + max(turn.values())
        step = 11.0 + 3 * max((abs(graph.number(p)) for p in self.lengths), default=0)
        moved = {p: np.full(3 * size, graph.number(p) + 7.3 + 1.7 * k) for k, p in enumerate(inputs)}
        for place in inputs:
            n = turn[place]
            if place in self.angles:
                moved[place][n] += 11.0
                moved[place][2 * size :] = 1e-5  # all but nothing is turned
            else:
                moved[place][[n, size + n, 2 * size + n]] += [step, -step, step]
        values = graph.run(moved)
        for place in graph.order:
            reach, value = self.reaches[place], np.broadcast_to(values[place], 3 * size)
            change, lengths = np.abs(value - value[0]), reach & self.lengths
            if not np.isfinite(change[: 2 * size]).all() or place in vast:
                self.depends[place], linear = reach, True  # what it refers to is all that is known
            else:
                small = 1e-9 * (1 + abs(value[0]))
                self.depends[place] = {p for p in reach if change[turn[p]] > small}
                pairs = {p: (value[turn[p]], value[size + turn[p]]) for p in self.depends[place] & self.lengths}
                straight = {p for p, (a, b) in pairs.items() if abs(a + b - 2 * value[0]) <= 0.005 * abs(a - b)}
                self.curved[place] = pairs.keys() - straight
                linear = len(straight) >= len(self.curved[place])
            if linear and self.depends[place] & self.lengths and place not in self.typed | graph.messages:
                self.vectors.add(place)
                slopes = {p: (value[2 * size + turn[p]] - value[2 * size]) / step for p in lengths}
                self.unturned[place] = {p: round(slope, 3) for p, slope in slopes.items() if abs(slope) > 1e-3}
                turned = {p: (value[turn[p]] - value[0]) / step for p in lengths}
                self.turned[place] = turned
                self.unmoved[place] = {p for p, slope in turned.items() if abs(slope - 1) < 1e-9}

    def turned_by(self, places: Iterable[Place]) -> set[Place]:
        """The angles on which some cells depend."""
        return {s for p in places for s in self.depends.get(p, ()) if s in self.angles}

    def _of(self, places: Line, inputs: set[Place]) -> Line:
        """The inputs to which the formulas of some places lead, as they are read."""
        return self.sorted({s for p in places for s in self.reaches.get(p, ()) if s in inputs})

    def _triples(self) -> list[Line]:
        """Three cells, or four, in line that are a vector: they depend on the same lengths."""
        graph, left, found = self.graph, self.vectors - {p for window in self.windows for p in window}, {}
        shared = {}  # component → the lengths that most of its vectors depend on, as on an origin
        for whole in {id(graph.component[p]): graph.component[p] for p in left}.values():
            inside = left.intersection(whole)
            uses = Counter(s for p in inside for s in self.depends[p] & self.lengths)
            shared[whole] = {s for s, count in uses.items() if 2 * count > len(inside)}
        for place, (down, right), k in product(
            self.sorted(left), ((1, 0), (0, 1), (0, 2), (0, 3), (0, 4)), range(3)
        ):
            whole = self.graph.component[place]
            line = tuple(offset(place, (n - k) * down, (n - k) * right) for n in range(3))
            last = graph.own[whole[-1]]
            fourth = whole[-1] not in graph.messages and (last in (1, None) or np.isnan(last))  # 1, or an error
            fourth |= graph.is_array((whole[0], whole[-1])) or graph.form(whole[-1]) == graph.form(whole[0])
            if len(whole) == 4 and fourth and 1 in (len({p[n] for p in whole}) for n in (1, 2)):
                line = whole
            inside, apart = left.intersection(line), right > 1
            if not graph.messages.isdisjoint(line):
                continue
            if apart and (len(inside) < 3 or not left.isdisjoint(offset(line[0], 0, n) for n in range(1, right))):
                continue
            alone = len(whole) == 3 and len({*map(graph.form, line)}) == 1  # two that take empty cells by a slip
            if len(inside) >= 2 - alone and (apart or all(self.graph.component.get(p) is whole for p in line)):
                alike = self._alike(inside, shared[whole])
                same = self._in_order([self.unturned.get(p, {}) for p in line[:3]])
                along = 1 if line[0][1] < line[1][1] else 2
                lost = {p for p in line if p in graph.trees and not self.depends[p]}  # by a slip
                shape = not lost | inside >= set(line), apart, not graph.is_array(line)
                given = sum(p in self.lengths for p in line)  # what others are made of is no result
                rank = given, alike <= 0.4, -same, -len(inside), *shape
                found[line] = rank, (line[0][0], along, line[0][along]), -round(alike, 3)
        aligned: Counter = Counter()
        ways: Counter = Counter()
        taken: set[Place] = set()
        chosen: list[Line] = []
        for line, ((_, is_unlike, same, fewer, *_), run, _) in found.items():
            aligned[run] += fewer + same
            ways[graph.component[line[0]], run[1]] -= not is_unlike
        order = self.graph.reading_order

        def likeliest(line: Line) -> tuple:
            rank, run, alike = found[line]
            way = ways[graph.component[line[0]], run[1]]
            return rank, way, aligned[run], alike, *map(order, (line[0], line[-1]))

        for line in sorted(found, key=likeliest):
            if taken.isdisjoint(line):
                taken.update(line)
                chosen.append(line)
        return sorted(chosen, key=lambda t: order(t[0]))

    def _alike(self, places: Collection[Place], shared: set[Place]) -> float:
        """How much alike the lengths are of which two of some cells at most are made, but for `shared` ones."""
        sets = [self.lengths.intersection(self.depends[p]) for p in places]
        still = self.unmoved if self.turned_by(places) else {}
        turned = [cells - still.get(p, set()) for p, cells in zip(places, sets, strict=True)]
        own = [cells - shared for cells in turned]
        sets = next(filter(all, (own, turned)), sets)  # what is added after the turn is of each cell alone
        pairs = [(len(a & b), len(a | b)) for a, b in combinations(sets, 2)]
        return all(both for both, _ in pairs) and max((both / either for both, either in pairs), default=1)

    @staticmethod
    def _in_order(slopes: Sequence[Mapping[Place, float]]) -> int:
        """With all angles at 0, how many pairs of three cells stem from neighbours in line, as x, y and z are."""
        steps: Counter = Counter()
        for (i, one), (j, other) in combinations(enumerate(slopes), 2):
            pairs = product(one.items(), other.items()) if len(one) * len(other) <= PAIRS else ()
            apart = {(q[0], (q[1] - p[1]) / (j - i), (q[2] - p[2]) / (j - i)) for (p, a), (q, b) in pairs if a == b}
            steps.update(step for step in apart if any(step[1:]) and not any(n % 1 for n in step[1:]))
        return max(steps.values(), default=0)
