"""Where tip and tool axis are, from a machine file: every rotation is Rodrigues' formula written out here.

The file's convention (comments in data/machines/*.toml, design "Conventions"): a rotary joint is a point and a
vector; the body that it carries turns right-handed about the vector by the programmed angle. Joints of a table are
given in machine coordinates, joints of a head count from the spindle nose. Angles here are degrees, lengths mm.
"""

import itertools
import math
import tomllib
from pathlib import Path

import numpy as np


def rotation(axis, degrees):
    """Rodrigues: cos·1 + sin·[k]× + (1 − cos)·k kᵀ, written out, shape (3, 3)."""
    x, y, z = np.asarray(axis, dtype=float) / math.sqrt(sum(float(c) ** 2 for c in axis))
    c = math.cos(math.radians(degrees))
    s = math.sin(math.radians(degrees))
    v = 1.0 - c
    return np.array(
        [
            [c + x * x * v, x * y * v - z * s, x * z * v + y * s],
            [y * x * v + z * s, c + y * y * v, y * z * v - x * s],
            [z * x * v - y * s, z * y * v + x * s, c + z * z * v],
        ]
    )


class Model:
    """A machine with one or two rotary axes.

    The state is `nose`, where the spindle nose would be with all head axes at zero (what the slides carry), in
    machine coordinates, and `angles`, one for each rotary axis in the order of the file.
    """

    def __init__(self, file, *, length=None, origin=None):
        data = tomllib.loads(Path(file).read_text(encoding="utf-8")) if not isinstance(file, dict) else file
        self.tables = []  # (axis, point), from the bed outwards
        self.heads = []
        self.letters = []
        self.sides = []
        self.travel = {}
        self.rates = {}
        self.accelerations = {}
        for joint in data["rotary"]:
            letter = joint["name"]
            self.letters.append(letter)
            self.sides.append(joint["carries"])
            side = self.tables if joint["carries"] == "workpiece" else self.heads
            side.append((np.array(joint["axis"], dtype=float), np.array(joint["point"], dtype=float)))
            self._keep(letter, joint)
        linear = data.get("linear", {})
        for letter in "XYZ":
            self._keep(letter, linear.get(letter, {}))
        self.limits_of = linear.get("limits_of", "slides")
        tool = data["tool"]
        direction = np.array(tool["axis"], dtype=float)
        self.tool_axis = direction / np.linalg.norm(direction)
        self.length = float(tool.get("length", 0.0)) if length is None else float(length)
        self.named = tool.get("programmed_point", "tip")
        self.origin = np.array(data["workpiece"]["origin"] if origin is None else origin, dtype=float)

    def _keep(self, letter, joint):
        self.travel[letter] = tuple(joint.get("limits", (-math.inf, math.inf)))
        self.rates[letter] = joint.get("max_rate", math.inf)
        self.accelerations[letter] = joint.get("max_acceleration", math.inf)

    # The two sides of the chain.

    def _split(self, angles):
        tables = [a for a, side in zip(angles, self.sides, strict=True) if side == "workpiece"]
        heads = [a for a, side in zip(angles, self.sides, strict=True) if side == "tool"]
        return tables, heads

    def table(self, angles):
        """Rotation and translation that take a point of the workpiece side from rotary zero to where it is."""
        turn = np.eye(3)
        shift = np.zeros(3)
        for (axis, point), angle in zip(self.tables, self._split(angles)[0], strict=True):
            r = rotation(axis, angle)
            shift = shift + turn @ (point - r @ point)
            turn = turn @ r
        return turn, shift

    def head(self, angles):
        """The same for a point of the tool side, in coordinates that count from the nose at rotary zero."""
        turn = np.eye(3)
        shift = np.zeros(3)
        for (axis, point), angle in zip(self.heads, self._split(angles)[1], strict=True):
            r = rotation(axis, angle)
            shift = shift + turn @ (point - r @ point)
            turn = turn @ r
        return turn, shift

    def place(self, nose, angles, length=None):
        """Tip and tool axis in the workpiece's coordinates: the machine's less the origin, at rotary zero."""
        length = self.length if length is None else length
        turn, shift = self.head(angles)
        tip = np.asarray(nose) + turn @ (-length * self.tool_axis) + shift
        table, carried = self.table(angles)
        return table.T @ (tip - carried) - self.origin, table.T @ (turn @ self.tool_axis)

    def nose_for(self, tip, angles, length=None):
        """Where the slides must carry the nose for the tip to be there at these angles."""
        length = self.length if length is None else length
        turn, shift = self.head(angles)
        table, carried = self.table(angles)
        return table @ (np.asarray(tip) + self.origin) + carried - turn @ (-length * self.tool_axis) - shift

    # Words of the program without TCP, and slides.

    def _named_point(self, length):
        if self.named == "tip":
            return -length * self.tool_axis
        return np.zeros(3) if self.named == "nose" else np.array(self.named, dtype=float)

    def words(self, nose, length):
        """X Y Z words: where the named point is at rotary zero, from the origin; length 0 without G43."""
        return np.asarray(nose) + self._named_point(length) - self.origin

    def nose_of_words(self, words, length):
        """The inverse of `words`."""
        return np.asarray(words) - self._named_point(length) + self.origin

    def slides(self, nose):
        """Machine coordinates X Y Z: of the nose, or of the point of the head that the words name."""
        return np.asarray(nose) + (0 if self.named in ("tip", "nose") else np.array(self.named, dtype=float))

    def nose_of_slides(self, slides):
        """The inverse of `slides`."""
        return np.asarray(slides) - (0 if self.named in ("tip", "nose") else np.array(self.named, dtype=float))

    def angles_for(self, axis, present):
        """All pairs of angles within travel that give the tool axis `axis`, nearest to `present` first.

        Newton's method from a grid of starts, and nothing else: slow, and independent of any closed form.
        """
        axis = np.asarray(axis, dtype=float) / np.linalg.norm(axis)
        found = []
        now = np.nan_to_num(np.asarray(present, dtype=float))
        grid = itertools.product(range(-177, 183, 45), repeat=len(self.letters))
        for start in [now, *grid]:  # what need not turn, as one axis at the pole, stays
            angles = self._newton(axis, np.array(start, dtype=float))
            if angles is None:
                continue
            angles = [self._within(n, a, present[n]) for n, a in enumerate(angles)]
            if None in angles or any(np.allclose(angles, other, atol=1e-6) for other in found):
                continue
            found.append(np.array(angles))
        return sorted(found, key=lambda angles: float(np.abs(angles - now).max()))

    def _newton(self, axis, angles):
        for _ in range(30):
            error = self.place(np.zeros(3), angles)[1] - axis
            if np.abs(error).max() < 1e-13:
                return angles
            columns = []
            for n in range(len(angles)):
                moved = angles.copy()
                moved[n] += 1e-4
                columns.append((self.place(np.zeros(3), moved)[1] - axis - error) / 1e-4)
            step = np.linalg.lstsq(np.column_stack(columns), -error, rcond=1e-9)[0]
            angles = angles + np.clip(step, -40, 40)
        return angles if np.abs(self.place(np.zeros(3), angles)[1] - axis).max() < 1e-9 else None

    def _within(self, n, angle, present):
        """The turn of `angle` nearest to `present` that is within travel, or None."""
        low, high = self.travel[self.letters[n]]
        present = 0.0 if math.isnan(present) else present
        turns = [angle + 360.0 * k for k in range(-12, 13)]
        inside = [a for a in turns if low - 1e-6 <= a <= high + 1e-6]
        return min(inside, key=lambda a: abs(a - present)) if inside else None
