"""Earlier verdicts, so that only new files are judged: a file beside the report, for the teacher alone.

A record is found by the content of its file and by the edition of everything that judges: if one byte of either
changes, the file is judged again. It is read as plain data; a damaged one is ignored.
"""

import hashlib
import json
import os
import sqlite3
import stat
import sys
from dataclasses import asdict
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

from mathpost.errors import InputError, OutputError
from mathpost.files import data_file
from mathpost.teaching.classroom.judged import Cell, Notebook, Workbook
from mathpost.teaching.course.verdict import Verdict

BESIDE = ("numpy", "scipy", "sympy", "openpyxl")  # other packages that a verdict depends on
TABLE = "CREATE TABLE IF NOT EXISTS kept (key TEXT PRIMARY KEY, edition TEXT, record TEXT)"
EXPECTED = "records of your own that nobody else may write; delete it to judge everything anew"


class Kept:
    """Records in a file; without a path, in memory.

    Raises `InputError` if the file is a link, somebody else's, one that others may write, or no such record, and
    `OutputError` if it cannot be made.
    """

    def __init__(self, path: Path | str | None = None) -> None:
        self.path = Path(path) if path else None
        if self.path:
            _make_or_check(self.path)
        try:
            self._database = sqlite3.connect(self.path or ":memory:")
            self._database.execute("PRAGMA synchronous = OFF")  # a lost record is judged again
            self._database.execute(TABLE)
            self._database.execute("DELETE FROM kept WHERE edition != ?", (edition(),))
            self._database.commit()
        except sqlite3.Error as error:
            raise InputError(str(self.path), EXPECTED, str(error)) from None

    def commit(self) -> None:
        """Save the verdicts so far, whatever happens next."""
        self._database.commit()

    def get(self, kind: str, content: str) -> Any:
        """Return the record of a kind ("notebook", "workbook") by the digest of the content, or None."""
        row = self._database.execute("SELECT record FROM kept WHERE key = ?", (f"{kind} {content}",)).fetchone()
        try:
            return row and _READ[kind](json.loads(row[0]))
        except (ValueError, TypeError, KeyError, AttributeError):
            return None

    def put(self, kind: str, content: str, record: Notebook | Workbook) -> None:
        """Keep a record."""
        row = (f"{kind} {content}", edition(), json.dumps(asdict(record)))
        self._database.execute("INSERT OR REPLACE INTO kept VALUES (?, ?, ?)", row)


def _make_or_check(path: Path) -> None:
    try:
        os.close(os.open(path, os.O_RDWR | os.O_CREAT | getattr(os, "O_NOFOLLOW", 0), 0o600))
    except OSError as error:
        if path.is_symlink():
            raise InputError(str(path), EXPECTED, "a link") from None
        raise OutputError(f"{path}: not written, {error.strerror or error}") from None
    found = path.stat()
    if hasattr(os, "getuid") and (found.st_uid != os.getuid() or found.st_mode & (stat.S_IWGRP | stat.S_IWOTH)):
        said = f"account {found.st_uid}, mode {stat.S_IMODE(found.st_mode):o}"
        raise InputError(str(path), EXPECTED, said)


@cache
def edition() -> str:
    """A digest of everything that judges: this package with its data, and the packages it calculates with."""
    said = hashlib.sha256(" ".join([sys.version, *map(version, BESIDE)]).encode())
    for folder in (Path(__file__).parents[2], data_file("machines").parent):
        for path in sorted(folder.rglob("*")):
            if path.is_file() and "__pycache__" not in path.parts:
                said.update(f"{path.relative_to(folder)} ".encode() + path.read_bytes())
    return said.hexdigest()


def _notebook(data: dict[str, Any]) -> Notebook:
    verdicts = tuple(Verdict(**each) for each in data["verdicts"])
    cells = tuple(Cell(each["source"], each["length"], tuple(each["asks"])) for each in data["cells"])
    return Notebook(tuple((name, digest) for name, digest in data["given"]), verdicts, data["answers"], cells)


_READ = {"notebook": _notebook, "workbook": lambda data: Workbook(**data)}
