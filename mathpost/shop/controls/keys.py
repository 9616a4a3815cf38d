"""The keys of a control's file: a field of a dataclass each, with the table that it is in and how it is read."""

from collections.abc import Callable, Mapping
from dataclasses import field, fields
from typing import Any

from mathpost.files import TomlTable, a_number, each, only_if

LINES = (lambda value: tuple(each(str)(value))), "a list of lines"
WORD = only_if(lambda value: isinstance(value, str)), "a word"
WORDS = only_if(lambda value: all(isinstance(word, str) for word in value.values()), dict), "a table of words"
TRUTH = only_if(lambda value: isinstance(value, bool)), "true or false"


def key(table: str, read: Callable, expected: str, *default: Any) -> Any:
    """Return the field of a dataclass that is a key of a table, "" for the file itself; the rest as in `take`."""
    return field(metadata={"table": table, "take": (read, expected, *default)})


def keys_of(kind: type, tables: Mapping[str, TomlTable]) -> dict[str, Any]:
    """Take what the tables of a file have for the keys of a dataclass, by name."""
    found = [each for each in fields(kind) if each.metadata]
    return {each.name: tables[each.metadata["table"]].take(each.name, *each.metadata["take"]) for each in found}


def several(count: int) -> tuple[Callable, str]:
    """Return the reader of so many words."""
    names = {2: "two words", 3: "three words"}
    return only_if(lambda found: len(found) == count, LINES[0]), names[count]


def whole(value: Any) -> int:
    if a_number(value) != int(value):
        raise ValueError
    return int(value)


def filled(lines: list[str], *values: float, **named: float) -> tuple[str, ...]:
    """Return lines whose fields are those of some values."""
    for line in LINES[0](lines):
        try:
            line.format(*values, **named)
        except (KeyError, IndexError):
            raise ValueError from None
    return tuple(lines)
