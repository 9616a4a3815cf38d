"""Files read and written, whole or not at all, and the data that come with the package."""

import csv
import io
import os
import re
from collections.abc import Iterable, Sequence
from contextlib import suppress
from pathlib import Path
from secrets import token_hex

from mathpost.errors import NUMBER, InputError, OutputError

written: list[Path] = []  # by this process

# Separators after which a spreadsheet program may begin a cell: it uses its locale's, whatever wrote the file.
_DIVIDERS = ",;|\t\r\n\v\f\x85\u2028\u2029،؛，；、"
_PASSED_OVER = r"[\s\"\x00-\x1f\x7f-\x9f\u00ad\u200b-\u200f\u2028-\u202e\u2060-\u2064\ufeff]*"
_SIGNS = "=＝﹦+＋﹢\\-－﹣−@＠﹫"  # with which a formula begins, in all their widths
_FORMULA = re.compile(
    rf"(^|[{_DIVIDERS}])(?={_PASSED_OVER}[{_SIGNS}])(?!{_PASSED_OVER}{NUMBER}(?:[eE][-+]?\d+)?[\s°)\]}}]*(?:$|[{_DIVIDERS}]))"
)


def read_bytes(path: Path | str) -> bytes:
    """Return the content of the file `path`; raise `InputError` if it cannot be read."""
    try:
        return Path(path).read_bytes()
    except OSError as error:
        raise InputError(str(path), "a readable file", error.strerror or str(error)) from None


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
    """Write `text` as UTF-8; see `write_bytes`."""
    write_bytes(path, text.encode("utf-8"), inputs=inputs)


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
    """Write `content` to `path` whole or not at all; raise `OutputError` if that fails.

    A temporary file in the same folder takes the place of `path` in one step, with the mode and the owner that the
    file had. A link is followed. Only regular files are replaced (no device, no pipe), and none of `inputs`.
    """
    path = Path(os.path.realpath(path))
    temporary = path.parent / f".{path.name}.{token_hex(4)}"
    try:
        if old := path.stat() if path.exists() else None:
            _may_be_replaced(path, inputs)
        with open(temporary, "xb") as file:
            if old and hasattr(os, "chown"):
                os.chown(temporary, old.st_uid, old.st_gid)
            if old:
                os.chmod(temporary, old.st_mode & 0o7777)
            file.write(content)
        os.replace(temporary, path)
        written.append(path)
    except OSError as error:
        raise OutputError(f"{path}: not written, {error.strerror or error}") from None
    finally:
        with suppress(OSError):  # already moved into place, or never made
            temporary.unlink()


def _may_be_replaced(path: Path, inputs: Iterable[Path | str]) -> None:
    if not path.is_file():
        raise OutputError(f"{path}: not written, it is no regular file")
    if any(os.path.exists(each) and path.samefile(each) for each in inputs):
        raise OutputError(f"{path}: not written, it is one of the files that are read")
    if not os.access(path, os.W_OK):
        raise OutputError(f"{path}: not written, Permission denied")
