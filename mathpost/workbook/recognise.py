"""What is this sheet? Inputs, matrices, vectors and results, told by how the formulas use the cells.

Labels only break ties: which triple is an angle, a point or an origin follows from where it goes.
"""

import re
import tomllib
from collections import Counter
from dataclasses import dataclass, fields
from itertools import combinations, count, product, takewhile
from pathlib import Path

import numpy as np

from mathpost import angles as euler
from mathpost.errors import InputError, read_text
from mathpost.workbook.calculation import Turn
from mathpost.workbook.edits import CONVERSIONS, TRIGONOMETRY
from mathpost.workbook.formula import areas, heads
from mathpost.workbook.label import read_label
from mathpost.workbook.nc_table import rows_of
from mathpost.workbook.plane_angles import find_planes

MOVES = 1500  # inputs of one formula that are moved one by one
PASSED_ON = {"RADIANS", "DEGREES", "PI", "MOD", "ROUND"}
BETWEEN = r"['’′]*[-–→·, ]*"
SEQUENCE = re.compile(rf"(?<![A-Za-z])([XYZ]){BETWEEN}([XYZ]){BETWEEN}([XYZ])['’′]*(?![A-Za-z])", re.I)
PRIMED = re.compile(r"(?<![A-Za-z])([XYZ])[-–, ]*([XYZ])['’′][-–, ]*([XYZ])(?:['’′]{2}|[\"”″])", re.I)
NUMBERED = re.compile(r"(?<![\d.])([123])-([123])-([123])(?![\d.])")
TURNS = r"euler|欧拉|rotat|dreh|turn|旋转|转|sequence|reihenfolge|顺序|axes|achsen|轴|trins|rpy|[ck]ardan|wrist"
ONE_AXIS = r"(?:about|around|\bum|autour de|绕)(?:\s|\(|the|die|der|den|l'axe|new|neue\w?|新的?)*([xyz])(?![a-z])"
FIXED = r"fixed axes|extrins|feste[nr]? achsen|固定(坐标)?轴|外旋|static axes"
OF_MATRICES = r"(?!\w*\s*\w*(?:matri|矩阵))"  # active matrices may make a passive rotation
ACTIVE, PASSIVE = (rf"(?:{word}){OF_MATRICES}" for word in (r"\bactive|aktiv|主动", r"passiv|被动"))
TRANSPOSED = r"transpo|转置|\)\^?[Tᵀ]\b|ᵀ"
INVERSE = r"inver|rück|zurück|\bback|retour|逆|反变换"
ABOUT_AN_AXIS = r"rodrig|罗德里格|任意轴|about an axis|um eine achse|axis.angle|轴角"


@dataclass(frozen=True)
class Task:
    """What the sheet was asked to do; None leaves it to the sheet, and then to source 000.

    Attributes
    ----------
    kind : str
        ``"zxz"``, ``"sequence"`` or ``"nc"``.
    sequence : str
        As in `mathpost.angles`: ``"ZXZ"`` about turned axes, ``"zxz"`` about fixed ones.
    convention : str
        ``"passive"``: coordinates of a fixed point in the turned frame; ``"active"``: the turned point.
    angles, point, origin : sequence of 3 numbers
        Degrees and mm, to be found in the input cells.
    machine : Machine or path of a machine file
    cells : dict
        ``{"angles": "B2:B4", "point": "C2:C4", "origin": "D2:D4", "result": "H2:H4"}``.
    """

    kind: str | None = None
    sequence: str | None = None
    convention: str | None = None
    angles: tuple | None = None
    point: tuple | None = None
    origin: tuple | None = None
    machine: object = None
    cells: dict | None = None

    def __post_init__(self):
        for name, known in (("kind", ("zxz", "sequence", "nc")), ("convention", ("active", "passive"))):
            if getattr(self, name) not in (None, *known):
                raise InputError(name, " or ".join(known), repr(getattr(self, name)))
        if self.sequence is not None:
            euler.matrix(self.sequence, (0, 0, 0))


