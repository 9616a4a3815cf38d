"""What is this sheet? Inputs, matrices, vectors and results, told by how the formulas use the cells.

Labels only break ties: which triple is an angle, a point or an origin follows from where it goes.
"""

import re
import tomllib
from collections import Counter
from dataclasses import dataclass, field, fields
from functools import reduce
from pathlib import Path

import numpy as np
import sympy as sp

from mathpost import angles as euler
from mathpost.errors import InputError, read_text
from mathpost.rotation import ACTIVE, about, numeric
from mathpost.workbook.formula import areas, walk
from mathpost.workbook.graph import SAMPLES, area_named
from mathpost.workbook.nc_table import rows_of
from mathpost.workbook.tilted_plane import planes_of

TRIGONOMETRY = {"SIN", "COS", "TAN"}
PASSED_ON = {"RADIANS", "DEGREES", "PI", "MOD", "ROUND"}
CONVERSIONS = (np.pi, np.pi / 180, 180 / np.pi, 180.0, 2 * np.pi, 200 / np.pi)
SEQUENCE = re.compile(r"(?<![A-Za-z])([XYZ])['’′]*[-–→·, ]*([XYZ])['’′]*[-–→·, ]*([XYZ])['’′]*(?![A-Za-z])", re.I)
ABOUT_TURNS = re.compile(
    r"euler|欧拉|rotat|dreh|旋转|sequence|reihenfolge|顺序|axes|achsen|轴|intrins|extrins|rpy", re.I
)
FIXED = re.compile(r"fixed axes|extrins|feste[nr]? achsen|固定(坐标)?轴|外旋|static axes", re.I)
SAID_ACTIVE = re.compile(r"\bactive|aktiv|主动", re.I)
SAID_PASSIVE = re.compile(r"passiv|被动", re.I)


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


@dataclass
class Calculation:
    """One rotation in the workbook: its inputs, its results, and what these ought to be."""

    results: tuple
    angles: tuple
    point: tuple = ()
    origin: tuple = ()
    axis: tuple = ()
    sequence: str = "ZXZ"
    active: bool = False
    said: str = ""
    words: dict = field(default_factory=dict)

    def prepare(self, values, units):
        """Compute, for the samples in `values`, the products and the vectors that may stand in the sheet."""
        look = lambda places: np.stack([np.broadcast_to(values[p], (SAMPLES,)) for p in places], axis=-1)  # noqa: E731
        self.radians = np.stack([values[p] * units[p] for p in self.angles], axis=-1)
        shift = np.tile(np.eye(4), (SAMPLES, 1, 1))
        if self.origin:
            shift[:, :3, 3] = -look(self.origin)
        factors = self._factors(values, look)
        names = list(factors)
        chain = [np.pad(f, ((0, 0), (0, 1), (0, 1))) + np.diag([0, 0, 0, 1.0]) for f in factors.values()]
        self.words = {}
        for first in range(len(chain)):
            for last in range(first, len(chain)):
                product = reduce(np.matmul, chain[first : last + 1])
                self._add("".join(names[first : last + 1]), product)
                if self.origin and last == len(chain) - 1:
                    self.words["shift"] = shift
                    self._add("".join(names[first:]) + "·shift", product @ shift)
        self.full = "".join(names)
        self.matrix = self.words[self.full]
        self.vectors = {}
        if self.point:
            p = np.concatenate([look(self.point), np.ones((SAMPLES, 1))], axis=-1)[..., None]
            moved = shift @ p
            self.vectors["p − origin"], self.vectors["p"] = moved[:, :, 0], p[:, :, 0]
            for first in range(len(chain)):
                turned = reduce(np.matmul, chain[first:]) @ moved
                self.vectors["".join(names[first:]) + "·p"] = turned[:, :, 0]
            self.target = self.vectors[self.full + "·p"]
        else:
            self.target = None

    def targets(self):
        """Place of a result → what must stand there."""
        places = self.results
        if len(places) < 9:
            return dict(zip(places, self.target.T, strict=False))
        size = 3 if len(places) == 9 else 4
        word = self.full + "·shift" if size == 4 and self.origin else self.full
        return dict(zip(places, self.words[word][:, :size, :size].reshape(SAMPLES, -1).T, strict=True))

    def _add(self, name, product):
        self.words[name] = product
        self.words[name + "ᵀ"] = np.linalg.inv(product)

    def _factors(self, values, look):
        if self.axis:
            unit = look(self.axis) / np.linalg.norm(look(self.axis), axis=-1, keepdims=True)
            symbols = sp.symbols("ux uy uz t", real=True)
            matrix = numeric(sp.ImmutableMatrix(about(symbols[:3], symbols[3])), symbols)(
                *unit.T, self.radians[:, 0]
            )
            return {"R": matrix if self.active else np.swapaxes(matrix, 1, 2)}
        order = list(zip("αβγ", self.sequence.upper(), self.radians.T, strict=True))
        if self.sequence.isupper() != self.active:
            order = order[::-1]
        return {name: self._elementary(letter, angle) for name, letter, angle in order}

    def _elementary(self, letter, angle):
        return elementary(letter, angle if self.active else -angle)


