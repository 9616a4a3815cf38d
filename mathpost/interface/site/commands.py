"""The commands, from the shell's own parsers, and their worked examples, run while the site is made."""

from __future__ import annotations

import contextlib
import io
import shlex
import shutil
import tempfile
from pathlib import Path
from typing import Any

from mathpost.files import data_file, read_text, read_toml
from mathpost.interface.shell.main import COMMANDS, main, option_actions

TOLD = read_toml(Path(__file__).with_name("commands.toml"))
LINES = 40  # of an example's output that are shown


def read(lessons: Path) -> list[dict[str, Any]]:
    """Return all commands, in the shell's order, as ``command.md.j2`` shows them.

    Their examples run in a folder with `data` and the lessons.
    """
    with tempfile.TemporaryDirectory() as folder:
        here = Path(folder)
        shutil.copytree(data_file("cl").parent, here / "data", ignore=shutil.ignore_patterns("__pycache__"))
        (here / "notebooks").mkdir()
        for path in sorted(lessons.glob("*.ipynb")):
            shutil.copy(path, here / "notebooks")
        with contextlib.chdir(here):
            examples = {
                name: [_run(**each) for each in told.get("example", ()) if _has_its_lessons(each["run"])]
                for name, told in TOLD.items()
            }
    return [
        {"name": name, "said": said, "about": TOLD[name].get("about", "")}
        | {"options": _options(name), "examples": examples[name]}
        for name, said in COMMANDS.items()
    ]


def _has_its_lessons(run: str) -> bool:
    """Whether the lessons that an example takes are in the folder, which may be a user's own."""
    taken = shlex.split(run.partition(" -o ")[0])
    return all(Path(word).exists() for word in taken if word.startswith(("notebooks", "handed_out")))


def _run(says: str, run: str, shows: str = "") -> dict[str, Any]:
    """Run an example here; `shows` names a file that it writes."""
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed), contextlib.redirect_stderr(printed):
        status = main(shlex.split(run))
    written = _first(read_text(shows)) if shows else ""
    found = {"says": says, "run": run, "status": status, "shows": shows, "written": written}
    return found | {"printed": _first(printed.getvalue())}


def _first(text: str) -> str:
    """The first lines of a text."""
    lines = text.splitlines()
    left = len(lines) - LINES
    return "\n".join(lines if left < 2 else [*lines[:LINES], f"… and {left} lines more"])


def _options(name: str) -> list[dict[str, Any]]:
    """The options of a command, or of its second word, as its help describes them."""
    actions, found = option_actions(name), []
    if isinstance(actions[0].choices, dict):
        (second,) = actions[0].choices.values()
        actions = [each for each in second._actions if each.dest != "help"]
    for action in actions:
        values = action.metavar or ("" if action.choices or action.nargs == 0 else action.dest.upper())
        values = " ".join(values) if isinstance(values, tuple) else values
        words = f"{', '.join(action.option_strings)} {values}".strip()
        said = ": ".join(filter(None, [(action.help or "") % vars(action), ", ".join(action.choices or ())]))
        found.append({"words": words, "said": said, "required": action.required})
    return found
