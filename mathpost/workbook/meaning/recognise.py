"""What is this sheet? Inputs, matrices, vectors and results, told by how the formulas use the cells.

Labels only break ties: which triple is an angle, a point or an origin follows from where it goes.
"""

import re
from collections import Counter
from itertools import combinations, permutations, product

import numpy as np

from mathpost import euler
from mathpost.errors import InputError
from mathpost.workbook.meaning.calculation import Turn
from mathpost.workbook.meaning.conversion import find_conversions, find_quaternions
from mathpost.workbook.meaning.given import QUATERNION, runs
from mathpost.workbook.meaning.label import plain, read_label
from mathpost.workbook.meaning.nc_table import rows_of
from mathpost.workbook.meaning.plane_angles import find_planes
from mathpost.workbook.meaning.texts import FOREIGN, ORIGIN, PASSIVE, reading
from mathpost.workbook.meaning.vectors import Vectors
from mathpost.workbook.sheet.edits import INVERSE as INVERSE_FUNCTIONS
from mathpost.workbook.sheet.place import offset
from mathpost.workbook.sheet.tree import heads

SMALL = 1e-6  # a slope that is none
SHIFT = r"shift|translat|verschieb|décal|平移|^\W*t[xyz]?\b"  # what is added after the turn
CENTRE = r"cent(?:re|er)|pivot|drehpunkt|mittelpunkt|中心"  # what is taken off before it
ABOUT_A_CENTRE = rf"\b(?:about|um) [^.,;]{{0,20}}(?:{CENTRE})|绕.{{0,6}}中心"
INVERSE = r"inver|rück|zurück|\bback|retour|逆|反变换"
MIRRORED = r"mirror|spiegel|miroir|symétr|镜像|对称"
AXIS_NAMES = {"X": r"roll|滚|\br_?x\b", "Y": r"pitch|nick|俯仰|\br_?y\b", "Z": r"yaw|heading|gier|偏航|\br_?z\b"}
ABOUT_AN_AXIS = r"rodrig|罗德里格|任意轴|about an axis|um eine achse|axis.angle|轴角"


