"""An option of the shell as a control, made from what argparse knows about it."""

import argparse
import os
import re
from collections.abc import Callable
from contextlib import suppress
from html import escape
from pathlib import Path
from typing import Any

import ipywidgets as widgets

from mathpost.errors import InputError
from mathpost.files import write_bytes
from mathpost.interface.shell.main import option_actions
from mathpost.interface.shell.options import a_path
from mathpost.shop.controls import control
from mathpost.teaching.classroom.handed_in import unzip
from mathpost.teaching.course.lesson_data import data

SHIPPED = {  # files that come with the package, by the option that takes them
    "cl": "cl/*.cl",
    "machine": "machines/*.toml",
    "errors": "errors/*.toml",
    "readings": "measurements/*.csv",
    "vectors": "measurements/*head.csv",
    "path": "workbooks/*.xlsx",
    "reference": "workbooks/*.xlsx",
}
NAMED: dict[str, Callable[[], list[str]]] = {  # names to choose from, besides a file of one's own
    "CONTROL": control.names,
    "TASK": lambda: ["zxz", "sequence", "nc"],
}
UNITS = {"MM": "mm", "DEG": "°"}
UPLOADED = "at most 10 MB"  # a message of Jupyter's, which brings all files of an upload
NOT_IN_NAMES = re.compile(r'[<>:"|?*\x00-\x1f\x7f]')  # of files on some system
# An app of voila is for people who may not read the server's files: theirs are uploaded, and downloaded.
IS_APP = os.environ.get("SERVER_SOFTWARE", "").startswith("voila")
LABEL, FIELD = "120px", "340px"
STYLE = {"description_width": LABEL}


class Option:
    """A control for one option: `box` is shown, `words` are its words on a command line."""

    def __init__(self, action: argparse.Action, value: Any = None) -> None:
        self.action = action
        self.name = max(action.option_strings, key=len, default="")
        self.positional = not action.option_strings
        unit = UNITS.get(str(action.metavar), "")
        label = (self.name or action.dest).strip("-").replace("-", " ") + f", {unit}" * bool(unit)
        said = escape((action.help or "") % vars(action)) if action.help else ""
        self.field = self._made(label, action.default if value is None else value)
        self.box = widgets.HBox([self.field, widgets.HTML(f"<span class=mathpost-help>{said}</span>")])

    def _made(self, label: str, value: Any) -> widgets.Widget:
        how = {"description": label, "style": STYLE, "layout": widgets.Layout(width=FIELD, flex="0 0 auto")}
        if self.action.const is True:
            return widgets.Checkbox(value=bool(value), indent=True, **how)
        if self.action.choices is not None:
            none = [] if self.action.default else [("", None)]
            choices = [*none, *((each, each) for each in self.action.choices)]
            return widgets.Dropdown(options=choices, value=value or None, **how)
        text = " ".join(value) if isinstance(value, list | tuple) else "" if value is None else str(value)
        shape = self.action.metavar
        shape = " ".join(shape) if isinstance(shape, tuple) else (shape or "") * (shape not in UNITS)
        return widgets.Text(value=text, placeholder=shape + f"; {shape}; …" * self._is_repeated(), **how)

    def _is_repeated(self) -> bool:
        return isinstance(self.action, argparse._AppendAction)

    def words(self, folder: Path) -> list[str]:
        """Return the words; uploaded files are written into `folder`."""
        value = self.field.value
        if isinstance(value, bool) or value is None:
            return [self.name] * bool(value)
        if not (text := value.strip()):
            return []
        if self._is_repeated():
            rows = filter(None, map(str.strip, text.split(";")))
            one = self.action.nargs is None
            return [word for row in rows for word in ([f"{self.name}={row}"] if one else [self.name, *row.split()])]
        if self.action.nargs is not None:
            return [*[self.name] * bool(self.name), *text.split()]
        return [text] if self.positional else [f"{self.name}={text}"]


