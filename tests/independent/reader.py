"""What a control does with a program: modal state, and for each block the moves that it makes.

`read(text, dialect, setup)` gives a list of `Move`; what the control would refuse raises `words.Refused` with its
line. The two families of dialects are in `word_address` and `klartext`; this file has what they share.

Coordinates of a block go through three frames: *program* (as written: shift, tilted plane), *space* (`"machine"`:
words without TCP, parallel to the slides; `"workpiece"`: the tip, under TCP or on a tilted plane), and the slides.
"""

import copy
import itertools
import math
from dataclasses import dataclass, field

import numpy as np

from .words import Refused

RADIUS_SLACK = 0.02  # mm by which the two ends of an arc may differ in radius


@dataclass
class Setup:
    """What stands at the machine and not in the program."""

    model: object
    lengths: dict = field(default_factory=dict)  # tool or H number: length; else the machine file's
    offsets: dict = field(default_factory=dict)  # "G55": shift of its origin from the machine file's
    length_on: bool = False  # G43 was given before the program (a program without a head)
    start: tuple | None = None  # nose and angles before the first block; unknown without


@dataclass
class Move:
    """One motion: from `start` to `end` angles while the curve goes from 0 to 1."""

    line: int
    kind: str  # "rapid", "feed", "dwell"
    space: str  # in which `curve` is: "slides" (of the nose) or "workpiece" (of the tip)
    curve: object  # t → three coordinates
    start: np.ndarray
    end: np.ndarray
    tool_length: float
    named_length: float  # the length that the words take off: 0 without G43
    seconds: float | None  # by F; None for a rapid
    feed: float | None
    cycle: bool
    tcp: bool
    modal: dict
    arc: bool = False
    text: str = ""

    def angles(self, t):
        return self.start + t * (self.end - self.start)

    def nose(self, model, t):
        if self.space == "slides":
            return self.curve(t)
        return model.nose_for(self.curve(t), self.angles(t), self.tool_length)


def _line(a, b):
    return lambda t: a + t * (b - a)


