"""The moves of a program as they are read: from where, to where, resolved to what the words name."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mathpost.errors import InputError
from mathpost.machine import Machine
from mathpost.path import text as bulk
from mathpost.shop.controls.coordinates import Coordinates, Setup
from mathpost.shop.controls.lines import Line

SAME_ANGLE = 1e-3  # degrees, by which the printed digits of a plane may turn the rotary axes


@dataclass(frozen=True)
class Blind:
    """A move from or to where nobody knows all axes."""

    line: int  # of the text
    block: int  # number of the moves before it that are known at their end; if this one is, its own
    machine: Machine  # with its tool
    # Shape (j,), words from where, counted from the machine's origin, mm and degrees, NaN if unknown.
    start: np.ndarray
    end: np.ndarray  # shape (j,), and to where
    tcp: bool  # whether X Y Z are the tip
    aside: bool  # whether, where Z is not known, the machine itself has put it there: reference point, tool change


class Track(bulk.Reader):
    """Keeps where the machine stands, and each move that it makes."""

    def __init__(self, machine: Machine, setup: Setup, name: str) -> None:
        self.name = name
        self.names = machine.joint_names
        self.line = 1
        self.at = Coordinates(machine, setup)
        self.feed = np.nan
        self.motion = "linear"
        self.inverse = False
        self.turning = False  # whether a line only turns axes: that may be the way to the first position
        self.changed = False  # whether a tool was changed
        self.kept: set[int] = set()  # rotary axes, by number, that nothing has named since then
        self.began = np.full(len(self.names), np.nan)  # words from where the first move goes
        self.blind: list[Blind] = []
        self.aside = False  # see `Blind`
        self.notes: dict[str, tuple[int, str]] = {}  # what is taken for granted: its first line and word there

    def note(self, kind: str, word: str) -> None:
        """Keep the first line at which something is taken for granted, and its word."""
        self.notes.setdefault(kind, (self.line, word))

    def put(self, points: np.ndarray, line: Line, rapid: np.ndarray | None = None) -> None:
        """Take moves to points, words of shape (n, j), that one line asks for."""
        count = len(points)
        self.begin()
        resolved = np.c_[self.at.resolved(points[:, :3]), points[:, 3:]].T
        seconds = np.full(count, line.seconds / count)
        fast = np.full(count, line.rapid) if rapid is None else np.array(rapid)
        self.emit(resolved, np.full(count, self.feed), seconds, fast, np.zeros(count, int), self.at.on_tip)
        self.at.go(points[-1].copy())

    def turn(self, words: np.ndarray, line: Line) -> None:
        """Turn rotary axes to words, shape (j,), without TCP: the slides stay, whatever X Y Z count from."""
        self.begin()
        joints, one = self.at.joints(), np.ones(1)
        place = np.r_[joints, words[3:]][:, None]
        self.emit(place, self.feed * one, line.seconds * one, np.array([line.rapid]), np.zeros(1, int), False)
        self.at.stand(joints, words[3:])

    def begin(self) -> None:
        """Keep from where the first move goes."""
        if not self.count:
            self.began = np.r_[self.at.resolved(self.at.words[None, :3])[0], self.at.words[3:]]

    def stand(self, place: np.ndarray) -> None:
        """Go to joints and angles, shape (j,), in rapid traverse, whatever the words name."""
        nothing = np.array([np.nan])
        self.emit(place[:, None], nothing, nothing, np.array([True]), np.zeros(1, int), False)
        self.at.stand(place[:3], place[3:])

    def park(self, axes: Sequence[int]) -> None:
        """Go with some axes, by number, to where the machine itself has a place for them: nobody knows it here."""
        self.at.lose(axes)
        self.aside |= 2 in axes

    def turn_to(self, joints: np.ndarray, angles: np.ndarray) -> None:
        """Turn the rotary axes, degrees, while the slides stay at the positions they have in the printed digits."""
        if np.abs(angles - self.at.words[3:]).max() < SAME_ANGLE:
            self.at.stand(joints, angles)
        else:
            self.stand(np.r_[joints, angles])

    def move(
        self, words: np.ndarray, feeds: np.ndarray, seconds: np.ndarray, rapid: np.ndarray, numbers: np.ndarray
    ) -> None:
        """Take n plain moves: words, shape (j, n), feeds and seconds, NaN where a line does not say."""
        fed = ~(rapid | (self.motion == "rapid"))
        until = int(fed.argmax()) + 1 if fed.any() else None
        self.kept -= set(np.flatnonzero(~np.isnan(words[:, :until]).all(axis=1)).tolist())
        for row, before in zip(words, self.at.words, strict=True):
            row[:] = bulk.held(row, before)
        self.begin()
        feeds = bulk.held(feeds, self.feed)
        self.at.go(words[:, -1].copy())
        self.feed = feeds[-1]
        self.emit(words, feeds, seconds, rapid, numbers, self.at.tcp)

    def emit(
        self, words: np.ndarray, feeds: np.ndarray, seconds: np.ndarray, rapid: np.ndarray, numbers: np.ndarray,
        tcp: bool,
    ) -> None:  # fmt: skip
        """Keep moves, resolved; those on the way to the first position, from where nobody knows, are none."""
        rapid = rapid | (self.motion == "rapid")
        unknown = np.isnan(words).any(axis=0)
        point = self.at.resolved(self.at.words[:3]) if tcp else self.at.joints()
        start = np.r_[point, self.at.words[3:]]
        if unknown[0] or np.isnan(start).any():
            where = self.line + int(numbers[0]), self.count, self.at.machine
            self.blind.append(Blind(*where, start, words[:, 0].copy(), tcp, self.aside))
        if unknown.any():
            first = int(unknown.argmax())
            lacking = ", ".join(self.names[axis] for axis in np.flatnonzero(np.isnan(words[:, first])))
            self.notes.setdefault("unplaced", (self.line + int(numbers[first]), lacking))
        if (unknown & ~rapid).any() and not self.turning:
            self.line += int(numbers[(unknown & ~rapid).argmax()])
            raise self.unplaced(np.isnan(words[:, (unknown & ~rapid).argmax()]))
        if self.kept and not rapid.all():
            self.note("tool change", ", ".join(self.names[axis] for axis in sorted(self.kept)))
        untimed = np.isnan(seconds)
        if self.inverse and (untimed & ~rapid).any():
            self.line += int(numbers[(untimed & ~rapid).argmax()])
            raise self.error("an F word, inverse time being active", "none")
        feeds, tcps = np.where(rapid | ~untimed, np.nan, feeds), np.full(len(feeds), tcp)
        known = slice(None) if not unknown.any() else ~unknown
        of_moves = words, feeds, seconds, rapid, tcps, self.line + numbers
        self.keep(*(column[..., known] for column in of_moves))

    def unplaced(self, missing: np.ndarray) -> InputError:
        """Return the error of a move at feed from where nobody knows, with how to say where the axes stand."""
        lacking = [name for name, lacks in zip(self.names, missing, strict=True) if lacks]
        stated = self.at.setup.start
        start = dict.fromkeys(lacking, 0.0) | stated
        lost = (self.changed or self.count) and any(name in self.names[:3] for name in lacking)
        shown = ",".join(f"{name}{start[name]:g}" for name in self.names if name in start)
        hint = "" if lost or set(lacking) & set(stated) else f", or --start {shown}"
        article = "an" if lacking[0][0] in "AX" else "a"
        words = f"{article} {lacking[0]} word" if len(lacking) == 1 else f"words of {', '.join(lacking)}"
        return self.error(f"{words} before or in the first move{hint}", "none")

    def error(self, expected: str, found: str | None) -> InputError:
        return InputError(f"{self.name}, line {self.line}", expected, found)
