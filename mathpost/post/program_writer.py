"""The text of an NC program from its moves, whole or in parts."""

import re
from bisect import bisect_left
from dataclasses import dataclass, replace
from operator import itemgetter

import numpy as np

from mathpost.errors import InputError
from mathpost.post import digits
from mathpost.post.dialect import (
    DECIMALS,
    FANUC,
    HEIDENHAIN,
    LAST_BLOCK_NUMBER,
    SHORTEST_TIME,
    Blocks,
    axis_word,
    dialect_named,
    printed,
)
from mathpost.post.digits import Column

ROWS = 4096  # moves that are written at once; what is made of them fits the processor's cache

CODES = {"move": ("G1", "G0"), "mode": ("G94", "G93")}  # each with what rapid or inverse time makes of it


@dataclass(frozen=True)
class State:
    """What holds from block to block, so that it need not be written again.

    Attributes
    ----------
    count, lines : int
        Lines so far that take a block number, and all of them.
    words : tuple of float, optional
        Where the last move ended.
    feed : float, optional
        The last F word, if it still holds.
    move, mode : str
        The G codes that hold: rapid or feed, feed by time or not. Heidenhain has none.
    """

    count: int = 0
    lines: int = 0
    words: tuple | None = None
    feed: float | None = None
    move: str = ""
    mode: str = "G94"


