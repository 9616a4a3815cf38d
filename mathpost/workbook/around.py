"""What the cells around a cell say that it should hold: a formula that goes on, a range as long as the table.

A cell beside the calculations may be something that is known, and yet not what all around it are.
"""

import re
from functools import cached_property

import numpy as np

from mathpost.workbook.calculation import Turn
from mathpost.workbook.edits import edits, repaired, said
from mathpost.workbook.formula import (
    STATISTICS,
    Area,
    areas,
    form_of,
    heads,
    put,
    text_of,
    unrounded,
    walk,
    with_areas,
)
from mathpost.workbook.given import may_turn
from mathpost.workbook.graph import CLOSE, SAMPLES, beside, offset, same
from mathpost.workbook.label import read_label
from mathpost.workbook.neighbours import along, between, filled

OF_A_PART = r"first|last|ersten|letzten|without|ohne|only|nur|group|gruppe|P\d|mid|mitte|前|后|组|\d *[-–] *\d"
LENGTH = r"^\|[^|]*\|\W*$|\bnorme?\b|\bbetrag\b|\blength\b|\blänge\b|\b3-?d\b|模长|长度"
DISTANCE = r"length|norm|\||betrag|länge|abstand|dist|radius|长|模|距"
OF_LENGTHS = r"²|\^2|squar|quadrat|平方|diff|differenz|error|fehler|%|/|unit|einheit|差|Δ"
DETERMINANT = r"\bd[eé]t|行列式"
DIFFERENCE = r"diff|Δ|abweich|error|fehler|deviation|écart|偏差|误差|差|\bd[xyz]\b"
STATISTIC = {
    **{"AVERAGE": r"\bmean|average|mittel|durchschnitt|moyenne|平均", "SUM": r"\bsum|summe|somme|总和|合计"},
    **{"MAX": r"\bmax|größte|最大", "MIN": r"\bmin(?!u)|kleinste|最小", "SQRT": r"\brms\b|effektiv|均方根"},
}


