"""The words of a control as one regular expression, each with its meaning and the fields in it."""

import re
from itertools import pairwise

from mathpost.files import NUMBER
from mathpost.path.nc_words import AUXILIARY


class Words:
    """Words with their meanings: `match` finds the one that a text begins with, the most literal of several."""

    def __init__(self, known: dict[str, str]) -> None:
        ordered = sorted(known.items(), key=lambda item: (-len(re.sub(r"{.*?}", "", item[0])), item[0]))
        patterns = [
            *((_pattern(word), meaning) for word, meaning in ordered),
            (rf"{AUXILIARY.pattern}(?![\d.])", "skip"),
        ]
        every = re.compile("|".join(f"(?P<word{n}>{pattern})" for n, (pattern, _) in enumerate(patterns)))
        self.match = every.match
        places = pairwise((*every.groupindex.values(), every.groups + 1))
        self.meanings = {  # by the group of each word: the meaning, and how many groups are in it
            group: (meaning, following - group - 1)
            for (group, following), (_, meaning) in zip(places, patterns, strict=True)
        }

    def meaning(self, match: re.Match) -> tuple[str, str, tuple[str, ...]]:
        """Return the meaning of what `match` found, its text, and the texts of the fields in it."""
        group = match.lastindex or 0
        meaning, inside = self.meanings[group]
        return meaning, match[0], match.groups()[group : group + inside]


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
