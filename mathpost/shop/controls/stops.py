"""All words at which the reading of a program stops, at once: what may be passed over, and what may not.

Reading stops at the first word that is not known. The rest of the program is then looked through word by word, and
nothing is done: what is known, and what only the first stop has caused, is not told.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import TYPE_CHECKING

from mathpost.errors import InputError
from mathpost.files import NUMBER
from mathpost.shop.controls import control as controls

if TYPE_CHECKING:
    from mathpost.shop.controls.reader import ProgramReader

MOST_LINES = 200_000  # that are looked through
SHOWN = 3  # lines of each word
MOST_WORDS = 20  # of each kind
# A word of the machine's maker: M words with the numbers that belong to them.
MAKERS = re.compile(rf"M\d+(?:\s*[PQRES]{NUMBER})*(?![\w.])")


def with_all(error: InputError, reader: ProgramReader) -> InputError:
    """Return the error at which reading has stopped with all the words at which it would stop next."""
    found: dict[str, list[int]] = {}
    for number, word in _unknown(reader):
        found.setdefault(word, []).append(number)
    skipped = [word for word in found if re.match(r"M\d+(?![\w.])", word) and _stays(word)]
    others = [word for word in found if word not in skipped]
    said = []
    if skipped:
        option = " ".join(f"--skip '{word}'" if " " in word else f"--skip {word}" for word in skipped[:MOST_WORDS])
        entry = ", ".join(f'"{word}"' for word in skipped[:MOST_WORDS])
        said.append(
            f"Not known of the machine: {_listed(skipped, found)}. Those that move no axis: in [program] of the"
            f" machine file skip = [{entry}], or for verify {option}"
        )
    if others:
        said.append(f"Not read, and may move an axis or decide what runs: {_listed(others, found)}")
    if not said:
        return error
    return InputError(error.where, error.expected, ". ".join([f"{error.found}", *said]))


def _listed(words: list[str], found: dict[str, list[int]]) -> str:
    texts = []
    for word in words[:MOST_WORDS]:
        numbers = found[word]
        more = f" and {len(numbers) - SHOWN} more" if len(numbers) > SHOWN else ""
        texts.append(f"{word} (line {', '.join(map(str, numbers[:SHOWN]))}{more})")
    return ", ".join([*texts, *([f"{len(words) - MOST_WORDS} more words"] if len(words) > MOST_WORDS else [])])


def _unknown(reader: ProgramReader) -> Iterator[tuple[int, str]]:
    """The words that stop the reading, with their lines, from the first stop to the end."""
    begun = ""
    for number, text in enumerate(reader.texts[:MOST_LINES], 1):
        if number < reader.line:
            continue
        text = begun + text
        if reader.control.continued and text.endswith(reader.control.continued):
            begun = text.removesuffix(reader.control.continued) + " "
            continue
        begun = ""
        try:
            body = reader.bare(text)
        except InputError:
            yield number, reader.words_of(text)[:30]
            continue
        while body:
            word = reader.next_word(body)
            if word is None:
                match = MAKERS.match(body)
                text = match[0] if match else body.split(maxsplit=1)[0]
                yield number, _template(text)
            elif word.meaning == "end":
                return
            elif word.meaning == "flow":
                yield number, word.text[:30]
            body = body[len(word.text if word else text) :].lstrip()


def _template(word: str) -> str:
    """A word of the maker with {} for the numbers behind it."""
    first, *rest = re.findall(rf"[A-Z]{NUMBER}", word) if MAKERS.fullmatch(word) else [word[:30]]
    return " ".join([first, *(f"{each[0]}{{}}" for each in rest)])


def _stays(word: str) -> bool:
    """Whether no control that we know moves an axis by an M word, or switches how words are taken."""
    for name in controls.names():
        known = controls.load(name).words.begins(word)
        if known and known.meaning != "skip":
            return False
    return True
