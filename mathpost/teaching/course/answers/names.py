"""Names as answers: one of several, or some of them."""

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from mathpost.errors import InputError
from mathpost.teaching.course.answers.kind import Data, Kind
from mathpost.teaching.course.typed import bare, brief


@dataclass(frozen=True)
class _Listed(Kind[Data]):
    """An answer made of given names."""

    choices: str | Mapping[str, Sequence[str]]  # in one string, or each with its synonyms, such as Chinese ones

    @property
    def known(self) -> dict[str, str]:
        """A dict of each spelling to its name."""
        if isinstance(self.choices, str):
            return {_key(name): name for name in self.choices.split()}
        return {_key(said): name for name, others in self.choices.items() for said in (name, *others)}

    @property
    def listed(self) -> list[str]:
        """Every name once."""
        return list(dict.fromkeys(self.known.values()))

    @property
    def shown(self) -> str:
        """The names in words; if there are many, the first three."""
        names = self.listed
        return f"of {', '.join(names)}" if len(names) <= 12 else f"such as {', '.join(names[:3])}"

    def one(self, answer: Any) -> str:
        """Return the one name in an answer."""
        if isinstance(answer, (list, tuple)) and len(answer) == 1:
            (answer,) = answer
        typed = answer
        if isinstance(answer, str):
            answer = re.sub(r"\b(?:minus|negative)\s+(?=\S)|负", "-", answer, flags=re.IGNORECASE)
        letters = re.sub(r"\bthen\b|[\W\d_]", " ", str(answer)).split()
        if _key(answer) not in self.known and len(letters) > 1 and max(map(len, letters)) == 1:
            answer = "".join(letters)  # Z-X'-Y'', Z → X → Y, ["Z", "X", "Y"]
        parts = [answer] if _key(answer) in self.known else re.split(r"\s+|(?<=\w)-(?=\w)", str(answer).strip())
        words = {_key(part) for part in parts}
        for first, second in pairwise(parts):  # "the cubic lifted"
            if _key(first + second) in self.known:
                words = words - {_key(first), _key(second)} | {_key(first + second)}
        found = {self.known[word] for word in words if word in self.known}  # "the z axis"
        plain = all(word.isalpha() for word in words - set(self.known)) and not {"not", "no", "nor"} & words
        if len(found) == 1 and plain:
            return found.pop()
        raise InputError("answer", self.asked, brief(typed))


def _key(name: object) -> str:
    """Return a name as it is looked up: as `bare`, and without the hyphen of a word such as space-fixed."""
    return re.sub(r"(?<=\w)-(?=\w)", "", bare(name))


@dataclass(frozen=True)
class Name(_Listed[str]):
    """One of several names; case, spaces, quotes, primes, brackets and marks between letters do not matter.

    Examples
    --------
    >>> Name("x y z").read(" 'Z′' "), Name({"active": ["主动"], "passive": ["被动"]}).read("主动")
    ('z', 'active')
    >>> Name("ZXY ZYX").read("z-x'-y''"), Name("Z -Z").read("-Z")
    ('ZXY', '-Z')
    >>> Name({"cubic": [], "cubic lifted": []}).read("the cubic lifted")
    'cubic lifted'
    """

    @property
    def asked(self) -> str:
        return f"{'one' if self.shown.startswith('of') else 'a name'} {self.shown}"

    def read(self, answer: Any) -> str:
        return self.one(answer)

    def show(self, value: str) -> str:
        return value


@dataclass(frozen=True)
class Names(_Listed[list[str]]):
    """Some of several names, in any order: a list, a set, or one string."""

    about: Callable[[str], str | None] | None = None  # says why a name does not belong

    @property
    def asked(self) -> str:
        return f"a list of names: some {self.shown}"

    def read(self, answer: Any) -> list[str]:
        if isinstance(answer, str):
            parts = re.split(r"[,;，、；/]+|\band\b|和|与", answer.strip("[](){} "))
            listed = [part.split() if {*map(bare, part.split())} <= set(self.known) else [part] for part in parts]
            answer = [name for names in listed for name in names if bare(name)]
        found = {self.one(each) for each in np.asarray(list(answer), dtype=object).ravel()}
        return [name for name in self.listed if name in found]

    def mixups(self, target: list[str]) -> Iterator[tuple[str, list[str]]]:
        others = [name for name in self.listed if name not in target]
        yield "These are the others: exactly those that do not belong.", others

    def nearly(self, value: list[str], target: list[str]) -> str:
        for name in value:
            if name not in target:
                return f"{name} does not belong here. {self.about(name) if self.about else ''}".strip()
        return "All of these belong, but there are more." if value else "There are some."

    def show(self, value: list[str]) -> str:
        return ", ".join(value)
