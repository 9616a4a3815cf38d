"""Files: read as text or as TOML, key by key; numbers in a text; files written whole or not at all.

`data_file` finds the data that come with the package.
"""

from __future__ import annotations

import csv
import io
import math
import os
import re
import stat
import tomllib
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import Any

from mathpost.errors import InputError, OutputError

NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)"  # a decimal number as CL files, NC programs and worksheets write it
MINUS = str.maketrans(dict.fromkeys("−–‐－", "-"))  # as word processors write it
LARGEST, LARGEST_BESIDE = 2**30, 16 * 2**20  # bytes of a file, and of one that a file names
LARGEST_NUMBER = 1e9  # absolute value of a number in a TOML file

# Separators after which a spreadsheet program may begin a cell: it uses its locale's, whatever wrote the file.
_DIVIDERS = ",;|\t\r\n\v\f\x85\u2028\u2029،؛，；、"
_PASSED_OVER = r"[\s\"\x00-\x1f\x7f-\x9f\u00ad\u200b-\u200f\u2028-\u202e\u2060-\u2064\ufeff]*"
_SIGNS = "=＝﹦+＋﹢\\-－﹣−@＠﹫"  # with which a formula begins, in all their widths
_FORMULA = re.compile(
    rf"(^|[{_DIVIDERS}])(?={_PASSED_OVER}[{_SIGNS}])(?!{_PASSED_OVER}{NUMBER}(?:[eE][-+]?\d+)?[\s°)\]}}]*(?:$|[{_DIVIDERS}]))"
)


def read_bytes(path: Path | str, most: int = LARGEST) -> bytes:
    """Return the content of a file; raise `InputError` if it cannot be read or has more than `most` bytes."""
    try:
        with open(path, "rb") as file:
            is_device = stat.S_ISCHR(os.fstat(file.fileno()).st_mode)  # /dev/zero does not end; a pipe does
            content = b"" if is_device else file.read(most + 1)
    except (OSError, ValueError) as error:  # a name with a zero in it
        raise InputError(str(path), "a readable file", getattr(error, "strerror", None) or str(error)) from None
    if is_device:
        raise InputError(str(path), "a file", "a device")
    if len(content) > most:
        raise InputError(str(path), f"at most {most // 2**20} MB", "more")
    return content


def beside(path: Path | str, name: str, suffix: str, where: str) -> Path:
    """Return the path of a file that the file `path` names: one beside it, of the expected kind.

    So a stranger's file cannot make us open any other file.

    Raises
    ------
    InputError
        If the name leads elsewhere, does not end in `suffix`, or there is no such file of at most 16 MB.
    """
    folder, expected = Path(path).parent, f"the name of a {suffix} file beside this one"
    if not re.fullmatch(rf"[^/\\:\x00]+{re.escape(suffix)}", name) or name.startswith("."):
        raise InputError(where, expected, repr(name))
    found = folder / name
    if not found.is_file() or found.resolve().parent != folder.resolve():
        raise InputError(where, expected, f"no file {name!r}")
    if found.stat().st_size > LARGEST_BESIDE:
        raise InputError(where, f"{expected}, of at most {LARGEST_BESIDE // 2**20} MB", repr(name))
    return found


def data_file(path: str) -> Path:
    """Return the path of a file that comes with the package, such as ``"cl/blade.cl"``; `InputError` if none does.

    In a checkout the folder `data` is beside the package, in an installed package inside it.
    """
    for folder in (Path(__file__).parents[1] / "data", Path(__file__).parent / "data"):
        if (folder / path).exists():
            return folder / path
    raise InputError("data", "a file that comes with the package", f"no data/{path}")


def read_text(path: Path | str) -> str:
    """Return the text of the UTF-8 file `path`; raise `InputError` if it cannot be read."""
    try:
        return read_bytes(path).decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = error.object[: error.start].count(b"\n") + 1
        raise InputError(f"{path}, line {line}", "UTF-8 text", f"byte 0x{error.object[error.start]:02x}") from None


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
    if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) < LARGEST_NUMBER:
        raise ValueError
    return float(value)


def numbers(count: int) -> Callable:
    return only_if(lambda found: len(found) == count, lambda value: tuple(map(a_number, value)))


def each(kind: type) -> Callable:
    return only_if(lambda value: isinstance(value, list) and all(isinstance(entry, kind) for entry in value))


def one_of(*words: str) -> tuple[Callable, str]:
    return only_if(lambda value: value in words), " or ".join(f'"{word}"' for word in words)


some_text = only_if(lambda value: isinstance(value, str) and value.strip())


def typed_number(text: str) -> str:
    """Return a number that somebody typed as Python reads it; `ValueError` if it is none, or not finite.

    Any minus, a decimal comma and a degree sign are understood.

    Examples
    --------
    >>> typed_number("−0,50°"), text_of(float(typed_number("−0,50°")))
    ('-0.50', '-0.5')
    """
    found = text.strip().translate(MINUS).replace(",", ".").removesuffix("°")
    if not math.isfinite(float(found)):
        raise ValueError
    return found