class Around:
    """The faults of cells that are unlike those around them, by a `Judge`, `is_known(place, tree)` and all `norms`.

    After `faults`, `doubtful` are cells that are something known, but together, or by their label, are not right.
    """

    def __init__(self, judge, is_known, norms):
        self.judge, self.graph, self.found = judge, judge.graph, judge.found
        self.is_known, self.norms = is_known, norms
        graph, found, self.doubtful = self.graph, self.found, set()
        self.still = {p for window in found.windows for p in window} | judge.inputs.keys()
        moved = [p for p in found.typed - self.still if p in graph.used and graph.own[p] is not None]
        drawn = np.random.default_rng(4).uniform(0.3, 3, (len(moved), SAMPLES))
        self.shaken = graph.run(judge.inputs | judge.fixed | dict(zip(found.sorted(moved), drawn, strict=True)))

    def faults(self, rest):
        """Yield the faults of formulas and numbers; those of `rest` are what no result needs."""
        graph = self.graph
        for place in sorted(graph.trees.keys() - graph.part.keys(), key=graph.calculation_order):
            fault = self._short_range(place) if place in rest else None
            if fault := fault or self._unlike(place, place in rest):
                yield fault
        for window in self.found.windows:
            formulas = graph.trees.keys() & set(window)
            if len(window) == 9 and formulas and rest.issuperset(formulas):
                yield from self._in_matrix(window)
        for place in self.found.sorted(rest & graph.trees.keys()):
            yield from self._unlike_its_label(place)
        for place in self.found.sorted(self.found.typed - graph.trees.keys()):
            other = between(graph, place, 4) if place not in self.still else None
            if other and np.isfinite(made := self.judge.calculate(place, other)).all():
                number = graph.own[place]
                if float(f"{number:.2g}") == number:  # it may be meant
                    self.doubtful.add(place)
                    continue
                self.judge.put({place: made})
                yield self.judge.typed_number(place)

    # A formula.

    def _unlike(self, place, is_rest):
        """The fault of a formula where those around it go on another way."""
        graph, judge, tree = self.graph, self.judge, self.graph.trees[place]
        sure = between(graph, place, 4)
        line = (p for p in graph.component.get(place, ()) if p != place and (p[1] == place[1] or p[2] == place[2]))
        if sure and (tree[0] in STATISTICS or any(filled(graph, p, place) == tree for p in line)):
            sure = None  # a row of means, or a sum that starts again
        for other in (sure, between(graph, place, 3), *along(graph, place)) if is_rest else (sure,):
            if other in (None, tree) or _without_numbers(other) == _without_numbers(tree):
                continue  # such as a matrix less that of zeros and ones
            alike = form_of(other) == graph.form(place)
            if other != sure and not (alike and self.is_known(place, other)):
                continue
            made, shaken = judge.calculate(place, other), graph.cell(place, self.shaken, other)
            differs = not same(judge.now(place), made)
            sources = set(graph.used_by(other))
            telling = np.ptp(made[1:]) > CLOSE or any(same(judge.now(p), made) for p in beside(place))
            if not telling or not graph.component.keys() >= sources or (differs and not is_rest):
                continue  # what a result needs is judged elsewhere
            if differs or not same(self.shaken[place], shaken):
                return self._fault(place, other, made)
        return None

    def _fault(self, place, other, made):
        """The fault of a cell that should hold another formula, said by the references or the part that differ."""
        graph, judge, tree = self.graph, self.judge, self.graph.trees[place]
        found = repaired(graph, {place: made}, judge.values)
        cause, sentence, repair = found or ("wrong value", said(place, tree, other), other)
        pairs = [each for each in zip(areas(tree), areas(other), strict=False) if each[0] != each[1]]
        alike = len(areas(tree)) == len(areas(other))
        if alike and len(pairs) == 1 and text_of(with_areas(tree, areas(other))) == text_of(other):
            cause, sentence = "wrong reference", said(place, *(("area", area) for area in pairs[0]))
        elif text_of(repair) != text_of(other):
            cause, sentence = "wrong value", said(place, tree, other)
        judge.put({place: made})
        return judge.fault(place, cause, f"{graph.short(place)}: {sentence}")

    # A matrix, and a label.

    def _in_matrix(self, window):
        """The faults of a matrix beside the calculations, of which one or two cells keep it from a known one."""
        judge, graph = self.judge, self.graph
        now, unit = judge.block(window), np.repeat(np.eye(3).reshape(9, 1), SAMPLES, axis=1)
        known = [unit, *(matrix for c in judge.live for matrix in c.known.get(9, ()))]
        if not may_turn(now[:, 1]):
            return
        off = [[not same(a, b) for a, b in zip(now, matrix, strict=True)] for matrix in known]
        best = min(range(len(known)), key=lambda n: sum(off[n]))
        wrong = [(place, known[best][n]) for n, place in enumerate(window) if off[best][n]]
        if len(wrong) > 2:
            self.doubtful.update(window)
        for place, value in wrong if len(wrong) < 3 else ():
            text = f"{graph.short(place)} keeps {graph.range(window)} from being a matrix of the rotation"
            yield judge.repaired_alone(place, value) or judge.fault(place, "wrong value", text)

    def _unlike_its_label(self, place):
        """The fault of a determinant, length or copy that is not what its label says; a length may be doubtful."""
        graph, judge = self.graph, self.judge
        said = next(iter(self.found.texts(place)), "")
        if re.search(DETERMINANT, said, re.I):
            yield from self._no_determinant(place)
        elif not re.search(OF_LENGTHS, said, re.I):
            yield from self._no_length(place, said)
        yield from self._no_statistic(place)
        is_plain = any(same(judge.now(place), each) for each in self._plain) and re.search(DIFFERENCE, said, re.I)
        if is_plain or any(part[0] == "-" and part[1] == part[2] for _, part in walk(graph.trees[place])):
            self.doubtful.add(place)  # no difference
        near = (graph.cells.get(p) for p in (offset(place, 0, -1), offset(place, -1, 0)))
        label = next((cell.value for cell in near if cell and isinstance(cell.value, str) and not cell.formula), "")
        plain = re.sub(r"\([^()xyz]*\)$", "", label)
        role = read_label(plain) or read_label(label.split(" ")[0]) if "=" not in label else None
        copied = unrounded(graph.trees[place])
        for turn in judge.live if role and role.kind == "outcome" and copied[0] == "area" else ():
            (source, *more), said = copied[1].places, role.word[0]
            if not more and source in turn.results[:3] and turn.results[said] != source:
                text = f"{graph.short(source)} should be {graph.short(turn.results[said])}"
                yield judge.fault(place, "wrong reference", f"{graph.short(place)}: {text}")

    def _no_determinant(self, place):
        """The fault of a determinant, by its label, that is not that of the nine cells it uses."""
        graph, judge, used = self.graph, self.judge, self.graph.uses[place]
        rows, columns = sorted({p[:2] for p in used}), sorted({p[2] for p in used})
        if (len(rows), len(columns)) == (3, 3) and len(used) > 6:
            block = judge.block([(*row, column) for row in rows for column in columns]).reshape(3, 3, -1)
            value = np.linalg.det(np.moveaxis(block, -1, 0))
            if not any(same(judge.now(place), sign * value) for sign in (1, -1)):
                text = f"{graph.short(place)} is not the determinant of the nine cells that it uses"
                yield judge.repaired_alone(place, value) or judge.fault(place, "wrong value", text)

    def _no_statistic(self, place):
        """The fault of a mean, sum, largest or smallest that its only name says to be another one of these."""
        graph, tree = self.graph, self.graph.trees[place]
        in_row = (graph.cells.get((*place[:2], column)) for column in range(1, place[2]))
        texts = [cell.value for cell in in_row if cell and isinstance(cell.value, str)] + self.found.texts(place)
        named = {name for name, pattern in STATISTIC.items() if any(re.search(pattern, t, re.I) for t in texts)}
        if len(named) != 1 or not heads(tree).isdisjoint(named) or tree[0] not in {*STATISTIC, "/"} - {"SQRT"}:
            return
        (name,) = named
        if tree[0] == "/" or name == "SQRT":
            self.doubtful.update([place] * (name == "SQRT"))
            return
        other = (name, *tree[1:])
        self.judge.put({place: self.judge.calculate(place, other)})
        yield self.judge.fault(place, "wrong value", f"{graph.short(place)}: {said(place, tree, other)}")

    @cached_property
    def _plain(self):
        """The coordinates of all points and results, and their lengths."""
        turns = [c for c in self.judge.live if isinstance(c, Turn) and c.point]
        both = [each for c in turns for each in (self.judge.block(c.point), np.array([*c.targets.values()][:3]))]
        return [row for each in both for row in (*each, np.linalg.norm(each, axis=0))]

    def _no_length(self, place, label):
        """The fault of what is said to be a length, and is one but for a repair; without one it is doubtful."""
        graph, judge, tree = self.graph, self.judge, self.graph.trees[place]
        is_length, root = re.search(LENGTH, label, re.I), ("SQRT", tree)
        repairs = [("wrong value", tree, root, root)] * bool(re.search(DISTANCE, label, re.I))
        terms = [text_of(term) for _, part in walk(tree) if part[0] == "+" for term in part[1:] if term[0] != "+"]
        twice = tree[0] == "SQRT" and len({*terms}) < len(terms)  # one coordinate is taken twice
        if not (repairs or twice) or self._is_length(judge.now(place)):
            return
        for cause, old, new, other in (*repairs, *(edits(graph, place) if is_length or twice else ())):
            made = judge.calculate(place, other)
            is_other = cause == "wrong reference" and not twice  # the length of another vector, which is known
            if not is_other and np.abs(made[1:]).max() > CLOSE and self._is_length(made):
                judge.put({place: made})
                yield judge.fault(place, cause, f"{graph.short(place)}: {said(place, old, new)}")
                return
        if is_length:
            self.doubtful.add(place)

    def _is_length(self, value):
        off = np.abs(value - self.norms)[:, 1:] <= CLOSE * (1 + self.norms[:, 1:])
        return bool(off.all(axis=1).any())

    # A range.

    def _short_range(self, place):
        """The fault of a sum, mean or extreme of all but the first or the last cell of a line."""
        tree = self.graph.trees[place]
        parts = [(path, part) for path, part in walk(tree) if part[0] in STATISTICS - {"SUMSQ"}]
        parts = [] if parts and self.is_of_a_part(place) else parts
        for path, part in parts:
            for inner, child in walk(part):
                if child[0] != "area" or sorted(child[1].shape)[0] > 1 or child[1].shape == (1, 1):
                    continue
                area, longer = child[1], self.whole(child[1], place)
                if longer != area and self._is_alone(place, part[0], area, longer):
                    other = put(tree, (*path, *inner), ("area", longer))
                    self.judge.put({place: self.judge.calculate(place, other)})
                    text = f"{self.graph.short(place)}: {said(place, child, ('area', longer))}"
                    return self.judge.fault(place, "wrong reference", text)
        return None

    def whole(self, area, place):
        """A range with what goes on at its ends: formulas of one form, or the same coordinate of further points."""
        graph, places = self.graph, area.places
        step = (0, 1) if area.shape[0] == 1 else (1, 0)
        forms, roles = {*map(graph.form, places)}, self._coordinates
        role = {roles.get(p) for p in places}

        def is_like(p):
            return (
                p != place
                and p in graph.component
                and (
                    graph.form(p) in forms if None not in forms else roles.get(p) in role and graph.form(p) is None
                )
            )

        if graph.is_array(places) or len(forms) > 1 or (None in forms and (len(role) > 1 or None in role)):
            return area
        first, last = places[0], places[-1]
        while is_like(offset(first, -step[0], -step[1])):
            first = offset(first, -step[0], -step[1])
        while is_like(offset(last, *step)):
            last = offset(last, *step)
        return Area(first[0], *first[1:], *last[1:], area.fixed)

    def is_of_a_part(self, place):
        """Whether a text in its row says that a cell is of some of the points only."""
        texts = (cell.value for p, cell in self.graph.cells.items() if p[:2] == place[:2] and not cell.formula)
        return any(re.search(OF_A_PART, text, re.I) for text in texts if isinstance(text, str))

    @property
    def _coordinates(self):
        """Place of a given number → which coordinate it is, of a point."""
        return {p: n for c in self.judge.live for n, p in enumerate(c.point)}

    def _is_alone(self, place, head, area, longer):
        """Whether all others in its row, or column, that take the same of a line go as far as the longer one."""
        along, found = (1 if area.shape[1] == 1 else 2), []
        for p, tree in self.graph.trees.items():
            if p != place and (p[0], p[along]) == (place[0], place[along]):
                others = [child[1] for _, part in walk(tree) if part[0] == head for child in part[1:2]]
                others = [other for other in others if isinstance(other, Area)]
                found += [other for other in others if (other.shape[1] == 1) == (along == 1)]
        ends = longer.places[0][along], longer.places[-1][along]
        return bool(found) and all((each.places[0][along], each.places[-1][along]) == ends for each in found)


def _without_numbers(tree):
    return tuple(
        _without_numbers(part) if isinstance(part, tuple) else part for part in tree if tree[0] != "number"
    )
