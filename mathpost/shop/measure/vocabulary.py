"""The words that people use for columns and units of readings, mapped to names and to mm or radians.

They are in data/measurements/words.toml.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from functools import lru_cache
from typing import Any

from mathpost.files import NUMBER, data_file, read_toml

LONGEST = 80  # characters of a name or a number that are read
MOST = 16  # parts of a name that are looked at
SIDES = ("forth", "back", "axial", "lateral")  # readings that may be called deviations, too
APART = " _-./:|"  # characters between the words of a name


@lru_cache(maxsize=1)
def _said() -> dict[str, dict[str, Any]]:
    return read_toml(data_file("measurements/words.toml"))


@lru_cache(maxsize=1)
def units() -> dict[str, tuple[str, float]]:
    """Return what each unit, by its word, measures, and its size in mm or radians."""
    sizes = {"length": 1.0, "angle": math.radians(1)}
    kinds = _said()["units"].items()
    return {
        word: (kind, entry["size"] * sizes[kind])
        for kind, entries in kinds
        for entry in entries
        for word in entry["words"]
    }


def unit_names(kind: str) -> list[str]:
    """Return a word for each unit of ``"length"`` or ``"angle"``."""
    return [entry["words"][0] for entry in _said()["units"][kind]]


def measure(stated: str) -> tuple[str | None, float]:
    """Return what a unit, or a number of units, measures and its size in mm or radians; None for other words."""
    number = re.match(NUMBER, stated.strip())
    count = number[0] if number else ""
    kind, size = units().get(stated.strip()[len(count) :].strip().casefold(), (None, 0.0))
    return (kind, size * float(count or 1)) if kind and float(count or 1) > 0 else (None, 0.0)


def is_aside(name: str) -> bool:
    """Return whether a column of this name is one that is not read: a remark, a time, a temperature."""
    said, word = _said()["aside"], name.casefold()
    ends = tuple(each for each in said["quantities"] if len(each) > 5)  # Lufttemperatur
    return word in said["words"] or any(_holds(word, each) for each in said["quantities"]) or word.endswith(ends)


def is_count(name: str) -> bool:
    """Return whether a column whose name means nothing else counts rows, or says with what was measured."""
    return any(_holds(name.casefold(), word) for word in _said()["aside"]["words"] if len(word) > 1)


def instead(name: str) -> str:
    """Return what a column should hold instead of what its name says, an empty text if that is not known."""
    for other in _said()["instead"].values():
        if any(_holds(name.casefold(), word) for word in other["words"]):
            return str(other["write"])
    return ""


def reverse(text: str) -> bool:
    """Return whether a text says the reverse of what every method reads: "target - actual"."""
    said = _said()["difference"]
    first, second = ("|".join(said[each]) for each in ("first", "second"))
    minus = r"\s*(?:[-−–]|minus)\s*"
    apart = r"\s+(?:[-−–]|minus)\s+"
    pattern = rf"(?:{second})\w*{minus}(?:{first})|(?:{second})\w*{apart}\w|\w{apart}(?:{first})"
    return bool(re.search(rf"(?<![^\W_])(?:{pattern})(?![-\w]|\W*(?:vergleich|compar))", text.casefold()))


class Names:
    """The columns that a file may have, by the names that people give them.

    A name within a phrase decides if it is the only one that fits: "radius of the ring". `also` maps further words
    to names.

    Examples
    --------
    >>> names = Names(["A", "x", "ex", "up1", "R"])
    >>> [names.find(cell) for cell in ("A axis [°]", "X", "Δx_um", "forward 1", "torque")]
    [('A', '°'), ('x', None), ('ex', 'um'), ('up1', None), (None, None)]
    >>> [names.find(cell)[0] for cell in ("A轴角度", "Run 1 (+)", "Radius of ring", "max x", "radius x")]
    ['A', 'up1', 'R', None, None]
    """

    def __init__(self, wanted: Iterable[str], also: dict[str, str] | None = None) -> None:
        other = _said()["columns"]
        self.wanted = tuple(wanted)
        self.words = {name.casefold(): name for name in reversed(self.wanted)}
        self.words |= {word.casefold(): name for word, name in (also or {}).items()}
        self.unclear: dict[str, list[str]] = {}  # words that may mean several columns
        for name in self.wanted:
            for word in other.get(name, ()):
                self.unclear.setdefault(word, []).append(name)
        alone = {word: names[0] for word, names in self.unclear.items() if len(names) == 1}
        self.words = alone | self.words
        self._found: dict[str, tuple[str | None, str | None]] = {}  # what was asked before

    def find(self, cell: str) -> tuple[str | None, str | None]:
        """Return the name that a cell of the header means, None if none, and the unit that follows it."""
        if cell not in self._found:
            self._found[cell] = self._find(cell) if len(cell) <= LONGEST else (None, None)
        return self._found[cell]

    def _find(self, cell: str) -> tuple[str | None, str | None]:
        name, unit = bracket(cell)
        said = _said()["run"]
        for side in ("up", "down"):  # Run 1 (+)
            if unit and unit.casefold() in (*said[side], *said["sign"][side]):
                return self._run(f"{name} {side}".casefold()), None
        ends = re.fullmatch(r"(.+?)(?:[\s_/,]+|(?=[°′″]))(\S+)", name)  # ex/µm, ex_um, A°
        if unit is None and ends and measure(ends[2])[0]:
            name, unit = ends[1], ends[2]
        return self._name(name), unit

    def _name(self, text: str) -> str | None:
        """Return the name that a text without a unit means."""
        if text in self.wanted:
            return text
        word, said = text.casefold().strip(APART), _said()["letter"]
        if word in self.words:
            return self.words[word]
        for left in _peeled(word, said["axis"]):
            if len(left) == 1 and left in self.words:
                return self.words[left]
        for left in _peeled(word, [*said["axis"], *said["error"]]):
            if left in ("x", "y", "z") and f"e{left}" in self.words:
                return self.words[f"e{left}"]
        for left in _peeled(word, said["error"]):
            if found := self._run(left) or (self.words.get(left) in SIDES and self.words[left]):
                return found
        return self._within(word)

    def _run(self, word: str) -> str | None:
        """Return the column of an ISO 230-2 run: words for its direction and its number, in either order."""
        said = _said()["run"]
        for text in (word, *_without(word, said["word"])):
            for side in ("up", "down"):
                for left in _without(text, said[side]):
                    for number in (left, *_without(left, said["word"])):
                        if number.isdecimal() and f"{side}{int(number)}" in self.wanted:
                            return f"{side}{int(number)}"
        return None

    def _within(self, phrase: str) -> str | None:
        """Return the only name that a phrase holds, unless words beside it make something else of it.

        A letter alone decides nothing beside words that are not known.
        """
        said = _said()["letter"]
        if re.search(r"\d", phrase) or any(_holds(phrase, word) for word in said["not"]):
            return None
        found = {word: name for word, name in self.words.items() if _holds(phrase, word)}
        names = {name for word, name in found.items() if len(word) > 1}
        letters = {name for word, name in found.items() if len(word) == 1}
        if letters - names and not any(_holds(phrase, word) for word in said["error"] if len(word) > 1):
            return None
        return names.pop() if len(names) == 1 else None


def bracket(cell: str) -> tuple[str, str | None]:
    """A column's name, and the text in brackets after it; of several the one that is a unit."""
    name, *parts = re.split(r"\s*[(\[（](.*?)[)\]）]", cell, flags=re.DOTALL)
    stated = [part.strip() for part in parts[::2]]
    units = [part for part in stated if measure(part)[0]]
    return " ".join([name, *parts[1::2]]).strip(), (units or stated or [None])[0]


def _holds(phrase: str, word: str) -> bool:
    """Whether a phrase holds a word as one of its own; Chinese has no blanks between them."""
    if word > "\u2fff":
        return word in phrase
    return word in phrase and bool(re.search(rf"(?<![^\W_]){re.escape(word)}(?![^\W_])", phrase))


def _peeled(text: str, words: Iterable[str]) -> list[str]:
    """Return `text`, and what is left of it without one or several of the words that begin or end it."""
    left, words = [text], list(words)
    for each in left:
        left += [more for more in _without(each, words) if more not in left][: MOST - len(left)]
    return left


def _without(text: str, words: Iterable[str]) -> list[str]:
    """Return `text` without each of the words that begins or ends it, where something is left.

    A word of several letters ends where a word ends, or only a letter or a number is left.
    """
    left = []
    for word in words:
        for at, rest in ((0, text.removeprefix(word)), (-1, text.removesuffix(word))):
            short = rest.strip(APART)
            if (
                rest != text
                and short
                and (len(short) == 1 or not short.isascii() or not (rest[at] + word).isalpha())
            ):
                left.append(short)
    return left
