"""Files read and written, whole or not at all, and the data that come with the package."""

import csv
import io
import os
import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from contextlib import ExitStack, suppress
from pathlib import Path

from mathpost.errors import NUMBER, InputError, OutputError

LARGEST, LARGEST_BESIDE = 2**30, 16 * 2**20  # bytes of a file, and of one that a file names

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
            content = file.read(most + 1)
    except (OSError, ValueError) as error:  # a name with a zero in it
        raise InputError(str(path), "a readable file", getattr(error, "strerror", None) or str(error)) from None
    if len(content) > most:
        raise InputError(str(path), f"at most {most // 2**20} MB", "more")
    return content


def beside(path: Path | str, name: str, suffix: str, where: str) -> Path:
    """Return the path of a file that the file `path` names: one beside it, of the expected kind.

    Whoever opens a stranger's file opens nothing else of theirs by it.

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


def write_text(path: Path | str, text: str, *, inputs: Iterable[Path | str] = ()) -> None:
    """Write `text` as UTF-8; see `write_set`. Names of files that are no UTF-8 are escaped in it."""
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
                if folders:
                    path.parent.mkdir(parents=True, exist_ok=True)
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


def _may_be_replaced(path: Path, inputs: Collection[Path | str]) -> None:
    if not path.is_file():
        raise OutputError(f"{path}: not written, it is no regular file")
    if any(os.path.exists(each) and path.samefile(each) for each in inputs):
        raise OutputError(f"{path}: not written, it is one of the files that are read")
    if not os.access(path, os.W_OK):
        raise OutputError(f"{path}: not written, Permission denied")