def task_file(path):
    """Return the fields of a `Task` from a TOML file.

    Raises
    ------
    InputError
        If it cannot be read or holds another key.
    """
    try:
        given = tomllib.loads(read_text(path))
    except tomllib.TOMLDecodeError as error:
        raise InputError(str(path), "TOML", str(error)) from None
    known = [each.name for each in fields(Task)]
    for key in given:
        if key not in known:
            raise InputError(f"{path}, {key}", f"one of {', '.join(known)}", key)
    if isinstance(given.get("machine"), str):
        given["machine"] = str(Path(path).parent / given["machine"])
    return given


class Recognised:
    """What is what in a workbook.

    `typed` are the places of numbers, and of formulas such as =RADIANS(20) that use no cell; those that others
    use are `angles`, `lengths` or `constants`. `turning` go into a sine or cosine, `vectors` depend on lengths;
    `windows` are matrices, row by row; `steps` would be calculations if no other cells used them; `composed` are
    angles made of several numbers. `by` says who names the reading: the task, the text, or source 000.
    """

    def __init__(self, graph, task):
        self.graph, self.task = graph, task
        texts = [c.value for c in graph.cells.values() if isinstance(c.value, str) and not c.formula]
        self.text, self.problems, self.vectors = "\n".join(texts), [], set()
        self.calculations, self.steps, self.beside, self.depends = [], [], [], {}
        self.typed = {p for p in graph.component if p not in graph.trees and graph.value(p) is not None}
        self.typed |= {p for p in graph.trees if not graph.uses[p] and p not in graph.part}
        self.turning, composed = self._turning()
        self.composed = composed if task.machine is None else set()
        self.typed |= self.composed
        self._read_the_reading()
        self.planes = [] if task.machine is not None or task.cells else [*find_planes(self)]
        given = {p for plane in self.planes for p in plane.given}
        self.windows = [w for w in self._windows() if given.isdisjoint(w)]
        self.constants = self._constants() - given
        inputs = {p for p in self.typed if not self.composed.issuperset(graph.used.get(p, ()))} - self.constants
        self.angles, self.lengths = inputs & self.turning, inputs - self.turning
        if task.machine is not None:
            self.calculations, self.problems = rows_of(graph, task.machine, task.cells)
        elif task.cells and "result" in task.cells:
            self._as_the_caller_says(task.cells)
        elif self.angles:
            self._find_calculations()
        elif not self.planes:
            self.problems.append("no cell goes into a sine or cosine as an angle")
        self.calculations = [*self.planes, *self.calculations]
        made = self.composed & graph.upstream(p for plane in self.planes for p in plane.line)
        self.typed, self.composed, self.angles = self.typed - made, self.composed - made, self.angles - made

    def sorted(self, places):
        """Places as they are read."""
        return tuple(sorted(places, key=self.graph.reading_order))

    # Which cells are matrices, which are given.

    def _windows(self):
        graph, found = self.graph, Counter()
        for _, part in graph.parts:
            if part[0] in ("MMULT", "TRANSPOSE", "MDETERM", "MINVERSE"):
                found.update(tuple(a.places) for a in areas(part) if a.shape in ((3, 3), (4, 4)))
        for component in graph.components:
            sides = [len({p[n] for p in component}) for n in (1, 2)]
            size, along = min(sides), 1 if sides[0] > sides[1] else 2
            if size not in (3, 4) or max(sides) % size or len(component) != sides[0] * sides[1]:
                continue
            for k in range(0, max(sides) if max(sides) <= 3 * size else 0, size):
                tile = tuple(p for p in component if 0 <= p[along] - component[0][along] - k < size)
                uses = [graph.uses[p] for p in tile if p in graph.trees]
                # Three points in rows use numbers typed in their own row; a matrix does not.
                own = [any(s[1] == p[1] and s in self.typed for s in graph.uses.get(p, [p])) for p in tile]
                if max(sides) == size or (len(uses) >= 2 and not all(own)):
                    found[tile] = 99
        for component in graph.components:  # nine elements in one line
            for line in _runs([p for p in component if p in graph.trees or graph.value(p) in (0, 1)]):
                if len(line) == 9 and any(p in graph.trees for p in line):
                    found[line] = 1
        for window, votes in list(found.items()):
            others = [o for o in found if o != window and found[o] >= votes and found[o] > 1]
            numbers = [graph.value(p) for p in window if p not in graph.trees]
            # A matrix has formulas, or else numbers such as cosines and sines make: it is no table of points.
            typed = len(numbers) == len(window) and None not in numbers
            table = typed and (sum(abs(n) > 1 for n in numbers) > 1 or all(n % 1 == 0 for n in numbers))
            typed = {p for p in window if p in self.typed and abs(graph.own[p]) > 1}
            table |= any(len({p[n] for p in typed}) == 1 for n in (1, 2)) and len(typed) > 2
            numbers = [graph.own.get(p) for p in window]
            table |= len(window) == 16 and [0, 0, 0, 1] not in (numbers[12:], numbers[3::4])
            overlaps = any(not set(window).isdisjoint(other) for other in others)
            if table or overlaps or self.turning & set(window) or not graph.component.keys() >= set(window):
                del found[window]
        return sorted(found, key=lambda w: graph.reading_order(w[0]))

    def _turning(self):
        """What goes into a sine or cosine, directly or through cells that only convert or negate.

        And the `composed` of these: angles that a formula makes of other numbers, as of degrees and minutes.
        """
        graph, found, composed = self.graph, set(), set()
        own = {p: np.array([number + 0.37]) for p, number in graph.own.items() if number is not None}
        stack = [p for _, part in graph.parts if part[0] in (*TRIGONOMETRY, "TAN") for p in graph.used_by(part)]
        while stack:
            place = stack.pop()
            if place in found:
                continue
            found.add(place)
            sources = graph.uses.get(place, ())
            if sources and {head for head in heads(graph.trees[place]) if head.isupper()} <= PASSED_ON:
                zeros = [graph.cell(place, {**own, p: np.zeros(1)})[0] for p in sources]
                if len(sources) <= 2 and any(not abs(zero) > 0 for zero in zeros):
                    stack += sources
                    continue
            above = graph.upstream(sources) & graph.trees.keys()
            if sources and not any(heads(graph.trees[p]) & TRIGONOMETRY.keys() for p in (place, *above)):
                composed.add(place)
        for place in found:  # an angle that is made by a formula and then negated
            if graph.tree(place)[0] == "minus" and composed.issuperset(graph.uses[place]):
                composed = composed - set(graph.uses[place]) | {place}
        return found, composed

    def _converts(self, place):
        """Whether a typed number is π, 180 or one such as π/180."""
        near = np.abs(self.graph.own[place] - CONVERSIONS) < 1e-4 * CONVERSIONS
        return place in self.typed and bool(near.any())

    def _constants(self):
        """Typed numbers that are not given: zeros and ones of matrices, numbers over formulas, conversions."""
        graph, found = self.graph, self.typed & {p for window in self.windows for p in window}
        for place in self.turning & self.typed:  # 180 or π multiplies or divides several others
            users = graph.used.get(place, ())
            partners = {s for user in users for s in graph.uses[user]} - {place}
            found |= {place} if self._converts(place) and min(len(users), len(partners)) >= 2 else set()
        given = self.typed & graph.used.keys() - self.turning - found
        quaternions = re.search("quaternion|四元数", self.text, re.I)
        for place, (down, right) in product(given, ((1, 0), (0, 1))):  # (x, y, z, 1), or (0, x, y, z)
            line = [_at(place, n * down, n * right) for n in range(-1, 5)]
            if [p in given for p in line] == [False, True, True, True, True, False]:
                found |= {line[4]} if graph.own[line[4]] == 1 else set()
                found |= {place} if quaternions and graph.own[place] == 0 else set()
        for whole in graph.components:
            formulas = [p for p in whole if p in graph.trees and p not in self.typed]
            if any(not self.turning.isdisjoint(graph.upstream([p])) for p in formulas):
                found |= {p for p in whole if p in self.typed - found and not self._in_typed_line(p, whole)}
        return found

    def _in_typed_line(self, place, whole):
        """Whether a typed number among formulas is given, not typed over one: three of its kind stand in line."""
        for down, right in ((1, 0), (0, 1)):
            line = [place]
            for sign in (1, -1):
                near = place
                while self.graph.component.get(near := _at(near, sign * down, sign * right)) is whole:
                    line.append(near)
            typed = sum(p in self.typed for p in line)
            row = {p in self.typed for p in whole if p[1] == place[1] and p != place} if down else ()
            if typed == 1 < len(line) and len(row) == 2:
                return False
            own = {p: abs(self.graph.own[p]) for p in whole if p in self.typed}
            units = sum(number in (0, 1) for number in own.values())
            if typed >= 3 and (units < 6 or any(own.get(p, 0) not in (0, 1) for p in line)):
                # A quaternion of a turn about one axis has two zeros.
                return not (len(line) == 4 > typed and sum(own.get(p) == 0 for p in line) >= 2)
            if len(line) in (3, 4) and sum(p in self.turning and p not in self.typed for p in line) >= 2:
                return False
        return place in self.turning

    def lines(self, cells, least):
        """Triples of evenly spaced typed cells of which at least `least` are in `cells`, the fullest first."""
        found, steps = {}, [way for step in range(1, 11) for way in ((step, 0), (0, step))]
        for place, (down, right), k in product(cells, steps, range(3)):
            triple = tuple(_at(place, (n - k) * down, (n - k) * right) for n in range(3))
            count = sum(p in cells for p in triple)
            if count >= least and self.typed.issuperset(triple):
                within = [_at(triple[0], n * (down > 0), n * (right > 0)) for n in range(1, 2 * (down + right))]
                # A number within that nobody uses tells that the formula which did is lost.
                count -= any(p in self.typed and p not in self.graph.used for p in within if p not in triple)
                found[triple] = (-count, down + right, self.graph.reading_order(triple[0]))
        return sorted(found, key=found.get)

    def label(self, place):
        """The text to the left of a cell or above it, empty if there is none."""
        cells = self.graph.cells
        left = [cells[p] for n in (1, 2) if (p := _at(place, 0, -n)) in cells][:1]
        above = takewhile(lambda cell: cell, (cells.get(_at(place, -n, 0)) for n in range(1, 60)))
        texts = (cell.value for cell in (*left, *above) if isinstance(cell.value, str) and not cell.formula)
        return next(texts, "")

    # Which calculations there are.

    def _find_calculations(self):
        graph, finals = self.graph, []
        self._respond()
        inner = {w: w if len(w) == 9 else (*w[:3], *w[4:7], *w[8:11]) for w in self.windows}
        moving = {p for p, depends in self.depends.items() if not self.lengths.isdisjoint(depends)}
        self.windows = [w for w in self.windows if len(moving.intersection(inner[w])) < 4]
        for triple in self._triples():
            trees, up = [graph.trees.get(p, ("text",)) for p in triple], graph.upstream(triple)
            # A result less what was expected, or than another result, is a check and not a step.
            difference = all(t[0] == "-" and t[1][0] == t[2][0] == "area" for t in trees)
            difference &= any(s in self.vectors for p in triple for s in graph.uses.get(p, ()))
            # One of which but a cell depends on angles was turned back.
            turned = sum(bool(self.turned_by([p])) for p in triple) > 1
            turned |= any(up & self.typed >= set(w) for w in self.windows)
            (finals if turned and not difference else self.beside).append(triple)
        for triple in finals[:]:
            if self._is_combined(triple, finals):
                finals.remove(triple)
                self.beside.append(triple)
        used = {p for t in finals for p in graph.upstream(t) - set(t)}
        for triple in finals:
            self._add_turn(triple, self.steps if used.issuperset(triple) else self.calculations)
        most = max((len(self._of(w, self.angles)) for w in self.windows), default=0)
        for window in self.windows if not self.calculations and not self.problems else ():
            plane = next((p for p in self.planes if graph.upstream(p.line) & self.turned_by(window)), None)
            own, after = self._of(window, self.angles), graph.downstream(window) - set(window)
            last = all(after.isdisjoint(w) for w in self.windows if w != window)
            if last and plane:
                self._tell(Turn(window, self._angles_of(plane)), self.calculations, plane)
            elif last and len(own) == most > 0 and (angles := self._three(own)):
                self._tell(Turn(window, self._by_name(angles)), self.calculations)
        for component in graph.components:  # the rows of a table have one origin, even if a $ is missing
            rows = [c for c in self.calculations if graph.component[c.results[0]] is component]
            for row in rows:
                row.origin = Counter(each.origin for each in rows).most_common(1)[0][0]
                row.shift = Counter(each.shift for each in rows).most_common(1)[0][0]

    def _is_combined(self, triple, finals):
        """Whether a vector is made of several that go back to different points, as a mean is."""
        up = self.graph.upstream(triple)
        parts = [s for s in finals if s != triple and up.issuperset(s)]
        points = [self.lengths.intersection(*(self.depends.get(p, ()) for p in s)) for s in parts]
        return any(a - b and b - a for a, b in combinations(points, 2))

    def _respond(self):
        """Which inputs each cell depends on, which cells are linear in lengths, and how if no angle turns them.

        This is found by moving each input alone.

        Inputs that no formula has in common move at once, so that a long table needs no more runs than a short one.
        """
        graph, inputs = self.graph, (*self.sorted(self.angles), *self.sorted(self.lengths))
        self.depends, self.reaches, self.unturned, self.unmoved = {}, {}, {}, {}
        together = {p: {p} for p in inputs}
        for place in graph.order:
            sources = graph.uses[place]
            direct = frozenset(together.keys() & sources)
            self.reaches[place] = direct.union(*(self.reaches.get(s, ()) for s in sources if s not in together))
        for reach in set(self.reaches.values()):
            for place in reach if len(reach) <= MOVES else ():
                together[place] |= reach
        turn = {}
        for place in inputs:
            taken = {turn.get(other) for other in together[place]}
            turn[place] = next(k for k in count(1) if k not in taken)
        size = 1 + max(turn.values())
        step = 11.0 + 3 * max((abs(graph.own[p]) for p in self.lengths), default=0)
        moved = {p: np.full(3 * size, graph.own[p] + 7.3 + 1.7 * k) for k, p in enumerate(inputs)}
        for place in inputs:
            n = turn[place]
            if place in self.angles:
                moved[place][n] += 11.0
                moved[place][2 * size :] = 1e-5  # all but nothing is turned
            else:
                moved[place][[n, size + n, 2 * size + n]] += [step, 2 * step, step]
        values = graph.run(moved)
        for place in graph.order:
            reach, value = self.reaches[place], np.broadcast_to(values[place], 3 * size)
            change, lengths = np.abs(value - value[0]), reach & self.lengths
            if not np.isfinite(change[: 2 * size]).all() or len(reach) > MOVES:
                self.depends[place], linear = reach, True  # what it refers to is all that is known
            else:
                small = 1e-9 * (1 + abs(value[0]))
                self.depends[place] = {p for p in reach if change[turn[p]] > small}
                pairs = [(change[turn[p]], change[size + turn[p]]) for p in self.depends[place] & self.lengths]
                linear = any(abs(second - 2 * first) <= 0.01 * first for first, second in pairs)
            if linear and self.depends[place] & self.lengths and place not in self.typed | graph.messages:
                self.vectors.add(place)
                slopes = {p: (value[2 * size + turn[p]] - value[2 * size]) / step for p in lengths}
                self.unturned[place] = {p: round(slope, 3) for p, slope in slopes.items() if abs(slope) > 1e-3}
                turned = {p: (value[turn[p]] - value[0]) / step for p in lengths}
                self.unmoved[place] = {p for p, slope in turned.items() if abs(slope - 1) < 1e-9}

    def turned_by(self, places):
        """The angles on which some cells depend."""
        return {s for p in places for s in self.depends.get(p, ()) if s in self.angles}

    def _of(self, places, inputs):
        """The inputs to which the formulas of some places lead, as they are read."""
        return self.sorted({s for p in places for s in self.reaches.get(p, ()) if s in inputs})

    def _triples(self):
        """Three cells, or four, in line that are a vector: they depend on the same lengths."""
        graph, left, found = self.graph, self.vectors - {p for window in self.windows for p in window}, {}
        for place, (down, right), k in product(left, ((1, 0), (0, 1), (0, 2), (0, 3), (0, 4)), range(3)):
            whole = self.graph.component[place]
            line = tuple(_at(place, (n - k) * down, (n - k) * right) for n in range(3))
            fourth = whole[-1] not in graph.messages and not abs(graph.own[whole[-1]] - 1) > 0  # 1, or an error
            fourth |= graph.is_array((whole[0], whole[-1]))
            if len(whole) == 4 and fourth and 1 in (len({p[n] for p in whole}) for n in (1, 2)):
                line = whole
            inside, apart = left.intersection(line), right > 1
            if apart and (len(inside) < 3 or not left.isdisjoint(_at(line[0], 0, n) for n in range(1, right))):
                continue
            if len(inside) >= 2 and (apart or all(self.graph.component.get(p) is whole for p in line)):
                sets = [self.lengths.intersection(self.depends[p]) for p in inside]
                turned = [cells - self.unmoved.get(p, set()) for p, cells in zip(inside, sets, strict=True)]
                sets = turned if all(turned) else sets  # but for what is added after the turn, each to its own
                alike = len(set.intersection(*sets)) / len(set.union(*sets))
                same = self._in_order([self.unturned.get(p, {}) for p in line[:3]])
                along = 1 if line[0][1] < line[1][1] else 2
                lost = {p for p in line if p in graph.trees and not self.depends[p]}  # by a slip
                shape = not lost | inside >= set(line), apart, not graph.is_array(line)
                rank = alike <= 0.4, -same, -len(inside), *shape
                found[line] = rank, (line[0][0], along, line[0][along])
        aligned, taken, chosen = Counter(), set(), []
        for (_, same, inside, *_), run in found.values():
            aligned[run] += inside + same
        order = self.graph.reading_order
        for line in sorted(found, key=lambda t: (found[t][0], aligned[found[t][1]], order(t[0]))):
            if taken.isdisjoint(line):
                taken.update(line)
                chosen.append(line)
        return sorted(chosen, key=lambda t: order(t[0]))

    @staticmethod
    def _in_order(slopes):
        """How many pairs of three cells come, where no angle turns them, of cells a step apart, as x, y and z."""
        steps = Counter()
        for (i, one), (j, other) in combinations(enumerate(slopes), 2):
            pairs = product(one.items(), other.items())
            apart = {(q[0], (q[1] - p[1]) / (j - i), (q[2] - p[2]) / (j - i)) for (p, a), (q, b) in pairs if a == b}
            steps.update(step for step in apart if any(step[1:]) and not any(n % 1 for n in step[1:]))
        return max(steps.values(), default=0)

    def _add_turn(self, triple, calculations):
        angles, in_row = self._of(triple, self.angles), triple[0][1] == triple[1][1]
        own = tuple(p for p in angles if p[:2] == triple[0][:2])
        angles = own if in_row and len(own) >= 2 and len(angles) > 3 else angles
        plane = next((p for p in self.planes if self.graph.upstream(p.line) & set(angles)), None)
        back = plane or re.search(INVERSE, self.text, re.I)
        shift = self._shift(triple) if back else ()
        point, origin, others = self._moved(triple, shift)
        if len(angles) == 1 and others and re.search(ABOUT_AN_AXIS, self.text, re.I):
            self._tell(Turn(triple, angles, point, axis=others[0]), calculations)
            return
        if plane and point:
            turn = Turn(triple, self._angles_of(plane), point, origin, shift=shift)
            self._tell(turn, calculations, plane)
            return
        chosen = self._three(angles) or self._three(self.sorted(self.angles))
        if chosen is None or not point:
            what = "three angles" if chosen is None else "a point"
            if calculations is self.calculations:
                self.problems.append(f"{self.graph.range(triple)}: {what} not found among its inputs")
            return
        self._tell(Turn(triple, self._by_name(chosen), point, origin, shift=shift), calculations)

    def _angles_of(self, plane):
        """The cells of a plane's angles that are turned by; a third one that is 0 is used by no formula."""
        order = self.graph.calculation_order
        turned_by = [max(self.angles & self.graph.upstream([p]), key=order, default=p) for p in plane.line]
        is_lost = len(turned_by) == 3 and self.graph.own[plane.line[2]] == 0 and turned_by[2] not in self.angles
        return tuple(turned_by[:2] if is_lost else turned_by)

    def _shift(self, triple):
        """What is added to a vector after it is turned, as the origin of a plane is."""
        unmoved = [self.unmoved.get(p, set()) for p in triple[:3]]
        lines = self.lines(set().union(*unmoved), 2)
        fits = (line for line in lines if sum(p in each for p, each in zip(line, unmoved, strict=True)) > 1)
        return next(fits, ())

    def _moved(self, triple, shift=()):
        """The point and the origin of a vector, and other triples of its lengths.

        Where no angle turns it a vector is the point less the origin, whichever formulas make it so.
        """
        slopes, row = [self.unturned.get(p, {}) for p in triple[:3]], triple[0][:2]
        moving, weighed = {s for p in triple for s in self.depends.get(p, ())} & self.lengths, {}
        lines = self._vectors(moving.union(*slopes), row if triple[0][1] == triple[1][1] else None)
        for line in self.lines(set().union(*slopes), 2):
            weights = Counter(each.get(p) for each, p in zip(slopes, line, strict=True) if p in each)
            weight, count = max(weights.items(), key=lambda w: w[1], default=(0, 0))
            if count >= 2:
                weighed.setdefault(weight, []).append((-count, line))
        plus, minus = ([line for _, line in sorted(weighed.pop(w, []), key=lambda c: c[0])] for w in (1, -1))
        plus, minus = _apart([shift, *plus] if shift else plus)[bool(shift) :], _apart(minus)
        if len(plus) != 1 or weighed:
            up = self.graph.upstream(triple)
            means = [t for t in self.beside if up.issuperset(t) and len(t) == 3]
            means = [t for t in means if sum(self.unturned.get(p) == s for p, s in zip(t, slopes, strict=True)) > 1]
            plus = means or plus
        point = self._as_labelled(next(iter((*plus[::-1], *lines)), ())) or self._made_by_formulas(triple)
        origin = next((line for line in minus if set(line).isdisjoint(point)), ())
        return point, origin, [line for line in lines if set(line).isdisjoint((*point, *origin))]

    def _made_by_formulas(self, triple):
        """A point that is calculated, or is 0 without being moved: three in line that all cells of a vector use."""
        used = set.intersection(*(set(self.graph.uses.get(p, ())) for p in triple[:3])) - self.turning
        used -= {p for window in self.windows for p in window}
        return next((line for line in _runs(used) if len(line) == 3), ())

    def _as_labelled(self, point):
        """The point a cell further on, if the labels say that x, y and z are there."""
        for order in (1, -1) if point else ():
            _, near, end = point[::order]
            moved = (near, end, _at(end, end[1] - near[1], end[2] - near[2]))[::order]
            if self.typed.issuperset(moved) and [*map(self._coordinate, moved)] == [(0,), (1,), (2,)]:
                return moved
        return point

    def _coordinate(self, place):
        """Which coordinate a text says that stands before a number, in its row or column."""
        cells = self.graph.cells
        for down, right in ((0, -1), (-1, 0)):
            before = (cells.get(_at(place, n * down, n * right)) for n in range(1, 60))
            texts = (c.value for c in before if c and isinstance(c.value, str) and not c.formula)
            role = read_label(next(texts, ""))
            if role and role.kind == "coordinate":
                return role.word
        return None

    def _three(self, cells):
        """The three inputs that belong together among `cells`, which may hold one too many or one too few."""
        lines = self.lines(set(cells), min(len(cells), 2))
        if len(cells) == 3:  # which may be one of two others and a wrong one
            may = self.angles | (self.typed - self.graph.used.keys())
            return next((line for line in lines if may.issuperset(line)), tuple(cells))
        return lines[0] if lines else None

    def _vectors(self, cells, row):
        """The triples of lengths that a result depends on; that in the row of a table first."""
        own = [line for line in self.lines({p for p in cells if p[:2] == row}, 2) if line[0][1] == line[1][1]]
        return _apart((*own[:1], *self.lines(set(cells), 2)))

    def _by_name(self, triple):
        """The angles α, β, γ: in reading order, unless their labels say otherwise."""
        labels = [self.label(p) for p in triple]
        # Which of φ, θ, ψ comes first is not the same everywhere.
        roles = [read_label(label) for label in labels if not re.search("phi|psi|theta|[φψθ]", label, re.I)]
        named = [role.word for role in roles if role and role.kind == "angle"]
        ordered = sorted(zip(named, triple, strict=False))
        return tuple(p for _, p in ordered) if len(set(named)) == 3 else self.sorted(triple)

    def _as_the_caller_says(self, cells):
        """Take angles, point, origin and result from where the caller says that they stand."""
        given = {name: tuple(self.graph.named(name, text).places) for name, text in cells.items()}
        sizes = {"angles": (3,), "result": (3, 4, 9, 16), "origin": (0, 3)}
        sizes["point"] = (0, 3) if len(given["result"]) > 4 else (3,)
        for name, allowed in sizes.items():
            places = given.setdefault(name, ())
            if len(places) not in allowed:
                raise InputError("cells", "angles, point and result of three cells each", f"no {name} of that size")
            for place in set(places) - self.graph.component.keys():
                raise InputError(f"cells, {name!r}", "numbers or formulas", f"none in {self.graph.address(place)}")
        self.vectors = set(given["result"])
        self._tell(Turn(*(given[name] for name in ("result", "angles", "point", "origin"))), self.calculations)

    # What was asked.

    def _read_the_reading(self):
        """Sequence and convention: the task's, else what the texts say, else those of source 000."""
        task, turns = self.task, [t for t in self.text.splitlines() if re.search(TURNS, t, re.I)]
        said = {"".join(f.groups()).upper() for f in PRIMED.finditer(self.text)}
        said |= {"".join(f.groups()).upper() for t in turns for f in SEQUENCE.finditer(t)}
        said |= {"".join("XYZ"[int(n) - 1] for n in f.groups()) for t in turns for f in NUMBERED.finditer(t)}
        in_words = [re.findall(ONE_AXIS, text, re.I) for text in self.text.splitlines()]
        said |= {"".join(axes).upper() for axes in in_words if len(axes) == 3}
        said &= set(euler.SEQUENCES)
        by_task = task.sequence or ("ZXZ" if task.kind == "zxz" else "")
        by_text = "" if len(said) != 1 else said.pop()
        by_text = by_text.lower() if re.search(FIXED, self.text, re.I) else by_text
        said = [bool(re.search(pattern, self.text, re.I)) for pattern in (ACTIVE, PASSIVE, TRANSPOSED)]
        self.sequence = by_task or by_text or "ZXZ"
        self.active = task.convention == "active" if task.convention else said == [True, False, False]
        self.by = "the task" if by_task else "the text" if by_text else "source 000"

    def _tell(self, calculation, calculations, plane=None):
        calculation.sequence, calculation.active = self.sequence, self.active != bool(calculation.shift)
        name = "a rotation about an axis" if calculation.axis else f"{self.sequence}, as {self.by} says"
        back = ", turned back" * bool(calculation.shift)
        calculation.said = f"{'active' if self.active else 'passive'} rotation, {name}{back}"
        if plane:  # into it less the origin, or out of it and to the origin, or who knows
            calculation.plane, calculation.sequence = plane, plane.sequence
            calculation.active = bool(calculation.shift) if calculation.shift or calculation.origin else None
            calculation.said = f"points by these angles, {plane.sequence}"
        calculations.append(calculation)


def _at(place, down, right):
    return place[0], place[1] + down, place[2] + right


def _runs(places):
    """The longest lines of cells side by side, in rows and in columns."""
    for along, order in ((1, lambda p: p[1:]), (2, lambda p: p[:0:-1])):
        lines = []
        for place in sorted(places, key=order):
            if not lines or place != _at(lines[-1][-1], along == 2, along == 1):
                lines.append([])
            lines[-1].append(place)
        yield from map(tuple, lines)


def _apart(lines):
    """The lines that have no cell in common with one before."""
    found = []
    for line in lines:
        if all(set(line).isdisjoint(other) for other in found):
            found.append(line)
    return found