class Recognised(Vectors):
    """What is what in a workbook.

    Given numbers that others use are `angles`, `lengths` or `constants`; `vectors` depend on lengths. `steps` would
    be calculations if no other cells used them, and the vectors `beside` are none; `doubts` says of some why not.
    `by` says who names the reading: the task, the text, or source 000; it `is_open` if a text that is not
    understood may say more.
    """

    def __init__(self, graph, task):
        super().__init__(graph, with_formulas=task.machine is None)
        self.task, self.problems, self.doubts, self.vectors = task, [], {}, set()
        self.calculations, self.steps, self.beside, self.depends, self._ends = [], [], [], {}, {}
        count = len(self.typed & self.turning)
        self.sequence, self.active, self.by, unsure, self.names = reading(task, self.text, count)
        said = task.convention or self.active or re.search(PASSIVE, self.text, re.I)
        self.is_open = self.by != "the task" and not said and bool(re.search(FOREIGN, self.text, re.I))
        self.is_whole = len(self.sequence) == 3  # else the last angles are 0
        if not self.is_whole:
            full = next(each for each in euler.SEQUENCES if each.startswith(self.sequence.upper()))
            self.sequence = full if self.sequence.isupper() else full.lower()
        self.planes = [] if task.machine is not None or task.cells else [*find_planes(self)]
        given = {p for plane in self.planes for p in plane.given}
        self.windows = [w for w in self.matrices() if given.isdisjoint(w)]
        self.constants = self.never_moved() - given
        inputs = {p for p in self.typed if not self.composed.issuperset(graph.used.get(p, ()))} - self.constants
        self.quaternions = self._quaternions(inputs)
        self.turning |= {p for quaternion in self.quaternions for p in quaternion}
        self.angles, self.lengths = inputs & self.turning, inputs - self.turning
        if task.machine is not None:
            self.calculations, self.problems = rows_of(self, task.machine, task.cells)
        elif task.cells:
            self._as_the_caller_says(task.cells)
        elif self.angles:
            self._find_calculations()
        elif not self.planes:
            self.problems.append("no cell goes into a sine or cosine as an angle")
        self.calculations = [*self.planes, *self.calculations]
        if task.machine is None and not (task.cells or self.planes):
            conversions = [*find_conversions(self)]
            made = [{*c.angles} for c in conversions if c.sequence != c.into]  # what turns by these is on the way
            self.calculations = [c for c in self.calculations if c.point or {*c.angles} not in made] + conversions
            if re.search(QUATERNION, self.text, re.I):
                for calculation in find_quaternions(self):
                    self._tell(calculation, self.calculations)
        if not any(heads(tree) & INVERSE_FUNCTIONS for tree in graph.trees.values()):
            self.problems += unsure
        made = self.composed & graph.upstream(p for plane in self.planes for p in plane.line)
        self.typed, self.composed, self.angles = self.typed - made, self.composed - made, self.angles - made

    # Which calculations there are.

    def _find_calculations(self):
        graph, finals = self.graph, []
        self._respond()
        inner = {w: w if len(w) == 9 else (*w[:3], *w[4:7], *w[8:11]) for w in self.windows}
        self.windows = [w for w in self.windows if len(self.vectors.intersection(inner[w])) < 3]
        for triple in self._triples():
            trees, up = [graph.trees.get(p, ("text",)) for p in triple], graph.upstream(triple)
            # A result less what was expected, or than another result, is a check and not a step.
            difference = all(t[0] == "-" and t[1][0] == t[2][0] == "area" for t in trees)
            difference &= any(s in self.vectors for p in triple for s in graph.uses.get(p, ()))
            # One of which but a cell depends on angles was turned back.
            lost = sum(not self.depends.get(p) for p in triple) == 2  # they take empty cells by a slip
            turned = lost or sum(bool(self.turned_by([p])) for p in triple) > 1
            turned |= any(up & self.typed >= set(w) for w in self.windows)
            # One coordinate of each of three points is no vector, nor three times one coordinate.
            lengths = [self.lengths.intersection(self.depends.get(p, ())) for p in triple]
            turned &= lost or any(a & b for a, b in combinations(lengths, 2))
            turned &= not self._is_one_coordinate(triple)
            of_signs = all(t[0] == "area" or (t[0] == "minus" and t[1][0] == "area") for t in trees)
            mirrored = {t[0] for t in trees} == {"minus", "area"} or re.search(MIRRORED, self.heading(triple), re.I)
            of_signs &= bool(mirrored)  # a mirrored copy, or one that has lost its minus
            (finals if turned and not (difference or of_signs) else self.beside).append(triple)
        kept, of = dict.fromkeys(finals), {p: t for t in finals for p in t}
        for triple in finals:
            up = graph.upstream(triple)
            parts = dict.fromkeys(t for t in [of[p] for p in self.sorted(up & of.keys())] if t in kept)
            if self._is_combined(triple, up, parts) or self._is_undone(triple, up, parts):
                del kept[triple]
                self.beside.append(triple)
        finals = [*kept]
        used, before = {p for t in finals for p in graph.upstream(t) - set(t)}, self._frames_before(finals)
        for triple in finals:
            on_the_way = used.issuperset(triple) and triple not in before.values()
            self._add_turn(triple, self.steps if on_the_way else self.calculations, before.get(triple, ()))
        most = max((len(self._of(w, self.angles)) for w in self.windows), default=0)
        for window in self.windows if not (self.calculations or self.doubts) else ():
            plane = next((p for p in self.planes if graph.upstream(p.line) & self.turned_by(window)), None)
            own, after = self._of(window, self.angles), graph.downstream(window) - set(window)
            last = all(after.isdisjoint(w) for w in self.windows if w != window)
            if last and plane:
                self._tell(Turn(window, self._angles_of(plane)), self.calculations, plane)
            elif last and (axis := self._quaternion_of(own, window[0])):
                self._tell(Turn(window, (), axis=axis), self.calculations)
            elif last and len(own) == most > 0 and (angles := self.three(own)):
                self._tell(Turn(window, self.by_name(angles)), self.calculations)
        tables = {}
        for calculation in self.calculations:
            tables.setdefault(graph.component[calculation.results[0]], []).append(calculation)
        for rows in tables.values():  # the rows of a table have one origin, even if a $ is missing
            origins = Counter((row.origin, _between(row)) for row in rows).most_common(1)
            shifts = Counter(row.shift for row in rows).most_common(1)
            for row in rows:
                ((origin, between), _), (shift, _) = *origins, *shifts
                own = row.origin and (_between(row) == between or self._is_named(row.origin, f"{ORIGIN}|{CENTRE}"))
                row.origin = row.origin if own else origin
                row.shift = shift
            self._give(rows, "point")
            if len({row.angles for row in rows}) > 1:
                self._give(rows, "angles")
        firsts = {id(graph.component[c.results[0]]): c for c in self.calculations if c.angles}
        for one, other in permutations(firsts.values(), 2):
            if one.point == other.point and one.angles != other.angles:  # the other has a point of its own
                down, right = _step(one.angles[0], other.angles[0])
                own = tuple((other.angles[0][0], *offset(p, down, right)[1:]) for p in one.point)
                if self._is_unused(own):
                    other.point = own

    def _give(self, rows, part):
        """Give a row of a table the point, or angles, that stand as those of others do and that no formula uses.

        Or that stand as those of all others do.
        """
        given = {row: own for row in rows if (own := getattr(row, part))}
        apart = Counter((own[0][0], *_step(row.results[0], own[0])) for row, own in given.items())
        for row, now in given.items():
            for (sheet, down, right), votes in sorted(apart.items(), key=lambda way: (-way[1], abs(way[0][1]))):
                _, top, left = offset(row.results[0], down, right)
                own = tuple((sheet, top + n, left + k) for n, k in (_step(now[0], p) for p in now))
                most = votes > 2 and votes == len(rows) - 1
                most |= votes > 1 and own in given.values()  # two rows that have each other's
                most &= part == "point"
                if own == now or self._is_unused(own) or (most and self.graph.component.keys() >= set(own)):
                    setattr(row, part, own)
                    break

    def _is_unused(self, line):
        """Whether some cells are numbers that no formula uses."""
        return bool(line) and self.typed.issuperset(line) and self.graph.used.keys().isdisjoint(line)

    def heading(self, triple):
        """The texts before a vector, with no number in between, or above it as far; or over its column."""
        (sheet, row, column), cells = triple[0], self.graph.cells
        first = max((n for n in range(1, column) if (sheet, row, n) in self.graph.component), default=0) + 1
        near = (cells.get((sheet, row - up, n)) for up in (0, 1) for n in range(first, column + 1))
        texts = [cell.value for cell in near if cell and isinstance(cell.value, str)]
        return "\n".join([*texts, *self.texts(triple[0])[:2]])

    def _frames_before(self, finals):
        """Vector → the vector that is its point, where one frame follows another: three angles more turn it."""
        graph, found, of = self.graph, {}, {p: t for t in finals for p in t}
        turned_by = {t: self.angles & graph.upstream(t) for t in finals}
        for last in (t for t in finals if len(turned_by[t]) > 5):
            up = graph.upstream(last)
            earlier = {of[p] for p in up & of.keys()} - {last}
            for before in sorted(earlier, key=lambda t: graph.calculation_order(t[0])):
                more = self.angles & graph.upstream(last, before)
                if len(more) == 3 and len(turned_by[before]) > 2 and more.isdisjoint(turned_by[before]):
                    found[last] = before if up.issuperset(before) else found.get(last)
        return {last: before for last, before in found.items() if before}

    def _is_combined(self, triple, up, finals):
        """Whether a vector is made of several that go back to different points, or angles, as a mean is."""
        own = {s for p in triple for s in self.depends.get(p, ())}
        parts = [s for s in finals if s != triple and len(up.intersection(s)) > 1]
        given = [own.intersection(*(self.depends.get(p, ()) for p in s)) for s in parts]
        given = [
            each for each in given if len(each & self.lengths) > 2
        ]  # not of the terms with x, with y and with z
        pairs = ((a & kind, b & kind) for a, b in combinations(given, 2) for kind in (self.lengths, self.angles))
        return any(a - b and b - a for a, b in pairs)

    def _is_one_coordinate(self, triple):
        """Whether some cells are multiples of one: their slopes in the lengths are, with angles that are not 0."""
        lengths = self._of(triple, self.lengths)
        slopes = np.array([[self.turned.get(p, {}).get(s, 0.0) for s in lengths] for p in triple])
        if not np.isfinite(slopes).all():
            return False
        return np.count_nonzero(np.abs(slopes[0]) > SMALL) > 1 and np.linalg.matrix_rank(slopes, SMALL) == 1

    def _is_undone(self, triple, up, finals):
        """Whether a vector is made of one that more angles turn: some of them are turned back."""
        angles = self.turned_by(triple)
        return any(up.issuperset(before) and angles < self.turned_by(before) for before in finals)

    def _add_turn(self, triple, calculations, before=()):
        triple = self.as_named(triple)
        angles = self._of(triple, self.angles)
        if before:
            angles = self.sorted(self.angles & self.graph.upstream(triple, before))
        plane = next((p for p in self.planes if self.graph.upstream(p.line) & set(angles)), None)
        back = bool(re.search(INVERSE, self.text, re.I))
        shift = self._shift(triple, back or plane)
        point, origin, others = self._moved(triple, shift, before)
        if origin and self._names_an_origin(point, origin):
            point, origin = origin, point
        origin = origin or self._origin_left_out(point)
        if axis := self._quaternion_of(angles, triple[0]):
            self._tell(Turn(triple, (), point, origin, axis=axis, shift=shift), calculations)
            return
        still = [line for line in others if self._is_still(line, triple)]  # where nothing is turned
        axes = [line for line in still if any(p in self.curved.get(t, ()) for p in line for t in triple)]
        centres = [line for line in still if line not in axes]
        centres += [origin] * bool(self.active and re.search(ABOUT_A_CENTRE, self.text, re.I))
        if centres and not shift:
            origin = shift = centres[0]
        if len(angles) == 1 and (axes or (others and re.search(ABOUT_AN_AXIS, self.text, re.I))):
            lines, matrices = (point, *others), self.graph.upstream(p for w in self.windows for p in w)
            axis = next((line for line in axes or lines if matrices.issuperset(line)), (axes or others)[0])
            point = point if axes else next(line for line in lines if line != axis)
            origin = origin if axes else ()
            self._tell(Turn(triple, angles, point, origin, axis=axis, shift=shift), calculations)
            return
        if plane and point:
            turn = Turn(triple, self._angles_of(plane), point, origin, shift=shift)
            self._tell(turn, calculations, plane)
            return
        chosen = self._varied(angles, triple) or self.three(angles) or self.three(self.sorted(self.angles))
        if min(len(self.depends[p] & self.angles) for p in triple[:3] if p in self.depends) > 4 and not before:
            chosen = None  # turned more than once, and not by a vector in between
        if chosen is None or not point:
            what = "three angles" if chosen is None else "a point"
            if calculations is self.calculations:
                self.beside.append(triple)
                self.doubts[triple] = f"{self.graph.range(triple)}: {what} not found among its inputs"
            return
        self._tell(Turn(triple, self.by_name(chosen), point, origin, shift=shift), calculations)

    def _varied(self, angles, triple):
        """Three angles of which one, by their names, stands in the row of a vector in place of the given one."""
        own = [p for p in angles if p[:2] == triple[0][:2]]
        said = {p: self.angle_said(p) for p in angles}
        rest = [p for p in angles if own and said[p] != said[own[0]]]
        three = (*rest, *own)
        return three if len(own) == 1 and len(three) == 3 and {*map(said.get, three)} == {0, 1, 2} else None

    def _origin_left_out(self, point):
        """The origin, by its name, in the differences with a point that no formula uses; empty if there is none."""
        graph = self.graph
        unused = [
            [u for u in graph.used.get(p, ()) if u not in graph.used and graph.trees[u][0] == "-"] for p in point
        ]
        for users in product(*unused):
            origin = tuple(s for u, p in zip(users, point, strict=True) for s in graph.uses[u] if s != p)
            is_given = len({*users}) == len({*origin}) == len(origin) == 3 and self.typed.issuperset(origin)
            if is_given and any(self._is_named(each, ORIGIN) for each in (origin, users)):
                return origin
        return ()

    def _names_an_origin(self, line, other):
        """Whether it is the first of two points that a label says to be the origin."""
        one, two = self.label(line[0]), self.label(other[0])
        is_said = [self._is_named(each, f"{ORIGIN}|{CENTRE}") for each in (line, other)]
        zero = re.fullmatch(r"\W*[xyz]_?0\b.*", one, re.I) and re.fullmatch(r"\W*[xyz]\b[^'’′]*", two, re.I)
        return is_said == [True, False] or bool(zero)

    def _is_still(self, line, triple):
        """Whether lengths move no vector where nothing is turned, as those of an axis or centre; but for a slip."""
        slopes = [self.unturned.get(p, {}) for p in triple[:3]]
        counts = [len(set(line).intersection(each)) for each in slopes]
        return any(slopes) and counts.count(0) > 1 and sum(counts) < 3

    def _quaternions(self, inputs):
        """Four given numbers in line, scalar first or last, in a sheet that speaks of quaternions."""
        if not re.search(QUATERNION, self.text, re.I):
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

    def scalar_first(self, line):
        """The cells of a quaternion, w before x, y and z, whichever the labels say is first."""
        said = ["".join(re.findall(r"\bq?_?([wxyz])\b", self.label(p), re.I)).lower() for p in line]
        if sorted(said) == [*"wxyz"]:
            return tuple(line[said.index(letter)] for letter in "wxyz")
        first, last = (re.search(name, self.label(line[0]), re.I) for name in (r"w|q?0|s", r"\bq?[xi]\b|\bq?1\b"))
        return line[-1:] + line[:-1] if last and not first else line

    def _quaternion_of(self, cells, place):
        """The quaternion that most of some cells are of, that in the row of a place first; None without one."""
        count = {q: (len(set(q).intersection(cells)), q[0][:2] == place[:2]) for q in self.quaternions}
        best = max(count, key=count.get, default=None)
        return best if best and count[best][0] else None

    def _is_of_length_one(self, axis):
        """Whether an axis or quaternion has length one, and no formula makes its length."""
        graph, given = self.graph, set(axis)
        lengths = (graph.upstream([p]) - graph.trees.keys() for p in graph.downstream(axis) & graph.trees.keys())
        is_one = abs(np.linalg.norm([graph.own[p] for p in axis]) - 1) < 2e-3
        return bool(is_one) and given not in lengths

    def _angles_of(self, plane):
        """The cells of a plane's angles that are turned by; a third one that is 0 is used by no formula."""
        order = self.graph.calculation_order
        turned_by = [max(self.angles & self.graph.upstream([p]), key=order, default=p) for p in plane.line]
        is_lost = len(turned_by) == 3 and self.graph.own[plane.line[2]] == 0 and turned_by[2] not in self.angles
        return tuple(turned_by[:2] if is_lost else turned_by)

    def _shift(self, triple, back):
        """What is added to a vector after it is turned, as a plane's origin is; another may be a mistake."""
        unmoved = [self.unmoved.get(p, set()) for p in triple[:3]]
        shift = next(iter(self.lines(set().union(*unmoved), 2)), ())
        meant = back or self._is_named(shift, SHIFT) or (self.active and not self._is_named(shift, CENTRE))
        return shift if meant else ()

    def _is_named(self, line, pattern):
        """Whether the text before the first of some cells, or above it, is such a name."""
        cells = self.graph.cells
        for steps in (((0, -n) for n in (1, 2, 3)), ((-n, 0) for n in (1, 2, 3))) if line else ():
            near = (cells.get(offset(line[0], *step)) for step in steps)
            text = next((cell.value for cell in near if cell and isinstance(cell.value, str)), "")
            if re.search(pattern, text, re.I):
                return True
        return False

    def _moved(self, triple, shift, before):
        """The point, or the vector `before`, and the origin of a vector, and other triples of its lengths.

        With all angles at zero a vector is the point minus the origin, whatever formulas compute it.
        """
        row, up = triple[0][:2], self.graph.upstream(triple, before)
        slopes = [{s: slope for s, slope in self.unturned.get(p, {}).items() if s in up} for p in triple[:3]]
        for step in (t for t in self.beside if up.issuperset(t) and not any(slopes)):  # no number, by a slip
            slopes = [self.unturned.get(p, {}) for p in step[:3]]
        moving, weighed = {s for p in triple for s in self.depends.get(p, ())} & self.lengths & up, {}
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
        named = [line for line in plus if self._is_named(line, ORIGIN)]
        asked = asked or (named if 0 < len(named) < len(plus) else [])
        plus, minus = [line for line in plus if line not in asked], [*minus, *asked]  # one that is added by mistake
        if len(plus) != 1 or weighed:
            means = [t for t in self.beside if up.issuperset(t) and len(t) == 3]
            means = [t for t in means if sum(self.unturned.get(p) == s for p, s in zip(t, slopes, strict=True)) > 1]
            plus = means or plus
        made = self._made_by_formulas(triple)
        mirrored = made if {self.graph.tree(p)[0] for p in made} == {"minus", "area"} else ()
        may = before, mirrored, *plus[::-1], *used, made, *lines
        point = self._as_labelled(next(filter(None, may), ()))
        # In 4×4 an origin that moves nothing is in a matrix that is transposed by mistake.
        minus += [line for line in used if len(triple) == 4 and not any(map(set(line).intersection, slopes))]
        origin = next((line for line in minus if set(line).isdisjoint(point)), ())
        return point, origin, [line for line in lines if set(line).isdisjoint((*point, *origin))]

    def _made_by_formulas(self, triple):
        """A point that is calculated, or is 0 without being moved: three in line that all cells of a vector use."""
        used = set.intersection(*(set(self.graph.uses.get(p, ())) for p in triple[:3])) - self.turning
        used = used.intersection(self.graph.component) - {p for window in self.windows for p in window}
        return next((line for line in runs(used) if len(line) == 3), ())

    def _as_labelled(self, point):
        """The point a cell further on, if the labels say that x, y and z are there."""
        for order in (1, -1) if point else ():
            _, near, end = point[::order]
            moved = (near, end, offset(end, end[1] - near[1], end[2] - near[2]))[::order]
            if self.typed.issuperset(moved) and [*map(self.coordinate, moved)] == [(0,), (1,), (2,)]:
                return moved
        return point

    def coordinate(self, place, kinds=("coordinate", "outcome")):
        """Which coordinate a text says that stands before a number, in its row or column."""
        cells = self.graph.cells
        for down, right in ((0, -1), (-1, 0)):
            before = (cells.get(offset(place, n * down, n * right)) for n in range(1, 60))
            texts = (c.value for c in before if c and isinstance(c.value, str))
            text = next(texts, "")
            said = *text.split("=")[::-1], text.split(" ")[0]  # "z2 = z'", "z' (mm)"
            role = next(filter(None, map(read_label, said)), None)
            if role and role.kind in kinds:
                return role.word
        return None

    def angle_said(self, place):
        """Which angle the text before a cell names; None if it names none, or several."""
        letters = {*re.findall("[αβγ]|alpha|beta|gamma", self.label(place).lower())}
        return ("α", "β", "γ", "alpha", "beta", "gamma").index(*letters) % 3 if len(letters) == 1 else None

    def three(self, cells):
        """The three inputs that belong together among `cells`, which may hold one too many or one too few."""
        if not self.is_whole:
            return self.sorted(self.angles)
        lines = self.lines(set(cells), min(len(cells), 2))
        lines = [line for line in lines if self.lengths.isdisjoint(line)]
        lines.sort(key=lambda line: -len(self.angles.intersection(line)))
        if len(cells) == 3:  # which may be one of two others and a wrong one
            may = self.angles | (self.typed - self.graph.used.keys()) if self.composed.isdisjoint(cells) else set()
            near = (line for line in lines if sum(b - a for a, b in zip(line[0][1:], line[1][1:], strict=True)) < 3)
            return next((line for line in near if may.issuperset(line)), tuple(cells))
        return lines[0] if lines else None

    def _vectors(self, cells, row):
        """The triples of lengths that a result depends on; that in the row of a table first."""
        own = self.lines({p for p in cells if p[:2] == row}, 2)
        return _apart((*own[:1], *self.lines(set(cells), 2)))

    def by_name(self, triple, sequence=None):
        """The angles α, β, γ: as labels say, or in the order in which they, or what they turn by, are read."""
        axes = [
            "".join(axis for axis, name in AXIS_NAMES.items() if re.search(name, self.label(p), re.I))
            for p in triple
        ]
        letters = (sequence or self.sequence).upper()
        if sorted(axes) == sorted(letters) == [*AXIS_NAMES]:
            return tuple(triple[axes.index(axis)] for axis in letters)
        if named := self._named_in_the_text(triple):
            return named
        graph, in_line = self.graph, any(len({(p[0], p[n]) for p in triple}) == 1 for n in (1, 2))
        ends = [self._end(p) for p in triple]
        for places in (triple, ends):
            # Which of φ, θ, ψ comes first is not the same everywhere.
            labels = [
                label for label in map(self.label, places) if not re.search("phi|psi|theta|[φψθ]", label, re.I)
            ]
            roles = [role for role in map(read_label, labels) if role and role.kind in ("angle", "radians")]
            named = [role.word for role in roles]
            if len(set(named)) == 3:
                return tuple(p for _, p in sorted(zip(named, triple, strict=True)))
        read = map(graph.reading_order, triple if in_line else ends)
        return tuple(p for _, p in sorted(zip(read, triple, strict=True)))

    def _end(self, place):
        """The last cell that an angle becomes before it goes into a sine."""
        if place not in self._ends:
            after = self.turning & self.graph.downstream([place])
            self._ends[place] = max(after, key=self.graph.calculation_order, default=place)
        return self._ends[place]

    def _named_in_the_text(self, triple):
        """The angles in the order in which a product in the text has their names; empty if the labels do not."""
        found, names = {}, [name.lstrip("-") for name in self.names]
        for place in triple:
            said = ({*names}.intersection(re.findall(r"\w+", plain(text))) for text in self.texts(place))
            found |= {name: place for name in next((words for words in said if len(words) == 1), ())}
        return tuple(found[name] for name in names) if len(found) == len(triple) == len(names) else ()

    def _as_the_caller_says(self, cells):
        """Take angles, point, origin and result from where the caller says that they stand."""
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
        self._tell(Turn(*(given[name] for name in ("result", "angles", "point", "origin"))), self.calculations)

    def as_named(self, cells, kinds=("outcome",)):
        """The three cells of a result, or of a point, in the order x, y, z that their labels say."""
        said = [self.coordinate(p, kinds) for p in cells]
        named = sorted(filter(None, said)) == [(0,), (1,), (2,)] and len(said) == 3
        return tuple(cells[said.index((n,))] for n in range(3)) if named else cells

    def _tell(self, calculation, calculations, plane=None):
        calculation.results = self.as_named(calculation.results)
        calculation.point = self.as_named(calculation.point, ("coordinate",))
        if any(name[:1] == "-" for name in self.names):
            calculation.signs = [-1 if name[:1] == "-" else 1 for name in self.names]
            if self._named_in_the_text(calculation.angles) != calculation.angles:
                self.doubts[calculation.results] = f"which angle is negated, as in {' '.join(self.names)}?"
                return
        primed = calculation.point and re.search("['′’]", self.label(calculation.point[0]))
        calculation.back = bool((calculation.shift or primed) and re.search(INVERSE, self.text, re.I))
        as_it_is = calculation.shift and self.active and not self.task.convention  # R·p' + p0
        calculation.back &= not as_it_is
        active = self.active
        of_quaternion = not calculation.point and re.search(QUATERNION, self.text, re.I)
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


def _step(a, b):
    """How far it is from a place to another, down and to the right."""
    return b[1] - a[1], b[2] - a[2]


def _between(row):
    """How far the origin of a row of a table is from its angles: the same where both are looked up."""
    steps = zip(row.origin[:1], row.angles[:1], strict=False)
    return tuple((p[0], p[1] - q[1], p[2] - q[2]) for p, q in steps)


def _apart(lines):
    """The lines that have no cell in common with one before."""
    found = []
    for line in lines:
        if all(set(line).isdisjoint(other) for other in found):
            found.append(line)
    return found
