"""The words of an NC block, whoever wrote it: an address and its number (X1.5, SPA+30, C=90), or an address alone.

`mathpost.shop.controls.words` are all the words of one control, with what they mean to it.
"""

import re
from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from mathpost.errors import InputError
from mathpost.files import NUMBER, text_of


def _word(address: str) -> str:
    return rf"(?<![A-Z])({address})\s*=?\s*({NUMBER})(?![\d.])"


WORD = re.compile(_word("[A-Z]+"))
# M words that controls have in common or leave to the maker of the machine; they move no axis.
AUXILIARY = re.compile(r"M(?:0?[01345789]|1[0-689]|2\d|3[1-9]|[4-7]\d|8[0-8])")
CALL = re.compile(r"(\w+)\s*\(([^()]*)\)")


def bare(line: str, comments: re.Pattern[str], number: re.Pattern[str]) -> str:
    """Return a line without its stroke, its comments and its number, see `tidy`."""
    return number.sub("", tidy(comments.sub(" ", line.removeprefix("/")).strip()), count=1)


def tidy(text: str) -> str:
    """Return capital letters, without a blank between a letter and its number."""
    return re.sub(r"(?<![A-Z_\"])([A-Z])\s+(?=[-+]?\.?\d)", r"\1", text.upper())


def arguments(call: str) -> tuple[str, list[str]]:
    """Return the name of the call that a text begins with, "" if none, and its arguments, "" for those left out.

    Examples
    --------
    >>> arguments("CYCLE81(10,0,,-8.5)")
    ('CYCLE81', ['10', '0', '', '-8.5'])
    """
    found = CALL.match(call.strip())
    return (found[1], [each.strip() for each in found[2].split(",")]) if found else ("", [])


def numbers(given: Sequence[str]) -> list[float]:
    """Return arguments as numbers, 0 for those left out; `ValueError` if one is none."""
    if not all(re.fullmatch(rf"(?:{NUMBER})?", each) for each in given):
        raise ValueError
    return [float(each or 0) for each in given]


def written(values: Mapping[str, float], decimals: int = 4, plus: str = "", point: str = "") -> str:
    """Return words with their numbers; `plus` before one without a sign, `point` behind one without a point.

    Examples
    --------
    >>> written({"X": 0, "Y": -5.5}), written({"I": 135, "J": 54.73561}, point=".")
    ('X0 Y-5.5', 'I135. J54.7356')
    """
    texts = [(word, text_of(value, decimals)) for word, value in values.items()]
    return " ".join(f"{word}{plus * (text[0] != '-')}{text}{point * ('.' not in text)}" for word, text in texts)


class Words:
    """The words of a block: what nobody has taken in the end is refused."""

    def __init__(self, block: str, where: str) -> None:
        self.block, self.where, self.rest = block, where, block
        self.half = 0.0  # half of the last digit of those numbers taken that have three or more after the point

    def begin(self, *heads: str) -> str:
        """Take what the block begins with; "" if it is none of `heads`."""
        head = next((head for head in heads if re.match(rf"{re.escape(head)}(?![A-Z\d.])", self.rest)), "")
        self.rest = self.rest.removeprefix(head)
        return head

    def take(self, addresses: Iterable[str], optional: bool = False) -> np.ndarray:
        """Take the numbers of words, each there once; a missing one is 0 if `optional`."""
        values = []
        for address in addresses:
            found = [number for _, number in re.findall(_word(address), self.rest)]
            if len(found) > 1 or not (found or optional):
                expected = f"one word {address} with a number"
                raise InputError(self.where, expected, f"{len(found)} in {self.block!r}")
            values.append(float(found[0]) if found else 0.0)
            if found and (digits := len(found[0].partition(".")[2])) > 2:
                self.half = max(self.half, 0.5 * 10.0**-digits)
            self.rest = re.sub(_word(address), " ", self.rest)
        return np.array(values)

    def whole(self, address: str, allowed: Sequence[int], missing: int) -> int:
        """Take a word whose number is one of the `allowed` whole ones, or missing."""
        if not re.search(rf"(?<![A-Z]){address}", self.rest):
            return missing
        value = self.take(address)[0]
        if value not in allowed:
            found = f"{address}{value:g}"
            raise InputError(self.where, f"{address} with one of {', '.join(map(str, allowed))}", found)
        return int(value)

    def all(self) -> list[tuple[str, str]]:
        """Take all words, each its address and its number as text."""
        found, rest = WORD.findall(self.rest), WORD.sub("", self.rest)
        if rest.strip():
            raise InputError(self.where, "words of a letter and a number", repr(rest.strip()))
        return found

    def drop(self, words: re.Pattern[str]) -> None:
        """Take words that say nothing that is asked for."""
        self.rest = words.sub(" ", self.rest)

    def done(self) -> None:
        if rest := self.rest.split():
            turn = "; R, a turn about I J K, is of G68 X Y Z I J K R" if rest[0].startswith("R") else ""
            raise InputError(self.where, f"no other words in a block of a plane{turn}", repr(" ".join(rest)))
