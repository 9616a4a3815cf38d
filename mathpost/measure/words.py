"""The words that people use for columns and units of readings, mapped to names and to mm or radians.

Other names of columns are in data/measurements/words.toml.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from functools import lru_cache

from mathpost.errors import NUMBER
from mathpost.files import data_file
from mathpost.toml_table import read_toml

# The quantity that a unit measures, and its size in mm or radians.
UNITS = {
    ("mm", "毫米", "millimetre", "millimetres", "millimeter", "millimeters"): ("length", 1.0),
    ("µm", "μm", "um", "微米", "micron", "microns", "micrometre", "micrometres", "micrometer", "micrometers",
     "mikrometer"): ("length", 1e-3),
    ("in", "inch", "inches"): ("length", 25.4),
    ("thou", "mil"): ("length", 25.4e-3),
    ("cm",): ("length", 10.0),
    ("m",): ("length", 1000.0),
    ("deg", "degree", "degrees", "°", "度", "grad"): ("angle", math.radians(1)),
    ("gon",): ("angle", math.radians(0.9)),
    ("arcmin", "′", "'"): ("angle", math.radians(1 / 60)),
    ("arcsec", "″", '"', "''", "角秒", "秒", "arcsecond", "arcseconds"): ("angle", math.radians(1 / 3600)),
    ("rad",): ("angle", 1.0),
    ("mrad",): ("angle", 1e-3),
    ("µrad", "μrad", "urad"): ("angle", 1e-6),
}  # fmt: skip
LONGEST = 80  # characters of a name or a number that are read
APART = " _-./:"  # characters between the words of a name


def measure(stated: str) -> tuple[str | None, float]:
    """Return what a unit, or a number of units, measures and its size in mm or radians; None for other words."""
    stated = stated.strip()
    number = re.match(NUMBER, stated)
    count = number[0] if number else ""
    word = stated[len(count) :].strip().casefold()
    for words, (measures, size) in UNITS.items():
        if word in words and float(count or 1) > 0:
            return measures, size * float(count or 1)
    return None, 0.0


@lru_cache(maxsize=1)
def _said() -> dict[str, dict[str, list[str]]]:
    return read_toml(data_file("measurements/words.toml"))


def is_aside(name: str) -> bool:
    """Return whether a column is one that is not read."""
    return name.casefold() in _said()["aside"]["words"]


class Names:
    """The columns that a file may have, by the names that people give them.

    `also` maps further words to names.

    Examples
    --------
    >>> names = Names(["A", "x", "ex", "up1"])
    >>> [names.find(cell) for cell in ("A axis [°]", "X", "Δx_um", "forward 1", "torque")]
    [('A', '°'), ('x', None), ('ex', 'um'), ('up1', None), (None, None)]
    """

    def __init__(self, wanted: Iterable[str], also: dict[str, str] | None = None) -> None:
        other = _said()["columns"]
        self.wanted = tuple(wanted)
        self.words = {word.casefold(): name for name in self.wanted for word in (*other.get(name, ()), name)}
        self.words |= {word.casefold(): name for word, name in (also or {}).items()}

    def find(self, cell: str) -> tuple[str | None, str | None]:
        """Return the name that a cell of the header means, None if none, and the unit that follows it."""
        if len(cell) > LONGEST:
            return None, None
        name, unit = bracket(cell)
        found = self._name(name)
        if found or unit:
            return found, unit
        ends = re.fullmatch(r"(.+?)(?:[\s_/,]+|(?=[°′″]))(\S+)", cell)  # ex/µm, ex_um, A°
        if ends and measure(ends[2])[0]:
            return self._name(ends[1]), ends[2]
        return None, None

    def _name(self, text: str) -> str | None:
        """Return the name that a text without a unit means."""
        if text in self.wanted:
            return text
        word = text.casefold()
        if word in self.words:
            return self.words[word]
        for name in _without(word, _said()["letter"]["axis"]):
            if len(name) == 1 and name in self.words:
                return self.words[name]
        for name in _without(word, _said()["letter"]["error"]):
            if name in ("x", "y", "z") and f"e{name}" in self.words:
                return self.words[f"e{name}"]
        return self._run(word)

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


def bracket(cell: str) -> tuple[str, str | None]:
    """A column's name, and the text in brackets after it."""
    found = re.fullmatch(r"(.*?)\s*(?:[(\[（](.*)[)\]）])?", cell, re.DOTALL)
    return (found[1], found[2]) if found else (cell, None)


def _without(text: str, words: Iterable[str]) -> list[str]:
    """Return `text` without each of the words that begins or ends it, where something is left."""
    left = [text.removeprefix(word).strip(APART) for word in words if text.startswith(word)]
    left += [text.removesuffix(word).strip(APART) for word in words if text.endswith(word)]
    return [each for each in left if each]