def elementary(letter, angle):
    """The active matrix about an axis, shape (..., 3, 3), from the package's expression."""
    t = sp.Symbol("t")
    return numeric(sp.ImmutableMatrix(ACTIVE[letter](t)), (t,))(angle)


class Recognised:
    """What is what in a workbook.

    Attributes
    ----------
    inputs : dict
        Place → ``"angle"``, ``"length"`` or ``"constant"``.
    units : dict
        Place of an angle → the factor that makes it radians.
    windows : list of tuples
        Nine or sixteen places, row by row, of each matrix.
    calculations : list of `Calculation`
    seen : list of str
    """

    def __init__(self, graph, task):
        self.graph, self.task = graph, task
        self.seen, self.problems = [], []
        self.typed = {p for p, cell in graph.cells.items() if cell.meant is not None and not cell.formula} | {
            p for p in graph.trees if not graph.uses[p] and p not in graph.part
        }
        self.numeric = {p for p, cell in graph.cells.items() if cell.formula or cell.meant is not None}
        self.components = sorted(self._components(), key=lambda c: graph.reading_order(c[0]))
        self.component = {p: c for c in self.components for p in c}
        self.windows = self._windows()
        in_window = {p for window in self.windows for p in window}
        self.tainted = self._angles()
        self.constants = self._constants(in_window)
        feeding = {p for p in self.typed if p in graph.used}
        self.angle_cells = [p for p in self._sorted(feeding & self.tainted) if p not in self.constants]
        others = feeding - self.tainted - self.constants
        self.length_cells = self._sorted(others)
        self.calculations, self.vector_cells = [], set()
        if task.cells and task.machine is None and "result" in task.cells:
            self._as_the_caller_says(task.cells)
        elif task.machine is not None:
            self.calculations = rows_of(graph, task.machine, task.cells)
            self.angle_cells, self.length_cells = [], []
        else:
            self._calculations()

    def _sorted(self, places):
        return sorted(places, key=self.graph.reading_order)

    # Geometry.

    def _components(self):
        left = set(self.numeric)
        while left:
            stack, found = [left.pop()], []
            while stack:
                place = stack.pop()
                found.append(place)
                sheet, row, column = place
                for near in (
                    (sheet, row + 1, column),
                    (sheet, row - 1, column),
                    (sheet, row, column + 1),
                    (sheet, row, column - 1),
                ):
                    if near in left:
                        left.remove(near)
                        stack.append(near)
            yield self._sorted(found)

    def _windows(self):
        found = {}
        graph = self.graph
        for tree in {id(t): t for t in graph.trees.values()}.values():
            for _, part in walk(tree):
                if part[0] == "call" and part[1] in ("MMULT", "TRANSPOSE", "MDETERM", "MINVERSE"):
                    for area in areas(part):
                        if area.shape in ((3, 3), (4, 4)):
                            places = tuple(area.places)
                            found[places] = found.get(places, 0) + 1
        for component in self.components:
            rows = sorted({p[1] for p in component})
            columns = sorted({p[2] for p in component})
            for size in (3, 4):
                full = len(component) == len(rows) * len(columns)
                if full and (len(rows), len(columns)) == (size, size):
                    found[tuple(component)] = 99
                elif full and size == 3 and {len(rows), len(columns)} in ({3, 6}, {3, 9}):
                    for k in range(0, max(len(rows), len(columns)), 3):
                        tile = [
                            p
                            for p in component
                            if 0 <= (p[1] - rows[0] if len(rows) > 3 else p[2] - columns[0]) - k < 3
                        ]
                        if sum(p in graph.trees for p in tile) >= 2 and self._one_matrix(tile):
                            found[tuple(tile)] = 50
        for places, votes in list(found.items()):
            clash = [
                o for o in found if o != places and set(o) & set(places) and found[o] >= votes and found[o] > 1
            ]
            if clash or not all(p in self.numeric for p in places):
                found.pop(places)
        return [w for w in sorted(found, key=lambda w: graph.reading_order(w[0])) if self._is_matrix(w)]

    def _is_matrix(self, window):
        """Whether a window has formulas, or else numbers such as cosines and sines make: no table of points."""
        if any(p in self.graph.trees for p in window):
            return True
        return all(abs(self.graph.value(p)) <= 1 for p in window) and any(self.graph.value(p) % 1 for p in window)

    def _one_matrix(self, tile):
        """Whether a tile holds constants such as 0 and 1 or formulas that do not form three rows of results."""
        rows = {}
        for place in tile:
            rows.setdefault(place[1], set()).update(self.graph.uses.get(place, ()))
        return len({frozenset(r) for r in rows.values()}) <= 3 and not self._is_table(tile)

    def _is_table(self, tile):
        """Whether every row of a tile uses numbers typed in its own row: three points, not a matrix."""
        return all(any(s[1] == p[1] and s in self.typed for s in self.graph.uses.get(p, ())) for p in tile)

    def _constants(self, in_window):
        """Typed numbers that are no inputs: zeros and ones of matrices, numbers over formulas, conversions."""
        found = {p for p in self.typed & in_window}
        for place in self.typed - in_window:
            value = self.graph.value(place)
            if value is None:
                value = (
                    float(self.graph.calculate(self.graph.trees[place], {})[0, 0, 0])
                    if place in self.graph.trees
                    else 0
                )
            whole = self.component[place]
            if value == 1 and len(whole) == 4 and whole[-1] == place and self.typed.issuperset(whole):
                found.add(place)  # the fourth coordinate
                continue
            if any(abs(value - c) < 1e-4 * c for c in CONVERSIONS) and self._converts(place):
                found.add(place)
                continue
            component = self.component[place]
            formulas = [p for p in component if p in self.graph.trees and p not in self.typed]
            if formulas and not self._in_typed_line(place, component):
                found.add(place)
        return found

    def _converts(self, place):
        """Whether a typed number multiplies or divides several others, on their way into a sine or cosine."""
        users = self.graph.used.get(place, ())
        partners = {s for u in users for s in self.graph.uses[u] if s != place}
        return len(users) >= 2 and len(partners) >= 2 and place in self.tainted

    def _in_typed_line(self, place, component):
        inside = set(component)
        sheet, row, column = place
        for dr, dc in ((1, 0), (0, 1)):
            line, step = [place], 1
            while (near := (sheet, row + dr * step, column + dc * step)) in inside:
                line.append(near)
                step += 1
            step = 1
            while (near := (sheet, row - dr * step, column - dc * step)) in inside:
                line.append(near)
                step += 1
            line = self._sorted(line)
            others = [p for p in line if p != place]
            if dr and others and not any(p in self.typed for p in others) and self._in_table(place, inside):
                return False
            if len([p for p in line if p in self.typed]) >= 3:
                return True
            if len(line) in (3, 4) and sum(p in self.tainted and p not in self.typed for p in line) >= 2:
                return False
        return place in self.tainted

    def _in_table(self, place, inside):
        """Whether numbers and formulas stand side by side in the row of a place."""
        row = [p for p in inside if p[1] == place[1] and p != place]
        return any(p in self.typed for p in row) and any(p not in self.typed for p in row)

    # Roles.

    def _angles(self):
        """The cells that go into a sine or cosine, directly or through cells that only convert or negate."""
        found, stack = set(), []
        for tree in {id(t): t for t in self.graph.trees.values()}.values():
            for _, part in walk(tree):
                if part[0] == "call" and part[1] in TRIGONOMETRY:
                    stack += self.graph.used_by(part)
        while stack:
            place = stack.pop()
            if place in found:
                continue
            found.add(place)
            tree = self.graph.trees.get(place)
            converts = tree and all(p[0] != "call" or p[1] in PASSED_ON for _, p in walk(tree))
            if converts and len(self.graph.uses[place]) <= 2:
                stack += self.graph.uses[place]
        return found

    def lines(self, cells, least=2):
        """Triples of evenly spaced typed cells of which at least `least` are in `cells`, the fullest first."""
        cells, found = set(cells), []
        for place in {
            (p[0], p[1] + dr, p[2] + dc)
            for p in cells
            for dr, dc in [(0, 0)] + [(-k, 0) for k in range(1, 9)] + [(0, -k) for k in range(1, 9)]
        }:
            for step in range(1, 5):
                for dr, dc in ((step, 0), (0, step)):
                    triple = tuple((place[0], place[1] + k * dr, place[2] + k * dc) for k in range(3))
                    if all(p in self.typed for p in triple):
                        count = sum(p in cells for p in triple)
                        if count >= least:
                            found.append((-count, step, self.graph.reading_order(triple[0]), triple))
        return [triple for *_, triple in sorted(found)]

    def _triple(self, cells):
        """The three inputs that belong together among `cells`, which may hold one too many or one too few."""
        if len(cells) == 3:
            return tuple(cells)
        lines = self.lines(cells, 2) or (self.lines(cells, 1) if len(cells) == 1 else [])
        return lines[0] if lines else None

    def _calculations(self):
        graph = self.graph
        lengths, angles = set(self.length_cells), set(self.angle_cells)
        if not angles:
            self.calculations = planes_of(graph, self)
            self.length_cells = []
        if not angles and not self.calculations:
            self.problems.append("no cell goes into a sine or cosine as an angle")
        if not angles:
            return
        depends = self._dependence(lengths | angles)
        self.vector_cells = {
            p for p in graph.trees if p not in self.typed and depends.get(p, frozenset()) & lengths
        }
        triples = self._vector_triples(depends, lengths)
        used_by_triples = set()
        for triple in triples:
            used_by_triples |= graph.upstream(triple) - set(triple)
        finals = [t for t in triples if not self._is_difference(t)]
        reached = set()
        for t in finals:
            reached |= graph.upstream(t) - set(t)
        finals = [t for t in finals if not all(p in reached for p in t) or self._only_checked(t, finals)]
        finals = [t for t in finals if self._turned(t, depends, angles)]
        for triple in finals:
            self._calculation(triple, depends, lengths, angles)
        if not finals:
            for window in self._final_windows(depends, angles):
                chosen = self._triple(self._sorted({a for p in window for a in depends.get(p, ()) if a in angles}))
                if chosen:
                    self.calculations.append(self._told(Calculation(results=window, angles=self._ordered(chosen))))

    def _turned(self, triple, depends, angles):
        """Whether a vector depends on angles, or on a matrix that somebody typed."""
        if any(depends.get(p, frozenset()) & angles for p in triple):
            return True
        up = self.graph.upstream(triple)
        return any(up.issuperset(w) for w in self.windows)

    def _as_the_caller_says(self, cells):
        """Take angles, point, origin and result from where the caller says that they stand."""
        given = {name: tuple(area_named(self.graph, name, text).places) for name, text in cells.items()}
        for name in ("angles", "result"):
            if len(given.get(name, ())) not in (3, *(4, 9, 16) * (name == "result")):
                raise InputError("cells", "angles, point and result of three cells each", f"no {name} of that size")
        for name, places in given.items():
            for place in places:
                if place not in self.numeric:
                    raise InputError(
                        f"cells, {name!r}", "numbers or formulas", f"none in {self.graph.address(place)}"
                    )
        self.vector_cells = set(given["result"])
        self.calculations.append(
            self._told(
                Calculation(given["result"], given["angles"], given.get("point", ()), given.get("origin", ()))
            )
        )

    def _dependence(self, leaves):
        depends = {}
        for place in self.graph.order:
            sources = self.graph.uses[place]
            depends[place] = frozenset(s for s in sources if s in leaves).union(
                *(depends.get(s, frozenset()) for s in sources if s in self.graph.trees)
            )
        return depends

    def _vector_triples(self, depends, lengths):
        found, left = [], self.vector_cells - {p for window in self.windows for p in window}
        for component in self.components:
            cells = [p for p in component if p in left]
            if not cells:
                continue
            if (
                len(component) == 4
                and len(cells) >= 2
                and (len({p[1] for p in component}) == 1 or len({p[2] for p in component}) == 1)
            ):
                found.append(tuple(component))
                continue
            found += self._split(cells, set(component), depends, lengths)
        return found

    def _split(self, cells, component, depends, lengths):
        inside = set(cells)
        rows, columns = sorted({p[1] for p in cells}), sorted({p[2] for p in cells})
        sheet = cells[0][0]

        def fits(lines):
            return [
                line for line in lines if sum(p in inside for p in line) >= 2 and all(p in component for p in line)
            ]

        wide = (
            fits([tuple((sheet, r, columns[0] + k) for k in range(3)) for r in rows])
            if columns[-1] - columns[0] in (1, 2, 3)
            else []
        )
        tall = (
            fits([tuple((sheet, rows[0] + k, c) for k in range(3)) for c in columns])
            if rows[-1] - rows[0] in (1, 2, 3)
            else []
        )
        if columns[-1] - columns[0] == 1:
            wide = fits([tuple((sheet, r, columns[0] + d + k) for k in range(3)) for r in rows for d in (-1, 0)])
        if rows[-1] - rows[0] == 1:
            tall = fits([tuple((sheet, rows[0] + d + k, c) for k in range(3)) for c in columns for d in (-1, 0)])
        if wide and tall:
            alike = sum(len({depends.get(p, frozenset()) & lengths for p in line}) == 1 for line in wide) / len(
                wide
            )
            other = sum(len({depends.get(p, frozenset()) & lengths for p in line}) == 1 for line in tall) / len(
                tall
            )
            if len(wide) != len(tall):
                return wide if len(wide) > len(tall) else tall
            return wide if alike > other else tall
        return wide or tall

    def _is_difference(self, triple):
        """Whether a triple is a result less what was expected, or than another result: a check, not a step."""
        trees = [self.graph.trees.get(p) for p in triple]
        return all(tree and tree[0] == "-" and tree[1][0] == tree[2][0] == "area" for tree in trees) and any(
            s in self.vector_cells for p in triple for s in self.graph.uses[p]
        )

    def _only_checked(self, triple, finals):
        """Whether no later final uses the triple."""
        others = [t for t in finals if t != triple]
        return not any(set(triple) & self.graph.upstream(t) for t in others)

    def _final_windows(self, depends, angles):
        graph = self.graph
        most = max(
            (len({a for p in w for a in depends.get(p, ()) if a in angles}) for w in self.windows), default=0
        )
        for window in self.windows:
            reached = {q for p in window for q in graph.downstream([p])} - set(window)
            if (
                {a for p in window for a in depends.get(p, ()) if a in angles}
                and not any(set(other) & reached for other in self.windows if other != window)
                and len({a for p in window for a in depends.get(p, ()) if a in angles}) == most
            ):
                yield window

    def _calculation(self, triple, depends, lengths, angles):
        reached = frozenset().union(*(depends.get(p, frozenset()) for p in triple))
        own_angles = self._sorted(reached & angles)
        in_row = [p for p in own_angles if p[:2] == triple[0][:2]]
        if triple[0][1] == triple[1][1] and len(in_row) >= 2 and len(own_angles) > 3:
            own_angles = in_row
        text = self._text()
        about_axis = len(own_angles) == 1 and re.search(
            r"rodrig|罗德里格|任意轴|about an axis|um eine achse|axis.angle|轴角", text, re.I
        )
        vectors = self._vectors(reached & lengths, triple)
        if about_axis and len(vectors) == 2:
            axis = self._axis_of(vectors, triple)
            point = next(v for v in vectors if v != axis)
            self.calculations.append(self._told(Calculation(triple, tuple(own_angles), point, (), axis)))
            return
        chosen = self._triple(own_angles) or self._triple(self.angle_cells)
        if chosen is None or not vectors:
            what = "three angles" if chosen is None else "a point"
            self.problems.append(f"{self.place_text(triple)}: {what} not found among its inputs")
            return
        point, origin = self._point_and_origin(vectors)
        self.calculations.append(self._told(Calculation(triple, self._ordered(chosen), point, origin)))

    def _vectors(self, cells, triple):
        """The triples of lengths that a result depends on."""
        found, left = [], set(cells)
        same_row = [p for p in left if p[0] == triple[0][0] and p[1] == triple[0][1]]
        if triple[0][1] == triple[1][1] and len(same_row) >= 2:  # a row of a table has its point in the same row
            lines = [t for t in self.lines(same_row, 2) if t[0][1] == t[1][1]]
            if lines:
                found.append(lines[0])
                left -= set(lines[0])
        while True:
            lines = [t for t in self.lines(left, 2) if not any(set(t) & set(f) for f in found)]
            if not lines:
                return found
            found.append(lines[0])
            left -= set(lines[0])

    def _axis_of(self, vectors, triple):
        """Of two vectors, the one whose cells are divided by a length, or go into one first."""
        for vector in vectors:
            for user in self.graph.used.get(vector[0], ()):
                if self.graph.trees[user][0] == "/" or any(
                    p[0] == "call" and p[1] in ("SUMSQ", "SQRT") for _, p in walk(self.graph.trees[user])
                ):
                    return vector
        return vectors[0]

    def _point_and_origin(self, vectors):
        if len(vectors) == 1:
            return vectors[0], ()
        taken = Counter()
        for vector in vectors:
            for place in vector:
                for user in self.graph.used.get(place, ()):
                    for _, part in walk(self.graph.trees[user]):
                        right = part[2] if part[0] == "-" else part[1] if part[0] == "minus" else None
                        if right is not None and place in self.graph.used_by(right):
                            taken[vector] += 1
        origin = max(vectors, key=lambda v: (taken[v], vectors.index(v)))
        return next(v for v in vectors if v != origin), origin

    def _ordered(self, triple):
        """The angles α, β, γ: in reading order, unless their labels say otherwise."""
        names = [re.sub(r"[^a-zα-ω]", "", str(self.label(p)).lower()) for p in triple]
        for order in (("α", "β", "γ"), ("alpha", "beta", "gamma")):
            if sorted(names) == sorted(order):
                return tuple(triple[names.index(name)] for name in order)
        return tuple(self._sorted(triple))

    def label(self, place):
        """The text beside or above a cell, empty if there is none."""
        sheet, row, column = place
        for step in range(1, 3):
            cell = self.graph.cells.get((sheet, row, column - step))
            if cell is not None:
                if isinstance(cell.value, str) and not cell.formula:
                    return cell.value
                break
        for step in range(1, 60):
            cell = self.graph.cells.get((sheet, row - step, column))
            if cell is None:
                break
            if isinstance(cell.value, str) and not cell.formula:
                return cell.value
        return ""

    def _text(self):
        return "\n".join(
            cell.value for cell in self.graph.cells.values() if isinstance(cell.value, str) and not cell.formula
        )

    def _told(self, calculation):
        """Set sequence and convention: the task's, else what the texts say, else those of source 000."""
        texts = self._text().splitlines()
        turns = [t for t in texts if ABOUT_TURNS.search(t)]
        said = {"".join(f.groups()).upper() for t in turns for f in SEQUENCE.finditer(t)} & set(euler.SEQUENCES)
        sequence = said.pop() if len(said) == 1 else None
        if sequence and any(FIXED.search(t) for t in texts):
            sequence = sequence.lower()
        active = any(SAID_ACTIVE.search(t) for t in texts)
        passive = any(SAID_PASSIVE.search(t) for t in texts)
        task = self.task
        calculation.sequence = task.sequence or ("ZXZ" if task.kind == "zxz" else sequence) or "ZXZ"
        if task.convention:
            calculation.active = task.convention == "active"
        else:
            calculation.active = active and not passive
        by = "the task" if task.sequence or task.kind == "zxz" else "the text" if sequence else "source 000"
        kind = "active" if calculation.active else "passive"
        name = "a rotation about an axis" if calculation.axis else f"{calculation.sequence}, as {by} says"
        calculation.said = f"{kind} rotation, {name}"
        return calculation

    def place_text(self, places):
        """The first and the last of some places, as ``Sheet!B2:B4``."""
        first, last = self.graph.address(places[0]), self.graph.short(places[-1])
        return first if places[0] == places[-1] else f"{first}:{last}"
