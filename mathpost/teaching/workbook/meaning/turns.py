"""What turns a vector: its angles or axis, the point that is turned, the origin, what is added afterwards."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Collection, Iterable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from mathpost.errors import InputError
from mathpost.teaching.workbook.meaning.calculation import Calculation, Turn
from mathpost.teaching.workbook.meaning.given import runs
from mathpost.teaching.workbook.meaning.names import Names
from mathpost.teaching.workbook.meaning.texts import CENTRE, ORIGIN, PASSIVE
from mathpost.teaching.workbook.meaning.vocabulary import wording
from mathpost.teaching.workbook.sheet.place import Line, Place, offset
from mathpost.teaching.workbook.task import Task

if TYPE_CHECKING:
    from mathpost.teaching.workbook.meaning.plane_angles import Plane

SHIFT = rf"{wording('shift')}|^\W*t[xyz]?\b"  # what is added after the turn
ABOUT_A_CENTRE = rf"{wording('about')}[^.,;]{{0,20}}{CENTRE}"


class Turns(Names):
    """The rotations of a workbook, each told from the vector that is its result."""

    # What `Recognised` finds out before:
    task: Task
    active: bool
    by: str  # who says what is turned
    sequence: str
    planes: list[Plane]
    calculations: list[Calculation]
    beside: list[Line]
    doubts: dict[Line, str]

    def _add_turn(self, triple: Line, calculations: list[Calculation]) -> None:
        triple = self.as_named(triple)
        angles = self._of(triple, self.angles)
        plane = next((p for p in self.planes if self.graph.upstream(p.results) & set(angles)), None)
        back = bool(re.search(wording("inverse"), self.text, re.I))
        shift = self._shift(triple, back or plane)
        point, origin, others = self._moved(triple, shift)
        if axis := self._quaternion_of(angles, triple[0]):
            self._tell(Turn(triple, (), point, origin, axis=axis, shift=shift), calculations)
            return
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
            self._tell(Turn(triple, angles, point, origin, axis=axis, shift=shift), calculations)
            return
        if plane and point:
            turn = Turn(triple, self._angles_of(plane, triple), point, origin, shift=shift)
            self._tell(turn, calculations, plane)
            return
        chosen = self._varied(angles, triple) or self.three(angles) or self.three(self.sorted(self.angles))
        if min(len(self.depends[p] & self.angles) for p in triple[:3] if p in self.depends) > 4:
            chosen = None  # turned more than once, and not by a vector in between
        if chosen is None or not point:
            what = "three angles" if chosen is None else "a point"
            if calculations is self.calculations:
                self.beside.append(triple)
                self.doubts[triple] = f"{self.graph.range(triple)}: {what} not found among its inputs"
            return
        self._tell(Turn(triple, self.by_name(chosen), point, origin, shift=shift), calculations)

    def _varied(self, angles: Line, triple: Line) -> Line | None:
        """Three angles of which one, by their names, is in the row of a vector and replaces the given one."""
        own = [p for p in angles if p[:2] == triple[0][:2]]
        said = {p: self.angle_said(p) for p in angles}
        rest = [p for p in angles if own and said[p] != said[own[0]]]
        three = (*rest, *own)
        return three if len(own) == 1 and len(three) == 3 and {*map(said.get, three)} == {0, 1, 2} else None

    def _angles_of(self, plane: Plane, places: Line) -> Line:
        """The cells of a plane's angles by which some places are turned, and a third one that is typed."""
        order = self.graph.calculation_order
        angles = [max(self.angles & self.graph.upstream([p]), key=order, default=p) for p in plane.results]
        return (*angles, *self.sorted(self.turned_by(places).difference(angles)))[:3]

    def _shift(self, triple: Line, back: Any) -> Line:
        """What is added to a vector after it is turned, as a plane's origin is; another may be a mistake."""
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
        point = self._as_labelled(next(filter(None, may), ()))
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

    def _as_labelled(self, point: Line) -> Line:
        """The point a cell further on, if the labels say that x, y and z are there."""
        for order in (1, -1) if point else ():
            _, near, end = point[::order]
            moved = (near, end, offset(end, end[1] - near[1], end[2] - near[2]))[::order]
            if self.typed.issuperset(moved) and [*map(self.coordinate, moved)] == [(0,), (1,), (2,)]:
                return moved
        return point

    def _is_still(self, line: Line, triple: Line) -> bool:
        """Whether lengths move no vector where nothing is turned, as those of an axis or centre; but for a slip."""
        slopes = [self.unturned.get(p, {}) for p in triple[:3]]
        counts = [len(set(line).intersection(each)) for each in slopes]
        return any(slopes) and counts.count(0) > 1 and sum(counts) < 3

    # Quaternions.

    def _quaternions(self, inputs: set[Place]) -> list[Line]:
        """Four given numbers in line, scalar first or last, in a sheet that speaks of quaternions."""
        if not re.search(wording("quaternion"), self.text, re.I):
            return []
        lines = [line for line in runs(inputs - self.turning) if len(line) == 4]
        threes = [line for line in runs(self.typed & self.graph.used.keys() - self.turning) if len(line) == 3]
        points = []  # four side by side
        for line in lines:
            across = {
                p for three in threes for p in three if (three[0][1] == three[1][1]) != (line[0][1] == line[1][1])
            }
            if across.issuperset(line) and not re.search(r"\bw\b|\bq", self.label(line[0]), re.I):
                points.append(line)
        return [self.scalar_first(line) for line in lines if line not in points]

    def _quaternion_of(self, cells: Collection[Place], place: Place) -> Line | None:
        """The quaternion that most of some cells are of, that in the row of a place first; None without one."""
        count = {q: (len(set(q).intersection(cells)), q[0][:2] == place[:2]) for q in self.quaternions}
        best = max(count, key=lambda quaternion: count[quaternion], default=None)
        return best if best and count[best][0] else None

    def _is_of_length_one(self, axis: Line) -> bool:
        """Whether an axis or quaternion has length one, and no formula makes its length."""
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
        self._tell(turn, self.calculations)

    def _tell(self, calculation: Turn, calculations: list[Calculation], plane: Plane | None = None) -> None:
        calculation.results = self.as_named(calculation.results)
        calculation.point = self.as_named(calculation.point, ("coordinate",))
        if any(name[:1] == "-" for name in self.names):
            calculation.signs = [-1 if name[:1] == "-" else 1 for name in self.names]
            if self._named_in_the_text(calculation.angles) != calculation.angles:
                self.doubts[calculation.results] = f"which angle is negated, as in {' '.join(self.names)}?"
                return
        primed = calculation.point and re.search("['′’]", self.label(calculation.point[0]))
        calculation.back = bool((calculation.shift or primed) and re.search(wording("inverse"), self.text, re.I))
        as_it_is = calculation.shift and self.active and not self.task.convention  # R·p' + p0
        calculation.back &= not as_it_is
        active = self.active
        of_quaternion = not calculation.point and re.search(wording("quaternion"), self.text, re.I)
        if calculation.axis or of_quaternion:  # what the field means by these, unless it is said
            active |= not (self.task.convention or re.search(PASSIVE, self.text, re.I))
        if calculation.axis:
            calculation.of_length_one = self._is_of_length_one(calculation.axis)
        calculation.sequence, calculation.active = self.sequence, active != calculation.back
        name = {0: f"{self.sequence}, as {self.by} says", 3: "about an axis", 4: "by a quaternion"}
        back = ", turned back" * calculation.back
        calculation.said = f"{'active' if active else 'passive'} rotation, {name[len(calculation.axis)]}{back}"
        if plane:  # into it less the origin, or out of it and to the origin, or who knows
            calculation.plane, calculation.sequence = plane, plane.sequence
            calculation.active = bool(calculation.shift) if calculation.shift or calculation.origin else None
            calculation.said = f"points by these angles, {plane.sequence}"
        calculations.append(calculation)


def _apart(lines: Iterable[Line]) -> list[Line]:
    """The lines that have no cell in common with one before."""
    found: list[Line] = []
    for line in lines:
        if all(set(line).isdisjoint(other) for other in found):
            found.append(line)
    return found