def text_of(number: float, decimals: int = 4) -> str:
    """Return a number as text without trailing zeros, and without a minus before 0.

    Examples
    --------
    >>> text_of(54.73561), text_of(45.0), text_of(-1e-9)
    ('54.7356', '45', '0')
    """
    text = f"{number:z.{decimals}f}"
    return text.rstrip("0").rstrip(".") if "." in text else text


def write_text(path: Path | str, text: str, *, inputs: Iterable[Path | str] = ()) -> None:
    """Write `text` as UTF-8; see `write_set`. File names in it that are not valid UTF-8 are escaped."""
    write_set({Path(path): text}, inputs=inputs)


def csv_text(rows: Iterable[Sequence[object]]) -> str:
    """Return a table as CSV, with a mark that tells spreadsheet programs the encoding.

    An apostrophe is put before whatever would begin a formula, also after a separator within a text (``eve;=1+1``
    in a German Excel), so that it is shown as it is. Numbers stay numbers.

    Examples
    --------
    >>> print(csv_text([["eve;=1+1", "-2.5", "=2+3"]]).strip("\\ufeff\\r\\n"))
    eve;'=1+1,-2.5,'=2+3
    """
    text = io.StringIO()
    table = csv.writer(text)
    for row in rows:
        table.writerow(_FORMULA.sub(r"\1'", cell) if isinstance(cell, str) else cell for cell in row)
    return "\ufeff" + text.getvalue()


def write_bytes(path: Path | str, content: bytes, *, inputs: Iterable[Path | str] = ()) -> None:
    """Write `content` to the file `path`; see `write_set`."""
    write_set({Path(path): content}, inputs=inputs)


def write_set(
    contents: Mapping[Path, bytes | str], *, inputs: Iterable[Path | str] = (), folders: bool = False
) -> None:
    """Write files, path to content, all of them whole or none; raise `OutputError` if that fails.

    With `folders`, those that are missing are made.

    Each is first written to a temporary file in its folder, which takes the place of the path in one step, with the
    mode and the owner that the file had. A link is followed. Only regular files are replaced (no device, no pipe),
    and none of `inputs`.
    """
    inputs, moved = list(inputs), []
    with ExitStack() as temporary:
        try:
            for path, content in contents.items():
                path = Path(os.path.realpath(path))
                for folder in _missing(path.parent) if folders else ():
                    folder.mkdir()
                    temporary.callback(_remove_empty, folder)
                new = path.parent / f".{path.name}.{os.urandom(4).hex()}"
                temporary.callback(_remove, new)
                moved.append((new, path, _write_new(new, path, content, inputs)))
            for number, (new, path, _) in enumerate(moved):
                try:
                    os.replace(new, path)
                except BaseException:  # a signal, too
                    _put_back(moved[:number])
                    raise
        except (OSError, ValueError) as error:
            if isinstance(error, OutputError):
                raise
            raise OutputError(f"{path}: not written, {getattr(error, 'strerror', None) or error}") from None


def _write_new(new: Path, path: Path, content: bytes | str, inputs: Collection[Path | str]) -> bytes | None:
    """Write the temporary file `new`, which is to replace `path`; return what is there now, None if nothing is."""
    old = path.stat() if path.exists() else None
    if old:
        _may_be_replaced(path, inputs)
    with open(new, "xb") as file:
        if old and hasattr(os, "chown"):
            os.chown(new, old.st_uid, old.st_gid)
        if old:
            os.chmod(new, old.st_mode & 0o7777)
        file.write(content.encode("utf-8", "backslashreplace") if isinstance(content, str) else content)
    return path.read_bytes() if old else None


def _put_back(moved: Iterable[tuple[Path, Path, bytes | None]]) -> None:
    for _, path, before in moved:
        if before is None:
            _remove(path)
        else:
            path.write_bytes(before)


def _remove(path: Path) -> None:
    with suppress(OSError):  # already moved into place, or never made
        path.unlink()


def _missing(folder: Path) -> list[Path]:
    """The folders that are not there, from the outermost to `folder`."""
    return [each for each in (*reversed(folder.parents), folder) if not each.exists()]


def _remove_empty(folder: Path) -> None:
    with suppress(OSError):  # it holds the files
        folder.rmdir()


def _may_be_replaced(path: Path, inputs: Collection[Path | str]) -> None:
    if not path.is_file():
        raise OutputError(f"{path}: not written, it is no regular file")
    if any(os.path.exists(each) and path.samefile(each) for each in inputs):
        raise OutputError(f"{path}: not written, it is one of the files that are read")
    if not os.access(path, os.W_OK):
        raise OutputError(f"{path}: not written, Permission denied")
