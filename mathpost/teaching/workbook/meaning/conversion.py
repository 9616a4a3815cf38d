"""Angles made of other angles: three Euler angles converted into others, or computed back from a matrix."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from mathpost import euler
from mathpost.teaching.workbook.meaning.calculation import LARGEST_RADIANS, Calculation, Turn, look, nearest
from mathpost.teaching.workbook.meaning.find_planes import by_words, computed_angles
from mathpost.teaching.workbook.meaning.given import runs
from mathpost.teaching.workbook.meaning.plane_angles import PLANE_WORDS
from mathpost.teaching.workbook.meaning.texts import SEQUENCE, TURNS
from mathpost.teaching.workbook.meaning.vocabulary import wording
from mathpost.teaching.workbook.sheet.place import offset
from mathpost.teaching.workbook.sheet.tree import parts_of

if TYPE_CHECKING:
    from mathpost.teaching.workbook.meaning.recognise import Recognised
    from mathpost.teaching.workbook.sheet.place import Place
    from mathpost.teaching.workbook.sheet.samples import Values


@dataclass(eq=False)
class Conversion(Calculation):
    """Three angles of the sequence `into` that are the rotation of three others, either solution."""

    sequence: str = "ZXZ"
    into: str = "ZXZ"
    unit: float = 1.0  # degrees of 1 of a result

    @property
    def periods(self) -> dict[Place, float]:
        """Place of an angle → a turn."""
        return dict.fromkeys(self.results, 360 / self.unit)

    def prepare(self, values: Values, units: dict[Place, float]) -> None:
        """Compute, at the samples, the required results and the values that may occur on the way."""
        self.turn = Turn((), self.angles, sequence=self.sequence)
        self.turn.prepare(values, units)
        self.radians, self.known = self.turn.radians, self.turn.known
        first = euler.angles(self.into, euler.matrix(self.sequence, self.radians))
        both = np.rad2deg(np.stack([first, euler.twin(self.into, first)], axis=1))
        now = look(values, self.results)
        self.should_be(self.results, nearest(now * self.unit, both)[0].T / self.unit)


@dataclass(eq=False)
class ToQuaternion(Turn):
    """The quaternion of a rotation by three angles, or of the inverse, scalar first, of either sign."""

    def prepare(self, values: Values, units: dict[Place, float]) -> None:
        """Compute the quaternion at the samples, of the signs that most cells have."""
        super().prepare(values, units)
        now = look(values, self.results).T
        signs = [s for s in product((1, -1), repeat=2) if s[0] == s[1] or not self.active]
        both = [np.array([a, b, b, b])[:, None] * self.quaternions()[2] for a, b in signs]
        self.should_be(self.results, max(both, key=lambda q: (np.abs(now - q) < 1e-6).sum()))


def find_quaternions(found: Recognised) -> Iterator[ToQuaternion]:
    """Yield four formulas in line, in a sheet that speaks of quaternions, that three angles make."""
    known = {c.angles for c in found.calculations}
    made = {p for p, inputs in found.depends.items() if len(inputs) == 3 and found.angles >= inputs}
    for line in runs(made - found.turning):
        angles = {tuple(found.sorted(found.depends[p])) for p in line}
        named = [found.by_name(each) for each in angles]
        if len(line) == 4 and len(named) == 1 and named[0] not in known:
            yield ToQuaternion(found.scalar_first(line), named[0])


def find_conversions(found: Recognised) -> Iterator[Conversion]:
    """Yield the `Conversion`s of a `Recognised` workbook: angles in line by inverse functions, of three others."""
    graph, used = found.graph, {c.angles for c in found.calculations}
    taken: set[Place] = set()
    by_text = _sequences(found)
    ends = computed_angles(graph, graph.messages)
    for place in found.sorted(ends):
        for down, right in ((0, 1), (1, 0), (0, 2)):
            line = tuple(offset(place, n * down, n * right) for n in range(3))
            of = [found.angles & graph.upstream([p]) for p in line]
            if not ends.issuperset(line) or taken.intersection(line) or of[0].isdisjoint(of[1]):
                continue
            angles = found.three(found.sorted(set().union(*of)))
            if angles is None:
                continue
            named = [name for each in (angles, line) if (name := words_of(found, each))]
            sequence, into = named if len(named) == 2 else by_text
            if found.by_name(angles, sequence) in used and into == sequence:
                continue
            taken.update(line)
            graph.take_unrounded(line)
            parts = [part for p in line for part in parts_of(graph.tree(p))]
            in_degrees = any(part[0] == "DEGREES" or part == ("number", 180.0) for part in parts)
            in_degrees |= any(abs(graph.own[p] or 0.0) > LARGEST_RADIANS for p in line)
            unit = 1.0 if in_degrees else float(np.rad2deg(1))
            said = f"{sequence} angles converted into {into}"
            angles, line = found.by_name(angles, sequence), found.by_name(line, into)
            if len(named) == 2:
                angles, line = by_words(found, angles), by_words(found, line)
            yield Conversion(line, angles, said=said, sequence=sequence, into=into, unit=unit)


def words_of(found: Recognised, line: Sequence[Place]) -> str | None:
    """The sequence of three angles whose labels are the words of a tilted plane, as SPA SPB SPC; None without."""
    said = sorted(re.sub(r"[^a-z].*", "", found.label(p).lower()) for p in line)
    return next((sequence for words, sequence in PLANE_WORDS.items() if sorted(words) == said), None)


def _sequences(found: Recognised) -> tuple[str, str]:
    """The sequence of the angles that are given, and of those that are made: as the texts name them, one by one."""
    lines = [line for line in re.finditer(".+", found.text) if re.search(TURNS, line[0], re.I)]
    matches = ((line.start() + f.start(), f) for line in lines for f in SEQUENCE.finditer(line[0]))
    named = [(start, "".join(f.groups()).upper()) for start, f in matches]
    named = [(start, sequence) for start, sequence in named if sequence in euler.SEQUENCES]
    first = next(iter(named), (0, found.sequence))
    then = next((each for each in named if each[1] != first[1]), None)
    if found.by == "the task" or then is None:
        return found.sequence, found.sequence
    parts = found.text[: then[0]], found.text[then[0] :]
    one, other = (
        name.lower() if re.search(wording("fixed axes"), part, re.I) else name
        for name, part in zip((first[1], then[1]), parts, strict=True)
    )
    return one, other
