"""Numbers of the machine in a sheet: how the words depend on them, not only the words at their present values.

A pivot that is 0 hides a slip before it. X Y Z are linear in every point of the machine, so that a step of a typed
number must step them as one of the machine's own numbers does, at all samples. Where all words are right, and a
number that is 0 steps them otherwise, the words are asked for with that number drawn at random.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import combinations, product
from typing import TYPE_CHECKING

import numpy as np

from mathpost.detective.causes import Setup
from mathpost.workbook.sheet.place import Place, offset
from mathpost.workbook.sheet.samples import SAMPLES, Values, at_samples

if TYPE_CHECKING:
    from mathpost.workbook.meaning.nc_table import Words
    from mathpost.workbook.verdict.judge import Judge

LONGEST = 60.0  # mm
CLOSE = 1e-7  # mm of a step of 1 mm
NEARLY = 0.6  # of the words that a number moves, or should, are moved as they should be
AROUND = {"tip", "word", "tool"}  # what moves before all joints, or behind; a pivot that is lost in one place, too
Role = tuple[str, int, int]  # what is moved, along which coordinate, which way


class Constants:
    """The numbers of the machine in the `rows` of a table of which all words are right.

    `doubtful` are those that step the words as no number of the machine does, and who knows as which they should.
    """

    def __init__(self, judge: Judge, rows: list[Words]) -> None:
        self.judge, self.graph, self.found, self.rows = judge, judge.graph, judge.found, rows
        self.known: dict[Role, np.ndarray] = dict(self._known())
        self.doubtful: list[Place] = []

    def vary(self) -> None:
        """Draw numbers at random in place of those that are 0 and step words as they should not."""
        steps = dict(self._steps())
        roles = {place: self._roles(step) for place, step in steps.items()}
        rng = np.random.default_rng(7)
        for place, step in steps.items():
            if self.graph.own[place] or not all(name in AROUND for name, *_ in roles[place]):
                continue
            role = self._of_its_line(place, roles)
            if role is None and roles[place]:
                continue
            role = role or self._nearly(step)
            if role is None:
                self.doubtful.append(place)
                continue
            drawn = rng.uniform(-LONGEST, LONGEST, SAMPLES)
            drawn[0] = 0.0
            self.judge.inputs[place] = drawn
            for row, part in zip(self.rows, np.split(self.known[role], len(self.rows)), strict=True):
                row.steps = row.steps | {place: part}

    def _steps(self) -> Iterator[tuple[Place, np.ndarray]]:
        """Yield the typed numbers that move X Y Z only, and the same wherever the tip is, with what 1 mm does."""
        judge = self.judge
        typed = self.found.typed & self.graph.upstream(p for row in self.rows for p in row.results[:3])
        typed -= {*judge.inputs, *self.found.constants, *(p for window in self.found.windows for p in window)}
        tip = {p: judge.now(p) + 10.0 * n for row in self.rows for n, p in enumerate(row.point, 1)}
        elsewhere = judge.run_with(tip)
        for place in self.found.sorted(typed):
            one, two = ({place: judge.now(place) + size} for size in (1.0, 2.0))
            step = self._words(judge.values_with(one)) - self._words(judge.values)
            double = self._words(judge.values_with(two)) - self._words(judge.values)
            there = self._words(judge.run_with({**tip, **one})) - self._words(elsewhere)
            turns = np.nanmax(np.abs(step[:, 3:]), initial=0) > CLOSE
            if not turns and _alike(2 * step, double) and _alike(step, there) and not _alike(step, 0 * step):
                yield place, step[:, :3]

    def _words(self, values: Values) -> np.ndarray:
        """All words, shape (rows · samples, 5)."""
        return np.vstack([np.array([at_samples(values[p]) for p in row.results]).T for row in self.rows])

    def _known(self) -> Iterator[tuple[Role, np.ndarray]]:
        """Yield what a step of 1 mm of each number of the machine makes of X Y Z, shape (rows · samples, 3)."""
        tips, axes = (
            np.vstack([self.judge.block(getattr(row, part)).T for row in self.rows]) for part in ("point", "axis")
        )
        angles = np.rad2deg(np.vstack([row.radians for row in self.rows]))
        right = Setup.right(self.rows[0].kinematics.machine)
        names = ["origin", *(joint.name for joint in right.machine.rotary)]

        def moved(setup: Setup, by: np.ndarray | float = 0.0) -> np.ndarray:
            return setup.linear(np.hstack([tips + by, angles])) - right.linear(np.hstack([tips, angles]))

        steps = {("tool", 0): moved(right, axes / np.linalg.norm(axes, axis=1)[:, None])}
        for n, unit in enumerate(np.eye(3)):
            each = [moved(right.pivoted(name, right.point(name) + unit)) for name in names]
            for count in range(1, len(each) + 1):  # whatever is mounted on one that is moved moves with it
                for chosen in combinations(range(len(each)), count):
                    steps["+".join(names[k] for k in chosen), n] = sum(
                        (each[k] for k in chosen), start=np.zeros_like(each[0])
                    )
            steps["tip", n] = moved(right, unit)
            steps["word", n] = np.tile(unit, (len(tips), 1))
        for (name, n), step in steps.items():
            step = np.where(np.abs(step) < CLOSE, 0.0, step)
            yield (name, n, 1), step
            yield (name, n, -1), -step

    def _roles(self, step: np.ndarray) -> list[Role]:
        """The numbers of the machine that do the same to all words."""
        return [role for role, known in self.known.items() if _alike(step, known)]

    def _of_its_line(self, place: Place, roles: Mapping[Place, list[Role]]) -> Role | None:
        """The role of a number by those beside it, which are coordinates of one point; None if they are not.

        One of them may be along an axis, where it moves nothing.
        """
        for (down, right), k in product(((0, 1), (1, 0)), range(3)):
            line = [offset(place, (n - k) * down, (n - k) * right) for n in range(3)]
            others = [(n, p) for n, p in enumerate(line) if n != k and p in roles]
            for name, _, sign in roles[others[0][1]] if others else ():
                if name in AROUND:
                    continue
                rest = [n for n, p in enumerate(line) if n != k and p not in roles]
                alone = rest and any(role[:2] in {("tip", k), ("word", k)} for role in self._others(place, roles))
                moves = any(self.known[name, n, sign].any() for n in rest)
                if not (alone or moves) and all((name, n, sign) in roles[p] for n, p in others):
                    return name, k, sign
        return None

    @staticmethod
    def _others(place: Place, roles: Mapping[Place, list[Role]]) -> list[Role]:
        """The roles of all other numbers."""
        return [role for other, found in roles.items() if other != place for role in found]

    def _nearly(self, step: np.ndarray) -> Role | None:
        """The role to which most words agree that move or should; None if there are two, or none."""
        shares = {}
        for role, known in self.known.items():
            if role[0] not in AROUND:
                pairs = np.stack([step, known]).reshape(2, len(self.rows), SAMPLES, 3)
                moves = np.nanmax(np.abs(pairs), axis=(0, 2)) > CLOSE
                agree = np.nanmax(np.abs(pairs[0] - pairs[1]), axis=1) < CLOSE
                shares[role] = agree[moves].mean()
        best = max(shares.values(), default=0)
        found = [role for role, share in shares.items() if share == best > NEARLY]
        return found[0] if found and all(_alike(self.known[role], self.known[found[0]]) for role in found) else None


def _alike(a: np.ndarray, b: np.ndarray) -> bool:
    """Whether two steps are the same, but where there is no number."""
    return bool(np.nanmax(np.abs(a - b), initial=0) < CLOSE)
