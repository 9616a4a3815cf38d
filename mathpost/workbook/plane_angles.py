"""The three angles of a tilted plane, from the directions of its X and Z: what they must be, and where they stand.

Which cells are angles and which are directions is told by the formulas; which direction is which, and whether the
angles are ZXZ or about X, Y and Z, by labels, or else by what gives the most of the angles that are there.
"""

import re
from dataclasses import dataclass
from itertools import permutations, product

import numpy as np

from mathpost import angles as euler
from mathpost.workbook.calculation import Calculation, look, nearest
from mathpost.workbook.edits import CONVERSIONS, INVERSE, take_unrounded
from mathpost.workbook.formula import heads
from mathpost.workbook.graph import SAMPLES

ROUNDED = 2e-3  # what the directions of a frame are off that are written to three decimals
CONVERTING = {"DEGREES", "PI", "ROUND", "MOD", "IF"}
SPATIAL = r"SPATIAL|\bSPA\b|空间角|raumwinkel|G68\.2 *P1|roll"
EULER = r"G68\.2|EULER|EULPR|欧拉|ZXZ"
NORMAL = r"^z|normal|法"
NAMED = (("i", "j", "k"), ("eulpr", "eulnu", "eulrot"), ("spa", "spb", "spc"))


@dataclass(eq=False)
class Plane(Calculation):
    """The three angles of a tilted plane: G68.2, PLANE EULER, PLANE SPATIAL.

    `point` and `axis` are the directions of its X and Z, `origin` that of its Y where it is given too.
    """

    spatial: bool = False
    degrees: bool = True

    @property
    def periods(self):
        """Place of an angle → a turn."""
        return dict.fromkeys(self.results, 360.0 if self.degrees else 2 * np.pi)

    def draw(self, rng, units):
        """Place → samples, of frames at random."""
        frame = _frame(*rng.normal(size=(2, SAMPLES, 3)))
        columns = zip((self.point, self.origin, self.axis), np.moveaxis(frame, -1, 0), strict=True)
        return {p: entry for places, vectors in columns for p, entry in zip(places, vectors.T, strict=False)}

    def unround(self, inputs):
        """Square the frame of the sheet if it is one but for its last digits; else draw others as it is."""
        x, z = (np.stack([inputs[p] for p in places], axis=-1) for places in (self.point, self.axis))
        own_x, own_z = x[0].copy(), z[0].copy()
        lengths = np.linalg.norm([own_x, own_z], axis=1)
        frame, cosine = _frame(own_x, own_z), own_x @ own_z / lengths.prod()
        x[0], z[0] = frame[:, 0], frame[:, 2]
        x += (abs(cosine) > ROUNDED) * cosine * z
        for places, vectors, length in ((self.point, x, lengths[0]), (self.axis, z, lengths[1])):
            vectors = vectors * (length if abs(length - 1) > ROUNDED else 1.0)
            inputs.update(zip(places, vectors.T, strict=True))
        for place, entry in zip(self.origin, frame[:, 1], strict=False):
            inputs[place][0] = entry

    def prepare(self, values, units):
        """Compute the angles at the samples in `values`; of the two solutions the one that the sheet has."""
        frame = _frame(look(values, self.point), look(values, self.axis))
        sequence, step = ("ZYX", -1) if self.spatial else ("ZXZ", 1)
        first, turn = euler.angles(sequence, frame), 180 / np.pi if self.degrees else 1.0
        both = np.stack([first, euler.twin(sequence, first)], axis=1)[..., ::step] * turn
        now = look(values, self.results)
        expected, _ = nearest(now, both, self.degrees)
        made = euler.matrix(sequence, np.nan_to_num(now)[:, ::step] / turn)
        fits = np.isfinite(now).all(axis=1) & (np.abs(made - frame).max(axis=(1, 2)) < 1e-9)
        expected = np.where(fits[:, None], now, expected)  # where first and last axis are parallel
        self.radians = expected / turn
        self.should_be(self.results, expected.T)
        beside = [self.radians, np.rad2deg(self.radians), np.cos(self.radians), np.sin(self.radians)]
        beside = np.hstack([*beside, frame.reshape(SAMPLES, 9), np.zeros((SAMPLES, 1))])
        self.known = {1: [entry[None] for entry in beside.T]}


def _frame(x, z):
    """The matrix of X, Y and Z in columns, from vectors along Z and in the plane of Z and X."""
    y = np.cross(z, x)
    columns = np.stack([np.cross(y, z), y, z], axis=-1)
    return columns / np.linalg.norm(columns, axis=-2, keepdims=True)


