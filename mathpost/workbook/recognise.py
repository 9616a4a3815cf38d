"""What is this sheet? Inputs, matrices, vectors and results, told by how the formulas use the cells.

Labels only break ties: which triple is an angle, a point or an origin follows from where it goes.
"""

import re
import tomllib
from collections import Counter
from dataclasses import dataclass, fields
from pathlib import Path

import numpy as np

from mathpost import angles as euler
from mathpost.errors import InputError, read_text
from mathpost.workbook.calculation import Turn
from mathpost.workbook.edits import CONVERSIONS, TRIGONOMETRY
from mathpost.workbook.formula import areas, heads, walk
from mathpost.workbook.nc_table import rows_of
from mathpost.workbook.tilted_plane import planes_of

PASSED_ON = {"RADIANS", "DEGREES", "PI", "MOD", "ROUND"}
SEQUENCE = re.compile(r"(?<![A-Za-z])([XYZ])['’′]*[-–→·, ]*([XYZ])['’′]*[-–→·, ]*([XYZ])['’′]*(?![A-Za-z])", re.I)
TURNS = r"euler|欧拉|rotat|dreh|旋转|sequence|reihenfolge|顺序|axes|achsen|轴|intrins|extrins|rpy"
FIXED = r"fixed axes|extrins|feste[nr]? achsen|固定(坐标)?轴|外旋|static axes"
ACTIVE, PASSIVE = r"\bactive|aktiv|主动", r"passiv|被动"
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

    `typed` are the places of numbers, and of formulas such as =RADIANS(20) that use no cell; those that others use
    are `angles`, `lengths` or `constants`. `turning` go into a sine or cosine, `vectors` depend on lengths; `windows`
    are matrices, row by row. `by` says who names the reading: the task, the text, or source 000.
    """

    def __init__(self, graph, task):
        self.graph, self.task = graph, task
        texts = [c.value for c in graph.cells.values() if isinstance(c.value, str) and not c.formula]
        self.text, self.calculations, self.problems, self.vectors = "\n".join(texts), [], [], set()
        self.typed = {p for p in graph.component if p not in graph.trees and graph.value(p) is not None}
        self.typed |= {p for p in graph.trees if not graph.uses[p] and p not in graph.part}
        self.windows, self.turning = self._windows(), self._turning()
        self.constants = self._constants({p for window in self.windows for p in window})
        inputs = {p for p in self.typed if p in graph.used} - self.constants
        self.angles, self.lengths = inputs & self.turning, inputs - self.turning
        self._read_the_reading()
        if task.machine is not None:
            self.calculations = rows_of(graph, task.machine, task.cells)
        elif task.cells and "result" in task.cells:
            self._as_the_caller_says(task.cells)
        elif self.angles:
            self._find_calculations()
        else:
            self.calculations = planes_of(graph, self)
            if not self.calculations:
                self.problems.append("no cell goes into a sine or cosine as an angle")

    def sorted(self, places):
        """Places as they are read."""
        return tuple(sorted(places, key=self.graph.reading_order))

    def number(self, place):
        """The number that an input cell holds."""
        return float(self.graph.cell(place, {})[0]) if place in self.graph.trees else self.graph.value(place)

    # Which cells are matrices, which are given.

    def _windows(self):
        graph, found = self.graph, Counter()
        for tree in {id(t): t for t in graph.trees.values()}.values():
            for _, part in walk(tree):
                if part[0] in ("MMULT", "TRANSPOSE", "MDETERM", "MINVERSE"):
                    found.update(tuple(a.places) for a in areas(part) if a.shape in ((3, 3), (4, 4)))
        for component in set(graph.component.values()):
            rows, columns = ({p[n] for p in component} for n in (1, 2))
            sides = len(rows), len(columns)
            if len(component) != sides[0] * sides[1]:
                continue
            if sides in ((3, 3), (4, 4)):
                found[component] = 99
            elif sorted(sides) in ([3, 6], [3, 9]):
                along = 1 if sides[0] > 3 else 2
                for k in range(0, max(sides), 3):
                    tile = tuple(p for p in component if 0 <= p[along] - component[0][along] - k < 3)
                    if sum(p in graph.trees for p in tile) >= 2 and not self._points(tile):
                        found[tile] = 50
        for window, votes in list(found.items()):
            others = [o for o in found if o != window and found[o] >= votes and found[o] > 1]
            if any(not set(window).isdisjoint(o) for o in others) or not graph.component.keys() >= set(window):
                del found[window]
        return sorted(filter(self._is_matrix, found), key=lambda w: graph.reading_order(w[0]))

    def _points(self, tile):
        """Whether every row of a tile uses numbers typed in its own row: three points, not a matrix."""
        rows = [[s for s in self.graph.uses[p] if s[1] == p[1]] for p in tile if p in self.graph.trees]
        return all(not self.typed.isdisjoint(row) for row in rows)

    def _is_matrix(self, window):
        """Whether a window has formulas, or else numbers such as cosines and sines make: no table of points."""
        numbers = [self.graph.value(p) for p in window]
        return any(p in self.graph.trees for p in window) or (
            all(abs(n) <= 1 for n in numbers) and any(n % 1 for n in numbers)
        )

    def _turning(self):
        graph, found = self.graph, set()
        stack = [
            p
            for t in graph.trees.values()
            for _, part in walk(t)
            if part[0] in (*TRIGONOMETRY, "TAN")
            for p in graph.used_by(part)
        ]
        while stack:
            place = stack.pop()
            if place not in found:
                found.add(place)
                functions = {head for head in heads(graph.trees.get(place, ("text",))) if head.isupper()}
                if functions <= PASSED_ON and len(graph.uses.get(place, ())) <= 2:
                    stack += graph.uses.get(place, ())
        return found

    def _constants(self, in_window):
        """Typed numbers that are not given: zeros and ones of matrices, numbers over formulas, conversions."""
        graph, found = self.graph, self.typed & in_window
        for place in self.typed - in_window:
            value, whole = self.number(place), graph.component[place]
            fourth = value == 1 and len(whole) == 4 and whole[-1] == place and self.typed.issuperset(whole)
            beside_formulas = any(p in graph.trees and p not in self.typed for p in whole)
            if (
                fourth
                or self._converts(place, value)
                or (beside_formulas and not self._in_typed_line(place, whole))
            ):
                found.add(place)
        return found

    def _converts(self, place, value):
        """Whether a typed number such as 180 or π multiplies or divides several others on their way into a sine."""
        users = self.graph.used.get(place, ())
        partners = {s for user in users for s in self.graph.uses[user]} - {place}
        near = (np.abs(value - CONVERSIONS) < 1e-4 * CONVERSIONS).any()
        return near and place in self.turning and min(len(users), len(partners)) >= 2

    def _in_typed_line(self, place, whole):
        """Whether a typed number among formulas is given, not typed over one: three of its kind stand in line."""
        row = [p for p in whole if p[1] == place[1] and p != place]
        mixed = len({p in self.typed for p in row}) == 2
        for down, right in ((1, 0), (0, 1)):
            line = [place]
            for sign in (1, -1):
                near = place
                while (near := (near[0], near[1] + sign * down, near[2] + sign * right)) in whole:
                    line.append(near)
            typed = sum(p in self.typed for p in line)
            if down and mixed and typed == 1 < len(line):
                return False
            if typed >= 3:  # a quaternion of a turn about one axis has two zeros
                zeros = sum(p in self.typed and self.number(p) == 0 for p in line)
                return not (len(line) == 4 == typed + 1 and zeros >= 2)
            if len(line) in (3, 4) and sum(p in self.turning and p not in self.typed for p in line) >= 2:
                return False
        return place in self.turning

    def lines(self, cells, least):
        """Triples of evenly spaced typed cells of which at least `least` are in `cells`, the fullest first."""
        found = {}
        for sheet, row, column in cells:
            for step, k in ((s, k) for s in range(1, 5) for k in range(3)):
                for down, right in ((step, 0), (0, step)):
                    triple = tuple((sheet, row + (n - k) * down, column + (n - k) * right) for n in range(3))
                    count = sum(p in cells for p in triple)
                    if count >= least and self.typed.issuperset(triple):
                        found[triple] = (-count, step, self.graph.reading_order(triple[0]))
        return sorted(found, key=found.get)

    def label(self, place):
        """The text to the left of a cell or above it, empty if there is none."""
        sheet, row, column = place
        for step, most in (((0, -1), 2), ((-1, 0), 60)):
            for n in range(1, most + 1):
                cell = self.graph.cells.get((sheet, row + n * step[0], column + n * step[1]))
                if cell is not None and isinstance(cell.value, str) and not cell.formula:
                    return cell.value
                if (cell is None) == bool(step[0]):
                    break
        return ""

    # Which calculations there are.

    def _find_calculations(self):
        graph, depends = self.graph, {}
        for place in graph.order:
            sources = graph.uses[place]
            direct = {s for s in sources if s in self.angles or s in self.lengths}
            depends[place] = frozenset(direct).union(*(depends.get(s, ()) for s in sources))
        self.depends = depends
        self.vectors = {p for p in graph.trees if p not in self.typed and depends[p] & self.lengths}
        triples = self._triples()
        finals = [t for t in triples if not self._is_difference(t) and self._turned(t)]
        used = {p for t in finals for p in graph.upstream(t) - set(t)}
        for triple in finals:
            if not used.issuperset(triple):
                self._add_turn(triple)
        if not self.calculations and not self.problems:
            counts = {w: len(self._of(w, self.angles)) for w in self.windows}
            for window, count in counts.items():
                after = graph.downstream(window) - set(window)
                later = any(not after.isdisjoint(w) for w in self.windows if w != window)
                angles = self._three(self._of(window, self.angles)) if count == max(counts.values()) > 0 else None
                if angles and not later:
                    self._tell(Turn(window, self._in_order(angles)))
        self._one_origin_for_a_table()

    def _of(self, places, inputs):
        """The inputs that some places depend on, as they are read."""
        return self.sorted({s for p in places for s in self.depends.get(p, ()) if s in inputs})

    def _triples(self):
        """Three cells, or four, in line that are a vector: they depend on the same lengths."""
        left, found = self.vectors - {p for window in self.windows for p in window}, {}
        for place in left:
            whole = self.graph.component[place]
            if len(whole) == 4 and 1 in (len({p[n] for p in whole}) for n in (1, 2)):
                if len(left.intersection(whole)) >= 2:
                    found[whole] = (0, 0)
                continue
            for k, (down, right) in ((k, step) for k in range(3) for step in ((1, 0), (0, 1))):
                triple = tuple((place[0], place[1] + (n - k) * down, place[2] + (n - k) * right) for n in range(3))
                inside = left.intersection(triple)
                if len(inside) >= 2 and set(whole).issuperset(triple):
                    sets = [self.depends[p] & self.lengths for p in inside]
                    alike = len(frozenset.intersection(*sets)) / len(frozenset.union(*sets))
                    found[triple] = (alike < 0.4, -len(inside))
        runs = {t: (t[0][0], n, t[0][n]) for t in found for n in [1 if t[0][1] < t[1][1] else 2]}
        aligned, taken, chosen = Counter(), set(), []
        for triple, run in runs.items():
            aligned[run] += found[triple][1]
        for triple in sorted(found, key=lambda t: (*found[t], aligned[runs[t]], self.graph.reading_order(t[0]))):
            if taken.isdisjoint(triple):
                taken.update(triple)
                chosen.append(triple)
        return sorted(chosen, key=lambda t: self.graph.reading_order(t[0]))

    def _is_difference(self, triple):
        """Whether a triple is a result less what was expected, or than another result: a check, not a step."""
        trees = [self.graph.trees.get(p, ("text",)) for p in triple]
        return all(t[0] == "-" and t[1][0] == t[2][0] == "area" for t in trees) and any(
            s in self.vectors for p in triple for s in self.graph.uses[p]
        )

    def _turned(self, triple):
        """Whether a vector depends on angles, or on a matrix that somebody typed."""
        up = self.graph.upstream(triple)
        return bool(self._of(triple, self.angles)) or any(up.issuperset(w) for w in self.windows)

    def _add_turn(self, triple):
        angles, in_row = self._of(triple, self.angles), triple[0][1] == triple[1][1]
        own = [p for p in angles if p[:2] == triple[0][:2]]
        angles = own if in_row and len(own) >= 2 and len(angles) > 3 else angles
        vectors = self._vectors(self._of(triple, self.lengths), triple[0] if in_row else None)
        if len(angles) == 1 and len(vectors) == 2 and re.search(ABOUT_AN_AXIS, self.text, re.I):
            axis = max(vectors, key=self._normalised)
            self._tell(Turn(triple, tuple(angles), next(v for v in vectors if v != axis), axis=axis))
            return
        chosen = self._three(angles) or self._three(self.sorted(self.angles))
        if chosen is None or not vectors:
            what = "three angles" if chosen is None else "a point"
            self.problems.append(f"{self.graph.range(triple)}: {what} not found among its inputs")
            return
        origin = max(vectors, key=lambda v: (self._subtracted(v), vectors.index(v))) if len(vectors) > 1 else ()
        point = next(v for v in vectors if v != origin)
        self._tell(Turn(triple, self._in_order(chosen), point, origin))

    def _three(self, cells):
        """The three inputs that belong together among `cells`, which may hold one too many or one too few."""
        if len(cells) == 3:
            return tuple(cells)
        lines = self.lines(set(cells), 2) or (self.lines(set(cells), 1) if len(cells) == 1 else [])
        return lines[0] if lines else None

    def _vectors(self, cells, of_row):
        """The triples of lengths that a result depends on; that in the row of a table first."""
        found, left = [], set(cells)
        own = {p for p in left if of_row and p[:2] == of_row[:2]}
        lines = [t for t in self.lines(own, 2) if t[0][1] == t[1][1]] or self.lines(left, 2)
        while lines:
            found.append(lines[0])
            left -= set(lines[0])
            lines = [t for t in self.lines(left, 2) if all(set(t).isdisjoint(f) for f in found)]
        return found

    def _users(self, vector):
        return [self.graph.trees[user] for place in vector for user in self.graph.used.get(place, ())]

    def _normalised(self, vector):
        """Whether a vector is divided by its length."""
        return any(t[0] == "/" or heads(t) & {"SUMSQ", "SQRT"} for t in self._users(vector))

    def _subtracted(self, vector):
        """How often a vector is taken from another."""
        parts = [part for tree in self._users(vector) for _, part in walk(tree) if part[0] in ("-", "minus")]
        return sum(not set(vector).isdisjoint(self.graph.used_by(part[-1])) for part in parts)

    def _in_order(self, triple):
        """The angles α, β, γ: in reading order, unless their labels say otherwise."""
        names = [re.sub(r"[^a-zα-ω]", "", self.label(p).lower()) for p in triple]
        for order in (("α", "β", "γ"), ("alpha", "beta", "gamma")):
            if sorted(names) == list(order):
                return tuple(triple[names.index(name)] for name in order)
        return self.sorted(triple)

    def _one_origin_for_a_table(self):
        """The rows of a table have one origin: a reference that moves down with the rows does not make another."""
        tables = {}
        for calculation in self.calculations:
            tables.setdefault(self.graph.component[calculation.results[0]], []).append(calculation)
        for rows in tables.values():
            ((origin, _),) = Counter(row.origin for row in rows).most_common(1)
            for row in rows:
                row.origin = origin

    def _as_the_caller_says(self, cells):
        """Take angles, point, origin and result from where the caller says that they stand."""
        given = {name: tuple(self.graph.named(name, text).places) for name, text in cells.items()}
        sizes = {"angles": (3,), "point": (3,), "origin": (0, 3), "result": (3, 4, 9, 16)}
        sizes["point"] = (0, 3) if len(given["result"]) > 4 else (3,)
        for name, allowed in sizes.items():
            if len(given.get(name, ())) not in allowed:
                raise InputError("cells", "angles, point and result of three cells each", f"no {name} of that size")
        for name, places in given.items():
            for place in set(places) - self.graph.component.keys():
                raise InputError(f"cells, {name!r}", "numbers or formulas", f"none in {self.graph.address(place)}")
        self.vectors = set(given["result"])
        self._tell(Turn(given["result"], given["angles"], given.get("point", ()), given.get("origin", ())))

    # What was asked.

    def _read_the_reading(self):
        """Sequence and convention: the task's, else what the texts say, else those of source 000."""
        task, texts = self.task, self.text.splitlines()
        turns = [text for text in texts if re.search(TURNS, text, re.I)]
        said = {"".join(f.groups()).upper() for t in turns for f in SEQUENCE.finditer(t)} & set(euler.SEQUENCES)
        sequence = said.pop() if len(said) == 1 else None
        sequence = sequence and (sequence.lower() if re.search(FIXED, self.text, re.I) else sequence)
        active, passive = (bool(re.search(pattern, self.text, re.I)) for pattern in (ACTIVE, PASSIVE))
        by_task = task.sequence or ("ZXZ" if task.kind == "zxz" else None)
        self.sequence = by_task or sequence or "ZXZ"
        self.active = task.convention == "active" if task.convention else active and not passive
        self.by = "the task" if by_task else "the text" if sequence else "source 000"

    def _tell(self, calculation):
        calculation.sequence, calculation.active = self.sequence, self.active
        name = "a rotation about an axis" if calculation.axis else f"{self.sequence}, as {self.by} says"
        calculation.said = f"{'active' if self.active else 'passive'} rotation, {name}"
        self.calculations.append(calculation)
