"""The three angles of a tilted plane from the directions of its X and Z: G68.2, PLANE EULER, PLANE SPATIAL."""

import re
from dataclasses import dataclass, field

import numpy as np

from mathpost import angles as euler
from mathpost.workbook.formula import walk
from mathpost.workbook.graph import SAMPLES

INVERSE = {"ATAN2", "ATAN", "ACOS", "ASIN"}


@dataclass
class Plane:
    """A calculation whose three `results` are angles; `point` and `axis` are the directions of X and Z."""

    results: tuple
    point: tuple
    axis: tuple
    spatial: bool
    degrees: bool
    said: str = ""
    angles: tuple = ()
    origin: tuple = ()
    words: dict = field(default_factory=dict)
    vectors: dict = field(default_factory=dict)
    target = None

    def draw(self, rng):
        """Place → samples, of frames at random."""
        z = rng.normal(size=(SAMPLES, 3))
        z /= np.linalg.norm(z, axis=1, keepdims=True)
        x = np.cross(rng.normal(size=(SAMPLES, 3)), z)
        x /= np.linalg.norm(x, axis=1, keepdims=True)
        return dict(zip((*self.point, *self.axis), np.concatenate([x, z], axis=1).T, strict=True))

    def prepare(self, values, units):
        """Compute the angles at the samples in `values`; of the two solutions the one that the sheet has."""
        x, z, now = (
            np.stack([np.broadcast_to(values[p], (SAMPLES,)) for p in places], axis=-1)
            for places in (self.point, self.axis, self.results)
        )
        z = z / np.linalg.norm(z, axis=1, keepdims=True)
        x = x - (x * z).sum(axis=1, keepdims=True) * z
        x = x / np.linalg.norm(x, axis=1, keepdims=True)
        frames = np.stack([x, np.cross(z, x), z], axis=-1)
        sequence = "ZYX" if self.spatial else "ZXZ"
        first = euler.angles(sequence, frames)
        both = np.stack([first, euler.twin(sequence, first)], axis=1)
        both = both[..., ::-1] if self.spatial else both
        scale = 180 / np.pi if self.degrees else 1.0
        off = (
            np.abs((now[:, None] - both * scale + 180) % 360 - 180) if self.degrees else np.abs(now[:, None] - both)
        )
        fits = (off < 1e-6).sum(axis=-1)
        branch = np.where(fits[:, 1] > fits[:, 0], 1, 0)
        n = np.arange(SAMPLES)
        turns = np.where(off[n, branch] < 1e-6, np.round((now - both[n, branch] * scale) / 360), 0) * self.degrees
        self.radians, self.expected = both[n, branch], both[n, branch] * scale + 360 * turns

    def targets(self):
        """Place → what must stand there."""
        return dict(zip(self.results, self.expected.T, strict=True))


def planes_of(graph, found):
    """Return the `Plane` calculations of a workbook.

    Parameters
    ----------
    graph : mathpost.workbook.graph.Graph
    found : mathpost.workbook.recognise.Recognised
        Of which the components, the lines of typed cells and the labels are used.
    """
    planes = []
    inverse = {
        p for p in graph.trees if any(part[0] == "call" and part[1] in INVERSE for _, part in walk(graph.trees[p]))
    }
    text = "\n".join(str(cell.value) for cell in graph.cells.values() if isinstance(cell.value, str))
    for component in found.components:
        own = [p for p in component if p in inverse]
        if len(component) != 3 or len(own) < 2:
            continue
        typed = {p for p in graph.upstream(component) if p in found.typed}
        vectors = []
        for line in found.lines(typed, 2) + found.lines(typed, 1):
            if not any(set(line) & set(v) for v in vectors):
                vectors.append(line)
        if len(vectors) != 2:
            continue
        vectors.sort(key=lambda v: graph.reading_order(v[0]))
        if str(found.label(vectors[0][0])).lower().startswith("z"):
            vectors.reverse()
        in_degrees = [
            any(p[:2] == ("call", "DEGREES") or p == ("number", 180.0) for _, p in walk(graph.trees[q]))
            for q in own
        ]
        spatial = bool(re.search(r"SPATIAL|\bSPA\b|空间角", text, re.I))
        said = "PLANE SPATIAL: angles about X, Y, Z" if spatial else "ZXZ angles of a tilted plane"
        planes.append(Plane(tuple(component), *vectors, spatial, sum(in_degrees) * 2 >= len(own), said))
    return planes
