"""The commands, from the shell's own parsers, and their worked examples, run while the site is made."""

from __future__ import annotations

import argparse
import contextlib
import io
import shlex
import shutil
import tempfile
from dataclasses import dataclass
from pathlib import Path

from mathpost.files import data_file, read_text, read_toml
from mathpost.interface.shell.main import COMMANDS, main, option_actions

TOLD = read_toml(Path(__file__).with_name("commands.toml"))
LINES = 40  # of an example's output that are shown


@dataclass(frozen=True)
class Option:
    """An argument of a command."""

    words: str  # as typed, such as "--machine FILE"
    said: str  # its help, and its choices
    required: bool


@dataclass(frozen=True)
class Example:
    """A command line, run."""

    says: str
    run: str
    printed: str
    status: int
    shows: str  # the name of a file that it wrote, or ""
    written: str  # its first lines


@dataclass(frozen=True)
class Command:
    """A command: its purpose, its options and examples of its use."""

    name: str
    said: str
    about: str  # Markdown
    options: list[Option]
    examples: tuple[Example, ...]


def read(lessons: Path) -> list[Command]:
    """Return all commands, in the shell's order; their examples run in a folder with `data` and the lessons."""
    examples: dict[str, tuple[Example, ...]] = {}
    with tempfile.TemporaryDirectory() as folder:
        here = Path(folder)
        shutil.copytree(data_file("cl").parent, here / "data", ignore=shutil.ignore_patterns("__pycache__"))
        (here / "notebooks").mkdir()
        for path in sorted(lessons.glob("*.ipynb")):
            shutil.copy(path, here / "notebooks")
        with contextlib.chdir(here):
            for name, told in TOLD.items():
                given = (each for each in told.get("example", ()) if _has_its_lessons(each["run"]))
                examples[name] = tuple(_run(**each) for each in given)
    return [
        Command(name, said, TOLD[name].get("about", ""), _options(name), examples[name])
        for name, said in COMMANDS.items()
    ]


def _has_its_lessons(run: str) -> bool:
    """Whether the lessons that an example takes are in the folder, which may be a user's own."""
    taken = shlex.split(run.partition(" -o ")[0])
    return all(Path(word).exists() for word in taken if word.startswith(("notebooks", "handed_out")))


def _run(says: str, run: str, shows: str = "") -> Example:
    """Run an example here."""
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed), contextlib.redirect_stderr(printed):
        status = main(shlex.split(run))
    written = _first(read_text(shows)) if shows else ""
    return Example(says, run, _first(printed.getvalue()), status, shows, written)


def _first(text: str) -> str:
    """The first lines of a text."""
    lines = text.splitlines()
    left = len(lines) - LINES
    return "\n".join(lines if left < 2 else [*lines[:LINES], f"… and {left} lines more"])


def _options(name: str) -> list[Option]:
    """The options of a command, or of its second word."""
    actions = option_actions(name)
    for action in actions:
        if isinstance(action.choices, dict):
            (second,) = action.choices.values()
            return [_option(each) for each in second._actions if each.dest != "help"]
    return [_option(action) for action in actions]


def _option(action: argparse.Action) -> Option:
    """An argument as the help describes it."""
    values = action.metavar or ("" if action.choices or action.nargs == 0 else action.dest.upper())
    values = " ".join(values) if isinstance(values, tuple) else values
    words = f"{', '.join(action.option_strings)} {values}".strip()
    said, choices = (action.help or "") % vars(action), ", ".join(action.choices or ())
    return Option(words, ": ".join(filter(None, [said, choices])), action.required)