class Control:
    """State and geometry; a dialect translates its blocks into calls of the methods here."""

    adds_degrees = True  # whether F of X Y Z and rotary axes counts both as one unit

    def __init__(self, setup):
        model = setup.model
        self.setup = setup
        self.model = model
        self.moves = []
        self.line = 0
        self.text = ""
        self.nose = np.full(3, np.nan) if setup.start is None else np.array(setup.start[0], dtype=float)
        unknown = np.full(len(model.letters), np.nan)
        self.turned = unknown if setup.start is None else np.array(setup.start[1], dtype=float)
        self.tool = None
        self.tool_length = model.length
        self.length_on = setup.length_on
        self.tcp = False
        self.plane = None  # (rotation, origin) of a tilted plane in the workpiece
        self.plane_number = 17
        self.base = np.zeros(3)  # work offset less the machine file's origin
        self.shift = np.zeros(3)  # datum shift on top
        self.feed = None
        self.feed_mode = 94
        self.absolute = True
        self.unit = 1.0
        self.speed = None
        self.spindle = None
        self.coolant = frozenset()
        self.compensation = 40
        self.offset_name = None
        self.ended = False
        self.in_cycle = False
        self.at = np.full(3, np.nan)  # where the program thinks it is, in its own coordinates
        self.update()

    def refuse(self, why):
        raise Refused(self.line, why)

    # Frames.

    @property
    def named_length(self):
        return self.tool_length if self.length_on else 0.0

    @property
    def space(self):
        return "workpiece" if self.tcp or self.plane is not None else "machine"

    def to_space(self, point):
        point = np.asarray(point, dtype=float)
        if self.plane is not None:
            turn, origin = self.plane
            point = turn @ point + origin
        return point + self.base + self.shift

    def from_space(self, point):
        point = np.asarray(point) - self.base - self.shift
        if self.plane is not None:
            turn, origin = self.plane
            point = turn.T @ (point - origin)
        return point

    def nose_at(self, point, angles):
        """The nose for a point of the program."""
        point = self.to_space(point)
        if self.space == "machine":
            return self.model.nose_of_words(point, self.named_length)
        return self.model.nose_for(point, angles, self.tool_length)

    def update(self):
        """The program's own coordinates after anything but a move changed what they mean."""
        if self.space == "workpiece":
            point = self.model.place(self.nose, self.turned, self.tool_length)[0]
        else:
            point = self.model.words(self.nose, self.named_length)
        self.at = self.from_space(point)

    def change_tool(self, number):
        """A tool in the spindle: its length acts at once on the tip, on the words only where they name it."""
        self.tool = number
        self.tool_length = self.setup.lengths.get(number, self.model.length)
        self.update()

    # Moves.

    def go(self, kind, target, angles, curve=None, **more):
        """Move to `target` (program coordinates) and `angles`; `curve` is in program coordinates, else a line."""
        then = copy.copy(self)  # the frames of now, for the path that is sampled later
        begin, end = self.at, np.asarray(target, dtype=float)
        turned = np.asarray(angles, dtype=float)
        arc = curve is not None
        if arc:
            points = [curve(n / 64) for n in range(65)]
            length = sum(float(np.linalg.norm(q - p)) for p, q in itertools.pairwise(points))
        else:
            length = float(np.linalg.norm(end - begin))
            curve = _line(begin, end)
        stays = self.space != "machine" and not self.tcp and np.array_equal(begin, end, equal_nan=True)
        nose = self.nose if stays else self.nose_at(end, turned)
        if self.tcp:
            space, path = "workpiece", lambda t: then.to_space(curve(t))
        elif arc:
            if self.space != "machine" and not np.array_equal(turned, self.turned):
                self.refuse("an arc on a tilted plane while a rotary axis turns")
            space, path = "slides", lambda t: then.nose_at(curve(t), turned)
        else:
            space, path = "slides", _line(self.nose, nose)
        self.emit(kind, space, path, self.turned, turned, length=length, arc=arc, **more)
        self.nose, self.turned, self.at = nose, turned, end
        if self.space == "workpiece" and not self.tcp:
            self.update()

    def go_slides(self, kind, slides, angles, **more):
        """Move in machine coordinates (G53, M91, SUPA): `slides` may hold NaN for an axis that is not named."""
        now = self.model.slides(self.nose)
        target = np.where(np.isnan(slides), now, slides)
        a, b = self.nose, self.model.nose_of_slides(target)
        end = np.asarray(angles, dtype=float)
        self.emit(kind, "slides", _line(a, b), self.turned, end, length=float(np.linalg.norm(b - a)), **more)
        self.nose, self.turned = b, end
        self.update()

    def dwell(self, seconds):
        nose = self.nose
        self.emit("dwell", "slides", lambda t: nose, self.turned, self.turned, seconds=seconds)

    def emit(self, kind, space, path, start, end, length=0.0, seconds=None, arc=False, feed=None):
        if kind == "feed" and seconds is None:
            seconds = self.feed_seconds(length, end - start, feed)
        modal = {
            "tool": self.tool, "speed": self.speed, "spindle": self.spindle, "coolant": self.coolant,
            "plane": self.plane_number, "tilted": self.plane is not None, "compensation": self.compensation,
            "offset": self.offset_name, "feed mode": self.feed_mode, "unit": self.unit, "absolute": self.absolute,
        }  # fmt: skip
        used = self.feed if feed is None else feed
        self.moves.append(
            Move(
                self.line, kind, space, path, start, end, self.tool_length, self.named_length, seconds,
                used, self.in_cycle, self.tcp, modal, arc, self.text,
            )
        )  # fmt: skip

    # Feed.

    def feed_seconds(self, length, turn, feed=None):
        """Seconds that F asks for."""
        feed = self.feed if feed is None else feed
        if feed is None or not feed > 0:
            self.refuse("a feed move without a feed")
        if self.feed_mode == 93:
            return 60.0 / feed
        turned = float(np.sqrt(np.nansum(np.square(turn))))
        if length < (1e-6 if self.tcp else 1e-9):
            return 60.0 * turned / feed
        # Without TCP Fanuc adds millimetres and degrees as if they were one unit (B-63174EN, 4.2).
        added = turned if self.adds_degrees and not self.tcp else 0.0
        return 60.0 * math.hypot(length, added) / feed

    # Arcs and holes.

    def arc_to(self, target, angles, clockwise, *, centre, turns=0, kind="feed"):
        """An arc or helix in the selected plane; `centre` in program coordinates."""
        u, v, w = {17: (0, 1, 2), 18: (2, 0, 1), 19: (1, 2, 0)}[self.plane_number]
        a, b = self.at, np.asarray(target, dtype=float)
        if np.isnan(a).any() or np.isnan(b).any():
            self.refuse("an arc from a position that is not known")
        chord = np.array([b[u] - a[u], b[v] - a[v]])
        middle = np.array([centre[u], centre[v]])
        from_ = np.array([a[u], a[v]]) - middle
        to = np.array([b[u], b[v]]) - middle
        r0, r1 = np.linalg.norm(from_), np.linalg.norm(to)
        if r0 < 1e-9 or abs(r0 - r1) > RADIUS_SLACK:
            self.refuse(f"an arc with radius {r0:.4f} at its start and {r1:.4f} at its end")
        begin = math.atan2(from_[1], from_[0])
        sweep = math.atan2(to[1], to[0]) - begin
        sweep = sweep % (2 * math.pi)
        if clockwise:
            sweep -= 2 * math.pi
        if np.linalg.norm(chord) < 1e-7:
            sweep = -2 * math.pi if clockwise else 2 * math.pi
        sweep += math.copysign(2 * math.pi * turns, sweep)

        def curve(t):
            r = r0 + t * (r1 - r0)
            point = np.empty(3)
            point[u] = middle[0] + r * math.cos(begin + t * sweep)
            point[v] = middle[1] + r * math.sin(begin + t * sweep)
            point[w] = a[w] + t * (b[w] - a[w])
            return point

        self.go(kind, target, angles, curve)

    def drill(
        self, position, clearance, depth, retract, *, peck=None, chip_break=False, dwell=0.0, feed=None, out="rapid"
    ):
        """A hole at `position`, normal to the plane: over it, to `clearance`, to `depth`, to `retract`."""
        w = {17: 2, 18: 1, 19: 0}[self.plane_number]

        def level(height):
            point = np.array(position, dtype=float)
            point[w] = height
            return point

        self.in_cycle = True
        self.go("rapid", level(self.at[w]), self.turned)
        self.go("rapid", level(clearance), self.turned)
        reached = clearance
        while peck and abs(depth - reached) > peck + 1e-9:
            reached += math.copysign(peck, depth - reached)
            self.go("feed", level(reached), self.turned, feed=feed)
            if not chip_break:
                self.go("rapid", level(clearance), self.turned)
                self.go("rapid", level(reached), self.turned)
        self.go("feed", level(depth), self.turned, feed=feed)
        if dwell:
            self.dwell(dwell)
        self.go(out, level(retract), self.turned, feed=feed)
        self.in_cycle = False


def read(text, dialect, setup):
    """The moves of a program; `dialect` is heidenhain, fanuc, siemens, linuxcnc, haas or mazak."""
    from . import klartext, word_address

    control = klartext.Klartext(setup) if dialect == "heidenhain" else word_address.control(dialect, setup)
    for number, line in enumerate(text.splitlines(), 1):
        control.line = number
        control.text = line.strip()
        if control.ended:
            if control.text and control.text != "%":
                control.refuse("a block after the end of the program")
            continue
        control.block(line)
    return control.moves