def find_planes(found):
    """Yield the `Plane`s of a `Recognised` workbook: three angles in line by inverse functions, from directions."""
    graph, angles, planes = found.graph, _angles(found.graph), {}
    for place, (down, right), k in product(sorted(angles, key=graph.reading_order), ((1, 0), (0, 1)), range(3)):
        line = tuple((place[0], place[1] + (n - k) * down, place[2] + (n - k) * right) for n in range(3))
        cells = angles.intersection(line)
        if line not in planes and len(cells) >= 2 and found.typed.union(cells).issuperset(line):
            planes[line] = _best(found, line)
    taken = set()
    for line, (_, plane) in sorted(planes.items(), key=lambda each: -each[1][0]):
        if plane and taken.isdisjoint(line):
            taken.update(line)
            take_unrounded(graph, line)
            yield plane


def _angles(graph):
    """The angles that come out of inverse functions, in the unit in which they are not converted further."""
    converted, angles = set(), {p for p, tree in graph.trees.items() if heads(tree) & INVERSE}
    for place in graph.order:
        functions = {head for head in heads(graph.trees[place]) if head.isupper()}
        if len(graph.uses[place]) == 1 and functions <= CONVERTING and angles.issuperset(graph.uses[place]):
            angles.add(place)
            converted.update(graph.uses[place])
    return angles - converted


def _best(found, line):
    """How many angles a reading of three cells gives, and the `Plane`; None if they are none."""
    graph, text = found.graph, found.text
    used = graph.upstream(line) & found.typed - graph.trees.keys() - set(line)
    used = {p for p in used if (np.abs(graph.own[p] - CONVERSIONS) > 1e-4 * CONVERSIONS).all()}
    line = _named(found, line)
    said = [bool(re.search(pattern, text, re.I)) for pattern in (EULER, SPATIAL)]
    best = 0, None
    for along, spatial in product((1, 2), (False, True)):
        vectors = _directions(found, used, set(line), along)
        normals = [v for v in vectors if re.search(NORMAL, found.label(v[0]), re.I)]
        for order in (*permutations(vectors), *permutations(vectors[:2])) if vectors else ():
            x, *y, z = order
            if (said[1] != said[0] and spatial != said[1]) or (len(normals) == 1 and z != normals[0]):
                continue
            for degrees in (True, False):
                plane = Plane(line, (), x, *y or ((),), z, spatial=spatial, degrees=degrees)
                fits = _fits(graph, plane)
                best = max(best, (fits, plane), key=lambda each: each[0])
    if best[1]:
        best[1].said = "PLANE SPATIAL: angles about X, Y, Z" if best[1].spatial else "ZXZ angles of a tilted plane"
    return best


def _directions(found, used, line, along):
    """Two or three triples of typed numbers, in rows or in columns, that have those `used`; or none."""
    triples = [each for each in found.lines(used, 1) if each[0][along] != each[1][along]]
    vectors = []
    for each in triples:
        taken = set().union(*vectors)
        if len(vectors) < 3 and (used - taken).intersection(each) and taken.isdisjoint(each):
            vectors.append(each)
    if len(vectors) == 1:  # the angle that uses the other one is lost: the nearest
        (first,) = vectors
        others = [each for each in found.lines(found.typed - line, 3) if each[0][along] != each[1][along]]
        others = [each for each in others if set(each).isdisjoint(first) and each[0][0] == first[0][0]]
        others.sort(key=lambda each: abs(each[0][1] - first[0][1]) + abs(each[0][2] - first[0][2]))
        vectors += others[:1]
    # One cell may be used by mistake.
    return vectors if len(vectors) > 1 and len(used.difference(*vectors)) <= 1 else ()


def _fits(graph, plane):
    """How many of the angles that are there a reading gives; 0 if the directions are none."""
    own = {p: np.array(graph.own[p], dtype=float) for p in (*plane.given, *plane.results)}
    x, y, z = (np.array([own[p] for p in places]) for places in (plane.point, plane.origin, plane.axis))
    if not np.linalg.norm(across := np.cross(z, x)) > 1e-6 or (y.size and not np.abs(across - y).max() < 0.01):
        return 0
    plane.prepare(own, {})
    return sum(abs(own[p] - plane.targets[p][0]) < (0.1 if plane.degrees else 0.002) for p in plane.results)


def _named(found, line):
    """The three cells in the order of the angles that their labels name."""
    names = [re.sub(r"[^a-z].*", "", found.label(place).lower()) for place in line]
    order = next((group for group in NAMED if sorted(names) == sorted(group)), names)
    return tuple(line[names.index(name)] for name in order) if order is not names else line
