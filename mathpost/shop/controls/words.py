"""The words of a control as one regular expression, each with its meaning and the fields in it."""

import re
from itertools import pairwise
from typing import NamedTuple

from mathpost.files import NUMBER
from mathpost.path.nc_words import AUXILIARY


class Word(NamedTuple):
    """A word of a control."""

    meaning: str
    text: str
    values: tuple[str, ...]  # texts of the fields in it


class Words:
    """All words of a control with their meanings."""

    def __init__(self, known: dict[str, str]) -> None:
        ordered = sorted(known.items(), key=lambda item: (-len(re.sub(r"{.*?}", "", item[0])), item[0]))
        patterns = [
            *((_pattern(word), meaning) for word, meaning in ordered),
            (rf"{AUXILIARY.pattern}(?![\d.])", "skip"),
        ]
        self.every = re.compile("|".join(f"(?P<word{n}>{pattern})" for n, (pattern, _) in enumerate(patterns)))
        places = pairwise((*self.every.groupindex.values(), self.every.groups + 1))
        self.meanings = {  # by the group of each word: the meaning, and how many groups are in it
            group: (meaning, following - group - 1)
            for (group, following), (_, meaning) in zip(places, patterns, strict=True)
        }

    def begins(self, text: str) -> Word | None:
        """Return the word that a text begins with, the most literal of several; None if it is not known."""
        match = self.every.match(text)
        if match is None or not match[0]:
            return None
        group = match.lastindex or 0
        meaning, inside = self.meanings[group]
        return Word(meaning, match[0], match.groups()[group : group + inside])


# What a word of a control's file may contain: a number, a name, the name of an axis, text within brackets or
# quotes, and the rest of the line.
FIELDS = {
    "": f"({NUMBER})",
    "name": r"(\w+)",
    "axis": r"([A-CU-Z](?:\d(?==))?)",
    "text": r"([^()\"]*)",
    "word": r"(\S*)",
    "title": r"([^=]*?(?=\sQ\d|$))",
    "two": r"(\d\d)",
    "letters": r"(?:[^\W\d_]|\.)*",
    "rest": "(.*)",
}


def _pattern(word: str) -> str:
    """A word of a control file as a regular expression; M3 may be written M03."""
    text = re.sub(r"\\ (?=\\{word)|(?<=word\\})\\ ", r"\\s+", re.escape(word))  # a name stands between blanks
    text = text.replace(r"\ ", r"\s*")
    for name, pattern in FIELDS.items():
        text = text.replace(rf"\{{{name}\}}", pattern)
    return re.sub(r"^([GM])(?=\d)", r"\g<1>0*", text) + (r"(?!\w)" if word[-1].isalpha() else r"(?![\d.])")