class Writer:
    """Writes a program, in parts if need be: joined they are the whole, wherever it is cut.

    Parameters
    ----------
    machine : Machine
        For the names of its axes.
    dialect : str
        ``"heidenhain"``, ``"fanuc"`` or ``"siemens"``.
    name : str
        Program name; letters, digits and underscores of it are used.
    tcp : bool
        Whether the control keeps the tip.

    Attributes
    ----------
    state : State
        Given to another writer of the same program, that one goes on from here.
    """

    def __init__(self, machine, dialect="heidenhain", *, name="MATHPOST", tcp=False):
        self.style, self.tcp, self.state = dialect_named(dialect), tcp, State()
        self.machine, self.axes = machine, machine.joint_names
        self.name = re.sub(r"\W", "_", name, flags=re.ASCII).upper() or "MATHPOST"
        for axis in self.axes[3:]:
            if self.style is HEIDENHAIN and len(axis) > 1:
                raise InputError("rotary axis name", "one letter for a Heidenhain program", repr(axis))

    def head(self):
        """Return the lines before the moves."""
        return self._frame(*self.style.head, *[self.style.tcp_on] * self.tcp)

    def foot(self):
        """Return the lines after the moves."""
        return self._frame(*[self.style.tcp_off] * self.tcp, *self.style.foot)

    def write(self, blocks):
        """Return the lines of some moves, with the remarks before and after them."""
        texts = []
        for part in _parts(blocks):
            count, at, rows = self.state.count, 0, len(part.words)
            before = [row for row, _ in part.remarks]
            columns = self._columns(part, np.searchsorted(before, np.arange(rows), side="right")) if rows else []
            for remarks, (row, remark) in enumerate(part.remarks):
                number = f"{count + row + remarks} " if self.style is HEIDENHAIN else ""
                texts += [_text(columns, at, row), number, _comment(self.style, remark), "\n"]
                at = row
            texts.append(_text(columns, at, rows))
            self.skip(part)
        return "".join(texts)

    def skip(self, blocks):
        """Go on to the state after some moves, without writing them."""
        state, rapid, remarks = self.state, blocks.rapid, len(blocks.remarks)
        count = state.count + len(rapid) + remarks * (self.style is HEIDENHAIN)
        state = replace(state, count=count, lines=state.lines + len(rapid) + remarks)
        if len(rapid):
            timed, cutting = _timed(blocks), np.flatnonzero(~rapid)
            state = replace(
                state, words=tuple(printed(blocks.words[-1]).tolist()), feed=self._feeds(blocks, timed)[1]
            )
            if self.style is not HEIDENHAIN:
                mode = CODES["mode"][int(timed[cutting[-1]])] if cutting.size else state.mode
                state = replace(state, move=CODES["move"][int(rapid[-1])], mode=mode)
        self.state = state

    def _frame(self, *lines):
        """Lines of words that do not move, with block numbers where they take one."""
        texts = []
        for line in lines:
            if self.style is HEIDENHAIN:
                number = f"{self.state.count} "
            else:
                number = "" if line == "%" or line.startswith(("O", ";")) else f"N{self._iso(self.state.count)} "
            texts.append(number + line.format(name=self.name) + "\n")
            self.state = replace(self.state, count=self.state.count + bool(number), lines=self.state.lines + 1)
        return "".join(texts)

    def _iso(self, count):
        """The block number after `count` others."""
        return self.style.number_step * (count % (LAST_BLOCK_NUMBER // self.style.number_step) + 1)

    def _columns(self, blocks, remarks):
        """The moves as `Column`s; `remarks` says how many stand before each."""
        words, timed = printed(blocks.words), _timed(blocks)
        count = self.state.count + np.arange(len(words))
        seconds = np.where(timed, np.maximum(blocks.seconds, SHORTEST_TIME), 1.0)
        if self.style is HEIDENHAIN:
            start, rapid = [Column("", count + remarks), Column(" L")], [Column(" FMAX", shown=blocks.rapid)]
            times = Column(" FT", seconds, 3, shown=timed)
        else:
            start, rapid = [Column("N", self._iso(count)), *self._codes(blocks, timed)], []
            times = Column(" F", 60 / seconds, 4, shown=timed)
        changed = words != np.concatenate([[self.state.words or (np.nan,) * 5], words[:-1]])
        axes = [
            Column(axis_word(name), values, DECIMALS, self.style.sign, shown)
            for name, values, shown in zip(self.axes, words.T, changed.T, strict=True)
        ]
        stated, whole = np.zeros(len(words), bool), blocks.feeds == np.round(blocks.feeds)
        stated[self._feeds(blocks, timed)[0]] = True
        kinds = (0, stated & whole), (3, stated & ~whole)  # as `printed_feed` writes them
        feeds = [Column(" F", blocks.feeds, decimals, shown=shown) for decimals, shown in kinds]
        return [*start, *axes, *rapid, times, *feeds, Column("\n")]

    def _codes(self, blocks, timed):
        """The G codes, where they change."""
        cutting = np.flatnonzero(~blocks.rapid)
        for group, rows, on in (("move", np.arange(len(timed)), blocks.rapid), ("mode", cutting, timed[cutting])):
            codes = np.array(CODES[group])[on.astype(int)]
            changed = codes != np.concatenate([[getattr(self.state, group)], codes[:-1]])
            for code in CODES[group]:
                shown = np.zeros(len(timed), bool)
                shown[rows[changed & (codes == code)]] = True
                yield Column(f" {code}", shown=shown)

    def _feeds(self, blocks, timed):
        """The rows with a feed that is not the one that holds, and the one that holds after all of them."""
        stated = np.flatnonzero(~(blocks.rapid | timed | np.isnan(blocks.feeds)))
        feeds = np.concatenate([[np.nan if self.state.feed is None else self.state.feed], blocks.feeds[stated]])
        # An ISO control that has been told times has forgotten the feed.
        forgotten = np.cumsum(timed) * (self.style is not HEIDENHAIN)
        since = np.concatenate([[0], forgotten[stated]])
        changes = stated[(feeds[1:] != feeds[:-1]) | (since[1:] != since[:-1])]
        holds = since[-1] == forgotten[-1] and not np.isnan(feeds[-1])
        return changes, float(feeds[-1]) if holds else None


def printed_feed(feed):
    """A feed in mm/min as it stands in a program."""
    return f"{feed:.{0 if feed == round(feed) else 3}f}"


def _parts(blocks):
    """Yield at most `ROWS` moves at a time, each remark in its place among them, or all behind the last."""
    rows = len(blocks.words)
    remarks = sorted(((min(row, rows), text) for row, text in blocks.remarks), key=itemgetter(0))
    for start in range(0, max(rows, 1), ROWS):
        stop = start + ROWS
        first = bisect_left(remarks, start, key=itemgetter(0))
        last = bisect_left(remarks, stop, key=itemgetter(0)) if stop < rows else None
        columns = (column[start:stop] for column in (blocks.words, blocks.feeds, blocks.seconds, blocks.rapid))
        yield Blocks(*columns, remarks=tuple((row - start, text) for row, text in remarks[first:last]))


def _timed(blocks):
    return ~(blocks.rapid | np.isnan(blocks.seconds))


def _text(columns, start, stop):
    return digits.text([column[start:stop] for column in columns], stop - start) if stop > start else ""


def _comment(style, remark):
    text = " ".join(remark.split())
    if style is FANUC:
        text = text.replace("(", "[").replace(")", "]")
    return style.comment[0] + text + style.comment[1]
