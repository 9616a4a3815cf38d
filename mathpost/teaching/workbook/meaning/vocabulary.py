"""The words that people write in worksheets: data/workbooks/words.toml, as patterns."""

from __future__ import annotations

import re
from functools import lru_cache

from mathpost.files import data_file, read_toml

LETTER = "A-Za-zÀ-ÿ"


@lru_cache(maxsize=1)
def _said() -> dict[str, dict[str, list[str]]]:
    return read_toml(data_file("workbooks/words.toml"))


def wording(*meanings: str) -> str:
    """Return a pattern, for texts in which capitals do not count, of the words of some meanings in all languages.

    Examples
    --------
    >>> bool(re.search(wording("mirrored"), "gespiegelt")), bool(re.search(wording("about"), "Umfang", re.I))
    (True, False)
    """
    every = [word for meaning in meanings for said in _said()[meaning].values() for word in said]
    return f"(?:{'|'.join(map(_pattern, sorted(every, key=len, reverse=True)))})"


def _pattern(word: str) -> str:
    """The pattern of a word, which ends where its letters do but for a *; Chinese has no blanks between words."""
    body = re.escape(word.strip("*")).replace(r"\ ", r"[\s-]+")
    before, after = f"(?<![{LETTER}])", f"(?![{LETTER}])"
    is_latin = bool(re.match(f"[{LETTER}\\d]", word.strip("*")))
    return before * (is_latin and word[0] != "*") + body + after * (is_latin and word[-1] != "*")
