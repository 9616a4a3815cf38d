"""The three angles of a tilted plane from the directions of its X and Z: G68.2, PLANE EULER, PLANE SPATIAL."""

import re
from dataclasses import dataclass

import numpy as np

from mathpost import angles as euler
from mathpost.workbook.calculation import Calculation, look, nearest
from mathpost.workbook.edits import INVERSE
from mathpost.workbook.formula import heads, walk
from mathpost.workbook.graph import SAMPLES


@dataclass
class Plane(Calculation):
    """Three angles as results; `point` and `axis` are the directions of X and Z."""

    spatial: bool = False
    degrees: bool = True

    def draw(self, rng, units):
        """Place → samples, of frames at random."""
        z, x = rng.normal(size=(2, SAMPLES, 3))
        z /= np.linalg.norm(z, axis=1, keepdims=True)
        x = np.cross(x, z)
        x /= np.linalg.norm(x, axis=1, keepdims=True)
        return dict(zip((*self.point, *self.axis), np.concatenate([x, z], axis=1).T, strict=True))

    def prepare(self, values, units):
        """Compute the angles at the samples in `values`; of the two solutions the one that the sheet has."""
        x, z = look(values, self.point), look(values, self.axis)
        z = z / np.linalg.norm(z, axis=1, keepdims=True)
        x = x - (x * z).sum(axis=1, keepdims=True) * z
        x = x / np.linalg.norm(x, axis=1, keepdims=True)
        sequence = "ZYX" if self.spatial else "ZXZ"
        first = euler.angles(sequence, np.stack([x, np.cross(z, x), z], axis=-1))
        both = np.stack([first, euler.twin(sequence, first)], axis=1)[..., :: -1 if self.spatial else 1]
        both = np.rad2deg(both) if self.degrees else both
        expected, _ = nearest(look(values, self.results), both, self.degrees)
        self.radians = np.deg2rad(expected) if self.degrees else expected
        self.should_be(self.results, expected)


def planes_of(graph, found):
    """Return the `Plane` calculations of a workbook, with the lines and labels that are `found` in it."""
    planes = []
    for component in graph.components:
        own = [graph.trees[p] for p in component if p in graph.trees and heads(graph.trees[p]) & INVERSE]
        if len(component) != 3 or len(own) < 2:
            continue
        typed, vectors = found.typed - set(component), []
        used = typed & graph.upstream(component)
        for line in found.lines(used, 2) + found.lines(used, 1) + found.lines(typed, 3):
            vectors += [line] * (len(vectors) < 2 and all(set(line).isdisjoint(v) for v in vectors))
        if len(vectors) != 2:
            continue
        vectors.sort(key=lambda v: graph.reading_order(v[0]))
        if found.label(vectors[0][0]).lower().startswith("z"):
            vectors.reverse()
        degrees = sum("DEGREES" in heads(t) or ("number", 180.0) in (p for _, p in walk(t)) for t in own)
        spatial = bool(re.search(r"SPATIAL|\bSPA\b|空间角", found.text, re.I))
        said = "PLANE SPATIAL: angles about X, Y, Z" if spatial else "ZXZ angles of a tilted plane"
        plane = Plane(component, (), vectors[0], (), vectors[1], said, spatial=spatial)
        plane.degrees = 2 * degrees >= len(own)
        planes.append(plane)
    return planes
