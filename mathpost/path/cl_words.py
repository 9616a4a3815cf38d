"""The words of APT CL files, in three classes.

Modelled words change the motion or the program: a method ``on_word`` is called with the text after the slash. Words
that move the tool are in `moves` and `holes`, commands to the control in `orders`. Comments are names, displays and
settings without motion. All others are hazardous: a file that has one is refused, because ignoring it could drop or
spoil a cut. ``data/cl/words.toml`` lists the words of the last two classes, and what to do instead.

Forms differ from system to system; those of NX (.cls), Creo (.ncl), CATIA (.aptsource) and SolidWorks are known.
"""

import re
from collections.abc import Callable, Collection

from mathpost.errors import InputError
from mathpost.files import data_file, read_toml
from mathpost.path.cl_lines import REAL
from mathpost.path.holes import Holes
from mathpost.path.modal import Command

WORDS = read_toml(data_file("cl/words.toml"))
FAMILIES = tuple(WORDS["comments"]["families"])
COMMENTS = {word: kind for kind, words in WORDS["comments"].items() for word in words}
MAJOR = re.compile(r"TOOL\s+PATH|[A-Z_][A-Z0-9_-]*|\S*")
ALIASES, REFUSED, MOVING = WORDS["aliases"], WORDS["refused"], frozenset(WORDS["moving"]["words"])


def in_program(statement: str) -> str:
    """Return what a program says of a statement that is no command: nothing if it is only a setting or a display.

    Examples
    --------
    >>> in_program("PPRINT/CLAMP FIRST"), in_program("PAINT/SPEED,10")
    ('CLAMP FIRST', '')
    """
    major, _, _ = statement.partition("/")
    word = " ".join(MAJOR.findall(major.upper())[0].split())
    if COMMENTS.get(word) == "text":
        return statement[len(word) :].lstrip(" /")
    unwritten = word in COMMENTS or word.startswith(FAMILIES) or hasattr(Statements, _method(word))
    return "" if unwritten and word != "INSERT" else statement


def _method(word: str) -> str:
    return f"on_{ALIASES.get(word, word).lower()}"


class Statements(Holes):
    """Takes all statements; arguments as for `cl.read`."""

    def __init__(self, name: str, tolerance: float, ignored: Collection[str] = ()) -> None:
        super().__init__(name, tolerance)
        self.ignored = {word.upper() for word in ignored}
        if moving := sorted(self.ignored & MOVING):
            found = f"{', '.join(moving)}: it moves the tool, or says where or how fast a later word does"
            raise InputError(f"{name}: words to be ignored", "words that move nothing", found)

    def takes_plain(self) -> bool:
        """Whether a GOTO is at present nothing but a move to its point."""
        special = self.circle or self.arc_before or self.cycle or self.unconfirmed
        unsure = self.coordinates.unsettled or self.modal.skip or self.modal.lacks_speed
        return not (special or unsure or self.unfinished or self.comment or self.rapid)

    def take(self) -> None:
        major, _, minor = self.statement.partition("/")
        upper = major.upper()
        word = " ".join(MAJOR.findall(upper)[0].split())
        if word != "GOTO":
            self.arc_before = None
        modelled = self.method(word)
        if word in self.ignored:
            self.counts[f"ignored as asked {word}"] += 1
            self.remark()
        elif word in COMMENTS or word.startswith(FAMILIES):
            self.remark(self.described(COMMENTS.get(word, ""), minor))
        elif word in REFUSED:
            self.problem(self.start, word, f"other words: {REFUSED[word]}")
        elif modelled is None:
            self.problem(self.start, "", "a CL statement that is known")
        elif word not in ("INSERT", "PPWORD") and upper.strip().replace(" ", "") not in (word, "TLON,GOFWD"):
            self.problem(self.start, word, f"{word} and a slash")
        else:
            try:
                modelled([each.strip().upper() for each in minor.split(",")] if minor.strip() else [])
            except InputError as error:
                self.problem(self.start, word, error.expected, error.found)

    def described(self, kind: str, minor: str) -> Command | None:
        """Return what a comment names: the operation and its tool, or the cutter; None if neither."""
        words = [word.strip() for word in minor.split(",")]
        if kind == "operations" and words[0]:
            tool = words[2:3] if words[1:2] == ["TOOL"] else []
            return Command("operation", (words[0], *tool), self.statement)
        if kind == "cutters":
            numbers = [float(word) * self.scale for word in words if REAL.fullmatch(word)]
            said = [] if numbers and not words[0].isalpha() else words[:1]
            said += [f"D{diameter:g}" for diameter in numbers[:1]]
            said += [f"R{radius:g}" for radius in numbers[1:2] if radius and words[0].upper() != "DRILL"]
            return Command("cutter", tuple(said), self.statement)
        return None

    def method(self, word: str) -> Callable[[list[str]], None] | None:
        """Return the method that takes the statements of a word, or None."""
        return getattr(self, _method(word), None)

    def on_insert(self, words: list[str]) -> None:
        self.insert()

    def on_ppword(self, words: list[str]) -> None:
        """Take a post-processor's statement within one of the CAM system, such as PPWORD/COOLNT,ON."""
        inner = self.statement.partition("/")[2].strip()
        word, _, rest = inner.partition("/" if "/" in inner else ",")
        word = word.strip().upper()
        known = word != "PPWORD" and (word in COMMENTS or self.method(word) is not None)
        if not known:
            raise InputError("", "other words: it puts words into the program that nobody knows here", repr(inner))
        outer, self.statement = self.statement, f"{word}/{rest}" if rest else word
        self.take()
        self.statement = outer
