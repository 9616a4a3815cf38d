"""Files from a browser: a zone to drop them on, which has buttons, too. `drop.js` is its other half.

Python first says which of the offered files it takes. Then the files come in pieces, one by one, and each is
answered with the bytes received: a lost piece is sent again, and one that comes twice is ignored.
"""

import re
from collections.abc import Sequence
from pathlib import Path, PurePosixPath
from typing import Any

import anywidget
from traitlets import Bool, Int, List, Unicode

from mathpost.errors import InputError

MEGABYTE = 2**20
LARGEST, TOGETHER = 100 * MEGABYTE, 200 * MEGABYTE  # of a file, and of all files in one zone
MOST = 500  # files
BOUND = f"at most {LARGEST // MEGABYTE} MB a file, {TOGETHER // MEGABYTE} MB and {MOST} files together"
NOT_IN_NAMES = re.compile(r'[<>:"|?*\x00-\x1f\x7f]')  # of files on some system
HIDDEN = (".", "~$", "__MACOSX")  # files that systems and spreadsheet programs leave in a folder


class Drop(anywidget.AnyWidget):
    """A zone that takes files: one, which replaces the last, or several.

    Parameters
    ----------
    label : str
        What they are, for screen readers.
    several : bool
        Whether it takes more than one, and folders.
    """

    _esm = Path(__file__).with_name("drop.js")
    label, bound = Unicode().tag(sync=True), Unicode(BOUND).tag(sync=True)
    several, most = Bool().tag(sync=True), Int(MOST).tag(sync=True)
    held: List = List().tag(sync=True)  # names and sizes of the files received
    changes = Int()  # how often they have changed, for observers

    def __init__(self, label: str, several: bool) -> None:
        super().__init__(label=label, several=several)
        self.files: dict[str, bytes] = {}
        self.coming: dict[str, tuple[int, bytearray]] = {}  # size, and the bytes received
        self.on_msg(self._heard)

    def put(self, files: dict[str, bytes]) -> None:
        """Replace the files by these."""
        self.files, self.coming = dict(files), {}
        self._show()

    def offer(self, files: Sequence[tuple[str, int]]) -> list[str]:
        """Return the name here of each of the files offered, "" if it is ignored; earlier offers lapse.

        Raises
        ------
        InputError
            If they are too many or too large; then none is taken.
        """
        if len(files) > 1 and not self.several:
            raise InputError(self.label, "one file", f"{len(files)}")
        if len(files) > MOST:
            raise InputError(self.label, BOUND, f"more than {MOST} files")
        self.coming = {}
        taken: list[str] = []
        sizes = {name: len(content) for name, content in self.files.items() if self.several}
        for sent, size in files:
            name = _distinct(_inside(sent), taken)
            if size > LARGEST:
                raise InputError(name, BOUND, f"{size / MEGABYTE:.1f} MB")
            is_hidden = len(files) > 1 and any(part.startswith(HIDDEN) for part in name.split("/"))
            taken.append("" if is_hidden else name)
            sizes |= {} if is_hidden else {name: size}
        if len(sizes) > MOST or sum(sizes.values()) > TOGETHER:
            raise InputError(self.label, BOUND, f"{len(sizes)} files, {sum(sizes.values()) / MEGABYTE:.1f} MB")
        self.coming = {name: (sizes[name], bytearray()) for name in taken if name}
        return taken

    def piece(self, name: str, start: int, content: bytes) -> int:
        """Take a piece of a file that was offered, and return how many of its bytes have been received."""
        if name not in self.coming:
            if name in self.files:  # the last piece, once more
                return len(self.files[name])
            raise InputError(name, "a file that was offered", "a different one")
        size, arrived = self.coming[name]
        if start == len(arrived):
            arrived += content
        if len(arrived) > size:
            raise InputError(name, f"{size} bytes", "more: it has changed")
        if len(arrived) == size:
            if not self.several:
                self.files = {}
            self.files[name] = bytes(self.coming.pop(name)[1])
            self._show()
        return len(arrived)

    def remove(self, names: Sequence[str]) -> None:
        """Forget files."""
        for name in names:
            self.files.pop(name, None)
            self.coming.pop(name, None)
        self._show()

    def whole(self) -> dict[str, bytes]:
        """Return the content of the files by their names; `InputError` if some are still on their way."""
        if self.coming:
            name, (size, arrived) = next(iter(self.coming.items()))
            found = f"{len(arrived) / MEGABYTE:.1f} of {size / MEGABYTE:.1f} MB"
            raise InputError(name, "a file that has arrived (wait, or drop it again)", found)
        return self.files

    def _show(self) -> None:
        self.files = dict(sorted(self.files.items()))
        self.held = [[name, len(content)] for name, content in self.files.items()]
        self.changes += 1

    def _heard(self, _widget: Any, content: dict, buffers: list) -> None:
        """Answer a message of the browser, with its number."""
        answer: dict[str, Any] = {"id": content["id"]}
        try:
            if "offer" in content:
                answer["names"] = self.offer(content["offer"])
            elif "remove" in content:
                self.remove(content["remove"])
            else:
                answer["have"] = self.piece(content["name"], content["start"], bytes(buffers[0]))
        except InputError as error:
            answer["refused"] = str(error)
        self.send(answer)


def _inside(name: str) -> str:
    """Return the name of a file, with its folders, as one that stays inside a folder on every system."""
    parts = (NOT_IN_NAMES.sub("_", part).strip() for part in re.split(r"[/\\]", name))
    return "/".join(part for part in parts if part.strip(".")) or "file"


def _distinct(name: str, taken: Sequence[str]) -> str:
    """Return a name that is not taken, so that of two files of one name none is lost."""
    path, number = PurePosixPath(name), 1
    while name in taken:
        number += 1
        name = str(path.with_name(f"{path.stem} ({number}){path.suffix}"))
    return name
