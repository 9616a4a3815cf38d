"""What is this sheet? Inputs, matrices, vectors and results, told by how the formulas use the cells.

Which triple is an angle, a point or an origin follows from where it goes; labels only break ties. The texts also
give the sequence, the order of the angles and the convention. A result is a vector that is turned by three angles
in sequence, or by one about an axis; a sheet of two angles, of single matrices or of other things has none, and is
not judged. An angle that a formula makes by ACOS or ATAN2 counts as given: that formula is not judged.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from itertools import combinations
from typing import TYPE_CHECKING

from mathpost.teaching.workbook.meaning.calculation import Turn
from mathpost.teaching.workbook.meaning.rows import rows_alike
from mathpost.teaching.workbook.meaning.texts import FOREIGN, PASSIVE, SAID_ACTIVE, reading
from mathpost.teaching.workbook.meaning.turns import Turns
from mathpost.teaching.workbook.meaning.vocabulary import wording
from mathpost.teaching.workbook.meaning.words import rows_of
from mathpost.teaching.workbook.sheet.edits import INVERSE as INVERSE_FUNCTIONS
from mathpost.teaching.workbook.sheet.neighbours import filled
from mathpost.teaching.workbook.sheet.tree import heads

if TYPE_CHECKING:
    from mathpost.teaching.workbook.sheet.graph import Graph
    from mathpost.teaching.workbook.sheet.place import Line, Place
    from mathpost.teaching.workbook.task import Task

SMALL = 1e-6  # a slope that is none


class Recognised(Turns):
    """What is what in a workbook.

    Numbers that others use, given or made by an inverse function, are `angles`, `lengths` or `constants`; `vectors`
    depend on lengths. Of these the `steps` are on the way to others, those `beside` are no results; `doubts` has
    some reasons. `by` says who names the reading: the task, the text, or source 000. The reading `is_open` if the
    text names axes but says neither active nor passive, or is in a language that is not understood; `also` are
    readings that it allows as well.
    """

    def __init__(self, graph: Graph, task: Task) -> None:
        super().__init__(graph, with_formulas=task.machine is None)
        self.task = task
        self.problems: list[str] = []
        self.doubts = {}
        self.vectors = set()
        self.depends = {}
        self._ends = {}
        self.calculations = []
        self.beside = []
        self.steps: list[Turn] = []
        read = reading(task, self.text)
        self.sequence, self.active, self.by, unsure, self.names, self.also, self.axes = read
        said = task.convention or self.active or re.search(f"{PASSIVE}|{SAID_ACTIVE}", self.text, re.I)
        more = self.by == "the text" or bool(re.search(FOREIGN, self.text, re.I))
        self.is_open = self.by != "the task" and not said and more
        self.windows = self.matrices()
        self.constants = self.never_moved()
        inputs = {p for p in self.typed if not self.composed.issuperset(graph.used.get(p, ()))} - self.constants
        self.angles, self.lengths = inputs & self.turning, inputs - self.turning
        if task.machine is not None:
            words, self.problems = rows_of(self, task.machine, task.cells)
            self.calculations = [*words]
        elif task.cells:
            self._as_the_caller_says(task.cells)
        elif any(name[:1] == "-" for name in self.names):
            self.problems.append(f"which angle is negated, as in {' '.join(self.names)}?")
        elif self.angles:
            self._find_calculations()
        else:
            none = "no cell goes into a sine or cosine as an angle" if graph.trees else "there are no formulas"
            self.problems.append(none)
        if not any(heads(tree) & INVERSE_FUNCTIONS for tree in graph.trees.values()):
            self.problems += unsure

    def _find_calculations(self) -> None:
        """The rotations of a sheet that turns something, by the vectors that are results."""
        self._respond()
        inner = {w: w if len(w) == 9 else (*w[:3], *w[4:7], *w[8:11]) for w in self.windows}
        self.windows = [w for w in self.windows if len(self.vectors.intersection(inner[w])) < 3]
        finals = self._final_vectors()
        used = {p for t in finals for p in self.graph.upstream(t) - set(t)}
        for triple in finals:
            turn = self._turn_of(triple)
            if isinstance(turn, Turn):
                (self.steps if used.issuperset(triple) else self.calculations).append(turn)
            elif not used.issuperset(triple):
                self.beside.append(triple)
                self.doubts[triple] = f"{self.graph.range(triple)}: {turn} not found among its inputs"
        rows_alike(self)

    def _final_vectors(self) -> list[Line]:
        """The vectors that may be results; the others become those `beside`."""
        finals: list[Line] = []
        for triple in self._triples():
            (finals if self._is_turned(triple) else self.beside).append(triple)
        kept = dict.fromkeys(finals)
        of = {p: t for t in finals for p in t}
        for triple in finals:
            up = self.graph.upstream(triple)
            parts = dict.fromkeys(t for t in [of[p] for p in self.sorted(up & of.keys())] if t in kept)
            if self._is_combined(triple, up, parts):
                del kept[triple]
                self.beside.append(triple)
        return [*kept]

    def _is_turned(self, triple: Line) -> bool:
        """Whether a vector is what a rotation makes of a point, and no check, copy or single coordinate."""
        graph = self.graph
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
        common = set.intersection(*lengths)  # such as a centre; what is added after the turn is each one's own
        own = [each - common - self.unmoved.get(p, set()) for p, each in zip(triple, lengths, strict=True)]
        of_rows = all(own) and not any(a & b for a, b in combinations(own, 2))
        turned &= not (of_rows and all(filled(graph, triple[0], p) == graph.tree(p) for p in triple[1:]))
        of_signs = all(t[0] == "area" or (t[0] == "minus" and t[1][0] == "area") for t in trees)
        mirrored = {t[0] for t in trees} == {"minus", "area"} or re.search(
            wording("mirrored"), self.heading(triple), re.I
        )
        of_signs &= bool(mirrored)  # a mirrored copy, or one that has lost its minus
        return turned and not (difference or of_signs)

    def _is_combined(self, triple: Line, up: set[Place], finals: Mapping[Line, None]) -> bool:
        """Whether a vector is made of several that go back to different points, or angles, as a mean is."""
        own = {s for p in triple for s in self.depends.get(p, ())}
        parts = [s for s in finals if s != triple and len(up.intersection(s)) > 1]
        given = [own.intersection(*(self.depends.get(p, ()) for p in s)) for s in parts]
        given = [
            each for each in given if len(each & self.lengths) > 2
        ]  # not of the terms with x, with y and with z
        pairs = ((a & kind, b & kind) for a, b in combinations(given, 2) for kind in (self.lengths, self.angles))
        return any(a - b and b - a for a, b in pairs)