class FileOption(Option):
    """A control for a file, or several: uploaded, by its path, or the name of one that comes with the package.

    A value that is a dictionary, name → text, contains files that are there at the start: those drawn in a lesson.
    """

    shipped: dict[str, Path]  # that come with the package, by name

    def __init__(self, action: argparse.Action, value: Any = None) -> None:
        self.is_folder = action.metavar == "FILE_OR_FOLDER"
        drawn = value if isinstance(value, dict) else {}
        super().__init__(action, None if drawn else value)
        several = self.is_folder or action.nargs in ("*", "+")
        bound = UPLOADED + ", or a folder as one .zip" * self.is_folder + "; more by its path" * (not IS_APP)
        self.upload = widgets.FileUpload(
            description=f"Upload {self.field.description}", multiple=several, tooltip=bound,
            layout=widgets.Layout(width="180px", flex="0 0 auto"),
        )  # fmt: skip
        self.files: dict[str, bytes] = {}
        self.put({name: text.encode() for name, text in drawn.items()})
        self.upload.observe(self._came, "value")
        self.box.children = (self.field, self.upload, *self.box.children[1:])

    def _made(self, label: str, value: Any) -> widgets.Widget:
        folder, _, pattern = SHIPPED.get(self.action.dest, "").partition("/")
        self.shipped = {file.name: file for file in sorted(data(folder).glob(pattern))} if pattern else {}
        if self.action.metavar in NAMED:
            self.shipped = {name: Path(name) for name in NAMED[self.action.metavar]()}
        text = "; ".join(map(str, value)) if isinstance(value, list | tuple) else str(value or "")
        return widgets.Combobox(
            description=label, options=list(self.shipped), value=text, placeholder="path, or from the list",
            style=STYLE, layout=widgets.Layout(width=FIELD, flex="0 0 auto"),
        )  # fmt: skip

    def _came(self, _change: Any) -> None:
        self.put({_inside(each["name"]): bytes(each["content"]) for each in self.upload.value})

    def put(self, files: dict[str, bytes]) -> None:
        """Hold files; the field names them, and they count until something else is typed there."""
        self.files = dict(sorted(files.items()))
        if self.files:
            self.field.value = self._named()

    def _named(self) -> str:
        names = list(self.files)
        return names[0] if len(names) == 1 else f"{len(names)} files"

    def _is_held(self) -> bool:
        return bool(self.files) and self.field.value.strip() == self._named()

    def words(self, folder: Path) -> list[str]:
        """Return the paths, with the option's name before each that has one."""
        paths = self.paths(folder)
        if len(paths) > 1 and self.action.nargs is None:
            paths = [folder / self.action.dest]
        return [str(path) if self.positional else f"{self.name}={path}" for path in paths]

    def paths(self, folder: Path) -> list[Path]:
        """Return the paths of the files that the field names; those that were uploaded are written into `folder`.

        A zip, which stands for a folder, is unpacked there.
        """
        text = self.field.value.strip()
        if self._is_held():
            held = [_written(folder / self.action.dest / name, content) for name, content in self.files.items()]
            zips = [path for path in held if self.is_folder and path.suffix.lower() == ".zip"]
            for path in zips:
                unzip(path, path.with_suffix(""))
                path.unlink()
            return [folder / self.action.dest] if zips else held
        names = [name.strip() for name in (text.split(";") if self.action.nargs else [text]) if name.strip()]
        if IS_APP:
            listed = {*self.shipped, *(Path(each).stem for each in self.shipped)}
            for name in (each for each in names if each not in listed):
                raise InputError(self.action.dest, "a file that is uploaded, or one of the list", repr(name))
        if self.action.metavar in NAMED:
            return [self.shipped.get(name, Path(name)) for name in names]
        return [self.shipped.get(name, Path(name)) if not Path(name).exists() else Path(name) for name in names]

    def content(self) -> bytes | None:
        """Return the content of the one file that the field names, None if there is none."""
        if self._is_held():
            return next(iter(self.files.values())) if len(self.files) == 1 else None
        with suppress(InputError):  # which a run reports
            paths = self.paths(Path())
            found = self.shipped.get(f"{paths[0]}.toml", paths[0]) if len(paths) == 1 else None
            return found.read_bytes() if found is not None and found.is_file() else None
        return None


def _inside(name: str) -> str:
    """Return the name of a file as one that stays inside a folder on every system."""
    last = NOT_IN_NAMES.sub("_", re.split(r"[/\\]", name)[-1]).strip()
    return last if last.strip(".") else "file"


def _written(path: Path, content: bytes) -> Path:
    with suppress(OSError):  # which the next line reports
        path.parent.mkdir(parents=True, exist_ok=True)
    write_bytes(path, content)
    return path


def options(command: str, values: dict[str, Any]) -> dict[str, Option]:
    """Return a control for each option of a command that is an input, by the name of its value.

    `values` are the initial values of the controls; files that the shell writes are downloads of the panel.
    """
    found = {}
    for action in option_actions(command):
        if "-o" not in action.option_strings and action.metavar != "OUT" and action.dest != "json":
            is_file = action.type is a_path or action.metavar in NAMED
            kind: Callable[..., Option] = FileOption if is_file else Option
            found[action.dest] = kind(action, values.pop(action.dest, None))
    if values:
        raise InputError(f"panel {command}", f"the options {', '.join(found)}", ", ".join(values))
    return found
