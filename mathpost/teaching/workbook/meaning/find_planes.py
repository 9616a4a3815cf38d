"""Where a sheet calculates the angles of a tilted plane.

The formulas show which cells are angles and which are directions. Labels say which direction is which; without
labels, the assignment that gives most of the angles found is taken. A text or the task names the sequence.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Iterator, Sequence
from itertools import chain, permutations, product
from typing import TYPE_CHECKING, Any

import numpy as np

from mathpost.teaching.workbook.meaning.label import read_label
from mathpost.teaching.workbook.meaning.plane_angles import PLANE_WORDS, ROUNDED, Plane
from mathpost.teaching.workbook.meaning.vocabulary import wording
from mathpost.teaching.workbook.sheet.edits import INVERSE, TRIGONOMETRY
from mathpost.teaching.workbook.sheet.place import offset
from mathpost.teaching.workbook.sheet.samples import SAMPLES
from mathpost.teaching.workbook.sheet.tree import CONVERSIONS, heads

if TYPE_CHECKING:
    from mathpost.teaching.workbook.meaning.recognise import Recognised
    from mathpost.teaching.workbook.sheet.graph import Graph
    from mathpost.teaching.workbook.sheet.place import Line, Place

LIKELY = 16  # readings of some angles that are looked at closely
CONVERTING = {"DEGREES", "PI", "ROUND", "MOD", "IF"}
SPATIAL = rf"{wording('spatial angles')}|G68\.2 *P1"
EULER = rf"{wording('euler angles')}|G68\.2"
NORMAL = rf"{wording('normal')}|^z"
A_PLANE = rf"{wording('plane')}|CYCLE ?800|{SPATIAL}|{EULER}"
NAMED = (*PLANE_WORDS, ("a", "b", "c"))


def find_planes(found: Recognised) -> Iterator[Plane]:
    """Yield the `Plane`s of a `Recognised` workbook: angles in line by inverse functions, from directions.

    A text says that it is a plane, or names axes: else they may be a machine's words.
    """
    graph = found.graph
    if found.by == "source 000" and not re.search(A_PLANE, found.text, re.I):
        return
    taken: set[Place] = set()
    angles = computed_angles(
        graph, graph.downstream(p for p, t in graph.trees.items() if heads(t) & TRIGONOMETRY.keys())
    )
    for step, size in product((1, 2, 3, 4), (3, 2)):
        for place, (down, right) in product(found.sorted(angles), ((step, 0), (0, step))):
            line = tuple(offset(place, n * down, n * right) for n in range(size))
            if not (angles - taken).issuperset(line) or _is_of_a_table(graph, line, 1 if down else 2):
                continue
            if plane := _best(found, line):
                taken.update(line)
                yield plane


def computed_angles(graph: Graph, others: Iterable[Place] = ()) -> set[Place]:
    """The angles, but for others, that inverse functions make, in the unit that is not converted further."""
    angles = {p for p, tree in graph.trees.items() if heads(tree) & INVERSE}.difference(others)
    converted = set()
    for place in graph.order:
        functions = {head for head in heads(graph.trees[place]) if head.isupper()}
        if len(graph.uses[place]) == 1 and functions <= CONVERTING and angles.issuperset(graph.uses[place]):
            angles.add(place)
            converted.update(graph.uses[place])
    return angles - converted


def _is_of_a_table(graph: Graph, line: Collection[Place], along: int) -> bool:
    """Whether each of some angles is calculated, like the next, from its own row, or its column for `along` 2."""
    leaves = {p: graph.upstream([p]) - graph.trees.keys() for p in line}
    own = all({(q[0], q[along]) for q in found} == {(p[0], p[along])} for p, found in leaves.items())
    return own and (len({*map(graph.form, line)}) == 1 or all(len(found) > 1 for found in leaves.values()))


def _best(found: Recognised, line: Line) -> Plane | None:
    """The best reading of two or three cells as the angles of a plane; None if they are none."""
    graph = found.graph
    used = graph.upstream(line) & found.typed - graph.trees.keys()
    used = {p for p in used if (np.abs(graph.own[p] - CONVERSIONS) > 1e-4 * CONVERSIONS).all()}
    line = by_words(found, line)
    beyond_a_turn = sum(abs(graph.number(p)) > 2 * np.pi for p in line)
    units = (True,) if beyond_a_turn > 1 else (True, False)  # no inverse function gives these in radians
    readings = []
    for along, sequence, degrees in product((1, 2), _sequences(found), units):
        for directions in chain(*(_readings(found, v) for v in _directions(found, used, along))):
            plane = Plane(line, sequence=sequence, degrees=degrees, **directions)
            if plane.is_possible() and any(fits := _fits(graph, plane)):
                readings.append((fits, plane))
    readings.sort(key=lambda reading: reading[0], reverse=True)
    drawn = []
    for _, plane in readings[:LIKELY]:
        drawn.append((_fits(graph, plane, drawn=True), plane))
        if drawn[0][0][1] == len(line):  # not by luck
            break
    (count, *_), best = max(drawn, key=lambda reading: reading[0], default=((0, 0, 0), None))
    if not count or best is None:
        return None
    known = {"xyz": "PLANE SPATIAL: angles about X, Y, Z"}
    best.said = known.get(best.sequence, f"{best.sequence} angles of a tilted plane")
    return best


def _sequences(found: Recognised) -> tuple[str, ...]:
    """The sequences that the task or a text names, or else those of G68.2 and PLANE SPATIAL."""
    if found.by == "the task":
        return (found.sequence,)
    named = {"ZXZ": re.search(EULER, found.text, re.I), "xyz": re.search(SPATIAL, found.text, re.I)}
    said = {found.sequence} if found.by == "the text" else set()
    return tuple(sorted(said.union(name for name, match in named.items() if match))) or ("ZXZ", "xyz")


def _readings(found: Recognised, vectors: Sequence[Line]) -> Iterator[dict[str, Any]]:
    """Yield which of some directions, or points, may be what."""
    if len(vectors) == 1:
        yield {"z": vectors[0]}
    normals = [v for v in vectors if re.search(NORMAL, found.label(v[0]), re.I)]
    for order in (*permutations(vectors), *permutations(vectors[:2])) if len(vectors) > 1 else ():
        x, *y, z = order
        if len(normals) != 1 or z == normals[0]:
            yield {"x": x, "y": y[0] if y else (), "z": z}
        yield {"corner": y[0] if y else (), "x": x, "y": z}


def _directions(found: Recognised, used: set[Place], along: int) -> Iterator[list[Line]]:
    """Yield up to three triples of typed numbers, in rows or in columns, that have those `used`."""
    triples = [each for each in found.lines(used, 1) if each[0][along] != each[1][along]]
    vectors: list[Line] = []
    for each in triples:
        taken = set().union(*vectors)
        if len(vectors) < 3 and (used - taken).intersection(each) and taken.isdisjoint(each):
            vectors.append(each)
    for several in (vectors, *([each] for each in triples[1:])):
        if len(used.difference(*several)) <= 1:  # one cell may be used by mistake
            yield several


def _fits(graph: Graph, plane: Plane, drawn: bool = False) -> tuple[int, int, int]:
    """How many cells a reading gives, how many of them are angles, and of how many; 0 if it is none.

    They are those that are there, or those at directions that are drawn at random.
    """
    formulas = graph.upstream(plane.results) & graph.trees.keys() - set(plane.results)
    own = {p: np.array(graph.own[p], dtype=float) for p in (*plane.read, *formulas)}
    x, y, z = (np.array([own[p] for p in places]) for places in (plane.x, plane.y, plane.z))
    if z.size and y.size and not np.abs(np.cross(z, x) - y).max() < 0.01:
        return 0, 0, 0
    if drawn:
        inputs = {p: np.r_[own[p], each[1:]] for p, each in plane.draw(np.random.default_rng(8), {}).items()}
        plane.unround(inputs)
        own |= graph.run(inputs, only=formulas.union(plane.results))
    plane.prepare(own, {})
    now = {p: np.broadcast_to(own[p], SAMPLES)[drawn:] for p in own}
    off = [np.abs(now[p] - plane.targets[p][drawn:]).max() for p in plane.results]
    known = np.array(plane.entries)[:, drawn:]
    telling = [p for p in formulas if not drawn or np.ptp(now[p])]
    others = [np.abs(known - now[p]).max(axis=1).min() for p in telling]
    angles = sum(each < (0.1 if plane.degrees else 0.002) for each in off)
    steps = sum(each < ROUNDED for each in others)
    return angles + steps, angles, len(plane.results)


def by_words(found: Recognised, line: Line) -> Line:
    """The cells in the order of the angles that their labels name."""
    labels = [*map(found.label, line)]
    names = [re.sub(r"[^a-z].*", "", label.lower()) for label in labels]
    may = ([name for name in group if name in names] for group in NAMED)
    order = next((order for order in may if len(order) == len(line)), None)
    if order is None:  # α and β, of which φ, θ and ψ do not say which is first
        names = [re.sub("(?i)phi|psi|theta|[φψθ]", "", label) for label in labels]
        roles = [role and role.kind == "angle" and role.word for role in map(read_label, names)]
        said = [role for role in roles if role]
        is_said = len({*said}) == len(roles)
        return tuple(line[roles.index(role)] for role in sorted(said)) if is_said else line
    return tuple(line[names.index(name)] for name in order)
