"""What turns a vector: its angles or axis, the point that is turned, the origin, what is added afterwards."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Mapping

import numpy as np

from mathpost.errors import InputError
from mathpost.teaching.workbook.meaning.calculation import Calculation, Turn
from mathpost.teaching.workbook.meaning.given import runs
from mathpost.teaching.workbook.meaning.names import Names
from mathpost.teaching.workbook.meaning.texts import CENTRE, ORIGIN, PASSIVE
from mathpost.teaching.workbook.meaning.vocabulary import wording
from mathpost.teaching.workbook.sheet.place import Line, Place
from mathpost.teaching.workbook.task import Task

SHIFT = rf"{wording('shift')}|^\W*t[xyz]?\b"  # what is added after the turn
ABOUT_A_CENTRE = rf"{wording('about')}[^.,;]{{0,20}}{CENTRE}"


class Turns(Names):
    """The rotations of a workbook, each told from the vector that is its result."""

    # What `Recognised` finds out before:
    task: Task
    active: bool
    by: str  # who says what is turned
    sequence: str
    calculations: list[Calculation]
    beside: list[Line]
    doubts: dict[Line, str]

    def _turn_of(self, triple: Line) -> Turn | str:
        """The rotation that a vector is the result of, or what of it is not found."""
        triple = self.as_named(triple)
        angles = self._of(triple, self.angles)
        back = bool(re.search(wording("inverse"), self.text, re.I))
        shift = self._shift(triple, back)
        point, origin, others = self._moved(triple, shift)
        still = [line for line in others if self._is_still(line, triple)]  # where nothing is turned
        axes = [line for line in still if any(p in self.curved.get(t, ()) for p in line for t in triple)]
        centres = [line for line in still if line not in axes]
        centres += [origin] * bool(self.active and re.search(ABOUT_A_CENTRE, self.text, re.I))
        if centres and not shift:
            origin = shift = centres[0]
        if len(angles) == 1 and (axes or (others and re.search(wording("about an axis"), self.text, re.I))):
            lines, matrices = (point, *others), self.graph.upstream(p for w in self.windows for p in w)
            axis = next((line for line in axes or lines if matrices.issuperset(line)), (axes or others)[0])
            point = point if axes else next(line for line in lines if line != axis)
            origin = origin if axes else ()
            return self._told(Turn(triple, angles, point, origin, axis=axis, shift=shift))
        chosen = self._varied(angles, triple) or self.three(angles) or self.three(self.sorted(self.angles))
        if min(len(self.depends[p] & self.angles) for p in triple[:3] if p in self.depends) > 4:
            chosen = None  # turned more than once, and not by a vector in between
        if chosen is None or not point:
            return "three angles" if chosen is None else "a point"
        return self._told(Turn(triple, self.by_name(chosen), point, origin, shift=shift))

    def _varied(self, angles: Line, triple: Line) -> Line | None:
        """Three angles of which one, by their names, is in the row of a vector and replaces the given one."""
        own = [p for p in angles if p[:2] == triple[0][:2]]
        said = {p: self.angle_said(p) for p in angles}
        rest = [p for p in angles if own and said[p] != said[own[0]]]
        three = (*rest, *own)
        return three if len(own) == 1 and len(three) == 3 and {*map(said.get, three)} == {0, 1, 2} else None

    def _shift(self, triple: Line, back: bool) -> Line:
        """What is added to a vector after it is turned, if that is meant; it may be a mistake."""
        unmoved = [self.unmoved.get(p, set()) for p in triple[:3]]
        shift = next(iter(self.lines(set().union(*unmoved), 2)), ())
        meant = back or self.is_named(shift, SHIFT) or (self.active and not self.is_named(shift, CENTRE))
        return shift if meant else ()

    # Point and origin.

    def _moved(self, triple: Line, shift: Line) -> tuple[Line, Line, list[Line]]:
        """The point and the origin of a vector, and other triples of its lengths.

        With all angles at zero a vector is the point minus the origin, whatever formulas compute it.
        """
        row, up = triple[0][:2], self.graph.upstream(triple)
        slopes = [{s: slope for s, slope in self.unturned.get(p, {}).items() if s in up} for p in triple[:3]]
        for step in (t for t in self.beside if up.issuperset(t) and not any(slopes)):  # no number, by a slip
            slopes = [self.unturned.get(p, {}) for p in step[:3]]
        moving = {s for p in triple for s in self.depends.get(p, ())} & self.lengths & up
        weighed: dict[float | None, list[tuple[int, Line]]] = {}
        lines = self._vectors(moving.union(*slopes), row if triple[0][1] == triple[1][1] else None)
        used = [line for line in lines if moving.issuperset(line)]
        for least, all_lines in ((2, self.lines(set().union(*slopes), 2)), (1, used)):  # a slip may turn two away
            for line in () if weighed else all_lines:
                weights = Counter(each.get(p) for each, p in zip(slopes, line, strict=True) if p in each)
                weight, count = max(weights.items(), key=lambda w: w[1], default=(0, 0))
                if count >= least:
                    weighed.setdefault(weight, []).append((-count, line))
        plus, minus = ([line for _, line in sorted(weighed.pop(w, []), key=lambda c: c[0])] for w in (1, -1))
        plus, minus = _apart([shift, *plus] if shift else plus)[bool(shift) :], _apart(minus)
        asked = [line for line in plus if tuple(self.graph.own[p] for p in line) == tuple(self.task.origin or ())]
        named = [line for line in plus if self.is_named(line, ORIGIN)]
        asked = asked or (named if 0 < len(named) < len(plus) else [])
        plus, minus = [line for line in plus if line not in asked], [*minus, *asked]  # one that is added by mistake
        if len(plus) != 1 or weighed:
            inside: list[Line] = [t for t in self.beside if up.issuperset(t) and len(t) == 3]
            means = [
                t for t in inside if sum(self.unturned.get(p) == s for p, s in zip(t, slopes, strict=True)) > 1
            ]
            plus = means or plus
        made = self._made_by_formulas(triple)
        mirrored = made if {self.graph.tree(p)[0] for p in made} == {"minus", "area"} else ()
        may = mirrored, *plus[::-1], *used, made, *lines
        point = next(filter(None, may), ())
        # In 4×4 an origin that moves nothing is in a matrix that is transposed by mistake.
        minus += [line for line in used if len(triple) == 4 and not any(map(set(line).intersection, slopes))]
        origin = next((line for line in minus if set(line).isdisjoint(point)), ())
        return point, origin, [line for line in lines if set(line).isdisjoint((*point, *origin))]

    def _vectors(self, cells: Iterable[Place], row: tuple[str, int] | None) -> list[Line]:
        """The triples of lengths that a result depends on; that in the row of a table first."""
        own = self.lines({p for p in cells if p[:2] == row}, 2)
        return _apart((*own[:1], *self.lines(set(cells), 2)))

    def _made_by_formulas(self, triple: Line) -> Line:
        """A point that is calculated, or is 0 without being moved: three in line that all cells of a vector use."""
        used = set.intersection(*(set(self.graph.uses.get(p, ())) for p in triple[:3])) - self.turning
        used = used.intersection(self.graph.component) - {p for window in self.windows for p in window}
        return next((line for line in runs(used) if len(line) == 3), ())

    def _is_still(self, line: Line, triple: Line) -> bool:
        """Whether lengths move no vector where nothing is turned, as those of an axis or centre; but for a slip."""
        slopes = [self.unturned.get(p, {}) for p in triple[:3]]
        counts = [len(set(line).intersection(each)) for each in slopes]
        return any(slopes) and counts.count(0) > 1 and sum(counts) < 3

    def _is_of_length_one(self, axis: Line) -> bool:
        """Whether an axis has length one, and no formula makes its length."""
        graph, given = self.graph, set(axis)
        lengths = (graph.upstream([p]) - graph.trees.keys() for p in graph.downstream(axis) & graph.trees.keys())
        is_one = abs(np.linalg.norm([graph.number(p) for p in axis]) - 1) < 2e-3
        return bool(is_one) and given not in lengths

    # What the sheet, or the caller, says about it.

    def _as_the_caller_says(self, cells: Mapping[str, str]) -> None:
        """Take angles, point, origin and result from the cells that the caller names."""
        given = {name: tuple(self.graph.named(name, text).places) for name, text in cells.items()}
        sizes = {"angles": (3,), "result": (3, 4, 9, 16), "origin": (0, 3)}
        sizes["point"] = (0, 3) if len(given.get("result", ())) > 4 else (3,)
        for name, allowed in sizes.items():
            places = given.setdefault(name, ())
            if len(places) not in allowed:
                raise InputError("cells", "angles, point and result of three cells each", f"no {name} of that size")
            for place in (p for p in places if p not in self.graph.component):
                raise InputError(f"cells, {name!r}", "numbers or formulas", f"none in {self.graph.address(place)}")
        self.vectors = set(given["result"])
        turn = Turn(given["result"], given["angles"], given["point"], given["origin"])
        self.calculations.append(self._told(turn))

    def _told(self, calculation: Turn) -> Turn:
        """The rotation with what the texts say of it."""
        calculation.results = self.as_named(calculation.results)
        calculation.point = self.as_named(calculation.point, ("coordinate",))
        primed = calculation.point and re.search("['′’]", self.label(calculation.point[0]))
        calculation.back = bool((calculation.shift or primed) and re.search(wording("inverse"), self.text, re.I))
        as_it_is = calculation.shift and self.active and not self.task.convention  # R·p' + p0
        calculation.back &= not as_it_is
        active = self.active
        if calculation.axis:  # what the field means by it, unless it is said
            active |= not (self.task.convention or re.search(PASSIVE, self.text, re.I))
        if calculation.axis:
            calculation.of_length_one = self._is_of_length_one(calculation.axis)
        calculation.sequence, calculation.active = self.sequence, active != calculation.back
        name = "about an axis" if calculation.axis else f"{self.sequence}, as {self.by} says"
        back = ", turned back" * calculation.back
        calculation.said = f"{'active' if active else 'passive'} rotation, {name}{back}"
        return calculation


def _apart(lines: Iterable[Line]) -> list[Line]:
    """The lines that have no cell in common with one before."""
    found: list[Line] = []
    for line in lines:
        if all(set(line).isdisjoint(other) for other in found):
            found.append(line)
    return found
