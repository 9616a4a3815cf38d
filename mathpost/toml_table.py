"""TOML files read key by key, so that a wrong or unknown key is an error that names it."""

from __future__ import annotations

import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

from mathpost.errors import InputError
from mathpost.files import read_text

LARGEST = 1e9  # absolute value of a number


def read_toml(path: Path | str) -> dict[str, Any]:
    """Return the content of the TOML file `path` as a dict; raise `InputError` if it is none."""
    text = read_text(path)
    try:
        return tomllib.loads(text)
    except (ValueError, RecursionError) as error:  # a number of thousands of digits, tables thousands deep
        raise InputError(str(path), "a TOML file", str(error)) from None


class TomlTable:
    """A TOML table that is emptied key by key, so that any key left over is unknown."""

    def __init__(self, content: dict[str, Any] | None, where: str) -> None:
        if not isinstance(content, dict):
            raise InputError(where, "a table of keys", "nothing" if content is None else repr(content))
        self.content, self.where = dict(content), where

    def take(self, key: str, read: Callable, expected: str, *default: Any) -> Any:
        if key not in self.content:
            if default:
                return default[0]
            raise InputError(f"{self.where}, key {key!r}", expected, "nothing")
        value = self.content.pop(key)
        try:
            return read(value)
        except (TypeError, ValueError, OverflowError):
            raise InputError(f"{self.where}, key {key!r}", expected, repr(value)) from None

    def table(self, key: str, optional: bool = False) -> TomlTable:
        return TomlTable(self.content.pop(key, {} if optional else None), f"{self.where}, [{key}]")

    def done(self) -> None:
        if self.content:
            key = next(iter(self.content))
            raise InputError(f"{self.where}, key {key!r}", "no such key", repr(self.content[key]))


# Readers return a value as read, or raise ValueError or TypeError; `TomlTable.take` adds where.


def only_if(holds: Callable, read: Callable = lambda value: value) -> Callable:
    """A reader that refuses a value unless `holds` is true of what `read` makes of it."""

    def checked(value: Any) -> Any:
        if not holds(found := read(value)):
            raise ValueError
        return found

    return checked


def a_number(value: object) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) < LARGEST:
        raise ValueError
    return float(value)


def numbers(count: int) -> Callable:
    return only_if(lambda found: len(found) == count, lambda value: tuple(map(a_number, value)))


def each(kind: type) -> Callable:
    return only_if(lambda value: isinstance(value, list) and all(isinstance(entry, kind) for entry in value))


def one_of(*words: str) -> tuple[Callable, str]:
    return only_if(lambda value: value in words), " or ".join(f'"{word}"' for word in words)


some_text = only_if(lambda value: isinstance(value, str) and value.strip())
